//! A controller that believes in another robot: the real robot moves by its real wheels, dead
//! reckoning uses the believed robot, and the difference is attributed to neither wheels nor floor.

use std::path::{Path, PathBuf};

use ilon_robot::Twist;
use ilon_sim::{Error, Run, Scenario, Simulation, run};
use nalgebra::{Matrix3, Vector3};

fn robots() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots")
}

fn scenario(robot: &str, motion: &str, belief: &str) -> Result<Scenario, Error> {
    let text = format!(
        "robot = {{ file = \"{robot}\", roller_bodies = \"near\" }}\n{motion}\nrun.duration_s = 2.5\n{belief}\n"
    );
    Scenario::from_toml(&text, "beliefs", robots())
}

fn driven(robot: &str, motion: &str, belief: &str) -> Run {
    run(&scenario(robot, motion, belief).expect("a scenario")).expect("it runs")
}

/// An open-loop twist, with means from 1 s on.
fn twist(vx_m_s: f64, vy_m_s: f64, omega_rad_s: f64) -> String {
    format!(
        "twist = {{ vx_m_s = {vx_m_s}, vy_m_s = {vy_m_s}, omega_rad_s = {omega_rad_s}, rest_s = 0.0, ramp_s = 0.5, settle_s = 0.5 }}"
    )
}

const MECANUM: &str = "mecanum4.urdf";
const OMNI: &str = "volksbot.urdf";
const AHEAD: [f64; 3] = [0.3, 0.0, 0.0];
const LEFT: [f64; 3] = [0.0, 0.31, 0.0];
const TURNING: [f64; 3] = [0.0, 0.0, 0.9];

/// The twist of the wheels' targets at the end of a run by the real robot's kinematics, which is
/// exact.
fn of_targets(run: &Run) -> [f64; 3] {
    numbers(run.trace.records().last().expect("rows").twist_target_ideal)
}

fn numbers(twist: Twist) -> [f64; 3] {
    [twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s]
}

fn assert_near(found: [f64; 3], expected: [f64; 3], within: f64, what: &str) {
    let pairs = found.into_iter().zip(expected);
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= within, "{what}: {found:?} in place of {expected:?}");
}

/// The terms of the budget add up to the missing motion, to the rounding of thousands of sums of
/// numbers below 1.
fn assert_adds_up(run: &Run, what: &str) {
    let ledger = &run.summary.ledger;
    let sum = |of: fn(&ilon_trace::ledger::Integral) -> f64| -> f64 {
        ledger.terms().iter().map(of).sum()
    };
    for (sum, total) in [
        (sum(|term| term.x_m), ledger.total.x_m),
        (sum(|term| term.y_m), ledger.total.y_m),
        (sum(|term| term.heading_rad), ledger.total.heading_rad),
    ] {
        assert!((sum - total).abs() < 1e-11, "{what}: {sum} {total}");
    }
}

/// Beliefs about mecanum wheels at (+-0.15, +-0.16) m of 50 mm and 45 deg, in the order front left,
/// front right, rear left, rear right. By the textbook each turns at w = (vx -+ vy -+ 0.31 omega) /
/// 0.05, and the rates w move the robot by 0.05 / 4
/// [sum, -fl + fr + rl - rr, (-fl + fr - rl + rr) / 0.31].
#[test]
fn mecanum_wheels_turn_the_real_robot_and_not_the_believed_one() {
    let one = "controller.robot.wheels.front_left";
    for (asked, belief, expected) in [
        // Larger wheels turn less.
        (
            AHEAD,
            "controller.robot.wheel_radius_m = 0.0515".to_owned(),
            [0.3 / 1.03, 0.0, 0.0],
        ),
        (
            LEFT,
            "controller.robot.wheel_radius_m = 0.0515".to_owned(),
            [0.0, 0.31 / 1.03, 0.0],
        ),
        (
            TURNING,
            "controller.robot.wheel_radius_m = 0.0515".to_owned(),
            [0.0, 0.0, 0.9 / 1.03],
        ),
        // A longer lever turns them more.
        (
            TURNING,
            "controller.robot.lever_m = 0.341".to_owned(),
            [0.0, 0.0, 0.9 * 1.1],
        ),
        (AHEAD, "controller.robot.lever_m = 0.341".to_owned(), AHEAD),
        // A wheel at half of the rate of the others: 1/2 in place of 1.
        (
            AHEAD,
            format!("{one}.radius_m = 0.1"),
            [0.3 * 3.5 / 4.0, 0.3 * 0.5 / 4.0, 0.3 * 0.5 / 4.0 / 0.31],
        ),
        // It turns backwards: -1 in place of 1.
        (
            AHEAD,
            format!("{one}.reversed = true"),
            [0.3 * 2.0 / 4.0, 0.3 * 2.0 / 4.0, 0.3 * 2.0 / 4.0 / 0.31],
        ),
        // To the left is (-1, 1, 1, -1), and becomes (1, -1, 1, -1): the robot turns to the right
        // by 1 rad for 0.31 m.
        (
            LEFT,
            format!(
                "{one}.taken_for = \"front_right\"\ncontroller.robot.wheels.front_right.taken_for = \"front_left\""
            ),
            [0.0, 0.0, -1.0],
        ),
        // Rollers at 40 deg need tan(40 deg) of the rate to the left, and those of the other
        // handedness turn the other way.
        (
            LEFT,
            "controller.robot.gamma_deg = 40".to_owned(),
            [0.0, 0.31 * f64::to_radians(40.0).tan(), 0.0],
        ),
        (
            LEFT,
            "controller.robot.gamma_deg = -45".to_owned(),
            [0.0, -0.31, 0.0],
        ),
        // One wheel of such rollers.
        (LEFT, format!("{one}.gamma_deg = -40"), {
            let rate = -f64::to_radians(40.0).tan();
            let [ahead, left, turn] = [rate + 1.0, 3.0 - rate, -1.0 - rate];
            [0.31 * ahead / 4.0, 0.31 * left / 4.0, turn / 4.0]
        }),
        // For a rotation about (0.1, 0) m the origin moves to the right by 0.1 m per rad.
        (
            TURNING,
            "controller.robot.origin_x_m = 0.1".to_owned(),
            [0.0, -0.09, 0.9],
        ),
        // It moves towards its believed front.
        (
            AHEAD,
            "controller.robot.origin_heading_deg = 90".to_owned(),
            [0.0, 0.3, 0.0],
        ),
    ] {
        let [vx, vy, omega] = asked;
        let found = driven(MECANUM, &twist(vx, vy, omega), &belief);
        assert_near(of_targets(&found), expected, 1e-12, &belief);
        assert_adds_up(&found, &belief);
        // The wheels follow their targets to the loops' error, 0.1 %; to the left the rollers add 2
        // %.
        let wheels = numbers(found.summary.twist_ideal_mean.expect("means"));
        assert_near(wheels, expected, 2e-3, &belief);
        let budget = &found.summary.ledger;
        let wrong = (asked[0] - expected[0]).hypot(asked[1] - expected[1])
            + 0.31 * (asked[2] - expected[2]).abs();
        let of_belief = budget.belief.path_m + 0.31 * budget.belief.turned_rad;
        // The twist grows for 0.5 s and holds for 2.
        assert!(
            (of_belief - 2.25 * wrong).abs() < 0.02 * wrong + 1e-9,
            "{belief}: {of_belief} {wrong}"
        );
        let of_wheels = budget.servo.path_m + 0.31 * budget.servo.turned_rad;
        assert!(of_wheels < 0.01, "{belief}: {of_wheels}");
        // Its own estimate is the commanded pose.
        let end = found.trace.records().last().expect("rows");
        let turned = (asked[2] != 0.0).then_some(end.odometry_ideal.heading_rad);
        let went = turned.unwrap_or_else(|| end.odometry_ideal.position_m().norm());
        let reckoned = went / (asked[0].hypot(asked[1]) + asked[2]);
        // The wheels' loops lag by the last hundredth of a second.
        assert!((reckoned - 2.25).abs() < 0.03, "{belief}: {reckoned}");
    }
}

/// The map from twists to rates of three omni wheels, computed independently: a wheel at (x, y)
/// whose axis points to theta rolls along theta - 90 deg.
fn omni(wheels: [(f64, f64, f64, f64); 3]) -> Matrix3<f64> {
    Matrix3::from_rows(&wheels.map(|(x_m, y_m, theta_deg, radius_m)| {
        let along = f64::to_radians(theta_deg - 90.0);
        let (y, x) = along.sin_cos();
        Vector3::new(x, y, y * x_m - x * y_m).transpose() / radius_m
    }))
}

const RING: f64 = 0.216_506_350_946_11;
const VOLKSBOT: [(f64, f64, f64, f64); 3] = [
    (0.25, 0.0, 0.0, 0.05),
    (-0.125, RING, 120.0, 0.05),
    (-0.125, -RING, 240.0, 0.05),
];

/// Three wheels can turn at any rates: the robot moves by A^-1 B v, with A the map of the real
/// wheels and B that of the believed ones.
#[test]
fn omni_wheels_move_the_robot_by_the_quotient_of_both_maps() {
    let [one, two, three] = VOLKSBOT;
    let minus = |(x, y, theta, radius): (f64, f64, f64, f64)| (x, y, theta, -radius);
    for (belief, wheels) in [
        (
            "wheel_radius_m = 0.06",
            VOLKSBOT.map(|(x, y, theta, _)| (x, y, theta, 0.06)),
        ),
        (
            "lever_m = 0.3",
            VOLKSBOT.map(|(x, y, theta, radius)| (1.2 * x, 1.2 * y, theta, radius)),
        ),
        (
            "wheels.wheel_2.radius_m = 0.045",
            [one, (two.0, two.1, two.2, 0.045), three],
        ),
        (
            "wheels.wheel_2.axis_deg = 130",
            [one, (two.0, two.1, 130.0, 0.05), three],
        ),
        ("wheels.wheel_3.reversed = true", [one, two, minus(three)]),
        (
            "wheels = { wheel_1 = { x_m = 0.2, y_m = 0.03 }, wheel_3 = { axis_deg = 233 } }",
            [(0.2, 0.03, 0.0, 0.05), two, (three.0, three.1, 233.0, 0.05)],
        ),
        (
            "wheels = { wheel_1.taken_for = \"wheel_2\", wheel_2.taken_for = \"wheel_3\", wheel_3.taken_for = \"wheel_1\" }",
            [two, three, one],
        ),
        (
            "wheels = { wheel_1 = { taken_for = \"wheel_2\", reversed = true }, wheel_2.taken_for = \"wheel_1\" }",
            [minus(two), one, three],
        ),
    ] {
        let asked = [0.1, -0.05, 0.3];
        let real = omni(VOLKSBOT).try_inverse().expect("a robot that drives");
        let expected = real * omni(wheels) * Vector3::from(asked);
        let found = driven(
            OMNI,
            &twist(0.1, -0.05, 0.3),
            &format!("controller.robot.{belief}"),
        );
        // The file's numbers have 14 digits.
        assert_near(of_targets(&found), expected.into(), 1e-12, belief);
        let moved = numbers(found.summary.twist_mean.expect("means"));
        // Omni wheels of one row follow their kinematics to half a percent.
        assert_near(moved, expected.into(), 5e-3, belief);
        assert_adds_up(&found, belief);
    }
}

/// A belief in 3 % larger wheels: the robot moves by 0.97 of the command, and dead reckoning misses
/// 30 mm per metre, by either kinematics.
#[test]
fn dead_reckoning_goes_by_what_is_believed() {
    let belief = "controller.robot.wheel_radius_m = 0.0515";
    for kinematics in ["ideal", "contact"] {
        let belief = format!("{belief}\nguidance.kinematics = \"{kinematics}\"");
        let found = driven(MECANUM, &twist(0.3, 0.0, 0.0), &belief).summary;
        let ratio = found.twist_ratio_asked.vx.expect("it went ahead");
        // Ahead mecanum wheels follow their kinematics, except for 0.1 % of sliding at hand-overs.
        assert!((ratio - 1.0 / 1.03).abs() < 1e-3, "{ratio}");
        for drift in [found.odometry_ideal, found.odometry_contact] {
            let drift = drift.m_per_m.expect("it went");
            assert!((drift - 0.03).abs() < 1e-3, "{drift}");
        }
        // Neither wheels nor floor are blamed: 3 / 103 of the command is the belief's.
        let ledger = &found.ledger;
        let asked_m = 0.3 * 2.25;
        assert!((ledger.belief.x_m / asked_m - 3.0 / 103.0).abs() < 1e-3);
        assert!(ledger.servo.path_m < 0.1 * ledger.belief.path_m);
        assert!(ledger.compensation.path_m < 0.01 * ledger.belief.path_m + 1e-3 * asked_m);
    }
}

/// A filter without poses relies on the wheels, and so on the belief about them: 30 mm per metre
/// too far.
#[test]
fn fusion_goes_by_what_is_believed() {
    let text = "controller.robot.wheel_radius_m = 0.0515\nsensors.fusion = {}\n[[faults]]\npose_lost = { from_s = 0.0 }";
    let found = driven(MECANUM, &twist(0.4, 0.0, 0.0), text);
    let end = found.trace.records().last().expect("rows");
    let (seen, real) = (end.seen_pose.x_m, end.truth.pose.x_m);
    assert!((seen / real - 1.03).abs() < 1e-3, "{seen} {real}");
}

/// The guidance corrects a robot that moves at 1 / 1.03 of the command: in the steady state K e =
/// 0.03 v with 0.3 m/s, so that e = 3 mm at a gain of 3 / s.
#[test]
fn guidance_on_a_wrong_radius_stays_behind_by_what_its_gain_allows() {
    let motion = "reference.line = { from_x_m = 0, from_y_m = 0, to_x_m = 2, to_y_m = 0, speed_m_s = 0.3 }\nguidance.position_gain_per_s = 3";
    let behind = |belief: &str| {
        let found = driven(MECANUM, motion, belief);
        assert_adds_up(&found, belief);
        let end = found.trace.records().last().copied().expect("rows");
        end.desired.expect("a reference").pose.x_m - end.truth.pose.x_m
    };
    let [without, with] = ["", "controller.robot.wheel_radius_m = 0.0515"].map(behind);
    // After 2.5 s e^(-3 t) leaves 0.1 %; rollers that hand over move the robot by a tenth of a
    // millimetre.
    assert!((with - without - 3e-3).abs() < 1e-4, "{with} {without}");
}

/// With the front wheels exchanged a command (vx, vy, omega) moves the robot by (vx, -L omega, -vy
/// / L), L = 0.31 m: what is to correct the place turns it, and what is to correct the heading
/// shifts it. Of gains of 1 / s the errors obey e_y' = L e_h, e_h' = e_y / L: they grow as cosh t
/// and sinh t, and no gain helps. Nine rollers take 2 % sideways and 1 % of turns. A loop that
/// integrates to the wheel's angle follows slow commands without a lag of first order, and a
/// command that is held for 10 ms comes 5 ms late in the mean: a growth of sqrt(0.98 x 0.99) (1 -
/// 0.005) = 0.980 / s. The first 10 ms and rollers that hand over leave some per cent of the
/// millimetre that it begins with.
#[test]
fn guidance_drives_a_robot_away_whose_front_wheels_are_exchanged() {
    let exchanged = "controller.robot.wheels = { front_left.taken_for = \"front_right\", front_right.taken_for = \"front_left\" }";
    // It begins 1 mm to the left of its target.
    let motion = "reference.hold_pose = { x_m = 0, y_m = -1e-3, heading_deg = 0 }\nguidance.position_gain_per_s = 1\nguidance.heading_gain_per_s = 1";
    let ended = |belief: &str| {
        let found = driven(MECANUM, motion, belief);
        assert_adds_up(&found, belief);
        found.trace.records().last().expect("rows").truth.pose
    };
    let right = ended("");
    // e^-2.5 is left.
    assert!((right.y_m + 1e-3 - 8.2e-5).abs() < 1e-5, "{right:?}");
    let wrong = ended(exchanged);
    let t = 0.980 * 2.5_f64;
    assert!(
        ((wrong.y_m + 1e-3) / (1e-3 * t.cosh()) - 1.0).abs() < 0.04,
        "{wrong:?}"
    );
    let turned_rad = 1e-3 / 0.31 * t.sinh();
    assert!(
        (wrong.heading_rad.abs() / turned_rad - 1.0).abs() < 0.04,
        "{wrong:?}"
    );
}

/// Wheels of 50 mm that are believed to have 51.5 are sent at v / 0.0515, and move the real robot by
/// 0.05 of that, along where its modules have turned.
#[test]
fn steered_wheels_move_the_real_robot_where_they_point() {
    let belief = "controller.robot.wheel_radius_m = 0.0515";
    for asked in [[0.2, 0.2, 0.0], [0.0, 0.25, 0.0], [0.2, -0.1, 0.3]] {
        let found = driven("swerve4.urdf", &twist(asked[0], asked[1], asked[2]), belief);
        let expected = asked.map(|part| part * 0.05 / 0.0515);
        // Servos have come within a thousandth of a radian.
        assert_near(of_targets(&found), expected, 3e-4, belief);
    }
}

/// A true belief changes no bit, and an empty section is no belief.
#[test]
fn a_true_belief_is_none() {
    let of = |belief: &str| {
        let found = driven(MECANUM, &twist(0.2, 0.1, 0.3), belief);
        (found.summary.trace_hash.clone(), found.trace.header.belief)
    };
    let plain = of("");
    assert_eq!(plain.1, None);
    let wheels = "controller.robot = { wheel_radius_m = 0.05, wheels.front_left = { x_m = 0.15, taken_for = \"front_left\" } }";
    for belief in [
        "controller.robot = {}",
        wheels,
        "controller.robot.file = \"mecanum4.urdf\"",
    ] {
        assert_eq!(of(belief), plain, "{belief}");
    }
}

/// Another robot's file defines the believed wheels; by names if these are the same.
#[test]
fn another_file_says_what_is_believed() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("other.toml");
    let text = std::fs::read_to_string(robots().join("mecanum4.toml")).expect("a shipped robot");
    let larger = text.replace("radius_m = 0.05\n", "radius_m = 0.06\n");
    assert_ne!(larger, text);
    std::fs::write(&file, larger).expect("written");
    let belief = format!("controller.robot.file = \"{}\"", file.display());
    let found = driven(MECANUM, &twist(0.3, 0.0, 0.0), &belief);
    assert_near(of_targets(&found), [0.25, 0.0, 0.0], 1e-12, &belief);
    let words = found.trace.header.belief.expect("a belief");
    assert!(
        words.contains("radius 60.00 mm in place of 50.00 mm"),
        "{words}"
    );
}

/// The header's description of a belief names what was exchanged, reversed or measured wrongly, and
/// nothing else.
#[test]
fn a_belief_is_said_in_words() {
    let swapped = "front_left.taken_for = \"front_right\", front_right = { taken_for = \"front_left\", reversed = true }";
    for (belief, said) in [
        (
            format!("wheels = {{ {swapped} }}"),
            "`front_left` taken for `front_right`, `front_right` taken for `front_left`, `front_right` reversed",
        ),
        (
            "wheels.rear_left.axis_deg = 80".to_owned(),
            "`rear_left` with axis 80.00° in place of 90.00°",
        ),
        (
            "lever_m = 0.341".to_owned(),
            "`lever_m` of 341.00 mm in place of 310.00 mm",
        ),
        (
            "origin_x_m = 0.05".to_owned(),
            "the origin at (50.00, 0.00) mm",
        ),
    ] {
        let scenario = scenario(
            MECANUM,
            &twist(0.1, 0.0, 0.0),
            &format!("controller.robot.{belief}"),
        );
        let simulation = Simulation::new(&scenario.expect("a scenario")).expect("it stands");
        assert_eq!(simulation.trace().header.belief.as_deref(), Some(said));
    }
}

#[test]
fn what_nobody_can_believe_is_refused() {
    let wheel = |keys: &str| format!("controller.robot.wheels.front_left = {{ {keys} }}");
    let parallel =
        "controller.robot.wheels = { front_left.gamma_deg = 45, rear_right.gamma_deg = 45 }";
    for (belief, said) in [
        (
            "controller.robot.wheel_radius_m = -0.05".to_owned(),
            "wheel_radius_m",
        ),
        (wheel("radius_m = 0"), "radius_m"),
        (
            "controller.robot.wheels.front_let.radius_m = 0.05".to_owned(),
            "front_left",
        ),
        (wheel("taken_for = \"front_right\""), "front_right"),
        (wheel("taken_for = \"nobody\""), "nobody"),
        (parallel.to_owned(), "controller.robot"),
        (
            "controller.robot.gamma_deg = 90".to_owned(),
            "controller.robot",
        ),
        (
            "controller.robot.file = \"volksbot.urdf\"".to_owned(),
            "3 wheels",
        ),
        (
            "controller.robot.file = \"none.urdf\"".to_owned(),
            "none.urdf",
        ),
    ] {
        let refused = scenario(MECANUM, &twist(0.1, 0.0, 0.0), &belief)
            .and_then(|scenario| Simulation::new(&scenario));
        let Err(error) = refused else {
            panic!("{belief} is taken");
        };
        let report = format!("{:?}", miette::Report::new(error));
        assert!(report.contains(said), "{belief}: {report}");
        assert!(report.contains("help"), "{belief}: {report}");
    }
}

/// Three omni wheels of radius rho at a distance L turn at w = s . v / rho + L omega / rho. A
/// radius believed 1.03 times too large turns all of them 1.03 times too slowly; a lever believed
/// 1.1 times as long turns the robot 1.1 times as far and leaves its ways; wheels that are taken
/// for each other, the second and the third, drive by the permuted rates P w, M^+ P M v: for wheels
/// at 60, 180 and 300 deg, or any such star, P is the mirror across the axis of the first, which
/// keeps turns and the way across that axis or turns it round. Dead reckoning by the belief says
/// what was asked in all of it.
#[test]
fn three_omni_wheels_turn_the_real_robot_and_not_the_believed_one() {
    let robot = "optiodom_omni3.toml";
    let names: Vec<String> = {
        let scenario = scenario(robot, &twist(0.1, 0.0, 0.0), "").expect("a scenario");
        let robot = ilon_sim::load_robot(&scenario).expect("a shipped robot");
        robot
            .wheels
            .iter()
            .map(|wheel| wheel.name.clone())
            .collect()
    };
    let right =
        |asked: [f64; 3]| of_targets(&driven(robot, &twist(asked[0], asked[1], asked[2]), ""));
    let asked = [0.2, 0.1, 0.6];
    // Nothing saturates: the targets equal the command to rounding.
    assert_near(right(asked), asked, 1e-12, "nothing believed");
    let believed = |belief: &str| {
        let found = driven(robot, &twist(asked[0], asked[1], asked[2]), belief);
        assert_adds_up(&found, belief);
        of_targets(&found)
    };
    let radius_m = {
        let scenario = scenario(robot, &twist(0.1, 0.0, 0.0), "").expect("a scenario");
        let robot = ilon_sim::load_robot(&scenario).expect("a shipped robot");
        (
            robot.wheels[0].radius_m,
            robot.wheels[0].position_m().xy().norm(),
        )
    };
    let (radius_m, lever_m) = radius_m;
    let found = believed(&format!(
        "controller.robot.wheel_radius_m = {}",
        1.03 * radius_m
    ));
    assert_near(found, asked.map(|of| of / 1.03), 1e-12, "radius");
    let found = believed(&format!("controller.robot.lever_m = {}", 1.1 * lever_m));
    assert_near(found, [asked[0], asked[1], 1.1 * asked[2]], 1e-12, "lever");
    let exchanged = format!(
        "controller.robot.wheels = {{ {a}.taken_for = \"{b}\", {b}.taken_for = \"{a}\" }}",
        a = names[1],
        b = names[2]
    );
    let found = believed(&exchanged);
    // A mirror keeps lengths and the rotation, and applied twice it is the identity.
    let length = |of: [f64; 3]| of[0].hypot(of[1]);
    assert!(
        (length(found) - length(asked)).abs() < 1e-9 && (found[2] - asked[2]).abs() < 1e-9,
        "{found:?}"
    );
    assert!(
        (found[0] - asked[0]).hypot(found[1] - asked[1]) > 0.01,
        "{found:?}"
    );
    let again = driven(robot, &twist(found[0], found[1], found[2]), &exchanged);
    assert_near(of_targets(&again), asked, 1e-9, "exchanged twice");
}

/// Tyres of 60 mm at (0, +-0.17) m, those of a skid-steered robot, and steered ones: a wheel
/// believed to be a tenth larger turns 1/1.1 of what is asked; a believed half track of 0.2 m turns
/// the robot faster by 0.2 / 0.17. Tyres give way by some thousandths of the rates of a turn.
#[test]
fn robots_on_tyres_are_driven_by_what_is_believed_of_them() {
    for (robot, radius_m, asked) in [
        ("differential.urdf", 0.06, AHEAD),
        ("differential.urdf", 0.06, [0.2, 0.0, 0.5]),
        ("skid4.urdf", 0.08, AHEAD),
        ("swerve4.urdf", 0.05, LEFT),
    ] {
        let [vx, vy, omega] = asked;
        let belief = format!("controller.robot.wheel_radius_m = {}", 1.1 * radius_m);
        let run = driven(robot, &twist(vx, vy, omega), &belief);
        let expected = asked.map(|x| x / 1.1);
        assert_near(
            numbers(run.summary.twist_mean.expect("means")),
            expected,
            2e-3,
            robot,
        );
        assert_adds_up(&run, robot);
    }
    let lever = driven(
        "differential.urdf",
        &twist(0.2, 0.0, 0.5),
        "controller.robot.lever_m = 0.2",
    );
    let expected = [0.2, 0.0, 0.5 * 0.2 / 0.17];
    assert_near(
        numbers(lever.summary.twist_mean.expect("means")),
        expected,
        2e-3,
        "lever",
    );
    let gamma = scenario(
        "differential.urdf",
        &twist(0.2, 0.0, 0.0),
        "controller.robot.gamma_deg = 45",
    );
    let refused = gamma.and_then(|scenario| run(&scenario)).map(|_| ());
    let refused = refused.expect_err("tyres have no gamma").to_string();
    assert!(refused.contains("rolls on a tyre"), "{refused}");
}

/// Steered wheels are believed elsewhere with their steering axes. Modules of a swerve drive at
/// (+-0.25, +-0.2) m whose lever is taken for 5 % longer turn it by 5 % more; exchanged cables of
/// two drives on a side, of equal rates in a turn, change nothing, as their steering is right; with
/// an origin believed 50 mm ahead the robot turns about that. A tricycle of 0.45 m between drive and
/// axle, which stands 0.2 m behind the origin, taken for 5 % longer: the drive stands at
/// atan(L omega / v) for L = 0.4725 m and turns the robot by 5 % more at the same speed of the axle.
/// Within 1.5 mm/s and mrad/s: the servos give way by 0.5 mrad, and tyres scrub in turns.
#[test]
fn steering_axes_are_believed_where_their_wheels_are() {
    let cables = |one: &str, other: &str| {
        format!("controller.robot.wheels.{one}_drive.taken_for = \"{other}_drive\"\n")
    };
    let exchanged = cables("front_left", "rear_left") + &cables("rear_left", "front_left");
    let tricycle = "controller.robot.wheels.drive.x_m = 0.2725";
    for (robot, [vx, vy, omega], belief, expected) in [
        (
            "swerve4.urdf",
            [0.0, 0.0, 0.5],
            "controller.robot.lever_m = 0.21",
            [0.0, 0.0, 0.525],
        ),
        ("swerve4.urdf", [0.0, 0.0, 0.5], &exchanged, [0.0, 0.0, 0.5]),
        (
            "swerve4.urdf",
            [0.0, 0.0, 0.5],
            "controller.robot.origin_x_m = 0.05",
            [0.0, -0.025, 0.5],
        ),
        (
            "tricycle.toml",
            [0.3, 0.0, 0.3],
            tricycle,
            [0.3, 0.063, 0.315],
        ),
    ] {
        let twist = format!(
            "twist = {{ vx_m_s = {vx:?}, vy_m_s = {vy:?}, omega_rad_s = {omega:?}, settle_s = 0.5 }}"
        );
        let text = format!("robot.file = \"{robot}\"\n{twist}\nrun.duration_s = 3\n{belief}\n");
        let scenario = Scenario::from_toml(&text, "beliefs", robots()).expect("a scenario");
        let run = run(&scenario).expect("it runs");
        assert_near(
            numbers(run.summary.twist_mean.expect("a mean")),
            expected,
            1.5e-3,
            belief,
        );
    }
}
