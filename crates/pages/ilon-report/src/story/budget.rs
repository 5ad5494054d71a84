//! The error budget at the worst instant: what moved the robot off its reference, and what moved it
//! back.
//!
//! With **e** = desired - actual, of the point that follows the reference,
//!
//! d**e**/dt = (desired rate - asked) + (asked - granted) + ... + (contact - real)
//!
//! where the first bracket is the guidance's correction, its request beyond the reference's own
//! rate, and the others are the terms of [`ilon_trace::ledger`], which rows have as sums. From an
//! instant with a small error to the worst one, and projected on the error there, the parts add up
//! to the growth of the error. Unlike the ledger of the whole run it does not count a correction
//! that feedback renews forever.

use ilon_robot::wrap_angle;
use ilon_trace::ledger::{Integral, NAMES, TERMS};
use ilon_trace::{Header, Ledger, Record};

/// Names of the parts: the guidance's correction, then the terms of the ledger in their order. The
/// ledger's `guidance` is the part removed by saturation.
pub(crate) const PARTS: [&str; 1 + TERMS] = {
    let mut parts = ["correction by guidance"; 1 + TERMS];
    let (_, named) = parts.split_at_mut(1);
    named.copy_from_slice(&NAMES);
    parts[1] = "saturation";
    parts
};

/// The parts at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Standing {
    pub t_s: f64,
    /// Desired minus actual position of the reference point, in the world frame, in metres.
    pub error_m: [f64; 2],
    /// The integral of each part since the start, in the world frame, in metres.
    pub parts_m: [[f64; 2]; 1 + TERMS],
    /// Lag of the wheels behind their targets, along the actual path, in metres.
    pub behind_m: f64,
}

/// The error budget of a growth of the error.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Budget {
    /// Time of the small error, in seconds.
    pub from_s: f64,
    /// Time of the largest error, in seconds.
    pub at_s: f64,
    /// The largest error, in metres.
    pub error_m: f64,
    /// Projection of the initial error on the error, in metres.
    pub before_m: f64,
    /// Contribution of each part of [`PARTS`] along the error, in metres.
    pub parts_m: [f64; 1 + TERMS],
    /// Lead of the wheels over their targets, along the actual path, in metres.
    pub ahead_m: f64,
    /// Remainder of the sum, in metres: of second order in the rotation from row to row.
    pub rest_m: f64,
}

/// Integrates the parts row by row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Integrator {
    parts_m: [[f64; 2]; 1 + TERMS],
    behind_m: f64,
    before: Option<Record>,
}

impl Integrator {
    /// Adds a row, and returns the parts at its time; `None` without a reference.
    pub fn add(&mut self, header: &Header, record: &Record) -> Option<Standing> {
        let desired = record.desired?.pose;
        if let Some(before) = self.before.replace(*record) {
            self.add_since(header, &before, record);
        }
        let real = header.reference_point_at(record.truth.pose);
        Some(Standing {
            t_s: record.t_s,
            error_m: [desired.x_m - real.x_m, desired.y_m - real.y_m],
            parts_m: self.parts_m,
            behind_m: self.behind_m,
        })
    }

    /// Adds the interval between two rows.
    fn add_since(&mut self, header: &Header, before: &Record, record: &Record) {
        let heading_rad = before.truth.pose.heading_rad;
        let turned_rad = wrap_angle(record.truth.pose.heading_rad - heading_rad);
        let (sin, cos) = (heading_rad + 0.5 * turned_rad).sin_cos();
        let [arm_x_m, arm_y_m] = header.reference_point_m;
        // A rotation of the body moves its reference point too.
        let of_point = |term: &Integral| {
            let turned_rad = term.heading_rad;
            [
                term.x_m - turned_rad * (sin * arm_x_m + cos * arm_y_m),
                term.y_m + turned_rad * (cos * arm_x_m - sin * arm_y_m),
            ]
        };
        let grown = record.ledger.since(&before.ledger);
        let place = |record: &Record| {
            record
                .desired
                .map_or([0.0; 2], |of| [of.pose.x_m, of.pose.y_m])
        };
        let real = |record: &Record| {
            let point = header.reference_point_at(record.truth.pose);
            [point.x_m, point.y_m]
        };
        let total = of_point(&grown.total);
        let [servo, went] = [
            of_point(&grown.servo),
            [0, 1].map(|axis| real(record)[axis] - real(before)[axis]),
        ];
        let went_m = went[0].hypot(went[1]);
        if went_m > 0.0 {
            self.behind_m += (servo[0] * went[0] + servo[1] * went[1]) / went_m;
        }
        let correction = [0, 1].map(|axis| {
            let wanted_m = place(record)[axis] - place(before)[axis];
            // The requested motion is the actual one plus the total of the ledger.
            wanted_m - (went[axis] + total[axis])
        });
        let terms = grown.terms().map(|term| of_point(&term));
        let parts = std::iter::once(correction).chain(terms);
        for (sum, part) in self.parts_m.iter_mut().zip(parts) {
            sum[0] += part[0];
            sum[1] += part[1];
        }
    }
}

/// What leads from the ledger of the whole run to the error at its end: where it follows a
/// reference, the error at the start and the guidance's corrections; in open loop the commands that
/// were carried out at another heading than where they lead.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OffCourse {
    before: Option<Record>,
    /// Desired minus real pose of the reference point at the first row and at the last, in the
    /// world frame, in m, m and rad.
    errors: Option<[[f64; 3]; 2]>,
    /// In open loop: what the commands would have moved the robot by at the heading to which they
    /// lead, minus what at its own, in metres.
    through_heading_m: [f64; 2],
}

impl OffCourse {
    pub fn add(&mut self, header: &Header, record: &Record) {
        let before = self.before.replace(*record);
        if let Some(desired) = record.desired {
            let real = header.reference_point_at(record.truth.pose);
            let error = [
                desired.pose.x_m - real.x_m,
                desired.pose.y_m - real.y_m,
                wrap_angle(desired.pose.heading_rad - real.heading_rad),
            ];
            self.errors.get_or_insert([error; 2])[1] = error;
        } else if let Some(before) = before {
            let [then, now] = [&before, record].map(|row| (row.truth.pose, row.ledger.total));
            let asked_m = [
                now.0.x_m - then.0.x_m + now.1.x_m - then.1.x_m,
                now.0.y_m - then.0.y_m + now.1.y_m - then.1.y_m,
            ];
            let (sin, cos) = (0.5 * (then.1.heading_rad + now.1.heading_rad)).sin_cos();
            self.through_heading_m[0] += (cos - 1.0) * asked_m[0] - sin * asked_m[1];
            self.through_heading_m[1] += sin * asked_m[0] + (cos - 1.0) * asked_m[1];
        }
    }

    /// The parts beside the terms of a ledger by their names, and the error at the end that all add
    /// up to, each in m, m and rad.
    pub fn closing(&self, ledger: &Ledger) -> Vec<(&'static str, [f64; 3])> {
        let total = ledger.total;
        let total = [total.x_m, total.y_m, total.heading_rad];
        match self.errors {
            None => {
                let [x_m, y_m] = self.through_heading_m;
                vec![
                    ("through heading", [x_m, y_m, 0.0]),
                    (
                        "off the commands",
                        [total[0] + x_m, total[1] + y_m, total[2]],
                    ),
                ]
            }
            Some([start, end]) => {
                let corrected = [0, 1, 2].map(|axis| end[axis] - start[axis] - total[axis]);
                vec![
                    ("error at the start", start),
                    ("correction by guidance", corrected),
                    ("error at the end", end),
                ]
            }
        }
    }
}

impl Standing {
    fn error(&self) -> f64 {
        self.error_m[0].hypot(self.error_m[1])
    }
}

/// Returns the budget of the largest error after `after_s`; `None` for too few instants.
pub(crate) fn at_the_worst(standings: &[Standing], after_s: f64) -> Option<Budget> {
    /// The growth starts where the error was last below this share of its peak.
    const SMALL: f64 = 0.1;
    let first = standings.iter().position(|s| s.t_s >= after_s)?;
    let considered = &standings[first..];
    // The first of equal ones.
    let later = |a: usize, b: usize| {
        if considered[b].error() > considered[a].error() {
            b
        } else {
            a
        }
    };
    let worst = (0..considered.len()).reduce(later)?;
    let peak = considered[worst];
    let small = |s: &Standing| s.error() <= SMALL * peak.error();
    // If the error was never small, the smallest before the peak is the start.
    let onset = considered[..worst].iter().rposition(small).or_else(|| {
        (0..worst).min_by(|&a, &b| considered[a].error().total_cmp(&considered[b].error()))
    })?;
    let start = considered[onset];
    let size_m = peak.error();
    // NaN is no error either.
    if size_m.is_nan() || size_m <= 0.0 {
        return None;
    }
    let along = peak.error_m.map(|x| x / size_m);
    let dot = |v: [f64; 2]| v[0] * along[0] + v[1] * along[1];
    let mut parts_m = [0.0; 1 + TERMS];
    for (part, (to, from)) in parts_m
        .iter_mut()
        .zip(peak.parts_m.iter().zip(&start.parts_m))
    {
        *part = dot([to[0] - from[0], to[1] - from[1]]);
    }
    let before_m = dot(start.error_m);
    Some(Budget {
        from_s: start.t_s,
        at_s: peak.t_s,
        error_m: size_m,
        before_m,
        rest_m: size_m - before_m - parts_m.iter().sum::<f64>(),
        parts_m,
        ahead_m: start.behind_m - peak.behind_m,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_robot::{Pose, Twist};
    use ilon_trace::Desired;
    use ilon_trace::ledger::Chain;

    /// A point (0.3, 0.2) off the body's origin moves with the body's rotation: a loss of 1 rad/s
    /// is a loss of (-0.2, 0.3) m/s there.
    #[test]
    fn what_turns_the_body_moves_its_reference_point() {
        let header = Header {
            control_dt_s: 0.01,
            reference_point_m: [0.3, 0.2],
            ..Header::default()
        };
        let mut sum = Integrator::default();
        let mut ledger = ilon_trace::Ledger::default();
        for row in 0..=100 {
            let record = Record {
                t_s: 0.01 * f64::from(row),
                ledger,
                desired: Some(Desired::default()),
                // A commanded rotation with no purpose: the point moves away at (-0.2, 0.3) m/s.
                command_twist_in_body: Twist::new(0.0, 0.0, 1.0),
                ..Record::default()
            };
            sum.add(&header, &record);
            ledger.count(&Chain::held(&record, 0.01), [0.0; 2]);
        }
        // The correction is the reference's rate, zero, less the command, over a second.
        let [x_m, y_m] = sum.parts_m[0];
        assert!((x_m - 0.2).abs() < 1e-12, "{x_m}");
        assert!((y_m + 0.3).abs() < 1e-12, "{y_m}");
    }

    /// The reference moves ahead at 1 m/s. From 1 to 2 s the robot's contacts slide by 0.4 m/s
    /// sideways, and the guidance corrects by 0.1 m/s.
    #[test]
    fn a_slide_and_its_correction_are_told_apart_and_add_up() {
        let header = Header {
            control_dt_s: 0.01,
            ..Header::default()
        };
        let mut sum = Integrator::default();
        let mut standings = Vec::new();
        let mut y_m = 0.0;
        let mut ledger = ilon_trace::Ledger::default();
        for row in 0..=300 {
            let t_s = 0.01 * f64::from(row);
            let sliding = (0.995..1.995).contains(&t_s);
            let asked_y = if sliding { 0.1 } else { 0.0 };
            let real_y = if sliding { -0.3 } else { 0.0 };
            let ahead = Twist::new(1.0, asked_y, 0.0);
            let record = Record {
                t_s,
                desired: Some(Desired {
                    pose: Pose {
                        x_m: t_s,
                        ..Pose::default()
                    },
                    ..Desired::default()
                }),
                ledger,
                command_twist_in_body: ahead,
                granted_twist_in_body: ahead,
                twist_target_ideal: ahead,
                twist_ideal: ahead,
                twist_contact: ahead,
                truth: ilon_trace::Truth {
                    pose: Pose {
                        x_m: t_s,
                        y_m,
                        heading_rad: 0.0,
                    },
                    twist_in_body: Twist::new(1.0, real_y, 0.0),
                    ..ilon_trace::Truth::default()
                },
                ..Record::default()
            };
            standings.extend(sum.add(&header, &record));
            ledger.count(&Chain::held(&record, 0.01), [0.0; 2]);
            y_m += 0.01 * real_y;
        }
        let budget = at_the_worst(&standings, 0.0).expect("it was off");
        // 0.3 m/s for a second, counted from a tenth of the peak, 0.03 m at 1.1 s: slip takes 0.4
        // m/s for 0.9 s, the guidance restores 0.1 m/s. Sums of a hundred terms: rounding below
        // 1e-12.
        assert!((budget.error_m - 0.3).abs() < 1e-12, "{budget:?}");
        assert!((budget.before_m - 0.03).abs() < 1e-12, "{budget:?}");
        assert!((budget.parts_m[8] - 0.36).abs() < 1e-12, "{budget:?}");
        assert!((budget.parts_m[0] + 0.09).abs() < 1e-12, "{budget:?}");
        assert!(budget.rest_m.abs() < 1e-12, "{budget:?}");
        assert!((budget.from_s - 1.1).abs() < 0.011 && (budget.at_s - 2.0).abs() < 0.011);
    }

    /// A robot that is asked for 1 m/s ahead turns by 0.3 rad/s all the same, by slip: nothing is
    /// lost along its own axes, and after 4 s it is on a circle instead of at (4, 0) m.
    #[test]
    fn what_a_lost_heading_does_closes_the_budget() {
        let (header, omega_rad_s) = (Header::default(), 0.3_f64);
        let (mut sum, mut ledger) = (OffCourse::default(), ilon_trace::Ledger::default());
        let mut last = Pose::default();
        for row in 0..=400 {
            let t_s = 0.01 * f64::from(row);
            let turned_rad = omega_rad_s * t_s;
            last = Pose {
                x_m: turned_rad.sin() / omega_rad_s,
                y_m: (1.0 - turned_rad.cos()) / omega_rad_s,
                heading_rad: turned_rad,
            };
            let mut record = Record {
                t_s,
                ledger,
                command_twist_in_body: Twist::new(1.0, 0.0, 0.0),
                ..Record::default()
            };
            record.truth.pose = last;
            record.truth.twist_in_body = Twist::new(1.0, 0.0, omega_rad_s);
            sum.add(&header, &record);
            let next_rad = turned_rad + 0.01 * omega_rad_s;
            ledger.count(&Chain::held(&record, 0.01), [turned_rad, next_rad]);
        }
        let closing = sum.closing(&sum.before.expect("rows").ledger);
        let [(_, through), (_, end)] = closing[..] else {
            panic!("{closing:?}");
        };
        // Of second order in the 3 mrad of a row: 4 m times 9e-6 / 24.
        let near = |a: f64, b: f64| (a - b).abs() < 1e-5;
        assert!(
            near(end[0], 4.0 - last.x_m) && near(end[1], -last.y_m),
            "{end:?}"
        );
        assert!(
            near(through[0], end[0]) && near(through[1], end[1]),
            "{through:?}"
        );
        assert!(near(end[2], -last.heading_rad), "{end:?}");
    }

    #[test]
    fn a_run_that_is_never_off_has_no_budget() {
        assert_eq!(at_the_worst(&[Standing::default(); 3], 0.0), None);
        assert_eq!(at_the_worst(&[], 0.0), None);
    }
}
