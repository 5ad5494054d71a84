//! One figure of the report, and the few kinds of curve that all figures are made of.
//!
//! Colours are named by what they stand for (`@real`, `@slip`, `@w0`); the page's script replaces the names by the
//! colours of its light or dark theme, both from the palette of Okabe and Ito, which the colour-blind can tell apart.
//! Curves that share a panel differ in their dashes too.

use plotly::common::{DashType, Line, Marker, Mode, Title};
use plotly::layout::{Axis, Layout};
use plotly::{Plot, Scatter};

use super::thin::{MAX_POINTS, envelope, short};

/// Significant digits of plotted values: a thousandth of a pixel on any screen.
const DIGITS: usize = 6;

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
    /// Curves and layout as JSON: plotly's own value carries its whole script along, megabytes of it.
    pub plot: String,
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

    /// As plotly has it.
    pub fn line(self) -> Line {
        let dash = match self.dash {
            DashKind::Solid => DashType::Solid,
            DashKind::Dash => DashType::Dash,
            DashKind::Dot => DashType::Dot,
            DashKind::DashDot => DashType::DashDot,
        };
        Line::new()
            .color(self.color)
            .dash(dash)
            .width(self.width_px)
    }
}

/// A curve over time, thinned to its outline.
pub fn curve(
    name: &str,
    points: impl Iterator<Item = (f64, f64)>,
    pen: Pen,
) -> Box<Scatter<f64, f64>> {
    let points: Vec<_> = points.collect();
    exact_curve(name, envelope(&points, MAX_POINTS).into_iter(), pen)
}

/// A curve of few points, all of them drawn.
pub fn exact_curve(
    name: &str,
    points: impl Iterator<Item = (f64, f64)>,
    pen: Pen,
) -> Box<Scatter<f64, f64>> {
    let (x, y) = points
        .map(|(x, y)| (short(x, DIGITS), short(y, DIGITS)))
        .unzip();
    Scatter::new(x, y)
        .name(super::page::escape(name))
        .mode(Mode::Lines)
        .line(pen.line())
}

/// Points without a line.
pub fn dots(
    name: &str,
    points: impl Iterator<Item = (f64, f64)>,
    color: &'static str,
    size_px: usize,
) -> Box<Scatter<f64, f64>> {
    exact_curve(name, points, solid(color))
        .mode(Mode::Markers)
        .marker(Marker::new().color(color).size(size_px).opacity(0.55))
}

/// A layout with named axes.
pub fn layout(x_title: &str, y_title: &str) -> Layout {
    Layout::new().x_axis(axis(x_title)).y_axis(axis(y_title))
}

/// An axis with its title.
pub fn axis(title: &str) -> Axis {
    Axis::new().title(Title::with_text(title))
}

/// A layout for a map: both axes in metres at the same scale.
pub fn map_layout() -> Layout {
    Layout::new()
        .x_axis(axis("x in m"))
        .y_axis(axis("y in m").scale_anchor("x"))
}

/// A plot of curves in a layout, as JSON.
pub fn plot(traces: Vec<Box<dyn plotly::Trace>>, layout: Layout) -> String {
    let mut plot = Plot::new();
    plot.add_traces(traces);
    plot.set_layout(layout);
    plot.to_json()
}
