//! Builds the header of a run's trace.

use std::collections::BTreeMap;

use ilon_formats::Loaded;
use ilon_robot::{Robot, VisualMeshes, Wheel};
use ilon_trace::{Header, MotorLine, WheelHeader};

use crate::bodies;
use crate::faults;
use crate::ground::floor;
use crate::pilot::Pilot;
use ilon_scenario::scenario::{self, Scenario};
use ilon_scenario::{Error, Resolved};

/// The appearance of a robot, for the header of its trace.
#[derive(Default)]
pub struct Appearance<'a> {
    urdf: &'a str,
    looks: VisualMeshes,
}

impl<'a> Appearance<'a> {
    /// By the shapes in its file.
    pub fn by(urdf: &'a str) -> Self {
        Self {
            urdf,
            looks: VisualMeshes::default(),
        }
    }

    /// By its meshes too.
    pub fn of(loaded: &'a Loaded) -> Self {
        Self {
            urdf: &loaded.urdf,
            looks: loaded.visual_meshes(),
        }
    }
}

/// The header of a run before its first row.
pub fn header(
    resolved: &Resolved,
    robot: &Robot,
    seen: Appearance,
    pilot: &Pilot,
) -> Result<Header, Error> {
    let scenario = resolved.scenario();
    let limit_rad_s = resolved.wheel_rate_limit_rad_s();
    let standing = resolved.choices().joint_targets.standing(robot);
    Ok(Header {
        scenario_name: scenario.name.clone(),
        scenario_toml: scenario.to_toml()?,
        reference_point_m: pilot.reference_point_m().into(),
        task_names: pilot.task_names().iter().map(ToString::to_string).collect(),
        physics_dt_s: resolved.physics_dt_s(),
        control_dt_s: scenario.run.control_dt_s,
        record_every: scenario.run.record_every,
        control_periods: scenario.run.control_periods(),
        measure_from_s: pilot.measure_from_s(),
        measure_to_s: scenario.run.duration_s,
        wheel_rate_limit_rad_s: limit_rad_s.is_finite().then_some(limit_rad_s),
        open_loop: resolved.reference().is_none(),
        roller_angles: scenario.run.roller_angles_hz.is_some(),
        measured: pilot.is_measured(),
        imu: scenario.sensors.imu.is_some(),
        belief: resolved.belief_in_words(robot),
        storage: scenario.wheel_loop.law == scenario::WheelLaw::Passive,
        urdf: seen.urdf.to_owned(),
        looks: seen.looks,
        ground: Some(floor::ground(
            scenario,
            robot,
            resolved.choices().uneven.as_deref(),
        )?),
        bodies: bodies::header(scenario),
        faults: Some(faults::recorded(&scenario.faults, robot)?),
        announced: resolved.announced().cloned(),
        guidance: resolved
            .choices()
            .stability
            .as_ref()
            .map(|stability| stability.recorded(scenario)),
        dead_band_n_m: scenario.motors.dead_band_n_m,
        motor_line: scenario.motors.dc.map(|dc| MotorLine {
            stall_torque_n_m: dc.stall_torque_n_m,
            no_load_rate_rad_s: dc.no_load_rate_rad_s,
            current_limit_n_m: dc.current_limit_n_m,
        }),
        commands_by_contact: scenario.guidance.kinematics == scenario::Kinematics::Contact,
        versions: BTreeMap::from([("ilon".to_owned(), env!("CARGO_PKG_VERSION").to_owned())]),
        // Joint positions count from zero; the robot is drawn with its servos at their start.
        joints: Header::of_robot(robot).joints,
        wheels: wheels(scenario, &standing),
        ..Header::of_robot(&standing)
    })
}

/// The wheels of a robot, with the strengths of motors that differ.
fn wheels(scenario: &Scenario, robot: &Robot) -> Vec<WheelHeader> {
    let of = |wheel: &Wheel| {
        let strength = scenario.motors.wheels.get(&wheel.name);
        WheelHeader {
            motor_strength: strength.map(|of| [of.forwards, of.backwards]),
            is_steered: robot.steering_of(wheel).is_some() || robot.swivels(wheel),
            ..WheelHeader::of_wheel(wheel)
        }
    };
    robot.wheels.iter().map(of).collect()
}
