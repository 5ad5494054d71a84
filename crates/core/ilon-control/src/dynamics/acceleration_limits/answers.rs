//! Settings and results of the acceleration limits.

/// How the wheels share the body's force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushSharing {
    /// One rate loop per wheel, all with the same gains: [`WheelLoop`](crate::WheelLoop). For
    /// identical wheels [`ComputedTorque`](crate::ComputedTorque) shares in the same way.
    EqualLoops,
    /// Minimises the worst use of grip: [`PrioritisedTorque`](crate::PrioritisedTorque).
    ByGrip,
}

/// Settings that limit a robot's accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitSettings {
    /// Coulomb's coefficient of friction between rollers and ground.
    pub friction: f64,
    /// Gravity in m/s^2.
    pub gravity_m_s2: f64,
    /// Slope of the ground in radians, below 90 degrees; 0 if level.
    pub slope_rad: f64,
    /// Downhill direction in the body frame, in radians from the x axis.
    pub downhill_rad: f64,
    /// How the wheels share the body's force.
    pub sharing: PushSharing,
    /// The share of grip and motor torque that may be used, in (0, 1].
    pub share: f64,
}

/// What limits an acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitCause {
    /// The wheel would slide.
    Grip,
    /// The motor has no more torque.
    Motor,
}

/// The wheel that limits an acceleration, and the cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitedBy {
    /// Index of the wheel in the robot; the first of equally loaded ones.
    pub wheel: usize,
    /// The cause.
    pub cause: LimitCause,
}

/// The largest acceleration along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationLimit {
    /// The acceleration in the direction's units: m/s^2 for a direction (cos, sin, 0), rad/s^2 for
    /// (0, 0, 1). Zero if even the current motion exceeds the limits.
    pub largest: f64,
    /// Index of the limiting wheel in the robot.
    pub wheel: usize,
    /// The cause.
    pub cause: LimitCause,
}

/// The share of the limits that an acceleration needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationUse {
    /// The largest share of its grip or motor torque that a wheel needs; above 1 if impossible.
    /// Infinite if a wheel has none, or if wheels that share by grip lack torque.
    pub share: f64,
    /// The wheel and its cause.
    pub by: LimitedBy,
}

/// The possible accelerations along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationRange {
    /// The smallest, in the line's units.
    pub least: f64,
    /// The largest, in the line's units.
    pub largest: f64,
    /// Limit at the smallest.
    pub least_by: LimitedBy,
    /// Limit at the largest.
    pub largest_by: LimitedBy,
}
