//! The HTML page around the figures, with style and scripts in one file.

use std::fmt::Write;

use ilon_scene::embed::{BRAND_STYLE, MARK, THEME};

use super::figure::{DashKind, Figure, Pen, Span};
use super::html_table::{self, cell, heads, row, wide};

const STYLE: &str = include_str!("web/style.css");
/// Script that draws the figures of a page on canvases: curves over time, maps, areas, bars.
/// Figures over time share their zoom and, if the page has a clock (`window.ilonClock`), its
/// cursor; a click seeks.
const PLOT: &str = concat!(
    "(function () {\n'use strict';\n",
    include_str!("web/plot/values.js"),
    include_str!("web/plot/frame.js"),
    include_str!("web/plot/drawing.js"),
    include_str!("web/plot/figure.js"),
    include_str!("web/plot/page.js"),
    "})();\n"
);

/// The script of tables that sort.
const SORT: &str = include_str!("web/sort.js");

/// Escapes text for HTML content or attribute values.
pub fn escape(text: &str) -> String {
    let mut html = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => html.push_str("&amp;"),
            '<' => html.push_str("&lt;"),
            '>' => html.push_str("&gt;"),
            '"' => html.push_str("&quot;"),
            '\'' => html.push_str("&#39;"),
            _ => html.push(c),
        }
    }
    html
}

/// Escapes JSON for a script element: no `<` in it can end the element.
pub fn json_in_script(json: &str) -> String {
    json.replace('<', "\\u003c")
}

/// A sentence of the answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Whether it is good or bad news; `None` for a neutral finding.
    pub is_good: Option<bool>,
    /// The sentence, as plain text.
    pub text: String,
}

impl Answer {
    /// A neutral finding.
    pub fn plain(text: String) -> Self {
        Self {
            is_good: None,
            text,
        }
    }

    /// A problem.
    pub fn bad(text: String) -> Self {
        Self {
            is_good: Some(false),
            text,
        }
    }
}

/// Returns text as HTML; what stands between `` ` `` becomes code.
pub fn with_code(text: &str) -> String {
    let parts = text.split('`').enumerate();
    parts
        .map(|(place, part)| match (place % 2, escape(part)) {
            (0, text) => text.to_string(),
            (_, code) => format!("<code>{code}</code>"),
        })
        .collect()
}

/// Returns the answers as the lead of a page, as HTML; text between `` ` `` becomes code.
pub fn answers(answers: &[Answer]) -> String {
    let line = |answer: &Answer| {
        let mark = match answer.is_good {
            Some(true) => "<b>✓</b> ",
            Some(false) => "<b class=\"failed\">✗</b> ",
            None => "",
        };
        format!("<p>{mark}{}</p>", with_code(&answer.text))
    };
    let lines: String = answers.iter().map(line).collect();
    format!("<div class=\"story\">{lines}</div>\n")
}

/// A table of text cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Its title.
    pub title: String,
    /// The headings of its columns.
    pub head: Vec<String>,
    /// Its rows.
    pub rows: Vec<Vec<String>>,
}

/// Returns a table as HTML; empty if it has no rows.
pub fn table(table: &Table) -> String {
    if table.rows.is_empty() {
        return String::new();
    }
    let word = |word: &String| cell(Some(escape(word)));
    let row = |cells: &Vec<String>| match cells.split_first() {
        Some((name, cells)) => row(&escape(name), &cells.iter().map(word).collect::<String>()),
        None => String::new(),
    };
    let rows: String = table.rows.iter().map(row).collect();
    let heads = heads(table.head.iter().map(|word| escape(word)));
    wide(&html_table::table(&escape(&table.title), &heads, &rows))
}

/// A section of the page.
pub struct Section {
    /// Identifier for links.
    pub id: &'static str,
    /// Heading, as text.
    pub title: &'static str,
    /// Introduction, as HTML; may be empty.
    pub lead: String,
    /// Its content, as HTML.
    pub body: String,
}

/// The content above the sections.
pub struct Head {
    /// The kind of page, next to the project's mark.
    pub kind: &'static str,
    /// The page's title, as text.
    pub title: String,
    /// Facts under the title, as HTML.
    pub facts: Vec<String>,
    /// The answer in short, as HTML.
    pub lead: String,
}

/// Identifies a page as written by ilon.
pub const GENERATOR: &str = "<meta name=\"generator\" content=\"ilon\">";

/// Message for viewers that do not run scripts.
const NO_SCRIPT: &str = "<noscript><p class=\"lead\">Without scripts the scene and the curves of this page stay empty. Open the file in a browser that runs them, or read \
                         the words and tables.</p></noscript>\n";

/// Additional parts of a page.
#[derive(Default)]
pub struct Parts<'a> {
    /// More style sheets.
    pub styles: &'a [&'a str],
    /// Scripts that run before the drawing script, such as the clock that moves the figures'
    /// cursor.
    pub before: &'a [&'a str],
}

/// Returns the whole page.
pub fn page(head: &Head, sections: &[Section], footer: &str, parts: &Parts) -> String {
    let mut html = String::with_capacity(2 << 20);
    let title = escape(&head.title);
    let facts: String = head.facts.iter().map(|f| format!("<li>{f}</li>")).collect();
    let links: String = sections
        .iter()
        .map(|s| format!("<li><a href=\"#{}\">{}</a></li>", s.id, escape(s.title)))
        .collect();
    let styles = parts.styles.join("\n");
    // Writing to a string cannot fail.
    let _ = write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\" data-theme=\"light\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n{GENERATOR}\n\
         <title>{title} · ilon</title>\n<style>\n{STYLE}{BRAND_STYLE}{styles}</style>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#main\">Skip to the content</a>\n<header>\n\
         <div class=\"brand\"><span>{MARK}<strong>ilon</strong> · {kind}</span>\
         <button type=\"button\" class=\"theme\">Light / dark</button></div>\n\
         <h1>{title}</h1>\n<ul class=\"facts\">{facts}</ul>\n{lead}\n{NO_SCRIPT}</header>\n\
         <nav aria-label=\"Sections\"><ul tabindex=\"0\">{links}</ul></nav>\n<main id=\"main\">\n",
        kind = head.kind,
        lead = head.lead,
    );
    for section in sections {
        let _ = write!(
            html,
            "<section aria-labelledby=\"{id}\">\n<h2 id=\"{id}\">{title}</h2>\n",
            id = section.id,
            title = escape(section.title)
        );
        if !section.lead.is_empty() {
            let _ = writeln!(html, "<p class=\"lead\">{}</p>", section.lead);
        }
        html.push_str(&section.body);
        html.push_str("</section>\n");
    }
    let _ = write!(html, "</main>\n<footer>{footer}</footer>");
    let plot = html.contains("data-figure=").then_some(PLOT);
    let sort = html.contains("class=\"sortable\"").then_some(SORT);
    let scripts = [THEME].into_iter().chain(parts.before.iter().copied());
    for script in scripts.chain(plot).chain(sort) {
        let _ = write!(html, "\n<script>\n{}</script>", compact(script));
    }
    html.push_str("\n</body>\n</html>\n");
    html
}

/// Removes indentation, empty lines and comment lines from a script.
fn compact(script: &str) -> String {
    let lines = script.lines().map(str::trim);
    let code = lines.filter(|line| !line.is_empty() && !line.starts_with("//"));
    code.flat_map(|line| [line, "\n"]).collect()
}

/// Folded content that the user can open; on paper it is open.
pub fn topic(title: &str, says: &str, body: &str) -> String {
    format!(
        "<details class=\"topic\"><summary><span>{}</span> <small>{says}</small></summary>\n{body}</details>\n",
        escape(title)
    )
}

/// Figures side by side.
pub fn grid(figures: &[Figure]) -> String {
    side_by_side(&figures.iter().map(card).collect::<String>())
}

/// Cards side by side, as HTML.
pub fn side_by_side(cards: &str) -> String {
    format!("<div class=\"grid\">\n{cards}</div>\n")
}

/// A figure on its own card.
pub fn card(figure: &Figure) -> String {
    let class = if figure.span == Span::Whole {
        " class=\"whole\""
    } else {
        ""
    };
    format!(
        "<figure{class}><figcaption><h3>{title}</h3><p>{caption}</p></figcaption>{plot}</figure>\n",
        title = escape(&figure.title),
        caption = figure.caption,
        plot = plot(figure),
    )
}

/// Small panels under one title, with one legend for all.
pub fn panels(title: &str, caption: &str, legend: &[(&str, Pen)], figures: &[Figure]) -> String {
    let items: String = legend
        .iter()
        .map(|(name, pen)| format!("<li>{}{}</li>", swatch(*pen), escape(name)))
        .collect();
    let cells: String = figures
        .iter()
        .map(|figure| {
            format!(
                "<div class=\"panel\"><h4>{}</h4>{}</div>\n",
                escape(&figure.title),
                plot(figure)
            )
        })
        .collect();
    format!(
        "<figure class=\"whole\"><figcaption><h3>{}</h3><p>{caption}</p>\
         <ul class=\"legend\">{items}</ul></figcaption>\n<div class=\"panels\">\n{cells}</div></figure>\n",
        escape(title)
    )
}

/// A sample of a drawn line.
pub fn swatch(pen: Pen) -> String {
    let dashes = match pen.dash {
        DashKind::Solid => "none",
        DashKind::Dash => "7 4",
        DashKind::Dot => "2 3",
        DashKind::DashDot => "7 3 2 3",
    };
    let color = pen.color.trim_start_matches('@');
    format!(
        "<svg viewBox=\"0 0 30 10\" aria-hidden=\"true\"><line x1=\"0\" y1=\"5\" x2=\"30\" y2=\"5\" \
         stroke=\"var(--{color})\" stroke-width=\"{}\" stroke-dasharray=\"{dashes}\"/></svg>",
        pen.width_px.max(2.0)
    )
}

/// The element of a plot with its data.
fn plot(figure: &Figure) -> String {
    let over_time = if figure.over_time {
        " data-over-time"
    } else {
        ""
    };
    let panel = if figure.span == Span::Panel {
        " data-panel"
    } else {
        ""
    };
    format!(
        "<div class=\"plot\" id=\"{id}\" data-height=\"{height}\"{over_time}{panel} role=\"group\" \
         aria-label=\"{title}\" style=\"min-height:{height}px\"></div>\
         <script type=\"application/json\" data-figure=\"{id}\">{json}</script>",
        id = figure.id,
        height = figure.height_px,
        title = escape(&figure.title),
        json = json_in_script(&figure.plot),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_data_cannot_break_out_of_the_page() {
        assert_eq!(
            escape("<a href='x'>&\""),
            "&lt;a href=&#39;x&#39;&gt;&amp;&quot;"
        );
        let json = serde_json::to_string("</script><b>").unwrap_or_default();
        let embedded = json_in_script(&json);
        assert!(!embedded.contains('<'));
        assert_eq!(
            serde_json::from_str::<String>(&embedded).ok().as_deref(),
            Some("</script><b>")
        );
    }

    #[test]
    fn scripts_are_carried_without_their_comments_and_load_nothing() {
        for script in [THEME, PLOT, SORT] {
            let carried = compact(script);
            assert!(carried.len() < script.len() && !carried.contains("\n//"));
            for word in [
                "http",
                "fetch(",
                "import ",
                "import(",
                "XMLHttpRequest",
                "eval(",
                "</script",
            ] {
                assert!(!carried.contains(word), "{word}");
            }
        }
    }
}
