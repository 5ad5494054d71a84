//! Robots on tyres described in TOML.

use std::path::PathBuf;

use ilon_formats::{LoadOptions, LoadRobot, SpecOnTyres, generate_on_tyres};
use ilon_robot::{JointRole, Robot, RollerForm};

fn shipped(name: &str) -> PathBuf {
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    PathBuf::from(robots).join(name)
}

/// The description says what the URDF of the same robot says, but for the fork's moments of
/// inertia.
#[test]
fn the_described_tricycle_is_that_of_its_urdf() {
    let [short, long] = ["tricycle.toml", "tricycle.urdf"]
        .map(|name| Robot::load(shipped(name)).expect("a shipped robot"));
    assert!((short.mass_kg() - long.mass_kg()).abs() < 1e-12);
    assert_eq!(short.wheels.len(), long.wheels.len());
    for (a, b) in short.wheels.iter().zip(&long.wheels) {
        assert_eq!(a.name, b.name);
        assert!(
            (a.position_m() - b.position_m()).norm() < 1e-12,
            "{}",
            a.name
        );
        assert!((a.axis() - b.axis()).norm() < 1e-12 && a.radius_m == b.radius_m);
        assert_eq!(a.motor.effort_n_m, b.motor.effort_n_m);
        assert_eq!(a.motor.velocity_rad_s, b.motor.velocity_rad_s);
        // The URDF's moments have three digits.
        let off = (a.hub.inertia_kg_m2 - b.hub.inertia_kg_m2).norm();
        assert!(off < 1e-3 * b.hub.inertia_kg_m2.norm(), "{}", a.name);
        let tyre = |of: &ilon_robot::Wheel| match &of.rollers[0].form {
            RollerForm::Tyre(solid) => [of.rollers[0].length_m, solid.edge_radius_m()],
            _ => panic!("`{}` rolls on a tyre", of.name),
        };
        let (a, b) = (tyre(a), tyre(b));
        assert!((a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-12);
    }
    let [a, b] = [&short, &long].map(|robot| {
        robot
            .steering_of(&robot.wheels[0])
            .map(|at| &robot.joints[at])
    });
    let (a, b) = (a.expect("steered"), b.expect("steered"));
    // 1.3 rad are 74.4845 deg to four digits.
    assert!((a.limits[1] - b.limits[1]).abs() < 1e-6 && a.limits[0] == -a.limits[1]);
    let servo = |of: &ilon_robot::BodyJoint| match of.role {
        JointRole::Driven(servo) => [servo.effort, servo.rate_limit, servo.stiffness],
        _ => panic!("a servo"),
    };
    assert_eq!(servo(a)[..2], servo(b)[..2]);
    assert!((servo(a)[2] - servo(b)[2]).abs() < 1e-9 * servo(b)[2]);
    let com = |of: &Robot| of.chassis.mass.center_of_mass_m;
    assert!((com(&short) - com(&long)).norm() < 1e-12);
}

const SWERVE: &str = r#"
name = "three"
[chassis]
shape.cylinder = { radius_m = 0.3, height_m = 0.1 }
mass_kg = 20
center_m = [0, 0, 0.2]
[tyres]
radius_m = 0.05
width_m = 0.03
shoulder_radius_m = 0.01
mass_kg = 0.5
motor_effort_n_m = 6
motor_velocity_rad_s = 30
[steering]
fork_mass_kg = 0.5
effort_n_m = 8
velocity_rad_s = 12
trail_m = 0.02
[[wheels]]
name = "a"
position_m = [0.2, 0]
steered = true
[[wheels]]
name = "b"
position_m = [-0.1, 0.2]
axis_deg = 45
steered = true
[[wheels]]
name = "c"
position_m = [-0.1, -0.2]
steered = true
[[casters]]
name = "tail"
position_m = [-0.25, 0]
radius_m = 0.03
width_m = 0.02
mass_kg = 0.1
fork_mass_kg = 0.2
trail_m = 0.025
"#;

fn read(text: &str) -> Result<Robot, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("short.toml");
    std::fs::write(&file, text).expect("written");
    let loaded = Robot::load_with(&file, &LoadOptions::default());
    loaded
        .map(|loaded| loaded.robot)
        .map_err(|error| error.to_string())
}

#[test]
fn modules_with_trail_and_casters_are_read_as_described() {
    let robot = read(SWERVE).expect("a good description");
    for (wheel, [x, y, axis_deg]) in
        robot
            .wheels
            .iter()
            .zip([[0.2, 0.0, 90.0_f64], [-0.1, 0.2, 45.0], [-0.1, -0.2, 90.0]])
    {
        let off = wheel.position_m() - nalgebra::Vector3::new(x, y, 0.05);
        assert!(
            off.norm() < 1e-12,
            "{}: {:?}",
            wheel.name,
            wheel.position_m()
        );
        let (sin, cos) = axis_deg.to_radians().sin_cos();
        assert!((wheel.axis() - nalgebra::Vector2::new(cos, sin)).norm() < 1e-12);
        let joint = &robot.joints[robot.steering_of(wheel).expect("steered")];
        let trail = wheel.position_m().xy() - joint.body_from_joint.translation.vector.xy();
        // Behind the axis along its way: u = n x k.
        assert!(
            (trail + 0.02 * nalgebra::Vector2::new(sin, -cos)).norm() < 1e-12,
            "{trail}"
        );
        assert_eq!(joint.limits, [f64::NEG_INFINITY, f64::INFINITY]);
    }
    let free: Vec<&str> = robot
        .joints
        .iter()
        .filter(|of| matches!(of.role, JointRole::Free))
        .map(|of| of.name.as_str())
        .collect();
    assert_eq!(free.len(), 2, "{free:?}");
    assert!((robot.mass_kg() - (20.0 + 3.0 * 1.0 + 0.3)).abs() < 1e-12);
}

/// A generated file is read as the same robot as the description.
#[test]
fn the_generated_urdf_is_read_as_the_description() {
    let file = shipped("tricycle.toml");
    let spec = SpecOnTyres::load(&file)
        .expect("readable")
        .expect("on tyres");
    let urdf = generate_on_tyres(&spec);
    let read = Robot::from_urdf_str(&urdf, "tricycle").expect("good");
    assert_eq!(read.wheels, Robot::load(&file).expect("good").wheels);
}

#[test]
fn what_is_out_of_range_is_refused_by_its_key() {
    for (good, bad, key) in [
        ("width_m = 0.03", "width_m = -1", "tyres.width_m"),
        (
            "shoulder_radius_m = 0.01",
            "shoulder_radius_m = 0.02",
            "tyres",
        ),
        (
            "fork_mass_kg = 0.5",
            "fork_mass_kg = 0",
            "steering.fork_mass_kg",
        ),
        ("trail_m = 0.025", "trail_m = 0", "casters.0.trail_m"),
        ("name = \"b\"", "name = \"a\"", "wheels.1.name"),
        ("mass_kg = 20", "mass_kg = nan", "chassis.mass_kg"),
        (
            "axis_deg = 45",
            "axis = 45\nplace = 3",
            "unknown keys `wheels.1.axis`, `wheels.1.place`",
        ),
    ] {
        let text = SWERVE.replacen(good, bad, 1);
        let error = read(&text).expect_err(key);
        assert!(error.contains(key), "{key}: {error}");
    }
    let without: String = SWERVE.replacen("[steering]", "[other]", 1);
    assert!(read(&without).is_err());
}
