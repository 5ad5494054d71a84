//! The robot's measurements of its own motion: the truth with delay, sample rate and noise; and the
//! estimates from them.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use ilon_control::Kinematics;
use ilon_robot::{Pose, Robot, wrap_angle};
use ilon_trace::ImuSample;
use ilon_world::World;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::faults::Faults;
use crate::noise::noise;
use crate::sensing::fusion::Fusion;
use crate::sensing::hubs;
use crate::sensing::imu::Imu;
use ilon_scenario::scenario::TIME_SLACK_S;
use ilon_scenario::{Error, scenario};

/// The robot's knowledge at one moment.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Measurements {
    /// The newest pose that has arrived; with fusion, the filter's current estimate.
    pub pose: Pose,
    /// The wheels' rates, in rad/s.
    pub wheel_rates_rad_s: Vec<f64>,
    /// Wheel angles since the start, as counted by the encoders, in rad.
    pub wheel_angles_rad: Vec<f64>,
    /// Positions of the joints between bodies as the robot knows them, in rad or m, in the robot's
    /// order: for a driven joint, and one coupled to it, the encoder's value once a control period.
    /// Free and sprung joints are not measured and count as zero.
    pub joint_positions: Vec<f64>,
    /// The last sample of the inertial measurement unit, and the tilt by its filter; `None` without
    /// one.
    pub imu: Option<ImuSample>,
}

impl Measurements {
    /// A robot at rest, with wheel angles zero.
    pub(crate) fn at(pose: Pose, wheel_count: usize) -> Self {
        Self {
            pose,
            wheel_rates_rad_s: vec![0.0; wheel_count],
            wheel_angles_rad: vec![0.0; wheel_count],
            joint_positions: Vec::new(),
            imu: None,
        }
    }
}

/// The sensors of a robot.
#[derive(Clone)]
pub(crate) struct Sensors {
    pose: scenario::PoseSensor,
    encoders: scenario::Encoders,
    control_dt_s: f64,
    /// Poses taken but not yet arrived.
    on_the_way: VecDeque<Taken>,
    poses_taken: u64,
    fusion: Option<Fusion>,
    imu: Option<Imu>,
    /// Whether the fusion uses the gyroscope's yaw rate.
    by_gyroscope: bool,
    seen: Measurements,
    /// For each joint between bodies, whether the robot knows its position.
    measured_joints: Vec<bool>,
    miscounts: Vec<Miscount>,
    pose_noise: ChaCha8Rng,
    encoder_noise: ChaCha8Rng,
}

/// A pose between the sensor and the robot.
#[derive(Clone)]
struct Taken {
    taken_s: f64,
    arrives_s: f64,
    pose: Pose,
}

/// The errors of an encoder.
#[derive(Clone, Copy, Debug, Default)]
struct Miscount {
    /// The wheel's angle at the last observation, in rad.
    angle_rad: f64,
    /// Accumulated counting error since the start, in rad.
    off_rad: f64,
    /// The noise of its rate until the next control sample, in rad/s.
    rate_noise_rad_s: f64,
    /// For an encoder with counts: the angle at the last control sample, in rad, and the rate
    /// since, in rad/s.
    counted_rad: f64,
    counted_rad_s: f64,
}

impl Sensors {
    /// Sensors of a robot that know the start. Odometry uses `kinematics`, or the kinematics with
    /// moved wheels if joints move them, once a control period.
    ///
    /// # Errors
    /// [`Error::Control`] for invalid filter settings.
    pub fn new(
        section: &scenario::Sensors,
        start: Pose,
        (robot, kinematics): (&Robot, &Kinematics),
        whole: &scenario::Scenario,
    ) -> Result<Self, Error> {
        let run = &whole.run;
        let wheel_count = kinematics.wheel_count();
        let fusion = match &section.fusion {
            Some(fusion) => Some(Fusion::new(
                fusion,
                &section.pose,
                start,
                (robot, kinematics),
                run.control_dt_s,
                run.duration_s,
            )?),
            None => None,
        };
        // One random stream per sensor, so that a change of one leaves the others' noise unchanged.
        let stream = |number| {
            let mut rng = ChaCha8Rng::seed_from_u64(section.seed);
            rng.set_stream(number);
            rng
        };
        let imu = section.imu.as_ref();
        let imu = imu.map(|imu| Imu::new(imu, whole.world.gravity_m_s2, stream(3)));
        Ok(Self {
            imu: imu.transpose()?,
            by_gyroscope: section
                .fusion
                .as_ref()
                .is_some_and(|fusion| fusion.gyroscope),
            pose: section.pose.clone(),
            encoders: section.encoders.clone(),
            control_dt_s: run.control_dt_s,
            on_the_way: VecDeque::new(),
            poses_taken: 0,
            fusion,
            seen: Measurements::at(start, wheel_count),
            measured_joints: hubs::measured(robot),
            miscounts: vec![Miscount::default(); wheel_count],
            pose_noise: stream(1),
            encoder_noise: stream(2),
        })
    }

    /// Observes the world at a physics step.
    pub fn sense(&mut self, t_s: f64, control_is_due: bool, world: &World, faults: &Faults) {
        let pose_is_due = match self.pose.rate_hz {
            Some(rate_hz) => t_s + TIME_SLACK_S >= self.poses_taken as f64 / rate_hz,
            None => control_is_due,
        };
        if pose_is_due {
            self.poses_taken += 1;
            let pose = self.noisy(faults.pose(t_s, world.robot().state().pose));
            if !faults.pose_is_lost(t_s) {
                self.on_the_way.push_back(Taken {
                    taken_s: t_s,
                    arrives_s: t_s + self.pose.latency_s,
                    pose,
                });
            }
        }
        for (wheel, miscount) in self.miscounts.iter_mut().enumerate() {
            let (angle_rad, rate_rad_s) = (
                world.robot().wheel_angles_rad()[wheel],
                world.robot().wheel_rates_rad_s()[wheel],
            );
            let factor = faults.encoder_factor(t_s, wheel);
            miscount.off_rad += (factor - 1.0) * (angle_rad - miscount.angle_rad);
            miscount.angle_rad = angle_rad;
            let mut seen_rad = angle_rad + miscount.off_rad;
            if let Some(counts_per_turn) = self.encoders.counts_per_turn {
                let count_rad = TAU / counts_per_turn;
                seen_rad = (seen_rad / count_rad).floor() * count_rad;
                if control_is_due {
                    let rate_rad_s = (seen_rad - miscount.counted_rad) / self.control_dt_s;
                    let weight =
                        self.control_dt_s / (self.control_dt_s + self.encoders.rate_filter_s);
                    miscount.counted_rad_s += weight * (rate_rad_s - miscount.counted_rad_s);
                    miscount.counted_rad = seen_rad;
                }
            }
            self.seen.wheel_angles_rad[wheel] = seen_rad;
            if control_is_due {
                // Once a control sample, so that shorter physics steps do not average it away.
                miscount.rate_noise_rad_s =
                    noise(&mut self.encoder_noise, self.encoders.rate_noise_rad_s);
            }
            self.seen.wheel_rates_rad_s[wheel] = match self.encoders.counts_per_turn {
                None => factor * (rate_rad_s + miscount.rate_noise_rad_s),
                Some(_) => miscount.counted_rad_s + factor * miscount.rate_noise_rad_s,
            };
        }
        if control_is_due {
            let joints = world.robot().joint_positions().iter();
            let joints = joints.zip(&self.measured_joints);
            let seen = joints.map(|(position, known)| if *known { *position } else { 0.0 });
            self.seen.joint_positions.clear();
            self.seen.joint_positions.extend(seen);
        }
        if let Some(imu) = &mut self.imu {
            imu.sense(t_s, control_is_due, world, faults.tilts());
            self.seen.imu = Some(imu.seen());
        }
        self.receive(t_s, control_is_due);
    }

    /// Gravity in the body frame by the inertial measurement unit, in m/s^2; `None` without one.
    pub fn gravity_in_body_m_s2(&self) -> Option<Vector3<f64>> {
        Some(self.imu.as_ref()?.gravity_in_body_m_s2())
    }

    /// Takes in the poses that have arrived, and updates the odometry if it is fused with them.
    fn receive(&mut self, t_s: f64, control_is_due: bool) {
        let counted: (&[f64], &[f64]) = (&self.seen.wheel_angles_rad, &self.seen.joint_positions);
        let mut gyroscope = self.imu.as_mut().filter(|_| self.by_gyroscope);
        let mut reckon = |fusion: &mut Fusion| {
            let turned_rad = gyroscope.as_mut().map(|imu| imu.take_turned_rad());
            fusion.reckon(t_s, counted, turned_rad);
        };
        if let Some(fusion) = &mut self.fusion
            && control_is_due
        {
            reckon(fusion);
        }
        while let Some(taken) = self.on_the_way.front()
            && taken.arrives_s <= t_s + TIME_SLACK_S
        {
            match &mut self.fusion {
                Some(fusion) => {
                    reckon(fusion);
                    fusion.correct(taken.taken_s, &taken.pose);
                }
                None => self.seen.pose = taken.pose,
            }
            self.on_the_way.pop_front();
        }
        if let Some(fusion) = &self.fusion {
            self.seen.pose = fusion.pose();
        }
    }

    /// The current measurements.
    pub fn seen(&self) -> &Measurements {
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
