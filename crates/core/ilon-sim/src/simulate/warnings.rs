//! What a person should know of a run although it could be run: before it, of what was asked for, and after it, of what came.

use ilon_robot::{BodyJoint, JointKind, Robot, Twist, wrap_angle};
use ilon_trace::metrics::Energy;
use ilon_trace::quantities::{self, Measure};
use ilon_trace::{Convergence, Quantity, Summary, Twin};
use ilon_world::{FreeBodyId, World};

use super::pilot::FeasibilityInTime;
use crate::scenario::{Priority, ReferencePoint, Saturation, Scenario};

/// No two materials that wheels and floors are made of grip better.
const MOST_FRICTION: f64 = 2.0;

/// A contact that misses its law by more than this, in m/s, is no rigid contact any more.
const WORST_RESIDUAL_M_S: f64 = 1e-3;

/// Energy that is missing from the balance, or too much in it, beyond this share of what was turned over means that something was not
/// resolved by the step. So does a loss that falls below zero by as much.
const WORST_UNEXPLAINED: f64 = 0.01;

/// Wheels whose rates are off by this share of the fastest that is asked for do not just lag: their loops swing, where they cannot settle.
const SWINGING: f64 = 0.05;

/// A wheel that is in the air for more than this part of the run does not carry the robot.
const MOST_AIRBORNE: f64 = 0.5;

/// Of a floor that grips like none there is.
pub(super) fn of_friction(scenario: &Scenario) -> Option<String> {
    let floor = &scenario.world.floor;
    let own = floor.material.is_none().then(|| floor.friction());
    let patches = floor.patches.iter().filter_map(|patch| patch.friction);
    let pairs = scenario.materials.values().flat_map(|on| on.values());
    let all = patches.chain(own).chain(pairs.map(|pair| pair.friction));
    let most = all.fold(0.0, f64::max);
    (most > MOST_FRICTION).then(|| {
        format!(
            "a friction of {most} is beyond that of any floor: rubber on dry concrete has about 1; nothing will ever slide"
        )
    })
}

/// Of how far the joints between bodies have moved from zero where the robot stands at the start: what its springs give way by.
pub(super) fn of_joints(robot: &Robot, positions: &[f64]) -> Option<String> {
    let place = |(joint, position): (&BodyJoint, &f64)| match joint.kind {
        JointKind::Turns => format!("`{}` at {position:.4} rad", joint.name),
        JointKind::Slides => format!("`{}` at {:.2} mm", joint.name, 1e3 * position),
    };
    let places: Vec<String> = robot.joints.iter().zip(positions).map(place).collect();
    (!places.is_empty()).then(|| {
        format!(
            "before it drives, the robot stands in equilibrium of springs, stops and ground with its joints {}",
            places.join(", ")
        )
    })
}

/// Of faults and patches that begin when the run is over.
pub(super) fn of_what_comes_too_late(scenario: &Scenario) -> Vec<String> {
    let end_s = scenario.run.duration_s;
    let late = scenario
        .windows_s()
        .filter(|(_, from_s, _)| *from_s >= end_s);
    late.map(|(key, from_s, _)| {
        format!("`{key}` never happens: it begins at {from_s} s, and the run ends at {end_s} s")
    })
    .collect()
}

/// Of a heading at the start that looks like one in radians.
pub(super) fn of_heading(scenario: &Scenario) -> Option<String> {
    /// Within what a person writes of pi / 4 and its multiples, in radians.
    const NEAR_RAD: f64 = 6e-3;
    /// A whole turn.
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

/// Of a motion in open loop that takes more than the wheels' limit, with the result: of a twist what saturation makes of it, `None` of rates that a
/// log asks for. `held` is the fastest twist asked for and what is left of it.
pub(super) fn of_twist(
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
        Some(Saturation::Prioritised | Saturation::Scale) => "it is scaled down to that".to_owned(),
        Some(Saturation::Clip) => format!("each wheel is clipped to that by itself{}", bent(held)),
        Some(Saturation::None) => {
            "nothing holds the command to that, and the wheels turn as fast as their motors let them".to_owned()
        }
        None => "rates of a log are commanded as they are, and the wheels turn as fast as their motors let them".to_owned(),
    };
    Some(format!(
        "{what} of {asked_rad_s:.3} rad/s, but the limit is {limit_rad_s:.3} rad/s: {comes}; command less or raise \
         `guidance.wheel_rate_limit_rad_s`"
    ))
}

/// What is left of a twist whose wheels were clipped one by one.
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

/// Of keys of the guidance that are set and that a motion in open loop does not look at: it has one task alone.
pub(super) fn of_guidance_in_open_loop(scenario: &Scenario) -> Option<String> {
    let guidance = &scenario.guidance;
    let keys = [
        ("priority", guidance.priority != Priority::default()),
        ("tasks", !guidance.tasks.is_empty()),
        (
            "position_gain_matrix_per_s",
            guidance.position_gain_matrix_per_s.is_some(),
        ),
        (
            "reference_point",
            guidance.reference_point != ReferencePoint::default(),
        ),
    ];
    let set = keys.into_iter().filter(|(_, is_set)| *is_set);
    let set: Vec<String> = set.map(|(key, _)| format!("`guidance.{key}`")).collect();
    (!set.is_empty()).then(|| {
        let verb = if set.len() == 1 { "has" } else { "have" };
        format!(
            "{} {verb} no effect without a reference: all of the motion asked for is one task, which saturation slows as a whole; to keep one part of it first, follow \
             a `[reference]` under `guidance.priority` or `guidance.tasks`",
            set.join(" and ")
        )
    })
}

/// Of a reference that takes more than the wheels' rates allow, or may: from when on, how much at most, and when.
pub(super) fn of_feasibility(feasibility: &FeasibilityInTime, robot: &Robot) -> Option<String> {
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
        (&feasibility.position, "velocity", "(36)"),
        (&feasibility.heading, "heading rate", "(37)"),
    ];
    let parts = conditions.into_iter().filter_map(|(asked, what, equation)| {
        let from_s = asked.beyond_from_s?;
        Some(format!(
            "from {from_s:.2} s on its {what} alone takes wheel rates of up to {:.3} rad/s, at {:.2} s (Indiveri 2009, eq. {equation})",
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

/// Of free bodies that were too heavy for what they lay on.
pub(super) fn of_bodies(robot: &Robot, world: &World) -> Vec<String> {
    /// What is pressed deeper than this, in wheel radii, was carried by nothing.
    const DEEP: f64 = 0.1;
    let radii_m = robot.wheels.iter().map(|wheel| wheel.radius_m);
    let deep_m = DEEP * radii_m.fold(f64::INFINITY, f64::min);
    let remark = |id: &FreeBodyId| {
        let pressed_m = world.free_body(*id)?.pressed_m;
        let name = world.free_body_name(*id)?;
        (pressed_m > deep_m).then(|| {
            format!(
                "body `{name}` and what it touched were pressed {:.1} mm into one another: contacts of this stiffness do not bear it; make it lighter \
                 or slower, or raise `world.solver.contact_stiffness_n_m`",
                1e3 * pressed_m
            )
        })
    };
    world.free_bodies().iter().filter_map(remark).collect()
}

/// Of what came of the run.
pub(super) fn of_summary(summary: &Summary, has_unstable_loops: bool) -> Vec<String> {
    let mut remarks = Vec::new();
    if let (true, Some(off_rad_s), Some(most_rad_s)) = (
        has_unstable_loops,
        summary.wheel_rate_error_rms_rad_s,
        summary.wheel_rate_command_max_rad_s,
    ) && off_rad_s > SWINGING * most_rad_s
    {
        remarks.push(format!(
            "the wheel loops swung: wheels were {off_rad_s:.2} rad/s off their targets (rms), up to {most_rad_s:.2} rad/s; what slid, and how far \
             the robot was off, comes from gains that are unstable at this step, and not from the floor"
        ));
    }
    remarks.extend(of_wheels_in_the_air(summary));
    if let Some(residual_m_s) = summary.contact_residual_max_m_s
        && residual_m_s > WORST_RESIDUAL_M_S
    {
        remarks.push(format!(
            "the contacts could not all be solved: the worst missed its law by {:.2} mm/s in a step; what happened then is \
             uncertain by as much (column `contact_residual_m_s`); a shorter `run.physics_dt_s` may help",
            1e3 * residual_m_s
        ));
    }
    remarks.extend(of_energy(&summary.energy));
    remarks
}

/// Of wheels that were in the air for most of the run: of one or two that do not carry the robot, or of so many that it hops.
fn of_wheels_in_the_air(summary: &Summary) -> Option<String> {
    let wheels = summary.wheels.iter();
    let aloft = wheels.filter_map(|wheel| {
        let share = wheel.lost_contact.filter(|share| *share > MOST_AIRBORNE)?;
        Some(format!("`{}` for {:.0} %", wheel.name, 100.0 * share))
    });
    let aloft: Vec<String> = aloft.collect();
    // Two wheels or fewer carry nothing: the others carry the robot in turn.
    let hops = aloft.len() + 2 > summary.wheels.len();
    let what = match (aloft.len(), hops) {
        (0, _) => return None,
        (_, true) => "the robot hops from wheel to wheel, which carry it in turn",
        (1, false) => "it does not carry the robot",
        (_, false) => "they do not carry the robot",
    };
    Some(format!(
        "in the air were, of the run, {}: {what}",
        aloft.join(", ")
    ))
}

/// Of energies that do not add up, and of losses that gave energy.
fn of_energy(energy: &Energy) -> Vec<String> {
    const REMEDY: &str = "the step does not resolve what happened, or the wheel loops are stiffer than can be computed with; shorten \
                          `run.physics_dt_s` or lower `wheel_loop.bandwidth_rad_s`";
    let mut remarks = Vec::new();
    if let Some(share) = energy.unexplained_share
        && share.abs() > WORST_UNEXPLAINED
    {
        remarks.push(format!(
            "the energies do not close: {:.1} % of what motors, pushes and gravity put in is unaccounted for: {REMEDY}",
            100.0 * share
        ));
    }
    let [motor_j, drove_j, outside_j, stored_j] = [
        energy.motor_j,
        energy.motor_positive_j,
        energy.outside_j,
        energy.stored_j,
    ]
    .map(|joules| joules.unwrap_or(0.0));
    let losses = [
        ("sliding", energy.slip_j),
        ("spinning rollers up", energy.spin_up_j),
        ("bearings and gears", energy.bearing_j),
        ("impacts", energy.impact_j),
    ];
    let losses = losses.map(|(what, lost_j)| (what, lost_j.unwrap_or(0.0)));
    let sizes = losses.iter().map(|(_, lost_j)| lost_j.abs());
    let rounding_j = WORST_UNEXPLAINED * sizes.fold(drove_j + outside_j.abs(), f64::max);
    for (what, lost_j) in losses {
        if lost_j < -rounding_j {
            remarks.push(format!(
                "a loss gave energy: {what} took {lost_j:.4} J, which cannot be: {REMEDY}"
            ));
        }
    }
    let (slip_j, there_j) = (losses[0].1, motor_j + outside_j - stored_j);
    if slip_j > there_j + rounding_j {
        remarks.push(format!(
            "sliding took {slip_j:.4} J, more than the {there_j:.4} J that were there to be lost: {REMEDY}"
        ));
    }
    remarks
}

/// Of figures that move at half the step by more than their stated accuracy, and of a run that could not be repeated at it. Where nobody asked, only of
/// where the robot goes.
pub(super) fn of_convergence(
    converge: &Convergence,
    twins: &[Twin],
    was_asked: bool,
) -> Vec<String> {
    let halves = twins.iter().filter(|twin| twin.change.is_noise());
    let failed = halves.filter_map(|twin| twin.error.as_ref());
    let mut remarks: Vec<String> = failed
        .map(|error| format!("the run could not be repeated at half its step: {error}"))
        .collect();
    let words = |(quantity, moved): (&Quantity, &ilon_trace::convergence::Moved)| {
        format!("{} by {:.2} %", quantity.words(), 100.0 * moved.share)
    };
    let goes = |quantity: &Quantity| {
        quantities::accuracy(quantity.key).is_some_and(|accuracy| accuracy.of != Measure::Itself)
    };
    let beyond = converge
        .beyond()
        .filter(|(quantity, _)| was_asked || goes(quantity));
    let beyond: Vec<String> = beyond.map(words).collect();
    if !beyond.is_empty() {
        remarks.push(format!(
            "at half the step figures move by more than their stated accuracy: {}; a shorter `run.physics_dt_s`, or a shorter \
             `world.solver.split_dt_s`, brings them closer",
            beyond.join(", ")
        ));
    }
    remarks
}

#[cfg(test)]
mod tests {
    use ilon_trace::slip::WheelSlip;

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
            (Some(Saturation::None), "nothing holds the command"),
            (None, "rates of a log are commanded as they are"),
        ];
        for (saturation, words) in words {
            let said = of(10.1, 10.0, saturation).unwrap_or_default();
            assert!(said.contains(words), "{said}");
        }
        // (1, 0.8) m/s of wheels that turn at 4, 36, 36 and 4 rad/s, held to 30: (0.85, 0.65) m/s. Its direction is atan 0.65 / 0.85 = 37.41 deg
        // and was atan 0.8 = 38.66 deg.
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
        let said = of("priority = 'heading'").unwrap_or_default();
        assert!(
            said.starts_with("`guidance.priority` has no effect"),
            "{said}"
        );
    }

    #[test]
    fn a_wheel_in_the_air_and_unsolved_contacts_are_remarked_with_their_figures() {
        let wheel = |name: &str, lost| {
            let mut wheel = WheelSlip::default();
            wheel.name = name.to_owned();
            wheel.lost_contact = Some(lost);
            wheel
        };
        let mut summary = Summary::default();
        summary.wheels = ["left", "right", "front"]
            .map(|name| wheel(name, 0.02))
            .into();
        summary.wheels.push(wheel("rear", 1.0));
        summary.contact_residual_max_m_s = Some(1e-8);
        let [remark] = &of_summary(&summary, false)[..] else {
            panic!("one wheel does not touch");
        };
        assert!(
            remark.contains("`rear` for 100 %") && remark.ends_with("it does not carry the robot"),
            "{remark}"
        );
        for wheel in &mut summary.wheels {
            wheel.lost_contact = Some(0.6);
        }
        // None of them carries the robot all the time, and together they do.
        let [hops] = &of_summary(&summary, false)[..] else {
            panic!("one remark for all");
        };
        assert!(
            hops.contains("hops") && !hops.contains("does not carry"),
            "{hops}"
        );
        summary.wheels.clear();
        summary.energy.unexplained_share = Some(0.004);
        summary.contact_residual_max_m_s = Some(0.02);
        assert!(of_summary(&summary, false)[0].contains("20.00 mm/s"));
        summary.contact_residual_max_m_s = None;
        summary.energy.unexplained_share = Some(-69.0);
        assert!(of_summary(&summary, false)[0].contains("-6900.0 %"));
    }

    /// A loss below zero by a hundredth of what the motors put in is no rounding, nor is sliding that took more than there was.
    #[test]
    fn losses_that_give_and_sliding_that_takes_more_than_there_is_are_remarked() {
        let remarks = |slip_j: f64, bearing_j: f64, impact_j: f64| {
            let mut energy = Energy::default();
            energy.motor_j = Some(0.7);
            energy.motor_positive_j = Some(1.0);
            energy.stored_j = Some(0.3);
            (energy.slip_j, energy.bearing_j) = (Some(slip_j), Some(bearing_j));
            energy.impact_j = Some(impact_j);
            of_energy(&energy)
        };
        assert!(remarks(0.25, 0.15, -0.005).is_empty());
        let [bearing] = &remarks(0.3, -4.7, 0.0)[..] else {
            panic!("a bearing that drives");
        };
        assert!(
            bearing.contains("bearings") && bearing.contains("-4.7"),
            "{bearing}"
        );
        assert_eq!(remarks(0.81, 0.13, -0.55).len(), 2);
    }

    #[test]
    fn loops_that_cannot_settle_are_named_where_wheels_are_far_off() {
        let mut summary = Summary::default();
        summary.wheel_rate_command_max_rad_s = Some(8.0);
        summary.wheel_rate_error_rms_rad_s = Some(0.1);
        assert!(of_summary(&summary, true).is_empty());
        summary.wheel_rate_error_rms_rad_s = Some(1.2);
        assert!(of_summary(&summary, true)[0].contains("swung"));
        assert!(of_summary(&summary, false).is_empty());
    }
}
