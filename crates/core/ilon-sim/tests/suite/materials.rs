//! Materials of rollers and floors: a pair acts like the corresponding floor keys, and unknown
//! names are refused.

use crate::support;

use ilon_sim::scenario::Scenario;
use ilon_sim::{Error, Simulation};
use support::{Folder, SCENARIO, message};

/// Rollers of rubber on concrete; the robot then drives on to a carpet.
const PAIRS: &str = r#"
[world.floor]
material = "concrete"

[[world.floor.patches]]
x_m = 0.0
y_m = 0.6
length_x_m = 2.0
length_y_m = 1.15
material = "carpet"

[rollers]
material = "rubber"

[materials.rubber.concrete]
friction = 0.8
rolling_resistance = 0.01

[materials.rubber.carpet]
friction = 0.5
rolling_resistance = 0.12
creep = 0.3
sliding = { friction = 0.4, speed_m_s = 0.1 }
across = { creep = 0.5, rolling_resistance = 0.2, friction = 0.6 }
against = { rolling_resistance = 0.15 }
"#;

/// The scenario of a text after the common one; its robot's file vanishes with the folder, so it is
/// used at once.
fn with<T>(
    text: &str,
    settings: &[&str],
    act: impl FnOnce(&Scenario) -> Result<T, Error>,
) -> Result<T, Error> {
    let folder = Folder::new();
    let path = folder.write("materials.toml", &format!("{SCENARIO}{text}"));
    let settings: Vec<_> = settings.iter().map(|s| s.parse().unwrap()).collect();
    act(&Scenario::load_with(path, &settings)?)
}

fn load(text: &str, settings: &[&str]) -> Result<Scenario, Error> {
    with(text, settings, |scenario| {
        Simulation::new(scenario)?;
        Ok(scenario.clone())
    })
}

fn hash(text: &str, settings: &[&str]) -> String {
    with(text, settings, |scenario| {
        Ok(ilon_sim::run(scenario)?.summary.trace_hash)
    })
    .unwrap()
}

#[test]
fn a_pair_of_materials_is_its_numbers_on_the_floor_to_the_bit() {
    let direct = r#"
[world.floor]
friction = 0.8
rolling_resistance = 0.01

[[world.floor.patches]]
x_m = 0.0
y_m = 0.6
length_x_m = 2.0
length_y_m = 1.15
friction = 0.5
rolling_resistance = 0.12
creep = 0.3
sliding = { friction = 0.4, speed_m_s = 0.1 }
across = { creep = 0.5, rolling_resistance = 0.2, friction = 0.6 }
against = { rolling_resistance = 0.15 }
"#;
    let by_pairs = hash(PAIRS, &[]);
    assert_eq!(by_pairs, hash(direct, &[]));
    // The values of a pair have an effect, on the patch and on the floor.
    for setting in [
        "materials.rubber.carpet.creep=0.1",
        "materials.rubber.carpet.across.creep=0.1",
        "materials.rubber.carpet.against.rolling_resistance=0.3",
        "materials.rubber.concrete.rolling_resistance=0.1",
        "world.floor.nap_deg=30",
        "world.floor.patches.0.nap_deg=30",
    ] {
        assert_ne!(by_pairs, hash(PAIRS, &[setting]), "{setting}");
    }
    // An isotropic nap has no effect in any direction.
    let alike = [
        "across.creep=0.3",
        "across.rolling_resistance=0.12",
        "across.friction=0.5",
        "against.rolling_resistance=0.12",
    ];
    let mut settings: Vec<String> = alike
        .iter()
        .map(|key| format!("materials.rubber.carpet.{key}"))
        .collect();
    let straight = hash(
        PAIRS,
        &settings.iter().map(String::as_str).collect::<Vec<_>>(),
    );
    settings.push("world.floor.nap_deg=40".to_owned());
    let turned = hash(
        PAIRS,
        &settings.iter().map(String::as_str).collect::<Vec<_>>(),
    );
    let without = direct
        .lines()
        .filter(|line| !line.starts_with("across") && !line.starts_with("against"))
        .collect::<Vec<_>>()
        .join("\n");
    assert_eq!(straight, hash(&without, &[]));
    assert_eq!(turned, straight);
}

#[test]
fn what_is_run_is_written_out_and_runs_again_to_the_same_bits() {
    let folder = Folder::new();
    let path = folder.write("materials.toml", &format!("{SCENARIO}{PAIRS}"));
    let run = ilon_sim::run(&Scenario::load(path).unwrap()).unwrap();
    let written = folder.write("written.toml", &run.scenario.to_toml().unwrap());
    let again = ilon_sim::run(&Scenario::load(written).unwrap()).unwrap();
    assert_eq!(run.summary.trace_hash, again.summary.trace_hash);
    assert!(
        run.scenario
            .to_toml()
            .unwrap()
            .contains("[materials.rubber.carpet]")
    );
}

#[test]
fn names_that_do_not_fit_are_refused_with_those_that_would() {
    for (settings, said) in [
        (
            &["world.floor.material=concret"][..],
            &[
                "concret",
                "rubber",
                "rubber on carpet, rubber on concrete",
                "did you mean the floor \"concrete\"?",
            ][..],
        ),
        (
            &["world.floor.patches.0.material=ice"],
            &[
                "world.floor.patches.0.material",
                "ice",
                "[materials.rubber.ice]",
            ],
        ),
        (
            &["rollers.material=rubbr"],
            &["rubbr", "did you mean rollers of \"rubber\"?"],
        ),
        (
            &["rollers.wheel_materials.front_left=steel"],
            &["\"steel\"", "rubber on concrete"],
        ),
        (
            &["rollers.wheel_materials.front=rubber"],
            &["`front`", "front_left"],
        ),
        (
            &["world.floor.friction=0.3"],
            &[
                "world.floor.friction",
                "world.floor.material",
                "materials.ROLLERS.concrete.friction",
            ],
        ),
        (
            &["world.floor.creep=0"],
            &["world.floor.creep", "do not go together"],
        ),
        (
            &["world.floor.patches.0.rolling_resistance=0.3"],
            &[
                "world.floor.patches.0.rolling_resistance",
                "do not go together",
            ],
        ),
        (
            &["materials.rubber.carpet.friction=0"],
            &["materials.rubber.carpet.across.friction"],
        ),
        (
            &["materials.rubber.carpet.crep=1"],
            &["materials.rubber.carpet.crep", "did you mean `creep`?"],
        ),
        (
            &["materials.rubber.carpet.creep=-1"],
            &["materials.rubber.carpet.creep"],
        ),
        (&["world.solver.contacts=rapier"], &["rapier"]),
    ] {
        let (what, help) = message(load(PAIRS, settings));
        let text = format!("{what} {help}");
        for word in said {
            assert!(
                text.contains(word),
                "{settings:?}: {word:?} is not in {text:?}"
            );
        }
    }
    let (what, help) = message(load(&PAIRS.replace("material = \"rubber\"", ""), &[]));
    assert!(
        what.contains("front_left")
            && help.contains("rollers.material")
            && help.contains("\"rubber\""),
        "{what} {help}"
    );
    // A material of rollers that nothing uses.
    let (what, _) = message(load("[rollers]\nmaterial = \"rubber\"\n", &[]));
    assert!(what.contains("neither the floor nor a patch"), "{what}");
    // A patch without friction.
    let bare = "[[world.floor.patches]]\nx_m = 0\ny_m = 0\nlength_x_m = 1\nlength_y_m = 1\n";
    let (what, help) = message(load(bare, &[]));
    assert!(
        what.contains("world.floor.patches.0.friction` is missing") && help.contains("material"),
        "{what} {help}"
    );
    // Unused pairs are a table of materials, not a fault.
    assert!(load("[materials.rubber.ice]\nfriction = 0.05\n", &[]).is_ok());
}

/// A robot whose file has the materials of its rollers drives on floors without materials like any
/// other.
#[test]
fn a_robot_says_its_own_materials_and_wheels_may_differ() {
    let folder = Folder::new();
    let robot = std::fs::read_to_string(folder.path("mecanum4.toml")).unwrap();
    let robot = robot.replace("[rollers]", "[rollers]\nmaterial = \"rubber\"");
    let robot = format!("{robot}\n[overrides.rear_left]\nroller_material = \"steel\"\n");
    folder.write("mecanum4.toml", &robot);
    let hash = |text: &str| {
        let path = folder.write("own.toml", &format!("{SCENARIO}{text}"));
        let run = ilon_sim::run(&Scenario::load(path)?)?;
        Ok::<_, Error>((run.summary.trace_hash, run.trace))
    };
    let (plain, _) = hash("").unwrap();
    let bare = Folder::new();
    let path = bare.write("plain.toml", SCENARIO);
    let of_none = ilon_sim::run(&Scenario::load(path).unwrap()).unwrap();
    assert_eq!(plain, of_none.summary.trace_hash);
    let pairs = "[world.floor]\nmaterial = \"wood\"\n[materials]\nrubber.wood.friction = 0.7\nsteel.wood.friction = 0.2\n";
    let (_, trace) = hash(pairs).unwrap();
    let last = trace.records().len() - 1;
    let frictions: Vec<f64> = trace.wheels_at(last).iter().map(|w| w.friction).collect();
    let wheels: Vec<&str> = trace
        .header
        .wheels
        .iter()
        .map(|w| w.name.as_str())
        .collect();
    for (wheel, friction) in wheels.iter().zip(&frictions) {
        let expected = if *wheel == "rear_left" { 0.2 } else { 0.7 };
        assert_eq!(*friction, expected, "{wheel}");
    }
    // The scenario takes precedence, wheel by wheel.
    let (_, trace) = hash(&format!(
        "{pairs}[rollers]\nmaterial = \"steel\"\nwheel_materials = {{ front_left = \"rubber\" }}\n"
    ))
    .unwrap();
    let frictions: Vec<f64> = trace.wheels_at(last).iter().map(|w| w.friction).collect();
    for (wheel, friction) in wheels.iter().zip(&frictions) {
        let expected = if *wheel == "front_left" { 0.7 } else { 0.2 };
        assert_eq!(*friction, expected, "{wheel}");
    }
    let (what, help) = message(hash(
        "[world.floor]\nmaterial = \"wood\"\n[materials.rubber.wood]\nfriction = 0.7\n",
    ));
    assert!(
        what.contains("steel") && help.contains("rubber on wood"),
        "{what} {help}"
    );
}

/// A puddle on a floor of a material has its own friction, and all else of the floor.
#[test]
fn a_patch_of_no_material_leaves_the_rest_as_the_pair_has_it() {
    let puddle = |friction: &str| {
        format!(
            "[world.floor]\nmaterial = \"mat\"\n[[world.floor.patches]]\nx_m = 0\ny_m = 0\nlength_x_m = 9\nlength_y_m = 9\n{friction}\n\
             [rollers]\nmaterial = \"rubber\"\n[materials.rubber.mat]\nfriction = 0.7\ncreep = 0.4\nrolling_resistance = 0.1\n"
        )
    };
    let dry = "[world.floor]\nfriction = 0.7\ncreep = 0.4\nrolling_resistance = 0.1\n";
    assert_eq!(hash(&puddle("friction = 0.7"), &[]), hash(dry, &[]));
    assert_ne!(hash(&puddle("friction = 0.03"), &[]), hash(dry, &[]));
}

/// A temporary friction applies to rollers of every pair, and then the pairs apply again.
#[test]
fn a_floor_that_changes_its_friction_goes_back_to_its_pairs() {
    let text = "[world.floor]\nmaterial = \"wood\"\n[rollers]\nmaterial = \"rubber\"\nwheel_materials = { rear_left = \"steel\" }\n\
                [materials]\nrubber.wood.friction = 0.7\nsteel.wood.friction = 0.2\n\
                [[faults]]\nfriction_changed = { friction = 0.05, from_s = 0.2, until_s = 0.3 }\n";
    let folder = Folder::new();
    let path = folder.write("changes.toml", &format!("{SCENARIO}{text}"));
    let run = ilon_sim::run(&Scenario::load(path).unwrap()).unwrap();
    let trace = &run.trace;
    for (row, record) in trace.records().iter().enumerate() {
        let t_s = record.t_s;
        let frictions: Vec<f64> = trace.wheels_at(row).iter().map(|w| w.friction).collect();
        if (0.22..0.29).contains(&t_s) {
            assert_eq!(frictions, [0.05; 4]);
        } else if t_s > 0.32 {
            assert!(
                frictions.contains(&0.7) && frictions.contains(&0.2),
                "{frictions:?}"
            );
        }
    }
}
