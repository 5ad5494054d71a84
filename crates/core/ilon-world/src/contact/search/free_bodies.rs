//! Finds places where free bodies are near the ground, robots and one another, and where the bodies
//! of two robots are near each other.

use nalgebra::{Point3, Vector3};

use crate::contact::frame::{along_frame, frame};
use crate::contact::reactions::reaction::{Part, Partner};
use crate::contact::scene::{Scene, Scenes};
use crate::contact::search::bounds::Bounds;
use crate::contact::search::candidate::{Candidate, Turning};
use crate::contact::search::on_ground::Workspace;
use crate::contact::search::solid::{Near, Solid};
use crate::contact::search::thinning::thin;
use crate::free::Free;
use crate::robot::articulated::Articulated;
use crate::robot::state::State;
use crate::settings::NEAR;

impl Scenes<'_> {
    /// Adds the places where free bodies are near anything.
    pub fn find_near_free_bodies(&self, room: &mut Workspace, found: &mut Vec<Candidate>) {
        // Free bodies come after the robots.
        if self.bodies.last().is_none_or(Articulated::is_robot) {
            return;
        }
        for scene in self.each().filter(|scene| !scene.body.is_robot()) {
            self.find_in_rapier(&scene, found);
            let shapes = scene.body.robot.shapes().iter();
            for (solid, shape) in solids(scene.body, &scene.step.middle).zip(shapes) {
                let own = FreePart {
                    scene: &scene,
                    joint: None,
                    solid: &solid,
                    bounds: solid.bounds(),
                    friction: shape.friction,
                };
                self.find_around(own, room, found);
            }
        }
    }

    /// Adds the places where the chassis of two robots, and the bodies on their joints, are near
    /// each other. Their rollers are left out.
    pub fn find_between_robots(&self, found: &mut Vec<Candidate>) {
        // One robot has no other before it.
        for scene in self.each().skip(1).filter(|scene| scene.body.is_robot()) {
            for (joint, solid) in parts(scene.body, &scene.step.middle) {
                let own = FreePart {
                    scene: &scene,
                    joint,
                    solid: &solid,
                    bounds: solid.bounds(),
                    friction: None,
                };
                for other in self.each().take(scene.index) {
                    find_between_chassis(&other, own, found);
                }
            }
        }
    }

    /// Adds the places where rapier found contacts of a coupled body with user bodies and fixed
    /// ones.
    fn find_in_rapier(&self, scene: &Scene<'_>, found: &mut Vec<Candidate>) {
        let coupled = scene.body.coupled().into_iter();
        let contacts = coupled.flat_map(|coupled| &coupled.contacts);
        found.extend(contacts.map(|contact| {
            let place = scene.step.middle.floor_from_chassis() * Point3::from(contact.in_body_m);
            let near = Near {
                place_m: place.coords,
                normal: contact.normal,
                gap_m: contact.gap_m,
                is_corner: false,
            };
            let other = contact.other.map(|other| self.of(other));
            let other = other.as_ref().map(|other| (other, None));
            Candidate {
                friction: Some(contact.friction),
                ..candidate((scene, None), other, &near)
            }
        }));
    }

    fn find_around(&self, own: FreePart<'_>, room: &mut Workspace, found: &mut Vec<Candidate>) {
        // rapier finds contacts of coupled bodies with the ground and with one another.
        let is_coupled = own.scene.body.coupled().is_some();
        if !is_coupled {
            own.scene.find_ground(found);
        }
        for other in self.each() {
            if other.body.is_robot() {
                find_robot(&other, own, room, found);
            } else if other.index < own.scene.index
                && !(is_coupled && other.body.coupled().is_some())
            {
                find_between_chassis(&other, own, found);
            }
        }
    }

    /// The friction of a contact, given the ground's: that of a user's collider if there is one,
    /// for free bodies the lower one of the pair, but against robots their own.
    pub fn friction_between(&self, place: &Candidate, of_ground: f64) -> f64 {
        let free = |body: usize| self.bodies[body].free();
        let of_a = free(place.a.body);
        let of_b = match place.b {
            Partner::Of(b) => free(b.body),
            Partner::Ground | Partner::Itself => {
                let lower = |of: &Free| of.friction.min(of_ground);
                return place.friction.unwrap_or(of_a.map_or(of_ground, lower));
            }
        };
        match (place.friction, of_a, of_b) {
            (Some(friction), one, _) => one.map_or(friction, |one| one.friction.min(friction)),
            (None, Some(one), Some(other)) => one.friction.min(other.friction),
            (None, Some(free), None) | (None, None, Some(free)) => free.friction_on_robots,
            (None, None, None) => of_ground,
        }
    }
}

/// A shape of a free body, or of a robot's body for another robot.
#[derive(Clone, Copy)]
struct FreePart<'a> {
    scene: &'a Scene<'a>,
    /// The joint of a robot's body.
    joint: Option<usize>,
    solid: &'a Solid<'a>,
    /// Its bounding box.
    bounds: Bounds,
    /// The shape's own friction, if it has one.
    friction: Option<f64>,
}

/// The shapes of a robot's chassis and of its bodies on joints, each with its joint, or the shape
/// of a free body, in a state.
pub(crate) fn parts<'a, 's>(
    body: &'a Articulated,
    state: &'s State,
) -> impl Iterator<Item = (Option<usize>, Solid<'a>)> + use<'a, 's> {
    let center_m = body.chassis_mass.center_of_mass_m;
    body.robot.shapes().iter().map(move |of| {
        let solid = Solid {
            shape: &of.shape,
            floor_from_shape: state.carrier(of.joint, &center_m) * of.carrier_from_shape,
        };
        (of.joint, solid)
    })
}

/// The same shapes alone.
pub(crate) fn solids<'a, 's>(
    body: &'a Articulated,
    state: &'s State,
) -> impl Iterator<Item = Solid<'a>> + use<'a, 's> {
    parts(body, state).map(|(_, solid)| solid)
}

/// The largest displacement of a point of a chassis, or of a body on its joints, in a step by the
/// rates of a state, in metres.
pub(crate) fn travel_m(body: &Articulated, state: &State, dt_s: f64) -> f64 {
    let center_m = state.center_m();
    let of_chassis = parts(body, state).filter(|(joint, _)| joint.is_none());
    let reach_m = of_chassis.map(|(_, solid)| {
        let ball = solid.shape.compute_local_bounding_sphere();
        let at_m = solid.floor_from_shape.translation.vector - center_m;
        let off_m = ball.center.length() + ball.radius;
        at_m.norm() + off_m
    });
    let turns_m_s = state.angular_rad_s.norm() * reach_m.fold(0.0, f64::max);
    let goes_m_s = state.velocity_m_s.norm() + turns_m_s;
    dt_s * goes_m_s.max(fastest_link_m_s(body, state))
}

/// The largest speed of a point of a body on a joint by the rates of a state, in m/s.
fn fastest_link_m_s(body: &Articulated, state: &State) -> f64 {
    let of_links = parts(body, state).filter(|(joint, _)| joint.is_some());
    let fastest = of_links.map(|(joint, solid)| {
        let ball = solid.shape.compute_local_bounding_sphere();
        let at_m = solid.floor_from_shape.translation.vector;
        let off_m = ball.center.length() + ball.radius;
        let turns_m_s = state.carrier_rates(joint).norm() * off_m;
        state.carrier_velocity_m_s(joint, &at_m).norm() + turns_m_s
    });
    fastest.fold(0.0, f64::max)
}

/// The distance within which two bodies are searched for contacts, in metres.
fn within_m(one: &Scene<'_>, other: &Scene<'_>) -> f64 {
    let of = |scene: &Scene<'_>| travel_m(scene.body, &scene.step.before, scene.dt_s);
    NEAR * one.scale.length_m.max(other.scale.length_m) + of(one) + of(other)
}

impl Scene<'_> {
    /// Adds the places where the body's shapes are near the ground: those of a robot's chassis and
    /// of the bodies on its joints, or that of a free body.
    pub fn find_ground(&self, found: &mut Vec<Candidate>) {
        let mut within_m = NEAR * self.scale.length_m;
        if !self.body.is_robot() {
            within_m += travel_m(self.body, &self.step.before, self.dt_s);
        }
        let first = found.len();
        let shapes = self.body.robot.shapes().iter();
        for ((joint, solid), shape) in parts(self.body, &self.step.middle).zip(shapes) {
            let add = |near: Near| {
                found.push(Candidate {
                    friction: shape.friction,
                    ..candidate((self, joint), None, &near)
                });
            };
            self.ground.near((&solid, &solid.bounds()), within_m, add);
        }
        thin(
            (found, first),
            self.step.middle.floor_from_chassis(),
            2.0 * self.scale.length_m,
        );
    }
}

fn find_between_chassis(a: &Scene<'_>, own: FreePart<'_>, found: &mut Vec<Candidate>) {
    let b = own.scene;
    let within_m = within_m(a, b);
    let around = own.bounds.grown(within_m);
    for (joint, part) in parts(a.body, &a.step.middle) {
        if part.bounds().meets(&around) {
            part.near(own.solid, within_m, |near| {
                found.push(Candidate {
                    friction: own.friction,
                    ..candidate((a, joint), Some((b, own.joint)), &near)
                });
            });
        }
    }
}

fn find_robot(
    robot: &Scene<'_>,
    own: FreePart<'_>,
    room: &mut Workspace,
    found: &mut Vec<Candidate>,
) {
    find_between_chassis(robot, own, found);
    let FreePart {
        scene,
        solid,
        bounds,
        friction,
        ..
    } = own;
    let Some(piece) = solid.piece() else {
        return;
    };
    let mut of_wheel = Vec::new();
    for (wheel, hub) in robot.step.middle.hubs().iter().enumerate() {
        let travels_m = travel_m(scene.body, &scene.step.before, scene.dt_s);
        let within_m = robot.prediction_m(wheel) + travels_m;
        let reach_m = robot.wheels[wheel].reach_m + within_m;
        if !Bounds::of_ball(&hub.center_m, reach_m).meets(&bounds) {
            continue;
        }
        robot.find_on_piece(wheel, (piece.clone(), within_m), room, &mut of_wheel);
        found.extend(of_wheel.drain(..).map(|place| Candidate {
            b: Partner::Of(scene.member(Part::Chassis)),
            friction,
            ..place
        }));
    }
}

/// A place of A's chassis, or of its body on a joint, near a free body or another robot's, or of a
/// free body near the ground.
fn candidate(
    (a, joint): (&Scene<'_>, Option<usize>),
    b: Option<(&Scene<'_>, Option<usize>)>,
    near: &Near,
) -> Candidate {
    // A shape of a robot turns about a place outside of it, and carries each of its points along.
    let turning = if near.is_corner || a.body.is_robot() {
        let axes = frame(near.normal, Vector3::x());
        let of_b = b.map(|(scene, joint)| scene.gained_by_turning_m_s(joint, &near.place_m));
        let of_a = a.gained_by_turning_m_s(joint, &near.place_m);
        let gained_m_s = of_a - of_b.unwrap_or_else(Vector3::zeros);
        Turning::in_each_half(0.5 * along_frame(&axes, &gained_m_s))
    } else {
        Turning::NONE
    };
    let of_b = b.map_or(Partner::Ground, |(scene, joint)| {
        Partner::Of(scene.member(Part::of_body(joint)))
    });
    let between = (a.member(Part::of_body(joint)), of_b);
    Candidate {
        turning,
        ..Candidate::new(between, (near.place_m, near.normal, near.gap_m))
    }
}
