//! Sentences on the effect of each cause and of remedies, from runs repeated without the cause or
//! with the remedy.

use ilon_trace::effects::{self, Ablation, Effect, FLOORS};
use ilon_trace::{Change, Header, Summary, quantities};

use super::phrases::list;
use super::posture::{Posture, Stance, TIPPED_RAD};
use crate::page::escape;
use crate::text::{angle_known, capital, energy, length_known, percent, time};

/// Number of causes with their own sentence.
const MOST_TOLD: usize = 4;
/// Joint effects of causes are reported from this share of their effects.
const TOLD_TOGETHER: f64 = 0.2;
/// A passing deviation is reported in addition to the final one if it is this many times as large.
const PASSING: f64 = 2.0;
/// If a run's accuracy is worse than this, in metres, smaller effects are not reported.
const ROUGHLY_KNOWN_M: f64 = 5e-3;
/// A largest error is reported if it differs by this share. A remedy is reported if it improves a figure by it, and worsens none by as much.
const WORTH_TELLING: f64 = 0.05;

/// Reports the effect of each cause, the largest first; nothing for a run that was not repeated.
pub(super) fn sentences(header: &Header, summary: &Summary, posture: &Posture) -> Vec<String> {
    let ablations = effects::of_causes(summary, header);
    let mut singles: Vec<&Ablation> = ablations.iter().filter(|one| one.cause.is_some()).collect();
    // What helped is no culprit, and comes last.
    singles.sort_by(|a, b| {
        let helped = a.helped().cmp(&b.helped());
        helped.then(b.apart.most_m.total_cmp(&a.apart.most_m))
    });
    let (told, idle): (Vec<&Ablation>, Vec<&Ablation>) = singles
        .iter()
        .partition(|one| one.moves() || one.differs() && one.floor[0] < ROUGHLY_KNOWN_M);
    let mut lines: Vec<String> = told
        .iter()
        .take(MOST_TOLD)
        .enumerate()
        .map(|(index, one)| of_cause(one, posture, index == 0))
        .collect();
    lines.extend(told.get(MOST_TOLD..).and_then(untold));
    lines.extend(together(&ablations));
    lines.extend(no_difference(&idle, header));
    let failed = header.twins.iter().filter_map(|twin| match &twin.change {
        Change::Without(cause) => Some((cause, twin.error.as_ref()?)),
        _ => None,
    });
    lines.extend(failed.map(|(cause, error)| {
        format!(
            "What {} did is not known: without it the run is refused ({}).",
            escape(&cause.words),
            escape(error)
        )
    }));
    lines
}

/// Counts the causes without a sentence of their own.
fn untold(rest: &[&Ablation]) -> Option<String> {
    let helped = rest.iter().filter(|one| one.helped()).count();
    let counts = [
        (rest.len() - helped, "made less difference"),
        (helped, "helped"),
    ];
    let counts = counts.iter().filter(|(count, _)| *count > 0);
    let counts: Vec<String> = counts
        .map(|(count, did)| format!("{count} more {did}"))
        .collect();
    (!counts.is_empty()).then(|| format!("{}.", counts.join("; ")))
}

/// Returns the name of a cause.
fn words(one: &Ablation) -> String {
    escape(one.cause.map_or("all of them", |cause| &cause.words))
}

fn of_cause(one: &Ablation, posture: &Posture, is_first: bool) -> String {
    let cause = words(one);
    let stood = posture.episodes();
    let was = |stance| stood.iter().any(|episode| episode.stance == stance);
    if was(Stance::Tipped) && one.apart.twin_leaned_rad < TIPPED_RAD {
        return format!("Without {cause} the robot <b>would not have tipped over</b>.");
    }
    let flown = one.get("airborne_share").filter(|flown| flown.differs);
    if was(Stance::InTheAir) && flown.is_some_and(|flown| flown.without == Some(0.0)) {
        return format!("Without {cause} the robot <b>would not have left the ground</b>.");
    }
    let error = one
        .get("position_error_max_m")
        .filter(|error| error.differs && relative(error) > WORTH_TELLING);
    if let Some((error, without_m)) = error.and_then(|error| Some((error, error.without?))) {
        let told = match without_m > FLOORS * error.floor {
            true => format!("<b>{}</b>", length_known(without_m, error.floor)),
            false => format!("less than <b>{}</b>", least(error.floor)),
        };
        return match one.helped() {
            true => format!(
                "{} <b>helped</b>: without {} the largest position error would have been {told}.",
                capital(&cause),
                it(&cause)
            ),
            false => format!("Without {cause} the largest position error would have been {told}."),
        };
    }
    if one.moves() {
        return of_way(one, &cause, is_first);
    }
    let costs = one
        .effects
        .iter()
        .filter(|it| it.differs && is_cost(&it.key));
    let largest = costs.max_by(|a, b| relative(a).total_cmp(&relative(b)));
    match largest.and_then(in_words) {
        Some(figure) => format!(
            "{} moved the robot by less than {}; {figure}.",
            capital(&cause),
            least(one.floor[0])
        ),
        None => format!(
            "{} moved the robot by less than {}.",
            capital(&cause),
            least(one.floor[0])
        ),
    }
}

/// Whether a figure is a cost of the run, and not part of its path.
fn is_cost(key: &str) -> bool {
    ["", "J", "N m"].contains(&quantities::si_unit(key))
}

/// Returns the smallest distinguishable effect, in metres, as text.
fn least(floor_m: f64) -> String {
    length_known(FLOORS * floor_m, floor_m)
}

/// Reports the displacement by a cause; the first such sentence names the comparison.
fn of_way(one: &Ablation, cause: &str, is_first: bool) -> String {
    let [floor_m, floor_rad] = one.floor;
    let apart = &one.apart;
    let side = |x: f64, plus: &'static str, minus: &'static str| if x < 0.0 { minus } else { plus };
    let ways = [
        (apart.ahead_m, side(apart.ahead_m, "ahead", "back")),
        (
            apart.left_m,
            side(apart.left_m, "to the left", "to the right"),
        ),
    ];
    let ways = ways
        .iter()
        .filter(|(off_m, _)| off_m.abs() > FLOORS * floor_m);
    let ways: Vec<String> = ways
        .map(|(off_m, way)| format!("<b>{} {way}</b>", length_known(off_m.abs(), floor_m)))
        .collect();
    let turned = apart.turned_rad;
    let turned = (turned.abs() > FLOORS * floor_rad).then(|| {
        let way = side(turned, "left", "right");
        let by = angle_known(turned.abs(), floor_rad);
        format!("turned it to the {way} by <b>{by}</b>")
    });
    let put = (!ways.is_empty()).then(|| format!("put the robot {}", list(&ways)));
    let did: Vec<String> = [put, turned].into_iter().flatten().collect();
    let end_m = apart.ahead_m.hypot(apart.left_m);
    let is_far = apart.most_m > FLOORS * floor_m;
    let passing = match is_far && (did.is_empty() || apart.most_m > PASSING * end_m) {
        true => Some(format!(
            "moved the robot by up to <b>{}</b> at {}",
            length_known(apart.most_m, floor_m),
            time(apart.most_at_s)
        )),
        false if did.is_empty() => Some(format!(
            "turned the robot by up to <b>{}</b> at {}",
            angle_known(apart.most_rad, floor_rad),
            time(apart.most_rad_at_s)
        )),
        false => None,
    };
    let (joined, ended) = match did.is_empty() {
        true => ("; ", "no effect is left at the end".to_owned()),
        false => (", and ", format!("{} at the end", list(&did))),
    };
    let what = [passing, Some(ended)].into_iter().flatten();
    let against = match is_first {
        true => format!(", compared with the same run without {}", it(cause)),
        false => String::new(),
    };
    let helped = match (one.helped(), is_plural(cause)) {
        (false, _) => "",
        (true, false) => "<b>helped</b>: it ",
        (true, true) => "<b>helped</b>: they ",
    };
    format!(
        "{} {helped}{}{against}.",
        capital(cause),
        what.collect::<Vec<_>>().join(joined)
    )
}

/// The pronoun of a cause.
fn it(cause: &str) -> &'static str {
    if is_plural(cause) { "them" } else { "it" }
}

/// Whether a cause's name is plural: "the 10 boxes", "the ramps", "the losses of its gears".
fn is_plural(cause: &str) -> bool {
    let mut words = cause
        .split(' ')
        .skip_while(|word| ["the", "The"].contains(word));
    let first = words.next().unwrap_or_default();
    first.parse::<u32>().is_ok() || (first.ends_with('s') && !first.ends_with("ss"))
}

/// Reports the joint effects of causes.
fn together(ablations: &[Ablation]) -> Option<String> {
    let all = ablations.iter().find(|one| one.cause.is_none())?;
    let singles = || ablations.iter().filter(|one| one.cause.is_some());
    let of = |key: &str| {
        let sum: f64 = singles()
            .filter_map(|one| Some(one.get(key)?.difference))
            .sum();
        let floor: f64 = singles().filter_map(|one| Some(one.get(key)?.floor)).sum();
        let whole = all.get(key)?;
        Some((
            whole.difference,
            whole.difference - sum,
            floor + whole.floor,
        ))
    };
    let ((x_m, over_x_m, floor_x_m), (y_m, over_y_m, floor_y_m)) = (of("end_x_m")?, of("end_y_m")?);
    let (whole_m, over_m) = (x_m.hypot(y_m), over_x_m.hypot(over_y_m));
    let floor_m = floor_x_m.max(floor_y_m);
    (over_m > FLOORS * floor_m && over_m > TOLD_TOGETHER * whole_m).then(|| {
        format!(
            "All of them together moved its end by <b>{}</b>. They act on each other: the sum of their single effects differs from that by <b>{}</b>.",
            length_known(whole_m, floor_m),
            length_known(over_m, floor_m)
        )
    })
}

/// Reports the causes without effect in one sentence.
fn no_difference(idle: &[&Ablation], header: &Header) -> Option<String> {
    let names: Vec<String> = idle.iter().map(|one| words(one)).collect();
    let floor_m = idle.iter().map(|one| one.floor[0]).fold(0.0, f64::max);
    (!names.is_empty()).then(|| {
        let names = list(&names);
        match floor_m > ROUGHLY_KNOWN_M {
            false => format!(
                "{} <b>made no difference</b>: less than {}.",
                capital(&names),
                least(floor_m)
            ),
            true => format!(
                "What {names} did to the way cannot be told: {} the run itself goes up to <b>{}</b> elsewhere.",
                with_what(header, floor_m),
                length_known(floor_m, floor_m)
            ),
        }
    })
}

/// Returns the change of the run that determined its accuracy, in metres.
fn with_what(header: &Header, floor_m: f64) -> &'static str {
    let mut twins = header.twins.iter();
    let half = twins.find(|twin| twin.change == Change::HalfStep);
    let moved_m = half.and_then(|twin| Some(twin.apart?.most_m));
    match moved_m.is_some_and(|moved_m| moved_m >= floor_m) {
        true => "at half the step",
        false => "with other noise",
    }
}

/// Returns the relative difference of a figure, over its larger value.
fn relative(effect: &Effect) -> f64 {
    let size = |value: Option<f64>| value.map_or(0.0, f64::abs);
    effect.difference.abs()
        / size(effect.with)
            .max(size(effect.without))
            .max(f64::MIN_POSITIVE)
}

/// Returns a figure with and without a cause.
fn in_words(effect: &Effect) -> Option<String> {
    let quantity = quantities::by_key(&effect.key)?;
    let shown = |value: Option<f64>| {
        value.map_or("none".to_owned(), |value| {
            format!("{:.*}", quantity.decimals, value * quantity.unit.per_si)
        })
    };
    Some(format!(
        "{}: <b>{}</b> instead of {} {}",
        quantity.words(),
        shown(effect.with),
        shown(effect.without),
        quantity.unit.symbol
    ))
}

/// Returns proposals as HTML: each remedy was simulated, and is reported with its gain.
pub(super) fn tries(header: &Header, summary: &Summary) -> Vec<String> {
    let tried = effects::of_remedies(summary, header);
    let mut gained: Vec<(f64, String)> =
        tried.iter().filter_map(|one| gain(one, summary)).collect();
    gained.sort_by(|a, b| b.0.total_cmp(&a.0));
    gained.into_iter().map(|(_, line)| line).collect()
}

/// Returns the gain of a remedy as text, and the relative improvement of the most important figure;
/// `None` if not worth reporting.
fn gain(one: &Ablation, summary: &Summary) -> Option<(f64, String)> {
    let remedy = one.cause?;
    let (mut best, mut spoilt) = (None, None);
    for (share, text) in measures(one, summary) {
        if share > WORTH_TELLING {
            best = best.or(Some((share, text)));
        } else if share < -WORTH_TELLING {
            spoilt = spoilt.or(Some(text));
        }
    }
    let (share, gave) = best?;
    if spoilt.is_some() {
        return None;
    }
    let line = format!(
        "{}, <code>{}</code>: tried, {gave}.",
        capital(&escape(&remedy.words)),
        escape(&remedy.key)
    );
    Some((share, line))
}

/// Returns the relative improvement of each relevant figure, the most important first, with its
/// text.
fn measures(one: &Ablation, summary: &Summary) -> Vec<(f64, String)> {
    let mut measures = Vec::new();
    let fallen = |from: f64, to: f64| (from - to) / from.abs().max(f64::MIN_POSITIVE);
    if summary.position_error_final_m.is_none()
        && let (Some(asked), Some(real)) = (summary.twist_asked_mean, summary.twist_mean)
    {
        let axes = [
            ("vx_m_s", asked.vx_m_s, real.vx_m_s),
            ("vy_m_s", asked.vy_m_s, real.vy_m_s),
            ("omega_rad_s", asked.omega_rad_s, real.omega_rad_s),
        ];
        for (axis, asked, real) in axes {
            let effect = one.get(&format!("twist_mean.{axis}"));
            let Some(tried) = effect.filter(|it| it.differs).and_then(|it| it.without) else {
                continue;
            };
            if asked.abs() > 1e-3 {
                let text = format!(
                    "the robot reached <b>{}</b> of the command instead of {}",
                    percent(tried / asked),
                    percent(real / asked)
                );
                measures.push((fallen((asked - real).abs(), (asked - tried).abs()), text));
            }
        }
    }
    for (key, name) in [
        ("position_error_rms_m", "the position error was"),
        ("position_error_max_m", "the largest position error was"),
    ] {
        if let Some(effect) = one.get(key).filter(|it| it.differs)
            && let (Some(from_m), Some(to_m)) = (effect.with, effect.without)
        {
            let text = format!(
                "{name} <b>{}</b> instead of {}",
                length_known(to_m, effect.floor),
                length_known(from_m, effect.floor)
            );
            measures.push((fallen(from_m, to_m), text));
        }
    }
    if let Some(effect) = one.get("slip_energy_j").filter(|it| it.differs)
        && let (Some(from_j), Some(to_j)) = (effect.with, effect.without)
    {
        let text = format!(
            "sliding cost <b>{}</b> instead of {}",
            energy(to_j),
            energy(from_j)
        );
        measures.push((fallen(from_j, to_j), text));
    }
    measures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::made_up_run;
    use ilon_trace::{Apart, Cause, Settings, Twin};

    /// The sentences of a run that was repeated without causes: of each how many times as large its error was without it.
    fn said(open_loop: bool, errors: &[f64]) -> Vec<String> {
        let mut trace = made_up_run(2.0, open_loop);
        let summary = Summary::of(&trace, &Settings::default());
        let key = match open_loop {
            true => "ledger.total.path_m",
            false => "position_error_max_m",
        };
        let twin = |(index, times): (usize, &f64)| {
            let most_m = 0.5 - 0.05 * index as f64;
            let apart = Apart {
                most_m,
                ahead_m: most_m,
                ..Apart::default()
            };
            let cause = Cause {
                key: format!("faults.{index}"),
                words: format!("the push {index}"),
            };
            let came = Ok((summary.clone(), Some(apart)));
            let mut twin = Twin::new(Change::Without(cause), came);
            *twin.figures.get_mut(key).expect("a figure") *= times;
            twin
        };
        trace.header.twins = errors.iter().enumerate().map(twin).collect();
        let summary = Summary::of(&trace, &Settings::default());
        sentences(&trace.header, &summary, &Posture::default())
    }

    #[test]
    fn what_helped_is_counted_apart_from_what_made_less_difference() {
        for (errors, count) in [
            (
                &[0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 2.0][..],
                "2 more made less difference; 1 more helped.",
            ),
            (&[0.5, 2.0, 0.5, 0.5, 0.5], "1 more helped."),
            (&[0.5, 0.5, 0.5, 0.5, 0.5], "1 more made less difference."),
        ] {
            for open_loop in [false, true] {
                let lines = said(open_loop, errors);
                assert!(lines.iter().any(|line| line == count), "{lines:?}");
            }
        }
    }

    #[test]
    fn what_helped_in_open_loop_is_said_to_have() {
        let lines = said(true, &[2.0, 0.5]);
        assert!(lines[0].starts_with("The push 1 put"), "{lines:?}");
        assert!(
            lines[1].starts_with("The push 0 <b>helped</b>: it put"),
            "{lines:?}"
        );
    }
}
