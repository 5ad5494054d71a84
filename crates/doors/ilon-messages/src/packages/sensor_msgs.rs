//! Sensor data.

use crate::declare::messages;
use crate::geometry_msgs::{Quaternion, Vector3};
use crate::std_msgs::Header;

/// A 3 x 3 covariance, row by row. A first element of -1 means that the quantity is not measured,
/// all zeros that its covariance is unknown.
pub type Covariance3 = [[f64; 3]; 3];

messages! { sensor_msgs;
    /// Data of an inertial measurement unit.
    Imu "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b" {
        /// Time and frame.
        header: Header,
        /// Orientation.
        orientation: Quaternion,
        /// Its covariance, rad².
        orientation_covariance: Covariance3,
        /// Angular velocity, rad/s.
        angular_velocity: Vector3,
        /// Its covariance, rad²/s².
        angular_velocity_covariance: Covariance3,
        /// The specific force, upwards at rest, m/s².
        linear_acceleration: Vector3,
        /// Its covariance, m²/s⁴.
        linear_acceleration_covariance: Covariance3,
    }

    /// The joints of a robot. Each list has one value for each name, or is empty.
    JointState "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e" {
        /// Time.
        header: Header,
        /// The joints' names.
        name: Vec<String>,
        /// Their positions, rad or m.
        position: Vec<f64>,
        /// Their rates, rad/s or m/s.
        velocity: Vec<f64>,
        /// Their torques, N·m, or forces, N.
        effort: Vec<f64>,
    }

    /// A picture in a file format.
    #[derive(Eq)]
    CompressedImage "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a" {
        /// Time, and the camera's frame.
        header: Header,
        /// The file format, such as `png`.
        format: String,
        /// The file.
        data: Vec<u8>,
    }
}
