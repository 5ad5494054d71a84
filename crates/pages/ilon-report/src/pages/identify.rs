//! The page of an identification: the results, and the measured robot compared with the ideal one,
//! the one by its rollers' geometry, and the fitted one.

mod direction;
mod simulation;

use crate::figure::{Figure, Layout, Span, axis, bars, dots, dotted, exact_curve, plot, solid};
use crate::page::{self, Head, Section, escape, grid};
use crate::sweep::figure as number;
use ilon_identify::Identified;
use ilon_identify::outcome::Direction;

use self::direction::{by_direction, turn};
use crate::answers::identify::{answers, tables};

/// Returns the page as one self-contained HTML file.
pub fn html(found: &Identified) -> String {
    let head = Head {
        kind: "identification",
        title: found.study.clone(),
        facts: facts(found),
        lead: page::answers(&answers(found)),
    };
    let mut sections = vec![Section {
        id: "parameters",
        title: "What was found",
        lead: match found.series.len() {
            0 | 1 => "Each value with its 95 % interval, for runs like these.".to_owned(),
            _ => "Each value with its 95 % interval, for runs like these. Where series by themselves differ by more, something changed between them."
                .to_owned(),
        },
        body: page::table(&tables::parameters(found)) + &page::table(&tables::series(found)),
    }];
    if !found.residual.is_empty() {
        // A robot that drove only ahead and back has two directions: no curve goes through them.
        let is_aside = |of: &Direction| of.direction_deg.to_radians().sin().abs() > 0.2;
        let charts = match found.residual.iter().any(is_aside) {
            true => grid(&[
                along(&found.residual),
                across(&found.residual),
                left(&found.residual),
            ]),
            false => String::new(),
        };
        sections.push(Section {
            id: "directions",
            title: "By direction of motion",
            lead: "The distance achieved over that of the wheel speeds, by the kinematics of the nominal robot.".to_owned(),
            body: charts + &page::table(&tables::directions(&found.residual)),
        });
    }
    sections.extend(found.simulation.as_ref().map(simulation::section));
    sections.push(Section {
        id: "models",
        title: "Models",
        lead: "The model with the least error on what was not fitted is chosen; a fit alone always prefers the one with the most \
               parameters."
            .to_owned(),
        body: std::iter::once(tables::errors(found))
            .chain(tables::of_models(found))
            .map(|table| page::table(&table))
            .collect(),
    });
    sections.push(Section {
        id: "runs",
        title: "Runs",
        lead: "Where dead reckoning ends, from the pose at the beginning of the run on.".to_owned(),
        body: page::table(&tables::runs(found)),
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

fn points(directions: &[Direction], of: impl Fn(&Direction) -> Option<f64>) -> Vec<(f64, f64)> {
    directions
        .iter()
        .filter_map(|direction| Some((direction.direction_deg, of(direction)?)))
        .collect()
}

/// Distance along the direction commanded by the wheels.
fn along(directions: &[Direction]) -> Figure {
    let of = |f: fn(&Direction) -> Option<f64>| points(directions, f).into_iter();
    let ideal = [(-10.0, 1.0), (360.0, 1.0)].into_iter();
    // Vertical lines with a gap after each.
    let spread = directions.iter().flat_map(|d| {
        let half = 2.0 * d.measured_error;
        [d.measured - half, d.measured + half, f64::NAN].map(|end| (d.direction_deg, end))
    });
    let mut curves = vec![
        exact_curve("ideal", ideal, dotted("@ideal")),
        exact_curve(
            "two standard errors of the measured",
            spread,
            solid("@slip"),
        ),
        dots("contact of rigid rollers", of(|d| d.contact), "@contact", 8),
        dots("fitted", of(|d| Some(d.fitted)), "@real", 8),
        dots("simulated", of(|d| d.simulated), "@guidance", 8),
        dots("measured", of(|d| Some(d.measured)), "@slip", 8),
    ];
    if directions
        .iter()
        .all(|direction| direction.simulated.is_none())
    {
        curves.remove(4);
    }
    Figure::new(
        "along",
        "Distance achieved over distance by the wheel speeds",
        "For each direction driven. A close fit is no proof: see the error on \
         unseen data.",
        plot(curves, Layout::of(turn(), axis("ratio").least_span(0.02))),
    )
    .height_px(340)
    .spanning(Span::Whole)
}

fn across(directions: &[Direction]) -> Figure {
    let of = |f: fn(&Direction) -> Option<f64>| points(directions, f).into_iter();
    let curves = vec![
        dots("fitted", of(|d| Some(d.fitted_across)), "@real", 8),
        dots("measured", of(|d| Some(d.measured_across)), "@slip", 8),
    ];
    by_direction(
        "across",
        "Sideways error",
        "As a share of the distance: 0.01 is 0.57 degrees off course.",
        curves,
        axis("ratio").least_span(0.01),
    )
}

/// Residual of the chosen model, by direction.
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
    Figure::new(
        "left",
        "What is left",
        "Measured less fitted, or less simulated where a simulation was fitted.",
        plot(
            vec![bars("measured less model", &values, "@slip")],
            Layout::of(axis("ratio").least_span(0.005), axis("").names(names)),
        ),
    )
    .height_px(80 + 22 * directions.len() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.9 with a standard error of 0.1: the line is from 0.7 to 1.1.
    #[test]
    fn two_standard_errors_are_drawn_around_what_was_measured() {
        let direction = Direction {
            direction_deg: 30.0,
            speed_m_s: 0.2,
            stretches: 9,
            measured: 0.9,
            measured_error: 0.1,
            measured_across: 0.0,
            contact: None,
            fitted: 0.9,
            fitted_across: 0.0,
            simulated: None,
            drift_rad_per_m: 0.0,
        };
        let plot: serde_json::Value =
            serde_json::from_str(&along(&[direction]).plot).expect("JSON");
        let curves = plot["curves"].as_array().expect("curves");
        let spread = curves
            .iter()
            .find(|curve| curve["name"] == "two standard errors of the measured")
            .expect("it is drawn");
        let ends: Vec<f64> = spread["y"]
            .as_array()
            .expect("numbers")
            .iter()
            .filter_map(serde_json::Value::as_f64)
            .collect();
        assert!(
            (ends[0] - 0.7).abs() < 1e-6 && (ends[1] - 1.1).abs() < 1e-6,
            "{ends:?}"
        );
    }
}
