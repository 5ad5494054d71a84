//! The time-optimal traversal of a path within the accelerations that grip and motors allow.
//!
//! The path parameter sigma is the distance moved by its point plus that of an arm that turns with
//! it, so that a rotation on the spot counts as well. With the twist of the body's origin nu =
//! sigma' B(sigma), in body components,
//!
//!   nu' = sigma'' B + sigma'^2 dB/dsigma,
//!
//! which is linear in (sigma'', x = sigma'^2). On a grid of sigma with steps d, x grows by 2 d
//! sigma''. A backward pass finds at each node the largest x from which the rest can still be
//! driven; a forward pass then accelerates as much as possible at each node within these bounds
//! (Pham and Pham, "A new approach to time-optimal path parameterization based on reachability
//! analysis", IEEE Transactions on Robotics 34(3), 2018).

use ilon_robot::Twist;
use nalgebra::Vector2;

use super::pace::{Node, Pace, length_m};
use super::reference::{Pieces, Reference};
use crate::error::{finite, positive};
use crate::{AccelerationLimits, ControlError, Motor};

/// Grid steps between two waypoints, on a line, and in a lap.
const PER_PIECE: usize = 120;
const PER_LAP: usize = 240;
/// Longest step beside a stop, in metres: longer ones are divided, because a robot may reach its
/// top speed within one.
const BESIDE_STOP_M: f64 = 0.05;
/// The square of a speed that any robot can have, in m^2/s^2.
const SLOW_M2_S2: f64 = 1e-4;
/// Largest number of laps computed.
const MOST_LAPS: usize = 64;

/// Constraints for the time-optimal traversal of a path.
#[derive(Debug)]
pub struct Fastest<'a> {
    /// The robot's acceleration limits, with the share that may be used.
    pub limits: &'a mut AccelerationLimits,
    /// The motors, one per wheel.
    pub motors: &'a [Motor],
    /// The largest wheel rate, in rad/s; infinite for none.
    pub wheel_rate_limit_rad_s: f64,
    /// The point of the body that follows the path, in the body frame, in metres.
    pub reference_point_m: Vector2<f64>,
    /// The downhill direction in the world frame, in radians; without effect on level ground.
    pub downhill_in_world_rad: f64,
}

/// A step of the grid.
struct Step {
    own_s: f64,
    own_until_s: f64,
    length_m: f64,
    /// Its two ends; the limits must hold at both.
    ends: [PathPlace; 2],
    /// Whether the robot is at rest at the start of the step.
    from_rest: bool,
    /// Largest x that the wheels' rates allow.
    most: f64,
}

/// A point on the path.
#[derive(Clone, Copy)]
struct PathPlace {
    /// B, and its change per metre.
    direction: Twist,
    bend: Twist,
    heading_rad: f64,
}

impl Reference {
    /// Returns the path traversed in minimal time, from rest, and to rest where the path ends. A
    /// circle or a figure eight repeats its laps; if its laps do not become equal, as under a
    /// heading that turns by itself, it is computed until `until_s` in seconds and rests then.
    /// Original speeds and times of the path have no effect, except for the sense of a circle.
    ///
    /// The heading belongs to the path: a constant-rate heading turns with the path's own time. If
    /// the rate of a tangent heading jumps, as at inner waypoints, the jump is spread over the last
    /// 1/120 of the distance to it.
    ///
    /// # Errors
    /// [`ControlError::CannotBeDriven`] if the limits allow no further motion;
    /// [`ControlError::NotPositive`], [`ControlError::NotFinite`] and those of
    /// [`AccelerationLimits::range`].
    pub fn as_fast_as_possible(
        &self,
        under: &mut Fastest<'_>,
        until_s: f64,
    ) -> Result<Self, ControlError> {
        if under.wheel_rate_limit_rad_s != f64::INFINITY {
            positive(
                "the wheel rate limit in rad/s",
                under.wheel_rate_limit_rad_s,
            )?;
        }
        finite("the direction downhill in rad", under.downhill_in_world_rad)?;
        finite("the time until which laps are worked out in s", until_s)?;
        let arm_m = under.limits.arm_m();
        let mut ends = |knots: &[f64]| under_ends(self, under, knots, arm_m);
        match self.pieces() {
            Pieces::None => return Ok(self.clone()),
            Pieces::Line(end_s) => ends(&[0.0, end_s]),
            Pieces::Between(times_s) => ends(times_s),
            Pieces::Lap(lap_s) => self.laps(under, lap_s, until_s, arm_m),
        }
        .map(|pace| self.at_pace(pace))
    }

    fn laps(
        &self,
        under: &mut Fastest<'_>,
        lap_s: f64,
        until_s: f64,
        arm_m: f64,
    ) -> Result<Pace, ControlError> {
        let mut laps = 3;
        loop {
            let mut steps = Vec::new();
            let whole = (0.0, laps as f64 * lap_s);
            under.add_steps(
                self,
                whole,
                (laps * PER_LAP, [true, false]),
                arm_m,
                &mut steps,
            );
            let squares = under.squares(&steps, f64::INFINITY)?;
            let nodes = nodes(&steps, &squares, whole.1)?;
            // The first step may be divided into several.
            let first = steps.len() - laps * PER_LAP;
            let begins = |lap: usize| first + lap * PER_LAP;
            // All laps are the same, except for the last, which need not prepare for another.
            let [before, after] = [laps - 2, laps - 1].map(|lap| nodes[begins(lap)].flow_m_s);
            if (after - before).abs() < 1e-6 * after {
                let kept = nodes[..=begins(laps - 1)].to_vec();
                return Ok(Pace::new(kept, Some(begins(laps - 2)), arm_m));
            }
            let is_enough = nodes.last().is_some_and(|last| last.t_s >= until_s);
            if is_enough || laps >= MOST_LAPS {
                return Ok(Pace::new(nodes, None, arm_m));
            }
            laps *= 2;
        }
    }
}

/// Traverses pieces of a path from rest to rest.
fn under_ends(
    path: &Reference,
    under: &mut Fastest<'_>,
    knots: &[f64],
    arm_m: f64,
) -> Result<Pace, ControlError> {
    let mut steps = Vec::new();
    for (index, piece) in knots.windows(2).enumerate() {
        let rests = [index == 0, index + 2 == knots.len()];
        let count = (PER_PIECE, rests);
        under.add_steps(path, (piece[0], piece[1]), count, arm_m, &mut steps);
    }
    let end_s = knots.last().copied().unwrap_or(0.0);
    let squares = under.squares(&steps, 0.0)?;
    Ok(Pace::new(nodes(&steps, &squares, end_s)?, None, arm_m))
}

impl Fastest<'_> {
    /// Adds a piece of a path to the grid, given its number of steps and whether the robot rests at
    /// its ends (also where the path itself rests).
    fn add_steps(
        &self,
        path: &Reference,
        (from_s, to_s): (f64, f64),
        (count, rests): (usize, [bool; 2]),
        arm_m: f64,
        steps: &mut Vec<Step>,
    ) {
        let flow = |own_s: f64| path.flow_on(own_s, arm_m);
        let part_s = (to_s - from_s) / count as f64;
        let whole_m: f64 = (0..count)
            .map(|k| {
                length_m(
                    from_s + k as f64 * part_s,
                    from_s + (k + 1) as f64 * part_s,
                    &flow,
                )
            })
            .sum();
        if whole_m <= 0.0 {
            return;
        }
        let mean_m_s = whole_m / (to_s - from_s);
        // Slightly inside the ends: in a stop nothing moves, and at a waypoint one piece ends and
        // another starts.
        let inside_s = 1e-3 * part_s;
        let place = |own_s: f64| {
            let own_s = own_s.clamp(from_s + 2.0 * inside_s, to_s - 2.0 * inside_s);
            let around = [own_s - inside_s, own_s + inside_s];
            let [before, after] = around.map(|own_s| self.direction(path, own_s, arm_m));
            let apart_m = length_m(around[0], around[1], &flow);
            PathPlace {
                direction: self.direction(path, own_s, arm_m),
                bend: (after + before.scaled(-1.0)).scaled(1.0 / apart_m),
                heading_rad: path.at_own(own_s).pose.heading_rad,
            }
        };
        let rests_at = |own_s: f64| flow(own_s) < 1e-6 * mean_m_s;
        let grid_s: Vec<f64> = (0..=count).map(|k| from_s + k as f64 * part_s).collect();
        let rests = [rests[0] || rests_at(from_s), rests[1] || rests_at(to_s)];
        let grid_s = divided_beside_stops(grid_s, rests, &flow);
        let mut first = place(from_s);
        for (k, pair) in grid_s.windows(2).enumerate() {
            let (start_s, end_s) = (pair[0], pair[1]);
            let ends = [first, place(end_s)];
            let rests = rests_at(start_s);
            if let Some(before) = steps.last_mut().filter(|_| k == 0 && !rests) {
                // A jump at a waypoint is spread over the step before it.
                let jump = ends[0].direction + before.ends[1].direction.scaled(-1.0);
                for end in &mut before.ends {
                    end.bend = end.bend + jump.scaled(1.0 / before.length_m);
                }
            }
            steps.push(Step {
                own_s: start_s,
                own_until_s: end_s,
                length_m: length_m(start_s, end_s, &flow),
                from_rest: rests || steps.is_empty(),
                most: ends
                    .map(|end| self.most_square(end.direction))
                    .into_iter()
                    .fold(f64::INFINITY, f64::min),
                ends,
            });
            first = ends[1];
        }
    }

    /// Returns B at a time: the twist of the body's origin per metre of sigma.
    fn direction(&self, path: &Reference, own_s: f64, arm_m: f64) -> Twist {
        let desired = path.at_own(own_s);
        let twist = desired.velocity_in_world.rotated(-desired.pose.heading_rad);
        // The origin rotates about the point that follows the path.
        let of_origin = twist.at(-self.reference_point_m);
        of_origin.scaled(1.0 / path.flow_on(own_s, arm_m))
    }

    /// Returns the largest x at which the position and heading tasks together keep all wheels
    /// within their limit, with the guidance's weights.
    fn most_square(&self, direction: Twist) -> f64 {
        let heading = Twist::new(0.0, 0.0, direction.omega_rad_s).at(-self.reference_point_m);
        let position = direction + heading.scaled(-1.0);
        let asked_rad_s = [position, heading].map(|task| self.limits.fastest_rate_rad_s(task));
        let share = asked_rad_s.iter().sum::<f64>() / self.wheel_rate_limit_rad_s;
        // A path that needs no wheel motion has no speed limit.
        1.0 / (share * share).max(1e-12)
    }

    /// Returns x at each node, including the last, where it is at most `end`.
    fn squares(&mut self, steps: &[Step], end: f64) -> Result<Vec<f64>, ControlError> {
        let mut reach = vec![end; steps.len() + 1];
        for (i, step) in steps.iter().enumerate().rev() {
            reach[i] = self.reach(step, reach[i + 1])?;
        }
        let mut x = 0.0;
        let mut squares = vec![0.0];
        for (i, step) in steps.iter().enumerate() {
            let to_next = (reach[i + 1] - x) / (2.0 * step.length_m);
            let after = |gain: f64| (x + 2.0 * step.length_m * gain).max(0.0);
            // At the boundary rounding may leave no interval.
            let (least, most) = self.gains(step, x)?.unwrap_or((0.0, 0.0));
            let mut gain = most.min(to_next);
            // A motor that turns faster at the step's end has less torque there.
            if let Some((_, at_end)) = self.gains_at(&step.ends[1], after(gain))? {
                gain = gain.min(at_end.max(least));
            }
            x = after(gain);
            squares.push(x);
        }
        Ok(squares)
    }

    /// Returns the largest x at the start of a step that allows at most `next` at its end.
    fn reach(&mut self, step: &Step, next: f64) -> Result<f64, ControlError> {
        let at_end = match next.is_finite() {
            true => self.gains_at(&step.ends[1], next)?,
            false => None,
        };
        let mut is_fine =
            |x: f64| {
                let needed = (next - x) / (2.0 * step.length_m);
                // A motor that turns more slowly at the step's end brakes with less torque there.
                if at_end.is_some_and(|(least, _)| needed < 0.0 && least > needed) {
                    return Ok(false);
                }
                let gains = self.gains(step, x)?;
                Ok::<_, ControlError>(gains.is_some_and(|(least, most)| {
                    least <= needed && most >= -x / (2.0 * step.length_m)
                }))
            };
        if !is_fine(0.0)? {
            return Err(ControlError::CannotBeDriven {
                own_time_s: step.own_s,
            });
        }
        if step.from_rest {
            return Ok(0.0);
        }
        if is_fine(step.most)? {
            return Ok(step.most);
        }
        let (mut low, mut high) = (0.0, SLOW_M2_S2.min(step.most));
        while high < step.most && is_fine(high)? {
            (low, high) = (high, 4.0 * high);
        }
        high = high.min(step.most);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if is_fine(middle)? {
                low = middle;
            } else {
                high = middle;
            }
        }
        Ok(low)
    }

    /// Returns the smallest and the largest sigma'' at the start of a step for a given x.
    fn gains(&mut self, step: &Step, x: f64) -> Result<Option<(f64, f64)>, ControlError> {
        let [first, last] = &step.ends;
        let both = self.gains_at(first, x)?.zip(self.gains_at(last, x)?);
        let both = both.map(|(first, last)| (first.0.max(last.0), first.1.min(last.1)));
        Ok(both.filter(|(least, most)| least <= most))
    }

    /// Returns the smallest and the largest sigma'' at a point for a given x.
    fn gains_at(&mut self, place: &PathPlace, x: f64) -> Result<Option<(f64, f64)>, ControlError> {
        self.limits
            .turn_slope(self.downhill_in_world_rad - place.heading_rad)?;
        let twist = place.direction.scaled(libm::sqrt(x));
        let base = place.bend.scaled(x);
        let found = self
            .limits
            .range(base, place.direction, twist, self.motors)?;
        Ok(found.map(|range| (range.least, range.largest)))
    }
}

/// Returns a grid of own times whose steps beside stops are halved repeatedly towards the stops.
fn divided_beside_stops(
    mut grid_s: Vec<f64>,
    [first, last]: [bool; 2],
    flow: &impl Fn(f64) -> f64,
) -> Vec<f64> {
    let halves = |stop_s: f64, other_s: f64| {
        let part = |half: i32| stop_s + 0.5_f64.powi(half) * (other_s - stop_s);
        let is_long = |half: &i32| length_m(stop_s, part(*half), flow).abs() > BESIDE_STOP_M;
        let long = (0..60).take_while(is_long);
        long.map(|half| part(half + 1)).collect::<Vec<_>>()
    };
    let n = grid_s.len();
    if last {
        let divided = halves(grid_s[n - 1], grid_s[n - 2]);
        grid_s.splice(n - 1..n - 1, divided);
    }
    if first {
        let divided = halves(grid_s[0], grid_s[1]);
        grid_s.splice(1..1, divided.into_iter().rev());
    }
    grid_s
}

/// Converts x at each node to the nodes of a pace.
fn nodes(steps: &[Step], squares: &[f64], end_s: f64) -> Result<Vec<Node>, ControlError> {
    let mut t_s = 0.0;
    let mut nodes = Vec::with_capacity(squares.len());
    for (step, pair) in steps.iter().zip(squares.windows(2)) {
        let flows = [pair[0], pair[1]].map(libm::sqrt);
        nodes.push(Node {
            t_s,
            own_s: step.own_s,
            own_until_s: step.own_until_s,
            flow_m_s: flows[0],
            gain_m_s2: (pair[1] - pair[0]) / (2.0 * step.length_m),
        });
        t_s += 2.0 * step.length_m / (flows[0] + flows[1]);
        if !t_s.is_finite() {
            return Err(ControlError::CannotBeDriven {
                own_time_s: step.own_s,
            });
        }
    }
    nodes.push(Node {
        t_s,
        own_s: end_s,
        own_until_s: end_s,
        flow_m_s: squares.last().map_or(0.0, |x| libm::sqrt(*x)),
        gain_m_s2: 0.0,
    });
    Ok(nodes)
}

#[cfg(test)]
mod tests;
