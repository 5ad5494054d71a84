//! Bodies on joints that touch the ground, boxes and free bodies, against mechanics by hand.

use crate::support;

use std::f64::consts::FRAC_PI_2;

use ilon_robot::{
    Collision, CollisionShape, FreeShape, JointKind, JointRole, JointServo, Pose, Robot,
};
use ilon_world::{Floor, FreeBody, GroundBox, Settings, World, WorldError};
use nalgebra::{Isometry3, Vector3};
use support::linked::{X_M, joint};
use support::{brake, mecanum4};

const G: f64 = 9.81;
const ARM_KG: f64 = 1.0;
const CUBE_KG: f64 = 1.5;
/// From the arm's axis to its centre and to the ball at its end, in metres.
const MIDDLE_M: f64 = 0.2;
const REACH_M: f64 = 0.4;
const BALL_M: f64 = 0.02;
/// Height of the axis over the body frame's origin, in metres.
const AXIS_M: f64 = 0.12;

/// The mecanum4 with an arm ahead that turns about an axis in the middle of the robot, with a ball
/// at its end, and a servo without damping in its stiffness's way.
fn with_arm(axis: Vector3<f64>, servo: JointServo) -> Robot {
    let mut robot = mecanum4();
    let pivot_m = Vector3::z() * AXIS_M;
    let law = (JointKind::Turns, JointRole::Driven(servo));
    let moves = (ARM_KG, pivot_m + Vector3::x() * MIDDLE_M);
    let mut arm = joint("arm", law, (pivot_m, axis), moves);
    let at_m = pivot_m + Vector3::x() * REACH_M;
    arm.body.collisions.push(Collision {
        friction: None,
        body_from_shape: Isometry3::translation(at_m.x, at_m.y, at_m.z),
        shape: CollisionShape::Sphere { radius_m: BALL_M },
    });
    robot.joints.push(arm);
    robot
}

fn ice() -> Floor {
    Floor {
        friction: 0.0,
        ..Floor::default()
    }
}

fn world(robot: &Robot) -> World {
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    World::new(robot, &ice(), Pose::default(), &settings).expect("it stands")
}

/// Steps with braked wheels.
fn step(world: &mut World) {
    brake(world);
    world.step();
}

fn assert_near(value: f64, expected: f64, within: f64, what: &str) {
    assert!(
        (value - expected).abs() <= within * expected.abs(),
        "{what}: {value} where {expected} is expected"
    );
}

/// The arm reaches down and presses on the floor: the part of the servo's torque beyond the arm's
/// own weight is a load on the ball, and the wheels bear the rest, by moments about either axle.
#[test]
fn an_arm_that_presses_on_the_floor_takes_load_off_the_wheels() {
    let servo = JointServo {
        stiffness: 100.0,
        damping: 10.0,
        ..JointServo::for_inertia(1.0)
    };
    /// Steps of which the mean is taken.
    const MEAN_OF: u32 = 200;
    let mut world = world(&with_arm(Vector3::y(), servo));
    // The ball's centre is AXIS_M over the floor's distance from the frame: it touches at about sin
    // q = 0.25, and its target is beyond that.
    for target in [0.1, 0.2, 0.28, 0.33] {
        world.robot_mut().aim_joint(0, target, 0.0).expect("driven");
        for _ in 0..1500 {
            step(&mut world);
        }
    }
    // A step of a solver with a tolerance of 1e-8 m/s may miss m 1e-8 m/s / 1 ms = 1e-4 N of the
    // weight: the mean of many does not.
    let mut carried_n = 0.0;
    for _ in 0..MEAN_OF {
        step(&mut world);
        let support = world.robot().support();
        carried_n += (support.wheels_n + support.chassis_n) / f64::from(MEAN_OF);
    }
    let robot = world.robot();
    let state = robot.state();
    let torque = robot.joint_forces()[0];
    // Down and ahead, from the horizontal.
    let angle = robot.joint_positions()[0] + state.pitch_rad;
    let ball_n = robot.support().chassis_n;
    // About the axis: the servo's torque and the weight are supported by the ball.
    let by_hand = (torque + ARM_KG * G * MIDDLE_M * angle.cos()) / (REACH_M * angle.cos());
    assert!(ball_n > 5.0, "{ball_n}");
    assert_near(ball_n, by_hand, 1e-4, "ball");
    let weight_n = (mecanum4().mass_kg() + ARM_KG) * G;
    assert_near(carried_n, weight_n, 1e-6, "sum");
    // About the rear axle: the robot without its arm has equal loads.
    let loads = robot.contacts();
    let front_n = loads[0].normal_force_n + loads[1].normal_force_n;
    let off_n = ARM_KG * G * MIDDLE_M - ball_n * REACH_M;
    let hand_n = 0.5 * weight_n - 0.5 * ball_n + off_n * angle.cos() / (2.0 * X_M);
    println!("{ball_n} {by_hand} {front_n} {hand_n} {}", state.pitch_rad);
    // The robot is tilted by some hundredth of a milliradian, and its levers start at the wheels'
    // contacts.
    assert_near(front_n, hand_n, 1e-3, "front");
}

fn cube(place_m: [f64; 2]) -> FreeBody {
    FreeBody {
        friction: 0.0,
        ..FreeBody::new(
            "cube",
            FreeShape::Box { size_m: [0.3; 3] },
            CUBE_KG,
            place_m.into(),
        )
    }
}

/// The momentum of robot and cube in the plane, in N s.
fn momentum_n_s(world: &World, cube: ilon_world::FreeBodyId) -> Vector3<f64> {
    let (robot, free) = (world.robot(), world.free_body(cube).expect("there"));
    let (state, body) = (robot.state(), mecanum4());
    let turned = state.world_from_body;
    let rates = turned * state.angular_in_body_rad_s;
    let of_origin = turned * state.velocity_in_body_m_s;
    let velocity = |place_m: Vector3<f64>| of_origin + rates.cross(&(turned * place_m));
    let at = robot.joint_positions()[0];
    let arm_m = MIDDLE_M * Vector3::new(at.cos(), at.sin(), 0.0);
    let swings = robot.joint_rates()[0] * (turned * Vector3::z()).cross(&(turned * arm_m));
    let of_arm = velocity(arm_m + Vector3::z() * AXIS_M) + swings;
    let own = body.mass_kg() * velocity(body.center_of_mass_m());
    own + ARM_KG * of_arm + CUBE_KG * free.velocity_m_s
}

/// An arm that swings out on ice hits a cube: both impulses are internal, so that the total
/// momentum is zero, as at the start, and the servo's work is kinetic energy or impact loss. The
/// impact is found in the step's middle, and the forces of rotating frames use the arm's rates w
/// before and w' after it: of the m r (w^2 - w'^2) dt / 2 = 0.018 N s that one of them alone would
/// miss at 1 ms, the remainder is of second order.
#[test]
fn an_arm_that_hits_a_free_body_keeps_the_momentum() {
    let of_step = |dt_s: f64| {
        let servo = JointServo {
            stiffness: 20.0,
            damping: 1.0,
            ..JointServo::for_inertia(1.0)
        };
        let settings = Settings {
            dt_s,
            ..Settings::default()
        };
        let robot = with_arm(Vector3::z(), servo);
        let mut world = World::new(&robot, &ice(), Pose::default(), &settings).expect("it stands");
        let cube = world.add_body(&cube([0.45, 0.4])).expect("it lies");
        let start = world.energy();
        world
            .robot_mut()
            .aim_joint(0, FRAC_PI_2, 0.0)
            .expect("driven");
        let (mut of_cube_n_s, mut of_all_n_s) = (0.0_f64, 0.0_f64);
        while world.time_s() < 0.6 {
            world.step();
            let cube_n_s = CUBE_KG
                * world
                    .free_body(cube)
                    .expect("there")
                    .velocity_m_s
                    .xy()
                    .norm();
            of_cube_n_s = of_cube_n_s.max(cube_n_s);
            of_all_n_s = momentum_n_s(&world, cube).xy().norm();
        }
        let now = world.energy();
        let gained_j = now.kinetic_j + now.potential_j - start.kinetic_j - start.potential_j;
        let lost_j = world.slip_energy_j()
            + world.spin_up_energy_j()
            + world.bearing_energy_j()
            + world.impact_energy_j();
        let did_j = world.motor_energy_j();
        // On ice all of the cube's momentum comes from the arm, except for the ground's part if it
        // is hit under its centre.
        let free = world.free_body(cube).expect("there");
        let inertia = CUBE_KG * 0.3 * 0.3 / 6.0;
        let moves_j = 0.5 * CUBE_KG * free.velocity_m_s.norm_squared()
            + 0.5 * inertia * free.angular_rad_s.norm_squared();
        let work_j = free.work_of_robots_j;
        assert!(
            moves_j < 1.001 * work_j && moves_j > 0.98 * work_j,
            "{moves_j} of {work_j}"
        );
        println!("{dt_s}: {of_cube_n_s} {of_all_n_s} {did_j} {gained_j} {lost_j}");
        assert!(of_cube_n_s > 1.0, "{of_cube_n_s}");
        (of_all_n_s, (did_j - gained_j - lost_j) / did_j)
    };
    let ((coarse, open), (fine, finer_open)) = (of_step(1e-3), of_step(2.5e-4));
    assert!(coarse < 2e-3 && fine < coarse / 7.0, "{coarse} {fine}");
    assert!(
        open.abs() < 1e-2 && finer_open.abs() < open.abs() / 3.0,
        "{open} {finer_open}"
    );
}

/// A box on the ground blocks an arm like a wall: the arm stops there, and its servo pushes against
/// it.
#[test]
fn an_arm_leans_on_a_box_of_the_ground() {
    let servo = JointServo {
        stiffness: 20.0,
        damping: 5.0,
        ..JointServo::for_inertia(1.0)
    };
    let mut floor = Floor {
        friction: 1.0,
        ..Floor::default()
    };
    floor.boxes.push(GroundBox {
        center_m: Vector3::new(0.0, 0.5, 0.2),
        half_sides_m: Vector3::new(0.5, 0.2, 0.2),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    });
    let settings = Settings::default();
    let robot = with_arm(Vector3::z(), servo);
    let mut world = World::new(&robot, &floor, Pose::default(), &settings).expect("it stands");
    world.robot_mut().aim_joint(0, 1.2, 0.0).expect("driven");
    for _ in 0..2000 {
        step(&mut world);
    }
    let at = world.robot().joint_positions()[0];
    let heading = world.robot().state().pose.heading_rad;
    let touches_m = REACH_M * (at + heading).sin() + world.robot().state().pose.y_m;
    // The ball's radius before the wall at 0.3 m, and the contact's deflection.
    assert!((touches_m - (0.3 - BALL_M)).abs() < 1e-4, "{touches_m}");
    // The wall's force along y, times its lever, is the servo's torque; friction at the ball acts
    // along x on a lever of y.
    let wall_n = -world.robot().support().obstacles_n.y;
    assert!(wall_n > 1.0, "{wall_n}");
}

/// A body that would start in the ground is refused with its name, its joint, and a remedy.
#[test]
fn an_arm_that_begins_in_the_ground_is_refused() {
    let servo = JointServo {
        target: 1.2,
        ..JointServo::for_inertia(1.0)
    };
    let robot = with_arm(Vector3::y(), servo);
    let refused = World::new(&robot, &ice(), Pose::default(), &Settings::default());
    let Err(error @ WorldError::NoPlaceToStand { .. }) = refused else {
        panic!("it began in the ground");
    };
    let words = error.to_string();
    assert!(
        words.contains("on joint `arm`") && words.contains("mm deep"),
        "{words}"
    );
}

/// Two robots touch each other by an arm like by their chassis: on ice one gains what the other
/// loses. In either order in the world they move the same way: contacts are found in the frame of
/// the first, to rounding.
#[test]
fn an_arm_pushes_another_robot() {
    let servo = JointServo {
        stiffness: 20.0,
        damping: 2.0,
        ..JointServo::for_inertia(1.0)
    };
    let mut other = mecanum4();
    other.chassis.collisions.push(Collision {
        friction: None,
        body_from_shape: Isometry3::translation(0.0, 0.0, 0.13),
        shape: CollisionShape::Box {
            half_extents_m: Vector3::new(0.2, 0.12, 0.1),
        },
    });
    let robots = [with_arm(Vector3::z(), servo), other];
    let starts = [
        Pose::default(),
        Pose {
            x_m: 0.1,
            y_m: 0.42,
            heading_rad: 0.0,
        },
    ];
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    let ends = [[0, 1], [1, 0]].map(|order| {
        let robots = order.map(|k| (ilon_world::SharedRobot::from(&robots[k]), starts[k]));
        let mut world = World::of_bodies(robots, &ice(), &settings).expect("they stand");
        let ids: Vec<_> = world.bodies().collect();
        let [pushes, pushed] = order.map(|k| ids[k]);
        world
            .body_mut(pushes)
            .aim_joint(0, FRAC_PI_2, 0.0)
            .expect("driven");
        for _ in 0..500 {
            world.step();
        }
        let state = world.body(pushed).state();
        let speed_m_s = state.velocity_in_body_m_s.norm();
        println!("{speed_m_s} {:?}", state.pose);
        // Away from the arm, to the left of the pushing robot.
        assert!(
            speed_m_s > 0.05 && state.pose.y_m > 0.43,
            "{speed_m_s} {:?}",
            state.pose
        );
        let pose = world.body(pushes).state().pose;
        assert!(pose.y_m < -1e-3);
        [state.pose, pose].map(|pose| pose.position_m())
    });
    for (one, other) in ends[0].iter().zip(&ends[1]) {
        let apart_m = (one - other).norm();
        println!("{apart_m:e} m");
        assert!(apart_m < 1.5e-5, "{apart_m:e} m");
    }
}

/// An arm that would start in a box of the ground is refused, with its depth and a remedy; one that
/// only touches it is not.
#[test]
fn an_arm_may_not_begin_in_a_box_of_the_ground() {
    let servo = JointServo::for_inertia(1.0);
    let robot = with_arm(Vector3::y(), servo);
    let built = |top_m: f64| {
        let half_sides_m = Vector3::new(0.05, 0.05, 0.5 * top_m);
        let stands = GroundBox {
            center_m: Vector3::new(REACH_M + 0.1, 0.0, half_sides_m.z),
            half_sides_m: half_sides_m + Vector3::x() * 0.1,
            heading_rad: 0.0,
            pitch_rad: 0.0,
        };
        let floor = Floor {
            boxes: vec![stands],
            ..ice()
        };
        World::new(&robot, &floor, Pose::default(), &Settings::default())
    };
    // The ball's lower side is at the height of the axis minus its radius.
    built(AXIS_M - BALL_M - 1e-3).expect("beneath the arm");
    let error = built(AXIS_M - BALL_M + 0.015).err().expect("in the arm");
    let text = error.to_string();
    assert!(text.contains("begin 15 mm deep in the ground"), "{text}");
    assert!(text.contains("joint `arm`"), "{text}");
}
