//! `ilon run`: simulate one scenario and write its results.

use std::path::PathBuf;

use ilon_trace::{Sink, Summary};

use super::bag::Bag;
use super::escape::one_line;
use super::output::{self, KeepingUp, OutputFolder};
use super::progress::Bar;
use super::say;
use super::table::Table;
use super::{Outcome, Sandbox, Settings};
use crate::Scenario;
use crate::cli::failure::Failure;
use crate::judge::judge_rows;
use crate::simulate;

/// Arguments of `ilon run`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario file.
    scenario: PathBuf,
    /// Where to write results.
    #[arg(long, value_name = "DIR", default_value = "out/<scenario>")]
    out: PathBuf,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    sandbox: Sandbox,
    /// Print the summary as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
    /// Write a bag beside the other results, `bag/`: the run as ROS 2 topics in MCAP, for `ros2 bag play`, Foxglove, Rerun and
    /// PlotJuggler. Rollers turn in it where the scenario sets `run.roller_angles_hz`.
    #[arg(long)]
    mcap: bool,
}

/// Simulates, writes, prints.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let path = &arguments.scenario;
    let files = arguments.sandbox.files()?;
    let scenario = Scenario::load_within(path, &arguments.settings.settings, &files)?;
    let out = out_folder(&arguments.out, &scenario.name);
    let inputs = output::inputs(path, &scenario);
    let folder = OutputFolder::prepare(out, "--out", &inputs)?;
    let bag = Bag::prepare(&folder, arguments.mcap, &inputs)?;

    let bar = Bar::new(&scenario.name, scenario.run.duration_s);
    let simulation = simulate::Simulation::new(&scenario)?;
    let foreseen = simulation.warnings().len();
    for warning in simulation.warnings() {
        bar.note(&format!("note: {warning}"));
    }
    if let Err(fault) = scenario.expect.check_windows(&scenario.run) {
        bar.note(&format!("note: {fault}"));
    }
    let recording = folder.begin(&simulation)?;
    let mut kept = KeepingUp::new();
    let mut bag = bag.begin(&simulation)?;
    let mut sinks: Vec<&mut dyn Sink> = bag.iter_mut().map(|bag| bag as _).collect();
    let run = simulation.run_recorded_beside(recording, &mut sinks, |simulation, recording| {
        bar.show(simulation.progress());
        kept.keep_up(simulation.progress().time_s, recording)
    })?;
    bar.done();

    folder.write(&run)?;
    for warning in &run.warnings[foreseen..] {
        say::note(&one_line(&format!("note: {warning}")));
    }
    for verdict in judge_rows(&run)?.iter().filter(|verdict| !verdict.held) {
        say::note(&one_line(&format!("note: expected {verdict}")));
    }
    if arguments.json {
        say::data(&folder.summary_json(&run)?)?;
    } else {
        say::lines(&format!(
            "{}\nwritten to {}: report.html, summary.json, trace.parquet, scenario.toml{}\n",
            summary_table(&run.summary),
            one_line(&folder.path().display().to_string()),
            if arguments.mcap { ", bag/" } else { "" },
        ))?;
    }
    Ok(Outcome::Done)
}

fn out_folder(out: &std::path::Path, scenario: &str) -> PathBuf {
    match out.to_str() {
        Some("out/<scenario>") => PathBuf::from("out").join(scenario),
        _ => out.to_owned(),
    }
}

/// The summary as a person reads it: millimetres and degrees.
fn summary_table(s: &Summary) -> String {
    let mut table = Table::new();
    table.heading(&format!("{} with {}", s.scenario, s.robot));
    table.row("simulated", Some(s.duration_s), 2, "s");
    table.row(
        "speed",
        s.sim_seconds_per_cpu_second,
        1,
        "times real time, one core",
    );

    if s.position_error_final_m.is_some() {
        table.heading("tracking");
        table.row("position error, rms", mm(s.position_error_rms_m), 2, "mm");
        table.row(
            "position error, at the end",
            mm(s.position_error_final_m),
            3,
            "mm",
        );
        table.row("position under 5 cm from", s.position_converged_s, 2, "s");
        table.row("heading error, rms", deg(s.heading_error_rms_rad), 3, "deg");
        table.row(
            "heading error, at the end",
            deg(s.heading_error_final_rad),
            4,
            "deg",
        );
        table.row("heading under 3 deg from", s.heading_converged_s, 2, "s");
        // Of sensors that see the truth there is nothing to say.
        if s.seen_position_error_rms_m > Some(0.0) {
            table.row(
                "pose seen is off by, rms",
                mm(s.seen_position_error_rms_m),
                2,
                "mm",
            );
            table.row(
                "heading seen is off by, rms",
                deg(s.seen_heading_error_rms_rad),
                3,
                "deg",
            );
        }
    } else {
        table.heading("twist: real, ideal by equation (7), by the touching rollers");
        let means = [s.twist_mean, s.twist_ideal_mean, s.twist_contact_mean];
        let component = |of: fn(&ilon_robot::Twist) -> f64| means.map(|mean| mean.as_ref().map(of));
        table.row_of("vx", &component(|t| t.vx_m_s), 5, "m/s");
        table.row_of("vy", &component(|t| t.vy_m_s), 5, "m/s");
        table.row_of("omega", &component(|t| t.omega_rad_s), 5, "rad/s");
        table.heading("real over ideal, real over touching rollers");
        let (ideal, contact) = (&s.twist_ratio_ideal, &s.twist_ratio_contact);
        table.row_of("vx", &[ideal.vx, contact.vx], 5, "");
        table.row_of("vy", &[ideal.vy, contact.vy], 5, "");
        table.row_of("omega", &[ideal.omega, contact.omega], 5, "");
    }

    table.heading("wheels");
    table.row(
        "largest rate commanded",
        s.wheel_rate_command_max_rad_s,
        3,
        "rad/s",
    );
    table.row("rate error, rms", s.wheel_rate_error_rms_rad_s, 3, "rad/s");
    table.row("largest torque", s.wheel_torque_max_n_m, 3, "N m");
    table.row("hub ripple", mm(s.hub_ripple_m), 4, "mm");

    table.heading("slip");
    table.row("sliding speed, rms", mm(s.slip_speed_rms_m_s), 2, "mm/s");
    table.row(
        "sliding speed, largest",
        mm(s.slip_speed_max_m_s),
        2,
        "mm/s",
    );
    table.row("energy lost", s.slip_energy_j, 4, "J");
    table.row(
        "odometry drift",
        mm(s.odometry_drift_m_per_m),
        2,
        "mm per m",
    );
    let turned = s.odometry_drift_rad_per_m.map(f64::to_degrees);
    table.row("odometry drift", turned, 3, "deg per m");
    table.to_string()
}

fn mm(metres: Option<f64>) -> Option<f64> {
    metres.map(|metres| 1e3 * metres)
}

fn deg(radians: Option<f64>) -> Option<f64> {
    radians.map(f64::to_degrees)
}
