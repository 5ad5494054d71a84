//! Whether the guidance can settle at its control period: Indiveri 2009, eqs. (25)-(26), in
//! discrete time.
//!
//! | symbol | is |
//! |---|---|
//! | K | a gain, K_r or K_phi of eq. (26), in 1/s; of a matrix its largest eigenvalue |
//! | T | the period in which the guidance sees a new pose and decides, in s |
//! | l | how old a pose is when it is decided on, in s |
//! | u, v | what is commanded and what the wheels make of it, along one direction of motion, in m/s or rad/s |
//!
//! Eq. (25) proves that the error decays for every K > 0 in continuous time. A controller that
//! decides once a period holds its command until the next. Along one direction
//!
//! e' = -v,   u = K e(k T - l)  from k T to (k + 1) T.
//!
//! Wheels that follow at once have v = u; loops with a proportional and an integral part, and a
//! feedforward of the command's filtered derivative, have
//!
//! v' = w (u - v) + s i + c (u - x),   i' = u - v,   x' = c (u - x).
//!
//! Where their torques come a time tau late, v'(t) is the right side at t - tau, of which a Pade
//! approximant stands for the delay: with y the right side,
//!
//! v' = y - (12 / tau) q,   p' = q,   q' = y - (6 / tau) q - (12 / tau^2) p,
//!
//! is exp(-s tau) to (s tau)^5 / 720. Wheels that follow at once, but late, are those of a pose
//! that is as much older.
//!
//! Over a period this is a matrix, and the error decays where and only where its powers vanish. For
//! wheels that follow at once and l = d T it is e_(k+1) = e_k - K T e_(k-d), which decays for
//!
//! 0 < K T < 2 cos(d pi / (2 d + 1)),
//!
//! (Levin and May 1976, "A note on difference-delay equations"): below 2 with poses that are seen
//! at once, 1 with poses a period old, 0.618 with two. Loops move the bound: w T = 0.6 lowers 2 to
//! 1.64, w T = 4 raises it to 3.15.
//!
//! The error passes zero, so that the robot swings past its target, where two real roots of the
//! same polynomial have met: from
//!
//! K T = d^d / (d + 1)^(d + 1)
//!
//! on, 1 for poses that are seen at once and T / (e l) for old ones. With loops it is found by
//! following an error.

use ilon_control::{DynamicModel, GuidanceTask};
use ilon_robot::bisected;
use ilon_trace::Guidance;
use nalgebra::{DMatrix, DVector, Matrix3};

use crate::Error;
use crate::scenario::{Scenario, WheelLaw};

/// The response of the wheels to a command along one direction of motion.
#[derive(Clone, Copy, Debug)]
struct Answer {
    /// w, in 1/s.
    proportional_per_s: f64,
    /// s, in 1/s^2.
    integral_per_s2: f64,
    /// c, in 1/s; 0 without feedforward.
    feedforward_per_s: f64,
    /// tau, in s.
    delay_s: f64,
}

/// A period, and the age of the pose used in it.
#[derive(Clone, Copy, Debug)]
struct Timing {
    /// T.
    period_s: f64,
    /// l.
    age_s: f64,
}

/// The control loop of a pose error along one direction, without its gain; without an `Answer` the
/// wheels follow at once.
#[derive(Clone, Copy, Debug)]
struct ErrorLoop {
    timing: Timing,
    answer: Option<Answer>,
}

/// The oldest pose in periods for which the bound is computed; older poses use longer periods.
/// Chosen.
const MOST_PERIODS: f64 = 20.0;

impl Timing {
    /// With a period so long that the pose is [`MOST_PERIODS`] of it old. A decision is held for
    /// half a period on average, so age plus half a period is kept: the bound on the gain is then
    /// accurate to 3e-4.
    fn coarsened(&self) -> Self {
        let Self { period_s, age_s } = *self;
        if age_s <= MOST_PERIODS * period_s {
            return *self;
        }
        let longer_s = (age_s + 0.5 * period_s) / (MOST_PERIODS + 0.5);
        Self {
            period_s: longer_s,
            age_s: MOST_PERIODS * longer_s,
        }
    }
}

impl ErrorLoop {
    /// The product K T from which on the error does not decay.
    fn limit(&self) -> f64 {
        /// No loop is stable beyond this. Chosen.
        const MOST: f64 = 8.0;
        self.largest((MOST, 40), Self::decays)
    }

    /// The product K T from which on the error passes zero, at most that from which on it does not
    /// decay.
    fn overshoots_from(&self) -> f64 {
        self.largest((self.limit(), 24), |of, product| !of.overshoots(product))
    }

    /// Whether the error passes zero under a product K T.
    fn overshoots_under(&self, product: f64) -> bool {
        let timing = self.timing.coarsened();
        let coarsened = Self { timing, ..*self };
        coarsened.overshoots(product * timing.period_s / self.timing.period_s)
    }

    /// The largest product up to `most` that satisfies `is_good`, by a number of bisections, for
    /// poses that are not too old.
    fn largest(&self, (most, halvings): (f64, u32), is_good: fn(&Self, f64) -> bool) -> f64 {
        let timing = self.timing.coarsened();
        let coarsened = Self { timing, ..*self };
        let periods = timing.period_s / self.timing.period_s;
        let is_good = |product: f64| is_good(&coarsened, product);
        bisected((0.0, most * periods), halvings, is_good).1 / periods
    }

    /// Whether an error of a robot at rest, constant until now, passes zero under a product K T.
    fn overshoots(&self, product: f64) -> bool {
        /// Smaller errors are rounding, as a share of the error. Chosen.
        const ROUNDING: f64 = 1e-10;
        /// The error counts as decayed below this. Chosen.
        const DECAYED: f64 = 1e-8;
        const MOST_PERIODS: usize = 5000;
        let over = self.over_a_period(product);
        let e = self.rates().nrows() - 2;
        let mut state = DVector::zeros(over.nrows());
        // The current error, and the measured ones of the periods before.
        state.rows_range_mut(e..).fill(1.0);
        for _ in 0..MOST_PERIODS {
            state = &over * state;
            if state[e] < -ROUNDING {
                return true;
            }
            if state.amax() < DECAYED {
                break;
            }
        }
        false
    }

    /// Whether the error decays under a product K T.
    fn decays(&self, product: f64) -> bool {
        /// After this number of doublings, 1e-7 below the bound is distinguished from above.
        /// Chosen.
        const DOUBLINGS: usize = 30;
        /// The power has decayed or grown for good at this factor. Chosen.
        const SMALL: f64 = 1e-6;
        let mut over = self.over_a_period(product);
        for _ in 0..DOUBLINGS {
            let size = over.norm();
            if !(SMALL..1.0 / SMALL).contains(&size) {
                return size < SMALL;
            }
            over = &over * &over;
        }
        false
    }

    /// The transition matrix of a period: of v, i and x, if there is an `Answer`; e; and e as
    /// measured in the periods before.
    fn over_a_period(&self, product: f64) -> DMatrix<f64> {
        let Timing { period_s, age_s } = self.timing;
        let age = age_s / period_s;
        // Whole periods, and a fraction of one, between measurement and decision.
        let whole = (age + 1e-9).floor();
        let part = (age - whole).max(0.0);
        let own = self.rates();
        // The last row and column are those of u, which is held.
        let size = own.nrows() - 1;
        let e = size - 1;
        let moves = |share: f64| (&own * (share * period_s)).exp();
        let looks = match part > 1e-9 {
            true => whole as usize + 1,
            false => whole as usize,
        };
        let mut seen = DVector::zeros(size + looks);
        seen[if looks == 0 { e } else { size + looks - 1 }] = 1.0;
        let command = seen.transpose() * (product / period_s);
        let mut over = DMatrix::zeros(size + looks, size + looks);
        let advance = |over: &mut DMatrix<f64>, row: usize, of: usize, moved: &DMatrix<f64>| {
            let mut line = &command * moved[(of, size)];
            for column in 0..size {
                line[column] += moved[(of, column)];
            }
            over.set_row(row, &line);
        };
        let whole_period = moves(1.0);
        for row in 0..size {
            advance(&mut over, row, row, &whole_period);
        }
        if looks > 0 {
            // The newest measurement is between this decision and the next.
            advance(&mut over, size, e, &moves(1.0 - part));
            for row in 1..looks {
                over[(size + row, size + row - 1)] = 1.0;
            }
            if part <= 1e-9 {
                // It is at this decision.
                over.row_mut(size).fill(0.0);
                over[(size, e)] = 1.0;
            }
        }
        over
    }

    /// The rates of v, i, x, e and u by these.
    fn rates(&self) -> DMatrix<f64> {
        match self.answer {
            None => DMatrix::from_row_slice(2, 2, &[0.0, -1.0, 0.0, 0.0]),
            Some(answer) => {
                let (w, s) = (answer.proportional_per_s, answer.integral_per_s2);
                let c = answer.feedforward_per_s;
                // A state without effect must vanish, and not count as an error that stays.
                let own = 1.0 / self.timing.period_s;
                let of_i = if s == 0.0 {
                    [0.0, -own, 0.0]
                } else {
                    [-1.0, 0.0, 1.0]
                };
                let of_x = if c == 0.0 { [-own, 0.0] } else { [-c, c] };
                #[rustfmt::skip]
                let rates = [
                    -w, s, -c, 0.0, w + c,
                    of_i[0], of_i[1], 0.0, 0.0, of_i[2],
                    0.0, 0.0, of_x[0], 0.0, of_x[1],
                    -1.0, 0.0, 0.0, 0.0, 0.0,
                    0.0, 0.0, 0.0, 0.0, 0.0,
                ];
                let at_once = DMatrix::from_row_slice(5, 5, &rates);
                match answer.delay_s > 0.0 {
                    true => late(at_once, answer.delay_s),
                    false => at_once,
                }
            }
        }
    }
}

/// Rates of v and more whose first row comes a time in seconds late, with p and q behind x.
fn late(at_once: DMatrix<f64>, delay_s: f64) -> DMatrix<f64> {
    const P: usize = 3;
    const Q: usize = 4;
    let mut rates = at_once.insert_rows(P, 2, 0.0).insert_columns(P, 2, 0.0);
    let y = rates.row(0).into_owned();
    rates.set_row(Q, &y);
    rates[(0, Q)] = -12.0 / delay_s;
    rates[(P, Q)] = 1.0;
    rates[(Q, Q)] = -6.0 / delay_s;
    rates[(Q, P)] = -12.0 / (delay_s * delay_s);
    rates
}

/// The timing of a scenario's new poses at the guidance, and whether it is constant: if the sample
/// period does not fit the control period, the age of poses varies.
fn timing(scenario: &Scenario) -> (Timing, bool) {
    // Rounding shall not take a period off.
    const SLACK: f64 = 1e-9;
    let control_s = scenario.run.control_dt_s;
    let sensor = &scenario.sensors.pose;
    let of = |period_s, age_s| Timing { period_s, age_s };
    // A filter brings each pose up to the present.
    if scenario.sensors.fusion.is_some() {
        return (of(control_s, 0.0), true);
    }
    let pose_s = sensor.rate_hz.map_or(control_s, |rate_hz| 1.0 / rate_hz);
    let periods = pose_s / control_s;
    match periods > 1.0 - 1e-6 && (periods - periods.round()).abs() < 1e-6 {
        // It waits for the next decision.
        true => {
            let waits = (sensor.latency_s / control_s - SLACK).ceil().max(0.0);
            (of(periods.round() * control_s, waits * control_s), true)
        }
        false => (of(pose_s.max(control_s), sensor.latency_s), false),
    }
}

/// How the wheels answer along the directions in which a position error, and a heading error, are
/// led back.
fn answers(scenario: &Scenario, model: &DynamicModel, period_s: f64) -> [Vec<Answer>; 2] {
    let section = &scenario.wheel_loop;
    let delay_s = section.latency_s();
    if section.law != WheelLaw::Pid {
        // Laws that know the robot have the requested bandwidth in each direction.
        let w = model.bandwidth_rad_s(section.bandwidth_rad_s, period_s);
        let answer = Answer {
            proportional_per_s: w,
            integral_per_s2: 0.25 * w * w,
            feedforward_per_s: 1.0 / scenario.run.control_dt_s,
            delay_s,
        };
        return [vec![answer], vec![answer]];
    }
    let (k_p, k_i) = (
        section.proportional_n_m_s.unwrap_or(0.0),
        section.integral_n_m.unwrap_or(0.0),
    );
    // R^T I R v' = R^T R (k_p (u - v) + k_i i).
    let r = model.kinematics().rate_matrix();
    let (inertia, push) = (r.transpose() * model.inertia() * r, r.transpose() * r);
    let answer = |pushed: f64| {
        let pushed = pushed / (1.0 + pushed * section.derivative_n_m_s2);
        Answer {
            proportional_per_s: k_p * pushed,
            integral_per_s2: k_i * pushed,
            feedforward_per_s: 0.0,
            delay_s,
        }
    };
    let along = |matrix: &Matrix3<f64>| matrix.fixed_view::<2, 2>(0, 0).into_owned();
    // The matrix is positive definite, like every inertia.
    let root = along(&inertia).cholesky().and_then(|c| c.l().try_inverse());
    let values = root.map(|root| (root * along(&push) * root.transpose()).symmetric_eigenvalues());
    let position = values.iter().flat_map(|values| values.iter());
    [
        position.map(|value| answer(*value)).collect(),
        vec![answer(push[(2, 2)] / inertia[(2, 2)])],
    ]
}

/// A gain of a guidance: its key, and how large it is.
struct UsedGain {
    key: String,
    per_s: f64,
    /// Whether it is on the heading.
    of_heading: bool,
}

/// The gains that a scenario's guidance uses.
fn gains(scenario: &Scenario) -> Vec<UsedGain> {
    let section = &scenario.guidance;
    let position = || UsedGain {
        key: match section.position_gain_matrix_per_s {
            Some(_) => "the largest eigenvalue of `guidance.position_gain_matrix_per_s`",
            None => "`guidance.position_gain_per_s`",
        }
        .to_owned(),
        per_s: section.position_gain_most_per_s(),
        of_heading: false,
    };
    let heading = |key: &str, per_s| UsedGain {
        key: format!("`guidance.{key}`"),
        per_s,
        of_heading: true,
    };
    let on_heading = || heading("heading_gain_per_s", section.heading_gain_per_s);
    if section.tasks.is_empty() {
        return vec![position(), on_heading()];
    }
    let of_task = |(index, task): (usize, &GuidanceTask)| match *task {
        GuidanceTask::PositionFeedback => Some(position()),
        GuidanceTask::HeadingFeedback => Some(on_heading()),
        GuidanceTask::Face { gain_per_s, .. } => Some(heading(
            &format!("tasks.{index}.face.gain_per_s"),
            gain_per_s,
        )),
        GuidanceTask::PositionFeedforward
        | GuidanceTask::HeadingFeedforward
        | GuidanceTask::Twist { .. } => None,
    };
    section
        .tasks
        .iter()
        .enumerate()
        .filter_map(of_task)
        .collect()
}

/// The largest gain on the heading, or on the position, that a scenario's guidance uses; 0 without
/// one.
fn most_per_s(scenario: &Scenario, of_heading: bool) -> f64 {
    let gains = gains(scenario).into_iter();
    let of_kind = gains.filter(|gain| gain.of_heading == of_heading);
    of_kind.map(|gain| gain.per_s).fold(0.0, f64::max)
}

/// The products of a gain and the period at which an error no longer settles.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// From which on it passes zero, with wheels that follow at once or with the scenario's own
    /// loops; infinite if it does not under the scenario's gains.
    overshoots_from: f64,
    /// Under the wheel loops of the scenario.
    unstable_from: f64,
    /// Under these, and under wheels that follow at once.
    hopeless_from: f64,
}

/// The limits of a guidance's gains at its period, its poses and its wheel loops.
#[derive(Clone, Copy, Debug)]
pub struct Stability {
    timing: Timing,
    position: Bounds,
    heading: Bounds,
}

impl Stability {
    /// For a scenario whose guidance follows a reference, with the period of its wheel loops in
    /// seconds; `None` for a law with springs, which has its own limits.
    pub fn of(scenario: &Scenario, model: &DynamicModel, period_s: f64) -> Option<Self> {
        if scenario.wheel_loop.law == WheelLaw::Passive {
            return None;
        }
        let (timing, is_certain) = timing(scenario);
        // Torques that come late are, of wheels that follow at once, as poses that are as much
        // older.
        let old = Timing {
            age_s: timing.age_s + scenario.wheel_loop.latency_s(),
            ..timing
        };
        let late = |answer: Option<Answer>| ErrorLoop {
            timing: if answer.is_some() { timing } else { old },
            answer,
        };
        let limit = |answer| late(answer).limit();
        let at_once = limit(None);
        let most = |of_heading| most_per_s(scenario, of_heading);
        let known = answers(scenario, model, period_s);
        let [position, heading] =
            [(false, &known[0]), (true, &known[1])].map(|(of_heading, answers)| {
                let product = most(of_heading) * timing.period_s;
                let all = answers.iter().copied().map(Some).chain([None]);
                let loops = all.map(late);
                let overshoots_from = loops
                    .filter(|of| of.overshoots_under(product))
                    .map(|of| of.overshoots_from())
                    .fold(f64::INFINITY, f64::min);
                let known = answers.iter().map(|own| limit(Some(*own)));
                let (least, most) = known.fold((f64::INFINITY, at_once), |(least, most), own| {
                    (least.min(own), most.max(own))
                });
                Bounds {
                    overshoots_from,
                    unstable_from: least,
                    hopeless_from: if is_certain { most } else { f64::INFINITY },
                }
            });
        Some(Self {
            timing: old,
            position,
            heading,
        })
    }

    /// It as a trace keeps it; the gain on an error that no task serves is 0.
    pub fn recorded(&self, scenario: &Scenario) -> Guidance {
        let most = |of_heading| most_per_s(scenario, of_heading);
        let periods = scenario.run.control_dt_s / self.timing.period_s;
        let known = |from: f64| from.is_finite().then_some(from * periods);
        Guidance {
            position_gain_per_s: most(false),
            heading_gain_per_s: most(true),
            position_unstable_from: known(self.position.unstable_from),
            heading_unstable_from: known(self.heading.unstable_from),
        }
    }

    /// Remarks the gains of a scenario.
    ///
    /// # Errors
    /// [`Error::Invalid`] if an error cannot settle.
    pub fn remark(&self, scenario: &Scenario) -> Result<Option<String>, Error> {
        /// Rounding must not pass a bound. Chosen.
        const ALMOST: f64 = 1.0 - 1e-9;
        let period_s = self.timing.period_s;
        let poses = match self.timing.age_s > 0.0 {
            true => format!(
                " with poses {} s old{}",
                self.timing.age_s,
                match scenario.wheel_loop.latency_s() > 0.0 {
                    true => " when torques follow",
                    false => "",
                }
            ),
            false => String::new(),
        };
        let mut worst: Option<(f64, UsedGain, Bounds)> = None;
        for gain in gains(scenario) {
            let bounds = if gain.of_heading {
                self.heading
            } else {
                self.position
            };
            let share = gain.per_s * period_s / bounds.overshoots_from;
            if worst.as_ref().is_none_or(|(most, ..)| share > *most) {
                worst = Some((share, gain, bounds));
            }
        }
        let Some((_, gain, bounds)) = worst.filter(|(share, ..)| *share >= ALMOST) else {
            return Ok(None);
        };
        let (key, product) = (&gain.key, gain.per_s * period_s);
        let (unstable, hopeless) = (bounds.unstable_from, bounds.hopeless_from);
        let (unstable_from, hopeless_from) = (digits(unstable), digits(hopeless));
        let is = format!(
            "{key} times the period of {period_s} s is {}",
            digits(product)
        );
        let help = format!(
            "choose a gain below {} /s; a shorter `run.control_dt_s` or wheel loops of more bandwidth allow more",
            digits(bounds.overshoots_from / period_s)
        );
        if product >= hopeless * ALMOST {
            return Err(Error::invalid(
                format!(
                    "the guidance cannot settle: {is}, and from {hopeless_from} on{poses} an error grows from period to period, with these wheel \
                     loops and with wheels that follow at once"
                ),
                help,
            ));
        }
        Ok(Some(match product >= unstable * ALMOST {
            true => format!(
                "the guidance is unstable: {is}, and from {unstable_from} on{poses} and with these wheel loops an error grows from period to period; {help}"
            ),
            false => format!(
                "the guidance overshoots: {is}, and from {} on{poses} the robot swings past its target (from {unstable_from} on the error \
                 grows, with these wheel loops); {help}",
                digits(bounds.overshoots_from)
            ),
        }))
    }
}

/// A number with three decimals, or of a small one three digits.
fn digits(x: f64) -> String {
    match x < 0.1 {
        true => ilon_trace::number(ilon_trace::significant(x, 3)),
        false => format!("{x:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn limit(periods_old: f64, answer: Option<(f64, f64)>) -> f64 {
        let timing = Timing {
            period_s: 0.02,
            age_s: 0.02 * periods_old,
        };
        let answer = answer.map(|(proportional_per_s, integral_per_s2)| Answer {
            proportional_per_s,
            integral_per_s2,
            feedforward_per_s: 0.0,
            delay_s: 0.0,
        });
        ErrorLoop { timing, answer }.limit()
    }

    /// The polynomial z^(d+1) - z^d + p has a double root at z = d / (d + 1), where p = d^d / (d +
    /// 1)^(d + 1); beyond it the slowest roots are complex. Of poses a part f of a period old it is
    /// z^2 - z + p ((1 - f) z + f), with a double root where (1 - p (1 - f))^2 = 4 p f. A lag of 1
    /// / w seen at once is critical near w = 4 K where periods are short.
    #[test]
    fn an_error_passes_zero_from_a_double_root_on() {
        let found = |periods_old: f64, w: Option<f64>, period_s: f64| {
            let timing = Timing {
                period_s,
                age_s: period_s * periods_old,
            };
            let answer = w.map(|proportional_per_s| Answer {
                proportional_per_s,
                integral_per_s2: 0.0,
                feedforward_per_s: 0.0,
                delay_s: 0.0,
            });
            ErrorLoop { timing, answer }.overshoots_from()
        };
        for d in 0..8 {
            let d = f64::from(d);
            let exact = d.powf(d) / (d + 1.0).powf(d + 1.0);
            let found = found(d, None, 0.02);
            // Just beyond the root an error passes zero by less than the resolution.
            assert!((found / exact - 1.0).abs() < 0.03, "{d}: {found} {exact}");
        }
        // 1 / (e l) of a pose 1 s old, at 10 ms; with half a period more of what is held.
        let old = found(100.0, None, 0.01) / 0.01;
        assert!(
            (old * 1.005 * std::f64::consts::E - 1.0).abs() < 0.03,
            "{old}"
        );
        let f = 0.5_f64;
        let (a, b) = ((1.0 - f).powi(2), -2.0 * (1.0 - f) - 4.0 * f);
        let exact = (-b - (b * b - 4.0 * a).sqrt()) / (2.0 * a);
        assert!((found(f, None, 0.02) / exact - 1.0).abs() < 0.03, "{exact}");
        let lagged = found(0.0, Some(10.0), 1e-3) / 1e-3;
        assert!((lagged / 2.5 - 1.0).abs() < 0.03, "{lagged}");
    }

    /// Wheels that follow at once: 2 cos(d pi / (2 d + 1)) of poses d whole periods old. Of poses a
    /// part f of a period old the polynomial is z^2 - z + p ((1 - f) z + f), by Jury's criterion
    /// stable below 2 / (1 - 2 f) and 1 / f.
    #[test]
    fn wheels_that_follow_at_once_have_the_bounds_of_levin_and_jury() {
        for d in 0..6 {
            let d = f64::from(d);
            let exact = 2.0 * (d * PI / (2.0 * d + 1.0)).cos();
            let found = limit(d, None);
            assert!((found - exact).abs() < 1e-5, "{d}: {found} {exact}");
        }
        // Poses so old that longer periods are used instead, within the stated accuracy of the
        // bound.
        for d in [21.0, 50.0, 300.0, 1e4] {
            let exact = 2.0 * (d * PI / (2.0 * d + 1.0)).cos();
            let found = limit(d, None);
            assert!((found / exact - 1.0).abs() < 3e-4, "{d}: {found} {exact}");
        }
        for f in [0.05_f64, 0.2, 0.25, 0.3, 0.5, 0.9] {
            let of_minus_one = if f < 0.5 {
                2.0 / (1.0 - 2.0 * f)
            } else {
                f64::INFINITY
            };
            let exact = of_minus_one.min(1.0 / f);
            let found = limit(f, None);
            assert!((found - exact).abs() < 1e-5, "{f}: {found} {exact}");
        }
    }

    /// Loops without an integral are a lag of 1 / w: with a = exp(-w T) the polynomial is
    /// (z - 1)(z - a) + p (b1 z + b0), b1 = 1 - (1 - a) / (w T) and b0 = (1 - a) / (w T) - a,
    /// stable below 2 (1 + a) / (b1 - b0) and (1 - a) / b0. Very fast ones follow at once, and very
    /// slow ones with an integral are those of the double lag.
    #[test]
    fn loops_have_the_bounds_of_their_polynomials() {
        for w_t in [0.1, 0.6, 2.0, 4.0, 8.0, 30.0] {
            let a = f64::exp(-w_t);
            let (b1, b0) = (1.0 - (1.0 - a) / w_t, (1.0 - a) / w_t - a);
            let exact = (2.0 * (1.0 + a) / (b1 - b0)).min((1.0 - a) / b0);
            let exact = if b1 > b0 { exact } else { (1.0 - a) / b0 };
            let found = limit(0.0, Some((w_t / 0.02, 0.0)));
            assert!((found / exact - 1.0).abs() < 1e-5, "{w_t}: {found} {exact}");
        }
        let fast = 1e5;
        assert!((limit(0.0, Some((fast, 0.25 * fast * fast))) - 2.0).abs() < 2e-3);
    }
}
