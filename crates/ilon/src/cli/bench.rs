//! `ilon bench`: how right and how fast the simulation is on this machine.

use super::Outcome;
use crate::Error;
use crate::bench::Bench;

/// Arguments of `ilon bench`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let bench = Bench::measure(|what| eprintln!("{what}"))?;
    if arguments.json {
        let json = serde_json::to_string_pretty(&bench)
            .map_err(|error| Error::invalid(error.to_string(), ""))?;
        super::print(&(json + "\n"))?;
    } else {
        super::print(&text(&bench))?;
    }
    Ok(Outcome::Done)
}

fn text(bench: &Bench) -> String {
    use std::fmt::Write;
    let mut text = String::new();
    let dash = |value: Option<f64>, decimals: usize| {
        value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    // Writing to a string does not fail.
    for (name, robot) in &bench.robots {
        let _ = writeln!(
            text,
            "{name}, drives D1-D5 against contact kinematics\n\
             {:>8} {:>9} {:>12} {:>11} {:>11} {:>12} {:>12}",
            "rollers",
            "steps/s",
            "worst error",
            "hub ripple",
            "slip rms",
            "sim s/CPU s",
            "steps/CPU s"
        );
        for c in &robot.configurations {
            let _ = writeln!(
                text,
                "{:>8} {:>9.0} {:>10.4} % {:>8} mm {:>6} mm/s {:>12} {:>12}",
                c.roller_bodies,
                1.0 / c.physics_dt_s,
                c.worst_error_pct,
                dash(c.hub_ripple_m.map(|m| 1e3 * m), 4),
                dash(c.slip_speed_rms_m_s.map(|v| 1e3 * v), 2),
                dash(c.sim_s_per_cpu_s, 1),
                dash(c.steps_per_cpu_s, 0),
            );
        }
        let _ = writeln!(text, "headline: {}\n", robot.headline);
    }
    let _ = writeln!(
        text,
        "robots in one process, near rollers, 240 steps a second"
    );
    let _ = writeln!(
        text,
        "{:>8} {:>9} {:>16}",
        "robots", "threads", "sim s/wall s"
    );
    for t in &bench.throughput {
        let _ = writeln!(
            text,
            "{:>8} {:>9} {:>16.1}",
            t.robots, t.threads, t.sim_s_per_wall_s
        );
    }
    text
}
