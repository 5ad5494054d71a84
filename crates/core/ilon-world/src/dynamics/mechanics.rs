//! A tree in one pose: its mass matrix, and the forces of its motion.

use ilon_robot::MassProperties;
use nalgebra::{Matrix3, Vector3, Vector6};

use super::attached::Attached;
use super::factors::{Factors, OfJoint};
use super::tree::{LinkPose, Motion, ROOT_DOFS, Tree};

/// A tree in a pose, with work space.
#[derive(Clone, Debug)]
pub(crate) struct Mechanics {
    root: Link,
    links: Vec<Link>,
    /// Composite inertia of each link with all that it carries.
    wholes: Vec<Inertia>,
    moving: Vec<Moving>,
    factors: Factors,
    /// The inertia of bodies that another engine moves with the root.
    pub attached: Option<Box<Attached>>,
}

/// Loads on a tree besides gravity, in N, N m, and in N for prismatic joints.
#[derive(Clone, Debug)]
pub(crate) struct Loads {
    /// On the root: the force, and the torque about its centre of mass.
    pub force_on_root_n: Vector3<f64>,
    pub torque_on_root_n_m: Vector3<f64>,
    /// External torques on the links.
    pub torques_on_links_n_m: Vec<Vector3<f64>>,
    /// In the joints: on the link, and the opposite on its carrier.
    pub in_joints: Vec<f64>,
}

/// A link in its pose, relative to the root's centre of mass.
#[derive(Clone, Copy, Debug)]
struct Link {
    mass_kg: f64,
    /// Its centre of mass.
    at_m: Vector3<f64>,
    /// About its centre of mass.
    inertia_kg_m2: Matrix3<f64>,
    /// The origin of its frame.
    origin_m: Vector3<f64>,
    axis: Vector3<f64>,
    /// Its twist per unit rate of its joint: linear, then angular.
    screw: Vector6<f64>,
}

/// The motion of a link at the current rates without joint accelerations.
#[derive(Clone, Copy, Debug)]
struct Moving {
    angular_rad_s: Vector3<f64>,
    angular_rad_s2: Vector3<f64>,
    /// Of its frame's origin.
    linear_m_s2: Vector3<f64>,
    /// Force on it and all that it carries, about the root's centre of mass.
    force_n: Vector3<f64>,
    torque_n_m: Vector3<f64>,
}

/// Mass, moment and inertia about the root's centre of mass.
#[derive(Clone, Copy, Debug)]
struct Inertia {
    mass_kg: f64,
    moment_kg_m: Vector3<f64>,
    inertia_kg_m2: Matrix3<f64>,
}

impl Inertia {
    fn of(link: &Link) -> Self {
        let (m, at) = (link.mass_kg, &link.at_m);
        let mut inertia_kg_m2 = link.inertia_kg_m2 - m * at * at.transpose();
        let along = m * at.norm_squared();
        for axis in 0..3 {
            inertia_kg_m2[(axis, axis)] += along;
        }
        Self {
            mass_kg: m,
            moment_kg_m: m * at,
            inertia_kg_m2,
        }
    }

    fn add(&mut self, other: &Self) {
        self.mass_kg += other.mass_kg;
        self.moment_kg_m += other.moment_kg_m;
        self.inertia_kg_m2 += other.inertia_kg_m2;
    }

    /// Momentum and angular momentum of a twist.
    fn momentum(&self, twist: &Vector6<f64>) -> Vector6<f64> {
        let (v, w) = halves(twist);
        let linear = self.mass_kg * v + w.cross(&self.moment_kg_m);
        let angular = self.moment_kg_m.cross(&v) + self.inertia_kg_m2 * w;
        joined(&linear, &angular)
    }
}

impl Link {
    fn placed(mass: &MassProperties, pose: &LinkPose, from_m: &Vector3<f64>) -> Self {
        let rotation = &pose.rotation;
        let origin_m = pose.center_m - from_m;
        Self {
            mass_kg: mass.mass_kg,
            at_m: origin_m + rotation * mass.center_of_mass_m,
            inertia_kg_m2: rotation * mass.inertia_kg_m2 * rotation.transpose(),
            origin_m,
            axis: pose.axis(),
            screw: Vector6::zeros(),
        }
    }

    /// The force and moment that this motion needs.
    fn needs(&self, moving: &Moving, gravity: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let Moving {
            angular_rad_s: w,
            angular_rad_s2: turns,
            linear_m_s2,
            ..
        } = moving;
        let lever_m = self.at_m - self.origin_m;
        let accelerates = linear_m_s2 + turns.cross(&lever_m) + w.cross(&w.cross(&lever_m));
        let force_n = self.mass_kg * (accelerates - gravity);
        let inertia = &self.inertia_kg_m2;
        let torque_n_m = self.at_m.cross(&force_n) + inertia * turns + w.cross(&(inertia * w));
        (force_n, torque_n_m)
    }
}

impl Loads {
    /// No loads on a tree.
    pub fn none(tree: &Tree) -> Self {
        let joints = tree.joints().len();
        Self {
            force_on_root_n: Vector3::zeros(),
            torque_on_root_n_m: Vector3::zeros(),
            torques_on_links_n_m: vec![Vector3::zeros(); joints],
            in_joints: vec![0.0; joints],
        }
    }
}

impl Mechanics {
    /// Memory for a tree.
    pub fn of(tree: &Tree) -> Self {
        let nowhere = LinkPose {
            center_m: Vector3::zeros(),
            rotation: Matrix3::identity(),
        };
        let link = |mass: &MassProperties| Link::placed(mass, &nowhere, &Vector3::zeros());
        let links: Vec<Link> = tree
            .joints()
            .iter()
            .map(|joint| link(&joint.mass))
            .collect();
        let still = Moving {
            angular_rad_s: Vector3::zeros(),
            angular_rad_s2: Vector3::zeros(),
            linear_m_s2: Vector3::zeros(),
            force_n: Vector3::zeros(),
            torque_n_m: Vector3::zeros(),
        };
        Self {
            root: link(&tree.root),
            wholes: links.iter().map(Inertia::of).collect(),
            moving: vec![still; links.len()],
            links,
            factors: Factors::of(tree),
            attached: None,
        }
    }

    /// Its current mass matrix, factorised, with the implicit damping of the joints on the
    /// diagonal.
    pub fn factors(&self) -> &Factors {
        &self.factors
    }

    /// Updates the pose, in the floor's frame, and factorises its mass matrix. `held` is added to
    /// the diagonal: the loss of impulse per rate gained by a joint's drive and bearing, in N m s^2
    /// or kg.
    pub fn stand(&mut self, tree: &Tree, root: &LinkPose, links: &[LinkPose], held: &[f64]) {
        self.set_up(tree, root, links, held);
        self.factors.factorise(tree);
    }

    /// The same without the factorisation.
    pub(super) fn set_up(
        &mut self,
        tree: &Tree,
        root: &LinkPose,
        links: &[LinkPose],
        held: &[f64],
    ) {
        self.root = Link::placed(&tree.root, root, &root.center_m);
        for (index, (joint, pose)) in tree.joints().iter().zip(links).enumerate() {
            let mut link = Link::placed(&joint.mass, pose, &root.center_m);
            link.screw = match joint.motion {
                Motion::Turns => joined(&link.origin_m.cross(&link.axis), &link.axis),
                Motion::Slides => joined(&link.axis, &Vector3::zeros()),
            };
            self.wholes[index] = Inertia::of(&link);
            self.links[index] = link;
        }
        let mut all = Inertia::of(&self.root);
        for (index, joint) in tree.joints().iter().enumerate().rev() {
            let whole = self.wholes[index];
            let momentum = whole.momentum(&self.links[index].screw);
            self.factors.joints[index] = OfJoint {
                root: momentum,
                own: self.links[index].screw.dot(&momentum) + joint.armature + held[index],
            };
            let between = &mut self.factors.between[tree.entries_of(index)];
            for (entry, ancestor) in between.iter_mut().zip(tree.ancestors(index)) {
                *entry = self.links[usize::from(*ancestor)].screw.dot(&momentum);
            }
            match joint.parent {
                Some(parent) => self.wholes[parent].add(&whole),
                None => all.add(&whole),
            }
        }
        let h = &all.moment_kg_m;
        let crosses = h.cross_matrix();
        for row in 0..3 {
            self.factors.root[row][..3].fill(0.0);
            self.factors.root[row][row] = all.mass_kg;
            for column in 0..3 {
                self.factors.root[3 + row][column] = crosses[(row, column)];
                self.factors.root[3 + row][3 + column] = all.inertia_kg_m2[(row, column)];
            }
        }
        if let Some(attached) = &mut self.attached {
            attached.stand(&root.rotation);
            for (row, entries) in self.factors.root.iter_mut().enumerate() {
                for (column, entry) in entries[..=row].iter_mut().enumerate() {
                    *entry += attached.about_center()[(row, column)];
                }
            }
        }
    }

    /// The generalised forces that remain for accelerations, tau - c, for these rates, loads and
    /// gravity in m/s^2.
    pub fn forces(
        &mut self,
        tree: &Tree,
        rates: &[f64],
        (loads, gravity): (&Loads, &Vector3<f64>),
        forces: &mut [f64],
    ) {
        let still = Moving {
            angular_rad_s: Vector3::new(rates[3], rates[4], rates[5]),
            angular_rad_s2: Vector3::zeros(),
            linear_m_s2: Vector3::zeros(),
            force_n: Vector3::zeros(),
            torque_n_m: Vector3::zeros(),
        };
        for (index, joint) in tree.joints().iter().enumerate() {
            let (parent, from_m) = match joint.parent {
                Some(parent) => (&self.moving[parent], &self.links[parent].origin_m),
                None => (&still, &Vector3::zeros()),
            };
            let link = &self.links[index];
            let w = parent.angular_rad_s;
            let by_joint = link.axis * rates[ROOT_DOFS + index];
            let lever_m = link.origin_m - from_m;
            let carried = parent.linear_m_s2
                + parent.angular_rad_s2.cross(&lever_m)
                + w.cross(&w.cross(&lever_m));
            let mut moving = Moving {
                angular_rad_s: w,
                angular_rad_s2: parent.angular_rad_s2,
                linear_m_s2: carried,
                ..still
            };
            match joint.motion {
                Motion::Turns => {
                    moving.angular_rad_s += by_joint;
                    moving.angular_rad_s2 += w.cross(&by_joint);
                }
                Motion::Slides => moving.linear_m_s2 += 2.0 * w.cross(&by_joint),
            }
            let (force_n, torque_n_m) = link.needs(&moving, gravity);
            moving.force_n = force_n;
            moving.torque_n_m = torque_n_m - loads.torques_on_links_n_m[index];
            self.moving[index] = moving;
        }
        let (mut force_n, mut torque_n_m) = self.root.needs(&still, gravity);
        force_n -= loads.force_on_root_n;
        torque_n_m -= loads.torque_on_root_n_m;
        for (index, joint) in tree.joints().iter().enumerate().rev() {
            let Moving {
                force_n: force,
                torque_n_m: torque,
                ..
            } = self.moving[index];
            let screw = &self.links[index].screw;
            forces[ROOT_DOFS + index] =
                loads.in_joints[index] - screw.dot(&joined(&force, &torque));
            match joint.parent {
                Some(parent) => {
                    self.moving[parent].force_n += force;
                    self.moving[parent].torque_n_m += torque;
                }
                None => {
                    force_n += force;
                    torque_n_m += torque;
                }
            }
        }
        for axis in 0..3 {
            forces[axis] = -force_n[axis];
            forces[3 + axis] = -torque_n_m[axis];
        }
        if let Some(attached) = &mut self.attached {
            let asks = attached.asks_of_turning(&still.angular_rad_s);
            for (force, asked) in forces.iter_mut().zip(&asks) {
                *force -= asked;
            }
        }
    }
}

fn joined(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

fn halves(of: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (
        Vector3::new(of[0], of[1], of[2]),
        Vector3::new(of[3], of[4], of[5]),
    )
}
