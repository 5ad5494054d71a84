//! The requests of a page and their replies. Both are JSON; binary or large data is returned as
//! bytes.
//!
//! A page adds files, opens one of them as a scenario, advances it by control periods until it is
//! done, and takes the files that the command would write. Alternatively the user drives, and the
//! result is a scenario that repeats the drive. There is at most one active run, one finished run,
//! and one that is kept for comparison.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ilon::compare::{ComparedRun, Comparison, html};
use ilon_files::FileAccess;
use ilon_formats::Spec;
use ilon_report::viewer::scene_of;
use ilon_scene::Rolling;
use ilon_sim::judge::judge;
use ilon_sim::scenario::Setting;
use ilon_sim::{Run, Scenario, Simulation, simulate};
use ilon_trace::Rows;
use serde::Deserialize;
use serde_json::{Value, json};

mod drive;
mod fault;
mod room;
mod view;

use drive::PersonsDrive;
pub use fault::Fault;
use fault::{none_driven, none_open, of_page};

/// A request.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// Removes all files.
    Clear,
    /// The JSON Schemas of a scenario and of a robot description.
    Schemas,
    /// Opens a scenario: returns its name, its keys with all defaults, the robot, and the scene.
    Open {
        /// The path of the scenario among the files.
        scenario: PathBuf,
        /// Changed keys, as for `--set`.
        settings: Vec<String>,
    },
    /// Opens a scenario as [`Request::Open`] does, for the user to drive.
    Drive {
        /// The path of the scenario among the files.
        scenario: PathBuf,
        /// Changed keys, as for `--set`.
        settings: Vec<String>,
    },
    /// Commands a twist in the body frame, in m/s, m/s and rad/s, until the next command.
    Steer {
        /// Ahead, to the left, and the yaw rate.
        twist: [f64; 3],
    },
    /// Ends a drive: returns `path` and `text` of a scenario that repeats it, and the `files` that
    /// it needs.
    EndDrive,
    /// Advances by control periods, or to the end.
    Advance {
        /// The number of control periods.
        periods: u32,
    },
    /// The robot's current state: the bytes of a frame, for the scene that [`Request::Open`]
    /// returned.
    Frame,
    /// Finishes a run that is done: returns its figures.
    Finish {
        /// The equivalent command line, for the report.
        command: String,
    },
    /// A file that the command would have written: bytes.
    Take {
        /// Which file.
        what: Output,
    },
    /// Keeps the finished run for comparison, in place of an earlier one.
    Keep {
        /// Its name in the comparison.
        name: String,
    },
    /// Compares the kept run with the finished one: the bytes of a page.
    Compare {
        /// The name of the finished run in the comparison.
        name: String,
    },
}

/// A file of a finished run.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Output {
    /// `report.html`.
    Report,
    /// `summary.json`.
    Summary,
    /// `trace.parquet`.
    Trace,
    /// The scenario with all defaults, for a folder that also holds the files that it names.
    Scenario,
}

/// The state of the simulator in a page.
#[derive(Default)]
pub struct Door {
    files: BTreeMap<PathBuf, Vec<u8>>,
    running: Option<Running>,
    finished: Option<Finished>,
    kept: Option<ComparedRun>,
}

/// An active run.
struct Running {
    simulation: Simulation,
    rolling: Rolling,
    /// The number of rows already used to turn the rollers.
    seen: usize,
    /// The drive, if the user drives.
    drive: Option<PersonsDrive>,
}

/// A finished run.
struct Finished {
    run: Run,
    command: String,
}

impl Door {
    /// Adds or replaces a file.
    pub fn put(&mut self, path: String, bytes: Vec<u8>) {
        self.files.insert(PathBuf::from(path), bytes);
    }

    /// Answers a request. The reply is JSON, `{"ok": ...}` or `{"fault": ...}`; bytes follow after
    /// a newline.
    pub fn ask(&mut self, request: &[u8]) -> Vec<u8> {
        let answered = serde_json::from_slice(request)
            .map_err(|error| of_page(format!("the page asks for nothing known: {error}")))
            .and_then(|request| self.answer(request));
        match answered {
            Ok(Reply::Said(said)) => json!({ "ok": said }).to_string().into_bytes(),
            Ok(Reply::Bytes(bytes)) => [&b"{\"ok\":null}\n"[..], &bytes].concat(),
            Err(fault) => json!({ "fault": fault }).to_string().into_bytes(),
        }
    }

    fn answer(&mut self, request: Request) -> Result<Reply, Fault> {
        match request {
            Request::Clear => {
                self.files.clear();
                Ok(Reply::Said(Value::Null))
            }
            Request::Schemas => Ok(Reply::Said(json!({
                "scenario": Scenario::json_schema(),
                "robot": Spec::json_schema(),
            }))),
            Request::Open { scenario, settings } => self.open(&scenario, &settings, false),
            Request::Drive { scenario, settings } => self.open(&scenario, &settings, true),
            Request::Steer { twist } => self.steer(twist),
            Request::EndDrive => self.end_drive(),
            Request::Advance { periods } => self.advance(periods),
            Request::Frame => self.frame(),
            Request::Finish { command } => self.finish(command),
            Request::Take { what } => self.take(what),
            Request::Keep { name } => {
                let Finished { run, .. } = self.finished()?;
                self.kept = Some(compared(run, name));
                Ok(Reply::Said(Value::Null))
            }
            Request::Compare { name } => self.compare(name),
        }
    }

    fn open(
        &mut self,
        path: &std::path::Path,
        settings: &[String],
        is_driven: bool,
    ) -> Result<Reply, Fault> {
        // Frees its memory before the new run is built.
        self.running = None;
        let settings: Vec<Setting> = settings
            .iter()
            .map(|text| text.parse().map_err(of_page))
            .collect::<Result<_, _>>()?;
        let files = self.files.iter();
        let files = FileAccess::of_memory(files.map(|(path, bytes)| (path.clone(), bytes.clone())));
        let scenario = Scenario::load_within(path, &settings, &files)?;
        let (drive, simulation) = if is_driven {
            let (drive, simulation) = PersonsDrive::begin(path, scenario.clone())?;
            (Some(drive), simulation)
        } else {
            room::admit(&scenario)?;
            (None, Simulation::new(&scenario)?)
        };
        room::admit(simulation.scenario())?;
        let robot = simulation.plant().robot();
        let header = &simulation.trace().header;
        let relief = header.ground.as_ref().and_then(|g| g.relief.as_ref());
        let relief_m = relief.map(simulate::relief_heights_m);
        let scene = scene_of(simulation.trace(), robot, relief_m.as_deref());
        let rest = ilon_scene::Frame::at_rest(robot);
        let said = json!({
            "name": scenario.name,
            "values": simulation.scenario(),
            "duration_s": simulation.progress().duration_s,
            "control_dt_s": simulation.scenario().run.control_dt_s,
            "warnings": simulation.warnings(),
            "robot": view::robot(robot),
            "spec": view::spec(&scenario, &self.files),
            "scene": scene,
            "rest": rest.values(),
        });
        self.running = Some(Running {
            rolling: Rolling::of(robot),
            simulation,
            seen: 0,
            drive,
        });
        Ok(Reply::Said(said))
    }

    fn steer(&mut self, twist: [f64; 3]) -> Result<Reply, Fault> {
        let running = self.running.as_mut().ok_or_else(none_open)?;
        let drive = running.drive.as_mut().ok_or_else(none_driven)?;
        drive.steer(&mut running.simulation, twist)?;
        Ok(Reply::Said(Value::Null))
    }

    fn end_drive(&mut self) -> Result<Reply, Fault> {
        let Running {
            simulation, drive, ..
        } = self.running.take().ok_or_else(none_open)?;
        let drive = drive.ok_or_else(none_driven)?;
        Ok(Reply::Said(drive.end(&simulation)?))
    }

    fn advance(&mut self, periods: u32) -> Result<Reply, Fault> {
        let Running {
            simulation, drive, ..
        } = self.running.as_mut().ok_or_else(none_open)?;
        let control_dt_s = simulation.scenario().run.control_dt_s;
        // Up to the start of a control period, whose step is not taken yet.
        let passed = (simulation.progress().time_s / control_dt_s).round();
        let until_s = (passed + f64::from(periods) - 1e-6) * control_dt_s;
        while !simulation.is_done() && simulation.progress().time_s < until_s {
            simulation.step();
        }
        let progress = simulation.progress();
        Ok(Reply::Said(json!({
            "t_s": progress.time_s,
            "duration_s": progress.duration_s,
            "done": simulation.is_done(),
            "figures": drive.as_ref().map(|drive| drive.figures(simulation)),
        })))
    }

    fn frame(&mut self) -> Result<Reply, Fault> {
        let running = self.running.as_mut().ok_or_else(none_open)?;
        let trace = running.simulation.trace();
        let mut frame = Vec::new();
        let rows = trace.row_count();
        for (row, (record, wheels)) in trace.steps().enumerate().skip(running.seen) {
            if row + 1 == rows {
                let seen = running.rolling.frame(&trace.header, record, wheels);
                frame = seen.bytes();
            }
            running.rolling.pass(&trace.header, record, wheels);
        }
        running.seen = rows;
        Ok(Reply::Bytes(frame))
    }

    fn finish(&mut self, command: String) -> Result<Reply, Fault> {
        let Running { simulation, .. } = self.running.take().ok_or_else(none_open)?;
        self.finished = None;
        let run = simulation.run();
        run.trace.check_finite()?;
        let failed = judge(&run).into_iter().filter(|verdict| !verdict.held);
        let said = json!({
            "name": run.scenario.name,
            "summary": run.summary,
            "hash": run.summary.trace_hash,
            "warnings": run.warnings,
            "failed": failed.map(|verdict| verdict.to_string()).collect::<Vec<_>>(),
        });
        self.finished = Some(Finished { run, command });
        Ok(Reply::Said(said))
    }

    fn finished(&self) -> Result<&Finished, Fault> {
        let none = || of_page("no run has been finished");
        self.finished.as_ref().ok_or_else(none)
    }

    fn take(&self, what: Output) -> Result<Reply, Fault> {
        let Finished { run, command } = self.finished()?;
        Ok(Reply::Bytes(match what {
            Output::Report => ilon::cli::report_html(run, command).into_bytes(),
            Output::Trace => run.trace.to_parquet()?,
            Output::Summary => {
                let text = serde_json::to_string_pretty(&run.summary).map_err(of_page)?;
                (text + "\n").into_bytes()
            }
            Output::Scenario => view::beside_its_files(&run.scenario)
                .to_toml()?
                .into_bytes(),
        }))
    }

    fn compare(&self, name: String) -> Result<Reply, Fault> {
        let none = || of_page("no run has been kept to compare with");
        let kept = self.kept.clone().ok_or_else(none)?;
        let Finished { run, .. } = self.finished()?;
        let paths = [&kept.name, &name].map(PathBuf::from);
        let comparison = Comparison::of(vec![kept, compared(run, name)], &paths);
        let comparison = comparison.map_err(of_page)?;
        Ok(Reply::Bytes(html(&comparison).into_bytes()))
    }
}

/// The reply to a request.
enum Reply {
    Said(Value),
    Bytes(Vec<u8>),
}

fn compared(run: &Run, name: String) -> ComparedRun {
    ComparedRun::new(name, run.trace.clone(), run.summary.clone())
}
