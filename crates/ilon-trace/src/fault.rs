//! What went wrong on purpose in a run, as data: whoever tells of it needs no scenario to read.

use serde::{Deserialize, Serialize};

/// One thing that went wrong on purpose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// When it begins, in seconds.
    pub from_s: f64,
    /// When it ends, in seconds; `None` where it never does.
    pub until_s: Option<f64>,
    /// What it is.
    pub kind: FaultKind,
}

/// What goes wrong. Wheels count as in [`crate::Header::wheels`].
///
/// It is exhaustive, so that a kind that is added cannot be forgotten by what writes it or tells of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// A motor is driven by nobody.
    MotorLost {
        /// Its wheel.
        wheel: usize,
        /// Whether its winding is shorted, so that its back-EMF brakes the wheel.
        #[serde(default)]
        shorted: bool,
    },
    /// An encoder reads zero.
    EncoderLost {
        /// Its wheel.
        wheel: usize,
    },
    /// An encoder counts wrong.
    EncoderScaled {
        /// Its wheel.
        wheel: usize,
        /// The rate that it reads over the real one.
        factor: f64,
    },
    /// The pose sensor sees nothing.
    PoseLost,
    /// The pose sensor is off.
    PoseShifted {
        /// By how much along the world's x and y, in metres.
        by_m: [f64; 2],
        /// By how much in heading, in radians.
        by_rad: f64,
    },
    /// The battery sags.
    BatterySag {
        /// What is left of its voltage, in [0, 1].
        share: f64,
    },
    /// Something pushes the chassis.
    Push {
        /// The impulse, spread evenly over the time, in N s.
        impulse_n_s: [f64; 3],
        /// Whether its axes are the robot's, turned level, and not the world's.
        in_body: bool,
        /// Where on the chassis, in the body frame, in metres.
        place_m: [f64; 3],
    },
    /// A mass lies on the chassis.
    Payload {
        /// Its mass, in kg.
        mass_kg: f64,
        /// Where on the chassis, in the body frame, in metres.
        place_m: [f64; 3],
    },
    /// A roller does not turn on its axle.
    RollerStuck {
        /// Its wheel.
        wheel: usize,
        /// Its number on the wheel, from 0.
        roller: u32,
    },
    /// The floor has another friction, everywhere but on its patches.
    FrictionChanged {
        /// Coulomb's coefficient.
        friction: f64,
    },
    /// The ground leans, or rocks.
    Tilt {
        /// The largest angle, in radians.
        amplitude_rad: f64,
        /// How often it rocks, in Hz; 0 where it leans and stays.
        frequency_hz: f64,
        /// Which way it goes down first, in radians from the world's x axis.
        direction_rad: f64,
    },
}
