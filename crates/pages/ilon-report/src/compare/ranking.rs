//! Ranks the figures by how much runs differ in them, and reports the largest differences in a
//! sentence per run.

use ilon_trace::quantities::{self, GROUPS};
use ilon_trace::{Quantity, Summary};

use super::{ComparedRun, Comparison};
use crate::page::escape;
use crate::text::{percent, spoken};

/// Figures that differ by less than this, as a logarithm of their ratio, count as equal: 1 %.
const SAME: f64 = 0.01;

/// Number of figures in a sentence.
const IN_A_SENTENCE: usize = 3;

/// A figure with its heading.
#[derive(Clone, Copy, Debug)]
pub struct Named {
    /// The heading.
    pub heading: &'static str,
    /// The figure.
    pub quantity: &'static Quantity,
}

/// The verdict on a figure that one run worsens and another betters.
const MIXED: &str = "regressed in one, improved in another";

/// Returns the figures in which the runs differ from the first, under their verdicts: regressed,
/// improved, both in different runs, or neither of the two. The largest differences stand first. The
/// others are within the noise.
pub fn verdicts(comparison: &Comparison) -> Vec<(&'static str, Vec<Named>)> {
    let verdict = |named: &Named| {
        let differ = |run: &usize| differs(comparison, named.quantity, *run);
        let gains = (1..comparison.runs.len()).filter(differ).filter_map(|run| {
            let summaries = [0, run].map(|run| &comparison.runs[run].summary);
            let [first, other] = summaries.map(|summary| named.quantity.value(summary));
            is_gain(named.quantity.key, first?, other?)
        });
        let gains: Vec<bool> = gains.collect();
        match (gains.contains(&false), gains.contains(&true)) {
            (true, false) => "regressed",
            (true, true) => MIXED,
            (false, true) => "improved",
            (false, false) => "changed",
        }
    };
    let different = different(comparison);
    let of = |word: &'static str| {
        let named = different.iter().filter(|named| verdict(named) == word);
        (word, named.copied().collect::<Vec<_>>())
    };
    let verdicts = ["regressed", MIXED, "improved", "changed"]
        .into_iter()
        .map(of);
    verdicts.filter(|(_, named)| !named.is_empty()).collect()
}

/// Whether a change of a figure is a gain; `None` where neither more nor less is better.
fn is_gain(key: &str, first: f64, other: f64) -> Option<bool> {
    if key.starts_with("twist_ratio") {
        return Some((other - 1.0).abs() < (first - 1.0).abs());
    }
    // Work that a run takes and another gives back is neither.
    let is_work = key.starts_with("energy.") && first * other < 0.0;
    (quantities::is_cost(key) && !is_work).then(|| other.abs() < first.abs())
}

/// Returns a figure relative to the first run's, as text; `None` if that one is too close to zero,
/// or of the opposite sign.
pub fn change(quantity: &Quantity, first: f64, other: f64) -> Option<String> {
    let last_digit = 10f64.powi(-(quantity.decimals as i32));
    if first.abs() < 10.0 * last_digit || first * other < 0.0 {
        return None;
    }
    let ratio = other / first;
    Some(if (0.5..=2.0).contains(&ratio) {
        format!("{:+.1} %", 100.0 * (ratio - 1.0))
    } else {
        format!("×{ratio:.2}")
    })
}

/// Returns the figures in which the runs differ from the first, the largest differences first.
fn different(comparison: &Comparison) -> Vec<Named> {
    let others = 1..comparison.runs.len();
    let weight = |named: &Named| {
        let weights = others
            .clone()
            .map(|run| weight(comparison, named.quantity, run));
        weights.fold(0.0, f64::max)
    };
    ranked(comparison, weight)
}

fn ranked(comparison: &Comparison, weight: impl Fn(&Named) -> f64) -> Vec<Named> {
    let open_loop = comparison.runs.iter().all(|run| run.trace.header.open_loop);
    let groups = GROUPS.iter().filter(|group| {
        // Figures about the execution of a run are no results.
        group.heading != "run" && (open_loop || !group.open_loop_only)
    });
    let named = groups.flat_map(|group| {
        group
            .quantities
            .iter()
            .filter(|q| q.is_main)
            .map(|quantity| Named {
                heading: group.heading,
                quantity,
            })
    });
    let mut weighed: Vec<(f64, Named)> = named
        .map(|named| (weight(&named), named))
        .filter(|(weight, _)| *weight > SAME)
        .collect();
    weighed.sort_by(|a, b| b.0.total_cmp(&a.0));
    weighed.into_iter().map(|(_, named)| named).collect()
}

/// Whether a figure of a run differs from that of the first by more than figures bear.
pub fn differs(comparison: &Comparison, quantity: &Quantity, run: usize) -> bool {
    weight(comparison, quantity, run) > SAME
}

/// Returns how much a figure of a run differs from that of the first: the logarithm of their ratio,
/// with magnitudes below the displayed precision counted as equal.
fn weight(comparison: &Comparison, quantity: &Quantity, run: usize) -> f64 {
    let shown = |run: usize| quantity.shown(&comparison.runs[run].summary);
    let (Some(first), Some(other)) = (shown(0), shown(run)) else {
        return 0.0;
    };
    // Ten steps of the last displayed digit; smaller values are not compared.
    let least = 10.0 * 10f64.powi(-(quantity.decimals as i32));
    let size = |x: f64| x.abs().max(least);
    if first.signum() != other.signum() && first.abs().max(other.abs()) > least {
        return 1.0 + ((first - other).abs() / least).ln().max(0.0);
    }
    (size(other) / size(first)).ln().abs()
}

/// Returns the results of each run relative to the first, one sentence each: first the motion
/// achieved of the commanded one, then the headline figures that differ most. Numbers are between
/// `<b>` and `</b>`.
pub fn sentences(comparison: &Comparison) -> Vec<String> {
    let Some((first, others)) = comparison.runs.split_first() else {
        return Vec::new();
    };
    let sentence = |(index, run): (usize, &ComparedRun)| {
        // What a guidance commands follows from the run: no share of that says how well it went.
        let is_open = |run: &ComparedRun| run.trace.header.open_loop;
        let mut what = match is_open(first) && is_open(run) {
            true => of_motion(&first.summary, &run.summary),
            false => Vec::new(),
        };
        let headlines: Vec<&str> = quantities::headlines(&run.summary)
            .iter()
            .map(|q| q.key)
            .collect();
        let is_cost = |named: &Named| {
            headlines.contains(&named.quantity.key)
                && !named.quantity.key.starts_with("twist_ratio")
        };
        let top = ranked(comparison, |named| match is_cost(named) {
            true => weight(comparison, named.quantity, index + 1),
            false => 0.0,
        });
        what.extend(top.iter().take(IN_A_SENTENCE).filter_map(|named| {
            let quantity = named.quantity;
            let [from, to] = [&first.summary, &run.summary].map(|summary| quantity.shown(summary));
            Some(instead(&escape(&spoken(quantity)), from?, to?, quantity))
        }));
        let (name, first) = (escape(&run.name), escape(&first.name));
        match what.is_empty() {
            true => {
                format!(
                    "The runs <b>{name}</b> and <b>{first}</b> agree: no main figure differs by more than 1 %."
                )
            }
            false => format!("<b>{name}</b>, compared with {first}: {}.", what.join("; ")),
        }
    };
    others.iter().enumerate().map(sentence).collect()
}

/// Returns the share of the commanded motion that was achieved, for each direction in which it
/// differs by more than a thousandth.
fn of_motion(first: &Summary, other: &Summary) -> Vec<String> {
    let [a, b] = [first, other].map(|summary| summary.twist_ratio_asked);
    let axes = [
        ("ahead", a.vx, b.vx),
        ("to the left", a.vy, b.vy),
        ("in turning", a.omega, b.omega),
    ];
    let differs = |(way, from, to): (&str, Option<f64>, Option<f64>)| {
        let (from, to) = (from?, to?);
        ((from - to).abs() > 1e-3).then(|| {
            format!(
                "{way} it reaches <b>{}</b> of the command instead of {}",
                percent(to),
                percent(from)
            )
        })
    };
    axes.into_iter().filter_map(differs).collect()
}

/// Returns a figure next to that of the first run, with the difference in percent if meaningful.
fn instead(words: &str, from: f64, to: f64, quantity: &Quantity) -> String {
    let (decimals, symbol) = (quantity.decimals, escape(quantity.unit.symbol));
    let change = 100.0 * (to - from) / from.abs();
    let change = match change.is_finite() && change.abs() < 1000.0 {
        true => format!(" ({change:+.0} %)"),
        false => String::new(),
    };
    format!("{words} <b>{to:.decimals$} {symbol}</b> instead of {from:.decimals$}{change}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::made_up_run;
    use ilon_trace::Settings;

    fn comparison(change: impl Fn(&mut Summary)) -> Comparison {
        comparison_of([&change])
    }

    /// A run beside others that are the same but for a change each.
    fn comparison_of<const N: usize>(changes: [&dyn Fn(&mut Summary); N]) -> Comparison {
        let run = |name: &str| {
            let trace = made_up_run(2.0, false);
            let summary = Summary::of(&trace, &Settings::default());
            ComparedRun::new(name.to_owned(), trace, summary)
        };
        let mut runs = vec![run("one")];
        for (name, change) in ["two", "three"].into_iter().zip(changes) {
            let mut changed = run(name);
            changed.trace.header.scenario_name = name.to_owned();
            change(&mut changed.summary);
            runs.push(changed);
        }
        let names = ["one", "two", "three"].map(Into::into);
        Comparison::of(runs, &names[..=N]).expect("runs")
    }

    #[test]
    fn what_differs_most_stands_first_and_noise_nowhere() {
        let compared = comparison(|summary| {
            summary.position_error_max_m =
                Some(1.0 + 10.0 * summary.position_error_max_m.unwrap_or(0.0));
            summary.travelled_m *= 1.001;
        });
        let top = different(&compared);
        assert_eq!(top[0].quantity.key, "position_error_max_m");
        assert!(top.iter().all(|named| named.quantity.key != "travelled_m"));
        let said = sentences(&compared).concat();
        assert!(said.contains("instead of"), "{said}");
    }

    /// A figure that is as large with the other sign differs, though the ratio of the sizes is 1:
    /// 2 m ahead and 2 m back are 4 m apart, which is 1 + ln of that over what is shown.
    #[test]
    fn a_figure_with_the_other_sign_differs() {
        let compared = comparison(|summary| summary.end_x_m = Some(-2.0));
        let mut runs = compared.runs;
        runs[0].summary.end_x_m = Some(2.0);
        let compared = Comparison::of(runs, &["one".into(), "two".into()]).expect("two runs");
        let quantity = quantities::by_key("end_x_m").expect("it is a figure");
        let least = 10.0 * 10f64.powi(-(quantity.decimals as i32));
        let expected = 1.0 + (4.0 / least).ln();
        assert!((weight(&compared, quantity, 1) - expected).abs() < 1e-12);
    }

    /// The achieved motion comes first, though another figure differs more; not where a guidance
    /// commands it, whose command follows from the run.
    #[test]
    fn what_was_reached_is_told_first() {
        let compared = comparison(|summary| {
            summary.twist_ratio_asked.vy = Some(1.0);
            summary.slip_energy_j = Some(1e3);
        });
        let mut runs = compared.runs;
        runs[0].summary.twist_ratio_asked.vy = Some(0.98);
        let mut compared = Comparison::of(runs, &["one".into(), "two".into()]).expect("two runs");
        assert!(!sentences(&compared)[0].contains("of the command"));
        for run in &mut compared.runs {
            run.trace.header.open_loop = true;
        }
        let said = &sentences(&compared)[0];
        assert!(
            said.starts_with("<b>two</b>, compared with one: to the left it reaches <b>100.0 %</b> of the command instead of 98.0 %; "),
            "{said}"
        );
        assert!(said.contains("1000.0000 J"), "{said}");
    }

    /// From 1 to 5 m is 400 % more; from 1 to 20 m is better said without percent.
    #[test]
    fn percents_beyond_a_thousand_are_left_out() {
        let quantity = quantities::by_key("end_x_m").expect("it is a figure");
        let said = |to: f64| instead("x", 1.0, to, quantity);
        assert!(said(5.0).ends_with(" (+400 %)"), "{}", said(5.0));
        assert!(!said(20.0).contains('%'), "{}", said(20.0));
    }

    #[test]
    fn a_figure_is_told_against_the_first_run_where_that_measures_anything() {
        // Its last digit is a tenth of a millimetre.
        let quantity = quantities::by_key("end_x_m").expect("it is a figure");
        assert_eq!(quantity.decimals, 4);
        assert_eq!(change(quantity, 1.0, 1.5).as_deref(), Some("+50.0 %"));
        assert_eq!(change(quantity, 1.0, 3.0).as_deref(), Some("×3.00"));
        assert_eq!(change(quantity, 0.0009, 3.0), None);
        // A share of the other sign measures nothing.
        assert_eq!(change(quantity, -1.0, 3.0), None);
    }

    /// Less of an error is better, a ratio is better the closer it is to 1 from either side, and a
    /// place is neither.
    #[test]
    fn a_change_is_judged_by_what_is_better() {
        assert_eq!(is_gain("slip_energy_j", 2.0, 1.0), Some(true));
        assert_eq!(is_gain("ledger.total.x_m", -1.0, -2.0), Some(false));
        assert_eq!(is_gain("twist_ratio_asked.vy", 0.98, 1.01), Some(true));
        assert_eq!(is_gain("twist_ratio_asked.vy", 0.98, 1.03), Some(false));
        assert_eq!(is_gain("end_x_m", 1.0, 2.0), None);
        assert_eq!(is_gain("energy.motor_j", -15.0, 1.0), None);
        assert_eq!(is_gain("energy.motor_j", 15.0, 1.0), Some(true));
        assert_eq!(is_gain("position_error_max_at_s", 1.0, 2.0), None);
        assert_eq!(is_gain("ledger.guidance.path_m", 1.0, 2.0), None);
        let compared = comparison(|summary| {
            summary.position_error_max_m = summary.position_error_max_m.map(|m| 0.5 * m);
            summary.slip_energy_j = Some(1e3);
        });
        let verdicts = verdicts(&compared);
        let keys = |word: &str| {
            let of = verdicts.iter().filter(|(verdict, _)| *verdict == word);
            let named = of.flat_map(|(_, named)| named);
            named.map(|named| named.quantity.key).collect::<Vec<_>>()
        };
        assert_eq!(keys("regressed"), ["slip_energy_j"]);
        assert_eq!(keys("improved"), ["position_error_max_m"]);
    }

    /// A figure that the second run worsens and the third betters did not regress.
    #[test]
    fn a_figure_that_runs_change_both_ways_has_a_verdict_of_its_own() {
        let slips = |slip_j: f64| move |summary: &mut Summary| summary.slip_energy_j = Some(slip_j);
        let compared = comparison_of([&slips(1e3), &slips(0.0)]);
        let verdicts = verdicts(&compared);
        assert_eq!(verdicts[0].0, MIXED);
        assert_eq!(verdicts[0].1[0].quantity.key, "slip_energy_j");
    }

    #[test]
    fn runs_that_came_to_the_same_are_said_to() {
        let compared = comparison(|_| {});
        assert!(different(&compared).is_empty());
        assert!(sentences(&compared)[0].contains("agree: "));
    }
}
