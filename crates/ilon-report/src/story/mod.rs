//! The run in a few sentences: the largest error, when it was, and why; then what it cost, and what would help.

mod budget;
mod events;
mod measured;
mod shortfall;
mod slope;

use ilon_trace::{Header, Settings, Summary};

pub(crate) use budget::{Budget, Integrator, PARTS, Standing};
pub(crate) use events::{Event, EventKind, Watch};
pub(crate) use measured::{Measured, apart};

use crate::gathered::OfRobot;
use crate::page::escape;
use crate::shown::Shown;
use crate::words::{angle, energy, length, percent, speed, time};

/// The most sentences of the answer.
const MOST_LINES: usize = 5;

/// Below this a position error is none that anyone asks about, in metres.
const UNREMARKABLE_M: f64 = 1e-3;

/// What is said of a run.
pub(crate) struct Story {
    /// Sentences as HTML, the most important first.
    pub lines: Vec<String>,
    /// What could be tried, and what it would gain, as HTML.
    pub tries: Vec<String>,
    /// The error budget at the worst instant.
    pub budget: Option<Budget>,
    /// All that happened.
    pub events: Vec<Event>,
}

impl Story {
    pub fn of(shown: &Shown, summary: &Summary, settings: &Settings) -> Self {
        let header = &shown.trace.header;
        let events = shown.all.events(header);
        let errors: Vec<(f64, f64)> = shown.all.robot(OfRobot::PositionError).collect();
        let start = Start::of(&errors, settings);
        let budget = budget::at_the_worst(shown.all.standings(), start.settled_s);
        let budget = budget.filter(|b| b.error_m > UNREMARKABLE_M);
        let mut lines: Vec<String> = shown.all.measured.sentence().into_iter().collect();
        let slope = slope::sentence(header, summary, &events);
        let (slope_first, slope) = match slope {
            Some((line, true)) => (Some(line), None),
            Some((line, false)) => (None, Some(line)),
            None => (None, None),
        };
        lines.extend(slope_first);
        let excursion = budget.as_ref().map(|b| excursion(b, &start, &events));
        let ended = tracking(summary, &start);
        // What came from outside explains more than the way in from the start.
        match excursion {
            Some((line, true)) => lines.extend([Some(line), ended].into_iter().flatten()),
            Some((line, false)) => lines.extend([ended, Some(line)].into_iter().flatten()),
            None => lines.extend(ended),
        }
        if header.open_loop {
            lines.extend(obstacles(&events));
        }
        lines.extend(shortfall::sentences(header, summary));
        lines.extend(slope);
        lines.extend(slipping(summary, &events));
        lines.extend(saturation(summary, header, &events));
        lines.extend(reckoning(summary));
        lines.truncate(MOST_LINES);
        let tries = tries(header, summary, &events);
        Self {
            lines,
            tries,
            budget,
            events,
        }
    }

    /// The sentences as plain text.
    pub fn plain(&self) -> Vec<String> {
        self.lines.iter().map(|line| plain(line)).collect()
    }

    /// The sentences as HTML.
    pub fn html(&self) -> String {
        let paragraphs: String = self.lines.iter().map(|l| format!("<p>{l}</p>")).collect();
        let tries = if self.tries.is_empty() {
            String::new()
        } else {
            let items: String = self.tries.iter().map(|t| format!("<li>{t}</li>")).collect();
            format!("<div class=\"tries\"><h2>To try</h2><ul>{items}</ul></div>\n")
        };
        format!("<div class=\"story\">{paragraphs}</div>\n{tries}")
    }
}

/// A sentence without its marks.
fn plain(html: &str) -> String {
    let mut text = String::with_capacity(html.len());
    let mut inside = false;
    for c in html.chars() {
        match c {
            '<' => inside = true,
            '>' => inside = false,
            c if !inside => text.push(c),
            _ => {}
        }
    }
    let entities = [
        ("&lt;", "<"),
        ("&gt;", ">"),
        ("&quot;", "\""),
        ("&#39;", "'"),
        ("&amp;", "&"),
    ];
    entities
        .iter()
        .fold(text, |text, (entity, c)| text.replace(entity, c))
}

/// How far off the run began, and when that was over.
struct Start {
    error_m: f64,
    /// It began away from its reference.
    is_off: bool,
    /// From here on an error is one of its own, in seconds.
    settled_s: f64,
}

impl Start {
    fn of(errors: &[(f64, f64)], settings: &Settings) -> Self {
        let error_m = errors.first().map_or(0.0, |&(_, e)| e);
        let is_off = error_m > settings.position_threshold_m;
        let settled_s = if is_off {
            let near = errors.iter().find(|&&(_, e)| e <= 0.01 * error_m);
            let nearest = || errors.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            near.or_else(nearest).map_or(0.0, |&(t_s, _)| t_s)
        } else {
            0.0
        };
        Self {
            error_m,
            is_off,
            settled_s,
        }
    }
}

/// The largest error and its cause; and whether the cause came from outside.
fn excursion(budget: &Budget, start: &Start, events: &[Event]) -> (String, bool) {
    const BEFORE_S: f64 = 0.3;
    let size = format!(
        "<b>{}</b> at <b>{}</b>",
        length(budget.error_m),
        time(budget.at_s)
    );
    let outside: Vec<&Event> = events
        .iter()
        .filter(|e| e.is_outside() && e.overlaps(budget.from_s - BEFORE_S, budget.at_s))
        .collect();
    let parts = shares(budget);
    let after = if start.is_off {
        " after it had arrived"
    } else {
        ""
    };
    if let Some(first) = outside.first() {
        let more = match outside.len() {
            1 => String::new(),
            n => format!(" (and {} more)", n - 1),
        };
        let when = capital(&first.when());
        let text = escape(&first.text);
        return (
            format!("{when} {text}{more}: the largest position error{after} was {size}. {parts}"),
            true,
        );
    }
    (
        format!("The largest position error{after} was {size}. {parts}"),
        false,
    )
}

/// Which parts made the error, the largest first.
fn shares(budget: &Budget) -> String {
    let mut grew: Vec<(&str, f64)> = PARTS.into_iter().zip(budget.parts_m).collect();
    grew.sort_by(|a, b| b.1.total_cmp(&a.1));
    let causes: Vec<String> = grew
        .iter()
        .filter(|(_, m)| *m > 0.15 * budget.error_m)
        .take(2)
        .map(|(name, m)| format!("{} made {}", in_words(name), length(*m)))
        .collect();
    if causes.is_empty() {
        return String::new();
    }
    let corrected_m = budget.parts_m[0];
    let back = if corrected_m < -0.15 * budget.error_m {
        format!(", and the guidance took back {}", length(-corrected_m))
    } else {
        String::new()
    };
    format!("Since {} {}{back}.", time(budget.from_s), causes.join(", "))
}

/// A part of the budget in a sentence.
fn in_words(part: &str) -> &str {
    match part {
        "slip" => "sliding contacts",
        "geometry" => "the rollers' geometry",
        "servo" => "wheels that lag their targets",
        "compensation" => "the command's compensation",
        other => other,
    }
}

/// How near it came to its reference.
fn tracking(summary: &Summary, start: &Start) -> Option<String> {
    let (position_m, heading_rad) = (
        summary.position_error_final_m?,
        summary.heading_error_final_rad?,
    );
    let began = if start.is_off {
        format!(
            "It began {} off its reference and ended",
            length(start.error_m)
        )
    } else {
        "It ended".to_owned()
    };
    let converged = match (summary.position_converged_s, summary.heading_converged_s) {
        (Some(0.0), Some(0.0)) => String::new(),
        (Some(p), Some(h)) => format!(
            " The position stayed within 5 cm from {} on, the heading within 3° from {}.",
            time(p),
            time(h)
        ),
        (Some(p), None) => format!(
            " The position stayed within 5 cm from {} on; the heading did not converge.",
            time(p)
        ),
        (None, Some(h)) => format!(
            " The heading stayed within 3° from {} on; the position did not converge.",
            time(h)
        ),
        (None, None) => " Neither position nor heading converged.".to_owned(),
    };
    Some(format!(
        "{began} <b>{}</b> and <b>{}</b> off.{converged}",
        length(position_m),
        angle(heading_rad)
    ))
}

/// What an open-loop run met on its way.
fn obstacles(events: &[Event]) -> Option<String> {
    let outside: Vec<String> = events
        .iter()
        .filter(|e| e.is_outside())
        .take(3)
        .map(|e| format!("{} {}", e.when(), escape(&e.text)))
        .collect();
    (!outside.is_empty()).then(|| format!("{}.", capital(&outside.join("; "))))
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(chars).collect()
    })
}

/// What slid, when, and what it cost; and what new rollers cost.
fn slipping(summary: &Summary, events: &[Event]) -> Option<String> {
    let slip_j = summary.energy.slip_j?;
    let of_work = summary
        .energy
        .motor_j
        .filter(|&motor_j| motor_j > 0.0)
        .map_or_else(String::new, |motor_j| {
            format!(" of the motors' {}", energy(motor_j))
        });
    let hand_over = summary
        .energy
        .spin_up_j
        .filter(|&j| j > 0.005)
        .map_or_else(String::new, |j| {
            format!(" Spinning up new rollers at hand-over took {}.", energy(j))
        });
    let slides: Vec<&Event> = events
        .iter()
        .filter(|e| matches!(e.kind, EventKind::Slide(_)))
        .collect();
    let Some(worst) = slides.iter().max_by(|a, b| a.lost_j.total_cmp(&b.lost_j)) else {
        let creep = speed(summary.slip_speed_rms_m_s.unwrap_or(0.0));
        return Some(format!(
            "No wheel slid at its friction limit (contacts crept at {creep} rms).{hand_over}"
        ));
    };
    // What lay in the same time belongs to the same story.
    let (from_s, until_s) = slides
        .iter()
        .filter(|e| e.overlaps(worst.from_s, worst.until_s))
        .fold((worst.from_s, worst.until_s), |(a, b), e| {
            (a.min(e.from_s), b.max(e.until_s))
        });
    let together: Vec<&&Event> = slides
        .iter()
        .filter(|e| e.overlaps(from_s, until_s))
        .collect();
    let lost_j: f64 = together.iter().map(|e| e.lost_j).sum();
    let mut wheels: Vec<usize> = together
        .iter()
        .filter_map(|e| match e.kind {
            EventKind::Slide(wheel) => Some(wheel),
            _ => None,
        })
        .collect();
    wheels.sort_unstable();
    wheels.dedup();
    let who = if wheels.len() == 1 {
        let name = worst.text.split(" slides").next().unwrap_or("a wheel");
        format!("<b>{}</b>", escape(name))
    } else {
        format!("<b>{} wheels</b>", wheels.len())
    };
    let share = if slip_j > 0.0 {
        (lost_j / slip_j).min(1.0)
    } else {
        0.0
    };
    Some(format!(
        "Sliding cost <b>{}</b>{of_work}, {} of it <b>from {:.2} to {}</b>, when {who} slid up to {}.{hand_over}",
        energy(slip_j),
        percent(share),
        from_s,
        time(until_s),
        length(together.iter().map(|e| e.slid_m).fold(0.0, f64::max)),
    ))
}

/// For how long the guidance could not give what its tasks asked.
fn saturation(summary: &Summary, header: &Header, events: &[Event]) -> Option<String> {
    let share = summary.saturated_share.filter(|&s| s > 0.005)?;
    let longest = events
        .iter()
        .filter(|e| matches!(e.kind, EventKind::Saturated(_)))
        .max_by(|a, b| (a.until_s - a.from_s).total_cmp(&(b.until_s - b.from_s)))?;
    let EventKind::Saturated(task) = longest.kind else {
        return None;
    };
    let name = header.task_names.get(task).map_or("", String::as_str);
    Some(format!(
        "The wheel rates were saturated for {} of the run; the task <b>{}</b> waited longest, {}.",
        percent(share),
        escape(name),
        longest.when()
    ))
}

/// How far dead reckoning drifts.
fn reckoning(summary: &Summary) -> Option<String> {
    let ideal = summary.odometry_ideal.m_per_m?;
    let contact = summary.odometry_contact.m_per_m?;
    Some(format!(
        "Dead reckoning drifts by {} for each metre with the ideal kinematics, by {} with the kinematics of the rollers that touch.",
        length(ideal),
        length(contact)
    ))
}

/// What could be tried, each with what the run itself says that it would gain.
fn tries(header: &Header, summary: &Summary, events: &[Event]) -> Vec<String> {
    let mut tries = Vec::new();
    let scenario = header
        .scenario_toml
        .parse::<toml::Table>()
        .unwrap_or_default();
    let text = |section: &str, key: &str| {
        let value = scenario.get(section)?.get(key)?;
        value.as_str().map(str::to_owned)
    };
    let by_contact = text("guidance", "kinematics").as_deref() == Some("contact");
    if let (Some(ideal), Some(contact), true, false) = (
        summary.twist_ideal_mean,
        summary.twist_contact_mean,
        header.open_loop,
        by_contact,
    ) {
        let ratio = summary.twist_ratio_ideal;
        let missing = [
            (ratio.vx, ideal.vx_m_s, contact.vx_m_s, "ahead"),
            (ratio.vy, ideal.vy_m_s, contact.vy_m_s, "sideways"),
            (
                ratio.omega,
                ideal.omega_rad_s,
                contact.omega_rad_s,
                "in turning",
            ),
        ]
        .into_iter()
        .filter_map(|(driven, ideal, contact, way)| {
            driven.map(|_| ((ideal - contact) / ideal, way))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((gain, way)) = missing.filter(|(gain, _)| *gain > 0.003) {
            tries.push(format!(
                "Command by the contact kinematics, <code>guidance.kinematics = \"contact\"</code>: <b>{} more {way}</b>, which is \
                 what the rollers' geometry takes.",
                percent(gain)
            ));
        }
    }
    if let (Some(ideal_m), Some(contact_m)) = (
        summary.odometry_ideal.m_per_m,
        summary.odometry_contact.m_per_m,
    ) && ideal_m > 1e-3
        && contact_m < 0.5 * ideal_m
    {
        tries.push(format!(
            "Reckon with the rollers that touch (<code>ilon_control::Odometry</code>): drift falls from {} to <b>{}</b> for each metre.",
            length(ideal_m),
            length(contact_m)
        ));
    }
    let at_start: f64 = events
        .iter()
        .filter(|e| matches!(e.kind, EventKind::Slide(_)) && e.from_s < 0.2)
        .map(|e| e.lost_j)
        .sum();
    if let Some(slip_j) = summary
        .energy
        .slip_j
        .filter(|&j| j > 0.05 && at_start > 0.3 * j)
    {
        let how = if header.open_loop {
            "raise <code>twist.ramp_s</code>"
        } else {
            "begin nearer to the reference, or weigh torques by grip"
        };
        tries.push(format!(
            "Start more gently ({how}): {} of the {} that sliding cost were lost in the first moments, <b>{}</b>.",
            energy(at_start.min(slip_j)),
            energy(slip_j),
            percent((at_start / slip_j).min(1.0))
        ));
    }
    if let (Some(share), Some(limit)) = (summary.saturated_share, header.wheel_rate_limit_rad_s)
        && share > 0.2
    {
        tries.push(format!(
            "Raise <code>guidance.wheel_rate_limit_rad_s</code> ({limit:.3} rad/s) or slow the reference: tasks waited for <b>{}</b> of the run.",
            percent(share)
        ));
    }
    if let Some(floor) = events
        .iter()
        .find(|e| e.kind == EventKind::Fault && e.text.contains("slippery"))
    {
        tries.push(format!(
            "Slow down where the floor is slippery, or weigh torques by grip (compare <code>mecanum4_slippery_by_grip</code> with \
             <code>mecanum4_slippery_plain</code>): what was lost was lost {}.",
            floor.when()
        ));
    }
    tries.truncate(4);
    tries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_lose_their_marks_and_keep_their_words() {
        assert_eq!(
            plain("a <b>1 mm</b> &lt;x&gt; &amp;amp;"),
            "a 1 mm <x> &amp;"
        );
    }

    #[test]
    fn a_run_that_begins_at_its_reference_is_judged_from_the_start() {
        let errors = [(0.0, 0.0), (1.0, 0.3), (2.0, 0.01)];
        let start = Start::of(&errors, &Settings::default());
        assert!(!start.is_off && start.settled_s == 0.0);
        let errors = [(0.0, 1.5), (1.0, 0.5), (2.0, 0.01), (3.0, 0.2)];
        let start = Start::of(&errors, &Settings::default());
        assert!(start.is_off);
        assert_eq!(start.settled_s, 2.0);
    }
}
