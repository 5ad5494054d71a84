//! The scenario's floor as the world's.

use ilon_trace::{Ground, GroundPatch, GroundRelief};
use ilon_world::{Floor, FloorSurface, GroundBox, Patch, Relief, Stribeck};
use nalgebra::{Vector2, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::Error;
use crate::scenario::{self, FloorPatch, Rough, Sliding};

/// The most cells a rough floor may have along a side: 4 million triangles are as many as a machine can be asked for.
const MOST_CELLS: f64 = 500.0;

/// The floor of a scenario.
///
/// # Errors
/// Where a rough floor has too many cells, or fewer than one.
pub(super) fn floor(section: &scenario::Floor) -> Result<Floor, Error> {
    let slope_rad = section.slope_deg.to_radians();
    // A box is as deep in the ground as it is high above it.
    let boxes = section.boxes.iter().map(|solid| GroundBox {
        center_m: Vector3::new(solid.x_m, solid.y_m, 0.0),
        half_sides_m: Vector3::new(
            0.5 * solid.length_x_m,
            0.5 * solid.length_y_m,
            solid.height_m,
        ),
        heading_rad: solid.heading_deg.to_radians(),
    });
    Ok(Floor {
        friction: section.friction,
        slope_rad,
        patches: patches(section, 0.0).collect(),
        boxes: boxes.collect(),
        relief: section.rough.as_ref().map(relief).transpose()?,
        surface: surface(section),
    })
}

/// What the floor is made of where there is no patch.
fn surface(section: &scenario::Floor) -> FloorSurface {
    FloorSurface {
        rolling_resistance: section.rolling_resistance,
        creep: section.creep,
        sliding: section.sliding.as_ref().map(stribeck),
    }
}

fn stribeck(sliding: &Sliding) -> Stribeck {
    Stribeck {
        friction: sliding.friction,
        speed_m_s: sliding.speed_m_s,
    }
}

/// The patches that are there at a time in seconds.
pub(super) fn patches(section: &scenario::Floor, t_s: f64) -> impl Iterator<Item = Patch> {
    let floor = surface(section);
    let there = move |patch: &&FloorPatch| scenario::within(t_s, patch.from_s, patch.until_s);
    section
        .patches
        .iter()
        .filter(there)
        .map(move |patch| Patch {
            center_m: Vector2::new(patch.x_m, patch.y_m),
            half_sides_m: 0.5 * Vector2::new(patch.length_x_m, patch.length_y_m),
            friction: patch.friction,
            surface: FloorSurface {
                rolling_resistance: patch.rolling_resistance.unwrap_or(floor.rolling_resistance),
                creep: patch.creep.unwrap_or(floor.creep),
                sliding: patch.sliding.as_ref().map(stribeck).or(floor.sliding),
            },
        })
}

/// The ground of a scenario as a trace keeps it.
pub(super) fn ground(section: &scenario::Floor) -> Ground {
    Ground {
        friction: section.friction,
        slope_rad: section.slope_deg.to_radians(),
        patches: section
            .patches
            .iter()
            .map(|patch| GroundPatch {
                center_m: [patch.x_m, patch.y_m],
                sides_m: [patch.length_x_m, patch.length_y_m],
                friction: patch.friction,
                from_s: patch.from_s,
                until_s: patch.until_s,
            })
            .collect(),
        boxes: section
            .boxes
            .iter()
            .map(|solid| ilon_trace::GroundBox {
                center_m: [solid.x_m, solid.y_m],
                sides_m: [solid.length_x_m, solid.length_y_m, solid.height_m],
                heading_rad: solid.heading_deg.to_radians(),
            })
            .collect(),
        relief: section.rough.as_ref().map(|rough| GroundRelief {
            cell_m: rough.cell_m,
            points: (rough.side_m / rough.cell_m).round() as usize + 1,
            seed: rough.seed,
            height_m: rough.height_m,
        }),
    }
}

/// The heights of a bumpy ground above its lowest possible point, in metres: rows along x, points of a row along y.
pub fn relief_heights_m(relief: &GroundRelief) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(relief.seed);
    let mut height_m = || relief.height_m * f64::from(rng.next_u32()) / f64::from(u32::MAX);
    (0..relief.points)
        .map(|_| (0..relief.points).map(|_| height_m()).collect())
        .collect()
}

fn relief(rough: &Rough) -> Result<Relief, Error> {
    let cells = (rough.side_m / rough.cell_m).round();
    if !(1.0..=MOST_CELLS).contains(&cells) {
        return Err(Error::invalid(
            format!(
                "world.floor.rough has {cells:.0} cells along a side: its side of {} m holds cells of {} m",
                rough.side_m, rough.cell_m
            ),
            format!("choose `cell_m` and `side_m` such that there are 1 to {MOST_CELLS} cells"),
        ));
    }
    Ok(Relief {
        cell_m: rough.cell_m,
        heights_m: relief_heights_m(&GroundRelief {
            cell_m: rough.cell_m,
            points: cells as usize + 1,
            seed: rough.seed,
            height_m: rough.height_m,
        }),
    })
}
