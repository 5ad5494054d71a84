//! Checks that the step is short enough for the contact springs and the bearings.
//!
//! A mass 1/W on a spring k with damping c, stepped by h with the damper at the old speed, is
//! stable for k W h^2 + 2 c W h < 4 and c W h < 2. At most a quarter of that is allowed: k W
//! h^2 + 2 c W h <= 1.
//!
//! W, the gain in a contact's speed per unit impulse there, is bounded from above by the chassis,
//! the wheels and the rollers as one rigid body, except for the joints between bodies, pushed at
//! the wheel's bottom with the wheel free about its axis (solved with the engine's own matrix).
//! Along the floor, r^2 / I is added for the roller's rotation about its own axis. As all wheels
//! may oscillate together, the terms of the wheels are summed. So are those of all elements in
//! joints between bodies, whose W `linkage.rs` computes.

use ilon_robot::Robot;
use nalgebra::Vector3;

use crate::dynamics::ArrowSystem;
use crate::forces::{Forces, Prescribed};
use crate::generalised::Generalised;
use crate::posture::{Carried, Posture};
use crate::tree::Tree;
use crate::{OracleError, Settings};

/// `in_joints` are the sums of k W and of c W over all elements in joints.
pub(crate) fn check(
    tree: &Tree,
    robot: &Robot,
    settings: &Settings,
    in_joints: (f64, f64),
) -> Result<(), OracleError> {
    let law = &settings.contact;
    let rigid: Vector3<f64> = (0..tree.wheels.len())
        .map(|w| {
            // A tyre touches in several places, each on springs.
            let places = if robot.wheels[w].has_tyre() {
                tree.wheels[w].rollers.len() as f64
            } else {
                1.0
            };
            places * response(tree, w, robot.wheels[w].radius_m)
        })
        .sum();
    let turning = robot
        .wheels
        .iter()
        .flat_map(|w| &w.rollers)
        .filter(|r| !r.is_tyre())
        .map(|r| r.radius_m * r.radius_m / r.axial_inertia_kg_m2)
        .fold(0.0, f64::max);
    let across = rigid.x.max(rigid.y) + turning;
    let limits = [
        (
            "contacts' normal springs",
            law.normal_stiffness_n_m * rigid.z,
            law.normal_damping_n_s_m * rigid.z,
        ),
        (
            "contacts' bristles",
            law.bristle_stiffness_n_m * across,
            law.bristle_damping_n_s_m * across,
        ),
        ("joints", in_joints.0, in_joints.1),
    ];
    let bearings = tree.rollers.iter().filter(|r| !r.is_tyre);
    let bearings = bearings.map(|r| (r.bearing, r.axial_inertia));
    let hubs = tree
        .wheels
        .iter()
        .map(|w| (w.bearing, w.hub.about_center[(2, 2)]));
    let damped = bearings
        .chain(hubs)
        .map(|(joint, inertia)| joint.damping_n_m_s / inertia)
        .fold(0.0, f64::max);
    let springs = limits.map(|(of, kw, cw)| {
        // Without springs, the damper alone sets the limit.
        let longest_s = if kw > 0.0 {
            ((cw * cw + kw).sqrt() - cw) / kw
        } else {
            0.5 / cw
        };
        (of, longest_s)
    });
    let step_s = settings.step_s;
    let (of, longest_s) =
        springs.into_iter().fold(
            ("bearings", 0.5 / damped),
            |a, b| if b.1 < a.1 { b } else { a },
        );
    if step_s > longest_s {
        return Err(OracleError::StepTooLong {
            step_s,
            of,
            longest_s,
        });
    }
    Ok(())
}

/// The velocity gain of a wheel's lowest point along x, y and z per unit impulse along each, with
/// rollers not turning.
fn response(tree: &Tree, w: usize, radius: f64) -> Vector3<f64> {
    let posture = Posture::new(tree);
    let hub = &posture.hubs[w];
    let point = hub.middle - Vector3::z() * radius;
    let rest = Generalised::zero(tree);
    let held = Prescribed {
        wheels: vec![None; tree.wheels.len()],
        rollers: vec![Some(0.0); tree.rollers.len()],
    };
    let mut carried = vec![Carried::REST; tree.carriers()];
    let mut gain = Vector3::zeros();
    for i in 0..3 {
        let mut unit = Vector3::zeros();
        unit[i] = 1.0;
        let (mut force, mut unused) = (Forces::zero(tree), Forces::zero(tree));
        let mut u = rest.clone();
        force.act_on_wheel(tree, &posture, w, &point, &unit);
        let mut system = ArrowSystem::new(tree);
        system.assemble(tree, &posture, &rest, &force);
        if system.solve(tree, &held, &mut u, &mut unused) {
            posture.carry(tree, &u, &mut carried);
            let turning = hub.axis.cross(&(point - hub.middle)) * u.wheels[w];
            gain[i] = (carried[tree.wheels[w].carrier].velocity(&point) + turning)[i];
        }
    }
    gain
}
