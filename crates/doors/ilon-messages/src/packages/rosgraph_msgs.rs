//! The clock of a simulation.

use crate::builtin_interfaces::Time;
use crate::declare::messages;

messages! { rosgraph_msgs;
    /// The simulated time, for nodes with `use_sim_time`.
    #[derive(Copy, Eq)]
    Clock "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564" {
        /// The time.
        clock: Time,
    }
}
