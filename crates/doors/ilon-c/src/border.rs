//! Reads and writes memory of the caller.
//!
//! Every pointer is checked as far as possible: it is not null and is aligned, a length does not
//! exceed the address space, a text is UTF-8. Only the caller can ensure that the memory is that
//! large and that no other thread writes to it during the call.

#![allow(unsafe_code, reason = "memory of C is reached through pointers alone")]

use std::ffi::{CStr, c_char};

use crate::status::{Fault, IlonStatus};

fn bad(name: &str, what: &str) -> Fault {
    Fault::new(IlonStatus::Pointer, format!("`{name}` {what}"))
}

/// Checks a pointer to `count` values.
fn check<T>(at: *const T, count: usize, name: &str) -> Result<(), Fault> {
    if at.is_null() {
        return Err(bad(name, "is null"));
    }
    if !at.is_aligned() {
        return Err(bad(name, "is not aligned to what it points at"));
    }
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(Fault::new(
            IlonStatus::Count,
            format!("`{name}` cannot have {count} elements"),
        ));
    }
    Ok(())
}

/// Reads a text of the caller.
///
/// # Safety
/// A non-null pointer points at bytes up to a zero, which are not written to during the reference's
/// lifetime.
pub(crate) unsafe fn text<'a>(at: *const c_char, name: &str) -> Result<&'a str, Fault> {
    check(at, 1, name)?;
    // SAFETY: the pointer is not null, and the caller guarantees the rest.
    let bytes = unsafe { CStr::from_ptr(at) };
    bytes.to_str().map_err(|_| bad(name, "is not UTF-8"))
}

/// Borrows an array of the caller for reading. Without elements the pointer may be null.
///
/// # Safety
/// A non-null pointer points at `count` initialised values, which are not written to during the
/// reference's lifetime.
pub(crate) unsafe fn array<'a, T>(
    at: *const T,
    count: usize,
    name: &str,
) -> Result<&'a [T], Fault> {
    if count == 0 {
        return Ok(&[]);
    }
    check(at, count, name)?;
    // SAFETY: the pointer is not null and aligned, the length is possible, and the caller
    // guarantees the rest.
    Ok(unsafe { std::slice::from_raw_parts(at, count) })
}

/// Reads three numbers of the caller; `None` for a null pointer.
///
/// # Safety
/// As [`array`] with three elements.
pub(crate) unsafe fn triple(at: *const f64, name: &str) -> Result<Option<[f64; 3]>, Fault> {
    if at.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller guarantees three numbers.
    let numbers = unsafe { array(at, 3, name) }?;
    Ok(Some([numbers[0], numbers[1], numbers[2]]))
}

/// Writes values into an array of the caller, which must have the same length.
///
/// # Safety
/// A non-null pointer points at memory for `count` values, which no other thread accesses during
/// the call. The memory may be uninitialised.
pub(crate) unsafe fn fill<T>(
    at: *mut T,
    count: usize,
    name: &str,
    values: impl ExactSizeIterator<Item = T>,
) -> Result<(), Fault> {
    let wanted = values.len();
    if count != wanted {
        return Err(Fault::new(
            IlonStatus::Count,
            format!("`{name}` has {count} elements, and there are {wanted}"),
        ));
    }
    if count == 0 {
        return Ok(());
    }
    check(at, count, name)?;
    for (index, value) in values.take(count).enumerate() {
        // SAFETY: the index is below `count`, and the caller guarantees the memory.
        unsafe { at.add(index).write(value) };
    }
    Ok(())
}

/// Writes a value to the caller's memory.
///
/// # Safety
/// As [`fill`] with one element.
pub(crate) unsafe fn put<T>(at: *mut T, name: &str, value: T) -> Result<(), Fault> {
    // SAFETY: the caller guarantees memory for one value.
    unsafe { fill(at, 1, name, std::iter::once(value)) }
}

/// Writes a text and its terminating zero into a buffer of the caller.
///
/// # Safety
/// As [`fill`] with `size` bytes.
pub(crate) unsafe fn put_text(
    at: *mut c_char,
    size: usize,
    name: &str,
    words: &str,
) -> Result<(), Fault> {
    let needed = words.len() + 1;
    if size < needed {
        return Err(Fault::new(
            IlonStatus::Count,
            format!("`{name}` has {size} bytes, and {needed} are needed"),
        ));
    }
    let bytes: Vec<c_char> = words
        .bytes()
        .chain([0])
        .map(|byte| byte as c_char)
        .collect();
    // SAFETY: the buffer is long enough, and the caller guarantees its memory.
    unsafe { fill(at, needed, name, bytes.into_iter()) }
}
