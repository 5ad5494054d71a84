//! The links of a URDF for viewers.

use std::f64::consts::FRAC_PI_2;

use ilon_formats::LoadRobot;
use ilon_formats::{describe, link_tree, with_ros2_control};
use ilon_robot::{CollisionShape, Robot, VisualShape};
use nalgebra::Vector3;
use test_case::test_case;

fn joint(parent: &str, child: &str) -> String {
    format!(
        "<joint name='{parent}_{child}'><parent link='{parent}'/><child link='{child}'/></joint>"
    )
}

/// `rpy` turns about x, then y, then z of the parent: a yaw of a quarter turn takes x to y, a pitch
/// x to -z, a roll y to z.
#[test]
fn an_origin_turns_by_its_roll_pitch_and_yaw() {
    let quarter = FRAC_PI_2;
    for (rpy, from, to) in [
        (format!("0 0 {quarter}"), Vector3::x(), Vector3::y()),
        (format!("0 {quarter} 0"), Vector3::x(), -Vector3::z()),
        (format!("{quarter} 0 0"), Vector3::y(), Vector3::z()),
        // Roll first: y goes to z, and by the yaw stays there; x goes to y by the yaw alone.
        (format!("{quarter} 0 {quarter}"), Vector3::y(), Vector3::z()),
        (format!("{quarter} 0 {quarter}"), Vector3::x(), Vector3::y()),
    ] {
        let text = format!(
            "<robot><link name='a'/><link name='b'/><joint name='j'><parent link='a'/><child link='b'/>\
             <origin xyz='1 2 3' rpy='{rpy}'/></joint></robot>"
        );
        let tree = link_tree(&text).expect("a tree");
        let placed = tree.joint("j").expect("the joint").parent_from_child;
        // One sine and one cosine, each off by less than a unit in its last place.
        assert!((placed.rotation * from - to).norm() < 1e-15, "{rpy}");
        assert_eq!(placed.translation.vector, Vector3::new(1.0, 2.0, 3.0));
    }
}

/// Parents come before their children, and joints stay in the order of the file.
#[test]
fn links_hang_where_the_file_says() {
    let links = "<link name='c'/><link name='b'/><link name='a'/>";
    let text = format!(
        "<robot>{links}{}{}</robot>",
        joint("b", "c"),
        joint("a", "b")
    );
    let tree = link_tree(&text).expect("a tree");
    let names: Vec<&str> = tree.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "c"]);
    let joints: Vec<_> = tree
        .joints
        .iter()
        .map(|j| (j.name.as_str(), j.parent, j.child))
        .collect();
    assert_eq!(joints, [("b_c", 1, 2), ("a_b", 0, 1)]);
    assert_eq!(tree.links[2].above, Some(0));
}

#[test_case("<robot><link name='a'/>", &[]; "no XML")]
#[test_case("<robot><link name='a'/><link name='b'/></robot>", &[]; "two roots")]
#[test_case("<robot><link name='a'/><link name='b'/><link name='c'/>", &[("a", "b"), ("b", "c"), ("c", "b")]; "a loop")]
#[test_case("<robot><link name='a'/><link name='b'/>", &[("a", "b"), ("b", "a")]; "no root")]
#[test_case("<robot><link name='a'/>", &[("a", "b")]; "an unknown link")]
fn what_is_no_one_tree_is_none(start: &str, joints: &[(&str, &str)]) {
    let joints: String = joints
        .iter()
        .map(|(parent, child)| joint(parent, child))
        .collect();
    let text = match joints.is_empty() {
        true => start.to_owned(),
        false => format!("{start}{joints}</robot>"),
    };
    assert_eq!(link_tree(&text), None);
}

/// A shape has the colour of its own material, or of the robot's material of that name.
#[test]
fn what_a_link_shows_is_read_with_its_colour() {
    let text = "<robot><material name='red'><color rgba='1 0 0 1'/></material><link name='a'>\
                <visual><geometry><box size='1 2 3'/></geometry><material name='red'/></visual>\
                <visual><geometry><mesh filename='m.stl' scale='2 2 2'/></geometry><material><color rgba='0 0 2 1'/></material></visual>\
                <visual><geometry><cylinder radius='1'/></geometry></visual></link></robot>";
    let tree = link_tree(text).expect("a tree");
    let [solid, mesh] = &tree.links[0].visuals[..] else {
        panic!("a cylinder without a length shows nothing: {tree:?}");
    };
    let half_extents_m = Vector3::new(0.5, 1.0, 1.5);
    assert_eq!(
        solid.shape,
        VisualShape::Solid(CollisionShape::Box { half_extents_m })
    );
    assert_eq!(solid.color, Some([1.0, 0.0, 0.0, 1.0]));
    let (name, scale) = ("m.stl".to_owned(), [2.0; 3]);
    assert_eq!(mesh.shape, VisualShape::Mesh { name, scale });
    assert_eq!(mesh.color, Some([0.0, 0.0, 1.0, 1.0]));
}

/// A description has a joint for each wheel and roller, and its links are those of its text, also
/// with the block for a controller manager.
#[test]
fn a_description_has_all_wheels_and_rollers() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    let urdf = std::fs::read_to_string(path).expect("a shipped robot");
    let robot = Robot::from_urdf_str(&urdf, "mecanum4").expect("it loads");
    for text in [urdf.as_str(), "", "<robot>"] {
        let described = describe(&robot, text);
        for wheel in &robot.wheels {
            assert!(
                described.links.joint(&wheel.name).is_some(),
                "{}",
                wheel.name
            );
            for roller in &wheel.rollers {
                assert!(
                    described.links.joint(&roller.name).is_some(),
                    "{}",
                    roller.name
                );
            }
        }
        let whole = with_ros2_control(&robot, &described.urdf).expect("it has an end");
        assert_eq!(link_tree(&whole), Some(described.links));
    }
}
