//! The ground: a plane or a rough surface, what stands on it, and how slippery it is where.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2, Vector3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::shape::{HeightField, HeightFieldFlags};
use parry3d::utils::Array2;
use rapier3d::pipeline::{ContactModificationContext, PhysicsHooks};
use rapier3d::prelude::*;

use crate::{WorldError, convert, groups};

/// The ground a robot drives on.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// Coulomb friction coefficient between roller and ground, >= 0.
    pub friction: f64,
    /// Slope: the angle by which the ground falls towards +x, in radians. 0 is level.
    pub slope_rad: f64,
    /// Places where the friction is another, later ones over earlier ones.
    pub patches: Vec<Patch>,
    /// Boxes that stand on the ground: kerbs, thresholds, walls.
    pub boxes: Vec<GroundBox>,
    /// A rough surface in place of the plane.
    pub relief: Option<Relief>,
}

/// A rectangle of ground, along the world's axes, with a friction of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Its middle in the world, in metres.
    pub center_m: Vector2<f64>,
    /// Half of its sides along x and y, in metres.
    pub half_sides_m: Vector2<f64>,
    /// Coulomb friction coefficient there, >= 0.
    pub friction: f64,
}

/// A box in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundBox {
    /// Its middle in the world, in metres.
    pub center_m: Vector3<f64>,
    /// Half of its sides along its own axes, in metres.
    pub half_sides_m: Vector3<f64>,
    /// Its heading in the world, in radians.
    pub heading_rad: f64,
}

/// A rough surface: heights on a square grid around the world's origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// Distance between neighbouring heights, in metres, > 0.
    pub cell_m: f64,
    /// Heights above the plane in metres: row by row from -y to +y, in each row from -x to +x. Square, at least 2 x 2.
    pub heights_m: Vec<Vec<f64>>,
}

impl Default for Floor {
    fn default() -> Self {
        Self {
            friction: 0.6,
            slope_rad: 0.0,
            patches: Vec::new(),
            boxes: Vec::new(),
            relief: None,
        }
    }
}

impl Floor {
    /// The rotation from the floor's frame, whose z axis stands on the plane, to the world.
    pub(crate) fn world_from_floor(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), self.slope_rad)
    }

    /// The highest point of the relief within a circle around a place in the floor's own plane, in metres; 0 on the
    /// plane. A robot that is put down there clears it.
    pub fn highest_m(&self, center_m: Vector2<f64>, radius_m: f64) -> f64 {
        let Some(relief) = &self.relief else {
            return 0.0;
        };
        let half_m = 0.5 * relief.side_m();
        let near = |row: usize, column: usize| {
            let at = Vector2::new(column as f64, row as f64) * relief.cell_m
                - Vector2::new(half_m, half_m);
            (at - center_m).norm() <= radius_m + relief.cell_m
        };
        let heights = relief
            .heights_m
            .iter()
            .enumerate()
            .flat_map(|(row, heights)| {
                heights
                    .iter()
                    .enumerate()
                    .filter(move |(column, _)| near(row, *column))
            });
        let highest = heights.map(|(_, h)| *h).fold(f64::NEG_INFINITY, f64::max);
        if highest.is_finite() { highest } else { 0.0 }
    }

    /// Refuses floors that make no sense.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        let setting = |name, value, range| Err(WorldError::Setting { name, value, range });
        let frictions = self.patches.iter().map(|p| p.friction);
        if let Some(bad) = std::iter::once(self.friction)
            .chain(frictions)
            .find(|f| !(f.is_finite() && *f >= 0.0))
        {
            return setting("friction", bad, "finite and not below 0");
        }
        let upright = std::f64::consts::FRAC_PI_2;
        if !(-upright..=upright).contains(&self.slope_rad) {
            return setting("slope_rad", self.slope_rad, "between -pi/2 and pi/2");
        }
        let sides = self
            .boxes
            .iter()
            .flat_map(|b| b.half_sides_m.iter().copied().collect::<Vec<_>>());
        if let Some(bad) = sides.into_iter().find(|s| !(s.is_finite() && *s > 0.0)) {
            return setting("half_sides_m", bad, "finite and above 0");
        }
        if let Some(relief) = &self.relief {
            if !(relief.cell_m.is_finite() && relief.cell_m > 0.0) {
                return setting("cell_m", relief.cell_m, "finite and above 0");
            }
            let rows = relief.heights_m.len();
            if rows < 2 || relief.heights_m.iter().any(|row| row.len() != rows) {
                return setting(
                    "heights_m",
                    rows as f64,
                    "a square grid of at least 2 x 2 heights",
                );
            }
            let heights = relief.heights_m.iter().flatten();
            if let Some(bad) = heights.copied().find(|h| !h.is_finite()) {
                return setting("heights_m", bad, "finite everywhere");
            }
        }
        Ok(())
    }

    /// Puts the ground into rapier, whose frame is the floor's.
    pub(crate) fn insert(&self, colliders: &mut ColliderSet, dt_s: f64) -> Ground {
        let solids = self.solids();
        let plane = self
            .relief
            .is_none()
            .then(|| SharedShape::halfspace(Vector::Z));
        let mut insert = |shape: &SharedShape, floor_from_shape: &Isometry3<f64>| {
            colliders.insert(
                ColliderBuilder::new(shape.clone())
                    .position(convert::pose(floor_from_shape))
                    .friction(self.friction as Real)
                    .friction_combine_rule(CoefficientCombineRule::Min)
                    .restitution(0.0)
                    .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
                    .collision_groups(groups::GROUND),
            )
        };
        if let Some(plane) = &plane {
            insert(plane, &Isometry3::identity());
        }
        let solids = solids.into_iter().map(|(floor_from_solid, shape)| Solid {
            collider: insert(&shape, &floor_from_solid),
            floor_from_solid,
            shape,
        });
        Ground {
            solids: solids.collect(),
            has_plane: plane.is_some(),
            friction: self.friction,
            patches: self.patches.clone(),
            has_its_own_friction: !self.patches.is_empty(),
            world_from_floor: self.world_from_floor(),
            floor_from_rapier: Isometry3::identity(),
            dt_s: dt_s as Real,
        }
    }

    /// Everything but the plane: where it stands in the floor's frame and its shape.
    fn solids(&self) -> Vec<(Isometry3<f64>, SharedShape)> {
        // parry's height fields rise along y over x and z: a quarter turn about x brings y up to z and -z to y.
        let upright =
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let relief = self.relief.iter().map(|relief| {
            (
                Isometry3::from_parts(Translation3::identity(), upright),
                relief.shape(),
            )
        });
        let floor_from_world = self.world_from_floor().inverse();
        let boxes = self.boxes.iter().map(|solid| {
            let h = solid.half_sides_m;
            let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), solid.heading_rad);
            let world_from_solid = Isometry3::from_parts(solid.center_m.into(), heading);
            let shape = SharedShape::cuboid(h.x as Real, h.y as Real, h.z as Real);
            (floor_from_world * world_from_solid, shape)
        });
        relief.chain(boxes).collect()
    }
}

impl Relief {
    /// Length of the square's side, in metres.
    fn side_m(&self) -> f64 {
        self.cell_m * (self.heights_m.len() - 1) as f64
    }

    fn shape(&self) -> SharedShape {
        let n = self.heights_m.len();
        // parry counts rows along its z, which is our -y.
        let heights = Array2::new(
            n,
            n,
            (0..n * n)
                .map(|i| self.heights_m[n - 1 - i % n][i / n] as Real)
                .collect(),
        );
        let side = self.side_m() as Real;
        SharedShape::new(HeightField::with_flags(
            heights,
            Vector::new(side, 1.0, side),
            HeightFieldFlags::FIX_INTERNAL_EDGES,
        ))
    }
}

/// What a running world needs to know of its ground.
///
/// rapier counts in f32 from an anchor near the robot: contact points a few metres away would be rounded by as much
/// as a roller moves in a step, and a robot at rest would creep. And the anchor turns with the robot: rapier solves
/// friction along two axes that are fixed in its frame, one after the other, and a roller is light across its axis and
/// heavy along it. Where its axis lies between rapier's the two are coupled and converge slowly; along them hardly any
/// sweeps are needed.
pub(crate) struct Ground {
    has_plane: bool,
    friction: f64,
    patches: Vec<Patch>,
    /// Whether the friction is another than the one that rapier knows, somewhere or by now.
    has_its_own_friction: bool,
    solids: Vec<Solid>,
    world_from_floor: UnitQuaternion<f64>,
    /// rapier's frame in the floor's: its origin lies in the plane, its z axis stands on it.
    floor_from_rapier: Isometry3<f64>,
    /// Length of a physics step, in seconds.
    dt_s: Real,
}

/// A part of the ground that is not the plane.
struct Solid {
    collider: ColliderHandle,
    floor_from_solid: Isometry3<f64>,
    shape: SharedShape,
}

impl Ground {
    /// Whether anything but the plane exists at all.
    pub fn is_plain(&self) -> bool {
        self.has_plane && self.solids.is_empty()
    }

    /// Whether anything but the plane reaches into a box in the floor's frame.
    pub fn reaches(&self, in_floor: &Aabb) -> bool {
        self.solids.iter().any(|solid| {
            let local = in_floor.transform_by(&convert::pose(&solid.floor_from_solid.inverse()));
            match solid.shape.as_heightfield() {
                None => solid.shape.compute_local_aabb().intersects(&local),
                Some(field) => {
                    let mut reached = false;
                    field.map_elements_in_local_aabb(&local, &mut |_, triangle| {
                        reached |= triangle.local_aabb().intersects(&local);
                    });
                    reached
                }
            }
        })
    }

    /// Moves rapier's frame beneath a robot once that has gone or turned too far away from it, and the solids along with
    /// it. `heading_rad` is the direction in the floor's frame that shall lie along an axis of rapier's, where there is
    /// any. Gives back the frame as it was, if it moved.
    pub fn follow(
        &mut self,
        place_m: &Vector3<f64>,
        heading_rad: Option<f64>,
        colliders: &mut ColliderSet,
    ) -> Option<Isometry3<f64>> {
        /// Within this distance f32 resolves 1e-8 m, a hundredth of what a slow robot moves in a step.
        const LEASH_M: f64 = 0.1;
        /// Friction's two directions converge about as fast at this angle as along the axes.
        const LEASH_RAD: f64 = 0.02;
        let before = self.floor_from_rapier;
        let beneath_m = Vector3::new(place_m.x, place_m.y, 0.0);
        let turned_rad = before.rotation.euler_angles().2;
        // Any of the four directions along rapier's axes will do.
        let off_rad = heading_rad.map_or(0.0, |heading_rad| {
            let off = heading_rad - turned_rad;
            off - FRAC_PI_2 * (off / FRAC_PI_2).round()
        });
        if (beneath_m - before.translation.vector).norm() < LEASH_M && off_rad.abs() < LEASH_RAD {
            return None;
        }
        self.floor_from_rapier = Isometry3::from_parts(
            beneath_m.into(),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turned_rad + off_rad),
        );
        let rapier_from_floor = self.floor_from_rapier.inverse();
        for solid in &self.solids {
            let in_rapier = rapier_from_floor * solid.floor_from_solid;
            if let Some(collider) = colliders.get_mut(solid.collider) {
                collider.set_position(convert::pose(&in_rapier));
            }
        }
        Some(before)
    }

    /// rapier's frame in the floor's.
    pub fn floor_from_rapier(&self) -> &Isometry3<f64> {
        &self.floor_from_rapier
    }

    /// The rotation from the floor's frame to the world.
    pub fn world_from_floor(&self) -> UnitQuaternion<f64> {
        self.world_from_floor
    }

    /// The acceleration of gravity in the floor's frame, in m/s^2, from its magnitude: on a slope it leans.
    pub fn gravity_in_floor(&self, gravity_m_s2: f64) -> Vector3<f64> {
        self.world_from_floor.inverse() * (Vector3::z() * -gravity_m_s2)
    }

    /// The same in rapier's frame.
    pub fn gravity_in_rapier(&self, gravity_m_s2: f64) -> Vector {
        let rapier_from_floor = self.floor_from_rapier.rotation.inverse();
        convert::vector(&(rapier_from_floor * self.gravity_in_floor(gravity_m_s2)))
    }

    /// Changes the friction from now on.
    pub fn set_friction(&mut self, friction: f64, patches: &[Patch]) {
        self.friction = friction;
        self.patches = patches.to_vec();
        self.has_its_own_friction = true;
    }

    /// The friction at a place of the world.
    fn friction_at(&self, in_world_m: &Vector3<f64>) -> f64 {
        let inside = |p: &&Patch| {
            let off = in_world_m.xy() - p.center_m;
            off.x.abs() <= p.half_sides_m.x && off.y.abs() <= p.half_sides_m.y
        };
        self.patches
            .iter()
            .rev()
            .find(inside)
            .map_or(self.friction, |p| p.friction)
            .max(0.0)
    }
}

/// What rapier lets us say about every contact before it solves them: how slippery the ground is there, and that a
/// rounding of the contact point is no way to make good.
impl PhysicsHooks for Ground {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let ground_first = context.rigid_body1.is_none();
        let (ground, body) = if ground_first {
            (context.collider1, context.rigid_body2)
        } else {
            (context.collider2, context.rigid_body1)
        };
        let (bodies, colliders) = (context.bodies, context.colliders);
        let (Some(ground), Some(body)) = (colliders.get(ground), body.and_then(|b| bodies.get(b)))
        else {
            return;
        };
        let Some(contact) = context.rigid_mut() else {
            return;
        };
        if self.has_its_own_friction
            && let Some(point) = contact.manifold.points.first()
        {
            let local = if ground_first {
                point.local_p1
            } else {
                point.local_p2
            };
            let in_rapier_m = convert::to_f64(ground.position() * local);
            let in_floor_m = self.floor_from_rapier * nalgebra::Point3::from(in_rapier_m);
            let in_world_m = self.world_from_floor * in_floor_m.coords;
            *contact.friction = self.friction_at(&in_world_m) as Real;
        }
        let normal = *contact.normal;
        for point in contact.solver_contacts.iter_mut() {
            let shift = (point.anchor2 - point.anchor1).dot(normal) - point.dist;
            let middle = (point.anchor1 + normal * shift + point.anchor2) * 0.5;
            let rounding = rounding_of(middle, body);
            let between = if ground_first { -rounding } else { rounding };
            point.tangent_velocity -= between / self.dt_s;
        }
    }
}

/// By how much rapier's friction misplaces a contact point on a body, in metres.
///
/// The solver keeps the point in the body's frame and takes it back to the world, in f32, and asks friction to close the
/// gap to the other body's point within the step. The gap is some 1e-8 m of rounding, and a robot at rest would creep by
/// that in every step. This repeats rapier's own operations to the letter, so that it can be taken off.
fn rounding_of(point: Vector, body: &RigidBody) -> Vector {
    let center = body.center_of_mass();
    let kept = center + (point - center);
    let pose = body.position();
    pose * pose.inverse_transform_point(kept) - point
}
