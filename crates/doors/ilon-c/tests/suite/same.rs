//! Values pass through the C interface bit for bit.

use ilon_c::plant::*;
use ilon_c::state::{IlonEnergies, IlonWheel};
use ilon_sim::{Plant, Scenario, Simulation, WheelCommand};

use crate::support::{Owned, must, scenario};

/// The wheel rates that a run commands in each control period, applied from outside at that period,
/// give the same motion.
fn retraces(name: &str) {
    let scenario_ = Scenario::load(scenario(name)).unwrap();
    let run = Simulation::new(&scenario_).unwrap().run();
    let plant = Owned::load(&scenario(name));
    let period_s = plant.about().control_dt_s;
    assert_eq!(run.trace.header.record_every, 1, "a row each period");
    for (record, wheels) in run.trace.steps().take(400) {
        let (state, truth) = (plant.state(), record.truth);
        let got = [
            state.position_m[0],
            state.position_m[1],
            state.position_m[2],
            state.heading_rad,
            state.velocity_in_body_m_s[0],
            state.velocity_in_body_m_s[1],
            state.angular_in_body_rad_s[2],
        ];
        let wanted = [
            truth.pose.x_m,
            truth.pose.y_m,
            truth.height_m,
            truth.pose.heading_rad,
            truth.twist_in_body.vx_m_s,
            truth.twist_in_body.vy_m_s,
            truth.twist_in_body.omega_rad_s,
        ];
        assert_eq!(
            got.map(f64::to_bits),
            wanted.map(f64::to_bits),
            "at {} s",
            record.t_s
        );
        let rates: Vec<f64> = wheels.iter().map(|wheel| wheel.target_rad_s).collect();
        must(plant.advance(&rates, period_s));
    }
}

#[test]
fn a_run_of_a_twist_is_retraced_to_the_bit() {
    retraces("mecanum4_lateral.toml");
}

#[test]
fn a_run_of_the_papers_guidance_is_retraced_to_the_bit() {
    retraces("volksbot_position_first.toml");
}

#[test]
fn wheels_and_energies_are_the_plants() {
    let path = scenario("mecanum4_lateral.toml");
    let owned = Owned::load(&path);
    let mut plant = Plant::of_scenario(&Scenario::load(&path).unwrap()).unwrap();
    let rates = [-4.0, 4.0, 4.5, -4.0];
    must(owned.advance(&rates, 0.2));
    let outcome = plant.advance(WheelCommand::Rates(&rates), 0.2).unwrap();
    let torques = outcome.torques_n_m.clone();
    let mut wheels = [IlonWheel::default(); 4];
    let mut energies = IlonEnergies::default();
    // SAFETY: both are locals.
    unsafe {
        must(ilon_plant_wheels(owned.0, wheels.as_mut_ptr(), 4));
        must(ilon_plant_energies(owned.0, &raw mut energies));
    }
    let robot = plant.world().robot();
    for (index, wheel) in wheels.iter().enumerate() {
        assert_eq!(wheel.torque_n_m, torques[index]);
        assert_eq!(wheel.rate_rad_s, robot.wheel_rates_rad_s()[index]);
        let over = &plant.outcome().wheels[index];
        assert_eq!(wheel.normal_force_n, over.normal_force_mean_n());
    }
    assert_eq!(energies.slip_j, plant.world().slip_energy_j());
    assert_eq!(energies.kinetic_j, plant.world().energy().kinetic_j);
}

/// A robot on ice under a force: m a = F, and so do the IMU's readings.
#[test]
fn the_acceleration_is_that_of_the_force() {
    let owned = Owned::load(&scenario("mecanum4_lateral.toml"));
    must(ilon_plant_set_friction(owned.0, 0.0));
    must(owned.advance(&[0.0; 4], 0.2));
    let before = owned.state();
    must(owned.wrench([6.0, -2.0, 0.0], [0.0; 3]));
    must(owned.advance(&[0.0; 4], 0.01));
    let state = owned.state();
    let weight_n = before.wheels_load_n;
    let mass_kg = -weight_n / before.gravity_in_world_m_s2[2];
    for (axis, force_n) in [6.0, -2.0].into_iter().enumerate() {
        let off = state.acceleration_in_world_m_s2[axis] * mass_kg - force_n;
        // The force acts at the centre of mass of the chassis, not at the origin: while the body
        // pitches on its elastic contacts, the origin moves by several micrometres more or less.
        assert!(
            off.abs() < 0.02 * 6.0,
            "{off} N off along {axis}: {state:?}"
        );
    }
    let mut energies = IlonEnergies::default();
    // SAFETY: the struct is a local.
    must(unsafe { ilon_plant_energies(owned.0, &raw mut energies) });
    let travelled_m = state.position_m[0] - before.position_m[0];
    assert!(energies.outside_j > 0.0 && travelled_m > 0.0);
}

/// Two opposite forces are a moment: both turn the robot equally.
#[test]
fn a_moment_is_a_couple_of_forces() {
    let turned = |act: &dyn Fn(&mut Plant)| {
        let scenario = Scenario::load(scenario("mecanum4_lateral.toml")).unwrap();
        let mut plant = Plant::of_scenario(&scenario).unwrap();
        act(&mut plant);
        plant.advance(WheelCommand::Rates(&[0.0; 4]), 0.5).unwrap();
        (
            plant.truth().pose.heading_rad,
            plant.world().outside_energy_j(),
        )
    };
    let moment = turned(&|plant| plant.set_wrench([0.0; 3], [0.0, 0.0, 3.0], None).unwrap());
    let couple = turned(&|plant| {
        // A pair of forces in the world frame at body-fixed points: after a turn by a small angle
        // alpha its moment is smaller by 1 - cos alpha.
        plant
            .push([0.0, 15.0, 0.0], Some([0.1, 0.0, 0.06]), 0.5)
            .unwrap();
        plant
            .push([0.0, -15.0, 0.0], Some([-0.1, 0.0, 0.06]), 0.5)
            .unwrap();
    });
    assert!(moment.0 > 1e-4, "{moment:?}");
    let share = moment.0 * moment.0;
    assert!(
        (moment.0 / couple.0 - 1.0).abs() < share + 1e-9,
        "{moment:?} {couple:?}"
    );
    assert!(
        (moment.1 / couple.1 - 1.0).abs() < 2.0 * share + 1e-9,
        "{moment:?} {couple:?}"
    );
}

/// Grip is a share of friction: on all wheels it equals another floor, on one it affects that wheel
/// alone; a reset clears it.
#[test]
fn grip_is_a_share_of_friction() {
    let path = scenario("mecanum4_lateral.toml");
    let drive = |owned: &Owned| {
        must(owned.advance(&[-9.0, 9.0, 9.0, -9.0], 0.3));
        owned.state()
    };
    let all = Owned::load(&path);
    (0..4).for_each(|wheel| must(ilon_plant_set_grip(all.0, wheel, 0.5)));
    let floor = Owned::load(&path);
    must(ilon_plant_set_friction(
        floor.0,
        0.5 * floor.about().floor_friction,
    ));
    let whole = Owned::load(&path);
    let (by_grip, by_floor, plain) = (drive(&all), drive(&floor), drive(&whole));
    assert_eq!(by_grip, by_floor);
    assert_ne!(by_grip.position_m, plain.position_m);

    let one = Owned::load(&path);
    must(ilon_plant_set_grip(one.0, 0, 0.0));
    must(one.advance(&[-9.0, 9.0, 9.0, -9.0], 0.3));
    let mut wheels = [IlonWheel::default(); 4];
    // SAFETY: the array is a local.
    must(unsafe { ilon_plant_wheels(one.0, wheels.as_mut_ptr(), 4) });
    assert_eq!(
        (wheels[0].friction, wheels[0].force_in_body_n),
        (0.0, [0.0; 2])
    );
    assert!(wheels[1].friction > 0.0);
    // SAFETY: null is the scenario's start.
    must(unsafe { ilon_plant_reset(one.0, one.about().seed, std::ptr::null()) });
    assert_eq!(drive(&one), plain);
}

/// The work of motors and outside equals all other energies, with wrench, payload and grip changing
/// in each step, on other robots and at other periods.
#[test]
fn the_energy_closes_under_all_that_acts_from_outside() {
    for (name, periods) in [
        ("mecanum4_lateral.toml", 1),
        ("mecanum4_rocker_kerb.toml", 3),
        ("volksbot_forward.toml", 2),
    ] {
        let owned = Owned::load(&scenario(name));
        let about = owned.about();
        let energies = || {
            let mut energies = IlonEnergies::default();
            // SAFETY: the struct is a local.
            must(unsafe { ilon_plant_energies(owned.0, &raw mut energies) });
            energies
        };
        let before = energies();
        // Also a period that is no multiple of the plant's steps, as a host may have.
        let period_s = if periods == 1 {
            1e-3
        } else {
            f64::from(periods) * about.control_dt_s
        };
        let mut t_s = 0.0;
        while t_s < 1.5 {
            let (s, c) = (f64::sin(5.0 * t_s), f64::cos(3.0 * t_s));
            must(owned.wrench([12.0 * s, 8.0 * c, -5.0 * s], [0.4 * c, 0.3 * s, 1.5 * s]));
            // SAFETY: null is the centre of mass.
            must(unsafe { ilon_plant_set_payload(owned.0, 1.0 + s, std::ptr::null()) });
            must(ilon_plant_set_grip(owned.0, 0, 0.5 + 0.5 * c));
            let rates: Vec<f64> = (0..about.wheel_count)
                .map(|wheel| 4.0 * c + f64::from(wheel))
                .collect();
            must(owned.advance(&rates, period_s));
            t_s += period_s;
        }
        let now = energies();
        let given_j = now.motor_j + now.outside_j;
        let stored_j = now.kinetic_j + now.potential_j - before.kinetic_j - before.potential_j;
        let lost_j = now.slip_j + now.spin_up_j + now.bearing_j + now.impact_j;
        let turned_over_j = now.motor_j.abs() + now.outside_j.abs() + lost_j;
        // The share that every shipped scenario keeps.
        let off_j = (given_j - stored_j - lost_j).abs();
        assert!(
            off_j < 0.01 * turned_over_j,
            "{name}: {off_j} J of {turned_over_j} J: {now:?}"
        );
        assert!(now.outside_j.abs() > 0.1, "{name}: {now:?}");
    }
}

/// External loads are part of a snapshot, and a reset clears them.
#[test]
fn what_acts_is_in_a_snapshot_and_ends_with_a_reset() {
    let [owned, fresh] = ["mecanum4_lateral.toml"; 2].map(|name| Owned::load(&scenario(name)));
    let act = |force_n: f64, mass_kg: f64, grip: f64, friction: f64| {
        must(owned.wrench([force_n, 0.0, 0.0], [0.0, 0.0, 0.1 * force_n]));
        // SAFETY: null is the centre of mass.
        must(unsafe { ilon_plant_set_payload(owned.0, mass_kg, std::ptr::null()) });
        must(ilon_plant_set_grip(owned.0, 1, grip));
        must(ilon_plant_set_friction(owned.0, friction));
    };
    let drive = |owned: &Owned| {
        must(owned.advance(&[5.0, 3.0, -2.0, 4.0], 0.2));
        owned.state()
    };
    act(9.0, 2.0, 0.3, 0.4);
    drive(&owned);
    let mut snapshot = 0;
    // SAFETY: the snapshot is a local.
    must(unsafe { ilon_plant_snapshot(owned.0, &raw mut snapshot) });
    let first = drive(&owned);
    act(0.0, 0.0, 1.0, 0.9);
    assert_ne!(drive(&owned), first);
    must(ilon_plant_restore(owned.0, snapshot));
    assert_eq!(drive(&owned), first);
    must(ilon_snapshot_free(snapshot));
    // SAFETY: null is the scenario's start.
    must(unsafe { ilon_plant_reset(owned.0, owned.about().seed, std::ptr::null()) });
    assert_eq!(drive(&owned), drive(&fresh));
}
