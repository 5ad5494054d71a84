//! From wheel rates asked for to torques: the wheel loops and the motors' limits.

use ilon_control::{
    ComputedTorque, ComputedTorqueSettings, DynamicModel, DynamicsSettings, LoopTiming, Motor,
    MotorCurve, PrioritisedTorque, PrioritisedTorqueSettings, TorqueRange, TorqueShares,
    WheelGains, WheelLoop, WheelLoopSettings,
};
use ilon_robot::Robot;
use nalgebra::Vector2;

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
    PrioritisedTorque(Box<PrioritisedTorque>),
}

impl Drive {
    /// The drive of a scenario; the gains that it chooses are written into the scenario. `reference_point_m` is the
    /// guidance's, in the body frame.
    pub fn new(
        scenario: &mut Scenario,
        robot: &Robot,
        model: DynamicModel,
        reference_point_m: Vector2<f64>,
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
            WheelLaw::PrioritisedTorque => {
                let settings = PrioritisedTorqueSettings {
                    bandwidth_rad_s: scenario.wheel_loop.bandwidth_rad_s,
                    target_filter_s: scenario.run.control_dt_s,
                    dt_s: physics_dt_s,
                    priority: scenario.guidance.priority.into(),
                    reference_point_m,
                    friction: scenario.wheel_loop.friction.unwrap_or(f64::INFINITY),
                    gravity_m_s2: scenario.world.gravity_m_s2,
                };
                let law = PrioritisedTorque::new(robot, &DynamicsSettings::default(), &settings)?;
                Law::PrioritisedTorque(Box::new(law))
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

    /// How much of each task the last torques gave; `None` of a law that weighs none.
    pub fn shares(&self) -> Option<TorqueShares> {
        match &self.law {
            Law::PrioritisedTorque(law) => Some(law.shares()),
            Law::Pid(_) | Law::ComputedTorque(_) => None,
        }
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
            (Targets::Rates(rates), Law::PrioritisedTorque(law)) => {
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

impl From<scenario::Priority> for ilon_control::Priority {
    fn from(priority: scenario::Priority) -> Self {
        match priority {
            scenario::Priority::Position => Self::Position,
            scenario::Priority::Heading => Self::Heading,
        }
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

/// The dynamic model of a scenario's robot.
pub(super) fn dynamic_model(robot: &Robot) -> Result<DynamicModel, Error> {
    Ok(DynamicModel::new(robot, &DynamicsSettings::default())?)
}
