//! What the wheels did: rates, torques, and the tasks that shared them.

use ilon_trace::{Record, Trace};
use plotly::common::Mode;
use plotly::layout::{Axis, Layout, RangeMode};

use super::motion::level;
use crate::report::figure::{
    Figure, Span, axis, curve, dashed, dotted, layout, plot, solid, wheel_pen,
};

/// One panel a wheel: commanded and real rate, and the limit. All panels share their scale.
pub(in crate::report) fn rates(trace: &Trace) -> Vec<Figure> {
    let header = &trace.header;
    let limits = || {
        let own = header.wheels.iter().filter_map(|w| w.rate_limit_rad_s);
        own.chain(header.wheel_rate_limit_rad_s)
    };
    let fastest = (0..trace.wheel_count())
        .flat_map(|index| trace.wheel(index))
        .map(|s| s.rate_rad_s.abs().max(s.target_rad_s.abs()))
        .fold(0.0, f64::max);
    // A limit far above what the run used would flatten the curves.
    let shown_limit = limits().filter(|&l| l <= 2.0 * fastest).reduce(f64::max);
    let top = 1.08 * shown_limit.unwrap_or(0.0).max(fastest).max(1e-3);
    (0..trace.wheel_count())
        .map(|index| {
            let times = || trace.records().iter().map(|r| r.t_s);
            let of =
                |f: fn(&ilon_trace::WheelSample) -> f64| times().zip(trace.wheel(index).map(f));
            let mut curves: Vec<Box<dyn plotly::Trace>> = vec![
                curve("real", of(|s| s.rate_rad_s), solid("@real").width(2.2)),
                curve("commanded", of(|s| s.target_rad_s), dashed("@asked")),
            ];
            let wheel = &header.wheels[index];
            let limit = header.wheel_rate_limit_rad_s.or(wheel.rate_limit_rad_s);
            if let Some(limit) = limit.filter(|&l| l <= top) {
                curves.push(level(trace, "limit", limit, dotted("@limit")));
                curves.push(level(trace, "limit", -limit, dotted("@limit")).show_legend(false));
            }
            Figure {
                id: format!("rate-{index}"),
                title: wheel.name.clone(),
                caption: String::new(),
                height_px: 230,
                span: Span::Panel,
                over_time: true,
                plot: plot(
                    curves,
                    Layout::new()
                        .x_axis(axis("t in s"))
                        .y_axis(axis("rad/s").range(vec![-top, top])),
                ),
            }
        })
        .collect()
}

/// Torques of all wheels.
pub(in crate::report) fn torques(trace: &Trace) -> Figure {
    let curves = (0..trace.wheel_count()).map(|index| {
        let times = trace.records().iter().map(|r| r.t_s);
        let torques = times.zip(trace.wheel(index).map(|s| s.torque_n_m));
        curve(&trace.header.wheels[index].name, torques, wheel_pen(index)) as Box<dyn plotly::Trace>
    });
    Figure {
        id: "torques".to_owned(),
        title: "Wheel torques".to_owned(),
        caption: "What the motors gave at the wheels. Steady torque at steady speed is the price of bearings and \
                  slip; wheels that work against each other show as torques of opposite sign in straight travel."
            .to_owned(),
        height_px: 320,
        span: Span::Half,
        over_time: true,
        plot: plot(curves.collect(), layout("t in s", "torque in N m")),
    }
}

/// What the torques give of the accelerations asked for; `None` where they gave all, always.
pub(in crate::report) fn torque_weights(trace: &Trace) -> Option<Figure> {
    let weights = |of: fn(&Record) -> f64| trace.records().iter().map(move |r| (r.t_s, of(r)));
    let position = || weights(|r| r.torque_weight_position);
    let heading = || weights(|r| r.torque_weight_heading);
    position().chain(heading()).any(|(_, w)| w < 1.0).then(|| {
        let curves: Vec<Box<dyn plotly::Trace>> = vec![
            curve("position", position(), solid("@w0")),
            curve("heading", heading(), dashed("@w1")),
        ];
        Figure {
            id: "torque-weights".to_owned(),
            title: "Which acceleration gives way".to_owned(),
            caption: "How much of the acceleration that each task asks for motors and grip can give. Below 1 the \
                      torques are at their limit, and the task of lower priority is held back."
                .to_owned(),
            height_px: 300,
            span: Span::Half,
            over_time: true,
            plot: plot(
                curves,
                Layout::new()
                    .x_axis(axis("t in s"))
                    .y_axis(axis("weight").range(vec![-0.03, 1.05])),
            ),
        }
    })
}

/// Weights and capacities of the guidance law's tasks; empty without guidance.
pub(in crate::report) fn tasks(trace: &Trace) -> Vec<Figure> {
    let names = &trace.header.task_names;
    if names.is_empty() {
        return Vec::new();
    }
    let of = |task: usize, f: fn(&ilon_trace::TaskShare) -> f64| {
        trace
            .records()
            .iter()
            .map(move |r| (r.t_s, f(&r.tasks[task])))
    };
    let tasks = || names.iter().enumerate().take(ilon_trace::MAX_TASKS);
    let weights = tasks().map(|(task, name)| {
        let name = format!("{}. {name}", task + 1);
        curve(&name, of(task, |s| s.weight), wheel_pen(task)).mode(Mode::Lines)
            as Box<dyn plotly::Trace>
    });
    let capacities = tasks().map(|(task, name)| {
        let name = format!("{}. {name}", task + 1);
        curve(&name, of(task, |s| s.capacity_rad_s), wheel_pen(task)) as Box<dyn plotly::Trace>
    });
    vec![
        Figure {
            id: "task-weights".to_owned(),
            title: "Which task gives way".to_owned(),
            caption: "The weight of each task, highest priority first (Indiveri 2009, eq. (33)). At 1 the task has all \
                      that it asks for; below, saturation holds it back; 0 also where it asks for nothing."
                .to_owned(),
            height_px: 300,
            span: Span::Half,
            over_time: true,
            plot: plot(
                weights.collect(),
                Layout::new()
                    .x_axis(axis("t in s"))
                    .y_axis(axis("weight").range(vec![-0.03, 1.05])),
            ),
        },
        Figure {
            id: "task-capacities".to_owned(),
            title: "What is left for each task".to_owned(),
            caption: "The capacity of each task: the wheel rate that those above it leave (eq. (34)).".to_owned(),
            height_px: 300,
            span: Span::Half,
            over_time: true,
            plot: plot(
                capacities.collect(),
                Layout::new()
                    .x_axis(axis("t in s"))
                    .y_axis(Axis::new().title("capacity in rad/s").range_mode(RangeMode::ToZero)),
            ),
        },
    ]
}
