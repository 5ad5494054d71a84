//! The page of a study: converts its rows and findings for [`crate::sweep`].

use crate::sweep::{self, Quantity, Run, Sensitivity, StudyInput, Varied};
use ilon_sweep::{
    Column, Findings, Question, Row, Scale, Status, Study, Values, number_of, text_of,
};

use crate::answers::sweep::{answers, tables, trade_offs, words};

/// Returns the page; `command` returns the command that repeats a run.
pub fn html(
    study: &Study,
    rows: &[Row],
    findings: &Findings,
    command: &dyn Fn(u64) -> String,
) -> String {
    sweep::html(&shown(study, rows, findings), command)
}

fn shown(study: &Study, rows: &[Row], findings: &Findings) -> StudyInput {
    let columns = study.columns().iter().enumerate();
    let varied: Vec<Varied> = columns
        .map(|(index, column)| varied(study, rows, index, column))
        .collect();
    let quantities = study.quantities().iter().map(|name| Quantity {
        name: with_unit(name),
        bound: bound(study, name).map(|bound| bound * unit_of(name).1),
    });
    let file = study.file();
    StudyInput {
        name: study.name().to_owned(),
        facts: facts(study, findings),
        answers: answers(study, findings),
        quantities: quantities.collect(),
        runs: rows.iter().map(|row| run(study, row, &varied)).collect(),
        varied: varied.into_iter().map(|of| named(study, of)).collect(),
        sensitivity: sensitivity(findings),
        tables: tables(study, findings),
        trade: trade(study, findings),
        is_sample: file.method != ilon_sweep::Method::Grid || file.minimise.is_some(),
    }
}

/// Returns the first two costs of a study with one varied key that pull apart along it.
fn trade(study: &Study, findings: &Findings) -> Option<([usize; 2], usize, f64)> {
    let mut trades = trade_offs(&findings.ranges, study);
    let (trade, None) = (trades.next()?, trades.next()) else {
        return None;
    };
    let index = |name: &String| study.quantities().iter().position(|known| known == name);
    let [first, second] = trade.apart?;
    let mut columns = study.columns().iter();
    let key = columns.position(|column| column.key == trade.key)?;
    Some(([index(&first)?, index(&second)?], key, trade.best))
}

/// Returns the unit in which a quantity is shown, and how many of it are one SI unit.
fn unit_of(quantity: &str) -> (&'static str, f64) {
    let known = ilon_trace::quantities::by_key(quantity);
    known.map_or(("", 1.0), |known| (known.unit.symbol, known.unit.per_si))
}

/// Returns the words of a quantity with the unit in which it is shown.
fn with_unit(quantity: &str) -> String {
    match unit_of(quantity).0 {
        "" => words(quantity),
        unit => format!("{}, in {unit}", words(quantity)),
    }
}

/// Returns the values of a varied column with this index.
fn varied(study: &Study, rows: &[Row], index: usize, column: &Column) -> Varied {
    let find = study.file().find.as_ref();
    let find = find.filter(|find| find.key == column.key);
    let axis = study.axes().iter().find(|axis| axis.key == column.key);
    let scale = match (find, axis.map(|axis| &axis.values)) {
        (Some(find), _) => find.scale,
        (None, Some(Values::Range { scale, .. })) => *scale,
        _ => Scale::Linear,
    };
    let mut words: Vec<String> = Vec::new();
    if !column.is_numeric {
        for row in rows {
            let word = row.values.get(index).map(text_of).unwrap_or_default();
            if !words.contains(&word) {
                words.push(word);
            }
        }
    }
    Varied {
        key: column.key.clone(),
        words,
        is_log: scale == Scale::Log,
    }
}

/// Replaces the texts of a column by short distinct names.
fn named(study: &Study, mut varied: Varied) -> Varied {
    let axis = study.axes().iter().find(|axis| axis.key == varied.key);
    if let Some(Values::List(values)) = axis.map(|axis| &axis.values) {
        for word in &mut varied.words {
            if let Some(value) = values.iter().find(|value| text_of(value) == *word) {
                *word = study.name_of(&varied.key, value);
            }
        }
    }
    varied
}

/// Returns a row for display: a value that is no number becomes its index among the column's texts.
fn run(study: &Study, row: &Row, varied: &[Varied]) -> Run {
    let place = |(value, varied): (&toml::Value, &Varied)| {
        let among = || varied.words.iter().position(|word| *word == text_of(value));
        let number = number_of(value).filter(|_| varied.words.is_empty());
        number.unwrap_or_else(|| among().unwrap_or(0) as f64)
    };
    let figure = |name: &String| {
        let figure = row.figure(ilon_sweep::figure_index(name)?)?;
        Some(figure * unit_of(name).1)
    };
    Run {
        run: row.run,
        scenario: study.task_of(row).scenario,
        values: row.values.iter().zip(varied).map(place).collect(),
        figures: study.quantities().iter().map(figure).collect(),
        has_failed: row.status == Status::Failed,
    }
}

/// Returns the bound of a quantity in a study.
fn bound(study: &Study, quantity: &str) -> Option<f64> {
    let file = study.file();
    let sought = file
        .find
        .as_ref()
        .filter(|find| find.quantity == quantity)
        .map(|find| find.crosses);
    let expected = file
        .expect
        .get(quantity)
        .and_then(|bound| bound.max.or(bound.min));
    let kept = file
        .minimise
        .as_ref()
        .and_then(|minimise| minimise.subject_to.get(quantity));
    sought
        .or(expected)
        .or(kept.and_then(|bound| bound.max.or(bound.min)))
}

fn facts(study: &Study, findings: &Findings) -> Vec<String> {
    let names: Vec<&str> = study.scenario_names().collect();
    let how = match study.question() {
        Question::Table { .. } => {
            format!("points by {}", study.file().method.word().replace('_', " "))
        }
        Question::Find(find) => format!("search along {}", find.key),
        Question::Minimise(_) => "search for a minimum".to_owned(),
    };
    vec![
        format!("scenario {}", names.join(", ")),
        how,
        format!("{} runs", findings.runs),
        format!("seed {}", study.file().seed),
        format!("ilon {}", findings.ilon),
    ]
}

fn sensitivity(findings: &Findings) -> Vec<Sensitivity> {
    let indices = findings.indices.iter().map(|one| Sensitivity {
        title: format!("{}, {}", words(&one.quantity), one.scenario),
        caption: format!(
            "Sobol indices of {} base points: the share of the variance that an axis causes. Lines are where they lie with 95 %.",
            one.base_points
        ),
        names: ["by itself".to_owned(), "with all others".to_owned()],
        bars: (one.axes.iter())
            .map(|axis| {
                let bar = |interval: &ilon_sweep::findings::sensitivity::Interval| {
                    (interval.value, Some((interval.low, interval.high)))
                };
                (axis.key.clone(), [bar(&axis.first), bar(&axis.total)])
            })
            .collect(),
    });
    let effects = findings.effects.iter().map(|one| Sensitivity {
        title: format!("{}; {}", with_unit(&one.quantity), one.scenario),
        caption: "Elementary effects after Morris: by how much the quantity changes over the whole axis. Where the second bar is as \
                  long as the first, the effect bends or depends on other axes."
            .to_owned(),
        names: ["mean magnitude".to_owned(), "deviation".to_owned()],
        bars: (one.axes.iter())
            .filter_map(|axis| {
                let bars = [axis.mean_magnitude?, axis.deviation.unwrap_or(0.0)];
                let per_si = unit_of(&one.quantity).1;
                Some((axis.key.clone(), bars.map(|bar| (bar * per_si, None))))
            })
            .collect(),
    });
    indices.chain(effects).collect()
}
