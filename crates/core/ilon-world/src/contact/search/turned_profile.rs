//! The points of a roller with a profile by numbers near a piece of ground, in f64.
//!
//! Such a roller is a convex body (see [`ilon_robot::solid_of_revolution`]), and unlike a barrel it
//! can lie on the ground with two of its corners at once: on a flat face its lowest corner and its
//! neighbours are separate contacts.
//!
//! **Faces.** The corner i is a circle of radius q about the axis at t, thickened by a ball of
//! radius c. Against a flat face with the unit normal **n** its lowest point is t **d** - q **e** -
//! c **n** from the roller's middle, **e** the unit vector of **n** across the axis **d**. That is
//! exact.
//!
//! **Edges.** The distance of a point from a convex body is convex along a straight line. So the
//! point of an edge of the ground nearest to the roller is where the derivative of that distance
//! along the edge changes its sign, which bisection finds; corners of the ground are the ends of
//! edges. It counts if the way from it to the roller leads out of the ground.

#[cfg(test)]
mod tests;

use ilon_robot::SolidOfRevolution;
use nalgebra::Vector3;

use super::bounds::Bounds;
use super::nearest::{Nearest, Piece};

/// The tilt to either side over which the curvature of a piecewise straight outline is averaged, in
/// radians: the tilt of a roller of a wheel with a dozen of them in a twentieth of its turn on the
/// ground. Chosen.
const MEAN_TILT: f64 = 0.02;

/// A turned roller in its pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedProfile<'a> {
    /// Its shape.
    pub turned: &'a SolidOfRevolution,
    /// Its middle, in the floor's frame, in metres.
    pub center_m: Vector3<f64>,
    /// Its axis, in the floor's frame.
    pub axis: Vector3<f64>,
}

/// The search along an edge of the ground ends within this, in metres: the error of the smallest
/// distance is below rounding. Chosen.
const SETTLED_M: f64 = 1e-11;

impl PlacedProfile<'_> {
    /// The support point of a corner in a direction's opposite, in metres; by default that of the
    /// corner that reaches furthest.
    pub fn support(&self, normal: &Vector3<f64>, corner: Option<usize>) -> Vector3<f64> {
        let index = corner.unwrap_or_else(|| self.lowest(normal));
        let corner = &self.turned.corners()[index];
        let along = normal.dot(&self.axis);
        let across = normal - along * self.axis;
        // A roller that stands upright on its face touches with all of it: its point is then the
        // middle of the face.
        let across = across.try_normalize(1e-9).unwrap_or_default();
        self.center_m + corner.t_m * self.axis - corner.ring_m * across - corner.ball_m * normal
    }

    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        let half_m = self.axis.map(|along| {
            let across = (1.0 - along * along).max(0.0).sqrt();
            let corners = self.turned.corners().iter();
            corners.fold(0.0, |most_m: f64, corner| {
                let to_side_m = corner.ring_m * across + corner.ball_m;
                most_m.max((corner.t_m * along).abs() + to_side_m)
            })
        });
        Bounds {
            least_m: self.center_m - half_m,
            most_m: self.center_m + half_m,
        }
    }

    /// Radii of curvature of its surface at the support point in a direction's opposite, along its
    /// outline and around its axis, in metres: along a piecewise straight outline the mean over a
    /// tilt by [`MEAN_TILT`] to either side.
    pub fn radii_m(&self, normal: &Vector3<f64>) -> [f64; 2] {
        let second = normal
            .cross(&self.axis)
            .try_normalize(1e-9)
            .unwrap_or_default();
        let first = second.cross(normal);
        let (sin, cos) = libm::sincos(MEAN_TILT);
        // Tilting it is the same as tilting the direction the other way.
        let place_m = |sin: f64| {
            let then = cos * normal - sin * first;
            self.support(&then, None) - self.center_m
        };
        let along_m = (place_m(sin) - place_m(-sin)).dot(&first) / (2.0 * sin);
        let corner = &self.turned.corners()[self.lowest(normal)];
        [
            along_m,
            corner.ring_m / self.axis.dot(&first) + corner.ball_m,
        ]
    }

    /// The corner that reaches furthest in a direction's opposite; of equal ones the first.
    fn lowest(&self, normal: &Vector3<f64>) -> usize {
        let w = -normal.dot(&self.axis);
        let across = (1.0 - w * w).max(0.0).sqrt();
        let mut best = (0, f64::NEG_INFINITY);
        for (index, corner) in self.turned.corners().iter().enumerate() {
            let reach_m = corner.t_m * w + corner.ring_m * across + corner.ball_m;
            if reach_m > best.1 {
                best = (index, reach_m);
            }
        }
        best.0
    }

    /// Its distance from a piece, in metres, negative in penetration; infinity if that is more than
    /// `within_m`.
    pub fn gap_m(&self, piece: &Piece, within_m: f64) -> f64 {
        let mut gap_m = f64::INFINITY;
        self.places_on(piece, within_m, |nearest| {
            gap_m = gap_m.min(nearest.gap_m);
        });
        gap_m
    }

    /// Passes the places nearer to a piece than this to `show`: on a face the lowest corner and its
    /// neighbours, and the nearest point of each edge.
    pub fn places_on(&self, piece: &Piece, within_m: f64, mut show: impl FnMut(Nearest)) {
        piece.faces(|normal| {
            let last = self.turned.corners().len() - 1;
            // Of a tyre all three can be equally low.
            let lowest = if last == 2 { 1 } else { self.lowest(&normal) };
            for corner in lowest.saturating_sub(1)..=(lowest + 1).min(last) {
                let place_m = self.support(&normal, Some(corner));
                let foot = piece.foot(&place_m);
                /// Over the face or straight beneath it, within rounding; beside it, an edge is
                /// nearer.
                const SAME_PLACE_M: f64 = 1e-9;
                let beside_m = place_m - foot.place_m - foot.distance_m * normal;
                if beside_m.norm() < SAME_PLACE_M && foot.distance_m < within_m {
                    let ball_m = self.turned.corners()[corner].ball_m;
                    show(Nearest {
                        normal,
                        place_m: foot.place_m,
                        gap_m: foot.distance_m,
                        sphere_m: place_m + ball_m * normal,
                        corner: Some(corner),
                    });
                }
            }
        });
        piece.edges(|from_m, to_m| {
            let nearest = self.nearest_of_edge((&from_m, &to_m), within_m);
            let Some((place_m, gap_m, normal)) = nearest else {
                return;
            };
            /// Far above the rounding of points, far below the accuracy of the ground, in metres.
            /// Chosen.
            const OUT_M: f64 = 1e-6;
            let out = piece.foot(&(place_m + OUT_M * normal));
            if out.distance_m > 0.0 && (out.place_m - place_m).norm() < 1e-3 * OUT_M {
                show(Nearest {
                    normal,
                    place_m,
                    gap_m,
                    sphere_m: place_m + (gap_m + self.turned.edge_radius_m()) * normal,
                    corner: None,
                });
            }
        });
    }

    /// The point of a straight edge nearest to the roller, its distance, and the unit vector from
    /// it to the roller; `None` if all of it is further away than `within_m`.
    fn nearest_of_edge(
        &self,
        (from_m, to_m): (&Vector3<f64>, &Vector3<f64>),
        within_m: f64,
    ) -> Option<(Vector3<f64>, f64, Vector3<f64>)> {
        let along = (to_m - from_m).try_normalize(0.0)?;
        let length_m = (to_m - from_m).norm();
        let look = |at_m: f64| {
            let place_m = from_m + at_m * along;
            let off_m = place_m - self.center_m;
            let t_m = off_m.dot(&self.axis);
            let across = off_m - t_m * self.axis;
            let r_m = across.norm();
            let (distance_m, [grows_along, grows_across]) = self.turned.distance_m(t_m, r_m);
            let outward = across.try_normalize(1e-12).unwrap_or_default();
            let grows = grows_along * self.axis + grows_across * outward;
            (place_m, distance_m, grows)
        };
        let (mut low_m, mut high_m) = (0.0, length_m);
        loop {
            let middle_m = 0.5 * (low_m + high_m);
            let half_m = 0.5 * (high_m - low_m);
            let (place_m, distance_m, grows) = look(middle_m);
            // A metre along the edge reduces the distance by a metre at most.
            if distance_m - half_m >= within_m {
                return None;
            }
            // A long edge cannot be halved below the rounding of its points.
            if half_m <= SETTLED_M || middle_m <= low_m || middle_m >= high_m {
                return (distance_m < within_m).then_some((place_m, distance_m, -grows));
            }
            if grows.dot(&along) > 0.0 {
                high_m = middle_m;
            } else {
                low_m = middle_m;
            }
        }
    }
}
