//! Detects a motion of a robot whose wheels have another handedness than stated: swapped on the
//! robot, or in its file.
//!
//! With the other handedness, mecanum wheels drive ahead alike and rotate with another lever, the
//! difference of the arms instead of their sum. A lever fitted to such a motion would be wrong for
//! any robot.

use ilon_control::{handed, other_hands};
use ilon_robot::Robot;
use nalgebra::Matrix3xX;

use super::anomalies::{Anomaly, AnomalyKind, anomaly, shown};
use super::guess::Guess;
use crate::model::{Model, Parameter};
use crate::motion::Window;

/// Factors on rotations and translations this close belong to one robot.
const ALIKE: f64 = 0.1;
/// The stated robot is doubted if these factors differ by more than this.
const APART: f64 = 0.2;
/// Less total rotation than this shows no lever, in radians.
const LEAST_TURN_RAD: f64 = 0.5;

/// Whether a guess has the same factor on rotations and translations.
pub(super) fn turns_alike(guess: &Guess) -> bool {
    off(guess) < ALIKE
}

/// Returns the relative difference of a guess's factors on rotations and translations.
fn off(guess: &Guess) -> f64 {
    (guess.turn_scale / guess.scale - 1.0).abs()
}

/// Returns another handedness that explains a motion if the stated one does not: in translation, or
/// in the amount of rotation.
pub(super) fn of_motion(windows: &[&Window], robot: &Robot, stated: &Guess) -> Option<Anomaly> {
    let fits = stated.fits();
    let turned_rad: f64 = windows.iter().map(|window| window.seen[2].abs()).sum();
    if turned_rad < LEAST_TURN_RAD || (fits && off(stated) < APART) {
        return None;
    }
    let guess = |reversed: Vec<usize>| {
        let mut other = robot.clone();
        other.wheels = handed(&robot.wheels, &reversed);
        let lever_m = Parameter::Lever.nominal(&other);
        let matrix: Matrix3xX<f64> = Model::new(&other, &[]).ok()?.twist_matrix(&[])?;
        let guess = Guess::of(windows, &matrix, lever_m, false);
        let is_it = guess.fits() && turns_alike(&guess);
        is_it.then_some((reversed, guess, lever_m))
    };
    let guesses = other_hands(&robot.wheels).into_iter().filter_map(guess);
    let (reversed, guess, lever_m) =
        guesses.max_by(|(.., p, _), (.., q, _)| p.explained.total_cmp(&q.explained))?;
    let names: Vec<String> = reversed
        .iter()
        .map(|&wheel| format!("`{}`", robot.wheels[wheel].name))
        .collect();
    let stated_m = Parameter::Lever.nominal(robot);
    // In the X, the usual layout, the lever is the sum of the arms, and in the O their difference.
    let layout = match (
        reversed.len() == 4 && names.len() == robot.wheels.len(),
        lever_m < stated_m,
    ) {
        (true, true) => "the wheels stand in the O in place of the X: ",
        (true, false) => "the wheels stand in the X in place of the O: ",
        (false, _) => "",
    };
    Some(anomaly(
        AnomalyKind::Hands,
        true,
        format!(
            "the robot turns {} times as much as its wheels as stated turn it, and they explain {:.0} % of the motion; with the other handedness they explain {:.0} %",
            shown(stated.turn_scale / stated.scale),
            100.0 * stated.explained.max(0.0),
            100.0 * guess.explained
        ),
        format!(
            "likely {}{} stand on the wrong sides, on the robot or in its file: exchange left and right there, or change the sign of gamma. The lever of \
             turns is then {:.1} mm in place of {:.1} mm",
            layout,
            names.join(", "),
            1e3 * lever_m,
            1e3 * stated_m
        ),
    ))
}
