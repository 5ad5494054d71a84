//! The wheel loops of a scenario: gains from the scenario, or chosen by the program.

use ilon_control::{
    DynamicModel, LoopTiming, PassiveTorqueSettings, TiltLoop, WheelGains, WheelLoop,
    WheelLoopSettings,
};
use ilon_robot::Robot;

use crate::Error;
use crate::scenario::{self, Passive, Scenario, Step, WheelLaw};

/// The period of a sampled wheel loop whose period the scenario leaves open, in seconds. Chosen:
/// that of usual motor controllers.
const PERIOD_S: f64 = 1e-3;

/// Samples a PID whose rates are counted, or whose torques come late and that has a period, and
/// fills in the period of sampled loops. By counted rates a loop decides when they are read, once a
/// control period. The period of a passive law with given dampers is the physics step, which they
/// choose.
pub fn choose_timing(scenario: &mut Scenario) {
    let (run, section) = (&scenario.run, &mut scenario.wheel_loop);
    let is_counted = scenario.sensors.encoders.counts_per_turn.is_some();
    let is_pid = section.law == WheelLaw::Pid;
    if (is_pid && is_counted) || (section.is_late() && section.period_s.is_some()) {
        section.timing = LoopTiming::Sampled;
    }
    if is_counted {
        section.period_s.get_or_insert(run.control_dt_s);
    } else if section.is_sampled() && !has_dampers(section) {
        section
            .period_s
            .get_or_insert_with(|| own_period_s(run.control_dt_s, &run.physics_dt_s));
    }
}

/// Whether a section says how a passive law damps.
fn has_dampers(section: &scenario::WheelLoop) -> bool {
    let said = section
        .passive
        .as_ref()
        .filter(|_| section.law == WheelLaw::Passive);
    said.is_some_and(|said| {
        let damps = [
            said.damping_n_s_m,
            said.heading_damping_n_m_s_rad,
            said.wheel_damping_n_m_s_rad,
        ];
        damps.iter().any(Option::is_some)
    })
}

/// The period nearest to `PERIOD_S`, by ratio, that is a whole number of physics steps and divides
/// the control period, in seconds.
fn own_period_s(control_dt_s: f64, step: &Step) -> f64 {
    let Step::Seconds(dt_s) = *step else {
        return control_dt_s / (control_dt_s / PERIOD_S).round().max(1.0);
    };
    let steps = (control_dt_s / dt_s).round().max(1.0) as u64;
    let off = |parts: u64| libm::log(control_dt_s / parts as f64 / PERIOD_S).abs();
    let parts = (1..=steps.isqrt())
        .filter(|parts| steps.is_multiple_of(*parts))
        .flat_map(|parts| [parts, steps / parts])
        .min_by(|a, b| off(*a).total_cmp(&off(*b)));
    control_dt_s / parts.unwrap_or(1) as f64
}

/// How late on average a rate is that is counted over the last control period and held until the
/// next, in seconds, where a loop with this period uses it; 0 without counts. Half a period is its
/// mean over the last, the rest is waiting.
pub fn counted_lag_s(scenario: &Scenario, period_s: f64) -> f64 {
    let counts = scenario.sensors.encoders.counts_per_turn;
    counts.map_or(0.0, |_| scenario.run.control_dt_s - 0.5 * period_s)
}

/// The period and the lag of a sampled loop that is as stable as one that acts all the time with a
/// latency, in seconds: a period that is short against it, of which half is part of it.
pub(super) fn as_sampled_s(latency_s: f64) -> (f64, f64) {
    /// Periods in a latency, and the shortest, below which the loop's polynomial has no digits
    /// left. Chosen.
    const PERIODS: f64 = 10.0;
    const SHORTEST_S: f64 = 1e-5;
    let period_s = (latency_s / PERIODS).max(SHORTEST_S);
    (period_s, (latency_s - 0.5 * period_s).max(0.0))
}

/// Fills in the period and the gains that a `[wheel_loop]` section leaves open. Returns the period,
/// in seconds.
pub fn choose_gains(
    scenario: &mut Scenario,
    model: &DynamicModel,
    physics_dt_s: f64,
) -> Result<f64, Error> {
    let section = &mut scenario.wheel_loop;
    if section.is_sampled() {
        section.period_s.get_or_insert(physics_dt_s);
    }
    let period_s = section.period_s.unwrap_or(physics_dt_s);
    if section.law == WheelLaw::Pid {
        // A rate that is half a period old has the limit of a new one.
        let counted_s = counted_lag_s(scenario, period_s) - 0.5 * period_s;
        let section = &mut scenario.wheel_loop;
        let gains = gains(section, model, (period_s, counted_s.max(0.0)))?;
        section.proportional_n_m_s = Some(gains.proportional_n_m_s);
        section.integral_n_m = Some(gains.integral_n_m);
    }
    Ok(period_s)
}

fn gains(
    section: &scenario::WheelLoop,
    model: &DynamicModel,
    (period_s, counted_s): (f64, f64),
) -> Result<WheelGains, Error> {
    let bandwidth_rad_s = section.bandwidth_rad_s;
    let (held, timing) = match section.is_late() {
        true => (as_sampled_s(section.latency_s()), LoopTiming::Sampled),
        false => {
            let lag_s = section.latency_s() + counted_s;
            ((period_s, lag_s), section.timing)
        }
    };
    let proposed = WheelGains::for_robot(model, timing, held, bandwidth_rad_s)?;
    Ok(WheelGains {
        proportional_n_m_s: section
            .proportional_n_m_s
            .unwrap_or(proposed.proportional_n_m_s),
        integral_n_m: section.integral_n_m.unwrap_or(proposed.integral_n_m),
        derivative_n_m_s2: section.derivative_n_m_s2,
    })
}

/// The wheel loops of a `[wheel_loop]` section.
pub fn pid(
    section: &scenario::WheelLoop,
    model: &DynamicModel,
    period_s: f64,
) -> Result<WheelLoop, Error> {
    let gains = gains(section, model, (period_s, 0.0))?;
    let settings = WheelLoopSettings {
        timing: section.timing,
        // The torque of a late loop does not act in the step in which it is decided: there the rate
        // changes as evenly as if the wheel were heavy.
        inertia_kg_m2: match section.is_late() {
            true => f64::MAX,
            false => model.ground_inertia_kg_m2(),
        },
        derivative_filter_s: section.derivative_filter_s,
        feedforward_damping_n_m_s: section.feedforward_damping_n_m_s,
        feedforward_friction_n_m: section.feedforward_friction_n_m,
        integral_limit_n_m: section.integral_limit_n_m.unwrap_or(f64::INFINITY),
        winds_up: section.anti_windup == scenario::AntiWindup::None,
        ..WheelLoopSettings::new(gains)
    };
    Ok(WheelLoop::new(model.kinematics().wheel_count(), settings)?)
}

/// The dynamic model of a scenario's robot.
pub fn dynamic_model(robot: &Robot) -> Result<DynamicModel, Error> {
    Ok(DynamicModel::new(robot)?)
}

/// Fills in the springs and dampers that a passive law's section leaves open, and the guidance's
/// gains that follow from them.
///
/// # Errors
/// [`Error::Control`] if the robot has no such law, also on tyres.
pub fn choose_springs(scenario: &mut Scenario, robot: &Robot) -> Result<(), Error> {
    if scenario.wheel_loop.law != WheelLaw::Passive {
        return Ok(());
    }
    if robot.has_tyres() {
        return Err(Error::invalid(
            "the passive law pulls the robot in every direction, but its tyres roll in only one",
            "leave `wheel_loop.law` out",
        ));
    }
    let run = &scenario.run;
    let period_s = scenario.wheel_loop.period_s;
    let period_s = period_s.unwrap_or_else(|| own_period_s(run.control_dt_s, &run.physics_dt_s));
    let own = passive_settings(scenario, robot, period_s)?;
    scenario.wheel_loop.passive = Some(Passive {
        stiffness_n_m: Some(own.stiffness_n_m),
        damping_n_s_m: Some(own.damping_n_s_m),
        heading_stiffness_n_m_rad: Some(own.heading_stiffness_n_m_rad),
        heading_damping_n_m_s_rad: Some(own.heading_damping_n_m_s_rad),
        wheel_stiffness_n_m_rad: Some(own.wheel_stiffness_n_m_rad),
        wheel_damping_n_m_s_rad: Some(own.wheel_damping_n_m_s_rad),
        wheel_limit_n_m: Some(own.wheel_limit_n_m),
    });
    scenario.guidance.position_gain_per_s = own.position_gain_per_s();
    scenario.guidance.heading_gain_per_s = own.heading_gain_per_s();
    Ok(())
}

/// The settings of a scenario's passive law, about the body's origin.
pub fn passive_settings(
    scenario: &Scenario,
    robot: &Robot,
    loop_period_s: f64,
) -> Result<PassiveTorqueSettings, Error> {
    let (control_dt_s, sensor) = (scenario.run.control_dt_s, &scenario.sensors.pose);
    let period =
        |rate_hz: Option<f64>| rate_hz.map_or(control_dt_s, |hz| control_dt_s.max(1.0 / hz));
    // A filter extrapolates each pose to the present.
    let (pose_period_s, pose_delay_s) = match scenario.sensors.fusion {
        Some(_) => (control_dt_s, 0.0),
        None => (period(sensor.rate_hz), sensor.latency_s),
    };
    let mut own = PassiveTorqueSettings::for_robot(
        robot,
        scenario.world.gravity_m_s2,
        loop_period_s,
        pose_period_s,
        pose_delay_s,
    )?;
    let said = scenario.wheel_loop.passive.clone().unwrap_or_default();
    // For translation and for rotation: the given values; a missing partner keeps the default ratio
    // of damping^2 to stiffness.
    let complete = |own: (f64, f64), said: (Option<f64>, Option<f64>)| match said {
        (Some(stiffness), Some(damping)) => (stiffness, damping),
        (Some(stiffness), None) => (stiffness, own.1 * libm::sqrt(stiffness / own.0)),
        (None, Some(damping)) => (own.0 * (damping / own.1) * (damping / own.1), damping),
        (None, None) => own,
    };
    (own.stiffness_n_m, own.damping_n_s_m) = complete(
        (own.stiffness_n_m, own.damping_n_s_m),
        (said.stiffness_n_m, said.damping_n_s_m),
    );
    (own.heading_stiffness_n_m_rad, own.heading_damping_n_m_s_rad) = complete(
        (own.heading_stiffness_n_m_rad, own.heading_damping_n_m_s_rad),
        (
            said.heading_stiffness_n_m_rad,
            said.heading_damping_n_m_s_rad,
        ),
    );
    let set = |own: &mut f64, said: Option<f64>| *own = said.unwrap_or(*own);
    set(
        &mut own.wheel_stiffness_n_m_rad,
        said.wheel_stiffness_n_m_rad,
    );
    set(
        &mut own.wheel_damping_n_m_s_rad,
        said.wheel_damping_n_m_s_rad,
    );
    set(&mut own.wheel_limit_n_m, said.wheel_limit_n_m);
    own.priority = scenario.guidance.priority.unwrap_or_default();
    own.friction = scenario.wheel_loop.friction.unwrap_or(f64::INFINITY);
    own.tilt = scenario.sensors.imu.as_ref().map(|imu| TiltLoop {
        time_constant_s: imu.filter_s,
        delay_s: imu.latency_s + period(imu.rate_hz),
    });
    Ok(own)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A millisecond, or the nearest whole number of steps that divides the control period.
    #[test]
    fn a_sampled_loop_has_a_period_that_the_chosen_step_does_not_change() {
        let period_s = |lines: &str| {
            let text = format!("robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\n{lines}");
            let mut scenario = Scenario::from_toml(&text, "test", "").expect("a scenario");
            choose_timing(&mut scenario);
            scenario.wheel_loop.period_s
        };
        let law = "wheel_loop.law = \"computed_torque\"\n";
        let sampled = "wheel_loop.timing = \"sampled\"\n";
        for (lines, steps, of_s) in [
            ("", 10.0, 0.01),
            ("run.control_dt_s = 0.0125", 13.0, 0.0125),
            ("run.control_dt_s = 0.0004", 1.0, 0.0004),
            ("run.physics_dt_s = 0.00025", 10.0, 0.01),
            ("run.physics_dt_s = 0.0025", 4.0, 0.01),
            // 2 ms are 5 of 25 steps, 0.4 ms are one: 2 and 2.5 times off.
            ("run.physics_dt_s = 0.0004", 5.0, 0.01),
            // 101 steps of 0.1 ms: one of them is ten times off, all are as much.
            (
                "run.physics_dt_s = 0.0001\nrun.control_dt_s = 0.0101",
                101.0,
                0.0101,
            ),
        ] {
            for loops in [law, sampled, "wheel_loop.law = \"passive\"\n"] {
                let found_s = period_s(&format!("{loops}{lines}")).expect("a period");
                assert!((found_s - of_s / steps).abs() < 1e-12, "{lines}: {found_s}");
            }
        }
        let counted = "sensors.encoders.counts_per_turn = 500";
        assert_eq!(period_s(counted), Some(0.01));
        assert_eq!(period_s("wheel_loop.latency_s = 0.01"), None);
        let passive = "wheel_loop = { law = \"passive\", passive.damping_n_s_m = 100 }";
        assert_eq!([period_s(""), period_s(passive)], [None; 2]);
    }
}
