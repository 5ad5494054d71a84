//! Whether the wheel loops of a scenario can settle at the physics step.
//!
//! **A sampled loop** (`wheel_loop.timing = "sampled"`) holds its torque over the step T. A wheel of inertia J and bearing damping d, its rate w
//! off its target, its integral i and its filtered acceleration a go by
//!
//! a_k = (1 - f) a_(k-1) + f (w_k - w_(k-1)) / T,   i_k = i_(k-1) - k_i T w_k,
//! w_(k+1) = w_k + T / (J + d T) (-k_p w_k + i_k - k_d a_k - d w_k),
//!
//! f the weight of the newest change in the derivative's low-pass. That is a matrix on (w, i, a, w before), and the loop settles where and only
//! where its powers vanish. Without derivative this is Jury's 2 k_p T / J + k_i T^2 / J < 4 (`ilon_control`, wheel loops). J is what the wheel
//! feels: its own inertia in the air and while it slides, and a share of the robot's on the ground, which depends on the direction of motion.
//!
//! **A continuous loop** settles at any gain, but its torque falls within the step by as much as the wheel gains rate. Where that fall is
//! `STIFFEST` times what the wheel's inertia takes, the difference of the two is no longer computed to its digits, and motors and bearings are
//! given energies that they never had. A wheel that follows within a thousandth of a step follows at once, so that nothing is lost by less.

use ilon_control::DynamicModel;
use nalgebra::Matrix4;

use crate::Error;
use crate::scenario::{LoopTiming, Scenario, WheelLaw, WheelLoop};

/// The most that a continuous loop's torque may fall within a step, as a multiple of what the wheel's inertia on the ground takes.
const STIFFEST: f64 = 1e6;

/// The gains of a wheel loop and the period for which its torque is held.
#[derive(Clone, Copy, Debug)]
struct Loop {
    proportional_n_m_s: f64,
    integral_n_m: f64,
    derivative_n_m_s2: f64,
    /// f.
    weight: f64,
    period_s: f64,
}

/// A wheel as its loop feels it.
#[derive(Clone, Copy, Debug)]
struct Felt {
    inertia_kg_m2: f64,
    damping_n_m_s: f64,
}

impl Loop {
    /// Of a section whose gains are chosen.
    fn of(section: &WheelLoop, period_s: f64) -> Self {
        Self {
            proportional_n_m_s: section.proportional_n_m_s.unwrap_or(0.0),
            integral_n_m: section.integral_n_m.unwrap_or(0.0),
            derivative_n_m_s2: section.derivative_n_m_s2,
            weight: period_s / (section.derivative_filter_s + period_s),
            period_s,
        }
    }

    /// What a period makes of (w, i, a, w before).
    fn over_a_period(&self, wheel: &Felt) -> Matrix4<f64> {
        let Self {
            proportional_n_m_s: k_p,
            integral_n_m: k_i,
            derivative_n_m_s2: k_d,
            weight: f,
            period_s: t,
        } = *self;
        let d = wheel.damping_n_m_s;
        let g = t / (wheel.inertia_kg_m2 + d * t);
        #[rustfmt::skip]
        let over = Matrix4::new(
            1.0 - g * (k_p + k_i * t + k_d * f / t + d), g, -g * k_d * (1.0 - f), g * k_d * f / t,
            -k_i * t, 1.0, 0.0, 0.0,
            f / t, 0.0, 1.0 - f, -f / t,
            1.0, 0.0, 0.0, 0.0,
        );
        // Without an integral i is no state, and does not decay.
        if k_i == 0.0 {
            let mut without = over;
            without.row_mut(1).fill(0.0);
            return without;
        }
        over
    }

    /// Whether a wheel's rate settles.
    fn settles(&self, wheel: &Felt) -> bool {
        // So that rates, torques and accelerations are of a size.
        let (t, j) = (self.period_s, wheel.inertia_kg_m2);
        let units = [1.0, j / t, 1.0 / t, 1.0];
        let mut over = self.over_a_period(wheel);
        for (row, of_row) in units.iter().enumerate() {
            for (column, of_column) in units.iter().enumerate() {
                over[(row, column)] *= of_column / of_row;
            }
        }
        vanishes(over)
    }
}

/// Whether the powers of a matrix vanish.
fn vanishes(mut matrix: Matrix4<f64>) -> bool {
    /// After so many doublings a part in 10^7 below the bound is told from one above.
    const DOUBLINGS: usize = 30;
    /// What has shrunk to this, or grown to that, does so for good.
    const SMALL: f64 = 1e-6;
    const LARGE: f64 = 1e12;
    for _ in 0..DOUBLINGS {
        let size = matrix.norm();
        if !(SMALL..LARGE).contains(&size) {
            return size < SMALL;
        }
        matrix *= matrix;
    }
    false
}

/// What may be too much in a section: its key, and its value in a loop.
type Gain = (&'static str, fn(&mut Loop) -> &mut f64);

/// What a loop has of a gain.
fn value((_, gain): &Gain, mut of: Loop) -> f64 {
    *gain(&mut of)
}

const GAINS: [Gain; 3] = [
    ("proportional_n_m_s", |of| &mut of.proportional_n_m_s),
    ("integral_n_m", |of| &mut of.integral_n_m),
    ("derivative_n_m_s2", |of| &mut of.derivative_n_m_s2),
];

/// What the wheels' loops feel, in kg m^2 with the damping of the bearings: in the air and while sliding, and on the ground.
fn felt(model: &DynamicModel) -> ([Felt; 2], [Felt; 2]) {
    let damping = model.damping_n_m_s().iter().copied();
    let damping_n_m_s = damping.fold(f64::INFINITY, f64::min);
    let of = |inertia_kg_m2| Felt {
        inertia_kg_m2,
        damping_n_m_s,
    };
    let alone = model.wheel_inertias_kg_m2().iter().copied();
    let air = [
        of(alone.clone().fold(f64::INFINITY, f64::min)),
        of(alone.fold(0.0, f64::max)),
    ];
    // R^T I R v' = R^T R tau: the inertia in each direction of motion.
    let r = model.kinematics().rate_matrix();
    let (inertia, push) = (r.transpose() * model.inertia() * r, r.transpose() * r);
    let most = model.ground_inertia_kg_m2();
    let root = push.cholesky().and_then(|c| c.l().try_inverse());
    let least = root.map_or(most, |root| {
        (root * inertia * root.transpose())
            .symmetric_eigenvalues()
            .min()
    });
    (air, [of(least), of(most)])
}

/// What a person should know of the wheel loops of a scenario whose gains are chosen: `None` where they settle.
///
/// # Errors
/// [`Error::Invalid`] where a continuous loop is faster than can be computed with.
pub fn remark(
    scenario: &Scenario,
    model: &DynamicModel,
    physics_dt_s: f64,
) -> Result<Option<String>, Error> {
    let section = &scenario.wheel_loop;
    if section.law != WheelLaw::Pid {
        return Ok(None);
    }
    let own = Loop::of(section, physics_dt_s);
    match section.timing {
        LoopTiming::Continuous => {
            refuse_too_fast(section, &own, model.ground_inertia_kg_m2()).map(|()| None)
        }
        LoopTiming::Sampled => Ok(remark_of_sampled(&own, model)),
    }
}

fn refuse_too_fast(section: &WheelLoop, own: &Loop, inertia_kg_m2: f64) -> Result<(), Error> {
    let dt_s = own.period_s;
    let most_n_m_s = STIFFEST * inertia_kg_m2 / dt_s;
    let falls = [
        (own.proportional_n_m_s, 1.0),
        (own.integral_n_m, dt_s),
        (own.derivative_n_m_s2, own.weight / dt_s),
    ];
    let too_fast = GAINS
        .iter()
        .zip(falls)
        .find(|(_, (gain, per_gain))| gain * per_gain > most_n_m_s);
    let Some(((key, _), (gain, per_gain))) = too_fast else {
        return Ok(());
    };
    // J w_b and J w_b^2 / 4 follow from a bandwidth w_b, and the latter is the sooner too much.
    let w_b = section.bandwidth_rad_s;
    let chosen = match *key {
        "proportional_n_m_s" => inertia_kg_m2 * w_b,
        "integral_n_m" => 0.25 * inertia_kg_m2 * w_b * w_b,
        _ => f64::INFINITY,
    };
    let (key, value, most) = if (gain / chosen - 1.0).abs() < 1e-9 {
        ("bandwidth_rad_s", w_b, 2.0 * STIFFEST.sqrt() / dt_s)
    } else {
        (*key, gain, most_n_m_s / per_gain)
    };
    Err(Error::invalid(
        format!(
            "`wheel_loop.{key}` = {value} makes a wheel loop that is faster than can be computed with: in a step of {dt_s:.3e} s a wheel \
             reaches its target at once from far less on"
        ),
        format!("give no more than {}", rounded_down(most)),
    ))
}

fn remark_of_sampled(own: &Loop, model: &DynamicModel) -> Option<String> {
    let (air, ground) = felt(model);
    let all: Vec<Felt> = air.into_iter().chain(ground).collect();
    let settles = |of: &Loop, on: &[Felt]| on.iter().all(|wheel| of.settles(wheel));
    if settles(own, &all) {
        return None;
    }
    let place = match (settles(own, &air), settles(own, &ground)) {
        (false, true) => "a wheel that hangs in the air or slides swings",
        (true, false) => "wheels that roll on the ground swing",
        _ => "wheels swing, on the ground and in the air,",
    };
    let remedy = remedy(own, |of| settles(of, &all));
    Some(format!(
        "the wheel loops are unstable: with torques held for {:.3e} s {place} ever wider from sample to sample; {remedy}, or set \
         `wheel_loop.timing` = \"continuous\"",
        own.period_s
    ))
}

/// Which gain would do.
fn remedy(own: &Loop, settles: impl Fn(&Loop) -> bool) -> String {
    /// By which part a gain is lowered at a time, and how often at most.
    const LOWER: f64 = 0.95;
    const TIMES: usize = 600;
    let lowered = |gains: &[Gain]| {
        let mut of = *own;
        (0..TIMES).find_map(|_| {
            for (_, gain) in gains {
                *gain(&mut of) *= LOWER;
            }
            settles(&of).then_some(of)
        })
    };
    // The one that has to be lowered least.
    let share = |gain: &Gain, of: &Loop| value(gain, *of) / value(gain, *own);
    let one = GAINS
        .iter()
        .filter(|gain| value(gain, *own) > 0.0)
        .filter_map(|gain| Some((gain, lowered(&[*gain])?)))
        .max_by(|(a, of_a), (b, of_b)| share(a, of_a).total_cmp(&share(b, of_b)));
    let said = |gain: &Gain, of: Loop| {
        format!(
            "`wheel_loop.{}` to {}",
            gain.0,
            rounded_down(value(gain, of))
        )
    };
    match one {
        Some((gain, of)) => format!("lower {}", said(gain, of)),
        None => lowered(&GAINS).map_or_else(
            || "leave the gains out".to_owned(),
            |of| {
                let all: Vec<String> = GAINS.iter().map(|gain| said(gain, of)).collect();
                format!("lower {}", all.join(", "))
            },
        ),
    }
}

/// A number to three digits, rounded towards zero.
fn rounded_down(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let unit = 10.0_f64.powf(value.abs().log10().floor() - 2.0);
    let short = format!("{:.2e}", (value / unit).trunc() * unit);
    short.parse().map_or(short, |short: f64| short.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.002;
    const INERTIA_KG_M2: f64 = 1.5e-3;

    fn of(proportional: f64, integral: f64, derivative: f64, weight: f64) -> Loop {
        // Gains in units of J / T, J / T^2 and J.
        Loop {
            proportional_n_m_s: proportional * INERTIA_KG_M2 / PERIOD_S,
            integral_n_m: integral * INERTIA_KG_M2 / PERIOD_S.powi(2),
            derivative_n_m_s2: derivative * INERTIA_KG_M2,
            weight,
            period_s: PERIOD_S,
        }
    }

    const WHEEL: Felt = Felt {
        inertia_kg_m2: INERTIA_KG_M2,
        damping_n_m_s: 0.0,
    };

    /// Jury: with a and b the gains in these units the loop settles where and only where 2 a + b < 4; of the derivative alone, beside a small
    /// proportional gain, z^2 - (1 - a - c) z - c has its roots within the circle where c < 1 - a / 2.
    #[test]
    fn a_sampled_loop_settles_where_jury_says() {
        for a in [0.1, 0.7, 1.2, 1.9] {
            let most_b = 4.0 - 2.0 * a;
            assert!(of(a, 0.999 * most_b, 0.0, 1.0).settles(&WHEEL), "{a}");
            assert!(!of(a, 1.001 * most_b, 0.0, 1.0).settles(&WHEEL), "{a}");
            let most_c = 1.0 - 0.5 * a;
            assert!(of(a, 0.0, 0.999 * most_c, 1.0).settles(&WHEEL), "{a}");
            assert!(!of(a, 0.0, 1.001 * most_c, 1.0).settles(&WHEEL), "{a}");
        }
        // A slow filter lets a larger derivative gain through; damping d adds d T / J to a loop's room: a < 2 + 2 d T / J - d T / J.
        assert!(of(0.1, 0.0, 2.0, 0.1).settles(&WHEEL));
        let damped = Felt {
            damping_n_m_s: INERTIA_KG_M2 / PERIOD_S,
            ..WHEEL
        };
        assert!(of(2.999, 0.0, 0.0, 1.0).settles(&damped));
        assert!(!of(3.001, 0.0, 0.0, 1.0).settles(&damped));
    }

    #[test]
    fn the_gain_that_would_do_settles_and_is_near_the_bound() {
        let settles = |of: &Loop| of.settles(&WHEEL);
        let said = remedy(&of(8.0, 0.0, 0.0, 1.0), settles);
        let value: f64 = said
            .rsplit(' ')
            .next()
            .expect("a word")
            .parse()
            .expect("a number");
        let bound = 2.0 * INERTIA_KG_M2 / PERIOD_S;
        assert!(said.contains("proportional_n_m_s"), "{said}");
        assert!(value < bound && value > 0.9 * bound, "{said}");
        assert!(remedy(&of(0.5, 0.0, 3.0, 1.0), settles).contains("derivative_n_m_s2"));
    }
}
