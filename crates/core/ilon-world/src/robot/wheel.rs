//! One wheel in the world: its hub as a link, and its rollers as flywheels on it.
//!
//! The mass of a roller and its inertia across its axis move with the hub and belong to the hub's
//! body; the rest is a flywheel with its own rate (`roller`).

use ilon_robot::{RollerSurface, Scale, Tread, Wheel};
use nalgebra::Vector3;

use crate::contact::law::tread::{Spring, TreadLaw};
use crate::robot::roller::RollerState;

/// The hub of a wheel and its rollers.
#[derive(Clone, Debug)]
pub(crate) struct WheelBody {
    /// The hub's joint in the robot's tree.
    pub joint: usize,
    /// The largest distance of a point of the wheel's rollers from the hub's centre, in metres.
    pub reach_m: f64,
    /// Contact properties of the rollers.
    pub surface: Surface,
    /// The share of the ground's friction for its rollers: 1, or a value set by the program.
    pub grip: f64,
    /// Whether its rollers make a circle of its outline, wherever they are on their axles. Not so
    /// of a tyre, which touches in several places.
    pub is_round: bool,
    /// Whether its rollers can slide along their axles.
    pub has_play: bool,
    /// The rollers.
    pub rollers: Vec<RollerState>,
    /// The unexpected part of the rollers' bearing torques on the hub in the last step, in its
    /// frame, in N m: applied in the next.
    pub owed_in_hub_n_m: Vector3<f64>,
    /// The expected bearing torques in this step, and the angular momentum of the rollers about
    /// their axes, in its frame, in N m and kg m^2/s.
    bearings_in_hub_n_m: Vector3<f64>,
    momentum_in_hub: Vector3<f64>,
}

/// Contact properties of the rollers of a wheel, under the load of their robot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// The tread of soft rollers, or of rollers with play.
    pub tread: Option<TreadLaw>,
    /// Coefficient of rolling resistance: drag over load.
    pub rolling_resistance: f64,
    /// Largest torque of the friction on a roller's axle over the load, in N m/N.
    pub axle_drag_m: f64,
    /// The mass supported by a wheel, in kg.
    pub load_kg: f64,
}

impl Surface {
    fn of((surface, beside_tyres): (&RollerSurface, bool), scale: &Scale) -> Self {
        let load_kg = scale.load_kg;
        let law = |tread: &Tread| TreadLaw {
            normal: Spring {
                stiffness_n_m: tread.stiffness_n_m,
                damping_n_s_m: tread.damping_under_n_s_m(load_kg),
            },
            shear: Spring {
                stiffness_n_m: tread.shear_n_m(),
                damping_n_s_m: tread.shear_damping_under_n_s_m(load_kg),
            },
            renewal_1_m: tread
                .relaxation_length_m
                .map_or(0.0, |lambda_m| 1.0 / lambda_m),
            load_kg,
        };
        Self {
            tread: surface
                .touching_tread(scale, beside_tyres)
                .as_ref()
                .map(law),
            rolling_resistance: surface.rolling_resistance,
            axle_drag_m: surface.axle_drag_n_m(1.0),
            load_kg,
        }
    }
}

impl WheelBody {
    /// Whether its rollers have treads.
    pub fn is_compliant(&self) -> bool {
        self.surface.tread.is_some()
    }

    /// A wheel on a joint of its robot's tree, with its rollers. `scale` has the robot's units, and
    /// `beside_tyres` says whether the robot has tyres.
    pub fn new(
        (wheel, beside_tyres): (&Wheel, bool),
        joint: usize,
        rollers: Vec<RollerState>,
        scale: &Scale,
    ) -> Self {
        let play_m = wheel.surface.axial_play_m;
        let reach_m = |roller: &RollerState| {
            let center_m = roller.hub_from_roller.translation.vector.norm();
            center_m + roller.bounding_radius_m + 0.5 * play_m
        };
        Self {
            joint,
            reach_m: rollers.iter().map(reach_m).fold(0.0, f64::max),
            surface: Surface::of((&wheel.surface, beside_tyres), scale),
            grip: 1.0,
            is_round: wheel.is_round() && play_m == 0.0 && !wheel.has_tyre(),
            has_play: play_m > 0.0,
            rollers,
            owed_in_hub_n_m: Vector3::zeros(),
            bearings_in_hub_n_m: Vector3::zeros(),
            momentum_in_hub: Vector3::zeros(),
        }
    }

    /// Begins a step of `dt_s` for the rollers.
    pub fn begin_step(&mut self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) {
        self.bearings_in_hub_n_m = self.owed_in_hub_n_m;
        self.momentum_in_hub = Vector3::zeros();
        for roller in &mut self.rollers {
            self.momentum_in_hub += roller.momentum_in_hub();
            self.bearings_in_hub_n_m +=
                roller.begin_step(hub_rate_in_hub_rad_s, dt_s) * roller.axis_in_hub;
        }
    }

    /// The torque of the rollers on a hub with this angular velocity in the step, in its frame, in
    /// N m: their bearings' torques, and the gyroscopic torque of the flywheels, -W x (I w d),
    /// which does no work.
    pub fn torque_on_hub_n_m(&self, hub_rate_in_hub_rad_s: &Vector3<f64>) -> Vector3<f64> {
        self.bearings_in_hub_n_m - hub_rate_in_hub_rad_s.cross(&self.momentum_in_hub)
    }

    /// Ends the step, with the hub's mean rate. Returns the energy taken by the bearings, in J.
    pub fn end_step(&mut self, hub_mean_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> f64 {
        self.owed_in_hub_n_m = Vector3::zeros();
        let mut lost_j = 0.0;
        for roller in &mut self.rollers {
            let borne = roller.end_step(hub_mean_in_hub_rad_s, dt_s);
            lost_j += borne.lost_j;
            self.owed_in_hub_n_m += borne.owed_n_m * roller.axis_in_hub;
        }
        lost_j
    }

    /// Moves rollers with play along their axles to the end of a step, with gravity in the hub's
    /// frame, in m/s^2. Returns the energy lost as they leave the ground, in J.
    pub fn slide_rollers(&mut self, gravity_in_hub: &Vector3<f64>, dt_s: f64) -> f64 {
        let mut lost_j = 0.0;
        for roller in &mut self.rollers {
            let along = gravity_in_hub.dot(&roller.axis_in_hub);
            lost_j += roller.end_slide(along, dt_s);
        }
        lost_j
    }
}
