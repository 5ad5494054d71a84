//! Rollers that give: ilon's treads against the oracle's springs of the same stiffness and damping, at any of them.

use crate::case::Case;
use crate::cases::{coasting, one_wheel_locked, steady, twist};
use crate::course::Course;
use crate::engines::{Springs, in_ilon, on_springs, on_treads};

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

fn said(course: &Course) -> String {
    let end = course.end();
    let speed = course.last_speed_m_s();
    format!(
        "{:8.1} {:8.1} {:8.2} deg, {:6.3} m/s {:6.3} rad/s, work {:6.3} slip {:6.3} other {:6.3} J",
        1e3 * end.position_m.x,
        1e3 * end.position_m.y,
        end.heading_rad.to_degrees(),
        speed,
        end.yaw_rate_rad_s,
        end.sums.drives_j,
        end.sums.slip_j,
        end.sums.other_j,
    )
}

#[test]
#[ignore = "minutes: prints treads beside the oracle's springs"]
fn table() {
    for case in cases() {
        println!("{}", case.name);
        println!(
            "  rigid             {}",
            said(&in_ilon(&case, 2.5e-4, None))
        );
        for stiffness_n_m in [2e5, 2e6, 2e7] {
            let springs = Springs::of(stiffness_n_m);
            println!(
                "  {stiffness_n_m:.0e} oracle      {}",
                said(&on_springs(&case, springs))
            );
            for step_s in [2.5e-3, 1e-3, 2.5e-4] {
                let course = on_treads(&case, stiffness_n_m, step_s);
                println!(
                    "  {stiffness_n_m:.0e} ilon {:4} us {}",
                    1e6 * step_s,
                    said(&course)
                );
            }
        }
    }
}
