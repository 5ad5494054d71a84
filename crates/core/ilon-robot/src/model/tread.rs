//! What rollers touch the ground with that is not rigid: a tread that gives, and what rolling on it costs.

use super::Scale;

/// A tread: rubber on a core. Its core keeps the shape of the roller; between core and ground it is a spring with a damper
/// beside it, along the ground's normal and across it, for every roller that reaches the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tread {
    /// Stiffness along the normal, in N/m, > 0.
    pub stiffness_n_m: f64,
    /// Damping along the normal, in N s/m, >= 0; `None` for [`DAMPING_RATIO`] of what is critical for the load on a wheel.
    pub damping_n_s_m: Option<f64>,
    /// Stiffness across the normal, in N/m, > 0; `None` for [`SHEAR_SHARE`] of that along it.
    pub shear_stiffness_n_m: Option<f64>,
    /// Damping across the normal, in N s/m, >= 0; `None` for as much of the stiffness as there is along the normal.
    pub shear_damping_n_s_m: Option<f64>,
    /// The way in metres, > 0, over which tread that has been sheared leaves the ground as the roller rolls on and fresh
    /// tread takes its place; `None` where none is renewed while the roller touches.
    pub relaxation_length_m: Option<f64>,
}

/// Damping along the normal of a tread of which nothing is said, of critical.
pub const DAMPING_RATIO: f64 = 0.1;

/// Stiffness across the normal over that along it of a tread of which nothing is said: that of a patch pressed on an
/// incompressible half-space, 2 (1 - nu) / (2 - nu) with nu = 1/2 (Mindlin 1949).
pub const SHEAR_SHARE: f64 = 2.0 / 3.0;

impl Tread {
    /// A tread of this stiffness along the normal, in N/m, with the defaults of all else.
    pub fn new(stiffness_n_m: f64) -> Self {
        Self {
            stiffness_n_m,
            damping_n_s_m: None,
            shear_stiffness_n_m: None,
            shear_damping_n_s_m: None,
            relaxation_length_m: None,
        }
    }

    /// Damping along the normal under a load, in N s/m: where none is said, 2 zeta sqrt(k m) with zeta = [`DAMPING_RATIO`].
    pub fn damping_under_n_s_m(&self, load_kg: f64) -> f64 {
        let critical = 2.0 * (self.stiffness_n_m * load_kg).sqrt();
        self.damping_n_s_m.unwrap_or(DAMPING_RATIO * critical)
    }

    /// Stiffness across the normal, in N/m.
    pub fn shear_n_m(&self) -> f64 {
        let share = SHEAR_SHARE * self.stiffness_n_m;
        self.shear_stiffness_n_m.unwrap_or(share)
    }

    /// Damping across the normal under a load, in N s/m.
    pub fn shear_damping_under_n_s_m(&self, load_kg: f64) -> f64 {
        let relaxes_s = self.damping_under_n_s_m(load_kg) / self.stiffness_n_m;
        self.shear_damping_n_s_m
            .unwrap_or(relaxes_s * self.shear_n_m())
    }
}

/// What the rollers of a wheel are covered with, what it costs them to roll, and how far they can slide along their axles. The
/// default is the rigid roller that rolls without loss and without play.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RollerSurface {
    /// The tread; `None` for rigid rollers.
    pub tread: Option<Tread>,
    /// Rolling resistance: energy that each metre takes by which the place of contact moves over the ground, per newton of
    /// load; dimensionless, >= 0. On a level floor the drag is this times the load.
    pub rolling_resistance: f64,
    /// Play of each roller along its axle, from stop to stop, in metres, >= 0.
    pub axial_play_m: f64,
    /// Coefficient of the friction between roller and axle, >= 0: under a load N it holds the roller with the torque that
    /// [`Self::axle_drag_n_m`] says, beside what its joint says of dry friction and damping.
    pub axle_friction: f64,
    /// Radius of the axle, where that friction acts, in metres, >= 0; of a rolling bearing that of its bore.
    pub axle_radius_m: f64,
}

/// What rollers with play that have no tread of their own give way by under a wheel's load, of its radius, and their damping as a share of
/// what is critical: they do not bounce.
const STIFF_SAG: f64 = 5.5e-5;
const STIFF_DAMPING: f64 = 0.7;

impl RollerSurface {
    /// Most torque of the friction on a roller's axle under a load in N, in N m: coefficient times radius times load.
    pub fn axle_drag_n_m(&self, load_n: f64) -> f64 {
        self.axle_friction * self.axle_radius_m * load_n.max(0.0)
    }

    /// What its rollers touch the ground with on a robot of these units: its tread, or, where they have none and can slide along their
    /// axles, one that gives way by 5.5e-5 of the wheel's radius, 1e7 N/m on a robot of 11 kg with wheels of 50 mm. About a hand-over two of
    /// them carry the wheel while one slides, and of rigid ones it cannot be said which carries what.
    pub fn touching_tread(&self, scale: &Scale) -> Option<Tread> {
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
        // 2 * 0.1 * sqrt(1e5 * 2.5) = 100 N s/m: 1 ms of the stiffness, and of that across it too.
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
