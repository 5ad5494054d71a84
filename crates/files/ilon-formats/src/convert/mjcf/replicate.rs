//! `<replicate>`: what it holds, written out as often as it says, each time in a `<frame>` of its own.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use crate::convert::assembled::Assembled;
use crate::convert::malformed::of_xml;
use crate::error::RobotError;
use crate::xml;

/// Longest text that may come of replicating, in bytes.
const MAX_BYTES: usize = 8 << 20;
/// Most elements that replicate, within each other or not.
const MOST_ELEMENTS: usize = 100;
/// Most copies of one element.
const MOST_COPIES: usize = 10_000;

/// A text without `<replicate>`: innermost first, each is replaced by its copies.
///
/// Copy i stands where i of its offsets and turns lead, and all names in it end in its separator and i. An actuator of a joint that is
/// replicated is replicated with it, as in MuJoCo.
pub(super) fn written_out(file: &str, whole: Assembled) -> Result<Assembled, RobotError> {
    let mut whole = whole;
    for left in (0..=MOST_ELEMENTS).rev() {
        let text = &whole.text;
        let document = xml::parse(text).map_err(|fault| of_xml(file, text, fault))?;
        let mut all = document.descendants().filter(is_replicate);
        let Some(node) = all.find(|node| !node.descendants().skip(1).any(|n| is_replicate(&n)))
        else {
            break;
        };
        let replicated = Replicated::read(node, &document)
            .and_then(|replicated| replicated.in_place_of(node, &document, &whole))
            .and_then(|written| match left {
                0 => Err(format!("more than {MOST_ELEMENTS} `<replicate>`")),
                _ => Ok(written),
            });
        let written =
            replicated.map_err(|reason| whole.error(file, xml::opening_tag(text, node), reason))?;
        whole = written;
    }
    Ok(whole)
}

fn is_replicate(node: &Node) -> bool {
    node.has_tag_name("replicate")
}

/// What a `<replicate>` says.
struct Replicated<'t> {
    count: usize,
    separator: &'t str,
    /// From each copy to the next.
    step: Isometry3<f64>,
}

impl<'t> Replicated<'t> {
    fn read<'d: 't>(node: Node<'t, 'd>, document: &'t Document<'d>) -> Result<Self, String> {
        let count = node.attribute("count").unwrap_or("");
        let count = count
            .trim()
            .parse()
            .ok()
            .filter(|count| *count <= MOST_COPIES);
        let Some(count) = count else {
            return Err(format!(
                "`<replicate>` needs a whole number `count` from 0 to {MOST_COPIES}"
            ));
        };
        let offset = three(node, "offset")?;
        Ok(Self {
            count,
            separator: node.attribute("sep").unwrap_or(""),
            step: Isometry3::from_parts(
                Translation3::from(offset),
                turn(three(node, "euler")?, document)?,
            ),
        })
    }

    /// The end of all names in a copy.
    fn suffix(&self, copy: usize) -> String {
        let digits = self.count.to_string().len();
        format!("{}{copy:0digits$}", self.separator)
    }

    /// The text with the copies where the element stood, and those of its actuators.
    fn in_place_of(
        &self,
        node: Node,
        document: &Document,
        old: &Assembled,
    ) -> Result<Assembled, String> {
        let text = &old.text;
        let joints: Vec<&str> = node
            .descendants()
            .filter(|n| n.has_tag_name("joint"))
            .filter_map(|n| n.attribute("name"))
            .collect();
        let is_of_joint = |n: &Node| {
            n.attribute("joint")
                .is_some_and(|name| joints.contains(&name))
        };
        let actuators = document
            .root_element()
            .children()
            .filter(|n| n.has_tag_name("actuator"))
            .flat_map(|block| block.children().filter(is_of_joint));

        let mut pieces = vec![(node.range(), self.copies(node, text)?)];
        for actuator in actuators {
            let copies = (0..self.count).map(|copy| {
                renamed(
                    actuator,
                    text,
                    actuator.range(),
                    &["name", "joint"],
                    &self.suffix(copy),
                )
            });
            pieces.push((actuator.range(), copies.collect()));
        }
        pieces.sort_by_key(|(range, _)| range.start);
        let mut whole = Assembled::default();
        let mut done = 0;
        for (range, written) in pieces {
            whole.append(old, done..range.start);
            whole.made(&written, old, range.start);
            done = range.end;
        }
        whole.append(old, done..text.len());
        enough(whole.text.len())?;
        Ok(whole)
    }

    fn copies(&self, node: Node, text: &str) -> Result<String, String> {
        let (Some(first), Some(last)) = (node.first_child(), node.last_child()) else {
            return Ok(String::new());
        };
        let inside = first.range().start..last.range().end;
        enough(self.count * inside.len())?;
        let mut whole = String::new();
        let mut place = Isometry3::identity();
        for copy in 0..self.count {
            let (p, q) = (place.translation, place.rotation);
            whole.push_str(&format!(
                "<frame pos=\"{} {} {}\" quat=\"{} {} {} {}\">{}</frame>",
                p.x,
                p.y,
                p.z,
                q.w,
                q.i,
                q.j,
                q.k,
                renamed(node, text, inside.clone(), &["name"], &self.suffix(copy))
            ));
            place *= self.step;
        }
        Ok(whole)
    }
}

/// Part of a text, with a suffix after the attributes of these names that stand in it.
fn renamed(
    node: Node,
    text: &str,
    part: std::ops::Range<usize>,
    attributes: &[&str],
    suffix: &str,
) -> String {
    let mut whole = String::new();
    let mut done = part.start;
    let of_names = node
        .descendants()
        .flat_map(|n| n.attributes())
        .filter(|a| attributes.contains(&a.name()))
        .map(|a| a.range_value())
        .filter(|value| part.start <= value.start && value.end <= part.end);
    let mut ends: Vec<usize> = of_names.map(|value| value.end).collect();
    ends.sort_unstable();
    for end in ends {
        whole.push_str(&text[done..end]);
        whole.push_str(suffix);
        done = end;
    }
    whole.push_str(&text[done..part.end]);
    whole
}

fn enough(bytes: usize) -> Result<(), String> {
    if bytes > MAX_BYTES {
        return Err(format!(
            "`<replicate>` would write out more than {} MB",
            MAX_BYTES >> 20
        ));
    }
    Ok(())
}

/// Three numbers of an attribute; zeros where there is none.
fn three(node: Node, attribute: &str) -> Result<Vector3<f64>, String> {
    let Some(text) = node.attribute(attribute) else {
        return Ok(Vector3::zeros());
    };
    let numbers: Vec<f64> = text
        .split_whitespace()
        .filter_map(|number| number.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    match numbers[..] {
        [x, y, z] if text.split_whitespace().count() == 3 => Ok(Vector3::new(x, y, z)),
        _ => Err(format!(
            "`{attribute}=\"{text}\"` of `<replicate>` is not three numbers"
        )),
    }
}

/// The turn by Euler angles, in the unit and the sequence that the file's `<compiler>` says: degrees about x, y, z of the turning frame.
fn turn(euler: Vector3<f64>, document: &Document) -> Result<UnitQuaternion<f64>, String> {
    let of_compiler = |name| {
        let compilers = document
            .root_element()
            .children()
            .filter(|n| n.has_tag_name("compiler"));
        compilers.filter_map(|n| n.attribute(name)).next_back()
    };
    let radians = of_compiler("angle") == Some("radian");
    let sequence = of_compiler("eulerseq").unwrap_or("xyz");
    let axes: Vec<Unit<Vector3<f64>>> = sequence
        .chars()
        .filter_map(|letter| match letter.to_ascii_lowercase() {
            'x' => Some(Vector3::x_axis()),
            'y' => Some(Vector3::y_axis()),
            'z' => Some(Vector3::z_axis()),
            _ => None,
        })
        .collect();
    if axes.len() != 3 || sequence.len() != 3 {
        return Err(format!("`eulerseq=\"{sequence}\"` is not three of x, y, z"));
    }
    let turns = axes.iter().zip(sequence.chars()).zip(euler.iter());
    Ok(turns.fold(
        UnitQuaternion::identity(),
        |so_far, ((axis, letter), angle)| {
            let angle = if radians { *angle } else { angle.to_radians() };
            let turn = UnitQuaternion::from_axis_angle(axis, angle);
            if letter.is_lowercase() {
                so_far * turn
            } else {
                turn * so_far
            }
        },
    ))
}
