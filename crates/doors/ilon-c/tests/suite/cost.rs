//! The cost of calls through the C interface.

use std::time::Instant;

use ilon_c::plant::{ilon_plant_restore, ilon_plant_snapshot, ilon_snapshot_free};
use ilon_sim::{Plant, Scenario, WheelCommand};

use crate::support::{Owned, must, scenario};

/// The least time of many repetitions of the same step, in microseconds; other load on the machine
/// can only increase it. `back` restores the state before the step, and is not timed.
fn least_us(mut back: impl FnMut(), mut act: impl FnMut()) -> f64 {
    const GOES: usize = 400;
    let timed = (0..GOES).map(|_| {
        back();
        let begun = Instant::now();
        act();
        begun.elapsed().as_secs_f64() * 1e6
    });
    timed.fold(f64::INFINITY, f64::min)
}

const RATES: [f64; 4] = [-4.0, 4.0, 4.0, -4.0];

/// The same step from the same state, in Rust and through the C interface, which looks up and locks
/// a handle and computes two velocities. It holds without optimisation too.
#[test]
#[ignore = "goes by the clock: cargo test --release -p ilon-c --test suite -- --ignored --test-threads 1 cost::"]
fn a_step_across_the_border_costs_less_than_a_microsecond_more() {
    let path = scenario("mecanum4_lateral.toml");
    let owned = Owned::load(&path);
    let dt_s = owned.about().physics_dt_s;
    let mut plant = Plant::of_scenario(&Scenario::load(&path).unwrap()).unwrap();
    for _ in 0..100 {
        plant.advance(WheelCommand::Rates(&RATES), dt_s).unwrap();
        must(owned.advance(&RATES, dt_s));
    }
    let start = plant.snapshot();
    let mut kept = 0;
    // SAFETY: the snapshot is a local.
    must(unsafe { ilon_plant_snapshot(owned.0, &raw mut kept) });
    let plant = std::cell::RefCell::new(plant);
    let inside_us = least_us(
        || plant.borrow_mut().restore(&start).unwrap(),
        || {
            let advanced = &mut *plant.borrow_mut();
            advanced.advance(WheelCommand::Rates(&RATES), dt_s).unwrap();
        },
    );
    let across_us = least_us(
        || must(ilon_plant_restore(owned.0, kept)),
        || must(owned.advance(&RATES, dt_s)),
    );
    println!("a step takes {inside_us:.2} us, across the border {across_us:.2} us");
    must(ilon_snapshot_free(kept));
    assert!(
        across_us - inside_us < 1.0,
        "{across_us} against {inside_us}"
    );
}

/// The same through the functions of FMI: rates are set, a step is taken, six numbers are read.
#[cfg(target_pointer_width = "64")]
#[test]
#[ignore = "goes by the clock: cargo test --release -p ilon-c --test suite -- --ignored --test-threads 1 cost::"]
fn a_step_through_fmi_costs_less_than_five_microseconds_more() {
    use ilon_fmi::{Instance, Value};
    let path = scenario("mecanum4_lateral.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let folder = path.parent().unwrap();
    let files = ilon_sim::files::FileAccess::anywhere();
    let mut made = Instance::of(text, folder, files).unwrap();
    let dt_s = made.plant().resolved().physics_dt_s();
    let named = |name: &str| {
        made.variables()
            .iter()
            .position(|of| of.name == name)
            .unwrap() as u32
    };
    let rates: Vec<u32> = (1..=4)
        .map(|k| named(&format!("wheel[{k}].rate_command")))
        .collect();
    let read = [
        "position.x",
        "position.y",
        "orientation.heading",
        "velocity.x",
        "velocity.y",
        "angular.z",
    ]
    .map(named);
    made.enter_initialization(0.0).unwrap();
    made.exit_initialization().unwrap();
    let act = |instance: &mut Instance| {
        for (reference, rate) in rates.iter().zip(RATES) {
            instance.set(*reference, Value::Real(rate)).unwrap();
        }
        instance.step(instance.time_s(), dt_s).unwrap();
        for reference in read {
            std::hint::black_box(instance.get(reference).unwrap());
        }
    };
    (0..100).for_each(|_| act(&mut made));
    let instance = std::cell::RefCell::new(made.clone());
    let through_us = least_us(
        || instance.borrow_mut().clone_from(&made),
        || act(&mut instance.borrow_mut()),
    );
    let plant = std::cell::RefCell::new(made.plant().clone());
    let inside_us = least_us(
        || *plant.borrow_mut() = made.plant().clone(),
        || {
            let advanced = &mut *plant.borrow_mut();
            advanced.advance(WheelCommand::Rates(&RATES), dt_s).unwrap();
        },
    );
    println!("a step takes {inside_us:.2} us, through FMI {through_us:.2} us");
    assert!(
        through_us - inside_us < 5.0,
        "{through_us} against {inside_us}"
    );
}
