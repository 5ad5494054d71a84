//! External disturbances of the robot: pushes, loads on its chassis, seized rollers, changed
//! floors.
//!
//! The energy that they add or remove is counted, so that the balance motors + outside = stored +
//! slip + bearings closes.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::{BodyMut, World};
use crate::Patch;
use crate::dynamics::Attached;
use crate::reference::Reference;
use crate::robot::articulated::{Articulated, wheel_inertia};
use crate::robot::payload::{ActingPush, Payload, loaded};
use crate::robot::state::State;

/// A force on the chassis for one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// The force, in the world frame, in N.
    pub force_in_world_n: Vector3<f64>,
    /// Point of application on the chassis, in the body frame, in metres.
    pub place_in_body_m: Vector3<f64>,
}

impl BodyMut<'_> {
    /// Pushes the chassis during the next step only. Several pushes add up.
    pub fn push(&mut self, push: &Push) {
        let robot = self.articulated();
        let center_m = robot.chassis_mass.center_of_mass_m;
        let floor_from_body = robot.state.floor_from_chassis().rotation;
        robot.command.pushes.push(ActingPush {
            force_n: push.force_in_world_n,
            lever_m: floor_from_body * (push.place_in_body_m - center_m),
            moment_n_m: Vector3::zeros(),
        });
    }

    /// Applies a pure moment in the world frame to the chassis, in N m, during the next step only.
    /// Pushes are added.
    pub fn turn(&mut self, moment_in_world_n_m: Vector3<f64>) {
        self.articulated().command.pushes.push(ActingPush {
            force_n: Vector3::zeros(),
            lever_m: Vector3::zeros(),
            moment_n_m: moment_in_world_n_m,
        });
    }

    /// Sets the loads on the chassis from now on; empty for none.
    ///
    /// A payload is put on, or taken off, at the velocity of its place on the chassis, so that the
    /// robot's motion does not change. Its energy is counted as external.
    pub fn carry(&mut self, payloads: &[Payload]) {
        let outside_j = |payload: &Payload| self.payload_energy_j(payload);
        let gone_j: f64 = self.world.bodies[self.index]
            .payloads
            .iter()
            .map(outside_j)
            .sum();
        let come_j: f64 = payloads.iter().map(outside_j).sum();
        self.world.energies.outside_j += come_j - gone_j;

        let robot = self.articulated();
        let center_before_m = robot.chassis_mass.center_of_mass_m;
        robot.chassis_mass = loaded(&robot.robot.chassis.mass, payloads);
        let moved_m = robot.chassis_mass.center_of_mass_m - center_before_m;
        robot.payloads = payloads.to_vec();
        if let Some(attached) = &mut robot.mechanics.attached {
            attached.recenter(&moved_m);
        }
        robot.weigh_wheels();
        self.weigh(moved_m);
    }

    /// Couples the inertia of bodies that another engine moves to the chassis from now on: an
    /// acceleration a of the chassis, linear at the body frame's origin before angular, then takes
    /// an additional wrench A a there, all along the world's axes, in kg, kg m and kg m^2. A is the
    /// articulated-body inertia of these bodies, symmetric and without negative energy. The energy
    /// that it takes counts as external. `None` ends it, and it has no effect on a body that rapier
    /// moves.
    pub fn attach(&mut self, inertia: Option<&Matrix6<f64>>) {
        let robot = self.articulated();
        let center_m = robot.chassis_mass.center_of_mass_m;
        robot.mechanics.attached =
            inertia.map(|inertia| Box::new(Attached::new(*inertia, &center_m)));
        robot.weigh_wheels();
    }

    /// Limits the rollers of a wheel to a share of the ground's friction from now on, on any
    /// ground; 1 for all of it. Values below 0 count as 0. A wheel that the robot does not have is
    /// ignored, and nothing changes if rapier moves the robot.
    pub fn set_grip(&mut self, wheel: usize, share: f64) {
        if let Some(hub) = self.articulated().wheels.get_mut(wheel) {
            hub.grip = share.max(0.0);
        }
    }

    /// Seizes a roller on its axle, or frees it again. A roller that the robot does not have is
    /// ignored.
    ///
    /// A seized roller does not turn relative to its hub. The energy of its spin goes into its
    /// bearing at once.
    pub fn seize_roller(&mut self, wheel: usize, roller: usize, seized: bool) {
        let kinetic_before_j = self.world.kinetic_j();
        let robot = self.articulated();
        let hubs = &mut robot.wheels;
        let Some(state) = hubs
            .get_mut(wheel)
            .and_then(|hub| hub.rollers.get_mut(roller))
        else {
            return;
        };
        state.seize(seized, &robot.state.hub_rate_in_hub(wheel));
        self.weigh(Vector3::zeros());
        self.world.energies.bearing_j += kinetic_before_j - self.world.kinetic_j();
    }

    /// Updates the masses after a change of the chassis's load, which moves its centre of mass by
    /// `moved_m` in the body's axes, or of the rollers that turn.
    fn weigh(&mut self, moved_m: Vector3<f64>) {
        self.articulated().weigh(moved_m);
        let world = &mut *self.world;
        if let Some(reference) = &mut world.reference {
            let robot = &world.bodies[self.index];
            **reference = Reference::new(robot, &world.ground, &world.settings);
        }
    }

    /// Kinetic and potential energy of a payload at the chassis's current motion, in J.
    fn payload_energy_j(&self, payload: &Payload) -> f64 {
        let robot = &self.world.bodies[self.index];
        let (state, center_m) = (&robot.state, robot.chassis_mass.center_of_mass_m);
        let lever_m = state.floor_from_chassis().rotation * (payload.place_in_body_m - center_m);
        let place_m = state.center_m() + lever_m;
        let velocity_m_s = state.velocity_m_s + state.angular_rad_s.cross(&lever_m);
        let gravity = self
            .world
            .ground
            .gravity_in_floor(self.world.settings.gravity_m_s2);
        payload.mass_kg * (0.5 * velocity_m_s.norm_squared() - gravity.dot(&place_m))
    }
}

impl World {
    /// Changes the friction of the ground from now on: everywhere, for rollers of all materials, or
    /// with `None` as it was built; and in patches, later ones over earlier ones, with footings for
    /// all of the floor's materials. A coefficient below 0 counts as 0.
    pub fn set_friction(&mut self, friction: Option<f64>, patches: &[Patch]) {
        self.ground.set_friction(friction, patches);
        self.wake_all();
        self.wake_user_bodies();
    }

    /// Tilts the ground from now on: gravity acts along a direction in the floor's frame, of any
    /// length, instead of the floor's original one. The change of potential energy counts as
    /// external. A zero direction is ignored.
    ///
    /// The frame stays the floor's, and the inertial forces of a rotating frame are left out: at a
    /// distance r from the axis, while the floor rotates with the rate w and the angular
    /// acceleration a, a r + w^2 r, and 2 w v for a body moving at v, all in m/s^2, compared with
    /// gravity. Contacts that rapier solves keep the direction of gravity that they were built with.
    pub fn lean(&mut self, down_in_floor: &Vector3<f64>) {
        let Some(down) = down_in_floor.try_normalize(f64::MIN_POSITIVE) else {
            return;
        };
        // An unchanged tilt does not wake sleeping bodies.
        if down == self.ground.gravity_in_floor(1.0) {
            return;
        }
        self.wake_all();
        self.wake_user_bodies();
        let before_j = self.potential_j();
        self.ground.lean(down);
        self.energies.outside_j += self.potential_j() - before_j;
    }

    /// Energy brought by pushes, payloads and tilting ground since the start, in J; negative if
    /// they took some.
    pub fn outside_energy_j(&self) -> f64 {
        self.energies.outside_j
    }
}

impl Articulated {
    /// Updates the inertia of the wheels for their motors, with the chassis's loads and coupled
    /// inertia.
    fn weigh_wheels(&mut self) {
        let carried_kg: f64 = self.payloads.iter().map(|payload| payload.mass_kg).sum();
        let attached = self.mechanics.attached.as_ref();
        let attached_kg = attached.map_or(0.0, |attached| attached.mean_mass_kg());
        self.wheel_inertia = wheel_inertia(&self.robot, carried_kg + attached_kg);
    }

    /// The force of the pushes of the coming step, and their torque about the chassis's centre of
    /// mass, in N and N m.
    pub(crate) fn pushed(&self) -> (Vector3<f64>, Vector3<f64>) {
        let mut sum = (Vector3::zeros(), Vector3::zeros());
        for push in &self.command.pushes {
            sum.0 += push.force_n;
            sum.1 += push.lever_m.cross(&push.force_n) + push.moment_n_m;
        }
        sum
    }

    /// The work of the pushes of a step, in J: force times the mean velocity of the point before
    /// and after, which is the energy that a constant force gives a body over a step.
    pub(crate) fn pushes_did_j(&self, dt_s: f64) -> f64 {
        let work_j = |push: &ActingPush| {
            let mean = &self.step.middle;
            let of_place = mean.velocity_m_s + mean.angular_rad_s.cross(&push.lever_m);
            (push.force_n.dot(&of_place) + push.moment_n_m.dot(&mean.angular_rad_s)) * dt_s
        };
        self.command.pushes.iter().map(work_j).sum()
    }

    /// Energy taken in a step by bodies that another engine moves, in J.
    pub(crate) fn attached_took_j(&self, dt_s: f64) -> f64 {
        let Some(attached) = &self.mechanics.attached else {
            return 0.0;
        };
        let rates = |state: &State| {
            let (v, w) = (state.velocity_m_s, state.angular_rad_s);
            Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
        };
        attached.took_j(&rates(&self.step.before), &rates(&self.state), dt_s)
    }
}
