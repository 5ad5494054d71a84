//! The page of a run that differs from its baseline: the result, the first difference, and every
//! differing signal.

mod ranked;

use ilon_trace::{Difference, Rows};

use crate::compare::{self, SettingRow};
use crate::figure::{
    Curve, Figure, Pen, axis, curve, dashed, dots, dotted, exact_curve, layout, map_layout, plot,
    solid,
};
use crate::html_table::{cell, heads, row, table, wide};
use crate::page::{self, Head, Section, escape, grid};
use crate::text::{angle, length, percent, time};
use crate::viewer;
use ranked::{Ranked, allowed, of_its_span, ranked, value};

/// Number of rows drawn before and after the first difference.
const ROWS_AROUND: usize = 25;

/// Number of signals drawn over the run, and around the first difference; the table has all.
const DRAWN: usize = 6;
const DRAWN_AT_FIRST: usize = 2;

/// Paths closer than this count as equal, in metres ...
const SAME_M: f64 = 1e-6;
/// ... and headings, in radians.
const SAME_RAD: f64 = 1e-6;

const RUN: Pen = solid("@real").width(2.2);
const BASELINE: Pen = dashed("@asked");

/// Returns the differences between a run and its baseline as one self-contained HTML file.
///
/// # Errors
/// If the rows cannot be read.
pub fn html<R: Rows>(run: &R, baseline: &R, found: &[Difference]) -> Result<String, R::Error> {
    let duration_s = |rows: &R| -> Result<f64, R::Error> {
        let last_s = rows.values("t_s")?.last().copied().flatten();
        Ok(last_s.map_or(0.0, |last_s| rows.header().row_end_s(last_s)))
    };
    let durations_s = [duration_s(run)?, duration_s(baseline)?];
    let ranked = ranked(found, baseline)?;
    let apart = Apart::of(run, baseline)?;
    let settings = compare::settings_that_differ(&[
        &baseline.header().scenario_toml,
        &run.header().scenario_toml,
    ]);
    let until_s = durations_s[0].max(durations_s[1]);
    let stage = viewer::of_runs(&[("run", run), ("baseline", baseline)], [0.0, until_s])?;
    let head = Head {
        kind: "against a baseline",
        title: format!("{} against its baseline", run.header().scenario_name),
        facts: vec![
            format!("robot <b>{}</b>", escape(&run.header().robot_name)),
            format!(
                "<b>{}</b> of {} signals differ",
                found.len(),
                run.header().signal_names().len()
            ),
            format!(
                "<b>{:.2} s</b>, the baseline {:.2} s",
                durations_s[0], durations_s[1]
            ),
        ],
        lead: format!(
            "<div class=\"story\">{}</div>\n{}{stage}",
            story(found, &ranked, &apart, durations_s),
            settings_table(&settings)
        ),
    };
    let mut came_to = vec![paths(run, baseline)?, apart.figure()];
    for (index, one) in ranked.iter().take(DRAWN).enumerate() {
        came_to.push(over_the_run(index, one, run, baseline)?);
    }
    let mut began = Vec::new();
    for (index, one) in found.iter().take(DRAWN_AT_FIRST).enumerate() {
        began.push(around_the_first(index, one, run, baseline)?);
    }
    let sections = [
        Section {
            id: "came-to",
            title: "Result",
            lead: "Over the whole run, what matters most first: differences by their share of what the signal does in the baseline."
                .to_owned(),
            body: grid(&came_to),
        },
        Section {
            id: "began",
            title: "Where it began",
            lead: format!(
                "The signals that left first, {ROWS_AROUND} rows before and after: a dot is a row of the trace."
            ),
            body: grid(&began),
        },
        Section {
            id: "signals",
            title: "Every signal that differs",
            lead: String::new(),
            body: page::topic(
                "All signals",
                &format!("{} of them, what matters most first", found.len()),
                &signals_table(&ranked),
            ),
        },
    ];
    let footer = "<p>A signal may differ by its tolerance in <code>[expect.tolerances]</code>; one without must be equal to \
                  the bit. Curves over the whole run are thinned for the screen.</p>";
    Ok(viewer::page(&head, &sections, footer, !stage.is_empty()))
}

/// Reports the result and the first difference in sentences, as HTML.
fn story(found: &[Difference], ranked: &[Ranked], apart: &Apart, durations_s: [f64; 2]) -> String {
    let Some(first) = found.first() else {
        return "<p>The run <b>is its baseline</b>, to the tolerance of every signal.</p>"
            .to_owned();
    };
    let mut lines = vec![apart.sentence()];
    if (durations_s[0] - durations_s[1]).abs() > 1e-9 {
        lines.push(format!(
            "The run ends at {}, the baseline at {}.",
            time(durations_s[0]),
            time(durations_s[1])
        ));
    }
    lines.push(format!(
        "The first to leave was <code>{}</code> at <b>{} s</b>: {} instead of {}.",
        escape(&first.signal),
        first.first_s,
        first
            .run
            .map_or_else(|| "no value".to_owned(), |x| value(&first.signal, x)),
        first
            .baseline
            .map_or_else(|| "none".to_owned(), |x| value(&first.signal, x)),
    ));
    let most: Vec<String> = ranked
        .iter()
        .filter(|ranked| ranked.share >= 0.001)
        .take(3)
        .map(|Ranked { one, share }| {
            format!(
                "<code>{}</code> by {} ({})",
                escape(&one.signal),
                value(&one.signal, one.worst),
                of_its_span(*share)
            )
        })
        .collect();
    lines.push(match most.is_empty() {
        true => "No signal differs by as much as a thousandth of what it does.".to_owned(),
        false => format!("What differs most: {}.", most.join(", ")),
    });
    lines.iter().map(|line| format!("<p>{line}</p>")).collect()
}

/// The table of different settings, if any.
fn settings_table(settings: &[SettingRow]) -> String {
    if settings.is_empty() {
        return "<p class=\"lead\">Both were run from the same scenario.</p>\n".to_owned();
    }
    let rows: String = settings.iter().map(compare::settings_row).collect();
    wide(&table(
        "What was set differently",
        &heads(["key", "baseline", "run"]),
        &rows,
    ))
}

/// Distance of the robot from its place in the baseline, row by row.
struct Apart {
    /// Time in seconds, distance in metres, angle between the headings in radians.
    rows: Vec<(f64, f64, f64)>,
}

impl Apart {
    fn of<R: Rows>(run: &R, baseline: &R) -> Result<Self, R::Error> {
        let columns = |rows: &R| -> Result<[Vec<Option<f64>>; 3], R::Error> {
            Ok([
                rows.values("truth_x_m")?,
                rows.values("truth_y_m")?,
                rows.values("truth_heading_rad")?,
            ])
        };
        let (times_s, ours, theirs) = (run.values("t_s")?, columns(run)?, columns(baseline)?);
        let off = |row: usize| {
            let by = |k: usize| {
                let [ours, theirs] = [&ours, &theirs].map(|of| of[k].get(row).copied().flatten());
                Some(ours? - theirs?)
            };
            Some((
                times_s[row]?,
                by(0)?.hypot(by(1)?),
                ilon_robot::wrap_angle(by(2)?).abs(),
            ))
        };
        Ok(Self {
            rows: (0..times_s.len()).filter_map(off).collect(),
        })
    }

    fn largest(&self, of: impl Fn(&(f64, f64, f64)) -> f64) -> (f64, f64) {
        let rows = self.rows.iter().map(|row| (row.0, of(row)));
        rows.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }

    fn sentence(&self) -> String {
        let (at_s, apart_m) = self.largest(|row| row.1);
        let (turned_at_s, turned_rad) = self.largest(|row| row.2);
        if apart_m < SAME_M && turned_rad < SAME_RAD {
            return "The run is not its baseline to the bit, but the robot <b>drives as it did</b>: its paths lie within a micrometre."
                .to_owned();
        }
        let end = self.rows.last().map_or(String::new(), |last| {
            format!("; at the end {} and {}", length(last.1), angle(last.2))
        });
        format!(
            "The robot is up to <b>{}</b> from where it was in the baseline, at <b>{}</b>, and up to <b>{}</b> turned, at {}{end}.",
            length(apart_m),
            time(at_s),
            angle(turned_rad),
            time(turned_at_s)
        )
    }

    fn figure(&self) -> Figure {
        let place = self.rows.iter().map(|row| (row.0, 1e3 * row.1));
        let heading = self.rows.iter().map(|row| (row.0, row.2.to_degrees()));
        Figure::over_time(
            "apart",
            "Run and baseline apart",
            "The distance between their places, and the angle between their headings.",
            vec![
                curve("distance in mm", place, RUN),
                curve("angle in degrees", heading, dotted("@w2").width(2.2)),
            ],
            axis("mm, degrees"),
        )
        .height_px(300)
    }
}

/// Returns a signal over time: time in seconds and value, where present.
fn points<R: Rows>(rows: &R, signal: &str) -> Result<Vec<(f64, f64)>, R::Error> {
    let pairs = rows.values("t_s")?.into_iter().zip(rows.values(signal)?);
    Ok(pairs
        .filter_map(|(t_s, value)| Some((t_s?, value?)))
        .collect())
}

/// Draws both traces row by row around the first difference.
fn around_the_first<R: Rows>(
    index: usize,
    one: &Difference,
    run: &R,
    baseline: &R,
) -> Result<Figure, R::Error> {
    let half_s = ROWS_AROUND as f64 * run.header().row_dt_s();
    let near = |rows: &R| -> Result<Vec<(f64, f64)>, R::Error> {
        let mut points = points(rows, &one.signal)?;
        points.retain(|(t_s, _)| (t_s - one.first_s).abs() <= half_s);
        Ok(points)
    };
    let (ours, theirs) = (near(run)?, near(baseline)?);
    let values = || ours.iter().chain(&theirs).map(|(_, value)| *value);
    let (low, high) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let mut curves: Vec<Curve> = vec![
        exact_curve("baseline", theirs.iter().copied(), BASELINE),
        exact_curve("run", ours.iter().copied(), RUN),
        dots("rows of the run", ours.iter().copied(), "@real", 6).unlisted(),
    ];
    if one.tolerance > 0.0 {
        for (name, sign) in [("tolerance", 1.0), ("", -1.0)] {
            let edge = theirs
                .iter()
                .map(|(t_s, value)| (*t_s, value + sign * one.tolerance));
            curves.push(exact_curve(name, edge, dotted("@limit")));
        }
    }
    if low.is_finite() && high.is_finite() {
        let mark = [(one.first_s, low), (one.first_s, high)];
        curves.push(exact_curve(
            "first difference",
            mark.into_iter(),
            dotted("@fg"),
        ));
    }
    Ok(Figure::new(
        format!("began-{index}"),
        one.signal.clone(),
        format!("{}.", escape(&one.to_string())),
        plot(curves, layout("t in s", &one.signal)),
    )
    .height_px(300))
}

/// Draws a signal of both over the whole run.
fn over_the_run<R: Rows>(
    index: usize,
    Ranked { one, share }: &Ranked,
    run: &R,
    baseline: &R,
) -> Result<Figure, R::Error> {
    let mut curves: Vec<Curve> = vec![
        curve(
            "baseline",
            points(baseline, &one.signal)?.into_iter(),
            BASELINE,
        ),
        curve("run", points(run, &one.signal)?.into_iter(), RUN),
    ];
    if one.tolerance > 0.0 {
        for (name, sign) in [("tolerance", 1.0), ("", -1.0)] {
            let edge = points(baseline, &one.signal)?
                .into_iter()
                .map(|(t_s, value)| (t_s, value + sign * one.tolerance));
            curves.push(curve(name, edge, dotted("@limit")));
        }
    }
    Ok(Figure::over_time(
        format!("came-to-{index}"),
        one.signal.clone(),
        format!(
            "At worst {} off, {} in the baseline; {}.",
            escape(&value(&one.signal, one.worst)),
            of_its_span(*share),
            escape(&allowed(&one.signal, one.tolerance)),
        ),
        curves,
        axis(&one.signal),
    )
    .height_px(300))
}

/// Draws both paths from above.
fn paths<R: Rows>(run: &R, baseline: &R) -> Result<Figure, R::Error> {
    let way = |rows: &R| -> Result<Vec<(f64, f64)>, R::Error> {
        let (x_m, y_m) = (rows.values("truth_x_m")?, rows.values("truth_y_m")?);
        let places = x_m.into_iter().zip(y_m);
        Ok(places.filter_map(|(x, y)| Some((x?, y?))).collect())
    };
    let thin = |way: Vec<(f64, f64)>| {
        super::decimate::evenly(way.len(), super::decimate::MAX_POINTS)
            .into_iter()
            .map(move |row| way[row])
    };
    let curves: Vec<Curve> = vec![
        exact_curve("baseline", thin(way(baseline)?), BASELINE),
        exact_curve("run", thin(way(run)?), RUN),
    ];
    Ok(Figure::new(
        "paths",
        "The paths, from above",
        "Where the body frame's origin really went.",
        plot(curves, map_layout()),
    )
    .height_px(300))
}

fn signals_table(ranked: &[Ranked]) -> String {
    let signal = |Ranked { one, share }: &Ranked| {
        let shown = |x: Option<f64>| cell(x.map(|x| escape(&value(&one.signal, x))));
        let cells = [
            cell(Some(percent(*share))),
            shown(Some(one.worst)),
            shown(Some(one.tolerance)),
            shown(one.baseline),
            shown(one.run),
            cell(Some(format!("{} s", one.first_s))),
        ];
        row(
            &format!("<code>{}</code>", escape(&one.signal)),
            &cells.concat(),
        )
    };
    let titles = [
        "signal",
        "of its span",
        "largest difference",
        "allowed",
        "baseline at first",
        "run at first",
        "first at",
    ];
    wide(&table(
        "",
        &heads(titles),
        &ranked.iter().map(signal).collect::<String>(),
    ))
}

#[cfg(test)]
mod tests;
