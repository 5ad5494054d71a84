//! A plant is stepped by its caller: its outputs are repeatable, and its inputs are checked.

use std::path::Path;

use ilon_sim::robot::{Pose, Robot};
use ilon_sim::trace::{Truth, trace_hash};
use ilon_sim::world::Floor;
use ilon_sim::{
    Commanded, Controller, Driver, Error, Measurements, Moment, Plant, Scenario, Simulation,
    Snapshot, WheelCommand, load_robot, resolve, resolve_for,
};
use test_case::test_case;

/// Everything that may happen between two moments: noise, a late sensor fused with odometry,
/// pushes, payloads, a seized roller, a changing floor, a box, the wheel law with the most state.
const EVENTFUL: &str = r#"
[robot]
file = "mecanum4.urdf"

[twist]
vx_m_s = 0.2

[[world.floor.boxes]]
x_m = 0.45
y_m = 0.0
length_x_m = 0.2
length_y_m = 2.0
height_m = 0.004

[wheel_loop]
law = "computed_torque"

[sensors]
seed = 7
encoders.rate_noise_rad_s = 0.05
fusion = {}

[sensors.pose]
rate_hz = 30
latency_s = 0.03
position_noise_m = 0.002
heading_noise_deg = 0.2

[[faults]]
push = { impulse_y_n_s = 1.5, from_s = 0.3, lasts_s = 0.2 }

[[faults]]
payload = { mass_kg = 2, x_m = 0.05, from_s = 0.25, until_s = 0.55 }

[[faults]]
roller_stuck = { wheel = "front_left", roller = 2, from_s = 0.1, until_s = 0.6 }

[[faults]]
friction_changed = { friction = 0.15, from_s = 0.35, until_s = 0.5 }

[run]
duration_s = 1.0
"#;

const PERIOD_S: f64 = 0.01;

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots")
}

fn eventful(further: &str) -> (Scenario, Robot) {
    let text = format!("{EVENTFUL}{further}");
    let scenario = Scenario::from_toml(&text, "eventful", folder()).expect("a scenario");
    let robot = load_robot(&scenario).expect("a shipped robot");
    (scenario, robot)
}

fn plant() -> Plant {
    plant_with("")
}

fn plant_with(further: &str) -> Plant {
    let (scenario, robot) = eventful(further);
    let resolved = resolve(&scenario, &robot).expect("it can be run");
    Plant::new(&resolved, &robot).expect("it stands")
}

/// Drives by the measurements, so that noise has an effect; returns truth and measurements.
fn drive(plant: &mut Plant, periods: usize) -> Vec<(Truth, Measurements)> {
    (0..periods)
        .map(|_| {
            let seen = plant.observe().clone();
            let turn = 3.0 * seen.pose.heading_rad + 0.1 * seen.wheel_rates_rad_s[0];
            let rates_rad_s = [8.0 + turn, 8.0 - turn, 7.0 + turn, 9.0 - turn];
            let command = WheelCommand::Rates(&rates_rad_s);
            plant.advance(command, PERIOD_S).expect("it drives");
            (plant.truth(), seen)
        })
        .collect()
}

#[test]
fn a_plant_goes_on_from_a_snapshot_to_the_bit_in_whatever_moment_it_was_taken() {
    // Before, within and after each of the events.
    for before in [0, 5, 15, 28, 40, 52, 70] {
        let mut plant = plant();
        drive(&mut plant, before);
        let snapshot = plant.snapshot();
        let first = drive(&mut plant, 40);
        plant.restore(&snapshot).expect("its own");
        assert_eq!(
            drive(&mut plant, 40),
            first,
            "restored after {before} periods"
        );
        let mut other = self::plant();
        other.restore(&snapshot).expect("of the same scenario");
        assert_eq!(drive(&mut other, 40), first, "restored into another");
    }
}

/// Of another floor, robot or course: a plant does not turn into another one.
#[test]
fn a_snapshot_of_another_plant_is_refused_and_changes_nothing() {
    let mut plant = plant();
    drive(&mut plant, 20);
    let here = plant.snapshot();
    let ahead = drive(&mut plant, 20);
    plant.restore(&here).expect("its own");
    let ice = plant_with("[world.floor]\nfriction = 0.05\n");
    let other_robot = {
        let text = "robot.file = \"volksbot.urdf\"\ntwist = {}\nrun.duration_s = 1\n";
        let scenario = Scenario::from_toml(text, "three", folder()).expect("a scenario");
        let robot = load_robot(&scenario).expect("a shipped robot");
        Plant::new(&resolve(&scenario, &robot).expect("it runs"), &robot).expect("it stands")
    };
    // The same scenario, but a robot that differs from its file.
    let changed_robot = {
        let (scenario, mut robot) = eventful("");
        robot.chassis.mass.mass_kg += 1.0;
        Plant::new(&resolve(&scenario, &robot).expect("it runs"), &robot).expect("it stands")
    };
    // The same scenario and robot on the caller's ground.
    let own_ground = {
        let (scenario, robot) = eventful("");
        let resolved = resolve(&scenario, &robot).expect("it runs");
        Plant::on_floor(&resolved, &robot, Floor::default()).expect("it stands")
    };
    for mut other in [ice, other_robot, changed_robot, own_ground] {
        let before = other.truth();
        for refused in [plant.restore(&other.snapshot()), other.restore(&here)] {
            let said = refused.expect_err("it is another").to_string();
            assert!(said.contains("another simulation"), "{said}");
        }
        assert_eq!(other.truth(), before);
    }
    assert_eq!(drive(&mut plant, 20), ahead);
}

/// With rapier solving the contacts, a plant supports the same: noise, a box, a push, a payload, a
/// seized roller, a floor that turns slippery. The step is chosen for it, no unsupported key is
/// written into the scenario, and snapshots work.
#[test]
fn a_plant_whose_contacts_rapier_solves_goes_through_the_same_events() {
    let (scenario, robot) = eventful("[world.solver]\ncontacts = \"rapier\"\n");
    let resolved = resolve(&scenario, &robot).expect("it can be run");
    assert!(
        resolved.physics_dt_s() <= 1e-3,
        "{}",
        resolved.physics_dt_s()
    );
    let again = resolve(resolved.scenario(), &robot).expect("what is spelled out can be run too");
    assert_eq!(
        again.scenario().to_toml().unwrap(),
        resolved.scenario().to_toml().unwrap()
    );

    let mut plant = Plant::new(&resolved, &robot).expect("it stands");
    drive(&mut plant, 28);
    let snapshot = plant.snapshot();
    let first = drive(&mut plant, 40);
    plant.restore(&snapshot).expect("its own");
    assert_eq!(drive(&mut plant, 40), first);
    // Ahead at some 0.4 m/s for 0.68 s, over a box: it was not thrown off.
    let truth = plant.truth();
    assert!(truth.pose.x_m > 0.1 && truth.pose.x_m < 0.4, "{truth:?}");
    assert!(
        truth.roll_rad.abs() < 0.1 && truth.pitch_rad.abs() < 0.1,
        "{truth:?}"
    );
}

#[test]
fn a_snapshot_is_of_the_energies_and_contacts_too() {
    let mut plant = plant();
    drive(&mut plant, 33);
    let snapshot = plant.snapshot();
    let look = |plant: &Plant| {
        let world = plant.world();
        (
            world.slip_energy_j(),
            world.motor_energy_j(),
            world.robot().contacts().to_vec(),
            world.robot().roller_spins_rad_s(0),
        )
    };
    drive(&mut plant, 20);
    let first = look(&plant);
    plant.restore(&snapshot).expect("its own");
    drive(&mut plant, 20);
    assert_eq!(look(&plant), first);
}

#[test]
fn plants_on_two_threads_do_what_they_do_on_one() {
    let alone = drive(&mut plant(), 80);
    let runs: Vec<_> = std::thread::scope(|scope| {
        let started = [(); 2].map(|()| scope.spawn(|| drive(&mut plant(), 80)));
        started
            .into_iter()
            .map(|run| run.join().expect("it drives"))
            .collect()
    });
    assert!(runs.iter().all(|run| *run == alone));
    // And one that moves to another thread during its drive.
    let mut moved = plant();
    let mut way = drive(&mut moved, 40);
    let rest = std::thread::spawn(move || drive(&mut moved, 40));
    way.extend(rest.join().expect("it drives"));
    assert_eq!(way, alone);
}

#[test]
fn what_runs_may_go_to_another_thread() {
    fn is_send<T: Send>() {}
    is_send::<Plant>();
    is_send::<Snapshot>();
    is_send::<Simulation>();
}

/// Also with axial play and with sheared treads.
#[test_case(""; "rigid rollers")]
#[test_case("[rollers]\naxial_play_m = 4e-4\n"; "rollers with play")]
#[test_case("[rollers.tread]\nstiffness_n_m = 1e6\n"; "rollers with a tread")]
fn a_plant_that_is_reset_is_a_new_one_of_that_seed_and_place(further: &str) {
    let (scenario, robot) = eventful(further);
    let start = Pose {
        x_m: -0.3,
        y_m: 0.1,
        heading_rad: 0.2,
    };
    let mut elsewhere = scenario.clone();
    elsewhere.sensors.seed = 99;
    elsewhere.robot.x_m = start.x_m;
    elsewhere.robot.y_m = start.y_m;
    elsewhere.robot.heading_deg = 0.2_f64.to_degrees();
    // 0.2 rad in degrees and back is not 0.2 rad to the last bit.
    let start = Pose {
        heading_rad: elsewhere.robot.heading_deg.to_radians(),
        ..start
    };
    let resolved = resolve(&elsewhere, &robot).expect("it can be run");
    let mut fresh = Plant::new(&resolved, &robot).expect("it stands");
    let mut reset = plant_with(further);
    drive(&mut reset, 37);
    reset.reset(99, start).expect("it stands there");
    assert_eq!(reset.time_s(), 0.0);
    assert_eq!(reset.truth(), fresh.truth());
    assert_eq!(drive(&mut reset, 60), drive(&mut fresh, 60));

    // Results of rounding.
    let nearly = Pose {
        heading_rad: 1e-17,
        ..Pose::default()
    };
    plant_with(further)
        .reset(1, nearly)
        .expect("it stands there");

    // Another seed gives other noise, and another path.
    let mut other = plant_with(further);
    other.reset(100, start).expect("it stands there");
    assert_ne!(drive(&mut other, 60).last(), drive(&mut reset, 60).last());
}

#[test]
fn a_reset_to_where_no_robot_can_stand_leaves_the_plant_as_it_was() {
    let mut plant = plant();
    drive(&mut plant, 10);
    let before = plant.truth();
    for x_m in [f64::NAN, f64::INFINITY, 1e300] {
        let pose = Pose {
            x_m,
            ..Pose::default()
        };
        assert!(plant.reset(1, pose).is_err());
        assert_eq!(plant.truth(), before);
    }
}

#[test]
fn sensors_asked_twice_say_the_same_and_asking_changes_nothing() {
    let (mut asked, mut unasked) = (plant(), plant());
    let rates = WheelCommand::Rates(&[5.0; 4]);
    for _ in 0..30 {
        let seen = asked.observe().clone();
        assert_eq!(*asked.observe(), seen);
        asked.advance(rates, PERIOD_S).expect("it drives");
        unasked.advance(rates, PERIOD_S).expect("it drives");
    }
    assert_eq!(asked.truth(), unasked.truth());
    assert_eq!(asked.observe(), unasked.observe());
}

/// What is seen before the first step is a measurement, and not the start itself: noise of 1 cm
/// moves it, by less than six deviations.
#[test]
fn at_the_start_too_the_sensors_measure() {
    for (noise_m, is_off) in [(0.0, false), (0.01, true)] {
        let text = format!(
            "robot.file = \"mecanum4.urdf\"\ntwist = {{}}\nrun.duration_s = 1.0\n\
             sensors = {{ seed = 7, pose.position_noise_m = {noise_m} }}\n"
        );
        let scenario = Scenario::from_toml(&text, "noisy", folder()).expect("a scenario");
        let robot = load_robot(&scenario).expect("a shipped robot");
        let resolved = resolve(&scenario, &robot).expect("it can be run");
        let mut plant = Plant::new(&resolved, &robot).expect("it stands");
        let (real, seen) = (plant.truth().pose, plant.observe().pose);
        for off_m in [seen.x_m - real.x_m, seen.y_m - real.y_m] {
            assert_eq!(off_m != 0.0, is_off, "{off_m} m");
            assert!(off_m.abs() <= 6.0 * noise_m, "{off_m} m");
        }
    }
}

/// The errors of a plant's encoders at each control sample, in rad/s, with a number of physics
/// steps between two samples.
fn encoder_errors_rad_s(steps_a_sample: u32) -> Vec<f64> {
    let physics_dt_s = PERIOD_S / f64::from(steps_a_sample);
    let text = format!(
        "[robot]\nfile = \"mecanum4.urdf\"\n[twist]\nvx_m_s = 0.2\n\
         [sensors]\nseed = 7\nencoders.rate_noise_rad_s = 0.05\n\
         [run]\nduration_s = 1.0\ncontrol_dt_s = {PERIOD_S}\nphysics_dt_s = {physics_dt_s}\n"
    );
    let scenario = Scenario::from_toml(&text, "noisy", folder()).expect("a scenario");
    let robot = load_robot(&scenario).expect("a shipped robot");
    let resolved = resolve(&scenario, &robot).expect("it can be run");
    let mut plant = Plant::new(&resolved, &robot).expect("it stands");
    let mut errors_rad_s = Vec::new();
    for _ in 0..100 {
        let seen = plant.observe().wheel_rates_rad_s.clone();
        let real = plant.world().robot().wheel_rates_rad_s();
        errors_rad_s.extend(seen.iter().zip(real).map(|(seen, real)| seen - real));
        let command = WheelCommand::Rates(&[2.0; 4]);
        plant.advance(command, PERIOD_S).expect("it drives");
    }
    errors_rad_s
}

#[test]
fn encoder_noise_is_a_matter_of_samples_and_not_of_physics_steps() {
    let [coarse, fine] = [4, 10].map(encoder_errors_rad_s);
    for (coarse, fine) in coarse.iter().zip(&fine) {
        // Rates of some rad/s: the sum of rate and noise is rounded at 1e-15.
        assert!((coarse - fine).abs() < 1e-13, "{coarse} is not {fine}");
    }
    // 400 draws of a standard deviation of 0.05 rad/s scatter by 1 / sqrt(2 * 400) = 3.5 % about
    // it: within four times that.
    let squares: f64 = coarse.iter().map(|error| error * error).sum();
    let rms_rad_s = (squares / coarse.len() as f64).sqrt();
    assert!((rms_rad_s / 0.05 - 1.0).abs() < 0.14, "{rms_rad_s} rad/s");
}

#[test]
fn one_long_advance_is_many_short_ones() {
    let (mut long, mut short) = (plant(), plant());
    let rates = WheelCommand::Rates(&[6.0, 5.0, 5.0, 6.0]);
    long.advance(rates, 0.3).expect("it drives");
    for _ in 0..30 {
        short.advance(rates, PERIOD_S).expect("it drives");
    }
    assert_eq!(long.truth(), short.truth());
    assert_eq!(long.time_s(), short.time_s());
}

#[test]
fn the_torques_of_an_outcome_are_the_mean_of_what_acted() {
    let mut plant = plant();
    let mut steps = Vec::new();
    let outcome = plant
        .advance_watched(WheelCommand::Rates(&[5.0; 4]), PERIOD_S, |world, dt_s| {
            steps.push((world.robot().motor_torques_n_m()[0], dt_s));
        })
        .expect("it drives")
        .clone();
    let impulse_n_m_s: f64 = steps.iter().map(|(torque, dt_s)| torque * dt_s).sum();
    // Sums of some ten numbers, rounded.
    assert!((outcome.torques_n_m[0] - impulse_n_m_s / PERIOD_S).abs() < 1e-12);
    assert!(outcome.torques_n_m[0] > 0.0);
}

/// A DC motor brings an unloaded wheel to its no-load rate and no further, at any step: with J w' =
/// stall (1 - w / no_load) the rate approaches it exponentially, here within 0.8 ms.
#[test]
fn a_dc_motor_ends_at_its_no_load_rate_at_any_step() {
    const NO_LOAD_RAD_S: f64 = 20.0;
    for dt_s in [0.0005, 0.001, 0.002, 0.004] {
        let text = format!(
            "robot.file = \"mecanum4.toml\"\nrobot.spec.wheel = {{ motor_effort_n_m = 20.0, motor_velocity_rad_s = 1000.0 }}\n\
             motors.dc = {{ stall_torque_n_m = 6.0, no_load_rate_rad_s = {NO_LOAD_RAD_S} }}\ntwist = {{}}\n\
             world.floor.friction = 0.0\nrun = {{ duration_s = 1, physics_dt_s = {dt_s}, control_dt_s = 0.02 }}\n"
        );
        let scenario = Scenario::from_toml(&text, "dc", folder()).expect("a scenario");
        let robot = load_robot(&scenario).expect("a shipped robot");
        let resolved = resolve(&scenario, &robot).expect("it can be run");
        let commands = [
            WheelCommand::Torques(&[6.0, 6.0, -6.0, -6.0]),
            WheelCommand::Rates(&[60.0, 60.0, -60.0, -60.0]),
        ];
        for command in commands {
            let mut plant = Plant::new(&resolved, &robot).expect("it stands");
            let mut fastest_rad_s = 0.0_f64;
            plant
                .advance_watched(command, 0.1, |world, _| {
                    let rates = world.robot().wheel_rates_rad_s().iter();
                    fastest_rad_s = rates.fold(fastest_rad_s, |most, rate| most.max(rate.abs()));
                })
                .expect("it drives");
            // The solver's residual.
            assert!(
                fastest_rad_s < NO_LOAD_RAD_S + 1e-4,
                "{dt_s}: {fastest_rad_s}"
            );
            for rate in &plant.observe().wheel_rates_rad_s {
                assert!(rate.abs() > 0.9 * NO_LOAD_RAD_S, "{dt_s}: {rate}");
            }
        }
    }
}

#[test]
fn bad_commands_and_periods_are_refused_and_move_nothing() {
    let mut plant = plant();
    let before = plant.truth();
    let good = [1.0; 4];
    let numbers: [&[f64]; 4] = [
        &[],
        &[1.0; 3],
        &[1.0, f64::NAN, 0.0, 0.0],
        &[f64::INFINITY; 4],
    ];
    for numbers in numbers {
        for command in [WheelCommand::Rates(numbers), WheelCommand::Torques(numbers)] {
            let refused = plant.advance(command, PERIOD_S);
            assert!(matches!(refused, Err(Error::Invalid { .. })), "{command:?}");
        }
    }
    for period_s in [
        0.0,
        -PERIOD_S,
        0.5e-9,
        1.37 * PERIOD_S,
        1e300,
        f64::NAN,
        f64::INFINITY,
    ] {
        let refused = plant.advance(WheelCommand::Rates(&good), period_s);
        assert!(matches!(refused, Err(Error::Invalid { .. })), "{period_s}");
    }
    assert_eq!((plant.time_s(), plant.truth()), (0.0, before));
}

/// Commands the rates of an open-loop guidance, from the given kinematics.
struct Forward;

impl Controller for Forward {
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
        assert_eq!(now.robot.wheels.len(), wheels.len());
        assert!(wheels.iter().all(|wheel| *wheel == 0.0));
        let twist = ilon_sim::robot::Twist::new(0.2, 0.0, 0.0);
        now.kinematics.wheel_rates(twist, wheels);
        Commanded::Rates
    }
}

#[test]
fn a_run_under_a_controller_is_its_plant_under_the_same_commands() {
    let (scenario, robot) = eventful("");
    let run = Simulation::with_controller(&scenario, Forward)
        .expect("it can be run")
        .run();
    let resolved = resolve_for(&scenario, &robot, Driver::Own).expect("it can be run");
    let mut plant = Plant::new(&resolved, &robot).expect("it stands");
    let mut rates_rad_s = [0.0; 4];
    let twist = ilon_sim::robot::Twist::new(0.2, 0.0, 0.0);
    plant.kinematics().wheel_rates(twist, &mut rates_rad_s);
    for record in run.trace.records() {
        assert_eq!(record.truth, plant.truth(), "at {} s", record.t_s);
        assert_eq!(record.seen_pose, plant.observe().pose);
        let command = WheelCommand::Rates(&rates_rad_s);
        plant.advance(command, PERIOD_S).expect("it drives");
    }
}

#[test]
fn to_resolve_is_to_resolve_once() {
    let (scenario, robot) = eventful("");
    let before = scenario.to_toml().expect("text");
    let once = resolve(&scenario, &robot).expect("it can be run");
    assert_eq!(scenario.to_toml().expect("text"), before);
    let twice = resolve(once.scenario(), &robot).expect("it can be run");
    let text = |scenario: &Scenario| scenario.to_toml().expect("text");
    assert_eq!(text(twice.scenario()), text(once.scenario()));
    let hash =
        |scenario: &Scenario| trace_hash(&ilon_sim::run(scenario).expect("it can be run").trace);
    assert_eq!(hash(&scenario), hash(once.scenario()));
}

/// A load of 5 kg is carried and put down again: the robot then goes on as one that never carried
/// any, to the bit. No load is lighter than nothing.
#[test]
fn a_load_that_is_put_down_is_gone_and_none_is_negative() {
    let [mut plain, mut laden] = [plant(), plant()];
    laden.carry(5.0).expect("a load");
    laden.carry(0.0).expect("no load");
    assert_eq!(drive(&mut laden, 10), drive(&mut plain, 10));
    laden.carry(5.0).expect("a load");
    assert_ne!(drive(&mut laden, 10), drive(&mut plain, 10));
    for mass_kg in [-1.0, f64::NAN, f64::INFINITY] {
        let error = laden.carry(mass_kg).expect_err("no load").to_string();
        assert!(error.contains("cannot carry"), "{error}");
    }
    // Springs of the contacts carry 1e9 kg in the ground, as a scenario refuses it.
    let error = laden.carry(1e9).expect_err("too heavy").to_string();
    assert!(error.contains("would sink by"), "{error}");
}

#[test]
fn a_push_from_outside_is_the_same_push_of_a_scenario() {
    // 6 N for 0.25 s from 0.3 s on, which divide without rounding: as an impulse in the scenario,
    // and as a force by the program.
    let fault = "\n[[faults]]\npush = { impulse_x_n_s = 1.5, x_m = 0.1, y_m = 0.05, z_m = 0.0, from_s = 0.3, lasts_s = 0.25 }\n";
    let of = |further: &str| {
        let (scenario, robot) = eventful(further);
        let resolved = resolve(&scenario, &robot).expect("it can be run");
        Plant::new(&resolved, &robot).expect("it stands")
    };
    let (mut scheduled, mut pushed, mut left_alone) = (of(fault), of(""), of(""));
    for period in 0..60 {
        if period == 30 {
            let place_m = Some([0.1, 0.05, 0.0]);
            pushed.push([6.0, 0.0, 0.0], place_m, 0.25).expect("a push");
        }
        for plant in [&mut scheduled, &mut pushed, &mut left_alone] {
            plant
                .advance(WheelCommand::Torques(&[0.0; 4]), PERIOD_S)
                .expect("it drives");
        }
    }
    assert_eq!(pushed.truth(), scheduled.truth());
    assert_ne!(pushed.truth(), left_alone.truth());
}

#[test]
fn a_push_ends_with_a_reset_and_is_refused_where_it_is_no_push() {
    let (mut plant, start) = (plant(), Pose::default());
    for (force_n, place_m, lasts_s) in [
        ([f64::NAN, 0.0, 0.0], None, 1.0),
        ([1.0, 0.0, 0.0], Some([f64::INFINITY, 0.0, 0.0]), 1.0),
        ([1.0, 0.0, 0.0], None, 0.0),
        ([1.0, 0.0, 0.0], None, f64::NAN),
    ] {
        assert!(plant.push(force_n, place_m, lasts_s).is_err());
    }
    plant.reset(7, start).expect("it stands");
    let drive = |plant: &mut Plant| {
        plant
            .advance(WheelCommand::Torques(&[0.0; 4]), PERIOD_S)
            .expect("it drives");
        plant.truth()
    };
    let alone = drive(&mut plant);
    plant.reset(7, start).expect("it stands");
    plant.push([50.0, 0.0, 0.0], None, 5.0).expect("a push");
    assert_ne!(drive(&mut plant), alone);
    plant.reset(7, start).expect("it stands");
    assert_eq!(drive(&mut plant), alone);
}

/// A plant with a camera that has this delay, pushed to one side by its wheels.
fn seen_late(latency_s: f64) -> Plant {
    let text = format!(
        "[robot]\nfile = \"mecanum4.urdf\"\n[twist]\n[sensors.pose]\nlatency_s = {latency_s}\n[run]\nduration_s = 1.0\n"
    );
    let scenario = Scenario::from_toml(&text, "late", folder()).expect("a scenario");
    let robot = load_robot(&scenario).expect("a shipped robot");
    let resolved = resolve(&scenario, &robot).expect("it can be run");
    Plant::new(&resolved, &robot).expect("it stands")
}

/// A late pose is the true one at that earlier time.
#[test]
fn a_late_pose_is_where_the_robot_was_then() {
    for periods_late in [1, 3, 7] {
        let mut plant = seen_late(PERIOD_S * f64::from(periods_late));
        let mut truths = vec![plant.truth().pose];
        for period in 1..=20 {
            let command = WheelCommand::Rates(&[8.0, 6.0, 6.0, 8.0]);
            plant.advance(command, PERIOD_S).expect("it drives");
            truths.push(plant.truth().pose);
            // Before the first one has arrived, the start pose.
            let then = truths[(period - periods_late).max(0) as usize];
            assert_eq!(
                plant.observe().pose,
                then,
                "{periods_late} late, at {period}"
            );
        }
        // It moves each time, so that no other moment would fit.
        let moved = truths
            .windows(2)
            .skip(2)
            .map(|pair| pair[1].x_m - pair[0].x_m);
        assert!(moved.into_iter().all(|m| m.abs() > 1e-5));
    }
}

/// An encoder with a wrong factor counts the rotation of its wheel since the fault's start, times
/// the factor; its rate is wrong at once.
#[test]
fn a_scaled_encoder_counts_the_factor_of_what_its_wheel_turns() {
    let text = "[robot]\nfile = \"mecanum4.urdf\"\n[twist]\n[run]\nduration_s = 1.0\n\
        [[faults]]\nencoder_scaled = { wheel = \"front_left\", factor = 1.25, from_s = 0.1 }\n";
    let scenario = Scenario::from_toml(text, "scaled", folder()).expect("a scenario");
    let robot = load_robot(&scenario).expect("a shipped robot");
    let resolved = resolve(&scenario, &robot).expect("it can be run");
    let mut plant = Plant::new(&resolved, &robot).expect("it stands");
    let wheel = robot
        .wheels
        .iter()
        .position(|wheel| wheel.name.starts_with("front_left"));
    let wheel = wheel.expect("it has one");
    let mut angle_when_it_broke = 0.0;
    for period in 1..=30 {
        let command = WheelCommand::Rates(&[8.0; 4]);
        plant.advance(command, PERIOD_S).expect("it drives");
        let true_angle = plant.world().robot().wheel_angles_rad()[wheel];
        let true_rate = plant.world().robot().wheel_rates_rad_s()[wheel];
        if period <= 10 {
            angle_when_it_broke = true_angle;
        }
        let broken = period >= 10;
        let seen = plant.observe();
        let expected = true_angle + 0.25 * (true_angle - angle_when_it_broke);
        // In the step of the fault's start the factor at its end applies: a step at 10 rad/s,
        // because the loop overshoots 8.
        let step_rad = 10.0 * resolved.physics_dt_s() * 0.25;
        assert!(
            (seen.wheel_angles_rad[wheel] - expected).abs() <= step_rad,
            "{period}: {} {expected}",
            seen.wheel_angles_rad[wheel]
        );
        if period != 10 {
            let factor = if broken { 1.25 } else { 1.0 };
            assert!((seen.wheel_rates_rad_s[wheel] - factor * true_rate).abs() < 1e-12);
        }
    }
}

/// Hosts have their own steps: one millisecond, five, and one whose multiples never meet the
/// plant's steps of 3.33 ms. The robot follows the same path as by control periods, sensors still
/// sample at control instants, and energies balance.
#[test]
fn a_plant_takes_whatever_steps_its_host_takes() {
    let scenario = |keys: &str| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
        let text =
            format!("robot.file = \"mecanum4.urdf\"\ntwist = {{}}\nrun.duration_s = 5\n{keys}");
        Scenario::from_toml(&text, "hosts", folder).expect("a scenario")
    };
    let drive = |step_s: f64, keys: &str| {
        let mut plant = Plant::of_scenario(&scenario(keys)).expect("it stands");
        for index in 1..=(0.9 / step_s).round() as u32 {
            // Up to 6 rad/s within 0.6 s, diagonally.
            let rate = 10.0 * (f64::from(index) * step_s).min(0.6);
            let command = [rate, 0.5 * rate, 0.5 * rate, rate];
            plant
                .advance(WheelCommand::Rates(&command), step_s)
                .expect("it goes on");
            // Some sums of steps end within rounding of the time.
            assert!((plant.time_s() - f64::from(index) * step_s).abs() < 1e-9);
        }
        let truth = plant.truth();
        (truth.pose, plant.world().motor_energy_j())
    };
    let body = "world.bodies = [{ name = \"box\", mass_kg = 1, x_m = 0.5, y_m = 0.1, box.size_m = [0.2, 0.4, 0.2] }]\n";
    for keys in ["", "world.solver.contacts = \"rapier\"\n", body] {
        let (by_periods, motor_j) = drive(0.01, keys);
        for step_s in [1e-3, 5e-3, 7.5e-4] {
            let (pose, energy_j) = drive(step_s, keys);
            let off_m = (pose.position_m() - by_periods.position_m()).norm();
            // Commands held for 10 ms lag by half of that: 5 ms at the final 0.3 m/s, less than 2
            // mm.
            assert!(off_m < 2e-3, "{keys} {step_s}: {off_m}");
            // A box of 1 kg rubs with 6 N on those millimetres.
            let off_j = (energy_j - motor_j).abs();
            assert!(
                off_j < 0.02 * motor_j + 6.0 * 2e-3,
                "{keys} {step_s}: {off_j}"
            );
        }
    }
    for keys in [
        "wheel_loop.timing = \"sampled\"\n",
        "wheel_loop.latency_s = 0.01\n",
    ] {
        let mut whole = Plant::of_scenario(&scenario(keys)).expect("it stands");
        let refused = whole.advance(WheelCommand::Rates(&[1.0; 4]), 7.5e-4);
        assert!(refused.is_err_and(|error| error.to_string().contains("act in steps")));
    }
    for none in [0.0, -1e-3, f64::NAN, 1e-9, 1e12] {
        let mut plant = Plant::of_scenario(&scenario("")).expect("it stands");
        assert!(
            plant.advance(WheelCommand::Rates(&[1.0; 4]), none).is_err(),
            "{none}"
        );
        assert_eq!(plant.time_s(), 0.0);
    }
}

/// Counted rates are as noisy as others: under given torques, which no noise changes, they differ
/// from those without noise by draws of 0.05 rad/s, within four times the scatter of 400 of them.
#[test]
fn rates_that_are_counted_have_noise_too() {
    let rates_rad_s = |noise_rad_s: f64| {
        let further = format!(
            "[sensors]\nseed = 7\nencoders = {{ counts_per_turn = 4096, rate_noise_rad_s = {noise_rad_s} }}\n"
        );
        let text = format!(
            "[robot]\nfile = \"mecanum4.urdf\"\n[twist]\nvx_m_s = 0.2\n{further}[run]\nduration_s = 1.0\n"
        );
        let scenario = Scenario::from_toml(&text, "counted", folder()).expect("a scenario");
        let mut plant = Plant::of_scenario(&scenario).expect("it stands");
        let mut seen = Vec::new();
        for _ in 0..100 {
            seen.extend(plant.observe().wheel_rates_rad_s.clone());
            let command = WheelCommand::Torques(&[0.05; 4]);
            plant.advance(command, PERIOD_S).expect("it drives");
        }
        seen
    };
    let (plain, noisy) = (rates_rad_s(0.0), rates_rad_s(0.05));
    let squares = plain.iter().zip(&noisy).map(|(a, b)| (a - b) * (a - b));
    let rms_rad_s = (squares.sum::<f64>() / plain.len() as f64).sqrt();
    assert!((rms_rad_s / 0.05 - 1.0).abs() < 0.14, "{rms_rad_s} rad/s");
}

/// Tyres whose axle lies 0.1 m behind the origin let the robot turn about points of that axle: at
/// 1 rad/s the origin then moves sideways by 0.1 m/s. The other way it would drag them.
#[test]
fn a_turn_about_an_axle_behind_the_origin_is_no_motion_sideways() {
    let resolved = |vy_m_s: f64| {
        let text = format!(
            "[robot]\nfile = \"differential.urdf\"\n[twist]\nvy_m_s = {vy_m_s}\nomega_rad_s = 1\n[run]\nduration_s = 1.0\n"
        );
        let scenario = Scenario::from_toml(&text, "turn", folder()).expect("a scenario");
        let mut robot = load_robot(&scenario).expect("a shipped robot");
        for wheel in &mut robot.wheels {
            wheel.body_from_hub.translation.x -= 0.1;
        }
        resolve(&scenario, &robot).map(|_| ())
    };
    resolved(0.1).expect("a turn about a point of the axle");
    let error = resolved(-0.1).expect_err("it drags").to_string();
    assert!(error.contains("drags tyres sideways"), "{error}");
}

/// A push that begins and ends within steps moves a robot alike in a run and for hosts whose steps
/// are others, and a plant copied in the middle of a step goes on as the one it was copied from.
#[test_case(5e-3; "a host of whole control periods")]
#[test_case(3.7e-3; "a host of odd steps")]
fn what_begins_within_a_step_does_so_for_every_host(host_s: f64) {
    let text = "robot.file = \"mecanum4.urdf\"\ntwist = { vx_m_s = 0 }\nrun.duration_s = 0.74\nrun.control_dt_s = 0.01\n\
                world.floor.friction = 0.3\nfaults = [{ push = { impulse_y_n_s = 6, from_s = 0.50123, lasts_s = 0.0237 } }]\n";
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let scenario = Scenario::from_toml(text, "hosts", folder).expect("a scenario");
    let run = ilon_sim::run(&scenario).expect("it runs").summary;
    let robot = load_robot(&scenario).expect("a robot");
    let resolved = resolve_for(&scenario, &robot, Driver::Own).expect("it runs");
    let mut plant = Plant::new(&resolved, &robot).expect("it stands");
    let mut copy = None;
    for step in 0..(0.74 / host_s).round() as usize {
        if step == (0.51 / host_s) as usize {
            copy = Some(plant.clone());
        }
        for plant in [Some(&mut plant), copy.as_mut()].into_iter().flatten() {
            plant
                .advance(WheelCommand::Rates(&[0.0; 4]), host_s)
                .expect("it moves");
        }
    }
    let truth = plant.truth();
    assert_eq!(copy.expect("a copy").truth(), truth);
    let end_m = [run.end_x_m, run.end_y_m].map(|m| m.expect("an end"));
    // Steps that begin elsewhere see hand-overs and sliding elsewhere: by 0.2 % of 58 mm.
    let off_m = (truth.pose.x_m - end_m[0]).hypot(truth.pose.y_m - end_m[1]);
    assert!(end_m[1] > 0.05 && off_m < 1.5e-4, "{off_m} of {end_m:?}");
}
