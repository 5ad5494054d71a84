//! A wheel in the drawing: outline, axis of the touching roller, vector to the wheel, and figures.

use ilon_trace::{Header, WheelHeader};
use nalgebra::Vector2;
use svg::node::element::path::Data;
use svg::node::element::{Group, Path, Polygon, TSpan, Text};

use super::map::*;
use super::marks::{dot, line, on_halo, signless_zero, subscript};

/// Draws a wheel, with a triangle in the direction of a positive rate.
pub(super) fn wheel_from_above(map: &Map, wheel: &WheelHeader) -> Group {
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

/// Draws the axis of the touching roller, through the wheel's centre.
pub(super) fn roller_axis(map: &Map, wheel: &WheelHeader) -> Group {
    let b = Vector2::from(wheel.position_m);
    let half = half_axis_m(wheel);
    let (from, to) = (map.px(b - half), map.px(b + half));
    let (x, y) = at(map.px(b));
    Group::new()
        .add(line(from, to, ROLLER, 5.0).set("stroke-linecap", "round"))
        .add(dot(x, y, 3.0).set("fill", INK))
}

/// Returns half of the drawn axis: along n_gamma = k x u_gamma, where u_gamma is n turned by gamma.
pub(super) fn half_axis_m(wheel: &WheelHeader) -> Vector2<f64> {
    let (s, c) = wheel.gamma_rad.sin_cos();
    let [n_x, n_y] = wheel.axis;
    let n_gamma = Vector2::new(-(s * n_x + c * n_y), c * n_x - s * n_y);
    f64::max(0.85 * wheel.radius_m, 0.6 * wheel.width_m) * n_gamma
}

/// Draws the vector from the body's origin to a wheel's centre.
pub(super) fn b_h(map: &Map, wheel: &WheelHeader) -> Path {
    let (from, to) = (
        map.px(Vector2::zeros()),
        map.px(Vector2::from(wheel.position_m)),
    );
    line(from, to, B_H, 1.5).set("stroke-dasharray", "7 4")
}

/// Draws the vector's name.
pub(super) fn b_h_name(map: &Map, index: usize, wheel: &WheelHeader) -> Text {
    let b = Vector2::from(wheel.position_m);
    let (x, y) = at(map.px(0.6 * b) + Vector2::new(5.0, -6.0));
    on_halo(Text::new(format!("b{}", subscript(index + 1))))
        .set("x", x)
        .set("y", y)
        .set("fill", B_H)
        .set("font-weight", 600)
}

/// Draws a wheel's name and figures, on the side that faces away from the others.
pub(super) fn label(map: &Map, header: &Header, wheel: &WheelHeader) -> Text {
    let count = header.wheels.len().max(1) as f64;
    let positions = header.wheels.iter().map(|w| Vector2::from(w.position_m));
    let middle_m = positions.sum::<Vector2<f64>>() / count;
    let b = Vector2::from(wheel.position_m);
    let n = Vector2::from(wheel.axis);
    let outward = if (b - middle_m).dot(&n) < 0.0 { -n } else { n };
    let roller_m = match wheel.has_tyre() {
        true => 0.0,
        false => half_axis_m(wheel).dot(&n).abs(),
    };
    let reach_m = f64::max(0.5 * wheel.width_m, roller_m);
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
    let mut figures = match wheel.has_tyre() {
        true => Vec::new(),
        false => vec![format!("\u{3b3} {gamma_deg:.1}\u{b0}")],
    };
    if common_figures(&header.wheels).is_none() {
        figures.push(size(wheel));
    }
    on_halo(Text::new(printable(&wheel.name)))
        .set("x", x)
        .set("y", y)
        .set("text-anchor", anchor)
        .add(
            TSpan::new(figures.join(", "))
                .set("x", x)
                .set("dy", 16)
                .set("fill", GREY),
        )
}

/// Returns a wheel's radius and number of rollers, or its tyre, as text.
pub(super) fn size(wheel: &WheelHeader) -> String {
    let (radius_mm, count) = (1e3 * wheel.radius_m, wheel.roller_count);
    let rolls = match wheel.has_tyre() {
        true => "tyre".to_owned(),
        false => format!("{count} rollers"),
    };
    format!("\u{3c1} {radius_mm:.1} mm, {rolls}")
}

/// Returns the [`size`] of the wheels, if it is the same for all.
pub(super) fn common_figures(wheels: &[WheelHeader]) -> Option<String> {
    let first = size(wheels.first()?);
    let alike = wheels.iter().all(|wheel| size(wheel) == first);
    alike.then(|| format!("{first} on each wheel"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_said_once_where_all_wheels_have_it() {
        let wheel = |radius_m: f64, roller_count: usize| {
            let mut wheel = WheelHeader::default();
            (wheel.radius_m, wheel.roller_count) = (radius_m, roller_count);
            wheel
        };
        let of = |others: [WheelHeader; 2]| common_figures(&others);
        let said = of([wheel(0.05, 9), wheel(0.05, 9)]);
        assert_eq!(
            said.as_deref(),
            Some("\u{3c1} 50.0 mm, 9 rollers on each wheel")
        );
        assert_eq!(of([wheel(0.05, 9), wheel(0.06, 9)]), None);
        assert_eq!(of([wheel(0.05, 9), wheel(0.05, 8)]), None);
    }
}
