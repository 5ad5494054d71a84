//! `ilon check --update` and `--init`: rewrites bounds, or writes first ones, around the measured
//! values.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_trace::quantities::{Quantity, by_key, headlines, known_to, least_change, limits};
use ilon_trace::{Header, Summary, number, significant};
use toml_edit::{DocumentMut, InlineTable, Item, TableLike, value};

use crate::cli::failure::Failure;
use crate::judge::Verdict;
use crate::scenario::MAX_BYTES;

/// New bounds for a scenario's file.
pub(super) struct Update {
    path: PathBuf,
    text: String,
    /// The changes, one line each; empty if nothing changes.
    pub changes: String,
    /// Failed bounds that are not changed, with the reason, one line each.
    pub left: String,
}

impl Update {
    /// Sets every failed bound of the summary to the measured value, with a margin as a share of
    /// it. Comments and layout stay. Bounds on signals, and on figures that do not apply, are left
    /// unchanged, and named. Does not write yet.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn of(path: &Path, verdicts: &[Verdict], margin: f64) -> Result<Self, Failure> {
        Self::by(path, |text| updated(text, verdicts, margin))
    }

    /// Adds bounds to a scenario without any: on the headline figures, and on the wheels' rates,
    /// with a margin as a share of the measured value, and at least as wide as the figure's
    /// accuracy. Ratios and rates get both bounds, costs the upper one. Does not write yet.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn first(
        path: &Path,
        summary: &Summary,
        header: &Header,
        margin: f64,
    ) -> Result<Self, Failure> {
        Self::by(path, |text| begun(text, summary, header, margin))
    }

    fn by(
        path: &Path,
        rewrite: impl FnOnce(&str) -> Result<[String; 3], Failure>,
    ) -> Result<Self, Failure> {
        // The target of a link is rewritten.
        let file = path.canonicalize();
        let file = file.map_err(|source| Failure::read(path, source))?;
        let text = FileAccess::anywhere().read_text(&file, MAX_BYTES);
        let text = text.map_err(|fault| ilon_sim::Error::read(path, &fault))?;
        let [mut rewritten, changes, left] = rewrite(&text)?;
        // The TOML library writes only LF line ends.
        if text.contains("\r\n") {
            rewritten = rewritten.replace('\n', "\r\n");
        }
        Ok(Self {
            path: file,
            text: rewritten,
            changes,
            left,
        })
    }

    /// Writes the file.
    ///
    /// # Errors
    /// If it cannot be written; it is then unchanged.
    pub fn write(&self) -> Result<(), Failure> {
        if !self.changes.is_empty() {
            ilon_trace::file::write_text(&self.path, &self.text)?;
        }
        Ok(())
    }
}

fn document(text: &str) -> Result<DocumentMut, Failure> {
    let document = text.parse().map_err(|error: toml_edit::TomlError| {
        ilon_sim::Error::invalid(error.to_string(), "correct the file")
    });
    Ok(document?)
}

/// Shows a changed wheel radius or gear, which no ratio shows.
const RATE: &str = "wheel_rate_command_max_rad_s";

/// The file with first bounds, the bounds as text, and an empty text, as none is left.
fn begun(
    text: &str,
    summary: &Summary,
    header: &Header,
    margin: f64,
) -> Result<[String; 3], Failure> {
    let mut document = document(text)?;
    let mut changes = String::new();
    for quantity in headlines(summary).into_iter().chain(by_key(RATE)) {
        let Some(measured) = quantity.value(summary) else {
            continue;
        };
        let least = least_change(quantity);
        let known = known_to(quantity, measured, summary, header).max(least);
        let room = known.max(margin * measured.abs());
        let Some(bound) = first_bound(quantity, measured, room) else {
            continue;
        };
        let widened = match room == known {
            true if known == least => "; widened to its last digits".to_owned(),
            true => format!(
                "; widened to its accuracy, {} {}",
                significant(known * quantity.unit.per_si, 2),
                quantity.unit.symbol
            ),
            false => String::new(),
        };
        changes.push_str(&format!(
            "         {}: {bound} (measured {}{widened})\n",
            quantity.key,
            number(significant(measured, 4))
        ));
        let mut table = document.as_table_mut() as &mut dyn TableLike;
        let mut parts: Vec<&str> = std::iter::once("expect")
            .chain(quantity.key.split('.'))
            .collect();
        let last = parts.pop().unwrap_or_default();
        for part in parts {
            let new = || toml_edit::table();
            let Some(inner) = table.entry(part).or_insert_with(new).as_table_like_mut() else {
                return Err(ilon_sim::Error::invalid(
                    format!("`expect` of the scenario has a `{part}` that is no table"),
                    "write `[expect]` with bounds in it",
                )
                .into());
            };
            // `twist_ratio_ideal.vx` on one line, below the one heading.
            inner.set_dotted(part != "expect");
            table = inner;
        }
        table.insert(last, value(bound));
    }
    Ok([document.to_string(), changes, String::new()])
}

/// A bound with some room; `None` for a share whose bound no run could exceed.
fn first_bound(quantity: &Quantity, measured: f64, room: f64) -> Option<InlineTable> {
    let [least, most] = [
        rounded(measured - room, f64::floor),
        rounded(measured + room, f64::ceil),
    ];
    let is_two_sided = quantity.key.contains("ratio") || quantity.key == RATE;
    let limits = limits(quantity.key);
    if limits.is_some_and(|limits| most >= limits.most) {
        return None;
    }
    let mut bound = InlineTable::new();
    if is_two_sided && limits.is_none_or(|limits| least > limits.least) {
        bound.insert("min", least.into());
    }
    bound.insert("max", most.into());
    bound.fmt();
    Some(bound)
}

/// The file with changed bounds, the changes, and the bounds left unchanged.
fn updated(text: &str, verdicts: &[Verdict], margin: f64) -> Result<[String; 3], Failure> {
    let mut document = document(text)?;
    let (mut changes, mut left) = (String::new(), String::new());
    for verdict in verdicts.iter().filter(|verdict| !verdict.held) {
        let name = &verdict.quantity;
        let (Some(quantity), Some(measured)) = (by_key(name), verdict.measured) else {
            let what = match (by_key(name), verdict.measured) {
                (Some(_), _) => "does not apply to this run",
                _ => "bounds on signals are left",
            };
            left.push_str(&format!("         {name}: {what}: change it by hand\n"));
            continue;
        };
        let room = (margin * measured.abs()).max(least_change(quantity));
        if let Some(bound) = bound_of(&mut document, name) {
            if let Some(limits) = limits(name)
                && limits.is_certain
                && (bound.get("min").is_none() || measured - room <= limits.least)
                && (bound.get("max").is_none() || measured + room >= limits.most)
                && bound.get("equal").is_none()
            {
                left.push_str(&format!(
                    "         {name}: no bound around {measured} could fail: change it by hand, or leave it out\n"
                ));
                continue;
            }
            let wanted = [
                ("min", rounded(measured - room, f64::floor)),
                ("max", rounded(measured + room, f64::ceil)),
                ("equal", measured),
                ("within", rounded(room, f64::ceil)),
            ];
            for (key, new) in wanted {
                let Some(item) = bound.get_mut(key) else {
                    continue;
                };
                let old = item.to_string().trim().to_owned();
                let decor = item.as_value().map(|value| value.decor().clone());
                *item = value(new);
                if let (Some(value), Some(decor)) = (item.as_value_mut(), decor) {
                    *value.decor_mut() = decor;
                }
                changes.push_str(&format!(
                    "         {}.{key}: {old} -> {new} (measured {})\n",
                    verdict.quantity,
                    significant(measured, 4)
                ));
            }
        }
    }
    Ok([document.to_string(), changes, left])
}

/// The table of a bound, by the quantity's dotted name.
fn bound_of<'d>(document: &'d mut DocumentMut, quantity: &str) -> Option<&'d mut dyn TableLike> {
    let mut item: &mut Item = document.get_mut("expect")?;
    for part in quantity.split('.') {
        item = item.as_table_like_mut()?.get_mut(part)?;
    }
    item.as_table_like_mut()
}

/// A number to three digits, rounded away from the bounded value.
fn rounded(number: f64, away: fn(f64) -> f64) -> f64 {
    if number == 0.0 || !number.is_finite() {
        return number;
    }
    // Through text, so that 0.3 * 0.001 has no rounding digits of the product.
    let exponent = number.abs().log10().floor() as i32 - 2;
    let digits = away(number / 10f64.powi(exponent));
    format!("{digits}e{exponent}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(quantity: &str, measured: f64) -> Verdict {
        Verdict {
            quantity: quantity.to_owned(),
            bound: String::new(),
            measured: Some(measured),
            at_s: None,
            share_beyond: None,
            held: false,
        }
    }

    #[test]
    fn bounds_move_around_what_was_measured_and_the_rest_of_the_file_stays() {
        let text = "# why\n[expect]\nslip_energy_j = { max = 9.0 } # joules\n\
                    twist_ratio_contact.vx = { min = 0.5, max = 2 }\n[run]\nduration_s = 1\n";
        let verdicts = [
            verdict("slip_energy_j", 0.012_34),
            verdict("twist_ratio_contact.vx", 1.0),
            Verdict {
                at_s: Some(0.5),
                ..verdict("truth_x_m", 1.0)
            },
        ];
        let [updated, changes, left] = updated(text, &verdicts, 0.1).expect("it is TOML");
        // 0.01234 * 1.1 = 0.013574, to three digits upwards; 1 -+ 0.1.
        assert_eq!(
            updated,
            "# why\n[expect]\nslip_energy_j = { max = 0.0136 } # joules\n\
             twist_ratio_contact.vx = { min = 0.9, max = 1.1 }\n[run]\nduration_s = 1\n"
        );
        assert!(
            changes.contains("slip_energy_j.max: 9.0 -> 0.0136 (measured 0.01234)"),
            "{changes}"
        );
        assert!(
            left.contains("truth_x_m: bounds on signals are left"),
            "{left}"
        );
    }

    #[test]
    fn bounds_keep_the_least_useful_room_and_none_is_written_that_cannot_fail() {
        let text = "expect.slip_energy_j = { max = 0 }\nexpect.friction_used_max = { max = 0.5 }\nexpect.hub_ripple_m = { min = 1 }\n";
        let verdicts = [
            verdict("slip_energy_j", 1.6e-7),
            verdict("friction_used_max", 0.95),
            verdict("hub_ripple_m", 0.0),
        ];
        let [updated, _, left] = updated(text, &verdicts, 0.1).expect("it is TOML");
        // Ten of the digit shown, 0.0001 J, above what was measured; three digits upwards.
        assert!(
            updated.contains("slip_energy_j = { max = 0.00101 }"),
            "{updated}"
        );
        assert!(updated.contains("{ max = 0.5 }") && updated.contains("{ min = 1 }"));
        assert_eq!(left.matches("could fail").count(), 2, "{left}");
    }

    #[test]
    fn numbers_are_rounded_away_from_what_they_bound() {
        assert_eq!(rounded(0.012_341, f64::ceil), 0.0124);
        assert_eq!(rounded(-0.012_341, f64::floor), -0.0124);
        assert_eq!(rounded(1234.5, f64::floor), 1230.0);
        assert_eq!(rounded(0.0, f64::ceil), 0.0);
    }
}
