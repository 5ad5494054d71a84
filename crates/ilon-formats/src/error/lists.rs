//! What faults are about, in words.

use super::named::{CandidateJoint, MissingFile};

/// The files that are missing, each with where it is named.
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
    let rest = match files.len().saturating_sub(named.len()) {
        0 => String::new(),
        rest => format!(", and {rest} more"),
    };
    format!(
        "{} that it names cannot be found: {}{rest}",
        counted(files.len(), "file"),
        named.join(", ")
    )
}

/// The joints that were looked at for wheels, and why they are none.
pub(super) fn looked_at(looked: &[CandidateJoint]) -> String {
    const SHOWN: usize = 6;
    if looked.is_empty() {
        return String::new();
    }
    let shown: Vec<String> = looked
        .iter()
        .take(SHOWN)
        .map(|l| format!("`{}` {}", l.joint, l.reason))
        .collect();
    let rest = match looked.len().saturating_sub(SHOWN) {
        0 => String::new(),
        rest => format!("; and {rest} more"),
    };
    format!(". CandidateJoint at: {}{rest}", shown.join("; "))
}

/// `no wheels`, `1 wheel`, `2 wheels`.
pub(super) fn counted(count: usize, noun: &str) -> String {
    match count {
        0 => format!("no {noun}s"),
        1 => format!("1 {noun}"),
        count => format!("{count} {noun}s"),
    }
}

/// Names, the first of them.
pub(super) fn listed(names: &[String]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|n| format!("`{n}`")).collect();
    let mut text = shown.join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    text
}
