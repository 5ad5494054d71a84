//! The inertial measurement unit, and the robot's tilt filter.

use std::collections::VecDeque;

use ilon_control::{InertialErrors, TiltFilter};
use ilon_trace::{ImuSample, ImuVariances};
use ilon_world::World;
use nalgebra::{UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::faults::tilt::Tilts;
use crate::noise::noise;
use ilon_scenario::Error;
use ilon_scenario::scenario::{self, ImuNoise, TIME_SLACK_S};

/// The sensor, and the robot's filter behind it.
#[derive(Clone)]
pub(crate) struct Imu {
    section: scenario::Imu,
    gravity_m_s2: f64,
    /// Rotation of the sensor's axes against those that the robot assumes.
    body_from_sensor: UnitQuaternion<f64>,
    /// Floor and body at the last sample, and the sensor's velocity.
    last: Option<Motion>,
    taken: u64,
    on_the_way: VecDeque<Taken>,
    accelerometer_bias: Vector3<f64>,
    gyroscope_bias: Vector3<f64>,
    filter: TiltFilter,
    rng: ChaCha8Rng,
    seen: ImuSample,
    /// Total time covered by samples, in seconds.
    heard_s: f64,
    /// Rotation by the gyroscope since the last query, in rad.
    turned_rad: f64,
}

#[derive(Clone, Copy)]
struct Motion {
    t_s: f64,
    level_from_body: UnitQuaternion<f64>,
    velocity_in_floor_m_s: Vector3<f64>,
}

#[derive(Clone, Copy)]
struct Taken {
    arrives_s: f64,
    over_s: f64,
    rate_rad_s: Vector3<f64>,
    specific_force_m_s2: Vector3<f64>,
}

/// A vector of normally distributed numbers.
fn vector(rng: &mut ChaCha8Rng, standard_deviation: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| noise(rng, standard_deviation))
}

impl Imu {
    /// A sensor without samples; the robot assumes level ground.
    ///
    /// # Errors
    /// [`Error::Control`] for invalid filter settings.
    pub fn new(
        section: &scenario::Imu,
        gravity_m_s2: f64,
        mut rng: ChaCha8Rng,
    ) -> Result<Self, Error> {
        let accelerometer_bias = vector(&mut rng, section.accelerometer.bias);
        let gyroscope_bias = vector(&mut rng, section.gyroscope.bias);
        Ok(Self {
            body_from_sensor: UnitQuaternion::from_euler_angles(
                section.roll_deg.to_radians(),
                section.pitch_deg.to_radians(),
                0.0,
            ),
            filter: TiltFilter::new(section.filter_s)?,
            section: section.clone(),
            gravity_m_s2,
            last: None,
            taken: 0,
            on_the_way: VecDeque::new(),
            accelerometer_bias,
            gyroscope_bias,
            rng,
            seen: ImuSample::default(),
            heard_s: 0.0,
            turned_rad: 0.0,
        })
    }

    /// Observes the world at a physics step.
    pub fn sense(&mut self, t_s: f64, control_is_due: bool, world: &World, tilts: &Tilts) {
        let is_due = match self.section.rate_hz {
            Some(rate_hz) => t_s + TIME_SLACK_S >= self.taken as f64 / rate_hz,
            None => control_is_due,
        };
        if is_due {
            self.taken += 1;
            self.take(t_s, world, tilts);
        }
        while let Some(taken) = self.on_the_way.front().copied()
            && taken.arrives_s <= t_s + TIME_SLACK_S
        {
            self.on_the_way.pop_front();
            self.receive(&taken);
        }
    }

    /// Takes a sample: mean rotation and specific force since the last.
    fn take(&mut self, t_s: f64, world: &World, tilts: &Tilts) {
        let section = &self.section;
        let place_m = Vector3::new(section.x_m, section.y_m, section.z_m);
        let motion = world.robot().motion_at(&place_m);
        let now = Motion {
            t_s,
            level_from_body: tilts.turned(t_s) * motion.floor_from_body,
            velocity_in_floor_m_s: motion.velocity_in_floor_m_s,
        };
        let last = self.last.replace(now).unwrap_or(now);
        let over_s = now.t_s - last.t_s;
        let (mut turn, mut gained) = (Vector3::zeros(), Vector3::zeros());
        if over_s > 0.0 {
            turn = (last.level_from_body.inverse() * now.level_from_body).scaled_axis() / over_s;
            gained = (now.velocity_in_floor_m_s - last.velocity_in_floor_m_s) / over_s;
            let walked_s = libm::sqrt(over_s);
            let walk = |of: &ImuNoise| of.bias_walk * walked_s;
            self.accelerometer_bias += vector(&mut self.rng, walk(&section.accelerometer));
            self.gyroscope_bias += vector(&mut self.rng, walk(&section.gyroscope));
        }
        let pulled = motion.floor_from_body.inverse() * (gained - world.gravity_in_world_m_s2());
        let sensor_from_body = self.body_from_sensor.inverse();
        let turn = sensor_from_body * turn + self.gyroscope_bias;
        let force = sensor_from_body * pulled + self.accelerometer_bias;
        self.on_the_way.push_back(Taken {
            arrives_s: t_s + section.latency_s,
            over_s,
            rate_rad_s: turn + vector(&mut self.rng, section.gyroscope.noise),
            specific_force_m_s2: force + vector(&mut self.rng, section.accelerometer.noise),
        });
    }

    fn receive(&mut self, taken: &Taken) {
        // The first sample covers no time: it only defines the vertical.
        let over_s = taken.over_s.max(f64::MIN_POSITIVE);
        self.filter
            .update(&taken.rate_rad_s, &taken.specific_force_m_s2, over_s);
        self.turned_rad += taken.rate_rad_s.z * taken.over_s;
        self.heard_s += taken.over_s;
        let down = self.filter.down_in_body();
        self.seen = ImuSample {
            rate_rad_s: taken.rate_rad_s,
            specific_force_m_s2: taken.specific_force_m_s2,
            roll_rad: libm::atan2(-down.y, -down.z),
            pitch_rad: libm::atan2(down.x, libm::hypot(down.y, down.z)),
            variances: Some(self.variances(taken.over_s)),
        };
    }

    /// The variances of a sample that covers `over_s` seconds. The mounting error is unknown to the
    /// robot, and not part of it.
    fn variances(&self, over_s: f64) -> ImuVariances {
        let errors = |of: &ImuNoise| InertialErrors {
            noise: of.noise,
            bias: of.bias,
            bias_walk: of.bias_walk,
        };
        let gyroscope = errors(&self.section.gyroscope);
        let accelerometer = errors(&self.section.accelerometer);
        ImuVariances {
            rate_rad2_s2: gyroscope.variance(self.heard_s),
            specific_force_m2_s4: accelerometer.variance(self.heard_s),
            tilt_rad2: self.filter.variance_rad2(
                &gyroscope,
                &accelerometer,
                self.gravity_m_s2,
                (over_s, self.heard_s),
            ),
        }
    }

    /// The last sample, and the tilt by the filter.
    pub fn seen(&self) -> ImuSample {
        self.seen
    }

    /// Gravity in the body frame by the filter, in m/s^2.
    pub fn gravity_in_body_m_s2(&self) -> Vector3<f64> {
        self.gravity_m_s2 * self.filter.down_in_body()
    }

    /// Rotation by the gyroscope since the last call, in rad.
    pub fn take_turned_rad(&mut self) -> f64 {
        std::mem::take(&mut self.turned_rad)
    }
}
