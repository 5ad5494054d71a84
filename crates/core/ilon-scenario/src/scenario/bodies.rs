//! `[[world.bodies]]`: objects in the world that can be pushed.

use ilon_files::defaults::thousandths;
use ilon_robot::FreeShape;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checks::objection::{Objection, object_if, objection};

/// A free rigid body of uniform density: `box`, `cylinder` or `sphere`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Its name, unique; used in the trace's columns.
    #[schemars(length(min = 1))]
    pub name: String,
    /// It is a box with these sides.
    #[serde(default, rename = "box", skip_serializing_if = "Option::is_none")]
    pub cuboid: Option<BoxShape>,
    /// It is a cylinder, upright unless it is turned.
    pub cylinder: Option<CylinderShape>,
    /// It is a sphere.
    pub sphere: Option<SphereShape>,
    /// Its mass, in kg.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub mass_kg: f64,
    /// Friction coefficient. On the floor and between two bodies the lower of both counts.
    #[serde(default = "thousandths::<500>")]
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// Friction coefficient against robots [default: `friction`].
    #[schemars(range(min = 0.0))]
    pub friction_on_robots: Option<f64>,
    /// x of its middle, in metres.
    pub x_m: f64,
    /// y of its middle, in metres.
    pub y_m: f64,
    /// Height of its middle above the floor, in metres [default: it stands on what is below it:
    /// floor, an earlier body, or the robot].
    pub z_m: Option<f64>,
    /// Its heading in the world, in degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Pitch, applied before the heading, in degrees; 90 lays a cylinder along x.
    #[serde(default)]
    pub pitch_deg: f64,
    /// Roll, applied before the heading, in degrees.
    #[serde(default)]
    pub roll_deg: f64,
    /// Velocity along x at the start, in m/s.
    #[serde(default)]
    pub vx_m_s: f64,
    /// Velocity along y at the start, in m/s.
    #[serde(default)]
    pub vy_m_s: f64,
    /// Velocity along z at the start, upwards, in m/s.
    #[serde(default)]
    pub vz_m_s: f64,
    /// Yaw rate at the start, in rad/s.
    #[serde(default)]
    pub omega_rad_s: f64,
}

/// The sides of a box.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxShape {
    /// Along its own x, y and z axes, in metres.
    pub size_m: [f64; 3],
}

/// The size of a cylinder.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderShape {
    /// Its radius, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_m: f64,
    /// Its length along its own z axis, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length_m: f64,
}

/// The size of a sphere.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereShape {
    /// Its radius, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_m: f64,
}

impl Body {
    /// Its shape.
    pub fn shape(&self) -> FreeShape {
        match (self.cuboid, self.cylinder, self.sphere) {
            (Some(BoxShape { size_m }), ..) => FreeShape::Box { size_m },
            (_, Some(CylinderShape { radius_m, length_m }), _) => {
                FreeShape::Cylinder { radius_m, length_m }
            }
            // A checked scenario has one of the three.
            (.., of) => FreeShape::Sphere {
                radius_m: of.map_or(0.0, |of| of.radius_m),
            },
        }
    }

    /// Refuses a body without a shape or with several.
    fn object(&self, key: &str) -> Result<(), Objection> {
        let shapes = [
            self.cuboid.is_some(),
            self.cylinder.is_some(),
            self.sphere.is_some(),
        ];
        let name = &self.name;
        let help = "give it one of box = { size_m = [x, y, z] }, cylinder = { radius_m, length_m } and sphere = { radius_m }";
        match shapes.iter().filter(|is| **is).count() {
            1 => {}
            0 => {
                return Err(Objection::to(
                    key,
                    format!("body `{name}` has no shape"),
                    help,
                ));
            }
            _ => {
                let message = format!("body `{name}` has several shapes");
                return Err(Objection::to(key, message, help));
            }
        }
        let sizes = match self.cuboid {
            Some(of) if of.size_m.iter().any(|side| *side <= 0.0) => Some(of.size_m),
            _ => None,
        };
        match sizes {
            None => Ok(()),
            Some(sides) => Err(objection!(
                "{key}.box.size_m",
                "body `{name}` has the sides {sides:?}, but each must be above 0",
                "write its three sides in metres",
            )),
        }
    }
}

/// Refuses bodies with the same name, and without a shape or with several.
pub(super) fn object(bodies: &[Body]) -> Result<(), Objection> {
    for (index, body) in bodies.iter().enumerate() {
        let key = format!("world.bodies.{index}");
        let name = &body.name;
        let is_plain = |letter: char| letter.is_alphanumeric() || "_-".contains(letter);
        object_if!(
            name.is_empty() || !name.chars().all(is_plain),
            "{key}.name",
            "the body's name `{name}` cannot stand in the name of a column",
            "write letters, digits, _ and -",
        );
        object_if!(
            bodies[..index].iter().any(|other| other.name == *name),
            "{key}.name",
            "two bodies are called `{name}`",
            "give each a name of its own",
        );
        body.object(&key)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::{Error, scenario::Scenario};

    const RUN: &str = "robot.file = \"r.urdf\"\ntwist = {}\n[run]\nduration_s = 1.0\n";
    const BODY: &str = "[[world.bodies]]\nname = \"box\"\nmass_kg = 1\nx_m = 1\ny_m = 0\n";

    /// The objection to a scenario with these bodies, and the text that it points at; `None` if it
    /// is accepted.
    fn said(bodies: &str) -> Option<(String, String)> {
        let text = format!("{RUN}{bodies}");
        match Scenario::from_toml(&text, "test", "") {
            Ok(_) => None,
            Err(Error::Scenario(fault)) => {
                let span = fault.span.offset()..fault.span.offset() + fault.span.len();
                Some((fault.message.clone(), text[span].to_owned()))
            }
            Err(other) => panic!("{other:?}"),
        }
    }

    #[test]
    fn bodies_without_a_shape_a_name_or_a_size_are_refused() {
        let refused = |text: String, words: &str| {
            let (message, _) = said(&text).expect("it makes no sense");
            assert!(message.contains(words), "{message}");
        };
        let cube = format!("{BODY}box = {{ size_m = [0.1, 0.1, 0.1] }}\n");
        let ball = format!("{BODY}sphere = {{ radius_m = 0.1 }}\n").replace("\"box\"", "\"ball\"");
        assert_eq!(said(&format!("{cube}{ball}")), None);
        refused(BODY.to_owned(), "body `box` has no shape");
        refused(
            format!("{cube}sphere = {{ radius_m = 0.1 }}\n"),
            "several shapes",
        );
        refused(format!("{cube}{cube}"), "two bodies are called `box`");
        refused(
            cube.replace("\"box\"", "\"a b\""),
            "cannot stand in the name of a column",
        );
        refused(cube.replace("0.1, 0.1]", "0, 0.1]"), "each must be above 0");
        refused(cube.replace("mass_kg = 1", "mass_kg = 0"), "mass_kg");
        refused(format!("{cube}friction = -1\n"), "friction");
        refused(
            format!("{cube}[world.solver]\ncontacts = \"rapier\"\n"),
            "do not go together",
        );
    }
}
