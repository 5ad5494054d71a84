//! `[reference]` and `[twist]`: the commanded motion of the robot.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

/// The motion asked for.
#[derive(Clone, Copy, Debug)]
pub enum Motion<'a> {
    /// Closed loop: the guidance tracks a reference.
    Tracked(&'a Tracked),
    /// Open loop: a twist becomes wheel rates.
    OpenLoop(&'a Twist),
    /// What a log says.
    Played(&'a super::Playback),
}

/// A position and a heading in time, for the guidance to track.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[schemars(rename = "ReferencePath")]
pub enum Reference {
    /// A straight line at constant speed, held at its end.
    Line {
        /// x of its start, in metres.
        #[serde(default)]
        from_x_m: f64,
        /// y of its start, in metres.
        #[serde(default)]
        from_y_m: f64,
        /// x of its end, in metres.
        to_x_m: f64,
        /// y of its end, in metres.
        to_y_m: f64,
        /// Speed along it, in m/s.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        speed_m_s: f64,
        /// Heading on the way.
        #[serde(default)]
        heading: Heading,
    },
    /// A circle at constant speed.
    Circle {
        /// x of its centre, in metres.
        #[serde(default)]
        center_x_m: f64,
        /// y of its centre, in metres.
        #[serde(default)]
        center_y_m: f64,
        /// Radius in metres.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius_m: f64,
        /// Speed along it, in m/s; counter-clockwise where positive.
        speed_m_s: f64,
        /// Start on the circle: angle from the world's x axis, in degrees.
        #[serde(default)]
        start_deg: f64,
        /// Heading on the way.
        #[serde(default)]
        heading: Heading,
    },
    /// A figure eight: the lemniscate of Bernoulli, from its crossing.
    FigureEight {
        /// x of its crossing, in metres.
        #[serde(default)]
        center_x_m: f64,
        /// y of its crossing, in metres.
        #[serde(default)]
        center_y_m: f64,
        /// Distance from the crossing to each tip, in metres.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        half_width_m: f64,
        /// Direction of its long axis, in degrees.
        #[serde(default)]
        axis_deg: f64,
        /// Time for the whole eight, in seconds.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        period_s: f64,
        /// Heading on the way.
        #[serde(default)]
        heading: Heading,
    },
    /// A smooth path through points, at rest at both ends: `points_m`, or a CSV file with the
    /// columns `x_m`, `y_m`, `t_s` (or `speed_m_s` here) and, optionally, `heading_deg`.
    Waypoints {
        /// The points: x and y, in metres.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        points_m: Vec<[f64; 2]>,
        /// Time at each of `points_m`, in seconds [default: from `speed_m_s`].
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        times_s: Vec<f64>,
        /// Heading at each of `points_m`, in degrees [default: `heading`].
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        headings_deg: Vec<f64>,
        /// The CSV file, relative to the scenario, instead of `points_m`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        file: Option<PathBuf>,
        /// Mean speed between neighbours, in m/s, where no times are given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        speed_m_s: Option<f64>,
        /// Heading on the way, unless `headings_deg` are given.
        #[serde(default)]
        heading: Heading,
    },
    /// A pose to reach and hold.
    HoldPose {
        /// x in the world, in metres.
        x_m: f64,
        /// y in the world, in metres.
        y_m: f64,
        /// Heading in degrees.
        heading_deg: f64,
    },
}

/// `[reference]`: a path, and how its time passes.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize)]
pub struct Tracked {
    /// `"as fast as grip allows"`: least time within the limits. Without it the path's own speeds
    /// and times hold.
    pub timing: Option<Timing>,
    /// With `timing`: largest share of grip, torques and wheel rates; 0.9 unless given.
    pub share_of_limits: Option<f64>,
    /// With `timing`: share of grip and torques used, above 0 and at most `share_of_limits`
    /// [default: the largest at which the simulated robot hardly slides].
    pub share_of_grip: Option<f64>,
    /// The path.
    #[serde(flatten)]
    pub path: Reference,
}

/// When a robot is where on its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Timing {
    /// In the least time within a share of what grip, motors and wheel rates allow, from rest and,
    /// where the path ends, to rest. The path's own speeds and times then have no effect, but for
    /// the sense of a circle.
    #[serde(rename = "as fast as grip allows")]
    AsFastAsGripAllows,
}

impl Tracked {
    /// The default share of the limits.
    const SHARE: f64 = 0.9;

    /// A path with its own timing.
    pub fn as_made(path: Reference) -> Self {
        Self {
            timing: None,
            share_of_limits: None,
            share_of_grip: None,
            path,
        }
    }

    /// The waypoint file that it names, if it names one.
    pub fn file(&self) -> Option<&PathBuf> {
        match &self.path {
            Reference::Waypoints { file, .. } => file.as_ref(),
            _ => None,
        }
    }

    /// The same, mutable.
    pub fn file_mut(&mut self) -> Option<&mut PathBuf> {
        match &mut self.path {
            Reference::Waypoints { file, .. } => file.as_mut(),
            _ => None,
        }
    }

    /// The share of grip, torques and wheel rates that the fastest timing may use.
    pub fn share_of_limits(&self) -> f64 {
        self.share_of_limits.unwrap_or(Self::SHARE)
    }
}

/// Heading of the robot on its path.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[schemars(rename = "HeadingSection")]
pub enum Heading {
    /// Constant, in degrees from the world's x axis.
    ConstantDeg(f64),
    /// Along the path.
    AlongPath,
    /// At a fixed angle from the path, in degrees, counter-clockwise.
    FromPathDeg(f64),
    /// Turning at a constant rate.
    Turning {
        /// The heading at the start, in degrees.
        #[serde(default)]
        from_deg: f64,
        /// Its rate in degrees per second, counter-clockwise.
        rate_deg_s: f64,
    },
}

impl Default for Heading {
    fn default() -> Self {
        Self::ConstantDeg(0.0)
    }
}

/// A twist in the body frame, held after a ramp, or a schedule of several.
#[derive(Clone, Debug, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "TwistSection")]
pub struct Twist {
    /// Forward speed in m/s.
    pub vx_m_s: f64,
    /// Speed to the left in m/s.
    pub vy_m_s: f64,
    /// Yaw rate in rad/s, counter-clockwise.
    pub omega_rad_s: f64,
    /// Rest before the first motion, in seconds.
    #[schemars(range(min = 0.0))]
    #[default = 1.0]
    pub rest_s: f64,
    /// Time of each change of the twist, linear, in seconds.
    #[schemars(range(min = 0.0))]
    #[default = 0.5]
    pub ramp_s: f64,
    /// Time after a ramp before the means of the summary begin, in seconds.
    #[schemars(range(min = 0.0))]
    #[default = 1.0]
    pub settle_s: f64,
    /// Further twists, each from its own time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub schedule: Vec<Scheduled>,
}

/// A twist of a schedule.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scheduled {
    /// When the change towards it begins, in seconds.
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// Forward speed in m/s.
    #[serde(default)]
    pub vx_m_s: f64,
    /// Speed to the left in m/s.
    #[serde(default)]
    pub vy_m_s: f64,
    /// Yaw rate in rad/s, counter-clockwise.
    #[serde(default)]
    pub omega_rad_s: f64,
}
