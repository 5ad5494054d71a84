//! Figures of the wheels: rates, torques, and task shares.

use super::motion::level;
use crate::accumulate::{OfRobot, OfWheel};
use crate::figure::{Curve, Figure, Span, axis, curve, dashed, dotted, solid, wheel_pen};
use crate::input::RunInput;

/// One panel per wheel: commanded and actual rate, and the limit. All panels have the same scale.
pub(crate) fn rates(shown: &RunInput) -> Vec<Figure> {
    let trace = &*shown.trace;
    let header = &trace.header;
    let limits = || {
        let own = header.wheels.iter().filter_map(|w| w.rate_limit_rad_s);
        own.chain(header.wheel_rate_limit_rad_s)
    };
    let magnitude = |what| {
        let values = (0..trace.wheel_count()).flat_map(move |index| shown.all.wheel(index, what));
        values.map(|(_, value)| value.abs()).fold(0.0, f64::max)
    };
    let fastest = magnitude(OfWheel::Rate).max(magnitude(OfWheel::Target));
    // A limit far above the used range would flatten the curves.
    let shown_limit = limits().filter(|&l| l <= 2.0 * fastest).reduce(f64::max);
    let top = 1.08 * shown_limit.unwrap_or(0.0).max(fastest).max(1e-3);
    (0..trace.wheel_count())
        .map(|index| {
            let of = |what| shown.all.wheel(index, what);
            let mut curves: Vec<Curve> = vec![
                curve("real", of(OfWheel::Rate), solid("@real").width(2.2)),
                curve("commanded", of(OfWheel::Target), dashed("@asked")),
            ];
            let wheel = &header.wheels[index];
            let limit = header.wheel_rate_limit_rad_s.or(wheel.rate_limit_rad_s);
            if let Some(limit) = limit.filter(|&l| l <= top) {
                curves.push(level(shown, "limit", limit, dotted("@limit")));
                curves.push(level(shown, "limit", -limit, dotted("@limit")).unlisted());
            }
            Figure::over_time(
                format!("rate-{index}"),
                wheel.name.clone(),
                "",
                curves,
                axis("rad/s").range(-top, top),
            )
            .height_px(230)
            .spanning(Span::Panel)
        })
        .collect()
}

/// Torques of all wheels.
pub(crate) fn torques(shown: &RunInput) -> Figure {
    let header = &shown.trace.header;
    let curves = header.wheels.iter().enumerate().map(|(index, wheel)| {
        let torques = shown.all.wheel(index, OfWheel::Torque);
        curve(&wheel.name, torques, wheel_pen(index))
    });
    Figure::over_time(
        "torques",
        "Wheel torques",
        "What the motors gave at the wheels. Steady torque at steady speed is the price of bearings and \
         slip; wheels that work against each other show as torques of opposite sign in straight travel.",
        curves.collect(),
        axis("torque in N m").least_span(0.01),
    )
}

/// Share of the commanded accelerations that the torques give; `None` if always all.
pub(crate) fn torque_weights(shown: &RunInput) -> Option<Figure> {
    let position = || shown.all.robot(OfRobot::PositionTorqueWeight);
    let heading = || shown.all.robot(OfRobot::HeadingTorqueWeight);
    position().chain(heading()).any(|(_, w)| w < 1.0).then(|| {
        let curves: Vec<Curve> = vec![
            curve("position", position(), solid("@w0")),
            curve("heading", heading(), dashed("@w1")),
        ];
        Figure::over_time(
            "torque-weights",
            "Accelerations at the torque limit",
            "How much of the acceleration that each task asks for motors and grip can give. Below 1 the \
             torques are at their limit, and the task of lower priority is held back.",
            curves,
            axis("weight").range(-0.03, 1.05),
        )
        .height_px(300)
    })
}

/// Weights and capacities of the guidance law's tasks; empty without guidance.
pub(crate) fn tasks(shown: &RunInput) -> Vec<Figure> {
    let names = &shown.trace.header.task_names;
    if names.is_empty() {
        return Vec::new();
    }
    let tasks = || names.iter().enumerate().take(ilon_trace::MAX_TASKS);
    let each = |of: fn(usize) -> OfRobot| -> Vec<Curve> {
        let one = |(task, name): (usize, &String)| {
            let name = format!("{}. {name}", task + 1);
            curve(&name, shown.all.robot(of(task)), wheel_pen(task))
        };
        tasks().map(one).collect()
    };
    vec![
        Figure::over_time(
            "task-weights",
            "Weights of the tasks",
            "The weight of each task, highest priority first (Indiveri 2009, eq. (33)). At 1 the task has all \
             that it asks for; below, saturation holds it back; 0 also where it asks for nothing.",
            each(OfRobot::TaskWeight),
            axis("weight").range(-0.03, 1.05),
        )
        .height_px(300),
        Figure::over_time(
            "task-capacities",
            "Capacity for each task",
            "The capacity of each task: the wheel rate that those above it leave (eq. (34)).",
            each(OfRobot::TaskCapacity),
            axis("capacity in rad/s").from_zero(),
        )
        .height_px(300),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_trace::{Header, Record, Trace, WheelHeader, WheelSample};

    /// The first of two wheels reaches 10 of 12 rad/s without a command; the second stands.
    #[test]
    fn the_limit_of_both_ways_is_drawn_where_any_wheel_comes_near_it() {
        let header = Header {
            wheels: vec![WheelHeader::default(); 2],
            wheel_rate_limit_rad_s: Some(12.0),
            control_dt_s: 0.01,
            ..Header::default()
        };
        let limits_of = |rate_rad_s: f64| {
            let mut trace = Trace::with_capacity(header.clone(), 2);
            for row in 0..2 {
                let record = Record {
                    t_s: 0.01 * f64::from(row),
                    ..Record::default()
                };
                let turning = WheelSample {
                    rate_rad_s,
                    ..WheelSample::default()
                }
                .steady();
                trace.push(record, &[turning, WheelSample::default()]);
            }
            let Ok(shown) = RunInput::of(&trace);
            let limits = |figure: &Figure| -> Vec<f64> {
                let plot: serde_json::Value = serde_json::from_str(&figure.plot).expect("JSON");
                let curves = plot["curves"].as_array().expect("curves");
                let limits = curves.iter().filter(|curve| curve["name"] == "limit");
                limits.filter_map(|curve| curve["y"][0].as_f64()).collect()
            };
            rates(&shown).iter().map(limits).collect::<Vec<_>>()
        };
        assert_eq!(limits_of(-10.0), [[12.0, -12.0], [12.0, -12.0]]);
        // Far from it, it would flatten the curves.
        assert_eq!(limits_of(5.0), [[]; 2] as [[f64; 0]; 2]);
    }
}
