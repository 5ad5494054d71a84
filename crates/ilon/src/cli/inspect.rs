//! `ilon inspect`: a robot as it is understood.

use std::path::PathBuf;

use ilon_control::Kinematics;
use ilon_robot::{Handedness, LoadOptions, Package, Robot, RollerForms, WheelOptions};

use super::escape::one_line;
use super::table::Table;
use super::{Outcome, Sandbox, claim, say};
use crate::inspect::Inspection;
use crate::{Error, drawing};

/// Arguments of `ilon inspect`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The robot's URDF.
    robot: PathBuf,
    /// The folder of a ROS package, for meshes at `package://NAME/...`; may be given several times.
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    packages: Vec<Package>,
    /// Mend what is safe to mend in the file, and say what.
    #[arg(long)]
    mend: bool,
    /// Look at the collision shapes of the rollers as they are, as `robot.rollers = "as_modelled"` drives them: gaps
    /// between rollers are no fault then.
    #[arg(long)]
    as_modelled: bool,
    #[command(flatten)]
    wheels: Wheels,
    #[command(flatten)]
    sandbox: Sandbox,
    /// Draw the robot from above, with the axes of its rollers, as an SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
}

/// Rollers for wheels that have none in the file: `[robot.wheels]` of a scenario, on the command line.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Rollers for wheels that have none in the file")]
struct Wheels {
    /// Put this many rollers on each wheel.
    #[arg(long, value_name = "N", requires = "gamma")]
    rollers: Option<usize>,
    /// Their angle gamma in the usual X of mecanum wheels, such as 45; the sign of each follows from its wheel's place.
    #[arg(long, value_name = "DEG", group = "gamma", requires = "rollers")]
    gamma_x_deg: Option<f64>,
    /// Their angle gamma: one number for all wheels, such as 0 for omni wheels, or one for each, with its sign.
    #[arg(
        long,
        value_name = "DEG,..",
        value_delimiter = ',',
        allow_hyphen_values = true,
        group = "gamma",
        requires = "rollers"
    )]
    gamma_deg: Vec<f64>,
    /// The wheels' joints; without it every turning joint on a level axis with nothing turning above or below it.
    #[arg(
        long,
        value_name = "JOINT,..",
        value_delimiter = ',',
        requires = "rollers"
    )]
    wheels: Vec<String>,
    /// The wheels' radius; without it, that of their collision geometry.
    #[arg(long, value_name = "M", requires = "rollers")]
    wheel_radius_m: Option<f64>,
    /// The rollers' largest radius; without it, a fifth of the wheel's, or as much more as it takes to reach the
    /// neighbours.
    #[arg(long, value_name = "M", requires = "rollers")]
    roller_radius_m: Option<f64>,
    /// Mass of one roller, taken from the wheel's; without it, that of solid rubber.
    #[arg(long, value_name = "KG", requires = "rollers")]
    roller_mass_kg: Option<f64>,
}

impl Wheels {
    /// The rollers asked for, if any are.
    fn options(&self) -> Option<WheelOptions> {
        let rollers = self.rollers?;
        let gamma = match (self.gamma_x_deg, self.gamma_deg.as_slice()) {
            (Some(gamma_deg), _) => Handedness::XDeg(gamma_deg),
            (None, [gamma_deg]) => Handedness::AllDeg(*gamma_deg),
            (None, gammas_deg) => Handedness::EachDeg(gammas_deg.to_vec()),
        };
        Some(WheelOptions {
            joints: self.wheels.clone(),
            gamma,
            rollers,
            radius_m: self.wheel_radius_m,
            roller_radius_m: self.roller_radius_m,
            roller_mass_kg: self.roller_mass_kg,
            damping_n_m_s: 0.0,
            friction_n_m: 0.0,
        })
    }
}

/// Prints the robot; one that cannot be controlled is printed too, and then told of as bad input.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let options = LoadOptions {
        packages: arguments.packages.clone(),
        mend: arguments.mend,
        rollers: if arguments.as_modelled {
            RollerForms::AsModelled
        } else {
            RollerForms::Barrel
        },
        wheels: arguments.wheels.options(),
        files: arguments.sandbox.files()?,
    };
    let claim_svg = |path| claim::file(path, "--svg", std::slice::from_ref(&arguments.robot));
    let _claim = arguments.svg.as_deref().map(claim_svg).transpose()?;
    let loaded = Robot::load_with(&arguments.robot, &options)?;
    let inspection = Inspection::of_loaded(&loaded)?;
    if let Some(path) = &arguments.svg {
        ilon_trace::file::write_text(path, &drawing::svg(&loaded.robot))?;
    }
    if arguments.json {
        let json = serde_json::to_string_pretty(&inspection)
            .map_err(|error| Error::encode("the inspection", &error))?;
        say::data(&(json + "\n"))?;
    } else {
        say::lines(&text(&inspection))?;
        if let Some(path) = &arguments.svg {
            let path = path.display().to_string();
            say::lines(&format!("\ndrawn in {}\n", one_line(&path)))?;
        }
    }
    Kinematics::new(&loaded.robot)?;
    Ok(Outcome::Done)
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

/// The wheels as the file's own collision geometry would roll.
fn as_modelled(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "wheels as modelled: radii fitted, mean, of rolling and at the peak, error of the outline, ripple, all in mm; gaps \
         and overlaps in % of a turn; depth of overlaps in mm",
    );
    columns(
        &mut table,
        &[
            "fitted", "mean", "rolling", "peak", "error", "ripple", "gaps", "overlaps", "depth",
        ],
    );
    for outline in &robot.outlines {
        let mm = |metres: f64, decimals: usize| format!("{:.decimals$}", 1e3 * metres);
        let percent = |share: f64| format!("{:.1}", 1e2 * share);
        table.words(
            &outline.wheel,
            &[
                mm(outline.fitted_radius_m, 2),
                mm(outline.mean_radius_m, 2),
                mm(outline.rolling_radius_m, 2),
                mm(outline.peak_radius_m, 2),
                mm(outline.outline_error_m, 3),
                mm(outline.ripple_m, 3),
                percent(outline.gap_share),
                percent(outline.overlap_share),
                mm(outline.overlap_depth_m, 2),
            ],
        );
    }
    table
}

/// A row of names for the columns below it.
fn columns(table: &mut Table, names: &[&str]) {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    table.words("", &names);
}

fn text(robot: &Inspection) -> String {
    let mut table = Table::new();
    table.heading(&robot.name);
    table.row("mass", Some(robot.mass_kg), 3, "kg");
    table.row("wheels", Some(robot.wheels.len() as f64), 0, "");

    table.heading("wheels: place in m, radius in mm, gamma in deg, limits of torque in N m and of rate in rad/s");
    columns(
        &mut table,
        &["x", "y", "z", "radius", "gamma", "torque", "rate"],
    );
    for wheel in &robot.wheels {
        let [x, y, z] = wheel.position_m;
        let number =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
        table.words(
            &wheel.name,
            &[
                format!("{x:.3}"),
                format!("{y:.3}"),
                format!("{z:.3}"),
                format!("{:.1}", 1e3 * wheel.radius_m),
                format!("{:.1}", wheel.gamma_rad.to_degrees()),
                number(wheel.effort_n_m),
                number(wheel.velocity_rad_s),
            ],
        );
    }
    let mut text = table.to_string();

    let mut table = Table::new();
    table.heading("rollers: largest radius and length in mm");
    columns(&mut table, &["count", "radius", "length"]);
    for wheel in &robot.wheels {
        table.words(
            &wheel.name,
            &[
                wheel.rollers.to_string(),
                format!("{:.2}", 1e3 * wheel.roller_radius_m),
                format!("{:.2}", 1e3 * wheel.roller_length_m),
            ],
        );
    }
    text.push_str(&format!("\n{table}"));

    if !robot.outlines.is_empty() {
        text.push_str(&format!("\n{}", as_modelled(robot)));
    }

    let mut table = Table::new();
    table.heading("M, Indiveri 2009, equation (8)");
    for (wheel, row) in robot.wheels.iter().zip(&robot.m) {
        table.row_of(&wheel.name, &row.map(Some), 4, "");
    }
    text.push_str(&format!("\n{table}"));

    let mut table = Table::new();
    table.heading("kinematics");
    table.row("rank of M", Some(robot.rank as f64), 0, "of 3");
    table.row_of("singular values", &robot.singular_values.map(Some), 4, "");
    table.row("condition", robot.condition, 2, "");
    table.words(
        "position and heading",
        &[if robot.decoupled {
            "decoupled"
        } else {
            "coupled"
        }
        .to_owned()],
    );
    if let Some(point) = robot.decoupling_point_m {
        table.row_of("decoupled about", &point.map(Some), 4, "m");
    }
    if let Some(limits) = robot.speed_limits {
        table.row(
            "top speed, slowest direction",
            Some(limits.slowest_direction_m_s),
            3,
            "m/s",
        );
        table.row(
            "top speed, fastest direction",
            Some(limits.fastest_direction_m_s),
            3,
            "m/s",
        );
        table.row(
            "top yaw rate",
            Some(limits.yaw_rate_rad_s.to_degrees()),
            1,
            "deg/s",
        );
    }
    text.push_str(&format!("\n{table}"));

    if let Some(singularity) = &robot.singularity {
        let singularity = one_line(singularity);
        text.push_str(&format!("\ncannot be controlled: {singularity}\n"));
    }
    if !robot.remarks.is_empty() {
        text.push_str("\nremarks on the file\n");
        for (subjects, said) in gathered(&robot.remarks) {
            let remark = format!("{}: {said}", subjects.join(", "));
            text.push_str(&format!("  {}\n", one_line(&remark)));
        }
    }
    text
}

/// Remarks `subject: text`, those of one text together, in the order in which each text comes first.
fn gathered(remarks: &[String]) -> Vec<(Vec<&str>, &str)> {
    let mut gathered: Vec<(Vec<&str>, &str)> = Vec::new();
    for remark in remarks {
        let (subject, said) = remark.split_once(": ").unwrap_or(("", remark));
        match gathered.iter_mut().find(|(_, known)| *known == said) {
            Some((subjects, _)) => subjects.push(subject),
            None => gathered.push((vec![subject], said)),
        }
    }
    gathered
}
