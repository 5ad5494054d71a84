//! A run that left its baseline, drawn: where it began, what it came to, and every signal that took part.

use std::fmt::Write;
use std::path::Path;

use ilon_trace::file::write_text;
use ilon_trace::{Difference, Rows, TraceError, number};

use crate::figure::{
    Curve, Figure, Pen, Span, curve, dashed, dots, dotted, exact_curve, layout, map_layout, plot,
    solid,
};
use crate::page::{self, Head, Section, escape, grid};

/// Rows before and after the first difference that are drawn one by one.
const ROWS_AROUND: usize = 25;

/// How many signals are drawn; the table has them all.
const DRAWN: usize = 6;

const RUN: Pen = solid("@real").width(2.2);
const BASELINE: Pen = dashed("@asked");

/// Writes what `differences` found, the earliest first, to a file, whole or not at all. A few signals at a time are held
/// in memory.
///
/// # Errors
/// [`TraceError::Io`] where the file cannot be written, and where the rows cannot be read.
pub fn write<R: Rows>(
    path: &Path,
    run: &R,
    baseline: &R,
    found: &[Difference],
) -> Result<(), TraceError>
where
    TraceError: From<R::Error>,
{
    write_text(path, &html(run, baseline, found)?)
}

/// The differences between a run and its baseline as one HTML file that needs nothing else.
///
/// # Errors
/// Where the rows cannot be read.
pub fn html<R: Rows>(run: &R, baseline: &R, found: &[Difference]) -> Result<String, R::Error> {
    let duration_s = |rows: &R| -> Result<f64, R::Error> {
        let last_s = rows.values("t_s")?.last().copied().flatten();
        Ok(last_s.map_or(0.0, |last_s| rows.header().row_end_s(last_s)))
    };
    let lead = match found.first() {
        None => "<p class=\"lead\">The run is its baseline.</p>".to_owned(),
        Some(first) => format!("<p class=\"lead\">{}.</p>", escape(&first.to_string())),
    };
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
                duration_s(run)?,
                duration_s(baseline)?
            ),
        ],
        lead,
    };
    let drawn = || found.iter().take(DRAWN).enumerate();
    let (mut began, mut came_to) = (Vec::new(), vec![paths(run, baseline)?]);
    for (index, one) in drawn() {
        began.push(around_the_first(index, one, run, baseline)?);
        came_to.push(over_the_run(index, one, run, baseline)?);
    }
    let sections = [
        Section {
            id: "began",
            title: "Where it began",
            lead: format!(
                "The signals that left first, {ROWS_AROUND} rows before and after: a dot is a row of the trace."
            ),
            body: grid(&began),
        },
        Section {
            id: "came-to",
            title: "What it came to",
            lead: "Over the whole run.".to_owned(),
            body: grid(&came_to),
        },
        Section {
            id: "signals",
            title: "Every signal that differs",
            lead: "In the order in which they left.".to_owned(),
            body: table(found),
        },
    ];
    let footer = "<p>A signal may differ by its tolerance in <code>[expect.tolerances]</code>; one without must be equal to \
                  the bit. Curves over the whole run are thinned for the screen.</p>";
    Ok(page::page(
        &head,
        &sections,
        footer,
        &page::Parts::default(),
    ))
}

/// A signal over time: time in seconds and value, where there is one.
fn points<R: Rows>(rows: &R, signal: &str) -> Result<Vec<(f64, f64)>, R::Error> {
    let pairs = rows.values("t_s")?.into_iter().zip(rows.values(signal)?);
    Ok(pairs
        .filter_map(|(t_s, value)| Some((t_s?, value?)))
        .collect())
}

/// Both traces row by row around the first difference.
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
    Ok(Figure {
        id: format!("began-{index}"),
        title: one.signal.clone(),
        caption: format!("{}.", escape(&one.to_string())),
        height_px: 300,
        span: Span::Half,
        over_time: false,
        plot: plot(curves, layout("t in s", &one.signal)),
    })
}

/// By how much a signal is off over the whole run. Rows are compared as the judge compares them: one by one.
fn over_the_run<R: Rows>(
    index: usize,
    one: &Difference,
    run: &R,
    baseline: &R,
) -> Result<Figure, R::Error> {
    let (ours, theirs) = (run.values(&one.signal)?, baseline.values(&one.signal)?);
    let rows = run
        .values("t_s")?
        .into_iter()
        .zip(ours.into_iter().zip(theirs));
    let off: Vec<(f64, f64)> = rows
        .filter_map(|(t_s, (ours, theirs))| Some((t_s?, ours? - theirs?)))
        .collect();
    let mut curves: Vec<Curve> = Vec::new();
    if let (Some(first), Some(last), true) = (off.first(), off.last(), one.tolerance > 0.0) {
        for (name, sign) in [("tolerance", 1.0), ("", -1.0)] {
            let edge = [first.0, last.0].map(|t_s| (t_s, sign * one.tolerance));
            curves.push(exact_curve(name, edge.into_iter(), dotted("@limit")));
        }
    }
    curves.push(curve("run minus baseline", off.into_iter(), RUN));
    Ok(Figure {
        id: format!("came-to-{index}"),
        title: format!("{}: run minus baseline", one.signal),
        caption: format!(
            "At worst {} off, where {} is allowed.",
            number(one.worst),
            number(one.tolerance)
        ),
        height_px: 300,
        span: Span::Half,
        over_time: true,
        plot: plot(curves, layout("t in s", &one.signal)),
    })
}

/// Both ways from above.
fn paths<R: Rows>(run: &R, baseline: &R) -> Result<Figure, R::Error> {
    let way = |rows: &R| -> Result<Vec<(f64, f64)>, R::Error> {
        let (x_m, y_m) = (rows.values("truth_x_m")?, rows.values("truth_y_m")?);
        let places = x_m.into_iter().zip(y_m);
        Ok(places.filter_map(|(x, y)| Some((x?, y?))).collect())
    };
    let thin = |way: Vec<(f64, f64)>| {
        super::thin::evenly(way.len(), super::thin::MAX_POINTS)
            .into_iter()
            .map(move |row| way[row])
    };
    let curves: Vec<Curve> = vec![
        exact_curve("baseline", thin(way(baseline)?), BASELINE),
        exact_curve("run", thin(way(run)?), RUN),
    ];
    Ok(Figure {
        id: "paths".to_owned(),
        title: "The way, from above".to_owned(),
        caption: "Where the body frame's origin really went.".to_owned(),
        height_px: 300,
        span: Span::Half,
        over_time: false,
        plot: plot(curves, map_layout()),
    })
}

fn table(found: &[Difference]) -> String {
    let value = |value: Option<f64>| value.map_or("–".to_owned(), number);
    let mut rows = String::new();
    for one in found {
        // Writing to a string cannot fail.
        let _ = write!(
            rows,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(&one.signal),
            one.first_s,
            value(one.baseline),
            value(one.run),
            number(one.worst),
            number(one.tolerance),
        );
    }
    format!(
        "<div class=\"card whole scroll\"><table><thead><tr><th>signal</th><th>first at, s</th><th>baseline there</th>\
         <th>run there</th><th>largest difference</th><th>allowed</th></tr></thead><tbody>{rows}</tbody></table></div>\n"
    )
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use ilon_trace::Trace;

    use super::*;
    use crate::sample::made_up_run;
    use ilon_trace::differences;

    #[test]
    fn the_page_draws_the_signal_that_left_first_and_tells_all_of_them() {
        let baseline = made_up_run(2.0, true);
        let mut run = Trace::with_capacity(baseline.header.clone(), baseline.records().len());
        for (record, wheels) in baseline.steps() {
            let (mut record, mut wheels) = (*record, wheels.to_vec());
            if record.t_s >= 0.5 {
                wheels[1].torque_n_m += 0.01;
            }
            if record.t_s >= 1.0 {
                record.truth.pose.x_m += 0.001;
            }
            run.push(record, &wheels);
        }
        let Ok(found) = differences(&run, &baseline, &BTreeMap::new());
        let Ok(html) = html(&run, &baseline, &found);
        assert!(html.contains("wheel1_torque_n_m leaves its baseline at 0.5 s"));
        assert!(html.contains("<b>2</b> of"));
        for place in ["began-0", "began-1", "came-to-1", "paths"] {
            assert!(
                html.contains(&format!("data-figure=\"{place}\"")),
                "{place}"
            );
        }
        assert_eq!(html.matches("<tr><th scope=\"row\">").count(), 2);
    }

    #[test]
    fn a_run_of_other_signals_is_drawn_too() {
        let (open, closed) = (made_up_run(1.0, true), made_up_run(1.0, false));
        let Ok(found) = differences(&open, &closed, &BTreeMap::new());
        let Ok(html) = html(&open, &closed, &found);
        assert!(html.contains("desired_x_m"));
    }
}
