//! HTML tables from HTML parts.

use super::text::decimals;

/// A cell; a dash if empty.
pub(crate) fn cell(content: Option<String>) -> String {
    match content {
        Some(content) => format!("<td>{content}</td>"),
        None => "<td class=\"none\">—</td>".to_owned(),
    }
}

/// A cell with a number.
pub(crate) fn number(value: Option<f64>, places: usize) -> String {
    cell(value.map(|x| decimals(x, places)))
}

/// A row with its heading.
pub(crate) fn row(head: &str, cells: &str) -> String {
    format!("<tr><th scope=\"row\">{head}</th>{cells}</tr>")
}

/// The headings of columns.
pub(crate) fn heads<T: std::fmt::Display>(titles: impl IntoIterator<Item = T>) -> String {
    // An empty heading is none.
    let head = |title: T| match title.to_string().as_str() {
        "" => "<td></td>".to_owned(),
        title => format!("<th scope=\"col\">{title}</th>"),
    };
    titles.into_iter().map(head).collect()
}

/// A table; an empty caption is omitted.
pub(crate) fn table(caption: &str, heads: &str, rows: &str) -> String {
    let caption = match caption {
        "" => String::new(),
        words => format!("<caption>{words}</caption>"),
    };
    format!("<table>{caption}<thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>")
}

/// A full-width table whose columns sort.
pub(crate) fn sortable(heads: &str, rows: &str) -> String {
    wide(&format!(
        "<table class=\"sortable\"><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"
    ))
}

/// A full-width card with content that may be wider than the page.
pub(crate) fn wide(content: &str) -> String {
    format!("<div class=\"card whole scroll\" tabindex=\"0\">{content}</div>\n")
}
