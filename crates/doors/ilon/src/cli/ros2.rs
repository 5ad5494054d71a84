//! `ilon inspect --ros2-controllers` and `--ros2-control`: files for ros2_control.

use std::path::Path;

use ilon_formats::{Loaded, describe, with_ros2_control};
use ilon_trace::file::write_text;

use crate::cli::failure::Failure;
use crate::cli::limits::must_give;
use crate::ros2_control::{DriveParameters, TyreDrive, yaml, yaml_on_tyres};
use crate::simulate::Limits;

/// Writes the requested files. A robot that no controller can drive is refused before anything is
/// written.
pub(super) fn write(
    loaded: &Loaded,
    limits: Option<&Limits>,
    controllers: Option<&Path>,
    control: Option<&Path>,
) -> Result<(), Failure> {
    let robot = &loaded.robot;
    let on_tyres = robot.wheels.iter().any(ilon_robot::Wheel::has_tyre);
    if let Some(path) = controllers.filter(|_| on_tyres) {
        let drive = TyreDrive::of(robot).map_err(|why| {
            Failure::usage(
                format!("no controller of ros2_controllers can drive this robot: {why}"),
                "command its joints each by itself, as a forward_command_controller does; `--ros2-control` writes the block for them",
            )
        })?;
        write_text(path, &yaml_on_tyres(robot, &drive))?;
    } else if let Some(path) = controllers {
        let drive = DriveParameters::of(robot)?.map_err(|unsuitable| {
            Failure::usage(
                unsuitable.to_string(),
                "command its wheels each by itself, as a forward_command_controller does; `--ros2-control` writes the block for them",
            )
        })?;
        if let Some(limits) = limits {
            must_give(limits, "--limits")?;
        }
        write_text(path, &yaml(robot, &drive, limits))?;
    }
    if let Some(path) = control {
        let urdf = describe(robot, &loaded.urdf).urdf;
        let whole = with_ros2_control(robot, &urdf)
            .ok_or_else(|| Failure::encode("the URDF", &"it has no end"))?;
        write_text(path, &whole)?;
    }
    Ok(())
}
