//! Checks whether the wheel loops of a scenario are stable at the physics step.
//!
//! **A sampled loop** (`wheel_loop.timing = "sampled"`) holds its torque over the step T. For a
//! wheel of inertia J and bearing damping d, the deviation w of its rate from its target, the
//! integral i and the filtered acceleration a obey
//!
//! - a_k = (1 - f) a_(k-1) + f (w_k - w_(k-1)) / T,
//! - i_k = i_(k-1) - k_i T w_k,
//! - w_(k+1) = w_k + T / (J + d T) (-k_p w_k + i_k - k_d a_k - d w_k),
//!
//! f the weight of the newest change in the derivative's low-pass. If torques come n + p periods
//! late (`wheel_loop.latency_s`), all but d w_k is (1 - p) times its value n periods before plus p
//! times that n + 1 periods before. With q for the delay by one period, the characteristic
//! polynomial is
//!
//!   (1 - (1 - g d) q) (1 - q) (1 - (1 - f) q) +
//!   g q^(n + 1) (1 - p + p q)
//!   (k_p (1 - q) (1 - (1 - f) q) + k_i T (1 - (1 - f) q) + k_d f / T (1 - q)^2),
//!
//! g = T / (J + d T). A rate counted over the last control period lags by half of it, and by the
//! time for which it is held on average if the loop's period is shorter: a part of n + p, exact if
//! the periods are equal and nothing else is late. A filter on it multiplies the first product by 1
//! - (1 - h) q and the second by h, its weight of the newest count.
//!
//! The loop is stable if and only if its roots in 1 / q lie within the unit circle. Without
//! derivative and latency this is Jury's 2 k_p T / J + k_i T^2 / J < 4 (`ilon_control`, wheel
//! loops); for k_p alone, n periods late, k_p T / J < 2 sin(pi / (4 n + 2)) (Levin and May 1976),
//! which for short periods is the phase margin of an integrator, k_p / J times the latency below pi
//! / 2. J is the inertia that the wheel feels: its own in the air and while it slides, plus a share
//! of the robot's on the ground, which depends on the direction of motion.
//!
//! A continuous loop with a latency counts as a sampled one whose period is a tenth of the latency
//! and whose torques are half a period less late.
//!
//! **A continuous loop without latency** is stable at any gain, but its torque falls within the
//! step as the wheel gains rate. If that fall is `STIFFEST` times the torque that the wheel's
//! inertia takes, the difference of the two loses its digits, and motors and bearings get wrong
//! energies. A wheel that follows within a thousandth of a step follows practically at once, so a
//! lower limit loses nothing.

use ilon_control::DynamicModel;

use super::wheel_loop::{as_sampled_s, counted_lag_s};
use crate::Error;
use crate::scenario::{Scenario, WheelLaw, WheelLoop};

/// Largest fall of a continuous loop's torque within a step, as a multiple of the torque that the
/// wheel's inertia on the ground takes. Chosen.
const STIFFEST: f64 = 1e6;

/// The gains of a wheel loop and the period for which its torque is held.
#[derive(Clone, Copy, Debug)]
struct Loop {
    proportional_n_m_s: f64,
    integral_n_m: f64,
    derivative_n_m_s2: f64,
    /// f of the module's documentation.
    weight: f64,
    period_s: f64,
    /// How late its torques come after the rates that they answer.
    lag_s: f64,
    /// h of the module's documentation; 1 without a filter.
    rate_weight: f64,
}

/// Inertia and damping that a wheel loop feels.
#[derive(Clone, Copy, Debug)]
struct Felt {
    inertia_kg_m2: f64,
    damping_n_m_s: f64,
}

impl Loop {
    /// The loop of a scenario whose gains have been chosen.
    fn of(scenario: &Scenario, period_s: f64) -> Self {
        let (section, encoders) = (&scenario.wheel_loop, &scenario.sensors.encoders);
        let filter_s = encoders
            .counts_per_turn
            .map_or(0.0, |_| encoders.rate_filter_s);
        let (period_s, lag_s) = match section.is_late() {
            true => as_sampled_s(section.latency_s()),
            false => (
                period_s,
                section.latency_s() + counted_lag_s(scenario, period_s),
            ),
        };
        Self {
            proportional_n_m_s: section.proportional_n_m_s.unwrap_or(0.0),
            integral_n_m: section.integral_n_m.unwrap_or(0.0),
            derivative_n_m_s2: section.derivative_n_m_s2,
            weight: period_s / (section.derivative_filter_s + period_s),
            period_s,
            lag_s,
            rate_weight: period_s / (period_s + filter_s),
        }
    }

    /// The characteristic polynomial of a wheel's rate in q, by falling powers of z = 1 / q.
    fn polynomial(&self, wheel: &Felt) -> Vec<f64> {
        let Self {
            proportional_n_m_s: k_p,
            integral_n_m: k_i,
            derivative_n_m_s2: k_d,
            weight: f,
            period_s: t,
            lag_s,
            rate_weight: h,
        } = *self;
        let d = wheel.damping_n_m_s;
        let g = t / (wheel.inertia_kg_m2 + d * t);
        let (difference, filter) = ([1.0, -1.0], [1.0, f - 1.0]);
        let scaled = |by: f64, of: &[f64]| of.iter().map(|c| by * c).collect::<Vec<f64>>();
        let own = times(&[1.0, g * d - 1.0], &filter);
        let over = scaled(k_d * f / t, &difference);
        let direct = plus(&scaled(k_p, &filter), &over);
        // Without an integral, i is not a state and does not decay.
        let (own, asked) = match k_i == 0.0 {
            true => (own, direct),
            false => (
                times(&own, &difference),
                plus(&times(&direct, &difference), &scaled(k_i * t, &filter)),
            ),
        };
        let own = match h < 1.0 {
            true => times(&own, &[1.0, h - 1.0]),
            false => own,
        };
        let waits = lag_s / t;
        let whole = (waits + 1e-9).floor();
        let part = (waits - whole).max(0.0);
        let mut late = vec![0.0; whole as usize + 1];
        late.extend([g * h * (1.0 - part), g * h * part]);
        plus(&own, &times(&late, &asked))
    }

    /// Whether the wheel's rate is stable.
    fn settles(&self, wheel: &Felt) -> bool {
        vanishes(self.polynomial(wheel))
    }
}

/// The product of two polynomials.
fn times(one: &[f64], other: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; one.len() + other.len() - 1];
    for (i, a) in one.iter().enumerate() {
        for (j, b) in other.iter().enumerate() {
            product[i + j] += a * b;
        }
    }
    product
}

/// The sum of two polynomials.
fn plus(one: &[f64], other: &[f64]) -> Vec<f64> {
    let at = |of: &[f64], i: usize| of.get(i).copied().unwrap_or(0.0);
    let length = one.len().max(other.len());
    (0..length).map(|i| at(one, i) + at(other, i)).collect()
}

/// Whether all roots of a polynomial, with coefficients by falling powers, lie within the unit
/// circle: Schur's recursion.
fn vanishes(mut polynomial: Vec<f64>) -> bool {
    while let [first, .., last] = polynomial[..] {
        let k = last / first;
        if k.is_nan() || k.abs() >= 1.0 {
            return false;
        }
        let pairs = polynomial.iter().zip(polynomial.iter().rev());
        let reduced = pairs.map(|(a, b)| (a - k * b) / (first * (1.0 - k * k)));
        let mut reduced: Vec<f64> = reduced.collect();
        reduced.pop();
        polynomial = reduced;
    }
    true
}

/// A gain of a section: its key, and access to its value in a loop.
type Gain = (&'static str, fn(&mut Loop) -> &mut f64);

/// The value of a gain in a loop.
fn value((_, gain): &Gain, mut of: Loop) -> f64 {
    *gain(&mut of)
}

/// The gains that may be lowered.
const GAINS: [Gain; 3] = [
    ("proportional_n_m_s", |of| &mut of.proportional_n_m_s),
    ("integral_n_m", |of| &mut of.integral_n_m),
    ("derivative_n_m_s2", |of| &mut of.derivative_n_m_s2),
];

/// What the wheel loops feel, smallest and largest: inertia in kg m^2 with the damping of the
/// bearings, in the air or sliding, and on the ground.
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

/// Remarks unstable wheel loops of a scenario whose gains have been chosen; `None` if they are
/// stable.
///
/// # Errors
/// [`Error::Invalid`] if a continuous loop is too fast for the arithmetic.
pub fn remark(
    scenario: &Scenario,
    model: &DynamicModel,
    physics_dt_s: f64,
) -> Result<Option<String>, Error> {
    let section = &scenario.wheel_loop;
    let period_s = section.period_s.unwrap_or(physics_dt_s);
    if section.law != WheelLaw::Pid {
        return Ok(remark_of_model(scenario, model, period_s));
    }
    let own = Loop::of(scenario, period_s);
    match section.takes_whole_steps() {
        false => refuse_too_fast(section, &own, model.ground_inertia_kg_m2()).map(|()| None),
        true => Ok(remark_of_sampled(&own, model, scenario)),
    }
}

/// Remarks a gain that a latency lowered below that of the bandwidth, with what each ground allows.
///
/// A wheel with k_p / J times the latency at 1 / e is critically damped: it follows fastest without
/// overshoot, and at pi / 2 it swings, 4.3 times that. The chosen gain keeps half of pi / 2 for a
/// wheel in the air, whose inertia is far less than a rolling wheel's share of the robot.
pub fn lowered(scenario: &Scenario, model: &DynamicModel) -> Option<String> {
    /// A robot that follows faster than this is not slow, in seconds. Chosen.
    const SLOW_S: f64 = 0.1;
    let section = &scenario.wheel_loop;
    let latency_s = section.latency_s();
    let chosen_n_m_s = section.proportional_n_m_s?;
    let ground_kg_m2 = model.ground_inertia_kg_m2();
    let asked_n_m_s = ground_kg_m2 * section.bandwidth_rad_s;
    if section.law != WheelLaw::Pid
        || latency_s == 0.0
        || chosen_n_m_s > asked_n_m_s.min(ground_kg_m2 / SLOW_S)
    {
        return None;
    }
    let (_, [lightest, _]) = felt(model);
    let rolling_n_m_s = lightest.inertia_kg_m2 / (std::f64::consts::E * latency_s);
    let follows_s = |gain_n_m_s: f64| ilon_trace::significant(ground_kg_m2 / gain_n_m_s, 2);
    let shown = |gain_n_m_s: f64| ilon_trace::significant(gain_n_m_s, 3);
    let remedy = match rolling_n_m_s.min(asked_n_m_s) {
        faster if faster > 1.5 * chosen_n_m_s => format!(
            "; where all wheels stay on the ground and do not slide, `wheel_loop.proportional_n_m_s` = {} is stable and follows in {} s",
            rounded_down(faster),
            follows_s(faster)
        ),
        _ => String::new(),
    };
    Some(format!(
        "`wheel_loop.latency_s` = {latency_s} lowers the chosen gain of the wheel loops from {} to {} N m s/rad, half of what lets a wheel in \
         the air or a sliding one swing: the robot reaches 63 % of a new speed in {} s; shorten the latency{remedy}",
        shown(asked_n_m_s),
        shown(chosen_n_m_s),
        follows_s(chosen_n_m_s)
    ))
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
    // The defaults for a bandwidth w_b are J w_b and J w_b^2 / 4; the latter reaches the limit
    // first.
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

/// Checks a law that knows the robot, has its bandwidth in each direction, and whose torques come
/// late: a wheel in the air feels only a part of the inertia that the law assumes.
fn remark_of_model(scenario: &Scenario, model: &DynamicModel, period_s: f64) -> Option<String> {
    /// Factor by which the bandwidth is lowered at a time. Chosen.
    const LOWER: f64 = 0.98;
    let in_the_air = model.air_inertia_kg_m2() / model.ground_inertia_kg_m2();
    let given = Loop::of(scenario, period_s);
    let settles = |bandwidth_rad_s: f64, inertia_kg_m2: f64| {
        let w = model.bandwidth_rad_s(bandwidth_rad_s, period_s);
        let own = Loop {
            proportional_n_m_s: w,
            integral_n_m: 0.25 * w * w,
            ..given
        };
        own.settles(&Felt {
            inertia_kg_m2,
            damping_n_m_s: 0.0,
        })
    };
    let all = |bandwidth_rad_s: f64| {
        settles(bandwidth_rad_s, 1.0) && settles(bandwidth_rad_s, in_the_air)
    };
    let asked = scenario.wheel_loop.bandwidth_rad_s;
    let is_passive = scenario.wheel_loop.law == WheelLaw::Passive;
    if is_passive || given.lag_s == 0.0 || all(asked) {
        return None;
    }
    let place = match settles(asked, 1.0) {
        true => "a wheel that hangs in the air or slides swings",
        false => "wheels swing",
    };
    let mut most = asked;
    while !all(most) && most > f64::MIN_POSITIVE {
        most *= LOWER;
    }
    let (late, else_) = late(scenario);
    Some(format!(
        "the wheel loops are unstable: with torques{late} {place} ever wider; lower `wheel_loop.bandwidth_rad_s` to {}, or {else_}",
        rounded_down(most)
    ))
}

/// What makes a loop's torques late, after "with torques", and what changes that.
fn late(scenario: &Scenario) -> (String, &'static str) {
    let latency_s = scenario.wheel_loop.latency_s();
    let encoders = &scenario.sensors.encoders;
    let late = match latency_s > 0.0 {
        true => format!(" that come {latency_s} s late"),
        false => String::new(),
    };
    match (encoders.counts_per_turn, encoders.rate_filter_s > 0.0) {
        (None, _) => (late, "shorten `wheel_loop.latency_s`"),
        (Some(_), false) => (
            format!("{late} from rates counted once a control period"),
            "shorten `run.control_dt_s`",
        ),
        (Some(_), true) => (
            format!("{late} from rates counted once a control period and filtered"),
            "shorten `sensors.encoders.rate_filter_s` or `run.control_dt_s`",
        ),
    }
}

fn remark_of_sampled(own: &Loop, model: &DynamicModel, scenario: &Scenario) -> Option<String> {
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
    let held = match scenario.wheel_loop.is_late() {
        true => String::new(),
        false => format!(" held for {:.3e} s", own.period_s),
    };
    let (late, else_) = match own.lag_s > 0.0 {
        true => late(scenario),
        false => (String::new(), "set `wheel_loop.timing` = \"continuous\""),
    };
    Some(format!(
        "the wheel loops are unstable: with torques{held}{late} {place} ever wider; {remedy}, or {else_}"
    ))
}

/// The gain that makes the loop stable.
fn remedy(own: &Loop, settles: impl Fn(&Loop) -> bool) -> String {
    /// Factor by which a gain is lowered at a time, and the largest number of times. Chosen.
    const LOWER: f64 = 0.95;
    const TIMES: usize = 200;
    let lowered = |gains: &[Gain]| {
        let mut of = *own;
        (0..TIMES).find_map(|_| {
            for (_, gain) in gains {
                *gain(&mut of) *= LOWER;
            }
            settles(&of).then_some(of)
        })
    };
    // The gain that has to be lowered least.
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

/// A number with three digits, rounded towards zero.
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
            lag_s: 0.0,
            rate_weight: 1.0,
        }
    }

    const WHEEL: Felt = Felt {
        inertia_kg_m2: INERTIA_KG_M2,
        damping_n_m_s: 0.0,
    };

    /// Jury: with a and b the gains in these units the loop is stable if and only if 2 a + b < 4;
    /// of the derivative alone, beside a small proportional gain, z^2 - (1 - a - c) z - c has its
    /// roots within the circle if c < 1 - a / 2.
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
        // A slow filter allows a larger derivative gain; damping d adds d T / J to the stable
        // range: a < 2 + 2 d T / J - d T / J.
        assert!(of(0.1, 0.0, 2.0, 0.1).settles(&WHEEL));
        let damped = Felt {
            damping_n_m_s: INERTIA_KG_M2 / PERIOD_S,
            ..WHEEL
        };
        assert!(of(2.999, 0.0, 0.0, 1.0).settles(&damped));
        assert!(!of(3.001, 0.0, 0.0, 1.0).settles(&damped));
    }

    /// Levin and May: a < 2 sin(pi / (4 n + 2)) for torques n periods late. Half a period later the
    /// polynomial is 1 - q + a q (1 + q) / 2, by Jury stable below 2. With an integral b = c a^2
    /// the phase margin of (k_p s + k_i) / (J s^2) is atan(u / c) at the crossing u of u^4 = u^2 +
    /// c^2, in units of k_p / J, and the latency that consumes it is atan(u / c) / u. For short
    /// periods, the half period for which a torque is held is part of that latency, and the
    /// remaining difference is of second order in a: 0.01^2.
    #[test]
    fn late_torques_have_the_bounds_of_levin_and_of_the_phase_margin() {
        let late = |periods: f64, a: f64, b: f64| Loop {
            lag_s: periods * PERIOD_S,
            ..of(a, b, 0.0, 1.0)
        };
        for n in [0.0_f64, 1.0, 2.0, 7.0, 40.0, 300.0] {
            let most = 2.0 * (std::f64::consts::PI / (4.0 * n + 2.0)).sin();
            assert!(late(n, 0.9999 * most, 0.0).settles(&WHEEL), "{n}");
            assert!(!late(n, 1.0001 * most, 0.0).settles(&WHEEL), "{n}");
        }
        assert!(late(0.5, 1.999, 0.0).settles(&WHEEL));
        assert!(!late(0.5, 2.001, 0.0).settles(&WHEEL));
        for c in [0.1_f64, 0.25, 1.0] {
            let u = (0.5 * (1.0 + (1.0 + 4.0 * c * c).sqrt())).sqrt();
            let a = 0.01;
            let most = (u / c).atan() / (u * a) - 0.5;
            let b = c * a * a;
            // The integral includes the newest error: half a period of it acts at once.
            let a = a - 0.5 * b;
            assert!(late(0.999 * most, a, b).settles(&WHEEL), "{c}");
            assert!(!late(1.001 * most, a, b).settles(&WHEEL), "{c}");
        }
    }

    /// A filter of weight h on rates counted over the last period: z^2 - (2 - h - a h / 2) z + 1 -
    /// h + a h / 2, by Jury stable below a = 2 whatever the filter. With an integral of b beside it
    /// the filter counts: 1 - q of the first product is squared.
    #[test]
    fn counted_and_filtered_rates_are_stable_below_two() {
        let counted = |a: f64, b: f64, weight: f64| Loop {
            lag_s: 0.5 * PERIOD_S,
            rate_weight: weight,
            ..of(a, b, 0.0, 1.0)
        };
        for weight in [1.0, 0.5, 0.05] {
            assert!(counted(1.999, 0.0, weight).settles(&WHEEL), "{weight}");
            assert!(!counted(2.001, 0.0, weight).settles(&WHEEL), "{weight}");
        }
        assert!(counted(0.1, 0.01, 1.0).settles(&WHEEL));
        assert!(!counted(0.1, 0.01, 0.05).settles(&WHEEL));
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
