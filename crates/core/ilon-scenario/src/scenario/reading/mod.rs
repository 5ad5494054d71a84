//! How the text of a scenario becomes a [`Scenario`](super::Scenario): its keys checked against the schema, settings laid over it, sections read.

mod keys;
mod load;
mod setting;
mod source;
mod tracked;

pub(crate) use keys::is_computable;
pub use keys::{SIZES, nearest};
pub use load::{MAX_BYTES, read_toml};
pub use setting::{SETTING, Setting};
pub use source::Source;
