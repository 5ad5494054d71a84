//! `ilon bench`: the table and the JSON agree, and nothing is written.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn ilon(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ilon"))
        .current_dir(folder)
        .arg("bench")
        .args(arguments)
        .output()
        .expect("the command runs")
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let mut names: Vec<_> = entries
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("UTF-8")
        })
        .collect();
    names.sort();
    names
}

fn printed(stream: &[u8]) -> String {
    String::from_utf8_lossy(stream).into_owned()
}

/// One robot, two long steps in the contact window, and the minimum of everything else.
const LITTLE: [&str; 11] = [
    "--robot",
    "volksbot",
    "--rollers",
    "near",
    "--rates",
    "40,20",
    "--headings",
    "0,-15.5",
    "--rounds",
    "1",
    "--quick",
];

#[test]
fn table_and_json_say_the_same() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let table = ilon(folder.path(), &LITTLE);
    let json = ilon(folder.path(), &[&LITTLE[..], &["--json"]].concat());
    let [table, json] = [table, json].map(|output| printed(&output.stdout));
    let json: Value = serde_json::from_str(&json).expect("JSON and nothing else");
    assert!(names_in(folder.path()).is_empty());
    let configurations = json["robots"]["volksbot"]["configurations"]
        .as_array()
        .expect("a list");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split_whitespace().collect())
        .filter(|words: &Vec<_>| words.first() == Some(&"near"))
        .collect();
    assert_eq!((rows.len(), configurations.len()), (2, 2), "{table}");
    for (row, of) in rows.iter().zip(configurations) {
        let number = |key: &str| of[key].as_f64().expect("a number");
        let drives = ["D1", "D2", "D3", "D4", "D5"].map(|name| &of["drives"][name]);
        let mut expected = vec![
            format!("{:.0}", 1.0 / number("physics_dt_s")),
            format!("{:.4}", number("worst_error_pct")),
        ];
        let errors = drives
            .iter()
            .map(|drive| drive["error_pct"].as_f64().expect("a number"));
        expected.extend(errors.clone().map(|pct| format!("{pct:.4}")));
        expected.push(format!("{:.4}", 1e3 * number("hub_ripple_m")));
        expected.push(format!("{:.2}", 1e3 * number("slip_speed_rms_m_s")));
        // Speeds differ from one measurement to the next.
        assert_eq!(row[1..=expected.len()], expected, "{table}");
        assert!(number("sim_s_per_cpu_s") > 1.0 && number("steps_per_cpu_s") > 20.0);
        // The worst error is that of the drives, and a drive's that of its headings.
        assert_eq!(errors.reduce(f64::max), Some(number("worst_error_pct")));
        for drive in drives {
            let headings = drive["headings"].as_array().expect("a list");
            let at: Vec<_> = headings.iter().map(|h| h["heading_deg"].as_f64()).collect();
            assert_eq!(at, [Some(0.0), Some(-15.5)]);
            let worst = headings
                .iter()
                .filter_map(|h| h["error_pct"].as_f64())
                .reduce(f64::max);
            assert_eq!(worst, drive["error_pct"].as_f64());
        }
        // The robot did drive: at 20 steps per second the error is 0.08 %, and it slips.
        assert!(number("worst_error_pct") < 0.5 && number("slip_speed_rms_m_s") > 0.0);
    }
}

/// Contacts solved by rapier support neither treads nor rollers that slide along their axles.
#[test_case::test_case("tread.stiffness_n_m = 1e5", "a tread"; "treads")]
#[test_case::test_case("axial_play_m = 2e-4", "play"; "play")]
fn of_a_robot_that_rapier_does_not_know_all_of_the_rest_is_measured(key: &str, named: &str) {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let described = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/volksbot.toml"
    );
    let described = std::fs::read_to_string(described).expect("a shipped robot");
    let described = described.replacen("[rollers]\n", &format!("[rollers]\n{key}\n"), 1);
    std::fs::write(folder.path().join("own.toml"), described).expect("a file to write");
    let little = [
        "--robot",
        "own.toml",
        "--rates",
        "240",
        "--headings",
        "0",
        "--rounds",
        "1",
    ];
    let output = ilon(folder.path(), &[&little[..], &["--json"]].concat());
    let said = printed(&output.stderr);
    assert!(output.status.success(), "{said}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let own = &json["robots"]["own"];
    let configurations = own["configurations"].as_array().expect("a list");
    let kinds = configurations.iter().map(|c| c["roller_bodies"].as_str());
    assert_eq!(kinds.collect::<Vec<_>>(), [Some("all"), Some("near")]);
    let remark = own["remarks"][0].as_str().expect("a remark");
    assert!(
        remark.contains("rapier") && remark.contains(named) && said.contains(remark),
        "{remark}: {said}"
    );

    // Requested alone, they are refused.
    let output = ilon(
        folder.path(),
        &[&little[..], &["--rollers", "rapier"]].concat(),
    );
    let said = printed(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains(named) && output.stdout.is_empty(), "{said}");
}

#[test_case::test_case(&["--robot", "mecanum5"], "no built-in robot `mecanum5`"; "no robot")]
#[test_case::test_case(&["--robot", "none/base.urdf"], "none/base.urdf"; "no file")]
#[test_case::test_case(&["--robot", "volksbot", "--robot", "volksbot"], "two robots are called `volksbot`"; "twice")]
#[test_case::test_case(&["--rates", "240,0"], "give a number of steps a second from 1 to 100000"; "no rate")]
#[test_case::test_case(&["--headings", "nan"], "give a number of degrees from -360 to 360"; "not a number")]
#[test_case::test_case(&["--rollers", "some"], "name `all` rollers, those `near` the ground, or `rapier`"; "no kind")]
#[test_case::test_case(&["--rounds", "0"], "1..=65535"; "no round")]
fn what_cannot_be_measured_is_refused_in_words_before_anything_is(arguments: &[&str], words: &str) {
    let folder = tempfile::tempdir().expect("a folder to work in");
    std::fs::write(folder.path().join("taken"), "").expect("a file in the way");
    let output = ilon(folder.path(), arguments);
    let said = printed(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains(words), "{said}");
    assert!(!said.contains("panicked") && output.stdout.is_empty());
    assert_eq!(names_in(folder.path()), ["taken"]);
}
