//! `ilon check --update` and `--init`: rewrites bounds, or writes first ones, around the measured
//! values.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_trace::quantities::{Quantity, by_key, headlines, known_to, least_change, limits};
use ilon_trace::{Header, Summary, number, significant};
use toml_edit::{Document, InlineTable, Item, Key, Value};

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
        let [mut text, changes, left] = rewrite(&text)?;
        // Reading takes a byte order mark away.
        if std::fs::read(&file).is_ok_and(|bytes| bytes.starts_with("\u{feff}".as_bytes())) {
            text.insert(0, '\u{feff}');
        }
        Ok(Self {
            path: file,
            text,
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

/// A scenario's file with the places of its values. It is not written by the TOML library, which
/// would sort keys with dots.
fn document(text: &str) -> Result<Document<&str>, Failure> {
    let document = Document::parse(text);
    Ok(
        document
            .map_err(|error| ilon_sim::Error::invalid(error.to_string(), "correct the file"))?,
    )
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
    let (mut bounds, mut changes) = (Vec::new(), String::new());
    for quantity in headlines(summary).into_iter().chain(by_key(RATE)) {
        let Some(measured) = quantity.value(summary) else {
            continue;
        };
        let least = least_change(quantity);
        let known = known_to(quantity, measured, summary, header).max(least);
        let margin = margin * measured.abs();
        let room = known.max(margin);
        let most = match quantity.key {
            "wheel_torque_max_n_m" => strongest_n_m(header),
            key => limits(key).map(|limits| limits.most),
        };
        let Some(bound) = first_bound(quantity, measured, (room, most)) else {
            continue;
        };
        let widened = match known > margin {
            true if known == least => "; widened to its last digits".to_owned(),
            true => format!("; widened to its accuracy, {}", significant(known, 2)),
            false => String::new(),
        };
        changes.push_str(&format!(
            "         {}: {bound} (measured {}{widened})\n",
            quantity.key,
            number(significant(measured, 4))
        ));
        bounds.push(format!("{} = {bound}", quantity.key));
    }
    let end_of_line = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let mut lines: String = bounds
        .iter()
        .flat_map(|bound| [bound, end_of_line])
        .collect();
    let ended = match text.is_empty() || text.ends_with('\n') {
        true => text.to_owned(),
        false => format!("{text}{end_of_line}"),
    };
    let text = ended.as_str();
    let file = document(text)?;
    let place = match file.get("expect") {
        // Within a heading's table, directly below the heading.
        Some(Item::Table(table)) if !table.is_implicit() && !table.is_dotted() => {
            let heading = table.span().map_or(text.len(), |span| span.end);
            text[heading..].find('\n').map(|end| heading + end + 1)
        }
        // Above the first key that says `expect` itself.
        Some(Item::Table(table)) if table.is_dotted() => {
            lines = bounds
                .iter()
                .flat_map(|bound| ["expect.", bound, end_of_line])
                .collect();
            let key = file.key("expect").and_then(Key::span);
            key.map(|span| text[..span.start].rfind('\n').map_or(0, |end| end + 1))
        }
        Some(Item::Table(_)) | None => None,
        Some(_) => {
            let message = "`expect` of the scenario stands on one line";
            let help = "write it as a section, `[expect]`, with a line for each bound";
            return Err(ilon_sim::Error::invalid(message, help).into());
        }
    };
    let text = match place {
        Some(place) => format!("{}{lines}{}", &text[..place], &text[place..]),
        None => format!("{text}{end_of_line}[expect]{end_of_line}{lines}"),
    };
    Ok([text, changes, String::new()])
}

/// The limit of the strongest motor, which no torque exceeds, in N m; `None` if one has no limit.
fn strongest_n_m(header: &Header) -> Option<f64> {
    let limits = header.wheels.iter().map(|wheel| wheel.torque_limit_n_m);
    let limits: Option<Vec<f64>> = limits.collect();
    limits?.into_iter().reduce(f64::max)
}

/// A bound with some room; `None` for a share whose bound no run could exceed.
fn first_bound(
    quantity: &Quantity,
    measured: f64,
    (room, greatest): (f64, Option<f64>),
) -> Option<InlineTable> {
    let [least, most] = [
        rounded(measured - room, f64::floor),
        rounded(measured + room, f64::ceil),
    ];
    let is_two_sided = quantity.key.contains("ratio") || quantity.key == RATE;
    let limits = limits(quantity.key);
    if greatest.is_some_and(|greatest| most >= greatest) {
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

/// The file with changed bounds, the changes, and the bounds left unchanged. All else, and the side
/// of a bound that holds, stays to the byte.
fn updated(text: &str, verdicts: &[Verdict], margin: f64) -> Result<[String; 3], Failure> {
    let document = document(text)?;
    let (mut edits, mut changes, mut left) = (Vec::new(), String::new(), String::new());
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
        let expected = document.get("expect");
        let bound = name.split('.').fold(expected, |item, part| item?.get(part));
        let Some(bound) = bound.and_then(Item::as_table_like) else {
            left.push_str(&format!(
                "         {name}: a bound on its change is left: change it by hand, or save the baseline anew\n"
            ));
            continue;
        };
        let old = |key: &str| {
            let item = bound.get(key)?;
            item.as_float().or(item.as_integer().map(|old| old as f64))
        };
        let fails = |key: &str| {
            let holds = match key {
                "min" => old(key)? <= measured,
                "max" => old(key)? >= measured,
                _ => (old("equal")? - measured).abs() <= old("within").unwrap_or_default(),
            };
            bound.get(key)?.span().filter(|_| !holds)
        };
        if let Some(limits) = limits(name)
            && limits.is_certain
            && (fails("min").is_none() || measured - room <= limits.least)
            && (fails("max").is_none() || measured + room >= limits.most)
            && fails("equal").is_none()
        {
            left.push_str(&format!(
                "         {name}: no bound around {measured} could fail: change it by hand, or leave it out\n"
            ));
            continue;
        }
        for (key, new) in [
            ("min", rounded(measured - room, f64::floor)),
            ("max", rounded(measured + room, f64::ceil)),
            ("equal", measured),
            ("within", rounded(room, f64::ceil)),
        ] {
            let Some(place) = fails(key) else {
                continue;
            };
            let new = Value::from(new).to_string();
            changes.push_str(&format!(
                "         {name}.{key}: {} -> {new} (measured {})\n",
                &text[place.clone()],
                number(significant(measured, 4))
            ));
            edits.push((place, new));
        }
    }
    edits.sort_by_key(|(place, _)| place.start);
    let mut text = text.to_owned();
    for (place, new) in edits.into_iter().rev() {
        text.replace_range(place, &new);
    }
    Ok([text, changes, left])
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
            is_short: false,
            is_outside: false,
            held: false,
        }
    }

    #[test]
    fn bounds_move_around_what_was_measured_and_the_rest_of_the_file_stays() {
        let text = "# why\n[expect]\nslip_energy_j = { max = 0.009 } # joules\n\
                    twist_ratio_contact.vx = { min = 0.5, max = 0.75 }\n[run]\nduration_s = 1\n";
        let verdicts = [
            verdict("slip_energy_j", 0.012_34),
            verdict("twist_ratio_contact.vx", 1.0),
            Verdict {
                at_s: Some(0.5),
                ..verdict("truth_x_m", 1.0)
            },
        ];
        let [updated, changes, left] = updated(text, &verdicts, 0.1).expect("it is TOML");
        // 0.01234 * 1.1 = 0.013574, to three digits upwards; 1 + 0.1. The lower bound holds.
        assert_eq!(
            updated,
            "# why\n[expect]\nslip_energy_j = { max = 0.0136 } # joules\n\
             twist_ratio_contact.vx = { min = 0.5, max = 1.1 }\n[run]\nduration_s = 1\n"
        );
        assert!(
            changes.contains("slip_energy_j.max: 0.009 -> 0.0136 (measured 0.01234)"),
            "{changes}"
        );
        assert!(
            left.contains("truth_x_m: bounds on signals are left"),
            "{left}"
        );
    }

    /// Keys with dots between others, as hands write them, and the line ends of Windows.
    #[test]
    fn all_but_what_changes_stays_to_the_byte() {
        let text = "robot.file = 'a'\r\nrun.duration_s = 1\r\n  robot.x_m = 0x10 # far\r\n[expect]\r\n\
                    energy.motor_j={max=1e0}\r\nslip_energy_j = { max = 9 }\r\nenergy.outside_j = {min=-1, max=1_0}";
        let verdicts = [verdict("energy.outside_j", 20.0)];
        let [after, changes, left] = updated(text, &verdicts, 0.5).expect("it is TOML");
        assert_eq!(after, text.replace("max=1_0", "max=30.0"), "{left}");
        assert!(changes.contains("outside_j.max: 1_0 -> 30.0 "), "{changes}");

        let without = &text[..text.find("[expect]").expect("it is there")];
        let mut summary = Summary::default();
        summary.slip_energy_j = Some(1.0);
        let first =
            |text: &str| begun(text, &summary, &Header::default(), 0.1).map(|of| of[0].clone());
        let bound = "slip_energy_j = { max = 1.1 }\r\n";
        for (before, after) in [
            ("", "\r\n[expect]\r\n"),
            (
                "[expect.tolerances]\r\nx = 1",
                "[expect.tolerances]\r\nx = 1\r\n\r\n[expect]\r\n",
            ),
            ("[expect] # CI\r\n[a]\r\n", "[expect] # CI\r\n"),
            ("expect.tolerances.x = 1\r\n", "expect."),
            ("[expect]", "[expect]\r\n"),
        ] {
            let written = first(&format!("{without}{before}")).expect("it is TOML");
            let start = format!("{without}{after}");
            assert!(
                written.starts_with(&start) && written.contains(bound),
                "{written}"
            );
            assert_eq!(written.replace("\r\n", "").find('\n'), None, "{written}");
            written
                .parse::<toml_edit::DocumentMut>()
                .expect("it is TOML");
        }
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
