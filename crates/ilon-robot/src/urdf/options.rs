//! What a person may say beside the file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::files::Files;
use crate::packages::Package;

/// How to read a robot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LoadOptions {
    /// Where ROS packages lie: `package://NAME/mesh.stl` is read from the folder given for NAME. A package that is not
    /// given is looked for in the folders above the file, by its name.
    pub packages: Vec<Package>,
    /// The values of a xacro file's arguments, `<xacro:arg name="...">`, by name; those left out have their defaults.
    pub arguments: BTreeMap<String, String>,
    /// Whether a xacro file's includes that cannot be found are left out, with the macros that they would define.
    pub leave_out_missing: bool,
    /// Which files may be read.
    pub files: Files,
    /// Mends what can be mended safely, and remarks each change: missing and impossible inertias, elements that stand
    /// twice, gaps between rollers.
    pub mend: bool,
    /// What rollers touch the ground with.
    pub rollers: RollerForms,
    /// Puts rollers into wheels that have none in the file.
    pub wheels: Option<WheelOptions>,
}

/// What the rollers of a robot touch the ground with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RollerForms {
    /// The exact barrel that is fitted to what the file models.
    #[default]
    Barrel,
    /// The file's own collision shapes, gaps and ripple included; rollers that are put in are barrels all the same.
    AsModelled,
}

/// Rollers for wheels that have none in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelOptions {
    /// The wheels' joints; none for every turning joint on a level axis with nothing turning above or below it.
    #[serde(default)]
    pub joints: Vec<String>,
    /// The angle of the rollers, and each wheel's handedness.
    pub gamma: Handedness,
    /// Rollers on each wheel.
    pub rollers: usize,
    /// The wheels' radius rho, in metres; left out, it is taken from their collision geometry.
    #[serde(default)]
    pub radius_m: Option<f64>,
    /// The rollers' largest radius, in metres; left out, a fifth of the wheel's, or as much more as it takes to reach
    /// the neighbours.
    #[serde(default)]
    pub roller_radius_m: Option<f64>,
    /// Mass of one roller, in kg, which is taken from the wheel's; left out, that of solid rubber (1100 kg/m^3), and at
    /// most half of the wheel's mass for all of them.
    #[serde(default)]
    pub roller_mass_kg: Option<f64>,
    /// Viscous damping of a roller's bearing, in N m s/rad.
    #[serde(default)]
    pub damping_n_m_s: f64,
    /// Dry friction of a roller's bearing, in N m.
    #[serde(default)]
    pub friction_n_m: f64,
}

/// The paper's gamma of each wheel, in degrees, with its sign (see [`crate::Wheel::gamma_rad`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Handedness {
    /// `gamma.x_deg = 45`: mecanum wheels in the usual X, in which each turns the robot with the sum of its two arms. The
    /// sign of each follows from its place about the middle of the wheels; all hub axes must lie along y.
    XDeg(f64),
    /// `gamma.all_deg = 0`: the same for all wheels.
    AllDeg(f64),
    /// `gamma.each_deg = [...]`: one for each joint, in the order of `joints`.
    EachDeg(Vec<f64>),
}
