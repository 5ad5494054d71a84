//! What limits of acceleration are asked by, and what they answer.

/// How wheels share what the body needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushSharing {
    /// One rate loop a wheel, all of the same gains: [`WheelLoop`](crate::WheelLoop). Of wheels that are alike
    /// [`ComputedTorque`](crate::ComputedTorque) shares in the same way.
    EqualLoops,
    /// With the least worst use of grip: [`PrioritisedTorque`](crate::PrioritisedTorque).
    ByGrip,
}

/// What the accelerations of a robot are limited by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitSettings {
    /// Coulomb's coefficient of friction between rollers and ground.
    pub friction: f64,
    /// Gravity in m/s^2.
    pub gravity_m_s2: f64,
    /// Slope of the ground in radians, below a right angle; 0 where it is level.
    pub slope_rad: f64,
    /// Direction in which it falls, in the body frame, in radians from the x axis.
    pub downhill_rad: f64,
    /// How the wheels share what the body needs.
    pub sharing: PushSharing,
    /// The share of grip and of the motors' torques that may be used, in (0, 1]; 1 for all.
    pub share: f64,
}

/// What holds an acceleration where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitCause {
    /// The wheel would slide.
    Grip,
    /// Its motor has no more torque.
    Motor,
}

/// The wheel that holds an acceleration where it is, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitedBy {
    /// The wheel, by its place in the robot. Of wheels that are used alike the first.
    pub wheel: usize,
    /// What it lacks.
    pub cause: LimitCause,
}

/// The largest acceleration along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationLimit {
    /// It, in the direction's units: m/s^2 for a direction (cos, sin, 0), rad/s^2 for (0, 0, 1). Zero where even standing, or going on
    /// as it goes, takes more than there is.
    pub largest: f64,
    /// The wheel that holds it there, by its place in the robot.
    pub wheel: usize,
    /// Why.
    pub cause: LimitCause,
}

/// How much of what there is an acceleration takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationUse {
    /// The largest share of its grip, or of its motor's torque, that a wheel needs: above 1 where it cannot be had. Infinite where a wheel
    /// has nothing, and where wheels that share by grip lack torque.
    pub share: f64,
    /// Of which wheel, and of what.
    pub by: LimitedBy,
}

/// The accelerations along a line that can be had.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationRange {
    /// The least, in the line's units.
    pub least: f64,
    /// The largest.
    pub largest: f64,
    /// What holds the least.
    pub least_by: LimitedBy,
    /// What holds the largest.
    pub largest_by: LimitedBy,
}
