//! Properties of every step on any course: the laws of contact and friction, the energy balance,
//! and reproducible bits.

use crate::support;

use ilon_robot::{Pose, Twist};
use ilon_world::{Floor, GroundBox, MotorTorque, Settings, World};
use nalgebra::Vector3;
use support::rig::{Rig, all, bumps, end_of_course, near};
use support::{DRIVES, ideal_rates, mecanum4, volksbot};

/// Under wheel loops as stiff as a held wheel, steps of 1/60 s leave no artificial sliding, at any
/// heading and while the heading turns. What remains is f32's rounding of the rates: 6e-8 of a
/// roller's 40 rad/s at 12 mm.
#[test]
fn nothing_slides_that_should_stick_at_any_heading_under_stiff_wheel_loops() {
    let robot = mecanum4();
    let settings = near(60.0);
    for heading_deg in [0.0, 20.0] {
        for (name, [vx, vy, omega]) in DRIVES {
            let mut rig = Rig::new(&robot, &Floor::default(), heading_deg, &settings);
            let targets = ideal_rates(&robot, Twist::new(vx, vy, omega));
            let (mut squares, mut count) = (0.0, 0.0);
            for step in 0..180 {
                let share = (f64::from(step) / 30.0).min(1.0);
                let rates = rig.world.robot().wheel_rates_rad_s();
                // 0.42 N m s: 60 rad/s of the robot's share that a wheel feels.
                let pull = |(target, rate): (&f64, &f64)| 0.42 * (share * target - rate);
                let torques: Vec<f64> = targets.iter().zip(rates).map(pull).collect();
                rig.world.robot_mut().drive(
                    &torques
                        .iter()
                        .map(|t| MotorTorque::with_droop(*t, 0.42))
                        .collect::<Vec<_>>(),
                );
                rig.world.step();
                if step >= 60 {
                    for contact in rig.world.robot().contacts() {
                        squares += contact.sliding_in_body_m_s.norm_squared();
                        count += 1.0;
                    }
                }
            }
            let sliding_m_s = f64::sqrt(squares / count);
            assert!(
                sliding_m_s < 1e-6,
                "{name} at {heading_deg} deg: {sliding_m_s} m/s rms"
            );
        }
    }
}

/// Signorini's, Coulomb's and the bearings' laws hold in every step to the solver's tolerance, 1e-8
/// m/s: rolling, and sliding on a floor that cannot hold the robot. On bumps several triangles give
/// nearly redundant contacts of one roller, and the last digits cannot always be reached: there 97
/// of 100 steps are solved, and none has an error above 2 mm/s.
#[test]
fn the_laws_of_contact_hold_in_every_step() {
    let slippery = Floor {
        friction: 0.05,
        ..Floor::default()
    };
    let hardly_any = Floor {
        friction: 1e-300,
        ..Floor::default()
    };
    for (place, floor, unsolved, worst_m_s) in [
        ("plane", Floor::default(), 0, 1e-8),
        ("slippery", slippery, 0, 1e-8),
        ("all but without friction", hardly_any, 0, 1e-8),
        ("bumps", bumps(7), 30, 2e-3),
    ] {
        let mut rig = Rig::new(&mecanum4(), &floor, 20.0, &near(500.0));
        rig.targets = ideal_rates(&mecanum4(), Twist::new(0.0, 0.3, 0.0));
        let errors: Vec<f64> = (0..1000)
            .map(|_| {
                rig.run_s(0.002);
                rig.world.contact_residual_m_s()
            })
            .collect();
        let beyond = errors.iter().filter(|error| **error > 1e-8).count();
        let most = errors.iter().copied().fold(0.0, f64::max);
        println!("{place}: {beyond} of 1000 unsolved, at most {most:.1e}");
        assert!(
            beyond <= unsolved && most <= worst_m_s,
            "{place}: {beyond}, {most:.1e}"
        );
    }
}

/// Every joule of the motors is stored, lost to sliding or bearings, or lost when a roller lands.
///
/// The work of every impulse is counted exactly for a constant inertia; the error comes from the
/// rotation of a roller during the step in which it comes down, and from f32.
#[test]
fn the_energy_balance_closes() {
    let kerb = Floor {
        boxes: vec![GroundBox {
            center_m: Vector3::new(0.45, 0.0, 0.0),
            half_sides_m: Vector3::new(0.1, 1.0, 0.005),
            heading_rad: 0.1,
            pitch_rad: 0.0,
        }],
        ..Floor::default()
    };
    // Too high to be climbed: the wheels push and slide.
    let mut high_kerb = kerb.clone();
    high_kerb.boxes[0].half_sides_m.z = 0.02;
    let slope = Floor {
        slope_rad: 0.1,
        ..Floor::default()
    };
    for (place, floor) in [
        ("on the plane", Floor::default()),
        ("on a slope", slope),
        ("over a kerb", kerb),
        ("against a high kerb", high_kerb),
        ("on bumps", bumps(7)),
    ] {
        for (robot, twist) in [
            (mecanum4(), Twist::new(0.3, 0.0, 0.0)),
            (mecanum4(), Twist::new(0.0, 0.3, 0.0)),
            (volksbot(), Twist::new(0.2, 0.2, 0.5)),
        ] {
            for settings in [all(500.0), near(500.0), near(250.0), near(60.0)] {
                let mut rig = Rig::new(&robot, &floor, 0.3, &settings);
                if settings.dt_s > 0.01 {
                    // Over edges a robot turns and falls by too much in so long a step.
                    if !floor.boxes.is_empty() || floor.relief.is_some() {
                        continue;
                    }
                    // The rig's own loop is too stiff for so long a step.
                    rig.proportional_n_m_s = 0.01;
                }
                rig.run_s(0.3);
                let energies = |world: &World| {
                    let stored = world.energy();
                    [
                        world.motor_energy_j(),
                        -stored.kinetic_j,
                        -stored.potential_j,
                        -world.slip_energy_j(),
                        -world.spin_up_energy_j(),
                        -world.bearing_energy_j(),
                        -world.impact_energy_j(),
                    ]
                };
                let before = energies(&rig.world);
                rig.targets = ideal_rates(&robot, twist);
                rig.run_s(1.5);
                let terms = energies(&rig.world);
                let terms: Vec<f64> = terms.iter().zip(before).map(|(a, b)| a - b).collect();
                let turnover_j: f64 = 0.5 * terms.iter().map(|j| j.abs()).sum::<f64>();
                let share = terms.iter().sum::<f64>() / turnover_j;
                println!(
                    "{share:.2e} {} {:?} {place} {} {:?}",
                    settings.dt_s, settings.roller_bodies, robot.name, terms
                );
                // On the plane and on a slope nothing lands, and a thousandth would be a term that
                // is not counted: the bearings of coasting rollers are five. A roller's spin
                // changes by half over the first part of its passage, and a step takes it in one
                // piece: an error of second order, (250 / 60)^2 = 17 times as large at 60 steps a
                // second.
                let bound = match place {
                    "on the plane" | "on a slope" if settings.dt_s > 0.01 => 5e-3,
                    "on the plane" | "on a slope" => 3e-4,
                    _ => 2e-3,
                };
                assert!(
                    share.abs() < bound,
                    "{share:.2e} of {turnover_j:.3} J are missing: {} {place}, {twist:?}, {:?} at {} s",
                    robot.name,
                    settings.roller_bodies,
                    settings.dt_s
                );
            }
        }
    }
}

#[test]
fn two_runs_are_the_same_to_the_bit() {
    let run = || {
        let (pose, rig) = end_of_course(&Floor::default(), &near(500.0));
        let bits = [pose.x_m, pose.y_m, pose.heading_rad].map(f64::to_bits);
        (
            bits,
            rig.world
                .robot()
                .wheel_angles_rad()
                .iter()
                .map(|a| a.to_bits())
                .collect::<Vec<_>>(),
        )
    };
    assert_eq!(run(), run());
}

/// Far from the origin f32 would lose a step's increment of 0.1 mm; the world's f64 sums keep it.
#[test]
fn far_from_the_origin_the_robot_drives_as_far_as_at_home() {
    let way = |x_m: f64| {
        let robot = mecanum4();
        let start = Pose {
            x_m,
            ..Pose::default()
        };
        let mut rig = Rig {
            world: World::new(&robot, &Floor::default(), start, &near(500.0))
                .expect("a valid world"),
            ..Rig::new(&robot, &Floor::default(), 0.0, &near(500.0))
        };
        rig.targets = ideal_rates(&robot, Twist::new(0.05, 0.0, 0.0));
        rig.run_s(4.0);
        rig.pose().x_m - x_m
    };
    let (home, away) = (way(0.0), way(1000.0));
    assert!(
        (home - away).abs() < 1e-4,
        "{home} m at home, {away} m at 1 km"
    );
}

/// A step that is taken in parts is so many steps of that length. A robot stands on a slope, held
/// by loops whose torque is in balance with its weight. Its rollers hold along their axes, at 45
/// degrees: that takes sqrt(2) tan(0.25) / 0.6 = 0.6 of its grip, so that every step from the
/// second on is taken in parts, and whole steps and short ones begin from the same rest. Then the
/// loops ask for a fifth more torque, which falls as the wheels gain rate, at 60 /s: two steps of 4
/// ms come to another speed than six of 4/3 ms. Parts of "about" 1.5 ms are three of 4/3 ms, the
/// fewest that are not longer.
#[test]
fn a_step_in_parts_goes_as_steps_of_that_length() {
    const DT_S: f64 = 4e-3;
    const GAIN_N_M_S: f64 = 0.42;
    const RESTS_S: f64 = 0.2;
    let (robot, slope_rad) = (mecanum4(), 0.25_f64);
    let floor = Floor {
        slope_rad,
        ..Floor::default()
    };
    // The four rims hold m g sin(slope), back against +x, where the slope falls.
    let back = ideal_rates(&robot, Twist::new(-1.0, 0.0, 0.0))[0].signum();
    let holds_n_m = back * robot.mass_kg() * 9.81 * slope_rad.sin() * 0.05 / 4.0;
    let speed_m_s = |dt_s: f64, split_dt_s: Option<f64>| {
        let settings = Settings {
            dt_s,
            split_dt_s,
            ..Settings::default()
        };
        let mut world = World::new(&robot, &floor, Pose::default(), &settings).expect("valid");
        while world.time_s() < RESTS_S + 2.0 * DT_S - 1e-9 {
            let rests = world.time_s() < RESTS_S - 1e-9;
            let asked_n_m = if rests { holds_n_m } else { 1.2 * holds_n_m };
            let rates = world.robot().wheel_rates_rad_s().iter();
            let motors: Vec<MotorTorque> = rates
                .map(|rate| MotorTorque::with_droop(asked_n_m - GAIN_N_M_S * rate, GAIN_N_M_S))
                .collect();
            world.robot_mut().drive(&motors);
            world.step();
            let pulled = world.robot().contacts()[0];
            assert!(pulled.force_in_body_n.norm() < 0.6 * pulled.normal_force_n);
        }
        world.robot().state().twist_in_body.vx_m_s
    };
    let in_parts = speed_m_s(DT_S, Some(1.5e-3));
    let (short, whole) = (speed_m_s(DT_S / 3.0, None), speed_m_s(DT_S, None));
    println!("{in_parts} m/s in parts, {short} m/s in short steps, {whole} m/s in whole ones");
    assert!(short < -1e-3);
    // The error of the first step, which is taken whole, is far below the effect of a step's
    // length.
    let off = (in_parts - short) / (whole - short);
    assert!(off.abs() < 0.02, "{off}");
}

/// The losses to sliding and spin-up under each wheel in a step add up to the robot's, also if
/// steps are split.
#[test]
fn what_wheels_lose_adds_up() {
    let robot = mecanum4();
    for (dt_s, split_dt_s) in [(1e-3, None), (4e-3, Some(2e-4))] {
        let settings = Settings {
            dt_s,
            split_dt_s,
            ..Settings::default()
        };
        let floor = Floor {
            friction: 0.3,
            ..Floor::default()
        };
        let mut world = World::new(&robot, &floor, Pose::default(), &settings).expect("valid");
        let rates = ideal_rates(&robot, Twist::new(0.6, 0.5, 3.0));
        let mut sums_j = [0.0; 2];
        while world.time_s() < 1.5 {
            let now = world.robot().wheel_rates_rad_s().iter();
            let motors: Vec<_> = rates
                .iter()
                .zip(now)
                .map(|(rate, now)| MotorTorque::with_droop(0.3 * (rate - now), 0.3))
                .collect();
            world.robot_mut().drive(&motors);
            world.step();
            for of in world.robot().contacts() {
                sums_j[0] += of.slip_power_w * dt_s;
                sums_j[1] += of.spin_up_power_w * dt_s;
            }
        }
        let whole_j = [world.slip_energy_j(), world.spin_up_energy_j()];
        println!("{sums_j:?} of {whole_j:?}");
        assert!(whole_j[0] > 0.1 && whole_j[1] > 1e-4);
        for (sum_j, whole_j) in sums_j.iter().zip(whole_j) {
            // Sums of thousands in f64.
            assert!((sum_j - whole_j).abs() < 1e-9, "{sum_j} {whole_j}");
        }
    }
}
