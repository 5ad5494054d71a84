//! Syntax of axes in a study, and its errors.

use serde::Deserialize;
use statrs::distribution::{ContinuousCDF, Normal};
use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

use crate::axis::{Axis, Values, along};
use crate::file::Scale;

/// An error of an axis, with its remedy.
#[derive(Debug, PartialEq)]
pub(crate) struct Wrong {
    pub message: String,
    pub help: String,
}

/// The keys of an axis written as a table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    values: Option<Vec<Value>>,
    from: Option<f64>,
    to: Option<f64>,
    steps: Option<u64>,
    scale: Option<Scale>,
    whole: Option<bool>,
    mean: Option<f64>,
    sd: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
}

const WORDS: [&str; 10] = [
    "values", "from", "to", "steps", "scale", "whole", "mean", "sd", "min", "max",
];

/// Help on the forms of an axis.
const FORMS: &str = "write a list, `[0.2, 0.4]`, a range, `{ from = 0.1, to = 0.8, steps = 8 }`, or a distribution, \
                     `{ mean = 0.6, sd = 0.05 }`";

/// Largest number of values of one axis.
const MOST_STEPS: u64 = 1_000_000;

/// A span of the text that holds an axis, with the axis or its error.
pub(crate) type SpannedAxis = (std::ops::Range<usize>, Result<Axis, Wrong>);

/// Returns all axes of a table, in the order of the text; `plain` is the same table without spans.
pub(crate) fn axes_of(table: &DeTable<'_>, plain: &Table) -> Vec<SpannedAxis> {
    let mut found = Vec::new();
    collect(table, plain, "", &mut found);
    found.sort_by_key(|(span, _)| span.start);
    found
}

fn collect(table: &DeTable<'_>, plain: &Table, above: &str, found: &mut Vec<SpannedAxis>) {
    for (name, place) in table {
        let Some(value) = plain.get(name.get_ref().as_ref()) else {
            continue;
        };
        let dot = if above.is_empty() { "" } else { "." };
        let key = format!("{above}{dot}{}", name.get_ref());
        let span = name.span().start..place.span().end.max(name.span().end);
        match (place.get_ref(), value) {
            (DeValue::Table(_), Value::Table(inner)) if inner.is_empty() => {
                found.push((
                    span,
                    Err(wrong(format!("`axes.{key}` has no values"), FORMS)),
                ));
            }
            (DeValue::Table(places), Value::Table(inner)) if !is_axis(inner) => {
                collect(places, inner, &key, found);
            }
            _ => found.push((span, axis_of(key, value))),
        }
    }
}

/// Whether a table defines the values of an axis, instead of containing further keys.
fn is_axis(table: &Table) -> bool {
    table.keys().any(|key| WORDS.contains(&key.as_str()))
}

fn wrong(message: impl Into<String>, help: impl Into<String>) -> Wrong {
    Wrong {
        message: message.into(),
        help: help.into(),
    }
}

/// Returns the axis that a key's value defines.
fn axis_of(key: String, value: &Value) -> Result<Axis, Wrong> {
    let name = format!("axes.{key}");
    let values = match value {
        Value::Array(values) => list(&name, values.clone())?,
        Value::Table(table) => {
            let written: Written = table.clone().try_into().map_err(|error: toml::de::Error| {
                wrong(format!("`{name}`: {}", error.message()), FORMS)
            })?;
            written.values(&name, table)?
        }
        _ => {
            return Err(wrong(
                format!("`{name}` is a single value, so nothing varies"),
                format!("put it below `[set]`, or {FORMS}"),
            ));
        }
    };
    Ok(Axis { key, values })
}

fn list(name: &str, values: Vec<Value>) -> Result<Values, Wrong> {
    if values.is_empty() {
        return Err(wrong(
            format!("`{name}` is an empty list, so there is no run"),
            FORMS,
        ));
    }
    for (index, value) in values.iter().enumerate() {
        if !is_finite(value) {
            return Err(wrong(
                format!("`{name}` holds {value}, which is not finite"),
                "write finite numbers",
            ));
        }
        if values[..index].contains(value) {
            return Err(wrong(
                format!("`{name}` holds {value} twice"),
                "leave one out; `repetitions` runs each point more than once",
            ));
        }
    }
    Ok(Values::List(values))
}

/// Whether all numbers in a value are finite.
fn is_finite(value: &Value) -> bool {
    match value {
        Value::Float(number) => number.is_finite(),
        Value::Array(values) => values.iter().all(is_finite),
        Value::Table(table) => table.values().all(is_finite),
        _ => true,
    }
}

impl Written {
    fn values(self, name: &str, table: &Table) -> Result<Values, Wrong> {
        let only = |form: &str, words: &[&str]| {
            let is_other = |word: &&&str| table.contains_key(**word) && !words.contains(word);
            let other = WORDS.iter().find(is_other);
            match other {
                None => Ok(()),
                Some(word) => Err(wrong(
                    format!("`{name}` is {form}, which has no `{word}`"),
                    FORMS,
                )),
            }
        };
        match self {
            Self {
                values: Some(values),
                ..
            } => {
                only("a list", &["values"])?;
                list(name, values)
            }
            Self {
                from: Some(from),
                to: Some(to),
                steps,
                scale,
                whole,
                ..
            } => {
                only("a range", &["from", "to", "steps", "scale", "whole"])?;
                let (scale, whole) = (scale.unwrap_or_default(), whole.unwrap_or_default());
                range(name, from, to, steps, scale, whole)
            }
            Self {
                mean: Some(mean),
                sd: Some(sd),
                min,
                max,
                ..
            } => {
                only("a normal distribution", &["mean", "sd", "min", "max"])?;
                normal(name, mean, sd, min, max)
            }
            _ => Err(wrong(
                format!("`{name}` is neither a list, a range nor a distribution"),
                FORMS,
            )),
        }
    }
}

pub(crate) fn range(
    name: &str,
    from: f64,
    to: f64,
    steps: Option<u64>,
    scale: Scale,
    whole: bool,
) -> Result<Values, Wrong> {
    if !(from.is_finite() && to.is_finite()) || from >= to {
        return Err(wrong(
            format!("`{name}` goes from {from} to {to}, which is not a range"),
            "let `from` be less than `to`",
        ));
    }
    if scale == Scale::Log && from <= 0.0 {
        return Err(wrong(
            format!("`{name}` begins at {from}, but `scale = \"log\"` needs numbers above 0"),
            "let it begin above 0, or leave `scale` out",
        ));
    }
    if whole && (from.fract() != 0.0 || to.fract() != 0.0) {
        return Err(wrong(
            format!("`{name}` is of whole numbers, and goes from {from} to {to}"),
            "let it begin and end at whole numbers",
        ));
    }
    match steps {
        Some(0 | 1) => {
            return Err(wrong(
                format!(
                    "`{name}` has {} steps, but a range needs two or more",
                    steps.unwrap_or(0)
                ),
                "give it 2 `steps` or more",
            ));
        }
        Some(steps) if steps > MOST_STEPS => {
            return Err(wrong(
                format!("`{name}` has {steps} steps, more than the limit of {MOST_STEPS}"),
                "take fewer",
            ));
        }
        Some(steps) if whole => {
            let at = |step: u64| along(from, to, scale, step as f64 / (steps - 1) as f64).round();
            if let Some(step) = (1..steps).find(|step| at(*step) == at(step - 1)) {
                return Err(wrong(
                    format!(
                        "`{name}` has {steps} steps, of which two come to the whole number {}",
                        at(step)
                    ),
                    "take fewer `steps`, or list the values",
                ));
            }
        }
        _ => {}
    }
    Ok(Values::Range {
        from,
        to,
        steps,
        scale,
        whole,
    })
}

fn normal(
    name: &str,
    mean: f64,
    sd: f64,
    min: Option<f64>,
    max: Option<f64>,
) -> Result<Values, Wrong> {
    let (min, max) = (
        min.unwrap_or(f64::NEG_INFINITY),
        max.unwrap_or(f64::INFINITY),
    );
    if !mean.is_finite() || !sd.is_finite() || sd <= 0.0 {
        return Err(wrong(
            format!("`{name}` has the mean {mean} and the standard deviation {sd}"),
            "give it a finite `mean`, and an `sd` above 0",
        ));
    }
    let mass = Normal::new(mean, sd).map(|normal| normal.cdf(max) - normal.cdf(min));
    // Below this, the inverse of the distribution has no digits left.
    if min >= max || mass.is_ok_and(|mass| mass < 1e-6) {
        return Err(wrong(
            format!("`{name}` has almost no probability between its bounds {min} and {max}"),
            "widen `min` and `max`, or move the `mean` between them",
        ));
    }
    Ok(Values::Normal { mean, sd, min, max })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::number_of;

    fn axis(text: &str) -> Result<Axis, Wrong> {
        let text = format!("a.b = {text}");
        let table = DeTable::parse(&text).unwrap();
        let mut found = axes_of(table.get_ref(), &text.parse().unwrap());
        assert_eq!(found.len(), 1);
        found.remove(0).1
    }

    #[test]
    fn axes_come_in_the_order_of_the_text_under_the_names_of_their_keys() {
        let text = "z.y = [1, 2]\n\"a.b.c\" = { from = 1, to = 2, steps = 2 }\n[m.n]\no = { mean = 0, sd = 1 }\n";
        let table = DeTable::parse(text).unwrap();
        let keys: Vec<String> = axes_of(table.get_ref(), &text.parse().unwrap())
            .into_iter()
            .map(|(_, axis)| axis.unwrap().key)
            .collect();
        assert_eq!(keys, ["z.y", "a.b.c", "m.n.o"]);
    }

    #[test]
    fn a_range_has_both_of_its_ends_and_even_steps_between() {
        let even = axis("{ from = 0.1, to = 0.4, steps = 4 }").unwrap();
        let values: Vec<f64> = (0..4).map(|i| number_of(&even.nth(i)).unwrap()).collect();
        assert_eq!(values, [0.1, 0.2, 0.3, 0.4]);
        let log = axis("{ from = 0.01, to = 100, steps = 5, scale = \"log\" }").unwrap();
        let values: Vec<f64> = (0..5).map(|i| number_of(&log.nth(i)).unwrap()).collect();
        assert_eq!(values, [0.01, 0.1, 1.0, 10.0, 100.0]);
        let whole = axis("{ from = 6, to = 12, steps = 3, whole = true }").unwrap();
        assert_eq!(whole.nth(1), Value::Integer(9));
    }

    #[test]
    fn shares_of_a_list_are_even_and_its_ends_belong_to_it() {
        let list = axis("[\"a\", \"b\", \"c\"]").unwrap();
        for (share, expected) in [
            (0.0, "a"),
            (0.33, "a"),
            (0.34, "b"),
            (0.67, "c"),
            (1.0, "c"),
        ] {
            assert_eq!(list.at(share).as_str(), Some(expected));
        }
        assert!(!list.is_numeric());
    }

    #[test]
    fn whole_numbers_are_drawn_with_the_same_probability() {
        let drawn = |text: &str, number: i64| {
            let axis = axis(text).unwrap();
            let shares = (0..6000).map(|draw| (f64::from(draw) + 0.5) / 6000.0);
            shares
                .filter(|share| axis.at(*share) == Value::Integer(number))
                .count()
        };
        for number in [-1, 0, 1] {
            assert_eq!(drawn("{ from = -1, to = 1, whole = true }", number), 2000);
        }
        // Uniform in the logarithm: each integer k has ln((k + 1) / k) of ln(4 / 1), so the first
        // has half of it.
        let log = "{ from = 1, to = 3, whole = true, scale = \"log\" }";
        assert_eq!(drawn(log, 1), 3000);
        let ends = axis("{ from = 1, to = 3, whole = true }").unwrap();
        assert_eq!(
            (ends.at(0.0), ends.at(1.0)),
            (Value::Integer(1), Value::Integer(3))
        );
    }

    #[test]
    fn a_normal_axis_has_the_quantiles_of_tables_and_keeps_to_its_ends() {
        let normal = axis("{ mean = 1, sd = 2 }").unwrap();
        // The quantile of 97.5 % is 1.959964 standard deviations above the mean.
        let at = |share| number_of(&normal.at(share)).unwrap();
        assert!((at(0.975) - 4.919928).abs() < 1e-5, "{}", at(0.975));
        assert!((at(0.5) - 1.0).abs() < 1e-9);
        let cut = axis("{ mean = 0.6, sd = 0.5, min = 0.1, max = 0.9 }").unwrap();
        for share in [0.0, 1e-9, 0.5, 1.0] {
            let x = number_of(&cut.at(share)).unwrap();
            assert!((0.1..=0.9).contains(&x), "{x}");
        }
        assert!(at(0.0).is_finite() && at(1.0).is_finite());
    }

    #[test_case::test_case("[]", "`axes.a.b` is an empty list, so there is no run")]
    #[test_case::test_case("[1, 2, 1]", "`axes.a.b` holds 1 twice")]
    #[test_case::test_case("0.3", "`axes.a.b` is a single value, so nothing varies")]
    #[test_case::test_case("{}", "`axes.a.b` has no values")]
    #[test_case::test_case(
        "{ from = 2, to = 1 }",
        "`axes.a.b` goes from 2 to 1, which is not a range"
    )]
    #[test_case::test_case(
        "{ from = 0, to = inf }",
        "`axes.a.b` goes from 0 to inf, which is not a range"
    )]
    #[test_case::test_case(
        "{ from = 0, to = 1, scale = \"log\" }",
        "`axes.a.b` begins at 0, but `scale = \"log\"` needs numbers above 0"
    )]
    #[test_case::test_case(
        "{ from = 0, to = 1, steps = 1 }",
        "`axes.a.b` has 1 steps, but a range needs two or more"
    )]
    #[test_case::test_case(
        "{ from = 1, to = 3, steps = 9, whole = true }",
        "`axes.a.b` has 9 steps, of which two come to the whole number 1"
    )]
    #[test_case::test_case(
        "{ from = 1, to = 10, steps = 10, scale = \"log\", whole = true }",
        "`axes.a.b` has 10 steps, of which two come to the whole number 1"
    )]
    #[test_case::test_case(
        "{ from = 0.5, to = 3, whole = true }",
        "`axes.a.b` is of whole numbers, and goes from 0.5 to 3"
    )]
    #[test_case::test_case("[0.1, inf]", "`axes.a.b` holds inf, which is not finite")]
    #[test_case::test_case("[[0.1, nan]]", "`axes.a.b` holds [0.1, nan], which is not finite")]
    #[test_case::test_case(
        "{ mean = 1, sd = 0.1, scale = \"log\" }",
        "`axes.a.b` is a normal distribution, which has no `scale`"
    )]
    #[test_case::test_case(
        "{ values = [1, 2], whole = true }",
        "`axes.a.b` is a list, which has no `whole`"
    )]
    #[test_case::test_case(
        "{ from = 1, to = 2, sd = 3 }",
        "`axes.a.b` is a range, which has no `sd`"
    )]
    #[test_case::test_case(
        "{ from = 1 }",
        "`axes.a.b` is neither a list, a range nor a distribution"
    )]
    #[test_case::test_case(
        "{ mean = 1, sd = 0 }",
        "`axes.a.b` has the mean 1 and the standard deviation 0"
    )]
    #[test_case::test_case(
        "{ mean = 1, sd = 0.1, min = 5 }",
        "`axes.a.b` has almost no probability between its bounds 5 and inf"
    )]
    fn an_axis_that_says_nothing_is_refused(text: &str, message: &str) {
        assert_eq!(axis(text).unwrap_err().message, message);
    }

    #[test]
    fn an_unknown_word_of_an_axis_is_refused_with_those_that_there_are() {
        let wrong = axis("{ from = 1, to = 2, stps = 3 }").unwrap_err();
        assert!(wrong.message.contains("stps"), "{}", wrong.message);
    }
}
