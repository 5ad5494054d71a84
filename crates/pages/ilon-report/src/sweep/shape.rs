//! Chooses the figures of a study, and their points.

use super::input::{Run, StudyInput, figure};

/// Largest number of curves in one figure.
const MOST_CURVES: usize = 8;
/// Largest number of points of a cloud: more cannot be distinguished.
const MOST_POINTS: usize = 1500;
/// Largest number of values of an axis of a heat map.
const MOST_FIELDS: usize = 60;

/// The key under which runs are repeated.
const SEED: &str = "sensors.seed";

/// A figure of one quantity.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Figure {
    pub title: String,
    pub caption: String,
    pub x: Scale,
    /// The second axis of a heat map.
    pub y: Option<Scale>,
    pub content: Content,
    /// Reference value of the quantity.
    pub bound: Option<f64>,
    /// Names of the points of a trade-off, and the one that is ringed; else the least is.
    pub named: Option<(Vec<String>, usize)>,
}

/// An axis of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scale {
    pub name: String,
    pub is_log: bool,
    /// The texts of an axis without numbers, at 0, 1, 2 and so on.
    pub words: Vec<String>,
}

/// A field for a pair of values: x, y, and the mean with its first run.
pub(super) type Field = (f64, f64, Option<(f64, u64)>);

/// Content of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Content {
    /// Means over repetitions with minimum and maximum, in the order of x, a curve for each of the
    /// other values.
    Curves(Vec<Curve>),
    /// One point per run.
    Cloud(Vec<(f64, f64)>),
    /// A field for each pair of values.
    Heat(Vec<Field>),
}

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    pub name: String,
    pub points: Vec<Point>,
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub x: f64,
    pub mean: f64,
    pub least: f64,
    pub largest: f64,
    /// The first of its runs.
    pub run: u64,
}

impl Content {
    /// Returns the values along the quantity's own axis; empty if drawn in colours.
    pub fn values(&self) -> Vec<f64> {
        match self {
            Self::Curves(curves) => {
                let points = curves.iter().flat_map(|curve| &curve.points);
                points.flat_map(|at| [at.least, at.largest]).collect()
            }
            Self::Cloud(points) => points.iter().map(|(_, value)| *value).collect(),
            Self::Heat(_) => Vec::new(),
        }
    }
}

/// Whether values are distinguishable next to a bound on one axis: they must take at least a
/// quarter of it.
fn is_in_sight(values: &[f64], bound: f64) -> bool {
    let Some(&first) = values.first() else {
        return true;
    };
    let range = |from: f64| {
        let least = values.iter().copied().fold(from, f64::min);
        values.iter().copied().fold(from, f64::max) - least
    };
    range(first) == 0.0 || range(first) >= 0.25 * range(bound)
}

/// Returns the figures of a study.
pub(super) fn figures(shown: &StudyInput, most_quantities: usize) -> Vec<Figure> {
    let mut figures = Vec::new();
    let keys = varying(shown);
    for quantity in 0..shown.quantities.len().min(most_quantities) {
        // What all runs come to, to the shown digits, is a sentence.
        let values = shown.runs.iter().filter_map(|run| run.figures[quantity]);
        let mut values = values.map(figure);
        let first = values.next();
        if values.all(|value| Some(value) == first) {
            continue;
        }
        if shown.is_sample {
            // For a sample with many keys, the first quantities are enough.
            let most = if quantity == 0 { 12 } else { 4 };
            figures.extend(
                keys.iter()
                    .take(most)
                    .map(|key| cloud(shown, quantity, *key)),
            );
            continue;
        }
        let widest = |keys: &mut dyn Iterator<Item = usize>| {
            keys.max_by_key(|key| distinct(shown, *key).len())
        };
        let numeric = keys.iter().copied();
        let mut numeric = numeric.filter(|key| shown.varied[*key].words.is_empty());
        let drawn_over = widest(&mut numeric).or_else(|| widest(&mut keys.iter().copied()));
        match (keys.as_slice(), drawn_over) {
            ([], _) | (_, None) => {}
            ([a, b], _) if is_fields(shown, *a, *b) => {
                figures.push(curves(shown, quantity, wider(shown, *a, *b)));
                figures.push(heat(shown, quantity, *a, *b));
            }
            (_, Some(key)) => {
                let drawn = curves(shown, quantity, key);
                match &drawn.content {
                    Content::Curves(curves) if curves.len() > MOST_CURVES => {
                        figures.extend(keys.iter().take(6).map(|key| cloud(shown, quantity, *key)));
                    }
                    _ => figures.push(drawn),
                }
            }
        }
    }
    figures
}

/// Returns the figure of two quantities that pull apart along a key, one over the other.
pub(super) fn trade(shown: &StudyInput) -> Option<Figure> {
    let ([across, up], key, best) = shown.trade?;
    let (over, content) = match (
        varying(shown).as_slice(),
        shown.runs.iter().all(|run| run.scenario == 0),
    ) {
        ([one], true) if *one == key => (
            across,
            [across, up].map(|of| curves(shown, of, key).content),
        ),
        _ => return None,
    };
    let [Content::Curves(across), Content::Curves(up)] = content else {
        return None;
    };
    let (across, up) = (across.into_iter().next()?, up.into_iter().next()?);
    let ringed = up.points.iter().position(|point| point.x == best)?;
    let names = up.points.iter().map(|point| figure(point.x)).collect();
    let points = up.points.into_iter().zip(across.points);
    let points = points.map(|(up, across)| Point {
        x: across.mean,
        least: up.mean,
        largest: up.mean,
        ..up
    });
    let points: Vec<Point> = points.collect();
    let [x, y] = [over, shown.trade?.0[1]].map(|of| shown.quantities[of].name.clone());
    Some(Figure {
        title: "Trade-off".to_owned(),
        caption: format!(
            "Up: {y}. To the right: {x}. Points are values of {}; lower left is better, a ring marks the compromise.",
            shown.varied[key].key
        ),
        x: Scale {
            name: x,
            is_log: false,
            words: Vec::new(),
        },
        y: None,
        content: Content::Curves(vec![Curve {
            name: String::new(),
            points,
        }]),
        bound: None,
        named: Some((names, ringed)),
    })
}

/// Returns the keys with several values, except the seed, which has no order.
fn varying(shown: &StudyInput) -> Vec<usize> {
    let varies = |key: &usize| shown.varied[*key].key != SEED && distinct(shown, *key).len() > 1;
    (0..shown.varied.len()).filter(varies).collect()
}

/// Returns the values of a key, in ascending order.
pub(super) fn distinct(shown: &StudyInput, key: usize) -> Vec<f64> {
    let runs = shown.runs.iter();
    ascending(runs.filter_map(|run| run.values.get(key).copied()))
}

/// Returns distinct values in ascending order.
pub(super) fn ascending(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Whether two keys form a grid of which enough points were run.
fn is_fields(shown: &StudyInput, a: usize, b: usize) -> bool {
    let (a, b) = (distinct(shown, a).len(), distinct(shown, b).len());
    a >= 3 && b >= 3 && a <= MOST_FIELDS && b <= MOST_FIELDS && a * b <= 2 * shown.runs.len()
}

fn wider(shown: &StudyInput, a: usize, b: usize) -> usize {
    if distinct(shown, b).len() > distinct(shown, a).len() {
        b
    } else {
        a
    }
}

fn scale(shown: &StudyInput, key: usize) -> Scale {
    let varied = &shown.varied[key];
    Scale {
        name: varied.key.clone(),
        is_log: varied.is_log,
        words: varied.words.clone(),
    }
}

fn cloud(shown: &StudyInput, quantity: usize, key: usize) -> Figure {
    let all: Vec<(f64, f64)> = shown
        .runs
        .iter()
        .filter_map(|run| Some((*run.values.get(key)?, run.figures[quantity]?)))
        .collect();
    let every = all.len().div_ceil(MOST_POINTS).max(1);
    let caption = match every {
        1 => String::new(),
        every => format!("One of {every} runs is shown."),
    };
    let content = Content::Cloud(all.into_iter().step_by(every).collect());
    over(shown, quantity, key, caption, content)
}

/// A figure of a quantity over a key.
fn over(
    shown: &StudyInput,
    quantity: usize,
    key: usize,
    mut caption: String,
    content: Content,
) -> Figure {
    let named = &shown.quantities[quantity];
    let values = content.values();
    let far = named.bound.filter(|bound| !is_in_sight(&values, *bound));
    if let Some(bound) = far {
        let lies_above = values.iter().all(|value| *value < bound);
        let way = if lies_above { "above" } else { "below" };
        caption += &format!(" Its bound, {}, is far {way}.", figure(bound));
    }
    Figure {
        title: format!("{} over {}", named.name, shown.varied[key].key),
        caption: caption.trim_start().to_owned(),
        x: scale(shown, key),
        y: None,
        content,
        bound: named.bound.filter(|_| far.is_none()),
        named: None,
    }
}

fn curves(shown: &StudyInput, quantity: usize, key: usize) -> Figure {
    let mut others = varying(shown);
    others.retain(|other| *other != key);
    let several_scenarios = shown.runs.iter().any(|run| run.scenario != 0);
    let name = |run: &Run| {
        let values = others.iter().map(|other| {
            format!(
                "{} = {}",
                shown.varied[*other].key,
                shown.value(*other, run.values[*other])
            )
        });
        let scenario = several_scenarios.then(|| format!("scenario {}", run.scenario + 1));
        scenario
            .into_iter()
            .chain(values)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let mut curves: Vec<(String, Vec<Sample>)> = Vec::new();
    for run in &shown.runs {
        let (Some(x), Some(value)) = (run.values.get(key), run.figures[quantity]) else {
            continue;
        };
        let name = name(run);
        match curves.iter().position(|(known, _)| *known == name) {
            Some(at) => curves[at].1.push((*x, value, run.run)),
            None if curves.len() > MOST_CURVES => {}
            None => curves.push((name, vec![(*x, value, run.run)])),
        }
    }
    let curves = curves.into_iter().map(|(name, points)| Curve {
        name,
        points: gathered(points),
    });
    let caption = match shown.varied.iter().any(|varied| varied.key == SEED) {
        true => "Means; a band reaches from the least to the largest of the repetitions.",
        false => "",
    };
    let content = Content::Curves(curves.collect());
    over(shown, quantity, key, caption.to_owned(), content)
}

/// x, the value there, and its run.
type Sample = (f64, f64, u64);

/// Merges points of equal x, in the order of x.
fn gathered(mut points: Vec<Sample>) -> Vec<Point> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut gathered: Vec<Point> = Vec::new();
    let mut count = 0.0;
    for (x, value, run) in points {
        match gathered.last_mut().filter(|last| last.x == x) {
            Some(last) => {
                count += 1.0;
                last.mean += (value - last.mean) / count;
                last.least = last.least.min(value);
                last.largest = last.largest.max(value);
            }
            None => {
                count = 1.0;
                gathered.push(Point {
                    x,
                    mean: value,
                    least: value,
                    largest: value,
                    run,
                });
            }
        }
    }
    gathered
}

fn heat(shown: &StudyInput, quantity: usize, a: usize, b: usize) -> Figure {
    let (xs, ys) = (distinct(shown, a), distinct(shown, b));
    let mut sums = vec![(0.0, 0.0, 0); xs.len() * ys.len()];
    for run in &shown.runs {
        let at =
            |values: &[f64], value: f64| values.binary_search_by(|known| known.total_cmp(&value));
        if let (Ok(i), Ok(j), Some(value)) = (
            at(&xs, run.values[a]),
            at(&ys, run.values[b]),
            run.figures[quantity],
        ) {
            let sum = &mut sums[i * ys.len() + j];
            let first = if sum.1 > 0.0 { sum.2 } else { run.run };
            *sum = (sum.0 + value, sum.1 + 1.0, first);
        }
    }
    let fields = sums.iter().enumerate().map(|(at, (sum, count, run))| {
        let mean = (*count > 0.0).then(|| (sum / count, *run));
        (xs[at / ys.len()], ys[at % ys.len()], mean)
    });
    let means = || {
        sums.iter()
            .filter(|sum| sum.1 > 0.0)
            .map(|(sum, count, _)| sum / count)
    };
    let caption = format!(
        "{} upward. Pale is {}, strong {}; empty fields failed.",
        shown.varied[b].key,
        figure(means().fold(f64::INFINITY, f64::min)),
        figure(means().fold(f64::NEG_INFINITY, f64::max))
    );
    Figure {
        title: format!("{} over both", shown.quantities[quantity].name),
        y: Some(scale(shown, b)),
        ..over(shown, quantity, a, caption, Content::Heat(fields.collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::input::{Quantity, Varied};
    use super::*;

    /// A study over keys with these numbers of values, with the quantity a + 10 b and so on of
    /// their indices.
    fn study(counts: &[usize], repetitions: usize) -> StudyInput {
        let varied = |index: usize| Varied {
            key: format!("k{index}"),
            words: Vec::new(),
            is_log: false,
        };
        let total: usize = counts.iter().product();
        let run = |number: usize| {
            let mut rest = number / repetitions;
            let mut values: Vec<f64> = Vec::new();
            for count in counts {
                values.push((rest % count) as f64);
                rest /= count;
            }
            let value: f64 = values
                .iter()
                .enumerate()
                .map(|(at, x)| x * 10_f64.powi(at as i32))
                .sum();
            Run {
                run: number as u64,
                scenario: 0,
                values,
                figures: vec![Some(value + (number % repetitions) as f64)],
                has_failed: false,
            }
        };
        StudyInput {
            varied: (0..counts.len()).map(varied).collect(),
            quantities: vec![Quantity {
                name: "q".to_owned(),
                bound: Some(3.0),
            }],
            runs: (0..total * repetitions).map(run).collect(),
            ..StudyInput::default()
        }
    }

    #[test]
    fn one_axis_makes_one_curve_with_the_spread_of_its_repetitions() {
        let figures = figures(&study(&[5], 3), 1);
        let [
            Figure {
                content: Content::Curves(curves),
                bound: Some(3.0),
                ..
            },
        ] = &figures[..]
        else {
            panic!("{figures:?}");
        };
        assert_eq!(curves.len(), 1);
        let expected = |x: f64| Point {
            x,
            mean: x + 1.0,
            least: x,
            largest: x + 2.0,
            run: 3 * x as u64,
        };
        assert_eq!(
            curves[0].points,
            (0..5).map(|x| expected(f64::from(x))).collect::<Vec<_>>()
        );
    }

    /// Values from 0 to 1 take a quarter of the span from 0 to a bound of 4; a bound of 4.1 would
    /// flatten them, and equal values have no spread to show.
    #[test]
    fn a_bound_that_would_flatten_what_is_drawn_is_told_and_not_drawn() {
        let values = [0.5, 0.0, 1.0];
        assert!([4.0, -1.0, 0.5, -3.0].map(|bound| is_in_sight(&values, bound)) == [true; 4]);
        assert!([4.1, -3.1].map(|bound| is_in_sight(&values, bound)) == [false; 2]);
        assert!(is_in_sight(&[2.0, 2.0], 1e6) && is_in_sight(&[], 1.0));
        // From 0 to 4.
        let mut shown = study(&[5], 1);
        let mut drawn = |bound| {
            shown.quantities[0].bound = Some(bound);
            let figure = figures(&shown, 1).remove(0);
            (figure.bound, figure.caption)
        };
        assert_eq!(drawn(16.0), (Some(16.0), String::new()));
        let told = |way: &str| (None, format!("Its bound, {way}."));
        assert_eq!(drawn(17.0), told("17, is far above"));
        assert_eq!(drawn(-13.0), told("-13, is far below"));
    }

    #[test]
    fn two_axes_make_curves_and_a_heat_map() {
        let figures = figures(&study(&[5, 3], 1), 1);
        assert_eq!(figures.len(), 2);
        let Content::Curves(curves) = &figures[0].content else {
            panic!()
        };
        assert_eq!((curves.len(), curves[1].name.as_str()), (3, "k1 = 1"));
        assert_eq!(curves[1].points[4].mean, 14.0);
        let Content::Heat(fields) = &figures[1].content else {
            panic!()
        };
        assert_eq!(fields.len(), 15);
        // Its run is the last of five times three.
        assert!(fields.contains(&(4.0, 2.0, Some((24.0, 14)))));
    }

    #[test]
    fn a_sample_is_a_cloud_that_is_thinned_and_says_so() {
        let mut shown = study(&[4000], 1);
        shown.is_sample = true;
        let figures = figures(&shown, 1);
        let Content::Cloud(points) = &figures[0].content else {
            panic!()
        };
        assert!(points.len() <= MOST_POINTS, "{}", points.len());
        assert_eq!(figures[0].caption, "One of 3 runs is shown.");
    }

    /// None, or the same to four digits.
    #[test]
    fn a_quantity_that_no_run_has_or_that_does_not_change_is_not_drawn() {
        let mut shown = study(&[5], 1);
        for figure in [None, Some(1.0)] {
            shown
                .runs
                .iter_mut()
                .for_each(|run| run.figures[0] = figure);
            shown.runs[0].figures[0] = figure.map(|x| x + 1e-6);
            assert!(figures(&shown, 1).is_empty());
        }
        shown.runs[0].figures[0] = Some(1.001);
        assert_eq!(figures(&shown, 1).len(), 1);
    }

    /// Two quantities of three runs, k0 = 0, 1, 2: one over the other, in the order of the key, and
    /// the ring where the key is 1. A second varied key makes no line.
    #[test]
    fn two_quantities_that_pull_apart_are_drawn_one_over_the_other() {
        let mut shown = study(&[3], 1);
        shown.quantities.push(Quantity {
            name: "p".to_owned(),
            bound: None,
        });
        let pairs = [(0.0, 4.0), (1.0, 2.0), (2.0, 1.0)];
        for (run, (q, p)) in shown.runs.iter_mut().zip(pairs) {
            run.figures = vec![Some(q), Some(p)];
        }
        assert!(trade(&shown).is_none());
        shown.trade = Some(([0, 1], 0, 1.0));
        let drawn = trade(&shown).expect("a figure");
        let Content::Curves(curves) = &drawn.content else {
            panic!("{drawn:?}")
        };
        let points: Vec<_> = curves[0]
            .points
            .iter()
            .map(|p| (p.x, p.mean, p.run))
            .collect();
        assert_eq!(points, [(0.0, 4.0, 0), (1.0, 2.0, 1), (2.0, 1.0, 2)]);
        assert!(drawn.caption.starts_with("Up: p. To the right: q."));
        assert_eq!(
            drawn.named,
            Some((["0", "1", "2"].map(str::to_owned).to_vec(), 1))
        );
        let shown = StudyInput {
            trade: shown.trade,
            ..study(&[3, 2], 1)
        };
        assert!(trade(&shown).is_none());
    }

    /// Nine runs or five are enough for a grid of three by three, four are not; a key with two
    /// values makes no grid.
    #[test]
    fn a_table_of_fields_is_drawn_where_at_least_half_of_it_was_run() {
        let mut shown = study(&[3, 3], 1);
        assert!(is_fields(&shown, 0, 1));
        // The two keys keep three values each with runs along one diagonal and next to it.
        let keep = |shown: &mut StudyInput, kept: &[usize]| {
            shown.runs.retain(|run| kept.contains(&(run.run as usize)));
        };
        keep(&mut shown, &[0, 1, 4, 5, 8]);
        assert!(is_fields(&shown, 0, 1));
        keep(&mut shown, &[0, 4, 5, 8]);
        assert!(!is_fields(&shown, 0, 1));
        assert!(!is_fields(&study(&[3, 2], 1), 0, 1));
    }
}
