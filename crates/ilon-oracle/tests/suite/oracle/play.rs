//! Rollers with play along their axles, in both engines: the oracle lets a roller without mass go where floor and stops balance, on
//! springs, and lays it down at its lower end while it is in the air.

use nalgebra::Vector3;

use crate::oracle::case::{Case, Shove, Wheels, ramp, robot};
use crate::oracle::cases::twist;
use crate::oracle::engines::{Springs, in_ilon, on_springs, on_treads};
use ilon_robot::Twist;

const PLAY_M: f64 = 5e-4;

/// Half a second of ramp and one of drive, with a force in N along the way from the end of the ramp on.
fn drive(name: &str, play_m: f64, end: Twist, force_n: f64) -> Case {
    let mut robot = robot("mecanum4");
    for wheel in &mut robot.wheels {
        wheel.surface.axial_play_m = play_m;
    }
    let target = ramp(end, 0.0, 0.5);
    let mut case = Case::new(name, robot, 0.8, 1.5, move |t_s| {
        Wheels::Follow(target(t_s))
    });
    let along = Vector3::new(end.vx_m_s, end.vy_m_s, 0.0).normalize();
    case.shove = Some(Shove {
        force_in_world_n: force_n * along,
        from_s: 0.5,
        until_s: 1.5,
    });
    case
}

fn cases(play_m: f64) -> Vec<Case> {
    let (ahead, sideways) = (twist(0.2, 0.0, 0.0), twist(0.0, 0.2, 0.0));
    vec![
        drive("ahead", play_m, ahead, 0.0),
        drive("ahead, held back", play_m, ahead, -30.0),
        drive("ahead, pushed", play_m, ahead, 30.0),
        drive("back, held back", play_m, twist(-0.2, 0.0, 0.0), -30.0),
        drive("sideways", play_m, sideways, 0.0),
        drive("sideways, held back", play_m, sideways, -30.0),
        drive("sideways, pushed", play_m, sideways, 30.0),
    ]
}

/// What play changes of the way is the same in both engines.
#[test]
fn play_takes_of_the_way_what_it_takes_on_springs() {
    for (case, tight) in cases(PLAY_M).into_iter().zip(cases(0.0)) {
        let arm_m = case.arm_m();
        let springs = [2e6, 8e6].map(|stiffness| on_springs(&case, Springs::of(stiffness)));
        let without = on_springs(&tight, Springs::of(8e6));
        let steps = [5e-4, 2.5e-4].map(|step_s| in_ilon(&case, step_s, None));
        let treads = on_treads(&case, 8e6, 2.5e-4);
        let rigid = in_ilon(&tight, 2.5e-4, None);
        let end = |course: &crate::oracle::course::Course| course.end().position_m.norm();
        println!(
            "| {} | {:.3} | {:.3} | {:.3} | {:.3}, {:.3} | {:.3}, {:.3} | {:.3} |",
            case.name,
            1e3 * end(&rigid),
            1e3 * end(&without),
            1e3 * end(&treads),
            1e3 * end(&steps[0]),
            1e3 * end(&steps[1]),
            1e3 * end(&springs[0]),
            1e3 * end(&springs[1]),
            1e3 * steps[1].worst_m(&springs[1], arm_m),
        );
        // Springs of a quarter of the stiffness and twice the step say what is known of both; beside it a seventh of what the play takes: ilon
        // knows a roller that comes down, and a stop that is hit, by its step of a quarter of a millisecond, the oracle by one of 8 us.
        let taken_m = (end(&without) - end(&springs[1])).abs();
        let within_m = springs[0].worst_m(&springs[1], arm_m);
        let apart_m = treads.worst_m(&springs[1], arm_m);
        assert!(
            apart_m < within_m + taken_m / 7.0,
            "{}: {apart_m} {within_m} {taken_m}",
            case.name
        );
    }
}
