//! The bodies of a world by identity: commands to a body, and its true state in f64 and in the
//! project's frames.

use ilon_robot::{BodyJoint, Pose as PlanarPose, Twist, roll_pitch_yaw};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::World;
use crate::contact::reactions::support::Support;
use crate::contact::reactions::wheel_contact::WheelContact;
use crate::contact::reactions::wheel_tally::WheelTally;
use crate::robot::articulated::Articulated;
use crate::{BodyId, MotorTorque, WorldError};

/// A robot of a world after the last step.
#[derive(Clone, Copy)]
pub struct Body<'a> {
    world: &'a World,
    index: usize,
}

/// A robot of a world, for driving and disturbing it.
pub struct BodyMut<'a> {
    pub(super) world: &'a mut World,
    pub(super) index: usize,
}

impl World {
    /// The identities of all robots, in the order of their creation.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> + use<> {
        (0..self.robots()).map(BodyId)
    }

    /// The number of robots, which come before the free bodies.
    fn robots(&self) -> usize {
        let robots = self.bodies.iter().take_while(|body| body.is_robot());
        robots.count()
    }

    /// A body in its current state.
    ///
    /// # Panics
    /// If the identity is that of another world, and this one has fewer bodies.
    pub fn body(&self, id: BodyId) -> Body<'_> {
        let index = self.checked(id);
        Body { world: self, index }
    }

    /// A body, for driving and disturbing it.
    ///
    /// # Panics
    /// If the identity is that of another world, and this one has fewer bodies.
    pub fn body_mut(&mut self, id: BodyId) -> BodyMut<'_> {
        let index = self.checked(id);
        BodyMut { world: self, index }
    }

    /// The robot that the world was built for; of several the first.
    pub fn robot(&self) -> Body<'_> {
        self.body(ROBOT)
    }

    /// Like [`World::robot`], for driving and disturbing it.
    pub fn robot_mut(&mut self) -> BodyMut<'_> {
        self.body_mut(ROBOT)
    }

    fn checked(&self, BodyId(index): BodyId) -> usize {
        let count = self.robots();
        assert!(index < count, "body {index} of a world of {count}");
        index
    }
}

/// The robot that a world was built for.
const ROBOT: BodyId = BodyId(0);

/// The state of the chassis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyState {
    /// Position of the body frame's origin in the ground plane and heading.
    pub pose: PlanarPose,
    /// Height of the body frame's origin, in metres.
    pub height_m: f64,
    /// Roll about the body's x axis, in radians.
    pub roll_rad: f64,
    /// Pitch about the body's y axis, in radians.
    pub pitch_rad: f64,
    /// Velocity of the body frame's origin and yaw rate, in the body frame.
    pub twist_in_body: Twist,
    /// Rotation from the body frame to the world: roll, pitch and heading in one.
    pub world_from_body: UnitQuaternion<f64>,
    /// Velocity of the body frame's origin along all axes of the body frame, in m/s.
    pub velocity_in_body_m_s: Vector3<f64>,
    /// Rates about all axes of the body frame, in rad/s.
    pub angular_in_body_rad_s: Vector3<f64>,
}

/// Orientation and motion of a point on a chassis, for a sensor there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceMotion {
    /// Rotation from the body frame to the floor's frame, whose z is the floor's normal.
    pub floor_from_body: UnitQuaternion<f64>,
    /// Velocity of the point in the floor's frame, in m/s.
    pub velocity_in_floor_m_s: Vector3<f64>,
}

impl<'a> Body<'a> {
    fn articulated(&self) -> &'a Articulated {
        &self.world.bodies[self.index]
    }

    /// Pose and velocity of the chassis.
    pub fn state(&self) -> BodyState {
        let robot = self.articulated();
        let (state, center_m) = (&robot.state, robot.chassis_mass.center_of_mass_m);
        let floor_from_body = state.floor_from_chassis() * Translation3::from(-center_m);
        let position = floor_from_body.translation.vector;
        let rotation = floor_from_body.rotation.to_rotation_matrix();
        let [roll_rad, pitch_rad, heading_rad] = roll_pitch_yaw(&rotation);
        let body_from_floor = self.rates_from().inverse();
        let angular_in_body = body_from_floor * state.angular_rad_s;
        let velocity_in_body =
            body_from_floor * state.velocity_m_s - angular_in_body.cross(&center_m);
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
            world_from_body: floor_from_body.rotation,
            velocity_in_body_m_s: velocity_in_body,
            angular_in_body_rad_s: angular_in_body,
        }
    }

    /// Orientation and motion of a point on the chassis, given in the body frame in metres,
    /// relative to the floor's frame.
    pub fn motion_at(&self, place_in_body_m: &Vector3<f64>) -> PlaceMotion {
        let robot = self.articulated();
        let state = &robot.state;
        let floor_from_body = state.floor_from_chassis().rotation;
        let lever_m = floor_from_body * (place_in_body_m - robot.chassis_mass.center_of_mass_m);
        PlaceMotion {
            floor_from_body,
            velocity_in_floor_m_s: state.velocity_m_s + state.angular_rad_s.cross(&lever_m),
        }
    }

    /// The rotation of the chassis for which its rates hold: the current one, or, after a step that
    /// did not resolve rollers, that in the middle of that step. At the end of the step such rates
    /// would show a lateral drift of v omega dt / 2.
    fn rates_from(&self) -> UnitQuaternion<f64> {
        let robot = self.articulated();
        let state = if robot.step.resolves_rollers {
            &robot.state
        } else {
            &robot.step.middle
        };
        state.floor_from_chassis().rotation
    }

    /// Angles of the wheels about their hub axes since the start, in rad, not wrapped.
    pub fn wheel_angles_rad(&self) -> &'a [f64] {
        self.articulated().state.wheel_angles_rad()
    }

    /// Rates of the wheels about their hub axes, in rad/s.
    pub fn wheel_rates_rad_s(&self) -> &'a [f64] {
        self.articulated().state.wheel_rates_rad_s()
    }

    /// Positions of the joints between bodies relative to zero, in rad or m.
    pub fn joint_positions(&self) -> &'a [f64] {
        self.articulated().state.joint_positions()
    }

    /// Rates of the joints between bodies, in rad/s or m/s.
    pub fn joint_rates(&self) -> &'a [f64] {
        self.articulated().state.joint_rates()
    }

    /// The target of each joint's servo, in rad or m, which approaches its aim at the servo's rate
    /// limit; zero for an undriven joint.
    pub fn joint_targets(&self) -> impl Iterator<Item = f64> + use<'a> {
        let servos = self.articulated().servos.iter();
        servos.map(|servo| servo.target)
    }

    /// Force in each joint between bodies during the last step along its motion, on its body, in N
    /// m or N: spring, damper, friction and stops; without couplings.
    pub fn joint_forces(&self) -> &'a [f64] {
        &self.articulated().done.joint_forces
    }

    /// Torques that the motors put on the wheels during the last step, in N m.
    pub fn motor_torques_n_m(&self) -> &'a [f64] {
        &self.articulated().done.acted_n_m
    }

    /// Means and extremes of each wheel, its motor and its contact over the last step.
    pub fn wheel_tallies(&self) -> impl Iterator<Item = &'a WheelTally> + use<'a> {
        self.articulated()
            .done
            .counts
            .iter()
            .map(|counts| &counts.tally)
    }

    /// Height of a wheel's centre above the floor's plane, level or not, in metres.
    ///
    /// # Panics
    /// If the robot has no such wheel.
    pub fn hub_height_m(&self, wheel: usize) -> f64 {
        self.articulated().state.hubs()[wheel].center_m.z
    }

    /// Position of each roller of a wheel on its axle, along its axis from the middle of its play,
    /// in metres; 0 without play.
    ///
    /// # Panics
    /// If the robot has no such wheel.
    pub fn roller_places_m(&self, wheel: usize) -> impl Iterator<Item = f64> + use<'a> {
        let rollers = &self.articulated().wheels[wheel].rollers;
        rollers.iter().map(|roller| roller.place_m())
    }

    /// Current penetration of the deepest point of all barrels into the ground, in metres; 0 if all
    /// are clear of it. Contacts deflect by their load over
    /// [`Settings::contact_stiffness_n_m`](crate::Settings::contact_stiffness_n_m), and a landing
    /// is detected within a step; anything more would be an error of the simulation. Rollers with
    /// shapes of their file are not included.
    pub fn penetration_m(&self) -> f64 {
        let mut pieces = Vec::new();
        let mut deepest_m = 0.0;
        let robot = self.articulated();
        let hubs = robot.state.hubs().iter();
        for (body, hub) in robot.wheels.iter().zip(hubs) {
            self.world
                .ground
                .pieces_near(&hub.center_m, body.reach_m, &mut pieces);
            let barrels = body.rollers.iter().filter_map(|r| r.placed_barrel(hub));
            for placed in barrels {
                let gaps = pieces.iter().map(|piece| placed.nearest_to(piece).gap_m);
                deepest_m = gaps.fold(deepest_m, |deepest: f64, gap_m| deepest.max(-gap_m));
            }
        }
        deepest_m
    }

    /// The contact of each wheel during the last step.
    pub fn contacts(&self) -> &'a [WheelContact] {
        &self.articulated().done.contacts
    }

    /// The ground's forces on the robot as a whole during the last step.
    pub fn support(&self) -> Support {
        self.articulated().done.support
    }

    /// Spins of all rollers of a wheel about their own axes relative to the hub, in rad/s, in the
    /// robot's order.
    ///
    /// # Panics
    /// If the robot has no such wheel.
    pub fn roller_spins_rad_s(&self, wheel: usize) -> Vec<f64> {
        let robot = self.articulated();
        let hub_rate_in_hub = robot.state.hub_rate_in_hub(wheel);
        let rollers = robot.wheels[wheel].rollers.iter();
        rollers
            .map(|roller| roller.spin_rad_s(&hub_rate_in_hub))
            .collect()
    }

    /// Angles of all rollers of a wheel about their own axes relative to the hub since the start,
    /// in rad, not wrapped, in the robot's order.
    ///
    /// # Panics
    /// If the robot has no such wheel.
    pub fn roller_angles_rad(&self, wheel: usize) -> impl Iterator<Item = f64> + use<'a> {
        let rollers = self.articulated().wheels[wheel].rollers.iter();
        rollers.map(|roller| roller.angle_rad)
    }
}

impl BodyMut<'_> {
    pub(super) fn articulated(&mut self) -> &mut Articulated {
        &mut self.world.bodies[self.index]
    }

    /// Sets the torques of the motors on the wheels during the next step, in N m, one per wheel;
    /// the chassis takes the opposite. They hold for one step.
    ///
    /// # Panics
    /// If there are more or fewer torques than wheels.
    pub fn apply(&mut self, torques_n_m: &[f64]) {
        let motors = &mut self.articulated().command.motors;
        assert_eq!(torques_n_m.len(), motors.len(), "one torque a wheel");
        for (motor, torque_n_m) in motors.iter_mut().zip(torques_n_m) {
            *motor = MotorTorque::constant(*torque_n_m);
        }
    }

    /// Sets the target of the servo of a joint between bodies in the middle of each coming step, in
    /// rad or m, and the target's rate, in rad/s or m/s; 0 for a constant one. Within a step the
    /// target moves at that rate. It approaches this aim at most at the servo's rate limit, and the
    /// aim holds until the next one.
    ///
    /// # Errors
    /// [`WorldError::Joint`] if the joint has no servo, a number is not finite, or the position is
    /// beyond the joint's limits.
    ///
    /// # Panics
    /// If the robot has no such joint.
    pub fn aim_joint(&mut self, joint: usize, position: f64, rate: f64) -> Result<(), WorldError> {
        self.aim_joint_along(joint, [position, rate, 0.0])
    }

    /// Like [`BodyMut::aim_joint`], for a target that has this position, rate and acceleration in
    /// the step's middle, in rad/s^2 or m/s^2.
    ///
    /// # Errors
    /// Those of [`BodyMut::aim_joint`].
    ///
    /// # Panics
    /// If the robot has no such joint.
    pub fn aim_joint_along(&mut self, joint: usize, aim: [f64; 3]) -> Result<(), WorldError> {
        let robot = self.articulated();
        let of = &robot.robot.joints[joint];
        let ([lower, upper], position) = (of.limits, aim[0]);
        if aim.iter().any(|number| !number.is_finite()) {
            return Err(of_joint(of, "its servo's target must be finite numbers"));
        }
        if !(lower..=upper).contains(&position) {
            let reason =
                format!("its servo cannot go to {position}: its limits are {lower} and {upper}");
            return Err(of_joint(of, reason));
        }
        match robot.aim(joint, aim) {
            true => Ok(()),
            false => Err(of_joint(&robot.robot.joints[joint], NOT_DRIVEN)),
        }
    }

    /// Commands a torque or a force of the servo of a joint between bodies from the coming step on,
    /// in N m or N, instead of a target, until it is aimed again; limited to its effort.
    ///
    /// # Errors
    /// [`WorldError::Joint`] if the joint has no servo, or the number is not finite.
    ///
    /// # Panics
    /// If the robot has no such joint.
    pub fn load_joint(&mut self, joint: usize, effort: f64) -> Result<(), WorldError> {
        let robot = self.articulated();
        let of = &robot.robot.joints[joint];
        if !effort.is_finite() {
            return Err(of_joint(of, "its torque or force must be a finite number"));
        }
        match robot.load_joint(joint, effort) {
            true => Ok(()),
            false => Err(of_joint(&robot.robot.joints[joint], NOT_DRIVEN)),
        }
    }

    /// Like [`BodyMut::apply`], with torques that depend on the rates of the wheels within the
    /// step.
    ///
    /// # Panics
    /// If there are more or fewer torques than wheels.
    pub fn drive(&mut self, motors: &[MotorTorque]) {
        self.articulated().command.motors.copy_from_slice(motors);
    }
}

/// The error for a command to a joint without a servo.
const NOT_DRIVEN: &str = "nothing drives it: give it a servo, the role `driven`";

fn of_joint(joint: &BodyJoint, reason: impl Into<String>) -> WorldError {
    WorldError::Joint {
        joint: joint.name.clone(),
        reason: reason.into(),
    }
}
