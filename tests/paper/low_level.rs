//! The two steps that section V leaves to future research, in the simulated world: priorities under
//! torque limits, and free torques used to spare grip.

use ilon_control::{
    ComputedTorque, ComputedTorqueSettings, Demand, DynamicModel, Kinematics, PrioritisedTorque,
    PrioritisedTorqueSettings, Priority, TorqueLaw, TorqueRange,
};
use ilon_robot::{Pose, Robot, Twist};
use ilon_world::{Floor, Settings, World};
use nalgebra::{Vector2, Vector3};

use crate::robots::shipped;

fn computed_torque(robot: &Robot, settings: &Settings) -> Box<dyn TorqueLaw> {
    let model = DynamicModel::new(robot).unwrap();
    let law_settings = ComputedTorqueSettings {
        bandwidth_rad_s: 20.0,
        target_filter_s: 0.0,
        dt_s: settings.dt_s,
    };
    Box::new(ComputedTorque::new(model, &law_settings).unwrap())
}

fn prioritised(robot: &Robot, settings: &Settings, friction: f64) -> Box<dyn TorqueLaw> {
    let law_settings = PrioritisedTorqueSettings {
        bandwidth_rad_s: 20.0,
        target_filter_s: 0.0,
        dt_s: settings.dt_s,
        priority: Priority::Position,
        reference_point_m: Vector2::zeros(),
        friction,
        gravity_m_s2: 9.81,
    };
    Box::new(PrioritisedTorque::new(robot, &law_settings).unwrap())
}

/// The end state of a run.
#[derive(Debug)]
struct Outcome {
    twist: Twist,
    slip_energy_j: f64,
}

/// Drives a robot from rest with targets that grow as `acceleration` for `ramp_s`.
fn drive(
    robot: &Robot,
    friction: f64,
    torque_n_m: f64,
    acceleration: Twist,
    ramp_s: f64,
    law: impl FnOnce(&Robot, &Settings) -> Box<dyn TorqueLaw>,
) -> Outcome {
    let settings = Settings::default();
    let floor = Floor {
        friction,
        ..Floor::default()
    };
    let mut law = law(robot, &settings);
    let mut world = World::new(robot, &floor, Pose::default(), &settings).unwrap();
    let kinematics = Kinematics::new(robot).unwrap();
    let n = robot.wheels.len();
    let limits = vec![
        TorqueRange {
            min_n_m: -torque_n_m,
            max_n_m: torque_n_m
        };
        n
    ];
    let mut targets = vec![0.0; n];
    for k in 0..((0.2 + ramp_s) / settings.dt_s).round() as usize {
        let t_s = (k as f64 * settings.dt_s - 0.2).max(0.0);
        kinematics.wheel_rates(acceleration.scaled(t_s), &mut targets);
        let rates = world.robot().wheel_rates_rad_s();
        let torques = law.update(&Demand::new(&targets, rates, &limits, settings.dt_s));
        world.robot_mut().apply(torques);
        world.step();
    }
    Outcome {
        twist: world.robot().state().twist_in_body,
        slip_energy_j: world.slip_energy_j(),
    }
}

#[test]
fn section_5_a_saturating_motor_slows_the_turn_and_not_the_sideways_motion() {
    // Robot A with 0.6 m/s^2 sideways and 6 rad/s^2 commanded at once, with motors of 0.1 N m that
    // allow one of the two. Position first: the sideways speed is that without any turn. Plain
    // clipping halves it.
    let robot = shipped("mecanum4");
    let (sideways, both) = (Twist::new(0.0, 0.6, 0.0), Twist::new(0.0, 0.6, 6.0));
    let by_priority =
        |robot: &Robot, settings: &Settings| prioritised(robot, settings, f64::INFINITY);
    let alone = drive(&robot, 0.8, 0.1, sideways, 0.4, by_priority);
    let kept = drive(&robot, 0.8, 0.1, both, 0.4, by_priority);
    let clipped = drive(&robot, 0.8, 0.1, both, 0.4, computed_torque);
    let share = |outcome: &Outcome| outcome.twist.vy_m_s / alone.twist.vy_m_s;
    println!(
        "sideways speed kept: by priority {:.3}, clipped {:.3}",
        share(&kept),
        share(&clipped)
    );
    assert!((share(&kept) - 1.0).abs() < 0.05, "{kept:?} {alone:?}");
    assert!(share(&clipped) < 0.7, "{clipped:?} {alone:?}");
    assert!(kept.twist.omega_rad_s > 0.1, "{kept:?}");
}

#[test]
fn section_5_free_torques_save_slip_on_a_slippery_floor() {
    // Robot A on a floor of friction 0.29, its mass centred 8 cm towards the front left wheel,
    // accelerating at 1 m/s^2. Eq. (12) distributes the forces equally and exceeds the grip of the
    // rear right wheel; distributed by load they stay within it.
    let mut robot = shipped("mecanum4");
    robot.chassis.mass.center_of_mass_m += Vector3::new(0.08, 0.08, 0.0);
    let wanted = Twist::new(0.9, 0.45, 0.0);
    let plain = drive(&robot, 0.29, 50.0, wanted, 0.5, computed_torque);
    let spared = drive(&robot, 0.29, 50.0, wanted, 0.5, |r, s| {
        prioritised(r, s, 0.29)
    });
    let gripping = drive(&robot, 0.8, 50.0, wanted, 0.5, computed_torque);
    let turned = |outcome: &Outcome| outcome.twist.omega_rad_s.abs();
    // Spinning up rollers at hand-overs costs energy on any floor.
    let slid_j = |outcome: &Outcome| outcome.slip_energy_j - gripping.slip_energy_j;
    println!(
        "slip energy: plain {:.2} mJ, by load {:.2} mJ, on a floor that grips {:.2} mJ; turn that nobody asked for: {:.4}, \
         {:.4} rad/s",
        1e3 * plain.slip_energy_j,
        1e3 * spared.slip_energy_j,
        1e3 * gripping.slip_energy_j,
        turned(&plain),
        turned(&spared)
    );
    // The law uses mean loads. At every hand-over the contact jumps along the roller and the loads
    // change by several N, so that a wheel still slides at times.
    assert!(slid_j(&spared) < 0.6 * slid_j(&plain));
    assert!(turned(&spared) < 0.3 * turned(&plain));
}
