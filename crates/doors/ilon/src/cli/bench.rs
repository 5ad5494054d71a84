//! `ilon bench`: accuracy and speed of the simulation on this machine.

use std::path::Path;

use ilon_formats::LoadRobot;
use ilon_robot::Robot;

use super::console;
use super::escape::one_line;
use super::json::pretty;
use super::outcome::Outcome;
use super::robot::Sources;
use super::table::Table;
use crate::bench::{
    Bench, CONFIGURATION_COLUMNS, ContactMode, DRIVES, Options, ROBOTS, RobotBench,
};
use crate::cli::failure::Failure;

const WHAT_IS_MEASURED: &str = "\
Five open-loop drives on a level floor of friction 0.6: D1 forward 0.3 m/s, D2 lateral 0.3 m/s, D3 yaw 1 rad/s,
D4 diagonal 0.2 + 0.2 m/s, D5 arc 0.3 m/s with 0.5 rad/s; wheels driven by torques from their loops.

Error: after 1 s of rest and 0.5 s of ramp the twist is held for 4 s, of which the last 3 s count. The worst deviation of a
driven component's mean from the contact kinematics (the twist without slip at the rollers that touch), over drives and
headings, in per cent.

Speed: the whole loop (sensors, wheel loops, motors, world, recording with a row of the trace a second), simulated time
over the CPU time of its one thread, while the twist is held, after 1 s of warm-up. A stretch is a second of simulated time
or more, 20 ms of CPU time at least; of each drive the best counts. All configurations are timed in turn, round after round,
each for 0.3 s of CPU time a round or a stretch of each drive. \"spread\" is how much longer the middle one of the stretches
took, in the worst drive. Set-up and writing files are not timed.";

/// Arguments of `ilon bench`.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_MEASURED, after_help = "`--help` says what is measured, and how.")]
pub(super) struct Arguments {
    /// A robot: `mecanum4`, `volksbot`, or a file; repeatable [default: both].
    #[arg(long = "robot", value_name = "NAME|FILE")]
    robots: Vec<String>,
    #[command(flatten)]
    sources: Sources,
    /// Contact search: `all` rollers, those `near` the ground, or `rapier`'s own contacts [default:
    /// each].
    #[arg(long, value_name = "all|near|rapier", value_parser = kind)]
    rollers: Option<ContactMode>,
    /// Physics steps a second [default: 1000,500,240,120,60,30,20, near also 40,15,10, and rapier
    /// 1000,500,240].
    #[arg(long, value_name = "HZ,..", value_delimiter = ',', value_parser = |text: &str| within(text, 1.0, 100_000.0, "steps a second"))]
    rates: Vec<f64>,
    /// Bandwidth of the wheel loops on the ground [default: 60].
    #[arg(long, value_name = "RAD_S", value_parser = |text: &str| within(text, 0.1, 10_000.0, "rad/s"))]
    bandwidth: Option<f64>,
    /// Headings of the measurement, in degrees; speed is measured at the first [default: 0,20].
    #[arg(
        long,
        value_name = "DEG,..",
        value_delimiter = ',',
        allow_hyphen_values = true,
        value_parser = |text: &str| within(text, -360.0, 360.0, "degrees")
    )]
    headings: Vec<f64>,
    /// Rounds of timing; the best stretch counts [default: 5].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    rounds: Option<u16>,
    /// A first look in a tenth of the time: fewer rates, headings and rounds, unless other options
    /// are given.
    #[arg(long)]
    quick: bool,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let options = options(arguments)?;
    if cfg!(debug_assertions) {
        console::note("note: this is a build for debugging; its speeds tell nothing");
    }
    let bench = crate::bench::measure(&options, |what| console::note(&one_line(what)))?;
    if arguments.json {
        console::data(&pretty("the measurements", &bench)?)?;
    } else {
        console::lines(&text(&bench))?;
    }
    Ok(Outcome::Done)
}

fn options(arguments: &Arguments) -> Result<Options, Failure> {
    let mut options = if arguments.quick {
        Options::quick()?
    } else {
        Options::full()?
    };
    if !arguments.robots.is_empty() {
        options.robots = arguments
            .robots
            .iter()
            .map(|name| robot(name, &arguments.sources))
            .collect::<Result<_, Failure>>()?;
    }
    for (index, (name, _)) in options.robots.iter().enumerate() {
        if options.robots[..index]
            .iter()
            .any(|(other, _)| other == name)
        {
            return Err(Failure::usage(
                format!("two robots are called `{name}`"),
                "name each robot once; a file gives its robot its own name, without folder and ending",
            ));
        }
    }
    if let Some(kind) = arguments.rollers {
        options.configurations.retain(|(of, _)| *of == kind);
        // An option can add what the short measurement leaves out.
        if options.configurations.is_empty() {
            options.configurations.push((kind, 240.0));
        }
    }
    if !arguments.rates.is_empty() {
        let mut kinds: Vec<_> = options.configurations.iter().map(|(of, _)| *of).collect();
        kinds.dedup();
        let rates = &arguments.rates;
        options.configurations = kinds
            .into_iter()
            .flat_map(|kind| rates.iter().map(move |rate_hz| (kind, *rate_hz)))
            .collect();
    }
    options.bandwidth_rad_s = arguments.bandwidth.or(options.bandwidth_rad_s);
    if !arguments.headings.is_empty() {
        options.headings_deg.clone_from(&arguments.headings);
    }
    if let Some(rounds) = arguments.rounds {
        options.rounds = rounds.into();
    }
    Ok(options)
}

/// Returns a built-in robot, or loads one from a file.
fn robot(name: &str, sources: &Sources) -> Result<(String, Robot), Failure> {
    if ROBOTS.iter().any(|(known, _)| *known == name) {
        return Ok((name.to_owned(), Options::built_in(name)?));
    }
    let path = Path::new(name);
    if path.extension().is_none() && !path.exists() {
        return Err(Failure::usage(
            format!("there is no built-in robot `{name}`, and no file of that name"),
            "choose `--robot mecanum4` or `--robot volksbot`, or name a URDF",
        ));
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    // `base.urdf.xacro` is named `base`.
    let stem = stem.split('.').next().unwrap_or_default().to_owned();
    Ok((stem, Robot::load_with(path, &sources.options())?.robot))
}

fn kind(text: &str) -> Result<ContactMode, String> {
    let known = ContactMode::ALL
        .into_iter()
        .find(|kind| kind.word() == text);
    known.ok_or_else(|| {
        "name `all` rollers, those `near` the ground, or `rapier`, which solves the contacts of all itself"
            .to_owned()
    })
}

fn within(text: &str, least: f64, most: f64, unit: &str) -> Result<f64, String> {
    let number: Option<f64> = text.trim().parse().ok();
    number
        .filter(|number| (least..=most).contains(number))
        .ok_or_else(|| format!("give a number of {unit} from {least} to {most}"))
}

/// The tables as text for a terminal.
fn text(bench: &Bench) -> String {
    let headings: Vec<String> = bench.headings_deg.iter().map(f64::to_string).collect();
    let mut text = String::new();
    for (name, robot) in &bench.robots {
        text.push_str(&robot_table(name, robot, &headings.join(", ")).to_string());
        text.push_str(&format!("  headline: {}\n", one_line(&robot.headline)));
        for remark in &robot.remarks {
            text.push_str(&format!("  {}\n", one_line(remark)));
        }
        text.push('\n');
    }
    text
}

fn robot_table(name: &str, robot: &RobotBench, headings: &str) -> Table {
    let mut table = Table::new();
    table.heading(&format!(
        "{name}: error against the contact kinematics in %, at headings of {headings} degrees; ripple in mm, slip in mm/s"
    ));
    let mut columns = vec!["steps/s".to_owned(), "worst".to_owned()];
    columns.extend(DRIVES.map(|(drive, _)| drive.to_owned()));
    let [others @ .., spread] = CONFIGURATION_COLUMNS;
    columns.extend(others.map(str::to_owned));
    columns.push(format!("{spread} %"));
    table.words("rollers", &columns);
    for c in &robot.configurations {
        let mut cells = vec![c.rate_hz().to_string()];
        cells.extend(dashes(&c.figures()));
        table.words(&c.roller_bodies, &cells);
    }
    table
}

/// Numbers with their decimals as text; a dash for a missing number.
fn dashes(figures: &[(Option<f64>, usize)]) -> Vec<String> {
    let shown = |(value, decimals): &(Option<f64>, usize)| {
        value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    figures.iter().map(shown).collect()
}
