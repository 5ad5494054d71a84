//! `ilon sweep`: killed and restarted, divided and merged, and with invalid studies.

use crate::support;

use std::time::{Duration, Instant};

use support::{Folder, ended_with, stderr, stdout};

/// A study of the folder's scenario over floors.
fn study(folder: &Folder, further: &str) {
    folder.write(
        "study.toml",
        &format!("scenario = \"good.toml\"\n{further}\n"),
    );
}

const FLOORS: &str = "[axes]\nworld.floor.friction = { from = 0.02, to = 0.8, steps = 24 }\n";

/// A pseudo-random number of a generator with a fixed start.
fn next(state: &mut u64) -> u64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

#[test]
fn killed_at_thirty_moments_it_loses_no_row_makes_none_twice_and_none_wrong() {
    let folder = Folder::new();
    study(&folder, FLOORS);
    let begun = Instant::now();
    ended_with(0, &folder.ilon(&["sweep", "study.toml", "--out", "whole"]));
    let whole_ms = begun.elapsed().as_millis() as u64;
    let mut state = 1;
    let mut kills = 0;
    let mut rows_before = 0;
    while kills < 30 {
        let mut child = folder
            .command(&["sweep", "study.toml", "--out", "killed"])
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("the command runs");
        std::thread::sleep(Duration::from_millis(next(&mut state) % whole_ms.max(1)));
        // SIGKILL.
        let _ = child.kill();
        let _ = child.wait();
        kills += 1;
        let log = std::fs::read(folder.path("killed/rows.log")).unwrap_or_default();
        let rows = log.iter().filter(|byte| **byte == b'\n').count();
        assert!(rows >= rows_before, "a row was lost");
        rows_before = rows;
        // Kills should hit each part of the study, so from time to time it begins anew.
        if rows == 24 && kills % 3 == 0 {
            std::fs::remove_dir_all(folder.path("killed")).expect("the folder is there");
            rows_before = 0;
        }
    }
    ended_with(0, &folder.ilon(&["sweep", "study.toml", "--out", "killed"]));
    for name in ["runs.parquet", "findings.json", "report.html"] {
        let of = |run: &str| std::fs::read(folder.path(run).join(name)).expect("a result");
        let is_equal = of("whole") == of("killed");
        assert!(is_equal, "{name} differs");
    }
    let log = folder.read("killed/rows.log");
    let mut runs: Vec<&str> = log
        .lines()
        .map(|line| {
            line.split("\"run\":")
                .nth(1)
                .and_then(|rest| rest.split(',').next())
                .expect("a row")
        })
        .collect();
    let count = runs.len();
    runs.sort_unstable();
    runs.dedup();
    assert_eq!((count, runs.len()), (24, 24), "each run once");
    let names = folder.names("killed");
    assert_eq!(
        names,
        [
            "findings.json",
            "report.html",
            "rows.log",
            "runs.parquet",
            "study.json"
        ]
    );
}

#[test]
fn shards_are_made_side_by_side_and_merged() {
    let folder = Folder::new();
    study(&folder, FLOORS);
    let shards: Vec<_> = ["1/2", "2/2"]
        .into_iter()
        .map(|shard| {
            let mut command =
                folder.command(&["sweep", "study.toml", "--out", "parts", "--shard", shard]);
            command
                .stdout(std::process::Stdio::piped())
                .stderr(std::process::Stdio::piped());
            command.spawn().expect("the command runs")
        })
        .collect();
    for shard in shards {
        let all = ended_with(0, &shard.wait_with_output().expect("it ends"));
        assert!(all.contains("12 runs in parts/shard-"), "{all}");
    }
    ended_with(0, &folder.ilon(&["sweep", "--merge", "parts"]));
    ended_with(0, &folder.ilon(&["sweep", "study.toml", "--out", "whole"]));
    let of = |run: &str| std::fs::read(folder.path(run).join("runs.parquet")).expect("rows");
    assert!(of("parts") == of("whole"));
    // Without --out the place of several results is undefined.
    let refused = ended_with(2, &folder.ilon(&["sweep", "--merge", "parts", "whole"]));
    assert!(refused.contains("add --out DIR"), "{refused}");
    let refused = ended_with(2, &folder.ilon(&["sweep", "--merge", "nowhere"]));
    assert!(
        refused.contains("`nowhere` holds no results of a study"),
        "{refused}"
    );
}

#[test]
fn a_full_disk_ends_it_in_words_and_what_was_run_stays() {
    // A file size limit simulates a full disk: writing beyond it fails.
    let folder = Folder::new();
    study(&folder, FLOORS);
    let limited = |blocks: &str| {
        let ilon = env!("CARGO_BIN_EXE_ilon");
        let script = format!(
            "trap '' XFSZ; ulimit -f {blocks}; exec '{ilon}' sweep study.toml --out full --jobs 2"
        );
        let mut command = std::process::Command::new("bash");
        command.args(["-c", &script]).current_dir(folder.path(""));
        command.output().expect("a shell")
    };
    let refused = ended_with(2, &limited("16"));
    assert!(
        refused.contains("cannot write `full/rows.log`"),
        "{refused}"
    );
    let rows = folder.read("full/rows.log").lines().count();
    assert!(rows > 0 && rows < 24, "{rows}");
    let all = ended_with(0, &folder.ilon(&["sweep", "study.toml", "--out", "full"]));
    assert!(!all.contains("could not be read again"), "{all}");
    ended_with(0, &folder.ilon(&["sweep", "study.toml", "--out", "whole"]));
    let of = |run: &str| std::fs::read(folder.path(run).join("runs.parquet")).expect("rows");
    assert!(of("full") == of("whole"));
}

#[test]
fn two_at_once_into_one_folder_are_refused() {
    let folder = Folder::new();
    study(
        &folder,
        "[axes]\nworld.floor.friction = { from = 0.02, to = 0.8, steps = 400 }\n",
    );
    let mut first = folder
        .command(&["sweep", "study.toml", "--out", "shared"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the command runs");
    while !folder.path("shared/rows.log").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let refused = ended_with(2, &folder.ilon(&["sweep", "study.toml", "--out", "shared"]));
    let _ = first.kill();
    let _ = first.wait();
    assert!(
        refused.contains("is being written to by another run"),
        "{refused}"
    );
}

#[test]
fn check_holds_a_study_against_its_share_of_runs() {
    let folder = Folder::new();
    let expect = |share: f64| {
        format!(
            "[expect]\nduration_s = {{ max = 0.65, share = {share} }}\n[axes]\nrun.duration_s = [0.9, 0.4, 0.5, 0.6]\n"
        )
    };
    study(&folder, &expect(0.75));
    let held = ended_with(0, &folder.ilon(&["check", "study.toml", "good.toml"]));
    assert!(held.contains("held   study"), "{held}");
    study(&folder, &expect(0.9));
    let failed = ended_with(1, &folder.ilon(&["check", "study.toml"]));
    assert!(
        failed.contains("share of 4 runs with duration_s <= 0.65 >= 0.9 failed: measured 0.75"),
        "{failed}"
    );
    assert!(
        failed.contains("to see it: ilon sweep study.toml"),
        "{failed}"
    );
    // Settings of a scenario are not those of a study.
    let refused = ended_with(
        2,
        &folder.ilon(&["check", "study.toml", "--set", "run.duration_s=1"]),
    );
    assert!(refused.contains("--set changes scenarios"), "{refused}");
}

#[test]
fn what_was_found_is_printed_written_and_shown_with_commands_that_run_it_again() {
    let folder = Folder::new();
    study(
        &folder,
        "quantities = [\"slip_energy_j\"]\n[axes]\nworld.floor.friction = [0.02, 0.6]\n",
    );
    let json = folder.ilon(&["sweep", "study.toml", "--out", "out", "--json"]);
    ended_with(0, &json);
    let printed: serde_json::Value = serde_json::from_str(&stdout(&json)).expect("JSON alone");
    assert_eq!(printed["runs"], 2);
    let written: serde_json::Value =
        serde_json::from_str(&folder.read("out/findings.json")).expect("JSON");
    assert_eq!(printed, written);
    let page = folder.read("out/report.html");
    let command = page
        .split("<code>ilon run ")
        .nth(1)
        .and_then(|rest| rest.split("</code>").next())
        .expect("a command");
    let words: Vec<&str> = command.split(' ').collect();
    let again = folder.ilon(&[&["run"], words.as_slice(), &["--out", "again"]].concat());
    ended_with(0, &again);
    assert!(!stderr(&json).contains('{'), "{}", stderr(&json));
}

/// The lead of a page, as plain text.
fn lead(page: &str) -> String {
    let lead = page.split("<div class=\"story\">").nth(1).expect("a lead");
    let lead = lead.split("</div>").next().unwrap_or_default();
    lead.replace("</p><p>", "\n")
        .replace("&gt;", ">")
        .replace("&lt;", "<")
}

/// One sentence on the terminal and on the page, with the numbers of `findings.json`.
#[test]
fn a_grid_says_its_range_and_main_effects_on_the_terminal_and_on_the_page() {
    let folder = Folder::new();
    study(
        &folder,
        "quantities = [\"steps\"]\nset.run.control_dt_s = 0.02\n[axes]\nrun.duration_s = [0.2, 0.4]\nrun.physics_dt_s = [0.001, 0.002]\n",
    );
    let output = folder.ilon(&["sweep", "study.toml", "--out", "out"]);
    ended_with(0, &output);
    // 200 and 400 steps of 1 ms, 100 and 200 of 2 ms: each axis causes 22500 of 47500.
    let sentence = "Physics steps: from 100 (duration 0.2 s, physics dt 0.002 s, run 1) to 400 (duration 0.4 s, physics dt 0.001 s, run 2). \
                    Duration explains 47 % of the variation, physics dt explains 47 % of the variation; their interaction explains 5.3 %.";
    let printed = stdout(&output).replace("\n    ", " ");
    assert!(printed.contains(sentence), "{printed}");
    let lead = lead(&folder.read("out/report.html"));
    assert!(lead.contains(sentence), "{lead}");
    let findings: serde_json::Value =
        serde_json::from_str(&folder.read("out/findings.json")).expect("JSON");
    assert_eq!(findings["ranges"][0]["largest"]["value"], 400.0);
}

#[test]
fn what_a_study_does_not_answer_is_said_on_the_terminal_and_on_the_page() {
    let folder = Folder::new();
    for method in ["sobol_indices", "morris"] {
        // Its means begin after these runs have ended.
        study(
            &folder,
            &format!(
                "method = \"{method}\"\npoints = 3\nquantities = [\"twist_mean.vy_m_s\"]\nset.run.duration_s = 0.2\n\
                 axes.world.floor.friction = {{ from = 0.2, to = 0.8 }}\n"
            ),
        );
        let output = folder.ilon(&["sweep", "study.toml", "--out", method]);
        ended_with(0, &output);
        let runs = if method == "morris" { 6 } else { 9 };
        let sentence = format!(
            "Real twist, mean vy is absent in {runs} of {runs} runs: it is taken over the window of the means"
        );
        let printed = stdout(&output);
        assert!(printed.contains(&sentence), "{printed}");
        let lead = lead(&folder.read(&format!("{method}/report.html")));
        assert!(lead.contains(&sentence), "{lead}");
        let findings: serde_json::Value =
            serde_json::from_str(&folder.read(&format!("{method}/findings.json"))).expect("JSON");
        assert_eq!(findings["gaps"][0]["absent"], runs);
    }
}

#[test]
fn quiet_it_prints_nothing_but_what_is_asked_for() {
    let folder = Folder::new();
    study(
        &folder,
        "expect.slip_energy_j = { max = -1 }\naxes.world.floor.friction = [0.2]\n",
    );
    let output = folder.ilon(&["sweep", "study.toml", "-q"]);
    assert_eq!(ended_with(0, &output), "");
    assert!(folder.path("out/study/report.html").exists());
    let output = folder.ilon(&["sweep", "study.toml", "--quiet", "--json"]);
    ended_with(0, &output);
    let json: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON alone");
    assert_eq!((&json["runs"], stderr(&output).as_str()), (&1.into(), ""));
    // A shard, and its merged result; errors are still printed.
    let shard = [
        "sweep",
        "study.toml",
        "-q",
        "--out",
        "parts",
        "--shard",
        "1/1",
    ];
    assert_eq!(ended_with(0, &folder.ilon(&shard)), "");
    let merged = folder.ilon(&["sweep", "--merge", "parts", "-q"]);
    assert_eq!(ended_with(0, &merged), "");
    assert_ne!(
        ended_with(2, &folder.ilon(&["sweep", "nowhere.toml", "-q"])),
        ""
    );
}

#[test]
fn a_page_of_ten_thousand_runs_is_below_two_megabytes() {
    use ilon::report::sweep::{Quantity, Run, StudyInput, Varied, html};
    let mut state = 7;
    let mut unit = || next(&mut state) as f64 / (1u64 << 31) as f64;
    let varied = |index: usize| Varied {
        key: format!("robot.spec.some.long.key_{index}"),
        words: Vec::new(),
        is_log: false,
    };
    let runs: Vec<Run> = (0..10_000)
        .map(|run| Run {
            run,
            scenario: 0,
            values: (0..8).map(|_| unit()).collect(),
            figures: (0..6).map(|_| Some(1e3 * unit())).collect(),
            has_failed: run % 100 == 0,
        })
        .collect();
    let quantity = |index: usize| Quantity {
        name: format!("quantity_{index}"),
        bound: Some(500.0),
    };
    for is_sample in [true, false] {
        let mut shown = StudyInput {
            name: "many".to_owned(),
            varied: (0..8).map(varied).collect(),
            quantities: (0..6).map(quantity).collect(),
            is_sample,
            ..StudyInput::default()
        };
        shown.runs = runs.clone();
        if !is_sample {
            // A grid of 100 by 100.
            for run in &mut shown.runs {
                run.values = vec![(run.run % 100) as f64, (run.run / 100) as f64];
            }
            shown.varied.truncate(2);
        }
        let page = html(&shown, &|run| {
            format!("ilon run scenario.toml --set a={run}")
        });
        assert!(page.len() < 2_000_000, "{} bytes", page.len());
        assert!(!page.contains("plotly"));
    }
}

#[test]
fn bad_studies_end_with_code_2_their_place_and_nothing_written() {
    let folder = Folder::new();
    study(&folder, "axes.world.floor.frction = [1]");
    let refused = ended_with(2, &folder.ilon(&["sweep", "study.toml", "--out", "bad"]));
    assert!(
        refused.contains("[study.toml:2:18]") && refused.contains("did you mean `friction`?"),
        "{refused}"
    );
    assert!(!folder.path("bad").exists());
    for (arguments, words) in [
        (vec!["sweep", "nowhere.toml"], "cannot read `nowhere.toml`"),
        (vec!["sweep"], "required"),
        (vec!["sweep", "study.toml", "--shard", "3/2"], "write I/N"),
        (
            vec!["sweep", "good.toml"],
            "is a scenario, not a study of many runs",
        ),
    ] {
        let refused = ended_with(2, &folder.ilon(&arguments));
        assert!(refused.contains(words), "{refused}");
    }
}

#[test]
fn a_study_of_which_no_run_comes_to_its_end_does_not_end_well() {
    let folder = Folder::new();
    study(&folder, "axes.world.floor.friction = [-1, -2]");
    let ended = folder.ilon(&["sweep", "study.toml", "--out", "out"]);
    let printed = ended_with(2, &ended);
    assert!(printed.contains("2 of them failed"), "{printed}");
    assert!(
        stderr(&ended).contains("NO RUN CAME TO ITS END"),
        "{}",
        stderr(&ended)
    );
}

#[test]
fn a_shard_prints_json_and_nothing_else_where_asked() {
    let folder = Folder::new();
    study(&folder, "axes.world.floor.friction = [0.2, 0.4]");
    let ended = folder.ilon(&[
        "sweep",
        "study.toml",
        "--out",
        "out",
        "--shard",
        "1/2",
        "--json",
    ]);
    ended_with(0, &ended);
    let printed: serde_json::Value = serde_json::from_str(&stdout(&ended)).expect("JSON alone");
    assert_eq!(
        (&printed["runs"], &printed["shard"]),
        (&1.into(), &"1/2".into())
    );
}

#[test]
fn the_worst_run_of_merged_shards_is_kept_where_it_is_said_to_be() {
    let folder = Folder::new();
    study(
        &folder,
        "keep = \"worst 1\"\naxes.world.floor.friction = [0.2, 0.4]",
    );
    for shard in ["1/2", "2/2"] {
        ended_with(
            0,
            &folder.ilon(&["sweep", "study.toml", "--out", "out", "--shard", shard]),
        );
    }
    let printed = ended_with(
        0,
        &folder.ilon(&["sweep", "--merge", "out", "--out", "out"]),
    );
    assert!(printed.contains(", kept/"), "{printed}");
    let kept = std::fs::read_dir(folder.path("out/kept")).expect("what was kept");
    assert_eq!(kept.count(), 1);
}

#[test]
fn running_a_study_as_a_scenario_says_how_it_is_run() {
    let folder = Folder::new();
    study(&folder, "axes.world.floor.friction = [0.2]");
    let ended = folder.ilon(&["run", "study.toml"]);
    ended_with(2, &ended);
    assert!(
        stderr(&ended).contains("read it with `ilon sweep study.toml`"),
        "{}",
        stderr(&ended)
    );
}

/// A robot that loses less the slower it drives: the least lies at the slow end of the grid, and
/// the run's remark on its patch is not lost.
#[test]
fn a_grid_says_where_its_ends_are_best_and_what_its_runs_remark() {
    let folder = Folder::new();
    study(
        &folder,
        "quantities = [\"travelled_m\"]\n[set]\nworld.floor.patches = [{ x_m = 9, y_m = 9, length_x_m = 1, length_y_m = 1, friction = 0.1 }]\n\
         [axes]\ntwist.vx_m_s = [0.1, 0.2, 0.3]\n",
    );
    let told = ended_with(0, &folder.ilon(&["sweep", "study.toml", "--out", "out"]));
    assert!(
        told.contains("Both lie at the end of vx: further out there may be less, and more."),
        "{told}"
    );
    assert!(
        told.contains("Note in all 3 runs: no wheel was ever on patch 0"),
        "{told}"
    );
    let page = folder.read("out/report.html");
    assert!(page.contains("Note in all 3 runs"));
    let findings: serde_json::Value =
        serde_json::from_str(&folder.read("out/findings.json")).expect("JSON");
    assert_eq!(findings["notes"][0]["count"], 3);
}

/// A gain has its unit behind a stroke, and the page has the units of the sentences.
#[test]
fn units_of_a_study_are_those_of_a_person() {
    let folder = Folder::new();
    let scenario = "[robot]\nfile = \"robot.urdf\"\n[reference.circle]\nradius_m = 1\nspeed_m_s = 0.2\n[run]\nduration_s = 0.5\n";
    folder.write("circle.toml", scenario);
    folder.write(
        "study.toml",
        "scenario = \"circle.toml\"\nquantities = [\"position_error_final_m\"]\n[axes]\nguidance.position_gain_per_s = [1, 5]\n",
    );
    let told = ended_with(0, &folder.ilon(&["sweep", "study.toml", "--out", "out"]));
    assert!(
        told.contains("position gain 1/s") && !told.contains("1 1/s"),
        "{told}"
    );
    assert!(told.contains(" mm"), "{told}");
    let page = folder.read("out/report.html");
    assert!(page.contains("in mm over") && !page.contains("in m over"));
}
