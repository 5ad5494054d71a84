//! Arguments of `ilon export`.

use std::path::{Path, PathBuf};

use super::options::{Sandbox, Settings};
use super::robot::Reading;

/// Arguments of `ilon export`.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("what").required(true).multiple(true))]
#[command(group = clap::ArgGroup::new("simulated").multiple(true))]
pub(super) struct Arguments {
    /// The robot's file: URDF, xacro, SDF, MJCF or TOML; for --mjcf, --newton, --sdf, --urdf and --usd-notes.
    pub(super) robot: Option<PathBuf>,
    /// Write the robot with its wheels as made for MuJoCo: native shapes, bearings, motors, solver
    /// settings, and a scene.
    #[arg(long, groups = ["what", "simulated"])]
    pub(super) mjcf: bool,
    /// The same MJCF for Newton, which reads it, with a program that drives it.
    #[arg(long, groups = ["what", "simulated"])]
    pub(super) newton: bool,
    /// The same for Gazebo, with a world.
    #[arg(long, group = "what")]
    pub(super) sdf: bool,
    /// The same as URDF, of spheres, cylinders and meshes.
    #[arg(long, group = "what")]
    pub(super) urdf: bool,
    /// Write the URDF, and notes on shapes and settings for Isaac Sim and other tools of USD.
    #[arg(long, group = "what")]
    pub(super) usd_notes: bool,
    /// Run the exported wheels in MuJoCo or Newton (the Python under ILON_PYTHON, or python3), and
    /// print their speeds beside ilon's.
    #[arg(long, requires = "simulated")]
    pub(super) verify: bool,
    /// Export the robot of a scenario, and its drive: with --verify MuJoCo runs it, and the
    /// difference is split into geometry, softness and step.
    #[arg(long, value_name = "SCENARIO", conflicts_with_all = ["robot", "fmu", "planar"])]
    pub(super) scenario: Option<PathBuf>,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long, conflicts_with_all = ["fmu", "planar"])]
    pub(super) json: bool,
    /// Write robot and world of a scenario as a functional mock-up unit (FMI 3.0, co-simulation).
    #[arg(long, value_name = "SCENARIO", group = "what", conflicts_with_all = ["robot", "planar", "mjcf", "newton", "sdf", "urdf", "usd_notes"])]
    pub(super) fmu: Option<PathBuf>,
    /// Fit a planar base to a robot, with its error on unseen drives; write it as JSON and for
    /// numpy.
    #[arg(long, value_name = "ROBOT", group = "what", conflicts_with_all = ["robot", "mjcf", "newton", "sdf", "urdf", "usd_notes"])]
    pub(super) planar: Option<PathBuf>,
    /// File or folder of the result [default: SCENARIO.fmu, ROBOT_planar, or ROBOT_export].
    #[arg(long, value_name = "PATH")]
    pub(super) out: Option<PathBuf>,
    /// Shared library of ilon-c for the FMU [default: the one that came with this command].
    #[arg(long, value_name = "FILE", conflicts_with_all = ["planar", "mjcf", "newton", "sdf", "urdf", "usd_notes"])]
    pub(super) library: Option<PathBuf>,
    #[command(flatten)]
    pub(super) settings: Settings,
    #[command(flatten)]
    pub(super) reading: Reading,
    #[command(flatten)]
    pub(super) sandbox: Sandbox,
}

/// A path's file name with another extension.
pub(super) fn named_after(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(ending);
    name.into()
}
