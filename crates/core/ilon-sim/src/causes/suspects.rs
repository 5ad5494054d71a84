//! The effect of common defects on a robot in standard motions, to compare with what a real robot
//! shows.

use std::f64::consts::TAU;
use std::sync::Arc;

use ilon_files::FileAccess;
use ilon_formats::RollerBearings;
use ilon_robot::{Pose, Robot, Twist, Wheel};
use ilon_trace::{Change, Summary};
use rayon::prelude::*;
use serde::Serialize;

use super::null::Null;
use super::path::Path;
use super::twin::{Limits, twin};
use crate::Error;
use crate::scenario::{Fault, MaterialPair, MotorStrength, Scenario, Setting};
use crate::simulate::{Resolved, resolve};
use crate::standard_motions::{MOTIONS, StandardMotion, standard_motions};

/// The effect of a defect in a motion: the robot's end pose with the defect minus that without it,
/// per metre of way or per turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Drift {
    /// Offset ahead along the heading of the healthy robot, in m/m or m/turn.
    pub ahead_m: f64,
    /// Offset to the left, in m/m or m/turn.
    pub left_m: f64,
    /// Rotation to the left, in rad/m or rad/turn.
    pub turned_rad: f64,
    /// Resolution in metres and radians: smaller effects cannot be told from zero.
    pub floor: [f64; 2],
}

/// A common defect of a robot, in a given amount.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Suspect {
    /// Its description with the amount.
    pub words: String,
    /// The wheel that has the defect, if it is one wheel's.
    pub wheel: Option<String>,
    /// Its effect in each of [`MOTIONS`](crate::standard_motions::MOTIONS); `None` if the robot
    /// could not be driven in it, or the motion was left out.
    pub drifts: Vec<Option<Drift>>,
    /// The sensible range of amounts, as multiples of the usual amount; negative if the defect can
    /// have the opposite sign.
    #[serde(skip)]
    pub times: (f64, f64),
}

/// The effect of each common defect in standard motions of one metre or one turn, under the
/// conditions in `settings`.
///
/// # Errors
/// If the robot cannot be driven, or a setting is invalid.
pub fn suspects(
    robot: &Robot,
    settings: &[Setting],
    files: &FileAccess,
) -> Result<Vec<Suspect>, Error> {
    let lengths = [Some(1.0); MOTIONS.len()];
    Ok(Lineup::of(robot, settings, files, lengths)?.at_usual_amounts())
}

/// The common defects of a robot, and the standard motions in which each can be tried in any
/// amount.
pub struct Lineup {
    robot: Robot,
    motions: Vec<Option<Motion>>,
    usual: Vec<Usual>,
}

impl Lineup {
    /// Drives each motion over its length in metres, or turns on the spot; motions with the length
    /// `None` are left out.
    ///
    /// # Errors
    /// If the robot cannot be driven, or a setting is invalid.
    pub fn of(
        robot: &Robot,
        settings: &[Setting],
        files: &FileAccess,
        lengths: [Option<f64>; MOTIONS.len()],
    ) -> Result<Self, Error> {
        Ok(Self {
            robot: robot.clone(),
            motions: motions(robot, settings, files, lengths)?,
            usual: usual(robot),
        })
    }

    /// Every defect in its usual amount.
    pub fn at_usual_amounts(&self) -> Vec<Suspect> {
        let all = (0..self.usual.len()).into_par_iter();
        all.map(|index| self.in_amount(index, 1.0)).collect()
    }

    /// Runs the motions with the defect at `index`, in `times` its usual amount.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn in_amount(&self, index: usize, times: f64) -> Suspect {
        let usual = &self.usual[index];
        let change: Null = Box::new({
            let apply = Arc::clone(&usual.apply);
            move |scenario, robot| apply(times, scenario, robot)
        });
        let motions = self.motions.par_iter();
        Suspect {
            words: (usual.words)(times),
            wheel: usual.wheel.clone(),
            drifts: motions
                .map(|motion| motion.as_ref()?.drift(&self.robot, &change))
                .collect(),
            times: usual.times,
        }
    }

    /// The offset of the robot without defects from the end of the commanded motion, in each
    /// motion: the effect of its rollers' geometry, its bearings and the conditions.
    pub fn healthy(&self) -> Vec<Option<Drift>> {
        let motions = self.motions.iter();
        motions
            .map(|motion| motion.as_ref().map(|motion| motion.healthy))
            .collect()
    }
}

/// A motion, and the path of the healthy robot in it.
struct Motion {
    resolved: Resolved,
    path: Path,
    /// Change of the end pose at half the step, in metres and radians.
    floor: [f64; 2],
    /// Its length in metres, or its number of turns.
    amount: f64,
    /// The healthy robot's drift from the command.
    healthy: Drift,
}

impl Motion {
    fn of(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        let resolved = resolve(scenario, robot)?;
        let (summary, path) = way(&resolved, robot, |_, _| ())?;
        let half_s = 0.5 * resolved.physics_dt_s();
        let (_, half) = way(&resolved, robot, |scenario, _| {
            scenario.run.physics_dt_s = crate::scenario::Step::Seconds(half_s);
        })?;
        let apart = path.apart(&half);
        // Smaller differences are rounding, in metres and radians.
        let floor = [apart.most_m.max(1e-5), apart.most_rad.max(1e-5)];
        let (_, amount) = amount(&summary);
        let floor_each = floor.map(|floor| ilon_trace::effects::FLOORS * floor / amount);
        Ok(Self {
            resolved,
            path,
            floor,
            amount,
            healthy: Drift {
                floor: floor_each,
                ..Drift::from_command(&summary).unwrap_or_default()
            },
        })
    }

    fn drift(&self, robot: &Robot, change: &Null) -> Option<Drift> {
        let (_, path) = way(&self.resolved, robot, change).ok()?;
        let apart = path.apart(&self.path);
        let each = |x: f64| x / self.amount;
        Some(Drift {
            ahead_m: each(apart.ahead_m),
            left_m: each(apart.left_m),
            turned_rad: each(apart.turned_rad),
            floor: self
                .floor
                .map(|floor| ilon_trace::effects::FLOORS * each(floor)),
        })
    }
}

/// Whether a robot was to turn on the spot, and how often it turned; else its way in metres. One
/// that hardly moved counts as if it had a twentieth of its command.
fn amount(summary: &Summary) -> (bool, f64) {
    let asked = summary.twist_asked_mean;
    let [way_m, turned_rad] = match asked {
        Some(asked) => [asked.linear_m_s().norm(), asked.omega_rad_s.abs()],
        None => [summary.travelled_m, summary.turned_rad],
    };
    let least = |rate: f64| asked.map_or(0.0, |_| 0.05 * rate * summary.duration_s);
    match way_m < 0.05 * turned_rad {
        true => (true, summary.turned_rad.max(least(turned_rad)) / TAU),
        false => (false, summary.travelled_m.max(least(way_m))),
    }
}

impl Drift {
    /// The offset of a robot that keeps its mean twist from the end of the commanded twist, per
    /// metre or turn; `None` without a command or without a mean.
    pub fn from_command(summary: &Summary) -> Option<Self> {
        let (asked, real) = (summary.twist_asked_mean?, summary.twist_mean?);
        let (stands, amount) = amount(summary);
        let speed = match stands {
            true => asked.omega_rad_s.abs() / TAU,
            false => asked.linear_m_s().norm(),
        };
        let lasts_s = amount / speed;
        let [there, here] = [asked, real].map(|twist| at_constant_twist(twist, lasts_s));
        let (sin, cos) = libm::sincos(there.heading_rad);
        let off_m = here.position_m() - there.position_m();
        Some(Self {
            ahead_m: (cos * off_m.x + sin * off_m.y) / amount,
            left_m: (cos * off_m.y - sin * off_m.x) / amount,
            turned_rad: (here.heading_rad - there.heading_rad) / amount,
            ..Self::default()
        })
    }
}

/// The pose that a body reaches from the origin at a constant twist in its own frame.
fn at_constant_twist(twist: Twist, lasts_s: f64) -> Pose {
    let angle = twist.omega_rad_s * lasts_s;
    // sin(a) / a and (1 - cos(a)) / a, with their limits at small a.
    let (along, across) = match angle.abs() < 1e-6 {
        true => (1.0, 0.5 * angle),
        false => (libm::sin(angle) / angle, (1.0 - libm::cos(angle)) / angle),
    };
    let (x, y) = (twist.vx_m_s * lasts_s, twist.vy_m_s * lasts_s);
    Pose {
        x_m: along * x - across * y,
        y_m: across * x + along * y,
        heading_rad: angle,
    }
}

/// The path and the figures of a changed robot.
fn way(
    resolved: &Resolved,
    robot: &Robot,
    change: impl FnOnce(&mut Scenario, &mut Robot),
) -> Result<(Summary, Path), Error> {
    let came = twin(resolved, robot, Change::WithoutAll, change, Limits::none());
    match came.map(|came| came.ran) {
        Some(Ok(ran)) => Ok(ran),
        Some(Err(error)) => Err(Error::invalid(
            format!("the robot cannot be driven in a standard motion: {error}"),
            "look at it with `ilon inspect`",
        )),
        None => Err(Error::invalid("the run was stopped", "run it again")),
    }
}

/// The standard motions of a robot, each driven over its length in metres or turns.
fn motions(
    robot: &Robot,
    settings: &[Setting],
    files: &FileAccess,
    lengths: [Option<f64>; MOTIONS.len()],
) -> Result<Vec<Option<Motion>>, Error> {
    let drive = |(motion, length): (&Option<StandardMotion>, &Option<f64>)| {
        let (Some(motion), Some(length)) = (motion, length) else {
            return Ok(None);
        };
        let text = format!(
            "robot = {{ file = \"\", roller_bodies = \"near\" }}\n{}",
            motion.over(*length).toml()
        );
        let scenario = Scenario::from_toml_with(&text, motion.name, "", settings, files)?;
        Motion::of(&scenario, robot).map(Some)
    };
    let all = standard_motions(robot)?;
    all.par_iter().zip(lengths.par_iter()).map(drive).collect()
}

/// Applies a defect to scenario and robot; the first argument is the multiple of its usual amount.
type Apply = Arc<dyn Fn(f64, &mut Scenario, &mut Robot) + Send + Sync>;

/// A common defect.
struct Usual {
    /// Its description at a multiple of the usual amount.
    words: Box<dyn Fn(f64) -> String + Send + Sync>,
    wheel: Option<String>,
    /// Whether only rollers have it.
    is_of_rollers: bool,
    /// The sensible range of multiples.
    times: (f64, f64),
    apply: Apply,
}

impl Usual {
    fn new(
        times: (f64, f64),
        words: impl Fn(f64) -> String + Send + Sync + 'static,
        apply: impl Fn(f64, &mut Scenario, &mut Robot) + Send + Sync + 'static,
    ) -> Self {
        Self {
            words: Box::new(words),
            wheel: None,
            is_of_rollers: false,
            times,
            apply: Arc::new(apply),
        }
    }

    fn of_rollers(self) -> Self {
        Self {
            is_of_rollers: true,
            ..self
        }
    }

    fn about(self, wheel: &str) -> Self {
        Self {
            wheel: Some(wheel.to_owned()),
            ..self
        }
    }
}

/// The magnitude of a number with two digits.
fn digits(x: f64) -> String {
    ilon_trace::number(ilon_trace::significant(x.abs(), 2))
}

/// One word for a positive and another for a negative amount.
fn either(times: f64, above: &'static str, below: &'static str) -> &'static str {
    if times < 0.0 { below } else { above }
}

/// All common defects.
fn usual(robot: &Robot) -> Vec<Usual> {
    // The centre of mass has to stay well between the wheels.
    let reach = |of: fn(&Wheel) -> f64| {
        let reaches = robot.wheels.iter().map(|wheel| of(wheel).abs());
        let times = 0.8 * reaches.fold(0.0, f64::max) / 0.05;
        (-times, times)
    };
    let mut suspects = vec![
        Usual::new(
            reach(|wheel| wheel.position_m().x),
            |times| {
                let way = either(times, "ahead", "back");
                format!("centre of mass {} cm further {way}", digits(5.0 * times))
            },
            |times, _, robot| robot.chassis.mass.center_of_mass_m.x += 0.05 * times,
        ),
        Usual::new(
            reach(|wheel| wheel.position_m().y),
            |times| {
                let way = either(times, "left", "right");
                format!(
                    "centre of mass {} cm further to the {way}",
                    digits(5.0 * times)
                )
            },
            |times, _, robot| robot.chassis.mass.center_of_mass_m.y += 0.05 * times,
        ),
        Usual::new(
            (0.0, 3.0),
            |times| match times == 1.0 {
                true => "dry bushings under all rollers".to_owned(),
                false => format!(
                    "bushings under all rollers with {} times the friction of dry ones",
                    digits(times)
                ),
            },
            |times, _, robot| {
                for wheel in &mut robot.wheels {
                    let radii = wheel.rollers.iter().map(|of| of.radius_m);
                    let radius_m = radii.fold(0.0, f64::max);
                    wheel.surface.axle_friction = times * RollerBearings::Bushings.axle_friction();
                    wheel.surface.axle_radius_m = RollerBearings::Bushings.axle_radius_m(radius_m);
                }
            },
        )
        .of_rollers(),
        Usual::new(
            (-5.0, 5.0),
            |times| {
                let way = either(times, "falls", "rises");
                format!("a floor that {way} by {}° more ahead", digits(2.0 * times))
            },
            |times, scenario, _| scenario.world.floor.slope_deg += 2.0 * times,
        ),
        Usual::new(
            (-6.0, 6.0),
            |times| {
                let way = either(times, "long", "short");
                format!(
                    "a lever that the controller takes for {} % too {way}",
                    digits(5.0 * times)
                )
            },
            |times, scenario, _| {
                if let Some(twist) = &mut scenario.twist {
                    twist.omega_rad_s *= 1.0 + 0.05 * times;
                }
            },
        ),
        Usual::new(
            (-10.0, 20.0),
            |times| {
                let way = either(times, "smaller", "larger");
                format!(
                    "all wheels {} % {way} than the controller takes them for",
                    digits(times)
                )
            },
            |times, scenario, robot| {
                for wheel in &robot.wheels {
                    scenario.faults.push(smaller(&wheel.name, times));
                }
            },
        ),
        Usual::new(
            // Later torques let most wheel loops swing.
            (0.0, 2.0),
            |times| {
                format!(
                    "torques of the wheel loops {} ms late, with gains for no delay",
                    digits(10.0 * times)
                )
            },
            |times, scenario, _| {
                *scenario.wheel_loop.latency_s.get_or_insert(0.0) += 0.01 * times;
            },
        ),
    ];
    let is_driven = |wheel: &&Wheel| wheel.motor.effort_n_m != 0.0;
    let driven = robot.wheels.iter().filter(is_driven).count();
    for wheel in &robot.wheels {
        let [smaller, stuck, dust, motor, bearing] = of_wheel(&wheel.name);
        let is_driven = is_driven(&wheel);
        // The size of the only driven wheel is that of all; of one that rolls along nothing
        // depends.
        suspects.extend((is_driven && driven > 1).then_some(smaller));
        suspects.extend([stuck, dust]);
        suspects.extend(is_driven.then_some(motor));
        suspects.push(bearing);
        if wheel.has_tyre() && robot.steering_of(wheel).is_some() {
            suspects.push(beside(wheel));
        }
    }
    if robot.wheels.iter().all(Wheel::has_tyre) {
        suspects.retain(|suspect| !suspect.is_of_rollers);
    }
    suspects
}

/// A wheel smaller by `percent`: it rolls less by as much as if its encoder read too much.
fn smaller(wheel: &str, percent: f64) -> Fault {
    Fault::EncoderScaled {
        wheel: wheel.to_owned(),
        factor: 1.0 / (1.0 - 0.01 * percent),
        from_s: 0.0,
        until_s: None,
    }
}

/// A steered wheel that stands beside the angle that the controller takes it for.
fn beside(wheel: &Wheel) -> Usual {
    const USUAL_DEG: f64 = 2.0;
    let name = wheel.name.clone();
    let words = move |times: f64| {
        let (deg, way) = (digits(USUAL_DEG * times), either(times, "left", "right"));
        format!("{name} turned by {deg}° more to the {way} than the controller takes it for")
    };
    let (name, axis) = (wheel.name.clone(), wheel.axis());
    let real_deg = libm::atan2(axis.y, axis.x).to_degrees();
    let apply = move |times: f64, scenario: &mut Scenario, _: &mut Robot| {
        let believed = scenario.controller.robot.get_or_insert_default();
        let of_wheel = believed.wheels.entry(name.clone()).or_default();
        *of_wheel.axis_deg.get_or_insert(real_deg) -= USUAL_DEG * times;
    };
    Usual::new((-10.0, 10.0), words, apply).about(&wheel.name)
}

/// Common defects of one wheel.
fn of_wheel(name: &str) -> [Usual; 5] {
    /// For defects without an amount.
    const ONCE: (f64, f64) = (1.0, 1.0);
    let name = || name.to_owned();
    let [n0, n1, n2, n3, n4] = std::array::from_fn(|_| name());
    let [w0, w1, w2, w3, w4] = std::array::from_fn(|_| name());
    let suspects = [
        Usual::new(
            (-10.0, 20.0),
            move |times| {
                let way = either(times, "smaller", "larger");
                format!("{n0} {} % {way} than in its file", digits(times))
            },
            move |times, scenario, _| scenario.faults.push(smaller(&w0, times)),
        ),
        Usual::new(
            ONCE,
            move |_| format!("a stuck roller on {n1}"),
            move |_, scenario, _| {
                scenario.faults.push(Fault::RollerStuck {
                    wheel: w1.clone(),
                    roller: 0,
                    from_s: 0.0,
                    until_s: None,
                });
            },
        )
        .of_rollers(),
        Usual::new(
            ONCE,
            move |_| format!("dust under {n2}: a tenth of the grip"),
            move |_, scenario, robot| dust(scenario, robot, &w2),
        ),
        Usual::new(
            (0.0, 9.0),
            move |times| format!("the motor of {n3} {} % weaker", digits(10.0 * times)),
            move |times, scenario, _| {
                let strength = MotorStrength {
                    forwards: 1.0 - 0.1 * times,
                    backwards: 1.0 - 0.1 * times,
                };
                scenario.motors.wheels.insert(w3.clone(), strength);
            },
        ),
        Usual::new(
            // A wheel whose bearing takes half its load does not roll.
            (0.0, 4.0),
            move |times| {
                let share = digits(10.0 * times);
                format!("a dragging bearing in {n4}: {share} % of its load at the rim")
            },
            move |times, scenario, robot| {
                let load_n =
                    scenario.world.gravity_m_s2 * robot.mass_kg() / robot.wheels.len() as f64;
                let mut wheels = robot.wheels.iter_mut();
                if let Some(wheel) = wheels.find(|wheel| wheel.name == w4) {
                    wheel.joint.friction_n_m += 0.1 * times * load_n * wheel.radius_m;
                }
            },
        ),
    ];
    suspects.map(|suspect| suspect.about(&name()))
}

/// Reduces one wheel's grip to a tenth of the floor's, by a material of its own.
fn dust(scenario: &mut Scenario, robot: &mut Robot, dusty: &str) {
    const FLOOR: &str = "floor";
    const CLEAN: &str = "clean";
    const DUSTY: &str = "dusty";
    if scenario.world.floor.material.is_none() {
        let floor = &mut scenario.world.floor;
        let pair = MaterialPair {
            friction: floor.friction.take().unwrap_or(0.6),
            rolling_resistance: floor.rolling_resistance.take().unwrap_or(0.0),
            radius_exponent: floor.radius_exponent.take().unwrap_or(0.0),
            creep: floor.creep.take().unwrap_or(0.0),
            sliding: floor.sliding.take(),
            across: floor.across.take(),
            against: floor.against.take(),
        };
        floor.material = Some(FLOOR.to_owned());
        let on_floor = [(FLOOR.to_owned(), pair)].into();
        scenario.materials.insert(CLEAN.to_owned(), on_floor);
        for wheel in &mut robot.wheels {
            wheel.material = Some(CLEAN.to_owned());
        }
    }
    let Some(wheel) = robot.wheels.iter_mut().find(|wheel| wheel.name == dusty) else {
        return;
    };
    let material = wheel.material.as_ref();
    let pairs = material.and_then(|material| scenario.materials.get(material));
    if let Some(mut pairs) = pairs.cloned() {
        for pair in pairs.values_mut() {
            pair.friction *= 0.1;
            if let Some(friction) = pair.across.as_mut().and_then(|of| of.friction.as_mut()) {
                *friction *= 0.1;
            }
        }
        scenario.materials.insert(DUSTY.to_owned(), pairs);
        wheel.material = Some(DUSTY.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;

    use super::*;

    fn robot() -> Robot {
        Robot::load("../../../assets/robots/mecanum4.toml").expect("a shipped robot")
    }

    /// At nine tenths of the rate the robot is a tenth of each turn behind, and at nine tenths of
    /// the speed a tenth of each metre.
    #[test]
    fn a_slow_robot_is_behind_in_proportion_to_its_way() {
        let drift = |asked: Twist, stands: bool, amount: f64| {
            let mut summary = Summary::default();
            summary.twist_asked_mean = Some(asked);
            summary.twist_mean = Some(Twist::new(
                0.9 * asked.vx_m_s,
                0.9 * asked.vy_m_s,
                0.9 * asked.omega_rad_s,
            ));
            match stands {
                true => summary.turned_rad = TAU * amount,
                false => summary.travelled_m = amount,
            }
            Drift::from_command(&summary).expect("means")
        };
        for amount in [1.0, 2.5] {
            let turned = drift(Twist::new(0.0, 0.0, 0.7), true, amount);
            assert!((turned.turned_rad + 0.1 * TAU).abs() < 1e-12, "{turned:?}");
            let gone = drift(Twist::new(0.3, 0.0, 0.0), false, amount);
            assert!((gone.ahead_m + 0.1).abs() < 1e-12, "{gone:?}");
        }
    }

    /// What cannot be told from zero is the same for the robot and for each of its defects.
    #[test]
    fn the_floor_is_that_of_a_metre_however_long_the_motion_is() {
        let lengths = [Some(0.5), None, None, None, None];
        let lineup = Lineup::of(&robot(), &[], &FileAccess::anywhere(), lengths);
        let lineup = lineup.expect("it drives");
        let healthy = lineup.healthy()[0].expect("ahead");
        let heavy = lineup.in_amount(0, 1.0).drifts[0].expect("ahead");
        // Equal but for the rounding of one product.
        let floors = healthy.floor.iter().zip(heavy.floor);
        for (of_healthy, of_heavy) in floors {
            assert!((of_healthy / of_heavy - 1.0).abs() < 1e-14);
        }
        // Below a hundredth of a millimetre, here of half a metre, nothing is said.
        assert!(healthy.floor[0] > 1.9 * ilon_trace::effects::FLOORS * 1e-5);
    }

    /// The words of a defect say what it changes.
    #[test]
    fn a_late_loop_and_a_shifted_mass_are_as_stated() {
        let robot = robot();
        let reach_m = robot.wheels.iter().map(|wheel| wheel.position_m().x.abs());
        let reach_m = reach_m.fold(0.0, f64::max);
        let text = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1";
        let mut seen = 0;
        for usual in usual(&robot) {
            let mut scenario = Scenario::from_toml(text, "test", "").expect("a scenario");
            let mut changed = robot.clone();
            let words = (usual.words)(1.5);
            (usual.apply)(1.5, &mut scenario, &mut changed);
            let moved_m =
                changed.chassis.mass.center_of_mass_m - robot.chassis.mass.center_of_mass_m;
            if words.contains("15 ms late") {
                assert!((scenario.wheel_loop.latency_s() - 0.015).abs() < 1e-15);
                seen += 1;
            }
            if words == "centre of mass 7.5 cm further ahead" {
                assert!((moved_m.x - 0.075).abs() < 1e-15, "{moved_m}");
                // It stays within four fifths of the way to the wheels.
                assert!((0.05 * usual.times.1 - 0.8 * reach_m).abs() < 1e-12);
                seen += 1;
            }
        }
        assert_eq!(seen, 2);
    }
}
