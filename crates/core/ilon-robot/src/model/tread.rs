//! Compliant treads on rollers, and their rolling resistance.

use super::Scale;

/// A tread: rubber on a core. The core has the shape of the roller; between core and ground the
/// tread is a spring with a parallel damper, along the ground's normal and across it, for every
/// roller that reaches the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tread {
    /// Stiffness along the normal, in N/m, > 0.
    pub stiffness_n_m: f64,
    /// Damping along the normal, in N s/m, >= 0; `None` for [`DAMPING_RATIO`] of the critical
    /// damping under a wheel's load.
    pub damping_n_s_m: Option<f64>,
    /// Stiffness across the normal, in N/m, > 0; `None` for [`SHEAR_SHARE`] of that along it.
    pub shear_stiffness_n_m: Option<f64>,
    /// Damping across the normal, in N s/m, >= 0; `None` for the same ratio to the stiffness as
    /// along the normal.
    pub shear_damping_n_s_m: Option<f64>,
    /// The distance in metres, > 0, over which sheared tread leaves the ground as the roller rolls
    /// and fresh tread replaces it; `None` if no tread is renewed while the roller touches.
    pub relaxation_length_m: Option<f64>,
}

/// Default damping along the normal, as a ratio of critical.
pub const DAMPING_RATIO: f64 = 0.1;

/// Default ratio of the stiffness across the normal to that along it: that of a patch pressed on an
/// incompressible half-space, 2 (1 - nu) / (2 - nu) with nu = 1/2 (Mindlin 1949).
pub const SHEAR_SHARE: f64 = 2.0 / 3.0;

impl Tread {
    /// A tread with this stiffness along the normal, in N/m, and defaults otherwise.
    pub fn new(stiffness_n_m: f64) -> Self {
        Self {
            stiffness_n_m,
            damping_n_s_m: None,
            shear_stiffness_n_m: None,
            shear_damping_n_s_m: None,
            relaxation_length_m: None,
        }
    }

    /// Returns the damping along the normal under a load, in N s/m; by default 2 zeta sqrt(k m)
    /// with zeta = [`DAMPING_RATIO`].
    pub fn damping_under_n_s_m(&self, load_kg: f64) -> f64 {
        let critical = 2.0 * (self.stiffness_n_m * load_kg).sqrt();
        self.damping_n_s_m.unwrap_or(DAMPING_RATIO * critical)
    }

    /// Returns the stiffness across the normal, in N/m.
    pub fn shear_n_m(&self) -> f64 {
        let share = SHEAR_SHARE * self.stiffness_n_m;
        self.shear_stiffness_n_m.unwrap_or(share)
    }

    /// Returns the damping across the normal under a load, in N s/m.
    pub fn shear_damping_under_n_s_m(&self, load_kg: f64) -> f64 {
        let relaxes_s = self.damping_under_n_s_m(load_kg) / self.stiffness_n_m;
        self.shear_damping_n_s_m
            .unwrap_or(relaxes_s * self.shear_n_m())
    }
}

/// Tread, rolling resistance, axial play and axle friction of a wheel's rollers. The default is the
/// rigid roller without losses and play.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RollerSurface {
    /// The tread; `None` for rigid rollers.
    pub tread: Option<Tread>,
    /// Rolling resistance: energy per metre by which the contact point moves over the ground, per
    /// newton of load; dimensionless, >= 0. On a level floor the drag is this times the load.
    pub rolling_resistance: f64,
    /// Play of each roller along its axle, from stop to stop, in metres, >= 0.
    pub axial_play_m: f64,
    /// Friction coefficient between roller and axle, >= 0: under a load N it brakes the roller with
    /// the torque of [`Self::axle_drag_n_m`], in addition to the dry friction and damping of its
    /// joint.
    pub axle_friction: f64,
    /// Radius of the axle, where that friction acts, in metres, >= 0; for a rolling bearing that of
    /// its bore.
    pub axle_radius_m: f64,
}

/// Deflection under a wheel's load, over its radius, of rollers with play but without a tread of
/// their own; they are damped so that they do not bounce.
const STIFF_SAG: f64 = 5.5e-5;
const STIFF_DAMPING: f64 = 0.7;

/// Deflection of one place of a tyre without a given tread under the whole load of a wheel, over
/// its radius: that of hard polyurethane (chosen).
pub const TYRE_SAG: f64 = 5e-3;

impl RollerSurface {
    /// Returns the largest torque of the friction on a roller's axle under a load in N, in N m:
    /// coefficient times radius times load.
    pub fn axle_drag_n_m(&self, load_n: f64) -> f64 {
        self.axle_friction * self.axle_radius_m * load_n.max(0.0)
    }

    /// Returns the tread with which rollers touch the ground, or a tyre, on a robot of these units.
    /// Rollers that can slide along their axles and have no tread get one that deflects by 5.5e-5
    /// of the wheel's radius, 1e7 N/m on a robot of 11 kg with wheels of 50 mm: near a hand-over
    /// two rollers carry the wheel while one slides, and with rigid ones their shares are
    /// undetermined. On a robot with tyres (`beside_tyres`) every wheel without a tread gets one of
    /// which each place would deflect by 5e-3 of the radius under the whole load of a wheel, so
    /// that all places of its tyres, and all of its wheels, carry it.
    pub fn touching_tread(&self, scale: &Scale, beside_tyres: bool) -> Option<Tread> {
        if beside_tyres && self.tread.is_none() {
            return Some(Tread::new(scale.stiffness_n_m(TYRE_SAG)));
        }
        let stiff = (self.axial_play_m > 0.0).then(|| {
            let stiffness_n_m = scale.stiffness_n_m(STIFF_SAG);
            let critical_n_s_m = 2.0 * (stiffness_n_m * scale.load_kg).sqrt();
            Tread {
                damping_n_s_m: Some(STIFF_DAMPING * critical_n_s_m),
                ..Tread::new(stiffness_n_m)
            }
        });
        self.tread.or(stiff)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_said_of_a_tread_follows_from_its_stiffness() {
        let tread = Tread::new(1e5);
        // 2 * 0.1 * sqrt(1e5 * 2.5) = 100 N s/m: 1 ms of the stiffness, and the same across.
        assert!((tread.damping_under_n_s_m(2.5) - 100.0).abs() < 1e-12);
        assert!((tread.shear_n_m() - 2e5 / 3.0).abs() < 1e-9);
        assert!((tread.shear_damping_under_n_s_m(2.5) - 200.0 / 3.0).abs() < 1e-9);
        let said = Tread {
            damping_n_s_m: Some(0.0),
            shear_stiffness_n_m: Some(4e4),
            shear_damping_n_s_m: Some(7.0),
            ..tread
        };
        let all = (
            said.damping_under_n_s_m(2.5),
            said.shear_n_m(),
            said.shear_damping_under_n_s_m(2.5),
        );
        assert_eq!(all, (0.0, 4e4, 7.0));
    }
}
