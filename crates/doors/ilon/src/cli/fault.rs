//! Display of errors: the message, the lines at fault, and how to repair them.

use std::fmt::{self, Write};

use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError,
    MietteSpanContents, Report, Severity, SourceCode, SourceSpan, SpanContents,
};

use super::{console, escape};
use crate::cli::failure::Failure;

/// How much of a line is shown on each side of the place at fault, in bytes. A file may be a single
/// line of megabytes.
const AROUND: usize = 120;
/// How much of the text at fault is shown, in bytes.
const AT_FAULT: usize = 120;
/// Lines shown before and after the one at fault.
const CONTEXT_LINES: usize = 1;

/// Largest number of errors shown for one file; chosen.
const MOST_RELATED: usize = 20;

/// Prints an error to standard error.
pub(super) fn show(error: Failure) {
    install_printer();
    // What the library calls a setting comes from an option here.
    let shown = PlainFault::of(&error, "--set");
    let mut text = String::new();
    if write!(text, "{:?}", Report::new(shown)).is_err() {
        text = format!("{}\n", escape::one_line(&error.to_string()));
    }
    console::watching(&format!("{text}\n"));
}

/// An error as text without colours; `settings` is the caller's name for settings.
pub(super) fn plain(error: &dyn Diagnostic, settings: &str) -> String {
    let mut text = String::new();
    let printed = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_links(false)
        .with_width(usize::MAX)
        .with_wrap_lines(false)
        .with_context_lines(CONTEXT_LINES)
        .render_report(&mut text, &PlainFault::of(error, settings));
    match printed {
        Ok(()) => text,
        Err(fmt::Error) => escape::one_line(&error.to_string()).into_owned(),
    }
}

/// In colour only on a terminal, and never wrapped, so that a log or a script finds each message
/// whole.
fn install_printer() {
    let print = miette::set_hook(Box::new(|_| {
        Box::new(
            miette::MietteHandlerOpts::new()
                .terminal_links(false)
                .width(usize::MAX)
                .wrap_lines(false)
                .context_lines(CONTEXT_LINES)
                .build(),
        )
    }));
    // A hook that a program set earlier stays, as a program that embeds this function expects.
    drop(print);
}

/// An error whose texts are short and escaped.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
struct PlainFault {
    message: String,
    help: Option<String>,
    excerpt: Option<Excerpt>,
    /// Related errors.
    related: Vec<PlainFault>,
}

impl PlainFault {
    fn of(error: &dyn Diagnostic, settings: &str) -> Self {
        let text = |text: &dyn fmt::Display| escape::folded(&escape::one_line(&text.to_string()));
        let label = error.labels().and_then(|mut labels| labels.next());
        Self {
            message: text(&error),
            help: error.help().map(|help| text(&help)),
            excerpt: label
                .zip(error.source_code())
                .and_then(|(label, source)| Excerpt::of(source, &label, settings)),
            related: Self::related_to(error, settings),
        }
    }

    /// The related errors: the first ones and the last, whose help covers all of them.
    fn related_to(error: &dyn Diagnostic, settings: &str) -> Vec<Self> {
        let of = |error| Self::of(error, settings);
        let all: Vec<&dyn Diagnostic> = error.related().into_iter().flatten().collect();
        let left_out = all.len().saturating_sub(MOST_RELATED);
        if left_out == 0 {
            return all.into_iter().map(of).collect();
        }
        let first = all[..MOST_RELATED - 1].iter().copied().map(of);
        let between = Self {
            message: format!("{left_out} more faults are not shown"),
            help: None,
            excerpt: None,
            related: Vec::new(),
        };
        let last = all.last().copied().map(of);
        first.chain([between]).chain(last).collect()
    }
}

impl Diagnostic for PlainFault {
    fn severity(&self) -> Option<Severity> {
        Some(Severity::Error)
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as _)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let related = self.related.iter();
        Some(Box::new(related.map(|shown| shown as &dyn Diagnostic)))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.excerpt.as_ref().map(|excerpt| excerpt as _)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let excerpt = self.excerpt.as_ref()?;
        let label = LabeledSpan::new_with_span(excerpt.label.clone(), excerpt.at_fault);
        Some(Box::new(std::iter::once(label)))
    }
}

/// The lines around a place in a file, as far as they are shown. Positions count from the start of
/// the excerpt.
#[derive(Debug)]
struct Excerpt {
    file: String,
    text: String,
    at_fault: SourceSpan,
    label: Option<String>,
    /// Line and column of the excerpt's start in the file, from 0.
    line: usize,
    column: usize,
}

impl Excerpt {
    fn of(source: &dyn SourceCode, label: &LabeledSpan, settings: &str) -> Option<Self> {
        let contents = source
            .read_span(label.inner(), CONTEXT_LINES, CONTEXT_LINES)
            .ok()?;
        let text = std::str::from_utf8(contents.data()).ok()?;
        let start = label.offset().checked_sub(contents.span().offset())?;
        let start = floor(text, start);
        let end = ceil(text, start.saturating_add(label.len().min(AT_FAULT)));
        // Whole lines if they are short, otherwise only the surroundings of the place.
        let is_long = text.lines().any(|line| line.len() > 2 * AROUND + AT_FAULT);
        let shown = if is_long {
            floor(text, start.saturating_sub(AROUND))..ceil(text, end.saturating_add(AROUND))
        } else {
            0..text.len()
        };
        let before = &text[..shown.start];
        let line_start = before.rfind('\n').map(|at| at + 1);
        let column = match line_start {
            Some(line_start) => before[line_start..].chars().count(),
            None => contents.column() + before.chars().count(),
        };
        Some(Self {
            file: match contents.name().unwrap_or_default() {
                ilon_sim::scenario::SETTING => settings.to_owned(),
                name => escape::one_line(name).into_owned(),
            },
            text: escape::standing_in(&text[shown.clone()]),
            at_fault: (start - shown.start..end - shown.start).into(),
            label: label.label().map(str::to_owned),
            line: contents.line() + before.matches('\n').count(),
            column,
        })
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let contents = self.text.as_str().read_span(span, before, after)?;
        // The excerpt may begin within a line; only its first line is shifted by the start column.
        let column = match contents.line() {
            0 => self.column + contents.column(),
            _ => contents.column(),
        };
        Ok(Box::new(MietteSpanContents::new_named(
            self.file.clone(),
            contents.data(),
            *contents.span(),
            self.line + contents.line(),
            column,
            contents.line_count(),
        )))
    }
}

/// The last character boundary at or before `at`.
fn floor(text: &str, at: usize) -> usize {
    let at = at.min(text.len());
    (0..=at)
        .rev()
        .find(|at| text.is_char_boundary(*at))
        .unwrap_or(0)
}

/// The first character boundary at or after `at`.
fn ceil(text: &str, at: usize) -> usize {
    let at = at.min(text.len());
    (at..=text.len())
        .find(|at| text.is_char_boundary(*at))
        .unwrap_or(text.len())
}

#[cfg(test)]
mod tests {
    use miette::NamedSource;

    use super::*;
    use crate::ScenarioFault;

    fn shown(text: &str, span: std::ops::Range<usize>) -> String {
        let place = (NamedSource::new("a.toml", text.to_owned()), span.into());
        let error = ilon_sim::Error::from(ScenarioFault::new("wrong", "right it", place));
        let mut printed = String::new();
        GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
            .with_width(usize::MAX)
            .with_wrap_lines(false)
            .with_context_lines(CONTEXT_LINES)
            .render_report(&mut printed, &PlainFault::of(&error, "--set"))
            .expect("it can be shown");
        printed
    }

    #[test]
    fn a_short_file_is_shown_as_ever() {
        let printed = shown("[a]\nb = 1\nc = 2\nd = 3\n", 10..11);
        let expected = "  × wrong
   ╭─[a.toml:3:1]
 2 │ b = 1
 3 │ c = 2
   · ┬
   · ╰── here
 4 │ d = 3
   ╰────
  help: right it
";
        assert_eq!(printed, expected);
    }

    #[test]
    fn of_a_line_of_megabytes_what_is_around_the_fault_is_shown_with_its_column() {
        for before in [200, 65_535, 70_000, 3_000_000] {
            let text = format!("[a]\n{}fault{}\n", "x".repeat(before), "y".repeat(before));
            let printed = shown(&text, before + 4..before + 9);
            assert!(
                printed.contains(&format!("[a.toml:2:{}]", before + 1)),
                "{printed}"
            );
            assert!(printed.contains(&format!("{}fault{}", "x".repeat(100), "y".repeat(100))));
            assert!(printed.len() < 2000);
        }
    }

    #[test]
    fn of_a_fault_of_megabytes_its_beginning_is_shown() {
        let text = format!("a = \"{}\"\nb = 1\n", "z".repeat(1_000_000));
        let printed = shown(&text, 4..1_000_006);
        assert!(printed.contains("[a.toml:1:5]"), "{printed}");
        assert!(printed.len() < 3000, "{}", printed.len());
    }

    #[test]
    fn lines_with_control_characters_do_nothing() {
        let printed = shown("a = '\u{1b}[2J\u{9b}\r\u{202e}'\r\nb = 1\r\n", 4..10);
        assert!(printed.contains("a = '?[2J\u{bf}?\u{fffd}'"), "{printed}");
        assert!(!printed.contains(['\u{1b}', '\u{9b}', '\r', '\u{202e}']));
    }

    #[test]
    fn messages_of_any_length_end_and_stay_in_their_line() {
        let error =
            ilon_sim::Error::invalid(format!("`{}\n::error::`", "k".repeat(1 << 20)), "a\u{1b}b");
        let shown = PlainFault::of(&error, "--set");
        assert!(shown.message.len() < 3000 && !shown.message.contains('\n'));
        assert_eq!(shown.help.as_deref(), Some("a\\u{1b}b"));
    }

    #[test]
    fn whatever_text_and_place_they_are_shown() {
        // All positions, also empty ones and those beyond the end, in texts with all kinds of line
        // ends and characters.
        let pieces = [
            "", "a", "\n", "\r", "\r\n", "ä", "轮", "\t", "\u{1b}", "\u{301}", "\u{200d}",
        ];
        let long = "ä".repeat(500);
        for a in pieces {
            for b in pieces {
                for c in ["", "\n", "x = 1\n", long.as_str()] {
                    let text = format!("{a}{b}{c}{b}{a}");
                    for start in (0..=text.len() + 1).step_by(1 + text.len() / 12) {
                        for length in [0, 1, 2, 7, 600] {
                            shown(&text, start..start + length);
                        }
                    }
                }
            }
        }
    }
}
