//! A roller against the floor: a spring and a damper along the normal, a bristle across it.
//!
//! **Normal.** At the depth d the floor pushes with N = max(0, k_n d + c_n d.): it never pulls.
//!
//! **Friction.** A bristle of stiffness k_t and damping c_t stands in line with a slider that holds |F| <= mu N (Coulomb).
//! Its bend **z** grows by the sliding velocity **u** of the roller's material against the floor as long as the slider holds:
//!
//! ```text
//! F = -k_t z - c_t z.,   z. = u               while |F| <= mu N
//! |F| = mu N,            z. = u - slip        else, the slip along -F
//! ```
//!
//! Over a step of length h the bend is found implicitly. Trial: z* = z + h u and F* = -k_t z* - c_t u. Where |F*| exceeds mu N,
//! F = mu N F* / |F*|, and the bend that gives this force is z' = (c_t z / h - F) / (k_t + c_t / h). The cone is held exactly, the
//! friction of a steady slide is mu N against **u** whatever the damping, and F . slip is never positive: the slider only
//! takes energy.
//!
//! The force acts at the roller's lowest point, so that the rolling radius is that of the rigid wheel. As k_n and k_t grow, the
//! law tends to that of rigid contacts with Coulomb friction and without rebound.

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
    /// mu.
    pub friction: f64,
}

/// Bristles of two thirds of the normal stiffness: what an incompressible half-space has (Mindlin: 2 (1 - nu) / (2 - nu) at
/// nu = 0.5).
const BRISTLE_SHARE: f64 = 2.0 / 3.0;
/// Damping of the robot bouncing on its wheels, of critical.
const NORMAL_DAMPING_RATIO: f64 = 0.7;
/// Damping of a roller that turns to and fro on its bristle, of critical.
const BRISTLE_DAMPING_RATIO: f64 = 0.5;

impl ContactLaw {
    /// A floor of this stiffness in N/m and this friction: bristles of 2/3 of it; a robot bouncing on its wheels is damped to
    /// 0.7 of critical, a roller turning to and fro on its bristle to 0.5. Grows to the rigid limit with the stiffness.
    pub fn stiff(normal_stiffness_n_m: f64, friction: f64, robot: &Robot) -> Self {
        let bristle_stiffness_n_m = BRISTLE_SHARE * normal_stiffness_n_m;
        let on_each_kg = robot.mass_kg() / robot.wheels.len() as f64;
        let rollers = robot.wheels.iter().flat_map(|w| &w.rollers);
        let lightest_kg = rollers
            .map(|r| r.axial_inertia_kg_m2 / (r.radius_m * r.radius_m))
            .fold(f64::INFINITY, f64::min);
        let critical = |k: f64, m: f64| 2.0 * (k * m).sqrt();
        Self {
            normal_stiffness_n_m,
            normal_damping_n_s_m: NORMAL_DAMPING_RATIO * critical(normal_stiffness_n_m, on_each_kg),
            bristle_stiffness_n_m,
            bristle_damping_n_s_m: BRISTLE_DAMPING_RATIO
                * critical(bristle_stiffness_n_m, lightest_kg),
            friction,
        }
    }

    pub(crate) fn check(&self) -> Result<(), OracleError> {
        let Self {
            normal_stiffness_n_m,
            normal_damping_n_s_m,
            bristle_stiffness_n_m,
            bristle_damping_n_s_m,
            friction,
        } = *self;
        for (setting, value, positive) in [
            ("normal_stiffness_n_m", normal_stiffness_n_m, true),
            ("normal_damping_n_s_m", normal_damping_n_s_m, false),
            ("bristle_stiffness_n_m", bristle_stiffness_n_m, true),
            ("bristle_damping_n_s_m", bristle_damping_n_s_m, false),
            ("friction", friction, false),
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

    /// N of a contact at this depth, deepening at this rate, in N.
    pub(crate) fn normal_n(&self, depth_m: f64, deepening_m_s: f64) -> f64 {
        let spring = self.normal_stiffness_n_m * depth_m;
        (spring + self.normal_damping_n_s_m * deepening_m_s).max(0.0)
    }

    /// Bends the bristle through a step of `h` seconds under the normal force `normal_n` and the sliding velocity `u`.
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
        let size = trial.norm();
        let (force, after, slip) = if size <= limit {
            (trial, before + h * u, Vector2::zeros())
        } else {
            let force = trial * (limit / size);
            let after = (before * (c / h) - force) / (k + c / h);
            (force, after, h * u - (after - before))
        };
        *z = after;
        Friction {
            force,
            slip_j: -force.dot(&slip),
            damping_j: c * (after - before).norm_squared() / h,
            slides: size > limit,
        }
    }
}

/// What a bristle does in a step.
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
        // mu N = 8 N against a slide of 0.5 m/s: 4 W. After 2000 steps of 5 um each the bend of 16 um has long settled.
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
            // A rounding of the cone's own size.
            assert!(friction.force.norm() <= 0.4 * normal * (1.0 + 1e-14));
            assert!(friction.slip_j >= -1e-18 && friction.damping_j >= 0.0);
        }
    }

    #[test]
    fn what_slides_nowhere_gives_its_energy_back() {
        // Bent by 2 um and back without damping: a spring of 5e5 N/m below a cone of 8 N.
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
        // A hundred roundings of 2 um each way.
        assert!(z.norm() < 1e-18);
    }
}
