//! Rejects invalid studies, each fault with its place in the file.

use std::ops::Range;
use std::path::Path;

use ilon_files::FileAccess;
use ilon_files::toml::flat;
use miette::NamedSource;
use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

use crate::axis::{Axis, Values, grid_points};
use crate::axis_syntax::{axes_of, range};
use crate::base::Base;
use crate::file::{Keep, MOST_RUNS, Method, SEED, StudyFile};
use crate::row::figure_names;
use crate::sample::{MOST_SOBOL_POINTS, runs_a_point};
use ilon_sim::scenario::{Bound, Scenario, Setting, nearest, read_toml};
use ilon_sim::{Error, ScenarioFault};

/// A fault of a study's text.
fn fault(
    text: &str,
    path: &Path,
    span: Range<usize>,
    message: impl Into<String>,
    help: impl Into<String>,
) -> Error {
    let source = NamedSource::new(path.display().to_string(), text.to_owned());
    ScenarioFault::new(message, help, (source, span.into())).into()
}

/// Tried values have twelve digits, so no bracket is narrower than this share of them.
const FINEST: f64 = 1e-11;

/// Returns the span of a key in a text, or of the whole text.
fn place(text: &str, keys: &[&str]) -> Range<usize> {
    let Ok(document) = DeTable::parse(text) else {
        return 0..0;
    };
    let mut span = 0..0;
    let mut table = Some(document.get_ref());
    for key in keys {
        let found = table.and_then(|table| table.iter().find(|(name, _)| name.get_ref() == key));
        let Some((name, value)) = found else {
            break;
        };
        span = name.span();
        table = match value.get_ref() {
            DeValue::Table(inner) => Some(inner),
            _ => None,
        };
    }
    span
}

/// Reads the text of a study.
pub(crate) fn parse(text: &str, path: &Path) -> Result<StudyFile, Error> {
    read_toml(text, path)
}

/// Returns the axes of a study, in the order of its text.
pub(crate) fn axes(text: &str, path: &Path, file: &StudyFile) -> Result<Vec<Axis>, Error> {
    let refuse = |span: Range<usize>, message: String, help: &str| -> Result<Vec<Axis>, Error> {
        Err(fault(text, path, span, message, help))
    };
    let document = DeTable::parse(text);
    let written = document.as_ref().ok();
    let written = written.and_then(|document| document.get_ref().get("axes")?.get_ref().as_table());
    let found = written.map_or_else(Vec::new, |table| axes_of(table, &file.axes));
    let is_expectation = |key: &&String| key.split('.').next() == Some("expect");
    if let Some(key) = file.axes.keys().find(is_expectation) {
        return refuse(
            place(text, &["axes", key]),
            format!("`{key}` cannot be varied: expectations do not change a run"),
            "write what the runs shall keep below `[expect]` of the study",
        );
    }
    let mut axes: Vec<Axis> = Vec::new();
    for (span, axis) in found {
        let axis =
            axis.map_err(|wrong| fault(text, path, span.clone(), wrong.message, wrong.help))?;
        let key = &axis.key;
        if let Some(other) = axes.iter().find(|other| overlap(&other.key, key)) {
            return refuse(
                span,
                format!("`axes.{key}` and `axes.{}` set the same key", other.key),
                "leave one of them out",
            );
        }
        let is_replaced = |(set, _): &(String, Value)| overlap(set, key) && set.len() >= key.len();
        if let Some((set, _)) = flat(&file.set).iter().find(|one| is_replaced(one)) {
            return refuse(
                span,
                format!("`axes.{key}` replaces `set.{set}` in every run"),
                "leave one of them out",
            );
        }
        if let (Method::Grid, None, None) = (file.method, axis.count(), &file.minimise) {
            return refuse(
                span,
                format!("`axes.{key}` has no number of values, which a grid needs"),
                "give it `steps`, or draw points: `method = \"latin_hypercube\"` with `points = 100`",
            );
        }
        axes.push(axis);
    }
    Ok(axes)
}

/// Whether one key equals the other or contains it.
fn overlap(a: &str, b: &str) -> bool {
    let holds = |above: &str, below: &str| {
        below
            .strip_prefix(above)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    holds(a, b) || holds(b, a)
}

/// A study that has been read but not checked.
#[derive(Clone, Copy)]
pub(crate) struct Draft<'s> {
    /// The text of its file.
    pub text: &'s str,
    /// Path of its file.
    pub path: &'s Path,
    /// Content of the text.
    pub file: &'s StudyFile,
    /// The varied keys.
    pub axes: &'s [Axis],
    /// The varied scenarios.
    pub bases: &'s [Base],
}

impl Draft<'_> {
    fn wrong(&self, keys: &[&str], message: impl Into<String>, help: &str) -> Result<(), Error> {
        Err(fault(
            self.text,
            self.path,
            place(self.text, keys),
            message,
            help,
        ))
    }

    /// Checks the parts of a study against each other.
    pub fn check(&self) -> Result<(), Error> {
        self.scenarios()?;
        self.points()?;
        self.repetitions()?;
        self.axes()?;
        self.runs()?;
        self.questions()?;
        self.quantities()?;
        self.physics()
    }

    /// Checks that there is a scenario, and that names are unique.
    fn scenarios(&self) -> Result<(), Error> {
        let wrong = |message: String, help: &str| self.wrong(&["scenario"], message, help);
        if self.bases.is_empty() {
            let message = "`scenario` names none".to_owned();
            return wrong(message, "name the scenario that is varied");
        }
        for (index, base) in self.bases.iter().enumerate() {
            if self.bases[..index]
                .iter()
                .any(|other| other.name == base.name)
            {
                let message = format!(
                    "two scenarios have the name `{}`, so their rows could not be distinguished",
                    base.name
                );
                return wrong(message, "rename one");
            }
        }
        Ok(())
    }

    /// Checks the number of points against the method.
    fn points(&self) -> Result<(), Error> {
        let wrong = |message: String, help: &str| self.wrong(&["points"], message, help);
        match (self.file.method, self.file.points) {
            (Method::Grid, Some(_)) => wrong(
                "the points of a grid follow from its axes".to_owned(),
                "leave `points` out, or draw them: `method = \"latin_hypercube\"`",
            ),
            (Method::Grid, None) => Ok(()),
            (method, None) => {
                let word = method.word();
                let message = format!("`method = \"{word}\"` needs a number of points");
                self.wrong(&["method"], message, "add `points = 100`")
            }
            (_, Some(0)) => wrong(
                "`points` is 0: there would be no run".to_owned(),
                "draw at least one",
            ),
            (Method::Sobol | Method::SobolIndices, Some(points)) if points > MOST_SOBOL_POINTS => {
                wrong(
                    format!(
                        "`points` is {points}, but a Sobol sequence has at most {MOST_SOBOL_POINTS}"
                    ),
                    "draw fewer, or take `method = \"random\"`",
                )
            }
            (Method::LatinHypercube, Some(points)) if points > MOST_RUNS => wrong(
                format!("`points` is {points}, more than the limit of {MOST_RUNS} runs"),
                "draw fewer",
            ),
            _ => Ok(()),
        }
    }

    /// Checks that repetitions differ.
    fn repetitions(&self) -> Result<(), Error> {
        let file = self.file;
        let is_set = flat(&file.set).iter().any(|(key, _)| key == SEED);
        let varied = self.axes.iter().map(|axis| axis.key.as_str());
        let mut varied = varied.chain(file.find.as_ref().map(|find| find.key.as_str()));
        if file.repetitions > 1 && (is_set || varied.any(|key| key == SEED)) {
            let message =
                format!("`repetitions` would all be the same run, since the study gives `{SEED}`");
            let help = "leave one of the two out: each repetition has a seed of its own";
            return self.wrong(&["repetitions"], message, help);
        }
        Ok(())
    }

    /// Checks that something varies, and that the method supports these axes and their number.
    fn axes(&self) -> Result<(), Error> {
        let Self { file, axes, .. } = *self;
        if axes.is_empty() && file.find.is_none() {
            let varies_noise = file.method == Method::Random
                || (file.method == Method::Grid && file.repetitions > 1);
            if !varies_noise || file.minimise.is_some() {
                let help = "add an axis, such as `axes.world.floor.friction = [0.2, 0.4]`; noise alone is varied by `repetitions`";
                let message = "the study varies nothing".to_owned();
                return self.wrong(&["scenario"], message, help);
            }
        }
        if file.method == Method::Morris {
            let is_endless = |axis: &&Axis| matches!(axis.values, Values::Normal { min, max, .. } if !(min.is_finite() && max.is_finite()));
            if let Some(axis) = axes.iter().find(is_endless) {
                let message = format!(
                    "`axes.{}` has no ends, and `method = \"morris\"` moves each axis from one end to the other",
                    axis.key
                );
                let span = axis_place(self.text, &axis.key).unwrap_or_default();
                let help = "cut it off: give it `min` and `max`";
                return Err(fault(self.text, self.path, span, message, help));
            }
        }
        let most = match file.method {
            Method::Sobol => 256,
            Method::SobolIndices => 128,
            _ => 10_000,
        };
        if axes.len() > most {
            let message = format!(
                "`method = \"{}\"` takes {most} axes at most, and there are {}",
                file.method.word(),
                axes.len()
            );
            return self.wrong(&["method"], message, "vary fewer keys");
        }
        Ok(())
    }

    /// Checks that there are not too many runs.
    fn runs(&self) -> Result<(), Error> {
        let Self { file, axes, .. } = *self;
        let points = match (file.method, file.points) {
            (Method::Grid, _) => grid_points(axes),
            (method, points) => points
                .unwrap_or_default()
                .saturating_mul(runs_a_point(method, axes.len())),
        };
        let runs = points
            .saturating_mul(self.bases.len() as u64)
            .saturating_mul(u64::from(file.repetitions));
        if runs > MOST_RUNS {
            let message = format!("the study has {runs} runs, more than the limit of {MOST_RUNS}");
            let help = "take fewer values or points, or divide the study";
            return self.wrong(&["axes"], message, help);
        }
        Ok(())
    }

    /// Checks that the quantities of a study with or without physics exist there.
    fn physics(&self) -> Result<(), Error> {
        let file = self.file;
        let find = file.find.iter().map(|find| ("find", &find.quantity));
        let least = file
            .minimise
            .iter()
            .map(|least| ("minimise", &least.quantity));
        let asked = file.quantities.iter().map(|name| ("quantities", name));
        let bounds = file.expect.keys().map(|name| ("expect", name));
        let mut named = asked.chain(bounds).chain(find).chain(least);
        let is_of_design = |name: &str| name.starts_with("design.");
        if let Some((key, name)) = named.find(|(_, name)| is_of_design(name) == file.physics) {
            let (message, help) = match file.physics {
                true => (
                    format!("`{name}` is computed without a run, so runs do not have it"),
                    "write `physics = false`, or ask for a quantity of runs",
                ),
                false => (
                    format!("`{name}` needs runs, and there are none with `physics = false`"),
                    "ask for quantities of designs: `design.condition`, `design.speed_least_m_s`; or leave `physics` out",
                ),
            };
            return self.wrong(&[key], message, help);
        }
        if !file.physics && file.repetitions > 1 {
            let message = "`repetitions` would all be the same with `physics = false`".to_owned();
            return self.wrong(&["repetitions"], message, "leave `repetitions` out");
        }
        if !file.physics && !matches!(file.keep, Keep::None) {
            let message = "there are no traces to keep with `physics = false`".to_owned();
            return self.wrong(&["keep"], message, "leave `keep` out");
        }
        Ok(())
    }

    /// Checks `[find]` and `[minimise]`.
    fn questions(&self) -> Result<(), Error> {
        let Self {
            file, axes, bases, ..
        } = *self;
        if let Some(find) = &file.find {
            if file.minimise.is_some() {
                let message = "a study has either `[find]` or `[minimise]`, not both".to_owned();
                return self.wrong(&["minimise"], message, "make two studies of it");
            }
            if file.method != Method::Grid {
                let message = format!(
                    "`[find]` searches at each point of a grid, not of `\"{}\"`",
                    file.method.word()
                );
                return self.wrong(&["method"], message, "leave `method` and `points` out");
            }
            if let Err(refused) = range("find", find.from, find.to, None, find.scale, false) {
                return self.wrong(&["find", "from"], refused.message, &refused.help);
            }
            let finest = FINEST * find.from.abs().max(find.to.abs());
            if find.tolerance < finest {
                let message = format!(
                    "`find.tolerance` = {:e} is finer than the digits with which values are tried",
                    find.tolerance
                );
                let help = format!("take {finest:e} or more");
                return self.wrong(&["find", "tolerance"], message, &help);
            }
            if let Some(axis) = axes.iter().find(|axis| overlap(&axis.key, &find.key)) {
                let message = format!("`{}` is searched over, and an axis too", axis.key);
                return self.wrong(&["find", "key"], message, "leave the axis out");
            }
        }
        if let Some(minimise) = &file.minimise {
            if file.method != Method::Grid {
                let message = format!(
                    "`[minimise]` chooses its points itself, not by `\"{}\"`",
                    file.method.word()
                );
                return self.wrong(&["method"], message, "leave `method` and `points` out");
            }
            if bases.len() > 1 {
                let message = "`[minimise]` needs a single scenario".to_owned();
                return self.wrong(&["scenario"], message, "make a study of each");
            }
            let is_range = |axis: &Axis| matches!(axis.values, Values::Range { steps: None, .. });
            if let Some(axis) = axes.iter().find(|axis| !is_range(axis)) {
                let key = &axis.key;
                let message =
                    format!("`[minimise]` searches ranges, but `axes.{key}` is not a range");
                let help = "write it as `{ from = 0.1, to = 0.8 }`, without `steps`";
                return self.wrong(&["axes"], message, help);
            }
            for (name, bound) in &minimise.subject_to {
                if let Some(what) = objection_to(&bound.bound()) {
                    let message = format!("`minimise.subject_to.{name}` {what}");
                    return self.wrong(&["minimise", "subject_to", name.as_str()], message, BOUNDS);
                }
            }
        }
        Ok(())
    }

    /// Checks that named quantities exist, and that bounds are valid.
    fn quantities(&self) -> Result<(), Error> {
        let file = self.file;
        let known = |name: &str, keys: &[&str]| {
            let names = figure_names();
            if names.contains(&name) {
                return Ok(());
            }
            let help = match nearest(name, names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => {
                "the quantities are the numbers of `summary.json`, such as `position_error_max_m`"
                    .to_owned()
            }
        };
            let message = format!("there is no quantity `{name}`");
            self.wrong(keys, message, &help)
        };
        file.quantities
            .iter()
            .try_for_each(|name| known(name, &["quantities"]))?;
        if let Some(find) = &file.find {
            known(&find.quantity, &["find", "quantity"])?;
        }
        if let Some(minimise) = &file.minimise {
            known(&minimise.quantity, &["minimise", "quantity"])?;
            let mut names = minimise.subject_to.keys();
            names.try_for_each(|name| known(name, &["minimise", "subject_to", name]))?;
        }
        for (name, bound) in &file.expect {
            let keys = ["expect", name.as_str()];
            known(name, &keys)?;
            let wrong = |what: String, help: &str| {
                let message = format!("`expect.{name}` {what}");
                self.wrong(&keys, message, help)
            };
            if let Some(what) = objection_to(&bound.bound()) {
                return wrong(what.to_owned(), BOUNDS);
            }
            if !(bound.share > 0.0 && bound.share <= 1.0) {
                return wrong(
                    format!(
                        "has the share {}, which is not a share of the runs",
                        bound.share
                    ),
                    "write a share above 0 and up to 1, such as 0.99",
                );
            }
        }
        Ok(())
    }

    /// Checks that every set or varied key exists in each scenario and has the right type: each
    /// value of a list, and one of a range, whose values are all numbers.
    pub fn keys(&self, fixed: &[Setting], files: &FileAccess) -> Result<(), Error> {
        let Self {
            text,
            path,
            file,
            axes,
            bases,
        } = *self;
        let words = |error: Error| match error {
            Error::Scenario(fault) => (fault.message.clone(), fault.help.clone()),
            other => (other.to_string(), String::new()),
        };
        for base in bases {
            // An error of the scenario itself is reported with its own file.
            base.with(&[], files)?;
            base.with(fixed, files).map_err(|error| {
                let (message, help) = words(error);
                fault(text, path, place(text, &["set"]), message, help)
            })?;
            let tried = axes.iter().flat_map(|axis| {
                let values = match &axis.values {
                    Values::List(values) => values.clone(),
                    _ => vec![axis.at(0.5)],
                };
                let of_key = |value| (axis.key.as_str(), value, "axes");
                values.into_iter().map(of_key)
            });
            let find = file.find.as_ref();
            let searched = find.map(|find| (find.key.as_str(), Value::Float(find.to), "find"));
            for (key, value, section) in tried.chain(searched) {
                let mut settings = fixed.to_vec();
                settings.push(Setting::new(key, &value));
                // A value that a scenario rejects makes a failed run; an unknown key is an error.
                let Some((message, help)) = Scenario::misshapen(&base.text, &base.path, &settings)
                else {
                    continue;
                };
                let keys: Vec<&str> = [section].into_iter().chain(key.split('.')).collect();
                let span = match section {
                    "find" => place(text, &["find", "key"]),
                    _ => axis_place(text, key).unwrap_or_else(|| place(text, &keys)),
                };
                return Err(fault(
                    text,
                    path,
                    span,
                    format!("{message}, which `{section}` varies"),
                    help,
                ));
            }
        }
        Ok(())
    }
}

/// Help for invalid bounds.
const BOUNDS: &str = "give it `min`, `max` or both, finite and the least first";

/// Returns the error of a bound, if any.
fn objection_to(bound: &Bound) -> Option<&'static str> {
    match (bound.min, bound.max) {
        (None, None) => Some("bounds nothing"),
        (Some(min), Some(max)) if min > max => Some("can never hold"),
        (min, max) => {
            let mut ends = min.into_iter().chain(max);
            ends.any(|end| !end.is_finite()).then_some("is not finite")
        }
    }
}

/// Returns the span of an axis in the text, in any notation of its dotted key.
fn axis_place(text: &str, key: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let plain: Table = text.parse().ok()?;
    let axes = document.get_ref().get("axes")?.get_ref().as_table()?;
    let found = axes_of(axes, plain.get("axes")?.as_table()?);
    let found = found
        .into_iter()
        .find(|(_, axis)| axis.as_ref().is_ok_and(|axis| axis.key == key));
    found.map(|(span, _)| span)
}
