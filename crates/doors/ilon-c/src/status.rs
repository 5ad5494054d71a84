//! How a call ended, and why: a code for the program, and words for a person.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use ilon_sim::Error;
use miette::Diagnostic;

/// How a call ended. All but 0 are failures, which `ilon_last_error` explains.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IlonStatus {
    /// It was done.
    Ok = 0,
    /// A pointer is null or misaligned, or a text is not UTF-8.
    Pointer = 1,
    /// A handle is unknown: freed, made up, or of another kind.
    Handle = 2,
    /// An array is too short or too long.
    Count = 3,
    /// A number is not finite or out of its range, or a snapshot is of another plant. Nothing has happened.
    Value = 4,
    /// The scenario, or the robot that it names, cannot be read or makes no sense.
    Scenario = 5,
    /// The robot's motion is no number any more. Reset or restore it.
    Diverged = 6,
    /// Another thread is using this plant. Nothing has happened.
    Busy = 7,
    /// A fault of ilon itself. The plant takes no call any more but the one that frees it.
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
    /// In the words of the command: what is wrong, and how to repair it.
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

/// Why the last call of this thread that failed did so, in UTF-8, or an empty text. It lies where it is until the next call of this thread
/// fails, or the thread ends; never null.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that C finds")]
pub extern "C" fn ilon_last_error() -> *const c_char {
    // While a thread ends it has no words any more.
    let words = LAST.try_with(|words| words.borrow().as_ptr());
    words.unwrap_or(c"".as_ptr())
}

/// What [`ilon_last_error`] says, kept.
pub(crate) fn last_words() -> CString {
    let words = LAST.try_with(|words| words.borrow().clone());
    words.unwrap_or_default()
}

/// Does what a call is for, and turns whatever comes of it into a code. No panic passes.
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
    // What is within the words of a file may hold zeros, which would end a text of C.
    let words = CString::new(fault.message.replace('\0', " ")).unwrap_or_default();
    let _ = LAST.try_with(|last| last.replace(words));
    fault.status
}

/// The stack that reading a file and building its robot may take, in bytes: parsers call themselves for what is nested.
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
