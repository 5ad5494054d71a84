//! The robot that the controller believes in.
//!
//! It is the real robot with other wheels, whose steering axes move along, in the real wheels'
//! order: a wheel that the controller takes for another one has that one's place, axis, angle and
//! radius, and a wheel believed to turn the other way has its axis reversed. So its kinematics give
//! the rates of the real wheels as they are wired, and accept their encoders' values directly.

use std::f64::consts::PI;

use ilon_control::Kinematics;
use ilon_formats::{LoadOptions, LoadRobot};
use ilon_robot::{Robot, Roller, RollerForm, Wheel};
use nalgebra::{Isometry3, Rotation3, Unit, UnitQuaternion, Vector3};

use super::wheel_index;
use crate::Error;
use crate::robot::remedy;
use crate::scenario::{Believed, BelievedWheel, Scenario};

/// Differences below this are digits of a file, in metres and radians. Chosen.
const SAME: f64 = 1e-9;

/// Levers below this count as zero, in metres. Chosen.
const LEAST_LEVER_M: f64 = 1e-9;

/// The robot that a scenario's controller believes in; `None` if it knows the real one.
///
/// # Errors
/// [`Error::Invalid`] if it names wheels that the robot does not have, or no controller could drive
/// the believed robot; also errors of reading a file.
pub fn believed(scenario: &Scenario, robot: &Robot) -> Result<Option<Robot>, Error> {
    let Some(section) = &scenario.controller.robot else {
        return Ok(None);
    };
    let mut wheels = match &section.file {
        Some(_) => of_file(scenario, robot)?,
        None => robot.wheels.clone(),
    };
    for wheel in &mut wheels {
        alike(wheel, section)?;
    }
    let before = wheels.clone();
    // The wheel in whose real place each is believed, but for other errors.
    let mut meant: Vec<usize> = (0..wheels.len()).collect();
    for (name, of_wheel) in &section.wheels {
        let index = wheel_index(name, robot, "`controller.robot.wheels` is")?;
        let wheel = &mut wheels[index];
        if let Some(other) = &of_wheel.taken_for {
            let other = wheel_index(other, robot, "`taken_for` in `controller.robot.wheels` is")?;
            *wheel = as_in(&robot.wheels[index], &before[other]);
            // Cables of drives are exchanged, not those of the steering.
            wheel.carrier = before[other].carrier;
            meant[index] = other;
        }
        single(wheel, of_wheel);
    }
    if let Some(wheel) = wheels
        .iter()
        .find(|wheel| wheel.has_tyre() && wheel.gamma_rad != 0.0)
    {
        return Err(Error::invalid(
            format!(
                "`controller.robot` gives an angle gamma to `{}`, which rolls on a tyre",
                wheel.name
            ),
            "leave gamma_deg out, or name a robot with rollers as `controller.robot.file`",
        ));
    }
    let mut believed = robot.clone();
    believed.wheels = wheels;
    take_steering_along(&mut believed, robot, &meant);
    seen_from_origin(&mut believed, section);
    if believed.wheels == robot.wheels {
        return Ok(None);
    }
    match Kinematics::new(&believed) {
        Ok(_) => Ok(Some(believed)),
        Err(reason) => Err(Error::invalid(
            format!("the robot of `[controller.robot]` cannot be driven: {reason}"),
            "let the controller believe in wheels that can give all three motions in the plane",
        )),
    }
}

/// How a believed robot differs from the real one: by the keys that are of the whole robot, what of
/// all wheels is alike in one phrase, and else wheel by wheel.
pub fn in_words(section: &Believed, robot: &Robot, believed: &Robot) -> String {
    type Figure = (&'static str, fn(&Wheel) -> f64, &'static str);
    const FIGURES: [Figure; 5] = [
        ("radius", |wheel| 1e3 * wheel.radius_m, " mm"),
        ("x", |wheel| 1e3 * wheel.position_m().x, " mm"),
        ("y", |wheel| 1e3 * wheel.position_m().y, " mm"),
        ("axis", |wheel| axis_rad(wheel).to_degrees(), "°"),
        ("gamma", |wheel| wheel.gamma_rad.to_degrees(), "°"),
    ];
    /// In mm and degrees: smaller differences are rounding. Chosen.
    const LEAST: f64 = 1e-4;
    /// The most wheels that are described one by one. Chosen.
    const MOST: usize = 3;
    let mut phrases = Vec::new();
    // What the keys of the whole robot say is said so, and not of each wheel again.
    let mut own = robot.clone();
    if let (Some(lever_m), Some(first)) = (section.lever_m, robot.wheels.first()) {
        let [said, real] = [lever_m, lever_of(first)].map(|lever_m| 1e3 * lever_m);
        phrases.push(format!(
            "`lever_m` of {said:.2} mm in place of {real:.2} mm"
        ));
        let lever = Believed {
            lever_m: Some(lever_m),
            ..Believed::default()
        };
        // Without a lever of its own there is no believed robot.
        let _ = own
            .wheels
            .iter_mut()
            .try_for_each(|wheel| alike(wheel, &lever));
    }
    if seen_from_origin(&mut own, section) {
        let at = [section.origin_x_m, section.origin_y_m].map(|m| format!("{:.2}", 1e3 * m));
        let turned = match section.origin_heading_deg {
            0.0 => String::new(),
            deg => format!(", turned by {deg:.2}°"),
        };
        phrases.push(format!("the origin at ({}, {}) mm{turned}", at[0], at[1]));
    }
    let mut pairs: Vec<[Wheel; 2]> = Vec::new();
    for (real, believed) in own.wheels.iter().zip(&believed.wheels) {
        let (mut taken_for, mut believed) = (real.clone(), believed.clone());
        let apart_m = |wheel: &Wheel| (wheel.position_m() - believed.position_m()).xy().norm();
        let other = own.wheels.iter().find(|wheel| apart_m(wheel) < SAME);
        if let Some(other) = other.filter(|other| other.name != real.name) {
            phrases.push(format!("`{}` taken for `{}`", real.name, other.name));
            taken_for = as_in(real, other);
        }
        if (taken_for.axis() + believed.axis()).norm() < SAME {
            phrases.push(format!("`{}` reversed", real.name));
            believed.body_from_hub.rotation = taken_for.body_from_hub.rotation;
        }
        pairs.push([taken_for, believed]);
    }
    for (name, of, unit) in FIGURES {
        let instead = |[real, believed]: &[Wheel; 2]| {
            let [real, believed] = [real, believed].map(|wheel| format!("{:.2}{unit}", of(wheel)));
            format!("{name} {believed} in place of {real}")
        };
        let differ: Vec<&[Wheel; 2]> = pairs
            .iter()
            .filter(|[real, believed]| (of(real) - of(believed)).abs() > LEAST)
            .collect();
        let Some(first) = differ.first() else {
            continue;
        };
        let is_alike = differ.iter().all(|pair| instead(pair) == instead(first));
        if differ.len() == pairs.len() && is_alike {
            phrases.push(format!("all wheels with {}", instead(first)));
        } else if differ.len() > MOST {
            phrases.push(format!("{} wheels with another {name}", differ.len()));
        } else {
            let single = |pair: &&[Wheel; 2]| format!("`{}` with {}", pair[0].name, instead(pair));
            phrases.extend(differ.iter().map(single));
        }
    }
    match phrases.is_empty() {
        true => "other rollers".to_owned(),
        false => phrases.join(", "),
    }
}

/// Moves the joints that steer wheels with these, by the mean of a joint's wheels: a module that is
/// believed elsewhere has its steering axis there.
fn take_steering_along(believed: &mut Robot, robot: &Robot, meant: &[usize]) {
    for at in 0..believed.joints.len() {
        let its = believed.wheels.iter().zip(meant);
        let its = its.filter(|(wheel, _)| robot.steering_of(wheel) == Some(at));
        let moved_m: Vec<Vector3<f64>> = its
            .map(|(wheel, of)| wheel.position_m() - robot.wheels[*of].position_m())
            .collect();
        let count = moved_m.len().max(1) as f64;
        let mean_m = moved_m.iter().sum::<Vector3<f64>>() / count;
        believed.joints[at].body_from_joint.translation.vector += mean_m;
    }
}

/// Moves wheels and joints to where the origin that is believed in has them; gives whether that is
/// elsewhere.
fn seen_from_origin(robot: &mut Robot, section: &Believed) -> bool {
    let origin_from_body = Isometry3::new(
        Vector3::new(section.origin_x_m, section.origin_y_m, 0.0),
        section.origin_heading_deg.to_radians() * Vector3::z(),
    )
    .inverse();
    let is_elsewhere = origin_from_body != Isometry3::identity();
    if is_elsewhere {
        for wheel in &mut robot.wheels {
            wheel.body_from_hub = origin_from_body * wheel.body_from_hub;
        }
        for joint in &mut robot.joints {
            joint.body_from_joint = origin_from_body * joint.body_from_joint;
        }
    }
    is_elsewhere
}

/// The direction of a wheel's hub axis in the body frame, in radians.
fn axis_rad(wheel: &Wheel) -> f64 {
    let n = wheel.axis();
    libm::atan2(n.y, n.x)
}

/// The wheels of the file that the controller uses, in the robot's order.
fn of_file(scenario: &Scenario, robot: &Robot) -> Result<Vec<Wheel>, Error> {
    let section = scenario.controller.robot.as_ref();
    let file = section.and_then(|section| section.file.as_ref());
    let path = scenario.resolve(file.map_or_else(|| "".as_ref(), |file| file.as_path()));
    // The scenario's options, without those for its own robot's file.
    let own = scenario
        .robot
        .load_options(&scenario.folder, &scenario.files);
    let mut options = LoadOptions::default();
    options.files = own.files;
    options.packages = own.packages;
    options.rollers = own.rollers;
    let other = match Robot::load_with(&path, &options) {
        Ok(loaded) => loaded.robot,
        Err(fault) => return Err(remedy::diagnosed(fault, &path, &options, &remedy::Keys)),
    };
    let (found, wanted) = (other.wheels.len(), robot.wheels.len());
    if found != wanted {
        return Err(Error::invalid(
            format!(
                "the robot of `controller.robot.file` has {found} wheels, and the robot has {wanted}"
            ),
            "name the file of a robot with as many wheels",
        ));
    }
    let by_name = |wheel: &Wheel| other.wheels.iter().find(|of| of.name == wheel.name);
    let named: Option<Vec<&Wheel>> = robot.wheels.iter().map(by_name).collect();
    let matched = named.unwrap_or_else(|| other.wheels.iter().collect());
    let pairs = robot.wheels.iter().zip(matched);
    Ok(pairs.map(|(own, other)| as_in(own, other)).collect())
}

/// A wheel with the place, axis, radius and rollers of another.
fn as_in(own: &Wheel, other: &Wheel) -> Wheel {
    Wheel {
        name: own.name.clone(),
        carrier: own.carrier,
        hub: own.hub.clone(),
        motor: own.motor,
        joint: own.joint,
        drive: own.drive,
        ..other.clone()
    }
}

/// Applies the beliefs about all wheels to a wheel.
fn alike(wheel: &mut Wheel, section: &Believed) -> Result<(), Error> {
    let radius_m = section.wheel_radius_m.unwrap_or(wheel.radius_m);
    let gamma_rad = section.gamma_deg.map(|gamma_deg| {
        let sense = if wheel.gamma_rad < 0.0 { -1.0 } else { 1.0 };
        sense * gamma_deg.to_radians()
    });
    reshape(wheel, radius_m, gamma_rad.unwrap_or(wheel.gamma_rad));
    let Some(lever_m) = section.lever_m else {
        return Ok(());
    };
    let own_m = lever_of(wheel);
    if own_m < LEAST_LEVER_M {
        return Err(Error::invalid(
            format!(
                "`controller.robot.lever_m` = {lever_m}, and the wheel `{}` does not turn while the robot turns in place: it has no lever",
                wheel.name
            ),
            "leave `lever_m` out, and give x_m and y_m under [controller.robot.wheels.NAME]",
        ));
    }
    let place = &mut wheel.body_from_hub.translation.vector;
    let scale = match differ(lever_m, own_m) {
        true => lever_m / own_m,
        false => 1.0,
    };
    (place.x, place.y) = (scale * place.x, scale * place.y);
    Ok(())
}

/// Displacement of a wheel's rim per radian of rotation about the body's origin, in metres: |b .
/// u_gamma| / cos(gamma), Indiveri 2009, eq. (5).
fn lever_of(wheel: &Wheel) -> f64 {
    let along = wheel
        .roller_rolling_direction()
        .dot(&wheel.position_m().xy());
    (along / libm::cos(wheel.gamma_rad)).abs()
}

/// Applies the beliefs about a single wheel to it.
fn single(wheel: &mut Wheel, section: &BelievedWheel) {
    let radius_m = section.radius_m.unwrap_or(wheel.radius_m);
    let gamma_rad = section.gamma_deg.map_or(wheel.gamma_rad, f64::to_radians);
    reshape(wheel, radius_m, gamma_rad);
    let place = &mut wheel.body_from_hub.translation.vector;
    let instead =
        |own: f64, said: Option<f64>| said.filter(|said| differ(own, *said)).unwrap_or(own);
    place.x = instead(place.x, section.x_m);
    place.y = instead(place.y, section.y_m);
    let mut turned_rad = match section.axis_deg {
        Some(axis_deg) => axis_deg.to_radians() - axis_rad(wheel),
        None => 0.0,
    };
    if section.reversed {
        turned_rad += PI;
    }
    if differ(turned_rad, 0.0) {
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turned_rad);
        wheel.body_from_hub.rotation = turned * wheel.body_from_hub.rotation;
    }
}

fn differ(one: f64, other: f64) -> bool {
    (one - other).abs() > SAME
}

/// Gives a wheel another radius and another angle gamma: a similar wheel of that size, with the
/// rollers' axes rotated about the lines from the hub axis through their middles. Its rollers are
/// barrels, whatever the real ones are; a tyre stays one.
fn reshape(wheel: &mut Wheel, radius_m: f64, gamma_rad: f64) {
    if !differ(radius_m, wheel.radius_m) && !differ(gamma_rad, wheel.gamma_rad) {
        return;
    }
    let (scale, turned_rad) = (radius_m / wheel.radius_m, gamma_rad - wheel.gamma_rad);
    for roller in &mut wheel.rollers {
        if let RollerForm::Tyre(tyre) = &roller.form {
            // Its width and its shoulders fit into any radius.
            let (width_m, shoulder_m) = (roller.length_m, tyre.edge_radius_m());
            if let Ok(tyre) = Roller::tyre(&wheel.name, radius_m, width_m, shoulder_m) {
                *roller = tyre;
            }
            continue;
        }
        // Neighbours go on handing over as they do: L = 2 a tan(pi/n) / cos gamma.
        roller.length_m *= scale * libm::cos(wheel.gamma_rad) / libm::cos(gamma_rad);
        // Counter-clockwise seen from above, for the roller that points down.
        let mut up = -roller.center_in_hub_m;
        up.z = 0.0;
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(up), turned_rad);
        roller.axis_in_hub = turn * roller.axis_in_hub;
        roller.center_in_hub_m *= scale;
        roller.radius_m *= scale;
        roller.form = RollerForm::Barrel;
    }
    (wheel.radius_m, wheel.gamma_rad) = (radius_m, gamma_rad);
}
