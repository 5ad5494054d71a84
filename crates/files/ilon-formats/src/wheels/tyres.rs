//! What stands for a tyre in other simulators: a cylinder about the hub axis.
//!
//! On a plane their cylinders touch at both ends of a line, each with half of the load, and resist a turn on the spot by mu N l / 2 with
//! the cylinder's length l. A tyre touches in its middle and s from it on both sides, each with a third, by mu N 2 s / 3. The cylinder is
//! therefore l = 4 s / 3 long: with the default shoulders, half of the tyre's width.

use std::fmt::Write;

use nalgebra::Isometry3;

use crate::generate::elements::{attribute, num};
use crate::model::{Collision, CollisionShape, Robot, Roller, RollerForm, Wheel};

/// The cylinder that stands for a tyre; `None` of a roller.
pub(super) fn cylinder(roller: &Roller) -> Option<Collision> {
    let RollerForm::Tyre(solid) = &roller.form else {
        return None;
    };
    let shoulder_m = 0.5 * roller.length_m - solid.edge_radius_m();
    Some(Collision {
        friction: None,
        body_from_shape: Isometry3::identity(),
        shape: CollisionShape::Cylinder {
            radius_m: roller.radius_m,
            length_m: 4.0 / 3.0 * shoulder_m,
        },
    })
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
    let mut out = "  <ilon_tyres".to_owned();
    // The element has one tyre for all; unequal ones are taken from the wheels' shapes.
    if tyres.iter().all(|of| *of == tyres[0]) {
        let [width, shoulder] = [width_m, shoulder_m].map(|m| num(*m));
        let _ = write!(out, " width=\"{width}\" shoulder_radius=\"{shoulder}\"");
    }
    out += ">\n";
    for wheel in &robot.wheels {
        let driven = wheel.motor.effort_n_m > 0.0;
        let name = attribute(&wheel.name);
        let _ = writeln!(out, "    <wheel joint=\"{name}\" driven=\"{driven}\"/>");
    }
    out + "  </ilon_tyres>\n"
}
