//! A robot as the reader understood it: the content of `ilon inspect`.

use ilon_control::{self as control, Arrangement, ControlError, Kinematics, WheelLoads};
use ilon_files::FileAccess;
use ilon_formats::{Loaded, WheelOutline};
use ilon_robot::{JointKind, JointRole, Robot, RollerSurface, Wheel};
use nalgebra::Vector2;
use serde::Serialize;

mod tyres;

pub use tyres::{HeldInspection, TyreInspection, TyresInspection};

use crate::Error;
use crate::scenario::{Floor, Scenario, Setting};
use crate::simulate::Limits;
use ilon_scenario::choices::{bearing_drag, odd_wheel, wheels_to_spare, wrong_hands};
use ilon_scenario::course::joint_targets::start_positions;

/// A robot as it was understood, and what follows from the places of its wheels.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Inspection {
    /// The robot's name.
    pub name: String,
    /// Mass of the whole robot, in kg.
    pub mass_kg: f64,
    /// The driven wheels.
    pub wheels: Vec<WheelInspection>,
    /// The movable joints between bodies; held joints are left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointInspection>,
    /// The rows of M, Indiveri 2009, equation (8): one a wheel; the last column in metres.
    #[serde(rename = "M")]
    pub m: Vec<[f64; 3]>,
    /// Rank of M; below 3 the robot cannot be controlled (Lemma 1). On tyres of M and the rows that
    /// tyres add below it.
    pub rank: usize,
    /// Singular values of the same rows, largest first.
    pub singular_values: [f64; 3],
    /// Condition number of the same rows; `None` if the rank is below 3.
    pub condition: Option<f64>,
    /// The fault of the wheel arrangement, if it has one.
    pub singularity: Option<String>,
    /// Whether position and heading are decoupled at the body's origin: M_a orthogonal to
    /// span(M_l).
    pub decoupled: bool,
    /// The point of the body frame about which they are decoupled, in metres; `None` if there is
    /// none, and on tyres.
    pub decoupling_point_m: Option<[f64; 2]>,
    /// What tyres hold, of a robot on tyres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tyres: Option<TyresInspection>,
    /// The robot's speed limits from its wheels' rate limits; `None` without rate limits.
    pub speed_limits: Option<SpeedLimits>,
    /// The outline of each wheel as modelled in its file, compared with the fitted wheel. Empty if
    /// the rollers were added by the program, or have a profile by numbers: then the file's shapes
    /// do not roll.
    pub outlines: Vec<WheelOutline>,
    /// What was ignored, repaired, assumed or doubted in the file.
    pub remarks: Vec<String>,
    /// The limits of acceleration, if requested by [`Inspection::with_limits`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<Limits>,
}

/// A wheel as it was understood.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct WheelInspection {
    /// The name of its joint.
    pub name: String,
    /// Centre in the body frame, in metres.
    pub position_m: [f64; 3],
    /// Hub axis in the body frame, in the ground plane.
    pub axis: [f64; 2],
    /// Radius, in metres.
    pub radius_m: f64,
    /// Angle from the hub axis to the rolling direction of the lowest roller, in radians, signed.
    pub gamma_rad: f64,
    /// Number of rollers; 0 on a tyre.
    pub rollers: usize,
    /// Largest radius of the rollers, in metres; 0 on a tyre.
    pub roller_radius_m: f64,
    /// Length of the rollers, in metres; 0 on a tyre.
    pub roller_length_m: f64,
    /// The tyre; `None` on rollers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tyre: Option<TyreInspection>,
    /// Mass with rollers, in kg.
    pub mass_kg: f64,
    /// Load at rest on level ground by statics, with the joints at their positions, in N.
    pub load_n: f64,
    /// Largest torque of the motor, in N m; `None` if the file sets none.
    pub effort_n_m: Option<f64>,
    /// Largest rate of the motor, in rad/s; `None` if the file sets none.
    pub velocity_rad_s: Option<f64>,
    /// Material of the rollers; `None` if it is not specified.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Contact properties of the rollers; `None` for rigid rollers that roll without loss.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceInspection>,
    /// The rollers as manufactured; `None` if their outline makes an exact circle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub made: Option<MadeInspection>,
}

/// A joint between bodies. Numbers of a revolute joint are in rad, of a prismatic one in m.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct JointInspection {
    /// Name.
    pub name: String,
    /// How it moves: `turns` or `slides`.
    pub moves: &'static str,
    /// Its role: `free`, `sprung` or `driven`.
    pub role: &'static str,
    /// Position at which the other figures of the inspection hold: for a driven joint the start of
    /// its servo, otherwise zero.
    pub position: f64,
    /// Lower and upper limit.
    pub limits: [Option<f64>; 2],
    /// The wheels that it moves.
    pub moves_wheels: Vec<String>,
}

impl JointInspection {
    /// The joint `index` (from zero) of a robot, at a position in rad or m.
    fn of(index: usize, position: f64, robot: &Robot) -> Self {
        let joint = &robot.joints[index];
        let is_moved = |wheel: &&Wheel| {
            let parent = |of: &usize| robot.joints[*of].parent;
            std::iter::successors(wheel.carrier, parent).any(|of| of == index)
        };
        let moved = robot.wheels.iter().filter(is_moved);
        let limit = |limit: f64| limit.is_finite().then_some(limit);
        Self {
            name: joint.name.clone(),
            moves: match joint.kind {
                JointKind::Turns => "turns",
                JointKind::Slides => "slides",
            },
            role: match joint.role {
                JointRole::Free => "free",
                JointRole::Sprung(_) => "sprung",
                JointRole::Driven(_) => "driven",
                _ => "other",
            },
            position,
            limits: joint.limits.map(limit),
            moves_wheels: moved.map(|wheel| wheel.name.clone()).collect(),
        }
    }
}

/// The rollers of a wheel as manufactured, and the effect on its hub.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MadeInspection {
    /// Curvature of the outline along the rollers relative to the ideal barrel; `None` for a
    /// profile by numbers.
    pub crown: Option<f64>,
    /// Radius of curvature of the outline along the rollers at their middles, in metres; `None` for
    /// a profile by numbers.
    pub crown_radius_m: Option<f64>,
    /// Smallest radius of the rollers at their middles, in metres.
    pub least_radius_m: f64,
    /// Largest radius of the rollers at their middles, in metres.
    pub largest_radius_m: f64,
    /// Rise and fall of the hub in one turn on level ground, in metres.
    pub hub_travel_m: f64,
    /// Mean height of the hub over one turn, in metres: the effective rolling radius, apart from
    /// the loss by the rollers' tilt.
    pub mean_height_m: f64,
}

impl MadeInspection {
    fn of(wheel: &Wheel) -> Option<Self> {
        let modelled = |roller: &ilon_robot::Roller| {
            matches!(roller.form, ilon_robot::RollerForm::AsModelled(_))
        };
        if wheel.rollers.iter().any(modelled) || wheel.made.is_ideal() && wheel.is_round() {
            return None;
        }
        let heights = wheel.hub_heights();
        let radii_m = || wheel.rollers.iter().map(|roller| roller.radius_m);
        let barrels = wheel.made.profile_m.is_none();
        Some(Self {
            crown: barrels.then_some(wheel.made.crown),
            crown_radius_m: barrels
                .then(|| wheel.rollers.first())
                .flatten()
                .map(|roller| wheel.barrel(roller).crown_radius_m()),
            least_radius_m: radii_m().fold(f64::INFINITY, f64::min),
            largest_radius_m: radii_m().fold(0.0, f64::max),
            hub_travel_m: heights.travel_m,
            mean_height_m: heights.mean_m,
        })
    }
}

/// Contact and bearing properties of rollers that are soft, have drag or have play, with defaults
/// filled in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SurfaceInspection {
    /// Coefficient of rolling resistance: drag over load.
    pub rolling_resistance: f64,
    /// Axial play of each roller from stop to stop, in metres.
    pub axial_play_m: f64,
    /// Friction coefficient between roller and axle.
    pub axle_friction: f64,
    /// Radius of the roller axles, in metres.
    pub axle_radius_m: f64,
    /// Torque of that friction under the wheel's share of the weight, in N m.
    pub axle_drag_n_m: f64,
    /// The tread; `None` for rigid rollers.
    pub tread: Option<TreadInspection>,
}

/// A tread under the load of its robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TreadInspection {
    /// Stiffness along the ground normal, in N/m.
    pub stiffness_n_m: f64,
    /// Damping along the normal, in N s/m.
    pub damping_n_s_m: f64,
    /// Stiffness across the normal, in N/m.
    pub shear_stiffness_n_m: f64,
    /// Damping across the normal, in N s/m.
    pub shear_damping_n_s_m: f64,
    /// Relaxation length of the sheared tread, in metres; `None` if it does not relax.
    pub relaxation_length_m: Option<f64>,
    /// Deflection of a roller that alone carries the wheel's share of the weight, in metres.
    pub sag_m: f64,
}

impl SurfaceInspection {
    fn of(surface: &RollerSurface, load_kg: f64) -> Option<Self> {
        let tread = surface.tread.map(|tread| TreadInspection {
            stiffness_n_m: tread.stiffness_n_m,
            damping_n_s_m: tread.damping_under_n_s_m(load_kg),
            shear_stiffness_n_m: tread.shear_n_m(),
            shear_damping_n_s_m: tread.shear_damping_under_n_s_m(load_kg),
            relaxation_length_m: tread.relaxation_length_m,
            sag_m: load_kg * STANDARD_GRAVITY_M_S2 / tread.stiffness_n_m,
        });
        (*surface != RollerSurface::default()).then_some(Self {
            rolling_resistance: surface.rolling_resistance,
            axial_play_m: surface.axial_play_m,
            axle_friction: surface.axle_friction,
            axle_radius_m: surface.axle_radius_m,
            axle_drag_n_m: surface.axle_drag_n_m(load_kg * STANDARD_GRAVITY_M_S2),
            tread,
        })
    }
}

/// The default gravity of a scenario.
const STANDARD_GRAVITY_M_S2: f64 = 9.81;

/// The robot's top speeds within the rate limits of its wheels.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct SpeedLimits {
    /// Top speed in the slowest direction, without rotation, in m/s.
    pub slowest_direction_m_s: f64,
    /// Top speed in the fastest direction, without rotation, in m/s.
    pub fastest_direction_m_s: f64,
    /// Top yaw rate on the spot, or in the sharpest turn that tyres and steering allow, in rad/s.
    pub yaw_rate_rad_s: f64,
}

/// The outlines of the wheels that roll on the shapes of their file.
fn outlines_of(loaded: &Loaded) -> Vec<WheelOutline> {
    let has_profile = |outline: &&WheelOutline| {
        let mut wheels = loaded.robot.wheels.iter();
        wheels.any(|wheel| wheel.name == outline.wheel && wheel.made.profile_m.is_some())
    };
    let outlines = loaded.outlines.iter();
    outlines.filter(|of| !has_profile(of)).cloned().collect()
}

impl Inspection {
    /// Inspects a robot that was read from a file, even one that cannot be controlled.
    ///
    /// # Errors
    /// [`ControlError::TooFewWheels`].
    pub fn of_loaded(loaded: &Loaded) -> Result<Self, ControlError> {
        Ok(Self {
            outlines: outlines_of(loaded),
            ..Self::of(&loaded.robot)?
        })
    }

    /// Inspects a robot that was read with the keys of a scenario, its joints at the start of their
    /// servos.
    ///
    /// # Errors
    /// [`ControlError::TooFewWheels`], and setpoints outside a joint's range.
    pub fn of_standing(loaded: &Loaded, scenario: &Scenario) -> Result<Self, Error> {
        let positions = start_positions(scenario, &loaded.robot)?;
        Ok(Self {
            outlines: outlines_of(loaded),
            ..Self::at(&loaded.robot, &positions)?
        })
    }

    /// Inspects a model of a robot without the file that it came from.
    ///
    /// # Errors
    /// [`ControlError::TooFewWheels`].
    pub fn of(robot: &Robot) -> Result<Self, ControlError> {
        Self::at(robot, &vec![0.0; robot.joints.len()])
    }

    /// Inspects a robot with its joints at `positions`, in rad or m.
    fn at(robot: &Robot, positions: &[f64]) -> Result<Self, ControlError> {
        let joints = positions.iter().enumerate();
        let joints = joints.map(|(index, position)| JointInspection::of(index, *position, robot));
        let joints = joints.collect();
        let turn = control::sharpest_turn(robot, positions);
        let robot = &robot.posed(positions);
        let arrangement = Arrangement::of(robot)?;
        let mut loads_n = vec![0.0; robot.wheels.len()];
        WheelLoads::new(robot, STANDARD_GRAVITY_M_S2).fill_n(Vector2::zeros(), &mut loads_n);
        let kinematics = Kinematics::new(robot).ok();
        let limits_rad_s: Vec<f64> = robot
            .wheels
            .iter()
            .map(|wheel| wheel.motor.velocity_rad_s)
            .collect();
        let finite = |x: f64| x.is_finite().then_some(x);
        let load_kg = robot.mass_kg() / robot.wheels.len() as f64;
        Ok(Self {
            name: robot.name.clone(),
            mass_kg: robot.mass_kg(),
            wheels: robot
                .wheels
                .iter()
                .zip(loads_n)
                .map(|(wheel, load_n)| WheelInspection::of(wheel, (load_kg, load_n)))
                .collect(),
            joints,
            m: arrangement
                .m
                .row_iter()
                .map(|row| [row[0], row[1], row[2]])
                .collect(),
            rank: arrangement.rank,
            singular_values: arrangement.singular_values,
            condition: finite(arrangement.condition),
            singularity: arrangement.singularity.as_ref().map(ToString::to_string),
            decoupled: kinematics.as_ref().is_some_and(Kinematics::is_decoupled),
            decoupling_point_m: kinematics
                .as_ref()
                .filter(|_| arrangement.held.is_empty())
                .map(|kinematics| kinematics.decoupling_point_m().into()),
            tyres: TyresInspection::of(&arrangement, turn),
            speed_limits: kinematics
                .map(|kinematics| control::SpeedLimits::new(&kinematics, &limits_rad_s))
                .and_then(|limits| SpeedLimits::of(&limits, turn)),
            outlines: Vec::new(),
            remarks: robot
                .remarks
                .iter()
                .map(ToString::to_string)
                .chain(bearing_drag::remarks(
                    robot,
                    Floor::default().friction(),
                    STANDARD_GRAVITY_M_S2,
                ))
                .chain(wheels_to_spare::remark(robot, None, STANDARD_GRAVITY_M_S2))
                .chain(wrong_hands(robot))
                .chain(odd_wheel(robot))
                .collect(),
            limits: None,
        })
    }

    /// Adds the accelerations that the robot can hold when simulated under a scenario's floor,
    /// motors, wheel loops and payloads.
    ///
    /// # Errors
    /// Those of [`Limits::held`].
    pub fn with_limits(mut self, scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        self.limits = Some(Limits::held(scenario, robot)?);
        Ok(self)
    }

    /// Like [`Self::with_limits`], under conditions given as keys of a scenario with a standing
    /// robot: floor, slope, motors, rollers, payloads, wheel loop law. Files that the keys name
    /// must be permitted by `files`.
    ///
    /// # Errors
    /// Unknown keys, invalid conditions, and those of [`Limits::held`].
    pub fn with_limits_under(
        self,
        settings: &[Setting],
        robot: &Robot,
        files: &FileAccess,
    ) -> Result<Self, Error> {
        let (scenario, robot) = conditions(settings, robot, files)?;
        self.with_limits(&scenario, &robot)
    }
}

/// A scenario with a standing robot and these settings.
///
/// # Errors
/// Unknown keys and invalid conditions.
pub fn standing(settings: &[Setting], files: &FileAccess) -> Result<Scenario, Error> {
    const STANDING: &str = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1.0\n";
    let scenario = Scenario::from_toml_with(STANDING, "the conditions", "", settings, files)?;
    scenario.validate()?;
    Ok(scenario)
}

/// A scenario with a standing robot and these settings, and the robot with the scenario's motors
/// and rollers.
///
/// # Errors
/// Unknown keys and invalid conditions.
pub fn conditions(
    settings: &[Setting],
    robot: &Robot,
    files: &FileAccess,
) -> Result<(Scenario, Robot), Error> {
    let scenario = standing(settings, files)?;
    let mut robot = robot.clone();
    scenario.motors.apply(&mut robot);
    scenario.rollers.apply(&mut robot)?;
    Ok((scenario, robot))
}

impl WheelInspection {
    fn of(wheel: &Wheel, (load_kg, load_n): (f64, f64)) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        let rollers = || wheel.rollers.iter().filter(|roller| !roller.is_tyre());
        let largest = |of: fn(&ilon_robot::Roller) -> f64| rollers().map(of).fold(0.0, f64::max);
        let rollers_kg: f64 = wheel.rollers.iter().map(|roller| roller.mass_kg).sum();
        Self {
            name: wheel.name.clone(),
            position_m: wheel.position_m().into(),
            axis: wheel.axis().into(),
            radius_m: wheel.radius_m,
            gamma_rad: wheel.gamma_rad,
            rollers: rollers().count(),
            roller_radius_m: largest(|roller| roller.radius_m),
            roller_length_m: largest(|roller| roller.length_m),
            tyre: TyreInspection::of(wheel),
            load_n,
            mass_kg: wheel.hub.mass_kg + rollers_kg,
            effort_n_m: finite(wheel.motor.effort_n_m),
            velocity_rad_s: finite(wheel.motor.velocity_rad_s),
            material: wheel.material.clone(),
            surface: SurfaceInspection::of(&wheel.surface, load_kg),
            made: MadeInspection::of(wheel),
        }
    }
}

impl SpeedLimits {
    /// Whether it is as fast in every direction, to rounding.
    pub fn is_even(&self) -> bool {
        let (least, most) = (self.slowest_direction_m_s, self.fastest_direction_m_s);
        most - least < 1e-9 * most
    }

    /// `None` if the wheels leave a motion unlimited. `turn` is the sharpest on tyres.
    fn of(limits: &control::SpeedLimits, turn: Option<control::Turn>) -> Option<Self> {
        let (slowest_direction_m_s, fastest_direction_m_s) = limits.top_speed_range_m_s();
        let yaw_rate_rad_s = match turn {
            Some(turn) => 1.0 / limits.share(turn.twist_in_body),
            None => limits.top_yaw_rate_rad_s(),
        };
        let all_finite = fastest_direction_m_s.is_finite() && yaw_rate_rad_s.is_finite();
        all_finite.then_some(Self {
            slowest_direction_m_s,
            fastest_direction_m_s,
            yaw_rate_rad_s,
        })
    }
}
