//! The inputs of a step's reactions.

use ilon_robot::{Robot, Scale};
use nalgebra::Vector3;

use crate::Settings;
use crate::contact::reactions::Reactions;
use crate::contact::reactions::row::Side;
use crate::dynamics::{Factors, Motion, Path, Tree};
use crate::ground::Ground;
use crate::robot::articulated::{Articulated, BodyStep};
use crate::robot::state::State;
use crate::robot::wheel::WheelBody;

/// The inputs of a step's reactions: the ground and all articulated bodies, as they move without
/// one another.
#[derive(Clone, Copy)]
pub(crate) struct Scenes<'a> {
    pub ground: &'a Ground,
    pub settings: &'a Settings,
    /// Length of the step, in seconds.
    pub dt_s: f64,
    pub bodies: &'a [Articulated],
    /// The reactions between them in the last step.
    pub reactions: &'a Reactions,
}

/// The inputs for one articulated body.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    /// Its index among the bodies.
    pub index: usize,
    pub body: &'a Articulated,
    pub ground: &'a Ground,
    pub robot: &'a Robot,
    /// Its own units.
    pub scale: &'a Scale,
    pub wheels: &'a [WheelBody],
    pub tree: &'a Tree,
    pub settings: &'a Settings,
    /// Length of the step, in seconds.
    pub dt_s: f64,
    /// The reactions between the bodies in the last step.
    pub reactions: &'a Reactions,
    /// The step of the body without any reaction.
    pub step: &'a BodyStep,
}

impl<'a> Scenes<'a> {
    /// The inputs for the articulated body at an index.
    pub fn of(&self, index: usize) -> Scene<'a> {
        let body = &self.bodies[index];
        Scene {
            index,
            body,
            ground: self.ground,
            robot: &body.robot,
            scale: &body.scale,
            wheels: &body.wheels,
            tree: &body.tree,
            settings: self.settings,
            dt_s: self.dt_s,
            reactions: self.reactions,
            step: &body.step,
        }
    }

    /// The inputs for each articulated body, in order.
    pub fn each(self) -> impl Iterator<Item = Scene<'a>> {
        (0..self.bodies.len()).map(move |index| self.of(index))
    }
}

impl<'a> Scene<'a> {
    /// The body's mass matrix in the middle of the step, factorised.
    pub fn factors(&self) -> &'a Factors {
        self.body.mechanics.factors()
    }

    /// The rate of a wheel.
    pub fn of_hub(&self, wheel: usize) -> Side {
        self.of_joint(self.wheels[wheel].joint, 1.0)
    }

    /// The rate of a joint of the tree, times a factor.
    pub fn of_joint(&self, joint: usize, times: f64) -> Side {
        let share = |at: usize| if at == joint { times } else { 0.0 };
        Side::of_joints(self.index, self.tree.path(joint, share))
    }

    /// The velocity along a direction, and the rate about another, of a point that moves with the
    /// link of a joint of the tree, or with the chassis, in the pose of a state.
    pub fn moving_with(
        &self,
        joint: Option<usize>,
        state: &State,
        (place_m, direction): (&Vector3<f64>, &Vector3<f64>),
        turn: &Vector3<f64>,
    ) -> Side {
        let about = |point_m: &Vector3<f64>| (place_m - point_m).cross(direction) + turn;
        let share = |joint: usize| {
            let link = &state.links()[joint];
            match self.tree.joints()[joint].motion {
                Motion::Turns => link.axis().dot(&about(&link.center_m)),
                Motion::Slides => link.axis().dot(direction),
            }
        };
        let joints = joint.map_or(Path::NONE, |joint| self.tree.path(joint, share));
        let about_root = about(&state.center_m());
        let mut side = Side::of_joints(self.index, joints);
        side.root.fixed_rows_mut::<3>(0).copy_from(direction);
        side.root.fixed_rows_mut::<3>(3).copy_from(&about_root);
        side
    }
}
