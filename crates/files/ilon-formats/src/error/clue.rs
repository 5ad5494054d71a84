//! Evidence in a file for the radius of a wheel whose geometry does not show it.
//!
//! No evidence is trusted alone: frames may not lie on the floor, inertias may be invented, names
//! and settings may belong to another wheel. A radius is proposed if two clues of different kinds
//! agree and nothing contradicts; otherwise the user is asked, with all clues.

/// Two clues agree if their radii differ by less than this share.
const ALIKE: f64 = 0.02;
/// A bound may be violated by this share.
const SLACK: f64 = 0.05;

/// The source of a clue: clues of one kind are not independent, and do not confirm each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum ClueKind {
    /// A property, an argument, a parameter or a plug-in's setting named as the wheel's radius or
    /// diameter.
    Said,
    /// The readable shapes of the wheel.
    Shape,
    /// A size in the name of a joint, link, mesh or macro.
    Name,
    /// The height of the axis above a frame that may lie on the floor.
    Height,
    /// The inertia about the axis, interpreted as a solid disc's.
    Inertia,
}

/// Evidence for the radius of a wheel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Clue {
    /// Its source.
    pub kind: ClueKind,
    /// Its description, such as ``the height of its axis above the frame `base_footprint` ``.
    pub what: String,
    /// The possible radii, in metres: one, or both if a size may be a radius or a diameter.
    pub radii_m: Vec<f64>,
}

impl Clue {
    /// A clue for one radius.
    pub(crate) fn new(kind: ClueKind, what: String, radius_m: f64) -> Self {
        let radii_m = vec![radius_m];
        Self {
            kind,
            what,
            radii_m,
        }
    }

    fn speaks_for(&self, radius_m: f64) -> bool {
        self.radii_m.iter().any(|other| are_alike(*other, radius_m))
    }
}

fn are_alike(p_m: f64, q_m: f64) -> bool {
    (p_m - q_m).abs() <= ALIKE * p_m.max(q_m)
}

impl std::fmt::Display for Clue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let radii: Vec<String> = self.radii_m.iter().map(|m| millimetres(*m)).collect();
        write!(f, "{} ({} mm)", self.what, radii.join(" or "))
    }
}

/// Returns a length in millimetres, to a tenth.
fn millimetres(metres: f64) -> String {
    format!("{}", (1e4 * metres).round() / 10.0)
}

/// All clues to the radius of a wheel, with bounds.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Clues {
    /// The evidence.
    pub clues: Vec<Clue>,
    /// Lower bounds of the radius, in metres, with descriptions.
    pub least_m: Vec<(f64, String)>,
    /// Upper bounds, in metres, with descriptions.
    pub most_m: Vec<(f64, String)>,
}

impl Clues {
    /// Returns the radius on which clues of two kinds agree, in metres, to a tenth of a millimetre;
    /// `None` if there is none, if two radii have equal evidence, and if something contradicts.
    pub fn proposed_m(&self) -> Option<f64> {
        let mut agreed: Vec<(ClueKind, f64)> = Vec::new();
        for clue in &self.clues {
            let supported = clue.radii_m.iter().filter(|m| self.is_supported(**m));
            agreed.extend(supported.map(|m| (clue.kind, *m)));
        }
        // The most direct kind gives the digits; if it has several values, the one closest to the
        // others.
        agreed.sort_by_key(|one| one.0);
        let direct = agreed.first()?.0;
        let apart_m = |m: f64| -> f64 {
            let others = agreed.iter().filter(|(kind, _)| *kind != direct);
            others.map(|(_, other)| (other - m).abs()).sum()
        };
        let said = agreed.iter().filter(|(kind, _)| *kind == direct);
        let radius_m = said
            .map(|(_, m)| *m)
            .min_by(|p, q| apart_m(*p).total_cmp(&apart_m(*q)))?;
        agreed
            .iter()
            .all(|(_, other)| are_alike(*other, radius_m))
            .then(|| (1e4 * radius_m).round() / 1e4)
    }

    /// Returns a stand-in radius for reading the rest of the file, in metres: one without
    /// contradiction, if possible.
    pub(crate) fn stand_in_m(&self) -> f64 {
        /// For a wheel without clues.
        const ANY_M: f64 = 0.05;
        let radii = self.clues.iter().flat_map(|clue| clue.radii_m.clone());
        let bounds = self.least_m.iter().chain(&self.most_m).map(|(m, _)| *m);
        let mut all = radii.chain(bounds);
        all.find(|m| self.contradictions(*m).is_empty())
            .unwrap_or(ANY_M)
    }

    fn is_supported(&self, radius_m: f64) -> bool {
        let speaking = |kind: ClueKind| {
            let mut of_kind = self.clues.iter().filter(move |clue| clue.kind == kind);
            of_kind.any(|clue| clue.speaks_for(radius_m))
        };
        let has = |kind| self.clues.iter().any(|clue| clue.kind == kind);
        let kinds = [
            ClueKind::Said,
            ClueKind::Shape,
            ClueKind::Name,
            ClueKind::Height,
            ClueKind::Inertia,
        ];
        let count = kinds.into_iter().filter(|kind| speaking(*kind)).count();
        // An explicit statement is not outvoted, nor is a drawing, which may be a hub if a size is
        // stated or named.
        let said = speaking(ClueKind::Said);
        let drawn_otherwise =
            has(ClueKind::Shape) && !speaking(ClueKind::Shape) && !speaking(ClueKind::Name);
        let denied = !said && (has(ClueKind::Said) || drawn_otherwise);
        count >= 2 && !denied && self.contradictions(radius_m).is_empty()
    }

    /// Returns the bounds that a radius violates, as text.
    fn contradictions(&self, radius_m: f64) -> Vec<String> {
        let below = self
            .least_m
            .iter()
            .filter(|(m, _)| radius_m < m * (1.0 - SLACK));
        let above = self
            .most_m
            .iter()
            .filter(|(m, _)| radius_m > m * (1.0 + SLACK));
        let below = below.map(|(m, what)| format!("{what} ({} mm or more)", millimetres(*m)));
        let above = above.map(|(m, what)| format!("{what} ({} mm or less)", millimetres(*m)));
        below.chain(above).collect()
    }

    /// Returns the evidence for and against a radius, as text.
    pub(crate) fn on(&self, radius_m: f64) -> String {
        let (pro, contra): (Vec<&Clue>, Vec<&Clue>) = self
            .clues
            .iter()
            .partition(|clue| clue.speaks_for(radius_m));
        let mut against: Vec<String> = contra.iter().map(ToString::to_string).collect();
        against.extend(self.contradictions(radius_m));
        let mut words = match &listed(&pro)[..] {
            "" => "nothing in the file speaks for it".to_owned(),
            listed => format!("for it speak {listed}"),
        };
        if !against.is_empty() {
            words.push_str(&format!("; against it {}", against.join(", ")));
        }
        words
    }

    /// Returns the information for a user who is asked for the radius, as text.
    pub(crate) fn help(&self) -> String {
        if let Some(radius_m) = self.proposed_m() {
            let speaking = self.clues.iter().filter(|clue| clue.speaks_for(radius_m));
            return format!(
                "say the wheels' radius; {} mm is what two or more clues agree on: {}",
                millimetres(radius_m),
                listed(&speaking.collect::<Vec<_>>())
            );
        }
        let mut all: Vec<String> = self.clues.iter().map(ToString::to_string).collect();
        let bounds = |bounds: &[(f64, String)], than: &str| -> Vec<String> {
            let words =
                |(m, what): &(f64, String)| format!("{what} ({} mm or {than})", millimetres(*m));
            bounds.iter().map(words).collect()
        };
        // A bound that is also a clue is named once.
        let is_named = |words: &String| self.clues.iter().any(|clue| words.starts_with(&clue.what));
        let of_bounds = [bounds(&self.least_m, "more"), bounds(&self.most_m, "less")].concat();
        all.extend(of_bounds.into_iter().filter(|words| !is_named(words)));
        match &all[..] {
            [] => "say the wheels' radius; nothing in the file speaks for one".to_owned(),
            _ => format!(
                "say the wheels' radius; no two kinds of clues agree on one: {}",
                all.join(", ")
            ),
        }
    }
}

fn listed(clues: &[&Clue]) -> String {
    let words: Vec<String> = clues.iter().map(ToString::to_string).collect();
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clues(clues: &[(ClueKind, &[f64])]) -> Clues {
        let clue = |(kind, radii_m): &(ClueKind, &[f64])| Clue {
            kind: *kind,
            what: format!("{kind:?}"),
            radii_m: radii_m.to_vec(),
        };
        Clues {
            clues: clues.iter().map(clue).collect(),
            ..Clues::default()
        }
    }

    #[test]
    fn a_radius_is_proposed_where_two_kinds_of_clues_agree_and_nothing_contradicts() {
        use ClueKind::{Height, Inertia, Name, Said, Shape};
        for (given, proposed) in [
            (clues(&[]), None),
            (clues(&[(Height, &[0.05])]), None),
            (clues(&[(Height, &[0.05]), (Height, &[0.05])]), None),
            (
                clues(&[(Height, &[0.05]), (Inertia, &[0.0504])]),
                Some(0.05),
            ),
            (clues(&[(Height, &[0.05]), (Inertia, &[0.06])]), None),
            // The digits are those of the most direct clue.
            (
                clues(&[(Height, &[0.0505]), (Said, &[0.0508])]),
                Some(0.0508),
            ),
            // Visual and collision shapes, of which the inertia confirms the second.
            (
                clues(&[(Shape, &[0.127]), (Shape, &[0.125]), (Inertia, &[0.125])]),
                Some(0.125),
            ),
            // A size that may be a diameter.
            (
                clues(&[(Name, &[0.1, 0.05]), (Height, &[0.05])]),
                Some(0.05),
            ),
            (
                clues(&[(Name, &[0.1, 0.05]), (Height, &[0.05]), (Inertia, &[0.1])]),
                None,
            ),
            // Two guesses do not outvote a statement or a drawing.
            (
                clues(&[(Said, &[0.0762]), (Height, &[0.097]), (Inertia, &[0.0965])]),
                None,
            ),
            (
                clues(&[(Shape, &[0.0235]), (Height, &[0.05]), (Inertia, &[0.05])]),
                None,
            ),
            // The drawing may be a mount, next to a wheel whose mesh is named after its size and
            // cannot be read.
            (
                clues(&[(Shape, &[0.028]), (Name, &[0.0508]), (Inertia, &[0.0509])]),
                Some(0.0508),
            ),
        ] {
            assert_eq!(given.proposed_m(), proposed, "{given:?}");
        }
        let mut bounded = clues(&[(Height, &[0.0179]), (Inertia, &[0.0179])]);
        bounded.least_m.push((0.04, "its mount".to_owned()));
        assert_eq!(bounded.proposed_m(), None);
        assert!(bounded.help().contains("its mount (40 mm or more)"));
        assert!(bounded.on(0.0179).contains("against it its mount"));
    }
}
