//! Gaps and overlaps between a wheel's rollers around the rim.

use std::f64::consts::{PI, TAU};

use crate::error::Fault;
pub(super) use crate::model::rollers_as_made::WIDEST_GAP_RAD;
use crate::model::{Remark, Roller, wrap_angle};

/// Gaps below a hundredth of a degree are rounding in the file.
const GAP_SLACK_RAD: f64 = 1e-2 * PI / 180.0;

/// The widest gap for which a wheel with its file's own rollers is proposed, in radians: into 40
/// degrees it falls by 6 % of its radius, and is lifted out at a slope of 20 degrees.
const WIDEST_ROLLED_RAD: f64 = 40.0 * PI / 180.0;
/// Positions around a wheel are multiples of one angle within this share of it.
const EVEN: f64 = 0.05;

/// Gaps and overlaps around a wheel.
pub(super) struct Handover {
    /// The widest gap between two neighbours, in radians of the wheel's turn; zero or negative if
    /// there is none.
    pub(super) widest_gap_rad: f64,
    /// Sum of all gaps in a turn, in radians.
    pub(super) gaps_rad: f64,
    /// Sum of all overlaps in a turn, in radians.
    pub(super) overlaps_rad: f64,
    /// The number of rollers, and of those missing if the others form an incomplete even ring.
    pub(super) rollers: usize,
    pub(super) missing: usize,
}

/// A roller touches the ground while its place is within phi of straight down, tan(phi) = (L/2)
/// cos(gamma) / a.
fn reach_rad(roller: &Roller, gamma_rad: f64) -> f64 {
    libm::atan(0.5 * roller.length_m * libm::cos(gamma_rad) / roller.ring_radius_m())
}

/// Returns the angle from one position on the rim to the next, in [0, 2 pi).
fn apart_rad(from: &Roller, to: &Roller) -> f64 {
    wrap_angle(to.place_rad() - from.place_rad() - PI) + PI
}

impl Handover {
    /// Computes the gaps of rollers ordered by angle.
    pub(super) fn between(rollers: &[Roller], gamma_rad: f64) -> Self {
        let mut sum = Self {
            widest_gap_rad: f64::NEG_INFINITY,
            gaps_rad: 0.0,
            overlaps_rad: 0.0,
            rollers: rollers.len(),
            missing: missing(rollers),
        };
        for (i, roller) in rollers.iter().enumerate() {
            let next = &rollers[(i + 1) % rollers.len()];
            let gap_rad =
                apart_rad(roller, next) - reach_rad(roller, gamma_rad) - reach_rad(next, gamma_rad);
            sum.widest_gap_rad = sum.widest_gap_rad.max(gap_rad);
            sum.gaps_rad += gap_rad.max(0.0);
            sum.overlaps_rad += (-gap_rad).max(0.0);
        }
        sum
    }

    /// Returns the gaps as a fault.
    pub(super) fn fault(&self) -> Fault {
        Fault::RollersHaveGaps {
            widest_gap_deg: self.widest_gap_rad.to_degrees(),
            share_percent: 100.0 * self.gaps_rad / TAU,
            missing: self.missing,
            of: self.rollers + self.missing,
            rolls: self.rolls(),
        }
    }

    /// Whether rollers are missing, judged by the positions of the others.
    pub(super) fn has_missing(&self) -> bool {
        self.missing > 0
    }

    /// Whether a wheel may roll over the gaps: none is wider than the limit, and no roller is
    /// missing.
    pub(super) fn rolls(&self) -> bool {
        self.missing == 0 && self.widest_gap_rad <= WIDEST_ROLLED_RAD
    }

    /// Adds a remark if a wheel with its file's own rollers cannot roll, with the reason.
    pub(super) fn remark_stuck(&self, wheel: &str, radius_m: f64, remarks: &mut Vec<Remark>) {
        if self.rolls() {
            return;
        }
        let missing = match self.missing {
            0 => String::new(),
            missing => format!(
                ": by their places {missing} of {} rollers are missing in the file",
                self.rollers + self.missing
            ),
        };
        let half_rad = 0.5 * self.widest_gap_rad;
        remarks.push(Remark::new(
            format!("wheel `{wheel}`"),
            format!(
                "it does not roll: it falls {:.1} mm into gaps of up to {:.1} deg between its rollers, and has to climb out of them at a slope of \
                 {:.0} deg{missing}",
                1e3 * radius_m * (1.0 - libm::cos(half_rad)),
                self.widest_gap_rad.to_degrees(),
                half_rad.to_degrees(),
            ),
        ));
    }

    /// Adds a remark on where no barrel touches the ground, and where two do.
    pub(super) fn remark(&self, wheel: &str, radius_m: f64, remarks: &mut Vec<Remark>) {
        if self.widest_gap_rad > GAP_SLACK_RAD {
            remarks.push(Remark::new(
                format!("wheel `{wheel}`"),
                format!(
                    "the rollers leave gaps of up to {:.2} deg, over which the wheel rests on their ends and dips {:.1} um",
                    self.widest_gap_rad.to_degrees(),
                    1e6 * radius_m * self.widest_gap_rad.powi(2) / 8.0
                ),
            ));
        }
        let share = self.overlaps_rad / TAU;
        if share > 0.01 {
            remarks.push(Remark::new(
                format!("wheel `{wheel}`"),
                format!(
                    "over {:.1} deg of each turn ({:.1} %) two rollers touch the ground at once, and rub where their \
                     directions differ",
                    self.overlaps_rad.to_degrees(),
                    100.0 * share
                ),
            ));
        }
    }
}

/// Returns the number of rollers missing from an even ring, judged by the ordered positions of the
/// others: all spacings are multiples of the smallest, and most equal it. Zero for other
/// arrangements.
fn missing(rollers: &[Roller]) -> usize {
    let apart: Vec<f64> = (0..rollers.len())
        .map(|i| apart_rad(&rollers[i], &rollers[(i + 1) % rollers.len()]))
        .collect();
    let pitch_rad = apart.iter().copied().fold(f64::INFINITY, f64::min);
    if pitch_rad < 1e-3 {
        return 0;
    }
    let multiples: Vec<f64> = apart.iter().map(|rad| rad / pitch_rad).collect();
    let is_even = multiples.iter().all(|n| (n - n.round()).abs() <= EVEN);
    let single = multiples.iter().filter(|n| n.round() == 1.0).count();
    if !is_even || 2 * single <= rollers.len() {
        return 0;
    }
    let places: f64 = multiples.iter().map(|n| n.round()).sum();
    places as usize - rollers.len()
}

/// Lengthens rollers, ordered by angle, until each reaches half of the way to its further
/// neighbour.
pub(super) fn close_gaps(rollers: &mut [Roller], wheel_radius_m: f64, gamma_rad: f64) {
    let count = rollers.len();
    let lengths_m: Vec<f64> = (0..count)
        .map(|i| {
            let roller = &rollers[i];
            let next_rad = apart_rad(roller, &rollers[(i + 1) % count]);
            let previous_rad = apart_rad(&rollers[(i + count - 1) % count], roller);
            let half_rad = 0.5 * next_rad.max(previous_rad);
            let a = roller.ring_radius_m();
            let length_m = 2.0 * barrel_half_length_m(a, wheel_radius_m, gamma_rad, half_rad);
            length_m.max(roller.length_m)
        })
        .collect();
    for (roller, length_m) in rollers.iter_mut().zip(lengths_m) {
        roller.length_m = length_m;
    }
}

/// Returns half of L for a barrel that touches the ground over `half_rad` to each side: a tan(phi)
/// / cos(gamma), but at most the length at which the barrel tapers to nothing, a / cos(phi) = rho.
pub(super) fn barrel_half_length_m(a: f64, rho: f64, gamma_rad: f64, half_rad: f64) -> f64 {
    let taper_rad = libm::acos((a / rho).clamp(-1.0, 1.0));
    a * libm::tan(half_rad.min(0.999 * taper_rad)) / libm::cos(gamma_rad)
}
