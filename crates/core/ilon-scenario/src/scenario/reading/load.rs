//! Converts a file and settings to a checked [`Scenario`], and back to text.

use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use std::sync::OnceLock;

use ilon_files::keys::{self, FaultKind, KeyFault};
use ilon_files::toml::{decode, encode};
use ilon_files::{FileAccess, normal};
use miette::{NamedSource, SourceSpan};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::DeTable;

use super::setting::{Origins, SETTING, Setting, dotted_keys, merge};
use super::source::Source;
use crate::scenario::{Scenario, Tracked};
use crate::{Error, ScenarioFault};

/// The largest scenario that is read, in bytes: a schedule of a hundred thousand twists is smaller.
/// Chosen.
pub const MAX_BYTES: u64 = 16 << 20;

/// The longest description of a scenario, in characters. Chosen.
pub const MOST_ABOUT: usize = 600;

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// If the file cannot be read, is not valid TOML, or has an invalid key or value.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::load_with(path, &[])
    }

    /// Reads a scenario file with some of its keys changed.
    ///
    /// # Errors
    /// Like [`Self::load`]; a fault in a setting is shown in the setting.
    pub fn load_with(path: impl AsRef<Path>, settings: &[Setting]) -> Result<Self, Error> {
        Self::load_within(path, settings, &FileAccess::anywhere())
    }

    /// Reads a scenario file with some of its keys changed; it and all files that it names must be
    /// permitted.
    ///
    /// # Errors
    /// Like [`Self::load_with`].
    pub fn load_within(
        path: impl AsRef<Path>,
        settings: &[Setting],
        files: &FileAccess,
    ) -> Result<Self, Error> {
        let path = path.as_ref();
        Self::from_text(&read_text(path, files)?, path, settings, files)
    }

    /// The scenario of a file whose text was read before, with some of its keys changed.
    ///
    /// # Errors
    /// Like [`Self::load_with`].
    pub fn from_text(
        text: &str,
        path: &Path,
        settings: &[Setting],
        files: &FileAccess,
    ) -> Result<Self, Error> {
        let name = path.display().to_string();
        let parsed = parse(text, &name, settings);
        let mut scenario = parsed.map_err(|error| unless_foreign(error, text, &name))?;
        let stem = path.file_stem().unwrap_or_default();
        // `...toml` is a file with the name `..` and the ending `.toml`.
        if stem == "." || stem == ".." {
            return Err(Error::invalid(
                format!(
                    "a scenario cannot be called `{}`, which means another folder",
                    stem.display()
                ),
                "rename the file: its name without `.toml` is the scenario's, and that of the folder of its results",
            ));
        }
        scenario.name = stem.to_string_lossy().into_owned();
        scenario.folder = path.parent().map(PathBuf::from).unwrap_or_default();
        scenario.files = files.clone();
        Ok(scenario)
    }

    /// The structural fault of a scenario with settings, which no value repairs: an unknown key, or
    /// a value of a wrong type; and how to repair it. `None` without such a fault, whatever other
    /// faults there are.
    pub fn misshapen(text: &str, path: &Path, settings: &[Setting]) -> Option<(String, String)> {
        let name = path.display().to_string();
        let lines: Vec<String> = settings.iter().map(Setting::as_toml).collect();
        let (document, _) = merged(text, &name, &lines).ok()?;
        let faults = keys::check(&document, schema(), true).into_iter();
        let is_of_shape = |fault: &KeyFault| matches!(fault.kind, FaultKind::Key | FaultKind::Type);
        let mut misshapen = faults.filter(is_of_shape);
        misshapen.next().map(|fault| (fault.message, fault.help))
    }

    /// Reads a scenario from text; its relative paths start from `folder`.
    ///
    /// # Errors
    /// Like [`Self::load`].
    pub fn from_toml(text: &str, name: &str, folder: impl Into<PathBuf>) -> Result<Self, Error> {
        Self::from_toml_with(text, name, folder, &[], &FileAccess::anywhere())
    }

    /// Reads a scenario from text with some of its keys changed; its relative paths start from
    /// `folder`, and all files that it names must be permitted.
    ///
    /// # Errors
    /// Like [`Self::load_with`].
    pub fn from_toml_with(
        text: &str,
        name: &str,
        folder: impl Into<PathBuf>,
        settings: &[Setting],
        files: &FileAccess,
    ) -> Result<Self, Error> {
        let mut scenario = parse(text, name, settings)?;
        scenario.name = name.to_owned();
        scenario.folder = folder.into();
        scenario.files = files.clone();
        Ok(scenario)
    }

    /// The text of a scenario with some of its keys changed; the same text without changes. Its
    /// relative paths start from the current folder, and are written as absolute ones.
    ///
    /// # Errors
    /// Like [`Self::load_with`].
    pub fn text_with(text: &str, name: &str, settings: &[Setting]) -> Result<String, Error> {
        if settings.is_empty() {
            return Ok(text.to_owned());
        }
        let mut placed = parse(text, name, settings)?;
        for path in placed.paths_mut() {
            *path = std::path::absolute(&*path).unwrap_or_else(|_| path.clone());
        }
        let lines: Vec<String> = settings.iter().map(Setting::as_toml).collect();
        let (document, _) = merged(text, name, &lines)?;
        let mut table: toml::Table =
            decode(document).map_err(|error| Error::encode("the scenario", &error.message))?;
        let failed = |source: toml::ser::Error| Error::encode("the scenario", &source);
        take_texts(&mut table, &toml::Table::try_from(&placed).map_err(failed)?);
        encode(&table).map_err(failed)
    }

    /// The scenario as TOML, with every default written out, below its description as a comment.
    pub fn to_toml(&self) -> Result<String, Error> {
        let keys = encode(self).map_err(|source| Error::encode("the scenario", &source))?;
        Ok(match self.about.is_empty() {
            true => keys,
            false => format!("# {}\n\n{keys}", self.about),
        })
    }

    /// A path of the scenario, resolved from its folder.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }

    /// The same scenario for a file in another folder, with relative paths adapted if possible.
    pub fn moved_to(&self, folder: &Path) -> Self {
        let mut moved = self.clone();
        for path in moved.paths_mut() {
            let absolute = std::path::absolute(self.resolve(path));
            let there = std::path::absolute(folder);
            if let (Ok(absolute), Ok(there)) = (absolute, there) {
                *path = relative(&real_but_its_name(&absolute), &real(&there));
            }
        }
        moved.folder = folder.to_owned();
        moved
    }

    /// All files and folders that it names.
    fn paths_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let believed = self.controller.robot.as_mut();
        let map = self.world.floor.height_map.as_mut();
        std::iter::once(&mut self.robot.file)
            .chain(self.robot.packages.values_mut())
            .chain(believed.and_then(|robot| robot.file.as_mut()))
            .chain(self.reference.as_mut().and_then(Tracked::file_mut))
            .chain(self.playback.as_mut().map(|playback| &mut playback.file))
            .chain(map.map(|map| &mut map.file))
    }
}

/// Gives the texts of a table the values that another table has for the same keys.
fn take_texts(table: &mut toml::Table, from: &toml::Table) {
    for (key, value) in table {
        match (value, from.get(key)) {
            (toml::Value::Table(inner), Some(toml::Value::Table(from))) => take_texts(inner, from),
            (value @ toml::Value::String(_), Some(text @ toml::Value::String(_))) => {
                *value = text.clone();
            }
            _ => {}
        }
    }
}

/// The true location of an absolute folder, in which `..` is the folder above: links are followed
/// as far as the path exists.
fn real(folder: &Path) -> PathBuf {
    let there = folder.ancestors().find_map(|above| {
        let rest = folder.strip_prefix(above).ok()?;
        Some(above.canonicalize().ok()?.join(rest))
    });
    normal(&there.unwrap_or_else(|| folder.to_owned()))
}

/// An absolute path with the true location of its folder. A link itself is kept, because its target
/// may name files beside it.
fn real_but_its_name(path: &Path) -> PathBuf {
    match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) => real(folder).join(name),
        _ => real(path),
    }
}

/// Reads a text file of at most [`MAX_BYTES`].
///
/// # Errors
/// [`Error::Read`] if it cannot be read.
pub fn read_text(path: &Path, files: &FileAccess) -> Result<String, Error> {
    let text = files.read_text(path, MAX_BYTES);
    text.map_err(|fault| Error::read(path, &fault))
}

/// Reads another kind of TOML file: keys that `T` does not have are refused as in a scenario.
///
/// # Errors
/// For text that is not valid TOML, or has an invalid key or value, with its place.
pub fn read_toml<T: DeserializeOwned + JsonSchema>(text: &str, path: &Path) -> Result<T, Error> {
    let source = || NamedSource::new(path.display().to_string(), text.to_owned());
    let document = DeTable::parse(text).map_err(|error| Error::toml(&error, source()))?;
    let schema = schemars::schema_for!(T).to_value();
    refuse(keys::check(&document, &schema, true), |_, span| {
        (source(), span.into())
    })?;
    decode(document).map_err(|error| {
        let span = error.span.unwrap_or_default();
        Error::toml_value(&error.message, source(), span.into())
    })
}

/// Reports all faults of keys at once; `place` returns the text that holds a key, and a span in it.
fn refuse(
    faults: Vec<KeyFault>,
    place: impl Fn(&[String], Range<usize>) -> (NamedSource<String>, SourceSpan),
) -> Result<(), Error> {
    let placed = |fault: KeyFault| {
        let place = place(&fault.path, fault.span);
        ScenarioFault::new(fault.message, fault.help, place)
    };
    let mut faults = faults.into_iter().map(placed);
    let Some(mut first) = faults.next() else {
        return Ok(());
    };
    first.related = faults.collect();
    Err(first.into())
}

/// The relative path from one absolute folder to an absolute path; the path itself if they share no
/// root.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let shared = path
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .count();
    if shared == 0 {
        return path.to_owned();
    }
    let up = folder
        .components()
        .skip(shared)
        .map(|_| Component::ParentDir);
    up.chain(path.components().skip(shared)).collect()
}

/// Removes the source lines from a fault in a file that is not a scenario: an untrusted link may
/// lead anywhere, and the content may be secret.
fn unless_foreign(error: Error, text: &str, name: &str) -> Error {
    match error {
        Error::Scenario(fault) if !text.contains("robot") => {
            let is_of_file = |of: &&ScenarioFault| of.source_code.name() == name;
            let mut all = std::iter::once(&*fault).chain(&fault.related);
            let Some(fault) = all.find(is_of_file) else {
                return Error::Scenario(fault);
            };
            let before = text.get(..fault.span.offset()).unwrap_or(text);
            let line = 1 + before.matches('\n').count();
            Error::invalid(
                format!(
                    "`{name}` is not a scenario: on line {line}, {}",
                    fault.message
                ),
                "the smallest scenario is `robot.file = \"robot.urdf\"`, `twist.vx_m_s = 0.3` and `run.duration_s = 5`, each on its line",
            )
        }
        other => other,
    }
}

/// A text merged with settings, each a line of TOML, and the origin of each key.
fn merged<'t>(
    text: &'t str,
    name: &'t str,
    settings: &'t [String],
) -> Result<(Spanned<DeTable<'t>>, Origins<'t>), Error> {
    let mut document = DeTable::parse(text)
        .map_err(|error| Error::toml(&error, NamedSource::new(name, text.to_owned())))?;
    let mut origins = Origins {
        file: (name, text),
        settings: Vec::new(),
    };
    for line in settings {
        let setting = DeTable::parse(line)
            .map_err(|error| Error::toml(&error, NamedSource::new(SETTING, line.clone())))?;
        origins
            .settings
            .push((dotted_keys(setting.get_ref()), line));
        let is_list = |path: &[String]| keys::is_list(schema(), path);
        merge(
            document.get_mut(),
            setting.into_inner(),
            &mut Vec::new(),
            &is_list,
        );
    }
    Ok((document, origins))
}

/// The schema of a scenario, cached: generating it takes longer than all else here, and a thousand
/// scenarios may be read.
fn schema() -> &'static serde_json::Value {
    static SCHEMA: OnceLock<serde_json::Value> = OnceLock::new();
    SCHEMA.get_or_init(Scenario::json_schema)
}

fn parse(text: &str, name: &str, settings: &[Setting]) -> Result<Scenario, Error> {
    let lines: Vec<String> = settings.iter().map(Setting::as_toml).collect();
    let (document, origins) = merged(text, name, &lines)?;
    let place = |path: &[String], span| origins.of(path, span);
    refuse(keys::check(&document, schema(), true), place)?;
    let mut scenario: Scenario = decode(document.clone()).map_err(|error| {
        let (source, span) = origins.of(&error.path, error.span.unwrap_or_default());
        Error::toml_value(&error.message, source, span)
    })?;
    scenario.about = about(text);
    let changed = origins.settings.iter().map(|(keys, _)| keys.clone());
    scenario.source = Source::of(name, text, changed.collect());
    scenario.world.floor.fill();
    scenario.object().map_err(|objection| {
        // A missing key may be added at the head of the file.
        let place = objection.place(document.get_ref());
        let (path, span) = place.unwrap_or_default();
        let place = origins.of(&path, span);
        Error::from(ScenarioFault::new(objection.message, objection.help, place))
    })?;
    Ok(scenario)
}

/// The first paragraph of the comment at the head of a text, in one line. Notes of ilon itself
/// begin with `#:`.
fn about(text: &str) -> String {
    let is_no_word_of_it = |line: &&str| line.is_empty() || line.starts_with("#:");
    let lines = text.lines().map(str::trim).skip_while(is_no_word_of_it);
    let comment = lines.map_while(|line| line.strip_prefix('#'));
    let paragraph = comment.map(str::trim).take_while(|line| !line.is_empty());
    let words: Vec<&str> = paragraph.flat_map(str::split_whitespace).collect();
    let whole = words.join(" ");
    whole
        .chars()
        .filter(|c| !c.is_control())
        .take(MOST_ABOUT)
        .collect()
}

#[cfg(test)]
mod tests;
