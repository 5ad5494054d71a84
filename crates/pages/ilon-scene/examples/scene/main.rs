//! Writes a page with a run in three dimensions, from its trace:
//! `cargo run --release --example scene -- TRACE OUT.html`.

mod page;

use std::error::Error;
use std::path::PathBuf;

use ilon_formats::{LoadRobot, link_tree};
use ilon_robot::Robot;
use ilon_scene::{Description, Scene, Thinning, embed, frames_of_run};
use ilon_trace::Trace;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [trace, out] = arguments.as_slice() else {
        return Err("give a trace, and the page to write".into());
    };
    let run = Trace::read_parquet(trace)?;
    let header = &run.header;
    let robot = Robot::from_urdf_str(&header.urdf, &header.robot_name)?;
    let links = link_tree(&header.urdf);
    let description = Description::of_run(header, &robot, links.as_ref(), None);
    let scene = Scene::new(
        description,
        frames_of_run(&run, &robot, Thinning::default())?,
    );
    let html = page::html(&header.scenario_name, &scene)?;
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
