//! `ilon inspect`: a robot as it is understood.

use std::path::PathBuf;

use ilon_control::Kinematics;
use ilon_robot::{LoadOptions, Package, Robot};

use super::Outcome;
use super::table::Table;
use crate::Error;
use crate::inspect::Inspection;

/// Arguments of `ilon inspect`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The robot's URDF.
    robot: PathBuf,
    /// The folder of a ROS package, for meshes at `package://NAME/...`.
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    packages: Vec<Package>,
    /// Mend what is safe to mend in the file, and say what.
    #[arg(long)]
    mend: bool,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
}

/// Prints the robot; one that cannot be controlled is printed too, and then told of as bad input.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let options = LoadOptions {
        packages: arguments.packages.clone(),
        mend: arguments.mend,
        ..LoadOptions::default()
    };
    let robot = Robot::load_with(&arguments.robot, &options)?.robot;
    let inspection = Inspection::of(&robot)?;
    if arguments.json {
        let json = serde_json::to_string_pretty(&inspection)
            .map_err(|error| Error::invalid(error.to_string(), ""))?;
        super::print(&(json + "\n"))?;
    } else {
        super::print(&text(&inspection))?;
    }
    Kinematics::new(&robot)?;
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

fn text(robot: &Inspection) -> String {
    let mut table = Table::new();
    table.heading(&robot.name);
    table.row("mass", Some(robot.mass_kg), 3, "kg");
    table.row("wheels", Some(robot.wheels.len() as f64), 0, "");

    table.heading("wheels: x, y, z [m], radius [mm], gamma [deg], torque [N m], rate [rad/s]");
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
    table.heading("rollers: count, largest radius [mm], length [mm]");
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
        text.push_str(&format!("\ncannot be controlled: {singularity}\n"));
    }
    if !robot.remarks.is_empty() {
        text.push_str("\nremarks on the file\n");
        for remark in &robot.remarks {
            text.push_str(&format!("  {remark}\n"));
        }
    }
    text
}
