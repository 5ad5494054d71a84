//! Ctrl-C, SIGTERM and SIGHUP: nothing half-written is left, and the exit code names the signal.

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};

use super::console;
use super::escape::path_in_line;

/// The longest time until a signal is obeyed.
const EVERY: Duration = Duration::from_millis(20);

/// Whether a command ends by itself after the first signal.
static IS_AWAITED: AtomicBool = AtomicBool::new(false);
/// Whether such a signal came.
static CAME: AtomicBool = AtomicBool::new(false);
/// What is left on purpose, for the note at the end.
static LEFT: Mutex<Option<Words>> = Mutex::new(None);

type Words = Box<dyn FnOnce() -> String + Send>;

/// From now on, SIGINT, SIGTERM and SIGHUP end the process once its unfinished files and locks are
/// removed. It ends by the signal, which a shell reports as the exit code 130, 143 or 129.
pub fn end_on_signals() {
    let signal = Arc::new(AtomicUsize::new(0));
    let heard = Arc::clone(&signal);
    let obey = move || {
        loop {
            std::thread::sleep(EVERY);
            match heard.swap(0, Ordering::Relaxed) {
                0 => {}
                _ if IS_AWAITED.swap(false, Ordering::Relaxed) => {
                    CAME.store(true, Ordering::Relaxed);
                }
                signal => end(signal),
            }
        }
    };
    let thread = std::thread::Builder::new().name("signals".to_owned());
    if thread.spawn(obey).is_ok() {
        for kind in kinds() {
            let _ = signal_hook::flag::register_usize(kind, Arc::clone(&signal), kind as usize);
        }
    }
}

#[cfg(not(target_os = "linux"))]
fn kinds() -> Vec<i32> {
    vec![SIGINT, SIGTERM]
}

/// A closed terminal ends the command too, unless `nohup` has it ignored.
#[cfg(target_os = "linux")]
fn kinds() -> Vec<i32> {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // The lowest bit stands for the first signal, SIGHUP.
    let is_heard = mask.is_some_and(|mask| mask & 1 == 0);
    let hangup = is_heard.then_some(signal_hook::consts::SIGHUP);
    [SIGINT, SIGTERM].into_iter().chain(hangup).collect()
}

fn end(signal: usize) -> ! {
    ilon_trace::file::discard_unfinished();
    let left = LEFT.lock().unwrap_or_else(PoisonError::into_inner).take();
    let left = left.map_or_else(String::new, |words| words());
    console::note(&format!("note: interrupted{left}"));
    // By the signal itself, so that a shell's loop around the command ends too.
    let _ = signal_hook::low_level::emulate_default_handler(signal as i32);
    std::process::exit(128 + signal as i32)
}

/// What an interruption leaves on purpose, to follow "interrupted".
pub(super) fn leaves(words: impl FnOnce() -> String + Send + 'static) {
    *LEFT.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(words));
}

/// An interruption leaves a trace that grows in a folder, and names it if any part of it is whole.
pub(super) fn leaves_trace(growing: PathBuf) {
    let is_part = |entry: fs::DirEntry| entry.path().extension() == Some("parquet".as_ref());
    leaves(move || {
        let holds_parts = fs::read_dir(&growing).is_ok_and(|of| of.flatten().any(is_part));
        match holds_parts {
            true => format!(": the trace until then is in {}", path_in_line(&growing)),
            false => String::new(),
        }
    });
}

/// Leaves the end after the first signal to the caller, who asks whether it came; a second one ends
/// the process at once.
#[cfg(feature = "live")]
pub(super) fn awaited() -> impl Fn() -> bool {
    IS_AWAITED.store(true, Ordering::Relaxed);
    || CAME.load(Ordering::Relaxed)
}
