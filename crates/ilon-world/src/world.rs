//! The world: a robot on a floor, stepped by rapier.

mod disturbance;
#[cfg(test)]
mod tests;

use ilon_robot::{
    MassProperties as RobotMass, Pose as PlanarPose, Robot, Roller, RollerForm, Twist, Wheel,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::contact::reaction::Part;
use crate::contact::readout::WheelContact;
use crate::contact::solve::{Reactions, Scene};
use crate::contact::window;
use crate::engine::convert;
use crate::engine::shapes::shape_of_roller;
use crate::ground::Ground;
use crate::robot::assembly::Assembly;
use crate::robot::energy::{Energy, energy};
use crate::robot::state::State;
use crate::robot::wheel::RollerState;
use crate::{Floor, RollerBodies, RollerDispatcher, RollerShape, Settings, WorldError};
use disturbance::ActingPush;
pub use disturbance::{Payload, Push};

/// A wheel whose window is wider than needed for this long is built narrower, in seconds.
const WINDOW_PATIENCE_S: f64 = 0.2;

/// A robot in a rapier world.
///
/// One step is: [`World::apply`] the wheel torques, then [`World::step`]. What can be read afterwards is the truth, in
/// f64 and in the project's frames; what a robot's sensors make of it is not this crate's business.
///
/// rapier computes in f32. Positions and wheel angles that only ever grow would lose their small increments there, so
/// the world sums them in f64 and hands rapier the rounded sum before every step.
pub struct World {
    rapier: PhysicsWorld,
    ground: Ground,
    robot: Robot,
    settings: Settings,
    assembly: Assembly,
    windows: Vec<Window>,
    state: State,
    before: State,
    contacts: Vec<WheelContact>,
    /// Of the motors, at the rates with which the coming step begins.
    torques_n_m: Vec<f64>,
    /// How the torques fall per rate gained.
    droops_n_m_s: Vec<f64>,
    /// What the motors put on the wheels at the end of the last step.
    acted_n_m: Vec<f64>,
    slip_energy_j: f64,
    impact_energy_j: f64,
    motor_energy_j: f64,
    bearing_energy_j: f64,
    outside_energy_j: f64,
    /// The chassis without what it carries.
    bare_chassis: RobotMass,
    payloads: Vec<Payload>,
    /// What pushes during the coming step.
    pushes: Vec<ActingPush>,
    reactions: Reactions,
    steps: u64,
}

/// A wheel's contact window and what it has needed lately.
#[derive(Clone, Debug)]
struct Window {
    /// Whether the window moves at all, or the shapes of all rollers are in the world for good.
    moves: bool,
    shapes: Vec<RollerShape>,
    /// The rollers in reach now.
    needed: Vec<usize>,
    /// The rollers that the slots shall stand for.
    slots: Vec<usize>,
    /// Steps since the window was last needed at its full width.
    idle_steps: u32,
}

/// The chassis as seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Position of the body frame's origin in the ground plane and heading.
    pub pose: PlanarPose,
    /// Height of the body frame's origin, in metres.
    pub height_m: f64,
    /// Roll about the body's x axis, in radians.
    pub roll_rad: f64,
    /// Pitch about the body's y axis, in radians.
    pub pitch_rad: f64,
    /// Velocity of the body frame's origin and yaw rate, in the body frame as it stood at the start of the last step.
    ///
    /// That is where the step solved the contacts that gave this velocity. Resolved in the frame at the step's end it
    /// would seem to drift sideways by v omega dt while turning, which no wheel ever did.
    pub twist_in_body: Twist,
}

impl World {
    /// Builds a robot standing on a floor with its body frame at `start`, at rest, its wheels just touching.
    ///
    /// On a slope `start` counts in the slope's own plane; on a rough floor the robot is put down onto the highest
    /// point beneath it.
    pub fn new(
        robot: &Robot,
        floor: &Floor,
        start: PlanarPose,
        settings: &Settings,
    ) -> Result<Self, WorldError> {
        check(robot, floor, settings)?;
        let mut rapier = PhysicsWorld {
            integration_parameters: integration_parameters(settings),
            narrow_phase: NarrowPhase::with_query_dispatcher(RollerDispatcher),
            ..PhysicsWorld::default()
        };
        let mut ground = floor.insert(&mut rapier.colliders);

        let state = State::at_rest(robot, &standing(robot, floor, start));
        let place_m = state.floor_from_chassis.translation.vector;
        ground.follow(&place_m, &mut rapier.colliders);
        rapier.gravity = convert::vector(&ground.gravity_in_floor(settings.gravity_m_s2));
        let state_of = |roller| RollerState::new(roller, settings.dt_s);
        let rollers: Vec<Vec<RollerState>> = robot
            .wheels
            .iter()
            .map(|wheel| wheel.rollers.iter().map(state_of).collect())
            .collect();
        let slots: Vec<Vec<usize>> = robot
            .wheels
            .iter()
            .map(|wheel| match settings.roller_bodies {
                RollerBodies::Near if alike(wheel) => vec![0],
                _ => (0..wheel.rollers.len()).collect(),
            })
            .collect();
        let assembly = Assembly::build(
            &mut rapier,
            robot,
            &state.seen_from(&ground),
            &rollers,
            &slots,
        );
        let windows = robot.wheels.iter().zip(slots).map(|(wheel, slots)| Window {
            moves: settings.roller_bodies == RollerBodies::Near && alike(wheel),
            shapes: wheel
                .rollers
                .iter()
                .map(|r| RollerShape::new(&wheel.barrel(r)))
                .collect(),
            needed: Vec::with_capacity(wheel.rollers.len()),
            slots,
            idle_steps: 0,
        });
        let mut world = Self {
            windows: windows.collect(),
            ground,
            before: state.clone(),
            state,
            contacts: vec![WheelContact::default(); robot.wheels.len()],
            torques_n_m: vec![0.0; robot.wheels.len()],
            droops_n_m_s: vec![0.0; robot.wheels.len()],
            acted_n_m: vec![0.0; robot.wheels.len()],
            slip_energy_j: 0.0,
            impact_energy_j: 0.0,
            motor_energy_j: 0.0,
            bearing_energy_j: 0.0,
            outside_energy_j: 0.0,
            bare_chassis: robot.chassis.mass.clone(),
            payloads: Vec::new(),
            pushes: Vec::new(),
            reactions: Reactions::default(),
            steps: 0,
            robot: robot.clone(),
            settings: settings.clone(),
            assembly,
            rapier,
        };
        world.move_windows();
        Ok(world)
    }

    /// Sets the torques that the motors put on the wheels during the next step, in N m, one a wheel; the chassis takes
    /// the opposite. They hold for one step.
    pub fn apply(&mut self, torques_n_m: &[f64]) {
        self.torques_n_m.copy_from_slice(torques_n_m);
        self.droops_n_m_s.fill(0.0);
    }

    /// As [`World::apply`], with torques that fall as the wheels gain speed during the step: by `droops_n_m_s`, in
    /// N m s/rad and not below 0, times the rate gained since the step began.
    ///
    /// A motor with back-EMF is of that kind, and a wheel loop that runs faster than the step. It is solved implicitly,
    /// and stable for any droop.
    pub fn apply_with_droop(&mut self, torques_n_m: &[f64], droops_n_m_s: &[f64]) {
        self.torques_n_m.copy_from_slice(torques_n_m);
        self.droops_n_m_s.copy_from_slice(droops_n_m_s);
    }

    /// Advances the world by one physics step.
    pub fn step(&mut self) {
        self.before.copy_from(&self.state);
        self.keep_spins();
        self.drive();
        self.begin_pushes();
        self.rapier.step();
        self.steps += 1;
        self.react();
        self.read_state();
        self.read_contacts();
        self.run_bearings();
        self.end_pushes();
        self.write_back();
        self.move_windows();
        self.place_wheels();
        self.torques_n_m.fill(0.0);
        self.droops_n_m_s.fill(0.0);
    }

    /// Simulated time since the start, in seconds.
    pub fn time_s(&self) -> f64 {
        self.steps as f64 * self.settings.dt_s
    }

    /// Length of one step, in seconds.
    pub fn dt_s(&self) -> f64 {
        self.settings.dt_s
    }

    /// Pose and velocity of the body.
    pub fn body(&self) -> BodyState {
        let center_m = self.robot.chassis.mass.center_of_mass_m;
        let floor_from_body = self.state.floor_from_chassis * Translation3::from(-center_m);
        let world_from_body = self.ground.world_from_floor() * floor_from_body;
        let position = world_from_body.translation.vector;
        let (roll_rad, pitch_rad, heading_rad) = world_from_body.rotation.euler_angles();
        let body_from_floor = self.before.floor_from_chassis.rotation.inverse();
        let angular_in_body = body_from_floor * self.state.angular_rad_s;
        let velocity_in_body =
            body_from_floor * self.state.velocity_m_s - angular_in_body.cross(&center_m);
        BodyState {
            pose: PlanarPose {
                x_m: position.x,
                y_m: position.y,
                heading_rad,
            },
            height_m: position.z,
            roll_rad,
            pitch_rad,
            twist_in_body: Twist::new(velocity_in_body.x, velocity_in_body.y, angular_in_body.z),
        }
    }

    /// Angles of the wheels about their hub axes since the start, in rad, not wrapped.
    pub fn wheel_angles_rad(&self) -> &[f64] {
        &self.state.wheel_angles_rad
    }

    /// Rates of the wheels about their hub axes, in rad/s.
    pub fn wheel_rates_rad_s(&self) -> &[f64] {
        &self.state.wheel_rates_rad_s
    }

    /// Torques that the motors put on the wheels during the last step, in N m.
    pub fn motor_torques_n_m(&self) -> &[f64] {
        &self.acted_n_m
    }

    /// Height of a wheel's centre above the floor's plane, level or not, in metres.
    pub fn hub_height_m(&self, wheel: usize) -> f64 {
        self.state.floor_from_hub(wheel).translation.vector.z
    }

    /// What each wheel's rollers did to the ground during the last step.
    pub fn contacts(&self) -> &[WheelContact] {
        &self.contacts
    }

    /// By how much the laws of contact and of dry friction were broken at the worst place in the last step, in m/s or
    /// rad/s: the speed at which something moves that should not.
    pub fn reaction_error(&self) -> f64 {
        self.reactions.error()
    }

    /// Energy that sliding at the contacts has turned into heat since the start, in J.
    pub fn slip_energy_j(&self) -> f64 {
        self.slip_energy_j
    }

    /// Energy that the contacts' normal forces have taken since the start, in J: hits that do not bounce, less what
    /// pushing rollers out of the ground gave back.
    pub fn impact_energy_j(&self) -> f64 {
        self.impact_energy_j
    }

    /// Work of the motors on the wheels since the start, in J; negative where they braked.
    pub fn motor_energy_j(&self) -> f64 {
        self.motor_energy_j
    }

    /// Energy that the bearings of wheels and rollers have turned into heat since the start, in J.
    pub fn bearing_energy_j(&self) -> f64 {
        self.bearing_energy_j
    }

    /// Kinetic and potential energy of the robot now.
    pub fn energy(&self) -> Energy {
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        energy(&self.robot, &self.state, &gravity, &self.assembly.wheels)
    }

    /// Spins of all rollers of a wheel about their own axes against the hub, in rad/s, in the robot's order.
    pub fn roller_spins_rad_s(&self, wheel: usize) -> Vec<f64> {
        let hub_rate_in_hub = self.state.hub_rate_in_hub(wheel);
        let rollers = self.assembly.wheels[wheel].rollers.iter();
        rollers
            .map(|roller| roller.spin_rad_s(&hub_rate_in_hub))
            .collect()
    }

    /// How many rollers of each wheel can touch the world now.
    pub fn roller_body_counts(&self) -> Vec<usize> {
        self.assembly
            .wheels
            .iter()
            .map(|wheel| wheel.slots.len())
            .collect()
    }

    /// Hands rapier the motors' torques, and what the rollers put on the hubs.
    fn drive(&mut self) {
        let mut reaction = Vector3::zeros();
        for (index, torque_n_m) in self.torques_n_m.iter().enumerate() {
            let wheel = &self.assembly.wheels[index];
            let floor_from_hub = self.state.floor_from_hub(index).rotation;
            let hub_rate_in_hub = self.state.hub_rate_in_hub(index);
            // rapier's damping takes droop x rate off; only droop x (rate - rate now) shall go.
            let undamped_n_m = self.droops_n_m_s[index] * self.state.wheel_rates_rad_s[index];
            let torque = floor_from_hub * Vector3::z() * (torque_n_m + undamped_n_m);
            let hub = &mut self.rapier.bodies[wheel.hub];
            hub.reset_torques(false);
            let rollers = floor_from_hub * wheel.torque_of_rollers_in_hub(&hub_rate_in_hub);
            hub.add_torque(convert::vector(&(torque + rollers)), false);
            reaction -= torque;
        }
        let chassis = &mut self.rapier.bodies[self.assembly.chassis];
        chassis.reset_torques(false);
        chassis.add_torque(convert::vector(&reaction), false);
        self.assembly
            .set_droops(&mut self.rapier, &self.robot, &self.droops_n_m_s);
    }

    /// Solves for the reactions of the step that rapier has just taken without any, and corrects the rates by them.
    fn react(&mut self) {
        self.reactions.react(&Scene {
            rapier: &self.rapier,
            ground: &self.ground,
            robot: &self.robot,
            assembly: &self.assembly,
            before: &self.before,
            dt_s: self.settings.dt_s,
        });
        let multibody = self.assembly.multibody_mut(&mut self.rapier);
        let mut rates = multibody.generalized_velocity_mut();
        for (dof, change) in self.reactions.change().iter().enumerate() {
            rates[dof] = (f64::from(rates[dof]) + change) as Real;
        }
        let wheels = &mut self.assembly.wheels;
        for roller in wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
            roller.touched = false;
        }
        for touched in self.reactions.touched() {
            let roller = &mut wheels[touched.wheel].rollers[touched.roller];
            roller.axial_rate_rad_s = touched.rate_rad_s;
            roller.touched = true;
        }
    }

    /// Takes rapier's velocities over and sums positions and angles in f64 as rapier does in f32: with the velocity
    /// after the step.
    fn read_state(&mut self) {
        let dt_s = self.settings.dt_s;
        let rate = |dof: usize| self.assembly.rate(&self.rapier, dof);
        let state = &mut self.state;
        state.velocity_m_s = Vector3::new(rate(0), rate(1), rate(2));
        state.angular_rad_s = Vector3::new(rate(3), rate(4), rate(5));
        state.floor_from_chassis.translation.vector += dt_s * state.velocity_m_s;
        state.floor_from_chassis.rotation =
            UnitQuaternion::new(dt_s * state.angular_rad_s) * state.floor_from_chassis.rotation;
        for (index, wheel) in self.assembly.wheels.iter().enumerate() {
            let rate_rad_s = rate(wheel.hub_dof);
            state.wheel_rates_rad_s[index] = rate_rad_s;
            state.wheel_angles_rad[index] += dt_s * rate_rad_s;
            let before_rad_s = self.before.wheel_rates_rad_s[index];
            let fallen_n_m = self.droops_n_m_s[index] * (rate_rad_s - before_rad_s);
            self.acted_n_m[index] = self.torques_n_m[index] - fallen_n_m;
            let mean_rad_s = 0.5 * (before_rad_s + rate_rad_s);
            self.motor_energy_j += dt_s * self.acted_n_m[index] * mean_rad_s;
        }
    }

    /// Reads the contacts of the last step at the poses where they were solved, and counts the work that they took, the
    /// chassis's too where it scrapes along.
    fn read_contacts(&mut self) {
        let dt_s = self.settings.dt_s;
        for (index, contact) in self.contacts.iter_mut().enumerate() {
            let wheel = (index, &self.assembly.wheels[index]);
            let (before, after) = (&self.before, &self.state);
            *contact = WheelContact::read(self.reactions.all(), wheel, before, after, dt_s);
            self.slip_energy_j += contact.slip_power_w * dt_s;
            self.impact_energy_j += contact.impact_power_w * dt_s;
        }
        for reaction in self.reactions.all() {
            if reaction.part != Part::Chassis {
                continue;
            }
            let center_m = self.before.floor_from_chassis.translation.vector;
            let lever_m = reaction.at_m - center_m;
            let of = |state: &State| state.velocity_m_s + state.angular_rad_s.cross(&lever_m);
            let mean_m_s = 0.5 * (of(&self.before) + of(&self.state));
            let (pressed, rubbed) = reaction.on_robot_n_s();
            self.slip_energy_j -= rubbed.dot(&mean_m_s);
            self.impact_energy_j -= pressed.dot(&mean_m_s);
        }
    }

    /// Notes the spins with which the rollers go into the step.
    fn keep_spins(&mut self) {
        for (index, wheel) in self.assembly.wheels.iter_mut().enumerate() {
            let hub_rate_in_hub = self.state.hub_rate_in_hub(index);
            for roller in &mut wheel.rollers {
                roller.spin_before_rad_s = roller.spin_rad_s(&hub_rate_in_hub);
            }
        }
    }

    /// Lets the bearings act on rollers that nothing touched, and sums what damping and dry friction took out of all of
    /// them. Damping acts with the rate after the step, with which it is solved; all work goes with the mean rate.
    fn run_bearings(&mut self) {
        let dt_s = self.settings.dt_s;
        let mut lost_j = 0.0;
        for (index, (body, wheel)) in (self.assembly.wheels.iter_mut())
            .zip(&self.robot.wheels)
            .enumerate()
        {
            let hub_rate_in_hub = self.state.hub_rate_in_hub(index);
            body.bearing_torque_in_hub_n_m = Vector3::zeros();
            for roller in &mut body.rollers {
                let borne = if roller.touched {
                    roller.bear(&hub_rate_in_hub, dt_s)
                } else {
                    roller.coast(&hub_rate_in_hub, dt_s)
                };
                lost_j += borne.lost_j;
                body.bearing_torque_in_hub_n_m += borne.torque_on_hub_n_m * roller.axis_in_hub;
                roller.angle_rad += roller.spin_rad_s(&hub_rate_in_hub) * dt_s;
            }
            let after_rad_s = self.state.wheel_rates_rad_s[index];
            let mean_rad_s = 0.5 * (self.before.wheel_rates_rad_s[index] + after_rad_s);
            lost_j += wheel.joint.damping_n_m_s * after_rad_s * mean_rad_s * dt_s;
        }
        for reaction in self.reactions.all() {
            let (before_rad_s, after_rad_s) = match reaction.part {
                Part::Hub(wheel) => (
                    self.before.wheel_rates_rad_s[wheel],
                    self.state.wheel_rates_rad_s[wheel],
                ),
                Part::Axle(wheel, roller) => {
                    let roller = &self.assembly.wheels[wheel].rollers[roller];
                    let hub_rate_in_hub = self.state.hub_rate_in_hub(wheel);
                    (
                        roller.spin_before_rad_s,
                        roller.spin_rad_s(&hub_rate_in_hub),
                    )
                }
                Part::Chassis | Part::Roller(..) => continue,
            };
            lost_j -= reaction.impulse.x * 0.5 * (before_rad_s + after_rad_s);
        }
        self.bearing_energy_j += lost_j;
    }

    /// Hands rapier the f64 sums, counted from its own origin and rounded: the chassis's pose, and wheel angles within
    /// one turn.
    fn write_back(&mut self) {
        let place_m = self.state.floor_from_chassis.translation.vector;
        self.ground.follow(&place_m, &mut self.rapier.colliders);
        let in_rapier = self.ground.rapier_from_floor() * self.state.floor_from_chassis;
        let chassis = &mut self.rapier.bodies[self.assembly.chassis];
        chassis.set_position(convert::pose(&in_rapier), false);
        self.assembly
            .set_wheel_angles(&mut self.rapier, &self.state.wheel_angles_rad);
    }

    /// Sets the hubs to where the f64 sums put them; rapier moves their rollers' colliders along.
    fn place_wheels(&mut self) {
        let rapier_from_floor = self.ground.rapier_from_floor();
        for (index, wheel) in self.assembly.wheels.iter().enumerate() {
            let pose = rapier_from_floor * self.state.floor_from_hub(index);
            self.rapier.bodies[wheel.hub].set_position(convert::pose(&pose), false);
            wheel.turn_rollers(&mut self.rapier);
        }
    }

    /// Lets those rollers touch the world that can.
    fn move_windows(&mut self) {
        for (index, window) in self.windows.iter_mut().enumerate() {
            if !window.moves {
                continue;
            }
            let body = &mut self.assembly.wheels[index];
            let floor_from_hub = self.state.floor_from_hub(index);
            let Window {
                shapes,
                needed,
                slots,
                ..
            } = window;
            window::in_reach(body, shapes, &floor_from_hub, &self.ground, needed);
            let wide_enough = window::assign(slots, needed);
            window.idle_steps = if needed.len() < slots.len() {
                window.idle_steps + 1
            } else {
                0
            };
            let patience = (WINDOW_PATIENCE_S / self.settings.dt_s) as u32;
            if !wide_enough || window.idle_steps > patience {
                slots.clone_from(needed);
                window.idle_steps = 0;
            }
            body.set_window(&mut self.rapier, &self.robot.wheels[index], slots);
        }
    }

    /// Builds the robot again, in the state in which it is, with the windows as they are asked for now.
    fn rebuild(&mut self) {
        let rollers: Vec<Vec<RollerState>> = self
            .assembly
            .wheels
            .iter()
            .map(|wheel| wheel.rollers.clone())
            .collect();
        let slots: Vec<Vec<usize>> = self
            .windows
            .iter()
            .map(|window| window.slots.clone())
            .collect();
        self.assembly.remove(&mut self.rapier);
        self.assembly = Assembly::build(
            &mut self.rapier,
            &self.robot,
            &self.state.seen_from(&self.ground),
            &rollers,
            &slots,
        );
    }
}

/// The body's pose in the floor's frame when the robot stands at a planar pose.
fn standing(robot: &Robot, floor: &Floor, start: PlanarPose) -> Isometry3<f64> {
    let reach_m = robot
        .wheels
        .iter()
        .map(|wheel| wheel.position_m().xy().norm() + wheel.radius_m)
        .fold(0.0, f64::max);
    let ground_m = floor.highest_m(start.position_m(), reach_m);
    let at = Vector3::new(start.x_m, start.y_m, ground_m + robot.ride_height_m());
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), start.heading_rad);
    Isometry3::from_parts(Translation3::from(at), yaw)
}

/// Whether all rollers of a wheel are the same but for their places, so that one collider can stand for any of them.
fn alike(wheel: &Wheel) -> bool {
    // Files round their numbers: what agrees to a few digits was meant to be the same.
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-4 * a.abs().max(b.abs());
    let figures = |roller: &Roller| {
        let barrel = wheel.barrel(roller);
        [
            barrel.ring_radius_m,
            barrel.half_length_m,
            roller.radius_m,
            roller.mass_kg,
            roller.axial_inertia_kg_m2,
            roller.transverse_inertia_kg_m2,
            roller.joint.damping_n_m_s,
            roller.joint.friction_n_m,
        ]
    };
    let first = figures(&wheel.rollers[0]);
    let same = |roller: &Roller| {
        figures(roller)
            .into_iter()
            .zip(first)
            .all(|(a, b)| close(a, b))
    };
    wheel.rollers.iter().all(same)
}

/// Refuses what cannot be simulated.
fn check(robot: &Robot, floor: &Floor, settings: &Settings) -> Result<(), WorldError> {
    let positive = [
        ("dt_s", settings.dt_s),
        ("contact_frequency_hz", settings.contact_frequency_hz),
        ("contact_damping_ratio", settings.contact_damping_ratio),
        ("prediction_m", settings.prediction_m),
    ];
    for (name, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return Err(WorldError::Setting {
                name,
                value,
                range: "finite and above 0",
            });
        }
    }
    let not_negative = [("gravity_m_s2", settings.gravity_m_s2)];
    for (name, value) in not_negative {
        if !(value.is_finite() && value >= 0.0) {
            return Err(WorldError::Setting {
                name,
                value,
                range: "finite and not below 0",
            });
        }
    }
    floor.check()?;
    for wheel in &robot.wheels {
        for roller in &wheel.rollers {
            if let RollerForm::AsModelled(_) = roller.form {
                let wheel_name = wheel.name.clone();
                if settings.roller_bodies == RollerBodies::Near {
                    return Err(WorldError::ModelledRollersNear { wheel: wheel_name });
                }
                if shape_of_roller(wheel, roller).is_none() {
                    return Err(WorldError::FlatRoller {
                        wheel: wheel_name,
                        roller: roller.name.clone(),
                    });
                }
                continue;
            }
            let barrel = wheel.barrel(roller);
            let end_radius_m = barrel.sphere_radius_m(barrel.half_length_m);
            if end_radius_m <= 0.0 {
                return Err(WorldError::RollerEndsVanish {
                    wheel: wheel.name.clone(),
                    missing_mm: -1e3 * end_radius_m,
                });
            }
        }
    }
    Ok(())
}

/// rapier as it has to be set where its own solver has no contact to solve: it finds contacts and moves bodies.
fn integration_parameters(settings: &Settings) -> IntegrationParameters {
    let softness = SpringCoefficients::new(
        settings.contact_frequency_hz as Real,
        settings.contact_damping_ratio as Real,
    );
    IntegrationParameters {
        dt: settings.dt_s as Real,
        contact_softness: softness,
        static_contact_softness: softness,
        num_solver_iterations: 1,
        // It has no contact to solve, and so none to stabilise.
        num_internal_stabilization_iterations: 0,
        num_internal_pgs_iterations: 1,
        normalized_prediction_distance: settings.prediction_m as Real,
        // One exact contact a roller and piece of ground: nothing to merge, and every force stays where it acts.
        contact_clustering: false,
        // A recycled contact keeps its old lever arm, but a roller's contact wanders along it all the time.
        contact_recycling: false,
        friction_model: FrictionModel::Coulomb,
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}
