//! Parses the drift of a real robot from the command line.

use std::str::FromStr;

use ilon_sim::causes::Drift;
use ilon_sim::standard_motions::MOTIONS;

/// The drift in one of the standard motions. Unobserved components are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Its index among the motions.
    pub motion: usize,
    /// The driven distance in metres, or the number of turns.
    pub length: f64,
    /// In m/m or m/turn.
    pub ahead_m: Option<f64>,
    pub left_m: Option<f64>,
    /// In rad/m or rad/turn.
    pub turned_rad: Option<f64>,
}

/// How well a suspect explains an observed drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    /// The explained share of the observed drift, up to 1.
    pub share: f64,
    /// Its amount over the usual amount; negative for the opposite sign.
    pub times: f64,
}

/// How well a suspect's drifts explain the observed ones, with the best amount within `times`, the
/// smallest and the largest, assuming drifts proportional to it. Angles count at an arm, in metres.
/// `None` if no such amount explains any of it.
pub(super) fn fit(
    seen: &[Seen],
    drifts: &[Option<Drift>],
    times: (f64, f64),
    arm_m: f64,
) -> Option<Fit> {
    let mut pairs: Vec<(f64, f64)> = Vec::new();
    for one in seen {
        let drift = drifts
            .get(one.motion)
            .copied()
            .flatten()
            .unwrap_or_default();
        let told = |x: f64, floor: f64| if x.abs() > floor { x } else { 0.0 };
        let parts = [
            (one.ahead_m, told(drift.ahead_m, drift.floor[0])),
            (one.left_m, told(drift.left_m, drift.floor[0])),
            (
                one.turned_rad.map(|turned| arm_m * turned),
                arm_m * told(drift.turned_rad, drift.floor[1]),
            ),
        ];
        pairs.extend(
            parts
                .iter()
                .filter_map(|(seen, drift)| Some(((*seen)?, *drift))),
        );
    }
    let sum = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>();
    let (seen2, drift2) = (sum(|(s, _)| s * s), sum(|(_, d)| d * d));
    let best = sum(|(s, d)| s * d) / drift2;
    if !(best.is_finite() && seen2 > 0.0) {
        return None;
    }
    let times = best.clamp(times.0, times.1);
    let rest = pairs
        .iter()
        .map(|(s, d)| (s - times * d).powi(2))
        .sum::<f64>();
    let share = 1.0 - (rest / seen2).sqrt();
    (times != 0.0 && share > 0.0).then_some(Fit { share, times })
}

impl FromStr for Seen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (motion, parts) = text.split_once(':').unwrap_or(("ahead", text));
        let motion = motion.trim();
        let place = MOTIONS.iter().position(|known| *known == motion);
        let motion = place.ok_or_else(|| {
            format!(
                "there is no motion `{motion}`: the motions are {}",
                MOTIONS.join(", ")
            )
        })?;
        let (parts, over) = match parts.rsplit_once(" over ") {
            Some((parts, over)) => (parts, Some(length(over, motion)?)),
            None => (parts, None),
        };
        let mut seen = Self {
            motion,
            length: over.unwrap_or(1.0),
            ahead_m: None,
            left_m: None,
            turned_rad: None,
        };
        for part in parts.split(',') {
            seen.take(part.trim(), over)?;
        }
        Ok(seen)
    }
}

/// Whether a motion is a turn on the spot.
fn is_turn(motion: usize) -> bool {
    MOTIONS[motion] == "turn"
}

/// The unit length of a drift in a motion.
pub(super) fn each(motion: usize) -> &'static str {
    if is_turn(motion) { "turn" } else { "m" }
}

/// The length of a drive, such as `3 m` or `2 turns`.
fn length(text: &str, motion: usize) -> Result<f64, String> {
    let each = each(motion);
    let words = apart(text);
    let words: Vec<&str> = words.split_whitespace().collect();
    match words.as_slice() {
        [number, unit] if unit.trim_end_matches('s') == each => number.parse().ok(),
        _ => None,
    }
    .filter(|length| (0.1..=20.0).contains(length))
    .ok_or_else(|| {
        format!(
            "`over {text}` is no length of this drive: it stands last, and is 0.1 to 20 {each}{}, such as \"over 3 {each}{}\"",
            if is_turn(motion) { "s" } else { "" },
            if is_turn(motion) { "s" } else { "" },
        )
    })
}

/// A text with a space between each number and its unit.
fn apart(text: &str) -> String {
    let mut spaced = String::new();
    let mut chars = text.chars().peekable();
    let mut before = ' ';
    while let Some(c) = chars.next() {
        let is_exponent = matches!(c, 'e' | 'E')
            && chars
                .peek()
                .is_some_and(|next| next.is_ascii_digit() || "+-".contains(*next));
        if before.is_ascii_digit() && (c.is_alphabetic() || "°%".contains(c)) && !is_exponent {
            spaced.push(' ');
        }
        spaced.push(c);
        before = c;
    }
    spaced
}

impl Seen {
    /// The observed drift less that of the robot without faults: 0 if the rest is below what a tape
    /// measure and a protractor resolve over a metre.
    pub fn beyond(self, healthy: &Drift) -> Self {
        const TAPE: [f64; 2] = [0.5e-3, 0.5e-3];
        let [floor_m, floor_rad] = std::array::from_fn(|of| healthy.floor[of].max(TAPE[of]));
        let less = |seen: Option<f64>, anyway: f64, floor: f64| {
            let rest = seen.map(|seen| seen - anyway);
            rest.map(|rest| if rest.abs() > floor { rest } else { 0.0 })
        };
        Self {
            ahead_m: less(self.ahead_m, healthy.ahead_m, floor_m),
            left_m: less(self.left_m, healthy.left_m, floor_m),
            turned_rad: less(self.turned_rad, healthy.turned_rad, floor_rad),
            ..self
        }
    }

    /// Whether nothing of it is left.
    pub fn is_nothing(&self) -> bool {
        let parts = [self.ahead_m, self.left_m, self.turned_rad];
        parts.into_iter().flatten().all(|part| part == 0.0)
    }

    /// Parses one part, such as `left 20 mm/m`; with a given length of the drive also `left 60 mm`.
    fn take(&mut self, part: &str, over: Option<f64>) -> Result<(), String> {
        let each = each(self.motion);
        let help = || {
            format!(
                "`{part}` is no drift of the motion `{}`: write a direction (ahead, back, left, right, short, turn), a number and a unit (mm/{each}, \
                 deg/{each}), such as \"left 20 mm/{each}\" or \"turn -1 deg/{each}\"; or what a longer drive came to, such as \"left 60 mm over 3 {each}{}\"",
                MOTIONS[self.motion],
                if is_turn(self.motion) { "s" } else { "" },
            )
        };
        let spaced = apart(part);
        let words: Vec<&str> = spaced.split_whitespace().collect();
        let (direction, number, unit) = match words.as_slice() {
            [direction, number, unit] => (*direction, *number, *unit),
            // "turn left 1 deg/m"
            ["turn", "left", number, unit] => ("turn", *number, *unit),
            ["turn", "right", number, unit] => ("turn right", *number, *unit),
            _ => return Err(help()),
        };
        let number: f64 = number.parse().map_err(|_| help())?;
        if !number.is_finite() {
            return Err(help());
        }
        let (unit, counted) = match unit.split_once('/') {
            Some((unit, counted)) => (unit, Some(counted)),
            None => (unit, None),
        };
        let (per_si, is_angle) = match unit {
            "mm" => (1e-3, false),
            "cm" => (1e-2, false),
            "m" => (1.0, false),
            "%" if counted.is_none() && each == "m" => (1e-2, false),
            "deg" | "°" => (1f64.to_radians(), true),
            "rad" => (1.0, true),
            _ => return Err(help()),
        };
        let divided_by = match counted {
            None if unit == "%" => 1.0,
            None => over.ok_or_else(help)?,
            Some(counted) if counted == each => 1.0,
            Some(_) => return Err(help()),
        };
        let value = per_si * number / divided_by;
        let (place, value) = match (direction, is_angle) {
            ("ahead", false) => (&mut self.ahead_m, value),
            ("back", false) => (&mut self.ahead_m, -value),
            ("left", false) => (&mut self.left_m, value),
            ("right", false) => (&mut self.left_m, -value),
            ("short", false) if MOTIONS[self.motion] == "ahead" => (&mut self.ahead_m, -value),
            ("short", false) if MOTIONS[self.motion] == "left" => (&mut self.left_m, -value),
            ("turn", true) => (&mut self.turned_rad, value),
            ("turn right", true) => (&mut self.turned_rad, -value),
            _ => return Err(help()),
        };
        match place.replace(value) {
            None => Ok(()),
            Some(_) => Err(format!("`{part}` is of a direction that was given before")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_seen_is_read_in_its_units() {
        let seen: Seen = "left 20 mm/m, turn right 1 deg/m".parse().expect("a drift");
        assert_eq!(
            (seen.motion, seen.ahead_m, seen.left_m),
            (0, None, Some(0.02))
        );
        assert_eq!(seen.turned_rad, Some(-1f64.to_radians()));
        let seen: Seen = "turn: back 0.5 cm/turn".parse().expect("a drift");
        assert_eq!((seen.motion, seen.ahead_m), (4, Some(-0.005)));
        let seen: Seen = "left 60mm, turn 3deg over 3m".parse().expect("a drift");
        assert_eq!((seen.length, seen.left_m), (3.0, Some(0.02)));
        assert_eq!(seen.turned_rad, Some(1f64.to_radians()));
        let seen: Seen = "left: short 7 %".parse().expect("a drift");
        assert_eq!((seen.motion, seen.left_m), (1, Some(-0.07)));
        for wrong in [
            "",
            "left",
            "left x mm/m",
            "left 3 deg/m",
            "turn 3 mm/m",
            "sideways: left 1 mm/m",
            "up 1 mm/m",
            "left NaN mm/m",
            "left 20 mm/m, right 30 mm/m",
            // Wrong unit for this motion, or without a unit.
            "turn 4 deg/turn",
            "turn: turn 3 deg/m",
            "turn: left 3 %",
            "left 35 mm",
            "left 35 mm over 0 m",
            "left 35 mm over 3 turns",
            "turn: short 3 mm/turn",
        ] {
            assert!(wrong.parse::<Seen>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_suspect_explains_what_it_is_parallel_to() {
        let seen: Seen = "left 20 mm/m, turn 1 deg/m".parse().expect("a drift");
        let drift = |left_m: f64, turned_rad: f64| {
            let mut drift = Drift::default();
            (drift.left_m, drift.turned_rad) = (left_m, turned_rad);
            [Some(drift)]
        };
        let any = (0.0, f64::INFINITY);
        let half = fit(&[seen], &drift(0.01, 0.5f64.to_radians()), any, 0.3).expect("it fits");
        assert!((half.share - 1.0).abs() < 1e-12 && (half.times - 2.0).abs() < 1e-12);
        assert_eq!(fit(&[seen], &drift(-0.01, 0.0), any, 0.3), None);
        assert_eq!(fit(&[seen], &drift(0.0, 0.0), any, 0.3), None);
        let aside = fit(&[seen], &drift(0.01, 0.0), any, 0.3).expect("it fits in part");
        assert!(aside.share < 0.8, "{aside:?}");
        // With the opposite sign if that makes sense, and limited to the allowed amount.
        let drifts = drift(-0.01, -0.5f64.to_radians());
        let other = fit(&[seen], &drifts, (-1.0, 1.0), 0.3).expect("it fits in part");
        assert!(
            (other.share - 0.5).abs() < 1e-12 && other.times == -1.0,
            "{other:?}"
        );
    }
}
