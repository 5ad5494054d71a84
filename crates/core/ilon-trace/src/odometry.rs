//! The drift of dead reckoning from the wheel rates.

use ilon_robot::{Pose, wrap_angle};
use serde::{Deserialize, Serialize};

use crate::fold::Largest;
use crate::record::Record;

/// Below this path length, in metres, a drift per metre is meaningless. Chosen.
const SHORTEST_WAY_M: f64 = 0.01;
/// Below this rotation, in radians, a drift per turn is meaningless. Chosen.
const LEAST_TURN_RAD: f64 = 0.1;

/// The drift of one kind of dead reckoning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Drift {
    /// Distance between reckoned and true position at the end, in metres.
    pub final_m: Option<f64>,
    /// Reckoned minus true heading at the end, in radians.
    pub final_rad: Option<f64>,
    /// Largest distance at any time, in metres.
    pub worst_m: Option<f64>,
    /// Final distance over the path length; `None` if the robot hardly moved.
    pub m_per_m: Option<f64>,
    /// Final heading error over the path length, in rad/m, signed.
    pub rad_per_m: Option<f64>,
    /// Final heading error per full turn of the robot, in radians, signed; `None` if it hardly
    /// turned.
    pub rad_per_turn: Option<f64>,
}

/// The robot's travel, and the drift of dead reckoning over it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct OdometryDrift {
    /// True path length of the body's origin, in metres.
    pub travelled_m: f64,
    /// Sum of all true rotations in both directions, in radians.
    pub turned_rad: f64,
    /// The drift of dead reckoning by Indiveri 2009, eq. (7).
    pub ideal: Drift,
    /// The drift of dead reckoning by the contact kinematics.
    pub contact: Drift,
}

/// Travel and dead reckoning so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Accumulator {
    last: Option<Record>,
    travelled_m: f64,
    turned_rad: f64,
    worst_ideal_m: Largest,
    worst_contact_m: Largest,
}

impl Accumulator {
    /// Adds the next record.
    pub fn add(&mut self, record: &Record) {
        let pose = record.truth.pose;
        if let Some(last) = self.last.replace(*record) {
            let before = last.truth.pose;
            self.travelled_m += (pose.position_m() - before.position_m()).norm();
            self.turned_rad += wrap_angle(pose.heading_rad - before.heading_rad).abs();
        }
        self.worst_ideal_m
            .add(away_m(record, record.odometry_ideal));
        self.worst_contact_m
            .add(away_m(record, record.odometry_contact));
    }

    /// The drifts at the end of the run.
    pub fn finish(self) -> OdometryDrift {
        let Some(last) = self.last else {
            return OdometryDrift::default();
        };
        OdometryDrift {
            travelled_m: self.travelled_m,
            turned_rad: self.turned_rad,
            ideal: self.drift(&last, last.odometry_ideal, self.worst_ideal_m),
            contact: self.drift(&last, last.odometry_contact, self.worst_contact_m),
        }
    }

    fn drift(&self, last: &Record, reckoned: Pose, worst_m: Largest) -> Drift {
        let final_m = away_m(last, reckoned);
        let final_rad = wrap_angle(reckoned.heading_rad - last.truth.pose.heading_rad);
        let (way_m, turn_rad) = (self.travelled_m, self.turned_rad);
        let moved = way_m >= SHORTEST_WAY_M;
        Drift {
            final_m: Some(final_m),
            final_rad: Some(final_rad),
            worst_m: worst_m.get(),
            m_per_m: moved.then(|| final_m / way_m),
            rad_per_m: moved.then(|| final_rad / way_m),
            rad_per_turn: (turn_rad >= LEAST_TURN_RAD)
                .then(|| final_rad / (turn_rad / std::f64::consts::TAU)),
        }
    }
}

/// Distance between a reckoned and the true position, in metres.
fn away_m(record: &Record, reckoned: Pose) -> f64 {
    (reckoned.position_m() - record.truth.pose.position_m()).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::Header;
    use crate::trace::Trace;

    fn drift_of(trace: &Trace) -> OdometryDrift {
        let mut accumulator = Accumulator::default();
        let records = trace.records().iter();
        records.for_each(|record| accumulator.add(record));
        accumulator.finish()
    }

    /// Half a radian to the left and back again is one radian of turning.
    #[test]
    fn turning_counts_in_both_directions() {
        let at = |heading_rad| Pose {
            heading_rad,
            ..Pose::default()
        };
        let poses = [0.0, 0.5, 0.0].map(|heading_rad| (at(heading_rad), at(heading_rad)));
        let drift = drift_of(&moved(&poses));
        assert_eq!(drift.turned_rad, 1.0);
        assert_eq!(drift.ideal.rad_per_turn, Some(0.0));
    }

    fn moved(poses: &[(Pose, Pose)]) -> Trace {
        let mut trace = Trace::with_capacity(Header::default(), poses.len());
        for &(truth, odometry_ideal) in poses {
            let mut record = Record {
                odometry_ideal,
                ..Record::default()
            };
            record.truth.pose = truth;
            trace.push(record, &[]);
        }
        trace
    }

    fn pose(x_m: f64, y_m: f64, heading_rad: f64) -> Pose {
        Pose {
            x_m,
            y_m,
            heading_rad,
        }
    }

    #[test]
    fn drift_is_counted_on_the_way_travelled_not_on_the_distance_from_the_start() {
        // 1 m out and 1 m back, far from the origin, turning across the wrap at pi; reckoned 2 cm
        // to the side and 0.1 rad off.
        let trace = moved(&[
            (pose(5.0, 0.0, 3.1), pose(5.0, 0.0, 3.1)),
            (pose(6.0, 0.0, -3.0), pose(6.0, -0.05, -3.0)),
            (pose(5.0, 0.0, -2.5), pose(5.0, 0.02, -2.4)),
        ]);
        let drifts = drift_of(&trace);
        let drift = drifts.ideal;
        let turned = std::f64::consts::TAU - 6.1 + 0.5;
        assert!((drifts.turned_rad - turned).abs() < 1e-14);
        assert_eq!(drifts.travelled_m, 2.0);
        assert_eq!((drift.m_per_m, drift.worst_m), (Some(0.01), Some(0.05)));
        // One subtraction near 2.5: 4e-16.
        assert!((drift.rad_per_m.unwrap() - 0.05).abs() < 1e-15);
        let per_turn = 0.1 * std::f64::consts::TAU / turned;
        assert!((drift.rad_per_turn.unwrap() - per_turn).abs() < 1e-14);
    }

    #[test]
    fn a_robot_that_stands_has_no_drift_per_metre() {
        let trace = moved(&[(Pose::default(), Pose::default()); 3]);
        let drift = drift_of(&trace).ideal;
        assert_eq!(
            (drift.final_m, drift.m_per_m, drift.rad_per_turn),
            (Some(0.0), None, None)
        );
        assert_eq!(drift_of(&moved(&[])), OdometryDrift::default());
    }
}
