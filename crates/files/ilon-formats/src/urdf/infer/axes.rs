//! The arrangement of wheels, and their rollers' directions from joints and friction directions.

use nalgebra::{Unit, Vector3};
use roxmltree::Node;

use crate::urdf::candidates::{WheelLike, in_place_of_rollers};
use crate::urdf::source::Source;
use crate::urdf::tree::Tree;
use crate::xml::numbers;

/// Range of the angle of mecanum rollers, in degrees.
const LEANS_DEG: std::ops::RangeInclusive<f64> = 20.0..=70.0;

/// Whether all axes are parallel, within a few degrees.
pub(super) fn are_parallel(wheels: &[WheelLike]) -> bool {
    wheels
        .windows(2)
        .all(|pair| are_aligned(&pair[0].axis, &pair[1].axis))
}

pub(super) fn are_aligned(p: &Unit<Vector3<f64>>, q: &Unit<Vector3<f64>>) -> bool {
    p.dot(q).abs() > 0.99
}

/// Whether parallel wheels are on both sides of the middle, and both ahead of it and behind.
pub(super) fn stand_in_x(wheels: &[WheelLike]) -> bool {
    let Some(first) = wheels.first().filter(|_| are_parallel(wheels)) else {
        return false;
    };
    let middle: Vector3<f64> = wheels
        .iter()
        .map(|w| w.middle().coords)
        .sum::<Vector3<f64>>()
        / wheels.len() as f64;
    let left = first.axis.into_inner();
    let ahead = left.cross(&Vector3::z());
    let both = |direction: &Vector3<f64>| {
        let places = || {
            wheels
                .iter()
                .map(|w| (w.middle().coords - middle).dot(direction))
        };
        places().any(|place| place > 1e-3) && places().any(|place| place < -1e-3)
    };
    wheels.len() >= 4 && both(&left) && both(&ahead)
}

/// Returns gamma of each wheel in degrees, if below each one joint turns in place of its rollers,
/// about the axis of the one on the ground.
pub(super) fn by_joints(tree: &Tree, wheels: &[WheelLike]) -> Option<Vec<f64>> {
    let of_wheel = |wheel: &WheelLike| {
        let roller = in_place_of_rollers(tree, wheel.joint)?;
        gamma_deg(&wheel.axis, &tree.joints[roller].axis)
    };
    let each = wheels.iter().map(of_wheel).collect::<Option<Vec<f64>>>()?;
    // To a tenth: joints are placed by hand.
    Some(each.iter().map(|deg| (10.0 * deg).round() / 10.0).collect())
}

/// Returns gamma of each wheel in degrees, if the file gives each a direction with grip and one
/// without: the first is the axis of the roller on the ground.
pub(super) fn by_friction(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<Vec<f64>> {
    // Plain wheels that slide sideways have directions along and across too.
    let is_oblique = |deg: &f64| deg.abs() >= *LEANS_DEG.start();
    let found = by_directions(source, tree, wheels, false);
    found.filter(|deg| !are_parallel(wheels) || deg.iter().any(is_oblique))
}

/// The same for directions that turn with their wheels, as placed in the file; only for inclined
/// rollers, because plain wheels also have directions along and across. Also returns the evidence
/// as text.
pub(super) fn by_turning_friction(
    source: &Source,
    tree: &Tree,
    wheels: &[WheelLike],
) -> Option<(Vec<f64>, String)> {
    let gammas_deg = by_directions(source, tree, wheels, true)?;
    let do_lean = gammas_deg.iter().all(|deg| LEANS_DEG.contains(&deg.abs()));
    let why = format!(
        "the `<fdir1>` of `{}` and the others; in the wheels' own frames these turn with the wheels, and the robot cannot move sideways in other \
         simulators: name a frame that stands, as `expressed_in`",
        tree.links[tree.joints[wheels.first()?.joint].child].name
    );
    do_lean.then_some((gammas_deg, why))
}

fn by_directions(
    source: &Source,
    tree: &Tree,
    wheels: &[WheelLike],
    may_turn: bool,
) -> Option<Vec<f64>> {
    let of_wheel = |wheel: &WheelLike| {
        let body = tree.lone_body(tree.joints[wheel.joint].child);
        let link = &tree.links[body.link].name;
        let grip = friction_direction(source, tree, link, may_turn)?.ok()?;
        gamma_deg(&wheel.axis, &grip)
    };
    wheels.iter().map(of_wheel).collect()
}

/// Returns why the friction directions of wheels say nothing of rollers, as text: why the first of
/// them cannot be used.
pub(super) fn unused_friction(
    source: &Source,
    tree: &Tree,
    wheels: &[WheelLike],
) -> Option<String> {
    let why_unused = |wheel: &WheelLike| {
        let link = &tree.links[tree.joints[wheel.joint].child].name;
        let why = match friction_direction(source, tree, link, false)? {
            Err(why) => why,
            Ok(grip) if gamma_deg(&wheel.axis, &grip).is_none() => {
                "with `mu` and `mu2` grips along the axle, as plain wheels do".to_owned()
            }
            Ok(_) => return None,
        };
        Some(format!("the `<fdir1>` of `{link}` {why}"))
    };
    wheels.iter().find_map(why_unused)
}

/// Returns an element of what a file says of a link's friction. Blocks of one link add up.
fn friction_setting<'a, 'i>(
    source: &'a Source<'i>,
    link: &str,
    tags: &[&str],
) -> Option<Node<'a, 'i>> {
    let of_link = source
        .robot()
        .children()
        .filter(|n| n.has_tag_name("gazebo") && n.attribute("reference") == Some(link));
    let mut settings = of_link.flat_map(|n| n.descendants());
    // SDF's `<friction>` of a surface contains the others.
    let is_value = |n: &Node| !n.children().any(|inner| inner.is_element());
    settings.find(|n| tags.contains(&n.tag_name().name()) && is_value(n))
}

/// Returns the direction in which a link grips, in the body frame: the first direction or the one
/// across it on the ground, whichever has more friction; or why that is not known, as text. In the
/// wheel's own frame, which turns with it, the direction is meaningless, unless it `may_turn`.
/// `None` if the file says none.
fn friction_direction(
    source: &Source,
    tree: &Tree,
    link: &str,
    may_turn: bool,
) -> Option<Result<Vector3<f64>, String>> {
    /// Largest share of the friction along a roller's axis that is left across it.
    const SLIDES: f64 = 0.1;
    let text_of = |node: Node<'_, '_>| {
        node.attribute("value")
            .or(node.text())
            .unwrap_or_default()
            .to_owned()
    };
    let fdir1 = friction_setting(source, link, &["fdir1"])?;
    let number = |tags: &[&str]| {
        let Some(of) = friction_setting(source, link, tags) else {
            return Ok(1.0);
        };
        let text = text_of(of);
        let number = text.trim().parse::<f64>().ok().filter(|mu| !mu.is_nan());
        number.ok_or_else(|| {
            let (tag, line) = (of.tag_name().name(), source.line_of(of));
            format!("cannot be used: the `{tag}` on line {line} is not a number, but `{text}`")
        })
    };
    let firsts = number(&["mu", "mu1", "friction"]);
    let (first, second) = match (firsts, number(&["mu2", "friction2"])) {
        (Ok(first), Ok(second)) => (first, second),
        (Err(why), _) | (_, Err(why)) => return Some(Err(why)),
    };
    if first.max(second) <= 0.0 || first.min(second) > SLIDES * first.max(second) {
        let why = format!(
            "cannot be used with `mu` {first} and `mu2` {second}: rollers need one direction with less than {SLIDES} of the other's friction"
        );
        return Some(Err(why));
    }
    let mut attributes = fdir1.attributes();
    let named = attributes
        .find(|a| a.name() == "expressed_in")
        .map(|a| a.value());
    let frame = named.filter(|frame| !frame.is_empty()).unwrap_or(link);
    if frame == link && !may_turn {
        let why = "names no frame but the wheel's own, with which it turns, so that it says nothing of rollers: name one that stands, as `expressed_in`";
        return Some(Err(why.to_owned()));
    }
    let text = text_of(fdir1);
    let Some([x, y, z]) = numbers(&text).and_then(|v| <[f64; 3]>::try_from(v).ok()) else {
        let line = source.line_of(fdir1);
        let why = format!("on line {line} is not three numbers, but `{text}`");
        return Some(Err(why));
    };
    let Some(of) = tree.links.iter().find(|l| l.name == frame) else {
        return Some(Err(format!("names the frame `{frame}`, which is no link")));
    };
    let direction = of.body_from_link.rotation * Vector3::new(x, y, z);
    Some(Ok(match first > second {
        true => direction,
        false => Vector3::z().cross(&direction),
    }))
}

/// Returns gamma of a wheel whose roller on the ground has its axis along `grip`: the rolling
/// direction is across it, and gamma its angle from the hub axis.
fn gamma_deg(hub: &Unit<Vector3<f64>>, grip: &Vector3<f64>) -> Option<f64> {
    let rolling = grip.xy();
    let rolling = nalgebra::Vector2::new(rolling.y, -rolling.x).try_normalize(1e-6)?;
    let n = hub.xy().try_normalize(1e-6)?;
    let (sin, cos) = (n.perp(&rolling), n.dot(&rolling));
    // A direction and its opposite are equivalent.
    let gamma_rad = if cos < 0.0 {
        libm::atan2(-sin, -cos)
    } else {
        libm::atan2(sin, cos)
    };
    let gamma_deg = gamma_rad.to_degrees();
    // Closer to 90 degrees the roller would turn with the hub: that is a plain wheel's direction.
    (gamma_deg.abs() < 80.0).then_some(gamma_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_of_the_roller_on_the_ground_gives_gamma() {
        // At the front left of the usual X the roller on the ground lies along (1, -1): gamma = -45
        // deg (see `from_options`).
        let left = Vector3::y_axis();
        for (grip, gamma) in [
            ([1.0, -1.0], Some(-45.0)),
            ([-1.0, 1.0], Some(-45.0)),
            ([1.0, 1.0], Some(45.0)),
            // A wheel that grips in its driving direction and slides sideways is an omni wheel.
            ([1.0, 0.0], Some(0.0)),
            // One that grips along its axis is none at all.
            ([0.0, 1.0], None),
        ] {
            let found = gamma_deg(&left, &Vector3::new(grip[0], grip[1], 0.0));
            match (found, gamma) {
                (Some(found), Some(gamma)) => {
                    let found: f64 = found;
                    assert!((found - gamma).abs() < 1e-12, "{found}");
                }
                (found, gamma) => assert_eq!(found, gamma),
            }
        }
    }
}
