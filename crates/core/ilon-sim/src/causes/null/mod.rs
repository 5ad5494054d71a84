//! The possible causes of a difference, and the null of each: the scenario and the robot without
//! it.
//!
//! | file | causes |
//! |---|---|
//! | `list` | a list of causes |
//! | `scene` | what the scenario names: faults, ground, bodies, sensors, joints moved by setpoints |
//! | `machine` | what every robot has: rollers, bearings, casters, steering, motors, wheel loops, control |

mod list;
mod machine;
mod scene;

use ilon_trace::Cause;

use crate::scenario::MotorStrength;

use list::List;
pub(crate) use list::Null;
pub(super) use list::Run;

/// The causes that a scenario names: faults, ground and bodies, moving joints, sensor errors.
pub(super) fn named(run: Run) -> Vec<(Cause, Null)> {
    let mut list = List::default();
    scene::faults(run.header, &mut list);
    scene::ground(&run.scenario.world.floor, &mut list);
    scene::bodies(run.scenario, &mut list);
    scene::sensors(run.scenario, &mut list);
    scene::joints(run, true, &mut list);
    scene::held_modules(run, &mut list);
    let strengths = &run.scenario.motors.wheels;
    if !strengths.is_empty() {
        let of_wheel = |(name, strength): (&String, &MotorStrength)| {
            let percent = |share: f64| format!("{} %", ilon_trace::number(100.0 * share));
            let [forwards, backwards] = [strength.forwards, strength.backwards].map(percent);
            match forwards == backwards {
                true => format!("`{name}` at {forwards}"),
                false => format!("`{name}` at {forwards} forwards and {backwards} backwards"),
            }
        };
        let wheels: Vec<String> = strengths.iter().map(of_wheel).collect();
        let words = format!("motors that differ ({})", wheels.join(", "));
        list.add("motors.wheels", words, |scenario, _| {
            scenario.motors.wheels.clear();
        });
    }
    if let Some(belief) = &run.header.belief {
        list.add(
            "controller.robot",
            format!("what the controller believes of the robot ({belief})"),
            |scenario, _| scenario.controller.robot = None,
        );
    }
    list.0
}

/// All causes: those of [`named`] and those that every robot has.
pub(super) fn all(run: Run) -> Vec<(Cause, Null)> {
    let (scenario, robot) = (run.scenario, run.robot);
    let mut list = List(named(run));
    scene::joints(run, false, &mut list);
    machine::of_rollers(scenario, robot, &mut list);
    machine::of_tyres(run, &mut list);
    machine::of_drive(scenario, robot, &mut list);
    machine::of_control(scenario, run.physics_dt_s, &mut list);
    list.0
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;
    use ilon_robot::Robot;

    use super::*;
    use crate::scenario::Scenario;

    #[test]
    fn motors_that_differ_are_named_once_where_they_are_as_strong_both_ways() {
        let text = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1.0\n[motors.wheels]\n\
            front_left = { forwards = 0.5, backwards = 0.5 }\nrear_left = { forwards = 0.5, backwards = 0.75 }";
        let urdf = include_str!("../../../../../../assets/robots/mecanum4.urdf");
        let causes = named(Run {
            scenario: &Scenario::from_toml(text, "test", "").expect("a scenario"),
            robot: &Robot::from_urdf_str(urdf, "mecanum4").expect("a robot"),
            header: &ilon_trace::Header::default(),
            stands: &[],
            physics_dt_s: 1e-3,
        });
        let words: Vec<&str> = causes
            .iter()
            .map(|(cause, _)| cause.words.as_str())
            .collect();
        let expected = "motors that differ (`front_left` at 50 %, `rear_left` at 50 % forwards and 75 % backwards)";
        assert_eq!(words, [expected]);
    }
}
