//! The figures of a run as tiles and tables.

use std::fmt::Write;

use ilon_robot::Twist;
use ilon_trace::convergence::Moved;
use ilon_trace::effects::{Ablation, FLOORS};
use ilon_trace::ledger::{Integral, TERMS};
use ilon_trace::quantities;
use ilon_trace::{Convergence, Quantity, Summary, Trace};
use serde_json::Value;

use super::figures::balance::TERM_COLORS;
use super::html_table::{cell, number, row, table, wide};
use super::input::RunInput;
use super::page::{Table, escape};
use super::provenance::Expectation;
use super::text::{
    angle, angle_known, by_kind, energy, length, length_known, percent, speed, time,
};

/// Figures on tiles: each quantity of the summary by its key, with the smallest magnitude shown.
const TILES: [(&str, f64); 6] = [
    ("slip_speed_rms_m_s", 0.0),
    ("wheel_slip_energy_j", 5e-4),
    ("energy.spin_up_j", 5e-4),
    ("wheel_torque_max_n_m", 0.0),
    ("odometry_drift_m_per_m", 0.0),
    ("hub_ripple_m", 1e-5),
];

/// Tiles of runs with a reference.
const TRACKING_TILES: [(&str, f64); 5] = [
    ("position_error_max_m", 0.0),
    ("position_error_final_m", 0.0),
    ("heading_error_final_rad", 0.0),
    ("position_converged_s", 0.0),
    ("heading_converged_s", 0.0),
];

/// Tiles of open-loop runs.
const OPEN_LOOP_TILES: [(&str, f64); 6] = [
    ("twist_ratio_ideal.vx", 0.0),
    ("twist_ratio_ideal.vy", 0.0),
    ("twist_ratio_ideal.omega", 0.0),
    ("twist_ratio_contact.vx", 0.0),
    ("twist_ratio_contact.vy", 0.0),
    ("twist_ratio_contact.omega", 0.0),
];

/// Returns a value of a quantity, in SI units, with the unit that suits its size.
fn sized(quantity: &Quantity, value: f64) -> String {
    match quantity.unit.symbol {
        "m" | "mm" => length(value),
        "mm per m" => format!("{}/m", length(value)),
        "m/s" | "mm/s" => speed(value),
        "deg" => angle(value),
        "s" => time(value),
        "J" => energy(value),
        "%" => percent_fine(value),
        symbol => format!(
            "{:.*} {symbol}",
            quantity.decimals,
            value * quantity.unit.per_si
        ),
    }
}

/// Returns the most important figures as HTML; figures with expectations show whether these held.
pub(super) fn tiles(summary: &Summary, expectations: &[Expectation]) -> String {
    let of_its_kind: &[(&str, f64)] = match summary.position_error_final_m {
        Some(_) => &TRACKING_TILES,
        None => &OPEN_LOOP_TILES,
    };
    let cells: String = of_its_kind
        .iter()
        .chain(&TILES)
        .filter_map(|(key, least)| {
            let quantity = quantities::by_key(key)?;
            let value = quantity.value(summary)?;
            (value.abs() >= *least).then_some((quantity, sized(quantity, value)))
        })
        .map(|(quantity, value)| {
            let name = escape(&quantity.words());
            // The unit is smaller than the number.
            let (number, unit) = value.split_once(' ').unwrap_or((&value, ""));
            let expected = expectations.iter().find(|e| e.quantity == quantity.key);
            let (class, bound) = expected.map_or(("", String::new()), |e| {
                let (class, word) = if e.held { (" held", "held") } else { (" failed", "failed") };
                (class, format!("<br>{} {word}", escape(&e.bound)))
            });
            format!(
                "<div class=\"tile{class}\"><dt>{name}{bound}</dt><dd>{number}<small>{unit}</small></dd></div>"
            )
        })
        .collect();
    format!("<dl class=\"tiles\">{cells}</dl>\n")
}

/// Returns a ratio near 1 to a hundredth of a percent.
fn percent_fine(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// Returns the ledger in numbers, as HTML.
pub(super) fn ledger_table(shown: &RunInput, summary: &Summary) -> String {
    let header = &shown.trace.header;
    let causes: [&str; TERMS] = [
        "a task was saturated",
        by_kind(
            header,
            "the steering was on its way",
            "the command compensated roller geometry in advance",
        ),
        "the controller took the robot for another than it is, or its encoders counted wrong",
        "the wheels were behind their targets, or ahead of them",
        by_kind(
            header,
            "the tyres are wide, and touch off their middle",
            "the touching roller is tilted and off the wheel's middle",
        ),
        "wheels were in the air, or carried less than others",
        "the wheels' rates belong to no one motion, so that they slid against each other",
        "the contacts slid besides",
        "the way along ramps and obstacles is longer than on a map",
    ];
    let cells = |i: &Integral, first: usize| {
        let all = [
            (1e3 * i.x_m, 2),
            (1e3 * i.y_m, 2),
            (i.heading_rad.to_degrees(), 3),
            (1e3 * i.path_m, 2),
            (i.turned_rad.to_degrees(), 3),
        ];
        let cells = all.iter().take(first);
        cells
            .map(|(value, places)| number(Some(*value), *places))
            .collect::<String>()
    };
    let mut rows: String = summary
        .ledger
        .shown()
        .map(|(place, name, term)| {
            let (color, cause) = (TERM_COLORS[place].trim_start_matches('@'), causes[place]);
            row(
                &format!(
                    "<span class=\"swatch\" style=\"background:var(--{color})\"></span>{name}"
                ),
                &format!(
                    "{}<td style=\"text-align:left\">{cause}</td>",
                    cells(&term, 5)
                ),
            )
        })
        .collect();
    rows += &format!(
        "<tr class=\"total\"><th scope=\"row\">total</th>{}<td></td></tr>",
        cells(&summary.ledger.total, 5)
    );
    let closing = shown.all.off_course.closing(&summary.ledger);
    for (place, (name, [x_m, y_m, heading_rad])) in closing.iter().enumerate() {
        let of_end = Integral {
            x_m: *x_m,
            y_m: *y_m,
            heading_rad: *heading_rad,
            ..Integral::default()
        };
        let is_sum = place + 1 == closing.len();
        let class = if is_sum { " class=\"total\"" } else { "" };
        let net = cells(&of_end, 3);
        rows += &format!(
            "<tr{class}><th scope=\"row\">{name}</th>{net}<td></td><td></td><td></td></tr>"
        );
    }
    wide(&table(
        "Commanded minus real motion over the run: net along the world's axes at the heading that the robot had, and as the length of the path of each term",
        "<th>term</th><th>x, mm</th><th>y, mm</th><th>heading, deg</th><th>path, mm</th><th>turn, deg</th>\
         <th style=\"text-align:left\">because</th>",
        &rows,
    ))
}

/// Returns the mean twist in its stages from commanded to actual, as HTML; empty if the run ends
/// before the window of the means begins.
pub(super) fn twist_table(trace: &Trace, summary: &Summary) -> String {
    if trace.header.measure_from_s >= trace.header.measure_to_s {
        return String::new();
    }
    let twist = |name: &str, twist: Option<Twist>| {
        let cells = [
            number(twist.map(|t| t.vx_m_s), 5),
            number(twist.map(|t| t.vy_m_s), 5),
            number(twist.map(|t| t.omega_rad_s.to_degrees()), 4),
        ];
        row(name, &cells.concat())
    };
    let ratio = |name: &str, r: &ilon_trace::metrics::TwistRatio| {
        row(name, &[r.vx, r.vy, r.omega].map(|x| number(x, 5)).concat())
    };
    let rows = [
        twist("commanded", summary.twist_asked_mean),
        twist(
            "ideal: (7) from the real wheel rates",
            summary.twist_ideal_mean,
        ),
        twist(
            "contact: by what touches the floor",
            summary.twist_contact_mean,
        ),
        twist("real", summary.twist_mean),
        ratio("real over commanded", &summary.twist_ratio_asked),
        ratio("real over ideal", &summary.twist_ratio_ideal),
        ratio("real over contact", &summary.twist_ratio_contact),
    ];
    wide(&table(
        &format!(
            "Means from {} to {}, in the body frame; a ratio stands only where the component is driven",
            time(trace.header.measure_from_s),
            time(trace.header.measure_to_s)
        ),
        "<td></td><th>v<sub>x</sub>, m/s</th><th>v<sub>y</sub>, m/s</th><th>ω, deg/s</th>",
        &rows.concat(),
    ))
}

/// The parts of the energy balance by their keys, first the supply and then the sinks, in display
/// order.
pub(super) const BALANCE: [&str; 8] = [
    "energy.motor_j",
    "energy.outside_j",
    "energy.stored_j",
    "energy.slip_j",
    "energy.spin_up_j",
    "energy.bearing_j",
    "energy.impact_j",
    "energy.unexplained_j",
];

/// Returns the energy balance in numbers, as HTML.
pub(super) fn energy_table(summary: &Summary) -> String {
    let share = summary.energy.unexplained_share.map(percent);
    let row = |quantity: &Quantity| {
        let joules = quantity.shown(summary);
        let further = match (quantity.key, &share) {
            ("energy.unexplained_j", Some(share)) => {
                format!(": {share} of the energy turned over, the solver's own")
            }
            _ => String::new(),
        };
        row(
            &format!("{}{further}", quantity.label),
            &cell(joules.map(|j| format!("{j:.*}", quantity.decimals))),
        )
    };
    let parts = BALANCE.iter().filter_map(|key| quantities::by_key(key));
    // Tyres have no rollers to spin up.
    let parts =
        parts.filter(|part| part.key != "energy.spin_up_j" || part.value(summary) != Some(0.0));
    wide(&table(
        "What the motors did and what came from outside, and where it went: the others add up to the first two",
        "<td></td><th>J</th>",
        &parts.map(row).collect::<String>(),
    ))
}

/// Returns the drift of dead reckoning by either kinematics, and their ratio, as HTML.
pub(super) fn odometry_table(summary: &Summary) -> String {
    let (ideal, contact) = (&summary.odometry_ideal, &summary.odometry_contact);
    // Heading, factor from SI units, decimals, value.
    type Column = (
        &'static str,
        fn(f64) -> f64,
        usize,
        fn(&ilon_trace::odometry::Drift) -> Option<f64>,
    );
    let mm = |x: f64| 1e3 * x;
    let columns: [Column; 6] = [
        ("at the end,<br>mm", mm, 2, |d| d.final_m),
        ("at its worst,<br>mm", mm, 2, |d| d.worst_m),
        ("per metre,<br>mm", mm, 3, |d| d.m_per_m),
        ("heading at the end,<br>deg", f64::to_degrees, 4, |d| {
            d.final_rad
        }),
        ("per metre,<br>deg", f64::to_degrees, 4, |d| d.rad_per_m),
        ("per full turn,<br>deg", f64::to_degrees, 4, |d| {
            d.rad_per_turn
        }),
    ];
    let drift = |name: &str, drift: &ilon_trace::odometry::Drift| {
        let cells = columns.map(|(_, shown, places, of)| {
            cell(of(drift).map(|value| format!("{:.places$}", shown(value))))
        });
        row(name, &cells.concat())
    };
    let better = columns.map(|(_, _, _, of)| {
        let times = of(ideal).zip(of(contact)).map(|(i, c)| (i / c).abs());
        cell(times.filter(|t| t.is_finite()).map(|t| format!("{t:.1}")))
    });
    let rows = [
        drift("by the ideal kinematics", ideal),
        drift("by the contact kinematics", contact),
        format!(
            "<tr class=\"total\"><th scope=\"row\">times less</th>{}</tr>",
            better.concat()
        ),
    ];
    let heads = columns.map(|(head, ..)| format!("<th>{head}</th>"));
    wide(&table(
        "Odometry minus truth. On your robot <code>ilon_control::Odometry</code> uses the contact kinematics: wheel angles in, pose \
         out",
        &format!("<td></td>{}", heads.concat()),
        &rows.concat(),
    ))
}

/// Returns the effect of each cause on the run, in this order. A dash: less than the accuracy bears.
pub fn causes_table(title: &str, ablations: &[&Ablation]) -> Table {
    let row = |one: &&Ablation| {
        let [end_floor_m, floor_rad] = one.end_floor;
        let known_m = |x_m: f64, floor_m: f64| {
            (x_m.abs() > FLOORS * floor_m).then(|| length_known(x_m, floor_m))
        };
        let turned = one.apart.turned_rad;
        let turned = (turned.abs() > FLOORS * floor_rad).then(|| angle_known(turned, floor_rad));
        let slip = one.get("slip_energy_j").filter(|slip| slip.differs);
        let name = one.cause.map_or("all of them", |cause| &cause.words);
        let cells = [
            Some(name.to_owned()),
            known_m(one.apart.most_m, one.floor[0]),
            known_m(one.apart.most_m, one.floor[0]).map(|_| time(one.apart.most_at_s)),
            known_m(one.apart.ahead_m, end_floor_m),
            known_m(one.apart.left_m, end_floor_m),
            turned,
            slip.map(|slip| energy(slip.difference)),
        ];
        cells
            .map(|cell| cell.unwrap_or_else(|| "-".to_owned()))
            .to_vec()
    };
    let head = [
        "cause",
        "apart by up to",
        "at",
        "at the end ahead",
        "to the left",
        "turned to the left",
        "sliding cost",
    ];
    Table {
        title: title.to_owned(),
        head: head.map(str::to_owned).to_vec(),
        rows: ablations.iter().map(row).collect(),
    }
}

/// Returns the figures of a run at its own step and at half of it, as HTML: those that moved by
/// more than their stated accuracy first.
pub(super) fn convergence_table(converge: &Convergence) -> String {
    let found = quantities::stated()
        .filter_map(|(quantity, accuracy)| Some((quantity, accuracy, converge.get(quantity.key)?)));
    let mut found: Vec<_> = found.collect();
    found.sort_by_key(|(_, _, moved)| !moved.exceeds);
    let by = |moved: &Moved| match moved.share == 0.0 && moved.moved > 0.0 {
        true => "–".to_owned(),
        false => format!("{:.3} %", 100.0 * moved.share),
    };
    let rows = found.into_iter().map(|(quantity, accuracy, moved)| {
        let shown = |value: Option<f64>| {
            cell(
                value
                    .map(|value| format!("{:.*}", quantity.decimals, value * quantity.unit.per_si)),
            )
        };
        let values = [moved.value, moved.half_step, moved.half_split].map(shown);
        let class = if moved.exceeds {
            " class=\"failed\""
        } else {
            ""
        };
        row(
            &format!("{}, {}", escape(&quantity.words()), unit_words(quantity)),
            &format!(
                "{}<td{class}>{}</td><td>{:.1} %</td>",
                values.concat(),
                by(moved),
                100.0 * accuracy.share
            ),
        )
    });
    wide(&table(
        "Places and headings are measured against the way, all else against itself. A dash: too little of it to matter in this run",
        "<th>figure</th><th>as it is</th><th>half the step</th><th>half the split</th><th>moves by</th><th>stated accuracy</th>",
        &rows.collect::<String>(),
    ))
}

/// Returns the display unit of a quantity.
fn unit_words(quantity: &Quantity) -> &'static str {
    match quantity.unit.symbol {
        "" => "1",
        symbol => symbol,
    }
}

/// Returns the contacts of each wheel in numbers, as HTML.
pub(super) fn wheel_table(summary: &Summary, has_rollers: bool) -> String {
    let plain = |x: Option<f64>, places: usize| cell(x.map(|x| format!("{x:.places$}")));
    let milli = |x: Option<f64>, places: usize| plain(x.map(|x| 1e3 * x), places);
    let mut wheels = summary.wheels.iter();
    let has_residual = wheels.any(|w| w.constraint_residual_rms_m_s.is_some());
    let of_unsteered = |cell: String| if has_residual { cell } else { String::new() };
    let wheel = |w: &ilon_trace::slip::WheelSlip| {
        let of_rollers = |cell: String| if has_rollers { cell } else { String::new() };
        let cells = [
            milli(w.speed_rms_m_s, 2),
            milli(w.speed_max_m_s, 2),
            cell(w.ratio.map(percent)),
            of_unsteered(milli(w.constraint_residual_rms_m_s, 2)),
            plain(Some(w.energy_j), 3),
            plain(w.normal_force_mean_n, 2),
            cell(w.friction_used_max.map(percent)),
            of_rollers(cell(Some(w.hand_overs.to_string()))),
            of_rollers(cell(w.shared_contact.map(percent))),
            cell(w.lost_contact.map(percent)),
            of_rollers(plain(w.roller_spin_error_rms_rad_s, 2)),
            milli(w.hub_ripple_m, 3),
        ];
        row(&escape(&w.name), &cells.concat())
    };
    let of_rollers = |head: &'static str| if has_rollers { head } else { "" };
    let [shared, spin] = [
        of_rollers("<th>hand-overs</th><th>two rollers<br>at once</th>"),
        of_rollers("<th>spin off ideal,<br>rad/s rms</th>"),
    ];
    let residual = of_unsteered("<th>residual of (5),<br>mm/s rms</th>".to_owned());
    let heads = format!(
        "<th>wheel</th><th>slip rms,<br>mm/s</th><th>slip max,<br>mm/s</th><th>slip ratio</th>\
         {residual}<th>lost to slip,<br>J</th><th>mean load,<br>N</th>\
         <th>most grip used</th>{shared}<th>off the floor</th>{spin}<th>ripple,<br>mm</th>"
    );
    wide(&table(
        "The contacts of each wheel over the run",
        &heads,
        &summary.wheels.iter().map(wheel).collect::<String>(),
    ))
}

/// Returns every number of the summary under its own name, as HTML.
pub(super) fn all_figures(summary: &Summary) -> String {
    let mut rows = String::new();
    // A summary of numbers and names always serialises.
    let json = serde_json::to_value(summary).unwrap_or_default();
    flatten("", &json, &mut rows);
    format!(
        "<div class=\"scroll\" tabindex=\"0\">{}</div>\n",
        table(
            "SI units; a dash is a quantity that does not apply",
            "<th>name</th><th>value</th>",
            &rows
        )
    )
}

/// Returns one row for each leaf of a JSON value, named by its path.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_and_balance_show_quantities_that_there_are() {
        let tiles = TILES.iter().chain(&TRACKING_TILES).chain(&OPEN_LOOP_TILES);
        for (key, _) in tiles {
            assert!(quantities::by_key(key).is_some(), "{key}");
        }
        for key in BALANCE {
            assert!(quantities::by_key(key).is_some(), "{key}");
        }
    }

    /// What moved, but by less than counts, has no share; what stayed has moved by none.
    #[test]
    fn a_change_too_small_to_matter_is_a_dash() {
        for (moved_m, share, shown) in [
            (0.0, 0.0, "0.000 %"),
            (1e-6, 0.0, "–"),
            (1e-3, 0.002, "0.200 %"),
        ] {
            let moved = serde_json::json!({
                "value": 1.0, "half_step": 1.0 + moved_m, "half_split": null,
                "moved": moved_m, "share": share, "exceeds": false,
            });
            let converge = serde_json::json!({ "end_x_m": moved });
            let table = convergence_table(&serde_json::from_value(converge).unwrap());
            assert!(
                table.contains(&format!("<td>{shown}</td><td>0.1 %</td>")),
                "{table}"
            );
        }
    }

    /// 0.000681 m per m is 0.681 mm in each metre.
    #[test]
    fn a_drift_is_a_length_per_metre() {
        let mut summary = Summary::default();
        summary.odometry_drift_m_per_m = Some(0.000_681);
        let tiles = tiles(&summary, &[]);
        assert!(tiles.contains("<dd>0.681<small>mm/m</small>"), "{tiles}");
    }

    #[test]
    fn lengths_have_one_unit_below_a_metre() {
        for (x_m, text) in [
            (2.0, "2.000 m"),
            (0.4222, "422.2 mm"),
            (0.0031, "3.10 mm"),
            (0.000_199, "0.199 mm"),
            (-1e-9, "0 mm"),
        ] {
            assert_eq!(length(x_m), text);
        }
    }
}
