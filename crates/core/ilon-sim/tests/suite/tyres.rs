//! Robots on tyres, from their files to what they do.

use std::path::Path;

use ilon_formats::LoadRobot;
use ilon_sim::robot::Pose;
use ilon_sim::{Plant, Scenario, Simulation, WheelCommand, load_robot, resolve};
use test_case::test_case;

use crate::support::message;

fn scenario(robot: &str, lines: &str) -> Scenario {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!("robot.file = \"{robot}.urdf\"\n{lines}\n");
    Scenario::from_toml(&text, "tyres", folder).expect("a scenario")
}

/// Where a run ends.
fn end(robot: &str, lines: &str) -> Pose {
    let mut simulation = Simulation::new(&scenario(robot, lines)).expect("it drives");
    while !simulation.is_done() {
        simulation.step();
    }
    simulation.world().robot().state().pose
}

/// Refused are motions along axles that nothing steers; a turn about an axle behind the origin is
/// none.
#[test_case("skid4", "twist.vy_m_s = 0.2", Some("drags tyres sideways"))]
#[test_case(
    "differential",
    "reference.circle = { radius_m = 1, speed_m_s = 0.2 }",
    None
)]
#[test_case(
    "tricycle",
    "twist = { vx_m_s = 0.2, vy_m_s = 0.2 }",
    Some("`left`, `right` are not steered")
)]
#[test_case("tricycle", "twist = { vx_m_s = 0.2, omega_rad_s = 0.3 }", None)]
#[test_case("swerve4", "twist.vy_m_s = 0.2", None)]
#[test_case(
    "differential",
    "wheel_loop.law = \"passive\"\nreference.circle = { radius_m = 1, speed_m_s = 0.2 }",
    Some("passive law")
)]
#[test_case(
    "differential",
    "reference.hold_pose = { x_m = 1, y_m = 1, heading_deg = 90 }",
    Some("1.000 m to the side of the robot at its start and 90.0 deg off its heading")
)]
#[test_case(
    "differential",
    "reference.hold_pose = { x_m = 1, y_m = 0, heading_deg = 0 }",
    None
)]
fn what_tyres_exclude_is_refused(robot: &str, motion: &str, refused: Option<&str>) {
    let scenario = scenario(robot, &format!("{motion}\nrun.duration_s = 1"));
    let robot = load_robot(&scenario).expect("a shipped robot");
    let resolved = resolve(&scenario, &robot);
    match refused {
        Some(words) => {
            let (said, help) = message(resolved.map(|_| ()));
            assert!(said.contains(words) && !help.is_empty(), "{said}");
        }
        None => assert!(resolved.is_ok(), "{:?}", resolved.err()),
    }
}

/// From rest with all modules ahead none of the wheels would turn for a motion to the left: the
/// modules turn, and then it drives.
#[test]
fn a_swerve_robot_leaves_straight_to_the_side() {
    let left = end(
        "swerve4",
        "twist = { vy_m_s = 0.3, rest_s = 0, ramp_s = 0 }\nrun.duration_s = 2",
    );
    // A tenth of a second goes by while the modules turn.
    assert!(left.y_m > 0.5 && left.x_m.abs() < 0.02, "{left:?}");
}

/// A robot with joints starts in equilibrium: its treads, which bear it, hold their energy from the
/// start, and nothing is lost or gained while it stands.
#[test_case("swerve4", "")]
#[test_case("tricycle", "rollers.tread.stiffness_n_m = 2e4")]
#[test_case("differential", "world.floor.slope_deg = 8")]
#[test_case("mecanum4_rocker", "rollers.tread.stiffness_n_m = 2e4")]
fn a_robot_that_stands_loses_nothing(robot: &str, line: &str) {
    let lines = format!("{line}\ntwist = {{}}\nrun.duration_s = 0.5");
    let energy = ilon_sim::run(&scenario(robot, &lines))
        .expect("it stands")
        .summary
        .energy;
    let impact_j = energy.impact_j.expect("it is counted");
    // The treads hold 0.01 to 0.2 J. With friction, without which equilibrium is looked for, a
    // robot on a slope settles once more: it may lose a thousandth of that, and gain nothing.
    assert!((-1e-6..2e-5).contains(&impact_j), "{impact_j} J");
}

/// Turning about the middle of its rear axle a tricycle's wheel would stand at 90 degrees, beyond
/// its 1.3 rad; on an arc of 1 m it does not.
#[test]
fn a_module_that_cannot_turn_so_far_is_remarked() {
    let remarked = |vx_m_s: f64| {
        let lines =
            format!("twist = {{ vx_m_s = {vx_m_s}, omega_rad_s = 0.3 }}\nrun.duration_s = 1");
        let scenario = scenario("tricycle", &lines);
        let robot = load_robot(&scenario).expect("a shipped robot");
        let warnings = resolve(&scenario, &robot)
            .expect("it drives")
            .warnings()
            .to_vec();
        warnings
            .iter()
            .any(|words| words.contains("`steer` cannot turn to where"))
    };
    assert!(remarked(0.0) && !remarked(0.3));
}

/// A heading that stays on a circle of 0.5 m at 0.5 m/s turns each module on the robot by 1 rad/s.
#[test_case(0.99, true)]
#[test_case(1.01, false)]
fn modules_that_a_path_turns_faster_than_they_can_are_remarked(
    limit_rad_s: f64,
    is_remarked: bool,
) {
    let lines = format!(
        "reference.circle = {{ radius_m = 0.5, speed_m_s = 0.5 }}\nrun.duration_s = 5\n\
         robot.joints.rear_left_steer = {{ role = \"driven\", rate_limit_rad_s = {limit_rad_s} }}"
    );
    let scenario = scenario("swerve4", &lines);
    let robot = load_robot(&scenario).expect("a shipped robot");
    let resolved = resolve(&scenario, &robot).expect("it drives");
    let words = format!(
        "up to 1.000 rad/s of the module `rear_left_steer`, whose limit is {limit_rad_s:.3} rad/s, and more than that for 100 %"
    );
    let mut warnings = resolved.warnings().iter();
    assert_eq!(warnings.any(|said| said.contains(&words)), is_remarked);
    let mut warnings = resolved.warnings().iter();
    assert_eq!(
        warnings.any(|said| said.contains("of the module")),
        is_remarked
    );
}

/// Four wheels, one with toe: a twist ahead is driven, within the toe, a turn on the spot stays
/// there, and both are remarked.
#[test_case(90.5, "vx_m_s = 0.3", [0.6, 0.0, 0.0])]
#[test_case(93.0, "vx_m_s = 0.3", [0.6, 0.0, 0.0])]
#[test_case(93.0, "omega_rad_s = 0.8", [0.0, 0.0, 1.0])]
fn a_wheel_with_toe_leaves_a_robot_that_drives_and_turns(
    axis_deg: f64,
    twist: &str,
    ends: [f64; 3],
) {
    let wheel = |x_m: f64, y_m: f64, axis_deg: f64| {
        format!(
            "[[wheels]]\nname = \"w{x_m}{y_m}\"\nposition_m = [{x_m}, {y_m}]\naxis_deg = {axis_deg}\n"
        )
    };
    let robot = format!(
        "name = \"toe\"\n[chassis]\nshape.box.size_m = [0.5, 0.3, 0.1]\nmass_kg = 20\ncenter_m = [0, 0, 0.1]\n[tyres]\nradius_m = 0.06\nwidth_m = 0.03\nmass_kg = 0.6\n\
         motor_effort_n_m = 6\nmotor_velocity_rad_s = 30\n{}{}{}{}",
        wheel(0.2, 0.15, axis_deg),
        wheel(0.2, -0.15, 90.0),
        wheel(-0.2, 0.15, 90.0),
        wheel(-0.2, -0.15, 90.0)
    );
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("toe.toml"), robot).expect("written");
    let text = format!(
        "robot.file = \"toe.toml\"\ntwist = {{ {twist}, rest_s = 0, ramp_s = 0 }}\nrun.duration_s = 2"
    );
    let scenario = Scenario::from_toml(&text, "toe", folder.path()).expect("a scenario");
    let robot = load_robot(&scenario).expect("four wheels");
    let resolved = resolve(&scenario, &robot).expect("it drives");
    let warnings = resolved.warnings();
    assert!(
        warnings.iter().any(|said| said.contains("(toe)")),
        "{warnings:?}"
    );
    let run = Simulation::new(&scenario).expect("it drives").run();
    let summary = &run.summary;
    let [x_m, y_m, turned_rad] = ends;
    let off = [
        summary.end_x_m.expect("an end") - x_m,
        summary.end_y_m.expect("an end") - y_m,
    ];
    // Aside by the toe at most; turned by what a skid robot loses, half or less.
    let aside_m = 0.6 * (axis_deg - 90.0).to_radians().sin();
    assert!(
        off.iter().all(|off| off.abs() < aside_m.max(0.03)),
        "{off:?}"
    );
    let end_rad = summary.end_heading_rad.expect("an end");
    assert!(
        (turned_rad * 0.5 - 0.1..turned_rad * 1.6 + 0.1).contains(&end_rad),
        "{end_rad}"
    );
}

/// A heading that stays while the path turns is none for a robot on a fixed axle; a swerve robot
/// has it.
#[test_case("differential", "", true)]
#[test_case("differential", "heading = \"along_path\"", false)]
#[test_case("differential", "heading = { from_path_deg = 180 }", false)]
#[test_case("swerve4", "", false)]
fn a_heading_beside_the_path_is_remarked(robot: &str, heading: &str, is_remarked: bool) {
    let lines =
        format!("run.duration_s = 5\n[reference.circle]\nradius_m = 1\nspeed_m_s = 0.3\n{heading}");
    let scenario = scenario(robot, &lines);
    let robot = load_robot(&scenario).expect("a shipped robot");
    let resolved = resolve(&scenario, &robot).expect("it drives");
    let mut warnings = resolved.warnings().iter();
    assert_eq!(
        warnings.any(|words| words.contains("beside the direction")),
        is_remarked
    );
}

/// Each wheel once, and no key of rollers.
#[test_case(
    "robot.tyres = { joints = [\"front_left\", \"front_left\", \"rear_left\"] }",
    "twice"
)]
#[test_case("rollers.bearings = \"bushings\"", "has a tyre")]
#[test_case("rollers.crown = 0.8", "has a tyre")]
fn what_makes_no_sense_of_tyres_is_refused(line: &str, words: &str) {
    let scenario = scenario(
        "skid4",
        &format!("{line}\ntwist = {{}}\nrun.duration_s = 1"),
    );
    let refused = load_robot(&scenario).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains(words), "{refused}");
}

/// Each of these gave the same bits as without it.
#[test_case("heading_gain_per_s = 5")]
#[test_case("reference_point.at = { x_m = 0.1, y_m = 0.3 }")]
#[test_case("position_gain_matrix_per_s = [[9, 0], [0, 9]]")]
#[test_case("tasks = [\"heading_feedback\"]")]
fn keys_that_a_path_on_tyres_does_not_look_at_are_refused(line: &str) {
    let resolved = |robot: &str| {
        let circle = "reference.circle = { radius_m = 1, speed_m_s = 0.3 }\nrun.duration_s = 1";
        let scenario = scenario(robot, &format!("{circle}\n[guidance]\n{line}"));
        let robot = load_robot(&scenario).expect("a shipped robot");
        resolve(&scenario, &robot).map(|_| ())
    };
    assert!(resolved("swerve4").is_ok());
    let (said, help) = message(resolved("differential"));
    let key = format!("`guidance.{}`", line.split([' ', '.']).next().unwrap());
    assert!(
        said.contains(&key) && help.contains("`guidance.position_gain_per_s`"),
        "{said}"
    );
}

/// Backing is plain rolling: from 5 degrees off its heading a robot backs 1.5 m onto the end of its
/// path. It stands 0.2 m wide, by which what is left of 5 degrees falls by e^-7 on the way.
#[test_case("{ from_path_deg = 180 }")]
#[test_case("{ constant_deg = 0 }")]
fn a_robot_that_faces_against_its_path_backs_along_it(heading: &str) {
    let line = "reference.line = { to_x_m = -1.5, to_y_m = 0, speed_m_s = 0.3";
    let lines =
        format!("{line}, heading = {heading} }}\nrobot.heading_deg = 5\nrun.duration_s = 9");
    let end = end("differential", &lines);
    // What is missing ahead falls by e a second, for four.
    assert!(
        (end.x_m + 1.5).abs() < 5e-3 && end.y_m.abs() < 2e-3,
        "{end:?}"
    );
    assert!(end.heading_rad.abs() < 5e-3, "{end:?}");
}

/// A swerve robot and its mirror image, driven in mirror image, end in mirror image. Wheels are
/// solved for in another order.
#[test]
fn a_mirrored_drive_ends_in_the_mirror() {
    let lines = |sign: f64| {
        format!(
            "twist = {{ vx_m_s = 0.2, vy_m_s = {}, omega_rad_s = {} }}\nrun.duration_s = 2",
            sign * 0.25,
            sign * 0.6
        )
    };
    let [one, other] = [1.0, -1.0].map(|sign| {
        let end = end("swerve4", &lines(sign));
        [end.x_m, sign * end.y_m, sign * end.heading_rad]
    });
    for (one, other) in one.iter().zip(other) {
        assert!((one - other).abs() < 1e-7, "{one} {other}");
    }
}

/// A module is turned on the spot by more than (2/3) mu N a, and held by less: three places at 0
/// and +-a carry a third of N each. By default a = 3 w / 8, which takes mu N w / 4, the moment of a
/// line of the width w; without shoulders a = w / 2, which takes that of a disc across the tyre,
/// (2/3) mu N r with r = w / 2. Its treads bend before they slide. It is turned by a torque: a
/// servo would give as well. 1 % turns it by more than 0.2 rad in 0.7 s.
#[test_case(None, 0.99, false)]
#[test_case(None, 1.01, true)]
#[test_case(Some(1e-4), 0.99, false)]
#[test_case(Some(1e-4), 1.01, true)]
fn a_tyre_turns_on_the_spot_from_its_scrub_on(shoulder_m: Option<f64>, share: f64, turns: bool) {
    let (friction, width_m) = (0.6, 0.03);
    let tyres = shoulder_m.map_or_else(String::new, |shoulder_m| {
        format!("robot.tyres.shoulder_radius_m = {shoulder_m}\n")
    });
    let at = |torque_n_m: f64| {
        format!(
            "{tyres}world.floor.friction = {friction}\ntwist = {{}}\nrun.duration_s = 1\n\
             [robot.joints.front_left_steer]\nrole = \"driven\"\n\
             setpoints = [{{ t_s = 0, torque_n_m = 0 }}, {{ t_s = 0.8, torque_n_m = {torque_n_m} }}]"
        )
    };
    let load_n = load_robot(&scenario("swerve4", &at(0.0)))
        .expect("shipped")
        .mass_kg()
        * 9.81
        / 4.0;
    let arm_m = 0.5 * width_m - shoulder_m.unwrap_or(width_m / 8.0);
    let scrub_n_m = 2.0 / 3.0 * friction * load_n * arm_m;
    let scenario = scenario("swerve4", &at(share * scrub_n_m));
    let mut plant = Plant::of_scenario(&scenario).expect("it stands");
    plant
        .advance(WheelCommand::Rates(&[0.0; 4]), 1.5)
        .expect("it runs");
    let turned_rad = plant.world().robot().joint_positions()[0];
    assert_eq!(turned_rad > 0.2, turns, "{turned_rad} rad");
    assert!(turns || turned_rad < 0.05, "{turned_rad} rad");
}

/// A chassis of 5 kg, with its centre of mass 0.1 m behind the axle, and a ball 0.2 m behind it:
/// the ball carries half of the chassis. It has no friction, so a turn on the spot neither drags
/// it nor loses anything but the tyres' scrub.
#[test]
fn a_fixed_ball_carries_its_share_and_drags_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let wheel = |side: &str, y_m: f64| {
        format!(
            r#"<link name="{side}"><inertial><mass value="0.4"/><inertia ixx="3e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="3e-4"/></inertial>
            <collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
            <joint name="{side}_wheel" type="continuous"><parent link="base"/><child link="{side}"/>
            <origin xyz="0.1 {y_m} 0.05"/><axis xyz="0 1 0"/><limit effort="2" velocity="20"/></joint>"#
        )
    };
    let urdf = format!(
        r#"<robot name="ball"><link name="base"><inertial><origin xyz="0 0 0.1"/><mass value="5"/>
        <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.08"/></inertial>
        <collision><origin xyz="-0.1 0 0.02"/><geometry><sphere radius="0.02"/></geometry></collision></link>{}{}</robot>"#,
        wheel("left", 0.15),
        wheel("right", -0.15)
    );
    std::fs::write(folder.path().join("ball.urdf"), urdf).expect("a file");
    let text = "robot.file = \"ball.urdf\"\nworld.floor.friction = 0.8\ntwist = { omega_rad_s = 1.0 }\n\
        run.duration_s = 4\n";
    let scenario = Scenario::from_toml(text, "ball", folder.path()).expect("a scenario");
    let found = Simulation::new(&scenario).expect("it drives").run();
    let summary = &found.summary;
    let share = summary.chassis_load_share.expect("loads");
    // Turning about the axle throws the centre of mass, 0.1 m up, back onto the ball: m omega^2 r
    // h / 0.2 m more, and less of it at rest and while the turn begins.
    let thrown = 5.0 * 0.1 * 0.1 / 0.2 / (5.8 * 9.81);
    let more = share - 2.5 / 5.8;
    assert!(0.5 * thrown < more && more < thrown, "{share} {thrown}");
    let ratio = summary.twist_ratio_ideal.omega.expect("it turned");
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    // Scrub alone: two tyres of moment mu N w / 4 turn by the robot's angle.
    let turned_rad = summary.turned_rad;
    let load_n = (5.8 - 2.5) * 9.81;
    let scrub_j = 0.8 * load_n * 0.02 / 4.0 * turned_rad;
    let slip_j = summary.slip_energy_j.expect("a loss");
    assert!((slip_j / scrub_j - 1.0).abs() < 0.05, "{slip_j} {scrub_j}");
}

/// Of a wheel that rolls along neither motor nor size is a cause, and the size of the only driven
/// wheel is that of all: no two suspects are the same.
#[test]
fn only_driven_wheels_have_motors_and_sizes_of_their_own() {
    let robot =
        load_robot(&scenario("tricycle", "twist = {}\nrun.duration_s = 1")).expect("a robot");
    let files = ilon_files::FileAccess::anywhere();
    let lineup = ilon_sim::causes::Lineup::of(&robot, &[], &files, [None; 5]).expect("it drives");
    let words: Vec<String> = lineup
        .at_usual_amounts()
        .into_iter()
        .map(|of| of.words)
        .collect();
    let any = |part: &str| words.iter().any(|words| words.contains(part));
    assert!(
        any("all wheels 1 % smaller") && any("the motor of drive"),
        "{words:?}"
    );
    assert!(!any("than the others"), "{words:?}");
    assert!(
        !any("the motor of left") && !any("the motor of right"),
        "{words:?}"
    );
    assert!(any("dust under left"), "{words:?}");
}

/// Omni wheels in front of driven tyres: nothing contradicts, so the robot goes as fast as its
/// wheels turn, and turns about the tyres' axle. Rollers on rigid contacts as soft as tyres would
/// roll on a radius smaller by what they sink in, 5e-3, and the robot half of that slower. Soft
/// rollers lose a tenth of it where one follows the other, and turning more by scrub.
#[test]
fn omni_wheels_beside_tyres_roll_on_their_own_radius() {
    let wheels = "[robot]\nfile = \"skid4.urdf\"\n[robot.wheels]\nrollers = 12\ngamma.all_deg = 0\n\
         joints = [\"front_left\", \"front_right\"]\n[robot.tyres]\n\
         joints = [\"rear_left\", \"rear_right\"]\n";
    for (twist, near) in [
        ("vx_m_s = 0.3", 5e-4),
        ("vx_m_s = 0.3\nomega_rad_s = 0.5", 2e-3),
    ] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
        let text = format!("{wheels}[twist]\n{twist}\n[run]\nduration_s = 3\n");
        let scenario = Scenario::from_toml(&text, "mixed", folder).expect("a scenario");
        let summary = Simulation::new(&scenario).expect("it drives").run().summary;
        let ratios = &summary.twist_ratio_ideal;
        for ratio in [ratios.vx, ratios.omega].into_iter().flatten() {
            assert!((ratio - 1.0).abs() < near, "{twist}: {ratio}");
        }
    }
}

/// The sharpest turn of the tricycle is about a point on the axle of its rear wheels, where the
/// steered wheel, 0.45 m ahead of it and turned by 74.4845 deg, rolls about it too: that wheel is
/// the furthest away, and limits the turn by its 0.06 m at 30 rad/s.
#[test]
fn a_tricycle_turns_as_fast_as_its_furthest_wheel_rolls() {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/tricycle.toml");
    let robot = ilon_sim::robot::Robot::load(robot).expect("a shipped robot");
    let seen = ilon_sim::inspect::Inspection::of(&robot).expect("it is inspected");
    let (ahead_m, steered_rad) = (0.45_f64, 74.4845_f64.to_radians());
    let expected = 0.06 * 30.0 / ahead_m.hypot(ahead_m / steered_rad.tan());
    let yaw_rate_rad_s = seen.speed_limits.expect("limited").yaw_rate_rad_s;
    assert!(
        (yaw_rate_rad_s / expected - 1.0).abs() < 1e-4,
        "{yaw_rate_rad_s} {expected}"
    );
}

/// A module at b whose wheel lies at r from its steering axis turns until the wheel rolls about the
/// middle of the robot: along p = omega k x b for a wheel d beside the axis, which is then d nearer
/// or farther, and for one that trails by c at sqrt(|b|^2 - c^2) from the middle. Asked for a
/// hundredth less no wheel is at its 1.8 m/s, for a hundredth more all are.
#[test_case([0.0, 0.045], 0.25_f64.hypot(0.19) + 0.045; "outside")]
#[test_case([0.0, -0.045], 0.25_f64.hypot(0.19) - 0.045; "inside")]
#[test_case([-0.06, 0.0], (0.25_f64.powi(2) + 0.19_f64.powi(2) - 0.06_f64.powi(2)).sqrt(); "behind")]
fn modules_off_their_axes_turn_as_fast_as_their_wheels_roll(r_m: [f64; 2], lever_m: f64) {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = std::fs::read_to_string(robots.join("offset4.urdf")).expect("a shipped robot");
    let [x_m, y_m] = r_m;
    // In the file all wheels lie to the left; here to the side of the robot on which they are.
    let mut places = text.split("xyz=\"0 0.045 -0.08\"");
    let mut text = places.next().expect("a chassis").to_owned();
    for (rest, side) in places.zip([1.0, -1.0, 1.0, -1.0]) {
        text += &format!("xyz=\"{x_m} {} -0.08\"{rest}", side * y_m);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("modules.urdf");
    std::fs::write(&file, text).expect("a file");
    let robot = ilon_sim::robot::Robot::load(&file).expect("it is read");
    let seen = ilon_sim::inspect::Inspection::of(&robot).expect("it is inspected");
    let top_rad_s = seen.speed_limits.expect("limited").yaw_rate_rad_s;
    assert!(
        (top_rad_s * lever_m / 1.8 - 1.0).abs() < 1e-9,
        "{top_rad_s}"
    );
    for (share, is_saturated) in [(0.99, false), (1.01, true)] {
        let text = format!(
            "robot.file = \"modules.urdf\"\nrun.duration_s = 2.5\n\
             twist = {{ omega_rad_s = {}, rest_s = 0, ramp_s = 1 }}\n",
            share * top_rad_s
        );
        let scenario = Scenario::from_toml(&text, "modules", folder.path()).expect("a scenario");
        let summary = Simulation::new(&scenario).expect("it drives").run().summary;
        let saturated = summary.saturated_share.expect("a twist");
        assert_eq!(saturated > 0.0, is_saturated, "{share}: {saturated}");
    }
}
