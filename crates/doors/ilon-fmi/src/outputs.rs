//! The output variables of a robot.

use ilon_sim::Plant;
use ilon_sim::world::WheelTally;

use crate::variable::{AXES, Now, Table};

/// An output: the name or its suffix, the description, the unit, and how to read it for the index
/// of a wheel, a joint or an axis.
type Output = (
    &'static str,
    &'static str,
    Option<&'static str>,
    fn(&Now<'_>, usize) -> f64,
);

/// A table of outputs, one per line.
macro_rules! outputs {
    ($($name:literal, $about:literal, $unit:expr, |$now:pat_param, $at:pat_param| $read:expr;)*) => {
        &[$(($name, $about, $unit, |$now, $at| $read)),*]
    };
}

const POSE: &[Output] = outputs! {
    "position.x", "body frame's origin in the world, x", Some("m"), |now, _| now.body.pose.x_m;
    "position.y", "body frame's origin in the world, y", Some("m"), |now, _| now.body.pose.y_m;
    "position.z", "body frame's origin in the world, z", Some("m"), |now, _| now.body.height_m;
    "orientation.roll", "roll about the body's x axis", Some("rad"), |now, _| now.body.roll_rad;
    "orientation.pitch", "pitch about the body's y axis", Some("rad"), |now, _| now.body.pitch_rad;
    "orientation.heading", "heading about the floor's normal", Some("rad"), |now, _| now.body.pose.heading_rad;
};

const MOTION: &[Output] = outputs! {
    "velocity", "velocity of the body frame's origin along the body's {} axis", Some("m/s"),
        |now, axis| now.body.velocity_in_body_m_s[axis];
    "angular", "rate about the body's {} axis", Some("rad/s"), |now, axis| now.body.angular_in_body_rad_s[axis];
    "acceleration", "acceleration of the origin along the world's {} axis, mean over the last step", Some("m/s2"),
        |now, axis| now.plant.outcome().acceleration_in_world_m_s2[axis];
};

const SENSED: &[Output] = outputs! {
    "sensed.x", "x as the robot's sensors have it", Some("m"), |now, _| now.seen.pose.x_m;
    "sensed.y", "y as the robot's sensors have it", Some("m"), |now, _| now.seen.pose.y_m;
    "sensed.heading", "heading as the robot's sensors have it", Some("rad"), |now, _| now.seen.pose.heading_rad;
};

const OF_WHEEL: &[Output] = outputs! {
    "angle", "angle about the wheel's axis since the start", Some("rad"),
        |now, wheel| now.plant.world().robot().wheel_angles_rad()[wheel];
    "rate", "rate about the wheel's axis", Some("rad/s"), |now, wheel| now.plant.world().robot().wheel_rates_rad_s()[wheel];
    "sensed_angle", "angle as the encoder counts it", Some("rad"), |now, wheel| now.seen.wheel_angles_rad[wheel];
    "sensed_rate", "rate as the encoder has it", Some("rad/s"), |now, wheel| now.seen.wheel_rates_rad_s[wheel];
    "torque", "what the motor put on the wheel, mean over the last step", Some("N.m"),
        |now, wheel| now.plant.outcome().torques_n_m[wheel];
    "load", "the ground's normal force, mean over the last step", Some("N"), |now, wheel| tally(now, wheel).normal_force_mean_n();
    "force.x", "the ground's tangential force, x in the body frame, mean over the last step", Some("N"),
        |now, wheel| tally(now, wheel).force_mean_in_body_n().x;
    "force.y", "the ground's tangential force, y in the body frame, mean over the last step", Some("N"),
        |now, wheel| tally(now, wheel).force_mean_in_body_n().y;
    "slip.x", "velocity of the rollers' surface over the ground, x in the body frame, mean over the last step while it touched", Some("m/s"),
        |now, wheel| tally(now, wheel).sliding_mean_in_body_m_s().x;
    "slip.y", "velocity of the rollers' surface over the ground, y in the body frame, mean over the last step while it touched", Some("m/s"),
        |now, wheel| tally(now, wheel).sliding_mean_in_body_m_s().y;
    "friction", "Coulomb's coefficient of friction at the contact, mean over the last step", Some("1"),
        |now, wheel| tally(now, wheel).friction_mean();
    "friction_used", "largest share of the friction limit in use in the last step", Some("1"),
        |now, wheel| tally(now, wheel).friction_used_max;
};

const OF_JOINT: &[Output] = outputs! {
    "position", "how far it has moved from zero, in rad or m", None, |now, joint| now.plant.world().robot().joint_positions()[joint];
    "rate", "its rate, in rad/s or m/s", None, |now, joint| now.plant.world().robot().joint_rates()[joint];
};

const ENERGY: &[Output] = outputs! {
    "energy.kinetic", "of all that moves", Some("J"), |now, _| now.plant.world().energy().kinetic_j;
    "energy.potential", "in height and springs", Some("J"), |now, _| now.plant.world().energy().potential_j;
    "energy.motors", "work of the motors since the start", Some("J"), |now, _| now.plant.world().motor_energy_j();
    "energy.outside", "what forces and payload brought since the start", Some("J"), |now, _| now.plant.world().outside_energy_j();
    "energy.slip", "heat of sliding since the start", Some("J"), |now, _| now.plant.world().slip_energy_j();
    "contact_residual", "by how much the laws of contact were broken at worst in the last step", Some("m/s"),
        |now, _| now.plant.outcome().contact_residual_m_s;
};

/// What a wheel did over the last step of the host.
fn tally<'a>(now: &Now<'a>, wheel: usize) -> &'a WheelTally {
    &now.plant.outcome().wheels[wheel]
}

/// Adds all outputs of a plant.
pub(crate) fn outputs(table: &mut Table, plant: &Plant) {
    let mut add = |name: &str, about: &str, (_, _, unit, read): Output, at| {
        table.output(name, about, unit, read, at);
    };
    let robot = plant.robot();
    POSE.iter().for_each(|of| add(of.0, of.1, *of, 0));
    for of in MOTION {
        for (axis, name) in AXES.iter().enumerate() {
            add(
                &format!("{}.{name}", of.0),
                &of.1.replace("{}", name),
                *of,
                axis,
            );
        }
    }
    SENSED.iter().for_each(|of| add(of.0, of.1, *of, 0));
    let wheels = robot.wheels.iter().map(|wheel| &wheel.name);
    let joints = robot.joints.iter().map(|joint| &joint.name);
    add_each(&mut add, "wheel", wheels, OF_WHEEL);
    add_each(&mut add, "joint", joints, OF_JOINT);
    ENERGY.iter().for_each(|of| add(of.0, of.1, *of, 0));
}

/// Adds outputs of each wheel or joint, by number and with its name.
fn add_each<'a>(
    add: &mut impl FnMut(&str, &str, Output, usize),
    kind: &str,
    names: impl Iterator<Item = &'a String>,
    outputs: &[Output],
) {
    for (place, name) in names.enumerate() {
        for of in outputs {
            let (end, about) = (of.0, of.1);
            add(
                &format!("{kind}[{}].{end}", place + 1),
                &format!("{name}: {about}"),
                *of,
                place,
            );
        }
    }
}
