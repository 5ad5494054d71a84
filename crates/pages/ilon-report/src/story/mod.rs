//! The run in a few sentences: posture, events and their consequences; the largest error with its
//! time and cause; then costs and remedies.

mod budget;
mod costs;
mod effects;
mod events;
mod measured;
mod phrases;
mod posture;
mod shortfall;
mod slope;
mod spells;
mod touches;

use ilon_trace::{Change, Guidance, Header, Settings, Summary, Twin};

pub(crate) use budget::{Budget, Integrator, OffCourse, PARTS, Standing};
use events::SLIDING_SHARE;
pub(crate) use events::{Event, EventKind, Watch};
pub(crate) use measured::{Measured, apart};

use crate::accumulate::OfRobot;
use crate::input::RunInput;
use crate::page::{escape, with_code};
use crate::text::{angle, angle_known, by_kind, capital, length, length_to, time};
pub(crate) use posture::Stance;

/// Number of sentences at which further costs are omitted.
const MOST_LINES: usize = 5;
/// Largest number of sentences on postures, and on faults.
const MOST_OF_A_KIND: usize = 4;

/// Smaller position errors are not reported, in metres.
pub(crate) const UNREMARKABLE_M: f64 = 1e-3;

/// The report's statements about a run.
pub(crate) struct Story {
    /// Sentences as HTML, the most important first.
    pub lines: Vec<String>,
    /// Proposals with their gains, as HTML.
    pub tries: Vec<String>,
    /// The error budget at the worst instant.
    pub budget: Option<Budget>,
    /// All events.
    pub events: Vec<Event>,
}

impl Story {
    pub fn of(shown: &RunInput, summary: &Summary, settings: &Settings) -> Self {
        let header = &shown.trace.header;
        let watch = &shown.all.watch;
        let posture = &watch.posture;
        let events = shown.all.events(header);
        let errors: Vec<(f64, f64)> = shown.all.robot(OfRobot::PositionError).collect();
        let start = Start::of(&errors, settings);
        let budget = budget::at_the_worst(&shown.all.stood, start.settled_s);
        let budget = budget.filter(|b| b.error_m > UNREMARKABLE_M);

        // A fault that makes everything else meaningless comes first.
        let instability = header.guidance.as_ref();
        let instability = instability.and_then(|guidance| unstable(guidance, header.control_dt_s));
        let stood = posture.episodes();
        let sentences = stood.iter().map(|e| e.sentence(header, posture.end_s));
        let spoilt = posture.spoils(header.measure_from_s, header.measure_to_s);
        let mut lines: Vec<String> = instability.into_iter().collect();
        lines.extend(sentences.take(MOST_OF_A_KIND));
        lines.extend(shown.all.measured.sentence());
        lines.extend(watch.touches.sentence(header, summary.energy.put_in_j));
        lines.extend(watch.touches.falls(header));
        lines.extend(shortfall::at_rest(header, summary, &watch.means));

        let ends_at_m_s = shown.all.ends_at_m_s;
        let slope = slope::sentence(header, summary, &events, ends_at_m_s);
        let (slope_first, slope) = match slope {
            Some((line, true)) => (Some(line), None),
            Some((line, false)) => (None, Some(line)),
            None => (None, None),
        };
        lines.extend(slope_first);
        let known = |key: &str| ilon_trace::effects::floor(key, summary, header);
        let ended = known("position_error_final_m").zip(known("heading_error_final_rad"));
        lines.extend(tracking(summary, &start, ended));
        let slid = summary.friction_used_max >= Some(SLIDING_SHARE);
        lines.extend(budget.as_ref().map(|budget| {
            excursion(
                (budget, slid),
                &start,
                header,
                known("position_error_max_m"),
            )
        }));
        match header.twins.is_empty() {
            true => {
                let purpose = on_purpose(header, summary.duration_s);
                lines.extend(purpose.into_iter().chain(believed(header)));
            }
            false => lines.extend(effects::sentences(header, summary, posture)),
        }
        if header.open_loop {
            lines.extend(obstacles(&events));
        }
        let lies = |stance| matches!(stance, Stance::Fallen | Stance::Tipped);
        if !(spoilt && stood.iter().any(|episode| lies(episode.stance))) {
            let axes = shortfall::sentences(header, &watch.means, !spoilt);
            lines.extend(shortfall::veered(header, &watch.means));
            lines.extend(axes);
        }
        if !spoilt {
            let costs = [
                slope,
                costs::landings(summary, header),
                costs::off_the_ground(summary),
                costs::joints(header, summary),
                costs::slipping(summary, header, &events),
                costs::saturation(summary, header, &events),
                costs::reckoning(header, summary),
            ];
            let room = MOST_LINES.saturating_sub(lines.len());
            lines.extend(costs.into_iter().flatten().take(room));
        }
        if header.faults.is_none() {
            lines.push(
                "The trace does not say what went wrong on purpose: it is of an older version."
                    .to_owned(),
            );
        }
        let tries = match spoilt {
            true => Vec::new(),
            false => effects::tries(header, summary),
        };
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

/// Removes the markup from a sentence.
pub(crate) fn plain(html: &str) -> String {
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

/// Initial error of the run, and the end of its decay.
struct Start {
    error_m: f64,
    /// Whether it started away from its reference.
    is_off: bool,
    /// Whether it came within 1 % of its initial error.
    has_arrived: bool,
    /// Time after which an error is independent of the start, in seconds.
    settled_s: f64,
}

impl Start {
    fn of(errors: &[(f64, f64)], settings: &Settings) -> Self {
        let error_m = errors.first().map_or(0.0, |&(_, e)| e);
        let is_off = error_m > settings.position_threshold_m;
        let near = errors.iter().find(|&&(_, e)| e <= 0.01 * error_m);
        let settled_s = if is_off {
            let nearest = || errors.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            near.or_else(nearest).map_or(0.0, |&(t_s, _)| t_s)
        } else {
            0.0
        };
        Self {
            error_m,
            is_off,
            has_arrived: near.is_some(),
            settled_s,
        }
    }
}

/// Reports a guidance that is unstable at its control period.
fn unstable(guidance: &Guidance, period_s: f64) -> Option<String> {
    let (position, heading) = (guidance.position_gain_per_s, guidance.heading_gain_per_s);
    let products = [
        (
            "position",
            position * period_s,
            guidance.position_unstable_from,
        ),
        (
            "heading",
            heading * period_s,
            guidance.heading_unstable_from,
        ),
    ];
    let known = products
        .into_iter()
        .filter_map(|(name, product, from)| Some((name, product, from?)));
    let beyond = known.filter(|(_, product, from)| *product >= from * (1.0 - 1e-9));
    let words: Vec<String> = beyond
        .map(|(name, product, from)| {
            format!(
                "the {name} gain times the control period is <b>{product:.3}</b>, and from {from:.3} on an error grows instead of settling"
            )
        })
        .collect();
    (!words.is_empty()).then(|| format!("<b>The guidance is unstable</b>: {}.", words.join("; ")))
}

/// Reports the faults set by the scenario that began before the end, if the run was not repeated
/// without them.
fn on_purpose(header: &Header, end_s: f64) -> Option<String> {
    let name_of = |wheel: usize| header.wheels.get(wheel).map(|wheel| wheel.name.as_str());
    let faults = header.faults.iter().flatten();
    let faults = faults.filter(|fault| fault.from_s < end_s);
    let words: Vec<String> = faults
        .map(|fault| with_code(&fault.words(name_of)))
        .collect();
    let more = words.len().saturating_sub(MOST_OF_A_KIND);
    let mut told = words[..words.len() - more].to_vec();
    if more > 0 {
        told.push(format!("{more} more"));
    }
    (!told.is_empty()).then(|| format!("On purpose there was {}.", phrases::list(&told)))
}

/// Reports the controller's wrong parameters, if the run was not repeated without them.
fn believed(header: &Header) -> Option<String> {
    let belief = with_code(header.belief.as_ref()?);
    Some(format!(
        "The controller <b>took the robot for another</b>: {belief}."
    ))
}

/// Reports the largest error and its parts, of a run in which a wheel `slid`. Where runs without
/// the causes were made, these say what each did, and no parts are named.
fn excursion(
    (budget, slid): (&Budget, bool),
    start: &Start,
    header: &Header,
    floor_m: Option<f64>,
) -> String {
    let length = |x_m: f64| length_to(x_m, floor_m);
    let is_told = |twin: &Twin| matches!(twin.change, Change::Without(_));
    let parts = match header.twins.iter().any(is_told) {
        true => String::new(),
        false => shares((budget, slid), header, &length),
    };
    let after = match (start.settled_s > 0.0, start.has_arrived) {
        (false, _) => "",
        (true, true) => " after it had arrived",
        (true, false) => " after it came nearest",
    };
    format!(
        "The largest position error{after} was <b>{}</b> at <b>{}</b>.{}",
        length(budget.error_m),
        time(budget.at_s),
        parts
    )
}

/// Returns the two largest parts of the error on either side. They are terms of a sum, not the
/// effects of causes: the run without a cause differs in other terms too. Under a passive law,
/// which pulls the robot like a spring and commands no wheel rates, the forces that stretch the
/// spring cause the error.
fn shares(
    (budget, slid): (&Budget, bool),
    header: &Header,
    length: &dyn Fn(f64) -> String,
) -> String {
    let mut grew: Vec<(&str, f64)> = PARTS.into_iter().zip(budget.parts_m).collect();
    grew.sort_by(|a, b| b.1.total_cmp(&a.1));
    let least_m = 0.15 * budget.error_m;
    let term = |(name, m): &(&str, f64)| {
        let sign = if *m < 0.0 { "−" } else { "+" };
        format!(
            "{} {sign}{}",
            in_words(name, (budget, slid), header),
            length(m.abs())
        )
    };
    let to_it = grew.iter().filter(|(_, m)| *m > least_m).take(2);
    let from_it = grew.iter().rev().filter(|(_, m)| *m < -least_m).take(2);
    let terms: Vec<String> = to_it.chain(from_it).map(term).collect();
    if terms.is_empty() {
        return String::new();
    }
    format!(
        " Its largest terms from {} on: {}.",
        time(budget.from_s),
        terms.join(", ")
    )
}

/// Returns a part of the budget as text.
fn in_words<'a>(part: &'a str, (budget, slid): (&Budget, bool), header: &Header) -> &'a str {
    /// Wheels count as ahead of their targets, or behind them, for this share of the servo term.
    const CLEARLY: f64 = 0.5;
    let servo_m = budget.parts_m[4];
    match part {
        "correction by guidance" if header.storage => {
            "forces against the spring of the passive law"
        }
        "correction by guidance" => "the guidance's corrections",
        "slip" if slid => "sliding contacts",
        "slip" => "creeping contacts",
        "geometry" => by_kind(header, "the tyres' width", "the rollers' geometry"),
        "lift-off" => "wheels in the air, or with little load",
        "conflict" => "wheels that contradict each other",
        "servo" if budget.ahead_m > CLEARLY * servo_m.abs() => {
            "wheels that run ahead of their targets"
        }
        "servo" if budget.ahead_m < -CLEARLY * servo_m.abs() => "wheels that lag their targets",
        "servo" => "wheels that are off their targets",
        "compensation" => shortfall::compensation(header),
        "belief" => header.belief_in_words(),
        "incline" => "the incline, whose way is longer than on a map",
        other => other,
    }
}

/// Reports the tracking accuracy.
/// `floors`: how far the errors at the end are known, in metres and radians.
fn tracking(summary: &Summary, start: &Start, floors: Option<(f64, f64)>) -> Option<String> {
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
    let from = |t_s: f64| match t_s {
        0.0 => "throughout".to_owned(),
        t_s => format!("from {} on", time(t_s)),
    };
    let converged = match (summary.position_converged_s, summary.heading_converged_s) {
        (Some(0.0), Some(0.0)) => String::new(),
        (Some(p), Some(h)) => format!(
            " The position stayed within 5 cm {}, the heading within 3° {}.",
            from(p),
            from(h)
        ),
        (Some(p), None) => format!(
            " The position stayed within 5 cm {}; the heading did not converge.",
            from(p)
        ),
        (None, Some(h)) => format!(
            " The heading stayed within 3° {}; the position did not converge.",
            from(h)
        ),
        (None, None) => " Neither position nor heading converged.".to_owned(),
    };
    Some(format!(
        "{began} <b>{}</b> and <b>{}</b> off.{converged}",
        length_to(position_m, floors.map(|(floor_m, _)| floor_m)),
        floors.map_or_else(
            || angle(heading_rad),
            |(_, floor_rad)| angle_known(heading_rad, floor_rad)
        )
    ))
}

/// Reports the obstacles of an open-loop run.
fn obstacles(events: &[Event]) -> Option<String> {
    // Of the same kind at several times, all in one.
    let mut kinds: Vec<(&str, String)> = Vec::new();
    let crossed = || events.iter().filter(|e| e.kind == EventKind::Ground);
    for event in crossed().take(MOST_OF_A_KIND) {
        match kinds.iter_mut().find(|(text, _)| *text == event.text) {
            Some((_, times)) => *times += &format!(" and {}", event.when()),
            None => kinds.push((&event.text, event.when())),
        }
    }
    let kinds = kinds.iter();
    let outside: Vec<String> = kinds
        .map(|(text, times)| format!("{times} {}", escape(text)))
        .collect();
    let more = match crossed().count().saturating_sub(MOST_OF_A_KIND) {
        0 => String::new(),
        more => format!("; {more} more"),
    };
    (!outside.is_empty()).then(|| format!("{}{more}.", capital(&outside.join("; "))))
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
    fn what_is_not_told_of_what_went_wrong_is_counted() {
        let said = |count: u32, end_s: f64| {
            let fault = |index: u32| ilon_trace::Fault {
                from_s: f64::from(index),
                until_s: None,
                kind: ilon_trace::FaultKind::PoseLost,
            };
            let header = ilon_trace::Header {
                faults: Some((0..count).map(fault).collect()),
                ..ilon_trace::Header::default()
            };
            on_purpose(&header, end_s)
        };
        assert_eq!(said(0, 9.0), None);
        // A fault that would begin when the run is over.
        assert_eq!(said(1, 0.0), None);
        for (count, sensors, end) in [(1, 1, "sensor."), (4, 4, "on."), (7, 4, "and 3 more.")] {
            let said = said(count, 9.0).unwrap_or_default();
            assert_eq!(said.matches("lost pose sensor").count(), sensors, "{said}");
            assert!(said.ends_with(end), "{said}");
        }
    }

    /// A robot that is too weak: the guidance asked for 13 m back, and got none of it.
    #[test]
    fn what_the_guidance_asked_for_is_not_what_it_did() {
        let mut parts_m = [0.0; PARTS.len()];
        [parts_m[0], parts_m[1]] = [-13.0, 16.0];
        let budget = Budget {
            from_s: 0.0,
            at_s: 8.0,
            error_m: 3.0,
            before_m: 0.0,
            parts_m,
            ahead_m: 0.0,
            rest_m: 0.0,
        };
        let start = Start::of(&[(0.0, 0.5), (8.0, 3.0)], &Settings::default());
        let said = plain(&excursion(
            (&budget, true),
            &start,
            &Header::default(),
            None,
        ));
        assert_eq!(
            said,
            "The largest position error was 3.000 m at 8.00 s. Its largest terms from 0.00 s on: saturation +16.000 m, the guidance's corrections −13.000 m."
        );
    }

    /// Of 20 mm that contacts slid, or crept where none lost its grip, lagging wheels took 12 mm
    /// back: 8 mm are left. Terms of a sum are no effects of causes: if the run was repeated
    /// without some, these are told instead.
    #[test]
    fn terms_of_either_sign_are_told_unless_causes_are() {
        let mut parts_m = [0.0; PARTS.len()];
        let slip = PARTS
            .iter()
            .position(|part| *part == "slip")
            .expect("a part");
        (parts_m[slip], parts_m[4]) = (0.02, -0.012);
        let budget = Budget {
            from_s: 0.0,
            at_s: 5.0,
            error_m: 0.008,
            before_m: 0.0,
            parts_m,
            ahead_m: -0.012,
            rest_m: 0.0,
        };
        let length = |x_m: f64| length_to(x_m, None);
        for (slid, contacts) in [(true, "sliding contacts"), (false, "creeping contacts")] {
            assert_eq!(
                plain(&shares((&budget, slid), &Header::default(), &length)),
                format!(
                    " Its largest terms from 0.00 s on: {contacts} +20.00 mm, wheels that lag their targets −12.00 mm."
                )
            );
        }
        let start = Start::of(&[(0.0, 0.0)], &Settings::default());
        let mut header = Header::default();
        header.twins.push(Twin {
            change: Change::Without(Default::default()),
            figures: Default::default(),
            apart: None,
            poses: Vec::new(),
            error: None,
        });
        let said = plain(&excursion((&budget, true), &start, &header, None));
        assert_eq!(said, "The largest position error was 8.00 mm at 5.00 s.");
    }

    #[test]
    fn a_run_that_begins_at_its_reference_is_judged_from_the_start() {
        let errors = [(0.0, 0.0), (1.0, 0.3), (2.0, 0.01)];
        let start = Start::of(&errors, &Settings::default());
        assert!(!start.is_off && start.settled_s == 0.0);
        let errors = [(0.0, 1.5), (1.0, 0.5), (2.0, 0.01), (3.0, 0.2)];
        let start = Start::of(&errors, &Settings::default());
        assert!(start.is_off && start.has_arrived);
        assert_eq!(start.settled_s, 2.0);
        // It comes no nearer than half way.
        let start = Start::of(&[(0.0, 1.5), (1.0, 0.7), (2.0, 0.9)], &Settings::default());
        assert!(!start.has_arrived);
        assert_eq!(start.settled_s, 1.0);
    }
}
