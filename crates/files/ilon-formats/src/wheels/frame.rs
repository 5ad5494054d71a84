//! What a file has around its robot: the format, the ground, the step, and the comment at its head.

use crate::generate::elements::comment_text;

/// The step for which the solver of a MJCF is set, in seconds.
pub const STEP_S: f64 = 0.002;

/// A format that robots are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MuJoCo's, with a scene.
    Mjcf,
    /// Gazebo's, with a world.
    Sdf,
    /// The plainest: cylinders and spheres.
    Urdf,
}

/// The ground of a written world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Coulomb's coefficient of friction between rollers and ground.
    pub friction: f64,
    /// Gravity, in m/s^2.
    pub gravity_m_s2: f64,
}

/// A text as a comment of XML.
pub(super) fn about_comment(about: &str) -> String {
    format!("<!--\n{}\n-->\n", comment_text(about).trim_end_matches('-'))
}

/// A template with values in place of their names in braces.
pub(super) fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let mut out = String::with_capacity(2 * template.len());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once('{') {
        let (name, after) = after.split_once('}').unwrap_or((after, ""));
        let value = values.iter().find(|(of, _)| *of == name);
        out += before;
        out += value.map_or("", |(_, value)| value);
        rest = after;
    }
    out + rest
}
