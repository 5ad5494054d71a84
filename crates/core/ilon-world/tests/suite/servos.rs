//! Driven arms and lifts, against mechanics by hand.

use crate::support;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use ilon_robot::{JointKind, JointRole, JointServo, Pose, Robot};
use ilon_world::{Floor, MotorTorque, Push, Settings, World};
use nalgebra::{Point3, Vector3};
use support::linked::joint;
use support::{brake, mecanum4};

const G: f64 = 9.81;
/// The arm's mass, and the distance of its centre from its axis.
const ARM_KG: f64 = 2.0;
const ARM_M: f64 = 0.4;

fn servo(stiffness: f64, damping: f64) -> JointServo {
    JointServo {
        stiffness,
        damping,
        ..JointServo::for_inertia(1.0)
    }
}

/// The mecanum4 with a body of a mass at a place that moves on a joint above the middle of its
/// chassis.
fn with(kind: JointKind, axis: Vector3<f64>, at_m: Vector3<f64>, servo: JointServo) -> Robot {
    let mut robot = mecanum4();
    let place_m = robot.center_of_mass_m();
    let law = (kind, JointRole::Driven(servo));
    let moves = (ARM_KG, place_m + at_m);
    robot.joints.push(joint("arm", law, (place_m, axis), moves));
    robot
}

fn arm(axis: Vector3<f64>, servo: JointServo) -> Robot {
    with(JointKind::Turns, axis, Vector3::x() * ARM_M, servo)
}

fn lift(servo: JointServo) -> Robot {
    with(JointKind::Slides, Vector3::z(), Vector3::zeros(), servo)
}

fn drawer(servo: JointServo) -> Robot {
    with(JointKind::Slides, Vector3::x(), Vector3::zeros(), servo)
}

fn world(robot: &Robot, floor: &Floor, gravity_m_s2: f64, dt_s: f64) -> World {
    let settings = Settings {
        dt_s,
        gravity_m_s2,
        ..Settings::default()
    };
    World::new(robot, floor, Pose::default(), &settings).expect("it stands")
}

fn ice() -> Floor {
    Floor {
        friction: 0.0,
        ..Floor::default()
    }
}

/// Steps with held wheels.
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

fn at(world: &World) -> f64 {
    world.robot().joint_positions()[0]
}

/// An arm held level sags until its servo's stiffness bears m g l, from the first step on.
#[test]
fn a_servo_bears_an_arm_by_its_stiffness() {
    let stiffness = 2000.0;
    let robot = arm(Vector3::y(), servo(stiffness, 20.0));
    let mut world = world(&robot, &Floor::default(), G, 1e-3);
    for _ in 0..200 {
        step(&mut world);
    }
    let (sags, pitch) = (at(&world), world.robot().state().pitch_rad);
    let borne = world.robot().joint_forces()[0];
    println!("{sags} {borne} {pitch}");
    assert_near(
        borne,
        -ARM_KG * G * ARM_M * (sags + pitch).cos(),
        1e-6,
        "torque",
    );
    assert_near(sags, -borne / stiffness, 1e-6, "sag");
}

/// A load on a slide without gravity oscillates against the rest of the robot at sqrt(K / mu), mu
/// the reduced mass of the two.
#[test]
fn a_step_of_the_target_swings_at_the_natural_frequency() {
    let reduced_kg = ARM_KG * mecanum4().mass_kg() / (ARM_KG + mecanum4().mass_kg());
    let stiffness = reduced_kg * (TAU * 5.0).powi(2);
    let mut world = world(&drawer(servo(stiffness, 0.0)), &ice(), 0.0, 1e-3);
    world.robot_mut().aim_joint(0, 0.01, 0.0).expect("driven");
    let mut passes_s = Vec::new();
    let mut before = at(&world) - 0.01;
    while passes_s.len() < 21 {
        world.step();
        let now = at(&world) - 0.01;
        if before * now < 0.0 {
            passes_s.push(world.time_s() - 1e-3 * now / (now - before));
        }
        before = now;
        assert!(world.time_s() < 5.0);
    }
    let frequency_hz = 10.0 / (passes_s[20] - passes_s[0]);
    println!("{frequency_hz}");
    // The midpoint rule is slower by (omega dt)^2 / 12 = 8e-5.
    assert_near(frequency_hz, 5.0, 2e-4, "frequency");
}

/// Far from its target a servo acts with its effort, in steps of any length: the load gains F / mu.
#[test]
fn a_servo_at_its_effort_accelerates_by_it() {
    let reduced_kg = ARM_KG * mecanum4().mass_kg() / (ARM_KG + mecanum4().mass_kg());
    for (dt_s, aim) in [(1e-3, 1.0), (5e-3, -1.0)] {
        let strong = JointServo {
            effort: 3.0,
            ..servo(1e4, 5000.0)
        };
        let mut world = world(&drawer(strong), &ice(), 0.0, dt_s);
        world.robot_mut().aim_joint(0, aim, 0.0).expect("driven");
        for _ in 0..20 {
            world.step();
            assert_near(world.robot().joint_forces()[0], 3.0 * aim, 1e-9, "force");
        }
        let rate_m_s = world.robot().joint_rates()[0];
        assert_near(
            rate_m_s,
            3.0 * aim / reduced_kg * world.time_s(),
            1e-9,
            "rate",
        );
        // It still comes to rest there, and its effort is never exceeded.
        for _ in 0..(6.0 / dt_s) as usize {
            world.step();
            assert!(world.robot().joint_forces()[0].abs() <= 3.0 * (1.0 + 1e-9));
        }
        // Near it the error decays as exp(-K t / D).
        assert_near(at(&world), aim, 1e-4, "place");
    }
}

/// A servo's demand at the beginning of a step may exceed its effort, here K q = 40 N, while its
/// force in the step is within it, because the load moves: then its effort has no effect.
#[test]
fn an_effort_that_a_step_does_not_come_to_changes_nothing() {
    let force_n = |effort: f64| {
        let robot = drawer(JointServo {
            effort,
            ..servo(1e4, 5000.0)
        });
        let mut world = world(&robot, &ice(), 0.0, 5e-3);
        world.robot_mut().aim_joint(0, 4e-3, 0.0).expect("driven");
        world.step();
        world.robot().joint_forces()[0]
    };
    let free_n = force_n(1e9);
    assert!((0.0..3.0).contains(&free_n), "{free_n}");
    // The solver ends within 1e-8 m/s: of a kilogram in 5 ms, 2e-6 N.
    assert_near(force_n(3.0), free_n, 1e-5, "force");
}

/// Of two drawers the commanded one moves, by F t^2 / 2 m, to the thousandth by which the base on
/// its held wheels deflects; the other stays in place.
#[test]
fn of_two_servos_the_one_that_is_told_acts() {
    const FORCE_N: f64 = 5.0;
    const STEPS: usize = 100;
    let mut robot = drawer(servo(1e3, 50.0));
    let place_m = robot.center_of_mass_m();
    let law = (JointKind::Slides, JointRole::Driven(servo(1e3, 50.0)));
    let moves = (ARM_KG, place_m);
    robot
        .joints
        .push(joint("across", law, (place_m, Vector3::y()), moves));
    for told in [0, 1] {
        let mut world = world(&robot, &Floor::default(), G, 1e-3);
        world.robot_mut().load_joint(told, FORCE_N).expect("driven");
        for _ in 0..STEPS {
            step(&mut world);
        }
        let time_s = 1e-3 * STEPS as f64;
        let expected_m = FORCE_N / ARM_KG * time_s * time_s / 2.0;
        let positions_m = world.robot().joint_positions();
        println!("{positions_m:?} {expected_m}");
        assert_near(positions_m[told], expected_m, 0.01, "way");
        assert!(positions_m[1 - told].abs() < 1e-3 * expected_m);
    }
}

/// A damper of c acts with the mean of the rates before and after a step, so that each step leaves
/// (1 - z / 2) / (1 + z / 2) of a rate, z = c dt / mu.
#[test]
fn a_damper_takes_the_mean_rate_of_a_step() {
    let reduced_kg = ARM_KG * mecanum4().mass_kg() / (ARM_KG + mecanum4().mass_kg());
    for (dt_s, damping) in [(1e-3, 2.0), (5e-3, 20.0)] {
        let mut robot = drawer(servo(1e4, 100.0));
        robot.joints[0].damping = damping;
        let mut world = world(&robot, &ice(), 0.0, dt_s);
        world.robot_mut().load_joint(0, 5.0).expect("driven");
        (0..10).for_each(|_| world.step());
        world.robot_mut().load_joint(0, 0.0).expect("driven");
        let half = 0.5 * damping * dt_s / reduced_kg;
        for _ in 0..10 {
            let before_m_s = world.robot().joint_rates()[0];
            world.step();
            let left = world.robot().joint_rates()[0] / before_m_s;
            assert_near(left, (1.0 - half) / (1.0 + half), 1e-9, "left");
        }
    }
}

/// The target of a jump moves at the rate limit, and the joint with it.
#[test]
fn a_rate_limit_bounds_how_fast_the_joint_follows() {
    let limited = JointServo {
        rate_limit: 0.5,
        ..JointServo::for_inertia(ARM_KG)
    };
    let mut world = world(&drawer(limited), &ice(), 0.0, 1e-3);
    world.robot_mut().aim_joint(0, 0.4, 0.0).expect("driven");
    let mut fastest_m_s: f64 = 0.0;
    while world.time_s() < 1.2 {
        world.step();
        fastest_m_s = fastest_m_s.max(world.robot().joint_rates()[0]);
        if (world.time_s() - 0.6).abs() < 1e-6 {
            // Stiffness and damping act on the error relative to a moving target: there is no lag.
            assert_near(at(&world), 0.3, 1e-3, "on its way");
            assert_near(world.robot().joint_rates()[0], 0.5, 1e-3, "rate");
        }
    }
    println!("{fastest_m_s}");
    // As it catches up, critically damped, it is faster by exp(-2) at most.
    assert!(fastest_m_s < 0.5 * 1.136, "{fastest_m_s}");
    assert_near(at(&world), 0.4, 1e-3, "there");
}

/// The inertia of a rigid robot about the vertical through a point, in kg m^2.
fn yaw_inertia(robot: &Robot, about_m: Vector3<f64>) -> f64 {
    let steiner = |mass_kg: f64, at_m: Vector3<f64>| mass_kg * (at_m - about_m).xy().norm_squared();
    let chassis = &robot.chassis.mass;
    let mut sum =
        chassis.inertia_kg_m2[(2, 2)] + steiner(chassis.mass_kg, chassis.center_of_mass_m);
    for wheel in &robot.wheels {
        let in_body = |at_m: Vector3<f64>| (wheel.body_from_hub * Point3::from(at_m)).coords;
        let up = wheel.body_from_hub.rotation.inverse() * Vector3::z();
        let hub = &wheel.hub;
        sum += up.dot(&(hub.inertia_kg_m2 * up));
        sum += steiner(hub.mass_kg, in_body(hub.center_of_mass_m));
        for roller in &wheel.rollers {
            let along = up.dot(&roller.axis_in_hub).powi(2);
            sum += steiner(roller.mass_kg, in_body(roller.center_in_hub_m))
                + along * roller.axial_inertia_kg_m2
                + (1.0 - along) * roller.transverse_inertia_kg_m2;
        }
    }
    sum
}

/// On ice an arm that swings out turns the base back: I_1 w_1 + (I_2 + mu l^2) w_2 = 0 about the
/// common centre of mass, with l from the base's centre of mass to the arm's, and mu their reduced
/// mass.
#[test]
fn an_arm_that_swings_on_ice_turns_the_base_back() {
    let robot = arm(
        Vector3::z(),
        JointServo::for_inertia(ARM_KG * ARM_M * ARM_M),
    );
    let base = mecanum4();
    let reduced_kg = ARM_KG * base.mass_kg() / (ARM_KG + base.mass_kg());
    let of_base = yaw_inertia(&base, base.center_of_mass_m());
    let of_arm = ARM_KG * 0.02 * 0.02 + reduced_kg * ARM_M * ARM_M;
    let mut world = world(&robot, &ice(), G, 1e-3);
    world
        .robot_mut()
        .aim_joint(0, FRAC_PI_2, 0.0)
        .expect("driven");
    let mut fastest_rad_s: f64 = 0.0;
    while world.time_s() < 1.0 {
        world.step();
        fastest_rad_s = fastest_rad_s.max(world.robot().joint_rates()[0]);
    }
    let yaw_rad = world.robot().state().pose.heading_rad;
    let expected_rad = -of_arm / (of_base + of_arm) * at(&world);
    println!("{yaw_rad} {expected_rad} {fastest_rad_s}");
    assert!(fastest_rad_s > 5.0);
    assert_near(yaw_rad, expected_rad, 1e-2, "yaw");
}

/// The error of the energy balance of an arm that swings up and out, and its servo's work, in J.
fn open_j(dt_s: f64) -> (f64, f64) {
    let mut robot = arm(Vector3::y(), servo(800.0, 20.0));
    robot.joints[0].damping = 0.3;
    robot.joints[0].friction = 0.2;
    robot.joints[0].role = JointRole::Driven(JointServo {
        effort: 9.0,
        ..servo(800.0, 20.0)
    });
    let mut world = world(&robot, &Floor::default(), G, dt_s);
    let stored_j = |world: &World| world.energy().kinetic_j + world.energy().potential_j;
    let spent_j = |world: &World| {
        world.slip_energy_j()
            + world.spin_up_energy_j()
            + world.impact_energy_j()
            + world.bearing_energy_j()
            - world.motor_energy_j()
    };
    step(&mut world);
    let (from_j, before_j) = (stored_j(&world) + spent_j(&world), world.motor_energy_j());
    let mut strongest: f64 = 0.0;
    while world.time_s() < 1.2 {
        let (sin, cos) = (PI * world.time_s().min(1.0)).sin_cos();
        let (at, rate) = (-0.6 * (1.0 - cos), -0.6 * PI * sin);
        world.robot_mut().aim_joint(0, at, rate).expect("driven");
        step(&mut world);
        strongest = strongest.max(world.robot().joint_forces()[0].abs());
    }
    // It reaches its effort on the way: damping and friction add the rest.
    assert!((9.0..11.0).contains(&strongest), "{strongest}");
    let open_j = stored_j(&world) + spent_j(&world) - from_j;
    (open_j.abs(), world.motor_energy_j() - before_j)
}

#[test]
fn the_work_of_a_servo_is_in_the_balance() {
    let (coarse_j, work_j) = open_j(1e-3);
    let (fine_j, _) = open_j(5e-4);
    println!("{coarse_j:e} {fine_j:e} of {work_j}");
    // It raises the arm by l sin 1.2: 7.3 J.
    assert!(work_j > 7.0, "{work_j}");
    assert!(coarse_j < 1e-6 * work_j, "{coarse_j} of {work_j}");
    assert!(
        fine_j < 0.3 * coarse_j + 1e-8 * work_j,
        "{fine_j} {coarse_j}"
    );
}

/// An arm that swings from ahead to the side tips the robot when the moment of the weights passes
/// the wheels' edge: sin q = Y (M + m) / (m l).
#[test]
fn an_arm_tips_the_robot_where_its_moment_passes_the_edge() {
    let edge_m = 0.16;
    let begins = JointServo {
        target: 0.7,
        ..JointServo::for_inertia(2.0)
    };
    let mut robot = arm(Vector3::z(), begins);
    robot.joints[0].body.mass.mass_kg = 8.0;
    let base_kg = mecanum4().mass_kg();
    let reach_m = edge_m * (base_kg + 8.0) / 8.0;
    println!("{base_kg} {reach_m}");
    // With the length at which it tips at 60 degrees.
    let length_m = reach_m / (TAU / 6.0).sin();
    let mass = robot.joints[0].body.mass.clone();
    robot.joints[0].body.mass.center_of_mass_m = mass.center_of_mass_m * (length_m / ARM_M);
    let mut world = world(&robot, &Floor::default(), G, 2e-3);
    let mut tips = None;
    while world.time_s() < 20.0 && tips.is_none() {
        let target = 0.7 + 0.05 * world.time_s();
        world
            .robot_mut()
            .aim_joint(0, target, 0.05)
            .expect("driven");
        step(&mut world);
        let contacts = world.robot().contacts();
        if contacts.iter().filter(|wheel| !wheel.touching).count() >= 2 {
            tips = Some(at(&world));
        }
    }
    println!("{tips:?}");
    assert_near(tips.expect("it tips"), TAU / 6.0, 1e-2, "tips");
}

/// A servo that is too weak lets its load sink to the stop, and bears a part with its effort.
#[test]
fn a_servo_that_is_too_weak_lets_its_load_down() {
    let weak = JointServo {
        effort: 0.5 * ARM_KG * G,
        ..servo(1e4, 100.0)
    };
    let mut robot = lift(weak);
    robot.joints[0].limits = [-0.05, 0.2];
    let mut world = world(&robot, &Floor::default(), G, 1e-3);
    for _ in 0..100 {
        step(&mut world);
    }
    assert_near(at(&world), -0.05, 1e-3, "place");
    // The stop bears the other half.
    assert_near(world.robot().joint_forces()[0], ARM_KG * G, 1e-4, "force");
}

/// Commands to undriven joints, positions beyond the limits and non-finite numbers are refused with
/// the joint's name; then nothing changes.
#[test]
fn what_no_servo_can_do_is_refused_in_words() {
    let mut robot = lift(servo(1e4, 100.0));
    robot.joints[0].limits = [0.0, 0.2];
    let mut stands = world(&robot, &Floor::default(), G, 1e-3);
    for (position, rate, words) in [
        (0.3, 0.0, "its limits are 0 and 0.2"),
        (f64::NAN, 0.0, "finite"),
        (0.1, f64::INFINITY, "finite"),
    ] {
        let refused = stands.robot_mut().aim_joint(0, position, rate).unwrap_err();
        let refused = refused.to_string();
        assert!(
            refused.contains(words) && refused.contains("`arm`"),
            "{refused}"
        );
    }
    robot.joints[0].role = JointRole::Free;
    let mut free = world(&robot, &Floor::default(), G, 1e-3);
    let refused = free.robot_mut().aim_joint(0, 0.1, 0.0).unwrap_err();
    assert!(
        refused.to_string().contains("nothing drives it"),
        "{refused}"
    );
    for (spoils, words) in [
        (
            JointServo {
                effort: 0.0,
                ..servo(1.0, 0.0)
            },
            "effort and rate limit must be above 0",
        ),
        (
            JointServo {
                rate_limit: f64::NAN,
                ..servo(1.0, 0.0)
            },
            "effort and rate limit",
        ),
        (
            JointServo {
                target: 1.0,
                ..servo(1.0, 0.0)
            },
            "not between its limits",
        ),
        (servo(0.0, 0.0), "stiffness"),
        (servo(1.0, -1.0), "damping"),
        (servo(1e12, 0.0), "its servo of"),
    ] {
        robot.joints[0].role = JointRole::Driven(spoils);
        let refused = World::new(
            &robot,
            &Floor::default(),
            Pose::default(),
            &Settings::default(),
        );
        let refused = refused.err().expect("refused").to_string();
        assert!(
            refused.contains(words) && refused.contains("`arm`"),
            "{words}: {refused}"
        );
    }
}

/// A rotor about the vertical, over the middle of the robot, accelerates more and more on a
/// friction of 0.1: the held wheels begin to slide when its reaction reaches the limit of the
/// rollers, each mu N along its axis on a lever of (l + w) / sqrt 2; from there on the base turns
/// by the angular momentum that they do not absorb.
#[test]
fn a_base_on_grip_alone_slides_and_turns_as_its_reaction_says() {
    let (friction, inertia, slides_s) = (0.1, 0.1, 1.0);
    let mut robot = mecanum4();
    let center_m = robot.center_of_mass_m();
    let (still_kg_m2, at_m) = (yaw_inertia(&robot, center_m), robot.wheels[0].position_m());
    let law = (JointKind::Turns, JointRole::Driven(servo(1e4, 100.0)));
    let mut rotor = joint("rotor", law, (center_m, Vector3::z()), (ARM_KG, center_m));
    rotor.body.mass.inertia_kg_m2 = nalgebra::Matrix3::identity() * inertia;
    robot.joints.push(rotor);
    let floor = Floor {
        friction,
        ..Floor::default()
    };
    let dt_s = 5e-4;
    let mut world = world(&robot, &floor, G, dt_s);
    let bears_n_m = friction * robot.mass_kg() * G * (at_m.x.abs() + at_m.y.abs()) / 2_f64.sqrt();
    // Its angle grows with the cube of time, and its reaction with time.
    let jerk = bears_n_m / (inertia * slides_s);
    let mut begins = None;
    let held: Vec<MotorTorque> = vec![MotorTorque::with_droop(0.0, 1e6); 4];
    while world.time_s() < 1.5 * slides_s {
        let t_s = world.time_s() + 0.5 * dt_s;
        let aim = [jerk * t_s.powi(3) / 6.0, jerk * t_s * t_s / 2.0];
        world
            .robot_mut()
            .aim_joint(0, aim[0], aim[1])
            .expect("driven");
        world.robot_mut().drive(&held);
        world.step();
        let contacts = world.robot().contacts().iter();
        let slides_m_s = contacts.map(|contact| contact.sliding_in_body_m_s.norm());
        if slides_m_s.fold(0.0, f64::max) > 3e-6 {
            begins.get_or_insert(at(&world));
        }
    }
    let by_hand = jerk * slides_s.powi(3) / 6.0;
    let begins = begins.expect("it slides");
    println!("{begins} {by_hand}");
    assert_near(begins, by_hand, 0.01, "angle at which it slides");
    let turned_rad = -jerk * inertia * 0.5_f64.powi(3) / (6.0 * (still_kg_m2 + inertia));
    let heading_rad = world.robot().state().pose.heading_rad;
    println!("{heading_rad} {turned_rad}");
    assert_near(heading_rad, turned_rad, 0.01, "base");
}

/// An effort that a step reaches limits the force within it: the damper of a drawer whose base is
/// pushed acts with its effort, and the drawer moves by that alone.
#[test]
fn an_effort_that_a_step_reaches_holds() {
    let (effort_n, dt_s) = (0.5, 2e-3);
    for way in [1.0, -1.0] {
        let robot = drawer(JointServo {
            effort: effort_n,
            ..servo(1.0, 200.0)
        });
        let mut world = world(&robot, &ice(), 0.0, dt_s);
        world.robot_mut().push(&Push {
            force_in_world_n: Vector3::x() * (way * 100.0),
            place_in_body_m: robot.center_of_mass_m(),
        });
        world.step();
        let base_m_s = world.robot().state().twist_in_body.vx_m_s;
        let drawer_m_s = base_m_s + world.robot().joint_rates()[0];
        let base_kg = mecanum4().mass_kg();
        println!("{base_m_s} {drawer_m_s}");
        // The solver ends within 1e-8 m/s of some mm/s.
        assert_near(drawer_m_s, way * effort_n * dt_s / ARM_KG, 1e-4, "drawer");
        let pushed_m_s = way * (100.0 - effort_n) * dt_s / base_kg;
        assert_near(base_m_s, pushed_m_s, 1e-4, "base");
    }
}

/// The largest stiffness for a step is the one that the refusal names: I (2 pi / dt)^2, with the
/// joint's inertia.
#[test]
fn the_stiffness_that_is_named_is_the_one_that_is_taken() {
    let settings = Settings {
        dt_s: 2e-3,
        ..Settings::default()
    };
    let built = |stiffness: f64| {
        let robot = arm(Vector3::y(), servo(stiffness, 1.0));
        World::new(&robot, &Floor::default(), Pose::default(), &settings)
    };
    let text = built(1e9).err().expect("too stiff").to_string();
    let (_, named) = text.split_once("give it less than ").expect(&text);
    let named: f64 = named
        .split(',')
        .next()
        .expect(&text)
        .trim()
        .parse()
        .expect(&text);
    // It is given with three decimals.
    built(named * 0.999).expect("as stiff as it may be");
    built(named * 1.001).err().expect("stiffer than that");
}

/// Position and rate of a target that moves from rest to rest with the least jerk, by a distance in
/// a time, from 0.2 s on.
fn least_jerk(t_s: f64, way: f64, takes_s: f64) -> [f64; 2] {
    let share = ((t_s - 0.2) / takes_s).clamp(0.0, 1.0);
    let rate = 30.0 * (share * (1.0 - share)).powi(2);
    let at = share.powi(3) * (10.0 - share * (15.0 - 6.0 * share));
    [way * at, way * rate / takes_s]
}

/// Energy that held wheels lose to sliding on a friction of 0.15 under a body that a servo moves by
/// a distance in a time, in J; and the final position and heading of the robot.
fn slid(
    robot: &Robot,
    (way, takes_s): (f64, f64),
    dt_s: f64,
    split_dt_s: Option<f64>,
) -> (f64, [f64; 3]) {
    let floor = Floor {
        friction: 0.15,
        ..Floor::default()
    };
    let settings = Settings {
        dt_s,
        split_dt_s,
        ..Settings::default()
    };
    let mut world = World::new(robot, &floor, Pose::default(), &settings).expect("it stands");
    for index in 0..(1.2 / dt_s).round() as usize {
        let at = |steps: f64| least_jerk((index as f64 + steps) * dt_s, way, takes_s);
        let [from, [middle, rate], to] = [0.0, 0.5, 1.0].map(at);
        let aim = [middle, rate, (to[1] - from[1]) / dt_s];
        world.robot_mut().aim_joint_along(0, aim).expect("driven");
        step(&mut world);
    }
    let pose = world.robot().state().pose;
    let ends = [pose.x_m, pose.y_m, pose.heading_rad];
    (world.slip_energy_j(), ends)
}

/// A servo moves its joint in split steps as in whole ones: its aim advances from part to part.
#[test]
fn a_servo_moves_in_split_steps_as_in_whole_ones() {
    let inertia = ARM_KG * ARM_M * ARM_M;
    let arm_of = |rate_limit: f64| {
        let servo = JointServo {
            rate_limit,
            ..JointServo::for_inertia(inertia)
        };
        arm(Vector3::z(), servo)
    };
    let pulls = drawer(JointServo::for_inertia(ARM_KG));
    // A target that is late by 0.1 rad catches up as the aim slows down, and brakes at its effort
    // from that moment within a step on.
    let weak = JointServo {
        rate_limit: 2.7,
        effort: 10.0,
        ..JointServo::for_inertia(inertia)
    };
    // The least jerk asks the arm for 15/8 x 1.2 rad / 0.7 s = 3.2 rad/s at most.
    for (what, robot, way) in [
        ("arm", arm_of(f64::INFINITY), (1.2, 0.7)),
        ("arm at its rate limit", arm_of(2.9), (1.2, 0.7)),
        (
            "arm that brakes at its effort",
            arm(Vector3::z(), weak),
            (1.2, 0.7),
        ),
        ("drawer", pulls, (0.25, 0.4)),
    ] {
        let (slip_j, ends) = slid(&robot, way, 2.5e-4, None);
        for dt_s in [1.0 / 300.0, 1e-3] {
            for split_dt_s in [None, Some(1e-4)] {
                let (of_step_j, at) = slid(&robot, way, dt_s, split_dt_s);
                let [x_m, y_m, heading_rad] = [0, 1, 2].map(|k| at[k] - ends[k]);
                // Of the chassis's middle, and of its wheels, which are 0.22 m from it.
                let off = x_m.hypot(y_m).max(0.22 * heading_rad.abs());
                println!("{what} {dt_s} {split_dt_s:?}: {of_step_j} {slip_j} J, {off} m");
                assert!(slip_j > 1e-4, "{what}: {slip_j} J");
                // The second-order error of steps of 3.3 ms, with 200 of them for the motion and 5
                // for the servo's time constant: a thousandth.
                assert_near(of_step_j, slip_j, 0.01, what);
                assert!(off < 1e-4, "{what}: {off}");
            }
        }
    }
}

/// A target delayed by its rate limit catches up within a step, and continues with the aim's rate
/// from there: a joint that follows without delay is at the target, in steps of any length.
#[test]
fn a_target_catches_up_within_a_step() {
    let limit = 0.2;
    let quick = JointServo {
        rate_limit: limit,
        ..servo(1e5, 1e3)
    };
    // It is late by 0.1 m and catches up after 0.1 / (0.2 + 0.1) s, because the aim moves towards
    // it.
    let caught_s = 0.1 / 0.3;
    for dt_s in [7e-3, 3e-3, 1e-3] {
        let mut world = world(&drawer(quick), &ice(), 0.0, dt_s);
        while world.time_s() < 0.6 {
            let middle_s = world.time_s() + 0.5 * dt_s;
            let aim = 0.1 - 0.1 * middle_s;
            world.robot_mut().aim_joint(0, aim, -0.1).expect("driven");
            world.step();
            let t_s = world.time_s();
            let target = if t_s < caught_s {
                limit * t_s
            } else {
                0.1 - 0.1 * t_s
            };
            let is_at = world.robot().joint_targets().next().expect("a joint");
            // A tenth of a per cent of a step is not taken separately, at both rates.
            assert!(
                (is_at - target).abs() < 1e-3 * 0.3 * dt_s + 1e-12,
                "{dt_s} {t_s}: {is_at} {target}"
            );
        }
    }
}

/// An arm is thrown on its stop on ice: the stop's impulse is internal, and the robot has no
/// momentum before and after. The stop acts in the pose of the step's middle, and the forces of
/// rotating frames use the rates before and after it: the error is of second order.
#[test]
fn a_stop_gives_no_momentum() {
    let left_n_s = |dt_s: f64, effort_n_m: f64| {
        let base = mecanum4();
        let mut robot = arm(Vector3::z(), servo(1.0, 1.0));
        robot.joints[0].limits = [-2.0, 1.0];
        let mut world = world(&robot, &ice(), 0.0, dt_s);
        world.robot_mut().load_joint(0, effort_n_m).expect("driven");
        let mut fastest_rad_s: f64 = 0.0;
        for _ in 0..(1.0 / dt_s).round() as usize {
            world.step();
            fastest_rad_s = fastest_rad_s.max(world.robot().joint_rates()[0]);
        }
        assert!(fastest_rad_s > 3.0 && (at(&world) - 1.0).abs() < 1e-5);
        // The arm turns above the base's centre of mass.
        let state = world.robot().state();
        let turns = state.angular_in_body_rad_s;
        let base_m_s = state.velocity_in_body_m_s + turns.cross(&base.center_of_mass_m());
        let (sin, cos) = at(&world).sin_cos();
        let arm_m_s = (turns + Vector3::z() * world.robot().joint_rates()[0])
            .cross(&(Vector3::new(cos, sin, 0.0) * ARM_M));
        let momentum = base_m_s * (base.mass_kg() + ARM_KG) + arm_m_s * ARM_KG;
        println!("{dt_s}: {} N s, {fastest_rad_s} rad/s", momentum.norm());
        momentum.norm()
    };
    // Thrown by eight torques, the arm reaches its stop at eight times within a step. Each step is
    // split there, so that the stop acts in one part: in all cases the error falls with the square
    // of the step. A stop that acted in two steps would leave up to m r w^2 dt / 2, some 10 mN s at
    // 2 ms.
    let worst_n_s = |dt_s: f64| {
        let efforts_n_m = (0..8).map(|throw| 2.6 + 0.1 * f64::from(throw));
        efforts_n_m
            .map(|effort| left_n_s(dt_s, effort))
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (worst_n_s(2e-3), worst_n_s(5e-4));
    assert!(coarse < 1e-4 && fine < coarse / 8.0, "{fine} {coarse}");
}
