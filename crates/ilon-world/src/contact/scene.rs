//! Everything that a step's reactions depend on.

use ilon_robot::Robot;
use nalgebra::Vector3;

use crate::engine::copy::Engine;
use crate::ground::Ground;
use crate::robot::articulated::Articulated;
use crate::robot::assembly::Assembly;
use crate::robot::state::State;
use crate::{MotorTorque, Settings};

/// Everything that a step's reactions depend on: the ground and all articulated bodies, as rapier left them.
#[derive(Clone, Copy)]
pub(crate) struct Scenes<'a> {
    pub ground: &'a Ground,
    pub settings: &'a Settings,
    /// How long the step is, in seconds.
    pub dt_s: f64,
    pub bodies: &'a [Articulated],
}

/// What concerns one articulated body of it.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    /// Its place among the bodies.
    pub index: usize,
    pub rapier: &'a Engine,
    /// Where its rapier world counts from, in the floor's frame, in metres.
    pub origin_m: Vector3<f64>,
    pub ground: &'a Ground,
    pub robot: &'a Robot,
    pub assembly: &'a Assembly,
    pub settings: &'a Settings,
    /// How long the step is, in seconds.
    pub dt_s: f64,
    /// The robot when the step began.
    pub before: &'a State,
    /// Its poses in the middle of the step, with the rates of its beginning.
    pub middle: &'a State,
    /// And where these rates would take it by the end of the step.
    pub ahead: &'a State,
    /// Whether the step is short enough to see how rollers turn while they pass over the ground.
    pub sees_rollers_pass: bool,
    /// The rates of its bodies when the step began, by degree of freedom.
    pub rates_before: &'a [f64],
    /// And at its end without any reaction.
    pub rates_free: &'a [f64],
    /// What the motors do.
    pub motors: &'a [MotorTorque],
    /// The torque of each wheel's motor that its gear takes a share of, in N m.
    pub geared_n_m: &'a [f64],
    /// What each wheel's motor and bearing lose of their impulse in the step per rate that it gains, in N m s per rad/s.
    pub held_n_m_s2: &'a [f64],
}

impl<'a> Scenes<'a> {
    /// What concerns the articulated body at a place among them.
    pub fn of(&self, index: usize) -> Scene<'a> {
        let body = &self.bodies[index];
        Scene {
            index,
            rapier: &body.rapier,
            origin_m: body.anchor.origin_m(),
            ground: self.ground,
            robot: &body.robot,
            assembly: &body.assembly,
            settings: self.settings,
            dt_s: self.dt_s,
            before: &body.before,
            middle: &body.middle,
            ahead: &body.ahead,
            sees_rollers_pass: body.sees_rollers_pass,
            rates_before: &body.rates_before,
            rates_free: &body.rates_free,
            motors: &body.motors,
            geared_n_m: &body.geared_n_m,
            held_n_m_s2: &body.held_n_m_s2,
        }
    }

    /// What concerns each articulated body, in their order.
    pub fn each(self) -> impl Iterator<Item = Scene<'a>> {
        (0..self.bodies.len()).map(move |index| self.of(index))
    }
}
