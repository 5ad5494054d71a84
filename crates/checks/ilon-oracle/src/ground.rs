//! Contact of a roller with floor and plates.
//!
//! A plate is convex, and so is the distance of a point from it. A roller is the envelope of
//! spheres on its axis, of radius s(t) at the place t, and -s is convex too (see `outline.rs`). So
//! the roller's distance from the plate, the minimum of (distance of the centre) - s(t), has one
//! minimum over t, which a golden-section search finds. There the sphere is deepest, and the
//! ground's normal points from the plate's nearest point to the centre: over the top it is up, over
//! an edge it turns with the roller.

use nalgebra::{Matrix3, Vector3};

use crate::Plate;
use crate::outline::Shape;

/// A roller at its pose, in the world frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'a> {
    pub shape: &'a Shape,
    pub center: Vector3<f64>,
    pub axis: Vector3<f64>,
}

/// The deepest point of a roller in a piece of ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    /// The roller's point, in the world frame, in metres.
    pub point: Vector3<f64>,
    /// In metres, negative above the ground.
    pub depth_m: f64,
    /// Two tangents and the normal out of the ground.
    pub world_from_ground: Matrix3<f64>,
}

impl Placed<'_> {
    /// The roller's deepest point in the floor; `None` if it is far above.
    pub fn on_the_floor(&self) -> Option<Touch> {
        if self.center.z > self.shape.bound_m() {
            return None;
        }
        let lowest = self.shape.lowest(self.axis.z);
        let center = self.center + self.axis * lowest.place_m;
        Some(Touch {
            point: center - Vector3::z() * lowest.radius_m,
            depth_m: lowest.radius_m - center.z,
            world_from_ground: Matrix3::identity(),
        })
    }

    /// The roller's deepest point in the plate; `None` if it is beside it or far above, and for a
    /// tyre, which no plate holds.
    pub fn on(&self, plate: &Plate) -> Option<Touch> {
        /// Sections: from a roller's length to 1e-8 of it, where rounding of the distance ends the
        /// search.
        const SECTIONS: usize = 38;
        let outline = self.shape.outline()?;
        let (c, bound) = (&self.center, outline.bound_m());
        if (c - plate.nearest(c)).norm() > bound {
            return None;
        }
        let section = 0.5 * (5.0_f64.sqrt() - 1.0);
        let gap = |t: f64| {
            let center = c + self.axis * t;
            (center - plate.nearest(&center)).norm() - outline.radius_m(t)
        };
        let (mut low, mut high) = (-outline.half_length_m(), outline.half_length_m());
        let mut inner = [high - section * (high - low), low + section * (high - low)];
        let mut gaps = inner.map(gap);
        for _ in 0..SECTIONS {
            if gaps[0] < gaps[1] {
                high = inner[1];
                inner = [high - section * (high - low), inner[0]];
                gaps = [gap(inner[0]), gaps[0]];
            } else {
                low = inner[0];
                inner = [inner[1], low + section * (high - low)];
                gaps = [gaps[1], gap(inner[1])];
            }
        }
        let t = 0.5 * (low + high);
        let center = c + self.axis * t;
        let off = center - plate.nearest(&center);
        let radius = outline.radius_m(t);
        // A point of the axis within the plate has no defined normal.
        let normal = off.try_normalize(1e-9)?;
        Some(Touch {
            point: center - normal * radius,
            depth_m: radius - off.norm(),
            world_from_ground: ground_axes(&normal),
        })
    }
}

impl Plate {
    /// Its point nearest to an outside one, in metres. Below the floor the plate continues.
    fn nearest(&self, point: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            point.x.clamp(self.from_m.x, self.to_m.x),
            point.y.clamp(self.from_m.y, self.to_m.y),
            point.z.min(self.height_m),
        )
    }
}

/// The world's axes after the smallest rotation that brings z to the normal `n`, which points
/// upwards or sideways.
fn ground_axes(n: &Vector3<f64>) -> Matrix3<f64> {
    let share = 1.0 / (1.0 + n.z);
    let across = -n.x * n.y * share;
    Matrix3::new(
        1.0 - n.x * n.x * share,
        across,
        n.x,
        across,
        1.0 - n.y * n.y * share,
        n.y,
        -n.x,
        -n.y,
        n.z,
    )
}
