//! The reactions of the last step: the part of a step that is kept until the next one, and that can
//! be queried.

use crate::contact::reactions::reaction::{Member, Part, Partner, Reaction};
use crate::robot::articulated::Articulated;
use crate::settings::ContactSpring;

/// The reactions of the last step, or of the last part of a split one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reactions {
    all: Vec<Reaction>,
    /// Their violation of the laws, in m/s or rad/s.
    error: f64,
    /// Its length, in seconds.
    dt_s: f64,
    /// Energy of treads that left the ground in it, in J.
    released_j: f64,
}

/// The spring of a contact: a robot's own with the ground, the softer one between two robots.
pub(super) fn spring_between(bodies: &[Articulated], a: Member, b: Partner) -> ContactSpring {
    let of_a = bodies[a.body].spring;
    match b {
        Partner::Of(member) => of_a.softer(bodies[member.body].spring),
        Partner::Ground | Partner::Itself => of_a,
    }
}

impl Reactions {
    /// Takes over the solution of a step of `dt_s`. Only the memory that is needed is kept, because
    /// many worlds share one solver.
    pub(super) fn take_solved(
        &mut self,
        solved: &mut Vec<Reaction>,
        (error, released_j): (f64, f64),
        dt_s: f64,
    ) {
        self.all.clear();
        self.all.reserve_exact(solved.len());
        self.all.append(solved);
        (self.error, self.released_j, self.dt_s) = (error, released_j, dt_s);
    }

    /// Takes over another solver's reactions in the step, and their violation of the laws, in m/s
    /// or rad/s.
    pub fn take(&mut self, reactions: Vec<(Reaction, f64)>) {
        let (mut all, errors): (Vec<_>, Vec<_>) = reactions.into_iter().unzip();
        let error = errors.into_iter().fold(0.0, f64::max);
        self.take_solved(&mut all, (error, 0.0), self.dt_s);
    }

    /// Forgets all but contacts.
    pub fn keep_contacts(&mut self) {
        self.all.retain(|reaction| reaction.rows() == 3);
        self.error = 0.0;
        self.released_j = 0.0;
    }

    /// The reactions of the last step.
    pub fn all(&self) -> &[Reaction] {
        &self.all
    }

    /// Those with an articulated body as A.
    pub fn of_body(&self, body: usize) -> impl Iterator<Item = &Reaction> {
        let all = self.all.iter();
        all.filter(move |reaction| reaction.a.body == body)
    }

    /// Energy taken by the dry bearings and joints of an articulated body, the stops of its rollers
    /// and rolling resistance in the last step, in J.
    pub fn bearings_took_j(&self, body: usize) -> f64 {
        let is_bearing = |r: &&Reaction| {
            matches!(
                r.a.part,
                Part::Hub(_)
                    | Part::Axle(..)
                    | Part::Slide(..)
                    | Part::Rolling(..)
                    | Part::Friction(_)
            )
        };
        let bearings = self.of_body(body).filter(is_bearing);
        bearings.map(|reaction| reaction.taken_j.sum()).sum()
    }

    /// Whether a rigid roller slides along its axle, or is about to slide: its friction is near its
    /// limit. One that only spins up slides across its axle. A soft roller is at its limit whenever
    /// it takes over, and its tread determines when it slides.
    pub fn slides_soon(&self, bodies: &[Articulated]) -> bool {
        /// A share of the limit that counts as near. Chosen.
        const NEAR_LIMIT: f64 = 0.5;
        /// A roller that slides faster, in its robot's unit of speed, and not along its axle, spins
        /// up: 3 cm/s for wheels of 50 mm. Chosen.
        const SPINS_UP: f64 = 0.043;
        self.all.iter().any(|reaction| {
            let fast_m_s = SPINS_UP * bodies[reaction.a.body].scale.speed_m_s();
            let slides_m_s = reaction.velocity_after.yz();
            let limit = NEAR_LIMIT * reaction.friction * reaction.impulse.x;
            matches!(reaction.a.part, Part::Roller(..))
                && reaction.tread().is_none()
                && limit > 0.0
                && reaction.impulse.yz().norm() > limit
                && (slides_m_s.norm() < fast_m_s || slides_m_s.x.abs() > 0.5 * fast_m_s)
        })
    }

    /// The violation of the laws in the last step, in m/s or rad/s.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Energy in the treads of rollers, in J.
    pub fn treads_j(&self) -> f64 {
        self.all.iter().map(Reaction::tread_j).sum()
    }

    /// Energy of treads that left the ground in the last step, and was lost, in J.
    pub fn released_j(&self) -> f64 {
        self.released_j
    }

    /// Energy in the springs of rigid contacts, in J: F^2 / (2 k) each.
    pub fn spring_energy_j(&self, bodies: &[Articulated], dt_s: f64) -> f64 {
        // Those of coupled bodies among themselves are rapier's.
        let is_rigid = |reaction: &&Reaction| {
            let is_coupled = bodies[reaction.a.body].coupled().is_some();
            reaction.rows() == 3 && reaction.tread().is_none() && !is_coupled
        };
        let contacts = self.all.iter().filter(is_rigid);
        let energy_j = |reaction: &Reaction| {
            let spring = spring_between(bodies, reaction.a, reaction.b);
            0.5 * (reaction.impulse.x / dt_s).powi(2) / spring.stiffness_n_m
        };
        contacts.map(energy_j).sum()
    }

    /// Length of the step, in seconds; 0 before the first.
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }
}

/// For bodies that join one problem, or leave it: each continues with its impulses.
impl Reactions {
    /// Adds those of other bodies, which are now numbered from `bodies` on.
    pub fn append(&mut self, mut other: Self, bodies: usize) {
        for reaction in &mut other.all {
            reaction.a.body += bodies;
            if let Partner::Of(member) = &mut reaction.b {
                member.body += bodies;
            }
        }
        self.all.append(&mut other.all);
        self.dt_s = self.dt_s.max(other.dt_s);
        self.error = self.error.max(other.error);
    }

    /// Those by which a chassis, a body on its joints or a roller acts on another body: each with
    /// that body's index.
    pub fn on_bodies(&self) -> impl Iterator<Item = (&Reaction, usize)> {
        self.all
            .iter()
            .filter_map(|reaction| match (reaction.a.part, reaction.b) {
                (Part::Chassis | Part::Link(_) | Part::Roller(..), Partner::Of(b)) => {
                    Some((reaction, b.body))
                }
                _ => None,
            })
    }

    /// Adds one of the last step between A and B, by their current numbers.
    pub fn go_on(&mut self, mut reaction: Reaction, a: usize, b: Option<usize>) {
        reaction.a.body = a;
        if let (Partner::Of(member), Some(b)) = (&mut reaction.b, b) {
            member.body = b;
        }
        self.all.push(reaction);
    }

    /// Removes those of bodies numbered from `first` on.
    pub fn split_off_behind(&mut self, first: usize) -> Vec<Reaction> {
        let is_behind = |reaction: &mut Reaction| {
            let of_b = matches!(reaction.b, Partner::Of(member) if member.body >= first);
            of_b || reaction.a.body >= first
        };
        self.all.extract_if(.., is_behind).collect()
    }

    /// Keeps those of some bodies, renumbered among these, and returns those of the others. Those
    /// between the two groups are dropped.
    pub fn split_off(&mut self, keeps: impl Fn(usize) -> bool) -> Self {
        let renumbered = |body: usize| (0..body).filter(|of| keeps(*of) == keeps(body)).count();
        let mut left = Self {
            dt_s: self.dt_s,
            error: self.error,
            ..Self::default()
        };
        for mut reaction in std::mem::take(&mut self.all) {
            let stays = keeps(reaction.a.body);
            reaction.a.body = renumbered(reaction.a.body);
            if let Partner::Of(member) = &mut reaction.b {
                if keeps(member.body) != stays {
                    continue;
                }
                member.body = renumbered(member.body);
            }
            let to: &mut Vec<Reaction> = if stays { &mut self.all } else { &mut left.all };
            to.push(reaction);
        }
        left
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::contact::reactions::reaction::Member;

    /// The touching pairs by number; `None` is the ground.
    fn pairs(reactions: &Reactions) -> Vec<(usize, Option<usize>)> {
        let pair = |reaction: &Reaction| match reaction.b {
            Partner::Of(b) => (reaction.a.body, Some(b.body)),
            _ => (reaction.a.body, None),
        };
        reactions.all.iter().map(pair).collect()
    }

    /// Of four bodies 0 and 2 stay and 1 and 3 leave, each numbered anew within its group; appended
    /// to the first two they are 2 and 3. Reactions between those that stay and those that leave
    /// are dropped.
    #[test]
    fn bodies_that_part_and_meet_keep_their_reactions() {
        let member = |body: usize| Member {
            body,
            part: Part::Chassis,
        };
        let mut stay = Reactions::default();
        for (a, b) in [
            (0, None),
            (1, None),
            (2, Some(0)),
            (3, Some(1)),
            (2, Some(1)),
        ] {
            let mut reaction = Reaction::within(member(a), Vector3::zeros());
            reaction.b = b.map_or(Partner::Ground, |b| Partner::Of(member(b)));
            stay.all.push(reaction);
        }
        let leave = stay.split_off(|body| body % 2 == 0);
        assert_eq!(pairs(&stay), [(0, None), (1, Some(0))]);
        assert_eq!(pairs(&leave), [(0, None), (1, Some(0))]);
        stay.append(leave, 2);
        assert_eq!(
            pairs(&stay),
            [(0, None), (1, Some(0)), (2, None), (3, Some(2))]
        );
    }
}
