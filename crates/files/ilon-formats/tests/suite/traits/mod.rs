//! Robot files in various styles, one trait per test: each is a valid robot written in another way.

mod bare_wheels;
use crate::common;
mod damage;
mod meshes;
mod shapes;
mod structure;

use common::SPEC;
use ilon_formats::{Fault, LoadRobot, Spec, generate};
use ilon_robot::Robot;

fn load(text: &str) -> Robot {
    Robot::from_urdf_str(text, "small.urdf").unwrap_or_else(|e| panic!("{e}"))
}

fn fault_of(text: &str) -> Fault {
    match Robot::from_urdf_str(text, "small.urdf") {
        Ok(_) => panic!("it loaded"),
        Err(error) => error.fault().clone(),
    }
}

/// The mecanum robot of 45 degrees with the body of the small one.
fn mecanum() -> String {
    let spec = SPEC
        .split("[wheels.ring]")
        .next()
        .expect("a description")
        .to_owned()
        + "[wheels.mecanum]\naxles_m = [0.2, -0.2]\nhalf_width_m = 0.25\ngamma_deg = 45.0\n";
    generate(&Spec::from_toml_str(&spec, "mecanum.toml").expect("a good description"))
        .expect("in range")
}

/// The same text with every roller collision replaced by one.
fn with_roller_collision(text: &str, collision: &str) -> String {
    let mut out = String::new();
    let mut in_roller = false;
    for line in text.lines() {
        if line.contains("<link name=") {
            in_roller = line.contains("_roller_");
            out.push_str(line);
            out.push('\n');
            if in_roller {
                out.push_str(collision);
                out.push('\n');
            }
        } else if !(in_roller && line.contains("<collision>")) {
            out.push_str(line);
            out.push('\n');
        }
    }
    out
}

fn remarked(robot: &Robot, subject: &str, text: &str) -> bool {
    robot
        .remarks
        .iter()
        .any(|r| r.subject == subject && r.text.contains(text))
}
