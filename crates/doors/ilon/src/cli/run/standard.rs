//! `ilon run ROBOT`: a robot alone, driven in five standard motions.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_sim::causes::Drift;
use ilon_sim::gathered;
use ilon_sim::standard_motions::{StandardMotion, standard_motions};
use ilon_trace::Summary;
use ilon_trace::file::write_text;
use ilon_trace::metrics::TwistRatio;

use super::one::{Arguments, Told, one, print_json};
use crate::Scenario;
use crate::cli::escape::{folded, path_in_line};
use crate::cli::failure::Failure;
use crate::cli::outcome::Outcome;
use crate::cli::robot::{robot_alone, robot_line};
use crate::cli::table::Table;
use crate::cli::{console, flags};
use crate::simulate::{Simulation, load_robot};

/// First line of each scenario written for a robot, which distinguishes it from one that the user
/// changed.
const WRITTEN: &str = "#: A standard motion, as `ilon run` writes it for a robot alone. Change it under another name.\n";

/// Writes a scenario for each motion, runs them, and prints the robot's result in each.
pub(super) fn run(
    robot: &Path,
    arguments: &Arguments,
    files: &FileAccess,
) -> Result<Outcome, Failure> {
    let name = robot
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let folder = match arguments.out.to_str() {
        Some("out/<scenario>") => PathBuf::from("out").join(&name),
        _ => arguments.out.clone(),
    };
    // No motion lasts longer.
    let standing = "twist = {}\nrun.duration_s = 60.0\n";
    let standing = robot_alone(
        robot,
        standing,
        &arguments.settings.settings,
        &arguments.sandbox,
    )?;
    let loaded = load_robot(&standing)?;
    let has_rollers = loaded.wheels.iter().any(|wheel| !wheel.has_tyre());
    let motions = standard_motions(&loaded)?;
    if motions.iter().all(Option::is_none) {
        return Err(Failure::usage(
            format!(
                "none of the standard motions fits `{name}`: its tyres roll along neither x of its frame, which is ahead, nor y"
            ),
            "drive it by a scenario with `[twist]`; `ilon inspect` shows where its wheels stand",
        ));
    }
    let (mut scenarios, mut notes) = (Vec::new(), Vec::new());
    for motion in motions.into_iter().flatten() {
        let path = folder.join(format!("{}.toml", motion.name));
        let text = format!("{}{}", robot_line(robot)?, motion.toml());
        let text = Scenario::text_with(&text, motion.name, &arguments.settings.settings)?;
        let text = format!("{WRITTEN}\n{text}");
        if std::fs::read_to_string(&path).is_ok_and(|there| !there.starts_with(WRITTEN)) {
            return Err(Failure::usage(
                format!(
                    "`{}` is there already, and was not written by this command",
                    path.display()
                ),
                "move it elsewhere, or choose another folder with --out",
            ));
        }
        let mut scenario = Scenario::from_text(&text, &path, &[], files)?;
        // What only the world refuses, such as a map that is not there, is refused before any file
        // is written.
        let simulation = Simulation::with_robot(&scenario, &loaded)?;
        notes.push(gathered(simulation.warnings()));
        scenario.run.converge |= arguments.converge.converge;
        scenarios.push((motion, path, text, scenario));
    }
    std::fs::create_dir_all(&folder).map_err(|source| Failure::write(&folder, &source))?;
    for (_, path, text, _) in &scenarios {
        write_text(path, text)?;
    }
    let mut shared = notes.first().cloned().unwrap_or_default();
    shared.retain(|note| notes.iter().all(|notes| notes.contains(note)));
    for note in &shared {
        console::note(&format!("note: {note}"));
    }
    let (mut told, mut summaries) = (Vec::new(), Vec::new());
    for (motion, path, _, scenario) in &scenarios {
        let (json, summary) = one(
            path,
            scenario,
            folder.join(motion.name),
            arguments,
            Told::Together(&shared),
        )?;
        summaries.push(json);
        told.push((*motion, summary));
    }
    if !arguments.json {
        let robot = flags::shell(&robot.display().to_string());
        let next = format!(
            "next: change a scenario; if your real robot drifts, see which causes look like it: `ilon explain {robot}{}`",
            arguments.settings.words()
        );
        console::lines(&format!(
            "{}\nwritten to {}: a scenario and its report for each motion\n{}\n",
            table(&name, &told, has_rollers),
            path_in_line(&folder),
            folded(&next)
        ))?;
    }
    print_json(arguments, &summaries)?;
    Ok(Outcome::Done)
}

/// The speed that the robot reached in each motion, what took the rest of the command, its drift, and
/// the friction used.
fn table(name: &str, told: &[(StandardMotion, Summary)], has_rollers: bool) -> Table {
    let mut table = Table::new();
    table.heading(&format!(
        "{name}: speed reached, as share of the command; what is missing in the wheels' speeds, and what {} takes; drift from the command \
         once the motion is steady, + ahead and to the left, and of wheel odometry, per metre or per turn; most grip used",
        if has_rollers {
            "roller geometry and the rest (slip, lift-off, wheels that work against each other)"
        } else {
            "slip"
        }
    ));
    type Cell<'a> = (&'a str, &'a dyn Fn(&&(StandardMotion, Summary)) -> String);
    let drift = |of: &Summary, part: fn(&Drift) -> f64| {
        Drift::from_command(of).map_or(f64::NAN, |drift| part(&drift))
    };
    let mm = |x_m: f64| with_sign(1e3 * x_m, 1, " mm");
    let [rest, rollers] = match has_rollers {
        true => ["rest", "rollers"],
        false => ["slip", ""],
    };
    let share = |of: &Shares, part: usize| percent(of.missing[part]);
    let columns: [Cell; 9] = [
        ("speed", &|(motion, of)| {
            percent(Shares::of(motion, of, has_rollers).reached)
        }),
        ("wheels", &|(motion, of)| {
            share(&Shares::of(motion, of, has_rollers), 0)
        }),
        (rollers, &|(motion, of)| {
            share(&Shares::of(motion, of, has_rollers), 1)
        }),
        (rest, &|(motion, of)| {
            share(&Shares::of(motion, of, has_rollers), 2)
        }),
        ("ahead", &|(_, of)| mm(drift(of, |drift| drift.ahead_m))),
        ("left", &|(_, of)| mm(drift(of, |drift| drift.left_m))),
        ("turn", &|(_, of)| {
            with_sign(drift(of, |drift| drift.turned_rad).to_degrees(), 2, "°")
        }),
        ("odometry", &|(_, of)| {
            let drift = of.odometry_ideal.m_per_m;
            drift.map_or("-".to_owned(), |drift| format!("{:.1} mm", 1e3 * drift))
        }),
        ("grip", &|(_, of)| percent(of.friction_used_max)),
    ];
    // Tyres have no kinematics of rollers that touch.
    let columns = columns.into_iter().filter(|(name, _)| !name.is_empty());
    let columns: Vec<Cell> = columns.collect();
    table.columns(&columns, told.iter().map(|told| (told.0.name, told)));
    table
}

/// The component of a motion that falls shortest, as shares of the command that make 1 together.
struct Shares {
    reached: Option<f64>,
    /// In the wheels' speeds, by the rollers' geometry, and the rest; `None` if unknown.
    missing: [Option<f64>; 3],
}

impl Shares {
    fn of(motion: &StandardMotion, of: &Summary, has_rollers: bool) -> Self {
        // Where the origin lies beside the axle, tyres move it sideways in turns: nobody asked for
        // that.
        let asked = |ratio: &TwistRatio| {
            let asked = motion.twist_in_body;
            [
                ratio.vx.filter(|_| asked.vx_m_s != 0.0),
                ratio.vy.filter(|_| asked.vy_m_s != 0.0),
                ratio.omega.filter(|_| asked.omega_rad_s != 0.0),
            ]
        };
        let reached = asked(&of.twist_ratio_asked);
        let known = (0..3).filter_map(|axis| Some((axis, reached[axis]?)));
        let least = known.min_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((axis, reached)) = least else {
            return Self {
                reached: None,
                missing: [None; 3],
            };
        };
        // What the wheels' speeds give, and what is left of it by the rollers that touch, over the
        // command.
        let by_wheels = asked(&of.twist_ratio_ideal)[axis].map(|ideal| reached / ideal);
        let by_contact = match has_rollers {
            true => asked(&of.twist_ratio_contact)[axis].map(|contact| reached / contact),
            false => by_wheels,
        };
        let less = |a: Option<f64>, b: Option<f64>| Some(a? - b?);
        Self {
            reached: Some(reached),
            missing: [
                less(Some(1.0), by_wheels),
                less(by_wheels, by_contact),
                less(by_contact, Some(reached)),
            ],
        }
    }
}

fn percent(share: Option<f64>) -> String {
    let shown = share.filter(|share| share.is_finite());
    shown.map_or("-".to_owned(), |share| {
        // A zero has no sign.
        let text = format!("{:.1} %", 1e2 * share);
        text.strip_prefix("-0.0 ")
            .map_or(text.clone(), |rest| format!("0.0 {rest}"))
    })
}

/// A number with its sign, but a zero; a dash for one that is none.
fn with_sign(x: f64, decimals: usize, unit: &str) -> String {
    match format!("{x:+.decimals$}") {
        _ if !x.is_finite() => "-".to_owned(),
        zero if !zero.contains(|c| matches!(c, '1'..='9')) => format!("0{unit}"),
        number => number + unit,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    /// On the spot such an origin moves sideways by its distance from the axle, which is no part of
    /// the command: its share can be anything.
    #[test]
    fn shares_are_those_of_the_components_that_are_asked_for() {
        let urdf = include_str!("../../../../../../assets/robots/differential.urdf");
        let robot = ilon_robot::Robot::from_urdf_str(urdf, "robot.urdf").expect("a robot");
        let turn = standard_motions(&robot).expect("it can be driven")[4].expect("it can turn");
        let mut summary = Summary::default();
        for ratio in [
            &mut summary.twist_ratio_asked,
            &mut summary.twist_ratio_ideal,
        ] {
            (ratio.vy, ratio.omega) = (Some(-2.79), Some(0.576));
        }
        let shown = table("robot", &[(turn, summary)], false).to_string();
        assert!(shown.contains("57.6") && !shown.contains("279"), "{shown}");
    }

    /// A robot that slides away while it is to turn, and one that goes the other way: shares keep
    /// their sign, and drifts are of the command.
    #[test]
    fn what_goes_elsewhere_is_shown_with_its_sign() {
        let robot =
            ilon_robot::Robot::load("../../../assets/robots/mecanum4.toml").expect("a robot");
        let motions = standard_motions(&robot).expect("four wheels");
        let cells = |motion: usize, summary: Summary| {
            let motion = motions[motion].expect("on rollers");
            let shown = table("robot", &[(motion, summary)], true).to_string();
            assert!(!shown.contains("\\n"), "{shown}");
            let row = shown.lines().last().expect("a row").to_owned();
            let cells = row.split("  ").map(|cell| cell.trim().to_owned());
            cells.filter(|cell| !cell.is_empty()).collect::<Vec<_>>()
        };
        let mut back = Summary::default();
        (back.travelled_m, back.duration_s) = (1.0, 10.0);
        back.twist_asked_mean = Some(ilon_robot::Twist::new(0.3, 0.0, 0.0));
        back.twist_mean = Some(ilon_robot::Twist::new(-0.3, 0.0, 0.0));
        back.twist_ratio_asked.vx = Some(-1.0);
        back.twist_ratio_ideal.vx = Some(f64::NAN);
        back.twist_ratio_contact.vx = Some(0.0);
        let shown = cells(0, back);
        assert_eq!(shown[1..6], ["-100.0 %", "-", "-", "-", "-2000.0 mm"]);
        let mut slid = Summary::default();
        (slid.travelled_m, slid.duration_s, slid.turned_rad) = (2.0, 10.0, 3.0);
        slid.twist_asked_mean = Some(ilon_robot::Twist::new(1e-9, 0.0, 6.0));
        slid.twist_mean = Some(ilon_robot::Twist::new(0.0, 0.0, 0.3));
        // 0.95 of each turn is missing.
        assert_eq!(cells(4, slid)[7], "-342.00°");
        assert_eq!(cells(4, Summary::default())[5..8], ["-"; 3]);
    }

    /// A mecanum robot that moves to the left at 0.29 m/s where 0.3 m/s are commanded, and to the
    /// right of the command by 0.003 m/s, is 10 mm/0.3 m short and 3 mm/0.3 m off; its wheels turn
    /// 1 % too slowly, and what its rollers take is in their kinematics, which it follows to 0.5 %.
    /// With what it reached the shares make the whole command.
    #[test]
    fn drifts_and_what_takes_the_rest_have_columns_of_their_own() {
        let robot =
            ilon_robot::Robot::load("../../../assets/robots/mecanum4.toml").expect("a robot");
        let left = standard_motions(&robot).expect("four wheels")[1].expect("on rollers");
        let mut summary = Summary::default();
        summary.travelled_m = 1.0;
        summary.twist_asked_mean = Some(ilon_robot::Twist::new(0.0, 0.3, 0.0));
        summary.twist_mean = Some(ilon_robot::Twist::new(0.003, 0.29, 0.0));
        summary.twist_ratio_asked.vy = Some(0.29 / 0.3);
        summary.twist_ratio_ideal.vy = Some(0.29 / 0.297);
        summary.twist_ratio_contact.vy = Some(0.995);
        let shown = table("robot", &[(left, summary)], true).to_string();
        let row = shown.lines().last().expect("a row");
        let cells: Vec<&str> = row
            .split("  ")
            .map(str::trim)
            .filter(|cell| !cell.is_empty())
            .collect();
        // 1 - 0.99, 0.99 - 0.9667 / 0.995 and 0.9667 / 0.995 - 0.9667; over 1 m of the command.
        assert_eq!(
            cells,
            [
                "left", "96.7 %", "1.0 %", "1.8 %", "0.5 %", "+10.0 mm", "-33.3 mm", "0°", "-", "-"
            ],
            "{shown}"
        );
    }
}
