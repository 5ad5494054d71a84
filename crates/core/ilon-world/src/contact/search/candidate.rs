//! A place where bodies are near each other, and may touch in the step.

use nalgebra::Vector3;

use crate::contact::reactions::reaction::{Member, Partner};

/// A hub whose axis leaves a plane by less than this, as the sine of an angle, counts as upright: a
/// round wheel on that plane. Chosen.
///
/// For an upright wheel the outline of barrels that hand over is a circle, and only the lowest one
/// touches. For a tilted wheel the next one comes down with a slope that grows with the tilt:
/// within this angle by less than 3 um in a step of 0.02 rad of the wheel.
pub(super) const UPRIGHT: f64 = 0.01;

/// A place where a part of body A is near its partner B.
///
/// Everything is in the floor's frame, and the poses are those in the middle of the step unless
/// stated otherwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub a: Member,
    pub b: Partner,
    /// Point on B, in metres.
    pub place_m: Vector3<f64>,
    /// Unit vector out of B.
    pub normal: Vector3<f64>,
    /// Along the axis of A's roller, or any direction without one.
    pub along: Vector3<f64>,
    /// Distance in metres, negative in penetration.
    pub gap_m: f64,
    /// The rotation of the velocity of A's surface at the contact.
    pub turning: Turning,
    /// Whether it is on a roller on which nothing pressed in the last step.
    pub came_down: bool,
    /// Velocity of the contact point over B, in m/s.
    pub travel_m_s: Vector3<f64>,
    /// Whether it is on a roller with an exact shape.
    pub on_barrel: bool,
    /// Its gap at the end of the step by the rates of its beginning, in metres, with the sign of
    /// `gap_m`; equal to that if it is not needed.
    pub gap_ahead_m: f64,
    /// The friction of B's shape there, or of a shape of A on the ground; `None` if the ground's or
    /// the bodies' applies.
    pub friction: Option<f64>,
}

/// The change of the velocity of the robot's surface at a contact by the robot's rotation, with the
/// rates at the beginning of the step: along normal and tangents, which rotate with the roller.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turning {
    /// The reference point of the tangents' rows: for a roller that came down, its point at the
    /// beginning of the step, in metres.
    pub came_down_at_m: Option<Vector3<f64>>,
    /// Change from the beginning of the step to the reference of the rows, in m/s.
    pub until_m_s: Vector3<f64>,
    /// Change from there to the end, in m/s.
    pub from_m_s: Vector3<f64>,
}

impl Candidate {
    /// A place at B with a unit vector out of B and a distance in metres, in the floor's frame,
    /// without rotation.
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
    /// No change.
    pub const NONE: Self = Self {
        came_down_at_m: None,
        until_m_s: Vector3::new(0.0, 0.0, 0.0),
        from_m_s: Vector3::new(0.0, 0.0, 0.0),
    };

    /// For a contact in the middle of the step whose velocity changes by this in each half of it.
    pub(super) fn in_each_half(half_m_s: Vector3<f64>) -> Self {
        Self {
            came_down_at_m: None,
            until_m_s: half_m_s,
            from_m_s: half_m_s,
        }
    }
}
