//! Load options as command-line flags, for the suggestions in error messages.

use ilon_formats::{Handedness, LoadOptions, Question, Remedy, RollerForms, WheelOptions};
use ilon_sim::remedy::{Wording, blanks, rounded, with_blank_arguments};

/// The blank of the wheels' radius.
const RADIUS: &str = "--wheel-radius-m METRES";

/// The flags of a command that reads a robot's file.
pub(super) struct Flags {
    /// The command up to the options, such as `ilon inspect robot.urdf`.
    pub command: String,
}

impl Wording for Flags {
    fn package(&self, name: &str) -> String {
        format!("`--package {}=FOLDER`", shell(name))
    }

    fn question(
        &self,
        question: &Question,
        _options: &LoadOptions,
        on_tyres: Option<Result<LoadOptions, String>>,
    ) -> String {
        let asked = question.asked.iter().filter_map(|remedy| {
            Some(match remedy {
                Remedy::WhichRollers { wheels, parallel } => {
                    let gamma = if *parallel {
                        "--gamma-x-deg"
                    } else {
                        "--gamma-deg"
                    };
                    let wheels = of_joints("--wheels", wheels).join(" ");
                    format!("--rollers NUMBER {gamma} ANGLE {wheels}")
                }
                Remedy::WheelRadius { guess_m: None } => RADIUS.to_owned(),
                _ => return None,
            })
        });
        let flags = flags(&with_blank_arguments(question))
            .into_iter()
            .chain(asked);
        let flags: Vec<String> = flags.collect();
        let blanks = blanks(question);
        let on_tyres = on_tyres.map(|options| match options {
            Ok(options) => {
                let mut known = self::flags(&options);
                known.extend(question.stand_in_m.map(|_| RADIUS.to_owned()));
                format!("; on tyres: `{} {}`", self.command, known.join(" "))
            }
            Err(why) => format!("; on tyres it cannot drive either: {why}"),
        });
        format!(
            "fill in {blanks}: `{} {}`{}",
            self.command,
            flags.join(" "),
            on_tyres.unwrap_or_default()
        )
    }

    fn proposed(&self, proposal: &LoadOptions, _options: &LoadOptions) -> String {
        let flags = flags(proposal).join(" ");
        format!("this works: `{} {flags}`", self.command)
    }
}

/// The flags that set these options.
fn flags(options: &LoadOptions) -> Vec<String> {
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
    if let Some(tyres) = &options.tyres {
        flags.push("--tyres".to_owned());
        flags.extend(of_joints("--wheels", &tyres.joints));
        flags.extend(of_joints("--free-wheels", &tyres.free));
        flags.extend(tyres.width_m.map(|m| format!("--tyre-width-m {m}")));
        let shoulder_m = tyres.shoulder_radius_m;
        flags.extend(shoulder_m.map(|m| format!("--tyre-shoulder-m {m}")));
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
    flags.extend(of_joints("--wheels", &wheels.joints));
    for (flag, value) in [
        ("--roller-radius-m", wheels.roller_radius_m),
        ("--roller-mass-kg", wheels.roller_mass_kg),
    ] {
        flags.extend(value.map(|value| format!("{flag} {value}")));
    }
    flags
}

/// The flag that names joints, again where the names are many: a line is broken between flags.
fn of_joints(flag: &str, joints: &[String]) -> Vec<String> {
    /// Most characters of the names after a flag, chosen.
    const MOST: usize = 120;
    let mut lists: Vec<String> = Vec::new();
    for joint in joints {
        match lists.last_mut() {
            Some(list) if list.len() + joint.len() < MOST => *list += &format!(",{joint}"),
            _ => lists.push(joint.clone()),
        }
    }
    let of = |list: &String| format!("{flag} {}", shell(list));
    lists.iter().map(of).collect()
}

/// Quotes a word for a shell.
pub(crate) fn shell(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./=,:+-@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The flags of given tyres set the same tyres.
    #[test]
    fn all_flags_of_tyres_are_written() {
        use clap::Parser;

        #[derive(Parser)]
        struct Line {
            #[command(flatten)]
            reading: crate::cli::robot::Reading,
        }
        let mut options = LoadOptions::default();
        let text = "joints = [\"a_long_name_of_a_wheel_on_the_left_which_is_one_of_many_on_a_side\", \"a_long_name_of_a_wheel_on_the_right_which_is_one_of_many_on_a_side\"]\nfree = [\"c\"]\nwidth_m = 0.04\nshoulder_radius_m = 0.01\n";
        options.tyres = Some(toml::from_str(text).expect("tyres"));
        let written = flags(&options).join(" ");
        let words = std::iter::once("ilon").chain(written.split(' '));
        let line = Line::try_parse_from(words).expect("flags of the command");
        assert_eq!(line.reading.options().tyres, options.tyres, "{written}");
    }

    #[test]
    fn words_are_quoted_for_the_shell_only_where_they_must_be() {
        assert_eq!(shell("front_left,rear/left"), "front_left,rear/left");
        assert_eq!(shell("front left"), "'front left'");
        assert_eq!(shell("it's"), r"'it'\''s'");
        assert_eq!(shell(""), "''");
    }
}
