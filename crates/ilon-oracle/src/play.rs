//! Rollers that can slide along their axles.
//!
//! Symbols: p the play from stop to stop, q a roller's place on its axle from the middle of the play, **a** its axis, **F** what the
//! floor does to it, S what the stops do to it along **a**.
//!
//! Along its axle a roller is taken to have no mass: on the floor it goes wherever **a** . **F** + S = 0 holds. Stops are springs with dampers
//! that only push, S = -k_s (x + tau x') at a depth x beyond a stop, k_s the stiffness of the floor's springs and tau their damping over
//! it. **F** falls with q', because friction opposes it and the floor's damper does; S falls with q' as well. So the rate is
//! found between two bounds that are moved apart until they hold it. In the air it falls to its lower end.

/// The play of one roller.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Play {
    /// p / 2, in metres.
    pub half_m: f64,
    /// q, in metres.
    pub place_m: f64,
    /// q' in the air, in m/s.
    pub falls_m_s: f64,
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
    /// S at a place and a rate, in N.
    fn force_n(&self, half_m: f64, place_m: f64, rate_m_s: f64) -> f64 {
        let push_n = |beyond_m: f64, deepening_m_s: f64| {
            let push_n = self.stiffness_n_m * (beyond_m + self.relaxes_s * deepening_m_s);
            if beyond_m > 0.0 { push_n.max(0.0) } else { 0.0 }
        };
        push_n(-half_m - place_m, -rate_m_s) - push_n(place_m - half_m, rate_m_s)
    }
}

impl Play {
    /// Goes through a step of `h` seconds on the floor, which does `along_n`(q') along the axis. Gives the rate q', in m/s, and S, in N.
    pub fn go(&mut self, stops: &Stops, h: f64, along_n: impl Fn(f64) -> f64) -> (f64, f64) {
        /// Halvings: from a metre a second to below what rounding leaves of the forces.
        const HALVINGS: usize = 50;
        let stop_n = |rate: f64| stops.force_n(self.half_m, self.place_m + h * rate, rate);
        let sum_n = |rate: f64| along_n(rate) + stop_n(rate);
        let (mut low, mut high) = (
            (-self.half_m - self.place_m) / h - 1.0,
            (self.half_m - self.place_m) / h + 1.0,
        );
        while sum_n(low) < 0.0 {
            low -= 1.0 + (high - low);
        }
        while sum_n(high) > 0.0 {
            high += 1.0 + (high - low);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            // Where nothing acts, it would have left the floor: back to where it has not.
            let sum = sum_n(middle);
            if sum > 0.0 || sum == 0.0 && middle < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let rate = 0.5 * (low + high);
        self.falls_m_s = 0.0;
        let force_n = stop_n(rate);
        self.place_m += h * rate;
        (rate, force_n)
    }

    /// Falls along its axle through a step of `h` seconds in the air, under this component of gravity, in m/s^2.
    pub fn fall(&mut self, gravity_m_s2: f64, h: f64) {
        self.falls_m_s += gravity_m_s2 * h;
        self.place_m += self.falls_m_s * h;
        if self.place_m.abs() >= self.half_m {
            self.place_m = self.half_m.copysign(self.place_m);
            self.falls_m_s = 0.0;
        }
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
        // 20 N against a viscous 1000 N s/m: 20 mm/s as long as it is free, and 20 um deep in the stop in the end.
        let mut play = Play {
            half_m: 1e-4,
            ..Play::default()
        };
        let pull = |rate: f64| 20.0 - 1000.0 * rate;
        let (rate, force_n) = play.go(&STOPS, 1e-5, pull);
        assert!(
            (rate - 0.02).abs() < 1e-9 && force_n == 0.0,
            "{rate} {force_n}"
        );
        for _ in 0..10_000 {
            play.go(&STOPS, 1e-5, pull);
        }
        assert!((play.place_m - 1.2e-4).abs() < 1e-10, "{}", play.place_m);
        // In the air it falls to the other end: 0.2 mm at 5 m/s^2 take 9 ms.
        (0..1000).for_each(|_| play.fall(-5.0, 1e-5));
        assert_eq!((play.place_m, play.falls_m_s), (-1e-4, 0.0));
    }
}
