//! What cannot be simulated.

use ilon_robot::{Robot, RollerForm, Wheel};

use crate::engine::shapes::shape_of_roller;
use crate::{Floor, Settings, WorldError};

/// Refuses what cannot be simulated.
pub(super) fn check(robot: &Robot, floor: &Floor, settings: &Settings) -> Result<(), WorldError> {
    let positive = [
        ("dt_s", settings.dt_s),
        ("contact_stiffness_n_m", settings.contact_stiffness_n_m),
        ("prediction_m", settings.prediction_m),
    ];
    for (name, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return Err(WorldError::Setting {
                name,
                value,
                range: "finite and above 0",
            });
        }
    }
    if let Some(split_dt_s) = settings.split_dt_s
        && !(split_dt_s.is_finite() && split_dt_s > 0.0)
    {
        return Err(WorldError::Setting {
            name: "split_dt_s",
            value: split_dt_s,
            range: "finite and above 0",
        });
    }
    let not_negative = [
        ("gravity_m_s2", settings.gravity_m_s2),
        ("contact_relaxation_s", settings.contact_relaxation_s),
    ];
    for (name, value) in not_negative {
        if !(value.is_finite() && value >= 0.0) {
            return Err(WorldError::Setting {
                name,
                value,
                range: "finite and not below 0",
            });
        }
    }
    floor.check()?;
    if robot.wheels.is_empty() {
        return Err(WorldError::NoWheels);
    }
    robot.wheels.iter().try_for_each(check_wheel)
}

fn check_wheel(wheel: &Wheel) -> Result<(), WorldError> {
    if wheel.rollers.is_empty() {
        return Err(WorldError::NoRollers {
            wheel: wheel.name.clone(),
        });
    }
    for roller in &wheel.rollers {
        if let RollerForm::AsModelled(modelled) = &roller.form {
            if shape_of_roller(modelled).is_none() {
                return Err(WorldError::FlatRoller {
                    wheel: wheel.name.clone(),
                    roller: roller.name.clone(),
                });
            }
            continue;
        }
        let barrel = wheel.barrel(roller);
        let end_radius_m = barrel.sphere_radius_m(barrel.half_length_m);
        if end_radius_m <= 0.0 {
            return Err(WorldError::RollerEndsVanish {
                wheel: wheel.name.clone(),
                missing_mm: -1e3 * end_radius_m,
            });
        }
    }
    Ok(())
}
