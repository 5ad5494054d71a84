//! The content of a figure (curves and axes), and its encoding for the page's script.
//!
//! Colours are named by their meaning (`@real`, `@slip`, `@w0`); the script looks them up in the
//! style sheet, so that a figure follows the light and the dark theme. Long columns are
//! little-endian numbers in base64: times as 16 bits over the curve's own range, which is finer
//! than any screen, values as f32.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use super::decimate::{MAX_POINTS, envelope};
use super::pen::{Pen, solid};
use ilon_trace::significant;

/// Significant digits of numbers written as text.
const DIGITS: usize = 6;

/// Columns up to this length are written as text.
const SHORT_COLUMN: usize = 24;

/// One curve, cloud of dots or row of bars.
#[derive(Clone, Debug)]
pub struct Curve {
    name: String,
    kind: CurveKind,
    pen: Pen,
    size_px: usize,
    opacity: f64,
    listed: bool,
    labels: Vec<String>,
    labels_below: bool,
    points: Vec<(f64, f64)>,
}

/// Drawing style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CurveKind {
    /// From point to point.
    Line,
    /// Constant from each point to the next.
    Steps,
    /// Only dots.
    Dots,
    /// The area stacked on the areas before it.
    Area,
    /// Bars along x, one for each row.
    Bars,
}

/// A curve over time, reduced to its envelope.
pub fn curve(name: &str, points: impl Iterator<Item = (f64, f64)>, pen: Pen) -> Curve {
    let points: Vec<_> = points.collect();
    exact_curve(name, envelope(&points, MAX_POINTS).into_iter(), pen)
}

/// A curve of few points, all of them drawn.
pub fn exact_curve(name: &str, points: impl Iterator<Item = (f64, f64)>, pen: Pen) -> Curve {
    Curve {
        name: name.to_owned(),
        kind: CurveKind::Line,
        pen,
        size_px: 6,
        opacity: 1.0,
        listed: true,
        labels: Vec::new(),
        labels_below: false,
        points: points.collect(),
    }
}

/// Points without a line.
pub fn dots(
    name: &str,
    points: impl Iterator<Item = (f64, f64)>,
    color: &'static str,
    size_px: usize,
) -> Curve {
    Curve {
        kind: CurveKind::Dots,
        size_px,
        opacity: 0.55,
        ..exact_curve(name, points, solid(color))
    }
}

/// A bar in each row of an axis with names; `None` for a missing value.
pub fn bars(name: &str, values: &[Option<f64>], color: &'static str) -> Curve {
    let rows = values.iter().enumerate();
    let points = rows.map(|(row, x)| (x.unwrap_or(f64::NAN), row as f64));
    Curve {
        kind: CurveKind::Bars,
        ..exact_curve(name, points, solid(color))
    }
}

impl Curve {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The largest magnitude of its values: of bars their lengths.
    pub fn largest(&self) -> f64 {
        let value = |(x, y): &(f64, f64)| match self.kind {
            CurveKind::Bars => x.abs(),
            _ => y.abs(),
        };
        self.points.iter().map(value).fold(0.0, f64::max)
    }

    /// Makes the curve constant from each point to the next.
    pub fn steps(mut self) -> Self {
        self.kind = CurveKind::Steps;
        self
    }

    /// Makes it an area stacked on the areas before it. All areas of a plot need the same x.
    pub fn stacked(mut self) -> Self {
        self.kind = CurveKind::Area;
        self
    }

    /// Leaves the curve out of the legend.
    pub fn unlisted(mut self) -> Self {
        self.listed = false;
        self
    }

    /// Sets the opacity, from 0 to 1.
    pub fn opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// Adds labels at its points, above or below them.
    pub fn labels(mut self, labels: Vec<String>, below: bool) -> Self {
        self.labels = labels;
        self.labels_below = below;
        self
    }

    fn to_json(&self) -> Value {
        let kind = match self.kind {
            CurveKind::Line => "line",
            CurveKind::Steps => "steps",
            CurveKind::Dots => "dots",
            CurveKind::Area => "area",
            CurveKind::Bars => "bars",
        };
        let has_dots = self.kind == CurveKind::Dots;
        let has_labels = !self.labels.is_empty();
        let (x, y): (Vec<f64>, Vec<f64>) = self.points.iter().copied().unzip();
        without_nulls(json!({
            "name": self.name,
            "color": self.pen.color.trim_start_matches('@'),
            "kind": kind,
            "width": self.pen.width_px,
            "dash": self.pen.dash.name(),
            "size": has_dots.then_some(self.size_px),
            "opacity": (self.opacity < 1.0).then_some(self.opacity),
            "unlisted": (!self.listed).then_some(true),
            "labels": has_labels.then_some(&self.labels),
            "below": has_labels.then_some(self.labels_below),
            "x": column(&x, true),
            "y": column(&y, false),
        }))
    }
}

/// Removes null fields from an object.
fn without_nulls(mut object: Value) -> Value {
    if let Some(fields) = object.as_object_mut() {
        fields.retain(|_, value| !value.is_null());
    }
    object
}

/// Encodes a column of numbers. NaN becomes a gap.
fn column(values: &[f64], coarse: bool) -> Value {
    if values.len() <= SHORT_COLUMN {
        let values = values.iter().map(|&x| significant(x, DIGITS));
        return values.collect::<Vec<_>>().into();
    }
    if coarse && values.iter().all(|x| x.is_finite()) {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let step = (high - low) / f64::from(u16::MAX);
        let steps = values.iter().map(|x| match step > 0.0 {
            true => ((x - low) / step).round() as u16,
            false => 0,
        });
        let bytes: Vec<u8> = steps.flat_map(u16::to_le_bytes).collect();
        return json!({ "from": low, "step": step, "u16": BASE64_STANDARD.encode(bytes) });
    }
    let bytes: Vec<u8> = values
        .iter()
        .flat_map(|&x| (x as f32).to_le_bytes())
        .collect();
    json!({ "f32": BASE64_STANDARD.encode(bytes) })
}

/// An axis.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    title: String,
    from_zero: bool,
    range: Option<[f64; 2]>,
    least_span: f64,
    names: Vec<String>,
}

/// An axis with its title, as text.
pub fn axis(title: &str) -> Axis {
    Axis {
        title: title.to_owned(),
        ..Axis::default()
    }
}

impl Axis {
    /// Always includes zero.
    pub fn from_zero(mut self) -> Self {
        self.from_zero = true;
        self
    }

    /// Sets a fixed range.
    pub fn range(mut self, from: f64, to: f64) -> Self {
        self.range = Some([from, to]);
        self
    }

    /// Sets a smallest span: smaller variation is noise, and is drawn small.
    pub fn least_span(self, least_span: f64) -> Self {
        Self { least_span, ..self }
    }

    /// Replaces numbers by row names, the first on top.
    pub fn names(self, names: Vec<String>) -> Self {
        Self { names, ..self }
    }

    fn to_json(&self) -> Value {
        without_nulls(json!({
            "title": self.title,
            "zero": self.from_zero.then_some(true),
            "range": self.range,
            "least": (self.least_span > 0.0).then_some(self.least_span),
            "names": (!self.names.is_empty()).then_some(&self.names),
        }))
    }
}

/// The axes of a plot, and their use by curves.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    x: Axis,
    y: Axis,
    equal: bool,
    grouped: bool,
    marks: bool,
}

/// A layout with named axes.
pub fn layout(x_title: &str, y_title: &str) -> Layout {
    Layout::of(axis(x_title), axis(y_title))
}

/// A layout for a map: both axes in metres at the same scale.
pub fn map_layout() -> Layout {
    layout("x in m", "y in m").equal()
}

impl Layout {
    /// A layout of two axes.
    pub fn of(x: Axis, y: Axis) -> Self {
        Self {
            x,
            y,
            ..Self::default()
        }
    }

    /// Gives both axes the same scale.
    pub fn equal(mut self) -> Self {
        self.equal = true;
        self
    }

    /// Puts the bars of a row below each other; otherwise they are stacked by sign.
    pub fn grouped(mut self) -> Self {
        self.grouped = true;
        self
    }

    /// Hides the axes, as for circles around a centre.
    pub fn bare(mut self) -> Self {
        self.marks = true;
        self
    }
}

/// Returns a plot of curves in a layout, as JSON.
pub fn plot(curves: Vec<Curve>, layout: Layout) -> String {
    let curves: Vec<Value> = curves.iter().map(Curve::to_json).collect();
    json!({
        "x": layout.x.to_json(), "y": layout.y.to_json(), "equal": layout.equal, "grouped": layout.grouped,
        "bare": layout.marks, "curves": curves,
    })
    .to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_columns_keep_their_values_to_what_a_screen_shows() {
        let points = (0..1000).map(|k| (0.04 * f64::from(k), (0.1 * f64::from(k)).sin()));
        let json = exact_curve("a", points.clone(), solid("@real")).to_json();
        let decode = |text: &Value| {
            BASE64_STANDARD
                .decode(text.as_str().expect("text"))
                .expect("base64")
        };
        let from = json["x"]["from"].as_f64().expect("a number");
        let step = json["x"]["step"].as_f64().expect("a number");
        let x = decode(&json["x"]["u16"]);
        let y = decode(&json["y"]["f32"]);
        for (k, (want_x, want_y)) in points.enumerate() {
            let found_x = from + step * f64::from(u16::from_le_bytes([x[2 * k], x[2 * k + 1]]));
            let found_y = f32::from_le_bytes(y[4 * k..4 * k + 4].try_into().expect("four bytes"));
            // Half a step of 40 s over 65535 parts; f32 has 24 bits.
            assert!(
                (found_x - want_x).abs() <= 0.5001 * step,
                "{found_x} {want_x}"
            );
            assert!(
                (f64::from(found_y) - want_y).abs() <= 6e-8,
                "{found_y} {want_y}"
            );
        }
    }

    #[test]
    fn gaps_stay_gaps_in_short_and_long_columns() {
        let short = exact_curve("a", [(0.0, f64::NAN)].into_iter(), solid("@real")).to_json();
        assert!(short["y"][0].is_null());
        let long = exact_curve("a", (0..99).map(|_| (f64::NAN, 1.0)), solid("@real")).to_json();
        assert!(long["x"]["f32"].is_string());
    }
}
