//! How parts of a robot fare.

use crate::declare::messages;
use crate::std_msgs::Header;

messages! { diagnostic_msgs;
    /// A value under a name.
    #[derive(Eq)]
    KeyValue "d68081eaa540288c5440753baecef0c4e16e81a5f78ad68902ded5100413bb42" {
        /// The name.
        key: String,
        /// The value.
        value: String,
    }

    /// How one part fares.
    #[derive(Eq)]
    DiagnosticStatus "b0e3e692ea2d54a8af2f4ef1930e81556a2db55216b771f8a7d2724ed47bf0e4" const {
        /// All is well.
        OK: u8 as byte = 0,
        /// Something to look into.
        WARN: u8 as byte = 1,
        /// Something failed.
        ERROR: u8 as byte = 2,
        /// Nothing has been heard for too long.
        STALE: u8 as byte = 3,
    } {
        /// How severe: one of the constants.
        level: u8 as byte,
        /// Which part, with those that it belongs to before it: `ilon/wheels/front_left`.
        name: String,
        /// How it fares, in words.
        message: String,
        /// The hardware, as by its serial number.
        hardware_id: String,
        /// What it was judged by.
        values: Vec<KeyValue>,
    }

    /// How several parts fare, for `/diagnostics`.
    #[derive(Eq)]
    DiagnosticArray "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e" {
        /// When.
        header: Header,
        /// The parts.
        status: Vec<DiagnosticStatus>,
    }
}
