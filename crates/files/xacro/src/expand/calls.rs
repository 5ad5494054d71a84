//! Definitions, calls and insertions of macros and blocks.

use std::rc::Rc;

use super::names::namespace;
use super::{Around, Expander, Inside, LEVELS_OF_ELEMENT, Result};
use crate::dom::{Element, Node};
use crate::macros::{Macro, Macros, Parameter, parameters};
use crate::python::number;
use crate::scope::{Entry, Scope};

impl Expander<'_> {
    pub(super) fn define_macro(&self, element: &Rc<Element>, around: &Around) -> Result<()> {
        let name = self.written(element, "name")?;
        if name == "call" || name.contains('.') {
            return Err(self.fault(
                &element.origin_of("name"),
                format!("`{name}` is no name of a macro: `call` and names with dots are taken"),
            ));
        }
        let name = name.strip_prefix("xacro:").unwrap_or(name);
        self.defined.borrow_mut().insert(name.to_owned());
        around.macros.define(Macro {
            name: name.to_owned(),
            body: Rc::clone(element),
            parameters: parameters(element.attribute("params").unwrap_or_default()),
        });
        Ok(())
    }

    pub(super) fn call_macro(
        &self,
        call: &Element,
        name: &str,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let depths = self.depths();
        let called = self.expand_call(call, name, around, inside);
        let subject = format!("`<{}>`", call.name);
        self.or_without(&call.origin, &subject, called, depths)
    }

    pub(super) fn expand_call(
        &self,
        call: &Element,
        name: &str,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let resolved = around
            .macros
            .resolve(name)
            .and_then(|(found, macros, path)| {
                let scope = namespace(self, &around.scope, &path)?;
                Some((found, macros, scope))
            });
        let Some((found, macros, outer_scope)) = resolved else {
            return self.unknown_macro(call, name, around);
        };
        self.called.borrow_mut().insert(found.name.clone());
        let scope = Scope::new(Some(outer_scope), false);
        // A call looks up names in all surrounding scopes, and copies parameters with their
        // defaults.
        let texts = found.parameters.iter().map(Parameter::bytes);
        let bytes = texts.sum::<usize>() + call.name_bytes();
        let lookups = 1 + scope.depth() / 4 + found.parameters.len() as u64;
        let paid = self.budget.spend(lookups);
        paid.and_then(|()| self.budget.spend_bytes(bytes))
            .map_err(self.spent(&call.origin))?;
        let within = Around {
            macros: Macros::new(Some(macros)),
            scope,
        };
        self.calls
            .borrow_mut()
            .push((found.name.clone(), call.origin.clone()));
        let _level = self
            .budget
            .enter(LEVELS_OF_ELEMENT)
            .map_err(self.spent(&call.origin))?;
        self.pass_parameters(call, &found, around, &within.scope)?;
        let body = self.macro_body(&found, &within)?;
        self.calls.borrow_mut().pop();
        inside.nodes.extend(body.nodes);
        Ok(())
    }

    pub(super) fn macro_body(&self, found: &Macro, within: &Around) -> Result<Inside> {
        // The attributes of the definition are evaluated again at each call, though not used; its
        // parameters contain what is only known inside.
        self.inside(&found.body, within)
    }

    /// Returns the xacro name of an element without prefix, as until 2014, if such elements are
    /// accepted.
    pub(super) fn old_name<'e>(&self, element: &'e Element, around: &Around) -> Option<&'e str> {
        /// Elements of URDF, whatever macros are called, and what is missed by name if it is lost.
        const MEANT: &str = "property link joint inertial material sensor transmission";
        let name = element.name.as_str();
        let is_old = match name {
            "if" | "unless" => element.attribute("value").is_some(),
            "insert_block" => true,
            // Elements of other programs may share a macro's name: `<sensor type="ray">`.
            _ => {
                let called = || around.macros.resolve(name);
                is_old_definition(element)
                    || called().is_some_and(|(found, ..)| fits(element, &found))
            }
        };
        if is_old && !self.settings.before_2014 && !MEANT.split(' ').any(|meant| meant == name) {
            self.unprefixed.borrow_mut().insert(name.to_owned());
        }
        if !is_old || !self.settings.before_2014 {
            return None;
        }
        if self.old.borrow().is_none() {
            let words = "elements without the prefix `xacro:` are read as until 2014".to_owned();
            self.note(&element.origin, &format!("`<{name}>`"), words);
            self.look_for_old(element);
        }
        Some(name)
    }

    /// Remembers the first definition in the syntax until 2014, for error messages about missing
    /// names.
    pub(super) fn look_for_old(&self, element: &Element) {
        let is_old = is_old_definition(element);
        let mut old = self.old.borrow_mut();
        if is_old && old.is_none() {
            *old = Some((element.name.clone(), element.origin.clone()));
        }
    }

    pub(super) fn unknown_macro(&self, call: &Element, name: &str, around: &Around) -> Result<()> {
        if !self.missing.borrow().is_empty() {
            // It may be defined in a missing file.
            let words = "left out, for nothing that could be read defines this macro".to_owned();
            self.note(&call.origin, &format!("`<{}>`", call.name), words);
            return Ok(());
        }
        if let Some((tag, origin)) = &*self.old.borrow() {
            let words = format!(
                "there is no macro `{name}`: `<{tag}>` stands without the prefix `xacro:` here, as it did until 2014, and is not read"
            );
            return Err(self.fault(origin, words));
        }
        let names = around.macros.names();
        let known = if names.is_empty() {
            "no macro is defined here".to_owned()
        } else {
            let shown: Vec<String> = names.iter().take(12).map(|n| format!("`{n}`")).collect();
            format!("defined are {}", shown.join(", "))
        };
        Err(self.fault(&call.origin, format!("there is no macro `{name}`: {known}")))
    }

    /// Sets a macro's parameters: attributes, blocks, forwarded names, defaults.
    pub(super) fn pass_parameters(
        &self,
        call: &Element,
        found: &Macro,
        around: &Around,
        scope: &Rc<Scope>,
    ) -> Result<()> {
        let mut open = found.parameters.clone();
        for a in &call.attributes {
            let Some(at) = open.iter().position(|p| p.name == a.name) else {
                return Err(self.fault(
                    &call.origin_of(&a.name),
                    format!("the macro `{}` has no parameter `{}`", found.name, a.name),
                ));
            };
            open.remove(at);
            let value = self
                .text(&a.value, &around.scope)
                .map_err(|e| self.error(&call.origin_of(&a.name), &e))?;
            self.clues.named(&a.name, &a.value);
            self.clues
                .parameter(self.settings, &found.name, &a.name, number(&value));
            scope.set(a.name.clone(), value, false);
        }
        // Blocks are evaluated at the call, and again where they are inserted.
        let inside = self.inside(call, around)?;
        let mut blocks = inside.nodes.into_iter().filter_map(|node| match node {
            Node::Element(element) => Some(element),
            Node::Text(_) | Node::Verbatim(_) => None,
        });
        for parameter in open.iter().filter(|p| p.name.starts_with('*')) {
            let Some(block) = blocks.next() else {
                return Err(self.fault(
                    &call.origin,
                    format!(
                        "the macro `{}` takes a block `{}`, which is not given",
                        found.name, parameter.name
                    ),
                ));
            };
            scope.put(parameter.name.clone(), Entry::Block(block));
        }
        if let Some(block) = blocks.next() {
            return Err(self.fault(
                &block.origin,
                format!(
                    "the macro `{}` takes no block `<{}>`",
                    found.name, block.name
                ),
            ));
        }
        open.retain(|p| !p.name.starts_with('*'));
        let mut undefined = Vec::new();
        for parameter in open {
            let forwarded = if parameter.forwarded {
                self.resolve(&around.scope, &parameter.name)
                    .map_err(|e| self.error(&call.origin, &e))?
            } else {
                None
            };
            let value = match (forwarded, &parameter.default) {
                (Some(value), _) => value,
                (None, Some(default)) => self
                    .text(default, &around.scope)
                    .map_err(|e| self.error(&call.origin, &e))?,
                (None, None) => {
                    undefined.push(format!("`{}`", parameter.name));
                    continue;
                }
            };
            scope.set(parameter.name, value, false);
        }
        if !undefined.is_empty() {
            return Err(self.fault(
                &call.origin,
                format!(
                    "the macro `{}` takes {}, which {} not given",
                    found.name,
                    undefined.join(", "),
                    if undefined.len() == 1 { "is" } else { "are" }
                ),
            ));
        }
        Ok(())
    }

    pub(super) fn insert_block(
        &self,
        element: &Element,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let name = self.written(element, "name")?;
        self.budget
            .spend(1 + around.scope.depth() / 8)
            .map_err(self.spent(&element.origin))?;
        let block = |stars: &str| match around.scope.find(&format!("{stars}{name}")) {
            Some((_, Entry::Block(block))) => Some(block),
            _ => None,
        };
        if let Some(block) = block("**") {
            inside.nodes.extend(self.inside(&block, around)?.nodes);
        } else if let Some(block) = block("*") {
            let inserted = self.element(&block, around)?;
            inside.nodes.push(Node::Element(Rc::new(inserted)));
        } else {
            return Err(self.fault(&element.origin, format!("there is no block `{name}`")));
        }
        Ok(())
    }
}

/// Whether an element without prefix is a xacro definition as until 2014.
fn is_old_definition(element: &Element) -> bool {
    let has = |attribute| element.attribute(attribute).is_some();
    match element.name.as_str() {
        // A property without a name had no effect.
        "property" => has("name") && !matches!(element.attribute("name"), Some("")),
        "macro" => has("name"),
        "include" => has("filename"),
        _ => false,
    }
}

/// Whether an element can be a call of a macro: it sets its parameters, and nothing else.
fn fits(element: &Element, called: &Macro) -> bool {
    let is_given = |p: &Parameter| element.attribute(&p.name).is_some();
    let may_be_left_out =
        |p: &Parameter| p.name.starts_with('*') || p.forwarded || p.default.is_some();
    let parameters = &called.parameters;
    let mut attributes = element.attributes.iter();
    attributes.all(|a| parameters.iter().any(|p| p.name == a.name))
        && parameters.iter().all(|p| is_given(p) || may_be_left_out(p))
}

/// Returns the scope of a macro's caller: the surrounding one, without namespaces.
pub(super) fn outer(scope: &Rc<Scope>) -> Option<Rc<Scope>> {
    let mut outer = scope.parent.clone()?;
    if !scope.is_namespace {
        while outer.is_namespace {
            outer = outer.parent.clone()?;
        }
    }
    Some(outer)
}
