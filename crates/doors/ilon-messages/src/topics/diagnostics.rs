//! Diagnostics of each second of a run: error budget, guidance, odometry and each wheel.

use ilon_robot::Twist;
use ilon_trace::{Header as RunHeader, MAX_TASKS, Record, WheelSample, ledger::Terms};

use crate::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};

/// A task with a smaller weight is saturated.
const SATURATED: f64 = 0.999;
/// A force at this share of its friction limit slides.
const ON_THE_EDGE: f64 = 0.999;

/// The rows since the last report.
#[derive(Clone, Debug)]
pub(super) struct Window {
    robot: String,
    wheel_names: Vec<String>,
    task_names: Vec<String>,
    rows: usize,
    /// The row before the window; for the first window the first row.
    before: Option<Record>,
    saturated_rows: [usize; MAX_TASKS],
    wheels: Vec<WheelWindow>,
    residual_m_s: f64,
    last: Record,
}

#[derive(Clone, Copy, Debug, Default)]
struct WheelWindow {
    airborne_rows: usize,
    sliding_rows: usize,
    load_n: f64,
    slip_squared: f64,
    friction_used_max: f64,
    torque_max_n_m: f64,
}

impl Window {
    pub fn of(header: &RunHeader) -> Self {
        Self {
            robot: header.robot_name.clone(),
            wheel_names: header.wheels.iter().map(|w| w.name.clone()).collect(),
            task_names: header.task_names.clone(),
            rows: 0,
            before: None,
            saturated_rows: [0; MAX_TASKS],
            wheels: vec![WheelWindow::default(); header.wheels.len()],
            residual_m_s: 0.0,
            last: Record::default(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.rows == 0
    }

    pub fn add(&mut self, record: &Record, wheels: &[WheelSample]) {
        self.rows += 1;
        self.before.get_or_insert(*record);
        for (rows, task) in self.saturated_rows.iter_mut().zip(&record.tasks) {
            *rows += usize::from(task.weight < SATURATED);
        }
        for (window, sample) in self.wheels.iter_mut().zip(wheels) {
            let used = sample.friction_used().unwrap_or(0.0);
            // The first row of a run comes before the first step: nothing has touched yet.
            window.airborne_rows += usize::from(!sample.touched() && record.t_s > 0.0);
            window.sliding_rows += usize::from(used > ON_THE_EDGE);
            window.load_n += sample.normal_force_n;
            window.slip_squared += sample.slip_speed_rms_m_s.powi(2);
            window.friction_used_max = window.friction_used_max.max(used);
            window.torque_max_n_m = window.torque_max_n_m.max(sample.torque_peak_n_m());
        }
        self.residual_m_s = self.residual_m_s.max(record.contact_residual_m_s);
        self.last = *record;
    }

    /// Returns the report, and starts the next window.
    pub fn report(&mut self) -> DiagnosticArray {
        let mut message = DiagnosticArray::default();
        message.status.push(self.error_budget());
        message.status.push(self.odometry());
        if !self.task_names.is_empty() {
            message.status.push(self.guidance());
        }
        for index in 0..self.wheels.len() {
            message.status.push(self.wheel(index));
        }
        self.rows = 0;
        self.before = Some(self.last);
        self.saturated_rows = Default::default();
        self.wheels.fill(WheelWindow::default());
        self.residual_m_s = 0.0;
        message
    }

    fn status(
        &self,
        name: &str,
        level: u8,
        message: String,
        values: Vec<(String, String)>,
    ) -> DiagnosticStatus {
        let values = values.into_iter();
        DiagnosticStatus {
            level,
            name: format!("ilon/{name}"),
            message,
            hardware_id: self.robot.clone(),
            values: values.map(|(key, value)| KeyValue { key, value }).collect(),
        }
    }

    fn error_budget(&self) -> DiagnosticStatus {
        let terms = Terms::between(self.before.as_ref().unwrap_or(&self.last), &self.last);
        let parts: Vec<(&str, Twist)> = (terms.shown())
            .map(|(_, name, term)| (name, term))
            .collect();
        let speed = |twist: &Twist| libm::hypot(twist.vx_m_s, twist.vy_m_s);
        // The first of equal ones.
        let larger = |a: usize, b: usize| {
            if speed(&parts[b].1) > speed(&parts[a].1) {
                b
            } else {
                a
            }
        };
        let (largest, of_largest) = parts[(1..parts.len()).fold(0, larger)];
        let message = format!(
            "asked and real differ by {:.1} mm/s; the largest part is {}, {:.1} mm/s",
            1e3 * speed(&terms.total),
            largest,
            1e3 * speed(&of_largest),
        );
        let mut values = Vec::new();
        for (name, mean) in std::iter::once(("total", terms.total)).chain(parts) {
            values.push((format!("{name} vx, m/s"), format!("{:.6}", mean.vx_m_s)));
            values.push((format!("{name} vy, m/s"), format!("{:.6}", mean.vy_m_s)));
            values.push((
                format!("{name} omega, rad/s"),
                format!("{:.6}", mean.omega_rad_s),
            ));
        }
        let last = &self.last;
        for (name, joules) in [
            ("slip energy, J", last.slip_energy_j),
            ("spin-up energy, J", last.spin_up_energy_j),
            ("motor energy, J", last.motor_energy_j),
        ] {
            values.push((name.to_owned(), format!("{joules:.6}")));
        }
        let residual = format!("{:.3e}", self.residual_m_s);
        values.push(("contact residual, m/s".to_owned(), residual));
        self.status("error budget", DiagnosticStatus::OK, message, values)
    }

    fn odometry(&self) -> DiagnosticStatus {
        let truth = self.last.truth.pose;
        let off = |name: &str, reckoned: ilon_robot::Pose| {
            let metres = (reckoned.position_m() - truth.position_m()).norm();
            let radians = ilon_robot::wrap_angle(reckoned.heading_rad - truth.heading_rad);
            [
                (format!("{name} position error, m"), format!("{metres:.6}")),
                (
                    format!("{name} heading error, rad"),
                    format!("{radians:.6}"),
                ),
            ]
        };
        let by_wheels = off("dead reckoning", self.last.odometry_ideal);
        let message = format!(
            "dead reckoning is off by {} m and {} rad",
            by_wheels[0].1, by_wheels[1].1
        );
        let mut values = by_wheels.to_vec();
        values.extend(off(
            "dead reckoning by touching rollers",
            self.last.odometry_contact,
        ));
        values.extend(off("seen pose", self.last.seen_pose));
        self.status("odometry", DiagnosticStatus::OK, message, values)
    }

    fn guidance(&self) -> DiagnosticStatus {
        let share = |task: usize| self.saturated_rows[task] as f64 / self.rows as f64;
        let tasks = self.task_names.len().min(MAX_TASKS);
        let values = (0..tasks).map(|task| {
            let key = format!("{} task saturated, share of time", self.task_names[task]);
            (key, format!("{:.3}", share(task)))
        });
        let saturated = (0..tasks).find(|task| share(*task) > 0.0);
        let (level, message) = match saturated {
            None => (DiagnosticStatus::OK, "no task was saturated".to_owned()),
            Some(task) => {
                let percent = (100.0 * share(task)).round();
                let name = &self.task_names[task];
                let message = format!("the {name} task was saturated for {percent} % of the time");
                (DiagnosticStatus::WARN, message)
            }
        };
        self.status("guidance", level, message, values.collect())
    }

    fn wheel(&self, index: usize) -> DiagnosticStatus {
        let rows = self.rows as f64;
        let wheel = &self.wheels[index];
        let airborne = wheel.airborne_rows as f64 / rows;
        let sliding = wheel.sliding_rows as f64 / rows;
        let percent = |share: f64| (100.0 * share).round();
        let (level, message) = if airborne > 0.0 {
            let message = format!("in the air for {} % of the time", percent(airborne));
            (DiagnosticStatus::WARN, message)
        } else if sliding > 0.0 {
            let message = format!("at its grip limit for {} % of the time", percent(sliding));
            (DiagnosticStatus::WARN, message)
        } else {
            (DiagnosticStatus::OK, "within its grip".to_owned())
        };
        let values = [
            ("load, N", wheel.load_n / rows),
            ("sliding speed rms, m/s", (wheel.slip_squared / rows).sqrt()),
            ("friction used, largest share", wheel.friction_used_max),
            ("torque, largest, N m", wheel.torque_max_n_m),
            ("in the air, share of time", airborne),
            ("at its grip limit, share of time", sliding),
        ];
        let values = values.map(|(key, value)| (key.to_owned(), format!("{value:.6}")));
        self.status(
            &format!("wheels/{}", self.wheel_names[index]),
            level,
            message,
            values.into(),
        )
    }
}
