//! `ilon inspect`: prints a robot as ilon interprets it.

use std::path::PathBuf;

use ilon_control::Kinematics;
use ilon_files::FileAccess;
use ilon_formats::{LoadOptions, Loaded, WheelOutline};
use ilon_trace::file::write_text;

use super::escape::{folded, path_in_line, sentence};
use super::kind::{Kind, wants};
use super::options::Sandbox;
use super::outcome::Outcome;
use super::robot::{Reading, load};
use super::table::Table;
use super::{console, flags, gallery, limits, open, planners, reserve, ros2};
use crate::cli::failure::Failure;
use crate::cli::json::pretty;
use crate::drawing;
use crate::inspect::{
    Inspection, JointInspection, MadeInspection, SurfaceInspection, TreadInspection,
    TyreInspection, TyresInspection, WheelInspection,
};
use crate::pages;
use crate::sim::remedy;

/// Arguments of `ilon inspect`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The robot's file: URDF, xacro, SDF, MJCF, or TOML; with `--html` a folder too.
    robot: PathBuf,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    sandbox: Sandbox,
    #[command(flatten)]
    limits: limits::Asked,
    #[command(flatten)]
    planners: planners::Exports,
    /// Draw the robot from above as SVG; with `--limits` its limits by direction.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    svg: Option<PathBuf>,
    /// Write the URDF that was read: expanded, converted and repaired.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    urdf: Option<PathBuf>,
    /// Write YAML for ros2_controllers (mecanum, omni, differential, tricycle, Ackermann, bicycle),
    /// with the rolling radius, and speeds for Nav2's MPPI controller.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    ros2_controllers: Option<PathBuf>,
    /// Write the robot's URDF with a `<ros2_control>` block for its wheels.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    ros2_control: Option<PathBuf>,
    /// Write an offline page of the robot in 3D, or of all robots below a folder.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    html: Option<PathBuf>,
    /// Open the page in the browser.
    #[arg(long, requires = "html", help_heading = "Output")]
    open: bool,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Prints the robot. One that cannot be controlled is printed too, and then reported as bad input.
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
    wants(path, &[Kind::Robot], &options.files)?;
    if path.is_dir() {
        return folder(arguments, &options);
    }
    let scenario = arguments.limits.scenario(&options.files)?;
    options.joints = scenario
        .robot
        .load_options(&scenario.folder, &options.files)
        .joints;
    let loaded = load(path, &options, "ilon inspect", &arguments.sandbox)?;
    let inspection = Inspection::of_standing(&loaded, &scenario)?;
    // Planners take real swerve drives without limits of acceleration.
    let (is_swerve, is_mecanum) = arguments.planners.are_asked();
    let inspection = match inspection.tyres.is_some() && (is_swerve || is_mecanum) {
        true => inspection,
        false => arguments
            .limits
            .add_to(inspection, &loaded.robot, &options.files)?,
    };
    write(arguments, &options.files, &loaded, &inspection)?;
    if arguments.json {
        console::data(&pretty("the inspection", &inspection)?)?;
    } else {
        match &inspection.limits {
            Some(limits) => console::lines(&limits::text(&inspection.name, limits))?,
            None => console::lines(&text(&inspection))?,
        }
        let robot = flags::shell(&path.display().to_string());
        let keys = remedy::keys(&options, &LoadOptions::default());
        let settings: String = keys
            .iter()
            .map(|key| {
                let setting = format!("robot.{}", key.replacen(" = ", "=", 1));
                format!(" --set {}", flags::shell(&setting))
            })
            .collect();
        let next = format!(
            "next: drive it, `ilon run {robot}{settings}{}{}`",
            arguments.limits.settings_in_words(),
            arguments.sandbox.words()
        );
        console::lines(&format!("\n{}\n", folded(&next)))?;
        for path in [&arguments.svg, &arguments.html].into_iter().flatten() {
            console::lines(&format!("\ndrawn in {}\n", path_in_line(path)))?;
        }
    }
    if let Some(html) = arguments.html.as_ref().filter(|_| arguments.open) {
        open::page(html);
    }
    Kinematics::new(&loaded.robot)?;
    Ok(Outcome::Done)
}

/// Inspects the robots of a folder side by side; refused with options that apply to a single robot.
fn folder(arguments: &Arguments, options: &LoadOptions) -> Result<Outcome, Failure> {
    let of_one = [
        &arguments.svg,
        &arguments.urdf,
        &arguments.ros2_controllers,
        &arguments.ros2_control,
    ];
    let of_one = of_one.iter().any(|out| out.is_some());
    let html = arguments.html.as_ref();
    let Some(html) = html.filter(|_| !(arguments.json || arguments.limits.limits || of_one)) else {
        return Err(Failure::usage(
            format!("`{}` is a folder", arguments.robot.display()),
            "name the file of a robot, or see all of the folder side by side with `--html FILE`",
        ));
    };
    gallery::run(&arguments.robot, options, &arguments.sandbox.words(), html)?;
    if arguments.open {
        open::page(html);
    }
    Ok(Outcome::Done)
}

/// Writes the requested files.
fn write(
    arguments: &Arguments,
    files: &FileAccess,
    loaded: &Loaded,
    inspection: &Inspection,
) -> Result<(), Failure> {
    if let Some(svg) = &arguments.svg {
        let from_above =
            || drawing::svg(&loaded.robot, inspection.decoupling_point_m.map(Into::into));
        let picture = drawing::limits(inspection).unwrap_or_else(from_above);
        write_text(svg, &picture)?;
    }
    if let Some(html) = &arguments.html {
        write_text(html, &pages::robot::html(loaded, inspection))?;
    }
    if let Some(urdf) = &arguments.urdf {
        write_text(urdf, &loaded.urdf)?;
    }
    ros2::write(
        loaded,
        inspection.limits.as_ref(),
        arguments.ros2_controllers.as_deref(),
        arguments.ros2_control.as_deref(),
    )?;
    let (planners, limits) = (&arguments.planners, &arguments.limits);
    planners.write(loaded, inspection, limits, files)
}

/// The wheels as the file's own collision geometry would roll.
fn as_modelled(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "wheel outlines of the file in mm: radius fitted, rolling and peak; outline error and ripple",
    );
    let mm = |metres: f64, decimals: usize| format!("{:.decimals$}", 1e3 * metres);
    table.columns::<&WheelOutline>(
        &[
            ("fitted", &|of| mm(of.fitted_radius_m, 2)),
            ("rolling", &|of| mm(of.rolling_radius_m, 2)),
            ("peak", &|of| mm(of.peak_radius_m, 2)),
            ("error", &|of| mm(of.outline_error_m, 3)),
            ("ripple", &|of| mm(of.ripple_m, 3)),
        ],
        robot.outlines.iter().map(|of| (of.wheel.as_str(), of)),
    );
    table
}

/// The materials of the wheels' rollers.
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

/// Contact and axle properties of rollers with compliance, drag or play.
fn surfaces(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "treads: stiffness in N/mm and damping in N s/m, along the ground's normal and across it; sag under a wheel's share of \
         the weight and the way over which sheared tread is renewed in mm; drag per load of rolling; play along the rollers' axles in mm; most torque of friction on them under that share in mN m",
    );
    type Surface<'s> = &'s SurfaceInspection;
    let of_tread = |of: Surface, value: fn(&TreadInspection) -> Option<f64>, decimals: usize| {
        or_dash(of.tread.as_ref().and_then(value), decimals)
    };
    let surfaces = robot.wheels.iter();
    let surfaces =
        surfaces.filter_map(|wheel| Some((wheel.name.as_str(), wheel.surface.as_ref()?)));
    table.columns::<Surface>(
        &[
            ("along", &|of| {
                of_tread(of, |tread| Some(1e-3 * tread.stiffness_n_m), 1)
            }),
            ("across", &|of| {
                of_tread(of, |tread| Some(1e-3 * tread.shear_stiffness_n_m), 1)
            }),
            ("damped", &|of| {
                of_tread(of, |tread| Some(tread.damping_n_s_m), 1)
            }),
            ("across", &|of| {
                of_tread(of, |tread| Some(tread.shear_damping_n_s_m), 1)
            }),
            ("sag", &|of| {
                of_tread(of, |tread| Some(1e3 * tread.sag_m), 3)
            }),
            ("renewed", &|of| {
                of_tread(of, |tread| Some(1e3 * tread.relaxation_length_m?), 1)
            }),
            ("drag", &|of| format!("{:.3}", of.rolling_resistance)),
            ("play", &|of| format!("{:.3}", 1e3 * of.axial_play_m)),
            ("axle", &|of| format!("{:.2}", 1e3 * of.axle_drag_n_m)),
        ],
        surfaces,
    );
    table
}

/// The roller shapes of wheels whose outline is not a circle.
fn made(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "rollers as made: curvature along the roller over the ideal barrel's, its radius, least and largest radius of the rollers, \
         travel of the hub in a turn and its mean height; lengths in mm",
    );
    let made = robot.wheels.iter();
    let made = made.filter_map(|wheel| Some((wheel.name.as_str(), wheel.made?)));
    table.columns::<MadeInspection>(
        &[
            ("crown", &|of| or_dash(of.crown, 3)),
            ("its radius", &|of| {
                or_dash(of.crown_radius_m.map(|m| 1e3 * m), 2)
            }),
            ("least", &|of| format!("{:.3}", 1e3 * of.least_radius_m)),
            ("largest", &|of| format!("{:.3}", 1e3 * of.largest_radius_m)),
            ("travel", &|of| format!("{:.3}", 1e3 * of.hub_travel_m)),
            ("height", &|of| format!("{:.3}", 1e3 * of.mean_height_m)),
        ],
        made,
    );
    table
}

/// A number; a dash for `None`.
fn or_dash(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
}

/// The joints between moving bodies.
fn joints(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(
        "joints: role; where they stand and how far they go, in deg or mm, of which M, loads and limits are; the wheels that they move",
    );
    let shown = |joint: &JointInspection, value: Option<f64>| {
        let unit = match joint.moves {
            "turns" => 1_f64.to_degrees(),
            _ => 1e3,
        };
        or_dash(value.map(|value| unit * value), 2)
    };
    table.columns::<&JointInspection>(
        &[
            ("moves", &|joint| joint.moves.to_owned()),
            ("role", &|joint| joint.role.to_owned()),
            ("stands", &|joint| shown(joint, Some(joint.position))),
            ("from", &|joint| shown(joint, joint.limits[0])),
            ("to", &|joint| shown(joint, joint.limits[1])),
            ("wheels", &|joint| joint.moves_wheels.len().to_string()),
        ],
        robot
            .joints
            .iter()
            .map(|joint| (joint.name.as_str(), joint)),
    );
    table
}

/// The load of each wheel at rest.
fn loads(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading("loads at rest on level ground, in N");
    for wheel in &robot.wheels {
        table.words(&wheel.name, &[format!("{:.3}", wheel.load_n)]);
    }
    table
}

/// The wheels with their names.
fn by_name(robot: &Inspection) -> impl Iterator<Item = (&str, &WheelInspection)> {
    robot
        .wheels
        .iter()
        .map(|wheel| (wheel.name.as_str(), wheel))
}

fn text(robot: &Inspection) -> String {
    let any = |has: fn(&WheelInspection) -> bool| robot.wheels.iter().any(has);
    let mut tables = vec![wheels(robot)];
    if any(|wheel| wheel.tyre.is_none()) {
        tables.push(rollers(robot));
    }
    if any(|wheel| wheel.tyre.is_some()) {
        tables.push(tyres(robot));
    }
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
    tables.push(matrix(robot));
    tables.extend(robot.tyres.as_ref().map(held_rows));
    tables.push(kinematics(robot));
    let tables: Vec<String> = tables.iter().map(ToString::to_string).collect();
    let mut text = tables.join("\n");

    if let Some(excluded) = robot.tyres.as_ref().and_then(|of| of.excluded.as_ref()) {
        text.push_str(&format!("\nexcluded by tyres: {excluded}\n"));
    }
    if let Some(singularity) = &robot.singularity {
        let singularity = sentence(singularity);
        text.push_str(&format!("\ncannot be controlled: {singularity}\n"));
    }
    if !robot.remarks.is_empty() {
        text.push_str("\nremarks on the file\n");
        for remark in ilon_sim::gathered(&robot.remarks) {
            text.push_str(&format!("  {}\n", sentence(&remark)));
        }
    }
    text
}

/// The robot and the places of its wheels.
fn wheels(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(&robot.name);
    table.row("mass", Some(robot.mass_kg), 3, "kg");
    table.row("wheels", Some(robot.wheels.len() as f64), 0, "");
    table.heading("wheels: place in m, radius in mm, gamma in deg, limits of torque in N m and of rate in rad/s");
    let place = |wheel: &WheelInspection, axis: usize| format!("{:.3}", wheel.position_m[axis]);
    table.columns::<&WheelInspection>(
        &[
            ("x", &|wheel| place(wheel, 0)),
            ("y", &|wheel| place(wheel, 1)),
            ("z", &|wheel| place(wheel, 2)),
            ("radius", &|wheel| format!("{:.1}", 1e3 * wheel.radius_m)),
            ("gamma", &|wheel| match wheel.tyre {
                Some(_) => "tyre".to_owned(),
                None => format!("{:.1}", wheel.gamma_rad.to_degrees()),
            }),
            ("torque", &|wheel| or_dash(wheel.effort_n_m, 2)),
            ("rate", &|wheel| or_dash(wheel.velocity_rad_s, 2)),
        ],
        by_name(robot),
    );
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
            "rollers: largest radius and length in mm; no axle friction (plain bushings: `rollers.bearings = \"bushings\"`)"
        }
    });
    table.columns::<&WheelInspection>(
        &[
            ("count", &|wheel| wheel.rollers.to_string()),
            ("radius", &|wheel| {
                format!("{:.2}", 1e3 * wheel.roller_radius_m)
            }),
            ("length", &|wheel| {
                format!("{:.2}", 1e3 * wheel.roller_length_m)
            }),
        ],
        by_name(robot),
    );
    table
}

fn tyres(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading("tyres: width and radius of the shoulders in mm");
    let on_tyres = by_name(robot).filter_map(|(name, wheel)| Some((name, wheel.tyre?)));
    table.columns::<TyreInspection>(
        &[
            ("width", &|tyre| format!("{:.2}", 1e3 * tyre.width_m)),
            ("shoulders", &|tyre| {
                format!("{:.2}", 1e3 * tyre.shoulder_radius_m)
            }),
        ],
        on_tyres,
    );
    table
}

/// The rows that tyres add below M.
fn held_rows(tyres: &TyresInspection) -> Table {
    let mut table = Table::new();
    table.heading("rows that tyres add: no motion along their axles; unsteered tyres on parallel axles give one, in their middle");
    for held in &tyres.rows {
        // More wheels on one axle line are counted.
        let name = match &held.wheels[..] {
            [first, second, rest @ ..] if rest.len() > 2 => {
                format!("{first}, {second} and {} more", rest.len())
            }
            few => few.join(", "),
        };
        let name = match held.is_steered {
            true => format!("{name}, steered"),
            false => name,
        };
        // A negative zero has no meaning here.
        table.row_of(&name, &held.row.map(|value| Some(value + 0.0)), 4, "");
    }
    table
}

fn matrix(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading(match robot.tyres {
        Some(_) => "M: the wheels' speeds of a motion ahead, to the left and of a turn",
        None => "M, Indiveri 2009, equation (8)",
    });
    for (wheel, row) in robot.wheels.iter().zip(&robot.m) {
        table.row_of(&wheel.name, &row.map(Some), 4, "");
    }
    table
}

fn kinematics(robot: &Inspection) -> Table {
    let mut table = Table::new();
    table.heading("kinematics");
    let rank = match robot.tyres {
        Some(_) => "rank of all rows",
        None => "rank of M",
    };
    table.row(rank, Some(robot.rank as f64), 0, "of 3");
    table.row_of("singular values", &robot.singular_values.map(Some), 4, "");
    table.row("condition", robot.condition, 2, "");
    match &robot.tyres {
        Some(tyres) => what_tyres_leave(&mut table, tyres),
        None => {
            let coupled = match robot.decoupled {
                true => "decoupled",
                false => "coupled",
            };
            table.words("position and heading", &[coupled.to_owned()]);
        }
    }
    if let Some(point) = robot.decoupling_point_m {
        table.row_of("decoupled about", &point.map(Some), 4, "m");
    }
    if let Some(limits) = robot.speed_limits {
        let is_held = robot.tyres.as_ref().is_some_and(TyresInspection::is_held);
        let speeds = [
            ("top speed, slowest direction", limits.slowest_direction_m_s),
            ("top speed, fastest direction", limits.fastest_direction_m_s),
        ];
        match is_held || limits.is_even() {
            true => table.row("top speed", Some(limits.fastest_direction_m_s), 3, "m/s"),
            false => {
                for (name, speed_m_s) in speeds {
                    table.row(name, Some(speed_m_s), 3, "m/s");
                }
            }
        }
        let rate_deg_s = limits.yaw_rate_rad_s.to_degrees();
        table.row("top yaw rate", Some(rate_deg_s), 1, "deg/s");
    }
    table
}

/// The twists that tyres leave, and the sharpest turn.
fn what_tyres_leave(table: &mut Table, tyres: &TyresInspection) {
    let twists = tyres.reachable_twists as f64;
    table.row("twists that it can drive", Some(twists), 0, "of 3");
    match tyres.turning_radius_m {
        Some(0.0) => table.words("sharpest turn", &["on the spot".to_owned()]),
        Some(radius_m) => table.row("sharpest turn, radius", Some(radius_m), 3, "m"),
        None => {}
    }
    let apart_m = tyres.axles_apart_m();
    if apart_m > SAME_LINE_M {
        table.row("tyres scrub in turns: axles apart", Some(apart_m), 3, "m");
    }
}

/// Axles nearer than this lie on one line, in metres: the last digit that is printed.
const SAME_LINE_M: f64 = 5e-4;
