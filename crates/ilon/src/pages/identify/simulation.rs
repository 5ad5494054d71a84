//! What simulating found, on the page of an identification.

use ilon_identify::outcome::{Drive, DriveRipple, Simulation};
use ilon_report::figure::{Figure, Layout, Span, axis, dots, plot};
use ilon_report::page::{Section, card, escape};
use ilon_report::sweep::figure as number;

use super::{fine, table, table_of, whether};

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
    let drives = simulation.drives.iter();
    let rippled: Vec<(&Drive, DriveRipple)> = drives
        .filter_map(|drive| Some((drive, drive.ripple?)))
        .collect();
    if rippled.is_empty() {
        return String::new();
    }
    type Rippled<'d> = (&'d Drive, DriveRipple);
    table_of::<Rippled>(
        "What wheels (mrad/s) and body (mm) do once a roller: amplitudes",
        &[
            ("log", &|(drive, _)| drive.file.clone()),
            ("", &|(drive, _)| whether(drive.held_out)),
            ("degrees", &|(drive, _)| {
                format!("{:.0}", drive.direction_deg)
            }),
            ("wheels", &|(_, ripple)| number(1e3 * ripple.wheels_rad_s)),
            ("standard error", &|(_, ripple)| {
                number(1e3 * ripple.wheels_error_rad_s)
            }),
            ("simulated", &|(_, ripple)| {
                number(1e3 * ripple.wheels_simulated_rad_s)
            }),
            ("body", &|(_, ripple)| number(1e3 * ripple.body_m)),
            ("standard error", &|(_, ripple)| {
                number(1e3 * ripple.body_error_m)
            }),
            ("simulated", &|(_, ripple)| {
                number(1e3 * ripple.body_simulated_m)
            }),
            ("rollers counted", &|(_, ripple)| {
                format!("{:.3}", ripple.rollers_counted)
            }),
        ],
        &rippled,
    )
}

fn drives(simulation: &Simulation) -> String {
    table_of::<Drive>(
        "Drives",
        &[
            ("log", &|drive| drive.file.clone()),
            ("", &|drive| whether(drive.held_out)),
            ("degrees", &|drive| format!("{:.1}", drive.direction_deg)),
            ("measured", &|drive| fine(drive.measured)),
            ("standard error", &|drive| fine(drive.measured_error)),
            ("simulated", &|drive| fine(drive.simulated)),
            ("measured across", &|drive| fine(drive.measured_across)),
            ("simulated across", &|drive| fine(drive.simulated_across)),
        ],
        &simulation.drives,
    )
}
