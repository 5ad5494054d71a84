//! Interventions of a program besides driving the wheels: pushes, wrenches, payloads, friction,
//! slopes, and joint commands.

use ilon_world::{ContactSolver, Payload, Push};
use nalgebra::{Matrix6, Vector3};

use super::Plant;
use crate::faults::disturbances::Wrench;
use ilon_scenario::Error;
use ilon_scenario::course::command::JointCommand;

impl Plant {
    /// Pushes the chassis from now on with a constant force in the world frame, in N, for a time in
    /// seconds, at a point in the body frame, in metres, by default at the chassis's centre of
    /// mass. Several pushes add up, and a reset ends them.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite or the time is not above 0.
    pub fn push(
        &mut self,
        force_in_world_n: [f64; 3],
        place_in_body_m: Option<[f64; 3]>,
        lasts_s: f64,
    ) -> Result<(), Error> {
        let place_in_body_m = self.place_or_center(place_in_body_m);
        let force_in_world_n = Vector3::from(force_in_world_n);
        let mut numbers = force_in_world_n.iter().chain(&place_in_body_m);
        let can_be =
            numbers.all(|number| number.is_finite()) && lasts_s.is_finite() && lasts_s > 0.0;
        if !can_be {
            return Err(Error::invalid(
                format!(
                    "the robot cannot be pushed with {:?} N for {lasts_s} s",
                    force_in_world_n.as_slice()
                ),
                "give finite newtons and metres, and a time above 0 s",
            ));
        }
        let now_s = self.clock.time_s();
        self.disturbances
            .push(now_s, force_in_world_n, place_in_body_m, lasts_s);
        Ok(())
    }

    /// Applies a force in N and a moment in N m to the chassis from now on until they are changed,
    /// both in the world frame, the force at a point in the body frame in metres, by default at the
    /// chassis's centre of mass. This is the interface to bodies of another simulator. Pushes are
    /// added, and a reset ends it.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite; the previous wrench then continues.
    pub fn set_wrench(
        &mut self,
        force_in_world_n: [f64; 3],
        moment_in_world_n_m: [f64; 3],
        place_in_body_m: Option<[f64; 3]>,
    ) -> Result<(), Error> {
        let place_in_body_m = self.place_or_center(place_in_body_m);
        let numbers = force_in_world_n.iter().chain(&moment_in_world_n_m);
        if !numbers
            .chain(&place_in_body_m)
            .all(|number| number.is_finite())
        {
            return Err(Error::invalid(
                format!(
                    "{force_in_world_n:?} N and {moment_in_world_n_m:?} N m cannot act on the robot"
                ),
                "give finite newtons, newton metres and metres",
            ));
        }
        let acts = force_in_world_n != [0.0; 3] || moment_in_world_n_m != [0.0; 3];
        self.disturbances.hold(acts.then(|| Wrench {
            force: Push {
                force_in_world_n: force_in_world_n.into(),
                place_in_body_m,
            },
            moment_in_world_n_m: moment_in_world_n_m.into(),
        }));
        Ok(())
    }

    /// Couples the inertia of bodies that another simulator moves to the chassis from now on: an
    /// acceleration a of the chassis, linear at the body frame's origin before angular, then takes
    /// an additional wrench A a there, all along the world's axes, in kg, kg m and kg m^2. A is the
    /// articulated-body inertia of an arm or a pushed box (Featherstone 2008, section 7.1).
    ///
    /// Together with [`Plant::set_wrench`] of the bodies' wrench on a chassis that does not
    /// accelerate, the two simulators are coupled without a delay: contacts and motors move the
    /// true inertia, stable for any mass ratio. All zeros, or a reset, end it.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite, if A is not symmetric or has negative energy,
    /// and if rapier's own solver moves the robot; the previous inertia is then kept.
    pub fn set_articulated_inertia(&mut self, inertia: &[[f64; 6]; 6]) -> Result<(), Error> {
        self.refuse_in_rapier("an articulated inertia")?;
        let inertia = Matrix6::from_fn(|row, column| inertia[row][column]);
        if !is_inertia(&inertia) {
            return Err(Error::invalid(
                format!(
                    "the rows {:?} are no articulated inertia",
                    inertia.transpose().as_slice()
                ),
                "give six rows of six finite numbers, symmetric and without negative energy, linear before angular",
            ));
        }
        let bears = inertia.iter().any(|number| *number != 0.0);
        self.world.robot_mut().attach(bears.then_some(&inertia));
        Ok(())
    }

    /// Tilts the ground from now on: gravity acts along a direction in the world frame, of any
    /// length above 0; [0, 0, -1] is level ground. Tilts of the scenario are added, and a reset
    /// ends it.
    ///
    /// The frame stays the floor's: the inertial forces of a rotating frame are left out, see
    /// [`World::lean`](ilon_world::World::lean).
    ///
    /// # Errors
    /// [`Error::Invalid`] for a direction that is zero or not finite, and if rapier's own solver
    /// moves the robot.
    pub fn set_down(&mut self, down_in_world: [f64; 3]) -> Result<(), Error> {
        self.refuse_in_rapier("ground that leans")?;
        let down = Vector3::from(down_in_world);
        let direction = down.try_normalize(f64::MIN_POSITIVE);
        let direction = direction.filter(|direction| direction.iter().all(|x| x.is_finite()));
        let Some(direction) = direction else {
            return Err(Error::invalid(
                format!("gravity cannot pull along {down_in_world:?}"),
                "give three finite numbers that are not all 0, such as [0, 0, -1]",
            ));
        };
        self.disturbances.lean(direction);
        Ok(())
    }

    /// Refuses features that the world does not have if rapier's own solver moves the robot.
    fn refuse_in_rapier(&self, what: &str) -> Result<(), Error> {
        if self.plan.settings.contacts == ContactSolver::Rapier {
            return Err(Error::invalid(
                format!("{what} is not available with rapier's own solver"),
                "leave `world.solver.contacts` at \"ilon\"",
            ));
        }
        Ok(())
    }

    /// Limits the rollers of a wheel to a share of the ground's friction from now on; 1 for all of
    /// it. A reset ends it.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a wheel that the robot does not have, a share that is negative or
    /// NaN, and if rapier's own solver moves the robot.
    pub fn set_grip(&mut self, wheel: usize, share: f64) -> Result<(), Error> {
        self.refuse_in_rapier("grip of single wheels")?;
        let wheels = self.motors.len();
        if wheel >= wheels || !(share.is_finite() && share >= 0.0) {
            return Err(Error::invalid(
                format!("wheel {wheel} cannot have {share} of the floor's friction"),
                format!(
                    "wheels count from 0 to {}; give a finite share of 0 or more",
                    wheels - 1
                ),
            ));
        }
        self.world.robot_mut().set_grip(wheel, share);
        Ok(())
    }

    /// A point in the body frame, by default the chassis's centre of mass without payload.
    fn place_or_center(&self, place_in_body_m: Option<[f64; 3]>) -> Vector3<f64> {
        let center_m = self.plan.robot.chassis.mass.center_of_mass_m;
        place_in_body_m.map_or(center_m, Vector3::from)
    }

    /// Changes the floor's friction from now on, except on its patches. A fault of the scenario
    /// that changes it overrides this from its own time on.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a friction that is negative or NaN.
    pub fn set_friction(&mut self, friction: f64) -> Result<(), Error> {
        if !(friction.is_finite() && friction >= 0.0) {
            return Err(Error::invalid(
                format!("a floor cannot have a friction of {friction}"),
                "give a finite number of 0 or more",
            ));
        }
        let patches = self.plan.floor.patches.clone();
        self.world.set_friction(Some(friction), &patches);
        Ok(())
    }

    /// Commands the servos of joints between bodies, each by name: a position, a rate, or a torque
    /// or force. Either all commands are accepted or none. The scenario's setpoints no longer hold
    /// for these joints; a reset restores them, and a snapshot includes the last command.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the robot has no such joint, it has no servo, it cannot reach the
    /// position, or a number is not finite.
    pub fn command_joints(&mut self, commands: &[(&str, JointCommand)]) -> Result<(), Error> {
        let indices = commands.iter().map(|(joint, _)| self.joint(joint));
        let indices: Vec<usize> = indices.collect::<Result<_, _>>()?;
        for (index, (name, command)) in indices.iter().zip(commands) {
            self.check_joint(*index, name, *command)?;
        }
        for (index, (_, command)) in indices.into_iter().zip(commands) {
            self.joint_targets.give(index, *command);
        }
        Ok(())
    }

    /// Sends the joints that steer wheels where the pilot wants them, each by its index.
    pub fn steer(&mut self, commands: impl Iterator<Item = (usize, JointCommand)>) {
        commands.for_each(|(joint, command)| self.joint_targets.give(joint, command));
    }

    /// Refuses a command that the servo of a joint cannot execute.
    fn check_joint(&self, index: usize, name: &str, command: JointCommand) -> Result<(), Error> {
        let of = &self.plan.robot.joints[index];
        let [lower, upper] = of.limits;
        if of.servo().is_none() {
            return Err(Error::invalid(
                format!("nothing drives the joint `{name}`"),
                format!("write role = \"driven\" in [robot.joints.{name}]"),
            ));
        }
        if !command.is_finite() {
            return Err(Error::invalid(
                format!("the joint `{name}` was commanded {command:?}, which is not finite"),
                "give finite numbers",
            ));
        }
        match command {
            JointCommand::Position { position, .. } if !(lower..=upper).contains(&position) => {
                Err(Error::invalid(
                    format!(
                        "the joint `{name}` cannot go to {position}: its limits are {lower} and {upper}"
                    ),
                    "give a position between them, or correct the limits in the robot's file",
                ))
            }
            _ => Ok(()),
        }
    }

    /// The index of a joint between bodies.
    fn joint(&self, name: &str) -> Result<usize, Error> {
        let joints = &self.plan.robot.joints;
        joints.iter().position(|of| of.name == name).ok_or_else(|| {
            let known: Vec<&str> = joints.iter().map(|of| of.name.as_str()).collect();
            Error::invalid(
                format!("the robot has no joint `{name}` between bodies"),
                if known.is_empty() {
                    "give one the role `driven` in [robot.joints.NAME]".to_owned()
                } else {
                    format!("name one of: {}", known.join(", "))
                },
            )
        })
    }

    /// Puts a mass in kg on the robot, at its chassis's centre of mass; it replaces the one put
    /// there before, and 0 removes it. The payloads of the scenario's faults are added, and a reset
    /// removes it.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a mass that is negative or NaN, or under which the wheels would sink
    /// into the ground by more than a tenth of their radius.
    pub fn carry(&mut self, mass_kg: f64) -> Result<(), Error> {
        self.carry_at(mass_kg, None)
    }

    /// Like [`Plant::carry`], at a point in the body frame, in metres.
    ///
    /// # Errors
    /// Like [`Plant::carry`], and for a point that is not finite.
    pub fn carry_at(
        &mut self,
        mass_kg: f64,
        place_in_body_m: Option<[f64; 3]>,
    ) -> Result<(), Error> {
        if !(mass_kg.is_finite() && mass_kg >= 0.0) {
            return Err(Error::invalid(
                format!("the robot cannot carry {mass_kg} kg"),
                "give a finite mass of 0 kg or more",
            ));
        }
        let scenario = self.resolved().scenario();
        scenario.check_payload(&self.plan.robot, mass_kg)?;
        let place_in_body_m = self.place_or_center(place_in_body_m);
        let payload = (mass_kg > 0.0).then(|| Payload::new(mass_kg, place_in_body_m));
        self.disturbances.carry(payload.transpose()?);
        Ok(())
    }
}

/// Whether a matrix can be an inertia: symmetric, and without negative energy, except for rounding.
fn is_inertia(inertia: &Matrix6<f64>) -> bool {
    /// Relative to the largest entry: above the rounding of sums of a scene's masses, below what a
    /// robot would feel. Chosen.
    const ROUNDING: f64 = 1e-9;
    let most = inertia.amax();
    let slack = ROUNDING * most;
    let is_symmetric = (inertia - inertia.transpose()).amax() <= slack;
    // This is false for NaN.
    most < f64::INFINITY
        && is_symmetric
        && (most == 0.0
            || (inertia + Matrix6::identity() * (6.0 * slack))
                .cholesky()
                .is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inertia_is_symmetric_and_without_negative_energy() {
        let of = |row: usize, column: usize, entry: f64| {
            let mut inertia = Matrix6::identity();
            inertia[(row, column)] = entry;
            is_inertia(&inertia)
        };
        assert!(is_inertia(&Matrix6::zeros()) && of(0, 0, 2.0));
        assert!(!of(0, 0, -1.0) && !of(0, 0, f64::NAN));
        // Only one of the two triangles has it.
        assert!(!of(0, 1, 0.5) && !of(1, 0, 0.5));
    }
}
