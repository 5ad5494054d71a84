//! One figure of the report, and the few kinds of curve that all figures are made of.
//!
//! Colours come from the palette of Okabe and Ito, which the colour-blind can tell apart. Curves that share a panel differ in
//! their dashes too.

pub use super::plot::{
    Axis, Curve, Layout, axis, bars, curve, dots, exact_curve, layout, map_layout, plot,
};

/// A figure with its title and the words that say what to look for.
pub struct Figure {
    /// Identifier in the page, of letters, digits and dashes.
    pub id: String,
    /// Title, as text.
    pub title: String,
    /// What it shows and what to look for, as HTML.
    pub caption: String,
    /// Height of the plot in CSS pixels.
    pub height_px: u32,
    /// How much room it takes.
    pub span: Span,
    /// Whether its x axis is time, so that zooming one zooms all.
    pub over_time: bool,
    /// Curves and layout, from [`plot`].
    pub plot: String,
}

impl Figure {
    /// A figure of half the page's width, 320 pixels high, of curves and layout from [`plot`].
    pub fn new(
        id: impl Into<String>,
        title: impl Into<String>,
        caption: impl Into<String>,
        plot: String,
    ) -> Self {
        Self {
            id: id.into(),
            title: title.into(),
            caption: caption.into(),
            height_px: 320,
            span: Span::Half,
            over_time: false,
            plot,
        }
    }

    /// The same of curves over time.
    pub fn over_time(
        id: impl Into<String>,
        title: impl Into<String>,
        caption: impl Into<String>,
        curves: Vec<Curve>,
        values: Axis,
    ) -> Self {
        let plot = plot(curves, Layout::of(axis("t in s"), values));
        Self {
            over_time: true,
            ..Self::new(id, title, caption, plot)
        }
    }

    /// The same with another height of its plot.
    pub fn height_px(self, height_px: u32) -> Self {
        Self { height_px, ..self }
    }

    /// The same that takes another width.
    pub fn spanning(self, span: Span) -> Self {
        Self { span, ..self }
    }
}

/// How wide a figure stands on a wide screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// Half of the page.
    Half,
    /// All of it.
    Whole,
    /// One of a row of small panels, without a caption of its own.
    Panel,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Pen {
    /// The colour's name, such as `@real`.
    pub color: &'static str,
    /// Solid, dashed, ...
    pub dash: DashKind,
    /// Width in CSS pixels.
    pub width_px: f64,
}

/// The dashes in use.
#[derive(Clone, Copy, Debug)]
pub enum DashKind {
    /// Unbroken.
    Solid,
    /// Dashes.
    Dash,
    /// Dots.
    Dot,
    /// Dashes and dots.
    DashDot,
}

/// A solid line.
pub const fn solid(color: &'static str) -> Pen {
    Pen {
        color,
        dash: DashKind::Solid,
        width_px: 1.8,
    }
}

/// A dashed line.
pub const fn dashed(color: &'static str) -> Pen {
    Pen {
        color,
        dash: DashKind::Dash,
        width_px: 1.6,
    }
}

/// A dotted line.
pub const fn dotted(color: &'static str) -> Pen {
    Pen {
        color,
        dash: DashKind::Dot,
        width_px: 1.6,
    }
}

/// The pen of a wheel: colours repeat after eight wheels, the dashes change with each.
pub fn wheel_pen(index: usize) -> Pen {
    const COLORS: [&str; 8] = ["@w0", "@w1", "@w2", "@w3", "@w4", "@w5", "@w6", "@w7"];
    let dash = match index % 4 {
        0 => DashKind::Solid,
        1 => DashKind::Dash,
        2 => DashKind::Dot,
        _ => DashKind::DashDot,
    };
    Pen {
        color: COLORS[index % COLORS.len()],
        dash,
        width_px: 1.6,
    }
}

impl Pen {
    /// The same with another width.
    pub const fn width(self, width_px: f64) -> Self {
        Self { width_px, ..self }
    }
}

impl DashKind {
    /// Its name in the page; none of an unbroken line.
    pub(crate) const fn name(self) -> Option<&'static str> {
        match self {
            Self::Solid => None,
            Self::Dash => Some("dash"),
            Self::Dot => Some("dot"),
            Self::DashDot => Some("dashdot"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wheels_next_to_each_other_differ_in_colour_and_dash() {
        for first in 0..9 {
            let pens: Vec<Pen> = (first..first + 4).map(wheel_pen).collect();
            for (index, pen) in pens.iter().enumerate() {
                for other in &pens[..index] {
                    assert_ne!(pen.color, other.color);
                    let dashes = [pen, other].map(|pen| std::mem::discriminant(&pen.dash));
                    assert_ne!(dashes[0], dashes[1], "{pen:?} beside {other:?}");
                }
            }
        }
    }
}
