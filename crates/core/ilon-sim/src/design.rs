//! What a design can do, computed without a run: rank and condition of the wheel arrangement, the
//! speeds that its wheel rates allow, and the accelerations that grip and motors allow.

use ilon_control::{Arrangement, Kinematics, SpeedLimits};
use ilon_robot::{Robot, Twist};
use ilon_trace::Design;

use crate::Error;
use crate::scenario::Scenario;
use ilon_plant::limits::{Limiter, top_rates};
use ilon_scenario::course::joint_targets::JointTargets;
use ilon_scenario::course::playback::Played;

/// Angle between the directions in which accelerations are computed, in degrees. Chosen: limits
/// change little between two of them.
const STEP_DEG: usize = 15;

/// The capabilities of a robot under a scenario's floor, slope, motors, payloads and wheel rates.
/// `robot` is a result of [`load_robot`](crate::load_robot). For a singular arrangement only the
/// rank is returned.
///
/// # Errors
/// If the robot or the scenario is invalid: fewer than three wheels, a floor without friction.
pub fn design(scenario: &Scenario, robot: &Robot) -> Result<Design, Error> {
    let targets = JointTargets::new(scenario, &Played::default(), robot)?;
    let posed = targets.standing(robot);
    let arrangement = Arrangement::of(&posed)?;
    let finite = |value: f64| value.is_finite().then_some(value);
    let mut design = Design::default();
    design.rank = Some(arrangement.rank as f64);
    if arrangement.rank < 3 {
        return Ok(design);
    }
    design.condition = finite(arrangement.condition);
    let tops = SpeedLimits::new(&Kinematics::new(&posed)?, &top_rates(scenario, robot));
    let (least_m_s, most_m_s) = tops.top_speed_range_m_s();
    design.speed_least_m_s = finite(least_m_s);
    design.speed_most_m_s = finite(most_m_s);
    design.yaw_rate_rad_s = finite(tops.top_yaw_rate_rad_s());
    if posed.wheels.iter().any(|wheel| wheel.has_tyre()) {
        return Ok(design);
    }
    let mut limiter = Limiter::new(scenario, (robot, &targets), 1.0)?;
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for degrees in (0..360).step_by(STEP_DEG) {
        let (sin, cos) = libm::sincos((degrees as f64).to_radians());
        let found = limiter.along(Twist::new(cos, sin, 0.0), Twist::default())?;
        least = least.min(found.largest);
        most = most.max(found.largest);
    }
    design.acceleration_least_m_s2 = finite(least);
    design.acceleration_most_m_s2 = finite(most);
    Ok(design)
}
