//! The dependence of a velocity on the rates of the two bodies between which it is measured.

use nalgebra::Vector6;

use crate::dynamics::{Path, ROOT_DOFS};

/// One velocity as a function of the rates of two bodies, and the effect of a unit impulse there on
/// them: for a contact the velocity of body A relative to body B, for a joint the rate between
/// parts of body A.
///
/// It is sparse: it has entries only for the one or two bodies that move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub a: Side,
    /// `None` if B is the ground, which never moves, and for joints within A.
    pub b: Option<Side>,
}

/// The entries of a row for one articulated body: its root, the joints on the way to one of its
/// links, and one of its rollers about its axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// Its index among the articulated bodies.
    pub body: usize,
    pub root: Vector6<f64>,
    pub joints: Path,
    /// Index among the axles, and coefficient.
    pub axle: Option<(usize, f64)>,
    /// Coefficient of the velocity of that roller along its axle.
    pub slide: f64,
}

impl Row {
    /// For a reaction on A alone.
    pub fn of_one(a: Side) -> Self {
        Self { a, b: None }
    }

    /// The one or two bodies that move.
    #[inline]
    pub fn sides(&self) -> impl Iterator<Item = &Side> {
        std::iter::once(&self.a).chain(&self.b)
    }

    /// The same, mutable.
    #[inline]
    pub fn sides_mut(&mut self) -> impl Iterator<Item = &mut Side> {
        std::iter::once(&mut self.a).chain(&mut self.b)
    }
}

impl Side {
    /// With entries for joints of one body.
    pub fn of_joints(body: usize, joints: Path) -> Self {
        Self {
            body,
            root: Vector6::zeros(),
            joints,
            axle: None,
            slide: 0.0,
        }
    }

    /// The part of the velocity from the links, with these rates by degree of freedom of the body.
    #[inline]
    pub fn of_bodies(&self, rates: &[f64]) -> f64 {
        let of_root = self.root.iter().zip(rates).map(|(c, rate)| c * rate);
        let of_joints = self
            .joints
            .iter()
            .map(|(joint, c)| c * rates[ROOT_DOFS + joint]);
        of_root.sum::<f64>() + of_joints.sum::<f64>()
    }

    /// The product of the entries of root and joints in two rows of the same body.
    #[inline]
    pub fn dot(&self, other: &Self) -> f64 {
        let mut sum = self.joints.dot(&other.joints);
        for (a, b) in self.root.iter().zip(&other.root) {
            sum += a * b;
        }
        sum
    }

    /// Passes on the entries of joints and root, each with its degree of freedom.
    #[inline]
    pub fn each_dof(&self, mut pass: impl FnMut(usize, f64)) {
        (self.joints.iter()).for_each(|(joint, c)| pass(ROOT_DOFS + joint, c));
        (self.root.iter().enumerate()).for_each(|(dof, c)| pass(dof, *c));
    }

    /// Adds a multiple of the entries of root and joints to rates by degree of freedom.
    #[inline]
    pub fn add_to(&self, times: f64, rates: &mut [f64]) {
        self.each_dof(|dof, c| rates[dof] += times * c);
    }

    /// The same body with the opposite sign.
    pub fn reversed(&self) -> Self {
        Self {
            body: self.body,
            root: -self.root,
            joints: self.joints.reversed(),
            axle: self.axle.map(|(place, c)| (place, -c)),
            slide: -self.slide,
        }
    }
}
