//! The reference mode, in which rapier solves contacts itself: its accuracy, its errors compared
//! with ilon's own solver, and what it refuses.

use crate::support;

use std::f64::consts::PI;

use ilon_robot::{Pose, Robot};
use ilon_world::{
    ContactSolver, Floor, FloorSurface, MotorTorque, Patch, Payload, Push, Relief, RollerBodies,
    Settings, World,
};
use nalgebra::{Vector2, Vector3};
use support::{DRIVES, Drive, brake, drive, ideal_rates, mecanum4, seize_all, volksbot};

const G: f64 = 9.81;

fn by(contacts: ContactSolver, hz: f64) -> Settings {
    Settings {
        dt_s: 1.0 / hz,
        contacts,
        ..Settings::default()
    }
}

fn world(robot: &Robot, settings: &Settings) -> World {
    World::new(robot, &Floor::default(), Pose::default(), settings).expect("a robot on a plane")
}

fn run(robot: &Robot, command: [f64; 3], contacts: ContactSolver) -> Drive {
    let settings = by(contacts, 1000.0);
    let heading_rad = 20.0_f64.to_radians();
    drive(
        robot,
        command,
        heading_rad,
        &Floor::default(),
        &settings,
        0.1,
        1.0,
    )
}

/// At rest the ground carries the weight in total, and m g / n at each wheel, because both robots
/// are symmetric about their middle. Three wheels share it by statics, to 0.03 %. Four are
/// redundant: rapier's sweeps leave them within 0.2 % of equal.
#[test]
fn the_wheels_carry_the_weight() {
    for (robot, even) in [(volksbot(), 1e-3), (mecanum4(), 5e-3)] {
        let mut world = world(&robot, &by(ContactSolver::Rapier, 1000.0));
        for _ in 0..1000 {
            world.step();
        }
        let loads_n: Vec<f64> = world
            .robot()
            .contacts()
            .iter()
            .map(|c| c.normal_force_n)
            .collect();
        let weight_n = robot.mass_kg() * G;
        let share_n = weight_n / loads_n.len() as f64;
        println!("{}: {loads_n:.3?} of {share_n:.3} N", robot.name);
        // f32 impulses of a step: 1e-4 of them.
        assert!((loads_n.iter().sum::<f64>() / weight_n - 1.0).abs() < 1e-3);
        for load_n in &loads_n {
            assert!(
                (load_n / share_n - 1.0).abs() < even,
                "{load_n} of {share_n}"
            );
        }
    }
}

/// With sticking rollers the robot follows the contact kinematics, with either solver. rapier has
/// an error of up to 0.02 % of the speed at 1000 steps a second, and its rollers slide by up to 0.8
/// mm/s where ilon's do not slide at all.
#[test]
fn drives_follow_the_contact_kinematics_nearly_as_well_as_ilons_own() {
    follow([(mecanum4(), &DRIVES[3..4]), (volksbot(), &DRIVES[1..2])]);
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn all_drives_follow_the_contact_kinematics_nearly_as_well_as_ilons_own() {
    follow([(mecanum4(), &DRIVES[..]), (volksbot(), &DRIVES[1..3])]);
}

/// A drive with its name and twist.
type Named = (&'static str, [f64; 3]);

fn follow(driven: [(Robot, &[Named]); 2]) {
    for (robot, drives) in driven {
        for (name, command) in drives.iter().copied() {
            let [rapier, ilon] =
                [ContactSolver::Rapier, ContactSolver::Ilon].map(|s| run(&robot, command, s));
            let off = |drive: &Drive| {
                let driven = (0..3).filter(|i| command[*i] != 0.0);
                let offs = driven.map(|i| (drive.real[i] / drive.contact[i] - 1.0).abs());
                offs.fold(0.0, f64::max)
            };
            println!(
                "{} {name}: {:.4} % and {:.2} mm/s by rapier, {:.4} % and {:.2} mm/s by ilon",
                robot.name,
                100.0 * off(&rapier),
                1e3 * rapier.slip_rms,
                100.0 * off(&ilon),
                1e3 * ilon.slip_rms,
            );
            assert!(off(&rapier) < 5e-4, "{name}");
            assert!(rapier.slip_rms < 1.5e-3, "{name}: {}", rapier.slip_rms);
            // A contact of 1000 Hz at dt = 1 ms sinks by about g dt^2: micrometres.
            assert!(rapier.ripple_mm < 0.005, "{name}: {}", rapier.ripple_mm);
        }
    }
}

/// Sideways a mecanum robot with n rollers per wheel moves at sin(pi/n) / (pi/n) of eq. (7), with
/// both solvers.
#[test]
fn sideways_the_tilt_of_the_rollers_shows_in_both_solvers() {
    let expected = (PI / 9.0).sin() / (PI / 9.0);
    for contacts in [ContactSolver::Rapier, ContactSolver::Ilon] {
        let drive = run(&mecanum4(), [0.0, 0.3, 0.0], contacts);
        let ratio = drive.real[1] / drive.ideal[1];
        assert!(
            (ratio / expected - 1.0).abs() < 1e-3,
            "{contacts:?}: {ratio}"
        );
    }
}

/// A robot that drives sideways, with its rollers' bearings damped.
fn sideways(world: &mut World, robot: &Robot, steps: usize) {
    let targets = ideal_rates(robot, ilon_robot::Twist::new(0.0, 0.3, 0.0));
    for _ in 0..steps {
        let rates = world.robot().wheel_rates_rad_s().iter();
        let motors: Vec<MotorTorque> = (targets.iter().zip(rates))
            .map(|(target, rate)| MotorTorque::with_droop(0.1 * (target - rate), 0.1))
            .collect();
        world.robot_mut().drive(&motors);
        world.step();
    }
}

/// The motors' work is kinetic energy, heat of sliding, bearing loss and impact loss: the balance
/// closes, also with wheel bearings with damping and friction.
#[test]
fn the_energy_balance_closes() {
    let mut rubs = mecanum4();
    for wheel in &mut rubs.wheels {
        (wheel.joint.damping_n_m_s, wheel.joint.friction_n_m) = (4e-3, 0.05);
    }
    [mecanum4(), rubs].into_iter().for_each(closes);
}

fn closes(robot: Robot) {
    let mut world = world(&robot, &by(ContactSolver::Rapier, 1000.0));
    let stored_j = |world: &World| world.energy().kinetic_j + world.energy().potential_j;
    let from_j = stored_j(&world);
    sideways(&mut world, &robot, 2000);
    let went_j = stored_j(&world) - from_j
        + world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.impact_energy_j()
        + world.bearing_energy_j();
    let came_j = world.motor_energy_j();
    println!(
        "{came_j} J came, {went_j} J went; residual {}",
        world.contact_residual_m_s()
    );
    assert!(came_j > 0.3);
    // rapier advances with the rates after the step: its rotation in a step of 1 ms has a
    // first-order error.
    assert!(
        (went_j / came_j - 1.0).abs() < 0.03,
        "{went_j} of {came_j} J"
    );
}

/// The residual is the velocity that violates the law: for a robot settling on its wheels in
/// rapier, which is soft, the fastest contact still moves into or out of the ground at least as
/// fast as the robot's middle, which is the mean of the four.
#[test]
fn the_residual_is_no_less_than_what_a_robot_that_settles_still_moves_by() {
    let mut world = world(&mecanum4(), &by(ContactSolver::Rapier, 1000.0));
    let mut fastest_m_s = 0.0_f64;
    for _ in 0..40 {
        world.step();
        let moves_m_s = world.robot().state().velocity_in_body_m_s.z.abs();
        let residual_m_s = world.contact_residual_m_s();
        // In f32, a step of gravity is 1e-2 m/s.
        assert!(
            residual_m_s > moves_m_s - 1e-7,
            "{residual_m_s} {moves_m_s}"
        );
        fastest_m_s = fastest_m_s.max(moves_m_s);
    }
    assert!(fastest_m_s > 1e-4, "{fastest_m_s}");
}

/// The friction depends on the place: on a patch, friction ends at its own limit.
#[test]
fn rapier_sees_how_slippery_each_place_is() {
    let patch = Patch {
        center_m: Vector2::new(0.15, 0.16),
        half_sides_m: Vector2::new(0.05, 0.05),
        friction: 0.02,
        surface: FloorSurface::default(),
        footings: Vec::new(),
    };
    let floor = Floor {
        patches: vec![patch],
        ..Floor::default()
    };
    let settings = by(ContactSolver::Rapier, 1000.0);
    let robot = mecanum4();
    let mut world = World::new(&robot, &floor, Pose::default(), &settings).expect("on a plane");
    let (mut pulled, mut touched) = ([0.0_f64; 2], [0; 4]);
    for _ in 0..100 {
        world.robot_mut().apply(&[0.2; 4]);
        world.step();
        for (index, contact) in world.robot().contacts().iter().enumerate() {
            if !contact.touching {
                continue;
            }
            touched[index] += 1;
            // f32 represents these numbers to 1e-7 of them.
            let on_patch = index == 0;
            let expected = if on_patch { 0.02 } else { 0.6 };
            assert!((contact.friction - expected).abs() < 1e-7, "wheel {index}");
            let pull = contact.force_in_body_n.norm() / contact.normal_force_n;
            let most = &mut pulled[usize::from(!on_patch)];
            *most = most.max(pull);
        }
    }
    println!("touched in {touched:?} of 100 steps, pulled with {pulled:?} of the load");
    assert!((pulled[0] / 0.02 - 1.0).abs() < 1e-6, "{pulled:?}");
    assert!(pulled[1] > 0.1, "{pulled:?}");
}

/// A copy continues identically to the bit, also with rollers as bodies.
#[test]
fn a_copy_goes_on_as_the_original_does() {
    let robot = mecanum4();
    let mut original = world(&robot, &by(ContactSolver::Rapier, 1000.0));
    sideways(&mut original, &robot, 200);
    let mut copy = original.clone();
    sideways(&mut original, &robot, 200);
    sideways(&mut copy, &robot, 200);
    assert_eq!(original.robot().state(), copy.robot().state());
    assert_eq!(original.robot().contacts(), copy.robot().contacts());
    assert_eq!(
        original.robot().roller_spins_rad_s(2),
        copy.robot().roller_spins_rad_s(2)
    );
}

/// A payload added during motion changes no velocity of chassis, wheels and rollers.
#[test]
fn a_payload_put_on_in_passing_leaves_the_motion_as_it_was() {
    let robot = mecanum4();
    let mut world = world(&robot, &by(ContactSolver::Rapier, 1000.0));
    sideways(&mut world, &robot, 500);
    let (body, spins) = (world.robot().state(), world.robot().roller_spins_rad_s(1));
    let payload = Payload::new(4.0, Vector3::new(0.1, 0.0, 0.12)).expect("a payload");
    world.robot_mut().carry(&[payload]);
    let now = world.robot().state();
    // Sums of a few metres and seconds in f64.
    assert!((now.twist_in_body.vy_m_s - body.twist_in_body.vy_m_s).abs() < 1e-12);
    assert!((now.pose.y_m - body.pose.y_m).abs() < 1e-12);
    for (now, before) in world.robot().roller_spins_rad_s(1).iter().zip(&spins) {
        assert!((now - before).abs() < 1e-9);
    }
    let kilograms = robot.mass_kg() + 4.0;
    sideways(&mut world, &robot, 500);
    let carried_n: f64 = world
        .robot()
        .contacts()
        .iter()
        .map(|c| c.normal_force_n)
        .sum();
    // Sideways the load oscillates with the robot's tilt.
    assert!(
        (carried_n / (kilograms * G) - 1.0).abs() < 0.05,
        "{carried_n} N"
    );
}

/// A seized roller does not turn relative to its hub, while the others of its wheel roll.
#[test]
fn a_seized_roller_stands_still() {
    let robot = mecanum4();
    let mut world = world(&robot, &by(ContactSolver::Rapier, 1000.0));
    world.robot_mut().seize_roller(0, 3, true);
    sideways(&mut world, &robot, 1500);
    let spins = world.robot().roller_spins_rad_s(0);
    assert_eq!(spins[3], 0.0);
    assert!(spins.iter().any(|spin| spin.abs() > 5.0), "{spins:?}");
}

/// Unsupported features of rapier's solver are refused with a message.
#[test]
fn what_rapier_does_not_know_is_refused() {
    let refused = |robot: &Robot, settings: Settings| {
        let built = World::new(robot, &Floor::default(), Pose::default(), &settings);
        match built {
            Ok(_) => panic!("{settings:?} was taken"),
            Err(error) => error.to_string(),
        }
    };
    let reference = by(ContactSolver::Rapier, 1000.0);
    let near = Settings {
        roller_bodies: RollerBodies::Near,
        ..reference.clone()
    };
    assert!(refused(&mecanum4(), near).contains("only the rollers near the ground"));
    let split = Settings {
        split_dt_s: Some(1e-4),
        ..reference.clone()
    };
    assert!(refused(&mecanum4(), split).contains("steps taken in parts"));
    let mut geared = mecanum4();
    geared.wheels[1].drive.gear_efficiency = 0.8;
    assert!(refused(&geared, reference).contains("gear that loses a share"));
}

/// A motor drives up to its rate limit and no further: a wheel in the air keeps the rate of its
/// last driven step.
#[test]
fn no_motor_drives_beyond_its_rate_limit_in_rapier_either() {
    let robot = mecanum4();
    let settings = Settings {
        gravity_m_s2: 0.0,
        ..by(ContactSolver::Rapier, 1000.0)
    };
    let (limit_rad_s, torque_n_m) = (8.0, 0.02);
    for way in [1.0, -1.0] {
        let mut world = world(&robot, &settings);
        let motor = MotorTorque {
            rate_limit_rad_s: limit_rad_s,
            ..MotorTorque::constant(way * torque_n_m)
        };
        let mut last_step_rad_s = 0.0_f64;
        for _ in 0..600 {
            let before_rad_s = world.robot().wheel_rates_rad_s()[0];
            world.robot_mut().drive(&[motor; 4]);
            world.step();
            let gained_rad_s = world.robot().wheel_rates_rad_s()[0] - before_rad_s;
            last_step_rad_s = last_step_rad_s.max(way * gained_rad_s);
        }
        for rate in world.robot().wheel_rates_rad_s() {
            let beyond_rad_s = way * rate - limit_rad_s;
            assert!(
                (-1e-3..=last_step_rad_s).contains(&beyond_rad_s),
                "{beyond_rad_s} rad/s beyond, {last_step_rad_s} a step"
            );
        }
    }
}

/// Uneven ground of zero height is a plane for rapier too: it carries the weight, and sideways the
/// robot moves as on the plane, except for the effect of a height field's faces on rapier's solver.
#[test]
fn level_relief_is_a_plane_in_rapier() {
    let robot = mecanum4();
    let relief = Relief {
        cell_m: 0.1,
        center_m: Vector2::new(0.013, 0.021),
        heights_m: vec![vec![0.0; 41]; 41],
    };
    let went = |relief: Option<Relief>| {
        let floor = Floor {
            relief,
            ..Floor::default()
        };
        let settings = by(ContactSolver::Rapier, 1000.0);
        let mut world = World::new(&robot, &floor, Pose::default(), &settings).expect("valid");
        sideways(&mut world, &robot, 1000);
        let load_n: f64 = world
            .robot()
            .contacts()
            .iter()
            .map(|of| of.normal_force_n)
            .sum();
        (world.robot().state().pose, load_n)
    };
    let ((plane, plane_n), (relief, relief_n)) = (went(None), went(Some(relief)));
    println!("{plane:?} {plane_n} N, {relief:?} {relief_n} N");
    assert!(plane.y_m.abs() > 0.1);
    assert!((relief.position_m() - plane.position_m()).norm() < 0.02 * plane.y_m.abs());
    assert!(
        (relief_n / (robot.mass_kg() * G) - 1.0).abs() < 0.05,
        "{relief_n} N"
    );
}

/// On ice a push gives the robot its momentum in rapier too: v = F t / m, along and across.
#[test]
fn a_push_gives_its_momentum_in_rapier() {
    let robot = mecanum4();
    let settings = by(ContactSolver::Rapier, 1000.0);
    let ice = Floor {
        friction: 0.0,
        ..Floor::default()
    };
    let mut world = World::new(&robot, &ice, Pose::default(), &settings).expect("valid");
    let force_n = Vector3::new(4.0, -3.0, 0.0);
    for _ in 0..200 {
        world.robot_mut().push(&Push {
            force_in_world_n: force_n,
            place_in_body_m: robot.center_of_mass_m(),
        });
        world.step();
    }
    let twist = world.robot().state().twist_in_body;
    let expected_m_s = force_n * 0.2 / robot.mass_kg();
    // Rollers with damped bearings turn with it: some parts in 10^4.
    assert!(
        (twist.vx_m_s / expected_m_s.x - 1.0).abs() < 1e-3,
        "{twist:?}"
    );
    assert!(
        (twist.vy_m_s / expected_m_s.y - 1.0).abs() < 1e-3,
        "{twist:?}"
    );
}

/// A kilometre from the origin rapier drives as at the origin.
#[test]
fn far_from_the_origin_rapier_drives_as_at_the_origin() {
    let robot = mecanum4();
    let went = |x_m: f64| {
        let start = Pose {
            x_m,
            ..Pose::default()
        };
        let settings = by(ContactSolver::Rapier, 1000.0);
        let mut world = World::new(&robot, &Floor::default(), start, &settings).expect("valid");
        sideways(&mut world, &robot, 1000);
        let pose = world.robot().state().pose;
        Vector3::new(pose.x_m - x_m, pose.y_m, pose.heading_rad)
    };
    let (home, far) = (went(0.0), went(1000.0));
    println!("{home:?} {far:?}");
    assert!(home.y.abs() > 0.2);
    // It starts from the same places beneath the robot, and poses are summed in f64: 1e-13 of a
    // kilometre in each step.
    assert!((far - home).norm() < 1e-6);
}

/// With its wheels and rollers held a robot slides to rest in rapier too: mu g decelerates it, and
/// all of its kinetic energy becomes heat of sliding.
#[test]
fn a_held_robot_slides_to_rest_in_rapier() {
    let (friction, v_m_s) = (0.3, 0.8);
    let robot = mecanum4();
    let floor = Floor {
        friction,
        ..Floor::default()
    };
    let settings = by(ContactSolver::Rapier, 1000.0);
    let mut world = World::new(&robot, &floor, Pose::default(), &settings).expect("valid");
    seize_all(&mut world, &robot);
    let step = |world: &mut World, force_n: f64| {
        brake(world);
        world.robot_mut().push(&Push {
            force_in_world_n: Vector3::x() * force_n,
            place_in_body_m: robot.center_of_mass_m(),
        });
        world.step();
    };
    (0..300).for_each(|_| step(&mut world, 0.0));
    // In 0.1 s to its speed, against friction.
    let force_n = robot.mass_kg() * (v_m_s / 0.1 + friction * G);
    (0..100).for_each(|_| step(&mut world, force_n));
    let (speed_m_s, slip_j) = (
        world.robot().state().twist_in_body.vx_m_s,
        world.slip_energy_j(),
    );
    let from_m = world.robot().state().pose.x_m;
    (0..400).for_each(|_| step(&mut world, 0.0));
    let had_j = 0.5 * robot.mass_kg() * speed_m_s * speed_m_s;
    let heat_j = world.slip_energy_j() - slip_j;
    let way_m = world.robot().state().pose.x_m - from_m;
    let expected_m = speed_m_s * speed_m_s / (2.0 * friction * G);
    println!("{speed_m_s} m/s: {way_m} of {expected_m} m, {heat_j} of {had_j} J");
    // rapier advances with the velocity after a step, dt / t of the way less, and satisfies
    // Coulomb's law to some thousandths.
    assert!((way_m / expected_m - 1.0).abs() < 0.02);
    assert!((heat_j / had_j - 1.0).abs() < 0.02);
}

/// Uneven ground that rises along x and falls along y, longer than wide, carries a held robot at
/// the same height and tilt in rapier as with ilon's own solver.
#[test]
fn relief_that_leans_carries_a_robot_as_under_ilons_solver() {
    let robot = mecanum4();
    let (columns, rows, cell_m) = (41, 13, 0.1);
    let height_m = |row: usize, column: usize| 0.004 * column as f64 - 0.003 * row as f64;
    let relief = Relief {
        cell_m,
        center_m: Vector2::zeros(),
        heights_m: (0..rows)
            .map(|row| (0..columns).map(|column| height_m(row, column)).collect())
            .collect(),
    };
    let floor = Floor {
        relief: Some(relief),
        ..Floor::default()
    };
    let stands = |contacts: ContactSolver| {
        let start = Pose {
            x_m: 1.1,
            y_m: 0.05,
            heading_rad: 0.4,
        };
        let mut world = World::new(&robot, &floor, start, &by(contacts, 1000.0)).expect("valid");
        seize_all(&mut world, &robot);
        for _ in 0..600 {
            brake(&mut world);
            world.step();
        }
        let state = world.robot().state();
        Vector3::new(state.height_m, state.pitch_rad, state.roll_rad)
    };
    let [own, rapier] = [ContactSolver::Ilon, ContactSolver::Rapier].map(stands);
    println!("{own:?} {rapier:?}");
    assert!(own.y.abs() > 0.02 && own.z.abs() > 0.02);
    // rapier leaves its contacts some micrometres in the ground, and computes in f32.
    assert!((own - rapier).norm() < 1e-4);
}

/// A rotor before the gear turns along in rapier as with ilon's own solver: without gravity a
/// torque gives a wheel the same rate.
#[test]
fn a_rotor_is_turned_along_in_rapier() {
    let mut robot = mecanum4();
    for wheel in &mut robot.wheels {
        (wheel.drive.gear_ratio, wheel.drive.rotor_inertia_kg_m2) = (20.0, 2e-6);
    }
    let turns = |robot: &Robot, contacts: ContactSolver| {
        let settings = Settings {
            gravity_m_s2: 0.0,
            ..by(contacts, 1000.0)
        };
        let mut world = world(robot, &settings);
        for _ in 0..100 {
            world.robot_mut().apply(&[0.01; 4]);
            world.step();
        }
        world.robot().wheel_rates_rad_s()[0]
    };
    let [own, rapier] = [ContactSolver::Ilon, ContactSolver::Rapier].map(|by| turns(&robot, by));
    let without = turns(&mecanum4(), ContactSolver::Rapier);
    println!("{own} {rapier} rad/s, {without} without");
    // rapier's f32, and a first-order error of the chassis's rotation for a wheel.
    assert!((rapier / own - 1.0).abs() < 5e-3);
    assert!(rapier < 0.8 * without);
}
