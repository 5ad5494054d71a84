//! Input files for the planners of robot contests.
//!
//! PathPlanner and Choreo model a swerve drive: four modules that each push with up to friction x
//! mass x 9.8 / 4, in any direction. A robot on mecanum or omni wheels reaches less in some
//! directions, and its wheel loads shift. So the friction in the files is not the floor's: it is
//! the largest at which this robot can reach from rest every acceleration that the planner's model
//! allows ([`Swerve`]). Road Runner models mecanum wheels and takes the voltage that a motion needs
//! ([`Feedforward`]). Pedro Pathing models them too and takes what its tuners measure.

mod choreo;
mod modules;
mod pathplanner;
mod pedro;
mod road_runner;
mod swerve;

pub use choreo::choreo;
pub use pathplanner::pathplanner;
pub use pedro::pedro;
pub use road_runner::{Feedforward, road_runner};
pub use swerve::{NoSwerve, Swerve};
