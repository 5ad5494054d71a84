//! How options of reading a robot are asked for: as flags of the command line, and as keys of a scenario.
//!
//! The library says what is wrong with a file and which options would do; the words for them are here.

use std::path::Path;

use ilon_robot::{
    Handedness, LoadOptions, Loaded, Remedy, Robot, RobotError, RollerForms, WheelOptions,
};

use crate::Error;
use crate::control::Kinematics;

/// The flags that ask for options.
pub(crate) fn flags(options: &LoadOptions) -> Vec<String> {
    let mut flags = Vec::new();
    for package in &options.packages {
        let named = format!("{}={}", package.name, package.folder.display());
        flags.push(format!("--package {}", shell(&named)));
    }
    for (name, value) in &options.arguments {
        flags.push(format!("--arg {}", shell(&format!("{name}={value}"))));
    }
    if options.leave_out_missing {
        flags.push("--leave-out-missing".to_owned());
    }
    if options.repair {
        flags.push("--repair".to_owned());
    }
    if let Some(density) = options.density_kg_m3 {
        flags.push(format!("--density-kg-m3 {density}"));
    }
    if options.rollers == RollerForms::AsModelled {
        flags.push("--as-modelled".to_owned());
    }
    if !options.infer_rollers {
        flags.push("--no-inferred-rollers".to_owned());
    }
    if let Some(wheels) = &options.wheels {
        flags.extend(wheel_flags(wheels));
    }
    if let Some(radius_m) = options.wheel_radius_m {
        flags.push(format!("--wheel-radius-m {radius_m}"));
    }
    flags
}

fn wheel_flags(wheels: &WheelOptions) -> Vec<String> {
    let mut flags = vec![format!("--rollers {}", wheels.rollers)];
    let listed = |numbers: &[f64]| {
        let numbers: Vec<String> = numbers.iter().map(|x| rounded(*x)).collect();
        numbers.join(",")
    };
    flags.push(match &wheels.gamma {
        Handedness::XDeg(gamma_deg) => format!("--gamma-x-deg {}", rounded(*gamma_deg)),
        Handedness::AllDeg(gamma_deg) => format!("--gamma-deg {}", rounded(*gamma_deg)),
        Handedness::EachDeg(gammas_deg) => format!("--gamma-deg {}", listed(gammas_deg)),
    });
    if !wheels.joints.is_empty() {
        flags.push(format!("--wheels {}", shell(&wheels.joints.join(","))));
    }
    for (flag, value) in [
        ("--roller-radius-m", wheels.roller_radius_m),
        ("--roller-mass-kg", wheels.roller_mass_kg),
    ] {
        flags.extend(value.map(|value| format!("{flag} {value}")));
    }
    flags
}

/// An angle without the noise of its last digits.
fn rounded(degrees: f64) -> String {
    let rounded = (1e6 * degrees).round() / 1e6;
    format!("{}", rounded + 0.0)
}

/// A word as a shell takes it.
pub(crate) fn shell(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./=,:+-@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// The keys of a scenario's `[robot]` that ask for what options say beyond others.
fn keys(options: &LoadOptions, beyond: &LoadOptions) -> Vec<String> {
    let mut keys = Vec::new();
    if options.leave_out_missing && !beyond.leave_out_missing {
        keys.push("leave_out_missing = true".to_owned());
    }
    if options.repair && !beyond.repair {
        keys.push("repair = true".to_owned());
    }
    if options.rollers != beyond.rollers {
        keys.push("rollers = \"as_modelled\"".to_owned());
    }
    if let Some(wheels) = options
        .wheels
        .as_ref()
        .filter(|_| options.wheels != beyond.wheels)
    {
        let mut inner = vec![format!("rollers = {}", wheels.rollers)];
        inner.push(match &wheels.gamma {
            Handedness::XDeg(gamma_deg) => format!("gamma.x_deg = {}", rounded(*gamma_deg)),
            Handedness::AllDeg(gamma_deg) => format!("gamma.all_deg = {}", rounded(*gamma_deg)),
            Handedness::EachDeg(gammas_deg) => {
                let gammas: Vec<String> = gammas_deg.iter().map(|x| rounded(*x)).collect();
                format!("gamma.each_deg = [{}]", gammas.join(", "))
            }
        });
        if !wheels.joints.is_empty() {
            let joints = wheels
                .joints
                .iter()
                .map(|joint| toml::Value::from(joint.as_str()));
            let joints: Vec<String> = joints.map(|joint| joint.to_string()).collect();
            inner.push(format!("joints = [{}]", joints.join(", ")));
        }
        keys.push(format!("wheels = {{ {} }}", inner.join(", ")));
    }
    if let Some(radius_m) = options.wheel_radius_m
        && options.wheel_radius_m != beyond.wheel_radius_m
    {
        keys.push(format!("wheel_radius_m = {radius_m}"));
    }
    keys
}

/// What a person does who wants a remedy that no machine can choose.
fn asked(remedy: &Remedy, words: &Words) -> Option<String> {
    Some(match (remedy, words) {
        (Remedy::Package { name }, Words::Flags { .. }) => {
            format!("`--package {}=FOLDER`", shell(name))
        }
        (Remedy::Package { name }, Words::Keys) => {
            format!("`packages = {{ {name} = \"FOLDER\" }}` in `[robot]`")
        }
        (Remedy::Argument { name }, Words::Flags { .. }) => {
            format!("`--arg {}=VALUE`", shell(name))
        }
        (Remedy::Argument { name }, Words::Keys) => {
            format!("`args = {{ {name} = \"VALUE\" }}` in `[robot]`")
        }
        (Remedy::WheelRadius { guess_m: None }, Words::Flags { .. }) => {
            "`--wheel-radius-m`".to_owned()
        }
        (Remedy::WheelRadius { guess_m: None }, Words::Keys) => {
            "`wheel_radius_m` in `[robot]`".to_owned()
        }
        _ => return None,
    })
}

/// Whom a remedy is worded for.
pub(crate) enum Words {
    /// Whoever called a command that reads a robot's file: the command up to the options.
    Flags {
        /// Such as `ilon inspect robot.urdf`.
        command: String,
    },
    /// Whoever wrote a scenario.
    Keys,
}

/// Why a robot's file cannot be used, and what would do.
pub(crate) struct Refusal {
    /// Everything that is wrong with it; at least one.
    pub faults: Vec<RobotError>,
    /// What would do about all of it, in words.
    pub closing: Vec<String>,
    /// What was read with the options that are proposed, where any are.
    pub loaded: Option<Box<Loaded>>,
}

impl Refusal {
    /// Of a file that could not be read, for `first`, with some options.
    pub(crate) fn of(first: RobotError, path: &Path, options: &LoadOptions, words: &Words) -> Self {
        let drives = |robot: &Robot| Kinematics::new(robot).is_ok();
        let diagnosis = Robot::diagnose(path, options, drives);
        let faults = if diagnosis.faults.is_empty() {
            vec![first]
        } else {
            diagnosis.faults
        };
        let mut advice: Vec<String> = Vec::new();
        for remedy in faults.iter().flat_map(RobotError::remedies) {
            if let Some(asked) = asked(&remedy, words)
                && !advice.contains(&asked)
            {
                advice.push(asked);
            }
        }
        let proposal = diagnosis.proposal.map(|proposal| match words {
            Words::Flags { command } => format!("`{command} {}`", flags(&proposal).join(" ")),
            Words::Keys => format!("`{}`", keys(&proposal, options).join("`, `")),
        });
        let mut closing = Vec::new();
        if !advice.is_empty() {
            closing.push(format!("say {}", advice.join(", ")));
        }
        if let Some(proposal) = &proposal {
            closing.push(match words {
                Words::Flags { .. } => format!("this works: {proposal}"),
                Words::Keys => format!("this works, in `[robot]`: {proposal}"),
            });
        }
        Self {
            faults,
            closing,
            loaded: diagnosis.loaded,
        }
    }
}

/// Everything that is wrong with a robot's file, with options that work, where there are any.
pub(crate) fn diagnosed(
    first: RobotError,
    path: &Path,
    options: &LoadOptions,
    words: &Words,
) -> Error {
    let refusal = Refusal::of(first, path, options, words);
    Error::of_robot(refusal.faults, &refusal.closing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_the_shell_only_where_they_must_be() {
        assert_eq!(shell("front_left,rear/left"), "front_left,rear/left");
        assert_eq!(shell("front left"), "'front left'");
        assert_eq!(shell("it's"), r"'it'\''s'");
        assert_eq!(shell(""), "''");
    }

    #[test]
    fn angles_lose_the_noise_of_their_last_digits() {
        assert_eq!(rounded(-45.00000000000001), "-45");
        assert_eq!(rounded(-0.0), "0");
        assert_eq!(rounded(33.75), "33.75");
    }
}
