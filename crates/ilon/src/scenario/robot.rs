//! `[robot]`: which robot, and how it starts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ilon_robot::{FileAccess, Handedness, LoadOptions, Package, RollerForms, WheelOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which robot, and how it starts.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RobotSection")]
pub struct Robot {
    /// The robot's URDF, relative to the scenario file.
    pub file: PathBuf,
    /// Where it starts: x of the body's origin in the world, in metres.
    #[serde(default)]
    pub x_m: f64,
    /// Where it starts: y of the body's origin in the world, in metres.
    #[serde(default)]
    pub y_m: f64,
    /// Where it looks at the start: the angle from the world's x axis to the body's, in degrees, counter-clockwise.
    #[serde(default)]
    pub heading_deg: f64,
    /// Which rollers have their shapes in the simulated world: all, or those near the ground. The motion is the same to
    /// micrometres, and not to the last bit.
    #[serde(default)]
    pub roller_bodies: RollerBodies,
    /// What the rollers touch the ground with.
    #[serde(default)]
    pub rollers: Rollers,
    /// Whether what can be mended safely in the robot's file is mended, each change being told of: missing and impossible
    /// inertias, elements that stand twice, gaps between rollers.
    #[serde(default)]
    pub mend: bool,
    /// Folders of the ROS packages in which meshes lie: `NAME = "DIR"` for `package://NAME/mesh.stl`, relative to the
    /// scenario file. A package that is not given is looked for in the folders above the robot's file, by its name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub packages: BTreeMap<String, PathBuf>,
    /// Rollers for wheels that have none in the robot's file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wheels: Option<Wheels>,
}

impl Robot {
    /// How the robot's file is to be read, with paths that start from `folder`, out of the files that may be read.
    pub fn load_options(&self, folder: &Path, files: &FileAccess) -> LoadOptions {
        let package = |(name, dir): (&String, &PathBuf)| Package {
            name: name.clone(),
            folder: folder.join(dir),
        };
        LoadOptions {
            packages: self.packages.iter().map(package).collect(),
            mend: self.mend,
            rollers: match self.rollers {
                Rollers::Barrel => RollerForms::Barrel,
                Rollers::AsModelled => RollerForms::AsModelled,
            },
            wheels: self.wheels.as_ref().map(Wheels::options),
            files: files.clone(),
        }
    }
}

/// Rollers for wheels that have none in the robot's file, as most published mobile bases have none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RobotWheelsSection")]
pub struct Wheels {
    /// The wheels' joints. Left out: every turning joint on a level axis with nothing turning above or below it.
    #[serde(default)]
    pub joints: Vec<String>,
    /// How many rollers each wheel carries.
    #[schemars(range(min = 3, max = 1000))]
    pub rollers: usize,
    /// The wheels' radius, in metres; left out, it is taken from their collision geometry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_m: Option<f64>,
    /// The rollers' largest radius, in metres; left out, a fifth of the wheel's, or as much more as it takes to reach
    /// the neighbours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub roller_radius_m: Option<f64>,
    /// Mass of one roller, in kg, taken from the wheel's; left out, that of solid rubber, and at most half of the wheel's
    /// for all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub roller_mass_kg: Option<f64>,
    /// Viscous damping of a roller's bearing, in N m s/rad.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub damping_n_m_s: f64,
    /// Dry friction of a roller's bearing, in N m.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub friction_n_m: f64,
    /// The angle from the hub axis to the rolling direction of the roller on the ground, counter-clockwise from above.
    pub gamma: Gamma,
}

/// The angle gamma of each wheel, in degrees, with its sign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Gamma {
    /// `gamma.x_deg = 45`: mecanum wheels in the usual X; the sign of each follows from its place. All hub axes must lie
    /// along y.
    XDeg(f64),
    /// `gamma.all_deg = 0`: the same for all wheels; 0 is an omni wheel.
    AllDeg(f64),
    /// `gamma.each_deg = [-45, 45, 45, -45]`: one for each joint, in the order of `joints`.
    EachDeg(Vec<f64>),
}

impl Wheels {
    fn options(&self) -> WheelOptions {
        let Self {
            joints,
            rollers,
            radius_m,
            roller_radius_m,
            roller_mass_kg,
            damping_n_m_s,
            friction_n_m,
            gamma,
        } = self.clone();
        WheelOptions {
            joints,
            gamma: match gamma {
                Gamma::XDeg(gamma_deg) => Handedness::XDeg(gamma_deg),
                Gamma::AllDeg(gamma_deg) => Handedness::AllDeg(gamma_deg),
                Gamma::EachDeg(gammas_deg) => Handedness::EachDeg(gammas_deg),
            },
            rollers,
            radius_m,
            roller_radius_m,
            roller_mass_kg,
            damping_n_m_s,
            friction_n_m,
        }
    }
}

/// What rollers touch the ground with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rollers {
    /// The exact barrel, fitted to what the robot's file models.
    #[default]
    Barrel,
    /// The collision shapes of the robot's file as they are, with their gaps and ripple: what other simulators roll on.
    /// `roller_bodies` must be `"all"` then. Rollers that are put in by `robot.wheels` stay barrels.
    AsModelled,
}

/// Which rollers have their shapes in the simulated world. All have their mass, inertia and spin, whichever this is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RollerBodies {
    /// Every roller, always.
    #[default]
    All,
    /// Those that can touch something; the others keep their spin. Faster.
    Near,
}
