//! Joints between bodies: conservation in free flight, and springs, stops, friction and couplings
//! against closed-form mechanics.

use crate::support;

use std::f64::consts::TAU;

use ilon_oracle::{ContactLaw, Engine, LEVEL_GRAVITY_M_S2, OracleError, Settings};
use ilon_robot::{Coupling, JointKind, JointRole, JointSpring, Robot};
use nalgebra::{Translation3, Vector3};
use support::linked::{
    ARM_M, CARRIER_KG, STIFFNESS_N_M, joint, on_a_rocker, on_arms, on_slides, sprung,
};
use support::{engine, lock, robot, run, without_bearings};

const G: f64 = 9.81;

/// mecanum4 with a tilted slide on its chassis, an arm on that, and another arm on that one: two
/// carry wheels, the last swings freely.
fn on_a_chain() -> Robot {
    let mut robot = without_bearings(robot("mecanum4"));
    let at_m = |wheel: usize| robot.wheels[wheel].position_m();
    let slide = joint(
        (JointKind::Slides, sprung(800.0)),
        (at_m(0), Vector3::new(0.3, -0.2, 1.0)),
        (0.4, at_m(0) + Vector3::new(0.02, 0.03, -0.01)),
    );
    let mut arm = joint(
        (JointKind::Turns, sprung(3.0)),
        (at_m(1), Vector3::new(0.4, 1.0, 0.2)),
        (0.3, at_m(1) + Vector3::new(-0.05, 0.02, 0.04)),
    );
    arm.parent = Some(0);
    let mut tail = joint(
        (JointKind::Turns, JointRole::Free),
        (Vector3::new(0.1, 0.1, 0.1), Vector3::new(1.0, 0.1, -0.3)),
        (0.5, Vector3::new(0.15, 0.12, 0.2)),
    );
    tail.parent = Some(1);
    robot.joints = vec![slide, arm, tail];
    robot.wheels[0].carrier = Some(0);
    robot.wheels[1].carrier = Some(1);
    robot
}

/// High up, tumbling, with all joints, wheels and rollers moving.
fn thrown(robot: &Robot, step_s: f64) -> Engine {
    let mut engine = engine(robot, 1e3, 0.5, step_s);
    let mut pose = engine.world_from_body();
    pose.append_translation_mut(&Translation3::new(0.0, 0.0, 100.0));
    engine.set_world_from_body(pose);
    let mut speeds = engine.speeds().clone();
    speeds.angular = Vector3::new(4.0, -3.0, 2.0);
    speeds.linear = Vector3::new(1.0, 0.5, 3.0);
    speeds.wheels = vec![40.0, -25.0, 10.0, 30.0];
    for (index, rate) in speeds.rollers.iter_mut().enumerate() {
        *rate = 200.0 * (index as f64).sin();
    }
    for (index, rate) in speeds.joints.iter_mut().enumerate() {
        *rate = [0.4, 5.0, -8.0, 0.5][index];
    }
    engine.set_speeds(speeds);
    engine
}

/// Relative changes over half a second in momentum (less the impulse of gravity), angular momentum
/// and stored energy.
fn changes(robot: &Robot, step_s: f64) -> [f64; 3] {
    let kept = |engine: &Engine| {
        let turn = engine.world_from_body().rotation;
        let (motion, energy) = (engine.motion(), engine.energy());
        (
            turn * motion.momentum_in_body,
            turn * motion.spin_in_body,
            energy.kinetic_j + energy.gravity_j + energy.joint_springs_j,
        )
    };
    let mut engine = thrown(robot, step_s);
    let (before, kinetic_j) = (kept(&engine), engine.energy().kinetic_j);
    run(&mut engine, 0.5);
    let after = kept(&engine);
    let fallen = Vector3::z() * (-G * engine.mass_kg() * engine.time_s());
    [
        (after.0 - before.0 - fallen).norm() / before.0.norm(),
        (after.1 - before.1).norm() / before.1.norm(),
        (after.2 - before.2).abs() / kinetic_j,
    ]
}

#[test]
fn tumbling_on_joints_keeps_momentum_spin_and_energy() {
    for robot in [on_a_chain(), without_bearings(on_arms(0.0))] {
        let (coarse, fine) = (changes(&robot, 2e-4), changes(&robot, 5e-5));
        println!("{coarse:?} at 0.2 ms, {fine:?} at 0.05 ms");
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            // Second order, as without joints: rates of 40 rad/s in steps of 0.05 ms are 4e-6.
            assert!(fine < 4e-6, "{fine:e}");
            assert!(fine < 1e-12 || coarse > 12.0 * fine, "{coarse:e} {fine:e}");
        }
    }
}

/// Energy is conserved between the joints' springs, dampers, friction, stops and couplings, the
/// drives, the contacts and the bodies: the residual of the balance falls with the step.
#[test]
fn the_energy_of_all_that_acts_in_joints_closes() {
    let left = |step_s: f64| {
        let mut robot = on_a_chain();
        robot.joints[0].damping = 3.0;
        robot.joints[0].limits = [-0.004, 0.003];
        robot.joints[1].friction = 0.05;
        robot.joints[2].damping = 1e-3;
        robot.couplings = vec![Coupling {
            joint: 2,
            follows: 1,
            factor: -2.0,
            offset: 0.1,
        }];
        let mut engine = thrown(&robot, step_s);
        let (from_j, kinetic_j) = (engine.energy().balance_j(), engine.energy().kinetic_j);
        run(&mut engine, 0.2);
        let energy = engine.energy();
        (
            (energy.balance_j() - from_j).abs() / kinetic_j,
            energy.joints_j,
        )
    };
    let ((coarse, heat_j), (fine, _)) = (left(4e-5), left(1e-5));
    println!("{coarse:.2e} at 40 us, {fine:.2e} at 10 us; {heat_j} J became heat");
    assert!(heat_j > 0.05);
    // Dampers use old rates: first order. The landing on the stop takes 2 ms.
    assert!(fine < 1e-3 && fine < 0.5 * coarse, "{coarse:e} {fine:e}");
}

/// A standing robot's height above its start, its wheels locked.
fn settle(engine: &mut Engine, duration_s: f64) {
    lock(engine);
    run(engine, duration_s);
}

#[test]
fn springs_sag_by_the_chassis_over_their_stiffness_and_wheels_bear_a_quarter_each() {
    let robot = on_slides(120.0);
    let mut engine = engine(&robot, 2e6, 0.6, 1e-5);
    settle(&mut engine, 1.0);
    println!(
        "{:?} {:?}",
        engine.joint_positions(),
        engine.wheel_loads_n()
    );
    let sag_m = robot.chassis.mass.mass_kg * G / 4.0 / STIFFNESS_N_M;
    for position_m in engine.joint_positions() {
        assert!((position_m / sag_m - 1.0).abs() < 1e-5, "{position_m}");
    }
    for load_n in engine.wheel_loads_n() {
        assert!(
            (load_n / (robot.mass_kg() * G / 4.0) - 1.0).abs() < 1e-5,
            "{load_n}"
        );
    }
}

/// Arms whose middle lies 50 mm ahead of their wheels move the load of four carriers forward by as
/// much, and each spring bears its wheel's load at the arm's length, less the load on the arm
/// itself.
#[test]
fn trailing_arms_move_their_own_weight_forward_and_springs_bear_the_loads() {
    let robot = on_arms(120.0);
    let mut engine = engine(&robot, 2e6, 0.6, 1e-5);
    // Wheels are free: locked ones would push against each other as the arms swing.
    run(&mut engine, 1.5);
    let loads_n = engine.wheel_loads_n();
    println!("{:?} {loads_n:?}", engine.joint_positions());
    let wheel = &robot.wheels[0];
    let wheel_kg = wheel.hub.mass_kg + wheel.rollers.iter().map(|r| r.mass_kg).sum::<f64>();
    let base_m = robot.wheels[0].position_m().x - robot.wheels[2].position_m().x;
    // As the arms swing the wheels move ahead relative to the chassis.
    let ahead_m = ARM_M * (1.0 - engine.joint_positions()[0].cos());
    let moment = 0.5 * ARM_M * 4.0 * CARRIER_KG - ahead_m * robot.chassis.mass.mass_kg;
    let moved_n = moment * G / (2.0 * base_m);
    let (_, pitch, _) = engine.world_from_body().rotation.euler_angles();
    for (index, (turned, load_n)) in engine.joint_positions().iter().zip(&loads_n).enumerate() {
        let side = if index < 2 { 1.0 } else { -1.0 };
        let expected_n = robot.mass_kg() * G / 4.0 + side * moved_n;
        // A pitch of half a milliradian moves the chassis's middle by 40 um of 150 mm.
        assert!(
            (load_n / expected_n - 1.0).abs() < 3e-4,
            "{load_n} {expected_n}"
        );
        let lever_m = ARM_M * (turned + pitch).cos();
        let moment = ((load_n - wheel_kg * G) - 0.5 * CARRIER_KG * G) * lever_m;
        let held = STIFFNESS_N_M * ARM_M * ARM_M * turned;
        // Remaining oscillation, and the wheels' bearings.
        assert!((held / moment - 1.0).abs() < 1e-3, "{held} {moment}");
    }
}

/// A chassis of m on four springs k bounces at sqrt(4 k / m) and keeps its energy; its wheels stand
/// still.
#[test]
fn a_sprung_chassis_bounces_at_its_frequency() {
    let robot = on_slides(0.0);
    let (mass_kg, amplitude_m) = (robot.chassis.mass.mass_kg, 1e-3);
    let sag_m = mass_kg * G / 4.0 / STIFFNESS_N_M;
    let mut engine = engine(&robot, 2e7, 0.6, 4e-6);
    lock(&mut engine);
    let mut pose = engine.world_from_body();
    pose.append_translation_mut(&Translation3::new(0.0, 0.0, -sag_m - amplitude_m));
    engine.set_world_from_body(pose);
    engine.set_joint_positions(&[sag_m + amplitude_m; 4]);
    let from_j = engine.energy();
    let mut passes_s = Vec::new();
    let mut before_m = amplitude_m;
    while passes_s.len() < 11 {
        engine.step().expect("finite");
        let now_m = engine.joint_positions()[0] - sag_m;
        if before_m * now_m < 0.0 {
            passes_s.push(engine.time_s() - 4e-6 * now_m / (now_m - before_m));
        }
        before_m = now_m;
        assert!(engine.time_s() < 2.0);
    }
    let frequency_hz = 5.0 / (passes_s[10] - passes_s[0]);
    let expected_hz = (4.0 * STIFFNESS_N_M / mass_kg).sqrt() / TAU;
    println!("{frequency_hz} Hz, {expected_hz} expected");
    // In series are the floor's springs, 5000 times as stiff.
    assert!((frequency_hz / expected_hz - 1.0).abs() < 3e-4);
    let energy = engine.energy();
    let swinging_j = 0.5 * 4.0 * STIFFNESS_N_M * amplitude_m * amplitude_m;
    let lost_j = (energy.balance_j() - from_j.balance_j()).abs();
    println!(
        "{lost_j:e} J of {swinging_j} J, {:e} J in contacts",
        energy.contacts_j()
    );
    assert!(lost_j < 1e-3 * swinging_j);
}

#[test]
fn a_slide_without_a_spring_lies_on_its_stop() {
    let mut robot = on_slides(0.0);
    for joint in &mut robot.joints {
        joint.role = JointRole::Free;
        joint.limits = [-0.01, 0.004];
    }
    let mut engine = engine(&robot, 2e6, 0.6, 1e-5);
    let from_j = engine.energy().balance_j();
    settle(&mut engine, 0.5);
    println!(
        "{:?} {:?}",
        engine.joint_positions(),
        engine.wheel_loads_n()
    );
    for position_m in engine.joint_positions() {
        // The stop gives way by the chassis's weight over a stiffness at which one wheel and its
        // carrier oscillate as the robot does on the floor.
        assert!((0.004..0.0043).contains(position_m), "{position_m}");
    }
    for load_n in engine.wheel_loads_n() {
        assert!(
            (load_n / (robot.mass_kg() * G / 4.0) - 1.0).abs() < 2e-3,
            "{load_n}"
        );
    }
    // It fell by 4 mm: 0.39 J.
    let left_j = engine.energy().balance_j() - from_j;
    assert!(left_j.abs() < 4e-3, "{left_j}");
}

/// On a chassis too heavy to react, friction f slows a body of inertia J about its joint at f / J,
/// and then holds it.
#[test]
fn dry_friction_stops_a_joint_at_an_even_rate_and_holds_it() {
    let friction = 0.02;
    let mut robot = without_bearings(on_a_rocker(0.0));
    robot.joints[0].friction = friction;
    robot.chassis.mass.mass_kg *= 1e3;
    robot.chassis.mass.inertia_kg_m2 *= 1e3;
    let contact = ContactLaw {
        normal_damping_n_s_m: 0.0,
        bristle_damping_n_s_m: 0.0,
        bristle_stiffness_n_m: 1.0,
        ..ContactLaw::stiff(1e9, 0.5, &robot)
    };
    let settings = Settings {
        step_s: 5e-6,
        contact,
        gravity_m_s2: LEVEL_GRAVITY_M_S2,
    };
    let mut engine = Engine::new(&robot, settings).expect("the engine takes the robot");
    let mut pose = engine.world_from_body();
    pose.append_translation_mut(&Translation3::new(0.0, 0.0, 100.0));
    engine.set_world_from_body(pose);
    let mut speeds = engine.speeds().clone();
    speeds.joints = vec![2.0];
    engine.set_speeds(speeds);
    let inertia = 2.0 * engine.motion().kinetic_j / 4.0;
    let stop_s = 2.0 * inertia / friction;
    run(&mut engine, 0.5 * stop_s);
    let half = engine.speeds().joints[0];
    println!("{half} rad/s half way of {stop_s} s");
    // The chassis has 3000 times the rocker's inertia and takes that share.
    assert!((half - 1.0).abs() < 1e-3, "{half}");
    run(&mut engine, 0.6 * stop_s);
    let rest = engine.speeds().joints[0];
    assert!(rest.abs() < 1e-4, "{rest}");
    let heat_j = engine.energy().joints_j;
    assert!(
        (heat_j / (0.5 * inertia * 4.0) - 1.0).abs() < 1e-3,
        "{heat_j}"
    );
}

/// A differential bar turns one side's rocker as far back as the other's forward.
#[test]
fn a_coupling_keeps_two_joints_together() {
    let mut robot = robot("mecanum4");
    for (index, side) in [1.0, -1.0].into_iter().enumerate() {
        let middle_m = Vector3::new(0.0, side * 0.16, 0.1);
        let law = (JointKind::Turns, JointRole::Free);
        let mut rocker = joint(law, (middle_m, Vector3::y()), (0.3, middle_m));
        rocker.damping = 0.5;
        robot.joints.push(rocker);
        for wheel in &mut robot.wheels {
            if wheel.position_m().y * side > 0.0 {
                wheel.carrier = Some(index);
            }
        }
    }
    robot.couplings.push(Coupling {
        joint: 1,
        follows: 0,
        factor: -1.0,
        offset: 0.0,
    });
    // A load ahead of the middle: without the bar the chassis would tip over between its rockers.
    robot.chassis.mass.center_of_mass_m.x = 0.03;
    let apart = |stiffness_n_m: f64, step_s: f64| {
        let mut engine = engine(&robot, stiffness_n_m, 0.6, step_s);
        settle(&mut engine, 1.0);
        engine.joint_positions().iter().sum::<f64>()
    };
    let (soft, stiff) = (apart(2e6, 1e-5), apart(2e7, 3e-6));
    println!("{soft} {stiff}");
    // The bar holds the chassis with a spring as stiff as the floor: 0.3 mrad, and a tenth of it.
    assert!(soft.abs() < 1e-3, "{soft}");
    assert!((stiff / soft - 0.1).abs() < 3e-3, "{soft} {stiff}");
}

#[test]
fn what_the_oracle_cannot_move_is_refused_in_words() {
    let refused = |spoil: fn(&mut Robot)| {
        let mut robot = on_slides(1.0);
        spoil(&mut robot);
        let settings = Settings {
            step_s: 1e-5,
            contact: ContactLaw::stiff(2e6, 0.6, &robot),
            gravity_m_s2: LEVEL_GRAVITY_M_S2,
        };
        Engine::new(&robot, settings).expect_err("it is refused")
    };
    let named = |part: &str| part.to_owned();
    assert_eq!(
        refused(|robot| robot.joints[1].parent = Some(1)),
        OracleError::NoCarrier {
            part: named("joint")
        }
    );
    assert_eq!(
        refused(|robot| robot.wheels[0].carrier = Some(9)),
        OracleError::NoCarrier {
            part: named("front_left")
        }
    );
    let stiff = refused(|robot| {
        robot.joints[0].role = JointRole::Sprung(JointSpring {
            stiffness: 1e12,
            rest: 0.0,
            preload: 0.0,
        });
    });
    assert!(
        matches!(stiff, OracleError::StepTooLong { of: "joints", .. }),
        "{stiff}"
    );
}
