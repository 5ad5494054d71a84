//! The accelerations of a scenario's robot that grip and motors allow.

pub(crate) mod share;
mod sprints;

use std::f64::consts::FRAC_PI_4;

use ilon_control::{
    AccelerationLimit, AccelerationLimits, AccelerationPolytope, AccelerationUse, Fastest,
    Kinematics, LimitCause, LimitSettings, Motor, PushSharing, Reference, SpeedLimits,
};
use ilon_robot::{Robot, Twist};
use ilon_trace::Announced;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::faults::place_m;
use crate::ground::floor::floor;
use crate::pilot::{Pilot, point_m};
use crate::wheels::motors::motors;
use ilon_scenario::Error;
use ilon_scenario::course::joint_targets::JointTargets;
use ilon_scenario::course::playback::Played;
use ilon_scenario::scenario::{Fault, Scenario, WheelLaw};

/// The accelerations that a robot's grip and motors allow under a scenario's floor, motors and
/// wheel loops.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Limits {
    /// Coulomb friction coefficient for these limits.
    pub friction: f64,
    /// Angle by which the floor falls, in degrees.
    pub slope_deg: f64,
    /// Direction in which it falls, relative to the robot's heading, counter-clockwise, in degrees.
    pub downhill_deg: f64,
    /// How the wheels share the force that the body needs: `"equal_loops"` for independent wheel
    /// loops, or `"by_grip"`.
    pub sharing: &'static str,
    /// The limits, in each direction and at each speed.
    pub rows: Vec<LimitRow>,
    /// The limits of motions without rotation in all directions, at rest and at shares of the top
    /// speeds.
    pub outlines: Vec<LimitOutline>,
    /// A polytope of feasible accelerations from rest, ahead and to the left in m/s^2 and rotation
    /// in rad/s^2. In JSON: its `corners`, its `half_spaces` [x, y, z] with x a + y b + z c <= 1,
    /// and `missing_at_most`, the largest share that it misses in any direction. `None` if no
    /// acceleration along an axis is feasible.
    #[serde(serialize_with = "as_corners_and_half_spaces")]
    pub polytope: Option<AccelerationPolytope>,
    /// A box of feasible accelerations ahead and back, left and right, in m/s^2, and of rotation,
    /// in rad/s^2, for planners that accept only boxes: nine tenths of the largest box in the
    /// proportions of the limits from rest, using the smaller limit of both senses. Every corner is
    /// feasible.
    pub acceleration_box: [f64; 3],
    /// Faults of the robot's stance: that it tips over, or slides, at rest.
    pub remarks: Vec<String>,
    /// Properties of floor and rollers in the scenario that these limits ignore.
    pub left_out: Vec<&'static str>,
}

/// The limits in all directions at one share of the top speeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LimitOutline {
    /// Speed in each direction over the top speed in that direction.
    pub share_of_top: f64,
    /// The limits of speeding up, counter-clockwise from ahead, every 5 degrees.
    pub points: Vec<OutlinePoint>,
}

/// The limit of speeding up in one direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct OutlinePoint {
    /// Relative to the robot's heading, counter-clockwise, in degrees.
    pub direction_deg: f64,
    /// The limit.
    #[serde(flatten)]
    pub limit: Limit,
}

/// The limits of one motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LimitRow {
    /// The motion's name, such as `"ahead"` or `"turning left"`.
    pub motion: String,
    /// Its direction relative to the robot's heading, counter-clockwise, in degrees; `None` for a
    /// turn on the spot.
    pub direction_deg: Option<f64>,
    /// Speed of that motion, in m/s, or rad/s for a rotation.
    pub speed: f64,
    /// The limit of speeding up.
    pub speeding_up: Limit,
    /// The limit of slowing down; at rest that of speeding up the other way.
    pub slowing_down: Limit,
}

/// One limit and its cause.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Limit {
    /// The largest acceleration, in m/s^2, or rad/s^2 for a rotation; zero if the motion itself
    /// exceeds the limits.
    pub largest: f64,
    /// The wheel that slides first, or whose motor is at its limit; for a robot that tips over, one
    /// that leaves the ground.
    pub wheel: String,
    /// `"grip"`, `"motor"` or `"tipping"`.
    pub cause: &'static str,
    /// The limit by statics, in the same unit.
    pub by_statics: f64,
    /// The limit over that by statics: less than 1 if the simulated robot slides at more.
    pub share_held: f64,
}

impl LimitRow {
    /// The limit from rest, of which only the share is needed.
    pub(crate) fn from_rest(share: f64) -> Self {
        let limit = Limit {
            largest: share,
            by_statics: 1.0,
            share_held: share,
            cause: "grip",
            ..Limit::default()
        };
        Self {
            speeding_up: limit.clone(),
            slowing_down: limit,
            ..Self::default()
        }
    }
}

/// The evaluated motions: name, direction in eighths of a turn, and sense of rotation.
pub(crate) const MOTIONS: [(&str, Option<i32>, f64); 10] = [
    ("ahead", Some(0), 0.0),
    ("ahead and left", Some(1), 0.0),
    ("left", Some(2), 0.0),
    ("back and left", Some(3), 0.0),
    ("back", Some(4), 0.0),
    ("back and right", Some(-3), 0.0),
    ("right", Some(-2), 0.0),
    ("ahead and right", Some(-1), 0.0),
    ("turning left", None, 1.0),
    ("turning right", None, -1.0),
];

/// The unit twist of a motion: along a direction in eighths of a turn, or a rotation if there is
/// none.
pub(crate) fn direction(eighths: Option<i32>, turning: f64) -> Twist {
    match eighths {
        Some(eighths) => {
            let (sin, cos) = libm::sincos(FRAC_PI_4 * f64::from(eighths));
            Twist::new(cos, sin, 0.0)
        }
        None => Twist::new(0.0, 0.0, turning),
    }
}

/// The shares of the top speed at which a motion is evaluated. Chosen.
const SHARES_OF_TOP: [f64; 3] = [0.0, 0.5, 0.9];

/// The share of the feasible set's boundary that the polytope may miss beyond the middles of its
/// faces. Chosen.
const POLYTOPE_MISSES: f64 = 0.03;

/// Angle between the directions of an outline, in degrees. Chosen.
const OUTLINE_STEP_DEG: usize = 5;

impl Limits {
    /// The limits of a robot under a scenario: with its floor, gravity, slope under its start,
    /// motors, wheel loops, payloads present from the start, and its joints at the start of their
    /// servos. `robot` is a result of [`load_robot`](ilon_scenario::robot::load_robot).
    ///
    /// # Errors
    /// If the scenario or the robot is invalid, or the floor has no friction.
    pub fn of(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        // Servos are at the positions from the robot's file and the scenario, whatever a log
        // commands later.
        let targets = JointTargets::new(scenario, &Played::default(), robot)?;
        let mut limiter = Limiter::new(scenario, (robot, &targets), 1.0)?;
        let kinematics = Kinematics::new(&targets.standing(robot))?;
        let tops = SpeedLimits::new(&kinematics, &top_rates(scenario, robot));
        let mut rows = Vec::new();
        for (motion, eighths, turning) in MOTIONS {
            let direction = direction(eighths, turning);
            let top = 1.0 / tops.share(direction);
            let shares = SHARES_OF_TOP
                .iter()
                .filter(|share| **share == 0.0 || top.is_finite());
            for share in shares {
                let speed = if *share == 0.0 { 0.0 } else { share * top };
                let twist = direction.scaled(speed);
                rows.push(LimitRow {
                    motion: motion.to_owned(),
                    direction_deg: eighths.map(|eighths| 45.0 * f64::from(eighths)),
                    speed,
                    speeding_up: limiter.limit(direction, twist)?,
                    slowing_down: limiter.limit(direction.scaled(-1.0), twist)?,
                });
            }
        }
        let section = &scenario.world.floor;
        Ok(Self {
            friction: limiter.settings.friction,
            slope_deg: section.slope_deg,
            downhill_deg: 0.0 - scenario.robot.heading_deg,
            sharing: match limiter.settings.sharing {
                PushSharing::EqualLoops => "equal_loops",
                PushSharing::ByGrip => "by_grip",
            },
            outlines: limiter.outlines(&tops)?,
            polytope: limiter.limits.polytope(
                Twist::default(),
                &limiter.motors,
                POLYTOPE_MISSES,
            )?,
            acceleration_box: limiter.box_from_rest()?,
            rows,
            remarks: limiter.how_it_stands()?,
            left_out: left_out(scenario, &limiter.robot),
        })
    }
}

fn as_corners_and_half_spaces<S: Serializer>(
    polytope: &Option<AccelerationPolytope>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let Some(polytope) = polytope else {
        return serializer.serialize_none();
    };
    let corners = polytope.corners.iter();
    let corners: Vec<[f64; 3]> = corners
        .map(|corner| [corner.vx_m_s, corner.vy_m_s, corner.omega_rad_s])
        .collect();
    let mut both = serializer.serialize_struct("polytope", 3)?;
    both.serialize_field("corners", &corners)?;
    both.serialize_field("half_spaces", &polytope.half_spaces)?;
    both.serialize_field("missing_at_most", &polytope.missing_at_most)?;
    both.end()
}

/// The largest wheel rates, in rad/s: the lowest limit of motor, guidance and a DC motor's line.
pub fn top_rates(scenario: &Scenario, robot: &Robot) -> Vec<f64> {
    let guided = scenario.guidance.wheel_rate_limit_rad_s;
    let no_load = scenario.motors.dc.map(|dc| dc.no_load_rate_rad_s);
    let held = guided
        .into_iter()
        .chain(no_load)
        .fold(f64::INFINITY, f64::min);
    let wheels = robot.wheels.iter();
    wheels
        .map(|wheel| wheel.motor.velocity_rad_s.min(held))
        .collect()
}

/// The properties that the limits ignore.
fn left_out(scenario: &Scenario, robot: &Robot) -> Vec<&'static str> {
    let section = &scenario.world.floor;
    let is_there = |of: Option<f64>| of.is_some_and(|of| of > 0.0);
    let mut surfaces = robot.wheels.iter().map(|wheel| &wheel.surface);
    let gives = surfaces.clone().any(|of| of.tread.is_some());
    let drags = is_there(section.rolling_resistance)
        || surfaces.any(|surface| surface.rolling_resistance > 0.0);
    let has_nap = section.across.is_some() || section.against.is_some();
    let falls = section.sliding.is_some();
    let all = [
        (drags, "rolling resistance"),
        (gives, "treads that give"),
        (is_there(section.creep), "creep"),
        (falls, "friction that falls as a roller slides"),
        (has_nap, "the nap of the floor"),
        (!section.patches.is_empty(), "patches of the floor"),
        (!section.is_plane(), "ground that is no plane"),
    ];
    let there = all.into_iter().filter(|(is_there, _)| *is_there);
    there.map(|(_, what)| what).collect()
}

/// The limits of a scenario's robot, for queries.
pub struct Limiter {
    limits: AccelerationLimits,
    settings: LimitSettings,
    motors: Vec<Motor>,
    /// With its payloads, and its joints at zero.
    robot: Robot,
    /// Joint positions, in rad or m.
    positions: Vec<f64>,
}

impl Limiter {
    /// For a scenario, a robot, and a share of grip and torques.
    ///
    /// # Errors
    /// Like [`Limits::of`].
    pub fn new(
        scenario: &Scenario,
        (robot, targets): (&Robot, &JointTargets),
        share: f64,
    ) -> Result<Self, Error> {
        let robot = laden(scenario, robot);
        if let Some(wheel) = robot.wheels.iter().find(|wheel| wheel.has_tyre()) {
            return Err(Error::invalid(
                format!(
                    "limits of acceleration are where wheels begin to slide, and `{}` rolls on a tyre, which slides in every turn",
                    wheel.name
                ),
                match scenario.reference {
                    Some(_) => {
                        "leave out `reference.timing`, sweep the reference's speed (`ilon sweep`), and look at `friction_used_max` and the way's error"
                    }
                    None => {
                        "sweep `twist.ramp_s` (`ilon sweep`), and look at `friction_used_max` and the way's error"
                    }
                },
            ));
        }
        // The limits are those on its plane.
        let floor = floor(scenario, &robot, None)?;
        let pairs = floor.footings.iter().map(|footing| footing.friction);
        let friction = pairs.fold(floor.friction, f64::min);
        if friction <= 0.0 {
            return Err(Error::invalid(
                "on a floor without friction no acceleration is possible",
                "give `world.floor.friction` a value above 0",
            ));
        }
        let sharing = match scenario.wheel_loop.law {
            WheelLaw::Pid | WheelLaw::ComputedTorque => PushSharing::EqualLoops,
            WheelLaw::PrioritisedTorque | WheelLaw::Passive => PushSharing::ByGrip,
        };
        let settings = LimitSettings {
            friction,
            gravity_m_s2: scenario.world.gravity_m_s2,
            slope_rad: floor.slope_rad,
            // The floor falls towards +x of the world.
            downhill_rad: -scenario.robot.start().heading_rad,
            sharing,
            share,
        };
        let positions = targets.at(0.0, &robot);
        Ok(Self {
            limits: AccelerationLimits::new(&robot.posed(&positions), &settings)?,
            settings,
            positions,
            motors: motors(scenario, &robot)?,
            robot,
        })
    }

    /// The limits by direction, at each share of the top speeds; only at rest if the speeds are
    /// unlimited.
    fn outlines(&mut self, tops: &SpeedLimits) -> Result<Vec<LimitOutline>, Error> {
        let mut outlines = Vec::new();
        for share_of_top in SHARES_OF_TOP {
            let mut points = Vec::new();
            for degrees in (0..360).step_by(OUTLINE_STEP_DEG) {
                let direction_deg = degrees as f64;
                let (sin, cos) = libm::sincos(direction_deg.to_radians());
                let direction = Twist::new(cos, sin, 0.0);
                let speed = match share_of_top == 0.0 {
                    true => 0.0,
                    false => share_of_top / tops.share(direction),
                };
                if !speed.is_finite() {
                    return Ok(outlines);
                }
                points.push(OutlinePoint {
                    direction_deg,
                    limit: self.limit(direction, direction.scaled(speed))?,
                });
            }
            outlines.push(LimitOutline {
                share_of_top,
                points,
            });
        }
        Ok(outlines)
    }

    /// Moves the joints to other positions, in rad or m, if the change is large enough to matter.
    fn stand(&mut self, positions: Vec<f64>) -> Result<(), Error> {
        /// In rad or m. Chosen.
        const MATTERS: f64 = 5e-3;
        let pairs = positions.iter().zip(&self.positions);
        if pairs
            .map(|(to, from)| (to - from).abs())
            .fold(0.0, f64::max)
            > MATTERS
        {
            self.limits = AccelerationLimits::new(&self.robot.posed(&positions), &self.settings)?;
            self.positions = positions;
        }
        Ok(())
    }

    /// The largest acceleration along a direction while the robot moves with a twist.
    pub fn along(&mut self, direction: Twist, twist: Twist) -> Result<AccelerationLimit, Error> {
        Ok(self.limits.along(direction, twist, &self.motors)?)
    }

    /// The wheels that reach their limit first if an acceleration exceeds it: the one with the
    /// largest demand, and those with nearly the same demand on their grip.
    fn first_of(
        &mut self,
        used: &AccelerationUse,
        twist_rate: Twist,
        twist: Twist,
    ) -> Result<Vec<usize>, Error> {
        let worst = used.by.wheel;
        if used.by.cause == LimitCause::Motor {
            return Ok(vec![worst]);
        }
        let mut shares = vec![0.0; self.motors.len()];
        self.limits
            .grip_used(twist_rate, twist, &self.motors, &mut shares)?;
        Ok(nearly_most_used(&shares))
    }

    /// The share of grip and torques that an acceleration needs if the wheels share forces by their
    /// grip and the floor falls towards an angle in rad from the robot's heading.
    fn by_grip(&self, twist_rate: Twist, twist: Twist, downhill_rad: f64) -> Result<f64, Error> {
        let settings = LimitSettings {
            sharing: PushSharing::ByGrip,
            downhill_rad,
            ..self.settings
        };
        let mut limits = AccelerationLimits::new(&self.robot.posed(&self.positions), &settings)?;
        Ok(limits.used(twist_rate, twist, &self.motors)?.share)
    }

    /// The box of [`Limits::acceleration_box`].
    fn box_from_rest(&mut self) -> Result<[f64; 3], Error> {
        const SHARE: f64 = 0.9;
        let mut sides = [0.0; 3];
        for (axis, side) in sides.iter_mut().enumerate() {
            let mut least = f64::INFINITY;
            for sign in [1.0, -1.0] {
                let mut way = [0.0; 3];
                way[axis] = sign;
                let found = self.along(Twist::new(way[0], way[1], way[2]), Twist::default())?;
                least = least.min(found.largest);
            }
            *side = least;
        }
        if sides.contains(&0.0) {
            return Ok([0.0; 3]);
        }
        let mut share = f64::INFINITY;
        for corner in 0..8 {
            let way = |axis: usize| {
                if corner >> axis & 1 == 1 {
                    -sides[axis]
                } else {
                    sides[axis]
                }
            };
            let found = self.along(Twist::new(way(0), way(1), way(2)), Twist::default())?;
            share = share.min(found.largest);
        }
        Ok(sides.map(|side| SHARE * share * side))
    }

    fn limit(&mut self, direction: Twist, twist: Twist) -> Result<Limit, Error> {
        let found = self.along(direction, twist)?;
        Ok(Limit {
            largest: found.largest,
            by_statics: found.largest,
            share_held: 1.0,
            wheel: self.robot.wheels[found.wheel].name.clone(),
            cause: match found.cause {
                LimitCause::Grip if self.tips(direction.scaled(found.largest)) => "tipping",
                LimitCause::Grip => "grip",
                LimitCause::Motor => "motor",
            },
        })
    }

    /// Whether the robot is about to tip over at an acceleration.
    fn tips(&self, twist_rate: Twist) -> bool {
        /// Relative to the distance from the outermost wheel to the origin. Chosen.
        const ABOUT: f64 = 1e-4;
        let wheels = self.robot.wheels.iter();
        let arm_m = wheels
            .map(|w| w.position_m().xy().norm())
            .fold(0.0, f64::max);
        self.limits.tipping_margin_m(twist_rate) < ABOUT * arm_m
    }

    /// Faults of the robot's stance, in words.
    fn how_it_stands(&mut self) -> Result<Vec<String>, Error> {
        let rest = Twist::default();
        let margin_m = self.limits.tipping_margin_m(rest);
        if margin_m == f64::NEG_INFINITY {
            let words = "the robot falls over: its wheels stand in one row";
            return Ok(vec![words.to_owned()]);
        }
        if margin_m < 0.0 {
            let off_mm = -1e3 * margin_m;
            return Ok(vec![format!(
                "the robot tips over where it stands: its weight meets the ground {off_mm:.1} mm outside of its wheels"
            )]);
        }
        let mut remarks = Vec::new();
        let used = self.limits.used(rest, rest, &self.motors)?;
        if used.share > 1.0 + 1e-9 {
            let wheel = &self.robot.wheels[used.by.wheel].name;
            let what = match used.by.cause {
                LimitCause::Grip => "grip",
                LimitCause::Motor => "motor's torque",
            };
            remarks.push(match used.share.is_finite() {
                true => format!(
                    "the robot cannot stand here: wheel `{wheel}` needs {:.0} % of its {what} for it",
                    100.0 * used.share
                ),
                false => format!("the robot cannot stand here: wheel `{wheel}` has no {what} for it"),
            });
        }
        remarks.extend(self.unloaded()?);
        Ok(remarks)
    }

    /// Wheels without load at rest, in words.
    fn unloaded(&mut self) -> Result<Option<String>, Error> {
        let loads_n = self.limits.loads_n(Twist::default(), &self.motors)?;
        let whole_n: f64 = loads_n.iter().sum();
        let light = |wheel: &usize| loads_n[*wheel] <= 1e-9 * whole_n;
        let wheels: Vec<usize> = (0..loads_n.len()).filter(light).collect();
        Ok((!wheels.is_empty()).then(|| {
            let names = wheels
                .iter()
                .map(|wheel| format!("`{}`", self.robot.wheels[*wheel].name));
            let names: Vec<String> = names.collect();
            format!(
                "the other wheels carry all the weight, so {} has no grip",
                names.join(", ")
            )
        }))
    }
}

/// The path of a scenario in the least time within a share of grip and torques, and a share of
/// wheel rates.
///
/// # Errors
/// Like [`Limits::of`], and if the path cannot be driven.
pub(crate) fn fastest(
    scenario: &Scenario,
    (robot, targets): (&Robot, &JointTargets),
    path: &Reference,
    [share, of_rates]: [f64; 2],
) -> Result<Reference, Error> {
    let mut limiter = Limiter::new(scenario, (robot, targets), share)?;
    let kinematics = Kinematics::new(&targets.standing(robot))?;
    let limit_rad_s = top_rates(scenario, robot)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let mut under = Fastest {
        limits: &mut limiter.limits,
        motors: &limiter.motors,
        wheel_rate_limit_rad_s: of_rates * limit_rad_s,
        reference_point_m: point_m(scenario.guidance.reference_point, &kinematics),
        // The floor falls towards +x.
        downhill_in_world_rad: 0.0,
    };
    Ok(path.as_fast_as_possible(&mut under, scenario.run.duration_s)?)
}

/// Number of times at which a motion is evaluated. Chosen.
const LOOKS: usize = 2000;

/// A planned motion that exceeds grip or motors, and for which share of the run.
#[derive(Clone, Debug)]
pub(crate) struct Beyond {
    pub announced: Announced,
    /// Number of the [`LOOKS`] at which it exceeds them.
    looks: u32,
    /// A remedy at the largest demand.
    remedy: &'static str,
    /// The share of grip needed there if all wheels share the force by their grip, as they do once
    /// one slides.
    together: Option<f64>,
}

/// Where a planned motion exceeds grip or motors: its first time, the largest demand, its wheel and
/// its kind. Steps of a speed, which would need infinite forces, are left to the wheel loops.
pub(crate) fn beyond(
    scenario: &Scenario,
    (robot, targets): (&Robot, &JointTargets),
    pilot: &Pilot,
) -> Option<Beyond> {
    // Faults of the scenario are reported elsewhere.
    let mut limiter = Limiter::new(scenario, (robot, targets), 1.0).ok()?;
    let mut beyond: Option<Beyond> = None;
    let tops_rad_s = top_rates(scenario, robot);
    for look in 0..=LOOKS {
        let t_s = scenario.run.duration_s * look as f64 / LOOKS as f64;
        let (twist, twist_rate) = pilot.planned(t_s)?;
        let heading_rad = match pilot.desired_heading_rad(t_s) {
            Some(heading_rad) => heading_rad,
            None => scenario.robot.start().heading_rad,
        };
        if !robot.joints.is_empty() {
            limiter.stand(targets.at(t_s, robot)).ok()?;
        }
        limiter.limits.turn_slope(-heading_rad).ok()?;
        let used = limiter
            .limits
            .used(twist_rate, twist, &limiter.motors)
            .ok()?;
        if used.share <= 1.0 + 1e-9 {
            continue;
        }
        let beyond = match &mut beyond {
            Some(beyond) => beyond,
            None => beyond.insert(Beyond {
                announced: Announced {
                    from_s: t_s,
                    first: limiter.first_of(&used, twist_rate, twist).ok()?,
                    most_at_s: t_s,
                    wheel: used.by.wheel,
                    of_grip: used.by.cause == LimitCause::Grip,
                    share: Some(0.0),
                },
                looks: 0,
                remedy: "",
                together: None,
            }),
        };
        if beyond.take(t_s, &used) {
            let mut rates_rad_s = vec![0.0; tops_rad_s.len()];
            pilot.kinematics().wheel_rates(twist, &mut rates_rad_s);
            let tops = rates_rad_s.iter().zip(&tops_rad_s);
            let is_too_fast = tops.into_iter().any(|(rate, top)| rate.abs() > *top);
            beyond.remedy = match (is_too_fast, twist_rate == Twist::default()) {
                (true, _) => "its wheels cannot turn so fast: command less speed",
                (false, true) => {
                    "without any acceleration: the slope or the speed alone needs that"
                }
                (false, false) => "command less acceleration",
            };
            beyond.together = limiter.by_grip(twist_rate, twist, -heading_rad).ok();
        }
    }
    beyond
}

/// The wheels that use nearly as much of their grip as the one that uses most.
fn nearly_most_used(shares: &[f64]) -> Vec<usize> {
    /// Relative to the largest. Loads and forces are uncertain by some per cent. Chosen.
    const NEARLY: f64 = 0.95;
    let most = shares.iter().copied().fold(0.0, f64::max);
    let near = (0..shares.len()).filter(|wheel| shares[*wheel] >= NEARLY * most);
    near.collect()
}

impl Beyond {
    /// Takes in the demand at a time, and returns whether it is the largest so far.
    fn take(&mut self, t_s: f64, used: &AccelerationUse) -> bool {
        self.looks += 1;
        let announced = &mut self.announced;
        let is_most = used.share > announced.share.unwrap_or(f64::INFINITY);
        if is_most {
            announced.most_at_s = t_s;
            announced.wheel = used.by.wheel;
            announced.of_grip = used.by.cause == LimitCause::Grip;
            announced.share = used.share.is_finite().then_some(used.share);
        }
        is_most
    }

    /// A description of it.
    pub fn remark(&self, robot: &Robot) -> String {
        /// Where wheels without load would have to push, no share is enough.
        const OUT_OF_REACH: f64 = 100.0;
        let Announced {
            from_s,
            ref first,
            most_at_s,
            wheel,
            of_grip,
            share,
        } = self.announced;
        let wheel = &robot.wheels[wheel].name;
        let first = named(robot, first);
        let of_what = match of_grip {
            true => "grip on the floor",
            false => "motor's torque",
        };
        let needs = match share {
            Some(share) => format!("needs {:.0} % of its {of_what}", 100.0 * share),
            None => format!("needs more than its {of_what}"),
        };
        let then = match (of_grip, self.together) {
            (false, _) => "it lags, and the robot falls behind or turns towards it".to_owned(),
            // This wheel and the others are short alike.
            (true, Some(together)) if together > OUT_OF_REACH => {
                "all wheels together cannot push that hard, and the robot slides or tips".to_owned()
            }
            (true, Some(together)) if together > 1.0 => format!(
                "all wheels together need {:.0} % of theirs, and the robot slides",
                100.0 * together
            ),
            (true, Some(together)) => format!(
                "it slides until the others take its share, which then need {:.0} % of theirs",
                100.0 * together
            ),
            (true, None) => "it slides".to_owned(),
        };
        format!(
            "the motion is too fast for {:.1} % of the run, from {from_s:.2} s on and first for {first}. At {most_at_s:.2} s wheel `{wheel}` {needs}: {then}; {}",
            100.0 * f64::from(self.looks) / (LOOKS + 1) as f64,
            self.remedy
        )
    }
}

/// Wheels in words.
fn named(robot: &Robot, wheels: &[usize]) -> String {
    if wheels.len() == robot.wheels.len() {
        return "all wheels".to_owned();
    }
    let names = wheels.iter().map(|wheel| &robot.wheels[*wheel].name);
    let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    match names.as_slice() {
        [one] => format!("wheel {one}"),
        names => format!("wheels {} at almost the same time", names.join(", ")),
    }
}

/// The robot with the payloads present at the start of the run.
fn laden(scenario: &Scenario, robot: &Robot) -> Robot {
    let mut laden = robot.clone();
    for fault in &scenario.faults {
        if let Fault::Payload {
            mass_kg,
            x_m,
            y_m,
            z_m,
            ..
        } = *fault
            && fault.is_on(0.0)
        {
            let at_m = place_m(robot, [x_m, y_m, z_m]);
            let mass = &mut laden.chassis.mass;
            let whole_kg = mass.mass_kg + mass_kg;
            let center_m = (mass.mass_kg * mass.center_of_mass_m + mass_kg * at_m) / whole_kg;
            let load = ilon_robot::MassProperties::point(mass_kg, at_m);
            mass.inertia_kg_m2 = mass.inertia_about(&center_m) + load.inertia_about(&center_m);
            (mass.mass_kg, mass.center_of_mass_m) = (whole_kg, center_m);
        }
    }
    laden
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    fn of(lines: &str) -> (Scenario, Robot) {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let text = format!("robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\n{lines}");
        let scenario = Scenario::from_toml(&text, "test", "").expect("a scenario");
        (
            scenario,
            Robot::from_urdf_str(urdf, "mecanum4").expect("a robot"),
        )
    }

    /// The robot's motors turn at 30 rad/s at most.
    #[test]
    fn a_wheel_turns_up_to_the_lowest_of_its_bounds() {
        for (no_load_rate_rad_s, top_rad_s) in [(25.0, 25.0), (40.0, 30.0)] {
            let (scenario, robot) = of(&format!(
                "motors.dc = {{ stall_torque_n_m = 2.0, no_load_rate_rad_s = {no_load_rate_rad_s} }}"
            ));
            assert_eq!(top_rates(&scenario, &robot), [top_rad_s; 4]);
        }
    }

    /// Motors without a largest rate have no top speed, of which there would be shares.
    #[test]
    fn without_a_top_speed_motions_are_evaluated_at_rest_alone() {
        let (scenario, mut robot) = of("");
        for wheel in &mut robot.wheels {
            wheel.motor.velocity_rad_s = f64::INFINITY;
        }
        let limits = Limits::of(&scenario, &robot).expect("it stands");
        let speeds: Vec<f64> = limits.rows.iter().map(|row| row.speed).collect();
        assert_eq!(speeds, vec![0.0; MOTIONS.len()]);
    }

    #[test]
    fn a_floor_that_drags_is_left_out_whatever_the_rollers_are() {
        let (scenario, robot) = of("world.floor.rolling_resistance = 0.01");
        assert_eq!(left_out(&scenario, &robot), ["rolling resistance"]);
        let (scenario, robot) = of("");
        assert!(left_out(&scenario, &robot).is_empty());
    }

    /// Where wheels without load would have to push, a share of the grip would say nothing.
    #[test]
    fn what_no_share_of_the_grip_reaches_is_said_in_words() {
        let (_, robot) = of("");
        let says = |together: f64, words: &str| {
            let announced = Announced {
                from_s: 0.5,
                first: vec![0],
                most_at_s: 1.0,
                wheel: 0,
                of_grip: true,
                share: None,
            };
            let beyond = Beyond {
                announced,
                looks: 1,
                remedy: "command less acceleration",
                together: Some(together),
            };
            let said = beyond.remark(&robot);
            assert!(said.contains(words), "{said}");
        };
        says(0.8, "until the others take its share, which then need 80 %");
        says(2.0, "all wheels together need 200 % of theirs");
        says(
            1e4,
            "all wheels together cannot push that hard, and the robot slides or tips",
        );
    }

    #[test]
    fn wheels_are_named_and_all_of_them_are_all_wheels() {
        let (_, robot) = of("");
        let name = |wheel: usize| format!("`{}`", robot.wheels[wheel].name);
        assert_eq!(named(&robot, &[0, 1, 2, 3]), "all wheels");
        assert_eq!(named(&robot, &[2]), format!("wheel {}", name(2)));
        let some = format!(
            "wheels {}, {}, {} at almost the same time",
            name(0),
            name(1),
            name(3)
        );
        assert_eq!(named(&robot, &[0, 1, 3]), some);
    }
}
