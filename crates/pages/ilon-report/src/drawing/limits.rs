//! A drawing of a robot's acceleration limits by direction, as outlines around the robot.
//!
//! Seen from above: ahead to the right, left up. The outline from rest has the colour and name of
//! the limiting wheel; where the motor limits, it is dashed. Outlines at speed are thin.

use ilon_sim::inspect::{Inspection, WheelInspection};
use ilon_sim::simulate::LimitOutline;
use nalgebra::Vector2;
use svg::Node;
use svg::node::element::path::Data;
use svg::node::element::{Group, Path, Text};

use super::map::{GREY, at, on_page, printable, tenth};
use super::marks::{arrow, dot, line, on_halo, page};
use crate::text::round_down;

const SIDE_PX: f64 = 640.0;
const MIDDLE_PX: Vector2<f64> = Vector2::new(320.0, 340.0);
/// Half size of the area for the outlines, in pixels.
const ROOM_PX: f64 = 215.0;

/// Colours of wheels, after Okabe and Ito; they repeat.
const WHEELS: [&str; 7] = [
    "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000",
];

/// Returns the limits of a robot by direction as an SVG, if they were computed.
pub fn limits(seen: &Inspection) -> Option<String> {
    let limits = seen.limits.as_ref()?;
    let largest = limits.outlines.iter().flat_map(|outline| &outline.points);
    let largest = largest.fold(0.0, |most: f64, point| most.max(point.limit.largest));
    let px_per_m_s2 = match largest > 0.0 {
        true => ROOM_PX / largest,
        false => 0.0,
    };
    let title = format!("{}: accelerations without slip", printable(&seen.name));
    let side = Vector2::repeat(SIDE_PX);
    let mut picture = page(side, &title, words(&title, 32.0)).add(
        words(
            "From rest, in the colour of the wheel that reaches its limit first; dashed where its motor does.",
            54.0,
        )
        .set("fill", GREY),
    );
    picture.append(rings(largest, px_per_m_s2));
    picture.append(arrow(MIDDLE_PX, on_page(Vector2::x()), 40.0));
    picture.append(words_at("ahead", MIDDLE_PX + Vector2::new(62.0, 5.0)).set("fill", GREY));
    for outline in limits.outlines.iter().rev() {
        match outline.share_of_top == 0.0 {
            true => picture.append(from_rest(outline, &seen.wheels, px_per_m_s2)),
            false => picture.append(at_speed(outline, px_per_m_s2)),
        }
    }
    let speeds = limits
        .outlines
        .iter()
        .filter(|outline| outline.share_of_top > 0.0);
    let speeds: Vec<String> = speeds
        .map(|outline| format!("{:.0} %", 100.0 * outline.share_of_top))
        .collect();
    if !speeds.is_empty() {
        let said = format!(
            "Thin: at {} of the top speed in each direction, further in the faster.",
            speeds.join(" and ")
        );
        picture.append(words(&said, SIDE_PX - 16.0).set("fill", GREY));
    }
    Some(picture.to_string() + "\n")
}

fn words(text: &str, y: f64) -> Text {
    Text::new(text).set("x", 24).set("y", y)
}

fn words_at(text: &str, place: Vector2<f64>) -> Text {
    let (x, y) = at(place);
    on_halo(Text::new(text))
        .set("x", x)
        .set("y", y)
        .set("text-anchor", "middle")
}

/// Draws rings at whole steps of 1, 2 or 5 times a power of ten, labelled with the acceleration.
fn rings(largest: f64, px_per_m_s2: f64) -> Group {
    let mut group = Group::new();
    if largest <= 0.0 {
        return group;
    }
    let step = round_down(largest / 2.0);
    for ring in 1..=(largest / step).floor() as usize {
        let acceleration = step * ring as f64;
        let radius_px = tenth(acceleration * px_per_m_s2);
        group = group
            .add(
                dot(MIDDLE_PX.x, MIDDLE_PX.y, radius_px)
                    .set("fill", "none")
                    .set("stroke", "#cccccc"),
            )
            .add(
                words_at(
                    &format!(
                        "{acceleration:.*} m/s\u{b2}",
                        (-step.log10().floor()).max(0.0) as usize
                    ),
                    MIDDLE_PX + Vector2::new(0.0, radius_px - 3.0),
                )
                .set("fill", GREY)
                .set("font-size", 11),
            );
    }
    group
}

/// Returns the points of an outline, closed.
fn places(outline: &LimitOutline, px_per_m_s2: f64) -> Vec<Vector2<f64>> {
    let points = outline.points.iter().chain(outline.points.first());
    points
        .map(|point| {
            let (sin, cos) = point.direction_deg.to_radians().sin_cos();
            MIDDLE_PX + px_per_m_s2 * point.limit.largest * on_page(Vector2::new(cos, sin))
        })
        .collect()
}

fn at_speed(outline: &LimitOutline, px_per_m_s2: f64) -> Path {
    let mut places = places(outline, px_per_m_s2).into_iter();
    let mut data = Data::new();
    if let Some(first) = places.next() {
        data = data.move_to(at(first));
    }
    for place in places {
        data = data.line_to(at(place));
    }
    Path::new()
        .set("d", data)
        .set("fill", "none")
        .set("stroke", GREY)
        .set("stroke-width", 1)
}

/// Draws the outline in pieces, each of one wheel and one cause.
fn from_rest(outline: &LimitOutline, wheels: &[WheelInspection], px_per_m_s2: f64) -> Group {
    let places = places(outline, px_per_m_s2);
    let holds = |index: usize| {
        let limit = &outline.points[index].limit;
        (limit.wheel.as_str(), limit.cause)
    };
    let mut group = Group::new();
    let count = outline.points.len();
    // A piece starts where the wheel or the cause changes; there may be only one around.
    let begins = |index: &usize| holds(*index) != holds((*index + count - 1) % count);
    let starts: Vec<usize> = (0..count).filter(begins).collect();
    let starts = if starts.is_empty() { vec![0] } else { starts };
    for (piece, start) in starts.iter().enumerate() {
        let next = starts[(piece + 1) % starts.len()];
        let length = (next + count - start - 1) % count + 1;
        let (wheel, cause) = holds(*start);
        let color = wheels
            .iter()
            .position(|known| known.name == wheel)
            .unwrap_or(0);
        let color = WHEELS[color % WHEELS.len()];
        for step in 0..length {
            let index = (start + step) % count;
            let mut side =
                line(places[index], places[index + 1], color, 3.0).set("stroke-linecap", "round");
            if cause == "motor" {
                side = side.set("stroke-dasharray", "2 5");
            }
            group = group.add(side);
        }
        let middle = places[(start + length / 2) % count];
        group = group.add(
            words_at(&printable(wheel), beside(middle))
                .set("fill", color)
                .set("font-weight", 600),
        );
    }
    group
}

/// The middle of a name outside of an outline, beside a point of it.
fn beside(point: Vector2<f64>) -> Vector2<f64> {
    let outward = (point - MIDDLE_PX).try_normalize(1e-9).unwrap_or_default();
    point + 22.0 * outward + Vector2::new(outward.x * 28.0, 4.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of 16 px is centred on a baseline 4 px below its middle, and a name is some 50 px
    /// wide: on the left and the right it begins beyond the point, above and below it leaves 10 px.
    #[test]
    fn a_name_stands_outside_of_its_outline() {
        for (x, y, least_px) in [
            (1.0, 0.0, 25.0),
            (-1.0, 0.0, 25.0),
            (0.0, 1.0, 10.0),
            (0.0, -1.0, 10.0),
        ] {
            let outward = Vector2::new(x, y);
            let point = MIDDLE_PX + 100.0 * outward;
            let further_px = (beside(point) - point).dot(&outward);
            assert!(further_px > least_px, "{outward}: {further_px}");
        }
    }
}
