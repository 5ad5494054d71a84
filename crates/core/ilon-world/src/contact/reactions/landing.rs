//! The time at which a joint reaches its stop within a step, and the depth of contacts.
//!
//! A stop that is not reached at the start of a step limits the joint's motion to it: the impulse
//! that stops it there acts over the whole step, which is of first order in the step. So a step in
//! which a joint reaches its stop is split in two, and the first part ends just before that.

use super::ReactionSolver;
use crate::contact::reactions::reaction::{Part, Reaction};
use crate::robot::articulated::Articulated;

/// The least energy of an impact on a stop for which the step is split, relative to a wheel's load
/// times its radius: 15 uJ for a robot of 12 kg on wheels of 50 mm. Chosen.
const LEAST_WORK: f64 = 1e-5;

/// The approach of a joint to its stop in a step, in rad and rad/s, or m and m/s.
struct Approach {
    /// Distance at the beginning of the step.
    gap: f64,
    /// Approach speed.
    closes: f64,
    /// The impulse that stops it, in N m s or N s.
    impulse: f64,
}

impl Approach {
    /// Whether it reaches the stop within a step.
    fn lands(&self, dt_s: f64) -> bool {
        self.gap > 0.0 && self.gap < self.closes * dt_s
    }
}

impl ReactionSolver {
    /// The time in a solved step of `dt_s`, in seconds, at which the first joint reaches its stop;
    /// infinite if none does.
    pub fn lands_after_s(&self, bodies: &[Articulated], dt_s: f64) -> f64 {
        let mut first_s = f64::INFINITY;
        for reaction in &self.all {
            let body = &bodies[reaction.a.body];
            let Some(comes) = approach(reaction, body) else {
                continue;
            };
            let scale = &body.scale;
            let least_j = LEAST_WORK * scale.load_kg * scale.gravity_m_s2 * scale.length_m;
            if comes.lands(dt_s) && comes.impulse * comes.gap > least_j * dt_s {
                first_s = first_s.min(comes.gap / comes.closes);
            }
        }
        first_s
    }

    /// Largest penetration between an articulated body and its partners in the middle of the last
    /// step, in metres.
    pub fn pressed_m(&self, body: usize) -> f64 {
        let contacts = self.all.iter().filter(|reaction| reaction.rows() == 3);
        let depths_m =
            contacts.zip(&self.gaps_m).map(
                |(contact, (gap_m, _))| {
                    if contact.touches(body) { -gap_m } else { 0.0 }
                },
            );
        depths_m.fold(0.0, f64::max)
    }

    /// Increase of the deepest penetration of an articulated body over the last step, if everything
    /// moved with the mean rates, in metres.
    pub fn sinks_m(&self, body: usize, dt_s: f64) -> f64 {
        let contacts = self.all.iter().filter(|reaction| reaction.rows() == 3);
        let rigid = contacts
            .zip(&self.gaps_m)
            .filter(|(contact, _)| contact.tread().is_none() && contact.touches(body));
        let sinks = rigid.map(|(contact, (gap_m, before_m))| {
            let then_m = gap_m + 0.5 * dt_s * contact.velocity_after.x;
            before_m.min(0.0) - then_m
        });
        sinks.fold(0.0, f64::max)
    }
}

/// The approach of a joint to the stop of a reaction; `None` for other reactions.
fn approach(reaction: &Reaction, body: &Articulated) -> Option<Approach> {
    let Part::Stop(joint, ahead) = reaction.a.part else {
        return None;
    };
    let way = if ahead { 1.0 } else { -1.0 };
    let stop = body.robot.joints[joint].limits[usize::from(ahead)];
    Some(Approach {
        gap: way * (stop - body.step.before.joint_positions()[joint]),
        closes: way * body.step.before.joint_rates()[joint],
        impulse: -way * reaction.impulse.x,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_gets_there_within_the_step_lands() {
        let lands = |gap: f64, closes: f64| {
            let comes = Approach {
                gap,
                closes,
                impulse: 1.0,
            };
            comes.lands(2e-3)
        };
        assert!(lands(1e-5, 0.02));
        assert!(!lands(5e-5, 0.02));
        assert!(!lands(-1e-5, 0.02));
        assert!(!lands(1e-5, -0.02));
    }
}
