//! `[[faults]]`: what goes wrong on purpose.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::run::TIME_SLACK_S;

/// The faults, each of which has a window of time behind its `;`, and which window that is. A push has a length in place of an end.
macro_rules! windowed {
    (
        $(#[$of:meta])*
        pub enum $name:ident {
            $(
                $(#[$about:meta])*
                $kind:ident {
                    $($(#[$said:meta])* $field:ident: $type:ty),*
                    $(,)? $(; $from:ident, $until:ident)?
                },
            )*
        }
    ) => {
        $(#[$of])*
        pub enum $name {
            $(
                $(#[$about])*
                $kind {
                    $($(#[$said])* $field: $type,)*
                    $(
                        /// When it begins, in seconds.
                        #[serde(default)]
                        #[schemars(range(min = 0.0))]
                        $from: f64,
                        /// When it ends, in seconds; without it, never.
                        #[serde(default, skip_serializing_if = "Option::is_none")]
                        #[schemars(range(min = 0.0))]
                        $until: Option<f64>,
                    )?
                },
            )*
        }

        impl $name {
            /// When it begins, and when it ends, if it does.
            pub fn window_s(&self) -> (f64, Option<f64>) {
                match *self {
                    $($(Self::$kind { $from, $until, .. } => ($from, $until),)?)*
                    Self::Push { from_s, lasts_s, .. } => (from_s, Some(from_s + lasts_s)),
                }
            }
        }
    };
}

windowed! {
/// One thing that goes wrong, from a time on and, if it ends, until another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[schemars(rename = "FaultSection")]
pub enum Fault {
    /// A motor is lost: it gives no torque, and its wheel turns freely (but for its gear), or its winding is shorted.
    MotorLost {
        /// The wheel's joint.
        wheel: String,
        /// Whether its winding is shorted, so that its back-EMF brakes the wheel; needs `[motors.dc]`.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        shorted: bool; from_s, until_s
    },
    /// An encoder tells nothing: its wheel seems to stand.
    EncoderLost {
        /// The wheel's joint.
        wheel: String; from_s, until_s
    },
    /// An encoder counts wrong: the rate seen is the real one times a factor.
    EncoderScaled {
        /// The wheel's joint.
        wheel: String,
        /// Rate seen over real rate.
        factor: f64; from_s, until_s
    },
    /// The pose sensor sees nothing: the last pose stays.
    PoseLost { ; from_s, until_s },
    /// The pose sensor is off by as much.
    PoseShifted {
        /// Along the world's x axis, in metres.
        #[serde(default)]
        x_m: f64,
        /// Along the world's y axis, in metres.
        #[serde(default)]
        y_m: f64,
        /// In heading, in degrees.
        #[serde(default)]
        heading_deg: f64; from_s, until_s
    },
    /// The battery sags. Of motors with `[motors.dc]` stall torque and no-load rate fall with the supply's voltage, until at a share of 0
    /// they are shorted; of others the limits of torque and rate fall.
    BatterySag {
        /// What is left of the supply's voltage, from 0 to 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        share: f64; from_s, until_s
    },
    /// Something pushes the chassis.
    Push {
        /// The push along x, in N s: force times time, spread evenly over the time that it lasts.
        #[serde(default)]
        impulse_x_n_s: f64,
        /// The push along y, in N s.
        #[serde(default)]
        impulse_y_n_s: f64,
        /// The push along z, upwards, in N s.
        #[serde(default)]
        impulse_z_n_s: f64,
        /// Whose x and y these are.
        #[serde(default)]
        frame: Frame,
        /// Where on the chassis, along the body's x axis, in metres; without it, at the chassis's centre of mass.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        x_m: Option<f64>,
        /// The same along the body's y axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        y_m: Option<f64>,
        /// The same along the body's z axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        z_m: Option<f64>,
        /// When it begins, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        from_s: f64,
        /// How long it lasts, in seconds.
        #[serde(default = "a_tenth")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        lasts_s: f64,
    },
    /// A mass is put on the chassis and stays fixed to it: a point, so that what is large is written as several. It has
    /// the velocity of its place when it comes, and goes with it.
    Payload {
        /// Its mass, in kg; of 0 there is none.
        #[schemars(range(min = 0.0))]
        mass_kg: f64,
        /// Where on the chassis, along the body's x axis, in metres; without it, at the chassis's centre of mass.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        x_m: Option<f64>,
        /// The same along the body's y axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        y_m: Option<f64>,
        /// The same along the body's z axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        z_m: Option<f64>; from_s, until_s
    },
    /// A roller seizes on its axle: it stands still against its wheel.
    RollerStuck {
        /// The wheel's joint.
        wheel: String,
        /// Which of its rollers, as `wheel0_roller` of the trace counts them, from 0.
        roller: u32; from_s, until_s
    },
    /// The ground leans, and may go on rocking: a ship's deck, a lift gate, a moving platform. Gravity leans in the frame of the floor, about the
    /// world's origin; what a frame that turns would add is left out: at a distance r from the origin amplitude (2 pi f)^2 r in m/s^2, 0.07 of
    /// gravity at 1 m for 4 deg and 0.5 Hz. Several add up, and come on top of `world.floor.slope_deg`.
    Tilt {
        /// The largest angle, in degrees.
        #[schemars(range(min = -60.0, max = 60.0))]
        amplitude_deg: f64,
        /// How often it rocks, in Hz, from level on; 0 leans to the amplitude and stays.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        frequency_hz: f64,
        /// Which way it goes down first, in degrees from the world's x axis.
        #[serde(default)]
        direction_deg: f64,
        /// How long it takes to build up, and to die away before it ends, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        ramp_s: f64; from_s, until_s
    },
    /// The floor turns slippery, or less so: another friction everywhere but on its patches.
    FrictionChanged {
        /// Coulomb's coefficient of friction.
        #[schemars(range(min = 0.0))]
        friction: f64; from_s, until_s
    },
}
}

/// The axes that a push is given along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The world's.
    #[default]
    World,
    /// The robot's own, turned level: ahead, to the left, up.
    Body,
}

fn a_tenth() -> f64 {
    0.1
}

/// Whether a time lies in a window that may be open towards the end.
pub(crate) fn within(t_s: f64, from_s: f64, until_s: Option<f64>) -> bool {
    t_s >= from_s - TIME_SLACK_S && until_s.is_none_or(|until_s| t_s < until_s - TIME_SLACK_S)
}

impl Fault {
    /// Whether it is there at a time in seconds.
    pub fn is_on(&self, t_s: f64) -> bool {
        let (from_s, until_s) = self.window_s();
        within(t_s, from_s, until_s)
    }

    /// The wheel that it is about, if it is about one.
    pub fn wheel(&self) -> Option<&str> {
        match self {
            Self::MotorLost { wheel, .. }
            | Self::EncoderLost { wheel, .. }
            | Self::EncoderScaled { wheel, .. }
            | Self::RollerStuck { wheel, .. } => Some(wheel),
            Self::PoseLost { .. }
            | Self::PoseShifted { .. }
            | Self::BatterySag { .. }
            | Self::Push { .. }
            | Self::Payload { .. }
            | Self::FrictionChanged { .. }
            | Self::Tilt { .. } => None,
        }
    }
}
