//! Fast bodies: contacts are searched as far ahead as the body may move in a step, and it stops at
//! the surface.

use crate::support;

use ilon_robot::{Collision, CollisionShape, Pose, Robot, RollersAsMade};
use ilon_world::{Floor, GroundBox, Push, Relief, Settings, World};
use nalgebra::{Isometry3, Vector3};
use support::mecanum4;

/// Rollers that are cylinders, by numbers.
fn on_cylinders() -> Robot {
    let mut robot = mecanum4();
    let made = RollersAsMade {
        profile_m: Some(vec![[-0.016, 0.012], [0.016, 0.012]]),
        ..RollersAsMade::default()
    };
    for wheel in &mut robot.wheels {
        wheel.make_rollers(made.clone(), None).expect("rollers");
    }
    robot
}

/// Level ground at 0.1 m: a plane, a box and relief.
fn grounds() -> [(f64, Floor); 3] {
    let top = GroundBox {
        center_m: Vector3::new(0.0, 0.0, 0.05),
        half_sides_m: Vector3::new(1.0, 1.0, 0.05),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    };
    let relief = Relief {
        cell_m: 0.1,
        center_m: Default::default(),
        heights_m: vec![vec![0.1; 21]; 21],
    };
    [
        (0.0, Floor::default()),
        (
            0.1,
            Floor {
                boxes: vec![top],
                ..Floor::default()
            },
        ),
        (
            0.1,
            Floor {
                relief: Some(relief),
                ..Floor::default()
            },
        ),
    ]
}

/// Thrown up at some 6 m/s it comes down by as much, 24 mm in each step of 4 ms: a search that only
/// looked around where a wheel is would miss the ground. Rigid rollers give way by less than 0.1 um
/// under hundreds of newtons, a contact is caught within its step, and a hub is no lower than it
/// stood.
#[test]
fn wheels_that_fall_fast_stop_at_the_surface() {
    const DT_S: f64 = 4e-3;
    let settings = Settings {
        dt_s: DT_S,
        ..Settings::default()
    };
    // A step longer in the air for each 2 cm/s: the last one begins at another tenth of a step's
    // way above the ground each time.
    for up_m_s in (0..10).map(|tenth| 6.0 + 0.1 * f64::from(tenth) * 0.5 * 9.81 * DT_S) {
        for robot in [mecanum4(), on_cylinders()] {
            for (top_m, floor) in grounds() {
                let mut world =
                    World::new(&robot, &floor, Pose::default(), &settings).expect("valid");
                let force_n = robot.mass_kg() * (up_m_s / DT_S + settings.gravity_m_s2);
                world.robot_mut().push(&Push {
                    force_in_world_n: Vector3::z() * force_n,
                    place_in_body_m: robot.center_of_mass_m(),
                });
                let (mut highest_m, mut lowest_m) = (0.0_f64, f64::INFINITY);
                while world.time_s() < 1.3 {
                    world.step();
                    for wheel in 0..4 {
                        let height_m = world.robot().hub_height_m(wheel) - top_m;
                        highest_m = highest_m.max(height_m);
                        lowest_m = lowest_m.min(height_m);
                    }
                }
                // v^2 / 2 g, less what a step of 4 ms leaves open.
                let rises_m = up_m_s * up_m_s / (2.0 * settings.gravity_m_s2);
                assert!((highest_m - 0.05 - rises_m).abs() < 0.02, "{highest_m}");
                // Stopped within a step, 4.2 kN act on each wheel: 20 um at 2e8 N/m.
                assert!(lowest_m > 0.05 - 4e-5, "{top_m}: {lowest_m}");
            }
        }
    }
}

/// A robot swings on the lower front edge of its chassis, which friction holds: a contact that is
/// held does no work, u_0 + u_1 = 0. The velocity that a step holds is that in its middle, which is
/// off by the square of the step; held in the frame at a step's start it would slide in proportion
/// to the step.
#[test]
fn an_edge_that_a_robot_swings_on_is_held_to_second_order() {
    let mut robot = mecanum4();
    robot.chassis.collisions = vec![Collision {
        friction: None,
        body_from_shape: Isometry3::translation(0.0, 0.0, 0.101),
        shape: CollisionShape::Box {
            half_extents_m: Vector3::new(0.21, 0.1, 0.1),
        },
    }];
    let floor = Floor {
        friction: 3.0,
        ..Floor::default()
    };
    let slip_j = |dt_s: f64| {
        let settings = Settings {
            dt_s,
            ..Settings::default()
        };
        let mut world = World::new(&robot, &floor, Pose::default(), &settings).expect("valid");
        while world.robot().state().pitch_rad < 0.3 {
            assert!(world.time_s() < 2.0, "it does not tip");
            world.robot_mut().turn(Vector3::y() * 40.0);
            world.step();
        }
        let (before_j, mut furthest_rad) = (world.slip_energy_j(), 0.0_f64);
        while world.robot().state().pitch_rad > 0.2 {
            assert!(world.time_s() < 3.0, "it does not come back");
            world.step();
            furthest_rad = furthest_rad.max(world.robot().state().pitch_rad);
        }
        assert!(furthest_rad > 0.55, "{furthest_rad}");
        world.slip_energy_j() - before_j
    };
    let (coarse_j, fine_j) = (slip_j(2e-3), slip_j(1e-3));
    // It rises by some 3 cm, 3 J.
    assert!(coarse_j < 1e-4, "{coarse_j:e}");
    // By four; it is let go within a step of 0.3 rad, and swings by 3 % more or less.
    assert!(
        (3.7..4.5).contains(&(coarse_j / fine_j)),
        "{coarse_j:e} {fine_j:e}"
    );
}
