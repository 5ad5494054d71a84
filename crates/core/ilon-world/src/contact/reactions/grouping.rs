//! Reactions of the last step when bodies come together in one problem, or part: each goes on where it acted.

use super::Reactions;
use crate::contact::reactions::reaction::{Part, Partner, Reaction};

impl Reactions {
    /// Adds those of other bodies, which now stand behind so many.
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

    /// Those by which a chassis, what hangs on it or a roller acts on another body: each with that body's place.
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

    /// Adds one of the last step between A and B, as they are numbered now.
    pub fn go_on(&mut self, mut reaction: Reaction, a: usize, b: Option<usize>) {
        reaction.a.body = a;
        if let (Partner::Of(member), Some(b)) = (&mut reaction.b, b) {
            member.body = b;
        }
        self.all.push(reaction);
    }

    /// Takes out those of bodies that stand behind so many.
    pub fn split_off_behind(&mut self, first: usize) -> Vec<Reaction> {
        let is_behind = |reaction: &mut Reaction| {
            let of_b = matches!(reaction.b, Partner::Of(member) if member.body >= first);
            of_b || reaction.a.body >= first
        };
        self.all.extract_if(.., is_behind).collect()
    }

    /// Keeps those of some bodies, as they are numbered among these, and gives those of the others. What was between the two is forgotten.
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

    /// Who touches whom, by their numbers; none is the ground.
    fn pairs(reactions: &Reactions) -> Vec<(usize, Option<usize>)> {
        let pair = |reaction: &Reaction| match reaction.b {
            Partner::Of(b) => (reaction.a.body, Some(b.body)),
            _ => (reaction.a.body, None),
        };
        reactions.all.iter().map(pair).collect()
    }

    /// Of four bodies 0 and 2 stay and 1 and 3 leave, each numbered anew among their own; put behind the first two they are 2 and 3. What was between those that
    /// stay and those that leave is forgotten.
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
