//! `[robot]`: the robot and its start.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_files::defaults::yes;
use ilon_formats::{LoadOptions, Package, RollerForms, TyreOptions, WheelOptions};
use ilon_robot::Pose;
use ilon_world::RollerBodies;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

use super::joints::Joint;

/// Which robot, and how it starts.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RobotSection")]
pub struct Robot {
    /// The robot's file, relative to the scenario.
    pub file: PathBuf,
    /// x of the body's origin in the world at the start, in metres.
    #[serde(default)]
    pub x_m: f64,
    /// y of the body's origin in the world at the start, in metres.
    #[serde(default)]
    pub y_m: f64,
    /// Heading at the start, counter-clockwise from the world's x axis, in degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Which rollers are checked for contact: all, or those near the ground. Same motion to
    /// micrometres, not to the last bit.
    #[serde(default)]
    pub roller_bodies: RollerBodies,
    /// Shape of the rollers at the ground: ideal barrels, or the shapes of the file.
    #[serde(default)]
    pub rollers: RollerForms,
    /// Repair masses, inertias, double names, gaps between rollers, wheels some millimetres off the
    /// floor and fixed hubs. Each change is reported.
    #[serde(default)]
    pub repair: bool,
    /// Density of a part whose size or mass is missing, for repairs, in kg/m^3 [default: 1500].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub density_kg_m3: Option<f64>,
    /// Leave out, and report, missing includes, macros and links.
    #[serde(default)]
    pub leave_out_missing: bool,
    /// Arguments of a xacro file, `NAME = VALUE`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub args: BTreeMap<String, Argument>,
    /// Propose rollers for wheels that have none, where the file says what kind they are.
    #[serde(default = "yes")]
    pub infer_rollers: bool,
    /// Folders of ROS packages, `NAME = "DIR"`, relative to the scenario. Others are searched in
    /// the folders above the robot's file.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub packages: BTreeMap<String, PathBuf>,
    /// Radius of wheels whose geometry does not show it, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub wheel_radius_m: Option<f64>,
    /// Rollers for wheels that have none in the robot's file.
    pub wheels: Option<WheelOptions>,
    /// Tyres of wheels that have no rollers in the robot's file.
    pub tyres: Option<TyreOptions>,
    /// Joints other than wheels and rollers, by name. Default: sprung where the file has a spring,
    /// free for rockers, else held at zero.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub joints: BTreeMap<String, Joint>,
    /// Keys of a robot's description in TOML, such as `spec.rollers.per_row = 12`.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub spec: Table,
}

impl Robot {
    /// The robot's start pose.
    pub fn start(&self) -> Pose {
        Pose {
            x_m: self.x_m,
            y_m: self.y_m,
            heading_rad: self.heading_deg.to_radians(),
        }
    }

    /// The options for reading the robot's file, with paths relative to `folder` and the permitted
    /// files.
    pub fn load_options(&self, folder: &Path, files: &FileAccess) -> LoadOptions {
        let package = |(name, dir): (&String, &PathBuf)| Package {
            name: name.clone(),
            folder: folder.join(dir),
        };
        let mut options = LoadOptions::default();
        options.files = files.clone();
        options.packages = self.packages.iter().map(package).collect();
        let argument = |(name, value): (&String, &Argument)| (name.clone(), value.to_string());
        options.arguments = self.args.iter().map(argument).collect();
        options.leave_out_missing = self.leave_out_missing;
        options.repair = self.repair;
        options.density_kg_m3 = self.density_kg_m3;
        options.rollers = self.rollers;
        options.wheel_radius_m = self.wheel_radius_m;
        options.infer_rollers = self.infer_rollers;
        let joint = |(name, joint): (&String, &Joint)| (name.clone(), joint.options());
        options.joints = self.joints.iter().map(joint).collect();
        options.spec = self.spec.clone();
        options.wheels = self.wheels.clone();
        options.tyres = self.tyres.clone();
        options
    }
}

/// The value of a xacro file's argument.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Argument {
    /// `true` or `false`.
    Truth(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
}

impl std::fmt::Display for Argument {
    /// As on xacro's command line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Truth(truth) => truth.fmt(f),
            Self::Whole(number) => number.fmt(f),
            Self::Number(number) => number.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}
