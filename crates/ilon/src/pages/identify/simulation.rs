//! What simulating found, on the page of an identification.

use ilon_identify::outcome::{Drive, DriveRipple, DriveTorque, Misses, Simulation};
use ilon_report::figure::{Figure, Layout, Span, axis, dots, plot};
use ilon_report::page::{Section, card, escape};
use ilon_report::sweep::figure as number;

use super::{by_direction, fine, table, table_of, whether};

/// The section of the page.
pub(super) fn section(simulation: &Simulation) -> Section {
    Section {
        id: "simulation",
        title: "By simulating",
        lead:
            "Each steady drive of the logs, driven by the simulated robot at the same wheel rates."
                .to_owned(),
        body: format!(
            "{}<div class=\"grid\">\n{}{}{}</div>\n{}{}{}{}{}",
            story(simulation),
            card(&left(&simulation.drives)),
            card(&drift(simulation)),
            pull(simulation).map_or(String::new(), |figure| card(&figure)),
            misses(simulation),
            series(simulation),
            ripple(simulation),
            torques(simulation),
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
        rms(simulation.fit.ratio),
        rms(simulation.held_out.ratio)
    ));
    for [a, b] in &simulation.alike {
        lines.push(format!(
            "<b class=\"failed\">✗</b> {} and {} are hardly told apart by these logs: what one changes the other makes up for, and their intervals allow for it.",
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
            "<b class=\"failed\">✗</b> These logs leave {} open: its interval holds all of its range, as other keys may make up for it. What all of \
             them come to together may hold all the same.",
            escape(key)
        ));
    }
    for key in &simulation.cut_off {
        lines.push(format!(
            "The interval of {} reaches an end of its range: what lies beyond was not tried.",
            escape(key)
        ));
    }
    for key in &simulation.of_one_run {
        lines.push(format!(
            "<b class=\"failed\">✗</b> How sure {} is cannot be said: one run alone tells it. Drive what it drives once more.",
            escape(key)
        ));
    }
    for key in &simulation.at_bounds {
        lines.push(format!(
            "<b class=\"failed\">✗</b> {} lies at an end of its range: beyond it the fit may be better.",
            escape(key)
        ));
    }
    for other in &simulation.elsewhere {
        lines.push(format!(
            "<b class=\"failed\">✗</b> {} near {} is not refused by these logs either, but much of what lies between is: its interval holds both. Other \
             directions, or what happens once a roller, may tell them apart.",
            escape(&other.key),
            number(other.value)
        ));
    }
    if simulation.phases_matter == Some(true) {
        lines.push(format!(
            "What is found depends on the angles of their rollers at which wheels began, which the logs do not say: each drive was simulated from {} \
             sets of angles, and the intervals hold what these scatter by.",
            simulation.phases
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

/// The heading's drift in each drive, measured and simulated.
fn drift(simulation: &Simulation) -> Figure {
    let of = |value: fn(&Drive) -> f64| {
        let drives = simulation.drives.iter();
        drives.map(move |drive| (drive.direction_deg, value(drive)))
    };
    let curves = vec![
        dots(
            "simulated",
            of(|d| d.simulated_drift_rad_per_m),
            "@guidance",
            8,
        ),
        dots("measured", of(|d| d.measured_drift_rad_per_m), "@slip", 8),
    ];
    by_direction(
        "simulated-drift",
        "Drift of the heading",
        "By how much the robot turns beyond what its wheels ask for, over the way that they ask for.",
        curves,
        axis("rad/m").least_span(0.05),
    )
}

/// The torques of the wheels in each drive, measured and simulated; `None` where the log has no currents.
fn pull(simulation: &Simulation) -> Option<Figure> {
    let of = |value: fn(&DriveTorque) -> f64| {
        let drives = simulation.drives.iter();
        drives.flat_map(move |drive| {
            let torques = drive.torques.iter();
            torques.map(move |torque| (drive.direction_deg, value(torque).abs()))
        })
    };
    if simulation
        .drives
        .iter()
        .all(|drive| drive.torques.is_empty())
    {
        return None;
    }
    let curves = vec![
        dots("simulated", of(|t| t.simulated_n_m), "@guidance", 8),
        dots("measured", of(|t| t.measured_n_m), "@slip", 8),
    ];
    Some(by_direction(
        "simulated-torques",
        "Torques of the wheels",
        "Of the wheels that turn, by the currents of their motors; sizes.",
        curves,
        axis("N m").least_span(0.05),
    ))
}

/// What is left, of the fitted keys and of others beside them.
fn misses(simulation: &Simulation) -> String {
    let row = |name: &str, which: bool, misses: &Misses| {
        let known = |value: Option<f64>| value.map_or("-".to_owned(), fine);
        vec![
            name.to_owned(),
            whether(which),
            known(misses.ratio),
            known(misses.drift_rad_per_m),
            known(misses.torque_n_m),
        ]
    };
    let mut rows = vec![
        row("with the values found", false, &simulation.fit),
        row("with the values found", true, &simulation.held_out),
    ];
    for beside in &simulation.beside {
        rows.push(row(&beside.name, false, &beside.fit));
        rows.push(row(&beside.name, true, &beside.held_out));
    }
    table(
        "Measured less simulated, root mean square over drives",
        &["model", "", "way over asked", "drift, rad/m", "torque, N m"],
        &rows,
    )
}

fn torques(simulation: &Simulation) -> String {
    let rows: Vec<Vec<String>> = simulation
        .drives
        .iter()
        .flat_map(|drive| {
            drive.torques.iter().map(|torque| {
                vec![
                    drive.file.clone(),
                    whether(drive.held_out),
                    format!("{:.0}", drive.direction_deg),
                    torque.wheel.clone(),
                    fine(torque.measured_n_m),
                    fine(torque.measured_error_n_m),
                    fine(torque.simulated_n_m),
                ]
            })
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let head = [
        "log",
        "",
        "degrees",
        "wheel",
        "measured",
        "standard error",
        "simulated",
    ];
    table("Torques of the wheels that turn, in N m", &head, &rows)
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
            ("measured drift, rad/m", &|drive| {
                fine(drive.measured_drift_rad_per_m)
            }),
            ("standard error", &|drive| {
                fine(drive.measured_drift_error_rad_per_m)
            }),
            ("simulated drift", &|drive| {
                fine(drive.simulated_drift_rad_per_m)
            }),
        ],
        &simulation.drives,
    )
}
