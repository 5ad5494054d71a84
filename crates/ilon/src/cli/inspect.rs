//! `ilon inspect`: a robot as it is understood.

use std::path::PathBuf;

use ilon_control::Kinematics;
use ilon_formats::LoadRobot;
use ilon_robot::Robot;

use super::escape::one_line;
use super::flags::{Flags, shell};
use super::options::Sandbox;
use super::outcome::Outcome;
use super::robot::{Reading, robot_of_scenario};
use super::table::Table;
use super::{console, gallery, limits, open, planners, reserve, ros2};
use crate::cli::failure::Failure;
use crate::drawing;
use crate::inspect::{Inspection, TreadInspection, WheelInspection};
use crate::pages;
use crate::sim::remedy;

/// Arguments of `ilon inspect`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The robot's file: URDF, xacro, SDF, MJCF, or a description in TOML; with `--html`, a folder of them too.
    robot: PathBuf,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    sandbox: Sandbox,
    #[command(flatten)]
    limits: limits::Asked,
    #[command(flatten)]
    planners: planners::Exports,
    /// Draw the robot from above, with the axes of its rollers, as an SVG; with `--limits` how hard it may be driven in each direction.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    svg: Option<PathBuf>,
    /// Write the URDF that was read: expanded, converted and repaired.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    urdf: Option<PathBuf>,
    /// Write parameters for ros2_controllers' mecanum_drive_controller or omni_wheel_drive_controller, with the radius that the
    /// wheels roll on, and speeds for Nav2's MPPI controller, as YAML.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    ros2_controllers: Option<PathBuf>,
    /// Write the robot's URDF with a `<ros2_control>` block for its wheels.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    ros2_control: Option<PathBuf>,
    /// Show the robot on one offline page: in three dimensions with its wheels turning, from above, and what it can do; the
    /// robots of a folder and below side by side, with why a file is refused.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    html: Option<PathBuf>,
    /// Open the page in the browser.
    #[arg(long, requires = "html", help_heading = "Output")]
    open: bool,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Prints the robot; one that cannot be controlled is printed too, and then reported as bad input.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let path = &arguments.robot;
    let mut options = arguments.reading.options();
    options.files = arguments.sandbox.files()?;
    let claimed = |out: &Option<PathBuf>, flag| {
        let claim = |out: &PathBuf| reserve::file(out, flag, std::slice::from_ref(path));
        out.as_ref().map(claim).transpose()
    };
    if arguments.limits.are_idle() {
        return Err(Failure::usage(
            "--set changes joints, `robot.joints.NAME`, or the conditions of --limits, which is not there",
            "add --limits",
        ));
    }
    let _svg = claimed(&arguments.svg, "--svg")?;
    let _urdf = claimed(&arguments.urdf, "--urdf")?;
    let _controllers = claimed(&arguments.ros2_controllers, "--ros2-controllers")?;
    let _control = claimed(&arguments.ros2_control, "--ros2-control")?;
    let _html = claimed(&arguments.html, "--html")?;
    let _planners = arguments.planners.claim(path)?;
    if let Some(robot) = robot_of_scenario(path, &options.files) {
        return Err(Failure::usage(
            format!("`{}` is a scenario, not a robot", path.display()),
            format!(
                "inspect its robot, `ilon inspect {}`, or run it",
                shell(&robot)
            ),
        ));
    }
    if path.is_dir() {
        let one_only = arguments.json
            || arguments.limits.limits
            || [
                &arguments.svg,
                &arguments.urdf,
                &arguments.ros2_controllers,
                &arguments.ros2_control,
            ]
            .iter()
            .any(|out| out.is_some());
        if let Some(html) = arguments.html.as_ref().filter(|_| !one_only) {
            gallery::run(path, &options, &arguments.sandbox.words(), html)?;
            if arguments.open {
                open::page(html);
            }
            return Ok(Outcome::Done);
        }
        return Err(Failure::usage(
            format!("`{}` is a folder", path.display()),
            "name the file of a robot, or see all of the folder side by side with `--html FILE`",
        ));
    }
    let scenario = arguments.limits.scenario(&options.files)?;
    options.joints = scenario
        .robot
        .load_options(&scenario.folder, &options.files)
        .joints;
    let loaded = Robot::load_with(path, &options).map_err(|fault| {
        let robot = shell(&path.display().to_string());
        let command = format!("ilon inspect {robot}{}", arguments.sandbox.words());
        remedy::diagnosed(fault, path, &options, &Flags { command })
    })?;
    let inspection = Inspection::of_standing(&loaded, &scenario)?;
    let inspection = arguments
        .limits
        .add_to(inspection, &loaded.robot, &options.files)?;
    if let Some(svg) = &arguments.svg {
        let from_above =
            || drawing::svg(&loaded.robot, inspection.decoupling_point_m.map(Into::into));
        let picture = drawing::limits(&inspection).unwrap_or_else(from_above);
        ilon_trace::file::write_text(svg, &picture)?;
    }
    if let Some(html) = &arguments.html {
        pages::robot::write(html, &loaded, &inspection)?;
    }
    if let Some(urdf) = &arguments.urdf {
        ilon_trace::file::write_text(urdf, &loaded.urdf)?;
    }
    ros2::write(
        &loaded,
        inspection.limits.as_ref(),
        arguments.ros2_controllers.as_deref(),
        arguments.ros2_control.as_deref(),
    )?;
    arguments
        .planners
        .write(&loaded, &inspection, &arguments.limits, &options.files)?;
    if arguments.json {
        let json = serde_json::to_string_pretty(&inspection)
            .map_err(|error| Failure::encode("the inspection", &error))?;
        console::data(&(json + "\n"))?;
    } else {
        match &inspection.limits {
            Some(limits) => console::lines(&limits::text(&inspection.name, limits))?,
            None => console::lines(&text(&inspection))?,
        }
        for path in [&arguments.svg, &arguments.html].into_iter().flatten() {
            let path = path.display().to_string();
            console::lines(&format!("\ndrawn in {}\n", one_line(&path)))?;
        }
    }
    if let Some(html) = arguments.html.as_ref().filter(|_| arguments.open) {
        open::page(html);
    }
    Kinematics::new(&loaded.robot)?;
    Ok(Outcome::Done)
}

/// The wheels as the file's own collision geometry would roll.
fn as_modelled(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "wheels as modelled: radii fitted, mean, of rolling and at the peak, error of the outline, ripple; share of \
         a turn on bridges between rollers, and how deep it is below them; overlap of rollers in % of a turn, and how deep it is. \
         Lengths in mm, shares in %",
    );
    columns(
        &mut table,
        &[
            "fitted", "mean", "rolling", "peak", "error", "ripple", "bridged", "hollow", "overlap",
            "depth",
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
                mm(outline.gap_depth_m, 2),
                percent(outline.overlap_share),
                mm(outline.overlap_depth_m, 2),
            ],
        );
    }
    table
}

/// What the rollers of wheels are made of.
fn materials(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "materials of the rollers, which `[materials]` of a scenario pairs with those of the floor",
    );
    for wheel in &robot.wheels {
        let material = wheel.material.as_deref().unwrap_or("-");
        table.words(&wheel.name, &[material.to_owned()]);
    }
    table
}

/// What rollers that give, drag or have play touch the ground with and are held by.
fn surfaces(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "treads: stiffness in N/mm and damping in N s/m, along the ground's normal and across it; sag under a wheel's share of \
         the weight and the way over which sheared tread is renewed in mm; drag per load of rolling; play along the rollers' axles in mm; most torque of friction on them under that share in mN m",
    );
    columns(
        &mut table,
        &[
            "along", "across", "damped", "across", "sag", "renewed", "drag", "play", "axle",
        ],
    );
    for wheel in &robot.wheels {
        let Some(surface) = &wheel.surface else {
            continue;
        };
        let of_tread = |value: fn(&TreadInspection) -> Option<f64>, decimals: usize| {
            let value = surface.tread.as_ref().and_then(value);
            value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
        };
        table.words(
            &wheel.name,
            &[
                of_tread(|tread| Some(1e-3 * tread.stiffness_n_m), 1),
                of_tread(|tread| Some(1e-3 * tread.shear_stiffness_n_m), 1),
                of_tread(|tread| Some(tread.damping_n_s_m), 1),
                of_tread(|tread| Some(tread.shear_damping_n_s_m), 1),
                of_tread(|tread| Some(1e3 * tread.sag_m), 3),
                of_tread(|tread| Some(1e3 * tread.relaxation_length_m?), 1),
                format!("{:.3}", surface.rolling_resistance),
                format!("{:.3}", 1e3 * surface.axial_play_m),
                format!("{:.2}", 1e3 * surface.axle_drag_n_m),
            ],
        );
    }
    table
}

/// How rollers are made where they do not make a circle of the wheel's outline.
fn made(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "rollers as made: curvature along the roller over the ideal barrel's, its radius, least and largest radius of the rollers, \
         travel of the hub in a turn and its mean height; lengths in mm",
    );
    columns(
        &mut table,
        &[
            "crown",
            "its radius",
            "least",
            "largest",
            "travel",
            "height",
        ],
    );
    let or_none = |value: Option<f64>, decimals: usize| {
        value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    for (name, made) in robot
        .wheels
        .iter()
        .filter_map(|wheel| Some((&wheel.name, wheel.made?)))
    {
        table.words(
            name,
            &[
                or_none(made.crown, 3),
                or_none(made.crown_radius_m.map(|m| 1e3 * m), 2),
                or_none(Some(1e3 * made.least_radius_m), 3),
                or_none(Some(1e3 * made.largest_radius_m), 3),
                or_none(Some(1e3 * made.hub_travel_m), 3),
                or_none(Some(1e3 * made.mean_height_m), 3),
            ],
        );
    }
    table
}

/// The joints between bodies that move.
fn joints(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "joints: role; where they stand and how far they go, in deg or mm, of which M, loads and limits are; the wheels that they move",
    );
    columns(
        &mut table,
        &["moves", "role", "stands", "from", "to", "wheels"],
    );
    for joint in &robot.joints {
        let unit = match joint.moves {
            "turns" => 1_f64.to_degrees(),
            _ => 1e3,
        };
        let number = |value: f64| format!("{:.2}", unit * value);
        let limit = |value: Option<f64>| value.map_or("-".to_owned(), number);
        table.words(
            &joint.name,
            &[
                joint.moves.to_owned(),
                joint.role.to_owned(),
                number(joint.position),
                limit(joint.limits[0]),
                limit(joint.limits[1]),
                joint.moves_wheels.len().to_string(),
            ],
        );
    }
    table
}

/// What each wheel bears at rest.
fn loads(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading("loads at rest on level ground, in N");
    for wheel in &robot.wheels {
        table.words(&wheel.name, &[format!("{:.3}", wheel.load_n)]);
    }
    table
}

/// A row of names for the columns below it.
fn columns(table: &mut Table, names: &[&str]) {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    table.words("", &names);
}

fn text(robot: &Inspection) -> String {
    let any = |has: fn(&WheelInspection) -> bool| robot.wheels.iter().any(has);
    let mut tables = vec![wheels(robot), rollers(robot)];
    if !robot.joints.is_empty() {
        tables.extend([joints(robot), loads(robot)]);
    }
    if any(|wheel| wheel.material.is_some()) {
        tables.push(materials(robot));
    }
    if any(|wheel| wheel.surface.is_some()) {
        tables.push(surfaces(robot));
    }
    if any(|wheel| wheel.made.is_some()) {
        tables.push(made(robot));
    }
    if !robot.outlines.is_empty() {
        tables.push(as_modelled(robot));
    }
    tables.extend([matrix(robot), kinematics(robot)]);
    let tables: Vec<String> = tables.iter().map(ToString::to_string).collect();
    let mut text = tables.join("\n");

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

/// The robot, and where its wheels are.
fn wheels(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(&robot.name);
    table.row("mass", Some(robot.mass_kg), 3, "kg");
    table.row("wheels", Some(robot.wheels.len() as f64), 0, "");
    table.heading("wheels: place in m, radius in mm, gamma in deg, limits of torque in N m and of rate in rad/s");
    columns(
        &mut table,
        &["x", "y", "z", "radius", "gamma", "torque", "rate"],
    );
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    for wheel in &robot.wheels {
        let [x, y, z] = wheel.position_m;
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
    table
}

fn rollers(robot: &Inspection) -> Table {
    let on_axles = |wheel: &WheelInspection| {
        let surface = wheel.surface.as_ref();
        surface.is_some_and(|surface| surface.axle_friction > 0.0)
    };
    let mut table = Table::new();
    table.heading(match robot.wheels.iter().any(on_axles) {
        true => "rollers: largest radius and length in mm",
        false => {
            "rollers: largest radius and length in mm; friction on their axles that follows the load is taken as none, which ball bearings \
             nearly have and bushings do not"
        }
    });
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
    table
}

fn matrix(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading("M, Indiveri 2009, equation (8)");
    for (wheel, row) in robot.wheels.iter().zip(&robot.m) {
        table.row_of(&wheel.name, &row.map(Some), 4, "");
    }
    table
}

fn kinematics(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading("kinematics");
    table.row("rank of M", Some(robot.rank as f64), 0, "of 3");
    table.row_of("singular values", &robot.singular_values.map(Some), 4, "");
    table.row("condition", robot.condition, 2, "");
    let coupled = match robot.decoupled {
        true => "decoupled",
        false => "coupled",
    };
    table.words("position and heading", &[coupled.to_owned()]);
    if let Some(point) = robot.decoupling_point_m {
        table.row_of("decoupled about", &point.map(Some), 4, "m");
    }
    if let Some(limits) = robot.speed_limits {
        for (name, speed_m_s) in [
            ("top speed, slowest direction", limits.slowest_direction_m_s),
            ("top speed, fastest direction", limits.fastest_direction_m_s),
        ] {
            table.row(name, Some(speed_m_s), 3, "m/s");
        }
        let rate_deg_s = limits.yaw_rate_rad_s.to_degrees();
        table.row("top yaw rate", Some(rate_deg_s), 1, "deg/s");
    }
    table
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
