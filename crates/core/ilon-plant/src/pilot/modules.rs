//! Where steered wheels are sent: each module's angle follows the velocity that a twist gives the
//! middle of its wheels.
//!
//! A wheel rolls along u. Its module turns until u lies along v_h = v + omega k x b, eq. (2), or
//! against it, whichever is nearer to where the module is sent now; the wheel then turns the other
//! way. What the wheel turns at while its module is on the way, the kinematics of the measured
//! angles says: u . v_h / rho, the cosine of the missing angle of the whole.
//!
//! **Pairs.** Two driven wheels side by side turn their module too, so that its joint is sent a
//! rate and they turn with it. If the middle of their axle lies at r from the steering axis (an
//! active caster), the module need not wait for an angle: n . (v_h + q'_s k x r) = 0 gives its rate
//! q'_s for any twist, at any angle. Such a base turns on the spot while its wheels stand.

use std::f64::consts::{FRAC_PI_2, PI};

use ilon_control::Kinematics;
use ilon_robot::{Robot, Twist, Wheel, wrap_angle};
use ilon_scenario::course::command::JointCommand;
use ilon_scenario::course::playback::Played;
use ilon_scenario::scenario::{Joint, Scenario};
use nalgebra::{Isometry3, Vector2, Vector3};

/// A wheel that is asked to move slower than this keeps its angle, in m/s (chosen): a robot that
/// has arrived does not turn its modules by the noise of its errors.
const STILL_M_S: f64 = 1e-3;

/// In which a pair without a lever turns to its angle, in seconds, but at least two control
/// periods: its rate is held for one (chosen).
const PAIR_TURNS_S: f64 = 0.1;

/// The modules of a robot that the pilot steers.
#[derive(Clone, Debug)]
pub(super) struct Modules(Vec<Module>);

/// Driven wheels side by side on a steering joint.
#[derive(Clone, Debug)]
struct Pair {
    /// n . (k x r), in metres; 0 without a lever.
    lever_m: f64,
    /// The axis of the joint in the body frame, in metres.
    axis_m: Vector2<f64>,
    /// The fastest that the joint turns, and the rate that it is sent, counter-clockwise, in rad/s.
    limit_rad_s: f64,
    rate_rad_s: f64,
}

/// What a joint steers.
#[derive(Clone, Debug)]
struct Module {
    /// Its steering joint, among the robot's.
    joint: usize,
    wheels: Vec<usize>,
    /// Of a pair.
    pair: Option<Pair>,
    /// 1 where the joint turns counter-clockwise seen from above, else -1.
    sense: f64,
    limits: [f64; 2],
    target_rad: f64,
}

impl Modules {
    /// The tyres of a robot that are steered, but for joints with a target, setpoints or data of a
    /// log; `None` without any. A wheel on rollers moves in every direction at every angle: its joint stays
    /// where it is sent.
    pub fn of(robot: &Robot, scenario: &Scenario, played: &Played) -> Option<Self> {
        let module = |joint: usize| {
            let pair_lever_m = robot.pair_lever_m(joint);
            let is_its = |of: &Wheel| {
                let counts = pair_lever_m.is_none() || of.motor.effort_n_m > 0.0;
                of.has_tyre() && counts && robot.steering_of(of) == Some(joint)
            };
            let wheels = 0..robot.wheels.len();
            let wheels: Vec<usize> = wheels.filter(|at| is_its(&robot.wheels[*at])).collect();
            let of = &robot.joints[joint];
            let asked = scenario.robot.joints.get(&of.name);
            let holds =
                |asked: &Joint| asked.options.target_rad.is_some() || !asked.setpoints.is_empty();
            let is_played = played.joints.iter().any(|(of, _)| *of == joint);
            if wheels.is_empty() || is_played || asked.is_some_and(holds) {
                return None;
            }
            let servo = of.servo()?;
            Some(Module {
                joint,
                wheels,
                pair: pair_lever_m.map(|lever_m| Pair {
                    lever_m,
                    axis_m: of.body_from_joint.translation.vector.xy(),
                    limit_rad_s: servo.rate_limit,
                    rate_rad_s: 0.0,
                }),
                sense: (of.body_from_joint.rotation * Vector3::z()).z.signum(),
                limits: of.limits,
                target_rad: servo.target,
            })
        };
        let modules: Vec<Module> = (0..robot.joints.len()).filter_map(module).collect();
        (!modules.is_empty()).then_some(Self(modules))
    }

    /// Sends them where a twist of the body's origin wants them, with the hubs where they are, and
    /// the joints at these positions, for a control period. Returns the first joint whose limits do
    /// not allow that.
    pub fn aim(
        &mut self,
        twist_in_body: Twist,
        (kinematics, hubs): (&Kinematics, &[Isometry3<f64>]),
        (positions, period_s): (&[f64], f64),
    ) -> Option<usize> {
        let mut beyond = None;
        for module in &mut self.0 {
            let wheels = module.wheels.iter();
            let velocities =
                wheels.filter_map(|at| kinematics.hub_velocity_m_s(*at, twist_in_body));
            let v_h = velocities.sum::<Vector2<f64>>() / module.wheels.len() as f64;
            let n = hubs[module.wheels[0]].rotation * Vector3::z();
            if let Some(pair) = module.pair.as_mut().filter(|pair| pair.lever_m != 0.0) {
                let rate_rad_s = -n.xy().dot(&v_h) / pair.lever_m;
                let stop_rad = module.limits[usize::from(module.sense * rate_rad_s > 0.0)];
                let left_rad = (stop_rad - positions[module.joint]).abs();
                // As far as its stop within the period.
                let most_rad_s = if left_rad > 0.0 {
                    left_rad / period_s
                } else {
                    0.0
                };
                pair.turn(rate_rad_s.clamp(-most_rad_s, most_rad_s));
                let is_stopped = rate_rad_s.abs() > most_rad_s && v_h.norm() >= STILL_M_S;
                beyond = beyond.or(is_stopped.then_some(module.joint));
                continue;
            }
            if v_h.norm() >= STILL_M_S {
                let now_rad = libm::atan2(-n.x, n.y);
                let sent_rad =
                    now_rad + module.sense * (module.target_rad - positions[module.joint]);
                let missing_rad = wrap_angle(libm::atan2(v_h.y, v_h.x) - sent_rad);
                let shorter_rad = if missing_rad.abs() > FRAC_PI_2 {
                    wrap_angle(missing_rad + PI)
                } else {
                    missing_rad
                };
                if !module.send(module.target_rad + module.sense * shorter_rad) {
                    beyond = beyond.or(Some(module.joint));
                }
            }
            let missing_rad = module.target_rad - positions[module.joint];
            if let Some(pair) = &mut module.pair {
                let turns_s = PAIR_TURNS_S.max(2.0 * period_s);
                pair.turn(module.sense * missing_rad / turns_s);
            }
        }
        beyond
    }

    /// The rates that a twist of the body's origin and its rate of change in the body frame take of
    /// modules that turn to an angle, in rad/s, by their joints.
    pub fn turning_rad_s(
        &self,
        robot: &Robot,
        [twist, rate]: [Twist; 2],
    ) -> impl Iterator<Item = (usize, f64)> {
        let turns = |of: &&Module| of.pair.is_none();
        self.0.iter().filter(turns).map(move |module| {
            let of = robot.joints[module.joint].body_from_joint;
            let axis_m = of.translation.vector.xy();
            let [v, a] = [twist, rate].map(|of| of.at(axis_m).linear_m_s());
            // Of atan2(v_y, v_x).
            let is_still = v.norm() < STILL_M_S;
            let rate_rad_s = if is_still {
                0.0
            } else {
                v.perp(&a) / v.norm_squared()
            };
            (module.joint, rate_rad_s)
        })
    }

    /// The commands of the steering joints, by their indices among the robot's.
    pub fn commands(&self) -> impl Iterator<Item = (usize, JointCommand)> {
        self.0.iter().map(|module| {
            let (position, rate) = (module.target_rad, 0.0);
            let command = match &module.pair {
                Some(pair) => JointCommand::Rate(module.sense * pair.rate_rad_s),
                None => JointCommand::Position { position, rate },
            };
            (module.joint, command)
        })
    }

    /// The rates at which the wheels of pairs turn with their modules, in rad/s, by their indices.
    pub fn turning_along(&self, kinematics: &Kinematics) -> impl Iterator<Item = (usize, f64)> {
        let rates = kinematics.rate_matrix();
        self.0.iter().flat_map(move |module| {
            let spin = module
                .pair
                .iter()
                .map(|pair| pair.rate_rad_s * Vector3::new(pair.axis_m.y, -pair.axis_m.x, 1.0));
            let of = move |spin: Vector3<f64>| {
                module
                    .wheels
                    .iter()
                    .map(move |at| (*at, (rates.row(*at) * spin).x))
            };
            spin.flat_map(of)
        })
    }
}

impl Pair {
    fn turn(&mut self, rate_rad_s: f64) {
        self.rate_rad_s = rate_rad_s.clamp(-self.limit_rad_s, self.limit_rad_s);
    }
}

impl Module {
    /// Sends it to an angle, or half a turn from there, or as far as its limits allow. Returns
    /// whether they allow one of the two.
    fn send(&mut self, asked_rad: f64) -> bool {
        let [lower, upper] = self.limits;
        let is_within = |rad: &f64| (lower..=upper).contains(rad);
        let ways = [asked_rad, asked_rad - PI, asked_rad + PI];
        let way_rad = ways.into_iter().find(is_within);
        self.target_rad = way_rad.unwrap_or_else(|| asked_rad.max(lower).min(upper));
        way_rad.is_some()
    }
}

#[cfg(test)]
mod tests {
    use ilon_scenario::robot::load_robot;

    use super::*;

    const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");

    /// The shipped swerve robot, where its joints are at these positions.
    fn aimed(twist: Twist, positions: [f64; 4], begun: [f64; 4]) -> Vec<f64> {
        let text = "robot.file = \"swerve4.urdf\"\ntwist = {}\nrun.duration_s = 1\n";
        let scenario = Scenario::from_toml(text, "aimed", ROBOTS).expect("a scenario");
        let robot = load_robot(&scenario).expect("a shipped robot");
        let mut modules =
            Modules::of(&robot, &scenario, &Played::default()).expect("it is steered");
        for (module, begun_rad) in modules.0.iter_mut().zip(begun) {
            module.target_rad = begun_rad;
        }
        let posed = robot.posed(&positions);
        let hubs = robot.body_from_hubs(&positions);
        let kinematics = Kinematics::new(&posed).expect("it drives");
        modules.aim(twist, (&kinematics, &hubs), (&positions, 0.01));
        modules.0.iter().map(|module| module.target_rad).collect()
    }

    #[test]
    fn a_joint_whose_axis_points_down_turns_the_other_way() {
        let text = "robot.file = \"swerve4.urdf\"\ntwist = {}\nrun.duration_s = 1\n";
        let scenario = Scenario::from_toml(text, "aimed", ROBOTS).expect("a scenario");
        let mut robot = load_robot(&scenario).expect("a shipped robot");
        let joint = robot.steering_of(&robot.wheels[1]).expect("it is steered");
        let over =
            nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        robot.joints[joint].body_from_joint.rotation *= over;
        let modules = Modules::of(&robot, &scenario, &Played::default()).expect("it is steered");
        let senses: Vec<f64> = modules.0.iter().map(|module| module.sense).collect();
        assert_eq!(senses, [1.0, -1.0, 1.0, 1.0]);
    }

    /// Modules stand at (+-0.25, +-0.2) m; v_h = v + omega k x b.
    #[test]
    fn each_module_turns_to_the_velocity_of_its_wheel() {
        let targets = aimed(Twist::new(0.3, 0.2, 0.4), [0.0; 4], [0.0; 4]);
        let places_m = [[0.25, 0.2], [0.25, -0.2], [-0.25, 0.2], [-0.25, -0.2]];
        for (target, [x_m, y_m]) in targets.iter().zip(places_m) {
            let expected = f64::atan2(0.2 + 0.4 * x_m, 0.3 - 0.4 * y_m);
            assert!((target - expected).abs() < 1e-9, "{targets:?}");
        }
    }

    /// To 135 deg from 0 it is 45 deg the other way; from 100 deg, where it is sent already while
    /// it is still at 20 deg, 35 deg on.
    #[test]
    fn a_module_takes_the_shorter_turn_from_where_it_is_sent() {
        let diagonal = Twist::new(-0.3, 0.3, 0.0);
        let from_rest = aimed(diagonal, [0.0; 4], [0.0; 4]);
        assert!(
            from_rest.iter().all(|rad| (rad + 0.25 * PI).abs() < 1e-9),
            "{from_rest:?}"
        );
        let at = 20_f64.to_radians();
        let on_its_way = aimed(diagonal, [at; 4], [100_f64.to_radians(); 4]);
        assert!(
            on_its_way.iter().all(|rad| (rad - 0.75 * PI).abs() < 1e-9),
            "{on_its_way:?}"
        );
    }

    #[test]
    fn a_robot_that_is_asked_to_stand_leaves_its_modules_where_they_are() {
        assert_eq!(
            aimed(Twist::new(1e-4, 1e-4, 0.0), [0.3; 4], [0.4; 4]),
            [0.4; 4]
        );
    }

    /// Two modules are left: one has a target, another setpoints. On omni wheels none is steered.
    #[test]
    fn joints_that_are_sent_elsewhere_and_wheels_on_rollers_are_not_steered() {
        let modules = |keys: &str| {
            let text =
                format!("robot.file = \"swerve4.urdf\"\ntwist = {{}}\nrun.duration_s = 1\n{keys}");
            let scenario = Scenario::from_toml(&text, "sent", ROBOTS).expect("a scenario");
            let robot = load_robot(&scenario).expect("a shipped robot");
            Modules::of(&robot, &scenario, &Played::default()).map_or(0, |modules| modules.0.len())
        };
        let sent = "[robot.joints]\nfront_left_steer = { role = \"driven\", target_rad = 0.5 }\n\
             rear_left_steer = { role = \"driven\", setpoints = [{ t_s = 0, position_rad = 1 }] }\n";
        assert_eq!(modules(""), 4);
        assert_eq!(modules(sent), 2);
        let omni = "[robot.wheels]\nrollers = 8\ngamma.all_deg = 0\njoints = [\"front_left_drive\", \
             \"front_right_drive\", \"rear_left_drive\", \"rear_right_drive\"]\n";
        let driven = ["front_left", "front_right", "rear_left", "rear_right"]
            .map(|at| format!("[robot.joints.{at}_steer]\nrole = \"driven\"\n"));
        assert_eq!(modules(&format!("{omni}{}", driven.concat())), 0);
    }

    #[test]
    fn a_module_with_limits_stays_within_them() {
        let mut module = Module {
            joint: 0,
            wheels: vec![0],
            pair: None,
            sense: 1.0,
            limits: [-1.3, 1.3],
            target_rad: 0.0,
        };
        assert!(module.send(2.0));
        assert!((module.target_rad - (2.0 - PI)).abs() < 1e-12);
        assert!(!module.send(1.5));
        assert!((module.target_rad - 1.3).abs() < 1e-12);
    }
}
