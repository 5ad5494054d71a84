//! Small robots on tyres, written as URDF.

use std::fmt::Write;

/// A robot's file as it grows: links of simple shapes, and their joints.
pub struct Urdf(String);

/// A wheel: where it stands on its parent, and how large it is.
#[derive(Clone, Copy)]
pub struct WheelPart<'a> {
    pub name: &'a str,
    pub parent: &'a str,
    pub at_m: [f64; 3],
    pub radius_m: f64,
    pub width_m: f64,
    /// Whether a motor drives it.
    pub is_driven: bool,
}

/// A body on an upright joint that carries a wheel.
#[derive(Clone, Copy)]
pub struct ForkPart<'a> {
    pub name: &'a str,
    pub at_m: [f64; 3],
    pub mass_kg: f64,
    /// About the upright axis, in kg m^2.
    pub inertia_kg_m2: f64,
    /// Whether a servo turns it.
    pub is_steered: bool,
}

impl Urdf {
    /// A chassis: a box of this mass with its centre of mass here, above the floor.
    pub fn new(mass_kg: f64, center_m: [f64; 3]) -> Self {
        let mut urdf = Self("<robot name=\"small\">\n".to_owned());
        let inertia = 0.05 * mass_kg;
        urdf.link("base_link", (mass_kg, center_m), [inertia; 3], "");
        urdf
    }

    fn link(
        &mut self,
        name: &str,
        (mass_kg, [x, y, z]): (f64, [f64; 3]),
        [xx, yy, zz]: [f64; 3],
        shape: &str,
    ) {
        writeln!(
            self.0,
            "<link name=\"{name}\"><inertial><origin xyz=\"{x} {y} {z}\"/><mass value=\"{mass_kg}\"/>\
             <inertia ixx=\"{xx}\" iyy=\"{yy}\" izz=\"{zz}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{shape}</link>"
        )
        .expect("written to memory");
    }

    fn joint(&mut self, name: &str, between: [&str; 2], at_m: [f64; 3], further: &str) {
        let [parent, child] = between;
        let [x, y, z] = at_m;
        writeln!(
            self.0,
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"{x} {y} {z}\"/>{further}</joint>"
        )
        .expect("written to memory");
    }

    /// Adds a body on an upright joint.
    pub fn fork(mut self, part: ForkPart<'_>) -> Self {
        let link = format!("{}_fork", part.name);
        let i = part.inertia_kg_m2;
        self.link(&link, (part.mass_kg, [0.0; 3]), [i; 3], "");
        let limit = if part.is_steered {
            "<limit effort=\"50\" velocity=\"12\"/>"
        } else {
            ""
        };
        let further = format!("<axis xyz=\"0 0 1\"/>{limit}");
        self.joint(part.name, ["base_link", &link], part.at_m, &further);
        self
    }

    /// Adds a wheel of a kilogram, on an axle along y.
    pub fn wheel(mut self, part: WheelPart<'_>) -> Self {
        let link = format!("{}_wheel", part.name);
        let (r, w) = (part.radius_m, part.width_m);
        let across = (3.0 * r * r + w * w) / 12.0;
        let shape = format!(
            "<collision><origin rpy=\"1.5707963267948966 0 0\"/><geometry>\
             <cylinder radius=\"{r}\" length=\"{w}\"/></geometry></collision>"
        );
        let inertia = [across, 0.5 * r * r, across];
        self.link(&link, (1.0, [0.0; 3]), inertia, &shape);
        let limit = if part.is_driven {
            "<limit effort=\"80\" velocity=\"60\"/>"
        } else {
            ""
        };
        let further = format!("<axis xyz=\"0 1 0\"/>{limit}");
        self.joint(part.name, [part.parent, &link], part.at_m, &further);
        self
    }

    /// The file.
    pub fn text(self) -> String {
        self.0 + "</robot>\n"
    }
}
