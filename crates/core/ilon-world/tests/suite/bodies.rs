//! Several robots in one world, by their identities.

use ilon_formats::LoadRobot;
use ilon_robot::{Pose, Robot};
use ilon_world::{
    BodyId, ContactSolver, Floor, MotorTorque, RollerBodies, Settings, SharedRobot, World,
    WorldError,
};

fn shipped(name: &str) -> SharedRobot {
    let path = format!(
        "{}/../../../assets/robots/{name}.urdf",
        env!("CARGO_MANIFEST_DIR")
    );
    SharedRobot::from(&Robot::load(path).expect("a shipped robot"))
}

fn at(x_m: f64, y_m: f64) -> Pose {
    Pose {
        x_m,
        y_m,
        heading_rad: 0.0,
    }
}

fn settings() -> Settings {
    Settings {
        dt_s: 2e-3,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    }
}

fn world(robots: &[(&SharedRobot, Pose)]) -> (World, Vec<BodyId>) {
    let robots = robots
        .iter()
        .map(|(robot, start)| ((*robot).clone(), *start));
    let world = World::of_bodies(robots, &Floor::default(), &settings()).expect("room for all");
    let ids = world.bodies().collect();
    (world, ids)
}

/// Motors that keep all wheels near a rate, in rad/s.
fn hold(world: &mut World, id: BodyId, rate_rad_s: f64) {
    const GAIN_N_M_S: f64 = 0.2;
    let rates = world.body(id).wheel_rates_rad_s().iter();
    let motors: Vec<MotorTorque> = rates
        .map(|rate| MotorTorque::with_droop(GAIN_N_M_S * (rate_rad_s - rate), GAIN_N_M_S))
        .collect();
    world.body_mut(id).drive(&motors);
}

/// Robots that do not touch behave as if alone: each has its own commands and state. The contacts
/// of all are solved together, to a residual below 1e-9 m/s: over 250 steps of 2 ms 1e-9 m.
#[test]
fn robots_apart_from_each_other_go_as_each_would_alone() {
    let (mecanum4, volksbot) = (shipped("mecanum4"), shipped("volksbot"));
    let (there, elsewhere) = (at(0.0, 0.0), at(3.0, -2.0));
    let (mut together, ids) = world(&[(&mecanum4, there), (&volksbot, elsewhere)]);
    let (mut first, _) = world(&[(&mecanum4, there)]);
    let (mut second, _) = world(&[(&volksbot, elsewhere)]);
    let alone = [
        first.bodies().next().unwrap(),
        second.bodies().next().unwrap(),
    ];
    for _ in 0..250 {
        hold(&mut together, ids[0], 4.0);
        hold(&mut together, ids[1], -3.0);
        hold(&mut first, alone[0], 4.0);
        hold(&mut second, alone[1], -3.0);
        together.step();
        first.step();
        second.step();
    }
    for (id, single) in ids.iter().zip([&first, &second]) {
        let (seen, expected) = (together.body(*id).state(), single.robot().state());
        let apart_m = seen.pose.position_m() - expected.pose.position_m();
        assert!(apart_m.norm() < 1e-9, "{:e} m", apart_m.norm());
        let turned_rad = seen.pose.heading_rad - expected.pose.heading_rad;
        assert!(turned_rad.abs() < 1e-8, "{turned_rad:e} rad");
    }
    assert!(first.robot().state().pose.x_m > 0.05);
    // Energies are those of all of them.
    let sum_j = first.motor_energy_j() + second.motor_energy_j();
    assert!((together.motor_energy_j() / sum_j - 1.0).abs() < 1e-6);
}

/// A robot that drives into another one with free wheels takes it along: in the end both have the
/// same speed, and the motors' work is kinetic energy, heat or impact loss. The balance closes like
/// that of one robot, to a thousandth.
#[test]
fn a_robot_pushes_another_along() {
    let robot = shipped("mecanum4");
    let (mut world, ids) = world(&[(&robot, at(0.0, 0.0)), (&robot, at(0.45, 0.0))]);
    let start_j = world.energy().kinetic_j + world.energy().potential_j;
    for _ in 0..1000 {
        hold(&mut world, ids[0], 6.0);
        world.step();
    }
    let [pushes, pushed] = [0, 1].map(|i| world.body(ids[i]).state());
    assert!(pushed.pose.x_m > 0.6, "{}", pushed.pose.x_m);
    // Chassis of 0.4 m, nose to tail.
    let gap_m = pushed.pose.x_m - pushes.pose.x_m - 0.4;
    assert!(gap_m.abs() < 1e-4, "{gap_m:e}");
    let faster = pushed.twist_in_body.vx_m_s / pushes.twist_in_body.vx_m_s;
    assert!((faster - 1.0).abs() < 1e-3, "{faster}");
    let now_j = world.energy().kinetic_j + world.energy().potential_j;
    let went_j = now_j - start_j
        + world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.impact_energy_j()
        + world.bearing_energy_j();
    let brought_j = world.motor_energy_j() + world.outside_energy_j();
    assert!(
        (went_j / brought_j - 1.0).abs() < 1e-3,
        "{went_j} J of {brought_j} J"
    );
}

/// Chassis that close in by many times in a step what they are searched within are stopped as they
/// meet. From 0.3 m apart at the grip of 0.6 g the robot is at 1.9 m/s, and would enter the other
/// one by up to 9 mm in a step of 5 ms; a tenth of that is left to the softness of the contact.
#[test]
fn robots_that_meet_fast_do_not_enter_each_other() {
    let robot = shipped("mecanum4");
    let starts = [(robot.clone(), at(0.0, 0.0)), (robot, at(0.7, 0.0))];
    let settings = Settings {
        dt_s: 5e-3,
        ..settings()
    };
    let mut world = World::of_bodies(starts, &Floor::default(), &settings).expect("room for both");
    let ids: Vec<BodyId> = world.bodies().collect();
    let (mut least_m, mut fastest_m_s) = (f64::INFINITY, 0.0_f64);
    for _ in 0..120 {
        hold(&mut world, ids[0], 60.0);
        world.step();
        let [hits, is_hit] = [0, 1].map(|index| world.body(ids[index]).state());
        least_m = least_m.min(is_hit.pose.x_m - hits.pose.x_m - 0.4);
        fastest_m_s = fastest_m_s.max(hits.twist_in_body.vx_m_s);
    }
    assert!(fastest_m_s > 1.0, "{fastest_m_s} m/s");
    assert!(least_m < 1e-3 && least_m > -0.9e-3, "{least_m} m");
}

/// Any two robots touch, whatever else is in the world: a third one far away, at any index, leaves
/// their motion unchanged. The contacts of all are solved together, to a residual below 1e-9 m/s in
/// each of 250 steps; their mutual forces may amplify that by a thousand, 1e-6 m/s over half a
/// second.
#[test]
fn any_two_of_three_robots_touch() {
    let robot = shipped("mecanum4");
    let (pushes, pushed, far) = (at(0.0, 0.0), at(0.41, 0.0), at(0.0, 4.0));
    let ends = [
        vec![far, pushes, pushed],
        vec![pushes, far, pushed],
        vec![pushes, pushed],
    ]
    .map(|starts| {
        let robots: Vec<_> = starts.iter().map(|start| (&robot, *start)).collect();
        let (mut world, ids) = world(&robots);
        let id_of = |of: Pose| ids[starts.iter().position(|start| *start == of).unwrap()];
        for _ in 0..250 {
            hold(&mut world, id_of(pushes), 6.0);
            world.step();
        }
        [pushes, pushed].map(|of| world.body(id_of(of)).state().pose.x_m)
    });
    println!("{ends:?}");
    assert!(ends[2][1] > 0.42, "it is pushed");
    for end in &ends[..2] {
        for (x_m, alone_m) in end.iter().zip(&ends[2]) {
            assert!((x_m - alone_m).abs() < 1e-6, "{ends:?}");
        }
    }
}

#[test]
fn bodies_that_cannot_begin_together_are_refused() {
    let robot = shipped("mecanum4");
    let build = |starts: &[Pose], settings: &Settings| {
        let robots = starts.iter().map(|start| (robot.clone(), *start));
        World::of_bodies(robots, &Floor::default(), settings).map(|_| ())
    };
    assert_eq!(build(&[], &settings()), Err(WorldError::NoBodies));
    let overlap = build(&[at(0.0, 0.0), at(0.3, 0.1)], &settings());
    assert!(
        matches!(overlap, Err(WorldError::NoPlaceToStand { .. })),
        "{overlap:?}"
    );
    assert_eq!(build(&[at(0.0, 0.0), at(0.41, 0.1)], &settings()), Ok(()));
    let reference = Settings {
        contacts: ContactSolver::Rapier,
        roller_bodies: RollerBodies::All,
        ..settings()
    };
    let in_rapier = build(&[at(0.0, 0.0), at(2.0, 0.0)], &reference);
    assert!(
        matches!(in_rapier, Err(WorldError::NotInRapier { .. })),
        "{in_rapier:?}"
    );
}

#[test]
#[should_panic(expected = "body 1 of a world of 1")]
fn an_identity_of_another_world_is_no_body_here() {
    let robot = shipped("volksbot");
    let (_, ids) = world(&[(&robot, at(0.0, 0.0)), (&robot, at(2.0, 0.0))]);
    let (alone, _) = world(&[(&robot, at(0.0, 0.0))]);
    alone.body(ids[1]);
}

/// The same with rollers that spin up as they land, which jolts their robot: one robot moves
/// sideways and one turns, each as if alone.
#[test]
fn what_jolts_one_robot_jolts_no_other() {
    let mecanum4 = shipped("mecanum4");
    let starts = [at(0.0, 0.0), at(0.0, 0.8)];
    let rates = [[-6.0, 6.0, 6.0, -6.0], [-5.0, 5.0, -5.0, 5.0]];
    let drive = |world: &mut World, id: BodyId, targets: [f64; 4]| {
        let now = world.body(id).wheel_rates_rad_s().to_vec();
        let motor = |k: usize| MotorTorque::with_droop(0.2 * (targets[k] - now[k]), 0.2);
        world.body_mut(id).drive(&[0, 1, 2, 3].map(motor));
    };
    let (mut together, ids) = world(&[(&mecanum4, starts[0]), (&mecanum4, starts[1])]);
    let mut alone = starts.map(|start| world(&[(&mecanum4, start)]).0);
    for _ in 0..400 {
        for k in 0..2 {
            drive(&mut together, ids[k], rates[k]);
            let id = alone[k].bodies().next().expect("one");
            drive(&mut alone[k], id, rates[k]);
            alone[k].step();
        }
        together.step();
    }
    for (id, single) in ids.iter().zip(&alone) {
        let (seen, expected) = (together.body(*id).state().pose, single.robot().state().pose);
        // Solved together, to 1e-9 m/s in each step: over 0.8 s 1e-9 m.
        let apart_m = seen.position_m() - expected.position_m();
        assert!(apart_m.norm() < 1e-8, "{:e} m", apart_m.norm());
        let turned_rad = seen.heading_rad - expected.heading_rad;
        assert!(turned_rad.abs() < 1e-7, "{turned_rad:e} rad");
    }
    let moved = together.body(ids[0]).state().pose.position_m().norm();
    let turned_rad = together.body(ids[1]).state().pose.heading_rad;
    assert!(
        moved > 0.15 && turned_rad.abs() > 0.3,
        "{moved} m, {turned_rad} rad"
    );
    let spun_j: f64 = alone.iter().map(World::spin_up_energy_j).sum();
    assert!(spun_j > 1e-4, "{spun_j} J");
}
