//! What of the motion that an open-loop run asked for is missing, axis by axis, in words.

use ilon_robot::Twist;
use ilon_trace::ledger::Terms;
use ilon_trace::{FaultKind, Header, Record, Summary, WheelHeader, WheelSample};

use crate::text::capital;
use crate::text::{percent, time};

/// Wheels that turn the robot by less, in m/s or rad/s, stand: a robot that moves all the same was carried.
const STANDING: f64 = 1e-3;
/// Wheels that turn for what was asked to this share of it do as they were asked.
const AS_ASKED: f64 = 1e-3;
/// A part of the motion below this goes without saying.
const LEAST_SHARE: f64 = 5e-4;
/// A motor that gives this share of what it can is at its limit; and so is a wheel that turns at this share of its rate limit.
const AT_LIMIT: f64 = 0.95;
/// What was not asked for is told of from here on: as a share of the speed asked for, and in m/s or rad/s.
const DRIFT_SHARE: f64 = 0.02;
const LEAST_DRIFT: f64 = 5e-3;

/// Means over the window of the means, of what stands between the twist asked for and that of the wheels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Means {
    guidance: Twist,
    compensation: Twist,
    servo: Twist,
    time_s: f64,
    /// The last row within the window.
    before: Option<Record>,
    /// How many samples of wheels there were, and how many with their motor at its limit.
    samples: u32,
    at_limit: u32,
}

impl Means {
    pub fn add(&mut self, header: &Header, record: &Record, samples: &[WheelSample]) {
        if !header.is_measured(record.t_s) {
            return;
        }
        if let Some(before) = self.before.replace(*record) {
            let terms = Terms::between(&before, record);
            let span_s = record.t_s - before.t_s;
            self.guidance = self.guidance + terms.guidance.scaled(span_s);
            self.compensation = self.compensation + terms.compensation.scaled(span_s);
            self.servo = self.servo + terms.servo.scaled(span_s);
            self.time_s += span_s;
        }
        let share = supply_share(header, record.t_s);
        for (wheel, sample) in header.wheels.iter().zip(samples) {
            self.samples += 1;
            self.at_limit += u32::from(is_at_limit(header, wheel, sample, share));
        }
    }

    /// Whether the motors gave all they can for most of the time.
    fn are_motors_at_limit(&self) -> bool {
        2 * self.at_limit > self.samples
    }
}

/// What is left of the battery's voltage at a time in seconds, from 0 to 1.
fn supply_share(header: &Header, t_s: f64) -> f64 {
    let faults = header.faults.iter().flatten();
    let on = faults.filter(|f| t_s >= f.from_s && f.until_s.is_none_or(|until_s| t_s < until_s));
    on.map(|fault| match fault.kind {
        FaultKind::BatterySag { share } => share,
        _ => 1.0,
    })
    .product()
}

/// Whether a wheel is slower than it should be and its motor gives all it can on a share of its supply.
fn is_at_limit(header: &Header, wheel: &WheelHeader, sample: &WheelSample, share: f64) -> bool {
    let rate_rad_s = sample.rate_rad_s.abs();
    let line = header.motor_line;
    let by_line_n_m = line.map(|line| {
        line.stall_torque_n_m * (share - rate_rad_s / line.no_load_rate_rad_s).max(0.0)
    });
    let by_current_n_m = line.and_then(|line| line.current_limit_n_m);
    let limits = [wheel.torque_limit_n_m, by_line_n_m, by_current_n_m];
    let limits = limits.into_iter().flatten();
    let most_n_m = limits.reduce(f64::min);
    let too_slow = sample.target_rad_s.abs() > rate_rad_s;
    let gives_all = most_n_m.is_some_and(|most_n_m| sample.torque_n_m.abs() >= AT_LIMIT * most_n_m);
    let turns_fastest = wheel
        .rate_limit_rad_s
        .is_some_and(|limit_rad_s| rate_rad_s >= AT_LIMIT * limit_rad_s);
    too_slow && (gives_all || turns_fastest)
}

/// A component of the mean twists, with what it is called and its unit.
struct Axis {
    of: fn(Twist) -> f64,
    plus: &'static str,
    minus: &'static str,
    unit: fn(f64) -> String,
    /// Below this a value is shown as zero.
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
        shown: 5e-5,
    },
    Axis {
        of: |twist| twist.vy_m_s,
        plus: "To the left",
        minus: "To the right",
        unit: metres,
        shown: 5e-5,
    },
    Axis {
        of: |twist| twist.omega_rad_s,
        plus: "Turning left",
        minus: "Turning right",
        unit: degrees,
        shown: 8.7e-5,
    },
];

impl Axis {
    fn direction(&self, value: f64) -> &'static str {
        if value < 0.0 { self.minus } else { self.plus }
    }

    /// What the robot did along it where something else was asked for.
    fn did(&self, real: f64, asked: f64) -> String {
        let is_shown = real.abs() >= self.shown;
        let way = match is_shown && real * asked < 0.0 {
            true => " the other way",
            false => "",
        };
        format!("{}{way}", (self.unit)(real))
    }
}

/// What of the motion asked for is missing, and why, for each axis of an open-loop run. Without `with_shares` the robot did not stand
/// free on its wheels, and shares would say nothing.
pub(super) fn sentences(
    header: &Header,
    summary: &Summary,
    means: &Means,
    with_shares: bool,
) -> Vec<String> {
    if !header.open_loop {
        return Vec::new();
    }
    let (Some(real), Some(ideal), Some(contact)) = (
        summary.twist_mean,
        summary.twist_ideal_mean,
        summary.twist_contact_mean,
    ) else {
        let from = time(header.measure_from_s);
        return vec![format!(
            "The run is too short for mean velocities: they are taken from {from} on, after rest and ramp."
        )];
    };
    let asked = summary.twist_asked_mean.unwrap_or(ideal);
    let (by_asked, by_ideal) = (summary.twist_ratio_asked, summary.twist_ratio_ideal);
    let driven = [
        by_asked.vx.or(by_ideal.vx),
        by_asked.vy.or(by_ideal.vy),
        by_asked.omega.or(by_ideal.omega),
    ];
    let speed_m_s = asked.vx_m_s.hypot(asked.vy_m_s);
    let mut lines = Vec::new();
    for (axis, driven) in AXES.iter().zip(driven) {
        let of = axis.of;
        let [asked, ideal, contact, real] = [asked, ideal, contact, real].map(of);
        let follows = (asked - ideal).abs() <= AS_ASKED * asked.abs();
        // Of wheels that do as they were asked it is enough to tell what they did.
        let base = match follows && with_shares {
            true => ideal,
            false => asked,
        };
        if driven.is_none() || base.abs() <= STANDING {
            let drifts = real.abs() > LEAST_DRIFT.max(DRIFT_SHARE * speed_m_s);
            if drifts && with_shares && asked.abs() <= STANDING {
                lines.push(format!(
                    "<b>{}</b> the robot did <b>{}</b> that nobody asked for.",
                    axis.direction(real),
                    (axis.unit)(real)
                ));
            }
            continue;
        }
        let direction = axis.direction(base);
        let (unit, did) = (axis.unit, axis.did(real, base));
        if !with_shares {
            lines.push(format!(
                "<b>{direction}</b> {} were asked for, and the robot did <b>{did}</b>.",
                unit(base)
            ));
            continue;
        }
        let share = percent(real / base);
        let geometry = takes((ideal - contact) / base);
        let slip = takes((contact - real) / base);
        if follows {
            lines.push(format!(
                "<b>{direction}</b> the wheels turned for {} and the robot did {did}: <b>{share}</b> of the ideal kinematics. \
                 The rollers' geometry {geometry}, slip {slip}.",
                unit(ideal),
            ));
            continue;
        }
        let motors = match means.are_motors_at_limit() {
            true => "the motors' limit",
            false => "the wheel loops' error",
        };
        let mean = |sum: Twist| of(sum) / means.time_s.max(f64::MIN_POSITIVE) / base;
        let before = [
            ("saturation", mean(means.guidance)),
            ("the command's compensation", mean(means.compensation)),
            (motors, mean(means.servo)),
        ];
        let before: String = before
            .into_iter()
            .filter(|(_, share)| share.abs() >= LEAST_SHARE)
            .map(|(name, share)| format!("{name} {}, ", takes(share)))
            .collect();
        let all = format!("{before}the rollers' geometry {geometry}, slip {slip}.");
        lines.push(format!(
            "<b>{direction}</b> {} were asked for, the wheels turned for {}, and the robot did {did}: <b>{share}</b> of what was asked. {}",
            unit(asked),
            axis.did(ideal, base),
            capital(&all)
        ));
    }
    lines
}

/// What a cause takes of the motion, as a verb: a floor that slopes or a push can make slip add to it.
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
    use ilon_trace::metrics::TwistRatio;

    #[test]
    fn slip_that_carries_the_robot_on_adds_to_its_motion() {
        assert_eq!(takes(0.0204), "takes 2.0 %");
        assert_eq!(takes(-0.52), "adds 52.0 %");
        // Too little to be shown has no direction, and nothing is nothing.
        assert_eq!(takes(-1e-5), "takes less than 0.05 %");
        assert_eq!(takes(0.0), "takes nothing");
    }

    /// What is said of an open-loop run that was asked for one speed ahead, whose wheels turned for another, and that did a third.
    fn said(asked: f64, ideal: f64, real: f64, with_shares: bool) -> Vec<String> {
        let header = Header {
            open_loop: true,
            ..Header::default()
        };
        let ahead = |v: f64| Some(Twist::new(v, 0.0, 0.0));
        let mut summary = Summary::default();
        summary.twist_asked_mean = ahead(asked);
        summary.twist_ideal_mean = ahead(ideal);
        summary.twist_contact_mean = ahead(ideal);
        summary.twist_mean = ahead(real);
        summary.twist_ratio_asked = TwistRatio {
            vx: Some(real / asked),
            ..TwistRatio::default()
        };
        let means = Means {
            servo: Twist::new(asked - ideal, 0.0, 0.0),
            time_s: 1.0,
            samples: 4,
            at_limit: 4,
            ..Means::default()
        };
        sentences(&header, &summary, &means, with_shares)
    }

    #[test]
    fn a_robot_is_held_against_what_was_asked_where_its_wheels_did_not_do_that() {
        assert_eq!(
            said(0.3, 0.3, 0.294, true),
            [
                "<b>Ahead</b> the wheels turned for 0.3000 m/s and the robot did 0.2940 m/s: <b>98.0 %</b> of the ideal kinematics. \
              The rollers' geometry takes nothing, slip takes 2.0 %."
            ]
        );
        // 0.4 of 0.5 m/s are the motors', 0.001 of it slip.
        assert_eq!(
            said(0.5, 0.1, 0.0995, true),
            [
                "<b>Ahead</b> 0.5000 m/s were asked for, the wheels turned for 0.1000 m/s, and the robot did 0.0995 m/s: \
              <b>19.9 %</b> of what was asked. The motors' limit takes 80.0 %, the rollers' geometry takes nothing, slip takes 0.1 %."
            ]
        );
        assert_eq!(
            said(0.3, 0.3, 0.0027, false),
            ["<b>Ahead</b> 0.3000 m/s were asked for, and the robot did <b>0.0027 m/s</b>."]
        );
    }

    #[test]
    fn what_is_shown_as_zero_goes_no_other_way() {
        let lines = said(0.3, 0.3, -1e-5, true);
        assert!(lines[0].contains("did 0.0000 m/s: "), "{lines:?}");
        let lines = said(0.3, 0.3, -1e-3, true);
        assert!(
            lines[0].contains("did 0.0010 m/s the other way: "),
            "{lines:?}"
        );
    }

    #[test]
    fn what_nobody_asked_for_is_no_share_of_anything() {
        let lines = said(0.0, 0.0, 0.1, true);
        assert!(lines[0].ends_with("that nobody asked for."), "{lines:?}");
        assert!(
            lines
                .iter()
                .all(|line| !line.contains("inf") && !line.contains("NaN"))
        );
    }

    /// A motor that gives all it can is no reason for what is missing where its wheel turns faster than it should: then it brakes.
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
            is_at_limit(&Header::default(), &wheel, &sample, 1.0)
        };
        assert!(at_limit(6.0, 2.0));
        assert!(!at_limit(4.0, -2.0));
        assert!(!at_limit(6.0, 1.0));
    }
}
