//! Boxes along the floor's axes, around things that may touch.

use nalgebra::Vector3;

/// A box along the floor's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub least_m: Vector3<f64>,
    pub most_m: Vector3<f64>,
}

impl Bounds {
    /// An empty box.
    pub const NONE: Self = Self {
        least_m: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        most_m: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The box of a ball.
    pub fn of_ball(center_m: &Vector3<f64>, radius_m: f64) -> Self {
        Self {
            least_m: center_m.add_scalar(-radius_m),
            most_m: center_m.add_scalar(radius_m),
        }
    }

    /// The box around both.
    pub fn merged(&self, other: &Self) -> Self {
        Self {
            least_m: self.least_m.inf(&other.least_m),
            most_m: self.most_m.sup(&other.most_m),
        }
    }

    /// Grown on all sides.
    pub fn grown(&self, by_m: f64) -> Self {
        Self {
            least_m: self.least_m.add_scalar(-by_m),
            most_m: self.most_m.add_scalar(by_m),
        }
    }

    /// Their distance in metres; 0 if they overlap.
    pub fn apart_m(&self, other: &Self) -> f64 {
        let below = self.least_m - other.most_m;
        let above = other.least_m - self.most_m;
        below.sup(&above).sup(&Vector3::zeros()).norm()
    }

    /// Whether they overlap.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| {
            self.least_m[axis] <= other.most_m[axis] && other.least_m[axis] <= self.most_m[axis]
        })
    }
}
