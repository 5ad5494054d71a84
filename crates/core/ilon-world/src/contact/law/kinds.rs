//! The laws between an impulse and the velocity at its place, each written once: as its proximal
//! map.
//!
//! A single row on which nothing else acts moves with u = (p - q) / g under the impulse p: g is the
//! inverse of its mobility, in N s per m/s, and q the impulse that would stop it. Together with the
//! law this has one solution, p = prox(q), which is all that a solver needs:
//!
//! - the law holds if p = prox(p - g u), for any g > 0: `residual` solves that;
//! - its derivative by q ranges from 0 (the law gives the impulse) to 1 (the law gives the
//!   velocity);
//! - with g = 0 it is the nearest impulse that the law allows at any velocity.

use nalgebra::{Matrix2, Vector2};

use super::curve::Curves;

/// A bound of friction below this, in N s, counts as 0: the square of such an impulse underflows.
pub(super) const LEAST_BOUND_N_S: f64 = 1e-150;

/// A law between an impulse and the velocity at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Law {
    /// Three rows: the normal and two tangents.
    Contact {
        /// Coulomb friction coefficient mu.
        friction: f64,
        /// b: the largest velocity of approach, in m/s; negative to push the bodies apart.
        approach_m_s: f64,
        /// c: compliance of the contact over the step, in m/s per N s.
        compliance: f64,
    },
    /// One row: the rate of a joint, with a bounded impulse. Dry friction has symmetric bounds. The
    /// law that keeps a motor from driving beyond a rate has 0 as one bound, and its velocity is
    /// relative to that rate.
    Joint {
        /// The impulse during forward rotation, in N m s, <= 0.
        least_n_m_s: f64,
        /// The impulse during backward rotation, in N m s, >= 0.
        most_n_m_s: f64,
    },
    /// Two rows: a motion in a plane, with an impulse of bounded magnitude in any direction.
    Disc {
        /// The impulse during the motion, in N s, >= 0.
        most_n_s: f64,
    },
    /// One row: a roller along its axle, between two stops.
    Slide {
        /// The velocity that reaches the rear stop within the step, in m/s, <= 0.
        least_m_s: f64,
        /// The velocity that reaches the front stop within the step, in m/s, >= 0.
        most_m_s: f64,
    },
    /// One row: velocity and impulse lie on a curve, which is added to the problem before.
    Curve {
        /// Its index among the curves.
        place: usize,
    },
}

/// The nearest impulses that a law allows, in N s or N m s, and their derivative. For laws with
/// fewer than three rows the rest is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Allowed {
    pub impulse: [f64; 3],
    /// Derivative of each row by each.
    pub slope: [[f64; 3]; 3],
}

impl Allowed {
    /// For a law with one row.
    fn one(impulse: f64, slope: f64) -> Self {
        let mut allowed = Self::default();
        allowed.impulse[0] = impulse;
        allowed.slope[0][0] = slope;
        allowed
    }

    /// Sets two rows from `first` on to the point of a disc nearest to `asked`. The disc's radius
    /// grows with the impulse of the row before by `grows`.
    #[inline(always)]
    fn hold_in_disc(&mut self, first: usize, asked: Vector2<f64>, limit: f64, grows: f64) {
        if limit < LEAST_BOUND_N_S {
            return;
        }
        let size = asked.norm();
        let (held, slope) = if size <= limit {
            (asked, Matrix2::identity())
        } else {
            let along = asked / size;
            let turns = (Matrix2::identity() - along * along.transpose()) * (limit / size);
            if let Some(before) = first.checked_sub(1) {
                self.slope[first][before] = grows * along.x;
                self.slope[first + 1][before] = grows * along.y;
            }
            (limit * along, turns)
        };
        for i in 0..2 {
            self.impulse[first + i] = held[i];
            self.slope[first + i][first..first + 2]
                .copy_from_slice(&[slope[(i, 0)], slope[(i, 1)]]);
        }
    }
}

impl Law {
    /// The number of its rows.
    pub fn rows(&self) -> usize {
        match self {
            Law::Contact { .. } => 3,
            Law::Disc { .. } => 2,
            Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. } => 1,
        }
    }

    /// The first of the two rows of its friction, if it has friction.
    pub fn first_tangent(&self) -> Option<usize> {
        match self {
            Law::Contact { .. } => Some(1),
            Law::Disc { .. } => Some(0),
            Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. } => None,
        }
    }

    /// The proximal map of the law: the allowed impulses nearest to those in `asked`, where the
    /// velocity is (p - asked) / `yields`; see the module. `yields` is in N s per m/s or N m s per
    /// rad/s, for the first row: in the other rows no law depends on it. Friction's bound follows
    /// the load that the contact carries here.
    #[inline(always)]
    pub(super) fn allows(&self, curves: &Curves, asked: &[f64], yields: f64) -> Allowed {
        match *self {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => {
                let within = asked[0].clamp(least_n_m_s, most_n_m_s);
                Allowed::one(within, f64::from(u8::from(within == asked[0])))
            }
            Law::Slide {
                least_m_s,
                most_m_s,
            } => {
                if asked[0] > -yields * least_m_s {
                    Allowed::one(asked[0] + yields * least_m_s, 1.0)
                } else if asked[0] < -yields * most_m_s {
                    Allowed::one(asked[0] + yields * most_m_s, 1.0)
                } else {
                    Allowed::one(0.0, 0.0)
                }
            }
            // Any impulse is somewhere on a curve.
            Law::Curve { .. } if yields == 0.0 => Allowed::one(asked[0], 1.0),
            Law::Curve { place } => {
                let meeting = curves.meet(place, asked[0], 1.0 / yields);
                Allowed::one(meeting.impulse, meeting.slope(1.0 / yields))
            }
            Law::Disc { most_n_s } => {
                let mut allowed = Allowed::default();
                allowed.hold_in_disc(0, Vector2::new(asked[0], asked[1]), most_n_s, 0.0);
                allowed
            }
            Law::Contact {
                friction,
                approach_m_s,
                compliance,
            } => {
                let pressed = 1.0 / (1.0 + yields * compliance);
                let load = (asked[0] - yields * approach_m_s) * pressed;
                if load <= 0.0 {
                    return Allowed::default();
                }
                let mut allowed = Allowed::one(load, pressed);
                let tangents = Vector2::new(asked[1], asked[2]);
                allowed.hold_in_disc(1, tangents, friction * load, friction * pressed);
                allowed
            }
        }
    }
}
