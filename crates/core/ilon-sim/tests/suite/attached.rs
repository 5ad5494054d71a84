//! Bodies moved by another simulator, and ground tilted by the program: the robot feels both like
//! its own.

use std::path::Path;

use ilon_sim::{Plant, Scenario, WheelCommand};
use nalgebra::{Matrix3, Vector3};

const RATES: [f64; 4] = [4.0, 9.0, 6.0, 11.0];

fn plant(further: &str) -> Plant {
    let text =
        format!("robot.file = \"mecanum4.urdf\"\ntwist.vx_m_s = 0\nrun.duration_s = 1\n{further}");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    Plant::of_scenario(&Scenario::from_toml(&text, "attached", folder).expect("a scenario"))
        .expect("it stands")
}

/// Gives a plant the wrench and inertia of a point mass that another simulator holds at a point of
/// its body: W_0 = m (g - w x (w x r)) there, and A = m [1, -r x; r x, -r x r x].
fn attach(plant: &mut Plant, mass_kg: f64, place_m: [f64; 3]) {
    let body = plant.world().robot().state();
    let r = body.world_from_body * Vector3::from(place_m);
    let w = body.world_from_body * body.angular_in_body_rad_s;
    let cross = r.cross_matrix();
    let block = |row: usize, column: usize| match (row, column) {
        (0, 0) => Matrix3::identity(),
        (0, 1) => -cross,
        (1, 0) => cross,
        _ => -cross * cross,
    };
    let inertia = std::array::from_fn(|row| {
        std::array::from_fn(|column| mass_kg * block(row / 3, column / 3)[(row % 3, column % 3)])
    });
    plant.set_articulated_inertia(&inertia).expect("an inertia");
    let gravity = plant.world().gravity_in_world_m_s2();
    let force_n = mass_kg * (gravity - w.cross(&w.cross(&r)));
    plant
        .set_wrench(force_n.into(), [0.0; 3], Some(place_m))
        .expect("a wrench");
}

/// The distance in metres between a robot with an external mass and one with a payload, after a
/// curve of 0.4 s; and the energy of the mass that the plant did not count as external, in J, with
/// its total.
fn apart(mass_kg: f64, dt_s: f64) -> (f64, f64, f64) {
    let place_m = [0.08, -0.05, 0.2];
    // A payload moves the robot's centre of mass away from the origin, which then rotates around
    // it.
    let further = format!(
        "run.physics_dt_s = {dt_s}\n[[faults]]\npayload = {{ mass_kg = 4, x_m = -0.12, y_m = 0.08 }}\n"
    );
    let (mut carries, mut bears) = (plant(&further), plant(&further));
    carries.carry_at(mass_kg, Some(place_m)).expect("a payload");
    let energy_j = |plant: &Plant| {
        let body = plant.world().robot().state();
        let r = body.world_from_body * Vector3::from(place_m);
        let v = body.world_from_body
            * (body.velocity_in_body_m_s
                + body.angular_in_body_rad_s.cross(&Vector3::from(place_m)));
        mass_kg * (0.5 * v.norm_squared() + 9.81 * (body.height_m + r.z))
    };
    // The payload of the scenario is added externally.
    attach(&mut bears, mass_kg, place_m);
    for plant in [&mut carries, &mut bears] {
        let stands = plant.advance(WheelCommand::Rates(&[0.0; 4]), dt_s);
        stands.expect("a step");
    }
    let outside_j = |plant: &Plant| plant.world().outside_energy_j();
    let start_j = energy_j(&bears);
    let before_j = start_j + outside_j(&bears);
    for _ in 0..(0.4 / dt_s).round() as usize {
        attach(&mut bears, mass_kg, place_m);
        for plant in [&mut carries, &mut bears] {
            plant
                .advance(WheelCommand::Rates(&RATES), dt_s)
                .expect("a step");
        }
    }
    let (one, other) = (carries.truth().pose, bears.truth().pose);
    assert!(one.x_m.hypot(one.y_m) > 0.05, "it moves: {one:?}");
    let off_m = (one.x_m - other.x_m).hypot(one.y_m - other.y_m);
    let missing_j = energy_j(&bears) + outside_j(&bears) - before_j;
    (off_m, missing_j, energy_j(&bears) - start_j)
}

/// Masses of a twelfth of the robot's and of ten times that. The difference: the other simulator
/// gives A and W_0 at the beginning of a step, while a payload rotates with the body within it.
/// This error is of first order in the step, so half the step halves it.
#[test]
fn a_mass_that_another_simulator_moves_is_felt_as_one_that_is_carried() {
    for mass_kg in [1.0, 120.0] {
        let (off_m, missing_j, gained_j) = apart(mass_kg, 0.001);
        let (finer_m, ..) = apart(mass_kg, 0.0005);
        println!("{mass_kg} kg: {off_m:e} m, {finer_m:e} m, {missing_j:e} of {gained_j} J");
        assert!(off_m < 1e-4, "{off_m} m");
        assert!(
            finer_m < 0.7 * off_m || finer_m < 1e-6,
            "{finer_m} of {off_m} m"
        );
        assert!(
            missing_j.abs() < 0.01 * gained_j,
            "{missing_j} of {gained_j} J"
        );
    }
}

/// A payload moves the robot's centre of mass, and with it the reference of an external mass: the
/// order of the two does not matter.
#[test]
fn a_payload_moves_the_centre_from_which_what_is_attached_counts() {
    let place_m = [0.08, -0.05, 0.2];
    let ends = [true, false].map(|carries_first| {
        let mut plant = plant("");
        for carries in [carries_first, !carries_first] {
            match carries {
                true => plant.carry_at(3.0, Some([-0.1, 0.07, 0.1])).unwrap(),
                false => attach(&mut plant, 5.0, place_m),
            }
            // A payload is added when a step begins.
            plant.advance(WheelCommand::Rates(&[0.0; 4]), 0.01).unwrap();
        }
        for _ in 0..30 {
            plant.advance(WheelCommand::Rates(&RATES), 0.01).unwrap();
        }
        plant.truth().pose
    });
    let [one, other] = ends;
    let off_m = (one.x_m - other.x_m).hypot(one.y_m - other.y_m);
    let turned_rad = (one.heading_rad - other.heading_rad).abs();
    assert!(one.x_m.hypot(one.y_m) > 0.05, "it moves: {one:?}");
    // The first of the two has made the robot sink by micrometres for 10 ms.
    assert!(off_m < 1e-5 && turned_rad < 1e-5, "{off_m} {turned_rad}");
}

#[test]
fn what_is_no_inertia_is_refused_and_nothing_ends_what_was() {
    let mut plant = plant("");
    let mut good = [[0.0; 6]; 6];
    (0..6).for_each(|axis| good[axis][axis] = 1.0);
    plant.set_articulated_inertia(&good).expect("an inertia");
    let with = |row: usize, column: usize, value: f64| {
        let mut bad = good;
        bad[row][column] = value;
        bad
    };
    for bad in [
        with(0, 0, f64::NAN),
        with(3, 3, f64::INFINITY),
        with(2, 4, 0.1),
        with(5, 5, -1.0),
    ] {
        let refused = plant.set_articulated_inertia(&bad).unwrap_err();
        assert!(refused.to_string().contains("no articulated inertia"));
    }
    // A reset ends it: the robot behaves as without.
    let start = plant.resolved().start();
    let mut moved = Vec::new();
    for _ in 0..2 {
        plant.reset(0, start).expect("a reset");
        for _ in 0..50 {
            plant
                .advance(WheelCommand::Rates(&RATES), 0.01)
                .expect("a step");
        }
        moved.push(plant.truth());
        plant.set_articulated_inertia(&good).expect("an inertia");
    }
    assert_eq!(moved[0], moved[1]);
}

/// Without friction a robot on a slope gains g sin of the slope, whatever its wheels do.
#[test]
fn ground_leans_as_it_is_set() {
    let mut plant = plant("world.floor.friction = 0");
    let (sin, cos) = 0.1_f64.sin_cos();
    plant.set_down([2.0 * sin, 0.0, -2.0 * cos]).expect("down");
    for _ in 0..20 {
        plant
            .advance(WheelCommand::Torques(&[0.0; 4]), 0.01)
            .expect("a step");
    }
    let gained = plant.truth().twist_in_body.vx_m_s / 0.2;
    assert!((gained - 9.81 * sin).abs() < 1e-6, "{gained}");
    plant.set_down([0.0, 0.0, -1.0]).expect("level");
    let before = plant.truth().twist_in_body.vx_m_s;
    plant
        .advance(WheelCommand::Torques(&[0.0; 4]), 0.02)
        .expect("a step");
    assert!((plant.truth().twist_in_body.vx_m_s - before).abs() < 1e-9);
    for bad in [[0.0; 3], [f64::NAN, 0.0, -1.0], [f64::INFINITY, 0.0, -1.0]] {
        assert!(plant.set_down(bad).is_err());
    }
}

/// If rapier's own solver moves the robot, unsupported features are refused.
#[test]
fn rapiers_solver_refuses_what_it_does_not_do() {
    let mut plant = plant("world.solver.contacts = \"rapier\"");
    assert!(plant.set_articulated_inertia(&[[0.0; 6]; 6]).is_err());
    assert!(plant.set_down([0.1, 0.0, -1.0]).is_err());
    assert!(plant.set_grip(0, 0.5).is_err());
}
