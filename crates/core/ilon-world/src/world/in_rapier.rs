//! One step of the reference mode, in which rapier moves everything.

use super::World;

impl World {
    /// Advances the world by a time, with rapier solving the contacts.
    pub(super) fn advance_in_rapier(&mut self, dt_s: f64) {
        // Such a world has one robot and no other moving bodies.
        let (Some(reference), [robot]) = (&mut self.reference, &mut self.bodies[..]) else {
            return;
        };
        reference.step(robot, &self.ground, dt_s);
        let took_j = reference.joints_lost_j(robot, dt_s);
        self.reactions.take(reference.reactions(robot));
        self.count_motors(dt_s);
        self.read_contacts(dt_s);
        self.energies.bearing_j += self.bodies[0].memory.bearings_owe.lost_j(took_j);
        self.energies.outside_j += self.bodies[0].pushes_did_j(dt_s);
    }
}
