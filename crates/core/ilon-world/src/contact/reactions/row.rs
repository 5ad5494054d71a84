//! How a velocity follows from the rates of the bodies that it is between.

use nalgebra::Vector6;

use crate::dynamics::{Path, ROOT_DOFS};

/// How one velocity follows from the rates of the bodies that it is between, and what a unit impulse there does to them: of a
/// contact how fast body A moves against body B, of a joint how fast parts of body A turn against each other.
///
/// It is sparse: it holds only what stands for the one or two bodies that move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub a: Side,
    /// `None` if B is the ground, which never moves, and of joints within A.
    pub b: Option<Side>,
}

/// What stands in a row for one articulated body: its root, the joints on the way to one of its links, and one of its rollers about its
/// axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// Its place among the articulated bodies.
    pub body: usize,
    pub root: Vector6<f64>,
    pub joints: Path,
    /// Place among the axles and share.
    pub axle: Option<(usize, f64)>,
    /// Share of the velocity with which that roller slides along its axle.
    pub slide: f64,
}

impl Row {
    /// Of what acts on A alone.
    pub fn of_one(a: Side) -> Self {
        Self { a, b: None }
    }

    /// The one or two bodies that move.
    #[inline]
    pub fn sides(&self) -> impl Iterator<Item = &Side> {
        std::iter::once(&self.a).chain(&self.b)
    }

    /// The same, to be changed.
    #[inline]
    pub fn sides_mut(&mut self) -> impl Iterator<Item = &mut Side> {
        std::iter::once(&mut self.a).chain(&mut self.b)
    }
}

impl Side {
    /// Of what joints of a body alone have a share in.
    pub fn of_joints(body: usize, joints: Path) -> Self {
        Self {
            body,
            root: Vector6::zeros(),
            joints,
            axle: None,
            slide: 0.0,
        }
    }

    /// The part of the velocity that the links make, with these rates by degree of freedom of the body.
    #[inline]
    pub fn of_bodies(&self, rates: &[f64]) -> f64 {
        let of_root = self.root.iter().zip(rates).map(|(c, rate)| c * rate);
        let of_joints = self
            .joints
            .iter()
            .map(|(joint, c)| c * rates[ROOT_DOFS + joint]);
        of_root.sum::<f64>() + of_joints.sum::<f64>()
    }

    /// The sum of products of the shares of root and joints in two rows of the same body.
    #[inline]
    pub fn dot(&self, other: &Self) -> f64 {
        let mut sum = self.joints.dot(&other.joints);
        for (a, b) in self.root.iter().zip(&other.root) {
            sum += a * b;
        }
        sum
    }

    /// Adds a multiple of the shares of root and joints to rates by degree of freedom.
    #[inline]
    pub fn add_to(&self, times: f64, rates: &mut [f64]) {
        for (rate, c) in rates.iter_mut().zip(&self.root) {
            *rate += times * c;
        }
        for (joint, c) in self.joints.iter() {
            rates[ROOT_DOFS + joint] += times * c;
        }
    }

    /// The same body, moving the other way.
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
