//! The largest share of a limit at which the simulated robot hardly slides.
//!
//! Sliding grows as some power of the share: about 20 for robots that slide when they are driven
//! hard, less than 1 for those whose wheels strain one another. The next share is where the power
//! through the last two drives would slide what may.

/// Of the motors' work, the share that may be lost to sliding.
pub(crate) const MAY_SLIDE: f64 = 0.005;

/// Times, and shares, that differ by less are the same: one over another.
const SAME: f64 = 1.02;
/// The power where one drive alone is known, and those that are believed.
const POWER: f64 = 5.0;
const POWERS: [f64; 2] = [0.3, 20.0];
/// The largest step down, one share over another, while every drive slides too much.
const DOWN: f64 = 4.0;
/// Of the way between a share that slides too much and one that does not, in logarithms: the least
/// and the most that is gone.
const BETWEEN: [f64; 2] = [0.15, 0.85];

/// A drive at a share of a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drive {
    pub share: f64,
    /// Lost to sliding, of the motors' work.
    pub slid: f64,
    /// How long it takes, in seconds; or what grows as it does.
    pub takes_s: f64,
}

/// A search for the largest share at which no more slides than may; where there is none, for the
/// share at which least slides. It is found to within 2 % of the time that the drive takes.
#[derive(Clone, Debug)]
pub(crate) struct ShareSearch {
    /// The largest share, and the least.
    bounds: [f64; 2],
    within: Option<Drive>,
    beyond: Option<Drive>,
    gentlest: Option<Drive>,
    /// What is known to be small enough, or too small to hold the robot on its slope.
    enough: Option<f64>,
    power: f64,
}

impl ShareSearch {
    /// Up to `most`. What slides at less than `least` does not slide for being driven hard.
    pub fn new(most: f64, least: f64) -> Self {
        Self {
            bounds: [most, least],
            within: None,
            beyond: None,
            gentlest: None,
            enough: None,
            power: POWER,
        }
    }

    /// The share to try next; `None` where the search has ended.
    pub fn next(&self) -> Option<f64> {
        let [most, least] = self.bounds;
        let Some(beyond) = self.beyond else {
            return self.within.is_none().then_some(most);
        };
        let found = (self.within).is_some_and(|within| within.takes_s < SAME * beyond.takes_s);
        let room = libm::log(beyond.share / self.enough.unwrap_or(least));
        if found || room < libm::log(SAME) {
            return None;
        }
        let [shortest, longest] = match self.enough {
            Some(_) => BETWEEN.map(|part| part * room),
            None => [libm::log(SAME), libm::log(DOWN)],
        };
        let down = libm::log(beyond.slid / MAY_SLIDE) / self.power;
        Some(beyond.share * libm::exp(-down.max(shortest).min(longest).min(room)))
    }

    /// Learns what a drive came to.
    pub fn learn(&mut self, now: Drive) {
        if let Some(before) = self.within.or(self.beyond) {
            let through = libm::log(now.slid / before.slid) / libm::log(now.share / before.share);
            if through.is_finite() {
                self.power = through.clamp(POWERS[0], POWERS[1]);
            }
        }
        if self.gentlest.is_none_or(|least| now.slid < least.slid) {
            self.gentlest = Some(now);
        }
        // Limits that are searched at once affect one another: of larger or smaller shares the
        // opposite may have been found before.
        if now.slid <= MAY_SLIDE {
            self.beyond = self.beyond.filter(|beyond| beyond.share > now.share);
            (self.within, self.enough) = (Some(now), Some(now.share));
        } else {
            self.within = self.within.filter(|within| within.share < now.share);
            self.enough = self.enough.filter(|enough| *enough < now.share);
            self.beyond = Some(now);
        }
    }

    /// The share to try after one at which so much slid, or the one that was found. A drive takes
    /// time in inverse proportion to the share.
    pub fn after(&mut self, share: f64, slid: f64) -> f64 {
        let takes_s = 1.0 / share;
        self.learn(Drive {
            share,
            slid,
            takes_s,
        });
        let found = self.found().map(|found| found.share);
        self.next().or(found).unwrap_or(share)
    }

    /// Learns that the robot cannot be driven at a share, as it does not hold it on its slope.
    pub fn learn_too_little(&mut self, share: f64) {
        self.enough = Some(share);
    }

    /// The best of the drives; `None` before the first.
    pub fn found(&self) -> Option<Drive> {
        self.within.or(self.gentlest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two limits that are searched at once, of which each adds a fifth of what slides to the
    /// other: together they end where both are held, within 5 % of where both slide what may. Each
    /// is found to 2 % while the other is where it is.
    #[test]
    fn limits_that_affect_one_another_are_found_together() {
        for power in [3.0, 6.0, 15.0] {
            let largest = [0.45, 0.8];
            let mut searches = [0; 2].map(|_| ShareSearch::new(1.0, 0.3));
            let mut shares = [1.0; 2];
            let slid = |shares: [f64; 2]| {
                let own: [f64; 2] = std::array::from_fn(|at| {
                    MAY_SLIDE / 1.2 * libm::pow(shares[at] / largest[at], power)
                });
                [own[0] + 0.2 * own[1], own[1] + 0.2 * own[0]]
            };
            let mut sprints = 0;
            while sprints < 16 {
                sprints += 1;
                let before = shares;
                for (at, slid) in slid(shares).into_iter().enumerate() {
                    shares[at] = searches[at].after(shares[at], slid);
                }
                if shares == before {
                    break;
                }
            }
            let slid = slid(shares);
            assert!(sprints < 16 && slid.iter().all(|slid| *slid <= MAY_SLIDE));
            for (share, largest) in shares.iter().zip(largest) {
                assert!(share / largest > 0.95, "{power}: {shares:?}");
            }
        }
    }
}
