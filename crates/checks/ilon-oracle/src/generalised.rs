//! Generalised speeds and accelerations.

use nalgebra::Vector3;

use crate::tree::Tree;

/// One number per generalised speed: speeds or accelerations.
#[derive(Clone, Debug, PartialEq)]
pub struct Generalised {
    /// Angular, of the chassis, in the body frame.
    pub angular: Vector3<f64>,
    /// Linear, of the body frame's origin, in the body frame.
    pub linear: Vector3<f64>,
    /// Of each joint between bodies.
    pub joints: Vec<f64>,
    /// Of each wheel about its hub axis.
    pub wheels: Vec<f64>,
    /// Of each roller about its axis relative to its hub, wheel by wheel.
    pub rollers: Vec<f64>,
}

impl Generalised {
    pub(crate) fn zero(tree: &Tree) -> Self {
        Self {
            angular: Vector3::zeros(),
            linear: Vector3::zeros(),
            joints: vec![0.0; tree.joints.len()],
            wheels: vec![0.0; tree.wheels.len()],
            rollers: vec![0.0; tree.rollers.len()],
        }
    }

    pub(crate) fn clear(&mut self) {
        self.angular = Vector3::zeros();
        self.linear = Vector3::zeros();
        self.joints.fill(0.0);
        self.wheels.fill(0.0);
        self.rollers.fill(0.0);
    }

    /// `self = x + factor y`.
    pub(crate) fn set_sum(&mut self, x: &Self, factor: f64, y: &Self) {
        self.angular = x.angular + factor * y.angular;
        self.linear = x.linear + factor * y.linear;
        let sum = |to: &mut [f64], x: &[f64], y: &[f64]| {
            for (sum, (x, y)) in to.iter_mut().zip(x.iter().zip(y)) {
                *sum = x + factor * y;
            }
        };
        sum(&mut self.joints, &x.joints, &y.joints);
        sum(&mut self.wheels, &x.wheels, &y.wheels);
        sum(&mut self.rollers, &x.rollers, &y.rollers);
    }
}
