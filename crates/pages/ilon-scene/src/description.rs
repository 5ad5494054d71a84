//! What is drawn. All lengths are in metres, all angles in radians, in the frames of [`ilon_robot`]; the world's frame is that of the
//! floor, whose z axis is the floor's normal.
//!
//! A pose is `[x, y, z, qx, qy, qz, qw]`: a place and a unit quaternion. Numbers of shapes are f32: what is seen needs no more, and it
//! halves the text.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use ilon_robot::Mesh;
use ilon_trace::{Fault, Ground};
use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use crate::frames::Frames;

/// All that a page needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Scene {
    /// What there is.
    #[serde(flatten)]
    pub description: Description,
    /// What happens.
    pub frames: Frames,
}

impl Scene {
    /// A scene of its parts.
    pub fn new(description: Description, frames: Frames) -> Self {
        Self {
            description,
            frames,
        }
    }
}

/// What there is: the robot, the floor with what lies on it, and what comes from outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Description {
    /// The robot's shapes.
    pub robot: RobotShape,
    /// The ground with its patches, boxes and ramps. Of its relief [`Description::relief`] is what is drawn.
    pub ground: Ground,
    /// A rough surface in place of the plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relief: Option<Relief>,
    /// What goes wrong on purpose: pushes are drawn, and another friction everywhere.
    #[serde(default)]
    pub faults: Vec<Fault>,
    /// Free bodies, each in its own frame; where they are comes with the frames.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<Shape>,
    /// A path to be shown from the start, points in the world. The reference of a run comes with its frames.
    #[serde(default)]
    pub reference: Vec<[f32; 2]>,
    /// Other ways that the robot would go, each shown as its ghost where it is chosen.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ways: Vec<OtherWay>,
}

/// A way that the robot would go otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherWay {
    /// What it is called.
    pub name: String,
    /// Time in seconds, x and y in metres and heading in radians, in the order of time.
    pub poses: Vec<[f32; 4]>,
}

/// The robot's shapes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RobotShape {
    /// Its name.
    pub name: String,
    /// Its mass in kg: forces are drawn in proportion to the load of a wheel at rest.
    pub mass_kg: f32,
    /// How far it reaches from the body frame's origin in the plane.
    pub reach_m: f32,
    /// Height of the body frame's origin above the floor at rest.
    pub ride_height_m: f32,
    /// A point on top of its front, in the body frame, from which an arrow points ahead.
    pub nose: [f32; 3],
    /// The chassis, in the body frame.
    pub chassis: Vec<Shape>,
    /// The bodies on joints of their own, parents before their children.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<BodyShape>,
    /// The wheels, in the robot's order.
    pub wheels: Vec<WheelShape>,
    /// Outlines of rollers: points `[z, r]` along and across the axis, from one end to the other. Rollers share them.
    pub lathes: Vec<Vec<[f32; 2]>>,
    /// The meshes that shapes refer to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Mesh>,
    /// How many meshes of the file's `<visual>` elements are not drawn.
    pub meshes_left_out: usize,
    /// What of its looks is left out or simplified.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
}

/// A shape and where it sits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Its pose in the frame of the body that carries it.
    pub pose: [f32; 7],
    /// What it is.
    #[serde(flatten)]
    pub form: Geometry,
    /// Its colour, red, green, blue, opacity, from 0 to 1; without one it takes that of the page.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<[f32; 4]>,
}

/// What a shape is. All but meshes are centred on their own frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "size", rename_all = "snake_case")]
pub enum Geometry {
    /// Half of its sides.
    Box([f32; 3]),
    /// Along z: radius and length.
    Cylinder([f32; 2]),
    /// Its radius.
    Sphere([f32; 1]),
    /// Triangles.
    Mesh(PlacedMesh),
}

/// A mesh of the robot, in some size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedMesh {
    /// Which of [`RobotShape::meshes`].
    pub index: usize,
    /// How much its own coordinates are stretched.
    pub scale: [f32; 3],
}

/// A body on a joint: a rocker, an arm, a lift.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BodyShape {
    /// The name of its joint.
    pub name: String,
    /// Which body carries it, by its place among [`RobotShape::bodies`]; the chassis where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<usize>,
    /// Pose of the joint in the body frame while all joints stand at zero; it moves about its z axis, or along it.
    pub body_from_joint: [f32; 7],
    /// Whether it slides.
    pub slides: bool,
    /// The body, in the body frame while all joints stand at zero.
    pub shapes: Vec<Shape>,
}

/// A wheel: hub and rollers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct WheelShape {
    /// The name of its joint.
    pub name: String,
    /// Pose of the hub frame in the body frame at wheel angle zero, and while all joints stand at zero.
    pub body_from_hub: [f32; 7],
    /// Which body carries it, by its place among [`RobotShape::bodies`]; the chassis where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub carrier: Option<usize>,
    /// The wheel's radius.
    pub radius_m: f32,
    /// The angle gamma from the hub axis to the rolling direction of the lowest roller.
    pub gamma_rad: f32,
    /// The hub, in the hub frame.
    pub hub: Vec<Shape>,
    /// The rollers, in the wheel's order.
    pub rollers: Vec<RollerShape>,
}

/// A roller: a body of revolution about the z axis of its frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RollerShape {
    /// Pose of the roller frame in the hub frame.
    pub hub_from_roller: [f32; 7],
    /// Which of [`RobotShape::lathes`] is its outline.
    pub lathe: usize,
}

/// A rough surface: heights on a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Relief {
    /// Distance between neighbouring heights.
    pub cell_m: f32,
    /// How many heights there are along x.
    pub points: usize,
    /// The middle of the grid; the world's origin where it is not given.
    #[serde(default)]
    pub center_m: [f32; 2],
    /// Metres for each step of `data`.
    pub scale: f32,
    /// The heights, row by row from -y to +y, in each row from -x to +x: i16, little-endian, in base64.
    pub data: String,
}

impl Relief {
    /// A surface about a middle, of heights in metres, row by row from -y to +y, in each row from -x to +x; `None` unless they are a grid of at
    /// least 2 x 2 finite heights.
    pub fn new(cell_m: f64, center_m: [f64; 2], heights_m: &[Vec<f64>]) -> Option<Self> {
        let points = heights_m.first()?.len();
        let heights = || heights_m.iter().flatten().copied();
        let even = points >= 2 && heights_m.iter().all(|row| row.len() == points);
        let sized = cell_m > 0.0 && cell_m.is_finite() && center_m.iter().all(|x| x.is_finite());
        if !(heights_m.len() >= 2 && even && sized && heights().all(f64::is_finite)) {
            return None;
        }
        let highest_m = heights().map(f64::abs).fold(1e-9, f64::max);
        let scale = (highest_m / f64::from(i16::MAX)) as f32;
        let bytes: Vec<u8> = heights()
            .flat_map(|h| ((h / f64::from(scale)).round() as i16).to_le_bytes())
            .collect();
        Some(Self {
            cell_m: cell_m as f32,
            points,
            center_m: center_m.map(|x| x as f32),
            scale,
            data: BASE64_STANDARD.encode(bytes),
        })
    }
}

/// A pose as the page reads it.
pub(crate) fn pose(from: &Isometry3<f64>) -> [f32; 7] {
    let (t, q) = (from.translation.vector, from.rotation.coords);
    [t.x, t.y, t.z, q.x, q.y, q.z, q.w].map(|x| x as f32)
}
