//! `ilon check` as a test suite: which scenarios it takes, and that an expectation that cannot fail
//! does not count as met.

use crate::support;

use support::{FAILS, Folder, HOLDS, ended_with, stderr};

/// The number after a name in the table at the end.
fn count(printed: &str, name: &str) -> String {
    let table = printed
        .split("all scenarios")
        .nth(1)
        .expect("a table at the end");
    let line = table
        .lines()
        .find(|line| line.trim_start().starts_with(name));
    // A result that no scenario has gets no line.
    line.map_or("0", |line| {
        line.split_whitespace().last().unwrap_or_default()
    })
    .to_owned()
}

#[test]
fn what_expects_nothing_counts_apart_and_is_skipped_in_junit() {
    let folder = Folder::new();
    folder.scenario("empty.toml", "");
    folder.scenario("tolerant.toml", "[expect.tolerances]\ntruth_x_m = 1.0\n");
    let all = ["check", "good.toml", "empty.toml", "tolerant.toml"];
    let printed = ended_with(0, &folder.ilon(&[&all[..], &["--junit", "j.xml"]].concat()));
    assert!(printed.contains("EMPTY  empty"), "{printed}");
    assert!(printed.contains("EMPTY  tolerant"), "{printed}");
    assert_eq!(
        (count(&printed, "held"), count(&printed, "nothing expected")),
        ("1".into(), "2".into())
    );
    let junit = folder.read("j.xml");
    assert!(junit.contains("skipped=\"2\""), "{junit}");
    assert_eq!(
        junit
            .matches("<skipped message=\"nothing is expected of it")
            .count(),
        2,
        "{junit}"
    );
    // A baseline counts as an expectation.
    ended_with(0, &folder.ilon(&[&all[..], &["--save", "base"]].concat()));
    let printed = ended_with(
        0,
        &folder.ilon(&[&all[..], &["--against", "base"]].concat()),
    );
    assert_eq!(
        (count(&printed, "held"), count(&printed, "nothing expected")),
        ("3".into(), "0".into())
    );
}

/// A robot description among the scenarios is no test, and no error.
#[test]
fn robots_among_scenarios_are_skipped() {
    let folder = Folder::new();
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots/");
    let robot = std::fs::read_to_string(format!("{robots}mecanum4.toml")).expect("a robot");
    folder.write("robot.toml", &robot);
    let printed = ended_with(0, &folder.ilon(&["check", "."]));
    assert_eq!(count(&printed, "held"), "1");
    assert!(!printed.contains("robot"), "{printed}");
}

/// A run's trace hash is the same in both commands, and differs for a changed scenario.
#[test]
fn a_check_tells_the_trace_hash_of_its_run() {
    let folder = Folder::new();
    let hash = |set: &[&str]| {
        let printed = folder.ilon(&[&["check", "good.toml", "--json"], set].concat());
        let told: serde_json::Value = serde_json::from_slice(&printed.stdout).expect("JSON");
        told["scenarios"][0]["trace_hash"].clone()
    };
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "run"]));
    let summary = folder.read("run/summary.json");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let of_run = summary["trace_hash"].clone();
    assert!(of_run.is_string());
    assert_eq!(hash(&[]), of_run);
    assert_ne!(hash(&["--set", "run.duration_s=0.1"]), of_run);
}

/// The same figures in both commands, in the page that is rebuilt from the trace, and with the
/// scenario's key; the run is bit-identical.
#[test]
fn a_run_that_is_repeated_at_half_the_step_says_what_moves() {
    let folder = Folder::new();
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = folder.ilon(arguments);
        ended_with(0, &output);
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let alone = json(&["run", "good.toml", "--out", "alone", "--json", "--no-twins"]);
    assert_eq!(alone.get("converge"), None);
    let run = json(&["run", "good.toml", "--out", "run", "--json", "--converge"]);
    assert_eq!(run["trace_hash"], alone["trace_hash"]);
    let place = &run["converge"]["end_x_m"];
    assert_eq!(place["value"], alone["end_x_m"]);
    assert!(
        place["half_step"].is_f64() && place["moved"].is_f64(),
        "{place}"
    );

    let checked = json(&["check", "good.toml", "--json", "--converge"]);
    assert_eq!(checked["scenarios"][0]["converge"], run["converge"]);
    let by_key = ["check", "good.toml", "--json", "--set", "run.converge=true"];
    assert_eq!(json(&by_key)["scenarios"][0]["converge"], run["converge"]);
    let printed = ended_with(0, &folder.ilon(&["check", "good.toml", "--converge"]));
    assert!(
        printed.contains("stay within their stated accuracy at half the step"),
        "{printed}"
    );

    for page in ["run", "alone"] {
        ended_with(0, &folder.ilon(&["report", page]));
        let says = folder
            .read(&format!("{page}/report.html"))
            .contains("At half the step");
        assert_eq!(says, page == "run");
    }
}

#[test]
fn a_bound_that_cannot_fail_is_refused_where_it_stands() {
    let folder = Folder::new();
    for (name, expect) in [
        ("a", "[expect]\nhub_ripple_m = {}\n"),
        ("b", "[expect]\nhub_ripple_m = { within = 1e-9 }\n"),
        ("c", "[[expect.signals]]\nsignal = \"truth_y_m\"\n"),
        ("d", "[expect]\nhub_ripple_m = { min = 1, max = 0 }\n"),
        ("g", "[expect]\nhub_ripple_m = { max = -1 }\n"),
        ("h", "[expect]\nposition_error_final_m = { max = 0.1 }\n"),
        ("i", "[expect]\ndesign.rank = { min = 3 }\n"),
        (
            "e",
            "[[expect.signals]]\nsignal = \"truth_y_m\"\nmax = 1\nuntil_s = 9\n",
        ),
        (
            "f",
            "[[expect.signals]]\nsignal = \"truth_y_m\"\nmax = 1\nfrom_s = 9\n",
        ),
    ] {
        folder.scenario(&format!("bad/{name}.toml"), expect);
    }
    let printed = ended_with(2, &folder.ilon(&["check", "bad", "good.toml"]));
    assert_eq!(
        (count(&printed, "held"), count(&printed, "could not run")),
        ("1".into(), "9".into())
    );
    for name in ["a", "b", "c", "d", "e", "f", "g", "h", "i"] {
        assert!(
            printed.contains(&format!("ERROR  {name}: `expect.")),
            "{printed}"
        );
    }
    // Shortened for a preview it runs, with a message.
    folder.scenario(
        "long.toml",
        "[[expect.signals]]\nsignal = \"truth_y_m\"\nmax = 1\nuntil_s = 0.4\n",
    );
    let short = ["--set", "run.duration_s=0.2"];
    let printed = ended_with(
        0,
        &folder.ilon(&[&["run", "long.toml"][..], &short].concat()),
    );
    assert!(printed.contains("note: `expect.signals.0`"), "{printed}");
    ended_with(
        2,
        &folder.ilon(&[&["check", "long.toml"][..], &short].concat()),
    );
}

#[test]
fn a_folder_is_taken_with_all_below_it_and_with_endings_in_capitals() {
    let folder = Folder::new();
    folder.scenario("all/one.toml", HOLDS);
    folder.scenario("all/Two.TOML", HOLDS);
    folder.scenario("all/deep/er/three.toml", FAILS);
    folder.scenario("all/.hidden/four.toml", FAILS);
    folder.scenario("all/.five.toml", FAILS);
    folder.write("all/notes.txt", "no scenario");
    let printed = ended_with(1, &folder.ilon(&["check", "all"]));
    for line in ["held   Two ", "held   one ", "FAILED deep/er/three "] {
        assert!(printed.contains(line), "{printed}");
    }
    assert_eq!(
        (count(&printed, "held"), count(&printed, "failed")),
        ("2".into(), "1".into())
    );
    let printed = ended_with(1, &folder.ilon(&["check", "all", "--filter", "deep"]));
    assert_eq!(
        (count(&printed, "held"), count(&printed, "failed")),
        ("0".into(), "1".into())
    );
    // Results of runs among the scenarios are no tests.
    ended_with(
        0,
        &folder.ilon(&["run", "all/one.toml", "--out", "all/out/one"]),
    );
    ended_with(1, &folder.ilon(&["check", "all", "--keep", "all/kept"]));
    let printed = ended_with(1, &folder.ilon(&["check", "all"]));
    assert_eq!(
        (count(&printed, "held"), count(&printed, "failed")),
        ("2".into(), "1".into())
    );
    // Unless they are named explicitly.
    let printed = ended_with(0, &folder.ilon(&["check", "all/out/one"]));
    assert_eq!(count(&printed, "held"), "1");
}

#[test]
fn a_named_folder_that_holds_no_scenario_is_bad_input() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("empty")).expect("a folder");
    let printed = ended_with(
        2,
        &folder.ilon(&["check", "empty", "good.toml", "--junit", "j.xml"]),
    );
    assert!(
        printed.contains("ERROR  empty: `empty` holds no scenario"),
        "{printed}"
    );
    assert_eq!(
        (count(&printed, "held"), count(&printed, "could not run")),
        ("1".into(), "1".into())
    );
    assert!(folder.read("j.xml").contains("errors=\"1\""));
    ended_with(2, &folder.ilon(&["check", "empty"]));
    // A filter that matches nothing in one folder is accepted if it matches something in another.
    folder.scenario("some/other.toml", HOLDS);
    let filtered = ["check", "some", "good.toml", "--filter", "good"];
    let printed = ended_with(0, &folder.ilon(&filtered));
    assert_eq!(count(&printed, "held"), "1");
    let printed = ended_with(2, &folder.ilon(&["check", "some", "--filter", "good"]));
    let says = "no scenario's name contains `good`";
    assert!(
        printed.contains(says) && printed.contains("such as `other`"),
        "{printed}"
    );
}

#[test]
fn a_scenario_that_is_named_twice_runs_once() {
    let folder = Folder::new();
    folder.scenario("in/x.toml", HOLDS);
    for paths in [
        &["in/x.toml", "in/x.toml"][..],
        &["in", "in/x.toml"],
        &["in", "./in"],
        &["in/x.toml", "in"],
    ] {
        let arguments = [&["check"][..], paths, &["--save", "base"]].concat();
        let printed = ended_with(0, &folder.ilon(&arguments));
        assert_eq!(count(&printed, "held"), "1", "{paths:?}");
    }
}

#[test]
fn bounds_are_not_updated_to_what_other_settings_give() {
    let folder = Folder::new();
    let before = folder.read("good.toml");
    let update = [
        "check",
        "good.toml",
        "--update",
        "--set",
        "twist.vx_m_s=0.1",
    ];
    let ended = folder.ilon(&update);
    ended_with(2, &ended);
    assert!(
        stderr(&ended).contains("--update would write"),
        "{}",
        stderr(&ended)
    );
    assert_eq!(folder.read("good.toml"), before);
}

#[test]
fn options_that_do_nothing_for_a_study_are_named() {
    let folder = Folder::new();
    folder.write(
        "study.toml",
        "scenario = \"good.toml\"\naxes.world.floor.friction = [0.5]\nexpect.slip_energy_j = { max = 1e3 }\n",
    );
    let ended = folder.ilon(&["check", "study.toml", "--save", "baseline"]);
    ended_with(0, &ended);
    let said = stderr(&ended);
    assert!(
        said.contains("is a study, of which --save does nothing"),
        "{said}"
    );
}

/// A regression gate in four commands: bounds are written, they hold, a baseline is kept, and a
/// change is printed in per cent and as Markdown.
#[test]
fn bounds_and_baselines_begin_from_nothing_and_changes_are_told_in_per_cent() {
    let folder = Folder::new();
    folder.scenario("fresh.toml", "");
    let before = folder.read("fresh.toml");
    let said = ended_with(0, &folder.ilon(&["check", "fresh.toml", "--init", "0.1"]));
    assert!(said.contains("UPDATED fresh"), "{said}");
    let written = folder.read("fresh.toml");
    assert!(written.starts_with(before.trim_end()), "{written}");
    assert!(written.contains("slip_energy_j = { max = "), "{written}");
    let held = ended_with(0, &folder.ilon(&["check", "fresh.toml", "--save", "base"]));
    assert!(held.contains("held   fresh"), "{held}");
    // Existing bounds stay.
    ended_with(0, &folder.ilon(&["check", "fresh.toml", "--init", "0.5"]));
    assert_eq!(folder.read("fresh.toml"), written);
    folder.write("summary.md", "## before\n");
    let changed = [
        "check",
        "fresh.toml",
        "--against",
        "base",
        "--markdown",
        "summary.md",
        "--set",
        "twist.vx_m_s=0.1",
    ];
    let said = ended_with(1, &folder.ilon(&changed));
    assert!(said.contains(", was ") && said.contains(" %)"), "{said}");
    let summary = folder.read("summary.md");
    assert!(
        summary.starts_with("## before\n| scenario | result |\n"),
        "{summary}"
    );
    assert!(summary.contains("| fresh | failed<br>"), "{summary}");
    assert_eq!(summary.lines().count(), 4, "{summary}");
}

/// A name in a file must not become markup in the job's summary.
#[test]
fn markdown_shows_names_as_they_are_written() {
    let folder = Folder::new();
    folder.scenario("a|b<i>_c.toml", "");
    ended_with(
        3,
        &folder.ilon(&["check", "a|b<i>_c.toml", "--markdown", "s.md"]),
    );
    let row = folder.read("s.md").lines().nth(2).map(str::to_owned);
    assert_eq!(
        row.as_deref(),
        Some(r"| a\|b&lt;i&gt;\_c | nothing expected |")
    );
}

/// Tables and line ends of the file are kept, and no bound is written that nothing could violate:
/// 1.1 times a full use of grip exceeds its maximum.
#[test]
fn first_bounds_keep_the_file_and_test_something() {
    let folder = Folder::new();
    folder.scenario("fresh.toml", "");
    let windows = folder.read("fresh.toml").replace('\n', "\r\n");
    folder.write("fresh.toml", &windows);
    let into_input = ["check", "fresh.toml", "--markdown", "fresh.toml"];
    assert!(ended_with(2, &folder.ilon(&into_input)).contains("--markdown"));
    let nowhere = ["check", "fresh.toml", "--markdown", "no/such/folder.md"];
    assert!(ended_with(2, &folder.ilon(&nowhere)).contains("--markdown"));
    assert_eq!(folder.read("fresh.toml"), windows);
    ended_with(0, &folder.ilon(&["check", "fresh.toml", "--init"]));
    let written = folder.read("fresh.toml");
    assert!(written.starts_with(windows.trim_end()), "{written:?}");
    assert!(
        written
            .split_inclusive('\n')
            .all(|line| line.ends_with("\r\n")),
        "{written:?}"
    );
    folder.scenario("ice.toml", "[world.floor]\nfriction = 0.01\n");
    ended_with(0, &folder.ilon(&["check", "ice.toml", "--init"]));
    let written = folder.read("ice.toml");
    assert!(
        written.contains("slip_energy_j") && !written.contains("friction_used_max"),
        "{written}"
    );
    // With motors at their limit no run could exceed a bound above it.
    folder.scenario("fast.toml", "");
    let fast = folder
        .read("fast.toml")
        .replace("vx_m_s = 0.2", "vx_m_s = 1.5");
    folder.write("fast.toml", &fast);
    let printed = ended_with(0, &folder.ilon(&["check", "fast.toml", "--init"]));
    let written = folder.read("fast.toml");
    assert!(
        written.contains("slip_energy_j") && !written.contains("wheel_torque_max_n_m"),
        "{printed}"
    );
    let too_wide = ["check", "fresh.toml", "--update", "1e308"];
    assert!(ended_with(2, &folder.ilon(&too_wide)).contains("from 0 to 10,"));
    let per_cent = ["check", "fresh.toml", "--init", "50"];
    assert!(ended_with(2, &folder.ilon(&per_cent)).contains("0.1 for 10 %"));
}

/// The printed command works in a shell, a failed bound shows by how much it failed, and results of
/// an earlier run are removed once all hold.
#[test]
fn a_failure_can_be_repeated_and_leaves_nothing_once_it_holds() {
    let folder = Folder::new();
    let path = "a b/x.toml";
    folder.scenario(path, "[expect]\nend_x_m = { min = 1.0 }\n");
    let check =
        |further: &[&str]| folder.ilon(&[&["check", path, "--keep", "kept"], further].concat());
    let said = ended_with(1, &check(&[]));
    let commands = "to see it: ilon run 'a b/x.toml'\n         why: ilon explain 'a b/x.toml'\n";
    assert!(said.contains(commands), "{said}");
    let files = ["--junit", "j.xml", "--markdown", "s.md"];
    ended_with(1, &check(&files));
    for file in ["j.xml", "s.md"] {
        let written = folder.read(file);
        assert!(written.contains("why: ilon explain"), "{written}");
    }
    assert!(said.contains(" % short)"), "{said}");
    assert!(folder.path("kept/x/summary.json").exists());
    ended_with(0, &check(&["--set", "expect.end_x_m.min=-1.0"]));
    assert!(!folder.path("kept/x").exists());

    let base = |further: &[&str]| folder.ilon(&[&["check", "good.toml"], further].concat());
    ended_with(0, &base(&["--save", "base"]));
    let longer = ["--against", "base", "--set", "run.duration_s=0.6"];
    let said = ended_with(1, &base(&longer));
    assert!(said.contains("the run takes 0.6 s, its baseline"), "{said}");
    assert!(folder.path("out/check/good/difference.html").exists());
    ended_with(0, &base(&["--against", "base"]));
    assert!(!folder.path("out/check/good/difference.html").exists());
}

/// Bounds that `--update` leaves unchanged are named, beside those that it writes.
#[test]
fn bounds_that_are_left_are_named() {
    let folder = Folder::new();
    let signals = "[expect]\nslip_energy_j = { max = 0 }\n[[expect.signals]]\nsignal = \"truth_x_m\"\nmax = -1\n";
    folder.scenario("s.toml", signals);
    let said = ended_with(1, &folder.ilon(&["check", "s.toml", "--update"]));
    assert!(
        said.contains("truth_x_m: bounds on signals are left: change it by hand"),
        "{said}"
    );
    assert!(said.contains("slip_energy_j.max: 0 -> "), "{said}");
    assert_eq!(
        count(&said, "of the failed, with bounds updated"),
        "1",
        "{said}"
    );
}

/// A wheel of another radius changes the commanded rates, so a bound around them has two sides.
#[test]
fn first_bounds_hold_the_rates_of_the_wheels_on_both_sides() {
    let folder = Folder::new();
    folder.scenario("fresh.toml", "");
    let said = ended_with(0, &folder.ilon(&["check", "fresh.toml", "--init"]));
    assert!(
        said.contains("wheel_rate_command_max_rad_s: { min = "),
        "{said}"
    );
    // A figure of nothing but rounding has the room of its accuracy: its bound holds at half the
    // step too.
    assert!(said.contains("widened to its accuracy"), "{said}");
    let halved = ["check", "fresh.toml", "--set", "run.physics_dt_s=0.0005"];
    ended_with(0, &folder.ilon(&halved));
    let swapped = ended_with(2, &folder.ilon(&["check", "--init", "fresh.toml"]));
    assert!(swapped.contains("files go before the option"), "{swapped}");
}

/// A test suite that tests nothing has not passed; one that shall only write its baselines has.
#[test]
fn a_check_of_nothing_fails() {
    let folder = Folder::new();
    folder.scenario("some/empty.toml", "");
    for quiet in [&[][..], &["--quiet"]] {
        let told = ended_with(3, &folder.ilon(&[&["check", "some"], quiet].concat()));
        assert!(told.contains("NOTHING WAS CHECKED"), "{told}");
        assert!(told.contains("--init"), "{told}");
    }
    ended_with(0, &folder.ilon(&["check", "some", "--save", "base"]));
    ended_with(0, &folder.ilon(&["check", "some", "--against", "base"]));
    ended_with(0, &folder.ilon(&["check", "some", "--init"]));
}

/// A name of 240 characters leaves no room for that of the unfinished file, in every command that
/// writes one.
#[test]
fn an_update_that_cannot_be_written_is_not_reported_as_done() {
    let folder = Folder::new();
    let name = format!("{}.toml", "n".repeat(240));
    folder.scenario(&name, FAILS);
    let output = folder.ilon(&["check", &name, "--update"]);
    let printed = ended_with(2, &output);
    assert!(!printed.contains("UPDATED"), "{printed}");
    assert!(printed.contains("ERROR"), "{printed}");
}

#[test]
fn a_scenario_that_is_gone_since_the_baseline_is_named() {
    let folder = Folder::new();
    folder.scenario("some/one.toml", HOLDS);
    folder.scenario("some/deep/two.toml", HOLDS);
    ended_with(0, &folder.ilon(&["check", "some", "--save", "base"]));
    let against = ["check", "some", "--against", "base"];
    assert!(!ended_with(0, &folder.ilon(&against)).contains("no scenario"));
    std::fs::remove_file(folder.path("some/deep/two.toml")).expect("it is there");
    let told = ended_with(0, &folder.ilon(&against));
    assert!(
        told.contains("`deep/two` has a baseline and no scenario"),
        "{told}"
    );
    let one = [&against[..], &["--filter", "one"]].concat();
    assert!(!ended_with(0, &folder.ilon(&one)).contains("no scenario"));
}

/// A change is bounded against a baseline: without one the scenario is refused; the same run holds,
/// and five times the speed on ice slips by more than a tenth more, while the signals may differ.
#[test]
fn a_change_is_bounded_against_a_baseline() {
    let folder = Folder::new();
    folder.scenario("gate.toml", "[expect]\nslip_energy_j = \"+10 %\"\n");
    let refused = folder.ilon(&["check", "gate.toml"]);
    ended_with(2, &refused);
    assert!(
        stderr(&refused).contains("--save DIR"),
        "{}",
        stderr(&refused)
    );
    ended_with(0, &folder.ilon(&["check", "gate.toml", "--save", "base"]));
    let gate = ["check", "gate.toml", "--against", "base"];
    let held = ended_with(0, &folder.ilon(&gate));
    assert!(held.contains("held   gate"), "{held}");
    let slower = [&gate[..], &["--set", "twist.vx_m_s=0.11"]].concat();
    let faster = [
        &gate[..],
        &[
            "--set",
            "world.floor.friction=0.05",
            "--set",
            "twist.vx_m_s=1",
        ],
    ]
    .concat();
    let said = ended_with(1, &folder.ilon(&faster));
    let bound = "slip_energy_j within +10 % (or 0.001, too little to count) of ";
    assert!(said.contains(bound), "{said}");
    assert!(said.contains(", was ") && said.contains(" %)"), "{said}");
    assert!(!said.contains("signal"), "{said}");
    // A change from next to nothing has no share: the robot did not slide before.
    let slid = said
        .lines()
        .find(|line| line.contains("sliding speed, largest"));
    assert!(
        slid.is_some_and(|line| line.ends_with("was 0.00 mm/s")),
        "{said}"
    );
    ended_with(0, &folder.ilon(&slower));
    // Signals with a tolerance are compared beside the changes, and no others.
    let both = "[expect]\nslip_energy_j = \"+10 %\"\n[expect.tolerances]\ntruth_x_m = 1e-4\n";
    folder.scenario("gate.toml", both);
    ended_with(0, &folder.ilon(&gate));
    let said = ended_with(1, &folder.ilon(&slower));
    assert!(
        said.contains("truth_x_m") && !said.contains("truth_vx_m_s"),
        "{said}"
    );
    folder.scenario("gate.toml", "[expect]\nslip_energy_j = \"+10 %\"\n");
    // No change is replaced by a first bound, and none that failed is updated away.
    let text = folder.read("gate.toml");
    ended_with(0, &folder.ilon(&[&gate[..], &["--init"]].concat()));
    assert_eq!(folder.read("gate.toml"), text);
    let wet = format!("{text}[world.floor]\nfriction = 0.01\n");
    folder.write("gate.toml", &wet);
    ended_with(1, &folder.ilon(&[&gate[..], &["--update"]].concat()));
    assert_eq!(folder.read("gate.toml"), wet);
}
