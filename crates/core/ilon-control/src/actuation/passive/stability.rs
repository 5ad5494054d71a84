//! Which gains of a passive law are stable, given its period, the pose's period and delay, and the
//! tilt filter.
//!
//! **Wheels in the air**, or on ice, feel only their own inertia J. Held over dt, the damping A =
//! T^T D T + D_n N and stiffness K_n N make them oscillate from step to step from A dt / J = 2 on,
//! and the springs are unstable unless D_n > K_n dt / 2 (T = M^+ L, N = L P L / l^2).
//!
//! **The robot.** For a mass m, a spring delayed by tau, and the tilt filter H(s) = (k_p s + k_i) /
//! (s^2 + k_p s + k_i),
//!
//!   f(s) = m s^2 + D s + K e^(-tau s) - m s^2 H(s) e^(-tau_i s),
//!
//! whose last term is the robot's own acceleration, which an accelerometer mistakes for tilt. A
//! pose held over T counts as delayed by all of T: the limit of K T / D is then 1.57 instead of 2
//! where the mass does not matter, so accepted gains are stable. f has no pole on the right; by
//! Mikhailov all roots lie on the left if and only if its argument grows by pi as s = j omega goes
//! from 0 to infinity.

use ilon_robot::bisected;
use nalgebra::{Complex, DMatrix, Matrix3, Vector3};

use crate::{ControlError, DynamicModel, Kinematics};

/// Timing of the tilt filter and its sensor: see [`TiltFilter`](crate::TiltFilter).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltLoop {
    /// The filter's time constant, in seconds.
    pub time_constant_s: f64,
    /// Age of the IMU's samples, in seconds.
    pub delay_s: f64,
}

/// Returns the smallest mass of the body with all rotating parts, over all directions, in kg, and
/// its inertia about the vertical, in kg m^2.
pub(super) fn masses(model: &DynamicModel, about: &Kinematics) -> (f64, f64) {
    let inertia = body_inertia(model, about);
    let along = inertia.fixed_view::<2, 2>(0, 0).into_owned();
    (along.symmetric_eigenvalues().min(), inertia[(2, 2)])
}

/// Returns the largest A dt / J of wheels in the air, which are unstable from 2 on: for a damping
/// along x, along y and about z, and one between the wheels, both held over `dt_s` seconds.
pub(super) fn air_swing(
    model: &DynamicModel,
    about: &Kinematics,
    (damping, between_n_m_s): (Vector3<f64>, f64),
    dt_s: f64,
) -> f64 {
    let t = about.twist_matrix();
    let damping = Matrix3::from_diagonal(&damping);
    let mut whole: DMatrix<f64> = t.transpose() * damping * t;
    let lever_m = mean_lever_m(about.lever_m());
    let levers = nalgebra::DVector::from_column_slice(about.lever_m());
    let slides = DMatrix::from_diagonal(&levers) - about.m() * t;
    whole += slides.transpose() * &slides * (between_n_m_s / (lever_m * lever_m));
    let most = whole.symmetric_eigenvalues().max();
    most * dt_s / model.air_inertia_kg_m2()
}

/// The error for an unstable gain.
pub(super) fn unstable(what: &str, value: f64, most: f64, because: String) -> ControlError {
    ControlError::Unstable {
        what: what.to_owned(),
        value,
        most,
        because,
    }
}

/// Returns l: the mean of |rho cos gamma|, in metres.
pub(super) fn mean_lever_m(levers_m: &[f64]) -> f64 {
    levers_m.iter().map(|lever| lever.abs()).sum::<f64>() / levers_m.len() as f64
}

/// Returns the inertia of the body with all rotating parts, R^T I R, about the reference point of
/// `about`.
fn body_inertia(model: &DynamicModel, about: &Kinematics) -> Matrix3<f64> {
    let r = about.rate_matrix();
    (r.transpose() * model.inertia() * r)
        .fixed_view::<3, 3>(0, 0)
        .into()
}

/// One direction of motion: inertia in kg or kg m^2, damping, and delays.
#[derive(Clone, Copy)]
pub(super) struct Loop {
    pub inertia: f64,
    pub damping: f64,
    pub delay_s: f64,
    pub tilt: Option<TiltLoop>,
}

/// Largest turn of the argument between two samples of the curve, in rad.
const FINE: f64 = 0.1;
/// Largest number of samples: beyond it a spring oscillates so often within its delay that no gain
/// is stable.
const MOST_LOOKS: f64 = 4e5;

impl Loop {
    /// Rejects an unstable stiffness, named by `what`; `said` describes the pose's timing.
    pub fn check(&self, what: &str, stiffness: f64, said: &str) -> Result<(), ControlError> {
        if self.is_stable(stiffness) {
            return Ok(());
        }
        let most = self.stiffness_limit(stiffness);
        if let Some(tilt) = self.tilt.filter(|_| most < 1e-6 * stiffness) {
            return Err(self.too_fast(tilt, stiffness));
        }
        let tilt = self.tilt.map_or(String::new(), |tilt| {
            format!(
                " and a tilt {} s old, filtered over {} s",
                tilt.delay_s, tilt.time_constant_s
            )
        });
        let damping = self.damping;
        let because = format!("{said}{tilt}, at a damping of {damping:.4}");
        Err(unstable(what, stiffness, most, because))
    }

    /// The error for a filter with which no stiffness is stable; it names the fastest stable
    /// filter.
    fn too_fast(&self, tilt: TiltLoop, stiffness: f64) -> ControlError {
        let with = |pace: f64| Self {
            tilt: Some(TiltLoop {
                time_constant_s: 1.0 / pace,
                ..tilt
            }),
            ..*self
        };
        let paces = (0.0, 1.0 / tilt.time_constant_s);
        let (fastest, _) = bisected(paces, 30, |pace| with(pace).is_stable(stiffness));
        let (m, d) = (self.inertia, self.damping);
        unstable(
            "one over the tilt filter's time constant, in 1/s,",
            1.0 / tilt.time_constant_s,
            fastest,
            format!(
                "for {m:.4} kg at a damping of {d:.4} N s/m, whose own acceleration looks like tilt"
            ),
        )
    }

    /// Returns the largest stable stiffness below an unstable one.
    pub fn stiffness_limit(&self, unstable: f64) -> f64 {
        bisected((0.0, unstable), 40, |stiffness| self.is_stable(stiffness)).0
    }

    /// Whether the loop is stable, by Mikhailov's criterion.
    pub fn is_stable(&self, stiffness: f64) -> bool {
        let (m, d) = (self.inertia, self.damping);
        let filter_rad_s = self.tilt.map_or(0.0, |tilt| 2.0 / tilt.time_constant_s);
        // Above this frequency only the mass counts, to about a hundredth of a radian.
        let end_rad_s = 100.0 * (d / m + filter_rad_s) + 10.0 * libm::sqrt(stiffness / m);
        let late_s = self.tilt.map_or(0.0, |tilt| tilt.delay_s).max(self.delay_s);
        let step = FINE / late_s.max(1.0 / end_rad_s);
        let slowest = (stiffness / d).min(libm::sqrt(stiffness / m));
        let slowest = match self.tilt {
            Some(tilt) => slowest.min(1.0 / tilt.time_constant_s),
            None => slowest,
        };
        if end_rad_s / step > MOST_LOOKS || slowest <= 0.0 {
            return false;
        }
        let (mut omega, mut turned) = (0.0, 0.0);
        let mut last = Complex::new(stiffness, 0.0);
        while omega < end_rad_s {
            // Finer steps where the argument changes with the logarithm of omega.
            omega += step.min(FINE * (omega + 0.1 * slowest));
            let now = self.at(stiffness, omega);
            turned += (now * last.conj()).arg();
            last = now;
        }
        (turned - std::f64::consts::PI).abs() < 0.5
    }

    /// f(j omega).
    fn at(&self, stiffness: f64, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        let late = |by_s: f64| Complex::new(libm::cos(omega * by_s), -libm::sin(omega * by_s));
        let spring = late(self.delay_s) * stiffness;
        let accelerates = s * s * self.inertia;
        let taken_for_tilt = match self.tilt {
            None => Complex::new(0.0, 0.0),
            Some(tilt) => {
                let k_p = 2.0 / tilt.time_constant_s;
                let k_i = 0.25 * k_p * k_p;
                let top = s * k_p + k_i;
                accelerates * top / (s * s + top) * late(tilt.delay_s)
            }
        };
        accelerates + s * self.damping + spring - taken_for_tilt
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(inertia: f64, damping: f64, delay_s: f64) -> Loop {
        Loop {
            inertia,
            damping,
            delay_s,
            tilt: None,
        }
    }

    /// m s^2 + D s + K e^(-tau s) has roots +-j omega where tan(omega tau) = D / (m omega); there
    /// K = D omega / sin(omega tau).
    #[test]
    fn the_stiffness_limit_of_a_late_spring_is_that_of_the_characteristic_equation() {
        for (m, d, tau) in [(12.0, 120.0, 0.01), (12.0, 30.0, 0.1), (0.3, 5.0, 0.05)] {
            let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2 / tau);
            for _ in 0..60 {
                let omega: f64 = 0.5 * (low + high);
                if (omega * tau).tan() < d / (m * omega) {
                    low = omega;
                } else {
                    high = omega;
                }
            }
            let exact = d * low / (low * tau).sin();
            let found = of(m, d, tau).stiffness_limit(4.0 * exact);
            // A curve that passes the origin closer than the sampling resolves counts as either: a
            // tenth of a radian at a ten-thousandth.
            assert!((found / exact - 1.0).abs() < 1e-3, "{found} {exact}");
        }
    }

    /// Without delays m s^4 + D s^3 + (K + D k_p) s^2 + (K k_p + D k_i) s + K k_i: Routh's
    /// criterion says the same.
    #[test]
    fn an_accelerometer_that_takes_acceleration_for_tilt_is_stable_where_routh_says_so() {
        let mut found = [0, 0];
        for damping in [3.0, 10.0, 30.0, 100.0] {
            for stiffness in [10.0, 100.0, 1000.0, 10_000.0] {
                for time_constant_s in [0.02, 0.1, 0.5, 2.0] {
                    let m = 12.0;
                    let (k_p, k_i) = (
                        2.0 / time_constant_s,
                        1.0 / (time_constant_s * time_constant_s),
                    );
                    let [a3, a2, a1, a0] = [
                        damping,
                        stiffness + damping * k_p,
                        stiffness * k_p + damping * k_i,
                        stiffness * k_i,
                    ];
                    let routh = a3 * a2 * a1 > m * a1 * a1 + a3 * a3 * a0;
                    let tilt = Some(TiltLoop {
                        time_constant_s,
                        delay_s: 0.0,
                    });
                    let own = Loop {
                        tilt,
                        ..of(m, damping, 0.0)
                    };
                    assert_eq!(
                        own.is_stable(stiffness),
                        routh,
                        "{damping} {stiffness} {time_constant_s}"
                    );
                    found[usize::from(routh)] += 1;
                }
            }
        }
        assert!(found[0] > 5 && found[1] > 5, "{found:?}");
    }

    /// A mass on a spring whose force is held over a period and is a whole period old, simulated
    /// step by step: with accepted gains the motion does not grow.
    #[test]
    fn what_is_let_through_is_stable_sampled_and_three_times_it_is_not() {
        for (m, d, period, old) in [
            (12.0, 120.0, 0.02, 0),
            (12.0, 120.0, 0.02, 4),
            (0.2, 40.0, 0.05, 1),
        ] {
            let limit = of(m, d, period * f64::from(old + 1)).stiffness_limit(1e9);
            let grown = |stiffness: f64| {
                let (mut e, mut v) = (1.0, 0.0);
                let mut seen = vec![1.0; old as usize + 1];
                for _ in 0..4000 {
                    seen.rotate_right(1);
                    seen[0] = e;
                    let force = -stiffness * seen[old as usize];
                    // Exact for a force that is held.
                    let (a, settles) = (d / m, force / d);
                    let left = (-a * period).exp();
                    e += settles * period + (v - settles) * (1.0 - left) / a;
                    v = settles + (v - settles) * left;
                }
                f64::hypot(e, v)
            };
            assert!(grown(0.99 * limit) < 1e-3, "{m} {d} {period} {old}");
            let beyond = grown(3.0 * limit);
            assert!(beyond.is_nan() || beyond > 1.0, "{m} {d} {period} {old}");
        }
    }

    /// Damping between wheels of equal lever acts on each wheel with the value set, in N m s,
    /// whatever the lever: the wheel rates that move no body form a unit vector, and slides = (1 -
    /// P) l with the projector P on the rates that move the body.
    #[test]
    fn a_damping_between_the_wheels_is_one_of_wheel_rates() {
        let model = DynamicModel::new(&crate::tests::robots::mecanum4()).unwrap();
        let kinematics = model.kinematics();
        let (between_n_m_s, dt_s) = (0.02, 0.005);
        let swing = air_swing(&model, kinematics, (Vector3::zeros(), between_n_m_s), dt_s);
        let expected = between_n_m_s * dt_s / model.air_inertia_kg_m2();
        assert!((swing / expected - 1.0).abs() < 1e-9, "{swing} {expected}");
    }
}
