//! One roller of a wheel: its constant properties, and its motion about its axis.
//!
//! A roller is round, and its middle and axis are fixed to the hub. So its motion is the hub's
//! except for one number: its rate about its own axis, whose momentum I w only its bearing and the
//! ground change. That is exact, and a roller takes one number instead of a body, a joint and a row
//! of the mass matrix.

use std::ops::Deref;
use std::sync::Arc;

use ilon_robot::{Barrel, Roller, RollerForm, SolidOfRevolution, Wheel};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use parry3d::shape::SharedShape;

use crate::contact::search::nearest::PlacedBarrel;
use crate::contact::search::solid::Solid;
use crate::contact::search::turned_profile::PlacedProfile;
use crate::dynamics::LinkPose;
use crate::engine::shapes::shape_of_roller;
use crate::robot::axial_play::{AxleSlide, Slide};

/// The effect of a bearing in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BearingStep {
    /// Energy that the bearing took, in J.
    pub lost_j: f64,
    /// The difference between its torque on the hub about the roller's axis and the expected one,
    /// in N m.
    pub owed_n_m: f64,
}

/// Inertia of a roller's joint if rapier solves the contacts, as a multiple of the roller's own
/// about its axis: the smallest one that keeps sticking rollers below 1 mm/s at 1000 steps a
/// second. Without any they slide at 10 mm/s. Chosen.
pub(crate) const ARMATURE: f64 = 3.0;

/// The armature of a seized roller, in kg m^2: 0.1 N m, more than a contact's torque on a roller,
/// takes 1000 s to give it 0.1 rad/s. Chosen.
const SEIZED_KG_M2: f64 = 1e3;

/// The constant properties of a roller: its place on its wheel, its shape, its inertia and its
/// bearing. All copies of a robot share it.
#[derive(Debug)]
pub(crate) struct FixedRoller {
    /// Pose of the roller frame in the hub frame.
    pub hub_from_roller: Isometry3<f64>,
    /// The roller's axis in the hub frame.
    pub axis_in_hub: Vector3<f64>,
    /// The exact barrel; `None` for other shapes.
    pub barrel: Option<Barrel>,
    /// The profile by numbers, if it has one.
    pub turned: Option<SolidOfRevolution>,
    /// The shape of its file, if it uses that, in its own frame.
    pub shape: Option<SharedShape>,
    /// Radius of a ball around its middle that holds it whole, in metres.
    pub bounding_radius_m: f64,
    /// Whether it is a tyre, which turns with its hub for good.
    pub is_tyre: bool,
    /// Inertia about its axis, in kg m^2.
    axial_inertia_kg_m2: f64,
    /// Bearing damping, in N m s/rad.
    damping_n_m_s: f64,
    /// Bearing dry friction, in N m.
    pub friction_n_m: f64,
    /// The roller in the middle of its play, if it has any.
    slide: Option<Slide>,
}

impl FixedRoller {
    /// A roller of a wheel.
    pub fn new(wheel: &Wheel, roller: &Roller) -> Self {
        let (barrel, turned) = match &roller.form {
            RollerForm::AsModelled(_) => (None, None),
            RollerForm::Turned(turned) | RollerForm::Tyre(turned) => (None, Some(turned.clone())),
            _ => (Some(wheel.barrel(roller)), None),
        };
        let shape = match &roller.form {
            RollerForm::AsModelled(modelled) => shape_of_roller(modelled),
            _ => None,
        };
        let play_m = wheel.surface.axial_play_m;
        let bounding_radius_m = match (&barrel, &turned) {
            (Some(barrel), _) => PlacedBarrel::bounding_radius_m(barrel),
            (None, Some(turned)) => turned.bounding_radius_m(),
            (None, None) => 0.5 * roller.length_m + roller.radius_m,
        };
        Self {
            hub_from_roller: roller.hub_from_roller(),
            axis_in_hub: roller.hub_from_roller().rotation * Vector3::z(),
            bounding_radius_m,
            is_tyre: roller.is_tyre(),
            barrel,
            turned,
            shape,
            axial_inertia_kg_m2: roller.axial_inertia_kg_m2,
            damping_n_m_s: roller.joint.damping_n_m_s,
            friction_n_m: roller.joint.friction_n_m,
            slide: (play_m > 0.0).then(|| Slide::in_the_middle(play_m, roller.mass_kg)),
        }
    }
}

/// A roller and its motion about its axis.
#[derive(Clone, Debug)]
pub(crate) struct RollerState {
    fixed: Arc<FixedRoller>,
    /// Absolute rate about its own axis, in rad/s: its spin relative to the hub plus the hub's own
    /// rate about that axis. Only its bearing and contacts change it, however the hub rotates.
    pub axial_rate_rad_s: f64,
    /// The mean of that rate over the last step, if the ground touched it, in rad/s.
    pub mean_rate_rad_s: f64,
    /// The hub's own rate about that axis at the beginning of the step, in rad/s.
    hub_carries_rad_s: f64,
    /// The expected bearing torque on the hub in the step, in N m.
    expected_n_m: f64,
    /// Whether that assumed a roller in the air.
    was_in_the_air: bool,
    /// Whether the ground touched it in the last step.
    pub touched: bool,
    /// Whether the ground pressed on it in the last step.
    pub pressed: bool,
    /// The energy still needed to bring it to its spin since it came down, in J.
    pub spin_up_left_j: f64,
    /// Angle about its axis since the start, in radians, for rollers whose shape is not round.
    pub angle_rad: f64,
    /// The share of its spin that damping leaves in a step in the air, and the length of that step
    /// in seconds.
    damping_leaves: (f64, f64),
    /// Whether the roller has seized on its axle; a tyre always has.
    pub seized: bool,
    /// Where it is along its axle, if it has play.
    pub slide: Option<Box<Slide>>,
}

/// Its constant properties are accessible like its own fields.
impl Deref for RollerState {
    type Target = FixedRoller;

    fn deref(&self) -> &FixedRoller {
        &self.fixed
    }
}

impl RollerState {
    /// A roller at rest.
    pub fn at_rest(fixed: Arc<FixedRoller>) -> Self {
        Self {
            slide: fixed.slide.clone().map(Box::new),
            seized: fixed.is_tyre,
            fixed,
            axial_rate_rad_s: 0.0,
            mean_rate_rad_s: 0.0,
            hub_carries_rad_s: 0.0,
            expected_n_m: 0.0,
            was_in_the_air: false,
            touched: false,
            pressed: false,
            spin_up_left_j: 0.0,
            angle_rad: 0.0,
            damping_leaves: (1.0, 0.0),
        }
    }

    /// Height of the roller's middle on a hub, in the floor's frame, in metres.
    #[inline]
    pub fn height_m(&self, hub: &LinkPose) -> f64 {
        self.center_m(hub).z
    }

    /// The roller's middle on a hub, in the floor's frame, in metres.
    #[inline]
    pub fn center_m(&self, hub: &LinkPose) -> Vector3<f64> {
        let in_hub_m = &self.hub_from_roller.translation.vector;
        match self.place_m() {
            0.0 => hub.place_m(in_hub_m),
            place_m => hub.place_m(&(in_hub_m + place_m * self.axis_in_hub)),
        }
    }

    /// Its position along its axle, in metres; 0 without play.
    pub fn place_m(&self) -> f64 {
        self.slide.as_ref().map_or(0.0, |slide| slide.place_m)
    }

    /// Its axial motion at the beginning of a step near the ground; zero without play, or if it has
    /// seized.
    pub fn slide_on_ground(&self) -> AxleSlide {
        let slide = self.slide.as_ref().filter(|_| !self.seized);
        slide.map_or_else(AxleSlide::default, |slide| slide.on_ground())
    }

    /// Moves it along its axle to the end of a step, with gravity along its axis in m/s^2. Returns
    /// the energy lost as it leaves the ground, in J.
    pub fn end_slide(&mut self, gravity: f64, dt_s: f64) -> f64 {
        let pressed = self.pressed;
        match &mut self.slide {
            Some(slide) if !self.seized => slide.end_step(pressed, gravity, dt_s),
            _ => 0.0,
        }
    }

    /// Its barrel in the pose of a hub, in the floor's frame; `None` if it has the shapes of its
    /// file.
    pub fn placed_barrel(&self, hub: &LinkPose) -> Option<PlacedBarrel<'_>> {
        let barrel = self.barrel.as_ref()?;
        Some(PlacedBarrel {
            barrel,
            center_m: self.center_m(hub),
            axis: hub.rotation * self.axis_in_hub,
        })
    }

    /// The shapes of its file in the pose of a hub, in the floor's frame; `None` for other rollers.
    pub fn placed_shape(&self, hub: &LinkPose) -> Option<Solid<'_>> {
        let shape = self.shape.as_ref()?;
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.angle_rad);
        let rotation = UnitQuaternion::from_matrix(&hub.rotation);
        let floor_from_hub = Isometry3::from_parts(hub.center_m.into(), rotation);
        Some(Solid {
            shape,
            floor_from_shape: floor_from_hub * self.hub_from_roller * turned,
        })
    }

    /// Its profile by numbers in the pose of a hub, in the floor's frame; `None` without one.
    pub fn placed_profile(&self, hub: &LinkPose) -> Option<PlacedProfile<'_>> {
        let turned = self.turned.as_ref()?;
        Some(PlacedProfile {
            turned,
            center_m: self.center_m(hub),
            axis: hub.rotation * self.axis_in_hub,
        })
    }

    /// Radii of curvature of its surface at the support point in a direction's opposite in the
    /// floor's frame, along its outline and around its axis, in metres; `None` if it has the shapes
    /// of its file, or stands upright.
    pub fn radii_m(&self, hub: &LinkPose, normal: &Vector3<f64>) -> Option<[f64; 2]> {
        /// Nearer to upright than this, as the sine of the angle between axis and ground, it does
        /// not roll. Chosen.
        const LEAST_LEVEL: f64 = 1e-3;
        let axis = hub.rotation * self.axis_in_hub;
        let w_axial = -normal.dot(&axis);
        if 1.0 - w_axial * w_axial < LEAST_LEVEL * LEAST_LEVEL {
            return None;
        }
        if let Some(barrel) = &self.barrel {
            let around_m = barrel.sphere_radius_m(barrel.support_place_m(w_axial));
            return Some([barrel.outline_radius_m(w_axial), around_m]);
        }
        self.placed_profile(hub)
            .map(|turned| turned.radii_m(normal))
    }

    /// Seizes the roller on its axle, or frees it; in both cases it does not turn relative to its
    /// hub at that moment.
    pub fn seize(&mut self, seized: bool, hub_rate_in_hub_rad_s: &Vector3<f64>) {
        self.seized = seized || self.is_tyre;
        if let Some(slide) = &mut self.slide {
            slide.seize();
        }
        self.axial_rate_rad_s = self.carried_rad_s(hub_rate_in_hub_rad_s);
    }

    /// The rate about the roller's axis of a hub with this angular velocity in its own frame, in
    /// rad/s.
    fn carried_rad_s(&self, hub_rate_in_hub_rad_s: &Vector3<f64>) -> f64 {
        hub_rate_in_hub_rad_s.dot(&self.axis_in_hub)
    }

    /// The roller's spin relative to its hub, whose angular velocity in the hub frame is given, in
    /// rad/s.
    pub fn spin_rad_s(&self, hub_rate_in_hub_rad_s: &Vector3<f64>) -> f64 {
        if self.seized {
            return 0.0;
        }
        self.axial_rate_rad_s - self.carried_rad_s(hub_rate_in_hub_rad_s)
    }

    /// Sets a spin relative to the hub, in rad/s.
    pub fn set_spin(&mut self, spin_rad_s: f64, hub_rate_in_hub_rad_s: &Vector3<f64>) {
        self.axial_rate_rad_s = spin_rad_s + self.carried_rad_s(hub_rate_in_hub_rad_s);
    }

    /// The armature of the roller's joint if rapier solves the contacts, in kg m^2.
    pub fn armature_kg_m2(&self) -> f64 {
        if self.seized {
            SEIZED_KG_M2
        } else {
            ARMATURE * self.axial_inertia_kg_m2
        }
    }

    /// Energy that brings the roller to another spin, in J: half of its inertia times the square of
    /// the difference.
    pub fn spin_up_j(&self, missing_rad_s: f64) -> f64 {
        0.5 * self.axial_inertia_kg_m2 * missing_rad_s * missing_rad_s
    }

    /// The roller's angular momentum about its axis, in the hub frame, in kg m^2/s; for a seized
    /// roller, that with its hub.
    pub fn momentum_in_hub(&self) -> Vector3<f64> {
        if self.seized {
            return Vector3::zeros();
        }
        self.axial_inertia_kg_m2 * self.axial_rate_rad_s * self.axis_in_hub
    }

    /// Begins a step on a hub with this angular velocity in its own frame. Returns the expected
    /// torque of the bearing on the hub about the roller's axis, in N m: for a roller on the ground
    /// that at a constant spin, otherwise the one that slows it.
    pub fn begin_step(&mut self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> f64 {
        self.hub_carries_rad_s = self.carried_rad_s(hub_rate_in_hub_rad_s);
        if let Some(slide) = &mut self.slide {
            slide.begin_step(dt_s);
        }
        self.was_in_the_air = !self.touched;
        self.expected_n_m = if self.seized {
            0.0
        } else if self.touched {
            self.damping_n_m_s * (self.axial_rate_rad_s - self.hub_carries_rad_s)
        } else {
            self.coasting_torque_n_m(dt_s)
        };
        self.expected_n_m
    }

    /// The roller's rate about its axis after a step without the ground, in rad/s, for
    /// [`RollerState::response`].
    pub fn free_rate_rad_s(&self, dt_s: f64) -> f64 {
        let momentum = self.axial_inertia_kg_m2 * self.axial_rate_rad_s;
        (momentum + self.damping_n_m_s * dt_s * self.hub_carries_rad_s) * self.response(dt_s)
    }

    /// The roller's rate change in a step per angular impulse of 1 N m s about its axis, in rad/s:
    /// its bearing's damping acts with the rate after the step.
    pub fn response(&self, dt_s: f64) -> f64 {
        1.0 / (self.axial_inertia_kg_m2 + self.damping_n_m_s * dt_s)
    }

    /// Ends a step: the bearing slows a roller without contact. Its work uses the mean spin, for
    /// which the hub's mean rate is given; dry friction of a roller in contact is among the
    /// reactions.
    pub fn end_step(&mut self, hub_mean_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> BearingStep {
        if self.seized {
            return BearingStep::default();
        }
        let (torque_n_m, mean_rad_s) = if self.touched {
            let torque_n_m = self.damping_n_m_s * (self.axial_rate_rad_s - self.hub_carries_rad_s);
            (torque_n_m, self.mean_rate_rad_s)
        } else {
            let torque_n_m = if self.was_in_the_air {
                self.expected_n_m
            } else {
                self.coasting_torque_n_m(dt_s)
            };
            let before_rad_s = self.axial_rate_rad_s;
            self.axial_rate_rad_s -= torque_n_m * dt_s / self.axial_inertia_kg_m2;
            (torque_n_m, 0.5 * (before_rad_s + self.axial_rate_rad_s))
        };
        let spin_rad_s = mean_rad_s - self.carried_rad_s(hub_mean_in_hub_rad_s);
        self.angle_rad += spin_rad_s * dt_s;
        BearingStep {
            lost_j: torque_n_m * spin_rad_s * dt_s,
            owed_n_m: torque_n_m - self.expected_n_m,
        }
    }

    /// The mean torque that slows a roller in the air over a step: I d(spin)/dt = -damping spin -
    /// friction sign(spin), solved exactly for the damping; dry friction never reverses the spin.
    fn coasting_torque_n_m(&mut self, dt_s: f64) -> f64 {
        let inertia = self.axial_inertia_kg_m2;
        let spin = self.axial_rate_rad_s - self.hub_carries_rad_s;
        if self.damping_leaves.1 != dt_s {
            self.damping_leaves = (libm::exp(-self.damping_n_m_s / inertia * dt_s), dt_s);
        }
        let damped = spin * self.damping_leaves.0;
        let stopping = self.friction_n_m / inertia * dt_s;
        let slowed = damped.signum() * (damped.abs() - stopping).max(0.0);
        inertia * (spin - slowed) / dt_s
    }
}
