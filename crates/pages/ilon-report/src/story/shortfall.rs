//! Sentences on the missing part of an open-loop run's commanded motion, axis by axis.

use ilon_robot::{Pose, Twist};
use ilon_trace::ledger::Terms;
use ilon_trace::{Change, FaultKind, Header, Record, Summary, Twin, WheelHeader, WheelSample};

use crate::text::{angle, by_kind, capital, length, percent, time};

/// Wheels whose motion of the robot is below this, in m/s or rad/s, stand still: a robot that moves
/// anyway was carried.
const STANDING: f64 = 1e-3;
/// Wheels follow their command if they reach it to this share.
const AS_ASKED: f64 = 1e-3;
/// A smaller part of the motion is not reported.
const LEAST_SHARE: f64 = 5e-4;
/// A motor is at its limit from this share of its torque on; a wheel from this share of its rate
/// limit on.
const AT_LIMIT: f64 = 0.95;
/// Uncommanded motion is reported from here on: as a share of the commanded speed, and in m/s or
/// rad/s.
const DRIFT_SHARE: f64 = 0.02;
const LEAST_DRIFT: f64 = 5e-3;

/// A stretch is reported from this duration on, in seconds. Its means start this long after its
/// command.
const LEAST_STRETCH_S: f64 = 0.5;
const SETTLE_S: f64 = 0.3;
/// A motion that varies by more than this share of what was asked has a mean that it rarely has.
const UNSTEADY: f64 = 0.2;
/// Largest number of stretches reported before the last.
const MOST_STRETCHES: usize = 4;
/// A component of the motion is driven from this share of the whole on, and from this speed on, in
/// m/s.
const DRIVEN_SHARE: f64 = 0.01;
const DRIVEN_M_S: f64 = 1e-6;

/// A time span with one commanded twist: sums over it.
#[derive(Clone, Copy, Debug, Default)]
struct Stretch {
    from_s: f64,
    until_s: f64,
    time_s: f64,
    /// Displacements in the body frame: of the robot, and of each term of the ledger.
    moved: Twist,
    /// The least and the largest of each component of the robot's twist in a row.
    range: Option<[Twist; 2]>,
    terms: Terms,
    /// Deviation of the wheels from their targets, in rad, summed over all; the part with a motor
    /// at its limit, the part of that with a wheel at its rate limit, the part in which dry
    /// friction takes most of the torque, the part in which a dead band leaves none, and that of wheels
    /// without a motor.
    off_rad: f64,
    at_limit_rad: f64,
    at_rate_limit_rad: f64,
    held_rad: f64,
    swallowed_rad: f64,
    undriven_rad: f64,
}

/// Commanded and actual motion, in the window of the means, and in each stretch of a schedule.
#[derive(Clone, Debug, Default)]
pub(crate) struct Means {
    window: Stretch,
    stretches: Vec<Stretch>,
    before: Option<Record>,
    /// The fastest commanded motion, in m/s at the furthest wheel, and the largest motor torque, in
    /// N m.
    most_asked_m_s: f64,
    most_torque_n_m: f64,
    /// How far the robot turned beyond its command before the measured time, in radians, and where
    /// the command would have taken it.
    veered_rad: f64,
    led_to: Option<Pose>,
}

/// Returns the size of a twist in m/s, with its rotation measured at the furthest wheel.
fn size_m_s(header: &Header, twist: Twist) -> f64 {
    twist
        .linear_m_s()
        .norm()
        .hypot(arm_m(header) * twist.omega_rad_s)
}

/// Returns the distance of the furthest wheel from the body's origin, in metres.
fn arm_m(header: &Header) -> f64 {
    let positions = header.wheels.iter().map(|wheel| wheel.position_m);
    positions
        .map(|[x_m, y_m]| x_m.hypot(y_m))
        .fold(0.0, f64::max)
}

impl Stretch {
    fn add(&mut self, header: &Header, [before, record]: [&Record; 2], samples: &[WheelSample]) {
        let span_s = record.t_s - before.t_s;
        let real = before.truth.pose.displacement_to(&record.truth.pose);
        let terms = Terms::between(before, record);
        self.moved = self.moved + real;
        let now = real.scaled(1.0 / span_s.max(f64::MIN_POSITIVE));
        let [least, most] = self.range.unwrap_or([now; 2]);
        let each = |pick: fn(f64, f64) -> f64, one: Twist| {
            let [x, y, turn] = [
                pick(one.vx_m_s, now.vx_m_s),
                pick(one.vy_m_s, now.vy_m_s),
                pick(one.omega_rad_s, now.omega_rad_s),
            ];
            Twist::new(x, y, turn)
        };
        self.range = Some([each(f64::min, least), each(f64::max, most)]);
        self.terms = self
            .terms
            .zip(&terms, |sum, term| sum + term.scaled(span_s));
        self.time_s += span_s;
        self.until_s = record.t_s;
        let share = supply_share(header, record.t_s);
        for (wheel, sample) in header.wheels.iter().zip(samples) {
            let off_rad = span_s * (sample.target_rad_s - sample.rate_rad_s).abs();
            let [gives_all, turns_fastest] = limits_met(header, wheel, sample, share);
            let where_it_is = |is_so: bool| if is_so { off_rad } else { 0.0 };
            self.off_rad += off_rad;
            if wheel.torque_limit_n_m == Some(0.0) {
                self.undriven_rad += off_rad;
                continue;
            }
            self.at_limit_rad += where_it_is(gives_all || turns_fastest);
            self.at_rate_limit_rad += where_it_is(turns_fastest);
            self.held_rad += where_it_is(is_held(wheel, sample));
            let is_swallowed = header.dead_band_n_m.is_some() && sample.torque_n_m == 0.0;
            self.swallowed_rad += where_it_is(is_swallowed);
        }
    }

    fn is_long(&self) -> bool {
        self.until_s - self.from_s >= LEAST_STRETCH_S
    }

    /// A sum as a mean.
    fn mean(&self, sum: Twist) -> Twist {
        sum.scaled(1.0 / self.time_s.max(f64::MIN_POSITIVE))
    }

    fn asked(&self) -> Twist {
        self.mean(self.moved + self.terms.total)
    }

    /// Returns the twist of the wheels' rates by Indiveri 2009, eq. (7).
    fn ideal(&self) -> Twist {
        let Terms {
            geometry,
            lift_off,
            conflict,
            slip,
            ..
        } = self.terms;
        self.mean(self.moved + slip + conflict + lift_off + geometry)
    }

    /// Returns what kept the wheels from their targets: the motors' limits, if they account for
    /// most of the deviation, dry friction, or the wheel loops; that no motor drives them, if the
    /// driven ones follow theirs, for wheels without a motor roll along with the driven ones.
    ///
    /// Friction slows wheels, and so is not what `adds` to a motion.
    fn behind_targets(&self, adds: bool) -> &'static str {
        /// The share of the driven wheels in the deviation below which they follow. Chosen.
        const FOLLOW: f64 = 0.1;
        let driven_rad = self.off_rad - self.undriven_rad;
        let is_most = |rad: f64| 2.0 * rad > driven_rad;
        let by_rate = 2.0 * self.at_rate_limit_rad > self.at_limit_rad;
        match (is_most(self.at_limit_rad), is_most(self.held_rad)) {
            _ if driven_rad < FOLLOW * self.off_rad => "the rolling of wheels without a motor",
            _ if is_most(self.swallowed_rad) && !adds => "the motors' dead band",
            (true, _) if by_rate => "the motors' rate limit",
            // Also where friction takes most of it: a stronger motor would overcome that.
            (true, _) => "the motors' limit",
            (_, true) if !adds => "the dry friction of bearings and gears",
            (false, _) => "the wheel loops' error",
        }
    }
}

impl Means {
    pub fn add(&mut self, header: &Header, record: &Record, samples: &[WheelSample]) {
        let asked = record.command_twist_in_body;
        self.most_asked_m_s = self.most_asked_m_s.max(size_m_s(header, asked));
        let torques = samples.iter().map(|sample| sample.torque_n_m.abs());
        self.most_torque_n_m = torques.fold(self.most_torque_n_m, f64::max);
        let before = self.before.replace(*record);
        if let Some(before) = &before {
            // The first row of the window has no predecessor in it.
            if header.is_measured(before.t_s) && header.is_measured(record.t_s) {
                self.window.add(header, [before, record], samples);
            }
            let beyond = Terms::between(before, record).total;
            let missing = beyond.scaled(record.t_s - before.t_s);
            if record.t_s <= header.measure_from_s {
                self.veered_rad -= missing.omega_rad_s;
            }
            let moved = before.truth.pose.displacement_to(&record.truth.pose);
            let from = self.led_to.unwrap_or(before.truth.pose);
            self.led_to = Some(from.moved(moved + missing));
            // A row's command holds until the next row.
            if let Some(stretch) = self.stretches.last_mut() {
                stretch.until_s = record.t_s;
                if before.t_s >= stretch.from_s + SETTLE_S {
                    stretch.add(header, [before, record], samples);
                }
            }
        }
        if before.is_none_or(|before| before.command_twist_in_body != asked) {
            // A twist that changes from row to row is no stretch.
            self.stretches.pop_if(|last| !last.is_long());
            self.stretches.push(Stretch {
                from_s: record.t_s,
                until_s: record.t_s,
                ..Stretch::default()
            });
        }
    }

    /// Returns the stretches before the window of the means with a commanded motion.
    fn earlier(&self, header: &Header) -> Vec<&Stretch> {
        let stretches = self.stretches.iter();
        let told = stretches.filter(|stretch| {
            stretch.is_long()
                && stretch.until_s <= header.measure_from_s
                && size_m_s(header, stretch.asked()) > STANDING
        });
        told.collect()
    }
}

/// Reports why a robot did not move at all: no command, or no motor torque; `None` if it moved, or
/// for other reasons.
pub(super) fn at_rest(header: &Header, summary: &Summary, means: &Means) -> Option<String> {
    /// A robot that moved and turned less than this did not move, in m and rad.
    const LEAST: f64 = 1e-3;
    /// A motor with less torque than this gave none, in N m.
    const NO_TORQUE_N_M: f64 = 1e-9;
    if summary.travelled_m > LEAST || summary.turned_rad > LEAST {
        return None;
    }
    let why = if means.most_asked_m_s <= STANDING {
        match header.open_loop && header.measure_from_s >= summary.duration_s {
            true => format!(
                "no motion is commanded within {}: the robot rests for `twist.rest_s` first, or its twist is 0",
                time(summary.duration_s)
            ),
            false if summary.position_error_final_m > Some(LEAST) && header.is_on_tyres() => {
                "the way to its goal is sideways, where its tyres cannot roll".to_owned()
            }
            false => "no motion is commanded".to_owned(),
        }
    } else if means.most_torque_n_m <= NO_TORQUE_N_M {
        let asked = metres(means.most_asked_m_s);
        let swallowed = header.dead_band_n_m.filter(|n_m| *n_m > 0.0).map(|n_m| {
            format!(
                ": their dead band `motors.dead_band_n_m` suppresses less than {} N m",
                ilon_trace::significant(n_m, 3)
            )
        });
        format!(
            "up to {asked} were commanded, but the motors gave no torque{}",
            swallowed.unwrap_or_default()
        )
    } else {
        let frictions = header.wheels.iter().map(|wheel| wheel.dry_friction_n_m);
        let least_n_m = frictions.map(Option::unwrap_or_default).reduce(f64::min)?;
        // A wheel on the point of turning is held as well.
        if means.most_torque_n_m > least_n_m * (1.0 + 1e-9) {
            return None;
        }
        format!(
            "up to {} were commanded, but the motors gave {} N m at most, and the dry friction of bearings and gears holds each wheel up to {} N m",
            metres(means.most_asked_m_s),
            ilon_trace::significant(means.most_torque_n_m, 3),
            ilon_trace::significant(least_n_m, 3)
        )
    };
    Some(format!("The robot <b>did not move</b>: {why}."))
}

/// Reports a robot in open loop that turned off its command before the measured time: what it does
/// afterwards leads elsewhere, though its means there are as commanded.
pub(super) fn veered(header: &Header, means: &Means) -> Option<String> {
    /// A smaller turn, and a smaller distance, are not worth a sentence. Chosen.
    const LEAST_RAD: f64 = 0.5 / 180.0 * std::f64::consts::PI;
    const LEAST_M: f64 = 5e-3;
    let (last, led_to) = (means.before.as_ref()?, means.led_to?);
    let end = last.truth.pose;
    let off_m = end.position_m() - led_to.position_m();
    let (sin, cos) = led_to.heading_rad.sin_cos();
    let left_m = cos * off_m.y - sin * off_m.x;
    let ahead_m = cos * off_m.x + sin * off_m.y;
    let far_m = off_m.norm();
    // A run without a cause that the scenario names has said it already.
    let is_told = |twin: &Twin| matches!(twin.change, Change::Without(_));
    if !header.open_loop
        || header.twins.iter().any(is_told)
        || means.veered_rad.abs() < LEAST_RAD
        || far_m < LEAST_M
    {
        return None;
    }
    let side = |x: f64, plus: &'static str, minus: &'static str| if x > 0.0 { plus } else { minus };
    let where_to = match left_m.abs() > ahead_m.abs() {
        true => side(left_m, "to the left of", "to the right of"),
        false => side(ahead_m, "ahead of", "behind"),
    };
    Some(format!(
        "It ended <b>{}</b> {where_to} where the command leads: until {} it had turned by <b>{}</b> to the {} of it.",
        length(far_m),
        time(header.measure_from_s.min(last.t_s)),
        angle(means.veered_rad.abs()),
        side(means.veered_rad, "left", "right")
    ))
}

/// Returns the remaining share of the battery's voltage at a time in seconds, from 0 to 1.
fn supply_share(header: &Header, t_s: f64) -> f64 {
    let faults = header.faults.iter().flatten();
    let on = faults.filter(|f| t_s >= f.from_s && f.until_s.is_none_or(|until_s| t_s < until_s));
    on.map(|fault| match fault.kind {
        FaultKind::BatterySag { share } => share,
        _ => 1.0,
    })
    .product()
}

/// Whether a wheel is too slow while its motor is at the torque limit for a share of its supply,
/// and while the wheel is at its rate limit.
fn limits_met(header: &Header, wheel: &WheelHeader, sample: &WheelSample, share: f64) -> [bool; 2] {
    let rate_rad_s = sample.rate_rad_s.abs();
    let line = header.motor_line;
    let strength = wheel.motor_strength.map_or(1.0, |[forwards, backwards]| {
        if sample.target_rad_s < 0.0 {
            backwards
        } else {
            forwards
        }
    });
    let by_line_n_m = line.map(|line| {
        line.stall_torque_n_m * (share * strength - rate_rad_s / line.no_load_rate_rad_s).max(0.0)
    });
    let by_current_n_m = line.and_then(|line| line.current_limit_n_m);
    let own = if line.is_none() { strength } else { 1.0 };
    let by_effort_n_m = wheel.torque_limit_n_m.map(|n_m| own * n_m);
    let limits = [by_effort_n_m, by_line_n_m, by_current_n_m];
    let most_n_m = limits.into_iter().flatten().reduce(f64::min);
    let too_slow = sample.target_rad_s.abs() > rate_rad_s;
    let gives_all = most_n_m.is_some_and(|most_n_m| sample.torque_n_m.abs() >= AT_LIMIT * most_n_m);
    let turns_fastest = wheel
        .rate_limit_rad_s
        .is_some_and(|limit_rad_s| rate_rad_s >= AT_LIMIT * limit_rad_s);
    [gives_all, turns_fastest].map(|is_met| is_met && too_slow)
}

/// Whether dry friction of bearing and gear takes most of the torque of a wheel that is too slow,
/// or holds it.
fn is_held(wheel: &WheelHeader, sample: &WheelSample) -> bool {
    let too_slow = sample.target_rad_s.abs() > sample.rate_rad_s.abs();
    let takes_most = |n_m: f64| 2.0 * n_m >= sample.torque_n_m.abs();
    too_slow && wheel.dry_friction_n_m.is_some_and(takes_most)
}

/// A component of the mean twists, with its name and unit.
struct Axis {
    of: fn(Twist) -> f64,
    plus: &'static str,
    minus: &'static str,
    unit: fn(f64) -> String,
    is_turn: bool,
    /// Smaller values are shown as zero.
    shown: f64,
}

fn metres(v_m_s: f64) -> String {
    format!("{:.4} m/s", v_m_s.abs())
}

fn degrees(w_rad_s: f64) -> String {
    format!("{:.2}°/s", w_rad_s.to_degrees().abs())
}

const AXES: [Axis; 3] = [
    Axis {
        of: |twist| twist.vx_m_s,
        plus: "Ahead",
        minus: "Backwards",
        unit: metres,
        is_turn: false,
        shown: 5e-5,
    },
    Axis {
        of: |twist| twist.vy_m_s,
        plus: "To the left",
        minus: "To the right",
        unit: metres,
        is_turn: false,
        shown: 5e-5,
    },
    Axis {
        of: |twist| twist.omega_rad_s,
        plus: "Turning left",
        minus: "Turning right",
        unit: degrees,
        is_turn: true,
        shown: 8.7e-5,
    },
];

impl Axis {
    fn direction(&self, value: f64) -> &'static str {
        if value < 0.0 { self.minus } else { self.plus }
    }

    /// Returns the robot's motion along it compared with the command.
    fn did(&self, real: f64, asked: f64) -> String {
        let is_shown = real.abs() >= self.shown;
        let way = match is_shown && real * asked < 0.0 {
            true => " the other way",
            false => "",
        };
        format!("{}{way}", (self.unit)(real))
    }
}

/// Reports the missing part of the commanded motion, with causes, for each axis of an open-loop
/// run: in each stretch of its schedule, and in the window of the means. Without `with_shares` the
/// robot did not stand freely on its wheels, and shares are meaningless.
pub(super) fn sentences(header: &Header, means: &Means, with_shares: bool) -> Vec<String> {
    if !header.open_loop || means.most_asked_m_s <= STANDING && means.window.time_s <= 0.0 {
        return Vec::new();
    }
    let earlier = means.earlier(header);
    if means.window.time_s <= 0.0 && earlier.is_empty() {
        return vec![
            "No mean velocities: the run ends too soon after the robot's rest and ramp.".to_owned(),
        ];
    }
    let is_schedule = !earlier.is_empty();
    let mut lines: Vec<String> = earlier
        .iter()
        .take(MOST_STRETCHES)
        .flat_map(|stretch| {
            let settled = Stretch {
                from_s: stretch.from_s + SETTLE_S,
                ..**stretch
            };
            of_stretch(header, &settled, with_shares, is_schedule)
        })
        .collect();
    if earlier.len() > MOST_STRETCHES {
        let more = earlier.len() - MOST_STRETCHES;
        lines.push(format!("{more} more stretches of the schedule follow."));
    }
    if means.window.time_s > 0.0 {
        let window = Stretch {
            from_s: header.measure_from_s,
            ..means.window
        };
        lines.extend(of_stretch(header, &window, with_shares, is_schedule));
    }
    lines
}

/// Reports the missing part in a stretch, for each axis, with its time if there are others.
fn of_stretch(
    header: &Header,
    stretch: &Stretch,
    with_shares: bool,
    is_schedule: bool,
) -> Vec<String> {
    let [asked, ideal, real] = [
        stretch.asked(),
        stretch.ideal(),
        stretch.mean(stretch.moved),
    ];
    let speed_m_s = asked.linear_m_s().norm();
    let least_m_s = (DRIVEN_SHARE * size_m_s(header, ideal)).max(DRIVEN_M_S);
    let mut lines = Vec::new();
    for axis in &AXES {
        let of = axis.of;
        let arm_m = if axis.is_turn { arm_m(header) } else { 1.0 };
        let [asked, ideal, real] = [asked, ideal, real].map(of);
        let is_driven = asked.abs().max(ideal.abs()) * arm_m > least_m_s;
        let when = |direction: &str| match is_schedule {
            true => format!(
                "From {:.2} to {} <b>{}</b>",
                stretch.from_s,
                time(stretch.until_s),
                direction.to_lowercase()
            ),
            false => format!("<b>{direction}</b>"),
        };
        let follows = (asked - ideal).abs() <= AS_ASKED * asked.abs();
        // If the wheels follow their commands, their motion is enough.
        let base = match follows && with_shares {
            true => ideal,
            false => asked,
        };
        if !is_driven || base.abs() <= STANDING {
            let drifts = real.abs() > LEAST_DRIFT.max(DRIFT_SHARE * speed_m_s);
            if drifts && with_shares && asked.abs() <= STANDING {
                let verb = if axis.is_turn { "reached" } else { "moved at" };
                lines.push(format!(
                    "{} it {verb} <b>{}</b> without a command.",
                    when(axis.direction(real)),
                    (axis.unit)(real)
                ));
            }
            continue;
        }
        let mut direction = when(axis.direction(base));
        let swing = |[least, most]: [Twist; 2]| of(most) - of(least);
        if stretch.range.map_or(0.0, swing) > UNSTEADY * base.abs() {
            direction += &match is_schedule {
                true => ", on average,".to_owned(),
                false => format!(", on average from {} on,", time(stretch.from_s)),
            };
        }
        let (unit, did) = (axis.unit, axis.did(real, base));
        if !with_shares {
            lines.push(format!(
                "{direction} the command was {}, and it reached <b>{did}</b>.",
                unit(base)
            ));
            continue;
        }
        let share = percent(real / base);
        let mean = |sum: Twist| of(stretch.mean(sum)) / base;
        let terms = &stretch.terms;
        if follows {
            lines.push(format!(
                "{direction} it reached {did}; its wheel speeds give {} by the ideal kinematics: <b>{share}</b>. {}.",
                unit(ideal),
                capital(&of_contacts(header, terms, mean))
            ));
            continue;
        }
        let before = [
            ("saturation", terms.guidance),
            (compensation(header), terms.compensation),
            (header.belief_in_words(), terms.belief),
            (stretch.behind_targets(mean(terms.servo) < 0.0), terms.servo),
        ];
        let before = taken(before, mean);
        lines.push(format!(
            "{direction} the command was {}, the wheel speeds give {}, and it reached {did}: <b>{share}</b> of the command. {}.",
            unit(asked),
            axis.did(ideal, base),
            capital(&format!("{before}{}", of_contacts(header, terms, mean)))
        ));
    }
    lines
}

/// Returns the name of what the command adds in advance: of tyres that are steered, how far they
/// are off the angles of the twist.
pub(super) fn compensation(header: &Header) -> &'static str {
    by_kind(header, "the steering error", "the command's compensation")
}

/// Returns the loss by each term that is large enough to show, each preceded by a comma.
fn taken<const N: usize>(terms: [(&str, Twist); N], mean: impl Fn(Twist) -> f64) -> String {
    let shares = terms.map(|(name, term)| (name, mean(term)));
    let shown = shares
        .into_iter()
        .filter(|(_, share)| share.abs() >= LEAST_SHARE);
    shown
        .map(|(name, share)| format!("{name} {}, ", takes(share)))
        .collect()
}

/// Reports the difference between the wheels' rates and the robot's motion.
fn of_contacts(header: &Header, terms: &Terms, mean: impl Fn(Twist) -> f64 + Copy) -> String {
    let rare = [
        (
            "the unequal load of wheels that contradict each other (lift-off in the budget)",
            terms.lift_off,
        ),
        ("the conflict between the wheels' rates", terms.conflict),
    ];
    let incline = [(
        "the incline (the way up is longer than on a map)",
        terms.incline,
    )];
    let geometry = match header.is_on_tyres() {
        true => taken([("the tyres' width", terms.geometry)], mean),
        false => format!("roller geometry {}, ", takes(mean(terms.geometry))),
    };
    format!(
        "{geometry}{}{}slip {}",
        taken(rare, mean),
        taken(incline, mean),
        takes(mean(terms.slip))
    )
}

/// Returns the effect of a cause on the motion, as a verb: on a slope or under a push slip can add
/// to it.
fn takes(share: f64) -> String {
    if share == 0.0 {
        return "takes nothing".to_owned();
    }
    let text = percent(share.abs());
    let is_shown = !text.starts_with("less");
    let verb = if share < 0.0 && is_shown {
        "adds"
    } else {
        "takes"
    };
    format!("{verb} {text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slip_that_carries_the_robot_on_adds_to_its_motion() {
        assert_eq!(takes(0.0204), "takes 2.0 %");
        assert_eq!(takes(-0.52), "adds 52.0 %");
        // A value too small to show has no direction, and zero is nothing.
        assert_eq!(takes(-1e-5), "takes less than 0.05 %");
        assert_eq!(takes(0.0), "takes nothing");
    }

    /// A term that adds to the motion is said like one that takes from it.
    #[test]
    fn terms_of_either_sign_are_said_and_small_ones_are_not() {
        let ahead = |share: f64| Twist::new(share, 0.0, 0.0);
        let terms = [
            ("slip", ahead(-0.1)),
            ("the motors", ahead(0.02)),
            ("play", ahead(1e-5)),
        ];
        let said = taken(terms, |twist| twist.vx_m_s);
        assert_eq!(said, "slip adds 10.0 %, the motors takes 2.0 %, ");
    }

    /// The term weighs wheels by their load, whether or not one is in the air.
    #[test]
    fn unequal_load_is_not_said_to_lift_wheels() {
        let lift_off = Twist::new(0.059, 0.0, 0.0);
        let terms = Terms {
            lift_off,
            ..Terms::default()
        };
        let said = of_contacts(&Header::default(), &terms, |twist| twist.vx_m_s);
        let words = "the unequal load of wheels that contradict each other";
        assert!(
            said.contains(words) && !said.contains("in the air"),
            "{said}"
        );
    }

    /// Sentences for an open-loop run with one commanded speed ahead, another by its wheels, and a
    /// third of the robot.
    fn said(asked: f64, ideal: f64, real: f64, with_shares: bool) -> Vec<String> {
        let header = Header {
            open_loop: true,
            ..Header::default()
        };
        let ahead = |v: f64| Twist::new(v, 0.0, 0.0);
        let window = Stretch {
            time_s: 1.0,
            moved: ahead(real),
            terms: Terms {
                total: ahead(asked - real),
                servo: ahead(asked - ideal),
                slip: ahead(ideal - real),
                ..Terms::default()
            },
            off_rad: 4.0,
            at_limit_rad: 4.0,
            ..Stretch::default()
        };
        let means = Means {
            window,
            ..Means::default()
        };
        sentences(&header, &means, with_shares)
    }

    #[test]
    fn a_robot_is_held_against_what_was_asked_where_its_wheels_did_not_do_that() {
        assert_eq!(
            said(0.3, 0.3, 0.294, true),
            [
                "<b>Ahead</b> it reached 0.2940 m/s; its wheel speeds give 0.3000 m/s by the ideal kinematics: <b>98.0 %</b>. \
              Roller geometry takes nothing, slip takes 2.0 %."
            ]
        );
        // 0.4 of 0.5 m/s are lost by the motors, 0.001 by slip.
        assert_eq!(
            said(0.5, 0.1, 0.0995, true),
            [
                "<b>Ahead</b> the command was 0.5000 m/s, the wheel speeds give 0.1000 m/s, and it reached 0.0995 m/s: \
              <b>19.9 %</b> of the command. The motors' limit takes 80.0 %, roller geometry takes nothing, slip takes 0.1 %."
            ]
        );
        assert_eq!(
            said(0.3, 0.3, 0.0027, false),
            ["<b>Ahead</b> the command was 0.3000 m/s, and it reached <b>0.0027 m/s</b>."]
        );
    }

    /// Half of the time at 0.3 m/s, then still before a wall: the mean is said as one, with the
    /// time from which it is one.
    #[test]
    fn a_mean_that_the_robot_rarely_has_is_told_as_a_mean() {
        let header = Header {
            open_loop: true,
            measure_from_s: 1.5,
            measure_to_s: 3.5,
            ..Header::default()
        };
        let mut means = Means::default();
        let (mut ledger, mut x_m) = (ilon_trace::Ledger::default(), 0.0);
        for row in 0..=350 {
            let t_s = 0.01 * f64::from(row);
            let real_m_s = if t_s < 2.5 { 0.3 } else { 0.0 };
            let ahead = |v: f64| Twist::new(v, 0.0, 0.0);
            let mut record = Record {
                t_s,
                ledger,
                command_twist_in_body: ahead(0.3),
                granted_twist_in_body: ahead(0.3),
                twist_target_ideal: ahead(0.3),
                twist_ideal: ahead(0.3),
                twist_contact: ahead(0.3),
                ..Record::default()
            };
            record.truth.pose.x_m = x_m;
            record.truth.twist_in_body = ahead(real_m_s);
            ledger.count(&ilon_trace::ledger::Chain::held(&record, 0.01), [0.0; 2]);
            x_m += 0.01 * real_m_s;
            means.add(&header, &record, &[]);
        }
        let lines = sentences(&header, &means, true);
        let words = "<b>Ahead</b>, on average from 1.50 s on, it reached 0.1500 m/s";
        assert!(lines[0].starts_with(words), "{lines:?}");
        assert!(said(0.3, 0.3, 0.294, true)[0].starts_with("<b>Ahead</b> it reached 0.2940 m/s"));
    }

    #[test]
    fn what_is_shown_as_zero_goes_no_other_way() {
        let lines = said(0.3, 0.3, -1e-5, true);
        assert!(lines[0].contains("reached 0.0000 m/s; "), "{lines:?}");
        let lines = said(0.3, 0.3, -1e-3, true);
        assert!(
            lines[0].contains("reached 0.0010 m/s the other way; "),
            "{lines:?}"
        );
    }

    #[test]
    fn what_nobody_asked_for_is_no_share_of_anything() {
        let lines = said(0.0, 0.0, 0.1, true);
        assert!(lines[0].ends_with("without a command."), "{lines:?}");
        assert!(
            lines
                .iter()
                .all(|line| !line.contains("inf") && !line.contains("NaN"))
        );
    }

    /// A motor at its limit is no cause if its wheel turns too fast: then it brakes.
    #[test]
    fn a_motor_is_at_its_limit_only_where_its_wheel_is_too_slow() {
        let wheel = WheelHeader {
            torque_limit_n_m: Some(2.0),
            ..WheelHeader::default()
        };
        let at_limit = |target_rad_s: f64, torque_n_m: f64| {
            let sample = WheelSample {
                target_rad_s,
                rate_rad_s: 5.0,
                torque_n_m,
                ..WheelSample::default()
            }
            .steady();
            limits_met(&Header::default(), &wheel, &sample, 1.0)[0]
        };
        assert!(at_limit(6.0, 2.0));
        assert!(!at_limit(4.0, -2.0));
        assert!(!at_limit(6.0, 1.0));
    }

    /// One weak motor of two at its limit misses 3 of 3.2 rad/s: the motors are the cause, though
    /// most samples of wheels are at no limit. A wheel with 0.1 N m of dry friction that stands
    /// under 0.05 N m is held by it, and one that turns under 0.15 N m loses most of that to it.
    #[test]
    fn what_keeps_wheels_from_their_targets_is_weighed_by_what_they_miss() {
        let wheel = |strength: f64, dry_n_m: f64| WheelHeader {
            torque_limit_n_m: Some(2.0),
            motor_strength: Some([strength, 1.0]),
            dry_friction_n_m: Some(dry_n_m),
            ..WheelHeader::default()
        };
        let said = |wheels: Vec<WheelHeader>, seen: &[[f64; 3]]| {
            let header = Header {
                wheels,
                ..Header::default()
            };
            let sample = |[target_rad_s, rate_rad_s, torque_n_m]: &[f64; 3]| {
                WheelSample {
                    target_rad_s: *target_rad_s,
                    rate_rad_s: *rate_rad_s,
                    torque_n_m: *torque_n_m,
                    ..WheelSample::default()
                }
                .steady()
            };
            let samples: Vec<WheelSample> = seen.iter().map(sample).collect();
            let [before, mut after] = [Record::default(); 2];
            after.t_s = 1.0;
            let mut stretch = Stretch::default();
            stretch.add(&header, [&before, &after], &samples);
            [false, true].map(|adds| stretch.behind_targets(adds))
        };
        let weak = vec![wheel(0.5, 0.0), wheel(1.0, 0.0), wheel(1.0, 0.0)];
        let missed = [[6.0, 3.0, 1.0], [6.0, 5.9, 0.5], [6.0, 5.9, 0.5]];
        assert_eq!(said(weak, &missed), ["the motors' limit"; 2]);
        let even = vec![wheel(1.0, 0.0), wheel(1.0, 0.0), wheel(1.0, 0.0)];
        assert_eq!(said(even, &missed), ["the wheel loops' error"; 2]);
        let held = vec![wheel(1.0, 0.1), wheel(1.0, 0.1)];
        let seen = [[0.4, 0.0, 0.05], [8.0, 6.0, 0.15]];
        let by_friction = "the dry friction of bearings and gears";
        assert_eq!(said(held, &seen), [by_friction, "the wheel loops' error"]);
        let weak_and_held = vec![wheel(0.5, 0.8)];
        let seen = [[6.0, 3.0, 1.0]];
        assert_eq!(said(weak_and_held, &seen), ["the motors' limit"; 2]);
        // Free wheels miss their targets too: with a driven one at its limit, and alone.
        let free = || WheelHeader {
            torque_limit_n_m: Some(0.0),
            ..wheel(1.0, 0.0)
        };
        let behind = [[6.0, 5.5, 1.0], [6.0, 5.4, 0.0], [6.0, 5.4, 0.0]];
        let weak = vec![wheel(0.5, 0.0), free(), free()];
        assert_eq!(said(weak, &behind), ["the motors' limit"; 2]);
        let alone = [[6.0, 5.99, 0.5], [6.0, 5.4, 0.0], [6.0, 5.4, 0.0]];
        let follows = vec![wheel(1.0, 0.0), free(), free()];
        let by_free = "the rolling of wheels without a motor";
        assert_eq!(said(follows, &alone), [by_free; 2]);
        // Two wheels that stand under motors with a dead band, without torque and with some.
        let even = || vec![wheel(1.0, 0.0), wheel(1.0, 0.0)];
        let said_of = |torque_n_m: f64| {
            let header = Header {
                dead_band_n_m: Some(0.2),
                wheels: even(),
                ..Header::default()
            };
            let sample = WheelSample {
                target_rad_s: 6.0,
                torque_n_m,
                ..WheelSample::default()
            };
            let [before, mut after] = [Record::default(); 2];
            after.t_s = 1.0;
            let mut stretch = Stretch::default();
            stretch.add(&header, [&before, &after], &[sample.steady(); 2]);
            stretch.behind_targets(false)
        };
        assert_eq!(said_of(0.0), "the motors' dead band");
        assert_eq!(said_of(0.3), "the wheel loops' error");
    }

    /// From 1 to 3 s 2 m/s are commanded, of which motors limited to 1 m/s give half; then 0.
    #[test]
    fn each_stretch_of_a_schedule_is_told_of_and_a_robot_that_rests_says_why() {
        let header = Header {
            open_loop: true,
            control_dt_s: 0.01,
            measure_from_s: 3.5,
            measure_to_s: 5.0,
            wheels: vec![WheelHeader {
                rate_limit_rad_s: Some(20.0),
                ..WheelHeader::default()
            }],
            ..Header::default()
        };
        let run = |asked_m_s: f64, end: u32| {
            let mut means = Means::default();
            let mut ledger = ilon_trace::Ledger::default();
            let mut x_m = 0.0;
            for row in 0..=end {
                let t_s = 0.01 * f64::from(row);
                let is_asked = (1.0..3.0).contains(&t_s) && asked_m_s > 0.0;
                let ahead = |v: f64| Twist::new(if is_asked { v } else { 0.0 }, 0.0, 0.0);
                let mut record = Record {
                    t_s,
                    ledger,
                    command_twist_in_body: ahead(asked_m_s),
                    granted_twist_in_body: ahead(asked_m_s),
                    twist_target_ideal: ahead(asked_m_s),
                    twist_ideal: ahead(1.0),
                    twist_contact: ahead(1.0),
                    ..Record::default()
                };
                record.truth.pose.x_m = x_m;
                record.truth.twist_in_body = ahead(1.0);
                ledger.count(&ilon_trace::ledger::Chain::held(&record, 0.01), [0.0; 2]);
                x_m += 0.01 * ahead(1.0).vx_m_s;
                let sample = WheelSample {
                    target_rad_s: if is_asked { 40.0 } else { 0.0 },
                    rate_rad_s: if is_asked { 20.0 } else { 0.0 },
                    ..WheelSample::default()
                };
                means.add(&header, &record, &[sample.steady()]);
            }
            means
        };
        let lines = sentences(&header, &run(2.0, 500), true);
        let [line] = &lines[..] else {
            panic!("one stretch moves: {lines:?}");
        };
        for words in [
            // Means begin 0.3 s after the command.
            "From 1.30 to 3.00 s <b>ahead</b> the command was 2.0000 m/s",
            "reached 1.0000 m/s: <b>50.0 %</b>",
            "The motors' rate limit takes 50.0 %",
        ] {
            assert!(line.contains(words), "{line}");
        }
        let still = run(0.0, 500);
        assert!(sentences(&header, &still, true).is_empty());
        let mut summary = Summary::default();
        summary.duration_s = 5.0;
        let said = |summary: &Summary| at_rest(&header, summary, &still).unwrap_or_default();
        assert!(said(&summary).ends_with("no motion is commanded."));
        let mut on_tyres = header.clone();
        on_tyres
            .wheels
            .iter_mut()
            .for_each(|wheel| wheel.roller_count = 1);
        summary.position_error_final_m = Some(0.5);
        let sideways = at_rest(&on_tyres, &summary, &still).unwrap_or_default();
        assert!(sideways.contains("its tyres cannot roll"), "{sideways}");
        summary.position_error_final_m = None;
        summary.duration_s = 1.0;
        // A run that ends before its measurement may also be one of a twist of 0 that never rests.
        assert!(said(&summary).contains("rests for `twist.rest_s` first, or its twist is 0"));
        let no_torque = at_rest(&header, &summary, &run(2.0, 500)).unwrap_or_default();
        assert!(no_torque.contains("2.0000 m/s were commanded, but the motors gave no torque"));
        let mut banded = header.clone();
        banded.dead_band_n_m = Some(0.2);
        let by_band = at_rest(&banded, &summary, &run(2.0, 500)).unwrap_or_default();
        assert!(by_band.contains("dead band `motors.dead_band_n_m` suppresses less than 0.2 N m"));
        summary.travelled_m = 1.0;
        assert_eq!(said(&summary), "");
    }

    /// A wheel that is 1 rad/s behind its target for a second, and then as much ahead of it, was
    /// off by 2 rad in all.
    #[test]
    fn what_a_wheel_is_ahead_does_not_make_up_for_what_it_was_behind() {
        let mut header = Header::default();
        header.wheels.push(Default::default());
        let at = |t_s: f64| {
            let record = Record::default();
            Record { t_s, ..record }
        };
        let mut stretch = Stretch::default();
        for (second, [target_rad_s, rate_rad_s]) in [(0.0, [3.0, 2.0]), (1.0, [2.0, 3.0])] {
            let sample = WheelSample {
                target_rad_s,
                rate_rad_s,
                ..WheelSample::default()
            };
            stretch.add(&header, [&at(second), &at(second + 1.0)], &[sample]);
        }
        assert_eq!((stretch.time_s, stretch.off_rad), (2.0, 2.0));
    }
}
