//! Free bodies of a world by identity: adding, removing, reading and pushing them.

mod grouping;
pub(super) mod islands;
mod put_down;
mod queries;

use std::sync::Arc;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::World;
use crate::free::{Free, FreeBody, FreeBodyId};
use crate::robot::articulated::{Articulated, Kind};
use crate::robot::payload::ActingPush;
use crate::robot::shared_robot::SharedRobot;
use crate::settings::ContactSpring;
use crate::{ContactSolver, WorldError};
use islands::place_among;
pub use queries::RayHit;

/// A free body after the last step, in the world's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FreeBodyState {
    /// Its centre, in metres.
    pub place_m: Vector3<f64>,
    /// Its orientation.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity of its centre, in m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Its angular velocity, in rad/s.
    pub angular_rad_s: Vector3<f64>,
    /// Mean force of all robots on it in the last step, in N.
    pub force_from_robots_n: Vector3<f64>,
    /// Net work of robots on it by contact since it was added, in J.
    pub work_of_robots_j: f64,
    /// Largest penetration between it and its partners since it was added, in metres: a body too
    /// heavy for its support sinks in.
    pub pressed_m: f64,
    /// Whether it is at rest, and is skipped until something comes near.
    pub sleeps: bool,
}

impl World {
    /// Adds a free body to the world.
    ///
    /// Its contacts are like those of a chassis: stiff springs that only push, Coulomb friction and
    /// no bounce. Rollers with the shapes of their file do not touch it, and rollers with a profile
    /// by numbers touch only boxes.
    ///
    /// # Errors
    /// [`WorldError`] if its sizes or mass are invalid, if it would start in the ground, in a robot
    /// or in another free body, and if rapier solves the contacts.
    pub fn add_body(&mut self, body: &FreeBody) -> Result<FreeBodyId, WorldError> {
        body.check()?;
        if self.settings.contacts == ContactSolver::Rapier {
            return Err(WorldError::NotInRapier {
                what: format!("free bodies (`{}`)", body.name),
                remedy: "leave the bodies out",
            });
        }
        let id = self.islands.next_id();
        let mut built = self.build(body, id);
        let middle_m = self.put_down(body, &built)?;
        let at = Isometry3::from_parts(middle_m.into(), body.rotation);
        for state in built.states_mut() {
            state.place(at);
            state.velocity_m_s = body.velocity_m_s;
            state.angular_rad_s = body.angular_rad_s;
        }
        if self.steps > 0 {
            let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
            self.energies.outside_j += built.kinetic_j() + built.potential_j(&gravity);
        }
        self.islands.add(built, body.is_at_rest());
        Ok(id)
    }

    fn build(&self, body: &FreeBody, id: FreeBodyId) -> Articulated {
        let robot = SharedRobot::from(&body.as_robot());
        let at = Isometry3::from_parts(Vector3::zeros().into(), body.rotation);
        let mut built = Articulated::build(robot, &at, &self.settings);
        built.scale = body.scale(self.settings.gravity_m_s2);
        built.spring = ContactSpring::of_body(&self.settings, &built.scale);
        built.kind = Kind::Free(Box::new(Free {
            id,
            name: Arc::from(body.name.as_str()),
            friction: body.friction,
            friction_on_robots: body.friction_on_robots.unwrap_or(body.friction),
            slow_s: 0.0,
            from_robots: Vector3::zeros(),
            work_j: 0.0,
            pressed_m: 0.0,
        }));
        built
    }

    /// Removes a free body from the world. Returns whether it was there.
    pub fn remove_body(&mut self, id: FreeBodyId) -> bool {
        self.wake(id);
        let gone = match place_among(&self.bodies, id) {
            Some(at) => {
                self.reactions.split_off(|body| body != at);
                Some(self.bodies.remove(at))
            }
            None => self.islands.remove(id),
        };
        let Some(gone) = gone else {
            return false;
        };
        self.islands.forget(id);
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        self.energies.outside_j -= gone.kinetic_j() + gone.potential_j(&gravity);
        true
    }

    /// The identities of all free bodies, in the order in which they were added.
    pub fn free_bodies(&self) -> &[FreeBodyId] {
        self.islands.ids()
    }

    /// A free body in its current state; `None` if it is not in the world.
    pub fn free_body(&self, id: FreeBodyId) -> Option<FreeBodyState> {
        let (body, sleeps) = self.find_body(id)?;
        let free = body.free()?;
        Some(FreeBodyState {
            place_m: body.state.center_m(),
            rotation: body.state.floor_from_chassis().rotation,
            velocity_m_s: body.state.velocity_m_s,
            angular_rad_s: body.state.angular_rad_s,
            force_from_robots_n: if sleeps {
                Vector3::zeros()
            } else {
                free.from_robots
            },
            work_of_robots_j: free.work_j,
            pressed_m: free.pressed_m,
            sleeps,
        })
    }

    /// The name of a free body; `None` if it is not in the world.
    pub fn free_body_name(&self, id: FreeBodyId) -> Option<&str> {
        let (body, _) = self.find_body(id)?;
        body.free().map(|free| &*free.name)
    }

    /// Pushes a free body during the next step only: a force in the world, in N, at a point
    /// relative to its centre in its own axes, in metres. Several pushes add up. A body that is not
    /// in the world is ignored.
    pub fn push_body(
        &mut self,
        id: FreeBodyId,
        force_n: Vector3<f64>,
        place_in_body_m: Vector3<f64>,
    ) {
        self.wake(id);
        let here = place_among(&self.bodies, id).map(|at| &mut self.bodies[at]);
        if let Some(body) = here.or_else(|| self.islands.awake_mut(id)) {
            let lever_m = body.state.floor_from_chassis().rotation * place_in_body_m;
            body.command.pushes.push(ActingPush {
                force_n,
                lever_m,
                moment_n_m: Vector3::zeros(),
            });
        }
    }

    fn find_body(&self, id: FreeBodyId) -> Option<(&Articulated, bool)> {
        match place_among(&self.bodies, id) {
            Some(at) => Some((&self.bodies[at], false)),
            None => self.islands.find(id),
        }
    }

    /// Counts the effect of robots on free bodies, and of robots and free bodies on coupled bodies.
    pub(super) fn count_pushing(&mut self) {
        // Both come after the robots.
        if self.bodies.last().is_none_or(Articulated::is_robot) {
            return;
        }
        for (reaction, b) in self.reactions.on_bodies() {
            let pusher = &self.bodies[reaction.a.body];
            let (by_robot, by_coupled) = (pusher.is_robot(), pusher.coupled().is_some());
            let body = &mut self.bodies[b];
            let middle = &body.step.middle;
            let normal = reaction.impulse.x * reaction.frame[0];
            let impulse_n_s = -(normal + reaction.friction_impulse_n_s());
            let did_j = impulse_n_s.dot(&middle.chassis_velocity_m_s(&reaction.at_m));
            let lever_m = reaction.at_m - middle.center_m();
            match &mut body.kind {
                Kind::Free(free) if by_robot => {
                    free.from_robots += impulse_n_s;
                    free.work_j += did_j;
                }
                Kind::Coupled(coupled) if !by_coupled => {
                    coupled.impulse[0] += impulse_n_s;
                    coupled.impulse[1] += lever_m.cross(&impulse_n_s);
                    self.energies.outside_j -= did_j;
                }
                _ => {}
            }
        }
    }
}
