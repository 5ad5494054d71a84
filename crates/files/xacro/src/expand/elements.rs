//! Evaluation of elements: ordinary ones, and dispatch of xacro's own.

use std::rc::Rc;

use super::{Around, Expander, Inside, LEVELS_OF_ELEMENT, MOST_ATTRIBUTES, Result};
use crate::dom::{Attribute, Element, Node, Origin};
use crate::python::{Error, text};
use crate::scope::Scope;

impl Expander<'_> {
    /// Evaluates an ordinary element.
    pub(super) fn element(&self, element: &Element, around: &Around) -> Result<Element> {
        self.budget
            .spend_bytes(element.name_bytes())
            .map_err(self.spent(&element.origin))?;
        let mut attributes = self.attributes(element, around)?;
        let Inside {
            nodes,
            attributes: set,
        } = self.inside(element, around)?;
        for (name, value) in set {
            attributes.retain(|a| a.name != name);
            attributes.push(Attribute {
                name,
                value,
                bytes: element.origin.bytes.clone(),
            });
        }
        Ok(Element {
            name: element.name.clone(),
            attributes,
            children: nodes,
            origin: element.origin.clone(),
        })
    }

    pub(super) fn attributes(&self, element: &Element, around: &Around) -> Result<Vec<Attribute>> {
        let mut attributes = Vec::with_capacity(element.attributes.len());
        for a in &element.attributes {
            if a.name.starts_with("xacro:") {
                continue;
            }
            let value = self.kept_text(&a.value, &around.scope, &element.origin_of(&a.name))?;
            attributes.push(Attribute {
                name: a.name.clone(),
                value,
                bytes: a.bytes.clone(),
            });
        }
        Ok(attributes)
    }

    /// Evaluates a text of the result. If it names an unknown package, it is left unchanged,
    /// because meshes and settings of other programs matter only where they are used.
    pub(super) fn kept_text(
        &self,
        whole: &str,
        scope: &Rc<Scope>,
        origin: &Origin,
    ) -> Result<String> {
        let value = self.text(whole, scope);
        match value.and_then(|value| Ok(text(&value, &self.budget)?)) {
            Ok(words) => Ok(words),
            Err(e) => match e.cause() {
                Error::Package(package) => {
                    let words = format!(
                        "the folder of the package `{package}` is not known: `$(find {package})` is left as it is"
                    );
                    self.note(origin, &format!("package `{package}`"), words);
                    Ok(whole.to_owned())
                }
                _ => Err(self.error(origin, &e)),
            },
        }
    }

    /// Evaluates the content of an element.
    pub(super) fn inside(&self, element: &Element, around: &Around) -> Result<Inside> {
        let spent = self.spent(&element.origin);
        let _level = self.budget.enter(LEVELS_OF_ELEMENT).map_err(&spent)?;
        let mut inside = Inside::default();
        for node in &element.children {
            // Each line is indented by its depth.
            let indent = self.budget.depth() as u64 / 36;
            self.budget.spend(4 + indent).map_err(&spent)?;
            match node {
                Node::Element(child) => self.child(child, around, &mut inside)?,
                Node::Verbatim(text) => {
                    self.budget.spend_bytes(text.len()).map_err(&spent)?;
                    inside.nodes.push(node.clone());
                }
                Node::Text(whole) => {
                    let value = self.kept_text(whole, &around.scope, &element.origin)?;
                    inside.nodes.push(Node::Text(value.into()));
                }
            }
        }
        Ok(inside)
    }

    pub(super) fn child(
        &self,
        child: &Rc<Element>,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let prefixed = child.name.strip_prefix("xacro:");
        match prefixed.or_else(|| self.old_name(child, around)) {
            None => {
                self.look_for_old(child);
                let element = self.element(child, around)?;
                inside.nodes.push(Node::Element(Rc::new(element)));
            }
            Some("property") => self.property(child, around)?,
            Some("macro") => self.define_macro(child, around)?,
            Some("arg") => self.declare_argument(child, around)?,
            Some("include") => self.include(child, around, inside)?,
            Some("insert_block") => self.insert_block(child, around, inside)?,
            Some("element") => self.named_element(child, around, inside)?,
            Some("attribute") => {
                let name = self.words(&self.required(child, "name", around)?, child)?;
                let value = self.words(&self.required(child, "value", around)?, child)?;
                if !is_xml_name(&name) {
                    let words = format!("`<xacro:attribute>`: `{name}` is no name of an attribute");
                    return Err(self.fault(&child.origin, words));
                }
                inside.attributes.retain(|(other, _)| *other != name);
                inside.attributes.push((name, value));
                if inside.attributes.len() > MOST_ATTRIBUTES {
                    let words =
                        format!("more than {MOST_ATTRIBUTES} attributes are set on one element");
                    return Err(self.fault(&child.origin, words));
                }
            }
            Some(condition @ ("if" | "unless")) => {
                self.clues.condition(self.written(child, "value")?);
                let holds = self.yes_or_no(child, "value", false, around)?;
                if holds == (condition == "if") {
                    inside.nodes.extend(self.inside(child, around)?.nodes);
                }
            }
            Some("call") => {
                let name = self.words(&self.required(child, "macro", around)?, child)?;
                if name.is_empty() {
                    return Err(
                        self.fault(&child.origin, "`<xacro:call>`: the macro's name is empty")
                    );
                }
                let mut call = (**child).clone();
                call.attributes.retain(|a| a.name != "macro");
                self.call_macro(&call, &name, around, inside)?;
            }
            Some(name) => self.call_macro(child, name, around, inside)?,
        }
        Ok(())
    }

    /// `<xacro:element xacro:name="...">`: an element whose name is evaluated.
    pub(super) fn named_element(
        &self,
        child: &Rc<Element>,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let name = self.words(&self.required(child, "xacro:name", around)?, child)?;
        if !is_xml_name(&name) {
            return Err(self.fault(
                &child.origin,
                format!("`<xacro:element>`: `{name}` is no name of an element"),
            ));
        }
        let mut element = (**child).clone();
        element.attributes.retain(|a| a.name != "xacro:name");
        element.name = name;
        let _level = self
            .budget
            .enter(LEVELS_OF_ELEMENT)
            .map_err(self.spent(&child.origin))?;
        self.child(&Rc::new(element), around, inside)
    }
}

/// Whether a text is a valid name of an element or an attribute.
fn is_xml_name(name: &str) -> bool {
    let mut chars = name.chars();
    let starts_well = chars.next().is_some_and(|c| c.is_alphabetic() || c == '_');
    starts_well && chars.all(|c| c.is_alphanumeric() || "_-.:".contains(c))
}
