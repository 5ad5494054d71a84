//! Disturbances from outside the robot over time: pushes, payloads, seized rollers, changed floors.

use ilon_robot::Robot;
use ilon_world::{Patch, Payload, Push, World};
use nalgebra::{Rotation3, Vector3};

use crate::faults::tilt::Tilts;
use crate::ground::floor::patches;
use crate::ground::timed_patch::TimedPatch;
use ilon_scenario::Error;
use ilon_scenario::robot::wheel_index;
use ilon_scenario::scenario::{Fault, Frame, Scenario, within};

/// The disturbances of a run.
#[derive(Clone)]
pub(crate) struct Disturbances {
    pushes: Vec<TimedPush>,
    payloads: Vec<(Payload, Fault)>,
    /// The payload added by the program.
    put_on: Option<Payload>,
    /// The wrench added by the program, which acts until it is changed.
    wrench: Option<Wrench>,
    seizures: Vec<Seizure>,
    patches: Vec<TimedPatch>,
    frictions: Vec<Fault>,
    tilts: Tilts,
    /// Gravity without tilts, once it is known.
    gravity_m_s2: Option<Vector3<f64>>,
    /// A new direction of gravity, until the world has received it.
    new_down: Option<Vector3<f64>>,
    /// The current payloads and friction, so that the world receives only changes.
    carried: Vec<Payload>,
    slippery: (Option<f64>, Vec<Patch>),
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
    frame: Frame,
    place_in_body_m: Vector3<f64>,
    from_s: f64,
    lasts_s: f64,
}

/// A roller that seizes, and whether it has seized.
#[derive(Clone)]
struct Seizure {
    wheel: usize,
    roller: usize,
    fault: Fault,
    seized: bool,
}

impl Disturbances {
    /// # Errors
    /// [`Error::Invalid`] for a roller that the robot does not have, an undefined pair of
    /// materials, and a payload that the world refuses.
    pub fn new(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        let patches = patches(scenario, robot)?;
        let center_m = robot.chassis.mass.center_of_mass_m;
        let place = |x_m: Option<f64>, y_m: Option<f64>, z_m: Option<f64>| {
            Vector3::new(
                x_m.unwrap_or(center_m.x),
                y_m.unwrap_or(center_m.y),
                z_m.unwrap_or(center_m.z),
            )
        };
        let mut this = Self {
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
            slippery: (None, TimedPatch::those_at(&patches, 0.0)),
            patches,
        };
        for fault in &scenario.faults {
            match *fault {
                Fault::Push {
                    impulse_x_n_s,
                    impulse_y_n_s,
                    impulse_z_n_s,
                    frame,
                    x_m,
                    y_m,
                    z_m,
                    from_s,
                    lasts_s,
                } => this.pushes.push(TimedPush {
                    impulse_n_s: Vector3::new(impulse_x_n_s, impulse_y_n_s, impulse_z_n_s),
                    frame,
                    place_in_body_m: place(x_m, y_m, z_m),
                    from_s,
                    lasts_s,
                }),
                Fault::Payload {
                    mass_kg,
                    x_m,
                    y_m,
                    z_m,
                    ..
                } if mass_kg > 0.0 => {
                    let payload = Payload::new(mass_kg, place(x_m, y_m, z_m))?;
                    this.payloads.push((payload, fault.clone()));
                }
                Fault::RollerStuck {
                    ref wheel, roller, ..
                } => this.seizures.push(Seizure {
                    wheel: wheel_index(wheel, robot, crate::faults::A_FAULT)?,
                    roller: roller_index(wheel, roller, robot)?,
                    fault: fault.clone(),
                    seized: false,
                }),
                Fault::FrictionChanged { .. } => this.frictions.push(fault.clone()),
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
            frame: Frame::World,
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

    /// Applies the disturbances of the physics step of length `dt_s` that begins at `t_s`.
    pub fn act(&mut self, t_s: f64, dt_s: f64, world: &mut World) {
        self.load(t_s, world);
        self.seize(t_s, world);
        self.wet(t_s, world);
        let new_down = self.new_down.take();
        if self.tilts.is_any() || new_down.is_some() {
            let gravity = self
                .gravity_m_s2
                .get_or_insert_with(|| world.gravity_in_world_m_s2());
            if let Some(down) = new_down {
                *gravity = gravity.norm() * down;
            }
            // Evaluated in the middle of the step, so that the step is of second order.
            let turned = self.tilts.turned(t_s + 0.5 * dt_s);
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
        let on = self.payloads.iter().filter(|(_, fault)| fault.is_on(t_s));
        let carried: Vec<Payload> = on.map(|(payload, _)| *payload).chain(self.put_on).collect();
        if carried != self.carried {
            world.robot_mut().carry(&carried);
            self.carried = carried;
        }
    }

    fn seize(&mut self, t_s: f64, world: &mut World) {
        for seizure in &mut self.seizures {
            let seized = seizure.fault.is_on(t_s);
            if seized != seizure.seized {
                world
                    .robot_mut()
                    .seize_roller(seizure.wheel, seizure.roller, seized);
                seizure.seized = seized;
            }
        }
    }

    fn wet(&mut self, t_s: f64, world: &mut World) {
        let changes = self.frictions.iter().rev();
        let friction = changes
            .filter_map(|fault| match fault {
                Fault::FrictionChanged {
                    friction,
                    from_s,
                    until_s,
                } if within(t_s, *from_s, *until_s) => Some(*friction),
                _ => None,
            })
            .next();
        let slippery = (friction, TimedPatch::those_at(&self.patches, t_s));
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
        let force_in_world_n = match self.frame {
            Frame::World => force_n,
            Frame::Body => {
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

fn roller_index(wheel: &str, roller: u32, robot: &Robot) -> Result<usize, Error> {
    let found = robot.wheels.iter().find(|known| known.name == wheel);
    if found.is_some_and(|wheel| wheel.has_tyre()) {
        return Err(Error::invalid(
            format!("a roller of the wheel `{wheel}` is to seize, but this wheel has a tyre"),
            "leave the fault out, or let the wheel's motor stop: `motor_lost`",
        ));
    }
    let count = found.map_or(0, |wheel| wheel.rollers.len());
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
