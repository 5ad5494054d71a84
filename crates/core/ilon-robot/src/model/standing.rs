//! How a robot stands on a plane, on wheels of any radius and height.
//!
//! The plane carries the robot at the lowest points of three of its wheels: those whose triangle
//! contains the centre of mass, with no wheel below their plane. Of all planes below the wheels it
//! is the one that is highest under the centre of mass, because gravity puts the robot as low as
//! possible.
//!
//! A wheel's lowest point moves as the robot leans, so the plane is found by iteration: lowest
//! points, then their plane, then the lowest points again. Each iteration is a Newton step, because
//! a plane touches a wheel at its lowest point.

use nalgebra::{Matrix2, Unit, UnitQuaternion, Vector2, Vector3};

use super::{Collision, Robot, RollerForm, Wheel};

/// How a robot stands on a level plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandingPose {
    /// Height of the body frame's origin above the plane, in metres.
    pub height_m: f64,
    /// Roll of the body, about its x axis, in radians; positive if its left side is raised.
    pub roll_rad: f64,
    /// Pitch of the body, about the y axis and after the roll, in radians; positive if its front is
    /// lowered.
    pub pitch_rad: f64,
    /// The wheels that it stands on, by their indices in [`Robot::wheels`]; an index beyond them is
    /// a place of the chassis.
    pub supporting: [usize; 3],
}

/// Largest number of Newton steps; five reach the last bit.
const MOST_STEPS: usize = 30;
/// The iteration ends when the plane turns by less than this, in radians.
const FOUND_RAD: f64 = 1e-14;
/// Wheels equally low within this stand level, in metres: files hold rounded numbers.
const LEVEL_M: f64 = 1e-9;
/// Triangles of less area than this carry nothing, in m^2.
const LEAST_AREA_M2: f64 = 1e-12;

impl StandingPose {
    /// Returns the rotation of the body against the plane: `rotation() * v` expresses a body-frame
    /// vector in a frame whose z is the plane's normal and whose x points ahead.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_euler_angles(self.roll_rad, self.pitch_rad, 0.0)
    }

    /// Returns the angle between the plane's normal and the body's z axis, in radians.
    pub fn tilt_rad(&self) -> f64 {
        let up = self.up_in_body();
        libm::atan2(up.xy().norm(), up.z)
    }

    /// Returns the height of a wheel above the plane, in metres; 0 for supporting wheels.
    pub fn gap_m(&self, wheel: &Wheel) -> f64 {
        let up = self.up_in_body();
        self.height_m + wheel.lowest_point_m(&up).dot(&up)
    }

    /// The plane's normal in the body frame.
    pub fn up_in_body(&self) -> Unit<Vector3<f64>> {
        // The last row of Ry(pitch) Rx(roll).
        let (sin_roll, cos_roll) = libm::sincos(self.roll_rad);
        let (sin_pitch, cos_pitch) = libm::sincos(self.pitch_rad);
        Unit::new_normalize(Vector3::new(
            -sin_pitch,
            cos_pitch * sin_roll,
            cos_pitch * cos_roll,
        ))
    }
}

impl Robot {
    /// Returns how the robot stands on a level plane, at wheel angles zero. `None` if it cannot
    /// stand: its centre of mass lies outside the area of its wheels, or the wheels are in one
    /// line. A robot on tyres without joints stands on its wheels and its chassis then, whose
    /// lowest points are its casters.
    ///
    /// A robot whose supporting wheels are equally low stands exactly level, at its
    /// [`Self::ride_height_m`].
    pub fn standing_pose(&self) -> Option<StandingPose> {
        let on_wheels = self.pose_on(&[]);
        let has_casters = self.joints.is_empty() && self.has_tyres();
        match on_wheels {
            None if has_casters => self.pose_on(&self.chassis.collisions),
            pose => pose,
        }
    }

    /// The same on the wheels and on shapes of the chassis.
    fn pose_on(&self, shapes: &[Collision]) -> Option<StandingPose> {
        let center = self.center_of_mass_m();
        let mut up = Vector3::z_axis();
        let mut supporting = [0; 3];
        for step in 0..MOST_STEPS {
            let wheels = self.wheels.iter().map(|w| w.lowest_point_m(&up));
            let of_shapes = shapes.iter().flat_map(|shape| low_places_m(shape, &up));
            let lowest: Vec<Vector3<f64>> = wheels.chain(of_shapes).collect();
            supporting = triangle_under(&lowest, &center, &up)?;
            let three = supporting.map(|i| lowest[i]);
            let on_a_wheel = supporting.iter().any(|at| *at < self.wheels.len());
            if step == 0 && on_a_wheel && spread_m(three) < LEVEL_M {
                return Some(StandingPose {
                    height_m: self.ride_height_m(),
                    roll_rad: 0.0,
                    pitch_rad: 0.0,
                    supporting,
                });
            }
            let next = Unit::try_new((three[1] - three[0]).cross(&(three[2] - three[0])), 1e-15)?;
            let next = if next.dot(&up) < 0.0 { -next } else { next };
            let turned_rad = next.cross(&up).norm();
            up = next;
            if turned_rad < FOUND_RAD {
                break;
            }
        }
        let wheels = self.wheels.iter().map(|w| w.lowest_point_m(&up).dot(&up));
        let of_shapes = shapes.iter().map(|of| -of.reach_m(&-up.into_inner()));
        Some(StandingPose {
            height_m: -wheels.chain(of_shapes).fold(f64::INFINITY, f64::min),
            roll_rad: libm::atan2(up.y, up.z),
            pitch_rad: libm::atan2(-up.x, libm::hypot(up.y, up.z)),
            supporting,
        })
    }
}

/// Returns the places at which a shape of the chassis may stand, in metres: its lowest point, and
/// those that are lowest if it leans a little, as the corners of a box.
fn low_places_m(shape: &Collision, up: &Unit<Vector3<f64>>) -> [Vector3<f64>; 9] {
    /// How much, in radians (chosen).
    const LEANS_RAD: f64 = 0.1;
    std::array::from_fn(|way| {
        let (sin, cos) = libm::sincos(way as f64 * std::f64::consts::FRAC_PI_4);
        let leans = match way {
            8 => Vector3::zeros(),
            _ => LEANS_RAD * Vector3::new(cos, sin, 0.0),
        };
        shape.farthest(&(leans - up.into_inner())).coords
    })
}

impl Wheel {
    /// Returns the wheel's lowest point for an upward direction `up`, in the body frame, in metres,
    /// at wheel angle zero. A wheel with barrels counts as the ring that its rollers sweep in a
    /// turn: a circle through their middles, as thick as they are there.
    pub fn lowest_point_m(&self, up: &Unit<Vector3<f64>>) -> Vector3<f64> {
        let as_modelled = |r: &super::Roller| matches!(r.form, RollerForm::AsModelled(_));
        if self.rollers.iter().any(as_modelled) || !self.is_round() {
            return self.position_m() - up.into_inner() * self.reach_in_body_m(&-*up);
        }
        let thick_m = self.rollers.iter().map(|r| r.radius_m).fold(0.0, f64::max);
        let n = self.body_from_hub.rotation * Vector3::z();
        let across = up.into_inner() - n * n.dot(up);
        let outward = across.try_normalize(1e-9).unwrap_or_default();
        self.position_m() - outward * (self.radius_m - thick_m) - up.into_inner() * thick_m
    }
}

fn spread_m(points: [Vector3<f64>; 3]) -> f64 {
    let [p, q, r] = points.map(|point| point.z);
    p.max(q).max(r) - p.min(q).min(r)
}

/// Returns the three points whose triangle contains the centre of mass, with none of the others
/// below their plane; heights are along `up`.
///
/// The dual simplex method: from any triangle under the centre, the point deepest below its plane
/// enters, in exchange for the one without which the centre stays over the triangle. Each exchange
/// lowers the plane under the centre, so the method ends.
fn triangle_under(
    points: &[Vector3<f64>],
    center: &Vector3<f64>,
    up: &Unit<Vector3<f64>>,
) -> Option<[usize; 3]> {
    let level_from_body = UnitQuaternion::rotation_between(up, &Vector3::z())?;
    let points: Vec<Vector3<f64>> = points.iter().map(|p| level_from_body * p).collect();
    let center = (level_from_body * center).xy();
    let mut three = any_triangle(&points, &center)?;
    // Far more than any number of wheels needs.
    for _ in 0..100 + 10 * points.len() {
        let corners = three.map(|i| points[i]);
        let height_m = |p: &Vector3<f64>| {
            let shares = shares(&corners, &p.xy())?;
            Some(p.z - (0..3).map(|i| shares[i] * corners[i].z).sum::<f64>())
        };
        let deepest = (0..points.len())
            .filter_map(|i| Some((i, height_m(&points[i])?)))
            .min_by(|p, q| p.1.total_cmp(&q.1));
        let Some((entering, _)) = deepest.filter(|(_, height_m)| *height_m < -LEVEL_M * 1e-3)
        else {
            break;
        };
        let of_center = shares(&corners, &center)?;
        let of_entering = shares(&corners, &points[entering].xy())?;
        let leaving = (0..3)
            .filter(|&i| of_entering[i] > 1e-12)
            .min_by(|&i, &j| {
                let ratio = |i: usize| of_center[i] / of_entering[i];
                ratio(i).total_cmp(&ratio(j))
            })?;
        three[leaving] = entering;
    }
    Some(three)
}

/// Returns a triangle of points that contains the centre. The triangles of the first point with any
/// two others cover the convex hull.
fn any_triangle(points: &[Vector3<f64>], center: &Vector2<f64>) -> Option<[usize; 3]> {
    for j in 1..points.len() {
        for k in j + 1..points.len() {
            let corners = [points[0], points[j], points[k]];
            let inside = shares(&corners, center).is_some_and(|s| s.iter().all(|x| *x >= -1e-9));
            if inside {
                return Some([0, j, k]);
            }
        }
    }
    None
}

/// Returns the weights of a triangle's corners whose mean is the point; `None` for a triangle
/// without area.
fn shares(corners: &[Vector3<f64>; 3], point: &Vector2<f64>) -> Option<[f64; 3]> {
    let [p, q, r] = corners.map(|corner| corner.xy());
    let sides = Matrix2::from_columns(&[q - p, r - p]);
    if sides.determinant().abs() < LEAST_AREA_M2 {
        return None;
    }
    let weights = sides.try_inverse()? * (point - p);
    Some([1.0 - weights.x - weights.y, weights.x, weights.y])
}
