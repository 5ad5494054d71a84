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
            .map(|j| WheelSample {
                rate_rad_s: f64::from(10 * step + j),
                ..WheelSample::default()
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
    };
    trace.push(Record::default(), &[sample]);
    trace.push(Record::default(), &[sample; 3]);
    let rates: Vec<_> = trace.wheel(1).map(|wheel| wheel.rate_rad_s).collect();
    assert_eq!(rates, [0.0, 1.0]);
}
