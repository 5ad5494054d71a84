//! Readable values of a world as a whole: its time, and its energies.

use nalgebra::Vector3;

use super::{ContactSolution, World};
use crate::robot::articulated::Articulated;
use crate::robot::energy::Energy;

impl World {
    /// Simulated time since the start, in seconds.
    pub fn time_s(&self) -> f64 {
        self.steps as f64 * self.settings.dt_s + self.gone_s
    }

    /// Length of one step, in seconds.
    pub fn dt_s(&self) -> f64 {
        self.settings.dt_s
    }

    /// Largest residual of the laws of contact and of dry friction in the last step, in m/s or
    /// rad/s: the speed of a motion that the laws forbid.
    pub fn contact_residual_m_s(&self) -> f64 {
        self.solution.residual_m_s
    }

    /// How the laws of contact were solved in the last step, and the cost of that.
    pub fn contact_solution(&self) -> ContactSolution {
        self.solution
    }

    /// Energy dissipated by sliding at the contacts since the start, in J. It never falls.
    pub fn slip_energy_j(&self) -> f64 {
        self.energies.slip_j
    }

    /// Energy lost in bringing rollers that came down to their spin since the start, in J. It never
    /// falls.
    pub fn spin_up_energy_j(&self) -> f64 {
        self.energies.spin_up_j
    }

    /// Energy taken by the contacts' normal forces since the start, in J: inelastic impacts, less
    /// the energy returned by pushing rollers out of the ground.
    pub fn impact_energy_j(&self) -> f64 {
        self.energies.impact_j
    }

    /// Work of the motors on the wheels since the start, in J; negative if they braked.
    pub fn motor_energy_j(&self) -> f64 {
        self.energies.motor_j
    }

    /// The positive part of the motors' work since the start, in J: the work while they drove,
    /// without subtracting braking. It never falls.
    pub fn motor_positive_energy_j(&self) -> f64 {
        self.energies.motor_positive_j
    }

    /// Energy dissipated by the bearings of wheels and rollers, and by the gears, since the start,
    /// in J.
    pub fn bearing_energy_j(&self) -> f64 {
        self.energies.bearing_j
    }

    /// The acceleration of gravity in the world frame, in m/s^2: tilted on a slope, because the
    /// world's frame is the floor's.
    pub fn gravity_in_world_m_s2(&self) -> Vector3<f64> {
        self.ground.gravity_in_floor(self.settings.gravity_m_s2)
    }

    /// Current kinetic and potential energy of all bodies.
    pub fn energy(&self) -> Energy {
        let in_contacts_j = self.energies.springs_j + self.energies.treads_j;
        let potential_j = self.potential_j() + (in_contacts_j + self.islands.springs_j());
        Energy {
            kinetic_j: self.kinetic_j(),
            potential_j,
        }
    }

    pub(super) fn kinetic_j(&self) -> f64 {
        let bodies = self.bodies.iter().chain(self.islands.awake());
        let moving_j = bodies.map(Articulated::kinetic_j).sum::<f64>() + self.islands.asleep_j().0;
        match (&self.reference, self.bodies.first()) {
            (Some(reference), Some(robot)) => moving_j + reference.armatures_j(robot),
            _ => moving_j,
        }
    }

    pub(super) fn potential_j(&self) -> f64 {
        let gravity = self.gravity_in_world_m_s2();
        let bodies = self.bodies.iter().chain(self.islands.awake());
        let awake = bodies.map(|body| body.potential_j(&gravity));
        awake.sum::<f64>() + self.islands.asleep_j().1
    }
}
