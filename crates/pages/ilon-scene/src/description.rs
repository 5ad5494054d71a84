//! The static part of a scene. All lengths are in metres, all angles in radians, in the frames of
//! [`ilon_robot`]. The world frame is that of the floor; its z axis is the floor's normal.
//!
//! A pose is `[x, y, z, qx, qy, qz, qw]`: a position and a unit quaternion. Numbers of shapes are
//! f32: drawing needs no more, and the text is half as long.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use ilon_robot::Mesh;
use ilon_trace::{Fault, Ground};
use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use crate::frames::Frames;

/// All data of a page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Scene {
    /// The static part.
    #[serde(flatten)]
    pub description: Description,
    /// The motion.
    pub frames: Frames,
}

impl Scene {
    /// A scene of both parts.
    pub fn new(description: Description, frames: Frames) -> Self {
        Self {
            description,
            frames,
        }
    }
}

/// The robot, the floor with everything on it, and external influences.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Description {
    /// The robot's shapes.
    pub robot: RobotShape,
    /// The ground with its patches, boxes and ramps. Its relief is drawn from
    /// [`Description::relief`].
    pub ground: Ground,
    /// A rough surface in place of the plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relief: Option<Relief>,
    /// Faults: pushes are drawn, and changes of the overall friction.
    #[serde(default)]
    pub faults: Vec<Fault>,
    /// Free bodies, each in its own frame; their poses are in the frames of the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<Shape>,
    /// A path shown from the start, as points in the world. The reference of a run is in its
    /// frames.
    #[serde(default)]
    pub reference: Vec<[f32; 2]>,
    /// Alternative motions of the robot, each shown as a ghost when selected.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ways: Vec<OtherWay>,
}

/// An alternative motion of the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherWay {
    /// Its name.
    pub name: String,
    /// Time in seconds, x and y in metres and heading in radians, in order of time.
    pub poses: Vec<[f32; 4]>,
}

/// The robot's shapes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RobotShape {
    /// Its name.
    pub name: String,
    /// Its weight in N, at 9.81 m/s^2 unless set: forces are drawn in proportion to the load of a
    /// wheel at rest.
    pub weight_n: f32,
    /// Its largest extent from the body frame's origin in the plane.
    pub reach_m: f32,
    /// Height of the body frame's origin above the floor at rest.
    pub ride_height_m: f32,
    /// A point on top of its front, in the body frame, from which an arrow points ahead.
    pub nose: [f32; 3],
    /// The chassis, in the body frame.
    pub chassis: Vec<Shape>,
    /// The bodies on joints, parents before their children.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<BodyShape>,
    /// The wheels, in the robot's order.
    pub wheels: Vec<WheelShape>,
    /// Outlines of rollers, shared between them: points `[z, r]` along and across the axis, from
    /// one end to the other.
    pub lathes: Vec<Vec<[f32; 2]>>,
    /// The meshes that shapes refer to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Mesh>,
    /// Number of meshes in the file's `<visual>` elements that are not drawn.
    pub meshes_left_out: usize,
    /// What of the file's visuals is left out or simplified.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
}

/// A shape with its pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Its pose in the frame of its body.
    pub pose: [f32; 7],
    /// Its geometry.
    #[serde(flatten)]
    pub form: Geometry,
    /// Its colour: red, green, blue, opacity, from 0 to 1; the page's default if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<[f32; 4]>,
}

/// A geometry. All except meshes are centred on their own frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "size", rename_all = "snake_case")]
pub enum Geometry {
    /// Half side lengths.
    Box([f32; 3]),
    /// Along z: radius and length.
    Cylinder([f32; 2]),
    /// Radius.
    Sphere([f32; 1]),
    /// Triangles.
    Mesh(PlacedMesh),
}

/// A mesh of the robot with a scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedMesh {
    /// Index in [`RobotShape::meshes`].
    pub index: usize,
    /// Scale of its coordinates along each axis.
    pub scale: [f32; 3],
}

/// A body on a joint: a rocker, an arm, a lift.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BodyShape {
    /// The name of its joint.
    pub name: String,
    /// Index of its parent in [`RobotShape::bodies`]; `None` for the chassis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<usize>,
    /// Pose of the joint in the body frame with all joints at zero; it turns about its z axis, or
    /// slides along it.
    pub body_from_joint: [f32; 7],
    /// Whether the joint is prismatic.
    pub slides: bool,
    /// The body's shapes, in the body frame with all joints at zero.
    pub shapes: Vec<Shape>,
}

/// A wheel: hub and rollers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct WheelShape {
    /// The name of its joint.
    pub name: String,
    /// Pose of the hub frame in the body frame at wheel angle zero, with all joints at zero.
    pub body_from_hub: [f32; 7],
    /// Index of the body that carries it in [`RobotShape::bodies`]; `None` for the chassis.
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
    /// Index of its outline in [`RobotShape::lathes`].
    pub lathe: usize,
}

/// A rough surface: heights on a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Relief {
    /// Distance between neighbouring points.
    pub cell_m: f32,
    /// Number of points along x.
    pub points: usize,
    /// The middle of the grid; `None` for the world's origin.
    #[serde(default)]
    pub center_m: [f32; 2],
    /// Metres per unit of `data`.
    pub scale: f32,
    /// The heights, row by row from -y to +y, in each row from -x to +x: i16, little-endian, in
    /// base64.
    pub data: String,
}

impl Relief {
    /// A surface about a centre, from heights in metres, row by row from -y to +y, in each row from
    /// -x to +x. `None` unless they are a grid of at least 2 x 2 finite heights.
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

/// A pose in the page's format.
pub(crate) fn pose(from: &Isometry3<f64>) -> [f32; 7] {
    let (t, q) = (from.translation.vector, from.rotation.coords);
    [t.x, t.y, t.z, q.x, q.y, q.z, q.w].map(|x| x as f32)
}
