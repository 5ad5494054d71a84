//! The report of a run: one HTML file that works offline and shows the robot's actual motion and
//! its causes.
//!
//! It is made from a trace and its summary alone, without physics. Its numbers are the summary's;
//! its curves are reduced for the screen, and say so. [`compare`] compares several runs.

mod accumulate;
#[cfg(feature = "studies")]
pub mod answers;
pub mod compare;
mod conditions;
mod decimate;
pub mod difference;
pub mod drawing;
pub mod figure;
mod figures;
mod html_table;
mod input;
pub mod page;
#[cfg(feature = "studies")]
pub mod pages;
mod pen;
mod plot;
pub mod provenance;
#[cfg(test)]
mod sample;
mod story;
pub mod sweep;
mod tables;
mod text;
pub mod viewer;

use std::path::Path;

use ilon_robot::Robot;
use ilon_trace::file::{ROWS_A_GROUP, write_text};
use ilon_trace::{Header, Recorded, Settings, Summary, Trace, TraceError};

use conditions::conditions;
use figure::{dashed, dotted, solid};
use figures::{balance, causes, contacts, motion, rollers, wheels};
use input::RunInput;
pub use page::GENERATOR;
use page::{Head, Section, card, escape, panels, side_by_side};
pub use provenance::{Expectation, Provenance};
use story::Story;
pub use tables::causes_table;
use text::{angle, by_kind, length};

/// Information for a report that a trace does not contain.
#[derive(Default)]
pub struct Context<'a> {
    /// The robot. Without it the report reads the URDF of the trace, which has wheels only in the
    /// form of their file.
    pub robot: Option<&'a Robot>,
    /// Heights of the ground's relief, row by row, in metres.
    pub relief_m: Option<Vec<Vec<f64>>>,
    /// Expectations with their results.
    pub expectations: Vec<Expectation>,
    /// Origin of the page.
    pub provenance: Provenance,
}

/// Returns the report of a run, as one self-contained HTML file.
pub fn html(trace: &Trace, summary: &Summary) -> String {
    html_with(trace, summary, &Context::default())
}

/// Returns the report of a run, with information that its trace does not contain.
pub fn html_with(trace: &Trace, summary: &Summary, context: &Context) -> String {
    page_in_memory(trace, summary, context).0
}

/// Writes the report of a run to a file, atomically.
///
/// # Errors
/// [`TraceError::Io`] if the file cannot be written.
pub fn write(path: &Path, trace: &Trace, summary: &Summary) -> Result<(), TraceError> {
    write_text(path, &html(trace, summary))
}

/// Writes the report of a run to a file, atomically; the rows need not be in memory. Returns the
/// answer in plain sentences, the most important first.
///
/// # Errors
/// [`TraceError::Io`] if the file cannot be written, and errors of reading the rows.
pub fn write_recorded(
    path: &Path,
    recorded: &Recorded,
    summary: &Summary,
    context: &Context,
) -> Result<Vec<String>, TraceError> {
    let (page, answer) = match recorded {
        Recorded::Memory(trace) => page_in_memory(trace, summary, context),
        Recorded::File(file) => {
            let shown = RunInput::of_many(file, ROWS_A_GROUP)?;
            let scene =
                viewer::picture_of(file, context.robot, context.relief_m.as_deref(), Vec::new())?;
            page_of(&shown, summary, context, scene.as_ref())
        }
    };
    write_text(path, &page)?;
    Ok(answer)
}

/// Returns the report's answer in plain sentences, the most important first.
///
/// # Errors
/// If the rows cannot be read.
pub fn answer(recorded: &Recorded, summary: &Summary) -> Result<Vec<String>, TraceError> {
    let settings = Settings::default();
    let story = match recorded {
        Recorded::Memory(trace) => {
            let Ok(shown) = RunInput::of(trace);
            Story::of(&shown, summary, &settings)
        }
        Recorded::File(file) => {
            Story::of(&RunInput::of_many(file, ROWS_A_GROUP)?, summary, &settings)
        }
    };
    Ok(story.plain())
}

fn page_in_memory(trace: &Trace, summary: &Summary, context: &Context) -> (String, Vec<String>) {
    let Ok(shown) = RunInput::of(trace);
    let Ok(scene) = viewer::picture_of(
        trace,
        context.robot,
        context.relief_m.as_deref(),
        Vec::new(),
    );
    page_of(&shown, summary, context, scene.as_ref())
}

/// Returns the page, and its answer in plain sentences.
fn page_of(
    shown: &RunInput,
    summary: &Summary,
    context: &Context,
    scene: Option<&viewer::Picture>,
) -> (String, Vec<String>) {
    let settings = Settings::default();
    let trace = &*shown.trace;
    let story = Story::of(shown, summary, &settings);
    let mut ends_s = shown.all.ends_s();
    let ends_s = [ends_s.next().unwrap_or(0.0), ends_s.next().unwrap_or(0.0)];
    let head = Head {
        kind: "run report",
        title: trace.header.scenario_name.clone(),
        facts: facts(trace, summary, &context.provenance),
        lead: format!(
            "{}<div class=\"first\"><div>{}{}{}</div>\n{}</div>\n",
            about(&trace.header),
            provenance::verdict(&context.expectations),
            story.html(),
            tables::tiles(summary, &context.expectations),
            viewer::html(&trace.header, ends_s, &story.events, scene),
        ),
    };
    let mut sections: Vec<Section> = causes_section(shown, summary).into_iter().collect();
    sections.extend([
        motion_section(shown, &settings),
        budget_section(shown, summary, &story),
    ]);
    sections.push(details_section(shown, summary, &story, context));
    (
        viewer::page(&head, &sections, &footer(shown), scene.is_some()),
        story.plain(),
    )
}

/// Returns the scenario's description, the comment at its head, as HTML.
fn about(header: &Header) -> String {
    let first = header.scenario_toml.lines().next().unwrap_or_default();
    match first.strip_prefix("# ") {
        Some(words) => format!("<p class=\"about\">{}</p>\n", escape(words)),
        None => String::new(),
    }
}

/// Returns facts about the run, as HTML.
fn facts(trace: &Trace, summary: &Summary, provenance: &Provenance) -> Vec<String> {
    let header = &trace.header;
    let mut gammas_deg: Vec<i64> = header
        .wheels
        .iter()
        .map(|w| w.gamma_rad.to_degrees().abs().round() as i64)
        .collect();
    gammas_deg.sort_unstable();
    gammas_deg.dedup();
    let gammas: Vec<String> = gammas_deg.iter().map(|g| format!("{g}°")).collect();
    let on_rollers = header.wheels.iter().filter(|w| !w.has_tyre());
    let rollers: usize = on_rollers.map(|w| w.roller_count).sum();
    let roll = match rollers {
        0 => " on tyres".to_owned(),
        _ => format!(", |γ| {}, <b>{rollers}</b> rollers", gammas.join(" / ")),
    };
    let mut facts = vec![
        format!("robot <b>{}</b>", escape(&header.robot_name)),
        format!("<b>{}</b> wheels{roll}", header.wheels.len()),
        format!(
            "<b>{}</b>",
            if header.open_loop {
                "open loop"
            } else {
                "closed loop"
            }
        ),
        conditions(header, provenance),
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
    facts.retain(|fact| !fact.is_empty());
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

fn motion_section(shown: &RunInput, settings: &Settings) -> Section {
    let legend = [
        ("real", solid("@real").width(2.6)),
        ("asked, before saturation", dotted("@asked")),
        (
            "ideal: ideal kinematics of the real wheel rates",
            dashed("@ideal"),
        ),
        (
            "contact: by what touches the floor",
            solid("@contact").width(1.2),
        ),
    ];
    let geometry = by_kind(&shown.trace.header, "tyres' width", "rollers' geometry");
    let caption = format!(
        "In the body frame. Ideal minus contact is the {geometry}, contact minus real is slip, commanded minus ideal is what saturation \
         and the wheel loops left."
    );
    let twist = panels("Velocity", &caption, &legend, &motion::twist(shown));
    let mut figures = vec![motion::path(shown)];
    figures.extend(motion::errors(shown, settings));
    figures.extend(motion::against_the_log(shown));
    // An odd last figure takes the whole row.
    if figures.len() % 2 == 1
        && let Some(last) = figures.last_mut()
    {
        last.span = figure::Span::Whole;
    }
    let cards: String = figures.iter().map(card).collect();
    Section {
        id: "motion",
        title: "Motion",
        lead: String::new(),
        body: side_by_side(&(cards + &twist)),
    }
}

/// The origin of the error: at the worst instant of a closed loop, over the run of an open one.
fn budget_section(shown: &RunInput, summary: &Summary, story: &Story) -> Section {
    let ledger: String = balance::ledger(shown, summary).iter().map(card).collect();
    let integral = side_by_side(&(ledger + &tables::ledger_table(shown, summary)));
    let body = if shown.trace.header.open_loop {
        let twist = tables::twist_table(&shown.trace, summary);
        side_by_side(&twist) + &integral
    } else {
        let is_off = summary.position_error_final_m > Some(story::UNREMARKABLE_M);
        let without = match is_off {
            true => "The robot was still on its way to its reference at the end.",
            false => "Once at its reference, the robot was never more than a millimetre off.",
        };
        let worst = story.budget.as_ref().map_or_else(
            || format!("<p class=\"lead\">{without}</p>\n"),
            |budget| {
                let error = motion::error_around(shown, budget);
                page::grid(&[balance::budget(budget), error])
            },
        );
        let folded = page::topic(
            "Commanded minus real over the whole run",
            "commands include what feedback asks again and again, so these sums are larger than any error",
            &integral,
        );
        worst + &folded
    };
    Section {
        id: "budget-section",
        title: "Error budget",
        lead: "Commanded minus real motion, split by cause. The terms add up to the total exactly."
            .to_owned(),
        body,
    }
}

/// The title of a table of causes.
pub const CAUSES: &str = "The run minus the run without the cause. A dash: less than can be told, three times what half the step changes";

/// The effect of each cause, if the run was repeated without it.
fn causes_section(shown: &RunInput, summary: &Summary) -> Option<Section> {
    let ablations = ilon_trace::effects::of_causes(summary, &shown.trace.header);
    let figures = [
        causes::at_the_end(&ablations),
        causes::ways(shown, &ablations),
    ];
    let figures: String = figures.iter().flatten().map(card).collect();
    let mut ranked: Vec<_> = ablations.iter().collect();
    ranked.sort_by(|a, b| b.apart.most_m.total_cmp(&a.apart.most_m));
    let table = page::table(&causes_table(CAUSES, &ranked));
    (!ablations.is_empty()).then(|| Section {
        id: "causes",
        title: "Causes",
        lead: "The same run was made without each cause. Each figure is this run minus that one."
            .to_owned(),
        body: side_by_side(&figures) + &table,
    })
}

/// Change of the figures at half the step, if the run was repeated at it.
fn convergence_topic(summary: &Summary) -> String {
    let converge = &summary.converge;
    if converge.is_empty() {
        return String::new();
    }
    let lead = format!("<p class=\"lead\">{}</p>\n", converge.sentence());
    page::topic(
        "At half the step",
        "how far each figure moves",
        &(lead + &tables::convergence_table(converge)),
    )
}

/// All other details, folded by topic.
fn details_section(
    shown: &RunInput,
    summary: &Summary,
    story: &Story,
    context: &Context,
) -> Section {
    let trace = &*shown.trace;
    let legend = [
        ("real", solid("@real").width(2.2)),
        ("commanded", dashed("@asked")),
        ("limit", dotted("@limit")),
    ];
    let rates = panels(
        "Wheel rates",
        "Real rates that lag the commanded ones show the wheel loops; commands on the limit show saturation. A limit far above \
         the rates is not drawn.",
        &legend,
        &wheels::rates(shown),
    );
    let of_wheels: String = std::iter::once(wheels::torques(shown))
        .chain(wheels::tasks(shown))
        .chain(wheels::torque_weights(shown))
        .map(|figure| card(&figure))
        .collect();
    let odometry: String = motion::odometry(shown).iter().map(card).collect();
    let energy = card(&balance::energy(shown)) + &tables::energy_table(summary);
    // A summary of numbers and names always serialises.
    let json = serde_json::to_string(summary).unwrap_or_default();
    let numbers = format!(
        "{}<script type=\"application/json\" id=\"summary\">{}</script>\n",
        tables::all_figures(summary),
        page::json_in_script(&json)
    );
    let scenario = format!(
        "<pre tabindex=\"0\">{}</pre>",
        escape(&trace.header.scenario_toml)
    );
    let topics = [
        page::topic(
            "Events",
            &format!("{} found", story.events.len()),
            &viewer::events_table(&story.events),
        ),
        page::topic(
            "Wheels",
            "rates, torques, tasks",
            &side_by_side(&(rates + &of_wheels)),
        ),
        page::topic(
            "Contacts and slip",
            "forces and sliding",
            &contacts_of(shown, summary),
        ),
        page::topic(
            "Energy",
            "where the motors' work went",
            &side_by_side(&energy),
        ),
        page::topic(
            "Odometry",
            "what wheel encoders alone would say",
            &side_by_side(&(odometry + &tables::odometry_table(summary))),
        ),
        page::topic(
            "The robot from above",
            "wheels and axes at rest",
            &robot_from_above(trace),
        ),
        convergence_topic(summary),
        page::topic("All numbers", "as in summary.json", &numbers),
        page::topic("Scenario", "with all defaults", &scenario),
        page::topic(
            "Provenance",
            "command, date, versions, files, remarks",
            &context.provenance.html(&trace.header.versions),
        ),
    ];
    Section {
        id: "details",
        title: "Details",
        lead: String::new(),
        body: format!(
            "<p><button type=\"button\" class=\"unfold\">Open or close all</button></p>\n{}",
            topics.concat()
        ),
    }
}

/// The robot from above: places of its wheels and directions of their rollers.
fn robot_from_above(trace: &Trace) -> String {
    format!(
        "<figure class=\"whole\"><figcaption><h3>The robot from above</h3><p>At rest, in the body frame: chassis, wheels, \
         {}and the vectors b of equation (2).</p></figcaption>\n{}</figure>\n",
        by_kind(&trace.header, "", "the axes of the rollers on the ground, "),
        drawing::svg_of_trace(&trace.header)
    )
}

/// Below this sliding speed a figure would show nothing, in m/s.
const LEAST_SLIDING_M_S: f64 = 1e-3;

fn contacts_of(shown: &RunInput, summary: &Summary) -> String {
    let trace = &*shown.trace;
    let mut figures = vec![
        contacts::normal_force(shown),
        contacts::tangential_force(shown),
        contacts::grip_used(shown),
        contacts::friction_cone(trace),
    ];
    let largest_m_s = shown.all.largest(accumulate::OfWheel::SlipSpeed);
    let slides = largest_m_s >= LEAST_SLIDING_M_S;
    let quiet = if slides {
        figures.extend([
            contacts::slip_speed(shown),
            contacts::slip_energy(shown),
            contacts::polar(shown),
            contacts::contact_map(trace),
        ]);
        String::new()
    } else {
        format!(
            "<p class=\"lead\">No contact slid faster than {}: the figures of sliding are left out.</p>\n",
            text::speed(largest_m_s)
        )
    };
    if trace.header.wheels.iter().any(|wheel| !wheel.is_steered) {
        figures.push(contacts::residual(shown));
    }
    if trace.header.is_on_tyres() {
        let cards: String = figures.iter().map(card).collect();
        return quiet + &side_by_side(&(cards + &tables::wheel_table(summary, false)));
    }
    figures.extend([contacts::roller_spin(shown), rollers::hand_over(shown)]);
    if slides {
        figures.push(rollers::slip_within_a_pitch(shown));
    }
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
    quiet + &side_by_side(&(cards + &touching + &tables::wheel_table(summary, true)))
}

fn footer(shown: &RunInput) -> String {
    let some = match shown.every {
        1 => String::new(),
        every => format!(
            " Paths over the floor, {}grip and the areas of the energy are drawn from one row in {every}; all other curves and all figures \
             are taken from all rows.",
            by_kind(&shown.trace.header, "", "which roller touches, ")
        ),
    };
    format!(
        "<p>Curves are thinned to at most {} points, of each interval the smallest and the largest value; the trace has one \
         row for each of the {} control steps.{some} Drag over a figure to zoom (all figures over time follow), double click to go \
         back. A short peak beyond the axis is marked with its value. Equation numbers are those of G. Indiveri, “Swedish Wheeled Omnidirectional Mobile Robots: Kinematics \
         Analysis and Control”, IEEE Transactions on Robotics 25(1), 2009.</p>",
        decimate::MAX_POINTS,
        shown.all.row_count
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
        // Inside a script a reference is text that no browser follows; only the page's own elements
        // count.
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

    /// What a page shows, without its scripts and its scene.
    fn shown_of(page: &str) -> String {
        let without = |text: &str, from: &str, to: &str| -> String {
            let after = |part: &str| part.split_once(to).map(|(_, after)| after.to_owned());
            let parts = text
                .split(from)
                .map(|part| after(part).unwrap_or_else(|| part.to_owned()));
            parts.collect()
        };
        without(&without(page, "<script", "</script>"), "<style", "</style>")
    }

    /// The contact is wide, and there is neither hand-over nor compensation.
    #[test]
    fn the_page_of_a_robot_on_tyres_has_no_rollers() {
        for open_loop in [false, true] {
            let mut trace = sample::made_up_run(3.0, open_loop);
            let of_rollers = shown_of(&html(&trace, &Summary::of(&trace, &Settings::default())));
            assert!(of_rollers.matches("roller").count() > 5);
            for wheel in &mut trace.header.wheels {
                wheel.roller_count = 1;
                wheel.gamma_rad = 0.0;
            }
            let mut summary = Summary::of(&trace, &Settings::default());
            summary.energy.spin_up_j = Some(0.0);
            let page = shown_of(&html(&trace, &summary));
            // The summary has its own names.
            let page = page.split("All numbers").next().unwrap_or_default();
            let at = page.find("roller");
            let around = at.map(|at| page.get(at.saturating_sub(150)..at + 50));
            assert_eq!(around, None, "open loop: {open_loop}");
            assert!(page.contains("the tyres are wide"));
        }
    }

    /// A run that ends before the window of the means begins has no means.
    #[test]
    fn means_are_shown_over_a_window_that_begins_before_it_ends() {
        for (from_s, is_shown) in [(1.0, true), (3.0, false), (4.0, false)] {
            let mut trace = sample::made_up_run(3.0, true);
            (trace.header.measure_from_s, trace.header.measure_to_s) = (from_s, 3.0);
            let page = html(&trace, &Summary::of(&trace, &Settings::default()));
            assert_eq!(page.contains("Means from"), is_shown, "from {from_s} s");
        }
    }

    #[test]
    fn a_minute_makes_less_than_two_megabytes() {
        let (_, page) = report_of(60.0, false);
        assert!(page.len() < 2_000_000, "{} bytes", page.len());
    }
}
