//! The reactions between bodies, the ground and dry bearings in a step.

use nalgebra::{Matrix2, Vector2, Vector3};

use crate::contact::law::tread::{Press, Shear, Softness};

/// A part of an articulated body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Member {
    /// The body's index among the articulated ones.
    pub body: usize,
    pub part: Part,
}

/// The partner of body A in a reaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Partner {
    /// The ground, which never moves.
    Ground,
    /// A part of another articulated body.
    Of(Member),
    /// A itself, for a reaction in a joint.
    Itself,
}

/// The part of a body on which a reaction acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Part {
    /// The chassis touches something.
    Chassis,
    /// The body of a joint touches something.
    Link(usize),
    /// A roller touches something: wheel and roller.
    Roller(usize, usize),
    /// The bearing of a wheel.
    Hub(usize),
    /// The bearing of a roller that touches something: wheel and roller.
    Axle(usize, usize),
    /// The play along the axle of a roller that touches something: wheel and roller.
    Slide(usize, usize),
    /// Rolling resistance: wheel and roller.
    Rolling(usize, usize),
    /// The limit that keeps the motor of a wheel from driving it beyond a rate.
    RateLimit(usize),
    /// The nonlinear part of a wheel's drive: its motor at its limits, its gear and its bearing.
    Drive(usize),
    /// The nonlinear part of a servo at its effort.
    Servo(usize),
    /// Dry friction in a joint between bodies.
    Friction(usize),
    /// A stop of a joint between bodies, and whether it is the one ahead.
    Stop(usize, bool),
    /// The coupling of one joint between bodies to another, by its index among the robot's
    /// couplings.
    Coupling(usize),
}

impl Part {
    /// The body of a joint, or the chassis.
    pub fn of_body(joint: Option<usize>) -> Self {
        joint.map_or(Self::Chassis, Self::Link)
    }

    /// The wheel of a roller or tyre that touches.
    pub fn wheel(self) -> Option<usize> {
        match self {
            Part::Roller(wheel, _) => Some(wheel),
            _ => None,
        }
    }

    /// Whether a reaction here continues one there in the last step. A wheel changes rollers as it
    /// turns.
    pub fn follows(self, before: Self) -> bool {
        match (self, before) {
            (Part::Roller(a, _), Part::Roller(b, _))
            | (Part::Axle(a, _), Part::Axle(b, _))
            | (Part::Rolling(a, _), Part::Rolling(b, _)) => a == b,
            _ => self == before,
        }
    }
}

impl Member {
    /// Whether a reaction here continues one there in the last step.
    pub fn follows(self, before: Self) -> bool {
        self.body == before.body && self.part.follows(before.part)
    }
}

impl Partner {
    /// Whether a reaction with this partner continues one with that partner in the last step.
    pub fn follows(self, before: Self) -> bool {
        match (self, before) {
            (Self::Of(now), Self::Of(then)) => now.follows(then),
            _ => self == before,
        }
    }
}

/// One reaction of the last step, between body A and its partner B.
///
/// Its three numbers are a contact's normal and two tangents; a bearing has only the first, and
/// rolling the first two: along the roller and across it.
#[derive(Clone, Debug)]
pub(crate) struct Reaction {
    pub a: Member,
    pub b: Partner,
    /// Its point in the middle of the step, in the floor's frame, in metres; meaningless for a
    /// bearing.
    pub at_m: Vector3<f64>,
    /// For a contact the normal out of B and two tangents, in the floor's frame, of which the first
    /// lies along the roller of A.
    pub frame: [Vector3<f64>; 3],
    /// Coulomb friction coefficient of a contact, in the direction of its friction force.
    pub friction: f64,
    /// The direction of the ground's nap among the tangents, and the ratio of the friction across
    /// it to that along it, if these differ.
    pub nap: Option<(Vector2<f64>, f64)>,
    /// Impulse on A along `frame`, in N s, and the opposite on B; of a bearing in N m s.
    pub impulse: Vector3<f64>,
    /// Velocity of A relative to B along `frame` at the beginning of the step, in m/s; of a bearing
    /// in rad/s.
    pub velocity_before: Vector3<f64>,
    /// Velocity along `frame` at the end of the step.
    pub velocity_after: Vector3<f64>,
    /// Energy that each of the impulses took from the bodies, in J.
    pub taken_j: Vector3<f64>,
    /// Whether a roller came down on the ground in the step.
    pub came_down: bool,
    /// Derivative of the second tangent's velocity by the roller's rate about its axis, in m.
    pub rolling_radius_m: f64,
    /// The contact's compliance, if it has one. Boxed, because most have none and it is as large as
    /// all else.
    pub compliance: Option<Box<TangentCompliance>>,
}

/// The compliance of a contact in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentCompliance {
    /// Along the two tangents.
    pub softness: [Softness; 2],
    /// Compliance of the velocity along each tangent by the impulse along the other, in m/s per N
    /// s.
    pub coupled: f64,
    /// The direction of the ground's nap among the tangents, if it matters: a tread is sheared
    /// along it and across it.
    pub along: Option<Vector2<f64>>,
    /// The tread between roller and ground; `None` if the contact only creeps.
    pub tread: Option<Tread>,
}

impl TangentCompliance {
    /// Compliances along a unit vector among the tangents, and across it; along the tangents
    /// themselves without one.
    pub fn along(
        softness: [Softness; 2],
        along: Option<Vector2<f64>>,
        tread: Option<Tread>,
    ) -> Self {
        let Some(direction) = along else {
            return Self {
                softness,
                coupled: 0.0,
                along,
                tread,
            };
        };
        let turn = turned_to(direction);
        let compliances = Vector2::from(softness.map(|softness| softness.compliance));
        let biases = Vector2::from(softness.map(|softness| softness.bias_m_s));
        let compliance = turn.transpose() * Matrix2::from_diagonal(&compliances) * turn;
        let bias_m_s = turn.transpose() * biases;
        Self {
            softness: [0, 1].map(|i| Softness {
                compliance: compliance[(i, i)],
                bias_m_s: bias_m_s[i],
            }),
            coupled: compliance[(0, 1)],
            along,
            tread,
        }
    }
}

/// The rotation of a contact's tangents that makes the first parallel to a unit vector among them.
pub(crate) fn turned_to(along: Vector2<f64>) -> Matrix2<f64> {
    Matrix2::new(along.x, along.y, -along.y, along.x)
}

/// A tread that is pressed on the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tread {
    pub press: Press,
    pub shear: Shear,
    /// Its shear after the step, in the floor's frame, in metres.
    pub bend_m: Vector3<f64>,
    /// Energy in it along the normal and across it, before the step and after it, in J.
    pub stored_before_j: [f64; 2],
    pub stored_j: [f64; 2],
}

impl Reaction {
    /// Whether it acts on an articulated body.
    pub fn touches(&self, body: usize) -> bool {
        let is_b = matches!(self.b, Partner::Of(member) if member.body == body);
        self.a.body == body || is_b
    }

    /// One within a body, with a velocity at the beginning of the step, and without impulse.
    pub fn within(a: Member, velocity_before: Vector3<f64>) -> Self {
        Self {
            a,
            b: Partner::Itself,
            at_m: Vector3::zeros(),
            frame: [Vector3::zeros(); 3],
            friction: 0.0,
            nap: None,
            impulse: Vector3::zeros(),
            velocity_before,
            velocity_after: Vector3::zeros(),
            taken_j: Vector3::zeros(),
            came_down: false,
            rolling_radius_m: 0.0,
            compliance: None,
        }
    }

    /// Whether it continues another in the last step.
    pub fn follows(&self, before: &Self) -> bool {
        self.a.follows(before.a) && self.b.follows(before.b)
    }

    /// The number of rows of the part.
    pub fn rows(&self) -> usize {
        match self.a.part {
            Part::Chassis | Part::Link(_) | Part::Roller(..) => 3,
            Part::Rolling(..) => 2,
            Part::Hub(_)
            | Part::Axle(..)
            | Part::Slide(..)
            | Part::RateLimit(_)
            | Part::Drive(_)
            | Part::Servo(_)
            | Part::Friction(_)
            | Part::Stop(..)
            | Part::Coupling(_) => 1,
        }
    }

    /// Takes over the solution: the impulse, and the velocity with the contact's deflection.
    /// `slides` tells whether its friction is at its limit.
    pub fn take(&mut self, impulse: Vector3<f64>, velocity: Vector3<f64>, slides: bool, dt_s: f64) {
        self.impulse = impulse;
        self.velocity_after = velocity;
        if let Some((along, ratio)) = self.nap
            && impulse.yz() != Vector2::zeros()
        {
            // Where the friction's direction meets the ellipse.
            let pull = turned_to(along) * impulse.yz().normalize();
            self.friction /= libm::hypot(pull.x, pull.y / ratio);
        }
        let Some(compliance) = &mut self.compliance else {
            return;
        };
        for (i, softness) in compliance.softness.iter().enumerate() {
            self.velocity_after[1 + i] -= softness.bias_m_s + softness.compliance * impulse[1 + i];
        }
        if compliance.coupled != 0.0 {
            self.velocity_after.y -= compliance.coupled * impulse.z;
            self.velocity_after.z -= compliance.coupled * impulse.y;
        }
        let turn = compliance.along.map(turned_to);
        let Some(tread) = &mut compliance.tread else {
            return;
        };
        let pushes = impulse.x > 0.0;
        let friction_n = impulse.yz() / dt_s;
        let bend_m = if pushes {
            let turned = |of: Vector2<f64>| turn.map_or(of, |turn| turn * of);
            let after_m_s = turned(self.velocity_after.yz());
            let friction_n = slides.then_some(turned(friction_n));
            let bend_m = tread.shear.bent_m(after_m_s, friction_n, dt_s);
            turn.map_or(bend_m, |turn| turn.transpose() * bend_m)
        } else {
            Vector2::zeros()
        };
        tread.bend_m = bend_m.x * self.frame[1] + bend_m.y * self.frame[2];
        let opens_m_s = self.velocity_after.x;
        tread.stored_j = [
            tread.press.stored_j(opens_m_s, pushes, dt_s),
            tread.shear.stored_j(&bend_m),
        ];
    }

    /// The tread of the contact, if it has one.
    pub fn tread(&self) -> Option<&Tread> {
        self.compliance.as_ref()?.tread.as_ref()
    }

    /// Energy in the contact's tread, in J.
    pub fn tread_j(&self) -> f64 {
        self.tread()
            .map_or(0.0, |tread| tread.stored_j.iter().sum())
    }

    /// Tangential impulse on A in the floor's frame, in N s.
    pub fn friction_impulse_n_s(&self) -> Vector3<f64> {
        self.impulse.y * self.frame[1] + self.impulse.z * self.frame[2]
    }

    /// Tangential velocity after the step in the floor's frame, in m/s.
    pub fn sliding_m_s(&self) -> Vector3<f64> {
        self.velocity_after.y * self.frame[1] + self.velocity_after.z * self.frame[2]
    }
}
