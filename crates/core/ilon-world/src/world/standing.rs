//! Places a robot at the start of a world: on whatever is beneath it, in its stance on a plane,
//! with its lowest wheel just touching.

use ilon_robot::{Barrel, Pose as PlanarPose, Robot, RollerForm, SolidOfRevolution};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rapier3d::prelude::SharedShape;

use crate::contact::search::bounds::Bounds;
use crate::contact::search::nearest::{Piece, PlacedBarrel};
use crate::contact::search::turned_profile::PlacedProfile;
use crate::engine::convert;
use crate::engine::shapes::{shape_of, shape_of_roller};
use crate::ground::{Ground, HeightField};
use crate::{Floor, WorldError};

/// Distance from contact at which a robot or a body is put down, in metres. Chosen.
pub(super) const PUT_DOWN_M: f64 = 1e-9;
/// The smallest step of lowering it, in metres: beside a wall everything is near all the way down.
/// Chosen.
const LEAST_LOWERED_M: f64 = 1e-5;

/// The most steps of lowering a robot by the distance to whatever is nearest. Most stand by then;
/// beside a high wall, or on steep uneven ground, it would take for ever, and the height is
/// bisected instead. Chosen.
const MOST_LOWERED: usize = 200;

/// At a smaller distance the chassis lies on the ground, in metres. Chosen.
const LIES_M: f64 = 1e-6;

/// A surface of the robot that may touch the ground.
struct Surface {
    /// The wheel that it belongs to; `None` for the chassis.
    wheel: Option<usize>,
    form: SurfaceShape,
}

enum SurfaceShape {
    /// The exact barrel, with its middle and axis in the body frame.
    Barrel {
        barrel: Barrel,
        center_m: Vector3<f64>,
        axis: Vector3<f64>,
    },
    /// A profile by numbers, placed in the same way.
    Turned {
        turned: SolidOfRevolution,
        center_m: Vector3<f64>,
        axis: Vector3<f64>,
    },
    /// Any other shape, with its pose in the body frame.
    Shape(Isometry3<f64>, SharedShape),
}

/// The body's pose in the floor's frame when the robot stands at a planar pose.
///
/// # Errors
/// [`WorldError::NoPlaceToStand`] if its chassis would lie on something, or one of its wheels would
/// hang over the ground by more than its radius.
pub(super) fn standing(
    robot: &Robot,
    floor: &Floor,
    ground: &Ground,
    start: PlanarPose,
) -> Result<Isometry3<f64>, WorldError> {
    let surfaces = surfaces(robot);
    let reach_m = surfaces.iter().map(Surface::reach_m).fold(0.0, f64::max);
    // Wheels of unequal radius or height tilt it. A robot that cannot stand is put down upright,
    // and falls over.
    let (upright_m, leaning) = match robot.standing_pose() {
        Some(stands) => (stands.height_m, stands.rotation()),
        None => (robot.ride_height_m(), UnitQuaternion::identity()),
    };
    let at = |height_m: f64| {
        let place_m = Vector3::new(start.x_m, start.y_m, height_m);
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), start.heading_rad);
        Isometry3::from_parts(Translation3::from(place_m), yaw * leaning)
    };
    let on_plane = at(upright_m);
    let top_m = floor.highest_m(start.position_m(), reach_m);
    if !ground.has_solids() {
        return Ok(on_plane);
    }
    let mut pieces = Vec::new();
    let above_m = (top_m + upright_m).max(upright_m);
    let middle_m = at(upright_m).translation.vector;
    let around_m = 2.0 * reach_m + above_m;
    ground.solids_near(&middle_m, around_m, &mut pieces);
    let around = Bounds::of_ball(&middle_m, around_m);
    let relief = ground.relief().filter(|relief| relief.reaches(&around));
    if relief.is_none() && matches!(pieces[..], [] | [Piece::Plane]) {
        return Ok(on_plane);
    }
    // There is nothing beneath this.
    let deepest_m = relief.map_or(f64::NEG_INFINITY, |relief| relief.lowest_m() - around_m);
    let near = |surface: &Surface, height_m: f64| surface.gap_m(&at(height_m), &pieces, ground);
    let nearest_m = |height_m: f64| {
        let gaps = surfaces.iter().map(|surface| near(surface, height_m));
        gaps.fold(f64::INFINITY, f64::min)
    };
    // A robot clear at a height is clear above it, too: there is nothing under uneven ground, and a
    // pose there does not count as clear.
    let is_clear = |height_m: f64| {
        let is_over = |relief: &HeightField| {
            let mut middles = surfaces.iter().map(|of| of.middle_m(&at(height_m)));
            middles.all(|middle_m| (relief.height_m(&middle_m.xy())).is_none_or(|z| z < middle_m.z))
        };
        nearest_m(height_m) > 0.0 && relief.is_none_or(is_over)
    };
    let bottom_m = if ground.is_solid_below() {
        upright_m - reach_m
    } else {
        deepest_m
    };

    // Down from where all of it is free, by no more than the distance to whatever is nearest.
    let (mut free_m, mut lower_m) = (above_m, f64::NEG_INFINITY);
    let mut lowered = 0;
    while free_m - lower_m > PUT_DOWN_M {
        let gap_m = nearest_m(free_m);
        if gap_m < PUT_DOWN_M || free_m < deepest_m {
            break;
        }
        if lowered == MOST_LOWERED && bottom_m.is_finite() {
            if is_clear(bottom_m) {
                free_m = bottom_m;
                break;
            }
            lower_m = lower_m.max(bottom_m);
        }
        lowered += 1;
        let Some(next_m) = next_lower_m(free_m, lower_m, gap_m) else {
            break;
        };
        if is_clear(next_m) {
            free_m = next_m;
        } else {
            lower_m = next_m;
        }
    }
    refuse_what_hangs(robot, &surfaces, |surface| near(surface, free_m))?;
    Ok(at(free_m))
}

/// The height to try below one that is free, at which the nearest is as far as the gap, and above
/// one that is not free, if any is known; `None` if rounding leaves none between. In metres.
pub(super) fn next_lower_m(free_m: f64, lower_m: f64, gap_m: f64) -> Option<f64> {
    let next_m = match lower_m.is_finite() {
        true => 0.5 * (free_m + lower_m),
        false => free_m - gap_m.max(LEAST_LOWERED_M),
    };
    (lower_m < next_m && next_m < free_m).then_some(next_m)
}

/// Distance of the nearest part of a robot from a plane ground, with its wheels at their start
/// angles, in metres.
#[cfg(test)]
pub(super) fn clearance_m(robot: &Robot, ground: &Ground, floor_from_body: &Isometry3<f64>) -> f64 {
    let surfaces = surfaces(robot);
    let gaps = surfaces
        .iter()
        .map(|surface| surface.gap_m(floor_from_body, &[Piece::Plane], ground));
    gaps.fold(f64::INFINITY, f64::min)
}

/// Refuses a robot that does not stand on its wheels.
fn refuse_what_hangs(
    robot: &Robot,
    surfaces: &[Surface],
    gap_m: impl Fn(&Surface) -> f64,
) -> Result<(), WorldError> {
    let least_m = |wheel: Option<usize>| {
        let of_part = surfaces.iter().filter(|surface| surface.wheel == wheel);
        of_part.map(&gap_m).fold(f64::INFINITY, f64::min)
    };
    let refused = |reason: String| Err(WorldError::NoPlaceToStand { reason });
    let wheels = (0..robot.wheels.len()).map(|index| least_m(Some(index)));
    let of_wheels_m = wheels.fold(f64::INFINITY, f64::min);
    // For two shapes nearer than some hundredths of a millimetre parry may report contact: then the
    // chassis came down no further.
    if least_m(None) < LIES_M.max(of_wheels_m) {
        return refused("it would lie on its chassis".to_owned());
    }
    for (index, wheel) in robot.wheels.iter().enumerate() {
        let hangs_m = least_m(Some(index));
        if hangs_m > wheel.radius_m {
            return refused(format!(
                "wheel `{}` would hang more than its radius over the ground",
                wheel.name
            ));
        }
    }
    Ok(())
}

fn surfaces(robot: &Robot) -> Vec<Surface> {
    let mut surfaces: Vec<Surface> = robot
        .chassis
        .collisions
        .iter()
        .filter_map(shape_of)
        .map(|(body_from_shape, shape)| Surface {
            wheel: None,
            form: SurfaceShape::Shape(body_from_shape, shape),
        })
        .collect();
    for (index, wheel) in robot.wheels.iter().enumerate() {
        for roller in &wheel.rollers {
            let center_m = wheel.body_from_hub * Point3::from(roller.center_in_hub_m);
            let (center_m, axis) = (
                center_m.coords,
                wheel.body_from_hub * roller.axis_in_hub.into_inner(),
            );
            let form = match &roller.form {
                RollerForm::Barrel | RollerForm::Made(_) => SurfaceShape::Barrel {
                    barrel: wheel.barrel(roller),
                    center_m,
                    axis,
                },
                RollerForm::Turned(turned) | RollerForm::Tyre(turned) => SurfaceShape::Turned {
                    turned: turned.clone(),
                    center_m,
                    axis,
                },
                RollerForm::AsModelled(modelled) => {
                    let Some(shape) = shape_of_roller(modelled) else {
                        continue;
                    };
                    SurfaceShape::Shape(wheel.body_from_hub * roller.hub_from_roller(), shape)
                }
            };
            let wheel = Some(index);
            surfaces.push(Surface { wheel, form });
        }
    }
    surfaces
}

impl Surface {
    /// A ball around it: its middle in the body frame and its radius, in metres.
    fn ball_m(&self) -> (Point3<f64>, f64) {
        match &self.form {
            SurfaceShape::Barrel {
                barrel, center_m, ..
            } => (
                Point3::from(*center_m),
                PlacedBarrel::bounding_radius_m(barrel),
            ),
            SurfaceShape::Turned {
                turned, center_m, ..
            } => (Point3::from(*center_m), turned.bounding_radius_m()),
            SurfaceShape::Shape(body_from_shape, shape) => {
                let ball = shape.compute_local_bounding_sphere();
                let center_m = Point3::from(convert::to_vector(ball.center));
                (body_from_shape * center_m, ball.radius)
            }
        }
    }

    /// The largest distance of the surface from the body's vertical axis, in metres.
    fn reach_m(&self) -> f64 {
        let (middle_m, radius_m) = self.ball_m();
        middle_m.coords.norm() + radius_m
    }

    /// A point within it, in metres, with the body at a pose in the floor's frame.
    fn middle_m(&self, floor_from_body: &Isometry3<f64>) -> Vector3<f64> {
        (floor_from_body * self.ball_m().0).coords
    }

    /// Its distance from the ground with the body at a pose in the floor's frame, in metres; zero
    /// or less if it touches.
    fn gap_m(&self, floor_from_body: &Isometry3<f64>, pieces: &[Piece], ground: &Ground) -> f64 {
        match &self.form {
            SurfaceShape::Barrel {
                barrel,
                center_m,
                axis,
            } => {
                let placed = PlacedBarrel {
                    barrel,
                    center_m: (floor_from_body * Point3::from(*center_m)).coords,
                    axis: floor_from_body * axis,
                };
                let gap_m = |piece: &Piece, within_m: f64| {
                    let nearest = placed.nearest_within(piece, within_m);
                    nearest.map_or(f64::INFINITY, |nearest| nearest.gap_m)
                };
                least_m(pieces, ground, || placed.bounds(), gap_m)
            }
            SurfaceShape::Turned {
                turned,
                center_m,
                axis,
            } => {
                let placed = PlacedProfile {
                    turned,
                    center_m: (floor_from_body * Point3::from(*center_m)).coords,
                    axis: floor_from_body * axis,
                };
                let gap_m = |piece: &Piece, within_m: f64| placed.gap_m(piece, within_m);
                least_m(pieces, ground, || placed.bounds(), gap_m)
            }
            SurfaceShape::Shape(body_from_shape, shape) => {
                ground.distance_m(&(floor_from_body * body_from_shape), shape)
            }
        }
    }
}

/// Distance of a roller from pieces of ground, and from its uneven part, in metres.
fn least_m(
    pieces: &[Piece],
    ground: &Ground,
    bounds: impl FnOnce() -> Bounds,
    gap_m: impl Fn(&Piece, f64) -> f64,
) -> f64 {
    let from_pieces_m = pieces.iter().fold(f64::INFINITY, |least_m, piece| {
        least_m.min(gap_m(piece, least_m))
    });
    let Some(relief) = ground.relief() else {
        return from_pieces_m;
    };
    let from_relief_m = relief.gap_m(&bounds(), |triangle, within_m| {
        gap_m(&Piece::Triangle(*triangle), within_m)
    });
    from_pieces_m.min(from_relief_m)
}
