//! Finds the equilibrium of a robot with joints at the start of a world: of springs, stops and the
//! ground.
//!
//! The robot is released in the pose of a rigid one, on frictionless ground, in steps after each of
//! which all rates are set to zero. Springs are evaluated at the end of such a step, so that a long
//! step is a step of Newton's method towards their equilibrium, and contacts are solved as in any
//! step. Its position and heading in the plane, its wheels' angles, and the directions of its
//! casters, which the ground's friction would hold, are kept.

use ilon_robot::roll_pitch_yaw;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::{ContactSolution, Energies, World, with_solver};
use crate::contact::reactions::{ReactionSolver, Reactions};
use crate::robot::articulated::Articulated;
use crate::robot::state::State;
use crate::settings::NEAR;

/// The most steps; a soft spring takes some hundred. Chosen.
const MOST_STEPS: usize = 4000;
/// The first step, and the longest, in a robot's unit of time. Chosen.
const FIRST: f64 = 0.05;
const LONGEST: f64 = 0.5;
/// The smallest value to which the longest step is reduced, in that unit: contacts that open and
/// close oscillate in long steps. Chosen.
const SHORTEST: f64 = 0.01;
/// The equilibrium is found if nothing moves faster than this in a step, in m/s: several times the
/// solver's tolerance. Chosen.
const FOUND_M_S: f64 = 5e-8;
/// A remaining displacement below this at the end, in wheel radii, counts as equilibrium: rollers
/// that hand over on a slope have no smoother one. Chosen.
const NEARLY: f64 = 2e-3;

impl World {
    /// Finds the equilibrium of robots with joints. A robot without one, because it falls over,
    /// begins in its initial pose.
    pub(super) fn find_equilibrium(&mut self) {
        let has_joints = |body: &Articulated| !body.robot.joints.is_empty();
        if self.settings.gravity_m_s2 == 0.0 || !self.bodies.iter().any(has_joints) {
            return;
        }
        let put_down = self.bodies.clone();
        let ground = self.ground.clone();
        self.ground.set_friction(Some(0.0), &[]);
        for body in &mut self.bodies {
            body.is_settling = true;
        }
        let is_found = with_solver(|solver| self.come_to_rest(solver, &put_down));
        self.ground = ground;
        let came = std::mem::replace(&mut self.bodies, put_down);
        if is_found {
            for (body, came) in self.bodies.iter_mut().zip(&came) {
                body.stand(&came.state);
            }
        }
        self.energies = Energies::default();
        if is_found && self.reactions.treads_j() > 0.0 {
            // Treads, and casters beside them, hold energy from the start.
            self.reactions.keep_contacts();
            self.energies.treads_j = self.reactions.treads_j();
            let dt_s = self.reactions.dt_s();
            self.energies.springs_j = self.reactions.spring_energy_j(&self.bodies, dt_s);
        } else {
            self.reactions = Reactions::default();
        }
        self.solution = ContactSolution::default();
    }

    /// Returns whether they come to rest.
    fn come_to_rest(&mut self, solver: &mut ReactionSolver, put_down: &[Articulated]) -> bool {
        let scales = || put_down.iter().map(|body| &body.scale);
        let time_s = scales().map(|s| s.time_s()).fold(0.0, f64::max);
        let length_m = scales().map(|s| s.length_m).fold(f64::INFINITY, f64::min);
        let casters: Vec<_> = put_down.iter().map(|body| body.robot.castering()).collect();
        let (mut dt_s, mut longest_s) = (FIRST * time_s, LONGEST * time_s);
        let mut last_m = f64::INFINITY;
        let mut from: Vec<State> = put_down.iter().map(|body| body.state.clone()).collect();
        for _ in 0..MOST_STEPS {
            self.find_reactions(solver, dt_s);
            self.move_on(solver, dt_s);
            for ((body, put_down), casters) in self.bodies.iter_mut().zip(put_down).zip(&casters) {
                body.halt(put_down);
                body.state.put_back(casters, &put_down.state);
            }
            let moves = self.bodies.iter().zip(&from);
            let moved_m = moves.map(|(body, from)| moved_m(&body.state, from));
            let moved_m = moved_m.fold(0.0, f64::max);
            if !moved_m.is_finite() {
                return false;
            }
            if moved_m > 0.5 * NEAR * length_m {
                // Approaching contacts would be found too late.
                dt_s *= 0.5;
                for (body, from) in self.bodies.iter_mut().zip(&from) {
                    body.state.copy_from(from);
                }
                continue;
            }
            if moved_m < FOUND_M_S * dt_s && dt_s >= longest_s {
                return true;
            }
            if dt_s >= longest_s && moved_m >= last_m {
                longest_s = (0.7 * longest_s).max(SHORTEST * time_s);
                dt_s = longest_s;
            } else if moved_m < 0.1 * NEAR * length_m {
                dt_s = (1.5 * dt_s).min(longest_s);
            }
            last_m = moved_m;
            for (body, from) in self.bodies.iter().zip(&mut from) {
                from.copy_from(&body.state);
            }
        }
        last_m < NEARLY * length_m
    }
}

/// The largest displacement of the centre of a body or of a wheel between two states.
fn moved_m(state: &State, from: &State) -> f64 {
    let links = state.links().iter().zip(from.links());
    let moved = links.map(|(to, from)| (to.center_m - from.center_m).norm());
    moved.fold((state.center_m() - from.center_m()).norm(), f64::max)
}

impl Articulated {
    /// Sets all rates to zero in the pose reached, at the original position and heading.
    fn halt(&mut self, put_down: &Self) {
        let center_m = self.chassis_mass.center_of_mass_m;
        let body_of = |state: &State| state.floor_from_chassis() * Translation3::from(-center_m);
        let (now, then) = (body_of(&self.state), body_of(&put_down.state));
        let heading = |at: &Isometry3<f64>| roll_pitch_yaw(&at.rotation.to_rotation_matrix())[2];
        let back =
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading(&then) - heading(&now));
        let mut place_m = then.translation.vector;
        place_m.z = now.translation.vector.z;
        let floor_from_body = Isometry3::from_parts(place_m.into(), back * now.rotation);
        self.state
            .place(floor_from_body * Translation3::from(center_m));
        self.state.halt();
        self.wheels.clone_from(&put_down.wheels);
    }

    /// Takes over a state.
    fn stand(&mut self, state: &State) {
        for own in self.states_mut() {
            own.copy_from(state);
        }
    }
}
