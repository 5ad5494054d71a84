//! Rollers as manufactured: barrels that are flatter, rounder, shorter or longer than the ideal
//! one, of unequal radius, or turned to a profile given by numbers.
//!
//! **Crown.** The ideal barrel is s(t) = rho - sqrt(a^2 + k^2 t^2) (see [`super::barrel_profile`]).
//! Its outline has the radius of curvature r + a / k^2 at the middle. A crown c makes that radius
//! (r + a / k^2) / c and leaves the middle in place: the roller is then the barrel of another
//! circle, s(t) = R - sqrt(A^2 + k^2 t^2) with R - A = r and r + A / k^2 = (r + a / k^2) / c. At
//! c = 1 it is the ideal barrel, towards c = 0 a cylinder with round ends; above 1 it is rounder.
//! For gamma = 0 the outline is an arc of a circle. It remains a family of spheres with a concave
//! radius, so that the nearest point to a convex piece of ground stays unique and is found exactly.
//!
//! **Length.** Rollers shorter than the length at which neighbours hand over leave gaps: between
//! two rollers the wheel stands on their ends, which are spheres.
//!
//! **Spread.** A roller whose radius is larger by d is the same barrel thickened by d.
//!
//! **Hub height** on level ground, with the touching roller at phi from straight down: h(phi) =
//! rho + (A - a) (1 - cos phi) as far as tan(phi) <= k L / (2 A), and beyond on an end sphere. Over
//! a gap it is h = rho - H (1 - cos(phi - psi)), with H = sqrt(a^2 + (k L / 2)^2) and psi = atan(k
//! L / 2a), and drops by H (1 - cos(pi/n - psi)) until the next roller lands. A wheel at the rate
//! omega moves its contact point p past the hub by omega n x (p - p_hub), whose forward part is
//! omega h: straight ahead it rolls on its mean height.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::solid_of_revolution::{ProfileError, SolidOfRevolution};
use super::{Barrel, RollerForm};

use smart_default::SmartDefault;

/// How the rollers of a wheel are made. The default is the ideal barrel for each.
#[derive(Clone, Debug, SmartDefault, PartialEq)]
pub struct RollersAsMade {
    /// Curvature of the outline along the roller, at its middle, over that of the ideal barrel: 1
    /// is ideal, below flatter, above rounder; > 0.
    #[default = 1.0]
    pub crown: f64,
    /// The profile by numbers, `[position along the axis from the middle, radius]` in metres;
    /// `None` for barrels.
    pub profile_m: Option<Vec<[f64; 2]>>,
    /// Radius of the edges of a profile by numbers, in metres.
    pub edge_radius_m: f64,
    /// Largest deviation of a roller's radius, drawn uniformly from both sides of nominal, in
    /// metres.
    pub radius_spread_m: f64,
    /// Seed of the draw.
    pub radius_seed: u64,
    /// Deviations of single rollers' radii, by the names of their joints, in metres; they replace
    /// the draw.
    pub radius_offsets_m: BTreeMap<String, f64>,
}

/// Reasons why rollers cannot be made in a given way.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotMade {
    /// Rollers with the shapes of their file.
    #[error("its rollers have the shapes of their file")]
    AsModelled,
    /// A value out of its range; the key is one of `[rollers]`.
    #[error("`rollers.{key}` = {value} must be {range}")]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// The value.
        value: String,
        /// The allowed range.
        range: &'static str,
    },
    /// An invalid profile.
    #[error("`rollers.profile_m`: {0}")]
    Profile(ProfileError),
}

pub(super) fn out_of_range(
    key: &'static str,
    value: impl ToString,
    range: &'static str,
) -> NotMade {
    NotMade::OutOfRange {
        key,
        value: value.to_string(),
        range,
    }
}

impl RollersAsMade {
    /// Whether every roller is the ideal barrel.
    pub fn is_ideal(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the deviation of a roller's radius, in metres. The draw depends only on the seed and
    /// the name of the roller's joint.
    pub fn radius_offset_m(&self, roller: &str) -> f64 {
        match self.radius_offsets_m.get(roller) {
            Some(offset_m) => *offset_m,
            None if self.radius_spread_m == 0.0 => 0.0,
            None => self.radius_spread_m * (2.0 * share(self.radius_seed, roller) - 1.0),
        }
    }

    /// Rejects numbers out of their ranges.
    pub(super) fn check(&self) -> Result<(), NotMade> {
        if !(self.crown.is_finite() && self.crown >= LEAST_CROWN) {
            let range = "a finite number of at least 0.01: flatter rollers are cylinders, which `rollers.profile_m` makes";
            return Err(out_of_range("crown", self.crown, range));
        }
        if self.profile_m.is_some() && self.crown != 1.0 {
            let range = "left out beside `rollers.profile_m`, which is the complete outline";
            return Err(out_of_range("crown", self.crown, range));
        }
        if self.profile_m.is_none() && self.edge_radius_m != 0.0 {
            let range = "left out without `rollers.profile_m`: barrels end in spheres";
            return Err(out_of_range("edge_radius_m", self.edge_radius_m, range));
        }
        if !(self.radius_spread_m.is_finite() && self.radius_spread_m >= 0.0) {
            let range = "a finite number, 0 or above";
            return Err(out_of_range("radius_spread_m", self.radius_spread_m, range));
        }
        let offsets = self.radius_offsets_m.values();
        match { offsets }.find(|offset_m| !offset_m.is_finite()) {
            Some(offset_m) => {
                let range = "finite numbers, by the names of rollers' joints";
                Err(out_of_range("radius_offsets_m", offset_m, range))
            }
            None => Ok(()),
        }
    }

    /// Rejects settings that are impossible for rollers with this ideal barrel and these names.
    pub fn check_on(
        &self,
        ideal: &Barrel,
        names: impl Iterator<Item = String>,
    ) -> Result<(), NotMade> {
        self.check()?;
        let mut names = names;
        names.try_for_each(|name| self.form(ideal, &name).map(|_| ()))
    }

    /// Returns the form of one roller with a given ideal barrel.
    pub(super) fn form(&self, ideal: &Barrel, roller: &str) -> Result<RollerForm, NotMade> {
        let offset_m = self.radius_offset_m(roller);
        let nominal_m = ideal.wheel_radius_m - ideal.ring_radius_m;
        if nominal_m + offset_m <= 0.0 || offset_m >= ideal.ring_radius_m {
            let (key, value) = match self.radius_offsets_m.get(roller) {
                Some(offset_m) => ("radius_offsets_m", *offset_m),
                None => ("radius_spread_m", self.radius_spread_m),
            };
            let range =
                "so small, in metres, that every roller keeps a radius and stays off the hub axis";
            return Err(out_of_range(key, value, range));
        }
        if let Some(points_m) = &self.profile_m {
            let grown: Vec<[f64; 2]> = points_m.iter().map(|[t, r]| [*t, r + offset_m]).collect();
            let turned =
                SolidOfRevolution::new(&grown, self.edge_radius_m).map_err(NotMade::Profile)?;
            if turned.bounding_radius_m() >= ideal.wheel_radius_m {
                let range = "places and radii in metres, of a roller that is smaller than its wheel: 12 mm are 0.012";
                return Err(out_of_range("profile_m", format!("{points_m:?}"), range));
            }
            return Ok(RollerForm::Turned(turned));
        }
        if self.crown == 1.0 && offset_m == 0.0 {
            return Ok(RollerForm::Barrel);
        }
        let mut made = *ideal;
        if self.crown != 1.0 {
            let k2 = ideal.sin_delta * ideal.sin_delta;
            let middle_m = (nominal_m + ideal.ring_radius_m / k2) / self.crown;
            made.ring_radius_m = k2 * (middle_m - nominal_m);
            if made.ring_radius_m <= 0.0 {
                let range =
                    "so flat that the outline is less curved along the roller than around it";
                return Err(out_of_range("crown", self.crown, range));
            }
        }
        made.wheel_radius_m = made.ring_radius_m + nominal_m + offset_m;
        if made.sphere_radius_m(made.half_length_m) <= 0.0 {
            let range = "so flat that the rollers do not taper to nothing before their ends";
            return Err(out_of_range("crown", self.crown, range));
        }
        Ok(RollerForm::Made(made))
    }
}

/// Gaps up to one degree are neglected: over a gap of angle g the wheel rests on the ends of its
/// rollers and dips by about rho g^2 / 8, which at one degree is 4e-5 of its radius.
pub const WIDEST_GAP_RAD: f64 = PI / 180.0;

/// A flatter crown than this cannot be distinguished from a cylinder.
const LEAST_CROWN: f64 = 0.01;

/// Returns a pseudo-random share in [0, 1) of a seed and a name: FNV-1a over the name (Fowler,
/// Noll, Vo), then one step of SplitMix64 (Steele et al. 2014) from the seed.
fn share(seed: u64, name: &str) -> f64 {
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for byte in name.bytes() {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    let mut z =
        (hash ^ seed.wrapping_mul(0xd1b5_4a32_d192_ed03)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 53) as f64
}
