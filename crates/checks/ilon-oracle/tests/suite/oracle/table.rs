//! The table of docs/measured.md.

use crate::oracle::cases;
use crate::oracle::course::Course;
use crate::oracle::engines::{Springs, on_springs};
use crate::oracle::limit;

/// The end of a course: x and y in mm if it moves, the heading if it turns.
fn end(course: &Course) -> String {
    let end = course.end();
    // Adding zero turns -0 into 0.
    let tenths = |value: f64| (10.0 * value).round() / 10.0 + 0.0;
    let (x, y) = (
        tenths(1e3 * end.position_m.x),
        tenths(1e3 * end.position_m.y),
    );
    let heading = end.heading_rad.to_degrees();
    match (end.position_m.norm() > 1e-3, heading.abs() > 0.1) {
        (true, true) => format!("{x:.1}, {y:.1}, {heading:.2}°"),
        (true, false) => format!("{x:.1}, {y:.1}"),
        _ => format!("{heading:.2}°"),
    }
}

#[test]
#[ignore = "prints the table of docs/measured.md; minutes with --release"]
fn transients_and_coasting() {
    println!(
        "\n| case | ilon, 0.25 ms | oracle, 2e6 N/m | oracle, rigid limit | apart mm | of the way | expected mm \
         | heat of sliding J | longest slide from, until s |"
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
