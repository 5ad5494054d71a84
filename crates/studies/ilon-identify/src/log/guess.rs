//! How well a map from wheel rates to twists explains a motion.

use nalgebra::Matrix3xX;

use crate::motion::Window;

/// The smallest share of a motion that the stated robot must explain.
pub(super) const EXPLAINED: f64 = 0.9;
/// Largest error of a tracker's heading before the wheels are doubted, in radians.
pub(super) const OFF_RAD: f64 = 0.4;
/// If rotation is a smaller part of the motion than this, it does not show its unit.
pub(super) const TURNS: f64 = 0.05;

/// Where the robot turned by less in all stretches together, as the root of the sum of squares, it
/// may be drift.
const LEAST_TURN_RAD: f64 = 0.5;
/// Where the wheels ask for a smaller share of the squares of the turns, the rest is drift. Chosen.
const LEAST_ASKED: f64 = 0.1;
/// Turns by the wheels and those of the robot contradict each other where their correlation is more
/// negative than this. Chosen.
const ALIKE: f64 = 0.5;

/// How well a map from wheel rates to twists explains a motion, up to its scale, the tracker's
/// direction and its position.
pub(super) struct Guess {
    /// The explained share of the motion.
    pub(super) explained: f64,
    /// Fitted factor on the displacements by the wheels.
    pub(super) scale: f64,
    /// Fitted angle of the tracker's direction against the body's.
    pub(super) turned_rad: f64,
    /// Fitted factor on the rotations by the wheels.
    pub(super) turn_scale: f64,
    /// Share of rotation in the motion, each over its own scale.
    pub(super) turns: f64,
    /// Whether the robot turns to the other side than by the wheels.
    pub(super) turns_back: bool,
}

impl Guess {
    /// Whether the robot moves and turns as by the wheels.
    pub(super) fn fits(&self) -> bool {
        self.explained >= EXPLAINED && self.turned_rad.abs() <= OFF_RAD && !self.turns_back
    }

    pub(super) fn of(
        windows: &[&Window],
        matrix: &Matrix3xX<f64>,
        lever_m: f64,
        mirrored: bool,
    ) -> Self {
        // Displacements as complex numbers: seen = c wheels + i l o, with c the scale and the
        // direction, o the tracked point and l twice the sine of half the rotation. Normal
        // equations of c and o, both complex.
        let flip = if mirrored { -1.0 } else { 1.0 };
        let (mut ww, mut ll, mut wl) = (0.0, 0.0, [0.0; 2]);
        let (mut ws, mut ls) = ([0.0; 2], [0.0; 2]);
        let (mut ss, mut tt, mut ts, mut turned) = (0.0, 0.0, 0.0, 0.0);
        for window in windows {
            // A mirrored tracker also mirrors headings, with which the steps of the wheels were
            // rotated.
            let moved = mirror(window, flip).of_wheels(matrix);
            let seen = [window.seen[0], flip * window.seen[1], flip * window.seen[2]];
            let l = 2.0 * libm::sin(0.5 * seen[2]);
            // i l, times the conjugate of the wheels'.
            ww += moved[0] * moved[0] + moved[1] * moved[1];
            ll += l * l;
            wl[0] += l * moved[1];
            wl[1] += l * moved[0];
            ws[0] += moved[0] * seen[0] + moved[1] * seen[1];
            ws[1] += moved[0] * seen[1] - moved[1] * seen[0];
            ls[0] += l * seen[1];
            ls[1] += -l * seen[0];
            ss += seen[0] * seen[0] + seen[1] * seen[1];
            tt += moved[2] * moved[2];
            ts += moved[2] * seen[2];
            turned += seen[2] * seen[2];
        }
        // [ww, wl; conj(wl), ll] [c; o] = [ws; ls]; without turns the point is not seen.
        let cross = wl[0] * wl[0] + wl[1] * wl[1];
        let determinant = ww * ll - cross;
        let c = if ll > 1e-9 && determinant > 1e-9 * ww * ll {
            let times = [wl[0] * ls[0] - wl[1] * ls[1], wl[0] * ls[1] + wl[1] * ls[0]];
            [
                (ll * ws[0] - times[0]) / determinant,
                (ll * ws[1] - times[1]) / determinant,
            ]
        } else {
            [ws[0] / ww, ws[1] / ww]
        };
        let o = match ll > 1e-9 {
            true => [
                (ls[0] - (wl[0] * c[0] + wl[1] * c[1])) / ll,
                (ls[1] - (wl[0] * c[1] - wl[1] * c[0])) / ll,
            ],
            false => [0.0; 2],
        };
        let explained_planar = c[0] * ws[0] + c[1] * ws[1] + o[0] * ls[0] + o[1] * ls[1];
        let scale = libm::hypot(c[0], c[1]);
        let turn_scale = if tt > 0.0 { ts / tt } else { 0.0 };
        let turns = tt * lever_m * lever_m / (ww + tt * lever_m * lever_m);
        // If the wheels demand no rotation, the measured one is drift and has no scale of its own.
        let turn_size = if turns > TURNS && turn_scale.abs() > 0.0 {
            turn_scale.abs()
        } else {
            scale
        };
        let left_planar = (ss - explained_planar).max(0.0) / (scale * scale);
        // Rotations in the wrong direction explain nothing.
        let explained_turn = if turn_scale > 0.0 {
            ts * turn_scale
        } else {
            0.0
        };
        let left_turn = (turned - explained_turn).max(0.0) * (lever_m / turn_size).powi(2);
        let all_planar = ss / (scale * scale);
        let all_turn = turned * (lever_m / turn_size).powi(2);
        let all = all_planar + all_turn;
        Self {
            explained: 1.0 - (left_planar + left_turn) / all,
            scale,
            turned_rad: libm::atan2(c[1], c[0]),
            turn_scale,
            turns,
            turns_back: turned > LEAST_TURN_RAD.powi(2)
                && tt > LEAST_ASKED * turned
                && ts < -ALIKE * (tt * turned).sqrt(),
        }
    }
}

/// Returns the steps of the wheels rotated by a tracker of the other handedness.
fn mirror(window: &Window, flip: f64) -> Window {
    let mut mirrored = window.clone();
    mirrored.sin_rad.iter_mut().for_each(|sin| *sin *= flip);
    mirrored
}
