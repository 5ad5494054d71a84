//! Causes that a scenario names: faults, ground and bodies, moving joints, sensor errors.

use std::collections::BTreeMap;

use ilon_robot::{JointRole, Robot};
use ilon_trace::Header;

use super::list::{List, MOST_OF_A_KIND, Run};
use super::machine::steering_joints;
use crate::scenario::{Drives, Encoders, Floor, FloorPatch, Imu, ImuNoise, PoseSensor, Scenario};

/// Each fault by itself. The header lists the faults in the scenario's order.
pub(super) fn faults(header: &Header, list: &mut List) {
    let name_of = |wheel: usize| header.wheels.get(wheel).map(|wheel| wheel.name.as_str());
    for (index, fault) in header.faults.iter().flatten().enumerate() {
        list.add(
            format!("faults.{index}"),
            fault.words(name_of),
            move |scenario, _| {
                scenario.faults.remove(index);
            },
        );
    }
}

/// Obstacles on the floor, patches of other floor, and the slope.
pub(super) fn ground(floor: &Floor, list: &mut List) {
    let at = |x_m: f64, y_m: f64| format!("at ({x_m}, {y_m}) m");
    list.each(
        "world.floor.patches",
        &floor.patches,
        |scenario| &mut scenario.world.floor.patches,
        "patches of floor",
        |patch| {
            format!(
                "the patch of {} {}",
                of_patch(patch),
                at(patch.x_m, patch.y_m)
            )
        },
    );
    list.each(
        "world.floor.boxes",
        &floor.boxes,
        |scenario| &mut scenario.world.floor.boxes,
        "boxes on the floor",
        |one| {
            let high_mm = 1e3 * one.height_m;
            format!("the box {high_mm:.1} mm high {}", at(one.x_m, one.y_m))
        },
    );
    if !floor.ramps.is_empty() {
        list.add("world.floor.ramps", "the ramps", |scenario, _| {
            scenario.world.floor.ramps.clear();
        });
    }
    if !floor.stairs.is_empty() {
        list.add("world.floor.stairs", "the stairs", |scenario, _| {
            scenario.world.floor.stairs.clear();
        });
    }
    if floor.rough.is_some() {
        list.add("world.floor.rough", "the rough ground", |scenario, _| {
            scenario.world.floor.rough = None;
        });
    }
    if floor.height_map.is_some() {
        list.add(
            "world.floor.height_map",
            "the map of heights",
            |scenario, _| {
                scenario.world.floor.height_map = None;
            },
        );
    }
    if floor.slope_deg != 0.0 {
        list.add(
            "world.floor.slope_deg",
            format!("the slope of {}°", floor.slope_deg.abs()),
            |scenario, _| scenario.world.floor.slope_deg = 0.0,
        );
    }
}

/// Describes in which properties a patch differs from the floor.
fn of_patch(patch: &FloorPatch) -> String {
    let mut parts = Vec::new();
    if let Some(material) = &patch.material {
        parts.push(material.clone());
    }
    let numbers = [
        ("friction", patch.friction),
        ("rolling resistance", patch.rolling_resistance),
        ("creep", patch.creep),
    ];
    let given = numbers
        .iter()
        .filter_map(|(name, number)| Some((name, (*number)?)));
    parts.extend(given.map(|(name, number)| format!("{name} {number}")));
    if patch.nap_deg.is_some() {
        parts.push("a nap".to_owned());
    }
    match parts.is_empty() {
        true => "floor".to_owned(),
        false => parts.join(" and "),
    }
}

/// Free bodies, one at a time. Bodies that may lie on one another count as one cause.
pub(super) fn bodies(scenario: &Scenario, list: &mut List) {
    let bodies = &scenario.world.bodies;
    if bodies.iter().filter(|body| body.z_m.is_some()).count() > 1 {
        let words = format!("the {} bodies that lie about", bodies.len());
        return list.add("world.bodies", words, |scenario, _| {
            scenario.world.bodies.clear();
        });
    }
    list.each(
        "world.bodies",
        bodies,
        |scenario| &mut scenario.world.bodies,
        "bodies that lie about",
        |body| format!("the body `{}`", body.name),
    );
}

/// Joints that move, each held at its position at the start: those moved by setpoints (`sent`), or
/// the others. Coupled joints are held together; if there are many, all are held together. Casters
/// and the joints that steer wheels are other causes: a robot does not drive with these held.
pub(super) fn joints(run: Run, sent: bool, list: &mut List) {
    let robot = run.robot;
    let is_sent = |name: &str| {
        let asked = run.scenario.robot.joints.get(name);
        asked.is_some_and(|asked| !asked.setpoints.is_empty())
    };
    let all_together = !robot.couplings.is_empty();
    let rolls = [robot.caster_joints(), steering_joints(robot)].concat();
    let names = robot.joints.iter().map(|joint| joint.name.as_str());
    let any_sent = names.clone().any(is_sent);
    let chosen: Vec<usize> = match all_together {
        true if any_sent == sent => (0..robot.joints.len()).collect(),
        true => Vec::new(),
        false => names
            .enumerate()
            .filter(|(index, name)| is_sent(name) == sent && (sent || !rolls.contains(index)))
            .map(|(index, _)| index)
            .collect(),
    };
    let hold = |joints: &[usize]| {
        let stands =
            |joint: &usize| Some((robot.joints[*joint].name.clone(), *run.stands.get(*joint)?));
        let stands: BTreeMap<String, f64> = joints.iter().filter_map(stands).collect();
        move |_: &mut Scenario, robot: &mut Robot| {
            let joints = robot.joints.iter();
            let held: Vec<Option<f64>> = joints.map(|of| stands.get(&of.name).copied()).collect();
            *robot = robot.with_joints_held(&held);
        }
    };
    if chosen.len() > MOST_OF_A_KIND || (all_together && chosen.len() > 1) {
        let words = format!("the movement of its {} joints", chosen.len());
        return list.add("joints", words, hold(&chosen));
    }
    for joint in chosen {
        let name = &robot.joints[joint].name;
        list.add(
            format!("joints.{name}"),
            format!("the movement of the joint `{name}`"),
            hold(&[joint]),
        );
    }
}

/// Modules that a target holds where a twist or a reference would steer them.
pub(super) fn held_modules(run: Run, list: &mut List) {
    let scenario = run.scenario;
    let steers = |drives| matches!(drives, Drives::Twist | Drives::Path | Drives::Joints);
    let mut played = scenario.playback.iter();
    if !played.all(|played| steers(played.drives)) {
        return;
    }
    for joint in steering_joints(run.robot) {
        let name = run.robot.joints[joint].name.clone();
        let asked = scenario.robot.joints.get(&name);
        let Some(target_rad) = asked.and_then(|asked| asked.options.target_rad) else {
            continue;
        };
        let held_deg = ilon_trace::number(target_rad.to_degrees());
        list.add(
            format!("joints.{name}"),
            format!("the module `{name}` held at {held_deg} deg (replaced by one that is steered)"),
            move |scenario, robot| {
                if let Some(asked) = scenario.robot.joints.get_mut(&name) {
                    asked.options.target_rad = None;
                }
                let of = robot.joints.iter_mut().find(|of| of.name == name);
                if let Some(JointRole::Driven(servo)) = of.map(|of| &mut of.role) {
                    servo.target = 0.0;
                }
            },
        );
    }
}

/// Delay, low rate and noise of the sensors, and the latency of the wheel loops.
pub(super) fn sensors(scenario: &Scenario, list: &mut List) {
    let latency_s = scenario.wheel_loop.latency_s();
    if latency_s > 0.0 {
        list.add(
            "wheel_loop.latency_s",
            format!("the wheel loops' latency of {latency_s} s at these gains"),
            |scenario, _| scenario.wheel_loop.latency_s = None,
        );
    }
    let sensors = &scenario.sensors;
    let pose = &sensors.pose;
    if pose.position_noise_m > 0.0 || pose.heading_noise_deg > 0.0 {
        list.add(
            "sensors.pose.noise",
            "the noise of the pose sensor",
            |scenario, _| {
                let pose = &mut scenario.sensors.pose;
                (pose.position_noise_m, pose.heading_noise_deg) = (0.0, 0.0);
            },
        );
    }
    if pose.latency_s > 0.0 {
        list.add(
            "sensors.pose.latency_s",
            format!("the pose sensor's delay of {:.0} ms", 1e3 * pose.latency_s),
            |scenario, _| scenario.sensors.pose.latency_s = 0.0,
        );
    }
    if let Some(rate_hz) = pose.rate_hz {
        list.add(
            "sensors.pose.rate_hz",
            format!("the pose sensor's rate of {rate_hz} Hz"),
            |scenario, _| {
                scenario.sensors.pose = PoseSensor {
                    rate_hz: None,
                    ..scenario.sensors.pose.clone()
                };
            },
        );
    }
    if sensors.encoders != Encoders::default() {
        list.add(
            "sensors.encoders",
            "the noise and the steps of the encoders",
            |scenario, _| {
                scenario.sensors.encoders = Encoders::default();
            },
        );
    }
    let exact = ImuNoise::default();
    let is_noisy = |imu: &Imu| imu.accelerometer != exact || imu.gyroscope != exact;
    if sensors.imu.as_ref().is_some_and(is_noisy) {
        list.add(
            "sensors.imu",
            "the errors of the inertial unit",
            |scenario, _| {
                if let Some(imu) = &mut scenario.sensors.imu {
                    (imu.accelerometer, imu.gyroscope) = (ImuNoise::default(), ImuNoise::default());
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a scenario leaves at zero is no cause.
    #[test]
    fn a_property_of_the_sensors_is_a_cause_where_it_is_given() {
        let keys_of = |line: &str| {
            let text = format!("robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\n{line}");
            let scenario = Scenario::from_toml(&text, "test", "").expect("a scenario");
            let mut list = List::default();
            sensors(&scenario, &mut list);
            let keys = list.0.into_iter().map(|(cause, _)| cause.key);
            keys.collect::<Vec<String>>()
        };
        assert!(keys_of("").is_empty());
        for (key, value) in [("latency_s", "0.1"), ("rate_hz", "20")] {
            let key = format!("sensors.pose.{key}");
            assert_eq!(keys_of(&format!("{key} = {value}")), [key]);
        }
        for noise in ["position_noise_m", "heading_noise_deg"] {
            let line = format!("sensors.pose.{noise} = 0.1");
            assert_eq!(keys_of(&line), ["sensors.pose.noise"]);
        }
    }
}
