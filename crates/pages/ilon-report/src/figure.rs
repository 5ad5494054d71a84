//! A figure of the report.

pub use super::pen::{DashKind, Pen, dashed, dotted, solid, wheel_pen};
pub use super::plot::{
    Axis, Curve, Layout, axis, bars, curve, dots, exact_curve, layout, map_layout, plot,
};

/// A figure with its title and caption.
pub struct Figure {
    /// Identifier in the page: letters, digits and dashes.
    pub id: String,
    /// Title, as text.
    pub title: String,
    /// Caption with reading instructions, as HTML.
    pub caption: String,
    /// Height of the plot in CSS pixels.
    pub height_px: u32,
    /// Its width on the page.
    pub span: Span,
    /// Whether its x axis is time; such figures share their zoom.
    pub over_time: bool,
    /// Curves and layout, from [`plot`].
    pub plot: String,
    /// The largest magnitude of its values, in the unit of its axis; infinite if unknown.
    pub largest: f64,
}

impl Figure {
    /// A figure of half the page's width, 320 pixels high, from the curves and layout of [`plot`].
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
            largest: f64::INFINITY,
        }
    }

    /// A figure of curves over time.
    pub fn over_time(
        id: impl Into<String>,
        title: impl Into<String>,
        caption: impl Into<String>,
        curves: Vec<Curve>,
        values: Axis,
    ) -> Self {
        let largest = curves.iter().map(Curve::largest).fold(0.0, f64::max);
        let plot = plot(curves, Layout::of(axis("t in s"), values));
        Self {
            over_time: true,
            largest,
            ..Self::new(id, title, caption, plot)
        }
    }

    /// Returns the figure with another height of its plot.
    pub fn height_px(self, height_px: u32) -> Self {
        Self { height_px, ..self }
    }

    /// Returns the figure with another width.
    pub fn spanning(self, span: Span) -> Self {
        Self { span, ..self }
    }
}

/// Width of a figure on a wide screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// Half of the page.
    Half,
    /// The whole page.
    Whole,
    /// One of a row of small panels, without its own caption.
    Panel,
}
