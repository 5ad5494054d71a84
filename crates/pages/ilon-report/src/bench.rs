//! What `ilon bench` measures, as data.

use std::collections::BTreeMap;

use serde::Serialize;

/// The drives: forward, lateral, yaw, diagonal, arc; m/s, m/s and rad/s.
pub const DRIVES: [(&str, [f64; 3]); 5] = [
    ("D1", [0.3, 0.0, 0.0]),
    ("D2", [0.0, 0.3, 0.0]),
    ("D3", [0.0, 0.0, 1.0]),
    ("D4", [0.2, 0.2, 0.0]),
    ("D5", [0.3, 0.0, 0.5]),
];

/// Physics steps a second of every robot of a fleet, in the contact window.
pub const FLEET_RATE_HZ: f64 = 240.0;

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Bench {
    /// Where, when and with what.
    pub machine: Machine,
    /// The headings at which accuracy was measured, in degrees.
    pub headings_deg: Vec<f64>,
    /// By robot.
    pub robots: BTreeMap<String, RobotBench>,
    /// Many robots in one process.
    pub throughput: Vec<Throughput>,
}

/// What was measured with one robot.
#[derive(Clone, Debug, Serialize)]
pub struct RobotBench {
    /// Worst error of the headline configuration, in per cent: the fastest one that is off by 0.1 % at most, or the most
    /// accurate one where none is.
    pub worst_error_pct: f64,
    /// Physics steps a CPU second of the headline configuration.
    pub steps_per_cpu_s: Option<f64>,
    /// Simulated seconds a CPU second of the headline configuration.
    pub sim_s_per_cpu_s: Option<f64>,
    /// Which configuration that is.
    pub headline: String,
    /// Its drives, by name.
    pub drives: BTreeMap<String, BenchDrive>,
    /// All configurations.
    pub configurations: Vec<Configuration>,
    /// What was left out, and why.
    pub remarks: Vec<String>,
    /// What treads cost; `None` where none was timed.
    pub tread: Option<TreadCost>,
    /// Drives in which wheels slide; empty where rapier's contacts are not among what is measured, or know not all of the robot.
    pub transients: Vec<Transient>,
}

/// One way to simulate a robot.
#[derive(Clone, Debug, Serialize)]
pub struct Configuration {
    /// Which rollers are looked at, `all` or `near`; or `rapier`: all of them, with contacts that rapier solves itself.
    pub roller_bodies: String,
    /// Length of a physics step, in seconds.
    pub physics_dt_s: f64,
    /// The worst error over all drives and headings, in per cent.
    pub worst_error_pct: f64,
    /// The largest ripple of a hub's height over all drives, in metres.
    pub hub_ripple_m: Option<f64>,
    /// The largest sliding speed, rms over a drive, in m/s.
    pub slip_speed_rms_m_s: Option<f64>,
    /// How far the wheels missed the rates asked of them, the worst component of the worst drive, in per cent: a loop that
    /// is too soft for its step makes an easier drive.
    pub rate_shortfall_pct: f64,
    /// Simulated seconds a CPU second, over all drives.
    pub sim_s_per_cpu_s: Option<f64>,
    /// Physics steps a CPU second, over all drives.
    pub steps_per_cpu_s: Option<f64>,
    /// How much longer than the best the middle one of the timed stretches took, the worst drive, in per cent.
    pub speed_spread_pct: Option<f64>,
    /// The drives, by name.
    pub drives: BTreeMap<String, BenchDrive>,
}

/// What one drive came to.
#[derive(Clone, Debug, Serialize)]
pub struct BenchDrive {
    /// Worst deviation of a driven component from the contact kinematics, the worst heading, in per cent.
    pub error_pct: f64,
    /// Real over ideal twist, the worst driven component.
    pub ratio_ideal: f64,
    /// Ripple of the hubs' height, in metres.
    pub hub_ripple_m: Option<f64>,
    /// Simulated seconds a CPU second.
    pub sim_s_per_cpu_s: Option<f64>,
    /// Heading by heading.
    pub headings: Vec<Heading>,
}

/// A drive at one heading.
#[derive(Clone, Debug, Serialize)]
pub struct Heading {
    /// The heading at the start, in degrees.
    pub heading_deg: f64,
    /// Worst deviation of a driven component from the contact kinematics, in per cent. A component that did not move as a
    /// number counts as one that did not move at all: 100.
    pub error_pct: f64,
    /// Real over ideal twist, the worst driven component.
    pub ratio_ideal: f64,
    /// Ripple of the hubs' height, in metres.
    pub hub_ripple_m: Option<f64>,
    /// Sliding speed of the touching rollers, rms, in m/s.
    pub slip_speed_rms_m_s: Option<f64>,
    /// How far the wheels missed the rates asked of them, the worst driven component, in per cent.
    pub rate_shortfall_pct: f64,
}

/// Many independent robots in one process.
#[derive(Clone, Debug, Serialize)]
pub struct Throughput {
    /// Which robot they all are.
    pub robot: String,
    /// How many.
    pub robots: usize,
    /// On how many threads.
    pub threads: usize,
    /// Simulated seconds of all robots together a second of wall clock, the best of the stretches.
    pub sim_s_per_wall_s: f64,
    /// The same a CPU second of all threads together.
    pub sim_s_per_cpu_s: Option<f64>,
    /// CPU time over wall clock: how many cores the threads really had. Where it is less than their number, others had
    /// the rest, and the efficiency says more about them.
    pub cores: Option<f64>,
    /// Speed over that of the same robots on one thread, by the number of threads: 1 is a thread that costs nothing.
    /// `None` where one thread was not measured, or there are more threads than robots.
    pub efficiency: Option<f64>,
}

/// Where, when and with what something was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// The processor, in the system's words; `None` where it does not tell.
    pub processor: Option<String>,
    /// How many threads can run at once.
    pub cores: Option<usize>,
    /// System and architecture.
    pub system: String,
    /// By name: the versions of ilon and of what it stands on.
    pub versions: Vec<(String, String)>,
    /// Whether the program was built for speed; figures of one that was not tell nothing about it.
    pub optimised: bool,
    /// When the measurement ended, RFC 3339, UTC.
    pub date: String,
}

/// A drive in which wheels slide.
#[derive(Clone, Debug, Serialize)]
pub struct Transient {
    /// What happens.
    pub name: String,
    /// Contacts that ilon solves, at steps of 1 ms.
    pub ilon: Slide,
    /// Contacts that rapier solves, at steps of 1 ms.
    pub rapier: Slide,
    /// Contacts that ilon solves, at steps of 0.25 ms: what both are held against.
    pub fine: Slide,
}

/// What one drive came to.
#[derive(Clone, Debug, Serialize)]
pub struct Slide {
    /// Where the robot ended, from where it began, in metres: ahead and to the left.
    pub end_m: [f64; 2],
    /// The largest distance between the course and that of small steps, at the same time, in metres.
    pub apart_m: f64,
    /// Heat of sliding, and of spinning rollers up, in J.
    pub heat_j: f64,
    /// The fastest that a contact slid, in m/s.
    pub slip_speed_max_m_s: f64,
    /// What no part of the energy balance explains, over all energy that was turned over.
    pub unexplained_share: f64,
}

/// What treads cost a robot.
#[derive(Clone, Debug, Serialize)]
pub struct TreadCost {
    /// Physics steps a second.
    pub rate_hz: f64,
    /// Which rollers are looked at.
    pub roller_bodies: String,
    /// Stiffness of the treads of the first wheel, in N/m.
    pub stiffness_n_m: f64,
    /// CPU time of a step with treads over that without, all drives together.
    pub ratio: f64,
    /// The same of each drive, by name.
    pub drives: BTreeMap<String, f64>,
}

impl Configuration {
    /// Physics steps a second.
    pub fn rate_hz(&self) -> f64 {
        // A rate that was given as 60 comes back as 60.
        (1e6 / self.physics_dt_s).round() / 1e6
    }

    /// CPU seconds that a simulated second costs.
    pub fn cpu_s_per_sim_s(&self) -> Option<f64> {
        self.sim_s_per_cpu_s.map(|speed| 1.0 / speed)
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

/// What a table shows of a configuration after the errors of its drives.
pub const CONFIGURATION_COLUMNS: [&str; 5] =
    ["ripple", "slip", "sim s/CPU s", "steps/CPU s", "spread"];

/// What a table shows of a slide.
pub const SLIDE_COLUMNS: [&str; 6] = ["x", "y", "apart", "heat", "slip", "unexplained"];

impl Configuration {
    /// The figures that a table shows of it, each with its decimals: the worst error and that of each drive in %, then
    /// [`CONFIGURATION_COLUMNS`] in mm, mm/s and %.
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

impl Slide {
    /// The figures of [`SLIDE_COLUMNS`] in mm, J, mm/s and %, each with its decimals.
    pub fn figures(&self) -> [(Option<f64>, usize); 6] {
        [
            (Some(1e3 * self.end_m[0]), 2),
            (Some(1e3 * self.end_m[1]), 2),
            (Some(1e3 * self.apart_m), 2),
            (Some(self.heat_j), 4),
            (Some(1e3 * self.slip_speed_max_m_s), 1),
            (Some(100.0 * self.unexplained_share), 3),
        ]
    }
}

impl Throughput {
    /// The figures that a table shows of it, each with its decimals: simulated seconds a second of wall clock and of the CPU, cores,
    /// efficiency.
    pub fn figures(&self) -> [(Option<f64>, usize); 4] {
        [
            (Some(self.sim_s_per_wall_s), 1),
            (self.sim_s_per_cpu_s, 1),
            (self.cores, 2),
            (self.efficiency, 2),
        ]
    }
}

impl TreadCost {
    /// The drive that treads cost most.
    pub fn worst(&self) -> Option<(&str, f64)> {
        let drives = self.drives.iter();
        let worst = drives.max_by(|a, b| a.1.total_cmp(b.1));
        worst.map(|(name, ratio)| (name.as_str(), *ratio))
    }

    /// What they cost, in a sentence.
    pub fn said(&self) -> String {
        let worst = self.worst();
        let worst = worst.map_or_else(String::new, |(name, ratio)| {
            format!("; {ratio:.2} times in {name}, the most")
        });
        format!(
            "treads of {:.0e} N/m: {:.2} times the time of a step on rigid rollers, {} rollers, {} steps a second{worst}",
            self.stiffness_n_m, self.ratio, self.roller_bodies, self.rate_hz
        )
    }
}

impl Transient {
    /// The solvers in the order in which they are shown, and what each came to.
    pub fn rows(&self) -> [(&'static str, &Slide); 3] {
        [
            ("ilon, 1 ms", &self.ilon),
            ("rapier, 1 ms", &self.rapier),
            ("ilon, 0.25 ms", &self.fine),
        ]
    }
}
