//! Robots on springs, arms and rockers in both engines.

use ilon_oracle::Plate;
use ilon_robot::{Robot, Twist};
use nalgebra::Vector2;

use crate::oracle::case::{Case, Wheels, ramp};
use crate::oracle::course::Course;
use crate::oracle::engines::{Springs, in_ilon, on_springs};
use crate::support::linked::{on_a_rocker, on_arms, on_slides};

/// The mean over a time span of values in rows.
fn mean(
    course: &Course,
    (from_s, until_s): (f64, f64),
    of: impl Fn(&crate::oracle::course::Row) -> f64,
) -> f64 {
    let rows = course.rows.iter();
    let shown: Vec<f64> = rows
        .filter(|row| row.t_s > from_s && row.t_s <= until_s)
        .map(of)
        .collect();
    shown.iter().sum::<f64>() / shown.len() as f64
}

/// Loads of the wheels, then roll and pitch, then joints, each the mean over a time span.
fn means(course: &Course, over: (f64, f64)) -> (Vec<f64>, [f64; 2], Vec<f64>) {
    let row = course.end();
    let loads = (0..row.loads_n.len()).map(|w| mean(course, over, |row| row.loads_n[w]));
    let leans = [1, 2].map(|at| mean(course, over, |row| row.stands[at]));
    let joints = (0..row.joints.len()).map(|j| mean(course, over, |row| row.joints[j]));
    (loads.collect(), leans, joints.collect())
}

/// The lean of a robot on contacts of 2e7 N/m, in rad, and the motion of a joint, in rad or m.
const GIVES: f64 = 5e-6;

/// Asserts that both engines have the same loads over a time span, within a share of a wheel's
/// mean, the same lean within a share of the largest angle in either, and likewise the same joint
/// positions.
fn alike(case: &Case, over: (f64, f64), within: f64) {
    let springs = Springs {
        stiffness_n_m: 2e7,
        step_s: 4e-6,
    };
    let courses = [on_springs(case, springs), in_ilon(case, 5e-4, None)];
    let [oracle, ilon] = courses.each_ref().map(|course| means(course, over));
    println!("{}: oracle {oracle:.5?}", case.name);
    println!("{}: ilon   {ilon:.5?}", case.name);
    let on_each_n = case.robot.mass_kg() * 9.81 / oracle.0.len() as f64;
    for (a, b) in oracle.0.iter().zip(&ilon.0) {
        assert!((a - b).abs() < within * on_each_n, "loads {a} and {b} N");
    }
    // Without a lean, the sag of the oracle's softer contacts remains: 1.4 um.
    let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let (lean, moved) = (largest(&oracle.1), largest(&oracle.2));
    for (a, b) in oracle.1.iter().zip(&ilon.1) {
        assert!(
            (a - b).abs() < within * lean + GIVES,
            "lean {a} and {b} rad"
        );
    }
    for (a, b) in oracle.2.iter().zip(&ilon.2) {
        assert!((a - b).abs() < within * moved + GIVES, "joints {a} and {b}");
    }
    let [drives, slips] = [
        courses.each_ref().map(|course| course.end().sums.drives_j),
        courses.each_ref().map(|course| course.end().sums.slip_j),
    ];
    println!("{}: drives {drives:.4?} J, slip {slips:.4?} J", case.name);
}

/// Ahead within half a second; from 0.9 s on it brakes at 3 m/s^2.
fn braking(name: &str, robot: Robot) -> Case {
    let ahead = Twist::new(0.9, 0.0, 0.0);
    let start = ramp(ahead, 0.1, 0.5);
    Case::new(name, robot, 0.8, 1.15, move |t_s| {
        Wheels::Follow(if t_s < 0.9 {
            start(t_s)
        } else {
            ahead.scaled((1.0 - (t_s - 0.9) / 0.3).max(0.0))
        })
    })
}

#[test]
fn arms_and_slides_bear_braking_alike_in_both_engines() {
    alike(&braking("arms", on_arms(60.0)), (0.9525, 1.1475), 1e-3);
    alike(&braking("slides", on_slides(60.0)), (0.9525, 1.1475), 1e-3);
}

/// A leaning wheel drops from roller to roller. A step with such a drop must count neither the load
/// nor the impact twice. The drives of a robot on slides that leans by 0.017 rad do the same work
/// in both engines, within the small change that each has with its own settings.
#[test]
fn leaning_wheels_cost_alike_in_both_engines() {
    let mut robot = on_slides(60.0);
    robot.chassis.mass.center_of_mass_m.y += 0.08;
    let target = ramp(Twist::new(0.4, 0.0, 0.0), 0.1, 0.3);
    let case = Case::new("leaning", robot, 0.8, 1.5, move |t_s| {
        Wheels::Follow(target(t_s))
    });
    let oracle = [(8e6, 6e-6), (2e7, 4e-6)].map(|(stiffness_n_m, step_s)| {
        let springs = Springs {
            stiffness_n_m,
            step_s,
        };
        on_springs(&case, springs).end().sums.drives_j
    });
    let ilon = [2.5e-3, 1.25e-3].map(|dt_s| in_ilon(&case, dt_s, None).end().sums.drives_j);
    println!("leaning: oracle {oracle:.4?}, ilon {ilon:.4?} J");
    let changed_j = (ilon[0] - ilon[1]).abs();
    let unknown_j = (oracle[0] - oracle[1]).abs() + changed_j;
    assert!((ilon[1] - oracle[1]).abs() < unknown_j, "{unknown_j} J");
    // The load of a wheel over half a step of each of the 62 drops, at about 40 mm/s, is 6 % of the
    // work at 2.5 ms. With half of the drops late and half early, at most a sixth of that remains.
    assert!(changed_j < 0.01 * ilon[1], "{changed_j} J");
}

#[test]
fn a_rocker_bears_a_load_off_centre_alike_in_both_engines() {
    let mut robot = on_a_rocker(0.3);
    robot.chassis.mass.center_of_mass_m.x += 0.03;
    robot.chassis.mass.center_of_mass_m.y += 0.04;
    let mut case = braking("rocker, load off centre", robot);
    alike(&case, (0.9525, 1.1475), 1e-3);
    case.wheels = Box::new(|_| Wheels::Follow(Twist::default()));
    case.duration_s = 0.4;
    case.name = "rocker, load off centre, standing".to_owned();
    alike(&case, (0.3025, 0.3975), 2e-4);
}

#[test]
fn a_kerb_under_one_wheel_loads_springs_and_rockers_alike_in_both_engines() {
    for (name, robot) in [("slides", on_slides(120.0)), ("rocker", on_a_rocker(0.3))] {
        let at_m = robot.wheels[2].position_m().xy();
        let half_m = Vector2::new(0.06, 0.06);
        let mut case = Case::new(name, robot, 0.8, 0.5, |_| Wheels::Follow(Twist::default()));
        case.plates = vec![Plate {
            from_m: at_m - half_m,
            to_m: at_m + half_m,
            height_m: 0.005,
        }];
        alike(&case, (0.4025, 0.4975), 1e-3);
    }
}

/// Sideways at 1 m/s over ten bars, 3 mm high and 20 mm wide.
fn over_bars(name: &str, robot: Robot) -> Case {
    let target = ramp(Twist::new(0.0, 1.0, 0.0), 0.1, 0.5);
    let mut case = Case::new(name, robot, 0.6, 2.2, move |t_s| {
        Wheels::Follow(target(t_s))
    });
    case.plates = (0..10)
        .map(|bar| {
            let y_m = 0.4 + 0.1 * f64::from(bar);
            Plate {
                from_m: Vector2::new(-1.0, y_m),
                to_m: Vector2::new(1.0, y_m + 0.02),
                height_m: 0.003,
            }
        })
        .collect();
    case
}

/// Energy dissipated by contacts along the ground, and in total, in J.
fn lost_j(course: &Course) -> [f64; 2] {
    let sums = course.end().sums;
    // The oracle's bristles dissipate the energy of spinning up rollers, which is slip in ilon.
    [sums.along_ground_j, sums.slip_j + sums.other_j]
}

/// Asserts that both engines lose the same energy over ten bars, along the ground and in total,
/// within a twentieth plus the change that each has with its own settings: the oracle with its two
/// contacts, each a stiffness, a step and a damping factor, ilon with steps of 0.5 and 0.25 ms.
///
/// The share of an impact at an edge along the ground depends on its progress, which a step that
/// contains the whole impact cannot resolve. If impacts throw the robot, each decides where the
/// next one is.
fn bars_cost_alike(name: &str, robot: Robot, contacts: [(f64, f64, f64); 2]) {
    let mut case = over_bars(name, robot);
    let oracle = contacts.map(|(stiffness_n_m, step_s, damped)| {
        case.damped[0] = damped;
        let springs = Springs {
            stiffness_n_m,
            step_s,
        };
        lost_j(&on_springs(&case, springs))
    });
    let ilon = [5e-4, 2.5e-4].map(|dt_s| lost_j(&in_ilon(&case, dt_s, None)));
    println!("{name}: oracle {oracle:.4?}, ilon {ilon:.4?} J");
    for of in 0..2 {
        let unknown_j = (oracle[0][of] - oracle[1][of]).abs() + (ilon[0][of] - ilon[1][of]).abs();
        let apart_j = (ilon[1][of] - oracle[1][of]).abs();
        assert!(
            apart_j < 0.05 * oracle[1][of] + unknown_j,
            "{apart_j} J apart, {unknown_j} J not known"
        );
    }
}

/// Wheels on springs stay on the ground: softer and stiffer contacts of the oracle give nearly the
/// same.
#[test]
fn ten_bars_cost_a_sprung_robot_alike_in_both_engines() {
    let contacts = [(8e6, 6e-6, 1.0), (2e7, 4e-6, 1.0)];
    bars_cost_alike("slides", on_slides(60.0), contacts);
}

/// Contacts of the oracle with a damping ratio of 0.7 throw wheels back with a fifth of their
/// speed, those with twice the damping hardly.
const BOUNCING_OR_NOT: [(f64, f64, f64); 2] = [(8e6, 6e-6, 1.0), (8e6, 2.5e-6, 2.0)];

#[test]
#[ignore = "minutes: .ci/nightly"]
fn ten_bars_cost_a_rocking_robot_alike_in_both_engines() {
    bars_cost_alike("rocker", on_a_rocker(0.3), BOUNCING_OR_NOT);
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn ten_bars_cost_a_rigid_robot_alike_in_both_engines() {
    let rigid = crate::support::robot("mecanum4");
    bars_cost_alike("rigid", rigid, BOUNCING_OR_NOT);
}
