//! Finds all faults of a file, and the options with which it can be read.

use std::path::Path;

use crate::error::{Fault, Remedy, RobotError};
use crate::loaded::{self, Loaded};
use crate::model::Robot;
use crate::options::LoadOptions;
use crate::prepare::{prepare, read_text};

/// Largest number of remedies applied in sequence.
const MOST_TRIES: usize = 8;

/// The faults of a file, with a proposal.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Diagnosis {
    /// All faults found, including those that only appear after others are repaired.
    pub faults: Vec<RobotError>,
    /// Options with which the file can be read, if found.
    pub proposal: Option<LoadOptions>,
    /// The robot read with them.
    pub loaded: Option<Box<Loaded>>,
    /// Questions to the user, if no options were found.
    pub question: Option<Question>,
}

/// All open questions about a file, and the other options that are needed.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Question {
    /// The questions: remedies that need the user's choice.
    pub asked: Vec<Remedy>,
    /// The other options needed, without the answers.
    pub options: LoadOptions,
    /// The radius of the wheels with which it was tested, in metres, if that is asked for.
    pub stand_in_m: Option<f64>,
    /// A remaining obstacle for any answer, tested with plausible ones; `None` if there is none.
    pub in_the_way: Option<String>,
}

/// Finds all faults of a file, and options with which it can be read.
pub(crate) fn diagnose(
    path: &Path,
    options: &LoadOptions,
    works: impl Fn(&Robot) -> bool,
) -> Diagnosis {
    let mut first = course(path, options, RobotError::remedies);
    if let Some(other) = whatever_the_arguments(path, options, &first, &works) {
        first = other;
    }
    if let Some(other) = by_argument(path, options, &first, &works) {
        first = other;
    }
    let mut needed = first.applied.clone();
    let works_with = |remedies: &[Remedy]| {
        let loaded = loaded::read_file(path, &with(options, remedies));
        loaded.is_ok_and(|loaded| works(&loaded.robot))
    };
    let mut course_of_needed = first;
    if course_of_needed.reaches(&works) && needed.len() > 1 {
        for remedy in course_of_needed.applied.clone() {
            let rest: Vec<Remedy> = needed.iter().filter(|r| **r != remedy).cloned().collect();
            if rest.len() < needed.len() && works_with(&rest) {
                needed = rest;
            }
        }
        // Faults that only appear after an unnecessary remedy are no faults of the file.
        let argument = |remedy: &&Remedy| matches!(remedy, Remedy::Argument { .. });
        if !needed.iter().any(|remedy| argument(&remedy)) {
            let shorter = course(path, options, |_| needed.clone());
            if shorter.reaches(&works) {
                course_of_needed = shorter;
            }
        }
        course_of_needed.applied = needed;
    }
    let works = course_of_needed.reaches(&works);
    let question = match works {
        true => None,
        false => question(path, options, &mut course_of_needed),
    };
    let Course {
        mut faults,
        applied,
        loaded,
    } = course_of_needed;
    // A missing file may hold the links.
    let lacks_files = |of: &RobotError| matches!(of.fault(), Fault::MissingFiles { .. });
    if faults.iter().any(lacks_files) {
        faults.retain(|of| !matches!(of.fault(), Fault::MissingElement { child: "link" }));
    }
    Diagnosis {
        faults,
        question,
        proposal: (works && !applied.is_empty()).then(|| with(options, &applied)),
        loaded: loaded.filter(|_| works).map(Box::new),
    }
}

/// Faults and notes met between some options and others with which a file can be read.
struct Course {
    faults: Vec<RobotError>,
    applied: Vec<Remedy>,
    loaded: Option<Loaded>,
}

impl Course {
    /// Adds new faults.
    fn meets<'a>(&mut self, errors: impl IntoIterator<Item = &'a RobotError>) {
        for new in errors {
            let is_known = |known: &RobotError| known.to_string() == new.to_string();
            if !self.faults.iter().any(is_known) {
                self.faults.push(new.clone());
            }
        }
    }

    /// Whether both lead to the same robot, whatever the remarks.
    fn is_same_robot(&self, other: &Self) -> bool {
        let robot = |course: &Self| {
            let mut robot = course.loaded.as_ref()?.robot.clone();
            robot.remarks.clear();
            Some(robot)
        };
        robot(self).is_some_and(|own| robot(other) == Some(own))
    }

    fn reaches(&self, works: impl Fn(&Robot) -> bool) -> bool {
        self.loaded
            .as_ref()
            .is_some_and(|loaded| works(&loaded.robot))
    }
}

/// Searches another value of one of the file's arguments that makes the file model something
/// otherwise guessed; with the faults met without it.
fn by_argument(
    path: &Path,
    options: &LoadOptions,
    first: &Course,
    works: impl Fn(&Robot) -> bool,
) -> Option<Course> {
    /// Largest number of values tried.
    const MOST: usize = 16;
    let is_guessed = first.applied.iter().any(Remedy::is_guess);
    if first.reaches(&works) && !is_guessed {
        return None;
    }
    let safe: Vec<Remedy> = first
        .applied
        .iter()
        .filter(|r| !r.is_guess())
        .cloned()
        .collect();
    let file = path.display().to_string();
    let reading = with(options, &safe);
    let text = read_text(path, &file, &reading).ok()?;
    let choices = prepare(&text, &file, &reading).ok()?.choices;
    let each = choices.into_iter().flat_map(|(name, values)| {
        let of_name = move |value| Remedy::Argument {
            name: name.clone(),
            value: Some(value),
        };
        values.into_iter().map(of_name)
    });
    each.take(MOST).find_map(|argument| {
        let tried = argument.apply(options)?;
        let without_guess = |error: &RobotError| {
            let mut remedies = error.remedies();
            remedies.retain(|remedy| !remedy.is_guess());
            remedies
        };
        let mut found = course(path, &tried, without_guess);
        let models = found.loaded.as_ref().is_some_and(|l| l.inferred.is_none());
        (models && found.reaches(&works)).then(|| {
            found.applied.insert(0, argument);
            found.faults = first.faults.clone();
            found
        })
    })
}

/// Searches any values of arguments without values, if the robot does not depend on them, such as
/// those about a simulator.
fn whatever_the_arguments(
    path: &Path,
    options: &LoadOptions,
    first: &Course,
    works: impl Fn(&Robot) -> bool,
) -> Option<Course> {
    /// Values that represent all others: numbers, which are truth values too, on both sides of
    /// typical thresholds; and truth values that are not numbers.
    const STAND_INS: [&[&str]; 2] = [&["0", "1", "-7", "1000"], &["false", "true"]];
    let is_open = |remedy: &Remedy| matches!(remedy, Remedy::Argument { value: None, .. });
    let mut remedies = first.faults.iter().flat_map(RobotError::remedies);
    if !remedies.any(|remedy| is_open(&remedy)) {
        return None;
    }
    let with_all = |value: &str| {
        let given = |remedy: Remedy| match remedy {
            Remedy::Argument { name, value: None } => Remedy::Argument {
                name,
                value: Some(value.to_owned()),
            },
            other => other,
        };
        course(path, options, |error| {
            error.remedies().into_iter().map(given).collect()
        })
    };
    // Possible numbers are tested with numbers: as truth values all of them look alike.
    let reached = STAND_INS.iter().find_map(|values| {
        let courses: Vec<Course> = values.iter().map(|value| with_all(value)).collect();
        let reach = courses.iter().all(|course| course.reaches(&works));
        reach.then_some(courses)
    });
    let same = reached.and_then(|courses| {
        let mut courses = courses.into_iter();
        let mut one = courses.next()?;
        let same = courses.all(|other| one.is_same_robot(&other));
        // An argument that is compared with texts has specific values.
        let mut looked_at = looked_at(path, options, &one).into_iter();
        if !same || looked_at.any(|(_, values)| !values.iter().all(|of| is_truth_value(of))) {
            return None;
        }
        for fault in &mut one.faults {
            fault.say_that_any_value_does();
        }
        Some(one)
    });
    same.or_else(|| {
        // Of truth values, the one with which the file defines something that it does not with the
        // other.
        let [no, yes] = ["false", "true"].map(with_all);
        let (reaches, misses) = match (no.reaches(&works), yes.reaches(&works)) {
            (true, false) => (no, yes),
            (false, true) => (yes, no),
            _ => return None,
        };
        let is_read = [&reaches, &misses]
            .iter()
            .all(|course| are_truth_values(path, options, course));
        is_read.then_some(reaches)
    })
}

/// Returns those of the given arguments that are used in conditions, with their alternative values.
fn looked_at(path: &Path, options: &LoadOptions, course: &Course) -> Vec<(String, Vec<String>)> {
    let file = path.display().to_string();
    let reading = with(options, &course.applied);
    let prepared =
        read_text(path, &file, &reading).and_then(|text| prepare(&text, &file, &reading));
    let mut choices = prepared.map_or_else(|_| Vec::new(), |prepared| prepared.choices);
    choices.retain(|(of, _)| {
        let is_given =
            |remedy: &Remedy| matches!(remedy, Remedy::Argument { name, .. } if name == of);
        course.applied.iter().any(is_given)
    });
    choices
}

/// Whether all given arguments, except names, are truth values used in conditions.
fn are_truth_values(path: &Path, options: &LoadOptions, course: &Course) -> bool {
    let choices = looked_at(path, options, course);
    let is_one = |name: &str| {
        let mut of_name = choices.iter().filter(|(of, _)| of == name);
        of_name.any(|(_, values)| values.iter().all(|value| is_truth_value(value)))
    };
    let mut given = course.applied.iter().filter_map(|remedy| match remedy {
        Remedy::Argument {
            name,
            value: Some(value),
        } if is_truth_value(value) => Some(name),
        _ => None,
    });
    given.all(|name| is_one(name))
}

fn is_truth_value(text: &str) -> bool {
    ["0", "1", "true", "false", "True", "False"].contains(&text)
}

/// Reads a file repeatedly, each time with the first remedy for its faults that has an effect.
fn course(
    path: &Path,
    options: &LoadOptions,
    remedies: impl Fn(&RobotError) -> Vec<Remedy>,
) -> Course {
    let mut course = Course {
        faults: Vec::new(),
        applied: Vec::new(),
        loaded: None,
    };
    let mut tried = options.clone();
    for _ in 0..MOST_TRIES {
        let error = match loaded::read_file(path, &tried) {
            Ok(loaded) => {
                course.loaded = Some(loaded);
                break;
            }
            Err(error) => error,
        };
        let all = || std::iter::once(&error).chain(error.others());
        course.meets(all());
        let next = all()
            .flat_map(&remedies)
            .find_map(|remedy| Some((remedy.apply(&tried)?, remedy)));
        match next {
            Some((next, remedy)) => {
                tried = next;
                course.applied.push(remedy);
            }
            None => break,
        }
    }
    course
}

/// Collects all questions to the user: known ones get stand-ins, behind which further questions and
/// faults may appear. These faults belong to the file too, unless a stand-in for a size caused
/// them.
fn question(path: &Path, options: &LoadOptions, course: &mut Course) -> Option<Question> {
    let mut inquiry = Inquiry {
        asked: Vec::new(),
        applied: course.applied.clone(),
        tried: with(options, &course.applied),
    };
    let mut errors = course.faults.clone();
    for _ in 0..MOST_TRIES {
        if !(inquiry.asks(&errors) || inquiry.repairs(&errors)) {
            break;
        }
        let Err(error) = loaded::read_file(path, &inquiry.tried) else {
            errors.clear();
            break;
        };
        let all = std::iter::once(&error).chain(error.others());
        errors = all.cloned().collect();
        let of_the_file = |new: &&RobotError| inquiry.is_of_the_file(new);
        course.meets(errors.iter().filter(of_the_file));
    }
    let in_the_way = errors.iter().find(|error| inquiry.is_of_the_file(error));
    let in_the_way = in_the_way.or_else(|| {
        let stays = errors.first().filter(|error| inquiry.stays(path, error))?;
        course.meets([stays]);
        Some(stays)
    });
    let in_the_way = in_the_way.map(ToString::to_string);
    let mut known = with(options, &inquiry.applied);
    // The thickness of rollers in a mesh does not apply to a wheel of another size.
    if inquiry.sizes_are_open()
        && options.wheels.is_none()
        && let Some(wheels) = &mut known.wheels
    {
        wheels.roller_radius_m = None;
    }
    (!inquiry.asked.is_empty()).then_some(Question {
        options: known,
        stand_in_m: (inquiry.tried.wheel_radius_m).filter(|_| inquiry.sizes_are_open()),
        asked: inquiry.asked,
        in_the_way,
    })
}

/// A set of questions being collected.
struct Inquiry {
    asked: Vec<Remedy>,
    applied: Vec<Remedy>,
    /// Options with all remedies applied, and stand-ins for open questions.
    tried: LoadOptions,
}

impl Inquiry {
    /// Adds questions for some faults; returns whether there was a new one.
    fn asks(&mut self, errors: &[RobotError]) -> bool {
        let known = self.asked.len();
        for error in errors {
            let has_size = self.tried.wheel_radius_m.is_some();
            let is_new = |remedy: &Remedy| {
                let is_known = has_size && matches!(remedy, Remedy::WheelRadius { .. });
                remedy.is_asked() && !is_known && !self.asked.contains(remedy)
            };
            if let Some(remedy) = error.remedies().into_iter().find(is_new) {
                self.asked.push(remedy);
                let stood_in = error.fault().stood_in(&self.tried);
                self.tried = stood_in.unwrap_or_else(|| self.tried.clone());
            }
        }
        self.asked.len() > known
    }

    /// Applies the first effective remedy for some faults that guesses nothing; returns whether
    /// there was one.
    fn repairs(&mut self, errors: &[RobotError]) -> bool {
        let remedies = errors.iter().flat_map(RobotError::remedies);
        let mut safe = remedies.filter(|remedy| !remedy.is_guess());
        let next = safe.find_map(|remedy| Some((remedy.apply(&self.tried)?, remedy)));
        let Some((next, remedy)) = next else {
            return false;
        };
        self.applied.push(remedy);
        self.tried = next;
        true
    }

    /// Whether an error belongs to the file, and was not caused by a stand-in: for a size, or for a
    /// value of a xacro file.
    fn is_of_the_file(&self, error: &RobotError) -> bool {
        let is_argument = |remedy: &Remedy| matches!(remedy, Remedy::Argument { .. });
        let has_argument = self.asked.iter().any(is_argument);
        let asks_more = error.remedies().iter().any(Remedy::is_asked)
            || matches!(error.fault(), Fault::MissingFiles { .. });
        !(self.sizes_are_open() && error.fault().is_of_sizes()) && (!has_argument || asks_more)
    }

    /// Whether an error stays with other values of the requested arguments, none of which the file
    /// compares with anything.
    fn stays(&self, path: &Path, error: &RobotError) -> bool {
        const OTHERS: [&str; 3] = ["0", "true", "false"];
        let name = |remedy: &Remedy| match remedy {
            Remedy::Argument { name, .. } => Some(name.clone()),
            _ => None,
        };
        let names: Vec<String> = self.asked.iter().filter_map(name).collect();
        let file = path.display().to_string();
        let prepared =
            read_text(path, &file, &self.tried).and_then(|text| prepare(&text, &file, &self.tried));
        let are_free = prepared
            .is_ok_and(|prepared| !prepared.choices.iter().any(|(of, _)| names.contains(of)));
        let stays = |value: &&str| {
            let mut other = self.tried.clone();
            let given = names.iter().map(|name| (name.clone(), (*value).to_owned()));
            other.arguments.extend(given);
            loaded::read_file(path, &other).is_err_and(|new| new.to_string() == error.to_string())
        };
        !names.is_empty() && !self.sizes_are_open() && are_free && OTHERS.iter().all(stays)
    }

    fn sizes_are_open(&self) -> bool {
        let is_size = |remedy: &Remedy| matches!(remedy, Remedy::WheelRadius { .. });
        self.asked.iter().any(is_size)
    }
}

/// Returns options with remedies applied in order.
fn with(options: &LoadOptions, remedies: &[Remedy]) -> LoadOptions {
    remedies.iter().fold(options.clone(), |options, remedy| {
        remedy.apply(&options).unwrap_or(options)
    })
}
