//! One figure of the report, and the few kinds of curve that all figures are made of.

pub use super::pen::{DashKind, Pen, dashed, dotted, solid, wheel_pen};
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
