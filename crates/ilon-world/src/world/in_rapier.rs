//! One step of the reference mode, in which rapier moves everything.

use super::World;

impl World {
    /// Advances the world by a time, with contacts that rapier solves.
    pub(super) fn advance_in_rapier(&mut self, dt_s: f64) {
        let mut found = Vec::new();
        for (index, body) in self.bodies.iter_mut().enumerate() {
            // There is one for every body of such a world.
            if let Some(mut reference) = body.reference.take() {
                reference.step(body, &self.ground, dt_s);
                reference.read_reactions(body, index, &mut found);
                body.reference = Some(reference);
            }
        }
        self.reactions.take(found);
        self.count_motors(dt_s);
        self.read_contacts(dt_s);
        for body in &self.bodies {
            let lost_j = body
                .reference
                .as_ref()
                .map(|of| of.joints_lost_j(body, dt_s));
            self.energies.bearing_j += lost_j.unwrap_or(0.0);
            self.energies.outside_j += body.pushes_did_j(dt_s);
        }
    }
}
