//! A robot's URDF for a controller manager of ROS 2.

use std::fmt::Write;

use roxmltree::Document;

use super::description::quoted;
use crate::model::Robot;

/// A URDF with a `<ros2_control>` block for the driven wheels and the joints that steer them,
/// without which no controller manager takes it: commands and states go over the topics that
/// `joint_state_topic_hardware_interface` and ilon share. A text with its own block stays
/// unchanged.
///
/// `None` of a text without an end.
pub fn with_ros2_control(robot: &Robot, urdf: &str) -> Option<String> {
    let has_own = |document: &Document<'_>| {
        let mut parts = document.root_element().children();
        parts.any(|part| part.has_tag_name("ros2_control"))
    };
    if Document::parse(urdf).is_ok_and(|document| has_own(&document)) {
        return Some(urdf.to_owned());
    }
    let end = urdf.rfind("</robot")?;
    let mut block = format!(
        "  <!-- Made by ilon. A threshold of -1 sends every command: above 0 a base at rest would never be sent one. -->\n  \
         <ros2_control name={} type=\"system\">\n    <hardware>\n      \
         <plugin>joint_state_topic_hardware_interface/JointStateTopicSystem</plugin>\n      \
         <param name=\"joint_commands_topic\">/robot_joint_commands</param>\n      \
         <param name=\"joint_states_topic\">/robot_joint_states</param>\n      \
         <param name=\"trigger_joint_command_threshold\">-1</param>\n    </hardware>\n",
        quoted(&robot.name)
    );
    let driven = robot.wheels.iter().filter(|of| of.motor.effort_n_m > 0.0);
    for wheel in driven {
        let limit = wheel.motor.velocity_rad_s;
        let command = if limit.is_finite() {
            format!(
                "<command_interface name=\"velocity\">\n        <param name=\"min\">{}</param>\n        <param name=\"max\">{limit}</param>\n      \
                 </command_interface>",
                -limit
            )
        } else {
            "<command_interface name=\"velocity\"/>".to_owned()
        };
        let _ = write!(
            block,
            "    <joint name={}>\n      {command}\n      <state_interface name=\"position\"/>\n      <state_interface name=\"velocity\"/>\n      \
             <state_interface name=\"effort\"/>\n    </joint>\n",
            quoted(&wheel.name)
        );
    }
    for joint in steering_joints(robot) {
        let _ = write!(
            block,
            "    <joint name={}>\n      <command_interface name=\"position\"/>\n      <state_interface name=\"position\"/>\n      \
             <state_interface name=\"velocity\"/>\n      <state_interface name=\"effort\"/>\n    </joint>\n",
            quoted(joint)
        );
    }
    block.push_str("  </ros2_control>\n");
    Some(format!("{}{block}{}", &urdf[..end], &urdf[end..]))
}

/// The names of the joints that steer wheels on tyres, each once.
fn steering_joints(robot: &Robot) -> Vec<&str> {
    let on_tyres = robot.wheels.iter().filter(|wheel| wheel.has_tyre());
    let steered = on_tyres.filter_map(|wheel| robot.steering_of(wheel));
    let mut names: Vec<&str> = Vec::new();
    for joint in steered {
        let name = robot.joints[joint].name.as_str();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LoadRobot;

    fn mecanum4() -> (Robot, String) {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../assets/robots/mecanum4.urdf"
        );
        let urdf = std::fs::read_to_string(path).unwrap();
        (Robot::from_urdf_str(&urdf, "mecanum4.urdf").unwrap(), urdf)
    }

    /// A controller manager takes the first description that it hears, and parses exactly what it
    /// needs out of this block.
    #[test]
    fn every_wheel_has_its_interfaces_in_the_one_block_that_there_is() {
        let (robot, urdf) = mecanum4();
        let whole = with_ros2_control(&robot, &urdf).unwrap();
        // A text with a block stays unchanged.
        assert_eq!(with_ros2_control(&robot, &whole).unwrap(), whole);
        let document = Document::parse(&whole).unwrap();
        let mut blocks = document
            .root_element()
            .children()
            .filter(|part| part.has_tag_name("ros2_control"));
        let block = blocks.next().unwrap();
        assert!(blocks.next().is_none());
        let joints: Vec<&str> = block
            .children()
            .filter(|part| part.has_tag_name("joint"))
            .filter_map(|joint| joint.attribute("name"))
            .collect();
        let wheels: Vec<&str> = robot
            .wheels
            .iter()
            .map(|wheel| wheel.name.as_str())
            .collect();
        assert_eq!(joints, wheels);
        // The robot is the same as before.
        let again = Robot::from_urdf_str(&whole, "again.urdf").unwrap();
        assert_eq!(again.wheels, robot.wheels);
    }

    #[test]
    fn a_text_without_an_end_is_no_robot() {
        let (robot, _) = mecanum4();
        assert_eq!(with_ros2_control(&robot, ""), None);
    }
}
