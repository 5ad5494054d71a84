//! The functions of FMI 3.0 for co-simulation: the same shared library is the binary of an FMU.
//!
//! The behaviour of an instance is in [`ilon_fmi::Instance`]. An `fmi3Instance` and an
//! `fmi3FMUState` are handles, not addresses: a freed one is refused. The reason for a failure is
//! passed to the importer's `logMessage` and to `ilon_last_error`. [`refused`] holds the functions
//! that are not supported, with the reasons.
//!
//! # Safety
//! As for [`crate::plant`].

#![allow(
    unsafe_code,
    reason = "what an importer calls has a plain name and takes pointers"
)]
#![allow(
    clippy::missing_safety_doc,
    reason = "one rule holds for all, and stands above"
)]
#![allow(non_snake_case, reason = "names of the standard")]

pub mod refused;

use std::ffi::{c_char, c_void};
use std::path::Path;

use ilon_fmi::{Instance, Value};
use ilon_sim::Error;

use crate::border::{array, fill, put, text};
use crate::status::{Fault, IlonStatus, guarded, last_words, on_own_stack};
use crate::table::Table;

/// The result of a call, as FMI 3.0 defines it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fmi3Status {
    /// Success.
    Ok = 0,
    /// Success with a remark. Never returned.
    Warning = 1,
    /// Not done, but the instance can continue. Never returned.
    Discard = 2,
    /// Not done.
    Error = 3,
    /// The library cannot continue.
    Fatal = 4,
}

/// The importer's log callback: its environment, a status, a category, the message.
pub type LogMessage =
    Option<unsafe extern "C" fn(*mut c_void, Fmi3Status, *const c_char, *const c_char)>;

/// An instance and its importer's log callback.
struct Slave {
    instance: Instance,
    log: LogMessage,
    /// The importer's address, which is passed back to it and never dereferenced.
    environment: usize,
}

static INSTANCES: Table<Slave> = Table::new(3, "FMU instance");
static STATES: Table<Instance> = Table::new(4, "FMU state");

/// An instance or a state in FMI's types: a handle cast to an address.
type Opaque = *mut c_void;

fn handle(opaque: Opaque) -> u64 {
    opaque.addr() as u64
}

fn opaque(handle: u64) -> Opaque {
    std::ptr::without_provenance_mut(handle as usize)
}

/// Runs `act` on an instance and logs its error to the importer.
fn with(instance: Opaque, act: impl FnOnce(&mut Slave) -> Result<(), Fault>) -> Fmi3Status {
    let status = guarded(|| INSTANCES.with(handle(instance), act));
    if status == IlonStatus::Ok {
        return Fmi3Status::Ok;
    }
    // An instance that is unknown or in use has no log. Called outside the lock, as the importer
    // may call back.
    let callback = INSTANCES.with(handle(instance), |slave| Ok((slave.log, slave.environment)));
    if let Ok((log, environment)) = callback {
        tell(log, environment);
    }
    match status {
        IlonStatus::Internal => Fmi3Status::Fatal,
        _ => Fmi3Status::Error,
    }
}

/// Passes the last error of this thread to the importer.
fn tell(log: LogMessage, environment: usize) {
    let Some(log) = log else { return };
    let words = last_words();
    let environment = std::ptr::with_exposed_provenance_mut(environment);
    // SAFETY: the importer passed both together for this call; the texts live until it returns.
    unsafe {
        log(
            environment,
            Fmi3Status::Error,
            c"logStatusError".as_ptr(),
            words.as_ptr(),
        )
    };
}

/// Runs `act` on the simulation of an instance.
fn with_instance(
    instance: Opaque,
    act: impl FnOnce(&mut Instance) -> Result<(), Error>,
) -> Fmi3Status {
    with(instance, |slave| Ok(act(&mut slave.instance)?))
}

/// The version of FMI: "3.0".
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Accepted without effect: only errors are logged, and always.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetDebugLogging(
    instance: Opaque,
    _on: bool,
    _count: usize,
    _categories: *const *const c_char,
) -> Fmi3Status {
    with(instance, |_| Ok(()))
}

/// Creates an instance from the unpacked resources of an FMU. On failure it returns null and logs
/// the error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _events: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _intermediate_count: usize,
    environment: *mut c_void,
    log: LogMessage,
    _update: *const c_void,
) -> Opaque {
    let mut made = std::ptr::null_mut();
    let environment = environment.expose_provenance();
    let status = guarded(|| {
        // SAFETY: the caller guarantees both texts.
        let (token, resources) = unsafe {
            (
                text(token, "instantiationToken")?,
                text(resources, "resourcePath")?,
            )
        };
        let instance = on_own_stack(|| Instance::open(Path::new(resources), token))??;
        made = opaque(INSTANCES.insert(Slave {
            instance,
            log,
            environment,
        }));
        Ok(())
    });
    if status != IlonStatus::Ok {
        tell(log, environment);
    }
    made
}

/// Frees an instance. An unknown handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3FreeInstance(instance: Opaque) {
    guarded(|| INSTANCES.remove(handle(instance)));
}

/// Begins initialisation. Tolerance and stop time are ignored.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3EnterInitializationMode(
    instance: Opaque,
    _has_tolerance: bool,
    _tolerance: f64,
    start_s: f64,
    _has_stop: bool,
    _stop_s: f64,
) -> Fmi3Status {
    with_instance(instance, |instance| instance.enter_initialization(start_s))
}

/// Ends initialisation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3ExitInitializationMode(instance: Opaque) -> Fmi3Status {
    with_instance(instance, Instance::exit_initialization)
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3Terminate(instance: Opaque) -> Fmi3Status {
    with_instance(instance, Instance::terminate)
}

/// Resets an instance to its state after instantiation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3Reset(instance: Opaque) -> Fmi3Status {
    with_instance(instance, Instance::reset)
}

/// Advances by one step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: Opaque,
    at_s: f64,
    step_s: f64,
    _is_final: bool,
    event: *mut bool,
    terminate: *mut bool,
    early_return: *mut bool,
    last_s: *mut f64,
) -> Fmi3Status {
    let mut now_s = f64::NAN;
    let status = with_instance(instance, |instance| {
        let stepped = instance.step(at_s, step_s);
        now_s = instance.time_s();
        stepped
    });
    // In the importer's arithmetic, so that the next step begins exactly where this one ends.
    let reached_s = if status == Fmi3Status::Ok {
        at_s + step_s
    } else {
        now_s
    };
    // SAFETY: the caller guarantees the non-null pointers.
    unsafe {
        for flag in [event, terminate, early_return] {
            if !flag.is_null() && flag.is_aligned() {
                flag.write(false);
            }
        }
        if !last_s.is_null() && last_s.is_aligned() {
            last_s.write(reached_s);
        }
    }
    status
}

/// Reads variables of one type; `take` returns the value of that type, or `None` for another type.
unsafe fn get<T>(
    instance: Opaque,
    (references, count): (*const u32, usize),
    (values, value_count): (*mut T, usize),
    take: impl Fn(Value) -> Option<T>,
) -> Fmi3Status {
    with(instance, |slave| {
        // SAFETY: the caller guarantees the array.
        let references = unsafe { array(references, count, "valueReferences") }?;
        let mut read = Vec::with_capacity(references.len());
        for reference in references {
            let value = take(slave.instance.get(*reference)?);
            read.push(value.ok_or_else(|| of_another_type(*reference))?);
        }
        // SAFETY: the caller guarantees the array.
        unsafe { fill(values, value_count, "values", read.into_iter()) }
    })
}

fn of_another_type(reference: u32) -> Fault {
    Fault::new(
        IlonStatus::Value,
        format!("the variable {reference} is of another type"),
    )
}

/// Sets variables of one type, up to the first that is refused.
unsafe fn set<T: Copy>(
    instance: Opaque,
    (references, count): (*const u32, usize),
    (values, value_count): (*const T, usize),
    make: impl Fn(T) -> Value,
) -> Fmi3Status {
    with(instance, |slave| {
        // SAFETY: the caller guarantees both arrays.
        let (references, values) = unsafe {
            (
                array(references, count, "valueReferences")?,
                array(values, value_count, "values")?,
            )
        };
        if references.len() != values.len() {
            return Err(Fault::new(
                IlonStatus::Count,
                format!(
                    "{} references have {} values",
                    references.len(),
                    values.len()
                ),
            ));
        }
        for (reference, value) in references.iter().zip(values) {
            slave.instance.set(*reference, make(*value))?;
        }
        Ok(())
    })
}

/// Defines the functions that read and set one type.
macro_rules! of_type {
    ($get:ident, $set:ident, $type:ty, $variant:ident, $take:expr, $make:expr) => {
        /// Reads variables of this type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: Opaque,
            references: *const u32,
            count: usize,
            values: *mut $type,
            value_count: usize,
        ) -> Fmi3Status {
            let take = |value| match value {
                Value::$variant(value) => Some($take(value)),
                _ => None,
            };
            // SAFETY: the caller guarantees both arrays.
            unsafe { get(instance, (references, count), (values, value_count), take) }
        }

        /// Sets variables of this type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: Opaque,
            references: *const u32,
            count: usize,
            values: *const $type,
            value_count: usize,
        ) -> Fmi3Status {
            let make = |value| Value::$variant($make(value));
            // SAFETY: the caller guarantees both arrays.
            unsafe { set(instance, (references, count), (values, value_count), make) }
        }
    };
}

of_type!(
    fmi3GetFloat64,
    fmi3SetFloat64,
    f64,
    Real,
    f64::from,
    f64::from
);
of_type!(fmi3GetInt64, fmi3SetInt64, i64, Whole, i64::from, i64::from);
// C may write any byte into a bool; every value except 0 is true.
of_type!(
    fmi3GetBoolean,
    fmi3SetBoolean,
    u8,
    Flag,
    u8::from,
    |value| value != 0
);

/// Saves the state of an instance into `state`, or into a new state if that is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: Opaque, state: *mut Opaque) -> Fmi3Status {
    with(instance, |slave| {
        let copy = slave.instance.clone();
        // SAFETY: the caller guarantees a pointer to an initialised value.
        let given = unsafe { array(state.cast_const(), 1, "FMUState") }?[0];
        if !given.is_null() {
            return STATES.with(handle(given), |state| {
                *state = copy;
                Ok(())
            });
        }
        // SAFETY: as above.
        unsafe { put(state, "FMUState", opaque(STATES.insert(copy))) }
    })
}

/// Restores a state; the simulation then continues bit-identically.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetFMUState(instance: Opaque, state: Opaque) -> Fmi3Status {
    with(instance, |slave| {
        STATES.with(handle(state), |state| {
            slave.instance.clone_from(state);
            Ok(())
        })
    })
}

/// Frees a state and sets it to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: Opaque, state: *mut Opaque) -> Fmi3Status {
    with(instance, |_| {
        if state.is_null() {
            return Ok(());
        }
        // SAFETY: the caller guarantees a pointer to an initialised value.
        let given = unsafe { array(state.cast_const(), 1, "FMUState") }?[0];
        if given.is_null() {
            return Ok(());
        }
        STATES.remove(handle(given))?;
        // SAFETY: as above.
        unsafe { put(state, "FMUState", std::ptr::null_mut()) }
    })
}

/// Refuses a function that this FMU does not support; for [`refused`].
fn refuse(instance: Opaque, name: &str) -> Fmi3Status {
    with(instance, |_| {
        let why =
            format!("{name} is not to be had: see modelDescription.xml for what this FMU can");
        Err(Fault::new(IlonStatus::Value, why))
    })
}

/// Lets an exporter check that the library has its own version.
#[used]
static MARK: &str = ilon_fmi::MARK;
