//! The engine and its state.

use ilon_robot::Robot;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::generalised::Generalised;
use crate::ground::{Placed, Touch};
use crate::joint::Bearing;
use crate::linkage::Linkage;
use crate::motion::Motion;
use crate::play::Play;
use crate::posture::Posture;
use crate::settings::{Contact, Plate, Settings};
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
    pub(crate) linkage: Linkage,
    pub(crate) plates: Vec<Plate>,

    pub(crate) steps: u64,
    /// Position of the body frame's origin, and its orientation.
    pub(crate) origin: Vector3<f64>,
    pub(crate) rotation: UnitQuaternion<f64>,
    /// Positions of the joints between bodies, in rad or m.
    pub(crate) joints: Vec<f64>,
    pub(crate) wheel_angles: Vec<f64>,
    pub(crate) speeds: Generalised,
    /// Deflection of each roller's bristle on the floor along the world's x and y, in metres; then
    /// those on the first plate, and so on.
    pub(crate) bristles: Vec<Vector2<f64>>,
    /// Each roller's position on its axle.
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
    /// The robot at rest on the floor, level, the body frame's origin above the world's, wheel
    /// angles zero and wheels free. Joints are at zero or the stop nearest to it, or where
    /// couplings put them. The contact springs are compressed by the mean wheel load; springs in
    /// joints are not yet compressed.
    ///
    /// # Errors
    ///
    /// Rollers that are not exact barrels, joints that are neither free nor sprung, parts without
    /// inertia, settings out of range, and a step that is too long for the springs.
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
        let linkage = Linkage::new(&tree, robot, &settings.contact)?;
        stability::check(&tree, robot, &settings, linkage.stiffest(&tree))?;
        let (wheels, rollers) = (tree.wheels.len(), tree.rollers.len());
        let bearings = tree.wheels.iter();
        let wheel_bearings = bearings
            .map(|w| Bearing::new(&w.bearing, w.hub.about_center[(2, 2)], h))
            .collect();
        let bearings = tree.rollers.iter();
        let roller_bearings = bearings
            .map(|r| Bearing::new(&r.bearing, r.axial_inertia, h).loaded(r.held_per_load))
            .collect();
        let weight_n = -settings.gravity_m_s2.z * tree.mass_kg();
        let sag_m = weight_n.max(0.0) / (wheels as f64 * settings.contact.normal_stiffness_n_m);
        Ok(Self {
            wheel_bearings,
            roller_bearings,
            linkage,
            plates: Vec::new(),
            steps: 0,
            origin: Vector3::z() * (robot.ride_height_m() - sag_m),
            rotation: UnitQuaternion::identity(),
            joints: first_positions(&tree),
            wheel_angles: vec![0.0; wheels],
            speeds: Generalised::zero(&tree),
            bristles: vec![Vector2::zeros(); rollers],
            plays: tree.rollers.iter().map(|roller| roller.play).collect(),
            drives: vec![Drive::Free; wheels],
            seized: tree.rollers.iter().map(|part| part.is_tyre).collect(),
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

    /// Generalised speeds: the body frame's twist in the body frame, the rates of the joints
    /// between bodies, the wheels' rates, and the rollers' rates relative to their hubs.
    pub fn speeds(&self) -> &Generalised {
        &self.speeds
    }

    /// Sets the generalised speeds.
    ///
    /// # Panics
    ///
    /// If their numbers of joints, wheels or rollers differ from the robot's.
    pub fn set_speeds(&mut self, speeds: Generalised) {
        assert_eq!(speeds.joints.len(), self.tree.joints.len());
        assert_eq!(speeds.wheels.len(), self.tree.wheels.len());
        assert_eq!(speeds.rollers.len(), self.tree.rollers.len());
        self.speeds = speeds;
        self.solution.accelerations.clear();
    }

    /// Moves the body frame to this pose; bristles and speeds are unchanged.
    pub fn set_world_from_body(&mut self, pose: Isometry3<f64>) {
        self.origin = pose.translation.vector;
        self.rotation = pose.rotation;
    }

    /// Replaces the plates on the floor.
    pub fn lay_plates(&mut self, plates: &[Plate]) {
        self.plates = plates.to_vec();
        self.bristles = vec![Vector2::zeros(); self.tree.rollers.len() * (1 + plates.len())];
    }

    /// Positions of the joints between bodies, in the robot's order, in rad or m.
    pub fn joint_positions(&self) -> &[f64] {
        &self.joints
    }

    /// Sets the positions of the joints between bodies, in rad or m.
    ///
    /// # Panics
    ///
    /// If their number differs from the number of joints.
    pub fn set_joint_positions(&mut self, positions: &[f64]) {
        self.joints.copy_from_slice(positions);
    }

    /// Each wheel's angle, in rad.
    pub fn wheel_angles_rad(&self) -> &[f64] {
        &self.wheel_angles
    }

    /// Sets the wheel angles, in rad.
    ///
    /// # Panics
    ///
    /// If their number differs from the number of wheels.
    pub fn set_wheel_angles_rad(&mut self, angles: &[f64]) {
        self.wheel_angles.copy_from_slice(angles);
    }

    /// Sets a wheel's drive from the next step on.
    ///
    /// # Panics
    ///
    /// If the robot has no such wheel.
    pub fn drive(&mut self, wheel: usize, drive: Drive) {
        self.drives[wheel] = drive;
    }

    /// Locks a roller to its hub, or frees it, from the next step on. Rollers are counted over all
    /// wheels.
    ///
    /// # Panics
    ///
    /// If the robot has no such roller.
    pub fn seize_roller(&mut self, roller: usize, seized: bool) {
        self.seized[roller] = seized || self.tree.rollers[roller].is_tyre;
    }

    /// Sets or removes the push on the chassis from the next step on.
    pub fn push(&mut self, push: Option<Push>) {
        self.push = push;
    }

    /// The rollers in contact in the last step.
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

    /// Mass of the whole robot, in kg.
    pub fn mass_kg(&self) -> f64 {
        self.tree.mass_kg()
    }

    /// Current momenta and kinetic energy.
    pub fn motion(&self) -> Motion {
        Motion::new(&self.tree, &self.posture_now(), &self.speeds)
    }

    /// The current energy balance.
    pub fn energy(&self) -> Energy {
        let posture = self.posture_now();
        let motion = Motion::new(&self.tree, &posture, &self.speeds);
        let center = self.origin + self.rotation * motion.center_in_body_m;
        let law = &self.settings.contact;
        let pressed = |roller: usize| {
            let depths = self
                .touches(&posture, roller)
                .map(|(_, touch)| touch.depth_m);
            let squares: f64 = depths.map(|depth| depth.powi(2)).sum();
            0.5 * law.normal_stiffness_n_m * squares
        };
        let bent = |bend: &Vector2<f64>| 0.5 * law.bristle_stiffness_n_m * bend.norm_squared();
        Energy {
            kinetic_j: motion.kinetic_j,
            gravity_j: -self.tree.mass_kg() * self.settings.gravity_m_s2.dot(&center),
            elastic_j: (0..self.tree.rollers.len()).map(pressed).sum::<f64>()
                + self.bristles.iter().map(bent).sum::<f64>(),
            joint_springs_j: self.linkage.stored_j(&self.tree, &self.joints),
            ..self.energy
        }
    }

    fn posture_now(&self) -> Posture {
        let mut posture = self.posture.clone();
        posture.update(&self.tree, &self.joints, &self.wheel_angles);
        posture
    }

    /// The contacts of a roller, each with the index of the piece of ground: 0 is the floor, then
    /// come the plates.
    pub(crate) fn touches<'a>(
        &'a self,
        posture: &Posture,
        roller: usize,
    ) -> impl Iterator<Item = (usize, Touch)> + 'a {
        let shape = &self.tree.rollers[roller].shape;
        let axis = &posture.axes[roller];
        let in_body = posture.centers[roller] + axis * self.plays[roller].place_m;
        let center = self.origin + self.rotation * in_body;
        let highest_m = self
            .plates
            .iter()
            .fold(0.0, |top: f64, p| top.max(p.height_m));
        let near = center.z <= shape.bound_m() + highest_m;
        let placed = near.then(|| Placed {
            shape,
            center,
            axis: self.rotation * axis,
        });
        placed.into_iter().flat_map(|placed| {
            let on_plates = self.plates.iter().map(move |plate| placed.on(plate));
            let all = std::iter::once(placed.on_the_floor()).chain(on_plates);
            let all = all.enumerate();
            all.filter_map(|(piece, touch)| touch.filter(|t| t.depth_m > 0.0).map(|t| (piece, t)))
        })
    }
}

/// Start positions of the joints: zero or the stop nearest to it, or where couplings put them.
fn first_positions(tree: &Tree) -> Vec<f64> {
    let nearest = |[low, high]: [f64; 2]| 0.0_f64.max(low).min(high);
    let mut positions: Vec<f64> = tree.joints.iter().map(|j| nearest(j.law.limits)).collect();
    for _ in &tree.couplings {
        for of in &tree.couplings {
            positions[of.joint] = of.factor * positions[of.follows] + of.offset;
        }
    }
    positions
}
