//! One scenario: simulated, written and printed.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ilon_files::FileAccess;
use ilon_trace::quantities::{self, GROUPS};
use ilon_trace::{Quantity, Recorded, Recording, Sink, Summary, to_microseconds};

use crate::Scenario;
use crate::cli::bag::Bag;
use crate::cli::converge::{self, Converge};
use crate::cli::escape::{path_in_line, sentences};
use crate::cli::failure::Failure;
use crate::cli::options::{Detail, Sandbox, Settings, Twins};
use crate::cli::output::{self, OutputFolder, Report};
use crate::cli::progress::Bar;
use crate::cli::table::Table;
use crate::cli::{console, interrupt, open};
use crate::judge::judge_rows;
use crate::simulate::{Run, Simulation};
use ilon_sim::gathered;

/// Least simulated time in a part of a growing trace, in seconds; chosen.
const PART_S: f64 = 1.0;

/// Least wall-clock time between parts; chosen. Writing a part takes a few milliseconds, which
/// would slow down runs far faster than real time.
const BETWEEN_PARTS: Duration = Duration::from_millis(200);

/// Arguments of `ilon run`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Scenario files, run one after the other; or a robot's file, driven in five standard motions.
    #[arg(required = true, value_name = "SCENARIO")]
    pub scenarios: Vec<PathBuf>,
    /// Folder of the results; of several scenarios the folder above them.
    #[arg(long, value_name = "DIR", default_value = "out/<scenario>")]
    pub out: PathBuf,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub sandbox: Sandbox,
    /// Print the summary as JSON, and nothing else, on standard output; of several scenarios a
    /// list.
    #[arg(long)]
    pub json: bool,
    /// Write a bag too, `bag/`: the run as ROS 2 topics in MCAP, for `ros2 bag play`, Foxglove,
    /// Rerun and PlotJuggler. Rollers turn if `run.roller_angles_hz` is set.
    #[arg(long)]
    pub mcap: bool,
    /// Write no report.html.
    #[arg(long)]
    pub no_report: bool,
    /// Open the report in the browser.
    #[arg(long, conflicts_with = "no_report")]
    pub open: bool,
    #[command(flatten)]
    pub converge: Converge,
    #[command(flatten)]
    pub twins: Twins,
    #[command(flatten)]
    pub detail: Detail,
}

/// Loads a scenario with the changes from the options.
pub fn load(path: &Path, arguments: &Arguments, files: &FileAccess) -> Result<Scenario, Failure> {
    let mut scenario = Scenario::load_within(path, &arguments.settings.settings, files)?;
    scenario.run.converge |= arguments.converge.converge;
    Ok(scenario)
}

/// Prints the summaries to standard output if requested; for several scenarios as a list.
pub fn print_json(arguments: &Arguments, summaries: &[String]) -> Result<(), Failure> {
    if arguments.json {
        let printed = match summaries {
            [summary] => summary.clone(),
            several => format!("[\n{}]\n", several.join(",\n")),
        };
        console::data(&printed)?;
    }
    Ok(())
}

/// What is printed about a run.
#[derive(Debug)]
pub enum Told<'a> {
    /// Its answer, its figures and the location of its files.
    InFull,
    /// Only its own notes, under its name: the caller prints all runs together, and the notes that
    /// all of them have.
    Together(&'a [String]),
}

impl Told<'_> {
    /// The printed words of a note; `None` if the caller prints it.
    fn words(&self, scenario: &str, note: &str) -> Option<String> {
        match self {
            Self::InFull => Some(format!("note: {note}")),
            Self::Together(shared) if shared.iter().any(|known| known == note) => None,
            Self::Together(_) => Some(format!("note: `{scenario}`: {note}")),
        }
    }
}

/// Runs a simulation, whose recording begins in a folder and grows there in parts; the rows also go
/// to other sinks.
pub fn recorded(
    simulation: Simulation,
    recording: Recording,
    folder: &OutputFolder,
    bar: &Bar,
    sinks: &mut [&mut dyn Sink],
) -> Result<Run<Recorded>, Failure> {
    interrupt::leaves_trace(folder.growing());
    let (mut kept_s, mut kept) = (0.0, Instant::now());
    let run = simulation.run_recorded_beside(recording, sinks, |simulation, recording| {
        let progress = simulation.progress();
        bar.simulated(progress);
        if progress.time_s >= kept_s + PART_S && kept.elapsed() >= BETWEEN_PARTS {
            recording.keep()?;
            (kept_s, kept) = (progress.time_s, Instant::now());
        }
        Ok::<_, Failure>(())
    })?;
    bar.done();
    Ok(run)
}

/// Simulates one scenario, writes and prints; returns its summary as JSON and as a value.
pub fn one(
    path: &Path,
    scenario: &Scenario,
    out: PathBuf,
    arguments: &Arguments,
    told: Told,
) -> Result<(String, Summary), Failure> {
    let inputs = output::inputs(path, scenario);
    let folder = OutputFolder::prepare(out, "--out", &inputs)?;
    let bag = Bag::prepare(&folder, arguments.mcap, &inputs)?;

    // An unreadable robot is reported before the run is announced.
    let simulation = Simulation::new(scenario)?.explaining(arguments.twins.causes());
    let bar = Bar::new(&scenario.name);
    let foreseen = simulation.warnings().len();
    for warning in gathered(simulation.warnings()) {
        if let Some(words) = told.words(&scenario.name, &warning) {
            bar.note(&words);
        }
    }
    if let Err(fault) = scenario.expect.check_windows(&simulation.scenario().run) {
        bar.note(&format!("note: {fault}"));
    }
    let recording = folder.begin(&simulation)?;
    let mut bag = bag.begin(&simulation)?;
    let mut sinks: Vec<&mut dyn Sink> = bag.iter_mut().map(|bag| bag as _).collect();
    let run = recorded(simulation, recording, &folder, &bar, &mut sinks)?;

    let verdicts = judge_rows(&run)?;
    let report = if arguments.no_report {
        Report::Left
    } else {
        Report::Written
    };
    let answer = folder.write(&run, &verdicts, report)?;
    for warning in &run.warnings[foreseen..] {
        if let Some(words) = told.words(&scenario.name, warning) {
            bar.note(&words);
        }
    }
    for verdict in verdicts.iter().filter(|verdict| !verdict.held) {
        if let Some(words) = told.words(&scenario.name, &format!("expected {verdict}")) {
            bar.note(&words);
        }
    }
    if !arguments.json && matches!(told, Told::InFull) {
        let page = if arguments.no_report {
            ""
        } else {
            "report.html, "
        };
        console::lines(&format!(
            "{}\n{}{}\nwritten to {}: {page}summary.json, trace.parquet, scenario.toml{}\n",
            sentences(&answer),
            if arguments.detail.table {
                whole_table(&run.summary)
            } else {
                headlines(&run.summary)
            },
            match scenario.run.converge {
                true => converge::table(&run.summary.converge)
                    .map_or_else(String::new, |table| format!("\n{table}")),
                false => String::new(),
            },
            path_in_line(folder.path()),
            if arguments.mcap { ", bag/" } else { "" },
        ))?;
    }
    if arguments.open {
        open::page(&folder.path().join("report.html"));
    }
    Ok((folder.summary_json(&run)?, run.summary))
}

pub fn out_folder(out: &Path, scenario: &str, is_alone: bool) -> PathBuf {
    match out.to_str() {
        Some("out/<scenario>") => PathBuf::from("out").join(scenario),
        _ if is_alone => out.to_owned(),
        _ => out.join(scenario),
    }
}

/// The main figures to look at first.
fn headlines(summary: &Summary) -> Table {
    let mut table = Table::new();
    let run = format!(
        "{} with {}, {} s",
        summary.scenario,
        summary.robot,
        to_microseconds(summary.duration_s)
    );
    let speed = summary.sim_seconds_per_cpu_second;
    let speed = speed.map(|times| format!(" at {times:.0} times real time on one core"));
    table.heading(&(run + &speed.unwrap_or_default()));
    for quantity in quantities::headlines(summary) {
        let values = [quantity.shown(summary)];
        let symbol = quantity.unit.symbol;
        table.row_of(&quantity.words(), &values, quantity.decimals, symbol);
    }
    table
}

/// All main figures that apply.
fn whole_table(summary: &Summary) -> Table {
    let mut table = Table::new();
    table.heading(&format!("{} with {}", summary.scenario, summary.robot));
    for key in ["duration_s", "sim_seconds_per_cpu_second"] {
        table.quantities(quantities::by_key(key), summary);
    }
    // A robot that tracks a path moves back and forth, so its mean twist says nothing.
    if summary.position_error_final_m.is_none() {
        twists(&mut table, summary);
    }
    for group in GROUPS.iter().filter(|group| !group.open_loop_only) {
        let applies = |q: &&Quantity| q.is_main && q.value(summary).is_some();
        let mut main = group.quantities.iter().filter(applies).peekable();
        if main.peek().is_some() {
            table.heading(group.heading);
            table.quantities(main, summary);
        }
    }
    table
}

/// The mean twist beside those predicted by the models, and the share that was reached.
fn twists(table: &mut Table, summary: &Summary) {
    let row = |table: &mut Table, of: &[&str], component: &str, name: &str| {
        let figures = of
            .iter()
            .map(|of| quantities::by_key(&format!("{of}.{component}")));
        let values: Vec<_> = figures.map(|figure| figure?.value(summary)).collect();
        table.row_of(name, &values, 5, quantities::si_unit(component));
    };
    let means = ["twist_mean", "twist_ideal_mean", "twist_contact_mean"];
    table.heading("twist: real, by the ideal kinematics, by the contact kinematics");
    row(table, &means, "vx_m_s", "vx");
    row(table, &means, "vy_m_s", "vy");
    row(table, &means, "omega_rad_s", "omega");
    let ratios = ["twist_ratio_ideal", "twist_ratio_contact"];
    table.heading("real over ideal (geometry and slip), real over contact kinematics (slip alone)");
    for component in ["vx", "vy", "omega"] {
        row(table, &ratios, component, component);
    }
}
