//! What makes a difference to a run: the run repeated with one thing changed, its twin.

mod halves;
mod twin;

pub(crate) use halves::Halves;
