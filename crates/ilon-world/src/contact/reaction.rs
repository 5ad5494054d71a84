//! What the ground or a dry bearing did to the robot in a step.

use nalgebra::Vector3;

/// What a reaction acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Part {
    /// The chassis touches the ground.
    Chassis,
    /// A roller touches the ground: wheel and roller.
    Roller(usize, usize),
    /// The bearing of a wheel.
    Hub(usize),
    /// The bearing of a roller that touches the ground: wheel and roller.
    Axle(usize, usize),
}

impl Part {
    /// Whether a reaction here goes on where one there was in the last step. A wheel changes rollers as it turns.
    pub fn follows(self, before: Self) -> bool {
        match (self, before) {
            (Part::Roller(a, _), Part::Roller(b, _)) | (Part::Axle(a, _), Part::Axle(b, _)) => {
                a == b
            }
            _ => self == before,
        }
    }
}

/// One reaction of the last step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction {
    pub part: Part,
    /// Where, in the floor's frame, in metres; nowhere for a bearing.
    pub at_m: Vector3<f64>,
    /// For a contact the ground's normal and two tangents, in the floor's frame, of which the first lies along the
    /// roller.
    pub frame: [Vector3<f64>; 3],
    /// Coulomb friction coefficient of a contact.
    pub friction: f64,
    /// Impulse on the robot along `frame`, in N s; of a bearing the first number, in N m s.
    pub impulse: Vector3<f64>,
}

impl Reaction {
    /// Which numbers of the impulse the part has.
    pub fn rows(&self) -> std::ops::Range<usize> {
        match self.part {
            Part::Chassis | Part::Roller(..) => 0..3,
            Part::Hub(_) | Part::Axle(..) => 0..1,
        }
    }

    /// The impulse on the robot in the floor's frame, in N s: normal and tangential part.
    pub fn on_robot_n_s(&self) -> (Vector3<f64>, Vector3<f64>) {
        let [normal, along, across] = self.frame;
        let p = &self.impulse;
        (p.x * normal, p.y * along + p.z * across)
    }
}
