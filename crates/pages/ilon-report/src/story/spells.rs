//! Unbroken times in which something held.

/// Spells of the same kind that are nearer to each other than this are one.
pub(super) const GAP_S: f64 = 0.2;

/// An unbroken time in which something held.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spell {
    pub from_s: f64,
    pub until_s: f64,
    /// Sum over the rows of what was given.
    pub sum: f64,
    pub largest: f64,
    /// A counter of energy where it began, and now.
    pub energy_j: [f64; 2],
}

/// Joins rows into spells.
#[derive(Clone, Debug, Default)]
pub(super) struct Spells {
    pub found: Vec<Spell>,
}

impl Spells {
    /// Adds a row in which it held, with a value that stands for a period.
    pub fn add(&mut self, t_s: f64, period_s: f64, value: f64, energy_j: [f64; 2]) {
        match self.found.last_mut() {
            Some(last) if t_s - last.until_s <= GAP_S => {
                last.until_s = t_s;
                last.sum += value * period_s;
                last.largest = last.largest.max(value);
                last.energy_j[1] = energy_j[1];
            }
            _ => self.found.push(Spell {
                from_s: (t_s - period_s).max(0.0),
                until_s: t_s,
                sum: value * period_s,
                largest: value,
                energy_j,
            }),
        }
    }
}
