//! Warnings about a scenario that can be run.

use ilon_control::{DynamicModel, Kinematics};
use ilon_robot::{Robot, Twist, Wheel, wrap_angle};
use ilon_trace::significant;

use crate::pilot::FeasibilityInTime;
use ilon_scenario::scenario::{
    Guidance, ReferencePoint, Saturation, Scenario, WheelLaw, WheelLoop,
};

/// No pair of materials of wheels and floors has a higher friction. Chosen.
const MOST_FRICTION: f64 = 2.0;

/// Axles less off their mean than this sine are parallel in a file with rounded angles. Chosen.
const TOE: f64 = 1e-3;

/// Warns of a floor with an implausible friction.
pub(crate) fn of_friction(scenario: &Scenario) -> Option<String> {
    let floor = &scenario.world.floor;
    let own = floor.material.is_none().then(|| floor.friction());
    let patches = floor.patches.iter().filter_map(|patch| patch.friction);
    let pairs = scenario.materials.values().flat_map(|on| on.values());
    let all = patches.chain(own).chain(pairs.map(|pair| pair.friction));
    let most = all.fold(0.0, f64::max);
    (most > MOST_FRICTION).then(|| {
        format!(
            "a friction of {most} is more than any floor has (rubber on dry concrete: about 1); nothing will ever slide"
        )
    })
}

/// Warns of faults and patches that begin after the end of the run.
pub(crate) fn of_what_comes_too_late(scenario: &Scenario) -> Vec<String> {
    let end_s = scenario.run.duration_s;
    let late = scenario
        .windows_s()
        .filter(|(_, from_s, _)| *from_s >= end_s);
    late.map(|(key, from_s, _)| {
        format!("`{key}` never happens: it begins at {from_s} s, and the run ends at {end_s} s")
    })
    .collect()
}

/// Warns of a bandwidth that was asked for, and that torques held over the loops' period do not
/// allow: more of it changes nothing. `chooses_gain`: the gain of a PID follows from it.
pub(crate) fn of_bandwidth(
    scenario: &Scenario,
    model: &DynamicModel,
    period_s: f64,
    chooses_gain: bool,
) -> Option<String> {
    let section = &scenario.wheel_loop;
    let asked_rad_s = section.bandwidth_rad_s;
    let acts_rad_s = match (section.law, section.proportional_n_m_s) {
        (WheelLaw::Pid, Some(gain)) if chooses_gain => gain / model.ground_inertia_kg_m2(),
        (WheelLaw::Pid | WheelLaw::Passive, _) => return None,
        _ => model.bandwidth_rad_s(asked_rad_s, period_s),
    };
    let is_default = asked_rad_s == WheelLoop::default().bandwidth_rad_s;
    (!is_default && acts_rad_s < 0.99 * asked_rad_s).then(|| {
        format!(
            "`wheel_loop.bandwidth_rad_s` = {} acts as {}: wheels that slide or hang in the air would swing under faster loops of this \
             period and latency; shorten these, or give no more",
            significant(asked_rad_s, 4),
            significant(acts_rad_s, 3)
        )
    })
}

/// Warns of a start heading that looks like one in radians.
pub(crate) fn of_heading(scenario: &Scenario) -> Option<String> {
    /// Tolerance for written values of pi / 4 and its multiples, in radians. Chosen.
    const NEAR_RAD: f64 = 6e-3;
    /// A whole turn, in radians.
    const MOST_RAD: f64 = 6.3;
    let heading = scenario.robot.heading_deg;
    let eighths = heading / std::f64::consts::FRAC_PI_4;
    let off_rad = (eighths - eighths.round()).abs() * std::f64::consts::FRAC_PI_4;
    let is_odd = heading.fract() != 0.0 && heading.abs() < MOST_RAD && off_rad < NEAR_RAD;
    (is_odd && eighths.round() != 0.0).then(|| {
        format!(
            "`robot.heading_deg` = {heading} is in degrees: if an angle in radians is meant, it is {:.0}",
            45.0 * eighths.round()
        )
    })
}

/// Warns of an open-loop motion that exceeds the wheels' limit. `held` has the fastest commanded
/// twist and the same after saturation; `None` for wheel rates of a log.
pub(crate) fn of_twist(
    asked_rad_s: f64,
    limit_rad_s: f64,
    saturation: Option<Saturation>,
    held: Option<[Twist; 2]>,
) -> Option<String> {
    if asked_rad_s <= limit_rad_s * (1.0 + 1e-9) {
        return None;
    }
    let what = match saturation {
        None => "the log asks for wheel rates",
        Some(_) => "the commanded twist needs wheel rates",
    };
    let comes = match saturation {
        Some(Saturation::Prioritised | Saturation::Scale) => scaled(held),
        Some(Saturation::Clip) => format!("each wheel is clipped to that by itself{}", bent(held)),
        Some(Saturation::None) => {
            "the command is not limited to that, and the wheels turn as fast as their motors can"
                .to_owned()
        }
        None => "rates of a log are not limited, and the wheels turn as fast as their motors can"
            .to_owned(),
    };
    let units = match asked_rad_s > 5.0 * limit_rad_s {
        true => " (twists are in m/s and rad/s, not in mm/s or deg/s)",
        false => "",
    };
    Some(format!(
        "{what} of {asked_rad_s:.3} rad/s, but the limit is {limit_rad_s:.3} rad/s{units}: {comes}; command less or raise \
         `guidance.wheel_rate_limit_rad_s`"
    ))
}

/// Describes a twist that was scaled down: all of it, or only what has the lower priority.
fn scaled(held: Option<[Twist; 2]>) -> String {
    /// Shares that differ by less are one. Chosen.
    const SAME: f64 = 1e-6;
    let shares = held.map(|[asked, left]| {
        [
            left.linear_m_s().norm() / asked.linear_m_s().norm(),
            (left.omega_rad_s / asked.omega_rad_s).abs(),
        ]
    });
    let (part, share, rest) = match shares {
        Some([moved, turned]) if moved < turned - SAME => ("translation", moved, "turn"),
        Some([moved, turned]) if turned < moved - SAME => ("turn", turned, "translation"),
        _ => return "it is scaled down to that".to_owned(),
    };
    format!(
        "{:.1} % of its {part} is left, for its {rest} comes first",
        100.0 * share
    )
}

/// Describes a twist whose wheels were clipped one by one.
fn bent(held: Option<[Twist; 2]>) -> String {
    let Some([asked, left]) = held else {
        return ", which bends the motion".to_owned();
    };
    let heading = |twist: Twist| libm::atan2(twist.vy_m_s, twist.vx_m_s);
    let turned_rad = wrap_angle(heading(left) - heading(asked));
    let turns = match asked.linear_m_s().norm() > 0.0 {
        true => format!(
            ", and the direction turns by {:.2} deg",
            turned_rad.to_degrees().abs()
        ),
        false => String::new(),
    };
    format!(
        ": ({:.3}, {:.3}) m/s and {:.3} rad/s are left of ({:.3}, {:.3}) m/s and {:.3} rad/s{turns}",
        left.vx_m_s, left.vy_m_s, left.omega_rad_s, asked.vx_m_s, asked.vy_m_s, asked.omega_rad_s
    )
}

/// Warns of unsteered tyres whose axles are not quite parallel.
pub(crate) fn of_toe(robot: &Robot, kinematics: &Kinematics) -> Option<String> {
    let toe = kinematics.toe();
    let is_fixed =
        |of: &&Wheel| of.has_tyre() && robot.steering_of(of).is_none() && !robot.swivels(of);
    let fixed = robot.wheels.iter().filter(is_fixed);
    let names: Vec<String> = fixed.map(|of| format!("`{}`", of.name)).collect();
    // The rounding of a file's angles counts for nothing.
    (toe > TOE).then(|| {
        format!(
            "axles of {} are up to {:.2} deg off their mean (toe), so that these tyres scrub as they roll: of a twist the part along the mean axle is left out, \
             and the wheels are commanded for the rest",
            names.join(", "),
            libm::asin(toe).to_degrees()
        )
    })
}

/// The first key set that the tracking law of robots which cannot move sideways does not look at.
pub(crate) fn unused_by_tracking(guidance: &Guidance) -> Option<&'static str> {
    let usual = Guidance::default();
    let keys = [
        ("tasks", !guidance.tasks.is_empty()),
        (
            "position_gain_matrix_per_s",
            guidance.position_gain_matrix_per_s.is_some(),
        ),
        (
            "heading_gain_per_s",
            guidance.heading_gain_per_s != usual.heading_gain_per_s,
        ),
        (
            "reference_point",
            guidance.reference_point != usual.reference_point,
        ),
    ];
    keys.into_iter()
        .find_map(|(key, is_set)| is_set.then_some(key))
}

/// Warns of guidance keys that an open-loop motion ignores, because it has a single task.
pub(crate) fn of_guidance_in_open_loop(scenario: &Scenario) -> Option<String> {
    let guidance = &scenario.guidance;
    let keys = [
        ("tasks", !guidance.tasks.is_empty()),
        (
            "position_gain_matrix_per_s",
            guidance.position_gain_matrix_per_s.is_some(),
        ),
        (
            "reference_point",
            guidance.reference_point != ReferencePoint::default(),
        ),
        (
            "priority",
            guidance.priority.is_some() && guidance.saturation != Saturation::Prioritised,
        ),
    ];
    let set = keys.into_iter().filter(|(_, is_set)| *is_set);
    let set: Vec<String> = set.map(|(key, _)| format!("`guidance.{key}`")).collect();
    (!set.is_empty()).then(|| {
        let verb = if set.len() == 1 { "has" } else { "have" };
        format!(
            "{} {verb} no effect without a reference; of a twist, `guidance.priority` under `saturation = \"prioritised\"` says which part gives way last",
            set.join(" and ")
        )
    })
}

/// Warns of a reference that exceeds the wheels' rates, or may: its start, its largest demand, and
/// the time of that.
pub(crate) fn of_feasibility(feasibility: &FeasibilityInTime, robot: &Robot) -> Option<String> {
    const REMEDY: &str = "slow it down or raise `guidance.wheel_rate_limit_rad_s`";
    if let Some((from_s, at_s, asked)) = feasibility.saturates {
        return Some(format!(
            "the reference cannot be followed from {from_s:.2} s on: at {at_s:.2} s it takes {:.3} rad/s of wheel `{}`, which can be given \
             {:.3} rad/s, and nothing is left for errors (Indiveri 2009, eqs. (36), (37)); {REMEDY}",
            asked.rate_rad_s.abs(),
            robot.wheels[asked.wheel].name,
            asked.limit_rad_s
        ));
    }
    let conditions = [
        (
            &feasibility.position,
            "velocity alone takes, in the direction that asks most of the wheels,",
            "(36)",
        ),
        (&feasibility.heading, "heading rate alone takes", "(37)"),
    ];
    let parts = conditions.into_iter().filter_map(|(asked, what, equation)| {
        let from_s = asked.beyond_from_s?;
        Some(format!(
            "from {from_s:.2} s on its {what} wheel rates of up to {:.3} rad/s, at {:.2} s (Indiveri 2009, eq. {equation})",
            asked.most_rad_s, asked.most_at_s
        ))
    });
    let parts: Vec<String> = parts.collect();
    (!parts.is_empty()).then(|| {
        format!(
            "the reference may be too fast to track: {}, but half of the limit is {:.3} rad/s; {REMEDY}",
            parts.join(", and "),
            0.5 * feasibility.limit_rad_s
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_floor(toml: &str) -> Option<String> {
        let text = format!(
            "[robot]\nfile = 'r.urdf'\n[twist]\nvx_m_s = 0.1\n[run]\nduration_s = 1\n[world.floor]\n{toml}"
        );
        of_friction(&Scenario::from_toml(&text, "s", ".").expect("a scenario"))
    }

    #[test]
    fn friction_that_no_floor_has_is_remarked_wherever_it_is() {
        assert_eq!(of_floor("friction = 1.2"), None);
        assert!(of_floor("friction = 20").is_some());
        let patch =
            "patches = [{ x_m = 0, y_m = 0, length_x_m = 1, length_y_m = 1, friction = 3 }]";
        assert!(of_floor(patch).is_some());
    }

    #[test]
    fn a_heading_in_radians_is_remarked() {
        let of = |heading_deg: &str| {
            let text = format!(
                "robot = {{ file = 'r.urdf', heading_deg = {heading_deg} }}\ntwist.vx_m_s = 0.1\nrun.duration_s = 1"
            );
            of_heading(&Scenario::from_toml(&text, "s", ".").expect("a scenario"))
        };
        for (written, degrees) in [
            ("1.57", "is 90"),
            ("-0.785", "is -45"),
            ("3.14159", "is 180"),
        ] {
            assert!(
                of(written).is_some_and(|text| text.ends_with(degrees)),
                "{written}"
            );
        }
        for plain in ["0", "1", "3", "1.5", "45", "0.001", "90.0"] {
            assert_eq!(of(plain), None, "{plain}");
        }
    }

    #[test]
    fn a_twist_is_remarked_when_it_is_too_fast_with_what_comes_of_it() {
        let of = |asked, limit, saturation| of_twist(asked, limit, saturation, None);
        let scaled = Some(Saturation::Prioritised);
        assert_eq!(of(10.0, 10.0, scaled), None);
        assert_eq!(of(10.0, f64::INFINITY, scaled), None);
        assert!(of(10.1, 10.0, scaled).is_some_and(|text| text.contains("10.100")));
        let words = [
            (scaled, "scaled down"),
            (
                Some(Saturation::Clip),
                "clipped to that by itself, which bends",
            ),
            (Some(Saturation::None), "the command is not limited"),
            (None, "rates of a log are not limited"),
        ];
        for (saturation, words) in words {
            let said = of(10.1, 10.0, saturation).unwrap_or_default();
            assert!(said.contains(words), "{said}");
        }
        // Half of the translation for a whole turn, none of the turn for the translation, and both
        // alike.
        for (left, words) in [
            (
                Twist::new(0.5, 0.4, 2.0),
                "50.0 % of its translation is left, for its turn",
            ),
            (
                Twist::new(1.0, 0.8, 0.0),
                "0.0 % of its turn is left, for its translation",
            ),
            (Twist::new(0.5, 0.4, 1.0), "it is scaled down to that"),
        ] {
            let held = Some([Twist::new(1.0, 0.8, 2.0), left]);
            let said = of_twist(36.0, 30.0, scaled, held).unwrap_or_default();
            assert!(said.contains(words), "{said}");
        }
        // A robot that is asked for no turn has none to keep.
        let held = Some([Twist::new(1.0, 0.8, 0.0), Twist::new(0.5, 0.4, 0.0)]);
        let said = of_twist(36.0, 30.0, scaled, held).unwrap_or_default();
        assert!(said.contains("it is scaled down to that"), "{said}");
        // (1, 0.8) m/s of wheels that turn at 4, 36, 36 and 4 rad/s, held to 30: (0.85, 0.65) m/s.
        // Its direction is atan 0.65 / 0.85 = 37.41 deg and was atan 0.8 = 38.66 deg.
        let held = [Twist::new(1.0, 0.8, 0.0), Twist::new(0.85, 0.65, 0.0)];
        let said = of_twist(36.0, 30.0, Some(Saturation::Clip), Some(held)).unwrap_or_default();
        assert!(
            said.contains("(0.850, 0.650) m/s") && said.contains("turns by 1.25 deg"),
            "{said}"
        );
    }

    #[test]
    fn keys_that_a_motion_in_open_loop_does_not_look_at_are_remarked() {
        let of = |guidance: &str| {
            let text = format!(
                "robot.file = 'r.urdf'\ntwist.vx_m_s = 0.1\nrun.duration_s = 1\n[guidance]\n{guidance}"
            );
            of_guidance_in_open_loop(&Scenario::from_toml(&text, "s", ".").expect("a scenario"))
        };
        assert_eq!(of("saturation = 'clip'"), None);
        assert_eq!(of("priority = 'heading'"), None);
        let said = of("priority = 'heading'\nsaturation = 'clip'").unwrap_or_default();
        assert!(
            said.starts_with("`guidance.priority` has no effect"),
            "{said}"
        );
        let said = of("tasks = ['heading_feedback']").unwrap_or_default();
        assert!(said.starts_with("`guidance.tasks` has no effect"), "{said}");
    }
}
