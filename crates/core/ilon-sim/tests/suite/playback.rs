//! Logs that drive robots: a recorded motion is repeated, and invalid logs are refused with the
//! reason.

use std::path::{Path, PathBuf};

use ilon_formats::describe;
use ilon_messages::bag::{BagWriter, Qos};
use ilon_messages::builtin_interfaces::Time;
use ilon_messages::geometry_msgs::Twist;
use ilon_messages::nav_msgs::Odometry;
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::topics::BagSink;
use ilon_sim::simulate::Simulation;
use ilon_sim::{Error, Run, Scenario, run};
use ilon_trace::{Sink, Trace};

const ROBOT: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../../assets/robots/mecanum4.urdf"
);

/// Half a second of driving ahead and to the side, with a turn.
const DRIVEN: &str =
    "[twist]\nvx_m_s = 0.3\nvy_m_s = 0.2\nomega_rad_s = 0.5\nrest_s = 0.1\nramp_s = 0.1\n";

fn scenario(folder: &Path, motion: &str) -> Result<Scenario, Error> {
    let text = format!("[robot]\nfile = \"{ROBOT}\"\n{motion}\n[run]\nduration_s = 0.6\n");
    let mut scenario = Scenario::from_toml(&text, "test", folder)?;
    scenario.folder = folder.to_owned();
    Ok(scenario)
}

fn ran(folder: &Path, motion: &str) -> Run {
    run(&scenario(folder, motion).expect("a scenario")).expect("a run")
}

/// The error for a log that cannot be played.
fn refused(folder: &Path, motion: &str) -> String {
    let scenario = scenario(folder, motion).expect("a scenario");
    match run(&scenario) {
        Err(error @ Error::Contents { .. }) => error.to_string(),
        other => panic!("{:?}", other.map(|run| run.summary)),
    }
}

/// A run as a bag, and its trace.
fn recorded(folder: &Path) -> (PathBuf, Trace) {
    let simulation =
        Simulation::new(&scenario(folder, DRIVEN).expect("a scenario")).expect("a simulation");
    let bag = folder.join("bag");
    let robot = simulation.plant().robot();
    let described = describe(robot, &simulation.trace().header.urdf);
    let mut sink = BagSink::create(&bag, robot, described).expect("a bag");
    sink.begin(&simulation.trace().header).expect("a bag");
    let trace = simulation.run().trace;
    sink.take(&trace).expect("rows");
    sink.finish().expect("a whole bag");
    (bag, trace)
}

/// The largest distance between two robots at the same time, in metres.
fn apart_m(one: &Trace, other: &Trace) -> f64 {
    let pairs = one.records().iter().zip(other.records());
    pairs
        .map(|(a, b)| (a.truth.pose.position_m() - b.truth.pose.position_m()).norm())
        .fold(0.0, f64::max)
}

/// A log of twists steers the modules of a swerve robot as `[twist]` does, so both go the same way; a
/// module whose joint has a column in the log goes where that sends it.
#[test]
fn a_log_of_twists_steers_what_it_does_not_move_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    let go = |motion: &str| {
        let text = format!(
            "[robot]\nfile = \"{robots}/swerve4.urdf\"\n{motion}\n[run]\nduration_s = 1.5\n"
        );
        let mut scenario = Scenario::from_toml(&text, "test", folder.path()).expect("a scenario");
        scenario.folder = folder.path().to_owned();
        run(&scenario).expect("a run").trace
    };
    let log = |name: &str, columns: &str, numbers: &str| {
        let text = format!(
            "t_s,vx_m_s,vy_m_s,omega_rad_s{columns}\n0,0,0.3,0.2{numbers}\n2,0,0.3,0.2{numbers}\n"
        );
        std::fs::write(folder.path().join(name), text).expect("a log");
        format!("[playback]\nfile = \"{name}\"\ndrives = \"twist\"\n")
    };
    let twist = go("[twist]\nvy_m_s = 0.3\nomega_rad_s = 0.2\nrest_s = 0\nramp_s = 0\n");
    let played = go(&log("log.csv", "", ""));
    assert!(apart_m(&twist, &played) < 1e-9);
    assert!(twist.records().last().expect("rows").truth.pose.y_m > 0.2);
    // At 30 degrees, although the twist wants some 90.
    let held = go(&log("held.csv", ",front_left_steer_position_deg", ",30"));
    let place = |name: &str| {
        held.header
            .joints
            .iter()
            .position(|joint| joint.name == name)
    };
    let at = place("front_left_steer").expect("the joint");
    let last = &held.records().last().expect("rows").joints[at];
    assert!(
        (last.position - 30_f64.to_radians()).abs() < 0.02,
        "{last:?}"
    );
}

/// A tricycle's log has its driven wheel and its steering: the wheels behind roll along, and neither
/// contradict it nor count as commanded to stand. Their names in other logs are no mistake.
#[test]
fn a_log_need_not_have_wheels_that_no_motor_drives() {
    let folder = tempfile::tempdir().expect("a folder");
    // 0.06 m a radian: 0.3 m/s, on an arc of 0.45 m / tan(20 deg) = 1.236 m.
    let rows: Vec<String> = (0..=60)
        .map(|row| {
            format!(
                "{:.1},{:.4},20\n",
                0.1 * f64::from(row),
                0.5 * f64::from(row)
            )
        })
        .collect();
    let text = "t_s,drive_angle_rad,drive_steer_position_deg\n".to_owned() + &rows.concat();
    std::fs::write(folder.path().join("log.csv"), text).expect("a log");
    let robot = ROBOT.replace("mecanum4.urdf", "tricycle.toml");
    let text = format!(
        "[robot]\nfile = \"{robot}\"\n[playback]\nfile = \"log.csv\"\ndrives = \"wheel_angles\"\n[playback.names]\nleft = \"rear_left\"\n[run]\nduration_s = 6\n"
    );
    let mut scenario = Scenario::from_toml(&text, "test", folder.path()).expect("a scenario");
    scenario.folder = folder.path().to_owned();
    let run = run(&scenario).expect("a run");
    assert!(
        !run.warnings.iter().any(|of| of.contains("contradict")),
        "{:#?}",
        run.warnings
    );
    // The rear axle's middle goes as fast as the front wheel times cos(20 deg).
    let summary = &run.summary;
    let asked = summary.twist_asked_mean.expect("a command");
    let expected_m_s = 0.3 * 20_f64.to_radians().cos();
    // The body's origin lies 0.2 m ahead of that axle: its speed ahead is the same.
    // With wheels that are to stand, the command would be a third of it.
    let off = asked.vx_m_s / expected_m_s - 1.0;
    assert!(off.abs() < 2e-3, "{asked:?}");
    // The wheels start from rest, and are at speed after a tenth of one of six seconds.
    let real = summary.twist_mean.expect("a mean");
    let off = real.vx_m_s / expected_m_s - 1.0;
    assert!((-0.1 / 6.0..2e-3).contains(&off), "{real:?}");
}

#[test]
fn wheel_rates_of_a_bag_do_again_what_they_did() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, before) = recorded(folder.path());
    let played = ran(
        folder.path(),
        "[playback]\nfile = \"bag\"\ndrives = \"wheel_rates\"\ntopic = \"/robot_joint_commands\"\npose_topic = \"/ground_truth/odom\"\n",
    );
    // The same rates at the same times; the automatic step may differ because each scenario
    // predicts other rates, which moves a contact's place within its step.
    let off_m = apart_m(&before, &played.trace);
    assert!(off_m < 1e-5, "{off_m} m apart after 0.1 m of way");
    for record in played.trace.records() {
        let measured = record.measured.expect("a pose at each time");
        assert!((measured.position_m() - record.truth.pose.position_m()).norm() < 1e-5);
    }
    assert!(played.trace.header.open_loop && played.trace.header.measured);
    let way_m = before
        .records()
        .last()
        .expect("rows")
        .truth
        .pose
        .position_m()
        .norm();
    assert!(way_m > 0.1, "it hardly moved, {way_m} m");
}

#[test]
fn angles_torques_twists_and_paths_of_a_bag_drive_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, before) = recorded(folder.path());
    // A loop that follows angles lags by up to a control period of travel, 4 mm, and the torques
    // were means over periods. The guidance starts its feedback from zero: it follows a path within
    // a centimetre.
    for (drives, topic, within_m) in [
        ("wheel_angles", "/joint_states", 0.006),
        ("wheel_torques", "/joint_states", 0.01),
        ("twist", "/cmd_vel", 1e-5),
        ("path", "/ground_truth/odom", 0.02),
    ] {
        let motion =
            format!("[playback]\nfile = \"bag\"\ndrives = \"{drives}\"\ntopic = \"{topic}\"\n");
        let played = ran(folder.path(), &motion);
        let off_m = apart_m(&before, &played.trace);
        assert!(off_m < within_m, "{drives}: {off_m} m apart");
        assert_eq!(played.trace.header.open_loop, drives != "path", "{drives}");
    }
}

#[test]
fn a_csv_file_says_the_same_in_its_own_names_and_units() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, before) = recorded(folder.path());
    let names: Vec<&str> = before
        .header
        .wheels
        .iter()
        .map(|wheel| wheel.name.as_str())
        .collect();
    let mut exact = format!(
        "\u{feff}t_s,{},measured_x_m,measured_y_m,measured_heading_deg\n",
        names
            .iter()
            .map(|n| format!("{n}_rate_rad_s"))
            .collect::<Vec<_>>()
            .join(",")
    );
    let mut own = "# of a robot of one's own\nt_ms, fl, fr, rl, rr\n".to_owned();
    for (record, wheels) in before.steps() {
        let t_s = 1000.0 + record.t_s;
        let rates: Vec<String> = wheels
            .iter()
            .map(|wheel| wheel.target_rad_s.to_string())
            .collect();
        let pose = record.truth.pose;
        let (x, y, heading) = (pose.x_m + 5.0, pose.y_m, pose.heading_rad.to_degrees());
        exact += &format!("{t_s},{},{x},{y},{heading}\n", rates.join(","));
        own += &format!("{}, {}\n", 1e3 * t_s, rates.join(", "));
    }
    std::fs::write(folder.path().join("exact.csv"), exact).expect("a file");
    std::fs::write(folder.path().join("own.csv"), own).expect("a file");
    let names: String = names
        .iter()
        .zip(["fl", "fr", "rl", "rr"])
        .map(|(ours, theirs)| format!("{ours} = \"{theirs}\"\n"))
        .collect();
    for (file, further) in [
        ("exact", String::new()),
        ("own", format!("[playback.names]\n{names}")),
    ] {
        let motion =
            format!("[playback]\nfile = \"{file}.csv\"\ndrives = \"wheel_rates\"\n{further}");
        let played = ran(folder.path(), &motion);
        let off_m = apart_m(&before, &played.trace);
        assert!(off_m < 1e-5, "{file}: {off_m} m apart");
        // Placed at the start, wherever it was measured.
        let measured = played.trace.records()[50]
            .measured
            .map(|pose| pose.position_m());
        let truth = before.records()[50].truth.pose.position_m();
        assert_eq!(measured.is_some(), file == "exact");
        assert!(measured.is_none_or(|measured| (measured - truth).norm() < 1e-9));
    }
}

#[test]
fn the_beginning_of_a_log_can_be_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows: String = (0..100)
        .map(|row| {
            format!(
                "{},{},0,0\n",
                0.01 * f64::from(row),
                if row < 50 { 0.0 } else { 0.2 }
            )
        })
        .collect();
    std::fs::write(
        folder.path().join("twist.csv"),
        format!("t_s,vx_m_s,vy_m_s,omega_rad_s\n{rows}"),
    )
    .expect("a file");
    let way_m = |further: &str| {
        let played = ran(
            folder.path(),
            &format!("[playback]\nfile = \"twist.csv\"\ndrives = \"twist\"\n{further}"),
        );
        played.trace.records().last().expect("rows").truth.pose.x_m
    };
    // 0.2 m/s from 0.5 s on, in a run of 0.6 s, or from its beginning until the end of the log; the
    // acceleration takes some hundredths.
    assert!((way_m("") - 0.02).abs() < 0.01, "{}", way_m(""));
    let later = way_m("from_s = 0.5\n");
    assert!((later - 0.1).abs() < 0.015, "{later}");
    let none = refused(
        folder.path(),
        "[playback]\nfile = \"twist.csv\"\ndrives = \"twist\"\nfrom_s = 2\n",
    );
    assert!(none.contains("leaves nothing"), "{none}");
}

#[test]
fn what_is_no_log_is_refused_with_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let play = |file: &str, further: &str| {
        refused(
            folder.path(),
            &format!("[playback]\nfile = \"{file}\"\n{further}\n"),
        )
    };
    let twist = "drives = \"twist\"";
    std::fs::write(at("other.csv"), "a,b\n1,2\n").expect("a file");
    assert!(play("other.csv", twist).contains("column `t_s` is missing"));
    std::fs::write(
        at("words.csv"),
        "t_s,vx_m_s,vy_m_s,omega_rad_s\n0,0,0,0\n1,fast,0,0\n",
    )
    .expect("a file");
    let said = play("words.csv", twist);
    assert!(
        said.contains("line 3: `vx_m_s` is text, but must be a number"),
        "{said}"
    );
    for bad in ["nan", "inf", "1e300"] {
        std::fs::write(
            at("nan.csv"),
            format!("t_s,vx_m_s,vy_m_s,omega_rad_s\n0,{bad},0,0\n"),
        )
        .expect("a file");
        assert!(play("nan.csv", twist).contains("line 2"), "{bad}");
    }
    std::fs::write(
        at("back.csv"),
        "t_s,vx_m_s,vy_m_s,omega_rad_s\n1,0,0,0\n0,0,0,0\n",
    )
    .expect("a file");
    assert!(play("back.csv", twist).contains("do not increase"));
    std::fs::write(at("none.csv"), "t_s,vx_m_s,vy_m_s,omega_rad_s\n").expect("a file");
    assert!(play("none.csv", twist).contains("nothing that could drive"));
    std::fs::write(at("no.mcap"), "no mcap at all").expect("a file");
    assert!(play("no.mcap", twist).contains("is no MCAP file"));
    std::fs::create_dir(at("folder")).expect("a folder");
    assert!(play("folder", twist).contains("without an MCAP file"));
    std::fs::write(at("folder/x.db3"), "").expect("a file");
    assert!(play("folder", twist).contains("SQLite"));

    let mut bag = BagWriter::create(&at("several")).expect("a bag");
    bag.declare::<Twist>("/a/cmd_vel", Qos::reliable(1))
        .expect("a topic");
    bag.declare::<Twist>("/b/cmd_vel", Qos::reliable(1))
        .expect("a topic");
    bag.declare::<Odometry>("/odom", Qos::reliable(1))
        .expect("a topic");
    bag.declare::<JointState>("/joint_states", Qos::reliable(1))
        .expect("a topic");
    for time_ns in [1, 2] {
        bag.write("/a/cmd_vel", &Twist::default(), time_ns)
            .expect("a message");
        bag.write("/b/cmd_vel", &Twist::default(), time_ns)
            .expect("a message");
        let mut joints = JointState::default();
        joints.header.stamp = Time { sec: 0, nanosec: 1 };
        joints.name = vec!["front_left".to_owned(), "arm".to_owned()];
        joints.velocity = vec![1.0, f64::NAN];
        bag.write("/joint_states", &joints, time_ns)
            .expect("a message");
        let mut lost = Odometry::default();
        lost.twist.twist.linear.x = f64::NAN;
        bag.write("/odom", &lost, time_ns).expect("a message");
    }
    bag.finish().expect("a bag");
    assert!(play("several", twist).contains("several of its topics"));
    assert!(play("several", "drives = \"twist\"\ntopic = \"/c\"").contains("no messages of"));
    assert!(
        play("several", "drives = \"twist\"\ntopic = \"/odom\"")
            .contains("not finite or too large")
    );
    assert!(
        play(
            "several",
            "drives = \"wheel_rates\"\ntopic = \"/a/cmd_vel\""
        )
        .contains("is of the type geometry_msgs/msg/Twist")
    );
    assert!(
        play("several", "drives = \"wheel_rates\"")
            .contains("no velocity of the wheel `front_right`")
    );
}

#[test]
fn a_damaged_bag_never_ends_in_a_panic() {
    let folder = tempfile::tempdir().expect("a folder");
    let (bag, _) = recorded(folder.path());
    let whole = std::fs::read(bag.join("bag_0.mcap")).expect("a bag");
    let path = folder.path().join("cut.mcap");
    let motion = "[playback]\nfile = \"cut.mcap\"\ndrives = \"twist\"\ntopic = \"/cmd_vel\"\n";
    let scenario = scenario(folder.path(), motion).expect("a scenario");
    let mut played = 0;
    for part in 0..40 {
        let mut bytes = whole[..whole.len() * part / 40].to_vec();
        // Every other one complete, with some bytes changed.
        if part % 2 == 1 {
            bytes = whole.clone();
            for place in (part * 977..bytes.len()).step_by(bytes.len() / 7) {
                bytes[place] ^= 0x55;
            }
        }
        std::fs::write(&path, bytes).expect("a file");
        match Simulation::new(&scenario) {
            Ok(_) => played += 1,
            Err(Error::Contents { .. }) => {}
            Err(other) => panic!("{other}"),
        }
    }
    // A bag cut in its last chunk still has the earlier messages.
    assert!(played > 0);
}

/// The bag of a killed run has no complete file, and playback reports why.
#[test]
fn a_bag_that_was_cut_short_is_not_taken_for_an_empty_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let (bag, _) = recorded(folder.path());
    std::fs::rename(bag.join("bag_0.mcap"), bag.join("bag_0.mcap.ilon-partial")).expect("a bag");
    let motion = format!(
        "[playback]\nfile = {:?}\ndrives = \"twist\"\ntopic = \"/cmd_vel\"\n",
        bag.file_name().expect("a name")
    );
    let scenario = scenario(folder.path(), &motion).expect("a scenario");
    let error = Simulation::new(&scenario).err().expect("refused");
    assert!(error.to_string().contains("cut short"), "{error}");
}

/// The run of a log of twists in a folder.
fn played(log: &str, further: &str) -> Run {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.csv"), log).expect("a file");
    ran(
        folder.path(),
        &format!("[playback]\nfile = \"log.csv\"\ndrives = \"twist\"\n{further}"),
    )
}

/// Rows of 0.2 m/s ahead at times of some unit, 10 ms apart.
fn ahead(name: &str, time: impl Fn(u64) -> String) -> String {
    let rows: String = (0..=60)
        .map(|row| format!("{},0.2,0,0\n", time(row)))
        .collect();
    format!("{name},vx_m_s,vy_m_s,omega_rad_s\n{rows}")
}

#[test]
fn times_since_1970_drive_as_times_since_the_start() {
    const SINCE_S: u64 = 1_732_255_000;
    let from_zero = played(&ahead("t_s", |row| format!("{}", 0.01 * row as f64)), "");
    for log in [
        ahead("t_s", |row| format!("{SINCE_S}.{:02}", row)),
        ahead("t_ms", |row| format!("{}", SINCE_S * 1000 + 10 * row)),
        ahead("t_ns", |row| {
            format!("{}", (SINCE_S * 100 + row) * 10_000_000)
        }),
    ] {
        let since = played(&log, "");
        assert_eq!(
            since.summary.trace_hash,
            from_zero.summary.trace_hash,
            "{}",
            &log[..40]
        );
    }
}

#[test]
fn poses_that_come_late_begin_where_the_simulated_robot_is_by_then() {
    // The real robot follows the command, in its own frame: rotated by a right angle, 3 m away.
    let log = |from_row: u64| {
        let rows: String = (0..=60)
            .map(|row| {
                let measured = match row >= from_row {
                    true => format!("3,{},90", 0.002 * row as f64),
                    false => ",,".to_owned(),
                };
                format!("{},0.2,0,0,{measured}\n", 0.01 * row as f64)
            })
            .collect();
        format!(
            "t_s,vx_m_s,vy_m_s,omega_rad_s,measured_x_m,measured_y_m,measured_heading_deg\n{rows}"
        )
    };
    let (whole, late) = (played(&log(0), ""), played(&log(30), ""));
    let at = |run: &Run, row: usize| run.trace.records()[row];
    assert_eq!(at(&late, 29).measured, None);
    let first = at(&late, 30);
    let measured = first.measured.expect("a pose");
    assert!((measured.position_m() - first.truth.pose.position_m()).norm() < 1e-12);
    assert!(first.truth.pose.x_m > 0.04, "it had hardly moved");
    for run in [&whole, &late] {
        // From then on both move by 2 mm per row, ahead.
        let way =
            at(run, 50).measured.expect("a pose").x_m - at(run, 30).measured.expect("a pose").x_m;
        assert!((way - 0.04).abs() < 1e-9, "{way}");
    }
}

#[test]
fn angles_that_jump_at_half_a_turn_drive_as_angles_that_go_on() {
    let log = |angle: fn(f64) -> f64| {
        let names = ["front_left", "front_right", "rear_left", "rear_right"];
        let header: Vec<String> = names
            .iter()
            .map(|name| format!("{name}_angle_rad"))
            .collect();
        let rows: String = (0..=60)
            .map(|row| {
                let turned = angle(0.1 * f64::from(row));
                format!(
                    "{},{turned},{turned},{turned},{turned}\n",
                    0.01 * f64::from(row)
                )
            })
            .collect();
        format!("t_s,{}\n{rows}", header.join(","))
    };
    let way_m = |angle| {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("log.csv"), log(angle)).expect("a file");
        let motion = "[playback]\nfile = \"log.csv\"\ndrives = \"wheel_angles\"\n";
        ran(folder.path(), motion).summary.travelled_m
    };
    let (on, wrapped) = (way_m(|angle| angle), way_m(ilon_sim::robot::wrap_angle));
    assert!(on > 0.2 && (on - wrapped).abs() < 1e-6, "{on} {wrapped}");
}

#[test]
fn rows_and_keys_that_would_be_ignored_are_refused() {
    let said = |log: &str, further: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("log.csv"), log).expect("a file");
        refused(
            folder.path(),
            &format!("[playback]\nfile = \"log.csv\"\ndrives = \"twist\"\n{further}"),
        )
    };
    let header = "t_s,vx_m_s,vy_m_s,omega_rad_s\n";
    let partly = said(&format!("{header}0,0.1,0,0\n1,,0,0\n"), "");
    assert!(
        partly.contains("line 3: `vx_m_s` holds no number"),
        "{partly}"
    );
    let word = said(&format!("{header}0,0.1,0,0\n1,abc,,0\n"), "");
    assert!(word.contains("line 3"), "{word}");
    let time = said(&format!("{header}noon,0.1,0,0\n1,0.1,0,0\n"), "");
    assert!(
        time.contains("line 2: `t_s` is text, but must be a time"),
        "{time}"
    );
    let semicolons = said("t_s;vx_m_s;vy_m_s;omega_rad_s\n0;1;2;3\n", "");
    assert!(
        semicolons.contains("its columns are separated by ';'"),
        "{semicolons}"
    );
    let one_row = said(&format!("{header}0,0.1,0,0\n"), "");
    assert!(one_row.contains("has only one row"), "{one_row}");
    let names = said(
        &format!("{header}0,0.1,0,0\n1,0.1,0,0\n"),
        "names = { vz_m_s = \"foo\" }\n",
    );
    assert!(
        names.contains("`playback.names.vz_m_s` is not used"),
        "{names}"
    );
    // A row without any value is skipped, as in a log of a slower signal beside others.
    let rows = format!("{header}0,0.1,0,0\n0.5,,,\n1,0.1,0,0\n");
    assert!(played(&rows, "").summary.travelled_m > 0.0);
}

/// A log of 0.73 s from its first row to its last, a row each 0.01 s; `further` is appended to the
/// scenario.
fn of_a_log(drives: &str, columns: &str, row: &str, further: &str) -> Result<Run, Error> {
    let folder = tempfile::tempdir().expect("a folder");
    // Its clock started long before.
    let rows: Vec<String> = (0..74)
        .map(|index| format!("{:.2},{row}\n", 1000.0 + 0.01 * f64::from(index)))
        .collect();
    let text = format!("t_s,{columns}\n{}", rows.concat());
    std::fs::write(folder.path().join("log.csv"), text).expect("a log");
    let text = format!(
        "[robot]\nfile = \"{ROBOT}\"\n[playback]\nfile = \"log.csv\"\ndrives = \"{drives}\"\n{further}"
    );
    run(&Scenario::from_toml(&text, "test", folder.path())?)
}

#[test]
fn without_a_duration_a_run_ends_with_its_log() {
    let wheels =
        "front_left_rate_rad_s,front_right_rate_rad_s,rear_left_rate_rad_s,rear_right_rate_rad_s";
    let cases = [
        ("twist", "vx_m_s,vy_m_s,omega_rad_s", "0.1,0,0"),
        ("wheel_rates", wheels, "1,1,1,1"),
        ("path", "x_m,y_m,heading_deg", "0,0,0"),
    ];
    for (drives, columns, row) in cases {
        // A rate holds until the next, the last one for the interval of rows; for a path the last
        // point is the end. A run has whole control periods: 25 or 24 of 0.03 s are nearest.
        let holds_s = if drives == "path" { 0.0 } else { 0.01 };
        for (further, duration_s) in [
            ("", 0.73 + holds_s),
            ("from_s = 0.23\n", 0.5 + holds_s),
            (
                "[run]\ncontrol_dt_s = 0.03\n",
                if drives == "path" { 0.72 } else { 0.75 },
            ),
            ("[run]\nduration_s = 0.3\n", 0.3),
        ] {
            let run = of_a_log(drives, columns, row, further).expect("a run");
            let lasted_s = run.summary.duration_s;
            assert!(
                (lasted_s - duration_s).abs() < 1e-9,
                "{drives} {further}: {lasted_s}"
            );
            // The written scenario has the duration.
            assert!((run.scenario.run.duration_s - duration_s).abs() < 0.0151);
        }
    }
}

/// Rows 0.1 s apart, and one 29.9 s later: the last one lasts as long as a row usually does, 0.1 s,
/// not the mean interval of 10 s; the gap is remarked, and short ones are not.
#[test]
fn a_gap_in_a_log_is_remarked_and_does_not_make_its_last_row_longer() {
    let of = |times_s: &[f64]| {
        let folder = tempfile::tempdir().expect("a folder");
        let rows: String = times_s
            .iter()
            .map(|t_s| format!("{t_s},0.1,0,0\n"))
            .collect();
        std::fs::write(
            folder.path().join("log.csv"),
            format!("t_s,vx_m_s,vy_m_s,omega_rad_s\n{rows}"),
        )
        .expect("a log");
        let text = format!(
            "[robot]\nfile = \"{ROBOT}\"\n[playback]\nfile = \"log.csv\"\ndrives = \"twist\"\n"
        );
        let scenario = Scenario::from_toml(&text, "test", folder.path()).expect("a scenario");
        let robot = ilon_sim::load_robot(&scenario).expect("a robot");
        let resolved = ilon_sim::resolve(&scenario, &robot).expect("it stands");
        let said = resolved.warnings().join("\n");
        (resolved.scenario().run.duration_s, said)
    };
    let (lasts_s, said) = of(&[0.0, 0.1, 0.2, 30.1]);
    assert!((lasts_s - 30.2).abs() < 1e-9, "{lasts_s}");
    assert!(
        said.contains("has no rows from 0.20 to 30.10 s: the row before it holds until then"),
        "{said}"
    );
    let (lasts_s, said) = of(&[0.0, 0.1, 0.2, 0.5]);
    assert!((lasts_s - 0.6).abs() < 1e-9, "{lasts_s}");
    assert!(!said.contains("no rows"), "{said}");
}

#[test]
fn a_window_beyond_the_end_of_the_log_is_refused_as_one_beyond_a_duration() {
    let further = "[sensors.pose]\nlatency_s = 5\n";
    let refused = of_a_log("twist", "vx_m_s,vy_m_s,omega_rad_s", "0.1,0,0", further);
    let said = refused.expect_err("no pose ever arrives").to_string();
    assert!(said.contains("latency_s"), "{said}");
}

#[test]
fn of_files_that_are_no_logs_no_column_and_no_cell_is_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = |text: &str, names: &str| {
        std::fs::write(folder.path().join("log.csv"), text).expect("a file");
        let motion =
            format!("[playback]\nfile = \"log.csv\"\ndrives = \"twist\"\nnames = {{ {names} }}\n");
        let scenario = scenario(folder.path(), &motion).expect("a scenario");
        format!(
            "{:?}",
            run(&scenario)
                .map(|run| run.summary)
                .expect_err("it is no log")
        )
    };
    let names = "t_s = \"user\", vx_m_s = \"PASSWORD\", vy_m_s = \"name\", omega_rad_s = \"id\"";
    for text in [
        "user,PASSWORD=hunter2,name,id\nbob,hunter2,x,y\n",
        "user,PASSWORD,name,id\nhunter2,a,b,c\n",
        "user,PASSWORD,name,id\n1,hunter2,3,4\n",
    ] {
        let said = said(text, names);
        assert!(!said.contains("hunter2"), "{said}");
    }
    // For a log the most similar column is shown.
    let log = "t_s,vx_m_s,vy_m_s,omega_rad_ss\n0,1,2,3\n1,1,2,3\n";
    assert!(said(log, "").contains("`omega_rad_ss`"));
}
