//! `ilon export ROBOT --mjcf`, and for other simulators: wheels with their real rollers.

use std::path::Path;
use std::process::Command;

use ilon_formats::{Format, write_fitted};
use ilon_robot::Robot;
use serde_json::{Value, json};

use super::escape::{one_line, path_in_line};
use super::export_arguments::{Arguments, named_after};
use super::kind::{Kind, wants};
use super::outcome::Outcome;
use super::robot::load;
use super::{console, json, reserve};
use crate::cli::failure::Failure;
use crate::exported::{DRIVE_NEWTON_PY, DRIVE_PY, Export};
use crate::inspect::conditions;
use crate::scenario::Scenario;
use crate::simulate::{Run, Simulation, load_robot};

/// Settings for Isaac Sim and other USD tools.
const USD_NOTES: &str = include_str!("../exported/usd_notes.txt");

/// The simulator agrees with ilon where it is off by no more of the ideal speed.
const AGREES: f64 = 0.01;

/// A robot for export, from its own file or from a scenario.
struct Subject<'a> {
    path: &'a Path,
    /// Before the scenario's keys are applied.
    plain: Robot,
    robot: Robot,
    scenario: Scenario,
    /// The scenario's run, for playback.
    run: Option<Run>,
}

/// Writes the files, and measures if requested.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let subject = subject(arguments)?;
    let path = subject.path;
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| named_after(path, "_export"));
    let _claim = reserve::folder(&out, "--out")?;
    let mut told = Vec::new();
    let mut outcome = Outcome::Done;
    for (is_asked, name, format) in [
        (arguments.mjcf, "mjcf", Format::Mjcf),
        (arguments.newton, "newton", Format::Mjcf),
        (arguments.sdf, "sdf", Format::Sdf),
        (arguments.urdf, "urdf", Format::Urdf),
        (arguments.usd_notes, "usd_notes", Format::Urdf),
    ] {
        if !is_asked {
            continue;
        }
        let (export, said) = export(arguments, &subject, &out, name, format)?;
        if said["verdict"]["agrees"] == false {
            outcome = Outcome::Unexpected;
            console::note(&format!(
                "warning: {} and ilon differ by {:.2} % on the drive `{}`: do not trust this robot there",
                simulator(name),
                1e2 * said["verdict"]["off"].as_f64().unwrap_or(f64::NAN),
                said["verdict"]["drive"].as_str().unwrap_or_default()
            ));
        }
        told.push((table(name, &export, &said), said));
    }
    if arguments.json {
        let all: Vec<&Value> = told.iter().map(|(_, said)| said).collect();
        console::data(&json::pretty("what was exported", &all)?)?;
    } else {
        let tables: String = told.iter().map(|(table, _)| table.as_str()).collect();
        let name = one_line(&subject.robot.name);
        console::lines(&format!(
            "{tables}`{name}` written to {}\n",
            path_in_line(&out)
        ))?;
    }
    Ok(outcome)
}

fn subject(arguments: &Arguments) -> Result<Subject<'_>, Failure> {
    let files = arguments.sandbox.files()?;
    let settings = &arguments.settings.settings;
    let robot = arguments.robot.as_ref().ok_or_else(|| {
        Failure::usage(
            "name one robot, or one scenario with --scenario",
            "for example `ilon export robot.urdf --mjcf`",
        )
    });
    let (path, plain, run, (scenario, robot)) = match &arguments.scenario {
        Some(path) => {
            wants(path, &[Kind::Scenario], &files)?;
            arguments.reading.none_beside(path)?;
            let scenario = Scenario::load_within(path, settings, &files)?;
            let robot = load_robot(&scenario)?;
            let run = Simulation::new(&scenario)?.run();
            (path, robot.clone(), Some(run), (scenario, robot))
        }
        None => {
            let path = robot?;
            let mut options = arguments.reading.options();
            options.files = files.clone();
            wants(path, &[Kind::Robot], &options.files)?;
            let plain = load(path, &options, "ilon export", &arguments.sandbox)?.robot;
            let met = conditions(settings, &plain, &files)?;
            (path, plain, None, met)
        }
    };
    Ok(Subject {
        path,
        plain,
        robot,
        scenario,
        run,
    })
}

/// Writes the files of one format, and measures in its simulator if requested: what it does, and
/// the same as JSON.
fn export(
    arguments: &Arguments,
    subject: &Subject<'_>,
    out: &Path,
    name: &str,
    format: Format,
) -> Result<(Export, Value), Failure> {
    let stem = subject.path.file_stem().unwrap_or_default();
    let stem = stem.to_string_lossy().replace(['.', ' '], "_");
    let mut export = Export::new(&subject.scenario, &subject.robot, format)?;
    let about = export.about();
    for (name, bytes) in write_fitted(&export.fitted, format, &stem, &export.ground, &about) {
        let place = out.join(name);
        reserve::not_an_input(&place, "--out", &[subject.path.to_path_buf()])?;
        ilon_trace::file::write_bytes(&place, &bytes)?;
    }
    let mut scenario_table = Value::Null;
    if format == Format::Mjcf {
        let mut drive = export.drive(&format!("{stem}_scene.xml"));
        if let Some(run) = subject.run.as_ref().filter(|_| name == "mjcf") {
            drive["trace"] = export.trace(&subject.robot, run)?;
        }
        let drive = json::pretty("the drives", &drive)?;
        ilon_trace::file::write_text(&out.join("drive.json"), &drive)?;
        let mut script = "drive.py";
        ilon_trace::file::write_text(&out.join(script), DRIVE_PY)?;
        if name == "newton" {
            script = "drive_newton.py";
            ilon_trace::file::write_text(&out.join(script), DRIVE_NEWTON_PY)?;
        }
        if arguments.verify {
            if subject.run.is_none() {
                let files = arguments.sandbox.files()?;
                export.simulate(&subject.plain, &arguments.settings.settings, &files)?;
            }
            let measured = python(&out.join(script), &out.join("drive.json"), name)?;
            export.take(&measured);
            scenario_table = measured["scenario"].clone();
        }
    }
    if name == "usd_notes" {
        let text = format!("{USD_NOTES}{}\n", about.replace("\n     ", "\n"));
        ilon_trace::file::write_text(&out.join("usd_notes.txt"), &text)?;
    }
    let fitted = &export.fitted;
    let verdict = export
        .furthest()
        .map(|(drive, off)| json!({ "agrees": off <= AGREES, "off": off, "drive": drive }));
    let said = json!({
        "format": name,
        "shapes": export.shapes(),
        "fit_error_mm": 1e3 * fitted.error_m,
        "hub_travel_mm": 1e3 * fitted.travel_m,
        "hub_travel_as_made_mm": 1e3 * fitted.travel_as_made_m,
        "drives": &export.drives,
        "left_out": export.left_out(),
        "verdict": verdict,
        "scenario": scenario_table,
    });
    Ok((export, said))
}

/// The simulator of a format that is verified.
fn simulator(name: &str) -> &'static str {
    if name == "newton" { "Newton" } else { "MuJoCo" }
}

/// One format as text for a terminal.
fn table(name: &str, export: &Export, said: &Value) -> String {
    let kind = if export.is_on_tyres() {
        "tyres"
    } else {
        "rollers"
    };
    let (shapes, error_mm) = (export.shapes().join(", "), 1e3 * export.fitted.error_m);
    let mut text = format!(
        "{name}: {kind} as {shapes}; hub height off by {error_mm:.4} mm at most\n  \
         speed over ideal      as made  on these shapes     ilon  simulator  travel there, mm\n"
    );
    let shown = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.4}"));
    for drive in &export.drives {
        let [ilon, there, travel] = [drive.ilon, drive.measured, drive.travel_mm].map(shown);
        let (name, made, expected) = (drive.name, drive.as_made, drive.expected);
        text += &format!(
            "  {name:<18} {made:>10.4} {expected:>16.4} {ilon:>8} {there:>10} {travel:>17}\n"
        );
    }
    if let Some((drive, off)) = export.furthest() {
        let verdict = if off <= AGREES {
            "agrees"
        } else {
            "does not agree"
        };
        let off = 1e2 * off;
        text += &format!("  it {verdict} with ilon: off by {off:.2} % at most, {drive}\n");
    }
    for words in ["difference", "geometry", "softness", "step", "remainder"] {
        if let Some(of) = said["scenario"][words].as_array() {
            let of = |axis: usize| of[axis].as_f64().unwrap_or(f64::NAN);
            let (x, y, turn) = (1e3 * of(0), 1e3 * of(1), of(2).to_degrees());
            text += &format!(
                "  end of the scenario, {words:<11}: {x:8.2} mm {y:8.2} mm {turn:8.3} deg\n"
            );
        }
    }
    text
}

/// The JSON output of a Python script, with the Python of `ILON_PYTHON`, or `python3`.
fn python(script: &Path, argument: &Path, name: &str) -> Result<Value, Failure> {
    let package = if name == "newton" {
        "newton[sim]"
    } else {
        "mujoco"
    };
    let python = std::env::var("ILON_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let refused = |reason: String| {
        let found = format!("the simulator could not be run: {reason}");
        let remedy = format!(
            "install it, such as with `pip install \"{package}\"`, name a Python that has it by ILON_PYTHON, or leave --verify out"
        );
        Failure::usage(found, remedy)
    };
    // Without a folder of compiled scripts beside the files.
    let mut command = Command::new(&python);
    let output = command.arg("-B").arg(script).arg(argument).output();
    let output = output.map_err(|error| refused(format!("{python}: {error}")))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.lines().rev().find(|line| !line.trim().is_empty());
    let last = last.unwrap_or_default().to_owned();
    if !output.status.success() {
        return Err(refused(last));
    }
    let printed = String::from_utf8_lossy(&output.stdout);
    let line = printed.lines().last().unwrap_or_default();
    serde_json::from_str(line).map_err(|error| refused(error.to_string()))
}
