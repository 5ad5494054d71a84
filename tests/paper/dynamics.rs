//! Eq. (11) against the simulated robot: torque steps and the resulting motion.

use ilon_control::DynamicModel;
use ilon_robot::{Pose, Robot, Twist};
use ilon_world::{Floor, Settings, World};
use nalgebra::Vector3;

use crate::robots::shipped;

/// Torques on every wheel that accelerate the body only along `twist_rate` from rest, by the model.
fn torques_for(model: &DynamicModel, twist_rate: Twist) -> Vec<f64> {
    let n = model.kinematics().wheel_count();
    let (mut accelerations, mut torques) = (vec![0.0; n], vec![0.0; n]);
    model
        .kinematics()
        .wheel_rates(twist_rate, &mut accelerations);
    model.torques(&vec![0.0; n], &accelerations, &mut torques);
    torques
}

/// Twists after `time_s` of constant torques, of the model and of the simulated robot.
fn after_torque_step(robot: &Robot, twist_rate: Twist, time_s: f64) -> (Twist, Twist) {
    let settings = Settings::default();
    let model = DynamicModel::new(robot).unwrap();
    let torques = torques_for(&model, twist_rate);

    let mut world = World::new(robot, &Floor::default(), Pose::default(), &settings).unwrap();
    let n = robot.wheels.len();
    let settle = (0.2 / settings.dt_s) as usize;
    for _ in 0..settle {
        world.robot_mut().apply(&vec![0.0; n]);
        world.step();
    }
    let steps = (time_s / settings.dt_s).round() as usize;
    let mut twist = Vector3::zeros();
    let (mut rates, mut scratch) = (vec![0.0; n], vec![0.0; n]);
    for _ in 0..steps {
        world.robot_mut().apply(&torques);
        world.step();
        let now = Twist::new(twist.x, twist.y, twist.z);
        model.kinematics().wheel_rates(now, &mut rates);
        let rate = model.twist_rate(&rates, &torques, &mut scratch);
        twist += settings.dt_s * Vector3::new(rate.vx_m_s, rate.vy_m_s, rate.omega_rad_s);
    }
    (
        Twist::new(twist.x, twist.y, twist.z),
        world.robot().state().twist_in_body,
    )
}

/// Eq. (11) neglects that each roller has to be spun up when it touches down. The faster the robot
/// moves across its wheels, the more that costs: on mecanum wheels 0.7 to 1.1 % of the speed after
/// 1 s at 0.5 m/s^2 sideways, 2 % at 2 rad/s^2 in a turn. So the accelerations are compared over
/// the first 0.2 s, in which a wheel turns by about 11 degrees.
const STEP_S: f64 = 0.2;

/// Torque steps ahead, sideways and turning: the simulated robot gains the twist that the model
/// predicts, within 2 % of it, including couplings through an off-centre mass.
fn holds(name: &str, payload: bool) {
    let mut robot = shipped(name);
    if payload {
        // 3 kg more, which move the centre of mass off the middle.
        robot.chassis.mass.mass_kg += 3.0;
        robot.chassis.mass.center_of_mass_m += Vector3::new(0.04, 0.03, 0.0);
    }
    for wanted in [
        Twist::new(0.5, 0.0, 0.0),
        Twist::new(0.0, 0.5, 0.0),
        Twist::new(0.0, 0.0, 2.0),
    ] {
        let (foretold, real) = after_torque_step(&robot, wanted, STEP_S);
        // Turning counts by the speed of a point 0.25 m away, about where the wheels are.
        let size = |t: Twist| Vector3::new(t.vx_m_s, t.vy_m_s, 0.25 * t.omega_rad_s).norm();
        let off = size(real - foretold) / size(foretold);
        println!(
            "{name}, payload {payload}, {wanted:?}: off by {:.3} %",
            100.0 * off
        );
        assert!(
            off < 0.02,
            "{name} {wanted:?}: {foretold:?} against {real:?}"
        );
        // The torques were computed for this motion, so that the comparison is not one of small
        // numbers.
        assert!(size(foretold) > 0.9 * STEP_S * size(wanted));
    }
}

/// A rotor of 2e-5 kg m^2 behind a gear of 20:1 is 8e-3 kg m^2 at the wheel: an equivalent mass of
/// 4 x 8e-3 / rho^2 = 12.8 kg in addition to 11.4, in the model and in the world.
#[test]
fn eq_11_knows_the_rotors_behind_the_gears() {
    let mut robot = shipped("mecanum4");
    let bare = DynamicModel::new(&robot).unwrap();
    for wheel in &mut robot.wheels {
        wheel.drive.gear_ratio = 20.0;
        wheel.drive.rotor_inertia_kg_m2 = 2e-5;
    }
    let ahead = Twist::new(0.5, 0.0, 0.0);
    let more =
        torques_for(&DynamicModel::new(&robot).unwrap(), ahead)[0] / torques_for(&bare, ahead)[0];
    assert!(more > 2.0, "{more} times the torque");
    for wanted in [ahead, Twist::new(0.0, 0.5, 0.0), Twist::new(0.0, 0.0, 2.0)] {
        let (foretold, real) = after_torque_step(&robot, wanted, STEP_S);
        let off =
            (real - foretold).linear_m_s().norm() + 0.25 * (real - foretold).omega_rad_s.abs();
        let size = foretold.linear_m_s().norm() + 0.25 * foretold.omega_rad_s.abs();
        // As without a rotor, see STEP_S.
        assert!(
            off < 0.02 * size,
            "{wanted:?}: {foretold:?} against {real:?}"
        );
    }
}

/// A gear of efficiency 0.7 passes 0.7 T of a torque T, and 0.02 N m of friction in it reduces that
/// further: the robot moves as under that torque without a gear. The gear's loss is counted with
/// the bearings.
#[test]
fn a_gear_takes_its_share_of_the_torque() {
    let speed_m_s = |efficiency: f64, friction_n_m: f64, torque_n_m: f64| {
        let mut robot = shipped("mecanum4");
        for wheel in &mut robot.wheels {
            wheel.drive.gear_efficiency = efficiency;
            wheel.drive.gear_friction_n_m = friction_n_m;
        }
        let settings = Settings::default();
        let mut world = World::new(&robot, &Floor::default(), Pose::default(), &settings).unwrap();
        while world.time_s() < 0.5 {
            world.robot_mut().apply(&[torque_n_m; 4]);
            world.step();
        }
        let energies = (world.motor_energy_j(), world.bearing_energy_j());
        (world.robot().state().twist_in_body.vx_m_s, energies)
    };
    let (geared, (motor_j, geared_j)) = speed_m_s(0.7, 0.02, 0.2);
    let (bare, (_, bearing_j)) = speed_m_s(1.0, 0.0, 0.7 * 0.2 - 0.02);
    assert!(
        (geared - bare).abs() < 1e-6 * bare,
        "{geared} for {bare} m/s"
    );
    // 0.06 + 0.02 N m of 0.2, plus the bearings' own loss.
    let taken = (geared_j - bearing_j) / motor_j;
    assert!((taken - 0.4).abs() < 1e-4, "{taken} of the work");
}

#[test]
fn eq_11_foretells_the_accelerations_of_the_mecanum_robot() {
    holds("mecanum4", false);
    holds("mecanum4", true);
}

#[test]
fn eq_11_foretells_the_accelerations_of_the_volksbot() {
    holds("volksbot", false);
    holds("volksbot", true);
}

#[test]
fn eq_11_foretells_the_accelerations_of_six_wheels() {
    holds("mecanum6", false);
    holds("mecanum6", true);
}
