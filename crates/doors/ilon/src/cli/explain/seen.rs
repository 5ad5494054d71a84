//! The drift of a real robot, as a person writes it on the command line.

use std::str::FromStr;

use ilon_sim::causes::Drift;
use ilon_sim::standard_motions::MOTIONS;

/// A drift in one of the standard motions. What was not seen is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Its place among the motions.
    pub motion: usize,
    /// In m/m or m/turn.
    ahead_m: Option<f64>,
    left_m: Option<f64>,
    /// In rad/m or rad/turn.
    turned_rad: Option<f64>,
}

/// How well a suspect explains what was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    /// The share of what was seen that it explains, up to 1.
    pub share: f64,
    /// By how much it would be larger than its usual amount.
    pub times: f64,
}

/// How well a suspect's drifts, in any amount, explain what was seen. Angles count at an arm, in metres. `None` where it would have to be the other way
/// round.
pub(super) fn fit(seen: &[Seen], drifts: &[Option<Drift>], arm_m: f64) -> Option<Fit> {
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
    let times = sum(|(s, d)| s * d) / drift2;
    let rest = pairs
        .iter()
        .map(|(s, d)| (s - times * d).powi(2))
        .sum::<f64>();
    (times > 0.0 && seen2 > 0.0).then(|| Fit {
        share: 1.0 - (rest / seen2).sqrt(),
        times,
    })
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
        let mut seen = Self {
            motion,
            ahead_m: None,
            left_m: None,
            turned_rad: None,
        };
        for part in parts.split(',') {
            seen.take(part.trim())?;
        }
        Ok(seen)
    }
}

impl Seen {
    /// Takes one part, such as `left 20 mm/m`.
    fn take(&mut self, part: &str) -> Result<(), String> {
        let help = || {
            format!(
                "`{part}` is no drift: write a direction (ahead, back, left, right, turn), a number and a unit (mm/m, deg/m, mm/turn, deg/turn), such \
                 as \"left 20 mm/m\" or \"turn -1 deg/m\""
            )
        };
        let words: Vec<&str> = part.split_whitespace().collect();
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
        let (per_si, is_angle) = match unit {
            "mm/m" | "mm/turn" => (1e-3, false),
            "cm/m" | "cm/turn" => (1e-2, false),
            "m/m" | "m/turn" => (1.0, false),
            "%" => (1e-2, false),
            "deg/m" | "deg/turn" | "°/m" | "°/turn" => (1f64.to_radians(), true),
            "rad/m" | "rad/turn" => (1.0, true),
            _ => return Err(help()),
        };
        let value = per_si * number;
        let (place, value) = match (direction, is_angle) {
            ("ahead", false) => (&mut self.ahead_m, value),
            ("back", false) => (&mut self.ahead_m, -value),
            ("left", false) => (&mut self.left_m, value),
            ("right", false) => (&mut self.left_m, -value),
            ("turn", true) => (&mut self.turned_rad, value),
            ("turn right", true) => (&mut self.turned_rad, -value),
            _ => return Err(help()),
        };
        *place = Some(value);
        Ok(())
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
        for wrong in [
            "",
            "left",
            "left x mm/m",
            "left 3 deg/m",
            "turn 3 mm/m",
            "sideways: left 1 mm/m",
            "up 1 mm/m",
            "left NaN mm/m",
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
        let half = fit(&[seen], &drift(0.01, 0.5f64.to_radians()), 0.3).expect("it fits");
        assert!((half.share - 1.0).abs() < 1e-12 && (half.times - 2.0).abs() < 1e-12);
        assert_eq!(fit(&[seen], &drift(-0.01, 0.0), 0.3), None);
        assert_eq!(fit(&[seen], &drift(0.0, 0.0), 0.3), None);
        let aside = fit(&[seen], &drift(0.01, 0.0), 0.3).expect("it fits in part");
        assert!(aside.share < 0.8, "{aside:?}");
    }
}
