//! From wheel rates asked for to torques: the wheel loops and the motors' limits.

use ilon_control::{
    ComputedTorque, ComputedTorqueSettings, DynamicModel, DynamicsSettings, LoopTiming, Motor,
    MotorCurve, TorqueRange, WheelGains, WheelLoop, WheelLoopSettings,
};
use ilon_robot::Robot;

use super::pilot::Targets;
use crate::Error;
use crate::scenario::{self, Scenario, WheelLaw};

/// The wheel loops of a robot and its motors.
pub(super) struct Drive {
    law: Law,
    motors: Vec<Motor>,
    limits: Vec<TorqueRange>,
    torques_n_m: Vec<f64>,
    droops_n_m_s: Vec<f64>,
}

enum Law {
    Pid(WheelLoop),
    ComputedTorque(Box<ComputedTorque>),
}

impl Drive {
    /// The drive of a scenario; the gains that it chooses are written into the scenario.
    pub fn new(
        scenario: &mut Scenario,
        robot: &Robot,
        model: DynamicModel,
        physics_dt_s: f64,
    ) -> Result<Self, Error> {
        let law = match scenario.wheel_loop.law {
            WheelLaw::Pid => {
                let section = &mut scenario.wheel_loop;
                Law::Pid(pid(section, &model, physics_dt_s)?)
            }
            WheelLaw::ComputedTorque => {
                let settings = ComputedTorqueSettings {
                    bandwidth_rad_s: scenario.wheel_loop.bandwidth_rad_s,
                    // The targets change once a control period; their derivative is smoothed over as long.
                    target_filter_s: scenario.run.control_dt_s,
                    dt_s: physics_dt_s,
                };
                Law::ComputedTorque(Box::new(ComputedTorque::new(model, &settings)?))
            }
        };
        let curve = match scenario.motors.dc {
            Some(dc) => MotorCurve::dc_line(dc.stall_torque_n_m, dc.no_load_rate_rad_s)?,
            None => MotorCurve::Flat,
        };
        let motors: Vec<Motor> = robot
            .wheels
            .iter()
            .map(|wheel| Motor::new(&wheel.motor, curve))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            law,
            torques_n_m: vec![0.0; motors.len()],
            droops_n_m_s: vec![0.0; motors.len()],
            limits: vec![TorqueRange::UNLIMITED; motors.len()],
            motors,
        })
    }

    /// The torques of the next physics step, in N m, within what each motor can give at its rate while a share of the
    /// supply is left.
    ///
    /// A torque falls by its droop, in N m s/rad, per rate that its wheel gains during the step.
    pub fn torques(
        &mut self,
        targets: Targets<'_>,
        rates_rad_s: &[f64],
        supply_share: f64,
        dt_s: f64,
    ) -> (&[f64], &[f64]) {
        self.droops_n_m_s.fill(0.0);
        for ((limit, motor), rate_rad_s) in
            self.limits.iter_mut().zip(&self.motors).zip(rates_rad_s)
        {
            *limit = motor.range_on(*rate_rad_s, supply_share);
        }
        match (targets, &mut self.law) {
            (Targets::Rates(rates), Law::Pid(pid)) => {
                pid.update(rates, rates_rad_s, &self.limits, dt_s);
                self.torques_n_m.copy_from_slice(pid.torques_n_m());
                self.droops_n_m_s.copy_from_slice(pid.droops_n_m_s());
            }
            (Targets::Rates(rates), Law::ComputedTorque(law)) => {
                let torques_n_m = law.update(rates, rates_rad_s, &self.limits, dt_s);
                self.torques_n_m.copy_from_slice(torques_n_m);
            }
            (Targets::Torques(torques), _) => {
                let given = self.torques_n_m.iter_mut().zip(&self.limits);
                for ((given, limit), asked) in given.zip(torques) {
                    *given = limit.clamp(*asked);
                }
            }
        }
        (&self.torques_n_m, &self.droops_n_m_s)
    }
}

/// The wheel loops of a `[wheel_loop]` section; the gains that are left out there are chosen and written into it.
fn pid(
    section: &mut scenario::WheelLoop,
    model: &DynamicModel,
    physics_dt_s: f64,
) -> Result<WheelLoop, Error> {
    let timing = match section.timing {
        scenario::LoopTiming::Sampled => LoopTiming::Sampled,
        scenario::LoopTiming::Continuous => LoopTiming::Continuous,
    };
    let proposed = WheelGains::for_robot(model, timing, physics_dt_s, section.bandwidth_rad_s)?;
    let gains = WheelGains {
        proportional_n_m_s: *section
            .proportional_n_m_s
            .get_or_insert(proposed.proportional_n_m_s),
        integral_n_m: *section.integral_n_m.get_or_insert(proposed.integral_n_m),
        derivative_n_m_s2: section.derivative_n_m_s2,
    };
    let settings = WheelLoopSettings {
        timing,
        derivative_filter_s: section.derivative_filter_s,
        feedforward_damping_n_m_s: section.feedforward_damping_n_m_s,
        feedforward_friction_n_m: section.feedforward_friction_n_m,
        ..WheelLoopSettings::new(gains)
    };
    Ok(WheelLoop::new(model.kinematics().wheel_count(), settings)?)
}

/// The dynamic model of a scenario's robot, with the roller armature of the simulated one.
pub(super) fn dynamic_model(scenario: &Scenario, robot: &Robot) -> Result<DynamicModel, Error> {
    let defaults = ilon_world::Settings::default();
    let settings = DynamicsSettings {
        roller_armature_ratio: scenario
            .world
            .solver
            .roller_armature_ratio
            .unwrap_or(defaults.roller_armature_ratio),
        ..DynamicsSettings::default()
    };
    Ok(DynamicModel::new(robot, &settings)?)
}
