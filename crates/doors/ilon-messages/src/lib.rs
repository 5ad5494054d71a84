//! The ROS 2 messages that ilon writes and reads, without a ROS installation.
//!
//! Each message is a struct in a module with its ROS package's name, such as
//! [`geometry_msgs::Twist`]. One declaration gives its fields, its encoding, its definition text
//! ([`Message::definition`]) and its type hash. Messages are encoded as CDR for the wire and for
//! files ([`Message::encode`], [`Message::decode`]), and through `serde` as JSON and for other
//! middleware.
//!
//! [`topics`] converts a run of ilon to topics and to a bag.
//!
//! The encoding is the same in every distribution from Humble to Lyrical.
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
