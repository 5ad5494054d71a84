//! The variables of a robot, with units and value references.

use ilon_sim::Plant;

use crate::keys::Key;
use crate::outputs::outputs;
use crate::value::Value;
use crate::variable::{AXES, Causality, Slot, Table, Variable};

/// Indices into the inputs. Those of wheels come last, one block for each of [`PER_WHEEL`].
pub(crate) mod set {
    pub const TORQUES: usize = 0;
    pub const FORCE: usize = 1;
    pub const MOMENT: usize = 4;
    pub const PLACE: usize = 7;
    pub const PAYLOAD: usize = 10;
    pub const PAYLOAD_PLACE: usize = 11;
    pub const FRICTION: usize = 14;
    pub const WHEELS: usize = 15;
    /// Inputs per wheel: rate, torque, grip.
    pub const PER_WHEEL: usize = 3;
}

/// All variables of a plant, in the order of their value references.
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
        let unit = key.unit();
        table.add(&key.name, &about, Causality::Parameter, unit, start, slot);
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
    let force = "outside force on the chassis along the world's {} axis";
    let moment = "outside moment on the chassis about the world's {} axis";
    let place = "where the outside force acts, {} in the body frame";
    of_axes(table, "force", force, "N", [0.0; 3], set::FORCE);
    of_axes(table, "moment", moment, "N.m", [0.0; 3], set::MOMENT);
    of_axes(table, "force_place", place, "m", center_m, set::PLACE);
    let about = "mass put on the chassis";
    table.input("payload.mass", about, Some("kg"), 0.0, set::PAYLOAD);
    let place = "where the payload lies, {} in the body frame";
    of_axes(table, "payload", place, "m", center_m, set::PAYLOAD_PLACE);
    let about = "Coulomb's coefficient of friction of the floor, but on its patches";
    let friction = plant.floor_friction();
    table.input("floor.friction", about, Some("1"), friction, set::FRICTION);
    for (wheel, of) in plant.robot().wheels.iter().enumerate() {
        let (number, joint) = (wheel + 1, &of.name);
        let at = set::WHEELS + set::PER_WHEEL * wheel;
        let mut input = |end: &str, about: &str, unit, start, at| {
            table.input(
                &format!("wheel[{number}].{end}"),
                about,
                Some(unit),
                start,
                at,
            );
        };
        let about = format!("rate that the wheel {joint} shall have");
        input("rate_command", &about, "rad/s", 0.0, at);
        let about = format!("torque that the motor of {joint} shall give, within its limits");
        input("torque_command", &about, "N.m", 0.0, at + 1);
        let about = format!("share of the ground's friction that {joint} finds");
        input("grip", &about, "1", 1.0, at + 2);
    }
}

/// An input along each axis; its name replaces `{}` in the description.
fn of_axes(
    table: &mut Table,
    name: &str,
    about: &str,
    unit: &'static str,
    starts: [f64; 3],
    first: usize,
) {
    for (axis, of) in AXES.iter().enumerate() {
        let (name, about) = (format!("{name}.{of}"), about.replace("{}", of));
        table.input(&name, &about, Some(unit), starts[axis], first + axis);
    }
}
