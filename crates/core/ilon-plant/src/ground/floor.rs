//! Converts the scenario's floor for the world.

use ilon_robot::Robot;
use ilon_trace::{Ground, GroundPatch, GroundRamp, GroundRelief};
use ilon_world::{ContactSurface, Floor, GroundBox, Patch, Relief};
use nalgebra::{Vector2, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::ground::roughness;
use crate::ground::surface::ContactSurfaces;
use crate::timed::Timed;
use ilon_scenario::Error;
use ilon_scenario::height_map;
use ilon_scenario::scenario::{
    self, FloorPatch, FloorRamp, FloorStairs, Rough, RoughnessClass, Scenario,
};

/// The most cells of a rough floor per side: the resulting 4 million triangles still fit a usual
/// machine. Chosen.
const MOST_CELLS: f64 = 500.0;

/// The floor of a scenario under a robot, with the patches present at the start, and with the
/// result of [`uneven`] instead of its plane.
///
/// # Errors
/// If a pair of materials is undefined.
pub(crate) fn floor(
    scenario: &Scenario,
    robot: &Robot,
    uneven: Option<&GroundRelief>,
) -> Result<Floor, Error> {
    let section = &scenario.world.floor;
    let slope_rad = section.slope_deg.to_radians();
    let boxes = upright(section).map(|solid| GroundBox {
        center_m: Vector3::new(solid.center_m[0], solid.center_m[1], 0.0),
        // The box extends into the ground by its own height.
        half_sides_m: Vector3::new(
            0.5 * solid.sides_m[0],
            0.5 * solid.sides_m[1],
            solid.sides_m[2],
        ),
        heading_rad: solid.heading_rad,
        pitch_rad: 0.0,
    });
    let ramps = section.ramps.iter().map(|one| {
        let ramp = ramp(one);
        GroundBox {
            center_m: ramp.center_m.into(),
            half_sides_m: 0.5 * Vector3::from(ramp.sides_m),
            heading_rad: ramp.heading_rad,
            pitch_rad: ramp.pitch_rad,
        }
    });
    let footings = ContactSurfaces::new(scenario, robot)?;
    let of_floor = footings.floor();
    let ContactSurface { friction, surface } = of_floor[0];
    Ok(Floor {
        friction,
        slope_rad,
        patches: Timed::those_at(&footings.patches()?, 0.0),
        boxes: boxes.chain(ramps).collect(),
        relief: uneven.map(relief),
        surface,
        materials: footings.materials(),
        footings: footings.each_of(of_floor),
    })
}

/// The patches of a scenario under a robot.
///
/// # Errors
/// If a pair of materials is undefined.
pub(crate) fn patches(scenario: &Scenario, robot: &Robot) -> Result<Vec<Timed<Patch>>, Error> {
    ContactSurfaces::new(scenario, robot)?.patches()
}

/// Describes what a patch sets besides its friction.
fn changes(patch: &FloorPatch) -> Vec<String> {
    let number = |name: &str, value: Option<f64>| value.map(|value| format!("{name} {value}"));
    let changed = [
        patch
            .material
            .as_ref()
            .map(|name| format!("material `{name}`")),
        number("rolling resistance", patch.rolling_resistance),
        number("radius exponent", patch.radius_exponent),
        number("creep", patch.creep),
        patch
            .sliding
            .map(|_| "friction that falls as a roller slides".to_owned()),
        (patch.across.is_some() || patch.against.is_some() || patch.nap_deg.is_some())
            .then(|| "another nap".to_owned()),
    ];
    changed.into_iter().flatten().collect()
}

/// The ground of a scenario under a robot as stored in a trace, with the result of [`uneven`].
///
/// # Errors
/// Those of [`floor`].
pub(crate) fn ground(
    scenario: &Scenario,
    robot: &Robot,
    uneven: Option<&GroundRelief>,
) -> Result<Ground, Error> {
    let section = &scenario.world.floor;
    let footings = ContactSurfaces::new(scenario, robot)?;
    Ok(Ground {
        friction: footings.floor()[0].friction,
        slope_rad: section.slope_deg.to_radians(),
        patches: footings
            .patches()?
            .iter()
            .zip(&section.patches)
            .map(|(timed, patch)| GroundPatch {
                center_m: timed.of.center_m.into(),
                sides_m: (2.0 * timed.of.half_sides_m).into(),
                friction: timed.of.friction,
                changes: changes(patch),
                from_s: timed.from_s,
                until_s: timed.until_s,
            })
            .collect(),
        boxes: upright(section).collect(),
        ramps: section.ramps.iter().map(ramp).collect(),
        relief: uneven.cloned(),
    })
}

/// The upright boxes of a floor, including those of stairs.
fn upright(section: &scenario::Floor) -> impl Iterator<Item = ilon_trace::GroundBox> + '_ {
    let boxes = section.boxes.iter().map(|solid| ilon_trace::GroundBox {
        center_m: [solid.x_m, solid.y_m],
        sides_m: [solid.length_x_m, solid.length_y_m, solid.height_m],
        heading_rad: solid.heading_deg.to_radians(),
    });
    boxes.chain(section.stairs.iter().flat_map(steps))
}

/// A box for each step of stairs, which extends under all higher ones.
fn steps(stairs: &FloorStairs) -> impl Iterator<Item = ilon_trace::GroundBox> + '_ {
    let heading_rad = stairs.heading_deg.to_radians();
    let (sin, cos) = libm::sincos(heading_rad);
    (0..stairs.steps).map(move |step| {
        let from_m = f64::from(step) * stairs.run_m;
        let long_m = f64::from(stairs.steps - step) * stairs.run_m;
        let middle_m = from_m + 0.5 * long_m;
        ilon_trace::GroundBox {
            center_m: [stairs.x_m + cos * middle_m, stairs.y_m + sin * middle_m],
            sides_m: [long_m, stairs.width_m, f64::from(step + 1) * stairs.rise_m],
            heading_rad,
        }
    })
}

/// A tilted box, deep enough to fill the ground under the ramp.
fn ramp(ramp: &FloorRamp) -> GroundRamp {
    let heading_rad = ramp.heading_deg.to_radians();
    let (sin, cos) = libm::sincos(heading_rad);
    let up_m = libm::hypot(ramp.length_m, ramp.rise_m);
    let (rises, runs) = (ramp.rise_m / up_m, ramp.length_m / up_m);
    // From the middle of its upper side to its centre, perpendicular to that side.
    let down_m = ramp.rise_m;
    let along_m = 0.5 * ramp.length_m + rises * down_m;
    GroundRamp {
        center_m: [
            ramp.x_m + cos * along_m,
            ramp.y_m + sin * along_m,
            0.5 * ramp.rise_m - runs * down_m,
        ],
        sides_m: [up_m, ramp.width_m, 2.0 * down_m],
        heading_rad,
        pitch_rad: -libm::atan2(ramp.rise_m, ramp.length_m),
    }
}

/// The heights of uneven ground in metres, row by row: of a map, of a roughness class about their
/// mean, or above the lowest possible point.
pub fn relief_heights_m(relief: &GroundRelief) -> Vec<Vec<f64>> {
    if let Some(map) = &relief.map {
        return height_map::heights_m(map, relief.points);
    }
    if let Some(density_m3) = relief.roughness_m3 {
        return roughness::heights_m(relief.points, relief.cell_m, density_m3, relief.seed);
    }
    let mut rng = ChaCha8Rng::seed_from_u64(relief.seed);
    let mut height_m = || relief.height_m * f64::from(rng.next_u32()) / f64::from(u32::MAX);
    (0..relief.points)
        .map(|_| (0..relief.points).map(|_| height_m()).collect())
        .collect()
}

/// The uneven ground that replaces the plane, if there is any, and warnings. It reads the file of a
/// height map, so call it only once.
///
/// # Errors
/// If a rough floor has too many cells, or none, or a height map cannot be read.
pub(crate) fn uneven(
    scenario: &Scenario,
    robot: &Robot,
) -> Result<(Option<GroundRelief>, Vec<String>), Error> {
    let section = &scenario.world.floor;
    if let Some(rough) = &section.rough {
        return Ok((Some(drawn(rough)?), Vec::new()));
    }
    let Some(map) = &section.height_map else {
        return Ok((None, Vec::new()));
    };
    let radii = robot.wheels.iter().map(|wheel| wheel.radius_m);
    let radius_m = radii.fold(f64::INFINITY, f64::min);
    let (relief, remarks) = height_map::relief(map, scenario, radius_m)?;
    Ok((Some(relief), remarks))
}

fn relief(ground: &GroundRelief) -> Relief {
    let center_m = ground.map.as_ref().map_or([0.0; 2], |map| map.center_m);
    Relief {
        cell_m: ground.cell_m,
        center_m: Vector2::from(center_m),
        heights_m: relief_heights_m(ground),
    }
}

/// The parameters of random uneven ground.
fn drawn(rough: &Rough) -> Result<GroundRelief, Error> {
    if rough.height_m.is_some() == rough.iso_8608.is_some() {
        return Err(Error::invalid(
            "`world.floor.rough` needs exactly one of `height_m` and `iso_8608`",
            "give one of them: the height of independent random cells, or a class from \"A\" to \"H\"",
        ));
    }
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
    Ok(GroundRelief {
        cell_m: rough.cell_m,
        points: cells as usize + 1,
        seed: rough.seed,
        height_m: rough.height_m.unwrap_or_default(),
        roughness_m3: rough.iso_8608.map(RoughnessClass::density_m3),
        map: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    /// A box of 20 x 40 cm with a height of 1 cm: half of its sides, and as deep in the ground as
    /// it is high.
    #[test]
    fn a_box_stands_on_the_ground_as_high_as_it_says() {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
        let text = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1.0\n[[world.floor.boxes]]\nx_m = 1.0\ny_m = 0.5\nlength_x_m = 0.2\n\
                    length_y_m = 0.4\nheight_m = 0.01\nheading_deg = 30\n";
        let scenario = Scenario::from_toml(text, "test", "").unwrap();
        let floor = floor(&scenario, &robot, None).unwrap();
        let solid = &floor.boxes[0];
        assert_eq!(solid.center_m, Vector3::new(1.0, 0.5, 0.0));
        assert_eq!(solid.half_sides_m, Vector3::new(0.1, 0.2, 0.01));
        assert_eq!(solid.heading_rad, 30.0_f64.to_radians());
    }

    fn floor_of(keys: &str) -> Result<Floor, Error> {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
        let text = format!("robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\n{keys}");
        let scenario = Scenario::from_toml(&text, "test", "")?;
        let (uneven, _) = uneven(&scenario, &robot)?;
        floor(&scenario, &robot, uneven.as_ref())
    }

    /// The middle of the foot, and of the upper edge: corners of the upper side of a tilted box.
    #[test]
    fn a_ramp_leads_from_its_foot_to_its_height() {
        let keys = "[[world.floor.ramps]]\nx_m = 1\ny_m = 2\nheading_deg = 90\nlength_m = 0.8\nwidth_m = 0.5\nrise_m = 0.1\n";
        let floor = floor_of(keys).unwrap();
        let ramp = &floor.boxes[0];
        let heading =
            nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), ramp.heading_rad);
        let pitch = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::y_axis(), ramp.pitch_rad);
        let at = |x: f64| {
            let h = ramp.half_sides_m;
            ramp.center_m + heading * (pitch * Vector3::new(x * h.x, 0.0, h.z))
        };
        assert!((at(-1.0) - Vector3::new(1.0, 2.0, 0.0)).norm() < 1e-12);
        assert!((at(1.0) - Vector3::new(1.0, 2.8, 0.1)).norm() < 1e-12);
        assert_eq!(ramp.half_sides_m.y, 0.25);
    }

    /// Three steps of 0.3 m by 0.02 m: each box begins at its step's edge, ends with the stairs,
    /// and is as high as its step.
    #[test]
    fn stairs_are_a_box_for_each_step() {
        let keys = "[[world.floor.stairs]]\nx_m = 1\ny_m = 0\nsteps = 3\nrise_m = 0.02\nrun_m = 0.3\nwidth_m = 1\n";
        let floor = floor_of(keys).unwrap();
        for (step, solid) in floor.boxes.iter().enumerate() {
            let (from_m, to_m) = (1.0 + 0.3 * step as f64, 1.9);
            assert!((solid.center_m.x - solid.half_sides_m.x - from_m).abs() < 1e-12);
            assert!((solid.center_m.x + solid.half_sides_m.x - to_m).abs() < 1e-12);
            assert!((solid.half_sides_m.z - 0.02 * (step + 1) as f64).abs() < 1e-12);
        }
        assert_eq!(floor.boxes.len(), 3);
    }

    #[test]
    fn uneven_ground_that_cannot_be_is_refused_in_words() {
        let refused = |keys: &str| floor_of(keys).unwrap_err().to_string();
        let rough = "[world.floor.rough]\ncell_m = 0.02\nside_m = 2\n";
        assert!(refused(rough).contains("exactly one"));
        let both = format!("{rough}height_m = 0.01\niso_8608 = 'B'\n");
        assert!(refused(&both).contains("exactly one"));
        let unknown = refused(&format!("{rough}iso_8608 = 'K'\n"));
        assert!(unknown.contains("K"), "{unknown}");
        for steps in ["0", "101", "-1", "1e9"] {
            let stairs = format!(
                "[[world.floor.stairs]]\nx_m = 1\ny_m = 0\nsteps = {steps}\nrise_m = 0.02\nrun_m = 0.3\nwidth_m = 1\n"
            );
            assert!(refused(&stairs).contains("steps"), "{}", refused(&stairs));
        }
        for length in ["0", "-1", "nan", "inf"] {
            let ramp = format!(
                "[[world.floor.ramps]]\nx_m = 1\ny_m = 2\nlength_m = {length}\nwidth_m = 0.5\nrise_m = 0.1\n"
            );
            assert!(refused(&ramp).contains("length_m"), "{}", refused(&ramp));
        }
    }
}
