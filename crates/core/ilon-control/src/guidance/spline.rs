//! Curves through waypoints at given times: cubic Hermite pieces, continuous in value and first
//! derivative.

use nalgebra::SVector;

use crate::ControlError;

/// A C1 curve through `D`-vectors at growing times, at rest at both ends.
///
/// The derivative at an inner waypoint is that of the parabola through it and its neighbours; where
/// a neighbour is the same point it is zero, so that a waypoint given twice is a stop.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spline<const D: usize> {
    times_s: Vec<f64>,
    points: Vec<SVector<f64, D>>,
    derivatives: Vec<SVector<f64, D>>,
}

/// Value and derivatives of a curve at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion<const D: usize> {
    pub value: SVector<f64, D>,
    pub velocity: SVector<f64, D>,
    pub acceleration: SVector<f64, D>,
}

impl<const D: usize> Spline<D> {
    /// The curve through `points` at `times_s`.
    pub fn new(times_s: &[f64], points: Vec<SVector<f64, D>>) -> Result<Self, ControlError> {
        let count = points.len();
        if times_s.len() != count {
            return Err(ControlError::LengthMismatch {
                left: "waypoint times",
                left_count: times_s.len(),
                right: "waypoints",
                right_count: count,
            });
        }
        if count < 2 {
            return Err(ControlError::TooFewWaypoints { count });
        }
        for (index, time_s) in times_s.iter().enumerate() {
            let after = if index == 0 {
                f64::NEG_INFINITY
            } else {
                times_s[index - 1]
            };
            // Written so that NaN is refused.
            if !(*time_s > after && time_s.is_finite() && *time_s >= 0.0) {
                return Err(ControlError::TimesNotGrowing {
                    index,
                    time_s: *time_s,
                });
            }
        }
        for (index, point) in points.iter().enumerate() {
            if let Some(value) = point.iter().find(|value| !value.is_finite()) {
                return Err(ControlError::NotFinite {
                    what: format!("a coordinate of waypoint {index}"),
                    value: *value,
                });
            }
        }
        let mut derivatives = vec![SVector::zeros(); count];
        for i in 1..count - 1 {
            let (h_0, h_1) = (times_s[i] - times_s[i - 1], times_s[i + 1] - times_s[i]);
            let (step_0, step_1) = (points[i] - points[i - 1], points[i + 1] - points[i]);
            if step_0.norm() > 0.0 && step_1.norm() > 0.0 {
                derivatives[i] = (step_0 / h_0 * h_1 + step_1 / h_1 * h_0) / (h_0 + h_1);
            }
        }
        Ok(Self {
            times_s: times_s.to_vec(),
            points,
            derivatives,
        })
    }

    /// The times of the waypoints, in seconds.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The waypoints.
    pub fn points(&self) -> &[SVector<f64, D>] {
        &self.points
    }

    /// Returns value and derivatives at a time; before the start and after the end the curve rests.
    pub fn at(&self, t_s: f64) -> Motion<D> {
        let last = self.times_s.len() - 1;
        let rest = SVector::<f64, D>::zeros();
        let resting = |value| Motion {
            value,
            velocity: rest,
            acceleration: rest,
        };
        if t_s.is_nan() || t_s <= self.times_s[0] {
            return resting(self.points[0]);
        }
        if t_s >= self.times_s[last] {
            return resting(self.points[last]);
        }
        let i = self.times_s.partition_point(|time_s| *time_s <= t_s) - 1;
        let h = self.times_s[i + 1] - self.times_s[i];
        let u = (t_s - self.times_s[i]) / h;
        let (p_0, p_1) = (self.points[i], self.points[i + 1]);
        let (m_0, m_1) = (self.derivatives[i] * h, self.derivatives[i + 1] * h);
        // p(u) = p_0 + u m_0 + u^2 b + u^3 a, the cubic with these ends and slopes.
        let a = 2.0 * (p_0 - p_1) + m_0 + m_1;
        let b = 3.0 * (p_1 - p_0) - 2.0 * m_0 - m_1;
        Motion {
            value: p_0 + (m_0 + (b + a * u) * u) * u,
            velocity: (m_0 + (2.0 * b + 3.0 * a * u) * u) / h,
            acceleration: (2.0 * b + 6.0 * a * u) / (h * h),
        }
    }
}

impl Spline<2> {
    /// Returns the direction of motion at a time, not normalised: the velocity; in a stop the
    /// direction in which the curve leaves it, at the end that in which it arrived.
    pub fn direction(&self, t_s: f64) -> SVector<f64, 2> {
        let last = self.times_s.len() - 1;
        let t_s = t_s.clamp(self.times_s[0], self.times_s[last]);
        let i = (self.times_s.partition_point(|time_s| *time_s <= t_s).max(1) - 1).min(last - 1);
        let h = self.times_s[i + 1] - self.times_s[i];
        let chord = self.points[i + 1] - self.points[i];
        let motion = self.at(t_s);
        // Near a stop the velocity vanishes; its direction is that at a point slightly inside the
        // piece.
        let slow = 1e-6 * chord.norm() / h;
        if motion.velocity.norm() > slow {
            return motion.velocity;
        }
        let inwards_s = if t_s - self.times_s[i] < 0.5 * h {
            1e-5 * h
        } else {
            -1e-5 * h
        };
        self.at(t_s + inwards_s).velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn zigzag() -> Spline<2> {
        let points = [(0.0, 0.0), (1.0, 0.5), (1.0, 0.5), (2.0, -0.5), (2.5, 1.0)];
        let points = points.iter().map(|&(x, y)| Vector2::new(x, y)).collect();
        Spline::new(&[1.0, 2.0, 2.5, 4.5, 5.0], points).unwrap()
    }

    #[test]
    fn the_curve_passes_through_its_waypoints_and_rests_at_both_ends() {
        let spline = zigzag();
        for (t_s, point) in spline.times_s.iter().zip(&spline.points) {
            assert!((spline.at(*t_s).value - point).norm() < 1e-14);
        }
        for t_s in [-1.0, 0.5, 1.0, 5.0, 9.0] {
            assert_eq!(spline.at(t_s).velocity, Vector2::zeros());
        }
    }

    #[test]
    fn value_and_velocity_are_continuous_and_the_derivatives_are_the_derivatives() {
        let spline = zigzag();
        let step_s = 1e-6;
        for k in 1..5000 {
            let t_s = 0.9 + 4.2 * f64::from(k) / 5000.0 + 1.7e-5;
            let (before, here, after) = (
                spline.at(t_s - step_s),
                spline.at(t_s),
                spline.at(t_s + step_s),
            );
            // Accelerations stay below 60 m/s^2 here: a difference quotient over 1e-6 s has an
            // error below 1e-4 m/s, and the velocity itself changes by less than 2e-4 m/s over it
            // even across a waypoint.
            let slope = (after.value - before.value) / (2.0 * step_s);
            assert!((slope - here.velocity).norm() < 1e-4);
            assert!((after.velocity - before.velocity).norm() < 2e-4);
        }
    }

    #[test]
    fn a_waypoint_given_twice_is_a_stop() {
        let spline = zigzag();
        for t_s in [2.0, 2.2, 2.5] {
            assert!((spline.at(t_s).value - Vector2::new(1.0, 0.5)).norm() < 1e-15);
            assert!(spline.at(t_s).velocity.norm() < 1e-15);
        }
    }

    #[test]
    fn a_straight_run_at_constant_speed_keeps_it_between_inner_waypoints() {
        let points = (0..6).map(|i| Vector2::new(f64::from(i), 2.0)).collect();
        let spline = Spline::new(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], points).unwrap();
        for t_s in [1.0, 1.3, 2.5, 3.9] {
            assert!((spline.at(t_s).velocity - Vector2::new(1.0, 0.0)).norm() < 1e-14);
        }
    }
}
