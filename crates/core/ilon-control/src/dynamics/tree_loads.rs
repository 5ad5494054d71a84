//! The wheel loads of a robot with joints between its bodies.
//!
//! Let l_jh be how much joint j raises wheel h in the body frame per movement, w_j the generalised
//! force in joint j of weight and inertia of all that it carries, and d_j its deflection from its
//! current position:
//!
//! - the loads carry the robot: sum N_h (1, x_h, y_h) is its weight and the weight's moments;
//! - a free joint bears nothing: sum_h l_jh N_h + w_j = 0;
//! - a sprung joint, and a driven one about its target, deflects with its load: sum_h l_jh N_h +
//!   w_j = k_j (d_j - d_0j), where d_0j is the rest position of its spring;
//! - a joint pressed on its stop stays there: d_j = 0;
//! - a coupling d_a = c d_b + e acts with some m in a, and with -c m in b;
//! - the wheels stay on the ground on which they stand: sum_j l_jh d_j + N_h / k = a + b x_h + c
//!   y_h, where k is the stiffness of wheels on the ground, far above the springs'. The part of the
//!   joints' positions that no plane explains is therefore unevenness of the ground, and the
//!   springs press accordingly.
//!
//! An acceleration along the ground needs equal pulls from all wheels. These equations are linear
//! in the loads, and the loads are linear in gravity and acceleration.

use ilon_robot::{BodyJoint, Coupling, JointKind, Robot};
use nalgebra::{DMatrix, DVector, Point3, Vector2, Vector3};

/// The loads as a linear function of gravity and acceleration.
#[derive(Clone, Debug)]
pub(super) struct TreeLoads {
    /// Loads without gravity and acceleration, in N: from springs that press against each other.
    own_n: DVector<f64>,
    /// Loads per gravity, and per acceleration along x and y, in kg.
    per_m_s2: [DVector<f64>; 3],
}

/// Stiffness of wheels on the ground relative to the stiffest spring.
const GROUND: f64 = 1e7;

/// A joint within this distance of a stop is on it, in rad or m.
const ON_STOP: f64 = 1e-4;

impl TreeLoads {
    /// Builds the loads of a robot with joints, under gravity in m/s^2; `None` if its posture is
    /// undetermined, as on free joints that fall over.
    pub(super) fn new(robot: &Robot, gravity_m_s2: f64) -> Option<Self> {
        let statics = Statics::new(robot);
        let mut held = statics.on_stops();
        loop {
            let solved = statics.solve(&held)?;
            // A stop only pushes: a joint that would be pulled onto it leaves it.
            let leaves = (0..held.len()).find(|joint| {
                held[*joint].is_some_and(|side| side * solved.bears(*joint, gravity_m_s2) < 0.0)
            });
            match leaves {
                Some(joint) => held[joint] = None,
                None => return Some(solved.loads),
            }
        }
    }

    /// Writes the loads in N; a load that would pull is set to zero, and the others are reduced
    /// accordingly.
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

/// The equations of the module's documentation. Unknowns: first the loads in N, then the plane
/// under the wheels and the joints' movements, both scaled to forces, then the couplings' forces.
struct Statics<'a> {
    robot: &'a Robot,
    /// l_jh, joint by joint.
    raises: Vec<Vec<f64>>,
    /// The stiffest spring, seen at a wheel, in N/m; it scales movements.
    stiffest_n_m: f64,
}

/// Loads, and each joint's force without its spring and stop, each at zero gravity and per gravity.
struct Solved {
    loads: TreeLoads,
    bears: Vec<[f64; 2]>,
}

impl Solved {
    fn bears(&self, joint: usize, gravity_m_s2: f64) -> f64 {
        let [own, per_m_s2] = self.bears[joint];
        own + per_m_s2 * gravity_m_s2
    }
}

impl<'a> Statics<'a> {
    fn new(robot: &'a Robot) -> Self {
        let joints = robot.joints.iter().enumerate();
        let raises: Vec<Vec<f64>> = joints
            .map(|(index, joint)| raised_by(robot, index, joint))
            .collect();
        let stiffnesses = robot.joints.iter().zip(&raises).filter_map(|(joint, l)| {
            let most = l.iter().fold(0.0, |most: f64, l| most.max(l * l));
            (most > 0.0).then_some(joint.gives_by()?.stiffness / most)
        });
        Self {
            stiffest_n_m: stiffnesses.fold(1.0, f64::max),
            raises,
            robot,
        }
    }

    /// Returns the joints that are on a stop, each with the side. Of two coupled joints the
    /// follower is left out.
    fn on_stops(&self) -> Vec<Option<f64>> {
        let side = |joint: &BodyJoint| match joint.limits {
            [_, upper] if upper <= ON_STOP => Some(1.0),
            [lower, _] if lower >= -ON_STOP => Some(-1.0),
            _ => None,
        };
        let mut held: Vec<Option<f64>> = self.robot.joints.iter().map(side).collect();
        for coupling in &self.robot.couplings {
            if held[coupling.follows].is_some() {
                held[coupling.joint] = None;
            }
        }
        held
    }

    fn joint_row(&self, joint: usize) -> usize {
        self.robot.wheels.len() + 3 + joint
    }

    fn coupling_row(&self, coupling: usize) -> usize {
        self.joint_row(self.robot.joints.len()) + coupling
    }

    /// Whether each joint keeps its position: held joints, and joints without spring or wheel,
    /// which fall until they hang and are not solved here.
    fn stays(&self, held: &[Option<f64>]) -> Vec<bool> {
        let hangs_free = |joint: usize| {
            let is_coupled = |of: &Coupling| of.joint == joint || of.follows == joint;
            self.robot.joints[joint].gives_by().is_none()
                && self.raises[joint].iter().all(|l| *l == 0.0)
                && !self.robot.couplings.iter().any(is_coupled)
        };
        let joints = held.iter().enumerate();
        joints
            .map(|(joint, side)| side.is_some() || hangs_free(joint))
            .collect()
    }

    /// The left-hand side; joints that keep their position are fixed.
    fn matrix(&self, stays: &[bool]) -> DMatrix<f64> {
        let wheels = self.robot.wheels.len();
        let size = self.coupling_row(self.robot.couplings.len());
        let mut matrix = DMatrix::zeros(size, size);
        for (h, wheel) in self.robot.wheels.iter().enumerate() {
            matrix[(h, h)] = 1.0;
            let at_m = wheel.position_m();
            for (k, c) in [1.0, at_m.x, at_m.y].into_iter().enumerate() {
                matrix[(h, wheels + k)] = -c;
                matrix[(wheels + k, h)] = c;
            }
            for (joint, raises) in self.raises.iter().enumerate() {
                let row = self.joint_row(joint);
                matrix[(h, row)] = GROUND * raises[h];
                matrix[(row, h)] = raises[h];
            }
        }
        for (joint, of) in self.robot.joints.iter().enumerate() {
            let row = self.joint_row(joint);
            let stiffness = of.gives_by().map_or(0.0, |spring| spring.stiffness);
            matrix[(row, row)] = -stiffness / self.stiffest_n_m;
        }
        for (index, coupling) in self.robot.couplings.iter().enumerate() {
            let row = self.coupling_row(index);
            for (joint, c) in [(coupling.joint, 1.0), (coupling.follows, -coupling.factor)] {
                matrix[(row, self.joint_row(joint))] = c;
                matrix[(self.joint_row(joint), row)] = c;
            }
        }
        for joint in (0..stays.len()).filter(|joint| stays[*joint]) {
            let row = self.joint_row(joint);
            matrix.row_mut(row).fill(0.0);
            matrix[(row, row)] = 1.0;
        }
        matrix
    }

    fn solve(&self, held: &[Option<f64>]) -> Option<Solved> {
        let robot = self.robot;
        let (wheels, joints) = (robot.wheels.len(), robot.joints.len());
        let stays = self.stays(held);
        let matrix = self.matrix(&stays);
        let size = matrix.nrows();
        let (at_rest, per_fields) = {
            let mut own = DVector::zeros(size);
            for (joint, of) in robot.joints.iter().enumerate() {
                if let Some(spring) = of.gives_by().filter(|_| !stays[joint]) {
                    own[self.joint_row(joint)] = -spring.stiffness * spring.rest - spring.preload;
                }
            }
            for (index, coupling) in robot.couplings.iter().enumerate() {
                own[self.coupling_row(index)] = self.stiffest_n_m * coupling.offset;
            }
            let per = |field: Vector3<f64>| {
                let mut right = DVector::zeros(size);
                let center_m = robot.center_of_mass_m() + Vector3::z() * robot.ride_height_m();
                let force = robot.mass_kg() * field;
                // The load of the ground: the force, and its moments about the ground's y and x
                // axes.
                right[wheels] = -force.z;
                right[wheels + 1] = -force.z * center_m.x + force.x * center_m.z;
                right[wheels + 2] = -force.z * center_m.y + force.y * center_m.z;
                for joint in (0..joints).filter(|joint| !stays[*joint]) {
                    right[self.joint_row(joint)] = -borne_by(robot, joint, &field);
                }
                right
            };
            // An acceleration acts on all masses as the opposite field.
            let fields = [-Vector3::z(), -Vector3::x(), -Vector3::y()];
            (own, fields.map(per))
        };
        let factors = matrix.full_piv_lu();
        let solve = |right: &DVector<f64>| {
            let all = factors.solve(right)?;
            all.iter().all(|n| n.is_finite()).then_some(all)
        };
        let own = solve(&at_rest)?;
        let [of_gravity, of_x, of_y] = per_fields.map(|right| solve(&right));
        let [of_gravity, of_x, of_y] = [of_gravity?, of_x?, of_y?];
        let bears = |joint: usize| {
            let pressed = |all: &DVector<f64>| {
                let wheels = self.raises[joint].iter().zip(all.iter());
                wheels.map(|(l, n)| l * n).sum::<f64>()
            };
            let spring = robot.joints[joint].gives_by();
            let spring = spring.map_or(0.0, |spring| spring.force_at(0.0));
            let weight = borne_by(robot, joint, &-Vector3::z());
            [pressed(&own) + spring, pressed(&of_gravity) + weight]
        };
        let loads = |all: DVector<f64>| all.rows(0, wheels).into_owned();
        Some(Solved {
            bears: (0..joints).map(bears).collect(),
            loads: TreeLoads {
                own_n: loads(own),
                per_m_s2: [of_gravity, of_x, of_y].map(loads),
            },
        })
    }
}

/// Whether a body, on a joint or the chassis, is carried by a joint.
fn hangs(robot: &Robot, carrier: Option<usize>, joint: usize) -> bool {
    std::iter::successors(carrier, |at| robot.joints[*at].parent).any(|at| at == joint)
}

/// Returns how a point moves per movement of a joint, in the body frame.
fn moves(joint: &BodyJoint, place_m: &Vector3<f64>) -> Vector3<f64> {
    let axis = joint.body_from_joint.rotation * Vector3::z();
    match joint.kind {
        JointKind::Slides => axis,
        JointKind::Turns => axis.cross(&(place_m - joint.body_from_joint.translation.vector)),
    }
}

/// Returns how much a joint raises each wheel; zero if only rounding says so, as for a horizontal
/// slide.
fn raised_by(robot: &Robot, index: usize, joint: &BodyJoint) -> Vec<f64> {
    /// In m per rad or m.
    const LEAST: f64 = 1e-9;
    let wheels = robot.wheels.iter();
    let hanging = wheels.map(|wheel| hangs(robot, wheel.carrier, index).then_some(wheel));
    let raised =
        hanging.map(|wheel| wheel.map_or(0.0, |wheel| moves(joint, &wheel.position_m()).z));
    raised
        .map(|l| if l.abs() < LEAST { 0.0 } else { l })
        .collect()
}

/// Returns the generalised force in a joint of a field of force per mass on all that it carries.
/// The field's part along the ground is taken up at the contacts by all wheels alike, with their
/// motors' torques.
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
