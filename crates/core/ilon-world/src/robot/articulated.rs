//! The articulated bodies of a world: their properties, their motion, and the data of a step.

use std::sync::Arc;

use ilon_robot::{MassProperties, Robot, Scale, Wheel};
use nalgebra::{Isometry3, Vector3};

use crate::contact::reactions::support::Support;
use crate::contact::reactions::wheel_contact::{Taken, WheelContact};
use crate::contact::reactions::wheel_tally::WheelTally;
use crate::dynamics::{Loads, Mechanics, ROOT_DOFS, Tree};
use crate::free::{Coupled, Free};
use crate::loss::Owed;
use crate::motor_torque::WheelInertia;
use crate::robot::energy::{kinetic_j, potential_j};
use crate::robot::payload::{ActingPush, Payload};
use crate::robot::servo::Servo;
use crate::robot::shared_robot::{SharedRobot, tree_of};
use crate::robot::state::State;
use crate::robot::wheel::WheelBody;
use crate::settings::ContactSpring;
use crate::{MotorTorque, Settings};

/// An articulated body of a world, in f64: a robot with chassis, wheels and rollers, or a free
/// body, which is only a chassis.
///
/// Each first moves as if the others were not there ([`crate::dynamics`]); their reactions on each
/// other and on the ground are solved for all at once ([`crate::contact::reactions`]).
#[derive(Clone)]
pub(crate) struct Articulated {
    pub kind: Kind,
    pub robot: SharedRobot,
    /// Its own units, without its load.
    pub scale: Scale,
    /// The spring of its contacts.
    pub spring: ContactSpring,
    /// The inertia of its wheels for their motors.
    pub wheel_inertia: WheelInertia,
    /// Its structure and masses.
    pub tree: Arc<Tree>,
    /// The tree in the middle of the step, and its loads.
    pub mechanics: Mechanics,
    /// The chassis with its load.
    pub chassis_mass: MassProperties,
    pub payloads: Vec<Payload>,
    pub state: State,
    pub wheels: Vec<WheelBody>,
    /// The servos of the joints between bodies; that of an undriven joint does nothing.
    pub servos: Vec<Servo>,
    pub memory: Memory,
    pub command: Command,
    pub step: BodyStep,
    pub done: Done,
    /// Whether the equilibrium at the start is being searched for: see
    /// [Modes](crate#modes-of-a-step).
    pub is_settling: bool,
}

/// The kind of body. Robots come first among the bodies of a world, then free bodies, and within a
/// step coupled bodies.
#[derive(Clone)]
pub(crate) enum Kind {
    Robot,
    Free(Box<Free>),
    /// A body of the caller in rapier, while it takes part in a step: rapier moves it.
    Coupled(Box<Coupled>),
}

/// Data besides the state that the next step needs.
#[derive(Clone, Default)]
pub(crate) struct Memory {
    /// Whether something pressed on it: see [Modes](crate#modes-of-a-step).
    pub is_pressed: bool,
    /// Increase of its rates per second, by degree of freedom.
    pub gained: Vec<f64>,
    /// The debt of the friction of its contacts, and of its bearings and gears, from steps in which
    /// a motion reversed.
    pub friction_owes: Owed,
    pub bearings_owe: Owed,
    /// Impulses that the motors still owe, in N m s, by wheel. A motor's torque is solved for the
    /// mean of the rates before and after. If rollers hand over, the rates jump within the step and
    /// their mean is another; the next step has the difference.
    pub motors_owe_n_m_s: Vec<f64>,
}

/// The commands for the coming step.
#[derive(Clone)]
pub(crate) struct Command {
    pub motors: Vec<MotorTorque>,
    /// The wheels' rates at the beginning of the step, in rad/s.
    pub rates_asked_rad_s: Vec<f64>,
    /// The length of the step, in seconds.
    pub step_s: f64,
    /// The beginning of the coming part of the step relative to the middle of the step, in seconds:
    /// the targets of servos are functions of this time.
    pub from_middle_s: f64,
    pub pushes: Vec<ActingPush>,
}

/// The current part of a step, or the last one; recomputed for each.
#[derive(Clone)]
pub(crate) struct BodyStep {
    /// The state at its beginning.
    pub before: State,
    /// The poses in its middle; with the rates of its beginning until its reactions are known, then
    /// with the mean rates, with which the body advances and all work is computed.
    pub middle: State,
    /// The state at its end by the rates of its beginning.
    pub ahead: State,
    /// Whether it is short compared with the passage of a roller over the ground: see
    /// [Modes](crate#modes-of-a-step).
    pub resolves_rollers: bool,
    /// Rates at its beginning by degree of freedom; after it was taken, those in its middle.
    pub rates_before: Vec<f64>,
    /// Rates at its end without reactions; after it was taken, with them.
    pub rates_free: Vec<f64>,
    /// The linear part of the motors' torques, which is solved with the masses.
    pub motors: Vec<MotorTorque>,
    /// The motors with all limits.
    pub motor_laws: Vec<MotorTorque>,
    /// Implicit damping: the loss of impulse of springs, motors and bearings per rate gained by
    /// their joint, in N m s per rad/s or N s per m/s.
    pub held_n_m_s2: Vec<f64>,
    pub loads: Loads,
    /// Work space for generalised forces.
    pub forces: Vec<f64>,
}

/// The results of the last step; within it the sums over its parts so far.
#[derive(Clone)]
pub(crate) struct Done {
    pub contacts: Vec<WheelContact>,
    /// The ground's forces on it as a whole.
    pub support: Support,
    /// Torques of the motors on the wheels, in N m.
    pub acted_n_m: Vec<f64>,
    /// Force in each joint between bodies, in N m or N; within the step impulses.
    pub joint_forces: Vec<f64>,
    /// Sums for each wheel.
    pub counts: Vec<WheelCounts>,
}

/// Sums for a wheel over a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelCounts {
    /// Angular impulse of the motor, in N m s.
    pub torque_n_m_s: f64,
    pub taken: Taken,
    /// Of the contact and the motor.
    pub tally: WheelTally,
}

impl Articulated {
    /// A robot at rest with its body frame at a pose.
    pub fn build(
        robot: SharedRobot,
        floor_from_body: &Isometry3<f64>,
        settings: &Settings,
    ) -> Self {
        let tree = Arc::clone(robot.tree());
        let state = State::at_rest(&robot, &tree, floor_from_body);
        let (dofs, count) = (tree.dofs(), robot.wheels.len());
        let scale = Scale::of(&robot, settings.gravity_m_s2);
        let wheels = robot.wheels.iter().zip(robot.rollers_at_rest());
        let first_hub = robot.joints.len();
        let wheels = wheels.enumerate().map(|(index, (wheel, rollers))| {
            // The hubs are the last joints of the tree.
            let wheel = (wheel, robot.has_tyres());
            WheelBody::new(wheel, first_hub + index, rollers, &scale)
        });
        let still = vec![MotorTorque::constant(0.0); count];
        Self {
            kind: Kind::Robot,
            scale,
            spring: ContactSpring::of_robot(settings, &robot, &scale),
            wheel_inertia: wheel_inertia(&robot, 0.0),
            mechanics: Mechanics::of(&tree),
            chassis_mass: robot.chassis.mass.clone(),
            payloads: Vec::new(),
            wheels: wheels.collect(),
            servos: servos_of(&robot),
            memory: Memory {
                gained: vec![0.0; dofs],
                motors_owe_n_m_s: vec![0.0; count],
                ..Memory::default()
            },
            command: Command {
                motors: still.clone(),
                rates_asked_rad_s: vec![0.0; count],
                step_s: settings.dt_s,
                from_middle_s: 0.0,
                pushes: Vec::new(),
            },
            step: BodyStep {
                before: state.clone(),
                middle: state.clone(),
                ahead: state.clone(),
                resolves_rollers: true,
                rates_before: vec![0.0; dofs],
                rates_free: vec![0.0; dofs],
                motors: still.clone(),
                motor_laws: still,
                held_n_m_s2: vec![0.0; tree.joints().len()],
                loads: Loads::none(&tree),
                forces: vec![0.0; dofs],
            },
            done: Done {
                contacts: vec![WheelContact::default(); count],
                support: Support::default(),
                acted_n_m: vec![0.0; count],
                joint_forces: vec![0.0; robot.joints.len()],
                counts: vec![WheelCounts::default(); count],
            },
            is_settling: false,
            state,
            robot,
            tree,
        }
    }

    /// Updates the masses after a change of the chassis's load, which moves its centre of mass by
    /// `moved_m` in the body's axes, or of the rollers that turn.
    pub fn weigh(&mut self, moved_m: Vector3<f64>) {
        let rollers = self.wheels.iter().map(|wheel| wheel.rollers.as_slice());
        self.tree = Arc::new(tree_of(&self.robot, &self.chassis_mass, rollers));
        let tree = Arc::clone(&self.tree);
        for state in self.states_mut() {
            state.recenter(moved_m, &tree);
        }
    }

    /// Moves it up, in metres.
    pub fn raise(&mut self, up_m: f64) {
        for state in self.states_mut() {
            let mut pose = *state.floor_from_chassis();
            pose.translation.z += up_m;
            state.place(pose);
        }
    }

    /// Its current state and those of the last step, for moving it elsewhere.
    pub fn states_mut(&mut self) -> [&mut State; 4] {
        let step = &mut self.step;
        [
            &mut self.state,
            &mut step.before,
            &mut step.middle,
            &mut step.ahead,
        ]
    }

    /// Begins a step of the world with the commands, before any part of it is taken.
    pub fn begin_step(&mut self, dt_s: f64) {
        if let Some(free) = self.free_mut() {
            free.from_robots = Vector3::zeros();
        }
        let rates_rad_s = self.state.wheel_rates_rad_s();
        self.command.rates_asked_rad_s.copy_from_slice(rates_rad_s);
        (self.command.step_s, self.command.from_middle_s) = (dt_s, -0.5 * dt_s);
        self.done.counts.fill(WheelCounts::default());
        self.done.support = Support::default();
        self.done.joint_forces.fill(0.0);
    }

    /// Ends a step of the world, which was taken in parts or at once: sums become means, and
    /// commands are cleared.
    pub fn end_step(&mut self, in_parts: bool, dt_s: f64) {
        if let Some(free) = self.free_mut() {
            free.from_robots /= dt_s;
        }
        let done = &mut self.done;
        for (index, counts) in done.counts.iter_mut().enumerate() {
            counts.tally.end_step(self.state.hubs()[index].center_m.z);
            done.acted_n_m[index] = counts.torque_n_m_s / dt_s;
            let contact = &mut done.contacts[index];
            if in_parts {
                counts.tally.put_means_into(contact);
            }
            contact.slip_power_w = counts.taken.slip_j / dt_s;
            contact.spin_up_power_w = counts.taken.spin_up_j / dt_s;
            contact.impact_power_w = counts.taken.impact_j / dt_s;
        }
        done.support = done.support.over(dt_s);
        done.joint_forces.iter_mut().for_each(|of| *of /= dt_s);
        self.command.pushes.clear();
        self.command.motors.fill(MotorTorque::constant(0.0));
    }

    /// The degree of freedom of a wheel's axis.
    pub fn dof_of(&self, wheel: usize) -> usize {
        ROOT_DOFS + self.wheels[wheel].joint
    }
}

impl Articulated {
    /// Whether it is a robot.
    pub fn is_robot(&self) -> bool {
        matches!(self.kind, Kind::Robot)
    }

    /// Its data as a free body, if it is one.
    pub fn free(&self) -> Option<&Free> {
        match &self.kind {
            Kind::Free(free) => Some(free),
            _ => None,
        }
    }

    /// The same, mutable.
    pub fn free_mut(&mut self) -> Option<&mut Free> {
        match &mut self.kind {
            Kind::Free(free) => Some(free),
            _ => None,
        }
    }

    /// Its data as a coupled body, if it is one: rapier moves it, and only its contacts are solved
    /// here.
    pub fn coupled(&self) -> Option<&Coupled> {
        match &self.kind {
            Kind::Coupled(coupled) => Some(coupled),
            _ => None,
        }
    }

    /// The same, mutable.
    pub fn coupled_mut(&mut self) -> Option<&mut Coupled> {
        match &mut self.kind {
            Kind::Coupled(coupled) => Some(coupled),
            _ => None,
        }
    }

    /// The part of a gravity in m/s^2 that acts on it here: zero for a coupled body, whose weight
    /// is included in rapier's forces.
    pub fn pulled_by(&self, gravity: &Vector3<f64>) -> Vector3<f64> {
        self.coupled().map_or(*gravity, |_| Vector3::zeros())
    }

    /// Its kinetic energy, in J.
    pub fn kinetic_j(&self) -> f64 {
        let robot = (&*self.robot, &self.chassis_mass);
        kinetic_j(robot, &self.state, &self.wheels)
    }

    /// Its potential energy above the origin of the floor's frame, in J, for a gravity in that
    /// frame, in m/s^2.
    pub fn potential_j(&self, gravity: &Vector3<f64>) -> f64 {
        let robot = (&*self.robot, &self.chassis_mass);
        potential_j(robot, &self.state, gravity)
    }
}

fn servos_of(robot: &Robot) -> Vec<Servo> {
    let joints = robot.joints.iter().enumerate();
    let servo = |(index, joint)| Servo::of(joint, robot.inertia_on_joint(index));
    joints.map(servo).collect()
}

/// The inertia of a robot's wheels: their hubs' and their rollers' about their axes, and on the
/// ground the share of the robot's mass, with its load in kg, at the rim. On the ground the mean of
/// the wheels, while spinning the smallest.
pub(crate) fn wheel_inertia(robot: &Robot, carried_kg: f64) -> WheelInertia {
    let count = robot.wheels.len() as f64;
    let spinning_kg_m2 = |wheel: &Wheel| {
        let rollers = wheel.rollers.iter();
        let at_ring = rollers.map(|roller| {
            roller.mass_kg * roller.center_in_hub_m.xy().norm_squared()
                + roller.transverse_inertia_kg_m2
        });
        wheel.hub.inertia_kg_m2[(2, 2)]
            + wheel.drive.reflected_inertia_kg_m2()
            + at_ring.sum::<f64>()
    };
    let share_kg = (robot.mass_kg() + carried_kg) / count;
    let on_ground_kg_m2 =
        |wheel: &Wheel| spinning_kg_m2(wheel) + share_kg * wheel.radius_m * wheel.radius_m;
    let wheels = robot.wheels.iter();
    WheelInertia {
        on_ground_kg_m2: wheels.clone().map(on_ground_kg_m2).sum::<f64>() / count,
        spinning_kg_m2: wheels.map(spinning_kg_m2).fold(f64::INFINITY, f64::min),
    }
}
