//! A roller's outline from the shapes in its file: a body of revolution about the roller's axis.
//!
//! Every part is a circle about the axis, thickened by a ball: a sphere is a ball on the axis, a
//! cylinder two circles without a ball, a mesh the circles of its outermost vertices. Flat ground
//! touches the convex hull of the parts. Its support in a unit direction with component w along the
//! axis is the largest t w + ring sqrt(1 - w^2) + ball over them.

/// A circle about the axis, thickened by a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfilePart {
    /// Position along the axis, in metres.
    pub t_m: f64,
    /// Radius of the circle, in metres.
    pub ring_m: f64,
    /// Radius of the ball, in metres.
    pub ball_m: f64,
}

/// A body of revolution of at least one part.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    parts: Vec<ProfilePart>,
}

impl Profile {
    /// A body of these parts; `None` without any.
    pub fn new(parts: Vec<ProfilePart>) -> Option<Self> {
        (!parts.is_empty()).then_some(Self { parts })
    }

    /// A body of one part.
    pub fn of(part: ProfilePart) -> Self {
        Self { parts: vec![part] }
    }

    /// Its parts, at least one.
    pub fn parts(&self) -> &[ProfilePart] {
        &self.parts
    }

    /// Returns the convex hull's reach in a unit direction with component `w` along the axis, in
    /// metres.
    pub fn support_m(&self, w: f64) -> f64 {
        self.furthest(w).1
    }

    /// Returns the part that reaches furthest in a unit direction with component `w` along the
    /// axis, and its reach in metres.
    pub fn furthest(&self, w: f64) -> (ProfilePart, f64) {
        let across = (1.0 - w * w).max(0.0).sqrt();
        let reach = |p: &ProfilePart| p.t_m * w + p.ring_m * across + p.ball_m;
        let mut best = (self.parts[0], reach(&self.parts[0]));
        for part in &self.parts[1..] {
            let reach_m = reach(part);
            if reach_m > best.1 {
                best = (*part, reach_m);
            }
        }
        best
    }

    /// Returns the first and last position of a part along the axis, in metres.
    pub fn span_m(&self) -> (f64, f64) {
        self.parts
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), p| {
                (first.min(p.t_m), last.max(p.t_m))
            })
    }
}
