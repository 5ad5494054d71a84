//! Robots under wheel loops, stepped by hand.

use ilon_robot::{Pose, Robot, Twist};
use ilon_world::{Floor, MotorTorque, Push, Relief, RollerBodies, Settings, World};
use nalgebra::Vector3;

use super::{Drive, drive, ideal_rates, mecanum4};

/// Gravity, in m/s^2.
pub const G: f64 = 9.81;

/// Steps at a rate in Hz, with only the rollers near the ground.
pub fn near(hz: f64) -> Settings {
    Settings {
        dt_s: 1.0 / hz,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    }
}

/// Like [`near`], with all rollers.
pub fn all(hz: f64) -> Settings {
    Settings {
        roller_bodies: RollerBodies::All,
        ..near(hz)
    }
}

/// Drives with loops that act within the step, so that they are stable at any step.
pub fn run(
    robot: &Robot,
    command: [f64; 3],
    heading_deg: f64,
    floor: &Floor,
    settings: &Settings,
) -> Drive {
    drive(
        robot,
        command,
        heading_deg.to_radians(),
        floor,
        settings,
        0.1,
        1.0,
    )
}

/// A robot under per-wheel PI loops, stepped by hand.
pub struct Rig {
    pub world: World,
    pub integral: Vec<f64>,
    pub targets: Vec<f64>,
    pub proportional_n_m_s: f64,
}

impl Rig {
    pub fn new(robot: &Robot, floor: &Floor, heading_deg: f64, settings: &Settings) -> Self {
        let start = Pose {
            heading_rad: heading_deg.to_radians(),
            ..Pose::default()
        };
        let n = robot.wheels.len();
        Self {
            world: World::new(robot, floor, start, settings).expect("a valid world"),
            integral: vec![0.0; n],
            targets: vec![0.0; n],
            proportional_n_m_s: 0.1,
        }
    }

    pub fn run_s(&mut self, duration_s: f64) {
        let dt_s = self.world.dt_s();
        for _ in 0..(duration_s / dt_s).round() as usize {
            let rates = self.world.robot().wheel_rates_rad_s().to_vec();
            let torques: Vec<f64> = (0..rates.len())
                .map(|i| {
                    let error = self.targets[i] - rates[i];
                    self.integral[i] += error * dt_s;
                    self.proportional_n_m_s * error + self.integral[i]
                })
                .collect();
            self.world.robot_mut().apply(&torques);
            self.world.step();
        }
    }

    pub fn push_s(&mut self, torques: &[f64], duration_s: f64) {
        for _ in 0..(duration_s / self.world.dt_s()).round() as usize {
            self.world.robot_mut().apply(torques);
            self.world.step();
        }
    }

    pub fn twist(&self) -> Twist {
        self.world.robot().state().twist_in_body
    }

    pub fn pose(&self) -> Pose {
        self.world.robot().state().pose
    }
}

/// A bumpy surface, 2 mm high, from a small linear congruential generator.
pub fn bumps(seed: u64) -> Floor {
    let mut state = seed;
    let mut height_m = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        0.002 * (state >> 33) as f64 / f64::from(1u32 << 31)
    };
    let heights_m = (0..61)
        .map(|_| (0..61).map(|_| height_m()).collect())
        .collect();
    Floor {
        relief: Some(Relief {
            cell_m: 0.05,
            center_m: Default::default(),
            heights_m,
        }),
        ..Floor::default()
    }
}

/// Drives ahead for 4 s at 0.3 m/s and returns the robot's final pose.
pub fn end_of_course(floor: &Floor, settings: &Settings) -> (Pose, Rig) {
    let robot = mecanum4();
    let mut rig = Rig::new(&robot, floor, 0.0, settings);
    rig.run_s(0.5);
    rig.targets = ideal_rates(&robot, Twist::new(0.3, 0.0, 0.0));
    rig.run_s(3.0);
    (rig.pose(), rig)
}

/// Drives for a time: wheels follow a twist with 1 N m s/rad, which grows over the first half
/// second of the world; `pull_n` pulls on the middle of the robot along its own x, at the height of
/// the ground.
pub fn follow(world: &mut World, robot: &Robot, twist: Twist, time_s: f64, pull_n: f64) {
    let targets = ideal_rates(robot, twist);
    let steps = (time_s / world.dt_s()).round() as usize;
    for _ in 0..steps {
        let share = (world.time_s() / 0.5).min(1.0);
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let motor =
            |(target, rate): (&f64, &f64)| MotorTorque::with_droop(share * target - rate, 1.0);
        let motors: Vec<_> = targets.iter().zip(&rates).map(motor).collect();
        world.robot_mut().drive(&motors);
        let heading_rad = world.robot().state().pose.heading_rad;
        world.robot_mut().push(&Push {
            force_in_world_n: share
                * pull_n
                * Vector3::new(heading_rad.cos(), heading_rad.sin(), 0.0),
            place_in_body_m: Vector3::zeros(),
        });
        world.step();
    }
}
