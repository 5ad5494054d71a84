//! Landings, tilted robots, robots on their side: properties of contacts in any pose.

use ilon_robot::{Pose as PlanarPose, Robot};
use nalgebra::{UnitQuaternion, Vector3};

use super::super::standing::clearance_m;
use super::{World, shipped};
use crate::{Floor, RollerBodies, Settings};

fn world(robot: &Robot, dt_s: f64, bodies: RollerBodies) -> World {
    let settings = Settings {
        dt_s,
        roller_bodies: bodies,
        ..Settings::default()
    };
    World::new(robot, &Floor::default(), PlanarPose::default(), &settings)
        .expect("a robot above a plane")
}

/// Places a robot in an attitude, its lowest point at a height above the plane.
fn place(world: &mut World, rotation: UnitQuaternion<f64>, clear_m: f64) {
    let mut pose = *world.bodies[0].state.floor_from_chassis();
    pose.rotation = rotation;
    pose.translation.z = 1.0;
    world.bodies[0].state.place(pose);
    pose.translation.z += clear_m - clearance_m(&world.bodies[0], &world.ground);
    world.bodies[0].state.place(pose);
}

/// For any height of the fall and any time of landing within the step, the robot stays down.
#[test]
fn a_landing_does_not_bounce() {
    let robot = shipped("mecanum4");
    for (dt_s, bodies) in [(2.5e-3, RollerBodies::Near), (1e-3, RollerBodies::All)] {
        for drop_m in [1e-3_f64, 5e-3, 0.02, 0.05] {
            // Between the phases of the step the height of the fall differs by a part of the
            // displacement in one.
            let a_step_m = dt_s * (2.0 * 9.81 * drop_m).sqrt();
            for phase in 0..8 {
                let drop_m = drop_m + a_step_m * f64::from(phase) / 8.0;
                let mut world = world(&robot, dt_s, bodies);
                let rests_m = world.robot().state().height_m;
                place(&mut world, UnitQuaternion::identity(), drop_m);
                while world.robot().contacts().iter().all(|wheel| !wheel.touching) {
                    world.step();
                }
                let mut rebound_m = 0.0_f64;
                for _ in 0..(0.3 / dt_s) as usize {
                    world.step();
                    rebound_m = rebound_m.max(world.robot().state().height_m - rests_m);
                }
                assert!(
                    rebound_m < 0.01 * drop_m,
                    "{dt_s} s: {drop_m} m, rebound {rebound_m:.1e} m"
                );
            }
        }
    }
}

/// For m kg on four contacts of k N/m the damping ratio is tau sqrt(k / m): 0.58 for 300 kg at the
/// default. It returns exp(-pi 0.58 / sqrt(1 - 0.58^2)) = 0.11 of the speed, 1.1 % of the height;
/// numerical dissipation reduces that.
#[test]
fn a_heavy_robot_does_not_bounce_at_short_steps_either() {
    let mut robot = shipped("mecanum4");
    let more = 290.0 / robot.chassis.mass.mass_kg;
    robot.chassis.mass.mass_kg *= more;
    robot.chassis.mass.inertia_kg_m2 *= more;
    for dt_s in [1e-3, 2.5e-4] {
        let mut world = world(&robot, dt_s, RollerBodies::Near);
        let rests_m = world.robot().state().height_m;
        place(&mut world, UnitQuaternion::identity(), 0.02);
        while world.robot().contacts().iter().all(|wheel| !wheel.touching) {
            world.step();
        }
        let mut rebound_m = 0.0_f64;
        for _ in 0..(0.2 / dt_s) as usize {
            world.step();
            rebound_m = rebound_m.max(world.robot().state().height_m - rests_m);
        }
        assert!(rebound_m < 0.01 * 0.02, "{dt_s} s: {rebound_m:.1e} m");
    }
}

/// The lowest point of a tilted robot need not be that of the roller that hangs straight down. It
/// falls by 0.1 mm, and over onto its wheels or its side, while it scrapes along.
#[test]
fn tilted_it_comes_down_onto_what_is_lowest() {
    let robot = shipped("mecanum4");
    for (bodies, dt_s) in [
        (RollerBodies::Near, 1e-3),
        (RollerBodies::All, 1e-3),
        (RollerBodies::Near, 2.5e-4),
    ] {
        for tilt_deg in [12.0_f64, 20.0, 30.0, 37.0, 44.0, 52.0, 60.0] {
            for axis in [Vector3::x_axis(), Vector3::y_axis()] {
                let mut world = world(&robot, dt_s, bodies);
                let tilt = UnitQuaternion::from_axis_angle(&axis, tilt_deg.to_radians());
                place(&mut world, tilt, 1e-4);
                let mut deepest_m = 0.0_f64;
                while world.time_s() < 0.5 {
                    world.step();
                    deepest_m = deepest_m.max(world.robot().penetration_m());
                    let said = format!("{dt_s} s, {tilt_deg} degrees, {:.3} s", world.time_s());
                    // It meets the ground at sqrt(2 g 0.1 mm) = 0.044 m/s, with 11 kg on a spring
                    // of 1e8 N/m: 0.044 sqrt(11 / 1e8) = 15 um. It falls over by some centimetres,
                    // at 0.5 m/s, onto two wheels: 0.5 sqrt(5.5 / 2e8) = 80 um without the damper.
                    let most_m = if world.time_s() < 0.06 { 2e-5 } else { 6e-5 };
                    assert!(deepest_m < most_m, "{said}: {deepest_m:.1e} m");
                    let residual_m_s = world.contact_residual_m_s();
                    assert!(residual_m_s < 1e-6, "{said}: {residual_m_s:.1e} m/s");
                }
            }
        }
    }
}

/// A robot that stands nearly on its nose still has a heading: a rotation about the vertical.
#[test]
fn the_angles_of_the_body_keep_their_digits_however_steep_it_stands() {
    let robot = shipped("mecanum4");
    let mut world = world(&robot, 1e-3, RollerBodies::Near);
    for short_of_upright_rad in [1e-2_f64, 1e-3, 1e-5] {
        let pitch_rad = std::f64::consts::FRAC_PI_2 - short_of_upright_rad;
        place(
            &mut world,
            UnitQuaternion::from_euler_angles(0.4, pitch_rad, 1.1),
            0.1,
        );
        let body = world.robot().state();
        // The pitch keeps all its digits. Heading and roll are as uncertain as the last digit of
        // what is left of the cosine of the pitch.
        assert!(
            (body.pitch_rad - pitch_rad).abs() < 1e-14,
            "{} is not {pitch_rad}",
            body.pitch_rad
        );
        let off = [body.roll_rad - 0.4, body.pose.heading_rad - 1.1];
        let most = 1e-14 / short_of_upright_rad;
        assert!(
            off.iter().all(|off| off.abs() < most),
            "{off:?} at {short_of_upright_rad}"
        );
    }
}

/// On its sides, its back and its ends; on its free wheels it would roll on.
#[test]
fn a_robot_that_lies_comes_to_rest_and_stays_there() {
    let robot = shipped("mecanum4");
    for bodies in [RollerBodies::Near, RollerBodies::All] {
        for [roll_deg, pitch_deg] in [
            [80.0, 5.0],
            [-90.0, 0.0],
            [120.0, -30.0],
            [175.0, 10.0],
            [10.0, 89.0],
        ] {
            let [roll, pitch] = [roll_deg, pitch_deg].map(f64::to_radians);
            let attitude = UnitQuaternion::from_euler_angles(roll, pitch, 0.3);
            let mut world = world(&robot, 2.5e-3, bodies);
            place(&mut world, attitude, 0.01);
            for _ in 0..1200 {
                world.step();
            }
            let place_m = world.bodies[0].state.center_m();
            for _ in 0..400 {
                world.step();
            }
            let drift_m = (world.bodies[0].state.center_m() - place_m).norm();
            // The deflection of the contacts' springs is a micrometre.
            assert!(
                drift_m < 1e-6,
                "{roll_deg}, {pitch_deg}: {drift_m:.1e} m in a second"
            );
        }
    }
}
