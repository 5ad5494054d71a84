//! The memory of a plant that is stepped for long does not grow, and nothing remains after handles
//! are freed. A test program of its own, as it counts every allocated byte.

#![allow(
    unsafe_code,
    reason = "the functions under test are those that C calls"
)]

use std::alloc::System;
use std::ffi::CString;
use std::path::Path;
use std::sync::Mutex;

use ilon_c::plant::*;
use ilon_c::state::IlonAbout;
use ilon_c::status::IlonStatus;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static COUNTED: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn load() -> IlonPlant {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../assets/scenarios/mecanum4_lateral.toml");
    let path = CString::new(path.to_str().unwrap()).unwrap();
    let mut plant = 0;
    // SAFETY: the text and the handle are locals.
    assert_eq!(
        unsafe { ilon_plant_load(path.as_ptr(), &raw mut plant) },
        IlonStatus::Ok
    );
    plant
}

/// Changes in each step everything that a caller can change, and takes and frees a snapshot.
fn drive(plant: IlonPlant, steps: u32) {
    let mut about = IlonAbout::default();
    // SAFETY: the handle is a local.
    assert_eq!(
        unsafe { ilon_plant_about(plant, &raw mut about) },
        IlonStatus::Ok
    );
    let dt_s = about.physics_dt_s;
    for step in 0..steps {
        let phase = f64::from(step % 100) / 100.0;
        let rates = [-4.0 + phase, 4.0, 4.0, -4.0];
        let force = [phase, 1.0 - phase, 0.0];
        let mut snapshot = 0;
        // SAFETY: arrays and handle are locals.
        unsafe {
            let set = ilon_plant_set_wrench(plant, force.as_ptr(), force.as_ptr(), force.as_ptr());
            assert_eq!(set, IlonStatus::Ok);
            if step % 50 == 0 {
                ilon_plant_set_payload(plant, phase, std::ptr::null());
                ilon_plant_snapshot(plant, &raw mut snapshot);
            }
            let advanced = ilon_plant_advance_rates(plant, rates.as_ptr(), 4, dt_s);
            assert_eq!(advanced, IlonStatus::Ok);
            // A successful call keeps the message of the last failure.
            ilon_plant_advance_rates(plant, rates.as_ptr(), 3, dt_s);
        }
        if snapshot != 0 {
            assert_eq!(ilon_plant_restore(plant, snapshot), IlonStatus::Ok);
            assert_eq!(ilon_snapshot_free(snapshot), IlonStatus::Ok);
        }
    }
}

/// Bytes allocated since counting began and not freed.
fn held(region: &Region<'_, System>) -> i64 {
    let stats = region.change();
    stats.bytes_allocated as i64 - stats.bytes_deallocated as i64
}

/// Both tests count the same bytes.
static COUNTS: Mutex<()> = Mutex::new(());

#[test]
fn many_steps_do_not_grow_and_nothing_is_left() {
    stays_as_large(20_000);
}

#[test]
#[ignore = "takes minutes: `cargo test --release -p ilon-c --test growth -- --ignored`"]
fn a_million_steps_do_not_grow_and_nothing_is_left() {
    stays_as_large(1_000_000);
}

fn stays_as_large(steps: u32) {
    let _alone = COUNTS.lock().unwrap();
    // What is allocated once stays: schemas, thread pools, tables.
    let first = load();
    drive(first, 1000);
    assert_eq!(ilon_plant_free(first), IlonStatus::Ok);
    let region = Region::new(COUNTED);
    let plant = load();
    drive(plant, 1000);
    let early = held(&region);
    drive(plant, steps);
    let late = held(&region);
    // Lists reach their largest size within the first thousand steps, except for a few more
    // contacts at once.
    println!("{early} bytes after 1000 steps, {late} after {steps} more");
    assert!(
        late - early < 16 << 10,
        "it grew by {} bytes in {steps} steps",
        late - early
    );
    assert_eq!(ilon_plant_free(plant), IlonStatus::Ok);
    let left = held(&region);
    assert!(left < 16 << 10, "{left} bytes are left");
}
