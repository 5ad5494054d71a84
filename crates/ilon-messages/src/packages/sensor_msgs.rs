//! What sensors say.

use crate::declare::messages;
use crate::std_msgs::Header;

messages! { sensor_msgs;
    /// The joints of a robot. Each list has one value for each name, or is empty.
    JointState "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e" {
        /// When.
        header: Header,
        /// The joints' names.
        name: Vec<String>,
        /// Their angles, rad, or places, m.
        position: Vec<f64>,
        /// Their rates, rad/s or m/s.
        velocity: Vec<f64>,
        /// Their torques, N·m, or forces, N.
        effort: Vec<f64>,
    }

    /// A picture in a file format.
    #[derive(Eq)]
    CompressedImage "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a" {
        /// When, and in the frame of which camera.
        header: Header,
        /// The file format, such as `png`.
        format: String,
        /// The file.
        data: Vec<u8>,
    }
}
