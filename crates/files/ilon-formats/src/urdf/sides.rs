//! Checks whether wheels are placed and roll as their names say: ahead is along x, left along y.

use nalgebra::Vector2;

use crate::model::{Remark, Wheel};

/// The cosine above which two directions agree, of 60 degrees: wheels of a triangle are 30 degrees
/// off their names.
const AGREE: f64 = 0.5;

/// Adds a remark if the names of wheels, their rolling direction and the body's x axis are
/// inconsistent.
pub(super) fn remark(wheels: &[Wheel], remarks: &mut Vec<Remark>) {
    let said = across(wheels).map(str::to_owned);
    remarks.extend(
        said.into_iter()
            .chain(by_names(wheels))
            .map(|words| Remark::new("the wheels", words)),
    );
}

/// Returns the remark for wheels with hubs along x.
fn across(wheels: &[Wheel]) -> Option<&'static str> {
    /// The cosine of 8 degrees.
    const ALONG: f64 = 0.99;
    let are_across = wheels.iter().all(|wheel| wheel.axis().x.abs() > ALONG);
    are_across.then_some(
        "their hubs lie along x of the body's frame, so that they roll along y: a drive along x, which is ahead, is one sideways for them",
    )
}

/// Returns the contradiction between the names of wheels and their places.
fn by_names(wheels: &[Wheel]) -> Option<String> {
    let front = direction(wheels, |side| side.ahead);
    let left = direction(wheels, |side| side.left);
    let way = |found: Option<Vector2<f64>>| found.and_then(|d| axis_called(&d));
    let (front, left) = (way(front), way(left));
    let odd = |way: Option<&'static str>, right: &str| way.filter(|way| *way != right);
    match (odd(front, "x"), odd(left, "y")) {
        (Some(front), Some(left)) => Some(format!(
            "by their names the front of the robot lies along {front} and its left along {left} of the body's frame, in which x is ahead and y to the left"
        )),
        (Some(front), None) => Some(format!(
            "by their names the front of the robot lies along {front} of the body's frame, in which x is ahead: the names of front and rear may be exchanged"
        )),
        (None, Some(left)) => Some(format!(
            "by their names the left of the robot lies along {left} of the body's frame, in which y is to the left: the names of left and right may be exchanged"
        )),
        (None, None) => None,
    }
}

/// Returns the axis of the body along which a direction lies, approximately.
fn axis_called(direction: &Vector2<f64>) -> Option<&'static str> {
    let axes = [
        ("x", Vector2::x()),
        ("-x", -Vector2::x()),
        ("y", Vector2::y()),
        ("-y", -Vector2::y()),
    ];
    let nearest = axes
        .into_iter()
        .max_by(|p, q| p.1.dot(direction).total_cmp(&q.1.dot(direction)))?;
    (nearest.1.dot(direction) > AGREE * direction.norm()).then_some(nearest.0)
}

/// Returns the direction from wheels with one name to those with the other; from the centre of all
/// if the other is missing. `None` if names do not say, or are inconsistent: half of a pair is next
/// to the other.
fn direction(wheels: &[Wheel], called: fn(&Side) -> Option<bool>) -> Option<Vector2<f64>> {
    let mean = |of: Option<bool>| {
        let places: Vec<Vector2<f64>> = wheels
            .iter()
            .filter(|wheel| of.is_none() || called(&Side::of(&wheel.name)) == of)
            .map(|wheel| wheel.position_m().xy())
            .collect();
        let count = places.len() as f64;
        (!places.is_empty()).then(|| places.iter().sum::<Vector2<f64>>() / count)
    };
    let all = mean(None)?;
    let (one, other) = (mean(Some(true)), mean(Some(false)));
    if one.is_none() && other.is_none() {
        return None;
    }
    (one.unwrap_or(all) - other.unwrap_or(all)).try_normalize(1e-3)
}

/// The place implied by a name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Side {
    ahead: Option<bool>,
    left: Option<bool>,
}

impl Side {
    /// Parses the words of a name, or their usual abbreviations: `front_left_wheel`,
    /// `wheel_fl_joint`, `WheelRR`.
    fn of(name: &str) -> Self {
        let mut side = Self::default();
        let mut words = words(name);
        // Beside a whole word `fr` is short for front.
        words.sort_by_key(|word| word.len() == 2);
        for word in words {
            let (ahead, left) = match word.as_str() {
                "front" | "forward" => (Some(true), None),
                "rear" | "back" | "hind" => (Some(false), None),
                "left" => (None, Some(true)),
                "right" => (None, Some(false)),
                "fl" | "lf" | "frontleft" | "leftfront" => (Some(true), Some(true)),
                "fr" | "rf" | "frontright" | "rightfront" => (Some(true), Some(false)),
                "rl" | "bl" | "lb" | "lr" | "rearleft" | "backleft" => (Some(false), Some(true)),
                "rr" | "br" | "rb" | "rearright" | "backright" => (Some(false), Some(false)),
                _ => (None, None),
            };
            side.ahead = side.ahead.or(ahead);
            side.left = side.left.or(left);
        }
        side
    }
}

/// Returns the words of a name, in lower case: split at non-letters, and where a capital follows a
/// small letter.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut after_small = false;
    for c in name.chars() {
        if !c.is_alphabetic() || (c.is_uppercase() && after_small) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| c.is_alphabetic()) {
            word.extend(c.to_lowercase());
        }
        after_small = c.is_lowercase();
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_where_wheels_stand() {
        let side = |ahead, left| Side { ahead, left };
        for (name, found) in [
            ("front_left_wheel", side(Some(true), Some(true))),
            ("wheel_rr_joint", side(Some(false), Some(false))),
            ("frontRightWheel", side(Some(true), Some(false))),
            ("back_wheel", side(Some(false), None)),
            ("WheelLR", side(Some(false), Some(true))),
            ("fr_left_joint", side(Some(true), Some(true))),
            ("wheel_3", side(None, None)),
            ("backpack_fringe", side(None, None)),
        ] {
            assert_eq!(Side::of(name), found, "{name}");
        }
    }
}
