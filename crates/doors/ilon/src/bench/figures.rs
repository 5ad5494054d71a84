//! The measurements of `ilon bench`, as data.

use std::collections::BTreeMap;

use serde::Serialize;

/// The drives forward, lateral, yaw, diagonal and arc, in m/s, m/s and rad/s.
pub const DRIVES: [(&str, [f64; 3]); 5] = [
    ("D1", [0.3, 0.0, 0.0]),
    ("D2", [0.0, 0.3, 0.0]),
    ("D3", [0.0, 0.0, 1.0]),
    ("D4", [0.2, 0.2, 0.0]),
    ("D5", [0.3, 0.0, 0.5]),
];

/// All measurements.
#[derive(Clone, Debug, Serialize)]
pub struct Bench {
    /// Machine, date and versions.
    pub machine: Machine,
    /// The headings at which accuracy was measured, in degrees.
    pub headings_deg: Vec<f64>,
    /// Measurements by robot.
    pub robots: BTreeMap<String, RobotBench>,
}

/// Measurements of one robot.
#[derive(Clone, Debug, Serialize)]
pub struct RobotBench {
    /// Worst error of the headline configuration, in percent: the fastest one with an error of at
    /// most 0.1 %, or the most accurate one if there is none.
    pub worst_error_pct: f64,
    /// Physics steps per CPU second of the headline configuration.
    pub steps_per_cpu_s: Option<f64>,
    /// Simulated seconds per CPU second of the headline configuration.
    pub sim_s_per_cpu_s: Option<f64>,
    /// Name of the headline configuration.
    pub headline: String,
    /// Its drives, by name.
    pub drives: BTreeMap<String, BenchDrive>,
    /// All configurations.
    pub configurations: Vec<Configuration>,
    /// What was left out, and the reason.
    pub remarks: Vec<String>,
}

/// One way to simulate a robot.
#[derive(Clone, Debug, Serialize)]
pub struct Configuration {
    /// The simulated rollers, `all` or `near`; or `rapier`: all of them, with contacts solved by
    /// rapier.
    pub roller_bodies: String,
    /// Length of a physics step, in seconds.
    pub physics_dt_s: f64,
    /// The worst error over all drives and headings, in percent.
    pub worst_error_pct: f64,
    /// The largest ripple of a hub's height over all drives, in metres.
    pub hub_ripple_m: Option<f64>,
    /// The largest sliding speed, rms over a drive, in m/s.
    pub slip_speed_rms_m_s: Option<f64>,
    /// Deviation of the wheels from their target rates, for the worst component of the worst drive,
    /// in percent: a loop that is too soft for its step makes an easier drive.
    pub rate_shortfall_pct: f64,
    /// Simulated seconds per CPU second, over all drives.
    pub sim_s_per_cpu_s: Option<f64>,
    /// Physics steps per CPU second, over all drives.
    pub steps_per_cpu_s: Option<f64>,
    /// Time of the median timed stretch over the best, less one, for the worst drive, in percent.
    pub speed_spread_pct: Option<f64>,
    /// The drives, by name.
    pub drives: BTreeMap<String, BenchDrive>,
}

/// Results of one drive.
#[derive(Clone, Debug, Serialize)]
pub struct BenchDrive {
    /// Worst deviation of a driven component from the contact kinematics, over the headings, in
    /// percent.
    pub error_pct: f64,
    /// Actual over ideal twist, for the worst driven component.
    pub ratio_ideal: f64,
    /// Ripple of the hubs' height, in metres.
    pub hub_ripple_m: Option<f64>,
    /// Simulated seconds per CPU second.
    pub sim_s_per_cpu_s: Option<f64>,
    /// Results at each heading.
    pub headings: Vec<Heading>,
}

/// A drive at one heading.
#[derive(Clone, Debug, Serialize)]
pub struct Heading {
    /// The heading at the start, in degrees.
    pub heading_deg: f64,
    /// Worst deviation of a driven component from the contact kinematics, in percent; 100 for a
    /// component that is NaN.
    pub error_pct: f64,
    /// Actual over ideal twist, for the worst driven component.
    pub ratio_ideal: f64,
    /// Ripple of the hubs' height, in metres.
    pub hub_ripple_m: Option<f64>,
    /// Sliding speed of the touching rollers, rms, in m/s.
    pub slip_speed_rms_m_s: Option<f64>,
    /// Deviation of the wheels from their target rates, for the worst driven component, in percent.
    pub rate_shortfall_pct: f64,
}

/// Machine, date and versions of a measurement.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// The processor, as named by the system; `None` if unknown.
    pub processor: Option<String>,
    /// Number of threads that can run at once.
    pub cores: Option<usize>,
    /// Operating system and architecture.
    pub system: String,
    /// Versions of ilon and its dependencies, by name.
    pub versions: Vec<(String, String)>,
    /// Whether the program was built with optimisation; otherwise speeds are meaningless.
    pub optimised: bool,
    /// End of the measurement, RFC 3339, UTC.
    pub date: String,
}

impl Configuration {
    /// Returns the physics steps per second.
    pub fn rate_hz(&self) -> f64 {
        // A rate of 60 comes back as 60.
        (1e6 / self.physics_dt_s).round() / 1e6
    }

    /// The configuration in a few words.
    pub fn describe(&self) -> String {
        describe(&self.roller_bodies, self.rate_hz())
    }
}

/// A configuration in a few words.
pub fn describe(kind: &str, rate_hz: f64) -> String {
    if kind == "rapier" {
        format!("contacts by rapier, {rate_hz} steps a second")
    } else {
        format!("{kind} rollers, {rate_hz} steps a second")
    }
}

/// Columns of a configuration's table after the errors of its drives.
pub const CONFIGURATION_COLUMNS: [&str; 5] =
    ["ripple", "slip", "sim s/CPU s", "steps/CPU s", "spread"];

impl Configuration {
    /// Returns the figures of its table row, each with its decimals: the worst error and that of
    /// each drive in %, then the other columns in mm, mm/s and %.
    pub fn figures(&self) -> Vec<(Option<f64>, usize)> {
        let drives = DRIVES.map(|(name, _)| (self.drives.get(name).map(|d| d.error_pct), 4));
        let others = [
            (self.hub_ripple_m.map(|m| 1e3 * m), 4),
            (self.slip_speed_rms_m_s.map(|v| 1e3 * v), 2),
            (self.sim_s_per_cpu_s, 1),
            (self.steps_per_cpu_s, 0),
            (self.speed_spread_pct, 1),
        ];
        let worst = std::iter::once((Some(self.worst_error_pct), 4));
        worst.chain(drives).chain(others).collect()
    }
}
