//! Whether the slope moved the robot downhill: by sliding, by creeping contacts, or by yielding
//! wheels.

use ilon_trace::{Header, Summary};

use super::events::{Event, EventKind};
use crate::text::{length, speed};

/// Smaller slopes count as level, in radians.
const LEAST_SLOPE_RAD: f64 = 1e-3;
/// A slope that uses this share of the friction is the cause of sliding downhill.
const LARGE_PART: f64 = 0.5;
/// Less sliding downhill is not reported, in metres.
const LEAST_SLID_M: f64 = 5e-3;
/// The same for creep and yielding wheels, in metres.
const LEAST_CREPT_M: f64 = 5e-5;
/// A robot that ends slower than this is at rest, in m/s; creep is not faster.
const AT_REST_M_S: f64 = 1e-3;
/// A cause of at least this share of the total path is the main cause.
const MOSTLY: f64 = 0.8;

/// Reports the effect of the slope as HTML, and whether it is the run's main explanation; the robot
/// ends the run at this speed.
pub(super) fn sentence(
    header: &Header,
    summary: &Summary,
    events: &[Event],
    ends_at_m_s: f64,
) -> Option<(String, bool)> {
    let ground = header.ground.as_ref()?;
    let slope_rad = ground.slope_rad;
    if slope_rad.abs() < LEAST_SLOPE_RAD {
        return None;
    }
    // The floor falls towards +x. The terms of the ledger are commanded minus actual.
    let downhill = slope_rad.signum();
    let ledger = &summary.ledger;
    let (slid_m, gave_m) = (-downhill * ledger.slip.x_m, -downhill * ledger.servo.x_m);
    let falls = format!(
        "The floor falls by <b>{:.1}°</b> towards {}x",
        slope_rad.abs().to_degrees(),
        if downhill > 0.0 { "+" } else { "−" }
    );
    let part = slope_rad.abs().tan() / ground.friction;
    if slid_m > LEAST_SLID_M && part > LARGE_PART {
        let too_much = if part > 1.0 {
            format!(
                ", steeper than friction {} can hold ({:.1}°)",
                ilon_trace::significant(ground.friction, 3),
                ground.friction.atan().to_degrees()
            )
        } else {
            let held = ground.friction * held_at_best(header, downhill, summary.end_heading_rad);
            format!(
                ", {:.0} % of what its rollers can hold in this direction on friction {} (up to {:.1}°)",
                100.0 * slope_rad.abs().tan() / held,
                ilon_trace::significant(ground.friction, 3),
                held.atan().to_degrees()
            )
        };
        return Some((
            format!(
                "{falls}{too_much}: the robot slid <b>{} downhill</b>.",
                length(slid_m)
            ),
            true,
        ));
    }
    // Motion that a controller corrects at once, and slides for other reasons, are not due to the
    // slope.
    let slides = events.iter().any(|e| matches!(e.kind, EventKind::Slide(_)));
    if !header.open_loop || slides {
        return None;
    }
    let mut causes = Vec::new();
    if slid_m > LEAST_CREPT_M && slid_m > MOSTLY * ledger.slip.path_m {
        // By creep of the contacts, or by play of the rollers; faster while the robot drives.
        let rests = summary.travelled_m < 2.0 * (slid_m + gave_m.max(0.0));
        let rate_mm_s = 1e3 * slid_m / summary.duration_s.max(1e-9);
        let at = rests.then(|| format!(", at {rate_mm_s:.3} mm/s"));
        causes.push(format!(
            "it crept <b>{}</b> downhill{}",
            length(slid_m),
            at.unwrap_or_default()
        ));
    }
    // Turning wheels lag for other reasons.
    if gave_m > LEAST_CREPT_M && summary.travelled_m < 2.0 * (gave_m + slid_m.max(0.0)) {
        causes.push(match ends_at_m_s < AT_REST_M_S {
            true => format!(
                "the wheels gave way by <b>{}</b> until their loops held the weight",
                length(gave_m)
            ),
            false => format!(
                "the wheels gave way by <b>{}</b>, and their motors do not hold the weight: at the end the robot goes at <b>{}</b>",
                length(gave_m),
                speed(ends_at_m_s)
            ),
        });
    }
    (!causes.is_empty()).then(|| (format!("{falls}: {}.", causes.join("; ")), false))
}

/// Returns the share of friction that the rollers can use downhill, for a robot that stands level
/// and equally on all wheels at a heading: each contact holds only along its roller's axis d.
///
/// Forces of up to 1 / n along n axes reach the boundary of a polygon; its sides are perpendicular
/// to normals n_k of the axes, at the distance sum |n_k . d| / n, so along e it reaches the
/// smallest of these over |n_k . e|.
fn held_at_best(header: &Header, downhill: f64, heading_rad: Option<f64>) -> f64 {
    let axes: Vec<[f64; 2]> = header
        .wheels
        .iter()
        .map(|wheel| {
            // The roller rolls at gamma from the hub axis; its own axis is perpendicular to that.
            let (sin, cos) = wheel.gamma_rad.sin_cos();
            let [x, y] = wheel.axis;
            [-(sin * x + cos * y), cos * x - sin * y]
        })
        .collect();
    let (sin, cos) = heading_rad.unwrap_or(0.0).sin_cos();
    let along = [downhill * cos, -downhill * sin];
    let reached = axes.iter().map(|[x, y]| {
        let normal = [-y, *x];
        let dot = |of: &[f64; 2]| (normal[0] * of[0] + normal[1] * of[1]).abs();
        axes.iter().map(dot).sum::<f64>() / axes.len() as f64 / dot(&along)
    });
    reached.fold(1.0, f64::min)
}

#[cfg(test)]
mod tests {
    use ilon_trace::Ground;
    use ilon_trace::ledger::Integral;

    use super::*;

    /// An open-loop run on a slope with friction 0.6 and given displacements by slip and by servo,
    /// along x.
    fn said(slope_deg: f64, slip_m: f64, servo_m: f64) -> Option<(String, bool)> {
        ended(slope_deg, slip_m, servo_m, 0.0)
    }

    fn ended(
        slope_deg: f64,
        slip_m: f64,
        servo_m: f64,
        ends_at_m_s: f64,
    ) -> Option<(String, bool)> {
        let header = Header {
            open_loop: true,
            ground: Some(Ground {
                friction: 0.6,
                slope_rad: slope_deg.to_radians(),
                ..Ground::default()
            }),
            ..Header::default()
        };
        let term = |x_m: f64| Integral {
            x_m: -x_m,
            path_m: x_m.abs(),
            ..Integral::default()
        };
        let mut summary = Summary::default();
        summary.duration_s = 10.0;
        summary.travelled_m = (slip_m + servo_m).abs();
        summary.ledger.slip = term(slip_m);
        summary.ledger.servo = term(servo_m);
        sentence(&header, &summary, &[], ends_at_m_s)
    }

    /// Four rollers at 45 degrees hold cos 45 degrees of the friction ahead and sideways, and half
    /// of it along two of their axes.
    #[test]
    fn rollers_hold_along_their_axes_alone() {
        let quarter = std::f64::consts::FRAC_PI_4;
        let wheel = |gamma_rad: f64| ilon_trace::WheelHeader {
            gamma_rad,
            axis: [0.0, 1.0],
            ..ilon_trace::WheelHeader::default()
        };
        let header = Header {
            wheels: [quarter, -quarter, -quarter, quarter].map(wheel).into(),
            ..Header::default()
        };
        let held = |heading_deg: f64| held_at_best(&header, 1.0, Some(heading_deg.to_radians()));
        for (heading_deg, share) in [(0.0, 0.5f64.sqrt()), (90.0, 0.5f64.sqrt()), (45.0, 0.5)] {
            assert!((held(heading_deg) - share).abs() < 1e-12, "{heading_deg}");
        }
    }

    /// Two rollers, along x and at 60 degrees to it, each with up to half of the friction: together
    /// they hold cos 30 degrees of it in the direction between them, and half of that at a right
    /// angle to the one at 60 degrees. Downhill, +x, lies 30 degrees to the left of a robot that is
    /// turned by 30 degrees to the right.
    #[test]
    fn downhill_is_turned_into_the_robots_frame() {
        let (sin, cos) = (60f64.to_radians().sin(), 0.5);
        let wheel = |axis: [f64; 2]| ilon_trace::WheelHeader {
            axis,
            ..ilon_trace::WheelHeader::default()
        };
        let header = Header {
            wheels: [wheel([0.0, 1.0]), wheel([sin, -cos])].into(),
            ..Header::default()
        };
        for (downhill, heading_deg, share) in [
            (1.0, -30.0, sin),
            (1.0, 30.0, 0.5 * sin),
            (-1.0, -30.0, sin),
        ] {
            let held = held_at_best(&header, downhill, Some(f64::to_radians(heading_deg)));
            assert!((held - share).abs() < 1e-12, "{heading_deg}: {held}");
        }
    }

    #[test]
    fn a_slope_is_named_where_it_carried_the_robot_and_only_there() {
        // atan 0.6 = 31.0 degrees; tan 20 / 0.6 = 61 %.
        let (steep, first) = said(35.0, 12.0, 0.0).unwrap_or_default();
        assert!(
            first && steep.contains("35.0°") && steep.contains("(31.0°)"),
            "{steep}"
        );
        assert!(steep.contains("<b>12.000 m downhill</b>"), "{steep}");
        let (gripping, first) = said(20.0, 0.01, 0.0).unwrap_or_default();
        assert!(
            first
                && gripping.contains(
                    "61 % of what its rollers can hold in this direction on friction 0.6"
                ),
            "{gripping}"
        );
        let (creeping, first) = said(6.0, 2e-4, 1e-3).unwrap_or_default();
        assert!(
            !first && creeping.contains("crept <b>0.200 mm</b> downhill, at 0.020 mm/s"),
            "{creeping}"
        );
        assert!(
            creeping.contains("gave way by <b>1.00 mm</b>"),
            "{creeping}"
        );
        let (away, _) = ended(20.0, 0.0, 10.958, 4.3).unwrap_or_default();
        assert!(
            away.contains("do not hold the weight: at the end the robot goes at <b>4.300 m/s</b>"),
            "{away}"
        );
        // With a negative slope the floor falls towards -x.
        let (other, _) = said(-6.0, -2e-4, 0.0).unwrap_or_default();
        assert!(other.contains("towards −x"), "{other}");
        let (other, _) = said(-6.0, 0.0, -1e-3).unwrap_or_default();
        assert!(other.contains("gave way by <b>1.00 mm</b>"), "{other}");
        for level in [
            said(0.0, 12.0, 1.0),
            said(6.0, -2e-4, 0.0),
            said(6.0, 0.0, 0.0),
        ] {
            assert_eq!(level, None);
        }
    }
}
