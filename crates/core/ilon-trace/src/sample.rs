//! Traces for tests whose every signal differs from every other.

use std::collections::BTreeMap;

use crate::columns::{ColumnType, signals};
use crate::header::{
    Ground, GroundBox, GroundPatch, GroundRamp, GroundRelief, Header, WheelHeader,
};
use crate::record::{Record, WheelSample};
use crate::trace::{RowMut, Trace};

/// A trace in which every signal has a different value at every step, so that rounding, order and
/// mix-ups are detected.
pub(crate) fn made_up_trace(wheel_count: usize, steps: usize, closed_loop: bool) -> Trace {
    let header = Header {
        scenario_name: "made up".to_owned(),
        scenario_toml: "[run]\nduration_s = 0.1\n".to_owned(),
        robot_name: "test robot".to_owned(),
        wheels: (0..wheel_count)
            .map(|k| WheelHeader {
                name: format!("wheel {k}"),
                position_m: [0.1 * k as f64, 1.0 / 3.0],
                radius_m: 0.05,
                axis: [0.6, 0.8],
                rate_limit_rad_s: (k > 0).then_some(8.7),
                ..WheelHeader::default()
            })
            .collect(),
        task_names: if closed_loop {
            vec!["position".to_owned(), "heading".to_owned()]
        } else {
            Vec::new()
        },
        physics_dt_s: 0.001,
        control_dt_s: 0.01,
        measure_from_s: 0.1 + 0.2,
        measure_to_s: 1e3,
        open_loop: !closed_loop,
        versions: BTreeMap::from([("ilon".to_owned(), "0".to_owned())]),
        roller_angles: closed_loop,
        measured: closed_loop,
        imu: closed_loop,
        storage: closed_loop,
        urdf: "<robot name=\"ä &amp; b\"/>".to_owned(),
        ground: closed_loop.then(|| Ground {
            friction: 0.1 + 0.2,
            slope_rad: 1.0 / 3.0,
            patches: vec![GroundPatch {
                until_s: Some(1.0 / 7.0),
                ..GroundPatch::default()
            }],
            boxes: vec![GroundBox::default()],
            ramps: vec![GroundRamp::default()],
            relief: Some(GroundRelief {
                seed: u64::MAX,
                ..GroundRelief::default()
            }),
        }),
        ..Header::default()
    };
    let signals = signals(&header);
    let header_rollers = header.rollers_recorded();
    let mut trace = Trace::with_capacity(header, steps);
    for step in 0..steps {
        let mut record = Record::default();
        let mut wheels = vec![WheelSample::default(); wheel_count];
        let mut rollers = vec![None; header_rollers];
        for (index, signal) in signals.iter().enumerate() {
            let value = match signal.kind {
                ColumnType::Real => (1.0 + index as f64) / 7.0 - step as f64 * 0.1,
                ColumnType::Count => (index + step) as f64,
                ColumnType::Flag => f64::from(u8::from((index + step) % 3 == 0)),
            };
            let is_roller = signal.name.contains("_roller") && signal.name.ends_with("_angle_rad");
            // Rollers are sampled less often than the rest.
            let present = !signal.nullable || closed_loop && (!is_roller || step % 2 == 0);
            let mut row = RowMut {
                record: &mut record,
                wheels: &mut wheels,
                rollers: &mut rollers,
            };
            signal.set(&mut row, present.then_some(value));
        }
        record.t_s = step as f64 * 0.01;
        trace.push(record, &wheels);
        trace.put_roller_angles(rollers);
    }
    trace
}
