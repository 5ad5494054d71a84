//! Limits on time, depth and memory, so that a file that never ends is rejected with a message.
//!
//! They count work, not seconds: the same file is accepted or rejected on every machine.

use std::cell::Cell;

use super::python::Value;
use super::spent::Spent;

/// Largest number of steps of one expansion. A step is the evaluation of a token, an element, a
/// value, or of some dozen bytes; a robot with a hundred rollers takes some hundred thousand.
const MOST_STEPS: u64 = 4_000_000;
/// Deepest nesting of elements, macros, properties and expressions, each level of them counted.
pub(super) const DEEPEST: usize = 6_000;
/// Stack of the expanding thread, in bytes: a level takes at most a few kilobytes.
pub(super) const STACK_BYTES: usize = 64 << 20;

/// The remaining limits.
#[derive(Debug)]
pub(super) struct Budget {
    steps: Cell<u64>,
    depth: Cell<usize>,
}

impl Budget {
    pub(super) fn new() -> Self {
        Self {
            steps: Cell::new(MOST_STEPS),
            depth: Cell::new(0),
        }
    }

    /// Charges a number of steps.
    pub(super) fn spend(&self, steps: u64) -> Result<(), Spent> {
        match self.steps.get().checked_sub(steps) {
            Some(left) => {
                self.steps.set(left);
                Ok(())
            }
            None => {
                // After the first failure everything fails, even if a caller ignores it.
                self.steps.set(0);
                Err(Spent::Steps)
            }
        }
    }

    /// Charges a text of that many bytes.
    pub(super) fn spend_bytes(&self, bytes: usize) -> Result<(), Spent> {
        self.spend(1 + bytes as u64 / 24)
    }

    /// Charges a pass through a value, to print, copy or compare it, before the pass: a short text
    /// can build an endless value.
    pub(super) fn spend_on(&self, value: &Value) -> Result<(), Spent> {
        self.spend_bytes(value.size().bytes)
    }

    /// The current depth.
    pub(super) fn depth(&self) -> usize {
        self.depth.get()
    }

    /// Enters a number of levels, until the guard is dropped.
    pub(super) fn enter(&self, levels: usize) -> Result<Level<'_>, Spent> {
        let depth = self.depth.get() + levels;
        if depth > DEEPEST {
            return Err(Spent::Depth);
        }
        self.depth.set(depth);
        Ok(Level {
            depth: &self.depth,
            levels,
        })
    }
}

/// Leaves its levels when dropped.
#[derive(Debug)]
pub(super) struct Level<'a> {
    depth: &'a Cell<usize>,
    levels: usize,
}

impl Drop for Level<'_> {
    fn drop(&mut self) {
        self.depth.set(self.depth.get() - self.levels);
    }
}
