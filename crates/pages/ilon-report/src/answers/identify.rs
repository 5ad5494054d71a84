//! The results of an identification in sentences.

pub mod tables;

use crate::page::Answer;
use crate::sweep::figure as number;
use crate::text::decimals;
use ilon_identify::Identified;
use ilon_identify::outcome::{
    Controller, ControllerKind, Direction, Errors, Gains, JudgedBy, Simulation, Value, WheelSetting,
};
use ilon_identify::scatter::Scatter;

/// A gain ahead above this exceeds the roll of wheels of their known size.
const TOO_FAR: f64 = 1.02;
/// A gain ahead below this is seldom due to smaller wheels alone.
const TOO_SHORT: f64 = 0.95;

/// Returns the results, the answer first: the robot's motion, the settings, their uncertainty, and
/// further drives for more certainty.
pub fn answers(found: &Identified) -> Vec<Answer> {
    // The gains are explained by wheels at other places than stated.
    let mut plain = match stand_otherwise(found) {
        Some(said) => vec![said],
        None => robot(&found.gains),
    };
    plain.extend(by_direction(&found.residual));
    plain.extend(set(&found.controller, &found.gains));
    let mut answers: Vec<Answer> = plain.into_iter().map(Answer::plain).collect();
    let errors = [&found.nominal, &found.held_out];
    answers.push(judged(
        (&found.model, found.window_s),
        found.judged_by,
        errors,
    ));
    let over_noise = found.held_out.over_noise;
    if over_noise > 2.0 {
        answers.push(Answer::bad(format!(
            "What is left is {} times what the tracker's noise explains: the model is not the whole truth. See by direction of motion.",
            number(over_noise)
        )));
    }
    for held in &found.held {
        let value = number(held.value);
        answers.push(Answer::bad(format!(
            "{} was held at {value}: {}.",
            held.name, held.why
        )));
    }
    if let Some(simulation) = &found.simulation {
        answers.extend(simulated(simulation));
    }
    for odd in found.doubts.iter().take(6) {
        let (doubt, file) = (&odd.doubt, &odd.file);
        answers.push(Answer::bad(format!(
            "{file}: {} ({}).",
            doubt.message, doubt.help
        )));
    }
    answers.extend(to_know_more(found).map(Answer::plain));
    answers
}

/// Reports wheels at other places than stated, and the consequence.
fn stand_otherwise(found: &Identified) -> Option<String> {
    let each = found.parameters.iter().filter_map(|(name, value)| {
        let (what, wheel) = name.split_once('.')?;
        let (what, unit, per_own) = match what {
            "axis_deg" => ("heading of the axis", "°", 1.0),
            "x_m" => ("x", "mm", 1e3),
            "y_m" => ("y", "mm", 1e3),
            "steering_deg" => ("steering angle at a reading of 0", "°", 1.0),
            _ => return None,
        };
        let is_otherwise = !may_be(value, value.nominal);
        is_otherwise.then(|| {
            let now = number(per_own * value.value);
            let before = number(per_own * value.nominal);
            format!(
                "{what} of `{wheel}` {now} {unit}{} in place of {before}",
                between(value, per_own)
            )
        })
    });
    let each: Vec<String> = each.collect();
    let remedy = match each.iter().all(|said| said.starts_with("steering")) {
        true => "Add that to what the steering reads.",
        false => {
            "Turn them back, or command the robot by its own matrix M: `ilon inspect robot.toml` prints that of the robot as it was found."
        }
    };
    (!each.is_empty()).then(|| {
        format!(
            "Wheels stand otherwise than stated: {}. {remedy}",
            each.join(", ")
        )
    })
}

/// Returns by how much a value falls short of 1, with its interval, in percent: `4.3 % less far`
/// and ` (3.9 to 4.7 %)`.
fn short_of(value: &Value, less: &str, more: &str) -> (String, String) {
    let short = |gain: f64| 100.0 * (1.0 - gain);
    let percent = short(value.value);
    let (sign, word) = if percent < 0.0 {
        (-1.0, more)
    } else {
        (1.0, less)
    };
    let shown = |gain: f64| rounded(sign * short(gain));
    let interval = match value.ci95 {
        [Some(low), Some(high)] => {
            let mut ends = [low, high];
            if sign > 0.0 {
                ends.reverse();
            }
            format!(" ({} to {} %)", shown(ends[0]), shown(ends[1]))
        }
        _ => " (how sure that is cannot be said)".to_owned(),
    };
    (format!("{} % {word}", shown(value.value)), interval)
}

/// Rounds percent to a tenth, and values below one to a hundredth.
fn rounded(percent: f64) -> String {
    decimals(percent, if percent.abs() < 0.95 { 2 } else { 1 })
}

/// Whether the interval of a value contains another one.
fn may_be(value: &Value, other: f64) -> bool {
    matches!(value.ci95, [Some(low), Some(high)] if low <= other && other <= high)
}

/// Whether the uncertainty of a gain exceeds a tenth.
fn is_vague(value: &Value) -> bool {
    match value.ci95 {
        [Some(low), Some(high)] => high - low > 0.2 * value.value.abs(),
        _ => true,
    }
}

/// Reports the part of a gain that rigid rollers explain, given their own gain.
fn explained(gain: &Value, rigid: Option<f64>) -> String {
    let Some(rigid) = rigid else {
        return String::new();
    };
    let (all, by_rollers) = (1.0 - gain.value, 1.0 - rigid);
    let percent = rounded(100.0 * by_rollers.abs());
    if by_rollers.abs() < (0.02 * all.abs()).max(5e-4) {
        "; rigid rollers explain nothing of it".to_owned()
    } else if all * by_rollers > 0.0 {
        format!("; rigid rollers explain {percent} of them")
    } else {
        let way = if by_rollers > 0.0 { "less" } else { "more" };
        format!("; rigid rollers would make it {percent} % {way}")
    }
}

/// Reports the robot's motion over the one commanded by its wheels.
fn robot(gains: &Gains) -> Vec<String> {
    let rigid = gains.rigid;
    let [sideways, turn] = [
        rigid.map(|[ahead, sideways, _]| sideways / ahead),
        rigid.map(|[.., turn]| turn),
    ];
    let ahead = match &gains.ahead {
        Some(_) if is_too_far(gains) => {
            "; wheels of their known size cannot: they are larger, or rows of the logs were lost, or the tracker's \
             scale is wrong. Unless it is the wheels, only ratios count"
        }
        Some(ahead) if ahead.value < TOO_SHORT => {
            "; wheels are seldom off by so much. Where a floor drags or creeps, what follows holds on that floor alone"
        }
        _ => "",
    };
    let sentence = |gain: &Option<Value>,
                    [does, less, more, than]: [&str; 4],
                    beside: &dyn Fn(&Value) -> String| {
        let gain = gain.as_ref()?;
        let (percent, interval) = short_of(gain, less, more);
        let (is_open, beside) = match (is_vague(gain), may_be(gain, 1.0)) {
            (true, _) => (true, ", which these logs do not determine".to_owned()),
            (false, true) => (true, ", which is within its uncertainty".to_owned()),
            (false, false) => (false, beside(gain)),
        };
        let words = format!("{does} {percent} than {than}{interval}{beside}.");
        Some((is_open, words))
    };
    let asked = "its wheel speeds give";
    let sentences = [
        sentence(
            &gains.sideways_over_ahead,
            ["Sideways it goes", "less far", "farther", "ahead"],
            &|gain| explained(gain, sideways),
        ),
        sentence(
            &gains.ahead,
            ["Ahead it goes", "less far", "farther", asked],
            &|_| ahead.to_owned(),
        ),
        sentence(&gains.turn, ["It turns", "less", "more", asked], &|gain| {
            explained(gain, turn)
        }),
    ];
    // What was found stands before what is open.
    let mut sentences: Vec<(bool, String)> = sentences.into_iter().flatten().collect();
    sentences.sort_by_key(|(is_open, _)| *is_open);
    sentences.into_iter().map(|(_, words)| words).collect()
}

/// Reports the directions with the smallest and largest gains, if more than the four along its axes
/// were driven.
fn by_direction(directions: &[Direction]) -> Option<String> {
    if directions.len() < 5 {
        return None;
    }
    let by = |a: &&Direction, b: &&Direction| a.measured.total_cmp(&b.measured);
    let (least, most) = (directions.iter().min_by(by)?, directions.iter().max_by(by)?);
    let words = |one: &Direction| {
        // The standard error over n windows has n - 1 degrees of freedom.
        let half =
            Scatter::furthest(one.stretches.saturating_sub(1).max(1) as f64) * one.measured_error;
        let [low, high] =
            [one.measured - half, one.measured + half].map(|gain| rounded(100.0 * gain));
        format!(
            "{:.0} degrees: {} % of what its wheel speeds give ({low} to {high} %)",
            one.direction_deg,
            rounded(100.0 * one.measured)
        )
    };
    Some(format!(
        "Of {} directions it falls shortest at {}, and gets furthest at {} (from ahead to the left).",
        directions.len(),
        words(least),
        words(most)
    ))
}

/// Returns a length in millimetres, with its value before the fit.
fn length(value: &Value) -> String {
    let [own, nominal] = [value.value, value.nominal].map(|metres| number(1e3 * metres));
    format!("{own} mm{} in place of {nominal} mm", between(value, 1e3))
}

/// Returns the setting of a controller's length.
fn set_to(name: &str, value: &Value) -> String {
    match may_be(value, value.nominal) {
        true => format!(
            "leave {name} at {} mm{}",
            number(1e3 * value.nominal),
            between(value, 1e3)
        ),
        false => format!("set {name} to {}", length(value)),
    }
}

/// Returns the interval of a value in brackets, in a unit of which `per_own` make one of its own.
fn between(value: &Value, per_own: f64) -> String {
    match value.ci95 {
        [Some(low), Some(high)] if low < high => {
            format!(" ({} to {})", number(per_own * low), number(per_own * high))
        }
        _ => String::new(),
    }
}

/// Returns the settings of a controller.
pub fn set(controller: &Controller, gains: &Gains) -> Vec<String> {
    let (name, radius_key, lever_key) = match controller.kind {
        Some(ControllerKind::Mecanum) => (
            "mecanum_drive_controller",
            ", `kinematics.wheels_radius`,",
            ", `kinematics.sum_of_robot_center_projection_on_X_Y_axis`,",
        ),
        Some(ControllerKind::Omni) => (
            "omni_wheel_drive_controller",
            ", `wheel_radius`,",
            ", `robot_radius`,",
        ),
        Some(ControllerKind::Differential) => ("diff_drive_controller", ", `wheel_radius`,", ""),
        Some(ControllerKind::Tricycle) => ("tricycle_controller", ", `wheel_radius`,", ""),
        None => ("your controller", "", ""),
    };
    let is_differential = controller.kind == Some(ControllerKind::Differential);
    let mut set: Vec<String> = Vec::new();
    let is_known = |radius: &&Value| !controller.wheels.is_empty() || !is_vague(radius);
    if let Some(radius) = controller.radius_m.as_ref().filter(is_known) {
        let doubt = if is_too_far(gains) {
            ", if it is the wheels that are larger"
        } else {
            ""
        };
        set.push(set_to(&format!("the wheel radius rho{radius_key}"), radius) + doubt);
    }
    if let Some(lever) = controller.lever_m.as_ref().filter(|lever| !is_vague(lever)) {
        set.push(match controller.kind {
            Some(ControllerKind::Tricycle) => set_to("the wheelbase, `wheelbase`,", lever),
            Some(ControllerKind::Differential) => set_to(
                "the track, `wheel_separation`,",
                &lever.through(|lever_m| 2.0 * lever_m, "m", 2.0 * lever.nominal),
            ),
            _ => set_to(&format!("the lever of turns{lever_key}"), lever),
        });
    }
    let mut lines: Vec<String> = Vec::new();
    let gamma = controller.gamma_deg.as_ref();
    if let Some(gamma) = gamma.filter(|of| !may_be(of, of.nominal) && !is_vague(of)) {
        lines.push(format!(
            "The rollers stand at gamma = {} deg{}, not {} deg: correct it in the robot's file.",
            number(gamma.value),
            between(gamma, 1.0),
            number(gamma.nominal)
        ));
    }
    if !set.is_empty() {
        lines.insert(0, format!("In {name} {}.", set.join(", and ")));
    }
    let factor = controller.sideways_factor.as_ref();
    if let Some(factor) = factor.filter(|factor| !may_be(factor, 1.0) && !is_vague(factor)) {
        lines.push(format!(
            "Multiply vy, the speed sideways, by {}{} before it reaches the controller, which has one gear factor for all directions.",
            number(factor.value),
            between(factor, 1.0)
        ));
    }
    if !controller.wheels.is_empty() {
        let (says, by) = match is_differential {
            true => (
                "Set its multipliers `left_wheel_radius_multiplier` and `right_wheel_radius_multiplier`",
                "to",
            ),
            false => (
                "Multiply the rate of each wheel behind the controller, which has one radius for all",
                "by",
            ),
        };
        let wheel = |one: &WheelSetting| {
            let factor = match is_differential {
                true => 1.0 / one.rate_factor,
                false => one.rate_factor,
            };
            let name = &one.wheel;
            format!("{name} {by} {factor:.4} (rho {})", length(&one.radius_m))
        };
        let wheels: Vec<String> = controller.wheels.iter().map(wheel).collect();
        lines.push(format!("{says}: {}.", wheels.join(", ")));
    }
    lines
}

/// Whether the robot drives further ahead than wheels of their known size would roll.
fn is_too_far(gains: &Gains) -> bool {
    let ahead = gains.ahead.as_ref();
    ahead.is_some_and(|ahead| ahead.ci95[0].unwrap_or(ahead.value) > TOO_FAR)
}

/// Reports the chosen model, and its held-out error compared with that of the robot before the fit.
fn judged(
    (model, window_s): (&str, f64),
    judged_by: JudgedBy,
    [before, after]: [&Errors; 2],
) -> Answer {
    let judged = match judged_by {
        JudgedBy::Runs => "on unseen runs",
        JudgedBy::EachRun => "by cross-validation over runs",
        JudgedBy::EachStretch => "by cross-validation over eighths of the runs",
    };
    // Ends are of whole runs: cross-validation has none that were not fitted.
    let of_which = match judged_by {
        JudgedBy::Runs => "",
        JudgedBy::EachRun | JudgedBy::EachStretch => "on the fitted runs ",
    };
    let milli = |metres: f64| number(1e3 * metres);
    Answer {
        is_good: (after.over_noise < before.over_noise).then_some(true),
        text: format!(
            "The model \"{model}\" errs by {} mm over a stretch of {} s {judged}, the nominal robot by {} mm; odometry ends {of_which}{} mm off instead of {} mm.",
            milli(after.position_rms_m),
            number(window_s),
            milli(before.position_rms_m),
            milli(after.end_position_rms_m),
            milli(before.end_position_rms_m)
        ),
    }
}

/// Reports limitations of the keys that were found by simulating.
fn simulated(simulation: &Simulation) -> Vec<Answer> {
    let mut answers: Vec<Answer> = Vec::new();
    let rms = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
    answers.push(Answer::plain(format!(
        "The simulated distances are off by {} (rms, as a share) on the fitted drives, and by {} on the unseen ones.",
        rms(simulation.fit.ratio),
        rms(simulation.held_out.ratio)
    )));
    let mut bad = |text: String| answers.push(Answer::bad(text));
    for [a, b] in &simulation.alike {
        bad(format!(
            "These logs hardly distinguish {a} and {b}: one can compensate the other. Their intervals include that."
        ));
    }
    let of_each: [(&[String], &str); 5] = [
        (
            &simulation.insensitive,
            "changes less than the noise over all of its range",
        ),
        (
            &simulation.open,
            "is not determined by these logs: its interval is its whole range, as other keys can compensate it. All of them together \
             can still predict well",
        ),
        (
            &simulation.cut_off,
            "has an interval that reaches an end of its range: values beyond were not tried",
        ),
        (
            &simulation.of_one_run,
            "is determined by one run alone: its uncertainty is unknown",
        ),
        (
            &simulation.at_bounds,
            "lies at an end of its range: beyond it the fit may be better",
        ),
    ];
    for (keys, says) in of_each {
        keys.iter().for_each(|key| bad(format!("{key} {says}.")));
    }
    for other in &simulation.elsewhere {
        bad(format!(
            "{} near {} fits these logs too, but values between do not: its interval includes both.",
            other.key,
            number(other.value)
        ));
    }
    if simulation.phases_matter == Some(true) {
        bad(format!(
            "The result depends on the wheels' angles at the start, which the logs do not have: each drive was simulated \
             from {} sets of angles, and the intervals include their scatter.",
            simulation.phases
        ));
    }
    if !simulation.has_converged {
        bad("The search stopped at its limit of steps: set a larger `simulate.steps`.".to_owned());
    }
    answers
}

/// Returns the drives or logs that would determine the unknown values.
fn to_know_more(found: &Identified) -> Option<String> {
    let gains = &found.gains;
    let mut wishes: Vec<String> = Vec::new();
    let lacks = [
        (&gains.ahead, "ahead and back"),
        (&gains.sideways, "sideways, to the left and to the right"),
        (&gains.turn, "turns on the spot"),
    ];
    let lacks: Vec<&str> = lacks
        .iter()
        .filter(|(gain, drive)| gain.is_none() && !(found.is_held && drive.starts_with("sideways")))
        .map(|(_, drive)| *drive)
        .collect();
    if !lacks.is_empty() {
        wishes.push(format!("drive {}", lacks.join(" and ")));
    }
    if found.intervals_over == "stretches" {
        wishes.push(
            "fit six runs or more: the intervals do not include differences between runs"
                .to_owned(),
        );
    }
    if let Some(simulation) = &found.simulation {
        if !simulation.of_one_run.is_empty() {
            wishes.push(format!(
                "repeat the drives that determine {}",
                simulation.of_one_run.join(", ")
            ));
        }
        if !(simulation.alike.is_empty()
            && simulation.open.is_empty()
            && simulation.elsewhere.is_empty())
        {
            wishes.push(
                "drive in other directions, and compare the heading, the currents or what happens once a roller too (`[simulate.heading]`, \
                 `[simulate.currents]`, `[simulate.ripple]`)"
                    .to_owned(),
            );
        }
        if simulation.phases_matter == Some(true) {
            wishes.push("log the wheels' absolute angles (`simulate.phases = \"log\"`)".to_owned());
        }
    }
    (!wishes.is_empty()).then(|| format!("To know more, {}.", wishes.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(value: f64, low: f64, high: f64) -> Option<Value> {
        Some(Value {
            value,
            ci95: [Some(low), Some(high)],
            unit: String::new(),
            nominal: 1.0,
        })
    }

    #[test]
    fn a_length_that_may_be_as_stated_is_left_at_it() {
        let left = set_to("the lever", &value(1.01, 0.98, 1.04).expect("a value"));
        assert!(left.starts_with("leave the lever at 1000 mm"), "{left}");
        let set = set_to("the lever", &value(1.01, 1.005, 1.015).expect("a value"));
        assert!(set.starts_with("set the lever to 1010 mm"), "{set}");
    }

    /// Eight rollers at 45 degrees give sin(pi/8) / (pi/8) = 0.9745 of the distance sideways.
    #[test]
    fn a_gain_is_said_as_what_is_missing_to_1_with_its_interval_and_what_rollers_explain() {
        let gains = Gains {
            sideways_over_ahead: value(0.957, 0.953, 0.961),
            ahead: value(0.998, 0.993, 1.003),
            turn: value(1.25, 0.7, 1.8),
            rigid: Some([1.0, 0.9745, 0.9745]),
            ..Gains::default()
        };
        assert_eq!(
            robot(&gains),
            [
                "Sideways it goes 4.3 % less far than ahead (3.9 to 4.7 %); rigid rollers explain 2.5 of them.",
                "Ahead it goes 0.20 % less far than its wheel speeds give (-0.30 to 0.70 %), which is within its uncertainty.",
                "It turns 25.0 % more than its wheel speeds give (-30.0 to 80.0 %), which these logs do not determine.",
            ]
        );
    }

    /// A model that misses as much as the robot before the fit is no improvement, and must not be
    /// shown as good.
    #[test]
    fn a_model_is_good_of_whichit_misses_less_than_the_robot_as_it_was_known() {
        let errors = |over_noise: f64, rms_mm: f64| Errors {
            over_noise,
            position_rms_m: 1e-3 * rms_mm,
            ..Errors::default()
        };
        let known = errors(2.0, 8.0);
        for (found, is_good) in [
            (errors(1.5, 6.0), Some(true)),
            (errors(2.0, 8.0), None),
            (errors(2.5, 10.0), None),
        ] {
            let answer = judged(("rigid", 1.0), JudgedBy::Runs, [&known, &found]);
            assert_eq!(answer.is_good, is_good, "{}", answer.text);
        }
        let better = judged(("rigid", 1.0), JudgedBy::Runs, [&known, &errors(1.5, 6.0)]);
        let says = "\"rigid\" errs by 6 mm over a stretch of 1 s on unseen runs, the nominal robot by 8 mm";
        assert!(better.text.contains(says), "{}", better.text);
        assert!(
            better.text.contains("odometry ends 0 mm off"),
            "{}",
            better.text
        );
        // No run was left out whose end could be judged.
        for by in [JudgedBy::EachRun, JudgedBy::EachStretch] {
            let text = judged(("rigid", 1.0), by, [&known, &known]).text;
            assert!(
                text.contains("odometry ends on the fitted runs 0 mm off"),
                "{text}"
            );
        }
    }

    #[test]
    fn what_no_wheel_of_its_size_does_is_doubted_and_so_is_what_would_be_set() {
        let far = Gains {
            ahead: value(1.09, 1.08, 1.1),
            ..Gains::default()
        };
        assert!(
            robot(&far)[0].contains("only ratios count"),
            "{:?}",
            robot(&far)
        );
        let radius = |own: f64| Value {
            value: own,
            ci95: [Some(own - 1e-4), Some(own + 1e-4)],
            unit: "m".to_owned(),
            nominal: 0.03,
        };
        let controller = |own: f64| Controller {
            kind: Some(ControllerKind::Mecanum),
            radius_m: Some(radius(own)),
            ..Controller::default()
        };
        assert_eq!(
            set(&controller(0.0327), &far),
            [
                "In mecanum_drive_controller set the wheel radius rho, `kinematics.wheels_radius`, to 32.7 mm (32.6 to 32.8) in place of 30 mm, if it \
              is the wheels that are larger."
            ]
        );
        assert_eq!(
            set(&controller(0.03005), &Gains::default()),
            [
                "In mecanum_drive_controller leave the wheel radius rho, `kinematics.wheels_radius`, at 30 mm (29.95 to 30.15)."
            ]
        );
    }
}
