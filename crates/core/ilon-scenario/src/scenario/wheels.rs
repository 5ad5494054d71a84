//! `[wheel_loop]` and `[motors]`: from commanded wheel rates to torques.

use std::collections::BTreeMap;

use ilon_control::LoopTiming;
use ilon_files::defaults::yes;
use ilon_robot::Robot;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

/// The law that turns commanded wheel rates into torques. Default gains follow from the bandwidth
/// and the robot's inertia.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "WheelLoopSection")]
pub struct WheelLoop {
    /// The law.
    pub law: WheelLaw,
    /// Whether the PID is sampled, or acts within the step.
    pub timing: LoopTiming,
    /// Period of a sampled PID or a torque law, in seconds: a multiple of the physics step that
    /// divides the control period [default: a millisecond, or the nearest that fits; the control
    /// period if encoders count; the physics step if a passive law has dampers].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub period_s: Option<f64>,
    /// Time from the reading of a wheel's rate to the torque that follows from it, in seconds; with
    /// a period a PID is sampled [default: none].
    #[schemars(range(min = 0.0, max = 0.2))]
    pub latency_s: Option<f64>,
    /// Bandwidth of computed torque and of default gains, in rad/s; a wheel in the air may allow
    /// less.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[default = 60.0]
    pub bandwidth_rad_s: f64,
    /// Friction coefficient assumed by the prioritised and the passive law [default: grip limits
    /// nothing].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub friction: Option<f64>,
    /// Torque per rate error, in N m s/rad.
    #[schemars(range(min = 0.0))]
    pub proportional_n_m_s: Option<f64>,
    /// Torque per angle error, in N m/rad.
    #[schemars(range(min = 0.0))]
    pub integral_n_m: Option<f64>,
    /// Torque per acceleration of the wheel, in N m s^2/rad.
    #[schemars(range(min = 0.0))]
    pub derivative_n_m_s2: f64,
    /// Time constant of the derivative's low-pass, in seconds; 0: none.
    #[schemars(range(min = 0.0))]
    pub derivative_filter_s: f64,
    /// Largest torque of the PID's integral, in N m [default: torque limits and `anti_windup` alone
    /// hold it].
    #[schemars(range(min = 0.0))]
    pub integral_limit_n_m: Option<f64>,
    /// What the PID's integral does while the motor cannot give more.
    #[serde(skip_serializing_if = "AntiWindup::is_default")]
    pub anti_windup: AntiWindup,
    /// Compensated viscous damping of the wheel's bearing, in N m s/rad.
    #[schemars(range(min = 0.0))]
    pub feedforward_damping_n_m_s: f64,
    /// Compensated dry friction of the wheel's bearing, in N m.
    #[schemars(range(min = 0.0))]
    pub feedforward_friction_n_m: f64,
    /// Springs and dampers of the passive law. Defaults follow from mass and control period.
    pub passive: Option<Passive>,
}

/// Springs and dampers of the passive law, instead of the guidance's gains. A missing partner of
/// stiffness or damping gives a damping ratio of 0.7.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "PassiveSection")]
pub struct Passive {
    /// Force per position error of the reference point, in N/m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness_n_m: Option<f64>,
    /// Force per velocity error, in N s/m [default, without stiffness: a stop within ten control
    /// periods].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub damping_n_s_m: Option<f64>,
    /// Moment per heading error, in N m/rad.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub heading_stiffness_n_m_rad: Option<f64>,
    /// Moment per error of the yaw rate, in N m s/rad.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub heading_damping_n_m_s_rad: Option<f64>,
    /// Torque per angle of wheels against each other, in N m/rad: keeps a wheel on ice from
    /// spinning. Not for three wheels.
    #[schemars(range(min = 0.0))]
    pub wheel_stiffness_n_m_rad: Option<f64>,
    /// Torque per rate of wheels against each other, in N m s/rad.
    #[schemars(range(min = 0.0))]
    pub wheel_damping_n_m_s_rad: Option<f64>,
    /// Limit of the springs between wheels, in N m [default: that of a friction of 1].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub wheel_limit_n_m: Option<f64>,
}

/// What the integral of a PID does while its torque is at the motor's limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AntiWindup {
    /// It stands still while the error would drive it further beyond the limit.
    #[default]
    Conditional,
    /// It goes on, and has to be worked off afterwards.
    None,
}

impl AntiWindup {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// A law from wheel rates to torques.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WheelLaw {
    /// A PID on each wheel's rate by itself.
    #[default]
    Pid,
    /// Computed torque from the robot's dynamic model, Indiveri 2009, equation (12).
    ComputedTorque,
    /// Computed torque that lets the task of lower priority (`guidance.priority`) give way where
    /// motors or grip cannot give both, and shares what the wheels push so that the worst use of
    /// grip is least.
    PrioritisedTorque,
    /// A spring and a damper to the reference, and springs between the wheels: gives way to a push
    /// by force over stiffness, needs no contact sensor, no friction coefficient and no integrator,
    /// and with `[sensors.imu]` holds a slope that it was not told of.
    Passive,
}

impl WheelLoop {
    /// Whether it decides once in a period and holds its torques meanwhile.
    pub fn is_sampled(&self) -> bool {
        self.law != WheelLaw::Pid || self.timing == LoopTiming::Sampled
    }

    /// Whether it acts all the time, but late.
    pub fn is_late(&self) -> bool {
        !self.is_sampled() && self.latency_s() > 0.0
    }

    /// Whether it acts once a physics step: a step cannot be taken in parts.
    pub fn takes_whole_steps(&self) -> bool {
        self.is_sampled() || self.is_late()
    }

    /// How late its torques come, in seconds.
    pub fn latency_s(&self) -> f64 {
        self.latency_s.unwrap_or(0.0)
    }
}

/// Motors and gears. The `effort` and `velocity` of the URDF always hold too.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "MotorsSection")]
pub struct Motors {
    /// Torque-speed curve of a DC motor with its gear; without it only the URDF's limits hold.
    pub dc: Option<DcMotor>,
    /// Turns of the rotor per turn of the wheel [default: the robot's file, else 1].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub gear_ratio: Option<f64>,
    /// Inertia of the rotor before the gear, in kg m^2; the wheel feels gear_ratio^2 times it
    /// [default: the robot's file, else 0].
    #[schemars(range(min = 0.0))]
    pub rotor_inertia_kg_m2: Option<f64>,
    /// Efficiency eta of the gear. Where the load drives, 2 - 1 / eta of its power arrives at the
    /// motor; up to 0.5 the gear locks itself [default: the robot's file, else 1].
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub gear_efficiency: Option<f64>,
    /// Dry friction of the gear at the wheel, in N m, beside the bearing's [default: the robot's
    /// file, else 0].
    #[schemars(range(min = 0.0))]
    pub gear_friction_n_m: Option<f64>,
    /// Torque below which a drive gives none, in N m.
    #[schemars(range(min = 0.0))]
    pub dead_band_n_m: Option<f64>,
    /// `[motors.wheels.NAME]`: single wheels whose motors are weaker or stronger.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub wheels: BTreeMap<String, MotorStrength>,
}

/// Strength of one motor relative to the others: with `[motors.dc]` of the voltage, so of stall
/// torque and no-load rate, else of the effort.
#[derive(Clone, Copy, Debug, SmartDefault, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "MotorStrengthSection")]
pub struct MotorStrength {
    /// Where it pushes the wheel forwards, in the sense of its joint.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[default = 1.0]
    pub forwards: f64,
    /// Where it pushes the wheel backwards.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[default = 1.0]
    pub backwards: f64,
}

impl Motors {
    /// Overrides the drives of the robot's file with the values of this section.
    pub fn apply(&self, robot: &mut Robot) {
        for drive in robot.wheels.iter_mut().map(|wheel| &mut wheel.drive) {
            let set = |value: &mut f64, said: Option<f64>| *value = said.unwrap_or(*value);
            set(&mut drive.gear_ratio, self.gear_ratio);
            set(&mut drive.rotor_inertia_kg_m2, self.rotor_inertia_kg_m2);
            set(&mut drive.gear_efficiency, self.gear_efficiency);
            set(&mut drive.gear_friction_n_m, self.gear_friction_n_m);
        }
    }
}

/// A DC motor at the wheel: at the share u of the voltage (-1 to 1) its torque is stall_torque (u -
/// rate / no_load_rate), at any rate.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "DcMotorSection")]
pub struct DcMotor {
    /// Torque at standstill at full voltage, at the wheel, in N m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stall_torque_n_m: f64,
    /// Rate without load at full voltage, at the wheel, in rad/s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub no_load_rate_rad_s: f64,
    /// Torque at the controller's current limit, driving and braking, at the wheel, in N m
    /// [default: the effort of the robot's file].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub current_limit_n_m: Option<f64>,
    /// The battery takes returned power. If not, braking heats the winding, and beyond its no-load
    /// rate the motor coasts at full voltage.
    #[serde(default = "yes")]
    pub regeneration: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    const ROBOT: &str = "../../../assets/robots/volksbot.toml";

    #[test]
    fn what_a_scenario_says_of_the_drives_stands_before_what_the_file_says() {
        let mut robot = Robot::load(ROBOT).unwrap();
        robot.wheels[0].drive.gear_ratio = 12.0;
        robot.wheels[0].drive.gear_efficiency = 0.7;
        let motors: Motors =
            toml::from_str("rotor_inertia_kg_m2 = 1e-6\ngear_efficiency = 0.9").unwrap();
        motors.apply(&mut robot);
        let (first, second) = (robot.wheels[0].drive, robot.wheels[1].drive);
        assert_eq!((first.gear_ratio, second.gear_ratio), (12.0, 1.0));
        assert_eq!((first.gear_efficiency, second.gear_efficiency), (0.9, 0.9));
        // 144 times 1e-6 kg m^2.
        assert!((first.reflected_inertia_kg_m2() - 1.44e-4).abs() < 1e-18);
    }
}
