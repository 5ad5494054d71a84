//! Text, arrays, colours, and the header with time and frame.

use crate::builtin_interfaces::Time;
use crate::declare::messages;

messages! { std_msgs;
    /// Time and frame of a message.
    #[derive(Eq)]
    Header "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01" {
        /// Time.
        stamp: Time,
        /// The frame, without a leading slash.
        frame_id: std::string::String,
    }

    /// A text, such as a robot's URDF on `/robot_description`.
    #[derive(Eq)]
    String "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18" {
        /// The text.
        data: std::string::String,
    }

    /// A colour with opacity, each part from 0 to 1.
    #[derive(Copy)]
    ColorRGBA "77a7a5b9ae477306097665106e0413ba74440245b1f3d0c6d6405fe5c7813fe8" {
        /// Red.
        r: f32,
        /// Green.
        g: f32,
        /// Blue.
        b: f32,
        /// Opacity: 0 is transparent, 1 is opaque.
        a: f32,
    }

    /// One dimension of an array.
    #[derive(Eq)]
    MultiArrayDimension "5e773a60a4c7fc8a54985f307c7837aa2994252a126c301957a24e31282c9cbe" {
        /// Its label.
        label: std::string::String,
        /// Its size.
        size: u32,
        /// Number of values in this dimension and those after it.
        stride: u32,
    }

    /// Layout of a multi-dimensional array.
    #[derive(Eq)]
    MultiArrayLayout "4c66e6f78e740ac103a94cf63259f968e48c617e7699e829b63c21a5cb50dac6" {
        /// Its dimensions, the slowest-changing first.
        dim: Vec<MultiArrayDimension>,
        /// Number of values before the first valid one.
        data_offset: u32,
    }

    /// Numbers, such as the commands for a group of joints.
    Float64MultiArray "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f" {
        /// Their layout; without dimensions they are a plain list.
        layout: MultiArrayLayout,
        /// The numbers.
        data: Vec<f64>,
    }
}
