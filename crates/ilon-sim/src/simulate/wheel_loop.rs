//! The wheel loops of a scenario: the gains that it gives or leaves to the program.

use ilon_control::{DynamicModel, LoopTiming, WheelGains, WheelLoop, WheelLoopSettings};
use ilon_robot::Robot;

use crate::Error;
use crate::scenario::{self, WheelLaw};

/// Writes the gains that a `[wheel_loop]` section leaves out, and the program chooses, into it.
pub(super) fn choose_gains(
    section: &mut scenario::WheelLoop,
    model: &DynamicModel,
    physics_dt_s: f64,
) -> Result<(), Error> {
    if section.law == WheelLaw::Pid {
        let gains = gains(section, model, physics_dt_s)?;
        section.proportional_n_m_s = Some(gains.proportional_n_m_s);
        section.integral_n_m = Some(gains.integral_n_m);
    }
    Ok(())
}

fn gains(
    section: &scenario::WheelLoop,
    model: &DynamicModel,
    physics_dt_s: f64,
) -> Result<WheelGains, Error> {
    let bandwidth_rad_s = section.bandwidth_rad_s;
    let proposed = WheelGains::for_robot(model, timing(section), physics_dt_s, bandwidth_rad_s)?;
    Ok(WheelGains {
        proportional_n_m_s: section
            .proportional_n_m_s
            .unwrap_or(proposed.proportional_n_m_s),
        integral_n_m: section.integral_n_m.unwrap_or(proposed.integral_n_m),
        derivative_n_m_s2: section.derivative_n_m_s2,
    })
}

fn timing(section: &scenario::WheelLoop) -> LoopTiming {
    match section.timing {
        scenario::LoopTiming::Sampled => LoopTiming::Sampled,
        scenario::LoopTiming::Continuous => LoopTiming::Continuous,
    }
}

/// The wheel loops of a `[wheel_loop]` section.
pub(super) fn pid(
    section: &scenario::WheelLoop,
    model: &DynamicModel,
    physics_dt_s: f64,
) -> Result<WheelLoop, Error> {
    let gains = gains(section, model, physics_dt_s)?;
    let settings = WheelLoopSettings {
        timing: timing(section),
        inertia_kg_m2: model.ground_inertia_kg_m2(),
        derivative_filter_s: section.derivative_filter_s,
        feedforward_damping_n_m_s: section.feedforward_damping_n_m_s,
        feedforward_friction_n_m: section.feedforward_friction_n_m,
        ..WheelLoopSettings::new(gains)
    };
    Ok(WheelLoop::new(model.kinematics().wheel_count(), settings)?)
}

/// The dynamic model of a scenario's robot.
pub(super) fn dynamic_model(robot: &Robot) -> Result<DynamicModel, Error> {
    Ok(DynamicModel::new(robot)?)
}
