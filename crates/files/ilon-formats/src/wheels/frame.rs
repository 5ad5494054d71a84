//! What a file has around its robot: the ground, the step, and the comment at its head.

use crate::generate::elements::comment_text;

/// The step for which the solver of a MJCF is set, in seconds.
pub const STEP_S: f64 = 0.002;

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
