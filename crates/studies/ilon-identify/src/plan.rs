//! Plans a short course that determines the free parameters: drives there and back, added while
//! they raise the smallest singular value of the expected measurements.

use std::fmt::Write;

use ilon_control::Kinematics;
use ilon_robot::{Pose, Robot, Twist};
use ilon_sim::Error;
use nalgebra::{DMatrix, SymmetricEigen};
use serde::Serialize;

use crate::kinematic_fit::{Evidence, Noise, residuals};
use crate::log::Log;
use crate::model::{Model, is_held};
use crate::motion::windows;

/// Assumed noise of displacements over a second: a millimetre and a milliradian.
const SEEN: Noise = Noise {
    position_m: 1e-3,
    heading_rad: 1e-3,
};
/// Duration of each half of a drive there and back, in seconds.
const WAY_S: f64 = 5.0;
/// Rest between two drives, in seconds.
const REST_S: f64 = 1.0;
/// Time between rows, in seconds.
const ROW_S: f64 = 0.05;
/// Largest number of drives there and back.
const MOST: usize = 5;

/// A drive at a constant twist.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Way {
    /// vx and vy in m/s and omega in rad/s, in the body frame.
    pub twist: [f64; 3],
    /// Duration, in seconds.
    pub for_s: f64,
}

/// A course and the parameters that it determines.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// The drives in order; the robot stands for a second between two of them.
    pub ways: Vec<Way>,
    /// The planned parameters, each with the expected standard error of the course at a noise of a
    /// millimetre and a milliradian over a second.
    pub errors: Vec<(String, f64)>,
    /// The smallest singular value of the measurements, each parameter over its expected deviation.
    pub least_singular_value: f64,
    /// The wheels' rates over time, in the format of `[playback]`.
    #[serde(skip)]
    pub wheel_rates_csv: String,
    /// The robot's poses over time, in the format of `[reference.waypoints]`.
    #[serde(skip)]
    pub waypoints_csv: String,
}

/// Plans a course for a robot at a speed, in m/s, that determines these parameters of its
/// kinematics, and the tracker's point.
///
/// # Errors
/// A robot that cannot move in all directions, an unknown parameter, and parameters that no course
/// distinguishes.
pub fn plan(robot: &Robot, free: &[String], speed_m_s: f64) -> Result<Plan, Error> {
    if !(speed_m_s.is_finite() && speed_m_s > 0.0 && speed_m_s <= 10.0) {
        return Err(Error::invalid(
            format!("a course cannot be driven at {speed_m_s} m/s"),
            "give a speed above 0 and up to 10 m/s",
        ));
    }
    let tracker = ["x_m", "y_m", "heading_deg"].map(str::to_owned);
    let model = Model::new(robot, free)?.with_tracker(&tracker, &[String::new()]);
    let kinematics = Kinematics::new(robot)?;
    let turn = speed_m_s / crate::model::Parameter::Lever.nominal(robot).max(0.05);
    let diagonal = speed_m_s * std::f64::consts::FRAC_1_SQRT_2;
    let candidates = [
        [speed_m_s, 0.0, 0.0],
        [0.0, speed_m_s, 0.0],
        [0.0, 0.0, turn],
        [diagonal, diagonal, 0.0],
        [diagonal, -diagonal, 0.0],
        [speed_m_s, 0.0, 0.5 * turn],
        [0.0, speed_m_s, 0.5 * turn],
    ];
    let mut candidates = candidates.to_vec();
    if is_held(robot) {
        candidates.retain(|[_, sideways, _]| *sideways == 0.0);
    }
    let information: Vec<DMatrix<f64>> = candidates
        .iter()
        .map(|twist| information(&model, &kinematics, &there_and_back(*twist)))
        .collect::<Result<_, _>>()?;
    let count = model.parameters.len();
    let mut sum = DMatrix::<f64>::zeros(count, count);
    let mut ways: Vec<Way> = Vec::new();
    let least = |matrix: &DMatrix<f64>| {
        let values = SymmetricEigen::new(matrix.clone()).eigenvalues;
        values.min().max(0.0).sqrt()
    };
    // Until all parameters are visible, the least visible one counts, as if each were known a
    // little beforehand.
    let ridge = DMatrix::<f64>::identity(count, count);
    for _ in 0..MOST {
        let gained = |index: &usize| least(&(&sum + &information[*index] + &ridge));
        let Some(best) = (0..candidates.len()).max_by(|a, b| gained(a).total_cmp(&gained(b)))
        else {
            break;
        };
        let (before, after) = (least(&(&sum + &ridge)), gained(&best));
        if !ways.is_empty() && after < 1.02 * before && least(&sum) > 1.0 {
            break;
        }
        sum += &information[best];
        ways.extend(there_and_back(candidates[best]));
    }
    let least_singular_value = least(&sum);
    let scales = model.scales();
    if least_singular_value < 1.0 {
        let eigen = SymmetricEigen::new(sum.clone());
        let which = (0..count)
            .min_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]))
            .unwrap_or(0);
        let names = model.names();
        let alike: Vec<&str> = (0..count)
            .filter(|axis| eigen.eigenvectors[(*axis, which)].abs() > 0.2)
            .map(|axis| names[axis].as_str())
            .collect();
        return Err(Error::invalid(
            format!("no course tells {} apart", alike.join(" and ")),
            "leave one of them out, and measure it by hand",
        ));
    }
    let inverse = sum
        .try_inverse()
        .ok_or_else(|| Error::invalid("no course determines all of that", "leave something out"))?;
    let errors = model
        .names()
        .into_iter()
        .enumerate()
        .map(|(axis, name)| (name, scales[axis] * inverse[(axis, axis)].max(0.0).sqrt()))
        .collect();
    let log = drive(&kinematics, &ways);
    Ok(Plan {
        errors,
        least_singular_value,
        wheel_rates_csv: wheel_rates(robot, &kinematics, &ways),
        waypoints_csv: waypoints(&log),
        ways,
    })
}

fn there_and_back(twist: [f64; 3]) -> [Way; 2] {
    [1.0, -1.0].map(|sign| Way {
        twist: twist.map(|rate| sign * rate),
        for_s: WAY_S,
    })
}

/// Returns the information matrix of drives, each parameter over its expected deviation.
fn information(
    model: &Model,
    kinematics: &Kinematics,
    ways: &[Way],
) -> Result<DMatrix<f64>, Error> {
    let log = drive(kinematics, ways);
    let evidence = Evidence::of([windows(&log, 0, 1.0)]);
    let all = evidence.all();
    let nominal = model.nominal();
    let mut columns = Vec::new();
    for (axis, scale) in model.scales().iter().enumerate() {
        let side = |by: f64| {
            let mut values = nominal.clone();
            values[axis] += by * scale;
            residuals(model, &values, &all, &evidence, SEEN).ok_or_else(|| {
                Error::invalid(
                    "this robot cannot move in all three directions (ahead, sideways, turn)",
                    "see `ilon inspect`",
                )
            })
        };
        let (below, above) = (side(-1e-3)?, side(1e-3)?);
        let column: Vec<f64> = below
            .iter()
            .zip(&above)
            .map(|(a, b)| (b - a) / 2e-3)
            .collect();
        columns.push(nalgebra::DVector::from_vec(column));
    }
    let jacobian = DMatrix::from_columns(&columns);
    Ok(jacobian.transpose() * jacobian)
}

/// Returns the log of these drives for a robot that follows its wheels exactly.
fn drive(kinematics: &Kinematics, ways: &[Way]) -> Log {
    let mut log = Log::default();
    let mut pose = Pose::default();
    let mut rates = vec![0.0; kinematics.wheel_count()];
    let mut angles = vec![0.0; kinematics.wheel_count()];
    let mut push = |pose: &Pose, angles: &[f64]| {
        log.times_s.push(log.times_s.len() as f64 * ROW_S);
        log.angles_rad.push(angles.to_vec());
        log.poses.push([pose.x_m, pose.y_m, pose.heading_rad]);
        log.unseen.push(false);
    };
    push(&pose, &angles);
    for way in ways {
        let [vx, vy, omega] = way.twist;
        for twist in [way.twist, [0.0; 3]] {
            let for_s = if twist == [vx, vy, omega] {
                way.for_s
            } else {
                REST_S
            };
            let asked = kinematics.reachable(Twist::new(twist[0], twist[1], twist[2]));
            kinematics.wheel_rates(asked, &mut rates);
            for _ in 0..(for_s / ROW_S).round() as usize {
                let heading_rad = pose.heading_rad + twist[2] * ROW_S;
                pose = pose.moved(asked.scaled(ROW_S));
                pose.heading_rad = heading_rad;
                angles
                    .iter_mut()
                    .zip(&rates)
                    .for_each(|(angle, rate)| *angle += rate * ROW_S);
                push(&pose, &angles);
            }
        }
    }
    log
}

fn wheel_rates(robot: &Robot, kinematics: &Kinematics, ways: &[Way]) -> String {
    let mut csv = "t_s".to_owned();
    for wheel in &robot.wheels {
        // Writing to a string cannot fail.
        let _ = write!(csv, ",{}_rate_rad_s", wheel.name);
    }
    csv.push('\n');
    let mut rates = vec![0.0; kinematics.wheel_count()];
    let mut t_s = 0.0;
    for way in ways {
        for (twist, for_s) in [(way.twist, way.for_s), ([0.0; 3], REST_S)] {
            kinematics.wheel_rates(Twist::new(twist[0], twist[1], twist[2]), &mut rates);
            let _ = write!(csv, "{t_s}");
            for rate in &rates {
                let _ = write!(csv, ",{rate:.5}");
            }
            csv.push('\n');
            t_s += for_s;
        }
    }
    csv
}

fn waypoints(log: &Log) -> String {
    let mut csv = "t_s,x_m,y_m,heading_deg\n".to_owned();
    for row in (0..log.len()).step_by((0.5 / ROW_S) as usize) {
        let [x, y, heading] = log.poses[row];
        let _ = writeln!(
            csv,
            "{:.2},{x:.4},{y:.4},{:.3}",
            log.times_s[row],
            heading.to_degrees()
        );
    }
    csv
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    /// Radius and lever of a mecanum robot: a drive ahead determines the first and a rotation the
    /// second. Each drive returns to its start, and a rotation moves the rims as fast as a drive
    /// ahead.
    #[test]
    fn a_course_ends_where_it_began_and_tells_enough() {
        let urdf = include_str!("../../../../assets/robots/mecanum4.urdf");
        let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
        let free = ["radius_m", "lever_m"].map(str::to_owned);
        let plan = plan(&robot, &free, 0.2).unwrap();
        assert!(plan.least_singular_value > 1.0, "{plan:?}");
        assert!(plan.ways.len() <= 2 * MOST, "{plan:?}");
        for axis in 0..3 {
            let went: f64 = plan
                .ways
                .iter()
                .map(|way| way.twist[axis] * way.for_s)
                .sum();
            assert!(went.abs() < 1e-12, "{plan:?}");
        }
        let at = robot.wheels[0].position_m();
        let lever_m = at.x.abs() + at.y.abs();
        let turns = plan.ways.iter().filter(|way| way.twist[..2] == [0.0; 2]);
        for turn in turns.clone() {
            assert!(
                (turn.twist[2].abs() * lever_m - 0.2).abs() < 1e-6,
                "{turn:?}"
            );
        }
        assert!(turns.count() >= 2, "{plan:?}");
    }
}
