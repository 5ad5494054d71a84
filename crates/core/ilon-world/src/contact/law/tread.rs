//! Soft rollers: the law of a contact with a tread between the roller's core and the ground.
//!
//! **Along the normal** a spring k is parallel to a damper c that only pushes: F = max(0, -k g - c
//! g'), g the gap between core and ground. **Across it** a bristle of stiffness k_t and damping c_t
//! is in series with a slider that holds |F| <= mu N:
//!
//! F = -k_t s - c_t s',  s' = u - slip - nu s,  nu = |V| / lambda + ...,
//!
//! with u the velocity of the core's surface over the ground, and nu the rate at which sheared
//! tread leaves the ground and fresh tread replaces it, because the contact point moves over the
//! ground with V. A roller that rolls under a force F therefore creeps at u = nu F / k_t.
//!
//! **In a step** of length h, from u_0 to u_1, both are laws between the impulse p = h F and u_1.
//! For the mean force, with the mean of the velocities, that is the trapezoidal rule, of second
//! order:
//!
//! F = -k (g_0 + h (a u_0 + b u_1)) - c ((1 - q) u_0 + q u_1),  a = b = 1/4, q = 1/2.
//!
//! A stiff spring would oscillate for ever under it. The implicit rule has a = 0, b = q = 1, and
//! damps what a step does not resolve. So the two are blended by how far the spring's own motion
//! exceeds the step, z = h sqrt(k / m): with a share z^2 / (4 + z^2) of the implicit rule. The
//! order stays two if the step resolves the spring, and any step is stable. A gap that is still
//! open is closed by the implicit rule, without a damper: a landing then gains no energy.

use nalgebra::Vector2;

/// A spring parallel to a damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spring {
    /// Stiffness, in N/m.
    pub stiffness_n_m: f64,
    /// Damping, in N s/m.
    pub damping_n_s_m: f64,
}

/// A tread under the load of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TreadLaw {
    /// Along the normal.
    pub normal: Spring,
    /// Across it.
    pub shear: Spring,
    /// 1 / lambda, in 1/m: the share of sheared tread that leaves the ground per metre rolled.
    pub renewal_1_m: f64,
    /// The mass supported by a wheel, in kg.
    pub load_kg: f64,
}

/// A contact's law along one direction: u + bias + compliance p = 0 while it holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Softness {
    /// Compliance, in m/s per N s.
    pub compliance: f64,
    /// Bias, in m/s.
    pub bias_m_s: f64,
}

/// The weights of the two rules in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Blend {
    /// The share of the implicit rule.
    implicit: f64,
    a: f64,
    b: f64,
    q: f64,
}

impl Blend {
    fn of(implicit: f64) -> Self {
        Self {
            implicit,
            a: 0.25 * (1.0 - implicit),
            b: 0.25 + 0.75 * implicit,
            q: 0.5 * (1.0 + implicit),
        }
    }

    /// For a spring that moves a mass, given by its inverse in 1/kg, in a step.
    fn for_spring(spring: &Spring, per_kg: f64, dt_s: f64) -> Self {
        let z_squared = spring.stiffness_n_m * per_kg * dt_s * dt_s;
        Self::of(z_squared / (4.0 + z_squared))
    }
}

/// The least response in D, to avoid a division by zero: a tread that is wholly renewed in a step
/// holds nothing.
const LEAST_N_S_M: f64 = 1e-30;

/// The normal law of a tread in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Press {
    pub spring: Spring,
    /// The gap at the beginning of the step, in metres, and its rate then, in m/s.
    pub gap_m: f64,
    pub opening_m_s: f64,
    /// Its force at the beginning of the step, in N.
    pub load_n: f64,
    pub softness: Softness,
}

impl TreadLaw {
    /// Along the normal, in a step of `dt_s` from a gap in metres that opens at a rate in m/s.
    pub fn press(&self, gap_m: f64, opening_m_s: f64, dt_s: f64) -> Press {
        let is_open = gap_m > 0.0;
        let spring = Spring {
            damping_n_s_m: if is_open {
                0.0
            } else {
                self.normal.damping_n_s_m
            },
            ..self.normal
        };
        let blend = if is_open {
            Blend::of(1.0)
        } else {
            Blend::for_spring(&spring, 1.0 / self.load_kg, dt_s)
        };
        let (k, c) = (spring.stiffness_n_m, spring.damping_n_s_m);
        let d = k * dt_s * blend.b + c * blend.q;
        let bias = k * gap_m + (k * dt_s * blend.a + c * (1.0 - blend.q)) * opening_m_s;
        Press {
            spring,
            gap_m,
            opening_m_s,
            load_n: (-k * gap_m - c * opening_m_s).max(0.0),
            softness: Softness {
                compliance: 1.0 / (dt_s * d),
                bias_m_s: bias / d,
            },
        }
    }

    /// Across the normal, in a step of `dt_s`: from a deflection in metres that the surface changes
    /// at a rate in m/s, along each of two tangents; across them the contact's response to an
    /// impulse is given in 1/kg, and `renewed_1_s` is nu of each.
    pub fn shear(
        &self,
        (bend_m, rate_m_s): (Vector2<f64>, Vector2<f64>),
        per_kg: [f64; 2],
        renewed_1_s: [f64; 2],
        dt_s: f64,
    ) -> Shear {
        Shear::new(&self.shear, (bend_m, rate_m_s), per_kg, renewed_1_s, dt_s)
    }
}

impl Press {
    /// The spring's energy after the gap has changed with the mean of its rates, in J; zero if the
    /// spring does not push.
    pub fn stored_j(&self, opens_m_s: f64, pushes: bool, dt_s: f64) -> f64 {
        let gap_m = self.gap_m + 0.5 * dt_s * (self.opening_m_s + opens_m_s);
        if pushes {
            0.5 * self.spring.stiffness_n_m * gap_m.min(0.0).powi(2)
        } else {
            0.0
        }
    }
}

/// The shear law of a tread in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shear {
    stiffness_n_m: f64,
    bend_m: Vector2<f64>,
    rate_m_s: Vector2<f64>,
    /// The share of the deflection along each tangent that renewal leaves.
    left: [f64; 2],
    /// The share of the deflection's change that follows the velocity after the step, along each
    /// tangent; the rest follows that before it.
    after: [f64; 2],
    /// The share of its distance from the deflection by its friction alone that a sliding bristle
    /// keeps over the step: its damper lets it follow no faster.
    lags: f64,
    pub softness: [Softness; 2],
}

impl Shear {
    fn new(
        spring: &Spring,
        (bend_m, rate_m_s): (Vector2<f64>, Vector2<f64>),
        per_kg: [f64; 2],
        renewed_1_s: [f64; 2],
        dt_s: f64,
    ) -> Self {
        let (k, c) = (spring.stiffness_n_m, spring.damping_n_s_m);
        let left = renewed_1_s.map(|renewed_1_s| 1.0 / (1.0 + renewed_1_s * dt_s));
        let mut softness = [Softness::default(); 2];
        let mut after = [0.5; 2];
        for i in 0..2 {
            let left = left[i];
            let blend = Blend::for_spring(spring, per_kg[i], dt_s);
            let d = left * (k * dt_s * blend.b + c * blend.q);
            let d = d.max(LEAST_N_S_M);
            // For the initial deflection: its mean over the step, and the damper's velocity by its
            // renewal.
            let kept = 0.5 * (1.0 - blend.implicit) * (1.0 + left) + blend.implicit * left;
            let of_bend = k * kept - c * (1.0 - left) / dt_s;
            let of_rate = left * (k * dt_s * blend.a + c * (1.0 - blend.q));
            after[i] = 0.5 * (1.0 + blend.implicit);
            softness[i] = Softness {
                compliance: 1.0 / (dt_s * d),
                bias_m_s: (of_bend * bend_m[i] + of_rate * rate_m_s[i]) / d,
            };
        }
        Self {
            stiffness_n_m: k,
            bend_m,
            rate_m_s,
            left,
            after,
            lags: libm::exp(-k * dt_s / c),
            softness,
        }
    }

    /// The deflection after the step, in metres, for the surface's velocity then; of a sliding one
    /// by its friction in N, from F = -k_t s - c_t s'.
    pub fn bent_m(
        &self,
        after_m_s: Vector2<f64>,
        slides_under_n: Option<Vector2<f64>>,
        dt_s: f64,
    ) -> Vector2<f64> {
        match slides_under_n {
            Some(friction_n) => {
                let held_m = -friction_n / self.stiffness_n_m;
                held_m + self.lags * (self.bend_m - held_m)
            }
            // By the rule of its force: if the deflection of a roller that a step stops at once
            // were the mean of its rates, it would store more energy than the roller had.
            None => {
                let bent = |i: usize| {
                    let mean_m_s =
                        (1.0 - self.after[i]) * self.rate_m_s[i] + self.after[i] * after_m_s[i];
                    self.left[i] * (self.bend_m[i] + dt_s * mean_m_s)
                };
                Vector2::new(bent(0), bent(1))
            }
        }
    }

    /// The energy of a bristle with this deflection, in J.
    pub fn stored_j(&self, bend_m: &Vector2<f64>) -> f64 {
        0.5 * self.stiffness_n_m * bend_m.norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: TreadLaw = TreadLaw {
        normal: Spring {
            stiffness_n_m: 1e5,
            damping_n_s_m: 0.0,
        },
        shear: Spring {
            stiffness_n_m: 4e4,
            damping_n_s_m: 3.0,
        },
        renewal_1_m: 0.0,
        load_kg: 2.0,
    };

    /// A mass of 2 kg on the spring alone, from 10 um deep: gap and rate after a time.
    fn bounced(steps: u32, time_s: f64) -> (f64, f64) {
        let h = time_s / f64::from(steps);
        let (mut gap_m, mut rate) = (-1e-5, 0.0);
        for _ in 0..steps {
            let softness = LAW.press(gap_m, rate, h).softness;
            // u_1 = u_0 + p / m, u_1 + bias + compliance p = 0.
            let p = -(rate + softness.bias_m_s) / (0.5 + softness.compliance);
            let after = rate + 0.5 * p;
            gap_m += 0.5 * h * (rate + after);
            rate = after;
        }
        (gap_m, rate)
    }

    #[test]
    fn a_resolved_spring_is_followed_to_second_order() {
        // An eighth of a period of sqrt(1e5 / 2) = 223.6 rad/s: the gap is -1e-5 cos(pi/4), still
        // closed.
        let omega = (1e5_f64 / 2.0).sqrt();
        let time_s = std::f64::consts::FRAC_PI_4 / omega;
        let exact = -1e-5 * std::f64::consts::FRAC_PI_4.cos();
        let error = |steps| (bounced(steps, time_s).0 - exact).abs();
        let (coarse, fine) = (error(20), error(40));
        // Second order: an error four times smaller at half the step; the next order contributes at
        // most a tenth.
        assert!((coarse / fine - 4.0).abs() < 0.4, "{coarse} {fine}");
    }

    #[test]
    fn a_spring_far_beyond_the_step_is_damped_and_not_rung() {
        // z = 223.6 * 0.2 = 45: after twenty steps no oscillation of the 10 um may remain.
        let (gap_m, rate) = bounced(20, 4.0);
        assert!(gap_m.abs() < 1e-8 && rate.abs() < 1e-7, "{gap_m} {rate}");
    }

    /// The spring in a bristle that stops a light roller within a step stores no more energy than
    /// the roller had, whatever the step.
    #[test]
    fn a_bristle_that_stops_a_roller_in_a_step_holds_no_more_than_the_roller_had() {
        // 2 g at 0.1 m/s: 10 uJ. z = sqrt(4e4 / 2e-3) h goes from 0.4 to 45.
        let (mass_kg, rate) = (2e-3, 0.1);
        for h in [1e-4, 5e-4, 2.5e-3, 1e-2] {
            let start = (Vector2::zeros(), Vector2::new(rate, 0.0));
            let shear = LAW.shear(start, [1.0 / mass_kg; 2], [0.0; 2], h);
            let softness = shear.softness[0];
            let p = -(rate + softness.bias_m_s) / (1.0 / mass_kg + softness.compliance);
            let after = rate + p / mass_kg;
            let bend = shear.bent_m(Vector2::new(after, 0.0), None, h);
            let had_j = 0.5 * mass_kg * rate * rate;
            let left_j = 0.5 * mass_kg * after * after;
            assert!(
                shear.stored_j(&bend) + left_j <= had_j * (1.0 + 1e-12),
                "{h}: {} J of {had_j}",
                shear.stored_j(&bend)
            );
        }
    }

    /// Deflection and force of a step follow one rule: the deflection at the end and the force of
    /// the step agree.
    #[test]
    fn a_bristle_bends_by_the_velocities_weighed_as_its_force_weighs_them() {
        // From rest and undeflected, without damper and renewal: F = -k h b u_1 in the mean of the
        // step, b = 1/4 + 3/4 z with the implicit share z, and the deflection at its end is h (1 +
        // z) / 2 u_1: half of it by the trapezoidal rule, all of it by the implicit one.
        let law = TreadLaw {
            shear: Spring {
                damping_n_s_m: 0.0,
                ..LAW.shear
            },
            ..LAW
        };
        for (h, per_kg) in [(1e-5, 0.5), (1e-3, 50.0), (1e-2, 500.0)] {
            let z_squared = 4e4 * per_kg * h * h;
            let implicit = z_squared / (4.0 + z_squared);
            let still = (Vector2::zeros(), Vector2::zeros());
            let shear = law.shear(still, [per_kg; 2], [0.0; 2], h);
            let compliance = 1.0 / (h * 4e4 * h * (0.25 + 0.75 * implicit));
            let bend_m = shear.bent_m(Vector2::new(0.1, -0.2), None, h);
            let expected = h * 0.5 * (1.0 + implicit) * Vector2::new(0.1, -0.2);
            let relative = (shear.softness[0].compliance - compliance) / compliance;
            assert!(relative.abs() < 1e-14, "{h}: {relative}");
            assert!(
                (bend_m - expected).norm() < 1e-14 * h,
                "{h}: {bend_m} {expected}"
            );
        }
    }

    /// Under a constant friction F its law F = -k s - c s' lets it approach -F / k as exp(-k t /
    /// c), in one step or in a hundred; without a damper it is there at once.
    #[test]
    fn a_bristle_that_slides_follows_its_friction_no_faster_than_its_damper_lets_it() {
        let (friction_n, time_s) = (Vector2::new(1.0, -2.0), 2e-4);
        let slid_m = |law: &TreadLaw, steps: u32| {
            let h = time_s / f64::from(steps);
            (0..steps).fold(Vector2::new(3e-5, 1e-5), |bend_m, _| {
                let moved = (bend_m, Vector2::zeros());
                let shear = law.shear(moved, [50.0; 2], [30.0; 2], h);
                shear.bent_m(Vector2::new(0.3, 0.1), Some(friction_n), h)
            })
        };
        let held_m = -friction_n / 4e4;
        // k t / c = 8 / 3.
        let expected_m = held_m + (Vector2::new(3e-5, 1e-5) - held_m) * libm::exp(-8.0 / 3.0);
        for steps in [1, 100] {
            let off_m = (slid_m(&LAW, steps) - expected_m).norm();
            assert!(off_m < 1e-18, "{steps}: {off_m}");
        }
        let mut undamped = LAW;
        undamped.shear.damping_n_s_m = 0.0;
        assert_eq!(slid_m(&undamped, 1), held_m);
    }

    #[test]
    fn a_roller_that_rolls_under_a_pull_creeps_by_the_pull_over_the_creep_stiffness() {
        // V = 0.2 m/s over lambda = 5 mm: nu = 40/s. A steady u of 1 mm/s deflects by u / nu = 25
        // um, 1 N at 4e4 N/m.
        let (nu, u, h) = (40.0, 1e-3, 2e-3);
        let mut bend = Vector2::zeros();
        let steady = Vector2::new(u, 0.0);
        for _ in 0..2000 {
            let shear = LAW.shear((bend, steady), [0.5, 500.0], [nu; 2], h);
            bend = shear.bent_m(steady, None, h);
        }
        let shear = LAW.shear((bend, steady), [0.5, 500.0], [nu; 2], h);
        let p = -(u + shear.softness[0].bias_m_s) / shear.softness[0].compliance;
        // Steady for 2000 steps of a twelfth each; what remains is rounding.
        assert!((bend.x - 25e-6).abs() < 1e-15, "{}", bend.x);
        assert!((p / h + 1.0).abs() < 1e-9, "{}", p / h);
    }
}
