//! What can be set and read of a robot, with units, and under which references.

use ilon_sim::Plant;
use ilon_sim::simulate::Seen;
use ilon_sim::world::{BodyState, WheelContact};

use crate::keys::Key;
use crate::value::Value;

/// What a variable is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Time.
    Independent,
    /// Set between steps.
    Input,
    /// Set once, before a simulation begins.
    Parameter,
    /// Read.
    Output,
}

/// One variable. Its reference is its place in the table.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its structured name.
    pub name: String,
    /// What it is, for a person.
    pub about: String,
    /// What it is for.
    pub causality: Causality,
    /// The name of its unit, where it has one.
    pub unit: Option<&'static str>,
    /// What it is before anybody sets it; of an output what it is at the start.
    pub start: Value,
    pub(crate) slot: Slot,
}

/// Where a variable's value is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Slot {
    Time,
    /// A place among what is set: inputs, and whether torques are commanded.
    Set(usize),
    /// A place among the keys.
    Key(usize),
    /// Read from the plant; the number is the function's own.
    Read(fn(&Now<'_>, usize) -> f64, usize),
}

/// What outputs are read from.
#[derive(Clone, Copy)]
pub(crate) struct Now<'a> {
    pub plant: &'a Plant,
    pub body: &'a BodyState,
    pub seen: &'a Seen,
}

impl std::fmt::Debug for Now<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.plant.fmt(f)
    }
}

/// Places among what is set. Those of wheels come last, one block for each of [`PER_WHEEL`].
pub(crate) mod set {
    pub const TORQUES: usize = 0;
    pub const FORCE: usize = 1;
    pub const MOMENT: usize = 4;
    pub const PLACE: usize = 7;
    pub const PAYLOAD: usize = 10;
    pub const PAYLOAD_PLACE: usize = 11;
    pub const FRICTION: usize = 14;
    pub const WHEELS: usize = 15;
    /// What is set of each wheel: its rate, its torque, its grip.
    pub const PER_WHEEL: usize = 3;
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// All variables of a plant, in the order of their references.
pub fn variables(plant: &Plant, keys: &[Key]) -> Vec<Variable> {
    let mut table = Table(Vec::new());
    let time = Value::Real(0.0);
    table.add(
        "time",
        "simulated time",
        Causality::Independent,
        Some("s"),
        time,
        Slot::Time,
    );
    inputs(&mut table, plant);
    for (index, key) in keys.iter().enumerate() {
        let about = format!("the scenario's key {}", key.path);
        let (slot, start) = (Slot::Key(index), key.value);
        table.add(&key.name, &about, Causality::Parameter, None, start, slot);
    }
    outputs_of_body(&mut table);
    outputs_of_wheels(&mut table, plant);
    outputs_of_joints(&mut table, plant);
    outputs_of_energy(&mut table);
    table.0
}

struct Table(Vec<Variable>);

impl Table {
    fn add(
        &mut self,
        name: &str,
        about: &str,
        causality: Causality,
        unit: Option<&'static str>,
        start: Value,
        slot: Slot,
    ) {
        self.0.push(Variable {
            name: name.to_owned(),
            about: about.to_owned(),
            causality,
            unit,
            start,
            slot,
        });
    }

    fn input(
        &mut self,
        name: &str,
        about: &str,
        unit: Option<&'static str>,
        start: f64,
        at: usize,
    ) {
        let start = Value::Real(start);
        self.add(name, about, Causality::Input, unit, start, Slot::Set(at));
    }

    fn output(
        &mut self,
        name: &str,
        about: &str,
        unit: Option<&'static str>,
        read: fn(&Now<'_>, usize) -> f64,
        of: usize,
    ) {
        let slot = Slot::Read(read, of);
        self.add(name, about, Causality::Output, unit, Value::Real(0.0), slot);
    }
}

fn inputs(table: &mut Table, plant: &Plant) {
    let is_torque = "true: torque commands drive the wheels, false: rate commands do";
    let off = Value::Flag(false);
    table.add(
        "torque_control",
        is_torque,
        Causality::Parameter,
        None,
        off,
        Slot::Set(set::TORQUES),
    );
    let center_m: [f64; 3] = plant.robot().chassis.mass.center_of_mass_m.into();
    for (axis, name) in AXES.iter().enumerate() {
        let about = format!("outside force on the chassis along the world's {name} axis");
        table.input(
            &format!("force.{name}"),
            &about,
            Some("N"),
            0.0,
            set::FORCE + axis,
        );
    }
    for (axis, name) in AXES.iter().enumerate() {
        let about = format!("outside moment on the chassis about the world's {name} axis");
        table.input(
            &format!("moment.{name}"),
            &about,
            Some("N.m"),
            0.0,
            set::MOMENT + axis,
        );
    }
    for (axis, name) in AXES.iter().enumerate() {
        let about = format!("where the outside force acts, {name} in the body frame");
        let start = center_m[axis];
        table.input(
            &format!("force_place.{name}"),
            &about,
            Some("m"),
            start,
            set::PLACE + axis,
        );
    }
    table.input(
        "payload.mass",
        "mass put on the chassis",
        Some("kg"),
        0.0,
        set::PAYLOAD,
    );
    for (axis, name) in AXES.iter().enumerate() {
        let about = format!("where the payload lies, {name} in the body frame");
        let (start, at) = (center_m[axis], set::PAYLOAD_PLACE + axis);
        table.input(&format!("payload.{name}"), &about, Some("m"), start, at);
    }
    let about = "Coulomb's coefficient of friction of the floor, but on its patches";
    table.input(
        "floor.friction",
        about,
        Some("1"),
        plant.floor_friction(),
        set::FRICTION,
    );
    for (wheel, of) in plant.robot().wheels.iter().enumerate() {
        let (number, joint) = (wheel + 1, &of.name);
        let at = set::WHEELS + set::PER_WHEEL * wheel;
        let about = format!("rate that the wheel {joint} shall have");
        table.input(
            &format!("wheel[{number}].rate_command"),
            &about,
            Some("rad/s"),
            0.0,
            at,
        );
        let about = format!("torque that the motor of {joint} shall give, within its limits");
        table.input(
            &format!("wheel[{number}].torque_command"),
            &about,
            Some("N.m"),
            0.0,
            at + 1,
        );
        let about = format!("share of the ground's friction that {joint} finds");
        table.input(
            &format!("wheel[{number}].grip"),
            &about,
            Some("1"),
            1.0,
            at + 2,
        );
    }
}

fn outputs_of_body(table: &mut Table) {
    let mut scalar =
        |name: &str, about: &str, unit, read| table.output(name, about, Some(unit), read, 0);
    scalar(
        "position.x",
        "body frame's origin in the world, x",
        "m",
        |now, _| now.body.pose.x_m,
    );
    scalar(
        "position.y",
        "body frame's origin in the world, y",
        "m",
        |now, _| now.body.pose.y_m,
    );
    scalar(
        "position.z",
        "body frame's origin in the world, z",
        "m",
        |now, _| now.body.height_m,
    );
    scalar(
        "orientation.roll",
        "roll about the body's x axis",
        "rad",
        |now, _| now.body.roll_rad,
    );
    scalar(
        "orientation.pitch",
        "pitch about the body's y axis",
        "rad",
        |now, _| now.body.pitch_rad,
    );
    scalar(
        "orientation.heading",
        "heading about the floor's normal",
        "rad",
        |now, _| now.body.pose.heading_rad,
    );
    for (axis, name) in AXES.iter().enumerate() {
        let about = format!("velocity of the body frame's origin along the body's {name} axis");
        table.output(
            &format!("velocity.{name}"),
            &about,
            Some("m/s"),
            |now, axis| now.body.velocity_in_body_m_s[axis],
            axis,
        );
    }
    for (axis, name) in AXES.iter().enumerate() {
        let about = format!("rate about the body's {name} axis");
        table.output(
            &format!("angular.{name}"),
            &about,
            Some("rad/s"),
            |now, axis| now.body.angular_in_body_rad_s[axis],
            axis,
        );
    }
    for (axis, name) in AXES.iter().enumerate() {
        let about = format!(
            "acceleration of the origin along the world's {name} axis, mean over the last step"
        );
        table.output(
            &format!("acceleration.{name}"),
            &about,
            Some("m/s2"),
            |now, axis| now.plant.outcome().acceleration_in_world_m_s2[axis],
            axis,
        );
    }
    let mut scalar =
        |name: &str, about: &str, unit, read| table.output(name, about, Some(unit), read, 0);
    scalar(
        "sensed.x",
        "x as the robot's sensors have it",
        "m",
        |now, _| now.seen.pose.x_m,
    );
    scalar(
        "sensed.y",
        "y as the robot's sensors have it",
        "m",
        |now, _| now.seen.pose.y_m,
    );
    scalar(
        "sensed.heading",
        "heading as the robot's sensors have it",
        "rad",
        |now, _| now.seen.pose.heading_rad,
    );
}

fn contact<'a>(now: &Now<'a>, wheel: usize) -> &'a WheelContact {
    &now.plant.world().robot().contacts()[wheel]
}

/// What is read of each wheel: the end of its name, what it is, its unit, and where it is.
type OfWheel = (
    &'static str,
    &'static str,
    &'static str,
    fn(&Now<'_>, usize) -> f64,
);

const OF_WHEEL: [OfWheel; 11] = [
    (
        "angle",
        "angle about the wheel's axis since the start",
        "rad",
        |now, wheel| now.plant.world().robot().wheel_angles_rad()[wheel],
    ),
    (
        "rate",
        "rate about the wheel's axis",
        "rad/s",
        |now, wheel| now.plant.world().robot().wheel_rates_rad_s()[wheel],
    ),
    (
        "sensed_angle",
        "angle as the encoder counts it",
        "rad",
        |now, wheel| now.seen.wheel_angles_rad[wheel],
    ),
    (
        "sensed_rate",
        "rate as the encoder has it",
        "rad/s",
        |now, wheel| now.seen.wheel_rates_rad_s[wheel],
    ),
    (
        "torque",
        "what the motor put on the wheel, mean over the last step",
        "N.m",
        |now, wheel| now.plant.outcome().torques_n_m[wheel],
    ),
    ("load", "the ground's normal force", "N", |now, wheel| {
        contact(now, wheel).normal_force_n
    }),
    (
        "force.x",
        "the ground's tangential force, x in the body frame",
        "N",
        |now, wheel| contact(now, wheel).force_in_body_n.x,
    ),
    (
        "force.y",
        "the ground's tangential force, y in the body frame",
        "N",
        |now, wheel| contact(now, wheel).force_in_body_n.y,
    ),
    (
        "slip.x",
        "velocity of the rollers' surface over the ground, x in the body frame",
        "m/s",
        |now, wheel| contact(now, wheel).sliding_in_body_m_s.x,
    ),
    (
        "slip.y",
        "velocity of the rollers' surface over the ground, y in the body frame",
        "m/s",
        |now, wheel| contact(now, wheel).sliding_in_body_m_s.y,
    ),
    (
        "friction",
        "Coulomb's coefficient of friction at the contact",
        "1",
        |now, wheel| contact(now, wheel).friction,
    ),
];

fn outputs_of_wheels(table: &mut Table, plant: &Plant) {
    for (wheel, of) in plant.robot().wheels.iter().enumerate() {
        for (end, about, unit, read) in OF_WHEEL {
            let (name, about) = (
                format!("wheel[{}].{end}", wheel + 1),
                format!("{}: {about}", of.name),
            );
            table.output(&name, &about, Some(unit), read, wheel);
        }
    }
}

fn outputs_of_joints(table: &mut Table, plant: &Plant) {
    for (joint, of) in plant.robot().joints.iter().enumerate() {
        let (number, name) = (joint + 1, &of.name);
        let about = format!("{name}: how far it has moved from zero, in rad or m");
        table.output(
            &format!("joint[{number}].position"),
            &about,
            None,
            |now, joint| now.plant.world().robot().joint_positions()[joint],
            joint,
        );
        let about = format!("{name}: its rate, in rad/s or m/s");
        table.output(
            &format!("joint[{number}].rate"),
            &about,
            None,
            |now, joint| now.plant.world().robot().joint_rates()[joint],
            joint,
        );
    }
}

fn outputs_of_energy(table: &mut Table) {
    let mut scalar = |name: &str, about: &str, read| table.output(name, about, Some("J"), read, 0);
    scalar("energy.kinetic", "of all that moves", |now, _| {
        now.plant.world().energy().kinetic_j
    });
    scalar("energy.potential", "in height and springs", |now, _| {
        now.plant.world().energy().potential_j
    });
    scalar(
        "energy.motors",
        "work of the motors since the start",
        |now, _| now.plant.world().motor_energy_j(),
    );
    scalar(
        "energy.outside",
        "what forces and payload brought since the start",
        |now, _| now.plant.world().outside_energy_j(),
    );
    scalar(
        "energy.slip",
        "heat of sliding since the start",
        |now, _| now.plant.world().slip_energy_j(),
    );
    let about = "by how much the laws of contact were broken at worst in the last step";
    table.output(
        "contact_residual",
        about,
        Some("m/s"),
        |now, _| now.plant.outcome().contact_residual_m_s,
        0,
    );
}
