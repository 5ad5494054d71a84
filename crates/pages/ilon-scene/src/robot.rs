//! The robot's shapes, from its model and from the visuals of its file.

use ilon_robot::{
    Collision, JointKind, LinkTree, Mesh, Robot, Roller, RollerForm, VisualMeshes, Wheel,
};
use ilon_trace::Ground;
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use crate::description::{
    BodyShape, Description, Geometry, PlacedMesh, RobotShape, RollerShape, Shape, WheelShape, pose,
};
use crate::outline;
use crate::visuals::{self, Visuals};

impl Description {
    /// A robot on a level floor. The chassis is drawn from the visuals of the file's links
    /// (`Loaded::links` of ilon-formats), if they are given and contain boxes, cylinders, spheres
    /// or meshes that `looks` has (`Loaded::visual_meshes`). Otherwise it is drawn by its collision
    /// shapes, and without any by a plate between its wheels.
    pub fn of_robot(robot: &Robot, links: Option<&LinkTree>, looks: &VisualMeshes) -> Self {
        let visuals = links.map(|links| visuals::of_links(links, robot, looks));
        Self {
            robot: robot_shape(robot, &visuals.unwrap_or_default(), looks),
            ground: Ground {
                friction: 0.6,
                ..Ground::default()
            },
            relief: None,
            faults: Vec::new(),
            bodies: Vec::new(),
            reference: Vec::new(),
            ways: Vec::new(),
        }
    }
}

fn robot_shape(robot: &Robot, visuals: &Visuals, looks: &VisualMeshes) -> RobotShape {
    let mut drawn = SharedShapes {
        looks,
        remarks: looks.remarks.clone(),
        left_out: visuals.meshes,
        lathes: Vec::new(),
    };
    let mut chassis = chassis_shapes(robot, visuals, &mut drawn);
    let wheels = robot.wheels.iter().enumerate().map(|(index, wheel)| {
        let shown = visuals.hubs.get(index).cloned().unwrap_or_default();
        wheel_shape(wheel, shown, &mut drawn)
    });
    let mut wheels: Vec<WheelShape> = wheels.collect();
    let mut bodies = bodies(robot, visuals);
    let hubs = wheels.iter_mut().flat_map(|wheel| &mut wheel.hub);
    let of_bodies = bodies.iter_mut().flat_map(|body| &mut body.shapes);
    let meshes = meshes(chassis.iter_mut().chain(hubs).chain(of_bodies), looks);
    // From here on shapes refer to the meshes of the scene.
    let looks = &looks.with_meshes(meshes);
    let corners: Vec<Vector3<f64>> = chassis.iter().flat_map(|s| corners(s, looks)).collect();
    let reach_m = corners
        .iter()
        .map(|c| c.xy().norm())
        .fold(span_of_wheels_m(robot), f64::max);
    let furthest = |axis: usize| corners.iter().map(|c| c[axis]).fold(f64::MIN, f64::max);
    RobotShape {
        name: robot.name.clone(),
        weight_n: (9.81 * robot.mass_kg()) as f32,
        reach_m: reach_m as f32,
        ride_height_m: robot.ride_height_m() as f32,
        nose: [
            0.5 * furthest(0) as f32,
            0.0,
            (furthest(2) + 0.02 * reach_m) as f32,
        ],
        chassis,
        bodies,
        wheels,
        lathes: drawn.lathes,
        meshes: looks.meshes.clone(),
        meshes_left_out: drawn.left_out,
        remarks: drawn.remarks,
    }
}

/// The largest distance of a wheel from the robot's centre, in metres.
fn span_of_wheels_m(robot: &Robot) -> f64 {
    let reach_m = |wheel: &Wheel| wheel.position_m().xy().norm() + wheel.radius_m;
    robot.wheels.iter().map(reach_m).fold(0.0, f64::max)
}

/// Data shared by a robot's shapes, and what was left out.
struct SharedShapes<'a> {
    looks: &'a VisualMeshes,
    remarks: Vec<String>,
    left_out: usize,
    /// The distinct outlines.
    lathes: Vec<Vec<[f32; 2]>>,
}

impl SharedShapes<'_> {
    /// Whether a shape is kept: all except a mesh with a reason `why` not to draw it.
    fn keeps(&mut self, shape: &Shape, why: Option<String>) -> bool {
        let Some((Geometry::Mesh(placed), why)) = Some(shape.form).zip(why) else {
            return true;
        };
        let name = self.looks.meshes.get(placed.index).map(|mesh| &mesh.name);
        let remark = format!("The mesh `{}` is not drawn: {why}", name.map_or("", |n| n));
        if !self.remarks.contains(&remark) {
            self.remarks.push(remark);
        }
        self.left_out += 1;
        false
    }

    /// The index of an outline among all.
    fn lathe(&mut self, outline: Vec<[f32; 2]>) -> usize {
        let known = self.lathes.iter().position(|lathe| *lathe == outline);
        known.unwrap_or_else(|| {
            self.lathes.push(outline);
            self.lathes.len() - 1
        })
    }
}

/// The chassis from its file's visuals, otherwise from its collision shapes, otherwise a plate.
fn chassis_shapes(robot: &Robot, visuals: &Visuals, drawn: &mut SharedShapes<'_>) -> Vec<Shape> {
    let span_m = span_of_wheels_m(robot);
    let mut shown = visuals.chassis.clone();
    shown.retain(|shape| {
        let corners = corners(shape, drawn.looks);
        let size_m = corners.iter().map(|c| c.norm()).fold(0.0, f64::max);
        let why = format!("it reaches {size_m:.0} m from a robot of {span_m:.2} m");
        drawn.keeps(shape, (size_m > MOST_SPANS * span_m).then_some(why))
    });
    if shown.is_empty() {
        let collisions = robot.chassis.collisions.iter();
        shown = collisions.flat_map(shapes_of_collision).collect();
    }
    if shown.is_empty() {
        shown.push(plate(robot));
    }
    shown
}

/// A wheel with the exact outlines of its rollers, and its hub from its file's visuals.
fn wheel_shape(wheel: &Wheel, mut shown: Vec<Shape>, drawn: &mut SharedShapes<'_>) -> WheelShape {
    let rollers = wheel.rollers.iter().map(|roller| {
        let outline = match &roller.form {
            RollerForm::Barrel | RollerForm::Made(_) => outline::of_barrel(&wheel.barrel(roller)),
            RollerForm::Turned(turned) | RollerForm::Tyre(turned) => outline::of_turned(turned),
            RollerForm::AsModelled(modelled) => outline::of_profile(&modelled.profile),
        };
        RollerShape {
            hub_from_roller: pose(&roller.hub_from_roller()),
            lathe: drawn.lathe(outline),
        }
    });
    let rollers = rollers.collect();
    shown.retain(|shape| {
        let why = shows_rollers(wheel, shape, drawn.looks).then(|| {
            "it shows the rollers too, which are drawn by their exact outlines".to_owned()
        });
        drawn.keeps(shape, why)
    });
    WheelShape {
        name: wheel.name.clone(),
        body_from_hub: pose(&wheel.body_from_hub),
        carrier: wheel.carrier,
        radius_m: wheel.radius_m as f32,
        gamma_rad: wheel.gamma_rad as f32,
        rollers,
        hub: hub(wheel, &shown, drawn.looks),
    }
}

/// The bodies on joints from their file's visuals, otherwise from their collision shapes.
fn bodies(robot: &Robot, visuals: &Visuals) -> Vec<BodyShape> {
    let body = |(index, joint): (usize, &ilon_robot::BodyJoint)| {
        let mut shapes = visuals.bodies.get(index).cloned().unwrap_or_default();
        if shapes.is_empty() {
            let collisions = joint.body.collisions.iter();
            shapes = collisions.flat_map(shapes_of_collision).collect();
        }
        BodyShape {
            name: joint.name.clone(),
            parent: joint.parent,
            body_from_joint: pose(&joint.body_from_joint),
            slides: joint.kind == JointKind::Slides,
            shapes,
        }
    };
    robot.joints.iter().enumerate().map(body).collect()
}

/// A mesh that extends beyond this many times the wheels' distance is not in metres; chosen.
const MOST_SPANS: f64 = 20.0;

/// The meshes that the shapes use; the shapes are changed to refer to this list.
fn meshes<'a>(shapes: impl Iterator<Item = &'a mut Shape>, looks: &VisualMeshes) -> Vec<Mesh> {
    let mut used: Vec<usize> = Vec::new();
    for shape in shapes {
        if let Geometry::Mesh(placed) = &mut shape.form {
            let known = used.iter().position(|index| *index == placed.index);
            let place = known.unwrap_or_else(|| {
                used.push(placed.index);
                used.len() - 1
            });
            placed.index = place;
        }
    }
    let of_looks = used.iter().filter_map(|index| looks.meshes.get(*index));
    of_looks.cloned().collect()
}

/// Whether a mesh on a hub extends to where the rollers touch the ground: it then shows the whole
/// wheel.
fn shows_rollers(wheel: &Wheel, shape: &Shape, looks: &VisualMeshes) -> bool {
    let Geometry::Mesh(PlacedMesh { index, scale }) = shape.form else {
        return false;
    };
    let placed = isometry(&shape.pose);
    let vertices = looks.meshes.get(index).map(Mesh::vertices);
    vertices.unwrap_or_default().into_iter().any(|vertex| {
        let scaled = [0, 1, 2].map(|k| f64::from(vertex[k] * scale[k]));
        let in_hub = placed * Point3::from(scaled);
        in_hub.coords.xy().norm() > 0.95 * wheel.radius_m
    })
}

/// The hub from its file's visuals. A drum inside the rollers if there are none, or if they are as
/// large as the wheel.
fn hub(wheel: &Wheel, shown: &[Shape], looks: &VisualMeshes) -> Vec<Shape> {
    let inside_m = |roller: &Roller| roller.ring_radius_m() - 0.8 * roller.radius_m;
    let room_m = wheel
        .rollers
        .iter()
        .map(inside_m)
        .fold(f64::INFINITY, f64::min);
    let room_m = room_m.clamp(0.1 * wheel.radius_m, wheel.radius_m);
    let fits = |shape: &Shape| {
        // A mesh was checked by its own vertices.
        matches!(shape.form, Geometry::Mesh(_))
            || corners(shape, looks)
                .iter()
                .all(|c| c.xy().norm() < 1.5 * room_m.max(0.8 * wheel.radius_m))
    };
    if !shown.is_empty() && shown.iter().all(fits) {
        return shown.to_vec();
    }
    let half_width_m = wheel
        .rollers
        .iter()
        .map(|r| r.row_offset_m().abs() + 0.35 * r.length_m * r.axis_in_hub.z.abs())
        .fold(0.3 * room_m, f64::max);
    vec![Shape {
        pose: pose(&Isometry3::identity()),
        form: Geometry::Cylinder([room_m as f32, 2.0 * half_width_m as f32]),
        color: None,
    }]
}

/// A collision shape as drawn shapes.
fn shapes_of_collision(collision: &Collision) -> Vec<Shape> {
    visuals::of_solid(&collision.shape, &collision.body_from_shape, None)
}

/// A plate between the wheels, for a robot without visuals and collision shapes.
fn plate(robot: &Robot) -> Shape {
    let places = || robot.wheels.iter().map(Wheel::position_m);
    let first = places().next().unwrap_or_default();
    let (low, high) = places().fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
    let thick_m = robot.wheels.iter().map(|w| w.radius_m).fold(0.0, f64::max) * 0.3;
    let half = (high - low) * 0.5;
    let middle = 0.5 * (low + high) + Vector3::z() * thick_m;
    Shape {
        pose: pose(&Translation3::from(middle).into()),
        form: Geometry::Box([
            half.x.max(thick_m) as f32,
            (0.8 * half.y).max(thick_m) as f32,
            0.5 * thick_m as f32,
        ]),
        color: None,
    }
}

/// The corners of the box around a shape along its own axes, in the frame of its body.
fn corners(shape: &Shape, looks: &VisualMeshes) -> Vec<Vector3<f64>> {
    let [low, high] = match shape.form {
        Geometry::Box(half) => around(half),
        Geometry::Cylinder([r, l]) => around([r, r, 0.5 * l]),
        Geometry::Sphere([r]) => around([r, r, r]),
        Geometry::Mesh(PlacedMesh { index, scale }) => {
            let bounds = looks
                .meshes
                .get(index)
                .map(Mesh::bounds)
                .unwrap_or_default();
            bounds.map(|corner| [0, 1, 2].map(|k| corner[k] * scale[k]))
        }
    };
    let placed = isometry(&shape.pose);
    (0..8)
        .map(|corner| {
            let end = |bit: usize| f64::from(if corner >> bit & 1 == 1 { high } else { low }[bit]);
            (placed * Point3::new(end(0), end(1), end(2))).coords
        })
        .collect()
}

/// A pose in the page's format, as a transform.
fn isometry(pose: &[f32; 7]) -> Isometry3<f64> {
    let [x, y, z, i, j, k, w] = pose.map(f64::from);
    let rotation = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, i, j, k));
    Isometry3::from_parts(Translation3::new(x, y, z), rotation)
}

/// The lowest and the highest corner of a box around the origin.
fn around(half: [f32; 3]) -> [[f32; 3]; 2] {
    [half.map(|x| -x), half]
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;

    use super::*;

    /// The plate lies on the hubs, and does not reach up to the top of the wheels of 50 mm.
    #[test]
    fn a_plate_is_thinner_than_wheels_are_high() {
        let robot = Robot::load("../../../assets/robots/mecanum4.urdf").expect("a shipped robot");
        let hub_m = robot.wheels[0].position_m().z;
        let corners = corners(&plate(&robot), &VisualMeshes::default());
        let (low_m, high_m) = corners
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                (low.min(p.z), high.max(p.z))
            });
        assert!(hub_m < low_m && high_m < hub_m + 0.05, "{low_m} {high_m}");
    }
}
