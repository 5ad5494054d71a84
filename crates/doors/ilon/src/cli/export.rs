//! `ilon export`: a robot for other simulators.

use std::path::{Path, PathBuf};

use ilon_fmi::package::platform;

use super::escape::{one_line, path_in_line};
use super::export_arguments::{Arguments, named_after};
use super::kind::{Kind, wants};
use super::outcome::Outcome;
use super::robot::load;
use super::{console, export_wheels, reserve};
use crate::cli::failure::Failure;
use crate::inspect::conditions;
use crate::planar;

/// Writes the requested files.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    match (&arguments.fmu, &arguments.planar) {
        (Some(scenario), _) => fmu(scenario, arguments),
        (None, Some(robot)) => planar_base(robot, arguments),
        (None, None) => export_wheels::run(arguments),
    }
}

/// Fits a planar base to a robot and writes it into a folder.
fn planar_base(path: &Path, arguments: &Arguments) -> Result<Outcome, Failure> {
    let mut options = arguments.reading.options();
    options.files = arguments.sandbox.files()?;
    wants(path, &[Kind::Robot], &options.files)?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| named_after(path, "_planar"));
    let _claim = reserve::folder(&out, "--out")?;
    let robot = load(path, &options, "ilon export --planar", &arguments.sandbox)?.robot;
    let settings = &arguments.settings.settings;
    let (scenario, robot) = conditions(settings, &robot, &options.files)?;
    let (base, judges, dt_s) = planar::fit(&scenario, &robot)?;
    for (name, text) in planar::files(&base, &judges, dt_s)? {
        ilon_trace::file::write_text(&out.join(name), &text)?;
    }
    let off = &base.held_out;
    console::lines(&format!(
        "a planar base of `{}`: {}\non {} drives of {:.1} s that it has not seen it ends off by {:.2} % of the path, ideal kinematics by {:.2} %\n",
        one_line(&base.robot),
        path_in_line(&out),
        off.drives,
        off.duration_s,
        1e2 * off.model.position_over_path,
        1e2 * off.ideal.position_over_path,
    ))?;
    Ok(Outcome::Done)
}

/// Writes the FMU, after a check that its content can be run.
fn fmu(path: &Path, arguments: &Arguments) -> Result<Outcome, Failure> {
    let files = arguments.sandbox.files()?;
    wants(path, &[Kind::Scenario], &files)?;
    arguments.reading.none_beside(path)?;
    let library = match &arguments.library {
        Some(library) => library.clone(),
        None => of_this_command()?,
    };
    let out = match &arguments.out {
        Some(out) => out.clone(),
        None => named_after(path, ".fmu"),
    };
    let _claim = reserve::file(&out, "--out", &[path.to_path_buf(), library.clone()])?;
    let settings = &arguments.settings.settings;
    let bytes = ilon_fmi::package(path, settings, &files, &library)?;
    ilon_trace::file::write_bytes(&out, &bytes)?;
    console::lines(&format!("an FMU for {}: {}\n", platform().0, out.display()))?;
    Ok(Outcome::Done)
}

/// The shared library: at `ILON_C_LIBRARY`, as the Python package sets it; beside the command,
/// where cargo builds it; or in `lib` beside its folder, where the installer of a release puts it.
fn of_this_command() -> Result<PathBuf, Failure> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let name = format!("{DLL_PREFIX}ilon_c{DLL_SUFFIX}");
    let command = std::env::current_exe().and_then(|path| path.canonicalize());
    let folder = command
        .ok()
        .and_then(|path| Some(path.parent()?.to_owned()));
    let near = folder.map(|folder| [folder.join(&name), folder.join("../lib").join(&name)]);
    let said = std::env::var_os("ILON_C_LIBRARY").map(PathBuf::from);
    let mut places = said.into_iter().chain(near.into_iter().flatten());
    places.find(|path| path.is_file()).ok_or_else(|| {
        Failure::usage(
            format!("there is no `{name}` beside this command nor in `../lib`, and an FMU holds it"),
            "take it from a release's archive or wheel, build it with `cargo build --release -p ilon-c`, or name it with --library",
        )
    })
}
