//! An extended Kalman filter that combines wheel odometry with late, noisy poses (of a camera,
//! say).
//!
//! Section IV closes the guidance loop on such an estimate, "the integration of odometry and an
//! omnidirectional vision system", without saying how the two are combined. This is the textbook
//! method (S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", 2005, chapters 3.3 and 7.4),
//! with the pose itself as the measurement.
//!
//! **State** x = (x, y, phi) of the body frame in the world, with covariance P.
//!
//! **Odometry.** The wheels' rotation gives a displacement (d_x, d_y, d_phi) in the body frame,
//! which moves the pose along an arc ([`Pose::moved`]). With (w_x, w_y) the displacement of the
//! body's origin in the world, F = dx+/dx = [1 0 -w_y; 0 1 w_x; 0 0 1] and P+ = F P F^T + Q. Slip
//! is random and accumulates, so Q grows with the distance that the wheels roll: Q = way
//! diag(q_r^2, q_r^2, q_phi^2), way = |d| + size |d_phi|.
//!
//! **A pose** z = x + noise of covariance R: K = P (P + R)^-1, x+ = x + K (z - x), P+ = (1 - K) P
//! (1 - K)^T + K R K^T (Joseph's form, which stays symmetric positive definite under rounding).
//! Heading differences are wrapped.
//!
//! **Delay.** A pose describes the robot at the time of measurement. The last displacements and
//! estimates are kept: a pose is applied at its own time, and the later displacements are replayed
//! on the corrected estimate. The result is exactly that of a pose which arrives at once, as long
//! as poses arrive in the order of measurement.

use std::collections::VecDeque;

use ilon_robot::{Pose, Twist, wrap_angle};
use nalgebra::{Matrix3, Vector3};

use crate::ControlError;
use crate::error::{not_negative, positive};

/// Assumed errors of odometry and measured poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseFilterSettings {
    /// Standard deviation of a measured x and of a measured y, in metres, > 0.
    pub measured_position_m: f64,
    /// Standard deviation of a measured heading, in radians, > 0.
    pub measured_heading_rad: f64,
    /// q_r: standard deviation of x and of y by odometry after the wheels have rolled 1 m, in
    /// metres. It grows with the root of the distance.
    pub drift_position_m: f64,
    /// q_phi: standard deviation of the heading by odometry after the wheels have rolled 1 m, in
    /// radians.
    pub drift_heading_rad: f64,
    /// Distance of the wheels from the body's origin in metres: how far they roll per radian of
    /// rotation.
    pub size_m: f64,
    /// Number of odometry steps kept, [`PoseFilter::MOST_STEPS`] at most: an older pose comes too
    /// late.
    pub memory: usize,
}

/// A pose with its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// The most likely pose of the body frame in the world.
    pub pose: Pose,
    /// Covariance of x (m), y (m) and heading (rad).
    pub covariance: Matrix3<f64>,
}

/// Dead reckoning corrected by poses that arrive late.
#[derive(Clone, Debug)]
pub struct PoseFilter {
    settings: PoseFilterSettings,
    /// R.
    measured: Matrix3<f64>,
    /// The steps that are kept, oldest first; never empty.
    steps: VecDeque<Step>,
    /// Measurement time of the last pose used, in seconds.
    corrected_s: f64,
}

/// One step of odometry and the estimate at its end.
#[derive(Clone, Copy, Debug)]
struct Step {
    end_s: f64,
    displacement_in_body: Twist,
    estimate: PoseEstimate,
}

impl PoseFilter {
    /// Largest number of odometry steps kept. Memory for all of them, about 130 bytes each, is
    /// allocated at construction.
    pub const MOST_STEPS: usize = 1_000_000;

    /// Starts from a known pose at a time in seconds.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`], [`ControlError::Negative`], [`ControlError::TooLarge`] for
    /// settings out of range.
    pub fn new(
        start_s: f64,
        start: Pose,
        settings: &PoseFilterSettings,
    ) -> Result<Self, ControlError> {
        let position_m = positive(
            "the deviation of a measured position in m",
            settings.measured_position_m,
        )?;
        let heading_rad = positive(
            "the deviation of a measured heading in rad",
            settings.measured_heading_rad,
        )?;
        not_negative(
            "the drift of the position by odometry in m",
            settings.drift_position_m,
        )?;
        not_negative(
            "the drift of the heading by odometry in rad",
            settings.drift_heading_rad,
        )?;
        not_negative("the robot's size in m", settings.size_m)?;
        let memory = "the filter's memory in steps";
        positive(memory, settings.memory as f64)?;
        if settings.memory > Self::MOST_STEPS {
            return Err(ControlError::TooLarge {
                what: memory.to_owned(),
                value: settings.memory as f64,
                most: Self::MOST_STEPS as f64,
            });
        }
        // One more for a split step.
        let mut steps = VecDeque::with_capacity(settings.memory + 2);
        steps.push_back(Step {
            end_s: start_s,
            displacement_in_body: Twist::default(),
            estimate: PoseEstimate {
                pose: start,
                covariance: Matrix3::zeros(),
            },
        });
        Ok(Self {
            settings: *settings,
            measured: variances(position_m, heading_rad),
            steps,
            corrected_s: start_s,
        })
    }

    /// Sets the distance of the wheels from the body's origin in metres (how far they roll per
    /// radian of rotation), for a robot whose joints move them. Negative values and NaN are
    /// ignored.
    pub fn resize(&mut self, size_m: f64) {
        if size_m.is_finite() && size_m >= 0.0 {
            self.settings.size_m = size_m;
        }
    }

    /// The estimate at the time of the last odometry step.
    pub fn estimate(&self) -> PoseEstimate {
        let start = PoseEstimate {
            pose: Pose::default(),
            covariance: Matrix3::zeros(),
        };
        self.steps.back().map_or(start, |step| step.estimate)
    }

    /// Advances by odometry to a time in seconds: `displacement_in_body` is the displacement by the
    /// wheels since the last call (metres and radians in the components of a twist). A time that is
    /// not later, or a displacement that is not finite, is ignored.
    pub fn predict(&mut self, now_s: f64, displacement_in_body: Twist) {
        let Some(last) = self.steps.back() else {
            return;
        };
        if now_s > last.end_s && is_finite(&displacement_in_body) {
            let estimate = self.propagated(&last.estimate, displacement_in_body);
            self.keep(
                self.steps.len(),
                Step {
                    end_s: now_s,
                    displacement_in_body,
                    estimate,
                },
            );
        }
    }

    /// Applies a pose measured at `taken_s`, now or earlier. Returns whether it was used: not if it
    /// is older than an earlier pose or than the steps kept, or not finite.
    pub fn correct(&mut self, taken_s: f64, measured: &Pose) -> bool {
        let finite = measured.x_m.is_finite()
            && measured.y_m.is_finite()
            && measured.heading_rad.is_finite();
        if !finite || taken_s < self.corrected_s {
            return false;
        }
        // The last step that ended by then.
        let Some(mut at) = self.steps.iter().rposition(|step| step.end_s <= taken_s) else {
            return false;
        };
        if let Some(next) = self.steps.get(at + 1).copied() {
            at = self.split(at, &next, taken_s);
        }
        self.steps[at].estimate = self.corrected(&self.steps[at].estimate, measured);
        self.corrected_s = taken_s;
        for later in at + 1..self.steps.len() {
            let displacement = self.steps[later].displacement_in_body;
            self.steps[later].estimate =
                self.propagated(&self.steps[later - 1].estimate, displacement);
        }
        true
    }

    /// Splits the step after `before` at a time inside it; returns the index of the step that now
    /// ends there.
    fn split(&mut self, before: usize, whole: &Step, at_s: f64) -> usize {
        let from_s = self.steps[before].end_s;
        // An interval of rounding size at a step's edge is not split.
        let share = (at_s - from_s) / (whole.end_s - from_s);
        if share <= 1e-9 {
            return before;
        }
        let first = whole.displacement_in_body.scaled(share);
        let estimate = self.propagated(&self.steps[before].estimate, first);
        self.steps[before + 1].displacement_in_body =
            whole.displacement_in_body.scaled(1.0 - share);
        let dropped = self.keep(
            before + 1,
            Step {
                end_s: at_s,
                displacement_in_body: first,
                estimate,
            },
        );
        before + 1 - dropped
    }

    /// Inserts a step and drops the oldest if there are too many; returns how many were dropped.
    fn keep(&mut self, place: usize, step: Step) -> usize {
        self.steps.insert(place, step);
        // One more than the steps kept: the start of the first of them.
        let too_many = self.steps.len() > self.settings.memory + 1;
        if too_many {
            self.steps.pop_front();
        }
        usize::from(too_many)
    }

    fn propagated(&self, from: &PoseEstimate, displacement_in_body: Twist) -> PoseEstimate {
        let d = displacement_in_body;
        let pose = from.pose.moved(d);
        let w = pose.position_m() - from.pose.position_m();
        #[rustfmt::skip]
        let f = Matrix3::new(
            1.0, 0.0, -w.y,
            0.0, 1.0, w.x,
            0.0, 0.0, 1.0,
        );
        let way_m = d.linear_m_s().norm() + self.settings.size_m * d.omega_rad_s.abs();
        let q = variances(
            self.settings.drift_position_m,
            self.settings.drift_heading_rad,
        ) * way_m;
        PoseEstimate {
            pose,
            covariance: f * from.covariance * f.transpose() + q,
        }
    }

    fn corrected(&self, before: &PoseEstimate, z: &Pose) -> PoseEstimate {
        let p = before.covariance;
        // P + R is positive definite, because R is.
        let Some(inverse) = (p + self.measured).try_inverse() else {
            return *before;
        };
        let k = p * inverse;
        let x = before.pose;
        let change = k * Vector3::new(
            z.x_m - x.x_m,
            z.y_m - x.y_m,
            wrap_angle(z.heading_rad - x.heading_rad),
        );
        let left = Matrix3::identity() - k;
        PoseEstimate {
            pose: Pose {
                x_m: x.x_m + change.x,
                y_m: x.y_m + change.y,
                heading_rad: wrap_angle(x.heading_rad + change.z),
            },
            covariance: left * p * left.transpose() + k * self.measured * k.transpose(),
        }
    }
}

/// A diagonal covariance from two standard deviations.
fn variances(position_m: f64, heading_rad: f64) -> Matrix3<f64> {
    let (r, phi) = (position_m * position_m, heading_rad * heading_rad);
    Matrix3::from_diagonal(&Vector3::new(r, r, phi))
}

fn is_finite(twist: &Twist) -> bool {
    twist.vx_m_s.is_finite() && twist.vy_m_s.is_finite() && twist.omega_rad_s.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn settings() -> PoseFilterSettings {
        PoseFilterSettings {
            measured_position_m: 0.02,
            measured_heading_rad: 0.03,
            drift_position_m: 0.05,
            drift_heading_rad: 0.04,
            size_m: 0.25,
            memory: 100,
        }
    }

    /// Pseudo-random numbers of a normal distribution, always the same: the sum of twelve uniform
    /// ones.
    fn normal(seed: &mut u64) -> f64 {
        let mut even = || {
            *seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| even()).sum::<f64>() - 6.0
    }

    fn size(a: &Pose, b: &Pose) -> f64 {
        let turn = wrap_angle(a.heading_rad - b.heading_rad);
        (a.position_m() - b.position_m()).norm() + turn.abs()
    }

    /// Odometry at step `k` of a curve that includes sideways motion.
    fn step_of(k: usize) -> Twist {
        let t = 0.01 * k as f64;
        Twist::new(0.004, 0.002 * t.sin(), 0.01 * (0.7 * t).cos())
    }

    #[test]
    fn without_poses_it_reckons() {
        // A quarter of a circle of 1 m to the left in a thousand steps ends at (1, 1), looking
        // along y. Chords in place of arcs are short by a part in (pi/2000)^2 / 24 = 1e-7.
        let mut filter = PoseFilter::new(0.0, Pose::default(), &settings()).unwrap();
        let turn = FRAC_PI_2 / 1000.0;
        for k in 1..=1000 {
            filter.predict(0.01 * f64::from(k), Twist::new(turn, 0.0, turn));
        }
        let end = Pose {
            x_m: 1.0,
            y_m: 1.0,
            heading_rad: FRAC_PI_2,
        };
        assert!(size(&filter.estimate().pose, &end) < 3e-7);
        // Distance: pi/2 m of travel and as much rotation, 0.25 m of wheel per radian. The
        // heading's drift alone is simple.
        let way = FRAC_PI_2 * 1.25;
        let p = filter.estimate().covariance;
        assert!((p.m33 - way * 0.04 * 0.04).abs() < 1e-12);
        assert!(p.m11 > way * 0.05 * 0.05 && (p - p.transpose()).norm() < 1e-15);
    }

    #[test]
    fn a_late_pose_does_what_a_timely_one_does() {
        let mut seed = 3;
        let mut poses = Vec::new();
        let (mut timely, mut late) = (
            PoseFilter::new(0.0, Pose::default(), &settings()).unwrap(),
            PoseFilter::new(0.0, Pose::default(), &settings()).unwrap(),
        );
        let delay = 9;
        for k in 1..=300 {
            let now_s = 0.01 * k as f64;
            for filter in [&mut timely, &mut late] {
                filter.predict(now_s, step_of(k));
            }
            if k % 4 == 0 {
                let seen = timely.estimate().pose;
                let z = Pose {
                    x_m: seen.x_m + 0.05 * normal(&mut seed),
                    heading_rad: wrap_angle(seen.heading_rad + 0.1 * normal(&mut seed)),
                    ..seen
                };
                assert!(timely.correct(now_s, &z));
                poses.push((k, now_s, z));
            }
            if let Some((_, taken_s, z)) = poses.iter().find(|(taken, ..)| taken + delay == k) {
                assert!(late.correct(*taken_s, z));
            }
        }
        // The last poses have not arrived yet: they do now.
        for (k, taken_s, z) in &poses {
            if k + delay > 300 {
                assert!(late.correct(*taken_s, z));
            }
        }
        let (timely, late) = (timely.estimate(), late.estimate());
        assert!(size(&timely.pose, &late.pose) < 1e-12);
        assert!((timely.covariance - late.covariance).norm() < 1e-15);
    }

    #[test]
    fn a_pose_taken_between_two_steps_counts_at_its_own_time() {
        // Straight ahead at 1 m/s: a perfect pose taken at 0.05 s, within a step of 0.1 s, must
        // change nothing.
        let mut filter = PoseFilter::new(0.0, Pose::default(), &settings()).unwrap();
        filter.predict(0.1, Twist::new(0.1, 0.0, 0.0));
        filter.predict(0.2, Twist::new(0.1, 0.0, 0.0));
        let then = Pose {
            x_m: 0.05,
            ..Pose::default()
        };
        let before = filter.estimate();
        assert!(filter.correct(0.05, &then));
        let after = filter.estimate();
        assert!((after.pose.x_m - 0.2).abs() < 1e-15);
        assert!(after.covariance.m11 < before.covariance.m11);
    }

    /// A step split by a pose moves the robot and its covariance like its two parts, wherever it is
    /// split.
    #[test]
    fn a_split_step_is_its_two_parts() {
        let whole = Twist::new(0.1, -0.04, 0.3);
        let z = Pose {
            x_m: 0.03,
            y_m: -0.01,
            heading_rad: 0.07,
        };
        for share in [0.1, 0.25, 0.5, 0.8] {
            let taken_s = 0.1 * share;
            let new = || PoseFilter::new(0.0, Pose::default(), &settings()).unwrap();
            let (mut split, mut parts) = (new(), new());
            split.predict(0.1, whole);
            assert!(split.correct(taken_s, &z));
            parts.predict(taken_s, whole.scaled(share));
            assert!(parts.correct(taken_s, &z));
            parts.predict(0.1, whole.scaled(1.0 - share));
            let (split, parts) = (split.estimate(), parts.estimate());
            // The same sums, of numbers below 1.
            assert!(size(&split.pose, &parts.pose) < 1e-14, "{share}");
            assert!(
                (split.covariance - parts.covariance).norm() < 1e-16,
                "{share}"
            );
        }
    }

    #[test]
    fn its_covariance_is_what_its_errors_come_to() {
        // Robots drift, and cameras err, as the settings say, 200 ms late: the squared error
        // weighted by the inverse covariance has the mean 3, one per degree of freedom. 4000 runs
        // of variance 6 give a mean within 3 sqrt(6/4000) = 0.116, except three times in a
        // thousand.
        let settings = settings();
        let (mut seed, mut sum, runs) = (11, 0.0, 4000);
        for _ in 0..runs {
            let mut filter = PoseFilter::new(0.0, Pose::default(), &settings).unwrap();
            let (mut truth, mut on_the_way) = (Pose::default(), VecDeque::new());
            for k in 1..=120_usize {
                let now_s = 0.01 * k as f64;
                let told = step_of(k);
                let way = told.linear_m_s().norm() + 0.25 * told.omega_rad_s.abs();
                let drift = |seed: &mut u64, q: f64| q * way.sqrt() * normal(seed);
                let real = told
                    + Twist::new(
                        drift(&mut seed, 0.05),
                        drift(&mut seed, 0.05),
                        drift(&mut seed, 0.04),
                    );
                truth = truth.moved(real);
                filter.predict(now_s, told);
                if k % 10 == 0 {
                    let z = Pose {
                        x_m: truth.x_m + 0.02 * normal(&mut seed),
                        y_m: truth.y_m + 0.02 * normal(&mut seed),
                        heading_rad: truth.heading_rad + 0.03 * normal(&mut seed),
                    };
                    on_the_way.push_back((k + 20, now_s, z));
                }
                while let Some((arrives, taken_s, z)) = on_the_way.front()
                    && *arrives <= k
                {
                    assert!(filter.correct(*taken_s, z));
                    on_the_way.pop_front();
                }
            }
            let estimate = filter.estimate();
            let e = Vector3::new(
                truth.x_m - estimate.pose.x_m,
                truth.y_m - estimate.pose.y_m,
                wrap_angle(truth.heading_rad - estimate.pose.heading_rad),
            );
            sum += e.dot(&(estimate.covariance.try_inverse().unwrap() * e));
        }
        let mean = sum / f64::from(runs);
        println!("mean squared error over covariance: {mean:.3}");
        assert!((mean - 3.0).abs() < 0.12, "{mean}");
    }

    #[test]
    fn what_comes_too_late_or_is_no_pose_is_left_out() {
        let mut filter = PoseFilter::new(0.0, Pose::default(), &settings()).unwrap();
        for k in 1..=150 {
            filter.predict(0.01 * f64::from(k), Twist::new(0.01, 0.0, 0.0));
        }
        let somewhere = Pose {
            x_m: 9.0,
            ..Pose::default()
        };
        let before = filter.estimate();
        assert!(!filter.correct(0.3, &somewhere), "older than what is kept");
        let lost = Pose {
            y_m: f64::NAN,
            ..Pose::default()
        };
        assert!(!filter.correct(1.4, &lost));
        filter.predict(1.5, Twist::new(5.0, 0.0, 0.0));
        filter.predict(1.6, Twist::new(f64::NAN, 0.0, 0.0));
        assert_eq!(filter.estimate(), before);
        assert!(filter.correct(1.4, &somewhere));
        assert!(!filter.correct(1.3, &somewhere), "out of order");
    }

    #[test]
    fn no_memory_that_is_asked_for_ends_the_process() {
        for memory in [PoseFilter::MOST_STEPS + 1, usize::MAX - 1, usize::MAX] {
            let settings = PoseFilterSettings {
                memory,
                ..settings()
            };
            let refused = PoseFilter::new(0.0, Pose::default(), &settings);
            assert!(matches!(refused, Err(ControlError::TooLarge { .. })));
        }
    }

    #[test]
    fn settings_out_of_range_are_refused_by_name() {
        let bad = PoseFilterSettings {
            measured_heading_rad: 0.0,
            ..settings()
        };
        assert_eq!(
            PoseFilter::new(0.0, Pose::default(), &bad)
                .unwrap_err()
                .to_string(),
            "the deviation of a measured heading in rad is 0; it must be finite and above zero"
        );
    }
}
