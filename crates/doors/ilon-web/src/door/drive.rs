//! A robot driven by the user, recorded as a log with a scenario that repeats the drive bit for
//! bit.

use std::path::{Path, PathBuf};

use ilon_robot::Twist;
use ilon_sim::scenario::Step;
use ilon_sim::{Scenario, Simulation};
use serde_json::{Value, json};

use super::fault::{Fault, of_page};

/// The longest drive, in seconds; chosen.
const LONGEST_S: f64 = 120.0;
/// The largest accepted twist, whatever the wheels allow, in m/s and rad/s; chosen.
const MOST_M_S: f64 = 20.0;
const MOST_RAD_S: f64 = 50.0;

/// The user's commands so far.
pub(super) struct PersonsDrive {
    /// The scenario as opened, without its commanded motion.
    scenario: Scenario,
    path: PathBuf,
    /// Steps for a robot whose commanded wheel rates are not known in advance.
    physics_dt_s: f64,
    split_dt_s: Option<f64>,
    control_dt_s: f64,
    /// The commanded twists with their start times, in seconds; unchanged commands are left out.
    rows: Vec<(f64, Twist)>,
}

impl PersonsDrive {
    /// Places the robot of a scenario in its world, to be driven.
    pub fn begin(path: &Path, mut scenario: Scenario) -> Result<(Self, Simulation), Fault> {
        scenario.run.duration_s = LONGEST_S;
        let simulation = Simulation::steered(&scenario)?;
        let resolved = simulation.plant().resolved();
        let drive = Self {
            path: path.to_owned(),
            physics_dt_s: resolved.physics_dt_s(),
            split_dt_s: resolved.scenario().world.solver.split_dt_s,
            control_dt_s: resolved.control_dt_s(),
            rows: vec![(0.0, Twist::default())],
            scenario,
        };
        Ok((drive, simulation))
    }

    /// Commands a twist (m/s, m/s, rad/s in the body frame) from the next control period on.
    pub fn steer(&mut self, simulation: &mut Simulation, asked: [f64; 3]) -> Result<(), Fault> {
        if !asked.iter().all(|part| part.is_finite()) {
            return Err(of_page("a twist that is no number is not taken"));
        }
        let [vx, vy, omega] = asked;
        // Avoids negative zero, which text and hash distinguish from zero.
        let within = |part: f64, most: f64| part.clamp(-most, most) + 0.0;
        let twist = Twist::new(
            within(vx, MOST_M_S),
            within(vy, MOST_M_S),
            within(omega, MOST_RAD_S),
        );
        self.hold(self.next_s(simulation), twist);
        simulation.steer(twist);
        Ok(())
    }

    /// Start of the next control period, in seconds.
    fn next_s(&self, simulation: &Simulation) -> f64 {
        // A physics step may end beyond the period by rounding.
        let periods = simulation.progress().time_s / self.control_dt_s;
        let next_s = (periods - 1e-6).ceil().max(0.0) * self.control_dt_s;
        // Rounded to nanoseconds, as times in a log are.
        (next_s * 1e9).round() / 1e9
    }

    fn hold(&mut self, from_s: f64, twist: Twist) {
        self.rows.pop_if(|(last_s, _)| *last_s >= from_s);
        if self.rows.last().is_none_or(|(_, last)| *last != twist) {
            self.rows.push((from_s, twist));
        }
    }

    /// The figures that a page shows, as in a live run.
    pub fn figures(&self, simulation: &Simulation) -> Value {
        let values = |twist: Twist| [twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s];
        let asked = self
            .rows
            .last()
            .map_or_else(Twist::default, |(_, last)| *last);
        json!({
            "t_s": simulation.progress().time_s,
            "asked": values(asked),
            "real": values(simulation.plant().truth().twist_in_body),
        })
    }

    /// Ends the drive: returns path and text of a scenario that repeats it, and of the log that the
    /// scenario plays back.
    pub fn end(mut self, simulation: &Simulation) -> Result<Value, Fault> {
        let end_s = self.next_s(simulation);
        if end_s <= 0.0 {
            return Err(of_page("the robot was not driven"));
        }
        self.hold(end_s, Twist::default());
        // A log ends with the time at which its last row ends.
        if self.rows.last().is_none_or(|(last_s, _)| *last_s < end_s) {
            self.rows.push((end_s, Twist::default()));
        }
        let name = self.scenario.name.trim_end_matches("_driven").to_owned();
        let beside = |ending: &str| self.path.with_file_name(format!("{name}_driven.{ending}"));
        let (path, log_path) = (beside("toml"), beside("csv"));
        let file = log_path.file_name().unwrap_or_default();
        let (mut again, log) = self.scenario.driven(file, &self.rows);
        again.run.physics_dt_s = Step::Seconds(self.physics_dt_s);
        again.world.solver.split_dt_s = self.split_dt_s;
        let text = format!(
            "# {name}, driven by hand for {end_s:.1} s.\n\n{}",
            again.to_toml()?
        );
        Ok(json!({ "path": path, "text": text, "files": [[log_path, log]] }))
    }
}
