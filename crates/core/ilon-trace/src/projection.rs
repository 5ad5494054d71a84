//! Which signals of a row are read.

/// Which signals are looked at: reading the others from a file takes time for nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// All of them.
    All,
    /// Those of the robot, not of its wheels.
    Robot,
    /// Those of one wheel, and the time.
    Wheel(usize),
}
