//! The world: a robot on a floor, stepped by rapier.

use ilon_robot::{
    Collision, CollisionShape, MassProperties as RobotMass, Pose as PlanarPose, Robot, Twist,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::contact::{Hub, WheelContact};
use crate::wheel_body::{self, WheelBody};
use crate::{Floor, RollerBodies, RollerDispatcher, Settings, WorldError, convert, groups};

/// A robot in a rapier world.
///
/// One step is: [`World::apply`] the wheel torques, then [`World::step`]. What can be read afterwards is the truth, in
/// f64 and in the project's frames; what a robot's sensors make of it is not this crate's business.
///
/// rapier computes in f32. Positions and wheel angles that only ever grow would lose their small increments there, so
/// the world sums them in f64 and hands rapier the rounded sum before every step.
pub struct World {
    rapier: PhysicsWorld,
    robot: Robot,
    settings: Settings,
    chassis: RigidBodyHandle,
    multibody: MultibodyIndex,
    wheels: Vec<WheelBody>,
    /// Zeros but for one entry while a joint's angle is corrected.
    displacement: Vec<Real>,
    floor_up: Vector3<f64>,
    /// The chassis's centre of mass in the body frame: rapier's multibody wants a root whose origin is its centre.
    body_from_chassis: Isometry3<f64>,
    state: State,
    before: State,
    wheel_rates_rad_s: Vec<f64>,
    contacts: Vec<WheelContact>,
    slip_energy_j: f64,
    motor_energy_j: f64,
    applied_torques_n_m: Vec<f64>,
    steps: u64,
}

/// Where everything is, in f64.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Pose of the chassis's centre of mass, along the body's axes.
    pub world_from_chassis: Isometry3<f64>,
    /// Velocity of the chassis's centre of mass, in the world frame, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity of the chassis, in the world frame, rad/s.
    pub angular_rad_s: Vector3<f64>,
    /// Angles of the wheels, in rad.
    pub wheel_angles_rad: Vec<f64>,
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
    /// Builds a robot standing on a floor with its body frame at `start`.
    ///
    /// The robot stands level on the plane, its wheels just touching, at rest.
    pub fn new(
        robot: &Robot,
        floor: &Floor,
        start: PlanarPose,
        settings: &Settings,
    ) -> Result<Self, WorldError> {
        check(robot, floor, settings)?;
        let mut rapier = PhysicsWorld {
            gravity: Vector::Z * -settings.gravity_m_s2 as Real,
            integration_parameters: integration_parameters(settings),
            narrow_phase: NarrowPhase::with_query_dispatcher(RollerDispatcher),
            ..PhysicsWorld::default()
        };
        let floor_up = Vector3::new(floor.slope_rad.sin(), 0.0, floor.slope_rad.cos());
        rapier.colliders.insert(
            ColliderBuilder::new(SharedShape::halfspace(convert::vector(&floor_up)))
                .friction(floor.friction as Real)
                .friction_combine_rule(CoefficientCombineRule::Min)
                .restitution(0.0)
                .collision_groups(groups::GROUND),
        );

        // Standing on the slope with the heading turned about the plane's normal.
        let tilt = UnitQuaternion::rotation_between(&Vector3::z(), &floor_up)
            .unwrap_or_else(UnitQuaternion::identity);
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), start.heading_rad);
        let along_floor = tilt * Vector3::new(start.x_m, start.y_m, robot.ride_height_m());
        let world_from_body = Isometry3::from_parts(Translation3::from(along_floor), tilt * yaw);
        let body_from_chassis = Isometry3::from_parts(
            robot.chassis.mass.center_of_mass_m.into(),
            UnitQuaternion::identity(),
        );
        let world_from_chassis = world_from_body * body_from_chassis;

        let chassis = rapier.bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(convert::pose(&world_from_chassis))
                .can_sleep(false)
                .additional_mass_properties(chassis_mass_properties(&robot.chassis.mass)),
        );
        let chassis_from_body = body_from_chassis.inverse();
        for collision in &robot.chassis.collisions {
            let PhysicsWorld {
                bodies, colliders, ..
            } = &mut rapier;
            colliders.insert_with_parent(
                chassis_collider(&chassis_from_body, collision, floor.friction),
                chassis,
                bodies,
            );
        }
        let mut wheels: Vec<WheelBody> = robot
            .wheels
            .iter()
            .map(|wheel| {
                let PhysicsWorld {
                    bodies,
                    colliders,
                    multibody_joints,
                    ..
                } = &mut rapier;
                wheel_body::insert(
                    bodies,
                    colliders,
                    multibody_joints,
                    chassis,
                    &chassis_from_body,
                    wheel,
                    settings,
                    floor.friction,
                )
            })
            .collect();
        let multibody = index_links(&mut rapier, &mut wheels);
        set_joint_dynamics(&mut rapier, multibody, robot, &wheels, settings);

        let state = State {
            world_from_chassis,
            velocity_m_s: Vector3::zeros(),
            angular_rad_s: Vector3::zeros(),
            wheel_angles_rad: vec![0.0; wheels.len()],
        };
        let mut world = Self {
            chassis,
            multibody,
            displacement: vec![0.0; rapier.multibody_joints[multibody].ndofs()],
            floor_up,
            body_from_chassis,
            before: state.clone(),
            state,
            wheel_rates_rad_s: vec![0.0; wheels.len()],
            contacts: vec![WheelContact::default(); wheels.len()],
            applied_torques_n_m: vec![0.0; wheels.len()],
            slip_energy_j: 0.0,
            motor_energy_j: 0.0,
            steps: 0,
            robot: robot.clone(),
            settings: settings.clone(),
            wheels,
            rapier,
        };
        world.move_windows();
        Ok(world)
    }

    /// Sets the torques that the motors put on the wheels during the next step, in N m, one a wheel; the chassis takes
    /// the opposite. They hold for one step.
    pub fn apply(&mut self, torques_n_m: &[f64]) {
        self.applied_torques_n_m.copy_from_slice(torques_n_m);
        let world_from_chassis = self.state.world_from_chassis.rotation;
        let mut reaction = Vector3::zeros();
        for ((torque_n_m, wheel), body) in
            torques_n_m.iter().zip(&self.robot.wheels).zip(&self.wheels)
        {
            let axis = world_from_chassis * (wheel.body_from_hub.rotation * Vector3::z());
            let torque = axis * *torque_n_m;
            let hub = &mut self.rapier.bodies[body.hub];
            hub.reset_torques(false);
            hub.add_torque(convert::vector(&torque), false);
            reaction -= torque;
        }
        let chassis = &mut self.rapier.bodies[self.chassis];
        chassis.reset_torques(false);
        chassis.add_torque(convert::vector(&reaction), false);
    }

    /// Advances the world by one physics step.
    pub fn step(&mut self) {
        self.before.clone_from(&self.state);
        self.rapier.step();
        self.steps += 1;
        self.read_state();
        self.read_contacts();
        self.write_back();
        self.move_windows();
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
        let world_from_body = self.state.world_from_chassis * self.body_from_chassis.inverse();
        let position = world_from_body.translation.vector;
        let rotation = world_from_body.rotation;
        let (roll_rad, pitch_rad, heading_rad) = rotation.euler_angles();
        let solved_at = self.before.world_from_chassis.rotation;
        let lever = solved_at * -self.body_from_chassis.translation.vector;
        let velocity = self.state.velocity_m_s + self.state.angular_rad_s.cross(&lever);
        let velocity_in_body = solved_at.inverse() * velocity;
        let angular_in_body = solved_at.inverse() * self.state.angular_rad_s;
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
        &self.wheel_rates_rad_s
    }

    /// What each wheel's rollers did to the ground during the last step.
    pub fn contacts(&self) -> &[WheelContact] {
        &self.contacts
    }

    /// Energy that sliding at the contacts has turned into heat since the start, in J.
    pub fn slip_energy_j(&self) -> f64 {
        self.slip_energy_j
    }

    /// Work of the motors on the wheels since the start, in J; negative where they braked.
    pub fn motor_energy_j(&self) -> f64 {
        self.motor_energy_j
    }

    /// Spins of all rollers of a wheel about their own axes against the hub, in rad/s, in the robot's order.
    pub fn roller_spins_rad_s(&self, wheel: usize) -> Vec<f64> {
        let hub_rate_in_hub = self.hub_rate_in_hub(wheel);
        let mut spins: Vec<f64> = self.wheels[wheel]
            .rollers
            .iter()
            .map(|r| r.axial_rate_rad_s - hub_rate_in_hub.dot(&r.axis_in_hub()))
            .collect();
        for slot in &self.wheels[wheel].slots {
            spins[slot.roller] = self.rate(slot.dof);
        }
        spins
    }

    /// Number of rapier bodies of the robot.
    pub fn body_count(&self) -> usize {
        self.rapier.bodies.len()
    }

    /// Rate along one axis of the robot's multibody: rad/s about a joint.
    fn rate(&self, dof: usize) -> f64 {
        f64::from(self.rapier.multibody_joints[self.multibody].generalized_velocity()[dof])
    }

    /// Takes rapier's velocities over and sums positions and angles in f64, as rapier does in f32: with the velocity
    /// after the step.
    fn read_state(&mut self) {
        let dt_s = self.settings.dt_s;
        let rate = |dof: usize| self.rate(dof);
        let velocity_m_s = Vector3::new(rate(0), rate(1), rate(2));
        let angular_rad_s = Vector3::new(rate(3), rate(4), rate(5));
        for index in 0..self.wheels.len() {
            self.wheel_rates_rad_s[index] = self.rate(self.wheels[index].hub_dof);
        }
        let state = &mut self.state;
        state.velocity_m_s = velocity_m_s;
        state.angular_rad_s = angular_rad_s;
        state.world_from_chassis.translation.vector += dt_s * velocity_m_s;
        state.world_from_chassis.rotation =
            convert::rotation_to_f64(self.rapier.bodies[self.chassis].position().rotation);
        for ((angle, rate), torque) in state
            .wheel_angles_rad
            .iter_mut()
            .zip(&self.wheel_rates_rad_s)
            .zip(&self.applied_torques_n_m)
        {
            *angle += dt_s * rate;
            self.motor_energy_j += dt_s * torque * rate;
        }
    }

    /// Reads the contacts of the last step at the poses where the solver saw them.
    fn read_contacts(&mut self) {
        let dt_s = self.settings.dt_s;
        let rates = self.rapier.multibody_joints[self.multibody].generalized_velocity();
        for (index, contact) in self.contacts.iter_mut().enumerate() {
            let hub = Hub {
                wheel: &self.robot.wheels[index],
                body: &self.wheels[index],
                chassis_from_body: self.body_from_chassis.inverse(),
                angle_before_rad: self.before.wheel_angles_rad[index],
                rate_rad_s: self.wheel_rates_rad_s[index],
            };
            *contact = hub.read_contact(&self.rapier, &self.before, &self.state, dt_s, |dof| {
                f64::from(rates[dof])
            });
            self.slip_energy_j += contact.slip_power_w * dt_s;
        }
    }

    /// Hands rapier the f64 sums, rounded: the chassis's pose, and wheel angles within one turn.
    fn write_back(&mut self) {
        let pose = convert::pose(&self.state.world_from_chassis);
        self.rapier.bodies[self.chassis].set_position(pose, false);
        let multibody = self
            .rapier
            .multibody_joints
            .get_multibody_mut(self.multibody)
            .expect("the robot's multibody lives as long as its world");
        for (wheel, angle_rad) in self.wheels.iter().zip(&self.state.wheel_angles_rad) {
            let link = multibody
                .link(wheel.hub_link)
                .expect("links are indexed at the start");
            let in_rapier = f64::from(link.joint().coords()[HINGE]);
            let correction = (ilon_robot::wrap_angle(*angle_rad) - in_rapier) as Real;
            if correction != 0.0 {
                self.displacement[wheel.hub_dof] = correction;
                multibody.apply_displacements(&self.displacement);
                self.displacement[wheel.hub_dof] = 0.0;
            }
        }
    }

    /// Angular velocity of a hub in its own frame, in rad/s.
    fn hub_rate_in_hub(&self, wheel: usize) -> Vector3<f64> {
        let rotation = self.hub_rotation(wheel);
        rotation.inverse() * self.state.angular_rad_s + Vector3::z() * self.wheel_rates_rad_s[wheel]
    }

    /// Rotation of a hub's frame in the world.
    fn hub_rotation(&self, wheel: usize) -> UnitQuaternion<f64> {
        let turned =
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.state.wheel_angles_rad[wheel]);
        self.state.world_from_chassis.rotation
            * self.robot.wheels[wheel].body_from_hub.rotation
            * turned
    }

    /// Moves every slot to the roller that stands lowest, and lets the others coast.
    fn move_windows(&mut self) {
        if self.settings.roller_bodies == RollerBodies::All {
            return;
        }
        for index in 0..self.wheels.len() {
            let hub_rotation = self.hub_rotation(index);
            let hub_rate_in_hub = self.hub_rate_in_hub(index);
            let down_in_hub = hub_rotation.inverse() * -self.floor_up;
            let down_rad = down_in_hub.y.atan2(down_in_hub.x);
            let dt_s = self.settings.dt_s;
            let slotted = self.wheels[index].slots[0].roller;
            let wheel = &mut self.wheels[index];
            for (i, roller) in wheel.rollers.iter_mut().enumerate() {
                if i != slotted {
                    roller.coast(&hub_rate_in_hub, dt_s);
                }
            }
            let lowest = (0..wheel.rollers.len())
                .min_by(|&a, &b| {
                    let off = |i: usize| {
                        ilon_robot::wrap_angle(wheel.rollers[i].place_rad - down_rad).abs()
                    };
                    off(a).total_cmp(&off(b))
                })
                .unwrap_or(slotted);
            if lowest != slotted {
                self.relabel(index, 0, lowest, &hub_rate_in_hub);
            }
        }
    }

    /// Lets a slot stand for another roller of its wheel: the leaving roller keeps its spin, the entering one brings
    /// its own. The slot carries nothing but spin inertia, so no momentum moves with it.
    fn relabel(
        &mut self,
        wheel: usize,
        slot: usize,
        roller: usize,
        hub_rate_in_hub: &Vector3<f64>,
    ) {
        let spin = self.rate(self.wheels[wheel].slots[slot].dof);
        let WheelBody {
            hub,
            slots,
            rollers,
            ..
        } = &mut self.wheels[wheel];
        let slot = &mut slots[slot];
        let leaving = &mut rollers[slot.roller];
        leaving.axial_rate_rad_s = spin + hub_rate_in_hub.dot(&leaving.axis_in_hub());
        let entering = &rollers[roller];
        let entering_spin =
            entering.axial_rate_rad_s - hub_rate_in_hub.dot(&entering.axis_in_hub());
        slot.roller = roller;

        let PhysicsWorld {
            bodies,
            multibody_joints,
            ..
        } = &mut self.rapier;
        let multibody = multibody_joints
            .get_multibody_mut(self.multibody)
            .expect("the robot's multibody lives as long as its world");
        multibody.generalized_velocity_mut()[slot.dof] = entering_spin as Real;
        let link = multibody
            .link_mut(slot.link)
            .expect("links are indexed at the start");
        link.joint.data.local_frame1 = wheel_body::joint_frame(&entering.hub_from_roller);
        // The start of rapier's next step moves the bodies by itself, but not their colliders.
        let hub_from_slot = link.joint().body_to_parent();
        let world_from_hub = *bodies[*hub].position();
        bodies[slot.body].set_position(world_from_hub * hub_from_slot, false);
    }
}

/// Place of a hinge's angle among rapier's six joint coordinates.
const HINGE: usize = 3;

/// Refuses what cannot be simulated.
fn check(robot: &Robot, floor: &Floor, settings: &Settings) -> Result<(), WorldError> {
    let positive = [
        ("dt_s", settings.dt_s),
        ("contact_frequency_hz", settings.contact_frequency_hz),
        ("contact_damping_ratio", settings.contact_damping_ratio),
        ("prediction_m", settings.prediction_m),
        ("sweeps", settings.sweeps as f64),
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
    let not_negative = [
        ("friction", floor.friction),
        ("roller_armature_kg_m2", settings.roller_armature_kg_m2),
        ("gravity_m_s2", settings.gravity_m_s2),
    ];
    for (name, value) in not_negative {
        if !(value.is_finite() && value >= 0.0) {
            return Err(WorldError::Setting {
                name,
                value,
                range: "finite and not below 0",
            });
        }
    }
    if !(floor.slope_rad.abs() < std::f64::consts::FRAC_PI_2) {
        return Err(WorldError::Setting {
            name: "slope_rad",
            value: floor.slope_rad,
            range: "between -pi/2 and pi/2",
        });
    }
    for wheel in &robot.wheels {
        for roller in &wheel.rollers {
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

/// rapier's solver as it has to be set for light rollers under a heavy robot.
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
        // With stabilisation rapier solves friction after it has moved the bodies: large steps then lose up to 40 %.
        num_internal_stabilization_iterations: 0,
        num_internal_pgs_iterations: settings.sweeps,
        normalized_prediction_distance: settings.prediction_m as Real,
        // A recycled contact keeps its old lever arm, but a roller's contact wanders along it all the time.
        contact_recycling: false,
        friction_model: FrictionModel::Coulomb,
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}

fn chassis_mass_properties(mass: &RobotMass) -> MassProperties {
    MassProperties::with_inertia_matrix(
        Vector::ZERO,
        mass.mass_kg as Real,
        convert::matrix(&mass.inertia_kg_m2),
    )
}

fn chassis_collider(
    chassis_from_body: &Isometry3<f64>,
    collision: &Collision,
    friction: f64,
) -> ColliderBuilder {
    // URDF's cylinders and capsules stand along z, parry's along y.
    let y_to_z = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    let (shape, turn) = match &collision.shape {
        CollisionShape::Box { half_extents_m: h } => (
            SharedShape::cuboid(h.x as Real, h.y as Real, h.z as Real),
            UnitQuaternion::identity(),
        ),
        CollisionShape::Cylinder { radius_m, length_m } => (
            SharedShape::cylinder(0.5 * *length_m as Real, *radius_m as Real),
            y_to_z,
        ),
        CollisionShape::Capsule { radius_m, length_m } => (
            SharedShape::capsule_z(0.5 * *length_m as Real, *radius_m as Real),
            UnitQuaternion::identity(),
        ),
        CollisionShape::Sphere { radius_m } => (
            SharedShape::ball(*radius_m as Real),
            UnitQuaternion::identity(),
        ),
    };
    let placed = chassis_from_body * collision.body_from_shape * turn;
    ColliderBuilder::new(shape)
        .position(convert::pose(&placed))
        .density(0.0)
        .friction(friction as Real)
        .friction_combine_rule(CoefficientCombineRule::Min)
        .collision_groups(groups::CHASSIS)
}

/// Looks up, once, where each hub and slot stands in the robot's multibody.
fn index_links(rapier: &mut PhysicsWorld, wheels: &mut [WheelBody]) -> MultibodyIndex {
    let PhysicsWorld {
        bodies,
        multibody_joints,
        ..
    } = rapier;
    let find = |joints: &MultibodyJointSet, body: RigidBodyHandle| {
        *joints
            .rigid_body_link(body)
            .expect("every hub and slot is inserted as a link")
    };
    let index = find(multibody_joints, wheels[0].hub).multibody;
    // Only now does rapier see that the chassis is free, and give the root its six axes before all others.
    multibody_joints
        .get_multibody_mut(index)
        .expect("the multibody of a link exists")
        .forward_kinematics(bodies, true);
    let place = |body: RigidBodyHandle| {
        let id = find(multibody_joints, body).id;
        let link = multibody_joints[index]
            .link(id)
            .expect("the link of an id exists");
        (id, link.assembly_id())
    };
    for wheel in wheels {
        (wheel.hub_link, wheel.hub_dof) = place(wheel.hub);
        for slot in &mut wheel.slots {
            (slot.link, slot.dof) = place(slot.body);
        }
    }
    index
}

/// Damping, dry friction and armature of every joint; rapier's own default damps every free axis by 0.1.
fn set_joint_dynamics(
    rapier: &mut PhysicsWorld,
    multibody: MultibodyIndex,
    robot: &Robot,
    wheels: &[WheelBody],
    settings: &Settings,
) {
    let multibody = rapier
        .multibody_joints
        .get_multibody_mut(multibody)
        .expect("the robot's multibody has just been built");
    multibody.damping_mut().fill(0.0);
    let mut set = |dof: usize, joint: &ilon_robot::Joint, armature: f64| {
        multibody.damping_mut()[dof] = joint.damping_n_m_s as Real;
        multibody.frictions_mut()[dof] = joint.friction_n_m as Real;
        multibody.armature_mut()[dof] = armature as Real;
    };
    for (body, wheel) in wheels.iter().zip(&robot.wheels) {
        set(body.hub_dof, &wheel.joint, 0.0);
        for slot in &body.slots {
            set(
                slot.dof,
                &wheel.rollers[slot.roller].joint,
                settings.roller_armature_kg_m2,
            );
        }
    }
}
