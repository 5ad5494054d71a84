//! A page with a run in three dimensions, from its trace: `cargo run --release --example scene -- TRACE OUT.html [ROBOT]`.
//!
//! Without ROBOT it is the one that the trace's scenario names, sought beside the trace and in the working folder: go to the scenario's.

mod page;
mod world;

use std::error::Error;
use std::path::{Path, PathBuf};

use ilon_formats::{LoadOptions, LoadRobot};
use ilon_robot::Robot;
use ilon_scene::{Description, Scene, Thinning, embed, frames_of_run};
use ilon_trace::Trace;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let (trace, out, robot) = match arguments.as_slice() {
        [trace, out] => (trace, out, None),
        [trace, out, robot] => (trace, out, Some(robot.clone())),
        _ => {
            return Err(
                "give a trace, the page to write, and the robot's file if it is not found".into(),
            );
        }
    };
    let run = Trace::read_parquet(trace)?;
    let world = world::of_scenario(&run.header.scenario_toml)?;
    let robot = robot.unwrap_or_else(|| beside(trace, &world.robot_file));
    let loaded = Robot::load_with(&robot, &LoadOptions::default())?;
    let mut description =
        Description::of_robot(&loaded.robot, Some(&loaded.urdf), &loaded.visual_meshes());
    (description.floor, description.pushes) = (world.floor, world.pushes);
    let scene = Scene::new(
        description,
        frames_of_run(&run, &loaded.robot, Thinning::default())?,
    );
    let html = page::html(&run.header.scenario_name, &scene)?;
    std::fs::write(out, &html)?;
    let duration_s = run.duration_s();
    println!(
        "{}: {} bytes, of them {} script and {} frames, {:.0} bytes for each second of the run",
        out.display(),
        html.len(),
        embed::script().len(),
        scene.frames.data_bytes(),
        scene.frames.data_bytes() as f64 / duration_s
    );
    Ok(())
}

/// A file that a scenario names: beside the trace, or else as it is.
fn beside(trace: &Path, file: &Path) -> PathBuf {
    let beside = trace.parent().unwrap_or(Path::new("")).join(file);
    if beside.exists() {
        beside
    } else {
        file.to_owned()
    }
}
