//! One wheel under its drive and a load, step by step, against closed forms.

use ilon_robot::TorqueBounds;
use ilon_robot::{
    DriveTrain, Joint, MassProperties, MotorLimits, RollerSurface, RollersAsMade, Wheel,
};
use nalgebra::{Isometry3, Matrix3, Vector3};

use super::*;
use crate::MotorTorque;
use crate::contact::law::{ImpulseProblem, Law, Solver};
use crate::motor_torque::WheelInertia;

const INERTIA_KG_M2: f64 = 7e-3;
const STALL_N_M: f64 = 0.3;
const NO_LOAD_RAD_S: f64 = 20.0;

/// A wheel on an axle, with the energies that entered and left it, in J.
struct Turning {
    wheel: Wheel,
    rate_rad_s: f64,
    motor_n_m: f64,
    motor_j: f64,
    load_j: f64,
    lost_j: f64,
}

impl Turning {
    fn new(efficiency: f64, rotor_kg_m2: f64, friction_n_m: f64) -> Self {
        let drive = DriveTrain {
            gear_efficiency: efficiency,
            rotor_inertia_kg_m2: rotor_kg_m2,
            ..DriveTrain::default()
        };
        let wheel = Wheel {
            name: "w".into(),
            carrier: None,
            body_from_hub: Isometry3::identity(),
            hub: MassProperties {
                mass_kg: 1.0,
                center_of_mass_m: Vector3::zeros(),
                inertia_kg_m2: Matrix3::identity(),
            },
            radius_m: 0.05,
            gamma_rad: 0.0,
            rollers: Vec::new(),
            motor: MotorLimits::default(),
            joint: Joint {
                damping_n_m_s: 0.0,
                friction_n_m,
            },
            drive,
            surface: RollerSurface::default(),
            material: None,
            made: RollersAsMade::default(),
        };
        Self {
            wheel,
            rate_rad_s: 0.0,
            motor_n_m: 0.0,
            motor_j: 0.0,
            load_j: 0.0,
            lost_j: 0.0,
        }
    }

    fn inertia_kg_m2(&self) -> f64 {
        INERTIA_KG_M2 + self.wheel.drive.reflected_inertia_kg_m2()
    }

    fn kinetic_j(&self) -> f64 {
        0.5 * self.inertia_kg_m2() * self.rate_rad_s.powi(2)
    }

    /// One step, solved like in a world: the straight part with the masses, the rest as a curve.
    fn step(&mut self, motor: &MotorTorque, load_n_m: f64, dt_s: f64) {
        let inertia = WheelInertia {
            on_ground_kg_m2: self.inertia_kg_m2(),
            spinning_kg_m2: self.inertia_kg_m2(),
        };
        let law = motor.over(dt_s, inertia);
        let straight = law.straight();
        let own = 1.0 / (self.inertia_kg_m2() + dt_s * straight.droop_n_m_s);
        let before_rad_s = self.rate_rad_s;
        let free_rad_s = before_rad_s + dt_s * (straight.torque_n_m + load_n_m) * own;
        let drive = WheelDrive::new(&law, &self.wheel, before_rad_s, dt_s);
        let mut curve = Curve::default();
        drive.fill_curve(&straight, dt_s, &mut curve);
        for pair in curve.points.windows(2) {
            let above = |[rate, impulse]: [f64; 2]| impulse - rate / own;
            assert!(pair[0][0] <= pair[1][0], "{curve:?}");
            assert!(above(pair[1]) <= above(pair[0]) + 1e-12, "{curve:?}");
        }
        let mut problem = ImpulseProblem::default();
        let place = problem.add_curve(&curve);
        problem.push(Law::Curve { place }, &[free_rad_s]);
        problem.set_delassus(|_, w| w[0] = own);
        let error = Solver::default().solve(&mut problem);
        assert!(error < 1e-8, "{error}");

        self.rate_rad_s = problem.velocities()[0];
        let gained_rad_s = self.rate_rad_s - before_rad_s;
        let straight_n_m = straight.torque_n_m - straight.droop_n_m_s * gained_rad_s;
        let on_wheel_n_m = straight_n_m + problem.impulses()[0] / dt_s;
        self.motor_n_m = drive.motor_n_m(self.rate_rad_s, on_wheel_n_m);
        let turned_rad = 0.5 * (before_rad_s + self.rate_rad_s) * dt_s;
        self.motor_j += self.motor_n_m * turned_rad;
        self.load_j += load_n_m * turned_rad;
        self.lost_j += (self.motor_n_m - on_wheel_n_m) * turned_rad;
    }

    fn balance_j(&self) -> f64 {
        self.motor_j + self.load_j - self.lost_j - self.kinetic_j()
    }
}

/// A motor with a torque demand at a rate, within its line there.
fn dc(torque_n_m: f64, rate_rad_s: f64) -> MotorTorque {
    let fall_n_m_s = STALL_N_M / NO_LOAD_RAD_S;
    let bounds = TorqueBounds {
        least_n_m: -STALL_N_M - fall_n_m_s * rate_rad_s,
        most_n_m: STALL_N_M - fall_n_m_s * rate_rad_s,
        fall_n_m_s,
        ..TorqueBounds::NONE
    };
    MotorTorque {
        bounds,
        ..MotorTorque::constant(torque_n_m)
    }
}

/// S (+-1 - w / w_0) = -load, or the target if a stiff loop reaches it within the lines: at any
/// step.
#[test]
fn a_dc_motor_ends_where_its_lines_meet_the_load_at_any_step() {
    for dt_s in [1e-4, 1e-3, 1e-2] {
        for (asked_n_m, load_n_m) in [(9.0, 0.0), (-9.0, 0.476), (9.0, -0.476), (9.0, 0.2)] {
            let mut wheel = Turning::new(1.0, 0.0, 0.0);
            for _ in 0..(8.0 / dt_s) as usize {
                wheel.step(&dc(asked_n_m, wheel.rate_rad_s), load_n_m, dt_s);
            }
            let expected = NO_LOAD_RAD_S * (asked_n_m.signum() + load_n_m / STALL_N_M);
            // J w_0 / S = 0.47 s: exp(-17) of it is left.
            assert!((wheel.rate_rad_s - expected).abs() < 1e-5 * expected.abs());
            assert!(wheel.balance_j().abs() < 1e-9 * wheel.load_j.abs().max(1.0));
        }
        for target_rad_s in [6.0, 28.0] {
            const GAIN_N_M_S: f64 = 5.0;
            let mut wheel = Turning::new(1.0, 0.0, 0.0);
            for _ in 0..(8.0 / dt_s) as usize {
                let error_rad_s = target_rad_s - wheel.rate_rad_s;
                let mut motor = dc(GAIN_N_M_S * error_rad_s, wheel.rate_rad_s);
                motor.droop_n_m_s = GAIN_N_M_S;
                wheel.step(&motor, 0.476, dt_s);
            }
            let held = NO_LOAD_RAD_S * (0.476 / STALL_N_M - 1.0);
            let expected = f64::max(held, target_rad_s + 0.476 / GAIN_N_M_S);
            assert!(
                (wheel.rate_rad_s - expected).abs() < 1e-5 * expected,
                "{dt_s}"
            );
        }
    }
}

/// A wheel held at 6 rad/s against a load and with it, with and without a rotor: the motor gives
/// (load + friction) / eta, and brakes with (load - friction) (2 - 1 / eta); if that is below zero,
/// it pushes.
#[test]
fn a_gear_passes_power_on_by_its_direction_and_the_energy_closes() {
    for efficiency in [1.0, 0.8, 0.6, 0.5, 0.4] {
        for rotor_kg_m2 in [0.0, 5e-3] {
            for load_n_m in [-0.2, 0.2] {
                let (dt_s, gain_n_m_s) = (1e-3, 2.0);
                let mut wheel = Turning::new(efficiency, rotor_kg_m2, 0.01);
                let mut sum_n_m = 0.0;
                for _ in 0..4000 {
                    let error_rad_s = 6.0 - wheel.rate_rad_s;
                    sum_n_m += 10.0 * error_rad_s * dt_s;
                    let asked_n_m = gain_n_m_s * error_rad_s + sum_n_m;
                    let motor = MotorTorque::with_droop(asked_n_m, gain_n_m_s);
                    wheel.step(&motor, load_n_m, dt_s);
                }
                let needed_n_m = 0.01 - load_n_m;
                let expected_n_m = if needed_n_m > 0.0 {
                    needed_n_m / efficiency
                } else {
                    needed_n_m * (2.0 - 1.0 / efficiency)
                };
                let motor_n_m = wheel.motor_n_m;
                assert!((wheel.rate_rad_s - 6.0).abs() < 1e-4, "{efficiency}");
                assert!(
                    (motor_n_m - expected_n_m).abs() < 1e-4,
                    "{motor_n_m} {expected_n_m}"
                );
                assert!(wheel.balance_j().abs() < 1e-9 && wheel.lost_j > 0.0);
            }
        }
    }
}

/// Without its motor a wheel accelerates a rotor of inertia J with J / (2 - 1 / eta), and a
/// self-locking gear stops it at once.
#[test]
fn a_load_spins_the_rotor_up_through_the_gear_or_is_locked() {
    const LOAD_N_M: f64 = 0.12;
    let after_a_second = |efficiency: f64, rotor_kg_m2: f64, from_rad_s: f64| {
        let mut wheel = Turning::new(efficiency, rotor_kg_m2, 0.0);
        wheel.rate_rad_s = from_rad_s;
        for _ in 0..1000 {
            wheel.step(&MotorTorque::constant(0.0), LOAD_N_M, 1e-3);
        }
        wheel.rate_rad_s
    };
    for (efficiency, rotor_kg_m2) in [
        (1.0, 0.0),
        (0.8, 0.0),
        (1.0, 0.02),
        (0.8, 0.02),
        (0.6, 0.02),
    ] {
        let felt_kg_m2 = INERTIA_KG_M2 + rotor_kg_m2 / (2.0 - 1.0 / efficiency);
        let expected_rad_s = LOAD_N_M / felt_kg_m2;
        let rate_rad_s = after_a_second(efficiency, rotor_kg_m2, 0.0);
        assert!(
            (rate_rad_s / expected_rad_s - 1.0).abs() < 1e-6,
            "{efficiency} {rate_rad_s}"
        );
    }
    for (efficiency, rotor_kg_m2) in [(0.5, 0.0), (0.5, 0.02), (0.4, 0.0), (0.4, 0.02)] {
        for from_rad_s in [0.0, 10.0] {
            let rate_rad_s = after_a_second(efficiency, rotor_kg_m2, from_rad_s);
            assert!(rate_rad_s.abs() < 1e-8, "{efficiency} {rate_rad_s}");
        }
    }
}

/// For any demand within any limits, the curve has one solution, the energy balance closes, and
/// gear and friction only dissipate.
#[test]
fn no_drive_gives_energy_that_its_motor_does_not() {
    // Marsaglia's xorshift: the same numbers in every run.
    let mut state: u64 = 88_172_645_463_325_252;
    let mut draw = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..20_000 {
        let efficiency = [1.0, 0.9, 0.7, 0.55, 0.5, 0.3][(draw() * 6.0) as usize];
        let (rotor_kg_m2, friction_n_m) = (0.02 * draw().round(), 0.05 * draw().round());
        let mut wheel = Turning::new(efficiency, rotor_kg_m2, friction_n_m);
        wheel.rate_rad_s = 40.0 * (draw() - 0.5) * (0.7 * draw() + 0.15).round();
        let mut motor = dc(2.0 * (draw() - 0.5), wheel.rate_rad_s);
        motor.droop_n_m_s = 3.0 * draw() * draw().round();
        motor.bounds.regenerates = draw() < 0.5;
        if draw() < 0.5 {
            motor.bounds.limit_n_m = 0.2 * draw();
        }
        if draw() < 0.3 {
            motor.rate_limit_rad_s = 0.1 + 10.0 * draw();
        }
        let (before_rad_s, before_j) = (wheel.rate_rad_s, wheel.kinetic_j());
        let dt_s = [1e-4, 1e-3, 1e-2][(draw() * 3.0) as usize];
        wheel.step(&motor, 2.0 * (draw() - 0.5), dt_s);
        assert!((wheel.balance_j() + before_j).abs() < 1e-9);
        assert!(wheel.motor_n_m.abs() <= motor.bounds.limit_n_m + 1e-12);
        // A wheel that the step has stopped ends within the solver's tolerance of a rate.
        if before_rad_s * wheel.rate_rad_s > 0.0 && wheel.rate_rad_s.abs() > 1e-8 {
            // The solver ends within 1e-8 rad/s, a droop and a rotor over the step make up to 3e-6
            // N m of it, and a step turns 0.2 rad.
            assert!(wheel.lost_j > -6e-7, "{} J", wheel.lost_j);
        }
    }
}

/// Between its points and beyond them the curve is straight, so it must bend wherever the drive
/// does: at every rate it equals the module's laws of motor, rotor and gear.
#[test]
fn the_curve_is_the_drives_own_law_at_every_rate() {
    let mut seed = 11_u32;
    let mut draw = |low: f64, high: f64| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        low + (high - low) * f64::from(seed >> 8) / f64::from(1 << 24)
    };
    for round in 0..300 {
        let (efficiency, friction_n_m, dt_s) = (0.8, 0.01, 5e-3);
        let turning = Turning::new(efficiency, draw(0.0, 2e-3), friction_n_m);
        let motor = MotorTorque {
            torque_n_m: draw(-0.6, 0.6),
            droop_n_m_s: draw(0.0, 0.2),
            per_acceleration_n_m_s2: 0.0,
            rate_limit_rad_s: f64::INFINITY,
            bounds: TorqueBounds {
                least_n_m: draw(-0.5, 0.0),
                most_n_m: draw(0.0, 0.5),
                fall_n_m_s: draw(0.0, 0.1),
                limit_n_m: draw(0.1, 0.4),
                regenerates: round % 2 == 0,
            },
        };
        let before_rad_s = draw(-5.0, 5.0);
        let drive = WheelDrive::new(&motor, &turning.wheel, before_rad_s, dt_s);
        let mut curve = Curve::default();
        drive.fill_curve(&MotorTorque::constant(0.0), dt_s, &mut curve);
        let rotor_n_m_s = turning.wheel.drive.reflected_inertia_kg_m2() / dt_s;
        let pieces = curve.points.windows(2);
        let pieces =
            pieces.map(|pair| (pair[0], [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]]));
        let inside = pieces.flat_map(|piece| [0.1, 0.5, 0.9].map(|share| (piece, share)));
        let (first, last) = (curve.points[0], curve.points[curve.points.len() - 1]);
        let below = [-0.1, -9.0].map(|share| ((first, curve.ends[0]), share));
        let above = [0.1, 9.0].map(|share| ((last, curve.ends[1]), share));
        for (([u_0, p_0], [u_along, p_along]), share) in inside.chain(below).chain(above) {
            let rate_rad_s = u_0 + share * u_along;
            if u_along < 1e-9 || rate_rad_s == 0.0 {
                continue;
            }
            let way = rate_rad_s.signum();
            let gained_rad_s = rate_rad_s - before_rad_s;
            let geared_n_m = motor.at_gain(gained_rad_s) - rotor_n_m_s * gained_rad_s;
            // Along the motion the mesh takes its share; against it, it helps to brake.
            let on_wheel_n_m = if way * geared_n_m >= 0.0 {
                efficiency * geared_n_m
            } else {
                geared_n_m / (2.0 - 1.0 / efficiency)
            };
            let expected = dt_s * (on_wheel_n_m - way * friction_n_m + rotor_n_m_s * gained_rad_s);
            let found = p_0 + share * p_along;
            assert!((found - expected).abs() < 1e-12, "{motor:?} {rate_rad_s}");
        }
    }
}

/// At its rate limit a motor gives T. The rotor takes J / dt of each rate gained in the step, the
/// gear passes eta of a driving torque and takes 1 / (2 - 1 / eta) of a driven one, and the bearing
/// keeps its friction: from the wheel's torque, T is recovered, in either sense.
#[test]
fn at_its_rate_limit_a_motor_gives_what_the_wheel_takes() {
    let (eta, friction_n_m, dt_s, limit_rad_s) = (0.8, 0.02, 1e-3, 10.0);
    let rotor_kg_m2 = 4e-4;
    let wheel = Turning::new(eta, rotor_kg_m2, friction_n_m).wheel;
    let reflected_kg_m2 = wheel.drive.reflected_inertia_kg_m2();
    for way in [1.0, -1.0] {
        for (gained_rad_s, torque_n_m) in [(0.0, 0.1), (0.5, 0.25), (0.5, 0.1), (0.2, 0.0)] {
            let motor = MotorTorque {
                rate_limit_rad_s: limit_rad_s,
                ..MotorTorque::constant(way * STALL_N_M)
            };
            let before_rad_s = way * (limit_rad_s - gained_rad_s);
            let drive = WheelDrive::new(&motor, &wheel, before_rad_s, dt_s);
            let rotor_n_m = reflected_kg_m2 * gained_rad_s / dt_s;
            let geared_n_m = torque_n_m - rotor_n_m;
            let passed_n_m = if geared_n_m > 0.0 {
                eta * geared_n_m
            } else {
                geared_n_m / (2.0 - 1.0 / eta)
            };
            let on_wheel_n_m = passed_n_m - friction_n_m + rotor_n_m;
            let found_n_m = drive.motor_n_m(way * limit_rad_s, way * on_wheel_n_m);
            // A few sums in f64.
            assert!(
                (found_n_m - way * torque_n_m).abs() < 1e-14,
                "{found_n_m} of {torque_n_m} at {gained_rad_s} rad/s gained"
            );
        }
    }
}
