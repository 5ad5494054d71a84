//! The response of the bodies to impulses, with the implicit damping of the step.

use crate::contact::reactions::potential::Axle;
use crate::contact::reactions::row::{Row, Side};
use crate::contact::scene::Scenes;

/// The response of bodies to each row, and to each of their joints: half solved.
///
/// With M = L^T L for each body, including the damping of its motors and bearings in the step, and
/// z = L^-T J^T for each row, the effect of one row's unit impulse on another row's velocity is the
/// product of their z; the effect of impulses p on the rates is L^-1 times the sum of p z. So rows
/// stay sparse, and the second half is solved only once for all of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Responses {
    /// The first degree of freedom of each body among all, and the end of the last.
    starts: Vec<usize>,
    /// The half solution of each row.
    rows: Vec<Row>,
    /// The half solutions of the rows once more, one degree of freedom of all bodies after the
    /// other; empty if a row is between two bodies.
    pub columns: Vec<f64>,
    /// The half solution of each joint, of all bodies one after the other.
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

    /// The range of a body's degrees of freedom among all.
    pub fn dofs_of(&self, body: usize) -> std::ops::Range<usize> {
        self.starts[body]..self.starts[body + 1]
    }

    /// Solves the first half for all rows.
    pub fn find(&mut self, rows: &[Row], scenes: Scenes<'_>) {
        self.rows.extend_from_slice(rows);
        let sides = self.rows.iter_mut().flat_map(Row::sides_mut);
        sides.for_each(|side| halve(side, scenes));
        self.columns.clear();
        if self.rows.iter().all(|row| row.b.is_none()) {
            let count = self.rows.len();
            self.columns.resize(self.dofs() * count, 0.0);
            for (at, row) in self.rows.iter().enumerate() {
                let start = self.starts[row.a.body];
                row.a
                    .each_dof(|dof, z| self.columns[(start + dof) * count + at] = z);
            }
        }
    }

    /// Solves it for all joints as well.
    pub fn find_of_joints(&mut self, scenes: Scenes<'_>) {
        for scene in scenes.each() {
            for joint in 0..scene.tree.joints().len() {
                let mut side = scene.of_joint(joint, 1.0);
                halve(&mut side, scenes);
                self.joints.push(side);
            }
        }
    }

    /// The number of joints of all bodies.
    pub fn joints(&self) -> usize {
        self.joints.len()
    }

    /// Effect of the unit impulse of a row on a joint's rate.
    pub fn at_joint(&self, row: usize, joint: usize) -> f64 {
        let joint = &self.joints[joint];
        let sides = self.rows[row]
            .sides()
            .filter(|side| side.body == joint.body);
        sides.map(|side| side.dot(joint)).sum()
    }

    /// Effect of the unit impulse in a joint on another's rate.
    pub fn between_joints(&self, joint: usize, other: usize) -> f64 {
        let (a, b) = (&self.joints[joint], &self.joints[other]);
        if a.body == b.body { a.dot(b) } else { 0.0 }
    }

    /// Adds the half solution for an impulse of a row, for the rates of all bodies.
    pub fn add_row(&self, row: usize, impulse: f64, halves: &mut [f64]) {
        for side in self.rows[row].sides() {
            side.add_to(impulse, &mut halves[self.dofs_of(side.body)]);
        }
    }

    /// The same for an impulse in a joint.
    pub fn add_joint(&self, joint: usize, impulse: f64, halves: &mut [f64]) {
        let side = &self.joints[joint];
        side.add_to(impulse, &mut halves[self.dofs_of(side.body)]);
    }

    /// Solves the second half in place: the rates of all bodies.
    pub fn complete(&self, scenes: Scenes<'_>, halves: &mut [f64]) {
        for scene in scenes.each() {
            let of_body = &mut halves[self.dofs_of(scene.index)];
            scene.factors().complete(scene.tree, of_body);
        }
    }

    /// W of a row and those up to it: the effect of each unit impulse on this row's velocity.
    pub fn fill_w(&self, axles: &[Axle], at: usize, w: &mut [f64]) {
        let row = &self.rows[at];
        if self.columns.is_empty() {
            for (other, w) in self.rows.iter().zip(&mut *w) {
                *w = of_links((row, other));
            }
        } else {
            let (start, count) = (self.starts[row.a.body], self.rows.len());
            row.a.each_dof(|dof, share| {
                let column = &self.columns[(start + dof) * count..];
                for (w, z) in w.iter_mut().zip(column) {
                    *w += share * z;
                }
            });
        }
        if row.sides().any(|side| side.axle.is_some()) {
            let responses = |axle: usize| axles[axle].responses();
            for (other, w) in self.rows.iter().zip(w) {
                *w += of_axles((row, other), responses);
            }
        }
    }
}

/// Solves the first half.
#[inline]
fn halve(side: &mut Side, scenes: Scenes<'_>) {
    let scene = scenes.of(side.body);
    scene
        .factors()
        .halve(scene.tree, &mut side.root, &mut side.joints);
}

/// The links' contribution to W of two rows, given their half solutions.
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

/// The contribution to W of two rows by rollers about and along their axes, given the response of
/// each about its axis and along it.
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
