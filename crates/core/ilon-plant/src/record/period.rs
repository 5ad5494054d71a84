//! Means and extremes between two rows.

use ilon_trace::{BodySample, JointSample, MAX_BODIES, MAX_JOINTS, Support, WheelSample};
use ilon_world::{WheelTally, World};
use nalgebra::Vector2;

use crate::bodies;

/// Sums and extremes over the physics steps since the last row.
pub(crate) struct Period {
    time_s: f64,
    /// Largest residual of the laws of contact, in m/s.
    pub residual_m_s: f64,
    wheels: Vec<WheelTally>,
    loops: Vec<LoopTally>,
    joints: Vec<JointTally>,
    bodies: Vec<PushTally>,
    carried: Carried,
}

/// How far a wheel's rate is from the commanded one.
#[derive(Clone, Copy, Default)]
struct LoopTally {
    /// `None` where nothing commands the wheel.
    target_rad_s: Option<f64>,
    /// The rate after the last physics step.
    rate_rad_s: f64,
    /// The time integral of the squared difference, in rad^2/s.
    off_rad2_s: f64,
}

impl LoopTally {
    /// Adds a physics step in which the rate changed evenly.
    fn add(&mut self, rate_rad_s: f64, dt_s: f64) {
        let before_rad_s = std::mem::replace(&mut self.rate_rad_s, rate_rad_s);
        if let Some(target_rad_s) = self.target_rad_s {
            let [before, after] = [before_rad_s, rate_rad_s].map(|rate| rate - target_rad_s);
            self.off_rad2_s += (before * before + before * after + after * after) / 3.0 * dt_s;
        }
    }
}

/// Sums over a joint, in rad and N m for a revolute joint, in m and N for a prismatic one.
#[derive(Clone, Copy)]
struct JointTally {
    position: [f64; 2],
    force: [f64; 2],
    impulse: f64,
}

/// Forces of robots on a free body: the time integral of the magnitude in N s, and the largest in
/// N.
#[derive(Clone, Copy, Default)]
struct PushTally {
    sum_n_s: f64,
    largest_n: f64,
}

/// Sums over the whole robot: impulses in the world frame, in N s.
#[derive(Clone, Copy, Default)]
struct Carried {
    wheels_n_s: f64,
    chassis_n_s: f64,
    obstacles_n_s: Vector2<f64>,
}

/// No values: the minimum is above and the maximum below all numbers.
const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

fn take_in([low, high]: &mut [f64; 2], value: f64) {
    (*low, *high) = (low.min(value), high.max(value));
}

impl Default for JointTally {
    fn default() -> Self {
        Self {
            position: NONE,
            force: NONE,
            impulse: 0.0,
        }
    }
}

impl Carried {
    /// Means over a time along a heading, in N.
    fn means(&self, time_s: f64, heading_rad: f64) -> Support {
        if time_s <= 0.0 {
            return Support::default();
        }
        let (sin, cos) = libm::sincos(heading_rad);
        let obstacles_n = self.obstacles_n_s / time_s;
        Support {
            wheels_n: self.wheels_n_s / time_s,
            chassis_n: self.chassis_n_s / time_s,
            obstacles_x_n: cos * obstacles_n.x + sin * obstacles_n.y,
            obstacles_y_n: cos * obstacles_n.y - sin * obstacles_n.x,
        }
    }
}

impl Period {
    /// For a robot with this many wheels and joints between bodies, without data.
    pub fn new(wheels: usize, joints: usize) -> Self {
        Self {
            time_s: 0.0,
            residual_m_s: 0.0,
            wheels: vec![WheelTally::default(); wheels],
            loops: vec![LoopTally::default(); wheels],
            joints: vec![JointTally::default(); joints.min(MAX_JOINTS)],
            bodies: Vec::new(),
            carried: Carried::default(),
        }
    }

    /// Restarts the sums.
    pub fn clear(&mut self) {
        self.time_s = 0.0;
        self.residual_m_s = 0.0;
        self.wheels.fill(WheelTally::default());
        self.loops.iter_mut().for_each(|of| of.off_rad2_s = 0.0);
        self.joints.fill(JointTally::default());
        self.bodies.fill(PushTally::default());
        self.carried = Carried::default();
    }

    /// Adds a physics step that was taken.
    pub fn count(&mut self, world: &World, dt_s: f64) {
        let robot = world.robot();
        self.time_s += dt_s;
        self.residual_m_s = self.residual_m_s.max(world.contact_residual_m_s());
        for (sum, step) in self.wheels.iter_mut().zip(robot.wheel_tallies()) {
            sum.add(step);
        }
        for (sum, rate_rad_s) in self.loops.iter_mut().zip(robot.wheel_rates_rad_s()) {
            sum.add(*rate_rad_s, dt_s);
        }
        let joints = robot.joint_positions().iter().zip(robot.joint_forces());
        for (sum, (position, force)) in self.joints.iter_mut().zip(joints) {
            take_in(&mut sum.position, *position);
            take_in(&mut sum.force, *force);
            sum.impulse += force * dt_s;
        }
        let recorded = world.free_bodies().len().min(MAX_BODIES);
        self.bodies.resize(recorded, PushTally::default());
        for (sum, push_n) in self.bodies.iter_mut().zip(bodies::pushes_n(world)) {
            sum.sum_n_s += push_n * dt_s;
            sum.largest_n = sum.largest_n.max(push_n);
        }
        let support = robot.support();
        self.carried.wheels_n_s += support.wheels_n * dt_s;
        self.carried.chassis_n_s += support.chassis_n * dt_s;
        self.carried.obstacles_n_s += support.obstacles_n * dt_s;
    }

    /// The ground's forces on the robot as a whole, along a heading in radians.
    pub fn support(&self, heading_rad: f64) -> Support {
        self.carried.means(self.time_s, heading_rad)
    }

    /// Begins to compare a wheel's rate with the rate that is commanded from now on, if any is.
    pub fn command(&mut self, wheel: usize, target_rad_s: Option<f64>, rate_rad_s: f64) {
        let of = &mut self.loops[wheel];
        (of.target_rad_s, of.rate_rad_s) = (target_rad_s, rate_rad_s);
    }

    /// Writes a wheel's means and extremes into its sample, which already has the state.
    pub fn put_wheel(&self, wheel: usize, sample: &mut WheelSample) {
        let tally = &self.wheels[wheel];
        if tally.time_s() <= 0.0 {
            sample.hub_height_min_m = sample.hub_height_m;
            sample.hub_height_max_m = sample.hub_height_m;
            return;
        }
        let (place_m, force_n) = (tally.place_mean_in_body_m(), tally.force_mean_in_body_n());
        let sliding_m_s = tally.sliding_mean_in_body_m_s();
        *sample = WheelSample {
            rate_error_rms_rad_s: (self.loops[wheel].off_rad2_s / tally.time_s()).sqrt(),
            torque_n_m: tally.torque_mean_n_m(),
            torque_min_n_m: tally.torque_n_m[0],
            torque_max_n_m: tally.torque_n_m[1],
            hub_height_min_m: tally.hub_height_m[0],
            hub_height_max_m: tally.hub_height_m[1],
            touching_share: tally.touching_share(),
            contact_x_m: place_m.x,
            contact_y_m: place_m.y,
            normal_force_n: tally.normal_force_mean_n(),
            normal_force_min_n: tally.normal_force_n[0],
            normal_force_max_n: tally.normal_force_n[1],
            force_x_n: force_n.x,
            force_y_n: force_n.y,
            friction: tally.friction_mean(),
            friction_used_max: tally.friction_used_max,
            slip_x_m_s: sliding_m_s.x,
            slip_y_m_s: sliding_m_s.y,
            slip_speed_rms_m_s: tally.sliding_rms_m_s(),
            slip_speed_max_m_s: tally.sliding_max_m_s,
            ..*sample
        };
    }

    /// Samples of the joints between the robot's bodies.
    pub fn joints(&self, world: &World) -> [JointSample; MAX_JOINTS] {
        let robot = world.robot();
        let mut samples = [JointSample::default(); MAX_JOINTS];
        let states = robot.joint_positions().iter().zip(robot.joint_rates());
        let found = states.zip(&self.joints);
        for (sample, ((position, rate), tally)) in samples.iter_mut().zip(found) {
            let mut positions = tally.position;
            take_in(&mut positions, *position);
            *sample = JointSample {
                position: *position,
                position_min: positions[0],
                position_max: positions[1],
                rate: *rate,
                ..JointSample::default()
            };
            if self.time_s > 0.0 {
                sample.force = tally.impulse / self.time_s;
                [sample.force_min, sample.force_max] = tally.force;
            }
        }
        samples
    }

    /// Samples of the free bodies.
    pub fn bodies(&self, world: &World) -> [BodySample; MAX_BODIES] {
        let mut samples = bodies::samples(world);
        if self.time_s > 0.0 {
            for (sample, push) in samples.iter_mut().zip(&self.bodies) {
                sample.push_n = push.sum_n_s / self.time_s;
                sample.push_max_n = push.largest_n;
            }
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot with its heading along the world's y axis has the world's x axis to its right.
    #[test]
    fn what_obstacles_push_is_along_the_robots_own_axes() {
        let carried = Carried {
            obstacles_n_s: Vector2::new(3.0, 4.0),
            ..Carried::default()
        };
        let means = carried.means(0.5, std::f64::consts::FRAC_PI_2);
        // The cosine of a rounded right angle is 6e-17.
        assert!((means.obstacles_x_n - 8.0).abs() < 1e-14);
        assert!((means.obstacles_y_n + 6.0).abs() < 1e-14);
    }
}
