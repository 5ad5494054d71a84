use super::*;
use crate::sample::made_up_run;
use ilon_trace::{Trace, WheelHeader};

#[test]
fn an_event_lasts_from_its_begin_to_its_end() {
    let event = Event {
        from_s: 1.5,
        until_s: 4.0,
        kind: EventKind::Fault,
        text: String::new(),
        slid_m: 0.0,
        lost_j: 0.0,
    };
    let table = events_table(&[event]);
    assert!(table.contains("<td>2.50 s</td>"), "{table}");
}

/// What was done on purpose stands above what came of it, whichever began first.
#[test]
fn lanes_stand_in_the_order_of_cause_and_effect() {
    let kinds = [
        EventKind::Touch,
        EventKind::Ground,
        EventKind::Stance(crate::story::Stance::Tipped),
        EventKind::Fault,
    ];
    let events = kinds.into_iter().zip(0_u8..).map(|(kind, at)| Event {
        from_s: f64::from(at),
        until_s: 9.0,
        kind,
        text: String::new(),
        slid_m: 0.0,
        lost_j: 0.0,
    });
    let html = track(&Header::default(), [0.0, 9.0], &events.collect::<Vec<_>>());
    let places = ["faults", "posture", "ground", "bodies"].map(|lane| html.find(lane));
    assert!(places.is_sorted() && places[0].is_some(), "{html}");
}

#[test]
fn a_run_beside_others_shares_their_slider_and_offers_them_as_ghosts_first() {
    let page = stage(&Viewer {
        title: "one, and the others as ghosts",
        is_run: true,
        scene: Some("{}"),
        ways: &["two".to_owned()],
        clock: clock(1.0, 3.5, &[]),
        ..Viewer::default()
    });
    assert!(
        page.contains("\"start\":1.0") && page.contains("\"end\":3.5"),
        "{page}"
    );
    let place = |words: &str| page.find(words).expect("an option");
    assert!(
        place(">two</option>") < place(">ideal kinematics</option>"),
        "{page}"
    );
    // The next event belongs to a run with events.
    assert!(!page.contains("class=\"next\""), "{page}");
}

#[test]
fn the_way_of_a_run_begins_and_ends_where_the_run_does() {
    let trace = made_up_run(2.0, false);
    let Ok(way) = way_of("two", &trace);
    let [first, last] = [0, trace.records().len() - 1].map(|row| trace.records()[row].truth.pose);
    let f32_of = |pose: ilon_robot::Pose| [pose.x_m, pose.y_m, pose.heading_rad].map(|x| x as f32);
    assert_eq!(way.poses[0][1..], f32_of(first));
    assert_eq!(way.poses.last().expect("poses")[1..], f32_of(last));
}

/// A robot's file that has changed since the run is not shown moving: one with a wheel more, or
/// with other rollers.
#[test]
fn a_robot_with_other_wheels_than_the_run_is_not_shown() {
    let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
    let robot = Robot::from_urdf_str(urdf, "mecanum4").expect("a shipped robot");
    let shown = |wheels: usize, roller_count: usize| {
        let mut header = Header {
            urdf: urdf.into(),
            ..Header::default()
        };
        let wheel = WheelHeader {
            roller_count,
            ..WheelHeader::default()
        };
        header.wheels = vec![wheel; wheels];
        let trace = Trace::with_capacity(header, 0);
        let Ok(picture) = picture_of(&trace, Some(&robot), None, Vec::new());
        picture.is_some()
    };
    let rollers = robot.wheels[0].rollers.len();
    assert!(shown(4, rollers));
    assert!(!shown(3, rollers));
    assert!(!shown(4, rollers + 1));
}
