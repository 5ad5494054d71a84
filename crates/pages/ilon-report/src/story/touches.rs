//! Sentences on the free bodies that the robot touched: when, and the work of pushing them.

use ilon_trace::{Header, Record};

use super::phrases::list;
use super::spells::{Spell, Spells};
use crate::conditions::gravity_m_s2;
use crate::page::escape;
use crate::text::{energy, length, percent, time};

/// Observes the free bodies of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touches {
    /// For each body: spans in which the robot pressed on it.
    bodies: Vec<Spells>,
    /// Work of robots on each body up to the previous row, in J.
    work_before_j: Vec<f64>,
    falls: Vec<Fall>,
    gravity_m_s2: f64,
}

/// The deepest free fall of a body.
#[derive(Clone, Copy, Debug, Default)]
struct Fall {
    /// Start height of the current fall, in metres, if any.
    from_m: Option<f64>,
    most_m: f64,
    at_s: f64,
}

impl Fall {
    /// A body that moves down faster than this falls, in m/s: rolling down a slope is slower.
    const FALLS_M_S: f64 = 0.7;

    /// Adds a row of a body under a gravity in m/s^2.
    fn add(&mut self, t_s: f64, height_m: f64, rate_m_s: f64, gravity_m_s2: f64) {
        if rate_m_s > -Self::FALLS_M_S {
            self.from_m = None;
            return;
        }
        // Before it reached this speed it had fallen by v^2 / 2 g already.
        let from_m =
            *(self.from_m).get_or_insert(height_m + rate_m_s * rate_m_s / (2.0 * gravity_m_s2));
        if from_m - height_m > self.most_m {
            (self.most_m, self.at_s) = (from_m - height_m, t_s);
        }
    }
}

impl Touches {
    pub fn new(header: &Header) -> Self {
        Self {
            bodies: vec![Spells::default(); header.bodies.len()],
            work_before_j: vec![0.0; header.bodies.len()],
            falls: vec![Fall::default(); header.bodies.len()],
            gravity_m_s2: gravity_m_s2(header),
        }
    }

    pub fn add(&mut self, header: &Header, record: &Record) {
        let (t_s, dt_s) = (record.t_s, header.row_span_s(record.t_s));
        for (sample, fall) in record.bodies.iter().zip(&mut self.falls) {
            let (height_m, rate_m_s) = (sample.place_m[2], sample.velocity_m_s[2]);
            fall.add(t_s, height_m, rate_m_s, self.gravity_m_s2);
        }
        let before = self.bodies.iter_mut().zip(&mut self.work_before_j);
        for (sample, (spells, work_j)) in record.bodies.iter().zip(before) {
            let before_j = std::mem::replace(work_j, sample.work_j);
            if sample.push_n > 0.0 {
                spells.add(t_s, dt_s, [sample.push_n; 2], sample.work_j - before_j);
            }
        }
    }

    /// Returns each span in which the robot pressed on a body, with its description.
    pub(super) fn episodes(&self, header: &Header) -> Vec<(Spell, String)> {
        let of_all = self.bodies.iter().zip(&header.bodies);
        let of_body = of_all.flat_map(|(spells, body)| {
            let say = |spell: &Spell| {
                let most_n = spell.largest;
                let took = took(spell.energy_j, None);
                let text = format!(
                    "the robot presses on `{}` with up to {most_n:.1} N; {took}",
                    body.name
                );
                (*spell, text)
            };
            spells.found.iter().map(say)
        });
        of_body.collect()
    }

    /// Reports which bodies fell, from the deck or onto it, and how far.
    pub fn falls(&self, header: &Header) -> Option<String> {
        /// Smaller falls are not reported, in metres.
        const LEAST_M: f64 = 0.03;
        let of_all = self.falls.iter().zip(&header.bodies);
        let fell = of_all.filter(|(fall, _)| fall.most_m > LEAST_M);
        let fell: Vec<String> = fell
            .map(|(fall, body)| {
                let (name, at) = (escape(&body.name), time(fall.at_s));
                format!(
                    "<b>{name}</b> fell by <b>{}</b> until {at}",
                    length(fall.most_m)
                )
            })
            .collect();
        (!fell.is_empty()).then(|| format!("{}.", list(&fell)))
    }

    /// Reports the first touched body, and the work of pushing all of them as a share of the energy
    /// supplied, in J; `None` if it touched none.
    pub fn sentence(&self, header: &Header, put_in_j: Option<f64>) -> Option<String> {
        let of_all = self.bodies.iter().zip(&header.bodies);
        let firsts = of_all.filter_map(|(spells, body)| Some((spells.found.first()?, &body.name)));
        let (first, name) = firsts.min_by(|(a, _), (b, _)| a.from_s.total_cmp(&b.from_s))?;
        let all_j = self.work_before_j.iter().sum();
        Some(format!(
            "It first touched <b>{}</b> at {}; its work on bodies {}.",
            escape(name),
            time(first.from_s),
            took(all_j, put_in_j),
        ))
    }
}

/// Returns work on bodies in J as text, with its share, if known.
fn took(work_j: f64, put_in_j: Option<f64>) -> String {
    /// Less work counts as zero, in J.
    const LEAST_J: f64 = 5e-4;
    if work_j.abs() < LEAST_J {
        return "was less than 1 mJ".to_owned();
    }
    if work_j < 0.0 {
        return format!("was negative: they gave back {}", energy(-work_j));
    }
    let of_all = put_in_j.filter(|all_j| *all_j >= work_j);
    let of_all = of_all.map_or_else(String::new, |all_j| {
        format!(", {} of the energy put in", percent(work_j / all_j))
    });
    format!("was {}{of_all}", energy(work_j))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_robot::FreeShape;
    use ilon_trace::BodyHeader;

    /// A box is pushed from 1 to 2 s with 5 N at 0.2 m/s, which takes 1 J of the motors' 4 J.
    #[test]
    fn the_first_touch_and_its_share_are_said() {
        let header = Header {
            control_dt_s: 0.01,
            bodies: vec![BodyHeader {
                name: "crate".to_owned(),
                shape: FreeShape::Box { size_m: [0.2; 3] },
                mass_kg: 1.0,
                friction: 0.5,
            }],
            ..Header::default()
        };
        let mut touches = Touches::new(&header);
        for row in 0..=200 {
            let t_s = 0.01 * f64::from(row);
            let mut record = Record {
                t_s,
                ..Record::default()
            };
            record.bodies[0].push_n = if t_s > 1.0 { 5.0 } else { 0.0 };
            record.bodies[0].work_j = (t_s - 1.0).max(0.0);
            touches.add(&header, &record);
        }
        assert_eq!(touches.falls(&header), None);
        let said = touches
            .sentence(&header, Some(4.0))
            .expect("it was touched");
        assert!(said.contains("<b>crate</b> at 1.0"), "{said}");
        assert!(said.contains("25"), "{said}");
        let episodes = touches.episodes(&header);
        assert_eq!(episodes.len(), 1);
        assert!(episodes[0].1.contains("up to 5.0 N"), "{}", episodes[0].1);
    }

    /// Work beyond what the motors put in came from elsewhere, such as a slope.
    #[test]
    fn work_is_a_share_of_what_was_put_in_only_if_it_came_from_there() {
        assert!(took(1.0, Some(4.0)).contains("25"));
        assert!(!took(4.0, Some(1.0)).contains("put in"));
    }

    /// A body that falls freely from 1 s on by 0.3 m, and then lies: v = g t. Returns the sentence.
    fn told_of_a_fall(gravity_m_s2: f64) -> String {
        let header = Header {
            scenario_toml: format!("[world]\ngravity_m_s2 = {gravity_m_s2:?}\n"),
            control_dt_s: 0.01,
            bodies: vec![BodyHeader {
                name: "cargo".to_owned(),
                shape: FreeShape::Box { size_m: [0.2; 3] },
                mass_kg: 1.0,
                friction: 0.5,
            }],
            ..Header::default()
        };
        let mut touches = Touches::new(&header);
        for row in 0..=200 {
            let t_s = 0.01 * f64::from(row);
            let for_s = (t_s - 1.0).max(0.0);
            let fell_m = 0.5 * gravity_m_s2 * for_s * for_s;
            let mut record = Record {
                t_s,
                ..Record::default()
            };
            record.bodies[0].place_m[2] = 0.4 - fell_m.min(0.3);
            record.bodies[0].velocity_m_s[2] = if fell_m < 0.3 {
                -gravity_m_s2 * for_s
            } else {
                0.0
            };
            touches.add(&header, &record);
        }
        touches.falls(&header).unwrap_or_default()
    }

    /// On earth the last row of the fall is at 0.24 s: 0.2825 m. On the moon at 0.60 s: 0.2916 m,
    /// of which 0.151 m before the body is faster than 0.7 m/s.
    #[test]
    fn a_body_that_falls_is_told_of() {
        for (gravity_m_s2, said) in [
            (9.81, "<b>cargo</b> fell by <b>282.5 mm</b> until 1.24 s."),
            (1.62, "<b>cargo</b> fell by <b>291.6 mm</b> until 1.60 s."),
        ] {
            assert_eq!(told_of_a_fall(gravity_m_s2), said);
        }
    }
}
