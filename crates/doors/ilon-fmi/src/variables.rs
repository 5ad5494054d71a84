//! What can be set and read of a robot, with units, and under which references.

use ilon_sim::Plant;

use crate::keys::Key;
use crate::outputs::outputs;
use crate::value::Value;
use crate::variable::{AXES, Causality, Slot, Table, Variable};

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
    outputs(&mut table, plant);
    table.0
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
