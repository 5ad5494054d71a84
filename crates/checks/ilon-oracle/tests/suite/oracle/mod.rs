//! ilon's slip against the oracle's: two engines that share only the robot's description
//! (docs/measured.md).

mod axles;
mod case;
mod cases;
mod course;
mod engines;
mod figures;
mod identify;
mod identify_keys;
mod joints;
mod limit;
mod logs;
mod passive;
mod play;
mod rollers_as_made;
mod spin;
mod table;
mod transients;
mod tread;
mod tyres;
