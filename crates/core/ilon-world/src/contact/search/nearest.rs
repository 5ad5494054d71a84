//! The point of a roller's exact barrel nearest to a piece of ground, in f64.
//!
//! The barrel is a family of spheres, so its distance to a convex piece is the minimum over the
//! family: dist = min over t of f(t), f(t) = distance(c + t d) - s(t), with c the roller's middle,
//! d its axis and s the profile of [`ilon_robot::Barrel`]. Both parts of f are convex in t, so
//! there is one minimum, where f'(t) = d . n(t) + k^2 t / sqrt(a^2 + k^2 t^2) changes its sign (n
//! from the piece to the sphere's centre), or an end.
//!
//! A surface consists of many pieces. A point on one of them is a contact point only if it is the
//! nearest of the whole surface around it: see [`keep_nearest_of_surface`].

#[cfg(test)]
mod tests;

use ilon_robot::Barrel;
use nalgebra::{Isometry3, Point3, Vector2, Vector3};

use crate::contact::search::ball_and_cylinder::{SolidBall, SolidCylinder};
use crate::contact::search::bounds::Bounds;

/// The search along a roller's axis ends within this, in metres. Chosen.
const SETTLED_M: f64 = 1e-13;

/// Points nearer than this are the same: far above the rounding of a few metres in f64, far below
/// the accuracy of a contact, in metres. Chosen.
const SAME_PLACE_M: f64 = 1e-10;

/// A convex piece of ground, in the floor's frame.
#[derive(Clone, Debug)]
pub(crate) enum Piece {
    /// The half-space below z = 0.
    Plane,
    /// A solid box.
    Box(SolidBox),
    /// A triangle of a surface.
    Triangle(Triangle),
    /// A free sphere.
    Ball(SolidBall),
    /// A free cylinder.
    Cylinder(SolidCylinder),
}

/// A solid box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidBox {
    /// Pose of its centre.
    pub floor_from_box: Isometry3<f64>,
    /// Half sides along its own axes, in metres.
    pub half_sides_m: Vector3<f64>,
}

/// A triangle of a surface with the ground beneath it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    corners_m: [Vector3<f64>; 3],
    /// Unit normal out of the ground.
    up: Vector3<f64>,
    /// Whether something can touch its edges: the surface ends there, or bends down.
    has_ridge: bool,
}

/// The point of a piece nearest to a given point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    /// The point on the piece, in metres.
    pub place_m: Vector3<f64>,
    /// Unit vector out of the ground, towards a point outside.
    pub normal: Vector3<f64>,
    /// Distance of the given point, in metres, negative inside.
    pub distance_m: f64,
}

impl From<(Vector3<f64>, Vector3<f64>, f64)> for Foot {
    fn from((place_m, normal, distance_m): (Vector3<f64>, Vector3<f64>, f64)) -> Self {
        Self {
            place_m,
            normal,
            distance_m,
        }
    }
}

/// A roller in its pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedBarrel<'a> {
    /// Its shape.
    pub barrel: &'a Barrel,
    /// Its middle, in the floor's frame, in metres.
    pub center_m: Vector3<f64>,
    /// Its axis, in the floor's frame.
    pub axis: Vector3<f64>,
}

/// The nearest points of a roller and a piece of ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// Unit vector out of the ground towards the roller.
    pub normal: Vector3<f64>,
    /// The point on the ground, in metres.
    pub place_m: Vector3<f64>,
    /// Distance of the surfaces, in metres, negative in penetration.
    pub gap_m: f64,
    /// Centre of the nearest sphere of the barrel, in metres.
    pub sphere_m: Vector3<f64>,
    /// Index of the corner of a turned roller, if it is one.
    pub corner: Option<usize>,
}

/// A bracket for the sign change of a slope that never falls.
struct Bracket {
    ends_m: [f64; 2],
    /// The slope at either end, if known.
    slopes: [Option<f64>; 2],
    /// The end that was moved last.
    last: usize,
}

impl Bracket {
    /// Adds the slope at a place.
    fn look(&mut self, at_m: f64, slope: f64) {
        let side = usize::from(slope > 0.0);
        let is_once_more = self.slopes[side].is_some() && self.last == side;
        self.ends_m[side] = at_m;
        self.slopes[side] = Some(slope);
        self.last = side;
        // The weight of an end that stays is reduced.
        if is_once_more && let Some(other) = &mut self.slopes[1 - side] {
            *other *= 0.5;
        }
    }

    fn middle_m(&self) -> f64 {
        0.5 * (self.ends_m[0] + self.ends_m[1])
    }

    /// The next place: an end with unknown slope, or the zero of the line between both (Illinois's
    /// rule, Dowell and Jarratt 1971).
    fn next_m(&self, round: usize) -> f64 {
        let [low_m, high_m] = self.ends_m;
        match self.slopes {
            [None, _] => low_m,
            [_, None] => high_m,
            // For sharply bent slopes the bracket is halved now and then.
            _ if round % 8 == 7 => self.middle_m(),
            [Some(low), Some(high)] => {
                let at_m = (low_m * high - high_m * low) / (high - low);
                at_m.clamp(low_m, high_m)
            }
        }
    }
}

impl Triangle {
    /// A triangle whose ground lies on the side away from `up`; `None` if it has no area.
    pub fn new(corners_m: [Vector3<f64>; 3], up: &Vector3<f64>) -> Option<Self> {
        let [a, b, c] = corners_m;
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(Self {
            corners_m,
            up: normal * normal.dot(up).signum(),
            has_ridge: true,
        })
    }

    /// Its corners, in metres.
    #[cfg(test)]
    pub fn corners_m(&self) -> [Vector3<f64>; 3] {
        self.corners_m
    }

    /// The same with edges that something can touch, or not.
    pub fn with_ridge(self, has_ridge: bool) -> Self {
        Self { has_ridge, ..self }
    }

    /// Whether a point is on the triangle as seen from above, including its edges.
    fn is_over_or_under(&self, point_m: &Vector3<f64>) -> bool {
        let [a, b, c] = self.corners_m.map(|corner| corner.xy());
        let least_m2 = SAME_PLACE_M * (b - a).abs().sum();
        let side = |from: Vector2<f64>, to: Vector2<f64>| (to - from).perp(&(point_m.xy() - from));
        let sides = [side(a, b), side(b, c), side(c, a)];
        sides.iter().all(|side| *side >= -least_m2) || sides.iter().all(|side| *side <= least_m2)
    }

    /// The point of the triangle nearest to a given point (Ericson, Real-Time Collision Detection
    /// 2005, section 5.1.5).
    fn nearest_m(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        let [a, b, c] = self.corners_m;
        let (ab, ac) = (b - a, c - a);
        let from = |corner: &Vector3<f64>| {
            let off = point_m - corner;
            (ab.dot(&off), ac.dot(&off))
        };
        let (d1, d2) = from(&a);
        if d1 <= 0.0 && d2 <= 0.0 {
            return a;
        }
        let (d3, d4) = from(&b);
        if d3 >= 0.0 && d4 <= d3 {
            return b;
        }
        let of_c = d1 * d4 - d3 * d2;
        if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return a + ab * (d1 / (d1 - d3));
        }
        let (d5, d6) = from(&c);
        if d6 >= 0.0 && d5 <= d6 {
            return c;
        }
        let of_b = d5 * d2 - d1 * d6;
        if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return a + ac * (d2 / (d2 - d6));
        }
        let of_a = d3 * d6 - d5 * d4;
        if of_a <= 0.0 && d4 >= d3 && d5 >= d6 {
            return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
        }
        let sum = of_a + of_b + of_c;
        a + ab * (of_b / sum) + ac * (of_c / sum)
    }
}

impl Piece {
    /// The point of the piece nearest to a given point.
    pub fn foot(&self, point_m: &Vector3<f64>) -> Foot {
        match self {
            Self::Plane => Foot {
                place_m: Vector3::new(point_m.x, point_m.y, 0.0),
                normal: Vector3::z(),
                distance_m: point_m.z,
            },
            Self::Box(solid) => solid.foot(point_m),
            Self::Triangle(triangle) => {
                let place_m = triangle.nearest_m(point_m);
                let off = point_m - place_m;
                if off.dot(&triangle.up) < 0.0 && triangle.is_over_or_under(point_m) {
                    // In the ground. Beside the triangle its plane is meaningless: past the edge of
                    // a slope it is above the ground.
                    return Foot {
                        place_m,
                        normal: triangle.up,
                        distance_m: off.dot(&triangle.up),
                    };
                }
                outside(place_m, off, triangle.up)
            }
            Self::Ball(ball) => Foot::from(ball.foot(point_m)),
            Self::Cylinder(cylinder) => Foot::from(cylinder.foot(point_m)),
        }
    }

    /// Passes the outward unit normals of its flat faces to `show`.
    pub fn faces(&self, mut show: impl FnMut(Vector3<f64>)) {
        match self {
            Self::Plane => show(Vector3::z()),
            Self::Box(solid) => {
                for axis in 0..3 {
                    let normal = solid.floor_from_box.rotation * Vector3::ith(axis, 1.0);
                    show(normal);
                    show(-normal);
                }
            }
            Self::Triangle(triangle) => show(triangle.up),
            Self::Ball(_) | Self::Cylinder(_) => {}
        }
    }

    /// Passes the ends of its straight edges, in metres, to `show`.
    pub fn edges(&self, mut show: impl FnMut(Vector3<f64>, Vector3<f64>)) {
        match self {
            Self::Plane | Self::Ball(_) | Self::Cylinder(_) => {}
            Self::Box(solid) => {
                for axis in 0..3 {
                    for (j, k) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                        let end = |i: f64| {
                            let mut signs = Vector3::zeros();
                            signs[axis] = i;
                            signs[(axis + 1) % 3] = j;
                            signs[(axis + 2) % 3] = k;
                            let corner = signs.component_mul(&solid.half_sides_m);
                            (solid.floor_from_box * Point3::from(corner)).coords
                        };
                        show(end(-1.0), end(1.0));
                    }
                }
            }
            Self::Triangle(triangle) => {
                let [a, b, c] = triangle.corners_m;
                show(a, b);
                show(b, c);
                show(c, a);
            }
        }
    }

    /// Whether a point is on the piece or in it, within rounding.
    fn holds(&self, place_m: &Vector3<f64>) -> bool {
        match self {
            Self::Triangle(triangle) => {
                (triangle.nearest_m(place_m) - place_m).norm_squared() < SAME_PLACE_M.powi(2)
            }
            _ => self.foot(place_m).distance_m < SAME_PLACE_M,
        }
    }
}

impl SolidBox {
    pub fn foot(&self, point_m: &Vector3<f64>) -> Foot {
        let local = self
            .floor_from_box
            .inverse_transform_point(&Point3::from(*point_m))
            .coords;
        let h = &self.half_sides_m;
        let held = local.zip_map(h, |x, h| x.clamp(-h, h));
        if held != local {
            let place_m = (self.floor_from_box * Point3::from(held)).coords;
            return outside(place_m, point_m - place_m, Vector3::z());
        }
        // Inside: out through the nearest face.
        let depths = h - local.abs();
        let face = depths.imin();
        let mut normal = Vector3::zeros();
        normal[face] = 1.0f64.copysign(local[face]);
        let mut on_face = local;
        on_face[face] = h[face].copysign(local[face]);
        Foot {
            place_m: (self.floor_from_box * Point3::from(on_face)).coords,
            normal: self.floor_from_box.rotation * normal,
            distance_m: -depths[face],
        }
    }
}

/// The foot of a point whose offset from the nearest point is `off_m`; `otherwise` is the normal if
/// the point is on the piece.
fn outside(place_m: Vector3<f64>, off_m: Vector3<f64>, otherwise: Vector3<f64>) -> Foot {
    let distance_m = off_m.norm();
    let normal = if distance_m > 0.0 {
        off_m / distance_m
    } else {
        otherwise
    };
    Foot {
        place_m,
        normal,
        distance_m,
    }
}

impl PlacedBarrel<'_> {
    /// Radius of a ball around the roller's middle that contains it, in metres.
    pub fn bounding_radius_m(barrel: &Barrel) -> f64 {
        let h = barrel.half_length_m;
        (h + barrel.sphere_radius_m(h)).max(barrel.sphere_radius_m(0.0))
    }

    /// The roller's support point in a direction's opposite, in metres, and whether it is on one of
    /// its end spheres.
    pub fn support(&self, normal: &Vector3<f64>) -> (Vector3<f64>, bool) {
        let t_m = self.barrel.support_place_m(-normal.dot(&self.axis));
        let place_m = self.center_m + t_m * self.axis - self.barrel.sphere_radius_m(t_m) * normal;
        (place_m, t_m.abs() >= self.barrel.half_length_m)
    }

    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        let half_m = self.axis.map(|along| {
            let t_m = self.barrel.support_place_m(along);
            t_m * along + self.barrel.sphere_radius_m(t_m)
        });
        Bounds {
            least_m: self.center_m - half_m,
            most_m: self.center_m + half_m,
        }
    }

    /// The nearest points of the roller and a piece.
    pub fn nearest_to(&self, piece: &Piece) -> Nearest {
        match piece {
            Piece::Plane => self.nearest_to_plane(),
            _ => self.nearest_to_convex(piece, 0.0, f64::INFINITY),
        }
    }

    /// The same if they are nearer than this; for a triangle without touchable edges only on its
    /// face.
    pub fn nearest_within(&self, piece: &Piece, within_m: f64) -> Option<Nearest> {
        let nearest = match piece {
            Piece::Plane => self.nearest_to_plane(),
            Piece::Triangle(triangle) => self.nearest_to_triangle(triangle, piece, within_m)?,
            _ => self.nearest_to_convex(piece, 0.0, within_m),
        };
        (nearest.gap_m < within_m).then_some(nearest)
    }

    fn nearest_to_triangle(
        &self,
        triangle: &Triangle,
        piece: &Piece,
        within_m: f64,
    ) -> Option<Nearest> {
        let t_m = self.barrel.support_place_m(-self.axis.dot(&triangle.up));
        let sphere_m = self.center_m + t_m * self.axis;
        let over_m = triangle.up.dot(&(sphere_m - triangle.corners_m[0]));
        if !triangle.has_ridge {
            let is_on_it = triangle.is_over_or_under(&(sphere_m - over_m * triangle.up));
            return is_on_it.then(|| self.nearest_at(sphere_m, piece.foot(&sphere_m), t_m));
        }
        if over_m - self.barrel.sphere_radius_m(t_m) >= within_m {
            return None;
        }
        Some(self.nearest_to_convex(piece, t_m, within_m))
    }

    /// On a plane the normal is the same everywhere: the support point is the answer.
    fn nearest_to_plane(&self) -> Nearest {
        let t_m = self.barrel.support_place_m(-self.axis.dot(&Vector3::z()));
        // With the axis parallel to the plane it is the middle, without rounding.
        let t_m = if t_m.abs() <= SETTLED_M { 0.0 } else { t_m };
        let (sphere_m, foot) = self.look(t_m, &Piece::Plane);
        self.nearest_at(sphere_m, foot, t_m)
    }

    /// Searches from a place along its axis. If the whole roller is further away than `within_m`,
    /// the result is any point that is further away too.
    fn nearest_to_convex(&self, piece: &Piece, from_m: f64, within_m: f64) -> Nearest {
        let half_m = self.barrel.half_length_m;
        let mut bracket = Bracket {
            ends_m: [-half_m, half_m],
            slopes: [None; 2],
            last: 0,
        };
        let mut t_m = from_m;
        // On a flat face the normal is constant, the closed form for the plane is the answer, and
        // the second evaluation confirms it. Over edges and corners the bracket converges.
        for round in 0..64 {
            let (sphere_m, foot) = self.look(t_m, piece);
            let along = self.axis.dot(&foot.normal);
            let kt_m = self.barrel.sin_delta * t_m;
            let to_hub_m = libm::hypot(self.barrel.ring_radius_m, kt_m);
            let slope = along + self.barrel.sin_delta * kt_m / to_hub_m;
            let gap_m = foot.distance_m - (self.barrel.wheel_radius_m - to_hub_m);
            bracket.look(t_m, slope);
            // A convex function is above its tangent.
            let [low_m, high_m] = bracket.ends_m;
            let ahead_m = if slope > 0.0 { low_m } else { high_m } - t_m;
            let on_a_face_m = self.barrel.support_place_m(-along);
            let settled = (on_a_face_m - t_m).abs() <= SETTLED_M;
            let is_far = gap_m + slope * ahead_m > within_m;
            if settled || is_far || high_m - low_m < 1e-12 {
                return self.nearest_at(sphere_m, foot, t_m);
            }
            let is_within = (low_m..=high_m).contains(&on_a_face_m);
            t_m = match piece {
                Piece::Triangle(_) => bracket.next_m(round),
                _ if is_within && (round < 4 || round % 2 == 0) => on_a_face_m,
                _ => bracket.middle_m(),
            };
        }
        let (sphere_m, foot) = self.look(t_m, piece);
        self.nearest_at(sphere_m, foot, t_m)
    }

    fn look(&self, t_m: f64, piece: &Piece) -> (Vector3<f64>, Foot) {
        let sphere_m = self.center_m + t_m * self.axis;
        (sphere_m, piece.foot(&sphere_m))
    }

    fn nearest_at(&self, sphere_m: Vector3<f64>, foot: Foot, t_m: f64) -> Nearest {
        Nearest {
            normal: foot.normal,
            place_m: foot.place_m,
            gap_m: foot.distance_m - self.barrel.sphere_radius_m(t_m),
            sphere_m,
            corner: None,
        }
    }
}

/// Keeps, of the points where one roller is nearest to each of several pieces, those that are
/// nearest of the whole surface around them.
///
/// A point on the seam of two pieces is the nearest of one piece, but if the other piece turns
/// towards the roller, a nearer point is right beside it: then nothing can touch at the seam, and a
/// contact there would push along a normal that the surface does not have. So a point is removed if
/// another piece contains it too and is nearer to the sphere; of equal ones one stays. `places` has
/// the index of each point's piece.
///
/// The same holds along a roller: for a barrel across the seam of two coplanar pieces, the point
/// nearest to the piece that is not beneath its lowest point is right over the seam, as near as the
/// other piece is there. But the distance to the other piece is convex along the roller and smaller
/// elsewhere, so that the other contact comes first.
pub(crate) fn keep_nearest_of_surface(places: &mut Vec<(usize, Nearest)>, pieces: &[Piece]) {
    if places.len() < 2 {
        return;
    }
    /// Two pieces are equally near within rounding, in metres.
    const SAME_DISTANCE_M: f64 = 1e-12;
    let nearer = |&(own, nearest): &(usize, Nearest), &(other, beside): &(usize, Nearest)| {
        if other == own || !pieces[other].holds(&nearest.place_m) {
            return false;
        }
        let own_m = pieces[own].foot(&nearest.sphere_m).distance_m;
        let other_m = pieces[other].foot(&nearest.sphere_m).distance_m;
        let is_least_elsewhere = beside.corner.is_none() && !pieces[own].holds(&beside.place_m);
        let of_equals = is_least_elsewhere || other < own;
        other_m < own_m - SAME_DISTANCE_M || of_equals && other_m < own_m + SAME_DISTANCE_M
    };
    // The nearer point is among the places itself: it touches where this one would, or deeper.
    let others = places.clone();
    places.retain(|place| !others.iter().any(|other| nearer(place, other)));
}
