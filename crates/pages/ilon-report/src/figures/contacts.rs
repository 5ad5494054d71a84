//! Figures of the contacts between rollers and floor.

use std::f64::consts::TAU;

use ilon_trace::{Record, Trace, WheelSample};

use crate::accumulate::{OfWheel, SECTORS};
use crate::decimate::evenly;
use crate::figure::{
    Curve, Figure, Layout, axis, curve, dots, dotted, exact_curve, layout, map_layout, plot,
    wheel_pen,
};
use crate::input::RunInput;
use crate::text::{by_kind, round_up};

/// Sliding speed of each wheel's contact over time.
pub(crate) fn slip_speed(shown: &RunInput) -> Figure {
    Figure::over_time(
        "slip-speed",
        "Sliding speed",
        by_kind(
            &shown.trace.header,
            "How fast the tyre slides over the floor. Low speeds are creep, which every push and every curve needs; a plateau is a wheel \
             that really slides.",
            "How fast the touching roller slides over the floor. A comb at the roller passing rate is the load going from roller to \
             roller; a plateau is a wheel that really slides.",
        ),
        each_wheel(shown, OfWheel::SlipSpeed, |v| 1e3 * v),
        axis("sliding speed in mm/s").from_zero().least_span(2.0),
    )
}

/// Normal force of each wheel over time.
pub(crate) fn normal_force(shown: &RunInput) -> Figure {
    Figure::over_time(
        "normal-force",
        "Load on each wheel",
        "The normal force. It shifts with acceleration and payload; where it falls to zero the wheel has \
         lost the floor.",
        each_wheel(shown, OfWheel::NormalForce, |v| v),
        axis("normal force in N").from_zero().least_span(1.0),
    )
}

/// Tangential force of each wheel over time.
pub(crate) fn tangential_force(shown: &RunInput) -> Figure {
    Figure::over_time(
        "tangential-force",
        "Push of each wheel",
        by_kind(
            &shown.trace.header,
            "The tangential force of the floor, its magnitude. At steady speed it is what bearings take; wheels that push against each \
             other show here.",
            "The tangential force of the floor, its magnitude. At steady speed it is what bearings and the rollers' ripple take; wheels \
             that push against each other show here.",
        ),
        each_wheel(shown, OfWheel::TangentialForce, |v| v),
        axis("tangential force in N").from_zero().least_span(0.1),
    )
}

/// Used share of the friction cone of each wheel over time.
pub(crate) fn grip_used(shown: &RunInput) -> Figure {
    Figure::over_time(
        "grip-used",
        "Grip in use over time",
        "Tangential force over the friction limit µN. At 1 the wheel slides; no value where it does not touch.",
        each_wheel(shown, OfWheel::GripUsed, |v| v),
        axis("share of µN").from_zero().least_span(0.1),
    )
}

/// Energy lost to slip at each wheel over time.
pub(crate) fn slip_energy(shown: &RunInput) -> Figure {
    Figure::over_time(
        "slip-energy",
        "Energy lost to slip",
        "What sliding has turned into heat so far. Steps are single events, a slope is steady sliding.",
        each_wheel(shown, OfWheel::SlipEnergy, |v| v),
        axis("energy in J").from_zero().least_span(0.01),
    )
}

/// Residual of Indiveri 2009, eq. (5), of each wheel over time.
pub(crate) fn residual(shown: &RunInput) -> Figure {
    Figure::over_time(
        "residual",
        "Residual of equation (5)",
        by_kind(
            &shown.trace.header,
            "How far each wheel is from rolling perfectly at the middle of its tyre.",
            "How far each wheel is from rolling perfectly on a roller that points straight down. Its swing at the roller passing rate is \
             geometry; what is left beside it is slip.",
        ),
        each_wheel(shown, OfWheel::Residual, |v| 1e3 * v),
        axis("residual in mm/s").least_span(1.0),
    )
}

/// Rms sliding speed around each wheel's turn.
pub(crate) fn polar(shown: &RunInput) -> Figure {
    let header = &shown.trace.header;
    let around: Vec<[f64; SECTORS]> = (0..header.wheels.len())
        .map(|index| {
            shown
                .all
                .slip_around(index)
                .map(|square| 1e3 * square.sqrt())
        })
        .collect();
    let largest_mm_s = around.iter().flatten().copied().fold(0.0, f64::max);
    let ring_mm_s = round_up(largest_mm_s);
    let at = |turn: f64, r: f64| {
        let (s, c) = (TAU * turn).sin_cos();
        (r * c, r * s)
    };
    let mut curves: Vec<Curve> = [0.5, 1.0]
        .into_iter()
        .map(|part| {
            let r = part * ring_mm_s;
            let rim = (0..=90).map(|k| at(f64::from(k) / 90.0, r));
            // The label is on the right of the rim.
            let mut labels = vec![String::new(); 91];
            labels[11] = format!("{r} mm/s");
            exact_curve("", rim, dotted("@rule"))
                .labels(labels, false)
                .unlisted()
        })
        .collect();
    curves.extend(
        header
            .wheels
            .iter()
            .zip(&around)
            .enumerate()
            .map(|(index, (wheel, mm_s))| {
                let sectors = (0..=SECTORS).map(|k| k % SECTORS);
                let points = sectors.map(|k| at((k as f64 + 0.5) / SECTORS as f64, mm_s[k]));
                exact_curve(&wheel.name, points, wheel_pen(index))
            }),
    );
    Figure::new(
        "slip-polar",
        "Slip around the wheel",
        by_kind(
            header,
            "Rms sliding speed against the wheel's angle. One lobe: a wheel out of round. A circle: plain sliding.",
            "Rms sliding speed against the wheel's angle. As many lobes as rollers: slip comes from the hand-over. One lobe: a wheel out of \
             round or a single bad roller. A circle: plain sliding.",
        ),
        plot(curves, layout("", "").equal().bare()),
    )
    .height_px(400)
}

/// Tangential force over the friction limit: inside the circle the contact sticks.
pub(crate) fn friction_cone(trace: &Trace) -> Figure {
    const POINTS_A_WHEEL: usize = 700;
    let rim = (0..=90).map(|k| {
        let (s, c) = (TAU * f64::from(k) / 90.0).sin_cos();
        (c, s)
    });
    let mut traces: Vec<Curve> = vec![exact_curve(
        "friction limit",
        rim,
        dotted("@limit").width(2.0),
    )];
    for index in 0..trace.wheel_count() {
        let samples: Vec<_> = trace.wheel(index).filter_map(in_cone).collect();
        let kept = evenly(samples.len(), POINTS_A_WHEEL)
            .into_iter()
            .map(|k| samples[k]);
        let name = &trace.header.wheels[index].name;
        traces.push(dots(name, kept, wheel_pen(index).color, 4));
    }
    Figure::new(
        "friction-cone",
        "How much grip is in use",
        "Tangential force over the friction limit µN, in the body frame. Points inside the circle grip, \
         points on it slide. Near the centre the drive has grip to spare.",
        plot(
            traces,
            Layout::of(axis("ahead, in µN"), axis("to the left, in µN")).equal(),
        ),
    )
    .height_px(400)
}

/// Positions and speeds of sliding contacts on the floor.
pub(crate) fn contact_map(trace: &Trace) -> Figure {
    const POINTS_A_WHEEL: usize = 900;
    // Classes a factor of 5 apart, in m/s, from the slowest to the fastest.
    let classes: [(&str, f64, &str, usize); 4] = [
        ("below 2 mm/s", 0.002, "@c0", 3),
        ("2 to 10 mm/s", 0.010, "@c1", 4),
        ("10 to 50 mm/s", 0.050, "@c2", 5),
        ("above 50 mm/s", f64::INFINITY, "@c3", 6),
    ];
    let mut points = vec![Vec::new(); classes.len()];
    for k in evenly(trace.records().len(), POINTS_A_WHEEL) {
        for sample in trace.wheels_at(k).iter().filter(|s| s.touching) {
            let speed_m_s = sample.slip_speed_m_s();
            let class = classes.iter().position(|c| speed_m_s < c.1);
            let class = class.unwrap_or(classes.len() - 1);
            points[class].push(contact_in_world_m(&trace.records()[k], sample));
        }
    }
    let traces = classes
        .iter()
        .zip(points)
        .filter(|(_, points)| !points.is_empty())
        .map(|((name, _, color, size), points)| dots(name, points.into_iter(), color, *size));
    Figure::new(
        "contact-map",
        "Slip over the floor",
        "Where each contact was and how fast it slid. Slip that stays at one place is the floor; slip that \
         follows the robot is the robot.",
        plot(traces.collect(), map_layout()),
    )
    .height_px(420)
}

/// Spin of the touching roller compared with rolling without sliding.
pub(crate) fn roller_spin(shown: &RunInput) -> Figure {
    Figure::over_time(
        "roller-spin",
        "Roller spin, real minus ideal",
        "Zero where the roller follows the floor. A new roller comes down at rest and must be spun up: the \
         spikes; their decay is the rollers' inertia and bearing friction against the floor's grip.",
        each_wheel(shown, OfWheel::SpinError, |v| v),
        axis("spin in rad/s").least_span(0.1),
    )
}

/// One curve per wheel.
fn each_wheel(shown: &RunInput, what: OfWheel, scale: fn(f64) -> f64) -> Vec<Curve> {
    let header = &shown.trace.header;
    let wheels = header.wheels.iter().enumerate().map(|(index, wheel)| {
        let points = shown.all.wheel(index, what);
        let points = points.map(|(t_s, value)| (t_s, scale(value)));
        curve(&wheel.name, points, wheel_pen(index))
    });
    wheels.collect()
}

/// Returns the tangential force over the friction limit; `None` without normal force.
fn in_cone(sample: &WheelSample) -> Option<(f64, f64)> {
    let limit_n = sample.friction * sample.normal_force_n;
    (sample.touching && limit_n > 0.0)
        .then(|| (sample.force_x_n / limit_n, sample.force_y_n / limit_n))
}

/// Returns the position of a contact on the floor, in metres.
fn contact_in_world_m(record: &Record, sample: &WheelSample) -> (f64, f64) {
    let pose = record.truth.pose;
    let (s, c) = pose.heading_rad.sin_cos();
    (
        pose.x_m + c * sample.contact_x_m - s * sample.contact_y_m,
        pose.y_m + s * sample.contact_x_m + c * sample.contact_y_m,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_trace::{Header, Record, Trace, WheelHeader, WheelSample};

    /// A contact 1 m ahead and 2 m to the left of a robot that looks along y.
    #[test]
    fn a_contact_turns_with_its_robot() {
        let mut record = Record::default();
        record.truth.pose = ilon_robot::Pose {
            x_m: 10.0,
            y_m: 20.0,
            heading_rad: std::f64::consts::FRAC_PI_2,
        };
        let sample = WheelSample {
            contact_x_m: 1.0,
            contact_y_m: 2.0,
            ..WheelSample::default()
        };
        let (x_m, y_m) = contact_in_world_m(&record, &sample);
        // The cosine of a right angle is a rounding away from 0.
        assert!((x_m - 8.0).abs() < 1e-12 && (y_m - 21.0).abs() < 1e-12);
    }

    /// A contact is in the class whose name contains its speed.
    #[test]
    fn contacts_are_sorted_by_their_speeds_into_classes() {
        let header = Header {
            wheels: vec![WheelHeader::default()],
            control_dt_s: 0.01,
            ..Header::default()
        };
        for (mm_s, name) in [
            (1.9, "below 2 mm/s"),
            (2.1, "2 to 10 mm/s"),
            (9.9, "2 to 10 mm/s"),
            (10.1, "10 to 50 mm/s"),
            (49.5, "10 to 50 mm/s"),
            (50.5, "above 50 mm/s"),
        ] {
            let mut trace = Trace::with_capacity(header.clone(), 1);
            let sample = WheelSample {
                touching: true,
                slip_x_m_s: -0.6e-3 * mm_s,
                slip_y_m_s: 0.8e-3 * mm_s,
                ..WheelSample::default()
            }
            .steady();
            trace.push(Record::default(), &[sample]);
            let plot: serde_json::Value =
                serde_json::from_str(&contact_map(&trace).plot).expect("JSON");
            let curves = plot["curves"].as_array().expect("curves");
            let names: Vec<_> = curves.iter().map(|curve| &curve["name"]).collect();
            assert_eq!(names, [name], "{mm_s}");
        }
    }
}
