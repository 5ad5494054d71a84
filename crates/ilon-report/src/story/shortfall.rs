//! What of the motion that the wheels of an open-loop run asked for is missing, in words.

use ilon_trace::{Header, Summary};

use crate::words::{percent, time};

/// Wheels that turn the robot by less, in m/s or rad/s, stand: a robot that moves all the same was carried.
const STANDING: f64 = 1e-3;

/// What of the ideal motion is missing, and why, for each driven component of an open-loop run.
pub(super) fn sentences(header: &Header, summary: &Summary) -> Vec<String> {
    if !header.open_loop {
        return Vec::new();
    }
    let (Some(real), Some(ideal), Some(contact)) = (
        summary.twist_mean,
        summary.twist_ideal_mean,
        summary.twist_contact_mean,
    ) else {
        let from = time(header.measure_from_s);
        return vec![format!(
            "The run is too short for mean velocities: they are taken from {from} on, after rest and ramp."
        )];
    };
    let ratios = summary.twist_ratio_ideal;
    let metres: fn(f64) -> String = |v| format!("{:.4} m/s", v.abs());
    let degrees: fn(f64) -> String = |w| format!("{:.2}°/s", w.to_degrees().abs());
    let side = |v: f64, plus: &'static str, minus: &'static str| if v < 0.0 { minus } else { plus };
    let components = [
        (
            ratios.vx,
            real.vx_m_s,
            ideal.vx_m_s,
            contact.vx_m_s,
            metres,
            side(ideal.vx_m_s, "Ahead", "Backwards"),
        ),
        (
            ratios.vy,
            real.vy_m_s,
            ideal.vy_m_s,
            contact.vy_m_s,
            metres,
            side(ideal.vy_m_s, "To the left", "To the right"),
        ),
        (
            ratios.omega,
            real.omega_rad_s,
            ideal.omega_rad_s,
            contact.omega_rad_s,
            degrees,
            side(ideal.omega_rad_s, "Turning left", "Turning right"),
        ),
    ];
    components
        .into_iter()
        .filter_map(|(ratio, real, ideal, contact, unit, direction)| {
            let ratio = ratio.filter(|_| ideal.abs() > STANDING)?;
            let geometry = (ideal - contact) / ideal;
            let slip = (contact - real) / ideal;
            let way = if real * ideal < 0.0 { " the other way" } else { "" };
            Some(format!(
                "<b>{direction}</b> the wheels turned for {} and the robot did {}{way}: <b>{}</b> of the ideal kinematics. \
                 The rollers' geometry {}, slip {}.",
                unit(ideal),
                unit(real),
                percent(ratio),
                takes(geometry),
                takes(slip)
            ))
        })
        .collect()
}

/// What a cause takes of the ideal motion, as a verb: a floor that slopes or a push can make slip add to it.
fn takes(share: f64) -> String {
    let text = percent(share.abs());
    let is_shown = !text.starts_with("less");
    let verb = if share < 0.0 && is_shown {
        "adds"
    } else {
        "takes"
    };
    format!("{verb} {text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slip_that_carries_the_robot_on_adds_to_its_motion() {
        assert_eq!(takes(0.0204), "takes 2.0 %");
        assert_eq!(takes(-0.52), "adds 52.0 %");
        // Too little to be shown has no direction.
        assert_eq!(takes(-1e-5), "takes less than 0.05 %");
    }
}
