//! Compliant rollers: ilon's treads against the oracle's springs of the same stiffness and damping,
//! over a range of stiffnesses.

use crate::oracle::case::Case;
use crate::oracle::cases::{coasting, one_wheel_locked, steady, twist};
use crate::oracle::course::Course;
use crate::oracle::engines::{Springs, in_ilon, on_springs, on_treads};

fn cases() -> Vec<Case> {
    vec![
        coasting("coasting ahead from 0.5 m/s", twist(0.5, 0.0, 0.0)),
        coasting("coasting sideways from 0.5 m/s", twist(0.0, 0.5, 0.0)),
        coasting("coasting yaw from 3 rad/s", twist(0.0, 0.0, 3.0)),
        one_wheel_locked("one wheel locked, 0.4 m/s ahead", twist(0.4, 0.0, 0.0)),
        one_wheel_locked("one wheel locked, 0.4 m/s sideways", twist(0.0, 0.4, 0.0)),
        steady("steady turn, 1 rad/s", "mecanum4", twist(0.0, 0.0, 1.0)),
    ]
}

/// The step of ilon, which resolves its treads' springs, in seconds.
const STEP_S: f64 = 2.5e-4;

/// Both engines on springs of one stiffness, each at a step and at half of it.
struct Beside {
    ilon: [Course; 2],
    oracle: [Course; 2],
    arm_m: f64,
}

impl Beside {
    fn of(case: &Case, springs: Springs) -> Self {
        let stiffness_n_m = springs.stiffness_n_m;
        let half = Springs {
            step_s: 0.5 * springs.step_s,
            ..springs
        };
        Self {
            ilon: [STEP_S, 0.5 * STEP_S].map(|step_s| on_treads(case, stiffness_n_m, step_s)),
            oracle: [springs, half].map(|springs| on_springs(case, springs)),
            arm_m: case.arm_m(),
        }
    }

    fn apart_m(&self) -> f64 {
        self.ilon[1].worst_m(&self.oracle[1], self.arm_m)
    }

    fn way_m(&self) -> f64 {
        self.oracle[1].way_m(self.arm_m)
    }

    /// The uncertainty of both after halving the steps: methods of first order are off by at most
    /// the change of the last halving.
    fn within_m(&self) -> f64 {
        let [ilon, oracle] = [&self.ilon, &self.oracle];
        ilon[0].worst_m(&ilon[1], self.arm_m) + oracle[0].worst_m(&oracle[1], self.arm_m)
    }

    fn heats_j(&self) -> [f64; 2] {
        [&self.ilon[1], &self.oracle[1]].map(|course| {
            let sums = course.end().sums;
            sums.slip_j + sums.other_j
        })
    }

    fn work_j(&self) -> [f64; 2] {
        [&self.ilon[1], &self.oracle[1]].map(|course| course.end().sums.drives_j)
    }
}

fn place(course: &Course) -> String {
    let end = course.end();
    format!(
        "{:.1}, {:.1}, {:.2}°",
        1e3 * end.position_m.x,
        1e3 * end.position_m.y,
        end.heading_rad.to_degrees()
    )
}

/// Allowed difference over the path, in addition to the uncertainty of the steps: a sixtieth of the
/// change by treads of 2e5 N/m, and as much as the change by those of 2e7 N/m.
const OF_THE_WAY: f64 = 1e-3;

/// Asserts that both agree within their uncertainties.
pub fn agree(case: &Case, stiffness_n_m: f64) {
    agree_on(case, Springs::of(stiffness_n_m));
}

/// Asserts that both agree on these springs.
pub fn agree_on(case: &Case, springs: Springs) {
    let (beside, stiffness_n_m) = (Beside::of(case, springs), springs.stiffness_n_m);
    let (apart_m, within_m, way_m) = (beside.apart_m(), beside.within_m(), beside.way_m());
    let ([heat_j, of_oracle_j], [work_j, work_of_oracle_j]) = (beside.heats_j(), beside.work_j());
    println!(
        "| {}, {stiffness_n_m:.0e} N/m | {} | {} | {:.2} | {:.3} % | {:.2} | {heat_j:.3}, {of_oracle_j:.3} | {work_j:.3}, {work_of_oracle_j:.3} |",
        case.name,
        place(&beside.ilon[1]),
        place(&beside.oracle[1]),
        1e3 * apart_m,
        100.0 * apart_m / way_m,
        1e3 * within_m,
    );
    assert!(
        apart_m < within_m + OF_THE_WAY * way_m,
        "{}: {apart_m} m apart, {within_m} m known",
        case.name
    );
    assert!((work_j / work_of_oracle_j - 1.0).abs() < 0.01);
}

#[test]
fn a_robot_on_treads_coasts_as_on_springs() {
    let [_, sideways, ..] = &cases()[..] else {
        return;
    };
    agree(sideways, 2e6);
}

/// Damped as ilon damps its own treads, little along the normal and much across it for the light
/// rollers: 5e4 N/m under 2.84 kg get 75 and 50 N s/m. A bristle that slides then lags by 1.5 ms,
/// many steps. If it followed at once, the end would move by 13 mm from steps of 1 ms to those of
/// 125 us.
#[test]
fn at_any_step_a_robot_drives_on_damped_treads_as_on_springs() {
    let mut case = steady("damped as by default", "mecanum4", twist(0.35, 0.15, 0.4));
    case.damped = [0.14, 4.1];
    let springs = Springs {
        step_s: 1e-5,
        ..Springs::of(5e4)
    };
    let oracle = on_springs(&case, springs);
    for step_s in [1e-3, 1.25e-4] {
        let treads = on_treads(&case, 5e4, step_s);
        let apart_m = treads.worst_m(&oracle, case.arm_m());
        // Steps of 1 ms resolve hand-overs to half a millimetre on a way of 1.4 m.
        assert!(apart_m < 1e-3, "{step_s} s: {apart_m} m");
        let [sums, of_oracle] = [&treads, &oracle].map(|course| course.end().sums);
        let ratio = sums.along_ground_j / of_oracle.along_ground_j;
        assert!((ratio - 1.0).abs() < 0.01, "{step_s} s: {ratio}");
    }
}

#[test]
#[ignore = "minutes: all cases at three stiffnesses"]
fn table() {
    println!(
        "| case, springs | ilon's treads: end in mm | oracle's springs | apart mm | of the way | known within mm | heat of contacts J | work of the drives J |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for case in cases() {
        println!(
            "| {}, rigid | {} | | | | | | |",
            case.name,
            place(&in_ilon(&case, STEP_S, None))
        );
        for stiffness_n_m in [2e5, 2e6, 2e7] {
            agree(&case, stiffness_n_m);
        }
    }
}

/// The sliding heat of a step that does not resolve the springs is at most the total heat of the
/// contacts.
#[test]
fn long_steps_book_no_more_sliding_than_contacts_take() {
    let case = coasting("coasting sideways from 0.5 m/s", twist(0.0, 0.5, 0.0));
    for (stiffness_n_m, step_s) in [(2e5, 2.5e-3), (2e6, 2.5e-3), (2e7, 2.5e-3), (2e7, 1e-3)] {
        let sums = on_treads(&case, stiffness_n_m, step_s).end().sums;
        println!("{stiffness_n_m:.0e} N/m, {step_s} s: {sums:?}");
        let all_j = sums.slip_j + sums.other_j;
        assert!(
            sums.slip_j > 0.0 && sums.slip_j < all_j,
            "{stiffness_n_m:.0e} N/m in {step_s} s: {} J of sliding, {all_j} J in all",
            sums.slip_j
        );
    }
}
