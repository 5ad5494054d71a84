//! The page of `ilon bench`, in the style of the report of a run: error over cost, and all figures.

use std::fmt::Write;

use crate::bench::{
    Bench, CONFIGURATION_COLUMNS, Configuration, DRIVES, FLEET_RATE_HZ, Machine, RobotBench,
    SLIDE_COLUMNS, TreadCost,
};
use crate::figure::{Curve, DashKind, Figure, Layout, Pen, Span, axis, exact_curve, plot, solid};
use crate::html_table::{cell, heads, number, row, table, wide};
use crate::page::{self, Head, Section, card, escape, grid, side_by_side};
use crate::text::capital;
use ilon_trace::significant;

/// Smaller errors, in percent, are drawn at this value: a logarithm has no zero.
const LEAST_ERROR_PCT: f64 = 1e-5;

/// Returns the page as one self-contained HTML file.
pub fn html(bench: &Bench) -> String {
    let names: Vec<&str> = bench.robots.keys().map(String::as_str).collect();
    let head = Head {
        kind: "bench",
        title: format!("Accuracy and speed: {}", names.join(" · ")),
        facts: facts(&bench.machine),
        lead: story(bench) + &tiles(bench),
    };
    let mut sections = vec![
        Section {
            id: "work-precision",
            title: "Error against cost",
            lead: "Lower is more accurate, left is faster. The figures at the points are physics steps a second.".to_owned(),
            body: grid(&[work_precision(bench)]),
        },
        Section {
            id: "configurations",
            title: "Every configuration",
            lead: "Errors in per cent, the worst over the headings; the fastest that is off by 0.1 % at most, \
                   or the most accurate where none is, is set in bold."
                .to_owned(),
            body: configurations(bench),
        },
    ];
    if !bench.throughput.is_empty() {
        sections.push(fleet_section(bench));
    }
    sections.push(method_section(bench));
    page::page(&head, &sections, &footer(bench), &page::Parts::default())
}

/// Returns machine, date and versions, as HTML.
fn facts(machine: &Machine) -> Vec<String> {
    let mut facts = Vec::new();
    if let Some(processor) = &machine.processor {
        facts.push(format!("<b>{}</b>", escape(processor)));
    }
    if let Some(cores) = machine.cores {
        facts.push(format!("<b>{cores}</b> threads at once"));
    }
    facts.push(escape(&machine.system));
    facts.extend(
        (machine.versions.iter())
            .map(|(name, version)| format!("{} <b>{}</b>", escape(name), escape(version))),
    );
    facts.push(escape(&machine.date));
    if !machine.optimised {
        facts.push("<b>a build for debugging: its speeds mean nothing</b>".to_owned());
    }
    facts
}

/// Returns the answer for all robots, and a sentence per robot, the fastest first, as HTML.
fn story(bench: &Bench) -> String {
    let mut lines = verdict(bench);
    let mut robots: Vec<(&String, &RobotBench)> = bench.robots.iter().collect();
    let speed = |robot: &RobotBench| robot.sim_s_per_cpu_s.unwrap_or(0.0);
    robots.sort_by(|a, b| speed(b.1).total_cmp(&speed(a.1)));
    for (name, robot) in robots {
        let speed = robot.sim_s_per_cpu_s.map_or_else(String::new, |speed| {
            format!(" at <b>{} times real time</b> on one core", figure(speed))
        });
        let _ = write!(
            lines,
            "<p><b>{}</b>: error <b>{} %</b>{speed}, with {}.</p>",
            escape(name),
            figure(robot.worst_error_pct),
            escape(&robot.headline)
        );
    }
    format!("<div class=\"story\">{lines}</div>\n")
}

/// Returns the statement for all robots.
fn verdict(bench: &Bench) -> String {
    let worst_pct = bench.robots.values().map(|r| r.worst_error_pct);
    let worst_pct = worst_pct.fold(0.0, f64::max);
    let speeds: Vec<f64> = (bench.robots.values())
        .filter_map(|robot| robot.sim_s_per_cpu_s)
        .collect();
    if speeds.is_empty() || bench.robots.len() < 2 {
        return String::new();
    }
    let slowest = speeds.iter().copied().fold(f64::INFINITY, f64::min);
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    let range = if figure(slowest) == figure(fastest) {
        figure(fastest)
    } else {
        format!("{} to {}", figure(slowest), figure(fastest))
    };
    format!(
        "<p>{} robots: error <b>{} %</b> or less at <b>{range} times real time</b> on one core.</p>",
        bench.robots.len(),
        figure(worst_pct)
    )
}

fn tiles(bench: &Bench) -> String {
    let mut tiles = Vec::new();
    for (name, robot) in &bench.robots {
        let best = |of: fn(&Configuration) -> bool| {
            let errors = robot.configurations.iter().filter(|c| of(c));
            errors.map(|c| c.worst_error_pct).reduce(f64::min)
        };
        for (kind, error) in [
            ("all rollers", best(|c| c.roller_bodies == "all")),
            ("contact window", best(|c| c.roller_bodies == "near")),
        ] {
            tiles.extend(error.map(|pct| (format!("least error, {name}, {kind}"), pct, "%")));
        }
        let steps = robot.steps_per_cpu_s.map(|steps| steps / 1e3);
        tiles.extend(steps.map(|x| (format!("steps a CPU second, {name}"), x, "k")));
    }
    let most = |threads: usize| {
        let of = bench.throughput.iter().filter(|t| t.threads == threads);
        of.max_by_key(|t| t.robots)
    };
    if let (Some(one), Some(several)) = (most(1), bench.throughput.last())
        && several.threads > 1
        && one.robots == several.robots
        // If threads had to share their cores with other processes, the figure is meaningless.
        && several.cores.is_some_and(|cores| cores > 0.95 * several.threads as f64)
    {
        let gain = several.sim_s_per_wall_s / one.sim_s_per_wall_s;
        let (robots, threads) = (several.robots, several.threads);
        tiles.push((
            format!("{threads} threads over one, {robots} robots"),
            gain,
            "×",
        ));
    }
    let tiles: String = tiles
        .into_iter()
        .map(|(what, x, unit)| {
            format!(
                "<div class=\"tile\"><dt>{}</dt><dd>{}<small>{unit}</small></dd></div>",
                escape(&what),
                figure(x)
            )
        })
        .collect();
    format!("<dl class=\"tiles\">{tiles}</dl>\n")
}

/// Returns three significant digits, without an exponent.
fn figure(x: f64) -> String {
    significant(x, 3).to_string()
}

/// The pen of a robot and kind: colours by robot, dashes by kind.
fn pen(robot: usize, roller_bodies: &str) -> Pen {
    const COLORS: [&str; 6] = ["@w0", "@w1", "@w2", "@w3", "@w5", "@w4"];
    let dash = match roller_bodies {
        "near" => DashKind::Solid,
        "rapier" => DashKind::Dot,
        _ => DashKind::Dash,
    };
    Pen {
        dash,
        ..solid(COLORS[robot % COLORS.len()]).width(2.2)
    }
}

/// Error over cost, both logarithmic, a curve for each robot and kind.
fn work_precision(bench: &Bench) -> Figure {
    let mut curves: Vec<Curve> = Vec::new();
    for (index, (name, robot)) in bench.robots.iter().enumerate() {
        // The first two curves of a robot may coincide; the labels of their points do not.
        for (kind, words, below) in [
            ("all", "all rollers", false),
            ("near", "contact window", true),
            ("rapier", "contacts by rapier", false),
        ] {
            let of_kind = robot
                .configurations
                .iter()
                .filter(|c| c.roller_bodies == kind);
            let points: Vec<_> = of_kind
                .filter_map(|c| Some((c, c.cpu_s_per_sim_s()?)))
                .collect();
            if !points.is_empty() {
                let name = format!("{name}, {words}");
                curves.push(labelled(&name, &points, pen(index, kind), below));
            }
        }
    }
    let layout = Layout::of(
        axis("CPU time for a simulated second in ms").log(),
        axis("worst error of D1 to D5 in %").log(),
    );
    Figure::new(
        "work-precision-plot",
        "Worst error against cost",
        "Each point is a step size: all five drives, all headings. Where a curve rises to the left, longer steps \
         cost accuracy; where it is flat, they are free.",
        plot(curves, layout),
    )
    .height_px(340)
    .spanning(Span::Whole)
}

/// A curve whose points are labelled with their steps per second.
fn labelled(name: &str, points: &[(&Configuration, f64)], pen: Pen, below: bool) -> Curve {
    let at = points
        .iter()
        .map(|(c, cpu_s)| (1e3 * cpu_s, c.worst_error_pct.max(LEAST_ERROR_PCT)));
    let rates = points.iter().map(|(c, _)| c.rate_hz().to_string());
    exact_curve(name, at, pen)
        .with_dots(7)
        .labels(rates.collect(), below)
}

fn configurations(bench: &Bench) -> String {
    let tables = bench.robots.iter();
    side_by_side(
        &tables
            .map(|(name, robot)| table_of(name, robot))
            .collect::<String>(),
    )
}

fn table_of(name: &str, robot: &RobotBench) -> String {
    let configuration = |c: &Configuration| {
        let cells = cell(Some(c.rate_hz().to_string())) + &numbers(&c.figures());
        let class = match c.describe() == robot.headline {
            true => " class=\"total\"",
            false => "",
        };
        format!(
            "<tr{class}><th scope=\"row\">{}</th>{cells}</tr>\n",
            escape(&c.roller_bodies)
        )
    };
    let before = ["rollers", "steps/s", "worst"].into_iter();
    let drives = DRIVES.map(|(name, _)| name);
    let titles = before.chain(drives).chain(CONFIGURATION_COLUMNS);
    let table = table(
        "Errors and spread in %, ripple in mm, slip in mm/s",
        &heads(titles),
        &robot
            .configurations
            .iter()
            .map(configuration)
            .collect::<String>(),
    );
    wide(&format!(
        "<h3>{}</h3>{table}{}",
        escape(name),
        sentences(robot)
    )) + &headings_table(name, robot)
        + &transients_table(name, robot)
}

/// The table of drives with sliding wheels, if measured.
fn transients_table(name: &str, robot: &RobotBench) -> String {
    if robot.transients.is_empty() {
        return String::new();
    }
    let mut rows = String::new();
    for transient in &robot.transients {
        for (solver, slide) in transient.rows() {
            let drive = format!("{}: {solver}", escape(&transient.name));
            rows += &(row(&drive, &numbers(&slide.figures())) + "\n");
        }
    }
    let table = table(
        "Ways in mm, \"apart\" from ilon's course at steps of 0.25 ms; heat of contacts in J, fastest slip in mm/s, unexplained \
         energy in %",
        &(heads(["drive"]) + &heads(SLIDE_COLUMNS)),
        &rows,
    );
    wide(&format!(
        "<h3>{}: sliding on friction 0.3</h3>{table}",
        escape(name)
    ))
}

/// Reports what was left out, and the cost of treads, if timed.
fn sentences(robot: &RobotBench) -> String {
    let said = robot.tread.as_ref().map(TreadCost::said);
    let sentence = |said: String| format!("<p>{}.</p>", escape(&capital(&said)));
    let remarks = robot.remarks.iter().cloned();
    remarks.chain(said).map(sentence).collect()
}

/// Each drive's error by heading, if there are several.
fn headings_table(name: &str, robot: &RobotBench) -> String {
    let Some(first) = robot
        .configurations
        .first()
        .and_then(|c| c.drives.values().next())
    else {
        return String::new();
    };
    if first.headings.len() < 2 {
        return String::new();
    }
    let columns = || (0..first.headings.len()).flat_map(|k| DRIVES.map(|(name, _)| (k, name)));
    let titles = columns().map(|(k, name)| format!("{name}, {}°", first.headings[k].heading_deg));
    let configuration = |c: &Configuration| {
        let error = |(k, name): (usize, &str)| {
            let heading = c.drives.get(name).and_then(|d| d.headings.get(k));
            number(heading.map(|h| h.error_pct), 4)
        };
        let head = format!("{}, {}", escape(&c.roller_bodies), c.rate_hz());
        row(&head, &columns().map(error).collect::<String>())
    };
    let table = table(
        "Errors in %",
        &(heads(["rollers, steps/s"]) + &heads(titles)),
        &robot
            .configurations
            .iter()
            .map(configuration)
            .collect::<String>(),
    );
    format!(
        "<details class=\"whole\"><summary>{}, heading by heading</summary><div class=\"scroll\" tabindex=\"0\">{table}</div>\
         </details>\n",
        escape(name)
    )
}

/// Cells with numbers and their decimals.
fn numbers(figures: &[(Option<f64>, usize)]) -> String {
    let cells = figures
        .iter()
        .map(|(value, places)| number(*value, *places));
    cells.collect()
}

fn fleet_section(bench: &Bench) -> Section {
    let speeds = bench.throughput.iter().map(|t| {
        let threads = cell(Some(t.threads.to_string()));
        row(&t.robots.to_string(), &(threads + &numbers(&t.figures())))
    });
    let titles = [
        "robots",
        "threads",
        "sim s a wall s",
        "sim s a CPU s",
        "cores",
        "efficiency",
    ];
    let robot = bench.throughput.first().map_or("", |t| t.robot.as_str());
    let table = table(
        &format!(
            "{}, contact window, {FLEET_RATE_HZ} steps a second",
            escape(robot)
        ),
        &heads(titles),
        &speeds.collect::<String>(),
    );
    let table = format!("<div class=\"card scroll\" tabindex=\"0\">{table}</div>\n");
    Section {
        id: "many",
        title: "Many robots in one process",
        lead: "Robots are independent of each other, and stepped from outside: each by 50 ms at a time, without a record. Efficiency is the speed over that of the same robots on one thread, by \
               the number of threads. Cores is how many the threads really had: CPU time over wall clock."
            .to_owned(),
        body: side_by_side(&(card(&fleet(bench)) + &table)),
    }
}

/// Speed of all robots over their number, a curve per number of threads.
fn fleet(bench: &Bench) -> Figure {
    let mut threads: Vec<usize> = bench.throughput.iter().map(|t| t.threads).collect();
    threads.dedup();
    let curves = threads.into_iter().enumerate().map(|(index, threads)| {
        let of = bench.throughput.iter().filter(|t| t.threads == threads);
        let points = of.map(|t| (t.robots as f64, t.sim_s_per_wall_s));
        let name = if threads == 1 {
            "one thread".to_owned()
        } else {
            format!("{threads} threads")
        };
        let pen = crate::figure::wheel_pen(index).width(2.2);
        exact_curve(&name, points, pen).with_dots(7)
    });
    let layout = Layout::of(
        axis("robots").log(),
        axis("simulated s a second of wall clock").from_zero(),
    );
    Figure::new(
        "fleet",
        "All robots together",
        "A level curve is a cost that is linear in the number of robots. Other work on the machine counts here.",
        plot(curves.collect(), layout),
    )
}

fn method_section(bench: &Bench) -> Section {
    let headings: Vec<String> = bench
        .headings_deg
        .iter()
        .map(|deg| format!("{deg}°"))
        .collect();
    // Numbers and names always serialise.
    let json = serde_json::to_string(bench).unwrap_or_default();
    Section {
        id: "method",
        title: "How it was measured",
        lead: String::new(),
        body: format!(
            "<div class=\"card whole\"><p><b>Drives.</b> Open loop on a level floor of friction 0.6, wheels driven by torques \
             from their loops: D1 forward 0.3 m/s, D2 lateral 0.3 m/s, D3 yaw 1 rad/s, D4 diagonal 0.2 + 0.2 m/s, D5 arc \
             0.3 m/s with 0.5 rad/s; at headings of {}.</p>\
             <p><b>Error.</b> After 1 s of rest and 0.5 s of ramp the twist is held for 4 s, of which the last 3 s count: the \
             worst deviation of a driven component's mean from the contact kinematics, which is the twist without slip at \
             the rollers that touch, by least squares over the wheels.</p>\
             <p><b>Ripple and slip.</b> The largest ripple of a hub's height and the largest rms sliding speed of the touching \
             rollers, over drives and headings.</p>\
             <p><b>Speed.</b> The whole loop (sensors, wheel loops, motors, world, recording with a row of the trace a \
             second): simulated time over the CPU time of its one thread, while the twist is held, after 1 s of warm-up. A \
             stretch is a simulated second or more, and 20 ms of CPU time; of each drive the best counts, of several rounds through all configurations. <i>Spread</i> \
             is how much longer the middle one of the stretches took, in the worst drive.</p>\
             <p><b>Many robots.</b> All alive in one process and advanced in turn, warmed up; simulated time of all together \
             over wall clock, the best stretch.</p></div>\n\
             <script type=\"application/json\" id=\"bench\">{}</script>\n",
            headings.join(", "),
            page::json_in_script(&json)
        ),
    }
}

fn footer(bench: &Bench) -> String {
    format!(
        "<p>Measured on {} by <code>ilon bench</code>, which repeats it on your machine. All figures are in \
         <code>bench.json</code>, and in this page. A click on a name in a legend hides that curve.</p>",
        escape(&bench.machine.date)
    )
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::bench::Throughput;

    /// Forty robots on one thread, and on four of which each is 0.9 times as fast.
    fn fleet(cores: Option<f64>) -> Bench {
        let on = |threads: usize, sim_s_per_wall_s: f64, cores: Option<f64>| Throughput {
            robot: "mecanum4".to_owned(),
            robots: 40,
            threads,
            sim_s_per_wall_s,
            sim_s_per_cpu_s: None,
            cores,
            efficiency: None,
        };
        Bench {
            machine: Machine {
                processor: None,
                cores: Some(4),
                system: String::new(),
                versions: Vec::new(),
                optimised: true,
                date: String::new(),
            },
            headings_deg: vec![0.0],
            robots: BTreeMap::new(),
            throughput: vec![on(1, 50.0, Some(1.0)), on(4, 180.0, cores)],
        }
    }

    /// Four threads that had 3.9 cores are 3.6 times as fast as one. With three cores, or an
    /// unknown number, the figure would depend on other programs.
    #[test]
    fn the_gain_of_threads_is_shown_where_they_had_their_cores() {
        let shows =
            |cores: Option<f64>| tiles(&fleet(cores)).contains("4 threads over one, 40 robots");
        assert!(shows(Some(3.9)));
        assert!(tiles(&fleet(Some(3.9))).contains("<dd>3.6"));
        for shared in [None, Some(3.0), Some(0.9)] {
            assert!(!shows(shared), "{shared:?}");
        }
    }
}
