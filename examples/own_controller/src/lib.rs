//! A controller that knows nothing of ilon: drives a mecanum robot towards a goal and stops there.

/// Where a robot is, or should be, in the world.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// In metres.
    pub x: f64,
    /// In metres.
    pub y: f64,
    /// In radians.
    pub heading: f64,
}

/// A four-wheeled mecanum robot: wheels front left, front right, rear left, rear right.
#[derive(Clone, Copy, Debug)]
pub struct GoToGoal {
    /// Where to go.
    pub goal: Pose,
    /// Half of the wheelbase plus half of the track, in metres.
    pub arm: f64,
    /// In metres.
    pub wheel_radius: f64,
    /// The fastest that it goes, in m/s.
    pub top_speed: f64,
}

impl GoToGoal {
    /// Wheel rates in rad/s for where the robot is.
    pub fn wheel_rates(&self, here: Pose) -> [f64; 4] {
        let (dx, dy) = (self.goal.x - here.x, self.goal.y - here.y);
        let (sin, cos) = here.heading.sin_cos();
        let slow_down = self.top_speed / dx.hypot(dy).max(self.top_speed);
        let forward = slow_down * (cos * dx + sin * dy);
        let left = slow_down * (cos * dy - sin * dx);
        let turn = (self.goal.heading - here.heading).sin() * self.arm;
        [
            forward - left - turn,
            forward + left + turn,
            forward + left - turn,
            forward - left + turn,
        ]
        .map(|speed| speed / self.wheel_radius)
    }
}
