//! The page that compares several runs, in the style of the report.

use std::fmt::Write;

use super::figures::{self, run_pen};
use ilon_trace::Quantity;

use super::ranking;
use super::{Comparison, SettingRow};
use crate::html_table::{self, cell, row};
use crate::page::{self, Head, Section, card, escape, grid, panels, side_by_side};
use crate::story::plain;
use crate::text::{angle, decimals, length};
use crate::viewer;

/// Returns the results of each run relative to the first, one sentence each.
pub fn answers(comparison: &Comparison) -> Vec<String> {
    let lines = ranking::sentences(comparison);
    lines.iter().map(|line| plain(line)).collect()
}

/// Returns the comparison as one self-contained HTML file.
pub fn html(comparison: &Comparison) -> String {
    let names: Vec<&str> = comparison
        .runs
        .iter()
        .map(|run| run.name.as_str())
        .collect();
    let ends = comparison.runs.iter().flat_map(|run| run.trace.records());
    let (from_s, until_s) = ends.fold((f64::INFINITY, 0.0_f64), |(from, until), record| {
        (from.min(record.t_s), until.max(record.t_s))
    });
    let runs = comparison.runs.iter();
    let runs: Vec<_> = runs.map(|run| (run.name.as_str(), &run.trace)).collect();
    let Ok(stage) = viewer::of_runs(&runs, [from_s, until_s]);
    let head = Head {
        kind: "comparison",
        title: match names[..] {
            [first, _, _, ..] => format!("{first} and {} others", names.len() - 1),
            _ => names.join(" and "),
        },
        facts: vec![format!("<b>{}</b> runs", names.len())],
        lead: format!(
            "<div class=\"story\">{}</div>\n{}{}{stage}",
            ranking::sentences(comparison)
                .iter()
                .map(|line| format!("<p>{line}</p>"))
                .collect::<String>(),
            legend(comparison),
            settings_table(comparison)
        ),
    };
    let sections = [
        Section {
            id: "figures",
            title: "In figures",
            lead: "In each row the first run is the measure for the others. What regressed stands first, then what improved.".to_owned(),
            body: ranked_table(comparison)
                + &page::topic("All figures", "in the order of a run's own table", &figures_table(comparison)),
        },
        motion_section(comparison),
        Section {
            id: "ledger",
            title: "Error budget",
            lead: "The difference between commanded and real motion, split by cause; and the motors' work."
                .to_owned(),
            body: grid(&figures::above_noise([
                figures::ledger_position(comparison),
                figures::ledger_heading(comparison),
                figures::energy(comparison),
                figures::odometry(comparison),
            ])),
        },
        Section {
            id: "contacts",
            title: "Contacts and slip",
            lead: "What happened where the rollers touch the floor.".to_owned(),
            body: grid(&figures::above_noise([
                figures::slip_speed(comparison),
                figures::slip_of_wheels(comparison),
                figures::grip(comparison),
                figures::torque(comparison),
            ])),
        },
        numbers_section(comparison),
    ];
    let footer = "<p>Curves are thinned as in the report of a single run. Zooming into the time of one figure zooms all; a \
                  double click goes back. A click on a name in a legend hides that curve. Equation numbers are those of \
                  G. Indiveri, “Swedish Wheeled Omnidirectional Mobile Robots: Kinematics Analysis and Control”, IEEE \
                  Transactions on Robotics 25(1), 2009.</p>";
    viewer::page(&head, &sections, footer, !stage.is_empty())
}

/// The legend of the curves, with a description of each run.
fn legend(comparison: &Comparison) -> String {
    let mut items = String::new();
    for (index, run) in comparison.runs.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(
            items,
            "<p>{}<b>{}</b>: {}, {:.1} s, travelled {}, turned {}</p>",
            page::swatch(run_pen(index)),
            escape(&run.name),
            escape(&run.trace.header.robot_name),
            run.summary.duration_s,
            length(run.summary.travelled_m),
            angle(run.summary.turned_rad),
        );
    }
    format!("<div class=\"story legend-of-runs\">{items}</div>\n")
}

/// The table of different settings.
fn settings_table(comparison: &Comparison) -> String {
    if comparison.differences.is_empty() {
        return "<p class=\"lead\">All were run from the same scenario.</p>\n".to_owned();
    }
    let rows = comparison.differences.iter().map(settings_row);
    table(
        "What was set differently",
        comparison,
        &rows.collect::<String>(),
    )
}

/// The row of a setting with its values.
pub(crate) fn settings_row(setting: &SettingRow) -> String {
    let values = setting.values.iter();
    let cells: String = values
        .map(|value| cell(value.as_deref().map(escape)))
        .collect();
    row(&format!("<code>{}</code>", escape(&setting.key)), &cells)
}

/// The figures that differ, by verdict.
fn ranked_table(comparison: &Comparison) -> String {
    let verdicts = ranking::verdicts(comparison);
    if verdicts.is_empty() {
        return "<p class=\"lead\">No main figure differs by more than 1 %.</p>\n".to_owned();
    }
    let columns = comparison.runs.len() + 1;
    let mut rows = String::new();
    for (verdict, all) in verdicts {
        let _ = write!(
            rows,
            "<tr class=\"group\"><th scope=\"rowgroup\" colspan=\"{columns}\" class=\"{verdict}\">{verdict}</th></tr>"
        );
        for named in all {
            rows.push_str(&figure_row(comparison, named.quantity, Some(named.heading)));
        }
    }
    table(
        "Main figures of all runs; those not listed agree within 1 %",
        comparison,
        &rows,
    )
}

fn figures_table(comparison: &Comparison) -> String {
    let columns = comparison.runs.len() + 1;
    let mut rows = String::new();
    for (heading, quantities) in comparison.groups() {
        let _ = write!(
            rows,
            "<tr class=\"group\"><th scope=\"rowgroup\" colspan=\"{columns}\">{}</th></tr>",
            escape(heading)
        );
        for quantity in quantities {
            rows.push_str(&figure_row(comparison, quantity, None));
        }
    }
    table(
        "SI units but for millimetres and degrees; a dash is a figure that does not apply",
        comparison,
        &rows,
    )
}

/// The row of a figure for each run, with an optional heading.
fn figure_row(comparison: &Comparison, quantity: &Quantity, heading: Option<&str>) -> String {
    let value = |index: usize| quantity.shown(&comparison.runs[index].summary);
    let first = value(0);
    let cells: String = (0..comparison.runs.len())
        .map(|index| {
            cell(value(index).map(|x| {
                // A change below what figures bear is none.
                let first = first.filter(|_| ranking::differs(comparison, quantity, index));
                let against = first.and_then(|first| ranking::change(quantity, first, x));
                let against =
                    against.map_or_else(String::new, |text| format!(" <small>{text}</small>"));
                decimals(x, quantity.decimals) + &against
            }))
        })
        .collect();
    let heading = heading.map_or_else(String::new, |heading| format!("{}: ", escape(heading)));
    let [label, unit] = [quantity.label, quantity.unit.symbol].map(escape);
    row(&format!("{heading}{label}, {unit}"), &cells)
}

/// A table with one column per run.
fn table(caption: &str, comparison: &Comparison, rows: &str) -> String {
    let runs = comparison.runs.iter().enumerate();
    let heads = html_table::heads(
        runs.map(|(index, run)| page::swatch(run_pen(index)) + &escape(&run.name)),
    );
    format!(
        "<div class=\"card whole scroll of-runs\" tabindex=\"0\">{}</div>\n",
        html_table::table(caption, &format!("<td></td>{heads}"), rows)
    )
}

fn motion_section(comparison: &Comparison) -> Section {
    let mut cards = card(&figures::path(comparison));
    for figure in figures::errors(comparison) {
        cards.push_str(&card(&figure));
    }
    let legend: Vec<_> = comparison
        .runs
        .iter()
        .enumerate()
        .map(|(index, run)| (run.name.as_str(), run_pen(index)))
        .collect();
    let caption = "The real velocity in the body frame.";
    cards.push_str(&panels(
        "Twist",
        caption,
        &legend,
        &figures::above_noise(figures::twist(comparison)),
    ));
    Section {
        id: "motion",
        title: "Motion",
        lead: "Where the robots went.".to_owned(),
        body: side_by_side(&cards),
    }
}

fn numbers_section(comparison: &Comparison) -> Section {
    let mut body = String::new();
    for run in &comparison.runs {
        let _ = writeln!(
            body,
            "<details><summary>The scenario of {}, with all defaults</summary><pre tabindex=\"0\">{}</pre></details>",
            escape(&run.name),
            escape(&run.trace.header.scenario_toml)
        );
    }
    let json = serde_json::Value::from(comparison.summaries()).to_string();
    let _ = writeln!(
        body,
        "<script type=\"application/json\" id=\"summaries\">{}</script>",
        page::json_in_script(&json)
    );
    Section {
        id: "numbers",
        title: "Scenarios",
        lead: "All figures of each run are in its own <code>summary.json</code>, and in this page."
            .to_owned(),
        body,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::ComparedRun;
    use crate::sample::made_up_run;
    use ilon_trace::{Settings, Summary};

    fn comparison(names: [&str; 2]) -> Comparison {
        let run = |(name, open_loop): (&str, bool)| {
            let mut trace = made_up_run(2.0, open_loop);
            trace.header.scenario_name = name.to_owned();
            let summary = Summary::of(&trace, &Settings::default());
            ComparedRun {
                name: name.to_owned(),
                trace,
                summary,
            }
        };
        let runs = vec![run((names[0], false)), run((names[1], true))];
        Comparison::of(runs, &[]).expect("two runs")
    }

    #[test]
    fn the_numbers_in_the_page_are_the_summaries() {
        let comparison = comparison(["one", "two"]);
        let page = html(&comparison);
        let after = page
            .split("id=\"summaries\">")
            .nth(1)
            .expect("the page carries its numbers");
        let json = after.split("</script>").next().expect("a closed element");
        let carried: serde_json::Value =
            serde_json::from_str(&json.replace("\\u003c", "<")).expect("numbers as JSON");
        for (index, run) in comparison.runs.iter().enumerate() {
            assert_eq!(
                carried[index]["summary"],
                serde_json::to_value(&run.summary).expect("JSON")
            );
        }
    }

    /// 3 m after 2 m is half as much again; the first run has nothing beside its figure.
    #[test]
    fn figures_stand_beside_their_change_from_the_first_run() {
        let mut compared = comparison(["one", "two"]);
        for (run, end_m) in compared.runs.iter_mut().zip([2.0, 3.0]) {
            run.summary.end_x_m = Some(end_m);
        }
        let quantity = ilon_trace::quantities::by_key("end_x_m").expect("it is a figure");
        let row = figure_row(&compared, quantity, None);
        let cells = [
            cell(Some("2.0000".to_owned())),
            cell(Some("3.0000 <small>+50.0 %</small>".to_owned())),
        ];
        assert!(row.contains(&cells.concat()), "{row}");
        // Half a percent is less than two runs can be told apart by.
        compared.runs[1].summary.end_x_m = Some(2.01);
        let row = figure_row(&compared, quantity, None);
        assert!(row.contains(&cell(Some("2.0100".to_owned()))), "{row}");
    }

    #[test]
    fn names_cannot_break_out_of_the_page() {
        let page = html(&comparison(["<b>one</b>", "two & </script>"]));
        let without_scripts: String = page
            .split("<script")
            .map(|part| {
                part.split_once("</script>")
                    .map_or(part, |(_, after)| after)
            })
            .collect();
        assert!(!without_scripts.contains("<b>one") && !without_scripts.contains("two & <"));
        assert!(without_scripts.contains("&lt;b&gt;one"));
    }

    /// An unknown robot cannot be drawn in three dimensions, and the page omits the script for it.
    #[test]
    fn a_page_without_scenes_carries_no_script_for_them() {
        let comparison = comparison(["one", "two"]);
        assert!(!html(&comparison).contains(&ilon_scene::embed::script()));
    }
}
