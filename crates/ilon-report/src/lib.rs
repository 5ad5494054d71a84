//! The report: one HTML file that opens offline and shows what the robot really did, and why.
//!
//! It is made from a trace and its summary alone, so that it can be made again without physics. Its numbers are the
//! summary's; its curves are thinned for the screen, and say so. [`compare`] lays several runs over each other.

pub mod compare;
pub mod difference;
pub mod drawing;
pub mod figure;
mod figures;
mod gathered;
pub mod page;
#[cfg(test)]
mod sample;
mod shown;
pub mod sweep;
mod thin;
mod top_view;
mod words;

use std::path::Path;

use ilon_trace::file::{ROWS_A_GROUP, write_text};
use ilon_trace::{Recorded, Settings, Summary, Trace, TraceError};

use figure::{dashed, dotted, solid};
use figures::{balance, contacts, motion, rollers, wheels};
pub use page::GENERATOR;
use page::{Head, Section, card, escape, panels};
use shown::Shown;
pub use thin::short;
use words::{angle, length};

/// The report of a run, as one HTML file that needs nothing else.
pub fn html(trace: &Trace, summary: &Summary) -> String {
    let Ok(shown) = Shown::of(trace);
    page_of(&shown, summary)
}

/// Writes the report of a run to a file, whole or not at all.
///
/// # Errors
/// [`TraceError::Io`] where the file cannot be written.
pub fn write(path: &Path, trace: &Trace, summary: &Summary) -> Result<(), TraceError> {
    write_text(path, &html(trace, summary))
}

/// Writes the report of a run whose rows need not lie in memory to a file, whole or not at all.
///
/// # Errors
/// [`TraceError::Io`] where the file cannot be written, and where the rows cannot be read.
pub fn write_recorded(
    path: &Path,
    recorded: &Recorded,
    summary: &Summary,
) -> Result<(), TraceError> {
    match recorded {
        Recorded::Memory(trace) => write(path, trace, summary),
        Recorded::File(file) => {
            let shown = Shown::of_many(file, ROWS_A_GROUP)?;
            write_text(path, &page_of(&shown, summary))
        }
    }
}

fn page_of(shown: &Shown, summary: &Summary) -> String {
    let settings = Settings::default();
    let trace = &*shown.trace;
    let head = Head {
        kind: "run report",
        title: trace.header.scenario_name.clone(),
        facts: facts(trace, summary),
        lead: words::story(trace, summary) + &words::tiles(summary),
    };
    let sections = [
        motion_section(shown, summary, &settings),
        ledger_section(shown, summary),
        wheels_section(shown),
        contacts_section(shown, summary),
        Section {
            id: "odometry-section",
            title: "Odometry",
            lead: "What the robot would believe if it had nothing but its wheel encoders."
                .to_owned(),
            body: format!(
                "<div class=\"grid\">\n{}{}</div>\n",
                motion::odometry(shown).iter().map(card).collect::<String>(),
                words::odometry_table(summary)
            ),
        },
        figures_section(trace, summary),
    ];
    page::page(&head, &sections, &footer(shown), &[top_view::SCRIPT])
}

/// What the run was, as HTML.
fn facts(trace: &Trace, summary: &Summary) -> Vec<String> {
    let header = &trace.header;
    let mut gammas_deg: Vec<i64> = header
        .wheels
        .iter()
        .map(|w| w.gamma_rad.to_degrees().abs().round() as i64)
        .collect();
    gammas_deg.sort_unstable();
    gammas_deg.dedup();
    let gammas: Vec<String> = gammas_deg.iter().map(|g| format!("{g}°")).collect();
    let rollers: usize = header.wheels.iter().map(|w| w.roller_count).sum();
    let mut facts = vec![
        format!("robot <b>{}</b>", escape(&header.robot_name)),
        format!(
            "<b>{}</b> wheels, |γ| {}, <b>{rollers}</b> rollers",
            header.wheels.len(),
            gammas.join(" / ")
        ),
        format!(
            "<b>{}</b>",
            if header.open_loop {
                "open loop"
            } else {
                "closed loop"
            }
        ),
        format!(
            "<b>{:.2} s</b> in steps of {:.3} ms",
            summary.duration_s,
            1e3 * header.physics_dt_s
        ),
        format!(
            "travelled <b>{}</b>, turned <b>{}</b>",
            length(summary.travelled_m),
            angle(summary.turned_rad)
        ),
    ];
    if let Some(speed) = summary.sim_seconds_per_cpu_second {
        facts.push(format!("<b>{speed:.1}×</b> real time"));
    }
    let versions: Vec<String> = header
        .versions
        .iter()
        .map(|(name, version)| format!("{} {}", escape(name), escape(version)))
        .collect();
    if !versions.is_empty() {
        facts.push(versions.join(", "));
    }
    facts
}

fn motion_section(shown: &Shown, summary: &Summary, settings: &Settings) -> Section {
    let legend = [
        ("real", solid("@real").width(2.6)),
        ("asked, before saturation", dotted("@asked")),
        ("ideal: (7) from the real wheel rates", dashed("@ideal")),
        (
            "contact: by the rollers that touch",
            solid("@contact").width(1.2),
        ),
    ];
    let caption = "In the body frame. Between ideal and contact lies the rollers' geometry, between contact and real the \
                   slip, between asked and ideal what saturation and the wheel loops left undone.";
    let twist = panels("Twist", caption, &legend, &motion::twist(shown));
    let mut cards = card(&motion::path(shown));
    cards.push_str(
        &motion::errors(shown, settings)
            .iter()
            .map(card)
            .collect::<String>(),
    );
    Section {
        id: "motion",
        title: "Motion",
        lead: "Where the robot went, and where it should have gone.".to_owned(),
        body: format!(
            "<div class=\"grid\">\n{}{cards}{twist}{}</div>\n",
            top_view::html(shown),
            words::twist_table(&shown.trace, summary)
        ),
    }
}

fn ledger_section(shown: &Shown, summary: &Summary) -> Section {
    let mut cards: String = balance::ledger(shown, summary).iter().map(card).collect();
    cards.push_str(&words::ledger_table(summary));
    cards.push_str(&card(&balance::energy(shown)));
    cards.push_str(&words::energy_table(summary));
    Section {
        id: "ledger",
        title: "Where it went",
        lead: "The difference between the motion asked for and the real one, split by cause. The terms add up to the \
               total exactly: nothing is left over."
            .to_owned(),
        body: format!("<div class=\"grid\">\n{cards}</div>\n"),
    }
}

fn wheels_section(shown: &Shown) -> Section {
    let legend = [
        ("real", solid("@real").width(2.2)),
        ("commanded", dashed("@asked")),
        ("limit", dotted("@limit")),
    ];
    let rates = panels(
        "Wheel rates",
        "Real rates that lag behind the commanded ones are the wheel loops' doing; commands that lie on the limit are \
         saturation's. A limit far above the rates is not drawn.",
        &legend,
        &wheels::rates(shown),
    );
    let rest: String = std::iter::once(wheels::torques(shown))
        .chain(wheels::tasks(shown))
        .chain(wheels::torque_weights(shown))
        .map(|figure| card(&figure))
        .collect();
    Section {
        id: "wheels",
        title: "Wheels",
        lead: String::new(),
        body: format!(
            "<div class=\"grid\">\n{rates}{rest}{}</div>\n",
            robot_from_above(&shown.trace)
        ),
    }
}

/// The robot itself: where its wheels sit and which way their rollers lie.
fn robot_from_above(trace: &Trace) -> String {
    format!(
        "<figure class=\"whole\"><figcaption><h3>The robot from above</h3><p>At rest, in the body frame: chassis, wheels, \
         the axes of the rollers on the ground, and the vectors b of equation (2).</p></figcaption>\n{}</figure>\n",
        drawing::svg_of_trace(&trace.header)
    )
}

fn contacts_section(shown: &Shown, summary: &Summary) -> Section {
    let trace = &*shown.trace;
    let figures = [
        contacts::slip_speed(shown),
        contacts::slip_energy(shown),
        contacts::normal_force(shown),
        contacts::tangential_force(shown),
        contacts::grip_used(shown),
        contacts::friction_cone(trace),
        contacts::polar(shown),
        contacts::contact_map(trace),
        contacts::residual(shown),
        contacts::roller_spin(shown),
        rollers::hand_over(shown),
        rollers::slip_within_a_pitch(shown),
    ];
    let legend = [
        ("the roller that carries", solid("@real")),
        ("it shares the load with a neighbour", dotted("@slip")),
    ];
    let touching = panels(
        "Which roller touches",
        "The roller that carries most of each wheel, by its number. A gap is a wheel that has lost the floor.",
        &legend,
        &rollers::touching(trace),
    );
    let cards: String = figures.iter().map(card).collect();
    Section {
        id: "contacts",
        title: "Contacts and slip",
        lead: "What happened where the rollers touch the floor.".to_owned(),
        body: format!(
            "<div class=\"grid\">\n{cards}{touching}{}</div>\n",
            words::wheel_table(summary)
        ),
    }
}

fn figures_section(trace: &Trace, summary: &Summary) -> Section {
    // A summary of numbers and names always serialises.
    let json = serde_json::to_string(summary).unwrap_or_default();
    Section {
        id: "numbers",
        title: "All numbers",
        lead: "As in <code>summary.json</code>.".to_owned(),
        body: format!(
            "<details><summary>Every figure of the summary</summary>{}</details>\n\
             <details><summary>The scenario, with all defaults</summary><pre>{}</pre></details>\n\
             <script type=\"application/json\" id=\"summary\">{}</script>\n",
            words::all_figures(summary),
            escape(&trace.header.scenario_toml),
            page::json_in_script(&json)
        ),
    }
}

fn footer(shown: &Shown) -> String {
    let some = match shown.every {
        1 => String::new(),
        every => format!(
            " Ways over the floor, which roller touches, grip, the areas of the energy and the picture that plays are drawn \
             from one row in {every}; all other curves and all figures are taken from all rows."
        ),
    };
    format!(
        "<p>Curves are thinned to at most {} points, of each interval the smallest and the largest value; the trace has one \
         row for each of the {} control steps.{some} Zooming into the time of one figure zooms all; a double click goes \
         back. Equation numbers are those of G. Indiveri, “Swedish Wheeled Omnidirectional Mobile Robots: Kinematics \
         Analysis and Control”, IEEE Transactions on Robotics 25(1), 2009.</p>",
        thin::MAX_POINTS,
        shown.all.row_count()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report_of(duration_s: f64, open_loop: bool) -> (Summary, String) {
        let trace = sample::made_up_run(duration_s, open_loop);
        let summary = Summary::of(&trace, &Settings::default());
        let page = html(&trace, &summary);
        (summary, page)
    }

    #[test]
    fn the_numbers_in_the_page_are_the_summary() {
        for open_loop in [false, true] {
            let (summary, page) = report_of(3.0, open_loop);
            let after = page
                .split("id=\"summary\">")
                .nth(1)
                .expect("the page carries its numbers");
            let json = after.split("</script>").next().expect("a closed element");
            let carried: serde_json::Value =
                serde_json::from_str(&json.replace("\\u003c", "<")).expect("numbers as JSON");
            assert_eq!(
                carried,
                serde_json::to_value(&summary).expect("numbers as JSON")
            );
        }
    }

    #[test]
    fn the_page_asks_nothing_of_the_network() {
        let (_, page) = report_of(2.0, false);
        // Inside a script a reference is text, which no browser follows by itself; the page's own elements count.
        let elements: String = page
            .split("<script")
            .map(|part| {
                part.split_once("</script>")
                    .map_or(part, |(_, after)| after)
            })
            .collect();
        assert!(
            elements.contains("<figure"),
            "the elements are left to look at"
        );
        for reference in [
            "src=\"http",
            "href=\"http",
            "src='http",
            "@import",
            "<link ",
        ] {
            assert!(!elements.contains(reference), "the page holds {reference}");
        }
    }

    #[test]
    fn a_minute_makes_less_than_ten_megabytes() {
        let (_, page) = report_of(60.0, false);
        assert!(page.len() < 10_000_000, "{} bytes", page.len());
    }
}
