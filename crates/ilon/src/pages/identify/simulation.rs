//! What simulating found, on the page of an identification.

use ilon_identify::outcome::{Drive, Simulation};
use ilon_report::figure::{Figure, Layout, Span, axis, dots, plot};
use ilon_report::page::{Section, card, escape};
use ilon_report::sweep::figure as number;

use super::table;

/// The section of the page.
pub(super) fn section(simulation: &Simulation) -> Section {
    Section {
        id: "simulation",
        title: "By simulating",
        lead:
            "Each steady drive of the logs, driven by the simulated robot at the same wheel rates."
                .to_owned(),
        body: format!(
            "{}<div class=\"grid\">\n{}</div>\n{}{}{}",
            story(simulation),
            card(&left(&simulation.drives)),
            series(simulation),
            ripple(simulation),
            drives(simulation)
        ),
    }
}

/// What is to be known before the values are believed.
fn story(simulation: &Simulation) -> String {
    let mut lines: Vec<String> = Vec::new();
    let rms = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
    lines.push(format!(
        "Measured less simulated way over the way asked for is {} (root mean square) over the drives that were fitted, and {} over those that \
         were kept back.",
        rms(simulation.ratio_rms_fit),
        rms(simulation.ratio_rms_held_out)
    ));
    for [a, b] in &simulation.alike {
        lines.push(format!(
            "<b class=\"failed\">✗</b> {} and {} are hardly told apart by these logs: their intervals hold with the other as it is.",
            escape(a),
            escape(b)
        ));
    }
    for key in &simulation.insensitive {
        lines.push(format!(
            "<b class=\"failed\">✗</b> {} changes less than the noise over all of its range.",
            escape(key)
        ));
    }
    for key in &simulation.open {
        lines.push(format!(
            "<b class=\"failed\">✗</b> These logs leave {} open: its interval holds all of its range, as the other keys make up for it. What all of \
             them come to together may hold all the same.",
            escape(key)
        ));
    }
    for key in &simulation.at_bounds {
        lines.push(format!(
            "<b class=\"failed\">✗</b> {} lies at an end of its range: beyond it the fit may be better.",
            escape(key)
        ));
    }
    if !simulation.has_converged {
        lines.push(
            "<b class=\"failed\">✗</b> The search was cut off after its steps: <code>simulate.steps</code> allows more."
                .to_owned(),
        );
    }
    let lines: String = lines.iter().map(|line| format!("<p>{line}</p>")).collect();
    format!("<div class=\"story\">{lines}</div>\n")
}

/// Measured less simulated, of each drive.
fn left(drives: &[Drive]) -> Figure {
    let of = |held_out: bool| {
        let own = drives
            .iter()
            .filter(move |drive| drive.held_out == held_out);
        own.map(|drive| (drive.direction_deg, drive.measured - drive.simulated))
    };
    let curves = vec![
        dots("fitted", of(false), "@slip", 8),
        dots("kept back", of(true), "@guidance", 8),
    ];
    Figure {
        id: "simulated-left".to_owned(),
        title: "Measured less simulated".to_owned(),
        caption: "Of each drive, over the way asked for. Drives that were kept back should scatter as those that were fitted do."
            .to_owned(),
        height_px: 300,
        span: Span::Whole,
        over_time: false,
        plot: plot(
            curves,
            Layout::of(
                axis("direction of motion in degrees"),
                axis("ratio").least_span(0.01),
            ),
        ),
    }
}

fn series(simulation: &Simulation) -> String {
    if simulation.series.is_empty() {
        return String::new();
    }
    let rows: Vec<Vec<String>> = simulation
        .series
        .iter()
        .map(|series| {
            let end = |end: Option<f64>| end.map_or("?".to_owned(), |value| format!("{value:.4}"));
            let measured = &series.sideways_over_ahead;
            vec![
                series.name.clone(),
                whether(series.held_out),
                format!("{:.4}", measured.value),
                end(measured.ci95[0]),
                end(measured.ci95[1]),
                format!("{:.4}", series.simulated),
            ]
        })
        .collect();
    table(
        "Sideways over ahead",
        &["series", "", "measured", "from", "to", "simulated"],
        &rows,
    )
}

fn ripple(simulation: &Simulation) -> String {
    let rows: Vec<Vec<String>> = simulation
        .drives
        .iter()
        .filter_map(|drive| {
            let ripple = drive.ripple?;
            Some(vec![
                drive.file.clone(),
                whether(drive.held_out),
                format!("{:.0}", drive.direction_deg),
                number(1e3 * ripple.wheels_rad_s),
                number(1e3 * ripple.wheels_error_rad_s),
                number(1e3 * ripple.wheels_simulated_rad_s),
                number(1e3 * ripple.body_m),
                number(1e3 * ripple.body_error_m),
                number(1e3 * ripple.body_simulated_m),
                format!("{:.3}", ripple.rollers_counted),
            ])
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    table(
        "What wheels (mrad/s) and body (mm) do once a roller: amplitudes",
        &[
            "log",
            "",
            "degrees",
            "wheels",
            "standard error",
            "simulated",
            "body",
            "standard error",
            "simulated",
            "rollers counted",
        ],
        &rows,
    )
}

fn drives(simulation: &Simulation) -> String {
    let rows: Vec<Vec<String>> = simulation
        .drives
        .iter()
        .map(|drive| {
            vec![
                drive.file.clone(),
                whether(drive.held_out),
                format!("{:.1}", drive.direction_deg),
                format!("{:.4}", drive.measured),
                format!("{:.4}", drive.measured_error),
                format!("{:.4}", drive.simulated),
                format!("{:.4}", drive.measured_across),
                format!("{:.4}", drive.simulated_across),
            ]
        })
        .collect();
    table(
        "Drives",
        &[
            "log",
            "",
            "degrees",
            "measured",
            "standard error",
            "simulated",
            "measured across",
            "simulated across",
        ],
        &rows,
    )
}

fn whether(held_out: bool) -> String {
    if held_out { "kept back" } else { "fitted" }.to_owned()
}
