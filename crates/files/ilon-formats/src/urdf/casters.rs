//! Casters: wheels that swivel freely, and the balls and skids of the chassis on which robots on
//! tyres stand.
//!
//! Files model a ball caster as a sphere, or a box, that is part of the chassis and just reaches
//! the floor. A robot that its wheels alone do not carry stands on it. As a ball caster rolls in
//! every direction, its place has no friction on the ground.

use nalgebra::{Translation3, Unit, Vector3};
use urdf_rs::Geometry;

use super::body::RigidBody;
use super::disc;
use super::hub::hub_frame;
use super::mesh::Meshes;
use super::names;
use super::tree::{Motion, PlacedShape, Tree};
use crate::model::{Collision, CollisionShape, Remark, Robot, StandingPose, Wheel};

/// By how much a caster may reach below the wheels' floor in a file and still be taken to reach
/// just down to it, in metres: files hold rounded numbers, and simulators with soft contacts press
/// it in. Chosen. A caster that reaches deeper tilts the robot.
const ROUNDED_M: f64 = 2e-3;
/// A smaller depth is none.
const EXACT_M: f64 = 1e-9;

/// A shape of the chassis within this distance of the floor stands on it, in wheel radii (chosen).
pub(super) const TOUCHES: f64 = 1e-3;
/// A smaller lean is not remarked, in degrees.
pub(super) const REMARKED_TILT_DEG: f64 = 0.05;

/// Whether a joint swivels a caster or turns its wheel: by its name, or by the caster's trail, or
/// because it turns a ball.
pub(super) fn is_caster(tree: &Tree, joint: usize) -> bool {
    names::is_called_caster(tree, joint) || trails(tree, joint) || is_ball(tree, joint)
}

/// Whether a joint swivels a caster that trails it, or turns such a caster's wheel. A ball trails
/// nothing: it rolls in every direction.
pub(super) fn swivels_freely(tree: &Tree, joint: usize) -> bool {
    let below = tree.turning_below(joint).unwrap_or(joint);
    is_caster(tree, joint) && swivel_of(tree, joint).is_some() && !is_ball(tree, below)
}

/// Whether a joint swivels, or turns, a wheel that its file shows as a disc about its axle, which
/// reaches below the driven wheels' axles, at `axles_m`: no part of an arm is one.
pub(super) fn carries_disc(tree: &Tree, joint: usize, axles_m: f64) -> bool {
    /// Cosine of the largest angle between a disc's axis and its axle.
    const ALONG: f64 = 0.99;
    let wheel = tree.turning_below(joint).unwrap_or(joint);
    let of = &tree.joints[wheel];
    let is_disc = |shape: &PlacedShape| {
        let Geometry::Cylinder { radius, length } = shape.geometry else {
            return false;
        };
        let along = shape.body_from_shape * Vector3::z();
        let off_m = shape.body_from_shape.translation.vector - of.origin.coords;
        let is_about_axle = along.dot(&of.axis).abs() > ALONG && off_m.norm() < radius;
        length <= 2.0 * radius && is_about_axle && of.origin.z - radius < axles_m
    };
    let link = &tree.links[of.child];
    let mut shapes = link.shapes.iter().chain(&link.visuals).peekable();
    shapes.peek().is_some() && shapes.all(is_disc)
}

/// Whether a joint turns a ball.
pub(super) fn is_ball(tree: &Tree, joint: usize) -> bool {
    let link = &tree.links[tree.joints[joint].child];
    let is_round = |shape: &PlacedShape| matches!(shape.geometry, Geometry::Sphere { .. });
    let mut shapes = link.shapes.iter().chain(&link.visuals).peekable();
    shapes.peek().is_some() && shapes.all(is_round)
}

/// Returns the joint itself, or the nearest one above it, that turns about an upright axis.
fn swivel_of(tree: &Tree, joint: usize) -> Option<usize> {
    /// Cosine of the largest lean of an upright axis.
    const UPRIGHT: f64 = 0.99;
    let is_swivel = |joint: &usize| {
        let of = &tree.joints[*joint];
        let turns = matches!(of.motion, Motion::Turning | Motion::Swinging);
        turns && of.axis.z.abs() > UPRIGHT
    };
    let mut all = std::iter::once(joint).chain(tree.joints_above(joint));
    all.find(is_swivel)
}

/// Whether a joint is the upright one, or the level one below it, of a wheel that trails it, and
/// nothing drives either: both turn endlessly, without an effort.
fn trails(tree: &Tree, joint: usize) -> bool {
    /// A trail shorter than this share of the wheel's size, or of its depth below the swivel, is
    /// none; nor is one shorter than the wheel is beside the axis of its swivel. Both chosen.
    const LEAST: f64 = 0.05;
    let turns = |joint: &usize| {
        let of = &tree.joints[*joint];
        of.motion == Motion::Turning && of.effort == 0.0 && !of.mimics
    };
    let pair = swivel_of(tree, joint).and_then(|swivel| match swivel == joint {
        true => Some((joint, tree.turning_below(joint)?)),
        false => Some((swivel, joint)),
    });
    pair.is_some_and(|(swivel, wheel)| {
        let [of_swivel, of_wheel] = [swivel, wheel].map(|at| &tree.joints[at]);
        let (beside_m, axle) = (of_wheel.origin - of_swivel.origin, of_wheel.axis);
        let trail_m = beside_m.xy().perp(&axle.xy()).abs();
        let reach_m = tree
            .lone_body(of_wheel.child)
            .reach_m(&of_wheel.origin.coords);
        let size_m = reach_m.max(beside_m.z.abs());
        let is_behind = trail_m > beside_m.xy().dot(&axle.xy()).abs().max(LEAST * size_m);
        turns(&swivel) && turns(&wheel) && tree.is_level(wheel) && is_behind
    })
}

/// Gives the wheel of a caster that swivels, if meshes alone show it, a cylinder of their size: the
/// hull of a mesh would roll on its corners.
pub(super) fn of_meshed_wheel(tree: &Tree, joint: usize, body: &mut RigidBody, meshes: &Meshes) {
    let is_mesh = |of: &PlacedShape| matches!(of.geometry, Geometry::Mesh { .. });
    let is_meshed = !body.shapes.is_empty() && body.shapes.iter().all(is_mesh);
    if !(is_meshed && tree.is_level(joint) && swivels_freely(tree, joint)) {
        return;
    }
    let of = &tree.joints[joint];
    let frame = hub_frame(&of.origin, &of.axis);
    if let Ok(disc) = disc::about(body, &frame, meshes)
        && let Some(length) = disc::width_m(body, &frame, meshes)
    {
        body.shapes = vec![PlacedShape {
            body_from_shape: frame * Translation3::new(0.0, 0.0, disc.middle_m),
            geometry: Geometry::Cylinder {
                radius: disc.radius_m,
                length,
            },
        }];
    }
}

/// Makes the wheel of a caster that swivels smaller where rounding puts it below the floor of the
/// robot's wheels: a rigid robot would stand on its casters instead. Returns a remark if it does.
pub(super) fn of_rounded_wheel(
    tree: &Tree,
    joint: usize,
    body: &mut RigidBody,
    wheels: &[Wheel],
) -> Option<Remark> {
    if !(tree.is_level(joint) && swivels_freely(tree, joint)) {
        return None;
    }
    let floor_m = floor_m(wheels);
    let mut most_m = 0.0_f64;
    for shape in &mut body.shapes {
        let height_m = shape.body_from_shape.translation.z - floor_m;
        if let Geometry::Cylinder { radius, .. } = &mut shape.geometry
            && (EXACT_M..=ROUNDED_M).contains(&(*radius - height_m))
        {
            most_m = most_m.max(*radius - height_m);
            *radius = height_m;
        }
    }
    (most_m > 0.0).then(|| {
        let words = format!(
            "in the file this caster's wheel reaches {:.2} mm below the wheels' floor: its radius is taken as so much smaller",
            1e3 * most_m
        );
        Remark::new(format!("joint `{}`", tree.joints[joint].name), words)
    })
}

/// The height of the floor of wheels in the body frame, in metres.
fn floor_m(wheels: &[Wheel]) -> f64 {
    let bottoms = wheels.iter().map(|of| of.position_m().z - of.radius_m);
    bottoms.fold(f64::INFINITY, f64::min)
}

/// Gives the balls that a file only shows, and that reach just down to the floor of its wheels,
/// collision geometry: a pair of wheels stands on them. Returns a remark if there are any.
pub(super) fn of_shown_balls(body: &mut RigidBody, wheels: &[Wheel]) -> Option<Remark> {
    let floor_m = floor_m(wheels);
    let touches = |of: &&PlacedShape| {
        let height_m = of.body_from_shape.translation.z - floor_m;
        matches!(of.geometry, Geometry::Sphere { radius } if (height_m - radius).abs() < ROUNDED_M)
    };
    if body.shapes.iter().any(|of| touches(&of)) {
        return None;
    }
    let before = body.shapes.len();
    body.shapes
        .extend(body.visuals.iter().filter(touches).cloned());
    let text = "those without collision geometry carry it as they are shown";
    (body.shapes.len() > before).then(|| Remark::new("balls", text))
}

/// Lets a robot on tyres that its wheels alone do not carry stand on the parts of its chassis that
/// reach the floor. Returns whether it does.
pub(super) fn stand_on(robot: &mut Robot, remarks: &mut Vec<Remark>) -> bool {
    if !robot.has_tyres() || stands_on_wheels(robot) {
        return false;
    }
    let raised_m = raise_rounded(robot);
    let near_m = TOUCHES * least_radius_m(robot);
    let floor = Floor::of(robot);
    let mut places = Vec::new();
    for shape in carriers(robot) {
        if floor.height_m(shape) < near_m {
            shape.friction = Some(0.0);
            let at = shape.farthest(&-floor.up.into_inner());
            places.push(format!("x = {:.3} m, y = {:.3} m", at.x, at.y));
        }
    }
    if places.is_empty() {
        return false;
    }
    let raised = match raised_m > 0.0 {
        true => format!(
            " In the file it reaches up to {:.2} mm below the wheels' floor: raised to it.",
            1e3 * raised_m
        ),
        false => String::new(),
    };
    let tilt_deg = floor.up.angle(&Vector3::z_axis()).to_degrees();
    let tilted = match tilt_deg > REMARKED_TILT_DEG {
        true => format!("; on them it leans by {tilt_deg:.2} deg"),
        false => String::new(),
    };
    remarks.push(Remark::new(
        format!("link `{}`", robot.chassis.name),
        format!(
            "stands on its wheels and its chassis, at {}: taken for ball casters, without friction{tilted}.{raised}",
            places.join("; ")
        ),
    ));
    true
}

/// The shapes that may be casters: those of the chassis, and balls of bodies that joints move.
fn carriers(robot: &mut Robot) -> impl Iterator<Item = &mut Collision> {
    let bodies = robot.joints.iter_mut();
    let moved = bodies.flat_map(|joint| &mut joint.body.collisions);
    let balls = moved.filter(|of| matches!(of.shape, CollisionShape::Sphere { .. }));
    robot.chassis.collisions.iter_mut().chain(balls)
}

/// Whether a robot rolls on two tyres alone, which do not carry it.
pub(super) fn is_lone_pair(wheels: &[Wheel]) -> bool {
    wheels.len() < 3 && wheels.iter().any(Wheel::has_tyre)
}

/// Whether the wheels carry the robot without its chassis.
fn stands_on_wheels(robot: &Robot) -> bool {
    let mut bare = robot.clone();
    bare.chassis.collisions.clear();
    bare.standing_pose().is_some()
}

pub(super) fn least_radius_m(robot: &Robot) -> f64 {
    let radii = robot.wheels.iter().map(|wheel| wheel.radius_m);
    radii.fold(f64::INFINITY, f64::min)
}

/// Raises shapes that reach below the level floor of the wheels by rounding, to this floor, unless
/// others reach deeper. Returns by how much at most, in metres.
fn raise_rounded(robot: &mut Robot) -> f64 {
    let floor_m = -robot.ride_height_m();
    let deep_m = |shape: &Collision| floor_m + shape.reach_m(&-Vector3::z());
    let depths = carriers(robot).map(|of| deep_m(of));
    let most_m = depths.fold(0.0, f64::max);
    if !(EXACT_M..=ROUNDED_M).contains(&most_m) {
        return 0.0;
    }
    for shape in carriers(robot) {
        let by_m = deep_m(shape).max(0.0);
        shape.body_from_shape.translation.vector.z += by_m;
    }
    most_m
}

/// The floor on which a robot stands: tilted to its pose, or level below its wheels.
struct Floor {
    up: Unit<Vector3<f64>>,
    height_m: f64,
}

impl Floor {
    fn of(robot: &Robot) -> Self {
        let pose = robot.standing_pose();
        Self {
            up: (pose.as_ref()).map_or_else(Vector3::z_axis, StandingPose::up_in_body),
            height_m: pose.map_or_else(|| robot.ride_height_m(), |pose| pose.height_m),
        }
    }

    /// The height of the lowest point of a shape above it, in metres.
    fn height_m(&self, shape: &Collision) -> f64 {
        self.height_m - shape.reach_m(&-self.up.into_inner())
    }
}
