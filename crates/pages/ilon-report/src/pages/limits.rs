//! Acceleration limits of a robot: the section of its page, and the limits as text.

use crate::drawing;
use crate::figure::{Figure, Layout, axis, exact_curve, plot, wheel_pen};
use crate::page::{self, Section, Table, card, escape};
use ilon_control::AccelerationPolytope;
use ilon_sim::inspect::Inspection;
use ilon_sim::simulate::{Limit, Limits};
use ilon_trace::significant;

/// Shares of the largest yaw acceleration at which the polytope is cut.
const TURN_SHARES: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// The section, if the limits were computed.
pub(super) fn section(seen: &Inspection) -> Option<Section> {
    let limits = seen.limits.as_ref()?;
    let cuts = limits
        .polytope
        .as_ref()
        .map(|polytope| card(&cuts(polytope)));
    let left_out = match limits.left_out.is_empty() {
        true => String::new(),
        false => format!(" Left out: {}.", limits.left_out.join(", ")),
    };
    let remarks: String = limits
        .remarks
        .iter()
        .map(|remark| format!(" But {remark}."))
        .collect();
    Some(Section {
        id: "limits",
        title: "How hard it may be driven",
        lead: format!(
            "Accelerations at which no wheel slides and no motor lacks torque, on a floor of friction {}.{}{}",
            limits.friction,
            escape(&remarks),
            escape(&left_out)
        ),
        body: format!(
            "<div class=\"grid\"><figure>{}</figure>\n{}</div>\n{}",
            drawing::limits(seen).unwrap_or_default(),
            cuts.unwrap_or_default(),
            page::table(&by_motion(limits))
        ),
    })
}

/// Cuts through the polytope at yaw accelerations.
fn cuts(polytope: &AccelerationPolytope) -> Figure {
    let top_rad_s2 = polytope
        .corners
        .iter()
        .map(|corner| corner.omega_rad_s)
        .fold(0.0, f64::max);
    let outlines = TURN_SHARES.iter().enumerate().map(|(index, share)| {
        let alpha_rad_s2 = share * top_rad_s2;
        let corners = polytope.at_yaw_acceleration(alpha_rad_s2);
        let closed = corners.iter().chain(corners.first()).map(|a| (a.x, a.y));
        let name = format!("turning by {alpha_rad_s2:.2} rad/s\u{b2}");
        exact_curve(&name, closed, wheel_pen(index))
    });
    Figure::new(
        "limits-cuts",
        "With turning, from rest",
        "Cuts through a polytope of accelerations that can be had, at shares of the largest in a turn. The JSON of the inspection has its \
         corners and half-spaces.",
        plot(
            outlines.collect(),
            Layout::of(axis("ahead in m/s\u{b2}"), axis("to the left in m/s\u{b2}")).equal(),
        ),
    )
    .height_px(420)
}

/// The limits by motion and speed, as text.
pub fn by_motion(limits: &Limits) -> Table {
    let head = [
        "motion", "speed", "up", "by", "wheel", "down", "by", "wheel",
    ];
    Table {
        title: "speed in m/s, speeding up and slowing down in m/s\u{b2}; turns in rad/s and rad/s\u{b2}".to_owned(),
        head: head.map(str::to_owned).to_vec(),
        rows: limits
            .rows
            .iter()
            .map(|row| {
                let of = |limit: &Limit| [number(limit.largest), limit.cause.to_owned(), limit.wheel.clone()];
                let beginning = [row.motion.clone(), number(row.speed)];
                let (up, down) = (of(&row.speeding_up), of(&row.slowing_down));
                beginning.into_iter().chain(up).chain(down).collect()
            })
            .collect(),
    }
}

/// Rounds to three digits: friction and masses are known to a percent at best.
fn number(x: f64) -> String {
    match x.abs() {
        size if size >= 100.0 => format!("{x:.0}"),
        size if size >= 10.0 => format!("{x:.1}"),
        size if size >= 1.0 => format!("{x:.2}"),
        size if size == 0.0 || size >= 0.1 => format!("{x:.3}"),
        _ => significant(x, 3).to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_have_three_digits() {
        assert_eq!(number(123.456), "123");
        assert_eq!(number(50.349), "50.3");
        assert_eq!(number(-1.23456), "-1.23");
        assert_eq!(number(0.1), "0.100");
        assert_eq!(number(0.000_423_49), "0.000423");
        assert_eq!(number(0.0), "0.000");
    }
}
