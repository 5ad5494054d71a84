//! Converts the text of a scenario to a [`Scenario`](super::Scenario): checks keys against the
//! schema, merges settings, reads sections.

mod load;
mod setting;
mod source;
mod tracked;

pub(crate) use ilon_files::keys::is_computable;
pub use ilon_files::keys::{SIZES, nearest};
pub use load::{MAX_BYTES, read_text, read_toml};
pub use setting::{SETTING, Setting};
pub use source::Source;
