//! Places a robot at the start of a world: on whatever is beneath it, in its stance on a plane,
//! with its lowest wheel just touching.

use ilon_robot::{Pose as PlanarPose, Robot};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::contact::search::bounds::Bounds;
use crate::contact::search::free_bodies::parts;
use crate::contact::search::nearest::{Piece, PlacedBarrel};
use crate::contact::search::solid::Solid;
use crate::contact::search::turned_profile::PlacedProfile;
use crate::engine::convert;
use crate::ground::{Ground, HeightField};
use crate::robot::articulated::Articulated;
use crate::{Floor, WorldError};

/// Distance from contact at which a robot or a body is put down, in metres. Chosen.
const PUT_DOWN_M: f64 = 1e-9;
/// The smallest step of lowering it, in metres: beside a wall everything is near all the way down.
/// Chosen.
const LEAST_LOWERED_M: f64 = 1e-5;

/// The steps of lowering by the distance to whatever is nearest, after which the height is bisected
/// instead, and the most of all. Most stand long before; beside a high wall, or on steep uneven
/// ground, it would take for ever. Chosen.
const MOST_LOWERED: [usize; 2] = [200, 500];

/// At a smaller distance the chassis lies on the ground, in metres. Chosen.
const LIES_M: f64 = 1e-6;

/// A surface of the robot that may touch the ground, in the pose that it has on a plane.
struct Surface<'a> {
    /// The wheel that it belongs to; `None` for the chassis.
    wheel: Option<usize>,
    form: SurfaceForm<'a>,
}

enum SurfaceForm<'a> {
    Barrel(PlacedBarrel<'a>),
    Turned(PlacedProfile<'a>),
    Shape(Solid<'a>),
}

/// The pose of a robot's body in the floor's frame when it stands on a plane at a planar pose.
/// Wheels of unequal radius or height tilt it. A robot that cannot stand is put down upright, and
/// falls over.
pub(super) fn on_plane(robot: &Robot, start: PlanarPose) -> Isometry3<f64> {
    let (height_m, leaning) = match robot.standing_pose() {
        Some(stands) => (stands.height_m, stands.rotation()),
        None => (robot.ride_height_m(), UnitQuaternion::identity()),
    };
    let place_m = Vector3::new(start.x_m, start.y_m, height_m);
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), start.heading_rad);
    Isometry3::from_parts(Translation3::from(place_m), yaw * leaning)
}

/// The height of a robot at rest over where it would stand on a plane, which is where it is, in
/// metres.
///
/// # Errors
/// [`WorldError::NoPlaceToStand`] if its chassis would lie on something, or one of its wheels would
/// hang over the ground by more than its radius.
pub(super) fn raised_m(
    body: &Articulated,
    floor: &Floor,
    ground: &Ground,
) -> Result<f64, WorldError> {
    if !ground.has_solids() {
        return Ok(0.0);
    }
    let surfaces = surfaces(body);
    let center_m = body.chassis_mass.center_of_mass_m;
    let origin_m = body.state.carrier(None, &center_m).translation.vector;
    let reach_m = |surface: &Surface| {
        let (middle_m, radius_m) = surface.ball_m();
        (middle_m - origin_m).norm() + radius_m
    };
    let reach_m = surfaces.iter().map(reach_m).fold(0.0, f64::max);
    let top_m = floor.highest_m(origin_m.xy(), reach_m);
    let from_m = top_m.max(0.0);
    let around_m = 2.0 * reach_m + origin_m.z + from_m;
    let mut pieces = Vec::new();
    ground.solids_near(&origin_m, around_m, &mut pieces);
    let around = Bounds::of_ball(&origin_m, around_m);
    let relief = ground.relief().filter(|relief| relief.reaches(&around));
    if relief.is_none() && matches!(pieces[..], [] | [Piece::Plane]) {
        return Ok(0.0);
    }
    // There is nothing beneath this.
    let bottom_m = match ground.is_solid_below() {
        true => -reach_m,
        false => relief.map_or(f64::NEG_INFINITY, |relief| {
            relief.lowest_m() - around_m - origin_m.z
        }),
    };
    let near = |surface: &Surface, up_m: f64| surface.gap_m(up_m, &pieces, ground);
    let nearest_m = |up_m: f64| {
        let gaps = surfaces.iter().map(|surface| near(surface, up_m));
        gaps.fold(f64::INFINITY, f64::min)
    };
    // A robot clear at a height is clear above it, too: there is nothing under uneven ground, and a
    // pose there does not count as clear.
    let is_clear = |up_m: f64| {
        let is_over = |relief: &HeightField| {
            let mut middles = surfaces.iter().map(|of| of.ball_m().0);
            middles.all(|middle_m| {
                let ground_m = relief.height_m(&middle_m.xy());
                ground_m.is_none_or(|z| z < middle_m.z + up_m)
            })
        };
        nearest_m(up_m) > 0.0 && relief.is_none_or(is_over)
    };
    let (up_m, _) = lowered_m((from_m, bottom_m), nearest_m, is_clear);
    refuse_what_hangs(&body.robot, &surfaces, |surface| near(surface, up_m))?;
    Ok(up_m)
}

/// Lowers something from where all of it is free, by no more than the distance to whatever is
/// nearest. Returns the lowest height found at which it is free, and the highest below it at which
/// it is not, minus infinity if there is none; in metres. Nothing is beneath `bottom_m`.
pub(super) fn lowered_m(
    (from_m, bottom_m): (f64, f64),
    gap_m: impl Fn(f64) -> f64,
    is_clear: impl Fn(f64) -> bool,
) -> (f64, f64) {
    let [by_gaps, most] = MOST_LOWERED;
    let (mut free_m, mut lower_m) = (from_m, f64::NEG_INFINITY);
    for lowered in 0..most {
        let gap_m = gap_m(free_m);
        if gap_m < PUT_DOWN_M || !gap_m.is_finite() || free_m < bottom_m {
            break;
        }
        if lowered == by_gaps && bottom_m.is_finite() {
            if is_clear(bottom_m) {
                free_m = bottom_m;
                break;
            }
            lower_m = lower_m.max(bottom_m);
        }
        let next_m = match lower_m.is_finite() {
            true => 0.5 * (free_m + lower_m),
            false => free_m - gap_m.max(LEAST_LOWERED_M),
        };
        // Rounding may leave none between.
        if !(lower_m < next_m && next_m < free_m) || free_m - lower_m <= PUT_DOWN_M {
            break;
        }
        if is_clear(next_m) {
            free_m = next_m;
        } else {
            lower_m = next_m;
        }
    }
    (free_m, lower_m)
}

/// Distance of the nearest part of a robot at rest from a plane ground, in metres.
#[cfg(test)]
pub(super) fn clearance_m(body: &Articulated, ground: &Ground) -> f64 {
    let surfaces = surfaces(body);
    let gaps = surfaces
        .iter()
        .map(|surface| surface.gap_m(0.0, &[Piece::Plane], ground));
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

fn surfaces(body: &Articulated) -> Vec<Surface<'_>> {
    let of_chassis = parts(body, &body.state).filter(|(joint, _)| joint.is_none());
    let of_chassis = of_chassis.map(|(_, solid)| Surface {
        wheel: None,
        form: SurfaceForm::Shape(solid),
    });
    let wheels = body.wheels.iter().zip(body.state.hubs()).enumerate();
    let of_wheels = wheels.flat_map(|(index, (wheel, hub))| {
        wheel.rollers.iter().filter_map(move |roller| {
            let form = (roller.placed_barrel(hub).map(SurfaceForm::Barrel))
                .or_else(|| roller.placed_profile(hub).map(SurfaceForm::Turned))
                .or_else(|| roller.placed_shape(hub).map(SurfaceForm::Shape))?;
            let wheel = Some(index);
            Some(Surface { wheel, form })
        })
    });
    of_chassis.chain(of_wheels).collect()
}

impl Surface<'_> {
    /// A ball around it: its middle and its radius, in metres.
    fn ball_m(&self) -> (Vector3<f64>, f64) {
        match &self.form {
            SurfaceForm::Barrel(placed) => (
                placed.center_m,
                PlacedBarrel::bounding_radius_m(placed.barrel),
            ),
            SurfaceForm::Turned(placed) => (placed.center_m, placed.turned.bounding_radius_m()),
            SurfaceForm::Shape(solid) => {
                let pose = convert::pose(&solid.floor_from_shape);
                let ball = solid.shape.compute_bounding_sphere(&pose);
                (convert::to_vector(ball.center), ball.radius)
            }
        }
    }

    /// Its distance from the ground if it is raised by a height, in metres; zero or less if it
    /// touches.
    fn gap_m(&self, up_m: f64, pieces: &[Piece], ground: &Ground) -> f64 {
        let up_m = up_m * Vector3::z();
        match &self.form {
            SurfaceForm::Barrel(placed) => {
                let placed = PlacedBarrel {
                    center_m: placed.center_m + up_m,
                    ..*placed
                };
                let gap_m = |piece: &Piece, within_m: f64| {
                    let nearest = placed.nearest_within(piece, within_m);
                    nearest.map_or(f64::INFINITY, |nearest| nearest.gap_m)
                };
                least_m(pieces, ground, || placed.bounds(), gap_m)
            }
            SurfaceForm::Turned(placed) => {
                let placed = PlacedProfile {
                    center_m: placed.center_m + up_m,
                    ..*placed
                };
                let gap_m = |piece: &Piece, within_m: f64| placed.gap_m(piece, within_m);
                least_m(pieces, ground, || placed.bounds(), gap_m)
            }
            SurfaceForm::Shape(solid) => ground.gap_m(&Solid {
                floor_from_shape: Translation3::from(up_m) * solid.floor_from_shape,
                ..*solid
            }),
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
