//! A robot as one articulated body of a world.

use std::sync::Arc;

use ilon_robot::{MassProperties, Robot, Scale, Wheel};
use nalgebra::{Isometry3, Vector3};

use crate::contact::reactions::support::Support;
use crate::contact::reactions::wheel_contact::{Taken, WheelContact};
use crate::contact::reactions::wheel_tally::WheelTally;
use crate::dynamics::{Loads, Mechanics, ROOT_DOFS, Tree};
use crate::free::Free;
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

/// A robot as one articulated body of a world: chassis, wheels and rollers, in f64.
///
/// Each moves as if no other were there ([`crate::dynamics`]); what they do to each other and to the ground is solved for all at once, by
/// [`Reactions`](crate::contact::reactions::Reactions).
#[derive(Clone)]
pub(crate) struct Articulated {
    pub robot: SharedRobot,
    /// Its own units, without what it carries.
    pub scale: Scale,
    /// That of its contacts.
    pub spring: ContactSpring,
    pub wheels: Vec<WheelBody>,
    /// What is joined to what, and weighs how much.
    pub tree: Arc<Tree>,
    /// The tree in the middle of the step, and what acts on it.
    pub mechanics: Mechanics,
    pub loads: Loads,
    /// What of it touches the ground as parry finds it.
    pub shapes: Shapes,
    pub state: State,
    /// The state when the last step began.
    pub before: State,
    /// The poses in the middle of the last step; before its reactions with the rates of its beginning, after them with the
    /// mean of the rates, with which it moved on and all work goes.
    pub middle: State,
    /// Where the rates of the last step's beginning would have taken it by its end.
    pub ahead: State,
    /// Whether the last step was short enough to see rollers pass.
    pub sees_rollers_pass: bool,
    pub contacts: Vec<WheelContact>,
    /// What carried it in the last step; within a step the impulses so far.
    pub support: Support,
    /// What the motors do in the coming step, as far as it is straight: it is solved with the masses.
    pub motors: Vec<MotorTorque>,
    /// What they do with all bounds.
    pub motor_laws: Vec<MotorTorque>,
    /// What the motors put on the wheels in the last step.
    pub acted_n_m: Vec<f64>,
    /// Rates by degree of freedom when the step began, and at its end without reactions.
    pub rates_before: Vec<f64>,
    pub rates_free: Vec<f64>,
    /// Room for generalised forces.
    pub forces: Vec<f64>,
    /// Whether something pressed on it in the last step.
    pub is_touched: bool,
    /// What the friction of its contacts, and that of its bearings and gears, gave in steps in which a motion turned around, and still owes.
    pub friction_owes: Owed,
    pub bearings_owe: Owed,
    /// What acted in each joint between bodies in the last step, in N m or N; within a step the impulses so far.
    pub joint_forces: Vec<f64>,
    /// The servos in these joints; of one that nothing drives it does nothing.
    pub servos: Vec<Servo>,
    /// By how much the rates grew in a second of the last step, by degree of freedom.
    pub gained: Vec<f64>,
    /// Whether it is looked for how it stands at the start, with what is springy taken at the end of each step.
    pub sets_out: bool,
    /// What springs, motors and bearings lose of their impulse in a step per rate that their joint gains, in N m s per rad/s or N s per m/s.
    pub held_n_m_s2: Vec<f64>,
    /// The chassis with what it carries.
    pub chassis_mass: MassProperties,
    pub payloads: Vec<Payload>,
    /// What pushes during the coming step.
    pub pushes: Vec<ActingPush>,
    /// What the motors were asked for when the step began, and the wheels' rates then, in rad/s.
    pub asked: Vec<MotorTorque>,
    pub rates_asked_rad_s: Vec<f64>,
    /// When the coming part of the step begins, counted from the middle of the step, in seconds: what is a function of time goes by it.
    pub from_middle_s: f64,
    /// What each wheel did over the step.
    pub counts: Vec<WheelCounts>,
    /// What its wheels set against their motors.
    pub wheel_inertia: WheelInertia,
    /// What it is where it is no robot but a free body.
    pub free: Option<Box<Free>>,
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
        Self {
            before: state.clone(),
            middle: state.clone(),
            ahead: state.clone(),
            sees_rollers_pass: true,
            state,
            wheels: wheels.collect(),
            mechanics: Mechanics::of(&tree),
            loads: Loads::none(&tree),
            shapes: Shapes::default(),
            contacts: vec![WheelContact::default(); count],
            support: Support::default(),
            motors: vec![MotorTorque::constant(0.0); count],
            motor_laws: vec![MotorTorque::constant(0.0); count],
            acted_n_m: vec![0.0; count],
            rates_before: vec![0.0; dofs],
            rates_free: vec![0.0; dofs],
            forces: vec![0.0; dofs],
            is_touched: false,
            friction_owes: Owed::default(),
            bearings_owe: Owed::default(),
            held_n_m_s2: vec![0.0; tree.joints().len()],
            gained: vec![0.0; dofs],
            sets_out: false,
            joint_forces: vec![0.0; robot.joints.len()],
            servos: servos_of(&robot),
            chassis_mass: robot.chassis.mass.clone(),
            payloads: Vec::new(),
            pushes: Vec::new(),
            asked: vec![MotorTorque::constant(0.0); count],
            rates_asked_rad_s: vec![0.0; count],
            from_middle_s: 0.0,
            counts: vec![WheelCounts::default(); count],
            wheel_inertia: wheel_inertia(&robot, 0.0),
            scale,
            spring: ContactSpring::of(settings, &scale),
            free: None,
            robot,
            tree,
        }
    }

    /// Takes over what the chassis carries now, whose centre of mass is further by `moved_m` in the body's axes, and which rollers turn.
    pub fn weigh(&mut self, moved_m: Vector3<f64>) {
        let rollers = self.wheels.iter().map(|wheel| wheel.rollers.as_slice());
        self.tree = Arc::new(tree_of(&self.robot, &self.chassis_mass, rollers));
        for state in [
            &mut self.state,
            &mut self.before,
            &mut self.middle,
            &mut self.ahead,
        ] {
            state.recenter(moved_m, &self.tree);
        }
    }

    /// A wheel's axis among its degrees of freedom.
    pub fn dof_of(&self, wheel: usize) -> usize {
        ROOT_DOFS + self.wheels[wheel].joint
    }
}

impl Articulated {
    /// Whether rapier moves it: only its contacts are solved here.
    pub fn is_guest(&self) -> bool {
        self.free.as_ref().is_some_and(|free| free.guest.is_some())
    }

    /// What of a gravity in m/s^2 pulls it here: nothing pulls a guest, for its weight is among what rapier does to it.
    pub fn pulled_by(&self, gravity: &Vector3<f64>) -> Vector3<f64> {
        if self.is_guest() {
            Vector3::zeros()
        } else {
            *gravity
        }
    }

    /// Its kinetic energy, in J.
    pub fn kinetic_j(&self) -> f64 {
        let robot = (&*self.robot, &self.chassis_mass);
        kinetic_j(robot, &self.state, &self.wheels)
    }

    /// Its potential energy above the origin of the floor's frame, in J, in a gravity given there, in m/s^2.
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

/// The inertia of a robot's wheels: their hubs' and their rollers' about their axes, and on the ground the share of the robot's mass,
/// with what it carries in kg, at the rim. On the ground the mean of the wheels, spinning the least.
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
