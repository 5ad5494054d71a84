//! Uninterrupted time spans of a condition.

/// Spans of the same kind closer than this are joined, in seconds.
pub(super) const GAP_S: f64 = 0.2;

/// An uninterrupted time span of a condition.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spell {
    pub from_s: f64,
    pub until_s: f64,
    /// Integral of the given value over time.
    pub sum: f64,
    pub largest: f64,
    /// The energy of its rows.
    pub energy_j: f64,
}

/// Joins rows into spans.
#[derive(Clone, Debug, Default)]
pub(super) struct Spells {
    pub found: Vec<Spell>,
}

impl Spells {
    /// Adds a row that fulfils the condition, with a value's mean over a period and its
    /// largest, and its energy.
    pub fn add(&mut self, t_s: f64, period_s: f64, [value, largest]: [f64; 2], energy_j: f64) {
        match self.found.last_mut() {
            Some(last) if t_s - last.until_s <= GAP_S => {
                last.until_s = t_s;
                last.sum += value * period_s;
                last.largest = last.largest.max(largest);
                last.energy_j += energy_j;
            }
            _ => self.found.push(Spell {
                from_s: (t_s - period_s).max(0.0),
                until_s: t_s,
                sum: value * period_s,
                largest,
                energy_j,
            }),
        }
    }
}
