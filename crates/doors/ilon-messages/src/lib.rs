//! The ROS 2 messages that ilon writes and reads, without a ROS installation.
//!
//! Each message is a struct under the name of its ROS package, such as [`geometry_msgs::Twist`]. From one declaration come its
//! fields, its encoding, the text of its definition ([`Message::definition`]) and what its type hash stands for. A message goes
//! over the wire and into files as CDR ([`Message::encode`], [`Message::decode`]); through its `serde` implementations it goes
//! into JSON, and into the middleware of others.
//!
//! A run of ilon becomes topics, and a bag, by [`topics`].
//!
//! The messages are the same on the wire in every distribution from Humble to Lyrical.
//!
//! ```
//! use ilon_messages::{Message, geometry_msgs::Twist};
//!
//! let mut twist = Twist::default();
//! twist.linear.x = 0.5;
//! let bytes = twist.encode()?;
//! assert_eq!(Twist::decode(&bytes)?, twist);
//! # Ok::<(), ilon_messages::CdrError>(())
//! ```

pub mod bag;
mod cdr;
mod declare;
mod description;
mod field;
mod message;
mod packages;
pub mod topics;

pub use cdr::{CdrError, CdrReader, CdrWriter};
pub use description::{Constant, Description, FieldDescription, FieldType, Shape, ValueType};
pub use field::Field;
pub use message::Message;
pub use packages::messages;
pub use packages::*;
