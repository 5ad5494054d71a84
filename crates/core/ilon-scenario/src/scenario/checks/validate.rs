//! Checks of a scenario beyond single keys: required combinations, divisions of time, and
//! meaningful expectations.

use ilon_trace::file::MOST_ROWS;

use super::objection::{Objection, object_if, objection};
use crate::Error;
use crate::scenario::{
    Contacts, Drives, Fault, Motion, Reference, Robot, RollerBodies, Rollers, Scenario, Step,
    Tracked, Twist, WheelLaw, bodies,
};

/// The most physics steps of a run: weeks of computing. Chosen.
const MOST_STEPS: f64 = 1e11;

impl Scenario {
    /// Checks what no single key can: required combinations, the division of time into steps, and
    /// that each expectation bounds something.
    ///
    /// # Errors
    /// [`Error::Invalid`], with the keys at fault.
    pub fn validate(&self) -> Result<(), Error> {
        Ok(self.object()?)
    }

    /// Like [`Self::validate`], with the key at fault as a separate value.
    pub(in crate::scenario) fn object(&self) -> Result<(), Objection> {
        self.object_to_motion()?;
        let Robot {
            rollers,
            roller_bodies,
            ..
        } = self.robot;
        object_if!(
            (rollers, roller_bodies) == (Rollers::AsModelled, RollerBodies::Near),
            "robot.roller_bodies",
            "`robot.rollers` = \"as_modelled\" and `robot.roller_bodies` = \"near\" do not go together: which rollers \
             can touch the ground is known of barrels only",
            "put the shapes of all rollers into the world, `robot.roller_bodies` = \"all\", or take barrels",
        );
        let mut joints = self.robot.joints.iter();
        joints.try_for_each(|(name, joint)| joint.object(name))?;
        self.controller.object()?;
        self.object_to_solver()?;
        bodies::object(&self.world.bodies)?;
        self.object_to_materials()?;
        self.object_to_windows()?;
        let is_shorted = |fault: &Fault| matches!(fault, Fault::MotorLost { shorted: true, .. });
        if let (Some(index), None) = (self.faults.iter().position(is_shorted), &self.motors.dc) {
            return Err(objection!(
                "faults.{index}",
                "`motor_lost` with `shorted` needs the motor's winding, but there is no `[motors.dc]`",
                "write the motor's stall_torque_n_m and no_load_rate_rad_s under [motors.dc], or leave `shorted` out: the motor then turns freely",
            ));
        }
        // Above this frequency samples would alias.
        let most_hz = 0.5 / self.run.control_dt_s;
        let is_too_fast = |fault: &Fault| matches!(fault, Fault::Tilt { frequency_hz, .. } if *frequency_hz > most_hz);
        if let Some(index) = self.faults.iter().position(is_too_fast) {
            return Err(objection!(
                "faults.{index}.tilt.frequency_hz",
                "the ground rocks at more than half the control rate, {most_hz} Hz, so its motion cannot be recorded",
                "write a lower frequency_hz, or a shorter `run.control_dt_s`",
            ));
        }
        let law = self.wheel_loop.law;
        object_if!(
            law == WheelLaw::Passive && self.wheel_loop.latency_s() > 0.0,
            "wheel_loop.latency_s",
            "the passive law does not support `wheel_loop.latency_s`: its gains are derived for torques without delay",
            "leave it out, or choose another `wheel_loop.law`",
        );
        object_if!(
            self.wheel_loop.passive.is_some() && law != WheelLaw::Passive,
            "wheel_loop.passive",
            "`[wheel_loop.passive]` has no effect: `wheel_loop.law` is not \"passive\"",
            "write law = \"passive\", or leave the section out",
        );
        object_if!(
            self.wheel_loop.friction.is_some()
                && !matches!(law, WheelLaw::PrioritisedTorque | WheelLaw::Passive),
            "wheel_loop.friction",
            "`wheel_loop.friction` has no effect: this `wheel_loop.law` does not use grip",
            "write law = \"prioritised_torque\" or \"passive\", or leave the friction out",
        );
        let floor = &self.world.floor;
        object_if!(
            floor.rough.is_some() && floor.height_map.is_some(),
            "world.floor.height_map",
            "`world.floor.rough` and `world.floor.height_map` exclude each other: each replaces the floor's plane",
            "leave one of them out",
        );
        let fusion = self.sensors.fusion.as_ref();
        object_if!(
            self.sensors.imu.is_none() && fusion.is_some_and(|fusion| fusion.gyroscope),
            "sensors.fusion.gyroscope",
            "`sensors.fusion.gyroscope` needs a gyroscope, but there is no `[sensors.imu]`",
            "add `[sensors.imu]`, or leave the key out: the rate of turn then comes from the wheels",
        );
        self.object_to_times()?;
        if self.twist.is_some() {
            self.expect.object_to_tracking()?;
        }
        self.expect.object()
    }

    /// Refuses features that rapier's own solver does not have.
    fn object_to_solver(&self) -> Result<(), Objection> {
        let solver = &self.world.solver;
        if solver.contacts == Contacts::Ilon {
            return Ok(());
        }
        object_if!(
            self.robot.roller_bodies == RollerBodies::Near,
            "robot.roller_bodies",
            "`world.solver.contacts` = \"rapier\" and `robot.roller_bodies` = \"near\" do not go together: every roller \
             is a body of its own there",
            "write `robot.roller_bodies` = \"all\", or let ilon solve the contacts",
        );
        let leans = |fault: &Fault| matches!(fault, Fault::Tilt { .. });
        if let Some(index) = self.faults.iter().position(leans) {
            return Err(objection!(
                "faults.{index}",
                "a tilting ground does not go with `world.solver.contacts` = \"rapier\", where gravity is constant",
                "leave it out, or let ilon solve the contacts",
            ));
        }
        if !self.world.bodies.is_empty() {
            return Err(objection!(
                "world.bodies",
                "`world.solver.contacts` = \"rapier\" and `world.bodies` do not go together: only ilon's solver moves free bodies",
                "leave the bodies out, or let ilon solve the contacts",
            ));
        }
        let (floor, rollers) = (&self.world.floor, &self.rollers);
        let is_there = |of: Option<f64>| of.is_some_and(|of| of > 0.0);
        let floor_drags = is_there(floor.rolling_resistance);
        let rollers_drag = is_there(rollers.rolling_resistance);
        let gives = [
            ("rollers.tread", rollers.tread.is_some()),
            ("rollers.rolling_resistance", rollers_drag),
            ("rollers.bearings", rollers.bearings.is_some()),
            ("rollers.axle_friction", is_there(rollers.axle_friction)),
            ("rollers.axial_play_m", is_there(rollers.axial_play_m)),
            ("world.floor.rolling_resistance", floor_drags),
            ("world.floor.creep", is_there(floor.creep)),
            ("world.floor.sliding", floor.sliding.is_some()),
            ("world.floor.across", floor.across.is_some()),
            ("world.floor.against", floor.against.is_some()),
        ];
        if let Some((key, _)) = gives.into_iter().find(|(_, gives)| *gives) {
            return Err(objection!(
                "{key}",
                "`{key}` is not supported by `world.solver.contacts` = \"rapier\", which has neither treads, bearings and play of rollers nor floors that drag",
                "leave it out, or let ilon solve the contacts",
            ));
        }
        for (key, value) in [
            ("split_dt_s", solver.split_dt_s),
            ("contact_stiffness_n_m", solver.contact_stiffness_n_m),
            ("contact_relaxation_s", solver.contact_relaxation_s),
        ] {
            object_if!(
                value.is_some(),
                "world.solver.{key}",
                "`world.solver.{key}` is a setting of ilon's solver, but `world.solver.contacts` = \"rapier\"",
                "leave it out, or let ilon solve the contacts",
            );
        }
        Ok(())
    }

    fn object_to_motion(&self) -> Result<(), Objection> {
        let playback = self.playback.as_ref();
        let of_joints = playback.filter(|playback| playback.drives == Drives::Joints);
        if let Some(playback) = of_joints {
            playback.object()?;
        }
        match self.motion() {
            Some(Motion::OpenLoop(twist)) => object_to_schedule(twist),
            Some(Motion::Played(playback)) => playback.object(),
            Some(Motion::Tracked(tracked)) => object_to_timing(tracked),
            None => {
                let stand = [
                    self.reference.is_some(),
                    self.twist.is_some(),
                    self.playback.is_some() && of_joints.is_none(),
                ];
                if of_joints.is_some() && stand == [false; 3] {
                    return Err(objection!(
                        "playback.drives",
                        "the log only drives joints, and the wheels have no command",
                        "add a `[twist]` (all zeros to stand still) or a `[reference]`",
                    ));
                }
                let (key, stands) = match stand {
                    [false, false, false] => {
                        let none = "no motion: neither `[twist]` nor `[reference]` nor `[playback]` is there";
                        let lacks_time = "; and the key `run.duration_s` is missing";
                        let further = if self.run.is_open() { lacks_time } else { "" };
                        ("", format!("{none}{further}"))
                    }
                    _ => {
                        let [one, key] = match stand {
                            [_, true, false] => ["reference", "twist"],
                            [true, ..] => ["reference", "playback"],
                            _ => ["twist", "playback"],
                        };
                        let two = format!("two motions, `[{one}]` and `[{key}]`: it takes one");
                        (key, two)
                    }
                };
                Err(objection!(
                    "{key}",
                    "the scenario has {stands}",
                    "write `twist = {{ vx_m_s = 0.3 }}` for a velocity, `[reference.circle]`, `[reference.line]` or another path for the guidance to \
                     follow, or `[playback]` for what a log says",
                ))
            }
        }
    }

    /// Refuses faults and patches that end before they begin.
    fn object_to_windows(&self) -> Result<(), Objection> {
        match self
            .windows_s()
            .find(|(_, from_s, until_s)| until_s.is_some_and(|until_s| until_s <= *from_s))
        {
            None => Ok(()),
            Some((key, from_s, until_s)) => {
                let until_s = until_s.unwrap_or_default();
                Err(objection!(
                    "{key}",
                    "`{key}` never happens: it ends at {until_s} s, before it begins at {from_s} s",
                    "let `until_s` come after `from_s`, or leave it out",
                ))
            }
        }
    }

    /// The time windows of events in the world, each with its key, start and end, in seconds.
    pub fn windows_s(&self) -> impl Iterator<Item = (String, f64, Option<f64>)> {
        let faults = self.faults.iter().enumerate().map(|(index, fault)| {
            let (from_s, until_s) = fault.window_s();
            (format!("faults.{index}"), from_s, until_s)
        });
        let patches = self.world.floor.patches.iter().enumerate();
        let patches = patches.map(|(index, patch)| {
            let key = format!("world.floor.patches.{index}");
            (key, patch.from_s, patch.until_s)
        });
        faults.chain(patches)
    }

    /// Refuses a period for a wheel loop without one, and a period that is not a whole number of
    /// steps or does not divide the control period.
    fn object_to_loop_period(&self) -> Result<(), Objection> {
        let Some(period_s) = self.wheel_loop.period_s else {
            return Ok(());
        };
        let key = "wheel_loop.period_s";
        let section = &self.wheel_loop;
        object_if!(
            !section.takes_whole_steps() && self.sensors.encoders.counts_per_turn.is_none(),
            "{key}",
            "`wheel_loop.period_s` has no effect: a continuous PID acts within each step",
            "leave it out, or set `wheel_loop.timing` to \"sampled\"",
        );
        let control_dt_s = self.run.control_dt_s;
        let step_s = match self.run.physics_dt_s {
            Step::Seconds(dt_s) => dt_s,
            Step::Auto(_) => period_s,
        };
        if is_whole(period_s / step_s) && is_whole(control_dt_s / period_s) {
            return Ok(());
        }
        Err(objection!(
            "{key}",
            "`wheel_loop.period_s` = {period_s} must be a whole number of physics steps, and `run.control_dt_s` = {control_dt_s} a whole \
             number of these periods",
            "set it to {control_dt_s}, the control period, and `run.physics_dt_s` to a whole part of it",
        ))
    }

    fn object_to_times(&self) -> Result<(), Objection> {
        let run = &self.run;
        let (duration_s, control_dt_s) = (run.duration_s, run.control_dt_s);
        self.object_to_loop_period()?;
        if let Step::Seconds(dt_s) = run.physics_dt_s {
            let steps = control_dt_s / dt_s;
            let part_s = control_dt_s / steps.ceil().max(1.0);
            object_if!(
                !is_whole(steps),
                "run.physics_dt_s",
                "`run.control_dt_s` = {control_dt_s} is {steps:.6} physics steps of `run.physics_dt_s` = {dt_s}, \
                 but must be a whole number of them",
                "set `run.physics_dt_s` to {part_s}, which divides it",
            );
            self.object_to_step(dt_s)?;
        }
        if run.is_open() {
            // The duration is known after the log is read; then this check is repeated.
            return match &self.playback {
                Some(_) => Ok(()),
                None => Err(objection!(
                    "run.duration_s",
                    "the key `run.duration_s` is missing",
                    "add `run.duration_s`: simulated time in seconds; only a `playback` can do without: it ends with its log",
                )),
            };
        }
        object_if!(
            duration_s < control_dt_s,
            "run.duration_s",
            "`run.duration_s` = {duration_s} is shorter than one control period, `run.control_dt_s` = {control_dt_s}",
            "lengthen the run or shorten the control period",
        );
        let (periods, most) = (duration_s / control_dt_s, MOST_ROWS as f64);
        let rows = periods / f64::from(run.record_every.max(1));
        let every = (periods / most).ceil();
        object_if!(
            rows > most,
            "run.duration_s",
            "`run.duration_s` = {duration_s} makes {rows:.1e} rows, more than the {most:.0e} of the longest trace",
            "shorten the run, or record less often: `run.record_every` = {every:.0}",
        );
        let latency_s = self.sensors.pose.latency_s;
        object_if!(
            latency_s > duration_s,
            "sensors.pose.latency_s",
            "`sensors.pose.latency_s` = {latency_s} is longer than the run, `run.duration_s` = {duration_s}: no pose would \
             ever arrive",
            "shorten the latency or lengthen the run",
        );
        Ok(())
    }

    /// Refuses physics steps that would never end the run, or that miss poses.
    fn object_to_step(&self, physics_dt_s: f64) -> Result<(), Objection> {
        let duration_s = self.run.duration_s;
        let steps = duration_s / physics_dt_s;
        object_if!(
            !self.run.is_open() && steps > MOST_STEPS,
            "run.duration_s",
            "`run.duration_s` = {duration_s} takes {steps:.1e} physics steps of `run.physics_dt_s` = {physics_dt_s}, where \
             at most {MOST_STEPS:.0e} are taken",
            "shorten the run or lengthen its steps",
        );
        let (rate_hz, most_hz) = (self.sensors.pose.rate_hz.unwrap_or(0.0), 1.0 / physics_dt_s);
        // A relative slack of 1e-9 for rounding.
        object_if!(
            rate_hz * physics_dt_s > 1.0 + 1e-9,
            "sensors.pose.rate_hz",
            "`sensors.pose.rate_hz` = {rate_hz} asks for more than one pose in a physics step, \
             `run.physics_dt_s` = {physics_dt_s}",
            "take poses at {most_hz:.6} Hz at most, or shorten the step",
        );
        Ok(())
    }

    /// Checks that the run can be simulated in physics steps of this length, which
    /// `run.physics_dt_s` may leave open.
    ///
    /// # Errors
    /// [`Error::Invalid`], with the keys at fault.
    pub fn check_step(&self, physics_dt_s: f64) -> Result<(), Error> {
        Ok(self.object_to_step(physics_dt_s)?)
    }
}

/// Whether a number of steps is whole, and at least one. A relative slack of 1e-9 absorbs the
/// rounding of periods such as 1/240 s written with ten digits.
fn is_whole(steps: f64) -> bool {
    steps.round() >= 1.0 && (steps - steps.round()).abs() <= 1e-9 * steps
}

fn object_to_timing(tracked: &Tracked) -> Result<(), Objection> {
    let is_timed = tracked.timing.is_some();
    object_if!(
        is_timed && matches!(tracked.path, Reference::HoldPose { .. }),
        "reference.timing",
        "`reference.timing` needs a path, but the reference holds one pose",
        "leave it out",
    );
    for (key, share) in [
        ("share_of_limits", tracked.share_of_limits),
        ("share_of_grip", tracked.share_of_grip),
    ] {
        object_if!(
            !is_timed && share.is_some(),
            "reference.{key}",
            "`reference.{key}` has no effect without `reference.timing`",
            "leave it out",
        );
    }
    Ok(())
}

fn object_to_schedule(twist: &Twist) -> Result<(), Objection> {
    let mut before_s = twist.rest_s;
    for (index, next) in twist.schedule.iter().enumerate() {
        let (from_s, end_s) = (next.from_s, before_s + twist.ramp_s);
        object_if!(
            from_s < end_s,
            "twist.schedule.{index}.from_s",
            "`twist.schedule.{index}` begins at {from_s} s, while the ramp before it lasts until {end_s} s",
            "order the schedule by `from_s` and leave each ramp its time",
        );
        before_s = from_s;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUN: &str = "robot.file = \"r.urdf\"\ntwist = {}\n[run]\nduration_s = 1.0\n";

    fn scenario(further: &str) -> Result<Scenario, Error> {
        Scenario::from_toml(&format!("{RUN}{further}"), "test", "")
    }

    /// The objection to a scenario, and the text that it points at.
    fn told(further: &str) -> (String, String) {
        let text = format!("{RUN}{further}");
        match Scenario::from_toml(&text, "test", "") {
            Err(Error::Scenario(fault)) => {
                let span = fault.span.offset()..fault.span.offset() + fault.span.len();
                (fault.message.clone(), text[span].to_owned())
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn poses_that_never_arrive_or_come_faster_than_physics_are_refused() {
        let late = told("[sensors.pose]\nlatency_s = 1.5\n");
        assert!(late.0.contains("no pose would ever arrive"), "{}", late.0);
        assert_eq!(late.1, "1.5");
        let fast = "physics_dt_s = 0.005\n[sensors.pose]\nrate_hz =";
        assert!(scenario(&format!("{fast} 200")).is_ok());
        let (message, at) = told(&format!("{fast} 201"));
        assert!(
            message.contains("more than one pose in a physics step"),
            "{message}"
        );
        assert_eq!(at, "201");
    }

    #[test]
    fn what_ends_before_it_begins_is_refused_with_its_key() {
        let fault = "[[faults]]\nmotor_lost = { wheel = \"front_left\", from_s = 0.2, until_s = ";
        for until_s in ["0.1", "0.2"] {
            let (message, _) = told(&format!("{fault}{until_s} }}\n"));
            assert!(message.starts_with("`faults.0` never happens"), "{message}");
        }
        assert!(scenario(&format!("{fault}0.3 }}\n")).is_ok());
        let patch = "[[world.floor.patches]]\nx_m = 0\ny_m = 0\nlength_x_m = 1\nlength_y_m = 1\nfriction = 0.1\nfrom_s = 2\nuntil_s = 1\n";
        let (message, _) = told(patch);
        assert!(
            message.starts_with("`world.floor.patches.0` never happens"),
            "{message}"
        );
    }

    #[test]
    fn keys_of_a_playback_that_would_be_ignored_are_refused() {
        let told = |keys: &str| {
            let text = format!("robot.file = \"r.urdf\"\nrun.duration_s = 1\n[playback]\n{keys}\n");
            match Scenario::from_toml(&text, "test", "") {
                Err(Error::Scenario(fault)) => fault.message.clone(),
                other => panic!("{other:?}"),
            }
        };
        let topic = told("file = \"a.CSV\"\ndrives = \"twist\"\ntopic = \"/cmd_vel\"");
        assert!(
            topic.contains("but `playback.file` is a CSV file"),
            "{topic}"
        );
        let gain = told("file = \"a.csv\"\ndrives = \"twist\"\nangle_gain_per_s = 3");
        assert!(
            gain.contains("does not drive the wheels by their angles"),
            "{gain}"
        );
    }

    #[test]
    fn what_rapiers_solver_does_not_know_is_refused_beside_it() {
        let rapier = "[world.solver]\ncontacts = \"rapier\"\n";
        assert!(scenario(rapier).is_ok());
        for (key, value) in [
            ("split_dt_s", "0.0001"),
            ("contact_stiffness_n_m", "1e6"),
            ("contact_relaxation_s", "0.001"),
        ] {
            let (message, at) = told(&format!("{rapier}{key} = {value}\n"));
            assert!(
                message.contains("is a setting of ilon's solver"),
                "{message}"
            );
            assert_eq!(at, value);
            let by_ilon = format!("[world.solver]\n{key} = {value}\n");
            assert!(scenario(&by_ilon).is_ok(), "{key}");
        }
    }

    #[test]
    fn what_a_setting_makes_wrong_is_shown_in_the_setting() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        std::fs::write(
            &path,
            format!("{RUN}[expect]\nslip_energy_j = {{ max = 1 }}\n"),
        )
        .unwrap();
        let setting = "expect.slip_energy_j.min=2".parse().unwrap();
        match Scenario::load_with(&path, &[setting]) {
            Err(Error::Scenario(fault)) => {
                assert!(fault.message.contains("can never hold"));
                // The bound is in the file, and half of it in the setting.
                assert_eq!(fault.source_code.name(), path.display().to_string());
            }
            other => panic!("{other:?}"),
        }
        let setting = "sensors.pose.latency_s=2".parse().unwrap();
        match Scenario::load_with(&path, &[setting]) {
            Err(Error::Scenario(fault)) => {
                assert_eq!(fault.source_code.name(), crate::scenario::SETTING);
                assert_eq!(fault.span.offset(), "sensors.pose.latency_s = ".len());
            }
            other => panic!("{other:?}"),
        }
    }
}
