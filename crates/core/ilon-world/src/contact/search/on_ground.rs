//! Finds places where a robot is near the ground and may touch it in the step.

use nalgebra::{Point3, Vector3};

use crate::RollerBodies;
use crate::contact::frame::{along_frame, frame};
use crate::contact::reactions::reaction::{Member, Part, Partner};
use crate::contact::scene::Scene;
use crate::contact::search::bounds::Bounds;
use crate::contact::search::candidate::{Candidate, Turning, UPRIGHT};
use crate::contact::search::handover::{leave_out_handed_over, leave_out_higher};
use crate::contact::search::nearest::{Nearest, Piece, PlacedBarrel, keep_nearest_of_surface};
use crate::contact::search::solid::Near;
use crate::contact::search::turned_profile::PlacedProfile;
use crate::ground::HeightField;
use crate::robot::roller::RollerState;
use crate::robot::state::State;
use crate::settings::NEAR;

/// The contact of a roller with the ground in some pose.
struct Touch {
    /// The roller's middle and its axis.
    center_m: Vector3<f64>,
    axis: Vector3<f64>,
    place_m: Vector3<f64>,
    /// Whether that is on one of its end spheres.
    on_its_end: bool,
    /// The ground's normal and two tangents.
    axes: [Vector3<f64>; 3],
}

impl Touch {
    /// Derivative of the point's velocity by the roller's spin, in m.
    fn per_spin_m(&self) -> Vector3<f64> {
        self.axis.cross(&(self.place_m - self.center_m))
    }
}

/// Work space.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    pieces: Vec<Piece>,
    nearest: Vec<(usize, Nearest)>,
}

/// The ground around a wheel's rollers.
#[derive(Clone, Copy)]
struct Around<'a> {
    /// Uneven ground besides the listed pieces, and an upper bound of its height there, in metres.
    relief: Option<(&'a HeightField, f64)>,
    /// Everything further away is ignored, in metres.
    within_m: f64,
}

impl Around<'_> {
    /// Whether the whole uneven ground is further from a point than this, by its height alone.
    fn is_above_relief(&self, place_m: &Vector3<f64>, within_m: f64) -> bool {
        let below = |(_, ceiling_m)| place_m.z - within_m > ceiling_m;
        self.relief.is_none_or(below)
    }

    /// Searches the triangles of uneven ground near a box, and appends those with a result to the
    /// pieces: `find` gets a triangle with its index among the pieces, and returns whether it has
    /// one.
    fn find_on_relief(
        &self,
        bounds: impl FnOnce() -> Bounds,
        pieces: &mut Vec<Piece>,
        mut find: impl FnMut(usize, &Piece) -> bool,
    ) {
        if let Some((relief, _)) = self.relief {
            relief.triangles_in(&bounds(), |triangle| {
                let piece = Piece::Triangle(triangle);
                if find(pieces.len(), &piece) {
                    pieces.push(piece);
                }
            });
        }
    }
}

impl Scene<'_> {
    /// A part of the body.
    pub fn member(&self, part: Part) -> Member {
        Member {
            body: self.index,
            part,
        }
    }

    /// Change of the velocity of a point of a joint's link, or of the chassis, over the step by its
    /// rotation, in m/s. Its state is that of the step's middle.
    pub(super) fn gained_by_turning_m_s(
        &self,
        joint: Option<usize>,
        place_m: &Vector3<f64>,
    ) -> Vector3<f64> {
        let center_m = self.body.chassis_mass.center_of_mass_m;
        let Some(joint) = joint else {
            let lever_m = place_m - self.step.middle.center_m();
            let of = |state: &State| {
                let turned = state.floor_from_chassis().rotation
                    * self.step.middle.floor_from_chassis().rotation.inverse();
                self.step.before.angular_rad_s.cross(&(turned * lever_m))
            };
            return of(&self.step.ahead) - of(&self.step.before);
        };
        let pose = |state: &State| state.carrier(Some(joint), &center_m);
        let in_link = pose(&self.step.middle).inverse_transform_point(&Point3::from(*place_m));
        let of = |state: &State| state.link_velocity_m_s(joint, &(pose(state) * in_link).coords);
        of(&self.step.ahead) - of(&self.step.before)
    }

    /// Fills `found` with the places of a wheel's rollers near the ground.
    pub fn find_wheel(&self, wheel: usize, room: &mut Workspace, found: &mut Vec<Candidate>) {
        found.clear();
        self.find_barrels(wheel, room, found);
        self.find_modelled(wheel, found);
    }

    /// The distance from the ground within which a wheel's surface can reach it in the step, in
    /// metres.
    pub(super) fn prediction_m(&self, wheel: usize) -> f64 {
        let speed_m_s = self.step.before.hub_center_velocity_m_s(wheel).norm()
            + self.step.before.hub_rate(wheel).norm() * self.wheels[wheel].reach_m;
        NEAR * self.scale.length_m + self.dt_s * speed_m_s
    }

    /// The distance by which a point of a wheel's rollers may come down in the second half of the
    /// step, in metres.
    fn comes_down_m(&self, wheel: usize) -> f64 {
        /// Addition to the motion of the step, in wheel radii. Chosen.
        const MARGIN: f64 = 2e-4;
        let falls_m_s = self.step.before.hub_center_velocity_m_s(wheel).norm()
            + self.settings.gravity_m_s2 * self.dt_s
            + self.step.before.hub_rate(wheel).norm() * self.wheels[wheel].reach_m;
        MARGIN * self.scale.length_m + 0.5 * self.dt_s * falls_m_s
    }

    fn find_barrels(&self, wheel: usize, room: &mut Workspace, found: &mut Vec<Candidate>) {
        let body = &self.wheels[wheel];
        let hub = &self.step.middle.hubs()[wheel];
        let prediction_m = self.prediction_m(wheel);
        let reach_m = body.reach_m + prediction_m;
        self.ground
            .solids_near(&hub.center_m, reach_m, &mut room.pieces);
        let around = Bounds::of_ball(&hub.center_m, reach_m);
        let relief = self.ground.relief();
        let around = Around {
            relief: relief
                .filter(|relief| relief.reaches(&around))
                .map(|relief| (relief, relief.ceiling_m(&around))),
            within_m: prediction_m,
        };
        self.find_on_pieces(wheel, (around, room), found);
    }

    /// Fills `found` with the places of a wheel's rollers that are nearer than this to a free body,
    /// which is treated as ground.
    pub(super) fn find_on_piece(
        &self,
        wheel: usize,
        (piece, within_m): (Piece, f64),
        room: &mut Workspace,
        found: &mut Vec<Candidate>,
    ) {
        room.pieces.clear();
        room.pieces.push(piece);
        let around = Around {
            relief: None,
            within_m,
        };
        self.find_on_pieces(wheel, (around, room), found);
    }

    /// The same for the listed pieces.
    fn find_on_pieces(
        &self,
        wheel: usize,
        (around, room): (Around<'_>, &mut Workspace),
        found: &mut Vec<Candidate>,
    ) {
        let prediction_m = around.within_m;
        let others = room.pieces.len();
        let body = &self.wheels[wheel];
        let hub = &self.step.middle.hubs()[wheel];
        let on_plane = around.relief.is_none() && matches!(room.pieces[..], [Piece::Plane]);
        let is_compliant = body.is_compliant();
        let is_upright = hub.axis().z.abs() < UPRIGHT;
        let is_rigid_ring = body.is_round && !is_compliant;
        let touches_lowest = on_plane && is_upright && is_rigid_ring;
        // A soft roller carries with what reaches into the ground; nothing else needs to be
        // considered.
        let within_gap_m = if is_compliant {
            self.comes_down_m(wheel)
        } else {
            prediction_m
        };
        // On a plane an upright wheel touches only where it is lowest.
        let mut lowest: Option<(usize, Nearest)> = None;
        let only_near = self.settings.roller_bodies == RollerBodies::Near;
        for (index, roller) in body.rollers.iter().enumerate() {
            let lowest_m = lowest.map_or(f64::INFINITY, |(_, nearest)| nearest.gap_m);
            let within_m = roller.bounding_radius_m + prediction_m.min(lowest_m);
            // For most rollers nothing else is evaluated.
            if on_plane && only_near && roller.height_m(hub) > within_m {
                continue;
            }
            let Some(placed) = roller.placed_barrel(hub) else {
                continue;
            };
            let out_of_reach = |piece: &Piece| piece.foot(&placed.center_m).distance_m > within_m;
            if only_near
                && around.is_above_relief(&placed.center_m, within_m)
                && room.pieces.iter().all(out_of_reach)
            {
                continue;
            }
            if touches_lowest {
                let nearest = placed.nearest_to(&Piece::Plane);
                if nearest.gap_m < prediction_m.min(lowest_m) {
                    lowest = Some((index, nearest));
                }
                continue;
            }
            room.nearest.clear();
            room.pieces.truncate(others);
            let reach_m = roller.bounding_radius_m + within_gap_m;
            for (number, piece) in room.pieces.iter().enumerate() {
                if piece.foot(&placed.center_m).distance_m > reach_m {
                    continue;
                }
                if let Some(nearest) = placed.nearest_within(piece, within_gap_m) {
                    room.nearest.push((number, nearest));
                }
            }
            let bounds = || placed.bounds().grown(within_gap_m);
            around.find_on_relief(bounds, &mut room.pieces, |number, piece| {
                let nearest = placed.nearest_within(piece, within_gap_m);
                room.nearest
                    .extend(nearest.map(|nearest| (number, nearest)));
                nearest.is_some()
            });
            keep_nearest_of_surface(&mut room.nearest, &room.pieces);
            for (_, nearest) in &room.nearest {
                found.push(self.on_barrel((wheel, index), &placed, nearest));
            }
        }
        if !body.is_round {
            self.find_profiles(wheel, (around, others), room, found);
            if !is_compliant && found.len() > 1 {
                leave_out_higher(found, hub, (&body.rollers, self.scale));
            }
        }
        if let Some((index, nearest)) = lowest
            && let Some(placed) = body.rollers[index].placed_barrel(hub)
        {
            found.push(self.on_barrel((wheel, index), &placed, &nearest));
        }
        if !touches_lowest && is_rigid_ring && found.len() > 1 {
            let axis = hub.axis();
            leave_out_handed_over(found, &axis, self.scale);
        }
    }

    /// The places where the rollers of a wheel with a profile by numbers are near the ground.
    fn find_profiles(
        &self,
        wheel: usize,
        (around, others): (Around<'_>, usize),
        room: &mut Workspace,
        found: &mut Vec<Candidate>,
    ) {
        let prediction_m = around.within_m;
        let hub = &self.step.middle.hubs()[wheel];
        for (index, roller) in self.wheels[wheel].rollers.iter().enumerate() {
            let Some(placed) = roller.placed_profile(hub) else {
                continue;
            };
            let within_m = roller.bounding_radius_m + prediction_m;
            room.nearest.clear();
            room.pieces.truncate(others);
            for (number, piece) in room.pieces.iter().enumerate() {
                if piece.foot(&placed.center_m).distance_m < within_m {
                    placed.places_on(piece, prediction_m, |nearest| {
                        room.nearest.push((number, nearest));
                    });
                }
            }
            let bounds = || placed.bounds().grown(prediction_m);
            around.find_on_relief(bounds, &mut room.pieces, |number, piece| {
                let before = room.nearest.len();
                placed.places_on(piece, prediction_m, |nearest| {
                    room.nearest.push((number, nearest));
                });
                room.nearest.len() > before
            });
            keep_nearest_of_surface(&mut room.nearest, &room.pieces);
            for (_, nearest) in &room.nearest {
                let support = |center_m, axis| {
                    let turned = placed.turned;
                    let then = PlacedProfile {
                        turned,
                        center_m,
                        axis,
                    };
                    (then.support(&nearest.normal, nearest.corner), false)
                };
                found.push(self.on_roller((wheel, index), placed.axis, nearest, support));
            }
        }
    }

    /// The place of a barrel nearest to the ground, with its state at the beginning of the step.
    fn on_barrel(
        &self,
        of: (usize, usize),
        placed: &PlacedBarrel<'_>,
        nearest: &Nearest,
    ) -> Candidate {
        self.on_roller(of, placed.axis, nearest, |center_m, axis| {
            let then = PlacedBarrel {
                barrel: placed.barrel,
                center_m,
                axis,
            };
            then.support(&nearest.normal)
        })
    }

    /// The place of a roller near the ground, with its state at the beginning of the step.
    /// `support` finds the support point towards the ground for another pose of the roller, and
    /// whether it is on an end sphere.
    fn on_roller(
        &self,
        (wheel, index): (usize, usize),
        along: Vector3<f64>,
        nearest: &Nearest,
        support: impl Fn(Vector3<f64>, Vector3<f64>) -> (Vector3<f64>, bool),
    ) -> Candidate {
        let roller = &self.wheels[wheel].rollers[index];
        let touches = |state: &State| {
            let hub = &state.hubs()[wheel];
            let axis = hub.rotation * roller.axis_in_hub;
            let center_m = roller.center_m(hub);
            let (place_m, on_its_end) = support(center_m, axis);
            Touch {
                center_m,
                axis,
                place_m,
                on_its_end,
                axes: frame(nearest.normal, axis),
            }
        };
        let velocity = |state: &State, touch: &Touch, more_spin_rad_s: f64| {
            let carried = state.hub_velocity_m_s(wheel, &touch.place_m);
            let per_spin = touch.per_spin_m();
            let spin_rad_s = roller.spin_rad_s(&state.hub_rate_in_hub(wheel)) + more_spin_rad_s;
            along_frame(&touch.axes, &(carried + spin_rad_s * per_spin))
        };
        let (before, ahead) = (touches(&self.step.before), touches(&self.step.ahead));
        // A soft roller takes its load over gradually.
        let is_compliant = self.wheels[wheel].is_compliant();
        let came_down =
            self.step.resolves_rollers && !roller.pressed && !roller.seized && !is_compliant;
        let turning = if !self.step.resolves_rollers {
            Turning::NONE
        } else if came_down {
            // On average it takes over at the beginning of the step, and rolls from then on.
            let radius_m = along_frame(&before.axes, &before.per_spin_m()).z;
            let missing_rad_s = -velocity(&self.step.before, &before, 0.0).z / radius_m;
            let from_m_s = velocity(&self.step.ahead, &ahead, missing_rad_s)
                - velocity(&self.step.before, &before, missing_rad_s);
            Turning {
                came_down_at_m: Some(before.place_m),
                until_m_s: Vector3::zeros(),
                from_m_s,
            }
        } else if ahead.on_its_end && !is_compliant {
            // Beyond its end it no longer touches: its rotation there is not that of its contact.
            let middle = touches(&self.step.middle);
            let half_m_s = velocity(&self.step.middle, &middle, 0.0)
                - velocity(&self.step.before, &before, 0.0);
            Turning::in_each_half(half_m_s)
        } else {
            let half_m_s = 0.5
                * (velocity(&self.step.ahead, &ahead, 0.0)
                    - velocity(&self.step.before, &before, 0.0));
            Turning::in_each_half(half_m_s)
        };
        let travel_m_s = (ahead.place_m - before.place_m) / self.dt_s;
        // A rigid roller touches on the ground; the core of a soft one beneath it, so that it rolls
        // like a rigid one.
        let place_m = if is_compliant {
            nearest.place_m + nearest.gap_m * nearest.normal
        } else {
            nearest.place_m
        };
        let between = (self.member(Part::Roller(wheel, index)), Partner::Ground);
        Candidate {
            along,
            turning,
            came_down,
            travel_m_s: travel_m_s - nearest.normal * nearest.normal.dot(&travel_m_s),
            on_barrel: true,
            gap_ahead_m: nearest.normal.dot(&(ahead.place_m - nearest.place_m)),
            ..Candidate::new(between, (place_m, nearest.normal, nearest.gap_m))
        }
    }

    /// Velocity of a point of a roller's surface in the roller's pose in a state, with the rates at
    /// the beginning of the step: the hub's part, in m/s, and the derivative by the roller's spin,
    /// in m.
    fn roller_velocity(
        &self,
        (wheel, roller): (usize, &RollerState),
        state: &State,
        place_m: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let hub = &state.hubs()[wheel];
        let axis = hub.rotation * roller.axis_in_hub;
        let carried = state.hub_velocity_m_s(wheel, place_m);
        (carried, axis.cross(&(place_m - roller.center_m(hub))))
    }

    /// The places of rollers with the shapes of their file, as found by rapier.
    /// Adds the places of the rollers with the shapes of their file.
    fn find_modelled(&self, wheel: usize, found: &mut Vec<Candidate>) {
        let body = &self.wheels[wheel];
        let hub = &self.step.middle.hubs()[wheel];
        for (index, roller) in body.rollers.iter().enumerate() {
            let Some(solid) = roller.placed_shape(hub) else {
                continue;
            };
            let along = hub.rotation * roller.axis_in_hub;
            let add = |near: Near| {
                let in_hub_m = hub.rotation.tr_mul(&(near.place_m - hub.center_m));
                let velocity = |state: &State| {
                    let hub = &state.hubs()[wheel];
                    let place_m = hub.place_m(&in_hub_m);
                    let (carried, per_spin) =
                        self.roller_velocity((wheel, roller), state, &place_m);
                    let spin_rad_s = roller.spin_rad_s(&state.hub_rate_in_hub(wheel));
                    let axes = frame(near.normal, hub.rotation * roller.axis_in_hub);
                    along_frame(&axes, &(carried + spin_rad_s * per_spin))
                };
                let between = (self.member(Part::Roller(wheel, index)), Partner::Ground);
                let gained_m_s = velocity(&self.step.ahead) - velocity(&self.step.before);
                found.push(Candidate {
                    along,
                    turning: Turning::in_each_half(0.5 * gained_m_s),
                    came_down: !roller.pressed && !roller.seized,
                    ..Candidate::new(between, (near.place_m, near.normal, near.gap_m))
                });
            };
            let within_m = NEAR * self.scale.length_m;
            self.ground.near((&solid, &solid.bounds()), within_m, add);
        }
    }
}
