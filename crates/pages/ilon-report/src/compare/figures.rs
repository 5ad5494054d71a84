//! Figures with a curve or a bar for each run.

use ilon_robot::{Pose, wrap_angle};
use ilon_trace::ledger::{Integral, NAMES, TERMS};
use ilon_trace::quantities::by_key;
use ilon_trace::{Record, Summary, WheelSample};

use crate::compare::{ComparedRun, Comparison};
use crate::figure::{
    Axis, Curve, Figure, Layout, Pen, Span, axis, bars, curve, dashed, map_layout, plot, wheel_pen,
};
use crate::figures::balance::TERM_COLORS;
use crate::figures::motion::{COMPONENTS, way};

/// The pen of a run: colours and dashes of the wheels, but wider.
pub(super) fn run_pen(index: usize) -> Pen {
    wheel_pen(index).width(2.0)
}

/// The paths on the floor, and their references.
pub(super) fn path(comparison: &Comparison) -> Figure {
    let mut curves: Vec<Curve> = Vec::new();
    for reference in references(comparison) {
        curves.push(way("reference", &reference, dashed("@asked")));
    }
    for (index, run) in comparison.runs.iter().enumerate() {
        let poses: Vec<Pose> = run.trace.records().iter().map(|r| r.truth.pose).collect();
        curves.push(way(&run.name, &poses, run_pen(index)));
    }
    Figure::new(
        "path",
        "The paths over the floor",
        "Seen from above: the path that each robot really took.",
        plot(curves, map_layout()),
    )
    .height_px(440)
}

/// Returns the distinct references of the runs.
fn references(comparison: &Comparison) -> Vec<Vec<Pose>> {
    // References further apart than a millimetre differ.
    const SAME_M: f64 = 1e-3;
    let mut found: Vec<Vec<Pose>> = Vec::new();
    for run in &comparison.runs {
        let records = run.trace.records().iter();
        let poses: Vec<Pose> = records.filter_map(|r| r.desired.map(|d| d.pose)).collect();
        let is_known = found.iter().any(|known| {
            let mut pairs = known.iter().zip(&poses);
            pairs.all(|(a, b)| (a.position_m() - b.position_m()).norm() < SAME_M)
        });
        if !poses.is_empty() && !is_known {
            found.push(poses);
        }
    }
    found
}

/// Position and heading error over time, for runs with a reference.
pub(super) fn errors(comparison: &Comparison) -> Vec<Figure> {
    if comparison
        .runs
        .iter()
        .all(|run| run.summary.position_error_final_m.is_none())
    {
        return Vec::new();
    }
    let of = |error: fn(&Pose, &Pose) -> f64| {
        each_run(comparison, move |run| {
            let records = run.trace.records().iter();
            let errors =
                records.filter_map(|r| Some((r.t_s, error(&r.desired?.pose, &r.truth.pose))));
            errors.collect()
        })
    };
    let position = of(|desired, truth| 1e3 * (desired.position_m() - truth.position_m()).norm());
    let heading =
        of(|desired, truth| wrap_angle(desired.heading_rad - truth.heading_rad).to_degrees());
    vec![
        Figure::over_time(
            "position-error",
            "Position error",
            "Distance from the desired position.",
            position,
            axis("distance in mm").from_zero(),
        ),
        Figure::over_time(
            "heading-error",
            "Heading error",
            "Desired minus real heading.",
            heading,
            axis("angle in deg"),
        ),
    ]
}

/// The actual twist, one panel per component.
pub(super) fn twist(comparison: &Comparison) -> Vec<Figure> {
    COMPONENTS
        .into_iter()
        .map(|(id, title, y_title, component)| {
            Figure::over_time(
                format!("twist-{id}"),
                title,
                "",
                each_run(comparison, move |run| {
                    let records = run.trace.records().iter();
                    records
                        .map(|r| (r.t_s, component(&r.truth.twist_in_body)))
                        .collect()
                }),
                axis(y_title),
            )
            .height_px(270)
            .spanning(Span::Panel)
        })
        .collect()
}

/// The ledger's terms of each run, in millimetres.
pub(super) fn ledger_position(comparison: &Comparison) -> Figure {
    ledger(
        comparison,
        "ledger-position",
        "Error budget: position",
        "The path length of each term: motion forth and back both count, so that no term hides because it happens to cancel.",
        "mm",
        |term| 1e3 * term.path_m,
    )
}

/// The ledger's terms of each run, in degrees.
pub(super) fn ledger_heading(comparison: &Comparison) -> Figure {
    ledger(
        comparison,
        "ledger-heading",
        "Error budget: heading",
        "The same for the heading.",
        "deg",
        |term| term.turned_rad.to_degrees(),
    )
}

fn ledger(
    comparison: &Comparison,
    id: &str,
    title: &str,
    caption: &str,
    unit: &str,
    of: fn(&Integral) -> f64,
) -> Figure {
    let runs = || comparison.runs.iter().map(|run| &run.summary.ledger);
    let is_shown = |term: &usize| runs().any(|run| run.shown().any(|(place, ..)| place == *term));
    let terms = (0..TERMS).filter(is_shown).map(|term| {
        let values = runs().map(|run| Some(of(&run.terms()[term])));
        bars(NAMES[term], &values.collect::<Vec<_>>(), TERM_COLORS[term])
    });
    let bars = terms.collect();
    bars_of_runs(id, title, caption, axis(unit), comparison, false, bars)
}

/// The energy balance of each run.
pub(super) fn energy(comparison: &Comparison) -> Figure {
    const WENT: [(&str, &str); 6] = [
        ("energy.slip_j", "@slip"),
        ("energy.spin_up_j", "@w1"),
        ("energy.bearing_j", "@servo"),
        ("energy.impact_j", "@w3"),
        ("energy.stored_j", "@contact"),
        ("energy.unexplained_j", "@asked"),
    ];
    let quantities = WENT
        .iter()
        .filter_map(|(key, color)| Some((by_key(key)?, *color)));
    let traces = quantities.map(|(quantity, color)| {
        let runs = comparison.runs.iter();
        let values: Vec<_> = runs.map(|run| quantity.shown(&run.summary)).collect();
        bars(quantity.label, &values, color)
    });
    let traces = traces.collect();
    bars_of_runs(
        "energy",
        "Where the motors' work went",
        "Lost to sliding, to spinning up rollers, in bearings and impacts, or stored as motion. What is unexplained is the \
         solver's own loss or gain.",
        axis("J").least_span(0.01),
        comparison,
        false,
        traces,
    )
}

/// The drift of dead reckoning.
pub(super) fn odometry(comparison: &Comparison) -> Figure {
    type Way = fn(&Summary) -> Option<f64>;
    let ways: [(&str, &str, Way); 2] = [
        ("by the ideal kinematics", "@ideal", |s| {
            s.odometry_ideal.m_per_m
        }),
        ("by the contact kinematics", "@contact", |s| {
            s.odometry_contact.m_per_m
        }),
    ];
    let traces = ways.into_iter().map(|(name, color, of)| {
        let values = comparison
            .runs
            .iter()
            .map(|run| of(&run.summary).map(|m| 1e3 * m));
        bars(name, &values.collect::<Vec<_>>(), color)
    });
    let traces = traces.collect();
    bars_of_runs(
        "odometry",
        "Drift of dead reckoning",
        "Distance from the truth at the end, per metre travelled. What the contact kinematics saves is geometry, which a \
         robot can correct for; what it leaves is slip, which the wheels cannot see.",
        axis("mm per m").least_span(0.1),
        comparison,
        true,
        traces,
    )
}

/// Rms sliding speed over the wheels, over time.
pub(super) fn slip_speed(comparison: &Comparison) -> Figure {
    Figure::over_time(
        "slip-speed",
        "Sliding speed",
        "How fast the touching rollers slide over the floor: rms over the wheels.",
        over_wheels(comparison, |wheels| {
            let speeds = wheels
                .iter()
                .filter(|w| w.touched())
                .map(|w| w.slip_speed_rms_m_s);
            ilon_trace::slip::rms(speeds).map(|v| 1e3 * v)
        }),
        axis("sliding speed in mm/s").from_zero(),
    )
}

/// Energy lost to slip at each wheel.
pub(super) fn slip_of_wheels(comparison: &Comparison) -> Figure {
    let names: Vec<&str> = comparison
        .runs
        .iter()
        .flat_map(|run| &run.summary.wheels)
        .map(|w| w.name.as_str())
        .collect();
    let mut wheels: Vec<String> = Vec::new();
    for name in names {
        if !wheels.iter().any(|known| known == name) {
            wheels.push(name.to_owned());
        }
    }
    let traces = comparison.runs.iter().enumerate().map(|(index, run)| {
        let of = |name: &String| {
            let wheel = run.summary.wheels.iter().find(|w| w.name == *name);
            wheel.and_then(|w| w.speed_rms_m_s).map(|v| 1e3 * v)
        };
        bars(
            &run.name,
            &wheels.iter().map(of).collect::<Vec<_>>(),
            run_pen(index).color,
        )
    });
    let traces: Vec<Curve> = traces.collect();
    let height_px = 110 + wheels.len() as u32 * (24 + 11 * traces.len().min(12) as u32);
    let x = axis("rms sliding speed in mm/s").least_span(1.0);
    let layout = Layout::of(x, axis("").names(wheels)).grouped();
    Figure {
        largest: traces.iter().map(Curve::largest).fold(0.0, f64::max),
        ..Figure::new(
            "slip-of-wheels",
            "Slip, wheel by wheel",
            "Rms sliding speed over the run.",
            plot(traces, layout),
        )
        .height_px(height_px)
    }
}

/// The largest used share of the friction cone over all wheels.
pub(super) fn grip(comparison: &Comparison) -> Figure {
    Figure::over_time(
        "grip",
        "How much grip is in use",
        "Tangential force over the friction limit µN, of the wheel that uses most. At 1 it slides.",
        over_wheels(comparison, |wheels| {
            wheels
                .iter()
                .filter_map(WheelSample::friction_used)
                .reduce(f64::max)
        }),
        axis("share of µN").from_zero(),
    )
}

/// The largest torque over all wheels.
pub(super) fn torque(comparison: &Comparison) -> Figure {
    Figure::over_time(
        "torque",
        "Wheel torque",
        "What the motor that works hardest gives, as a magnitude.",
        over_wheels(comparison, |wheels| {
            wheels
                .iter()
                .map(WheelSample::torque_peak_n_m)
                .reduce(f64::max)
        }),
        axis("torque in N m").from_zero(),
    )
}

/// The figures that show more than rounding: a value of at least a thousandth of the axis' unit.
pub(super) fn above_noise(figures: impl IntoIterator<Item = Figure>) -> Vec<Figure> {
    let is_seen = |figure: &Figure| figure.largest >= 1e-3;
    figures.into_iter().filter(is_seen).collect()
}

/// One curve per run.
fn each_run(
    comparison: &Comparison,
    points: impl Fn(&ComparedRun) -> Vec<(f64, f64)>,
) -> Vec<Curve> {
    let runs = comparison.runs.iter().enumerate();
    runs.map(|(index, run)| curve(&run.name, points(run).into_iter(), run_pen(index)))
        .collect()
}

/// One curve per run, of a quantity over its wheels; instants without a value are left out.
fn over_wheels(comparison: &Comparison, of: fn(&[WheelSample]) -> Option<f64>) -> Vec<Curve> {
    each_run(comparison, |run| {
        let point = |(record, wheels): (&Record, &[WheelSample])| Some((record.t_s, of(wheels)?));
        run.trace.steps().filter_map(point).collect()
    })
}

/// Horizontal bars, one row per run, stacked by sign unless grouped; the first run on top.
fn bars_of_runs(
    id: &str,
    title: &str,
    caption: &str,
    x: Axis,
    comparison: &Comparison,
    grouped: bool,
    curves: Vec<Curve>,
) -> Figure {
    let names: Vec<String> = comparison.runs.iter().map(|run| run.name.clone()).collect();
    let count = names.len().min(12) as u32;
    let layout = Layout::of(x, axis("").names(names));
    let largest = curves.iter().map(Curve::largest).fold(0.0, f64::max);
    let plot = plot(curves, if grouped { layout.grouped() } else { layout });
    Figure {
        largest,
        ..Figure::new(id, title, caption, plot).height_px(110 + 46 * count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::ComparedRun;
    use crate::sample::made_up_run;
    use ilon_trace::{Settings, Summary, Trace};

    fn run(name: &str, open_loop: bool) -> ComparedRun {
        let mut trace = made_up_run(2.0, open_loop);
        trace.header.scenario_name = name.to_owned();
        let summary = Summary::of(&trace, &Settings::default());
        ComparedRun {
            name: name.to_owned(),
            trace,
            summary,
        }
    }

    #[test]
    fn a_reference_that_runs_share_is_drawn_once_and_none_where_there_is_none() {
        let drawn = |runs: Vec<ComparedRun>| {
            references(&Comparison::of(runs, &[]).expect("two runs")).len()
        };
        assert_eq!(drawn(vec![run("a", false), run("b", false)]), 1);
        assert_eq!(drawn(vec![run("a", false), run("b", true)]), 1);
        assert_eq!(drawn(vec![run("a", true), run("b", true)]), 0);
        // Apart from the start on, and from the middle of the run on.
        for from_s in [0.0, 1.0] {
            let mut moved = run("b", false);
            let mut trace = Trace::with_capacity(moved.trace.header.clone(), 0);
            for (record, wheels) in moved.trace.steps() {
                let mut record = *record;
                if let Some(desired) = &mut record.desired
                    && record.t_s >= from_s
                {
                    desired.pose.x_m += 0.01;
                }
                trace.push(record, wheels);
            }
            moved.trace = trace;
            assert_eq!(drawn(vec![run("a", false), moved]), 2);
        }
    }

    #[test]
    fn every_wheel_has_a_bar_of_its_own_speed() {
        let comparison = Comparison::of(vec![run("a", false), run("b", true)], &[]).expect("two");
        let plot = slip_of_wheels(&comparison).plot;
        let plot: serde_json::Value = serde_json::from_str(&plot).expect("JSON");
        for (run, curve) in comparison
            .runs
            .iter()
            .zip(plot["curves"].as_array().expect("bars"))
        {
            for (wheel, bar) in run
                .summary
                .wheels
                .iter()
                .zip(curve["x"].as_array().expect("few"))
            {
                let expected = 1e3 * wheel.speed_rms_m_s.expect("it touches");
                let bar = bar.as_f64().expect("a number");
                // Numbers are written with six digits.
                assert!((bar / expected - 1.0).abs() < 1e-4, "{bar} {expected}");
            }
        }
    }

    /// Bars keep their height up to twelve runs; more become thinner.
    #[test]
    fn bars_have_room_for_each_of_twelve_runs() {
        let height_px = |count: usize| {
            let runs = (0..count).map(|k| run(&format!("run {k}"), true));
            energy(&Comparison::of(runs.collect(), &[]).expect("runs")).height_px
        };
        assert_eq!(height_px(5) - height_px(3), 2 * 46);
        assert_eq!(height_px(14), height_px(12));
    }
}
