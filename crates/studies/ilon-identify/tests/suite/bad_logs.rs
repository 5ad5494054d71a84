//! Logs that contradict their description: each error is named, with its likely cause.

use crate::support;

use std::fmt::Write;

use ilon_identify::{Log, Study, identify};
use ilon_robot::Robot;
use ilon_sim::Error;
use support::{Drive, csv, drive, robot, study};

/// The message for a changed log, with the help.
fn said(change: impl Fn(&mut Log)) -> String {
    said_of("mecanum4.toml", change)
}

fn said_of(file: &str, change: impl Fn(&mut Log)) -> String {
    let robot = robot(file);
    let mut log = drive(&plain(&robot), &[], &Drive::default());
    change(&mut log);
    outcome(&robot, file, &csv(&log, &robot), "")
}

fn plain(robot: &Robot) -> ilon_identify::model::Model {
    ilon_identify::model::Model::new(robot, &[]).unwrap()
}

fn outcome(robot: &Robot, file: &str, text: &str, more: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), text).unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, study(robot, file, "log.csv", more)).unwrap();
    let found = Study::load(&path).and_then(|study| identify(&study, &|_| ()));
    match found {
        Ok(found) => {
            let mut words = "fine".to_owned();
            for odd in &found.doubts {
                let _ = write!(words, "; {} {}", odd.doubt.message, odd.doubt.help);
            }
            words
        }
        Err(Error::Contents { message, help, .. }) => format!("{message}; {help}"),
        Err(other) => format!("other: {other}"),
    }
}

fn wheel(log: &mut Log, wheel: usize, change: impl Fn(f64) -> f64) {
    log.angles_rad
        .iter_mut()
        .for_each(|row| row[wheel] = change(row[wheel]));
}

fn pose(log: &mut Log, change: impl Fn([f64; 3]) -> [f64; 3]) {
    log.poses.iter_mut().for_each(|pose| *pose = change(*pose));
}

#[track_caller]
fn holds(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "`{part}` is not in: {said}");
    }
}

/// Wheels that move back and forth by a thousandth of a turn command almost no turning: the robot's
/// turning is drift and gives no scale.
#[test]
fn a_straight_drive_that_drifts_is_not_doubted() {
    let robot = robot("mecanum4.toml");
    let mut log = Log::default();
    for row in 0..=60 {
        let time_s = 0.1 * f64::from(row);
        // Stretches of 1 s, alternately to the left and back: over all of them it goes with the
        // drift as often as against it.
        let within_s = time_s % 2.0;
        let turned_rad = 0.01 * within_s.min(2.0 - within_s);
        let (heading_rad, rolled_rad) = (0.03 * time_s, 4.0 * time_s);
        log.times_s.push(time_s);
        let sides = [-1.0, 1.0, -1.0, 1.0];
        log.angles_rad
            .push(sides.map(|side| rolled_rad + side * turned_rad).to_vec());
        let radius_m = 0.2 / 0.03;
        log.poses.push([
            radius_m * heading_rad.sin(),
            radius_m * (1.0 - heading_rad.cos()),
            heading_rad,
        ]);
        log.unseen.push(false);
    }
    let said = outcome(&robot, "mecanum4.toml", &csv(&log, &robot), "");
    assert_eq!(said, "fine");
}

#[test]
fn a_good_log_is_not_doubted() {
    for file in ["mecanum4.toml", "volksbot.toml", "mecanum6.toml"] {
        assert_eq!(said_of(file, |_| ()), "fine", "{file}");
    }
}

#[test]
fn wheels_that_are_swapped_are_named() {
    holds(
        &said(|log| log.angles_rad.iter_mut().for_each(|row| row.swap(0, 1))),
        &[
            "otherwise wired",
            "the columns of `front_left` and `front_right` are swapped",
        ],
    );
    holds(
        &said_of("volksbot.toml", |log| {
            log.angles_rad.iter_mut().for_each(|row| row.swap(1, 2))
        }),
        &["the columns of `wheel_2` and `wheel_3` are swapped"],
    );
}

/// On wide circles turning is a small part of the motion, but a robot that turns to the other side is
/// wired otherwise: no negative lever is advised.
#[test]
fn swapped_wheels_are_named_on_wide_circles_too() {
    let robot = robot("optiodom_differential.toml");
    let mut log = Log::default();
    for row in 0..=300 {
        let time_s = 0.1 * f64::from(row);
        let (circle_m, lever_m, radius_m, speed_m_s) = (0.85, 0.1, 0.042, 0.1);
        let heading_rad = speed_m_s * time_s / circle_m;
        log.times_s.push(time_s);
        let [left, right] =
            [-lever_m, lever_m].map(|side| (circle_m + side) * heading_rad / radius_m);
        log.angles_rad.push(vec![left, right]);
        log.poses.push([
            circle_m * heading_rad.sin(),
            circle_m * (1.0 - heading_rad.cos()),
            heading_rad,
        ]);
        log.unseen.push(false);
    }
    let outcome = |log: &Log| outcome(&robot, "optiodom_differential.toml", &csv(log, &robot), "");
    assert_eq!(outcome(&log), "fine");
    log.angles_rad.iter_mut().for_each(|row| row.swap(0, 1));
    holds(
        &outcome(&log),
        &[
            "the robot turns left where its wheels as stated turn it right",
            "the columns of `left` and `right` are swapped",
        ],
    );
}

/// Arms of 0.15 and 0.16 m give a lever of 0.31 m in the X and of 0.01 m in the O; with one axle
/// exchanged, its wheels have one lever and the others the other. The true robot has the other
/// handedness.
#[test]
fn wheels_that_are_handed_otherwise_are_named_and_no_lever_is_advised() {
    let stated = robot("mecanum4.toml");
    for (reversed, lever) in [
        (vec![0, 1, 2, 3], "then 10.0 mm in place of 310.0 mm"),
        (vec![0, 1], "then 160.0 mm in place of 310.0 mm"),
    ] {
        let mut other = stated.clone();
        other.wheels = ilon_control::handed(&stated.wheels, &reversed);
        let log = drive(&plain(&other), &[], &Drive::default());
        let said = outcome(&stated, "mecanum4.toml", &csv(&log, &stated), "");
        holds(
            &said,
            &[
                "with the other handedness",
                "`front_left`, `front_right`",
                lever,
            ],
        );
    }
}

#[test]
fn wheels_that_count_the_other_way_are_named() {
    holds(
        &said(|log| wheel(log, 2, |angle| -angle)),
        &["`rear_left` counts the other way"],
    );
    holds(
        &said(|log| {
            wheel(log, 1, |angle| -angle);
            wheel(log, 3, |angle| -angle);
        }),
        &["`front_right` and `rear_right` count the other way"],
    );
    holds(
        &said_of("volksbot.toml", |log| {
            (0..3).for_each(|which| wheel(log, which, |angle| -angle))
        }),
        &["all wheels count the other way"],
    );
}

#[test]
fn axes_of_the_tracker_that_are_turned_or_left_handed_are_named() {
    holds(
        &said(|log| pose(log, |[x, y, heading]| [x, -y, -heading])),
        &["left-handed"],
    );
    holds(
        &said(|log| pose(log, |[x, y, heading]| [x, -y, heading])),
        &["the tracker's y points to the other side"],
    );
    holds(
        &said(|log| pose(log, |[x, y, heading]| [-x, y, heading])),
        &["the tracker's x points the other way"],
    );
    holds(
        &said(|log| pose(log, |[x, y, heading]| [x, y, -heading])),
        &["the heading is counted clockwise"],
    );
    holds(
        &said(|log| pose(log, |[x, y, heading]| [y, x, heading])),
        &["the columns of x and y are swapped"],
    );
    holds(
        &said(|log| pose(log, |[x, y, heading]| [x, y, heading + 1.0])),
        &["moves -57 degrees off", "tracker's heading is turned"],
    );
    // Turned as well, no single axis and no other order of the wheels explains it.
    holds(
        &said(|log| pose(log, |[x, y, heading]| [x, y, -heading - 1.0])),
        &[
            "turns left where its wheels as stated turn it right",
            "likely the heading is counted clockwise: give it `scale = -1`; or wheels are swapped",
        ],
    );
}

#[test]
fn units_that_cannot_be_right_are_named() {
    holds(
        &said(|log| pose(log, |[x, y, heading]| [1e3 * x, 1e3 * y, heading])),
        &["lengths in mm that are stated in m"],
    );
    holds(
        &said(|log| pose(log, |[x, y, heading]| [x, y, heading.to_degrees()])),
        &["headings in deg that are stated in rad"],
    );
    holds(
        &said(|log| pose(log, |[x, y, heading]| [x, y, heading.to_radians()])),
        &["headings in rad that are stated in deg"],
    );
    let turns = |angle: f64| angle / std::f64::consts::TAU;
    holds(
        &said(|log| (0..4).for_each(|which| wheel(log, which, turns))),
        &["wheel angles in turns that are stated in radians"],
    );
    holds(
        &said(|log| (0..4).for_each(|which| wheel(log, which, f64::to_degrees))),
        &["wheel angles in degrees that are stated in radians"],
    );
    holds(
        &said(|log| (0..4).for_each(|which| wheel(log, which, |angle| 16.0 * angle))),
        &["likely a gear of 1:16"],
    );
    holds(
        &said(|log| (0..4).for_each(|which| wheel(log, which, |angle| 1e4 * angle))),
        &["rad/s on the mean", "ticks"],
    );
    holds(
        &said(|log| log.times_s.iter_mut().for_each(|t_s| *t_s *= 1e3)),
        &["rows are 20 s apart", "\"ms\""],
    );
}

#[test]
fn counters_that_begin_anew_are_named() {
    holds(
        &said(|log| {
            let at = log.angles_rad[2000].clone();
            for row in &mut log.angles_rad[2000..] {
                row.iter_mut().zip(&at).for_each(|(angle, at)| *angle -= at);
            }
        }),
        &["jumps by", "set to zero"],
    );
    holds(
        &said(|log| wheel(log, 0, |angle| angle.rem_euclid(std::f64::consts::TAU))),
        &["`front_left` jumps by", "counted within one turn"],
    );
    holds(
        &said(|log| wheel(log, 0, |angle| angle.rem_euclid(20.0))),
        &["`front_left` jumps by", "overflows every 3.18"],
    );
}

#[test]
fn gaps_are_named_and_stepped_over() {
    let said = said(|log| {
        for rows in [
            (&mut log.times_s) as &mut dyn Cut,
            &mut log.angles_rad,
            &mut log.poses,
            &mut log.unseen,
        ] {
            rows.cut(500, 600);
        }
    });
    holds(&said, &["fine", "1 gap in its times", "left out"]);
}

/// Removes rows from a column.
trait Cut {
    fn cut(&mut self, from: usize, to: usize);
}

impl<T> Cut for Vec<T> {
    fn cut(&mut self, from: usize, to: usize) {
        self.drain(from..to);
    }
}

#[test]
fn a_tracker_that_jumps_or_freezes_is_named() {
    holds(
        &said(|log| {
            log.poses[700..900]
                .iter_mut()
                .for_each(|pose| pose[0] += 0.5)
        }),
        &["fine", "the pose jumps by"],
    );
    holds(
        &said(|log| {
            let at = log.poses[700];
            log.poses[700..900].iter_mut().for_each(|pose| *pose = at);
        }),
        &["fine", "the pose is the same for"],
    );
}

#[test]
fn a_robot_that_stood_still_and_wheels_of_another_drive_are_named() {
    holds(
        &said(|log| (0..4).for_each(|which| wheel(log, which, |angle| 1e-5 * angle))),
        &["no wheel turns by more than"],
    );
    // Poses from another time of the drive.
    holds(
        &said(|log| log.poses.rotate_left(1300)),
        &["the wheels explain"],
    );
}

#[test]
fn times_that_do_not_grow_and_too_few_rows_are_named() {
    holds(
        &said(|log| log.times_s[100] = log.times_s[99]),
        &["times do not increase", "row 100"],
    );
    holds(
        &said(|log| {
            for rows in [
                (&mut log.times_s) as &mut dyn Cut,
                &mut log.angles_rad,
                &mut log.poses,
                &mut log.unseen,
            ] {
                rows.cut(6, 3001);
            }
        }),
        &["it has 6 rows", "as a row of `measured`", "heading_deg = "],
    );
}

#[test]
fn tables_that_are_not_as_stated_are_named_with_their_line() {
    let robot = robot("mecanum4.toml");
    let log = drive(&plain(&robot), &[], &Drive::default());
    let text = csv(&log, &robot);
    let of = |text: &str| outcome(&robot, "mecanum4.toml", text, "");
    holds(
        &of(&text.replacen("front_left,front_right,rear_left,rear_right", "k,l,m,n", 1)),
        &["the column `front_left` is missing", "its columns are"],
    );
    holds(
        &of(&text.replacen("front_left", "front_lefd", 1)),
        &[
            "the column `front_left` is missing",
            "did you mean `front_lefd`?",
        ],
    );
    holds(
        &of(&text.replace(',', ";")),
        &["separated by ';'", "`log.delimiter = \";\"`"],
    );
    holds(
        &of(&text.replacen("\n0.0200,", "\n0.02x,", 1)),
        &["line 3: `t` is text, but must be a number"],
    );
    let cut = &text[..text.len() - 12];
    holds(&of(cut), &["columns", "cut off"]);
    holds(&of("t,x\n"), &["the column", "is missing"]);
    holds(&of(""), &["it ends before line 1"]);
    holds(
        &of("t,x,y,heading,front_left,front_right,rear_left,rear_right\n"),
        &["it has 0 rows"],
    );
    let nan = text.replacen("\n0.0200,", "\nnan,", 1);
    holds(&of(&nan), &["line 3: `t` holds no number"]);
}

/// A drive that changes its twist thirty times, with the tracker late by several rows.
fn late(robot: &Robot, rows: usize) -> Log {
    let directions = (0..30).map(|leg| {
        let turn = 0.7 * f64::from(leg);
        [
            0.25 * libm::cos(turn),
            0.25 * libm::sin(2.3 * turn),
            0.6 * libm::sin(1.7 * turn),
        ]
    });
    let mut log = drive(
        &plain(robot),
        &[],
        &Drive {
            directions: directions.collect(),
            ..Drive::default()
        },
    );
    let poses = log.poses.clone();
    for row in (0..log.len()).rev() {
        log.poses[row] = poses[row.saturating_sub(rows)];
    }
    log
}

#[test]
fn poses_of_other_times_than_the_wheels_are_named_and_fitted() {
    let robot = robot("mecanum4.toml");
    let kept = csv(&late(&robot, 0), &robot);
    assert_eq!(outcome(&robot, "mecanum4.toml", &kept, ""), "fine");
    // Four rows of 0.02 s, plus 0.017 s, which is no whole number of rows.
    for (rows, clock_s) in [(4, 0.0), (4, 0.017), (0, -0.06)] {
        let mut log = late(&robot, rows);
        // The wheels' clock is behind: the wheel data beside a pose is from an earlier time.
        log = ilon_identify::delay::shifted(&log, -clock_s);
        let text = csv(&log, &robot);
        let truth_s = 0.02 * rows as f64 + clock_s;
        let said = outcome(&robot, "mecanum4.toml", &text, "");
        holds(
            &said,
            &[
                "the poses come",
                "s after the wheels",
                "`delay_s = \"fit\"`",
            ],
        );
        let found = identified(&robot, &text, "delay_s = \"fit\"");
        assert!(found.doubts.is_empty(), "{:?}", found.doubts);
        let delay = &found.parameters["tracker.delay_s"];
        let [Some(low), Some(high)] = delay.ci95 else {
            panic!("{delay:?}")
        };
        // 1.5 times the interval of 95 %: it contains the truth in 99.7 of 100 logs.
        let half = 0.75 * (high - low);
        assert!((delay.value - truth_s).abs() < half, "{truth_s}: {delay:?}");
        assert!(half < 2e-3, "{delay:?}");
        // With the delay removed the result is the true robot.
        let without = identified(&robot, &text, "");
        assert!(found.noise.position_m < 0.5 * without.noise.position_m);
        let known = identified(&robot, &text, &format!("delay_s = {truth_s}"));
        assert!(!known.parameters.contains_key("tracker.delay_s"));
        assert!((known.noise.position_m / found.noise.position_m - 1.0).abs() < 0.1);
    }
}

/// The identification of a log, with more keys in `[log]`.
fn identified(robot: &Robot, text: &str, more: &str) -> ilon_identify::Identified {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), text).unwrap();
    let path = folder.path().join("study.toml");
    let study = study(robot, "mecanum4.toml", "log.csv", "").replacen(
        "[log]\n",
        &format!("[log]\n{more}\n"),
        1,
    );
    std::fs::write(&path, study).unwrap();
    Study::load(&path)
        .and_then(|study| identify(&study, &|_| ()))
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_drive_that_never_changes_shows_no_delay() {
    let robot = robot("mecanum4.toml");
    let log = drive(
        &plain(&robot),
        &[],
        &Drive {
            directions: vec![[0.2, 0.1, 0.3]],
            ..Drive::default()
        },
    );
    let text = csv(&log, &robot);
    assert_eq!(outcome(&robot, "mecanum4.toml", &text, ""), "fine");
}

#[test]
fn decimals_with_commas_are_read_where_that_is_said() {
    let robot = robot("mecanum4.toml");
    let log = drive(&plain(&robot), &[], &Drive::default());
    let points = csv(&log, &robot);
    let commas = points.replace(',', ";").replace('.', ",");
    let as_stated = identified(&robot, &commas, "delimiter = \";\"\ndecimal_comma = true");
    let plain = identified(&robot, &points, "");
    assert_eq!(as_stated.parameters, plain.parameters);
    let parted = "delimiter = \";\"\n";
    let study = study(&robot, "mecanum4.toml", "log.csv", "").replacen(
        "[log]\n",
        &format!("[log]\n{parted}"),
        1,
    );
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), &commas).unwrap();
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let found =
        Study::load(folder.path().join("study.toml")).and_then(|study| identify(&study, &|_| ()));
    let Err(Error::Contents { help, .. }) = found else {
        panic!("it is refused")
    };
    holds(&help, &["`log.decimal_comma = true`"]);
}

/// An untrusted study may name any file as its log: of a file that is no log, no line, no name and
/// no cell is shown.
#[test]
fn of_files_that_are_no_logs_nothing_is_shown() {
    let robot = robot("mecanum4.toml");
    for (text, separator) in [
        // A header that holds the secret, with names that a study could guess.
        (
            "root:$6$SECRET:19000:0:99999:7:::\ndaemon:*:19000:0:99999:7:::\n",
            ":",
        ),
        ("TOKEN=SECRET\nHOME=/root\n", "="),
        ("SECRET=TOKEN\nHOME=/root\n", "="),
        ("t x y heading SECRET\nfour five six seven eight\n", " "),
        // Rows that hold it.
        (
            "t,x,y,heading,front_left,front_right,rear_left,rear_right\n1,2,3,4,SECRET,6,7,8\n",
            ",",
        ),
        (
            "t,x,y,heading,front_left,front_right,rear_left,rear_right\nSECRET,2,3,4,5,6,7,8\n",
            ",",
        ),
    ] {
        for header_line in [0, 1, 2] {
            for by_name in [true, false] {
                let said = log_said(&robot, text, separator, header_line, by_name);
                assert!(!said.contains("SECRET"), "{text}: {said}");
            }
        }
    }
}

/// The message for a log in a format that names its columns, or counts them from the left.
fn log_said(
    robot: &Robot,
    text: &str,
    separator: &str,
    header_line: usize,
    by_name: bool,
) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, text).unwrap();
    let wheels = robot.wheels.iter().map(|wheel| wheel.name.as_str());
    let mut format = format!("delimiter = {separator:?}\nheader_line = {header_line}\n");
    for (index, name) in ["t", "x", "y", "heading"]
        .into_iter()
        .chain(wheels)
        .enumerate()
    {
        let (key, unit) = match name {
            "t" => ("time".to_owned(), "s"),
            "x" | "y" => (name.to_owned(), "m"),
            "heading" => (name.to_owned(), "rad"),
            wheel => (format!("wheels.{wheel}"), "rad"),
        };
        // An attacker's guesses: names that such files begin with.
        let named = ["root", "TOKEN=SECRE", "t", "x"]
            .get(index)
            .unwrap_or(&name);
        let column = match by_name {
            true => format!("{named:?}"),
            false => (index + 1).to_string(),
        };
        let _ = writeln!(format, "{key} = {{ column = {column}, unit = {unit:?} }}");
    }
    let format: ilon_identify::log::Format = toml::from_str(&format).unwrap();
    let read = Log::read(&path, &format, robot, &ilon_files::FileAccess::anywhere());
    format!("{:?}", read.expect_err("it is no log"))
}
