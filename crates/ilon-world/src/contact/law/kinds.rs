//! The laws between an impulse and the velocity where it acts.

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

/// What holds of one row that slides between stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sliding {
    /// It is at a stop, to which this velocity takes it, in m/s.
    At(f64),
    /// It slides, without impulse.
    Free,
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
}

impl Sliding {
    /// What holds of a row of a response `own` in 1/kg, on a `line` p - u / own: as the velocity falls from stop to stop, the
    /// impulse grows, so that each of these lines meets the law once.
    pub fn on_line(line: f64, own: f64, (least_m_s, most_m_s): (f64, f64)) -> Self {
        if line > -least_m_s / own {
            Self::At(least_m_s)
        } else if line < -most_m_s / own {
            Self::At(most_m_s)
        } else {
            Self::Free
        }
    }
}
