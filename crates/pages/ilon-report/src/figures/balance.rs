//! Figures of the error ledger (commanded minus actual motion) and of the energy balance.

use ilon_trace::ledger::{Integral, NAMES, TERMS};
use ilon_trace::{Ledger, Record, Summary};

use crate::accumulate::{OfRobot, Way};
use crate::decimate::evenly;
use crate::figure::{
    Curve, Figure, Layout, axis, bars, curve, dashed, dots, exact_curve, plot, solid,
};
use crate::input::RunInput;
use crate::story::{Budget, PARTS};
use crate::text::{by_kind, label, length};

/// A component of the ledger, such as its x.
type Quantity = fn(&Integral) -> f64;

/// Colour names of the ledger's terms, in the ledger's order.
pub(crate) const TERM_COLORS: [&str; TERMS] = [
    "@guidance",
    "@compensation",
    "@belief",
    "@servo",
    "@geometry",
    "@lift-off",
    "@conflict",
    "@slip",
    "@incline",
];

/// Colour names of what leads from the total to the error at the end: its start, and guidance.
const CLOSING_COLORS: [&str; 2] = ["@asked", "@correction"];

/// Terms that the table beside the figures rounds to zero draw no figure.
const LEAST_MM: f64 = 5e-3;
const LEAST_DEG: f64 = 5e-4;

/// The ledger: net bars, and the growth of the terms.
pub(crate) fn ledger(shown: &RunInput, summary: &Summary) -> Vec<Figure> {
    let mm = |i: &Integral, f: Quantity| 1e3 * f(i);
    let position: [(&str, Quantity); 2] = [("along x", |i| i.x_m), ("along y", |i| i.y_m)];
    let heading: [(&str, Quantity); 1] = [("heading", |i| i.heading_rad)];
    let closing = shown.all.off_course.closing(&summary.ledger);
    let grew = |of: fn(&Way) -> f64, least: f64| {
        let last = shown.all.grown().last();
        last.is_some_and(|grown| grown.ways.iter().any(|way| of(way) >= least))
    };
    let mut figures = Vec::new();
    if grew(|way| way.way_mm, LEAST_MM) {
        figures.push(Figure::new(
            "ledger-position",
            "Commanded minus real: position",
            "Commanded minus real motion over the run along the world's axes, and what leads from there to the error at the end. The bars of one row \
             add up to its dot exactly; bars that point left are gains.",
            bars_of((&summary.ledger, &closing), &position, mm, "mm"),
        )
        .height_px(260));
        figures.push(growth(
            shown,
            "ledger-growth-position",
            "How the terms grew: position",
            "The length of the path of each term, stacked. Motion to and fro counts twice, so that no term hides in a \
             sum that cancels.",
            "mm",
            |way| way.way_mm,
        ));
    }
    if grew(|way| way.turn_deg, LEAST_DEG) {
        figures.push(
            Figure::new(
                "ledger-heading",
                "Commanded minus real: heading",
                "The same for the heading.",
                bars_of(
                    (&summary.ledger, &closing),
                    &heading,
                    |i, f| f(i).to_degrees(),
                    "deg",
                ),
            )
            .height_px(260),
        );
        figures.push(growth(
            shown,
            "ledger-growth-heading",
            "How the terms grew: heading",
            "The same for the heading.",
            "deg",
            |way| way.turn_deg,
        ));
    }
    figures
}

/// The error budget: what moved the robot off its reference up to the worst instant, and what moved
/// it back.
pub(crate) fn budget(budget: &Budget) -> Figure {
    let colors = std::iter::once("@correction").chain(TERM_COLORS);
    // A part below a hundredth of the error is invisible as a bar.
    let least_m = 0.01 * budget.error_m;
    let mut rows: Vec<(String, f64, &'static str)> = Vec::new();
    if budget.before_m.abs() > least_m {
        rows.push(("error at the start".to_owned(), budget.before_m, "@asked"));
    }
    for ((name, m), color) in PARTS.into_iter().zip(budget.parts_m).zip(colors) {
        if m.abs() > least_m {
            rows.push((name.to_owned(), m, color));
        }
    }
    if budget.rest_m.abs() > least_m {
        rows.push(("between rows".to_owned(), budget.rest_m, "@muted"));
    }
    rows.push((
        "error at the worst instant".to_owned(),
        budget.error_m,
        "@fg",
    ));
    let names: Vec<String> = rows.iter().map(|(name, _, _)| name.clone()).collect();
    let height_px = 60 + 44 * rows.len() as u32;
    let curves = rows.iter().enumerate().map(|(row, (name, m, color))| {
        let values: Vec<_> = (0..rows.len())
            .map(|k| (k == row).then_some(1e3 * m))
            .collect();
        bars(name, &values, color).unlisted()
    });
    Figure::new(
        "budget",
        "Error budget at the worst instant",
        format!(
            "What made the position error of {} at {:.2} s, counted along the error since {:.2} s. The parts add up to it; bars \
             that point left brought the robot back.",
            length(budget.error_m),
            budget.at_s,
            budget.from_s
        ),
        plot(
            curves.collect(),
            Layout::of(axis("mm along the error"), axis("").names(names)),
        ),
    )
    .height_px(height_px)
}

/// The motors' work and its sinks.
pub(crate) fn energy(shown: &RunInput) -> Figure {
    let trace = &*shown.trace;
    let of = |f: fn(&Record, &Record) -> f64| {
        let records = trace.records();
        records
            .first()
            .into_iter()
            .flat_map(move |first| records.iter().map(move |r| (r.t_s, f(r, first))))
    };
    let stacked = |name, points: &mut dyn Iterator<Item = (f64, f64)>, color| {
        let points: Vec<_> = points.collect();
        let kept = evenly(points.len(), 800).into_iter().map(|k| points[k]);
        exact_curve(name, kept, solid(color).width(0.8)).stacked()
    };
    let mut traces = vec![
        stacked(
            label("energy.slip_j"),
            &mut of(|r, _| r.slip_energy_j),
            "@slip",
        ),
        stacked(
            label("energy.spin_up_j"),
            &mut of(|r, _| r.spin_up_energy_j),
            "@w1",
        ),
        stacked(
            label("energy.bearing_j"),
            &mut of(|r, _| r.bearing_energy_j),
            "@servo",
        ),
        stacked(
            label("energy.impact_j"),
            &mut of(|r, _| r.impact_energy_j),
            "@w3",
        ),
        stacked(
            label("energy.stored_j"),
            &mut of(|r, first| {
                r.kinetic_energy_j + r.potential_energy_j
                    - first.kinetic_energy_j
                    - first.potential_energy_j
            }),
            "@contact",
        ),
        curve(
            "motors and outside",
            shown.all.robot(OfRobot::PutIn),
            solid("@asked").width(2.2),
        ),
        curve(
            label("energy.unexplained_j"),
            shown.all.robot(OfRobot::Unexplained),
            dashed("@limit"),
        ),
    ];
    if trace.header.is_on_tyres() {
        traces.retain(|curve| curve.name() != label("energy.spin_up_j"));
    }
    let lost_to = by_kind(
        &trace.header,
        "sliding,",
        "sliding, to spinning up rollers,",
    );
    Figure::over_time(
        "energy",
        "Where the motors' work went",
        format!(
            "Lost to {lost_to} bearings and landing, or stored as motion. The line is the motors' work with that of pushes and payloads; \
             what lies between it and the stack is the solver's own loss or gain."
        ),
        traces,
        axis("energy in J"),
    )
}

/// Horizontal bars, stacked by sign: one row per quantity, one colour per term.
fn bars_of(
    (ledger, closing): (&Ledger, &[(&'static str, [f64; 3])]),
    rows: &[(&str, Quantity)],
    value: fn(&Integral, Quantity) -> f64,
    unit: &str,
) -> String {
    let names = rows.iter().map(|(name, _)| (*name).to_owned()).collect();
    let mut curves: Vec<Curve> = ledger
        .shown()
        .map(|(place, name, term)| {
            let values: Vec<_> = rows.iter().map(|(_, f)| Some(value(&term, *f))).collect();
            bars(name, &values, TERM_COLORS[place])
        })
        .collect();
    let mut closing = closing.iter().map(|(name, [x_m, y_m, heading_rad])| {
        let net = Integral {
            x_m: *x_m,
            y_m: *y_m,
            heading_rad: *heading_rad,
            ..Integral::default()
        };
        let values: Vec<f64> = rows.iter().map(|(_, f)| value(&net, *f)).collect();
        (*name, values)
    });
    let end = closing.next_back();
    for ((name, values), color) in closing.zip(CLOSING_COLORS) {
        let values: Vec<_> = values.into_iter().map(Some).collect();
        curves.push(bars(name, &values, color));
    }
    if let Some((name, values)) = end {
        let dots_at = values
            .into_iter()
            .zip(0..)
            .map(|(x, row)| (x, f64::from(row)));
        curves.push(dots(name, dots_at, "@fg", 12).opacity(1.0));
    }
    let x = axis(unit);
    plot(curves, Layout::of(x, axis("").names(names)))
}

/// Accumulated displacement of each term, stacked.
fn growth(
    shown: &RunInput,
    id: &str,
    title: &str,
    caption: &str,
    unit: &str,
    of: fn(&Way) -> f64,
) -> Figure {
    let mut traces: Vec<Curve> = Vec::new();
    for (term, (name, color)) in NAMES.into_iter().zip(TERM_COLORS).enumerate() {
        if !shown.trace.header.has_term(name) {
            continue;
        }
        let grown = shown.all.grown().iter();
        let points = grown.map(|grown| (grown.t_s, of(&grown.ways[term])));
        traces.push(exact_curve(name, points, solid(color).width(0.8)).stacked());
    }
    Figure::over_time(id, title, caption, traces, axis(unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parts below a hundredth of the error get no bar; all bars are in millimetres, the whole
    /// error last.
    #[test]
    fn an_error_budget_has_a_bar_for_each_part_that_can_be_seen() {
        let said = Budget {
            error_m: 0.1,
            ahead_m: 0.0,
            before_m: -0.02,
            parts_m: [0.0005, 0.03, -0.002, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0915, 0.0],
            rest_m: 0.0,
            from_s: 0.0,
            at_s: 1.0,
        };
        let figure = budget(&said);
        let plot: serde_json::Value = serde_json::from_str(&figure.plot).expect("JSON");
        let bars: Vec<(String, f64)> = plot["curves"]
            .as_array()
            .expect("curves")
            .iter()
            .map(|curve| {
                let name = curve["name"].as_str().expect("a name").to_owned();
                let values = curve["x"].as_array().expect("few values").iter();
                (name, values.filter_map(serde_json::Value::as_f64).sum())
            })
            .collect();
        let lengths: Vec<f64> = bars.iter().map(|(_, mm)| *mm).collect();
        assert_eq!(lengths, [-20.0, 30.0, -2.0, 91.5, 100.0], "{bars:?}");
        let named = [bars[1].0.as_str(), bars[2].0.as_str(), bars[3].0.as_str()];
        assert_eq!(named, [PARTS[1], PARTS[2], PARTS[8]]);
    }

    /// In a pile of bars colours alone tell which is which.
    #[test]
    fn bars_of_one_row_have_colours_of_their_own_in_both_themes() {
        let themes: Vec<&str> = include_str!("../web/style.css")
            .split(":root")
            .skip(1)
            .collect();
        for theme in &themes[..2] {
            let value = |name: &&str| {
                let key = format!("--{}: #", name.trim_start_matches('@'));
                let at = theme.find(&key).unwrap_or_else(|| panic!("no {key}")) + key.len();
                &theme[at..at + 6]
            };
            let colors: Vec<&str> = TERM_COLORS
                .iter()
                .chain(&CLOSING_COLORS)
                .map(value)
                .collect();
            let distinct: std::collections::BTreeSet<_> = colors.iter().collect();
            assert_eq!(distinct.len(), colors.len(), "{colors:?}");
        }
    }

    #[test]
    fn the_ledgers_bars_are_the_summarys_terms_in_millimetres() {
        let trace = crate::sample::made_up_run(2.0, false);
        let summary = Summary::of(&trace, &ilon_trace::Settings::default());
        let Ok(shown) = RunInput::of(&trace);
        let figures = ledger(&shown, &summary);
        let plot: serde_json::Value = serde_json::from_str(&figures[0].plot).expect("JSON");
        let curves = plot["curves"].as_array().expect("curves");
        let drawn: Vec<f64> = curves
            .iter()
            .flat_map(|curve| curve["x"].as_array().expect("few values"))
            .filter_map(serde_json::Value::as_f64)
            .collect();
        for (name, term) in summary.ledger.named() {
            for metres in [term.x_m, term.y_m] {
                let mm = 1e3 * metres;
                let near = |x: &f64| (x - mm).abs() <= 1e-4 * mm.abs() + 1e-9;
                assert!(drawn.iter().any(near), "{name}: {mm} in {drawn:?}");
            }
        }
    }

    #[test]
    fn what_lies_between_rows_has_a_bar_whichever_way_it_goes() {
        for rest_m in [-0.03, 0.03] {
            let said = Budget {
                error_m: 0.1,
                ahead_m: 0.0,
                before_m: 0.0,
                parts_m: [0.1 - rest_m, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                rest_m,
                from_s: 0.0,
                at_s: 1.0,
            };
            let plot = budget(&said).plot;
            assert!(plot.contains("between rows"), "{rest_m}");
        }
    }
}
