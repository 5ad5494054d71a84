//! How the bodies answer to impulses, as they are held in the step.

use crate::contact::reactions::potential::Axle;
use crate::contact::reactions::row::{Row, Side};
use crate::contact::scene::Scenes;

/// How bodies answer to each row, and to each of their joints: solved halfway.
///
/// With M = L^T L of each body, held by its motors and bearings as in the step, and z = L^-T J^T for each row, what the
/// unit impulse of one row does to the velocity of another is the product of their z; what impulses p do to the rates is L^-1 of
/// the sum of p z. So rows stay sparse, and the second half is left to do once for all of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Responses {
    /// Where the degrees of freedom of each body begin among all, and where those of the last one end.
    starts: Vec<usize>,
    /// The half of each row.
    rows: Vec<Row>,
    /// That of each joint, of all bodies one after the other.
    joints: Vec<Side>,
}

impl Responses {
    /// Begins anew.
    pub fn clear(&mut self, scenes: Scenes<'_>) {
        self.rows.clear();
        self.joints.clear();
        self.starts.clear();
        self.starts.push(0);
        let mut end = 0;
        for scene in scenes.each() {
            end += scene.tree.dofs();
            self.starts.push(end);
        }
    }

    /// Degrees of freedom of all bodies.
    pub fn dofs(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Where a body's degrees of freedom stand among all.
    pub fn dofs_of(&self, body: usize) -> std::ops::Range<usize> {
        self.starts[body]..self.starts[body + 1]
    }

    /// Finds the halves of all rows.
    pub fn find(&mut self, rows: &[Row], scenes: Scenes<'_>) {
        self.rows.extend_from_slice(rows);
        let sides = self.rows.iter_mut().flat_map(Row::sides_mut);
        sides.for_each(|side| halve(side, scenes));
    }

    /// Finds those of all joints as well.
    pub fn find_of_joints(&mut self, scenes: Scenes<'_>) {
        for scene in scenes.each() {
            for joint in 0..scene.tree.joints().len() {
                let mut side = scene.of_joint(joint, 1.0);
                halve(&mut side, scenes);
                self.joints.push(side);
            }
        }
    }

    /// How many joints all bodies have.
    pub fn joints(&self) -> usize {
        self.joints.len()
    }

    /// What the unit impulse of a row does to a joint's rate.
    pub fn at_joint(&self, row: usize, joint: usize) -> f64 {
        let joint = &self.joints[joint];
        let sides = self.rows[row]
            .sides()
            .filter(|side| side.body == joint.body);
        sides.map(|side| side.dot(joint)).sum()
    }

    /// What the unit impulse in a joint does to another's rate.
    pub fn between_joints(&self, joint: usize, other: usize) -> f64 {
        let (a, b) = (&self.joints[joint], &self.joints[other]);
        if a.body == b.body { a.dot(b) } else { 0.0 }
    }

    /// Adds the half of what an impulse of a row does to the rates of all bodies.
    pub fn add_row(&self, row: usize, impulse: f64, halves: &mut [f64]) {
        for side in self.rows[row].sides() {
            side.add_to(impulse, &mut halves[self.dofs_of(side.body)]);
        }
    }

    /// The same of an impulse in a joint.
    pub fn add_joint(&self, joint: usize, impulse: f64, halves: &mut [f64]) {
        let side = &self.joints[joint];
        side.add_to(impulse, &mut halves[self.dofs_of(side.body)]);
    }

    /// Takes such halves to the rates of all bodies, in place.
    pub fn complete(&self, scenes: Scenes<'_>, halves: &mut [f64]) {
        for scene in scenes.each() {
            let of_body = &mut halves[self.dofs_of(scene.index)];
            scene.factors().complete(scene.tree, of_body);
        }
    }

    /// W of a row and those up to it: what the unit impulse of each does to the velocity of this one.
    pub fn fill_w(&self, axles: &[Axle], at: usize, w: &mut [f64]) {
        let row = &self.rows[at];
        let responses = |axle: usize| axles[axle].responses();
        for (other, w) in self.rows.iter().zip(w) {
            *w = of_links((row, other)) + of_axles((row, other), responses);
        }
    }
}

/// Solves halfway.
#[inline]
fn halve(side: &mut Side, scenes: Scenes<'_>) {
    let scene = scenes.of(side.body);
    scene
        .factors()
        .halve(scene.tree, &mut side.root, &mut side.joints);
}

/// What the links add to W of two rows, of which the halves are given.
#[inline]
fn of_links((at, by): (&Row, &Row)) -> f64 {
    if at.b.is_none() && by.b.is_none() {
        return if at.a.body == by.a.body {
            at.a.dot(&by.a)
        } else {
            0.0
        };
    }
    let mut sum = 0.0;
    for at in at.sides() {
        for by in by.sides().filter(|by| by.body == at.body) {
            sum += at.dot(by);
        }
    }
    sum
}

/// What rollers about and along their axes add to W of two rows, given how each answers about its axis and along it.
#[inline]
pub(crate) fn of_axles((at, by): (&Row, &Row), responses: impl Fn(usize) -> [f64; 2]) -> f64 {
    let of_one = |at: &Side, by: &Side| match (at.axle, by.axle) {
        (Some((i, a)), Some((j, b))) if i == j => {
            let [about, along] = responses(i);
            a * b * about + at.slide * by.slide * along
        }
        _ => 0.0,
    };
    if at.b.is_none() && by.b.is_none() {
        return of_one(&at.a, &by.a);
    }
    let mut sum = 0.0;
    for at in at.sides() {
        for by in by.sides() {
            sum += of_one(at, by);
        }
    }
    sum
}
