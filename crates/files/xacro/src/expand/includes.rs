//! Included files.

use std::any::Any;
use std::path::Path;
use std::rc::Rc;

use super::faults::MOST_LISTED;
use super::{Around, Expander, Inside, LEVELS_OF_ELEMENT, MOST_FILES, Result};
use crate::dom::{Element, Origin, Parsed, SourceFile};
use crate::python::{Error, Value};
use crate::scope::Scope;
use crate::{MAX_FILE_BYTES, Missing};

impl Expander<'_> {
    pub(super) fn include(
        &self,
        element: &Element,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let written = self.written(element, "filename")?;
        let optional = self.yes_or_no(element, "optional", false, around)?;
        let within = match self.attribute(element, "ns", around)? {
            None => around.clone(),
            Some(name) => {
                let name = self.words(&name, element)?;
                let scope = Scope::new(Some(Rc::clone(&around.scope)), true);
                self.scopes.borrow_mut().push(Rc::clone(&scope));
                let value: Rc<dyn Any> = Rc::clone(&scope) as Rc<dyn Any>;
                around
                    .scope
                    .set(name.clone(), Value::Namespace(value), false);
                Around {
                    scope,
                    macros: around.macros.add_namespace(&name),
                }
            }
        };
        let origin = element.origin_of("filename");
        let name = match self.text(written, &around.scope) {
            Ok(name) => self.words(&name, element)?,
            Err(e) => match e.cause() {
                Error::Package(package) => {
                    let (what, package) = (written.to_owned(), Some(package.clone()));
                    if !optional {
                        self.miss_include(&origin, what, package, String::new());
                    }
                    return Ok(());
                }
                _ => return Err(self.error(&origin, &e)),
            },
        };
        for path in self.included_files(&name, &origin) {
            match self.host.read_text(&path, MAX_FILE_BYTES) {
                Ok(text) => {
                    let depths = self.depths();
                    let included = self.include_file(&path, text, &origin, &within, inside);
                    let subject = format!("include `{name}`");
                    self.or_without(&origin, &subject, included, depths)?;
                }
                Err(_) if optional => {}
                Err(fault) => {
                    let reason = match fault.is_missing {
                        true => String::new(),
                        false => fault.reason,
                    };
                    self.miss_include(&origin, name.clone(), None, reason);
                }
            }
        }
        Ok(())
    }

    pub(super) fn miss_include(
        &self,
        origin: &Origin,
        what: String,
        package: Option<String>,
        reason: String,
    ) {
        let words = match (&package, reason.as_str()) {
            (Some(package), _) => {
                format!("left out, for the folder of the package `{package}` is not known")
            }
            (None, "") => "left out, for there is no such file".to_owned(),
            (None, reason) => format!("left out: {reason}"),
        };
        self.note(origin, &format!("include `{what}`"), words);
        // Lines are counted for those alone that are listed.
        if self.missing.borrow().len() == MOST_LISTED {
            return;
        }
        self.miss(Missing {
            what,
            package,
            reason,
            at: self.line(origin),
        });
    }

    /// Returns the files of an include: one, or those that match a pattern in its last part.
    pub(super) fn included_files(&self, name: &str, origin: &Origin) -> Vec<std::path::PathBuf> {
        let path = self.folder().join(name);
        if !name.contains(['*', '?', '[']) {
            return vec![path];
        }
        let (Some(folder), Some(pattern)) = (path.parent(), path.file_name()) else {
            return Vec::new();
        };
        let pattern = pattern.to_string_lossy().into_owned();
        let names = self.host.names_in(folder, MOST_FILES);
        let found: Vec<_> = names
            .iter()
            .filter(|name| matches_pattern(name, &pattern))
            .map(|name| folder.join(name))
            .collect();
        if found.is_empty() {
            let words = "no file matches the pattern".to_owned();
            self.note(origin, &format!("include `{name}`"), words);
        }
        found
    }

    pub(super) fn include_file(
        &self,
        path: &Path,
        text: String,
        origin: &Origin,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let _level = self
            .budget
            .enter(16 * LEVELS_OF_ELEMENT)
            .map_err(self.spent(origin))?;
        let file = Rc::new(SourceFile {
            name: path.display().to_string(),
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            text: text.into(),
        });
        let Parsed { root, namespaces } = self.parse(&file)?;
        self.add_namespaces(namespaces);
        self.reading.borrow_mut().push(file);
        // Its root's attributes are evaluated, though not used.
        let included = self
            .attributes(&root, around)
            .and_then(|_| self.inside(&root, around));
        let included = included.map_err(|mut failure| {
            if failure.trail.len() < 8 {
                failure
                    .trail
                    .push(format!("included at {}", self.line(origin)));
            }
            failure
        })?;
        self.reading.borrow_mut().pop();
        inside.nodes.extend(included.nodes);
        Ok(())
    }
}

/// Whether a file name matches a pattern of `*`, `?` and `[...]`. A leading dot must be matched
/// explicitly.
fn matches_pattern(name: &str, pattern: &str) -> bool {
    if name.starts_with('.') && !pattern.starts_with('.') {
        return false;
    }
    let (name, pattern): (Vec<char>, Vec<char>) =
        (name.chars().collect(), pattern.chars().collect());
    // Possible end positions of each part of the pattern in the name, part by part: no
    // backtracking, however many stars there are.
    let mut ends = vec![false; name.len() + 1];
    ends[0] = true;
    let mut at = 0;
    while at < pattern.len() {
        let mut next = vec![false; name.len() + 1];
        match pattern[at] {
            '*' => {
                let mut reached = false;
                for (i, end) in ends.iter().enumerate() {
                    reached = reached || *end;
                    next[i] = reached;
                }
                at += 1;
            }
            '[' => {
                let from = at + 2 + usize::from(pattern.get(at + 1) == Some(&'!'));
                let close = (from..pattern.len()).find(|&i| pattern[i] == ']');
                let (set, after) = match close {
                    Some(close) => (&pattern[at + 1..close], close + 1),
                    None => (&pattern[at..=at], at + 1),
                };
                for i in 0..name.len() {
                    next[i + 1] = ends[i] && in_set(name[i], set);
                }
                at = after;
            }
            c => {
                for i in 0..name.len() {
                    next[i + 1] = ends[i] && (c == '?' || c == name[i]);
                }
                at += 1;
            }
        }
        ends = next;
    }
    ends[name.len()]
}

fn in_set(c: char, set: &[char]) -> bool {
    let (negated, set) = match set {
        ['!', set @ ..] => (true, set),
        set => (false, set),
    };
    let mut i = 0;
    let mut found = false;
    while i < set.len() {
        if i + 2 < set.len() && set[i + 1] == '-' {
            found = found || (set[i]..=set[i + 2]).contains(&c);
            i += 3;
        } else {
            found = found || set[i] == c;
            i += 1;
        }
    }
    found != negated
}
