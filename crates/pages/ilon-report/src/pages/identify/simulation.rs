//! Results of the fit by simulation, on the page of an identification.

use crate::figure::{Figure, Layout, Span, axis, dots, plot};
use crate::page::{self, Section, grid};
use ilon_identify::outcome::{DriveTorque, Simulation, SteadyDrive};

use super::direction::{by_direction, turn};
use crate::answers::identify::tables;

/// The section of the page.
pub(super) fn section(simulation: &Simulation) -> Section {
    let mut figures = vec![left(&simulation.drives), drift(simulation)];
    figures.extend(pull(simulation));
    Section {
        id: "simulation",
        title: "By simulating",
        lead:
            "Each steady drive of the logs, driven by the simulated robot at the same wheel rates."
                .to_owned(),
        body: grid(&figures)
            + &(tables::of_simulation(simulation).iter().map(page::table)).collect::<String>(),
    }
}

/// Measured less simulated values, for each drive.
fn left(drives: &[SteadyDrive]) -> Figure {
    let of = |held_out: bool| {
        let own = drives
            .iter()
            .filter(move |drive| drive.held_out == held_out);
        own.map(|drive| (drive.direction_deg, drive.measured - drive.simulated))
    };
    let curves = vec![
        dots("fitted", of(false), "@slip", 8),
        dots("unseen", of(true), "@guidance", 8),
    ];
    Figure::new(
        "simulated-left",
        "Measured less simulated",
        "Of each drive, as a share of its distance. Unseen drives should scatter as the fitted ones do.",
        plot(
            curves,
            Layout::of(
                turn(),
                axis("ratio").least_span(0.01),
            ),
        ),
    )
    .height_px(300)
    .spanning(Span::Whole)
}

/// The heading's drift in each drive, measured and simulated.
fn drift(simulation: &Simulation) -> Figure {
    let of = |value: fn(&SteadyDrive) -> f64| {
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
        "By how much the robot turns beyond its wheel speeds, per distance.",
        curves,
        axis("rad/m").least_span(0.05),
    )
}

/// The torques of the wheels in each drive, measured and simulated; `None` if the log has no
/// currents.
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
