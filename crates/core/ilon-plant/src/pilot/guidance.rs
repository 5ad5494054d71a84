//! Builds the guidance law of a scenario.

use ilon_control::{Gain, Guidance, GuidanceSettings, Kinematics, Saturation};
use nalgebra::Matrix2;

use ilon_scenario::{Error, scenario};

/// The guidance of a `[guidance]` section: gains, saturation, tasks and limits; for the reference
/// point of the kinematics.
///
/// # Errors
/// If a gain, a limit or a task is invalid.
pub fn guidance(section: &scenario::Guidance, kinematics: Kinematics) -> Result<Guidance, Error> {
    let settings = GuidanceSettings {
        position_gain: match section.position_gain_matrix_per_s {
            Some([[xx, xy], [yx, yy]]) => Gain::Matrix(Matrix2::new(xx, xy, yx, yy)),
            None => Gain::Scalar(section.position_gain_per_s),
        },
        heading_gain: section.heading_gain_per_s,
        wheel_rate_limit_rad_s: section.wheel_rate_limit_rad_s.unwrap_or(f64::INFINITY),
        saturation: match section.saturation {
            scenario::Saturation::Prioritised => {
                Saturation::Prioritised(section.priority.unwrap_or_default())
            }
            scenario::Saturation::Clip => Saturation::Clip,
            scenario::Saturation::Scale => Saturation::Scale,
            scenario::Saturation::None => Saturation::None,
        },
    };
    let mut guidance = Guidance::new(kinematics, &settings)?;
    if !section.wheel_rate_limits_rad_s.is_empty() {
        guidance = guidance.with_wheel_limits(&section.wheel_rate_limits_rad_s)?;
    }
    if !section.tasks.is_empty() {
        guidance = guidance.with_tasks(&section.tasks)?;
    }
    Ok(match section.capacity_rad_s {
        Some(capacity_rad_s) => guidance.with_capacity(capacity_rad_s)?,
        None => guidance,
    })
}
