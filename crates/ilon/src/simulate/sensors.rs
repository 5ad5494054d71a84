//! What the robot sees of its own motion: the truth, late, now and then, and with noise.

use std::collections::VecDeque;

use ilon_robot::{Pose, wrap_angle};
use ilon_world::World;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::faults::Faults;
use crate::scenario;

/// What the robot knows at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// The newest pose that has arrived.
    pub pose: Pose,
    /// The wheels' rates, in rad/s.
    pub wheel_rates_rad_s: Vec<f64>,
    /// The wheels' angles since the start, as the encoders counted them, in rad.
    pub wheel_angles_rad: Vec<f64>,
}

impl Seen {
    /// A robot at rest, its wheels at angle zero.
    pub(super) fn at(pose: Pose, wheel_count: usize) -> Self {
        Self {
            pose,
            wheel_rates_rad_s: vec![0.0; wheel_count],
            wheel_angles_rad: vec![0.0; wheel_count],
        }
    }
}

/// The sensors of a robot.
pub(super) struct Sensors {
    pose: scenario::PoseSensor,
    rate_noise_rad_s: f64,
    /// Poses taken but not yet arrived, with the time at which they arrive.
    on_the_way: VecDeque<(f64, Pose)>,
    poses_taken: u64,
    seen: Seen,
    miscounts: Vec<Miscount>,
    pose_noise: ChaCha8Rng,
    encoder_noise: ChaCha8Rng,
}

/// What an encoder that counted wrong has lost or gained.
#[derive(Clone, Copy, Debug, Default)]
struct Miscount {
    /// The wheel's angle when it was last looked at, in rad.
    angle_rad: f64,
    /// What was counted too much since the start, in rad.
    off_rad: f64,
}

/// Slack on times, in seconds, that keeps the rounding of sums from delaying a sample by a whole step.
const TIME_SLACK_S: f64 = 1e-9;

impl Sensors {
    /// Sensors that know the start.
    pub fn new(section: &scenario::Sensors, start: Pose, wheel_count: usize) -> Self {
        // One stream of random numbers a sensor, so that a change of one leaves the others' noise as it was.
        let stream = |number| {
            let mut rng = ChaCha8Rng::seed_from_u64(section.seed);
            rng.set_stream(number);
            rng
        };
        Self {
            pose: section.pose.clone(),
            rate_noise_rad_s: section.encoders.rate_noise_rad_s,
            on_the_way: VecDeque::new(),
            poses_taken: 0,
            seen: Seen::at(start, wheel_count),
            miscounts: vec![Miscount::default(); wheel_count],
            pose_noise: stream(1),
            encoder_noise: stream(2),
        }
    }

    /// Looks at the world at a physics step.
    pub fn sense(&mut self, t_s: f64, control_is_due: bool, world: &World, faults: &Faults) {
        let pose_is_due = match self.pose.rate_hz {
            Some(rate_hz) => t_s + TIME_SLACK_S >= self.poses_taken as f64 / rate_hz,
            None => control_is_due,
        };
        if pose_is_due {
            self.poses_taken += 1;
            let pose = self.noisy(faults.pose(t_s, world.body().pose));
            if !faults.pose_is_lost(t_s) {
                self.on_the_way.push_back((t_s + self.pose.latency_s, pose));
            }
        }
        while let Some((arrives_s, pose)) = self.on_the_way.front()
            && *arrives_s <= t_s + TIME_SLACK_S
        {
            self.seen.pose = *pose;
            self.on_the_way.pop_front();
        }
        for (wheel, miscount) in self.miscounts.iter_mut().enumerate() {
            let (angle_rad, rate_rad_s) = (
                world.wheel_angles_rad()[wheel],
                world.wheel_rates_rad_s()[wheel],
            );
            let factor = faults.encoder_factor(t_s, wheel);
            miscount.off_rad += (factor - 1.0) * (angle_rad - miscount.angle_rad);
            miscount.angle_rad = angle_rad;
            self.seen.wheel_angles_rad[wheel] = angle_rad + miscount.off_rad;
            let noise_rad_s = noise(&mut self.encoder_noise, self.rate_noise_rad_s);
            self.seen.wheel_rates_rad_s[wheel] = factor * (rate_rad_s + noise_rad_s);
        }
    }

    /// What the robot knows now.
    pub fn seen(&self) -> &Seen {
        &self.seen
    }

    fn noisy(&mut self, pose: Pose) -> Pose {
        let heading_noise_rad = self.pose.heading_noise_deg.to_radians();
        let rng = &mut self.pose_noise;
        Pose {
            x_m: pose.x_m + noise(rng, self.pose.position_noise_m),
            y_m: pose.y_m + noise(rng, self.pose.position_noise_m),
            heading_rad: match heading_noise_rad {
                0.0 => pose.heading_rad,
                sigma_rad => wrap_angle(pose.heading_rad + noise(rng, sigma_rad)),
            },
        }
    }
}

/// A normally distributed number of mean zero; zero, and nothing drawn, for a deviation of zero.
fn noise(rng: &mut ChaCha8Rng, standard_deviation: f64) -> f64 {
    if standard_deviation == 0.0 {
        return 0.0;
    }
    let unit: f64 = StandardNormal.sample(rng);
    standard_deviation * unit
}
