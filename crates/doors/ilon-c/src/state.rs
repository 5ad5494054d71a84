//! The structs that a plant returns, in C layout. Lengths are in metres, angles in radians, forces
//! in newtons, times in seconds. The body frame has x forward, y left and z up, the world frame z
//! along the floor's normal.

use ilon_sim::Plant;
use ilon_sim::robot::Pose;
use ilon_sim::world::{BodyState, WheelContact};

/// A position in the ground plane and a heading.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IlonPose {
    /// In metres.
    pub x_m: f64,
    /// In metres.
    pub y_m: f64,
    /// About the floor's normal, in radians, from -pi to pi.
    pub heading_rad: f64,
}

/// The constant properties of a plant.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IlonAbout {
    /// The number of wheels: the length of every array of wheels.
    pub wheel_count: u32,
    /// The number of joints between bodies: the length of every array of joints.
    pub joint_count: u32,
    /// The physics step, in seconds. With sampled or late wheel loops a period is
    /// a whole number of them.
    pub physics_dt_s: f64,
    /// The control period of the scenario, in seconds.
    pub control_dt_s: f64,
    /// The limit of the wheel rates, in rad/s; infinite for none.
    pub wheel_rate_limit_rad_s: f64,
    /// Coulomb friction coefficient of the floor in the scenario.
    pub floor_friction: f64,
    /// The seed of the scenario's noise.
    pub seed: u64,
    /// The start pose in the scenario.
    pub start: IlonPose,
}

/// The true state of the robot as a whole, independent of its sensors.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IlonState {
    /// Simulated time since the start or the last reset, in seconds.
    pub time_s: f64,
    /// The body frame's origin in the world, in metres.
    pub position_m: [f64; 3],
    /// Orientation of the body in the world: a unit quaternion w, x, y, z.
    pub quaternion_wxyz: [f64; 4],
    /// Roll about the body's x axis, in radians.
    pub roll_rad: f64,
    /// Pitch about the body's y axis, in radians.
    pub pitch_rad: f64,
    /// Heading about the floor's normal, in radians.
    pub heading_rad: f64,
    /// Velocity of the body frame's origin, in the body frame, in m/s.
    pub velocity_in_body_m_s: [f64; 3],
    /// Angular velocity in the body frame, in rad/s.
    pub angular_in_body_rad_s: [f64; 3],
    /// Acceleration of the body frame's origin in the world frame, in m/s^2: the mean over the last
    /// advance. An accelerometer there measures this minus gravity.
    pub acceleration_in_world_m_s2: [f64; 3],
    /// The acceleration of gravity in the world frame, in m/s^2. On a slope it is tilted.
    pub gravity_in_world_m_s2: [f64; 3],
    /// The load of the wheels along the floor's normal, in N, in the last physics step.
    pub wheels_load_n: f64,
    /// The load of a chassis that touches the ground, in N.
    pub chassis_load_n: f64,
    /// The force of walls, kerbs and bumps on the robot, in the world frame's x and y, in N.
    pub obstacle_force_n: [f64; 2],
    /// The largest violation of the contact laws in the last advance, in m/s.
    pub contact_residual_m_s: f64,
}

/// A wheel and its contact with the ground. Forces, slip and place are means over the last advance.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IlonWheel {
    /// Angle about the wheel's axis since the start, in radians, not wrapped.
    pub angle_rad: f64,
    /// Rate about the wheel's axis, in rad/s.
    pub rate_rad_s: f64,
    /// Motor torque on the wheel, in N m: the mean over the last advance.
    pub torque_n_m: f64,
    /// Height of the wheel's centre above the floor's plane, in metres.
    pub hub_height_m: f64,
    /// The load: the ground's normal force, in N.
    pub normal_force_n: f64,
    /// The ground's tangential force on the wheel, in the body frame's x and y, in N.
    pub force_in_body_n: [f64; 2],
    /// Slip: the velocity of the rollers' surface over the ground, in the body frame's x and y, in
    /// m/s.
    pub slip_in_body_m_s: [f64; 2],
    /// The contact point in the body frame, in metres.
    pub place_in_body_m: [f64; 3],
    /// Coulomb friction coefficient under the roller with the largest normal force.
    pub friction: f64,
    /// Power converted to heat by sliding in the last physics step, in W.
    pub slip_power_w: f64,
    /// The roller with the largest normal force at the end of the last advance.
    pub roller: u32,
    /// 1 if any roller touches the ground, 0 otherwise.
    pub touching: u32,
}

/// A joint between bodies of the robot, such as of a rocker or a sprung wheel. Values are in rad
/// and N m for a revolute joint, in m and N for a prismatic one.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IlonJoint {
    /// Displacement from zero.
    pub position: f64,
    /// Rate of the displacement.
    pub rate: f64,
    /// Force or torque of spring, damper, friction and stops on the joint's body in the last
    /// physics step.
    pub force: f64,
}

/// Stored energies, and the energy exchanged since the start, in J. The work of motors and outside
/// equals the sum of all others.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IlonEnergies {
    /// Kinetic energy of all bodies.
    pub kinetic_j: f64,
    /// Potential energy of height and springs.
    pub potential_j: f64,
    /// Work of the motors on the wheels.
    pub motor_j: f64,
    /// Work of external wrenches and payloads.
    pub outside_j: f64,
    /// Heat of sliding.
    pub slip_j: f64,
    /// Energy lost in spinning up rollers that touch down.
    pub spin_up_j: f64,
    /// Heat of bearings and gears.
    pub bearing_j: f64,
    /// Energy lost to the normal forces.
    pub impact_j: f64,
}

impl From<Pose> for IlonPose {
    fn from(pose: Pose) -> Self {
        Self {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: pose.heading_rad,
        }
    }
}

impl From<IlonPose> for Pose {
    fn from(pose: IlonPose) -> Self {
        Self {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: pose.heading_rad,
        }
    }
}

impl IlonAbout {
    pub(crate) fn of(plant: &Plant) -> Self {
        let (resolved, robot) = (plant.resolved(), plant.robot());
        Self {
            wheel_count: robot.wheels.len() as u32,
            joint_count: robot.joints.len() as u32,
            physics_dt_s: resolved.physics_dt_s(),
            control_dt_s: resolved.control_dt_s(),
            wheel_rate_limit_rad_s: resolved.wheel_rate_limit_rad_s(),
            floor_friction: plant.floor_friction(),
            seed: resolved.scenario().sensors.seed,
            start: resolved.start().into(),
        }
    }
}

impl IlonState {
    pub(crate) fn of(plant: &Plant) -> Self {
        let body: BodyState = plant.world().robot().state();
        let support = plant.world().robot().support();
        let last = plant.outcome();
        let [x, y, z, w] = body.world_from_body.coords.into();
        Self {
            time_s: plant.time_s(),
            position_m: [body.pose.x_m, body.pose.y_m, body.height_m],
            quaternion_wxyz: [w, x, y, z],
            roll_rad: body.roll_rad,
            pitch_rad: body.pitch_rad,
            heading_rad: body.pose.heading_rad,
            velocity_in_body_m_s: body.velocity_in_body_m_s.into(),
            angular_in_body_rad_s: body.angular_in_body_rad_s.into(),
            acceleration_in_world_m_s2: last.acceleration_in_world_m_s2,
            gravity_in_world_m_s2: plant.world().gravity_in_world_m_s2().into(),
            wheels_load_n: support.wheels_n,
            chassis_load_n: support.chassis_n,
            obstacle_force_n: support.obstacles_n.into(),
            contact_residual_m_s: last.contact_residual_m_s,
        }
    }
}

impl IlonWheel {
    pub(crate) fn of(plant: &Plant, wheel: usize) -> Self {
        let robot = plant.world().robot();
        let contact: &WheelContact = &robot.contacts()[wheel];
        let over = &plant.outcome().wheels[wheel];
        let place = over.place_mean_in_body_m();
        Self {
            angle_rad: robot.wheel_angles_rad()[wheel],
            rate_rad_s: robot.wheel_rates_rad_s()[wheel],
            torque_n_m: plant.outcome().torques_n_m[wheel],
            hub_height_m: robot.hub_height_m(wheel),
            normal_force_n: over.normal_force_mean_n(),
            force_in_body_n: over.force_mean_in_body_n().into(),
            slip_in_body_m_s: over.sliding_mean_in_body_m_s().into(),
            place_in_body_m: [place.x, place.y, contact.place_in_body_m.z],
            friction: over.friction_mean(),
            slip_power_w: contact.slip_power_w,
            roller: contact.roller as u32,
            touching: u32::from(contact.touching),
        }
    }
}

impl IlonJoint {
    pub(crate) fn of(plant: &Plant, joint: usize) -> Self {
        let robot = plant.world().robot();
        Self {
            position: robot.joint_positions()[joint],
            rate: robot.joint_rates()[joint],
            force: robot.joint_forces()[joint],
        }
    }
}

impl IlonEnergies {
    pub(crate) fn of(plant: &Plant) -> Self {
        let (world, now) = (plant.world(), plant.world().energy());
        Self {
            kinetic_j: now.kinetic_j,
            potential_j: now.potential_j,
            motor_j: world.motor_energy_j(),
            outside_j: world.outside_energy_j(),
            slip_j: world.slip_energy_j(),
            spin_up_j: world.spin_up_energy_j(),
            bearing_j: world.bearing_energy_j(),
            impact_j: world.impact_energy_j(),
        }
    }
}
