//! Numerical settings of a world. Every default follows from the measurements in
//! `docs/measured.md`.
//!
//! All contacts of a robot are springs of the same stiffness k. So of all loads that balance its
//! weight they carry those with the smallest sum of squares, and a floor that is d lower under one
//! of four wheels moves a load of k d / 4 from each wheel of that diagonal to the other. A wheel
//! that sinks in rolls on a smaller radius: that is the only effect of a soft contact in steady
//! motion.

use ilon_robot::tread::TYRE_SAG;
use ilon_robot::{Robot, Scale};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

/// Deflection of a rigid contact under a wheel's load, relative to the wheel's radius. Chosen.
const SAG: f64 = 5.5e-6;

/// Relaxation time of a contact's spring, in a robot's unit of time: three times that of critical
/// damping under a wheel's load, 2 sqrt([`SAG`]). Nothing bounces, and the micrometres by which a
/// robot tilts while one of its wheels hands over move little load. Chosen.
const RELAXATION: f64 = 0.014;

/// The default stiffness of a robot's contacts with the ground, in N/m: hard rollers on hard
/// ground. A wheel sinks in by 5.5e-6 of its radius: 1e8 N/m, and 0.28 um, for a robot of 11 kg on
/// four wheels of 50 mm.
pub fn contact_stiffness_n_m(scale: &Scale) -> f64 {
    scale.stiffness_n_m(SAG)
}

/// [`contact_stiffness_n_m`] of a robot; of one on tyres so much less that its casters and its
/// chassis give as its tyres do, and share the load.
pub fn contact_stiffness_of_robot_n_m(robot: &Robot, scale: &Scale) -> f64 {
    if robot.has_tyres() {
        scale.stiffness_n_m(TYRE_SAG)
    } else {
        contact_stiffness_n_m(scale)
    }
}

/// The default relaxation time of a robot's contacts, in seconds: a millisecond for wheels of 50 mm
/// on earth.
pub fn contact_relaxation_s(scale: &Scale) -> f64 {
    RELAXATION * scale.time_s()
}

/// The distance within which a chassis is searched for contacts, in wheel radii; its displacement
/// in a step is added where that is known. Chosen.
pub(crate) const NEAR: f64 = 0.02;

/// The spring of a robot's contacts, with its damper.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSpring {
    pub stiffness_n_m: f64,
    pub relaxation_s: f64,
}

impl ContactSpring {
    /// Of a robot with these units.
    pub fn of_robot(settings: &Settings, robot: &Robot, scale: &Scale) -> Self {
        let stiffness_n_m = settings.contact_stiffness_n_m;
        Self {
            stiffness_n_m: stiffness_n_m
                .unwrap_or_else(|| contact_stiffness_of_robot_n_m(robot, scale)),
            ..Self::of(settings, scale)
        }
    }

    /// Of hard bodies with these units.
    pub fn of(settings: &Settings, scale: &Scale) -> Self {
        let stiffness_n_m = settings.contact_stiffness_n_m;
        let relaxation_s = settings.contact_relaxation_s;
        Self {
            stiffness_n_m: stiffness_n_m.unwrap_or_else(|| contact_stiffness_n_m(scale)),
            relaxation_s: relaxation_s.unwrap_or_else(|| contact_relaxation_s(scale)),
        }
    }

    /// For a free body with these units: a heavy one is as stiff relative to its weight as any
    /// robot, and does not sink into the floor.
    pub fn of_body(settings: &Settings, scale: &Scale) -> Self {
        let of_robot = Self::of(settings, scale);
        Self {
            stiffness_n_m: of_robot.stiffness_n_m.max(contact_stiffness_n_m(scale)),
            ..of_robot
        }
    }

    /// The softer of two.
    pub fn softer(self, other: Self) -> Self {
        if other.stiffness_n_m < self.stiffness_n_m {
            other
        } else {
            self
        }
    }

    /// Compliance of a contact over a step, in m/s per N s.
    pub fn compliance(&self, dt_s: f64) -> f64 {
        1.0 / (self.stiffness_n_m * dt_s * (dt_s + self.relaxation_s))
    }
}

/// Which rollers are checked for contact: all, or those near the ground. Same motion to
/// micrometres, not to the last bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RollerBodies {
    /// Every roller, always.
    #[default]
    All,
    /// Those that can touch something; the others keep their spin. Faster.
    Near,
}

/// The contact solver: ilon, or rapier alone, to compare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "Contacts")]
pub enum ContactSolver {
    /// ilon: the laws of contact and friction all at once, to the end.
    #[default]
    Ilon,
    /// rapier alone: every roller is a body on a joint of its own, and rapier's own solver sweeps
    /// over contacts and dry bearings. Slower and less exact; it shows what the engine does by
    /// itself, and cross-checks ilon. It knows no `split_dt_s`, no contact stiffness or relaxation,
    /// no `roller_bodies = "near"` and no gear that loses a share of the torque.
    Rapier,
}

/// Numerical settings of a world.
#[derive(Clone, Debug, SmartDefault, PartialEq)]
pub struct Settings {
    /// Length of one physics step, in seconds, > 0.
    #[default(1.0 / 500.0)]
    pub dt_s: f64,
    /// Steps in which a roller uses more than half of its grip, or slides, are split into parts of
    /// about this length, in seconds, > 0; `None` never splits. How far a roller slides before the
    /// next one takes over, how long that one takes to spin up, and the cost of it, are decided
    /// within milliseconds. A step whose contacts cannot be solved is halved, down to this or to a
    /// sixteenth of `dt_s`, whichever is shorter.
    pub split_dt_s: Option<f64>,
    /// The solver of the contacts with the ground.
    pub contacts: ContactSolver,
    /// Which rollers are searched for contacts.
    pub roller_bodies: RollerBodies,
    /// Stiffness of every contact of a robot with the ground, in N/m, > 0; `None` for
    /// [`contact_stiffness_n_m`].
    pub contact_stiffness_n_m: Option<f64>,
    /// Relaxation time of a contact's spring, in seconds, >= 0: the damper parallel to it has this
    /// times the stiffness. `None` for [`contact_relaxation_s`].
    pub contact_relaxation_s: Option<f64>,
    /// Gravity along -z, in m/s^2.
    #[default = 9.81]
    pub gravity_m_s2: f64,
}
