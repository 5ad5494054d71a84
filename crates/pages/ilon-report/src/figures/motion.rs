//! Figures of the robot's motion: path, tracking errors, twist, dead reckoning.

use ilon_robot::{Pose, Twist};
use ilon_trace::{Record, Settings};

use crate::accumulate::{OfRobot, TwistOf};
use crate::decimate::{MAX_POINTS, evenly};
use crate::figure::{
    Curve, Figure, Layout, Pen, Span, axis, curve, dashed, dots, dotted, exact_curve, map_layout,
    plot, solid,
};
use crate::input::RunInput;
use crate::story::Budget;

/// The path on the floor, compared with the reference.
pub(crate) fn path(shown: &RunInput) -> Figure {
    let trace = &*shown.trace;
    let records = trace.records();
    let desired = || records.iter().filter_map(|r| r.desired).map(|d| d.pose);
    let mut curves: Vec<Curve> = Vec::new();
    if desired().next().is_some() {
        let reference: Vec<_> = desired().collect();
        curves.push(way("reference", &reference, dashed("@asked").width(2.2)));
    }
    let point = |pose: Pose| trace.header.reference_point_at(pose);
    let truth: Vec<_> = records.iter().map(|r| point(r.truth.pose)).collect();
    curves.push(way("driven", &truth, solid("@real").width(2.4)));
    let measured: Vec<_> = records
        .iter()
        .filter_map(|r| r.measured)
        .map(point)
        .collect();
    if !measured.is_empty() {
        curves.push(way(
            "measured, by the log",
            &measured,
            dashed("@ideal").width(2.2),
        ));
    }
    if shown.all.sees_otherwise {
        let seen: Vec<_> = records.iter().map(|r| point(r.seen_pose)).collect();
        curves.push(way("as the robot saw it", &seen, dotted("@contact")));
    }
    let arrows = heading_arrows(&truth);
    curves
        .push(exact_curve("heading", arrows.into_iter(), solid("@real").width(1.4)).opacity(0.75));
    if let Some(start) = truth.first() {
        let here = std::iter::once((start.x_m, start.y_m));
        curves.push(dots("start", here, "@slip", 11).opacity(1.0));
    }
    let caption = "Seen from above. Arrows point along the robot's x axis: where they turn along a straight path, \
                   the robot turns while it travels. The dot is the initial pose.";
    Figure::new(
        "path",
        "The path over the floor",
        caption,
        plot(curves, map_layout()),
    )
    .height_px(440)
}

/// Position and heading error over time; none without a reference.
pub(crate) fn errors(shown: &RunInput, settings: &Settings) -> Vec<Figure> {
    if shown.all.robot(OfRobot::PositionError).next().is_none() {
        return Vec::new();
    }
    let drawn = |real: OfRobot, seen: OfRobot, name: &str| {
        let mut curves: Vec<Curve> = Vec::new();
        if shown.all.sees_otherwise {
            let pen = solid("@contact").width(1.0);
            curves.push(curve("as the robot saw it", shown.all.robot(seen), pen));
        }
        curves.push(curve(name, shown.all.robot(real), solid("@real")));
        curves
    };
    let position_threshold_m = settings.position_threshold_m;
    let heading_threshold_deg = settings.heading_threshold_rad.to_degrees();
    let mut position_curves = drawn(
        OfRobot::PositionError,
        OfRobot::SeenPositionError,
        "position error",
    );
    position_curves.push(level(
        shown,
        "threshold",
        position_threshold_m,
        dotted("@limit"),
    ));
    let mut heading_curves = drawn(
        OfRobot::HeadingError,
        OfRobot::SeenHeadingError,
        "heading error",
    );
    heading_curves.extend([
        level(shown, "threshold", heading_threshold_deg, dotted("@limit")),
        level(shown, "threshold", -heading_threshold_deg, dotted("@limit")).unlisted(),
    ]);
    vec![
        Figure::over_time(
            "position-error",
            "Position error",
            format!(
                "Distance from the desired position. It counts as converged from the last time on that it falls below \
                 {} cm.",
                100.0 * position_threshold_m
            ),
            position_curves,
            axis("distance in m").from_zero().least_span(1e-3),
        )
        .height_px(300),
        Figure::over_time(
            "heading-error",
            "Heading error",
            format!(
                "Desired minus real heading. Under prioritised saturation the task of lower priority waits: its error \
                 falls only once the other has what it needs. Converged within {heading_threshold_deg:.0}°."
            ),
            heading_curves,
            axis("angle in deg").least_span(0.05),
        )
        .height_px(300),
    ]
}

/// Distance of the simulated robot from a measured log; empty without such a log.
pub(crate) fn against_the_log(shown: &RunInput) -> Vec<Figure> {
    if shown.all.robot(OfRobot::MeasuredDistance).next().is_none() {
        return Vec::new();
    }
    let distance = shown.all.robot(OfRobot::MeasuredDistance);
    let distance = distance.map(|(t_s, m)| (t_s, 1e3 * m));
    let turn = shown.all.robot(OfRobot::MeasuredTurn);
    vec![
        Figure::over_time(
            "measured-distance",
            "Distance from the measured place",
            "How far the simulated robot is from where the log says that the real one was at the same time.",
            vec![curve(
                "simulated from measured",
                distance,
                solid("@ideal"),
            )],
            axis("distance in mm").from_zero().least_span(1.0),
        )
        .height_px(300),
        Figure::over_time(
            "measured-turn",
            "Angle from the measured heading",
            "Simulated minus measured heading.",
            vec![curve("simulated from measured", turn, solid("@ideal"))],
            axis("angle in deg").least_span(0.1),
        )
        .height_px(300),
    ]
}

/// The position error and the events around the worst instant.
pub(crate) fn error_around(shown: &RunInput, budget: &Budget) -> Figure {
    let around_s = (budget.at_s - budget.from_s).max(0.2);
    let (from_s, to_s) = (budget.from_s - 0.5 * around_s, budget.at_s + 0.7 * around_s);
    let near = shown
        .all
        .robot(OfRobot::PositionError)
        .filter(|(t_s, _)| (from_s..=to_s).contains(t_s))
        .map(|(t_s, m)| (t_s, 1e3 * m));
    let counted = [(budget.from_s, 0.0), (budget.at_s, 0.0)].into_iter();
    let worst = std::iter::once((budget.at_s, 1e3 * budget.error_m));
    let curves = vec![
        exact_curve("position error", near, solid("@real").width(2.2)),
        exact_curve("counted", counted, solid("@limit").width(4.0)),
        dots("worst", worst, "@limit", 10).opacity(1.0),
    ];
    Figure::new(
        "budget-error",
        "The position error around it",
        "The budget counts from where the error was last a tenth of its peak, or least.",
        plot(
            curves,
            Layout::of(axis("t in s"), axis("position error in mm").from_zero()),
        ),
    )
    .height_px(300)
}

/// A component of a twist.
pub(crate) type Component = fn(&Twist) -> f64;

/// The components of a twist: the figure's id, title and axis, and the component in the axis's
/// unit.
pub(crate) const COMPONENTS: [(&str, &str, &str, Component); 3] = [
    ("vx", "Velocity ahead", "ahead in m/s", |v| v.vx_m_s),
    ("vy", "Velocity to the left", "to the left in m/s", |v| {
        v.vy_m_s
    }),
    ("omega", "Yaw rate", "yaw rate in deg/s", |v| {
        v.omega_rad_s.to_degrees()
    }),
];

/// The three components of the twist: commanded, ideal, by the contacts, actual.
pub(crate) fn twist(shown: &RunInput) -> Vec<Figure> {
    COMPONENTS
        .into_iter()
        .enumerate()
        .map(|(index, (id, title, y_title, component))| {
            let of = |twist: TwistOf| {
                let points = shown.all.robot(OfRobot::Twist(twist, index));
                points.map(move |(t_s, value)| {
                    let mut components = [0.0; 3];
                    components[index] = value;
                    let [vx_m_s, vy_m_s, omega_rad_s] = components;
                    (t_s, component(&Twist::new(vx_m_s, vy_m_s, omega_rad_s)))
                })
            };
            Figure::over_time(
                format!("twist-{id}"),
                title,
                "",
                vec![
                    curve("real", of(TwistOf::Real), solid("@real").width(2.6)),
                    curve("asked", of(TwistOf::Asked), dotted("@asked")),
                    curve("ideal", of(TwistOf::Ideal), dashed("@ideal")),
                    curve(
                        "contact",
                        of(TwistOf::Contact),
                        solid("@contact").width(1.2),
                    ),
                ],
                axis(y_title).least_span(0.02),
            )
            .height_px(270)
            .spanning(Span::Panel)
        })
        .collect()
}

/// The pose by dead reckoning, and its error.
pub(crate) fn odometry(shown: &RunInput) -> Vec<Figure> {
    let poses = |pose: fn(&Record) -> Pose| -> Vec<Pose> {
        shown.trace.records().iter().map(pose).collect()
    };
    let away = |drift: OfRobot| {
        let points = shown.all.robot(drift);
        points.map(|(t_s, off_m)| (t_s, 1e3 * off_m))
    };
    let map = plot(
        vec![
            way("truth", &poses(|r| r.truth.pose), solid("@real").width(2.6)),
            way(
                "by the ideal kinematics",
                &poses(|r| r.odometry_ideal),
                dashed("@ideal"),
            ),
            way(
                "by the contacts",
                &poses(|r| r.odometry_contact),
                dotted("@contact"),
            ),
        ],
        map_layout(),
    );
    let drift = vec![
        curve(
            "by the ideal kinematics",
            away(OfRobot::IdealDrift),
            dashed("@ideal"),
        ),
        curve(
            "by the contacts",
            away(OfRobot::ContactDrift),
            solid("@contact"),
        ),
    ];
    vec![
        Figure::new(
            "odometry",
            "Dead reckoning",
            "The path by the wheel rates alone, by the ideal kinematics (7) and by the kinematics of \
             what really touches the floor.",
            map,
        )
        .height_px(400),
        Figure::over_time(
            "odometry-drift",
            "Drift",
            "How far dead reckoning is from the truth. What the contact kinematics saves is geometry, which \
             a robot can correct for; what it leaves is slip, which the wheels cannot see.",
            drift,
            axis("distance from the truth in mm").from_zero().least_span(0.5),
        )
        .height_px(400),
    ]
}

/// A path on the floor, evenly thinned, because a map has no extremes to preserve.
pub(crate) fn way(name: &str, poses: &[Pose], pen: Pen) -> Curve {
    let kept = evenly(poses.len(), MAX_POINTS).into_iter();
    exact_curve(name, kept.map(|k| (poses[k].x_m, poses[k].y_m)), pen)
}

/// A horizontal line over the run.
pub(super) fn level(shown: &RunInput, name: &str, y: f64, pen: Pen) -> Curve {
    exact_curve(name, shown.all.ends_s().map(|t_s| (t_s, y)), pen)
}

/// Returns arrows along the robot's x axis at about twenty poses, as one line with gaps.
fn heading_arrows(poses: &[Pose]) -> Vec<(f64, f64)> {
    const ARROWS: usize = 20;
    let extent = |f: fn(&Pose) -> f64| {
        ilon_trace::slip::peak_to_peak(poses.iter().map(f)).unwrap_or_default()
    };
    let size_m = extent(|p| p.x_m).max(extent(|p| p.y_m)).max(0.2);
    let length_m = 0.06 * size_m;
    let mut line = Vec::with_capacity(6 * ARROWS);
    for k in evenly(poses.len(), ARROWS) {
        let p = poses[k];
        // A point `back_m` behind the tip of the arrow and `left_m` to the left of its shaft.
        let at = |back_m: f64, left_m: f64| {
            let (s, c) = p.heading_rad.sin_cos();
            let ahead_m = length_m - back_m;
            (
                p.x_m + c * ahead_m - s * left_m,
                p.y_m + s * ahead_m + c * left_m,
            )
        };
        let barb_m = 0.3 * length_m;
        line.extend([
            (p.x_m, p.y_m),
            at(0.0, 0.0),
            at(barb_m, 0.6 * barb_m),
            at(0.0, 0.0),
            at(barb_m, -0.6 * barb_m),
            (f64::NAN, f64::NAN),
        ]);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a path of 1 m arrows are 6 cm long; their barbs end 3/10 of that behind the tip, on
    /// either side of the shaft.
    #[test]
    fn arrows_point_where_the_robot_looks() {
        let poses = [
            Pose::default(),
            Pose {
                x_m: 1.0,
                y_m: 0.0,
                heading_rad: std::f64::consts::FRAC_PI_2,
            },
        ];
        let line = heading_arrows(&poses);
        let near = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1) < 1e-12;
        // Foot, tip, left barb, tip, right barb, gap.
        assert!(near(line[0], (0.0, 0.0)) && near(line[1], (0.06, 0.0)));
        assert!(near(line[2], (0.042, 0.0108)) && near(line[4], (0.042, -0.0108)));
        assert!(near(line[3], line[1]) && line[5].0.is_nan());
        // Facing along y: left is -x.
        assert!(near(line[6], (1.0, 0.0)) && near(line[7], (1.0, 0.06)));
        assert!(near(line[8], (0.9892, 0.042)) && near(line[10], (1.0108, 0.042)));
    }

    #[test]
    fn the_dot_is_where_the_run_began() {
        let trace = crate::sample::made_up_run(2.0, false);
        let Ok(shown) = RunInput::of(&trace);
        let plot: serde_json::Value = serde_json::from_str(&path(&shown).plot).expect("JSON");
        let curves = plot["curves"].as_array().expect("curves");
        let start = curves.iter().find(|curve| curve["name"] == "start");
        let at = ["x", "y"].map(|axis| start.expect("a start")[axis][0].as_f64());
        let pose = trace.records()[0].truth.pose;
        assert_eq!(at, [Some(pose.x_m), Some(pose.y_m)]);
        let end = trace.records().last().expect("rows").truth.pose;
        assert!((end.position_m() - pose.position_m()).norm() > 0.1);
    }
}
