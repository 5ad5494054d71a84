//! A place where bodies are near each other, which may touch in the step.

use nalgebra::Vector3;

use crate::contact::reactions::reaction::{Member, Partner};

/// A hub whose axis leaves a plane by less than this, as the sine of an angle, turns as a round wheel on it.
///
/// Upright, the outline of barrels that hand over is a circle, and only the lowest one touches. Leaning, the next one comes
/// down with a slope that grows with the lean: within this angle by less than 3 um in a step of 0.02 rad of the wheel.
pub(super) const UPRIGHT: f64 = 0.01;

/// A place where a part of body A is near its partner B.
///
/// Everything is in the floor's frame; the poses are those in the middle of the step where nothing else is said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub a: Member,
    pub b: Partner,
    /// On B, in metres.
    pub place_m: Vector3<f64>,
    /// Unit vector out of B.
    pub normal: Vector3<f64>,
    /// Along the axis of A's roller, or any direction.
    pub along: Vector3<f64>,
    /// Distance in metres, negative in penetration.
    pub gap_m: f64,
    /// How the velocity of A's surface where it touches turns with A.
    pub turning: Turning,
    /// Whether it is on a roller that nothing pressed on in the last step.
    pub came_down: bool,
    /// Velocity with which the place moves over B, in m/s.
    pub travel_m_s: Vector3<f64>,
    /// Whether it is on a roller with an exact shape.
    pub on_barrel: bool,
    /// Its distance where the rates of the step's beginning would take it by the step's end, in metres, counted as `gap_m`; that
    /// itself where nobody asks.
    pub gap_ahead_m: f64,
    /// The friction of B's shape there; `None` if the ground or the bodies say it.
    pub friction: Option<f64>,
}

/// How the velocity of the robot's surface at a contact changes because the robot turns on, with the rates as they were when
/// the step began: along normal and tangents, which turn with the roller.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turning {
    /// Where the tangents' rows are taken: on a roller that came down, its place when the step began, in metres.
    pub came_down_at_m: Option<Vector3<f64>>,
    /// From the beginning of the step to where the rows are taken, in m/s.
    pub until_m_s: Vector3<f64>,
    /// From there to its end, in m/s.
    pub from_m_s: Vector3<f64>,
}

impl Candidate {
    /// A place at B with a unit vector out of B and a distance in metres, in the floor's frame, of what
    /// does not turn.
    pub fn new(
        (a, b): (Member, Partner),
        (place_m, normal, gap_m): (Vector3<f64>, Vector3<f64>, f64),
    ) -> Self {
        Self {
            a,
            b,
            place_m,
            normal,
            along: Vector3::x(),
            gap_m,
            turning: Turning::NONE,
            came_down: false,
            travel_m_s: Vector3::zeros(),
            on_barrel: false,
            gap_ahead_m: gap_m,
            friction: None,
        }
    }
}

impl Turning {
    /// None that is counted.
    pub const NONE: Self = Self {
        came_down_at_m: None,
        until_m_s: Vector3::new(0.0, 0.0, 0.0),
        from_m_s: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Of a contact in the middle of the step, that changes by this in each half of it.
    pub(super) fn in_each_half(half_m_s: Vector3<f64>) -> Self {
        Self {
            came_down_at_m: None,
            until_m_s: half_m_s,
            from_m_s: half_m_s,
        }
    }
}
