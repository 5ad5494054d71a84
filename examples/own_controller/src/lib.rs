//! A controller without dependence on ilon: it drives a mecanum robot to a goal and stops there.

/// The pose of a robot, or its goal, in the world.
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
    /// The goal.
    pub goal: Pose,
    /// Half of the wheelbase plus half of the track, in metres.
    pub arm: f64,
    /// In metres.
    pub wheel_radius: f64,
    /// The largest speed, in m/s.
    pub top_speed: f64,
}

impl GoToGoal {
    /// Wheel rates in rad/s at the robot's pose.
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
