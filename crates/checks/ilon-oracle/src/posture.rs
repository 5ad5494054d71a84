//! Poses of carriers, hubs and rollers, and motion of the carriers, in the body frame.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use crate::generalised::Generalised;
use crate::tree::{Inertia, Tree};

/// A carrier at its pose.
#[derive(Clone, Debug)]
pub(crate) struct PlacedCarrier {
    /// Its rotation and translation from its pose with all joints at zero.
    pub turn: Matrix3<f64>,
    pub by: Vector3<f64>,
    pub inertia: Inertia,
    /// A point on its joint's axis, and that axis; zero for the chassis.
    pub pivot: Vector3<f64>,
    pub axis: Vector3<f64>,
}

/// A hub at its pose.
#[derive(Clone, Debug)]
pub(crate) struct PlacedHub {
    /// The wheel's middle.
    pub middle: Vector3<f64>,
    pub axis: Vector3<f64>,
    /// Its centre of mass, from the middle.
    pub center: Vector3<f64>,
    pub about_center: Matrix3<f64>,
}

/// Poses of carriers, hubs and rollers.
#[derive(Clone, Debug)]
pub(crate) struct Posture {
    pub carriers: Vec<PlacedCarrier>,
    pub hubs: Vec<PlacedHub>,
    /// Each roller's middle, from O.
    pub centers: Vec<Vector3<f64>>,
    /// Each roller's axis.
    pub axes: Vec<Vector3<f64>>,
}

/// The motion of a carrier: its angular velocity, the velocity of its material point at O, and the
/// bias of their accelerations at u. = 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    pub angular: Vector3<f64>,
    pub linear: Vector3<f64>,
    pub angular_left: Vector3<f64>,
    pub linear_left: Vector3<f64>,
}

impl Carried {
    pub const REST: Self = Self {
        angular: Vector3::new(0.0, 0.0, 0.0),
        linear: Vector3::new(0.0, 0.0, 0.0),
        angular_left: Vector3::new(0.0, 0.0, 0.0),
        linear_left: Vector3::new(0.0, 0.0, 0.0),
    };

    /// The velocity of its point at `r`.
    pub fn velocity(&self, r: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(r)
    }

    /// The bias of the acceleration of its point at `r`, at u. = 0.
    pub fn left(&self, r: &Vector3<f64>) -> Vector3<f64> {
        let (omega, alpha) = (&self.angular, &self.angular_left);
        self.linear_left + alpha.cross(r) + omega.cross(&omega.cross(r))
    }
}

impl Posture {
    /// All joints and wheel angles at zero.
    pub fn new(tree: &Tree) -> Self {
        let carrier = PlacedCarrier {
            turn: Matrix3::identity(),
            by: Vector3::zeros(),
            inertia: tree.chassis,
            pivot: Vector3::zeros(),
            axis: Vector3::zeros(),
        };
        let hub = PlacedHub {
            middle: Vector3::zeros(),
            axis: Vector3::zeros(),
            center: Vector3::zeros(),
            about_center: Matrix3::zeros(),
        };
        let mut posture = Self {
            carriers: vec![carrier; tree.carriers()],
            hubs: vec![hub; tree.wheels.len()],
            centers: vec![Vector3::zeros(); tree.rollers.len()],
            axes: vec![Vector3::zeros(); tree.rollers.len()],
        };
        let (joints, wheels) = (vec![0.0; tree.joints.len()], vec![0.0; tree.wheels.len()]);
        posture.update(tree, &joints, &wheels);
        posture
    }

    /// Updates the poses for these joint positions, in rad or m, and wheel angles, in rad.
    pub fn update(&mut self, tree: &Tree, joints: &[f64], wheel_angles: &[f64]) {
        for (i, joint) in tree.joints.iter().enumerate() {
            let on = &self.carriers[joint.parent];
            let pivot = on.turn * joint.pivot_in_body + on.by;
            let axis = on.turn * joint.axis_in_body;
            let (turn, by) = if joint.slides {
                (on.turn, on.by + axis * joints[i])
            } else {
                let about = Rotation3::from_axis_angle(&Unit::new_unchecked(axis), joints[i]);
                (about * on.turn, pivot + about * (on.by - pivot))
            };
            self.carriers[i + 1] = PlacedCarrier {
                turn,
                by,
                inertia: joint.body.moved(&turn, &by),
                pivot,
                axis,
            };
        }
        for (i, wheel) in tree.wheels.iter().enumerate() {
            let on = &self.carriers[wheel.carrier];
            let (sin, cos) = wheel_angles[i].sin_cos();
            let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
            let body_from_hub = on.turn * wheel.body_from_hub * turn;
            let middle = on.turn * wheel.origin_in_body + on.by;
            self.hubs[i] = PlacedHub {
                middle,
                axis: body_from_hub * Vector3::z(),
                center: body_from_hub * wheel.hub.center,
                about_center: body_from_hub * wheel.hub.about_center * body_from_hub.transpose(),
            };
            for j in wheel.rollers.clone() {
                let roller = &tree.rollers[j];
                self.centers[j] = middle + body_from_hub * roller.center_in_hub;
                self.axes[j] = body_from_hub * roller.axis_in_hub;
            }
        }
    }

    /// Writes the motion of the carriers at these speeds.
    ///
    /// On a carrier with angular velocity **w**, the body of a revolute joint with axis **z**
    /// through **p** has **w** + q' **z**. Its angular bias is that of the carrier plus **w** x q'
    /// **z**, and **p** is a point of both. The body of a prismatic joint has the carrier's angular
    /// velocity; q' **z** adds to its velocity, 2 **w** x q' **z** to its acceleration.
    pub fn carry(&self, tree: &Tree, speeds: &Generalised, carried: &mut [Carried]) {
        carried[0] = Carried {
            angular: speeds.angular,
            linear: speeds.linear,
            angular_left: Vector3::zeros(),
            linear_left: speeds.angular.cross(&speeds.linear),
        };
        for (i, joint) in tree.joints.iter().enumerate() {
            let (on, of) = (carried[joint.parent], &self.carriers[i + 1]);
            let rate = of.axis * speeds.joints[i];
            carried[i + 1] = if joint.slides {
                Carried {
                    linear: on.linear + rate,
                    linear_left: on.linear_left + 2.0 * on.angular.cross(&rate),
                    ..on
                }
            } else {
                let angular = on.angular + rate;
                let angular_left = on.angular_left + on.angular.cross(&rate);
                let p = &of.pivot;
                let back = angular_left.cross(p) + angular.cross(&angular.cross(p));
                Carried {
                    angular,
                    linear: on.linear + p.cross(&rate),
                    angular_left,
                    linear_left: on.left(p) - back,
                }
            };
        }
    }
}
