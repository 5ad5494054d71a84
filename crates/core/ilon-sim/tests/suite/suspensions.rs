//! Suspensions from a short description: writing, reading back, and the robot's stance by hand.

use ilon_formats::{LoadRobot, Spec, generate};
use ilon_sim::robot::{JointKind, JointRole, Pose, Robot};
use ilon_world::{Floor, GroundBox, MotorTorque, Settings, World};
use nalgebra::Vector3;
use test_case::test_case;

const G: f64 = 9.81;
/// Half of the wheels' base and of their track, in metres.
const X_M: f64 = 0.15;
const Y_M: f64 = 0.16;

/// A mecanum robot of 10 kg whose chassis has its centre slightly ahead, with a suspension.
fn described(suspension: &str) -> String {
    format!(
        r#"
name = "hung"
chassis = {{ shape.box = {{ size_m = [0.40, 0.24, 0.10] }}, mass_kg = 10.0, center_m = [0.03, 0.0, 0.10] }}
wheel = {{ radius_m = 0.05, hub_mass_kg = 0.25, hub_radius_m = 0.03, hub_width_m = 0.04, motor_effort_n_m = 1.8, motor_velocity_rad_s = 30 }}
rollers = {{ per_row = 9, radius_m = 0.012, mass_kg = 0.01 }}
wheels.mecanum = {{ axles_m = [0.15, -0.15], half_width_m = 0.16, gamma_deg = 45 }}
{suspension}
"#
    )
}

fn robot(suspension: &str) -> Robot {
    let spec = Spec::from_toml_str(&described(suspension), "hung.toml").expect("a description");
    let urdf = generate(&spec).expect("a robot");
    Robot::from_urdf_str(&urdf, "hung.urdf").expect("it is read")
}

/// Lets it stand with braked wheels until nothing moves; returns the loads of its wheels.
fn stands(robot: &Robot, floor: &Floor) -> (World, [f64; 4]) {
    let settings = Settings::default();
    let mut world = World::new(robot, floor, Pose::default(), &settings).expect("it stands");
    for _ in 0..300 {
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let hold = |rate: &f64| MotorTorque::with_droop(-20.0 * rate, 20.0);
        let motors: Vec<MotorTorque> = rates.iter().map(hold).collect();
        world.robot_mut().drive(&motors);
        world.step();
    }
    let contacts = world.robot().contacts();
    let loads = [0, 1, 2, 3].map(|wheel| contacts[wheel].normal_force_n);
    (world, loads)
}

fn assert_near(value: f64, expected: f64, within: f64, what: &str) {
    assert!(
        (value - expected).abs() <= within * expected.abs().max(1e-12),
        "{what}: {value} where {expected} is expected"
    );
}

const SPRUNG: &str = r#"
[suspension.all]
wheels = ["front_left", "front_right", "rear_left", "rear_right"]
mass_kg = 0.1
law.sprung = { stiffness_n_m = 4000, damping_n_s_m = 60, travel_m = 0.02 }
"#;

/// Each spring bears the load of its wheel without the wheel and its carrier, and sags by that over
/// its stiffness; the axles share by moments.
#[test]
fn wheels_on_springs_sag_by_their_loads() {
    let robot = robot(SPRUNG);
    assert_eq!(robot.joints.len(), 4);
    for joint in &robot.joints {
        assert_eq!(joint.kind, JointKind::Slides);
        assert_eq!((joint.limits, joint.damping), ([-0.02, 0.02], 60.0));
        assert!(matches!(joint.role, JointRole::Sprung(spring) if spring.stiffness == 4000.0));
    }
    let (world, loads) = stands(&robot, &Floor::default());
    // Wheels and carriers: 0.34 and 0.1 kg each. The chassis's centre is 0.03 m ahead, and moves
    // ahead by its height over the axles times the pitch.
    let (chassis_n, corner_n) = (10.0 * G, 0.44 * G);
    let pitch_rad = world.robot().state().pitch_rad;
    let ahead_m = 0.03 + 0.05 * pitch_rad;
    let front_n = 0.25 * chassis_n * (1.0 + ahead_m / X_M);
    let rear_n = 0.25 * chassis_n * (1.0 - ahead_m / X_M);
    for (wheel, of_chassis_n) in [front_n, front_n, rear_n, rear_n].into_iter().enumerate() {
        assert_near(loads[wheel], of_chassis_n + corner_n, 2e-3, "load");
        let sag_m = world.robot().joint_positions()[wheel];
        assert_near(sag_m, of_chassis_n / 4000.0, 2e-3, "sag");
    }
    assert_near(
        pitch_rad,
        (front_n - rear_n) / (4000.0 * 2.0 * X_M),
        5e-3,
        "pitch",
    );
}

/// With a preload equal to their load they are at zero.
#[test]
fn preloaded_springs_stand_at_zero() {
    let preloaded = SPRUNG.replace("travel_m", "preload_n = 24.525, travel_m");
    let preloaded = described(&preloaded).replace("[0.03,", "[0.0,");
    let spec = Spec::from_toml_str(&preloaded, "hung.toml").expect("a description");
    let urdf = generate(&spec).expect("a robot");
    let robot = Robot::from_urdf_str(&urdf, "hung.urdf").expect("it is read");
    let (world, _) = stands(&robot, &Floor::default());
    for at in world.robot().joint_positions() {
        assert!(at.abs() < 1e-6, "{at}");
    }
}

/// On arms behind their pivots, or ahead of them, each spring turns by the moment of its load about
/// the pivot.
#[test_case(0.1; "trailing")]
#[test_case(-0.08; "leading")]
fn wheels_on_arms_turn_them_by_their_moments(length_m: f64) {
    let robot = robot(&format!(
        "[suspension.all]\nwheels = [\"front_left\", \"front_right\", \"rear_left\", \"rear_right\"]\nmass_kg = 0.2\n\
         law.trailing_arm = {{ length_m = {length_m}, stiffness_n_m_rad = 40, damping_n_m_s_rad = 1, travel_deg = 20 }}"
    ));
    let (world, loads) = stands(&robot, &Floor::default());
    let sum_n: f64 = loads.iter().sum();
    assert_near(sum_n, (10.0 + 4.0 * 0.54) * G, 1e-6, "sum");
    let pitch_rad = world.robot().state().pitch_rad;
    for (wheel, load_n) in loads.into_iter().enumerate() {
        let turned_rad = world.robot().joint_positions()[wheel];
        assert!(turned_rad > 0.0, "a load turns it up: {turned_rad}");
        // Relative to the horizontal: the chassis pitches about its left axis, in the sense of arms
        // behind their pivots.
        let to_level_rad = turned_rad + pitch_rad * length_m.signum();
        let carried_n = load_n - 0.34 * G;
        let moment_n_m =
            (carried_n * length_m.abs() - 0.2 * G * 0.5 * length_m.abs()) * to_level_rad.cos();
        // The hub's load acts at the wheel's contact, under its axle except for the rollers' offset
        // ahead or behind: some tenths of a millimetre.
        assert_near(40.0 * turned_rad, moment_n_m, 1e-2, "moment");
    }
}

/// A rocker loads both of its wheels equally whatever is under one; a bogie one ahead and one
/// behind.
#[test_case(["rear_left", "rear_right"]; "a rocker")]
#[test_case(["front_left", "rear_left"]; "a bogie")]
fn wheels_on_a_rocker_bear_alike(wheels: [&str; 2]) {
    let robot = robot(&format!(
        "[suspension.beam]\nwheels = {wheels:?}\nmass_kg = 0.3\nlaw.rocker = {{ limit_deg = 8, damping_n_m_s_rad = 0.05 }}"
    ));
    let [beam] = &robot.joints[..] else {
        panic!("one joint");
    };
    assert_eq!((beam.name.as_str(), beam.role), ("beam", JointRole::Free));
    let mut floor = Floor::default();
    floor.boxes.push(GroundBox {
        center_m: Vector3::new(-X_M, Y_M, 0.005),
        half_sides_m: Vector3::new(0.06, 0.06, 0.005),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    });
    let (world, loads) = stands(&robot, &floor);
    let of = |name: &str| {
        robot
            .wheels
            .iter()
            .position(|wheel| wheel.name == name)
            .expect("there")
    };
    let [one, other] = wheels.map(|name| loads[of(name)]);
    assert_near(one, other, 0.01, "alike");
    let base_m: f64 = if wheels[0] == "rear_left" {
        2.0 * Y_M
    } else {
        2.0 * X_M
    };
    let turned_rad = world.robot().joint_positions()[0];
    assert_near(turned_rad.abs(), 0.01 / base_m, 0.15, "turned");
}

/// Unreasonable demands are refused with their key.
#[test_case("wheels = [\"front_lef\"]\nmass_kg = 1\nlaw.rocker = { limit_deg = 5 }", "front_lef"; "an unknown wheel")]
#[test_case("wheels = [\"front_left\"]\nmass_kg = 1\nlaw.rocker = { limit_deg = 5 }", "two wheels"; "a rocker of one wheel")]
#[test_case("wheels = [\"front_left\", \"front_left\"]\nmass_kg = 1\nlaw.rocker = { limit_deg = 5 }", "named once"; "a wheel twice")]
#[test_case("wheels = []\nmass_kg = 1\nlaw.sprung = { stiffness_n_m = 1, travel_m = 1 }", "one wheel or more"; "no wheel")]
#[test_case("wheels = [\"front_left\"]\nmass_kg = 0\nlaw.sprung = { stiffness_n_m = 1, travel_m = 1 }", "suspension.x.mass_kg"; "no mass")]
#[test_case("wheels = [\"front_left\"]\nmass_kg = 1\nlaw.sprung = { stiffness_n_m = 0, travel_m = 1 }", "law.sprung.stiffness_n_m"; "no stiffness")]
#[test_case("wheels = [\"front_left\"]\nmass_kg = 1\nlaw.sprung = { stiffness_n_m = 9, travel_m = nan }", "law.sprung.travel_m"; "no number")]
#[test_case("wheels = [\"front_left\"]\nmass_kg = 1\nlaw.trailing_arm = { length_m = 0, stiffness_n_m_rad = 9, travel_deg = 9 }", "law.trailing_arm.length_m"; "an arm without length")]
#[test_case("wheels = [\"front_left\"]\nmass_kg = 1\nlaw.trailing_arm = { length_m = 1, stiffness_n_m_rad = 9, travel_deg = 95 }", "below 90"; "too far")]
#[test_case("wheels = [\"front_left\"]\nmass_kg = 1\nlaw.sprong = { stiffness_n_m = 9 }", "sprong"; "an unknown law")]
fn what_cannot_be_is_refused_by_its_key(text: &str, words: &str) {
    let text = described(&format!("[suspension.x]\n{text}"));
    let refused = Spec::from_toml_str(&text, "hung.toml").and_then(|spec| generate(&spec));
    let error = refused.expect_err("it is refused").to_string();
    assert!(error.contains(words), "{error}");
}

/// A rocker must not have the name of a wheel.
#[test]
fn a_rocker_has_a_name_of_its_own() {
    let text = described(
        "[suspension.front_left]\nwheels = [\"rear_left\", \"rear_right\"]\nmass_kg = 1\nlaw.rocker = { limit_deg = 5 }",
    );
    let spec = Spec::from_toml_str(&text, "hung.toml").expect("a description");
    let error = generate(&spec).expect_err("it is refused").to_string();
    assert!(error.contains("a name that no wheel"), "{error}");
}
