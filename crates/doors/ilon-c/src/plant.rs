//! The functions that C calls. What they do is a [`Plant`]'s; here they are counted, looked at and locked.
//!
//! # Safety
//! Of all functions here: a pointer that is not null points at as much memory as the call says, which nobody else writes to while the call
//! lasts. Texts end with a zero. Everything else that may be wrong with an argument is a code.

#![allow(
    unsafe_code,
    reason = "what C calls has a plain name and takes pointers"
)]
#![allow(
    clippy::missing_safety_doc,
    reason = "one rule holds for all, and stands above"
)]

use std::ffi::{CStr, c_char};

use ilon_sim::{Error, Plant, Scenario, Snapshot, WheelCommand};

use crate::border::{array, fill, put, put_text, text, triple};
use crate::state::{IlonAbout, IlonEnergies, IlonJoint, IlonPose, IlonState, IlonWheel};
use crate::status::{Fault, IlonStatus, guarded, on_own_stack};
use crate::table::Table;

/// Grows whenever a program that was built with an older header would go wrong.
pub const ILON_ABI_VERSION: u32 = 1;

/// A simulated robot in its world. 0 is none.
pub type IlonPlant = u64;

/// A plant as it was at one moment. 0 is none.
pub type IlonSnapshot = u64;

static PLANTS: Table<Plant> = Table::new(1, "plant");
static SNAPSHOTS: Table<Snapshot> = Table::new(2, "snapshot");

/// Does something with a plant.
fn with(plant: IlonPlant, act: impl FnOnce(&mut Plant) -> Result<(), Fault>) -> IlonStatus {
    guarded(|| PLANTS.with(plant, act))
}

/// Reads a scenario, puts its robot into the world, and its handle where the caller wants it.
unsafe fn take_in(
    read: impl FnOnce() -> Result<Scenario, Error> + Send,
    plant: *mut IlonPlant,
) -> Result<(), Fault> {
    let built = on_own_stack(|| Plant::of_scenario(&read()?))?;
    // Whatever is wrong here is wrong with a file.
    let built = built.map_err(|error| Fault {
        status: IlonStatus::Scenario,
        ..error.into()
    });
    let handle = PLANTS.insert(built?);
    // SAFETY: the caller of the exported function vouches for the pointer.
    unsafe { put(plant, "plant", handle) }.inspect_err(|_| {
        let _ = PLANTS.remove(handle);
    })
}

/// The version of the functions and structs of this library, to be compared with `ILON_ABI_VERSION` of the header.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_abi_version() -> u32 {
    ILON_ABI_VERSION
}

/// The version of ilon, such as "0.1.0". Never null.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => c"",
        };
    VERSION.as_ptr()
}

/// Loads a scenario, a file in TOML, and stands its robot at the start, at rest.
///
/// On success the handle is in `plant`; end it with `ilon_plant_free`. Whatever moves the robot in the scenario is not looked at: it is driven
/// by the advances alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_load(path: *const c_char, plant: *mut IlonPlant) -> IlonStatus {
    guarded(|| {
        // SAFETY: the caller vouches for text and handle.
        unsafe {
            let path = text(path, "path")?;
            take_in(|| Scenario::load(path), plant)
        }
    })
}

/// Like `ilon_plant_load`, of a scenario's text. Its relative paths start from `folder`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_parse(
    toml: *const c_char,
    folder: *const c_char,
    plant: *mut IlonPlant,
) -> IlonStatus {
    guarded(|| {
        // SAFETY: the caller vouches for texts and handle.
        unsafe {
            let (toml, folder) = (text(toml, "toml")?, text(folder, "folder")?);
            take_in(|| Scenario::from_toml(toml, "scenario", folder), plant)
        }
    })
}

/// Ends a plant. Its handle is refused from now on; snapshots of it go on.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_plant_free(plant: IlonPlant) -> IlonStatus {
    guarded(|| PLANTS.remove(plant))
}

/// What stays as it is while the plant lives: counts, periods, limits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_about(plant: IlonPlant, about: *mut IlonAbout) -> IlonStatus {
    // SAFETY: the caller vouches for the pointer.
    with(plant, |held| unsafe {
        put(about, "about", IlonAbout::of(held))
    })
}

/// The name of a wheel's joint, with a closing zero, into a buffer of `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_wheel_name(
    plant: IlonPlant,
    wheel: usize,
    buffer: *mut c_char,
    size: usize,
) -> IlonStatus {
    with(plant, |held| {
        let wheels = &held.robot().wheels;
        let Some(wheel) = wheels.get(wheel) else {
            let count = wheels.len();
            return Err(Fault::new(
                IlonStatus::Count,
                format!("there is no wheel {wheel}: the robot has {count}, counted from 0"),
            ));
        };
        // SAFETY: the caller vouches for the buffer.
        unsafe { put_text(buffer, size, "buffer", &wheel.name) }
    })
}

/// Begins anew, at rest: time zero, noise from `seed`, the robot at `pose`, or where that is null at the scenario's start. Wrench, payload and
/// grip end, and friction is the scenario's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_reset(
    plant: IlonPlant,
    seed: u64,
    pose: *const IlonPose,
) -> IlonStatus {
    with(plant, |held| {
        let start = held.resolved().start();
        // SAFETY: the caller vouches for the pointer.
        let given = unsafe { array(pose, usize::from(!pose.is_null()), "pose") }?;
        let pose = given.first().map_or(start, |pose| (*pose).into());
        Ok(held.reset(seed, pose)?)
    })
}

/// Lets the wheel loops follow rates in rad/s, one a wheel, for a period in seconds; with sampled wheel loops a whole
/// number of physics steps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_advance_rates(
    plant: IlonPlant,
    rates_rad_s: *const f64,
    count: usize,
    period_s: f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller vouches for the array.
        let rates_rad_s = unsafe { wheels(held, rates_rad_s, count, "rates_rad_s") }?;
        held.advance(WheelCommand::Rates(rates_rad_s), period_s)?;
        Ok(())
    })
}

/// Lets the motors put torques in N m on the wheels, one a wheel and within their limits, for a period in seconds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_advance_torques(
    plant: IlonPlant,
    torques_n_m: *const f64,
    count: usize,
    period_s: f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller vouches for the array.
        let torques_n_m = unsafe { wheels(held, torques_n_m, count, "torques_n_m") }?;
        held.advance(WheelCommand::Torques(torques_n_m), period_s)?;
        Ok(())
    })
}

/// One number a wheel.
unsafe fn wheels<'a>(
    held: &Plant,
    at: *const f64,
    count: usize,
    name: &str,
) -> Result<&'a [f64], Fault> {
    let wanted = held.robot().wheels.len();
    if count != wanted {
        return Err(Fault::new(
            IlonStatus::Count,
            format!("`{name}` has {count} elements, and the robot {wanted} wheels"),
        ));
    }
    // SAFETY: the caller of the exported function vouches for the array.
    unsafe { array(at, count, name) }
}

/// The robot as a whole, as it really is now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_state(plant: IlonPlant, state: *mut IlonState) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller vouches for the pointer.
        unsafe { put(state, "state", IlonState::of(held)) }
    })
}

/// Its wheels with their contacts; `count` is that of `IlonAbout`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_wheels(
    plant: IlonPlant,
    wheels: *mut IlonWheel,
    count: usize,
) -> IlonStatus {
    with(plant, |held| {
        let all = 0..held.robot().wheels.len();
        let all = all.map(|wheel| IlonWheel::of(held, wheel));
        // SAFETY: the caller vouches for the array.
        unsafe { fill(wheels, count, "wheels", all) }
    })
}

/// Its joints between bodies; `count` is that of `IlonAbout`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_joints(
    plant: IlonPlant,
    joints: *mut IlonJoint,
    count: usize,
) -> IlonStatus {
    with(plant, |held| {
        let all = 0..held.robot().joints.len();
        // SAFETY: the caller vouches for the array.
        unsafe {
            fill(
                joints,
                count,
                "joints",
                all.map(|joint| IlonJoint::of(held, joint)),
            )
        }
    })
}

/// Where energy is, and where it went.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_energies(
    plant: IlonPlant,
    energies: *mut IlonEnergies,
) -> IlonStatus {
    // SAFETY: the caller vouches for the pointer.
    with(plant, |held| unsafe {
        put(energies, "energies", IlonEnergies::of(held))
    })
}

/// What the robot's sensors say now, with noise, delay and faults: its pose, and the rates in rad/s and angles in rad of its wheels. Any of the
/// three may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_observe(
    plant: IlonPlant,
    pose: *mut IlonPose,
    rates_rad_s: *mut f64,
    angles_rad: *mut f64,
    count: usize,
) -> IlonStatus {
    with(plant, |held| {
        let seen = held.observe();
        // SAFETY: the caller vouches for pointer and arrays.
        unsafe {
            if !pose.is_null() {
                put(pose, "pose", seen.pose.into())?;
            }
            let lists = [
                (rates_rad_s, "rates_rad_s", &seen.wheel_rates_rad_s),
                (angles_rad, "angles_rad", &seen.wheel_angles_rad),
            ];
            for (at, name, values) in lists.into_iter().filter(|(at, ..)| !at.is_null()) {
                fill(at, count, name, values.iter().copied())?;
            }
        }
        Ok(())
    })
}

/// The wheel rates in rad/s with which a robot whose wheels do not slip has a twist: vx and vy in m/s and omega in rad/s, in the body frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_rates_for_twist(
    plant: IlonPlant,
    twist: *const f64,
    rates_rad_s: *mut f64,
    count: usize,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller vouches for three numbers.
        let twist = unsafe { array(twist, 3, "twist") }?;
        if let Some(wild) = twist.iter().find(|number| !number.is_finite()) {
            return Err(Fault::new(
                IlonStatus::Value,
                format!("`twist` holds {wild}"),
            ));
        }
        let twist = ilon_sim::robot::Twist::new(twist[0], twist[1], twist[2]);
        let mut rates = vec![0.0; held.robot().wheels.len()];
        held.kinematics().wheel_rates(twist, &mut rates);
        // SAFETY: the caller vouches for the array.
        unsafe { fill(rates_rad_s, count, "rates_rad_s", rates.into_iter()) }
    })
}

/// Lets a force in N and a moment in N m act on the chassis from now on, both in the world frame: three numbers each, or null for none. The
/// force acts at a place in the body frame in metres, or where that is null at the chassis's centre of mass. They act until the next call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_set_wrench(
    plant: IlonPlant,
    force_in_world_n: *const f64,
    moment_in_world_n_m: *const f64,
    place_in_body_m: *const f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller vouches for three numbers each.
        let (force, moment, place) = unsafe {
            (
                triple(force_in_world_n, "force_in_world_n")?,
                triple(moment_in_world_n_m, "moment_in_world_n_m")?,
                triple(place_in_body_m, "place_in_body_m")?,
            )
        };
        Ok(held.set_wrench(force.unwrap_or_default(), moment.unwrap_or_default(), place)?)
    })
}

/// Puts a mass in kg on the robot, in place of the one put there before; 0 takes it off. It lies at a place in the body frame in metres, or
/// where that is null at the chassis's centre of mass.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_set_payload(
    plant: IlonPlant,
    mass_kg: f64,
    place_in_body_m: *const f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller vouches for three numbers.
        let place = unsafe { triple(place_in_body_m, "place_in_body_m") }?;
        Ok(held.carry_at(mass_kg, place)?)
    })
}

/// Changes Coulomb's coefficient of friction of the floor from now on, but on its patches.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_plant_set_friction(plant: IlonPlant, friction: f64) -> IlonStatus {
    with(plant, |held| Ok(held.set_friction(friction)?))
}

/// Lets the ground lean from now on: gravity pulls along a direction in the world frame, three numbers; 0, 0, -1 is level ground.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_set_down(
    plant: IlonPlant,
    down_in_world: *const f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller vouches for three numbers.
        let down = unsafe { array(down_in_world, 3, "down_in_world") }?;
        Ok(held.set_down([down[0], down[1], down[2]])?)
    })
}

/// Lets the chassis bear from now on the articulated-body inertia of what your program moves, beside a wrench of what that puts on the chassis where
/// it is not accelerated: 36 numbers, row by row, linear at the body frame's origin before angular, along the world's axes, in kg, kg m and
/// kg m^2. Both engines then meet without a delay, whatever weighs more. All zeros end it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_set_articulated_inertia(
    plant: IlonPlant,
    inertia: *const f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller vouches for 36 numbers.
        let numbers = unsafe { array(inertia, 36, "inertia") }?;
        let rows =
            std::array::from_fn(|row| std::array::from_fn(|column| numbers[6 * row + column]));
        Ok(held.set_articulated_inertia(&rows)?)
    })
}

/// Lets the rollers of a wheel find a share of the ground's friction from now on, whatever lies beneath them; 1 for all of it.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_plant_set_grip(plant: IlonPlant, wheel: usize, share: f64) -> IlonStatus {
    with(plant, |held| Ok(held.set_grip(wheel, share)?))
}

/// The plant as it is now, to come back to. On success the handle is in `snapshot`; end it with `ilon_snapshot_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_snapshot(
    plant: IlonPlant,
    snapshot: *mut IlonSnapshot,
) -> IlonStatus {
    with(plant, |held| {
        let handle = SNAPSHOTS.insert(held.snapshot());
        // SAFETY: the caller vouches for the pointer.
        unsafe { put(snapshot, "snapshot", handle) }.inspect_err(|_| {
            let _ = SNAPSHOTS.remove(handle);
        })
    })
}

/// Goes back to a snapshot of this plant, or of another of the same scenario: from there all is as it was, to the bit.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_plant_restore(plant: IlonPlant, snapshot: IlonSnapshot) -> IlonStatus {
    with(plant, |held| {
        SNAPSHOTS.with(snapshot, |snapshot| Ok(held.restore(snapshot)?))
    })
}

/// Ends a snapshot.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_snapshot_free(snapshot: IlonSnapshot) -> IlonStatus {
    guarded(|| SNAPSHOTS.remove(snapshot))
}
