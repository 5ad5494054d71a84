//! Options for reading a robot.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

use crate::files::FileAccess;
use crate::packages::{Machine, Package};

/// How to read a robot.
#[derive(Clone, Debug, SmartDefault, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct LoadOptions {
    /// Where ROS packages lie: `package://NAME/mesh.stl` is read from the folder given for NAME. A
    /// package that is not given is looked for around the file, by its name.
    pub packages: Vec<Package>,
    /// The values of a xacro file's arguments, `<xacro:arg name="...">`, by name; those left out
    /// have their defaults.
    pub arguments: BTreeMap<String, String>,
    /// Whether what is not there is left out, and each part that is left out remarked: a xacro
    /// file's includes that cannot be found, with the macros that they would define, and links that
    /// then hang by nothing.
    pub leave_out_missing: bool,
    /// Which files may be read: the robot's own, those that it includes, and the meshes that it
    /// names. Where only some may be, a xacro file sees nothing of the environment.
    #[serde(skip)]
    pub files: FileAccess,
    /// Repairs what can be repaired safely, and remarks each change with its line: missing and
    /// impossible inertias, elements and names that stand twice, gaps between rollers, wheels some
    /// millimetres off the floor, hubs that do not turn.
    #[serde(alias = "mend")]
    pub repair: bool,
    /// Density of a part of which no mass is known, in kg/m^3, for repairs; left out,
    /// [`Self::DENSITY_KG_M3`].
    pub density_kg_m3: Option<f64>,
    /// What rollers touch the ground with.
    pub rollers: RollerForms,
    /// Puts rollers into wheels that have none in the file.
    pub wheels: Option<WheelOptions>,
    /// Lets wheels that have no rollers in the file roll on tyres.
    pub tyres: Option<TyreOptions>,
    /// The radius rho of wheels whose geometry does not show it, or cannot be read, in metres.
    /// Rollers that are in the file without geometry reach it at their middles, and their
    /// neighbours at their ends.
    pub wheel_radius_m: Option<f64>,
    /// What joints that are neither a wheel's nor a roller's do, by their names; those left out are
    /// sprung where the file gives them a spring, free where they carry wheels on both sides of
    /// their axis and nothing drives them, and else held at zero.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub joints: BTreeMap<String, JointOptions>,
    /// What is otherwise than in the file, where the file is a description in TOML: keys of
    /// [`Spec`](crate::Spec), those of tables within tables, those of a list by their index from 0.
    /// A value replaces the one of that key.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    pub spec: toml::Table,
    /// Whether wheels without rollers are given some where the file itself says which they are: by
    /// friction directions, a drive plug-in, wheels that could not roll otherwise, or by calling
    /// them mecanum or omni wheels. What they were given is remarked.
    #[default = true]
    pub infer_rollers: bool,
}

impl LoadOptions {
    /// Density of a part of which only the size, or only the mass, is known, in kg/m^3: between
    /// plastic and aluminium.
    pub const DENSITY_KG_M3: f64 = 1500.0;

    /// The density used by repairs.
    pub(crate) fn density(&self) -> f64 {
        self.density_kg_m3.unwrap_or(Self::DENSITY_KG_M3)
    }

    /// Returns the machine as visible with these options.
    pub(crate) fn machine(&self) -> Machine {
        Machine {
            given: self.packages.clone(),
            files: self.files.clone(),
        }
    }
}

/// What rollers touch the ground with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "Rollers")]
pub enum RollerForms {
    /// The exact barrel, fitted to what the robot's file models.
    #[default]
    Barrel,
    /// The collision shapes of the robot's file as they are, with their gaps and ripple: what other
    /// simulators roll on. `roller_bodies` must be `"all"` then. Rollers that are put in by
    /// `robot.wheels` stay barrels.
    AsModelled,
}

/// Rollers for wheels that have none in the robot's file, as most published mobile bases have none.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RobotWheelsSection")]
#[non_exhaustive]
pub struct WheelOptions {
    /// The wheels' joints, of any type [default: every joint on a level axis that stands on the
    /// common floor].
    #[serde(default)]
    pub joints: Vec<String>,
    /// Rollers on each wheel.
    #[schemars(range(min = 3, max = 1000))]
    pub rollers: usize,
    /// Largest radius of the rollers, in metres [default: a fifth of the wheel's, or more, to reach
    /// the neighbours].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub roller_radius_m: Option<f64>,
    /// Mass of one roller, in kg, taken from the wheel's [default: solid rubber, all together at
    /// most half of the wheel].
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
    /// Angle from the hub axis to the rolling direction of the lowest roller, counter-clockwise
    /// from above.
    pub gamma: Handedness,
}

impl WheelOptions {
    /// So many rollers of an angle on each wheel, everything else left to the file.
    pub fn new(rollers: usize, gamma: Handedness) -> Self {
        Self {
            joints: Vec::new(),
            gamma,
            rollers,
            roller_radius_m: None,
            roller_mass_kg: None,
            damping_n_m_s: 0.0,
            friction_n_m: 0.0,
        }
    }

    /// The same for the joints of these names.
    pub fn on(mut self, joints: Vec<String>) -> Self {
        self.joints = joints;
        self
    }
}

/// Tyres of driven wheels without rollers: of differential, skid-steered, tricycle and swerve
/// robots.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "RobotTyresSection")]
#[non_exhaustive]
pub struct TyreOptions {
    /// The wheels' joints [default: every joint on a level axis that stands on the common floor,
    /// but for casters].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<String>,
    /// Those of other joints whose tyres nothing drives, such as the rear axle of a tricycle.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<String>,
    /// Width of a tyre, in metres [default: that of the wheel's geometry].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub width_m: Option<f64>,
    /// Radius of a tyre's shoulders, in metres, below half of its width: the tyre touches in its
    /// middle and where they begin [default: an eighth of the width, which scrubs in a turn like a
    /// line of the tyre's width].
    #[schemars(range(min = 0.0))]
    pub shoulder_radius_m: Option<f64>,
}

impl TyreOptions {
    /// Tyres on the joints of these names, as their geometry shows them.
    pub fn on(joints: Vec<String>) -> Self {
        Self {
            joints,
            ..Self::default()
        }
    }
}

/// The angle gamma of each wheel, in degrees, with its sign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(rename = "Gamma")]
pub enum Handedness {
    /// `gamma.x_deg = 45`: mecanum wheels in the usual X, -45: in the O. All hub axes must be
    /// parallel.
    XDeg(f64),
    /// `gamma.all_deg = 0`: the same for all wheels; 0 is an omni wheel.
    AllDeg(f64),
    /// `gamma.each_deg = [-45, 45, 45, -45]`: one for each wheel, in the order of `joints`.
    EachDeg(Vec<f64>),
}

/// What a joint that is neither a wheel's nor a roller's does. Numbers are in the units of how it
/// moves: those with `rad` of a joint that turns, those without of one that slides.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct JointOptions {
    /// Its role [default: sprung where a stiffness is given].
    pub role: Option<RoleOption>,
    /// Stiffness of its spring or servo, in N/m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness_n_m: Option<f64>,
    /// Stiffness of its spring or servo, in N m/rad.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness_n_m_rad: Option<f64>,
    /// Viscous damping, or a servo's, in N s/m [default: the robot's file; of a servo critical].
    #[schemars(range(min = 0.0))]
    pub damping_n_s_m: Option<f64>,
    /// Viscous damping, or a servo's, in N m s/rad [default: the robot's file; of a servo
    /// critical].
    #[schemars(range(min = 0.0))]
    pub damping_n_m_s_rad: Option<f64>,
    /// Position at which the spring acts with its preload alone, in metres [default: 0].
    pub rest_m: Option<f64>,
    /// Position at which the spring acts with its preload alone, in radians [default: 0].
    pub rest_rad: Option<f64>,
    /// Force of the spring at its rest, along the joint's axis, in N [default: 0].
    pub preload_n: Option<f64>,
    /// Torque of the spring at its rest, about the joint's axis, in N m [default: 0].
    pub preload_n_m: Option<f64>,
    /// Dry friction, in N [default: the robot's file].
    #[schemars(range(min = 0.0))]
    pub friction_n: Option<f64>,
    /// Dry friction, in N m [default: the robot's file].
    #[schemars(range(min = 0.0))]
    pub friction_n_m: Option<f64>,
    /// Largest force of a servo, in N [default: the robot's file].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub effort_n: Option<f64>,
    /// Largest torque of a servo, in N m [default: the robot's file].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub effort_n_m: Option<f64>,
    /// Largest rate of a servo's target, in m/s [default: the robot's file].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rate_limit_m_s: Option<f64>,
    /// Largest rate of a servo's target, in rad/s [default: the robot's file].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rate_limit_rad_s: Option<f64>,
    /// Position that a servo holds, instead of setpoints, in metres [default: 0].
    pub target_m: Option<f64>,
    /// Position that a servo holds, instead of setpoints, in radians [default: 0].
    pub target_rad: Option<f64>,
}

/// What acts in a joint beside its damping and friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "RobotJointRole")]
pub enum RoleOption {
    /// Nothing: a rocker.
    Free,
    /// A spring.
    Sprung,
    /// A servo that goes to setpoints: an arm, a lift, a turret. `stiffness_*` and `damping_*` are
    /// the servo's; left out, they swing what the joint moves at most at 10 Hz, critically damped.
    /// What the robot's file has of damping and friction acts beside it.
    Driven,
    /// It does not move.
    Held,
}

/// The numbers of [`JointOptions`], in the units of their joint.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointNumbers {
    pub stiffness: Option<f64>,
    pub damping: Option<f64>,
    pub rest: Option<f64>,
    pub preload: Option<f64>,
    pub friction: Option<f64>,
    pub effort: Option<f64>,
    pub rate_limit: Option<f64>,
    pub target: Option<f64>,
}

impl JointOptions {
    /// Returns the target position of a servo, in rad or m, if given.
    pub fn target(&self) -> Option<f64> {
        self.target_m.or(self.target_rad)
    }

    /// Returns its numbers in the units of a joint that slides or turns.
    ///
    /// # Errors
    /// A message, if a value has the other unit, or is out of its range.
    pub(crate) fn numbers(&self, slides: bool) -> Result<JointNumbers, String> {
        type Given<'a> = (&'a str, Option<f64>);
        let number = |(least, range): (f64, &str), of_slide: Given<'_>, of_turn: Given<'_>| {
            let ((name, given), (other, of_other), moves) = match slides {
                true => (of_slide, of_turn, "slides"),
                false => (of_turn, of_slide, "turns"),
            };
            if of_other.is_some() {
                return Err(format!("it {moves}, and has no `{other}`: write `{name}`"));
            }
            match given {
                Some(value) if !(value.is_finite() && value >= least) => {
                    Err(format!("`{name}` is {value}, but must be {range}"))
                }
                _ => Ok(given),
            }
        };
        let any = (f64::MIN, "finite");
        let not_below_0 = (0.0, "finite and not below 0");
        let above_0 = (f64::MIN_POSITIVE, "finite and above 0");
        macro_rules! one_of {
            ($range:expr, $slides:ident, $turns:ident) => {{
                let [of_slide, of_turn] = [stringify!($slides), stringify!($turns)];
                number($range, (of_slide, self.$slides), (of_turn, self.$turns))?
            }};
        }
        Ok(JointNumbers {
            stiffness: one_of!(above_0, stiffness_n_m, stiffness_n_m_rad),
            damping: one_of!(not_below_0, damping_n_s_m, damping_n_m_s_rad),
            rest: one_of!(any, rest_m, rest_rad),
            preload: one_of!(any, preload_n, preload_n_m),
            friction: one_of!(not_below_0, friction_n, friction_n_m),
            effort: one_of!(above_0, effort_n, effort_n_m),
            rate_limit: one_of!(above_0, rate_limit_m_s, rate_limit_rad_s),
            target: number(
                any,
                ("target_m` or `position_m", self.target_m),
                ("target_rad` or `position_rad", self.target_rad),
            )?,
        })
    }
}
