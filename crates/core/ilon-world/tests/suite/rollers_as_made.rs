//! Rollers as manufactured: the height of a driving wheel's hub, against the geometry of its
//! rollers.

use crate::support;

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use ilon_robot::{Pose, Robot, RollersAsMade, Tread, Twist, Wheel};
use ilon_world::{
    ContactSolver, Floor, GroundBox, MotorTorque, Relief, RollerBodies, Settings, World, WorldError,
};
use nalgebra::Vector3;
use support::{ideal_rates, mecanum4, volksbot};

fn made(
    mut robot: Robot,
    change: impl Fn(&mut RollersAsMade),
    length_factor: Option<f64>,
) -> Robot {
    let mut made = RollersAsMade::default();
    change(&mut made);
    for wheel in &mut robot.wheels {
        wheel
            .make_rollers(made.clone(), length_factor)
            .expect("rollers");
    }
    robot
}

fn cylinders(half_m: f64, edge_radius_m: f64) -> impl Fn(&mut RollersAsMade) {
    move |made| {
        made.profile_m = Some(vec![[-half_m, 0.012], [half_m, 0.012]]);
        made.edge_radius_m = edge_radius_m;
    }
}

fn settings(dt_s: f64) -> Settings {
    Settings {
        dt_s,
        ..Settings::default()
    }
}

/// The results of a drive at a constant twist, wheels held to its rates by 5 N m s/rad.
struct Drive {
    /// Largest distance of a hub's height from that of the geometry at its wheel angle, in metres.
    off_m: f64,
    /// Its mean over wheels and steps, in metres.
    mean_off_m: f64,
    /// Smallest and largest height of a hub, in metres.
    heights_m: (f64, f64),
    /// The error of the energy balance, over the work of the motors and of landings, dimensionless.
    unexplained: f64,
    /// Way of the body along x over the turn of the first wheel, in metres a radian.
    way_m_rad: f64,
    impact_j: f64,
}

fn drive(robot: &Robot, twist: Twist, turns: f64, dt_s: f64) -> Drive {
    let mut world =
        World::new(robot, &Floor::default(), Pose::default(), &settings(dt_s)).expect("valid");
    let targets = ideal_rates(robot, twist);
    let began_j = world.energy().kinetic_j + world.energy().potential_j;
    let step = |world: &mut World, share: f64| {
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let motor = |(target, rate): (&f64, &f64)| {
            MotorTorque::with_droop(5.0 * (share * target - rate), 5.0)
        };
        let motors: Vec<_> = targets.iter().zip(&rates).map(motor).collect();
        world.robot_mut().drive(&motors);
        world.step();
    };
    while world.time_s() < 0.5 {
        let share = (world.time_s() / 0.5).min(1.0);
        step(&mut world, share);
    }
    let start = world.robot().wheel_angles_rad()[0];
    let mut found = Drive {
        off_m: 0.0,
        mean_off_m: 0.0,
        heights_m: (f64::INFINITY, 0.0),
        unexplained: 0.0,
        way_m_rad: 0.0,
        impact_j: 0.0,
    };
    let (mut looks, from_m) = (0.0, world.robot().state().pose.x_m);
    while (world.robot().wheel_angles_rad()[0] - start).abs() < turns * TAU {
        step(&mut world, 1.0);
        for (index, wheel) in robot.wheels.iter().enumerate() {
            let height_m = world.robot().hub_height_m(index);
            let exact_m = wheel.hub_height_m(world.robot().wheel_angles_rad()[index]);
            let off_m = (height_m - exact_m).abs();
            found.off_m = found.off_m.max(off_m);
            found.mean_off_m += off_m;
            looks += 1.0;
            let (low, high) = found.heights_m;
            found.heights_m = (low.min(height_m), high.max(height_m));
        }
    }
    found.mean_off_m /= looks;
    let turned = (world.robot().wheel_angles_rad()[0] - start).abs();
    found.way_m_rad = (world.robot().state().pose.x_m - from_m) / turned;
    let energy = world.energy();
    let lost_j = world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.bearing_energy_j()
        + world.impact_energy_j();
    let stored_j = energy.kinetic_j + energy.potential_j - began_j;
    let open_j = world.motor_energy_j() + world.outside_energy_j() - lost_j - stored_j;
    found.unexplained = open_j / (world.motor_energy_j().abs() + world.impact_energy_j().abs());
    found.impact_j = world.impact_energy_j();
    found
}

const AHEAD: Twist = Twist {
    vx_m_s: 0.1,
    vy_m_s: 0.0,
    omega_rad_s: 0.0,
};

const YAW: Twist = Twist {
    vx_m_s: 0.0,
    vy_m_s: 0.0,
    omega_rad_s: 0.4,
};

/// Largest slope of a hub's height over the wheel's angle, in metres a radian, by differences.
fn steepest_m(wheel: &Wheel) -> f64 {
    const STEP_RAD: f64 = TAU / 20_000.0;
    let height_m = |i: i32| wheel.hub_height_m(STEP_RAD * f64::from(i));
    (0..20_000)
        .map(|i| (height_m(i + 1) - height_m(i)).abs() / STEP_RAD)
        .fold(0.0, f64::max)
}

fn mean_height_m(wheel: &Wheel) -> f64 {
    (0..20_000)
        .map(|i| wheel.hub_height_m(TAU / 20_000.0 * f64::from(i)))
        .sum::<f64>()
        / 20_000.0
}

/// The hub follows the outline of its wheel, and the wheel rolls on its mean height: the contact
/// moves past the hub with omega n x (p - hub), whose forward part is omega times the height.
fn hub_follows_its_outline(robot: &Robot, twist: Twist) {
    const DT_S: f64 = 5e-4;
    let drive = drive(robot, twist, 1.0, DT_S);
    let wheel = &robot.wheels[0];
    let rate_rad_s = ideal_rates(robot, twist)[0].abs();
    // A contact is compressed by fractions of a micrometre; a landing is detected a step late, in
    // which the hub comes down by the slopes before and after it.
    let off_m = 1e-6 + 2.0 * steepest_m(wheel) * rate_rad_s * DT_S;
    assert!(drive.off_m < off_m, "{:e} of {off_m:e}", drive.off_m);
    assert!(drive.mean_off_m < 1e-6, "{:e}", drive.mean_off_m);
    // The error of the balance is of first order in the step: 0.02 % of the work.
    assert!(drive.unexplained.abs() < 1e-3, "{:e}", drive.unexplained);
    if twist == AHEAD {
        // A turn ends within a step of a whole one, over which the height differs by micrometres:
        // 1e-4 of a turn.
        let ratio = drive.way_m_rad / mean_height_m(wheel);
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    }
}

#[test]
fn the_default_drives_bit_by_bit_as_the_ideal_barrel() {
    let pose = |robot: &Robot| {
        let mut world =
            World::new(robot, &Floor::default(), Pose::default(), &settings(1e-3)).unwrap();
        for _ in 0..300 {
            world.robot_mut().apply(&[0.1, -0.05, 0.02, 0.07]);
            world.step();
        }
        let pose = world.robot().state().pose;
        [pose.x_m, pose.y_m, pose.heading_rad].map(f64::to_bits)
    };
    let seeded = made(mecanum4(), |made| made.radius_seed = 9, None);
    assert_eq!(pose(&mecanum4()), pose(&seeded));
}

#[test]
fn a_hub_rides_on_flat_and_on_round_barrels() {
    for crown in [0.1, 0.5, 1.5] {
        hub_follows_its_outline(&made(mecanum4(), |made| made.crown = crown, None), AHEAD);
    }
}

#[test]
fn a_wheel_drops_over_the_gaps_between_short_rollers() {
    for factor in [0.7, 0.9] {
        let robot = made(mecanum4(), |_| (), Some(factor));
        hub_follows_its_outline(&robot, AHEAD);
        // The rise: see `ilon-robot/tests/made.rs`; a of the ring, angles of half a pitch and of a
        // roller's end.
        let (a, k, half_pitch) = (0.038, std::f64::consts::FRAC_1_SQRT_2, PI / 9.0);
        let half_m = factor * a * half_pitch.tan() / k;
        let (far_m, end) = (f64::hypot(a, k * half_m), f64::atan2(k * half_m, a));
        let drop_m = far_m * (1.0 - (half_pitch - end).cos());
        let drive = drive(&robot, AHEAD, 1.0, 2.5e-4);
        let (low_m, high_m) = drive.heights_m;
        assert!(
            (high_m - low_m - drop_m).abs() < 3e-6,
            "{low_m} {high_m} {drop_m}"
        );
    }
}

#[test]
fn a_hub_rides_on_the_edges_of_cylinders() {
    for edge_radius_m in [0.0, 0.001] {
        hub_follows_its_outline(
            &made(mecanum4(), cylinders(0.016, edge_radius_m), None),
            AHEAD,
        );
    }
    // Omni wheels, in a turn on the spot.
    hub_follows_its_outline(&made(volksbot(), cylinders(0.012, 0.0005), None), YAW);
}

#[test]
fn a_profile_by_numbers_of_the_barrel_rolls_as_the_barrel() {
    // Sixteen chords of the ideal outline.
    let ideal = mecanum4();
    let barrel = ideal.wheels[0].barrel(&ideal.wheels[0].rollers[0]);
    let point = |i: i32| {
        let t = f64::from(i) / 8.0 * barrel.half_length_m;
        let k = barrel.sin_delta;
        let w = k * k * t / f64::hypot(barrel.ring_radius_m, k * t);
        let s = barrel.sphere_radius_m(t);
        [t + s * w, s * (1.0 - w * w).sqrt()]
    };
    let points: Vec<[f64; 2]> = (-8..=8).map(point).collect();
    let robot = made(
        ideal,
        move |made| made.profile_m = Some(points.clone()),
        None,
    );
    hub_follows_its_outline(&robot, AHEAD);
    let drive = drive(&robot, AHEAD, 1.0, 1e-3);
    let (low_m, high_m) = drive.heights_m;
    // Chords of an arc of radius rho and of 20 deg / 8 each lie rho (2.5 deg)^2 / 8 = 12 um below
    // it.
    assert!(
        high_m < 0.05 + 1e-6 && low_m > 0.05 - 14e-6,
        "{low_m} {high_m}"
    );
}

#[test]
fn unequal_rollers_move_the_mean_as_their_mean_radius() {
    // All thicker by 0.2 mm: the wheel of radius rho + 0.2 mm.
    let offsets = |of: fn(usize) -> f64| {
        let offsets: BTreeMap<String, f64> = (0..9).map(|i| (format!("r{i}"), of(i))).collect();
        made(
            mecanum4(),
            move |made| made.radius_offsets_m = offsets.clone(),
            None,
        )
    };
    let thick = offsets(|_| 2e-4);
    assert!((mean_height_m(&thick.wheels[0]) - 0.0502).abs() < 1e-9);
    let way_m = drive(&thick, AHEAD, 1.0, 1e-3).way_m_rad;
    assert!((way_m / 0.0502 - 1.0).abs() < 2e-5, "{way_m}");
    // One thicker than the others: the mean rises by its share of that, and each turn equals the
    // one before.
    let one = offsets(|i| if i == 3 { 2e-4 } else { 0.0 });
    hub_follows_its_outline(&one, AHEAD);
    let raised_m = mean_height_m(&one.wheels[0]) - 0.05;
    // It carries the wheel over its own ninth of a turn and a little beyond.
    assert!(
        (2e-4 / 9.0..3.0 * 2e-4 / 9.0).contains(&raised_m),
        "{raised_m:e}"
    );
}

#[test]
fn rollers_that_are_no_barrels_drive_over_a_kerb() {
    let floor = Floor {
        boxes: vec![GroundBox {
            center_m: Vector3::new(0.6, 0.0, 0.0),
            half_sides_m: Vector3::new(0.3, 0.5, 0.004),
            heading_rad: 0.0,
            pitch_rad: 0.0,
        }],
        ..Floor::default()
    };
    for robot in [
        made(mecanum4(), cylinders(0.016, 0.001), None),
        made(mecanum4(), cylinders(0.016, 0.0), None),
        made(mecanum4(), |made| made.crown = 0.5, Some(0.9)),
    ] {
        let mut world = World::new(&robot, &floor, Pose::default(), &settings(1e-3)).unwrap();
        let targets = ideal_rates(&robot, AHEAD);
        let began_j = world.energy().kinetic_j + world.energy().potential_j;
        let mut highest_m: f64 = 0.0;
        while world.time_s() < 4.0 {
            let rates = world.robot().wheel_rates_rad_s().to_vec();
            let motor = |(target, rate): (&f64, &f64)| {
                MotorTorque::with_droop(5.0 * (2.0 * target - rate), 5.0)
            };
            let motors: Vec<_> = targets.iter().zip(&rates).map(motor).collect();
            world.robot_mut().drive(&motors);
            world.step();
            highest_m = highest_m.max(world.robot().hub_height_m(0));
            assert!(
                world.robot().penetration_m() < 5e-4,
                "{}",
                world.robot().penetration_m()
            );
        }
        // On the kerb, and no higher than wheel and kerb by a hop of a fifth of it.
        assert!((0.0535..0.0568).contains(&highest_m), "{highest_m}");
        assert!(world.robot().state().pose.x_m > 0.4);
        let energy = world.energy();
        let lost_j = world.slip_energy_j()
            + world.spin_up_energy_j()
            + world.bearing_energy_j()
            + world.impact_energy_j();
        let open_j =
            world.motor_energy_j() - lost_j - (energy.kinetic_j + energy.potential_j - began_j);
        assert!(open_j.abs() < 0.01 * world.motor_energy_j(), "{open_j}");
    }
}

/// Sideways over bumps of 2 mm: a wheel of cylinders behaves nearly like one of barrels.
#[test]
fn cylinders_drive_over_bumps_as_barrels_do() {
    let size = 161;
    let bump = |i: usize| 0.002 * ((i * 7919 + i * i * 31) % 101) as f64 / 100.0;
    let relief = Relief {
        cell_m: 0.02,
        center_m: Default::default(),
        heights_m: (0..size)
            .map(|row| (0..size).map(|column| bump(row * size + column)).collect())
            .collect(),
    };
    let floor = Floor {
        relief: Some(relief),
        ..Floor::default()
    };
    let way_m = |robot: &Robot| {
        let mut world = World::new(robot, &floor, Pose::default(), &settings(2e-3)).unwrap();
        let targets = ideal_rates(robot, Twist::new(0.0, 0.2, 0.0));
        while world.time_s() < 0.8 {
            let rates = world.robot().wheel_rates_rad_s().to_vec();
            let motor =
                |(target, rate): (&f64, &f64)| MotorTorque::with_droop(0.3 * (target - rate), 0.3);
            let motors: Vec<_> = targets.iter().zip(&rates).map(motor).collect();
            world.robot_mut().drive(&motors);
            world.step();
        }
        world.robot().state().pose.y_m
    };
    let barrels_m = way_m(&mecanum4());
    let cylinders_m = way_m(&made(mecanum4(), cylinders(0.0138, 0.001), None));
    // Their mean heights differ by a few per cent, and both lose a few on bumps.
    assert!(
        (cylinders_m / barrels_m - 1.0).abs() < 0.06,
        "{cylinders_m} {barrels_m}"
    );
}

#[test]
fn what_is_not_known_of_a_profile_by_numbers_is_refused() {
    let mut robot = made(mecanum4(), cylinders(0.016, 0.001), None);
    let world = |robot: &Robot, settings: &Settings| {
        World::new(robot, &Floor::default(), Pose::default(), settings).map(|_| ())
    };
    let in_rapier = Settings {
        contacts: ContactSolver::Rapier,
        roller_bodies: RollerBodies::All,
        split_dt_s: None,
        ..settings(1e-3)
    };
    let refused = world(&robot, &in_rapier).unwrap_err();
    assert!(
        matches!(refused, WorldError::NotInRapier { .. }),
        "{refused}"
    );
    // A crowned roller is a barrel for rapier too.
    let crowned = made(mecanum4(), |made| made.crown = 0.8, None);
    assert_eq!(world(&crowned, &in_rapier), Ok(()));
    robot.wheels[1].surface.tread = Some(Tread::new(1e5));
    let refused = world(&robot, &settings(1e-3)).unwrap_err();
    assert!(
        matches!(&refused, WorldError::Wheel { reason, .. } if reason.contains("by numbers and a tread")),
        "{refused}"
    );
}

/// Sideways, where rollers that hand over at once have different axes: the robot follows the
/// contact kinematics of its lowest rollers, at any step, and nothing slides. Neighbouring flat
/// rollers are equally low for degrees of a turn.
#[test]
fn neighbours_that_are_equally_low_do_not_rub() {
    for crown in [0.3, 0.5, 0.8, 0.9] {
        let robot = made(mecanum4(), |made| made.crown = crown, None);
        for dt_s in [1e-3, 5e-4] {
            let mut world =
                World::new(&robot, &Floor::default(), Pose::default(), &settings(dt_s)).unwrap();
            let targets = ideal_rates(&robot, Twist::new(0.0, 0.3, 0.0));
            let (mut expected_m, mut from_m) = (0.0, 0.0);
            while world.time_s() < 4.0 {
                let share = (world.time_s() / 0.5).min(1.0);
                let rates = world.robot().wheel_rates_rad_s().to_vec();
                let motor = |(target, rate): (&f64, &f64)| {
                    MotorTorque::with_droop(0.3 * (share * target - rate), 0.3)
                };
                let motors: Vec<_> = targets.iter().zip(&rates).map(motor).collect();
                world.robot_mut().drive(&motors);
                world.step();
                if world.time_s() < 1.0 {
                    from_m = world.robot().state().pose.y_m;
                    continue;
                }
                let (angles, rates) = (
                    world.robot().wheel_angles_rad(),
                    world.robot().wheel_rates_rad_s(),
                );
                expected_m += support::contact_twist(&robot, angles, rates).vy_m_s * dt_s;
            }
            let ratio = (world.robot().state().pose.y_m - from_m) / expected_m;
            // The sum uses the twist at the ends of steps: half a step of hand-overs with jumps of
            // a few per cent, 1e-4 in total.
            assert!(
                (ratio - 1.0).abs() < 2e-4,
                "crown {crown}, {dt_s} s: {ratio}"
            );
            assert!(world.slip_energy_j() < 1e-3, "{}", world.slip_energy_j());
        }
    }
}
