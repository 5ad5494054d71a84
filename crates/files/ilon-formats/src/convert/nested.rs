//! Models of SDF that lie within others: written out into the one that holds them.
//!
//! What lies in a model `m` is called `m::name` outside of it, and its poses count from the model's
//! own frame: that is written as a frame `m::__model__`, to which all poses within refer that name
//! none. A model that is merged keeps its names.

use std::path::{Path, PathBuf};

use roxmltree::Node;

use super::assembled::Assembled;
use super::malformed::of_xml;
use crate::error::{Fault, MissingFile, RobotError};
use crate::generate::elements::attribute as escaped;
use crate::model::Remark;
use crate::options::LoadOptions;
use crate::urdf::{Edit, Meshes, child, text_of};
use crate::xml;

/// Deepest model within models.
const MOST_DEPTH: usize = 8;
/// Most models that are written out.
const MOST_MODELS: usize = 200;
/// Most missing files that are listed.
const MOST_MISSING: usize = 200;
/// Most bytes that all files that are included have.
const MAX_BYTES: u64 = 16 << 20;

/// A text of SDF with the models that it includes or that lie within others written out.
pub(super) fn flattened(
    file: &str,
    text: &str,
    options: &LoadOptions,
    remarks: &mut Vec<Remark>,
) -> Result<Assembled, RobotError> {
    let own = Assembled::of_file(file, text);
    let document = xml::parse(text).map_err(|fault| of_xml(file, text, fault))?;
    let is_nested = |n: &Node| n.has_tag_name("model") || n.has_tag_name("include");
    let mut all = document.descendants().filter(is_nested);
    if !all.any(|n| n.has_tag_name("include") || model_around(n).is_some()) {
        return Ok(own);
    }
    let mut writing = Writing {
        options,
        meshes: Meshes::beside(file, options),
        out: Assembled::default(),
        models: 0,
        bytes: 0,
        missing: Vec::new(),
        remarks,
    };
    let mut done = 0;
    // Models and includes that lie in none.
    let outermost = document.descendants().filter(is_nested);
    for node in outermost.filter(|n| model_around(*n).is_none()) {
        writing.out.append(&own, done..node.range().start);
        done = node.range().end;
        if node.has_tag_name("include") {
            writing.of_world(&own, node)?;
        } else {
            writing.outermost(&own, node)?;
        }
    }
    writing.out.append(&own, done..text.len());
    match writing.missing.is_empty() {
        true => Ok(writing.out),
        false => Err(RobotError::new(
            file,
            Fault::MissingFiles {
                files: writing.missing,
            },
        )),
    }
}

/// The model that a node lies in.
fn model_around<'a, 'i>(node: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    node.ancestors().skip(1).find(|n| n.has_tag_name("model"))
}

/// Where a model is written out.
struct Place<'p> {
    /// What is before its names.
    prefix: String,
    /// The frame that its poses count from; empty of the outermost model.
    frame: String,
    /// The folder that its file lies in, where that is another than the robot's.
    folder: Option<&'p Path>,
    depth: usize,
}

struct Writing<'w> {
    options: &'w LoadOptions,
    meshes: Meshes,
    out: Assembled,
    models: usize,
    bytes: u64,
    missing: Vec<MissingFile>,
    remarks: &'w mut Vec<Remark>,
}

impl Writing<'_> {
    /// A model that lies in none, with those in it.
    fn outermost(&mut self, source: &Assembled, model: Node) -> Result<(), RobotError> {
        let tag = xml::opening_tag(&source.text, model);
        if source.text[tag.clone()].ends_with("/>") {
            self.out.append(source, model.range());
            return Ok(());
        }
        self.out.append(source, tag);
        let place = Place {
            prefix: String::new(),
            frame: String::new(),
            folder: None,
            depth: 0,
        };
        self.contents(source, model, &place)?;
        self.out.made("</model>", source, model.range().start);
        Ok(())
    }

    /// A model that a world includes, if it is there: floors and suns are not sought.
    fn of_world(&mut self, source: &Assembled, include: Node) -> Result<(), RobotError> {
        let Some((path, included)) = self.read(include) else {
            return Ok(());
        };
        let name = path.display().to_string();
        let own = Assembled::of_file(&name, &included);
        let document = xml::parse(&included).map_err(|fault| of_xml(&name, &included, fault))?;
        let Some(model) = child(document.root_element(), "model") else {
            return Ok(());
        };
        let called = text_of(include, "name").or(model.attribute("name"));
        let opening = format!("<model name=\"{}\">", escaped(called.unwrap_or("model")));
        self.out.made(&opening, source, include.range().start);
        let place = Place {
            prefix: String::new(),
            frame: String::new(),
            folder: path.parent(),
            depth: 1,
        };
        self.contents(&own, model, &place)?;
        self.out.made("</model>", source, include.range().start);
        Ok(())
    }

    /// What stands in a model.
    fn contents(
        &mut self,
        source: &Assembled,
        model: Node,
        place: &Place,
    ) -> Result<(), RobotError> {
        for node in model.children().filter(Node::is_element) {
            match node.tag_name().name() {
                "model" => self.within(source, node, node, place, place.folder)?,
                "include" => self.included(source, node, place)?,
                // That of a model within another is written with it.
                "pose" if !place.frame.is_empty() => {}
                _ => self.element(source, node, place),
            }
        }
        Ok(())
    }

    /// A model that a file of its own holds.
    fn included(
        &mut self,
        source: &Assembled,
        include: Node,
        place: &Place,
    ) -> Result<(), RobotError> {
        let Some((path, text)) = self.read(include) else {
            let what = text_of(include, "uri").unwrap_or("").to_owned();
            let at = source.origin(include.range());
            let at = at.map_or_else(String::new, |at| format!("{}:{}", at.file, at.line));
            if self.options.leave_out_missing {
                let words = format!("left out, for it is not there: `{what}` at {at}");
                self.remarks.push(Remark::new("a model", words));
            } else if self.missing.len() < MOST_MISSING {
                self.missing.push(MissingFile {
                    package: package(&what),
                    what,
                    folder: None,
                    reason: None,
                    at,
                });
            }
            return Ok(());
        };
        let name = path.display().to_string();
        let document = xml::parse(&text).map_err(|fault| of_xml(&name, &text, fault))?;
        let Some(model) = child(document.root_element(), "model") else {
            let reason = "it holds no `<model>`".to_owned();
            return Err(RobotError::new(&name, Fault::Format { reason }));
        };
        let own = Assembled::of_file(&name, &text);
        // The place of what includes stands in the including file.
        let at = include.range().start;
        self.open(source, include, model, place)
            .map_err(|reason| source.error(&name, at..at + 1, reason))?;
        let inner = self.place_of(include, model, place, path.parent());
        self.contents(&own, model, &inner)
    }

    /// A model that stands within another.
    fn within(
        &mut self,
        source: &Assembled,
        said: Node,
        model: Node,
        place: &Place,
        folder: Option<&Path>,
    ) -> Result<(), RobotError> {
        self.open(source, said, model, place)
            .map_err(|reason| source.error("", said.range(), reason))?;
        let inner = self.place_of(said, model, place, folder);
        self.contents(source, model, &inner)
    }

    /// Where a model is written out that `said` names: itself, or what includes it.
    fn place_of<'p>(
        &self,
        said: Node,
        model: Node,
        place: &Place,
        folder: Option<&'p Path>,
    ) -> Place<'p> {
        let own = text_of(said, "name").or(said.attribute("name"));
        let name = own.or(model.attribute("name")).unwrap_or("model");
        let whole = format!("{}{name}", place.prefix);
        let is_merged = said
            .attribute("merge")
            .is_some_and(|of| of == "true" || of == "1");
        Place {
            prefix: match is_merged {
                true => place.prefix.clone(),
                false => format!("{whole}::"),
            },
            frame: format!("{whole}::__model__"),
            folder,
            depth: place.depth + 1,
        }
    }

    /// Writes the frame of a model, at the pose that is said for it: by what includes it, or by
    /// itself.
    fn open(
        &mut self,
        source: &Assembled,
        said: Node,
        model: Node,
        place: &Place,
    ) -> Result<(), String> {
        self.models += 1;
        if self.models > MOST_MODELS || place.depth >= MOST_DEPTH {
            return Err(format!(
                "more than {MOST_MODELS} models, or models {MOST_DEPTH} deep within each other, are not read"
            ));
        }
        let inner = self.place_of(said, model, place, None);
        let pose = child(said, "pose").or_else(|| child(model, "pose"));
        let refers =
            pose.and_then(|pose| pose.attribute("relative_to").or(pose.attribute("frame")));
        let relative_to = match refers.filter(|frame| !frame.is_empty()) {
            Some(frame) => scoped(frame, place),
            None => place.frame.clone(),
        };
        let degrees = pose
            .and_then(|pose| pose.attribute("degrees"))
            .unwrap_or("false");
        let values = pose.and_then(|pose| pose.text()).unwrap_or("");
        let frame = format!(
            "<frame name=\"{}\"><pose relative_to=\"{}\" degrees=\"{}\">{}</pose></frame>",
            escaped(&inner.frame),
            escaped(&relative_to),
            escaped(degrees),
            escaped(values)
        );
        self.out.made(&frame, source, said.range().start);
        Ok(())
    }

    /// An element with its names and frames as they are outside of its model.
    fn element(&mut self, source: &Assembled, node: Node, place: &Place) {
        let mut edits: Vec<Edit> = Vec::new();
        let is_placed = ["link", "joint", "frame"].contains(&node.tag_name().name());
        if !place.frame.is_empty() && is_placed {
            let name = node.attribute_node("name");
            edits.extend(
                name.map(|name| (name.range_value(), escaped(&scoped(name.value(), place)))),
            );
            if child(node, "pose").is_none() {
                let tag = xml::opening_tag(&source.text, node);
                let written = &source.text[tag.clone()];
                let default = format!(
                    "<pose relative_to=\"{}\"/>",
                    escaped(&self.default_frame(node, place))
                );
                edits.push(match written.strip_suffix("/>") {
                    Some(open) => (
                        tag.clone(),
                        // The name is in it, which is written anew.
                        renamed(open, node, place)
                            + &format!(">{default}</{}>", node.tag_name().name()),
                    ),
                    None => (tag.end..tag.end, default),
                });
            }
        }
        for inner in node.descendants().filter(Node::is_element) {
            let is_own_pose =
                inner.has_tag_name("pose") && inner.parent() == Some(node) && is_placed;
            let mut names_frame = place.frame.is_empty();
            for attribute in inner.attributes() {
                // Before SDF 1.7 a pose said `frame`; an empty one names none.
                let refers = ["relative_to", "attached_to", "expressed_in", "frame"]
                    .contains(&attribute.name());
                let frame = match attribute.value() {
                    "" if is_own_pose => self.default_frame(node, place),
                    "" => continue,
                    name => scoped(name, place),
                };
                if refers && !place.frame.is_empty() {
                    edits.push((attribute.range_value(), escaped(&frame)));
                    names_frame = true;
                }
            }
            if is_own_pose && !names_frame {
                let at = inner.range().start + "<pose".len();
                let frame = escaped(&self.default_frame(node, place));
                edits.push((at..at, format!(" relative_to=\"{frame}\"")));
            }
            let names_link = node.has_tag_name("joint")
                && inner.parent() == Some(node)
                && ["parent", "child"].contains(&inner.tag_name().name());
            if let Some(text) = inner.first_child().filter(|n| n.is_text() && names_link)
                && let Some(name) = text.text().map(str::trim).filter(|name| *name != "world")
                && !place.prefix.is_empty()
            {
                edits.push((text.range(), escaped(&scoped(name, place))));
            }
            if let Some(folder) = place.folder.filter(|_| inner.has_tag_name("uri"))
                && let Some(text) = inner.first_child().filter(Node::is_text)
                && let Some(uri) = text.text().map(str::trim)
                && !uri.contains("://")
                && !Path::new(uri).is_absolute()
            {
                edits.push((
                    text.range(),
                    escaped(&absolute(folder, uri).display().to_string()),
                ));
            }
        }
        self.out.append_edited(source, node.range(), edits);
    }

    /// The frame that an element's pose counts from where it names none: of a joint its child, of a
    /// frame what it is attached to.
    fn default_frame(&self, node: Node, place: &Place) -> String {
        let named = match node.tag_name().name() {
            "joint" => text_of(node, "child"),
            "frame" => node.attribute("attached_to").filter(|of| !of.is_empty()),
            _ => None,
        };
        named.map_or_else(|| place.frame.clone(), |name| scoped(name, place))
    }

    /// The file and the text of what is included; `None` where it is not there.
    fn read(&mut self, include: Node) -> Option<(PathBuf, String)> {
        let uri = text_of(include, "uri")?.trim_end_matches('/');
        let files = &self.options.files;
        let uris = match uri.ends_with(".sdf") {
            true => vec![uri.to_owned()],
            false => vec![format!("{uri}/model.sdf"), format!("{uri}.sdf")],
        };
        let path = uris
            .iter()
            .filter_map(|uri| self.meshes.find(uri).ok())
            .find(|path| files.is_file(path))?;
        let text = files
            .read_text(&path, MAX_BYTES.saturating_sub(self.bytes))
            .ok()?;
        self.bytes += text.len() as u64;
        Some((path, text))
    }
}

/// An opening tag without its end, its name written anew.
fn renamed(open: &str, node: Node, place: &Place) -> String {
    let name = node.attribute("name").unwrap_or_default();
    let new = escaped(&scoped(name, place));
    ["\"", "'"].iter().fold(open.to_owned(), |tag, quote| {
        tag.replace(
            &format!("name={quote}{name}{quote}"),
            &format!("name={quote}{new}{quote}"),
        )
    })
}

/// The name that a model has in the file around it.
fn scoped(name: &str, place: &Place) -> String {
    match name {
        "__model__" if !place.frame.is_empty() => place.frame.clone(),
        "__model__" | "world" => name.to_owned(),
        _ => format!("{}{name}", place.prefix),
    }
}

/// The package in which an address says that a model lies.
fn package(uri: &str) -> Option<String> {
    let path = uri
        .strip_prefix("model://")
        .or(uri.strip_prefix("package://"))?;
    path.split('/').next().map(str::to_owned)
}

fn absolute(folder: &Path, uri: &str) -> PathBuf {
    let path = folder.join(uri);
    std::path::absolute(&path).unwrap_or(path)
}
