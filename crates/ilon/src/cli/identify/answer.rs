//! What an identification found, as a person reads it on a terminal.

use std::fmt::Write;

use ilon_identify::Identified;
use ilon_identify::outcome::{JudgedBy, Misses, Simulation, Value};
use ilon_identify::plan::Plan;
use ilon_report::sweep::figure as number;

use crate::cli::table::Table;

/// What was found, in words and tables.
pub(super) fn words(found: &Identified) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}: the model \"{}\" has the least error on what was not fitted, {}",
        found.study,
        found.model,
        match found.judged_by {
            JudgedBy::Runs => "the runs that were kept back",
            JudgedBy::EachRun => "each run in turn",
            JudgedBy::EachStretch => "each eighth of the runs in turn",
        }
    );
    let _ = write!(text, "{}", tables(found));
    if !found.held.is_empty() {
        let _ = writeln!(text, "\nnot determined by this log:");
        for held in &found.held {
            let _ = writeln!(
                text,
                "  {} is held at {}: {}",
                held.name,
                number(held.value),
                held.why
            );
        }
    }
    if let Some(simulation) = &found.simulation {
        for [a, b] in &simulation.alike {
            let _ = writeln!(
                text,
                "\n{a} and {b} are hardly told apart by this log: what one changes the other makes up for, and their intervals allow for it"
            );
        }
        for key in &simulation.insensitive {
            let _ = writeln!(
                text,
                "\n{key} changes less than the noise over all of its range"
            );
        }
        for key in &simulation.open {
            let _ = writeln!(
                text,
                "\nthis log leaves {key} open: its interval holds all of its range, as other keys may make up for it"
            );
        }
        for key in &simulation.cut_off {
            let _ = writeln!(
                text,
                "\nthe interval of {key} reaches an end of its range: what lies beyond was not tried"
            );
        }
        for key in &simulation.of_one_run {
            let _ = writeln!(
                text,
                "\nhow sure {key} is cannot be said: one run alone tells it. Drive what it drives once more"
            );
        }
        for key in &simulation.at_bounds {
            let _ = writeln!(
                text,
                "\n{key} lies at an end of its range: beyond it the fit may be better"
            );
        }
        for other in &simulation.elsewhere {
            let _ = writeln!(
                text,
                "\n{} near {} is not refused by this log either, but much of what lies between is: its interval holds both. Other directions, or what \
                 happens once a roller (`[simulate.ripple]`), may tell them apart",
                other.key,
                number(other.value)
            );
        }
        if simulation.phases_matter == Some(true) {
            let _ = writeln!(
                text,
                "\nWhat is found depends on the angles of their rollers at which wheels began, which the log does not say: each drive was simulated from {} \
                 sets of angles, and the intervals hold what these scatter by. Absolute encoders would say it: `simulate.phases`",
                simulation.phases
            );
        }
        if !simulation.has_converged {
            let _ = writeln!(
                text,
                "\nThe search was cut off after its steps: `simulate.steps` allows more"
            );
        }
    }
    if found.intervals_over == "stretches" {
        let _ = writeln!(
            text,
            "\nThe intervals are over stretches of the runs: what differs from run to run is not in them. Six runs or more would show it."
        );
    }
    text
}

fn tables(found: &Identified) -> Table {
    let mut table = Table::new();
    table.heading("parameter: value, from, to (95 %), before");
    for (name, value) in found.parameters.iter().chain(&found.derived) {
        table.words(name, &value_words(value));
    }
    table.heading("model: error on what was fitted and on what was not (mm and mrad a stretch, and over the noise), end of a run (m)");
    for model in &found.models {
        let (fit, held_out) = (&model.fit, &model.held_out);
        let words = [
            number(1e3 * fit.position_rms_m),
            number(1e3 * held_out.position_rms_m),
            number(1e3 * held_out.heading_rms_rad),
            number(held_out.over_noise),
            number(held_out.end_position_rms_m),
        ];
        table.words(&model.name, &words);
    }
    table.heading("direction in degrees, m/s: measured over asked, +-, contact, fitted, simulated");
    let known = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
    for direction in &found.residual {
        let name = format!(
            "{:.0}, {}",
            direction.direction_deg,
            number(direction.speed_m_s)
        );
        let words = [
            format!("{:.4}", direction.measured),
            format!("{:.4}", direction.measured_error),
            known(direction.contact),
            format!("{:.4}", direction.fitted),
            known(direction.simulated),
        ];
        table.words(&name, &words);
    }
    if let Some(simulation) = &found.simulation {
        table.heading(
            "simulated, rms of measured less simulated: way over asked, drift in mrad/m, torque in mN m",
        );
        let words = |misses: &Misses| {
            let milli = |value: Option<f64>| value.map_or("-".to_owned(), |v| number(1e3 * v));
            let ratio = misses.ratio.map_or("-".to_owned(), |v| format!("{v:.4}"));
            [
                ratio,
                milli(misses.drift_rad_per_m),
                milli(misses.torque_n_m),
            ]
        };
        table.words("of drives that were fitted", &words(&simulation.fit));
        table.words("of drives that were not", &words(&simulation.held_out));
        for beside in &simulation.beside {
            let name = |which: &str| format!("{}, {which}", beside.name);
            table.words(&name("fitted"), &words(&beside.fit));
            table.words(&name("not fitted"), &words(&beside.held_out));
        }
    }
    if let Some(simulation) = &found.simulation {
        simulated(&mut table, simulation);
    }
    if found.series.len() > 1 {
        table.heading("series by itself: value, from, to (95 %)");
        for series in &found.series {
            for (name, value) in &series.gains {
                table.words(&format!("{} {name}", series.name), &value_words(value)[..3]);
            }
        }
    }
    table
}

/// What the simulation with the fitted keys comes to beside the logs.
fn simulated(table: &mut Table, simulation: &Simulation) {
    if !simulation.series.is_empty() {
        table.heading("series: sideways over ahead, from, to (95 %), simulated");
        for series in &simulation.series {
            let [value, from, to, _] = value_words(&series.sideways_over_ahead);
            let words = [value, from, to, format!("{:.4}", series.simulated)];
            table.words(&series.name, &words);
        }
    }
    if simulation.drives.iter().any(|drive| drive.ripple.is_some()) {
        table.heading("once a roller: wheels in mrad/s, +-, simulated; body in mm, +-, simulated");
        for drive in &simulation.drives {
            let Some(ripple) = &drive.ripple else {
                continue;
            };
            let words = [
                ripple.wheels_rad_s,
                ripple.wheels_error_rad_s,
                ripple.wheels_simulated_rad_s,
                ripple.body_m,
                ripple.body_error_m,
                ripple.body_simulated_m,
            ]
            .map(|value| number(1e3 * value));
            let name = std::path::Path::new(&drive.file);
            let name = name.file_stem().unwrap_or_default().to_string_lossy();
            table.words(&format!("{name}, {:.0}", drive.direction_deg), &words);
        }
    }
}

fn value_words(value: &Value) -> [String; 4] {
    let end = |end: Option<f64>| end.map_or("?".to_owned(), number);
    let with_unit = match value.unit.as_str() {
        "" => number(value.value),
        unit => format!("{} {unit}", ilon_report::short(value.value, 5)),
    };
    [
        with_unit,
        end(value.ci95[0]),
        end(value.ci95[1]),
        number(value.nominal),
    ]
}

/// A course, and what it determines.
pub(super) fn course(plan: &Plan) -> String {
    let mut table = Table::new();
    table.heading("drive: m/s ahead, m/s to the left, rad/s, seconds");
    for (index, way) in plan.ways.iter().enumerate() {
        let [vx, vy, omega] = way.twist;
        let words = [vx, vy, omega, way.for_s].map(number);
        table.words(&format!("{}", index + 1), &words);
    }
    table.heading(
        "standard error that it leaves, of displacements seen to 1 mm and 1 mrad a second",
    );
    for (name, error) in &plan.errors {
        table.words(name, &[number(*error)]);
    }
    table.to_string()
}
