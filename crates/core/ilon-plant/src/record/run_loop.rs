//! The loop of a run: a plant, what drives it, and what records it.

use ilon_robot::Robot;
use ilon_trace::{Trace, Truth};

use crate::pilot::{Controller, Pilot};
use crate::plant::Plant;
use crate::record::header::{Appearance, header};
use crate::record::recorder::Recorder;
use ilon_scenario::{Error, Resolved};

/// A plant, what drives it, and what records it.
pub struct RunLoop {
    /// What acts.
    pub plant: Plant,
    /// What decides.
    pub pilot: Pilot,
    /// What is recorded.
    pub recorder: Recorder,
}

impl RunLoop {
    /// The loop of a resolved scenario; `controller` in place of its guidance, where there is one.
    pub fn new(
        resolved: &Resolved,
        robot: &Robot,
        seen: Appearance,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Self, Error> {
        let pilot = Pilot::of(resolved, robot, controller)?;
        let plant = Plant::new(resolved, robot)?;
        let header = header(resolved, robot, seen, &pilot)?;
        let rows = resolved.scenario().run.row_count() as usize;
        let recorder = Recorder::new(header, resolved, robot, resolved.start(), rows)?;
        Ok(Self {
            plant,
            pilot,
            recorder,
        })
    }

    /// The loop of a resolved scenario under its own guidance, of which nobody draws a picture.
    pub fn of_guidance(resolved: &Resolved, robot: &Robot) -> Result<Self, Error> {
        Self::new(resolved, robot, Appearance::default(), None)
    }

    /// Advances by one physics step, and closes the record with a row at the end of the last.
    pub fn step(&mut self) {
        let clock = *self.plant.clock();
        let t_s = clock.time_s();
        if clock.control_is_due() {
            let seen = self.plant.observe();
            self.pilot.decide(t_s, seen);
            self.recorder.reckon(&seen.wheel_angles_rad);
        }
        self.plant.actuate(self.pilot.command());
        if clock.control_is_due() {
            self.write_down();
        }
        self.plant.step();
        self.recorder
            .count(self.plant.world(), clock.physics_dt_s());
        if self.is_done() {
            let seen = self.plant.observe();
            self.recorder.reckon(&seen.wheel_angles_rad);
            self.pilot.end(self.plant.clock().time_s());
            self.plant.actuate(self.pilot.command());
            self.write_down();
            self.recorder.end();
        }
    }

    /// Hands a control instant to the recorder.
    fn write_down(&mut self) {
        let clock = self.plant.clock();
        let t_s = clock.time_s();
        let decided = self.pilot.decided(t_s, self.plant.truth().pose);
        if clock.record_is_due() {
            self.recorder.record(t_s, &self.plant, &decided);
        } else {
            self.recorder.hold(t_s, &self.plant, &decided);
        }
    }

    /// Whether the end is reached.
    pub fn is_done(&self) -> bool {
        self.plant.clock().is_over()
    }

    /// Whether the coming step begins a control period.
    pub fn control_is_due(&self) -> bool {
        self.plant.clock().control_is_due()
    }

    /// Where the robot really is, and how it moves.
    pub fn truth(&self) -> Truth {
        self.plant.truth()
    }

    /// How often the last step looked for contacts.
    pub fn searches(&self) -> u32 {
        self.plant.world().contact_solution().searches
    }

    /// Where the joints between its bodies stand, in rad or m.
    pub fn joint_positions(&self) -> &[f64] {
        self.plant.world().robot().joint_positions()
    }

    /// Time since the start of the run, in seconds.
    pub fn time_s(&self) -> f64 {
        self.plant.clock().time_s()
    }

    /// The rows that nobody has taken yet.
    pub fn rows_mut(&mut self) -> &mut Trace {
        self.recorder.trace_mut()
    }
}
