//! How a world is built and stepped. Every default is the outcome of the measurements in `docs/accuracy.md`.

use ilon_robot::Robot;

/// Which rollers are rigid bodies of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RollerBodies {
    /// Every roller, always.
    #[default]
    All,
    /// The contact window: every roller keeps its place and spin, and those that can touch the ground have a body.
    Near,
}

/// Numerical settings of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Length of one physics step, in seconds, > 0.
    pub dt_s: f64,
    /// Which rollers are bodies.
    pub roller_bodies: RollerBodies,
    /// Natural frequency of a contact's spring, in Hz, > 0: how fast penetration is pushed out. It scales with the
    /// mass at the contact; at 1000 Hz a 10 kg robot sinks by less than a micrometre.
    pub contact_frequency_hz: f64,
    /// Damping ratio of a contact's spring, dimensionless, > 0.
    pub contact_damping_ratio: f64,
    /// Gauss-Seidel sweeps over the contacts of one step, >= 1; see [`Settings::sweeps_for`].
    pub sweeps: usize,
    /// Inertia added to every roller's spin, as a multiple of the roller's own about its axis, >= 0: it eases the
    /// solver's work. It costs its share of the spin's energy and of the robot's lateral inertia; 0 works too, with
    /// more sweeps.
    pub roller_armature_ratio: f64,
    /// Contacts are foreseen at this distance, in metres, > 0.
    pub prediction_m: f64,
    /// Gravity along -z, in m/s^2.
    pub gravity_m_s2: f64,
}

impl Settings {
    /// The sweeps that a robot's contacts need. Friction across rollers converges slowly where the light direction (the
    /// roller spins) and the heavy one (it carries the robot) lie between the axes along which rapier solves friction:
    /// those turn with the robot, and lie along the rollers where the rollers of all wheels agree modulo a quarter turn.
    ///
    /// With every roller a body, neighbours press at once while they hand over and rub against each other: no frame serves
    /// that, and sweeps cost next to nothing there.
    pub fn sweeps_for(robot: &Robot, roller_bodies: RollerBodies) -> usize {
        match (roller_bodies, friction_axis_rad(robot)) {
            (RollerBodies::Near, Some(_)) => 16,
            _ => Self::default().sweeps,
        }
    }
}

/// The direction in the body frame, modulo a quarter turn, along which and across which the axes of the touching rollers
/// lie; `None` where they lie in too many directions for any to serve.
///
/// The mean of the axes' directions with their angles counted four times over, which makes quarter turns the same. Its
/// length says how well they agree: 1 for mecanum wheels at 45 degrees, 0 for three omni wheels.
pub(crate) fn friction_axis_rad(robot: &Robot) -> Option<f64> {
    const AGREEMENT: f64 = 0.7;
    let (mut x, mut y) = (0.0, 0.0);
    for wheel in &robot.wheels {
        let axis = wheel.roller_axis();
        let (sin, cos) = libm::sincos(4.0 * libm::atan2(axis.y, axis.x));
        x += cos;
        y += sin;
    }
    let agree = libm::hypot(x, y) / robot.wheels.len() as f64;
    (agree > AGREEMENT).then(|| libm::atan2(y, x) / 4.0)
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dt_s: 1.0 / 500.0,
            roller_bodies: RollerBodies::All,
            contact_frequency_hz: 1000.0,
            contact_damping_ratio: 1.0,
            sweeps: 32,
            roller_armature_ratio: 1.0,
            prediction_m: 1e-3,
            gravity_m_s2: 9.81,
        }
    }
}
