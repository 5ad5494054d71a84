//! Numbers with their units, as a person reads them.

use ilon_trace::quantities;

/// A length for reading: metres, or millimetres below one.
pub(super) fn length(x_m: f64) -> String {
    let size_m = x_m.abs();
    if !x_m.is_finite() {
        "not finite".to_owned()
    } else if size_m >= 1.0 {
        format!("{x_m:.3} m")
    } else if size_m >= 0.1 {
        format!("{:.1} mm", 1e3 * x_m)
    } else if size_m >= 1e-3 {
        format!("{:.2} mm", 1e3 * x_m)
    } else if size_m >= 1e-6 {
        format!("{:.3} mm", 1e3 * x_m)
    } else {
        "0 mm".to_owned()
    }
}

/// An angle for reading, in degrees.
pub(super) fn angle(x_rad: f64) -> String {
    let x_deg = x_rad.to_degrees();
    if x_deg.abs() >= 1.0 {
        format!("{x_deg:.2}°")
    } else {
        format!("{x_deg:.3}°")
    }
}

/// A time for reading.
pub(super) fn time(x_s: f64) -> String {
    format!("{x_s:.2} s")
}

/// A part of a whole for reading.
pub(super) fn percent(x: f64) -> String {
    let x_pct = 100.0 * x;
    if x_pct.abs() >= 0.05 || x_pct == 0.0 {
        format!("{x_pct:.1} %")
    } else {
        "less than 0.05 %".to_owned()
    }
}

/// A force for reading.
pub(super) fn force(x_n: f64) -> String {
    match x_n.abs() {
        size_n if size_n >= 1000.0 => format!("{x_n:.0} N"),
        size_n if size_n >= 0.1 => format!("{x_n:.1} N"),
        _ => format!("{x_n:.3} N"),
    }
}

/// A speed for reading.
pub(super) fn speed(x_m_s: f64) -> String {
    // What is shown as zero has no sign.
    let x_m_s = if x_m_s.abs() < 5e-6 { 0.0 } else { x_m_s };
    if x_m_s.abs() >= 1.0 {
        format!("{x_m_s:.3} m/s")
    } else if x_m_s.abs() >= 0.1 {
        format!("{:.0} mm/s", 1e3 * x_m_s)
    } else {
        format!("{:.2} mm/s", 1e3 * x_m_s)
    }
}

/// An energy for reading.
pub(super) fn energy(x_j: f64) -> String {
    if x_j.abs() >= 0.1 {
        format!("{x_j:.2} J")
    } else {
        format!("{x_j:.3} J")
    }
}

/// The words for a part of the energy balance, or for any other quantity, by its key.
pub(super) fn label(key: &str) -> &'static str {
    quantities::by_key(key).map_or("", |quantity| quantity.label)
}
