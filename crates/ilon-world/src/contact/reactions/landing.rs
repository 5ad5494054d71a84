//! What lands within a step, and when.
//!
//! A contact that is still open when a step begins may come no nearer than to touch: u_1 >= -g / dt with g its gap. The impulse that stops it there holds
//! back what comes, which is right; but it also bears what load there is, over a way on which nothing touches yet. Where another contact bears that load
//! until then, as the roller before bears a wheel that leans, the energy load x g is lost: to first order in the step, at every landing. So a step in
//! which something lands under load is taken in two parts, and the first of them ends just before the landing.
//!
//! The next roller of a wheel that does not lean comes down without a hit: what closes its gap slows down by R w^2, and is at rest as it takes over. What
//! closes by v in the middle of the step, with a gap g left, lands at sqrt(v^2 - 2 R w^2 g); where that is next to nothing, nothing hits.

use super::Reactions;
use crate::contact::reactions::reaction::{Part, Reaction};
use crate::robot::articulated::Articulated;

/// Of the load of a wheel and its radius, the least energy for which a landing is a matter of its own: 15 uJ of a robot of 12 kg on wheels of 50 mm.
const LEAST_WORK: f64 = 1e-5;

/// The least share of its speed in the middle of a step with which a roller that hits comes down.
const HITS: f64 = 0.25;

/// How something comes to what stops it in a step, in m and m/s or rad and rad/s.
struct Approach {
    /// How far it has to go when the step begins and in its middle.
    gaps: [f64; 2],
    /// How fast it goes in the middle, and by how much it slows down until it is there, per second.
    closes: f64,
    slows: f64,
    /// The impulse that stops it, in N s or N m s.
    impulse: f64,
}

impl Approach {
    /// Whether it lands within a step, and hits.
    fn lands(&self, dt_s: f64) -> bool {
        let [start, middle] = self.gaps;
        let speed_2 = self.closes * self.closes;
        let left_2 = speed_2 - 2.0 * self.slows * middle.max(0.0);
        start > 0.0 && start < self.closes * dt_s && left_2 > HITS * HITS * speed_2
    }
}

impl Reactions {
    /// After how many seconds of a step of `dt_s` that has been solved the first of what lands under load does so; infinite where nothing does.
    pub fn lands_after_s(&self, bodies: &[Articulated], dt_s: f64) -> f64 {
        let mut gaps_m = self.gaps_m.iter();
        let mut first_s = f64::INFINITY;
        for reaction in &self.all {
            let gaps_m = if reaction.rows() == 3 {
                gaps_m.next()
            } else {
                None
            };
            let body = &bodies[reaction.a.body];
            // A robot without joints stands on wheels that do not lean: what bears its load until then is in line with what lands.
            if body.robot.joints.is_empty() {
                continue;
            }
            let Some(comes) = approach(reaction, gaps_m, body, dt_s) else {
                continue;
            };
            let scale = &body.scale;
            let least_j = LEAST_WORK * scale.load_kg * scale.gravity_m_s2 * scale.length_m;
            let [gap, _] = comes.gaps;
            if comes.lands(dt_s) && comes.impulse * gap > least_j * dt_s {
                first_s = first_s.min(gap / comes.closes);
            }
        }
        first_s
    }

    /// How deep an articulated body and what it touches were in one another in the middle of the last step at most, in metres.
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

    /// By how much deeper than when it began the deepest contact of an articulated body would be at the end of the last step if
    /// all moved on with the mean of the rates, in metres.
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

/// How a rigid roller, whose gaps in the middle of the step and when it began are given in metres, or a joint comes to what stops it; `None` of all
/// else.
fn approach(
    reaction: &Reaction,
    gaps_m: Option<&(f64, f64)>,
    body: &Articulated,
    dt_s: f64,
) -> Option<Approach> {
    match reaction.a.part {
        // A robot in the air has no load that anything could bear until then.
        Part::Roller(wheel, _) if reaction.tread().is_none() && body.is_touched => {
            let (middle_m, start_m) = gaps_m?;
            let rate_rad_s = body.before.wheel_rates_rad_s()[wheel];
            Some(Approach {
                gaps: [*start_m, *middle_m],
                closes: -reaction.velocity_before.x,
                slows: body.robot.wheels[wheel].radius_m * rate_rad_s * rate_rad_s,
                impulse: reaction.impulse.x,
            })
        }
        Part::Stop(joint, ahead) => {
            let way = if ahead { 1.0 } else { -1.0 };
            let stop = body.robot.joints[joint].limits[usize::from(ahead)];
            let gap = way * (stop - body.before.joint_positions()[joint]);
            let closes = way * body.before.joint_rates()[joint];
            Some(Approach {
                gaps: [gap, gap - 0.5 * dt_s * closes],
                closes,
                slows: 0.0,
                impulse: -way * reaction.impulse.x,
            })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gap that closes at a steady rate from its start on.
    fn steady(gap: f64, closes: f64, dt_s: f64) -> Approach {
        Approach {
            gaps: [gap, gap - 0.5 * dt_s * closes],
            closes,
            slows: 0.0,
            impulse: 1.0,
        }
    }

    #[test]
    fn what_gets_there_within_the_step_lands() {
        let dt_s = 2e-3;
        assert!(steady(1e-5, 0.02, dt_s).lands(dt_s));
        assert!(!steady(5e-5, 0.02, dt_s).lands(dt_s));
        assert!(!steady(-1e-5, 0.02, dt_s).lands(dt_s));
        assert!(!steady(1e-5, -0.02, dt_s).lands(dt_s));
    }

    /// The next roller of an upright wheel: its gap is c t^2 / 2 a time t before it takes over, and closes at c t. Of one that leans the gap closes
    /// faster, and is larger, by what it hits with.
    #[test]
    fn what_is_at_rest_as_it_gets_there_does_not_hit() {
        let (dt_s, curves_m_s2) = (2e-3, 3.2);
        for (until_s, hits_m_s, lands) in [
            (1.8e-3, 0.0, false),
            (1.4e-3, 0.0, false),
            (1.8e-3, 5e-3, true),
            (1.4e-3, 5e-3, true),
        ] {
            let left_s: f64 = until_s - 0.5 * dt_s;
            let closes = curves_m_s2 * left_s + hits_m_s;
            let middle = 0.5 * curves_m_s2 * left_s * left_s + hits_m_s * left_s;
            let comes = Approach {
                gaps: [middle + 0.5 * dt_s * closes, middle],
                closes,
                slows: curves_m_s2,
                impulse: 1.0,
            };
            assert_eq!(comes.lands(dt_s), lands, "{until_s} {hits_m_s}");
        }
    }
}
