//! A roller against the floor: a spring and a damper along the normal, a bristle in the tangent
//! plane.
//!
//! **Normal.** At the depth d the floor pushes with N = max(0, k_n d + c_n d.): it never pulls.
//!
//! **Friction.** A bristle of stiffness k_t and damping c_t is in series with a slider that holds
//! |F| <= mu N (Coulomb). Its deflection **z** grows with the sliding velocity **u** of the roller's
//! material against the floor while the slider holds:
//!
//! ```text
//! F = -k_t z - c_t z.,   z. = u               while |F| <= mu N
//! |F| = mu N,            z. = u - slip        else, the slip along -F
//! ```
//!
//! Over a step of length h the deflection is found implicitly. Trial: z* = z + h u and
//! F* = -k_t z* - c_t u. If |F*| exceeds mu N, F = mu N F* / |F*|, and the deflection that gives
//! this force is z' = (c_t z / h - F) / (k_t + c_t / h). The cone is held exactly, the friction of a
//! steady slide is mu N against **u** whatever the damping, and F . slip is never positive: the
//! slider only dissipates.
//!
//! **Anisotropic friction (a nap).** If friction across a direction of the floor differs from that
//! along it, the slider holds |M^-1 F| <= N with the coefficients of the two directions in M, and
//! slips along the ellipse's normal, -M^-2 F. Then F = F* + (k_t + c_t / h) slip gives each of the
//! two its share F*_i / (1 + s / m_i^2), with the s >= 0 for which F lies on the ellipse, found by
//! bisection.
//!
//! The force acts at the roller's lowest point, so that the rolling radius is that of the rigid
//! wheel. As k_n and k_t grow, the law tends to that of rigid contacts with Coulomb friction and
//! without rebound.

use ilon_robot::Robot;
use nalgebra::Vector2;

use crate::OracleError;

/// Springs, dampers and friction between a roller and the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// k_n, in N/m.
    pub normal_stiffness_n_m: f64,
    /// c_n, in N s/m.
    pub normal_damping_n_s_m: f64,
    /// k_t, in N/m.
    pub bristle_stiffness_n_m: f64,
    /// c_t, in N s/m.
    pub bristle_damping_n_s_m: f64,
    /// mu; along the nap, if there is one.
    pub friction: f64,
    /// A direction of the floor with different friction across it.
    pub nap: Option<Nap>,
}

/// A direction of the floor, and the friction across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nap {
    /// From the world's x axis, counter-clockwise, in radians.
    pub angle_rad: f64,
    /// Friction across it over that along it, > 0.
    pub ratio: f64,
}

/// Bristle stiffness over normal stiffness: that of an incompressible half-space (Mindlin: 2 (1 -
/// nu) / (2 - nu) at nu = 0.5).
const BRISTLE_SHARE: f64 = 2.0 / 3.0;
/// Damping ratio of the robot bouncing on its wheels; chosen.
const NORMAL_DAMPING_RATIO: f64 = 0.7;
/// Damping ratio of a roller that oscillates about its axis on its bristle; chosen.
const BRISTLE_DAMPING_RATIO: f64 = 0.5;

impl ContactLaw {
    /// A floor of this stiffness in N/m and this friction, with bristles of 2/3 of the stiffness. A
    /// robot bouncing on its wheels has a damping ratio of 0.7, a roller oscillating on its
    /// bristle, or a wheel on one of its tyre's, one of 0.5. Tends to the rigid limit with growing
    /// stiffness.
    pub fn stiff(normal_stiffness_n_m: f64, friction: f64, robot: &Robot) -> Self {
        let bristle_stiffness_n_m = BRISTLE_SHARE * normal_stiffness_n_m;
        let on_each_kg = robot.mass_kg() / robot.wheels.len() as f64;
        let parts = robot.wheels.iter().flat_map(|w| {
            let hub_kg_m2 = w.hub.inertia_kg_m2[(2, 2)];
            w.rollers.iter().map(move |roller| {
                let inertia_kg_m2 = match roller.is_tyre() {
                    true => hub_kg_m2,
                    false => roller.axial_inertia_kg_m2,
                };
                inertia_kg_m2 / (roller.radius_m * roller.radius_m)
            })
        });
        let lightest_kg = parts.fold(f64::INFINITY, f64::min);
        let critical = |k: f64, m: f64| 2.0 * (k * m).sqrt();
        Self {
            normal_stiffness_n_m,
            normal_damping_n_s_m: NORMAL_DAMPING_RATIO * critical(normal_stiffness_n_m, on_each_kg),
            bristle_stiffness_n_m,
            bristle_damping_n_s_m: BRISTLE_DAMPING_RATIO
                * critical(bristle_stiffness_n_m, lightest_kg),
            friction,
            nap: None,
        }
    }

    pub(crate) fn check(&self) -> Result<(), OracleError> {
        let Self {
            normal_stiffness_n_m,
            normal_damping_n_s_m,
            bristle_stiffness_n_m,
            bristle_damping_n_s_m,
            friction,
            nap,
        } = *self;
        let ratio = nap.map_or(1.0, |nap| nap.ratio);
        for (setting, value, positive) in [
            ("normal_stiffness_n_m", normal_stiffness_n_m, true),
            ("normal_damping_n_s_m", normal_damping_n_s_m, false),
            ("bristle_stiffness_n_m", bristle_stiffness_n_m, true),
            ("bristle_damping_n_s_m", bristle_damping_n_s_m, false),
            ("friction", friction, false),
            ("nap.ratio", ratio, true),
        ] {
            let range = if positive { "above 0" } else { "0 or more" };
            let allowed = value.is_finite() && value >= 0.0 && (value > 0.0 || !positive);
            if !allowed {
                return Err(OracleError::Setting {
                    setting,
                    value,
                    range,
                });
            }
        }
        Ok(())
    }

    /// Normal force in N at a depth and its rate.
    pub(crate) fn normal_n(&self, depth_m: f64, deepening_m_s: f64) -> f64 {
        let spring = self.normal_stiffness_n_m * depth_m;
        (spring + self.normal_damping_n_s_m * deepening_m_s).max(0.0)
    }

    /// Updates the bristle over a step of `h` seconds under the normal force `normal_n` and the
    /// sliding velocity `u`.
    pub(crate) fn bend(
        &self,
        z: &mut Vector2<f64>,
        u: Vector2<f64>,
        normal_n: f64,
        h: f64,
    ) -> Friction {
        let (k, c) = (self.bristle_stiffness_n_m, self.bristle_damping_n_s_m);
        let limit = self.friction * normal_n;
        let before = *z;
        let trial = -k * (before + h * u) - c * u;
        let held = self.held(trial, limit);
        let (force, after, slip) = if held.is_none() {
            (trial, before + h * u, Vector2::zeros())
        } else {
            let force = held.unwrap_or(trial);
            let after = (before * (c / h) - force) / (k + c / h);
            (force, after, h * u - (after - before))
        };
        *z = after;
        Friction {
            force,
            slip_j: -force.dot(&slip),
            damping_j: c * (after - before).norm_squared() / h,
            slides: held.is_some(),
        }
    }
}

impl ContactLaw {
    /// The force of a slider for a trial force beyond its limit; `None` if it holds. `limit_n` is
    /// mu N.
    fn held(&self, trial: Vector2<f64>, limit_n: f64) -> Option<Vector2<f64>> {
        let Some(nap) = self.nap else {
            let size = trial.norm();
            return (size > limit_n).then(|| trial * (limit_n / size));
        };
        let (s, c) = nap.angle_rad.sin_cos();
        let own = Vector2::new(c * trial.x + s * trial.y, c * trial.y - s * trial.x);
        let limits = Vector2::new(limit_n, nap.ratio * limit_n);
        let over = |force: Vector2<f64>| force.component_div(&limits).norm();
        if limit_n <= 0.0 {
            return Some(Vector2::zeros());
        }
        if over(own) <= 1.0 {
            return None;
        }
        let scale = limits.component_mul(&limits);
        let at = |share: f64| {
            Vector2::new(
                own.x / (1.0 + share / scale.x),
                own.y / (1.0 + share / scale.y),
            )
        };
        // The force falls with s in both components: at this s it lies in the ellipse.
        let (mut low, mut high) = (0.0, scale.max() * over(own));
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if over(at(middle)) > 1.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let force = at(high);
        Some(Vector2::new(
            c * force.x - s * force.y,
            s * force.x + c * force.y,
        ))
    }
}

/// The result of a bristle's step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Friction {
    /// On the roller, in N.
    pub force: Vector2<f64>,
    /// Heat of the slider.
    pub slip_j: f64,
    /// Heat of the bristle's damper.
    pub damping_j: f64,
    /// Whether the slider moves.
    pub slides: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: ContactLaw = ContactLaw {
        normal_stiffness_n_m: 1e6,
        normal_damping_n_s_m: 1e3,
        bristle_stiffness_n_m: 5e5,
        bristle_damping_n_s_m: 50.0,
        friction: 0.4,
        nap: None,
    };

    #[test]
    fn the_floor_never_pulls() {
        assert_eq!(LAW.normal_n(1e-5, -1.0), 0.0);
        assert_eq!(LAW.normal_n(1e-5, 0.0), 10.0);
    }

    #[test]
    fn a_steady_slide_has_coulombs_force_and_heat_whatever_the_damping() {
        let (mut z, u, h, normal) = (Vector2::zeros(), Vector2::new(0.3, -0.4), 1e-5, 20.0);
        let mut last = None;
        for _ in 0..2000 {
            last = Some(LAW.bend(&mut z, u, normal, h));
        }
        let friction = last.expect("steps were made");
        // mu N = 8 N against a slide of 0.5 m/s: 4 W. After 2000 steps of 5 us the deflection of
        // 16 um has long settled.
        assert!((friction.force - Vector2::new(-4.8, 6.4)).norm() < 1e-12);
        assert!((friction.slip_j / h - 4.0).abs() < 1e-9 && friction.damping_j < 1e-20);
        assert!(friction.slides);
    }

    #[test]
    fn the_cone_is_held_and_the_slider_takes_energy_through_any_history() {
        let (mut z, h) = (Vector2::zeros(), 1e-5);
        for i in 0..20_000 {
            let x = f64::from(i) * 1e-3;
            let u = Vector2::new(0.5 * (3.1 * x).sin(), 0.2 * (7.7 * x).cos());
            let normal = 30.0 * (0.9 * x).sin().max(0.0);
            let friction = LAW.bend(&mut z, u, normal, h);
            // Within rounding of the cone's size.
            assert!(friction.force.norm() <= 0.4 * normal * (1.0 + 1e-14));
            assert!(friction.slip_j >= -1e-18 && friction.damping_j >= 0.0);
        }
    }

    #[test]
    fn what_slides_nowhere_gives_its_energy_back() {
        // Deflected by 2 um and back without damping: a spring of 5e5 N/m below a cone of 8 N.
        let law = ContactLaw {
            bristle_damping_n_s_m: 0.0,
            ..LAW
        };
        let (mut z, h) = (Vector2::zeros(), 1e-5);
        for i in 0..200 {
            let u = Vector2::new(if i < 100 { 2e-3 } else { -2e-3 }, 0.0);
            let friction = law.bend(&mut z, u, 20.0, h);
            assert!(!friction.slides && friction.slip_j == 0.0);
        }
        // A hundred rounding errors of 2 um each way.
        assert!(z.norm() < 1e-18);
    }

    #[test]
    fn a_steady_slide_over_a_nap_has_the_force_that_takes_most() {
        // 0.4 along x and 0.2 across it, under 20 N: an ellipse of 8 and 4 N. Of the forces (8 cos
        // t, 4 sin t) the one against u dissipates most at tan t = 4 u_y / 8 u_x.
        let law = ContactLaw {
            nap: Some(Nap {
                angle_rad: 0.0,
                ratio: 0.5,
            }),
            ..LAW
        };
        let (mut z, u, h) = (Vector2::zeros(), Vector2::new(0.3, -0.4), 1e-5);
        let mut force = Vector2::zeros();
        for _ in 0..4000 {
            let friction = law.bend(&mut z, u, 20.0, h);
            assert!(friction.slip_j >= -1e-18);
            force = friction.force;
        }
        let t = (4.0_f64 * 0.4).atan2(8.0 * 0.3);
        let most = Vector2::new(-8.0 * t.cos(), 4.0 * t.sin());
        assert!((force - most).norm() < 1e-9, "{force} {most}");
        // The same in rotated axes.
        let turned = ContactLaw {
            nap: Some(Nap {
                angle_rad: 0.7,
                ratio: 0.5,
            }),
            ..LAW
        };
        let turn = nalgebra::Rotation2::new(0.7);
        let mut z = Vector2::zeros();
        for _ in 0..4000 {
            force = turned.bend(&mut z, turn * u, 20.0, h).force;
        }
        assert!((force - turn * most).norm() < 1e-9, "{force}");
    }
}
