//! The scenario's floor as the world's.

use ilon_robot::Robot;
use ilon_trace::{Ground, GroundPatch, GroundRelief};
use ilon_world::{Floor, Footing, GroundBox, Relief};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::surface::Footings;
use super::timed_patch::TimedPatch;
use crate::Error;
use crate::scenario::{Rough, Scenario};

/// The most cells a rough floor may have along a side: 4 million triangles are as many as a machine can be asked for.
const MOST_CELLS: f64 = 500.0;

/// The floor of a scenario under a robot, with the patches that are there when it begins.
///
/// # Errors
/// Where a rough floor has too many cells, or fewer than one, or a pair of materials is not named.
pub(super) fn floor(scenario: &Scenario, robot: &Robot) -> Result<Floor, Error> {
    let section = &scenario.world.floor;
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
    let footings = Footings::new(scenario, robot)?;
    let Footing { friction, surface } = footings.floor()[0];
    Ok(Floor {
        friction,
        slope_rad,
        patches: TimedPatch::those_at(&footings.patches()?, 0.0),
        boxes: boxes.collect(),
        relief: section.rough.as_ref().map(relief).transpose()?,
        surface,
        materials: footings.materials(),
        footings: footings.each_of(footings.floor()),
    })
}

/// The patches of a scenario under a robot.
///
/// # Errors
/// Where a pair of materials is not named.
pub(super) fn patches(scenario: &Scenario, robot: &Robot) -> Result<Vec<TimedPatch>, Error> {
    Footings::new(scenario, robot)?.patches()
}

/// The ground of a scenario under a robot as a trace keeps it.
///
/// # Errors
/// Where a pair of materials is not named.
pub(super) fn ground(scenario: &Scenario, robot: &Robot) -> Result<Ground, Error> {
    let section = &scenario.world.floor;
    let footings = Footings::new(scenario, robot)?;
    Ok(Ground {
        friction: footings.floor()[0].friction,
        slope_rad: section.slope_deg.to_radians(),
        patches: footings
            .patches()?
            .iter()
            .map(|timed| GroundPatch {
                center_m: timed.patch.center_m.into(),
                sides_m: (2.0 * timed.patch.half_sides_m).into(),
                friction: timed.patch.friction,
                from_s: timed.from_s,
                until_s: timed.until_s,
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
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    /// A box of 20 x 40 cm that stands 1 cm high: half of its sides, and as deep in the ground as it is high.
    #[test]
    fn a_box_stands_on_the_ground_as_high_as_it_says() {
        let urdf = include_str!("../../../../assets/robots/mecanum4.urdf");
        let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
        let text = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1.0\n[[world.floor.boxes]]\nx_m = 1.0\ny_m = 0.5\nlength_x_m = 0.2\n\
                    length_y_m = 0.4\nheight_m = 0.01\nheading_deg = 30\n";
        let scenario = Scenario::from_toml(text, "test", "").unwrap();
        let floor = floor(&scenario, &robot).unwrap();
        let solid = &floor.boxes[0];
        assert_eq!(solid.center_m, Vector3::new(1.0, 0.5, 0.0));
        assert_eq!(solid.half_sides_m, Vector3::new(0.1, 0.2, 0.01));
        assert_eq!(solid.heading_rad, 30.0_f64.to_radians());
    }
}
