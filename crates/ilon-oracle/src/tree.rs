//! The robot as a tree of bodies: chassis, hubs on the chassis, rollers on the hubs.

use ilon_robot::{Joint, Robot, Roller, RollerForm, Wheel};
use nalgebra::{Matrix3, Vector3};

use crate::OracleError;
use crate::outline::Outline;
use crate::play::Play;

/// Mass, centre and inertia of a body, in the frame that it is fixed to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inertia {
    pub mass: f64,
    pub center: Vector3<f64>,
    /// About the centre, along the frame's axes.
    pub about_center: Matrix3<f64>,
}

impl From<&ilon_robot::MassProperties> for Inertia {
    fn from(of: &ilon_robot::MassProperties) -> Self {
        Self {
            mass: of.mass_kg,
            center: of.center_of_mass_m,
            about_center: of.inertia_kg_m2,
        }
    }
}

/// A roller, in the frame of its hub.
#[derive(Clone, Debug)]
pub(crate) struct RollerPart {
    pub center_in_hub: Vector3<f64>,
    pub axis_in_hub: Vector3<f64>,
    pub mass: f64,
    pub axial_inertia: f64,
    pub transverse_inertia: f64,
    pub outline: Outline,
    pub bearing: Joint,
    pub play: Play,
}

/// A hub, in the body frame.
#[derive(Clone, Debug)]
pub(crate) struct WheelPart {
    pub origin_in_body: Vector3<f64>,
    pub axis_in_body: Vector3<f64>,
    /// At wheel angle zero.
    pub body_from_hub: Matrix3<f64>,
    pub hub: Inertia,
    pub bearing: Joint,
    /// Its rollers, as a range of [`Tree::rollers`].
    pub rollers: std::ops::Range<usize>,
}

/// The tree: the wheels stand in the robot's order, the rollers wheel by wheel.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub chassis: Inertia,
    pub wheels: Vec<WheelPart>,
    pub rollers: Vec<RollerPart>,
}

impl Tree {
    pub fn new(robot: &Robot) -> Result<Self, OracleError> {
        let mut rollers = Vec::new();
        let mut wheels = Vec::new();
        for wheel in &robot.wheels {
            let first = rollers.len();
            for roller in &wheel.rollers {
                rollers.push(roller_part(wheel, roller)?);
            }
            wheels.push(wheel_part(wheel, first..rollers.len())?);
        }
        Ok(Self {
            chassis: (&robot.chassis.mass).into(),
            wheels,
            rollers,
        })
    }

    /// Mass of all bodies, in kg.
    pub fn mass_kg(&self) -> f64 {
        let hubs: f64 = self.wheels.iter().map(|w| w.hub.mass).sum();
        let rollers: f64 = self.rollers.iter().map(|r| r.mass).sum();
        self.chassis.mass + hubs + rollers
    }
}

fn wheel_part(wheel: &Wheel, rollers: std::ops::Range<usize>) -> Result<WheelPart, OracleError> {
    let body_from_hub = wheel.body_from_hub.rotation.to_rotation_matrix();
    let hub = Inertia::from(&wheel.hub);
    if hub.about_center[(2, 2)] <= 0.0 {
        let part = wheel.name.clone();
        return Err(OracleError::NoInertia { part });
    }
    Ok(WheelPart {
        origin_in_body: wheel.body_from_hub.translation.vector,
        axis_in_body: body_from_hub * Vector3::z(),
        body_from_hub: body_from_hub.into_inner(),
        hub,
        bearing: wheel.joint,
        rollers,
    })
}

fn roller_part(wheel: &Wheel, roller: &Roller) -> Result<RollerPart, OracleError> {
    if !matches!(roller.form, RollerForm::Barrel | RollerForm::Made(_)) {
        let roller = roller.name.clone();
        return Err(OracleError::NoBarrel { roller });
    }
    if roller.axial_inertia_kg_m2 <= 0.0 {
        let part = roller.name.clone();
        return Err(OracleError::NoInertia { part });
    }
    Ok(RollerPart {
        center_in_hub: roller.center_in_hub_m,
        axis_in_hub: roller.axis_in_hub.into_inner(),
        mass: roller.mass_kg,
        axial_inertia: roller.axial_inertia_kg_m2,
        transverse_inertia: roller.transverse_inertia_kg_m2,
        outline: Outline::new(&wheel.barrel(roller)),
        bearing: roller.joint,
        play: Play {
            half_m: 0.5 * wheel.surface.axial_play_m,
            mass_kg: roller.mass_kg,
            ..Play::default()
        },
    })
}
