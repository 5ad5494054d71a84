//! The functions that C calls. They look up and lock the plant, check the arguments and call
//! [`Plant`].
//!
//! # Safety
//! For all functions here: a non-null pointer points at as much memory as the function requires,
//! which no other thread writes to during the call. Texts end with a zero. Every other invalid
//! argument returns a status code.

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

/// Increases whenever a program built with an older header would no longer work.
pub const ILON_ABI_VERSION: u32 = 1;

/// A simulated robot in its world. 0 is none.
pub type IlonPlant = u64;

/// The saved state of a plant. 0 is none.
pub type IlonSnapshot = u64;

static PLANTS: Table<Plant> = Table::new(1, "plant");
static SNAPSHOTS: Table<Snapshot> = Table::new(2, "snapshot");

/// Runs `act` on a plant.
fn with(plant: IlonPlant, act: impl FnOnce(&mut Plant) -> Result<(), Fault>) -> IlonStatus {
    guarded(|| PLANTS.with(plant, act))
}

/// Reads a scenario, builds its plant, and writes its handle to the caller's memory.
unsafe fn take_in(
    read: impl FnOnce() -> Result<Scenario, Error> + Send,
    plant: *mut IlonPlant,
) -> Result<(), Fault> {
    let built = on_own_stack(|| Plant::of_scenario(&read()?))?;
    // An error here comes from the content of a file.
    let built = built.map_err(|error| Fault {
        status: IlonStatus::Scenario,
        ..error.into()
    });
    let handle = PLANTS.insert(built?);
    // SAFETY: the caller of the exported function guarantees the pointer.
    unsafe { put(plant, "plant", handle) }.inspect_err(|_| {
        let _ = PLANTS.remove(handle);
    })
}

/// The version of the functions and structs of this library; compare it with `ILON_ABI_VERSION` of
/// the header.
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

/// Loads a scenario from a TOML file and places its robot at the start, at rest.
///
/// On success the handle is in `plant`; free it with `ilon_plant_free`. What moves the robot in the
/// scenario is ignored: only the advance functions drive it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_load(path: *const c_char, plant: *mut IlonPlant) -> IlonStatus {
    guarded(|| {
        // SAFETY: the caller guarantees the text and the handle.
        unsafe {
            let path = text(path, "path")?;
            take_in(|| Scenario::load(path), plant)
        }
    })
}

/// Like `ilon_plant_load`, but from a scenario's text. Its relative paths start from `folder`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_parse(
    toml: *const c_char,
    folder: *const c_char,
    plant: *mut IlonPlant,
) -> IlonStatus {
    guarded(|| {
        // SAFETY: the caller guarantees the texts and the handle.
        unsafe {
            let (toml, folder) = (text(toml, "toml")?, text(folder, "folder")?);
            take_in(|| Scenario::from_toml(toml, "scenario", folder), plant)
        }
    })
}

/// Frees a plant. Its handle is refused from then on; its snapshots stay valid.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_plant_free(plant: IlonPlant) -> IlonStatus {
    guarded(|| PLANTS.remove(plant))
}

/// The constant properties of a plant: counts, periods, limits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_about(plant: IlonPlant, about: *mut IlonAbout) -> IlonStatus {
    // SAFETY: the caller guarantees the pointer.
    with(plant, |held| unsafe {
        put(about, "about", IlonAbout::of(held))
    })
}

/// The name of a wheel's joint, with a terminating zero, into a buffer of `size` bytes.
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
        // SAFETY: the caller guarantees the buffer.
        unsafe { put_text(buffer, size, "buffer", &wheel.name) }
    })
}

/// Restarts a plant at rest: time zero, noise from `seed`, the robot at `pose`, or at the
/// scenario's start if that is null. Wrench, payload and grip are cleared, and friction is the
/// scenario's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_reset(
    plant: IlonPlant,
    seed: u64,
    pose: *const IlonPose,
) -> IlonStatus {
    with(plant, |held| {
        let start = held.resolved().start();
        // SAFETY: the caller guarantees the pointer.
        let given = unsafe { array(pose, usize::from(!pose.is_null()), "pose") }?;
        let pose = given.first().map_or(start, |pose| (*pose).into());
        Ok(held.reset(seed, pose)?)
    })
}

/// Advances by a period in seconds while the wheel loops follow rates in rad/s, one per wheel. With
/// sampled wheel loops the period must be a whole number of physics steps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_advance_rates(
    plant: IlonPlant,
    rates_rad_s: *const f64,
    count: usize,
    period_s: f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller guarantees the array.
        let rates_rad_s = unsafe { wheels(held, rates_rad_s, count, "rates_rad_s") }?;
        held.advance(WheelCommand::Rates(rates_rad_s), period_s)?;
        Ok(())
    })
}

/// Advances by a period in seconds while the motors apply torques in N m to the wheels, one per
/// wheel and within their limits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_advance_torques(
    plant: IlonPlant,
    torques_n_m: *const f64,
    count: usize,
    period_s: f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller guarantees the array.
        let torques_n_m = unsafe { wheels(held, torques_n_m, count, "torques_n_m") }?;
        held.advance(WheelCommand::Torques(torques_n_m), period_s)?;
        Ok(())
    })
}

/// Reads one number per wheel.
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
    // SAFETY: the caller of the exported function guarantees the array.
    unsafe { array(at, count, name) }
}

/// The true state of the robot as a whole.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_state(plant: IlonPlant, state: *mut IlonState) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller guarantees the pointer.
        unsafe { put(state, "state", IlonState::of(held)) }
    })
}

/// The wheels with their contacts; `count` is that of `IlonAbout`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_wheels(
    plant: IlonPlant,
    wheels: *mut IlonWheel,
    count: usize,
) -> IlonStatus {
    with(plant, |held| {
        let all = 0..held.robot().wheels.len();
        let all = all.map(|wheel| IlonWheel::of(held, wheel));
        // SAFETY: the caller guarantees the array.
        unsafe { fill(wheels, count, "wheels", all) }
    })
}

/// The joints between bodies; `count` is that of `IlonAbout`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_joints(
    plant: IlonPlant,
    joints: *mut IlonJoint,
    count: usize,
) -> IlonStatus {
    with(plant, |held| {
        let all = 0..held.robot().joints.len();
        // SAFETY: the caller guarantees the array.
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

/// Stored energies, and the energy exchanged since the start.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_energies(
    plant: IlonPlant,
    energies: *mut IlonEnergies,
) -> IlonStatus {
    // SAFETY: the caller guarantees the pointer.
    with(plant, |held| unsafe {
        put(energies, "energies", IlonEnergies::of(held))
    })
}

/// The current sensor readings, with noise, delay and faults: the robot's pose, and the rates in
/// rad/s and angles in rad of its wheels. Each of the three pointers may be null.
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
        // SAFETY: the caller guarantees the pointer and the arrays.
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

/// The wheel rates in rad/s at which a robot without wheel slip has a twist: vx and vy in m/s and
/// omega in rad/s, in the body frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_rates_for_twist(
    plant: IlonPlant,
    twist: *const f64,
    rates_rad_s: *mut f64,
    count: usize,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller guarantees three numbers.
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
        // SAFETY: the caller guarantees the array.
        unsafe { fill(rates_rad_s, count, "rates_rad_s", rates.into_iter()) }
    })
}

/// Applies a force in N and a moment in N m to the chassis, both in the world frame: three numbers
/// each, or null for zero. The force acts at a point in the body frame in metres, or at the
/// chassis's centre of mass if that is null. Both act until the next call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_set_wrench(
    plant: IlonPlant,
    force_in_world_n: *const f64,
    moment_in_world_n_m: *const f64,
    place_in_body_m: *const f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller guarantees three numbers each.
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

/// Puts a mass in kg on the robot and replaces the previous one; 0 removes it. Its place is in the
/// body frame in metres, or the chassis's centre of mass if that is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_set_payload(
    plant: IlonPlant,
    mass_kg: f64,
    place_in_body_m: *const f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller guarantees three numbers.
        let place = unsafe { triple(place_in_body_m, "place_in_body_m") }?;
        Ok(held.carry_at(mass_kg, place)?)
    })
}

/// Changes the Coulomb friction coefficient of the floor, except on its patches.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_plant_set_friction(plant: IlonPlant, friction: f64) -> IlonStatus {
    with(plant, |held| Ok(held.set_friction(friction)?))
}

/// Changes the direction of gravity, as on a slope: three numbers in the world frame; 0, 0, -1 is
/// level ground.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_set_down(
    plant: IlonPlant,
    down_in_world: *const f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller guarantees three numbers.
        let down = unsafe { array(down_in_world, 3, "down_in_world") }?;
        Ok(held.set_down([down[0], down[1], down[2]])?)
    })
}

/// Couples the chassis to bodies that your program simulates, by their articulated-body inertia: 36
/// numbers, row by row, linear at the body frame's origin before angular, along the world's axes,
/// in kg, kg m and kg m^2. Set also the wrench that these bodies apply to an unaccelerated chassis.
/// Both engines are then coupled without a delay, whatever the masses. All zeros end the coupling.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_set_articulated_inertia(
    plant: IlonPlant,
    inertia: *const f64,
) -> IlonStatus {
    with(plant, |held| {
        // SAFETY: the caller guarantees 36 numbers.
        let numbers = unsafe { array(inertia, 36, "inertia") }?;
        let rows =
            std::array::from_fn(|row| std::array::from_fn(|column| numbers[6 * row + column]));
        Ok(held.set_articulated_inertia(&rows)?)
    })
}

/// Scales the ground's friction under the rollers of a wheel by a share; 1 for full friction.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_plant_set_grip(plant: IlonPlant, wheel: usize, share: f64) -> IlonStatus {
    with(plant, |held| Ok(held.set_grip(wheel, share)?))
}

/// Saves the state of a plant. On success the handle is in `snapshot`; free it with
/// `ilon_snapshot_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ilon_plant_snapshot(
    plant: IlonPlant,
    snapshot: *mut IlonSnapshot,
) -> IlonStatus {
    with(plant, |held| {
        let handle = SNAPSHOTS.insert(held.snapshot());
        // SAFETY: the caller guarantees the pointer.
        unsafe { put(snapshot, "snapshot", handle) }.inspect_err(|_| {
            let _ = SNAPSHOTS.remove(handle);
        })
    })
}

/// Restores a snapshot of this plant, or of another plant of the same scenario; the simulation then
/// continues bit-identically.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_plant_restore(plant: IlonPlant, snapshot: IlonSnapshot) -> IlonStatus {
    with(plant, |held| {
        SNAPSHOTS.with(snapshot, |snapshot| Ok(held.restore(snapshot)?))
    })
}

/// Frees a snapshot.
#[unsafe(no_mangle)]
pub extern "C" fn ilon_snapshot_free(snapshot: IlonSnapshot) -> IlonStatus {
    guarded(|| SNAPSHOTS.remove(snapshot))
}
