use super::*;
use crate::scenario::{Fault, RollerBodies, Step};

const CIRCLE: &str = r#"
[robot]
file = "robot.urdf"

[reference.circle]
radius_m = 1.0
speed_m_s = 0.2

[run]
duration_s = 30
"#;

fn told(text: &str, settings: &[&str]) -> (String, String, usize) {
    let settings: Vec<Setting> = settings.iter().map(|s| s.parse().unwrap()).collect();
    match parse(text, "test.toml", &settings) {
        Err(Error::Scenario(fault)) => (
            fault.message.clone(),
            fault.help.clone(),
            fault.span.offset(),
        ),
        Err(Error::Invalid { message, help }) => (message, help, 0),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_left_out_takes_its_documented_default() {
    let scenario = parse(CIRCLE, "test.toml", &[]).unwrap();
    assert_eq!(scenario.world.floor.friction, Some(0.6));
    assert_eq!(scenario.run.physics_dt_s, Step::default());
}

#[test]
fn a_scenario_written_out_loads_again_to_the_same_text() {
    let once = parse(CIRCLE, "test.toml", &[]).unwrap().to_toml().unwrap();
    let twice = parse(&once, "test.toml", &[]).unwrap().to_toml().unwrap();
    assert_eq!(once, twice);
    assert!(once.contains("friction = 0.6"), "{once}");
}

#[test]
fn a_setting_changes_any_key_and_needs_no_quotes() {
    let settings = [
        "world.floor.friction=0.2",
        "robot.roller_bodies=near",
        "robot.x_m = -1",
    ]
    .map(|s| s.parse().unwrap());
    let scenario = parse(CIRCLE, "test.toml", &settings).unwrap();
    assert_eq!(scenario.world.floor.friction, Some(0.2));
    assert_eq!(scenario.robot.roller_bodies, RollerBodies::Near);
    assert_eq!(scenario.robot.x_m, -1.0);
    assert_eq!(scenario.robot.file, Path::new("robot.urdf"));
}

#[test]
fn a_key_that_begins_like_a_table_names_both() {
    let text = "[robot]\nfile = \"r.urdf\"\n[reference.waypoints]\nspeed_m_s = 0.3\nheading_deg = 90\n[run]\nduration_s = 1\n";
    let (_, help, _) = told(text, &[]);
    assert_eq!(
        help,
        "did you mean `headings_deg`, or a key of `heading`, such as `heading.constant_deg`?"
    );
}

#[test]
fn all_unknown_keys_of_a_table_are_named() {
    let text = format!("{CIRCLE}\n[world.floor]\nslop_deg = 2\nfrction = 0.2\n");
    let (message, help, at) = told(&text, &[]);
    assert_eq!(
        message,
        "unknown keys `world.floor.slop_deg`, `world.floor.frction`"
    );
    assert_eq!(
        help,
        "`slop_deg`: did you mean `slope_deg`? `frction`: did you mean `friction`?"
    );
    assert_eq!(at, text.find("slop_deg").unwrap());
    // What is said of several is said once.
    let (_, help, _) = told(&format!("{CIRCLE}\n[sensors.imu]\nzz = 1\nqqq = 2\n"), &[]);
    assert!(
        help.starts_with("`zz`, `qqq`: the keys here are `"),
        "{help}"
    );
}

#[test]
fn a_key_of_another_table_is_named_whole() {
    for (text, meant) in [
        ("[floor]\nfriction = 0.3\n", "world.floor"),
        ("[world]\nfriction = 0.3\n", "floor.friction"),
        ("[robot.bushings]\nfriction = 0.3\n", ""),
    ] {
        let (_, help, _) = told(&format!("{CIRCLE}\n{text}"), &[]);
        match meant {
            "" => assert!(help.starts_with("the keys here are"), "{help}"),
            meant => assert!(help.contains(&format!("{meant}`?")), "{help}"),
        }
    }
    // A key of a table within another has its own meaning: that of `wheel_loop` is no help here.
    let circle = told(CIRCLE, &["reference.circle.period_s=5"]).1;
    assert!(
        circle.starts_with("the keys here are ") && !circle.contains("wheel_loop"),
        "{circle}"
    );
    assert_eq!(
        told(CIRCLE, &["robot.bearings=\"ball\""]).1,
        "did you mean `rollers.bearings`?"
    );
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_known_one_and_its_place() {
    let text = format!("{CIRCLE}\n[world.floor]\nfrction = 0.2\n");
    let (message, help, at) = told(&text, &[]);
    assert_eq!(message, "unknown key `world.floor.frction`");
    assert_eq!(help, "did you mean `friction`?");
    assert_eq!(at, text.find("frction").unwrap());
    assert_eq!(
        told(CIRCLE, &["wrld.floor.friction=1"]).1,
        "did you mean `world`?"
    );
}

#[test]
fn a_fault_in_a_setting_is_shown_in_the_setting() {
    for (setting, offset) in [("world.flor.friction=1", 6), ("run.duration_s=x", 17)] {
        let settings = [setting.parse().unwrap()];
        match parse(CIRCLE, "test.toml", &settings) {
            Err(Error::Scenario(fault)) => {
                assert_eq!(fault.source_code.name(), SETTING);
                assert_eq!(fault.span.offset(), offset);
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_wrong_type_says_what_was_found_and_what_is_wanted() {
    let (message, ..) = told(CIRCLE, &["reference.circle.radius_m=wide"]);
    assert_eq!(
        message,
        "`reference.circle.radius_m` is a text, but must be a number"
    );
    let (message, help, _) = told(CIRCLE, &["guidance.priority=positon"]);
    assert_eq!(message, "`guidance.priority` cannot be \"positon\"");
    assert_eq!(help, "did you mean \"position\"?");
    let (message, ..) = told(CIRCLE, &["world.floor=0.2"]);
    assert_eq!(message, "`world.floor` is a number, but must be a table");
    let (message, help, _) = told(CIRCLE, &["expect.position_error_max_m=0.05"]);
    assert_eq!(
        message,
        "`expect.position_error_max_m` is a number, but must be a text in quotes or a table"
    );
    assert_eq!(
        help,
        "write a table, `{ ... }`, with what you need of its keys: `equal`, `max`, `min`, `within`; or a change against a baseline, `\"+10 %\"`"
    );
}

#[test]
fn an_array_of_a_fixed_length_has_that_many_entries() {
    for (points, count) in [("[[0, 0], [1, 0, 0.5]]", 3), ("[[0, 0], [1]]", 1)] {
        let text = format!(
            "[robot]\nfile = \"robot.urdf\"\n[reference.waypoints]\npoints_m = {points}\n[run]\nduration_s = 1\n"
        );
        let (message, help, at) = told(&text, &[]);
        assert_eq!(
            message,
            format!("`reference.waypoints.points_m.1` has {count} entries, but must have 2")
        );
        assert_eq!(help, "write 2 numbers");
        assert_eq!(at, text.find("[1").unwrap());
    }
}

#[test]
fn numbers_must_be_finite_and_within_their_bounds() {
    for not_finite in ["nan", "inf", "-inf"] {
        let (message, ..) = told(CIRCLE, &[&format!("run.duration_s={not_finite}")]);
        assert_eq!(message, "`run.duration_s` is not a finite number");
    }
    let (message, ..) = told(CIRCLE, &["run.physics_dt_s=0"]);
    assert_eq!(
        message,
        "`run.physics_dt_s` is 0, but must be greater than 0"
    );
    let (message, ..) = told(CIRCLE, &["run.control_dt_s=-0.01"]);
    assert_eq!(
        message,
        "`run.control_dt_s` is -0.01, but must be greater than 0"
    );
    let (message, ..) = told(CIRCLE, &["world.floor.friction=-1"]);
    assert_eq!(
        message,
        "`world.floor.friction` is -1, but must be 0 or more"
    );
}

#[test]
fn numbers_are_of_a_size_to_compute_with_but_for_what_is_expected() {
    for (setting, told_of) in [
        ("run.duration_s=1e30", "`run.duration_s` is 1e30"),
        ("robot.x_m=-1e10", "`robot.x_m` is -1e10"),
        (
            "world.floor.friction=1e-300",
            "`world.floor.friction` is 1e-300",
        ),
    ] {
        let (message, help, _) = told(CIRCLE, &[setting]);
        assert!(message.starts_with(told_of), "{message}");
        assert_eq!(
            help,
            "write 0 or a number whose size is between 1e-12 and 1e9"
        );
    }
    // Numbers of either sign come from sines and cosines: a script writes cos(90 deg) as 6e-17.
    for zero in ["robot.x_m=6e-17", "robot.heading_deg=-1.8e-17"] {
        assert!(
            parse(CIRCLE, "t", &[zero.parse().unwrap()]).is_ok(),
            "{zero}"
        );
    }
    let expected = ["expect.slip_energy_j={max=1e-20}".parse().unwrap()];
    assert!(parse(CIRCLE, "t", &expected).is_ok());
}

#[test]
fn a_control_period_is_a_whole_number_of_physics_steps() {
    let (message, help, _) = told(CIRCLE, &["run.physics_dt_s=0.003"]);
    assert_eq!(
        message,
        "`run.control_dt_s` = 0.01 is 3.333333 physics steps of `run.physics_dt_s` = 0.003, but must be a whole \
         number of them"
    );
    assert_eq!(help, "set `run.physics_dt_s` to 0.0025, which divides it");
    let longer = parse(CIRCLE, "t", &["run.physics_dt_s=0.02".parse().unwrap()]);
    assert!(longer.is_err());
}

#[test]
fn a_run_that_no_memory_holds_is_refused_with_what_would_do() {
    // 1e8 s at 100 Hz are 1e10 rows: a thousand times too many.
    let (message, help, _) = told(CIRCLE, &["run.duration_s=1e8"]);
    assert_eq!(
        message,
        "`run.duration_s` = 100000000 makes 1.0e10 rows, more than the 1e7 of the longest trace"
    );
    assert!(help.ends_with("`run.record_every` = 1000"), "{help}");
    let thinned = ["run.duration_s=1e8", "run.record_every=1000"].map(|s| s.parse().unwrap());
    assert!(parse(CIRCLE, "t", &thinned).is_ok());
    let (message, ..) = told(CIRCLE, &["run.physics_dt_s=1e-12"]);
    assert!(message.contains("3.0e13 physics steps"), "{message}");
}

#[test]
fn a_scenario_moved_to_another_folder_names_the_same_files() {
    let mut scenario = parse(CIRCLE, "test.toml", &[]).unwrap();
    scenario.folder = PathBuf::from("/home/a/scenarios");
    scenario.robot.file = PathBuf::from("../robots/x.urdf");
    let packages = &mut scenario.robot.packages;
    packages.insert("x".to_owned(), PathBuf::from("../meshes"));
    let moved = scenario.moved_to(Path::new("/home/b/out"));
    assert_eq!(moved.robot.file, Path::new("../../a/robots/x.urdf"));
    assert_eq!(moved.robot.packages["x"], Path::new("../../a/meshes"));
}

#[test]
#[cfg(unix)]
fn a_scenario_moved_to_a_folder_behind_a_link_names_the_same_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(at("m/deep/er")).unwrap();
    std::fs::create_dir_all(at("l")).unwrap();
    std::os::unix::fs::symlink("../m/deep/er", at("l/link")).unwrap();
    std::fs::write(at("robot.urdf"), "the robot").unwrap();
    std::os::unix::fs::symlink("robot.urdf", at("other_name.urdf")).unwrap();
    let mut scenario = parse(CIRCLE, "test.toml", &[]).unwrap();
    scenario.folder = folder.path().to_owned();
    for file in [
        "robot.urdf",
        "other_name.urdf",
        "l/link/../../../robot.urdf",
    ] {
        scenario.robot.file = PathBuf::from(file);
        // The folder of the results is created later, or exists.
        for out in ["l/link/r", "l/link", "m/deep", "l/nowhere/yet"] {
            let moved = scenario.moved_to(&at(out));
            std::fs::create_dir_all(at(out)).unwrap();
            let text = std::fs::read_to_string(at(out).join(&moved.robot.file));
            assert_eq!(
                text.ok().as_deref(),
                Some("the robot"),
                "{file}, {out}: {:?}",
                moved.robot.file
            );
        }
    }
    // Files beside a robot are relative to the robot's own link.
    scenario.robot.file = PathBuf::from("other_name.urdf");
    assert_eq!(
        scenario.moved_to(&at("m")).robot.file,
        Path::new("../other_name.urdf")
    );
}

#[test]
fn of_a_file_that_is_no_scenario_nothing_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let told = |text: &str| {
        std::fs::write(&path, text).unwrap();
        match Scenario::load(&path) {
            Err(Error::Invalid { message, .. }) => message,
            other => panic!("{other:?}"),
        }
    };
    for secret in [
        "[registry]\ntoken = \"secret\"\n",
        "A=1\u{0}secret=2",
        "run=1\n= secret",
    ] {
        let told = told(secret);
        assert!(told.contains("is not a scenario: on line"), "{told}");
        assert!(!told.contains("secret"), "{told}");
    }
    std::fs::write(&path, CIRCLE.replace("radius_m", "raduis_m")).unwrap();
    assert!(matches!(Scenario::load(&path), Err(Error::Scenario(_))));
}

/// Without the word "robot" a file may be no scenario, but a setting is shown where it is at fault.
#[test]
fn a_fault_in_a_setting_is_shown_in_it_also_where_only_a_setting_names_the_robot() {
    let text = "twist.vx_m_s = 0.3\nrun.duration_s = 5\n";
    let of = |settings: [&str; 2]| {
        let settings = settings.map(|setting| setting.parse().unwrap());
        Scenario::from_text(
            text,
            Path::new("s.toml"),
            &settings,
            &FileAccess::anywhere(),
        )
    };
    assert!(of(["robot.file=r.urdf", "run.duration_s=6"]).is_ok());
    match of(["robot.file=r.urdf", "run.duration_s=x"]) {
        Err(Error::Scenario(fault)) => {
            assert_eq!(fault.source_code.name(), SETTING);
            assert_eq!(fault.span.offset(), "run.duration_s = ".len());
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_largest_seed_is_read_and_written_and_the_next_is_refused_as_the_number_it_is() {
    let seed = u64::MAX.to_string();
    let settings = [format!("sensors.seed={seed}").parse().unwrap()];
    let scenario = parse(CIRCLE, "t", &settings).unwrap();
    assert_eq!(scenario.sensors.seed, u64::MAX);
    let again = parse(&scenario.to_toml().unwrap(), "t", &[]).unwrap();
    assert_eq!(again.sensors.seed, u64::MAX);
    for beyond in [
        "18446744073709551616",
        "99999999999999999999999999999999999999999999",
    ] {
        let (message, help, _) = told(CIRCLE, &[&format!("sensors.seed={beyond}")]);
        assert_eq!(
            message,
            format!("`sensors.seed` is {beyond}, but must be {seed} or less")
        );
        assert_eq!(help, format!("write a whole number that is {seed} or less"));
    }
    let (message, ..) = told(CIRCLE, &["sensors.seed=-1"]);
    assert_eq!(message, "`sensors.seed` is -1, but must be 0 or more");
}

#[test]
fn a_name_that_means_another_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["...toml", "..toml"] {
        let path = folder.path().join(file);
        std::fs::write(&path, CIRCLE).unwrap();
        let refused = Scenario::load(&path).unwrap_err().to_string();
        assert!(
            refused.starts_with("a scenario cannot be called `."),
            "{refused}"
        );
    }
    let path = folder.path().join("....toml");
    std::fs::write(&path, CIRCLE).unwrap();
    assert_eq!(Scenario::load(&path).unwrap().name, "...");
}

#[test]
fn exactly_one_motion_is_asked_for() {
    let (message, ..) = told(CIRCLE, &["twist.vx_m_s=0.3"]);
    assert!(
        message.starts_with("the scenario has two motions, `[reference]` and `[twist]`"),
        "{message}"
    );
    let none = CIRCLE.replace("[reference.circle]\nradius_m = 1.0\nspeed_m_s = 0.2\n", "");
    let (message, ..) = told(&none, &[]);
    assert!(
        message.starts_with("the scenario has no motion"),
        "{message}"
    );
}

/// Keys beside the path define its timing; they are no path.
#[test]
fn a_reference_has_exactly_one_path() {
    let two = format!("{CIRCLE}\n[reference.hold_pose]\nx_m = 0\ny_m = 0\nheading_deg = 0\n");
    let (message, ..) = told(&two, &[]);
    assert!(
        message.contains("`hold_pose` is a second path"),
        "{message}"
    );
    for keys in ["", "share_of_limits = 0.5\n"] {
        let none = format!("robot.file = \"r.urdf\"\nrun.duration_s = 1\n[reference]\n{keys}");
        let (message, _, at) = told(&none, &[]);
        assert!(message.contains("there is no path"), "{message}");
        assert!(none[at..].starts_with("[reference]") || none[at..].starts_with("reference]"));
    }
    // What is wrong within a path is shown there.
    let text = CIRCLE.replace(
        "radius_m",
        "heading = {constant_deg = 1, from_path_deg = 2}\nradius_m",
    );
    let (message, _, at) = told(&text, &[]);
    assert!(message.contains("several keys"), "{message}");
    assert!(text[at..].starts_with("{constant_deg"), "{}", &text[at..]);
}

#[test]
fn a_list_of_tables_takes_two_brackets() {
    let (_, help, _) = told(&format!("{CIRCLE}\n[faults]\npose_lost = {{}}\n"), &[]);
    assert_eq!(
        help,
        "write it with two brackets, `[[faults]]`: there may be several"
    );
}

#[test]
fn a_missing_key_is_named_with_what_it_is_for() {
    let (message, help, _) = told("[run]\nduration_s = 1\n[twist]\n", &[]);
    assert_eq!(message, "the key `robot` is missing");
    assert_eq!(help, "add `robot`: Which robot, and how it starts");
    // In an optional section that is present.
    let rough = format!("{CIRCLE}\n[world.floor.rough]\nheight_m = 0.01\nside_m = 2\n");
    let (message, help, at) = told(&rough, &[]);
    assert_eq!(message, "the key `world.floor.rough.cell_m` is missing");
    assert!(
        help.starts_with("add `world.floor.rough.cell_m`: Distance"),
        "{help}"
    );
    assert!(
        rough[at..].starts_with("[world.floor.rough]") || rough[at..].starts_with("rough]"),
        "{}",
        &rough[at..]
    );
}

#[test]
fn a_key_that_is_missing_in_a_setting_is_shown_in_the_setting() {
    let setting = "guidance.reference_point.at.x_m=0".parse().unwrap();
    match parse(CIRCLE, "test.toml", &[setting]) {
        Err(Error::Scenario(fault)) => {
            assert!(fault.message.contains("y_m"), "{}", fault.message);
            assert_eq!(fault.source_code.name(), SETTING);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_expectation_names_a_quantity_that_exists() {
    let (message, help, _) = told(CIRCLE, &["expect.position_eror_final_m={max=1}"]);
    assert_eq!(message, "unknown key `expect.position_eror_final_m`");
    assert_eq!(help, "did you mean `position_error_final_m`?");
    let (message, ..) = told(CIRCLE, &["expect.twist_ratio_contact.vx={mx=1}"]);
    assert_eq!(message, "unknown key `expect.twist_ratio_contact.vx.mx`");
    let settings = ["expect.twist_ratio_contact.vx={min=0.9,max=1.1}"
        .parse()
        .unwrap()];
    let scenario = parse(CIRCLE, "t", &settings).unwrap();
    let bound = scenario.expect.bounds["twist_ratio_contact.vx"];
    assert_eq!((bound.min, bound.max), (Some(0.9), Some(1.1)));
}

#[test]
fn a_setting_makes_the_list_that_it_names_and_adds_to_it() {
    let settings: Vec<Setting> = [
        "faults.0.payload.mass_kg=2",
        "faults.0.payload.x_m=0.1",
        "faults.1.pose_lost.from_s=3",
    ]
    .map(|setting| setting.parse().unwrap())
    .to_vec();
    let scenario = parse(CIRCLE, "test.toml", &settings).unwrap();
    assert_eq!(scenario.faults.len(), 2);
    assert!(matches!(
        scenario.faults[0],
        Fault::Payload { mass_kg, x_m: Some(x_m), .. } if mass_kg == 2.0 && x_m == 0.1
    ));
    // Appended to an existing one.
    let text = format!("{CIRCLE}\n[[faults]]\npose_lost = {{}}\n");
    let added = parse(&text, "test.toml", &settings[2..]).unwrap();
    assert_eq!(added.faults.len(), 2);
    assert_eq!(added.faults[1].window_s().0, 3.0);
}

#[test]
fn a_place_beyond_the_end_of_a_list_is_refused_with_what_to_do() {
    for setting in ["faults.1.pose_lost.from_s=3", "faults.7.pose_lost.from_s=3"] {
        let (message, help, _) = told(CIRCLE, &[setting]);
        let place = setting.split('.').nth(1).unwrap();
        assert_eq!(
            message,
            format!("the list `faults` has no place {place} yet")
        );
        assert!(help.contains("count from 0"), "{help}");
    }
}

#[test]
fn numbers_as_names_of_a_table_stay_names() {
    let settings = ["robot.args.0=a".parse().unwrap()];
    let scenario = parse(CIRCLE, "test.toml", &settings).unwrap();
    assert!(scenario.robot.args.contains_key("0"));
}

#[test]
fn a_run_without_a_duration_is_of_a_log_alone() {
    let open = CIRCLE.replace("duration_s = 30\n", "");
    assert_eq!(told(&open, &[]).0, "the key `run.duration_s` is missing");
    let bare = open.replace("[run]\n", "");
    assert_eq!(told(&bare, &[]).0, "the key `run.duration_s` is missing");
    let played = "robot.file = \"r.urdf\"\n[playback]\nfile = \"l.csv\"\ndrives = \"twist\"\n";
    let scenario = parse(played, "test.toml", &[]).unwrap();
    assert!(scenario.run.is_open());
    // Still open after writing and reading.
    let again = parse(&scenario.to_toml().unwrap(), "test.toml", &[]).unwrap();
    assert!(again.run.is_open());
    for wrong in ["inf", "0", "-1"] {
        let setting = format!("run.duration_s={wrong}");
        assert!(told(played, &[&setting]).0.contains("`run.duration_s`"));
    }
}

/// A path may be of several kinds, all of which have a timing: the help lists it once.
#[test]
fn keys_of_several_kinds_are_listed_once() {
    let (_, help, _) = told(&format!("{CIRCLE}\n[reference]\nquux = 1\n"), &[]);
    assert!(help.starts_with("the keys here are "), "{help}");
    for key in ["`circle`", "`timing`", "`share_of_limits`"] {
        assert_eq!(help.matches(key).count(), 1, "{help}");
    }
}

/// When a fault begins is a key of what it is.
#[test]
fn a_key_beside_the_table_that_it_belongs_into_is_found_there() {
    let fault = "[[faults]]\npayload.mass_kg = 1\nfrom = 2\n";
    let (message, help, _) = told(&format!("{CIRCLE}\n{fault}"), &[]);
    assert_eq!(message, "unknown key `faults.0.from`");
    assert_eq!(help, "did you mean `payload.from_s`?");
}

#[test]
fn what_a_scenario_is_about_is_the_comment_at_its_head() {
    let keys = "robot.file = \"x.urdf\"\ntwist = {}\nrun.duration_s = 1\n";
    let about = |head: &str| {
        let text = format!("{head}{keys}# not this\n");
        Scenario::from_toml(&text, "x", "").unwrap()
    };
    let read =
        about("#: As it was run.\n\n# Sideways over bars,\n#   on springs.\n#\n# Not this.\n\n");
    assert_eq!(read.about, "Sideways over bars, on springs.");
    // What is written can be read again.
    let written = read.to_toml().unwrap();
    assert!(
        written.starts_with("# Sideways over bars, on springs.\n\n"),
        "{written}"
    );
    let again = Scenario::from_toml(&written, "x", "").unwrap();
    assert_eq!(again.about, read.about);
    assert_eq!(again.to_toml().unwrap(), written);
    assert_eq!(about("").about, "");
    assert_eq!(about("\n\n").to_toml().unwrap().find('#'), None);
    assert_eq!(
        about(&format!("# {}\n", "a".repeat(5000))).about.len(),
        MOST_ABOUT
    );
}

#[test]
fn all_keys_that_are_missing_are_named_at_once() {
    let hold = "robot.file = \"r.urdf\"\nrun.duration_s = 1\n[reference.hold_pose]\nx_m = 1\n";
    let (message, help, _) = told(hold, &[]);
    assert_eq!(
        message,
        "the keys `reference.hold_pose.y_m`, `reference.hold_pose.heading_deg` are missing"
    );
    assert_eq!(
        help,
        "add `reference.hold_pose.y_m`: y in the world, in metres; `reference.hold_pose.heading_deg`: Heading in degrees"
    );
    let (message, _, _) = told("robot.file = \"r.urdf\"\n", &[]);
    assert!(message.contains("no motion") && message.contains("`run.duration_s` is missing"));
}

/// Unknown keys, wrong types and missing keys of all tables are reported together. A key that is
/// missing because it was misspelt is reported once.
#[test]
fn all_faults_of_keys_are_reported_at_once() {
    let text = "[robot]\nfle = \"r.urdf\"\n[reference.hold_pose]\nx_m = \"1\"\ny_m = 2\n[run]\nduration = 3\n";
    let Err(Error::Scenario(fault)) = parse(text, "test.toml", &[]) else {
        panic!("it has faults");
    };
    let all = [&*fault].into_iter().chain(&fault.related);
    let found: Vec<(&str, usize)> = all
        .map(|fault| (fault.message.as_str(), fault.span.offset()))
        .collect();
    let at = |word: &str| text.find(word).unwrap_or_else(|| panic!("{word}"));
    let expected = [
        ("unknown key `robot.fle`", at("fle")),
        (
            "`reference.hold_pose.x_m` is a text, but must be a number",
            at("\"1\""),
        ),
        (
            "the key `reference.hold_pose.heading_deg` is missing",
            at("reference.hold_pose") - 1,
        ),
        ("unknown key `run.duration`", at("duration")),
    ];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found, expected);
    }
}

/// Errors found only with the robot are placed by the key or value that they name, but not if a
/// setting overrides it, or the value occurs twice.
#[test]
fn late_errors_are_placed_in_the_text() {
    let text = format!("{CIRCLE}\n[[faults]]\nmotor_lost = {{ wheel = \"lft\" }}\n");
    let scenario = parse(&text, "test.toml", &[]).unwrap();
    let at = |scenario: &Scenario, message: &str| match scenario
        .source
        .placed(Error::invalid(message, "help"))
    {
        Error::Scenario(fault) => Some(fault.span.offset()),
        Error::Invalid { .. } => None,
        other => panic!("{other:?}"),
    };
    let of_wheel = at(&scenario, "there is no wheel `lft` of the fault").unwrap();
    assert!(text[of_wheel..].starts_with("\"lft\""));
    let of_key = at(&scenario, "`reference.circle.radius_m` is too small").unwrap();
    assert!(text[..of_key].contains("radius_m"));
    assert_eq!(at(&scenario, "nothing of `this` is there"), None);
    let setting = "reference.circle.radius_m=0.1".parse().unwrap();
    let changed = parse(&text, "test.toml", &[setting]).unwrap();
    assert_eq!(
        at(&changed, "`reference.circle.radius_m` is too small"),
        None
    );
    let twice = format!("{text}[[faults]]\nmotor_lost = {{ wheel = \"lft\" }}\n");
    let twice = parse(&twice, "test.toml", &[]).unwrap();
    assert_eq!(at(&twice, "there is no wheel `lft`"), None);
}
