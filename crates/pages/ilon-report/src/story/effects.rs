//! Sentences on the effect of each cause and of remedies, from runs repeated without the cause or
//! with the remedy.

use ilon_trace::effects::{self, Ablation, Effect, FLOORS};
use ilon_trace::{Change, Header, Summary, quantities};

use super::phrases::list;
use super::posture::{Posture, Stance, TIPPED_RAD};
use crate::page::escape;
use crate::text::{angle_known, borne, capital, decimals, energy_to, length_known, percent, time};

/// Number of causes with their own sentence.
const MOST_TOLD: usize = 4;
/// Joint effects of causes are reported from this share of their effects.
const TOLD_TOGETHER: f64 = 0.2;
/// A passing deviation is reported in addition to the final one if it is this many times as large.
const PASSING: f64 = 2.0;
/// If a run's accuracy is worse than this, in metres, smaller effects are not reported.
const ROUGHLY_KNOWN_M: f64 = 5e-3;
/// A largest error is reported if it differs by this share. A remedy is reported if it improves a
/// figure by it, and worsens none by as much.
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
    let (told, idle): (Vec<&Ablation>, Vec<&Ablation>) = singles.iter().partition(|one| {
        one.moves()
            || ends_elsewhere(one)
            || figure(one).is_some()
            || one.differs() && one.floor[0] < ROUGHLY_KNOWN_M
    });
    let mut lines: Vec<String> = told
        .iter()
        .take(MOST_TOLD)
        .enumerate()
        .map(|(index, one)| of_cause(one, posture, index == 0))
        .collect();
    lines.extend(told.get(MOST_TOLD..).and_then(untold));
    lines.extend(together(&ablations));
    lines.extend(no_difference(&idle));
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
        .map(|(count, did)| {
            let plural = if *count > 1 { "s" } else { "" };
            format!("{count} more cause{plural} {did}")
        })
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
    if one.moves() || ends_elsewhere(one) {
        return of_way(one, &cause, is_first);
    }
    format!(
        "{} moved the robot by less than {}{}.",
        capital(&cause),
        least(one.floor[0]),
        figure(one).map_or_else(String::new, |figure| format!("; {figure}"))
    )
}

/// Whether the end of the run, which may be known better than its way, differs significantly.
fn ends_elsewhere(one: &Ablation) -> bool {
    let [floor_m, floor_rad] = one.end_floor.map(|floor| FLOORS * floor);
    let apart = &one.apart;
    let moved_m = apart.ahead_m.abs().max(apart.left_m.abs());
    moved_m > floor_m || apart.turned_rad.abs() > floor_rad
}

/// Returns the figure that a cause changed most, as text: of the costs, else of what the robot saw.
fn figure(one: &Ablation) -> Option<String> {
    let largest = |is: fn(&str) -> bool| {
        let changed = one.effects.iter().filter(|it| it.differs && is(&it.key));
        changed.max_by(|a, b| relative(a).total_cmp(&relative(b)))
    };
    let is_seen = |key: &str| key.starts_with("seen_") || key.starts_with("odometry_");
    largest(is_cost).or(largest(is_seen)).and_then(in_words)
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
    let [end_floor_m, end_floor_rad] = one.end_floor;
    let apart = &one.apart;
    let side = |x: f64, plus: &'static str, minus: &'static str| if x < 0.0 { minus } else { plus };
    let ways = [
        (apart.ahead_m, ["ahead", "back"]),
        (apart.left_m, ["to the left", "to the right"]),
    ];
    let ways: Vec<String> = ways
        .into_iter()
        .filter(|(off_m, _)| off_m.abs() > FLOORS * end_floor_m)
        .map(|(off_m, [plus, minus])| {
            let by = length_known(off_m.abs(), end_floor_m);
            format!("<b>{by} {}</b>", side(off_m, plus, minus))
        })
        .collect();
    let turned_rad = apart.turned_rad;
    let turned = (turned_rad.abs() > FLOORS * end_floor_rad).then(|| {
        let way = side(turned_rad, "left", "right");
        let by = angle_known(turned_rad.abs(), end_floor_rad);
        format!("turned it to the {way} by <b>{by}</b>")
    });
    let put = (!ways.is_empty()).then(|| format!("put the robot {}", list(&ways)));
    let did: Vec<String> = [put, turned].into_iter().flatten().collect();
    let end_m = apart.ahead_m.hypot(apart.left_m);
    let is_far = apart.most_m > FLOORS * floor_m;
    let is_turned = apart.most_rad > FLOORS * floor_rad;
    let passing = if is_far && (did.is_empty() || apart.most_m > PASSING * end_m) {
        let by = length_known(apart.most_m, floor_m);
        Some(("moved", by, apart.most_at_s))
    } else if is_turned && (did.is_empty() || apart.most_rad > PASSING * turned_rad.abs()) {
        let by = angle_known(apart.most_rad, floor_rad);
        Some(("turned", by, apart.most_rad_at_s))
    } else {
        None
    };
    let passing = passing
        .map(|(did, by, at_s)| format!("{did} the robot by up to <b>{by}</b> at {}", time(at_s)));
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
            "All these causes together moved the robot's end by <b>{}</b>. They act on each other: the sum of their single effects differs from that by <b>{}</b>.",
            length_known(whole_m, floor_m),
            length_known(over_m, floor_m)
        )
    })
}

/// Reports the causes without effect, in a sentence each for those that certainly did nothing and
/// for those of which that is unknown, because the way is too uncertain.
fn no_difference(idle: &[&Ablation]) -> Vec<String> {
    let is_open = |one: &&Ablation| known_to_m(one) > ROUGHLY_KNOWN_M;
    let (open, none): (Vec<_>, Vec<_>) = idle.iter().copied().partition(is_open);
    let sentences = [none, open].into_iter().filter_map(|of| of_idle(&of));
    sentences.collect()
}

/// How far the effect of a cause on the way is known, in metres: exactly, if without it the run is
/// bit by bit the same.
fn known_to_m(one: &Ablation) -> f64 {
    let is_same = one.apart.most_m == 0.0 && one.apart.most_rad == 0.0;
    if is_same { 0.0 } else { one.floor[0] }
}

/// Reports causes that made no difference, or whose effect is unknown.
fn of_idle(idle: &[&Ablation]) -> Option<String> {
    let names: Vec<String> = idle.iter().map(|one| words(one)).collect();
    let floor_m = idle.iter().map(|one| known_to_m(one)).fold(0.0, f64::max);
    (!names.is_empty()).then(|| {
        let names = list(&names);
        match floor_m > ROUGHLY_KNOWN_M {
            false if floor_m == 0.0 => {
                format!("{} <b>made no difference</b> at all.", capital(&names))
            }
            false => format!(
                "{} <b>made no difference</b>: less than {}.",
                capital(&names),
                least(floor_m)
            ),
            true => format!(
                "The effect of {names} on the way is <b>unknown</b>: the way itself is uncertain by <b>{}</b>.",
                length_known(floor_m, floor_m)
            ),
        }
    })
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
            let [value, floor] = [value, effect.floor].map(|x| x * quantity.unit.per_si);
            decimals(value, borne(value, floor, quantity.decimals))
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
    let measured = measures(one, summary);
    if measured.iter().any(|(share, _)| *share < -WORTH_TELLING) {
        return None;
    }
    let (share, gave) = measured.into_iter().find(|it| it.0 > WORTH_TELLING)?;
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
    /// A figure as text, with the digits that its uncertainty justifies.
    type Known = fn(f64, f64) -> String;
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
                measures.push((nearer(asked - real, asked - tried), text));
            }
        }
    }
    let joules: Known = |x_j, floor_j| energy_to(x_j, Some(floor_j));
    let length: Known = length_known;
    let figures = [
        ("position_error_rms_m", "the position error was", length),
        (
            "position_error_max_m",
            "the largest position error was",
            length,
        ),
        ("slip_energy_j", "sliding cost", joules),
    ];
    for (key, name, shown) in figures {
        if let Some(effect) = one.get(key).filter(|it| it.differs)
            && let (Some(from), Some(to)) = (effect.with, effect.without)
        {
            let [to_known, from_known] = [to, from].map(|x| shown(x, effect.floor));
            let text = format!("{name} <b>{to_known}</b> instead of {from_known}");
            measures.push((fallen(from, to), text));
        }
    }
    measures
}

/// Returns how much nearer to the command a motion comes, of what was missing; 0 for one that then
/// goes beyond it by more than half as much.
fn nearer(missing: f64, then: f64) -> f64 {
    match missing * then < 0.0 && then.abs() > 0.5 * missing.abs() {
        true => 0.0,
        false => (missing.abs() - then.abs()) / missing.abs().max(f64::MIN_POSITIVE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::made_up_run;
    use ilon_trace::{Apart, Cause, Settings, Twin};

    /// Of 31 % that are missing 28 too much are no gain, and 3 too much are nine tenths.
    #[test]
    fn a_motion_that_goes_beyond_its_command_has_not_come_nearer() {
        assert_eq!(nearer(0.31, -0.28), 0.0);
        assert!((nearer(0.30, -0.03) - 0.9).abs() < 1e-12);
        assert!((nearer(0.30, 0.15) - 0.5).abs() < 1e-12);
        assert!((nearer(-0.30, -0.45) + 0.5).abs() < 1e-12);
    }

    /// The sentences of a run that was repeated without causes: of each how many times as large its
    /// error was without it.
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
                "2 more causes made less difference; 1 more cause helped.",
            ),
            (&[0.5, 2.0, 0.5, 0.5, 0.5], "1 more cause helped."),
            (
                &[0.5, 0.5, 0.5, 0.5, 0.5],
                "1 more cause made less difference.",
            ),
        ] {
            for open_loop in [false, true] {
                let lines = said(open_loop, errors);
                assert!(lines.iter().any(|line| line == count), "{lines:?}");
            }
        }
    }

    /// The sentence of an open-loop run that moved like `half` at half its step, and like `without`
    /// without a cause of this key; without it sliding cost `slip_j` more.
    fn said_of(key: &str, half: Apart, without: Apart, slip_j: f64) -> String {
        let mut trace = made_up_run(2.0, true);
        let summary = Summary::of(&trace, &Settings::default());
        let cause = Cause {
            key: key.to_owned(),
            words: "the wind".to_owned(),
        };
        let of = |change, apart| Twin::new(change, Ok((summary.clone(), Some(apart))));
        let mut twins = [
            of(Change::HalfStep, half),
            of(Change::Without(cause), without),
        ];
        *twins[1].figures.get_mut("slip_energy_j").expect("a figure") += slip_j;
        *twins[1]
            .figures
            .get_mut("ledger.total.path_m")
            .expect("a figure") += slip_j;
        trace.header.twins = twins.into();
        let summary = Summary::of(&trace, &Settings::default());
        super::super::plain(&sentences(&trace.header, &summary, &Posture::default())[0])
    }

    /// On its way the run is known to 10 mm, at its end to 1 mm: 23 of 23.4 mm are left there.
    #[test]
    fn what_is_left_at_the_end_is_told_by_how_well_the_end_is_known() {
        let half = Apart {
            most_m: 0.01,
            ahead_m: 0.001,
            ..Apart::default()
        };
        let without = Apart {
            most_m: 0.05,
            most_at_s: 1.0,
            left_m: 0.0234,
            ..Apart::default()
        };
        let said = said_of("faults.0", half, without, 0.0);
        assert!(
            said.starts_with(
                "The wind moved the robot by up to 50 mm at 1.00 s, and put the robot 23 mm to the left"
            ),
            "{said}"
        );
    }

    /// The way is known to 10 mm, the end to a hundredth: 5 mm there are told, though they are no
    /// part of what can be told of the way.
    #[test]
    fn an_end_that_is_known_better_than_the_way_is_told() {
        let half = Apart {
            most_m: 0.01,
            left_m: 1e-5,
            ..Apart::default()
        };
        let without = Apart {
            most_m: 0.02,
            left_m: 5e-3,
            ..Apart::default()
        };
        let said = said_of("faults.0", half, without, 0.0);
        assert!(
            said.starts_with("The wind put the robot 5.00 mm to the left at the end"),
            "{said}"
        );
    }

    /// The end is known to a hundredth of a millimetre, though the way is not: its tenths are said.
    #[test]
    fn the_end_is_told_with_the_digits_that_it_is_known_to() {
        let half = Apart {
            most_m: 0.01,
            ahead_m: 1e-5,
            ..Apart::default()
        };
        let without = Apart {
            most_m: 0.05,
            left_m: 0.0234,
            ..Apart::default()
        };
        let said = said_of("faults.0", half, without, 0.0);
        assert!(said.contains("put the robot 23.4"), "{said}");
    }

    /// A turn of 0.04 rad, of which 0.004 rad are left.
    #[test]
    fn a_turn_that_passes_is_told_beside_what_is_left_of_it() {
        let without = Apart {
            most_rad: 0.04,
            most_rad_at_s: 0.5,
            turned_rad: 0.004,
            ..Apart::default()
        };
        let said = said_of("faults.0", Apart::default(), without, 0.0);
        assert!(
            said.starts_with(
                "The wind turned the robot by up to 2.292° at 0.50 s, and turned it to the left by 0.229°"
            ),
            "{said}"
        );
    }

    /// The way is known to half a metre; 10 J more sliding is still reported.
    #[test]
    fn what_a_cause_costs_is_told_where_the_way_is_not_known() {
        let half = Apart {
            most_m: 0.5,
            ..Apart::default()
        };
        let said = said_of("faults.0", half, Apart::default(), 10.0);
        assert!(
            said.starts_with("The wind moved the robot by less than 1.5 m; slip: lost to sliding:"),
            "{said}"
        );
    }

    /// Noise has another direction with another seed.
    #[test]
    fn noise_never_helps() {
        let without = Apart {
            most_m: 0.05,
            ahead_m: 0.05,
            ..Apart::default()
        };
        for (key, helps) in [("faults.0", true), ("sensors.imu", false)] {
            let said = said_of(key, Apart::default(), without, 10.0);
            assert_eq!(said.contains("helped"), helps, "{said}");
        }
    }

    #[test]
    fn what_helped_in_open_loop_is_said_to_have() {
        let lines = said(true, &[2.0, 0.5]);
        assert!(lines[0].starts_with("The push 1 put"), "{lines:?}");
        // What it is compared with is said once.
        let compared = |line: &String| line.contains("compared with the same run without");
        assert!(compared(&lines[0]) && !compared(&lines[1]), "{lines:?}");
        assert!(
            lines[1].starts_with("The push 0 <b>helped</b>: it put"),
            "{lines:?}"
        );
    }
}
