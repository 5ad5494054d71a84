//! The world of a scenario, as far as the scene draws it, from the text that a trace carries.

use std::path::PathBuf;

use ilon_scene::{Floor, FrictionChange, GroundBox, Patch, Push};
use serde::Deserialize;

/// What a scenario says of robot and world.
pub struct World {
    /// The robot's file.
    pub robot_file: PathBuf,
    /// The ground, without the bumps of a rough one.
    pub floor: Floor,
    /// Pushes on the chassis.
    pub pushes: Vec<Push>,
}

#[derive(Deserialize)]
struct Scenario {
    robot: RobotSection,
    #[serde(default)]
    world: WorldSection,
    #[serde(default)]
    faults: Vec<FaultSection>,
}

#[derive(Deserialize)]
struct RobotSection {
    #[serde(default)]
    file: PathBuf,
}

#[derive(Default, Deserialize)]
struct WorldSection {
    #[serde(default)]
    floor: FloorSection,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct FloorSection {
    friction: f32,
    slope_deg: f32,
    patches: Vec<PatchSection>,
    boxes: Vec<BoxSection>,
}

#[derive(Deserialize)]
struct PatchSection {
    x_m: f32,
    y_m: f32,
    length_x_m: f32,
    length_y_m: f32,
    friction: f32,
    #[serde(default)]
    from_s: f32,
    until_s: Option<f32>,
}

#[derive(Deserialize)]
struct BoxSection {
    x_m: f32,
    y_m: f32,
    #[serde(default)]
    heading_deg: f32,
    length_x_m: f32,
    length_y_m: f32,
    height_m: f32,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
struct FaultSection {
    push: Option<PushSection>,
    friction_changed: Option<FrictionChange>,
}

#[derive(Deserialize)]
struct PushSection {
    impulse_x_n_s: f32,
    impulse_y_n_s: f32,
    impulse_z_n_s: f32,
    frame: String,
    x_m: Option<f32>,
    y_m: Option<f32>,
    z_m: Option<f32>,
    from_s: f32,
    lasts_s: f32,
}

/// Reads it from a scenario with all its defaults written out.
pub fn of_scenario(text: &str) -> Result<World, toml::de::Error> {
    let scenario: Scenario = toml::from_str(text)?;
    let floor = scenario.world.floor;
    let changes = scenario.faults.iter().filter_map(|f| f.friction_changed);
    let patches = floor.patches.iter().map(|p| Patch {
        center_m: [p.x_m, p.y_m],
        half_sides_m: [0.5 * p.length_x_m, 0.5 * p.length_y_m],
        friction: p.friction,
        from_s: p.from_s,
        until_s: p.until_s,
    });
    let boxes = floor.boxes.iter().map(|b| GroundBox {
        center_m: [b.x_m, b.y_m, 0.5 * b.height_m],
        half_sides_m: [b.length_x_m, b.length_y_m, b.height_m].map(|side| 0.5 * side),
        heading_rad: b.heading_deg.to_radians(),
        pitch_rad: 0.0,
    });
    let pushes = scenario.faults.iter().filter_map(|f| f.push.as_ref());
    let at = |place: Option<f32>| place.unwrap_or(0.0);
    Ok(World {
        robot_file: scenario.robot.file,
        floor: Floor {
            friction: floor.friction,
            slope_rad: floor.slope_deg.to_radians(),
            patches: patches.collect(),
            boxes: boxes.collect(),
            relief: None,
            changes: changes.collect(),
        },
        pushes: pushes
            .map(|p| Push {
                impulse_n_s: [p.impulse_x_n_s, p.impulse_y_n_s, p.impulse_z_n_s],
                in_body: p.frame == "body",
                point_m: [at(p.x_m), at(p.y_m), at(p.z_m)],
                from_s: p.from_s,
                until_s: p.from_s + p.lasts_s,
            })
            .collect(),
    })
}
