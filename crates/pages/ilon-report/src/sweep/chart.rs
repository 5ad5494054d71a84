//! Figures of a study as SVG.

use std::fmt::Write;

use super::input::{Sensitivity, figure};
use super::shape::{Content, Field, Figure, Scale, ascending};
use crate::page::escape;
use crate::text::round_up;
use ilon_trace::significant;

/// Width and height of a figure, in pixels.
const SIZE: (f64, f64) = (560.0, 300.0);
/// The plot area: left, right, top, bottom, in pixels.
const AREA: (f64, f64, f64, f64) = (64.0, 548.0, 10.0, 256.0);
/// Of more points only the ends and the ringed one are named: labels would cover one another.
const MOST_NAMED: usize = 10;

/// A map from values to positions along a figure.
struct Placement {
    low: f64,
    high: f64,
    is_log: bool,
    from: f64,
    to: f64,
}

impl Placement {
    /// Spans values, with a margin if they have a spread.
    fn of(
        values: impl Iterator<Item = f64>,
        is_log: bool,
        from: f64,
        to: f64,
        margin: f64,
    ) -> Self {
        let values: Vec<f64> = values
            .filter(|x| x.is_finite() && (!is_log || *x > 0.0))
            .collect();
        let of = |x: f64| if is_log { x.log10() } else { x };
        let mut low = values.iter().map(|x| of(*x)).fold(f64::INFINITY, f64::min);
        let mut high = values
            .iter()
            .map(|x| of(*x))
            .fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let spread = high - low;
        if spread <= 1e-12 * high.abs().max(1e-300) {
            let around = 0.5 * high.abs().max(1e-3);
            (low, high) = (low - around, high + around);
        } else {
            (low, high) = (low - margin * spread, high + margin * spread);
        }
        Self {
            low,
            high,
            is_log,
            from,
            to,
        }
    }

    fn at(&self, value: f64) -> f64 {
        let value = if self.is_log {
            value.max(f64::MIN_POSITIVE).log10()
        } else {
            value
        };
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Returns round values along it.
    fn ticks(&self) -> Vec<f64> {
        if self.is_log {
            let decades: Vec<f64> = (self.low.floor() as i32..=self.high.ceil() as i32)
                .flat_map(|decade| [1.0, 2.0, 5.0].map(|x| x * 10_f64.powi(decade)))
                .filter(|x| (self.low..=self.high).contains(&x.log10()))
                .collect();
            if decades.len() >= 2 {
                let every = decades.len().div_ceil(7);
                return decades.into_iter().step_by(every).collect();
            }
        }
        let (low, high) = if self.is_log {
            (10_f64.powf(self.low), 10_f64.powf(self.high))
        } else {
            (self.low, self.high)
        };
        let step = round_up((high - low) / 5.0);
        let first = (low / step).ceil() as i64;
        let last = (high / step).floor() as i64;
        (first..=last.min(first + 12))
            .map(|tick| significant(tick as f64 * step, 10))
            .collect()
    }
}

/// A figure on its own card.
pub(super) fn card(drawn: &Figure, leads: bool) -> String {
    let (svg, legend) = match &drawn.content {
        Content::Heat(fields) => (heat(drawn, fields, leads), String::new()),
        _ => (lines(drawn, leads), legend(drawn)),
    };
    framed(&drawn.title, &drawn.caption, &format!("{legend}{svg}"))
}

/// A shape, as a link to the row of a run if it `leads` there.
fn linked(shape: &str, run: u64, leads: bool) -> String {
    match leads {
        true => format!("<a href=\"#run-{run}\">{shape}</a>"),
        false => shape.to_owned(),
    }
}

fn framed(title: &str, caption: &str, content: &str) -> String {
    format!(
        "<figure><figcaption><h3>{}</h3><p>{}</p></figcaption>{content}</figure>\n",
        escape(title),
        escape(caption)
    )
}

fn svg(label: &str, content: &str) -> String {
    svg_of(label, SIZE.1, content)
}

fn svg_of(label: &str, height: f64, content: &str) -> String {
    // Links inside a picture would be out of reach of screen readers.
    let role = if content.contains("<a ") {
        "group"
    } else {
        "img"
    };
    format!(
        "<svg viewBox=\"0 0 {} {height}\" role=\"{role}\" aria-label=\"{}\" style=\"width:100%;height:auto;font-size:11px\" \
         fill=\"var(--muted)\">{content}</svg>",
        SIZE.0,
        escape(label)
    )
}

fn x_axis(scale: &Scale, place: &Placement, svg: &mut String) {
    let (_, _, top, bottom) = AREA;
    let words = scale
        .words
        .iter()
        .enumerate()
        .map(|(at, word)| (at as f64, word.clone()));
    let ticks: Vec<(f64, String)> = if scale.words.is_empty() {
        place.ticks().into_iter().map(|x| (x, figure(x))).collect()
    } else {
        words.collect()
    };
    for (x, word) in ticks {
        let x = place.at(x);
        let _ = write!(
            svg,
            "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{top}\" y2=\"{bottom}\" stroke=\"var(--grid)\"/>{}",
            text(x, bottom + 15.0, "middle", &word)
        );
    }
    *svg += &x_title(scale);
}

/// Text in a figure, anchored at its "start", "middle" or "end".
fn text(x: f64, y: f64, anchor: &str, words: &str) -> String {
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
        escape(words)
    )
}

/// Returns the title of the x axis.
fn x_title(scale: &Scale) -> String {
    let (left, right, _, bottom) = AREA;
    text((left + right) / 2.0, bottom + 34.0, "middle", &scale.name)
}

fn y_axis(place: &Placement, svg: &mut String) {
    let (left, right, ..) = AREA;
    for value in place.ticks() {
        let y = place.at(value);
        let _ = write!(
            svg,
            "<line x1=\"{left}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"var(--grid)\"/>{}",
            text(left - 6.0, y + 4.0, "end", &figure(value))
        );
    }
}

/// Draws curves or a cloud over one axis.
fn lines(drawn: &Figure, leads: bool) -> String {
    let (left, right, top, bottom) = AREA;
    let xs: Vec<f64> = match &drawn.content {
        Content::Curves(curves) => {
            let points = curves.iter().flat_map(|curve| &curve.points);
            points.map(|point| point.x).collect()
        }
        Content::Cloud(points) => points.iter().map(|(x, _)| *x).collect(),
        Content::Heat(_) => return String::new(),
    };
    let words = drawn.x.words.len();
    let xs = xs.into_iter().chain((0..words).map(|at| at as f64));
    let x = Placement::of(
        xs,
        drawn.x.is_log && words == 0,
        left,
        right,
        if words > 0 { 0.1 } else { 0.02 },
    );
    let ys = drawn.content.values().into_iter();
    let y = Placement::of(ys.chain(drawn.bound), false, bottom, top, 0.05);
    let mut content = String::new();
    x_axis(&drawn.x, &x, &mut content);
    y_axis(&y, &mut content);
    if let Some(bound) = drawn.bound {
        let _ = write!(
            content,
            "<line x1=\"{left}\" x2=\"{right}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"var(--limit)\" \
             stroke-dasharray=\"6 4\" stroke-width=\"1.5\"/>",
            at = y.at(bound)
        );
    }
    match &drawn.content {
        Content::Curves(curves) => {
            let points = || curves.iter().flat_map(|curve| &curve.points);
            let least = points().min_by(|a, b| a.mean.total_cmp(&b.mean));
            let (ringed, word) = match &drawn.named {
                Some((_, ringed)) => (points().nth(*ringed), "compromise"),
                None => (least, "least"),
            };
            if let Some(point) = ringed.filter(|point| points().any(|p| p.mean != point.mean)) {
                let (x, y) = (x.at(point.x), y.at(point.mean));
                let _ = write!(
                    content,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"8\" fill=\"none\" stroke=\"var(--fg)\"><title>{word}</title></circle>"
                );
            }
            for (index, curve) in curves.iter().enumerate() {
                let color = format!("var(--w{})", index % 8);
                let place = |at: f64, value: f64| format!("{:.1},{:.1} ", x.at(at), y.at(value));
                if curve.points.iter().any(|point| point.largest > point.least) {
                    let there = curve.points.iter().map(|p| place(p.x, p.largest));
                    let back = curve.points.iter().rev().map(|p| place(p.x, p.least));
                    let band: String = there.chain(back).collect();
                    let _ = write!(
                        content,
                        "<polygon points=\"{band}\" fill=\"{color}\" opacity=\"0.15\"/>"
                    );
                }
                let line: String = curve.points.iter().map(|p| place(p.x, p.mean)).collect();
                if words == 0 {
                    let _ = write!(
                        content,
                        "<polyline points=\"{line}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>"
                    );
                }
                if curve.points.len() <= 60 {
                    for (place, point) in curve.points.iter().enumerate() {
                        let name = drawn.named.as_ref().and_then(|(names, ringed)| {
                            let ends = [0, *ringed, names.len() - 1];
                            let is_named = names.len() <= MOST_NAMED || ends.contains(&place);
                            names.get(place).filter(|_| is_named)
                        });
                        if let Some(name) = name {
                            let (at, above) = (x.at(point.x), y.at(point.mean) - 7.0);
                            content += &match at < 0.95 * right {
                                true => text(at + 9.0, above, "start", name),
                                false => text(at - 9.0, above, "end", name),
                            };
                        }
                        let circle = format!(
                            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{color}\">\
                             <title>{}: {}, run {}</title></circle>",
                            x.at(point.x),
                            y.at(point.mean),
                            figure(point.x),
                            figure(point.mean),
                            point.run
                        );
                        content += &linked(&circle, point.run, leads);
                    }
                }
            }
        }
        Content::Cloud(points) => {
            // One path of dots: a tenth of the size of as many circles.
            let mut dots = String::new();
            for (a, b) in points {
                let _ = write!(dots, "M{:.0} {:.0}h0", x.at(*a), y.at(*b));
            }
            let _ = write!(
                content,
                "<path d=\"{dots}\" stroke=\"var(--w0)\" stroke-width=\"4\" stroke-linecap=\"round\" opacity=\"0.45\" \
                 fill=\"none\"/>"
            );
        }
        Content::Heat(_) => {}
    }
    svg(&drawn.title, &content)
}

fn legend(drawn: &Figure) -> String {
    let Content::Curves(curves) = &drawn.content else {
        return String::new();
    };
    if curves.len() < 2 {
        return String::new();
    }
    legend_of(curves.iter().map(|curve| curve.name.as_str()))
}

/// Draws a legend of names in the wheels' colours.
fn legend_of<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let item = |(index, name)| {
        format!(
            "<li><span class=\"swatch\" style=\"background:var(--w{})\"></span>{}</li>",
            index % 8,
            escape(name)
        )
    };
    let items: String = names.enumerate().map(item).collect();
    format!("<ul class=\"legend\">{items}</ul>")
}

/// Draws a heat map: a field for each pair of values, stronger in colour the larger.
fn heat(drawn: &Figure, fields: &[Field], leads: bool) -> String {
    let (left, right, top, bottom) = AREA;
    let values = || fields.iter().filter_map(|field| Some(field.2?.0));
    let (least, largest) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let xs = ascending(fields.iter().map(|field| field.0));
    let ys = ascending(fields.iter().map(|field| field.1));
    let (width, height) = (
        (right - left) / xs.len() as f64,
        (bottom - top) / ys.len() as f64,
    );
    let mut content = String::new();
    for (x, y, value) in fields {
        let place = |all: &[f64], value: &f64| {
            all.iter().position(|known| known == value).unwrap_or(0) as f64
        };
        let Some((value, run)) = value else {
            continue;
        };
        let share = if largest > least {
            (value - least) / (largest - least)
        } else {
            0.5
        };
        let is_beyond = drawn.bound.is_some_and(|bound| *value > bound);
        let field = format!(
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"var(--{})\" opacity=\"{:.2}\">\
             <title>{}: {}, run {run}</title></rect>",
            left + place(&xs, x) * width,
            bottom - (1.0 + place(&ys, y)) * height,
            (width - 1.0).max(0.5),
            (height - 1.0).max(0.5),
            if is_beyond { "limit" } else { "accent" },
            0.12 + 0.85 * share,
            escape(&format!("{}, {}", figure(*x), figure(*y))),
            figure(*value)
        );
        content += &linked(&field, *run, leads);
    }
    let label = |scale: &Scale, value: f64| {
        scale
            .words
            .get(value as usize)
            .cloned()
            .unwrap_or_else(|| figure(value))
    };
    let every = xs.len().div_ceil(8);
    for (at, x) in xs.iter().enumerate().step_by(every) {
        let middle = left + (at as f64 + 0.5) * width;
        content += &text(middle, bottom + 15.0, "middle", &label(&drawn.x, *x));
    }
    if let Some(scale) = &drawn.y {
        let every = ys.len().div_ceil(9);
        for (at, y) in ys.iter().enumerate().step_by(every) {
            let middle = bottom - (at as f64 + 0.5) * height + 4.0;
            content += &text(left - 6.0, middle, "end", &label(scale, *y));
        }
        content += &x_title(&drawn.x);
    }
    svg(&drawn.title, &content)
}

/// Draws the effect of each axis on a quantity as bars with intervals.
pub(super) fn bars(sensitivity: &Sensitivity) -> String {
    let left = 190.0;
    let right = 548.0;
    let all = sensitivity.bars.iter().flat_map(|(_, bars)| bars);
    let ends = all.flat_map(|(value, interval)| {
        let (low, high) = interval.unwrap_or((*value, *value));
        [*value, low, high]
    });
    let x = Placement::of(ends.chain([0.0]), false, left, right, 0.03);
    let height = 30.0 + 34.0 * sensitivity.bars.len() as f64;
    let mut content = String::new();
    for tick in x.ticks() {
        let at = x.at(tick);
        let _ = write!(
            content,
            "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"4\" y2=\"{:.1}\" stroke=\"var(--grid)\"/>{}",
            height - 20.0,
            text(at, height - 6.0, "middle", &figure(tick))
        );
    }
    for (row, (key, bars)) in sensitivity.bars.iter().enumerate() {
        let y = 8.0 + 34.0 * row as f64;
        content += &text(left - 8.0, y + 16.0, "end", key);
        for (which, (value, interval)) in bars.iter().enumerate() {
            let top = y + 13.0 * which as f64;
            let (from, to) = (x.at(0.0).min(x.at(*value)), x.at(0.0).max(x.at(*value)));
            let _ = write!(
                content,
                "<rect x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"11\" fill=\"var(--w{which})\">\
                 <title>{}: {}</title></rect>",
                to - from,
                escape(&sensitivity.names[which]),
                figure(*value)
            );
            if let Some((low, high)) = interval {
                let _ = write!(
                    content,
                    "<line x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{mid:.1}\" y2=\"{mid:.1}\" stroke=\"var(--fg)\"/>",
                    x.at(*low),
                    x.at(*high),
                    mid = top + 5.5
                );
            }
        }
    }
    let legend = legend_of(sensitivity.names.iter().map(String::as_str));
    let drawn = svg_of(&sensitivity.title, height, &content);
    framed(&sensitivity.title, &sensitivity.caption, &(legend + &drawn))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_with_a_spread_get_the_margin_as_a_share_of_it_on_either_side() {
        let placed = Placement::of([2.0, 6.0, 3.0].into_iter(), false, 0.0, 1.0, 0.25);
        assert_eq!([placed.low, placed.high], [1.0, 7.0]);
        assert_eq!([1.0, 4.0, 7.0].map(|x| placed.at(x)), [0.0, 0.5, 1.0]);
    }

    /// Bars of 2 to the right and 1 to the left: both end at zero, and one is twice as long as the
    /// other.
    #[test]
    fn bars_reach_from_zero_to_their_value_on_either_side() {
        let drawn = bars(&Sensitivity {
            title: String::new(),
            caption: String::new(),
            names: ["first".to_owned(), "total".to_owned()],
            bars: vec![("friction".to_owned(), [(2.0, None), (-1.0, None)])],
        });
        let of = |bar: &str, key: &str| -> f64 {
            let (_, rest) = bar.split_once(&format!(" {key}=\"")).expect("a key");
            let (value, _) = rest.split_once('"').expect("its end");
            value.parse().expect("a number")
        };
        let found: Vec<[f64; 2]> = drawn
            .split("<rect")
            .skip(1)
            .filter(|bar| bar.contains("height=\"11\""))
            .map(|bar| [of(bar, "x"), of(bar, "width")])
            .collect();
        let [[zero, right], [start, left]] = found[..] else {
            panic!("{drawn}");
        };
        // Written to a tenth of a pixel: each number is off by at most half of that.
        assert!((start + left - zero).abs() < 0.16, "{found:?}");
        assert!(left > 0.0 && (right - 2.0 * left).abs() < 0.16, "{found:?}");
    }

    /// Two by two fields of a plot 484 wide and 246 high: each spans a half, the smaller values to
    /// the left and below, and a label of y lies beside the middle of its field.
    #[test]
    fn a_field_lies_where_its_values_do_and_labels_stand_beside_their_fields() {
        let scale = Scale {
            name: String::new(),
            is_log: false,
            words: Vec::new(),
        };
        let drawn = Figure {
            title: String::new(),
            caption: String::new(),
            x: scale.clone(),
            y: Some(scale),
            content: Content::Cloud(Vec::new()),
            bound: None,
            named: None,
        };
        let fields = [
            (1.0, 3.0, Some((0.0, 0))),
            (2.0, 3.0, Some((1.0, 1))),
            (1.0, 4.0, Some((2.0, 2))),
        ];
        let html = heat(&drawn, &fields, false);
        for place in [
            "x=\"64.0\" y=\"133.0\"",
            "x=\"306.0\" y=\"133.0\"",
            "x=\"64.0\" y=\"10.0\"",
        ] {
            assert!(html.contains(&format!("<rect {place} ")), "{place}: {html}");
        }
        // 4 px below the middles, which are at 133 -+ 61.5 px.
        for (y, label) in [("75.5", "4"), ("198.5", "3")] {
            let text = format!("<text x=\"58.0\" y=\"{y}\" text-anchor=\"end\">{label}</text>");
            assert!(html.contains(&text), "{text}: {html}");
        }
    }
}
