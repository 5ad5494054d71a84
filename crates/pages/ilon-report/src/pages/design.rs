//! The speeds that a robot's wheels allow, and those that the touching rollers leave of them.

use ilon_control::{ContactKinematics, Kinematics, SpeedLimits};
use ilon_robot::Twist;
use nalgebra::Vector2;

use crate::figure::{Figure, Layout, Span, axis, exact_curve, plot, wheel_pen};
use crate::page::{Section, panels, side_by_side};

/// Returns the mean speed in a direction of the body by the touching rollers, for the wheel rates
/// of (7) for 1 m/s, and its peak-to-peak ripple over its mean.
pub(super) fn along(
    direction_rad: f64,
    kinematics: &Kinematics,
    contact: &mut ContactKinematics,
) -> (f64, f64) {
    let n = kinematics.wheel_count();
    let (ahead, left) = (direction_rad.cos(), direction_rad.sin());
    let (mut rates, mut angles) = (vec![0.0; n], vec![0.0; n]);
    kinematics.wheel_rates(Twist::new(ahead, left, 0.0), &mut rates);
    let fastest = rates
        .iter()
        .fold(0.0_f64, |most, rate| most.max(rate.abs()));
    // Instants evenly spread over a hundred turns of the fastest wheel, no two at the same place of
    // a roller.
    const INSTANTS: usize = 1000;
    let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..INSTANTS {
        let turned_rad = 0.1 * std::f64::consts::TAU * k as f64 * (1.0 + 1.0 / 377.0);
        for (angle, rate) in angles.iter_mut().zip(&rates) {
            *angle = rate / fastest * turned_rad;
        }
        let twist = contact.twist(&angles, &rates);
        let speed = ahead * twist.vx_m_s + left * twist.vy_m_s;
        sum += speed;
        (least, most) = (speed.min(least), speed.max(most));
    }
    let mean = sum / INSTANTS as f64;
    (mean, (most - least) / mean)
}

/// Shares of the top yaw rate at which the set of velocities is drawn.
const YAW_SHARES: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// The velocities that a robot's wheels allow at some shares of its top yaw rate; its speeds and
/// yaw rates where tyres leave it one direction.
pub(super) fn reach_section(name: &str, limits: &SpeedLimits) -> Section {
    if limits.is_held() {
        return held_section(name, limits);
    }
    let names = YAW_SHARES.map(|share| format!("at {:.0} % of the top yaw rate", 100.0 * share));
    let legend: Vec<_> = names
        .iter()
        .enumerate()
        .map(|(index, name)| (name.as_str(), wheel_pen(index)))
        .collect();
    let figures = [reach_figure(name, limits)];
    Section {
        id: "reach",
        title: "What the wheels allow",
        lead: "The twists within the wheels' rates are a polytope; each outline is a cut through it at one yaw rate. What a \
               robot can do in a direction is the way from the middle to the outline."
            .to_owned(),
        body: side_by_side(&panels("Velocity in the body frame", "", &legend, &figures)),
    }
}

/// The section of robots whose tyres leave one direction.
fn held_section(name: &str, limits: &SpeedLimits) -> Section {
    let figures = [held_figure(name, limits)];
    Section {
        id: "reach",
        title: "What the wheels allow",
        lead: "Unsteered tyres leave the speed ahead and the yaw rate. The outline holds what the wheels' rates allow of both."
            .to_owned(),
        body: side_by_side(&panels("Speed and yaw rate", "", &[], &figures)),
    }
}

/// The outline of the speeds along the tyres' way and of the yaw rates.
fn held_figure(name: &str, limits: &SpeedLimits) -> Figure {
    /// Yaw rates on each half of the outline.
    const STEPS: i32 = 40;
    let top_rad_s = limits.top_yaw_rate_rad_s();
    let ends = limits.at_yaw_rate(0.0);
    let way = match ends[..] {
        [a, b] => (b - a).normalize() * (b - a).x.signum(),
        _ => Vector2::zeros(),
    };
    let at = |k: i32| {
        let omega_rad_s = top_rad_s * f64::from(k) / f64::from(STEPS);
        let ends = limits.at_yaw_rate(omega_rad_s);
        let speeds: Vec<f64> = ends.iter().map(|v| v.dot(&way)).collect();
        (speeds, omega_rad_s.to_degrees())
    };
    let rows: Vec<_> = (-STEPS..=STEPS).map(at).collect();
    let side = |pick: fn(f64, f64) -> f64| {
        let ends = rows.iter().filter_map(move |(speeds, yaw_deg_s)| {
            Some((speeds.iter().copied().reduce(pick)?, *yaw_deg_s))
        });
        ends.collect::<Vec<_>>()
    };
    let (fast, slow) = (side(f64::max), side(f64::min));
    let around = fast.iter().chain(slow.iter().rev()).chain(fast.first());
    let (_, fastest_m_s) = limits.top_speed_range_m_s();
    Figure::new(
        "reach",
        format!(
            "{}: {fastest_m_s:.3} m/s, {:.1} deg/s",
            name,
            top_rad_s.to_degrees()
        ),
        "",
        plot(
            vec![exact_curve(name, around.copied(), wheel_pen(0)).unlisted()],
            Layout::of(axis("ahead in m/s"), axis("yaw rate in deg/s")),
        ),
    )
    .spanning(Span::Panel)
}

fn reach_figure(name: &str, limits: &SpeedLimits) -> Figure {
    let top_rad_s = limits.top_yaw_rate_rad_s();
    let outlines = YAW_SHARES.iter().enumerate().map(|(index, share)| {
        let corners = limits.at_yaw_rate(share * top_rad_s);
        let closed = corners.iter().chain(corners.first()).map(|v| (v.x, v.y));
        exact_curve(name, closed, wheel_pen(index)).unlisted()
    });
    let (slowest_m_s, fastest_m_s) = limits.top_speed_range_m_s();
    let speeds = match fastest_m_s - slowest_m_s < 1e-9 * fastest_m_s {
        true => format!("{fastest_m_s:.3}"),
        false => format!("{slowest_m_s:.3} to {fastest_m_s:.3}"),
    };
    Figure::new(
        "reach",
        format!(
            "{}: {speeds} m/s, {:.1} deg/s",
            name,
            top_rad_s.to_degrees()
        ),
        "",
        plot(
            outlines.collect(),
            Layout::of(axis("ahead in m/s"), axis("to the left in m/s")).equal(),
        ),
    )
    .spanning(Span::Panel)
}
