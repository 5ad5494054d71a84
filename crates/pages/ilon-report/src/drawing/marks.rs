//! Elements of a drawing: lines, arrows, axes, scale bar and legend.

use ilon_trace::Header;
use nalgebra::Vector2;
use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Path, Rectangle, Text, Title};
use svg::{Document, Node};

use super::map::*;
use crate::text::round_down;

/// A white page of a size with a title and a heading.
pub(super) fn page(size_px: Vector2<f64>, title: &str, head: Text) -> Document {
    let [width, height] = size_px.into();
    let background = Rectangle::new().set("width", width).set("height", height);
    Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .set("role", "img")
        // Shrinks with its container.
        .set("style", "max-width:100%;height:auto")
        .set("font-family", "system-ui, sans-serif")
        .set("font-size", 13)
        .set("fill", INK)
        .add(Title::new(title))
        .add(background.set("fill", "#ffffff"))
        .add(head.set("font-size", 18).set("font-weight", 600))
}

/// A straight line.
pub(super) fn line(from: Vector2<f64>, to: Vector2<f64>, color: &str, width_px: f64) -> Path {
    Path::new()
        .set("d", Data::new().move_to(at(from)).line_to(at(to)))
        .set("fill", "none")
        .set("stroke", color)
        .set("stroke-width", width_px)
}

pub(super) fn dot(x: f64, y: f64, r: f64) -> Circle {
    Circle::new().set("cx", x).set("cy", y).set("r", r)
}

/// A number in subscript digits.
pub(super) fn subscript(number: usize) -> String {
    const ZERO: u32 = 0x2080;
    let digits = number.to_string();
    let small = digits.chars().filter_map(|c| c.to_digit(10));
    small.filter_map(|d| char::from_u32(ZERO + d)).collect()
}

/// Adds a halo so that text stays readable over lines.
pub(super) fn on_halo(text: Text) -> Text {
    text.set("paint-order", "stroke")
        .set("stroke", "#ffffff")
        .set("stroke-width", 3)
        .set("stroke-linejoin", "round")
}

/// Removes the sign of a value that rounds to zero at one decimal.
pub(super) fn signless_zero(value: f64) -> f64 {
    if value.abs() < 0.05 { 0.0 } else { value }
}

/// An arrow from a point in a direction.
pub(super) fn arrow(from: Vector2<f64>, ahead: Vector2<f64>, length_px: f64) -> Group {
    let tip = from + ahead * length_px;
    let aside = Vector2::new(-ahead.y, ahead.x);
    let head = Data::new()
        .move_to(at(tip))
        .line_to(at(tip - ahead * 10.0 + aside * 5.0))
        .line_to(at(tip - ahead * 10.0 - aside * 5.0))
        .close();
    Group::new()
        .add(line(from, tip - ahead * 8.0, INK, 2.0))
        .add(Path::new().set("d", head).set("fill", INK))
}

/// The body's axes, at its origin.
pub(super) fn axes(map: &Map) -> Group {
    const LENGTH_PX: f64 = 55.0;
    let origin = map.px(Vector2::zeros());
    let mut group = Group::new();
    for (name, axis) in [("x", Vector2::x()), ("y", Vector2::y())] {
        let ahead = on_page(axis);
        let (x, y) = at(origin + ahead * (LENGTH_PX + 12.0) + Vector2::new(0.0, 5.0));
        group = group.add(arrow(origin, ahead, LENGTH_PX)).add(
            on_halo(Text::new(name))
                .set("x", x)
                .set("y", y)
                .set("text-anchor", "middle")
                .set("font-style", "italic"),
        );
    }
    let (x, y) = at(origin);
    group.add(
        dot(x, y, 4.0)
            .set("fill", "#ffffff")
            .set("stroke", INK)
            .set("stroke-width", 2),
    )
}

pub(super) fn diamond(middle: Vector2<f64>) -> Path {
    let data = Data::new()
        .move_to(at(middle - Vector2::new(0.0, 8.0)))
        .line_by((8, 8))
        .line_by((-8, 8))
        .line_by((-8, -8))
        .close();
    Path::new()
        .set("d", data)
        .set("fill", DECOUPLED)
        .set("stroke", "#ffffff")
        .set("stroke-width", 1.5)
}

/// A scale bar of 1, 2 or 5 times a power of ten.
pub(super) fn scale_bar(map: &Map) -> Group {
    let length_m = round_down(160.0 / map.px_per_m);
    let words = if length_m < 1.0 {
        format!("{} mm", (1e6 * length_m).round() / 1e3)
    } else {
        format!("{length_m} m")
    };
    let (left, right) = (40.0, tenth(40.0 + length_m * map.px_per_m));
    let bar = Data::new()
        .move_to((left, 594))
        .vertical_line_by(10)
        .move_to((left, 599))
        .horizontal_line_to(right)
        .move_to((right, 594))
        .vertical_line_by(10);
    Group::new()
        .add(
            Path::new()
                .set("d", bar)
                .set("stroke", INK)
                .set("stroke-width", 2)
                .set("fill", "none"),
        )
        .add(Text::new(words).set("x", left).set("y", 586))
}

/// The legend of the marks.
pub(super) fn legend(header: &Header, decoupling_point_m: Option<Vector2<f64>>) -> Group {
    let chassis = if header.chassis_outlines_m.is_empty() {
        "the chassis has no collision shapes that are read"
    } else {
        "chassis: its collision shapes"
    };
    let (left, right, middle) = (
        Vector2::zeros(),
        Vector2::new(28.0, 0.0),
        Vector2::new(14.0, 0.0),
    );
    let triangle = Data::new()
        .move_to((9, -5))
        .vertical_line_by(10)
        .line_by((10, -5))
        .close();
    let patch = Rectangle::new()
        .set("y", -7)
        .set("width", 28)
        .set("height", 14)
        .set("fill", CHASSIS)
        .set("stroke", GREY);
    let roller = line(left, right, ROLLER, 5.0).set("stroke-linecap", "round");
    let roller = (
        roller.into(),
        "axis of the roller on the ground, mirrored on top of the wheel".to_owned(),
    );
    let on_rollers = header.wheels.iter().any(|wheel| !wheel.has_tyre());
    let mut marks: Vec<(Box<dyn Node>, String)> =
        on_rollers.then_some(roller).into_iter().collect();
    marks.extend::<[(Box<dyn Node>, String); 4]>([
        (
            line(left, right, B_H, 1.5)
                .set("stroke-dasharray", "7 4")
                .into(),
            "b, from the body's origin to the wheel's centre".to_owned(),
        ),
        (
            Path::new().set("d", triangle).set("fill", INK).into(),
            "where a positive rate drives the wheel".to_owned(),
        ),
        (
            arrow(left, Vector2::x(), 28.0).into(),
            "axes of the body: x forward, y left".to_owned(),
        ),
        (patch.into(), chassis.to_owned()),
    ]);
    if let Some(point_m) = decoupling_point_m {
        let words = format!(
            "position and heading decouple about ({:.1}, {:.1}) mm",
            signless_zero(1e3 * point_m.x),
            signless_zero(1e3 * point_m.y)
        );
        marks.push((diamond(middle).into(), words));
    }
    let mut legend = Group::new();
    for (index, (mark, words)) in marks.into_iter().enumerate() {
        let x = if index % 2 == 0 { 40 } else { 490 };
        let y = 636 + 28 * (index / 2);
        legend = legend.add(
            Group::new()
                .set("transform", format!("translate({x} {y})"))
                .add(mark)
                .add(Text::new(words).set("x", 40).set("y", 5)),
        );
    }
    legend
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_digit_is_lowered() {
        assert_eq!(subscript(0), "\u{2080}");
        assert_eq!(
            subscript(19_083),
            "\u{2081}\u{2089}\u{2080}\u{2088}\u{2083}"
        );
    }
}
