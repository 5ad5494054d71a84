//! Measured and predicted motion by direction.

use std::f64::consts::TAU;

use ilon_control::ContactKinematics;
use ilon_robot::Robot;
use nalgebra::{DVector, Matrix3xX};

use crate::motion::{Tracker, Window};
use crate::outcome::Direction;

/// Directions closer than this are one, in radians.
const APART_RAD: f64 = TAU / 48.0;
/// Speeds that differ by less than this share of the larger are one.
const SPEED_APART: f64 = 0.3;
/// Number of wheel angles over which the touching rollers are averaged.
const PHASES: usize = 512;

/// Windows of one direction and speed.
struct Bin {
    angle_rad: f64,
    way_m: f64,
    /// Total rotation of each wheel, in radians.
    turned_rad: Vec<f64>,
    /// For each window: the commanded distance, the distance along it and across, the same by the
    /// fitted model, and the residual rotation.
    members: Vec<[f64; 6]>,
}

/// Returns the motion of windows by direction. `nominal` is the robot's own map, `fitted` that of
/// the chosen model, and `trackers` has one entry per run.
pub fn directions(
    windows: &[&Window],
    robot: &Robot,
    nominal: &Matrix3xX<f64>,
    fitted: &Matrix3xX<f64>,
    trackers: &[Tracker],
    window_s: f64,
) -> Vec<Direction> {
    let mut bins = binned(windows, nominal, fitted, trackers);
    // Rare directions are the transitions between others.
    let most = bins.iter().map(|bin| bin.members.len()).max().unwrap_or(0);
    bins.retain(|bin| bin.members.len() * 20 >= most && bin.members.len() >= 2);
    bins.sort_by(|a, b| {
        let turn = |angle: f64| (angle + 1e-6).rem_euclid(TAU);
        turn(a.angle_rad)
            .total_cmp(&turn(b.angle_rad))
            .then(a.way_m.total_cmp(&b.way_m))
    });
    let of = |bin: &Bin| bin.direction(robot, nominal, window_s);
    bins.iter().map(of).collect()
}

/// Sorts the windows with translation by direction and speed.
fn binned(
    windows: &[&Window],
    nominal: &Matrix3xX<f64>,
    fitted: &Matrix3xX<f64>,
    trackers: &[Tracker],
) -> Vec<Bin> {
    let asked = windows.iter().map(|window| window.of_wheels(nominal));
    let asked: Vec<[f64; 3]> = asked.collect();
    let way = |asked: &[f64; 3]| libm::hypot(asked[0], asked[1]);
    let largest = asked.iter().map(way).fold(0.0, f64::max);
    let mut bins: Vec<Bin> = Vec::new();
    for (window, asked) in windows.iter().zip(&asked) {
        let way_m = way(asked);
        // Rotations on the spot have no direction.
        if way_m < 0.2 * largest {
            continue;
        }
        let angle_rad = libm::atan2(asked[1], asked[0]);
        let unit = [asked[0] / way_m, asked[1] / way_m];
        let seen = of_body(window, &trackers[window.run]);
        let given = window.of_wheels(fitted);
        let along = |way: [f64; 3]| way[0] * unit[0] + way[1] * unit[1];
        let across = |way: [f64; 3]| way[1] * unit[0] - way[0] * unit[1];
        let member = [
            way_m,
            along(seen),
            across(seen),
            along(given),
            across(given),
            seen[2] - given[2],
        ];
        let bin = bins.iter_mut().find(|bin| {
            let apart = ilon_robot::wrap_angle(bin.angle_rad - angle_rad).abs();
            apart < APART_RAD && (bin.way_m - way_m).abs() < SPEED_APART * bin.way_m.max(way_m)
        });
        match bin {
            Some(bin) => {
                bin.members.push(member);
                for (sum, turned) in bin.turned_rad.iter_mut().zip(&window.turned_rad) {
                    *sum += turned;
                }
            }
            None => bins.push(Bin {
                angle_rad,
                way_m,
                turned_rad: window.turned_rad.clone(),
                members: vec![member],
            }),
        }
    }
    bins
}

impl Bin {
    fn direction(&self, robot: &Robot, nominal: &Matrix3xX<f64>, window_s: f64) -> Direction {
        let members = &self.members;
        let count = members.len() as f64;
        let sum = |column: usize| members.iter().map(|row| row[column]).sum::<f64>();
        let way_m = sum(0);
        let measured = sum(1) / way_m;
        let left = members.iter().map(|row| row[1] - measured * row[0]);
        let squares: f64 = left.map(|left| left.powi(2)).sum();
        let rates = self.turned_rad.iter().map(|sum| sum / (count * window_s));
        let rates: Vec<f64> = rates.collect();
        let asked = nominal * DVector::from_column_slice(&rates);
        Direction {
            direction_deg: tidy(self.angle_rad.to_degrees().rem_euclid(360.0)),
            speed_m_s: way_m / (count * window_s),
            stretches: members.len(),
            measured,
            measured_error: (squares * count / (count - 1.0)).sqrt() / way_m,
            measured_across: sum(2) / way_m,
            contact: contact(robot, [asked[0], asked[1], 0.0], &rates),
            fitted: sum(3) / way_m,
            fitted_across: sum(4) / way_m,
            simulated: None,
            drift_rad_per_m: sum(5) / way_m,
        }
    }
}

/// Returns a direction rounded to a tenth of a degree, below a full turn.
fn tidy(degrees: f64) -> f64 {
    let rounded = (10.0 * degrees).round() / 10.0;
    if rounded >= 360.0 { 0.0 } else { rounded }
}

/// Returns the tracked displacement as the body's own displacement.
pub fn of_body(window: &Window, tracker: &Tracker) -> [f64; 3] {
    let (s, c) = libm::sincos(tracker.turned_rad);
    let [x, y, turn] = window.seen;
    let lever = 2.0 * libm::sin(0.5 * turn);
    let [o_x, o_y] = tracker.point_m;
    [
        c * x + s * y + lever * o_y,
        -s * x + c * y - lever * o_x,
        turn,
    ]
}

/// Returns the part of a twist that the touching rollers produce along it, averaged over wheel
/// angles; `None` if the rollers are unknown.
pub fn contact(robot: &Robot, asked: [f64; 3], rates: &[f64]) -> Option<f64> {
    let mut kinematics = ContactKinematics::new(robot).ok()?;
    let square: f64 = asked.iter().map(|part| part * part).sum();
    if square <= 0.0 {
        return None;
    }
    let mut along = 0.0;
    let mut angles = vec![0.0; rates.len()];
    for phase in 0..PHASES {
        // The wheels' angles are independent: steps by roots of primes fill all combinations
        // evenly.
        for (angle, root) in angles.iter_mut().zip(
            [2.0_f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0]
                .iter()
                .cycle(),
        ) {
            *angle = TAU * (phase as f64 * root.sqrt()).fract();
        }
        let twist = kinematics.twist(&angles, rates);
        along += twist.vx_m_s * asked[0] + twist.vy_m_s * asked[1] + twist.omega_rad_s * asked[2];
    }
    Some(along / PHASES as f64 / square)
}
