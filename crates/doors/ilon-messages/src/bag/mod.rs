//! Bags: recordings in the format of rosbag2, a folder with an MCAP file and its `metadata.yaml`,
//! for `ros2 bag`, Foxglove, Rerun, PlotJuggler and all other readers of MCAP.
//!
//! Bags are written in the format of Humble (version 5 of the metadata), which every later
//! distribution reads. Their chunks are not compressed, so no C compiler is needed.
//!
//! ```no_run
//! use ilon_messages::bag::{BagWriter, Qos};
//! use ilon_messages::{builtin_interfaces::Time, rosgraph_msgs::Clock};
//!
//! let mut bag = BagWriter::create("out/bag".as_ref())?;
//! bag.declare::<Clock>("/clock", Qos::best_effort(1))?;
//! let clock = Time { sec: 1, nanosec: 0 };
//! bag.write("/clock", &Clock { clock }, 1_000_000_000)?;
//! bag.finish()?;
//! # Ok::<(), ilon_messages::bag::BagError>(())
//! ```

mod error;
mod files;
mod metadata;
mod own;
mod qos;
mod reader;
mod topic;
mod writer;

pub use error::BagError;
pub use own::{is_own, remove_own};
pub use qos::{Durability, Qos, Reliability};
pub use reader::{BagReadError, MessageFault, ReadMessage, Seen, read};
pub use writer::BagWriter;
