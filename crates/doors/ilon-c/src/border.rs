//! How memory of the caller is read and written.
//!
//! What can be known of a pointer is looked at: that it is not null and is aligned, that a length does not run over the address space, that a
//! text is UTF-8. That so much memory is there, and that nobody else writes to it meanwhile, only the caller can know.

#![allow(unsafe_code, reason = "memory of C is reached through pointers alone")]

use std::ffi::{CStr, c_char};

use crate::status::{Fault, IlonStatus};

fn bad(name: &str, what: &str) -> Fault {
    Fault::new(IlonStatus::Pointer, format!("`{name}` {what}"))
}

/// Looks at a pointer to so many values.
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

/// A text of the caller.
///
/// # Safety
/// A pointer that is not null points at bytes up to a zero, which nobody writes to while the reference lives.
pub(crate) unsafe fn text<'a>(at: *const c_char, name: &str) -> Result<&'a str, Fault> {
    check(at, 1, name)?;
    // SAFETY: it is not null, and the caller vouches for the rest.
    let bytes = unsafe { CStr::from_ptr(at) };
    bytes.to_str().map_err(|_| bad(name, "is not UTF-8"))
}

/// An array of the caller, to be read. Of no elements it may be null.
///
/// # Safety
/// A pointer that is not null points at `count` initialised values, which nobody writes to while the reference lives.
pub(crate) unsafe fn array<'a, T>(
    at: *const T,
    count: usize,
    name: &str,
) -> Result<&'a [T], Fault> {
    if count == 0 {
        return Ok(&[]);
    }
    check(at, count, name)?;
    // SAFETY: it is not null, aligned and of a possible length, and the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts(at, count) })
}

/// Three numbers of the caller, or none where the pointer is null.
///
/// # Safety
/// As [`array`] of three.
pub(crate) unsafe fn triple(at: *const f64, name: &str) -> Result<Option<[f64; 3]>, Fault> {
    if at.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller vouches for three numbers.
    let numbers = unsafe { array(at, 3, name) }?;
    Ok(Some([numbers[0], numbers[1], numbers[2]]))
}

/// Writes values into an array of the caller, which must be as long.
///
/// # Safety
/// A pointer that is not null points at memory for `count` values, which nobody else looks at meanwhile. What lies there may be anything.
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
        // SAFETY: the index is below `count`, and the caller vouches for as much memory.
        unsafe { at.add(index).write(value) };
    }
    Ok(())
}

/// Writes a value to the caller's memory.
///
/// # Safety
/// As [`fill`] of one.
pub(crate) unsafe fn put<T>(at: *mut T, name: &str, value: T) -> Result<(), Fault> {
    // SAFETY: the caller vouches for memory of one value.
    unsafe { fill(at, 1, name, std::iter::once(value)) }
}

/// Writes a text and its closing zero into a buffer of the caller.
///
/// # Safety
/// As [`fill`] of `size` bytes.
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
    // SAFETY: the buffer is at least as long, and the caller vouches for it.
    unsafe { fill(at, needed, name, bytes.into_iter()) }
}
