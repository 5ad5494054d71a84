//! The energy balance.

/// Work and heat since the start, and stored energy, in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy of all bodies.
    pub kinetic_j: f64,
    /// Potential energy in gravity, relative to the world's origin.
    pub gravity_j: f64,
    /// Stored in contact springs and bristles.
    pub elastic_j: f64,
    /// Stored in joints: springs, stops, couplings and the bristles of their dry friction.
    pub joint_springs_j: f64,
    /// Work of the wheels' drives.
    pub drives_j: f64,
    /// Work of the push.
    pub push_j: f64,
    /// Heat of sliding contacts.
    pub slip_j: f64,
    /// Heat of the bristles' damping, and energy of bristles that left the floor.
    pub bristles_j: f64,
    /// Heat of the damping along contact normals.
    pub normals_j: f64,
    /// Heat of wheel bearings.
    pub wheel_bearings_j: f64,
    /// Heat of roller bearings.
    pub roller_bearings_j: f64,
    /// Heat of joints between bodies: damping, dry friction, stops and couplings.
    pub joints_j: f64,
    /// Heat of wheels and rollers at the moment of locking.
    pub locking_j: f64,
}

impl Energy {
    /// Energy dissipated by all contacts: sliding and damping.
    pub fn contacts_j(&self) -> f64 {
        self.slip_j + self.bristles_j + self.normals_j
    }

    /// Stored energy and heat less work: constant, except for the integration error.
    pub fn balance_j(&self) -> f64 {
        let stored = self.kinetic_j + self.gravity_j + self.elastic_j + self.joint_springs_j;
        let bearings_j = self.wheel_bearings_j + self.roller_bearings_j;
        let heat = self.contacts_j() + bearings_j + self.joints_j + self.locking_j;
        stored + heat - self.drives_j - self.push_j
    }
}
