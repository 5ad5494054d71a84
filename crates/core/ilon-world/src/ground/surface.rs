//! Contact properties of ground: rolling resistance, creep and friction by direction.
//!
//! Over a nap, with a and c the directions along it and across it, V the velocity of the contact
//! point over the ground, N its load, F the friction on the roller and u the velocity of its
//! surface over the ground:
//!
//! **Rolling resistance.** Rolling takes the power N h(V), h = sqrt(c_a^2 V_a^2 + c_c^2 V_c^2),
//! with c_a along the nap if V_a > 0 and against it if V_a < 0. The two half ellipses meet at V_a =
//! 0 with one tangent, so that h is convex and never negative. The drag is the gradient N dh / dV:
//! at an angle to the nap it has a lateral part too.
//!
//! **Creep.** u = |V| C F / N, C with the eigenvalues creep along a and across c. F . u = |V| F . C
//! F / N takes power, because C is positive.
//!
//! **Friction** lies in an ellipse, |(F_a / mu_a, F_c / mu_c)| <= N, and when it slides, u is
//! opposed to F along the ellipse's normal (an associated law). Friction and creep are the same
//! with the nap and against it: an asymmetric cone or creep is not a quadratic law, and would need
//! another solver.

use crate::WorldError;
use crate::error::{FINITE, NOT_NEGATIVE, POSITIVE, check_numbers};

/// The contact properties of ground for a roller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSurface {
    /// Coulomb friction coefficient, >= 0; along its nap, if it has one.
    pub friction: f64,
    /// The other properties.
    pub surface: FloorSurface,
}

impl ContactSurface {
    /// Refuses invalid values.
    pub(super) fn check(&self) -> Result<(), WorldError> {
        check_numbers([("friction", self.friction, NOT_NEGATIVE)])?;
        self.surface.check()
    }
}

/// Contact properties of ground besides its friction. The default is hard ground under Coulomb's
/// law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FloorSurface {
    /// Rolling resistance: energy per metre by which a contact point moves over the ground, per
    /// newton of load; dimensionless, >= 0. That of the rollers is added.
    pub rolling_resistance: f64,
    /// Growth of rolling resistance on small radii: (wheel radius / radius of curvature of the
    /// roller in the direction of travel) to this power; 0 to 1. With 0 a metre costs the same on
    /// all radii, with 1/2 as on a layer that loses a share of its compression, with 1 as with a
    /// constant lever arm.
    pub radius_exponent: f64,
    /// Creep: slip of a roller per distance that its contact point moves, per share of its load
    /// that it pulls with; dimensionless, >= 0. Force against slip is then linear up to the
    /// friction limit.
    pub creep: f64,
    /// Decrease of friction with sliding speed; `None` for constant friction.
    pub sliding: Option<Stribeck>,
    /// Dependence on direction; `None` for isotropic ground.
    pub nap: Option<Nap>,
}

/// A nap or a weave: ground with other friction, rolling resistance and creep across a direction
/// than along it, and other rolling resistance against it. The values in [`FloorSurface`], and the
/// friction, are those along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nap {
    /// The direction of the nap, as an angle from the floor's x axis, counter-clockwise, in
    /// radians.
    pub angle_rad: f64,
    /// Friction across it over that along it, > 0.
    pub friction_ratio: f64,
    /// Creep across it, >= 0.
    pub creep_across: f64,
    /// Rolling resistance across it, >= 0.
    pub resistance_across: f64,
    /// Rolling resistance against it, >= 0.
    pub resistance_against: f64,
}

/// Friction that falls with the sliding speed v, from the floor's mu at rest: mu' + (mu - mu')
/// exp(-(v / speed)^2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// mu', the coefficient at speed, >= 0.
    pub friction: f64,
    /// The speed over which it falls, in m/s, > 0.
    pub speed_m_s: f64,
}

impl FloorSurface {
    /// The friction coefficient of a roller that slides at a speed in m/s, from that at rest.
    pub(crate) fn friction_at_speed(&self, at_rest: f64, sliding_m_s: f64) -> f64 {
        match &self.sliding {
            None => at_rest,
            Some(stribeck) => {
                let share = libm::exp(-(sliding_m_s / stribeck.speed_m_s).powi(2));
                stribeck.friction + (at_rest - stribeck.friction) * share
            }
        }
    }

    /// Creep along its nap and across it; without a nap twice the same.
    pub(crate) fn creeps(&self) -> [f64; 2] {
        let across = self.nap.map_or(self.creep, |nap| nap.creep_across);
        [self.creep, across]
    }

    /// Whether it has rolling resistance.
    pub(crate) fn drags(&self) -> bool {
        let by_nap = |nap: &Nap| nap.resistance_across > 0.0 || nap.resistance_against > 0.0;
        self.rolling_resistance > 0.0 || self.nap.as_ref().is_some_and(by_nap)
    }

    /// Whether its rolling resistance depends on direction.
    pub(crate) fn drags_by_direction(&self) -> bool {
        let alike = [self.rolling_resistance; 2];
        let differs = |nap: &Nap| [nap.resistance_across, nap.resistance_against] != alike;
        self.nap.as_ref().is_some_and(differs)
    }

    /// Rolling resistance along the nap and across it for a contact point with this velocity along
    /// it: rolling takes the power N sqrt(c_along^2 V_along^2 + c_across^2 V_across^2). At zero
    /// velocity along it, the largest value.
    pub(crate) fn resistances(&self, along_m_s: f64) -> [f64; 2] {
        let with = self.rolling_resistance;
        let (across, against) = self.nap.map_or((with, with), |nap| {
            (nap.resistance_across, nap.resistance_against)
        });
        let along = if along_m_s > 0.0 {
            with
        } else if along_m_s < 0.0 {
            against
        } else {
            with.max(against)
        };
        [along, across]
    }

    /// Refuses invalid values.
    fn check(&self) -> Result<(), WorldError> {
        check_numbers([
            ("rolling_resistance", self.rolling_resistance, NOT_NEGATIVE),
            ("radius_exponent", self.radius_exponent, NOT_NEGATIVE),
            ("creep", self.creep, NOT_NEGATIVE),
        ])?;
        if let Some(sliding) = &self.sliding {
            check_numbers([
                ("sliding.friction", sliding.friction, NOT_NEGATIVE),
                ("sliding.speed_m_s", sliding.speed_m_s, POSITIVE),
            ])?;
        }
        let Some(nap) = &self.nap else {
            return Ok(());
        };
        let (across, against) = (nap.resistance_across, nap.resistance_against);
        check_numbers([
            ("nap.angle_rad", nap.angle_rad, FINITE),
            ("nap.friction_ratio", nap.friction_ratio, POSITIVE),
            ("nap.creep_across", nap.creep_across, NOT_NEGATIVE),
            ("nap.resistance_across", across, NOT_NEGATIVE),
            ("nap.resistance_against", against, NOT_NEGATIVE),
        ])
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    const CARPET: FloorSurface = FloorSurface {
        rolling_resistance: 0.1,
        radius_exponent: 0.0,
        creep: 0.3,
        sliding: None,
        nap: Some(Nap {
            angle_rad: 0.0,
            friction_ratio: 0.8,
            creep_across: 0.5,
            resistance_across: 0.2,
            resistance_against: 0.15,
        }),
    };

    /// The power of rolling over the load.
    fn power(way: Vector2<f64>) -> f64 {
        let [along, across] = CARPET.resistances(way.x);
        libm::hypot(along * way.x, across * way.y)
    }

    #[test]
    fn friction_falls_as_a_bell_of_the_sliding_speed() {
        // From 0.6 at rest to 0.2 at speed over 0.1 m/s: of the difference, 0.4, a share of exp(-(v
        // / 0.1)^2) remains at v.
        let surface = FloorSurface {
            sliding: Some(Stribeck {
                friction: 0.2,
                speed_m_s: 0.1,
            }),
            ..CARPET
        };
        for (v, left) in [
            (0.0, 1.0),
            (0.05, (-0.25_f64).exp()),
            (0.2, (-4.0_f64).exp()),
        ] {
            let expected = 0.2 + 0.4 * left;
            // Two libraries' exponentials, and a handful of roundings.
            assert!(
                (surface.friction_at_speed(0.6, v) - expected).abs() < 1e-15,
                "{v}"
            );
        }
        assert_eq!(CARPET.friction_at_speed(0.6, 0.05), 0.6);
    }

    #[test]
    fn along_across_and_against_a_nap_it_drags_as_stated() {
        assert_eq!(CARPET.resistances(0.3), [0.1, 0.2]);
        assert_eq!(CARPET.resistances(-0.3), [0.15, 0.2]);
        // At rest the direction is undefined: the largest value.
        assert_eq!(CARPET.resistances(0.0), [0.15, 0.2]);
        let hard = FloorSurface {
            nap: None,
            ..CARPET
        };
        assert_eq!(hard.resistances(-0.3), [0.1, 0.1]);
    }

    #[test]
    fn rolling_over_a_nap_always_takes_power_and_is_convex() {
        // For a convex power only rest costs nothing, and its mean over two velocities is no less
        // than the power of the mean velocity.
        let mut state = 7_u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 23) - 1.0
        };
        for _ in 0..10_000 {
            let (a, b) = (Vector2::new(draw(), draw()), Vector2::new(draw(), draw()));
            assert!(power(a) > 0.0);
            assert!((power(2.0 * a) - 2.0 * power(a)).abs() < 1e-14);
            assert!(power(0.5 * (a + b)) <= 0.5 * (power(a) + power(b)) + 1e-15);
        }
    }
}
