//! Robots whose driven joints move their wheels: control and dead reckoning go by where the joints
//! have them.

use std::path::Path;

use ilon_sim::{Plant, Run, Scenario, Simulation, WheelCommand};

/// How far the slides carry the wheels outward, in metres.
const OUT_M: f64 = 0.08;
/// From the body's middle to a wheel along x and along y, in metres, with the slides at zero.
const ALONG_M: f64 = 0.15;
const ACROSS_M: f64 = 0.16;

/// The robot with a slide under each wheel, which goes outward.
fn urdf() -> String {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/mecanum4_sprung.urdf");
    let text = std::fs::read_to_string(path).expect("a shipped robot");
    let mut joints = text.split(r#"<axis xyz="0 0 1"/>"#);
    let mut out = joints.next().unwrap_or_default().to_owned();
    for (joint, axis) in joints.zip([1, -1, 1, -1]) {
        out += &format!(r#"<axis xyz="0 {axis} 0"/>{joint}"#);
    }
    out.replace(
        r#"<limit lower="-0.02" upper="0.02" effort="0" velocity="0"/>"#,
        r#"<limit lower="0" upper="0.1" effort="500" velocity="1"/>"#,
    )
}

fn scenario(folder: &Path, slides: &str, motion: &str) -> Scenario {
    let driven = format!("role = \"driven\"\n{slides}");
    of_slides(folder, [&driven; 4], motion)
}

/// With something else said of the slide under each wheel: front left, front right, rear left, rear
/// right.
fn of_slides(folder: &Path, slides: [&str; 4], motion: &str) -> Scenario {
    std::fs::write(folder.join("extending.urdf"), urdf()).expect("a place for a file");
    let wheels = ["front_left", "front_right", "rear_left", "rear_right"];
    let joints = wheels.iter().zip(slides);
    let joints = joints.map(|(wheel, slide)| format!("[robot.joints.{wheel}_spring]\n{slide}\n"));
    let joints: String = joints.collect();
    let text = format!(
        r#"
[robot]
file = "extending.urdf"
wheels = {{ rollers = 9, roller_radius_m = 0.012, roller_mass_kg = 0.01, damping_n_m_s = 1e-6, gamma.x_deg = 45 }}

{}
{motion}
[run]
duration_s = 4
"#,
        joints
    );
    Scenario::from_toml(&text, "extending", folder).expect("a scenario")
}

fn run(slides: &str, motion: &str) -> Run {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), slides, motion);
    Simulation::new(&scenario).expect("it stands").run()
}

fn moving() -> String {
    format!("setpoints = [{{ t_s = 0.5, position_m = 0 }}, {{ t_s = 1.5, position_m = {OUT_M} }}]")
}

fn built_so() -> String {
    format!("target_m = {OUT_M}")
}

/// Headings by truth and by dead reckoning after so many seconds, in radians.
fn headings_rad(run: &Run, t_s: f64) -> [f64; 3] {
    let rows = run.trace.records();
    let row = rows
        .iter()
        .find(|row| row.t_s >= t_s - 1e-9)
        .expect("a row");
    [
        row.truth.pose.heading_rad,
        row.odometry_ideal.heading_rad,
        row.odometry_contact.heading_rad,
    ]
}

/// Wheels that went outward while the robot turned turn it on as those of a robot that was built
/// with them there, and dead reckoning counts by them: a robot that went by where its servos began
/// would turn slower by (l + w) / (l + w + 0.08) = 0.795, and believe that it turned as before.
#[test]
fn a_robot_turns_by_where_its_joints_have_its_wheels() {
    let turn = "[twist]\nomega_rad_s = 0.5\n";
    let [moved, built] = [moving(), built_so()].map(|slides| run(&slides, turn));
    let turned_rad = |run: &Run, from_s: f64, to_s: f64| {
        let (from, to) = (headings_rad(run, from_s), headings_rad(run, to_s));
        [0, 1, 2].map(|of| to[of] - from[of])
    };
    let [moved_rad, built_rad] = [&moved, &built].map(|run| turned_rad(run, 2.0, 3.9));
    println!("{moved_rad:?} {built_rad:?}");
    for (moved, built) in moved_rad.iter().zip(built_rad) {
        // Other rollers are on the ground when the time begins and ends: a few thousandths, by
        // their ripple.
        assert!((moved / built - 1.0).abs() < 5e-3, "{moved} {built}");
    }
    let as_begun = (ALONG_M + ACROSS_M) / (ALONG_M + ACROSS_M + OUT_M);
    assert!((moved_rad[0] / built_rad[0] - as_begun).abs() > 0.15);
    // Over the whole drive, with the wheels on their way: by the rollers that touch it is off by
    // what slips.
    let [truth, _, contact] = turned_rad(&moved, 0.1, 3.9);
    assert!((contact - truth).abs() < 5e-3 * truth, "{contact} {truth}");
}

/// How sure dead reckoning is of turning follows the wheels, too: of a robot whose wheels went
/// outward as of one that was built with them there, of which each rad takes 1 / 0.795 times the
/// way of wheels further in, and an error of that way turns the robot by 0.795 times as much: the
/// variance by 0.795, as the lever from the middle to the wheels has grown.
#[test]
fn the_covariance_of_odometry_follows_the_wheels() {
    let turn = "[twist]\nomega_rad_s = 0.5\n";
    let [moved, built, begun] =
        [moving(), built_so(), "target_m = 0".to_owned()].map(|slides| run(&slides, turn));
    // Means over many rollers: at one instant the loops of the wheels are off their rates by some
    // thousandths.
    let heading = |run: &Run| {
        let rows = run.trace.records().iter();
        let rows: Vec<_> = rows.filter(|row| (2.0..3.9).contains(&row.t_s)).collect();
        let mut means = [0.0; 2];
        for row in &rows {
            let reckoned = row.reckoned.expect("it is known");
            // A servo of 10 Hz gives way by some millimetres to what wheels that went outward keep
            // of the grip's side force: a variance counts by where they are.
            let out_m = row.joints[..4]
                .iter()
                .map(|slide| slide.position)
                .sum::<f64>()
                / 4.0;
            let lever = (ALONG_M + ACROSS_M + out_m) / (ALONG_M + ACROSS_M + OUT_M);
            means[0] += lever * reckoned.twist_covariance[2][2] / rows.len() as f64;
            means[1] += reckoned.twist.omega_rad_s / rows.len() as f64;
        }
        means
    };
    let [moved, built, begun] = [&moved, &built, &begun].map(heading);
    println!("{moved:?} {built:?} {begun:?}");
    for (moved, built) in moved.iter().zip(built) {
        // Loops of wheels follow within some thousandths.
        assert!((moved / built - 1.0).abs() < 5e-3, "{moved} {built}");
    }
    // The lever is taken out of both.
    assert!((built[0] / begun[0] - 1.0).abs() < 5e-3);
}

/// One wheel goes outward under a robot that stands: dead reckoning does not take its rolling along
/// for a motion of the body.
#[test]
fn the_twist_of_odometry_leaves_out_what_carries_the_wheels() {
    let folder = tempfile::tempdir().expect("a folder");
    let driven = format!("role = \"driven\"\n{}", moving());
    let stands = "role = \"held\"";
    let scenario = of_slides(
        folder.path(),
        [&driven, stands, stands, stands],
        "[twist]\nvx_m_s = 0\n",
    );
    let run = Simulation::new(&scenario).expect("it stands").run();
    let worst = |twist: &dyn Fn(&ilon_trace::Record) -> ilon_robot::Twist| {
        let rows = run.trace.records().iter();
        rows.map(|row| twist(row).linear_m_s().norm())
            .fold(0.0, f64::max)
    };
    let reckoned = worst(&|row| row.reckoned.expect("it is known").twist);
    let by_rates = worst(&|row| row.twist_ideal);
    println!("{reckoned} {by_rates}");
    assert!(by_rates > 0.03, "{by_rates}");
    assert!(reckoned < 0.1 * by_rates, "{reckoned} {by_rates}");
}

/// A robot that stands while its wheels go outward: rolling along they carry it nowhere, and scrape
/// less than wheels that are held.
#[test]
fn wheels_roll_along_with_what_carries_them() {
    let rolled = run(&moving(), "[twist]\nvx_m_s = 0\n");
    let last = rolled.trace.records().last().expect("a row");
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), &moving(), "[twist]\nvx_m_s = 0\n");
    let mut held = Plant::of_scenario(&scenario).expect("it stands");
    held.advance(WheelCommand::Rates(&[0.0; 4]), 4.0)
        .expect("it goes");
    let held_j = held.world().slip_energy_j();
    println!("{:?} {} {held_j}", last.truth.pose, last.slip_energy_j);
    assert!(last.truth.pose.position_m().norm() < 1e-3);
    assert!(last.truth.pose.heading_rad.abs() < 1e-3);
    assert!(
        last.slip_energy_j < 0.1 * held_j,
        "{} {held_j}",
        last.slip_energy_j
    );
    // Dead reckoning does not take rolling along for driving.
    assert!(
        last.odometry_ideal.position_m().norm() < 2e-3,
        "{:?}",
        last.odometry_ideal
    );
}

/// One wheel goes outward under a robot that stands: a filter of odometry and rare poses does not
/// take its rolling along for driving, which would put it off by a fourth of the way, 20 mm.
#[test]
fn a_filter_does_not_take_rolling_along_for_driving() {
    let folder = tempfile::tempdir().expect("a folder");
    let driven = format!("role = \"driven\"\n{}", moving());
    let stands = "role = \"held\"";
    let standing = "[twist]\nvx_m_s = 0\n[sensors.pose]\nrate_hz = 0.01\n[sensors.fusion]\n";
    let scenario = of_slides(folder.path(), [&driven, stands, stands, stands], standing);
    let run = Simulation::new(&scenario).expect("it stands").run();
    let rolled_rad = run.trace.wheel(0).last().expect("a row").angle_rad;
    assert!(rolled_rad.abs() > 0.5, "{rolled_rad}");
    let off_m = run.summary.seen_position_error_rms_m.expect("it is judged");
    assert!(off_m < 2e-3, "{off_m}");
}

/// Dead reckoning goes by joints that are measured, and by no others: what a sprung slide gives way
/// by while the robot sets out sideways is in the cost of joints that nothing measures, and what a
/// driven one does is not.
#[test]
fn dead_reckoning_goes_by_the_joints_that_are_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let driven = format!("role = \"driven\"\n{}", moving());
    let sideways = "[twist]\nvy_m_s = 0.3\n";
    let cost_m = |last: &str| {
        let slides = [&driven, "role = \"held\"", "role = \"held\"", last];
        let scenario = of_slides(folder.path(), slides, sideways);
        let run = Simulation::new(&scenario).expect("it stands").run();
        run.summary.odometry_joints_m.expect("it has joints")
    };
    assert!(cost_m("role = \"held\"") < 1e-12);
    let sprung = "stiffness_n_m = 200\nrest_m = 0.05\ndamping_n_s_m = 20";
    assert!(cost_m(sprung) > 1e-4, "{}", cost_m(sprung));
}

/// On a circle in closed loop the wheels go outward meanwhile: the robot stays on its way as one
/// that was built so.
#[test]
fn a_reference_is_followed_by_where_the_wheels_are() {
    let circle = "[reference.circle]\nradius_m = 0.5\nspeed_m_s = 0.3\nheading = { turning = { rate_deg_s = 40 } }\n[guidance]\n";
    let errors = [moving(), built_so()].map(|slides| {
        let run = run(&slides, circle);
        let rows = run.trace.records().iter().filter(|row| row.t_s > 2.0);
        let off_m = rows.filter_map(|row| {
            let desired = row.desired?.pose.position_m();
            Some((row.truth.pose.position_m() - desired).norm())
        });
        off_m.fold(0.0, f64::max)
    });
    println!("{errors:?}");
    let [moved_m, built_m] = errors;
    assert!(moved_m < 1.2 * built_m + 1e-3, "{moved_m} {built_m}");
}

/// An inspection shows the robot with its joints where its servos start: the wheels further out,
/// and each a fourth of the weight.
#[test]
fn an_inspection_is_of_where_the_servos_start() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), &built_so(), "[twist]\nvx_m_s = 0\n");
    let loaded = ilon_sim::simulate::load(&scenario).expect("a robot");
    let seen = ilon_sim::inspect::Inspection::of_standing(&loaded, &scenario).expect("inspected");
    for wheel in &seen.wheels {
        assert!((wheel.position_m[1].abs() - ACROSS_M - OUT_M).abs() < 1e-12);
        assert!((wheel.load_n - 0.25 * seen.mass_kg * 9.81).abs() < 1e-6);
    }
    assert_eq!(seen.joints.len(), 4);
    for joint in &seen.joints {
        assert_eq!(
            (joint.role, joint.moves, joint.position),
            ("driven", "slides", OUT_M)
        );
        assert_eq!(joint.limits, [Some(0.0), Some(0.1)]);
        assert_eq!(joint.moves_wheels.len(), 1);
    }
}
