//! Command-line options for reading a robot's file.

use std::path::{Path, PathBuf};

use ilon_formats::{
    Handedness, LoadOptions, LoadRobot, Loaded, Package, RollerForms, TyreOptions, WheelOptions,
};
use ilon_robot::Robot;

use super::escape::path_in_line;
use super::failure::Failure;
use super::flags::{Flags, shell};
use super::options::Sandbox;
use crate::Scenario;
use crate::scenario::Setting;
use crate::sim::remedy;

/// Options of reading a robot's file.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub(super) struct Reading {
    #[command(flatten)]
    sources: Sources,
    /// Use the collision shapes of the rollers as they are (`robot.rollers = "as_modelled"`); gaps
    /// are then allowed.
    #[arg(long)]
    as_modelled: bool,
    /// Radius of wheels whose geometry does not show it.
    #[arg(long, value_name = "M")]
    wheel_radius_m: Option<f64>,
    /// Propose no rollers for wheels that have none.
    #[arg(long)]
    no_inferred_rollers: bool,
    #[command(flatten)]
    wheels: Wheels,
}

/// What a robot's file is read with, whatever becomes of the robot.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub(super) struct Sources {
    /// Folder of a ROS package, for `package://NAME/...`; repeatable.
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    packages: Vec<Package>,
    /// Argument of a xacro file; repeatable.
    #[arg(long = "arg", value_name = "NAME=VALUE", value_parser = argument)]
    arguments: Vec<(String, String)>,
    /// Leave out, and report, missing includes, macros and links.
    #[arg(long)]
    leave_out_missing: bool,
    /// Repair what is safe to repair, and report each change.
    #[arg(long, alias = "mend")]
    repair: bool,
    /// Density of a part whose size or mass is missing, for repairs [default: 1500].
    #[arg(long, value_name = "RHO")]
    density_kg_m3: Option<f64>,
}

/// Rollers for wheels that have none in the file: `[robot.wheels]` of a scenario, on the command
/// line.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
#[command(next_help_heading = "Rollers for wheels that have none in the file")]
struct Wheels {
    /// Rollers on each wheel.
    #[arg(long, value_name = "N", requires = "gamma", group = "given")]
    rollers: Option<usize>,
    /// Their angle gamma in the usual X of mecanum wheels, such as 45; -45 is the O.
    #[arg(
        long,
        value_name = "DEG",
        allow_hyphen_values = true,
        group = "gamma",
        requires = "rollers"
    )]
    gamma_x_deg: Option<f64>,
    /// Their angle gamma: one for all wheels, such as 0 for omni wheels, or one each, with sign.
    #[arg(
        long,
        value_name = "DEG,..",
        value_delimiter = ',',
        allow_hyphen_values = true,
        group = "gamma",
        requires = "rollers"
    )]
    gamma_deg: Vec<f64>,
    /// Tyres instead of rollers: of differential, skid-steered and tricycle robots.
    #[arg(long, group = "given", conflicts_with = "gamma")]
    tyres: bool,
    /// Width of a tyre [default: that of the wheel's geometry].
    #[arg(long, value_name = "M", requires = "tyres")]
    tyre_width_m: Option<f64>,
    /// Radius of a tyre's shoulders [default: an eighth of its width].
    #[arg(long, value_name = "M", requires = "tyres")]
    tyre_shoulder_m: Option<f64>,
    /// Joints of wheels on tyres that nothing drives.
    #[arg(
        long,
        value_name = "JOINT,..",
        value_delimiter = ',',
        requires = "tyres"
    )]
    free_wheels: Vec<String>,
    /// The wheels' joints [default: every joint on a level axis that stands on the floor].
    #[arg(
        long,
        value_name = "JOINT,..",
        value_delimiter = ',',
        requires = "given"
    )]
    wheels: Vec<String>,
    /// Largest radius of the rollers [default: a fifth of the wheel's, or more, to reach the
    /// neighbours].
    #[arg(long, value_name = "M", requires = "rollers")]
    roller_radius_m: Option<f64>,
    /// Mass of one roller, taken from the wheel's [default: solid rubber].
    #[arg(long, value_name = "KG", requires = "rollers")]
    roller_mass_kg: Option<f64>,
}

impl Sources {
    /// The requested load options.
    pub(super) fn options(&self) -> LoadOptions {
        let mut options = LoadOptions::default();
        options.packages.clone_from(&self.packages);
        options.arguments = self.arguments.iter().cloned().collect();
        options.leave_out_missing = self.leave_out_missing;
        options.repair = self.repair;
        options.density_kg_m3 = self.density_kg_m3;
        options
    }
}

impl Reading {
    /// The requested load options.
    pub(super) fn options(&self) -> LoadOptions {
        let mut options = self.sources.options();
        if self.as_modelled {
            options.rollers = RollerForms::AsModelled;
        }
        options.wheel_radius_m = self.wheel_radius_m;
        options.infer_rollers = !self.no_inferred_rollers;
        options.wheels = self.wheels.options();
        options.tyres = self.wheels.tyres();
        options
    }

    /// Refuses all of them for a scenario, which says itself how its robot is read.
    pub(super) fn none_beside(&self, scenario: &Path) -> Result<(), Failure> {
        match *self == Self::default() {
            true => Ok(()),
            false => Err(Failure::usage(
                format!(
                    "options of a robot's file are given, and `{}` is a scenario",
                    path_in_line(scenario)
                ),
                "write them under `[robot]` in the scenario, or name the robot's file",
            )),
        }
    }
}

impl Wheels {
    /// The requested tyres, if any.
    fn tyres(&self) -> Option<TyreOptions> {
        let mut options = TyreOptions::on(self.wheels.clone());
        options.free = self.free_wheels.clone();
        options.width_m = self.tyre_width_m;
        options.shoulder_radius_m = self.tyre_shoulder_m;
        self.tyres.then_some(options)
    }

    /// The requested rollers, if any.
    fn options(&self) -> Option<WheelOptions> {
        let gamma = match (self.gamma_x_deg, self.gamma_deg.as_slice()) {
            (Some(gamma_deg), _) => Handedness::XDeg(gamma_deg),
            (None, [gamma_deg]) => Handedness::AllDeg(*gamma_deg),
            (None, gammas_deg) => Handedness::EachDeg(gammas_deg.to_vec()),
        };
        let mut options = WheelOptions::new(self.rollers?, gamma).on(self.wheels.clone());
        options.roller_radius_m = self.roller_radius_m;
        options.roller_mass_kg = self.roller_mass_kg;
        Some(options)
    }
}

/// Loads a robot from a file. `command` names the calling command, for the error of a file that
/// needs options.
pub(super) fn load(
    path: &Path,
    options: &LoadOptions,
    command: &str,
    sandbox: &Sandbox,
) -> Result<Loaded, Failure> {
    Ok(Robot::load_with(path, options).map_err(|fault| {
        let robot = shell(&path.display().to_string());
        let command = format!("{command} {robot}{}", sandbox.words());
        remedy::diagnosed(fault, path, options, &Flags { command })
    })?)
}

/// A scenario made from a robot's file alone, with further lines of TOML and settings. A robot that
/// needs options is refused with the command that tries them, as there is no scenario to edit.
pub(super) fn robot_alone(
    path: &Path,
    lines: &str,
    settings: &[Setting],
    sandbox: &Sandbox,
) -> Result<Scenario, Failure> {
    let mut options = LoadOptions::default();
    options.files = sandbox.files()?;
    if settings.is_empty() {
        load(path, &options, "ilon inspect", sandbox)?;
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let text = format!("{}{lines}", robot_line(path)?);
    Ok(Scenario::from_toml_with(
        &text,
        &name,
        "",
        settings,
        &options.files,
    )?)
}

/// The line of a scenario that names a robot's file, valid wherever the scenario lies.
pub(super) fn robot_line(path: &Path) -> Result<String, Failure> {
    let file = std::path::absolute(path).map_err(|source| Failure::write(path, &source))?;
    let file = toml::Value::from(file.display().to_string());
    Ok(format!("robot.file = {file}\n"))
}

fn package(text: &str) -> Result<Package, String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => Ok(Package {
            name: name.to_owned(),
            folder: PathBuf::from(folder),
        }),
        _ => Err("write NAME=DIR, such as my_robot=../my_robot".to_owned()),
    }
}

/// Parses `NAME=VALUE`, or `NAME:=VALUE` as in ROS xacro.
fn argument(text: &str) -> Result<(String, String), String> {
    let split = text.split_once(":=").or_else(|| text.split_once('='));
    match split {
        Some((name, value)) if !name.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.to_owned()))
        }
        _ => Err("write NAME=VALUE, such as mecanum=true".to_owned()),
    }
}
