//! Causes that every robot has: rollers, bearings, motors, wheel loops and a control period.

use std::f64::consts::TAU;

use ilon_robot::{Collision, Joint, JointRole, MotorLimits, Robot, Roller, RollersAsMade};

use super::list::{List, Run};
use crate::scenario::{Contacts, Kinematics, LoopTiming, Saturation, Scenario, WheelLaw};

/// A friction coefficient at which nothing slides. Chosen.
const HOLDS: f64 = 100.0;

/// Width of a tyre that resists no turn even with [`HOLDS`], over its radius. Chosen.
const THIN: f64 = 1e-5;

/// Factor on the gains of the wheel loops that makes them follow without lag. Chosen.
const AT_ONCE: f64 = 50.0;

/// Steps in a period of the steering servos that make modules follow without lag. Chosen: a world
/// needs 1.5, and as few as these are still calm.
const STEPS_A_SWING: f64 = 4.0;

/// Sliding, and the rollers with their bearings.
pub(super) fn of_rollers(scenario: &Scenario, robot: &Robot, list: &mut List) {
    let words = match (robot.has_tyres(), robot.caster_joints().is_empty()) {
        (false, _) => "sliding (replaced by unlimited grip)",
        (true, true) => "sliding (replaced by unlimited grip of tyres without width)",
        (true, false) => {
            "sliding (replaced by unlimited grip of tyres without width, and by casters without friction)"
        }
    };
    list.add("sliding", words, |scenario, robot| {
        never_slides(scenario);
        if robot.has_tyres() {
            grip_in_a_point(robot);
        }
    });
    let has_rollers = robot.wheels.iter().any(|wheel| !wheel.has_tyre());
    if has_rollers && scenario.guidance.kinematics == Kinematics::Ideal {
        list.add(
            "geometry",
            "the rollers' geometry (replaced by commands for the rollers that touch)",
            |scenario, _| scenario.guidance.kinematics = Kinematics::Contact,
        );
    }
    let any = |is: fn(&ilon_robot::Wheel) -> bool| robot.wheels.iter().any(is);
    if any(|wheel| wheel.made != RollersAsMade::default()) {
        list.add(
            "rollers.made",
            "the made shape of its rollers",
            |_, robot| {
                for wheel in &mut robot.wheels {
                    // Modelled rollers stay as they are.
                    let _ = wheel.make_rollers(RollersAsMade::default(), Some(1.0));
                }
            },
        );
    }
    if any(|wheel| wheel.surface.tread.is_some()) {
        list.add("rollers.tread", "the give of its treads", |_, robot| {
            for wheel in &mut robot.wheels {
                wheel.surface.tread = None;
            }
        });
    }
    if any(|wheel| wheel.surface.axial_play_m > 0.0) {
        list.add(
            "rollers.axial_play_m",
            "the play of its rollers",
            |_, robot| {
                for wheel in &mut robot.wheels {
                    wheel.surface.axial_play_m = 0.0;
                }
            },
        );
    }
    list.add("bearings", "the drag of its bearings", |_, robot| {
        for wheel in &mut robot.wheels {
            wheel.joint = Joint::default();
            wheel.surface.axle_friction = 0.0;
            for roller in &mut wheel.rollers {
                roller.joint = Joint::default();
            }
        }
    });
    let resists = any(|wheel| wheel.surface.rolling_resistance > 0.0);
    if resists || of_floor_resists(scenario) {
        list.add(
            "rolling_resistance",
            "rolling resistance",
            |scenario, robot| {
                for wheel in &mut robot.wheels {
                    wheel.surface.rolling_resistance = 0.0;
                }
                rolls_freely(scenario);
            },
        );
    }
}

/// Leaves of each tyre its middle, and of feet and casters no friction: with unlimited grip none of
/// them could turn or be dragged along.
fn grip_in_a_point(robot: &mut Robot) {
    for wheel in &mut robot.wheels {
        for tyre in wheel.rollers.iter_mut().filter(|roller| roller.is_tyre()) {
            let width_m = THIN * tyre.radius_m;
            let thin = Roller::tyre(&wheel.name, tyre.radius_m, width_m, 0.25 * width_m);
            if let Ok(thin) = thin {
                (tyre.form, tyre.length_m) = (thin.form, width_m);
            }
        }
    }
    for joint in robot.caster_joints() {
        without_friction(&mut robot.joints[joint].body.collisions);
    }
    without_friction(&mut robot.chassis.collisions);
}

fn without_friction(shapes: &mut [Collision]) {
    for shape in shapes {
        shape.friction = Some(0.0);
    }
}

/// Unlimited grip and no creep on every surface.
fn never_slides(scenario: &mut Scenario) {
    let floor = &mut scenario.world.floor;
    for patch in &mut floor.patches {
        (patch.friction, patch.creep) = (patch.friction.map(|_| HOLDS), None);
        (patch.sliding, patch.across) = (None, None);
    }
    floor.friction = floor.friction.map(|_| HOLDS);
    (floor.creep, floor.sliding, floor.across) = (None, None, None);
    for pair in scenario
        .materials
        .values_mut()
        .flat_map(|of| of.values_mut())
    {
        (pair.friction, pair.creep) = (HOLDS, 0.0);
        (pair.sliding, pair.across) = (None, None);
    }
    scenario
        .faults
        .retain(|fault| !matches!(fault, crate::scenario::Fault::FrictionChanged { .. }));
}

fn of_floor_resists(scenario: &Scenario) -> bool {
    let floor = &scenario.world.floor;
    let mut patches = floor
        .patches
        .iter()
        .filter_map(|patch| patch.rolling_resistance);
    let mut pairs = scenario.materials.values().flat_map(|of| of.values());
    floor.rolling_resistance.is_some_and(|it| it > 0.0)
        || patches.any(|it| it > 0.0)
        || pairs.any(|pair| pair.rolling_resistance > 0.0)
}

/// No rolling resistance on any surface.
fn rolls_freely(scenario: &mut Scenario) {
    let floor = &mut scenario.world.floor;
    floor.rolling_resistance = None;
    floor.against = None;
    for patch in &mut floor.patches {
        (patch.rolling_resistance, patch.against) = (None, None);
    }
    for pair in scenario
        .materials
        .values_mut()
        .flat_map(|of| of.values_mut())
    {
        (pair.rolling_resistance, pair.against) = (0.0, None);
    }
}

/// Whether a wheel has a motor, and that has limits: a free wheel without its limits would be driven.
fn has_bounded_motor(wheel: &ilon_robot::Wheel) -> bool {
    wheel.motor.effort_n_m != 0.0 && wheel.motor != MotorLimits::default()
}

/// What keeps the wheels from following their targets.
pub(super) fn of_drive(scenario: &Scenario, robot: &Robot, list: &mut List) {
    let guidance = &scenario.guidance;
    let is_limited =
        guidance.wheel_rate_limit_rad_s.is_some() || !guidance.wheel_rate_limits_rad_s.is_empty();
    if is_limited && guidance.saturation != Saturation::None {
        list.add(
            "guidance.saturation",
            "the limit on commanded wheel rates",
            |scenario, _| {
                scenario.guidance.saturation = Saturation::None;
            },
        );
    }
    if scenario.motors.dc.is_some() || robot.wheels.iter().any(has_bounded_motor) {
        list.add("motors", "the limits of its motors", |scenario, robot| {
            scenario.motors.dc = None;
            scenario.motors.wheels.clear();
            let bounded = robot
                .wheels
                .iter_mut()
                .filter(|wheel| has_bounded_motor(wheel));
            bounded.for_each(|wheel| wheel.motor = MotorLimits::default());
        });
    }
    let loses = |wheel: &ilon_robot::Wheel| {
        wheel.drive.gear_efficiency < 1.0 || wheel.drive.gear_friction_n_m > 0.0
    };
    if robot.wheels.iter().any(loses) {
        list.add("gears", "the losses of its gears", |_, robot| {
            for wheel in &mut robot.wheels {
                wheel.drive.gear_efficiency = 1.0;
                wheel.drive.gear_friction_n_m = 0.0;
            }
        });
    }
    let words = match scenario.wheel_loop.law {
        WheelLaw::Pid => {
            let counts = match scenario.sensors.encoders.counts_per_turn {
                Some(_) => " and the counts that they read",
                None => "",
            };
            return list.add(
                "wheel_loop",
                format!(
                    "the lag of the wheel loops{counts} (replaced by wheels that follow at once)"
                ),
                |scenario, _| {
                    let section = &mut scenario.wheel_loop;
                    section.timing = LoopTiming::Continuous;
                    (section.latency_s, section.period_s) = (None, None);
                    scenario.sensors.encoders.counts_per_turn = None;
                    section.proportional_n_m_s =
                        section.proportional_n_m_s.map(|gain| AT_ONCE * gain);
                },
            );
        }
        WheelLaw::ComputedTorque => "computed torque",
        WheelLaw::PrioritisedTorque => "torques by priority",
        WheelLaw::Passive => "the passive law",
    };
    list.add(
        "wheel_loop.law",
        format!("{words} (replaced by a loop for each wheel)"),
        |scenario, _| {
            let section = &mut scenario.wheel_loop;
            (section.law, section.passive) = (WheelLaw::Pid, None);
            (section.friction, section.period_s) = (None, None);
        },
    );
}

/// Casters, and modules that are not yet where they are sent.
pub(super) fn of_tyres(run: Run, list: &mut List) {
    let robot = run.robot;
    let casters = robot.caster_joints();
    // rapier does not know the friction of a shape of a robot.
    if !casters.is_empty() && run.scenario.world.solver.contacts == Contacts::Ilon {
        list.add(
            "casters",
            "its casters (replaced by feet without friction)",
            move |_, robot| {
                for joint in &casters {
                    without_friction(&mut robot.joints[*joint].body.collisions);
                }
            },
        );
    }
    let steering = steering_joints(robot);
    if !steering.is_empty() {
        let rate_rad_s = TAU / (STEPS_A_SWING * run.physics_dt_s);
        list.add(
            "steering",
            "the lag of its steering (replaced by steering that follows at once)",
            move |_, robot| {
                for joint in &steering {
                    follow_at_once(robot, *joint, rate_rad_s);
                }
            },
        );
    }
}

/// Gives a joint a servo without limits, critically damped, of this natural frequency in rad/s,
/// where its own is not faster.
fn follow_at_once(robot: &mut Robot, joint: usize, rate_rad_s: f64) {
    let inertia = robot.inertia_on_joint(joint);
    if let JointRole::Driven(servo) = &mut robot.joints[joint].role {
        (servo.effort, servo.rate_limit) = (f64::INFINITY, f64::INFINITY);
        servo.stiffness = servo.stiffness.max(inertia * rate_rad_s * rate_rad_s);
        servo.damping = servo.damping.max(2.0 * inertia * rate_rad_s);
    }
}

/// The joints that steer tyres. Wheels on rollers roll wherever theirs hold them.
pub(super) fn steering_joints(robot: &Robot) -> Vec<usize> {
    let wheels = robot.wheels.iter().filter(|wheel| wheel.has_tyre());
    let mut joints: Vec<usize> = wheels
        .filter_map(|wheel| robot.steering_of(wheel))
        .collect();
    joints.sort_unstable();
    joints.dedup();
    joints
}

/// The control period.
pub(super) fn of_control(scenario: &Scenario, physics_dt_s: f64, list: &mut List) {
    let period_s = scenario.run.control_dt_s;
    // A control period is a whole number of steps, and of periods of a loop that has shorter ones.
    let loop_s = scenario.wheel_loop.period_s;
    let unit_s = loop_s.filter(|loop_s| *loop_s < period_s);
    let steps = (period_s / unit_s.unwrap_or(physics_dt_s)).round() as u32;
    let parts = (2..=10).rev().find(|parts| steps.is_multiple_of(*parts));
    let Some(parts) = parts else {
        return;
    };
    let words = format!(
        "the control period of {} ms (replaced by {:.3} ms)",
        1e3 * period_s,
        1e3 * period_s / f64::from(parts)
    );
    list.add("run.control_dt_s", words, move |scenario, _| {
        let shorter_s = scenario.run.control_dt_s / f64::from(parts);
        // Loops that decide when encoders are read decide as often.
        if scenario.wheel_loop.period_s == Some(scenario.run.control_dt_s) {
            scenario.wheel_loop.period_s = Some(shorter_s);
        }
        scenario.run.control_dt_s = shorter_s;
    });
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;

    use super::*;

    fn scenario(lines: &str) -> Scenario {
        let text = format!("robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\n{lines}");
        Scenario::from_toml(&text, "test", "").expect("a scenario")
    }

    fn robot() -> Robot {
        let urdf = include_str!("../../../../../../assets/robots/mecanum4.urdf");
        Robot::from_urdf_str(urdf, "mecanum4").expect("a robot")
    }

    #[test]
    fn without_sliding_no_ground_creeps() {
        let patch = "{ friction = 0.2, creep = 0.01, x_m = 1.0, y_m = 0.0, length_x_m = 1.0, length_y_m = 1.0 }";
        let mut scenario = scenario(&format!(
            "world.floor = {{ creep = 0.02, patches = [{patch}] }}"
        ));
        never_slides(&mut scenario);
        let floor = &scenario.world.floor;
        assert_eq!((floor.creep, floor.patches[0].creep), (None, None));
        assert_eq!(floor.patches[0].friction, Some(HOLDS));
    }

    #[test]
    fn without_rolling_resistance_wheels_and_floor_have_none() {
        let mut scenario = scenario("world.floor.rolling_resistance = 0.03");
        let mut robot = robot();
        for wheel in &mut robot.wheels {
            wheel.surface.rolling_resistance = 0.02;
        }
        let mut list = List::default();
        of_rollers(&scenario, &robot, &mut list);
        let mut of_it = list.0.into_iter();
        let (_, without) = of_it
            .find(|(cause, _)| cause.key == "rolling_resistance")
            .expect("it resists");
        without(&mut scenario, &mut robot);
        let mut wheels = robot.wheels.iter();
        assert!(wheels.all(|wheel| wheel.surface.rolling_resistance == 0.0));
        assert!(!of_floor_resists(&scenario));
    }

    #[test]
    fn without_drag_neither_hubs_nor_rollers_have_any() {
        let (scenario, mut robot) = (scenario(""), robot());
        for wheel in &mut robot.wheels {
            wheel.joint.friction_n_m = 0.1;
            for roller in &mut wheel.rollers {
                roller.joint.damping_n_m_s = 0.1;
            }
        }
        let mut list = List::default();
        of_rollers(&scenario, &robot, &mut list);
        let bearings = list.0.iter().find(|(cause, _)| cause.key == "bearings");
        let mut scenario = scenario;
        bearings.expect("every robot has them").1(&mut scenario, &mut robot);
        for wheel in &robot.wheels {
            assert_eq!(wheel.joint, Joint::default());
            assert!(
                wheel
                    .rollers
                    .iter()
                    .all(|roller| roller.joint == Joint::default())
            );
        }
    }

    #[test]
    fn a_limit_of_commanded_rates_is_a_cause_also_if_it_is_of_each_wheel() {
        let of = |line: &str| {
            let mut list = List::default();
            of_drive(&scenario(line), &robot(), &mut list);
            list.0
                .iter()
                .any(|(cause, _)| cause.key == "guidance.saturation")
        };
        assert!(!of(""));
        assert!(of("guidance.wheel_rate_limit_rad_s = 9"));
        assert!(of("guidance.wheel_rate_limits_rad_s = [9, 9, 9, 9]"));
    }

    /// A period of 10 ms of steps of 1 ms is cut into ten parts, one of 12 ms into six, and one of
    /// 13 ms into none.
    #[test]
    fn a_control_period_is_cut_into_as_many_parts_as_steps_allow() {
        for (period_ms, parts) in [(10, Some(10)), (12, Some(6)), (13, None)] {
            let mut scenario = scenario(&format!(
                "run.control_dt_s = {}",
                1e-3 * f64::from(period_ms)
            ));
            let (before_s, mut robot) = (scenario.run.control_dt_s, robot());
            let mut list = List::default();
            of_control(&scenario, 1e-3, &mut list);
            assert_eq!(list.0.len(), usize::from(parts.is_some()));
            if let (Some(parts), Some((_, null))) = (parts, list.0.first()) {
                null(&mut scenario, &mut robot);
                assert_eq!(scenario.run.control_dt_s, before_s / f64::from(parts));
            }
        }
    }
}
