//! Rigid bodies: links merged over locked joints.

use nalgebra::{Point3, Vector3};

use super::geometry::extent_m;
use super::tree::{Motion, PlacedShape, Tree, TreeLink};
use crate::model::{MassProperties, Remark};

/// Links that move as one.
pub(super) struct RigidBody {
    /// The topmost link.
    pub(super) link: usize,
    /// All of its links.
    pub(super) links: Vec<usize>,
    /// Mass properties in the body frame; `None` if no link has mass.
    pub(super) mass: Option<MassProperties>,
    /// Collision geometry in the body frame.
    pub(super) shapes: Vec<PlacedShape>,
    /// Visual shapes in the body frame.
    pub(super) visuals: Vec<PlacedShape>,
    /// Movable joints inside it that are locked at zero.
    pub(super) held: Vec<usize>,
}

impl Tree {
    /// Returns everything that moves as one with `link` and is below it, if the joints chosen by
    /// `splits` move and all others are locked at zero.
    pub(super) fn rigid_body(&self, link: usize, splits: impl Fn(usize) -> bool) -> RigidBody {
        let mut body = RigidBody {
            link,
            links: Vec::new(),
            mass: None,
            shapes: Vec::new(),
            visuals: Vec::new(),
            held: Vec::new(),
        };
        let mut parts = Vec::new();
        let mut waiting = vec![link];
        while let Some(link) = waiting.pop() {
            let TreeLink {
                mass,
                shapes,
                visuals,
                joints_below,
                ..
            } = &self.links[link];
            parts.extend(mass.clone());
            body.links.push(link);
            body.shapes.extend(shapes.iter().cloned());
            body.visuals.extend(visuals.iter().cloned());
            // Reversed, so that the first in the file is merged first.
            for &j in joints_below.iter().rev().filter(|&&j| !splits(j)) {
                if self.joints[j].motion != Motion::Fixed {
                    body.held.push(j);
                }
                waiting.push(self.joints[j].child);
            }
        }
        body.mass = MassProperties::merged(&parts);
        body
    }

    /// Returns a link without the links below it.
    pub(super) fn lone_body(&self, link: usize) -> RigidBody {
        let TreeLink {
            mass,
            shapes,
            visuals,
            ..
        } = &self.links[link];
        RigidBody {
            link,
            links: vec![link],
            mass: mass.clone(),
            shapes: shapes.clone(),
            visuals: visuals.clone(),
            held: Vec::new(),
        }
    }
}

impl RigidBody {
    /// Adds remarks on movable joints locked at zero, and on the wheels (by their joints) that they
    /// would carry.
    pub(super) fn remark_held(
        &self,
        tree: &Tree,
        of: &str,
        wheels: &[usize],
        remarks: &mut Vec<Remark>,
    ) {
        if self.held.is_empty() {
            return;
        }
        for &j in &self.held {
            let carried = wheels
                .iter()
                .filter(|&&wheel| wheel == j || tree.joints_above(wheel).any(|k| k == j));
            let carried: Vec<String> = carried
                .map(|&wheel| format!("`{}`", tree.joints[wheel].name))
                .collect();
            let words = if carried.len() == wheels.len() && !carried.is_empty() {
                "it carries the whole robot, as joints to the world do, and is held at zero"
                    .to_owned()
            } else if carried.is_empty() {
                format!("neither wheel nor roller: it is held at zero and moves with {of}")
            } else {
                format!(
                    "it lies between the chassis and {}, and is held at zero: their loads are those of wheels on a rigid frame, \
                     where a rocker, a suspension or a steering would share them otherwise",
                    carried.join(", ")
                )
            };
            let subject = format!("joint `{}`", tree.joints[j].name);
            remarks.push(Remark::new(subject, words));
        }
    }

    /// Returns the largest distance of its geometry, without meshes, from a point of the body
    /// frame, in metres; 0 without any.
    pub(super) fn reach_m(&self, from: &Vector3<f64>) -> f64 {
        self.shapes
            .iter()
            .chain(&self.visuals)
            .filter_map(|shape| extent_m(shape, &Point3::from(*from)))
            .fold(0.0, f64::max)
    }
}
