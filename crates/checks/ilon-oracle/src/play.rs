//! Rollers that can slide along their axles.
//!
//! Symbols: p the play from stop to stop, q a roller's position on its axle from the middle of the
//! play, **a** its axis, m its mass, **g** gravity, **F** the floor's force on it, S the stops'
//! force along **a**. On the floor and in the air
//!
//! ```text
//! m q'' = a . F + S + m a . g
//! ```
//!
//! Stops are springs with dampers that only push, S = -k_s (x + tau x') at a depth x beyond a stop,
//! with k_s the stiffness of the floor's springs and tau their damping over it. A step is implicit
//! in q': **F** and S depend on the unknown rate. **F** may rise with it if the axle is tilted and
//! friction is at its limit, but by less than m / h in steps of microseconds. So there is one
//! solution, between two bounds that are widened until they bracket it. The effects of the hub's
//! own acceleration on q, and of m q'' on the hub, are neglected.

/// The play of one roller.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Play {
    /// p / 2, in metres.
    pub half_m: f64,
    /// q, in metres.
    pub place_m: f64,
    /// q', in m/s.
    pub rate_m_s: f64,
    /// m, in kg.
    pub mass_kg: f64,
}

/// The stops of a roller.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stops {
    /// k_s, in N/m.
    pub stiffness_n_m: f64,
    /// tau, in seconds.
    pub relaxes_s: f64,
}

impl Stops {
    /// S at a position and a rate, in N.
    fn force_n(&self, half_m: f64, place_m: f64, rate_m_s: f64) -> f64 {
        let push_n = |beyond_m: f64, deepening_m_s: f64| {
            let push_n = self.stiffness_n_m * (beyond_m + self.relaxes_s * deepening_m_s);
            if beyond_m > 0.0 { push_n.max(0.0) } else { 0.0 }
        };
        push_n(-half_m - place_m, -rate_m_s) - push_n(place_m - half_m, rate_m_s)
    }
}

impl Play {
    /// Takes a step of `h` seconds on the floor, whose force along the axis is `along_n`(q'), under
    /// the component `gravity_m_s2` of gravity. Returns the work of the stops, in J.
    pub fn go(
        &mut self,
        stops: &Stops,
        h: f64,
        gravity_m_s2: f64,
        along_n: impl Fn(f64) -> f64,
    ) -> f64 {
        /// Bisections: from 1 m/s to below the rounding of the forces.
        const HALVINGS: usize = 50;
        let before = self.rate_m_s + gravity_m_s2 * h;
        let stop_n = |rate: f64| stops.force_n(self.half_m, self.place_m + h * rate, rate);
        let left_n = |rate: f64| along_n(rate) + stop_n(rate) - self.mass_kg * (rate - before) / h;
        let (mut low, mut high) = (before - 0.01, before + 0.01);
        while left_n(low) < 0.0 {
            low -= high - low;
        }
        while left_n(high) > 0.0 {
            high += high - low;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if left_n(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.rate_m_s = 0.5 * (low + high);
        let work_j = stop_n(self.rate_m_s) * self.rate_m_s * h;
        self.place_m += h * self.rate_m_s;
        work_j
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STOPS: Stops = Stops {
        stiffness_n_m: 1e6,
        relaxes_s: 1e-3,
    };

    #[test]
    fn what_pulls_on_a_roller_takes_it_to_a_stop_and_presses_it_in_there() {
        // 20 N against a viscous 1000 N s/m: 20 mm/s while free, and finally 20 um deep in the
        // stop.
        let mut play = Play {
            half_m: 1e-4,
            mass_kg: 0.01,
            ..Play::default()
        };
        let pull = |rate: f64| 20.0 - 1000.0 * rate;
        // m / c is 10 us.
        (0..20).for_each(|_| {
            play.go(&STOPS, 1e-5, 0.0, pull);
        });
        assert!((play.rate_m_s - 0.02).abs() < 1e-6, "{}", play.rate_m_s);
        for _ in 0..10_000 {
            play.go(&STOPS, 1e-5, 0.0, pull);
        }
        assert!((play.place_m - 1.2e-4).abs() < 1e-10, "{}", play.place_m);
    }

    #[test]
    fn in_the_air_a_roller_falls_to_its_other_end() {
        let mut play = Play {
            half_m: 1e-4,
            place_m: 1e-4,
            mass_kg: 0.01,
            ..Play::default()
        };
        // 0.2 mm at 5 m/s^2 take 8.94 ms.
        let mut steps = 0;
        while play.place_m > -1e-4 {
            play.go(&STOPS, 1e-5, -5.0, |_| 0.0);
            steps += 1;
        }
        assert!((890..900).contains(&steps), "{steps}");
        (0..10_000).for_each(|_| {
            play.go(&STOPS, 1e-5, -5.0, |_| 0.0);
        });
        // Its weight of 0.05 N presses it 0.05 um deep.
        assert!(
            (play.place_m + 1e-4 + 5e-8).abs() < 1e-12,
            "{}",
            play.place_m
        );
    }
}
