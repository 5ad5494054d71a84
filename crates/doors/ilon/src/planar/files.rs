//! Output files of a planar base.

use std::fmt::Write;

use serde_json::Value;

use super::Planar;
use super::drives::PlanarDrive;
use crate::Error;

/// The files of a planar base, by name: `planar.json` with all values, `planar.py` for numpy, and
/// `held_out.csv` with the drives that the fit was judged by.
///
/// # Errors
/// [`Error::Invalid`] if a value is not finite, as for a robot that did not move.
pub fn files(
    planar: &Planar,
    judges: &[PlanarDrive],
    dt_s: f64,
) -> Result<Vec<(&'static str, String)>, Error> {
    let is_whole = serde_json::to_value(planar).is_ok_and(|value| is_whole(&value));
    let json = serde_json::to_string_pretty(planar).ok();
    let json = json.filter(|_| is_whole).ok_or_else(|| {
        Error::invalid(
            format!(
                "no planar base fits `{}`: a number of it is none",
                planar.robot
            ),
            "look at how the robot drives with `ilon run`",
        )
    })?;
    Ok(vec![
        ("planar.json", json + "\n"),
        ("planar.py", include_str!("planar.py").to_owned()),
        ("held_out.csv", csv(judges, dt_s)),
    ])
}

/// Whether all numbers are finite: JSON has null for others.
fn is_whole(value: &Value) -> bool {
    match value {
        Value::Null => false,
        Value::Array(values) => values.iter().all(is_whole),
        Value::Object(values) => values.values().all(is_whole),
        _ => true,
    }
}

/// Drives as a table: drive number, time, commanded twist, reached twist.
fn csv(drives: &[PlanarDrive], dt_s: f64) -> String {
    let mut text =
        "drive,t_s,asked_vx_m_s,asked_vy_m_s,asked_omega_rad_s,vx_m_s,vy_m_s,omega_rad_s\n"
            .to_owned();
    for (number, drive) in drives.iter().enumerate() {
        for (step, (asked, came)) in drive.asked.iter().zip(&drive.came).enumerate() {
            let _ = write!(text, "{number},{:.6}", (step + 1) as f64 * dt_s);
            for value in asked.iter().chain(came) {
                let _ = write!(text, ",{value:.7}");
            }
            text.push('\n');
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::is_whole;

    /// Nulls are found at any depth; text is ignored.
    #[test]
    fn numbers_that_are_none_are_found_and_names_are_not_looked_at() {
        assert!(is_whole(
            &json!({ "robot": "nullbot: null", "grip": { "most": [1.0, 2.0] } })
        ));
        let infinite = json!({ "robot": "bot", "grip": { "most": [1.0, f64::INFINITY] } });
        assert!(!is_whole(&infinite));
    }
}
