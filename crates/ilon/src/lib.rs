//! ilon simulates omnidirectional robots down to the rollers of their wheels.

mod error;
pub mod judge;
pub mod scenario;

pub use error::Error;
pub use scenario::Scenario;
