//! Simulated time, counted in whole physics steps so that it never drifts, and CPU time.

use ilon_scenario::scenario;

/// The time of a run.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    physics_dt_s: f64,
    control_dt_s: f64,
    steps_per_control: u64,
    control_periods: u64,
    record_every: u64,
    steps: u64,
    /// The part of the coming step that has already been simulated, in seconds, because a host
    /// advanced by less than a step, or something began or ended within it.
    gone_s: f64,
    /// Number of steps and parts of steps so far.
    moments: u64,
}

impl Clock {
    /// A clock at zero. The duration is rounded to whole control periods, of which there is at
    /// least one.
    pub fn new(run: &scenario::Run, physics_dt_s: f64) -> Self {
        let steps_per_control = (run.control_dt_s / physics_dt_s).round().max(1.0) as u64;
        Self {
            physics_dt_s,
            control_dt_s: run.control_dt_s,
            steps_per_control,
            control_periods: run.control_periods(),
            record_every: u64::from(run.record_every.max(1)),
            steps: 0,
            gone_s: 0.0,
            moments: 0,
        }
    }

    /// Number of steps and parts of steps so far.
    pub fn moments(&self) -> u64 {
        self.moments
    }

    /// Advances by a step, or by the rest of one.
    pub fn tick(&mut self) {
        self.steps += 1;
        self.gone_s = 0.0;
        self.moments += 1;
    }

    /// Advances by a part of a step, in seconds, that leaves some of it.
    pub fn tick_part(&mut self, part_s: f64) {
        self.gone_s += part_s;
        self.moments += 1;
    }

    /// The rest of the coming step, in seconds.
    pub fn left_s(&self) -> f64 {
        self.physics_dt_s - self.gone_s
    }

    /// Seconds since the start. Control instants fall on multiples of the control period to the
    /// last bit.
    pub fn time_s(&self) -> f64 {
        let (periods, rest) = (
            self.steps / self.steps_per_control,
            self.steps % self.steps_per_control,
        );
        periods as f64 * self.control_dt_s + rest as f64 * self.physics_dt_s + self.gone_s
    }

    /// Duration of the run, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.control_periods as f64 * self.control_dt_s
    }

    /// Physics step, in seconds.
    pub fn physics_dt_s(&self) -> f64 {
        self.physics_dt_s
    }

    /// Whether this instant is a row of the trace. The end of the run always is, so that its last
    /// period is recorded.
    pub fn record_is_due(&self) -> bool {
        let period = self.steps / self.steps_per_control;
        self.control_is_due() && (period.is_multiple_of(self.record_every) || self.is_over())
    }

    /// Whether a control period begins at this instant.
    pub fn control_is_due(&self) -> bool {
        self.gone_s == 0.0 && self.steps.is_multiple_of(self.steps_per_control)
    }

    /// Whether the end of the run has been reached.
    pub fn is_over(&self) -> bool {
        self.steps >= self.steps_per_control * self.control_periods
    }
}

/// CPU time spent by this thread, so that other work on the machine does not count.
#[derive(Clone, Copy, Debug)]
pub struct CpuTime {
    start_s: Option<f64>,
}

impl CpuTime {
    /// Starts counting, on this thread.
    pub fn now() -> Self {
        Self {
            start_s: thread_cpu_s(),
        }
    }

    /// Seconds since [`Self::now`]; `None` if the system does not report it.
    pub fn elapsed_s(&self) -> Option<f64> {
        Some(thread_cpu_s()? - self.start_s?)
    }
}

#[cfg(unix)]
fn thread_cpu_s() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

#[cfg(not(unix))]
fn thread_cpu_s() -> Option<f64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_instants_are_exact_multiples_however_odd_the_steps() {
        let run = scenario::Run {
            duration_s: 1.0,
            physics_dt_s: scenario::Step::default(),
            control_dt_s: 0.1,
            record_every: 1,
            roller_angles_hz: None,
            converge: false,
        };
        let mut clock = Clock::new(&run, 0.1 / 3.0);
        let mut instants = Vec::new();
        while !clock.is_over() {
            if clock.control_is_due() {
                instants.push(clock.time_s());
            }
            clock.tick();
        }
        let expected: Vec<f64> = (0..10).map(|k| f64::from(k) * 0.1).collect();
        assert_eq!(instants, expected);
        assert_eq!(clock.time_s(), 1.0);
    }

    /// A host may stop in the middle of a step: no control period begins there, and none is left
    /// out.
    #[test]
    fn no_control_period_begins_within_a_step() {
        let run = scenario::Run {
            duration_s: 1.0,
            physics_dt_s: scenario::Step::default(),
            control_dt_s: 0.2,
            record_every: 1,
            roller_angles_hz: None,
            converge: false,
        };
        let mut clock = Clock::new(&run, 0.1);
        let mut due = Vec::new();
        for _ in 0..4 {
            due.push(clock.control_is_due());
            clock.tick_part(0.04);
            due.push(clock.control_is_due());
            clock.tick();
        }
        let expected = [true, false, false, false, true, false, false, false];
        assert_eq!(due, expected);
        // Four parts and the rests of their steps.
        assert_eq!(clock.moments(), 8);
    }
}
