//! A page with several robots side by side: each in three dimensions with its capabilities, a table
//! that sorts, and the faults of invalid files.

use ilon_formats::Loaded;
use ilon_scene::{Description, Frame, Frames, Scene, embed};

use crate::drawing;
use crate::html_table::{cell, heads, row, sortable};
use crate::page::{self, Head, Parts, Section, escape};
use ilon_sim::inspect::Inspection;

/// Draws the robots one by one, as more than a browser's number of scenes may be on a page.
const SCRIPT: &str = include_str!("../web/gallery.js");

/// Largest size of all scenes of a page, in bytes; further robots are drawn from above.
const MOST_SCENES: usize = 1 << 20;

/// A robot's file and its result.
#[derive(Debug)]
pub struct Exhibit {
    /// The displayed file name.
    pub file: String,
    /// The robot, if it was read.
    pub robot: Option<(Loaded, Inspection)>,
    /// The faults of the file; empty if the robot can drive.
    pub faults: Vec<String>,
    /// A remedy as text; with it the robot was read, if there is one.
    pub help: Option<String>,
}

/// Display of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FileKind {
    AsItIs,
    WithOptions,
    Uncontrolled,
    Refused,
}

impl FileKind {
    fn of(exhibit: &Exhibit) -> Self {
        match (&exhibit.robot, &exhibit.help) {
            (None, _) => Self::Refused,
            (Some((_, seen)), _) if seen.condition.is_none() => Self::Uncontrolled,
            (Some(_), Some(_)) => Self::WithOptions,
            (Some(_), None) => Self::AsItIs,
        }
    }
}

/// Returns the robots as one self-contained HTML file.
pub fn html(title: &str, exhibits: &[Exhibit]) -> String {
    let of = |kind: FileKind| exhibits.iter().filter(move |e| FileKind::of(e) == kind);
    let kinds = [
        (FileKind::AsItIs, "as-they-are", "Read without options", ""),
        (
            FileKind::WithOptions,
            "with-options",
            "With options",
            "Read with the options that are named; without them, their files are refused.",
        ),
        (
            FileKind::Uncontrolled,
            "uncontrolled",
            "Cannot be controlled",
            "Robots whose wheels do not hold all three freedoms of the plane.",
        ),
        (FileKind::Refused, "refused", "Refused", ""),
    ];
    let fact = |(kind, _, title, _): &(FileKind, &str, &str, &str)| {
        format!("<b>{}</b> {}", of(*kind).count(), title.to_lowercase())
    };
    let head = Head {
        kind: "robots",
        title: title.to_owned(),
        facts: kinds.iter().map(fact).collect(),
        lead: String::new(),
    };
    let mut room = MOST_SCENES;
    let mut section =
        |(kind, id, title, lead): (FileKind, &'static str, &'static str, &str)| Section {
            id,
            title,
            lead: lead.to_owned(),
            body: if kind == FileKind::Refused {
                of(kind).map(refusal).collect()
            } else {
                let cards: String = of(kind).map(|one| card(one, &mut room)).collect();
                format!("<div class=\"grid robots\">\n{cards}</div>\n")
            },
        };
    let there = kinds.into_iter().filter(|(kind, ..)| of(*kind).count() > 0);
    let all = Section {
        id: "all",
        title: "All robots",
        lead: "A click on a heading sorts, a click on a name leads to the robot.".to_owned(),
        body: overview(exhibits),
    };
    let has_robots = exhibits.iter().any(|exhibit| exhibit.robot.is_some());
    let overview = has_robots.then_some(all).into_iter();
    let sections: Vec<Section> = overview.chain(there.map(&mut section)).collect();
    let footer = "<p>Each robot is drawn to its own scale; the arrow on it points ahead. Top speeds are what the wheels' rates allow. \
                  γ and M are those of G. Indiveri, “Swedish Wheeled Omnidirectional Mobile Robots: Kinematics Analysis and \
                  Control”, IEEE Transactions on Robotics 25(1), 2009.</p>";
    let parts = Parts {
        styles: &[embed::STYLE],
        before: &[&embed::script(), SCRIPT],
    };
    page::page(&head, &sections, footer, &parts)
}

/// The table of all robots.
fn overview(exhibits: &[Exhibit]) -> String {
    const COLUMNS: [&str; 8] = [
        "wheels",
        "wheel radius",
        "|γ|",
        "rollers",
        "tyres",
        "mass",
        "top speed",
        "top yaw rate",
    ];
    let line = |exhibit: &Exhibit| {
        let (_, seen) = exhibit.robot.as_ref()?;
        let figures = figures(seen);
        let value = |column: &&str| {
            let figure = figures.iter().find(|(name, _)| name == column);
            cell(figure.map(|(_, value)| escape(value)))
        };
        let name = escape(&exhibit.file);
        let link = format!("<a href=\"#{}\">{name}</a>", anchor(exhibit));
        Some(row(&link, &COLUMNS.iter().map(value).collect::<String>()))
    };
    let rows: String = exhibits.iter().filter_map(line).collect();
    let heads = heads(["robot"].into_iter().chain(COLUMNS));
    sortable(&heads, &rows)
}

/// The address of a robot's card within the page.
fn anchor(exhibit: &Exhibit) -> String {
    let plain = |c: char| match c.is_ascii_alphanumeric() {
        true => c.to_string(),
        false => format!("-{:x}-", u32::from(c)),
    };
    "robot-".to_owned() + &exhibit.file.chars().map(plain).collect::<String>()
}

/// A robot from above and, while there is `room`, in bytes, the scene that covers the drawing.
fn picture(loaded: &Loaded, seen: &Inspection, room: &mut usize) -> String {
    let robot = &loaded.robot;
    let flat = drawing::svg(robot, seen.decoupling_point_m.map(Into::into));
    let scene = Scene::new(
        Description::of_robot(robot, loaded.links().as_ref(), &loaded.visual_meshes()),
        Frames::of(robot, [Frame::at_rest(robot)]),
    );
    match embed::data(&scene) {
        Ok(data) if data.len() <= *room => {
            *room -= data.len();
            let name = escape(&seen.name);
            format!(
                "<div class=\"thumb\" data-name=\"{name}\"><div class=\"flat\">{flat}</div><script type=\"application/json\">{data}</script></div>"
            )
        }
        _ => flat,
    }
}

fn card(exhibit: &Exhibit, room: &mut usize) -> String {
    let Some((loaded, seen)) = &exhibit.robot else {
        return String::new();
    };
    let facts: String = figures(seen)
        .into_iter()
        .map(|(name, value)| format!("<li>{name} <b>{}</b></li>", escape(&value)))
        .collect();
    let trouble = if exhibit.faults.is_empty() {
        String::new()
    } else {
        format!(
            "<details><summary>{} as the file is</summary>{}</details>",
            counted(exhibit.faults.len(), "fault"),
            said(exhibit)
        )
    };
    let remarks = if seen.remarks.is_empty() {
        String::new()
    } else {
        format!(
            "<details><summary>{}</summary>{}</details>",
            counted(seen.remarks.len(), "remark"),
            list(&seen.remarks)
        )
    };
    format!(
        "<figure id=\"{id}\"><figcaption><h3>{name}</h3><p><code>{file}</code></p></figcaption>\n{picture}\n\
         <ul class=\"facts\">{facts}</ul>\n{trouble}{remarks}</figure>\n",
        id = anchor(exhibit),
        name = escape(&seen.name),
        file = escape(&exhibit.file),
        picture = picture(loaded, seen, room),
    )
}

/// Returns a robot's properties in figures.
pub(super) fn figures(seen: &Inspection) -> Vec<(&'static str, String)> {
    let wheels = &seen.wheels;
    let mut rows = vec![("mass", format!("{:.2} kg", seen.mass_kg))];
    let span = |of: &dyn Fn(usize) -> f64, decimals: usize, unit: &str| {
        let values = (0..wheels.len()).map(of);
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(x), b.max(x))
        });
        let (least, most) = (format!("{least:.decimals$}"), format!("{most:.decimals$}"));
        if least == most {
            format!("{least}{unit}")
        } else {
            format!("{least} to {most}{unit}")
        }
    };
    let radius = span(&|i| 1e3 * wheels[i].radius_m, 1, " mm");
    rows.push(("wheels", wheels.len().to_string()));
    rows.push(("wheel radius", radius));
    let width_m = |i: usize| wheels[i].tyre.map_or(0.0, |tyre| tyre.width_m);
    match seen.tyres {
        Some(_) => rows.push(("tyres", span(&|i| 1e3 * width_m(i), 1, " mm wide"))),
        None => {
            let gamma = span(&|i| wheels[i].gamma_rad.to_degrees().abs(), 1, "°");
            rows.push(("|γ|", gamma));
            let count = span(&|i| wheels[i].rollers as f64, 0, "");
            let size = span(&|i| 1e3 * wheels[i].roller_radius_m, 1, " mm");
            rows.push(("rollers", format!("{count} of radius {size}")));
        }
    }
    let condition = match seen.condition {
        Some(condition) => format!("{condition:.2}"),
        None => "cannot be controlled".to_owned(),
    };
    let of = match seen.tyres {
        Some(_) => "condition of M with the rows of tyres",
        None => "condition of M",
    };
    rows.push((of, condition));
    let held = seen.tyres.as_ref().filter(|tyres| tyres.is_held());
    if let Some(radius_m) = held.and_then(|tyres| tyres.turning_radius_m) {
        let turn = match radius_m > 0.0 {
            true => format!("{radius_m:.2} m"),
            false => "on the spot".to_owned(),
        };
        rows.push(("sharpest turn", turn));
    }
    if let Some(limits) = &seen.speed_limits {
        let (least, most) = (limits.slowest_direction_m_s, limits.fastest_direction_m_s);
        let speeds = match held.is_some() || limits.is_even() {
            true => format!("{most:.2} m/s"),
            false => format!("{least:.2} to {most:.2} m/s"),
        };
        rows.push(("top speed", speeds));
        let yaw = limits.yaw_rate_rad_s.to_degrees();
        rows.push(("top yaw rate", format!("{yaw:.0}°/s")));
    }
    rows
}

fn refusal(exhibit: &Exhibit) -> String {
    format!(
        "<details><summary><code>{}</code></summary>{}</details>\n",
        escape(&exhibit.file),
        said(exhibit)
    )
}

fn said(exhibit: &Exhibit) -> String {
    let help = exhibit.help.as_deref().map(escape).unwrap_or_default();
    format!("{}<p>{help}</p>", list(&exhibit.faults))
}

pub(super) fn list(items: &[String]) -> String {
    let items: String = items
        .iter()
        .map(|item| format!("<li>{}</li>", escape(item)))
        .collect();
    format!("<ul>{items}</ul>")
}

fn counted(count: usize, thing: &str) -> String {
    if count == 1 {
        format!("1 {thing}")
    } else {
        format!("{count} {thing}s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_in_the_singular() {
        let said = [0, 1, 2].map(|count| counted(count, "robot"));
        assert_eq!(said, ["0 robots", "1 robot", "2 robots"]);
    }

    /// Files whose names differ in one character have two anchors, which stand in an address
    /// without escapes.
    #[test]
    fn each_file_has_its_own_anchor() {
        let files = [
            "a_b.urdf",
            "a-b.urdf",
            "a b.urdf",
            "a/b.urdf",
            "a-5f-b.urdf",
            "\u{e4}.urdf",
        ];
        let of = |file: &str| {
            anchor(&Exhibit {
                file: file.to_owned(),
                robot: None,
                faults: Vec::new(),
                help: None,
            })
        };
        let anchors: std::collections::BTreeSet<String> = files.map(of).into();
        assert_eq!(anchors.len(), files.len(), "{anchors:?}");
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-';
        assert!(anchors.iter().all(|anchor| anchor.chars().all(is_plain)));
    }
}
