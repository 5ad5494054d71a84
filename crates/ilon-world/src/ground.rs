//! The ground: a plane or a rough surface, what stands on it, and how slippery it is where.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use parry3d::bounding_volume::Aabb;
use parry3d::shape::{HeightField, HeightFieldFlags};
use parry3d::utils::Array2;
use rapier3d::pipeline::{ContactModificationContext, PhysicsHooks};
use rapier3d::prelude::*;

use crate::contact::nearest::{Piece, SolidBox, Triangle};
use crate::engine::{convert, groups};
use crate::{ContactSolver, WorldError};

/// The ground a robot drives on.
///
/// It is the frame of the world: the origin lies in its plane, and z is its normal. On a slope gravity leans.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// Coulomb friction coefficient between roller and ground, >= 0.
    pub friction: f64,
    /// Slope: the angle by which the ground falls towards +x, in radians. 0 is level. All places, boxes and their heights count
    /// in the sloping plane, and along its normal.
    pub slope_rad: f64,
    /// Places where the friction is another, later ones over earlier ones.
    pub patches: Vec<Patch>,
    /// Boxes that stand on the ground: kerbs, thresholds, walls.
    pub boxes: Vec<GroundBox>,
    /// A rough surface in place of the plane.
    pub relief: Option<Relief>,
    /// What it is made of, where there is no patch.
    pub surface: FloorSurface,
}

/// What ground is made of, beside its friction. The default is hard ground under Coulomb's law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FloorSurface {
    /// Rolling resistance: energy that each metre takes by which a place of contact moves over the ground, per newton of load;
    /// dimensionless, >= 0. It adds to that of the rollers.
    pub rolling_resistance: f64,
    /// Creep: the way by which a roller slips per way that its place of contact moves, per pull over load; dimensionless,
    /// >= 0. Force against slip is then a line up to the grip.
    pub creep: f64,
    /// How friction falls as a roller slides; `None` where it does not.
    pub sliding: Option<Stribeck>,
}

/// Friction that falls with the speed v of sliding, from the floor's mu at rest: mu' + (mu - mu') exp(-(v / speed)^2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// mu', the coefficient at speed, >= 0.
    pub friction: f64,
    /// The speed over which it falls, in m/s, > 0.
    pub speed_m_s: f64,
}

impl FloorSurface {
    /// The friction coefficient of a roller that slides at a speed in m/s, from that at rest.
    pub(crate) fn friction_at_speed(&self, at_rest: f64, sliding_m_s: f64) -> f64 {
        match &self.sliding {
            None => at_rest,
            Some(stribeck) => {
                let share = libm::exp(-(sliding_m_s / stribeck.speed_m_s).powi(2));
                stribeck.friction + (at_rest - stribeck.friction) * share
            }
        }
    }

    /// Refuses what makes no sense.
    fn check(&self) -> Result<(), WorldError> {
        let mut numbers = vec![
            ("rolling_resistance", self.rolling_resistance),
            ("creep", self.creep),
        ];
        if let Some(sliding) = &self.sliding {
            numbers.push(("sliding.friction", sliding.friction));
            if !(sliding.speed_m_s.is_finite() && sliding.speed_m_s > 0.0) {
                return Err(WorldError::Setting {
                    name: "sliding.speed_m_s",
                    value: sliding.speed_m_s,
                    range: "finite and above 0",
                });
            }
        }
        let bad = |(_, value): &(&str, f64)| !(value.is_finite() && *value >= 0.0);
        match numbers.into_iter().find(bad) {
            None => Ok(()),
            Some((name, value)) => Err(WorldError::Setting {
                name,
                value,
                range: "finite and not below 0",
            }),
        }
    }
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
    /// What it is made of.
    pub surface: FloorSurface,
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
            surface: FloorSurface::default(),
        }
    }
}

impl Floor {
    /// The direction of gravity in the floor's frame, whose z is the floor's normal.
    fn down(&self) -> Vector3<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -self.slope_rad) * -Vector3::z()
    }

    /// The highest point of relief and boxes within a circle around a place in the floor's own plane, in metres; 0 where there
    /// are none.
    pub(crate) fn highest_m(&self, center_m: Vector2<f64>, radius_m: f64) -> f64 {
        let on_boxes = self.boxes.iter().filter_map(|solid| {
            let within_m = radius_m + solid.half_sides_m.norm();
            let top_m = solid.center_m.z + solid.half_sides_m.z;
            ((solid.center_m.xy() - center_m).norm() <= within_m).then_some(top_m)
        });
        let on_relief = self
            .relief
            .iter()
            .filter_map(|relief| relief.highest_m(center_m, radius_m));
        let ground_m = if self.relief.is_some() {
            f64::NEG_INFINITY
        } else {
            0.0
        };
        let highest_m = on_boxes.chain(on_relief).fold(ground_m, f64::max);
        if highest_m.is_finite() {
            highest_m
        } else {
            0.0
        }
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
        let patches = self.patches.iter().map(|patch| &patch.surface);
        patches
            .chain([&self.surface])
            .try_for_each(FloorSurface::check)?;
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
    pub(crate) fn insert(&self, colliders: &mut ColliderSet, solver: ContactSolver) -> Ground {
        let solids = self.solids();
        let plane = self
            .relief
            .is_none()
            .then(|| SharedShape::halfspace(Vector::Z));
        let mut insert = |shape: &SharedShape, floor_from_shape: &Isometry3<f64>| {
            colliders.insert(
                ColliderBuilder::new(shape.clone())
                    .position(convert::pose(floor_from_shape))
                    .collision_groups(groups::GROUND)
                    .solver_groups(groups::solved(solver)),
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
        let solids: Vec<Solid> = solids.collect();
        let boxes = self.boxes.iter().map(|solid| SolidBox {
            floor_from_box: solid.floor_from_box(),
            half_sides_m: solid.half_sides_m,
        });
        Ground {
            boxes: boxes.collect(),
            solids,
            has_plane: plane.is_some(),
            friction: self.friction,
            surface: self.surface,
            patches: self.patches.clone(),
            down: self.down(),
            rapier_origin_m: Vector3::zeros(),
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
        let boxes = self.boxes.iter().map(|solid| {
            let h = solid.half_sides_m;
            let shape = SharedShape::cuboid(h.x as Real, h.y as Real, h.z as Real);
            (solid.floor_from_box(), shape)
        });
        relief.chain(boxes).collect()
    }
}

impl GroundBox {
    fn floor_from_box(&self) -> Isometry3<f64> {
        let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.heading_rad);
        Isometry3::from_parts(self.center_m.into(), heading)
    }
}

impl Relief {
    /// Length of the square's side, in metres.
    fn side_m(&self) -> f64 {
        self.cell_m * (self.heights_m.len() - 1) as f64
    }

    /// The highest point within a circle around a place, in metres; `None` where the circle misses the relief.
    fn highest_m(&self, center_m: Vector2<f64>, radius_m: f64) -> Option<f64> {
        let half_m = 0.5 * self.side_m();
        let is_near = |row: usize, column: usize| {
            let at = Vector2::new(column as f64, row as f64) * self.cell_m
                - Vector2::new(half_m, half_m);
            (at - center_m).norm() <= radius_m + self.cell_m
        };
        let rows = self.heights_m.iter().enumerate();
        let heights = rows.flat_map(|(row, heights)| {
            let cells = heights.iter().enumerate();
            cells.filter(move |(column, _)| is_near(row, *column))
        });
        heights.map(|(_, height_m)| *height_m).reduce(f64::max)
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
/// rapier's frame is the floor's, but it counts in f32 from an anchor near the robot: contact points a few metres away
/// would be rounded by as much as a roller moves in a step.
#[derive(Clone)]
pub(crate) struct Ground {
    has_plane: bool,
    friction: f64,
    surface: FloorSurface,
    patches: Vec<Patch>,
    solids: Vec<Solid>,
    /// The boxes among them.
    boxes: Vec<SolidBox>,
    /// The direction of gravity.
    down: Vector3<f64>,
    /// rapier's origin in the floor's frame, in the plane.
    rapier_origin_m: Vector3<f64>,
}

/// A part of the ground that is not the plane.
#[derive(Clone)]
struct Solid {
    collider: ColliderHandle,
    floor_from_solid: Isometry3<f64>,
    shape: SharedShape,
}

impl Ground {
    /// Fills `pieces` with those of the ground that may be nearer to a place than `within_m`.
    pub fn pieces_near(&self, place_m: &Vector3<f64>, within_m: f64, pieces: &mut Vec<Piece>) {
        pieces.clear();
        let mut offer = |piece: Piece| {
            if piece.foot(place_m).distance_m < within_m {
                pieces.push(piece);
            }
        };
        if self.has_plane {
            offer(Piece::Plane);
        }
        self.boxes
            .iter()
            .for_each(|solid| offer(Piece::Box(*solid)));
        for solid in &self.solids {
            let Some(field) = solid.shape.as_heightfield() else {
                continue;
            };
            let center = solid.floor_from_solid.inverse() * Point3::from(*place_m);
            let half = Vector3::repeat(within_m);
            let around = Aabb::new(
                convert::vector(&(center.coords - half)),
                convert::vector(&(center.coords + half)),
            );
            field.map_elements_in_local_aabb(&around, &mut |_, triangle| {
                let corner = |corner: Vector| {
                    (solid.floor_from_solid * Point3::from(convert::to_f64(corner))).coords
                };
                let corners_m = [triangle.a, triangle.b, triangle.c].map(corner);
                if let Some(triangle) = Triangle::new(corners_m, &Vector3::z()) {
                    offer(Piece::Triangle(triangle));
                }
            });
        }
    }

    /// Whether everything below a point of the ground is ground too, as below a plane and the boxes on it; below a relief nothing is.
    pub fn is_solid_below(&self) -> bool {
        self.has_plane
    }

    /// Whether there is more than a plane.
    pub fn has_solids(&self) -> bool {
        !self.solids.is_empty()
    }

    /// How far a shape of the robot is from the ground, in metres; not above 0 where they touch, and f64's infinity where
    /// parry cannot tell.
    pub fn distance_m(&self, floor_from_shape: &Isometry3<f64>, shape: &SharedShape) -> f64 {
        let in_rapier = convert::pose(&(self.rapier_from_floor() * floor_from_shape));
        let plane = self.has_plane.then(|| SharedShape::halfspace(Vector::Z));
        let plane = plane.iter().map(|plane| (Pose::IDENTITY, plane));
        let solids = self.solids.iter().map(|solid| {
            let pose = convert::pose(&(self.rapier_from_floor() * solid.floor_from_solid));
            (pose, &solid.shape)
        });
        let distances = plane.chain(solids).map(|(pose, ground)| {
            parry3d::query::distance(&pose, &**ground, &in_rapier, &**shape)
                .map_or(f64::INFINITY, |found| f64::from(found.distance))
        });
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Moves rapier's origin beneath a robot once that has gone too far away from it, and the solids along with it.
    pub fn follow(&mut self, place_m: &Vector3<f64>, colliders: &mut ColliderSet) {
        /// Within this distance f32 resolves 1e-8 m, a hundredth of what a slow robot moves in a step.
        const LEASH_M: f64 = 0.1;
        let beneath_m = Vector3::new(place_m.x, place_m.y, 0.0);
        if (beneath_m - self.rapier_origin_m).norm() < LEASH_M {
            return;
        }
        self.rapier_origin_m = beneath_m;
        for solid in &self.solids {
            let in_rapier = Translation3::from(-beneath_m) * solid.floor_from_solid;
            if let Some(collider) = colliders.get_mut(solid.collider) {
                collider.set_position(convert::pose(&in_rapier));
            }
        }
    }

    /// rapier's origin in the floor's frame, in metres; the axes are the same.
    pub fn rapier_origin_m(&self) -> Vector3<f64> {
        self.rapier_origin_m
    }

    /// What takes places in the floor's frame to rapier's.
    pub fn rapier_from_floor(&self) -> Translation3<f64> {
        Translation3::from(-self.rapier_origin_m)
    }

    /// The acceleration of gravity in the floor's frame, in m/s^2, from its magnitude: on a slope it leans.
    pub fn gravity_in_floor(&self, gravity_m_s2: f64) -> Vector3<f64> {
        self.down * gravity_m_s2
    }

    /// Changes the friction from now on.
    pub fn set_friction(&mut self, friction: f64, patches: &[Patch]) {
        self.friction = friction;
        self.patches = patches.to_vec();
    }

    /// The friction coefficient at a place in the floor's frame.
    pub fn friction_at(&self, in_floor_m: &Vector3<f64>) -> f64 {
        let patch = self.patch_at(in_floor_m);
        patch.map_or(self.friction, |p| p.friction).max(0.0)
    }

    /// What the ground is made of at a place in the floor's frame.
    pub fn surface_at(&self, in_floor_m: &Vector3<f64>) -> FloorSurface {
        self.patch_at(in_floor_m)
            .map_or(self.surface, |p| p.surface)
    }

    /// The patch that a place in the floor's frame lies on, of several the last.
    fn patch_at(&self, in_floor_m: &Vector3<f64>) -> Option<&Patch> {
        let inside = |p: &&Patch| {
            let off = in_floor_m.xy() - p.center_m;
            off.x.abs() <= p.half_sides_m.x && off.y.abs() <= p.half_sides_m.y
        };
        self.patches.iter().rev().find(inside)
    }
}

/// What rapier asks where it solves contacts itself: how slippery the ground is where something touches it.
impl PhysicsHooks for Ground {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let ground_first = context.rigid_body1.is_none();
        let ground = if ground_first {
            context.collider1
        } else {
            context.collider2
        };
        let Some(ground) = context.colliders.get(ground) else {
            return;
        };
        let rapier_from_ground = *ground.position();
        let Some(contact) = context.rigid_mut() else {
            return;
        };
        if let Some(point) = contact.manifold.points.first() {
            let on_ground = if ground_first {
                point.local_p1
            } else {
                point.local_p2
            };
            let in_rapier_m = convert::to_f64(rapier_from_ground * on_ground);
            *contact.friction = self.friction_at(&(self.rapier_origin_m + in_rapier_m)) as Real;
        }
    }
}
