//! The interface to JavaScript: requests and replies are bytes in linear memory, in two buffers
//! that the module owns.
//!
//! ```js
//! const at = exports.ilon_room(bytes.length);                      // buffer for the input
//! new Uint8Array(exports.memory.buffer, at, bytes.length).set(bytes);
//! const length = exports.ilon_ask();                               // length of the reply
//! const reply = new Uint8Array(exports.memory.buffer, exports.ilon_reply(), length).slice();
//! ```
//!
//! A panic ends the instance, as WebAssembly cannot unwind. Its message is kept in
//! [`ilon_last_words`].

use std::cell::RefCell;
use std::sync::Mutex;

use crate::door::Door;

/// The buffers.
#[derive(Default)]
struct Border {
    door: Door,
    inward: Vec<u8>,
    outward: Vec<u8>,
}

thread_local! {
    static BORDER: RefCell<Border> = RefCell::default();
}

/// The message of a panic. Outside `Border`, which may be locked during a panic.
static LAST_WORDS: Mutex<String> = Mutex::new(String::new());

/// Installs the panic hook. Call it once, before anything else.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that JavaScript finds")]
pub extern "C" fn ilon_begin() {
    std::panic::set_hook(Box::new(|panic| {
        if let Ok(mut words) = LAST_WORDS.lock() {
            *words = panic.to_string();
        }
    }));
}

/// Makes room for `length` bytes of input and returns its address.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that JavaScript finds")]
pub extern "C" fn ilon_room(length: usize) -> *mut u8 {
    BORDER.with_borrow_mut(|border| {
        border.inward = vec![0; length];
        border.inward.as_mut_ptr()
    })
}

/// Takes the input as a file: the first `path_length` bytes are its path, in UTF-8, and the rest is
/// its content.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that JavaScript finds")]
pub extern "C" fn ilon_put(path_length: usize) {
    BORDER.with_borrow_mut(|border| {
        let mut path = std::mem::take(&mut border.inward);
        let bytes = path.split_off(path_length.min(path.len()));
        let path = String::from_utf8_lossy(&path).into_owned();
        border.door.put(path, bytes);
    });
}

/// Answers the request in the input, JSON as [`Request`](crate::door::Request); returns the length
/// of the reply.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that JavaScript finds")]
pub extern "C" fn ilon_ask() -> usize {
    BORDER.with_borrow_mut(|border| {
        let request = std::mem::take(&mut border.inward);
        border.outward = border.door.ask(&request);
        border.outward.len()
    })
}

/// The address of the reply.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that JavaScript finds")]
pub extern "C" fn ilon_reply() -> *const u8 {
    BORDER.with_borrow(|border| border.outward.as_ptr())
}

/// The address of the last panic's message. After a panic only this function and the one for its
/// length may be called.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that JavaScript finds")]
pub extern "C" fn ilon_last_words() -> *const u8 {
    let words = LAST_WORDS.lock();
    words.map_or(std::ptr::null(), |words| words.as_ptr())
}

/// The length of [`ilon_last_words`], in bytes.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that JavaScript finds")]
pub extern "C" fn ilon_last_words_length() -> usize {
    LAST_WORDS.lock().map_or(0, |words| words.len())
}
