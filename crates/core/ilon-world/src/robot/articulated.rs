//! The bodies of a world: what they are, how they move, and what a step needs of them.

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
use crate::robot::shapes::Shapes;
use crate::robot::shared_robot::{SharedRobot, tree_of};
use crate::robot::state::State;
use crate::robot::wheel::WheelBody;
use crate::settings::ContactSpring;
use crate::{MotorTorque, Settings};

/// A body of a world, articulated, in f64: a robot with chassis, wheels and rollers, or a free
/// body, which is a chassis alone.
///
/// Each moves as if no other were there ([`crate::dynamics`]); what they do to each other and to
/// the ground is solved for all at once ([`crate::contact::reactions`]).
#[derive(Clone)]
pub(crate) struct Articulated {
    pub kind: Kind,
    pub robot: SharedRobot,
    /// Its own units, without what it carries.
    pub scale: Scale,
    /// That of its contacts.
    pub spring: ContactSpring,
    /// What its wheels set against their motors.
    pub wheel_inertia: WheelInertia,
    /// What is joined to what, and weighs how much.
    pub tree: Arc<Tree>,
    /// The tree in the middle of the step, and what acts on it.
    pub mechanics: Mechanics,
    /// The chassis with what it carries.
    pub chassis_mass: MassProperties,
    pub payloads: Vec<Payload>,
    pub state: State,
    pub wheels: Vec<WheelBody>,
    /// The servos in the joints between bodies; one of a joint that nothing drives does nothing.
    pub servos: Vec<Servo>,
    pub memory: Memory,
    pub command: Command,
    pub step: BodyStep,
    pub done: Done,
    /// Whether its equilibrium at the start is looked for: see [Modes](crate#modes-of-a-step).
    pub is_settling: bool,
}

/// What kind of body it is. Robots stand first among the bodies of a world, then free bodies, and
/// within a step coupled bodies.
#[derive(Clone)]
pub(crate) enum Kind {
    Robot,
    Free(Box<Free>),
    /// A body that a program has in rapier, while it takes part in a step: rapier moves it.
    Coupled(Box<Coupled>),
}

/// What lasts of a step beside the state, because the next one depends on it.
#[derive(Clone, Default)]
pub(crate) struct Memory {
    /// Whether something pressed on it: see [Modes](crate#modes-of-a-step).
    pub is_pressed: bool,
    /// By how much its rates grew in a second, by degree of freedom.
    pub gained: Vec<f64>,
    /// What the friction of its contacts, and that of its bearings and gears, gave in steps in
    /// which a motion turned around, and still owes.
    pub friction_owes: Owed,
    pub bearings_owe: Owed,
}

/// What it was asked to do in the coming step.
#[derive(Clone)]
pub(crate) struct Command {
    pub motors: Vec<MotorTorque>,
    /// The wheels' rates when the step began, in rad/s.
    pub rates_asked_rad_s: Vec<f64>,
    /// When the coming part of the step begins, from the middle of the step, in seconds: the
    /// targets of servos are functions of this time.
    pub from_middle_s: f64,
    pub pushes: Vec<ActingPush>,
}

/// The current part of a step, or the last one after it: found anew for each.
#[derive(Clone)]
pub(crate) struct BodyStep {
    /// The state when it began.
    pub before: State,
    /// The poses in its middle; until its reactions are known with the rates of its beginning, then
    /// with the mean of the rates, with which the body moved on and all work goes.
    pub middle: State,
    /// Where the rates of its beginning would take the body by its end.
    pub ahead: State,
    /// Whether it is short beside the time in which a roller passes over the ground: see
    /// [Modes](crate#modes-of-a-step).
    pub resolves_rollers: bool,
    /// Rates by degree of freedom when it began; once it was taken, those in its middle.
    pub rates_before: Vec<f64>,
    /// Rates at its end: without reactions, and once it was taken with them.
    pub rates_free: Vec<f64>,
    /// The linear part of what the motors do, which is solved with the masses.
    pub motors: Vec<MotorTorque>,
    /// What they do with all bounds.
    pub motor_laws: Vec<MotorTorque>,
    /// What springs, motors and bearings lose of their impulse per rate that their joint gains, in
    /// N m s per rad/s or N s per m/s.
    pub held_n_m_s2: Vec<f64>,
    pub loads: Loads,
    /// Room for generalised forces.
    pub forces: Vec<f64>,
    /// Which of its shapes are near the ground.
    pub shapes: Shapes,
}

/// What the last step did: within it the sums over its parts so far.
#[derive(Clone)]
pub(crate) struct Done {
    pub contacts: Vec<WheelContact>,
    /// What carried it.
    pub support: Support,
    /// What the motors put on the wheels, in N m.
    pub acted_n_m: Vec<f64>,
    /// What acted in each joint between bodies, in N m or N; within the step impulses.
    pub joint_forces: Vec<f64>,
    /// What each wheel did.
    pub counts: Vec<WheelCounts>,
}

/// What a wheel did over a step.
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
                ..Memory::default()
            },
            command: Command {
                motors: still.clone(),
                rates_asked_rad_s: vec![0.0; count],
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
                shapes: Shapes::default(),
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

    /// Takes over what the chassis carries now, whose centre of mass is further by `moved_m` in the
    /// body's axes, and which rollers turn.
    pub fn weigh(&mut self, moved_m: Vector3<f64>) {
        let rollers = self.wheels.iter().map(|wheel| wheel.rollers.as_slice());
        self.tree = Arc::new(tree_of(&self.robot, &self.chassis_mass, rollers));
        let tree = Arc::clone(&self.tree);
        for state in self.states_mut() {
            state.recenter(moved_m, &tree);
        }
    }

    /// Its state now and those of the last step, to be placed elsewhere.
    pub fn states_mut(&mut self) -> [&mut State; 4] {
        let step = &mut self.step;
        [
            &mut self.state,
            &mut step.before,
            &mut step.middle,
            &mut step.ahead,
        ]
    }

    /// Begins a step of the world with what was commanded, before any part of it is taken.
    pub fn begin_step(&mut self, dt_s: f64) {
        if let Some(free) = self.free_mut() {
            free.from_robots = Vector3::zeros();
        }
        let rates_rad_s = self.state.wheel_rates_rad_s();
        self.command.rates_asked_rad_s.copy_from_slice(rates_rad_s);
        self.command.from_middle_s = -0.5 * dt_s;
        self.done.counts.fill(WheelCounts::default());
        self.done.support = Support::default();
        self.done.joint_forces.fill(0.0);
    }

    /// Ends a step of the world, which was taken in parts or at once: sums become means, and commands
    /// are forgotten.
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

    /// A wheel's axis among its degrees of freedom.
    pub fn dof_of(&self, wheel: usize) -> usize {
        ROOT_DOFS + self.wheels[wheel].joint
    }
}

impl Articulated {
    /// Whether it is a robot.
    pub fn is_robot(&self) -> bool {
        matches!(self.kind, Kind::Robot)
    }

    /// What it is as a free body, if it is one.
    pub fn free(&self) -> Option<&Free> {
        match &self.kind {
            Kind::Free(free) => Some(free),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn free_mut(&mut self) -> Option<&mut Free> {
        match &mut self.kind {
            Kind::Free(free) => Some(free),
            _ => None,
        }
    }

    /// What it is as a coupled body, if it is one: rapier moves it, and only its contacts are
    /// solved here.
    pub fn coupled(&self) -> Option<&Coupled> {
        match &self.kind {
            Kind::Coupled(coupled) => Some(coupled),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn coupled_mut(&mut self) -> Option<&mut Coupled> {
        match &mut self.kind {
            Kind::Coupled(coupled) => Some(coupled),
            _ => None,
        }
    }

    /// What of a gravity in m/s^2 acts on it here: none on a coupled body, whose weight is among
    /// what rapier does to it.
    pub fn pulled_by(&self, gravity: &Vector3<f64>) -> Vector3<f64> {
        self.coupled().map_or(*gravity, |_| Vector3::zeros())
    }

    /// Its kinetic energy, in J.
    pub fn kinetic_j(&self) -> f64 {
        let robot = (&*self.robot, &self.chassis_mass);
        kinetic_j(robot, &self.state, &self.wheels)
    }

    /// Its potential energy above the origin of the floor's frame, in J, in a gravity given there,
    /// in m/s^2.
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
/// ground the share of the robot's mass, with what it carries in kg, at the rim. On the ground the
/// mean of the wheels, spinning the least.
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
