//! Fits the parameters of the law, each to drives of its own kind.

use std::f64::consts::TAU;

use ilon_robot::Robot;
use nalgebra::{Matrix3, Vector3};

use super::drives::{PlanarDrive, Track};
use super::model::{Law, error, poses, taken};
use super::{DirectionShortfall, Grip, HeldOut, Lag, Planar, Shortfall};
use crate::Error;
use crate::scenario::Scenario;

/// Number of directions of steady drives; chosen.
const DIRECTIONS: usize = 12;
/// Number of pseudo-random drives that are fitted to; the others judge the fit. Chosen.
const FITTED: usize = 6;
const HELD_OUT: usize = 6;
/// Length of each of them, in the robot's units of time; a wheel of 50 mm has 14 units per second.
/// Chosen.
const CHANCE_UNITS: f64 = 70.0;
/// Time over which the model's error is taken as drift, in the robot's units; chosen.
const DRIFT_UNITS: f64 = 14.0;

/// Fits a planar base to a robot with the floor, motors and wheel loops of a scenario. Returns also
/// the drives that it was judged by, and their step in seconds. The robot is as
/// [`load_robot`](crate::simulate::load_robot) returns it.
///
/// # Errors
/// If the scenario or the robot is invalid, or if the robot does not follow its commands.
pub fn fit(scenario: &Scenario, robot: &Robot) -> Result<(Planar, Vec<PlanarDrive>, f64), Error> {
    if let Some(wheel) = robot
        .wheels
        .iter()
        .find(|wheel| wheel.has_tyre() && !robot.swivels(wheel))
    {
        return Err(Error::invalid(
            format!(
                "a planar base moves alike along all three axes, and the tyre of `{}` holds the robot sideways or must be steered first",
                wheel.name
            ),
            "fit robots on rollers; simulate others themselves, with Python or the C library",
        ));
    }
    let track = Track::new(scenario, robot)?;
    let starts = starts(&track)?;
    let grip = grip(&track, &starts)?;
    let most = Vector3::from(grip.most);
    let shortfall = shortfall(&track, most)?;
    let matrix = Matrix3::from_fn(|row, column| shortfall.matrix[row][column]);
    let lag = lag(&track, &matrix, most)?;
    let proportional_per_s = Vector3::from(lag.proportional_per_s);
    let law = Law {
        shortfall: matrix,
        proportional_per_s,
        integral_per_s2: Vector3::from(lag.integral_per_s2),
        most,
        exponent: grip.exponent,
        step_s: step_s(&track, proportional_per_s.max()),
    };
    let by_chance = |number| track.drive(track.by_chance(number, CHANCE_UNITS));
    let fitted: Vec<PlanarDrive> = (0..FITTED).map(by_chance).collect::<Result<_, _>>()?;
    let judges = FITTED..FITTED + HELD_OUT;
    let judges: Vec<PlanarDrive> = judges.map(by_chance).collect::<Result<_, _>>()?;
    let dt_s = track.dt_s;
    let planar = Planar {
        robot: robot.name.clone(),
        friction: track.plant().floor_friction(),
        wheel_rate_rad_s: track.wheel_rate_rad_s,
        top: track.tops().into(),
        step_s: law.step_s,
        drift_covariance_per_s: drift(&track, &fitted, &law),
        shortfall,
        grip,
        lag,
        held_out: HeldOut {
            drives: HELD_OUT,
            duration_s: track.steps(CHANCE_UNITS) as f64 * dt_s,
            model: error(&judges, dt_s, |asked| law.follow(asked, dt_s)),
            ideal: error(&judges, dt_s, <[_]>::to_vec),
        },
    };
    Ok((planar, judges, dt_s))
}

/// Directions in twist space, in shares of the top speed along each axis: translations all around,
/// turns, and combinations of both.
fn ways() -> Vec<Vector3<f64>> {
    let around = (0..DIRECTIONS).map(|k| TAU * k as f64 / DIRECTIONS as f64);
    let level = around.map(|angle| Vector3::new(libm::cos(angle), libm::sin(angle), 0.0));
    let turns = [1.0, -1.0].map(|sign| Vector3::new(0.0, 0.0, sign));
    let both = [
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
        [-1.0, 0.0, 1.0],
        [0.0, -1.0, 1.0],
    ];
    let both = both.map(|way| Vector3::from(way).normalize());
    level.chain(turns).chain(both).collect()
}

/// Mean accelerations of starts at the fastest command, until half of it is reached.
fn starts(track: &Track) -> Result<Vec<Vector3<f64>>, Error> {
    /// Longest start. At friction 0.01 a robot needs 150 units to reach its commanded speed.
    const LONGEST_UNITS: f64 = 400.0;
    let tops = track.tops();
    let start = |way: Vector3<f64>| {
        let asked = track.fastest(way.component_mul(&tops));
        let mut plant = track.plant();
        for step in 1..=track.steps(LONGEST_UNITS) {
            let came = track.step(&mut plant, asked)?;
            if came.component_div(&tops).norm() >= 0.5 * asked.component_div(&tops).norm() {
                return Ok(came / (step as f64 * track.dt_s));
            }
        }
        Err(Error::invalid(
            format!(
                "commanded {:.2} m/s ahead, {:.2} m/s to the left and {:.2} rad/s, the robot does not reach half of it",
                asked.x, asked.y, asked.z
            ),
            "a base is fitted to a robot that follows its commands: give its floor more friction, or its motors more torque",
        ))
    };
    ways().into_iter().map(start).collect()
}

/// Fits the acceleration limits to starts.
fn grip(track: &Track, starts: &[Vector3<f64>]) -> Result<Grip, Error> {
    let tops = track.tops();
    // The sum of X_i |a_i|^p = 1 is linear in X = most^-p. Divided by the top speeds, all axes have
    // the same scale.
    let of_exponent = |p: f64| {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for start in starts {
            let row = start.component_div(&tops).map(|a| libm::pow(a.abs(), p));
            // Gives small accelerations the same weight as large ones.
            let weight = 1.0 / row.sum();
            normal += weight * weight * row * row.transpose();
            right += weight * weight * row;
        }
        let x = normal.cholesky()?.solve(&right);
        x.iter().all(|x| *x > 0.0).then_some(())?;
        let most = x.map(|x| libm::pow(x, -1.0 / p)).component_mul(&tops);
        let squares = starts.iter().map(|a| {
            let off = taken(*a, most, p) - 1.0;
            off * off
        });
        let off = libm::sqrt(squares.sum::<f64>() / starts.len() as f64);
        Some((most, p, off))
    };
    let candidates = (10..=40).filter_map(|tenths| of_exponent(f64::from(tenths) / 10.0));
    let best = candidates.min_by(|a, b| a.2.total_cmp(&b.2));
    let (Some((most, exponent, fit_error)), Some((ellipse, _, ellipse_fit_error))) =
        (best, of_exponent(2.0))
    else {
        return Err(Error::invalid(
            "the robot's accelerations make no ellipse",
            "a base that is fitted must move along all three axes, alike in all directions that are opposite",
        ));
    };
    Ok(Grip {
        most: most.into(),
        exponent,
        fit_error,
        ellipse: ellipse.into(),
        ellipse_fit_error,
    })
}

/// Fits the reached share of a commanded twist to steady drives.
fn shortfall(track: &Track, most: Vector3<f64>) -> Result<Shortfall, Error> {
    /// Settling time after the start, and the time over which the mean is taken: several turns of
    /// the wheels.
    const SETTLED_UNITS: f64 = 8.0;
    const MEASURED_UNITS: f64 = 30.0;
    const SHARE: f64 = 0.6;
    let tops = track.tops();
    let settled = track.steps(SETTLED_UNITS);
    let measured = track.steps(MEASURED_UNITS);
    let (mut normal, mut right) = (Matrix3::zeros(), Matrix3::zeros());
    let mut pairs = Vec::new();
    for way in ways() {
        let asked = track.fastest(way.component_mul(&tops)) * SHARE;
        let start_s = 2.0 * taken(asked, most, 1.0);
        let start = settled + (start_s / track.dt_s).ceil() as usize;
        let drive = track.drive(vec![asked; start + measured])?;
        let came = drive.came[start..].iter().sum::<Vector3<f64>>() / measured as f64;
        let (asked, came) = (asked.component_div(&tops), came.component_div(&tops));
        normal += asked * asked.transpose();
        right += came * asked.transpose();
        pairs.push((asked, came));
    }
    let Some(inverse) = normal.try_inverse() else {
        return Err(Error::invalid(
            "the robot cannot be driven along all three axes",
            "give it wheels that can",
        ));
    };
    let relative = right * inverse;
    let off = pairs.iter().map(|(u, v)| (relative * u - v).amax());
    let fit_error = off.fold(0.0, f64::max);
    let scale = Matrix3::from_diagonal(&tops);
    let unscale = Matrix3::from_diagonal(&tops.map(|top| 1.0 / top));
    let matrix = scale * relative * unscale;
    let by_direction = pairs.iter().take(DIRECTIONS).enumerate();
    let by_direction = by_direction.map(|(k, (asked, came))| {
        let [asked, came] = [asked, came].map(|v| v.component_mul(&tops).xy());
        let speed = asked.norm();
        let way = asked / speed;
        DirectionShortfall {
            direction_deg: 360.0 * k as f64 / DIRECTIONS as f64,
            missing: 1.0 - came.dot(&way) / speed,
            aside: way.perp(&came) / speed,
        }
    });
    Ok(Shortfall {
        by_direction: by_direction.collect(),
        matrix: matrix.transpose().into(),
        fit_error,
    })
}

/// Fits the gains of the law to starts within the acceleration limits.
fn lag(track: &Track, shortfall: &Matrix3<f64>, most: Vector3<f64>) -> Result<Lag, Error> {
    const TRIAL: f64 = 0.01;
    const SHARE_OF_GRIP: f64 = 0.3;
    const UNITS: f64 = 4.0;
    // At least 40 samples, for two gains.
    let steps = track.steps(UNITS).max(40);
    let mut lag = Lag {
        proportional_per_s: [0.0; 3],
        integral_per_s2: [0.0; 3],
        fit_error: [0.0; 3],
    };
    for axis in 0..3 {
        let way = track.fastest(Vector3::ith(axis, 1.0));
        let trial = track.drive(vec![way * TRIAL; steps])?;
        let (mut before, mut hardest) = (0.0, f64::MIN_POSITIVE);
        for came in &trial.came {
            hardest = f64::max(hardest, (came[axis] - before) / track.dt_s);
            before = came[axis];
        }
        let share = (TRIAL * SHARE_OF_GRIP * most[axis] / hardest).min(0.5);
        let drive = track.drive(vec![way * share; steps])?;
        let off = |proportional_per_s: f64, over_square: f64| {
            let integral_per_s2 = over_square * proportional_per_s * proportional_per_s;
            let law = Law {
                shortfall: *shortfall,
                proportional_per_s: Vector3::ith(axis, proportional_per_s),
                integral_per_s2: Vector3::ith(axis, integral_per_s2),
                most: Vector3::repeat(f64::MAX),
                exponent: 1.0,
                step_s: step_s(track, proportional_per_s),
            };
            let followed = law.follow(&drive.asked, track.dt_s);
            let pairs = followed.iter().zip(&drive.came);
            let squares = pairs.map(|(followed, came)| {
                let off = (followed[axis] - came[axis]) / drive.asked[0][axis];
                off * off
            });
            libm::sqrt(squares.sum::<f64>() / steps as f64)
        };
        let (gains, error) = least(off, track.unit_s);
        lag.proportional_per_s[axis] = gains[0];
        lag.integral_per_s2[axis] = gains[1] * gains[0] * gains[0];
        lag.fit_error[axis] = error;
    }
    Ok(lag)
}

/// The longest integration step for a gain: a quarter of its time constant.
fn step_s(track: &Track, proportional_per_s: f64) -> f64 {
    track.dt_s.min(0.25 / proportional_per_s)
}

/// Minimises over the proportional gain, in 1/s, and the integral gain over its square, on a grid
/// that is refined in rounds.
fn least(of: impl Fn(f64, f64) -> f64, unit_s: f64) -> ([f64; 2], f64) {
    /// From far slower to far faster than any wheel loop, in the robot's units.
    const GAINS: [f64; 2] = [0.2, 100.0];
    /// Critical damping is at a quarter.
    const MOST_OVER_SQUARE: f64 = 1.0;
    const POINTS: usize = 12;
    const ROUNDS: usize = 5;
    let mut logs = GAINS.map(|gain| libm::log(gain / unit_s));
    let mut shares = [0.0, MOST_OVER_SQUARE];
    let mut best = ([1.0 / unit_s, 0.0], f64::INFINITY);
    for _ in 0..ROUNDS {
        let at = |[from, to]: [f64; 2], k: usize| from + (to - from) * k as f64 / POINTS as f64;
        for row in 0..=POINTS {
            for column in 0..=POINTS {
                let gains = [libm::exp(at(logs, row)), at(shares, column)];
                let found = of(gains[0], gains[1]);
                if found < best.1 {
                    best = (gains, found);
                }
            }
        }
        let around = |middle: f64, [from, to]: [f64; 2]| {
            let half = (to - from) / 6.0;
            [middle - half, middle + half]
        };
        logs = around(libm::log(best.0[0]), logs);
        shares = around(best.0[1], shares).map(|share| share.max(0.0));
    }
    best
}

/// The covariance of the pose error that grows per second of pseudo-random drives.
fn drift(track: &Track, drives: &[PlanarDrive], law: &Law) -> [[f64; 3]; 3] {
    let dt_s = track.dt_s;
    let window = track.steps(DRIFT_UNITS);
    let (mut sum, mut time_s) = (Matrix3::zeros(), 0.0);
    for drive in drives {
        let modelled = law.follow(&drive.asked, dt_s);
        for (modelled, came) in modelled.chunks(window).zip(drive.came.chunks(window)) {
            let [modelled, came] = [modelled, came].map(|twists| poses(twists, dt_s).pop());
            let off = modelled.unwrap_or_default() - came.unwrap_or_default();
            sum += off * off.transpose();
        }
        time_s += drive.came.len() as f64 * dt_s;
    }
    // Symmetric, so that row and column order agree.
    (sum / time_s).into()
}
