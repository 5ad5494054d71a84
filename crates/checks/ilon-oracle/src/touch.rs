//! Contact forces on the rollers in a step.

use nalgebra::{Matrix3, Vector3};

use crate::Engine;
use crate::contact::Friction;
use crate::ground::Touch;
use crate::play::Stops;
use crate::settings::Contact;

impl Engine {
    pub(crate) fn add_contacts(&mut self, h: f64) {
        self.contacts.clear();
        let mut touches = Vec::with_capacity(1 + self.plates.len());
        for w in 0..self.tree.wheels.len() {
            for j in self.tree.wheels[w].rollers.clone() {
                touches.clear();
                touches.extend(self.touches(&self.posture, j));
                self.straighten(j, &touches);
                self.slide_on_its_axle((w, j), &touches, h);
                for (piece, touch) in &touches {
                    self.push_roller((w, j), *piece, touch, h);
                }
            }
        }
    }

    /// A massless bristle relaxes at once when it leaves the ground; its energy is lost.
    fn straighten(&mut self, roller: usize, touches: &[(usize, Touch)]) {
        let stiffness_n_m = self.settings.contact.bristle_stiffness_n_m;
        for piece in 0..=self.plates.len() {
            if touches.iter().all(|(touched, _)| *touched != piece) {
                let at = self.bristle_of(piece, roller);
                let bristle = &mut self.bristles[at];
                self.energy.bristles_j += 0.5 * stiffness_n_m * bristle.norm_squared();
                bristle.fill(0.0);
            }
        }
    }

    fn bristle_of(&self, piece: usize, roller: usize) -> usize {
        piece * self.tree.rollers.len() + roller
    }

    /// The velocity of a roller's material at a point in the body frame, in the world frame,
    /// without its sliding along its axle.
    fn held_velocity(&self, (w, j): (usize, usize), point: &Vector3<f64>) -> Vector3<f64> {
        let (hub, c, a) = (
            &self.posture.hubs[w],
            &self.posture.centers[j],
            &self.posture.axes[j],
        );
        self.rotation
            * (self.solution.carried[self.tree.wheels[w].carrier].velocity(point)
                + hub.axis.cross(&(point - hub.middle)) * self.speeds.wheels[w]
                + a.cross(&(point - c)) * self.speeds.rollers[j])
    }

    /// The point of a contact in the body frame.
    fn in_body(&self, touch: &Touch) -> Vector3<f64> {
        self.rotation.inverse() * (touch.point - self.origin)
    }

    /// Moves a roller that has play along its axle.
    fn slide_on_its_axle(&mut self, of: (usize, usize), touches: &[(usize, Touch)], h: f64) {
        let j = of.1;
        let mut play = self.plays[j];
        if play.half_m <= 0.0 {
            return;
        }
        let law = self.settings.contact;
        let stops = Stops {
            stiffness_n_m: law.normal_stiffness_n_m,
            relaxes_s: law.normal_damping_n_s_m / law.normal_stiffness_n_m,
        };
        let axis = self.rotation * self.posture.axes[j];
        let held: Vec<_> = touches
            .iter()
            .map(|(_, touch)| self.held_velocity(of, &self.in_body(touch)))
            .collect();
        let work_j = play.go(&stops, h, axis.dot(&self.settings.gravity_m_s2), |rate| {
            let on_each = touches.iter().zip(&held).map(|((piece, touch), held)| {
                let velocity = touch.world_from_ground.transpose() * (held + rate * axis);
                let normal_n = law.normal_n(touch.depth_m, -velocity.z);
                let mut bristle = self.bristles[self.bristle_of(*piece, j)];
                let friction = law.bend(&mut bristle, velocity.xy(), normal_n, h);
                axis.dot(&in_world(&touch.world_from_ground, &friction, normal_n))
            });
            on_each.sum()
        });
        self.energy.roller_bearings_j -= work_j;
        self.plays[j] = play;
    }

    /// Adds the force of a piece of ground on a roller.
    fn push_roller(&mut self, (w, j): (usize, usize), piece: usize, touch: &Touch, h: f64) {
        let law = self.settings.contact;
        let point = self.in_body(touch);
        let mut held = self.held_velocity((w, j), &point);
        if self.plays[j].half_m > 0.0 {
            held += self.plays[j].rate_m_s * (self.rotation * self.posture.axes[j]);
        }
        let velocity = touch.world_from_ground.transpose() * held;
        let normal_n = law.normal_n(touch.depth_m, -velocity.z);
        let bristle = self.bristle_of(piece, j);
        let friction = law.bend(&mut self.bristles[bristle], velocity.xy(), normal_n, h);
        let damper_n = normal_n - law.normal_stiffness_n_m * touch.depth_m;
        self.energy.normals_j += damper_n * -velocity.z * h;
        self.energy.slip_j += friction.slip_j;
        self.energy.bristles_j += friction.damping_j;

        let force =
            self.rotation.inverse() * in_world(&touch.world_from_ground, &friction, normal_n);
        let forces = &mut self.solution.forces;
        forces.act_on_wheel(&self.tree, &self.posture, w, &point, &force);
        let (a, c) = (&self.posture.axes[j], &self.posture.centers[j]);
        forces.rollers[j] += a.dot(&(point - c).cross(&force));
        self.contacts.push(Contact {
            wheel: w,
            roller: j,
            point_in_body_m: point,
            normal_in_world: touch.world_from_ground.column(2).into(),
            normal_n,
            friction_n: friction.force,
            velocity_m_s: velocity.xy(),
            slides: friction.slides,
        });
    }
}

fn in_world(world_from_ground: &Matrix3<f64>, friction: &Friction, normal_n: f64) -> Vector3<f64> {
    world_from_ground * Vector3::new(friction.force.x, friction.force.y, normal_n)
}
