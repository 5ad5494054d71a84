//! Poses and velocities of a robot, in f64, in the floor's frame: z is perpendicular to the plane,
//! x and y lie in it.

use std::sync::Arc;

use ilon_robot::Robot;
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::dynamics::{LinkPose, Motion, ROOT_DOFS, Tree};

/// The state of a robot without its rollers.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Pose of the chassis's centre of mass, along the body's axes.
    floor_from_chassis: Isometry3<f64>,
    /// Velocity of the chassis's centre of mass, in the floor's frame, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity of the chassis, in the floor's frame, rad/s.
    pub angular_rad_s: Vector3<f64>,
    /// Positions of the joints of the tree, in rad, not wrapped, or m: those of the bodies first,
    /// then the wheels.
    moved: Vec<f64>,
    /// Rates of the joints, in rad/s or m/s.
    rates: Vec<f64>,
    /// The index of the first wheel among the joints.
    first_hub: usize,
    /// The tree's structure, shared by copies of a state.
    tree: Arc<Tree>,
    /// Poses of the chassis and the links, which follow from the coordinates above.
    chassis: LinkPose,
    links: Vec<LinkPose>,
}

impl State {
    /// A robot at rest with its body frame at a pose.
    pub fn at_rest(robot: &Robot, tree: &Arc<Tree>, floor_from_body: &Isometry3<f64>) -> Self {
        let body_from_chassis = Isometry3::from(robot.chassis.mass.center_of_mass_m);
        let nowhere = LinkPose {
            center_m: Vector3::zeros(),
            rotation: Matrix3::identity(),
        };
        let mut state = Self {
            floor_from_chassis: floor_from_body * body_from_chassis,
            velocity_m_s: Vector3::zeros(),
            angular_rad_s: Vector3::zeros(),
            moved: robot.start_positions(),
            rates: vec![0.0; tree.joints().len()],
            first_hub: robot.joints.len(),
            tree: Arc::clone(tree),
            chassis: nowhere,
            links: vec![nowhere; tree.joints().len()],
        };
        state.moved.resize(tree.joints().len(), 0.0);
        state.place_links();
        state
    }

    /// Pose of the chassis's centre of mass, along the body's axes.
    pub fn floor_from_chassis(&self) -> &Isometry3<f64> {
        &self.floor_from_chassis
    }

    /// The chassis's centre of mass, in metres.
    pub fn center_m(&self) -> Vector3<f64> {
        self.floor_from_chassis.translation.vector
    }

    /// Angles of the wheels, in rad, not wrapped.
    pub fn wheel_angles_rad(&self) -> &[f64] {
        &self.moved[self.first_hub..]
    }

    /// Rates of the wheels, in rad/s.
    pub fn wheel_rates_rad_s(&self) -> &[f64] {
        &self.rates[self.first_hub..]
    }

    /// The same, mutable.
    pub fn wheel_rates_mut(&mut self) -> &mut [f64] {
        &mut self.rates[self.first_hub..]
    }

    /// Positions of the joints between bodies, in rad or m.
    pub fn joint_positions(&self) -> &[f64] {
        &self.moved[..self.first_hub]
    }

    /// Rates of the joints between bodies, in rad/s or m/s.
    pub fn joint_rates(&self) -> &[f64] {
        &self.rates[..self.first_hub]
    }

    /// The chassis's centre of mass and its axes.
    pub fn chassis(&self) -> &LinkPose {
        &self.chassis
    }

    /// Poses of the hubs.
    pub fn hubs(&self) -> &[LinkPose] {
        &self.links[self.first_hub..]
    }

    /// Poses of all links of the tree.
    pub fn links(&self) -> &[LinkPose] {
        &self.links
    }

    /// Pose of a joint's link, or of the body frame, whose origin has the given offset from the
    /// chassis's centre of mass.
    pub fn carrier(&self, joint: Option<usize>, center_m: &Vector3<f64>) -> Isometry3<f64> {
        let Some(joint) = joint else {
            return self.floor_from_chassis * Isometry3::from(-center_m);
        };
        let link = &self.links[joint];
        let rotation = Rotation3::from_matrix_unchecked(link.rotation);
        let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
        Isometry3::from_parts(link.center_m.into(), rotation)
    }

    /// Moves the chassis elsewhere.
    pub fn place(&mut self, floor_from_chassis: Isometry3<f64>) {
        self.floor_from_chassis = floor_from_chassis;
        self.place_links();
    }

    /// Sets all rates to zero.
    pub fn halt(&mut self) {
        self.velocity_m_s = Vector3::zeros();
        self.angular_rad_s = Vector3::zeros();
        self.rates.fill(0.0);
        self.moved[self.first_hub..].fill(0.0);
        self.place_links();
    }

    /// Puts joints between bodies back to where they are in another state of the same robot.
    pub fn put_back(&mut self, joints: &[usize], to: &Self) {
        for joint in joints {
            self.moved[*joint] = to.moved[*joint];
        }
        self.place_links();
    }

    /// Copies the poses of another state of the same robot; the rates stay.
    pub fn take_poses(&mut self, other: &Self) {
        self.floor_from_chassis = other.floor_from_chassis;
        self.moved.copy_from_slice(&other.moved);
        self.chassis = other.chassis;
        self.links.copy_from_slice(&other.links);
    }

    /// Advances the poses by `dt_s` with the current rates.
    pub fn advance(&mut self, dt_s: f64) {
        self.move_chassis(self.velocity_m_s, self.angular_rad_s, dt_s);
        for (moved, rate) in self.moved.iter_mut().zip(&self.rates) {
            *moved += dt_s * rate;
        }
        self.place_links();
    }

    /// Advances the poses by `dt_s` with the rates of another state of the same robot.
    pub fn advance_with(&mut self, rates: &Self, dt_s: f64) {
        self.move_chassis(rates.velocity_m_s, rates.angular_rad_s, dt_s);
        for (moved, rate) in self.moved.iter_mut().zip(&rates.rates) {
            *moved += dt_s * rate;
        }
        self.place_links();
    }

    fn move_chassis(&mut self, velocity_m_s: Vector3<f64>, angular_rad_s: Vector3<f64>, dt_s: f64) {
        self.floor_from_chassis.translation.vector += dt_s * velocity_m_s;
        self.floor_from_chassis.rotation =
            UnitQuaternion::new(dt_s * angular_rad_s) * self.floor_from_chassis.rotation;
    }

    fn place_links(&mut self) {
        let Isometry3 {
            rotation,
            translation,
        } = self.floor_from_chassis;
        self.chassis = LinkPose {
            center_m: translation.vector,
            rotation: rotation.to_rotation_matrix().into_inner(),
        };
        self.tree.place(&self.chassis, &self.moved, &mut self.links);
    }

    /// Writes its rates by degree of freedom.
    pub fn write_rates(&self, rates: &mut [f64]) {
        rates[..3].copy_from_slice(self.velocity_m_s.as_slice());
        rates[3..ROOT_DOFS].copy_from_slice(self.angular_rad_s.as_slice());
        rates[ROOT_DOFS..].copy_from_slice(&self.rates);
    }

    /// Takes over rates by degree of freedom.
    pub fn take_rates(&mut self, rates: &[f64]) {
        self.velocity_m_s = Vector3::from_column_slice(&rates[..3]);
        self.angular_rad_s = Vector3::from_column_slice(&rates[3..ROOT_DOFS]);
        self.rates.copy_from_slice(&rates[ROOT_DOFS..]);
    }

    /// Angular velocity of the carrier of a wheel, in the floor's frame, for a given rate of the
    /// chassis and given joint rates, in rad/s.
    pub fn carrier_rate_with(
        &self,
        wheel: usize,
        chassis_rad_s: Vector3<f64>,
        rates: &[f64],
    ) -> Vector3<f64> {
        let above = self.tree.ancestors(self.first_hub + wheel).iter();
        above.fold(chassis_rad_s, |sum, at| {
            sum + self.turning_of(usize::from(*at), rates)
        })
    }

    fn carrier_rate(&self, wheel: usize) -> Vector3<f64> {
        self.carrier_rate_with(wheel, self.angular_rad_s, &self.rates)
    }

    /// A joint's contribution to the angular velocity of its link.
    fn turning_of(&self, joint: usize, rates: &[f64]) -> Vector3<f64> {
        match self.tree.joints()[joint].motion {
            Motion::Turns => rates[joint] * self.links[joint].axis(),
            Motion::Slides => Vector3::zeros(),
        }
    }

    /// A joint's contribution to the velocity of a point of its link, or of one further out.
    fn moving_of(&self, joint: usize, place_m: &Vector3<f64>) -> Vector3<f64> {
        let link = &self.links[joint];
        let along = self.rates[joint] * link.axis();
        match self.tree.joints()[joint].motion {
            Motion::Turns => along.cross(&(place_m - link.center_m)),
            Motion::Slides => along,
        }
    }

    /// Angular velocity of the link of a joint between bodies, in the floor's frame, in rad/s.
    pub fn link_rate(&self, joint: usize) -> Vector3<f64> {
        let above = self.tree.ancestors(joint).iter();
        let way = above.map(|at| usize::from(*at)).chain([joint]);
        way.fold(self.angular_rad_s, |sum, at| {
            sum + self.turning_of(at, &self.rates)
        })
    }

    /// Velocity of a point of that link, in m/s.
    pub fn link_velocity_m_s(&self, joint: usize, place_m: &Vector3<f64>) -> Vector3<f64> {
        let above = self.tree.ancestors(joint).iter();
        let way = above.map(|at| usize::from(*at)).chain([joint]);
        way.fold(self.chassis_velocity_m_s(place_m), |sum, at| {
            sum + self.moving_of(at, place_m)
        })
    }

    /// Velocity of a point of a joint's link, or of the chassis, in m/s.
    pub fn carrier_velocity_m_s(
        &self,
        joint: Option<usize>,
        place_m: &Vector3<f64>,
    ) -> Vector3<f64> {
        match joint {
            Some(joint) => self.link_velocity_m_s(joint, place_m),
            None => self.chassis_velocity_m_s(place_m),
        }
    }

    /// Angular velocity of a joint's link, or of the chassis, in rad/s.
    pub fn carrier_rates(&self, joint: Option<usize>) -> Vector3<f64> {
        joint.map_or(self.angular_rad_s, |joint| self.link_rate(joint))
    }

    /// Angular velocity of a hub, in the floor's frame, in rad/s.
    pub fn hub_rate(&self, wheel: usize) -> Vector3<f64> {
        self.carrier_rate(wheel) + self.wheel_rates_rad_s()[wheel] * self.hubs()[wheel].axis()
    }

    /// Angular velocity of a hub in its own frame, in rad/s.
    pub fn hub_rate_in_hub(&self, wheel: usize) -> Vector3<f64> {
        self.hubs()[wheel]
            .rotation
            .tr_mul(&self.carrier_rate(wheel))
            + Vector3::z() * self.wheel_rates_rad_s()[wheel]
    }

    /// Velocity of a hub's centre, in m/s.
    pub fn hub_center_velocity_m_s(&self, wheel: usize) -> Vector3<f64> {
        let hub_m = self.hubs()[wheel].center_m;
        let above = self.tree.ancestors(self.first_hub + wheel).iter();
        above.fold(self.chassis_velocity_m_s(&hub_m), |sum, at| {
            sum + self.moving_of(usize::from(*at), &hub_m)
        })
    }

    /// Velocity of a point of the chassis, in m/s.
    pub fn chassis_velocity_m_s(&self, place_m: &Vector3<f64>) -> Vector3<f64> {
        self.velocity_m_s + self.angular_rad_s.cross(&(place_m - self.center_m()))
    }

    /// Velocity of a point that turns with a hub, in m/s.
    pub fn hub_velocity_m_s(&self, wheel: usize, place_m: &Vector3<f64>) -> Vector3<f64> {
        let hub_m = self.hubs()[wheel].center_m;
        self.hub_center_velocity_m_s(wheel) + self.hub_rate(wheel).cross(&(place_m - hub_m))
    }

    /// Changes the reference point of the chassis by `moved_m` in the body's axes: to the centre of
    /// mass of the root of another tree.
    pub fn recenter(&mut self, moved_m: Vector3<f64>, tree: &Arc<Tree>) {
        let lever_m = self.floor_from_chassis.rotation * moved_m;
        self.floor_from_chassis.translation.vector += lever_m;
        self.velocity_m_s += self.angular_rad_s.cross(&lever_m);
        self.tree = Arc::clone(tree);
        self.place_links();
    }

    /// Copies another state of the same robot without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.take_poses(other);
        self.velocity_m_s = other.velocity_m_s;
        self.angular_rad_s = other.angular_rad_s;
        self.rates.copy_from_slice(&other.rates);
    }
}
