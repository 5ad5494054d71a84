//! Finds places where the chassis of two articulated bodies, and the bodies on their joints, are
//! near each other.

use nalgebra::{Isometry3, Point3};
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use rapier3d::prelude::*;

use crate::contact::reactions::reaction::{Part, Partner};
use crate::contact::scene::{Scene, Scenes};
use crate::contact::search::candidate::Candidate;
use crate::contact::search::free_bodies::fastest_link_m_s;
use crate::engine::convert;
use crate::settings::NEAR;

impl Scenes<'_> {
    /// Adds the places where the chassis of articulated bodies are near each other. Their rollers
    /// are left out.
    pub fn find_between_chassis(&self, found: &mut Vec<Candidate>) {
        let robots = || self.each().filter(|scene| scene.body.is_robot());
        for (index, a) in robots().enumerate() {
            for b in robots().skip(index + 1) {
                self.find_between_two(&a, &b, found);
            }
        }
    }

    fn find_between_two(&self, a: &Scene<'_>, b: &Scene<'_>, found: &mut Vec<Candidate>) {
        let floor_from_a = a.step.middle.floor_from_chassis();
        let a_from_b = floor_from_a.inv_mul(b.step.middle.floor_from_chassis());
        let closes_m_s = speed_m_s(a) + speed_m_s(b);
        let within_m = NEAR * a.scale.length_m.max(b.scale.length_m) + self.dt_s * closes_m_s;
        for (joint_a, shape_a, a_from_shape) in shapes(a) {
            for (joint_b, shape_b, b_from_shape) in shapes(b) {
                let pose_b = convert::pose(&a_from_b) * b_from_shape;
                let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
                // If parry does not support a pair of shapes it says so at any pose: then they do
                // not touch.
                let _ = DefaultQueryDispatcher.contact_manifolds(
                    &(a_from_shape.inverse() * pose_b),
                    &**shape_a,
                    &**shape_b,
                    within_m,
                    &mut manifolds,
                    &mut None,
                );
                for manifold in &manifolds {
                    let poses = manifold.subshape_poses.as_deref();
                    let piece_a = poses.and_then(|poses| poses.pos1);
                    let piece_b = poses.and_then(|poses| poses.pos2);
                    let a_from_piece = a_from_shape * piece_a.unwrap_or(Pose::IDENTITY);
                    let from_piece_b = pose_b * piece_b.unwrap_or(Pose::IDENTITY);
                    // parry's normal points out of the first shape.
                    let normal_in_a = convert::to_vector(a_from_piece.rotation * manifold.local_n1);
                    let normal = -(floor_from_a.rotation * normal_in_a).normalize();
                    for point in &manifold.points {
                        let in_a_m = convert::to_vector(from_piece_b * point.local_p2);
                        let place_m = (floor_from_a * Point3::from(in_a_m)).coords;
                        let of_a = a.member(Part::of_body(joint_a));
                        let of_b = Partner::Of(b.member(Part::of_body(joint_b)));
                        let place = Candidate::new((of_a, of_b), (place_m, normal, point.dist));
                        found.push(place);
                    }
                }
            }
        }
    }
}

/// The largest speed of a point of a chassis, or of a body on its joints, in the step, in m/s.
fn speed_m_s(scene: &Scene<'_>) -> f64 {
    let of_chassis = shapes(scene).filter(|(joint, ..)| joint.is_none());
    let reach_m = of_chassis.map(|(_, shape, pose)| {
        let ball = shape.compute_local_bounding_sphere();
        (pose * ball.center).length() + ball.radius
    });
    let turns_m_s = scene.step.before.angular_rad_s.norm() * reach_m.fold(0.0, f64::max);
    let goes_m_s = scene.step.before.velocity_m_s.norm() + turns_m_s;
    goes_m_s.max(fastest_link_m_s(scene.body, &scene.step.before))
}

/// The shapes of a chassis and of the bodies on its joints, each with its joint and its pose in the
/// chassis's frame.
fn shapes<'a>(
    scene: &Scene<'a>,
) -> impl Iterator<Item = (Option<usize>, &'a SharedShape, Pose)> + use<'a> {
    let chassis_from_body = Isometry3::from(-scene.body.chassis_mass.center_of_mass_m);
    let (center_m, middle) = (scene.body.chassis_mass.center_of_mass_m, &scene.step.middle);
    scene.body.robot.shapes().iter().map(move |of| {
        let chassis_from_carrier = match of.joint {
            None => chassis_from_body,
            joint => middle
                .floor_from_chassis()
                .inv_mul(&middle.carrier(joint, &center_m)),
        };
        let pose = convert::pose(&(chassis_from_carrier * of.carrier_from_shape));
        (of.joint, &of.shape, pose)
    })
}
