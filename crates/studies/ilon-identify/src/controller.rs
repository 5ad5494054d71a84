//! Controller settings, by the names of ros2_controllers, that make a robot with ideal kinematics
//! follow its commands.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_4, TAU};

use ilon_control::Kinematics;
use ilon_robot::{Robot, Wheel};
use nalgebra::{Vector2, Vector3};

use crate::directions::contact;
use crate::model::{Parameter, is_held, named_wheels, stands_for_steered};
use crate::outcome::{Controller, ControllerKind, Gains, Value, WheelSetting};
use crate::scatter::Interval;
use crate::steered::{ahead, is_hold};

/// Rollers within this angle of the controller's assumption agree with it, in radians.
const WITHIN_RAD: f64 = 0.02;

/// Returns gains by their names in a study, and the gains of rigid rollers.
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

/// Returns the gains of twists ahead, to the left and of rotation by the touching rollers' geometry
/// alone, relative to the robot's matrix; `None` if the rollers are unknown.
pub(crate) fn rigid(robot: &Robot) -> Option<[f64; 3]> {
    // A tyre goes as far as its rate says.
    let kinematics = Kinematics::new(robot).ok().filter(|_| !is_held(robot))?;
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

/// Returns the controller of ros2_controllers that can drive such a robot: four mecanum wheels on
/// parallel axes with equal sums of their arms, omni wheels that face outward, spread evenly on
/// a circle, tyres on parallel axles, or one that is steered before the middle of an axle.
pub fn kind(robot: &Robot) -> Option<ControllerKind> {
    /// Lengths that differ by less than this share are equal: files are rounded, and measurements
    /// too.
    const WITHIN: f64 = 0.01;
    let wheels = &robot.wheels;
    let (steered, fixed): (Vec<usize>, Vec<usize>) =
        (0..wheels.len()).partition(|at| stands_for_steered(robot, *at));
    if let ([one, _], [left, right]) = (&steered[..], &fixed[..]) {
        let [one, left, right] = [one, left, right].map(|at| &wheels[*at]);
        let across = (left.position_m() - right.position_m()).xy();
        let off = one.position_m() - 0.5 * (left.position_m() + right.position_m());
        // A wheel that stands for a tyre's hold alone rolls along its axle.
        let axle = |wheel: &Wheel| match is_hold(wheel) {
            true => ahead(wheel),
            false => wheel.axis(),
        };
        let n = axle(left);
        let is_parallel = n.perp(&axle(right)).abs() < WITHIN_RAD
            && n.dot(&across).abs() > (1.0 - WITHIN) * across.norm();
        // In the direction in which it drives at an angle of 0.
        let is_ahead = off.xy().dot(&ahead(one)) > 0.0;
        let is_in_middle = off.xy().dot(&across).abs() < WITHIN * across.norm_squared();
        let is_tricycle = is_held(robot) && is_parallel && is_ahead && is_in_middle;
        return is_tricycle.then_some(ControllerKind::Tricycle);
    }
    if !steered.is_empty() {
        return None;
    }
    if is_held(robot) {
        let first = wheels.first()?.axis();
        let is_parallel = |wheel: &Wheel| wheel.axis().perp(&first).abs() < WITHIN_RAD;
        return wheels
            .iter()
            .all(is_parallel)
            .then_some(ControllerKind::Differential);
    }
    let count = wheels.len() as f64;
    let are_at = |gamma_rad: f64| {
        let mut all = wheels.iter();
        all.all(|wheel| (wheel.gamma_rad.abs() - gamma_rad).abs() < WITHIN_RAD)
    };
    let middle = wheels
        .iter()
        .map(|wheel| wheel.position_m())
        .sum::<Vector3<f64>>()
        / count;
    let arms = || {
        wheels
            .iter()
            .map(|wheel| (wheel.position_m() - middle).xy())
    };
    let are_equal = |lengths: &mut dyn Iterator<Item = f64>| {
        let lengths: Vec<f64> = lengths.collect();
        let mean = lengths.iter().sum::<f64>() / count;
        lengths
            .iter()
            .all(|length| (length - mean).abs() < WITHIN * mean)
    };
    let axes = || wheels.iter().map(|wheel| wheel.axis().xy());
    if are_at(0.0) {
        let looks_outward = |(arm, axis): (Vector2<f64>, Vector2<f64>)| {
            arm.perp(&axis).abs() < WITHIN_RAD * arm.norm()
        };
        let mut angles: Vec<f64> = arms().map(|arm| libm::atan2(arm.y, arm.x)).collect();
        angles.sort_by(f64::total_cmp);
        let first = angles.first().copied().unwrap_or_default();
        let is_even = |(place, angle): (usize, &f64)| {
            (angle - first - TAU * place as f64 / count).abs() < WITHIN_RAD
        };
        let is_ring = are_equal(&mut arms().map(|arm| arm.norm()))
            && arms().zip(axes()).all(looks_outward)
            && angles.iter().enumerate().all(is_even);
        return is_ring.then_some(ControllerKind::Omni);
    }
    let first = axes().next()?;
    let are_parallel = axes().all(|axis| axis.perp(&first).abs() < WITHIN_RAD);
    let sum = |arm: Vector2<f64>| arm.dot(&first).abs() + arm.perp(&first).abs();
    let is_mecanum =
        wheels.len() == 4 && are_at(FRAC_PI_4) && are_parallel && are_equal(&mut arms().map(sum));
    is_mecanum.then_some(ControllerKind::Mecanum)
}

/// Returns the settings that follow from gains by direction, and from wheels that were fitted
/// separately, without a [`kind`] yet.
///
/// Wheels of radius R commanded with v / R produce g v of a twist ahead; they produce v if the
/// controller's radius is R g. With that radius a lever L produces (gain of rotation / gain ahead)
/// of a rotation, and a factor sideways of (gain sideways / gain ahead) is left.
pub fn controller(robot: &Robot, gains: &Gains, parameters: &[(Parameter, Value)]) -> Controller {
    let [radius_m, lever_m] = [Parameter::Radius, Parameter::Lever].map(|of| of.nominal(robot));
    let wheels: Vec<(usize, &Value)> = parameters
        .iter()
        .filter_map(|(parameter, value)| match parameter {
            Parameter::WheelRadius(wheel) => Some((*wheel, value)),
            _ => None,
        })
        .collect();
    let value_of = |wanted: Parameter| {
        let mut parameters = parameters.iter();
        parameters
            .find(|(of, _)| *of == wanted)
            .map(|of| of.1.clone())
    };
    let fitted = Controller {
        radius_m: value_of(Parameter::Radius),
        lever_m: value_of(Parameter::Lever),
        gamma_deg: value_of(Parameter::Gamma),
        ..Controller::default()
    };
    if !wheels.is_empty() {
        let own = |wheel: usize| wheels.iter().find(|(known, _)| *known == wheel);
        let own_m = |index: &usize| {
            own(*index).map_or(robot.wheels[*index].radius_m, |(_, value)| value.value)
        };
        let named = named_wheels(robot);
        let mean_m = named.iter().map(own_m).sum::<f64>() / named.len() as f64;
        let mean = |value: f64| Value::new(value, Interval::around(value, f64::NAN), "m", radius_m);
        let setting = |name: &str, radius_m: Value| WheelSetting {
            wheel: name.to_owned(),
            rate_factor: mean_m / radius_m.value,
            radius_m,
        };
        // The controller of a robot that is held sideways has one radius a side.
        let wheels = match is_held(robot) {
            true => [("left", 1.0), ("right", -1.0)]
                .into_iter()
                .filter_map(|(name, side)| {
                    let radius_m = radius_of_side(robot, &wheels, side, &mean)?;
                    Some(setting(name, radius_m))
                })
                .collect(),
            false => (wheels.iter())
                .map(|(wheel, radius_m)| setting(&robot.wheels[*wheel].name, (*radius_m).clone()))
                .collect(),
        };
        return Controller {
            radius_m: Some(mean(mean_m)),
            wheels,
            ..fitted
        };
    }
    // Gains by direction describe wheels at other places or with other rollers than stated as seen
    // by the stated commands: radius and lever are what was fitted besides.
    let is_beside = |of: &Parameter| of.is_of_place() || *of == Parameter::Gamma;
    if parameters.iter().any(|(parameter, _)| is_beside(parameter)) {
        return fitted;
    }
    let of = |value: &Option<Value>, f: &dyn Fn(f64) -> f64, unit: &str, nominal: f64| {
        value.as_ref().map(|value| value.through(f, unit, nominal))
    };
    Controller {
        radius_m: of(&gains.ahead, &|gain| radius_m * gain, "m", radius_m),
        lever_m: of(
            &gains.turn_over_ahead,
            &|ratio| lever_m / ratio,
            "m",
            lever_m,
        ),
        sideways_factor: of(&gains.sideways_over_ahead, &|ratio| 1.0 / ratio, "", 1.0),
        ..fitted
    }
}

/// The radius of the driven wheels on the left of a robot whose axles are parallel, for a side of 1,
/// or on its right, for -1: that of a single one with its interval, else their mean; `None` without
/// any.
fn radius_of_side(
    robot: &Robot,
    fitted: &[(usize, &Value)],
    side: f64,
    mean: &dyn Fn(f64) -> Value,
) -> Option<Value> {
    // A wheel that turns forwards about its axis, which points to the left, drives ahead.
    let axle = robot.wheels.first()?.axis();
    let along_m = |wheel: &Wheel| wheel.position_m().xy().dot(&axle.xy());
    let middle_m = robot.wheels.iter().map(along_m).sum::<f64>() / robot.wheels.len() as f64;
    let is_there =
        |wheel: &Wheel| wheel.motor.effort_n_m > 0.0 && side * (along_m(wheel) - middle_m) > 0.0;
    let there: Vec<usize> = (0..robot.wheels.len())
        .filter(|wheel| is_there(&robot.wheels[*wheel]))
        .collect();
    let own = |wheel: usize| fitted.iter().find(|(known, _)| *known == wheel);
    if let [one] = there[..]
        && let Some((_, value)) = own(one)
    {
        return Some((*value).clone());
    }
    let radii_m = there
        .iter()
        .map(|wheel| own(*wheel).map_or(robot.wheels[*wheel].radius_m, |(_, value)| value.value));
    (!there.is_empty()).then(|| mean(radii_m.sum::<f64>() / there.len() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    /// A skid robot whose left wheels are 42 and 43 mm and whose right one of two was fitted to 40:
    /// its sides have 42.5 and 45 mm, in the mean of all 43.75. Turned by 90 degrees they stand
    /// ahead of and behind the origin, and their sides are the same.
    #[test]
    fn a_robot_that_is_held_sideways_has_one_radius_a_side() {
        let skid = include_str!("../../../../assets/robots/skid4.urdf");
        for turn_rad in [0.0, std::f64::consts::FRAC_PI_2] {
            let mut robot = Robot::from_urdf_str(skid, "robot").unwrap();
            let turn = nalgebra::Isometry3::rotation(turn_rad * Vector3::z());
            let mut fitted = Vec::new();
            for (index, wheel) in robot.wheels.iter_mut().enumerate() {
                let is_left = wheel.position_m().y > 0.0;
                let radius_m = match (is_left, wheel.position_m().x > 0.0) {
                    (true, true) => 0.042,
                    (true, false) => 0.043,
                    (false, true) => 0.040,
                    (false, false) => {
                        wheel.radius_m = 0.050;
                        wheel.body_from_hub = turn * wheel.body_from_hub;
                        continue;
                    }
                };
                wheel.body_from_hub = turn * wheel.body_from_hub;
                let value = Value::new(radius_m, Interval::around(radius_m, 1e-4), "m", 0.05);
                fitted.push((Parameter::WheelRadius(index), value));
            }
            let set = controller(&robot, &Gains::default(), &fitted).wheels;
            let sides: Vec<_> = set
                .iter()
                .map(|of| (&of.wheel[..], of.radius_m.value))
                .collect();
            let [("left", left_m), ("right", right_m)] = sides[..] else {
                panic!("{sides:?}")
            };
            assert!((left_m - 0.0425).abs() < 1e-12 && (right_m - 0.045).abs() < 1e-12);
            assert!((set[0].rate_factor - 0.04375 / 0.0425).abs() < 1e-12);
        }
    }

    /// ros2_controllers has one controller for four wheels with rollers at 45 degrees and equal
    /// arms, one for transverse rollers on wheels that face outward and are spread evenly, and none
    /// for others.
    #[test]
    fn the_controller_is_one_that_can_drive_the_robot() {
        let mecanum = include_str!("../../../../assets/robots/mecanum4.urdf");
        let omni = include_str!("../../../../assets/robots/volksbot.urdf");
        let of = |urdf: &str, change: &dyn Fn(&mut Robot)| {
            let mut robot = Robot::from_urdf_str(urdf, "robot").unwrap();
            change(&mut robot);
            kind(&robot)
        };
        let moved = |robot: &mut Robot| robot.wheels[0].body_from_hub.translation.x += 0.02;
        assert_eq!(of(mecanum, &|_| ()), Some(ControllerKind::Mecanum));
        assert_eq!(of(omni, &|_| ()), Some(ControllerKind::Omni));
        assert_eq!(of(mecanum, &|robot| robot.wheels[0].gamma_rad *= 0.7), None);
        assert_eq!(of(mecanum, &|robot| robot.wheels.truncate(3)), None);
        assert_eq!(of(mecanum, &moved), None);
        assert_eq!(of(omni, &moved), None);
    }

    /// Beside a fitted angle of the rollers, radius and lever are those of the fit: gains by
    /// direction hold what the angle does, and would correct it a second time.
    #[test]
    fn a_fitted_angle_of_the_rollers_is_named_with_what_was_fitted_beside_it() {
        let urdf = include_str!("../../../../assets/robots/mecanum4.urdf");
        let robot = Robot::from_urdf_str(urdf, "robot").unwrap();
        let fitted = |parameter: Parameter, value: f64| {
            let nominal = parameter.nominal(&robot);
            let value = Value::new(
                value,
                Interval::around(value, 1e-3),
                parameter.unit(),
                nominal,
            );
            (parameter, value)
        };
        let by_name = [("gain.ahead", 0.98), ("sideways_over_ahead", 1.09)]
            .map(|(name, gain)| (name.to_owned(), fitted(Parameter::Radius, gain).1));
        let gains = gains(&robot, &BTreeMap::from(by_name));
        let mut parameters = vec![
            fitted(Parameter::Radius, 0.049),
            fitted(Parameter::Lever, 0.31),
            fitted(Parameter::Gamma, 42.5),
        ];
        let value = |value: &Option<Value>| value.as_ref().map(|value| value.value);
        let found = controller(&robot, &gains, &parameters);
        assert_eq!(value(&found.gamma_deg), Some(42.5));
        assert_eq!(value(&found.radius_m), Some(0.049));
        assert_eq!(value(&found.lever_m), Some(0.31));
        assert_eq!(found.sideways_factor, None);
        parameters.truncate(2);
        let found = controller(&robot, &gains, &parameters);
        assert_eq!(value(&found.gamma_deg), None);
        let factor = value(&found.sideways_factor).unwrap();
        assert!((factor - 1.0 / 1.09).abs() < 1e-12, "{factor}");
    }
}
