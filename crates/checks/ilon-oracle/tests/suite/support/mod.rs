//! Robots, engines and runs of the tests.

#![allow(dead_code)]

pub mod linked;

use ilon_formats::LoadRobot;
use ilon_oracle::{ContactLaw, Drive, Engine, Generalised, LEVEL_GRAVITY_M_S2, Settings};
use ilon_robot::Robot;
use nalgebra::Vector3;

/// A robot of the project's assets.
pub fn robot(name: &str) -> Robot {
    let file = format!(
        "{}/../../../assets/robots/{name}.urdf",
        env!("CARGO_MANIFEST_DIR")
    );
    Robot::load(file).expect("the asset loads")
}

/// A robot whose bearings are ideal.
pub fn without_bearings(mut robot: Robot) -> Robot {
    for wheel in &mut robot.wheels {
        wheel.joint = Default::default();
        for roller in &mut wheel.rollers {
            roller.joint = Default::default();
        }
    }
    robot
}

/// An engine on a level floor.
pub fn engine(robot: &Robot, stiffness_n_m: f64, friction: f64, step_s: f64) -> Engine {
    let settings = Settings {
        step_s,
        contact: ContactLaw::stiff(stiffness_n_m, friction, robot),
        gravity_m_s2: LEVEL_GRAVITY_M_S2,
    };
    Engine::new(robot, settings).expect("the engine takes the robot")
}

/// Takes steps for a duration.
pub fn run(engine: &mut Engine, duration_s: f64) {
    let until_s = engine.time_s() + duration_s - 1e-9;
    while engine.time_s() < until_s {
        engine.step().expect("the motion stays finite");
    }
}

/// Sets all wheels to follow these rates.
pub fn follow(engine: &mut Engine, rates_rad_s: &[f64]) {
    for (wheel, target_rad_s) in rates_rad_s.iter().enumerate() {
        engine.drive(
            wheel,
            Drive::Rate {
                target_rad_s: *target_rad_s,
                gain_n_m_s: 0.3,
                limit_n_m: f64::INFINITY,
            },
        );
    }
}

/// Locks all wheels.
pub fn lock(engine: &mut Engine) {
    for wheel in 0..engine.wheel_angles_rad().len() {
        engine.drive(wheel, Drive::Locked);
    }
}

/// A chassis that moves with this velocity, all else at rest.
pub fn moving(engine: &Engine, linear: Vector3<f64>) -> Generalised {
    Generalised {
        linear,
        ..engine.speeds().clone()
    }
}
