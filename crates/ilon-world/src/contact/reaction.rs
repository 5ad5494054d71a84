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
    /// What keeps the motor of a wheel from driving it beyond its rate limit.
    RateLimit(usize),
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
///
/// Its three numbers are a contact's normal and two tangents; a bearing has only the first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction {
    pub part: Part,
    /// Where, in the middle of the step, in the floor's frame, in metres; nowhere for a bearing.
    pub at_m: Vector3<f64>,
    /// For a contact the ground's normal and two tangents, in the floor's frame, of which the first lies along the
    /// roller.
    pub frame: [Vector3<f64>; 3],
    /// Coulomb friction coefficient of a contact.
    pub friction: f64,
    /// Impulse on the robot along `frame`, in N s; of a bearing in N m s.
    pub impulse: Vector3<f64>,
    /// Velocity along `frame` when the step began, in m/s; of a bearing in rad/s.
    pub velocity_before: Vector3<f64>,
    /// Velocity along `frame` when it ended.
    pub velocity_after: Vector3<f64>,
    /// Energy that each of the impulses took out of the robot, in J.
    pub taken_j: Vector3<f64>,
    /// Whether a roller came down on the ground in the step.
    pub came_down: bool,
    /// By how much the second tangent's velocity grows with the roller's rate about its axis, in m.
    pub rolling_radius_m: f64,
}

impl Reaction {
    /// How many numbers the part has.
    pub fn rows(&self) -> usize {
        match self.part {
            Part::Chassis | Part::Roller(..) => 3,
            Part::Hub(_) | Part::Axle(..) | Part::RateLimit(_) => 1,
        }
    }

    /// Tangential impulse on the robot in the floor's frame, in N s.
    pub fn friction_impulse_n_s(&self) -> Vector3<f64> {
        self.impulse.y * self.frame[1] + self.impulse.z * self.frame[2]
    }

    /// Tangential velocity after the step in the floor's frame, in m/s.
    pub fn sliding_m_s(&self) -> Vector3<f64> {
        self.velocity_after.y * self.frame[1] + self.velocity_after.z * self.frame[2]
    }
}
