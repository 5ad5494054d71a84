//! Columns of numbers for a terminal.

use std::fmt;

use ilon_trace::{Quantity, Summary};

use super::escape::{one_line, sentence};

/// Rows of a name, numbers and a unit, under headings.
#[derive(Debug, Default)]
pub(super) struct Table {
    lines: Vec<Line>,
}

#[derive(Debug)]
enum Line {
    Heading(String),
    /// The heads of columns, which do not widen them beyond their longest word.
    Heads(Vec<String>),
    Row {
        name: String,
        values: Vec<String>,
        unit: String,
    },
}

/// A column: its heading, and its text for one item.
pub(super) type Column<'c, T> = (&'c str, &'c dyn Fn(&T) -> String);

impl Table {
    pub fn new() -> Self {
        Self::default()
    }

    pub fn heading(&mut self, text: &str) {
        self.lines.push(Line::Heading(sentence(text)));
    }

    /// Adds a table of text with its headings.
    pub fn of(&mut self, table: &ilon_report::page::Table) {
        self.heading(&table.title);
        let heads = table.head.iter().skip(1);
        self.heads(heads.map(String::as_str));
        for row in &table.rows {
            if let Some((name, words)) = row.split_first() {
                self.words(name, words);
            }
        }
    }

    /// Adds the headings of columns, and one row per named item.
    pub fn columns<'n, T>(
        &mut self,
        columns: &[Column<'_, T>],
        things: impl IntoIterator<Item = (&'n str, T)>,
    ) {
        self.heads(columns.iter().map(|(name, _)| *name));
        for (name, thing) in things {
            let cells: Vec<String> = columns.iter().map(|(_, cell)| cell(&thing)).collect();
            self.words(name, &cells);
        }
    }

    fn heads<'h>(&mut self, heads: impl Iterator<Item = &'h str>) {
        let heads = heads.map(|head| one_line(head).into_owned());
        self.lines.push(Line::Heads(heads.collect()));
    }

    /// Adds a row of one number; a dash if it does not apply.
    pub fn row(&mut self, name: &str, value: Option<f64>, decimals: usize, unit: &str) {
        self.row_of(name, &[value], decimals, unit);
    }

    /// Adds a row for each quantity of a run, in its display unit; a dash if it does not apply.
    pub fn quantities<'q>(
        &mut self,
        quantities: impl IntoIterator<Item = &'q Quantity>,
        summary: &Summary,
    ) {
        for quantity in quantities {
            let value = quantity.shown(summary);
            self.row_of(
                quantity.label,
                &[value],
                quantity.decimals,
                quantity.unit.symbol,
            );
        }
    }

    /// Adds a row of several numbers; dashes for those that do not apply.
    pub fn row_of(&mut self, name: &str, values: &[Option<f64>], decimals: usize, unit: &str) {
        let values = values
            .iter()
            .map(|value| match value {
                Some(value) => unsigned_zero(format!("{value:.decimals$}")),
                None => "-".to_owned(),
            })
            .collect();
        self.lines.push(Line::Row {
            name: one_line(name).into_owned(),
            values,
            unit: unit.to_owned(),
        });
    }

    /// Adds a row of text, some of which may be numbers.
    pub fn words(&mut self, name: &str, words: &[String]) {
        let shown = |word: &String| unsigned_zero(one_line(word).into_owned());
        self.lines.push(Line::Row {
            name: one_line(name).into_owned(),
            values: words.iter().map(shown).collect(),
            unit: String::new(),
        });
    }
}

/// The words of a text in lines of at most this many characters, or of one word.
fn folded_to(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Removes the sign of a zero, with or without a unit.
fn unsigned_zero(text: String) -> String {
    let number = text.split(' ').next().unwrap_or_default();
    let is_zero = number.chars().all(|c| matches!(c, '-' | '0' | '.'));
    match text.strip_prefix('-') {
        Some(digits) if is_zero && number.len() > 1 => digits.to_owned(),
        _ => text,
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rows = || {
            self.lines.iter().filter_map(|line| match line {
                Line::Row { name, values, .. } => Some((name, values)),
                Line::Heading(_) | Line::Heads(_) => None,
            })
        };
        let heads = || {
            self.lines.iter().filter_map(|line| match line {
                Line::Heads(heads) => Some(heads),
                _ => None,
            })
        };
        let longest_word = |head: &String| {
            let words = head.split(' ').map(|word| word.chars().count());
            words.max().unwrap_or(0)
        };
        let name_width = rows()
            .map(|(name, _)| name.chars().count())
            .max()
            .unwrap_or(0);
        let columns = rows().map(|(_, values)| values.len()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns)
            .map(|column| {
                let values = rows().filter_map(|(_, values)| values.get(column));
                let values = values.map(|value| value.chars().count());
                let of_heads = heads().filter_map(|heads| heads.get(column));
                values.chain(of_heads.map(longest_word)).max().unwrap_or(0)
            })
            .collect();
        for (index, line) in self.lines.iter().enumerate() {
            match line {
                Line::Heading(text) => {
                    if index > 0 {
                        writeln!(f)?;
                    }
                    writeln!(f, "{text}")?;
                }
                Line::Heads(heads) => {
                    let folded = heads.iter().zip(&widths);
                    let folded: Vec<Vec<String>> = folded
                        .map(|(head, width)| folded_to(head, *width))
                        .collect();
                    let tall = folded.iter().map(Vec::len).max().unwrap_or(0);
                    for line in (0..tall).rev() {
                        let mut text = format!("  {:name_width$}", "");
                        for (lines, width) in folded.iter().zip(&widths) {
                            // The last line of each stands in the last of all.
                            let index = lines.len().checked_sub(line + 1);
                            let word = index.map_or("", |index| lines[index].as_str());
                            text.push_str(&format!("  {word:>width$}"));
                        }
                        writeln!(f, "{}", text.trim_end())?;
                    }
                }
                Line::Row { name, values, unit } => {
                    let mut text = format!("  {name:name_width$}");
                    for (value, width) in values.iter().zip(&widths) {
                        text.push_str(&format!("  {value:>width$}"));
                    }
                    if !unit.is_empty() {
                        text.push_str(&format!(" {unit}"));
                    }
                    writeln!(f, "{}", text.trim_end())?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A head of several words stands above its column in as many lines as its values are narrow.
    #[test]
    fn heads_stand_above_their_columns() {
        let mut table = Table::new();
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
        table.of(&ilon_report::page::Table {
            title: "causes".to_owned(),
            head: words(&["cause", "apart by up to", "at"]),
            rows: vec![words(&["the push", "1 mm", "5.02 s"])],
        });
        assert_eq!(
            table.to_string(),
            "causes\n            apart\n            by up\n               to      at\n  the push   1 mm  5.02 s\n"
        );
    }

    #[test]
    fn a_zero_has_no_sign() {
        let texts = ["-0.000 deg", "-0.00", "-0.01 deg", "-", "-x"];
        let shown = texts.map(|text| unsigned_zero(text.to_owned()));
        assert_eq!(shown, ["0.000 deg", "0.00", "-0.01 deg", "-", "-x"]);
    }

    #[test]
    fn names_stay_in_their_line() {
        let mut table = Table::new();
        table.heading("a\nb");
        table.row("c\u{1b}[2J", Some(1.0), 0, "m");
        table.words("d", &["e\n::error::f".to_owned()]);
        assert_eq!(
            table.to_string(),
            "a\\nb\n  c\\u{1b}[2J              1 m\n  d           e\\n::error::f\n"
        );
    }

    #[test]
    fn columns_line_up_and_what_does_not_apply_is_a_dash() {
        let mut table = Table::new();
        table.heading("slip");
        table.row("energy", Some(12.345), 2, "J");
        table.row("odometry drift", None, 2, "m");
        table.row("side drift", Some(-0.001), 2, "m");
        assert_eq!(
            table.to_string(),
            "slip\n  energy          12.35 J\n  odometry drift      - m\n  side drift       0.00 m\n"
        );
    }
}
