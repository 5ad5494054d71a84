//! What the border costs.

use std::time::Instant;

use ilon_sim::{Plant, Scenario, WheelCommand};

use crate::support::{Owned, must, scenario};

/// Says it, and holds no bound: machines are shared. Between two advances the border looks the handle up, locks, and works out two velocities.
#[test]
fn what_a_step_across_the_border_costs_is_said() {
    const STEPS: u32 = 500;
    let path = scenario("mecanum4_lateral.toml");
    let owned = Owned::load(&path);
    let mut plant = Plant::of_scenario(&Scenario::load(&path).unwrap()).unwrap();
    let dt_s = owned.about().physics_dt_s;
    let rates = [-4.0, 4.0, 4.0, -4.0];
    let best_of = |act: &mut dyn FnMut()| {
        let timed = (0..5).map(|_| {
            let begun = Instant::now();
            (0..STEPS).for_each(|_| act());
            begun.elapsed().as_secs_f64() * 1e6 / f64::from(STEPS)
        });
        timed.fold(f64::INFINITY, f64::min)
    };
    let inside_us = best_of(&mut || {
        plant.advance(WheelCommand::Rates(&rates), dt_s).unwrap();
    });
    let across_us = best_of(&mut || must(owned.advance(&rates, dt_s)));
    // The lookup alone, of a call that does nothing else.
    let lookup_us = best_of(&mut || {
        std::hint::black_box(owned.about());
    });
    println!(
        "a step takes {inside_us:.2} us, across the border {across_us:.2} us, ratio {:.3}; a call that only looks {lookup_us:.3} us",
        across_us / inside_us
    );
    assert!(across_us.is_finite());
}
