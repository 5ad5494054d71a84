//! A robot drawn from above: chassis, wheels, the axes of the rollers on the ground, and the vectors b_h.
//!
//! The body's x axis points right and its y axis up, as on a map. Colours are of the palette of Okabe and Ito, which the
//! colour-blind can tell apart; what differs in colour differs in form too. The picture refers to nothing outside itself
//! and names nothing inside itself, so that it can stand in a page among others.

use ilon_robot::Robot;
use ilon_trace::{Header, WheelHeader};
use nalgebra::Vector2;
use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Path, Polygon, Rectangle, TSpan, Text, Title};
use svg::{Document, Node};

/// The picture's width and height, in pixels.
const SIZE_PX: Vector2<f64> = Vector2::new(900.0, 720.0);
/// The middle of the room for the robot, and half of that room, in pixels.
const MIDDLE_PX: Vector2<f64> = Vector2::new(450.0, 318.0);
const HALF_ROOM_PX: Vector2<f64> = Vector2::new(300.0, 190.0);

const INK: &str = "#222222";
const GREY: &str = "#666666";
const CHASSIS: &str = "#e6e6e6";
/// Blue: the vectors b_h.
const B_H: &str = "#0072B2";
/// Vermilion: the rollers' axes.
const ROLLER: &str = "#D55E00";
/// Bluish green: the decoupling point.
const DECOUPLED: &str = "#009E73";

/// A robot as an SVG, with the point of the body frame about which position and heading are decoupled, in metres, where
/// there is one; an infinitely far one is as good as none.
pub fn svg(robot: &Robot, decoupling_point_m: Option<Vector2<f64>>) -> String {
    let near = |point: &Vector2<f64>| point.iter().all(|x| x.is_finite());
    draw(&Header::of_robot(robot), decoupling_point_m.filter(near))
}

/// The robot of a trace as an SVG.
pub(crate) fn svg_of_trace(header: &Header) -> String {
    draw(header, None)
}

fn draw(header: &Header, decoupling_point_m: Option<Vector2<f64>>) -> String {
    let map = Map::of(header, decoupling_point_m);
    let mut picture = Document::new()
        .set("viewBox", (0, 0, SIZE_PX.x, SIZE_PX.y))
        .set("width", SIZE_PX.x)
        .set("height", SIZE_PX.y)
        .set("role", "img")
        // In a page it shrinks with what holds it.
        .set("style", "max-width:100%;height:auto")
        .set("font-family", "system-ui, sans-serif")
        .set("font-size", 13)
        .set("fill", INK)
        .add(Title::new(format!(
            "{} from above",
            printable(&header.robot_name)
        )))
        .add(
            Rectangle::new()
                .set("width", SIZE_PX.x)
                .set("height", SIZE_PX.y)
                .set("fill", "#ffffff"),
        )
        .add(
            Text::new(format!(
                "{}, seen from above",
                printable(&header.robot_name)
            ))
            .set("x", 40)
            .set("y", 36)
            .set("font-size", 18)
            .set("font-weight", 600),
        );
    if let Some(figures) = common_figures(&header.wheels) {
        picture.append(
            Text::new(figures)
                .set("x", 40)
                .set("y", 56)
                .set("fill", GREY),
        );
    }
    for outline in &header.chassis_outlines_m {
        picture.append(
            Polygon::new()
                .set(
                    "points",
                    map.points(outline.iter().map(|&p| Vector2::from(p))),
                )
                .set("fill", CHASSIS)
                .set("fill-opacity", 0.7)
                .set("stroke", GREY),
        );
    }
    for wheel in &header.wheels {
        picture.append(wheel_from_above(&map, wheel));
    }
    for wheel in &header.wheels {
        picture.append(b_h(&map, wheel));
    }
    picture.append(axes(&map));
    for (index, wheel) in header.wheels.iter().enumerate() {
        picture.append(roller_axis(&map, wheel));
        picture.append(b_h_name(&map, index, wheel));
        picture.append(label(&map, header, wheel));
    }
    if let Some(point_m) = decoupling_point_m {
        picture.append(diamond(map.px(point_m)));
    }
    picture.append(scale_bar(&map));
    picture.append(legend(header, decoupling_point_m));
    picture.to_string() + "\n"
}

/// From the body frame to the picture.
struct Map {
    px_per_m: f64,
    middle_m: Vector2<f64>,
}

impl Map {
    /// The largest scale at which the whole robot has room.
    fn of(header: &Header, decoupling_point_m: Option<Vector2<f64>>) -> Self {
        let outlines = header.chassis_outlines_m.iter().flatten();
        let points_m = outlines
            .map(|&p| Vector2::from(p))
            .chain(header.wheels.iter().flat_map(corners_m))
            .chain([Vector2::zeros()])
            .chain(decoupling_point_m);
        let (mut low_m, mut high_m) = (Vector2::zeros(), Vector2::zeros());
        for p in points_m {
            low_m = low_m.inf(&p);
            high_m = high_m.sup(&p);
        }
        // A robot without any extent is drawn at some scale all the same.
        let half_m = (0.5 * (high_m - low_m)).map(|x: f64| x.max(1e-6));
        Self {
            px_per_m: HALF_ROOM_PX.component_div(&half_m).min(),
            middle_m: 0.5 * (low_m + high_m),
        }
    }

    fn px(&self, point_m: Vector2<f64>) -> Vector2<f64> {
        MIDDLE_PX + self.px_per_m * on_page(point_m - self.middle_m)
    }

    /// Points as a polygon lists them.
    fn points(&self, points_m: impl IntoIterator<Item = Vector2<f64>>) -> String {
        let pairs = points_m.into_iter().map(|point_m| {
            let [x, y] = self.px(point_m).into();
            format!("{x:.1},{y:.1}")
        });
        pairs.collect::<Vec<_>>().join(" ")
    }
}

/// A direction of the body frame on the page, whose y points down.
fn on_page(vector: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(vector.x, -vector.y)
}

/// Rounded to a tenth: a picture needs no more.
fn tenth(x: f64) -> f64 {
    (10.0 * x).round() / 10.0
}

fn at(point: Vector2<f64>) -> (f64, f64) {
    (tenth(point.x), tenth(point.y))
}

/// u = n x k: where a positive rate drives the hub.
fn driving_direction(wheel: &WheelHeader) -> Vector2<f64> {
    Vector2::new(wheel.axis[1], -wheel.axis[0])
}

fn corners_m(wheel: &WheelHeader) -> [Vector2<f64>; 4] {
    let b = Vector2::from(wheel.position_m);
    let across = 0.5 * wheel.width_m * Vector2::from(wheel.axis);
    let along = wheel.radius_m * driving_direction(wheel);
    [
        b + along + across,
        b - along + across,
        b - along - across,
        b + along - across,
    ]
}

/// A wheel, with a triangle before it where a positive rate drives it.
fn wheel_from_above(map: &Map, wheel: &WheelHeader) -> Group {
    let u = driving_direction(wheel);
    let foot = map.px(Vector2::from(wheel.position_m) + wheel.radius_m * u);
    let (ahead, aside) = (on_page(u), Vector2::new(u.y, u.x));
    let triangle = Data::new()
        .move_to(at(foot + ahead * 15.0))
        .line_to(at(foot + ahead * 5.0 + aside * 5.0))
        .line_to(at(foot + ahead * 5.0 - aside * 5.0))
        .close();
    Group::new()
        .add(
            Polygon::new()
                .set("points", map.points(corners_m(wheel)))
                .set("fill", "#ffffff")
                .set("fill-opacity", 0.85)
                .set("stroke", INK)
                .set("stroke-width", 1.5),
        )
        .add(Path::new().set("d", triangle).set("fill", INK))
}

/// A straight line.
fn line(from: Vector2<f64>, to: Vector2<f64>, color: &str, width_px: f64) -> Path {
    Path::new()
        .set("d", Data::new().move_to(at(from)).line_to(at(to)))
        .set("fill", "none")
        .set("stroke", color)
        .set("stroke-width", width_px)
}

/// The axis of the roller that touches the ground, through the wheel's centre.
fn roller_axis(map: &Map, wheel: &WheelHeader) -> Group {
    let b = Vector2::from(wheel.position_m);
    let half = half_axis_m(wheel);
    let (from, to) = (map.px(b - half), map.px(b + half));
    let (x, y) = at(map.px(b));
    Group::new()
        .add(line(from, to, ROLLER, 5.0).set("stroke-linecap", "round"))
        .add(dot(x, y, 3.0).set("fill", INK))
}

/// Half of the axis as it is drawn: along n_gamma = k x u_gamma, where u_gamma is n turned by gamma.
fn half_axis_m(wheel: &WheelHeader) -> Vector2<f64> {
    let (s, c) = wheel.gamma_rad.sin_cos();
    let [n_x, n_y] = wheel.axis;
    let n_gamma = Vector2::new(-(s * n_x + c * n_y), c * n_x - s * n_y);
    f64::max(0.85 * wheel.radius_m, 0.6 * wheel.width_m) * n_gamma
}

fn dot(x: f64, y: f64, r: f64) -> Circle {
    Circle::new().set("cx", x).set("cy", y).set("r", r)
}

/// The vector from the body's origin to a wheel's centre.
fn b_h(map: &Map, wheel: &WheelHeader) -> Path {
    let (from, to) = (
        map.px(Vector2::zeros()),
        map.px(Vector2::from(wheel.position_m)),
    );
    line(from, to, B_H, 1.5).set("stroke-dasharray", "7 4")
}

/// Its name, beside it.
fn b_h_name(map: &Map, index: usize, wheel: &WheelHeader) -> Text {
    let b = Vector2::from(wheel.position_m);
    let (x, y) = at(map.px(0.6 * b) + Vector2::new(5.0, -6.0));
    on_halo(Text::new(format!("b{}", subscript(index + 1))))
        .set("x", x)
        .set("y", y)
        .set("fill", B_H)
        .set("font-weight", 600)
}

/// A number in subscript digits.
fn subscript(number: usize) -> String {
    const ZERO: u32 = 0x2080;
    let digits = number.to_string();
    let small = digits.chars().filter_map(|c| c.to_digit(10));
    small.filter_map(|d| char::from_u32(ZERO + d)).collect()
}

/// Text that stays readable over lines.
fn on_halo(text: Text) -> Text {
    text.set("paint-order", "stroke")
        .set("stroke", "#ffffff")
        .set("stroke-width", 3)
        .set("stroke-linejoin", "round")
}

/// A wheel's name and figures, on the side of it that is turned away from the others.
fn label(map: &Map, header: &Header, wheel: &WheelHeader) -> Text {
    let count = header.wheels.len().max(1) as f64;
    let positions = header.wheels.iter().map(|w| Vector2::from(w.position_m));
    let middle_m = positions.sum::<Vector2<f64>>() / count;
    let b = Vector2::from(wheel.position_m);
    let n = Vector2::from(wheel.axis);
    let outward = if (b - middle_m).dot(&n) < 0.0 { -n } else { n };
    let reach_m = f64::max(0.5 * wheel.width_m, half_axis_m(wheel).dot(&n).abs());
    let reach_px = reach_m * map.px_per_m + 12.0;
    let beside = map.px(b) + on_page(outward) * reach_px;
    let anchor = match outward.x {
        x if x > 0.4 => "start",
        x if x < -0.4 => "end",
        _ => "middle",
    };
    // Two lines of 16 pixels: above the point, beside it or below it.
    let (x, y) = at(beside + Vector2::new(0.0, -4.0 - 18.0 * outward.y));
    let gamma_deg = signless_zero(wheel.gamma_rad.to_degrees());
    let mut figures = format!("\u{3b3} {gamma_deg:.1}\u{b0}");
    if common_figures(&header.wheels).is_none() {
        figures = format!("{figures}, {}", size(wheel));
    }
    on_halo(Text::new(printable(&wheel.name)))
        .set("x", x)
        .set("y", y)
        .set("text-anchor", anchor)
        .add(
            TSpan::new(figures)
                .set("x", x)
                .set("dy", 16)
                .set("fill", GREY),
        )
}

/// A wheel's radius and number of rollers.
fn size(wheel: &WheelHeader) -> String {
    let (radius_mm, count) = (1e3 * wheel.radius_m, wheel.roller_count);
    format!("\u{3c1} {radius_mm:.1} mm, {count} rollers")
}

/// What [`size`] says of every wheel, where it says the same of all.
fn common_figures(wheels: &[WheelHeader]) -> Option<String> {
    let first = size(wheels.first()?);
    let alike = wheels.iter().all(|wheel| size(wheel) == first);
    alike.then(|| format!("{first} on each wheel"))
}

/// A value that rounds to zero at one decimal has no sign.
fn signless_zero(value: f64) -> f64 {
    if value.abs() < 0.05 { 0.0 } else { value }
}

/// An arrow from one place in a direction.
fn arrow(from: Vector2<f64>, ahead: Vector2<f64>, length_px: f64) -> Group {
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

/// The body's axes, from its origin.
fn axes(map: &Map) -> Group {
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

fn diamond(middle: Vector2<f64>) -> Path {
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

/// A bar of 1, 2 or 5 times a power of ten.
fn scale_bar(map: &Map) -> Group {
    let at_most_m = 160.0 / map.px_per_m;
    let power_m = 10f64.powf(at_most_m.log10().floor());
    let length_m = [5.0, 2.0, 1.0]
        .map(|digit| digit * power_m)
        .into_iter()
        .find(|length_m| *length_m <= at_most_m)
        .unwrap_or(power_m);
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

/// What the marks mean.
fn legend(header: &Header, decoupling_point_m: Option<Vector2<f64>>) -> Group {
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
    let mut marks: Vec<(Box<dyn Node>, String)> = vec![
        (
            roller.into(),
            "axis of the roller on the ground, mirrored on top of the wheel".to_owned(),
        ),
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
    ];
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

/// A name without the control characters that XML cannot hold.
fn printable(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        let wheel = |name: &str, x: f64, y: f64| WheelHeader {
            name: name.to_owned(),
            position_m: [x, y],
            radius_m: 0.05,
            axis: [0.0, 1.0],
            width_m: 0.04,
            gamma_rad: 45f64.to_radians(),
            roller_count: 9,
            ..WheelHeader::default()
        };
        Header {
            robot_name: "a <robot> & \"more\"".to_owned(),
            wheels: vec![wheel("front", 0.2, 0.1), wheel("rear", -0.2, -0.1)],
            ..Header::default()
        }
    }

    #[test]
    fn the_picture_is_well_formed_whatever_names_hold() {
        let mut header = header();
        header.wheels[0].name = "\u{1}</svg>".to_owned();
        let picture = draw(&header, Some(Vector2::zeros()));
        let document = roxmltree::Document::parse(&picture).unwrap();
        let texts: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
        assert!(texts.iter().any(|t| t.trim() == "</svg>"), "{texts:?}");
        assert!(texts.iter().any(|t| t.contains("a <robot> & \"more\"")));
    }

    #[test]
    fn a_roller_axis_lies_where_gamma_says() {
        // n = y, gamma = 45 deg: u_gamma is y turned by 45 deg counter-clockwise, (-1, 1)/sqrt 2, and
        // n_gamma = k x u_gamma = (-1, -1)/sqrt 2: from the lower left to the upper right of a map.
        let header = header();
        let map = Map::of(&header, None);
        let path = roller_axis(&map, &header.wheels[0]).to_string();
        let data = path.split("d=\"").nth(1).unwrap();
        let numbers: Vec<f64> = data[..data.find('"').unwrap()]
            .split(['M', 'L', ',', ' '])
            .filter_map(|word| word.parse().ok())
            .collect();
        let (dx, dy) = (numbers[2] - numbers[0], numbers[3] - numbers[1]);
        // The page's y points down; places are rounded to a tenth.
        assert!((dx + dy).abs() < 0.3 && dx.abs() > 20.0, "{dx} {dy}");
    }

    #[test]
    fn everything_drawn_lies_in_the_picture() {
        let header = header();
        let map = Map::of(&header, None);
        for corner in header.wheels.iter().flat_map(corners_m) {
            let [x, y] = map.px(corner).into();
            assert!(
                (0.0..SIZE_PX.x).contains(&x) && (60.0..580.0).contains(&y),
                "{x} {y}"
            );
        }
    }
}
