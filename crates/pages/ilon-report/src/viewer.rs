//! The viewer of a run, or of a robot alone: the scene in three dimensions, the track of events,
//! and the slider of the page's time.

use std::fmt::Write;

use ilon_formats::{LoadRobot, link_tree};
use ilon_robot::Robot;
use ilon_scene::{Description, OtherWay, Scene, Thinning, embed, frames_of_run};
use ilon_trace::{Header, Rows};
use serde_json::json;

use super::html_table::{table, wide};
use super::page::{self, Head, Parts, Section, escape, json_in_script};
use super::story::{Event, EventKind};
use ilon_trace::significant;

/// The script of clock, slider, keys and events.
const SCRIPT: &str = include_str!("web/clock.js");

/// Frames of a run in the page: half a screen's frame rate looks smooth, and the page stays small.
const THINNING: Thinning = Thinning {
    rate_hz: 30.0,
    most: 1500,
};

/// Largest number of events in a lane of the track: the most important ones.
const MOST_A_LANE: usize = 60;

/// A scene in the format of a page.
pub(crate) struct Picture {
    /// The scene as JSON.
    pub json: String,
    /// What was left out or simplified in the robot's appearance.
    pub remarks: Vec<String>,
    /// Other paths for the ghost.
    pub ways: Vec<String>,
}

/// Returns the scene of a run as data for `ilonScene`, with the frames of the existing rows;
/// without rows, it accepts frames later. `relief_m` are the heights of the ground's relief, row by
/// row, in metres. `None` if the robot is another one.
pub fn scene_of(
    trace: &ilon_trace::Trace,
    robot: &Robot,
    relief_m: Option<&[Vec<f64>]>,
) -> Option<String> {
    let Ok(picture) = picture_of(trace, Some(robot), relief_m, Vec::new());
    picture.map(|picture| picture.json)
}

/// Returns the scene of a run; `None` if its robot is unknown. The ways of `others`, if any, are
/// for the ghost in place of the run's own twins.
///
/// # Errors
/// If the rows cannot be read.
pub(crate) fn picture_of<R: Rows>(
    rows: &R,
    robot: Option<&Robot>,
    relief_m: Option<&[Vec<f64>]>,
    others: Vec<OtherWay>,
) -> Result<Option<Picture>, R::Error> {
    let header = rows.header();
    let read;
    let robot = match robot {
        Some(robot) => robot,
        None => match Robot::from_urdf_str(&header.urdf, &header.robot_name) {
            Ok(robot) => {
                read = robot;
                &read
            }
            Err(_) => return Ok(None),
        },
    };
    let same = robot.wheels.len() == header.wheels.len()
        && robot
            .wheels
            .iter()
            .zip(&header.wheels)
            .all(|(ours, theirs)| ours.rollers.len() == theirs.roller_count);
    if !same {
        return Ok(None);
    }
    let links = link_tree(&header.urdf);
    let mut description = Description::of_run(header, robot, links.as_ref(), relief_m);
    if !others.is_empty() {
        description.ways = others;
    }
    let frames = frames_of_run(rows, robot, THINNING)?;
    let remarks = description.robot.remarks.clone();
    let ways = description.ways.iter().map(|way| way.name.clone());
    let ways = ways.collect();
    let json = embed::data(&Scene::new(description, frames)).ok();
    Ok(json.map(|json| Picture {
        json,
        remarks,
        ways,
    }))
}

/// A page with a viewer, and its scripts, including the scene's if there is one.
pub fn page(head: &Head, sections: &[Section], footer: &str, has_scene: bool) -> String {
    let script = if has_scene {
        embed::script()
    } else {
        String::new()
    };
    let styles: &[&str] = if has_scene { &[embed::STYLE] } else { &[] };
    let parts = Parts {
        styles,
        before: &[&script, SCRIPT],
    };
    page::page(head, sections, footer, &parts)
}

/// Returns the viewer of a run as HTML: scene, track, slider.
pub(crate) fn html(
    header: &Header,
    ends_s: [f64; 2],
    events: &[Event],
    picture: Option<&Picture>,
) -> String {
    let wheels: Vec<&str> = header.wheels.iter().map(|w| w.name.as_str()).collect();
    stage(&Viewer {
        title: "The run",
        label: "The robot, its wheels and its contacts in three dimensions",
        scene: picture.map(|picture| picture.json.as_str()),
        remarks: picture.map_or(&[], |picture| &picture.remarks),
        wheels: &wheels,
        views: RUN_VIEWS,
        is_run: true,
        ways: picture.map_or(&[], |picture| &picture.ways),
        track: track(header, ends_s, events),
        clock: clock(ends_s[0], ends_s[1], events),
        help: "The slider moves the picture and the cursor of every figure; a click in a figure over time goes there. Space plays, \
               arrows step, N and P go to the next and the previous event.",
    })
}

/// Returns the viewer of a robot alone as HTML: its scene, in which its wheels turn once within
/// this time, and a slider.
///
/// # Errors
/// Never for a scene made by `ilon-scene`; otherwise those of serde.
pub fn of_robot(scene: &Scene, turn_s: f64) -> Result<String, serde_json::Error> {
    let data = embed::data(scene)?;
    let wheels = scene.description.robot.wheels.iter();
    let wheels: Vec<&str> = wheels.map(|wheel| wheel.name.as_str()).collect();
    Ok(stage(&Viewer {
        title: "The robot",
        label: "The robot with all of its rollers in three dimensions",
        scene: Some(&data),
        remarks: &scene.description.robot.remarks,
        wheels: &wheels,
        ways: &[],
        views: &[("follow", "From aside"), ("top", "From above")],
        clock: clock(0.0, turn_s, &[]),
        help: "The slider turns the wheels in their places, once around. Space plays, arrows step.",
        ..Viewer::default()
    }))
}

/// Returns a run and the ways of others as HTML, each for a ghost: the first run that can be drawn
/// has the scene. Empty if there is none.
///
/// # Errors
/// If the rows cannot be read.
pub(crate) fn of_runs<R: Rows>(runs: &[(&str, &R)], ends_s: [f64; 2]) -> Result<String, R::Error> {
    for (index, (name, rows)) in runs.iter().enumerate() {
        let others = runs.iter().enumerate().filter(|(other, _)| *other != index);
        let others = others.map(|(_, (name, rows))| way_of(name, *rows));
        let others: Vec<OtherWay> = others.collect::<Result<_, _>>()?;
        let Some(picture) = picture_of(*rows, None, None, others)? else {
            continue;
        };
        let wheels = rows.header().wheels.iter();
        let wheels: Vec<&str> = wheels.map(|wheel| wheel.name.as_str()).collect();
        return Ok(stage(&Viewer {
            title: &format!("{name}, and the others as ghosts"),
            label: "The robot, its wheels and its contacts in three dimensions, and a ghost where another run was",
            scene: Some(&picture.json),
            wheels: &wheels,
            views: RUN_VIEWS,
            is_run: true,
            ways: &picture.ways,
            clock: clock(ends_s[0], ends_s[1], &[]),
            help: "The slider moves the picture and the cursor of every figure over time; a click in such a figure goes there. Space \
                   plays, arrows step.",
            ..Viewer::default()
        }));
    }
    Ok(String::new())
}

/// The way of a run over the floor, for a ghost.
fn way_of<R: Rows>(name: &str, rows: &R) -> Result<OtherWay, R::Error> {
    let names = ["t_s", "truth_x_m", "truth_y_m", "truth_heading_rad"];
    let [t_s, x_m, y_m, heading_rad] = names.map(|name| rows.values(name));
    let columns = [t_s?, x_m?, y_m?, heading_rad?];
    let stride = rows.row_count().div_ceil(THINNING.most).max(1);
    let pose = |row: usize| {
        Some([
            columns[0][row]?,
            columns[1][row]?,
            columns[2][row]?,
            columns[3][row]?,
        ])
    };
    let poses = (0..columns[0].len()).step_by(stride).filter_map(pose);
    Ok(OtherWay {
        name: name.to_owned(),
        poses: poses.map(|pose| pose.map(|x| x as f32)).collect(),
    })
}

/// A canvas with its scene.
fn picture(label: &str, scene: &str) -> String {
    format!(
        "<div class=\"scene-stage\"><canvas aria-label=\"{label}\" data-scene=\"scene-data\"></canvas></div>\n\
         <script type=\"application/json\" id=\"scene-data\">{scene}</script>\n"
    )
}

/// The view buttons.
fn views(views: &[(&str, &str)]) -> String {
    let buttons: String = views
        .iter()
        .map(|(view, word)| format!("<button type=\"button\" data-view=\"{view}\">{word}</button>"))
        .collect();
    format!("<span class=\"views\">{buttons}</span>")
}

/// The views of a run.
const RUN_VIEWS: &[(&str, &str)] = &[
    ("follow", "Follow"),
    ("whole", "Whole run"),
    ("top", "From above"),
];

/// The colour legend of a run's scene.
const RUN_LEGEND: &str = "<ul class=\"legend scene-legend\"><li style=\"--c:var(--scene-ghost)\">ghost: by the ideal kinematics, or the run chosen as ghost</li>\
     <li style=\"--c:var(--scene-path)\">path</li><li style=\"--c:var(--scene-reference)\">reference</li>\
     <li style=\"--c:var(--scene-grip)\">contact that grips, with its force</li>\
     <li style=\"--c:var(--scene-sliding)\">contact at its friction limit</li>\
     <li style=\"--c:var(--scene-slip)\">sliding velocity</li></ul>";

/// The content of a viewer.
#[derive(Default)]
struct Viewer<'a> {
    title: &'a str,
    /// Description of the picture for screen readers.
    label: &'a str,
    /// The scene as JSON.
    scene: Option<&'a str>,
    /// What was left out or simplified in the robot's appearance.
    remarks: &'a [String],
    wheels: &'a [&'a str],
    /// The views of the buttons, with their labels.
    views: &'a [(&'a str, &'a str)],
    /// Whether it moves over the ground; only then are there a ghost, paths, forces and events.
    is_run: bool,
    /// Other paths for the ghost.
    ways: &'a [String],
    /// The lanes of events, as HTML.
    track: String,
    /// Data for the page's clock.
    clock: serde_json::Value,
    help: &'a str,
}

fn stage(of: &Viewer) -> String {
    let shown = of.scene.map_or_else(
        || "<p class=\"lead\">The robot is not drawn: the trace does not carry what describes it.</p>\n".to_owned(),
        |scene| picture(of.label, scene),
    );
    let wheels: String = of
        .wheels
        .iter()
        .enumerate()
        .map(|(index, name)| format!("<option value=\"{index}\">{}</option>", escape(name)))
        .collect();
    let ghost = match of.is_run {
        true => ghosts(of.ways, of.track.is_empty()),
        false => String::new(),
    };
    let scene_controls = of.scene.map_or_else(String::new, |_| {
        format!(
            "{}<label>Close-up <select class=\"wheel\"><option value=\"\">none</option>{wheels}</select></label>{ghost}",
            views(of.views)
        )
    });
    let legend = match of.scene {
        Some(_) if of.is_run => RUN_LEGEND,
        _ => "",
    };
    let remarks = match of.remarks {
        [] => String::new(),
        [remark] => format!("<p class=\"stage-note\">{}.</p>", escape(remark)),
        remarks => format!(
            "<details class=\"help\"><summary>{} remarks on the picture</summary><p>{}.</p></details>",
            remarks.len(),
            escape(&remarks.join(". "))
        ),
    };
    figure(of, &shown, &scene_controls, &format!("{legend}{remarks}"))
}

/// The choice of the ghost's path.
fn ghosts(ways: &[String], others_first: bool) -> String {
    let way = |(index, name): (usize, &String)| {
        format!("<option value=\"{index}\">{}</option>", escape(name))
    };
    let ways: String = ways.iter().enumerate().map(way).collect();
    let ideal = "<option value=\"ideal\">ideal kinematics</option>";
    let [first, second] = match others_first {
        true => [&ways, ideal],
        false => [ideal, &ways],
    };
    format!(
        "<label>Ghost <select class=\"ghost\">{first}{second}<option value=\"none\">none</option></select></label>"
    )
}

/// The figure around pictures, with their slider.
fn figure(of: &Viewer, pictures: &str, scene_controls: &str, legend: &str) -> String {
    let jumps = if !of.track.is_empty() {
        "<button type=\"button\" class=\"back\" title=\"Previous event (P)\">‹ event</button>\
         <button type=\"button\" class=\"next\" title=\"Next event (N)\">event ›</button>"
    } else {
        ""
    };
    format!(
        "<figure id=\"run-view\"><figcaption><h2>{title}</h2></figcaption>\n{pictures}\
         <div class=\"track\">{track}<div class=\"lane-line\"><label class=\"lane-name\" for=\"time\">time</label>\
         <input id=\"time\" class=\"time\" type=\"range\" min=\"0\" max=\"1\" step=\"any\" value=\"0\"></div></div>\n\
         <p class=\"said\">&nbsp;</p>\n\
         <div class=\"controls\"><button type=\"button\" class=\"play\">Play</button>{jumps}<output class=\"now\"></output>\
         <label>Speed <select class=\"speed\"><option value=\"0.05\">0.05×</option><option value=\"0.25\">0.25×</option>\
         <option value=\"1\" selected>1×</option><option value=\"4\">4×</option><option value=\"16\">16×</option></select></label>\
         {scene_controls}</div>{legend}\
         <details class=\"help\"><summary>How to use it</summary><p>Drag the picture to turn it, scroll to zoom, click a wheel to \
         see close up where it touches. {help}</p></details>\n\
         <script type=\"application/json\" id=\"clock-data\">{clock}</script></figure>\n",
        title = of.title,
        track = of.track,
        help = of.help,
        clock = json_in_script(&of.clock.to_string()),
    )
}

fn clock(start_s: f64, end_s: f64, events: &[Event]) -> serde_json::Value {
    let spans: Vec<_> = events
        .iter()
        .filter(|event| event.is_outside())
        .map(|event| json!({ "from": significant(event.from_s, 6), "until": significant(event.until_s, 6), "color": "limit" }))
        .collect();
    let events: Vec<_> = important(events, 200)
        .into_iter()
        .map(|event| json!({ "from": significant(event.from_s, 6), "until": significant(event.until_s, 6), "text": event.text }))
        .collect();
    json!({ "start": start_s, "end": end_s, "spans": spans, "events": events })
}

/// Returns the most important events, in the order of time: first external ones, then by loss and
/// duration.
fn important(events: &[Event], most: usize) -> Vec<&Event> {
    let weight = |event: &Event| {
        let outside = if event.is_outside() { 1e9 } else { 0.0 };
        outside + 10.0 * event.lost_j + event.slid_m + 0.01 * (event.until_s - event.from_s)
    };
    let mut kept: Vec<&Event> = events.iter().collect();
    kept.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    kept.truncate(most);
    kept.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    kept
}

/// A lane for each kind of event that occurred.
fn track(header: &Header, [start_s, end_s]: [f64; 2], events: &[Event]) -> String {
    struct Lane<'a> {
        place: usize,
        name: String,
        color: String,
        events: Vec<&'a Event>,
    }
    let wheel_lane = |place: usize, wheel: usize, does: &str| {
        let name = format!("{} {does}", header.wheels[wheel].name);
        (place + wheel, name, format!("w{}", wheel % 8))
    };
    let fixed = |place: usize, name: &str, color: &str| (place, name.to_owned(), color.to_owned());
    let mut lanes: Vec<Lane> = Vec::new();
    for event in events {
        let (place, name, color) = match event.kind {
            EventKind::Fault => fixed(0, "faults", "limit"),
            EventKind::Stance(_) => fixed(1, "posture", "limit"),
            EventKind::Ground => fixed(2, "ground", "asked"),
            EventKind::Touch => fixed(3, "bodies", "asked"),
            EventKind::Announced => fixed(4, "announced", "limit"),
            EventKind::Saturated(task) => {
                let name = header.task_names.get(task).map_or("task", String::as_str);
                fixed(5 + task, &format!("saturated: {name}"), "guidance")
            }
            EventKind::Slide(wheel) => wheel_lane(100, wheel, "slides"),
            EventKind::Airborne(wheel) => wheel_lane(10_000, wheel, "in the air"),
        };
        match lanes.iter_mut().find(|lane| lane.name == name) {
            Some(lane) => lane.events.push(event),
            None => lanes.push(Lane {
                place,
                name,
                color,
                events: vec![event],
            }),
        }
    }
    lanes.sort_by_key(|lane| lane.place);
    let span_s = (end_s - start_s).max(1e-9);
    let mut html = String::new();
    for Lane {
        name,
        color,
        events,
        ..
    } in lanes
    {
        let owned: Vec<Event> = events.into_iter().cloned().collect();
        let spells: String = important(&owned, MOST_A_LANE)
            .into_iter()
            .map(|event| {
                format!(
                    "<i style=\"left:{:.2}%;width:{:.2}%\" data-from=\"{}\" title=\"{}\"></i>",
                    100.0 * (event.from_s - start_s) / span_s,
                    100.0 * (event.until_s - event.from_s) / span_s,
                    significant(event.from_s, 6),
                    escape(&format!("{}: {}", event.when(), event.text)),
                )
            })
            .collect();
        // Writing to a string cannot fail.
        let _ = write!(
            html,
            "<div class=\"lane-line\"><span class=\"lane-name\">{}</span><div class=\"lane\" style=\"--c:var(--{color})\">{spells}</div></div>",
            escape(&name)
        );
    }
    html
}

/// Returns all events as a table; a click on a time seeks.
pub(crate) fn events_table(events: &[Event]) -> String {
    if events.is_empty() {
        return "<p class=\"lead\">Nothing stood out: no fault, no slide, no lost contact, no saturation.</p>\n".to_owned();
    }
    const MOST: usize = 120;
    let rows: String = important(events, MOST)
        .into_iter()
        .map(|event| {
            format!(
                "<tr><td><a href=\"#run-view\" data-seek=\"{}\">{:.2} s</a></td><td>{:.2} s</td><td class=\"words\">{}</td></tr>",
                significant(event.from_s, 6),
                event.from_s,
                event.until_s - event.from_s,
                escape(&event.text)
            )
        })
        .collect();
    let more = match events.len().saturating_sub(MOST) {
        0 => String::new(),
        more => format!("; {more} lesser ones are left out"),
    };
    wide(&table(
        &format!("A click on a time goes there{more}"),
        "<th scope=\"col\">from</th><th scope=\"col\">lasts</th><th scope=\"col\" class=\"words\">what</th>",
        &rows,
    ))
}

#[cfg(test)]
mod tests;
