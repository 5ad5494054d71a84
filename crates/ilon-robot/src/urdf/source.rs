//! The file as text: where its elements are, and the faults that show in the text alone.
//!
//! urdf-rs says what a file means but hardly where; roxmltree knows every byte. So the text is held against the form of
//! URDF here first, with line numbers, and urdf-rs then reads what is known to be well formed.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use roxmltree::{Document, Node};

use super::remark;
use crate::error::{Fault, RobotError};
use crate::model::Remark;
use crate::xml;

/// A URDF text and its elements.
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
    document: Document<'a>,
}

impl<'a> Source<'a> {
    /// Parses the text as XML and holds it against the form of URDF.
    pub(super) fn parse(text: &'a str, file: &'a str) -> Result<Self, RobotError> {
        let document = xml::parse(text).map_err(|fault| match fault {
            xml::Fault::Malformed(reason, bytes) => {
                // An undeclared `xacro:` prefix is not a slip of the pen: the file is the source of a URDF.
                let fault = if reason.contains("xacro") {
                    Fault::Unexpanded {
                        what: "an element `xacro:...`".to_owned(),
                        tried: None,
                    }
                } else {
                    Fault::Xml { reason }
                };
                RobotError::new(file, fault).at(text, bytes)
            }
            xml::Fault::TooMuch(what, most, bytes) => {
                let error = RobotError::new(file, Fault::TooLarge { what, most });
                if bytes.is_empty() {
                    error
                } else {
                    error.at(text, bytes)
                }
            }
        })?;
        let source = Self {
            file,
            text,
            document,
        };
        source.check_root()?;
        Ok(source)
    }

    /// The `<robot>` element.
    pub(super) fn robot(&self) -> Node<'_, 'a> {
        self.document.root_element()
    }

    /// The links or the joints of the robot.
    pub(super) fn all(&self, tag: &'static str) -> impl Iterator<Item = Node<'_, 'a>> {
        self.robot().children().filter(move |n| n.has_tag_name(tag))
    }

    /// An error about an element, at its opening tag.
    pub(super) fn error(&self, node: Node, fault: Fault) -> RobotError {
        RobotError::new(self.file, fault)
            .at(self.text, self.opening_tag(node))
            .about(describe(node))
    }

    /// An error about an attribute of an element, at the attribute.
    pub(super) fn attribute_error(&self, node: Node, attribute: &str, fault: Fault) -> RobotError {
        match node.attribute_node(attribute) {
            Some(a) => RobotError::new(self.file, fault)
                .at(self.text, a.range())
                .about(describe(node)),
            None => self.error(node, fault),
        }
    }

    /// An error about the joint of that name.
    pub(super) fn joint_error(&self, name: &str, fault: Fault) -> RobotError {
        self.named_error("joint", name, fault)
    }

    /// An error about the link of that name.
    pub(super) fn link_error(&self, name: &str, fault: Fault) -> RobotError {
        self.named_error("link", name, fault)
    }

    /// An error about the robot as a whole.
    pub(super) fn robot_error(&self, fault: Fault) -> RobotError {
        self.error(self.robot(), fault)
    }

    /// An error about the mass properties of the link of that name: at its `<inertial>`, where it has one.
    pub(super) fn inertial_error(&self, link: &str, fault: Fault) -> RobotError {
        let inertial = self
            .all("link")
            .find(|n| n.attribute("name") == Some(link))
            .and_then(|n| child(n, "inertial"));
        match inertial {
            Some(node) => self.error(node, fault),
            None => self.link_error(link, fault),
        }
    }

    fn named_error(&self, tag: &'static str, name: &str, fault: Fault) -> RobotError {
        match self.all(tag).find(|n| n.attribute("name") == Some(name)) {
            Some(node) => self.error(node, fault),
            None => RobotError::new(self.file, fault).about(format!("{tag} `{name}`")),
        }
    }

    fn opening_tag(&self, node: Node) -> Range<usize> {
        xml::opening_tag(self.text, node)
    }

    fn check_root(&self) -> Result<(), RobotError> {
        let root = self.robot();
        if root.tag_name().name() != "robot" {
            let root_tag = root.tag_name().name().to_owned();
            return Err(self.error(root, Fault::NotUrdf { root_tag }));
        }
        let xacro = root.descendants().find(|n| {
            let namespace = n.tag_name().namespace().unwrap_or_default();
            namespace.contains("xacro")
        });
        if let Some(node) = xacro {
            let what = format!("an element `xacro:{}`", node.tag_name().name());
            return Err(
                RobotError::new(self.file, Fault::Unexpanded { what, tried: None })
                    .at(self.text, self.opening_tag(node)),
            );
        }
        Ok(())
    }

    /// Line of an element, from 1; found by counting from the top of the file.
    pub(super) fn line_of(&self, node: Node) -> usize {
        self.document.text_pos_at(node.range().start).row as usize
    }

    /// Gives remarks the lines of the links and joints that they are about.
    pub(super) fn place(&self, remarks: &mut [Remark]) {
        // Counting from the top for each of thousands of joints would take minutes.
        let breaks: Vec<usize> = self.text.match_indices('\n').map(|(at, _)| at).collect();
        let line_of = |node: Node| 1 + breaks.partition_point(|at| *at < node.range().start);
        let mut lines: HashMap<String, usize> = HashMap::new();
        for (tag, kinds) in [("link", &["link"][..]), ("joint", &["joint", "wheel"][..])] {
            for node in self.all(tag) {
                let name = node.attribute("name").unwrap_or_default();
                for kind in kinds {
                    lines.insert(format!("{kind} `{name}`"), line_of(node));
                }
            }
        }
        for remark in remarks {
            // Of ``link `base`, `<inertial>` `` the link is known.
            let outer = remark.subject.split(", `<").next().unwrap_or_default();
            remark.line = lines.get(outer).copied();
        }
    }

    /// What stands in the file and is not read, counted by tag.
    pub(super) fn ignored_elements(&self) -> Vec<Remark> {
        const READ: [(&str, &[&str]); 3] = [
            ("robot", &["link", "joint", "material"]),
            ("link", &["inertial", "collision"]),
            (
                "joint",
                &[
                    "origin",
                    "parent",
                    "child",
                    "axis",
                    "limit",
                    "dynamics",
                    "mimic",
                    "calibration",
                    "safety_controller",
                ],
            ),
        ];
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
                if !read.contains(&tag) {
                    *counts.entry((inside, tag)).or_default() += 1;
                }
            }
        }
        counts
            .into_iter()
            .map(|((inside, tag), count)| remark(format!("`<{tag}>`"), match (inside, tag) {
                    ("link", "visual") => {
                        format!("{count} in the file, not read: they show the robot, and neither weigh nor touch")
                    }
                    ("robot", _) => format!("{count} in the file, not read: settings of other programs"),
                    (inside, _) => format!("{count} in the {inside}s of the file, not read: not part of URDF"),
                }))
            .collect()
    }
}

/// The first child element of that tag.
pub(super) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.has_tag_name(tag))
}

/// ``joint `arm` ``, or ``link `base`, `<inertia>` `` for what is inside it.
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

/// Refuses names that are missing or given twice among the elements of one tag.
pub(super) fn unique_names(source: &Source, tag: &'static str) -> Result<(), RobotError> {
    let mut first: HashMap<&str, Node> = HashMap::new();
    for node in source.all(tag) {
        let Some(name) = node.attribute("name").filter(|n| !n.trim().is_empty()) else {
            let attribute = "name".to_owned();
            return Err(source.error(node, Fault::MissingAttribute { attribute }));
        };
        if let Some(taken) = first.insert(name, node) {
            let first_line = source.line_of(taken);
            let fault = Fault::DuplicateName { tag, first_line };
            return Err(source.attribute_error(node, "name", fault));
        }
    }
    Ok(())
}
