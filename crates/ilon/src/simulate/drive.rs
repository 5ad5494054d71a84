//! From wheel rates asked for to torques: the wheel loops and the motors' limits.

use ilon_control::{
    DynamicModel, DynamicsSettings, Motor, MotorCurve, TorqueRange, WheelGains, WheelLoop,
    WheelLoopSettings,
};
use ilon_robot::Robot;

use crate::Error;
use crate::scenario::Scenario;

/// The wheel loops of a robot and its motors.
pub(super) struct Drive {
    wheel_loop: WheelLoop,
    motors: Vec<Motor>,
    limits: Vec<TorqueRange>,
}

impl Drive {
    /// The drive of a scenario; the gains that it chooses are written into the scenario.
    pub fn new(scenario: &mut Scenario, robot: &Robot, physics_dt_s: f64) -> Result<Self, Error> {
        let section = &mut scenario.wheel_loop;
        let armature_ratio = scenario.world.solver.roller_armature_ratio.unwrap_or(0.0);
        let roller_inertia_kg_m2 = robot
            .wheels
            .iter()
            .flat_map(|wheel| &wheel.rollers)
            .map(|roller| roller.axial_inertia_kg_m2)
            .fold(0.0, f64::max);
        let settings = DynamicsSettings {
            roller_armature_kg_m2: armature_ratio * roller_inertia_kg_m2,
            ..DynamicsSettings::default()
        };
        let model = DynamicModel::new(robot, &settings)?;
        let proposed = WheelGains::for_robot(&model, physics_dt_s, section.bandwidth_rad_s)?;
        let gains = WheelGains {
            proportional_n_m_s: *section
                .proportional_n_m_s
                .get_or_insert(proposed.proportional_n_m_s),
            integral_n_m: *section.integral_n_m.get_or_insert(proposed.integral_n_m),
            derivative_n_m_s2: section.derivative_n_m_s2,
        };
        let settings = WheelLoopSettings {
            derivative_filter_s: section.derivative_filter_s,
            feedforward_damping_n_m_s: section.feedforward_damping_n_m_s,
            feedforward_friction_n_m: section.feedforward_friction_n_m,
            ..WheelLoopSettings::new(gains)
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
            wheel_loop: WheelLoop::new(motors.len(), settings)?,
            limits: vec![TorqueRange::UNLIMITED; motors.len()],
            motors,
        })
    }

    /// The torques of the next physics step, in N m, within what each motor can give at its rate.
    pub fn torques(&mut self, targets_rad_s: &[f64], rates_rad_s: &[f64], dt_s: f64) -> &[f64] {
        for ((limit, motor), rate_rad_s) in
            self.limits.iter_mut().zip(&self.motors).zip(rates_rad_s)
        {
            *limit = motor.range(*rate_rad_s);
        }
        self.wheel_loop
            .update(targets_rad_s, rates_rad_s, &self.limits, dt_s)
    }
}
