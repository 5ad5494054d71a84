//! Everything that a step's reactions depend on.

use ilon_robot::Robot;
use rapier3d::prelude::PhysicsWorld;

use crate::ground::Ground;
use crate::robot::assembly::Assembly;
use crate::robot::state::State;
use crate::{MotorTorque, Settings};

/// Everything that a step's reactions depend on, as rapier left it.
pub(crate) struct Scene<'a> {
    pub rapier: &'a PhysicsWorld,
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
    /// The rates of bodies when the step began, by degree of freedom.
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
