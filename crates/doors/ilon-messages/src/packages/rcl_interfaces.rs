//! What nodes log.

use crate::builtin_interfaces::Time;
use crate::declare::messages;

messages! { rcl_interfaces;
    /// A line of a log, for `/rosout`.
    #[derive(Eq)]
    Log "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac" const {
        /// For those who look for a fault in the program.
        DEBUG: u8 = 10,
        /// All is well.
        INFO: u8 = 20,
        /// Something to look into.
        WARN: u8 = 30,
        /// Something failed.
        ERROR: u8 = 40,
        /// The program cannot go on.
        FATAL: u8 = 50,
    } {
        /// When.
        stamp: Time,
        /// How severe: one of the constants.
        level: u8,
        /// Who logged it.
        name: String,
        /// The line.
        msg: String,
        /// The source file from which it came.
        file: String,
        /// The function from which it came.
        function: String,
        /// The line of the source file from which it came.
        line: u32,
    }
}
