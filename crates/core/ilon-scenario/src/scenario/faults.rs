//! `[[faults]]`: injected faults.

use ilon_files::defaults::thousandths;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::run::TIME_SLACK_S;

/// The faults, each of which has a window of time behind its `;`, and which window that is. A push
/// has a length in place of an end.
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
/// A fault, a push or a payload, with its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[schemars(rename = "FaultSection")]
pub enum Fault {
    /// A motor gives no torque. Its wheel turns freely, but for its gear, unless `shorted`.
    MotorLost {
        /// The wheel's joint.
        wheel: String,
        /// The winding is shorted: its back-EMF brakes the wheel. Needs `[motors.dc]`.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        shorted: bool; from_s, until_s
    },
    /// An encoder reads zero.
    EncoderLost {
        /// The wheel's joint.
        wheel: String; from_s, until_s
    },
    /// An encoder reads a wrong rate.
    EncoderScaled {
        /// The wheel's joint.
        wheel: String,
        /// Rate seen over real rate.
        factor: f64; from_s, until_s
    },
    /// The pose sensor is blind: the last pose stays.
    PoseLost { ; from_s, until_s },
    /// The pose sensor has an offset.
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
    /// The battery voltage drops. With `[motors.dc]` stall torque and no-load rate fall with it (0:
    /// shorted), else the limits of torque and rate.
    BatterySag {
        /// Remaining share of the voltage, from 0 to 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        share: f64; from_s, until_s
    },
    /// A push on the chassis.
    Push {
        /// Impulse along x (force times time), in N s.
        #[serde(default)]
        impulse_x_n_s: f64,
        /// Impulse along y, in N s.
        #[serde(default)]
        impulse_y_n_s: f64,
        /// Impulse along z, upwards, in N s.
        #[serde(default)]
        impulse_z_n_s: f64,
        /// Frame of the impulse.
        #[serde(default)]
        frame: Frame,
        /// x on the chassis in the body frame, in metres [default: centre of mass].
        #[serde(default, skip_serializing_if = "Option::is_none")]
        x_m: Option<f64>,
        /// y on the chassis, in metres.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        y_m: Option<f64>,
        /// z on the chassis, in metres.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        z_m: Option<f64>,
        /// When it begins, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        from_s: f64,
        /// Duration, in seconds.
        #[serde(default = "thousandths::<100>")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        lasts_s: f64,
    },
    /// A point mass fixed to the chassis. Write a large load as several.
    Payload {
        /// Its mass, in kg.
        #[schemars(range(min = 0.0))]
        mass_kg: f64,
        /// x on the chassis in the body frame, in metres [default: centre of mass].
        #[serde(default, skip_serializing_if = "Option::is_none")]
        x_m: Option<f64>,
        /// y on the chassis, in metres.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        y_m: Option<f64>,
        /// z on the chassis, in metres.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        z_m: Option<f64>; from_s, until_s
    },
    /// A roller seizes on its axle.
    RollerStuck {
        /// The wheel's joint.
        wheel: String,
        /// Number of the roller, from 0, as in `wheel0_roller` of the trace.
        roller: u32; from_s, until_s
    },
    /// The ground tilts or rocks about the world's origin, by turning gravity; the acceleration of
    /// the turning frame is left out. Added to `world.floor.slope_deg`; several add up.
    Tilt {
        /// The largest angle, in degrees.
        #[schemars(range(min = -60.0, max = 60.0))]
        amplitude_deg: f64,
        /// Rocking frequency, in Hz; 0 tilts and stays.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        frequency_hz: f64,
        /// Direction in which it goes down first, in degrees from the world's x axis.
        #[serde(default)]
        direction_deg: f64,
        /// Time to build up, and to fade out at the end, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        ramp_s: f64; from_s, until_s
    },
    /// The floor has another friction, except on patches.
    FrictionChanged {
        /// Friction coefficient.
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

/// Whether a time lies in a window that may have no end.
pub fn within(t_s: f64, from_s: f64, until_s: Option<f64>) -> bool {
    t_s >= from_s - TIME_SLACK_S && until_s.is_none_or(|until_s| t_s < until_s - TIME_SLACK_S)
}

impl Fault {
    /// Whether it is active at a time in seconds.
    pub fn is_on(&self, t_s: f64) -> bool {
        let (from_s, until_s) = self.window_s();
        within(t_s, from_s, until_s)
    }
}
