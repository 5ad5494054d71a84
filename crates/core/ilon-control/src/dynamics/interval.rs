//! The interval of a line on which constraints hold that are linear or conic along it.

/// A number that is linear in a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Value at parameter 0.
    pub at_zero: f64,
    /// Increase per unit of the parameter.
    pub slope: f64,
}

impl Line {
    /// The line with these values at 0 and at `step`.
    pub fn through(at_zero: f64, at_step: f64, step: f64) -> Self {
        Self {
            at_zero,
            slope: (at_step - at_zero) / step,
        }
    }

    fn at(self, x: f64) -> f64 {
        self.at_zero + self.slope * x
    }
}

/// The remaining interval of a line, and the constraint at each end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval<T> {
    pub low: f64,
    pub high: f64,
    pub holds_low: T,
    pub holds_high: T,
}

impl<T: Copy> Interval<T> {
    /// The whole interval up to a size, with placeholders as constraints.
    pub fn within(size: f64, nothing: T) -> Self {
        Self {
            low: -size,
            high: size,
            holds_low: nothing,
            holds_high: nothing,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.low > self.high
    }

    fn cut_low(&mut self, low: f64, by: T) {
        if low > self.low {
            (self.low, self.holds_low) = (low, by);
        }
    }

    fn cut_high(&mut self, high: f64, by: T) {
        if high < self.high {
            (self.high, self.holds_high) = (high, by);
        }
    }

    fn clear(&mut self, by: T) {
        *self = Self {
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            holds_low: by,
            holds_high: by,
        };
    }

    /// Keeps the part where `line` >= 0.
    pub fn keep_positive(&mut self, line: Line, by: T) {
        let root = -line.at_zero / line.slope;
        if line.slope > 0.0 {
            self.cut_low(root, by);
        } else if line.slope < 0.0 {
            self.cut_high(root, by);
        } else if line.at_zero < 0.0 {
            self.clear(by);
        }
    }

    /// Keeps the part where the length of (`x`, `y`) is at most `radius`: one interval, because the
    /// cone is convex.
    pub fn keep_in_cone(&mut self, [x, y]: [Line; 2], radius: Line, by: T) {
        self.keep_positive(radius, by);
        // a p^2 + 2 b p + c <= 0.
        let a = x.slope * x.slope + y.slope * y.slope - radius.slope * radius.slope;
        let b = x.at_zero * x.slope + y.at_zero * y.slope - radius.at_zero * radius.slope;
        let c = x.at_zero * x.at_zero + y.at_zero * y.at_zero - radius.at_zero * radius.at_zero;
        let of_size = x.slope * x.slope + y.slope * y.slope + radius.slope * radius.slope;
        if a.abs() <= 1e-14 * of_size {
            return self.keep_positive(
                Line {
                    at_zero: -c,
                    slope: -2.0 * b,
                },
                by,
            );
        }
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            // Either the whole line is outside, or it never is if the radius grows fastest.
            if a > 0.0 {
                self.clear(by);
            }
            return;
        }
        // The root without cancellation; the other follows from the product of the roots.
        let far = -(b + libm::copysign(libm::sqrt(discriminant), b)) / a;
        let near = if far == 0.0 { 0.0 } else { c / (a * far) };
        let (first, last) = (far.min(near), far.max(near));
        if a > 0.0 {
            self.cut_low(first, by);
            self.cut_high(last, by);
        } else if radius.at(last) - radius.at(first) >= 0.0 {
            self.cut_low(last, by);
        } else {
            self.cut_high(first, by);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(at_zero: f64, slope: f64) -> Line {
        Line { at_zero, slope }
    }

    /// Compares with sampling many points, for pseudo-random lines.
    #[test]
    fn a_cone_keeps_the_places_that_lie_in_it() {
        let mut seed = 3_u64;
        let mut noise = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut kept = 0;
        for round in 0..2000 {
            let mut any = || line(noise(), noise());
            let (x, mut y, radius) = (any(), any(), any());
            if round % 3 == 0 {
                y = line(0.0, 0.0);
            }
            let mut interval = Interval::within(20.0, 0);
            interval.keep_in_cone([x, y], radius, 1);
            for k in -2000..=2000 {
                let p = 0.01 * f64::from(k);
                let excess = libm::hypot(x.at(p), y.at(p)) - radius.at(p);
                let inside = interval.low <= p && p <= interval.high;
                if excess.abs() > 1e-6 {
                    assert_eq!(inside, excess < 0.0, "{x:?} {y:?} {radius:?} at {p}");
                }
                kept += usize::from(inside);
            }
        }
        assert!(kept > 100_000, "{kept}");
    }

    #[test]
    fn what_holds_an_end_is_the_last_that_cut_it() {
        let mut interval = Interval::within(10.0, 'n');
        interval.keep_positive(line(1.0, 1.0), 'a');
        interval.keep_positive(line(3.0, -1.0), 'b');
        interval.keep_positive(line(5.0, -1.0), 'c');
        assert_eq!((interval.low, interval.high), (-1.0, 3.0));
        assert_eq!((interval.holds_low, interval.holds_high), ('a', 'b'));
        interval.keep_positive(line(-1.0, 0.0), 'd');
        assert!(interval.is_empty());
    }
}
