//! How far the figures of a run move at half its step.
//!
//! A *twin* is the same run, with the same seeds, with one thing changed. Only its figures are
//! kept, in the header of the trace, so that they can be reported without physics.

use std::collections::BTreeMap;

use ilon_robot::wrap_angle;

use crate::header::Header;
use crate::metrics::Summary;
use crate::quantities::{self, Quantity, Scales};
pub use crate::twin::{Apart, Cause, Change, Convergence, Moved, Twin};

impl Twin {
    /// A twin with these figures, or the reason why it could not be run.
    pub fn new(change: Change, came: Result<(Summary, Option<Apart>), String>) -> Self {
        let figures = |summary: &Summary| {
            let value = |figure: &Quantity| Some((figure.key.to_owned(), figure.value(summary)?));
            quantities::compared().filter_map(value).collect()
        };
        match came {
            Ok((summary, apart)) => Self {
                change,
                figures: figures(&summary),
                apart,
                poses: Vec::new(),
                error: None,
            },
            Err(error) => Self {
                change,
                figures: BTreeMap::new(),
                apart: None,
                poses: Vec::new(),
                error: Some(error),
            },
        }
    }
}

impl Convergence {
    /// The convergence of a run whose header has its twins.
    pub(crate) fn of(summary: &Summary, header: &Header) -> Self {
        let is_half = |change: &Change| matches!(change, Change::HalfStep | Change::HalfSplit);
        let mut halves = header.twins.iter().filter(|twin| is_half(&twin.change));
        if halves.all(|twin| twin.figures.is_empty()) {
            return Self::default();
        }
        let scales = Scales::of(summary, header);
        let at = |change: Change, key: &str| {
            let twin = header.twins.iter().find(|twin| twin.change == change)?;
            twin.figures.get(key).copied()
        };
        let moved = |(quantity, accuracy): (&Quantity, quantities::Accuracy)| {
            let key = quantity.key;
            let value = quantity.value(summary);
            let half_step = at(Change::HalfStep, key);
            let half_split = at(Change::HalfSplit, key);
            let known = value.or(half_step).or(half_split)?;
            let off = |other: f64| difference(key, other, value.unwrap_or(0.0)).abs();
            let moved = half_step.map_or(0.0, off).max(half_split.map_or(0.0, off));
            let floor = scales.floor(quantity);
            let measure = scales.measure(accuracy.of, known).max(floor);
            let share = if moved > floor { moved / measure } else { 0.0 };
            Some((
                key.to_owned(),
                Moved {
                    value,
                    half_step,
                    half_split,
                    moved,
                    share,
                    exceeds: share > accuracy.share,
                },
            ))
        };
        let stated = quantities::stated();
        let stated =
            stated.filter(|(quantity, _)| quantities::says_something(quantity.key, summary));
        Self(stated.filter_map(moved).collect())
    }

    /// The figures that moved by more than their stated accuracy, in the order of
    /// [`quantities::all`].
    pub fn beyond(&self) -> impl Iterator<Item = (&'static Quantity, &Moved)> {
        let found =
            quantities::all().filter_map(|quantity| Some((quantity, self.get(quantity.key)?)));
        found.filter(|(_, moved)| moved.exceeds)
    }

    /// The largest relative change of a position, a heading or a path length.
    pub fn of_the_way(&self) -> f64 {
        let of_way = |key: &str| {
            quantities::accuracy(key)
                .is_some_and(|accuracy| accuracy.of != quantities::Measure::Itself)
        };
        let shares = self.0.iter().filter(|(key, _)| of_way(key));
        shares.map(|(_, moved)| moved.share).fold(0.0, f64::max)
    }

    /// The result at half the step, as a sentence.
    pub fn sentence(&self) -> String {
        let count = self.beyond().count();
        let way = 100.0 * self.of_the_way();
        match count {
            0 => format!(
                "All figures stay within their stated accuracy at half the step: places and headings move by at most {way:.3} % of the way."
            ),
            1 => format!(
                "One figure moves by more than its stated accuracy at half the step; places and headings by at most {way:.3} % of the way."
            ),
            _ => format!(
                "{count} figures move by more than their stated accuracy at half the step; places and headings by at most {way:.3} % of the way."
            ),
        }
    }
}

/// The difference of two values of a figure; of final headings, the difference within half a turn.
pub(crate) fn difference(key: &str, value: f64, from: f64) -> f64 {
    match key {
        "end_heading_rad" => wrap_angle(value - from),
        _ => value - from,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Settings;
    use crate::sample::made_up_trace;

    /// A run of a robot whose farthest wheel is at 0.4 m, with a twin at half the step that has the
    /// same figures except those in `changed`.
    fn converged(changed: &[(&str, f64)]) -> Summary {
        let mut trace = made_up_trace(1, 40, true);
        trace.header.wheels[0].position_m = [0.0, 0.4];
        let alone = Summary::of(&trace, &Settings::default());
        assert!(alone.converge.is_empty());
        let mut twin = Twin::new(Change::HalfStep, Ok((alone, None)));
        for (key, by) in changed {
            *twin.figures.get_mut(*key).expect("a stated figure") += by;
        }
        trace.header.twins = vec![twin];
        Summary::of(&trace, &Settings::default())
    }

    #[test]
    fn a_twin_that_came_to_the_same_moves_nothing() {
        let summary = converged(&[]);
        assert!(summary.converge.beyond().next().is_none());
        assert!(summary.converge.sentence().starts_with("All figures stay"));
        let place = summary.converge.get("end_x_m").expect("it applies");
        assert_eq!((place.value, place.moved), (summary.end_x_m, 0.0));
        assert_eq!((place.half_step, place.half_split), (summary.end_x_m, None));
    }

    /// A position is accurate to a thousandth of the way, and differences below 1e-4 of 0.4 m do
    /// not count.
    #[test]
    fn places_are_measured_against_the_way_and_rounding_is_left_out() {
        let way_m = {
            let summary = converged(&[]);
            summary.travelled_m.max(0.4 * summary.turned_rad)
        };
        assert!(
            1e-3 * way_m > 4e-5,
            "the floor would hide the accuracy: {way_m} m"
        );
        for (by_m, share, exceeds) in [
            (3.9e-5, 0.0, false),
            (0.9e-3 * way_m, 0.9e-3, false),
            (-1.1e-3 * way_m, 1.1e-3, true),
        ] {
            let summary = converged(&[("end_y_m", by_m)]);
            let place = summary.converge.get("end_y_m").expect("it applies");
            // Rounding of one sum.
            assert!((place.moved - by_m.abs()).abs() < 1e-12);
            assert!((place.share - share).abs() < 1e-9, "{place:?}");
            assert_eq!(place.exceeds, exceeds);
            assert_eq!(summary.converge.beyond().count(), usize::from(exceeds));
        }
    }

    #[test]
    fn headings_at_the_end_differ_by_less_than_half_a_turn() {
        let summary = converged(&[("end_heading_rad", std::f64::consts::TAU)]);
        let heading = summary.converge.get("end_heading_rad").expect("it applies");
        assert!(heading.moved < 1e-12, "{heading:?}");
    }

    #[test]
    fn a_twin_that_could_not_be_run_moves_nothing_and_says_why() {
        let mut trace = made_up_trace(1, 4, true);
        let twin = Twin::new(Change::HalfStep, Err("it diverged".to_owned()));
        assert_eq!(twin.error.as_deref(), Some("it diverged"));
        trace.header.twins = vec![twin];
        let summary = Summary::of(&trace, &Settings::default());
        assert!(summary.converge.is_empty());
    }
}
