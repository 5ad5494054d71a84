//! Losses only lose: what friction takes over the steps.
//!
//! Friction's law holds for the velocity u_1 at the end of a step, its impulse p acts over the whole of it, and what it takes is exactly
//! -p (u_0 + u_1) / 2. Where the velocity turns around within the step, p pulls along u_0 all the while, and the step's friction gives energy
//! that the friction of the next steps takes again: with a steady limit c the sum over steps of c (|u_1| + u_0 sgn u_1) / 2 is never below
//! -c |u_0| / 2 of the first. Contacts that hold give and take in the same way, from wheel to wheel, while their loads swing.
//!
//! So what a step's friction gave is no loss of any kind. It is owed: later friction takes it back before anything is lost, and what is still owed
//! in the end is the step's own gain, which no account explains.

/// What friction of one kind gave in earlier steps and still owes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Owed {
    owed_j: f64,
}

impl Owed {
    /// What is lost where friction took so much in a step, in J: never negative.
    pub fn lost_j(&mut self, taken_j: f64) -> f64 {
        let owed_j = self.owed_j - taken_j;
        self.owed_j = owed_j.max(0.0);
        (-owed_j).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block under a limit c that is shaken to and fro takes c |u| / 2 less than its steps give and take: +u, -u, +u, ... give nothing, and then it comes
    /// to rest.
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
