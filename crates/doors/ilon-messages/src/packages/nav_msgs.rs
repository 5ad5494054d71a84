//! Where a robot believes to be, and where it is to go.

use crate::declare::messages;
use crate::geometry_msgs::{PoseStamped, PoseWithCovariance, TwistWithCovariance};
use crate::std_msgs::Header;

messages! { nav_msgs;
    /// A pose and a velocity as estimated, or as they truly are.
    Odometry "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0" {
        /// When, and in which frame the pose is.
        header: Header,
        /// Which frame has this pose, and in which the velocity is.
        child_frame_id: String,
        /// The pose.
        pose: PoseWithCovariance,
        /// The velocity.
        twist: TwistWithCovariance,
    }

    /// Poses to drive through, or those driven through.
    Path "1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b" {
        /// When, and in which frame.
        header: Header,
        /// The poses, in order.
        poses: Vec<PoseStamped>,
    }
}
