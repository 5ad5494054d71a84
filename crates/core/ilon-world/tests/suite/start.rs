//! The start of a robot: on whatever is beneath it, never inside it.

use crate::support;

use std::f64::consts::FRAC_PI_2;

use ilon_robot::{Collision, CollisionShape, Pose, Robot, RollersAsMade};
use ilon_world::{Floor, GroundBox, Relief, Settings, World, WorldError};
use nalgebra::{Isometry3, Vector3};
use support::mecanum4;

/// A box on the floor, with its sides along the axes.
fn solid(x_m: [f64; 2], y_m: [f64; 2], height_m: f64) -> GroundBox {
    let span = |[from, to]: [f64; 2]| (0.5 * (from + to), 0.5 * (to - from));
    let ((x, half_x), (y, half_y)) = (span(x_m), span(y_m));
    GroundBox {
        center_m: Vector3::new(x, y, 0.5 * height_m),
        half_sides_m: Vector3::new(half_x, half_y, 0.5 * height_m),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    }
}

fn floor(boxes: Vec<GroundBox>) -> Floor {
    Floor {
        boxes,
        ..Floor::default()
    }
}

fn begin(robot: &Robot, floor: &Floor, start: Pose) -> Result<World, WorldError> {
    World::new(robot, floor, start, &Settings::default())
}

/// The largest height above the start and the largest vertical speed within half a second, in
/// metres and m/s.
fn rises(world: &mut World) -> (f64, f64) {
    let start_m = world.robot().state().height_m;
    let (mut rise_m, mut fastest_m_s) = (0.0_f64, 0.0_f64);
    while world.time_s() < 0.5 {
        let before_m = world.robot().state().height_m;
        world.step();
        let body = world.robot().state();
        rise_m = rise_m.max(body.height_m - start_m);
        fastest_m_s = fastest_m_s.max((body.height_m - before_m).abs() / world.dt_s());
    }
    (rise_m, fastest_m_s)
}

#[test]
fn on_a_box_that_bears_all_wheels_it_stands_on_top_and_stays() {
    let robot = mecanum4();
    for height_m in [0.001, 0.005, 0.05, 0.5] {
        let floor = floor(vec![solid([-1.0, 1.0], [-1.0, 1.0], height_m)]);
        let start = Pose {
            x_m: 0.013,
            y_m: -0.02,
            heading_rad: 0.7,
        };
        let mut world = begin(&robot, &floor, start).expect("a place to stand");
        let radius_m = robot.wheels[0].radius_m;
        // The hub is as far above the top as above a floor, to f32's resolution of half a metre.
        assert!((world.robot().hub_height_m(0) - height_m - radius_m).abs() < 1e-7);
        let (rise_m, fastest_m_s) = rises(&mut world);
        assert!(rise_m < 1e-6, "{height_m}: rose {rise_m:.1e} m");
        // Only the settling onto contacts that deflect by micrometres moves it.
        assert!(fastest_m_s < 1e-2, "{height_m}: {fastest_m_s:.1e} m/s");
    }
}

#[test]
fn on_a_box_under_two_wheels_it_tips_onto_the_other_two_and_is_not_thrown() {
    let robot = mecanum4();
    let height_m = 0.005;
    for heading_rad in [0.0, 0.1, 1.57, 2.5] {
        let floor = floor(vec![solid([0.0, 1.0], [-1.0, 1.0], height_m)]);
        let start = Pose {
            heading_rad,
            ..Pose::default()
        };
        let mut world = begin(&robot, &floor, start).expect("a place to stand");
        let (rise_m, fastest_m_s) = rises(&mut world);
        assert!(rise_m < 1e-5, "rose {rise_m:.1e} m");
        // The largest possible speed is that of a fall from the height of the box, times the lever
        // of the chassis's end, which is below twice that of its wheels.
        assert!(
            fastest_m_s < 2.0 * (2.0 * 9.81 * height_m).sqrt(),
            "{fastest_m_s:.2} m/s"
        );
        assert!(world.robot().penetration_m() < 5e-5);
    }
}

#[test]
fn on_bumps_the_first_wheel_touches_and_none_is_inside() {
    let robot = mecanum4();
    let heights_m = (0..40)
        .map(|row| {
            let at = |column: usize| {
                0.004 * f64::from(u32::from((row * 7 + column * 3).is_multiple_of(5)))
            };
            (0..40).map(at).collect()
        })
        .collect();
    let floor = Floor {
        relief: Some(Relief {
            cell_m: 0.03,
            center_m: Default::default(),
            heights_m,
        }),
        ..Floor::default()
    };
    for heading_rad in [0.0, 0.4, 2.0] {
        let start = Pose {
            heading_rad,
            ..Pose::default()
        };
        let mut world = begin(&robot, &floor, start).expect("a place to stand");
        assert!(world.robot().penetration_m() < 1e-8);
        let (rise_m, _) = rises(&mut world);
        assert!(rise_m < 1e-5, "rose {rise_m:.1e} m");
    }
}

/// A robot also stands on a peg that only the far end of one wheel reaches, and nothing starts in
/// it.
#[test]
fn on_a_peg_under_the_far_end_of_a_wheel_it_begins_on_top() {
    let mut turned = mecanum4();
    let made = RollersAsMade {
        profile_m: Some(vec![[-0.016, 0.012], [0.016, 0.012]]),
        ..RollersAsMade::default()
    };
    for wheel in &mut turned.wheels {
        wheel.make_rollers(made.clone(), None).expect("rollers");
    }
    for robot in [mecanum4(), turned] {
        // Beneath the wheel's front, 6 mm off its middle.
        let floor = floor(vec![solid([0.194, 0.206], [0.166, 0.178], 0.035)]);
        let mut world = begin(&robot, &floor, Pose::default()).expect("a place to stand");
        let raised_m = world.robot().hub_height_m(0) - 0.05;
        // A circle of 50 mm over an edge 44 mm ahead has its hub at 35 + sqrt(50^2 - 44^2) = 58.7
        // mm; rollers leave some of it free.
        assert!(raised_m > 1e-3 && raised_m < 0.009, "{raised_m}");
        let (rise_m, _) = rises(&mut world);
        assert!(rise_m < 1e-5, "rose {rise_m:.1e} m");
    }
}

/// A front left wheel is worn by 1 mm: of the three wheels under the centre of mass the robot leans
/// onto it or off it, and stays in its start pose without a fall.
#[test]
fn on_wheels_of_unequal_radius_it_begins_as_it_stands() {
    for worn in 0..4 {
        let mut robot = mecanum4();
        let wheel = &mut robot.wheels[worn];
        let shrunk = 1.0 - 0.001 / wheel.radius_m;
        wheel.radius_m *= shrunk;
        for roller in &mut wheel.rollers {
            roller.center_in_hub_m *= shrunk;
            roller.radius_m *= shrunk;
            roller.length_m *= shrunk;
        }
        // A mass near the other corner keeps it off the worn wheel or on it, not in between.
        robot.chassis.mass.center_of_mass_m += Vector3::new(0.02, 0.03, 0.0);
        let stands = robot.standing_pose().expect("it can stand");
        let mut world = begin(&robot, &Floor::default(), Pose::default()).expect("a plane");
        let body = world.robot().state();
        let at = [body.height_m, body.roll_rad, body.pitch_rad];
        let foretold = [stands.height_m, stands.roll_rad, stands.pitch_rad];
        for (at, foretold) in at.iter().zip(foretold) {
            assert!((at - foretold).abs() < 1e-12);
        }
        while world.time_s() < 0.5 {
            world.step();
        }
        let body = world.robot().state();
        let left = [body.height_m, body.roll_rad, body.pitch_rad];
        let moved = at.iter().zip(left).map(|(at, left)| (at - left).abs());
        let moved = moved.fold(0.0, f64::max);
        // Wheels tilted by 1 mm / 0.3 m touch up to 1 cm beside their middles, where their rollers
        // are: 3.3e-3 x 0.01 m.
        assert!(moved < 4e-5, "wheel {worn}: moved by {moved:.1e}");
    }
}

#[test]
fn beside_a_wall_it_stands_on_the_floor() {
    let robot = mecanum4();
    // The wall begins 1 mm beside the outermost roller.
    let reach_m = robot
        .wheels
        .iter()
        .map(|wheel| wheel.position_m().y.abs())
        .fold(0.0, f64::max)
        + 0.06;
    let floor = floor(vec![solid([-1.0, 1.0], [reach_m, reach_m + 0.1], 0.5)]);
    let world = begin(&robot, &floor, Pose::default()).expect("a place to stand");
    assert!((world.robot().hub_height_m(0) - robot.wheels[0].radius_m).abs() < 1e-7);
}

/// Ground rises to 0.3 m right ahead of the wheels: the robot is put down on the ground beneath it,
/// level at 50 mm.
#[test]
fn beside_a_bank_of_relief_it_stands_on_what_is_beneath() {
    let robot = mecanum4();
    let height_m = |column: usize| if column > 31 { 0.3 } else { 0.05 };
    let relief = Relief {
        cell_m: 0.02,
        center_m: Default::default(),
        heights_m: vec![(0..41).map(height_m).collect(); 41],
    };
    let floor = Floor {
        relief: Some(relief),
        ..Floor::default()
    };
    let world = begin(&robot, &floor, Pose::default()).expect("a place to stand");
    let above_m = world.robot().hub_height_m(0) - robot.wheels[0].radius_m;
    assert!((above_m - 0.05).abs() < 1e-7, "{above_m}");
}

#[test]
fn beside_a_wall_of_any_height_it_stands_on_the_floor_soon() {
    let robot = mecanum4();
    let outermost_m = robot
        .wheels
        .iter()
        .map(|wheel| wheel.position_m().y.abs())
        .fold(0.0, f64::max)
        + 0.06;
    // 20 um beside the robot, so that it was lowered by as much at a time: 50 million times for a
    // kilometre.
    for height_m in [3.0, 1e3, 1e6, 1e9] {
        let wall = solid([-1.0, 1.0], [outermost_m, outermost_m + 0.1], height_m);
        let world = begin(&robot, &floor(vec![wall]), Pose::default()).expect("a place to stand");
        let off_m = world.robot().hub_height_m(0) - robot.wheels[0].radius_m;
        assert!(off_m.abs() < 1e-7, "{height_m}: {off_m}");
        // Beneath it: it stands there, or is refused, and either result is quick.
        let beneath = solid([-1.0, 1.0], [-1.0, 1.0], height_m);
        if let Ok(world) = begin(&robot, &floor(vec![beneath]), Pose::default()) {
            let above_m = world.robot().hub_height_m(0) - height_m;
            assert!(
                above_m >= 0.0 && above_m < 0.06 + 1e-6 * height_m,
                "{height_m}: {above_m}"
            );
        }
    }
}

/// One point of uneven ground is far above the others: the robot beside it stands on the flat part.
#[test]
fn beside_a_high_point_of_relief_it_stands_on_what_is_flat() {
    let robot = mecanum4();
    let mut heights_m = vec![vec![0.0; 101]; 101];
    heights_m[50][50] = 30.0;
    let floor = Floor {
        relief: Some(Relief {
            cell_m: 0.02,
            center_m: nalgebra::Vector2::new(0.5, 0.0),
            heights_m,
        }),
        ..Floor::default()
    };
    let world = begin(&robot, &floor, Pose::default()).expect("a place to stand");
    let above_m = world.robot().hub_height_m(0) - robot.wheels[0].radius_m;
    assert!(above_m.abs() < 1e-6, "{above_m}");
}

#[test]
fn where_only_its_chassis_would_bear_it_or_a_wheel_would_hang_it_is_refused() {
    let mut robot = mecanum4();
    robot.chassis.collisions = vec![Collision {
        friction: None,
        body_from_shape: Isometry3::translation(0.0, 0.0, 0.0),
        shape: CollisionShape::Box {
            half_extents_m: Vector3::new(0.15, 0.1, 0.01),
        },
    }];
    let under_its_middle = floor(vec![solid([-0.03, 0.03], [-0.03, 0.03], 0.2)]);
    let refused = begin(&robot, &under_its_middle, Pose::default())
        .err()
        .expect("it lies");
    assert!(refused.to_string().contains("chassis"), "{refused}");

    let under_two_wheels = floor(vec![solid([0.1, 1.0], [-1.0, 1.0], 0.2)]);
    let refused = begin(&mecanum4(), &under_two_wheels, Pose::default())
        .err()
        .expect("it hangs");
    assert!(refused.to_string().contains("hang"), "{refused}");
}

/// The protruding part of a chassis comes down at the robot's heading: turned left, a box ahead of
/// its place is beside it, and one to its left is under the protruding part.
#[test]
fn what_reaches_out_of_a_chassis_comes_down_where_the_robot_heads() {
    let mut robot = mecanum4();
    robot.chassis.collisions = vec![Collision {
        friction: None,
        body_from_shape: Isometry3::translation(0.5, 0.0, 0.1),
        shape: CollisionShape::Sphere { radius_m: 0.04 },
    }];
    let start = Pose {
        x_m: 1.0,
        y_m: -2.0,
        heading_rad: FRAC_PI_2,
    };
    let stands_beside = |x_m: f64, y_m: f64| {
        let block = solid([x_m - 0.1, x_m + 0.1], [y_m - 0.1, y_m + 0.1], 0.1);
        begin(&robot, &floor(vec![block]), start)
    };
    let ahead = stands_beside(1.5, -2.0).expect("it lies to the robot's right");
    // It is put down to a nanometre.
    assert!(ahead.robot().state().height_m < 1e-9);
    let refused = stands_beside(1.0, -1.5).err().expect("it lies");
    assert!(refused.to_string().contains("chassis"), "{refused}");
}

#[test]
fn a_robot_without_wheels_or_a_wheel_without_rollers_is_refused() {
    let mut robot = mecanum4();
    robot.wheels[2].rollers.clear();
    let refused = begin(&robot, &Floor::default(), Pose::default());
    assert!(
        matches!(refused, Err(WorldError::Wheel { reason, .. }) if reason.contains("no rollers"))
    );
    robot.wheels.clear();
    let refused = begin(&robot, &Floor::default(), Pose::default());
    assert!(matches!(refused, Err(WorldError::NoWheels)));
}

/// Boxes of the ground with zero or NaN sizes are refused, and so are ramps beyond vertical.
#[test]
fn boxes_that_are_none_are_refused() {
    let refused = |change: &dyn Fn(&mut GroundBox)| {
        let mut solid = GroundBox {
            center_m: Vector3::new(3.0, 0.0, 0.1),
            half_sides_m: Vector3::repeat(0.1),
            heading_rad: 0.0,
            pitch_rad: 0.0,
        };
        change(&mut solid);
        let floor = Floor {
            boxes: vec![solid],
            ..Floor::default()
        };
        let built = World::new(&mecanum4(), &floor, Pose::default(), &Settings::default());
        built.err().map(|error| error.to_string())
    };
    assert_eq!(refused(&|_| ()), None);
    for bad in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let text = refused(&|solid| solid.half_sides_m.y = bad).expect("no size");
        assert!(text.contains("half_sides_m"), "{text}");
    }
    let text = refused(&|solid| solid.pitch_rad = -1.6).expect("beyond upright");
    assert!(text.contains("pitch_rad"), "{text}");
}
