//! Soft rollers, and floors with rolling resistance and creep: against derivations by hand, and
//! against the rigid roller in the limit.

use crate::support;

use ilon_robot::{Pose, Robot, Tread, Twist};
use ilon_world::{Floor, FloorSurface, Push, RollerBodies, Settings, World, WorldError};
use nalgebra::Vector3;
use support::rig::follow;
use support::{mecanum4, volksbot};

const G: f64 = 9.81;

fn settings(dt_s: f64) -> Settings {
    Settings {
        dt_s,
        ..Settings::default()
    }
}

/// The robot on treads of a stiffness in N/m; `longer` is the length of its rollers relative to
/// that without overlap.
fn on_treads(mut robot: Robot, stiffness_n_m: f64, longer: f64) -> Robot {
    for wheel in &mut robot.wheels {
        wheel.surface.tread = Some(Tread::new(stiffness_n_m));
        for roller in &mut wheel.rollers {
            roller.length_m *= longer;
        }
    }
    robot
}

fn world(robot: &Robot, surface: FloorSurface, dt_s: f64) -> World {
    let floor = Floor {
        surface,
        ..Floor::default()
    };
    World::new(robot, &floor, Pose::default(), &settings(dt_s)).expect("valid")
}

/// Means of forward velocity and of the wheels' rates over a second.
fn means(world: &mut World, robot: &Robot, twist: Twist, pull_n: f64) -> (f64, Vec<f64>) {
    let (x_m, angles) = (
        world.robot().state().pose.x_m,
        world.robot().wheel_angles_rad().to_vec(),
    );
    follow(world, robot, twist, 1.0, pull_n);
    let rates = world.robot().wheel_angles_rad().iter().zip(&angles);
    (
        world.robot().state().pose.x_m - x_m,
        rates.map(|(a, b)| a - b).collect(),
    )
}

fn unexplained_j(world: &World, began_j: f64) -> f64 {
    let energy = world.energy();
    let lost_j = world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.bearing_energy_j()
        + world.impact_energy_j();
    let stored_j = energy.kinetic_j + energy.potential_j - began_j;
    world.motor_energy_j() + world.outside_energy_j() - lost_j - stored_j
}

fn total_j(world: &World) -> f64 {
    world.energy().kinetic_j + world.energy().potential_j
}

#[test]
fn rolling_resistance_takes_its_share_of_the_load_for_each_metre() {
    // Under Swedish wheels without tilt the contact point moves like the robot: in any direction
    // the drag is c m g.
    let (c, v) = (0.03, 0.2);
    let robot = volksbot();
    for (vx, vy) in [(v, 0.0), (0.0, v), (0.6 * v, 0.8 * v)] {
        let twist = Twist::new(vx, vy, 0.0);
        let work_j = |resistance: f64, robot: &Robot| {
            let surface = FloorSurface {
                rolling_resistance: resistance,
                ..FloorSurface::default()
            };
            let mut world = world(robot, surface, 1e-3);
            let rest_j = total_j(&world);
            follow(&mut world, robot, twist, 1.0, 0.0);
            let (began_j, from) = (world.motor_energy_j(), world.robot().state().pose);
            follow(&mut world, robot, twist, 1.0, 0.0);
            let way_m = (world.robot().state().pose.position_m() - from.position_m()).norm();
            let unexplained = unexplained_j(&world, rest_j).abs() / world.motor_energy_j();
            assert!(unexplained < 1e-3, "{unexplained}");
            (world.motor_energy_j() - began_j) / way_m
        };
        let expected_n = c * robot.mass_kg() * G;
        let plain_n = work_j(0.0, &robot);
        let dragged_n = work_j(c, &robot);
        // The spin-up at hand-overs occurs at another rate: a hundredth.
        let drag_n = dragged_n - plain_n;
        assert!(
            (drag_n / expected_n - 1.0).abs() < 0.01,
            "{drag_n} {expected_n}"
        );
        // The same with the rollers' own resistance, and on treads.
        let mut own = on_treads(robot.clone(), 1e7, 1.0);
        let without_n = work_j(0.0, &own);
        for wheel in &mut own.wheels {
            wheel.surface.rolling_resistance = c;
        }
        let drag_n = work_j(0.0, &own) - without_n;
        assert!(
            (drag_n / expected_n - 1.0).abs() < 0.01,
            "{drag_n} {expected_n}"
        );
    }
}

#[test]
fn a_robot_under_a_pull_slips_by_the_pull_over_the_creep_stiffness() {
    // Wheels at 0, 120 and 240 degrees, ahead: two of them pull, each along its rim with f = F / (2
    // cos 30). Each slips by creep v f / N, and the robot falls back by that over cos 30: by v
    // creep F / (1.5 N), N = m g / 3.
    let (v, pull_n) = (0.3, -6.0);
    let robot = volksbot();
    let load_n = robot.mass_kg() * G / 3.0;
    let twist = Twist::new(v, 0.0, 0.0);
    let short = |robot: &Robot, creep: f64| {
        let of = |pull_n: f64| {
            let surface = FloorSurface {
                creep,
                ..FloorSurface::default()
            };
            let mut world = world(robot, surface, 1e-3);
            follow(&mut world, robot, twist, 1.0, pull_n);
            let (way_m, rates) = means(&mut world, robot, twist, pull_n);
            way_m / support::ideal_twist(robot, &rates).vx_m_s
        };
        of(0.0) - of(pull_n)
    };
    let expected = 0.1 * -pull_n / (1.5 * load_n);
    let rigid = short(&robot, 0.1);
    assert!((rigid / expected - 1.0).abs() < 0.02, "{rigid} {expected}");
    let treaded = on_treads(robot.clone(), 1e5, 1.0);
    let of_floor = short(&treaded, 0.1);
    assert!(
        (of_floor / expected - 1.0).abs() < 0.05,
        "{of_floor} {expected}"
    );
    // A tread with a relaxation length of 1 mm: creep stiffness k_t lambda = 2e5 * 1e-3 = 200 N.
    // Each of eight rollers is sheared anew over 1 of 39 mm; it is so stiff along the normal that
    // two hardly share the load.
    let mut renewed = on_treads(robot.clone(), 1e7, 1.0);
    for wheel in &mut renewed.wheels {
        let tread = wheel.surface.tread.as_mut().expect("it has one");
        tread.shear_stiffness_n_m = Some(2e5);
        tread.relaxation_length_m = Some(1e-3);
    }
    let of_tread = short(&renewed, 0.0);
    let expected = -pull_n / (1.5 * 200.0);
    assert!(
        (of_tread / expected - 1.0).abs() < 0.05,
        "{of_tread} {expected}"
    );
}

#[test]
fn friction_falls_with_the_speed_of_sliding_as_stribeck_has_it() {
    // Wheels with held rims, pushed to a speed: at 0.1 m/s exp(-1) of the way from 0.5 down to 0.2
    // remains.
    let surface = FloorSurface {
        sliding: Some(ilon_world::Stribeck {
            friction: 0.2,
            speed_m_s: 0.1,
        }),
        ..FloorSurface::default()
    };
    let floor = Floor {
        friction: 0.5,
        surface,
        ..Floor::default()
    };
    let mut robot = volksbot();
    for wheel in &mut robot.wheels {
        wheel.joint.friction_n_m = 100.0;
    }
    let mut world = World::new(&robot, &floor, Pose::default(), &settings(1e-3)).expect("valid");
    // Turning on the spot every wheel slides along its rim, at 0.25 m: a couple of 0.55 of the
    // weight there exceeds a friction of 0.5.
    let couple_n_m = 0.55 * robot.mass_kg() * G * 0.25;
    let mut checked = false;
    for step in 0..3000 {
        for (y, sign) in [(0.25, -1.0), (-0.25, 1.0)] {
            let force_in_world_n = world_x(&world) * (sign * couple_n_m / 0.5);
            world.robot_mut().push(&Push {
                force_in_world_n,
                place_in_body_m: Vector3::new(0.0, y, 0.0),
            });
        }
        world.step();
        let slides_m_s = world.robot().contacts()[0].sliding_in_body_m_s.norm();
        if step > 10 && slides_m_s > 0.1 {
            let expected = 0.2 + 0.3 * (-1.0f64).exp();
            for contact in world.robot().contacts() {
                // One step of acceleration beyond 0.1 m/s: 2 %.
                assert!(
                    (contact.friction / expected - 1.0).abs() < 0.03,
                    "{}",
                    contact.friction
                );
            }
            checked = true;
            break;
        }
    }
    assert!(checked, "it never slid so fast");
}

fn world_x(world: &World) -> Vector3<f64> {
    let heading_rad = world.robot().state().pose.heading_rad;
    Vector3::new(heading_rad.cos(), heading_rad.sin(), 0.0)
}

#[test]
fn long_rollers_share_the_load_and_the_wheel_carries_all_of_it() {
    let robot = on_treads(mecanum4(), 1e5, 1.3);
    let mut world = world(&robot, FloorSurface::default(), 1e-3);
    let twist = Twist::new(0.0, 0.2, 0.0);
    follow(&mut world, &robot, twist, 1.0, 0.0);
    let (mut shared, mut count) = (0, 0);
    let mut total_n = 0.0;
    for _ in 0..1000 {
        follow(&mut world, &robot, twist, 1e-3, 0.0);
        for contact in world.robot().contacts() {
            assert!(contact.touching && contact.touching_rollers >= 1);
            shared += usize::from(contact.touching_rollers > 1);
            assert_eq!(contact.touching_rollers > 1, contact.load_share < 1.0);
            count += 1;
            total_n += contact.normal_force_n;
        }
    }
    let weight_n = robot.mass_kg() * G;
    // The robot bounces with the hand-overs; over a second its mean load is its weight.
    assert!(
        (total_n / 1000.0 / weight_n - 1.0).abs() < 0.005,
        "{total_n}"
    );
    // About half of the turn: the rollers' ends overlap by 0.3 of the tangent of half a pitch, and
    // sag by 0.28 mm.
    let share = shared as f64 / count as f64;
    assert!((0.25..0.9).contains(&share), "{share}");
}

#[test]
fn the_energies_close_with_what_treads_store_and_lose() {
    for (longer, resistance, twist) in [
        (1.0, 0.0, Twist::new(0.0, 0.3, 0.0)),
        (1.3, 0.02, Twist::new(0.2, 0.2, 0.5)),
        (1.3, 0.0, Twist::new(0.0, 0.0, 2.0)),
    ] {
        let mut robot = on_treads(mecanum4(), 1e5, longer);
        for wheel in &mut robot.wheels {
            wheel.surface.rolling_resistance = resistance;
        }
        let mut world = world(&robot, FloorSurface::default(), 1e-3);
        let began_j = total_j(&world);
        follow(&mut world, &robot, twist, 3.0, 0.0);
        // Then it coasts.
        for _ in 0..1000 {
            world.robot_mut().apply(&[0.0; 4]);
            world.step();
        }
        let unexplained = unexplained_j(&world, began_j).abs() / world.motor_energy_j();
        // f32 rates and second order: as for rigid rollers.
        assert!(unexplained < 2e-3, "{unexplained}");
        assert!(world.slip_energy_j() > 0.0 && world.impact_energy_j() > 0.0);
    }
}

#[test]
fn the_stiffer_the_tread_the_nearer_the_rigid_roller() {
    // A start, a drive to the left and a turn; the end compared with that of rigid rollers.
    let end = |robot: &Robot| {
        let mut world = world(robot, FloorSurface::default(), 5e-4);
        follow(&mut world, robot, Twist::new(0.2, 0.3, 0.5), 2.0, 0.0);
        world.robot().state().pose
    };
    let rigid = end(&mecanum4());
    let apart_m = |stiffness_n_m: f64| {
        let pose = end(&on_treads(mecanum4(), stiffness_n_m, 1.0));
        let turned_m = 0.2 * (pose.heading_rad - rigid.heading_rad);
        (pose.position_m() - rigid.position_m())
            .norm()
            .hypot(turned_m)
    };
    let apart: Vec<f64> = [2e5, 2e6, 2e7, 2e8].into_iter().map(apart_m).collect();
    println!("{apart:?}");
    // The angle over which two rollers share the load is proportional to the root of the sag, so
    // the distance from the limit to 1 / sqrt(k): a factor of 3.2 for each ten, until the rigid
    // roller's own 0.3 um of sag and the step are as large.
    assert!(
        apart[1] < 0.6 * apart[0] && apart[2] < 0.6 * apart[1],
        "{apart:?}"
    );
    assert!(apart[3] < 1e-3, "{apart:?}");
}

#[test]
fn all_rollers_and_those_near_the_ground_do_the_same_to_the_bit() {
    let robot = on_treads(mecanum4(), 1e5, 1.3);
    let end = |roller_bodies| {
        let settings = Settings {
            roller_bodies,
            ..settings(2e-3)
        };
        let mut world =
            World::new(&robot, &Floor::default(), Pose::default(), &settings).expect("valid");
        follow(&mut world, &robot, Twist::new(0.2, 0.3, 0.5), 1.0, 0.0);
        world.robot().state()
    };
    assert_eq!(end(RollerBodies::All), end(RollerBodies::Near));
}

#[test]
fn a_robot_stands_on_its_treads_as_deep_as_its_weight_presses_them() {
    let robot = on_treads(volksbot(), 2e5, 1.0);
    let mut world = world(&robot, FloorSurface::default(), 2e-3);
    for _ in 0..1000 {
        world.robot_mut().apply(&[0.0; 3]);
        world.step();
    }
    // m g / (3 k) below the point of contact; the oscillation of the landing has died out.
    let sag_m = robot.mass_kg() * G / 3.0 / 2e5;
    let height_m = world.robot().hub_height_m(0);
    assert!(
        (0.05 - height_m - sag_m).abs() < 1e-3 * sag_m,
        "{height_m} {sag_m}"
    );
    assert!(world.energy().kinetic_j < 1e-9);
}

/// A softer tread would let the robot sink onto its hubs.
#[test]
fn a_tread_that_the_weight_presses_through_is_refused() {
    let robot = mecanum4();
    let least_n_m = robot.mass_kg() * G / 4.0 / robot.wheels[0].rollers[0].radius_m;
    let build = |stiffness_n_m: f64| {
        let robot = on_treads(robot.clone(), stiffness_n_m, 1.0);
        World::new(&robot, &Floor::default(), Pose::default(), &settings(1e-3)).map(drop)
    };
    assert!(build(1.01 * least_n_m).is_ok());
    for soft_n_m in [0.99 * least_n_m, 1e-3] {
        let refused = build(soft_n_m);
        assert!(
            matches!(&refused, Err(WorldError::Wheel { reason, .. }) if reason.contains("deeper than")),
            "{refused:?}"
        );
    }
}

/// Held wheels on treads are pushed slowly: the shear energy of their treads is stored, and counts
/// neither as slip nor as impact loss.
#[test]
fn what_a_tread_stores_in_shear_is_neither_slip_nor_a_hit() {
    let mut robot = on_treads(mecanum4(), 1e5, 1.0);
    for wheel in &mut robot.wheels {
        wheel.joint.friction_n_m = 5.0;
    }
    let mut world = world(&robot, FloorSurface::default(), 1e-3);
    for _ in 0..500 {
        world.robot_mut().apply(&[0.0; 4]);
        world.step();
    }
    let spent_j = |world: &World| {
        (
            world.slip_energy_j() + world.spin_up_energy_j(),
            world.impact_energy_j(),
            world.outside_energy_j(),
            total_j(world),
        )
    };
    let from = spent_j(&world);
    let most_n = 20.0;
    for step in 0..1000 {
        world.robot_mut().push(&Push {
            force_in_world_n: Vector3::new(most_n * f64::from(step) / 1000.0, 0.0, 0.0),
            place_in_body_m: Vector3::zeros(),
        });
        world.robot_mut().apply(&[0.0; 4]);
        world.step();
    }
    let to = spent_j(&world);
    // Four rollers, each of which the floor holds only along its axis, at 45 degrees: 2 k in total.
    let shear_n_m = Tread::new(1e5).shear_n_m();
    let stored_j = most_n * most_n / (2.0 * 2.0 * shear_n_m);
    let work_j = to.2 - from.2;
    println!("{work_j:e} of work, {stored_j:e} stored; {from:?} {to:?}");
    // It pitches a little on its treads too.
    assert!((work_j / stored_j - 1.0).abs() < 0.2, "{work_j} {stored_j}");
    for (spent, what) in [(to.0 - from.0, "slip"), (to.1 - from.1, "hits")] {
        assert!(spent.abs() < 0.03 * work_j, "{what}: {spent} of {work_j}");
    }
    assert!((to.3 - from.3 - work_j).abs() < 0.05 * work_j);
}

/// On soft contacts a robot sinks by its weight over their stiffness, and half of the weight's work
/// is in their springs.
#[test]
fn contacts_store_half_of_what_the_weight_did() {
    let robot = mecanum4();
    let at = |stiffness_n_m: f64| {
        let settings = Settings {
            contact_stiffness_n_m: Some(stiffness_n_m),
            ..settings(1e-3)
        };
        let mut world =
            World::new(&robot, &Floor::default(), Pose::default(), &settings).expect("valid");
        for _ in 0..500 {
            world.robot_mut().apply(&[0.0; 4]);
            world.step();
        }
        (world.energy().potential_j, world.robot().state().height_m)
    };
    let ((soft_j, soft_m), (stiff_j, stiff_m)) = (at(1e5), at(1e9));
    let weight_n = robot.mass_kg() * G;
    let sag_m = weight_n / (4.0 * 1e5);
    assert!((stiff_m - soft_m - sag_m).abs() < 1e-3 * sag_m);
    // m g d / 2 remains of the m g d by which it sank.
    let expected_j = 0.5 * weight_n * sag_m;
    assert!(
        (stiff_j - soft_j - expected_j).abs() < 2e-3 * expected_j,
        "{soft_j} {stiff_j}"
    );
}

/// A tread that the robot's weight would compress by more than its rollers' radius is refused, with
/// that deflection: F / k.
#[test]
fn a_tread_that_is_too_soft_says_how_deep_it_would_be_pressed() {
    let mut robot = mecanum4();
    let load_n = robot.mass_kg() * 9.81 / 4.0;
    for wheel in &mut robot.wheels {
        wheel.surface.tread = Some(Tread::new(load_n / 0.03));
    }
    let built = World::new(
        &robot,
        &Floor::default(),
        Pose::default(),
        &Settings::default(),
    );
    let text = built.err().expect("30 mm of rollers of 12 mm").to_string();
    assert!(text.contains("30.0 mm") || text.contains("30 mm"), "{text}");
    assert!(text.contains("12.0 mm") || text.contains("12 mm"), "{text}");
}

/// The energy of a compressed tread is stored: of F, applied slowly, half of F^2 / (4 k), in
/// addition to the energy from the weight alone.
#[test]
fn what_is_pressed_into_treads_is_stored() {
    let (stiffness_n_m, force_n) = (2e4, 60.0);
    let mut robot = mecanum4();
    for wheel in &mut robot.wheels {
        wheel.surface.tread = Some(Tread::new(stiffness_n_m));
    }
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    let mut world =
        World::new(&robot, &Floor::default(), Pose::default(), &settings).expect("it stands");
    let press = |world: &mut World, force_n: f64| {
        world.robot_mut().push(&Push {
            force_in_world_n: -Vector3::z() * force_n,
            place_in_body_m: robot.center_of_mass_m(),
        });
        world.step();
    };
    (0..1000).for_each(|_| press(&mut world, 0.0));
    let stored_j = |world: &World| world.energy().kinetic_j + world.energy().potential_j;
    let (before_j, outside_j) = (stored_j(&world), world.outside_energy_j());
    const STEPS: usize = 2000;
    for step in 0..STEPS {
        press(&mut world, force_n * (step + 1) as f64 / STEPS as f64);
    }
    // Applied in 2 s to a robot that oscillates at 13 Hz: its dampers take hardly anything. Rollers
    // are tilted, and their springs with them.
    let expected_j = force_n * force_n / (2.0 * 4.0 * stiffness_n_m);
    let (came_j, more_j) = (
        world.outside_energy_j() - outside_j,
        stored_j(&world) - before_j,
    );
    println!("{came_j} J came, {more_j} J more is stored, {expected_j} J by the force alone");
    let sinks_m = force_n / (4.0 * stiffness_n_m);
    let weight_n = robot.mass_kg() * 9.81;
    assert!((came_j / expected_j - 1.0).abs() < 0.02);
    // The work of gravity goes into the springs too: the weight sinks with them.
    assert!(
        (more_j - came_j).abs() < 0.01 * weight_n * sinks_m,
        "{more_j}"
    );
}
