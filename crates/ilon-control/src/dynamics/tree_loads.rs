//! How the weight of a robot with joints between its bodies stands on its wheels.
//!
//! On level ground, with l_jh by how much joint j raises wheel h in the body frame per movement, and w_j what weight and inertia of all that a joint
//! carries do in it:
//!
//! - the loads carry the robot: sum N_h (1, x_h, y_h) is its weight and the moments of that;
//! - a free joint bears nothing: sum_h l_jh N_h + w_j = 0;
//! - a sprung one, and a driven one about its target, gives way by what it bears: q_j = q_0j + (sum_h l_jh N_h + w_j) / k_j, with q_0j where its spring alone is at rest;
//! - the wheels stand on one plane: sum_j l_jh q_j + N_h / k = a + b x_h + c y_h, where k is that of wheels on the ground, far above the springs'.
//!
//! What accelerates the robot along the ground pulls on all wheels alike. These are linear in the loads, and the loads are linear in gravity and acceleration.

use ilon_robot::{BodyJoint, JointKind, Robot};
use nalgebra::{DMatrix, DVector, Point3, Vector2, Vector3};

/// The loads as they follow from gravity and acceleration.
#[derive(Clone, Debug)]
pub(super) struct TreeLoads {
    /// Without either, in N: what springs press that are at odds with one another.
    own_n: DVector<f64>,
    /// Per gravity, and per acceleration along x and y, in kg.
    per_m_s2: [DVector<f64>; 3],
}

/// How much stiffer wheels stand on the ground than the stiffest spring.
const GROUND: f64 = 1e5;

impl TreeLoads {
    /// Of a robot with joints; `None` where its wheels leave open how it stands, as on free joints that fall over.
    pub(super) fn new(robot: &Robot) -> Option<Self> {
        let raises: Vec<Vec<f64>> = robot
            .joints
            .iter()
            .enumerate()
            .map(|(index, joint)| raised_by(robot, index, joint))
            .collect();
        let wheels = robot.wheels.len();
        let free: Vec<usize> = (0..robot.joints.len())
            .filter(|joint| robot.joints[*joint].gives_by().is_none())
            .collect();
        let stiffnesses = robot.joints.iter().zip(&raises).filter_map(|(joint, l)| {
            let most = l.iter().fold(0.0, |most: f64, l| most.max(l * l));
            (most > 0.0).then_some(joint.gives_by()?.stiffness / most)
        });
        let ground_n_m = GROUND * stiffnesses.fold(1.0, f64::max);
        let size = wheels + 3 + free.len();
        let mut matrix = DMatrix::zeros(size, size);
        for (h, wheel) in robot.wheels.iter().enumerate() {
            matrix[(h, h)] = 1.0 / ground_n_m;
            let at_m = wheel.position_m();
            for (k, c) in [1.0, at_m.x, at_m.y].into_iter().enumerate() {
                matrix[(h, wheels + k)] = -c;
                matrix[(wheels + k, h)] = c;
            }
            for (place, joint) in free.iter().enumerate() {
                matrix[(h, wheels + 3 + place)] = raises[*joint][h];
                matrix[(wheels + 3 + place, h)] = raises[*joint][h];
            }
        }
        for (joint, l) in robot.joints.iter().zip(&raises) {
            let Some(spring) = joint.gives_by() else {
                continue;
            };
            for (i, of_i) in l.iter().enumerate() {
                for (j, of_j) in l.iter().enumerate() {
                    matrix[(i, j)] += of_i * of_j / spring.stiffness;
                }
            }
        }
        let factors = matrix.full_piv_lu();
        let solve = |right: &DVector<f64>| {
            let loads = factors.solve(right)?.rows(0, wheels).into_owned();
            loads.iter().all(|n| n.is_finite()).then_some(loads)
        };
        let mut own = DVector::zeros(size);
        for (joint, l) in robot.joints.iter().zip(&raises) {
            if let Some(spring) = joint.gives_by() {
                let rest = spring.rest + spring.preload / spring.stiffness;
                for (h, l) in l.iter().enumerate() {
                    own[h] -= l * rest;
                }
            }
        }
        let per = |field: Vector3<f64>| {
            let mut right = DVector::zeros(size);
            let center_m = robot.center_of_mass_m() + Vector3::z() * robot.ride_height_m();
            let force = robot.mass_kg() * field;
            // What the ground has to carry: the force, and its moments about the ground's y and x axes.
            right[wheels] = -force.z;
            right[wheels + 1] = -force.z * center_m.x + force.x * center_m.z;
            right[wheels + 2] = -force.z * center_m.y + force.y * center_m.z;
            for (index, (joint, l)) in robot.joints.iter().zip(&raises).enumerate() {
                let borne = borne_by(robot, index, &field);
                match joint.gives_by() {
                    Some(spring) => {
                        for (h, l) in l.iter().enumerate() {
                            right[h] -= l * borne / spring.stiffness;
                        }
                    }
                    None => {
                        let place = free.iter().position(|free| *free == index);
                        right[wheels + 3 + place.unwrap_or(0)] = -borne;
                    }
                }
            }
            solve(&right)
        };
        Some(Self {
            own_n: solve(&own)?,
            // What acts on all masses as they are accelerated is the opposite.
            per_m_s2: [
                per(-Vector3::z())?,
                per(-Vector3::x())?,
                per(-Vector3::y())?,
            ],
        })
    }

    /// The loads in N, of which those that would pull are zero and the others bear as much less.
    pub(super) fn fill_n(&self, gravity_m_s2: f64, acceleration: Vector2<f64>, out: &mut [f64]) {
        let [of_gravity, of_x, of_y] = &self.per_m_s2;
        for (h, out) in out.iter_mut().enumerate() {
            *out = self.own_n[h]
                + of_gravity[h] * gravity_m_s2
                + of_x[h] * acceleration.x
                + of_y[h] * acceleration.y;
        }
        let sum_n: f64 = out.iter().sum();
        let pressing_n: f64 = out.iter().map(|n| n.max(0.0)).sum();
        if pressing_n > sum_n && pressing_n > 0.0 {
            let share = (sum_n / pressing_n).max(0.0);
            out.iter_mut().for_each(|n| *n = n.max(0.0) * share);
        }
    }
}

/// Whether a body, on a joint or the chassis, hangs by a joint.
fn hangs(robot: &Robot, carrier: Option<usize>, joint: usize) -> bool {
    std::iter::successors(carrier, |at| robot.joints[*at].parent).any(|at| at == joint)
}

/// How a place moves per movement of a joint, in the body frame.
fn moves(joint: &BodyJoint, place_m: &Vector3<f64>) -> Vector3<f64> {
    let axis = joint.body_from_joint.rotation * Vector3::z();
    match joint.kind {
        JointKind::Slides => axis,
        JointKind::Turns => axis.cross(&(place_m - joint.body_from_joint.translation.vector)),
    }
}

/// By how much a joint raises each wheel.
fn raised_by(robot: &Robot, index: usize, joint: &BodyJoint) -> Vec<f64> {
    let wheels = robot.wheels.iter();
    wheels
        .map(|wheel| {
            if hangs(robot, wheel.carrier, index) {
                moves(joint, &wheel.position_m()).z
            } else {
                0.0
            }
        })
        .collect()
}

/// What a field of force per mass does in a joint to all that it carries. What of it lies along the ground is taken up where the wheels stand,
/// by all of them alike, with their motors' torques in what carries them.
fn borne_by(robot: &Robot, index: usize, field: &Vector3<f64>) -> f64 {
    let joint = &robot.joints[index];
    let of = |mass_kg: f64, at_m: Vector3<f64>| mass_kg * field.dot(&moves(joint, &at_m));
    let share_kg = robot.mass_kg() / robot.wheels.len() as f64;
    let pull_n = -share_kg * Vector3::new(field.x, field.y, 0.0);
    let bodies = robot.joints.iter().enumerate();
    let bodies = bodies.filter(|(at, _)| hangs(robot, Some(*at), index));
    let bodies = bodies.map(|(_, body)| of(body.body.mass.mass_kg, body.center_of_mass_m()));
    let wheels = robot.wheels.iter();
    let wheels = wheels.filter(|wheel| hangs(robot, wheel.carrier, index));
    let wheels = wheels.map(|wheel| {
        let in_body = |at_m: Vector3<f64>| (wheel.body_from_hub * Point3::from(at_m)).coords;
        let rollers = wheel.rollers.iter();
        of(wheel.hub.mass_kg, in_body(wheel.hub.center_of_mass_m))
            + rollers
                .map(|roller| of(roller.mass_kg, in_body(roller.center_in_hub_m)))
                .sum::<f64>()
            + pull_n.dot(&moves(
                joint,
                &(wheel.position_m() - Vector3::z() * wheel.reach_at_rest_m()),
            ))
    });
    bodies.sum::<f64>() + wheels.sum::<f64>()
}
