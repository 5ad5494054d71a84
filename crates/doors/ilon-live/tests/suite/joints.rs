//! Servos of joints between bodies in a live run: their commands, and messages about impossible
//! ones.

use ilon_live::{Controls, Session};
use ilon_sim::Scenario;

/// A robot whose arm is at 0.2 rad in the scenario.
fn session() -> Session {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    let text = r#"
[robot]
file = "mecanum4_arm.urdf"
roller_bodies = "near"
wheels = { rollers = 9, roller_radius_m = 0.012, roller_mass_kg = 0.01, damping_n_m_s = 1e-6, gamma.x_deg = 45 }
[robot.joints.arm]
role = "driven"
target_rad = 0.2
[twist]
vx_m_s = 0
[run]
duration_s = 1
"#;
    let scenario = Scenario::from_toml(text, "arm", folder).expect("a scenario");
    Session::new(&scenario).expect("a session")
}

/// The arm's position after several control periods.
fn goes(session: &mut Session, controls: &Controls, periods: usize) -> f64 {
    for _ in 0..periods {
        session.advance(controls).expect("it goes");
    }
    session.row().expect("a row").record.joints[0].position
}

/// A command moves a joint, which stays there; a return to the start resets it, and earlier
/// commands no longer count.
#[test]
fn a_joint_goes_where_it_is_sent_and_back_to_its_start() {
    let (mut session, mut controls) = (session(), Controls::default());
    assert!((goes(&mut session, &controls, 5) - 0.2).abs() < 1e-3);
    assert_eq!(controls.take(r#"{"joints": {"arm": 0.6}}"#), None);
    assert!((goes(&mut session, &controls, 150) - 0.6).abs() < 2e-3);
    controls.take(r#"{"reset": true}"#);
    assert!((goes(&mut session, &controls, 100) - 0.2).abs() < 2e-3);
    controls.take(r#"{"joints": {"arm": 0.6}}"#);
    assert!((goes(&mut session, &controls, 150) - 0.6).abs() < 2e-3);
}

/// An impossible command is reported once, and the joint stays where it is.
#[test]
fn what_no_joint_can_do_is_said() {
    for (command, words) in [
        (r#"{"joints": {"arm": 9.0}}"#, "its limits are"),
        (r#"{"joints": {"arn": 0.1}}"#, "no joint `arn`"),
        (
            r#"{"joints": {"front_left": 0.1}}"#,
            "no joint `front_left`",
        ),
    ] {
        let (mut session, mut controls) = (session(), Controls::default());
        controls.take(command);
        assert!((goes(&mut session, &controls, 20) - 0.2).abs() < 1e-3);
        let notes: Vec<String> = session.take_notes().collect();
        let about: Vec<&String> = notes.iter().filter(|note| note.contains(words)).collect();
        assert_eq!(about.len(), 1, "{notes:?}");
    }
}

/// The shipped swerve robot under a twist to the left turns its modules by 90 degrees and reaches
/// the twist, as under `[twist]`; after a return to the start it does so again. The wheels do not
/// slip but for creep across the tyres, below 1e-3.
#[test]
fn steered_wheels_turn_to_a_twist_by_hand() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/scenarios/swerve4_skew.toml"
    );
    let scenario = Scenario::load(path).expect("a scenario");
    let mut session = Session::new(&scenario).expect("a session");
    let mut controls = Controls::default();
    for _ in 0..2 {
        controls.take(r#"{"twist": [0, 0.3, 0]}"#);
        for _ in 0..200 {
            session.advance(&controls).expect("it goes");
        }
        let real = session.figures(&controls).real;
        let [vx_m_s, vy_m_s, omega_rad_s] = real;
        assert!((vy_m_s - 0.3).abs() < 3e-4, "{real:?}");
        assert!(vx_m_s.abs().max(omega_rad_s.abs()) < 3e-4, "{real:?}");
        controls.take(r#"{"reset": true}"#);
    }
}

/// Under a reference a tricycle goes as the run of the same scenario does, and by hand it drives a
/// twist about its origin, with the gain that was set meanwhile; creep takes less than 1 %.
#[test]
fn a_tricycle_follows_its_path_and_then_a_hand() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    let text = "robot = { file = \"tricycle.urdf\", x_m = 1, heading_deg = 90 }\n\
                reference.circle = { radius_m = 1, speed_m_s = 0.3, heading = \"along_path\" }\n\
                run = { duration_s = 2, physics_dt_s = 1e-3 }\n";
    let scenario = Scenario::from_toml(text, "circle", folder).expect("a scenario");
    let mut session = Session::new(&scenario).expect("a session");
    let mut controls = Controls::default();
    let mut go = |controls: &Controls, periods: usize| {
        for _ in 0..periods {
            session.advance(controls).expect("it goes");
        }
        (session.frame().pose, session.figures(controls).real)
    };
    controls.take(r#"{"mode": "reference"}"#);
    let (pose, _) = go(&controls, 200);
    let run = ilon_sim::run(&scenario).expect("a run");
    let end = run.trace.records().last().expect("rows").truth.pose;
    let off_m = (pose.position_m() - end.position_m()).norm();
    assert!(off_m < 1e-9, "{pose:?}, {end:?} in a run");
    controls.take(r#"{"mode": "hand", "twist": [0.2, 0, -0.2], "position_gain_per_s": 2}"#);
    let (_, real) = go(&controls, 300);
    assert!((real[0] - 0.2).abs() < 2e-3, "{real:?}");
    assert!((real[2] + 0.2).abs() < 2e-3, "{real:?}");
}
