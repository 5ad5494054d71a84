//! The factorised mass matrix.
//!
//! H = L^T L with L lower triangular has zeros wherever H has: between joints that are on no common
//! path from the root (Featherstone 2008, section 6.5). A right-hand side b is solved in two
//! halves, z = L^-T b and x = L^-1 z; the effect of a row J_2 through the body on another row is
//! J_1 H^-1 J_2^T = z_1 . z_2, for which the first half is enough, and for a row on one link it is
//! as sparse as the row.

use nalgebra::Vector6;

use super::tree::{Path, ROOT_DOFS, Tree};

/// A mass matrix, or its factors.
#[derive(Clone, Debug)]
pub(crate) struct Factors {
    /// Of the root's own degrees of freedom, on and below the diagonal.
    pub(super) root: [[f64; ROOT_DOFS]; ROOT_DOFS],
    /// One over the diagonal of the factor.
    root_inverse: [f64; ROOT_DOFS],
    pub(super) joints: Vec<OfJoint>,
    /// Coupling of each joint with those between it and the root, indexed by [`Tree::entries_of`].
    pub(super) between: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct OfJoint {
    /// Coupling with the root.
    pub root: Vector6<f64>,
    /// The diagonal; its inverse once factorised.
    pub own: f64,
}

impl Factors {
    /// Memory for a tree.
    pub fn of(tree: &Tree) -> Self {
        let empty = OfJoint {
            root: Vector6::zeros(),
            own: 0.0,
        };
        Self {
            root: [[0.0; ROOT_DOFS]; ROOT_DOFS],
            root_inverse: [0.0; ROOT_DOFS],
            joints: vec![empty; tree.joints().len()],
            between: vec![0.0; tree.entries()],
        }
    }

    /// Factorises the matrix in place. It is positive definite, because every link has a mass.
    pub(super) fn factorise(&mut self, tree: &Tree) {
        for joint in (0..self.joints.len()).rev() {
            let inverse = 1.0 / self.joints[joint].own.sqrt();
            let of_root = self.joints[joint].root * inverse;
            self.joints[joint] = OfJoint {
                root: of_root,
                own: inverse,
            };
            let ancestors = tree.ancestors(joint);
            let start = tree.entries_of(joint).start;
            for (at, ancestor) in ancestors.iter().map(|at| usize::from(*at)).enumerate() {
                self.between[start + at] *= inverse;
                let share = self.between[start + at];
                self.joints[ancestor].own -= share * share;
                self.joints[ancestor].root -= share * of_root;
                let into = tree.entries_of(ancestor).start;
                for further in 0..at {
                    self.between[into + further] -= share * self.between[start + further];
                }
            }
            for (row, share) in of_root.iter().enumerate() {
                for (entry, other) in self.root[row][..=row].iter_mut().zip(&of_root) {
                    *entry -= share * other;
                }
            }
        }
        for row in (0..ROOT_DOFS).rev() {
            let inverse = 1.0 / self.root[row][row].sqrt();
            self.root_inverse[row] = inverse;
            let (above, own) = self.root.split_at_mut(row);
            let own = &mut own[0][..row];
            own.iter_mut().for_each(|entry| *entry *= inverse);
            for (into, share) in above.iter_mut().zip(&*own) {
                for (entry, other) in into.iter_mut().zip(&*own) {
                    *entry -= share * other;
                }
            }
        }
    }

    /// The first half of the solution for a row on one link.
    #[inline]
    pub fn halve(&self, tree: &Tree, root: &mut Vector6<f64>, path: &mut Path) {
        let (joints, shares) = path.parts_mut();
        for at in (0..joints.len()).rev() {
            let joint = usize::from(joints[at]);
            let of = &self.joints[joint];
            let half = shares[at] * of.own;
            shares[at] = half;
            let start = tree.entries_of(joint).start;
            for (share, between) in shares[..at].iter_mut().zip(&self.between[start..]) {
                *share -= between * half;
            }
            *root -= half * of.root;
        }
        self.halve_root(root);
    }

    #[inline]
    fn halve_root(&self, root: &mut Vector6<f64>) {
        for row in (0..ROOT_DOFS).rev() {
            let half = root[row] * self.root_inverse[row];
            root[row] = half;
            for (other, l) in root.as_mut_slice()[..row].iter_mut().zip(&self.root[row]) {
                *other -= l * half;
            }
        }
    }

    /// Solves for one right-hand side, in place.
    pub fn solve(&self, tree: &Tree, x: &mut [f64]) {
        let (of_root, of_joints) = x.split_at_mut(ROOT_DOFS);
        let mut root = Vector6::from_column_slice(of_root);
        for joint in (0..of_joints.len()).rev() {
            let of = &self.joints[joint];
            let half = of_joints[joint] * of.own;
            of_joints[joint] = half;
            let start = tree.entries_of(joint).start;
            for (ancestor, between) in tree.ancestors(joint).iter().zip(&self.between[start..]) {
                of_joints[usize::from(*ancestor)] -= between * half;
            }
            root -= half * of.root;
        }
        self.halve_root(&mut root);
        of_root.copy_from_slice(root.as_slice());
        self.complete(tree, x);
    }

    /// The second half of a solution, in place.
    pub fn complete(&self, tree: &Tree, x: &mut [f64]) {
        let (of_root, of_joints) = x.split_at_mut(ROOT_DOFS);
        for row in 0..ROOT_DOFS {
            let (known, own) = of_root.split_at_mut(row);
            for (l, x) in self.root[row].iter().zip(&*known) {
                own[0] -= l * x;
            }
            own[0] *= self.root_inverse[row];
        }
        for (joint, of) in self.joints.iter().enumerate() {
            let mut left = of_joints[joint];
            for (l, x) in of.root.iter().zip(&*of_root) {
                left -= l * x;
            }
            let start = tree.entries_of(joint).start;
            for (ancestor, l) in tree.ancestors(joint).iter().zip(&self.between[start..]) {
                left -= l * of_joints[usize::from(*ancestor)];
            }
            of_joints[joint] = left * of.own;
        }
    }
}
