//! Robots whose driven joints move their wheels: control and dead reckoning use the wheels' current
//! places.

use std::path::Path;

use ilon_sim::{Plant, Run, Scenario, Simulation, WheelCommand};

/// Outward displacement of the wheels by the slides, in metres.
const OUT_M: f64 = 0.08;
/// Distance of a wheel from the body's middle along x and along y, in metres, with the slides at
/// zero.
const ALONG_M: f64 = 0.15;
const ACROSS_M: f64 = 0.16;

/// The robot with an outward slide under each wheel.
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

/// With different keys for the slide under each wheel: front left, front right, rear left, rear
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

/// True heading, and headings by dead reckoning, after a time in seconds, in radians.
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

/// Wheels moved outward during a rotation turn the robot like those of a robot built with them
/// there, and dead reckoning uses their places: with the places of the start the robot would turn
/// slower by (l + w) / (l + w + 0.08) = 0.795, and not notice.
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
        // Other rollers are on the ground at the beginning and the end: a few thousandths, by their
        // ripple.
        assert!((moved / built - 1.0).abs() < 5e-3, "{moved} {built}");
    }
    let as_begun = (ALONG_M + ACROSS_M) / (ALONG_M + ACROSS_M + OUT_M);
    assert!((moved_rad[0] / built_rad[0] - as_begun).abs() > 0.15);
    // Over the whole drive, including the wheels' motion: contact kinematics is off by the slip.
    let [truth, _, contact] = turned_rad(&moved, 0.1, 3.9);
    assert!((contact - truth).abs() < 5e-3 * truth, "{contact} {truth}");
}

/// The covariance of the heading follows the wheels, too: for a robot with wheels moved outward as
/// for one built with them there. Each rad takes 1 / 0.795 times the travel of wheels further in,
/// and an error of that travel turns the robot by 0.795 times as much: the variance changes by
/// 0.795, the ratio of the levers.
#[test]
fn the_covariance_of_odometry_follows_the_wheels() {
    let turn = "[twist]\nomega_rad_s = 0.5\n";
    let [moved, built, begun] =
        [moving(), built_so(), "target_m = 0".to_owned()].map(|slides| run(&slides, turn));
    // Means over many rollers: at one instant the wheel loops have errors of some thousandths.
    let heading = |run: &Run| {
        let rows = run.trace.records().iter();
        let rows: Vec<_> = rows.filter(|row| (2.0..3.9).contains(&row.t_s)).collect();
        let mut means = [0.0; 2];
        for row in &rows {
            let reckoned = row.reckoned.expect("it is known");
            // A servo of 10 Hz deflects by some millimetres under the side force that remains from
            // the wheels' outward motion: the variance uses the real places.
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
        // Wheel loops follow within some thousandths.
        assert!((moved / built - 1.0).abs() < 5e-3, "{moved} {built}");
    }
    // The lever is removed from both.
    assert!((built[0] / begun[0] - 1.0).abs() < 5e-3);
}

/// One wheel moves outward under a standing robot: dead reckoning does not take its rolling for a
/// motion of the body.
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

/// A robot stands while its wheels move outward: rolling wheels carry it nowhere, and scrape less
/// than held ones.
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
    // Dead reckoning does not take their rolling for driving.
    assert!(
        last.odometry_ideal.position_m().norm() < 2e-3,
        "{:?}",
        last.odometry_ideal
    );
}

/// One wheel moves outward under a standing robot: a filter of odometry and rare poses does not
/// take its rolling for driving, which would cause an error of a fourth of the way, 20 mm.
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

/// Dead reckoning uses measured joints only: the deflection of a sprung slide during a sideways
/// start is in the cost of unmeasured joints, that of a driven one is not.
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

/// On a circle in closed loop the wheels move outward meanwhile: the robot stays on its path like
/// one built with them there.
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

/// An inspection shows the robot with its joints at the start of their servos: the wheels further
/// out, and a fourth of the weight on each.
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
