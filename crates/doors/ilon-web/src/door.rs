//! What a page can ask, and what comes of it. Requests and replies are JSON; what is large or no text is asked for as bytes.
//!
//! A page puts files, opens a scenario among them, advances it by control periods until it is done, and takes what the command would
//! write. Or a person drives: what comes of it is a scenario that does the same again. One run is under way at a time, one is finished, and
//! one is kept beside it to be compared.

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

/// What can be asked.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// Forgets all files.
    Clear,
    /// The JSON Schemas of a scenario and of a robot in short.
    Schemas,
    /// Puts the robot of a scenario into its world: gives its name, what it holds with every default, the robot, and the scene.
    Open {
        /// The path of the scenario among the files.
        scenario: PathBuf,
        /// Keys that are otherwise than in the file, as `--set` takes them.
        settings: Vec<String>,
    },
    /// Puts the robot of a scenario into its world as [`Request::Open`] does, for a person to drive.
    Drive {
        /// The path of the scenario among the files.
        scenario: PathBuf,
        /// Keys that are otherwise than in the file.
        settings: Vec<String>,
    },
    /// Asks the robot that is driven for a twist in the body frame, in m/s, m/s and rad/s, until the next.
    Steer {
        /// Ahead, to the left, and the yaw rate.
        twist: [f64; 3],
    },
    /// Ends a drive: gives `path` and `text` of a scenario that does the same again, and the `files` that it needs.
    EndDrive,
    /// Goes on by some control periods, or to the end.
    Advance {
        /// How many.
        periods: u32,
    },
    /// The robot now: the bytes of a frame, for the scene that [`Request::Open`] gave.
    Frame,
    /// Ends a run that is done: gives its figures.
    Finish {
        /// The command that gives the same, for the report.
        command: String,
    },
    /// What the command would have written: bytes.
    Take {
        /// Which file.
        what: Output,
    },
    /// Keeps the finished run, in place of the one that was kept before, under a name.
    Keep {
        /// What it is called beside the other.
        name: String,
    },
    /// Lays the kept run and the finished one over each other: the bytes of a page.
    Compare {
        /// What the finished run is called beside the kept one.
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
    /// The scenario with every default spelled out, for a folder in which the files that it names lie beside it.
    Scenario,
}

/// The state behind the border.
#[derive(Default)]
pub struct Door {
    files: BTreeMap<PathBuf, Vec<u8>>,
    running: Option<Running>,
    finished: Option<Finished>,
    kept: Option<ComparedRun>,
}

/// A run under way.
struct Running {
    simulation: Simulation,
    rolling: Rolling,
    /// The rows that have turned the rollers.
    seen: usize,
    /// Where a person drives.
    drive: Option<PersonsDrive>,
}

/// A run that is over.
struct Finished {
    run: Run,
    command: String,
}

impl Door {
    /// Adds a file, or replaces it.
    pub fn put(&mut self, path: String, bytes: Vec<u8>) {
        self.files.insert(PathBuf::from(path), bytes);
    }

    /// Answers a request. The reply is JSON, `{"ok": ...}` or `{"fault": ...}`; of what is bytes these follow behind a newline.
    pub fn ask(&mut self, request: &[u8]) -> Vec<u8> {
        let answered = serde_json::from_slice(request)
            .map_err(|error| Fault::of_page(format!("the page asks for nothing known: {error}")))
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
        // What it held is given back before anything new is made.
        self.running = None;
        let settings: Vec<Setting> = settings
            .iter()
            .map(|text| text.parse().map_err(Fault::of_page))
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
        let running = self.running.as_mut().ok_or_else(Fault::none_open)?;
        let drive = running.drive.as_mut().ok_or_else(Fault::none_driven)?;
        drive.steer(&mut running.simulation, twist)?;
        Ok(Reply::Said(Value::Null))
    }

    fn end_drive(&mut self) -> Result<Reply, Fault> {
        let Running {
            simulation, drive, ..
        } = self.running.take().ok_or_else(Fault::none_open)?;
        let drive = drive.ok_or_else(Fault::none_driven)?;
        Ok(Reply::Said(drive.end(&simulation)?))
    }

    fn advance(&mut self, periods: u32) -> Result<Reply, Fault> {
        let Running {
            simulation, drive, ..
        } = self.running.as_mut().ok_or_else(Fault::none_open)?;
        let control_dt_s = simulation.scenario().run.control_dt_s;
        // Up to the beginning of a control period, whose step is not taken yet.
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
        let running = self.running.as_mut().ok_or_else(Fault::none_open)?;
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
        let Running { simulation, .. } = self.running.take().ok_or_else(Fault::none_open)?;
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
        let none = || Fault::of_page("no run has been finished");
        self.finished.as_ref().ok_or_else(none)
    }

    fn take(&self, what: Output) -> Result<Reply, Fault> {
        let Finished { run, command } = self.finished()?;
        Ok(Reply::Bytes(match what {
            Output::Report => ilon::cli::report_html(run, command).into_bytes(),
            Output::Trace => run.trace.to_parquet()?,
            Output::Summary => {
                let text = serde_json::to_string_pretty(&run.summary).map_err(Fault::of_page)?;
                (text + "\n").into_bytes()
            }
            Output::Scenario => view::beside_its_files(&run.scenario)
                .to_toml()?
                .into_bytes(),
        }))
    }

    fn compare(&self, name: String) -> Result<Reply, Fault> {
        let none = || Fault::of_page("no run has been kept to compare with");
        let kept = self.kept.clone().ok_or_else(none)?;
        let Finished { run, .. } = self.finished()?;
        let paths = [&kept.name, &name].map(PathBuf::from);
        let comparison = Comparison::of(vec![kept, compared(run, name)], &paths);
        let comparison = comparison.map_err(Fault::of_page)?;
        Ok(Reply::Bytes(html(&comparison).into_bytes()))
    }
}

/// What a request is answered with.
enum Reply {
    Said(Value),
    Bytes(Vec<u8>),
}

fn compared(run: &Run, name: String) -> ComparedRun {
    ComparedRun::new(name, run.trace.clone(), run.summary.clone())
}
