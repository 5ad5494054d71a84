//! Disturbances from outside the robot over time: pushes, payloads, seized rollers, changed floors.

use ilon_robot::{Robot, Wheel};
use ilon_trace::FaultKind;
use ilon_world::{Patch, Payload, Push, World};
use nalgebra::{Rotation3, Vector3};

use crate::faults::recorded;
use crate::faults::tilt::Tilts;
use crate::ground::floor::patches;
use crate::timed::Timed;
use ilon_scenario::Error;
use ilon_scenario::scenario::{Fault, Scenario};

/// The disturbances of a run.
#[derive(Clone)]
pub(crate) struct Disturbances {
    pushes: Vec<TimedPush>,
    payloads: Vec<Timed<Payload>>,
    /// The payload added by the program.
    put_on: Option<Payload>,
    /// The wrench added by the program, which acts until it is changed.
    wrench: Option<Wrench>,
    seizures: Vec<Seizure>,
    patches: Vec<Timed<Patch>>,
    frictions: Vec<Timed<f64>>,
    tilts: Tilts,
    /// Gravity without tilts, once it is known.
    gravity_m_s2: Option<Vector3<f64>>,
    /// A new direction of gravity, until the world has received it.
    new_down: Option<Vector3<f64>>,
    /// The current payloads and friction, so that the world receives only changes.
    carried: Vec<Payload>,
    slippery: (Option<f64>, Vec<Patch>),
    /// When faults and patches begin and end, in seconds, in order.
    changes_s: Vec<f64>,
}

/// A force and a moment on the chassis.
#[derive(Clone, Copy)]
pub(crate) struct Wrench {
    pub force: Push,
    pub moment_in_world_n_m: Vector3<f64>,
}

/// An impulse on the chassis, spread evenly over a time.
#[derive(Clone)]
struct TimedPush {
    impulse_n_s: Vector3<f64>,
    /// Whether its axes are those of the body frame, turned level, instead of the world's.
    in_body: bool,
    place_in_body_m: Vector3<f64>,
    from_s: f64,
    lasts_s: f64,
}

/// A roller that seizes, and whether it has seized.
#[derive(Clone)]
struct Seizure {
    /// The wheel, and the roller on it.
    roller: Timed<(usize, usize)>,
    seized: bool,
}

impl Disturbances {
    /// # Errors
    /// [`Error::Invalid`] for a roller that the robot does not have, an undefined pair of
    /// materials, and a payload that the world refuses.
    pub fn new(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        let patches = patches(scenario, robot)?;
        let windows = scenario.faults.iter().map(Fault::window_s);
        let windows = windows.chain(patches.iter().map(|patch| (patch.from_s, patch.until_s)));
        let mut changes_s: Vec<f64> = windows
            .flat_map(|(from_s, until_s)| std::iter::once(from_s).chain(until_s))
            .collect();
        changes_s.sort_by(f64::total_cmp);
        let mut this = Self {
            changes_s,
            pushes: Vec::new(),
            payloads: Vec::new(),
            put_on: None,
            wrench: None,
            seizures: Vec::new(),
            frictions: Vec::new(),
            tilts: Tilts::new(&scenario.faults),
            gravity_m_s2: None,
            new_down: None,
            carried: Vec::new(),
            slippery: (None, Timed::those_at(&patches, 0.0)),
            patches,
        };
        let recorded = recorded(&scenario.faults, robot)?;
        for (fault, of) in scenario.faults.iter().zip(&recorded) {
            match (fault, &of.kind) {
                (
                    Fault::Push {
                        from_s, lasts_s, ..
                    },
                    FaultKind::Push {
                        impulse_n_s,
                        in_body,
                        place_m,
                    },
                ) => this.pushes.push(TimedPush {
                    impulse_n_s: Vector3::from(*impulse_n_s),
                    in_body: *in_body,
                    place_in_body_m: Vector3::from(*place_m),
                    from_s: *from_s,
                    lasts_s: *lasts_s,
                }),
                (_, FaultKind::Payload { mass_kg, place_m }) if *mass_kg > 0.0 => {
                    let payload = Payload::new(*mass_kg, Vector3::from(*place_m))?;
                    this.payloads.push(during(of, payload));
                }
                (_, FaultKind::RollerStuck { wheel, roller }) => {
                    let roller = roller_index(&robot.wheels[*wheel], *roller)?;
                    this.seizures.push(Seizure {
                        roller: during(of, (*wheel, roller)),
                        seized: false,
                    });
                }
                (_, FaultKind::FrictionChanged { friction }) => {
                    this.frictions.push(during(of, *friction));
                }
                _ => {}
            }
        }
        Ok(this)
    }

    /// Pushes the chassis from a time on with a constant force in the world frame, in N, at a point
    /// in the body frame, in metres.
    pub fn push(
        &mut self,
        now_s: f64,
        force_in_world_n: Vector3<f64>,
        place_in_body_m: Vector3<f64>,
        lasts_s: f64,
    ) {
        // Finished pushes are removed, because they would cost time in every step.
        self.pushes
            .retain(|push| push.from_s + push.lasts_s > now_s);
        self.pushes.push(TimedPush {
            impulse_n_s: force_in_world_n * lasts_s,
            in_body: false,
            place_in_body_m,
            from_s: now_s,
            lasts_s,
        });
    }

    /// Sets the payload, which replaces the one set before.
    pub fn carry(&mut self, payload: Option<Payload>) {
        self.put_on = payload;
    }

    /// Sets the wrench that acts from now on, which replaces the one before.
    pub fn hold(&mut self, wrench: Option<Wrench>) {
        self.wrench = wrench;
    }

    /// Tilts the ground: gravity acts along a unit vector in the world frame.
    pub fn lean(&mut self, down: Vector3<f64>) {
        self.new_down = Some(down);
    }

    /// Returns when the next fault, patch or push begins or ends after a time, all in seconds;
    /// infinite if none does.
    pub fn next_change_s(&self, after_s: f64) -> f64 {
        let next = self.changes_s.partition_point(|at_s| *at_s <= after_s);
        let ends_s = self.pushes.iter().map(|push| push.from_s + push.lasts_s);
        let next_s = self.changes_s.get(next).copied().into_iter();
        let ends_s = ends_s.filter(|end_s| *end_s > after_s);
        next_s.chain(ends_s).fold(f64::INFINITY, f64::min)
    }

    /// Applies the disturbances of the physics step, or part of one, of length `dt_s` that begins
    /// at `t_s`; what begins or ends within it counts as on if it is in the middle.
    pub fn act(&mut self, t_s: f64, dt_s: f64, world: &mut World) {
        let middle_s = t_s + 0.5 * dt_s;
        self.load(middle_s, world);
        self.seize(middle_s, world);
        self.wet(middle_s, world);
        let new_down = self.new_down.take();
        if self.tilts.is_any() || new_down.is_some() {
            let gravity = self
                .gravity_m_s2
                .get_or_insert_with(|| world.gravity_in_world_m_s2());
            if let Some(down) = new_down {
                *gravity = gravity.norm() * down;
            }
            // Evaluated in the middle of the step, so that the step is of second order.
            let turned = self.tilts.turned(middle_s);
            world.lean(&(turned.inverse() * *gravity));
        }
        for push in &self.pushes {
            if let Some(push) = push.during(t_s, dt_s, world) {
                world.robot_mut().push(&push);
            }
        }
        if let Some(wrench) = &self.wrench {
            world.robot_mut().push(&wrench.force);
            world.robot_mut().turn(wrench.moment_in_world_n_m);
        }
    }

    fn load(&mut self, t_s: f64, world: &mut World) {
        let mut carried = Timed::those_at(&self.payloads, t_s);
        carried.extend(self.put_on);
        if carried != self.carried {
            world.robot_mut().carry(&carried);
            self.carried = carried;
        }
    }

    fn seize(&mut self, t_s: f64, world: &mut World) {
        for seizure in &mut self.seizures {
            let seized = seizure.roller.is_on(t_s);
            if seized != seizure.seized {
                let (wheel, roller) = seizure.roller.of;
                world.robot_mut().seize_roller(wheel, roller, seized);
                seizure.seized = seized;
            }
        }
    }

    fn wet(&mut self, t_s: f64, world: &mut World) {
        // The last that is on holds.
        let mut on = self.frictions.iter().rev().filter(|it| it.is_on(t_s));
        let friction = on.next().map(|it| it.of);
        let slippery = (friction, Timed::those_at(&self.patches, t_s));
        if slippery != self.slippery {
            world.set_friction(slippery.0, &slippery.1);
            self.slippery = slippery;
        }
    }
}

impl TimedPush {
    /// The push's share of a step: the whole impulse is applied, whatever the step.
    fn during(&self, t_s: f64, dt_s: f64, world: &World) -> Option<Push> {
        let overlap_s = (t_s + dt_s).min(self.from_s + self.lasts_s) - t_s.max(self.from_s);
        if overlap_s <= 0.0 {
            return None;
        }
        let force_n = self.impulse_n_s / self.lasts_s * (overlap_s / dt_s);
        let force_in_world_n = match self.in_body {
            false => force_n,
            true => {
                let heading_rad = world.robot().state().pose.heading_rad;
                Rotation3::from_axis_angle(&Vector3::z_axis(), heading_rad) * force_n
            }
        };
        Some(Push {
            force_in_world_n,
            place_in_body_m: self.place_in_body_m,
        })
    }
}

/// What a fault does, during the time of the fault.
fn during<T>(fault: &ilon_trace::Fault, of: T) -> Timed<T> {
    Timed {
        of,
        from_s: fault.from_s,
        until_s: fault.until_s,
    }
}

/// The index of a roller on a wheel.
fn roller_index(of: &Wheel, roller: u32) -> Result<usize, Error> {
    let (wheel, count) = (&of.name, of.rollers.len());
    if of.has_tyre() {
        return Err(Error::invalid(
            format!("a roller of the wheel `{wheel}` is to seize, but this wheel has a tyre"),
            "leave the fault out, or let the wheel's motor stop: `motor_lost`",
        ));
    }
    if (roller as usize) < count {
        return Ok(roller as usize);
    }
    Err(Error::invalid(
        format!(
            "roller {roller} of the wheel `{wheel}` is to seize, but this wheel has {count} rollers"
        ),
        format!("they count from 0 to {}", count.saturating_sub(1)),
    ))
}
