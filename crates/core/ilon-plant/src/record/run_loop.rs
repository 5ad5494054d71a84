//! The loop of a run: a plant, its pilot and its recorder.

use ilon_robot::Robot;
use ilon_trace::{Trace, Truth};

use crate::pilot::{Controller, Pilot};
use crate::plant::Plant;
use crate::record::header::{Appearance, header};
use crate::record::recorder::Recorder;
use ilon_scenario::{Error, Resolved};

/// A plant, its pilot and its recorder.
pub struct RunLoop {
    /// The simulated robot.
    pub plant: Plant,
    /// The source of commands.
    pub pilot: Pilot,
    /// The recorder.
    pub recorder: Recorder,
}

impl RunLoop {
    /// The loop of a resolved scenario; `controller`, if given, replaces its guidance.
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

    /// The loop of a resolved scenario under its own guidance, without visual meshes.
    pub fn of_guidance(resolved: &Resolved, robot: &Robot) -> Result<Self, Error> {
        Self::new(resolved, robot, Appearance::default(), None)
    }

    /// Advances by one physics step, or a part of one where something begins or ends within it; after
    /// the last one the final row is recorded.
    pub fn step(&mut self) {
        let clock = *self.plant.clock();
        let t_s = clock.time_s();
        if clock.control_is_due() {
            let seen = self.plant.observe();
            self.pilot.decide(t_s, seen);
            self.recorder.reckon(&seen.wheel_angles_rad);
            self.plant.steer(self.pilot.steering());
        }
        self.plant.actuate(self.pilot.command());
        if clock.control_is_due() {
            self.write_down();
        }
        let part_s = self.plant.step();
        self.recorder.count(self.plant.world(), part_s);
        if self.is_done() {
            let seen = self.plant.observe();
            self.recorder.reckon(&seen.wheel_angles_rad);
            self.pilot.end(self.plant.clock().time_s());
            self.plant.actuate(self.pilot.command());
            self.write_down();
            self.recorder.end();
        }
    }

    /// Passes a control instant to the recorder.
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

    /// Whether the end has been reached.
    pub fn is_done(&self) -> bool {
        self.plant.clock().is_over()
    }

    /// Whether the coming step begins a control period.
    pub fn control_is_due(&self) -> bool {
        self.plant.clock().control_is_due()
    }

    /// The robot's true pose and motion.
    pub fn truth(&self) -> Truth {
        self.plant.truth()
    }

    /// Number of contact searches in the last step.
    pub fn searches(&self) -> u32 {
        self.plant.world().contact_solution().searches
    }

    /// Positions of the joints between its bodies, in rad or m.
    pub fn joint_positions(&self) -> &[f64] {
        self.plant.world().robot().joint_positions()
    }

    /// Time since the start of the run, in seconds.
    pub fn time_s(&self) -> f64 {
        self.plant.clock().time_s()
    }

    /// The rows that have not been taken yet.
    pub fn rows_mut(&mut self) -> &mut Trace {
        self.recorder.trace_mut()
    }
}
