//! The table of docs/oracle.md.

use crate::cases;
use crate::course::Course;
use crate::engines::{Springs, on_springs};
use crate::limit;

fn end(course: &Course) -> String {
    let end = course.end();
    let (x, y, heading) = (
        1e3 * end.position_m.x,
        1e3 * end.position_m.y,
        end.heading_rad.to_degrees(),
    );
    let turned = heading.abs() > 0.1;
    let moved = end.position_m.norm() > 1e-3;
    match (moved, turned) {
        (true, true) => format!("{x:.1}, {y:.1}, {heading:.2}°"),
        (true, false) => format!("{x:.1}, {y:.1}"),
        _ => format!("{heading:.2}°"),
    }
}

#[test]
#[ignore = "prints the table of docs/oracle.md; minutes with --release"]
fn transients_and_coasting() {
    println!(
        "| case | ilon, 0.25 ms | oracle, 2e6 N/m | oracle, rigid limit | apart mm | of the way | expected mm | heat of sliding J | sliding from, until s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for case in cases::table() {
        let soft = on_springs(&case, Springs::of(2e6));
        let (ilon, rigid) = (limit::ilon(&case, 5e-4), limit::rigid(&case));
        let arm_m = case.arm_m();
        let apart_m = ilon.course.worst_m(&rigid.course, arm_m);
        let slides = |course: &Course| match course.slide_s(0.02) {
            Some((from, until)) => format!("{from:.3}, {until:.3}"),
            None => "-".into(),
        };
        println!(
            "| {} | {} | {} | {} | {:.2} | {:.3} % | {:.2} + {:.2} | {:.3}, {:.3} | {}; {} |",
            case.name,
            end(&ilon.course),
            end(&soft),
            end(&rigid.course),
            1e3 * apart_m,
            1e2 * apart_m / rigid.course.way_m(arm_m),
            1e3 * ilon.within_m,
            1e3 * rigid.within_m,
            ilon.course.end().sums.slip_j,
            rigid.course.end().sums.slip_j,
            slides(&ilon.course),
            slides(&rigid.course),
        );
    }
}
