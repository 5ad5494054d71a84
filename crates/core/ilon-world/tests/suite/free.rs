//! Free bodies against closed forms: pushed, hit, carried, sliding, rolling.

use std::f64::consts::FRAC_PI_2;

use ilon_robot::{Collision, CollisionShape, FreeShape, Pose, Robot};
use ilon_world::{Floor, FreeBody, FreeBodyId, MotorTorque, Push, Settings, World};
use nalgebra::{Isometry3, UnitQuaternion, Vector2, Vector3};

use crate::support::mecanum4;

const G: f64 = 9.81;
/// The chassis of the robot: 0.4 x 0.24 x 0.1 m, its middle 0.06 m high.
const FRONT_M: f64 = 0.2;
const TOP_M: f64 = 0.11;

pub fn robot() -> Robot {
    let mut robot = mecanum4();
    robot.chassis.collisions.push(Collision {
        friction: None,
        body_from_shape: Isometry3::translation(0.0, 0.0, 0.06),
        shape: CollisionShape::Box {
            half_extents_m: Vector3::new(FRONT_M, 0.12, 0.05),
        },
    });
    robot
}

pub fn settings(dt_s: f64) -> Settings {
    Settings {
        dt_s,
        ..Settings::default()
    }
}

pub fn world(floor: &Floor, dt_s: f64) -> World {
    World::new(&robot(), floor, Pose::default(), &settings(dt_s)).expect("it stands on a plane")
}

pub fn cube(name: &str, side_m: f64, mass_kg: f64, x_m: f64, y_m: f64) -> FreeBody {
    let shape = FreeShape::Box {
        size_m: [side_m; 3],
    };
    FreeBody::new(name, shape, mass_kg, Vector2::new(x_m, y_m))
}

/// Stiff rate loops that keep all wheels at a rate, in rad/s.
pub fn hold(world: &mut World, rate_rad_s: f64) {
    const GAIN_N_M_S: f64 = 2.0;
    let rates = world.robot().wheel_rates_rad_s().iter();
    let motors: Vec<MotorTorque> = rates
        .map(|rate| MotorTorque::with_droop(GAIN_N_M_S * (rate_rad_s - rate), GAIN_N_M_S))
        .collect();
    world.robot_mut().drive(&motors);
}

/// The error of the energy balance, in J: what came in less the storage and the losses.
fn missing_j(world: &World, stored_before_j: f64) -> f64 {
    let energy = world.energy();
    let stored_j = energy.kinetic_j + energy.potential_j - stored_before_j;
    let lost_j = world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.impact_energy_j()
        + world.bearing_energy_j();
    world.motor_energy_j() + world.outside_energy_j() - stored_j - lost_j
}

fn stored_j(world: &World) -> f64 {
    let energy = world.energy();
    energy.kinetic_j + energy.potential_j
}

fn place(world: &World, id: FreeBodyId) -> Vector3<f64> {
    world.free_body(id).expect("it is there").place_m
}

fn velocity(world: &World, id: FreeBodyId) -> Vector3<f64> {
    world.free_body(id).expect("it is there").velocity_m_s
}

/// On a frictionless floor the horizontal momentum is conserved: after the impact both move
/// together with the robot's momentum.
#[test]
fn a_robot_hits_a_box_head_on_and_momentum_stays() {
    let floor = Floor {
        friction: 0.0,
        ..Floor::default()
    };
    for (dt_s, mass_kg) in [(1e-3, 3.0), (2e-3, 30.0), (5e-4, 0.2)] {
        let mut world = world(&floor, dt_s);
        let id = world
            .add_body(&cube("box", 0.12, mass_kg, 0.4, 0.0))
            .expect("room");
        let robot_kg = robot().mass_kg();
        let pushes = (0.1 / dt_s) as usize;
        for _ in 0..pushes {
            world.robot_mut().push(&Push {
                force_in_world_n: Vector3::new(robot_kg * 5.0, 0.0, 0.0),
                place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
            });
            world.step();
        }
        let speed_m_s = world.robot().state().twist_in_body.vx_m_s;
        assert!((speed_m_s - 0.5).abs() < 1e-9 && velocity(&world, id).x == 0.0);
        let before = robot_kg * speed_m_s;
        for _ in 0..(1.5 / dt_s) as usize {
            world.step();
        }
        let after = robot_kg * world.robot().state().twist_in_body.vx_m_s
            + mass_kg * velocity(&world, id).x;
        println!("{dt_s} {mass_kg}: {before} {after}");
        assert!(velocity(&world, id).x > 0.1, "it was hit");
        assert!((after / before - 1.0).abs() < 1e-6, "{after} of {before}");
    }
}

/// Pushing a box of known friction at a constant speed takes mu m g, and that times the way. If its
/// face rubs on the robot's, it is also pressed down: it would tip forwards, and friction holds it
/// back at its limit, F = mu (m g + mu_r F).
#[test]
fn pushing_a_box_takes_its_friction() {
    let of_robot = [0.0, 0.3];
    for (dt_s, friction, mass_kg) in [(1e-3, 0.3, 2.0), (2e-3, 0.2, 4.0)] {
        for friction_on_robot in of_robot {
            let mut world = world(&Floor::default(), dt_s);
            let mut body = cube("box", 0.2, mass_kg, FRONT_M + 0.1 + 1e-3, 0.0);
            body.friction = friction;
            body.friction_on_robots = Some(friction_on_robot);
            let id = world.add_body(&body).expect("room");
            let before_j = stored_j(&world);
            let steps = (1.0 / dt_s) as usize;
            for _ in 0..steps {
                hold(&mut world, 4.0);
                world.step();
            }
            let (from, slid_j) = (world.free_body(id).unwrap(), world.slip_energy_j());
            let mut force_n = 0.0;
            for _ in 0..steps {
                hold(&mut world, 4.0);
                world.step();
                force_n += world.free_body(id).unwrap().force_from_robots_n.x / steps as f64;
            }
            let to = world.free_body(id).unwrap();
            let way_m = to.place_m.x - from.place_m.x;
            let work_j = to.work_of_robots_j - from.work_of_robots_j;
            let expected_n = friction * mass_kg * G / (1.0 - friction * friction_on_robot);
            let heat_j = world.slip_energy_j() - slid_j;
            println!("{force_n} of {expected_n} N; {work_j} J over {way_m} m, heat {heat_j}");
            // The rate loops have an error by their droop.
            assert!((way_m - 0.2).abs() < 4e-3, "{way_m}");
            assert!(
                (force_n / expected_n - 1.0).abs() < 5e-3,
                "{force_n} of {expected_n} N"
            );
            assert!((work_j / (expected_n * way_m) - 1.0).abs() < 5e-3);
            let missing_j = missing_j(&world, before_j);
            println!("missing {missing_j} of {}", world.motor_energy_j());
            assert!(missing_j.abs() < 1e-3 * world.motor_energy_j());
        }
    }
}

/// A stack of three boxes on the robot stays while it brakes by less than mu g, and slides by the
/// difference if it brakes harder.
#[test]
fn a_stack_on_the_robot_slides_when_statics_says_so() {
    const DT_S: f64 = 1e-3;
    let floor = Floor {
        friction: 0.9,
        ..Floor::default()
    };
    for brakes in [0.9, 0.98, 1.02, 1.2] {
        let mut world = world(&floor, DT_S);
        let mut ids = Vec::new();
        for name in ["low", "middle", "top"] {
            let mut body = cube(name, 0.06, 0.5, 0.0, 0.0);
            body.friction = 0.2;
            ids.push(world.add_body(&body).expect("it is put on what is there"));
        }
        for (at, id) in ids.iter().enumerate() {
            let height_m = TOP_M + 0.06 * (at as f64 + 0.5);
            assert!((place(&world, *id).z - height_m).abs() < 1e-6);
        }
        let before_j = stored_j(&world);
        let rate_rad_s = |t_s: f64| {
            let brakes_m_s2 = brakes * 0.2 * G;
            let up_m_s = 1.0 * t_s.min(0.6);
            (up_m_s - brakes_m_s2 * (t_s - 0.8).max(0.0)).max(0.0) / 0.05
        };
        let speeds_m_s = |world: &World| {
            let of_bodies = ids.iter().map(|id| velocity(world, *id).x);
            let of_robot = world.robot().state().twist_in_body.vx_m_s;
            of_bodies.chain([of_robot]).collect::<Vec<f64>>()
        };
        let (mut from, mut lean) = (Vec::new(), 0.0_f64);
        for step in 0..930 {
            hold(&mut world, rate_rad_s((step + 1) as f64 * DT_S));
            world.step();
            if step == 849 {
                // The rate loops have followed into the ramp.
                from = speeds_m_s(&world);
            }
            lean = lean.max(world.robot().state().pitch_rad.abs());
        }
        let to = speeds_m_s(&world);
        let brakes_m_s2: Vec<f64> = from.iter().zip(&to).map(|(a, b)| (a - b) / 0.08).collect();
        println!("{brakes}: {brakes_m_s2:?} {lean}");
        let of_robot = brakes_m_s2[3];
        assert!(
            (of_robot / (brakes * 0.2 * G) - 1.0).abs() < 5e-3,
            "{of_robot}"
        );
        // All three slide as one: between them the same friction carries less.
        let expected = of_robot.min(0.2 * G);
        for of_body in &brakes_m_s2[..3] {
            assert!(
                (of_body / expected - 1.0).abs() < 5e-3,
                "{of_body} {expected}"
            );
        }
        let missing_j = missing_j(&world, before_j);
        println!("missing {missing_j} of {}", world.motor_energy_j());
        assert!(missing_j.abs() < 1e-3 * world.slip_energy_j().max(1.0));
    }
}

/// On a slope a box rests if tan a < mu, and otherwise slides with g (sin a - mu cos a).
#[test]
fn a_box_on_a_slope_slides_or_rests_as_tan_says() {
    const FRICTION: f64 = 0.3;
    for (part, dt_s) in [(0.99, 1e-3), (1.01, 1e-3), (1.5, 2e-3)] {
        let slope_rad = (part * FRICTION).atan();
        let floor = Floor {
            slope_rad,
            ..Floor::default()
        };
        let mut world = world(&floor, dt_s);
        let mut body = cube("box", 0.1, 1.0, 0.0, 1.0);
        body.friction = FRICTION;
        body.rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4);
        let id = world.add_body(&body).expect("room");
        let from = place(&world, id);
        let before_j = stored_j(&world);
        let steps = (0.5 / dt_s) as usize;
        (0..steps).for_each(|_| world.step());
        let moved = place(&world, id) - from;
        let accelerates = G * (slope_rad.sin() - FRICTION * slope_rad.cos());
        let expected_m = 0.5 * accelerates.max(0.0) * 0.25;
        println!("{part}: {moved:?} of {expected_m}");
        assert!((moved.x - expected_m).abs() < 1e-3 * expected_m + 1e-6);
        assert!(moved.y.abs() < 1e-5);
        let lost_j = missing_j(&world, before_j).abs();
        assert!(lost_j < 1e-3 * world.slip_energy_j().max(0.1), "{lost_j}");
    }
}

/// A ball that flies at a wheel by 20 mm per step is found a step before its impact: it gets no
/// deeper than between two rollers, which is less than a roller's radius below the rim.
#[test]
fn a_fast_ball_does_not_get_into_a_wheel() {
    let (radius_m, dt_s) = (0.02, 5e-3);
    let robot = mecanum4();
    let hub_m = robot.wheels[0].position_m();
    let apart_m = robot.wheels[0].radius_m + radius_m;
    let mut world = World::new(&robot, &Floor::default(), Pose::default(), &settings(dt_s))
        .expect("it stands on a plane");
    let place_m = Vector2::new(hub_m.x + apart_m + 0.055, hub_m.y);
    let ball = FreeBody {
        height_m: Some(hub_m.z),
        velocity_m_s: Vector3::new(-4.0, 0.0, 0.0),
        ..FreeBody::new("ball", FreeShape::Sphere { radius_m }, 0.05, place_m)
    };
    let ball = world.add_body(&ball).expect("room");
    let mut nearest_m = f64::INFINITY;
    for _ in 0..20 {
        world.step();
        let ball_m = world.free_body(ball).expect("it is there").place_m;
        let off_m = ball_m - hub_m - Vector3::x() * world.robot().state().pose.x_m;
        nearest_m = nearest_m.min(off_m.xz().norm());
    }
    let deep_m = apart_m - nearest_m;
    assert!(deep_m < robot.wheels[0].rollers[0].radius_m, "{deep_m}");
}

/// A box that sleeps on level ground slides with g (sin - mu cos) once the ground is tilted far
/// enough, and its energy comes from outside.
#[test]
fn a_box_that_sleeps_slides_where_the_ground_begins_to_lean() {
    const FRICTION: f64 = 0.3;
    let slope_rad = (1.5 * FRICTION).atan();
    let mut world = world(&Floor::default(), 1e-3);
    let mut body = cube("box", 0.1, 1.0, 0.0, 1.0);
    body.friction = FRICTION;
    let id = world.add_body(&body).expect("room");
    (0..1000).for_each(|_| world.step());
    let from = place(&world, id);
    let before_j = stored_j(&world);
    let (sin, cos) = slope_rad.sin_cos();
    world.lean(&Vector3::new(sin, 0.0, -cos));
    (0..500).for_each(|_| world.step());
    let expected_m = 0.5 * G * (sin - FRICTION * cos) * 0.25;
    let moved = place(&world, id) - from;
    // The contact's deflection is less than before, by some of its 0.3 um.
    assert!(
        (moved.x / expected_m - 1.0).abs() < 1e-3,
        "{moved:?} of {expected_m}"
    );
    let lost_j = missing_j(&world, before_j).abs();
    assert!(lost_j < 1e-3 * world.slip_energy_j(), "{lost_j}");
}

/// A small box lies on an equal one that is rotated against it about the vertical: crossing edges
/// carry it, whatever their length. Each of the two contacts deflects by less than 1e-5 of a side,
/// 1000 times less than the sinking of an undetected corner in this time.
#[test]
fn small_boxes_that_cross_lie_on_one_another() {
    let cube = |side_m: f64| Vector3::repeat(side_m);
    let bar = Vector3::new(0.015, 0.005, 0.005);
    for (size_m, turned_deg) in [
        (cube(0.015), 10.0),
        (cube(0.018), 10.0),
        (cube(0.002), 10.0),
        (cube(0.015), 0.01),
        (bar, 90.0),
        (0.2 * bar, 30.0),
    ] {
        let mut world = world(&Floor::default(), 1e-3);
        let put = |world: &mut World, name: &str, turned_deg: f64| {
            let place_m = Vector2::new(1.0, 0.0);
            let mut body = FreeBody::new(
                name,
                FreeShape::Box {
                    size_m: size_m.into(),
                },
                0.01,
                place_m,
            );
            let turned_rad = turned_deg.to_radians();
            body.rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turned_rad);
            world.add_body(&body).expect("room")
        };
        put(&mut world, "low", 0.0);
        let high = put(&mut world, "high", turned_deg);
        (0..500).for_each(|_| world.step());
        let sunk_m = 1.5 * size_m.z - place(&world, high).z;
        println!("{size_m:?} at {turned_deg} deg: {sunk_m:e} m");
        assert!(sunk_m.abs() < 2e-5 * size_m.z, "{sunk_m} of {size_m:?}");
    }
}

/// Down a slope a sphere rolls with 5/7 g sin and a cylinder with 2/3 g sin, without slip.
#[test]
fn a_sphere_and_a_cylinder_roll_as_they_should() {
    let slope_rad = 0.1_f64;
    let floor = Floor {
        slope_rad,
        ..Floor::default()
    };
    let radius_m = 0.07;
    let lies = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
    let shapes = [
        (
            FreeShape::Sphere { radius_m },
            5.0 / 7.0,
            UnitQuaternion::identity(),
        ),
        (
            FreeShape::Cylinder {
                radius_m,
                length_m: 0.1,
            },
            2.0 / 3.0,
            lies,
        ),
    ];
    for dt_s in [1e-3, 2e-3] {
        for (shape, share, rotation) in shapes {
            let mut world = world(&floor, dt_s);
            let mut body = FreeBody::new("ball", shape, 1.3, Vector2::new(0.0, 1.0));
            body.rotation = rotation;
            let id = world.add_body(&body).expect("room");
            assert!((place(&world, id).z - radius_m).abs() < 1e-6);
            let before_j = stored_j(&world);
            // First it settles on the floor, by less than a micrometre.
            let steps = (0.1 / dt_s) as usize;
            (0..steps).for_each(|_| world.step());
            let from_m_s = velocity(&world, id).x;
            (0..9 * steps).for_each(|_| world.step());
            let state = world.free_body(id).unwrap();
            let gained_m_s = state.velocity_m_s.x - from_m_s;
            let expected_m_s = share * G * slope_rad.sin() * (9.0 * steps as f64 * dt_s);
            println!("{share} {dt_s}: {gained_m_s} of {expected_m_s}");
            // It rolls on a radius reduced by its deflection into the floor, 4 * 5.5e-6 of its unit
            // of length: 1.8e-5.
            const PRESSED: f64 = 2e-5;
            assert!((gained_m_s / expected_m_s - 1.0).abs() < PRESSED);
            let slips = state.velocity_m_s.x - radius_m * state.angular_rad_s.y;
            assert!(slips.abs() < PRESSED * state.velocity_m_s.x, "{slips}");
            assert!(state.velocity_m_s.y.abs() < 1e-6);
            let missing_j = missing_j(&world, before_j);
            assert!(missing_j.abs() < 1e-3, "{missing_j}");
        }
    }
}

/// Rollers alone push a box: the robot has no chassis to touch. The forces on wheel and box are
/// equal and opposite.
#[test]
fn rollers_push_a_box_that_stands_before_a_wheel() {
    let mut world = World::new(
        &mecanum4(),
        &Floor::default(),
        Pose::default(),
        &settings(1e-3),
    )
    .expect("it stands");
    let mut body = cube("box", 0.1, 1.0, FRONT_M + 0.05 + 2e-3, 0.16);
    body.friction = 0.3;
    let id = world.add_body(&body).expect("room");
    let from = place(&world, id);
    let before_j = stored_j(&world);
    for _ in 0..600 {
        hold(&mut world, 4.0);
        world.step();
    }
    let state = world.free_body(id).unwrap();
    let moved_m = state.place_m - from;
    println!(
        "{moved_m:?} {:?} {}",
        state.force_from_robots_n, state.work_of_robots_j
    );
    assert!(moved_m.x > 0.08 && state.work_of_robots_j > 0.0);
    let missing_j = missing_j(&world, before_j);
    println!("missing {missing_j} of {}", world.motor_energy_j());
    assert!(missing_j.abs() < 1e-3 * world.motor_energy_j());
}

/// A motion to the left mirrors one to the right.
#[test]
fn a_push_beside_the_middle_is_its_own_mirror_image() {
    let ends: Vec<_> = [1.0, -1.0]
        .into_iter()
        .map(|side| {
            let mut world = world(&Floor::default(), 1e-3);
            let mut body = cube("box", 0.12, 2.0, 0.3, 0.04 * side);
            body.friction = 0.3;
            body.rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.3 * side);
            let id = world.add_body(&body).expect("room");
            for _ in 0..500 {
                hold(&mut world, 4.0);
                world.step();
            }
            let (state, robot) = (world.free_body(id).unwrap(), world.robot().state());
            let [_, _, yaw] = ilon_robot::roll_pitch_yaw(&state.rotation.to_rotation_matrix());
            let pose = robot.pose;
            [
                state.place_m.x,
                side * state.place_m.y,
                side * yaw,
                pose.x_m,
                side * pose.y_m,
                side * pose.heading_rad,
            ]
        })
        .collect();
    println!("{ends:?}");
    assert!((ends[0][2] - 0.3).abs() > 0.01, "it turns");
    for (left, right) in ends[0].iter().zip(&ends[1]) {
        assert!((left - right).abs() < 1e-5, "{ends:?}");
    }
}

/// Without gravity a moment of M for a step turns a body of any shape about each of its axes by M
/// dt / I, with the inertias of textbooks.
#[test]
fn bodies_turn_with_the_inertia_of_their_shapes() {
    let (mass_kg, dt_s, moment_n_m) = (2.0, 1e-3, 0.1);
    let (a, b, c) = (0.1, 0.2, 0.3);
    let of_box = [b * b + c * c, a * a + c * c, a * a + b * b].map(|square| square / 12.0);
    let across = a * a / 4.0 + c * c / 12.0;
    let shapes = [
        (FreeShape::Box { size_m: [a, b, c] }, of_box),
        (
            FreeShape::Cylinder {
                radius_m: a,
                length_m: c,
            },
            [across, across, a * a / 2.0],
        ),
        (FreeShape::Sphere { radius_m: a }, [0.4 * a * a; 3]),
    ];
    for (shape, inertia_m2) in shapes {
        let weightless = Settings {
            gravity_m_s2: 0.0,
            ..settings(dt_s)
        };
        let mut world = World::new(&robot(), &Floor::default(), Pose::default(), &weightless)
            .expect("it floats");
        let mut body = cube("body", 0.1, mass_kg, 2.0, 0.0);
        (body.shape, body.height_m) = (shape, Some(1.0));
        for (axis, inertia_m2) in inertia_m2.into_iter().enumerate() {
            body.place_m.y = axis as f64;
            let id = world.add_body(&body).expect("room");
            // A pair of forces: one at a lever, and the opposite one at the centre.
            let lever = Vector3::ith((axis + 1) % 3, 1.0);
            let force_n = Vector3::ith((axis + 2) % 3, moment_n_m);
            world.push_body(id, force_n, lever);
            world.push_body(id, -force_n, Vector3::zeros());
            world.step();
            let turns = world.free_body(id).expect("it is there").angular_rad_s;
            let expected_rad_s = moment_n_m * dt_s / (mass_kg * inertia_m2);
            let expected = Vector3::ith(axis, expected_rad_s);
            // The midpoint rule at a rotation by 1e-5 rad.
            assert!(
                (turns - expected).norm() < 1e-4 * expected_rad_s,
                "{turns} {expected}"
            );
        }
    }
}

/// A can between a robot, whose wheels spin at the limit of their grip, and a box that is too heavy
/// passes on the force. A wheel's rollers turn freely across their axes, so that its grip mu N acts
/// along them, at 45 degrees: F = mu (m g + F_z) / sqrt(2), with F_z the friction of the can's side
/// on the robot. It touches each of its neighbours along a line whose two ends carry it, and every
/// step is solved.
#[test]
fn a_can_hands_on_the_force_to_a_box_that_is_too_heavy() {
    const FRICTION: f64 = 0.6;
    let floor = Floor {
        friction: FRICTION,
        ..Floor::default()
    };
    let mut world = world(&floor, 1e-3);
    let shape = FreeShape::Cylinder {
        radius_m: 0.05,
        length_m: 0.15,
    };
    let can = FreeBody::new("can", shape, 0.5, Vector2::new(0.3, 0.0));
    let can = world.add_body(&can).expect("room");
    let heavy = cube("heavy", 0.3, 60.0, 0.55, 0.0);
    world.add_body(&heavy).expect("room");
    let mut residual_m_s = 0.0_f64;
    for _ in 0..1000 {
        hold(&mut world, 8.0);
        world.step();
        residual_m_s = residual_m_s.max(world.contact_residual_m_s());
    }
    let can = world.free_body(can).expect("it is there");
    assert!(can.velocity_m_s.norm() < 1e-6, "{}", can.velocity_m_s);
    let push_n = can.force_from_robots_n;
    let grip_n = FRICTION * (robot().mass_kg() * G + push_n.z) / f64::sqrt(2.0);
    // Rollers' bearings and the wheels' rotation take less than a thousandth.
    assert!((push_n.x / grip_n - 1.0).abs() < 1e-3, "{push_n} {grip_n}");
    // All laws hold to the solver's tolerance.
    assert!(residual_m_s <= 1e-8, "{residual_m_s:e}");
}
