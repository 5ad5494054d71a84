//! What the engine refuses, and what it tolerates.

use crate::support;

use ilon_oracle::{ContactLaw, Engine, LEVEL_GRAVITY_M_S2, OracleError, Push, Settings};
use ilon_robot::{Collision, CollisionShape, ModelledRoller, Profile, ProfilePart, RollerForm};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use support::{engine, follow, lock, robot, run};

fn settings(step_s: f64) -> Settings {
    Settings {
        step_s,
        contact: ContactLaw::stiff(2e6, 0.6, &robot("mecanum4")),
        gravity_m_s2: LEVEL_GRAVITY_M_S2,
    }
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let robot = robot("mecanum4");
    let refused = |settings| match Engine::new(&robot, settings) {
        Err(OracleError::Setting { setting, .. }) => setting,
        other => panic!("{other:?}"),
    };
    for step_s in [0.0, -1e-5, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(settings(step_s)), "step_s");
    }
    let with = |change: fn(&mut ContactLaw)| {
        let mut settings = settings(1e-5);
        change(&mut settings.contact);
        refused(settings)
    };
    assert_eq!(
        with(|law| law.normal_stiffness_n_m = 0.0),
        "normal_stiffness_n_m"
    );
    assert_eq!(
        with(|law| law.bristle_stiffness_n_m = f64::NAN),
        "bristle_stiffness_n_m"
    );
    assert_eq!(
        with(|law| law.normal_damping_n_s_m = -1.0),
        "normal_damping_n_s_m"
    );
    assert_eq!(
        with(|law| law.bristle_damping_n_s_m = f64::INFINITY),
        "bristle_damping_n_s_m"
    );
    assert_eq!(with(|law| law.friction = -0.1), "friction");
}

#[test]
fn a_step_that_the_springs_outrun_is_refused_with_one_that_works() {
    let robot = robot("mecanum4");
    let Err(OracleError::StepTooLong { longest_s, .. }) = Engine::new(&robot, settings(1e-4))
    else {
        panic!("a step of 0.1 ms is taken");
    };
    // And that step is stable: the robot comes to rest, and its wheels carry its weight.
    let mut engine = Engine::new(&robot, settings(longest_s)).expect("the longest step is taken");
    lock(&mut engine);
    run(&mut engine, 0.5);
    let weight_n: f64 = engine.wheel_loads_n().iter().sum();
    assert!((weight_n / (9.81 * engine.mass_kg()) - 1.0).abs() < 1e-6);
    assert!(engine.motion().kinetic_j < 1e-12);
}

#[test]
fn rollers_with_the_shapes_of_their_file_are_refused_by_name() {
    let mut robot = robot("mecanum4");
    let part = ProfilePart {
        t_m: 0.0,
        ring_m: 0.0,
        ball_m: 0.012,
    };
    robot.wheels[1].rollers[3].form = RollerForm::AsModelled(ModelledRoller {
        shapes: vec![Collision {
            friction: None,
            body_from_shape: Isometry3::identity(),
            shape: CollisionShape::Sphere { radius_m: 0.012 },
        }],
        profile: Profile::new(vec![part]).expect("a part"),
    });
    let name = robot.wheels[1].rollers[3].name.clone();
    let refused = Engine::new(&robot, settings(1e-5)).err();
    assert_eq!(refused, Some(OracleError::NoBarrel { roller: name }));
}

#[test]
fn parts_that_cannot_turn_are_refused_by_name() {
    let refused = |change: fn(&mut ilon_robot::Wheel)| {
        let mut robot = robot("mecanum4");
        change(&mut robot.wheels[2]);
        Engine::new(&robot, settings(1e-5)).err()
    };
    let names = robot("mecanum4").wheels[2].clone();
    let part = names.name.clone();
    let no_hub = refused(|wheel| wheel.hub.inertia_kg_m2.fill(0.0));
    assert_eq!(no_hub, Some(OracleError::NoInertia { part }));
    let part = names.rollers[0].name.clone();
    let no_roller = refused(|wheel| wheel.rollers[0].axial_inertia_kg_m2 = 0.0);
    assert_eq!(no_roller, Some(OracleError::NoInertia { part }));
}

#[test]
fn a_motion_that_is_not_finite_is_an_error_and_no_panic() {
    let robot = robot("mecanum4");
    for force in [f64::NAN, f64::INFINITY] {
        let mut engine = engine(&robot, 2e6, 0.6, 1e-5);
        engine.push(Some(Push {
            force_in_world_n: Vector3::x() * force,
            point_in_body_m: Vector3::zeros(),
        }));
        let failed = (0..10).find_map(|_| engine.step().err());
        assert!(
            matches!(failed, Some(OracleError::Diverged { .. })),
            "{failed:?}"
        );
    }
}

#[test]
fn without_friction_wheels_spin_and_the_robot_stays() {
    let robot = robot("mecanum4");
    let mut engine = engine(&robot, 2e6, 0.0, 1e-5);
    follow(&mut engine, &[20.0, 20.0, 20.0, 20.0]);
    run(&mut engine, 0.3);
    assert!(engine.speeds().wheels.iter().all(|rate| *rate > 19.0));
    // Bearing torques of the wheels pitch the chassis on its springs by several um; they do not
    // turn the robot.
    assert!(engine.world_from_body().translation.vector.xy().norm() < 1e-4);
    assert_eq!(engine.energy().slip_j, 0.0);
}

#[test]
fn every_shipped_robot_stands_on_any_wheel_angle_and_heading() {
    for name in [
        "mecanum4",
        "mecanum4_6_rollers",
        "mecanum4_12_rollers",
        "mecanum6",
        "volksbot",
    ] {
        let robot = robot(name);
        let mut engine = engine(&robot, 2e6, 0.6, 1e-5);
        let angles: Vec<f64> = (0..robot.wheels.len())
            .map(|w| 0.7 * w as f64 - 1.0)
            .collect();
        engine.set_wheel_angles_rad(&angles);
        let mut pose = engine.world_from_body();
        pose.rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 2.2);
        engine.set_world_from_body(pose);
        lock(&mut engine);
        run(&mut engine, 0.3);
        let loads = engine.wheel_loads_n();
        let weight_n: f64 = loads.iter().sum();
        assert!(
            (weight_n / (9.81 * engine.mass_kg()) - 1.0).abs() < 1e-4,
            "{name}: {loads:?}"
        );
        let moved = engine.world_from_body().translation.vector.xy().norm();
        println!("{name}: {loads:.2?} N, moved by {moved:.1e} m");
        assert!(moved < 1e-5, "{name}");
    }
}

#[test]
fn a_tilted_robot_lands_on_its_wheels_and_rests() {
    // Dropped from 20 mm, tilted by 12 deg: it lands on one wheel after the other, dissipates the
    // energy of the fall, and stands.
    let robot = robot("mecanum4");
    let mut engine = engine(&robot, 2e6, 0.6, 1e-5);
    lock(&mut engine);
    let mut pose = engine.world_from_body();
    pose.translation.vector.z += 0.08;
    pose.rotation = UnitQuaternion::from_euler_angles(0.15, 0.15, 0.0);
    engine.set_world_from_body(pose);
    let before = engine.energy();
    run(&mut engine, 1.5);
    let after = engine.energy();
    let loads = engine.wheel_loads_n();
    println!("{loads:.3?} N, {after:?}");
    assert!(loads.iter().all(|load| *load > 20.0) && after.kinetic_j < 1e-4);
    let fallen_j = before.gravity_j - after.gravity_j;
    assert!((after.contacts_j() / fallen_j - 1.0).abs() < 1e-2);
}
