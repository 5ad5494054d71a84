//! The ripple of wheels and body at the roller frequency in a drive.
//!
//! Over a window of steady drive the angle of a wheel is regressed on 1, t, t^2 and on cosine and
//! sine of k times its mean angle, and the body's position along its direction on the same for all
//! its wheels' rates. k at the number of rollers gives their line; k well away from it gives the
//! background, which is subtracted. Rows that a log lost shift the line up, by the share that was
//! lost, and smear it, so power is summed over a band about it: a pure wave over X turns has the
//! power sinc^2(X (k - k_0)), whose integral is 1 / X.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Matrix3xX};

use crate::log::Log;
use crate::motion::{largest_size, twist_of};

/// Range of orders searched, over the number of rollers.
const FROM: f64 = 0.75;
const TO: f64 = 1.5;
const STEP: f64 = 0.0125;
/// Largest shift of the line: a log that lost more than a sixth of its rows cannot be used.
const LINE: (f64, f64) = (0.98, 1.2);
/// Half the band over which a line is summed, over the number of rollers.
const BAND: f64 = 0.12;
/// Orders further away than this are background.
const BACKGROUND: f64 = 0.15;
/// In a steady window the rates of the two halves differ by less than this share of the fastest.
const STEADY: f64 = 0.05;
/// Smallest number of rows of a window.
const LEAST_ROWS: usize = 16;
/// Wheels slower than this share of the fastest pass too few rollers.
const SLOW: f64 = 0.2;

/// Ripple of wheels and body at the roller frequency, over steady windows of one drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ripple {
    /// Number of windows.
    pub stretches: usize,
    /// Rollers passed per turn of the wheel in the log's count, over the wheel's number of rollers:
    /// more than 1 if rows were lost.
    pub line: f64,
    /// Amplitude of the wheels' rates, root mean square over wheels and stretches, and its standard
    /// error, in rad/s.
    pub wheels_rad_s: [f64; 2],
    /// Amplitude of the body's position along its direction, root mean square over windows, and its
    /// standard error, in metres.
    pub body_m: [f64; 2],
}

/// How windows are taken from a drive.
#[derive(Clone, Copy, Debug)]
pub struct Stretches<'a> {
    /// Duration of each, in seconds.
    pub length_s: f64,
    /// Mean wheel rates of the drive, in rad/s.
    pub rates_rad_s: &'a [f64],
    /// Windows whose rates differ from the drive's by more than this share of the fastest belong to
    /// another drive.
    pub alike: f64,
}

impl Stretches<'_> {
    /// Whether a log is long enough for a window, and its rows dense enough.
    pub fn fit(&self, log: &Log) -> bool {
        let rows = self.rows(log);
        rows >= LEAST_ROWS && rows < log.len()
    }

    fn rows(&self, log: &Log) -> usize {
        (self.length_s / log.period_s()).round() as usize
    }
}

/// One window: rows, mean wheel rates in rad/s, wheel angles and the position along the direction
/// of motion.
struct SteadyStretch {
    times_s: Vec<f64>,
    rates_rad_s: Vec<f64>,
    angles_rad: Vec<Vec<f64>>,
    way_m: Vec<f64>,
}

/// Returns the ripple in a log, if it has a steady window of that drive. For short windows the band
/// misses a twentieth of a line's power; both compared logs are treated alike.
pub fn ripple(
    log: &Log,
    rollers: usize,
    nominal: &Matrix3xX<f64>,
    stretches: &Stretches<'_>,
) -> Option<Ripple> {
    let found = steady(log, nominal, stretches);
    if found.is_empty() || rollers == 0 {
        return None;
    }
    let count = found.len();
    let n = rollers as f64;
    let orders: Vec<f64> = (0..=((TO - FROM) / STEP) as usize)
        .map(|step| FROM + step as f64 * STEP)
        .collect();
    let powers: Vec<Vec<Power>> = found
        .iter()
        .map(|stretch| orders.iter().map(|k| stretch.power(k * n)).collect())
        .collect();
    let height = |place: usize| powers.iter().map(|of| of[place].wheels).sum::<f64>();
    let line = (0..orders.len())
        .filter(|place| orders[*place] >= LINE.0 && orders[*place] <= LINE.1)
        .max_by(|a, b| height(*a).total_cmp(&height(*b)))?;
    let line = orders[line];
    let far: Vec<usize> = (0..orders.len())
        .filter(|place| (orders[*place] - line).abs() > BACKGROUND)
        .collect();
    let near: Vec<usize> = (0..orders.len())
        .filter(|place| (orders[*place] - line).abs() < BAND)
        .collect();
    // The power of the line of each window: over the band, less the common background, in turns of
    // the wheel.
    let of = |density: &dyn Fn(&Power) -> f64| -> [f64; 2] {
        let mean = |place: usize| powers.iter().map(|of| density(&of[place])).sum::<f64>();
        let mut background: Vec<f64> = far
            .iter()
            .map(|place| mean(*place) / count as f64)
            .collect();
        let background = crate::log::middle(&mut background);
        let lines: Vec<f64> = powers
            .iter()
            .map(|of| {
                let above = near.iter().map(|place| density(&of[*place]) - background);
                above.sum::<f64>() * STEP * n
            })
            .collect();
        amplitude(&lines)
    };
    Some(Ripple {
        stretches: count,
        line,
        wheels_rad_s: of(&|power| power.wheels_density),
        body_m: of(&|power| power.body_density),
    })
}

/// Returns the amplitude whose square is the mean of powers, and its standard error; the powers are
/// of windows that overlap by half.
fn amplitude(powers: &[f64]) -> [f64; 2] {
    let count = powers.len() as f64;
    let mean = powers.iter().sum::<f64>() / count;
    let squares: f64 = powers.iter().map(|power| (power - mean).powi(2)).sum();
    let apart = (0.5 * count).max(1.0);
    let error = match powers.len() {
        1 => mean.abs(),
        _ => (squares / (count - 1.0) / apart).sqrt(),
    };
    let amplitude = mean.max(0.0).sqrt();
    // Half the error of the square over the amplitude, and its root if the amplitude is zero.
    let of_amplitude = error / (amplitude + (amplitude * amplitude + error).sqrt());
    [amplitude, if error > 0.0 { of_amplitude } else { 0.0 }]
}

/// The squared amplitude of the wheels at an order, and those of wheels and body times the observed
/// turns.
#[derive(Clone, Copy, Debug, Default)]
struct Power {
    wheels: f64,
    wheels_density: f64,
    body_density: f64,
}

impl SteadyStretch {
    /// Returns the distinct rates of its wheels: wheels with equal rates have equal ripple
    /// frequencies.
    fn groups(&self) -> Vec<f64> {
        let fastest = self.fastest();
        let mut groups: Vec<f64> = Vec::new();
        for rate in self.rates_rad_s.iter().map(|rate| rate.abs()) {
            let is_new = groups.iter().all(|of| (of - rate).abs() > 0.06 * fastest);
            if is_new && rate > SLOW * fastest {
                groups.push(rate);
            }
        }
        groups
    }

    fn fastest(&self) -> f64 {
        let sizes = self.rates_rad_s.iter().map(|rate| rate.abs());
        sizes.fold(0.0, f64::max)
    }

    fn power(&self, order: f64) -> Power {
        let mut power = Power::default();
        let (fastest, length_s) = (self.fastest(), self.times_s[self.times_s.len() - 1]);
        let moving: Vec<usize> = (0..self.rates_rad_s.len())
            .filter(|wheel| self.rates_rad_s[*wheel].abs() > SLOW * fastest)
            .collect();
        for wheel in &moving {
            let rate = self.rates_rad_s[*wheel].abs();
            for squared in waves(&self.times_s, &self.angles_rad[*wheel], &[order * rate]) {
                let of_rate = squared * (order * rate).powi(2) / moving.len() as f64;
                power.wheels += of_rate;
                power.wheels_density += of_rate * rate * length_s / TAU;
            }
        }
        let groups = self.groups();
        let waves_rad_s: Vec<f64> = groups.iter().map(|rate| order * rate).collect();
        for (squared, rate) in waves(&self.times_s, &self.way_m, &waves_rad_s)
            .iter()
            .zip(&groups)
        {
            power.body_density += squared * rate * length_s / TAU;
        }
        power
    }
}

/// Returns the squared amplitude of each angular frequency in values, fitted together with a
/// parabola.
fn waves(times_s: &[f64], values: &[f64], frequencies_rad_s: &[f64]) -> Vec<f64> {
    let rows = times_s.len();
    let columns = 3 + 2 * frequencies_rad_s.len();
    let middle_s = 0.5 * times_s[rows - 1];
    let equations = DMatrix::from_fn(rows, columns, |row, column| {
        let t = (times_s[row] - middle_s) / middle_s;
        match column {
            0 => 1.0,
            1 => t,
            2 => t * t,
            _ => {
                let angle = frequencies_rad_s[(column - 3) / 2] * (times_s[row] - middle_s);
                let (s, c) = libm::sincos(angle);
                if (column - 3).is_multiple_of(2) { c } else { s }
            }
        }
    });
    let transposed = equations.transpose();
    let Some(factor) = (&transposed * &equations).cholesky() else {
        return vec![0.0; frequencies_rad_s.len()];
    };
    let found = factor.solve(&(&transposed * DVector::from_column_slice(values)));
    (0..frequencies_rad_s.len())
        .map(|wave| found[3 + 2 * wave].powi(2) + found[4 + 2 * wave].powi(2))
        .collect()
}

/// Returns the steady windows of a drive, each overlapping the next by half.
fn steady(log: &Log, nominal: &Matrix3xX<f64>, wanted: &Stretches<'_>) -> Vec<SteadyStretch> {
    let rows = wanted.rows(log);
    let mut found = Vec::new();
    if !wanted.fit(log) {
        return found;
    }
    let fastest = largest_size(wanted.rates_rad_s);
    let differ = |a: &[f64], b: &[f64]| {
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    };
    let mut first = 0;
    while first + rows < log.len() {
        let last = first + rows;
        let rates = |from: usize, to: usize| -> Vec<f64> {
            let time_s = log.times_s[to] - log.times_s[from];
            let turned = log.angles_rad[to].iter().zip(&log.angles_rad[from]);
            turned.map(|(to, from)| (to - from) / time_s).collect()
        };
        let half = first + rows / 2;
        let rates_rad_s = rates(first, last);
        let length_s = log.times_s[last] - log.times_s[first];
        let is_whole = length_s < 1.1 * wanted.length_s
            && !log.unseen[first..=last].iter().any(|unseen| *unseen);
        let is_steady = differ(&rates(first, half), &rates(half, last)) < STEADY * fastest;
        if is_whole
            && is_steady
            && differ(&rates_rad_s, wanted.rates_rad_s) < wanted.alike * fastest
        {
            found.push(stretch(log, nominal, rates_rad_s, first, last));
        }
        first += (rows / 2).max(1);
    }
    found
}

fn stretch(
    log: &Log,
    nominal: &Matrix3xX<f64>,
    rates_rad_s: Vec<f64>,
    first: usize,
    last: usize,
) -> SteadyStretch {
    let asked = twist_of(nominal, &rates_rad_s);
    let size = libm::hypot(asked[0], asked[1]).max(f64::MIN_POSITIVE);
    let mut way_m = vec![0.0];
    for row in first..last {
        let (from, to) = (log.poses[row], log.poses[row + 1]);
        let (s, c) = libm::sincos(0.5 * (from[2] + to[2]));
        let (x_m, y_m) = (to[0] - from[0], to[1] - from[1]);
        let ahead = (c * x_m + s * y_m) * asked[0] + (c * y_m - s * x_m) * asked[1];
        way_m.push(way_m[way_m.len() - 1] + ahead / size);
    }
    let wheels = rates_rad_s.len();
    SteadyStretch {
        times_s: log.times_s[first..=last]
            .iter()
            .map(|t_s| t_s - log.times_s[first])
            .collect(),
        angles_rad: (0..wheels)
            .map(|wheel| {
                let rows = log.angles_rad[first..=last].iter();
                rows.map(|row| row[wheel] - log.angles_rad[first][wheel])
                    .collect()
            })
            .collect(),
        rates_rad_s,
        way_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four wheels at two rates with eight rollers each; the wheels have a ripple of 0.05 rad/s,
    /// the body 0.2 mm with each pair. Noise of 0.1 mm.
    fn log(lost: f64) -> Log {
        let mut log = Log::default();
        let (slow, fast) = (1.5, 3.0);
        let noise = |row: usize, salt: f64| libm::sin(row as f64 * salt).mul_add(1e-4, 0.0);
        let mut row = 0;
        let mut angles = [0.0; 4];
        let mut last: Option<[f64; 4]> = None;
        for step in 0..6000 {
            let t_s = 0.01 * f64::from(step);
            let wave = |rate: f64, phase: f64| libm::sin(8.0 * rate * t_s + phase);
            let of = |rate: f64, phase: f64| rate * t_s + 0.05 / (8.0 * rate) * wave(rate, phase);
            let now = [of(slow, 0.3), of(fast, 1.1), of(slow, 2.0), of(fast, 2.9)];
            // Rows are lost evenly, with the rotation in them.
            let is_lost = (f64::from(step) * lost).fract() + lost >= 1.0;
            if let Some(last) = last
                && !is_lost
            {
                (0..4).for_each(|wheel| angles[wheel] += now[wheel] - last[wheel]);
            }
            last = Some(now);
            if is_lost || step % 4 != 0 {
                continue;
            }
            let along = 0.05 * t_s + 2e-4 * (wave(slow, 0.7) + wave(fast, 0.2));
            log.times_s.push(0.04 * row as f64);
            log.angles_rad.push(angles.to_vec());
            log.poses
                .push([along + noise(row, 91.7), noise(row, 53.3), 0.0]);
            log.unseen.push(false);
            row += 1;
        }
        log
    }

    fn nominal() -> Matrix3xX<f64> {
        Matrix3xX::from_columns(&[nalgebra::Vector3::new(0.0075, 0.0, 0.0); 4])
    }

    #[test]
    fn waves_of_known_size_are_found_under_noise() {
        let stretches = Stretches {
            length_s: 4.0,
            rates_rad_s: &[1.5, 3.0, 1.5, 3.0],
            alike: 0.06,
        };
        let found = ripple(&log(0.0), 8, &nominal(), &stretches).unwrap();
        assert!((found.line - 1.0).abs() < 0.02, "{found:?}");
        // Two waves of 0.2 mm; the band holds all but a twentieth of their power, and the noise has
        // none at the line.
        assert!(
            (found.wheels_rad_s[0] / 0.05 - 1.0).abs() < 0.06,
            "{found:?}"
        );
        let both = 2e-4 * 2.0_f64.sqrt();
        assert!((found.body_m[0] / both - 1.0).abs() < 0.08, "{found:?}");
    }

    #[test]
    fn other_drives_and_unsteady_ones_are_left_out() {
        let stretches = Stretches {
            length_s: 4.0,
            rates_rad_s: &[1.5, 3.0, 1.5, 2.0],
            alike: 0.06,
        };
        assert_eq!(ripple(&log(0.0), 8, &nominal(), &stretches), None);
    }
}
