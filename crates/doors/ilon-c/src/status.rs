//! Results of calls: a code for the program and a message for its user.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use ilon_sim::Error;
use miette::Diagnostic;

/// The result of a call. All except 0 are failures, which `ilon_last_error` explains.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IlonStatus {
    /// Success.
    Ok = 0,
    /// A pointer is null or misaligned, or a text is not UTF-8.
    Pointer = 1,
    /// A handle is unknown: freed, made up, or of another kind.
    Handle = 2,
    /// An array is too short or too long.
    Count = 3,
    /// A number is not finite or out of its range, or a snapshot is of another plant. The state is
    /// unchanged.
    Value = 4,
    /// The scenario, or the robot that it names, cannot be read or is invalid.
    Scenario = 5,
    /// The robot's motion is no longer finite. Reset or restore it.
    Diverged = 6,
    /// Another thread is using this plant. The state is unchanged.
    Busy = 7,
    /// An internal error of ilon. The plant accepts only the call that frees it.
    Internal = 8,
}

/// Why a call failed.
#[derive(Debug)]
pub(crate) struct Fault {
    pub status: IlonStatus,
    pub message: String,
}

impl Fault {
    pub fn new(status: IlonStatus, message: impl Into<String>) -> Self {
        Self {
            status,
            message: message.into(),
        }
    }
}

impl From<Error> for Fault {
    /// The command's message: what is wrong, and how to repair it.
    fn from(error: Error) -> Self {
        let status = match error {
            Error::Diverged { .. } => IlonStatus::Diverged,
            Error::Invalid { .. } | Error::World(_) | Error::Control(_) => IlonStatus::Value,
            _ => IlonStatus::Scenario,
        };
        let help = error.help().map(|help| format!("; {help}"));
        Self::new(status, format!("{error}{}", help.unwrap_or_default()))
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// The reason for the last failed call of this thread, in UTF-8, or an empty text. The text is
/// valid until the next call of this thread fails, or the thread ends; never null.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that C finds")]
pub extern "C" fn ilon_last_error() -> *const c_char {
    // The message no longer exists while a thread ends.
    let words = LAST.try_with(|words| words.borrow().as_ptr());
    words.unwrap_or(c"".as_ptr())
}

/// A copy of the message that [`ilon_last_error`] returns.
pub(crate) fn last_words() -> CString {
    let words = LAST.try_with(|words| words.borrow().clone());
    words.unwrap_or_default()
}

/// Runs the body of a call and converts its result to a code. A panic does not leave this function.
pub(crate) fn guarded(call: impl FnOnce() -> Result<(), Fault>) -> IlonStatus {
    let fault = match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => return IlonStatus::Ok,
        Ok(Err(fault)) => fault,
        Err(panic) => {
            let said = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or(panic.downcast_ref::<&str>().copied());
            Fault::new(
                IlonStatus::Internal,
                format!(
                    "a fault of ilon itself, please report it: {}",
                    said.unwrap_or("no words")
                ),
            )
        }
    };
    // The content of a file may hold zeros, which would end a C string.
    let words = CString::new(fault.message.replace('\0', " ")).unwrap_or_default();
    let _ = LAST.try_with(|last| last.replace(words));
    fault.status
}

/// The stack that reading a file and building its robot may take, in bytes: parsers call themselves
/// for what is nested.
const STACK_BYTES: usize = 8 << 20;

/// Does something deep on a stack of its own: that of the caller may be as small as 256 kB.
pub(crate) fn on_own_stack<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Fault> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
        match thread.spawn_scoped(scope, work) {
            Ok(thread) => thread.join().map_err(|panic| resume_unwind(panic)),
            Err(error) => Err(Fault::new(
                IlonStatus::Internal,
                format!("no thread could be started to read files: {error}"),
            )),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_code_and_its_words_are_kept() {
        let status = guarded(|| panic!("of a kind"));
        assert_eq!(status, IlonStatus::Internal);
        let words = LAST.with_borrow(|words| words.to_string_lossy().into_owned());
        assert!(words.ends_with("of a kind"), "{words}");
    }
}
