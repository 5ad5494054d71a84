//! `ilon run ROBOT`: a robot alone, driven in five standard motions.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_sim::standard_motions::{StandardMotion, standard_motions};
use ilon_trace::Summary;
use ilon_trace::file::write_text;
use ilon_trace::metrics::TwistRatio;

use super::one::{Arguments, Told, one, print_json};
use crate::Scenario;
use crate::cli::escape::path_in_line;
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
    let mut scenarios = Vec::new();
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
        Simulation::with_robot(&scenario, &loaded)?;
        scenario.run.converge |= arguments.converge.converge;
        scenarios.push((motion, path, text, scenario));
    }
    std::fs::create_dir_all(&folder).map_err(|source| Failure::write(&folder, &source))?;
    for (_, path, text, _) in &scenarios {
        write_text(path, text)?;
    }
    let (mut told, mut summaries, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    for (motion, path, _, scenario) in &scenarios {
        let (json, summary) = one(
            path,
            scenario,
            folder.join(motion.name),
            arguments,
            Told::Together(&mut notes),
        )?;
        summaries.push(json);
        told.push((*motion, summary));
    }
    if !arguments.json {
        let robot = flags::shell(&robot.display().to_string());
        console::lines(&format!(
            "{}\nwritten to {}: a scenario and its report for each motion\nnext: change a scenario, or see what would look like a drift: `ilon explain {robot}{}`\n",
            table(&name, &told, has_rollers),
            path_in_line(&folder),
            arguments.settings.words()
        ))?;
    }
    print_json(arguments, &summaries)?;
    Ok(Outcome::Done)
}

/// The speed that the robot reached in each motion, the friction used, and the drift of odometry.
fn table(name: &str, told: &[(StandardMotion, Summary)], has_rollers: bool) -> Table {
    let mut table = Table::new();
    table.heading(&format!(
        "{name}: speed reached, in % of the command and of the ideal kinematics; most grip used, %; odometry drift, \
         mm per metre{}",
        if has_rollers { "; speed in % of the kinematics of the touching rollers" } else { "" }
    ));
    let percent =
        |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.1}", 1e2 * share));
    // Where the origin lies beside the axle, tyres move it sideways in turns: nobody asked for
    // that.
    let least = |motion: &StandardMotion, ratio: &TwistRatio| {
        let asked = motion.twist_in_body;
        let parts = [
            ratio.vx.filter(|_| asked.vx_m_s != 0.0),
            ratio.vy.filter(|_| asked.vy_m_s != 0.0),
            ratio.omega.filter(|_| asked.omega_rad_s != 0.0),
        ];
        percent(parts.into_iter().flatten().reduce(f64::min))
    };
    type Cell<'a> = (&'a str, &'a dyn Fn(&&(StandardMotion, Summary)) -> String);
    let columns: [Cell; 5] = [
        ("command", &|(motion, of)| {
            least(motion, &of.twist_ratio_asked)
        }),
        ("ideal", &|(motion, of)| {
            least(motion, &of.twist_ratio_ideal)
        }),
        ("grip", &|(_, of)| percent(of.friction_used_max)),
        ("odometry", &|(_, of)| {
            let drift = of.odometry_ideal.m_per_m;
            drift.map_or("-".to_owned(), |drift| format!("{:.1}", 1e3 * drift))
        }),
        ("contact", &|(motion, of)| {
            least(motion, &of.twist_ratio_contact)
        }),
    ];
    // Tyres have no kinematics of rollers that touch.
    let columns = &columns[..if has_rollers { 5 } else { 4 }];
    table.columns(columns, told.iter().map(|told| (told.0.name, told)));
    table
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
}
