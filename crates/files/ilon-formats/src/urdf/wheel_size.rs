//! Collects evidence for a wheel's size if its geometry does not show it: [`crate::error::Clues`]
//! weighs it.

use nalgebra::{Isometry3, Point3, Unit, Vector3};

use super::body::RigidBody;
use super::candidates::WheelLike;
use super::disc::{self, NoDisc};
use super::hub::hub_frame;
use super::loading::Loading;
use super::mesh_rollers;
use super::names;
use super::source::Source;
use super::tree::{Motion, Tree};
use crate::error::{Clue, ClueKind, Clues, Fault};

/// Plausible radii of robots' wheels, in metres.
const PLAUSIBLE_M: std::ops::Range<f64> = 0.005..2.0;
/// Rollers are thinner than the ring of their axes.
const MOST_OF_RING: f64 = 2.0;

/// Returns the fault of a wheel without rollers whose geometry does not show its size.
pub(super) fn unknown(loading: &Loading, like: &WheelLike) -> Fault {
    let tree = loading.tree;
    let body = tree.rigid_body(tree.joints[like.joint].child, |j| {
        tree.joints[j].motion == Motion::Turning
    });
    let shown = disc::about(&body, &hub_frame(&like.origin, &like.axis), &loading.meshes);
    Unsized {
        joint: like.joint,
        origin: like.origin,
        axis: like.axis,
        body: &body,
        ring_m: None,
        roller_m: None,
    }
    .fault(loading, &shown.err().unwrap_or(NoDisc::Bare))
}

/// A wheel of unknown size.
pub(super) struct Unsized<'a> {
    pub(super) joint: usize,
    pub(super) origin: Point3<f64>,
    pub(super) axis: Unit<Vector3<f64>>,
    pub(super) body: &'a RigidBody,
    /// Distance of its rollers' axes from the hub axis, in metres, if it has rollers.
    pub(super) ring_m: Option<f64>,
    /// The largest radius of its rollers with a shape, in metres.
    pub(super) roller_m: Option<f64>,
}

impl Unsized<'_> {
    /// Returns the fault of a wheel of unknown size, with the evidence.
    pub(super) fn fault(&self, loading: &Loading, why: &NoDisc) -> Fault {
        let frame = hub_frame(&self.origin, &self.axis);
        let lies_across = || !disc::cylinders_across(self.body, &frame).is_empty();
        let is_level = || disc::level_axis(self.body, &loading.meshes).is_ok();
        let states_axis = loading.tree.joints[self.joint].states_axis || self.ring_m.is_some();
        if !states_axis && lies_across() && is_level() {
            return Fault::NoAxis;
        }
        let package = match why {
            NoDisc::Unreadable(Fault::PackageUnknown { package, .. }) => Some(package.clone()),
            _ => None,
        };
        Fault::WheelSizeUnknown {
            reason: Some(why.words()),
            clues: Box::new(self.clues(loading)),
            package,
        }
    }

    /// Returns the remark on a radius given by the user.
    pub(super) fn words_on(&self, loading: &Loading, radius_m: f64) -> String {
        format!(
            "its geometry does not show its radius: {:.1} mm as given; {}",
            1e3 * radius_m,
            self.clues(loading).on(radius_m)
        )
    }

    /// Returns the file's evidence for its radius.
    pub(super) fn clues(&self, loading: &Loading) -> Clues {
        let (source, tree) = (loading.source, loading.tree);
        let mut clues = Clues::default();
        clues.clues.extend(said(source));
        self.add_shapes(loading, &mut clues);
        clues.clues.extend(self.named(source, tree));
        self.add_heights(tree, &mut clues);
        clues.clues.extend(self.inertia());
        if let (Some(ring_m), Some(roller_m)) = (self.ring_m, self.roller_m) {
            let what =
                "the ring of its rollers' axes and the radius of those with a shape".to_owned();
            // The hub's shape is no independent evidence.
            clues.clues.retain(|clue| clue.kind != ClueKind::Shape);
            clues
                .clues
                .push(Clue::new(ClueKind::Shape, what, ring_m + roller_m));
        }
        if let Some(ring_m) = self.ring_m {
            let what = "the ring on which its rollers' axes stand";
            clues.least_m.push((ring_m, what.to_owned()));
            clues.most_m.push((MOST_OF_RING * ring_m, what.to_owned()));
        }
        clues.most_m.extend(self.neighbour(tree));
        clues
            .clues
            .retain(|clue| clue.radii_m.iter().any(|m| PLAUSIBLE_M.contains(m)));
        clues
    }

    /// Adds its readable shapes: those round about its axis, and the reach of the others.
    fn add_shapes(&self, loading: &Loading, clues: &mut Clues) {
        let frame: Isometry3<f64> = hub_frame(&self.origin, &self.axis);
        let discs = disc::readable(self.body, &frame, &loading.meshes);
        if let Some(largest_m) = discs.iter().copied().reduce(f64::max) {
            let what = "what can be read of its shapes".to_owned();
            // A hub is smaller than its wheel.
            if self.ring_m.is_none_or(|ring_m| largest_m > ring_m) {
                let clue = Clue::new(ClueKind::Shape, what.clone(), largest_m);
                clues.clues.push(clue);
            }
            clues.least_m.push((largest_m, what));
        }
        for radius_m in disc::cylinders_across(self.body, &frame) {
            if self.ring_m.is_none_or(|ring_m| radius_m > ring_m) {
                let what = "its cylinder, which lies across its axis".to_owned();
                let clue = Clue::new(ClueKind::Shape, what, radius_m);
                if !clues.clues.contains(&clue) {
                    clues.clues.push(clue);
                }
            }
        }
        if let Some(drawn) = mesh_rollers::of_wheel(self.body, &frame, &loading.meshes) {
            let what = "the rollers that its mesh shows".to_owned();
            let clue = Clue::new(ClueKind::Shape, what, drawn.wheel_radius_m);
            clues.clues.push(clue);
        }
        if let Some(reach_m) = disc::mesh_reach_m(self.body, &frame, &loading.meshes) {
            let what = "the reach of its meshes from its axis".to_owned();
            clues.least_m.push((reach_m, what));
        }
    }

    /// Returns sizes in the names of the wheel, its meshes and its macro.
    fn named(&self, source: &Source, tree: &Tree) -> Vec<Clue> {
        let mut clues: Vec<Clue> = Vec::new();
        for name in names::of_wheel(source, tree, self.joint) {
            let radii_m = radii_in_name(&name);
            if !radii_m.is_empty() && !clues.iter().any(|known| known.radii_m == radii_m) {
                clues.push(Clue {
                    kind: ClueKind::Name,
                    what: format!("the name `{name}`"),
                    radii_m,
                });
            }
        }
        clues
    }

    /// Adds the height of its axis above frames that may lie on the floor: those with such names,
    /// or else the root.
    fn add_heights(&self, tree: &Tree, clues: &mut Clues) {
        const FLOORS: [&str; 4] = ["footprint", "ground", "floor", "projected"];
        let is_floor = |name: &str| FLOORS.iter().any(|word| name.to_lowercase().contains(word));
        let called = tree.links.iter().find(|link| is_floor(&link.name));
        let frame = called.unwrap_or(&tree.links[tree.root]);
        let height_m = self.origin.z - frame.body_from_link.translation.z;
        if PLAUSIBLE_M.contains(&height_m) {
            let what = format!("the height of its axis above the frame `{}`", frame.name);
            if called.is_some() {
                clues.most_m.push((height_m, what.clone()));
            }
            clues
                .clues
                .push(Clue::new(ClueKind::Height, what, height_m));
        }
    }

    /// Returns the radius from its inertia as a solid disc, I = m r^2 / 2; or as a solid ball, I =
    /// 2/5 m r^2, if it is equal about all axes, which no wheel narrower than high has.
    fn inertia(&self) -> Option<Clue> {
        /// Moments this close are meant to be equal.
        const SAME: f64 = 1e-3;
        let mass = self.body.mass.as_ref()?;
        let axis = self.axis.into_inner();
        let axial = axis.dot(&(mass.inertia_kg_m2 * axis));
        let [least, _, most] = mass.principal_moments_kg_m2();
        let (share, what) = if most - least <= SAME * most {
            (0.4, "its inertia, as that of a solid ball")
        } else {
            (0.5, "its inertia about its axis, as that of a solid disc")
        };
        let radius_m = (axial / (share * mass.mass_kg)).sqrt();
        // Without its rollers inertia and shapes are the hub's: two clues about one part count as
        // one.
        let kind = match self.ring_m {
            Some(_) => ClueKind::Shape,
            None => ClueKind::Inertia,
        };
        let is_wheel =
            self.ring_m.is_none_or(|ring_m| radius_m > ring_m) && self.roller_m.is_none();
        is_wheel.then(|| Clue::new(kind, what.to_owned(), radius_m))
    }

    /// Returns half of the distance to the nearest wheel in its plane: larger wheels would overlap.
    fn neighbour(&self, tree: &Tree) -> Option<(f64, String)> {
        /// Wheels this close to a plane are in it, in metres.
        const IN_PLANE_M: f64 = 0.01;
        let others = tree.moving(Motion::Turning).filter(|&j| {
            let other = &tree.joints[j];
            j != self.joint
                && tree.turning_above(j).is_none()
                && other.axis.dot(&self.axis).abs() > 0.99
                && (other.origin - self.origin).dot(&self.axis).abs() < IN_PLANE_M
        });
        let apart_m = |j: usize| (tree.joints[j].origin - self.origin).norm();
        let nearest = others.min_by(|&p, &q| apart_m(p).total_cmp(&apart_m(q)))?;
        let words = format!("half of the way to `{}`", tree.joints[nearest].name);
        (apart_m(nearest) > IN_PLANE_M).then(|| (0.5 * apart_m(nearest), words))
    }
}

/// Returns whether a name means a wheel's radius or diameter, if it does.
pub(crate) fn is_wheel_size(name: &str) -> Option<bool> {
    let plain: String = name.chars().filter(|c| c.is_alphanumeric()).collect();
    let plain = plain.to_lowercase();
    let holds = |word: &str| plain.contains(word);
    if !(holds("wheel") || holds("mecanum"))
        || holds("roller")
        || holds("caster")
        || holds("castor")
    {
        return None;
    }
    if holds("diam") {
        return Some(true);
    }
    holds("radius").then_some(false)
}

/// Returns stated radii or diameters: xacro's properties, arguments and parameters, and plug-ins'
/// settings.
fn said(source: &Source) -> Vec<Clue> {
    let mut clues: Vec<Clue> = Vec::new();
    let mut add = |what: String, is_diameter: bool, value: f64| {
        let value_m = if is_diameter { 0.5 * value } else { value };
        // A value of 50 means millimetres.
        let radius_m = if value_m > PLAUSIBLE_M.end {
            1e-3 * value_m
        } else {
            value_m
        };
        let is_new = clues.iter().all(|known| known.radii_m != [radius_m]);
        if is_new && PLAUSIBLE_M.contains(&radius_m) {
            clues.push(Clue::new(ClueKind::Said, what, radius_m));
        }
    };
    for (name, value) in &source.prepared.sizes {
        if let Some(is_diameter) = is_wheel_size(name) {
            add(format!("`{name}` of the xacro file"), is_diameter, *value);
        }
    }
    for (name, value) in &source.prepared.settings {
        if let (Some(is_diameter), Ok(value)) = (is_wheel_size(name), value.parse()) {
            add(
                format!("the controllers' setting `{name}`"),
                is_diameter,
                value,
            );
        }
    }
    let settings = source.robot().children().filter(|n| {
        let tag = n.tag_name().name();
        n.is_element() && !["link", "joint"].contains(&tag)
    });
    for node in settings.flat_map(|n| n.descendants()) {
        let name = node.attribute("name").unwrap_or(node.tag_name().name());
        let text = node.attribute("value").or(node.text()).unwrap_or_default();
        if let (Some(is_diameter), Ok(value)) = (is_wheel_size(name), text.trim().parse()) {
            add(format!("the setting `{name}`"), is_diameter, value);
        }
    }
    clues
}

/// Returns the possible radii of a size in a name, in metres: `4inch` is a diameter, as wheels are
/// sold, and so is the rest of `4" Omni Wheel` where names may have no quotes; `_100` and `100mm`
/// are diameters or radii.
fn radii_in_name(name: &str) -> Vec<f64> {
    /// Smaller numbers are indices of a wheel, part, side or version.
    const LEAST_MM: f64 = 30.0;
    const INCH_M: f64 = 0.0254;
    /// Common wheel sizes, in inches; a number before one of these is in inches.
    const SOLD_INCH: std::ops::RangeInclusive<f64> = 2.0..=12.0;
    const SOLD: [&str; 4] = ["omni", "mecanum", "mechanum", "swedish"];
    let lower = name.to_lowercase();
    let mut rest = lower.as_str();
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let number = &rest[start..];
        let end = number.find(|c: char| !c.is_ascii_digit() && c != '.');
        let end = end.unwrap_or(number.len());
        let digits = number[..end].trim_end_matches('.');
        let after = &number[digits.len()..];
        let follows_letter = rest[..start].ends_with(|c: char| c.is_alphanumeric());
        let unit = after.trim_start_matches(['-', '_', ' ']);
        if let Ok(value) = digits.parse::<f64>() {
            if unit.starts_with("inch")
                || (unit.starts_with("in") && !unit[2..].starts_with(char::is_alphabetic))
            {
                return vec![0.5 * INCH_M * value];
            }
            let is_of_wheel = SOLD.iter().any(|word| unit.starts_with(word));
            if is_of_wheel && unit != after && !follows_letter && SOLD_INCH.contains(&value) {
                return vec![0.5 * INCH_M * value];
            }
            // A bare number in another name, such as a CAD program's `Revolute-60`, has another
            // meaning.
            let stands_alone = names::is_of_wheel(&lower)
                && !follows_letter
                && !after.starts_with(char::is_alphanumeric);
            if unit.starts_with("mm")
                || (stands_alone && value >= LEAST_MM && !digits.contains('.'))
            {
                return vec![0.5e-3 * value, 1e-3 * value];
            }
        }
        rest = after;
    }
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_in_names() {
        for (name, radii_mm) in [
            ("wheel_4inch.stl", vec![50.8]),
            ("4-inch-mecanum", vec![50.8]),
            ("mecanum_wheel_250", vec![125.0, 250.0]),
            ("Wheel-100mm-left.STL", vec![50.0, 100.0]),
            ("front_left_wheel_1", vec![]),
            ("wheel2_link", vec![]),
            ("v1.2", vec![]),
            ("wheel_100.stl", vec![50.0, 100.0]),
            ("am0137", vec![]),
            ("Servo_Revolute-60", vec![]),
            ("omni-60", vec![30.0, 60.0]),
            ("4-Omni-Directional-Wheel_Single_Body-v1.stl", vec![50.8]),
            ("3.25 mecanum", vec![41.3]),
            ("4omni", vec![]),
            ("wheel4_omni", vec![]),
            ("40_omni_wheel", vec![20.0, 40.0]),
        ] {
            let found: Vec<f64> = radii_in_name(name)
                .iter()
                .map(|m| (1e4 * m).round() / 10.0)
                .collect();
            assert_eq!(found, radii_mm, "{name}");
        }
    }

    #[test]
    fn names_of_sizes_of_wheels_are_known() {
        for (name, is_diameter) in [
            ("wheel_radius", Some(false)),
            ("wheelDiameter", Some(true)),
            ("mecanum_wheel_r", None),
            ("roller_radius", None),
            ("wheel_roller_radius", None),
            ("caster_wheel_radius", None),
            ("wheel_width", None),
        ] {
            assert_eq!(is_wheel_size(name), is_diameter, "{name}");
        }
    }
}
