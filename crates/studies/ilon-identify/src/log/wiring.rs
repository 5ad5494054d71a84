//! Anomalies of a readable log that its motion shows: wrong units, swapped or reversed wheels, and
//! wrong axes.

use std::f64::consts::{PI, TAU};

use ilon_robot::Robot;
use nalgebra::Matrix3xX;

use super::anomalies::{Anomaly, AnomalyKind, anomaly, shown};
use super::guess::{EXPLAINED, Guess, TURNS};
use super::hands;
use super::series::Log;
use crate::model::{Model, Parameter, named_wheels};
use crate::motion::{Window, windows};

const TURNS_BACK: &str = "the robot turns left where its wheels as stated turn it right";

/// Checks whether the wheels as stated explain the motion of all runs; if not, returns the likely
/// cause.
pub fn of_motion(windows: &[&Window], robot: &Robot) -> Option<Anomaly> {
    let model = Model::new(robot, &[]).ok()?;
    let matrix = model.twist_matrix(&[])?;
    let lever_m = Parameter::Lever.nominal(robot);
    let windows = &usual(windows, &matrix)[..];
    let stated = Guess::of(windows, &matrix, lever_m, false);
    if !stated.scale.is_finite() {
        return None;
    }
    let unit = heading_unit(&stated);
    if unit.is_some() {
        return unit;
    }
    let of_hands = hands::of_motion(windows, robot, &stated);
    if stated.fits() {
        if of_hands.is_some() {
            return of_hands;
        }
        return scale_doubt(&stated);
    }
    // If another hypothesis explains much more, it is the cause; the smallest change comes first.
    let mut best: Option<(usize, Guess, String)> = None;
    for (changes, words, changed, mirrored) in wirings(robot, &matrix) {
        let guess = Guess::of(windows, &changed, lever_m, mirrored);
        // Wheels of another handedness look like swapped ones that rotate the robot with another
        // lever.
        let turns_otherwise = of_hands.is_some() && !hands::turns_alike(&guess);
        if !guess.fits() || turns_otherwise {
            continue;
        }
        let is_better = best.as_ref().is_none_or(|(fewest, known, _)| {
            changes < *fewest || (changes == *fewest && guess.explained > known.explained)
        });
        if is_better {
            best = Some((changes, guess, words));
        }
    }
    if best.is_none() && of_hands.is_some() {
        return of_hands;
    }
    let turned_deg = stated.turned_rad.to_degrees();
    if let Some((changes, guess, words)) = best {
        // A rotated tracker is a smaller change than several wheels.
        let is_turned = stated.explained >= EXPLAINED && !stated.turns_back && changes > 1;
        if !is_turned {
            return Some(anomaly(
                AnomalyKind::Wiring,
                true,
                match stated.turns_back {
                    true => TURNS_BACK.to_owned(),
                    false => format!(
                        "the wheels as stated explain {:.0} % of the motion; otherwise wired they explain {:.0} %",
                        100.0 * stated.explained.max(0.0),
                        100.0 * guess.explained
                    ),
                },
                format!("likely {words}"),
            ));
        }
    }
    if stated.turns_back {
        return Some(anomaly(
            AnomalyKind::Wiring,
            true,
            TURNS_BACK.to_owned(),
            "likely the heading is counted clockwise: give it `scale = -1`; or wheels are swapped",
        ));
    }
    if stated.explained >= EXPLAINED {
        return Some(anomaly(
            AnomalyKind::Wiring,
            true,
            format!(
                "the robot moves {turned_deg:.0} degrees off the direction in which its wheels drive it"
            ),
            format!(
                "the tracker's heading is turned against the body's: add {:.4} rad to it, or the wheels are named one place further round",
                -stated.turned_rad
            ),
        ));
    }
    Some(anomaly(
        AnomalyKind::Unexplained,
        true,
        format!(
            "the wheels explain {:.0} % of the motion, in whichever order and direction they are taken",
            100.0 * stated.explained.max(0.0)
        ),
        "wheels and poses may come from two clocks or two drives, a wheel may not be logged, or it is another robot",
    ))
}

/// Tells whether headings are in another unit than stated. It shows only in rotations, and
/// distorts everything else.
fn heading_unit(stated: &Guess) -> Option<Anomaly> {
    if stated.turns <= TURNS {
        return None;
    }
    for (factor, unit, other) in [
        (180.0 / PI, "deg", "rad"),
        (PI / 180.0, "rad", "deg"),
        (1.0 / TAU, "turns", "rad"),
    ] {
        let off = (stated.turn_scale.abs() / factor - 1.0).abs();
        if off < 0.15
            && (stated.turn_scale / stated.scale).abs() / factor > 0.3
            && !near(stated.turn_scale.abs(), stated.scale)
        {
            return Some(anomaly(
                AnomalyKind::Unit,
                true,
                format!(
                    "the heading changes {} times as much as the wheels turn the robot",
                    shown(stated.turn_scale.abs())
                ),
                format!("headings in {unit} that are stated in {other}: see `log.heading.unit`"),
            ));
        }
    }
    None
}

/// Returns a single tracker axis that differs from its statement, if this alone makes the stated
/// wheels explain the motion. Displacements in the body frame cannot show it, because they were
/// rotated by the heading.
pub fn of_axes(logs: &[&Log], robot: &Robot, window_s: f64) -> Option<Anomaly> {
    type Change = fn([f64; 3]) -> [f64; 3];
    let changes: [(&str, Change); 4] = [
        (
            "the heading is counted clockwise: give it `scale = -1`",
            |[x, y, heading]| [x, y, -heading],
        ),
        (
            "the tracker's y points to the other side: give it `scale = -1`",
            |[x, y, heading]| [x, -y, heading],
        ),
        (
            "the tracker's x points the other way: give it `scale = -1`",
            |[x, y, heading]| [-x, y, heading],
        ),
        ("the columns of x and y are swapped", |[x, y, heading]| {
            [y, x, heading]
        }),
    ];
    let lever_m = Parameter::Lever.nominal(robot);
    let matrix = Model::new(robot, &[]).ok()?.twist_matrix(&[])?;
    let explained = |change: Change| {
        let mut all = Vec::new();
        for log in logs {
            let mut changed = (*log).clone();
            changed
                .poses
                .iter_mut()
                .for_each(|pose| *pose = change(*pose));
            all.extend(windows(&changed, 0, window_s));
        }
        let all: Vec<&Window> = all.iter().collect();
        Guess::of(&usual(&all, &matrix), &matrix, lever_m, false)
    };
    let stated = explained(|pose| pose);
    let (words, changed) = changes
        .into_iter()
        .map(|(words, change)| (words, explained(change)))
        .filter(|(_, changed)| changed.fits())
        .max_by(|a, b| a.1.explained.total_cmp(&b.1.explained))?;
    if stated.explained >= EXPLAINED && !stated.turns_back {
        return None;
    }
    Some(anomaly(
        AnomalyKind::Wiring,
        true,
        match stated.turns_back {
            true => TURNS_BACK.to_owned(),
            false => format!(
                "the wheels as stated explain {:.0} % of the motion; with one of the tracker's axes changed they explain {:.0} %",
                100.0 * stated.explained.max(0.0),
                100.0 * changed.explained
            ),
        },
        format!("likely {words}"),
    ))
}

/// Returns all windows but the tenth that fits the wheels worst, where the tracker may have jumped
/// or frozen.
fn usual<'w>(windows: &[&'w Window], matrix: &Matrix3xX<f64>) -> Vec<&'w Window> {
    let size = |way: [f64; 3]| libm::hypot(way[0], way[1]);
    let ways: Vec<[f64; 2]> = windows
        .iter()
        .map(|window| [size(window.seen), size(window.of_wheels(matrix))])
        .collect();
    let sum = |column: usize| {
        let mut column: Vec<f64> = ways.iter().map(|way| way[column]).collect();
        super::series::middle(&mut column)
    };
    let ratio = sum(0) / sum(1).max(1e-12);
    let off = |index: usize| (ways[index][0] - ratio * ways[index][1]).abs();
    let mut order: Vec<usize> = (0..windows.len()).collect();
    order.sort_by(|a, b| off(*a).total_cmp(&off(*b)));
    order.truncate((windows.len() * 9).div_ceil(10));
    order.iter().map(|index| windows[*index]).collect()
}

/// Factors between units that are easily confused.
const FACTORS: [(f64, &str); 12] = [
    (1000.0, "lengths in mm that are stated in m"),
    (100.0, "lengths in cm that are stated in m"),
    (0.001, "lengths in m that are stated in mm"),
    (0.01, "lengths in m that are stated in cm"),
    (39.37, "lengths in inches that are stated in m"),
    (0.0254, "lengths in m that are stated in inches"),
    (TAU, "wheel angles in turns that are stated in radians"),
    (
        1.0 / TAU,
        "wheel angles in radians that are stated in turns",
    ),
    (
        180.0 / PI,
        "wheel angles in radians that are stated in degrees",
    ),
    (
        PI / 180.0,
        "wheel angles in degrees that are stated in radians",
    ),
    (360.0, "wheel angles in turns that are stated in degrees"),
    (
        1.0 / 360.0,
        "wheel angles in degrees that are stated in turns",
    ),
];

fn scale_doubt(stated: &Guess) -> Option<Anomaly> {
    let ratio = stated.scale;
    if (0.55..=1.8).contains(&ratio) {
        return None;
    }
    let is_turn_too = stated.turns > TURNS && near(stated.turn_scale.abs(), ratio);
    let known = FACTORS.iter().find(|(factor, words)| {
        // A wrong unit of wheels also shows in rotations, one of lengths does not.
        let fits = stated.turns <= TURNS || words.starts_with("wheel") == is_turn_too;
        (ratio / factor - 1.0).abs() < 0.2 && fits
    });
    let help = match known {
        Some((_, words)) => format!("likely {words}"),
        None if ratio < 1.0 => format!(
            "likely a gear of 1:{} between what is counted and the wheel, or other ticks a turn, or another wheel radius",
            shown(1.0 / ratio)
        ),
        None => "likely other ticks a turn, a gear that was counted twice, or another wheel radius"
            .to_owned(),
    };
    Some(anomaly(
        AnomalyKind::Unit,
        true,
        format!(
            "the robot moves {} times as far as its wheels drive it",
            shown(ratio)
        ),
        help,
    ))
}

fn near(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 0.25
}

/// Returns maps of the same robot with wheels swapped or reversed, each with the number of changes
/// and a description. A steered wheel has two columns.
fn wirings(robot: &Robot, matrix: &Matrix3xX<f64>) -> Vec<(usize, String, Matrix3xX<f64>, bool)> {
    let named = named_wheels(robot);
    let wheels = named.len();
    let name = |wheel: usize| format!("`{}`", robot.wheels[named[wheel]].name);
    let columns = |wheel: usize| {
        let of_it = |at: &usize| robot.wheels[*at].name == robot.wheels[named[wheel]].name;
        (0..robot.wheels.len()).filter(of_it).collect::<Vec<_>>()
    };
    let columns: Vec<Vec<usize>> = (0..wheels).map(columns).collect();
    let is_alike = |order: &Vec<usize>| {
        let mut places = order.iter().enumerate();
        places.all(|(wheel, from)| columns[wheel].len() == columns[*from].len())
    };
    let mut all = turned_modules(matrix, &columns);
    for order in orders(wheels).into_iter().filter(is_alike) {
        let moved: Vec<usize> = (0..wheels)
            .filter(|wheel| order[*wheel] != *wheel)
            .collect();
        let swaps = moved.len().saturating_sub(1);
        for signs in 0..1_u32 << wheels.min(6) {
            let flipped: Vec<usize> = (0..wheels.min(6))
                .filter(|wheel| signs >> wheel & 1 == 1)
                .collect();
            // One switch reverses all wheels.
            let flips = if flipped.len() == wheels {
                1
            } else {
                flipped.len()
            };
            for mirrored in [false, true] {
                let changes = swaps + flips + 2 * usize::from(mirrored);
                if changes == 0 || (wheels > 4 && changes > 3) {
                    continue;
                }
                let mut words: Vec<String> = Vec::new();
                match moved.as_slice() {
                    [] => {}
                    [a, b] => words.push(format!(
                        "the columns of {} and {} are swapped",
                        name(*a),
                        name(*b)
                    )),
                    several => {
                        let list: Vec<String> = several
                            .iter()
                            .map(|wheel| format!("{} holds {}", name(*wheel), name(order[*wheel])))
                            .collect();
                        words.push(format!("columns are in another order: {}", list.join(", ")));
                    }
                }
                match flipped.as_slice() {
                    [] => {}
                    list if list.len() == wheels => {
                        words.push(
                            "all wheels count the other way: give them `scale = -1`".to_owned(),
                        );
                    }
                    list => {
                        let list: Vec<String> = list.iter().map(|wheel| name(*wheel)).collect();
                        let verb = if list.len() == 1 { "counts" } else { "count" };
                        words.push(format!(
                            "{} {verb} the other way: give {} `scale = -1`",
                            list.join(" and "),
                            if list.len() == 1 { "it" } else { "them" }
                        ));
                    }
                }
                if mirrored {
                    words.push(
                        "the tracker's axes are left-handed: give y and the heading `scale = -1`"
                            .to_owned(),
                    );
                }
                let mut changed = matrix.clone();
                for (wheel, from) in order.iter().enumerate() {
                    let sign = if flipped.contains(&wheel) { -1.0 } else { 1.0 };
                    for (to, from) in columns[wheel].iter().zip(&columns[*from]) {
                        changed.set_column(*to, &(matrix.column(*from) * sign));
                    }
                }
                all.push((changes, words.join("; "), changed, mirrored));
            }
        }
    }
    all
}

/// Returns maps of a robot whose modules all count their steering otherwise: the other way round, or
/// from another direction.
fn turned_modules(
    matrix: &Matrix3xX<f64>,
    columns: &[Vec<usize>],
) -> Vec<(usize, String, Matrix3xX<f64>, bool)> {
    // Of cos d and sin d in the directions along and across, those of -d, d + 90 degrees and
    // d - 90 degrees.
    let changes = [
        (
            [[1.0, 0.0], [0.0, -1.0]],
            "the steering angles count the other way: give them `scale = -1`",
        ),
        (
            [[0.0, 1.0], [-1.0, 0.0]],
            "the steering angles are 90 degrees too small: give them the `zero` -90 degrees",
        ),
        (
            [[0.0, -1.0], [1.0, 0.0]],
            "the steering angles are 90 degrees too large: give them the `zero` 90 degrees",
        ),
    ];
    let pairs = columns.iter().filter_map(|columns| match columns[..] {
        [along, across] => Some([along, across]),
        _ => None,
    });
    let pairs: Vec<[usize; 2]> = pairs.collect();
    let changes = changes.into_iter().filter(|_| !pairs.is_empty());
    changes
        .map(|(rows, words)| {
            let mut changed = matrix.clone();
            for pair in &pairs {
                for (to, row) in pair.iter().zip(rows) {
                    let [along, across] = pair.map(|from| matrix.column(from));
                    changed.set_column(*to, &(along * row[0] + across * row[1]));
                }
            }
            (1, words.to_owned(), changed, false)
        })
        .collect()
}

/// Returns all orders of up to four items; for more, those with two swapped.
fn orders(count: usize) -> Vec<Vec<usize>> {
    let plain: Vec<usize> = (0..count).collect();
    if count > 4 {
        let mut orders = vec![plain.clone()];
        for a in 0..count {
            for b in a + 1..count {
                let mut order = plain.clone();
                order.swap(a, b);
                orders.push(order);
            }
        }
        return orders;
    }
    let mut orders = vec![Vec::new()];
    for _ in 0..count {
        let longer = |order: &Vec<usize>| -> Vec<Vec<usize>> {
            let free = (0..count).filter(|next| !order.contains(next));
            free.map(|next| order.iter().copied().chain([next]).collect())
                .collect()
        };
        orders = orders.iter().flat_map(longer).collect();
    }
    orders
}
