//! `[[faults]]`: what goes wrong on purpose.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One thing that goes wrong, from a time on and, if it ends, until another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[schemars(rename = "FaultSection")]
pub enum Fault {
    /// A motor gives no torque; its wheel turns freely.
    MotorLost {
        /// The wheel's joint.
        wheel: String,
        /// When it begins, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        from_s: f64,
        /// When it ends, in seconds; without it, never.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0))]
        until_s: Option<f64>,
    },
    /// An encoder tells nothing: its wheel seems to stand.
    EncoderLost {
        /// The wheel's joint.
        wheel: String,
        /// When it begins, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        from_s: f64,
        /// When it ends, in seconds; without it, never.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0))]
        until_s: Option<f64>,
    },
    /// An encoder counts wrong: the rate seen is the real one times a factor.
    EncoderScaled {
        /// The wheel's joint.
        wheel: String,
        /// Rate seen over real rate.
        factor: f64,
        /// When it begins, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        from_s: f64,
        /// When it ends, in seconds; without it, never.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0))]
        until_s: Option<f64>,
    },
    /// The pose sensor sees nothing: the last pose stays.
    PoseLost {
        /// When it begins, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        from_s: f64,
        /// When it ends, in seconds; without it, never.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0))]
        until_s: Option<f64>,
    },
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
        heading_deg: f64,
        /// When it begins, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        from_s: f64,
        /// When it ends, in seconds; without it, never.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0))]
        until_s: Option<f64>,
    },
    /// The battery sags: every motor gives only a share of its torque.
    BatterySag {
        /// What is left of the torque, from 0 to 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        share: f64,
        /// When it begins, in seconds.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        from_s: f64,
        /// When it ends, in seconds; without it, never.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0))]
        until_s: Option<f64>,
    },
}

impl Fault {
    /// Whether it is there at a time in seconds.
    pub fn is_on(&self, t_s: f64) -> bool {
        let (Self::MotorLost {
            from_s, until_s, ..
        }
        | Self::EncoderLost {
            from_s, until_s, ..
        }
        | Self::EncoderScaled {
            from_s, until_s, ..
        }
        | Self::PoseLost { from_s, until_s }
        | Self::PoseShifted {
            from_s, until_s, ..
        }
        | Self::BatterySag {
            from_s, until_s, ..
        }) = self;
        t_s >= *from_s && until_s.is_none_or(|until_s| t_s < until_s)
    }

    /// The wheel that it is about, if it is about one.
    pub fn wheel(&self) -> Option<&str> {
        match self {
            Self::MotorLost { wheel, .. }
            | Self::EncoderLost { wheel, .. }
            | Self::EncoderScaled { wheel, .. } => Some(wheel),
            Self::PoseLost { .. } | Self::PoseShifted { .. } | Self::BatterySag { .. } => None,
        }
    }
}
