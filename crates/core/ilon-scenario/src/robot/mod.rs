//! The robot of a scenario: reading its file, remedies for a refused file, and the controller's
//! belief.

pub mod belief;
mod load;
pub mod remedy;

pub use load::{load, load_file, load_robot};

use ilon_robot::Robot;

use crate::Error;
use crate::scenario::nearest;

/// The index of a wheel by its joint's name; `what` is the context for a message.
///
/// # Errors
/// [`Error::Invalid`] for a wheel that the robot does not have.
pub fn wheel_index(name: &str, robot: &Robot, what: &str) -> Result<usize, Error> {
    let names = || robot.wheels.iter().map(|wheel| wheel.name.as_str());
    names().position(|known| known == name).ok_or_else(|| {
        Error::invalid(
            format!("{what} about the wheel `{name}`, which the robot does not have"),
            match nearest(name, names()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("its wheels are {}", names().collect::<Vec<_>>().join(", ")),
            },
        )
    })
}
