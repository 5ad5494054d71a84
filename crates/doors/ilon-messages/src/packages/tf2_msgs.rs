//! The tree of frames.

use crate::declare::messages;
use crate::geometry_msgs::TransformStamped;

messages! { tf2_msgs;
    /// Transforms, for `/tf` and `/tf_static`.
    TFMessage "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087" {
        /// The frames.
        transforms: Vec<TransformStamped>,
    }
}
