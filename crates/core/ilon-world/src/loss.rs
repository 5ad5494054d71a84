//! Friction losses that never become negative over several steps.
//!
//! Friction's law holds for the velocity u_1 at the end of a step, its impulse p acts over the
//! whole step, and the energy that it takes is exactly -p (u_0 + u_1) / 2. If the velocity reverses
//! within the step, p acts along u_0 for a while, and the step's friction adds energy, which the
//! friction of the next steps takes again: with a constant limit c the sum over steps of c (|u_1| +
//! u_0 sgn u_1) / 2 is never below -c |u_0| / 2 of the first. Sticking contacts exchange energy
//! between wheels in the same way while their loads oscillate.
//!
//! So energy added by a step's friction is not a loss of any kind. It is a debt: later friction
//! repays it before anything counts as lost, and the remaining debt at the end is an error of the
//! step, which no account explains.

/// The energy that friction of one kind added in earlier steps and has not taken back yet.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Owed {
    owed_j: f64,
}

impl Owed {
    /// The loss if friction took this energy in a step, in J: never negative.
    pub fn lost_j(&mut self, taken_j: f64) -> f64 {
        let owed_j = self.owed_j - taken_j;
        self.owed_j = owed_j.max(0.0);
        (-owed_j).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block under a limit c that is shaken to and fro takes c |u| / 2 less than the sum over its
    /// steps: +u, -u, +u, ... add nothing, and then it comes to rest.
    #[test]
    fn what_friction_gave_is_taken_back_before_anything_is_lost() {
        let mut owed = Owed::default();
        let (limit, mut speed, mut lost_j, mut taken_j) = (0.3, 0.0_f64, 0.0, 0.0);
        for now in [0.2, -0.1, 0.1, -0.1, 0.1, 0.05, 0.0_f64] {
            let took_j = 0.5 * limit * (now.abs() + speed * now.signum());
            taken_j += took_j;
            let lost_now_j = owed.lost_j(took_j);
            assert!(lost_now_j >= 0.0);
            lost_j += lost_now_j;
            speed = now;
        }
        assert!(owed.owed_j <= 0.5 * limit * 0.2);
        assert!((lost_j - owed.owed_j - taken_j).abs() < 1e-15);
    }
}
