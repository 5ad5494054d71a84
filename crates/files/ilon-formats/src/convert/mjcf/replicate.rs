//! `<replicate>`: what it holds, written out as often as it says, each time in a `<frame>` of its
//! own.

use std::collections::HashMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use crate::convert::assembled::Assembled;
use crate::convert::malformed::of_xml;
use crate::error::RobotError;
use crate::xml;

/// Longest text that may come of replicating, in bytes.
const MAX_BYTES: usize = 8 << 20;
/// Most elements that replicate, within each other or not.
const MOST_ELEMENTS: usize = 100;
/// Most bytes that are read in all: once for each element on the way to the innermost.
const MOST_READ: usize = 8 * MAX_BYTES;
/// Most copies of one element.
const MOST_COPIES: usize = 10_000;

/// A text without `<replicate>`: innermost first, each is replaced by its copies.
///
/// Copy i stands where i of its offsets and turns lead, and all names in it end in its separator
/// and i. An actuator of a joint that is replicated is replicated with it, as in MuJoCo.
pub(super) fn written_out(file: &str, whole: Assembled) -> Result<Assembled, RobotError> {
    let mut whole = whole;
    let mut read = 0;
    loop {
        let text = &whole.text;
        let document = xml::parse(text).map_err(|fault| of_xml(file, text, fault))?;
        let fault = |(node, reason): (Node, String)| {
            whole.error(file, xml::opening_tag(text, node), reason)
        };
        let all: Vec<Node> = document.descendants().filter(is_replicate).collect();
        let Some(first) = all.first() else {
            break;
        };
        // Copies hold none, so there are never more than at first.
        if let Some(beyond) = all.get(MOST_ELEMENTS) {
            let reason = format!("more than {MOST_ELEMENTS} `<replicate>`");
            return Err(fault((*beyond, reason)));
        }
        read += text.len();
        if read > MOST_READ {
            let reason = format!(
                "`<replicate>` within one another write out more than {} MB",
                MOST_READ >> 20
            );
            return Err(fault((*first, reason)));
        }
        let is_innermost = |node: &&Node| !node.descendants().skip(1).any(|n| is_replicate(&n));
        let innermost = all.iter().filter(is_innermost);
        let read_each = innermost.map(|node| {
            let replicated = Replicated::read(*node, &document).map_err(|reason| (*node, reason));
            Ok((*node, replicated?))
        });
        let replicated: Result<Vec<_>, _> = read_each.collect();
        let written = replicated.and_then(|of_each| in_their_place(&of_each, &document, &whole));
        let written = written.map_err(fault)?;
        whole = written;
    }
    Ok(whole)
}

/// The text with copies where elements stood that lie apart, and with those of their actuators.
fn in_their_place<'a, 'i>(
    all: &[(Node<'a, 'i>, Replicated<'_>)],
    document: &Document,
    old: &Assembled,
) -> Result<Assembled, (Node<'a, 'i>, String)> {
    let text = &old.text;
    let mut pieces = Vec::new();
    // The element that replicates a joint.
    let mut of_joint: HashMap<&str, &Replicated<'_>> = HashMap::new();
    for (node, replicated) in all {
        let copies = replicated
            .copies(*node, text)
            .map_err(|reason| (*node, reason))?;
        pieces.push((node.range(), copies));
        let joints = node.descendants().filter(|n| n.has_tag_name("joint"));
        for name in joints.filter_map(|n| n.attribute("name")) {
            of_joint.entry(name).or_insert(replicated);
        }
    }
    let blocks = document.root_element().children();
    let actuators = blocks
        .filter(|n| n.has_tag_name("actuator"))
        .flat_map(|block| block.children());
    for actuator in actuators {
        let joint = actuator.attribute("joint");
        if let Some(replicated) = joint.and_then(|joint| of_joint.get(joint)) {
            pieces.push((actuator.range(), replicated.of_actuator(actuator, text)));
        }
    }
    let mut whole = Assembled::default();
    whole.append_edited(old, 0..text.len(), pieces);
    match (enough(whole.text.len()), all.first()) {
        (Err(reason), Some((first, _))) => Err((*first, reason)),
        _ => Ok(whole),
    }
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

    /// The copies of an actuator of one of its joints.
    fn of_actuator(&self, actuator: Node, text: &str) -> String {
        let names = ["name", "joint"];
        let copy = |copy| renamed(actuator, text, actuator.range(), &names, &self.suffix(copy));
        (0..self.count).map(copy).collect()
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
    match xml::numbers(text).as_deref() {
        Some(&[x, y, z]) => Ok(Vector3::new(x, y, z)),
        _ => Err(format!(
            "`{attribute}=\"{text}\"` of `<replicate>` is not three numbers"
        )),
    }
}

/// The turn by Euler angles, in the unit and the sequence that the file's `<compiler>` says:
/// degrees about x, y, z of the turning frame.
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
    let wrong = || format!("`eulerseq=\"{sequence}\"` is not three of x, y, z");
    if sequence.chars().count() != 3 {
        return Err(wrong());
    }
    let mut whole = UnitQuaternion::identity();
    for (letter, angle) in sequence.chars().zip(euler.iter()) {
        let place = "xyz".find(letter.to_ascii_lowercase()).ok_or_else(wrong)?;
        let angle = if radians { *angle } else { angle.to_radians() };
        let turn = UnitQuaternion::from_axis_angle(&Vector3::ith_axis(place), angle);
        whole = match letter.is_lowercase() {
            true => whole * turn,
            false => turn * whole,
        };
    }
    Ok(whole)
}
