//! Tables of numbers in files of unknown origin, and what messages may show of them.
//!
//! An untrusted study or scenario may name any file as a log. Its content is shown only as far as
//! it is a log: column names above rows of numbers, and cells that could be numbers.

mod table;

pub use table::{Column, MOST_ROWS, Table, TableFormat};

/// The largest part of a name or value that a message quotes, in characters. Chosen.
const QUOTED: usize = 40;

/// The beginning of a text of any length, on one line.
pub fn quoted(text: &str) -> String {
    let mut letters = text.chars().filter(|letter| !letter.is_control());
    let beginning: String = letters.by_ref().take(QUOTED).collect();
    match letters.next() {
        Some(_) => beginning + "...",
        None => beginning,
    }
}

/// A cell that should be a number: shown if it has only characters of numbers, dates and times,
/// otherwise replaced by `text`.
fn cell(text: &str) -> String {
    let of_numbers = |letter: char| letter.is_ascii_digit() || "+-.,:eE ".contains(letter);
    // "inf" is a number too.
    match text.chars().all(of_numbers) || text.parse::<f64>().is_ok() {
        true => format!("\"{}\"", quoted(text)),
        false => "text".to_owned(),
    }
}

/// Whether two successive lines are the head of a log: names without a number, and a row in which
/// most filled cells are numbers, at least two of them.
fn is_head_of_log(
    names: impl IntoIterator<Item = impl AsRef<str>>,
    row: impl IntoIterator<Item = impl AsRef<str>>,
) -> bool {
    // Decimals may have a comma.
    let is_number = |cell: &str| cell.trim().replacen(',', ".", 1).parse::<f64>().is_ok();
    let (mut numbers, mut others) = (0, 0);
    for cell in row {
        match cell.as_ref().trim() {
            "" => {}
            number if is_number(number) => numbers += 1,
            _ => others += 1,
        }
    }
    let mut names = names.into_iter();
    numbers >= 2 && numbers > others && !names.any(|name| is_number(name.as_ref()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_cells_only_what_could_be_a_number_is_shown() {
        for shown in ["", "1,5", "12:00:01", "1e-3", "2026-01-01 12:00", "-inf"] {
            assert_eq!(cell(shown), format!("\"{shown}\""));
        }
        for hidden in ["hunter2", "$6$salt$hash", "x", "0x10", "noon"] {
            assert_eq!(cell(hidden), "text");
        }
    }

    #[test]
    fn heads_of_logs_are_told_from_lines_of_other_files() {
        let is_log = |names: &str, row: &str, separator: char| {
            is_head_of_log(names.split(separator), row.split(separator))
        };
        for (names, row) in [
            ("t,x,y", "0.0,1.0,2.0"),
            ("t,x,y,mode", "0,,,1"),
            ("time,x,y,mode", "2026-01-01T12:00,0.5,1e3,2"),
        ] {
            assert!(is_log(names, row, ','), "{row}");
        }
        assert!(is_log("t;x;mode;y", "0,1;5;auto;2", ';'));
        for (first, second) in [
            (
                "root:$6$hash:19000:0:99999:7:::",
                "daemon:*:19000:0:99999:7:::",
            ),
            (
                "root:x:0:0:root:/root:/bin/bash",
                "daemon:x:1:1:daemon:/usr/sbin:/bin/false",
            ),
            // No name is a number, and two cells are: most are not.
            (
                "login:password:uid:gid:home:shell",
                "bob:secret:1000:1000:/home/bob:/bin/sh",
            ),
            ("name:password", "bob:1234"),
            ("TOKEN=1", "HOME=2"),
            ("secret", "17"),
            ("", ""),
        ] {
            assert!(!is_log(first, second, ':'), "{first}");
        }
    }
}
