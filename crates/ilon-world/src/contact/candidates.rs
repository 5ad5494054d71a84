//! Where the robot is near the ground: the places that may touch in the step.

use nalgebra::Vector3;
use rapier3d::prelude::*;

use crate::RollerBodies;
use crate::contact::nearest::{Nearest, Piece, PlacedBarrel, keep_nearest_of_surface};
use crate::contact::reaction::Part;
use crate::contact::solve::Scene;
use crate::engine::convert;
use crate::robot::state::State;
use crate::robot::wheel::RollerState;

/// A hub whose axis leaves a plane by less than this, as the sine of an angle, turns as a round wheel on it.
///
/// Upright, the outline of barrels that hand over is a circle, and only the lowest one touches. Leaning, the next one comes
/// down with a slope that grows with the lean: within this angle by less than 3 um in a step of 0.02 rad of the wheel.
const UPRIGHT: f64 = 0.01;

/// A place where a part of the robot is near the ground.
///
/// Everything is in the floor's frame; the poses are those in the middle of the step where nothing else is said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub part: Part,
    /// On the ground, in metres.
    pub place_m: Vector3<f64>,
    /// Unit vector out of the ground.
    pub normal: Vector3<f64>,
    /// Along the roller's axis, or any direction.
    pub along: Vector3<f64>,
    /// Distance in metres, negative in penetration.
    pub gap_m: f64,
    /// By how much the velocity of the robot's surface where it touches changes in half a step because the robot turns on,
    /// with the rates as they were when the step began, in m/s.
    pub turns_m_s: Vector3<f64>,
    /// Whether it is on a roller that the ground did not press on in the last step.
    pub came_down: bool,
    /// Whether it is on an exact barrel.
    on_barrel: bool,
}

/// Room for what is looked through on the way.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    pieces: Vec<Piece>,
    nearest: Vec<(usize, Nearest)>,
}

impl Scene<'_> {
    /// Fills `found` with the places of the chassis that are near the ground.
    pub fn find_chassis(&self, found: &mut Vec<Candidate>) {
        found.clear();
        let body = &self.rapier.bodies[self.assembly.chassis];
        for collider in body.colliders() {
            self.find_in_rapier(*collider, |place_m, normal, gap_m| {
                let lever_m = place_m - self.middle.center_m();
                let velocity = |state: &State| {
                    let turned = state.floor_from_chassis().rotation
                        * self.middle.floor_from_chassis().rotation.inverse();
                    self.before.angular_rad_s.cross(&(turned * lever_m))
                };
                found.push(Candidate {
                    part: Part::Chassis,
                    place_m,
                    normal,
                    along: Vector3::x(),
                    gap_m,
                    turns_m_s: 0.5 * (velocity(self.ahead) - velocity(self.before)),
                    came_down: false,
                    on_barrel: false,
                });
            });
        }
    }

    /// Fills `found` with the places of a wheel's rollers that are near the ground.
    pub fn find_wheel(&self, wheel: usize, room: &mut Workspace, found: &mut Vec<Candidate>) {
        found.clear();
        self.find_barrels(wheel, room, found);
        self.find_modelled(wheel, found);
    }

    /// How far from the ground a wheel's surface can be and still reach it in the step, in metres.
    fn prediction_m(&self, wheel: usize) -> f64 {
        let hub_m = self.before.hubs()[wheel].center_m;
        let speed_m_s = self.before.chassis_velocity_m_s(&hub_m).norm()
            + self.before.hub_rate(wheel).norm() * self.assembly.wheels[wheel].reach_m;
        self.settings.prediction_m + self.dt_s * speed_m_s
    }

    fn find_barrels(&self, wheel: usize, room: &mut Workspace, found: &mut Vec<Candidate>) {
        let body = &self.assembly.wheels[wheel];
        let hub = &self.middle.hubs()[wheel];
        let prediction_m = self.prediction_m(wheel);
        let reach_m = body.reach_m + prediction_m;
        self.ground
            .pieces_near(&hub.center_m, reach_m, &mut room.pieces);
        let on_plane = matches!(room.pieces[..], [Piece::Plane]);
        let upright = on_plane && hub.axis().z.abs() < UPRIGHT;
        // On a plane an upright wheel touches where it is lowest, and nowhere else.
        let mut lowest_m = f64::INFINITY;
        for (index, roller) in body.rollers.iter().enumerate() {
            let Some(barrel) = &roller.barrel else {
                continue;
            };
            let center_m = roller.center_m(hub);
            let within_m = roller.bounding_radius_m + prediction_m.min(lowest_m);
            let out_of_reach = |piece: &Piece| piece.foot(&center_m).distance_m > within_m;
            if self.settings.roller_bodies == RollerBodies::Near
                && room.pieces.iter().all(out_of_reach)
            {
                continue;
            }
            let placed = PlacedBarrel {
                barrel,
                center_m,
                axis: hub.rotation * roller.axis_in_hub,
            };
            room.nearest.clear();
            for (number, piece) in room.pieces.iter().enumerate() {
                let nearest = placed.nearest_to(piece);
                if nearest.gap_m < prediction_m {
                    room.nearest.push((number, nearest));
                }
            }
            keep_nearest_of_surface(&mut room.nearest, &room.pieces);
            for (_, nearest) in &room.nearest {
                if upright && nearest.gap_m >= lowest_m {
                    continue;
                }
                if upright {
                    lowest_m = nearest.gap_m;
                    found.clear();
                }
                let part = Part::Roller(wheel, index);
                found.push(self.on_barrel((part, roller), &placed, nearest));
            }
        }
        if !upright && found.len() > 1 {
            let axis = hub.axis();
            leave_out_handed_over(found, &axis);
        }
    }

    /// The place of a roller where it is nearest to the ground, with what it was when the step began.
    fn on_barrel(
        &self,
        (part, roller): (Part, &RollerState),
        placed: &PlacedBarrel<'_>,
        nearest: &Nearest,
    ) -> Candidate {
        let Part::Roller(wheel, _) = part else {
            unreachable!("a barrel is a roller's");
        };
        let velocity = |state: &State| {
            let hub = &state.hubs()[wheel];
            let then = PlacedBarrel {
                barrel: placed.barrel,
                center_m: roller.center_m(hub),
                axis: hub.rotation * roller.axis_in_hub,
            };
            self.roller_velocity_m_s((wheel, roller), state, &then.support_m(&nearest.normal))
        };
        Candidate {
            part,
            place_m: nearest.place_m,
            normal: nearest.normal,
            along: placed.axis,
            gap_m: nearest.gap_m,
            turns_m_s: 0.5 * (velocity(self.ahead) - velocity(self.before)),
            came_down: !roller.pressed && !roller.seized,
            on_barrel: true,
        }
    }

    /// Velocity of a place of a roller's surface with the roller in the pose that it has in a state, and with the rates as
    /// they were when the step began, in m/s.
    fn roller_velocity_m_s(
        &self,
        (wheel, roller): (usize, &RollerState),
        state: &State,
        place_m: &Vector3<f64>,
    ) -> Vector3<f64> {
        let hub = &state.hubs()[wheel];
        let axis = hub.rotation * roller.axis_in_hub;
        let spin_rad_s = roller.spin_rad_s(&state.hub_rate_in_hub(wheel));
        state.hub_velocity_m_s(wheel, place_m)
            + spin_rad_s * axis.cross(&(place_m - roller.center_m(hub)))
    }

    /// The places of rollers with the shapes of their file, as rapier finds them.
    fn find_modelled(&self, wheel: usize, found: &mut Vec<Candidate>) {
        let body = &self.assembly.wheels[wheel];
        let hub = &self.middle.hubs()[wheel];
        for part in &body.colliders {
            let roller = &body.rollers[part.roller];
            let along = hub.rotation * roller.axis_in_hub;
            self.find_in_rapier(part.collider, |place_m, normal, gap_m| {
                let in_hub_m = hub.rotation.tr_mul(&(place_m - hub.center_m));
                let velocity = |state: &State| {
                    let place_m = state.hubs()[wheel].place_m(&in_hub_m);
                    self.roller_velocity_m_s((wheel, roller), state, &place_m)
                };
                found.push(Candidate {
                    part: Part::Roller(wheel, part.roller),
                    place_m,
                    normal,
                    along,
                    gap_m,
                    turns_m_s: 0.5 * (velocity(self.ahead) - velocity(self.before)),
                    came_down: !roller.pressed && !roller.seized,
                    on_barrel: false,
                });
            });
        }
    }

    /// Shows where rapier found a collider near the ground: place on the ground, normal out of it, and distance.
    fn find_in_rapier(
        &self,
        collider: ColliderHandle,
        mut show: impl FnMut(Vector3<f64>, Vector3<f64>, f64),
    ) {
        for pair in self.rapier.narrow_phase.contact_pairs_with(collider) {
            let is_first = pair.collider1 == collider;
            let ground = if is_first {
                pair.collider2
            } else {
                pair.collider1
            };
            let rapier_from_ground = self.rapier.colliders[ground].position();
            for manifold in pair.manifolds() {
                // A manifold's normal points from its first shape to its second.
                let towards_second = convert::to_f64(manifold.data.normal);
                let normal = if is_first {
                    -towards_second
                } else {
                    towards_second
                };
                for point in &manifold.points {
                    let on_ground = if is_first {
                        point.local_p2
                    } else {
                        point.local_p1
                    };
                    let in_rapier_m = convert::to_f64(*rapier_from_ground * on_ground);
                    let place_m = self.ground.rapier_origin_m() + in_rapier_m;
                    show(place_m, normal, f64::from(point.dist));
                }
            }
        }
    }
}

/// Leaves out the rollers of a wheel that have handed it over to another, which stands on the same plane and is nearer
/// to it.
///
/// Barrels that follow each other without a gap make an upright wheel round, and rigid: beyond its end a roller is higher
/// than the next one and carries nothing. But in the step of the hand-over both are within a micrometre of the ground, and
/// two that stick in one step rub against each other's way. A wheel that leans on the plane has several to stand on.
fn leave_out_handed_over(found: &mut Vec<Candidate>, hub_axis: &Vector3<f64>) {
    /// Far above the rounding of a plane's places, and far below any step in a ground.
    const ONE_PLANE_M: f64 = 1e-5;
    let handed_over = |a: &Candidate, b: &Candidate| {
        let nearer = b.gap_m < a.gap_m || b.gap_m == a.gap_m && b.part < a.part;
        a.part != b.part
            && a.on_barrel
            && b.on_barrel
            && nearer
            && a.normal.dot(hub_axis).abs() < UPRIGHT
            && a.normal.dot(&b.normal) > 1.0 - 1e-6
            && a.normal.dot(&(b.place_m - a.place_m)).abs() < ONE_PLANE_M
    };
    // The nearest of a plane always stays, and leaving one out makes nobody else nearer.
    let mut index = 0;
    while index < found.len() {
        let gone = found.iter().any(|other| handed_over(&found[index], other));
        if gone {
            found.swap_remove(index);
        } else {
            index += 1;
        }
    }
}
