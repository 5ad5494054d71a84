//! `ilon inspect --pathplanner`, `--choreo`, `--road-runner` and `--pedro`: a robot for the
//! planners of robot contests.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_formats::Loaded;
use ilon_trace::file::write_text;

use super::failure::Failure;
use super::limits;
use super::reserve;
use crate::inspect::Inspection;
use crate::planners::{self, Swerve};
use crate::ros2_control::DriveParameters;

/// Which files for planners are asked for. Each asks for `--limits`, too
/// ([`limits::Asked::limits`]).
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Planners")]
pub(super) struct Exports {
    /// Write PathPlanner's `settings.json`: a swerve drive with this robot's limits.
    #[arg(long, value_name = "FILE")]
    pathplanner: Option<PathBuf>,
    /// Write a project of Choreo (`.chor`): a swerve drive with this robot's limits.
    #[arg(long, value_name = "FILE")]
    choreo: Option<PathBuf>,
    /// Write feedforward and limits for Road Runner's mecanum drive, as Java; needs `--set
    /// motors.dc...`.
    #[arg(long, value_name = "FILE")]
    road_runner: Option<PathBuf>,
    /// Write Pedro Pathing's constants of a mecanum drive, as Java; needs `--set motors.dc...`.
    #[arg(long, value_name = "FILE")]
    pedro: Option<PathBuf>,
}

impl Exports {
    /// The files, with the flags that name them.
    pub fn files(&self) -> [(&Option<PathBuf>, &'static str); 4] {
        [
            (&self.pathplanner, "--pathplanner"),
            (&self.choreo, "--choreo"),
            (&self.road_runner, "--road-runner"),
            (&self.pedro, "--pedro"),
        ]
    }

    /// Reserves the files.
    pub fn claim(&self, robot: &Path) -> Result<Vec<reserve::ReservedOutput>, Failure> {
        let asked = self.files().into_iter();
        let named = asked.filter_map(|(path, flag)| Some((path.as_ref()?, flag)));
        named
            .map(|(path, flag)| reserve::file(path, flag, &[robot.to_path_buf()]))
            .collect()
    }

    /// Whether files for swerve drives, and whether files for mecanum drives are requested.
    pub fn are_asked(&self) -> (bool, bool) {
        let is_swerve = self.pathplanner.is_some() || self.choreo.is_some();
        (
            is_swerve,
            self.road_runner.is_some() || self.pedro.is_some(),
        )
    }

    fn write_swerve(&self, swerve: Result<Swerve, planners::NoSwerve>) -> Result<(), Failure> {
        let swerve = swerve.map_err(|fault| {
            Failure::usage(fault.to_string(), "leave --pathplanner and --choreo out")
        })?;
        for (path, text) in [
            (&self.pathplanner, planners::pathplanner(&swerve)),
            (&self.choreo, planners::choreo(&swerve)),
        ] {
            if let Some(path) = path {
                write_text(path, &text)?;
            }
        }
        Ok(())
    }

    /// Writes the requested files.
    pub fn write(
        &self,
        loaded: &Loaded,
        inspection: &Inspection,
        conditions: &limits::Asked,
        files: &FileAccess,
    ) -> Result<(), Failure> {
        let (is_swerve, is_mecanum) = self.are_asked();
        if !(is_swerve || is_mecanum) {
            return Ok(());
        }
        let (scenario, robot) = conditions.conditions(&loaded.robot, files)?;
        if robot.wheels.iter().any(ilon_robot::Wheel::has_tyre) {
            if is_mecanum {
                return Err(Failure::usage(
                    "--road-runner and --pedro are for four equal mecanum wheels, and this robot rolls on tyres",
                    "leave them out; --pathplanner and --choreo take robots whose tyres are all steered",
                ));
            }
            return self.write_swerve(Swerve::of_modules(&robot, &scenario));
        }
        let Some(limits) = &inspection.limits else {
            return Ok(());
        };
        if is_swerve {
            self.write_swerve(Swerve::of(&robot, limits))?;
        }
        for (path, flag) in [
            (&self.road_runner, "--road-runner"),
            (&self.pedro, "--pedro"),
        ] {
            let Some(path) = path else { continue };
            limits::must_give(limits, flag)?;
            let dc = scenario.motors.dc.as_ref().ok_or_else(|| {
                Failure::usage(
                    format!("{flag} needs to know the motors"),
                    "add `--set motors.dc.stall_torque_n_m=...` and `--set motors.dc.no_load_rate_rad_s=...`, both at the wheel on 12 V",
                )
            })?;
            let not_mecanum = || {
                Failure::usage(
                    format!("{flag} is for four equal mecanum wheels, which this robot has not"),
                    format!("leave {flag} out"),
                )
            };
            let drive = DriveParameters::of(&robot)?.map_err(|_| not_mecanum())?;
            let under = (dc, &scenario.world);
            let measured = conditions.sideways_over_ahead(files)?;
            let text = match flag {
                "--pedro" => planners::pedro(&robot, &drive, under, measured)?,
                _ => planners::road_runner(&robot, &drive, under, limits, measured)?,
            };
            write_text(path, &text.ok_or_else(not_mecanum)?)?;
        }
        Ok(())
    }
}
