//! The replies are the command's results.

use std::path::Path;

use ilon_files::FileAccess;
use ilon_sim::Scenario;
use serde_json::json;

use crate::support::{ask, assets, door, shipped};

const LATERAL: &str = "/scenarios/mecanum4_lateral.toml";

/// Runs a scenario and returns the final reply.
fn ran(door: &mut ilon_web::door::Door, scenario: &str, settings: &[&str]) -> serde_json::Value {
    let open = json!({ "do": "open", "scenario": scenario, "settings": settings });
    let (opened, _) = ask(door, &open);
    assert!(opened["fault"].is_null(), "{opened:#}");
    loop {
        let (said, _) = ask(door, &json!({ "do": "advance", "periods": 37 }));
        if said["ok"]["done"] == true {
            break;
        }
    }
    ask(door, &json!({ "do": "finish", "command": "ilon run it" })).0["ok"].clone()
}

#[test]
fn a_run_in_pieces_out_of_memory_is_the_run_of_the_file_to_the_bit() {
    let settings = ["run.duration_s=1.5", "world.floor.friction=0.3"];
    let mut door = door();
    let said = ran(&mut door, LATERAL, &settings);
    let file = assets().join("scenarios/mecanum4_lateral.toml");
    let parsed: Vec<_> = settings.iter().map(|text| text.parse().unwrap()).collect();
    let scenario = Scenario::load_with(&file, &parsed).unwrap();
    let run = ilon_sim::run(&scenario).unwrap();
    assert_eq!(said["hash"], run.summary.trace_hash.as_str());

    let (_, trace) = ask(&mut door, &json!({ "do": "take", "what": "trace" }));
    assert!(trace == run.trace.to_parquet().unwrap());
    let (_, report) = ask(&mut door, &json!({ "do": "take", "what": "report" }));
    let report = String::from_utf8(report).unwrap();
    let expected = ilon::cli::report_html(&run, "ilon run it");
    // Without date and duration, which differ between runs.
    let lines = |page: &str| -> Vec<String> {
        let timeless = |line: &&str| {
            !line.contains("real time") && !line.contains("<th scope=\"row\">made</th>")
        };
        page.lines().filter(timeless).map(str::to_owned).collect()
    };
    let differ: Vec<_> = lines(&report)
        .into_iter()
        .zip(lines(&expected))
        .filter(|(ours, theirs)| ours != theirs && !ours.contains("sim_seconds_per_cpu_second"))
        .collect();
    assert!(differ.is_empty(), "{:.2000}", format!("{differ:#?}"));
}

#[test]
fn the_scenario_that_is_handed_out_runs_beside_its_files_to_the_same_bits() {
    let mut door = door();
    let first = ran(&mut door, LATERAL, &["run.duration_s=1"]);
    let (_, scenario) = ask(&mut door, &json!({ "do": "take", "what": "scenario" }));
    door.put("/there/scenario.toml".to_owned(), scenario);
    door.put(
        "/there/mecanum4.urdf".to_owned(),
        shipped("robots/mecanum4.urdf").into_bytes(),
    );
    let again = ran(&mut door, "/there/scenario.toml", &[]);
    assert_eq!(first["hash"], again["hash"]);
}

#[test]
fn a_fault_is_told_in_the_words_of_the_command() {
    let mut door = door();
    let spoilt = shipped("scenarios/mecanum4_lateral.toml").replace("vy_m_s", "vz_m_s");
    let path = "/scenarios/spoilt.toml";
    door.put(path.to_owned(), spoilt.clone().into_bytes());
    let (said, _) = ask(
        &mut door,
        &json!({ "do": "open", "scenario": path, "settings": [] }),
    );
    let files = FileAccess::of_memory([(path.into(), spoilt.into_bytes())]);
    let error = Scenario::load_within(Path::new(path), &[], &files).unwrap_err();
    let expected = ilon::cli::explain(&error);
    assert_eq!(said["fault"]["shown"], expected.shown.as_str());
    assert!(expected.shown.contains("vz_m_s") && expected.shown.contains("help"));
    // The simulator still works.
    assert!(ran(&mut door, LATERAL, &["run.duration_s=0.1"])["hash"].is_string());
}

#[test]
fn a_robot_that_names_files_outside_finds_none_of_the_machine() {
    let mut door = door();
    let scenario =
        "[robot]\nfile = \"/etc/passwd\"\n[twist]\nvx_m_s = 0.1\n[run]\nduration_s = 1\n";
    door.put("/own/a.toml".to_owned(), scenario.into());
    let (said, _) = ask(
        &mut door,
        &json!({ "do": "open", "scenario": "/own/a.toml", "settings": [] }),
    );
    let shown = said["fault"]["shown"].as_str().unwrap();
    assert!(shown.contains("there is no such file"), "{shown}");
}

#[test]
fn a_run_that_a_page_has_no_room_for_is_refused_before_it_begins() {
    let mut door = door();
    let open = json!({ "do": "open", "scenario": LATERAL, "settings": ["run.duration_s=5e4"] });
    let (said, _) = ask(&mut door, &open);
    let shown = said["fault"]["shown"].as_str().unwrap();
    assert!(shown.contains("more than a page has room for"), "{shown}");
    let open = json!({ "do": "open", "scenario": LATERAL, "settings": ["run.duration_s=500"] });
    assert!(ask(&mut door, &open).0["fault"].is_null());
}

#[test]
fn what_cannot_be_answered_is_a_fault_and_not_the_end() {
    let mut door = door();
    for request in [
        json!({ "do": "nothing" }),
        json!({ "do": "advance", "periods": 1 }),
        json!({ "do": "frame" }),
        json!({ "do": "finish", "command": "" }),
        json!({ "do": "take", "what": "trace" }),
        json!({ "do": "keep", "name": "a" }),
        json!({ "do": "compare", "name": "a" }),
        json!({ "do": "open", "scenario": "/none.toml", "settings": [] }),
        json!({ "do": "open", "scenario": LATERAL, "settings": ["no setting"] }),
    ] {
        let (said, _) = ask(&mut door, &request);
        assert!(said["fault"]["shown"].is_string(), "{request}: {said}");
    }
}

#[test]
fn two_runs_are_compared_on_the_page_of_the_command() {
    let mut door = door();
    ran(&mut door, LATERAL, &["run.duration_s=1"]);
    ask(&mut door, &json!({ "do": "keep", "name": "grip" }));
    ran(
        &mut door,
        LATERAL,
        &["run.duration_s=1", "world.floor.friction=0.05"],
    );
    let (_, page) = ask(&mut door, &json!({ "do": "compare", "name": "ice" }));
    let page = String::from_utf8(page).unwrap();
    assert!(page.contains("<title>grip and ice") && page.contains("world.floor.friction"));
}

#[test]
fn a_robot_in_short_is_changed_by_keys_of_the_scenario() {
    let mut door = door();
    let open = json!({ "do": "open", "scenario": LATERAL, "settings": [] });
    let (said, _) = ask(&mut door, &open);
    let spec = &said["ok"]["spec"];
    assert_eq!(spec["values"]["wheels"]["mecanum"]["gamma_deg"], 45.0);
    let file = format!("robot.file={}", spec["file"].as_str().unwrap());
    let settings = [file.as_str(), "robot.spec.rollers.per_row=12"];
    let open = json!({ "do": "open", "scenario": LATERAL, "settings": settings });
    let (said, _) = ask(&mut door, &open);
    assert_eq!(
        said["ok"]["robot"]["wheels"][0]["rollers"], 12,
        "{said:.800}"
    );
}

/// Frames of the open scenario, each after a number of control periods.
fn frames_after(
    door: &mut ilon_web::door::Door,
    periods: &[u32],
    mut steer: impl FnMut(&mut ilon_web::door::Door, usize),
) -> Vec<Vec<u8>> {
    let mut frames = Vec::new();
    for (index, periods) in periods.iter().enumerate() {
        steer(door, index);
        let (said, _) = ask(door, &json!({ "do": "advance", "periods": periods }));
        assert!(said["fault"].is_null(), "{said}");
        frames.push(ask(door, &json!({ "do": "frame" })).1);
    }
    frames
}

#[test]
fn what_was_driven_a_log_does_again_to_the_bit() {
    // Open loop, path guidance, guidance that commands by contact, and periods that are no round
    // numbers.
    for (scenario, settings) in [
        (LATERAL, vec!["run.physics_dt_s=0.002"]),
        ("/scenarios/mecanum4_circle.toml", vec![]),
        (
            "/scenarios/mecanum4_wet_floor.toml",
            vec!["guidance.kinematics=contact"],
        ),
        (
            "/scenarios/volksbot_blind.toml",
            vec!["run.control_dt_s=0.007", "run.record_every=3"],
        ),
        ("/scenarios/mecanum4_sprung_kerb.toml", vec![]),
    ] {
        let mut door = door();
        let open = json!({ "do": "drive", "scenario": scenario, "settings": settings });
        let (said, _) = ask(&mut door, &open);
        assert!(said["fault"].is_null(), "{scenario}: {said:.900}");
        let periods = [3, 1, 1, 40, 7, 1, 60, 2, 1];
        let twists = [
            [0.0, 0.0, 0.0],
            [0.4, 0.0, 0.0],
            [0.4, 0.0, 0.0],
            [0.1, -0.3, 1.0 / 3.0],
            [-0.0, 0.2, -0.0],
            [1e9, 0.0, 0.0],
            [0.0, 0.0, -0.7],
            [0.2, 0.1, 0.1],
            [0.2, 0.1, 0.1],
        ];
        let driven = frames_after(&mut door, &periods, |door, index| {
            let steer = json!({ "do": "steer", "twist": twists[index] });
            assert!(ask(door, &steer).0["fault"].is_null());
        });
        let (ended, _) = ask(&mut door, &json!({ "do": "end_drive" }));
        let ended = &ended["ok"];
        let text = |value: &serde_json::Value| value.as_str().expect("text").to_owned();
        for file in ended["files"].as_array().expect("files") {
            door.put(text(&file[0]), text(&file[1]).into_bytes());
        }
        let path = text(&ended["path"]);
        door.put(path.clone(), text(&ended["text"]).into_bytes());
        let open = json!({ "do": "open", "scenario": path, "settings": [] });
        let (said, _) = ask(&mut door, &open);
        assert!(said["fault"].is_null(), "{said:.900}\n{ended:#}");
        let control_dt_s = said["ok"]["control_dt_s"].as_f64().expect("a period");
        let driven_s = f64::from(periods.iter().sum::<u32>()) * control_dt_s;
        let again_s = said["ok"]["duration_s"].as_f64().expect("a duration");
        assert!(
            (again_s - driven_s).abs() < 1e-9,
            "{again_s} s of {driven_s} s"
        );
        let again = frames_after(&mut door, &periods, |_, _| ());
        // At its end the log commands nothing more, whereas the user may.
        let last = driven.len() - 1;
        assert!(driven[..last] == again[..last], "{scenario}");
        // The robot has moved.
        assert!(driven[3] != driven[7]);
    }
}

#[test]
fn a_drive_refuses_what_is_no_drive() {
    let mut door = door();
    let steer = json!({ "do": "steer", "twist": [0.1, 0.0, 0.0] });
    let end = json!({ "do": "end_drive" });
    for request in [&steer, &end] {
        assert!(ask(&mut door, request).0["fault"].is_object());
    }
    let open = json!({ "do": "open", "scenario": LATERAL, "settings": [] });
    ask(&mut door, &open);
    assert!(ask(&mut door, &steer).0["fault"].is_object());
    let drive = json!({ "do": "drive", "scenario": LATERAL, "settings": [] });
    ask(&mut door, &drive);
    let huge = json!({ "do": "steer", "twist": [null, 0.0, 0.0] });
    assert!(ask(&mut door, &huge).0["fault"].is_object());
    // No drive has begun.
    assert!(ask(&mut door, &end).0["fault"].is_object());
}

#[test]
fn links_of_the_book_open_what_they_say() {
    let mut door = door();
    let docs = assets().join("../docs");
    let mut found = 0;
    for page in std::fs::read_dir(docs).expect("the book") {
        let text = std::fs::read_to_string(page.expect("a page").path()).unwrap_or_default();
        for link in text.split("playground/index.html#").skip(1) {
            let link = link.split(')').next().expect("a link");
            let mut scenario = None;
            let mut settings = Vec::new();
            let mut act = "open";
            for part in link.split('&') {
                match part.split_once('=') {
                    Some(("scenario", name)) => scenario = Some(format!("/scenarios/{name}.toml")),
                    Some(("set", setting)) => settings.push(setting.to_owned()),
                    _ if part == "drive" => act = "drive",
                    _ => panic!("{link}"),
                }
            }
            let open = json!({ "do": act, "scenario": scenario, "settings": settings });
            let (said, _) = ask(&mut door, &open);
            assert!(said["fault"].is_null(), "{link}: {said:#}");
            found += 1;
        }
    }
    assert!(found > 10, "{found} links");
}
