//! Escapes text from files, such as names and paths, for a terminal and for logs.
//!
//! A control character in a name can clear a terminal, forge a line, or command the machine that
//! reads the log: GitHub executes `::error::` at the start of a line and `##[error]` anywhere in
//! it. All of these are shown, none takes effect.

use std::borrow::Cow;
use std::path::Path;

/// Prefixes of commands to log-reading machines, at any place in a line.
const COMMANDS: [&str; 2] = ["##[", "##vso["];

/// Longest name or message shown, in characters; chosen.
const LONGEST: usize = 2000;

/// Escapes a name or message for use within a line: control characters and line breaks are escaped,
/// and very long text is cut.
pub(super) fn one_line(text: &str) -> Cow<'_, str> {
    let cut = match text.char_indices().nth(LONGEST) {
        None => Cow::Borrowed(text),
        Some((end, _)) => {
            let more = text[end..].chars().count();
            Cow::Owned(format!("{}... ({more} more characters)", &text[..end]))
        }
    };
    if cut.chars().any(acts) || COMMANDS.iter().any(|command| cut.contains(command)) {
        Cow::Owned(written_out(&cut))
    } else {
        cut
    }
}

/// The longest line left whole, and the length of the parts of a longer one, in characters. With a
/// prefix a line stays within 240.
const WHOLE: usize = 220;
const PART: usize = 180;

/// Breaks a long line between words, but not where the next one would begin like a command to a
/// log-reading machine. Text to copy, within backticks, gets a line of its own, and goes on in
/// further ones only where a shell or TOML reads them as one.
pub(super) fn folded(line: &str) -> String {
    /// Phrases before text to copy.
    const COPIED: [&str; 2] = ["this works", "fill in "];
    if line.chars().count() <= WHOLE {
        return line.to_owned();
    }
    let copied = COPIED.iter().filter_map(|words| line.find(words)).min();
    let (line, copied) = line.split_at(copied.unwrap_or(line.len()));
    // A second command stands on a line of its own.
    let copied = copied.replacen("; on tyres: ", ";\non tyres: ", 1);
    let copied = copied.split('\n').map(|part| match part.chars().count() {
        ..=WHOLE => part.to_owned(),
        _ => filled(part),
    });
    let mut parts: Vec<String> = copied.filter(|part| !part.is_empty()).collect();
    let line = filled(line);
    if !line.is_empty() {
        let end = line.trim_end().len();
        parts.insert(
            0,
            line[..if parts.is_empty() { line.len() } else { end }].to_owned(),
        );
    }
    parts.join("\n")
}

/// Breaks a line between words and quoted parts.
fn filled(line: &str) -> String {
    let mut filled = String::with_capacity(line.len());
    let (mut length, mut unit) = (0, String::new());
    for (i, word) in line.split(' ').enumerate() {
        let goes_on = !unit.is_empty();
        unit = if goes_on {
            unit + " " + word
        } else {
            word.to_owned()
        };
        if unit.matches('`').count() % 2 == 1 {
            continue;
        }
        let of_unit = unit.chars().count();
        let is_first = i == unit.matches(' ').count();
        let may_break = !is_first && !unit.is_empty() && !unit.starts_with("::");
        if may_break && length + 1 + of_unit > PART {
            filled.push('\n');
            length = 0;
        } else if !is_first {
            filled.push(' ');
            length += 1;
        }
        let unit = std::mem::take(&mut unit);
        filled.push_str(&if of_unit > PART {
            continued(&unit)
        } else {
            unit
        });
        length += of_unit;
    }
    if !unit.is_empty() && !filled.is_empty() {
        filled.push(' ');
    }
    filled + &unit
}

/// Breaks quoted text to copy where a shell goes on after a backslash, and TOML after an element of
/// a list; never within a word, as the next line is indented.
fn continued(quoted: &str) -> String {
    let is_command = quoted.starts_with("`ilon ");
    // PowerShell and cmd end a command at the line's end.
    if is_command && cfg!(windows) {
        return quoted.to_owned();
    }
    let mut folded = String::with_capacity(quoted.len());
    let (mut length, mut is_quoted, mut lists, mut in_list) = (0, !is_command, 0, false);
    for (i, word) in quoted.split(' ').enumerate() {
        let of_word = word.chars().count();
        let may_break = i > 0 && (!is_quoted || in_list);
        if may_break && length + 1 + of_word > PART {
            folded.push_str(if is_quoted { "\n" } else { " \\\n" });
            length = 0;
        } else if i > 0 {
            folded.push(' ');
            length += 1;
        }
        folded.push_str(word);
        length += of_word;
        // An escaped quote mark begins and ends nothing.
        is_quoted ^= is_command && word.replace("\\'", "").matches('\'').count() % 2 == 1;
        lists += word.matches('[').count();
        lists -= word.matches(']').count().min(lists);
        // A comma in a text ends no element: those of a list of texts follow a quote mark.
        let ends = word.ends_with("\",") || (word.ends_with(',') && !quoted.contains('"'));
        in_list = lists > 0 && ends;
    }
    folded
}

/// Escapes a sentence for the user, and folds it if it is long: later lines are indented.
pub(super) fn sentence(text: &str) -> String {
    folded(&one_line(text)).replace('\n', "\n    ")
}

/// Escapes sentences, each on lines of its own.
pub(super) fn sentences(all: &[String]) -> String {
    all.iter().map(|one| sentence(one) + "\n").collect()
}

/// Escapes a path for use within a line.
pub(super) fn path_in_line(path: &Path) -> String {
    one_line(&path.display().to_string()).into_owned()
}

/// Escapes whole lines for the user: line breaks stay.
pub(super) fn lines(text: &str) -> Cow<'_, str> {
    let is_harmless = |line: &str| {
        !line.chars().any(acts)
            && !line.trim_start().starts_with("::")
            && !COMMANDS.iter().any(|command| line.contains(command))
    };
    if text.split('\n').all(is_harmless) {
        return Cow::Borrowed(text);
    }
    let harmless: Vec<String> = text.split('\n').map(harmless_line).collect();
    Cow::Owned(harmless.join("\n"))
}

fn harmless_line(line: &str) -> String {
    let line = written_out(line);
    // The backslash makes it no command, and shows that it was escaped.
    if line.trim_start().starts_with("::") {
        line.replacen("::", "\\::", 1)
    } else {
        line
    }
}

/// Whether a character has an effect beyond being displayed.
fn acts(c: char) -> bool {
    c.is_control() || turns_text(c) || matches!(c, '\u{2028}' | '\u{2029}')
}

/// Whether a character changes the direction of the text after it, so that it reads as something
/// else.
fn turns_text(c: char) -> bool {
    matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text with such characters as escape sequences.
fn written_out(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if acts(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    for command in COMMANDS {
        shown = shown.replace(command, &command.replacen("##", "#\\#", 1));
    }
    shown
}

/// Replaces these characters by harmless ones of the same length in bytes, so that byte positions
/// stay valid. Line ends and tabs stay.
pub(super) fn standing_in(text: &str) -> String {
    let mut after = text.chars().skip(1);
    let stand_in = |c: char| {
        let next = after.next();
        let ends_line = c == '\n' || (c, next) == ('\r', Some('\n'));
        match (acts(c) && c != '\t' && !ends_line, c.len_utf8()) {
            (false, _) => c,
            (true, 1) => '?',
            (true, 2) => '\u{bf}',
            (true, _) => '\u{fffd}',
        }
    };
    let mut instead: String = text.chars().map(stand_in).collect();
    for command in COMMANDS {
        instead = instead.replace(command, &command.replacen("##", "#?", 1));
    }
    instead
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_folded_between_words_and_not_in_what_is_copied() {
        let short = "a word ".repeat(30);
        assert_eq!(folded(&short), short);
        let long = "a word ".repeat(60);
        assert!(folded(&long).lines().all(|line| line.len() <= 180));
        assert_eq!(folded(&long).replace('\n', " "), long);
        let command = format!("{long}: `ilon inspect {}`", "--wheels a ".repeat(40));
        let last = folded(&command);
        assert!(last.contains(":\n`ilon inspect --wheels a"), "{last}");
        // Shells of Windows take no command in parts: it stays whole there.
        let is_short = |line: &str| line.len() <= 200 || cfg!(windows) && line.contains("`ilon ");
        assert!(last.lines().all(is_short), "{last}");
        assert!(!folded(&"::error:: ".repeat(60)).contains('\n'));
        let words = "a word ".repeat(15);
        let two = format!(
            "fill in {words}: `a{}`; on tyres: `b{}`",
            " c".repeat(60),
            " d".repeat(60)
        );
        let lines: Vec<String> = folded(&two).lines().map(str::to_owned).collect();
        assert_eq!(lines.len(), 3, "words, and two commands: {lines:?}");
        assert!(lines.iter().all(|line| line.len() <= 220), "{lines:?}");
        assert!(lines[1].starts_with("`a c") && lines[2].starts_with("on tyres: `b"));
        let keys = format!(
            "{long}; this works, in `[robot]`: {}",
            "`a = 1`, ".repeat(40)
        );
        let last = folded(&keys);
        let start = |line: &str| line.starts_with("this works, in `[robot]`: `a = 1`,");
        assert!(last.lines().any(start), "{last}");
        assert!(last.lines().all(|line| line.len() <= 200), "{last}");
    }

    /// A shell reads a folded command, indented as messages are, as the words that were folded, and
    /// TOML a folded list; a line has at most 182 characters of the command (180 and ` \`).
    #[test]
    #[cfg(unix)]
    fn a_folded_command_can_be_copied() {
        let names: Vec<String> = (0..20)
            .map(|i| format!("front_left_wheel_joint_{i}"))
            .collect();
        let list = format!("robot.tyres={{ joints = [\"{}\"] }}", names.join("\", \""));
        let words = [
            "run",
            "my robot.urdf",
            "it's",
            &names.join(","),
            "--set",
            &list,
        ];
        let mut quoted: Vec<String> = words.map(super::super::flags::shell).to_vec();
        quoted.extend((0..20).map(|i| format!("--flag-{i} value")));
        let message = format!("next: drive it, `ilon {}`", quoted.join(" "));
        let shown = sentence(&message);
        let widest = shown.lines().map(|line| line.chars().count()).max();
        // The names without spaces between them are one word, which stays whole.
        assert!(widest <= Some(names.join(",").len() + 10), "{shown}");
        let copied = shown.split('`').nth(1).expect("a command");
        assert!(copied.contains(" \\\n"), "{copied}");
        let script = format!("ilon() {{ printf '%s\\0' \"$@\"; }}\n{copied}\n");
        let output = std::process::Command::new("sh")
            .args(["-c", &script])
            .output()
            .expect("sh");
        let read = String::from_utf8(output.stdout).expect("UTF-8");
        let read: Vec<&str> = read.trim_end_matches('\0').split('\0').collect();
        assert_eq!(read.len(), words.len() + 40, "{read:?}");
        assert_eq!(read[..5], words[..5]);
        let [read, meant] = [read[5], &list].map(|text| {
            let value = format!(
                "joints = {}",
                &text["robot.tyres={ joints = ".len()..text.len() - 2]
            );
            toml::from_str::<toml::Table>(&value).expect("a list of TOML")
        });
        assert_eq!(read, meant);
    }

    #[test]
    fn a_name_stays_in_its_line_and_does_nothing() {
        assert_eq!(one_line("front left ä 轮"), "front left ä 轮");
        assert_eq!(
            one_line("\u{1b}[2J\n::add-mask::held\r\t\u{9b}\u{202e}\u{2028}"),
            "\\u{1b}[2J\\n::add-mask::held\\r\\t\\u{9b}\\u{202e}\\u{2028}"
        );
        assert_eq!(one_line("##[error]x"), "#\\#[error]x");
    }

    #[test]
    fn what_is_very_long_is_cut_where_a_character_ends() {
        let text = "ä".repeat(LONGEST);
        assert_eq!(one_line(&text), text);
        let longer = format!("{text}bc");
        assert_eq!(one_line(&longer), format!("{text}... (2 more characters)"));
    }

    #[test]
    fn no_line_is_a_command_to_who_reads_the_log() {
        assert_eq!(lines("held\n  x  1.0\n"), "held\n  x  1.0\n");
        assert_eq!(
            lines("::error::x\n  ::set-env::"),
            "\\::error::x\n  \\::set-env::"
        );
        // Within a line it is no command, and a module path stays unchanged.
        assert_eq!(lines("a::b"), "a::b");
        assert_eq!(lines("x ##[error]a ##vso[b]"), "x #\\#[error]a #\\#vso[b]");
        assert_eq!(lines("a\u{1b}[31m\rb\n"), "a\\u{1b}[31m\\rb\n");
    }

    #[test]
    fn what_stands_in_for_a_text_is_as_long_as_it_character_by_character() {
        let all: String = (0..=0x2_ffff).filter_map(char::from_u32).collect();
        let instead = standing_in(&all);
        for (c, instead) in all.chars().zip(instead.chars()) {
            assert_eq!(instead.len_utf8(), c.len_utf8());
            assert!(!acts(instead) || matches!(instead, '\t' | '\n'));
        }
        assert_eq!(standing_in("a\r\nb\r\nc\rd\r"), "a\r\nb\r\nc?d?");
        assert_eq!(standing_in("##[error]"), "#?[error]");
    }
}
