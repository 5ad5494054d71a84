//! Times and durations.

use crate::declare::messages;

messages! { builtin_interfaces;
    /// A time since the clock's start: the Unix epoch, or that of the simulation.
    #[derive(Copy, Eq)]
    Time "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197" {
        /// Whole seconds, s.
        sec: i32,
        /// Nanoseconds on top, below 10^9.
        nanosec: u32,
    }

    /// A duration.
    #[derive(Copy, Eq)]
    Duration "e8d009f659816f758b75334ee1a9ca5b5c0b859843261f14c7f937349599d93b" {
        /// Whole seconds, s, rounded down.
        sec: i32,
        /// Nanoseconds on top, below 10^9.
        nanosec: u32,
    }
}

const NANOSECONDS: u64 = 1_000_000_000;

impl Time {
    /// Returns the time `nanoseconds` after the clock's start; `None` if its seconds exceed 31 bits
    /// (Unix time of 2038).
    pub fn from_nanoseconds(nanoseconds: u64) -> Option<Self> {
        let sec = i32::try_from(nanoseconds / NANOSECONDS).ok()?;
        let nanosec = (nanoseconds % NANOSECONDS) as u32;
        Some(Self { sec, nanosec })
    }

    /// Returns the nanoseconds since the clock's start; `None` for a time before it.
    pub fn nanoseconds(self) -> Option<u64> {
        let sec = u64::try_from(self.sec).ok()?;
        Some(sec * NANOSECONDS + u64::from(self.nanosec))
    }
}
