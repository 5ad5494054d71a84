//! Logs of nodes.

use crate::builtin_interfaces::Time;
use crate::declare::messages;

messages! { rcl_interfaces;
    /// A log entry, for `/rosout`.
    #[derive(Eq)]
    Log "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac" const {
        /// For debugging.
        DEBUG: u8 = 10,
        /// No problem.
        INFO: u8 = 20,
        /// A warning.
        WARN: u8 = 30,
        /// An error.
        ERROR: u8 = 40,
        /// A fatal error.
        FATAL: u8 = 50,
    } {
        /// Time.
        stamp: Time,
        /// Severity: one of the constants.
        level: u8,
        /// Name of the node.
        name: String,
        /// The text.
        msg: String,
        /// Source file.
        file: String,
        /// Source function.
        function: String,
        /// Line in the source file.
        line: u32,
    }
}
