//! A robot as the planners of robot contests take it.
//!
//! PathPlanner and Choreo know a swerve drive: four modules that each push with up to friction x mass x 9.8 / 4, in any direction. A robot on
//! mecanum or omni wheels can do less in some directions, and its loads shift. So the friction that they are given is not the floor's, but the
//! largest with which every acceleration that their model allows is one that this robot has from rest ([`Swerve`]). Road Runner knows mecanum
//! wheels, and takes the voltage that a motion needs ([`Feedforward`]); Pedro Pathing knows them too, and takes what its tuners measure.

mod choreo;
mod pathplanner;
mod pedro;
mod road_runner;
mod swerve;

pub use choreo::choreo;
pub use pathplanner::pathplanner;
pub use pedro::pedro;
pub use road_runner::{Feedforward, road_runner};
pub use swerve::{NoSwerve, Swerve};
