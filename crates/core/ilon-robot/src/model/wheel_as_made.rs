//! Wheels whose rollers deviate from the ideal barrel.

use std::f64::consts::TAU;

use nalgebra::{Rotation3, Vector3};

use super::rollers_as_made::{NotMade, RollersAsMade, WIDEST_GAP_RAD, out_of_range};
use super::{Barrel, Roller, RollerForm, Wheel};

/// Heights of a wheel's hub over a turn on level ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HubHeights {
    /// The largest less the smallest, in metres.
    pub travel_m: f64,
    /// Their mean, in metres: the rolling radius, apart from the effect of the rollers' tilt.
    pub mean_m: f64,
}

impl Wheel {
    /// Changes how the rollers are made, and gives barrels another length: as a factor of that at
    /// which neighbours hand over with neither gap nor overlap. Each keeps its mass, with uniform
    /// density; its moments of inertia follow its form.
    ///
    /// # Errors
    /// [`NotMade`]; the wheel is then unchanged.
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
                // The radius as read, plus its deviation.
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

    /// Returns the moments of a roller of its mass and uniform density, about its axis and across
    /// it; `None` for the shapes of a file.
    fn solid_moments(&self, roller: &Roller) -> Option<(f64, f64)> {
        match &roller.form {
            RollerForm::AsModelled(_) | RollerForm::Tyre(_) => None,
            RollerForm::Turned(turned) => Some(turned.solid_moments_kg_m2(roller.mass_kg)),
            _ => Some(self.barrel(roller).solid_moments_kg_m2(roller.mass_kg)),
        }
    }

    /// Returns the height of its hub on level ground with the wheel turned by an angle in radians
    /// from wheel angle zero, in metres: its radius if its outline is a circle.
    pub fn hub_height_m(&self, wheel_angle_rad: f64) -> f64 {
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), -wheel_angle_rad);
        let down_in_hub = self.body_from_hub.rotation.inverse() * -Vector3::z();
        self.reach_in_hub_m(&(turned * down_in_hub))
    }

    /// Returns how its hub rises and falls on level ground in a turn of the wheel, in metres.
    pub fn hub_heights(&self) -> HubHeights {
        /// Samples per passing roller; the error of a hub's travel is of the order of one over its
        /// square.
        const LOOKS: usize = 200;
        if self.has_tyre() {
            let (travel_m, mean_m) = (0.0, self.radius_m);
            return HubHeights { travel_m, mean_m };
        }
        let looks = LOOKS * self.rollers.len();
        let step_rad = TAU / looks as f64;
        let heights_m = (0..looks).map(|i| self.hub_height_m(step_rad * i as f64));
        let (least_m, largest_m, sum_m) = heights_m.fold(
            (f64::INFINITY, f64::NEG_INFINITY, 0.0),
            |(least, largest, sum), h| (h.min(least), h.max(largest), sum + h),
        );
        HubHeights {
            travel_m: largest_m - least_m,
            mean_m: sum_m / looks as f64,
        }
    }

    /// Whether its outline is a perfect circle: ideal barrels that follow each other without a gap,
    /// or a tyre.
    pub fn is_round(&self) -> bool {
        if self.has_tyre() {
            return true;
        }
        if self.rollers.iter().any(|r| r.form != RollerForm::Barrel) {
            return false;
        }
        // A roller touches until tan(phi) = t k / a with its end at t = L/2: half of the angle of
        // its contact.
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
