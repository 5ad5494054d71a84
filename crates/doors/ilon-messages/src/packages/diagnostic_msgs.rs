//! Diagnostics of a robot's parts.

use crate::declare::messages;
use crate::std_msgs::Header;

messages! { diagnostic_msgs;
    /// A named value.
    #[derive(Eq)]
    KeyValue "d68081eaa540288c5440753baecef0c4e16e81a5f78ad68902ded5100413bb42" {
        /// The name.
        key: String,
        /// The value.
        value: String,
    }

    /// Status of one part.
    #[derive(Eq)]
    DiagnosticStatus "b0e3e692ea2d54a8af2f4ef1930e81556a2db55216b771f8a7d2724ed47bf0e4" const {
        /// No problem.
        OK: u8 as byte = 0,
        /// A warning.
        WARN: u8 as byte = 1,
        /// An error.
        ERROR: u8 as byte = 2,
        /// No data for too long.
        STALE: u8 as byte = 3,
    } {
        /// Severity: one of the constants.
        level: u8 as byte,
        /// Name of the part, after its parents': `ilon/wheels/front_left`.
        name: String,
        /// Status as text.
        message: String,
        /// Hardware identifier, such as a serial number.
        hardware_id: String,
        /// Values behind the status.
        values: Vec<KeyValue>,
    }

    /// Status of several parts, for `/diagnostics`.
    #[derive(Eq)]
    DiagnosticArray "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e" {
        /// Time.
        header: Header,
        /// The parts.
        status: Vec<DiagnosticStatus>,
    }
}
