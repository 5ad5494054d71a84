//! Limits that hold on time, depth and memory, so that a file that never ends is refused in words.
//!
//! They count work, not seconds: the same file is taken or refused on every machine.

use std::cell::Cell;

use super::python::Value;
use super::spent::Spent;

/// Most steps of one expansion. A step is the evaluation of a token, an element, a value, or of some dozen bytes; a robot with
/// a hundred rollers takes some hundred thousand.
const MOST_STEPS: u64 = 4_000_000;
/// Deepest nesting of elements, macros, properties and expressions within each other, each level of them counted.
pub(super) const DEEPEST: usize = 6_000;
/// Stack of the thread that expands, in bytes: a level takes a few kilobytes at most.
pub(super) const STACK_BYTES: usize = 64 << 20;

/// What is left of the limits.
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

    /// Pays for some work.
    pub(super) fn spend(&self, steps: u64) -> Result<(), Spent> {
        match self.steps.get().checked_sub(steps) {
            Some(left) => {
                self.steps.set(left);
                Ok(())
            }
            None => {
                // Nothing goes on after the first refusal, whoever catches it.
                self.steps.set(0);
                Err(Spent::Steps)
            }
        }
    }

    /// Pays for a text of that many bytes.
    pub(super) fn spend_bytes(&self, bytes: usize) -> Result<(), Spent> {
        self.spend(1 + bytes as u64 / 24)
    }

    /// Pays for going through a value, to print, copy or compare it: before that is done, for a short text can make a value that
    /// never ends.
    pub(super) fn spend_on(&self, value: &Value) -> Result<(), Spent> {
        self.spend_bytes(value.size().bytes())
    }

    /// How deep it is now.
    pub(super) fn depth(&self) -> usize {
        self.depth.get()
    }

    /// Goes down by so many levels, until the guard is dropped.
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

/// Levels that are left when this is dropped.
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
