//! An inner polytope of the set of possible accelerations: the convex hull of points on its
//! boundary.
//!
//! The set is convex, so any of its points may be corners. The polytope starts as the octahedron of
//! the limits along the axes. Then, repeatedly, the face whose centroid lies furthest inside the
//! boundary, as seen from zero, is refined: the boundary point beyond the centroid becomes a
//! corner, all faces visible from it are removed, and their rim is joined to it. Rotations are
//! scaled by the distance of the outermost wheel, so that all three axes are in m/s^2.
//!
//! **Bound of the missing part.** Let the boundary beyond the centroid of a face be at l = 1 + e,
//! where l is linear and 1 on the face, and let a possible point q lie beyond the same face at l =
//! 1 + h. As seen from zero, the centroid lies between q and a point on the face's rim, at least a
//! third of the way to q. The line between the two is possible too, and passes over the centroid at
//! l = 1 + h s / (1 + h (1 - s)) with s >= 1/3, which is at most 1 + e: h <= 3 e / (1 - 2 e). In
//! the direction of q the share h / (1 + h) is missing.

use ilon_robot::Twist;
use nalgebra::{Vector2, Vector3};

use super::{AccelerationLimits, LimitedBy};
use crate::{ControlError, Motor};

/// A convex polytope of possible accelerations.
#[derive(Clone, Debug, PartialEq)]
pub struct AccelerationPolytope {
    /// The corners, on the boundary of the possible set: rates of change of the twist (d/dt of its
    /// components in the body frame).
    pub corners: Vec<Twist>,
    /// The limit at each corner.
    pub held_by: Vec<LimitedBy>,
    /// The faces: an acceleration (a, b, c) lies inside if x a + y b + z c <= 1 for each; in s^2/m,
    /// and for z in s^2/rad.
    pub half_spaces: Vec<[f64; 3]>,
    /// Upper bound of the share of the possible acceleration that is missing, over all directions.
    pub missing_at_most: f64,
    edges: Vec<[usize; 2]>,
}

impl AccelerationPolytope {
    /// Scales the polytope by a share about the origin; the missing share grows accordingly.
    pub fn scale(&mut self, share: f64) {
        for corner in &mut self.corners {
            *corner = corner.scaled(share);
        }
        for half_space in &mut self.half_spaces {
            *half_space = half_space.map(|per_acceleration| per_acceleration / share);
        }
        self.missing_at_most = 1.0 - share * (1.0 - self.missing_at_most);
    }

    /// Returns the share of the polytope that an acceleration uses: at most 1 inside.
    pub fn share(&self, twist_rate: Twist) -> f64 {
        let products = self.half_spaces.iter().map(|[x, y, z]| {
            x * twist_rate.vx_m_s + y * twist_rate.vy_m_s + z * twist_rate.omega_rad_s
        });
        products.fold(0.0, f64::max)
    }

    /// Returns the cut at a yaw acceleration in rad/s^2: the corners of a convex polygon in m/s^2,
    /// counter-clockwise; empty beyond the polytope.
    pub fn at_yaw_acceleration(&self, alpha_rad_s2: f64) -> Vec<Vector2<f64>> {
        let cuts = self.edges.iter().filter_map(|edge| {
            let [a, b] = edge.map(|corner| self.corners[corner]);
            let (below, above) = (alpha_rad_s2 - a.omega_rad_s, b.omega_rad_s - alpha_rad_s2);
            let share = below / (below + above);
            (below * above >= 0.0 && share.is_finite()).then(|| {
                let from = Vector2::new(a.vx_m_s, a.vy_m_s);
                from.lerp(&Vector2::new(b.vx_m_s, b.vy_m_s), share)
            })
        });
        let mut outline: Vec<Vector2<f64>> = cuts.collect();
        let middle = outline.iter().sum::<Vector2<f64>>() / outline.len().max(1) as f64;
        let angle = |v: &Vector2<f64>| libm::atan2(v.y - middle.y, v.x - middle.x);
        outline.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        outline.dedup_by(|a, b| (*a - *b).norm() <= 1e-9 * (a.norm() + b.norm()));
        outline
    }
}

impl AccelerationLimits {
    /// Returns an inner polytope of the accelerations that are possible while the robot moves with
    /// `twist`. Along each face's centroid at most the share `shortfall` is missing, unless it has
    /// [`MOST_CORNERS`](Self::MOST_CORNERS). `None` if some acceleration along an axis is
    /// impossible.
    ///
    /// # Errors
    /// Those of [`Self::along`]; [`ControlError::NotPositive`] for `shortfall`.
    pub fn polytope(
        &mut self,
        twist: Twist,
        motors: &[Motor],
        shortfall: f64,
    ) -> Result<Option<AccelerationPolytope>, ControlError> {
        crate::error::positive("the share that may be missing", shortfall)?;
        let arm_m = self.arm_m();
        let mut edge = |way: Vector3<f64>| -> Result<Corner, ControlError> {
            let direction = Twist::new(way.x, way.y, way.z / arm_m);
            let found = self.along(direction, twist, motors)?;
            let (wheel, cause) = (found.wheel, found.cause);
            Ok(Corner {
                at: found.largest * way,
                by: LimitedBy { wheel, cause },
            })
        };
        let mut hull = Hull::default();
        for way in [Vector3::x(), Vector3::y(), Vector3::z()] {
            for way in [way, -way] {
                hull.corners.push(edge(way)?);
            }
        }
        if hull.corners.iter().any(|corner| corner.at.norm() == 0.0) {
            return Ok(None);
        }
        for x in [0, 1] {
            for y in [2, 3] {
                for z in [4, 5] {
                    // Counter-clockwise as seen from outside.
                    let corners = match (x + y + z) % 2 == 0 {
                        true => [x, y, z],
                        false => [x, z, y],
                    };
                    hull.add(corners, &mut edge)?;
                }
            }
        }
        while hull.corners.len() < Self::MOST_CORNERS {
            let widest = hull.faces.iter().enumerate();
            let widest = widest.filter(|(_, face)| !face.is_last);
            let widest = widest.max_by(|(_, a), (_, b)| a.missing.total_cmp(&b.missing));
            let Some((face, missing)) = widest.map(|(face, found)| (face, found.missing)) else {
                break;
            };
            if missing <= shortfall {
                break;
            }
            if !hull.grow(face, &mut edge)? {
                hull.faces[face].is_last = true;
            }
        }
        Ok(Some(hull.into_polytope(arm_m)))
    }

    /// Largest number of corners.
    pub const MOST_CORNERS: usize = 100;
}

/// A point on the boundary, in m/s^2.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: Vector3<f64>,
    by: LimitedBy,
}

/// A triangle between corners, counter-clockwise as seen from outside.
#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [usize; 3],
    /// Unit normal, outward.
    normal: Vector3<f64>,
    /// Distance from zero.
    distance: f64,
    /// The boundary point beyond the centroid, and its distance relative to the centroid's.
    beyond: Corner,
    missing: f64,
    /// Whether the face cannot be refined.
    is_last: bool,
}

impl Face {
    /// Whether a point lies beyond the face's plane, by more than rounding.
    fn sees(&self, at: &Vector3<f64>) -> bool {
        self.normal.dot(at) > self.distance + 1e-9 * at.norm()
    }

    /// Returns the upper bound of the share missing beyond this face.
    fn missing_at_most(&self) -> f64 {
        // e and h of the module's derivation.
        let e = self.missing / (1.0 - self.missing);
        match 1.0 - 2.0 * e > 0.0 {
            true => {
                let h = 3.0 * e / (1.0 - 2.0 * e);
                h / (1.0 + h)
            }
            false => 1.0,
        }
    }

    fn edges(&self) -> [[usize; 2]; 3] {
        let [a, b, c] = self.corners;
        [[a, b], [b, c], [c, a]]
    }
}

#[derive(Debug, Default)]
struct Hull {
    corners: Vec<Corner>,
    faces: Vec<Face>,
}

/// A triangle whose height is below this share of its base is discarded.
const SLIVER: f64 = 1e-6;

impl Hull {
    /// Returns the normal of a triangle, not of unit length; `None` for a sliver.
    fn normal(&self, corners: [usize; 3]) -> Option<Vector3<f64>> {
        let [a, b, c] = corners.map(|corner| self.corners[corner].at);
        let normal = (b - a).cross(&(c - a));
        let longest = (b - a).norm().max((c - a).norm()).max((c - b).norm());
        (normal.norm() > SLIVER * longest * longest).then_some(normal)
    }

    /// Adds a triangle, with the boundary point beyond its centroid.
    fn add<E>(
        &mut self,
        corners: [usize; 3],
        edge: &mut impl FnMut(Vector3<f64>) -> Result<Corner, E>,
    ) -> Result<(), E> {
        let [a, b, c] = corners.map(|corner| self.corners[corner].at);
        let normal = (b - a).cross(&(c - a)).normalize();
        let middle = (a + b + c) / 3.0;
        let beyond = edge(middle)?;
        self.faces.push(Face {
            corners,
            normal,
            distance: normal.dot(&a),
            missing: 1.0 - middle.norm() / beyond.at.norm(),
            beyond,
            is_last: false,
        });
        Ok(())
    }

    /// Adds the boundary point beyond a face's centroid as a corner; `false` if this would create a
    /// sliver.
    fn grow<E>(
        &mut self,
        face: usize,
        edge: &mut impl FnMut(Vector3<f64>) -> Result<Corner, E>,
    ) -> Result<bool, E> {
        let new = self.faces[face].beyond;
        let seen = |face: &Face| face.sees(&new.at);
        let inner: Vec<[usize; 2]> = self
            .faces
            .iter()
            .filter(|f| seen(f))
            .flat_map(Face::edges)
            .collect();
        // An edge between two visible faces occurs in both directions.
        let rim = inner.iter().filter(|[a, b]| !inner.contains(&[*b, *a]));
        let at = self.corners.len();
        self.corners.push(new);
        let joined: Vec<[usize; 3]> = rim.map(|[a, b]| [*a, *b, at]).collect();
        if joined.is_empty() || joined.iter().any(|corners| self.normal(*corners).is_none()) {
            self.corners.pop();
            return Ok(false);
        }
        self.faces.retain(|face| !face.sees(&new.at));
        for corners in joined {
            self.add(corners, edge)?;
        }
        Ok(true)
    }

    fn into_polytope(self, arm_m: f64) -> AccelerationPolytope {
        let mut half_spaces: Vec<Vector3<f64>> = Vec::new();
        for face in &self.faces {
            let side = face.normal / face.distance;
            // Triangles without area, from rounding, are skipped: their neighbours bound the
            // polytope.
            let is_side = face.distance > 0.0
                && self
                    .corners
                    .iter()
                    .all(|corner| side.dot(&corner.at) < 1.0 + 1e-5);
            if !is_side {
                continue;
            }
            // Triangles in one plane form one face.
            if half_spaces
                .iter()
                .all(|known| (known - side).norm() > 1e-6 * side.norm())
            {
                half_spaces.push(side);
            }
        }
        // A corner inside the hull of later ones is no longer a corner.
        let mut places = vec![None; self.corners.len()];
        let (mut corners, mut held_by, mut edges) = (Vec::new(), Vec::new(), Vec::new());
        let mut place = |corner: usize| {
            *places[corner].get_or_insert_with(|| {
                let Corner { at, by } = self.corners[corner];
                corners.push(Twist::new(at.x, at.y, at.z / arm_m));
                held_by.push(by);
                corners.len() - 1
            })
        };
        for [a, b] in self.faces.iter().flat_map(Face::edges) {
            let edge = [place(a), place(b)];
            // Each edge occurs in both directions.
            if a < b {
                edges.push(edge);
            }
        }
        AccelerationPolytope {
            corners,
            held_by,
            half_spaces: half_spaces
                .iter()
                .map(|side| [side.x, side.y, side.z * arm_m])
                .collect(),
            missing_at_most: self
                .faces
                .iter()
                .map(Face::missing_at_most)
                .fold(0.0, f64::max),
            edges,
        }
    }
}

#[cfg(test)]
mod tests;
