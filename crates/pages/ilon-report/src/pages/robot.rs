//! A page of one robot: in three dimensions with turning wheels, from above, and its capabilities.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::figure::{Figure, Layout, axis, exact_curve, plot, wheel_pen};
use crate::html_table::{cell, heads, row, table, wide};
use crate::page::{Head, Section, card, escape};
use crate::{drawing, viewer};
use ilon_control::{ContactKinematics, Kinematics, SpeedLimits};
use ilon_formats::Loaded;
use ilon_robot::Robot;
use ilon_scene::{Contact, Description, Frame, Frames, Scene, WheelFrame};
use ilon_sim::inspect::{Inspection, TyresInspection};

use super::design;
use super::gallery;
use super::limits;

/// Time of one turn of the wheels, in seconds.
const TURN_S: f64 = 8.0;

/// Frames of one turn of the wheels: thirty per second.
const PICTURES: usize = 240;

/// Returns the page of a robot as one self-contained HTML file. `seen` is its
/// [`Inspection::of_loaded`].
pub fn html(loaded: &Loaded, seen: &Inspection) -> String {
    let robot = &loaded.robot;
    let kinematics = Kinematics::new(robot).ok();
    let contact = ContactKinematics::new(robot).ok();
    let scene = Scene::new(
        Description::of_robot(robot, loaded.links().as_ref(), &loaded.visual_meshes()),
        turning(robot, contact.clone()),
    );
    let picture = viewer::of_robot(&scene, TURN_S).ok();
    let has_scene = picture.is_some();
    let on_tyres = seen.tyres.is_some();
    let by_direction = kinematics
        .as_ref()
        .zip(contact)
        .filter(|_| !on_tyres)
        .map(|(ideal, contact)| by_direction(ideal, contact));
    let head = Head {
        kind: "robot",
        title: seen.name.clone(),
        facts: gallery::figures(seen)
            .into_iter()
            .map(|(name, value)| format!("{name} <b>{}</b>", escape(&value)))
            .collect(),
        lead: format!(
            "<div class=\"first\"><div class=\"story\">{}</div>\n{}</div>\n",
            story(seen, by_direction.as_deref()),
            picture.unwrap_or_default()
        ),
    };
    let mut sections = vec![Section {
        id: "above",
        title: "From above",
        lead: match on_tyres {
            true => "Its wheels, with the joints where they stand.",
            false => "The axes of the rollers that touch the floor, as seen through the robot.",
        }
        .to_owned(),
        body: format!(
            "<div class=\"grid\"><figure>{}</figure>\n{}</div>\n",
            drawing::svg(robot, seen.decoupling_point_m.map(Into::into)),
            by_direction
                .map(|shares| card(&direction_figure(&shares)))
                .unwrap_or_default()
        ),
    }];
    let rates_rad_s: Vec<f64> = robot
        .wheels
        .iter()
        .map(|w| w.motor.velocity_rad_s)
        .collect();
    if let Some(kinematics) = &kinematics
        && seen.speed_limits.is_some()
        && (on_tyres || rates_rad_s.iter().all(|rate| rate.is_finite()))
        && seen
            .tyres
            .as_ref()
            .is_none_or(|tyres| tyres.turning_radius_m.is_none_or(|m| m == 0.0))
    {
        let limits = SpeedLimits::new(kinematics, &rates_rad_s);
        sections.push(design::reach_section(&seen.name, &limits));
    }
    sections.extend(limits::section(seen));
    sections.push(wheels_section(seen));
    if !seen.remarks.is_empty() {
        sections.push(Section {
            id: "remarks",
            title: "Remarks",
            lead: "What of the file was ignored, repaired, assumed or doubted.".to_owned(),
            body: gallery::list(&seen.remarks),
        });
    }
    let footer = "<p>γ, M and equation (7) are those of G. Indiveri, “Swedish Wheeled Omnidirectional Mobile Robots: Kinematics Analysis \
                  and Control”, IEEE Transactions on Robotics 25(1), 2009.</p>";
    viewer::page(&head, &sections, footer, has_scene)
}

/// One turn of the wheels in place, with the touching roller at each instant.
fn turning(robot: &Robot, contact: Option<ContactKinematics>) -> Frames {
    let at_rest = Frame::at_rest(robot);
    let Some(mut contact) = contact else {
        return Frames::of(robot, [at_rest]);
    };
    // The load per wheel, in equal shares: forces are scaled so that this load has a fixed size.
    let load_n = 9.81 * robot.mass_kg() / robot.wheels.len() as f64;
    let frames = (0..=PICTURES).map(|k| {
        let part = k as f64 / PICTURES as f64;
        contact.update(&vec![TAU * part; robot.wheels.len()]);
        let wheels = at_rest.wheels.iter().zip(contact.contacts());
        Frame {
            t_s: TURN_S * part,
            wheels: wheels
                .map(|(wheel, touch)| WheelFrame {
                    angle_rad: TAU * part,
                    roller: touch.roller,
                    contact: Some(Contact {
                        place_m: [touch.point_in_body_m.x, touch.point_in_body_m.y],
                        normal_force_n: load_n,
                        friction: 0.6,
                        ..Contact::default()
                    }),
                    ..wheel.clone()
                })
                .collect(),
            ..at_rest.clone()
        }
    });
    Frames::of(robot, frames.collect::<Vec<_>>())
}

/// Returns the speed by the touching rollers over the 1 m/s of equation (7): direction in degrees,
/// mean and ripple over it.
fn by_direction(kinematics: &Kinematics, mut contact: ContactKinematics) -> Vec<(f64, f64, f64)> {
    let directions = (0..=36).map(|k| PI * f64::from(k) / 36.0);
    directions
        .map(|direction_rad| {
            let (mean, swing) = design::along(direction_rad, kinematics, &mut contact);
            (direction_rad.to_degrees(), mean, swing)
        })
        .collect()
}

fn direction_figure(shares: &[(f64, f64, f64)]) -> Figure {
    let mean = shares
        .iter()
        .map(|(degrees, mean, _)| (*degrees, 100.0 * mean));
    Figure::new(
        "by-direction",
        "How far the rollers let it go",
        "Mean speed that the touching rollers allow, as a share of the ideal kinematics, by direction: 0° is ahead, \
         90° to the left. What is missing is geometry, not slip.",
        plot(
            vec![exact_curve("share of (7)", mean, wheel_pen(0)).unlisted()],
            Layout::of(
                axis("direction in deg"),
                axis("share of (7) in %").least_span(1.0),
            ),
        ),
    )
}

/// Describes the robot's capabilities in sentences, as HTML.
fn story(seen: &Inspection, shares: Option<&[(f64, f64, f64)]>) -> String {
    let mut sentences = Vec::new();
    if let Some(singularity) = &seen.singularity {
        sentences.push(escape(singularity));
    }
    if let Some(tyres) = &seen.tyres {
        sentences.extend(on_tyres(tyres));
    }
    if let Some(shares) = shares {
        let of = |direction_rad: f64| {
            let degrees = direction_rad.to_degrees();
            shares.iter().find(|(at, ..)| (at - degrees).abs() < 1e-9)
        };
        if let (Some((_, ahead, _)), Some((_, left, swing))) = (of(0.0), of(FRAC_PI_2)) {
            sentences.push(format!(
                "Its touching rollers let it go <b>{:.1} %</b> of the ideal kinematics ahead and <b>{:.1} %</b> sideways, where its speed \
                 swings by <b>{:.1} %</b> as rollers pass. That is geometry: slip comes on top.",
                100.0 * ahead,
                100.0 * left,
                100.0 * swing
            ));
        }
    }
    if let Some(limits) = &seen.speed_limits {
        let (least, most) = (limits.slowest_direction_m_s, limits.fastest_direction_m_s);
        let tyres = seen.tyres.as_ref().filter(|tyres| tyres.is_held());
        let speeds = match (tyres.is_some(), limits.is_even()) {
            (true, _) => format!("<b>{most:.2} m/s</b>"),
            (false, true) => format!("<b>{most:.2} m/s</b> in every direction"),
            (false, false) => format!("<b>{least:.2} to {most:.2} m/s</b>, by direction"),
        };
        let turning = match tyres.and_then(|tyres| tyres.turning_radius_m) {
            Some(radius_m) if radius_m > 0.0 => "in its sharpest turn",
            _ => "on the spot",
        };
        sentences.push(format!(
            "Its motors take it to {speeds}, or to <b>{:.0}°/s</b> {turning}.",
            limits.yaw_rate_rad_s.to_degrees()
        ));
    }
    if seen.condition.is_some() && !seen.decoupled {
        sentences
            .push("Position and heading disturb each other about the body's origin.".to_owned());
    }
    sentences.iter().map(|s| format!("<p>{s}</p>")).collect()
}

/// What tyres leave, in sentences.
fn on_tyres(tyres: &TyresInspection) -> Vec<String> {
    let mut sentences = Vec::new();
    match &tyres.excluded {
        Some(excluded) => sentences.push(format!(
            "Its tyres leave <b>{} of 3</b> twists. Excluded: {}.",
            tyres.reachable_twists,
            escape(excluded)
        )),
        None => sentences.push(
            "All its tyres are steered: it drives every twist once they have turned to it."
                .to_owned(),
        ),
    }
    if let Some(radius_m) = tyres.turning_radius_m.filter(|radius_m| *radius_m > 0.0) {
        sentences.push(format!(
            "Its steering lets the middle of the other tyres turn on a circle of <b>{radius_m:.2} m</b> and more."
        ));
    }
    let apart_m = tyres.axles_apart_m();
    if apart_m > 5e-4 {
        sentences.push(format!(
            "Its axles lie up to <b>{apart_m:.2} m</b> apart: in a turn tyres scrub, and it turns less than the wheels' rates say."
        ));
    }
    sentences
}

fn wheels_section(seen: &Inspection) -> Section {
    let optional = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), |x| format!("{x:.2}"));
    let rows: String = seen
        .wheels
        .iter()
        .map(|wheel| {
            let [x, y, z] = wheel.position_m;
            let (count, radius_m, length_m) = match wheel.tyre {
                Some(tyre) => ("tyre".to_owned(), tyre.shoulder_radius_m, tyre.width_m),
                None => (
                    wheel.rollers.to_string(),
                    wheel.roller_radius_m,
                    wheel.roller_length_m,
                ),
            };
            let values = [
                format!("{x:.3}"),
                format!("{y:.3}"),
                format!("{z:.3}"),
                format!("{:.1}", 1e3 * wheel.radius_m),
                format!("{:.1}", wheel.gamma_rad.to_degrees()),
                count,
                format!("{:.2}", 1e3 * radius_m),
                format!("{:.2}", 1e3 * length_m),
                format!("{:.3}", wheel.mass_kg),
                optional(wheel.effort_n_m),
                optional(wheel.velocity_rad_s),
            ];
            row(
                &escape(&wheel.name),
                &values.map(|v| cell(Some(v))).concat(),
            )
        })
        .collect();
    let [rolls, radius, length] = match seen.tyres {
        Some(_) => ["rolls on", "shoulders / mm", "width / mm"],
        None => ["rollers", "their radius / mm", "length / mm"],
    };
    let titles = [
        "wheel",
        "x / m",
        "y / m",
        "z / m",
        "radius / mm",
        "γ / °",
        rolls,
        radius,
        length,
        "mass / kg",
        "torque / N m",
        "rate / rad/s",
    ];
    Section {
        id: "wheels",
        title: "The wheels",
        lead: "Places in the body frame: x ahead, y to the left, z up. Torque and rate are the motors' limits.".to_owned(),
        body: wide(&table("", &heads(titles), &rows)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    /// Beyond half a turn the speeds repeat. Rollers at 45 degrees let the robot go ahead as eq.
    /// (7) says, and back as well.
    #[test]
    fn directions_are_from_ahead_to_back() {
        let robot = Robot::load("../../../assets/robots/mecanum4.toml").expect("a shipped robot");
        let kinematics = Kinematics::new(&robot).expect("four wheels");
        let contact = ContactKinematics::new(&robot).expect("rollers that touch");
        let shares = by_direction(&kinematics, contact);
        let degrees: Vec<f64> = shares.iter().map(|(degrees, ..)| degrees.round()).collect();
        assert_eq!(
            degrees,
            Vec::from_iter((0..=36).map(|k| 5.0 * f64::from(k)))
        );
        let mean = |at: usize| shares[at].1;
        assert!((mean(0) - 1.0).abs() < 0.01 && (mean(36) - 1.0).abs() < 0.01);
        assert!(mean(18) < 0.99, "{}", mean(18));
    }
}
