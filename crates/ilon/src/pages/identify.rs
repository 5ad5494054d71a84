//! The page of an identification: what was found, and the robot as measured beside the robot as ideal, as its rollers' geometry has it,
//! and as fitted.

mod simulation;

use std::path::Path;

use ilon_identify::Identified;
use ilon_identify::outcome::{Direction, JudgedBy, Run, Value};
use ilon_report::figure::{
    Axis, Curve, Figure, Layout, Span, axis, bars, dashed, dots, dotted, exact_curve, plot, solid,
};
use ilon_report::page::{self, Head, Section, card, escape};
use ilon_report::sweep::figure as number;
use ilon_trace::TraceError;
use ilon_trace::file::write_text;

/// Writes the page to a file, whole or not at all.
///
/// # Errors
/// [`TraceError::Io`] where the file cannot be written.
pub fn write(path: &Path, found: &Identified) -> Result<(), TraceError> {
    write_text(path, &html(found))
}

/// The page as one HTML file that needs nothing else.
pub fn html(found: &Identified) -> String {
    let head = Head {
        kind: "identification",
        title: found.study.clone(),
        facts: facts(found),
        lead: story(found),
    };
    let mut sections = vec![Section {
        id: "parameters",
        title: "What was found",
        lead: "Each value with the interval in which it lies with 95 %.".to_owned(),
        body: parameters(found),
    }];
    if !found.residual.is_empty() {
        sections.push(Section {
            id: "directions",
            title: "By direction of motion",
            lead: "The way made over the way that the wheels ask for, by the kinematics of the robot as it was known.".to_owned(),
            body: format!(
                "<div class=\"grid\">\n{}{}{}</div>\n{}",
                card(&along(&found.residual)),
                card(&across(&found.residual)),
                card(&left(&found.residual)),
                directions(&found.residual)
            ),
        });
    }
    sections.extend(found.simulation.as_ref().map(simulation::section));
    sections.push(Section {
        id: "models",
        title: "Models",
        lead: "The model with the least error on what was not fitted is chosen; a fit alone always prefers the one with the most \
               parameters."
            .to_owned(),
        body: models(found),
    });
    sections.push(Section {
        id: "runs",
        title: "Runs",
        lead: "Where dead reckoning ends, from the pose at the beginning of the run on.".to_owned(),
        body: runs(found),
    });
    let footer = "<p>All figures are in <code>identified.json</code>.</p>";
    page::page(&head, &sections, footer, &page::Parts::default())
}

fn facts(found: &Identified) -> Vec<String> {
    vec![
        format!("model <b>{}</b>", escape(&found.model)),
        format!("<b>{}</b> runs", found.runs.len()),
        format!("<b>{}</b> stretches fitted", found.fit.stretches),
        format!(
            "tracker's noise <b>{}</b> mm, <b>{}</b> mrad a stretch",
            number(1e3 * found.noise.position_m),
            number(1e3 * found.noise.heading_rad)
        ),
        format!("ilon <b>{}</b>", escape(&found.ilon)),
    ]
}

fn story(found: &Identified) -> String {
    let mut lines: Vec<String> = Vec::new();
    let (before, after) = (&found.nominal, &found.held_out);
    let judged = match found.judged_by {
        JudgedBy::Runs => "on the runs that were kept back",
        JudgedBy::EachRun => "on each run in turn, fitted to the others",
        JudgedBy::EachStretch => "on each eighth of the runs in turn, fitted to the rest",
    };
    let is_better = after.over_noise < before.over_noise;
    lines.push(format!(
        "{} The model \"{}\" misses {} mm a stretch {judged}; the robot as it was known misses {} mm.",
        if is_better { "<b>✓</b>" } else { "" },
        escape(&found.model),
        number(1e3 * after.position_rms_m),
        number(1e3 * before.position_rms_m),
    ));
    lines.push(format!(
        "Dead reckoning ends {} mm from the robot in place of {} mm.",
        number(1e3 * after.end_position_rms_m),
        number(1e3 * before.end_position_rms_m)
    ));
    if after.over_noise > 2.0 {
        lines.push(format!(
            "<b class=\"failed\">✗</b> What is left is {} times what the tracker's noise explains: the model is not the whole truth. See by \
             direction of motion.",
            number(after.over_noise)
        ));
    }
    for held in &found.held {
        lines.push(format!(
            "<b class=\"failed\">✗</b> {} was held at {}: {}.",
            escape(&held.name),
            number(held.value),
            escape(&held.why)
        ));
    }
    if found.intervals_over == "stretches" {
        lines.push(
            "The intervals are over stretches of the runs: what differs from run to run is not in them. Six runs or more would show it."
                .to_owned(),
        );
    }
    for odd in found.doubts.iter().take(6) {
        lines.push(format!(
            "<b class=\"failed\">✗</b> {}: {} ({}).",
            escape(&odd.file),
            escape(&odd.doubt.message),
            escape(&odd.doubt.help)
        ));
    }
    let lines: String = lines.iter().map(|line| format!("<p>{line}</p>")).collect();
    format!("<div class=\"story\">{lines}</div>\n")
}

/// A column of a table: its heading, and what stands under it for one row.
type Column<'c, T> = (&'c str, &'c dyn Fn(&T) -> String);

/// A table with a row for each of some things.
fn table_of<'t, T: 't>(
    caption: &str,
    columns: &[Column<'_, T>],
    things: impl IntoIterator<Item = &'t T>,
) -> String {
    let head: Vec<&str> = columns.iter().map(|(heading, _)| *heading).collect();
    let row = |thing: &T| columns.iter().map(|(_, cell)| cell(thing)).collect();
    let rows: Vec<Vec<String>> = things.into_iter().map(row).collect();
    table(caption, &head, &rows)
}

/// A number to four places.
fn fine(value: f64) -> String {
    format!("{value:.4}")
}

/// Whether a run was kept back from the fit.
fn whether(held_out: bool) -> String {
    if held_out { "kept back" } else { "fitted" }.to_owned()
}

fn table(caption: &str, head: &[&str], rows: &[Vec<String>]) -> String {
    let cells = |tag: &str, words: &mut dyn Iterator<Item = String>| -> String {
        words
            .map(|word| format!("<{tag}>{}</{tag}>", escape(&word)))
            .collect()
    };
    let body: String = rows
        .iter()
        .map(|row| format!("<tr>{}</tr>", cells("td", &mut row.iter().cloned())))
        .collect();
    format!(
        "<div class=\"card scroll\" tabindex=\"0\" style=\"margin-top:1rem\"><table><caption>{}</caption><thead><tr>{}</tr></thead>\
         <tbody>{body}</tbody></table></div>\n",
        escape(caption),
        cells("th", &mut head.iter().map(|word| (*word).to_owned()))
    )
}

fn value_row(name: &str, value: &Value) -> Vec<String> {
    let end = |end: Option<f64>| end.map_or("?".to_owned(), number);
    vec![
        name.to_owned(),
        ilon_report::short(value.value, 5).to_string(),
        end(value.ci95[0]),
        end(value.ci95[1]),
        value.unit.clone(),
        number(value.nominal),
    ]
}

const VALUE_HEAD: [&str; 6] = ["name", "value", "from", "to", "unit", "before"];

fn parameters(found: &Identified) -> String {
    let rows: Vec<Vec<String>> = found
        .parameters
        .iter()
        .chain(&found.derived)
        .map(|(name, value)| value_row(name, value))
        .collect();
    let mut html = table("Parameters", &VALUE_HEAD, &rows);
    if found.series.len() > 1 {
        let rows: Vec<Vec<String>> = found
            .series
            .iter()
            .flat_map(|series| {
                let name = |gain: &String| format!("{}: {gain}", series.name);
                series
                    .gains
                    .iter()
                    .map(move |(gain, value)| value_row(&name(gain), value))
            })
            .collect();
        html += &table("Each series by itself", &VALUE_HEAD, &rows);
    }
    html
}

fn points(directions: &[Direction], of: impl Fn(&Direction) -> Option<f64>) -> Vec<(f64, f64)> {
    directions
        .iter()
        .filter_map(|direction| Some((direction.direction_deg, of(direction)?)))
        .collect()
}

/// The way made along the direction that the wheels ask for.
fn along(directions: &[Direction]) -> Figure {
    let of = |f: fn(&Direction) -> Option<f64>| points(directions, f).into_iter();
    let mut curves = vec![
        exact_curve("ideal", of(|_| Some(1.0)), dotted("@ideal")),
        exact_curve(
            "contact of rigid rollers",
            of(|d| d.contact),
            dashed("@contact"),
        ),
        exact_curve("fitted", of(|d| Some(d.fitted)), solid("@real")),
    ];
    if directions
        .iter()
        .any(|direction| direction.simulated.is_some())
    {
        curves.push(exact_curve("simulated", of(|d| d.simulated), solid("@guidance")).with_dots(6));
    }
    curves.push(dots("measured", of(|d| Some(d.measured)), "@slip", 8));
    Figure {
        id: "along".to_owned(),
        title: "Way made over way asked for".to_owned(),
        caption: "Dots are measured. A fitted line through them is no proof: see the error on what was not fitted.".to_owned(),
        height_px: 340,
        span: Span::Whole,
        over_time: false,
        plot: plot(
            curves,
            Layout::of(axis("direction of motion in the body frame in degrees"), axis("ratio").least_span(0.02)),
        ),
    }
}

/// A figure of half the page's width over the direction of motion.
fn by_direction(id: &str, title: &str, caption: &str, curves: Vec<Curve>, values: Axis) -> Figure {
    Figure {
        id: id.to_owned(),
        title: title.to_owned(),
        caption: caption.to_owned(),
        height_px: 300,
        span: Span::Half,
        over_time: false,
        plot: plot(
            curves,
            Layout::of(axis("direction of motion in degrees"), values),
        ),
    }
}

fn across(directions: &[Direction]) -> Figure {
    let of = |f: fn(&Direction) -> Option<f64>| points(directions, f).into_iter();
    let curves = vec![
        exact_curve("fitted", of(|d| Some(d.fitted_across)), solid("@real")),
        dots("measured", of(|d| Some(d.measured_across)), "@slip", 8),
    ];
    by_direction(
        "across",
        "Way made to the left of it",
        "Over the way asked for: 0.01 is 0.57 degrees off course.",
        curves,
        axis("ratio").least_span(0.01),
    )
}

/// What the chosen model leaves, by direction.
fn left(directions: &[Direction]) -> Figure {
    let names: Vec<String> = directions
        .iter()
        .map(|direction| {
            format!(
                "{:.0}° at {} m/s",
                direction.direction_deg,
                number(direction.speed_m_s)
            )
        })
        .collect();
    let values: Vec<Option<f64>> = directions
        .iter()
        .map(|direction| Some(direction.measured - direction.simulated.unwrap_or(direction.fitted)))
        .collect();
    Figure {
        id: "left".to_owned(),
        title: "What is left".to_owned(),
        caption: "Measured less fitted, or less simulated where a simulation was fitted."
            .to_owned(),
        height_px: 80 + 22 * directions.len() as u32,
        span: Span::Half,
        over_time: false,
        plot: plot(
            vec![bars("measured less model", &values, "@slip")],
            Layout::of(axis("ratio").least_span(0.005), axis("").names(names)),
        ),
    }
}

fn directions(directions: &[Direction]) -> String {
    let known = |value: Option<f64>| value.map_or("-".to_owned(), fine);
    table_of::<Direction>(
        "By direction",
        &[
            ("degrees", &|d| format!("{:.1}", d.direction_deg)),
            ("m/s", &|d| number(d.speed_m_s)),
            ("stretches", &|d| d.stretches.to_string()),
            ("measured", &|d| fine(d.measured)),
            ("standard error", &|d| fine(d.measured_error)),
            ("contact", &|d| known(d.contact)),
            ("fitted", &|d| fine(d.fitted)),
            ("simulated", &|d| known(d.simulated)),
            ("measured across", &|d| fine(d.measured_across)),
            ("fitted across", &|d| fine(d.fitted_across)),
            ("drift left, rad/m", &|d| number(d.drift_rad_per_m)),
        ],
        directions,
    )
}

fn models(found: &Identified) -> String {
    let errors: Vec<Vec<String>> = found
        .models
        .iter()
        .map(|model| {
            vec![
                model.name.clone(),
                model.parameters.len().to_string(),
                number(1e3 * model.fit.position_rms_m),
                number(model.fit.over_noise),
                number(1e3 * model.held_out.position_rms_m),
                number(1e3 * model.held_out.heading_rms_rad),
                number(model.held_out.over_noise),
                number(1e3 * model.held_out.end_position_rms_m),
            ]
        })
        .collect();
    let head = [
        "model",
        "parameters",
        "fitted, mm",
        "over noise",
        "not fitted, mm",
        "mrad",
        "over noise",
        "end of a run, mm",
    ];
    let mut html = table("Errors", &head, &errors);
    for model in &found.models {
        let rows: Vec<Vec<String>> = model
            .parameters
            .iter()
            .map(|(name, value)| value_row(name, value))
            .collect();
        if !rows.is_empty() {
            html += &table(&model.name, &VALUE_HEAD, &rows);
        }
    }
    html
}

fn runs(found: &Identified) -> String {
    table_of::<Run>(
        "Ends of runs",
        &[
            ("log", &|run| run.file.clone()),
            ("", &|run| whether(run.held_out)),
            ("s", &|run| number(run.duration_s)),
            ("m", &|run| number(run.path_m)),
            ("off before, mm", &|run| {
                number(1e3 * run.end_position_nominal_m)
            }),
            ("off after, mm", &|run| number(1e3 * run.end_position_m)),
            ("heading after, mrad", &|run| {
                number(1e3 * run.end_heading_rad)
            }),
        ],
        &found.runs,
    )
}
