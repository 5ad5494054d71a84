//! Files in various authors' styles, with joints between bodies: their roles and numbers.

use std::path::Path;

use ilon_formats::LoadRobot;
use ilon_robot::{BodyJoint, JointKind, JointRole, Robot};
use test_case::test_case;

fn robot(file: &str) -> Robot {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/joints_of_people");
    Robot::load(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// Four equal springs: from classes and degrees of MJCF, and from SDF. MuJoCo counts `springref`
/// and `range` from `ref`.
#[test_case("classes.xml", JointKind::Slides, [3500.0, -0.01, 90.0, 0.0], 0.03)]
#[test_case("trailing.xml", JointKind::Turns, [45.0, -13f64.to_radians(), 1.2, 0.0], 20f64.to_radians())]
#[test_case("springs.sdf", JointKind::Slides, [3000.0, -0.012, 80.0, 0.5], 0.02)]
fn springs_are_those_of_the_file(
    file: &str,
    kind: JointKind,
    [stiffness, rest, damping, friction]: [f64; 4],
    most: f64,
) {
    let robot = robot(file);
    assert_eq!(robot.joints.len(), 4, "{:?}", robot.joints);
    for (index, joint) in robot.joints.iter().enumerate() {
        let spring = joint.spring().expect("it is sprung");
        assert_eq!(joint.kind, kind);
        assert_eq!((spring.stiffness, spring.preload), (stiffness, 0.0));
        assert!((spring.rest - rest).abs() < 1e-12, "{}", spring.rest);
        assert_eq!((joint.damping, joint.friction), (damping, friction));
        assert!((joint.limits[1] - most).abs() < 1e-12, "{:?}", joint.limits);
        assert_eq!(robot.wheels[index].carrier, Some(index));
    }
}

/// Both rockers are free, and one turns opposite to the other: `<mimic>` of URDF, `<equality>` of
/// MJCF.
#[test_case("diff_bar.urdf", 1)]
#[test_case("equality.xml", 0)]
fn a_differential_bar_couples_two_free_rockers(file: &str, follower: usize) {
    let robot = robot(file);
    let is_free = |joint: &BodyJoint| joint.role == JointRole::Free;
    assert!(robot.joints.len() == 2 && robot.joints.iter().all(is_free));
    let [coupling] = &robot.couplings[..] else {
        panic!("{:?}", robot.couplings);
    };
    assert_eq!((coupling.joint, coupling.follows), (follower, 1 - follower));
    assert_eq!((coupling.factor, coupling.offset), (-1.0, 0.0));
}

/// A lift in two stages, one of which follows the other, is driven: it is held until the user sets
/// its role.
#[test]
fn a_lift_with_an_effort_is_held() {
    let robot = robot("lift.urdf");
    assert!(robot.joints.is_empty() && robot.couplings.is_empty());
    let mut remarks = robot.remarks.iter();
    assert!(remarks.any(|remark| remark.subject.contains("lift_stage_2")));
}

/// A spring in a joint that carries no wheel moves; a free continuous joint is a part of the
/// chassis.
#[test]
fn a_camera_on_a_spring_tilts() {
    let robot = robot("pan_tilt.sdf");
    let [tilt] = &robot.joints[..] else {
        panic!("{:?}", robot.joints);
    };
    let spring = tilt.spring().expect("it is sprung");
    assert_eq!(
        (tilt.name.as_str(), spring.stiffness, spring.rest),
        ("tilt_joint", 15.0, 0.1)
    );
}
