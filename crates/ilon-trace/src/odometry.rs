//! How far dead reckoning from the wheel rates strays from the truth.

use ilon_robot::{Pose, wrap_angle};
use serde::{Deserialize, Serialize};

use crate::record::Record;
use crate::trace::Trace;

/// Below this way, in metres, a drift per metre says nothing.
const SHORTEST_WAY_M: f64 = 0.01;
/// Below this turn, in radians, a drift per turn says nothing.
const LEAST_TURN_RAD: f64 = 0.1;

/// How far one way of dead reckoning strays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// Distance from the reckoned to the true position at the end, in metres.
    pub final_m: Option<f64>,
    /// Reckoned minus true heading at the end, in radians.
    pub final_rad: Option<f64>,
    /// The largest distance at any time, in metres.
    pub worst_m: Option<f64>,
    /// The distance at the end over the way travelled; `None` where the robot hardly moved.
    pub m_per_m: Option<f64>,
    /// The heading's error at the end over the way travelled, in rad/m, signed.
    pub rad_per_m: Option<f64>,
    /// The heading's error at the end per full turn of the robot, in radians, signed; `None` where it hardly turned.
    pub rad_per_turn: Option<f64>,
}

/// Length of the way that the body's origin really travelled, in metres.
pub fn travelled_m(trace: &Trace) -> f64 {
    pairs(trace)
        .map(|(a, b)| (b.position_m() - a.position_m()).norm())
        .sum()
}

/// How much the robot really turned, back and forth both counted, in radians.
pub fn turned_rad(trace: &Trace) -> f64 {
    pairs(trace)
        .map(|(a, b)| wrap_angle(b.heading_rad - a.heading_rad).abs())
        .sum()
}

/// The drift of dead reckoning by Indiveri 2009, eq. (7).
pub fn ideal_drift(trace: &Trace) -> Drift {
    drift(trace, |record| record.odometry_ideal)
}

/// The drift of dead reckoning by the contact kinematics.
pub fn contact_drift(trace: &Trace) -> Drift {
    drift(trace, |record| record.odometry_contact)
}

/// True poses of neighbouring records.
fn pairs(trace: &Trace) -> impl Iterator<Item = (Pose, Pose)> {
    trace
        .records()
        .windows(2)
        .map(|pair| (pair[0].truth.pose, pair[1].truth.pose))
}

fn drift(trace: &Trace, reckoned: impl Fn(&Record) -> Pose) -> Drift {
    let away_m = |r: &Record| (reckoned(r).position_m() - r.truth.pose.position_m()).norm();
    let Some(last) = trace.records().last() else {
        return Drift::default();
    };
    let final_m = away_m(last);
    let final_rad = wrap_angle(reckoned(last).heading_rad - last.truth.pose.heading_rad);
    let way_m = travelled_m(trace);
    let turn_rad = turned_rad(trace);
    let moved = way_m >= SHORTEST_WAY_M;
    Drift {
        final_m: Some(final_m),
        final_rad: Some(final_rad),
        worst_m: trace.records().iter().map(away_m).reduce(f64::max),
        m_per_m: moved.then(|| final_m / way_m),
        rad_per_m: moved.then(|| final_rad / way_m),
        rad_per_turn: (turn_rad >= LEAST_TURN_RAD)
            .then(|| final_rad / (turn_rad / std::f64::consts::TAU)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::Header;

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
        // 1 m out and 1 m back, turned by half a turn across the cut at pi; reckoned 2 cm to the side and 0.1 rad off.
        let trace = moved(&[
            (pose(0.0, 0.0, 3.0), pose(0.0, 0.0, 3.0)),
            (pose(1.0, 0.0, -3.0), pose(1.0, 0.0, -3.0)),
            (pose(0.0, 0.0, -2.5), pose(0.0, 0.02, -2.4)),
        ]);
        let drift = ideal_drift(&trace);
        let turned = std::f64::consts::TAU - 6.0 + 0.5;
        assert!((turned_rad(&trace) - turned).abs() < 1e-14);
        assert_eq!(travelled_m(&trace), 2.0);
        assert_eq!(drift.m_per_m, Some(0.01));
        // One subtraction near 2.5: 4e-16.
        assert!((drift.rad_per_m.unwrap() - 0.05).abs() < 1e-15);
        let per_turn = 0.1 * std::f64::consts::TAU / turned;
        assert!((drift.rad_per_turn.unwrap() - per_turn).abs() < 1e-14);
    }

    #[test]
    fn a_robot_that_stands_has_no_drift_per_metre() {
        let trace = moved(&[(Pose::default(), Pose::default()); 3]);
        let drift = ideal_drift(&trace);
        assert_eq!(
            (drift.final_m, drift.m_per_m, drift.rad_per_turn),
            (Some(0.0), None, None)
        );
        assert_eq!(ideal_drift(&moved(&[])), Drift::default());
    }
}
