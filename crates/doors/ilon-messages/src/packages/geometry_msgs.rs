//! Points, poses, velocities and forces, in SI units.

use crate::declare::messages;
use crate::std_msgs::Header;

/// A 6 x 6 covariance: rows and columns x, y, z, then rotations about x, y, z.
pub type Covariance = [[f64; 6]; 6];

impl Pose {
    /// Returns x and y in metres and the heading in radians. For a leaning body the heading is the
    /// rotation about z before the lean.
    pub fn planar(&self) -> [f64; 3] {
        let q = &self.orientation;
        let heading_rad = libm::atan2(
            2.0 * (q.w * q.z + q.x * q.y),
            1.0 - 2.0 * (q.y * q.y + q.z * q.z),
        );
        [self.position.x, self.position.y, heading_rad]
    }
}

messages! { geometry_msgs;
    /// A point.
    #[derive(Copy)]
    Point "6963084842a9b04494d6b2941d11444708d892da2f4b09843b9c43f42a7f6881" {
        /// Along x, m.
        x: f64,
        /// Along y, m.
        y: f64,
        /// Along z, m.
        z: f64,
    }

    /// A vector, in the unit of the containing message.
    #[derive(Copy)]
    Vector3 "cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d" {
        /// Along or about x.
        x: f64,
        /// Along or about y.
        y: f64,
        /// Along or about z.
        z: f64,
    }

    /// An orientation as a unit quaternion; none by default.
    #[derive(Copy)]
    Quaternion "8a765f66778c8ff7c8ab94afcc590a2ed5325a1d9a076ffff38fbce36f458684" {
        /// The factor of i.
        x: f64,
        /// The factor of j.
        y: f64,
        /// The factor of k.
        z: f64,
        /// The real part.
        w: f64 = 1.0,
    }

    /// A position and an orientation.
    #[derive(Copy)]
    Pose "d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa" {
        /// The position, m.
        position: Point,
        /// The orientation.
        orientation: Quaternion,
    }

    /// A pose with time and frame.
    PoseStamped "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8" {
        /// Time and frame.
        header: Header,
        /// The pose.
        pose: Pose,
    }

    /// A pose with covariance.
    #[derive(Copy)]
    PoseWithCovariance "9a7c0fd234b7f45c6098745ecccd773ca1085670e64107135397aee31c02e1bb" {
        /// The pose.
        pose: Pose,
        /// Its covariance, m² and rad².
        covariance: Covariance,
    }

    /// A velocity.
    #[derive(Copy)]
    Twist "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a" {
        /// Linear velocity of the origin, m/s.
        linear: Vector3,
        /// Angular velocity, rad/s.
        angular: Vector3,
    }

    /// A velocity with time and frame.
    TwistStamped "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64" {
        /// Time and frame.
        header: Header,
        /// The velocity.
        twist: Twist,
    }

    /// A velocity with covariance.
    #[derive(Copy)]
    TwistWithCovariance "49f574f033f095d8b6cd1beaca5ca7925e296e84af1716d16c89d38b059c8c18" {
        /// The velocity.
        twist: Twist,
        /// Its covariance, m²/s² and rad²/s².
        covariance: Covariance,
    }

    /// The pose of one frame in another.
    #[derive(Copy)]
    Transform "beb83fbe698636351461f6f35d1abb20010c43d55374d81bd041f1ba2581fddc" {
        /// Its origin, m.
        translation: Vector3,
        /// Its orientation.
        rotation: Quaternion,
    }

    /// The pose of one frame in another, with time.
    TransformStamped "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206" {
        /// Time and frame.
        header: Header,
        /// The child frame.
        child_frame_id: String,
        /// Its pose.
        transform: Transform,
    }

    /// A vector with time and frame, such as the slip velocity of a wheel's contact.
    Vector3Stamped "d4829622288cbb443886e7ea94ea5671a3b1be6bab4ad04224432a65f7d7887a" {
        /// Time and frame.
        header: Header,
        /// The vector.
        vector: Vector3,
    }

    /// A force and a torque.
    #[derive(Copy)]
    Wrench "018e8519d57c16adbe97c9fe1460ef21fec7e31bc541de3d653a35895677ce52" {
        /// The force, N.
        force: Vector3,
        /// The torque, N·m.
        torque: Vector3,
    }

    /// A force and a torque with time and frame.
    WrenchStamped "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77" {
        /// Time and frame.
        header: Header,
        /// The force and the torque.
        wrench: Wrench,
    }
}
