//! Figures that are accumulated value by value.

/// A mean, weighted by the time of each value.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mean {
    sum: f64,
    weight: f64,
}

impl Mean {
    pub fn add(&mut self, x: f64) {
        self.add_weighted(x, 1.0);
    }

    pub fn add_weighted(&mut self, x: f64, weight: f64) {
        self.sum += x * weight;
        self.weight += weight;
    }

    /// The mean; `None` without values.
    pub fn get(self) -> Option<f64> {
        (self.weight > 0.0).then(|| self.sum / self.weight)
    }
}

/// A root mean square.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rms(Mean);

impl Rms {
    pub fn add(&mut self, x: f64) {
        self.0.add(x * x);
    }

    pub fn add_weighted(&mut self, x: f64, weight: f64) {
        self.0.add_weighted(x * x, weight);
    }

    /// The root mean square; `None` without values.
    pub fn get(self) -> Option<f64> {
        self.0.get().map(f64::sqrt)
    }
}

/// The largest value.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Largest(Option<f64>);

impl Largest {
    pub fn add(&mut self, x: f64) {
        self.0 = Some(self.0.map_or(x, |largest| largest.max(x)));
    }

    /// The largest value; `None` without values.
    pub fn get(self) -> Option<f64> {
        self.0
    }
}

/// The range of the values.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Extent(Option<(f64, f64)>);

impl Extent {
    pub fn add(&mut self, x: f64) {
        self.0 = Some(
            self.0
                .map_or((x, x), |(low, high)| (low.min(x), high.max(x))),
        );
    }

    /// Largest minus smallest; `None` without values.
    pub fn get(self) -> Option<f64> {
        self.0.map(|(low, high)| high - low)
    }
}
/// The number if it is finite.
pub(crate) fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
