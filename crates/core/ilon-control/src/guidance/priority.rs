//! Prioritised saturation: one bound's capacity is shared among tasks in the order of their
//! priority, eqs. (29)-(35).

use ilon_robot::Twist;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which task is served first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Priority {
    /// Position before heading, equations (38)-(41).
    #[default]
    Position,
    /// Heading before position, equations (47)-(50).
    Heading,
}

impl Priority {
    /// Returns the two in the order of their priority. Applied to a pair in that order, it returns
    /// position and heading.
    pub(crate) fn order<T>(self, position: T, heading: T) -> (T, T) {
        match self {
            Self::Position => (position, heading),
            Self::Heading => (heading, position),
        }
    }
}

/// One task of the guidance: a requested motion.
///
/// In the kinematic model every motion that the wheels can roll is a twist, q' = M twist / (rho cos
/// gamma). Requests by twist therefore cover every task, whatever N: wheel rates outside the range
/// of M would only make wheels slide against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// Its name, repeated in [`TaskShare`].
    pub name: &'static str,
    /// The requested motion, in the body frame.
    pub twist_in_body: Twist,
}

impl Task {
    /// A twist of the body as tasks: its velocity and its yaw rate in the order of a priority;
    /// without a priority, the whole twist as the first task and nothing as the second.
    pub fn of_twist(twist_in_body: Twist, priority: Option<Priority>) -> [Self; 2] {
        let task = |name, vx_m_s, vy_m_s, omega_rad_s| Self {
            name,
            twist_in_body: Twist::new(vx_m_s, vy_m_s, omega_rad_s),
        };
        let Twist {
            vx_m_s,
            vy_m_s,
            omega_rad_s,
        } = twist_in_body;
        let whole = task("twist", vx_m_s, vy_m_s, omega_rad_s);
        let parts = priority.map(|priority| {
            let velocity = task("velocity", vx_m_s, vy_m_s, 0.0);
            priority.order(velocity, task("yaw rate", 0.0, 0.0, omega_rad_s))
        });
        parts.map_or([whole, task("yaw rate", 0.0, 0.0, 0.0)], Into::into)
    }
}

/// The share of a task that was executed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskShare {
    /// The task's name.
    pub name: &'static str,
    /// The requested motion, in the body frame.
    pub twist_in_body: Twist,
    /// The request: the infinity norm of its wheel rates, in rad/s.
    pub asked_rad_s: f64,
    /// Its capacity c_i of eq. (34), in rad/s: the rest left by the tasks above it.
    pub capacity_rad_s: f64,
    /// Its weight sigma of eq. (33), in [0, 1]: below 1 the task is saturated. A task without a
    /// request has weight 0, as eq. (30) defines it.
    pub weight: f64,
}

impl TaskShare {
    /// Whether the task was executed only in part.
    pub fn is_saturated(&self) -> bool {
        // Not `weight < 1`: a task without a request has weight zero and lacks nothing.
        self.asked_rad_s != 0.0 && self.weight < 1.0
    }
}

/// Returns the saturation weight of eqs. (30), (31): the factor that keeps `x` within its capacity
/// `c` >= 0.
///
/// 0 where x = 0; 1 where |x| < c; c / |x| beyond, which is 1 at |x| = c as well and 0 for c = 0. A
/// value that is not finite gets weight 0: no finite factor can keep it within.
pub fn sigma(x: f64, c: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        0.0
    } else if x.abs() < c {
        1.0
    } else {
        c / x.abs()
    }
}

/// Sets the capacity and weight of each task from its request, in falling priority: eq. (34), with
/// c_1 = `capacity_rad_s`, for any number of tasks.
pub fn share_capacity(capacity_rad_s: f64, shares: &mut [TaskShare]) {
    let mut c = capacity_rad_s;
    for share in shares {
        let x = share.asked_rad_s;
        share.capacity_rad_s = c;
        share.weight = sigma(x, c);
        if x.is_finite() {
            // c - x sigma(x, c) without its rounding: a task that takes all leaves exactly zero.
            c = if x < c { c - x } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eq_30_sigma_is_the_factor_that_clips() {
        assert_eq!(sigma(0.0, 3.0), 0.0);
        assert_eq!(sigma(2.0, 3.0), 1.0);
        assert_eq!(sigma(-2.0, 3.0), 1.0);
        assert_eq!(sigma(6.0, 3.0), 0.5);
        assert_eq!(sigma(-6.0, 3.0), 0.5);
        // The strict inequality of eq. (30) leaves |x| = c to the last case, where c / |x| is 1: no
        // jump.
        assert_eq!(sigma(3.0, 3.0), 1.0);
    }

    #[test]
    fn eq_31_zero_capacity_gives_zero_weight() {
        for x in [-5.0, -1e-300, 0.0, 1e-300, 7.0] {
            assert_eq!(sigma(x, 0.0), 0.0);
        }
    }

    #[test]
    fn what_is_not_finite_gets_no_weight() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(sigma(x, 3.0), 0.0);
        }
    }

    fn shares(asked: &[f64]) -> Vec<TaskShare> {
        let share = |asked_rad_s: &f64| TaskShare {
            twist_in_body: Twist::default(),
            name: "task",
            asked_rad_s: *asked_rad_s,
            capacity_rad_s: 0.0,
            weight: 0.0,
        };
        asked.iter().map(share).collect()
    }

    #[test]
    fn eq_34_each_task_gets_what_those_above_it_left() {
        let mut tasks = shares(&[2.0, 0.0, 5.0, 4.0, 1.0]);
        share_capacity(8.0, &mut tasks);
        let capacities: Vec<_> = tasks.iter().map(|t| t.capacity_rad_s).collect();
        let weights: Vec<_> = tasks.iter().map(|t| t.weight).collect();
        assert_eq!(capacities, [8.0, 6.0, 6.0, 1.0, 0.0]);
        assert_eq!(weights, [1.0, 0.0, 1.0, 0.25, 0.0]);
        let is_saturated: Vec<_> = tasks.iter().map(TaskShare::is_saturated).collect();
        assert_eq!(is_saturated, [false, false, false, true, true]);
    }

    #[test]
    fn a_task_that_is_not_finite_takes_nothing_from_those_below() {
        let mut tasks = shares(&[f64::NAN, 5.0]);
        share_capacity(8.0, &mut tasks);
        assert_eq!(tasks[1].capacity_rad_s, 8.0);
        assert_eq!(tasks[1].weight, 1.0);
    }
}
