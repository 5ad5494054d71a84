//! Conserved quantities of a robot in free flight: the equations of motion without contacts.

use crate::support;

use ilon_oracle::{Engine, Generalised};
use nalgebra::{Translation3, Vector3};
use support::{engine, robot, run, without_bearings};

/// High up, tumbling, with wheels and rollers spinning.
fn tumbling(step_s: f64) -> Engine {
    let robot = without_bearings(robot("mecanum4"));
    let mut engine = engine(&robot, 1e3, 0.5, step_s);
    let mut pose = engine.world_from_body();
    pose.append_translation_mut(&Translation3::new(0.0, 0.0, 100.0));
    engine.set_world_from_body(pose);
    let rollers = engine.speeds().rollers.len();
    engine.set_speeds(Generalised {
        angular: Vector3::new(4.0, -3.0, 2.0),
        linear: Vector3::new(1.0, 0.5, 3.0),
        joints: Vec::new(),
        wheels: vec![40.0, -25.0, 10.0, 30.0],
        rollers: (0..rollers).map(|j| 200.0 * (j as f64).sin()).collect(),
    });
    engine
}

/// Linear and angular momentum in the world frame, and energy.
fn kept(engine: &Engine) -> (Vector3<f64>, Vector3<f64>, f64) {
    let turn = engine.world_from_body().rotation;
    let motion = engine.motion();
    let energy = engine.energy();
    (
        turn * motion.momentum_in_body,
        turn * motion.spin_in_body,
        energy.kinetic_j + energy.gravity_j,
    )
}

/// Relative changes over a second in momentum (less the impulse of gravity), angular momentum and
/// energy.
fn changes(step_s: f64) -> [f64; 3] {
    let mut engine = tumbling(step_s);
    let before = kept(&engine);
    run(&mut engine, 1.0);
    let after = kept(&engine);
    let fallen = Vector3::z() * (-9.81 * engine.mass_kg() * engine.time_s());
    let kinetic = tumbling(step_s).energy().kinetic_j;
    [
        (after.0 - before.0 - fallen).norm() / before.0.norm(),
        (after.1 - before.1).norm() / before.1.norm(),
        (after.2 - before.2).abs() / kinetic,
    ]
}

#[test]
fn tumbling_with_spinning_wheels_and_rollers_keeps_momentum_spin_and_energy() {
    let (coarse, fine) = (changes(4e-4), changes(1e-4));
    for (name, (coarse, fine)) in ["momentum", "spin", "energy"]
        .into_iter()
        .zip(coarse.into_iter().zip(fine))
    {
        println!("{name}: {coarse:.2e} at 0.4 ms, {fine:.2e} at 0.1 ms");
        // The scheme is of second order: (omega h)^2 with omega up to 40 rad/s is 1.6e-5 at 0.1 ms.
        // An error in any term of the equations of motion would leave a change of order 1.
        assert!(fine < 1.6e-5, "{name} changes by {fine:e}");
        // Sixteen times less at a quarter of the step; fifteen allows for the next order, unless
        // only rounding is left.
        assert!(
            fine < 1e-12 || coarse > 12.0 * fine,
            "{name}: {coarse:e}, {fine:e}"
        );
    }
}

#[test]
fn a_robot_that_is_thrown_falls_on_a_parabola() {
    let mut engine = tumbling(1e-4);
    let center = |engine: &Engine| {
        let pose = engine.world_from_body();
        pose.translation.vector + pose.rotation * engine.motion().center_in_body_m
    };
    let (from, momentum) = (center(&engine), kept(&engine).0);
    run(&mut engine, 0.5);
    let (t, velocity) = (engine.time_s(), momentum / engine.mass_kg());
    let expected = from + velocity * t + Vector3::z() * (-0.5 * 9.81 * t * t);
    let off_m = (center(&engine) - expected).norm();
    println!("off the parabola by {off_m:.2e} m");
    // Second order, as above: 1.6e-5 of a path of 2 m.
    assert!(off_m < 3.2e-5);
}

#[test]
fn bearings_stop_spinning_wheels_with_their_damping_constants() {
    // A wheel that spins on a free chassis, its rollers locked: the torque c q' slows the wheel and
    // turns the chassis in the opposite direction. All four wheels spin equally, so that the robot
    // only pitches. With J the inertia of one wheel about its axis and J_r that of the robot with
    // its wheels locked, the rate relative to the chassis falls as exp(-r t), r = c
    // (1 / J + 4 / (J_r - 4 J)).
    let robot = robot("mecanum4");
    let mut engine = engine(&robot, 1e3, 0.5, 1e-4);
    let mut pose = engine.world_from_body();
    pose.append_translation_mut(&Translation3::new(0.0, 0.0, 100.0));
    engine.set_world_from_body(pose);
    let at_rest = engine.speeds().clone();
    for roller in 0..at_rest.rollers.len() {
        engine.seize_roller(roller, true);
    }
    let mut spin_of = |speeds: Generalised| {
        engine.set_speeds(speeds);
        engine.motion().spin_in_body.y
    };
    let turning = Generalised {
        wheels: vec![1.0; 4],
        ..at_rest.clone()
    };
    let pitching = Generalised {
        angular: Vector3::y(),
        ..at_rest.clone()
    };
    let (j, j_robot) = (spin_of(turning) / 4.0, spin_of(pitching));
    let c = robot.wheels[0].joint.damping_n_m_s;
    let r = c * (1.0 / j + 4.0 / (j_robot - 4.0 * j));

    engine.set_speeds(Generalised {
        wheels: vec![20.0; 4],
        ..at_rest
    });
    run(&mut engine, 0.3);
    let expected = 20.0 * (-r * engine.time_s()).exp();
    for rate in &engine.speeds().wheels {
        println!("{rate} rad/s, {expected} expected");
        // A damper at the old rate gives (1 - r h)^(t / h) instead of the exponential: r^2 h t / 2
        // less, 2.4e-4 at r = 4 / s.
        assert!((rate / expected - 1.0).abs() < 3e-4);
    }
    // The torque is internal.
    assert!(engine.motion().spin_in_body.norm() < 1.001 * 20.0 * 4.0 * j);
}

#[test]
fn a_spinning_rollers_bearing_brakes_it_with_its_damping_constant() {
    // The hub is so much heavier than the roller that its reaction is negligible: exp(-c t / I).
    let robot = robot("mecanum4");
    let mut engine = engine(&robot, 1e3, 0.5, 1e-4);
    let mut pose = engine.world_from_body();
    pose.append_translation_mut(&Translation3::new(0.0, 0.0, 100.0));
    engine.set_world_from_body(pose);
    engine.drive(0, ilon_oracle::Drive::Locked);
    let mut speeds = engine.speeds().clone();
    speeds.rollers[0] = 100.0;
    engine.set_speeds(speeds);
    run(&mut engine, 0.5);
    let roller = &robot.wheels[0].rollers[0];
    let r = roller.joint.damping_n_m_s / roller.axial_inertia_kg_m2;
    let expected = 100.0 * (-r * engine.time_s()).exp();
    let rate = engine.speeds().rollers[0];
    println!("{rate} rad/s, {expected} expected");
    // The robot's own inertia is 0.1 kg m^2 against 6.5e-7, a relative reaction of 1e-5; the step
    // adds r^2 h t / 2 = 6e-5.
    assert!((rate / expected - 1.0).abs() < 1e-4);
}

#[test]
fn dry_friction_stops_a_wheel_at_an_even_rate_and_holds_it() {
    // The rate falls by f / J on a heavy chassis, J measured as above; then the wheel stands.
    let mut robot = without_bearings(robot("mecanum4"));
    for wheel in &mut robot.wheels {
        wheel.joint.friction_n_m = 0.01;
    }
    let mut engine = engine(&robot, 1e3, 0.5, 1e-5);
    let mut pose = engine.world_from_body();
    pose.append_translation_mut(&Translation3::new(0.0, 0.0, 100.0));
    engine.set_world_from_body(pose);
    let mut speeds = engine.speeds().clone();
    for roller in 0..speeds.rollers.len() {
        engine.seize_roller(roller, true);
    }
    // Front and rear turn in opposite directions, so that the chassis stands still.
    speeds.wheels = vec![10.0, 10.0, -10.0, -10.0];
    let kinetic_j = {
        engine.set_speeds(speeds);
        engine.motion().kinetic_j
    };
    let j = 2.0 * kinetic_j / (4.0 * 100.0);
    let stop_s = 10.0 * j / 0.01;
    run(&mut engine, 0.5 * stop_s);
    let half = engine.speeds().wheels[0];
    println!("{half} rad/s half way of {stop_s} s");
    // Steps of 10 us in 0.25 s.
    assert!((half - 5.0).abs() < 1e-3);
    run(&mut engine, 0.6 * stop_s);
    // The remaining rate, below that at which friction has its full value, halves in each step.
    assert!(engine.speeds().wheels.iter().all(|rate| rate.abs() < 1e-9));
}
