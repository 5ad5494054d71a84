//! Rollers as they are made: barrels that are flatter, rounder, shorter or longer than the ideal one, of unequal radius, or
//! turned to a profile by numbers.
//!
//! **Crown.** The ideal barrel is s(t) = rho - sqrt(a^2 + k^2 t^2) (see [`super::barrel`]). Its outline has the radius of
//! curvature r + a / k^2 at the middle. A crown c makes that radius (r + a / k^2) / c and leaves the middle where it is: the
//! roller is then the barrel of another circle, s(t) = R - sqrt(A^2 + k^2 t^2) with R - A = r and r + A / k^2 = (r + a / k^2) / c.
//! At c = 1 it is the ideal barrel, towards c = 0 a cylinder with round ends; above 1 it is rounder. For gamma = 0 the outline is
//! an arc of a circle. It remains a family of spheres with a concave radius, so that the nearest place to a convex piece of
//! ground stays one and is found exactly.
//!
//! **Length.** Shorter than that at which neighbours hand over leaves gaps: between two rollers the wheel stands on their ends,
//! which are spheres.
//!
//! **Spread.** A roller whose radius is larger by d is the same barrel thickened by d.
//!
//! **The hub** on level ground, with the touching roller at phi from straight down, stands at h(phi) = rho + (A - a) (1 - cos phi) as far as
//! tan(phi) <= k L / (2 A), and beyond on an end sphere. Over a gap it stands at h = rho - H (1 - cos(phi - psi)), with H = sqrt(a^2 + (k L / 2)^2)
//! and psi = atan(k L / 2a), and drops by H (1 - cos(pi/n - psi)) until the next roller lands. A wheel at the rate omega moves its place of
//! contact p past the hub by omega n x (p - p_hub), of which the part ahead is omega h: straight ahead it rolls on its mean height.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use nalgebra::{Rotation3, Vector3};

use super::turned::{NotTurned, Turned};
use super::{Barrel, Roller, RollerForm, Wheel};

/// How the rollers of a wheel are made. The default is the ideal barrel for each of them.
#[derive(Clone, Debug, PartialEq)]
pub struct RollersAsMade {
    /// Curvature of the outline along the roller, at its middle, over that of the ideal barrel: 1 is ideal, below flatter,
    /// above rounder; > 0.
    pub crown: f64,
    /// The profile by numbers, `[place along the axis from the middle, radius]` in metres; `None` for barrels.
    pub profile_m: Option<Vec<[f64; 2]>>,
    /// Radius of the edges of a profile by numbers, in metres.
    pub edge_radius_m: f64,
    /// Each roller's radius is off by up to this, drawn evenly from both sides of nominal, in metres.
    pub radius_spread_m: f64,
    /// Seed of what is drawn.
    pub radius_seed: u64,
    /// What is added to the radius of single rollers, by the names of their joints, in metres: in place of what is drawn.
    pub radius_offsets_m: BTreeMap<String, f64>,
}

impl Default for RollersAsMade {
    fn default() -> Self {
        Self {
            crown: 1.0,
            profile_m: None,
            edge_radius_m: 0.0,
            radius_spread_m: 0.0,
            radius_seed: 0,
            radius_offsets_m: BTreeMap::new(),
        }
    }
}

/// Why rollers cannot be made so.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotMade {
    /// Rollers that have the shapes of their file.
    #[error("its rollers have the shapes of their file")]
    AsModelled,
    /// A value out of its range; the key is one of `[rollers]`.
    #[error("`rollers.{key}` = {value} must be {range}")]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// Its value.
        value: String,
        /// What it must be.
        range: &'static str,
    },
    /// A profile that is none.
    #[error("`rollers.profile_m`: {0}")]
    Profile(NotTurned),
}

fn out_of_range(key: &'static str, value: impl ToString, range: &'static str) -> NotMade {
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

    /// What the radius of a roller is off, in metres. The draw depends on the seed and the name of the roller's joint alone.
    pub fn radius_offset_m(&self, roller: &str) -> f64 {
        match self.radius_offsets_m.get(roller) {
            Some(offset_m) => *offset_m,
            None if self.radius_spread_m == 0.0 => 0.0,
            None => self.radius_spread_m * (2.0 * share(self.radius_seed, roller) - 1.0),
        }
    }

    fn check(&self) -> Result<(), NotMade> {
        if !(self.crown.is_finite() && self.crown >= LEAST_CROWN) {
            let range = "a finite number of at least 0.01: flatter rollers are cylinders, which `rollers.profile_m` makes";
            return Err(out_of_range("crown", self.crown, range));
        }
        if self.profile_m.is_some() && self.crown != 1.0 {
            let range = "left out beside `rollers.profile_m`, which is the whole outline";
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

    /// Refuses what cannot be made of rollers with this ideal barrel and these names.
    pub fn check_on(
        &self,
        ideal: &Barrel,
        names: impl Iterator<Item = String>,
    ) -> Result<(), NotMade> {
        self.check()?;
        let mut names = names;
        names.try_for_each(|name| self.form(ideal, &name).map(|_| ()))
    }

    /// The form of one roller, whose ideal barrel is given.
    fn form(&self, ideal: &Barrel, roller: &str) -> Result<RollerForm, NotMade> {
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
            let turned = Turned::new(&grown, self.edge_radius_m).map_err(NotMade::Profile)?;
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

/// Gaps up to one degree are none: over a gap of angle g the wheel rests on the ends of its rollers and dips by about
/// rho g^2 / 8, which at one degree is 4e-5 of its radius.
pub const WIDEST_GAP_RAD: f64 = PI / 180.0;

/// A flatter crown than this is a cylinder to whoever measures it.
const LEAST_CROWN: f64 = 0.01;

impl Wheel {
    /// Makes the rollers otherwise, and gives barrels another length: as a factor of that at which neighbours hand over with
    /// neither gap nor overlap. Each keeps its mass, with even density; its moments of inertia follow its form.
    ///
    /// # Errors
    /// [`NotMade`]; the wheel is then as it was.
    pub fn make_rollers(
        &mut self,
        made: RollersAsMade,
        length_factor: Option<f64>,
    ) -> Result<(), NotMade> {
        made.check()?;
        if made.profile_m.is_some()
            && let Some(factor) = length_factor
        {
            let range = "left out beside `rollers.profile_m`, which has its own length";
            return Err(out_of_range("length_factor", factor, range));
        }
        let count = self.rollers.len();
        let mut rollers = Vec::with_capacity(count);
        for roller in &self.rollers {
            let before = self.solid_moments(roller).ok_or(NotMade::AsModelled)?;
            let mut next = roller.clone();
            let ring_m = roller.ring_radius_m();
            let thick_m = self.radius_m - ring_m;
            if let Some(factor) = length_factor {
                let even = Barrel::handing_over(self.radius_m, thick_m, self.gamma_rad, count);
                next.length_m = 2.0 * (factor * even.half_length_m);
            }
            let ideal = self.ideal_barrel(&next);
            if made.profile_m.is_none() && ideal.sphere_radius_m(ideal.half_length_m) <= 0.0 {
                let range = "short enough for rollers of this radius, which taper to nothing before their ends";
                let factor = length_factor.unwrap_or(1.0);
                return Err(out_of_range("length_factor", factor, range));
            }
            next.form = made.form(&ideal, &roller.name)?;
            if let RollerForm::Turned(turned) = &next.form {
                let (first_m, last_m) = turned.span_m();
                next.length_m = last_m - first_m;
            }
            next.radius_m = match &next.form {
                RollerForm::Turned(turned) => turned.largest_radius_m(),
                // As it was read, but for what it is off.
                _ if self.made.is_ideal() => roller.radius_m + made.radius_offset_m(&roller.name),
                _ => thick_m + made.radius_offset_m(&roller.name),
            };
            if let Some(after) = self.solid_moments(&next) {
                next.axial_inertia_kg_m2 *= after.0 / before.0;
                next.transverse_inertia_kg_m2 *= after.1 / before.1;
            }
            rollers.push(next);
        }
        self.rollers = rollers;
        self.made = made;
        Ok(())
    }

    /// Moments of a roller of its mass and even density, about its axis and across it; `None` where it has the shapes of its
    /// file.
    fn solid_moments(&self, roller: &Roller) -> Option<(f64, f64)> {
        match &roller.form {
            RollerForm::AsModelled(_) => None,
            RollerForm::Turned(turned) => Some(turned.solid_moments_kg_m2(roller.mass_kg)),
            _ => Some(self.barrel(roller).solid_moments_kg_m2(roller.mass_kg)),
        }
    }

    /// How high its hub stands on level ground with the wheel turned by an angle from where it is at wheel angle zero, in radians:
    /// in metres, its radius where its rollers make a circle of its outline.
    pub fn hub_height_m(&self, wheel_angle_rad: f64) -> f64 {
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), -wheel_angle_rad);
        let down_in_hub = self.body_from_hub.rotation.inverse() * -Vector3::z();
        self.reach_in_hub_m(&(turned * down_in_hub))
    }

    /// Whether its rollers make a perfect circle of its outline: ideal barrels that follow each other without a gap.
    pub fn is_round(&self) -> bool {
        if self.rollers.iter().any(|r| r.form != RollerForm::Barrel) {
            return false;
        }
        // A roller touches until tan(phi) = t k / a with its end at t = L/2: half of the angle that it serves.
        let serves_rad = |roller: &Roller| {
            let barrel = self.barrel(roller);
            libm::atan2(
                barrel.half_length_m * barrel.sin_delta,
                barrel.ring_radius_m,
            )
        };
        let count = self.rollers.len();
        (0..count).all(|i| {
            let (one, next) = (&self.rollers[i], &self.rollers[(i + 1) % count]);
            let apart_rad = (next.place_rad() - one.place_rad()).rem_euclid(TAU);
            serves_rad(one) + serves_rad(next) >= apart_rad - WIDEST_GAP_RAD
        })
    }
}

/// A share in [0, 1) of a seed and a name: FNV-1a over the name (Fowler, Noll, Vo), then one step of SplitMix64 (Steele et al.
/// 2014) from the seed.
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
