//! Worlds of one thread share their work space: its remaining content has no effect on other
//! worlds.

use crate::support;

use ilon_robot::{Pose, Robot};
use ilon_world::{ContactSolver, Floor, GroundBox, RollerBodies, Settings, World};
use nalgebra::Vector3;
use support::{mecanum4, mecanum6, volksbot};

/// A world with its wheel torques, in N m.
struct Driven {
    world: World,
    torque_n_m: f64,
}

impl Driven {
    fn step(&mut self, times: usize) {
        let wheels = self.world.robot().wheel_rates_rad_s().len();
        let torques_n_m: Vec<f64> = (0..wheels)
            .map(|wheel| self.torque_n_m * (1.0 - 0.7 * wheel as f64))
            .collect();
        for _ in 0..times {
            self.world.robot_mut().apply(&torques_n_m);
            self.world.step();
        }
    }

    /// All of its readable state, to the bit.
    fn bits(&self) -> String {
        let (world, wheels) = (&self.world, self.world.robot().contacts().len());
        let spins: Vec<_> = (0..wheels)
            .map(|w| world.robot().roller_spins_rad_s(w))
            .collect();
        let energies = [world.slip_energy_j(), world.impact_energy_j()];
        let seen = (
            world.robot().state(),
            world.robot().contacts(),
            spins,
            energies,
        );
        // Rust prints enough digits to distinguish neighbouring numbers.
        format!("{seen:?} {:?}", world.robot().wheel_angles_rad())
    }
}

/// Robots with three, four and six wheels, rolling and sliding, on level ground and over a box,
/// with contacts of ilon and of rapier.
fn worlds() -> Vec<Driven> {
    let kerb = GroundBox {
        center_m: Vector3::zeros(),
        half_sides_m: Vector3::new(0.05, 3.0, 0.005),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    };
    let over_a_kerb = Floor {
        boxes: vec![kerb],
        ..Floor::default()
    };
    let slippery = Floor {
        friction: 0.05,
        ..Floor::default()
    };
    let ilon = Settings {
        dt_s: 2e-3,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    };
    let rapier = Settings {
        contacts: ContactSolver::Rapier,
        roller_bodies: RollerBodies::All,
        dt_s: 1e-3,
        ..Settings::default()
    };
    let driven = |robot: &Robot, floor: &Floor, settings: &Settings, torque_n_m: f64| Driven {
        world: World::new(robot, floor, Pose::default(), settings).expect("it stands"),
        torque_n_m,
    };
    vec![
        driven(&volksbot(), &Floor::default(), &ilon, 0.1),
        driven(&mecanum4(), &slippery, &ilon, 1.0),
        driven(&mecanum6(), &over_a_kerb, &ilon, 0.5),
        driven(&mecanum4(), &Floor::default(), &rapier, 0.3),
        driven(&mecanum4(), &Floor::default(), &ilon, 0.3),
    ]
}

#[test]
fn worlds_that_are_stepped_in_turn_go_as_each_does_alone() {
    const TURNS: usize = 40;
    let mut together = worlds();
    for _ in 0..TURNS {
        for one in &mut together {
            one.step(1);
        }
    }
    for (index, in_turn) in together.into_iter().enumerate() {
        let alone = std::thread::spawn(move || {
            let mut alone = worlds().swap_remove(index);
            alone.step(TURNS);
            alone
        });
        let alone = alone.join().expect("it can be stepped");
        assert_eq!(in_turn.bits(), alone.bits(), "world {index}");
    }
}

#[test]
fn a_world_that_goes_to_another_thread_goes_on_to_the_bit() {
    for (mut stays, mut goes) in worlds().into_iter().zip(worlds()) {
        stays.step(60);
        goes.step(30);
        let goes = std::thread::spawn(move || {
            // Another world has used this thread's work space.
            worlds()[1].step(5);
            goes.step(30);
            goes
        });
        let goes = goes.join().expect("it can be stepped");
        assert_eq!(stays.bits(), goes.bits());
    }
}
