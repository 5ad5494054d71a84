//! What a controller is to be set to, so that the robot does what it is asked: as ros2_controllers name it, for a robot that is driven by its
//! ideal kinematics.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_4;

use ilon_control::Kinematics;
use ilon_robot::Robot;

use crate::directions::contact;
use crate::model::Parameter;
use crate::outcome::{Controller, ControllerKind, Gains, Value, WheelSetting};

/// Rollers that are turned by less than this from where a controller takes them to be are as it takes them, in radians.
const WITHIN_RAD: f64 = 0.02;

/// Gains by their names in a study, and what rigid rollers make of them.
pub fn gains(robot: &Robot, by_name: &BTreeMap<String, Value>) -> Gains {
    let of = |name: &str| by_name.get(name).cloned();
    Gains {
        ahead: of("gain.ahead"),
        sideways: of("gain.sideways"),
        turn: of("gain.turn"),
        sideways_over_ahead: of("sideways_over_ahead"),
        turn_over_ahead: of("turn_over_ahead"),
        rigid: rigid(robot),
    }
}

/// What the touching rollers, by their geometry alone, make of twists ahead, to the left and of turns, over what the robot's matrix says; `None`
/// of robots whose rollers are not known.
fn rigid(robot: &Robot) -> Option<[f64; 3]> {
    let kinematics = Kinematics::new(robot).ok()?;
    let gain = |axis: usize| {
        let rates: Vec<f64> = kinematics
            .rate_matrix()
            .column(axis)
            .iter()
            .copied()
            .collect();
        let mut asked = [0.0; 3];
        asked[axis] = 1.0;
        contact(robot, asked, &rates)
    };
    Some([gain(0)?, gain(1)?, gain(2)?])
}

/// The settings that follow from gains by direction, and from wheels that were fitted one by one.
///
/// Wheels of radius R that are commanded by v / R make g v of a twist ahead; they make v of it where the controller takes R g for their radius.
/// With that radius a lever L makes (gain of turns / gain ahead) of a turn, and sideways (gain sideways / gain ahead) is left.
pub fn controller(robot: &Robot, gains: &Gains, parameters: &[(Parameter, Value)]) -> Controller {
    let nominal = |parameter: Parameter| parameter.nominal(robot);
    let (radius_m, lever_m) = (nominal(Parameter::Radius), nominal(Parameter::Lever));
    let is_omni = robot
        .wheels
        .iter()
        .all(|wheel| wheel.gamma_rad.abs() < WITHIN_RAD);
    let is_mecanum = robot.wheels.len() == 4
        && (robot.wheels.iter())
            .all(|wheel| (wheel.gamma_rad.abs() - FRAC_PI_4).abs() < WITHIN_RAD);
    let kind = match (is_omni, is_mecanum) {
        (true, _) => Some(ControllerKind::Omni),
        (_, true) => Some(ControllerKind::Mecanum),
        _ => None,
    };
    let wheels: Vec<(usize, &Value)> = parameters
        .iter()
        .filter_map(|(parameter, value)| match parameter {
            Parameter::WheelRadius(wheel) => Some((*wheel, value)),
            _ => None,
        })
        .collect();
    if wheels.is_empty() {
        let of = |value: &Option<Value>, f: &dyn Fn(f64) -> f64, unit: &str, nominal: f64| {
            value.as_ref().map(|value| value.through(f, unit, nominal))
        };
        return Controller {
            kind,
            radius_m: of(&gains.ahead, &|gain| radius_m * gain, "m", radius_m),
            lever_m: of(
                &gains.turn_over_ahead,
                &|ratio| lever_m / ratio,
                "m",
                lever_m,
            ),
            sideways_factor: of(&gains.sideways_over_ahead, &|ratio| 1.0 / ratio, "", 1.0),
            wheels: Vec::new(),
        };
    }
    let mean_m = {
        let own = |wheel: usize| wheels.iter().find(|(known, _)| *known == wheel);
        let radius_m =
            |wheel: usize| own(wheel).map_or(robot.wheels[wheel].radius_m, |own| own.1.value);
        (0..robot.wheels.len()).map(radius_m).sum::<f64>() / robot.wheels.len() as f64
    };
    let lever = parameters
        .iter()
        .find(|(parameter, _)| *parameter == Parameter::Lever);
    Controller {
        kind,
        radius_m: Some(Value {
            value: mean_m,
            ci95: [None, None],
            unit: "m".to_owned(),
            nominal: radius_m,
        }),
        lever_m: lever.map(|(_, value)| value.clone()),
        sideways_factor: None,
        wheels: (wheels.into_iter())
            .map(|(wheel, radius_m)| WheelSetting {
                wheel: robot.wheels[wheel].name.clone(),
                radius_m: radius_m.clone(),
                rate_factor: mean_m / radius_m.value,
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    /// ros2_controllers has one for four wheels whose rollers stand at 45 degrees, one for rollers across the wheel, and none for others.
    #[test]
    fn the_controller_is_that_of_the_rollers_angle() {
        let urdf = include_str!("../../../../assets/robots/mecanum4.urdf");
        let of = |change: &dyn Fn(f64) -> f64, wheels: usize| {
            let mut robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
            robot.wheels.truncate(wheels);
            for wheel in &mut robot.wheels {
                wheel.gamma_rad = change(wheel.gamma_rad);
            }
            controller(&robot, &Gains::default(), &[]).kind
        };
        assert_eq!(of(&|gamma| gamma, 4), Some(ControllerKind::Mecanum));
        assert_eq!(of(&|_| 0.0, 4), Some(ControllerKind::Omni));
        assert_eq!(of(&|gamma| 0.7 * gamma, 4), None);
        assert_eq!(of(&|gamma| gamma, 3), None);
    }
}
