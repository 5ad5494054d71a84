//! The functions of FMI 3.0 for co-simulation: the same shared library is the binary of an FMU.
//!
//! What an instance does is [`ilon_fmi::Instance`]'s. An `fmi3Instance` and an `fmi3FMUState` are handles, not addresses: what was freed is
//! refused. Why a call failed is given to the importer's `logMessage`, and to `ilon_last_error`. Which functions are not to be had, and why, is
//! said in [`refused`].
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

/// How a call ended, by FMI 3.0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fmi3Status {
    /// It was done.
    Ok = 0,
    /// It was done, with a remark. Not given.
    Warning = 1,
    /// It was not done, and the instance goes on. Not given.
    Discard = 2,
    /// It was not done.
    Error = 3,
    /// The library cannot go on.
    Fatal = 4,
}

/// The importer's log callback: its own environment, a status, a category, the message.
pub type LogMessage =
    Option<unsafe extern "C" fn(*mut c_void, Fmi3Status, *const c_char, *const c_char)>;

/// An instance, and where its errors are logged.
struct Slave {
    instance: Instance,
    log: LogMessage,
    /// The importer's own address, which is handed back to it and never looked at.
    environment: usize,
}

static INSTANCES: Table<Slave> = Table::new(3, "FMU instance");
static STATES: Table<Instance> = Table::new(4, "FMU state");

/// What FMI calls an instance or a state: here the number of a handle in the clothes of an address.
type Opaque = *mut c_void;

fn handle(opaque: Opaque) -> u64 {
    opaque.addr() as u64
}

fn opaque(handle: u64) -> Opaque {
    std::ptr::without_provenance_mut(handle as usize)
}

/// Does something with an instance, and logs to the importer what went wrong.
fn with(instance: Opaque, act: impl FnOnce(&mut Slave) -> Result<(), Fault>) -> Fmi3Status {
    let status = guarded(|| INSTANCES.with(handle(instance), act));
    if status == IlonStatus::Ok {
        return Fmi3Status::Ok;
    }
    // An instance that is unknown or in use has no log. Outside of the lock, for an importer may call back.
    let callback = INSTANCES.with(handle(instance), |slave| Ok((slave.log, slave.environment)));
    if let Ok((log, environment)) = callback {
        tell(log, environment);
    }
    match status {
        IlonStatus::Internal => Fmi3Status::Fatal,
        _ => Fmi3Status::Error,
    }
}

/// Tells the importer what the last failure of this thread was.
fn tell(log: LogMessage, environment: usize) {
    let Some(log) = log else { return };
    let words = last_words();
    let environment = std::ptr::with_exposed_provenance_mut(environment);
    // SAFETY: the importer gave both together, for this; the texts live until it returns.
    unsafe {
        log(
            environment,
            Fmi3Status::Error,
            c"logStatusError".as_ptr(),
            words.as_ptr(),
        )
    };
}

/// Does something with an instance of the simulation.
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

/// Errors are always logged, and nothing else is.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetDebugLogging(
    instance: Opaque,
    _on: bool,
    _count: usize,
    _categories: *const *const c_char,
) -> Fmi3Status {
    with(instance, |_| Ok(()))
}

/// Makes an instance of the FMU whose resources were unpacked; null, and a message, where it cannot be.
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
        // SAFETY: the caller vouches for both texts.
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

/// Ends an instance. A handle that is unknown is left alone.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3FreeInstance(instance: Opaque) {
    guarded(|| INSTANCES.remove(handle(instance)));
}

/// Begins to initialise. Neither tolerance nor stop time is of use.
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

/// Ends the initialisation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3ExitInitializationMode(instance: Opaque) -> Fmi3Status {
    with_instance(instance, Instance::exit_initialization)
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3Terminate(instance: Opaque) -> Fmi3Status {
    with_instance(instance, Instance::terminate)
}

/// Goes back to how the instance was made.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3Reset(instance: Opaque) -> Fmi3Status {
    with_instance(instance, Instance::reset)
}

/// Goes on by a step.
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
    // By the importer's own sum, so that the next step begins where this one ended.
    let reached_s = if status == Fmi3Status::Ok {
        at_s + step_s
    } else {
        now_s
    };
    // SAFETY: the caller vouches for those that are not null.
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

/// Reads variables of one type; `take` gives the value of that type, or `None` of another.
unsafe fn get<T>(
    instance: Opaque,
    (references, count): (*const u32, usize),
    (values, value_count): (*mut T, usize),
    take: impl Fn(Value) -> Option<T>,
) -> Fmi3Status {
    with(instance, |slave| {
        // SAFETY: the caller vouches for the array.
        let references = unsafe { array(references, count, "valueReferences") }?;
        let mut read = Vec::with_capacity(references.len());
        for reference in references {
            let value = take(slave.instance.get(*reference)?);
            read.push(value.ok_or_else(|| of_another_type(*reference))?);
        }
        // SAFETY: the caller vouches for the array.
        unsafe { fill(values, value_count, "values", read.into_iter()) }
    })
}

fn of_another_type(reference: u32) -> Fault {
    Fault::new(
        IlonStatus::Value,
        format!("the variable {reference} is of another type"),
    )
}

/// Sets variables of one type: all of them, or up to the one that is refused.
unsafe fn set<T: Copy>(
    instance: Opaque,
    (references, count): (*const u32, usize),
    (values, value_count): (*const T, usize),
    make: impl Fn(T) -> Value,
) -> Fmi3Status {
    with(instance, |slave| {
        // SAFETY: the caller vouches for both arrays.
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

/// The functions that read and set one type.
macro_rules! of_type {
    ($get:ident, $set:ident, $type:ty, $take:expr, $make:expr) => {
        /// Reads variables of this type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: Opaque,
            references: *const u32,
            count: usize,
            values: *mut $type,
            value_count: usize,
        ) -> Fmi3Status {
            // SAFETY: the caller vouches for both arrays.
            unsafe { get(instance, (references, count), (values, value_count), $take) }
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
            // SAFETY: the caller vouches for both arrays.
            unsafe { set(instance, (references, count), (values, value_count), $make) }
        }
    };
}

of_type!(
    fmi3GetFloat64,
    fmi3SetFloat64,
    f64,
    |value| match value {
        Value::Real(value) => Some(value),
        _ => None,
    },
    Value::Real
);
of_type!(
    fmi3GetInt64,
    fmi3SetInt64,
    i64,
    |value| match value {
        Value::Whole(value) => Some(value),
        _ => None,
    },
    Value::Whole
);
// C writes any byte into a bool; what is not 0 is true.
of_type!(
    fmi3GetBoolean,
    fmi3SetBoolean,
    u8,
    |value| match value {
        Value::Flag(value) => Some(u8::from(value)),
        _ => None,
    },
    |value| Value::Flag(value != 0)
);

/// The instance as it is now, to come back to; into a state that is given, or where that is null into a new one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: Opaque, state: *mut Opaque) -> Fmi3Status {
    with(instance, |slave| {
        let copy = slave.instance.clone();
        // SAFETY: the caller vouches for a pointer that was written before.
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

/// Goes back to a state: from there all is as it was, to the bit.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetFMUState(instance: Opaque, state: Opaque) -> Fmi3Status {
    with(instance, |slave| {
        STATES.with(handle(state), |state| {
            slave.instance.clone_from(state);
            Ok(())
        })
    })
}

/// Ends a state, and sets it to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: Opaque, state: *mut Opaque) -> Fmi3Status {
    with(instance, |_| {
        if state.is_null() {
            return Ok(());
        }
        // SAFETY: the caller vouches for a pointer that was written before.
        let given = unsafe { array(state.cast_const(), 1, "FMUState") }?[0];
        if given.is_null() {
            return Ok(());
        }
        STATES.remove(handle(given))?;
        // SAFETY: as above.
        unsafe { put(state, "FMUState", std::ptr::null_mut()) }
    })
}

/// Refuses what this FMU cannot do; for [`refused`].
fn refuse(instance: Opaque, name: &str) -> Fmi3Status {
    with(instance, |_| {
        let why =
            format!("{name} is not to be had: see modelDescription.xml for what this FMU can");
        Err(Fault::new(IlonStatus::Value, why))
    })
}

/// By this an exporter sees that the library is of its own version.
#[used]
static MARK: &str = ilon_fmi::MARK;
