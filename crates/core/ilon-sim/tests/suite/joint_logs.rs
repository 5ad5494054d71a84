//! Driven joints that follow a log: CSV files and bags, beside wheels or alone, and refused logs.

use std::path::Path;

use ilon_formats::describe;
use ilon_messages::Message;
use ilon_messages::bag::{BagWriter, Qos};
use ilon_messages::builtin_interfaces::Duration;
use ilon_messages::geometry_msgs::Twist;
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::topics::BagSink;
use ilon_messages::trajectory_msgs::{JointTrajectory, JointTrajectoryPoint};
use ilon_sim::simulate::Simulation;
use ilon_sim::{Error, Plant, Run, Scenario, WheelCommand, run};
use ilon_trace::Sink;
use test_case::test_case;

const ROBOT: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../../assets/robots/mecanum4_arm.urdf"
);

/// A scenario in a folder, of a robot with a driven arm.
fn scenario(folder: &Path, joint: &str, motion: &str) -> Result<Scenario, Error> {
    let text = format!(
        "[robot]\nfile = \"{ROBOT}\"\n\
         wheels = {{ rollers = 9, roller_radius_m = 0.012, roller_mass_kg = 0.01, damping_n_m_s = 1e-6, gamma.x_deg = 45 }}\n\
         [robot.joints.arm]\nrole = \"driven\"\n{joint}\n{motion}"
    );
    Scenario::from_toml(&text, "joints", folder)
}

/// The run of a CSV file that drives the joints.
fn of_csv(csv: &str, joint: &str, motion: &str) -> Result<Run, Error> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.csv"), csv).expect("a log");
    run(&scenario(folder.path(), joint, motion)?)
}

const ALONE: &str = "[playback]\nfile = \"log.csv\"\ndrives = \"joints\"\n[twist]\nvx_m_s = 0\n";
/// From 0.2 rad within a second to 0.6 rad: at a constant rate, which the servo follows with the
/// delay of a critically damped one.
const ROWS: &str = "t_s,arm_position_rad\n5,0.2\n6,0.6\n";

/// Position of the arm at a time.
fn arm_at(run: &Run, t_s: f64) -> f64 {
    let records = run.trace.records();
    let near = records.iter().min_by(|a, b| {
        let off = |t: f64| (t - t_s).abs();
        off(a.t_s).total_cmp(&off(b.t_s))
    });
    near.expect("records").joints[0].position
}

/// The run begins at the log's beginning, whatever its clock, interpolates linearly between its
/// rows, and ends with it.
#[test_case(ROWS, ""; "by the joints name")]
#[test_case("t_ms,arm_position_deg\n0,11.459155902616464\n1000,34.37746770784939\n", ""; "in degrees and milliseconds")]
#[test_case("t_s,joint_arm_position_rad,wheel\n0,0.2,1\n0.5,,2\n1,0.6,3\n", ""; "as in a trace and with an empty cell")]
#[test_case("t_s,elbow\n0,0.2\n1,0.6\n", "names.arm = \"elbow\"\n"; "by another name")]
fn a_csv_file_drives_a_joint_beside_a_twist(csv: &str, names: &str) {
    let motion = ALONE.replace("[twist]", &format!("{names}[twist]"));
    let run = of_csv(csv, "", &motion).expect("a run");
    assert!((run.summary.duration_s - 1.0).abs() < 1e-9);
    assert!((arm_at(&run, 0.0) - 0.2).abs() < 1e-6);
    // A critically damped servo that knows its target's rate follows without a lag except for
    // friction and damping: some mrad, as with setpoints.
    assert!(
        (arm_at(&run, 0.5) - 0.4).abs() < 0.01,
        "{}",
        arm_at(&run, 0.5)
    );
}

/// For the arm and for the lift, a revolute and a prismatic joint: the same scenario of another
/// joint.
fn of_lift(csv: &str, motion: &str) -> Result<Run, Error> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.csv"), csv).expect("a log");
    let arm = scenario(folder.path(), "", motion)?.to_toml()?;
    let lift = arm.replace("[robot.joints.arm]", "[robot.joints.lift]");
    run(&Scenario::from_toml(&lift, "joints", folder.path())?)
}

/// 0.4 rad/s for half a second, and 0.2 rad/s back for the interval of rows; the arm is held
/// afterwards.
const RATES: &str = "t_s,arm_rate_rad_s\n3,0.4\n3.5,-0.2\n";

/// A log of rates moves the joint by their integral, each holding until the next and the last for
/// the interval of rows; then the servo holds the joint in place.
#[test_case(RATES, ""; "by the joints name")]
#[test_case("t_s,arm_rate_deg_s\n0,22.918311805232932\n0.5,-11.459155902616466\n", ""; "in degrees")]
#[test_case("t_s,joint_arm_rate_rad_s,joint_arm_position_rad\n0,0.4,\n0.2,,\n0.25,NaN,nan\n0.5,-0.2,\n", ""; "as in a trace with cells that say nothing")]
#[test_case("t_s,elbow\n0,0.4\n0.5,-0.2\n", "joints_by = \"rate\"\nnames.arm = \"elbow\"\n"; "by another name")]
#[test_case("t_s,arm_rate_rad_s,arm_position_rad,arm_torque_n_m\n0,0.4,0,9\n0.5,-0.2,2,9\n", "joints_by = \"rate\"\n"; "though positions stand beside them")]
fn rates_of_a_csv_file_move_a_joint_to_their_integral(csv: &str, keys: &str) {
    let motion = ALONE.replace("[twist]", &format!("{keys}[twist]"));
    let run = of_csv(csv, "", &format!("{motion}[run]\nduration_s = 1.5\n")).expect("a run");
    // Deflection by friction and damping: (0.1 + 0.05 x 0.4) N m over 599 N m/rad, 0.2 mrad to
    // either side.
    for (t_s, expected) in [(0.0, 0.0), (0.4, 0.16), (0.5, 0.2), (1.0, 0.1), (1.4, 0.1)] {
        let found = arm_at(&run, t_s);
        assert!(
            (found - expected).abs() < 1e-3,
            "{t_s} s: {found} {expected}"
        );
    }
}

/// A run ends when the last rate has lasted for the interval of rows, and begins at the log's joint
/// position.
#[test]
fn rates_begin_where_the_log_has_the_joint() {
    let csv = "t_s,arm_position_rad,arm_rate_rad_s\n0,0.3,0.4\n0.5,,-0.2\n";
    let motion = ALONE.replace("[twist]", "joints_by = \"rate\"\n[twist]");
    let run = of_csv(csv, "", &motion).expect("a run");
    assert!((run.summary.duration_s - 1.0).abs() < 1e-9);
    for (t_s, expected) in [(0.0, 0.3), (0.5, 0.5), (0.9, 0.42)] {
        assert!((arm_at(&run, t_s) - expected).abs() < 1e-3, "{t_s}");
    }
}

/// The lift has 4 kg, friction of 1 N and damping of 5 N s/m: x'' = (F - m g - f - c x') / m; after
/// the force ends, the servo holds it in place.
#[test]
fn forces_of_a_csv_file_lift_what_newton_says() {
    let (mass_kg, friction_n, damping_n_s_m, force_n) = (4.0, 1.0, 5.0, 45.0);
    let net_n: f64 = force_n - mass_kg * 9.81 - friction_n;
    let time_s = mass_kg / damping_n_s_m;
    let at_m = |t_s: f64| net_n / damping_n_s_m * (t_s - time_s * (1.0 - (-t_s / time_s).exp()));
    let motion = format!("{ALONE}[run]\nduration_s = 1.5\n");
    let run = of_lift("t_s,lift_force_n\n0,45\n0.25,45\n", &motion).expect("a run");
    for t_s in [0.25, 0.5] {
        let (found, expected) = (arm_at(&run, t_s), at_m(t_s));
        assert!(
            (found - expected).abs() < 5e-3 * expected,
            "{found} {expected}"
        );
    }
    // It stops from 0.45 m/s within about a period of its servo, 0.1 s.
    let held = arm_at(&run, 1.4);
    assert!((held - arm_at(&run, 1.0)).abs() < 1e-4, "{held}");
    assert!((held - at_m(0.5)).abs() < 0.03, "{held} {}", at_m(0.5));
}

/// Of position, rate and torque the first one in a row counts: a command by rate replaces one by
/// position, and vice versa.
#[test]
fn each_row_drives_by_the_first_that_it_says() {
    let csv = "t_s,arm_position_rad,arm_rate_rad_s\n0,0.1,\n1,0.3,5\n1.5,,0.4\n2,0.5,\n2.5,0.5,\n";
    let run = of_csv(csv, "", ALONE).expect("a run");
    assert!((run.summary.duration_s - 2.5).abs() < 1e-9);
    for (t_s, expected) in [(0.5, 0.2), (1.0, 0.3), (1.4, 0.3), (2.0, 0.5), (2.4, 0.5)] {
        let found = arm_at(&run, t_s);
        // As with positions alone: some mrad of lag when a target starts to move.
        assert!(
            (found - expected).abs() < 0.01,
            "{t_s} s: {found} {expected}"
        );
    }
}

/// A log that drives the wheels moves joints too, in the time of the wheels.
#[test]
fn a_log_of_wheels_takes_joints_along() {
    let wheels =
        "front_left_rate_rad_s,front_right_rate_rad_s,rear_left_rate_rad_s,rear_right_rate_rad_s";
    let csv = format!(
        "t_s,{wheels},arm_position_rad\n1,,,,,0.0\n2,3,3,3,3,0.2\n2.5,3,3,3,3,\n3,3,3,3,3,0.6\n"
    );
    let motion = "[playback]\nfile = \"log.csv\"\ndrives = \"wheel_rates\"\n";
    let run = of_csv(&csv, "", motion).expect("a run");
    assert!((arm_at(&run, 0.0) - 0.2).abs() < 1e-6);
    assert!((arm_at(&run, 0.5) - 0.4).abs() < 0.01);
    let goes = run.trace.records().last().expect("records").truth.pose.x_m;
    assert!(goes > 0.1, "{goes}");
    // A target in the scenario holds the joint, regardless of the log.
    let held = of_csv(&csv, "target_rad = 0.1", motion).expect("a run");
    assert!((arm_at(&held, 0.9) - 0.1).abs() < 0.01);
}

/// A reset begins at the log's beginning, and snapshots of both plants are compatible.
#[test]
fn a_reset_begins_where_the_log_begins() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.csv"), ROWS).expect("a log");
    let scenario = scenario(folder.path(), "", ALONE).expect("a scenario");
    let mut plant = Plant::of_scenario(&scenario).expect("it stands");
    let at = |plant: &Plant| plant.world().robot().joint_positions()[0];
    plant
        .advance(WheelCommand::Rates(&[0.0; 4]), 1.5)
        .expect("it goes");
    assert!((at(&plant) - 0.6).abs() < 2e-3, "{}", at(&plant));
    let pose = plant.resolved().start();
    plant.reset(0, pose).expect("it stands");
    assert!((at(&plant) - 0.2).abs() < 1e-6);
}

fn joint_state(names: &[&str], position: &[f64]) -> JointState {
    JointState {
        name: names.iter().map(ToString::to_string).collect(),
        position: position.to_vec(),
        ..JointState::default()
    }
}

/// The run of a bag of joint positions and twists, at times in seconds.
fn of_bag<M: Message>(joints: &[(f64, M)], motion: &str) -> Result<Run, Error> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bag = BagWriter::create(&folder.path().join("bag")).expect("a bag");
    bag.declare::<M>("/joint_commands", Qos::reliable(1))
        .expect("a topic");
    bag.declare::<Twist>("/cmd_vel", Qos::reliable(1))
        .expect("a topic");
    let ns = |t_s: f64| 9_000_000_000 + (1e9 * t_s).round() as u64;
    for t_s in [0.5, 1.0, 1.5] {
        bag.write("/cmd_vel", &Twist::default(), ns(t_s))
            .expect("a message");
    }
    for (t_s, message) in joints {
        bag.write("/joint_commands", message, ns(*t_s))
            .expect("a message");
    }
    bag.finish().expect("a bag");
    run(&scenario(folder.path(), "", motion)?)
}

/// A joint's state; NaN is unknown.
fn state_of_arm(position: f64, velocity: f64, effort: f64) -> JointState {
    let beside = |number: f64| match number.is_nan() {
        true => Vec::new(),
        false => vec![9.0, number],
    };
    JointState {
        name: vec!["front_left".to_owned(), "arm".to_owned()],
        position: vec![9.0, position],
        velocity: beside(velocity),
        effort: beside(effort),
        ..JointState::default()
    }
}

/// Messages without a position drive the joint by its velocity, and without a velocity by its
/// effort.
#[test]
fn a_bag_of_velocities_or_efforts_drives_joints() {
    let nan = f64::NAN;
    let rates = [
        (0.0, state_of_arm(nan, 0.4, 7.0)),
        (0.5, state_of_arm(nan, -0.2, 7.0)),
        (1.0, state_of_arm(nan, 0.0, 7.0)),
    ];
    let run = of_bag(&rates, BAG_ALONE).expect("a run");
    for (t_s, expected) in [(0.5, 0.2), (1.0, 0.1), (1.4, 0.1)] {
        assert!((arm_at(&run, t_s) - expected).abs() < 1e-3, "{t_s}");
    }
    // 0.4 N m against friction of 0.1 and damping of 0.05 on 0.1517 kg m^2, on a robot that its
    // floor holds: q = a / c (t - J / c (1 - exp(-c t / J))).
    let efforts = [0.0, 0.5].map(|t_s| (t_s, state_of_arm(nan, nan, 0.4)));
    let run = of_bag(&efforts, BAG_ALONE).expect("a run");
    let (time_s, rate): (f64, f64) = (0.1517 / 0.05, 0.3 / 0.05);
    let expected = rate * (0.9 - time_s * (1.0 - (-0.9 / time_s).exp()));
    assert!(
        (arm_at(&run, 0.9) - expected).abs() < 0.01 * expected,
        "{} {expected}",
        arm_at(&run, 0.9)
    );
}

/// A run whose arm swings by 1 rad within 0.6 s, at up to 3.125 rad/s and 16.04 rad/s^2, and the
/// largest distance of another's arm from it, in rad.
fn swing(folder: &Path) -> Simulation {
    let joint = "friction_n_m = 0\nsetpoints = [{ t_s = 0, position_rad = 0.2 }, { t_s = 0.6, position_rad = 1.2 }]\n";
    let motion = "[twist]\nvx_m_s = 0\n[run]\nduration_s = 0.6\n";
    Simulation::new(&scenario(folder, joint, motion).expect("a scenario")).expect("a simulation")
}

fn apart_rad(one: &Run, other: &Run) -> f64 {
    let pairs = one.trace.records().iter().zip(other.trace.records());
    let off = pairs.map(|(a, b)| (a.joints[0].position - b.joints[0].position).abs());
    off.fold(0.0, f64::max)
}

/// A servo lags by acceleration x inertia / stiffness, 16.04 x 0.1517 / 599 = 4.1 mrad, and by some
/// of damping; rates that hold from row to row lag by half a control period of 10 ms, 15.6 mrad
/// more at the fastest.
#[test_case("position", 0.005; "positions")]
#[test_case("rate", 0.021; "rates")]
fn the_bag_of_a_run_moves_its_joint_again(by: &str, within_rad: f64) {
    let folder = tempfile::tempdir().expect("a folder");
    let simulation = swing(folder.path());
    let robot = simulation.plant().robot();
    let described = describe(robot, &simulation.trace().header.urdf);
    let mut sink = BagSink::create(&folder.path().join("bag"), robot, described).expect("a bag");
    sink.begin(&simulation.trace().header).expect("a bag");
    let before = simulation.run();
    sink.take(&before.trace).expect("rows");
    sink.finish().expect("a whole bag");
    let motion = BAG_ALONE.replace(
        "[twist]",
        &format!("joint_topic = \"/joint_states\"\njoints_by = \"{by}\"\n[twist]"),
    );
    let again = scenario(folder.path(), "friction_n_m = 0", &motion).expect("a scenario");
    let off_rad = apart_rad(&before, &run(&again).expect("a run"));
    assert!(off_rad < within_rad, "{off_rad} rad");
}

/// A trace's torque includes the joint's damping, 0.05 N m s/rad, besides the servo's. A row's
/// torque is the mean over the period that it ends, so that the torque from a row on is in the next
/// one.
#[test]
fn the_torques_of_a_trace_move_its_joint_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let before = swing(folder.path()).run();
    let mut csv = "t_s,joint_arm_position_rad,joint_arm_force_n_m\n".to_owned();
    let records = before.trace.records();
    for (record, next) in records.iter().zip(&records[1..]) {
        let [arm, then] = [&record.joints[0], &next.joints[0]];
        let torque = then.force + 0.05 * 0.5 * (arm.rate + then.rate);
        csv += &format!("{},{},{torque}\n", record.t_s, arm.position);
    }
    let motion = ALONE.replace("[twist]", "joints_by = \"effort\"\n[twist]");
    let again = of_csv(&csv, "friction_n_m = 0", &motion).expect("a run");
    let off_rad = apart_rad(&before, &again);
    assert!(off_rad < 0.021, "{off_rad} rad");
}

const BAG: &str =
    "[playback]\nfile = \"bag\"\ndrives = \"twist\"\njoint_topic = \"/joint_commands\"\n";
const BAG_ALONE: &str = "[playback]\nfile = \"bag\"\ndrives = \"joints\"\n[twist]\nvx_m_s = 0\n";

/// A bag drives joints beside a twist, from the twist's first message on, or alone, from their own
/// first on.
#[test]
fn a_bag_drives_joints() {
    let said = [
        (0.0, joint_state(&["arm"], &[0.0])),
        (0.2, joint_state(&["front_left"], &[9.0])),
        (0.5, joint_state(&["front_left", "arm"], &[9.0, 0.2])),
        (1.5, joint_state(&["arm", "front_left"], &[0.6, 9.0])),
    ];
    let beside = of_bag(&said, BAG).expect("a run");
    let alone = of_bag(&said, BAG_ALONE).expect("a run");
    for (run, starts, later) in [(&beside, 0.2, 0.4), (&alone, 0.0, 0.2)] {
        assert!(
            (arm_at(run, 0.0) - starts).abs() < 1e-6,
            "{}",
            arm_at(run, 0.0)
        );
        assert!(
            (arm_at(run, 0.5) - later).abs() < 0.01,
            "{}",
            arm_at(run, 0.5)
        );
    }
    assert!((alone.summary.duration_s - 1.5).abs() < 1e-9);
}

/// Points of the arm: seconds after its beginning, and positions.
fn trajectory(points: &[(f64, f64)]) -> JointTrajectory {
    let point = |(after_s, position): &(f64, f64)| JointTrajectoryPoint {
        positions: vec![9.0, *position],
        time_from_start: Duration {
            sec: after_s.floor() as i32,
            nanosec: (1e9 * after_s.fract()).round() as u32,
        },
        ..JointTrajectoryPoint::default()
    };
    JointTrajectory {
        joint_names: vec!["gripper".to_owned(), "arm".to_owned()],
        points: points.iter().map(point).collect(),
        ..JointTrajectory::default()
    }
}

/// A trajectory starts at the time of its message, and another one replaces it from the position
/// reached.
#[test]
fn a_bag_of_trajectories_drives_joints() {
    let said = [
        (0.0, trajectory(&[(0.0, 0.0), (1.0, 0.8)])),
        (0.5, trajectory(&[(0.5, 0.2), (1.0, 0.2)])),
    ];
    let run = of_bag(&said, BAG_ALONE).expect("a run");
    for (t_s, at) in [(0.0, 0.0), (0.25, 0.2), (0.75, 0.3), (1.25, 0.2)] {
        assert!(
            (arm_at(&run, t_s) - at).abs() < 0.02,
            "{t_s} {}",
            arm_at(&run, t_s)
        );
    }
    assert!((run.summary.duration_s - 1.5).abs() < 1e-9);
}

/// A trajectory says positions alone: at rates that it does not say, nothing may be driven.
#[test]
fn a_trajectory_drives_by_no_rate() {
    let by_rate = BAG_ALONE.replace("[twist]", "joints_by = \"rate\"\n[twist]");
    let said = [(0.0, trajectory(&[(0.0, 0.0), (1.0, 0.8)]))];
    let Err(error) = of_bag(&said, &by_rate) else {
        panic!("not refused");
    };
    assert!(error.to_string().contains("it drives no joint"), "{error}");
}

#[test]
fn a_trajectory_whose_points_lack_a_joint_is_refused_in_words() {
    let mut lacks = trajectory(&[(0.0, 0.0), (1.0, 0.8)]);
    lacks.points[1].positions.pop();
    let Err(error) = of_bag(&[(0.0, lacks)], BAG_ALONE) else {
        panic!("not refused");
    };
    assert!(
        error.to_string().contains("a point of 1 positions"),
        "{error}"
    );
}

#[test_case(&[(0.0, joint_state(&["arm"], &[0.0, 1.0]))], BAG, "1 names and 2 positions"; "wrong length")]
#[test_case(&[(0.0, joint_state(&["arm"], &[f64::INFINITY]))], BAG, "not finite or too large"; "no number")]
#[test_case(&[(0.0, joint_state(&["arm"], &[f64::NAN]))], BAG, "it drives no joint"; "nothing said")]
#[test_case(&[(0.0, JointState { velocity: vec![1.0], ..joint_state(&["arm"], &[]) })], BAG, "has only one row"; "one rate")]
#[test_case(&[(0.0, JointState { effort: vec![1.0], ..joint_state(&["arm", "front_left"], &[]) })], BAG, "2 names and 1 efforts"; "efforts of wrong length")]
#[test_case(&[(0.0, joint_state(&["arm"], &[0.1]))], "[playback]\nfile = \"bag\"\ndrives = \"twist\"\njoint_topic = \"/joint_commands\"\njoints_by = \"effort\"\n", "it drives no joint"; "not what it says")]
#[test_case(&[(0.0, joint_state(&["arn"], &[0.1]))], BAG, "it drives no joint"; "an unknown joint")]
#[test_case(&[(0.0, joint_state(&["arm"], &[0.1])), (0.0, joint_state(&["arm"], &[0.2]))], BAG, "do not increase"; "one time twice")]
#[test_case(&[(0.0, joint_state(&["arm"], &[7.0]))], BAG, "beyond its limits"; "beyond the limits")]
#[test_case(&[], BAG, "no messages of `playback.joint_topic`"; "no message")]
#[test_case(&[(0.0, joint_state(&["arm"], &[0.1]))], "[playback]\nfile = \"bag\"\ndrives = \"twist\"\njoint_topic = \"/cmd_vel\"\n", "geometry_msgs/msg/Twist"; "another type")]
#[test_case(&[(0.0, joint_state(&["arm"], &[0.1]))], "[playback]\nfile = \"bag\"\ndrives = \"joints\"\n", "add a `[twist]`"; "wheels that nothing drives")]
#[test_case(&[(0.0, joint_state(&["arm"], &[0.1]))], "[playback]\nfile = \"bag\"\ndrives = \"joints\"\ntopic = \"/x\"\n[twist]\nvx_m_s = 0\n", "joint_topic"; "the wheels topic")]
fn what_no_joint_can_do_is_refused_in_words(
    joints: &[(f64, JointState)],
    motion: &str,
    words: &str,
) {
    let Err(error) = of_bag(joints, motion) else {
        panic!("not refused");
    };
    let error = format!("{error} {error:?}");
    assert!(error.contains(words), "{error}");
}

#[test_case("t_s,arm_position_rad\n0,0.1\n0,0.2\n", "do not increase"; "times that stand")]
#[test_case("t_s,arm_position_rad\n1,0.1\n0,0.2\n", "do not increase"; "times that go back")]
#[test_case("t_s,arm_position_rad\n0,wide\n1,0.2\n", "must be a number"; "no number")]
#[test_case("t_s,arm_position_rad\n0,inf\n1,0.2\n", "must be a number"; "no finite number")]
#[test_case("t_s,arm_position_rad\n0,nan\n1,\n", "it drives no joint"; "nothing said")]
#[test_case("t_s,arm_rate_rad_s\n0,1\n", "has only one row"; "one rate")]
#[test_case("t_s,arm_rate_m_s\n0,1\n1,1\n", "it drives no joint"; "the rate of a slide")]
#[test_case("t_s,arm_rate_rad_s,arm_position_rad\n0,1,2.7\n1,1,2.7\n", "beyond its limits"; "beyond the limits beside a rate")]
#[test_case("t_s,arn_position_rad\n0,0.1\n1,0.2\n", "it drives no joint"; "an unknown joint")]
#[test_case("t_s,arm_position_m\n0,0.1\n1,0.2\n", "arm_position_rad"; "the unit of a slide")]
#[test_case("t_s,arm_position_rad\n0,0.1\n1,2.7\n", "beyond its limits"; "beyond the limits")]
#[test_case("t_s,arm_position_rad\n", "it drives no joint"; "no rows")]
fn a_csv_file_that_no_joint_can_follow_is_refused_in_words(csv: &str, words: &str) {
    let Err(error) = of_csv(csv, "", ALONE) else {
        panic!("not refused");
    };
    let error = format!("{error} {error:?}");
    assert!(error.contains(words), "{error}");
}
