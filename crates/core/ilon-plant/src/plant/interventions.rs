//! What a program does to a plant beside driving its wheels: pushes, wrenches, payloads, friction, slopes, and commands to joints.

use ilon_world::{ContactSolver, Payload, Push};
use nalgebra::{Matrix6, Vector3};

use super::Plant;
use crate::faults::disturbances::Wrench;
use ilon_scenario::Error;
use ilon_scenario::course::command::JointCommand;

impl Plant {
    /// Pushes the chassis from now on with a constant force in the world frame, in N, for a time in
    /// seconds, at a place in the body frame, in metres; without one, at the chassis's centre of
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

    /// Lets a force in N and a moment in N m act on the chassis from now on until they are changed,
    /// both in the world frame, the force at a place in the body frame in metres, or without one at
    /// the chassis's centre of mass: what another simulator's bodies put on the robot. Pushes come
    /// on top, and a reset ends it.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite; what acted before goes on then.
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

    /// Lets the chassis bear from now on the inertia of something that another simulator moves: of
    /// its acceleration a, linear at the body frame's origin before angular, that takes a wrench A
    /// a there, all along the world's axes, in kg, kg m and kg m^2. A is the articulated-body
    /// inertia of an arm or a pushed box (Featherstone 2008, section 7.1).
    ///
    /// With [`Plant::set_wrench`] of what that thing puts on the chassis where it is not
    /// accelerated, both simulators meet without a delay: contacts and motors move what they really
    /// move, stable whatever weighs more. All zeros, and a reset, end it.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite, where A is not symmetric or has negative
    /// energy, and where rapier's own solver moves the robot; what was borne before goes on then.
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

    /// Lets the ground lean from now on: gravity pulls along a direction in the world frame, of any length above 0;
    /// [0, 0, -1] is level ground. Tilts of the scenario turn it further, and a reset ends it.
    ///
    /// The frame stays the floor's: what a frame that turns would add is left out, as [`World::lean`](ilon_world::World::lean) says.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a direction that is none or not finite, and where rapier's own solver moves the robot.
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

    /// Refuses what the world does not do where rapier's own solver moves the robot.
    fn refuse_in_rapier(&self, what: &str) -> Result<(), Error> {
        if self.plan.settings.contacts == ContactSolver::Rapier {
            return Err(Error::invalid(
                format!("{what} is not to be had where rapier's own solver moves the robot"),
                "leave `world.solver.contacts` at \"ilon\"",
            ));
        }
        Ok(())
    }

    /// Lets the rollers of a wheel find a share of the ground's friction from now on; 1 for all of it. A reset ends it.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a wheel that the robot does not have, a share that is negative or no number, and where rapier's own solver moves
    /// the robot.
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

    /// A place in the body frame, or where none is given the chassis's centre of mass without payload.
    fn place_or_center(&self, place_in_body_m: Option<[f64; 3]>) -> Vector3<f64> {
        let center_m = self.plan.robot.chassis.mass.center_of_mass_m;
        place_in_body_m.map_or(center_m, Vector3::from)
    }

    /// Changes how slippery the floor is from now on, but on its patches. A fault of the scenario that changes it too has the
    /// last word from its own time on.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a friction that is negative or no number.
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

    /// Tells the servos of joints between bodies, each by its name, where to go, how fast, or with
    /// what torque or force to act. All are told, or none. From now on the scenario's setpoints no
    /// longer hold for these joints; a reset brings them back, and a snapshot holds what was last.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the robot has no such joint, nothing drives it, it cannot go there, or
    /// a number is not finite.
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

    /// Refuses what the servo of a joint cannot do.
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
                format!("the joint `{name}` was told {command:?}, which is not finite"),
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

    /// The place of a joint between bodies among the robot's.
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

    /// Puts a mass in kg on the robot, at its chassis's centre of mass, in place of the one put there before; 0 takes it off. It comes
    /// on top of the payloads of the scenario's faults, and a reset takes it off.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a mass that is negative or no number.
    pub fn carry(&mut self, mass_kg: f64) -> Result<(), Error> {
        self.carry_at(mass_kg, None)
    }

    /// Like [`Plant::carry`], at a place in the body frame, in metres.
    ///
    /// # Errors
    /// Like [`Plant::carry`], and for a place that is nowhere.
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
        let place_in_body_m = self.place_or_center(place_in_body_m);
        let payload = (mass_kg > 0.0).then(|| Payload::new(mass_kg, place_in_body_m));
        self.disturbances.carry(payload.transpose()?);
        Ok(())
    }
}

/// Whether a matrix can be the inertia of something: symmetric, and nothing that moves has negative
/// energy, except for rounding.
fn is_inertia(inertia: &Matrix6<f64>) -> bool {
    /// Of the greatest entry. Beyond what sums of a scene's masses round by, and below what a robot would feel.
    const ROUNDING: f64 = 1e-9;
    let most = inertia.amax();
    let slack = ROUNDING * most;
    let is_symmetric = (inertia - inertia.transpose()).amax() <= slack;
    // A number that is none is below nothing.
    most < f64::INFINITY
        && is_symmetric
        && (most == 0.0
            || (inertia + Matrix6::identity() * (6.0 * slack))
                .cholesky()
                .is_some())
}
