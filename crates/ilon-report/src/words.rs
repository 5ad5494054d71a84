//! The run in words: the answer in short, tiles, tables.

use std::fmt::Write;

use ilon_robot::Twist;
use ilon_trace::{Summary, Trace};
use serde_json::Value;

use super::figures::balance::TERM_COLORS;
use super::page::escape;

/// A length for reading: metres, centimetres, millimetres or micrometres.
pub(super) fn length(x_m: f64) -> String {
    let size_m = x_m.abs();
    if !x_m.is_finite() {
        "not finite".to_owned()
    } else if size_m >= 1.0 {
        format!("{x_m:.3} m")
    } else if size_m >= 0.1 {
        format!("{:.1} cm", 1e2 * x_m)
    } else if size_m >= 1e-3 {
        format!("{:.2} mm", 1e3 * x_m)
    } else if size_m >= 1e-6 {
        format!("{:.3} mm", 1e3 * x_m)
    } else {
        "0 mm".to_owned()
    }
}

/// An angle for reading, in degrees.
pub(super) fn angle(x_rad: f64) -> String {
    let x_deg = x_rad.to_degrees();
    if x_deg.abs() >= 1.0 {
        format!("{x_deg:.2}°")
    } else {
        format!("{x_deg:.3}°")
    }
}

/// A time for reading.
pub(super) fn time(x_s: f64) -> String {
    format!("{x_s:.2} s")
}

/// A part of a whole for reading.
pub(super) fn percent(x: f64) -> String {
    let x_pct = 100.0 * x;
    if x_pct.abs() >= 0.1 || x_pct == 0.0 {
        format!("{x_pct:.1} %")
    } else {
        format!("{x_pct:.3} %")
    }
}

/// A speed for reading.
pub(super) fn speed(x_m_s: f64) -> String {
    if x_m_s.abs() >= 0.1 {
        format!("{x_m_s:.3} m/s")
    } else {
        format!("{:.2} mm/s", 1e3 * x_m_s)
    }
}

/// The run in a few sentences, as HTML.
pub(super) fn story(trace: &Trace, summary: &Summary) -> String {
    let mut lines = Vec::new();
    lines.extend(tracking(summary));
    lines.extend(shortfall(trace, summary));
    lines.extend(slipping(summary));
    lines.extend(reckoning(summary));
    let paragraphs: String = lines.iter().map(|l| format!("<p>{l}</p>")).collect();
    format!("<div class=\"story\">{paragraphs}</div>\n")
}

/// How near it came to its reference.
fn tracking(summary: &Summary) -> Option<String> {
    let (position_m, heading_rad) = (
        summary.position_error_final_m?,
        summary.heading_error_final_rad?,
    );
    let mut text = format!(
        "It ended <b>{}</b> and <b>{}</b> from its reference.",
        length(position_m),
        angle(heading_rad)
    );
    let converged = match (summary.position_converged_s, summary.heading_converged_s) {
        (Some(p), Some(h)) if p == h => {
            format!("Position and heading were there from {} on.", time(p))
        }
        (Some(p), Some(h)) if p < h => {
            format!(
                "The position was there from {} on, the heading from {}.",
                time(p),
                time(h)
            )
        }
        (Some(p), Some(h)) => {
            format!(
                "The heading was there from {} on, the position from {}.",
                time(h),
                time(p)
            )
        }
        (Some(p), None) => format!(
            "The position was there from {} on, the heading never for good.",
            time(p)
        ),
        (None, Some(h)) => format!(
            "The heading was there from {} on, the position never for good.",
            time(h)
        ),
        (None, None) => "Neither position nor heading converged.".to_owned(),
    };
    let _ = write!(text, " {converged}");
    if let Some(share) = summary.saturated_share.filter(|&s| s > 0.0) {
        let _ = write!(
            text,
            " Saturation made a task give way during {} of the run.",
            percent(share)
        );
    }
    Some(text)
}

/// What of the ideal motion did not come, and why, for each driven component of an open-loop run.
fn shortfall(trace: &Trace, summary: &Summary) -> Vec<String> {
    if !trace.header.open_loop {
        return Vec::new();
    }
    let (Some(real), Some(ideal), Some(contact)) = (
        summary.twist_mean,
        summary.twist_ideal_mean,
        summary.twist_contact_mean,
    ) else {
        return Vec::new();
    };
    let ratios = summary.twist_ratio_ideal;
    let metres: fn(f64) -> String = |v| format!("{:.4} m/s", v.abs());
    let degrees: fn(f64) -> String = |w| format!("{:.2}°/s", w.to_degrees().abs());
    let side = |v: f64, plus: &'static str, minus: &'static str| if v < 0.0 { minus } else { plus };
    let components = [
        (
            ratios.vx,
            real.vx_m_s,
            ideal.vx_m_s,
            contact.vx_m_s,
            metres,
            side(ideal.vx_m_s, "Ahead", "Backwards"),
        ),
        (
            ratios.vy,
            real.vy_m_s,
            ideal.vy_m_s,
            contact.vy_m_s,
            metres,
            side(ideal.vy_m_s, "To the left", "To the right"),
        ),
        (
            ratios.omega,
            real.omega_rad_s,
            ideal.omega_rad_s,
            contact.omega_rad_s,
            degrees,
            side(ideal.omega_rad_s, "Turning left", "Turning right"),
        ),
    ];
    components
        .into_iter()
        .filter_map(|(ratio, real, ideal, contact, unit, direction)| {
            let ratio = ratio?;
            let geometry = (ideal - contact) / ideal;
            let slip = (contact - real) / ideal;
            Some(format!(
                "<b>{direction}</b> the wheels turned for {} and the robot did {}: <b>{}</b> of the ideal kinematics. \
                 The rollers' geometry takes {}, slip takes {}.",
                unit(ideal),
                unit(real),
                percent(ratio),
                percent(geometry),
                percent(slip)
            ))
        })
        .collect()
}

/// How much the contacts slid and what it cost.
fn slipping(summary: &Summary) -> Option<String> {
    let rms_m_s = summary.slip_speed_rms_m_s?;
    let mut text = format!("The contacts slid at <b>{}</b> rms", speed(rms_m_s));
    if let (Some(slip_j), Some(motor_j)) = (summary.energy.slip_j, summary.energy.motor_j) {
        let _ = write!(text, " and lost {slip_j:.2} J");
        if motor_j > 0.0 {
            let _ = write!(text, " of the {motor_j:.2} J that the motors gave");
        }
    }
    text.push('.');
    Some(text)
}

/// How far dead reckoning strays.
fn reckoning(summary: &Summary) -> Option<String> {
    let ideal = summary.odometry_ideal.m_per_m?;
    let contact = summary.odometry_contact.m_per_m?;
    Some(format!(
        "Dead reckoning strays by {} a metre by the ideal kinematics, by {} when it allows for the rollers that touch.",
        length(ideal),
        length(contact)
    ))
}

/// The figures that matter most, as HTML.
pub(super) fn tiles(summary: &Summary) -> String {
    let components = |ratio: &ilon_trace::metrics::TwistRatio| [ratio.vx, ratio.vy, ratio.omega];
    let names = ["ahead", "sideways", "yaw"];
    let mut tiles: Vec<(String, Option<String>)> = vec![
        (
            "position error at the end".to_owned(),
            summary.position_error_final_m.map(length),
        ),
        (
            "heading error at the end".to_owned(),
            summary.heading_error_final_rad.map(angle),
        ),
        (
            "position converged after".to_owned(),
            summary.position_converged_s.map(time),
        ),
        (
            "heading converged after".to_owned(),
            summary.heading_converged_s.map(time),
        ),
    ];
    if summary.position_error_final_m.is_none() {
        for (of, ratio) in [
            ("ideal", components(&summary.twist_ratio_ideal)),
            ("contact", components(&summary.twist_ratio_contact)),
        ] {
            let named = names.iter().zip(ratio);
            tiles.extend(
                named.map(|(name, r)| (format!("real over {of}, {name}"), r.map(percent_fine))),
            );
        }
    }
    tiles.extend([
        (
            "sliding speed, rms".to_owned(),
            summary.slip_speed_rms_m_s.map(speed),
        ),
        (
            "lost to slip".to_owned(),
            summary.slip_energy_j.map(|j| format!("{j:.3} J")),
        ),
        (
            "largest wheel rate asked".to_owned(),
            summary
                .wheel_rate_command_max_rad_s
                .map(|w| format!("{w:.2} rad/s")),
        ),
        (
            "largest wheel torque".to_owned(),
            summary.wheel_torque_max_n_m.map(|t| format!("{t:.3} N m")),
        ),
        (
            "drift of dead reckoning, per metre".to_owned(),
            summary.odometry_drift_m_per_m.map(length),
        ),
        ("hub ripple".to_owned(), summary.hub_ripple_m.map(length)),
    ]);
    let cells: String = tiles
        .iter()
        .filter_map(|(name, value)| Some((name, value.as_ref()?)))
        .map(|(name, value)| {
            // The unit stands smaller than the number.
            let (number, unit) = value.split_once(' ').unwrap_or((value, ""));
            format!(
                "<div class=\"tile\"><dt>{name}</dt><dd>{number}<small>{unit}</small></dd></div>"
            )
        })
        .collect();
    format!("<dl class=\"tiles\">{cells}</dl>\n")
}

/// A ratio near 1 to a hundredth of a percent.
fn percent_fine(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// The ledger in numbers, as HTML.
pub(super) fn ledger_table(summary: &Summary) -> String {
    let causes = [
        "saturation made a task give way",
        "the command allowed for the rollers' geometry in advance",
        "the wheels had not reached their targets",
        "the touching roller is tilted and off the wheel's middle",
        "the contacts slid",
    ];
    let cells = |i: &ilon_trace::ledger::Integral| {
        format!(
            "<td>{:.2}</td><td>{:.2}</td><td>{:.3}</td><td>{:.2}</td><td>{:.3}</td>",
            1e3 * i.x_m,
            1e3 * i.y_m,
            i.heading_rad.to_degrees(),
            1e3 * i.path_m,
            i.turned_rad.to_degrees()
        )
    };
    let rows: String = summary
        .ledger
        .named()
        .iter()
        .zip(TERM_COLORS)
        .zip(causes)
        .map(|(((name, term), color), cause)| {
            format!(
                "<tr><th scope=\"row\"><span class=\"swatch\" style=\"background:var(--{})\"></span>{name}</th>{}\
                 <td style=\"text-align:left\">{cause}</td></tr>",
                color.trim_start_matches('@'),
                cells(term)
            )
        })
        .collect();
    format!(
        "<div class=\"card whole scroll\"><table><caption>Asked minus real motion over the run: net along the world's axes, \
         and as the length of each term's own way</caption><thead><tr><th>term</th><th>x, mm</th><th>y, mm</th>\
         <th>heading, deg</th><th>way, mm</th><th>turn, deg</th><th style=\"text-align:left\">because</th></tr></thead>\
         <tbody>{rows}<tr class=\"total\"><th scope=\"row\">total</th>{}<td></td></tr></tbody></table></div>\n",
        cells(&summary.ledger.total)
    )
}

/// The mean twist on its way from asked to real, as HTML.
pub(super) fn twist_table(trace: &Trace, summary: &Summary) -> String {
    let row = |name: &str, twist: Option<Twist>| {
        let cells = twist.map_or_else(
            || "<td class=\"none\">—</td>".repeat(3),
            |t| {
                format!(
                    "<td>{:.5}</td><td>{:.5}</td><td>{:.4}</td>",
                    t.vx_m_s,
                    t.vy_m_s,
                    t.omega_rad_s.to_degrees()
                )
            },
        );
        format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>")
    };
    let ratio = |name: &str, r: &ilon_trace::metrics::TwistRatio| {
        let cells: String = [r.vx, r.vy, r.omega]
            .map(|x| {
                x.map_or("<td class=\"none\">—</td>".to_owned(), |x| {
                    format!("<td>{x:.5}</td>")
                })
            })
            .concat();
        format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>")
    };
    format!(
        "<div class=\"card whole scroll\"><table><caption>Means from {} to {}, in the body frame; a ratio stands only where \
         the component is driven</caption><thead><tr><th></th><th>v<sub>x</sub>, m/s</th><th>v<sub>y</sub>, m/s</th>\
         <th>ω, deg/s</th></tr></thead><tbody>{}{}{}{}{}</tbody></table></div>\n",
        time(trace.header.measure_from_s),
        time(trace.header.measure_to_s),
        row(
            "ideal: (7) from the real wheel rates",
            summary.twist_ideal_mean
        ),
        row(
            "contact: by the rollers that touch",
            summary.twist_contact_mean
        ),
        row("real", summary.twist_mean),
        ratio("real over ideal", &summary.twist_ratio_ideal),
        ratio("real over contact", &summary.twist_ratio_contact),
    )
}

/// The energy balance in numbers, as HTML.
pub(super) fn energy_table(summary: &Summary) -> String {
    let e = &summary.energy;
    let row = |name: &str, value: Option<f64>, because: &str| {
        let cell = value.map_or("<td class=\"none\">—</td>".to_owned(), |j| {
            format!("<td>{j:.4}</td>")
        });
        format!(
            "<tr><th scope=\"row\">{name}</th>{cell}<td style=\"text-align:left\">{because}</td></tr>"
        )
    };
    let share = e.unexplained_share.map_or_else(String::new, |share| {
        format!(
            "its own loss or gain: {} of the energy turned over",
            percent(share)
        )
    });
    format!(
        "<div class=\"card whole scroll\"><table><caption>Motors and outside = stored + slip + bearings + landing + solver</caption>\
         <thead><tr><th></th><th>J</th><th style=\"text-align:left\">is</th></tr></thead><tbody>{}{}{}{}{}{}{}</tbody></table></div>\n",
        row("motors", e.motor_j, "work at the wheels"),
        row("outside", e.outside_j, "brought by pushes and payloads"),
        row("stored", e.stored_j, "gain of kinetic and potential energy"),
        row("slip", e.slip_j, "turned into heat where contacts slide"),
        row("bearings", e.bearing_j, "of wheels and rollers"),
        row(
            "landing",
            e.impact_j,
            "rollers that meet the floor and do not bounce"
        ),
        row("solver", e.unexplained_j, &share),
    )
}

/// How far dead reckoning strayed, by either kinematics, and how many times less by the second; as HTML.
pub(super) fn odometry_table(summary: &Summary) -> String {
    let (ideal, contact) = (&summary.odometry_ideal, &summary.odometry_contact);
    let mm = |x: Option<f64>| x.map(|x| 1e3 * x);
    let deg = |x: Option<f64>| x.map(f64::to_degrees);
    type Column = (
        &'static str,
        usize,
        fn(&ilon_trace::odometry::Drift) -> Option<f64>,
    );
    let millimetres: [Column; 3] = [
        ("at the end,<br>mm", 2, |d| d.final_m),
        ("at its worst,<br>mm", 2, |d| d.worst_m),
        ("per metre,<br>mm", 3, |d| d.m_per_m),
    ];
    let degrees: [Column; 3] = [
        ("heading at the end,<br>deg", 4, |d| d.final_rad),
        ("per metre,<br>deg", 4, |d| d.rad_per_m),
        ("per full turn,<br>deg", 4, |d| d.rad_per_turn),
    ];
    let cell = |value: Option<String>| {
        value.map_or("<td class=\"none\">—</td>".to_owned(), |v| {
            format!("<td>{v}</td>")
        })
    };
    let row = |name: &str, drift: &ilon_trace::odometry::Drift| {
        let lengths = millimetres
            .iter()
            .map(|(_, digits, of)| (mm(of(drift)), *digits));
        let angles = degrees
            .iter()
            .map(|(_, digits, of)| (deg(of(drift)), *digits));
        let cells: String = lengths
            .chain(angles)
            .map(|(value, digits)| cell(value.map(|v| format!("{v:.digits$}"))))
            .collect();
        format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>")
    };
    let better: String = millimetres
        .iter()
        .chain(&degrees)
        .map(|(_, _, of)| {
            let times = of(ideal).zip(of(contact)).map(|(i, c)| (i / c).abs());
            cell(times.filter(|t| t.is_finite()).map(|t| format!("{t:.1}")))
        })
        .collect();
    let heads: String = millimetres
        .iter()
        .chain(&degrees)
        .map(|(head, _, _)| format!("<th>{head}</th>"))
        .collect();
    format!(
        "<div class=\"card whole scroll\"><table><caption>Reckoned minus real. A robot of one's own reckons by the contacts \
         with <code>ilon_control::Odometry</code>: wheel angles in, pose out</caption><thead><tr><th></th>{heads}</tr></thead>\
         <tbody>{}{}<tr class=\"total\"><th scope=\"row\">times less</th>{better}</tr></tbody></table></div>\n",
        row("by equation (7)", ideal),
        row("by the contact kinematics", contact),
    )
}

/// The contacts of each wheel in numbers, as HTML.
pub(super) fn wheel_table(summary: &Summary) -> String {
    let cell = |value: Option<String>| {
        value.map_or("<td class=\"none\">—</td>".to_owned(), |v| {
            format!("<td>{v}</td>")
        })
    };
    let mm_s = |x: Option<f64>| cell(x.map(|x| format!("{:.2}", 1e3 * x)));
    let rows: String = summary
        .wheels
        .iter()
        .map(|w| {
            format!(
                "<tr><th scope=\"row\">{}</th>{}{}{}{}<td>{:.3}</td>{}{}<td>{}</td>{}{}{}{}</tr>",
                escape(&w.name),
                mm_s(w.speed_rms_m_s),
                mm_s(w.speed_max_m_s),
                cell(w.ratio.map(percent)),
                mm_s(w.constraint_residual_rms_m_s),
                w.energy_j,
                cell(w.normal_force_mean_n.map(|n| format!("{n:.2}"))),
                cell(w.friction_used_max.map(percent)),
                w.hand_overs,
                cell(w.shared_contact.map(percent)),
                cell(w.lost_contact.map(percent)),
                cell(w.roller_spin_error_rms_rad_s.map(|w| format!("{w:.2}"))),
                cell(w.hub_ripple_m.map(|m| format!("{:.3}", 1e3 * m))),
            )
        })
        .collect();
    format!(
        "<div class=\"card whole scroll\"><table><caption>The contacts of each wheel over the run</caption><thead><tr>\
         <th>wheel</th><th>slip rms,<br>mm/s</th><th>slip max,<br>mm/s</th><th>slip ratio</th>\
         <th>residual of (5),<br>mm/s rms</th><th>lost to slip,<br>J</th><th>mean load,<br>N</th>\
         <th>most grip used</th><th>hand-overs</th><th>two rollers<br>at once</th><th>off the floor</th>\
         <th>spin off ideal,<br>rad/s rms</th><th>ripple,<br>mm</th>\
         </tr></thead><tbody>{rows}</tbody></table></div>\n"
    )
}

/// Every number of the summary under its own name, as HTML.
pub(super) fn all_figures(summary: &Summary) -> String {
    let mut rows = String::new();
    // A summary of numbers and names always serialises.
    let json = serde_json::to_value(summary).unwrap_or_default();
    flatten("", &json, &mut rows);
    format!(
        "<div class=\"scroll\"><table><caption>SI units; a dash is a quantity that does not apply</caption><thead><tr>\
         <th>name</th><th>value</th></tr></thead><tbody>{rows}</tbody></table></div>\n"
    )
}

/// One row for each leaf of a JSON value, named by its path.
fn flatten(path: &str, value: &Value, rows: &mut String) {
    let below = |key: &str| {
        if path.is_empty() {
            key.to_owned()
        } else {
            format!("{path}.{key}")
        }
    };
    match value {
        Value::Object(fields) => fields.iter().for_each(|(k, v)| flatten(&below(k), v, rows)),
        Value::Array(items) => {
            items
                .iter()
                .enumerate()
                .for_each(|(k, v)| flatten(&below(&k.to_string()), v, rows));
        }
        leaf => {
            let text = match leaf {
                Value::Null => "—".to_owned(),
                Value::String(text) => escape(text),
                other => other.to_string(),
            };
            let key = escape(path);
            let class = if leaf.is_null() {
                " class=\"none\""
            } else {
                ""
            };
            // Writing to a string cannot fail.
            let _ = write!(
                rows,
                "<tr><th scope=\"row\"><code>{key}</code></th><td{class} data-key=\"{key}\">{text}</td></tr>"
            );
        }
    }
}
