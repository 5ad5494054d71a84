//! The laws between an impulse and the velocity where it acts, each written once: as its proximal map.
//!
//! A row of its own, on which nothing else acts, moves with u = (p - q) / g if the impulse p acts on it: g is its mobility's inverse, in N s per
//! m/s, and q the impulse that would stop it. Together with the law that has one solution, p = prox(q), and with it everything that a solver needs:
//!
//! - the laws hold where p = prox(p - g u) for any g > 0: `residual` solves that;
//! - its derivative by q says how a law answers, from 0 (the impulse is given) to 1 (the velocity is given);
//! - with g = 0 it is the nearest impulse that the law allows at all.

use nalgebra::{Matrix2, Vector2};

use super::curve::Curves;

/// What holds between an impulse and the velocity where it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Law {
    /// Three rows: the normal and two tangents.
    Contact {
        /// Coulomb friction coefficient mu.
        friction: f64,
        /// b: the contact may come nearer by at most this, in m/s; negative where it shall be pushed apart.
        approach_m_s: f64,
        /// c: compliance of the contact over the step, in m/s per N s: it gives by this much for what it carries.
        compliance: f64,
    },
    /// One row: the turning of a joint, held within bounds. Dry friction has bounds of equal size; what keeps a motor from
    /// driving beyond a rate has 0 as one of them, and its velocity is counted from that rate.
    Joint {
        /// The impulse while the joint turns forwards, in N m s, <= 0.
        least_n_m_s: f64,
        /// The impulse while it turns backwards, in N m s, >= 0.
        most_n_m_s: f64,
    },
    /// Two rows: a motion in a plane that is held by an impulse of bounded size, in whatever direction.
    Disc {
        /// The impulse while it moves, in N s, >= 0.
        most_n_s: f64,
    },
    /// One row: a roller along its axle, between two stops.
    Slide {
        /// The velocity that takes it to the stop behind within the step, in m/s, <= 0.
        least_m_s: f64,
        /// The velocity that takes it to the stop ahead, in m/s, >= 0.
        most_m_s: f64,
    },
    /// One row: velocity and impulse lie on a curve, which is added to the problem before.
    Curve {
        /// Its place among the curves.
        place: usize,
    },
}

/// The impulses that a law allows next to others, in N s or N m s, and their derivative by these. Of laws of fewer than three rows the rest is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Allowed {
    pub impulse: [f64; 3],
    /// Of each row by each.
    pub slope: [[f64; 3]; 3],
}

impl Allowed {
    /// Of a law of one row.
    fn one(impulse: f64, slope: f64) -> Self {
        let mut allowed = Self::default();
        allowed.impulse[0] = impulse;
        allowed.slope[0][0] = slope;
        allowed
    }

    /// Sets two rows from one on to the nearest of `asked` in a disc. Its size grows with the impulse of the row before by `grows`.
    #[inline(always)]
    fn hold_in_disc(&mut self, first: usize, asked: Vector2<f64>, limit: f64, grows: f64) {
        if limit <= 0.0 {
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
    /// How many rows it has.
    pub fn rows(&self) -> usize {
        match self {
            Law::Contact { .. } => 3,
            Law::Disc { .. } => 2,
            Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. } => 1,
        }
    }

    /// Which of its rows is the first of two among which its friction lies.
    pub fn first_tangent(&self) -> Option<usize> {
        match self {
            Law::Contact { .. } => Some(1),
            Law::Disc { .. } => Some(0),
            Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. } => None,
        }
    }

    /// The proximal map of the law: the impulses that it allows next to those in `asked`, where the velocity is (p - asked) / `yields`; see the
    /// module. `yields` is in N s per m/s or N m s per rad/s, that of the first row: in the other rows no law depends on it. Friction's bound follows
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
