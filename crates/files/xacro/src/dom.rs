//! The elements of a xacro file, with their places in the text.

use std::ops::Range;
use std::rc::Rc;

use crate::xml;

/// A file with its text.
#[derive(Debug)]
pub(super) struct SourceFile {
    /// Its name in messages.
    pub(super) name: String,
    /// The folder for its relative includes.
    pub(super) folder: std::path::PathBuf,
    pub(super) text: Rc<str>,
}

/// A place in a file.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    pub(super) file: Rc<SourceFile>,
    pub(super) bytes: Range<usize>,
}

/// An element, evaluated or not.
#[derive(Clone, Debug)]
pub(super) struct Element {
    /// Its name as written, with its prefix.
    pub(super) name: String,
    pub(super) attributes: Vec<Attribute>,
    pub(super) children: Vec<Node>,
    /// Its opening tag.
    pub(super) origin: Origin,
}

/// An attribute.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    pub(super) name: String,
    pub(super) value: String,
    /// Its bytes in the file of its element.
    pub(super) bytes: Range<usize>,
}

/// The content of an element, without comments.
#[derive(Clone, Debug)]
pub(super) enum Node {
    Element(Rc<Element>),
    /// Text, with expressions in it.
    Text(Rc<str>),
    /// `<![CDATA[...]]>`, in which nothing is evaluated.
    Verbatim(Rc<str>),
}

impl Element {
    /// Size of its names in bytes, which it needs whatever its values are.
    pub(super) fn name_bytes(&self) -> usize {
        let names = self.attributes.iter().map(|a| a.name.len());
        2 * self.name.len() + names.sum::<usize>()
    }

    /// The value of an attribute.
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|a| a.name == name)?;
        Some(&found.value)
    }

    /// Returns the place of an attribute, or of the element if it is missing.
    pub(super) fn origin_of(&self, attribute: &str) -> Origin {
        let found = self.attributes.iter().find(|a| a.name == attribute);
        Origin {
            file: Rc::clone(&self.origin.file),
            bytes: found.map_or(self.origin.bytes.clone(), |a| a.bytes.clone()),
        }
    }

    /// The child elements.
    pub(super) fn elements(&self) -> impl Iterator<Item = &Rc<Element>> {
        self.children.iter().filter_map(|node| match node {
            Node::Element(element) => Some(element),
            Node::Text(_) | Node::Verbatim(_) => None,
        })
    }
}

/// A file's root element, and the declared namespaces as prefix and address.
pub(super) struct Parsed {
    pub(super) root: Element,
    pub(super) namespaces: Vec<(String, String)>,
}

/// Parses a file's elements; the error has its place.
pub(super) fn parse(file: &Rc<SourceFile>) -> Result<Parsed, xml::Fault> {
    let document = xml::parse(&file.text)?;
    let mut namespaces = Vec::new();
    let root = element(document.root_element(), file, &mut namespaces);
    Ok(Parsed { root, namespaces })
}

/// Elements nest no deeper than [`xml::MAX_DEPTH`], which `xml::parse` ensures.
fn element(
    node: roxmltree::Node,
    file: &Rc<SourceFile>,
    namespaces: &mut Vec<(String, String)>,
) -> Element {
    let text = node.document().input_text();
    let bytes = xml::opening_tag(text, node);
    declared(node, &text[bytes.clone()], namespaces);
    let name_end = text[bytes.start + 1..bytes.end]
        .find(|c: char| c.is_whitespace() || c == '>' || c == '/')
        .map_or(bytes.end, |length| bytes.start + 1 + length);
    let attributes = node
        .attributes()
        .map(|a| Attribute {
            name: text[a.range_qname()].to_owned(),
            value: a.value().to_owned(),
            bytes: a.range(),
        })
        .collect();
    let children = node
        .children()
        .filter_map(|child| {
            if child.is_element() {
                return Some(Node::Element(Rc::new(element(child, file, namespaces))));
            }
            let content = child.text().filter(|_| child.is_text())?;
            Some(if text[child.range()].starts_with("<![CDATA[") {
                Node::Verbatim(content.into())
            } else {
                Node::Text(content.into())
            })
        })
        .collect();
    Element {
        name: text[bytes.start + 1..name_end].to_owned(),
        attributes,
        children,
        origin: Origin {
            file: Rc::clone(file),
            bytes,
        },
    }
}

/// Adds the namespaces that an opening tag declares.
fn declared(node: roxmltree::Node, tag: &str, namespaces: &mut Vec<(String, String)>) {
    for (at, declaration) in tag.match_indices("xmlns:") {
        let prefix = &tag[at + declaration.len()..];
        let end = prefix.find(|c: char| c == '=' || c.is_whitespace());
        let prefix = &prefix[..end.unwrap_or(0)];
        if let Some(address) = node.lookup_namespace_uri(Some(prefix)) {
            namespaces.push((prefix.to_owned(), address.to_owned()));
        }
    }
}

/// Returns the text of an expanded file, and the origin of each of its elements, in the order of
/// their first bytes.
pub(super) fn write(
    root: &Element,
    namespaces: &[(String, String)],
) -> (String, Vec<(usize, Origin)>) {
    let mut writer = Writer {
        out: String::from("<?xml version=\"1.0\" ?>\n"),
        origins: Vec::new(),
    };
    let used: Vec<&(String, String)> = namespaces
        .iter()
        .filter(|(prefix, _)| !prefix.is_empty() && prefix != "xml" && uses(root, prefix))
        .collect();
    writer.element(root, 0, &used);
    (writer.out, writer.origins)
}

/// Whether a prefix is used anywhere.
fn uses(element: &Element, prefix: &str) -> bool {
    let with_prefix = |name: &str| {
        name.strip_prefix(prefix)
            .is_some_and(|rest| rest.starts_with(':'))
    };
    with_prefix(&element.name)
        || element.attributes.iter().any(|a| with_prefix(&a.name))
        || element.elements().any(|inner| uses(inner, prefix))
}

struct Writer {
    out: String,
    origins: Vec<(usize, Origin)>,
}

impl Writer {
    /// Writes one element per line, attributes in the order of their names.
    fn element(&mut self, element: &Element, depth: usize, namespaces: &[&(String, String)]) {
        let indent = "  ".repeat(depth);
        self.out.push_str(&indent);
        self.origins.push((self.out.len(), element.origin.clone()));
        self.out.push('<');
        self.out.push_str(&element.name);
        for (prefix, address) in namespaces {
            self.attribute(&format!("xmlns:{prefix}"), address);
        }
        let mut attributes: Vec<&Attribute> = element.attributes.iter().collect();
        attributes.sort_by(|p, q| p.name.cmp(&q.name));
        for Attribute { name, value, .. } in attributes {
            self.attribute(name, value);
        }
        let content: Vec<&Node> = element
            .children
            .iter()
            .filter(|node| !matches!(node, Node::Text(text) if text.trim().is_empty()))
            .collect();
        match content[..] {
            [] => self.out.push_str("/>\n"),
            [Node::Text(text) | Node::Verbatim(text)] => {
                self.out.push('>');
                self.out.push_str(&escaped(text.trim()));
                self.out.push_str(&format!("</{}>\n", element.name));
            }
            _ => {
                self.out.push_str(">\n");
                for node in content {
                    match node {
                        Node::Element(inner) => self.element(inner, depth + 1, &[]),
                        Node::Text(text) | Node::Verbatim(text) => {
                            self.out.push_str(&indent);
                            self.out.push_str("  ");
                            self.out.push_str(&escaped(text.trim()));
                            self.out.push('\n');
                        }
                    }
                }
                self.out.push_str(&format!("{indent}</{}>\n", element.name));
            }
        }
    }

    fn attribute(&mut self, name: &str, value: &str) {
        self.out.push_str(&format!(
            " {name}=\"{}\"",
            escaped(value).replace('"', "&quot;")
        ));
    }
}

fn escaped(text: &str) -> String {
    // Escapes in expressions can produce characters that XML does not allow.
    text.replace(
        |c: char| c < ' ' && !matches!(c, '\n' | '\t' | '\r'),
        "\u{fffd}",
    )
    .replace('&', "&amp;")
    .replace('<', "&lt;")
    .replace('>', "&gt;")
}
