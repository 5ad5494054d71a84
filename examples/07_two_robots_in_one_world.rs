//! Two robots in one world: one drives into the other, whose motors are off, and pushes it along.
//! There is no scenario and no controller; the program steps the world itself.

use ilon::formats::LoadRobot;
use ilon::robot::{Pose, Robot};
use ilon::world::{Floor, MotorTorque, Settings, SharedRobot, World};

/// Motor torque per lag of the wheel's rate, in N m s/rad.
const GAIN_N_M_S: f64 = 0.2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = SharedRobot::from(&Robot::load("assets/robots/mecanum4.urdf")?);
    let behind = Pose::default();
    let ahead = Pose {
        x_m: 0.6,
        y_m: 0.05,
        heading_rad: 0.3,
    };
    let mut world = World::of_bodies(
        [(robot.clone(), behind), (robot, ahead)],
        &Floor::default(),
        &Settings::default(),
    )?;
    let ids: Vec<_> = world.bodies().collect();

    let steps_a_second = (1.0 / world.dt_s()).round() as usize;
    for step in 0..=3 * steps_a_second {
        if step % (steps_a_second / 2) == 0 {
            let [pushes, pushed] = [ids[0], ids[1]].map(|id| world.body(id).state());
            println!(
                "{:.1} s: the first at {:.3} m, {:.3} m/s; the second at {:.3} m, {:.3} m/s, turned by {:.1} deg",
                world.time_s(),
                pushes.pose.x_m,
                pushes.twist_in_body.vx_m_s,
                pushed.pose.x_m,
                pushed.twist_in_body.vx_m_s,
                pushed.pose.heading_rad.to_degrees(),
            );
        }
        let rates = world.body(ids[0]).wheel_rates_rad_s().iter();
        let motors: Vec<MotorTorque> = rates
            .map(|rate| MotorTorque::with_droop(GAIN_N_M_S * (6.0 - rate), GAIN_N_M_S))
            .collect();
        world.body_mut(ids[0]).drive(&motors);
        world.step();
    }
    // It drove 0.9 m, and the other stood 0.2 m ahead of it.
    assert!(world.body(ids[1]).state().pose.x_m > 0.9);
    Ok(())
}
