//! A page on design: the effect of one choice (an angle, a count, a place) on the capabilities of a
//! wheel arrangement.
//!
//! ```no_run
//! # use ilon_report::pages::design::{self, Curve, Merits, Study};
//! # fn robot(_half_track_m: f64) -> ilon_robot::Robot { unimplemented!() }
//! let tracks_m = [0.10, 0.15, 0.20];
//! let points = tracks_m.map(|x| (x, Merits::of(&robot(x), 10.0)));
//! let study = Study {
//!     id: "track",
//!     title: "How wide",
//!     lead: String::new(),
//!     x_title: "half track in m".to_owned(),
//!     curves: vec![Curve { name: "my robot".to_owned(), points: points.into() }],
//! };
//! design::write("design.html".as_ref(), "My robot", &[], &[study])?;
//! # Ok::<(), ilon_trace::TraceError>(())
//! ```

use std::path::Path;

use ilon_control::{Arrangement, ContactKinematics, Kinematics, SpeedLimits};
use ilon_robot::{Robot, Twist};
use ilon_trace::TraceError;
use ilon_trace::file::write_text;
use nalgebra::Vector2;

use crate::figure::{Figure, Layout, Span, axis, exact_curve, layout, plot, wheel_pen};
use crate::page::{self, Head, Section, escape, panels, side_by_side};

/// Figures of merit of a wheel arrangement; NaN if not applicable, as for a robot that violates
/// Lemma 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merits {
    /// The singular values of M of Indiveri 2009, eq. (8), about the body's origin, falling; the
    /// last column of M is in metres.
    pub singular_values: [f64; 3],
    /// The condition of M, independent of units; infinite if the rank is below 3.
    pub condition: f64,
    /// Top speed in the slowest direction, without rotation, in m/s.
    pub slowest_m_s: f64,
    /// Top speed in the fastest direction, without rotation, in m/s.
    pub fastest_m_s: f64,
    /// Top yaw rate on the spot, in rad/s.
    pub yaw_rate_rad_s: f64,
    /// Distance from the body's origin to the point about which position and heading are decoupled,
    /// in metres.
    pub decoupling_m: f64,
    /// Mean speed to the left by the touching rollers, over that of eq. (7).
    pub sideways_share: f64,
    /// Peak-to-peak ripple of that speed as rollers pass, over its mean.
    pub sideways_ripple: f64,
}

impl Merits {
    /// Computes the merits of a robot whose wheels turn at up to `wheel_rate_rad_s`.
    pub fn of(robot: &Robot, wheel_rate_rad_s: f64) -> Self {
        let mut merits = Self {
            singular_values: [f64::NAN; 3],
            condition: f64::NAN,
            slowest_m_s: f64::NAN,
            fastest_m_s: f64::NAN,
            yaw_rate_rad_s: f64::NAN,
            decoupling_m: f64::NAN,
            sideways_share: f64::NAN,
            sideways_ripple: f64::NAN,
        };
        if let Ok(arrangement) = Arrangement::of(robot) {
            merits.singular_values = arrangement.singular_values;
            merits.condition = arrangement.condition;
        }
        if let Ok(kinematics) = Kinematics::new(robot) {
            let limits = SpeedLimits::uniform(&kinematics, wheel_rate_rad_s);
            (merits.slowest_m_s, merits.fastest_m_s) = limits.top_speed_range_m_s();
            merits.yaw_rate_rad_s = limits.top_yaw_rate_rad_s();
            merits.decoupling_m = kinematics.decoupling_point_m().norm();
            if let Ok(contact) = ContactKinematics::new(robot) {
                (merits.sideways_share, merits.sideways_ripple) = sideways(&kinematics, contact);
            }
        }
        merits
    }
}

/// Returns mean and ripple of the speed to the left by the touching rollers, for the wheel rates of
/// (7) for 1 m/s.
fn sideways(kinematics: &Kinematics, mut contact: ContactKinematics) -> (f64, f64) {
    along(std::f64::consts::FRAC_PI_2, kinematics, &mut contact)
}

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

/// Merits over a varied number.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its name.
    pub name: String,
    /// The number and its merits.
    pub points: Vec<(f64, Merits)>,
}

/// A varied choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Identifier for links, of letters, digits and dashes.
    pub id: &'static str,
    /// Heading, as text.
    pub title: &'static str,
    /// Introduction with reading instructions, as text.
    pub lead: String,
    /// Name and unit of the number.
    pub x_title: String,
    /// One curve per robot.
    pub curves: Vec<Curve>,
}

/// The twists that a robot's wheels allow.
#[derive(Clone, Debug)]
pub struct Reach {
    /// The robot's name.
    pub name: String,
    /// Its limits.
    pub limits: SpeedLimits,
}

/// Writes reaches and studies as one self-contained HTML file, atomically.
///
/// # Errors
/// [`TraceError::Io`] if the file cannot be written.
pub fn write(
    path: &Path,
    title: &str,
    reaches: &[Reach],
    studies: &[Study],
) -> Result<(), TraceError> {
    write_text(path, &html(title, reaches, studies))
}

/// Returns reaches and studies as one self-contained HTML file.
pub fn html(title: &str, reaches: &[Reach], studies: &[Study]) -> String {
    let head = Head {
        kind: "design study",
        title: title.to_owned(),
        facts: vec![format!("<b>{}</b> choices varied", studies.len())],
        lead: String::new(),
    };
    let reach = (!reaches.is_empty()).then(|| reach_section(reaches));
    let sections: Vec<Section> = reach
        .into_iter()
        .chain(studies.iter().map(section))
        .collect();
    let footer = "<p>Equation numbers are those of G. Indiveri, “Swedish Wheeled Omnidirectional Mobile Robots: Kinematics \
                  Analysis and Control”, IEEE Transactions on Robotics 25(1), 2009. Where a curve breaks off, Lemma 1 \
                  refuses the robot.</p>";
    page::page(&head, &sections, footer, &page::Parts::default())
}

/// Shares of the top yaw rate at which the set of velocities is drawn.
const YAW_SHARES: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// The velocities that each robot's wheels allow at some shares of its top yaw rate; its speeds and
/// yaw rates where tyres leave it one direction.
pub(super) fn reach_section(reaches: &[Reach]) -> Section {
    if reaches.iter().all(|reach| reach.limits.is_held()) {
        return held_section(reaches);
    }
    let names = YAW_SHARES.map(|share| format!("at {:.0} % of the top yaw rate", 100.0 * share));
    let legend: Vec<_> = names
        .iter()
        .enumerate()
        .map(|(index, name)| (name.as_str(), wheel_pen(index)))
        .collect();
    let figures: Vec<Figure> = reaches.iter().enumerate().map(reach_figure).collect();
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
fn held_section(reaches: &[Reach]) -> Section {
    let figures: Vec<Figure> = reaches.iter().enumerate().map(held_figure).collect();
    Section {
        id: "reach",
        title: "What the wheels allow",
        lead: "Unsteered tyres leave the speed ahead and the yaw rate. The outline holds what the wheels' rates allow of both."
            .to_owned(),
        body: side_by_side(&panels("Speed and yaw rate", "", &[], &figures)),
    }
}

/// The outline of the speeds along the tyres' way and of the yaw rates.
fn held_figure((number, reach): (usize, &Reach)) -> Figure {
    /// Yaw rates on each half of the outline.
    const STEPS: i32 = 40;
    let limits = &reach.limits;
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
        format!("reach-{number}"),
        format!(
            "{}: {fastest_m_s:.3} m/s, {:.1} deg/s",
            reach.name,
            top_rad_s.to_degrees()
        ),
        "",
        plot(
            vec![exact_curve(&reach.name, around.copied(), wheel_pen(0)).unlisted()],
            Layout::of(axis("ahead in m/s"), axis("yaw rate in deg/s")),
        ),
    )
    .spanning(Span::Panel)
}

fn reach_figure((number, reach): (usize, &Reach)) -> Figure {
    let top_rad_s = reach.limits.top_yaw_rate_rad_s();
    let outlines = YAW_SHARES.iter().enumerate().map(|(index, share)| {
        let corners = reach.limits.at_yaw_rate(share * top_rad_s);
        let closed = corners.iter().chain(corners.first()).map(|v| (v.x, v.y));
        exact_curve(&reach.name, closed, wheel_pen(index)).unlisted()
    });
    let (slowest_m_s, fastest_m_s) = reach.limits.top_speed_range_m_s();
    let speeds = match fastest_m_s - slowest_m_s < 1e-9 * fastest_m_s {
        true => format!("{fastest_m_s:.3}"),
        false => format!("{slowest_m_s:.3} to {fastest_m_s:.3}"),
    };
    Figure::new(
        format!("reach-{number}"),
        format!(
            "{}: {speeds} m/s, {:.1} deg/s",
            reach.name,
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

/// A figure of merit on a panel: identifier, title, unit, value.
type Panel = (&'static str, &'static str, &'static str, fn(&Merits) -> f64);

const PANELS: [Panel; 10] = [
    ("s1", "Largest singular value", "", |m| m.singular_values[0]),
    ("s2", "Middle singular value", "", |m| m.singular_values[1]),
    ("s3", "Smallest singular value", "", |m| {
        m.singular_values[2]
    }),
    ("condition", "Condition, free of units", "", |m| m.condition),
    ("slow", "Top speed, slowest direction", "m/s", |m| {
        m.slowest_m_s
    }),
    ("fast", "Top speed, fastest direction", "m/s", |m| {
        m.fastest_m_s
    }),
    ("yaw", "Top yaw rate", "deg/s", |m| {
        m.yaw_rate_rad_s.to_degrees()
    }),
    ("point", "Decoupling point from the origin", "mm", |m| {
        1e3 * m.decoupling_m
    }),
    ("share", "Sideways, of what (7) says", "%", |m| {
        100.0 * m.sideways_share
    }),
    ("ripple", "Ripple of that speed", "%", |m| {
        100.0 * m.sideways_ripple
    }),
];

/// Conditions beyond this only mean that the robot is unusable, and would flatten the rest of the
/// curve.
const WORST_CONDITION: f64 = 30.0;

/// Values below this are rounding errors of zero.
const ROUNDING: f64 = 1e-6;

fn section(study: &Study) -> Section {
    let names: Vec<String> = study
        .curves
        .iter()
        .map(|curve| curve.name.clone())
        .collect();
    let legend: Vec<_> = names
        .iter()
        .enumerate()
        .map(|(index, name)| (name.as_str(), wheel_pen(index)))
        .collect();
    let figures: Vec<Figure> = PANELS.iter().map(|panel| figure(study, panel)).collect();
    Section {
        id: study.id,
        title: study.title,
        lead: escape(&study.lead),
        body: side_by_side(&panels(&study.x_title, "", &legend, &figures)),
    }
}

fn figure(study: &Study, (id, title, unit, of): &Panel) -> Figure {
    let curves = study.curves.iter().enumerate().map(|(index, curve)| {
        let shown = |value: f64| {
            let beyond = *id == "condition" && value > WORST_CONDITION;
            if !value.is_finite() || beyond {
                f64::NAN
            } else if value.abs() < ROUNDING {
                0.0
            } else {
                value
            }
        };
        let points = curve
            .points
            .iter()
            .map(|(x, merits)| (*x, shown(of(merits))));
        exact_curve(&curve.name, points, wheel_pen(index)).unlisted()
    });
    Figure::new(
        format!("{}-{id}", study.id),
        *title,
        "",
        plot(curves.collect(), layout(&study.x_title, unit)),
    )
    .height_px(230)
    .spanning(Span::Panel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    #[test]
    fn merits_of_robot_a_are_the_textbooks() {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
        let merits = Merits::of(&robot, 10.0);
        // |vx| + |vy| + 0.31 |omega| <= rho q' = 0.5 m/s; M's columns have the norms sqrt 2, sqrt 2
        // and 0.31 sqrt 2.
        assert!((merits.slowest_m_s - 0.5 / 2.0_f64.sqrt()).abs() < 1e-6);
        assert!((merits.fastest_m_s - 0.5).abs() < 1e-6);
        assert!((merits.yaw_rate_rad_s - 0.5 / 0.31).abs() < 1e-6);
        for (value, expected) in merits.singular_values.iter().zip([1.0, 1.0, 0.31]) {
            assert!((value - expected * 2.0_f64.sqrt()).abs() < 1e-6, "{value}");
        }
        assert!(merits.decoupling_m < 1e-6);
        // Nine rollers at 45 degrees: the mean of cos phi over +-20 degrees. The wheels are not in
        // phase, and the mean of a thousand instants has an error of some 1e-4.
        let mean = 20.0_f64.to_radians().sin() / 20.0_f64.to_radians();
        assert!((merits.sideways_share - mean).abs() < 2e-3, "{merits:?}");
    }

    #[test]
    fn the_page_holds_every_panel_of_every_study() {
        let merits = Merits {
            singular_values: [1.0; 3],
            condition: f64::INFINITY,
            slowest_m_s: 0.3,
            fastest_m_s: 0.4,
            yaw_rate_rad_s: 1.0,
            decoupling_m: 0.0,
            sideways_share: 0.98,
            sideways_ripple: 0.06,
        };
        let study = Study {
            id: "angle",
            title: "The angle <gamma>",
            lead: "Varied.".to_owned(),
            x_title: "gamma in deg".to_owned(),
            curves: vec![Curve {
                name: "a & b".to_owned(),
                points: vec![(0.0, merits), (1.0, merits)],
            }],
        };
        let urdf = include_str!("../../../../../assets/robots/volksbot.urdf");
        let kinematics = Kinematics::new(&Robot::from_urdf_str(urdf, "volksbot").unwrap()).unwrap();
        let reach = Reach {
            name: "volksbot".to_owned(),
            limits: SpeedLimits::uniform(&kinematics, 8.7),
        };
        let page = html("Design", &[reach], &[study]);
        // The paper's figures for its robot.
        assert!(page.contains("volksbot: 0.435 to 0.502 m/s, 99.7 deg/s"));
        for (id, ..) in PANELS {
            assert!(page.contains(&format!("id=\"angle-{id}\"")), "{id}");
        }
        assert!(page.contains("The angle &lt;gamma&gt;") && page.contains("a &amp; b"));
    }
}
