//! What can be read of a robot.

use ilon_sim::Plant;
use ilon_sim::world::WheelTally;

use crate::variable::{AXES, Now, Table};

/// Adds all outputs of a plant.
pub(crate) fn outputs(table: &mut Table, plant: &Plant) {
    of_body(table);
    of_wheels(table, plant);
    of_joints(table, plant);
    of_energy(table);
}

fn of_body(table: &mut Table) {
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

/// What a wheel did over the last step of the host.
fn tally<'a>(now: &Now<'a>, wheel: usize) -> &'a WheelTally {
    &now.plant.outcome().wheels[wheel]
}

/// What is read of each wheel: the end of its name, what it is, its unit, and where it is.
type OfWheel = (
    &'static str,
    &'static str,
    &'static str,
    fn(&Now<'_>, usize) -> f64,
);

const OF_WHEEL: [OfWheel; 12] = [
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
    (
        "load",
        "the ground's normal force, mean over the last step",
        "N",
        |now, wheel| tally(now, wheel).normal_force_mean_n(),
    ),
    (
        "force.x",
        "the ground's tangential force, x in the body frame, mean over the last step",
        "N",
        |now, wheel| tally(now, wheel).force_mean_in_body_n().x,
    ),
    (
        "force.y",
        "the ground's tangential force, y in the body frame, mean over the last step",
        "N",
        |now, wheel| tally(now, wheel).force_mean_in_body_n().y,
    ),
    (
        "slip.x",
        "velocity of the rollers' surface over the ground, x in the body frame, mean over the last step while it touched",
        "m/s",
        |now, wheel| tally(now, wheel).sliding_mean_in_body_m_s().x,
    ),
    (
        "slip.y",
        "velocity of the rollers' surface over the ground, y in the body frame, mean over the last step while it touched",
        "m/s",
        |now, wheel| tally(now, wheel).sliding_mean_in_body_m_s().y,
    ),
    (
        "friction",
        "Coulomb's coefficient of friction at the contact, mean over the last step",
        "1",
        |now, wheel| tally(now, wheel).friction_mean(),
    ),
    (
        "friction_used",
        "largest share of the friction limit in use in the last step",
        "1",
        |now, wheel| tally(now, wheel).friction_used_max,
    ),
];

fn of_wheels(table: &mut Table, plant: &Plant) {
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

fn of_joints(table: &mut Table, plant: &Plant) {
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

fn of_energy(table: &mut Table) {
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
