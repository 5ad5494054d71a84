//! Free bodies by identity: adding, removing, sleeping, copying, finding, refusing.

use ilon_robot::{FreeShape, Pose};
use ilon_world::rapier3d::prelude::{QueryFilter, Ray, Vector};
use ilon_world::{
    ContactSolver, Floor, FreeBody, FreeBodyId, GroundBox, Patch, Push, Relief, Settings, World,
    WorldError, WorldObject,
};
use nalgebra::{Vector2, Vector3};

use crate::free::{cube, hold, robot, settings, world};

/// All readable values of a world's free bodies and its robot, as bits.
fn bits(world: &World) -> Vec<u64> {
    let mut all = Vec::new();
    let mut add = |number: f64| all.push(number.to_bits());
    for id in world.free_bodies() {
        let state = world.free_body(*id).expect("it is there");
        state.place_m.iter().for_each(|x| add(*x));
        state.rotation.coords.iter().for_each(|x| add(*x));
        state.velocity_m_s.iter().for_each(|x| add(*x));
        add(state.work_of_robots_j);
    }
    let pose = world.robot().state().pose;
    [pose.x_m, pose.y_m, pose.heading_rad]
        .into_iter()
        .for_each(&mut add);
    add(world.slip_energy_j());
    all
}

fn crowded() -> World {
    let mut world = world(&Floor::default(), 1e-3);
    for at in 0..4 {
        let body = cube(
            &format!("box{at}"),
            0.08,
            0.4,
            0.3 + 0.1 * f64::from(at),
            0.05,
        );
        world.add_body(&body).expect("room");
    }
    let ball = FreeShape::Sphere { radius_m: 0.05 };
    let mut ball = FreeBody::new("ball", ball, 0.5, Vector2::new(0.0, 0.5));
    ball.velocity_m_s = Vector3::new(0.3, -0.4, 0.0);
    world.add_body(&ball).expect("room");
    let can = FreeShape::Cylinder {
        radius_m: 0.03,
        length_m: 0.1,
    };
    let can = FreeBody::new("can", can, 0.3, Vector2::new(0.0, 0.0));
    world.add_body(&can).expect("room");
    world
}

/// Runs are identical to the bit, and a copy continues like the original.
#[test]
fn runs_and_copies_are_equal_to_the_bit() {
    let run = |world: &mut World, steps: usize| {
        for _ in 0..steps {
            hold(world, 5.0);
            world.step();
        }
    };
    let mut first = crowded();
    run(&mut first, 300);
    let mut copy = first.clone();
    run(&mut first, 500);
    run(&mut copy, 500);
    assert_eq!(bits(&first), bits(&copy));
    let mut again = crowded();
    run(&mut again, 800);
    assert_eq!(bits(&first), bits(&again));
}

/// A robot far away from all bodies moves to the bit as if alone.
#[test]
fn bodies_far_away_change_nothing() {
    let (mut alone, mut beside) = (
        world(&Floor::default(), 1e-3),
        world(&Floor::default(), 1e-3),
    );
    beside
        .add_body(&cube("box", 0.1, 1.0, 0.0, 5.0))
        .expect("room");
    for _ in 0..400 {
        for world in [&mut alone, &mut beside] {
            hold(world, 5.0);
            world.step();
        }
        let [a, b] = [&alone, &beside].map(|world| world.robot().state());
        assert_eq!(a, b);
    }
    assert_eq!(alone.slip_energy_j(), beside.slip_energy_j());
}

/// A body put down at rest that stays sleeps at once; one that would slide or fall does not; an
/// approaching body wakes it.
#[test]
fn what_rests_sleeps_until_something_comes_near() {
    let mut world = world(&Floor::default(), 1e-3);
    let box_ = world
        .add_body(&cube("box", 0.1, 1.0, 0.5, 0.0))
        .expect("room");
    let mut falls = cube("falls", 0.1, 1.0, 0.0, 2.0);
    falls.height_m = Some(0.2);
    let falls = world.add_body(&falls).expect("room");
    hold(&mut world, 6.0);
    world.step();
    let sleeps = |world: &World, id| world.free_body(id).expect("it is there").sleeps;
    assert!(sleeps(&world, box_) && !sleeps(&world, falls));
    let from = world.free_body(box_).unwrap().place_m;
    for _ in 0..1500 {
        hold(&mut world, 6.0);
        world.step();
    }
    assert!(sleeps(&world, falls), "it has come to rest");
    let height_m = world.free_body(falls).unwrap().place_m.z;
    assert!((height_m - 0.05).abs() < 1e-5, "{height_m}");
    assert!(!sleeps(&world, box_));
    assert!(world.free_body(box_).unwrap().place_m.x > from.x + 0.1);
}

/// A body put down at rest settles into its contacts before it sleeps, all within the first step:
/// the height that a tower loses counts as impact loss, for each of its cubes, and nothing else
/// changes. The sums are of some ten joules, each rounded to 2e-16 of them, in a few hundred
/// additions.
#[test]
fn what_settles_as_it_is_put_down_is_counted() {
    let mut alone = world(&Floor::default(), 1e-3);
    let mut beside = alone.clone();
    for storey in 0..3 {
        let mut body = cube(&format!("cube{storey}"), 0.1, 1.0, 0.0, 2.0);
        body.height_m = Some(0.05 + 0.1 * f64::from(storey));
        beside.add_body(&body).expect("room");
    }
    let gains_j = |world: &mut World| {
        let all_j = |world: &World| {
            let energy = world.energy();
            [
                energy.kinetic_j + energy.potential_j,
                world.impact_energy_j(),
            ]
        };
        let before = all_j(world);
        world.step();
        let after = all_j(world);
        [0, 1].map(|k| after[k] - before[k])
    };
    let (of_robot, of_all) = (gains_j(&mut alone), gains_j(&mut beside));
    let sleep = |id: &FreeBodyId| beside.free_body(*id).is_some_and(|body| body.sleeps);
    assert!(beside.free_bodies().iter().all(sleep));
    let [stored_j, hits_j] = [0, 1].map(|k| of_all[k] - of_robot[k]);
    println!("{stored_j:e} J stored, {hits_j:e} J in hits");
    let rounding_j = 300.0 * f64::EPSILON * 10.0;
    assert!(stored_j < -100.0 * rounding_j, "it settles: {stored_j:e} J");
    assert!((stored_j + hits_j).abs() < rounding_j);
}

/// A body falls asleep after being slow for half a second: a cube that drops by 5 mm lands after 32
/// ms, and settles in some milliseconds.
#[test]
fn what_has_come_down_sleeps_half_a_second_later() {
    let mut world = world(&Floor::default(), 1e-3);
    let mut drops = cube("drops", 0.1, 1.0, 0.0, 2.0);
    drops.height_m = Some(0.055);
    let drops = world.add_body(&drops).expect("room");
    while !world.free_body(drops).expect("it is there").sleeps {
        world.step();
        assert!(world.time_s() < 1.0, "it is awake");
    }
    let (lands_s, sleeps_s) = ((2.0 * 5e-3 / 9.81_f64).sqrt(), world.time_s());
    assert!((0.5..0.55).contains(&(sleeps_s - lands_s)), "{sleeps_s}");
}

/// Bodies that separate rest separately: a box that a ball rolls away from sleeps after being slow
/// for half a second, and not only when the ball does.
#[test]
fn what_is_left_alone_sleeps_while_the_other_rolls_on() {
    let mut world = world(&Floor::default(), 1e-3);
    let box_ = world
        .add_body(&cube("box", 0.1, 1.0, 0.0, 2.0))
        .expect("room");
    let ball = FreeShape::Sphere { radius_m: 0.05 };
    let mut ball = FreeBody::new("ball", ball, 0.5, Vector2::new(0.1001, 2.0));
    ball.velocity_m_s = Vector3::new(0.2, 0.0, 0.0);
    ball.angular_rad_s = Vector3::new(0.0, 4.0, 0.0);
    let ball = world.add_body(&ball).expect("room");
    let sleeps = |world: &World, id| world.free_body(id).expect("it is there").sleeps;
    while !sleeps(&world, box_) {
        world.step();
        assert!(world.time_s() < 2.0, "it is awake");
    }
    // Beside the ball it cannot sleep yet.
    let at_s = world.time_s();
    assert!((0.5..0.55).contains(&at_s), "{at_s} s");
    assert!(!sleeps(&world, ball));
}

/// A tower falls when its support is removed, and all sleeping bodies wake when the floor turns to
/// ice.
#[test]
fn taking_away_and_ice_wake_what_sleeps() {
    let slope_rad = 0.1;
    let floor = Floor {
        slope_rad,
        ..Floor::default()
    };
    let mut world = world(&floor, 1e-3);
    let [low, top] = ["low", "top"].map(|name| {
        let body = cube(name, 0.1, 1.0, 0.0, 1.0);
        world.add_body(&body).expect("one on the other")
    });
    world.step();
    assert!(world.free_body(top).unwrap().sleeps);
    let before_j = world.energy().potential_j - world.outside_energy_j();
    assert!(world.remove_body(low) && !world.remove_body(low));
    let now_j = world.energy().potential_j - world.outside_energy_j();
    assert!((now_j - before_j).abs() < 1e-4, "{now_j} {before_j}");
    (0..700).for_each(|_| world.step());
    let state = world.free_body(top).unwrap();
    assert!((state.place_m.z - 0.05).abs() < 1e-4, "{state:?}");
    assert!(state.sleeps && world.free_body(low).is_none());
    let ice = Patch {
        center_m: Vector2::new(0.0, 1.0),
        half_sides_m: Vector2::new(2.0, 0.5),
        friction: 0.02,
        surface: Default::default(),
        footings: Vec::new(),
    };
    world.set_friction(None, &[ice]);
    (0..500).for_each(|_| world.step());
    let slid_m = world.free_body(top).unwrap().place_m.x - state.place_m.x;
    // g (sin - 0.02 cos) t^2 / 2.
    let expected_m = 0.5 * 9.81 * (slope_rad.sin() - 0.02 * slope_rad.cos()) * 0.25;
    assert!(
        (slid_m / expected_m - 1.0).abs() < 1e-3,
        "{slid_m} {expected_m}"
    );
}

/// Pushed at its centre without friction, a body gains F t / m.
#[test]
fn a_push_acts_for_one_step() {
    let mut world = world(&Floor::default(), 1e-3);
    let mut body = cube("box", 0.1, 2.0, 0.0, 1.0);
    body.friction = 0.0;
    let id = world.add_body(&body).expect("room");
    (0..100).for_each(|_| world.step());
    for _ in 0..50 {
        world.push_body(id, Vector3::new(4.0, 0.0, 0.0), Vector3::zeros());
        world.step();
    }
    (0..50).for_each(|_| world.step());
    let state = world.free_body(id).unwrap();
    assert!((state.velocity_m_s.x - 0.1).abs() < 1e-9, "{state:?}");
    assert!((world.outside_energy_j() - 0.5 * 2.0 * 0.01).abs() < 1e-9);
}

/// A ray hits the expected object at the expected point.
#[test]
fn rays_see_robots_bodies_and_ground() {
    let mut floor = Floor::default();
    floor.boxes.push(GroundBox {
        center_m: Vector3::new(3.0, 0.0, 0.0),
        half_sides_m: Vector3::new(0.1, 1.0, 0.3),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    });
    let mut world = world(&floor, 1e-3);
    let id = world
        .add_body(&cube("box", 0.2, 1.0, 1.0, 0.0))
        .expect("room");
    let from = Vector3::new(0.5, 0.0, 0.06);
    let look = |world: &World, x: f64, z: f64| world.cast_ray(from, Vector3::new(x, 0.0, z), 10.0);
    let ahead = look(&world, 2.0, 0.0).expect("the box");
    assert_eq!(ahead.object, WorldObject::Free(id));
    assert!((ahead.distance_m - 0.4).abs() < 1e-6 && (ahead.normal.x + 1.0).abs() < 1e-6);
    let back = look(&world, -1.0, 0.0).expect("the robot");
    assert_eq!(
        back.object,
        WorldObject::Robot(world.bodies().next().unwrap())
    );
    assert!((back.distance_m - 0.3).abs() < 1e-6);
    // From inside, in any direction.
    for direction in [Vector3::x(), -Vector3::z()] {
        let within = world.cast_ray(Vector3::new(1.05, 0.0, 0.06), direction, 10.0);
        let within = within.expect("the box");
        assert_eq!(within.object, WorldObject::Free(id));
        assert_eq!(within.distance_m, 0.0);
    }
    let down = look(&world, 0.0, -1.0).expect("the plane");
    assert_eq!(down.object, WorldObject::Ground);
    assert!((down.distance_m - 0.06).abs() < 1e-7);
    assert!(world.remove_body(id));
    let wall = look(&world, 1.0, 0.0).expect("the wall");
    assert_eq!(wall.object, WorldObject::Ground);
    assert!((wall.distance_m - 2.4).abs() < 1e-6);
    assert!(world.cast_ray(from, Vector3::z(), 10.0).is_none());
    assert!(world.cast_ray(from, Vector3::x(), 2.3).is_none());
    assert!(world.rapier().is_none());
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    // A chassis and four wheels, the plane and the wall.
    assert_eq!((rapier.bodies.len(), rapier.colliders.len()), (0, 7));
    let of = |world: &World, x: f64| {
        let rapier = world.rapier().expect("it was asked for");
        let ray = Ray::new(Vector::new(0.5, 0.0, 0.06), Vector::new(x, 0.0, 0.0));
        let (hit, far_m) = rapier.cast_ray(&ray, 10.0, true, QueryFilter::default())?;
        Some((world.object_in_rapier(hit)?, far_m))
    };
    let (object, far_m) = of(&world, -1.0).expect("the robot");
    assert!(matches!(object, WorldObject::Robot(_)) && (far_m - 0.3).abs() < 1e-6);
    let (object, far_m) = of(&world, 1.0).expect("the wall");
    assert!(object == WorldObject::Ground && (far_m - 2.4).abs() < 1e-6);
}

/// An invalid body, or one that cannot start at its place, is refused with a remedy.
#[test]
fn what_makes_no_sense_is_refused_in_words() {
    let mut world = world(&Floor::default(), 1e-3);
    world
        .add_body(&cube("first", 0.1, 1.0, 1.0, 0.0))
        .expect("room");
    let mut refused = |change: &dyn Fn(&mut FreeBody)| {
        let mut body = cube("bad", 0.1, 1.0, 0.0, 2.0);
        change(&mut body);
        let count = world.free_bodies().len();
        let error = world.add_body(&body).expect_err("it makes no sense");
        assert_eq!(world.free_bodies().len(), count);
        let text = error.to_string();
        assert!(text.starts_with("body `bad`: "), "{text}");
        text
    };
    let says = |text: String, words: &str| assert!(text.contains(words), "{text}");
    says(refused(&|body| body.mass_kg = 0.0), "mass_kg is 0");
    says(refused(&|body| body.mass_kg = f64::NAN), "mass_kg");
    says(refused(&|body| body.friction = -0.1), "friction");
    says(
        refused(&|body| body.velocity_m_s.x = f64::INFINITY),
        "finite",
    );
    says(
        refused(&|body| body.shape = FreeShape::Sphere { radius_m: -1.0 }),
        "radius_m is -1",
    );
    says(
        refused(&|body| {
            body.shape = FreeShape::Box {
                size_m: [0.2, 0.2, 1.9e-4],
            };
        }),
        "more than 1000 times another",
    );
    says(
        refused(&|body| body.height_m = Some(0.04)),
        "10.0 mm deep in the ground",
    );
    says(
        refused(&|body| {
            body.place_m = Vector2::new(0.2, 0.0);
            body.height_m = Some(0.06);
        }),
        "deep in the robot; move it",
    );
    says(
        refused(&|body| {
            body.place_m = Vector2::new(1.05, 0.0);
            body.height_m = Some(0.06);
        }),
        "deep in body `first`",
    );
    // Beside a wheel, outside the chassis.
    says(
        refused(&|body| {
            body.place_m = Vector2::new(0.15, 0.16);
            body.height_m = Some(0.06);
        }),
        "deep in the robot",
    );
    // Small sizes are valid.
    let mut bead = cube("bead", 0.1, 1e-6, 0.0, 2.5);
    bead.shape = FreeShape::Sphere { radius_m: 4e-4 };
    world.add_body(&bead).expect("a bead of 0.8 mm");
    let by_rapier = Settings {
        contacts: ContactSolver::Rapier,
        ..settings(1e-3)
    };
    let mut world = World::new(&robot(), &Floor::default(), Pose::default(), &by_rapier).unwrap();
    let error = world.add_body(&cube("box", 0.1, 1.0, 1.0, 0.0));
    assert!(matches!(error, Err(WorldError::NotInRapier { .. })));
}

/// On rough ground a body is put down on the bump beneath it, and rests there; beyond the edge
/// nothing is beneath it, and it falls.
#[test]
fn on_rough_ground_bodies_stand_on_what_is_beneath() {
    let heights_m = (0..41)
        .map(|i| {
            (0..41)
                .map(|j| if (i + j) % 3 == 0 { 4e-3 } else { 0.0 })
                .collect()
        })
        .collect();
    let floor = Floor {
        relief: Some(Relief {
            cell_m: 0.1,
            center_m: Default::default(),
            heights_m,
        }),
        ..Floor::default()
    };
    let mut world = world(&floor, 1e-3);
    let box_ = world
        .add_body(&cube("box", 0.2, 1.0, 0.7, 0.1))
        .expect("room");
    let ball = FreeShape::Sphere { radius_m: 0.05 };
    let ball = FreeBody::new("ball", ball, 0.5, Vector2::new(-0.71, 0.33));
    let ball = world.add_body(&ball).expect("room");
    let beyond = world
        .add_body(&cube("beyond", 0.1, 1.0, 3.0, 0.0))
        .expect("room");
    let height_m = |world: &World, id| world.free_body(id).expect("it is there").place_m.z;
    // Its face is on bumps of equal height.
    assert!(
        (height_m(&world, box_) - 0.104).abs() < 1e-6,
        "{}",
        height_m(&world, box_)
    );
    let of_ball_m = height_m(&world, ball);
    assert!((0.05 - 1e-6..0.0541).contains(&of_ball_m), "{of_ball_m}");
    let from_m = height_m(&world, beyond);
    (0..300).for_each(|_| world.step());
    assert!((height_m(&world, box_) - 0.104).abs() < 1e-5);
    // g t^2 / 2, from its first step on.
    let fell_m = from_m - height_m(&world, beyond);
    assert!(
        (fell_m / (0.5 * 9.81 * 0.09) - 1.0).abs() < 0.01,
        "{fell_m}"
    );
}

/// After a body is removed all other contacts are unchanged: deflected treads keep their
/// deflection, and the robot moves as before.
#[test]
fn what_is_taken_away_leaves_the_treads_of_others_bent() {
    let mut robot = robot();
    for wheel in &mut robot.wheels {
        wheel.surface.tread = Some(ilon_robot::Tread::new(2e5));
    }
    let mut worlds = [(); 2].map(|()| {
        World::new(&robot, &Floor::default(), Pose::default(), &settings(1e-3)).expect("it stands")
    });
    // Just ahead of the chassis without contact, so that it is solved with the robot.
    let boxes = [0, 1].map(|k| {
        worlds[k]
            .add_body(&cube("box", 0.1, 1.0, 0.2505, 0.0))
            .expect("room")
    });
    let push = |world: &mut World| {
        hold(world, 0.0);
        world.robot_mut().push(&Push {
            force_in_world_n: Vector3::y() * 15.0,
            place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
        });
        world.step();
    };
    for _ in 0..300 {
        worlds.iter_mut().for_each(push);
    }
    assert!(!worlds[0].free_body(boxes[0]).expect("it is there").sleeps);
    let before = worlds[0].robot().state().pose;
    assert!(worlds[0].remove_body(boxes[0]));
    for _ in 0..100 {
        worlds.iter_mut().for_each(push);
    }
    let [without, with] = [0, 1].map(|k| worlds[k].robot().state().pose);
    let moved_m = (with.position_m() - before.position_m()).norm();
    let apart_m = (with.position_m() - without.position_m()).norm();
    println!("{moved_m:e} m, {apart_m:e} m apart");
    // Solved to 1e-9 m/s in each of 100 steps; a tread without its deflection would sag by 15 N /
    // 8e5 N/m = 2e-5 m.
    assert!(apart_m < 1e-8, "{apart_m:e} m");
}
