//! The engine and its state.

use ilon_robot::Robot;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::dynamics::{Generalised, Motion, Posture};
use crate::joint::Bearing;
use crate::play::Play;
use crate::settings::{Contact, Settings};
use crate::solution::Solution;
use crate::tree::Tree;
use crate::{Drive, Energy, OracleError, Push, stability};

/// A robot on contact springs.
#[derive(Clone, Debug)]
pub struct Engine {
    pub(crate) tree: Tree,
    pub(crate) settings: Settings,
    pub(crate) wheel_bearings: Vec<Bearing>,
    pub(crate) roller_bearings: Vec<Bearing>,

    pub(crate) steps: u64,
    /// Position of the body frame's origin, and its orientation.
    pub(crate) origin: Vector3<f64>,
    pub(crate) rotation: UnitQuaternion<f64>,
    pub(crate) wheel_angles: Vec<f64>,
    pub(crate) speeds: Generalised,
    /// Bend of each roller's bristle along the world's x and y, in metres.
    pub(crate) bristles: Vec<Vector2<f64>>,
    /// Where each roller is on its axle.
    pub(crate) plays: Vec<Play>,

    pub(crate) drives: Vec<Drive>,
    pub(crate) seized: Vec<bool>,
    pub(crate) push: Option<Push>,

    pub(crate) contacts: Vec<Contact>,
    pub(crate) energy: Energy,
    pub(crate) posture: Posture,
    pub(crate) solution: Solution,
}

impl Engine {
    /// The robot at rest on the floor, level, the body frame's origin above the world's, wheel angles zero, wheels free. It
    /// stands as deep in its contact springs as its weight presses them on average.
    ///
    /// # Errors
    ///
    /// Rollers that are no exact barrels, parts without inertia, settings out of range, and a step that is too long for the
    /// contact springs.
    pub fn new(robot: &Robot, settings: Settings) -> Result<Self, OracleError> {
        settings.contact.check()?;
        let tree = Tree::new(robot)?;
        let h = settings.step_s;
        if !(h.is_finite() && h > 0.0) {
            return Err(OracleError::Setting {
                setting: "step_s",
                value: h,
                range: "above 0",
            });
        }
        stability::check(&tree, robot, &settings)?;
        let (wheels, rollers) = (tree.wheels.len(), tree.rollers.len());
        let bearings = tree.wheels.iter();
        let wheel_bearings = bearings
            .map(|w| Bearing::new(&w.bearing, w.hub.about_center[(2, 2)], h))
            .collect();
        let bearings = tree.rollers.iter();
        let roller_bearings = bearings
            .map(|r| Bearing::new(&r.bearing, r.axial_inertia, h))
            .collect();
        let weight_n = -settings.gravity_m_s2.z * tree.mass_kg();
        let sag_m = weight_n.max(0.0) / (wheels as f64 * settings.contact.normal_stiffness_n_m);
        Ok(Self {
            wheel_bearings,
            roller_bearings,
            steps: 0,
            origin: Vector3::z() * (robot.ride_height_m() - sag_m),
            rotation: UnitQuaternion::identity(),
            wheel_angles: vec![0.0; wheels],
            speeds: Generalised::zero(&tree),
            bristles: vec![Vector2::zeros(); rollers],
            plays: tree.rollers.iter().map(|roller| roller.play).collect(),
            drives: vec![Drive::Free; wheels],
            seized: vec![false; rollers],
            push: None,
            contacts: Vec::with_capacity(rollers),
            energy: Energy::default(),
            posture: Posture::new(&tree),
            solution: Solution::new(&tree),
            tree,
            settings,
        })
    }

    /// Time since the start, in seconds.
    pub fn time_s(&self) -> f64 {
        self.steps as f64 * self.settings.step_s
    }

    /// Pose of the body frame in the world.
    pub fn world_from_body(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.origin), self.rotation)
    }

    /// Generalised speeds: the body frame's twist in the body frame, the wheels' rates and the rollers' rates against their
    /// hubs.
    pub fn speeds(&self) -> &Generalised {
        &self.speeds
    }

    /// Sets the generalised speeds.
    ///
    /// # Panics
    ///
    /// Where they are for another number of wheels or rollers.
    pub fn set_speeds(&mut self, speeds: Generalised) {
        assert_eq!(speeds.wheels.len(), self.tree.wheels.len());
        assert_eq!(speeds.rollers.len(), self.tree.rollers.len());
        self.speeds = speeds;
        self.solution.accelerations.clear();
    }

    /// Puts the body frame at this pose; bristles and speeds stay as they are.
    pub fn set_world_from_body(&mut self, pose: Isometry3<f64>) {
        self.origin = pose.translation.vector;
        self.rotation = pose.rotation;
    }

    /// Each wheel's angle, in rad.
    pub fn wheel_angles_rad(&self) -> &[f64] {
        &self.wheel_angles
    }

    /// Turns the wheels to these angles in rad.
    ///
    /// # Panics
    ///
    /// Where there are more or fewer of them than wheels.
    pub fn set_wheel_angles_rad(&mut self, angles: &[f64]) {
        self.wheel_angles.copy_from_slice(angles);
    }

    /// Drives a wheel so from the next step on.
    ///
    /// # Panics
    ///
    /// Where the robot has no such wheel.
    pub fn drive(&mut self, wheel: usize, drive: Drive) {
        self.drives[wheel] = drive;
    }

    /// Holds a roller fast on its hub, or frees it, from the next step on. Rollers are counted over all wheels.
    ///
    /// # Panics
    ///
    /// Where the robot has no such roller.
    pub fn seize_roller(&mut self, roller: usize, seized: bool) {
        self.seized[roller] = seized;
    }

    /// Pushes the chassis so from the next step on, or no longer.
    pub fn push(&mut self, push: Option<Push>) {
        self.push = push;
    }

    /// The rollers that touched the floor in the last step.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Normal force on each wheel in the last step, in N.
    pub fn wheel_loads_n(&self) -> Vec<f64> {
        let mut loads = vec![0.0; self.tree.wheels.len()];
        for contact in &self.contacts {
            loads[contact.wheel] += contact.normal_n;
        }
        loads
    }

    /// Torque of each wheel's drive in the last step, in N m; where it is locked, what held it.
    pub fn drive_torques_n_m(&self) -> &[f64] {
        &self.solution.drive_torques
    }

    /// Mass of the whole robot, in kg.
    pub fn mass_kg(&self) -> f64 {
        self.tree.mass_kg()
    }

    /// Momenta and kinetic energy now.
    pub fn motion(&self) -> Motion {
        let mut posture = self.posture.clone();
        posture.update(&self.tree, &self.wheel_angles);
        Motion::new(&self.tree, &posture, &self.speeds)
    }

    /// Where the energy is and went.
    pub fn energy(&self) -> Energy {
        let mut posture = self.posture.clone();
        posture.update(&self.tree, &self.wheel_angles);
        let motion = Motion::new(&self.tree, &posture, &self.speeds);
        let center = self.origin + self.rotation * motion.center_in_body_m;
        let up = self.rotation.inverse() * Vector3::z();
        let law = &self.settings.contact;
        let elastic = |roller: usize| {
            let depth = self.lowest_of(&posture, roller, &up).1;
            0.5 * law.normal_stiffness_n_m * depth.max(0.0).powi(2)
                + 0.5 * law.bristle_stiffness_n_m * self.bristles[roller].norm_squared()
        };
        Energy {
            kinetic_j: motion.kinetic_j,
            gravity_j: -self.tree.mass_kg() * self.settings.gravity_m_s2.dot(&center),
            elastic_j: (0..self.tree.rollers.len()).map(elastic).sum(),
            ..self.energy
        }
    }

    /// A roller's lowest point in the body frame and its depth under the floor, negative above it. `up` is the floor's normal
    /// in the body frame.
    pub(crate) fn lowest_of(
        &self,
        posture: &Posture,
        roller: usize,
        up: &Vector3<f64>,
    ) -> (Vector3<f64>, f64) {
        let outline = &self.tree.rollers[roller].outline;
        let a = &posture.axes[roller];
        let c = &(posture.centers[roller] + a * self.plays[roller].place_m);
        let height = self.origin.z + up.dot(c);
        if height > outline.bound_m() {
            return (*c, outline.bound_m() - height);
        }
        let w = up.dot(a);
        let lowest = outline.lowest(w);
        let point = c + a * lowest.place_m - up * lowest.radius_m;
        (point, -(height + w * lowest.place_m - lowest.radius_m))
    }
}
