//! Wheels beside the edge of a plateau that falls steeply: the plane of the slope, above the
//! plateau, is not ground.

use crate::support;

use ilon_robot::Pose;
use ilon_world::{Floor, Relief, Settings, World};
use nalgebra::Vector2;
use support::mecanum4;

/// A plateau that ends at some x, and falls by a height in the next cell of 20 mm.
fn plateau(ends_m: f64, falls_m: f64) -> Floor {
    let points = 101;
    let at_m = |index: usize| 0.02 * (index as f64 - 50.0);
    let height_m = |column: usize| {
        if at_m(column) > ends_m + 1e-6 {
            -falls_m
        } else {
            0.0
        }
    };
    Floor {
        relief: Some(Relief {
            cell_m: 0.02,
            center_m: Vector2::zeros(),
            heights_m: vec![(0..points).map(height_m).collect(); points],
        }),
        ..Floor::default()
    }
}

/// The load of each wheel after half a second at rest, and the robot's pose.
fn loads_n(floor: &Floor) -> (Vec<f64>, Pose, f64) {
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    let mut world = World::new(&mecanum4(), floor, Pose::default(), &settings).unwrap();
    while world.time_s() < 0.5 {
        world.step();
    }
    let robot = world.robot();
    let of = robot
        .contacts()
        .iter()
        .map(|contact| contact.normal_force_n);
    (of.collect(), robot.state().pose, robot.state().height_m)
}

/// The front wheels are on the plateau by less than a roller's radius, and by more: there their
/// loads are those on a plane. A slope of 45, 79 and 84 degrees.
#[test]
fn a_wheel_on_the_brink_stands_as_on_a_plane() {
    let (on_plane, ..) = loads_n(&Floor::default());
    let robot = mecanum4();
    let front_m = robot
        .wheels
        .iter()
        .map(|wheel| wheel.body_from_hub.translation.x);
    let front_m = front_m.fold(f64::NEG_INFINITY, f64::max);
    for falls_m in [0.02, 0.1, 0.2] {
        for cells in [1.0, 2.0, 3.0] {
            let ends_m = (front_m / 0.02 + cells).floor() * 0.02;
            let (loads, pose, height_m) = loads_n(&plateau(ends_m, falls_m));
            println!("{falls_m} {ends_m}: {loads:?} {pose:?} {height_m}");
            for (found, expected) in loads.iter().zip(&on_plane) {
                assert!(
                    (found / expected - 1.0).abs() < 1e-3,
                    "{loads:?} {on_plane:?}"
                );
            }
            assert!(pose.x_m.abs() < 1e-5 && pose.y_m.abs() < 1e-5, "{pose:?}");
        }
    }
}
