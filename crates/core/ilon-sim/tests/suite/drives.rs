//! Motors, gears and batteries in all four quadrants, compared with closed forms.
//!
//! A robot with four wheels of radius rho on a slope of angle a, heading down it, is pulled by G =
//! m g sin(a) rho / 4 at each wheel; the bearing takes d w. A DC motor of stall torque S and
//! no-load rate w_0 at the share u of its voltage gives S (u - w / w_0).

use std::path::Path;

use ilon_sim::robot::Robot;
use ilon_sim::world::World;
use ilon_sim::{Plant, Run, Scenario, WheelCommand, load_robot, resolve, run};
use test_case::test_case;

const STALL_N_M: f64 = 0.3;
const NO_LOAD_RAD_S: f64 = 20.0;
/// Bearing damping of each of the robot's wheels.
const DAMPING_N_M_S: f64 = 1e-3;
const RADIUS_M: f64 = 0.05;
const DC: &str = "[motors.dc]\nstall_torque_n_m = 0.3\nno_load_rate_rad_s = 20\n";
/// Tolerance of a steady rate: closed forms leave out impacts at hand-overs, and the rollers'
/// bearings.
const STEADY: f64 = 3e-3;

/// The floor has enough friction for steep slopes: the wheels with the least load hold 0.6 of it on
/// 20 degrees.
fn scenario(slope_deg: f64, further: &str) -> (Scenario, Robot) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!(
        "robot = {{ file = \"mecanum4.urdf\", roller_bodies = \"near\" }}\nworld.floor = {{ slope_deg = {slope_deg}, friction = 1.0 }}\n{further}"
    );
    let scenario = Scenario::from_toml(&text, "drives", folder).expect("a scenario");
    let robot = load_robot(&scenario).expect("a shipped robot");
    (scenario, robot)
}

fn robot() -> Robot {
    scenario(0.0, "twist = {}\nrun.duration_s = 1\n").1
}

/// Torque of the slope at each wheel, in N m.
fn pull_n_m(robot: &Robot, slope_deg: f64) -> f64 {
    robot.mass_kg() * 9.81 * slope_deg.to_radians().sin() * RADIUS_M / 4.0
}

/// Total energy of a world plus all losses minus the motors' work, in J: constant.
fn balance_j(world: &World) -> f64 {
    let energy = world.energy();
    energy.kinetic_j
        + energy.potential_j
        + world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.impact_energy_j()
        + world.bearing_energy_j()
        - world.motor_energy_j()
}

/// A plant after a time at full voltage of a sign, with the robot's mean wheel rate, in rad/s; its
/// energy balance is checked.
fn at_full_voltage(slope_deg: f64, sign: f64, further: &str, time_s: f64) -> (Plant, f64) {
    let (scenario, robot) = scenario(
        slope_deg,
        &format!(
            "twist = {{}}\nrun = {{ duration_s = 9, physics_dt_s = 0.002, control_dt_s = 0.01 }}\n{further}"
        ),
    );
    let mut plant =
        Plant::new(&resolve(&scenario, &robot).expect("resolved"), &robot).expect("it stands");
    // It stands before it is driven, which loads its springs.
    let (before_j, height_j) = (balance_j(plant.world()), plant.world().energy().potential_j);
    plant
        .advance(WheelCommand::Torques(&[sign * 1e3; 4]), time_s)
        .expect("it drives");
    let world = plant.world();
    let turned_over_j =
        world.motor_energy_j().abs() + (world.energy().potential_j - height_j).abs();
    let unexplained_j = balance_j(world) - before_j;
    assert!(
        unexplained_j.abs() < 1e-3 * turned_over_j + 1e-3,
        "{unexplained_j} J of {turned_over_j} J"
    );
    let rates = world.robot().wheel_rates_rad_s();
    let mean_rad_s = rates.iter().sum::<f64>() / 4.0;
    for rate in rates {
        // Nothing controls the heading: the slope amplifies rotations by rounding.
        let off_rad_s = (rate - mean_rad_s).abs();
        assert!(
            off_rad_s < 1e-2 + 1e-3 * mean_rad_s.abs(),
            "left and right alike: {rates:?}"
        );
    }
    (plant, mean_rad_s)
}

/// S (u - w / w_0) + G = d w: the motor drives, is driven backwards, brakes at full reverse, or
/// overruns its no-load rate at full forward; with zero voltage, it is shorted.
#[test_case(0.0, 1.0, 1.0; "ahead on the level")]
#[test_case(0.0, -1.0, 1.0; "back on the level")]
#[test_case(20.0, -1.0, 1.0; "full reverse against a load that drives ahead")]
#[test_case(-20.0, 1.0, 1.0; "full forward against a load that drives back")]
#[test_case(10.0, -1.0, 1.0; "full reverse up a slope that it can climb")]
#[test_case(12.0, 1.0, 1.0; "full forward beyond the no-load rate")]
#[test_case(-12.0, -1.0, 1.0; "full reverse beyond the no-load rate")]
#[test_case(12.0, 1.0, 0.5; "full forward on half of the supply")]
#[test_case(20.0, -1.0, 0.5; "full reverse on half of the supply")]
#[test_case(20.0, -1.0, 0.0; "shorted by a supply that is gone")]
fn a_dc_motor_settles_where_its_line_meets_its_load(slope_deg: f64, sign: f64, share: f64) {
    let (plant, rate_rad_s) = at_full_voltage(
        slope_deg,
        sign,
        &format!("{DC}[[faults]]\nbattery_sag = {{ share = {share} }}\n"),
        5.0,
    );
    let pull_n_m = pull_n_m(plant.robot(), slope_deg);
    let expected_rad_s =
        (sign * share * STALL_N_M + pull_n_m) / (STALL_N_M / NO_LOAD_RAD_S + DAMPING_N_M_S);
    println!("{rate_rad_s} {expected_rad_s}");
    assert!(
        (rate_rad_s - expected_rad_s).abs() < STEADY * expected_rad_s.abs().max(1.0),
        "{rate_rad_s} rad/s for {expected_rad_s}"
    );
}

/// A shorted winding brakes by S w / w_0; a lost motor lets the wheel run: m v' = m g sin(a) - 4 d
/// w / rho.
#[test]
fn a_shorted_motor_brakes_and_a_lost_one_coasts() {
    let lost = |further: &str| {
        let faults: String = ["front_left", "front_right", "rear_left", "rear_right"]
            .map(|wheel| format!("[[faults]]\nmotor_lost = {{ wheel = \"{wheel}\"{further} }}\n"))
            .concat();
        at_full_voltage(10.0, 1.0, &format!("{DC}{faults}"), 3.0)
    };
    let (plant, rate_rad_s) = lost(", shorted = true");
    let pull_n_m = pull_n_m(plant.robot(), 10.0);
    let expected_rad_s = pull_n_m / (STALL_N_M / NO_LOAD_RAD_S + DAMPING_N_M_S);
    println!("{rate_rad_s} {expected_rad_s}");
    assert!((rate_rad_s / expected_rad_s - 1.0).abs() < STEADY);

    let (plant, rate_rad_s) = lost("");
    assert_eq!(plant.world().motor_energy_j(), 0.0);
    let inertia_kg_m2 = 4.0 * wheel_inertia_kg_m2(plant.robot());
    let time_s = inertia_kg_m2 / 4.0 / DAMPING_N_M_S;
    let expected_rad_s = pull_n_m / DAMPING_N_M_S * (1.0 - (-3.0 / time_s).exp());
    println!("{rate_rad_s} {expected_rad_s}");
    assert!((rate_rad_s / expected_rad_s - 1.0).abs() < 1e-2);
}

/// Inertia at a wheel of a robot that moves straight: hub and rollers about its axle, and its share
/// of the mass, in kg m^2.
fn wheel_inertia_kg_m2(robot: &Robot) -> f64 {
    let wheel = &robot.wheels[0];
    let rollers = wheel.rollers.iter().map(|roller| {
        roller.mass_kg * roller.center_in_hub_m.xy().norm_squared()
            + roller.transverse_inertia_kg_m2
    });
    wheel.hub.inertia_kg_m2[(2, 2)]
        + rollers.sum::<f64>()
        + robot.mass_kg() / 4.0 * RADIUS_M * RADIUS_M
}

/// A current limit of 0.1 N m limits a motor that drives up a gentle slope, and one that brakes on
/// a steep one, in either sense.
#[test]
fn a_current_limit_holds_the_torque_that_drives_and_the_torque_that_brakes() {
    let limited = format!("{DC}current_limit_n_m = 0.1\n");
    for (slope_deg, sign) in [(3.0, -1.0), (-3.0, 1.0), (20.0, -1.0), (-20.0, 1.0)] {
        let (plant, rate_rad_s) = at_full_voltage(slope_deg, sign, &limited, 0.4);
        for torque_n_m in plant.world().robot().motor_torques_n_m() {
            assert!((torque_n_m - sign * 0.1).abs() < 1e-9, "{torque_n_m} N m");
        }
        let net_n_m = pull_n_m(plant.robot(), slope_deg) + sign * 0.1;
        let expected_rad_s = net_n_m * 0.4 / wheel_inertia_kg_m2(plant.robot());
        println!("{rate_rad_s} {expected_rad_s}");
        // Damping and the first contact take some of it.
        assert!((rate_rad_s / expected_rad_s - 1.0).abs() < 0.05);
    }
}

/// Without regeneration, full voltage does not brake a motor that its load overruns: it coasts. It
/// still brakes at reverse.
#[test]
fn without_regeneration_a_motor_coasts_beyond_its_no_load_rate() {
    let refuses = format!("{DC}regeneration = false\n");
    let (plant, rate_rad_s) = at_full_voltage(12.0, 1.0, &refuses, 3.0);
    assert!(rate_rad_s > 30.0, "{rate_rad_s}");
    for torque_n_m in plant.world().robot().motor_torques_n_m() {
        assert_eq!(*torque_n_m, 0.0);
    }
    let (plant, rate_rad_s) = at_full_voltage(20.0, -1.0, &refuses, 6.0);
    let pull_n_m = pull_n_m(plant.robot(), 20.0);
    let expected_rad_s = (pull_n_m - STALL_N_M) / (STALL_N_M / NO_LOAD_RAD_S + DAMPING_N_M_S);
    assert!((rate_rad_s / expected_rad_s - 1.0).abs() < STEADY);
}

fn driven(slope_deg: f64, further: &str) -> Run {
    run(&scenario(slope_deg, further).0).expect("it runs")
}

/// The mean of the wheels' rates and torques over the last half second of a run, in rad/s and N m.
/// The share of a load among self-locking gears is arbitrary.
fn end_of(run: &Run) -> (f64, f64) {
    let rows = run.trace.records().len();
    let last = rows - rows / 8..rows;
    let count = last.len() as f64;
    let (mut rate_rad_s, mut torque_n_m) = (0.0, 0.0);
    for row in last {
        for wheel in run.trace.wheels_at(row) {
            rate_rad_s += 0.25 * wheel.rate_rad_s / count;
            torque_n_m += 0.25 * wheel.torque_n_m / count;
        }
    }
    (rate_rad_s, torque_n_m)
}

/// Down 20 degrees, where each wheel is pulled with 0.476 N m: 0.3 m/s are beyond the reach of 0.3
/// N m of stall torque, and the robot moves as fast as full reverse allows; from 0.9 m/s on
/// back-EMF holds it at its target. Both timings of the loop agree.
#[test_case("continuous")]
#[test_case("sampled")]
fn a_robot_on_a_steep_slope_is_held_within_its_motors_lines(timing: &str) {
    for asked_m_s in [0.3, 0.9, 1.2, 1.4] {
        let run = driven(
            20.0,
            &format!(
                "twist = {{ vx_m_s = {asked_m_s} }}\nwheel_loop.timing = \"{timing}\"\nrun.duration_s = 4\n{DC}"
            ),
        );
        let robot = robot();
        let least_rad_s =
            (pull_n_m(&robot, 20.0) - STALL_N_M) / (STALL_N_M / NO_LOAD_RAD_S + DAMPING_N_M_S);
        let expected_rad_s = f64::max(asked_m_s / RADIUS_M, least_rad_s);
        let (rate_rad_s, torque_n_m) = end_of(&run);
        println!("{timing} {asked_m_s}: {rate_rad_s} {expected_rad_s} rad/s, {torque_n_m} N m");
        assert!(
            (rate_rad_s / expected_rad_s - 1.0).abs() < 1e-2,
            "{asked_m_s} m/s"
        );
        let last = run.trace.records().last().expect("rows").truth;
        let (aside_m, turned_rad) = (last.pose.y_m, last.pose.heading_rad);
        assert!(
            aside_m.abs() < 5e-3 && turned_rad.abs() < 5e-3,
            "{aside_m} m, {turned_rad} rad"
        );
        for row in 1..run.trace.records().len() {
            let (before, now) = (run.trace.wheels_at(row - 1), run.trace.wheels_at(row));
            for (before, now) in before.iter().zip(now) {
                // Rows have the mean torque: it is within the line at the smallest and at the
                // largest of the surrounding rates.
                let fastest = before.rate_rad_s.max(now.rate_rad_s) + 0.05;
                let slowest = before.rate_rad_s.min(now.rate_rad_s) - 0.05;
                let least_n_m = STALL_N_M * (-1.0 - fastest / NO_LOAD_RAD_S);
                let most_n_m = STALL_N_M * (1.0 - slowest / NO_LOAD_RAD_S);
                assert!(
                    (least_n_m..=most_n_m).contains(&now.torque_n_m),
                    "{} N m at {} rad/s",
                    now.torque_n_m,
                    now.rate_rad_s
                );
            }
        }
    }
}

/// A drive ahead down a slope equals one backwards down the mirrored slope, rate by rate.
#[test]
fn a_slope_and_a_motion_that_are_mirrored_are_driven_alike() {
    let down = |sign: f64| {
        driven(
            20.0 * sign,
            &format!(
                "twist = {{ vx_m_s = {} }}\nrun.duration_s = 2\n{DC}",
                0.3 * sign
            ),
        )
    };
    let (ahead, back) = (end_of(&down(1.0)), end_of(&down(-1.0)));
    // The rollers' phases differ.
    assert!(
        (ahead.0 + back.0).abs() < 1e-2 * ahead.0,
        "{ahead:?} {back:?}"
    );
    assert!(
        (ahead.1 + back.1).abs() < 1e-2 * ahead.1.abs(),
        "{ahead:?} {back:?}"
    );
}

/// A sampled loop converges to the continuous loop as its period falls.
#[test]
fn both_timings_come_to_the_same_as_the_period_falls() {
    let end_m = |timing: &str, dt_s: f64| {
        let gains = "proportional_n_m_s = 0.01, integral_n_m = 0.05";
        let run = driven(
            15.0,
            &format!(
                "twist = {{ vx_m_s = 0.4, rest_s = 0.2 }}\nwheel_loop = {{ timing = \"{timing}\", {gains} }}\n\
                 run = {{ duration_s = 2, physics_dt_s = {dt_s}, control_dt_s = 0.02 }}\n{DC}"
            ),
        );
        run.trace.records().last().expect("rows").truth.pose.x_m
    };
    let limit_m = end_m("continuous", 2.5e-4);
    let off_m: Vec<f64> = [4e-3, 1e-3, 2.5e-4]
        .map(|dt_s| (end_m("sampled", dt_s) - limit_m).abs())
        .to_vec();
    println!("{limit_m} m, off by {off_m:?}");
    // First order: a quarter of the step, a quarter of the distance. The contacts' dependence on
    // the step is below 1e-4 m.
    assert!(off_m[2] < 0.3 * off_m[0] + 1e-4, "{off_m:?}");
    assert!(off_m[2] < 1e-3 * limit_m, "{off_m:?}");
    // A continuous loop is accurate at long steps.
    assert!((end_m("continuous", 4e-3) - limit_m).abs() < 2e-3 * limit_m);
}

/// The gear passes eta of the motor's power to a wheel that drives up; down the slope the motor
/// brakes with 2 - 1 / eta of the wheel's torque. Below one half that is negative: the gear is
/// self-locking, and the motor pushes the load down.
#[test_case(0.8)]
#[test_case(0.6)]
#[test_case(0.5)]
#[test_case(0.4)]
fn a_gear_loses_by_the_direction_of_power(efficiency: f64) {
    const SLOPE_DEG: f64 = 5.0;
    let geared = |vx_m_s: f64| {
        driven(
            SLOPE_DEG,
            &format!(
                "twist = {{ vx_m_s = {vx_m_s} }}\nmotors.gear_efficiency = {efficiency}\nrun.duration_s = 4\n"
            ),
        )
    };
    let robot = robot();
    let (pull_n_m, bearing_n_m) = (pull_n_m(&robot, SLOPE_DEG), 6.0 * DAMPING_N_M_S);

    let up = geared(-0.3);
    let (rate_rad_s, torque_n_m) = end_of(&up);
    let expected_n_m = -(pull_n_m + bearing_n_m) / efficiency;
    println!("up: {rate_rad_s} rad/s, {torque_n_m} for {expected_n_m} N m");
    assert!((rate_rad_s + 6.0).abs() < 1e-2, "{rate_rad_s}");
    assert!(
        (torque_n_m / expected_n_m - 1.0).abs() < 1e-2,
        "{torque_n_m} {expected_n_m}"
    );

    let down = geared(0.3);
    let (rate_rad_s, torque_n_m) = end_of(&down);
    let expected_n_m = -(pull_n_m - bearing_n_m) * (2.0 - 1.0 / efficiency);
    println!("down: {rate_rad_s} rad/s, {torque_n_m} for {expected_n_m} N m");
    assert!((rate_rad_s - 6.0).abs() < 2e-2, "{rate_rad_s}");
    assert!(
        (torque_n_m - expected_n_m).abs() < 1e-2 * pull_n_m,
        "{torque_n_m} {expected_n_m}"
    );
    for run in [up, down] {
        let energy = &run.summary.energy;
        let unexplained_j = energy.unexplained_j.expect("counted");
        assert!(unexplained_j.abs() < 2e-2, "{unexplained_j} J");
    }
}

/// With zero motor torque a gear of 0.8 without a rotor passes nothing and loses nothing. With a
/// rotor of inertia J the wheel accelerates it through the gear with J / (2 - 1 / eta); a gear of
/// 0.4 does not turn at all.
#[test]
fn a_gear_is_turned_by_its_wheel_as_far_as_it_does_not_lock_itself() {
    let coasts_rad_s = |efficiency: f64, rotor_kg_m2: f64| {
        let faults: String = ["front_left", "front_right", "rear_left", "rear_right"]
            .map(|wheel| format!("[[faults]]\nmotor_lost = {{ wheel = \"{wheel}\" }}\n"))
            .concat();
        let further = format!(
            "[motors]\ngear_efficiency = {efficiency}\nrotor_inertia_kg_m2 = {rotor_kg_m2}\n{faults}"
        );
        let (plant, rate_rad_s) = at_full_voltage(5.0, 0.0, &further, 1.0);
        let inertia_kg_m2 = wheel_inertia_kg_m2(plant.robot());
        (rate_rad_s, pull_n_m(plant.robot(), 5.0), inertia_kg_m2)
    };
    let (free_rad_s, ..) = coasts_rad_s(1.0, 0.0);
    assert!((coasts_rad_s(0.8, 0.0).0 / free_rad_s - 1.0).abs() < 1e-6);
    for (efficiency, rotor_kg_m2) in [(1.0, 2e-2), (0.8, 2e-2), (0.6, 2e-2)] {
        let (rate_rad_s, pull_n_m, inertia_kg_m2) = coasts_rad_s(efficiency, rotor_kg_m2);
        let felt_kg_m2 = inertia_kg_m2 + rotor_kg_m2 / (2.0 - 1.0 / efficiency);
        let falls_s = felt_kg_m2 / DAMPING_N_M_S;
        let expected_rad_s = pull_n_m / DAMPING_N_M_S * (1.0 - (-1.0 / falls_s).exp());
        println!("{efficiency}: {rate_rad_s} {expected_rad_s} rad/s");
        assert!((rate_rad_s / expected_rad_s - 1.0).abs() < 1e-2);
    }
    for efficiency in [0.5, 0.4] {
        for rotor_kg_m2 in [0.0, 2e-2] {
            let (rate_rad_s, ..) = coasts_rad_s(efficiency, rotor_kg_m2);
            assert!(rate_rad_s.abs() < 1e-6, "{efficiency}: {rate_rad_s} rad/s");
        }
    }
}
