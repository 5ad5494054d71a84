//! Which roller carries a wheel, and how the load goes from one to the next.

use std::f64::consts::TAU;

use ilon_trace::{Trace, WheelSample};
use plotly::common::{Line, LineShape};
use plotly::layout::{Layout, RangeMode};

use crate::report::figure::{
    Figure, Span, axis, curve, dots, exact_curve, layout, plot, solid, wheel_pen,
};
use crate::report::thin::{MAX_POINTS, evenly};

/// One panel a wheel: the roller that carries it over time, where it shares the load, and where none touches.
pub(in crate::report) fn touching(trace: &Trace) -> Vec<Figure> {
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
            let line: Line = solid("@real").line().shape(LineShape::Hv);
            Figure {
                id: format!("roller-{index}"),
                title: wheel.name.clone(),
                caption: String::new(),
                height_px: 230,
                span: Span::Panel,
                over_time: true,
                plot: plot(
                    vec![
                        exact_curve("carries", carrying.into_iter(), solid("@real")).line(line),
                        dots("shares", shared, "@slip", 6).opacity(1.0),
                    ],
                    Layout::new()
                        .x_axis(axis("t in s"))
                        .y_axis(axis("roller").range(vec![-0.6, wheel.roller_count as f64 - 0.4])),
                ),
            }
        })
        .collect()
}

/// The carrying roller where it changes, with a gap where none touches; the first and the last instant as well.
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

/// How the carrying roller shares the load, over the wheel's turn folded into one roller pitch.
pub(in crate::report) fn hand_over(trace: &Trace) -> Figure {
    let curves = (0..trace.wheel_count()).map(|index| {
        let points = folded(trace, index, |s| Some(s.load_share));
        curve(
            &trace.header.wheels[index].name,
            points.into_iter(),
            wheel_pen(index),
        ) as Box<dyn plotly::Trace>
    });
    Figure {
        id: "hand-over".to_owned(),
        title: "Load hand-over".to_owned(),
        caption: "The mean share of the wheel's load that the carrying roller has, with the wheel's turn folded into one \
                  roller pitch. At 1 it carries alone. The dip is the hand-over: its width is how long neighbours share, \
                  and in it they pull in different directions."
            .to_owned(),
        height_px: 320,
        span: Span::Half,
        over_time: false,
        plot: plot(
            curves.collect(),
            Layout::new()
                .x_axis(axis("turn within a roller pitch in deg"))
                .y_axis(axis("share of the load").range_mode(RangeMode::ToZero)),
        ),
    }
}

/// Sliding speed over the wheel's turn folded into one roller pitch.
pub(in crate::report) fn slip_within_a_pitch(trace: &Trace) -> Figure {
    let curves = (0..trace.wheel_count()).map(|index| {
        let squares = folded(trace, index, |s| {
            s.touching.then(|| (1e3 * s.slip_speed_m_s()).powi(2))
        });
        let points = squares
            .into_iter()
            .map(|(turn, square)| (turn, square.sqrt()));
        curve(&trace.header.wheels[index].name, points, wheel_pen(index)) as Box<dyn plotly::Trace>
    });
    Figure {
        id: "slip-pitch".to_owned(),
        title: "Slip within a roller pitch".to_owned(),
        caption: "Rms sliding speed with the wheel's turn folded into one roller pitch: a peak is the hand-over, a level \
                  is sliding that has nothing to do with it."
            .to_owned(),
        height_px: 320,
        span: Span::Half,
        over_time: false,
        plot: plot(
            curves.collect(),
            layout("turn within a roller pitch in deg", "sliding speed in mm/s"),
        ),
    }
}

/// Mean of a quantity of a wheel's touching samples over the turn within a roller pitch, in degrees; bins without any
/// sample are left out.
fn folded(
    trace: &Trace,
    index: usize,
    of: impl Fn(&WheelSample) -> Option<f64>,
) -> Vec<(f64, f64)> {
    const BINS: usize = 40;
    let rollers = trace.header.wheels[index].roller_count.max(1) as f64;
    let mut sums = [(0.0, 0_u32); BINS];
    for sample in trace.wheel(index).filter(|s| s.touching) {
        let Some(value) = of(sample) else { continue };
        let turn = (sample.angle_rad * rollers / TAU).rem_euclid(1.0);
        // A turn of 1 - 1e-17 rounds to 1.
        let bin = &mut sums[((turn * BINS as f64) as usize).min(BINS - 1)];
        *bin = (bin.0 + value, bin.1 + 1);
    }
    let pitch_deg = 360.0 / rollers;
    let bins = sums.into_iter().enumerate().filter(|(_, (_, n))| *n > 0);
    bins.map(|(k, (sum, n))| {
        (
            (k as f64 + 0.5) * pitch_deg / BINS as f64,
            sum / f64::from(n),
        )
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_trace::{Header, Record, WheelHeader};

    #[test]
    fn a_roller_is_told_where_it_changes_and_where_none_touches() {
        let sample = |roller: u32, touching: bool| WheelSample {
            roller,
            touching,
            ..WheelSample::default()
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

    #[test]
    fn folding_lays_all_pitches_of_a_turn_over_each_other() {
        let header = Header {
            wheels: vec![WheelHeader {
                roller_count: 4,
                ..WheelHeader::default()
            }],
            ..Header::default()
        };
        let mut trace = Trace::with_capacity(header, 4);
        // 6 deg into the first, second and third pitch of 90 deg, and backwards 6 deg into the last; one in the air.
        for (angle_deg, load_share, touching) in [
            (6.0, 0.5, true),
            (96.0, 0.7, true),
            (186.0, 0.9, true),
            (-84.0, 0.5, true),
            (6.0, 0.0, false),
        ] {
            let sample = WheelSample {
                angle_rad: f64::to_radians(angle_deg),
                load_share,
                touching,
                ..WheelSample::default()
            };
            trace.push(Record::default(), &[sample]);
        }
        let shares = folded(&trace, 0, |s| Some(s.load_share));
        // Bins of 2.25 deg: 6 deg lies in the third, whose middle is at 5.625 deg.
        assert_eq!(shares.len(), 1);
        assert_eq!(shares[0].0, 5.625);
        // Four numbers below 1: rounding below 1e-15.
        assert!((shares[0].1 - 0.65).abs() < 1e-15);
    }
}
