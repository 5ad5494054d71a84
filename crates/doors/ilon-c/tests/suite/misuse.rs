//! Every detectable misuse returns a status code with a message, and changes nothing.

use std::ffi::CString;
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};

use ilon_c::plant::*;
use ilon_c::state::{IlonPose, IlonState, IlonWheel};
use ilon_c::status::IlonStatus;

use crate::support::{Owned, last_error, must, scenario};

fn owned() -> Owned {
    Owned::load(&scenario("mecanum4_lateral.toml"))
}

#[test]
fn bad_commands_are_refused_and_change_nothing() {
    let plant = owned();
    let before = plant.state();
    let period_s = plant.about().control_dt_s;
    let cases: [(&[f64], f64, IlonStatus); 9] = [
        (&[1.0; 3], period_s, IlonStatus::Count),
        (&[1.0; 5], period_s, IlonStatus::Count),
        (&[], period_s, IlonStatus::Count),
        (&[1.0, 1.0, f64::NAN, 1.0], period_s, IlonStatus::Value),
        (&[1.0, f64::INFINITY, 1.0, 1.0], period_s, IlonStatus::Value),
        (&[1.0; 4], 0.0, IlonStatus::Value),
        (&[1.0; 4], -period_s, IlonStatus::Value),
        (&[1.0; 4], f64::NAN, IlonStatus::Value),
        (&[1.0; 4], 1e300, IlonStatus::Value),
    ];
    for (rates, period_s, wanted) in cases {
        assert_eq!(
            plant.advance(rates, period_s),
            wanted,
            "{rates:?} for {period_s}"
        );
        assert!(!last_error().is_empty());
        assert_eq!(plant.state(), before);
    }
    // Null in place of an array, and a count beyond all memory.
    for (at, count, wanted) in [
        (ptr::null(), 4, IlonStatus::Pointer),
        (ptr::dangling(), usize::MAX, IlonStatus::Count),
        (ptr::without_provenance(9), 4, IlonStatus::Pointer),
    ] {
        // SAFETY: a refused array is not read.
        let status = unsafe { ilon_plant_advance_rates(plant.0, at, count, period_s) };
        assert_eq!(status, wanted, "{at:?}, {count}");
    }
}

/// Sampled wheel loops add a reason for times within a step, not for what is no time at all.
#[test]
fn what_is_no_time_is_called_so_whatever_the_wheel_loops_are() {
    for name in ["mecanum4_lateral.toml", "mecanum4_passive_slope.toml"] {
        let plant = Owned::load(&scenario(name));
        for period_s in [0.0, -0.01, f64::NAN, f64::INFINITY, 1e12] {
            assert_eq!(plant.advance(&[1.0; 4], period_s), IlonStatus::Value);
            assert!(last_error().contains("not a time"), "{}", last_error());
        }
    }
    let sampled = Owned::load(&scenario("mecanum4_passive_slope.toml"));
    let within_a_step_s = 0.7 * sampled.about().physics_dt_s;
    assert_eq!(
        sampled.advance(&[1.0; 4], within_a_step_s),
        IlonStatus::Value
    );
    assert!(last_error().contains("act in steps"), "{}", last_error());
}

#[test]
fn bad_disturbances_are_refused_and_change_nothing() {
    let plant = owned();
    assert_eq!(
        plant.wrench([f64::NAN, 0.0, 0.0], [0.0; 3]),
        IlonStatus::Value
    );
    assert_eq!(
        plant.wrench([0.0; 3], [0.0, f64::INFINITY, 0.0]),
        IlonStatus::Value
    );
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        assert_eq!(ilon_plant_set_friction(plant.0, bad), IlonStatus::Value);
        assert_eq!(ilon_plant_set_grip(plant.0, 0, bad), IlonStatus::Value);
        // SAFETY: null is the centre of mass, and the three numbers are locals.
        unsafe {
            assert_eq!(
                ilon_plant_set_payload(plant.0, bad, ptr::null()),
                IlonStatus::Value
            );
            let place = [0.0, f64::NAN, 0.0];
            assert_eq!(
                ilon_plant_set_payload(plant.0, 1.0, place.as_ptr()),
                IlonStatus::Value
            );
            let pose = IlonPose {
                x_m: f64::NAN,
                ..IlonPose::default()
            };
            assert_eq!(
                ilon_plant_reset(plant.0, 0, &raw const pose),
                IlonStatus::Value
            );
        }
    }
    assert_eq!(ilon_plant_set_grip(plant.0, 4, 1.0), IlonStatus::Value);
    // Invalid directions and inertias, and null.
    for (down, inertia) in [
        ([0.0; 3], [-1.0; 36]),
        ([0.0, 0.0, f64::NAN], [f64::NAN; 36]),
    ] {
        // SAFETY: the arrays are locals of the required length, and null is not read.
        unsafe {
            let leans = ilon_plant_set_down(plant.0, down.as_ptr());
            assert_eq!(leans, IlonStatus::Value);
            let bears = ilon_plant_set_articulated_inertia(plant.0, inertia.as_ptr());
            assert_eq!(bears, IlonStatus::Value);
            let leans = ilon_plant_set_down(plant.0, ptr::null());
            assert_eq!(leans, IlonStatus::Pointer);
            let bears = ilon_plant_set_articulated_inertia(plant.0, ptr::null());
            assert_eq!(bears, IlonStatus::Pointer);
        }
    }
    let fresh = owned();
    must(plant.advance(&[2.0; 4], 0.1));
    must(fresh.advance(&[2.0; 4], 0.1));
    assert_eq!(plant.state(), fresh.state());
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let plant = owned();
    let mut wheels = [IlonWheel::default(); 8];
    let mut name = [0; 64];
    // SAFETY: arrays and buffer are locals, at least as long as stated.
    unsafe {
        for count in [0, 3, 5] {
            let status = ilon_plant_wheels(plant.0, wheels.as_mut_ptr(), count);
            assert_eq!(status, IlonStatus::Count);
        }
        assert_eq!(
            ilon_plant_wheels(plant.0, ptr::null_mut(), 4),
            IlonStatus::Pointer
        );
        assert_eq!(wheels, [IlonWheel::default(); 8], "nothing was written");
        let short = ilon_plant_wheel_name(plant.0, 0, name.as_mut_ptr(), 4);
        assert_eq!(short, IlonStatus::Count);
        let no_wheel = ilon_plant_wheel_name(plant.0, 4, name.as_mut_ptr(), 64);
        assert_eq!(no_wheel, IlonStatus::Count);
        must(ilon_plant_joints(plant.0, ptr::null_mut(), 0));
    }
}

#[test]
fn texts_and_files_that_make_no_sense_are_refused_in_words() {
    let mut plant = 7;
    // SAFETY: texts and handle are locals; null is refused.
    unsafe {
        let load = |path: *const _, plant| ilon_plant_load(path, plant);
        assert_eq!(load(ptr::null(), &raw mut plant), IlonStatus::Pointer);
        assert_eq!(load(c"\xff".as_ptr(), &raw mut plant), IlonStatus::Pointer);
        assert_eq!(
            load(c"nowhere.toml".as_ptr(), &raw mut plant),
            IlonStatus::Scenario
        );
        assert!(last_error().contains("nowhere.toml"), "{}", last_error());
        let parse =
            |text: &std::ffi::CStr, plant| ilon_plant_parse(text.as_ptr(), c".".as_ptr(), plant);
        assert_eq!(parse(c"robot = 3", &raw mut plant), IlonStatus::Scenario);
        let lost = c"robot.file = \"none.urdf\"\ntwist = {}";
        assert_eq!(parse(lost, &raw mut plant), IlonStatus::Scenario);
    }
    assert_eq!(plant, 7, "nothing was written");
}

#[test]
fn handles_that_were_freed_or_are_of_another_kind_are_refused() {
    let plant = owned();
    let (mut snapshot, mut other) = (0, 0);
    let mut state = IlonState::default();
    // SAFETY: the handles are locals.
    unsafe {
        must(ilon_plant_snapshot(plant.0, &raw mut snapshot));
        must(ilon_plant_snapshot(plant.0, &raw mut other));
        assert_eq!(
            ilon_plant_state(snapshot, &raw mut state),
            IlonStatus::Handle
        );
        assert_eq!(ilon_plant_snapshot(0, &raw mut other), IlonStatus::Handle);
        assert_eq!(
            ilon_plant_snapshot(plant.0, ptr::null_mut()),
            IlonStatus::Pointer
        );
    }
    assert_eq!(ilon_plant_restore(plant.0, plant.0), IlonStatus::Handle);
    must(ilon_snapshot_free(snapshot));
    assert_eq!(ilon_snapshot_free(snapshot), IlonStatus::Handle);
    assert_eq!(ilon_plant_restore(plant.0, snapshot), IlonStatus::Handle);
    must(ilon_plant_restore(plant.0, other));
    let foreign = Owned::load(&scenario("volksbot_forward.toml"));
    assert_eq!(ilon_plant_restore(foreign.0, other), IlonStatus::Value);
    must(ilon_snapshot_free(other));
}

/// While one thread advances a plant, a second one is refused; the first thread and another plant
/// continue undisturbed.
#[test]
fn two_threads_on_one_plant_are_a_code_and_on_two_plants_go_on() {
    let (shared, alone) = (owned(), owned());
    let (done, busy) = (AtomicBool::new(false), AtomicBool::new(false));
    let mut advances = 0;
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                let mut state = IlonState::default();
                // SAFETY: the state is a local.
                match unsafe { ilon_plant_state(shared.0, &raw mut state) } {
                    IlonStatus::Busy => busy.store(true, Ordering::Relaxed),
                    status => must(status),
                }
            }
        });
        // Until the second thread is refused; given up after an hour of simulated time.
        while advances < 20 || !busy.load(Ordering::Relaxed) && advances < 180_000 {
            // The second thread may hold the plant for a moment.
            while shared.advance(&[2.0; 4], 0.02) == IlonStatus::Busy {}
            advances += 1;
        }
        done.store(true, Ordering::Relaxed);
    });
    assert!(busy.into_inner());
    (0..advances).for_each(|_| must(alone.advance(&[2.0; 4], 0.02)));
    assert_eq!(shared.state(), alone.state());
}

/// Threads of some systems have small stacks. The header asks for 256 kB; a third of that is left
/// for who calls. Nested files do not depend on it.
#[test]
fn a_thread_with_a_small_stack_may_call() {
    let nested = format!("x = {}{}", "[".repeat(1000), "]".repeat(1000));
    let calls = move || {
        for name in [
            "mecanum4_lateral",
            "mecanum4_arm_hits_box",
            "mecanum4_rough_class",
        ] {
            let plant = Owned::load(&scenario(&format!("{name}.toml")));
            let period_s = plant.about().control_dt_s;
            for _ in 0..20 {
                must(plant.advance(&[1.0; 4], period_s));
            }
        }
        let (toml, folder) = (CString::new(nested).unwrap(), c".");
        let mut other = 0;
        // SAFETY: texts and handle live here.
        let status = unsafe { ilon_plant_parse(toml.as_ptr(), folder.as_ptr(), &raw mut other) };
        assert_eq!(status, IlonStatus::Scenario, "{}", last_error());
    };
    let thread = std::thread::Builder::new().stack_size(170 << 10);
    thread.spawn(calls).unwrap().join().unwrap();
}
