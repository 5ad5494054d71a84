//! A chassis, or a free body, on ground with many small faces: thousands of contacts, of which a
//! few carry it.

use crate::support;

use ilon_robot::{Collision, CollisionShape, FreeShape, Pose, Robot};
use ilon_world::{Floor, FreeBody, Push, Relief, Settings, World};
use nalgebra::{Isometry3, Vector2, Vector3};
use support::mecanum4;

/// A robot whose chassis is a box of 0.3 m x 0.16 m, 30 mm above the ground.
fn low() -> Robot {
    let mut robot = mecanum4();
    robot.chassis.collisions = vec![Collision {
        friction: None,
        body_from_shape: Isometry3::translation(0.0, 0.0, 0.05),
        shape: CollisionShape::Box {
            half_extents_m: Vector3::new(0.15, 0.08, 0.02),
        },
    }];
    robot
}

/// Level ground with a bank of 50 mm between the wheels, over a range of x, in cells of 5 mm.
fn bank(x_m: [f64; 2]) -> Floor {
    let points = 321;
    let at_m = |index: usize| 0.005 * (index as f64 - 160.0);
    let height_m = |row: usize, column: usize| {
        let inside = (x_m[0]..=x_m[1]).contains(&at_m(column)) && at_m(row).abs() < 0.07;
        if inside { 0.05 } else { 0.0 }
    };
    Floor {
        relief: Some(Relief {
            cell_m: 0.005,
            center_m: Default::default(),
            heights_m: (0..points)
                .map(|row| (0..points).map(|column| height_m(row, column)).collect())
                .collect(),
        }),
        ..Floor::default()
    }
}

fn settled(floor: &Floor) -> World {
    let settings = Settings {
        dt_s: 2e-3,
        ..Settings::default()
    };
    let start = Pose {
        x_m: -0.55,
        ..Pose::default()
    };
    let mut world = World::new(&low(), floor, start, &settings).unwrap();
    hoist(&mut world, 0.55, 0.025);
    let there_s = world.time_s();
    while world.time_s() < there_s + 0.4 {
        world.step();
    }
    world
}

/// Carries the robot along x from its place, and releases it at a height above its start: up, along
/// and down at 0.5 m/s, by forces at its centre of mass only, so that it neither turns nor swings.
fn hoist(world: &mut World, along_m: f64, height_m: f64) {
    let robot = low();
    let (mass_kg, dt_s) = (robot.mass_kg(), world.dt_s());
    let clear_m = height_m + 0.06;
    let ways = [
        Vector3::z() * clear_m,
        Vector3::x() * along_m,
        Vector3::z() * (height_m - clear_m),
    ];
    for way_m in ways {
        let steps = (way_m.norm() / (0.5 * dt_s)).round();
        let speed_m_s = way_m / (steps * dt_s);
        for step in 0..=steps as usize {
            // It advances with the mean of its velocities before and after a step.
            let gains_m_s = match step {
                0 => speed_m_s,
                last if last == steps as usize => -speed_m_s,
                _ => Vector3::zeros(),
            };
            world.robot_mut().push(&Push {
                force_in_world_n: mass_kg * (gains_m_s / dt_s + 9.81 * Vector3::z()),
                place_in_body_m: robot.center_of_mass_m(),
            });
            world.step();
        }
    }
}

/// A robot must not start with its chassis on a bank and its wheels in the air.
#[test]
fn a_chassis_that_would_begin_on_a_bank_is_refused() {
    let settings = Settings::default();
    let floor = bank([-0.14, 0.14]);
    let refused = World::new(&low(), &floor, Pose::default(), &settings).map(|_| ());
    let said = refused.unwrap_err().to_string();
    assert!(said.contains("chassis"), "{said}");
}

/// 28 x 57 cells of two faces each, under the middle of the robot.
#[test]
fn a_bank_of_small_cells_carries_a_chassis() {
    let world = settled(&bank([-0.14, 0.14]));
    let robot = world.robot();
    let state = robot.state();
    let weight_n = low().mass_kg() * 9.81;
    let carried_n = robot.support().chassis_n;
    println!("{carried_n} N of {weight_n} N, {state:?}");
    // The rest of the settling: a hundredth of the weight would move it by a tenth of a millimetre
    // in the time.
    assert!((carried_n / weight_n - 1.0).abs() < 1e-2, "{carried_n}");
    assert!((state.height_m - 0.02).abs() < 1e-4, "{}", state.height_m);
    assert!(state.pitch_rad.abs() < 1e-4 && state.roll_rad.abs() < 1e-4);
}

/// If the bank ends 20 mm before the middle the robot tips onto its front wheels, if it ends 20 mm
/// behind it does not. A robot that turns about the edge of the bank falls by m g s = (I + m s^2)
/// phi'', tenths of a radian in the time.
#[test]
fn a_chassis_tips_over_the_edge_of_a_bank_and_not_before() {
    let holds = settled(&bank([-0.14, 0.02]));
    let pitch_rad = holds.robot().state().pitch_rad;
    assert!(pitch_rad.abs() < 1e-3, "{pitch_rad}");
    let tips = settled(&bank([-0.14, -0.02]));
    let pitch_rad = tips.robot().state().pitch_rad;
    assert!(pitch_rad > 0.03, "{pitch_rad}");
    assert!(tips.robot().support().wheels_n > 1.0);
}

/// A box of 0.3 m beside the robot, on 60 x 60 cells: it slides v^2 / (2 mu g) = 31.9 mm, straight,
/// and rests level on level ground.
#[test]
fn a_box_slides_over_small_cells_as_over_a_plane() {
    let points = 401;
    let floor = Floor {
        relief: Some(Relief {
            cell_m: 0.005,
            center_m: Vector2::new(0.5, 0.0),
            heights_m: vec![vec![0.0; points]; points],
        }),
        ..Floor::default()
    };
    let settings = Settings {
        dt_s: 2e-3,
        ..Settings::default()
    };
    let mut world = World::new(&mecanum4(), &floor, Pose::default(), &settings).unwrap();
    let size_m = Vector3::new(0.3, 0.3, 0.2);
    let place_m = Vector2::new(0.8, 0.0);
    let id = world
        .add_body(&FreeBody {
            friction: 0.4,
            velocity_m_s: Vector3::y() * 0.5,
            ..FreeBody::new(
                "box",
                FreeShape::Box {
                    size_m: size_m.into(),
                },
                2.0,
                place_m,
            )
        })
        .unwrap();
    while world.time_s() < 0.3 {
        world.step();
    }
    let end = world.free_body(id).unwrap();
    let way_m = 0.5 * 0.5 / (2.0 * 0.4 * 9.81);
    // To rest in steps of 2 ms: half of one at 0.5 m/s is 1.6 % of the way.
    assert!(
        (end.place_m.y / way_m - 1.0).abs() < 0.02,
        "{}",
        end.place_m.y
    );
    assert!((end.place_m.x - 0.8).abs() < 1e-5);
    assert!((end.place_m.z - 0.1).abs() < 1e-5, "{}", end.place_m.z);
    assert!(end.rotation.angle() < 1e-4 && end.velocity_m_s.norm() < 1e-3);
}
