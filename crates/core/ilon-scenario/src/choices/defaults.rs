//! Time steps that the program chooses if the scenario leaves them open.

use std::f64::consts::TAU;

use ilon_control::DynamicModel;
use ilon_robot::{Robot, Scale, Wheel};
use ilon_world::longest_step_of_springs_s;

use crate::Error;
use crate::scenario::{Contacts, Passive, Rollers, Scenario, WheelLaw};

// Times below are in the robot's unit sqrt(rho / g); a wheel of 50 mm has 14 of them per second. So
// robots of one shape and any size get similar steps, and slip alike.

/// The longest step on an open plane: 1/240 s for wheels of 50 mm. Mean motion is as accurate at 20
/// steps per second as at 1000, but the onset of sliding and the spin-up of a roller that takes
/// over are smeared over a step (`docs/measured.md`).
const LONGEST_ON_A_PLANE: f64 = 0.0584;
/// The longest step among walls and ramps, with modelled rollers, and without a limit on wheel
/// rates: 2 ms for wheels of 50 mm. Chosen.
const LONGEST_AMONG_WALLS: f64 = 0.0281;
/// The longest step of rigid rollers if the wheel is not a circle, or if they slide along their
/// axles: half a millisecond for wheels of 50 mm. Each roller lands, and the time of a landing is
/// only known to a step: at four times the step the heading is off by 0.3 %, the heat of sliding by
/// a quarter. The same on kerbs and uneven ground: at four times the step impacts are a tenth to
/// three quarters too strong, and what slides up to nine tenths too much; at this step an eighth of
/// the impacts and a seventh of what slides at most, except where it is chance who mounts.
const LONGEST_IN_LANDINGS: f64 = 7.01e-3;
/// The same if such wheels are redundant on a rigid chassis: an eighth of a millisecond for wheels
/// of 50 mm. The wheels of one diagonal land while the other carries, and their relative angles
/// then decide which diagonal carries next, on which half of its rollers. With landings known to
/// half a millisecond, a robot with crowned rollers turned by 2.6 % less after some seconds; with
/// this step the answer stays within 0.2 % (`docs/rollers.md`).
const LONGEST_IN_ROCKING: f64 = 1.7525e-3;
/// Smallest number of steps per passage of a roller over the ground: a roller that is skipped has
/// no effect at all. Chosen.
const STEPS_PER_PASSAGE: f64 = 6.0;
/// The shortest step that is chosen for a latency of wheel loops, half a millisecond for wheels of
/// 50 mm. Chosen.
const SHORTEST_FOR_LATENCY: f64 = 7.01e-3;
/// The longest step of late wheel loops, as a share of their latency: they then swing from 3 %
/// above the gain of shorter steps on, and in steps of the latency from 27 % above it on.
const OF_LATENCY: f64 = 0.4;
/// The parts into which a step is split while a roller slides or is about to, 0.1 ms for wheels of
/// 50 mm: a roller that takes over spins up within milliseconds, and the slip of a fast turn on the
/// edge of its grip is then within a tenth of its limit (`docs/measured.md`).
const SPLIT: f64 = 1.4e-3;
/// The shortest step that is chosen for a wheel rate limit, a millisecond for wheels of 50 mm. Many
/// files have a limit that no wheel reaches, in place of none; beyond this step the rate that the
/// scenario commands decides. Chosen.
const SHORTEST_FOR_LIMIT: f64 = 0.0141;
/// Largest phase of a robot's bouncing on the treads of its rollers per step, in radians, and the
/// shortest step that is chosen for them, half a millisecond for wheels of 50 mm. A hand-over takes
/// several such steps: in drives and turns at crowns of 1 to 1.5 on 2e4 to 1e6 N/m the end is right
/// to 0.03 % of the way, and slip of more than 0.1 J to 2 %. Stiffer treads are damped where the
/// step does not resolve them, and nearly rigid. Chosen.
const ON_TREADS: (f64, f64) = (0.18, 7.01e-3);
/// The same for tyres, which do not hand over. Chosen.
const ON_TYRES: (f64, f64) = (0.5, 0.0141);
/// The longest step if rapier solves the contacts, in seconds: its contacts have a natural
/// frequency of 1000 Hz.
const LONGEST_IN_RAPIER_S: f64 = 1e-3;
/// How much faster than commanded wheels may turn, by feedback, noise and overshoot. Chosen.
const FASTER_THAN_ASKED: f64 = 2.0;
/// The shortest step that is chosen, in seconds. Nothing that rolls needs a shorter one, and a
/// simulated second of it takes half a minute to compute; a scenario can still set one.
const SHORTEST_S: f64 = 1e-5;

/// The parts into which a step is split with `"auto"` while a roller is near its grip; `None` if
/// edges and bumps decide the step.
pub fn split_dt_s(scenario: &Scenario, robot: &Robot) -> Option<f64> {
    let by_ilon = scenario.world.solver.contacts == Contacts::Ilon;
    let serves = by_ilon && is_open_plane(scenario, robot);
    serves.then(|| SPLIT * scale_of(scenario, robot).time_s())
}

/// The robot's units under the scenario's gravity.
pub fn scale_of(scenario: &Scenario, robot: &Robot) -> Scale {
    Scale::of(robot, scenario.world.gravity_m_s2)
}

/// Whether only circular wheels, whatever the position of their rollers on the axles, roll on a
/// plane.
fn is_open_plane(scenario: &Scenario, robot: &Robot) -> bool {
    let floor = &scenario.world.floor;
    let round = scenario.robot.rollers == Rollers::Barrel && robot.wheels.iter().all(is_round);
    round && floor.is_plane()
}

/// Whether a wheel is a circle, whatever the position of its rollers on the axles.
fn is_round(wheel: &Wheel) -> bool {
    wheel.is_round() && wheel.surface.axial_play_m == 0.0
}

/// Whether wheels land on the ground again and again: it is uneven, or has an edge that they can
/// mount, lower than a wheel's radius.
fn is_bumpy(scenario: &Scenario, robot: &Robot) -> bool {
    let floor = &scenario.world.floor;
    let boxes = floor.boxes.iter().map(|one| one.height_m);
    let mut heights_m = boxes.chain(floor.stairs.iter().map(|one| one.rise_m));
    let radii_m = robot.wheels.iter().map(|wheel| wheel.radius_m);
    let most_m = radii_m.fold(0.0, f64::max);
    let is_even = floor.rough.is_none() && floor.height_map.is_none();
    !is_even || heights_m.any(|height_m| height_m < most_m)
}

/// The step that rollers need which land one after the other, and wheels on bumpy ground. Treads
/// soften the former.
fn landing_need(scenario: &Scenario, robot: &Robot, scale: &Scale) -> Need {
    let lands = |wheel: &Wheel| !is_round(wheel) && wheel.surface.tread.is_none();
    let rocks = |wheel: &Wheel| lands(wheel) && !wheel.is_round();
    let made = scenario.robot.rollers == Rollers::Barrel;
    let any = |of: &dyn Fn(&Wheel) -> bool| made && robot.wheels.iter().any(of);
    let longest = if robot.has_wheels_to_spare() && any(&rocks) {
        LONGEST_IN_ROCKING
    } else if any(&lands) || is_bumpy(scenario, robot) {
        LONGEST_IN_LANDINGS
    } else {
        f64::INFINITY
    };
    Need::of(longest * scale.time_s())
}

/// An upper limit of the step, and the key or joint that causes it.
struct Need {
    longest_s: f64,
    because: String,
    help: &'static str,
}

impl Need {
    /// A limit that is never too short, and so needs no explanation.
    fn of(longest_s: f64) -> Self {
        Self {
            longest_s,
            because: String::new(),
            help: "",
        }
    }
}

/// The physics step for `"auto"`, in seconds: the longest that serves the contacts, the passage of
/// rollers, the wheel loop and the pose sensor, shortened to divide the control period.
/// `asked_rad_s` is the fastest wheel rate that the scenario commands, if that is known.
///
/// # Errors
/// [`Error::Invalid`] with the cause, if the step would be shorter than the shortest chosen one.
pub fn physics_dt_s(
    scenario: &Scenario,
    robot: &Robot,
    model: &DynamicModel,
    asked_rad_s: Option<f64>,
) -> Result<f64, Error> {
    let scale = scale_of(scenario, robot);
    let needs = [
        contact_need(scenario, robot, (&scale, asked_rad_s)),
        landing_need(scenario, robot, &scale),
        solver_need(scenario),
        tread_need(robot, &scale),
        sliding_need(scenario, robot, &scale),
        spring_need(robot),
        pose_need(scenario),
    ];
    let shortest = needs
        .into_iter()
        .chain(loop_need(scenario, model, &scale))
        .min_by(|a, b| a.longest_s.total_cmp(&b.longest_s));
    // The step divides the period of the wheel loop, which divides the control period.
    let period_s = scenario.wheel_loop.period_s;
    let period_s = period_s.unwrap_or(scenario.run.control_dt_s);
    let longest_s = shortest.as_ref().map_or(period_s, |need| need.longest_s);
    if let Some(need) = shortest.filter(|need| need.longest_s < SHORTEST_S) {
        return Err(Error::invalid(
            format!(
                "`run.physics_dt_s` = \"auto\" comes to {:.1e} s, but the shortest automatic step is {SHORTEST_S:.0e} s: {}",
                need.longest_s, need.because
            ),
            need.help,
        ));
    }
    // A relative slack of 1e-9, so that a period that is a whole number of steps except for
    // rounding does not take one more.
    let steps = (period_s / longest_s - 1e-9).ceil().max(1.0);
    Ok(period_s / steps)
}

/// The limit by contacts: that of edges, or longer steps for exact rollers on an open plane with
/// bounded wheel rates.
fn contact_need(
    scenario: &Scenario,
    robot: &Robot,
    (scale, asked_rad_s): (&Scale, Option<f64>),
) -> Need {
    let [on_a_plane_s, default_s, for_limits_s] =
        [LONGEST_ON_A_PLANE, LONGEST_AMONG_WALLS, SHORTEST_FOR_LIMIT].map(|of| of * scale.time_s());
    let limit_rad_s = scenario
        .guidance
        .wheel_rate_limit_rad_s
        .unwrap_or(f64::INFINITY)
        .min(robot.wheel_rate_limit_rad_s());
    let rollers = robot.wheels.iter().map(|wheel| wheel.rollers.len()).max();
    let for_rate_s =
        |rate_rad_s: f64| TAU / (rollers.unwrap_or(1) as f64 * rate_rad_s) / STEPS_PER_PASSAGE;
    let longest_s = if is_open_plane(scenario, robot) && limit_rad_s.is_finite() {
        on_a_plane_s
    } else {
        default_s
    };
    let for_limit_s = for_rate_s(limit_rad_s);
    let (for_rates_s, because, help) = match asked_rad_s {
        _ if for_limit_s >= for_limits_s => (for_limit_s, String::new(), ""),
        Some(asked_rad_s) => {
            let rate_rad_s = limit_rad_s.min(FASTER_THAN_ASKED * asked_rad_s);
            let most_s = if limit_rad_s.is_finite() {
                for_limits_s
            } else {
                default_s
            };
            (
                for_rate_s(rate_rad_s).min(most_s),
                format!("the scenario asks for wheel rates of {asked_rad_s:.1e} rad/s"),
                "ask for a slower motion, or limit the wheels' rates: `guidance.wheel_rate_limit_rad_s`",
            )
        }
        // Without a limit nothing is known of the rates.
        None if limit_rad_s == f64::INFINITY => (f64::INFINITY, String::new(), ""),
        None => (
            for_limit_s,
            limited_by(scenario, robot, limit_rad_s),
            "write the rate that the wheels reach as `guidance.wheel_rate_limit_rad_s`, or a step: `run.physics_dt_s`",
        ),
    };
    Need {
        longest_s: longest_s.min(for_rates_s),
        because,
        help,
    }
}

/// The limit by rapier's contact solver: its sweeps satisfy the laws of contact only in short
/// steps.
fn solver_need(scenario: &Scenario) -> Need {
    Need::of(match scenario.world.solver.contacts {
        Contacts::Ilon => f64::INFINITY,
        Contacts::Rapier => LONGEST_IN_RAPIER_S,
    })
}

/// The limit by soft rollers and tyres: a step that resolves the robot's bouncing on them.
fn tread_need(robot: &Robot, scale: &Scale) -> Need {
    let (bounce_rad, shortest) = match robot.has_tyres() {
        true => ON_TYRES,
        false => ON_TREADS,
    };
    let wheels = robot.wheels.iter();
    let treads = wheels.filter_map(|wheel| wheel.surface.touching_tread(scale, robot.has_tyres()));
    let seen_s = treads.map(|tread| bounce_rad * (scale.load_kg / tread.stiffness_n_m).sqrt());
    let seen_s = seen_s.reduce(f64::min);
    Need::of(seen_s.map_or(f64::INFINITY, |seen_s| {
        seen_s.max(shortest * scale.time_s())
    }))
}

/// The limit by friction that changes within a step, for tyres, which slide all the time: where it
/// falls with sliding speed, it is that of the step's beginning, and steps of 2.5 ms missed 3.5 % of
/// the slip, this one 1 %; where tyres are steered, their sliding turns with them, and steps of 2.5
/// and 3.3 ms missed 3 to 6 % of the slip and 2 to 3 mm of 1.5 m, this one 0.5 to 2 % and 0.3 mm.
fn sliding_need(scenario: &Scenario, robot: &Robot, scale: &Scale) -> Need {
    let floor = &scenario.world.floor;
    let pairs = scenario.materials.values().flat_map(|with| with.values());
    let falls = floor.sliding.is_some()
        || floor.patches.iter().any(|patch| patch.sliding.is_some())
        || pairs.into_iter().any(|pair| pair.sliding.is_some());
    let steers = |wheel: &Wheel| wheel.has_tyre() && robot.steering_of(wheel).is_some();
    let turns = robot.wheels.iter().any(steers);
    Need::of(match turns || falls && robot.has_tyres() {
        true => ON_TYRES.1 * scale.time_s(),
        false => f64::INFINITY,
    })
}

/// The limit by springs and servos of joints: a step that can follow them. Accuracy demands no
/// more, because they stay stiff in longer steps.
fn spring_need(robot: &Robot) -> Need {
    let (longest_s, because) = match longest_step_of_springs_s(robot) {
        Some((longest_s, joint)) => {
            let name = &robot.joints[joint].name;
            (
                longest_s,
                format!("the joint `{name}` is held by as stiff a spring or servo"),
            )
        }
        None => (f64::INFINITY, String::new()),
    };
    Need {
        longest_s,
        because,
        help: "give it less stiffness, or hold the joint",
    }
}

/// The limit of the wheels' rates, in words.
fn limited_by(scenario: &Scenario, robot: &Robot, limit_rad_s: f64) -> String {
    let of_motor = |wheel: &&ilon_robot::Wheel| wheel.motor.velocity_rad_s <= limit_rad_s;
    match robot.wheels.iter().find(of_motor) {
        Some(wheel) => format!(
            "the joint `{}` may turn at {:.1e} rad/s, the velocity of its limit",
            wheel.name, wheel.motor.velocity_rad_s
        ),
        None => format!(
            "`guidance.wheel_rate_limit_rad_s` lets wheels turn at {:.1e} rad/s",
            scenario
                .guidance
                .wheel_rate_limit_rad_s
                .unwrap_or(limit_rad_s)
        ),
    }
}

/// At most one pose is taken per step.
fn pose_need(scenario: &Scenario) -> Need {
    let rate_hz = scenario.sensors.pose.rate_hz.unwrap_or(0.0);
    Need {
        longest_s: 1.0 / rate_hz,
        because: format!("`sensors.pose.rate_hz` = {rate_hz} asks for a pose in each step"),
        help: "take poses less often",
    }
}

/// The limit by the wheel loop: torques with a latency shall arrive in a later step than that of
/// their decision, and a passive law with given dampers is sampled once a step. Other loops have a
/// period of their own or act within the step.
fn loop_need(scenario: &Scenario, model: &DynamicModel, scale: &Scale) -> Option<Need> {
    let section = &scenario.wheel_loop;
    if section.law == WheelLaw::Passive && section.period_s.is_none() {
        return Some(damper_need(scenario, model));
    }
    section.is_late().then(|| {
        let latency_s = section.latency_s();
        Need {
            longest_s: (OF_LATENCY * latency_s).max(SHORTEST_FOR_LATENCY * scale.time_s()),
            because: format!("`wheel_loop.latency_s` = {latency_s} is as short"),
            help: "take a longer latency, or leave it out",
        }
    })
}

/// The limit by the dampers of a passive law: wheels in the air, which feel only their own inertia,
/// come to rest in several steps.
fn damper_need(scenario: &Scenario, model: &DynamicModel) -> Need {
    let section = scenario.wheel_loop.passive.as_ref();
    let most = |of: fn(&Passive) -> Option<f64>| section.and_then(of).unwrap_or(0.0);
    let lever_m = model
        .kinematics()
        .lever_m()
        .iter()
        .map(|m| m.abs())
        .fold(0.0, f64::max);
    let far = |wheel: &ilon_robot::Wheel| wheel.position_m().xy().norm();
    let wheels = model.kinematics().wheels().iter();
    let least_m = wheels.map(far).fold(f64::INFINITY, f64::min);
    // No wheel feels more than the whole damping at its lever.
    let heading_n_s_m = most(|p| p.heading_damping_n_m_s_rad) / (least_m * least_m);
    let along_n_s_m = most(|p| p.damping_n_s_m).max(heading_n_s_m);
    let felt_n_m_s = (lever_m * lever_m * along_n_s_m).max(most(|p| p.wheel_damping_n_m_s_rad));
    Need {
        longest_s: 0.5 * model.air_inertia_kg_m2() / felt_n_m_s,
        because: format!(
            "`[wheel_loop.passive]` damps wheels in the air by {felt_n_m_s} N m s/rad"
        ),
        help: "take less damping",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    const URDF: &str = include_str!("../../../../../assets/robots/mecanum4.urdf");

    fn chosen_s(lines: &str) -> f64 {
        chosen(URDF, lines, Some(6.0)).unwrap()
    }

    fn chosen(urdf: &str, lines: &str, asked_rad_s: Option<f64>) -> Result<f64, Error> {
        let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
        let text = format!("robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\n{lines}");
        let scenario = Scenario::from_toml(&text, "test", "").unwrap();
        let model = super::super::wheel_loop::dynamic_model(&robot).unwrap();
        physics_dt_s(&scenario, &robot, &model, asked_rad_s)
    }

    /// The robot with another limit on the rates of its wheels.
    fn limited_to(velocity: &str) -> String {
        URDF.replace("velocity=\"30\"", &format!("velocity=\"{velocity}\""))
    }

    #[test]
    fn the_chosen_step_divides_the_control_period_and_is_no_longer_than_the_longest() {
        for control_dt_s in [0.01, 1.0 / 30.0, 0.0007, 0.0123] {
            let dt_s = chosen_s(&format!("run.control_dt_s = {control_dt_s}"));
            let steps = control_dt_s / dt_s;
            assert!((steps - steps.round()).abs() < 1e-9 * steps);
            // sqrt(0.05 / 9.81) = 71.4 ms.
            assert!(dt_s <= LONGEST_ON_A_PLANE * 0.0714);
        }
    }

    #[test]
    fn on_a_plane_the_step_follows_the_rollers_that_pass() {
        let slow = "run.control_dt_s = 0.1\n";
        // Nine rollers at 10 rad/s: one passes in 2 pi / 90 = 69.8 ms, a sixth of which is longer
        // than 1/240 s; at the motors' 30 rad/s a sixth is 3.88 ms. 24 and 26 steps a control
        // period.
        let at = |limit_rad_s: f64| {
            chosen_s(&format!(
                "{slow}guidance.wheel_rate_limit_rad_s = {limit_rad_s}"
            ))
        };
        assert!((at(10.0) - 0.1 / 24.0).abs() < 1e-12);
        assert!((at(100.0) - 0.1 / 26.0).abs() < 1e-12);
        // Among walls, and with modelled rollers, the general step for contacts holds. A box lower
        // than the radius of 50 mm is a kerb on which wheels land, and uneven ground is like it.
        let box_of = |height_m: f64| {
            format!(
                "world.floor.boxes = [{{ x_m = 1.0, y_m = 0.0, length_x_m = 0.1, length_y_m = 1.0, height_m = {height_m} }}]\n"
            )
        };
        let rough =
            "world.floor.rough = { height_m = 0.002, cell_m = 0.02, side_m = 4.0 }\n".to_owned();
        for (floor, most_s) in [(box_of(0.06), 2e-3), (box_of(0.04), 5e-4), (rough, 5e-4)] {
            let dt_s = chosen_s(&format!("{slow}{floor}"));
            assert!((dt_s - most_s).abs() < 0.01 * most_s, "{floor}: {dt_s}");
        }
        let modelled = "robot.rollers = \"as_modelled\"\n";
        assert!((chosen_s(&format!("{modelled}{slow}")) - 0.002).abs() < 1e-12);
    }

    #[test]
    fn of_a_limit_that_no_wheel_reaches_what_is_asked_for_counts() {
        // At 116 rad/s nine rollers pass a sixth of the way in a millisecond: the shortest step for
        // a limit. A limit of 1e5 or 1e9 stands for none, and twice the commanded 6 rad/s need no
        // shorter step.
        for velocity in ["1000", "1e5", "1e9"] {
            let dt_s = chosen(&limited_to(velocity), "", Some(6.0)).unwrap();
            assert!((dt_s - 1e-3).abs() < 1e-12, "{velocity}: {dt_s}");
        }
        // 500 rad/s commanded, and as much again on top: 2 pi / (9 x 1000) / 6 = 0.116 ms; 86 such
        // steps divide 10 ms.
        let fast = chosen(&limited_to("1e9"), "", Some(500.0)).unwrap();
        assert_eq!((0.01 / fast).round(), 86.0);
        // Not faster than the limit: 2 pi / (9 x 600) / 6 = 0.194 ms.
        let limited = chosen(&limited_to("600"), "", Some(500.0)).unwrap();
        assert_eq!((0.01 / limited).round(), 52.0);
    }

    #[test]
    fn what_would_never_end_is_refused_with_what_makes_it_so() {
        let told = |urdf: &str, lines: &str, asked_rad_s| match chosen(urdf, lines, asked_rad_s) {
            Err(Error::Invalid { message, .. }) => message,
            other => panic!("{other:?}"),
        };
        // Under a caller's controller only the limit is known.
        let unknown = told(&limited_to("1e9"), "", None);
        assert!(
            unknown.ends_with(
                "the joint `front_left` may turn at 1.0e9 rad/s, the velocity of its limit"
            ),
            "{unknown}"
        );
        let guided = "guidance.wheel_rate_limit_rad_s = 1e8";
        let by_guidance = told(&limited_to("1e9"), guided, None);
        assert!(
            by_guidance.contains("`guidance.wheel_rate_limit_rad_s` lets"),
            "{by_guidance}"
        );
        let asked = told(&limited_to("1e9"), "", Some(1e7));
        assert!(
            asked.ends_with("asks for wheel rates of 1.0e7 rad/s"),
            "{asked}"
        );
        let poses = told(URDF, "sensors.pose.rate_hz = 1e9", Some(6.0));
        assert!(
            poses.contains("`sensors.pose.rate_hz` = 1000000000"),
            "{poses}"
        );
    }

    #[test]
    fn treads_get_a_step_that_sees_the_robot_bounce_on_them() {
        let mut robot = Robot::from_urdf_str(URDF, "mecanum4").unwrap();
        let longest_s = |robot: &mut Robot, stiffness_n_m: f64| {
            for wheel in &mut robot.wheels {
                wheel.surface.tread = Some(ilon_robot::Tread::new(stiffness_n_m));
            }
            tread_need(robot, &Scale::of(robot, 9.81)).longest_s
        };
        let scale = Scale::of(&robot, 9.81);
        assert_eq!(tread_need(&robot, &scale).longest_s, f64::INFINITY);
        // 11.36 kg on four wheels of 1e5 N/m: 0.18 sqrt(2.84 / 1e5) = 0.959 ms; nearly rigid ones
        // of 1e8 N/m get half a millisecond.
        assert!((longest_s(&mut robot, 1e5) - 0.959e-3).abs() < 1e-6);
        assert!((longest_s(&mut robot, 1e8) - 0.5e-3).abs() < 1e-5);
    }

    #[test]
    fn tyres_get_a_millisecond_on_ground_whose_friction_falls_with_speed() {
        let urdf = include_str!("../../../../../assets/robots/skid4.urdf");
        let robot = Robot::from_urdf_str(urdf, "skid4").unwrap();
        let falls = "sliding = { friction = 0.2, speed_m_s = 0.1 }";
        let need_s = |lines: &str| {
            let text = format!("robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\n{lines}");
            let scenario = Scenario::from_toml(&text, "test", "").unwrap();
            sliding_need(&scenario, &robot, &Scale::of(&robot, 9.81)).longest_s
        };
        let patch = "x_m = 1, y_m = 0, length_x_m = 1, length_y_m = 1, friction = 0.5";
        assert_eq!(need_s(""), f64::INFINITY);
        for lines in [
            format!("[world.floor]\n{falls}"),
            format!("[world.floor]\npatches = [{{ {patch}, {falls} }}]"),
            format!("[materials.rubber.ice]\nfriction = 0.5\n{falls}"),
        ] {
            // 0.0141 sqrt(0.05 to 0.15 m / 9.81 m/s^2).
            assert!((1e-3..1.8e-3).contains(&need_s(&lines)), "{lines}");
        }
    }

    #[test]
    fn stiff_springs_get_a_step_in_which_the_world_takes_them() {
        let text = include_str!("../../../../../assets/robots/mecanum4_sprung.urdf");
        let mut options = ilon_formats::LoadOptions::default();
        options.joints = ["front_left", "front_right", "rear_left", "rear_right"]
            .map(|wheel| {
                let free = ilon_formats::JointOptions {
                    role: Some(ilon_formats::RoleOption::Free),
                    ..ilon_formats::JointOptions::default()
                };
                (format!("{wheel}_spring"), free)
            })
            .into();
        let mut robot = Robot::from_urdf_str_with(text, "sprung.urdf", &options)
            .unwrap()
            .robot;
        let stiff = |robot: &mut Robot, stiffness: f64| {
            robot.joints[2].role = ilon_robot::JointRole::Sprung(ilon_robot::JointSpring {
                stiffness,
                rest: 0.0,
                preload: 0.0,
            });
            let need = spring_need(robot);
            let takes = |dt_s: f64| {
                let settings = ilon_world::Settings {
                    dt_s,
                    ..ilon_world::Settings::default()
                };
                let start = ilon_robot::Pose::default();
                let floor = ilon_world::Floor::default();
                ilon_world::World::new(&*robot, &floor, start, &settings).is_ok()
            };
            assert!(takes(0.999 * need.longest_s) && !takes(1.001 * need.longest_s));
            need
        };
        for stiffness in [1e5, 1e6, 1e7] {
            // The slide moves a carrier of 0.1 kg and a wheel of 0.34 kg with 9 rollers; a spring
            // makes that oscillate with a period of 2 pi sqrt(m / k).
            let mass_kg = robot.inertia_on_joint(2);
            let swing_s = TAU * (mass_kg / stiffness).sqrt();
            let need = stiff(&mut robot, stiffness);
            assert!((need.longest_s - swing_s / 1.5).abs() < 1e-12);
        }
        // A spring that needs less than the shortest step is refused by name.
        let need = stiff(&mut robot, 1e12);
        assert!(need.longest_s < SHORTEST_S && need.because.contains(&robot.joints[2].name));
    }

    #[test]
    fn rigid_rollers_that_land_get_steps_that_know_when() {
        let text = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1.0";
        let scenario = Scenario::from_toml(text, "test", "").unwrap();
        let mut robot = Robot::from_urdf_str(URDF, "mecanum4").unwrap();
        let longest_s =
            |robot: &Robot| landing_need(&scenario, robot, &Scale::of(robot, 9.81)).longest_s;
        assert_eq!(longest_s(&robot), f64::INFINITY);
        robot.wheels[1].surface.axial_play_m = 2e-4;
        // 0.00701 sqrt(0.05 / 9.81) s; a tread softens the landing.
        assert!((longest_s(&robot) - 5e-4).abs() < 1e-6);
        robot.wheels[1].surface.tread = Some(ilon_robot::Tread::new(1e5));
        assert_eq!(longest_s(&robot), f64::INFINITY);
        // Four crowned wheels on a rigid chassis rock; with three of them on the chassis and one on
        // a joint, the ground carries each.
        let crowned = ilon_robot::RollersAsMade {
            crown: 1.2,
            ..ilon_robot::RollersAsMade::default()
        };
        for wheel in &mut robot.wheels {
            wheel.surface = ilon_robot::RollerSurface::default();
            wheel.make_rollers(crowned.clone(), None).unwrap();
        }
        assert!((longest_s(&robot) - 1.25e-4).abs() < 1e-6);
        robot.wheels[1].carrier = Some(0);
        assert!((longest_s(&robot) - 5e-4).abs() < 1e-6);
    }

    #[test]
    fn poses_that_come_fast_find_a_step_each() {
        let dt_s = chosen_s("sensors.pose.rate_hz = 900.0");
        assert_eq!((0.01 / dt_s).round(), 9.0);
    }

    /// 10 ms in whole steps of at most two fifths of the latency, and of half a millisecond at
    /// least.
    #[test]
    fn late_torques_get_a_step_in_which_they_come_later() {
        for (latency_s, steps) in [(0.003, 9.0), (0.0012, 20.0), (1e-5, 20.0)] {
            let found_s = chosen_s(&format!("wheel_loop.latency_s = {latency_s}"));
            assert!(
                (found_s - 0.01 / steps).abs() < 1e-12,
                "{latency_s}: {found_s}"
            );
        }
    }
}
