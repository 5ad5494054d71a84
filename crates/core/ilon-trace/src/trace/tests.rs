use super::*;
use crate::header::WheelHeader;

#[test]
fn wheels_lie_flat_and_are_found_again_by_step_and_by_wheel() {
    let header = Header {
        wheels: vec![WheelHeader::default(); 3],
        control_dt_s: 0.01,
        ..Header::default()
    };
    let mut trace = Trace::with_capacity(header, 5);
    for step in 0..5 {
        let wheels: Vec<_> = (0..3)
            .map(|j| {
                WheelSample {
                    rate_rad_s: f64::from(10 * step + j),
                    ..WheelSample::default()
                }
                .steady()
            })
            .collect();
        trace.push(Record::default(), &wheels);
    }
    assert_eq!(trace.wheels_at(2)[1].rate_rad_s, 21.0);
    let rates: Vec<_> = trace.wheel(2).map(|w| w.rate_rad_s).collect();
    assert_eq!(rates, [2.0, 12.0, 22.0, 32.0, 42.0]);
    assert!(trace.wheels_at(5).is_empty());
    assert_eq!(trace.wheel(3).len(), 0);
}

#[test]
fn rows_and_wheels_that_there_are_not_are_empty() {
    let header = Header {
        wheels: vec![WheelHeader::default(); 2],
        ..Header::default()
    };
    let mut trace = Trace::with_capacity(header, 0);
    // No row yet: the second wheel would begin beyond the end.
    assert_eq!(trace.wheel(1).len(), 0);
    assert!(trace.wheels_at(usize::MAX).is_empty());
    // Missing samples are zero, surplus ones dropped.
    let sample = WheelSample {
        rate_rad_s: 1.0,
        ..WheelSample::default()
    }
    .steady();
    trace.push(Record::default(), &[sample]);
    trace.push(Record::default(), &[sample; 3]);
    let rates: Vec<_> = trace.wheel(1).map(|wheel| wheel.rate_rad_s).collect();
    assert_eq!(rates, [0.0, 1.0]);
}

/// Two wheels of two rollers each: four angles per row, none from another row, and none beyond the
/// end.
#[test]
fn roller_angles_of_a_row_are_those_of_that_row_alone() {
    let wheel = WheelHeader {
        roller_count: 2,
        ..WheelHeader::default()
    };
    let header = Header {
        wheels: vec![wheel.clone(), wheel],
        roller_angles: true,
        ..Header::default()
    };
    let mut trace = Trace::with_capacity(header, 3);
    for row in 0..3 {
        trace.push(Record::default(), &[WheelSample::default(); 2]);
        if row != 1 {
            trace.push_roller_angles((0..4).map(|k| f64::from(10 * row + k)));
        }
    }
    let some = |angles: [f64; 4]| angles.map(Some);
    assert_eq!(trace.roller_angles_at(0), some([0.0, 1.0, 2.0, 3.0]));
    assert_eq!(trace.roller_angles_at(1), [None; 4]);
    assert_eq!(trace.roller_angles_at(2), some([20.0, 21.0, 22.0, 23.0]));
    assert!(trace.roller_angles_at(3).is_empty());
}
