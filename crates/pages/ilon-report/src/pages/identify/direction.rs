//! Figures over the direction of motion.

use crate::figure::{Axis, Curve, Figure, Layout, axis, plot};

/// The axis of directions of motion in the body frame: a whole turn, so that undriven directions
/// are visible.
pub(super) fn turn() -> Axis {
    axis("direction of motion in degrees: 0 ahead, 90 to the left, 180 back, 270 to the right")
        .range(-10.0, 360.0)
}

/// A figure of half the page's width over the direction of motion.
pub(super) fn by_direction(
    id: &str,
    title: &str,
    caption: &str,
    curves: Vec<Curve>,
    values: Axis,
) -> Figure {
    Figure::new(id, title, caption, plot(curves, Layout::of(turn(), values))).height_px(300)
}
