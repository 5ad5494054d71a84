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
