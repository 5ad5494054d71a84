//! The file as text: the places of its elements, and faults of the text alone.
//!
//! urdf-rs reports hardly any places; roxmltree knows every byte. So the text is checked against
//! the form of URDF here first, with line numbers, and urdf-rs then reads a valid text.

use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use roxmltree::{Document, Node};

use super::urdf_text::UrdfText;
use crate::error::{Fault, RobotError};
use crate::model::Remark;
use crate::xml;

/// A URDF text and its elements.
pub(super) struct Source<'a> {
    pub(super) prepared: &'a UrdfText,
    document: Document<'a>,
    line_breaks: Vec<usize>,
    /// The first link and the first joint of each name.
    by_name: OnceCell<HashMap<(&'static str, String), roxmltree::NodeId>>,
}

/// Largest number of links and joints: those of seventy thousand rollers, and read in seconds. 64
/// MB could hold three million.
const MOST_PARTS: usize = 150_000;

/// The reason why a file that is not XML is rejected.
const NO_ROBOT_FILE: &str = "it does not begin with `<`, so this is not a robot file";

impl<'a> Source<'a> {
    /// Parses the text as XML and checks it against the form of URDF.
    pub(super) fn parse(prepared: &'a UrdfText) -> Result<Self, RobotError> {
        let text = &prepared.text;
        let document = xml::parse(text).map_err(|fault| {
            let (fault, bytes) = match fault {
                xml::Fault::Malformed(reason, bytes) => {
                    let reason = match text.trim_start().starts_with('<') {
                        true => reason,
                        false => NO_ROBOT_FILE.to_owned(),
                    };
                    (Fault::Xml { reason }, bytes)
                }
                xml::Fault::TooMuch(what, most, bytes) => (Fault::TooLarge { what, most }, bytes),
            };
            let error = RobotError::new(&prepared.file, fault);
            if bytes.is_empty() {
                error
            } else {
                error.at(text, bytes)
            }
        })?;
        let source = Self {
            prepared,
            document,
            line_breaks: text.match_indices('\n').map(|(at, _)| at).collect(),
            by_name: OnceCell::new(),
        };
        let root = source.robot();
        if root.tag_name().name() != "robot" {
            let root_tag = root.tag_name().name().to_owned();
            return Err(source.error(root, Fault::NotUrdf { root_tag }));
        }
        if (source.all("link").chain(source.all("joint")))
            .nth(MOST_PARTS)
            .is_some()
        {
            let what = format!("more than {MOST_PARTS} links and joints");
            let most = MOST_PARTS.to_string();
            return Err(source.robot_error(Fault::TooLarge { what, most }));
        }
        Ok(source)
    }

    /// The text.
    pub(super) fn text(&self) -> &'a str {
        &self.prepared.text
    }

    /// The `<robot>` element.
    pub(super) fn robot(&self) -> Node<'_, 'a> {
        self.document.root_element()
    }

    /// Returns the links or the joints of the robot.
    pub(super) fn all(&self, tag: &'static str) -> impl Iterator<Item = Node<'_, 'a>> {
        self.robot().children().filter(move |n| n.has_tag_name(tag))
    }

    /// An error about an element, at its opening tag.
    pub(super) fn error(&self, node: Node, fault: Fault) -> RobotError {
        self.error_at(node, self.opening_tag(node), fault)
    }

    /// An error about an attribute of an element, at the attribute.
    pub(super) fn attribute_error(&self, node: Node, attribute: &str, fault: Fault) -> RobotError {
        match node.attribute_node(attribute) {
            Some(a) => self.error_at(node, a.range(), fault),
            None => self.error(node, fault),
        }
    }

    /// An error about an element at some of its bytes. If the text was derived from another, the
    /// element's origin is shown.
    fn error_at(&self, node: Node, bytes: Range<usize>, fault: Fault) -> RobotError {
        let at = node.range().start;
        let error = match self.prepared.origin(at) {
            Some(origin) => {
                RobotError::new(&origin.file, fault).at(&origin.text, origin.bytes.clone())
            }
            None => RobotError::new(&self.prepared.file, fault).at(&self.prepared.text, bytes),
        };
        error.about(describe(node)).loaded_at(at)
    }

    /// Returns the element of an error of this text.
    pub(super) fn node_of(&self, error: &RobotError) -> Option<Node<'_, 'a>> {
        let at = error.loaded()?;
        let mut node = self.robot();
        // Descends to the element that starts there.
        while node.range().start != at {
            node = node
                .children()
                .find(|child| child.is_element() && child.range().contains(&at))?;
        }
        Some(node)
    }

    /// An error about the joint with that name.
    pub(super) fn joint_error(&self, name: &str, fault: Fault) -> RobotError {
        self.named_error("joint", name, fault)
    }

    /// An error about the link with that name.
    pub(super) fn link_error(&self, name: &str, fault: Fault) -> RobotError {
        self.named_error("link", name, fault)
    }

    /// An error about the robot as a whole.
    pub(super) fn robot_error(&self, fault: Fault) -> RobotError {
        self.error(self.robot(), fault)
    }

    /// An error about the mass properties of the link with that name: at its `<inertial>`, if it
    /// has one.
    pub(super) fn inertial_error(&self, link: &str, fault: Fault) -> RobotError {
        let inertial = self.named("link", link).and_then(|n| child(n, "inertial"));
        match inertial {
            Some(node) => self.error(node, fault),
            None => self.link_error(link, fault),
        }
    }

    fn named_error(&self, tag: &'static str, name: &str, fault: Fault) -> RobotError {
        match self.named(tag, name) {
            Some(node) => self.error(node, fault),
            None => RobotError::new(&self.prepared.file, fault).about(format!("{tag} `{name}`")),
        }
    }

    /// Returns the first link or joint with a name.
    pub(super) fn named(&self, tag: &'static str, name: &str) -> Option<Node<'_, 'a>> {
        let by_name = self.by_name.get_or_init(|| {
            let mut by_name = HashMap::new();
            for tag in ["link", "joint"] {
                for node in self.all(tag) {
                    let name = node.attribute("name").unwrap_or_default().to_owned();
                    by_name.entry((tag, name)).or_insert(node.id());
                }
            }
            by_name
        });
        let id = by_name.get(&(tag, name.to_owned()))?;
        self.document.get_node(*id)
    }

    fn opening_tag(&self, node: Node) -> Range<usize> {
        xml::opening_tag(self.text(), node)
    }

    /// Returns the line of an element, from 1, in its original file.
    pub(super) fn line_of(&self, node: Node) -> usize {
        let at = node.range().start;
        match self.prepared.origin(at) {
            Some(origin) => origin.line,
            None => {
                1 + self
                    .line_breaks
                    .partition_point(|line_break| *line_break < at)
            }
        }
    }

    /// Sets a remark's place to that of an element.
    pub(super) fn place_at(&self, remark: &mut Remark, node: Node) {
        remark.line = Some(self.line_of(node));
        remark.file = self
            .prepared
            .origin(node.range().start)
            .map(|origin| origin.file.to_string())
            .filter(|file| *file != self.prepared.file);
    }

    /// Sets the places of remarks about links and joints.
    pub(super) fn place(&self, remarks: &mut [Remark]) {
        for remark in remarks.iter_mut().filter(|remark| remark.line.is_none()) {
            // For ``link `base`, `<inertial>` `` the link is used.
            let outer = remark.subject.split(", `<").next().unwrap_or_default();
            let named = outer.split_once(" `").and_then(|(kind, name)| {
                let tag = match kind {
                    "link" => "link",
                    "joint" | "wheel" => "joint",
                    _ => return None,
                };
                self.named(tag, name.strip_suffix('`')?)
            });
            if let Some(node) = named {
                self.place_at(remark, node);
            }
        }
    }

    /// Returns remarks on ignored elements, counted by tag.
    pub(super) fn ignored_elements(&self) -> Vec<Remark> {
        const READ: [(&str, &str); 3] = [
            (
                "robot",
                "link joint material ilon_drive ilon_rollers ilon_spring ilon_tyres",
            ),
            ("link", "inertial collision visual"),
            ("joint", OF_JOINT),
        ];
        const OF_JOINT: &str =
            "origin parent child axis limit dynamics mimic calibration safety_controller";
        let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
        let robot = self.robot();
        for outer in [robot]
            .into_iter()
            .chain(self.all("link"))
            .chain(self.all("joint"))
        {
            let Some((inside, read)) = READ.iter().find(|(tag, _)| outer.has_tag_name(*tag)) else {
                continue;
            };
            for node in outer.children().filter(Node::is_element) {
                let tag = node.tag_name().name();
                // Friction with a direction stands for rollers, and has remarks of its own.
                let is_friction = tag == "gazebo" && child(node, "fdir1").is_some();
                if !is_friction && !read.split(' ').any(|known| known == tag) {
                    *counts.entry((inside, tag)).or_default() += 1;
                }
            }
        }
        counts
            .into_iter()
            .map(|((inside, tag), count)| {
                let subject = format!("`<{tag}>`");
                match (inside, tag) {
                    ("robot", "transmission") => Remark::aside(
                        subject,
                        format!("{count} in the file, of which only gear ratios are read"),
                    ),
                    ("robot", _) => Remark::aside(
                        subject,
                        format!("{count} in the file, not read: settings of other programs"),
                    ),
                    (inside, _) => Remark::new(
                        subject,
                        format!("{count} in the {inside}s of the file, not read: not part of URDF"),
                    ),
                }
            })
            .collect()
    }
}

/// Returns the first child element with that tag.
pub(crate) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.has_tag_name(tag))
}

/// Returns the text of the first child element with that tag; `None` if it is empty.
pub(crate) fn text_of<'a>(node: Node<'a, '_>, tag: &str) -> Option<&'a str> {
    Some(child(node, tag)?.text()?.trim()).filter(|text| !text.is_empty())
}

/// Returns ``joint `arm` ``, or ``link `base`, `<inertia>` `` for an inner element.
pub(super) fn describe(node: Node) -> String {
    let tag = node.tag_name().name();
    let outer = node
        .ancestors()
        .find(|n| n.has_tag_name("link") || n.has_tag_name("joint"));
    match outer {
        None => format!("`<{tag}>`"),
        Some(outer) => {
            let kind = outer.tag_name().name();
            let name = match outer.attribute("name") {
                Some(name) => format!("{kind} `{name}`"),
                None => format!("{kind} without a name"),
            };
            if outer == node {
                name
            } else {
                format!("{name}, `<{tag}>`")
            }
        }
    }
}
