//! Indiveri 2009 across crates: the shipped robots read from their files, and the dynamic model
//! (11) compared with a simulated robot. Tests of the control crate alone are in
//! `crates/core/ilon-control/tests/paper`.

mod computed_torque;
mod dynamics;
mod low_level;
mod reference_point;
mod robots;
mod section_iv;

/// Distances of the reference point from the desired position, in metres, Indiveri 2009, eq. (16),
/// row by row.
fn position_errors_m(trace: &ilon_trace::Trace) -> Vec<f64> {
    let error = |record| trace.header.tracking_error(record);
    trace
        .records()
        .iter()
        .filter_map(error)
        .map(|(position_m, _)| position_m)
        .collect()
}
