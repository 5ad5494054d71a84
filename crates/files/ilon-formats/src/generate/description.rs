//! The robot's URDF as viewers need it: with a link for each wheel and roller, and something to see
//! of each roller.

use std::collections::HashSet;
use std::fmt::Write;
use std::ops::Range;

use nalgebra::{Isometry3, UnitQuaternion};
use roxmltree::Document;

use super::elements::{attribute, origin, spheres_of};
use super::slices_of;
use crate::model::{Robot, RobotDescription, Roller, RollerForm, SolidOfRevolution, Wheel};
use crate::urdf::{Edit, UrdfText, child, link_tree};

/// The URDF of a robot, with a joint and a link for each of its wheels and rollers: the text that
/// it was read from, and what that lacks of them. Rollers that the text does not show are shown as
/// the spheres whose envelope is their barrel.
///
/// `urdf` is the URDF that was read ([`Loaded::urdf`](crate::Loaded::urdf)); of an empty text, or
/// one that is no tree of links, the robot is described anew.
pub fn describe(robot: &Robot, urdf: &str) -> RobotDescription {
    let urdf = completed(robot, urdf).unwrap_or_else(|| {
        let [name, base] = [&robot.name, &robot.chassis.name].map(|name| quoted(name));
        let bare = format!("<robot name={name}>\n  <link name={base}/>\n</robot>\n");
        // Its one link is a tree.
        completed(robot, &bare).unwrap_or(bare)
    });
    RobotDescription {
        links: link_tree(&urdf).unwrap_or_default(),
        urdf,
    }
}

fn completed(robot: &Robot, urdf: &str) -> Option<String> {
    let tree = link_tree(urdf)?;
    let document = Document::parse(urdf).ok()?;
    let element = document.root_element();
    let end = urdf[..element.range().end].rfind("</")?;
    let mut names: HashSet<String> = tree.links.iter().map(|link| link.name.clone()).collect();
    // What of the text is replaced, and by what.
    let mut edits: Vec<Edit> = Vec::new();
    let mut added = String::new();
    for wheel in &robot.wheels {
        let (wheel_link, body_from_wheel) = match tree.joint(&wheel.name) {
            Some(joint) => {
                let link = &tree.links[joint.child];
                (link.name.clone(), link.body_from_link)
            }
            None => {
                let link = unique(format!("{}_link", wheel.name), &mut names);
                let placed = Placed {
                    joint: &wheel.name,
                    parent: &tree.links[0].name,
                    child: &link,
                    parent_from_child: wheel.body_from_hub,
                };
                added.push_str(&placed.joint_and_link(""));
                (link, wheel.body_from_hub)
            }
        };
        for (index, roller) in wheel.rollers.iter().enumerate() {
            let body_from_roller = wheel.body_from_hub * roller.hub_from_roller();
            let Some(joint) = tree.joint(&roller.name) else {
                let link = format!("{}_roller_{}_link", wheel.name, index + 1);
                let link = unique(link, &mut names);
                let placed = Placed {
                    joint: &roller.name,
                    parent: &wheel_link,
                    child: &link,
                    parent_from_child: body_from_wheel.inverse() * body_from_roller,
                };
                let shown = visuals(wheel, roller, &Isometry3::identity());
                added.push_str(&placed.joint_and_link(&shown));
                continue;
            };
            let known = &tree.links[joint.child];
            let mut links = element.children().filter(|node| node.has_tag_name("link"));
            let link = links.find(|node| node.attribute("name") == Some(&known.name))?;
            if child(link, "visual").is_some() {
                continue;
            }
            let link_from_roller = known.body_from_link.inverse() * body_from_roller;
            let shown = visuals(wheel, roller, &link_from_roller);
            let text = &urdf[link.range()];
            let Range { start, end } = link.range();
            edits.push(match text.rfind("</").filter(|_| !text.ends_with("/>")) {
                Some(close) => (start + close..start + close, shown),
                None => (end - "/>".len()..end, format!(">\n{shown}  </link>")),
            });
        }
    }
    edits.push((end..end, added));
    let edited = UrdfText::as_it_is("", urdf).edited(edits);
    Some(edited.text.to_string())
}

/// A joint that turns about z, and the link below it.
struct Placed<'a> {
    joint: &'a str,
    parent: &'a str,
    child: &'a str,
    parent_from_child: Isometry3<f64>,
}

impl Placed<'_> {
    fn joint_and_link(&self, shown: &str) -> String {
        let [joint, parent, child] = [self.joint, self.parent, self.child].map(quoted);
        let at = origin(&self.parent_from_child);
        format!(
            "  <joint name={joint} type=\"continuous\">\n    <parent link={parent}/>\n    <child link={child}/>\n    {at}\n    \
             <axis xyz=\"0 0 1\"/>\n  </joint>\n  <link name={child}>\n{shown}  </link>\n"
        )
    }
}

fn visuals(wheel: &Wheel, roller: &Roller, link_from_roller: &Isometry3<f64>) -> String {
    if let RollerForm::Turned(turned) = &roller.form {
        return slices(turned, link_from_roller);
    }
    spheres_of(&wheel.barrel(roller)).fold(String::new(), |mut shown, [t_m, radius_m]| {
        let at = link_from_roller * Isometry3::translation(0.0, 0.0, t_m);
        let at = origin(&Isometry3::from_parts(
            at.translation,
            UnitQuaternion::identity(),
        ));
        let _ = writeln!(
            shown,
            "    <visual>{at}<geometry><sphere radius=\"{radius_m}\"/></geometry></visual>"
        );
        shown
    })
}

/// A roller with a profile by numbers, as a stack of cylinders.
fn slices(turned: &SolidOfRevolution, link_from_roller: &Isometry3<f64>) -> String {
    slices_of(turned).fold(String::new(), |mut shown, [t_m, length_m, radius_m]| {
        let at = origin(&(link_from_roller * Isometry3::translation(0.0, 0.0, t_m)));
        let _ = writeln!(
            shown,
            "    <visual>{at}<geometry><cylinder radius=\"{radius_m}\" length=\"{length_m}\"/></geometry></visual>"
        );
        shown
    })
}

/// A text as an attribute's value, in its quotes.
pub(super) fn quoted(text: &str) -> String {
    format!("\"{}\"", attribute(text))
}

/// A name that is not taken, which is taken now.
fn unique(mut name: String, taken: &mut HashSet<String>) -> String {
    while !taken.insert(name.clone()) {
        name.push('_');
    }
    name
}

#[cfg(test)]
mod tests {
    use super::super::elements::SPHERES_PER_ROLLER as SPHERES;
    use super::*;
    use crate::LoadRobot;
    use crate::model::{CollisionShape, Visual, VisualShape};

    fn mecanum4() -> Robot {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        Robot::from_urdf_str(urdf, "mecanum4").unwrap()
    }

    /// The place along z and the radius of each sphere that a link shows.
    fn spheres(urdf: &str, joint: &str) -> Vec<(f64, f64)> {
        let tree = link_tree(urdf).unwrap();
        let link = &tree.links[tree.joint(joint).unwrap().child];
        let sphere = |visual: &Visual| {
            let at = visual.link_from_visual.translation;
            assert!(at.x.abs() < 1e-12 && at.y.abs() < 1e-12, "{at}");
            let VisualShape::Solid(CollisionShape::Sphere { radius_m }) = visual.shape else {
                panic!("{visual:?}")
            };
            (at.z, radius_m)
        };
        link.visuals.iter().map(sphere).collect()
    }

    /// A barrel is what a wheel's rim leaves of a sphere that goes along the roller's axis: each
    /// touches the rim from within, and the first and the last stand at the barrel's ends.
    #[test]
    fn spheres_of_a_roller_touch_the_rim_from_within_and_reach_its_ends() {
        let robot = mecanum4();
        let urdf = describe(&robot, "").urdf;
        for wheel in &robot.wheels {
            for roller in &wheel.rollers {
                assert!(!matches!(roller.form, RollerForm::Turned(_)));
                let shown = spheres(&urdf, &roller.name);
                assert_eq!(shown.len(), SPHERES);
                let half_m = wheel.barrel(roller).half_length_m;
                assert!((shown[0].0 + half_m).abs() < 1e-12);
                assert!((shown[SPHERES - 1].0 - half_m).abs() < 1e-12);
                for (t_m, radius_m) in shown {
                    let at = roller.hub_from_roller() * nalgebra::Point3::new(0.0, 0.0, t_m);
                    let reach_m = at.x.hypot(at.y) + radius_m;
                    assert!((reach_m - wheel.radius_m).abs() < 1e-9, "{t_m} {reach_m}");
                }
            }
        }
    }

    /// Whether a link that shows nothing is written in one tag or in two, its roller is shown once.
    #[test]
    fn links_of_rollers_that_show_nothing_are_given_something_to_see() {
        let robot = mecanum4();
        let whole = describe(&robot, "").urdf;
        let lines = whole.lines().filter(|line| !line.contains("<visual>"));
        let in_two_tags = lines.fold(String::new(), |text, line| text + line + "\n");
        let in_one_tag = in_two_tags.replace("\">\n  </link>", "\"/>");
        assert!(in_one_tag.len() < in_two_tags.len());
        for text in [&whole, &in_two_tags, &in_one_tag] {
            let completed = describe(&robot, text).urdf;
            for roller in robot.wheels.iter().flat_map(|wheel| &wheel.rollers) {
                let (found, expected) = (
                    spheres(&completed, &roller.name),
                    spheres(&whole, &roller.name),
                );
                assert_eq!(found.len(), expected.len(), "{}", roller.name);
                for ((t_m, radius_m), (there_m, as_large_m)) in found.into_iter().zip(expected) {
                    // Angles of frames go through text and back: some roundings of lengths below 1.
                    assert!((t_m - there_m).abs() < 1e-12 && (radius_m - as_large_m).abs() < 1e-12);
                }
            }
        }
    }

    /// A roller by numbers is a stack of cylinders on its axis, from its one end to the other
    /// without a gap.
    #[test]
    fn a_roller_by_numbers_is_shown_from_end_to_end() {
        let points_m = [[-0.02, 0.005], [0.0, 0.01], [0.03, 0.004]];
        let turned = SolidOfRevolution::new(&points_m, 0.0).unwrap();
        let text = format!("<a>{}</a>", slices(&turned, &Isometry3::identity()));
        let document = Document::parse(&text).unwrap();
        let attribute = |tag: &str, name: &str| -> Vec<Vec<f64>> {
            let nodes = document.descendants();
            nodes
                .filter(|node| node.has_tag_name(tag))
                .filter_map(|node| node.attribute(name))
                .map(|text| text.split(' ').map(|x| x.parse().unwrap()).collect())
                .collect()
        };
        let mut end_m = -0.02;
        let lengths_m = attribute("cylinder", "length");
        for (at, length_m) in attribute("origin", "xyz").iter().zip(&lengths_m) {
            assert_eq!((at[0], at[1]), (0.0, 0.0));
            assert!((at[2] - 0.5 * length_m[0] - end_m).abs() < 1e-12, "{at:?}");
            end_m += length_m[0];
        }
        assert_eq!(lengths_m.len(), SPHERES);
        assert!((end_m - 0.03).abs() < 1e-12, "{end_m}");
    }
}
