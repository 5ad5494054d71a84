//! Figures of the carrying roller of each wheel, and of the load transfer between rollers.

use ilon_trace::{Trace, WheelSample};

use crate::accumulate::{Accumulated, PITCH_BINS};
use crate::decimate::{MAX_POINTS, evenly};
use crate::figure::{
    Curve, Figure, Layout, Span, axis, curve, dots, exact_curve, layout, plot, solid, wheel_pen,
};
use crate::input::RunInput;

/// One panel per wheel: the carrying roller over time, with shared loads and lost contact.
pub(crate) fn touching(trace: &Trace) -> Vec<Figure> {
    const DOTS: usize = 400;
    (0..trace.wheel_count())
        .map(|index| {
            let wheel = &trace.header.wheels[index];
            let times = || trace.records().iter().map(|r| r.t_s);
            let samples = || times().zip(trace.wheel(index));
            let shared: Vec<_> = samples()
                .filter(|(_, s)| s.touching && s.load_share < 0.999)
                .map(|(t, s)| (t, f64::from(s.roller)))
                .collect();
            let shared = evenly(shared.len(), DOTS).into_iter().map(|k| shared[k]);
            let carrying = changes(samples());
            Figure::over_time(
                format!("roller-{index}"),
                wheel.name.clone(),
                "",
                vec![
                    exact_curve("carries", carrying.into_iter(), solid("@real")).steps(),
                    dots("shares", shared, "@slip", 6).opacity(1.0),
                ],
                axis("roller").range(-0.6, wheel.roller_count as f64 - 0.4),
            )
            .height_px(230)
            .spanning(Span::Panel)
        })
        .collect()
}

/// Returns the carrying roller where it changes, with gaps without contact, and the first and the
/// last instant.
fn changes<'t>(samples: impl Iterator<Item = (f64, &'t WheelSample)>) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut last = None;
    for (t_s, sample) in samples {
        let roller = sample.touching.then_some(sample.roller);
        let value = roller.map_or(f64::NAN, f64::from);
        match &mut last {
            Some((known, until_s)) if *known == roller => *until_s = t_s,
            _ => {
                points.push((t_s, value));
                last = Some((roller, t_s));
            }
        }
    }
    if let Some((roller, until_s)) = last {
        points.push((until_s, roller.map_or(f64::NAN, f64::from)));
    }
    let kept = evenly(points.len(), MAX_POINTS);
    kept.into_iter().map(|k| points[k]).collect()
}

/// Load share of the carrying roller over the wheel's angle, folded into one roller pitch.
pub(crate) fn hand_over(shown: &RunInput) -> Figure {
    let curves = each_wheel(shown, |all, index| all.load_in_pitch(index));
    Figure::new(
        "hand-over",
        "Load hand-over",
        "The mean share of the wheel's load that the carrying roller has, with the wheel's turn folded into one \
         roller pitch. At 1 it carries alone, as on a plane, where the load passes in a step. A dip is a \
         hand-over in which neighbours share, as on bumps and edges, and pull in different directions.",
        plot(
            curves,
            Layout::of(
                axis("turn within a roller pitch in deg"),
                axis("share of the load").from_zero(),
            ),
        ),
    )
}

/// Sliding speed over the wheel's angle, folded into one roller pitch.
pub(crate) fn slip_within_a_pitch(shown: &RunInput) -> Figure {
    let curves = each_wheel(shown, |all, index| all.slip_in_pitch(index).map(f64::sqrt));
    Figure::new(
        "slip-pitch",
        "Slip within a roller pitch",
        "Rms sliding speed with the wheel's turn folded into one roller pitch: a peak is the hand-over, a level \
         is sliding that has nothing to do with it.",
        plot(
            curves,
            layout("turn within a roller pitch in deg", "sliding speed in mm/s"),
        ),
    )
}

/// A curve per wheel, folded into one roller pitch, in degrees; empty bins are left out.
fn each_wheel(
    shown: &RunInput,
    folded: fn(&Accumulated, usize) -> [f64; PITCH_BINS],
) -> Vec<Curve> {
    let header = &shown.trace.header;
    let wheels = header.wheels.iter().enumerate().map(|(index, wheel)| {
        let pitch_deg = 360.0 / wheel.roller_count.max(1) as f64;
        let bins = folded(&shown.all, index).into_iter().enumerate();
        let points = bins
            .map(|(k, mean)| ((k as f64 + 0.5) * pitch_deg / PITCH_BINS as f64, mean))
            .filter(|(_, mean)| !mean.is_nan());
        curve(&wheel.name, points, wheel_pen(index))
    });
    wheels.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roller_is_told_where_it_changes_and_where_none_touches() {
        let sample = |roller: u32, touching: bool| {
            WheelSample {
                roller,
                touching,
                ..WheelSample::default()
            }
            .steady()
        };
        let samples = [
            sample(3, true),
            sample(3, true),
            sample(4, true),
            sample(4, false),
            sample(4, true),
        ];
        let times = [0.0, 0.1, 0.2, 0.3, 0.4];
        let points = changes(times.into_iter().zip(&samples));
        assert_eq!(points.len(), 5);
        assert_eq!(points[..2], [(0.0, 3.0), (0.2, 4.0)]);
        assert!(points[2].1.is_nan());
        assert_eq!(points[3..], [(0.4, 4.0), (0.4, 4.0)]);
    }
}
