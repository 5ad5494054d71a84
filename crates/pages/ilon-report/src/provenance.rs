//! Origin of a page and expectations of the run, given by the caller because a trace does not
//! contain them.

use std::collections::BTreeMap;

use super::html_table::{self, wide};
use super::page::escape;

/// An expectation with its result.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expectation {
    /// The quantity or signal, by its name in `[expect]`.
    pub quantity: String,
    /// The bound with its unit, such as `<= 20 mm`.
    pub bound: String,
    /// The measured value, with its unit and time.
    pub measured: String,
    /// Whether it held.
    pub held: bool,
}

/// Origin of a page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// The command that made it.
    pub command: Option<String>,
    /// Keys of the scenario that the command changed, as `key=value`.
    pub changed: Vec<String>,
    /// Date, as text for the reader.
    pub date: Option<String>,
    /// Files and the hashes of their contents.
    pub files: BTreeMap<String, String>,
    /// Remarks on the input or the run.
    pub remarks: Vec<String>,
}

/// Returns the verdict as HTML: expectations with their results, failures first. Empty without
/// expectations.
pub fn verdict(expectations: &[Expectation]) -> String {
    if expectations.is_empty() {
        return String::new();
    }
    let failed = expectations.iter().filter(|e| !e.held).count();
    let (class, text) = match (failed, expectations.len()) {
        (0, 1) => ("held", "The expectation held".to_owned()),
        (0, all) => ("held", format!("All {all} expectations held")),
        (failed, all) => ("failed", format!("{failed} of {all} expectations failed")),
    };
    let mut sorted: Vec<&Expectation> = expectations.iter().collect();
    sorted.sort_by_key(|e| e.held);
    let items: String = sorted
        .into_iter()
        .map(|e| {
            format!(
                "<li class=\"{}\"><b>{}</b> <code>{} {}</code>: {}</li>",
                if e.held { "held" } else { "failed" },
                if e.held { "held" } else { "failed" },
                escape(&e.quantity),
                escape(&e.bound),
                escape(&e.measured)
            )
        })
        .collect();
    let open = if failed > 0 { " open" } else { "" };
    format!(
        "<details class=\"verdict {class}\"{open}><summary>{text}</summary><ul>{items}</ul></details>\n"
    )
}

impl Provenance {
    /// Returns the origin as HTML; `versions` are those of the producing software, by name.
    pub fn html(&self, versions: &BTreeMap<String, String>) -> String {
        let row = |(name, value): (&str, &String)| {
            let value = format!("<td class=\"words\"><code>{}</code></td>", escape(value));
            html_table::row(&escape(name), &value)
        };
        let command = self.command.iter().map(|command| ("command", command));
        let date = self.date.iter().map(|date| ("made", date));
        let named = versions.iter().chain(&self.files);
        let named = named.map(|(name, value)| (name.as_str(), value));
        let rows: String = command.chain(date).chain(named).map(row).collect();
        let remarks: String = self
            .remarks
            .iter()
            .map(|remark| format!("<li>{}</li>", escape(remark)))
            .collect();
        let remarks = if remarks.is_empty() {
            String::new()
        } else {
            format!("<h3>Remarks</h3><ul class=\"remarks\">{remarks}</ul>")
        };
        wide(&format!("{remarks}<table><tbody>{rows}</tbody></table>"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_come_first_and_are_counted() {
        let one = |quantity: &str, held| Expectation {
            quantity: quantity.to_owned(),
            bound: "<= 1 <mm>".to_owned(),
            measured: "2 mm".to_owned(),
            held,
        };
        let html = verdict(&[one("good", true), one("bad", false)]);
        assert!(html.contains("1 of 2 expectations failed") && html.contains(" open>"));
        assert!(html.find("bad").expect("there") < html.find("good").expect("there"));
        assert!(html.contains("&lt;mm&gt;"));
        assert_eq!(verdict(&[]), "");
        assert!(verdict(&[one("good", true)]).contains("The expectation held"));
    }
}
