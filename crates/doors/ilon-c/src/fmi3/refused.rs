//! Functions of FMI 3.0 that are not supported: an importer finds the symbols, and each call fails
//! with a message.
//!
//! The FMU is for co-simulation only. It has no events, clocks, derivatives or structural
//! parameters, only variables of the types `Float64`, `Int64` and `Boolean`, and its states cannot
//! be serialised. `modelDescription.xml` states all of this, so importers do not call these
//! functions.

use std::ffi::{c_char, c_void};

use super::{Fmi3Status, Opaque, refuse};

/// Functions that take an instance and refuse, with the arguments of the standard.
macro_rules! refused {
    ($($name:ident($($of:ty),*);)*) => {
        $(
            /// Not supported.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name(instance: Opaque $(, _: $of)*) -> Fmi3Status {
                refuse(instance, stringify!($name))
            }
        )*
    };
}

/// Types without variables: reading or setting zero of them succeeds, as some importers do.
macro_rules! typed {
    ($($get:ident, $set:ident, $of:ty;)*) => {
        $(
            /// There are no variables of this type.
            #[unsafe(no_mangle)]
            pub extern "C" fn $get(instance: Opaque, _: *const u32, count: usize, _: *mut $of, _: usize) -> Fmi3Status {
                none(instance, count, stringify!($get))
            }

            /// There are no variables of this type.
            #[unsafe(no_mangle)]
            pub extern "C" fn $set(instance: Opaque, _: *const u32, count: usize, _: *const $of, _: usize) -> Fmi3Status {
                none(instance, count, stringify!($set))
            }
        )*
    };
}

fn none(instance: Opaque, count: usize, name: &str) -> Fmi3Status {
    if count == 0 {
        return super::with(instance, |_| Ok(()));
    }
    refuse(instance, name)
}

typed! {
    fmi3GetFloat32, fmi3SetFloat32, f32;
    fmi3GetInt8, fmi3SetInt8, i8;
    fmi3GetUInt8, fmi3SetUInt8, u8;
    fmi3GetInt16, fmi3SetInt16, i16;
    fmi3GetUInt16, fmi3SetUInt16, u16;
    fmi3GetInt32, fmi3SetInt32, i32;
    fmi3GetUInt32, fmi3SetUInt32, u32;
    fmi3GetUInt64, fmi3SetUInt64, u64;
    fmi3GetString, fmi3SetString, *const c_char;
}

refused! {
    fmi3GetBinary(*const u32, usize, *mut usize, *mut *const u8, usize);
    fmi3SetBinary(*const u32, usize, *const usize, *const *const u8, usize);
    fmi3GetClock(*const u32, usize, *mut bool);
    fmi3SetClock(*const u32, usize, *const bool);
    fmi3GetNumberOfVariableDependencies(u32, *mut usize);
    fmi3GetVariableDependencies(u32, *mut usize, *mut u32, *mut usize, *mut i32, usize);
    fmi3SerializedFMUStateSize(Opaque, *mut usize);
    fmi3SerializeFMUState(Opaque, *mut u8, usize);
    fmi3DeserializeFMUState(*const u8, usize, *mut Opaque);
    fmi3GetDirectionalDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
    fmi3GetAdjointDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
    fmi3GetOutputDerivatives(*const u32, usize, *const i32, *mut f64, usize);
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3GetIntervalDecimal(*const u32, usize, *mut f64, *mut i32);
    fmi3GetIntervalFraction(*const u32, usize, *mut u64, *mut u64, *mut i32);
    fmi3GetShiftDecimal(*const u32, usize, *mut f64);
    fmi3GetShiftFraction(*const u32, usize, *mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const u32, usize, *const f64);
    fmi3SetIntervalFraction(*const u32, usize, *const u64, *const u64);
    fmi3SetShiftDecimal(*const u32, usize, *const f64);
    fmi3SetShiftFraction(*const u32, usize, *const u64, *const u64);
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64);
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize);
    fmi3GetContinuousStateDerivatives(*mut f64, usize);
    fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetContinuousStates(*mut f64, usize);
    fmi3GetNominalsOfContinuousStates(*mut f64, usize);
    fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize);
    fmi3ActivateModelPartition(u32, f64);
}

/// Model exchange is not supported: null.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateModelExchange(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    _: *mut c_void,
    _: super::LogMessage,
) -> Opaque {
    std::ptr::null_mut()
}

/// Scheduled execution is not supported: null.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateScheduledExecution(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    _: *mut c_void,
    _: super::LogMessage,
    _: *const c_void,
    _: *const c_void,
    _: *const c_void,
) -> Opaque {
    std::ptr::null_mut()
}
