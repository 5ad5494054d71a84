//! What the usual suspects do to a robot in standard motions: which of them would look like what somebody sees of a real one.

use ilon_files::FileAccess;
use ilon_formats::RollerBearings;
use ilon_robot::Robot;
use ilon_trace::Change;
use rayon::prelude::*;
use serde::Serialize;

use super::null::Null;
use super::path::Path;
use super::twin::{Limits, twin};
use crate::Error;
use crate::scenario::{Fault, MaterialPair, MotorStrength, Scenario, Setting};
use crate::simulate::{Resolved, resolve};
use crate::standard_motions::{StandardMotion, standard_motions};

/// What a suspect does in a motion: the robot with it minus the robot without it, for each metre of the way, or for each turn on the spot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Drift {
    /// How far ahead it ends, by the heading without it, in m/m or m/turn.
    pub ahead_m: f64,
    /// How far to the left, in m/m or m/turn.
    pub left_m: f64,
    /// How far turned to the left, in rad/m or rad/turn.
    pub turned_rad: f64,
    /// Below these, in metres and radians, it cannot be told from none.
    pub floor: [f64; 2],
}

/// Something that is often amiss with a robot, in its usual amount.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Suspect {
    /// What it is, in words.
    pub words: String,
    /// The wheel that it is about, if it is about one.
    pub wheel: Option<String>,
    /// What it does in each of [`MOTIONS`](crate::standard_motions::MOTIONS); `None` where the motion could not be driven with it.
    pub drifts: Vec<Option<Drift>>,
}

/// What each of the usual suspects does to a robot under a scenario's conditions, `settings`.
///
/// # Errors
/// Where the robot cannot be driven, or a setting makes no sense.
pub fn suspects(
    robot: &Robot,
    settings: &[Setting],
    files: &FileAccess,
) -> Result<Vec<Suspect>, Error> {
    let motions = motions(robot, settings, files)?;
    let usual = usual(robot);
    let drifts: Vec<Vec<Option<Drift>>> = usual
        .par_iter()
        .map(|(_, _, null)| {
            motions
                .iter()
                .map(|motion| motion.drift(robot, null))
                .collect()
        })
        .collect();
    let suspects = usual.into_iter().zip(drifts);
    Ok(suspects
        .map(|((words, wheel, _), drifts)| Suspect {
            words,
            wheel,
            drifts,
        })
        .collect())
}

/// A motion, and the way of the robot in it.
struct Motion {
    resolved: Resolved,
    path: Path,
    /// What half the step moves it by, in metres and radians.
    floor: [f64; 2],
    /// How many metres it goes, or how often it turns.
    amount: f64,
}

impl Motion {
    fn of(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        let resolved = resolve(scenario, robot)?;
        let (path, amount) = way(&resolved, robot, |_, _| ())?;
        let half_s = 0.5 * resolved.physics_dt_s();
        let (half, _) = way(&resolved, robot, |scenario, _| {
            scenario.run.physics_dt_s = crate::scenario::Step::Seconds(half_s);
        })?;
        let apart = path.apart(&half);
        // What is less is rounding, in metres and radians.
        let floor = [apart.most_m.max(1e-5), apart.most_rad.max(1e-5)];
        Ok(Self {
            resolved,
            path,
            floor,
            amount,
        })
    }

    fn drift(&self, robot: &Robot, null: &Null) -> Option<Drift> {
        let (path, _) = way(&self.resolved, robot, null).ok()?;
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

/// The way of a robot with something changed, and how far it went in metres; of one that turns on the spot, how often it turned.
fn way(
    resolved: &Resolved,
    robot: &Robot,
    change: impl FnOnce(&mut Scenario, &mut Robot),
) -> Result<(Path, f64), Error> {
    let came = twin(resolved, robot, Change::WithoutAll, change, Limits::none());
    let ran = came.map(|came| came.ran);
    match ran {
        Some(Ok((summary, path))) => {
            let turns = summary.turned_rad / std::f64::consts::TAU;
            let stands = summary.travelled_m < 0.05 * summary.turned_rad;
            Ok((path, if stands { turns } else { summary.travelled_m }))
        }
        Some(Err(error)) => Err(Error::invalid(
            format!("the robot cannot be driven in a standard motion: {error}"),
            "look at it with `ilon inspect`",
        )),
        None => Err(Error::invalid("the run was stopped", "run it again")),
    }
}

/// The standard motions of a robot, driven.
fn motions(robot: &Robot, settings: &[Setting], files: &FileAccess) -> Result<Vec<Motion>, Error> {
    let drive = |motion: &StandardMotion| {
        let text = format!(
            "robot = {{ file = \"\", roller_bodies = \"near\" }}\n{}",
            motion.toml()
        );
        let scenario = Scenario::from_toml_with(&text, motion.name, "", settings, files)?;
        Motion::of(&scenario, robot)
    };
    standard_motions(robot)?.par_iter().map(drive).collect()
}

/// The usual suspects: words, the wheel, and the change of scenario and robot that each is.
fn usual(robot: &Robot) -> Vec<(String, Option<String>, Null)> {
    let mut suspects: Vec<(String, Option<String>, Null)> = vec![
        (
            "centre of mass 5 cm further ahead".to_owned(),
            None,
            Box::new(|_, robot| robot.chassis.mass.center_of_mass_m.x += 0.05),
        ),
        (
            "centre of mass 5 cm further to the left".to_owned(),
            None,
            Box::new(|_, robot| robot.chassis.mass.center_of_mass_m.y += 0.05),
        ),
        (
            "dry bushings under all rollers".to_owned(),
            None,
            Box::new(|_, robot| {
                for wheel in &mut robot.wheels {
                    let radius_m = wheel
                        .rollers
                        .iter()
                        .map(|of| of.radius_m)
                        .fold(0.0, f64::max);
                    wheel.surface.axle_friction = RollerBearings::Bushings.axle_friction();
                    wheel.surface.axle_radius_m = RollerBearings::Bushings.axle_radius_m(radius_m);
                }
            }),
        ),
        (
            "a floor that falls by 2° ahead".to_owned(),
            None,
            Box::new(|scenario, _| scenario.world.floor.slope_deg = 2.0),
        ),
        (
            "a lever that the controller takes for 5 % too long".to_owned(),
            None,
            Box::new(|scenario, _| {
                if let Some(twist) = &mut scenario.twist {
                    twist.omega_rad_s *= 1.05;
                }
            }),
        ),
    ];
    for wheel in &robot.wheels {
        suspects.extend(of_wheel(&wheel.name));
    }
    suspects
}

/// What is often amiss with one wheel.
fn of_wheel(name: &str) -> [(String, Option<String>, Null); 5] {
    let wheel = || Some(name.to_owned());
    let [smaller, stuck, dusty, dragging, weak] = std::array::from_fn(|_| name.to_owned());
    [
        (
            format!("{name} 1 % smaller than the others"),
            wheel(),
            // It rolls as much less as a wheel whose encoder reads as much too much.
            Box::new(move |scenario, _| {
                scenario.faults.push(Fault::EncoderScaled {
                    wheel: smaller.clone(),
                    factor: 1.0 / 0.99,
                    from_s: 0.0,
                    until_s: None,
                });
            }),
        ),
        (
            format!("a stuck roller on {name}"),
            wheel(),
            Box::new(move |scenario, _| {
                scenario.faults.push(Fault::RollerStuck {
                    wheel: stuck.clone(),
                    roller: 0,
                    from_s: 0.0,
                    until_s: None,
                });
            }),
        ),
        (
            format!("dust under {name}: a tenth of the grip"),
            wheel(),
            Box::new(move |scenario, robot| dust(scenario, robot, &dusty)),
        ),
        (
            format!("the motor of {name} 10 % weaker"),
            wheel(),
            Box::new(move |scenario, _| {
                let strength = MotorStrength {
                    forwards: 0.9,
                    backwards: 0.9,
                };
                scenario.motors.wheels.insert(weak.clone(), strength);
            }),
        ),
        (
            format!("a dragging bearing in {name}: a tenth of its load at the rim"),
            wheel(),
            Box::new(move |scenario, robot| {
                let load_n =
                    scenario.world.gravity_m_s2 * robot.mass_kg() / robot.wheels.len() as f64;
                for wheel in robot
                    .wheels
                    .iter_mut()
                    .filter(|wheel| wheel.name == dragging)
                {
                    wheel.joint.friction_n_m += 0.1 * load_n * wheel.radius_m;
                }
            }),
        ),
    ]
}

/// One wheel of a material of its own, that has a tenth of the floor's grip.
fn dust(scenario: &mut Scenario, robot: &mut Robot, dusty: &str) {
    const FLOOR: &str = "floor";
    let floor = &mut scenario.world.floor;
    let friction = floor.friction.take().unwrap_or(0.6);
    floor.material = Some(FLOOR.to_owned());
    for (name, share) in [("clean", 1.0), ("dusty", 0.1)] {
        let pair = MaterialPair {
            friction: share * friction,
            rolling_resistance: 0.0,
            radius_exponent: 0.0,
            creep: 0.0,
            sliding: None,
            across: None,
            against: None,
        };
        let on_floor = [(FLOOR.to_owned(), pair)].into();
        scenario.materials.insert(name.to_owned(), on_floor);
    }
    for wheel in &mut robot.wheels {
        let name = if wheel.name == dusty {
            "dusty"
        } else {
            "clean"
        };
        wheel.material = Some(name.to_owned());
    }
}
