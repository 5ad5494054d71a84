//! Sliding: Coulomb's law against closed-form motions.

use crate::support;

use ilon_oracle::{Drive, Engine};
use nalgebra::Vector3;
use support::{engine, lock, moving, robot, run, without_bearings};

const FRICTION: f64 = 0.3;

/// A robot that slides at 1 m/s in a direction with locked wheels and free or locked rollers.
fn sliding(direction: f64, seized: bool) -> Engine {
    let robot = without_bearings(robot("mecanum4"));
    let mut engine = engine(&robot, 2e6, FRICTION, 1e-5);
    lock(&mut engine);
    for roller in 0..engine.speeds().rollers.len() {
        engine.seize_roller(roller, seized);
    }
    engine.set_speeds(moving(
        &engine,
        Vector3::new(direction.cos(), direction.sin(), 0.0),
    ));
    engine
}

#[test]
fn a_block_slides_with_mu_g_in_any_direction() {
    for direction in [0.0, 0.7, 1.6, -2.5] {
        let mut engine = sliding(direction, true);
        run(&mut engine, 0.1);
        let from = engine.speeds().linear;
        run(&mut engine, 0.1);
        let deceleration = (from - engine.speeds().linear) / 0.1;
        let expected = Vector3::new(direction.cos(), direction.sin(), 0.0) * FRICTION * 9.81;
        println!("{deceleration:?}, {expected:?} expected");
        // The tilt of the chassis by its deceleration turns the floor's normal by the sag over the
        // wheelbase, 5e-5.
        assert!((deceleration - expected).norm() < 1e-3 * expected.norm());
    }
}

#[test]
fn with_free_rollers_only_friction_along_their_axes_is_left() {
    // Ahead with locked wheels, each roller spins up until it slides only along its axis: mu N
    // along the axis, cos 45 deg of it against the motion.
    let mut engine = sliding(0.0, false);
    run(&mut engine, 0.1);
    let from = engine.speeds().linear;
    run(&mut engine, 0.1);
    let deceleration = (from - engine.speeds().linear) / 0.1;
    let expected = FRICTION * 9.81 * 0.5_f64.sqrt();
    println!("{deceleration:?}, {expected} expected");
    // A spinning roller adds (I / r^2) / (m / 4) cos^2 = 8e-4 to the mass.
    assert!((deceleration.x / expected - 1.0).abs() < 2e-3);
}

#[test]
fn what_slides_turns_its_kinetic_energy_into_heat_of_sliding() {
    let mut engine = sliding(0.7, true);
    let before = engine.energy();
    run(&mut engine, 0.5);
    let after = engine.energy();
    // It stands after v / (mu g) = 0.34 s.
    assert!(after.kinetic_j < 1e-6);
    println!("{before:?}\n{after:?}");
    let heat = after.slip_j / before.kinetic_j;
    // Springs oscillate at the start and at the end: mu N of 9 N deflects a bristle by 7 um, of a
    // path of 0.17 m.
    assert!((heat - 1.0).abs() < 2e-3, "{heat}");
}

#[test]
fn friction_keeps_within_the_cone_and_no_contact_pulls_through_a_hard_start() {
    let robot = robot("mecanum4");
    let mut engine = engine(&robot, 2e6, FRICTION, 1e-5);
    for wheel in 0..4 {
        engine.drive(wheel, Drive::Torque(if wheel < 2 { 1.0 } else { 0.6 }));
    }
    let (mut slid, mut stuck) = (false, false);
    for _ in 0..30_000 {
        engine.step().expect("the motion stays finite");
        for contact in engine.contacts() {
            let limit = FRICTION * contact.normal_n;
            assert!(contact.normal_n >= 0.0);
            assert!(contact.friction_n.norm() <= limit * (1.0 + 1e-12));
            slid |= contact.slides;
            stuck |= !contact.slides;
        }
    }
    assert!(slid && stuck);
}

#[test]
fn the_energy_balance_closes_through_a_start_that_slides_to_first_order_of_the_step() {
    let robot = robot("mecanum4");
    let open = |step_s: f64| {
        let mut engine = engine(&robot, 2e5, FRICTION, step_s);
        let before = engine.energy().balance_j();
        support::follow(&mut engine, &[20.0, 12.0, 16.0, 20.0]);
        run(&mut engine, 0.5);
        let energy = engine.energy();
        println!(
            "{step_s:e} s: {:.3e} J open of {:.3} J, {energy:?}",
            energy.balance_j() - before,
            energy.drives_j
        );
        ((energy.balance_j() - before).abs(), energy.drives_j)
    };
    let ((coarse, _), (fine, work)) = (open(2e-5), open(5e-6));
    // Heat at the old speeds against work at the mean ones: first order.
    assert!(fine < 1e-3 * work && fine < 0.4 * coarse);
}

#[test]
fn the_end_of_a_run_that_slides_converges_to_first_order_of_the_step() {
    let robot = robot("mecanum4");
    let end = |step_s: f64| {
        let mut engine = engine(&robot, 2e5, FRICTION, step_s);
        support::follow(&mut engine, &[20.0, 12.0, 16.0, 20.0]);
        run(&mut engine, 0.4);
        engine.world_from_body().translation.vector
    };
    let ends = [2e-5, 1e-5, 5e-6, 2.5e-6].map(end);
    let gaps: Vec<f64> = ends
        .windows(2)
        .map(|pair| (pair[0] - pair[1]).norm())
        .collect();
    println!("{ends:?}: {gaps:?}");
    // Halves with the step, within the uncertainty of the moments of sticking; and is small: 0.1 mm
    // of half a metre at 10 us.
    assert!(gaps[1] < 0.8 * gaps[0] && gaps[2] < 0.8 * gaps[1]);
    assert!(gaps[1] < 1e-4);
}
