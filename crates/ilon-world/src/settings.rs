//! How a world is built and stepped. Every default is the outcome of the measurements in `docs/accuracy.md`.

/// Which rollers are looked at for contact. All have their mass, inertia and spin, and touch where they touch, whichever
/// this is: the motion is the same to the bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RollerBodies {
    /// Every roller, always.
    #[default]
    All,
    /// Those near the ground: the others are passed over by a bound on how far they reach.
    Near,
}

/// Who solves the contacts with the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ContactSolver {
    /// ilon: rollers are flywheels on their hubs, and the laws of contact and friction are solved all at once, to the end.
    #[default]
    Ilon,
    /// rapier alone, to compare with: every roller is a body on a joint of its own, and rapier's solver sweeps over contacts
    /// and dry bearings. [`Settings::contact_stiffness_n_m`] and [`Settings::contact_relaxation_s`] do not act.
    Rapier,
}

/// Numerical settings of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Length of one physics step, in seconds, > 0.
    pub dt_s: f64,
    /// Steps in which a roller uses more than half of its grip and holds, or has just begun to slide, are taken in parts of
    /// about this length, in seconds, > 0; `None` takes every step whole. How far a roller slides before the next one takes
    /// over, and what that costs, is decided within milliseconds.
    pub split_dt_s: Option<f64>,
    /// Who solves the contacts with the ground.
    pub contacts: ContactSolver,
    /// Which rollers are looked at for contact.
    pub roller_bodies: RollerBodies,
    /// Stiffness of every contact with the ground, in N/m, > 0. The default is that of hard rollers on hard ground: under
    /// 28 N a roller goes in by 0.3 um.
    pub contact_stiffness_n_m: f64,
    /// Time in which a contact's spring gives back what it was loaded with, in seconds, >= 0: the damper beside it has this
    /// times the stiffness. The default lets nothing bounce that weighs less than 300 kg, and lets little load change hands
    /// for the micrometres by which a robot leans while one of its wheels hands over.
    pub contact_relaxation_s: f64,
    /// Places of the robot that are nearer to the ground than this are contact candidates, in metres, > 0; the distance that a
    /// wheel moves in a step comes on top.
    pub prediction_m: f64,
    /// Gravity along -z, in m/s^2.
    pub gravity_m_s2: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dt_s: 1.0 / 500.0,
            split_dt_s: None,
            contacts: ContactSolver::Ilon,
            roller_bodies: RollerBodies::All,
            contact_stiffness_n_m: 1e8,
            contact_relaxation_s: 1e-3,
            prediction_m: 1e-3,
            gravity_m_s2: 9.81,
        }
    }
}
