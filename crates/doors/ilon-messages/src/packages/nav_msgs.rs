//! Odometry and paths.

use crate::declare::messages;
use crate::geometry_msgs::{PoseStamped, PoseWithCovariance, TwistWithCovariance};
use crate::std_msgs::Header;

messages! { nav_msgs;
    /// A pose and a velocity, estimated or true.
    Odometry "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0" {
        /// Time, and the frame of the pose.
        header: Header,
        /// The frame with this pose, in which the velocity is given.
        child_frame_id: String,
        /// The pose.
        pose: PoseWithCovariance,
        /// The velocity.
        twist: TwistWithCovariance,
    }

    /// A path, planned or driven.
    Path "1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b" {
        /// Time and frame.
        header: Header,
        /// The poses, in order.
        poses: Vec<PoseStamped>,
    }
}
