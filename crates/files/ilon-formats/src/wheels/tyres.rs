//! What stands for a tyre in other simulators.
//!
//! A tyre touches in its middle and s from it on both sides, each with a third of the load, and
//! resists a turn on the spot by mu N 2 s / 3. In MJCF an ellipsoid touches at each of these
//! places. SDF and URDF have a cylinder, which on a plane touches at both ends of its length l, and
//! resists by mu N l / 2: so l = 4 s / 3, with the default shoulders half of the tyre's width.

use super::frame::Format;
use super::shape::RollerShape;
use crate::generate::elements::tyres_element;
use crate::model::{CollisionShape, Robot, Roller, RollerForm, Wheel};

/// What stands for a tyre; `None` of a roller.
pub(super) fn shape(roller: &Roller, format: Format) -> Option<RollerShape> {
    let RollerForm::Tyre(solid) = &roller.form else {
        return None;
    };
    let radius_m = roller.radius_m;
    let shoulder_m = 0.5 * roller.length_m - solid.edge_radius_m();
    if format == Format::Mjcf {
        return Some(RollerShape::Ellipsoids {
            radius_m,
            half_length_m: shoulder_m / 3.0,
            at_m: vec![-shoulder_m, 0.0, shoulder_m],
        });
    }
    Some(RollerShape::of(CollisionShape::Cylinder {
        radius_m,
        length_m: 4.0 / 3.0 * shoulder_m,
    }))
}

/// The element of URDF by which ilon reads the tyres as they are; empty on rollers.
pub(super) fn element(robot: &Robot) -> String {
    let tyre = |wheel: &Wheel| {
        wheel.rollers.iter().find_map(|roller| match &roller.form {
            RollerForm::Tyre(solid) => Some((roller.length_m, solid.edge_radius_m())),
            _ => None,
        })
    };
    let tyres: Vec<(f64, f64)> = robot.wheels.iter().filter_map(tyre).collect();
    let Some((width_m, shoulder_m)) = tyres.first() else {
        return String::new();
    };
    // The element has one tyre for all; unequal ones are taken from the wheels' shapes.
    let all = tyres
        .iter()
        .all(|of| *of == tyres[0])
        .then_some((*width_m, Some(*shoulder_m)));
    let wheels = robot.wheels.iter();
    let wheels = wheels.map(|wheel| (&wheel.name[..], wheel.motor.effort_n_m > 0.0));
    tyres_element(all, wheels)
}
