//! The whole robot.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point3, Vector2, Vector3};

use super::scale::{LEAST_GRAVITY_M_S2, Scale};
use super::{BodyJoint, Collision, Coupling, JointKind, JointRole, MassProperties, Remark, Wheel};

/// An omnidirectional robot: a chassis carried by N >= 3 driven wheels with passive rollers.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// The robot's name in its file.
    pub name: String,
    /// Everything that neither turns with a wheel or roller nor moves on a joint.
    pub chassis: Chassis,
    /// Bodies other than the chassis, each with its joint, parents before their children; empty for
    /// a rigid robot.
    pub joints: Vec<BodyJoint>,
    /// Couplings between these joints.
    pub couplings: Vec<Coupling>,
    /// The driven wheels, in the order of their joints in the file.
    pub wheels: Vec<Wheel>,
    /// What the loader ignored or doubts.
    pub remarks: Vec<Remark>,
}

/// The rigid body that carries the wheels, or the joints that do. Links on fixed joints are merged
/// into it.
#[derive(Clone, Debug, PartialEq)]
pub struct Chassis {
    /// The name of its link, which is the body frame.
    pub name: String,
    /// Mass properties in the body frame.
    pub mass: MassProperties,
    /// Its collision shapes.
    pub collisions: Vec<Collision>,
}

impl Robot {
    /// Returns the mean radius of its wheels, in metres; it needs at least one.
    pub fn mean_wheel_radius_m(&self) -> f64 {
        let radii_m = self.wheels.iter().map(|wheel| wheel.radius_m);
        radii_m.sum::<f64>() / self.wheels.len() as f64
    }

    /// Mass of the whole robot, in kg.
    pub fn mass_kg(&self) -> f64 {
        let wheel_kg = |w: &Wheel| w.hub.mass_kg + w.rollers.iter().map(|r| r.mass_kg).sum::<f64>();
        let of_joints: f64 = self
            .joints
            .iter()
            .map(|joint| joint.body.mass.mass_kg)
            .sum();
        self.chassis.mass.mass_kg + self.wheels.iter().map(wheel_kg).sum::<f64>() + of_joints
    }

    /// Returns the centre of mass of the whole robot in the body frame while all joints are at
    /// zero, in metres.
    pub fn center_of_mass_m(&self) -> Vector3<f64> {
        let chassis = &self.chassis.mass;
        let mut first_moment = chassis.mass_kg * chassis.center_of_mass_m;
        for wheel in &self.wheels {
            let in_body = |at_m: Vector3<f64>| (wheel.body_from_hub * Point3::from(at_m)).coords;
            first_moment += wheel.hub.mass_kg * in_body(wheel.hub.center_of_mass_m);
            for roller in &wheel.rollers {
                first_moment += roller.mass_kg * in_body(roller.center_in_hub_m);
            }
        }
        for joint in &self.joints {
            first_moment += joint.body.mass.mass_kg * joint.center_of_mass_m();
        }
        first_moment / self.mass_kg()
    }

    /// Whether it has more wheels on its rigid chassis than a plane needs to carry it: four or
    /// more, none of them on a joint. The wheels' heights and their contacts' compliance then
    /// decide which of them touch.
    pub fn has_wheels_to_spare(&self) -> bool {
        self.wheels.len() > 3 && self.wheels.iter().all(|wheel| wheel.carrier.is_none())
    }

    /// Returns the height of the body frame's origin above the ground while the robot stands level,
    /// with wheel angles and joints at zero, in metres.
    pub fn ride_height_m(&self) -> f64 {
        let lowest = |w: &Wheel| w.position_m().z - w.reach_at_rest_m();
        -self.wheels.iter().map(lowest).fold(f64::INFINITY, f64::min)
    }

    /// Returns the paper's q'_max = min_j q'_max_j (before eq. (29)), in rad/s; infinite if no
    /// wheel has a limit.
    pub fn wheel_rate_limit_rad_s(&self) -> f64 {
        self.wheels
            .iter()
            .map(|w| w.motor.velocity_rad_s)
            .fold(f64::INFINITY, f64::min)
    }

    /// Returns the inertia on a joint while all others are at zero, except its followers: the mass
    /// along its axis in kg, or the inertia about it in kg m^2, of its body and everything that it
    /// carries; with followers twice the energy at a rate of 1. Wheels turn freely on their
    /// axles.
    ///
    /// # Panics
    /// If the robot has no such joint.
    pub fn inertia_on_joint(&self, index: usize) -> f64 {
        let rates = self.rates_along(index);
        if rates.iter().filter(|rate| **rate != 0.0).count() > 1 {
            return self.inertia_at(&rates);
        }
        let joint = &self.joints[index];
        let joint_from_body = joint.body_from_joint.inverse();
        let hangs = |carrier: Option<usize>| {
            std::iter::successors(carrier, |at| self.joints[*at].parent).any(|at| at == index)
        };
        let about = |mass_kg: f64, in_body_m: Vector3<f64>, own: f64| match joint.kind {
            JointKind::Slides => mass_kg,
            JointKind::Turns => {
                let at_m = joint_from_body * Point3::from(in_body_m);
                own + mass_kg * at_m.coords.xy().norm_squared()
            }
        };
        let bodies = self.joints.iter().enumerate();
        let bodies = bodies.filter(|(at, _)| hangs(Some(*at))).map(|(_, of)| {
            let axis = (joint_from_body * of.body_from_joint).inverse() * Vector3::z();
            let own = axis.dot(&(of.body.mass.inertia_kg_m2 * axis));
            about(of.body.mass.mass_kg, of.center_of_mass_m(), own)
        });
        let wheels = self.wheels.iter().filter(|wheel| hangs(wheel.carrier));
        let wheels = wheels.map(|wheel| {
            let mass = wheel.carried_mass(|_| false).moved(&wheel.body_from_hub);
            let [axis, axle] = [joint.body_from_joint, wheel.body_from_hub]
                .map(|body_from| body_from * Vector3::z());
            let of = |axis: &Vector3<f64>| axis.dot(&(mass.inertia_kg_m2 * axis));
            let own = of(&axis) - axis.dot(&axle).powi(2) * of(&axle);
            about(mass.mass_kg, mass.center_of_mass_m, own)
        });
        bodies.sum::<f64>() + wheels.sum::<f64>()
    }

    /// Returns the largest [`Robot::inertia_on_joint`] over poses in which all others are at zero,
    /// or one joint that it carries is turned by a quarter to either side, within its limits: the
    /// inertia of a stretched arm.
    ///
    /// # Panics
    /// If the robot has no such joint.
    pub fn most_inertia_on_joint(&self, index: usize) -> f64 {
        let hangs = |at: usize| {
            std::iter::successors(self.joints[at].parent, |at| self.joints[*at].parent)
                .any(|at| at == index)
        };
        let turns = |at: &usize| self.joints[*at].kind == JointKind::Turns && hangs(*at);
        let poses = (0..self.joints.len()).filter(turns).flat_map(|at| {
            [-FRAC_PI_2, FRAC_PI_2].map(|turned| {
                let [lower, upper] = self.joints[at].limits;
                let mut positions = vec![0.0; self.joints.len()];
                positions[at] = turned.max(lower).min(upper);
                self.couple(&mut positions);
                self.posed(&positions).inertia_on_joint(index)
            })
        });
        poses.fold(self.inertia_on_joint(index), f64::max)
    }

    /// Returns the rate of each joint while one moves at 1 and all others stand, except its
    /// followers.
    fn rates_along(&self, index: usize) -> Vec<f64> {
        let mut rates = vec![0.0; self.joints.len()];
        rates[index] = 1.0;
        // Each pass sets the followers of joints that are already set.
        for _ in &self.couplings {
            let others = self.couplings.iter().filter(|of| of.joint != index);
            for of in others {
                rates[of.joint] = of.factor * rates[of.follows];
            }
        }
        rates
    }

    /// Returns twice the kinetic energy in J for joint rates in rad/s or m/s, with all joints at
    /// zero.
    fn inertia_at(&self, rates: &[f64]) -> f64 {
        // Velocity of a point carried by a joint, and its angular velocity.
        let moves = |carrier: Option<usize>, at_m: &Vector3<f64>| {
            let joints = std::iter::successors(carrier, |at| self.joints[*at].parent);
            let mut moves = (Vector3::zeros(), Vector3::zeros());
            for at in joints {
                let frame = &self.joints[at].body_from_joint;
                let along = frame.rotation * Vector3::z() * rates[at];
                match self.joints[at].kind {
                    JointKind::Slides => moves.0 += along,
                    JointKind::Turns => {
                        moves.0 += along.cross(&(at_m - frame.translation.vector));
                        moves.1 += along;
                    }
                }
            }
            moves
        };
        let bodies = self.joints.iter().enumerate().map(|(at, of)| {
            let (velocity, turning) = moves(Some(at), &of.center_of_mass_m());
            let turning = of.body_from_joint.rotation.inverse() * turning;
            let mass = &of.body.mass;
            mass.mass_kg * velocity.norm_squared() + turning.dot(&(mass.inertia_kg_m2 * turning))
        });
        let wheels = self.wheels.iter().map(|wheel| {
            let rollers_kg: f64 = wheel.rollers.iter().map(|roller| roller.mass_kg).sum();
            let (velocity, _) = moves(wheel.carrier, &wheel.position_m());
            (wheel.hub.mass_kg + rollers_kg) * velocity.norm_squared()
        });
        bodies.sum::<f64>() + wheels.sum::<f64>()
    }

    /// Whether any of its wheels rolls on a tyre.
    pub fn has_tyres(&self) -> bool {
        self.wheels.iter().any(Wheel::has_tyre)
    }

    /// Returns the joint that steers a wheel, by its index in [`Robot::joints`]: the nearest one
    /// above it that a servo turns about an upright axis. `None` for a wheel that is not steered.
    pub fn steering_of(&self, wheel: &Wheel) -> Option<usize> {
        let steers = |at: &usize| {
            let joint = &self.joints[*at];
            joint.turns_upright() && joint.servo().is_some()
        };
        std::iter::successors(wheel.carrier, |at| self.joints[*at].parent).find(steers)
    }

    /// Returns n . (k x r) in metres of a joint that steers a pair: driven tyres side by side on
    /// axles along n, whose middle lies at r from the axis of the joint, on a robot that no
    /// unsteered tyre holds. `None` for other joints. 0 where the middle lies within a twentieth of
    /// the track of the axis (chosen): steered by that lever the rate would have no bound.
    pub fn pair_lever_m(&self, joint: usize) -> Option<f64> {
        let is_held =
            |of: &Wheel| of.has_tyre() && self.steering_of(of).is_none() && !self.swivels(of);
        let is_its = |of: &&Wheel| {
            of.has_tyre() && of.motor.effort_n_m > 0.0 && self.steering_of(of) == Some(joint)
        };
        let wheels: Vec<&Wheel> = self.wheels.iter().filter(is_its).collect();
        let n = wheels.first()?.axis();
        let places_m: Vec<Vector2<f64>> = wheels.iter().map(|of| of.position_m().xy()).collect();
        let off_m = |place_m: &Vector2<f64>| n.dot(&(place_m - places_m[0])).abs();
        let track_m = places_m.iter().map(off_m).fold(0.0, f64::max);
        let middle_m = places_m.iter().sum::<Vector2<f64>>() / places_m.len() as f64;
        let r = middle_m - self.joints[joint].body_from_joint.translation.vector.xy();
        let lever_m = Some(r.perp(&n)).filter(|lever_m| lever_m.abs() > 0.05 * track_m);
        let is_pair = track_m > 0.0 && !self.wheels.iter().any(is_held);
        is_pair.then_some(lever_m.unwrap_or(0.0))
    }

    /// Whether a wheel is a caster's: nothing drives its tyre, and it swivels freely.
    pub fn swivels(&self, wheel: &Wheel) -> bool {
        let is_free = |at: usize| {
            let joint = &self.joints[at];
            joint.turns_upright() && joint.role == JointRole::Free
        };
        let mut way = std::iter::successors(wheel.carrier, |at| self.joints[*at].parent);
        wheel.has_tyre() && wheel.motor.effort_n_m == 0.0 && way.any(is_free)
    }

    /// Returns the joints of its casters, by their indices in [`Robot::joints`]: those that turn
    /// freely about an upright axis and carry no wheel of [`Robot::wheels`], and the free ones
    /// below them, on which the casters' own wheels roll.
    pub fn caster_joints(&self) -> Vec<usize> {
        let way = |at: usize| std::iter::successors(Some(at), |at| self.joints[*at].parent);
        let swivels = |at: usize| {
            let joint = &self.joints[at];
            let carries =
                |wheel: &Wheel| wheel.carrier.is_some_and(|on| way(on).any(|on| on == at));
            joint.turns_upright()
                && joint.role == JointRole::Free
                && !self.wheels.iter().any(carries)
        };
        let is_free = |at: usize| self.joints[at].role == JointRole::Free;
        let is_of_one = |at: &usize| is_free(*at) && way(*at).any(swivels);
        let has_shapes = |at: usize| !self.joints[at].body.collisions.is_empty();
        let found: Vec<usize> = (0..self.joints.len()).filter(is_of_one).collect();
        match found.iter().any(|at| has_shapes(*at)) {
            true => found,
            false => Vec::new(),
        }
    }

    /// Returns the joints by which casters point where they roll, by their indices in
    /// [`Robot::joints`]: [`Robot::caster_joints`], and the free upright ones above wheels that no
    /// motor drives.
    pub fn castering(&self) -> Vec<usize> {
        let casters = self.wheels.iter().filter(|wheel| self.swivels(wheel));
        let above = casters.flat_map(|wheel| self.joints_above(wheel));
        let is_swivel = |at: &usize| {
            self.joints[*at].role == JointRole::Free && self.joints[*at].turns_upright()
        };
        let mut found = self.caster_joints();
        found.extend(above.filter(is_swivel));
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Returns the joints between the chassis and a wheel, from the chassis on, by their indices in
    /// [`Robot::joints`].
    pub fn joints_above(&self, wheel: &Wheel) -> Vec<usize> {
        let mut way: Vec<usize> =
            std::iter::successors(wheel.carrier, |at| self.joints[*at].parent).collect();
        way.reverse();
        way
    }
}

impl Scale {
    /// The units of a robot with at least one wheel, in a gravity in m/s^2.
    pub fn of(robot: &Robot, gravity_m_s2: f64) -> Self {
        let count = robot.wheels.len() as f64;
        Self {
            length_m: robot.mean_wheel_radius_m(),
            load_kg: robot.mass_kg() / count,
            gravity_m_s2: gravity_m_s2.max(LEAST_GRAVITY_M_S2),
        }
    }
}
