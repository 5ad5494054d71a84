//! `[world]`: gravity, floor, and what lies on it.

use std::path::PathBuf;

use ilon_world::ContactSolver;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

use super::bodies::Body;
use super::materials::{Across, Against, Sliding};

/// The world that the robot stands in.
#[derive(Clone, Debug, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "WorldSection")]
pub struct World {
    /// The acceleration of gravity, downwards, in m/s^2.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[default = 9.81]
    pub gravity_m_s2: f64,
    /// The ground.
    pub floor: Floor,
    /// The solver; the defaults are measured.
    pub solver: Solver,
    /// Free bodies, which the robot can push.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<Body>,
}

/// The ground: an endless plane, unless it is rough, and what stands on it.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "FloorSection")]
pub struct Floor {
    /// Friction coefficient between rollers and floor; 0.6 unless given.
    #[schemars(range(min = 0.0))]
    pub friction: Option<f64>,
    /// Material: a name of `[materials]`. The pair with the rollers' material then gives friction,
    /// rolling resistance, creep, `sliding`, `across` and `against`.
    pub material: Option<String>,
    /// Slope of the floor, downwards along +x, in degrees. All positions count in the sloping
    /// plane, heights along its normal.
    #[schemars(range(min = -60.0, max = 60.0))]
    pub slope_deg: f64,
    /// Rectangles with other friction; later ones cover earlier ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub patches: Vec<FloorPatch>,
    /// Boxes that stand on the floor: kerbs, thresholds, walls.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub boxes: Vec<FloorBox>,
    /// Ramps that lead up from the floor.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ramps: Vec<FloorRamp>,
    /// Stairs that lead up from the floor.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stairs: Vec<FloorStairs>,
    /// A bumpy square around the origin, instead of the plane.
    pub rough: Option<Rough>,
    /// Ground from a picture or a mesh, instead of the plane.
    pub height_map: Option<HeightMap>,
    /// Rolling resistance: drag per load on level ground; 0.01 hard, 0.1 to 0.3 soft. Added to the
    /// rollers'.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: Option<f64>,
    /// Growth of rolling resistance on small radii: (wheel radius / the roller's radius of
    /// curvature)^this; 0 unless given.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub radius_exponent: Option<f64>,
    /// Creep: slip per rolled distance, for each share of its load that a roller pulls with. For
    /// carpets and mats.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub creep: Option<f64>,
    /// Friction that falls with sliding speed [default: it does not].
    pub sliding: Option<Sliding>,
    /// Direction of the floor's nap or weave, counter-clockwise from x, in degrees; 0 unless given.
    /// The floor's values hold along it.
    pub nap_deg: Option<f64>,
    /// Values across the nap [default: as along it].
    pub across: Option<Across>,
    /// Values against the nap [default: as with it].
    pub against: Option<Against>,
}

impl Floor {
    /// Friction where nothing is said.
    const FRICTION: f64 = 0.6;

    /// Coulomb's coefficient of friction of a floor that is of no material.
    pub fn friction(&self) -> f64 {
        self.friction.unwrap_or(Self::FRICTION)
    }

    /// Whether it is a plane, and nothing stands on it.
    pub fn is_plane(&self) -> bool {
        let Self {
            boxes,
            ramps,
            stairs,
            rough,
            height_map,
            ..
        } = self;
        let is_even = rough.is_none() && height_map.is_none();
        boxes.is_empty() && ramps.is_empty() && stairs.is_empty() && is_even
    }

    /// Whether the floor or a patch is of a material.
    pub fn is_of_material(&self) -> bool {
        let mut patches = self.patches.iter().map(|patch| &patch.material);
        self.material.is_some() || patches.any(Option::is_some)
    }

    /// Spells out what it grips like where it is of no material.
    pub fn fill(&mut self) {
        if self.material.is_none() {
            self.friction.get_or_insert(Self::FRICTION);
        }
    }
}

fn is_zero(number: &Option<f64>) -> bool {
    number.is_none_or(|number| number == 0.0)
}

/// A rectangle of other floor.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FloorPatch {
    /// x of its middle, in metres.
    pub x_m: f64,
    /// y of its middle, in metres.
    pub y_m: f64,
    /// Its length along x, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length_x_m: f64,
    /// Its length along y, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length_y_m: f64,
    /// Friction coefficient; required without `material`.
    #[schemars(range(min = 0.0))]
    pub friction: Option<f64>,
    /// Material: a name of `[materials]`, instead of the values here.
    pub material: Option<String>,
    /// Rolling resistance [default: the floor's].
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: Option<f64>,
    /// Growth of rolling resistance on small radii [default: the floor's].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub radius_exponent: Option<f64>,
    /// Creep [default: the floor's].
    #[schemars(range(min = 0.0, max = 100.0))]
    pub creep: Option<f64>,
    /// Friction that falls with sliding speed [default: the floor's].
    pub sliding: Option<Sliding>,
    /// Direction of its nap, in degrees [default: the floor's].
    pub nap_deg: Option<f64>,
    /// Values across its nap [default: the floor's].
    pub across: Option<Across>,
    /// Values against its nap [default: the floor's].
    pub against: Option<Against>,
    /// When it appears, in seconds.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// When it disappears, in seconds; without it, never.
    #[schemars(range(min = 0.0))]
    pub until_s: Option<f64>,
}

/// A box that stands on the floor.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FloorBox {
    /// x of its middle, in metres.
    pub x_m: f64,
    /// y of its middle, in metres.
    pub y_m: f64,
    /// Its heading in the world, in degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Its length along its own x axis, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length_x_m: f64,
    /// Its length along its own y axis, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length_y_m: f64,
    /// Its height above the floor, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub height_m: f64,
}

/// A ramp. It rises evenly from its foot and ends in a vertical drop; its sides are vertical.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FloorRamp {
    /// x of the middle of its foot, in metres.
    pub x_m: f64,
    /// y of the middle of its foot, in metres.
    pub y_m: f64,
    /// The heading in which it leads up, in degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Its length along the floor, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length_m: f64,
    /// Its width, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub width_m: f64,
    /// Height of its end, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rise_m: f64,
}

/// Stairs: steps of one height and one depth.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FloorStairs {
    /// x of the middle of the first step's edge, in metres.
    pub x_m: f64,
    /// y of the middle of the first step's edge, in metres.
    pub y_m: f64,
    /// The heading in which they lead up, in degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// How many steps there are.
    #[schemars(range(min = 1, max = 100))]
    pub steps: u32,
    /// The height of a step, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rise_m: f64,
    /// The depth of a step, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub run_m: f64,
    /// Their width, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub width_m: f64,
}

/// Classes of road roughness: ISO 8608, table C.1. Each is four times the class before it in
/// spectral density, twice in height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum RoughnessClass {
    /// Very good: 16e-6 m^3 at 0.1 cycles/m.
    A,
    /// Good: 64e-6 m^3.
    B,
    /// Average: 256e-6 m^3.
    C,
    /// Poor: 1024e-6 m^3.
    D,
    /// Very poor: 4096e-6 m^3.
    E,
    /// 16384e-6 m^3.
    F,
    /// 65536e-6 m^3.
    G,
    /// 262144e-6 m^3.
    H,
}

impl RoughnessClass {
    /// Gd(n0): the geometric mean of the displacement's spectral density at 0.1 cycles/m, in m^3.
    pub fn density_m3(self) -> f64 {
        16e-6 * f64::from(4_u32.pow(self as u32))
    }
}

/// Uneven ground on a square grid: random heights, or a class of ISO 8608.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rough {
    /// Largest height, in metres; heights are even between 0 and this. Or `iso_8608`.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub height_m: Option<f64>,
    /// Class of roughness by ISO 8608, isotropic, for waves from two cells to the side; mean height
    /// 0.
    pub iso_8608: Option<RoughnessClass>,
    /// Distance between neighbouring points, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub cell_m: f64,
    /// Side of the square, in metres; at most 500 cells. Beyond it there is no ground.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub side_m: f64,
    /// Seed: the same seed gives the same ground.
    #[serde(default)]
    pub seed: u64,
}

/// Ground with the heights of a file, on a grid of at most 1025 x 1025 points, flat in triangles
/// between them. Beyond it there is no ground.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeightMap {
    /// The file, relative to the scenario: a grey `.png` of 8 or 16 bits, one point a pixel, black
    /// lowest, upper edge at +y; or a mesh (`.stl`, `.obj`, `.dae`) in metres with z up, of which
    /// the highest place at each point counts.
    pub file: PathBuf,
    /// Distance between neighbouring points, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub cell_m: f64,
    /// Height of white above black, in metres; of a picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub height_m: Option<f64>,
    /// Height of black; of a mesh an offset of its heights, in metres.
    #[serde(default)]
    pub base_m: f64,
    /// x of the picture's middle, or an offset of the mesh, in metres.
    #[serde(default)]
    pub x_m: f64,
    /// y of the picture's middle, or an offset of the mesh, in metres.
    #[serde(default)]
    pub y_m: f64,
}

/// Settings of the solver, for checks of the solver.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "SolverSection")]
pub struct Solver {
    /// The contact solver: ilon, or rapier alone, to compare.
    pub contacts: ContactSolver,
    /// Length of the parts into which steps are split while a roller slides, or is about to, in
    /// seconds [default: with an automatic step 0.0014 sqrt(wheel radius / gravity), 0.0001 for
    /// wheels of 50 mm; with a given step none].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub split_dt_s: Option<f64>,
    /// Stiffness of each contact with the ground, in N/m [default: hard rollers on hard ground,
    /// which sink by 5.5e-6 of the wheel's radius: 1e8 for a robot of 11 kg with wheels of 50 mm].
    #[schemars(range(max = 1e15), extend("exclusiveMinimum" = 0.0))]
    pub contact_stiffness_n_m: Option<f64>,
    /// Relaxation time of a contact's spring, in seconds [default: 0.014 sqrt(wheel radius /
    /// gravity), 0.001 for wheels of 50 mm]. Shorter: robots may bounce.
    #[schemars(range(min = 0.0))]
    pub contact_relaxation_s: Option<f64>,
}
