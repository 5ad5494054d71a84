//! The wheels' places under joints between bodies, and the effect of moving them.
//!
//! A wheel rolls off the whole velocity of its hub, v_h = v + omega x b + db/dt, so that Indiveri
//! 2009, eq. (5), has db/dt beside the body's motion. Its encoder measures the rolling rate except
//! for the rotation of its carrier.
//!
//! A driven joint has an encoder, so the robot knows its position, and that of a joint coupled to
//! it. A free or sprung joint is not measured: the robot assumes zero.

use ilon_control::Kinematics;
use ilon_robot::{JointRole, Robot, Twist, Wheel};
use nalgebra::{Isometry3, Vector3};

/// The wheels of a robot at some joint positions.
#[derive(Clone)]
pub(crate) struct Hubs {
    robot: Robot,
    /// The joint positions for which the other fields hold, in rad or m; empty before the first.
    positions: Vec<f64>,
    /// Pose of each hub in the body frame at these positions, at wheel angle zero.
    body_from_hubs: Vec<Isometry3<f64>>,
    /// For the last positions at which a twist follows from the wheels' rates.
    kinematics: Option<Kinematics>,
    carried_rad: Vec<f64>,
    rates_rad: Vec<f64>,
    /// The lever of the pair to which each wheel belongs, and how the joints of those with one
    /// moved the body along the axles since the last update.
    pair_levers_m: Vec<Option<f64>>,
    along_axles: Twist,
}

impl Hubs {
    /// For a robot without joint positions yet.
    pub fn new(robot: &Robot) -> Self {
        let wheels = robot.wheels.len();
        let lever_m = |wheel: &Wheel| {
            let is_driven = wheel.has_tyre() && wheel.motor.effort_n_m > 0.0;
            robot.pair_lever_m(robot.steering_of(wheel).filter(|_| is_driven)?)
        };
        Self {
            robot: robot.clone(),
            positions: Vec::new(),
            body_from_hubs: Vec::new(),
            kinematics: None,
            carried_rad: vec![0.0; wheels],
            rates_rad: vec![0.0; wheels],
            pair_levers_m: robot.wheels.iter().map(lever_m).collect(),
            along_axles: Twist::default(),
        }
    }

    /// The same, if a joint that the robot measures moves a wheel.
    pub fn that_move(robot: &Robot) -> Option<Self> {
        let measured = measured(robot);
        let moves = |mut carrier: Option<usize>| {
            while let Some(joint) = carrier {
                if measured[joint] {
                    return true;
                }
                carrier = robot.joints[joint].parent;
            }
            false
        };
        let mut wheels = robot.wheels.iter();
        (wheels.any(|wheel| moves(wheel.carrier))).then(|| Self::new(robot))
    }

    /// Updates the joint positions, in rad or m, and returns whether they have moved.
    pub fn see(&mut self, positions: &[f64]) -> bool {
        self.carried_rad.fill(0.0);
        self.along_axles = Twist::default();
        if self.positions == positions && self.kinematics.is_some() {
            return false;
        }
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        let hubs = self.robot.body_from_hubs(positions);
        let before = std::mem::replace(&mut self.body_from_hubs, hubs);
        let found = match &self.kinematics {
            Some(kinematics) => kinematics.moved(&self.body_from_hubs),
            None => Kinematics::new(&self.robot.posed(positions)),
        };
        self.kinematics = found.ok().or(self.kinematics.take());
        let Some(kinematics) = &self.kinematics else {
            return true;
        };
        let mut along_m = vec![0.0; before.len()];
        for (wheel, (now, then)) in self.body_from_hubs.iter().zip(&before).enumerate() {
            let moved_m = now.translation.vector - then.translation.vector;
            let turned = (now.rotation * then.rotation.inverse()).scaled_axis();
            let asked = Twist::new(moved_m.x, moved_m.y, 0.0);
            kinematics.wheel_rates(asked, &mut self.rates_rad);
            self.carried_rad[wheel] =
                turned.dot(&(now.rotation * Vector3::z())) - self.rates_rad[wheel];
            if self.is_of_caster(wheel) {
                along_m[wheel] = moved_m.dot(&(now.rotation * Vector3::z()));
            }
        }
        if along_m.iter().any(|along_m| *along_m != 0.0) {
            self.along_axles = kinematics.carried_along_axles(&along_m);
        }
        true
    }

    /// The kinematics at these positions; `None` before the first, and if no twist follows from the
    /// wheels' rates there.
    pub fn kinematics(&self) -> Option<&Kinematics> {
        self.kinematics.as_ref()
    }

    /// Adds to the wheels' rotation since the last update, in rad, what they rolled because joints
    /// moved them, and returns the body's displacement by eq. (7), which is linear; `None` without
    /// [`Self::kinematics`].
    pub fn displacement(&self, turned_rad: &mut [f64]) -> Option<Twist> {
        let kinematics = self.kinematics()?;
        let turned = turned_rad.iter_mut().zip(&self.carried_rad);
        turned.for_each(|(turned, carried)| *turned += carried);
        Some(kinematics.twist(turned_rad) + self.along_axles)
    }

    /// The angle by which each wheel rolled over the ground because its joints moved it since the
    /// last update, beyond what its encoder measured and for a standing body, in rad.
    pub fn carried_rad(&self) -> &[f64] {
        &self.carried_rad
    }

    /// How the body moved since the last update because its joints moved the wheels of active
    /// casters along their axles, in m and rad.
    pub fn along_axles(&self) -> Twist {
        self.along_axles
    }

    fn is_of_caster(&self, wheel: usize) -> bool {
        self.pair_levers_m[wheel].is_some_and(|lever_m| lever_m != 0.0)
    }

    /// [`Self::carried_rad`] of the wheels of pairs; 0 of the others.
    pub fn carried_of_pairs_rad(&self) -> impl Iterator<Item = f64> {
        let wheels = self.carried_rad.iter().zip(&self.pair_levers_m);
        wheels.map(|(carried, lever_m)| lever_m.map_or(0.0, |_| *carried))
    }

    /// How the body moved since the last update because joints moved the wheels of pairs, which did
    /// not turn, in m and rad.
    pub fn moved_by_pairs(&self) -> Twist {
        let has_pairs = self.pair_levers_m.iter().any(Option::is_some);
        let Some(kinematics) = self.kinematics.as_ref().filter(|_| has_pairs) else {
            return Twist::default();
        };
        let carried_rad: Vec<f64> = self.carried_of_pairs_rad().collect();
        kinematics.twist(&carried_rad) + self.along_axles
    }

    /// Pose of each hub in the body frame with the joints there, at wheel angle zero.
    pub fn body_from_hubs(&self) -> &[Isometry3<f64>] {
        &self.body_from_hubs
    }
}

/// For each joint between bodies, whether the robot knows its position.
pub(crate) fn measured(robot: &Robot) -> Vec<bool> {
    let is_driven = |joint: &ilon_robot::BodyJoint| matches!(joint.role, JointRole::Driven(_));
    let mut measured: Vec<bool> = robot.joints.iter().map(is_driven).collect();
    // A joint may follow one that follows a third.
    for _ in &robot.couplings {
        for coupling in &robot.couplings {
            measured[coupling.joint] |= measured[coupling.follows];
        }
    }
    measured
}

#[cfg(test)]
mod tests {
    use ilon_formats::{JointOptions, LoadOptions, LoadRobot, RoleOption};
    use ilon_robot::Coupling;

    use super::*;

    const URDF: &str = include_str!("../../../../../assets/robots/mecanum4_sprung.urdf");

    /// Of four slides the first is driven, the second follows it, the third the second, and the
    /// fourth is independent, in any order of the couplings.
    #[test]
    fn what_follows_a_measured_joint_is_measured() {
        let free = JointOptions {
            role: Some(RoleOption::Free),
            ..JointOptions::default()
        };
        let slides = ["front_left", "front_right", "rear_left", "rear_right"];
        let joints = slides.map(|wheel| (format!("{wheel}_spring"), free.clone()));
        let mut options = LoadOptions::default();
        options.joints = joints.into();
        let loaded = Robot::from_urdf_str_with(URDF, "mecanum4_sprung.urdf", &options);
        let mut robot = loaded.expect("a robot").robot;
        robot.joints[0].role = JointRole::Driven(ilon_robot::JointServo {
            target: 0.0,
            stiffness: 1e3,
            damping: 1.0,
            effort: 10.0,
            rate_limit: 1.0,
        });
        robot.couplings = [(2, 1), (1, 0)]
            .map(|(joint, follows)| Coupling {
                joint,
                follows,
                factor: -1.0,
                offset: 0.0,
            })
            .to_vec();
        assert_eq!(measured(&robot), [true, true, true, false]);
        assert!(Hubs::that_move(&robot).is_some());
        robot.joints[0].role = JointRole::Free;
        assert_eq!(measured(&robot), [false; 4]);
        assert!(Hubs::that_move(&robot).is_none());
    }
}
