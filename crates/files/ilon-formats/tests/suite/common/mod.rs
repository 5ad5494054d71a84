//! A small valid robot, which the tests modify.

#![allow(dead_code)] // Each test binary uses a part.

use ilon_formats::{LoadOptions, Spec, generate};
use ilon_robot::{Collision, CollisionShape, MassProperties, Robot, Roller, RollerForm};
use nalgebra::Isometry3;

/// Changed load options.
pub fn options(change: impl FnOnce(&mut LoadOptions)) -> LoadOptions {
    let mut options = LoadOptions::default();
    change(&mut options);
    options
}

/// Three omni wheels on a ring.
pub const SPEC: &str = r#"
name = "small"
[chassis]
shape.box = { size_m = [0.3, 0.3, 0.1] }
mass_kg = 5.0
center_m = [0.0, 0.0, 0.06]
[wheel]
radius_m = 0.05
hub_mass_kg = 0.2
hub_radius_m = 0.03
hub_width_m = 0.04
motor_effort_n_m = 1.0
motor_velocity_rad_s = 20.0
[rollers]
per_row = 8
radius_m = 0.012
mass_kg = 0.01
[wheels.ring]
count = 3
distance_m = 0.2
gamma_deg = 0.0
"#;

/// Its URDF.
pub fn small() -> String {
    let spec = Spec::from_toml_str(SPEC, "small.toml").expect("a good description");
    generate(&spec).expect("a good description")
}

/// The line of the first occurrence of `needle`.
pub fn line_of(text: &str, needle: &str) -> usize {
    let at = text.find(needle).unwrap_or_else(|| panic!("no {needle}"));
    text[..at].matches('\n').count() + 1
}

/// A fingerprint of every number in a robot's model, equal if all are bit-identical: FNV-1a over
/// the bits.
pub fn fingerprint(robot: &Robot) -> u64 {
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    hash.text(&robot.name);
    hash.text(&robot.chassis.name);
    hash.mass(&robot.chassis.mass);
    for collision in &robot.chassis.collisions {
        hash.collision(collision);
    }
    for wheel in &robot.wheels {
        hash.text(&wheel.name);
        hash.pose(&wheel.body_from_hub);
        hash.mass(&wheel.hub);
        hash.numbers(&[
            wheel.radius_m,
            wheel.gamma_rad,
            wheel.motor.effort_n_m,
            wheel.motor.velocity_rad_s,
            wheel.joint.damping_n_m_s,
            wheel.joint.friction_n_m,
        ]);
        for roller in &wheel.rollers {
            hash.roller(roller);
        }
    }
    hash.0
}

struct Fnv(u64);

impl Fnv {
    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
        self.bytes(&[0]);
    }

    fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.bytes(&number.to_bits().to_le_bytes());
        }
    }

    fn pose(&mut self, pose: &Isometry3<f64>) {
        self.numbers(pose.translation.vector.as_slice());
        self.numbers(pose.rotation.coords.as_slice());
    }

    fn mass(&mut self, mass: &MassProperties) {
        self.numbers(&[mass.mass_kg]);
        self.numbers(mass.center_of_mass_m.as_slice());
        self.numbers(mass.inertia_kg_m2.as_slice());
    }

    fn collision(&mut self, collision: &Collision) {
        self.pose(&collision.body_from_shape);
        match &collision.shape {
            CollisionShape::Box { half_extents_m } => self.numbers(half_extents_m.as_slice()),
            CollisionShape::Cylinder { radius_m, length_m }
            | CollisionShape::Capsule { radius_m, length_m } => {
                self.numbers(&[*radius_m, *length_m]);
            }
            CollisionShape::Sphere { radius_m } => self.numbers(&[*radius_m]),
            CollisionShape::ConvexHull { points_m } => {
                for point in points_m.iter() {
                    self.numbers(point.coords.as_slice());
                }
            }
        }
    }

    fn roller(&mut self, roller: &Roller) {
        self.text(&roller.name);
        self.numbers(roller.center_in_hub_m.as_slice());
        self.numbers(roller.axis_in_hub.as_slice());
        self.numbers(&[
            roller.radius_m,
            roller.length_m,
            roller.mass_kg,
            roller.axial_inertia_kg_m2,
            roller.transverse_inertia_kg_m2,
            roller.joint.damping_n_m_s,
            roller.joint.friction_n_m,
        ]);
        if let RollerForm::AsModelled(modelled) = &roller.form {
            for shape in &modelled.shapes {
                self.collision(shape);
            }
            for part in modelled.profile.parts() {
                self.numbers(&[part.t_m, part.ring_m, part.ball_m]);
            }
        }
    }
}
