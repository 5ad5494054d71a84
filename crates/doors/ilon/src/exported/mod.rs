//! A robot with its real rollers in other simulators, and the error of its motion there.
//!
//! The shapes that represent rollers have their own contact kinematics: a robot's motion on them
//! without slip is known before any simulator runs. [`Export::drive`] describes three drives for a
//! simulator, whose measured ratios are shown beside these and ilon's own.

use std::collections::BTreeSet;

use ilon_control::{ContactKinematics, Kinematics};
use ilon_formats::{FittedRobot, Format, Ground, RollerShape, contact_stiffness_n_m, fit};
use ilon_robot::{CollisionShape, JointRole, Pose, Robot, Twist, Wheel, wrap_angle};
use ilon_sim::standard_motions::standard_motions;
use ilon_trace::{Record, WheelSample};
use serde::Serialize;
use serde_json::{Value, json};

mod tyres;

use crate::Error;
use crate::scenario::{Scenario, Setting};
use crate::simulate::{Driver, Plant, Run, Simulation, resolve_for};

/// The program that drives a robot in MuJoCo.
pub const DRIVE_PY: &str = include_str!("drive.py");
/// The program that drives the same file in Newton, beside the other.
pub const DRIVE_NEWTON_PY: &str = include_str!("drive_newton.py");

/// Durations of rest, acceleration and settling before a drive is measured, in seconds; chosen.
const REST_S: f64 = 0.5;
const RAMP_S: f64 = 0.5;
const SETTLE_S: f64 = 1.0;
const SETTLED_S: f64 = REST_S + RAMP_S + SETTLE_S;
/// Least duration of the measurement, in seconds, over whole turns of the fastest wheel; chosen.
const LEAST_WINDOW_S: f64 = 3.0;

/// A robot in one format, with its motion there.
#[derive(Clone, Debug)]
pub struct Export {
    /// The robot with shapes of the format.
    pub fitted: FittedRobot,
    /// Floor and gravity.
    pub ground: Ground,
    /// Its motions ahead, sideways and on the spot.
    pub drives: Vec<Drive>,
    format: Format,
    /// Whether the scenario's floor is more than a level plane.
    has_relief: bool,
}

/// One drive: a twist along one axis of the body frame. Ratios are speeds over those of ideal
/// kinematics.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Drive {
    /// `ahead`, `left` or `turn`.
    pub name: &'static str,
    /// By contact kinematics of the real rollers.
    pub as_made: f64,
    /// By contact kinematics of the fitted shapes.
    pub expected: f64,
    /// In ilon's simulation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ilon: Option<f64>,
    /// In the other simulator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<f64>,
    /// Vertical travel of the base there, in mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub travel_mm: Option<f64>,
    /// Of the twist: ahead, left, turn.
    #[serde(skip)]
    axis: usize,
    #[serde(skip)]
    twist_in_body: Twist,
    #[serde(skip)]
    lasts_s: f64,
    /// For a program that plays it.
    #[serde(skip)]
    told: Value,
}

/// The component of a twist along an axis of the body frame: ahead, left, turn.
fn along(twist: Twist, axis: usize) -> f64 {
    [twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s][axis]
}

impl Export {
    /// A robot with the motors and rollers of a scenario, on the shapes of a format.
    ///
    /// # Errors
    /// A robot that is not omnidirectional, rollers without a shape in the format, and an invalid
    /// simulation.
    pub fn new(scenario: &Scenario, robot: &Robot, format: Format) -> Result<Self, Error> {
        let plant = Plant::new(&resolve_for(scenario, robot, Driver::Own)?, robot)?;
        let fitted = fit(robot, format);
        if format != Format::Mjcf && fitted.shapes.iter().flatten().any(is_hull) {
            return Err(Error::invalid(
                "its rollers are convex hulls, which SDF and URDF have no shape for",
                "export --mjcf, or leave --as-modelled out",
            ));
        }
        let floor = &scenario.world.floor;
        let has_relief = floor.slope_deg != 0.0 || !floor.is_plane() || !floor.patches.is_empty();
        let mut drives = Vec::new();
        for motion in standard_motions(robot)?.into_iter().flatten() {
            let mut names = ["ahead", "left", "turn"].iter();
            let axis = names.position(|name| *name == motion.name);
            let twist_in_body = motion.twist_in_body;
            let positions = tyres::positions(robot, twist_in_body);
            let (Some(axis), Some(positions)) = (axis, positions) else {
                continue;
            };
            let posed = robot.posed(&positions);
            let kinematics = Kinematics::new(&posed)?;
            let mut rates_rad_s = vec![0.0; kinematics.wheel_count()];
            kinematics.wheel_rates(kinematics.reachable(twist_in_body), &mut rates_rad_s);
            let fastest = rates_rad_s.iter().fold(0.0, |a: f64, r| a.max(r.abs()));
            let turn_s = std::f64::consts::TAU / fastest;
            let lasts_s = turn_s * (LEAST_WINDOW_S / turn_s).ceil();
            let ratio = |robot: &Robot| -> Result<f64, Error> {
                let contact = ContactKinematics::new(robot)?;
                let mean = mean_speed(contact, &rates_rad_s, lasts_s, axis);
                Ok(mean / along(twist_in_body, axis))
            };
            let end_s = SETTLED_S + lasts_s;
            let driven = tyres::driven(robot).into_iter();
            let driven = driven.map(|wheel| rates_rad_s[wheel]);
            drives.push(Drive {
                name: motion.name,
                as_made: ratio(&posed)?,
                expected: ratio(&fitted.robot.posed(&positions))?,
                ilon: None,
                measured: None,
                travel_mm: None,
                axis,
                twist_in_body,
                lasts_s,
                told: json!({
                    "name": motion.name,
                    "rate_matrix": tyres::rows(&posed, &kinematics)?,
                    "steering": tyres::named(robot, &positions),
                    "axis": axis,
                    "times_s": [0.0, REST_S, REST_S + RAMP_S, end_s],
                    "rates_rad_s": driven.map(|rate| [0.0, 0.0, rate, rate]).collect::<Vec<_>>(),
                    "window_s": [SETTLED_S, end_s],
                }),
            });
        }
        Ok(Self {
            fitted,
            ground: Ground {
                friction: plant.floor_friction(),
                gravity_m_s2: scenario.world.gravity_m_s2,
            },
            drives,
            format,
            has_relief,
        })
    }

    /// Simulates the drives in ilon, with contacts as stiff as those of the MJCF; `robot` is the
    /// one before the scenario's keys are applied.
    ///
    /// # Errors
    /// If the simulation is invalid.
    pub fn simulate(
        &mut self,
        robot: &Robot,
        settings: &[Setting],
        files: &ilon_files::FileAccess,
    ) -> Result<(), Error> {
        // Where hubs rise and fall, the stiffness decides how wheels share the load, and so where
        // they slip. Treads and tyres have their own.
        let is_soft = |of: &Wheel| of.surface.tread.is_some() || of.has_tyre();
        let stiffness = match robot.wheels.iter().any(is_soft) {
            true => String::new(),
            false => format!(
                "world.solver.contact_stiffness_n_m = {:?}\n",
                contact_stiffness_n_m(robot)
            ),
        };
        for drive in &mut self.drives {
            let [vx, vy, omega] = [0, 1, 2].map(|axis| along(drive.twist_in_body, axis));
            let text = format!(
                "robot.file = \"\"\ntwist = {{ vx_m_s = {vx}, vy_m_s = {vy}, omega_rad_s = {omega}, rest_s = {REST_S:?}, ramp_s = {RAMP_S:?}, settle_s = {SETTLE_S:?} }}\n{stiffness}run.duration_s = {:?}\n",
                SETTLED_S + drive.lasts_s
            );
            let scenario = Scenario::from_toml_with(&text, "a drive", "", settings, files)?;
            let run = Simulation::with_robot(&scenario, robot)?.run();
            let ratio = run.summary.twist_ratio_ideal;
            drive.ilon = [ratio.vx, ratio.vy, ratio.omega][drive.axis];
        }
        Ok(())
    }

    /// The input of [`DRIVE_PY`] to drive the model in a file.
    pub fn drive(&self, model: &str) -> Value {
        let robot = &self.fitted.robot;
        let driven = tyres::driven(robot);
        let names = driven.iter().map(|wheel| &robot.wheels[*wheel].name);
        let drives = self.drives.iter().map(|drive| &drive.told);
        json!({
            "model": model,
            "wheels": names.collect::<Vec<_>>(),
            "on_tyres": self.is_on_tyres(),
            "drives": drives.collect::<Vec<_>>(),
        })
    }

    /// Stores what a simulator measured.
    pub fn take(&mut self, measured: &Value) {
        let said = measured["drives"].as_array().into_iter().flatten();
        for (drive, said) in self.drives.iter_mut().zip(said) {
            drive.measured = said["ratio"].as_f64();
            drive.travel_mm = said["travel_mm"].as_f64();
        }
    }

    /// The drive with the largest difference of a simulator, as a share of the ideal speed: from
    /// ilon, or from contact kinematics where ilon did not simulate it. `None` if nothing was
    /// measured.
    pub fn furthest(&self) -> Option<(&'static str, f64)> {
        let off = |drive: &Drive| {
            let off = (drive.measured? - drive.ilon.unwrap_or(drive.expected)).abs();
            Some((drive.name, off))
        };
        let offs = self.drives.iter().filter_map(off);
        offs.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// A run of ilon for playback in a simulator: the angles and rates of its wheels, its start and
    /// end poses, and how far the fitted shapes change the end.
    ///
    /// # Errors
    /// Where the robot has no contact kinematics.
    pub fn trace(&self, robot: &Robot, run: &Run) -> Result<Value, Error> {
        let mut wheels = robot.wheels.iter();
        if let Some(wheel) = wheels.find(|wheel| tyres::steering(robot, wheel).is_some()) {
            let name = &wheel.name;
            return Err(Error::invalid(
                format!("what is played back are the angles of wheels, and `{name}` is steered"),
                "export the robot alone, without --scenario",
            ));
        }
        let steps: Vec<_> = run.trace.steps().collect();
        let driven = tyres::driven(robot);
        let of = |value: fn(&WheelSample) -> f64| -> Vec<Vec<f64>> {
            let of_wheel = |wheel| steps.iter().map(move |(_, of)| value(&of[wheel])).collect();
            driven.iter().copied().map(of_wheel).collect()
        };
        let pose = |of: Option<&(&Record, &[WheelSample])>| {
            of.map_or(Pose::default(), |of| of.0.truth.pose)
        };
        let (start, end) = (pose(steps.first()), pose(steps.last()));
        let led = |robot: &Robot| -> Result<Pose, Error> {
            let mut contact = ContactKinematics::new(robot)?;
            let mut pose = start;
            for pair in steps.windows(2) {
                let (before, after) = (pair[0].1.iter(), pair[1].1.iter());
                let wheels = before.zip(after).map(|(a, b)| (a.angle_rad, b.angle_rad));
                let (angles, turned): (Vec<f64>, Vec<f64>) =
                    wheels.map(|(a, b)| (0.5 * (a + b), b - a)).unzip();
                // With turned angles in place of rates it is a displacement.
                pose = pose.moved(contact.twist(&angles, &turned));
            }
            Ok(pose)
        };
        let (made, shown) = (led(robot)?, led(&self.fitted.robot)?);
        let turn_rad = wrap_angle(shown.heading_rad - made.heading_rad);
        let as_list = |pose: Pose| [pose.x_m, pose.y_m, pose.heading_rad];
        Ok(json!({
            "times_s": steps.iter().map(|(row, _)| row.t_s).collect::<Vec<_>>(),
            "rates_rad_s": of(|wheel| wheel.rate_rad_s),
            "angles_rad": of(|wheel| wheel.angle_rad),
            "start": as_list(start),
            "end": as_list(end),
            "geometry": [shown.x_m - made.x_m, shown.y_m - made.y_m, turn_rad],
        }))
    }

    /// The comment at the head of a file.
    pub fn about(&self) -> String {
        let fitted = &self.fitted;
        let robot = &fitted.robot;
        let (one, all) = match robot.has_tyres() {
            true => ("tyre", "Tyres"),
            false => ("roller", "Rollers"),
        };
        let [error, travel, as_made] =
            [fitted.error_m, fitted.travel_m, fitted.travel_as_made_m].map(|m| 1e3 * m);
        let (name, version) = (&robot.name, env!("CARGO_PKG_VERSION"));
        let (shapes, friction) = (self.shapes().join(", or "), self.ground.friction);
        let speed = |of: &Drive| format!(" {} {:.4} {:.4};", of.name, of.as_made, of.expected);
        let speeds: String = self.drives.iter().map(speed).collect();
        let mut text = format!(
            "     The robot `{name}` with its wheels as made, by ilon {version}. A {one} is {shapes}.\n     \
             Error of a hub's height by these shapes: {error:.4} mm at most over a turn; travel {travel:.4} mm, of the wheels as made {as_made:.4} mm.\n     \
             Speed over ideal kinematics, without slip, as made and on these shapes:{speeds}\n     \
             Motors hold the rates of wheels. Floor of friction {friction}. {all} meet the world, not their robot."
        );
        if robot.has_tyres() && self.format != Format::Mjcf {
            text += "\n     A tyre's cylinder is as long as makes it resist a turn on the spot as the tyre does: mu N length / 2.";
        }
        let left_out = self.left_out();
        if !left_out.is_empty() {
            text += &format!("\n     Left out: {}.", left_out.join(", "));
        }
        text
    }

    /// Whether its wheels roll on tyres.
    pub fn is_on_tyres(&self) -> bool {
        self.fitted.robot.has_tyres()
    }

    /// The kinds of shapes of its rollers, or of its tyres.
    pub fn shapes(&self) -> Vec<String> {
        let shapes = self.fitted.shapes.iter().flatten();
        let names: BTreeSet<String> = shapes.map(RollerShape::name).collect();
        names.into_iter().collect()
    }

    /// What of the robot is not in the files.
    pub fn left_out(&self) -> Vec<&'static str> {
        let robot = &self.fitted.robot;
        let any = |has: fn(&Wheel) -> bool| robot.wheels.iter().any(has);
        let joints = |has: fn(&JointRole) -> bool| {
            self.format == Format::Urdf && robot.joints.iter().any(|of| has(&of.role))
        };
        let left_out = [
            ("treads of rollers", any(|of| of.surface.tread.is_some())),
            (
                "rolling resistance of rollers",
                any(|of| of.surface.rolling_resistance != 0.0),
            ),
            (
                "play of rollers along their axles",
                any(|of| of.surface.axial_play_m != 0.0),
            ),
            (
                "friction of axles that grows with the load",
                any(|of| of.surface.axle_friction != 0.0),
            ),
            (
                "efficiency of gears",
                any(|of| of.drive.gear_efficiency != 1.0),
            ),
            (
                "springs of joints",
                joints(|of| matches!(of, JointRole::Sprung(_))),
            ),
            (
                "servos of joints",
                joints(|of| matches!(of, JointRole::Driven(_))),
            ),
            ("all of the floor but a level plane", self.has_relief),
        ];
        let left_out = left_out.into_iter().filter(|(_, is_there)| *is_there);
        left_out.map(|(words, _)| words).collect()
    }
}

/// Whether a roller is a convex hull in its file.
fn is_hull(shape: &RollerShape) -> bool {
    let RollerShape::Solids(solids) = shape else {
        return false;
    };
    let mut shapes = solids.iter().map(|solid| &solid.shape);
    shapes.any(|shape| matches!(shape, CollisionShape::ConvexHull { .. }))
}

/// The mean speed along an axis without slip at these rates of wheels, in m/s or rad/s.
fn mean_speed(
    mut contact: ContactKinematics,
    rates_rad_s: &[f64],
    lasts_s: f64,
    axis: usize,
) -> f64 {
    const LOOKS: usize = 3600;
    let look = |k: usize| {
        // The middle of each step, so that no look falls on a hand-over.
        let time_s = lasts_s * (k as f64 + 0.5) / LOOKS as f64;
        let angles: Vec<f64> = rates_rad_s.iter().map(|rate| rate * time_s).collect();
        along(contact.twist(&angles, rates_rad_s), axis)
    };
    (0..LOOKS).map(look).sum::<f64>() / LOOKS as f64
}
