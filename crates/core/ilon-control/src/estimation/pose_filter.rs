//! Where the robot is: wheel odometry and late, noisy poses (of a camera, say) in an extended Kalman filter.
//!
//! Section IV closes the guidance loop on such an estimate, "the integration of odometry and an omnidirectional vision
//! system", without saying how the two are joined. This is the textbook way (S. Thrun, W. Burgard, D. Fox, "Probabilistic
//! Robotics", 2005, chapters 3.3 and 7.4), with the pose itself as what is measured.
//!
//! **State** x = (x, y, phi) of the body frame in the world, with covariance P.
//!
//! **Odometry.** The wheels' turn gives a displacement (d_x, d_y, d_phi) in the body frame, which takes the pose along an
//! arc ([`Pose::moved`]). With (w_x, w_y) what the body's origin moves by in the world, F = dx+/dx = [1 0 -w_y; 0 1 w_x; 0 0 1]
//! and P+ = F P F^T + Q. Slip comes at random and adds up, so Q grows with the way that the wheels roll:
//! Q = way diag(q_r^2, q_r^2, q_phi^2), way = |d| + size |d_phi|.
//!
//! **A pose** z = x + noise of covariance R: K = P (P + R)^-1, x+ = x + K (z - x), P+ = (1 - K) P (1 - K)^T + K R K^T
//! (Joseph's form, which stays symmetric positive definite under rounding). Heading differences are wrapped.
//!
//! **Delay.** A pose tells where the robot was when it was taken. The last displacements and estimates are kept: a
//! pose is put in at its own time, and the displacements since then are replayed on the corrected estimate. The result is
//! exactly that of a pose which arrives at once, as long as poses arrive in the order in which they were taken.

use std::collections::VecDeque;

use ilon_robot::{Pose, Twist, wrap_angle};
use nalgebra::{Matrix3, Vector3};

use crate::ControlError;
use crate::error::{not_negative, positive};

/// What the filter takes for granted of odometry and measured poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseFilterSettings {
    /// Standard deviation of a measured x, and y, in metres, > 0.
    pub measured_position_m: f64,
    /// Standard deviation of a measured heading, in radians, > 0.
    pub measured_heading_rad: f64,
    /// q_r: standard deviation of x, and y, by odometry after the wheels have rolled 1 m, in metres. It grows with the
    /// root of the way.
    pub drift_position_m: f64,
    /// q_phi: standard deviation of the heading by odometry after the wheels have rolled 1 m, in radians.
    pub drift_heading_rad: f64,
    /// Distance of the wheels from the body's origin in metres: how far they roll per radian turned.
    pub size_m: f64,
    /// How many odometry steps are kept, [`PoseFilter::MOST_STEPS`] at most: a pose older than these comes too late.
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

/// The filter: dead reckoning corrected by poses that arrive late.
#[derive(Clone, Debug)]
pub struct PoseFilter {
    settings: PoseFilterSettings,
    /// R.
    measured: Matrix3<f64>,
    /// The steps that are kept, oldest first; never empty.
    steps: VecDeque<Step>,
    /// When the last pose that was put in was taken, in seconds.
    corrected_s: f64,
}

/// One step of odometry and what was believed at its end.
#[derive(Clone, Copy, Debug)]
struct Step {
    end_s: f64,
    displacement_in_body: Twist,
    estimate: PoseEstimate,
}

impl PoseFilter {
    /// The most odometry steps that are kept: room is made for all of them, 130 bytes or so each, so that none is made
    /// under way.
    pub const MOST_STEPS: usize = 1_000_000;

    /// A filter that knows where the robot stands at a time in seconds.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`], [`ControlError::Negative`], [`ControlError::TooLarge`] for settings out of range.
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
        // A split step takes a place more.
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

    /// Takes the wheels of a robot whose joints move them to be so far from the body's origin from now on, in metres: how far they roll per radian turned.
    /// Distances that are negative or no number change nothing.
    pub fn resize(&mut self, size_m: f64) {
        if size_m.is_finite() && size_m >= 0.0 {
            self.settings.size_m = size_m;
        }
    }

    /// What is believed at the time of the last odometry step.
    pub fn estimate(&self) -> PoseEstimate {
        let start = PoseEstimate {
            pose: Pose::default(),
            covariance: Matrix3::zeros(),
        };
        self.steps.back().map_or(start, |step| step.estimate)
    }

    /// Goes on by odometry to a time in seconds: `displacement_in_body` is what the wheels turned since the last time,
    /// as a displacement (metres and radians in the components of a twist). A time that is not later, or a
    /// displacement that is not finite, changes nothing.
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

    /// Puts in a pose that was taken at `taken_s`, now or earlier. Returns whether it was of use: it is not where it is
    /// older than one that was put in before or than what is kept, or not finite.
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

    /// Splits the step after `before` at a time inside it; returns the place of the step that now ends there.
    fn split(&mut self, before: usize, whole: &Step, at_s: f64) -> usize {
        let from_s = self.steps[before].end_s;
        // What lies between two sums of times is no interval worth splitting at its edge.
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

    /// Puts a step in its place and forgets the oldest where they become too many; returns how many were forgotten.
    fn keep(&mut self, place: usize, step: Step) -> usize {
        self.steps.insert(place, step);
        // One more than the steps kept: where the first of them began.
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

/// A diagonal covariance from two deviations.
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

    /// Normally distributed numbers, always the same: the sum of twelve even ones.
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

    /// What the wheels say at step `k` of a curve that is driven sideways, too.
    fn step_of(k: usize) -> Twist {
        let t = 0.01 * k as f64;
        Twist::new(0.004, 0.002 * t.sin(), 0.01 * (0.7 * t).cos())
    }

    #[test]
    fn without_poses_it_reckons() {
        // A quarter of a circle of 1 m to the left in a thousand steps ends at (1, 1), looking along y. Chords in place
        // of arcs are short by a part in (pi/2000)^2 / 24 = 1e-7.
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
        // Way: pi/2 m of travel and as much turning, 0.25 m of wheel a radian. The headings' drift alone is plain.
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
        // Straight on at 1 m/s: a perfect pose taken at 0.05 s, amid a step of 0.1 s, must change nothing.
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

    /// A step that a pose splits moves the robot and its covariance as the two steps do that it consists of, wherever it is split.
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
        // Robots that drift, and cameras that err, as the settings say, 200 ms late: the squared error weighed by the
        // inverse covariance has the mean 3, one a freedom. 4000 runs of variance 6 give a mean within 3 sqrt(6/4000) =
        // 0.116 three times out of a thousand.
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
