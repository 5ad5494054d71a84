//! The robot as a whole: its chassis, and what must hold between its wheels.

use urdf_rs::Geometry;

use super::remark;
use super::source::Source;
use super::tree::{Motion, PlacedShape, RigidBody, Tree};
use super::wheels::Candidate;
use crate::error::{Fault, RobotError};
use crate::model::{Chassis, Collision, CollisionShape, Remark, Robot};

/// Fewest wheels that hold all three freedoms of the plane.
const LEAST_WHEELS: usize = 3;
/// A wheel larger than this is taken for millimetres.
const LARGEST_WHEEL_M: f64 = 5.0;

/// Refuses fewer than three wheels, saying what was found instead.
pub(super) fn check_wheel_count(
    source: &Source,
    tree: &Tree,
    candidates: &[Candidate],
) -> Result<(), RobotError> {
    if candidates.len() >= LEAST_WHEELS {
        return Ok(());
    }
    let turning = |j: &usize| tree.joints[*j].motion == Motion::Turning;
    let has_turning_below = |j: usize| {
        let turns = |&other: &usize| tree.turning_above(other) == Some(j);
        (0..tree.joints.len())
            .filter(turning)
            .any(|other| turns(&other))
    };
    let ends = || {
        (0..tree.joints.len())
            .filter(turning)
            .filter(|&j| !has_turning_below(j))
    };
    let name = |j: usize| tree.joints[j].name.clone();
    if !candidates.is_empty() {
        let wheels = candidates.iter().map(|c| name(c.hub)).collect();
        return Err(source.robot_error(Fault::TooFewWheels { wheels }));
    }
    // A wheel on a level axis that hangs by an upright turning joint is steered.
    let level = |j: usize| tree.joints[j].axis.z.abs() < 0.1;
    let steered: Vec<String> = ends()
        .filter(|&j| level(j) && tree.turning_above(j).is_some_and(|above| !level(above)))
        .map(name)
        .collect();
    if !steered.is_empty() {
        return Err(source.joint_error(&steered[0].clone(), Fault::Steered { wheels: steered }));
    }
    let plain: Vec<String> = ends()
        .filter(|&j| level(j) && tree.turning_above(j).is_none())
        .map(name)
        .collect();
    if plain.len() >= LEAST_WHEELS {
        return Err(source.joint_error(&plain[0].clone(), Fault::NoRollers { wheels: plain }));
    }
    let wheels = Vec::new();
    Err(source.robot_error(Fault::TooFewWheels { wheels }))
}

/// Says which movable joints are held at zero.
pub(super) fn remark_held(tree: &Tree, body: &RigidBody, of: &str, remarks: &mut Vec<Remark>) {
    for &j in &body.held {
        remarks.push(remark(
            format!("joint `{}`", tree.joints[j].name),
            format!("neither wheel nor roller: it is held at zero and moves with {of}"),
        ));
    }
}

/// The chassis from the body that hangs by the root link.
pub(super) fn chassis(
    source: &Source,
    tree: &Tree,
    body: RigidBody,
    remarks: &mut Vec<Remark>,
) -> Result<Chassis, RobotError> {
    let name = tree.links[body.link].name.clone();
    let mass = body
        .mass
        .ok_or_else(|| source.link_error(&name, Fault::NoMass))?;
    let mut meshes = 0;
    let mut collisions = Vec::with_capacity(body.shapes.len());
    for PlacedShape {
        body_from_shape,
        geometry,
    } in body.shapes
    {
        let shape = match geometry {
            Geometry::Box { size } => CollisionShape::Box {
                half_extents_m: nalgebra::Vector3::from(*size) * 0.5,
            },
            Geometry::Cylinder { radius, length } => CollisionShape::Cylinder {
                radius_m: radius,
                length_m: length,
            },
            Geometry::Capsule { radius, length } => CollisionShape::Capsule {
                radius_m: radius,
                length_m: length,
            },
            Geometry::Sphere { radius } => CollisionShape::Sphere { radius_m: radius },
            Geometry::Mesh { .. } => {
                meshes += 1;
                continue;
            }
        };
        collisions.push(Collision {
            body_from_shape,
            shape,
        });
    }
    if meshes > 0 {
        remarks.push(remark(
            format!("link `{name}`"),
            format!(
                "{meshes} collision meshes of the chassis are not read: it touches nothing there"
            ),
        ));
    }
    Ok(Chassis {
        name,
        mass,
        collisions,
    })
}

/// Checks what must hold between the wheels, and hands the robot on.
pub(super) fn check(source: &Source, robot: Robot) -> Result<Robot, RobotError> {
    for wheel in &robot.wheels {
        if wheel.radius_m > LARGEST_WHEEL_M {
            let fault = Fault::LooksLikeMillimetres {
                radius_m: wheel.radius_m,
            };
            return Err(source.joint_error(&wheel.name, fault));
        }
    }
    // All wheels must stand on one floor while the body is level.
    let bottom_m = |w: &crate::Wheel| w.position_m().z - w.radius_m;
    let mut by_height: Vec<&crate::Wheel> = robot.wheels.iter().collect();
    by_height.sort_by(|p, q| bottom_m(p).total_cmp(&bottom_m(q)));
    if let [lowest, .., highest] = by_height[..] {
        let apart_m = bottom_m(highest) - bottom_m(lowest);
        if apart_m > 0.01 * lowest.radius_m {
            let fault = Fault::UnevenWheels {
                lower_wheel: lowest.name.clone(),
                apart_mm: 1e3 * apart_m,
            };
            return Err(source.joint_error(&highest.name, fault));
        }
    }
    Ok(robot)
}
