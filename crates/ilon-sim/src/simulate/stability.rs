//! Whether the guidance can settle at its control period: Indiveri 2009, eqs. (25)-(26), in discrete time.
//!
//! | symbol | is |
//! |---|---|
//! | K | a gain, K_r or K_phi of eq. (26), in 1/s |
//! | T | the control period, in s |
//! | d | how many whole periods old a pose is when it is seen |
//!
//! Eq. (25) proves that the error decays for every K > 0 in continuous time. A controller that decides once a period holds its twist until
//! the next, so that the error of an ideal robot follows e_(k+1) = e_k - K T e_(k-d). That decays where and only where
//!
//! 0 < K T < 2 cos(d pi / (2 d + 1)),
//!
//! (Levin and May 1976, "A note on difference-delay equations"): below 2 with poses that are seen at once, 1 with poses a period old, 0.618
//! with two. From half of it (exactly so for d = 0) the error changes its sign from period to period.

use std::f64::consts::PI;

use ilon_trace::Guidance;

use crate::scenario::Scenario;

/// The product of gain and period from which on an error cannot settle, for poses that are some whole periods old.
pub(super) fn unstable_from(periods_old: u32) -> f64 {
    let d = f64::from(periods_old);
    2.0 * libm::cos(d * PI / (2.0 * d + 1.0))
}

/// The guidance of a scenario as a trace keeps it.
pub(super) fn guidance(scenario: &Scenario) -> Guidance {
    // Rounding shall not take a period off.
    const SLACK: f64 = 1e-9;
    let periods = scenario.sensors.pose.latency_s / scenario.run.control_dt_s;
    // A filter brings each pose up to the present.
    let periods_old = match scenario.sensors.fusion {
        Some(_) => 0,
        None => (periods + SLACK).floor() as u32,
    };
    Guidance {
        position_gain_per_s: scenario.guidance.position_gain_most_per_s(),
        heading_gain_per_s: scenario.guidance.heading_gain_per_s,
        unstable_from: unstable_from(periods_old),
    }
}

/// What a person should know of the gains of a scenario whose guidance follows a reference.
pub(super) fn remark(scenario: &Scenario) -> Option<String> {
    let guidance = guidance(scenario);
    let period_s = scenario.run.control_dt_s;
    let products = [
        ("position_gain_per_s", guidance.position_gain_per_s),
        ("heading_gain_per_s", guidance.heading_gain_per_s),
    ];
    let beyond = |least: f64| {
        let keys = products
            .iter()
            .filter(|(_, gain)| gain * period_s >= least * (1.0 - 1e-12));
        let words = keys.map(|(key, gain)| {
            format!(
                "`guidance.{key}` times `run.control_dt_s` is {:.3}",
                gain * period_s
            )
        });
        words.collect::<Vec<_>>()
    };
    let limit = guidance.unstable_from;
    let late = match limit < 2.0 {
        true => " with poses as old as `sensors.pose.latency_s` says",
        false => "",
    };
    let most_per_s = 0.5 * limit / period_s;
    let unstable = beyond(limit);
    if !unstable.is_empty() {
        return Some(format!(
            "the guidance is unstable: {}, and from {limit:.3} on{late} each correction is larger than the error, which cannot settle; \
             choose gains below {most_per_s:.3} /s, or a shorter `run.control_dt_s`",
            unstable.join(" and ")
        ));
    }
    let overshoots = beyond(0.5 * limit);
    (!overshoots.is_empty()).then(|| {
        format!(
            "the guidance overshoots: {}, and from {:.3} on{late} an error changes its sign from period to period (from {limit:.3} on it \
             never settles); choose gains below {most_per_s:.3} /s, or a shorter `run.control_dt_s`",
            overshoots.join(" and "),
            0.5 * limit
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error after many periods of e_(k+1) = e_k - product e_(k-d), by going through them.
    fn error_after(product: f64, periods_old: usize, periods: usize) -> f64 {
        /// Beyond this it has grown for good.
        const GROWN: f64 = 1e6;
        let mut errors = vec![1.0; periods_old + 1];
        for _ in 0..periods {
            let now: f64 = errors[errors.len() - 1];
            if now.abs() > GROWN {
                break;
            }
            errors.push(now - product * errors[errors.len() - 1 - periods_old]);
        }
        let last = errors.iter().rev().take(50);
        last.fold(0.0, |most: f64, e| most.max(e.abs()))
    }

    /// One per cent below the bound the error dies out, one above it grows, whatever the delay.
    #[test]
    fn the_bound_parts_errors_that_die_out_from_those_that_grow() {
        for periods_old in 0..6 {
            let limit = unstable_from(periods_old);
            let of = |product| error_after(product, periods_old as usize, 20_000);
            assert!(of(0.99 * limit) < 1e-3, "{periods_old}");
            assert!(of(1.01 * limit) > 1e3, "{periods_old}");
        }
        // The golden ratio less 1, of poses two periods old.
        assert!((unstable_from(2) - 0.618_033_988_75).abs() < 1e-10);
        assert_eq!(unstable_from(0), 2.0);
    }

    fn said(gains: &str) -> String {
        let text = format!(
            "[robot]\nfile = 'r.urdf'\n[reference.hold_pose]\nx_m = 0\ny_m = 0\nheading_deg = 0\n\
             [run]\nduration_s = 1\ncontrol_dt_s = 0.25\n{gains}"
        );
        let scenario = Scenario::from_toml(&text, "s", ".").expect("a scenario");
        remark(&scenario).unwrap_or_default()
    }

    #[test]
    fn each_gain_is_remarked_from_half_of_its_bound_on() {
        let with = |position: f64, heading: f64| {
            said(&format!(
                "[guidance]\nposition_gain_per_s = {position}\nheading_gain_per_s = {heading}"
            ))
        };
        assert_eq!(with(3.9, 3.9), "");
        let heading = with(1.0, 4.0);
        assert!(
            heading.contains(
                "overshoots: `guidance.heading_gain_per_s` times `run.control_dt_s` is 1.000,"
            ),
            "{heading}"
        );
        let position = with(7.9, 1.0);
        assert!(
            position.contains(
                "overshoots: `guidance.position_gain_per_s` times `run.control_dt_s` is 1.975,"
            ),
            "{position}"
        );
        let both = with(8.0, 10.0);
        for words in [
            "unstable",
            "is 2.000 and",
            "is 2.500, and from 2.000 on each",
            "below 4.000 /s",
        ] {
            assert!(both.contains(words), "{both}");
        }
    }

    #[test]
    fn a_late_pose_lowers_the_bound_unless_a_filter_brings_it_up_to_the_present() {
        let late = "[guidance]\nposition_gain_per_s = 4.5\n[sensors.pose]\nlatency_s = 0.25\n";
        assert!(said(late).contains("unstable"), "{}", said(late));
        assert!(said(&format!("{late}[sensors.fusion]\n")).contains("overshoots"));
    }
}
