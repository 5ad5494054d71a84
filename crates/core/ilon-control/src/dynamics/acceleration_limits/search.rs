//! The possible part of a line of accelerations, by roots or by bisection.

use ilon_robot::bisected;
use nalgebra::Vector3;

use super::{AccelerationLimits, Course, LimitCause, LimitedBy, NOTHING, PushSharing};
use crate::dynamics::interval::{Interval, Line};
use crate::dynamics::wheel_force::{Moving, SLACK_N, WheelForce};

/// Largest acceleration considered, in m/s^2 and rad/s^2.
const MOST: f64 = 1e4;

impl AccelerationLimits {
    /// Returns the possible part of a line by roots; `None` if a wheel lifts on it.
    pub(super) fn by_roots(
        &mut self,
        moving: &Moving,
        course: &Course,
    ) -> Option<Interval<LimitedBy>> {
        let length = course.along.norm();
        let step = 0.1 / length;
        self.weigh(moving, course.at(0.0));
        std::mem::swap(&mut self.forces, &mut self.before);
        self.weigh(moving, course.at(step));
        let all = self.before.iter().chain(&self.forces);
        if all.clone().any(|force| force.load_n <= 0.0) {
            return None;
        }
        let mut left = Interval::within(MOST / length, NOTHING);
        for (wheel, (before, after)) in self.before.iter().zip(&self.forces).enumerate() {
            let by = |cause| LimitedBy { wheel, cause };
            let line = |of: fn(&WheelForce) -> f64| Line::through(of(before), of(after), step);
            left.keep_in_cone(
                [line(|w| w.at_ground_n[0]), line(|w| w.at_ground_n[1])],
                line(|w| w.grip_n),
                by(LimitCause::Grip),
            );
            if before.motor.max_n.is_finite() {
                left.keep_positive(line(|w| w.motor.max_n - w.push_n), by(LimitCause::Motor));
            }
            if before.motor.min_n.is_finite() {
                left.keep_positive(line(|w| w.push_n - w.motor.min_n), by(LimitCause::Motor));
            }
        }
        Some(left)
    }

    /// Returns the possible part of a line by bisection; the possible set is convex.
    pub(super) fn by_halving(
        &mut self,
        moving: &Moving,
        course: &Course,
    ) -> Option<Interval<LimitedBy>> {
        let length = course.along.norm();
        let most = MOST / length;
        let mut outside_n = |scale: f64| self.outside_n(moving, course.at(scale));
        let inside = match outside_n(0.0) <= SLACK_N {
            true => 0.0,
            false => least_of(0.01 / length, most, &mut outside_n),
        };
        if outside_n(inside) > SLACK_N {
            return None;
        }
        let mut end = |way: f64| {
            let (mut near, mut far) = (0.0, 1e-3 / length);
            while far < 2.0 * most
                && self.outside_n(moving, course.at(inside + way * far)) <= SLACK_N
            {
                (near, far) = (far, 2.0 * far);
            }
            // Forty bisections leave 1e-12 of the interval.
            (near, far) = bisected((near, far), 40, |off| {
                self.outside_n(moving, course.at(inside + way * off)) <= SLACK_N
            });
            let by = self.lacking(moving, course.at(inside + way * far));
            (inside + way * near, by)
        };
        let ((low, holds_low), (high, holds_high)) = (end(-1.0), end(1.0));
        Some(Interval {
            low,
            high,
            holds_low,
            holds_high,
        })
    }

    /// Returns by how much an acceleration exceeds the limits, in N: at most 0 if possible.
    pub(super) fn outside_n(&mut self, moving: &Moving, nu_rate: Vector3<f64>) -> f64 {
        let force = self.weigh(moving, nu_rate);
        match self.sharing {
            PushSharing::EqualLoops => self.worst().0,
            PushSharing::ByGrip => {
                let ranges = self.forces.iter().map(WheelForce::range);
                self.capacity.set.outside_n(&force, ranges)
            }
        }
    }
}

/// Returns the minimum of a convex function, or a point where it is below zero: first growing steps
/// downhill from 0, then golden-section search.
fn least_of(first_step: f64, most: f64, mut of: impl FnMut(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let way = match of(first_step) <= of(-first_step) {
        true => 1.0,
        false => -1.0,
    };
    let (mut before, mut here, mut step) = (-first_step, 0.0, first_step);
    let mut at_here = of(0.0);
    loop {
        let next = here + step;
        let at_next = of(way * next);
        if at_next <= 0.0 || next > most {
            return way * next;
        }
        if at_next > at_here {
            break;
        }
        (before, here, at_here, step) = (here, next, at_next, 2.0 * step);
    }
    let (mut low, mut high) = (before, here + step);
    let inner = |low: f64, high: f64| (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut x, mut y) = inner(low, high);
    let (mut at_x, mut at_y) = (of(way * x), of(way * y));
    // Sixty steps leave 3e-13 of the interval.
    for _ in 0..60 {
        if at_x <= 0.0 || at_y <= 0.0 {
            break;
        }
        if at_x <= at_y {
            (high, y, at_y) = (y, x, at_x);
            x = inner(low, high).0;
            at_x = of(way * x);
        } else {
            (low, x, at_x) = (x, y, at_y);
            y = inner(low, high).1;
            at_y = of(way * y);
        }
    }
    way * if at_x <= at_y { x } else { y }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The minimum of a parabola is found on either side, within its flat bottom: 1e-8 of a step in
    /// x changes the value by 1e-16.
    #[test]
    fn the_least_of_a_parabola_is_found_on_either_side() {
        for least in [0.3, -0.7, 12.5, -1e-3] {
            let found = least_of(0.1, 1e3, |x| (x - least) * (x - least) + 1.0);
            assert!((found - least).abs() < 1e-7, "{found} for {least}");
        }
        // The search ends at the first value that is not above zero.
        let crossed = least_of(0.1, 1e3, |x| 1.0 - x);
        assert!((1.0..=3.2).contains(&crossed), "{crossed}");
    }
}
