//! An instance between calls.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_fmi::{Causality, Instance, Phase, Value};
use ilon_sim::{Plant, Scenario, Simulation, WheelCommand};

pub fn scenario(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../assets/scenarios")
        .join(name)
}

fn instance(name: &str) -> Instance {
    let path = scenario(name);
    let text = std::fs::read_to_string(&path).unwrap();
    Instance::of(text, path.parent().unwrap(), FileAccess::anywhere()).unwrap()
}

fn reference(instance: &Instance, name: &str) -> u32 {
    let found = instance.variables().iter().position(|of| of.name == name);
    found.unwrap_or_else(|| panic!("there is no {name}")) as u32
}

fn set(instance: &mut Instance, name: &str, value: f64) {
    let reference = reference(instance, name);
    instance.set(reference, Value::Real(value)).unwrap();
}

fn get(instance: &mut Instance, name: &str) -> f64 {
    let reference = reference(instance, name);
    match instance.get(reference).unwrap() {
        Value::Real(number) => number,
        other => panic!("{name} is {other:?}"),
    }
}

fn begin(instance: &mut Instance) {
    instance.enter_initialization(0.0).unwrap();
    instance.exit_initialization().unwrap();
}

/// Advances by control periods at wheel rates.
fn drive(instance: &mut Instance, rates: &[f64], periods: u32) {
    let period_s = instance.plant().resolved().control_dt_s();
    for (wheel, rate) in rates.iter().enumerate() {
        set(
            instance,
            &format!("wheel[{}].rate_command", wheel + 1),
            *rate,
        );
    }
    for _ in 0..periods {
        instance.step(instance.time_s(), period_s).unwrap();
    }
}

#[test]
fn a_run_is_retraced_to_the_bit() {
    let name = "mecanum4_lateral.toml";
    let run = Simulation::new(&Scenario::load(scenario(name)).unwrap())
        .unwrap()
        .run();
    let mut instance = instance(name);
    begin(&mut instance);
    for (record, wheels) in run.trace.steps().take(150) {
        let pose = record.truth.pose;
        let wanted = [
            pose.x_m,
            pose.y_m,
            pose.heading_rad,
            record.truth.twist_in_body.vy_m_s,
        ];
        let names = [
            "position.x",
            "position.y",
            "orientation.heading",
            "velocity.y",
        ];
        let got = names.map(|name| get(&mut instance, name));
        assert_eq!(
            got.map(f64::to_bits),
            wanted.map(f64::to_bits),
            "at {} s",
            record.t_s
        );
        let rates: Vec<f64> = wheels.iter().map(|wheel| wheel.target_rad_s).collect();
        drive(&mut instance, &rates, 1);
    }
}

/// Inputs reach the plant: the result is that of direct calls to it.
#[test]
fn inputs_are_the_plants_own() {
    let name = "mecanum4_lateral.toml";
    let mut instance = instance(name);
    begin(&mut instance);
    for (input, value) in [
        ("force.x", 5.0),
        ("force.y", -2.0),
        ("moment.z", 0.4),
        ("force_place.x", 0.1),
        ("payload.mass", 1.5),
        ("payload.y", 0.05),
        ("floor.friction", 0.4),
        ("wheel[2].grip", 0.5),
    ] {
        set(&mut instance, input, value);
    }
    drive(&mut instance, &[3.0, -2.0, 4.0, 1.0], 20);
    let mut plant = Plant::of_scenario(&Scenario::load(scenario(name)).unwrap()).unwrap();
    let center_m: [f64; 3] = plant.robot().chassis.mass.center_of_mass_m.into();
    let place = [0.1, center_m[1], center_m[2]];
    plant
        .set_wrench([5.0, -2.0, 0.0], [0.0, 0.0, 0.4], Some(place))
        .unwrap();
    plant
        .carry_at(1.5, Some([center_m[0], 0.05, center_m[2]]))
        .unwrap();
    plant.set_friction(0.4).unwrap();
    plant.set_grip(1, 0.5).unwrap();
    let period_s = plant.resolved().control_dt_s();
    for _ in 0..20 {
        plant
            .advance(WheelCommand::Rates(&[3.0, -2.0, 4.0, 1.0]), period_s)
            .unwrap();
    }
    assert_eq!(instance.plant().truth(), plant.truth());
    let over = &plant.outcome().wheels[1];
    assert_eq!(
        get(&mut instance, "wheel[2].friction"),
        over.friction_mean()
    );
    assert_eq!(
        get(&mut instance, "wheel[2].load"),
        over.normal_force_mean_n()
    );
    assert_eq!(
        get(&mut instance, "energy.outside"),
        plant.world().outside_energy_j()
    );
}

/// A parameter is a key of the scenario: the result is that of a scenario with that key.
#[test]
fn parameters_are_keys_of_the_scenario() {
    let name = "mecanum4_lateral.toml";
    let mut instance = instance(name);
    set(&mut instance, "scenario.world.floor.friction", 0.25);
    assert_eq!(
        get(&mut instance, "floor.friction"),
        0.25,
        "the input starts where the floor is"
    );
    let seed = reference(&instance, "scenario.sensors.seed");
    instance.set(seed, Value::Whole(5)).unwrap();
    begin(&mut instance);
    drive(&mut instance, &[9.0; 4], 20);
    let keys = ["world.floor.friction=0.25", "sensors.seed=5"].map(|key| key.parse().unwrap());
    let with_keys = Scenario::load_with(scenario(name), &keys).unwrap();
    let mut plant = Plant::of_scenario(&with_keys).unwrap();
    plant
        .advance(
            WheelCommand::Rates(&[9.0; 4]),
            plant.resolved().control_dt_s() * 20.0,
        )
        .unwrap();
    assert_eq!(instance.plant().truth(), plant.truth());
    // Too late after initialisation; a reset restores the start values.
    let friction = reference(&instance, "scenario.world.floor.friction");
    assert!(instance.set(friction, Value::Real(0.5)).is_err());
    instance.reset().unwrap();
    assert_eq!(
        get(&mut instance, "scenario.world.floor.friction"),
        get(&mut instance, "floor.friction")
    );
    assert_eq!(instance.phase(), Phase::Instantiated);
}

#[test]
fn a_copy_goes_on_to_the_bit() {
    let mut instance = instance("mecanum4_lateral.toml");
    begin(&mut instance);
    set(&mut instance, "force.y", 8.0);
    drive(&mut instance, &[2.0; 4], 5);
    let mut copy = instance.clone();
    drive(&mut instance, &[2.0; 4], 5);
    drive(&mut copy, &[2.0; 4], 5);
    assert_eq!(instance.plant().truth(), copy.plant().truth());
    assert_eq!(instance.time_s(), copy.time_s());
}

#[test]
fn calls_out_of_season_and_values_that_make_no_sense_are_refused() {
    let mut instance = instance("mecanum4_lateral.toml");
    let period_s = instance.plant().resolved().control_dt_s();
    assert!(
        instance.step(0.0, period_s).is_err(),
        "before it is initialised"
    );
    assert!(instance.exit_initialization().is_err());
    assert!(instance.enter_initialization(f64::NAN).is_err());
    begin(&mut instance);
    assert!(instance.enter_initialization(0.0).is_err());
    for (at_s, step_s) in [
        (1.0, period_s),
        (f64::NAN, period_s),
        (0.0, 0.0),
        (0.0, -period_s),
        (0.0, f64::NAN),
        (0.0, 1e-9),
    ] {
        assert!(instance.step(at_s, step_s).is_err(), "{at_s} {step_s}");
    }
    let rate = reference(&instance, "wheel[1].rate_command");
    let position = reference(&instance, "position.x");
    let count = instance.variables().len() as u32;
    for (reference, value) in [
        (rate, Value::Real(f64::NAN)),
        (rate, Value::Whole(1)),
        (position, Value::Real(1.0)),
        (0, Value::Real(1.0)),
        (count, Value::Real(1.0)),
        (u32::MAX, Value::Real(1.0)),
    ] {
        assert!(
            instance.set(reference, value).is_err(),
            "{reference} {value:?}"
        );
    }
    assert!(instance.get(count).is_err());
    // An invalid payload is refused at the step, and the robot has not moved.
    set(&mut instance, "payload.mass", -1.0);
    assert!(instance.step(0.0, period_s).is_err());
    set(&mut instance, "payload.mass", 0.0);
    instance.step(0.0, period_s).unwrap();
    instance.terminate().unwrap();
    assert!(instance.set(rate, Value::Real(0.0)).is_err());
}

#[test]
fn references_are_places_and_names_are_unique() {
    let instance = instance("volksbot_position_first.toml");
    let mut names: Vec<&str> = instance
        .variables()
        .iter()
        .map(|of| of.name.as_str())
        .collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
    let outputs = instance
        .variables()
        .iter()
        .filter(|of| of.causality == Causality::Output);
    assert!(outputs.count() > 50);
}

/// Importers use steps of one or five milliseconds, which are no multiples of the plant's 3.33: the
/// robot goes where it goes by control periods.
#[test]
fn any_step_of_the_importer_will_do() {
    let end = |step_s: f64| {
        let mut instance = instance("mecanum4_lateral.toml");
        begin(&mut instance);
        for (wheel, rate) in [-4.0, 4.0, 4.0, -4.0].iter().enumerate() {
            set(
                &mut instance,
                &format!("wheel[{}].rate_command", wheel + 1),
                *rate,
            );
        }
        for step in 0..(0.5 / step_s).round() as u32 {
            instance.step(f64::from(step) * step_s, step_s).unwrap();
        }
        assert!((instance.time_s() - 0.5).abs() < 1e-9);
        [
            get(&mut instance, "position.x"),
            get(&mut instance, "position.y"),
        ]
    };
    let [x_m, y_m] = end(0.01);
    assert!(y_m.abs() > 0.08, "{y_m}");
    for step_s in [1e-3, 5e-3] {
        let [x, y] = end(step_s);
        // Rates are constant; the difference is how finely the start is stepped: 20 m/s^2 over
        // several milliseconds squared.
        assert!(
            (x - x_m).hypot(y - y_m) < 5e-4,
            "{step_s}: {x} {y} for {x_m} {y_m}"
        );
    }
}
