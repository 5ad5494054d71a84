//! Selects the signals of a row that are read.

/// Which signals are needed. Reading the others from a file would waste time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// All signals.
    All,
    /// Those of the robot, without those of its wheels.
    Robot,
    /// Those of one wheel, and the time.
    Wheel(usize),
}
