//! Choices of the program where a scenario leaves them open (steps, gains, contacts), checks of
//! loops and wheels before a run, and [`Resolved`].

pub mod bearing_drag;
pub mod defaults;
pub mod loop_stability;
mod resolved;
pub mod stability;
pub mod wheel_loop;
pub mod wheels_to_spare;

use ilon_control::WrongHands;
use ilon_robot::Robot;

pub use resolved::{Choices, Resolved, kinematics_of};

/// Remarks wheels whose handedness does not fit their places.
pub fn wrong_hands(robot: &Robot) -> Option<String> {
    let wrong = WrongHands::of(&robot.wheels);
    wrong.map(|wrong| format!("the wheels: {wrong}"))
}
