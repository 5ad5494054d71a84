//! The short description of a robot from which [`crate::generate`] writes URDF.
//!
//! The body frame of a described robot has its origin on the ground, x forward, y left and z up, so
//! a robot at z = 0 stands on the floor.

mod bearings;
mod changed;
mod check;
mod described;
mod on_tyres;
mod ranges;
mod reading;
mod suspension;

use std::collections::BTreeMap;

use ilon_files::defaults::number;
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::model::{DriveTrain, RollerSurface, RollersAsMade, Tread};
use crate::solid::Solid;

pub use bearings::RollerBearings;
pub(crate) use check::check;
pub(crate) use described::Described;
pub(crate) use on_tyres::is_on_tyres;
pub use on_tyres::{CasterSpec, SpecOnTyres, SteeringSpec, TyreSpec, TyredWheel};
pub use suspension::{SuspensionLaw, SuspensionSpec};

/// Largest description, in bytes: one with thousands of wheels stays below.
const MAX_BYTES: u64 = 1 << 20;

/// A robot in short: one chassis, and wheels that are alike but for place, axis, handedness, and
/// what is overridden of some.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Robot")]
pub struct Spec {
    /// The robot's name.
    pub name: String,
    /// The body that carries the wheels.
    pub chassis: ChassisSpec,
    /// What all wheels have in common.
    pub wheel: WheelSpec,
    /// What all rollers have in common.
    pub rollers: RollerSpec,
    /// Where the wheels sit and which way they roll.
    pub wheels: Arrangement,
    /// `[suspension.NAME]`: a rocker, springs or trailing arms between chassis and wheels. Other
    /// wheels are fixed to the chassis.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub suspension: BTreeMap<String, SuspensionSpec>,
    /// `[overrides.NAME]`: other values for one wheel, worn or mounted differently.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub overrides: BTreeMap<String, WheelOverride>,
}

/// The chassis: a solid of even density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChassisSpec {
    /// Its shape.
    pub shape: ChassisShape,
    /// Mass in kg.
    pub mass_kg: f64,
    /// Its centre in the body frame, whose origin is on the ground, in metres.
    #[serde(deserialize_with = "exactly")]
    pub center_m: [f64; 3],
}

/// The shape of a chassis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ChassisShape {
    /// `shape.box = { size_m = [x, y, z] }`: a box along the body's axes.
    Box {
        /// Its sides along x, y and z, in metres.
        #[serde(deserialize_with = "exactly")]
        size_m: [f64; 3],
    },
    /// `shape.cylinder = { radius_m = ..., height_m = ... }`: an upright cylinder.
    Cylinder {
        /// Radius in metres.
        radius_m: f64,
        /// Height in metres.
        height_m: f64,
    },
}

impl ChassisShape {
    /// It as a solid.
    pub(crate) fn solid(&self) -> Solid {
        match *self {
            Self::Box { size_m } => Solid::Box {
                size_m: size_m.into(),
            },
            Self::Cylinder { radius_m, height_m } => Solid::Cylinder {
                radius_m,
                length_m: height_m,
            },
        }
    }
}

/// What all wheels have in common. The hub is a solid cylinder about the hub axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WheelSpec {
    /// The paper's rho: from the hub axis to the ground, in metres.
    pub radius_m: f64,
    /// Mass of the hub without its rollers, in kg.
    pub hub_mass_kg: f64,
    /// Radius of the hub, in metres.
    pub hub_radius_m: f64,
    /// Width of the hub along its axis, in metres.
    pub hub_width_m: f64,
    /// Largest torque of the motor at the wheel, behind its gear, in N m.
    pub motor_effort_n_m: f64,
    /// Largest rate of the motor at the wheel, behind its gear, in rad/s.
    pub motor_velocity_rad_s: f64,
    /// Viscous damping of the wheel's bearing and gear, in N m s/rad.
    #[serde(default)]
    pub damping_n_m_s: f64,
    /// Dry friction of the wheel's bearing and gear, in N m.
    #[serde(default)]
    pub friction_n_m: f64,
    /// Turns of the motor's rotor per turn of the wheel.
    #[serde(default = "number::<1, f64>")]
    pub gear_ratio: f64,
    /// Inertia of the rotor before the gear, in kg m^2; the wheel feels gear_ratio^2 times it.
    #[serde(default)]
    pub rotor_inertia_kg_m2: f64,
    /// Efficiency eta of the gear, in (0, 1]. Where the load drives, 2 - 1 / eta of its power
    /// arrives at the motor; up to 0.5 the gear locks itself.
    #[serde(default = "number::<1, f64>")]
    pub gear_efficiency: f64,
    /// Dry friction of the gear at the wheel, in N m, beside `friction_n_m`.
    #[serde(default)]
    pub gear_friction_n_m: f64,
}

impl WheelSpec {
    /// The hub as a solid, with its axis along z.
    pub(crate) fn hub(&self) -> Solid {
        Solid::Cylinder {
            radius_m: self.hub_radius_m,
            length_m: self.hub_width_m,
        }
    }

    /// The gear and the rotor before it.
    pub fn drive(&self) -> DriveTrain {
        DriveTrain {
            gear_ratio: self.gear_ratio,
            rotor_inertia_kg_m2: self.rotor_inertia_kg_m2,
            gear_efficiency: self.gear_efficiency,
            gear_friction_n_m: self.gear_friction_n_m,
        }
    }
}

/// All rollers. By default a barrel of even density, with neither gap nor overlap.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RollerSpec {
    /// Number of rollers in one row.
    pub per_row: usize,
    /// Number of rows: 1, or 2 with the second row half a pitch further.
    #[serde(default = "number::<1, usize>")]
    pub rows: usize,
    /// Distance between the two rows along the hub axis, in metres; 0 with one row.
    #[serde(default)]
    pub row_spacing_m: f64,
    /// Largest radius of a roller, at its middle, in metres.
    pub radius_m: f64,
    /// Mass of one roller, in kg.
    pub mass_kg: f64,
    /// Viscous damping of the roller's bearing, in N m s/rad.
    #[serde(default)]
    pub damping_n_m_s: f64,
    /// Dry friction of the roller's bearing, in N m.
    #[serde(default)]
    pub friction_n_m: f64,
    /// Length of a roller, above 0; 1 leaves neither gap nor overlap. Longer rollers share the
    /// ground (with a tread); shorter ones leave gaps.
    #[serde(default = "number::<1, f64>", skip_serializing_if = "is_unity")]
    pub length_factor: f64,
    /// Curvature along a roller at its middle, relative to the ideal barrel: 1 makes the wheel a
    /// circle, less is flatter, more is rounder; at least 0.01.
    #[serde(default = "number::<1, f64>", skip_serializing_if = "is_unity")]
    pub crown: f64,
    /// `[[t, radius], ...]`, in metres: outline instead of a barrel, t along the axis from the
    /// middle, joined by straight lines. Two points make a cylinder.
    #[serde(default, deserialize_with = "pairs")]
    pub profile_m: Option<Vec<[f64; 2]>>,
    /// Radius to which all edges of `profile_m` are rounded, in metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub edge_radius_m: f64,
    /// Tolerance of the rollers' radius, in metres: each differs at random, evenly between minus
    /// and plus this.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub radius_spread_m: f64,
    /// Seed of `radius_spread_m`.
    #[serde(default, skip_serializing_if = "is_none")]
    pub radius_seed: u32,
    /// Error of the radius of single rollers, in metres, by joint name: `front_left_roller_1 =
    /// 0.0001`. Instead of random ones.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub radius_offsets_m: BTreeMap<String, f64>,
    /// Rolling resistance of the rollers: drag per load, dimensionless.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rolling_resistance: f64,
    /// Play of each roller along its axle, from stop to stop, in metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub axial_play_m: f64,
    /// Class of the rollers' bearings, which sets `axle_friction` and `axle_radius_m` [default: no
    /// friction that grows with the load].
    pub bearings: Option<RollerBearings>,
    /// Friction coefficient between roller and axle; overrides `bearings`. The torque is this times
    /// `axle_radius_m` times the load.
    pub axle_friction: Option<f64>,
    /// Radius of the rollers' axles, in metres; overrides `bearings`. Of a rolling bearing that of
    /// its bore.
    pub axle_radius_m: Option<f64>,
    /// A soft tread. Without it rollers are rigid.
    pub tread: Option<TreadSpec>,
    /// Material of the rollers: a name of a scenario's `[materials]`.
    pub material: Option<String>,
}

/// A tread.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreadSpec {
    /// Stiffness along the ground's normal, in N/m.
    pub stiffness_n_m: f64,
    /// Damping along the normal, in N s/m [default: a tenth of critical under the load of a wheel].
    pub damping_n_s_m: Option<f64>,
    /// Stiffness across the normal, in N/m [default: 2/3 of that along it].
    pub shear_stiffness_n_m: Option<f64>,
    /// Damping across the normal, in N s/m [default: the same share of stiffness as along it].
    pub shear_damping_n_s_m: Option<f64>,
    /// Rolled distance over which sheared tread is renewed, in metres. A roller creeps by pull /
    /// (`shear_stiffness_n_m` times this) [default: no creep].
    pub relaxation_length_m: Option<f64>,
}

impl RollerSpec {
    /// How the rollers are made.
    pub fn made(&self) -> RollersAsMade {
        RollersAsMade {
            crown: self.crown,
            profile_m: self.profile_m.clone(),
            edge_radius_m: self.edge_radius_m,
            radius_spread_m: self.radius_spread_m,
            radius_seed: u64::from(self.radius_seed),
            radius_offsets_m: self.radius_offsets_m.clone(),
        }
    }

    /// The tread and friction of the rollers.
    pub fn surface(&self) -> RollerSurface {
        let tread = self.tread.as_ref().map(|said| Tread {
            stiffness_n_m: said.stiffness_n_m,
            damping_n_s_m: said.damping_n_s_m,
            shear_stiffness_n_m: said.shear_stiffness_n_m,
            shear_damping_n_s_m: said.shear_damping_n_s_m,
            relaxation_length_m: said.relaxation_length_m,
        });
        let bearings = self
            .bearings
            .map(|kind| (kind.axle_friction(), kind.axle_radius_m(self.radius_m)));
        RollerSurface {
            tread,
            rolling_resistance: self.rolling_resistance,
            axial_play_m: self.axial_play_m,
            axle_friction: self.axle_friction.or(bearings.map(|b| b.0)).unwrap_or(0.0),
            axle_radius_m: self.axle_radius_m.or(bearings.map(|b| b.1)).unwrap_or(0.0),
        }
    }
}

fn is_unity(number: &f64) -> bool {
    *number == 1.0
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

fn is_none(number: &u32) -> bool {
    *number == 0
}

/// Other values for one wheel. Its axle stays at the height of `wheel.radius_m`, so the robot leans
/// on a smaller wheel.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct WheelOverride {
    /// The paper's rho of this wheel, in metres.
    pub radius_m: Option<f64>,
    /// The paper's gamma of this wheel, with its sign, in degrees, in (-90, 90).
    pub gamma_deg: Option<f64>,
    /// Rotation of its rollers at wheel angle zero, in degrees; at 0 the first points straight
    /// down.
    pub phase_deg: Option<f64>,
    /// Number of its rollers in one row.
    pub per_row: Option<usize>,
    /// Largest radius of its rollers, at their middles, in metres.
    pub roller_radius_m: Option<f64>,
    /// Mass of one of its rollers, in kg.
    pub roller_mass_kg: Option<f64>,
    /// Material of its rollers: a name of a scenario's `[materials]`.
    pub roller_material: Option<String>,
    /// Mass of its hub without rollers, in kg.
    pub hub_mass_kg: Option<f64>,
}

/// Where the wheels sit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Arrangement {
    /// `[wheels.mecanum]`: pairs of wheels on axles in the usual X: from above, the axes of the
    /// upper rollers form an X.
    Mecanum {
        /// x of each axle in the body frame, front first, in metres.
        axles_m: Vec<f64>,
        /// From the middle of the robot to the middle of a wheel, in metres.
        half_width_m: f64,
        /// The paper's |gamma|, in degrees, in (0, 90).
        gamma_deg: f64,
    },
    /// `[wheels.ring]`: wheels at even angles around the body's origin, their hub axes pointing
    /// outward.
    Ring {
        /// Number of wheels.
        count: usize,
        /// The paper's |b|: from the body's origin to the middle of a wheel, in metres.
        distance_m: f64,
        /// Angle of the first wheel from the body's x axis, counter-clockwise, in degrees.
        #[serde(default)]
        first_deg: f64,
        /// The paper's gamma of every wheel, with its sign, in degrees, in (-90, 90).
        gamma_deg: f64,
    },
    /// `[[wheels.list]]`: wheels one by one.
    List(Vec<PlacedWheel>),
}

/// One wheel: its place, axis and handedness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacedWheel {
    /// The name of its joint.
    pub name: String,
    /// The paper's **b**: the wheel's middle in the body frame, x and y, in metres.
    #[serde(deserialize_with = "exactly")]
    pub position_m: [f64; 2],
    /// The hub axis **n** as an angle from the body's x axis, counter-clockwise, in degrees.
    /// Positive wheel rates turn about it.
    pub axis_deg: f64,
    /// The paper's gamma, with its sign: from the hub axis to the rolling direction of the roller
    /// on the ground, counter-clockwise seen from above, in degrees, in (-90, 90).
    pub gamma_deg: f64,
}

impl Spec {
    /// The JSON Schema of the file.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(Self).to_value()
    }
}

/// Reads an array of a fixed length. The TOML reader's own arrays would ignore surplus entries.
fn exactly<'de, D: Deserializer<'de>, const N: usize>(from: D) -> Result<[f64; N], D::Error> {
    let entries = Vec::<f64>::deserialize(from)?;
    let count = entries.len();
    let wanted = format!("{N} numbers");
    entries
        .try_into()
        .map_err(|_| D::Error::invalid_length(count, &wanted.as_str()))
}

/// Reads an array of pairs, like [`exactly`].
fn pairs<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec<[f64; 2]>>, D::Error> {
    #[derive(Deserialize)]
    struct Pair(#[serde(deserialize_with = "exactly")] [f64; 2]);
    let pairs = Vec::<Pair>::deserialize(from)?;
    Ok(Some(pairs.into_iter().map(|Pair(pair)| pair).collect()))
}

impl Arrangement {
    /// Returns the wheels one by one, in the order in which they are written.
    pub fn placed(&self) -> Vec<PlacedWheel> {
        match self {
            Self::List(wheels) => wheels.clone(),
            Self::Ring {
                count,
                distance_m,
                first_deg,
                gamma_deg,
            } => (0..*count)
                .map(|i| {
                    let axis_deg = first_deg + 360.0 * i as f64 / *count as f64;
                    let (s, c) = libm::sincos(axis_deg.to_radians());
                    PlacedWheel {
                        name: format!("wheel_{}", i + 1),
                        position_m: [distance_m * c, distance_m * s],
                        axis_deg,
                        gamma_deg: *gamma_deg,
                    }
                })
                .collect(),
            Self::Mecanum {
                axles_m,
                half_width_m,
                gamma_deg,
            } => {
                let middle_m = axles_m.iter().sum::<f64>() / axles_m.len().max(1) as f64;
                let pair = |(i, &x_m): (usize, &f64)| {
                    // The left wheel ahead of the middle has its rolling direction turned forward
                    // from the hub axis (gamma < 0), so that its roller axis on the ground points
                    // along (-1, 1) and it rotates the robot with the lever arm x + y; behind, and
                    // on the right, mirrored. An axle in the middle is handed like one ahead.
                    let left_deg = if x_m >= middle_m {
                        -gamma_deg
                    } else {
                        *gamma_deg
                    };
                    let axle = axle_name(i, axles_m.len());
                    [
                        (format!("{axle}_left"), *half_width_m, left_deg),
                        (format!("{axle}_right"), -half_width_m, -left_deg),
                    ]
                    .map(|(name, y_m, gamma_deg)| PlacedWheel {
                        name,
                        position_m: [x_m, y_m],
                        axis_deg: 90.0,
                        gamma_deg,
                    })
                };
                axles_m.iter().enumerate().flat_map(pair).collect()
            }
        }
    }
}

fn axle_name(i: usize, count: usize) -> String {
    match (i, count) {
        (0, 1..) => "front".to_owned(),
        (_, 2..) if i + 1 == count => "rear".to_owned(),
        (1, 3) => "middle".to_owned(),
        _ => format!("axle_{}", i + 1),
    }
}
