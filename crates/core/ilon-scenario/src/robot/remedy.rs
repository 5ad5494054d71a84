//! Options with which a refused robot file can be used, worded for the user's interface.
//!
//! `ilon-robot` reports the faults of a file and the options that would help. How to set an option
//! depends on where the file was named: [`Keys`] words it for a scenario, and a program with
//! another interface in its own way.

use std::path::Path;

use ilon_control::{Arrangement, Kinematics};
use ilon_formats::{
    Fault, Handedness, LoadOptions, LoadRobot, Loaded, Package, Question, Remedy, RobotError,
    TyreOptions,
};
use ilon_robot::Robot;

use crate::Error;

/// Options are proposed only for robots whose fastest direction is less than this many times as
/// fast as their slowest; built robots are below ten. Chosen.
const MOST_CONDITION: f64 = 50.0;

/// The wording of the options of reading a robot.
pub trait Wording {
    /// How to set the location of a package.
    fn package(&self, name: &str) -> String;

    /// The questions that only a person can answer, with the other options needed, given that
    /// `options` were set; the options to roll on tyres instead, or why that fails.
    fn question(
        &self,
        question: &Question,
        options: &LoadOptions,
        on_tyres: Option<Result<LoadOptions, String>>,
    ) -> String;

    /// That `proposal` works, given that `options` were set.
    fn proposed(&self, proposal: &LoadOptions, options: &LoadOptions) -> String;
}

/// The blank of the wheels' radius.
const RADIUS: &str = "wheel_radius_m = METRES";

/// Worded as keys of a scenario's `[robot]`.
#[derive(Clone, Copy, Debug)]
pub struct Keys;

impl Wording for Keys {
    fn package(&self, name: &str) -> String {
        format!("`packages = {{ {name} = \"FOLDER\" }}` in `[robot]`")
    }

    fn question(
        &self,
        question: &Question,
        options: &LoadOptions,
        on_tyres: Option<Result<LoadOptions, String>>,
    ) -> String {
        let asked = question.asked.iter().filter_map(|remedy| {
            Some(match remedy {
                Remedy::WhichRollers { wheels, parallel } => format!(
                    "wheels = {{ rollers = NUMBER, gamma.{} = ANGLE, joints = [{}] }}",
                    if *parallel { "x_deg" } else { "all_deg" },
                    quoted(wheels)
                ),
                Remedy::WheelRadius { guess_m: None } => RADIUS.to_owned(),
                _ => return None,
            })
        });
        let known = keys(&with_blank_arguments(question), options);
        let keys: Vec<String> = known.into_iter().chain(asked).collect();
        let blanks = blanks(question);
        let on_tyres = on_tyres.map(|on_tyres| match on_tyres {
            Ok(on_tyres) => {
                let mut keys = self::keys(&on_tyres, options);
                keys.extend(question.stand_in_m.map(|_| RADIUS.to_owned()));
                format!("; on tyres: `{}`", keys.join("`, `"))
            }
            Err(why) => format!("; on tyres it cannot drive either: {why}"),
        });
        format!(
            "fill in {blanks}, in `[robot]`: `{}`{}",
            keys.join("`, `"),
            on_tyres.unwrap_or_default()
        )
    }

    fn proposed(&self, proposal: &LoadOptions, options: &LoadOptions) -> String {
        let keys = keys(proposal, options).join("`, `");
        format!("this works, in `[robot]`: `{keys}`")
    }
}

/// The options of a question, with VALUE for each requested argument of the file.
pub fn with_blank_arguments(question: &Question) -> LoadOptions {
    let mut options = question.options.clone();
    for remedy in &question.asked {
        if let Remedy::Argument { name, .. } = remedy {
            options.arguments.insert(name.clone(), "VALUE".to_owned());
        }
    }
    options
}

/// The options with which the wheels of a question roll on tyres instead of rollers, if no more
/// than their radius is asked for besides and their axles are parallel, or why they do not drive.
/// Where other wheels turn beside them, as those behind steered ones, all are taken.
fn tyres_instead(question: &Question, path: &Path) -> Option<Result<LoadOptions, String>> {
    let is_other = |remedy: &&Remedy| !matches!(remedy, Remedy::WheelRadius { .. });
    let others: Vec<&Remedy> = question.asked.iter().filter(is_other).collect();
    let [
        Remedy::WhichRollers {
            wheels,
            parallel: true,
        },
    ] = &others[..]
    else {
        return None;
    };
    let tried = |tyres: TyreOptions| {
        let mut options = question.options.clone();
        options.tyres = Some(tyres);
        let mut sized = options.clone();
        sized.wheel_radius_m = question.stand_in_m.or(options.wheel_radius_m);
        let loaded = Robot::load_with(path, &sized).map_err(|error| error.to_string())?;
        Kinematics::new(&loaded.robot).map_err(|error| error.to_string())?;
        Ok((options, loaded.robot))
    };
    let all = tried(TyreOptions::default()).ok().filter(|(_, robot)| {
        let is_in = |name: &String| robot.wheels.iter().any(|wheel| wheel.name == *name);
        robot.wheels.len() > wheels.len() && wheels.iter().all(is_in)
    });
    let found = all.map_or_else(|| tried(TyreOptions::on(wheels.clone())), Ok);
    let found = found.map(|(options, _)| options);
    // The radius that was tested may be what fails.
    Some(found).filter(|found| found.is_ok() || question.stand_in_m.is_none())
}

/// Describes the blanks of [`Wording::question`] that a person has to fill in.
pub fn blanks(question: &Question) -> String {
    let asked = |is: fn(&Remedy) -> bool| question.asked.iter().any(is);
    let mut blanks = Vec::new();
    if asked(|remedy| matches!(remedy, Remedy::Argument { .. })) {
        blanks.push("VALUE");
    }
    if asked(|remedy| matches!(remedy, Remedy::WhichRollers { .. })) {
        blanks.push("the NUMBER of rollers on a wheel");
        blanks.push("their ANGLE (45 of usual mecanum wheels, 0 of omni wheels)");
    }
    if question.stand_in_m.is_some() {
        blanks.push("the wheels' radius in METRES");
    }
    match &blanks[..] {
        [rest @ .., last] if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => blanks.concat(),
    }
}

/// The keys of a scenario's `[robot]` for the differences between two sets of options.
pub fn keys(options: &LoadOptions, beyond: &LoadOptions) -> Vec<String> {
    let text = |text: &str| toml::Value::from(text).to_string();
    let said = |key: &str| Some(key.to_owned());
    let set = |key: &str, value: Option<f64>| value.map(|value| format!("{key} = {value}"));
    let table = |key: &str, inner: Vec<String>| Some(format!("{key} = {{ {} }}", inner.join(", ")));
    let listed = |key: &str, joints: &[String]| {
        (!joints.is_empty()).then(|| format!("{key} = [{}]", quoted(joints)))
    };
    let package = |of: &Package| {
        let folder = of.folder.display().to_string();
        format!("{} = {}", of.name, text(&folder))
    };
    let packages = options.packages.iter().map(package).collect();
    let arguments = options.arguments.iter();
    let arguments = arguments.map(|(name, value)| format!("{name} = {}", text(value)));
    let wheels = options.wheels.as_ref().and_then(|wheels| {
        let mut inner = vec![format!("rollers = {}", wheels.rollers)];
        inner.push(match &wheels.gamma {
            Handedness::XDeg(gamma_deg) => format!("gamma.x_deg = {}", rounded(*gamma_deg)),
            Handedness::AllDeg(gamma_deg) => format!("gamma.all_deg = {}", rounded(*gamma_deg)),
            Handedness::EachDeg(gammas_deg) => {
                let gammas: Vec<String> = gammas_deg.iter().map(|x| rounded(*x)).collect();
                format!("gamma.each_deg = [{}]", gammas.join(", "))
            }
        });
        inner.extend(listed("joints", &wheels.joints));
        table("wheels", inner)
    });
    let tyres = options.tyres.as_ref().and_then(|tyres| {
        let inner = [
            listed("joints", &tyres.joints),
            listed("free", &tyres.free),
            set("width_m", tyres.width_m),
            set("shoulder_radius_m", tyres.shoulder_radius_m),
        ];
        table("tyres", inner.into_iter().flatten().collect())
    });
    let density = set("density_kg_m3", options.density_kg_m3);
    let leaves_out = options.leave_out_missing && !beyond.leave_out_missing;
    let infers_none = !options.infer_rollers && beyond.infer_rollers;
    let radius = set("wheel_radius_m", options.wheel_radius_m);
    let all = [
        (
            options.packages != beyond.packages,
            table("packages", packages),
        ),
        (options.density_kg_m3 != beyond.density_kg_m3, density),
        (infers_none, said("infer_rollers = false")),
        (
            options.arguments != beyond.arguments,
            table("args", arguments.collect()),
        ),
        (leaves_out, said("leave_out_missing = true")),
        (options.repair && !beyond.repair, said("repair = true")),
        (
            options.rollers != beyond.rollers,
            said("rollers = \"as_modelled\""),
        ),
        (options.wheels != beyond.wheels, wheels),
        (options.tyres != beyond.tyres, tyres),
        (options.wheel_radius_m != beyond.wheel_radius_m, radius),
    ];
    let differing = all.into_iter().filter(|(differs, _)| *differs);
    differing.filter_map(|(_, key)| key).collect()
}

/// Names as a TOML list.
fn quoted(names: &[String]) -> String {
    let names = names
        .iter()
        .map(|name| toml::Value::from(name.as_str()).to_string());
    names.collect::<Vec<_>>().join(", ")
}

/// An angle without the rounding noise of its last digits.
pub fn rounded(degrees: f64) -> String {
    let rounded = (1e6 * degrees).round() / 1e6;
    format!("{}", rounded + 0.0)
}

/// Why a robot's file is refused, and what would help.
#[derive(Debug)]
pub struct Refusal {
    /// All of its faults; at least one.
    pub faults: Vec<RobotError>,
    /// Remedies for all of them, in words.
    pub closing: Vec<String>,
    /// The robot read with the proposed options, if there are any.
    pub loaded: Option<Box<Loaded>>,
}

impl Refusal {
    /// The refusal of a file that could not be read with `options`; `first` is its first fault.
    pub fn of(
        first: RobotError,
        path: &Path,
        options: &LoadOptions,
        wording: &impl Wording,
    ) -> Self {
        // A robot that hardly moves in one direction was misunderstood, even if it can be run.
        let drives = |robot: &Robot| {
            Kinematics::new(robot).is_ok()
                && Arrangement::of(robot).is_ok_and(|of| of.condition < MOST_CONDITION)
        };
        let diagnosis = Robot::diagnose(path, options, drives);
        let faults = if diagnosis.faults.is_empty() {
            vec![first]
        } else {
            diagnosis.faults
        };
        let lacks_files = |of: &RobotError| matches!(of.fault(), Fault::MissingFiles { .. });
        let is_incomplete = faults.iter().any(lacks_files);
        let mut advice: Vec<String> = Vec::new();
        for remedy in faults.iter().flat_map(RobotError::remedies) {
            if let Remedy::Package { name, folder: None } = remedy {
                let package = wording.package(&name);
                if !advice.contains(&package) {
                    advice.push(package);
                }
            }
        }
        let mut closing = Vec::new();
        if !advice.is_empty() {
            closing.push(format!("say {}", advice.join(", ")));
        }
        let question = diagnosis.question.as_ref();
        closing.extend(question.map(|question| {
            let on_tyres = tyres_instead(question, path);
            match (&question.in_the_way, on_tyres) {
                (None, on_tyres) => wording.question(question, options, on_tyres),
                // Rollers cannot be put in, whichever they are.
                (Some(_), Some(Ok(on_tyres))) if question.stand_in_m.is_some() => {
                    let mut of_size = question.clone();
                    of_size.asked = vec![Remedy::WheelRadius { guess_m: None }];
                    of_size.options = on_tyres;
                    wording.question(&of_size, options, None)
                }
                (Some(_), Some(Ok(on_tyres))) => wording.proposed(&on_tyres, options),
                // What is missing may hold what the rest lacks.
                (Some(what), _) if is_incomplete => {
                    format!("without what is missing this stands in the way: {what}")
                }
                (Some(what), _) => format!(
                    "no option is enough: whatever else is said, this stands in the way: {what}"
                ),
            }
        }));
        let proposal = diagnosis.proposal.as_ref();
        closing.extend(proposal.map(|proposal| wording.proposed(proposal, options)));
        Self {
            faults,
            closing,
            loaded: diagnosis.loaded,
        }
    }
}

/// All faults of a robot's file, with options that work if there are any.
pub fn diagnosed(
    first: RobotError,
    path: &Path,
    options: &LoadOptions,
    wording: &impl Wording,
) -> Error {
    let refusal = Refusal::of(first, path, options, wording);
    Error::of_robot(refusal.faults, &refusal.closing)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closing remedies for three omni wheels 0.2 m from the middle that turn the robot with a
    /// given lever, in metres. Their chassis has no inertia, which a repair computes.
    fn closing(lever_m: f64) -> Vec<String> {
        let part = |name: &str, inertia: &str| {
            format!(
                r#"<link name="{name}"><inertial><mass value="1"/>{inertia}</inertial><collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision></link>"#
            )
        };
        let disc = r#"<inertia ixx="7e-4" ixy="0" ixz="0" iyy="1.2e-3" iyz="0" izz="7e-4"/>"#;
        let mut text = part("base", "");
        for i in 0..3 {
            let (angle, name) = (
                std::f64::consts::TAU * f64::from(i) / 3.0,
                format!("omni_{i}"),
            );
            // With the hub axis, y of its frame, along the tangent, the lever is zero.
            let yaw = angle + (lever_m / 0.2).asin();
            let (s, c) = angle.sin_cos();
            text += &part(&name, disc);
            text += &format!(
                r#"<joint name="{name}_joint" type="continuous"><parent link="base"/><child link="{name}"/><origin xyz="{} {} 0" rpy="0 0 {yaw}"/><axis xyz="0 1 0"/></joint>"#,
                0.2 * c,
                0.2 * s
            );
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.urdf");
        std::fs::write(&path, format!(r#"<robot name="r">{text}</robot>"#)).unwrap();
        let options = LoadOptions::default();
        let first = Robot::load(&path).expect_err("no inertia");
        Refusal::of(first, &path, &options, &Keys).closing
    }

    #[test]
    fn no_robot_is_proposed_that_hardly_moves_one_way() {
        // The columns of M are orthogonal, of lengths sqrt(3 / 2), sqrt(3 / 2) and sqrt(3) lever:
        // the condition is 0.2 m / (sqrt(2) lever), 0.7, 7 and 71.
        let works = |closing: &[String]| closing.iter().any(|words| words.contains("works"));
        assert!(works(&closing(0.2)));
        assert!(works(&closing(0.02)));
        assert!(!works(&closing(0.002)));
    }

    /// Three wheels on parallel axles roll on tyres, but do not turn the robot where their ways are
    /// one line, though balls at the sides keep it upright: they are proposed only beside another.
    #[test]
    fn tyres_are_proposed_only_where_they_drive() {
        let inertial = r#"<inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>"#;
        let closing = |aside_m: f64| {
            let ball = |y: f64| {
                format!(
                    r#"<collision><origin xyz="0 {y} 0"/><geometry><sphere radius="0.05"/></geometry></collision>"#
                )
            };
            let mut text = format!(
                r#"<link name="base">{inertial}{}{}</link>"#,
                ball(0.3),
                ball(-0.3)
            );
            for (name, x, y) in [("a", 0.2, 0.0), ("b", 0.0, aside_m), ("c", -0.2, 0.0)] {
                text += &format!(
                    r#"<link name="{name}"><inertial><mass value="1"/><inertia ixx="7e-4" ixy="0" ixz="0" iyy="1.2e-3" iyz="0" izz="7e-4"/></inertial><collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision></link><joint name="{name}_joint" type="continuous"><parent link="base"/><child link="{name}"/><origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/></joint>"#
                );
            }
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("r.urdf");
            std::fs::write(&path, format!(r#"<robot name="r">{text}</robot>"#)).unwrap();
            let first = Robot::load(&path).expect_err("no rollers");
            Refusal::of(first, &path, &LoadOptions::default(), &Keys)
                .closing
                .join("; ")
        };
        let [in_line, aside] = [closing(0.0), closing(0.2)];
        assert!(aside.contains("tyres = { joints"), "{aside}");
        assert!(!in_line.contains("tyres = { joints"), "{in_line}");
    }

    /// The keys of given tyres are read as the same tyres.
    #[test]
    fn all_keys_of_tyres_are_written() {
        let text =
            "joints = [\"l\", \"r\"]\nfree = [\"c\"]\nwidth_m = 0.04\nshoulder_radius_m = 0.01\n";
        let mut options = LoadOptions::default();
        options.tyres = Some(toml::from_str(text).expect("tyres"));
        let written = keys(&options, &LoadOptions::default()).concat();
        let read: toml::Table = toml::from_str(&written).expect("a key");
        let tyres = read["tyres"].clone().try_into().expect("tyres");
        assert_eq!(Some(tyres), options.tyres, "{written}");
    }

    #[test]
    fn angles_lose_the_noise_of_their_last_digits() {
        assert_eq!(rounded(-45.00000000000001), "-45");
        assert_eq!(rounded(-0.0), "0");
        assert_eq!(rounded(33.75), "33.75");
    }
}
