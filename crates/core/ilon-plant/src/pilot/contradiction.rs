//! Inconsistent wheel rates: no motion of the robot produces them, so the wheels slide against each
//! other on any floor.
//!
//! The inconsistent part of rates q' is r = q' - M M^+ q'. It is linear in q', so sums over time of
//! q' q'^T show how large it would have been with one wheel reversed, or with two exchanged.

use ilon_control::{Kinematics, handed};
use ilon_robot::Robot;
use nalgebra::{DMatrix, DVectorView};

/// Rates count as inconsistent from this share on, and from this rim speed, in m/s. Chosen.
const LEAST_SHARE: f64 = 0.05;
const LEAST_M_S: f64 = 5e-3;
/// Shorter inconsistencies are the lag of a wheel loop, in seconds. Chosen.
const LEAST_S: f64 = 0.3;
/// A change removes the inconsistency if at most this share of it remains. Chosen.
const REMOVED: f64 = 0.15;
/// M at the end is that of the contradiction if it gives the same sum of squares, but for rounding
/// and the give of a steering servo. Chosen.
const SAME: f64 = 0.02;

/// The times at which wheel rates were inconsistent.
#[derive(Clone, Debug)]
pub struct Contradiction {
    from_s: Option<f64>,
    time_s: f64,
    /// The sums of |r|^2 and |q'|^2 over these times, in rad^2/s: r as M was then, which steering
    /// changes.
    sizes: Sizes,
    /// The sum of |r|^2 over all times.
    seen: f64,
    /// The sum of q' q'^T over all times, in rad^2/s.
    products: DMatrix<f64>,
    residual: Vec<f64>,
}

/// Magnitudes of the inconsistent part of rates, and of the rates, as sums of squares.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    pub of_no_motion: f64,
    pub of_all: f64,
}

impl Sizes {
    /// |r| over |q'|, in [0, 1]; 0 if the wheels stand.
    pub fn share(self) -> f64 {
        match self.of_all > 0.0 {
            true => (self.of_no_motion / self.of_all).sqrt(),
            false => 0.0,
        }
    }
}

impl Contradiction {
    /// For a robot with `wheels` wheels, without data.
    pub fn new(wheels: usize) -> Self {
        Self {
            from_s: None,
            time_s: 0.0,
            sizes: Sizes::default(),
            seen: 0.0,
            products: DMatrix::zeros(wheels, wheels),
            residual: vec![0.0; wheels],
        }
    }

    /// The inconsistent part of the last rates, in rad/s.
    pub fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// Computes the inconsistent part of rates in rad/s.
    pub fn of(&mut self, kinematics: &Kinematics, rates_rad_s: &[f64]) -> Sizes {
        kinematics.contradiction(rates_rad_s, &mut self.residual);
        let squares = |of: &[f64]| of.iter().map(|rate| rate * rate).sum::<f64>();
        Sizes {
            of_no_motion: squares(&self.residual),
            of_all: squares(rates_rad_s),
        }
    }

    /// Adds the last rates in rad/s, which held from a time on for a duration, in seconds, while
    /// all wheels carried load.
    pub fn add(
        &mut self,
        kinematics: &Kinematics,
        rates_rad_s: &[f64],
        sizes: Sizes,
        [t_s, span_s]: [f64; 2],
    ) {
        let rims = self.residual.iter().zip(kinematics.lever_m());
        let rim_m2_s2 = rims.map(|(rate, lever_m)| (rate * lever_m).powi(2));
        let rim_m_s = (rim_m2_s2.sum::<f64>() / rates_rad_s.len() as f64).sqrt();
        if sizes.share() >= LEAST_SHARE && rim_m_s >= LEAST_M_S {
            self.from_s.get_or_insert(t_s);
            self.time_s += span_s;
            self.sizes.of_no_motion += span_s * sizes.of_no_motion;
            self.sizes.of_all += span_s * sizes.of_all;
        }
        // What mends them must leave alone what is consistent.
        self.seen += span_s * sizes.of_no_motion;
        let rates = DVectorView::from_slice(rates_rad_s, rates_rad_s.len());
        self.products.ger(span_s, &rates, &rates, 1.0);
    }

    /// A remark with the changes that would remove the inconsistency; `None` if the rates are
    /// consistent. `whose` names their source.
    pub fn remark(&self, kinematics: &Kinematics, robot: &Robot, whose: &str) -> Option<String> {
        let from_s = self.from_s.filter(|_| self.time_s >= LEAST_S)?;
        let mended = self.mended(kinematics, robot);
        let remedy = match (mended.as_deref(), steering_limit_rad_s(robot)) {
            (None, Some(rate_rad_s)) => format!(
                "steered wheels do so while their joints, which turn at up to {rate_rad_s} rad/s, are on their way"
            ),
            (None, None) => {
                "what would remove it cannot be told, as the wheels' steering has turned since"
                    .to_owned()
            }
            (Some([]), Some(rate_rad_s)) => format!(
                "no single reversal or exchange of wheels removes it; steered wheels do so while their joints, which turn at up to {rate_rad_s} rad/s, are on \
                 their way"
            ),
            (Some([]), None) => "no single reversal or exchange of wheels removes it".to_owned(),
            (Some([first]), _) => format!("{first} removes it"),
            (Some([first, rest @ ..]), _) => format!(
                "{first} removes it, and so does {}: drive in other directions to tell which",
                rest.join(", or ")
            ),
        };
        Some(format!(
            "{whose} contradict each other from {from_s:.2} s on, for {:.2} s: {:.0} % of them belongs to no motion of the robot, so that wheels \
             slide against each other on any floor, and where the robot goes is up to friction (column `rate_conflict_share`); {remedy}",
            self.time_s,
            100.0 * self.sizes.share()
        ))
    }

    /// The sum of |r|^2 over time for such products.
    fn of_no_motion(&self, kinematics: &Kinematics, products: &DMatrix<f64>) -> f64 {
        let count = products.nrows();
        let projector =
            DMatrix::identity(count, count) - kinematics.rate_matrix() * kinematics.twist_matrix();
        (&projector * products * projector.transpose())
            .trace()
            .max(0.0)
    }

    /// Each reversal of one wheel, each exchange of two, and each wheel of the other hand, that
    /// removes the inconsistency; those that drive the robot ahead most come first. `None` if M has turned since.
    fn mended(&self, kinematics: &Kinematics, robot: &Robot) -> Option<Vec<String>> {
        let count = robot.wheels.len();
        let name = |wheel: usize| robot.wheels[wheel].name.as_str();
        let reversals = (0..count).map(|wheel| {
            let mut change = DMatrix::identity(count, count);
            change[(wheel, wheel)] = -1.0;
            (change, format!("reversing `{}`", name(wheel)))
        });
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        let exchanges = pairs.map(|(a, b)| {
            let mut change = DMatrix::identity(count, count);
            change.swap_rows(a, b);
            let words = format!("exchanging `{}` and `{}`", name(a), name(b));
            (change, words)
        });
        let before = self.of_no_motion(kinematics, &self.products);
        // Steering has turned M since: what helps now says nothing of then.
        if (before / self.seen - 1.0).abs() > SAME {
            return None;
        }
        let mends = |kinematics: &Kinematics, products: &DMatrix<f64>| {
            let left = self.of_no_motion(kinematics, products);
            let ahead = kinematics.twist_matrix().row(0);
            let is_mended = left <= REMOVED * REMOVED * self.sizes.of_no_motion;
            is_mended.then(|| (ahead * products * ahead.transpose()).x)
        };
        let changed = reversals.chain(exchanges).filter_map(|(change, words)| {
            let products = &change * &self.products * change.transpose();
            Some((mends(kinematics, &products)?, words))
        });
        let mut found: Vec<(f64, String)> = changed.collect();
        // In one direction a wheel of the other hand looks like a reversed one. Alone it is no
        // sign: with another hand the wheel opposite may turn at any rate.
        let may_be = |wheel: &usize| !found.is_empty() && robot.wheels[*wheel].gamma_rad != 0.0;
        let other = (0..count).filter(may_be).filter_map(|wheel| {
            let mut other = robot.clone();
            other.wheels = handed(&robot.wheels, &[wheel]);
            let ahead = mends(&Kinematics::new(&other).ok()?, &self.products)?;
            let words = format!("mounting `{}` with its rollers the other way", name(wheel));
            Some((ahead, words))
        });
        let other: Vec<(f64, String)> = other.collect();
        found.extend(other);
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        Some(found.into_iter().map(|(_, words)| words).collect())
    }
}

/// The lowest limit of the rate of joints that steer wheels, in rad/s; `None` without such joints.
fn steering_limit_rad_s(robot: &Robot) -> Option<f64> {
    let steering = robot
        .wheels
        .iter()
        .filter_map(|wheel| robot.steering_of(wheel));
    let limits = steering.filter_map(|joint| Some(robot.joints[joint].servo()?.rate_limit));
    limits.reduce(f64::min).filter(|limit| limit.is_finite())
}

#[cfg(test)]
mod tests {
    use ilon_control::Kinematics;

    use super::*;

    /// A robot of four wheels.
    fn robot(name: &str) -> Robot {
        let file = format!("../../../assets/robots/{name}");
        let text = format!("[robot]\nfile = '{file}'\n[twist]\n[run]\nduration_s = 1");
        let here = env!("CARGO_MANIFEST_DIR");
        let scenario = ilon_scenario::Scenario::from_toml(&text, "s", here).expect("a scenario");
        ilon_scenario::robot::load(&scenario)
            .expect("a robot")
            .robot
    }

    fn said(rows: &[[f64; 4]]) -> Option<String> {
        said_of("mecanum4.toml", rows)
    }

    fn said_of(name: &str, rows: &[[f64; 4]]) -> Option<String> {
        let robot = robot(name);
        let kinematics = Kinematics::new(&robot).expect("a kinematics");
        let mut found = Contradiction::new(4);
        for (row, rates) in rows.iter().enumerate() {
            let sizes = found.of(&kinematics, rates);
            found.add(&kinematics, rates, sizes, [row as f64, 1.0]);
        }
        found.remark(&kinematics, &robot, "the wheel rates")
    }

    /// Rates of a motion have no r. No motion of these wheels, front left and right, then rear, has
    /// a part of n = (1, 1, -1, -1) / 2, and the rates (-6, 6, 6, 6) rad/s have n . q' = -6: half
    /// of their length 12. A drive ahead with the first wheel reversed is also one that turns, or
    /// goes sideways, with another reversed.
    #[test]
    fn a_reversed_motor_is_found_and_four_free_numbers_are_not_mended() {
        assert_eq!(said(&[[6.0; 4], [6.0, -6.0, 6.0, -6.0]]), None);
        let reversed = said(&[[-6.0, 6.0, 6.0, 6.0]]).unwrap_or_default();
        assert!(reversed.contains("50 % of them"), "{reversed}");
        let first = reversed.split("removes it").next().unwrap_or_default();
        assert!(first.ends_with("reversing `front_left` "), "{reversed}");
        // For a drive that turns as well, (2, 6, 4, 4) rad/s, only one reversal remains, and for one to
        // the left, (-6, 6, 6, -6), not even another wheel of the other hand.
        let turns = said(&[[-6.0, 6.0, 6.0, 6.0], [-2.0, 6.0, 4.0, 4.0]]);
        let turns = turns.unwrap_or_default();
        assert!(
            turns.contains("reversing `front_left` removes it, and so does mounting `rear_right`"),
            "{turns}"
        );
        let all = said(&[
            [-6.0, 6.0, 6.0, 6.0],
            [-2.0, 6.0, 4.0, 4.0],
            [6.0, 6.0, 6.0, -6.0],
        ]);
        let all = all.unwrap_or_default();
        assert!(
            all.ends_with("; reversing `front_left` removes it"),
            "{all}"
        );
        let free = said(&[[7.0, -2.0, 3.0, -5.0], [1.0, 4.0, -6.0, 3.0]]).unwrap_or_default();
        assert!(free.contains("no single reversal or exchange"), "{free}");
    }

    /// To the left all wheels turn at the same rate, those on one diagonal backwards. With the third
    /// one's rollers the other way it must turn the other way too, as if it were reversed; ahead it
    /// must not, so that a drive in both directions is of no reversed wheel.
    #[test]
    fn a_wheel_of_the_other_hand_is_named_beside_a_reversed_one() {
        let left = said(&[[-6.0, 6.0, -6.0, -6.0]]).unwrap_or_default();
        for way in [
            "reversing `rear_left`",
            "mounting `rear_left` with its rollers the other way",
        ] {
            assert!(
                left.contains(way) && left.contains("in other directions"),
                "{left}"
            );
        }
        let both = said(&[[-6.0, 6.0, -6.0, -6.0], [6.0; 4]]).unwrap_or_default();
        assert!(both.contains("no single reversal"), "{both}");
    }

    /// Rates of which one alone is wrong by another factor, and a contradiction among others below the
    /// threshold: neither is laid to a hand, nor to steering.
    #[test]
    fn a_wheel_that_counts_too_little_is_no_other_hand() {
        let slow = said(&[[5.0, 8.0, 8.0, 8.0]]).unwrap_or_default();
        assert!(
            slow.ends_with("no single reversal or exchange of wheels removes it"),
            "{slow}"
        );
        // 4 s of contradictions of 4 %, which are not reported, after 1 s of one of 12 %.
        let rows = [
            [5.0, 8.0, 8.0, 8.0],
            [7.3, 8.0, 8.0, 8.0],
            [7.3, 8.0, 8.0, 8.0],
            [7.3, 8.0, 8.0, 8.0],
        ];
        let mixed = said(&rows).unwrap_or_default();
        assert!(!mixed.contains("steering"), "{mixed}");
    }

    /// Four driven modules that stand straight: one that turns backwards is named, and rates that
    /// nothing mends are laid to steering that is on its way.
    #[test]
    fn a_reversed_module_is_named_and_else_its_steering() {
        let name = "swerve4.urdf";
        let reversed = said_of(name, &[[-6.0, 6.0, 6.0, 6.0]]).unwrap_or_default();
        assert!(
            reversed.contains("removes it") && !reversed.contains("steered"),
            "{reversed}"
        );
        let odd =
            said_of(name, &[[7.0, -2.0, 3.0, -5.0], [1.0, 4.0, -6.0, 3.0]]).unwrap_or_default();
        assert!(
            odd.contains("steered wheels do so while their joints"),
            "{odd}"
        );
    }

    /// The share is that of the rates when they were: steering turns M afterwards, as another
    /// robot's M stands for here.
    #[test]
    fn what_steering_turns_afterwards_changes_no_share() {
        let [robot, other] = ["mecanum4.toml", "skid4.urdf"].map(robot);
        let [kinematics, after] = [&robot, &other].map(|of| Kinematics::new(of).expect("M"));
        let mut found = Contradiction::new(4);
        let rates = [-6.0, 6.0, 6.0, 6.0];
        let sizes = found.of(&kinematics, &rates);
        found.add(&kinematics, &rates, sizes, [0.0, 1.0]);
        let said = found
            .remark(&after, &robot, "the wheel rates")
            .unwrap_or_default();
        assert!(said.contains("50 % of them"), "{said}");
        // What would help now says nothing of then.
        assert!(
            said.contains("has turned since") && !said.contains("removes it"),
            "{said}"
        );
    }
}
