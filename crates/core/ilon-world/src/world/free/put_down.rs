//! Places a free body at its start: at its given height, if it is free there, or put down on
//! whatever is beneath it.

use nalgebra::Vector3;

use crate::WorldError;
use crate::contact::search::bounds::Bounds;
use crate::contact::search::free_bodies::solids;
use crate::contact::search::nearest::Piece;
use crate::contact::search::solid::Solid;
use crate::free::FreeBody;
use crate::robot::articulated::Articulated;
use crate::world::World;
use crate::world::free::islands::{bounds, bounds_of_parts};
use crate::world::standing::lowered_m;

/// A body nearer to what is beneath it than this lies on it, in metres. Chosen.
const NEAR_M: f64 = 1e-4;
/// The largest overlap of a body at its start, in its unit of length: the rounding of heights.
/// Chosen.
const ROUNDED: f64 = 1e-3;

/// The obstacle in which a body would start.
enum Obstacle<'a> {
    Ground,
    Robot,
    Body(&'a str),
}

impl World {
    /// The start of the centre of a body, in metres, which was built elsewhere.
    pub(super) fn put_down(
        &self,
        body: &FreeBody,
        built: &Articulated,
    ) -> Result<Vector3<f64>, WorldError> {
        let at = |height_m: f64| Vector3::new(body.place_m.x, body.place_m.y, height_m);
        let near = self.over_or_under(&self.bounds_at(built, at(0.0)));
        let height_m = match body.height_m {
            Some(height_m) => height_m,
            None => self.lowered_m((built, &near), at),
        };
        let (gap_m, obstacle) = self.nearest((built, &near), at(height_m));
        if gap_m >= -ROUNDED * built.scale.length_m {
            return Ok(at(height_m));
        }
        let what = match obstacle {
            Obstacle::Ground => "the ground".to_owned(),
            Obstacle::Robot => "the robot".to_owned(),
            Obstacle::Body(name) => format!("body `{name}`"),
        };
        Err(WorldError::FreeBody {
            name: body.name.clone(),
            reason: format!(
                "it would begin {:.1} mm deep in {what}; move it, or leave out its height to put it down on what is below",
                -1e3 * gap_m
            ),
        })
    }

    /// What a body with these bounds may meet at any height: robots and free bodies.
    fn over_or_under(&self, own: &Bounds) -> Vec<&Articulated> {
        let column = column(own).grown(NEAR_M);
        let all = self.bodies.iter().chain(self.islands.bodies());
        all.filter(|body| bounds(body).meets(&column)).collect()
    }

    /// The height at which a body touches what is beneath it, given the others near it.
    fn lowered_m(
        &self,
        (built, others): (&Articulated, &[&Articulated]),
        at: impl Fn(f64) -> Vector3<f64>,
    ) -> f64 {
        let own = self.bounds_at(built, at(0.0));
        let beneath = self.tops_m(&own, others).fold(0.0, f64::max);
        let from_m = beneath - own.least_m.z + NEAR_M;
        let gap_m = |height_m: f64| self.nearest((built, others), at(height_m)).0;
        let is_clear = |height_m: f64| gap_m(height_m) > 0.0;
        let (free_m, lower_m) = lowered_m((from_m, f64::NEG_INFINITY), gap_m, is_clear);
        // Without anything beneath it, it falls.
        let lies = lower_m.is_finite() || gap_m(free_m) < NEAR_M;
        if lies { free_m } else { from_m }
    }

    fn bounds_at(&self, built: &Articulated, middle_m: Vector3<f64>) -> Bounds {
        solid_at(built, middle_m).map_or(Bounds::NONE, |solid| solid.bounds())
    }

    /// The heights of the ground and others that are over or under bounds, in metres.
    fn tops_m(&self, own: &Bounds, others: &[&Articulated]) -> impl Iterator<Item = f64> {
        let column = column(own);
        let ground = self.ground.solids().map(|solid| solid.bounds());
        let shapes = others.iter().flat_map(|body| bounds_of_parts(body));
        let tops = ground.chain(shapes).filter(move |of| of.meets(&column));
        tops.map(|of| of.most_m.z)
    }

    /// The distance of a body with its centre at a point from the nearest of the ground and of
    /// others, in metres, negative inside; and that obstacle.
    fn nearest<'a>(
        &self,
        (built, others): (&Articulated, &[&'a Articulated]),
        middle_m: Vector3<f64>,
    ) -> (f64, Obstacle<'a>) {
        let mut nearest = (f64::INFINITY, Obstacle::Ground);
        let Some(own) = solid_at(built, middle_m) else {
            return nearest;
        };
        nearest.0 = self.ground.gap_m(&own);
        let (piece, bounds) = (own.piece(), own.bounds());
        for body in others {
            let mut least_m = nearest.0;
            for solid in solids(body, &body.state) {
                // Those further away by their bounding boxes are skipped.
                if solid.bounds().apart_m(&bounds) < least_m {
                    least_m = least_m.min(own.gap_m(&solid));
                }
            }
            if let Some(piece) = &piece {
                least_m = least_m.min(rollers_gap_m(body, piece));
            }
            if least_m < nearest.0 {
                let obstacle = match body.free() {
                    Some(free) => Obstacle::Body(&free.name),
                    None => Obstacle::Robot,
                };
                nearest = (least_m, obstacle);
            }
        }
        nearest
    }
}

/// The column over and under bounds.
fn column(own: &Bounds) -> Bounds {
    let mut column = *own;
    (column.least_m.z, column.most_m.z) = (f64::NEG_INFINITY, f64::INFINITY);
    column
}

/// The shape of a free body with its centre at a point.
fn solid_at(built: &Articulated, middle_m: Vector3<f64>) -> Option<Solid<'_>> {
    let mut solid = solids(built, &built.state).next()?;
    solid.floor_from_shape.translation.vector += middle_m - built.state.center_m();
    Some(solid)
}

/// The distance between the rollers of a robot and a piece, in metres.
fn rollers_gap_m(robot: &Articulated, piece: &Piece) -> f64 {
    let hubs = robot.state.hubs().iter().zip(&robot.wheels);
    let barrels = hubs.flat_map(|(hub, wheel)| {
        let rollers = wheel.rollers.iter();
        rollers.filter_map(|roller| roller.placed_barrel(hub))
    });
    let gaps = barrels.map(|placed| placed.nearest_to(piece).gap_m);
    gaps.fold(f64::INFINITY, f64::min)
}
