//! Two robots in one world that touch each other: the laws hold between bodies as on the ground.

use ilon_robot::{Collision, CollisionShape, Pose as PlanarPose, Robot, Scale};
use nalgebra::{Isometry3, Vector3};

use super::{World, angular_momentum, shipped};
use crate::contact::reactions::reaction::Partner;
use crate::robot::articulated::Articulated;
use crate::robot::shared_robot::SharedRobot;
use crate::{Floor, Settings};

const RADIUS_M: f64 = 0.3;

/// The robot's centre of mass in the body frame, in metres, including its wheels.
fn center_of_mass_m(robot: &Robot) -> Vector3<f64> {
    let chassis = &robot.chassis.mass;
    let mut moment = chassis.mass_kg * chassis.center_of_mass_m;
    for wheel in &robot.wheels {
        let place = |in_hub_m: Vector3<f64>| {
            (wheel.body_from_hub * nalgebra::Point3::from(in_hub_m)).coords
        };
        moment += wheel.hub.mass_kg * place(wheel.hub.center_of_mass_m);
        for roller in &wheel.rollers {
            moment += roller.mass_kg * place(roller.center_in_hub_m);
        }
    }
    moment / robot.mass_kg()
}

/// A shipped robot within a ball around its centre of mass, which is its only contact shape.
fn in_a_ball(name: &str) -> Robot {
    let mut robot = shipped(name);
    robot.chassis.collisions = vec![Collision {
        friction: None,
        body_from_shape: Isometry3::from(center_of_mass_m(&robot)),
        shape: CollisionShape::Sphere { radius_m: RADIUS_M },
    }];
    robot
}

/// A weightless world of two robots high above the ground, each with its centre of mass at a place
/// and a velocity, in m and m/s.
fn floating(
    dt_s: f64,
    robots: [&Robot; 2],
    centers_m: [Vector3<f64>; 2],
    moving: [Vector3<f64>; 2],
) -> World {
    let settings = Settings {
        dt_s,
        gravity_m_s2: 0.0,
        ..Settings::default()
    };
    let start = PlanarPose::default();
    let mut world =
        World::new(robots[0], &Floor::default(), start, &settings).expect("a robot above a plane");
    world.bodies = (0..2)
        .map(|i| {
            let at = Isometry3::from(centers_m[i] - center_of_mass_m(robots[i]));
            let mut body = Articulated::build(SharedRobot::from(robots[i]), &at, &settings);
            body.state.velocity_m_s = moving[i];
            body
        })
        .collect();
    world
}

/// Linear momentum of all bodies, in N s.
fn momentum(body: &Articulated) -> Vector3<f64> {
    let state = &body.state;
    let mut sum = body.chassis_mass.mass_kg * state.velocity_m_s;
    for (index, (wheel, hub)) in body.robot.wheels.iter().zip(state.hubs()).enumerate() {
        let moving = |mass_kg: f64, in_hub_m: &Vector3<f64>| {
            mass_kg * state.hub_velocity_m_s(index, &hub.place_m(in_hub_m))
        };
        sum += moving(wheel.hub.mass_kg, &wheel.hub.center_of_mass_m);
        let rollers = wheel.rollers.iter();
        sum += rollers
            .map(|roller| moving(roller.mass_kg, &roller.center_in_hub_m))
            .sum::<Vector3<f64>>();
    }
    sum
}

/// Two balls that just touch, one approaching with w along the line between their centres and s
/// across it. By hand, with both centres of mass on that line and 1/m = 1/m_A + 1/m_B: nothing
/// bounces, and the contact deflects by c = 1 / (k dt (dt + tau)) of its load, so that p_n (1/m +
/// c) = w, whatever friction does, because its impulse turns the balls and does not move them along
/// the line. It slides all the time, so that p_t = mu p_n against s. B gets the opposite of A's
/// impulse.
#[test]
fn two_robots_that_hit_each_other_get_equal_and_opposite_impulses() {
    let (a, b) = (in_a_ball("mecanum4"), in_a_ball("volksbot"));
    let line = Vector3::new(0.8, 0.6, 0.0);
    let across = Vector3::new(-0.6, 0.8, 0.0);
    let (dt_s, closes, slides, friction) = (1e-4, 0.4, 2.0, 0.6);
    let place_m = Vector3::new(900.0, -1200.0, 2.0);
    let velocity_of_a = closes * line + slides * across;
    let mut world = floating(
        dt_s,
        [&a, &b],
        [place_m, place_m + 2.0 * RADIUS_M * line],
        [velocity_of_a, Vector3::zeros()],
    );
    let before = [momentum(&world.bodies[0]), momentum(&world.bodies[1])];
    world.step();
    let after = [momentum(&world.bodies[0]), momentum(&world.bodies[1])];
    let (on_a, on_b) = (after[0] - before[0], after[1] - before[1]);

    // The softer of the two robots' springs counts.
    let [of_a, of_b] = [&a, &b].map(|robot| Scale::of(robot, world.settings.gravity_m_s2));
    let softer = if crate::contact_stiffness_n_m(&of_a) < crate::contact_stiffness_n_m(&of_b) {
        of_a
    } else {
        of_b
    };
    let stiffness_n_m = crate::contact_stiffness_n_m(&softer);
    let gives = 1.0 / (stiffness_n_m * dt_s * (dt_s + crate::contact_relaxation_s(&softer)));
    let pressed = closes / (1.0 / a.mass_kg() + 1.0 / b.mass_kg() + gives);
    let on_paper = -pressed * line - friction * pressed * across;
    // Until the middle of the step the line turns by s dt / (4 R). Positions so far out are
    // accurate to 3e-13 m, and a gap of that size is closed in the step before anything presses.
    let turned = slides * dt_s / (4.0 * RADIUS_M);
    let open_m_s = 3e-13 / dt_s;
    let apart = 2.0 * turned * slides / closes + open_m_s / closes;
    assert!(
        (on_a - on_paper).norm() < apart * pressed,
        "{on_a} {on_paper}"
    );
    assert!((on_a + on_b).norm() < 1e-6 * pressed, "{on_a} {on_b}");

    let [contact] = world.reactions.all() else {
        panic!("{} reactions", world.reactions.all().len());
    };
    assert!(matches!(contact.b, Partner::Of(member) if member.body == 1));
    let [normal, along, across] = contact.frame;
    // In the middle of the step it is on B's ball, where that is nearest to A's.
    let middle_m = place_m + 0.5 * dt_s * velocity_of_a;
    let of_b_m = place_m + 2.0 * RADIUS_M * line;
    let touches_m = of_b_m - RADIUS_M * (of_b_m - middle_m).normalize();
    // A few roundings of places 1500 m out, 2e-13 m each.
    let off_m = (contact.at_m - touches_m).norm();
    assert!(off_m < 2e-12, "{off_m:e}");
    // The impulse equals the changes of both momenta, along the contact's own frame and on A; and
    // its friction is at the limit.
    let impulse = contact.impulse;
    let as_vector = impulse.x * normal + impulse.y * along + impulse.z * across;
    assert!((as_vector - on_a).norm() < 1e-6 * pressed, "{as_vector}");
    let rubbed = impulse.yz().norm();
    assert!((rubbed - friction * impulse.x).abs() < 1e-9 * pressed);
}

/// Two robots that collide with corners and sides, without symmetry, keep their momentum and
/// angular momentum, separate again or rest on each other, and gain no energy.
#[test]
fn robots_that_run_into_each_other_keep_their_momenta() {
    let (a, b) = (shipped("mecanum4"), shipped("volksbot"));
    let place_m = Vector3::new(0.0, 0.0, 2.0);
    let other_m = place_m + Vector3::new(0.9, 0.12, 0.03);
    let moving = [Vector3::new(0.8, 0.1, 0.0), Vector3::new(-0.2, 0.0, 0.0)];
    let mut world = floating(2e-3, [&a, &b], [place_m, other_m], moving);
    let linear = |world: &World| momentum(&world.bodies[0]) + momentum(&world.bodies[1]);
    let energy_j = |world: &World| world.energy().kinetic_j;
    let (from, turning) = (linear(&world), angular_momentum(&world));
    let mut last_j = energy_j(&world);
    let first_j = last_j;
    let mut steps_in_contact = 0;
    for _ in 0..750 {
        world.step();
        let now_j = energy_j(&world);
        let pressing = world.reactions.all().iter();
        steps_in_contact += usize::from(
            pressing
                .filter(|reaction| reaction.b != Partner::Itself)
                .any(|reaction| reaction.impulse.x > 0.0),
        );
        // Between impacts the only error is that of the rotating frames, of second order in the
        // step.
        assert!(now_j < last_j + 1e-6 * first_j, "{now_j} after {last_j}");
        last_j = now_j;
    }
    assert!(steps_in_contact > 0, "they missed each other");
    assert!(last_j < 0.9 * first_j, "{last_j} of {first_j}");
    let lost = (linear(&world) - from).norm() / from.norm();
    // The chassis's velocities are summed, and its share of the total rotates within a step: second
    // order.
    assert!(lost < 1e-6, "{lost:e}");
    let lost = (angular_momentum(&world) - turning).norm() / turning.norm();
    assert!(lost < 1e-3, "{lost:e}");
}
