//! The robot as a whole: its chassis, and what must hold between its wheels.

use nalgebra::Vector3;

use super::geometry::primitive;
use super::recognise::Candidate;
use super::source::Source;
use super::tree::{PlacedShape, RigidBody, Tree};
use super::{Loading, remark};
use crate::error::{Fault, RobotError};
use crate::model::{Chassis, Collision, Remark, Robot, Wheel};

/// Fewest wheels that hold all three freedoms of the plane.
const LEAST_WHEELS: usize = 3;
/// A wheel larger than this is taken for millimetres.
const LARGEST_WHEEL_M: f64 = 5.0;

/// Refuses fewer than three wheels, saying what was found instead.
pub(super) fn check_wheel_count(
    loading: &Loading,
    candidates: &[Candidate],
    given: usize,
) -> Result<(), RobotError> {
    if candidates.len() + given >= LEAST_WHEELS {
        return Ok(());
    }
    let (source, tree) = (loading.source, loading.tree);
    let names = |joints: Vec<usize>| -> Vec<String> {
        joints
            .into_iter()
            .map(|j| tree.joints[j].name.clone())
            .collect()
    };
    let found = names(candidates.iter().map(|c| c.hub).collect());
    if let Some((joint, rollers)) = tree.fixed_hub() {
        let wheels = candidates.len() + given;
        let fault = Fault::HubDoesNotTurn { rollers, wheels };
        return Err(source.joint_error(&tree.joints[joint].name, fault));
    }
    if found.is_empty() && given == 0 {
        let steered = names(tree.steered_wheels());
        if let Some(first) = steered.first().cloned() {
            return Err(source.joint_error(&first, Fault::Steered { wheels: steered }));
        }
        let plain = names(tree.plain_wheels());
        if let Some(first) = plain
            .first()
            .filter(|_| plain.len() >= LEAST_WHEELS)
            .cloned()
        {
            return Err(source.joint_error(&first, Fault::NoRollers { wheels: plain }));
        }
    }
    Err(source.robot_error(Fault::TooFewWheels { wheels: found }))
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
pub(super) fn chassis(loading: &mut Loading, body: RigidBody) -> Result<Chassis, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
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
        let Some(shape) = primitive(&geometry) else {
            meshes += 1;
            continue;
        };
        collisions.push(Collision {
            body_from_shape,
            shape,
        });
    }
    if meshes > 0 {
        loading.remarks.push(remark(
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
    let bottom_m = |w: &Wheel| w.position_m().z - w.radius_m;
    let mut by_height: Vec<&Wheel> = robot.wheels.iter().collect();
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
    let floor_m = -robot.ride_height_m();
    let lowest_m = robot
        .chassis
        .collisions
        .iter()
        .map(|collision| -collision.reach_m(&-Vector3::z()))
        .fold(f64::INFINITY, f64::min);
    let radius_m = robot
        .wheels
        .iter()
        .map(|w| w.radius_m)
        .fold(f64::INFINITY, f64::min);
    if lowest_m < floor_m - 0.01 * radius_m {
        let fault = Fault::ChassisBelowFloor {
            deep_mm: 1e3 * (floor_m - lowest_m),
        };
        return Err(source.link_error(&robot.chassis.name, fault));
    }
    Ok(robot)
}
