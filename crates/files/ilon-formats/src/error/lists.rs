//! Lists in messages of faults.

use super::named::{CandidateJoint, MissingFile};

/// Returns the missing files, each with the place that names it.
pub(super) fn missing(files: &[MissingFile]) -> String {
    let of = |file: &MissingFile| match (&file.package, &file.reason) {
        (Some(package), _) => {
            format!(
                "`{}` at {} (no folder of the package `{package}` is known)",
                file.what, file.at
            )
        }
        (None, Some(reason)) => format!("`{}` at {} ({reason})", file.what, file.at),
        (None, None) => format!("`{}` at {}", file.what, file.at),
    };
    let (first, more) = (files.first().map(of), files.iter().skip(1).take(5).map(of));
    let named: Vec<String> = first.into_iter().chain(more).collect();
    format!(
        "{} that it names cannot be found: {}{}",
        counted(files.len(), "file"),
        named.join(", "),
        and_more(files.len(), named.len(), ",")
    )
}

/// Returns the joints that are no wheels, with reasons.
pub(super) fn looked_at(looked: &[CandidateJoint]) -> String {
    const SHOWN: usize = 3;
    if looked.is_empty() {
        return String::new();
    }
    let shown: Vec<String> = looked
        .iter()
        .take(SHOWN)
        .map(|l| format!("`{}` {}", l.joint, l.reason))
        .collect();
    let rest = and_more(looked.len(), SHOWN, ";");
    format!(". Looked at: {}{rest}", shown.join("; "))
}

/// Returns the joints that are not among some wheels, with reasons.
pub(super) fn left_out_of(left_out: &[CandidateJoint]) -> String {
    const SHOWN: usize = 4;
    if left_out.is_empty() {
        return String::new();
    }
    let shown = left_out.iter().take(SHOWN);
    let shown: Vec<String> = shown
        .map(|of| format!("`{}` ({})", of.joint, of.reason))
        .collect();
    let rest = and_more(left_out.len(), SHOWN, "");
    format!("; left out: {}{rest}", shown.join(", "))
}

/// Returns the position of a chassis that touches the floor, by its depth in millimetres.
pub(super) fn above_floor(deep_mm: f64) -> String {
    const FLOOR: &str = "the floor on which the wheels stand";
    match deep_mm {
        deep_mm if deep_mm > 0.05 => format!("reaches {deep_mm:.1} mm below {FLOOR}"),
        deep_mm if deep_mm > 5e-4 => format!("reaches {deep_mm:.3} mm below {FLOOR}"),
        deep_mm => format!("touches {FLOOR}: it is {:.3} mm above it", deep_mm.abs()),
    }
}

/// `no wheels`, `1 wheel`, `2 wheels`.
pub(super) fn counted(count: usize, noun: &str) -> String {
    match count {
        0 => format!("no {noun}s"),
        1 => format!("1 {noun}"),
        count => format!("{count} {noun}s"),
    }
}

/// Returns the first of some names.
pub(super) fn listed(names: &[String]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|n| format!("`{n}`")).collect();
    shown.join(", ") + &and_more(names.len(), SHOWN, "")
}

/// Returns how many follow the shown ones, after a separator; nothing if all are shown.
pub(crate) fn and_more(count: usize, shown: usize, separator: &str) -> String {
    match count.saturating_sub(shown) {
        0 => String::new(),
        rest => format!("{separator} and {rest} more"),
    }
}

/// A mass, without the zeros of light parts.
pub(super) fn mass_words(mass_kg: f64) -> String {
    match mass_kg < 1e-3 {
        true => format!("{mass_kg:.3e} kg"),
        false => format!("{mass_kg:.4} kg"),
    }
}
