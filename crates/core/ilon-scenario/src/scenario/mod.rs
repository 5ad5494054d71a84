//! The scenario file: the description of one run.
//!
//! A scenario is TOML. Unknown keys are refused, defaults are documented at each field, paths are
//! relative to the file, and degrees occur only here, in keys that end in `_deg`. Each file of this
//! module is a section; `reading` converts text to a [`Scenario`], and `checks` has the conditions
//! across several sections.

mod bodies;
mod checks;
mod controller;
mod driven;
mod expect;
mod faults;
mod guidance;
mod joints;
mod materials;
mod motion;
mod playback;
mod reading;
mod robot;
mod rollers;
mod run;
mod sensors;
mod wheels;
mod world;

pub use bodies::{Body, BoxShape, CylinderShape, SphereShape};
pub use controller::{Believed, BelievedWheel, Controller};
pub use expect::{Bound, Expect, Must, SignalBound};
pub use faults::{Fault, Frame, within};
pub use guidance::{Guidance, Kinematics, ReferencePoint, Saturation};
pub use ilon_control::{GuidanceTask as Task, LoopTiming, Priority};
pub use ilon_formats::{
    Handedness as Gamma, RoleOption as JointRole, RollerForms as Rollers, WheelOptions as Wheels,
};
pub use ilon_world::{ContactSolver as Contacts, RollerBodies};
pub use joints::{Between, Joint, JointSetpoint, Quantity};
pub use materials::{Across, Against, MaterialPair, Materials, Sliding};
pub use motion::{Heading, Motion, Reference, Scheduled, Timing, Tracked, Twist};
pub use playback::{Drives, Playback};
pub(crate) use reading::is_computable;
pub use reading::{MAX_BYTES, SETTING, SIZES, Setting, Source, nearest, read_text, read_toml};
pub use robot::Robot;
pub use rollers::{RollerSurface, Tread};
pub use run::{Auto, Run, Step, TIME_SLACK_S};
pub use sensors::{Encoders, Fusion, Imu, ImuNoise, PoseSensor, Sensors};
pub use wheels::{AntiWindup, DcMotor, MotorStrength, Motors, Passive, WheelLaw, WheelLoop};
pub use world::{
    Floor, FloorBox, FloorPatch, FloorRamp, FloorStairs, HeightMap, Rough, RoughnessClass, Solver,
    World,
};

use std::path::PathBuf;

use ilon_files::FileAccess;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One run: a robot, the world it stands in, the motion asked of it, and what is expected to come
/// of it.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Which robot, and how it starts.
    pub robot: Robot,
    /// Gravity and floor.
    #[serde(default)]
    pub world: World,
    /// A path in time that the robot tracks (closed loop). Either this or `twist`.
    pub reference: Option<Tracked>,
    /// A velocity of the body without feedback of the pose (open loop). Either this or `reference`.
    pub twist: Option<Twist>,
    /// Drives the robot by a log: wheels, a twist or a path. Instead of `reference` and `twist`.
    pub playback: Option<Playback>,
    /// How the robot tracks the reference. Under `twist` only its kinematics, wheel rate limits and
    /// saturation count.
    #[serde(default)]
    pub guidance: Guidance,
    /// What the controller believes of the robot.
    #[serde(default, skip_serializing_if = "Controller::is_empty")]
    pub controller: Controller,
    /// The loop that turns commanded wheel rates into torques.
    #[serde(default)]
    pub wheel_loop: WheelLoop,
    /// Motors and gears, beside the limits of the robot's file.
    #[serde(default)]
    pub motors: Motors,
    /// Shape, bearings and tread of the rollers. Overrides the robot's file.
    #[serde(default, skip_serializing_if = "RollerSurface::is_empty")]
    pub rollers: RollerSurface,
    /// `[materials.ROLLERS.FLOOR]`: what rollers of one material do on a floor of another.
    #[serde(default, skip_serializing_if = "Materials::is_empty")]
    pub materials: Materials,
    /// What the robot measures.
    #[serde(default)]
    pub sensors: Sensors,
    /// Faults, pushes and payloads.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<Fault>,
    /// Duration and time steps.
    #[serde(default)]
    pub run: Run,
    /// Bounds on the results, tested by `ilon check`.
    #[serde(default, skip_serializing_if = "Expect::is_empty")]
    pub expect: Expect,

    /// The scenario's name: its file's name without `.toml`.
    #[serde(skip)]
    pub name: String,
    /// What it is about: the first paragraph of the comment at the head of its file, of at most 600
    /// characters.
    #[serde(skip)]
    pub about: String,
    /// The text that it was read from.
    #[serde(skip)]
    pub source: Source,
    /// The folder that its relative paths start from.
    #[serde(skip)]
    pub folder: PathBuf,
    /// Which files it, and its robot, may read.
    #[serde(skip)]
    pub files: FileAccess,
}

impl Scenario {
    /// The motion asked for, whichever of `[reference]`, `[twist]` and `[playback]` it is; `None`
    /// where several or none stand. A log that drives joints between bodies alone stands beside it.
    pub fn motion(&self) -> Option<Motion<'_>> {
        let playback = self.playback.as_ref();
        let playback = playback.filter(|playback| playback.drives != Drives::Joints);
        match (&self.reference, &self.twist, playback) {
            (Some(reference), None, None) => Some(Motion::Tracked(reference)),
            (None, Some(twist), None) => Some(Motion::OpenLoop(twist)),
            (None, None, Some(playback)) => Some(Motion::Played(playback)),
            _ => None,
        }
    }

    /// The JSON Schema of the scenario file.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(Scenario).to_value()
    }
}
