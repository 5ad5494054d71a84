//! A part of a step that is discarded, because its contacts could not be solved, has no effect.

use ilon_robot::{
    Body, BodyJoint, JointKind, JointRole, JointServo, MassProperties, Pose as PlanarPose, Robot,
};
use nalgebra::{Isometry3, Matrix3, Vector3};

use super::{World, shipped};
use crate::world::with_solver;
use crate::{Floor, MotorTorque, Settings};

/// An arm moved by servos, on driven rollers with play.
fn swinging() -> World {
    let mut robot: Robot = shipped("mecanum4");
    let mass = MassProperties {
        mass_kg: 0.5,
        center_of_mass_m: Vector3::new(0.3, 0.0, 0.0),
        inertia_kg_m2: Matrix3::identity() * 1e-3,
    };
    robot.joints.push(BodyJoint {
        name: "arm".into(),
        parent: None,
        kind: JointKind::Turns,
        body_from_joint: Isometry3::translation(0.0, 0.0, 0.1),
        body: Body {
            name: "arm".into(),
            mass,
            collisions: Vec::new(),
        },
        role: JointRole::Driven(JointServo::for_inertia(0.05)),
        limits: [f64::NEG_INFINITY, f64::INFINITY],
        damping: 0.0,
        friction: 0.0,
    });
    for wheel in &mut robot.wheels {
        wheel.surface.axial_play_m = 3e-4;
    }
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    let start = PlanarPose::default();
    World::new(&robot, &Floor::default(), start, &settings).expect("it stands on a plane")
}

/// The observable state of a world: poses, rates and energies, to the bit.
fn shown(world: &World) -> Vec<u64> {
    let energies = &world.energies;
    let body = &world.bodies[0];
    let mut rates = vec![0.0; body.tree.dofs()];
    body.state.write_rates(&mut rates);
    let poses = body.state.links().iter().map(|link| link.center_m.norm());
    let rollers = body.wheels.iter().flat_map(|wheel| &wheel.rollers);
    let rollers = rollers.flat_map(|roller| [roller.axial_rate_rad_s, roller.place_m()]);
    let servos = body.servos.iter().map(|servo| servo.target);
    let counted = [
        energies.slip_j,
        energies.spin_up_j,
        energies.impact_j,
        energies.motor_j,
        energies.bearing_j,
        energies.springs_j,
        energies.treads_j,
        world.contact_residual_m_s(),
    ];
    let all = rates.into_iter().chain(poses).chain(rollers);
    let all = all.chain(servos).chain(counted);
    all.map(f64::to_bits).collect()
}

/// One world takes each part at once, another first discards one of twice the length and one of the
/// same: both stay identical to the bit, including the arm's targets, the rollers on their axles
/// and all energies.
#[test]
fn what_is_given_up_leaves_no_trace() {
    let (mut at_once, mut anew) = (swinging(), swinging());
    for step in 0..400 {
        for (world, gives_up) in [(&mut at_once, false), (&mut anew, true)] {
            let dt_s = world.settings.dt_s;
            let body = &mut world.bodies[0];
            for (wheel, torque) in body.command.motors.iter_mut().enumerate() {
                *torque = MotorTorque::constant(if wheel % 2 == 0 { 0.3 } else { -0.2 });
            }
            for joint in 0..body.servos.len() {
                body.aim(joint, [0.4, 0.0, 0.0]);
            }
            if gives_up {
                for tried_s in [2.0 * dt_s, dt_s] {
                    with_solver(|solver| world.find_reactions(solver, tried_s));
                    world.give_up();
                }
            }
            with_solver(|solver| world.advance(solver, dt_s));
        }
        assert_eq!(shown(&at_once), shown(&anew), "step {step}");
    }
    // Robot and arm did move.
    assert!(at_once.bodies[0].state.velocity_m_s.norm() > 1e-3);
    assert!(at_once.bodies[0].state.joint_positions()[0] > 0.1);
}
