//! Accelerations that are announced as free of slip against the simulated world, on robots that look random.

use std::f64::consts::TAU;

use ilon_sim::control::{AccelerationLimits, LimitSettings, Motor, MotorCurve, PushSharing};
use ilon_sim::formats::{LoadRobot, Spec, generate};
use ilon_sim::robot::{Robot, Twist};
use ilon_sim::simulate::{Commanded, Controller, Moment};
use ilon_sim::{Run, Scenario, Simulation};

/// Numbers in [0, 1) that look random, always the same.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// A robot on a floor, and a direction of acceleration.
struct Case {
    robot: Robot,
    friction: f64,
    slope_deg: f64,
    heading_deg: f64,
    direction: Twist,
}

/// Three to six wheels on rings and axles, wheels of 30 to 80 mm, 2 to 30 kg, the centre of mass up to a fifth off the middle; frictions of
/// 0.1 to 1; slopes up to 10 deg, and to a third of what the floor holds.
fn case(k: u64) -> Case {
    let mut noise = Noise(77 + 1000 * k);
    for _ in 0..4 {
        noise.next();
    }
    let radius_m = noise.between(0.03, 0.08);
    let arm_m = noise.between(3.0, 6.0) * radius_m;
    let half_width_m = noise.between(0.7, 1.2) * arm_m;
    let count = 3 + (k % 4) as usize;
    let (wheels, per_row) = match count {
        3 | 5 => (
            format!(
                "[wheels.ring]\ncount = {count}\ndistance_m = {arm_m}\ngamma_deg = 0.0\nfirst_deg = {}\n",
                noise.between(0.0, 360.0)
            ),
            8 + (6.0 * noise.next()) as usize,
        ),
        4 => (
            format!(
                "[wheels.mecanum]\naxles_m = [{arm_m}, {}]\nhalf_width_m = {half_width_m}\ngamma_deg = 45.0\n",
                -arm_m
            ),
            9 + (6.0 * noise.next()) as usize,
        ),
        _ => (
            format!(
                "[wheels.mecanum]\naxles_m = [{}, 0.0, {}]\nhalf_width_m = {half_width_m}\ngamma_deg = 45.0\n",
                1.3 * arm_m,
                -1.3 * arm_m
            ),
            9 + (6.0 * noise.next()) as usize,
        ),
    };
    let mass_kg = noise.between(2.0, 30.0);
    let (x_m, y_m) = (
        noise.between(-0.2, 0.2) * arm_m,
        noise.between(-0.2, 0.2) * half_width_m,
    );
    let height_m = noise.between(0.8, 2.5) * radius_m;
    let hub_kg = mass_kg * noise.between(0.02, 0.05);
    let spec = format!(
        "name = \"r\"\n[chassis]\nshape.box = {{ size_m = [{}, {}, {}] }}\nmass_kg = {mass_kg}\ncenter_m = [{x_m}, {y_m}, {height_m}]\n\
         [wheel]\nradius_m = {radius_m}\nhub_mass_kg = {hub_kg}\nhub_radius_m = {}\nhub_width_m = {}\nmotor_effort_n_m = 1000.0\n\
         motor_velocity_rad_s = 500.0\n[rollers]\nper_row = {per_row}\nradius_m = {}\nmass_kg = {}\n{wheels}",
        arm_m,
        arm_m,
        radius_m,
        0.6 * radius_m,
        0.8 * radius_m,
        0.24 * radius_m,
        0.03 * hub_kg,
    );
    let spec = Spec::from_toml_str(&spec, "r.toml").expect("a description");
    let robot =
        Robot::from_urdf_str(&generate(&spec).expect("in range"), "r.urdf").expect("a robot");
    let friction = noise.between(0.1, 1.0);
    let most_deg = (friction / 3.0).atan().to_degrees().min(10.0);
    let angle_rad = noise.between(0.0, TAU);
    let turning = if k % 3 == 0 {
        noise.between(-1.0, 1.0) / arm_m
    } else {
        0.0
    };
    Case {
        robot,
        friction,
        slope_deg: if k % 2 == 0 {
            0.0
        } else {
            noise.between(0.0, most_deg)
        },
        heading_deg: noise.between(-180.0, 180.0).round(),
        direction: Twist::new(angle_rad.cos(), angle_rad.sin(), turning),
    }
}

/// Speeds up along a direction by an acceleration that grows smoothly from one time to another and stays.
struct SpeedsUp {
    direction: Twist,
    most: f64,
    speed: f64,
}

const FROM_S: f64 = 0.2;
const GROWS_S: f64 = 0.5;
const HOLDS_S: f64 = 0.15;
const CONTROL_S: f64 = 0.005;

/// The share of the acceleration at a time: 3 u^2 - 2 u^3.
fn grown(t_s: f64) -> f64 {
    let u = ((t_s - FROM_S) / GROWS_S).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

impl Controller for SpeedsUp {
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
        self.speed += CONTROL_S * self.most * grown(now.t_s + 0.5 * CONTROL_S);
        now.kinematics
            .wheel_rates(self.direction.scaled(self.speed), wheels);
        Commanded::Rates
    }
}

impl Case {
    fn limits(&self, sharing: PushSharing) -> AccelerationLimits {
        let settings = LimitSettings {
            friction: self.friction,
            gravity_m_s2: 9.81,
            slope_rad: self.slope_deg.to_radians(),
            downhill_rad: -self.heading_deg.to_radians(),
            sharing,
            share: 1.0,
        };
        AccelerationLimits::new(&self.robot, &settings).expect("limits")
    }

    fn motors(&self) -> Vec<Motor> {
        let wheels = self.robot.wheels.iter();
        wheels
            .map(|wheel| Motor::new(&wheel.motor, MotorCurve::Flat).expect("a motor"))
            .collect()
    }

    fn run(&self, law: &str, most: f64) -> Run {
        let scenario = format!(
            "robot = {{ file = \"\", heading_deg = {}, roller_bodies = \"near\" }}\nworld.floor = {{ slope_deg = {}, friction = {} }}\n\
             twist = {{}}\nwheel_loop = {{ law = \"{law}\", bandwidth_rad_s = 60.0 }}\n\
             run = {{ duration_s = {}, control_dt_s = {CONTROL_S} }}\n",
            self.heading_deg,
            self.slope_deg,
            self.friction,
            FROM_S + GROWS_S + HOLDS_S
        );
        let scenario = Scenario::from_toml(&scenario, "limits", "").expect("a scenario");
        let controller = SpeedsUp {
            direction: self.direction,
            most,
            speed: 0.0,
        };
        Simulation::with_robot_and_controller(&scenario, &self.robot, controller)
            .expect("it stands")
            .run()
    }
}

#[test]
fn explore() {
    for k in 0..20 {
        let case = case(k);
        let mut limits = case.limits(PushSharing::EqualLoops);
        let motors = case.motors();
        let found = limits
            .along(case.direction, Twist::default(), &motors)
            .unwrap();
        let mut used = vec![0.0; motors.len()];
        limits
            .grip_used(
                case.direction.scaled(found.largest),
                Twist::default(),
                &motors,
                &mut used,
            )
            .unwrap();
        let below = case.run("pid", 0.95 * found.largest);
        let above = case.run("pid", 1.3 * found.largest);
        let motor_j = below.summary.energy.motor_j.unwrap();
        let slip = below.summary.slip_energy_j.unwrap() / motor_j;
        // Onset.
        let mut onset = (f64::NAN, 99, f64::NAN);
        'rows: for (record, wheels) in above.trace.steps() {
            for (h, wheel) in wheels.iter().enumerate() {
                if wheel.slip_energy_j > 1e-3 * motor_j && onset.1 == 99 {
                    let v = above
                        .trace
                        .records()
                        .iter()
                        .position(|r| r.t_s == record.t_s)
                        .unwrap();
                    let _ = v;
                    onset = (1.3 * grown(record.t_s), h, record.t_s);
                    break 'rows;
                }
            }
        }
        println!(
            "{k}: n {} mu {:.2} slope {:.1} limit {:.2} wheel {} {:?} | 95 %: slip {:.4} % used {:.3} | onset {:.3} of limit at {:.2} s wheel {} (used {:.3})",
            motors.len(),
            case.friction,
            case.slope_deg,
            found.largest,
            found.wheel,
            found.cause,
            100.0 * slip,
            below.summary.friction_used_max.unwrap_or(f64::NAN),
            onset.0,
            onset.2,
            onset.1,
            used.get(onset.1).copied().unwrap_or(f64::NAN)
        );
    }
}
