//! Driven wheels.

use nalgebra::{Isometry3, Matrix3, Unit, Vector2, Vector3};

use super::{
    Barrel, DriveTrain, Joint, MassProperties, MotorLimits, Roller, RollerForm, RollerSurface,
    RollersAsMade,
};

/// A driven wheel: hub, motor, and the passive rollers on its rim (a Swedish wheel) or a tyre.
#[derive(Clone, Debug, PartialEq)]
pub struct Wheel {
    /// The name of the wheel's joint.
    pub name: String,
    /// The carrier: the body of a joint, by its index in [`Robot::joints`](super::Robot::joints);
    /// `None` for the chassis.
    pub carrier: Option<usize>,
    /// Pose of the hub frame in the body frame at wheel angle zero and joints at zero: origin at
    /// the wheel's centre, z along the hub axis, x straight down.
    pub body_from_hub: Isometry3<f64>,
    /// Mass properties of the hub without its rollers, in the hub frame.
    pub hub: MassProperties,
    /// The paper's rho: distance from the hub axis to the ground, in metres.
    pub radius_m: f64,
    /// The paper's gamma, signed: the angle from the hub axis to the rolling direction of the
    /// roller that points down, counter-clockwise seen from above, in (-pi/2, pi/2]. The sign is
    /// the wheel's handedness. 0 for a wheel with a tyre.
    pub gamma_rad: f64,
    /// The rollers, ordered by their angle about the hub axis; of a wheel without rollers its tyre
    /// alone (see [`Roller::tyre`]).
    pub rollers: Vec<Roller>,
    /// The motor's limits, at the wheel.
    pub motor: MotorLimits,
    /// Damping and friction of the wheel's own bearing and gear.
    pub joint: Joint,
    /// The gear and the rotor behind it.
    pub drive: DriveTrain,
    /// The tread and friction of its rollers.
    pub surface: RollerSurface,
    /// Material of its rollers, a name used by a world's material pairs; `None` if not given.
    pub material: Option<String>,
    /// How its rollers are made; their forms follow from it (see [`Wheel::make_rollers`]).
    pub made: RollersAsMade,
}

impl Wheel {
    /// Whether it has a tyre instead of rollers: it rolls along its circumference and resists all
    /// sideways motion.
    pub fn has_tyre(&self) -> bool {
        self.rollers.iter().any(Roller::is_tyre)
    }

    /// The wheel's centre in the body frame: the paper's **b**, with its height, in metres.
    pub fn position_m(&self) -> Vector3<f64> {
        self.body_from_hub.translation.vector
    }

    /// The hub axis **n** in the ground plane of the body frame.
    pub fn axis(&self) -> Vector2<f64> {
        let n = self.body_from_hub.rotation * Vector3::z();
        n.xy().normalize()
    }

    /// The roller's rolling direction **u**_gamma in the body frame, of the roller that points
    /// straight down: the hub axis turned by gamma.
    pub fn roller_rolling_direction(&self) -> Vector2<f64> {
        let (s, c) = libm::sincos(self.gamma_rad);
        let n = self.axis();
        Vector2::new(c * n.x - s * n.y, s * n.x + c * n.y)
    }

    /// The roller's axis **n**_gamma = **k** x **u**_gamma in the body frame, of the roller that
    /// points straight down.
    pub fn roller_axis(&self) -> Vector2<f64> {
        let u_gamma = self.roller_rolling_direction();
        Vector2::new(-u_gamma.y, u_gamma.x)
    }

    /// Returns the mass of the hub and its rollers in the hub's frame, without the inertia of rollers
    /// about their axles, except those that are `seized` by their index.
    pub fn carried_mass(&self, seized: impl Fn(usize) -> bool) -> MassProperties {
        let rollers = self.rollers.iter().enumerate();
        let carried = rollers.map(|(index, roller)| {
            let d = roller.axis_in_hub.into_inner();
            let along = d * d.transpose();
            let mut inertia_kg_m2 = roller.transverse_inertia_kg_m2 * (Matrix3::identity() - along);
            if seized(index) {
                inertia_kg_m2 += roller.axial_inertia_kg_m2 * along;
            }
            MassProperties {
                inertia_kg_m2,
                ..MassProperties::point(roller.mass_kg, roller.center_in_hub_m)
            }
        });
        let parts: Vec<MassProperties> = [self.hub.clone()].into_iter().chain(carried).collect();
        MassProperties::merged(&parts).unwrap_or_else(|| self.hub.clone())
    }

    /// Returns how far the wheel reaches down from its centre at wheel angle zero, in metres: its
    /// radius if its outline is a circle, else the largest reach of its rollers.
    pub fn reach_at_rest_m(&self) -> f64 {
        self.reach_in_body_m(&-Vector3::z_axis())
    }

    /// Returns how far the wheel reaches from its centre at wheel angle zero in a direction of the
    /// body frame across its axis, in metres: its radius if its outline is a circle, else the
    /// largest reach of its rollers.
    pub(super) fn reach_in_body_m(&self, direction: &Unit<Vector3<f64>>) -> f64 {
        self.reach_in_hub_m(&(self.body_from_hub.rotation.inverse() * direction.into_inner()))
    }

    /// Returns how far the wheel reaches from its centre in a unit direction of the hub frame
    /// across its axis, in metres.
    pub(super) fn reach_in_hub_m(&self, in_hub: &Vector3<f64>) -> f64 {
        let is_round = self.is_round();
        let reach_m = |roller: &Roller| match &roller.form {
            RollerForm::Barrel if is_round => self.radius_m,
            RollerForm::Barrel | RollerForm::Made(_) => {
                let barrel = self.barrel(roller);
                let w = roller.axis_in_hub.dot(in_hub);
                let t_m = barrel.support_place_m(w);
                roller.center_in_hub_m.dot(in_hub) + t_m * w + barrel.sphere_radius_m(t_m)
            }
            RollerForm::Turned(turned) | RollerForm::Tyre(turned) => {
                let w = roller.axis_in_hub.dot(in_hub);
                roller.center_in_hub_m.dot(in_hub) + turned.profile().support_m(w)
            }
            RollerForm::AsModelled(modelled) => {
                let hub_from_roller = roller.hub_from_roller();
                let in_roller = hub_from_roller.rotation.inverse() * in_hub;
                let reaches = modelled
                    .shapes
                    .iter()
                    .map(|shape| shape.reach_m(&in_roller));
                hub_from_roller.translation.vector.dot(in_hub)
                    + reaches.fold(f64::NEG_INFINITY, f64::max)
            }
        };
        let reaches = self.rollers.iter().map(reach_m);
        reaches.reduce(f64::max).unwrap_or(self.radius_m)
    }

    /// Coulomb friction of bearing and gear together, at the wheel, in N m.
    pub fn dry_friction_n_m(&self) -> f64 {
        self.joint.friction_n_m + self.drive.gear_friction_n_m
    }

    /// Returns the barrel of one of this wheel's rollers (see [`crate::barrel_profile`]); the ideal
    /// one if the roller is no barrel.
    pub fn barrel(&self, roller: &Roller) -> Barrel {
        match &roller.form {
            RollerForm::Made(barrel) => *barrel,
            _ => self.ideal_barrel(roller),
        }
    }

    /// Returns the barrel at a roller's place, axis and length that makes the wheel's outline a
    /// circle.
    pub(super) fn ideal_barrel(&self, roller: &Roller) -> Barrel {
        Barrel {
            wheel_radius_m: self.radius_m,
            ring_radius_m: roller.ring_radius_m(),
            sin_delta: libm::cos(self.gamma_rad),
            half_length_m: 0.5 * roller.length_m,
        }
    }
}
