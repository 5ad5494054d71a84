//! Forces on the bodies, and prescribed accelerations.

use nalgebra::Vector3;

use crate::posture::Posture;
use crate::tree::Tree;

/// Forces on the bodies: moment about O and force on each carrier, torques and forces in joints,
/// wheels and rollers.
#[derive(Clone, Debug)]
pub(crate) struct Forces {
    pub carriers: Vec<(Vector3<f64>, Vector3<f64>)>,
    pub joints: Vec<f64>,
    pub wheels: Vec<f64>,
    pub rollers: Vec<f64>,
}

impl Forces {
    pub fn zero(tree: &Tree) -> Self {
        Self {
            carriers: vec![(Vector3::zeros(), Vector3::zeros()); tree.carriers()],
            joints: vec![0.0; tree.joints.len()],
            wheels: vec![0.0; tree.wheels.len()],
            rollers: vec![0.0; tree.rollers.len()],
        }
    }

    pub fn clear(&mut self) {
        self.carriers.fill((Vector3::zeros(), Vector3::zeros()));
        self.joints.fill(0.0);
        self.wheels.fill(0.0);
        self.rollers.fill(0.0);
    }

    /// Adds a force on a carrier at a point, both in the body frame.
    pub fn act_on(&mut self, carrier: usize, point: &Vector3<f64>, force: &Vector3<f64>) {
        let (moment, sum) = &mut self.carriers[carrier];
        *sum += force;
        *moment += point.cross(force);
    }

    /// Adds a force at a point of the wheel `w`, all in the body frame.
    pub fn act_on_wheel(
        &mut self,
        tree: &Tree,
        posture: &Posture,
        w: usize,
        point: &Vector3<f64>,
        force: &Vector3<f64>,
    ) {
        let hub = &posture.hubs[w];
        self.act_on(tree.wheels[w].carrier, point, force);
        self.wheels[w] += hub.axis.dot(&(point - hub.middle).cross(force));
    }
}

/// Wheels and rollers that are locked: their acceleration is prescribed instead of their torque.
#[derive(Clone, Debug)]
pub(crate) struct Prescribed {
    pub wheels: Vec<Option<f64>>,
    pub rollers: Vec<Option<f64>>,
}
