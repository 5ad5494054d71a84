//! The answer's sentences for every kind of fault and every way of standing, compared with the
//! scenario and the trace.

use std::path::Path;

use ilon::simulate::{Run, Simulation};
use ilon::trace::{Record, Recorded};
use ilon::{Causes, Scenario};

/// 11.36 kg: 10 kg of chassis, four hubs of 0.25 kg and 36 rollers of 10 g.
const WEIGHT_N: f64 = 11.36 * 9.81;

struct Told {
    run: Run,
    /// The sentences of the answer.
    lines: Vec<String>,
}

impl Told {
    /// Runs mecanum4 with a changed description and further lines of TOML.
    fn of(description: impl Fn(String) -> String, text: &str) -> Self {
        let shipped =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/mecanum4.toml");
        let shipped = std::fs::read_to_string(shipped).expect("a shipped robot");
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("r.toml"), description(shipped)).expect("its robot");
        let text = format!("[robot]\nfile = 'r.toml'\nroller_bodies = 'near'\n{text}");
        let scenario = Scenario::from_toml(&text, "story", folder.path()).expect("a scenario");
        let simulation = Simulation::new(&scenario).expect("it stands");
        let run = simulation.explaining(Causes::Named).run();
        let recorded = Recorded::Memory(run.trace.clone());
        let lines = ilon::report::answer(&recorded, &run.summary).expect("rows in memory");
        Self { run, lines }
    }

    fn shipped(text: &str) -> Self {
        Self::of(|shipped| shipped, text)
    }

    fn rows(&self) -> &[Record] {
        self.run.trace.records()
    }

    fn at(&self, t_s: f64) -> &Record {
        let near = |a: &&Record, b: &&Record| (a.t_s - t_s).abs().total_cmp(&(b.t_s - t_s).abs());
        self.rows().iter().min_by(near).expect("rows")
    }

    /// The sentence with these words.
    fn line(&self, words: &str) -> &str {
        let found = self.lines.iter().find(|line| line.contains(words));
        found.unwrap_or_else(|| panic!("no `{words}` in {:#?}", self.lines))
    }

    fn says(&self, words: &str) -> bool {
        self.lines.iter().any(|line| line.contains(words))
    }

    /// The mean of a value over the rows between two times.
    fn mean(&self, from_s: f64, until_s: f64, of: impl Fn(&Record) -> f64) -> f64 {
        let rows = self
            .rows()
            .iter()
            .filter(|r| r.t_s > from_s && r.t_s <= until_s);
        let values: Vec<f64> = rows.map(of).collect();
        values.iter().sum::<f64>() / values.len() as f64
    }
}

/// The number before a unit, after given words.
fn number(line: &str, before: &str, unit: &str) -> f64 {
    let rest = line
        .split(before)
        .nth(1)
        .unwrap_or_else(|| panic!("no `{before}` in {line}"));
    let text = rest.split(unit).next().expect("a part");
    text.trim()
        .parse()
        .unwrap_or_else(|_| panic!("`{text}` in {line}"))
}

/// A length after given words: in mm or m.
fn length_m(line: &str, after: &str) -> f64 {
    let Some(before) = line.split(after).next().filter(|_| line.contains(after)) else {
        return 0.0;
    };
    let mut words = before.split_whitespace().rev();
    let (unit, number) = (words.next(), words.next());
    let number: f64 = number
        .and_then(|n| n.parse().ok())
        .unwrap_or_else(|| panic!("{line}"));
    number * if unit == Some("mm") { 1e-3 } else { 1.0 }
}

/// Ahead at 0.2 m/s for 2.5 s, on motors with a torque line.
const AHEAD: &str = "[twist]\nvx_m_s = 0.2\nrest_s = 0\nramp_s = 0.2\nsettle_s = 0.2\n[run]\nduration_s = 2.5\n\
                     [motors.dc]\nstall_torque_n_m = 1.5\nno_load_rate_rad_s = 8\n";

/// Every kind of fault from 1 s to 1.5 s: its sentence has the scenario's numbers, and its reported
/// effect is the difference from a run without it.
#[test]
fn every_fault_is_told_with_its_time_its_size_and_what_it_did() {
    let window = "from_s = 1, until_s = 1.5";
    let one = |kind: &str, keys: &str| format!("[[faults]]\n{kind} = {{ {keys}{window} }}\n");
    let faults = [
        (
            one("motor_lost", "wheel = 'front_left', "),
            "he lost motor of front_left from 1.00 to 1.50 s",
        ),
        (
            one("encoder_lost", "wheel = 'rear_left', "),
            "he lost encoder of rear_left from 1.00 to 1.50 s",
        ),
        (
            one("encoder_scaled", "wheel = 'rear_left', factor = 0.5, "),
            "he encoder of rear_left that reads 0.5 times the rate from 1.00 to 1.50 s",
        ),
        (
            one("pose_lost", ""),
            "he lost pose sensor from 1.00 to 1.50 s",
        ),
        (
            one("pose_shifted", "x_m = 0.03, y_m = 0.04, heading_deg = 5, "),
            "he pose sensor with an offset of 50.0 mm and 5.00° from 1.00 to 1.50 s",
        ),
        (
            one("battery_sag", "share = 0.3, "),
            "he battery at 30 % of its voltage from 1.00 to 1.50 s",
        ),
        (
            "[[faults]]\npush = { impulse_y_n_s = 20, from_s = 1 }\n".to_owned(),
            "he push of 20 N s at 1.00 s",
        ),
        (
            one("payload", "mass_kg = 2.84, "),
            "he payload of 2.84 kg from 1.00 to 1.50 s",
        ),
        (
            one("roller_stuck", "wheel = 'front_right', roller = 3, "),
            "he stuck roller 3 of front_right from 1.00 to 1.50 s",
        ),
        (
            one("friction_changed", "friction = 0.02, "),
            "he floor's change of friction to 0.02 from 1.00 to 1.50 s",
        ),
    ];
    let end = |told: &Told| told.rows().last().expect("rows").truth.pose;
    let without = end(&Told::shipped(AHEAD));
    for (fault, words) in faults {
        let told = Told::shipped(&format!("{AHEAD}{fault}"));
        let line = told.line(words);
        let with = end(&told);
        let (sin, cos) = without.heading_rad.sin_cos();
        let off_m = with.position_m() - without.position_m();
        let did = [cos * off_m.x + sin * off_m.y, cos * off_m.y - sin * off_m.x];
        let places = line.split("turned it").next().unwrap_or(line);
        let places = places.split("; ").last().unwrap_or(places);
        let said = [
            length_m(places, " ahead") - length_m(places, " back"),
            length_m(places, " to the left") - length_m(places, " to the right"),
        ];
        // Half of the last printed digit, which is that of the resolution; three times the
        // resolution for what is not printed.
        let apart = told.run.summary.effects.get("faults.0", "apart_m");
        let least_m = 3.0 * apart.expect("it was left out").floor;
        for (said_m, did_m) in said.iter().zip(did) {
            assert!(
                (said_m - did_m).abs() <= least_m,
                "{line}: {did_m} m, known to {least_m} m"
            );
        }
    }
}

/// In closed loop the distance from the reference counts.
#[test]
fn a_fault_in_closed_loop_says_what_the_position_error_would_have_been() {
    let line =
        "[reference.line]\nto_x_m = 1\nto_y_m = 0\nspeed_m_s = 0.2\n[run]\nduration_s = 2.5\n";
    let slippery =
        "[[faults]]\nfriction_changed = { friction = 0.4, from_s = 0.3, until_s = 0.4 }\n";
    let shifted = "[[faults]]\npose_shifted = { y_m = 0.05, from_s = 1, until_s = 1.5 }\n";
    let told = Told::shipped(&format!("{line}{slippery}{shifted}"));
    let without = Told::shipped(&format!("{line}{slippery}"));
    let would_m = without
        .run
        .summary
        .position_error_max_m
        .expect("a reference");
    let said = told.line("Without the pose sensor with an offset of 50.0 mm");
    let said_mm = number(said, "would have been ", "mm");
    // Half of the second decimal.
    assert!(
        (said_mm - 1e3 * would_m).abs() < 6e-3,
        "{said}: {would_m} m"
    );
    assert!(
        told.says("The floor's change of friction to 0.4 from 0.30 to 0.40 s"),
        "{:#?}",
        told.lines
    );
}

fn low(center_z_m: f64) -> impl Fn(String) -> String {
    move |shipped| {
        let lower = format!("center_m = [0.0, 0.0, {center_z_m}]");
        let changed = shipped.replace("center_m = [0.0, 0.0, 0.06]", &lower);
        assert_ne!(changed, shipped);
        changed
    }
}

const SHORT: &str =
    "[twist]\nvx_m_s = 0.3\nrest_s = 0.2\nramp_s = 0.2\nsettle_s = 0.2\n[run]\nduration_s = 1.5\n";

/// Treads that sag more than the clearance of a box above the floor. A box that touches it at rest
/// is refused earlier.
#[test]
fn a_robot_on_its_chassis_is_told_before_all_else_and_without_shares_of_slip() {
    let tread = "[rollers.tread]\nstiffness_n_m = 5e4\n";
    for (center_z_m, more) in [(0.0501, tread), (0.0502, tread)] {
        let told = Told::of(low(center_z_m), &format!("{SHORT}{more}"));
        let line = told.lines.first().expect("an answer");
        assert!(
            line.contains("the robot stood on its chassis: the wheels carried"),
            "{:#?}",
            told.lines
        );
        let load = |of: fn(&ilon::trace::Support) -> f64| {
            told.mean(0.0, 1.5, |r| of(&r.support.expect("it is recorded")))
        };
        let (wheels_n, chassis_n) = (load(|s| s.wheels_n), load(|s| s.chassis_n));
        assert!(
            (number(line, "the wheels carried", "N") - wheels_n).abs() < 0.1,
            "{line}: {wheels_n} N"
        );
        assert!(
            (number(line, "and the chassis", "N") - chassis_n).abs() < 0.1,
            "{line}: {chassis_n} N"
        );
        // Together they carry the robot, which has no vertical motion: within the settling.
        assert!(
            ((wheels_n + chassis_n) / WEIGHT_N - 1.0).abs() < 0.01,
            "{wheels_n} + {chassis_n} N"
        );
        let share = told.run.summary.chassis_load_share.expect("it stands");
        assert!(
            (share - chassis_n / (wheels_n + chassis_n)).abs() < 1e-3,
            "{share}"
        );
        // The command is compared with the motion, and nothing is attributed to slip.
        assert!(
            told.says("Ahead the command was 0.3000 m/s, and it reached "),
            "{:#?}",
            told.lines
        );
        assert!(
            !told.says("slip takes") && !told.says("slid"),
            "{:#?}",
            told.lines
        );
    }
    let free = Told::of(low(0.0502), SHORT);
    assert!(!free.says("chassis"), "{:#?}", free.lines);
    assert_eq!(free.run.summary.chassis_load_share, Some(0.0));
    assert!(free.says("by the ideal kinematics"), "{:#?}", free.lines);
}

/// A standing robot's whole weight is on its wheels, and equals their normal forces.
#[test]
fn a_robot_on_its_wheels_has_all_its_weight_on_them() {
    let told = Told::shipped(SHORT);
    let carried_n = told.mean(0.5, 1.5, |r| r.support.expect("it is recorded").wheels_n);
    assert!((carried_n / WEIGHT_N - 1.0).abs() < 2e-3, "{carried_n} N");
    let free = ["chassis", "tipped", "in the air", "fell", "against"];
    assert!(
        !free.iter().any(|word| told.says(word)),
        "{:#?}",
        told.lines
    );
}

#[test]
fn a_robot_that_tips_is_told_as_one_and_by_what() {
    let high = |shipped: String| {
        let box_m = "shape.box = { size_m = [0.3, 0.24, 0.06] }";
        let changed = shipped.replace("shape.box = { size_m = [0.40, 0.24, 0.10] }", box_m);
        low(0.1)(changed)
    };
    let payload = "[twist]\nvx_m_s = 0.1\nrest_s = 0.2\nramp_s = 0.2\nsettle_s = 0.2\n[run]\nduration_s = 2.5\n\
                   [[faults]]\npayload = { mass_kg = 20, x_m = 0.4, y_m = 0, z_m = 0.1, from_s = 0.5 }\n";
    let push = "[twist]\n[world.floor]\nfriction = 1.5\n[run]\nduration_s = 2.5\n\
                [[faults]]\npush = { impulse_y_n_s = 40, z_m = 0.3, from_s = 0.5, lasts_s = 0.05 }\n";
    for (told, cause, onto) in [
        (
            Told::of(high, payload),
            "Without the payload of 20 kg from 0.50 s on the robot would not have tipped over",
            "on its nose",
        ),
        (
            Told::shipped(push),
            "Without the push of 40 N s at 0.50 s the robot would not have tipped over",
            "",
        ),
    ] {
        let first = told.lines.first().expect("an answer");
        assert!(
            first.contains("the robot lay tipped over on "),
            "{:#?}",
            told.lines
        );
        let lean_deg = |r: &Record| {
            let upright = r.truth.roll_rad.cos() * r.truth.pitch_rad.cos();
            upright.acos().to_degrees()
        };
        let tipped = told
            .rows()
            .iter()
            .find(|r| lean_deg(r) > 45.0)
            .expect("it tips");
        let most_deg = told.rows().iter().map(lean_deg).fold(0.0, f64::max);
        assert!(
            (number(first, "it leaned by up to", "°") - most_deg).abs() < 0.01,
            "{first}"
        );
        told.line(cause);
        assert!(first.contains(onto), "{first}");
        assert!(tipped.t_s > 0.5, "{} s", tipped.t_s);
        assert!(
            !told.says("ideal kinematics") && !told.says("No wheel slid"),
            "{:#?}",
            told.lines
        );
    }
}

/// 40 N s upwards lift 11.36 kg off at (40 - 0.1 m g) / m and so on: the height is the trace's.
#[test]
fn a_jump_is_told_with_its_height_and_its_landing() {
    let told = Told::shipped(
        "[twist]\nvx_m_s = 0.1\nrest_s = 0\nramp_s = 0.1\nsettle_s = 0.1\n[run]\nduration_s = 3\n\
         [[faults]]\npush = { impulse_z_n_s = 30, from_s = 0.5, lasts_s = 0.1 }\n",
    );
    let first = told.lines.first().expect("an answer");
    assert!(
        first.contains("the robot was in the air, up to "),
        "{:#?}",
        told.lines
    );
    let rest_m = told.at(0.4).truth.height_m;
    let most_m = told
        .rows()
        .iter()
        .map(|r| r.truth.height_m)
        .fold(0.0, f64::max)
        - rest_m;
    let said_m = length_m(first, " above where");
    // It leaves the ground slightly before the row that shows it.
    assert!(
        most_m > 0.1 && (said_m - most_m).abs() < 0.03,
        "{first}: {most_m} m"
    );
    let hits_j = told.rows().last().expect("rows").impact_energy_j;
    assert!(
        (number(first, "the landing took", "J") - hits_j).abs() < 0.05 * hits_j,
        "{first}: {hits_j} J"
    );
    told.line("Without the push of 30 N s at 0.50 s the robot would not have left the ground");
}

#[test]
fn a_robot_that_drives_off_the_ground_fell() {
    let told = Told::shipped(
        "[twist]\nvx_m_s = 0.8\nrest_s = 0\nramp_s = 0.3\nsettle_s = 0.1\n[run]\nduration_s = 2\n\
         [world.floor.rough]\ncell_m = 0.05\nheight_m = 0.001\nside_m = 1.0\n",
    );
    let first = told.lines.first().expect("an answer");
    assert!(
        first.contains("the robot fell off the ground: "),
        "{:#?}",
        told.lines
    );
    let last = told.run.trace.wheels_at(told.rows().len() - 1);
    let hub_m = last
        .iter()
        .map(|wheel| wheel.hub_height_m)
        .fold(f64::NEG_INFINITY, f64::max);
    assert!(
        (length_m(first, " below the floor") + hub_m).abs() < 1e-3,
        "{first}: {hub_m} m"
    );
    assert!(
        !told.says("ideal kinematics") && !told.says("slip"),
        "{:#?}",
        told.lines
    );
}

/// A wall is higher than a wheel's radius; a kerb is lower, but too high for these motors. The
/// chassis protrudes beyond the wheels: flush with them it would share the wall with their rollers
/// in an indeterminate way.
#[test]
fn a_robot_at_a_wall_or_a_kerb_is_told_to_stand_there_and_not_to_cross_it() {
    let longer = |shipped: String| shipped.replace("size_m = [0.40,", "size_m = [0.42,");
    for (height_m, words) in [
        (
            0.3,
            "the robot stood against a wall, a box 300.0 mm high: of ",
        ),
        (
            0.03,
            "the robot was caught at a kerb, a box 30.00 mm high: of ",
        ),
    ] {
        let text = format!(
            "[twist]\nvx_m_s = 0.3\nrest_s = 0\nramp_s = 0.2\nsettle_s = 1\n[run]\nduration_s = 2.5\n\
             [motors.dc]\nstall_torque_n_m = 0.2\nno_load_rate_rad_s = 20\n\
             [[world.floor.boxes]]\nx_m = 0.8\ny_m = 0\nlength_x_m = 0.8\nlength_y_m = 2\nheight_m = {height_m}\n"
        );
        let told = Told::of(longer, &text);
        let line = told.line(words);
        assert!(line.contains("300 mm/s commanded it reached "), "{line}");
        let from_s = number(line, "From", "s to the end");
        let held_n = told.mean(from_s, 2.5, |r| {
            -r.support.expect("it is recorded").obstacles_x_n
        });
        assert!(
            (number(line, "held back by", "N") - held_n).abs() < 0.1 + 0.01 * held_n,
            "{line}: {held_n} N"
        );
        assert!(held_n > 1.0, "{held_n} N");
        // At rest, the wall's force equals the friction that pushes the robot against it: the sum
        // of the wheels' columns, within the remaining oscillation.
        let rests_n = told.mean(2.0, 2.5, |r| {
            -r.support.expect("it is recorded").obstacles_x_n
        });
        let rows = told.run.trace.steps().filter(|(r, _)| r.t_s > 2.0);
        let pushes: Vec<f64> = rows
            .map(|(_, wheels)| wheels.iter().map(|wheel| wheel.force_x_n).sum())
            .collect();
        let pushes_n = pushes.iter().sum::<f64>() / pushes.len() as f64;
        assert!(
            (rests_n / pushes_n - 1.0).abs() < 0.03,
            "{rests_n} N, {pushes_n} N"
        );
        assert!(!told.says("cross a box"), "{:#?}", told.lines);
        assert!(
            told.says("Ahead the command was 0.3000 m/s, and it reached"),
            "{:#?}",
            told.lines
        );
    }
}

/// 0.01 N m (1 - w / 4) against the bearings' 0.001 N m s end far below the 10 rad/s that 0.5 m/s
/// need.
#[test]
fn motors_that_cannot_are_told_against_what_was_asked() {
    let told = Told::shipped(
        "[twist]\nvx_m_s = 0.5\nrest_s = 0\nramp_s = 0.2\nsettle_s = 1\n[run]\nduration_s = 2.5\n\
         [motors.dc]\nstall_torque_n_m = 0.01\nno_load_rate_rad_s = 4\n",
    );
    let line = told.line("Ahead the command was 0.5000 m/s, the wheel speeds give ");
    let mean = told.run.summary.twist_mean.expect("a window").vx_m_s;
    assert!(
        (number(line, "it reached", "m/s") - mean).abs() < 1e-4,
        "{line}: {mean} m/s"
    );
    let share = 100.0 * mean / 0.5;
    assert!(
        line.contains(&format!(
            " {share:.1} % of the command. The motors' limit takes "
        )),
        "{line}"
    );
    // The commanded mean comes from sums over the window: a thousand roundings.
    let ratio = told.run.summary.twist_ratio_asked.vx.expect("it was asked");
    assert!((ratio - mean / 0.5).abs() < 1e-12, "{ratio}");
}

/// Gain times period 1.8 with loops that follow slowly: the warning before the run, and the first
/// sentence after it.
#[test]
fn an_unstable_guidance_is_told_first_and_warned_of() {
    let text = |gain: f64| {
        format!(
            "y_m = 0.2\nheading_deg = 20\n[reference.hold_pose]\nx_m = 0.3\ny_m = 0\nheading_deg = 0\n\
             [guidance]\nposition_gain_per_s = {gain}\n[run]\nduration_s = 3\ncontrol_dt_s = 0.01\n"
        )
    };
    let told = Told::shipped(&text(180.0));
    let first = told.lines.first().expect("an answer");
    let expected = "The guidance is unstable: the position gain times the control period is 1.800, and from 1.";
    assert!(first.starts_with(expected), "{first}");
    let warned = |told: &Told, word: &str| told.run.warnings.iter().any(|w| w.contains(word));
    assert!(
        warned(&told, "the guidance is unstable"),
        "{:?}",
        told.run.warnings
    );
    let steady = Told::shipped(&text(1.0));
    assert!(
        !steady.says("unstable") && !warned(&steady, "guidance"),
        "{:?}",
        steady.run.warnings
    );
}

/// Sliding without friction costs nothing, and no share of zero is reported.
#[test]
fn sliding_without_friction_costs_nothing() {
    let told = Told::shipped(
        "[twist]\nvx_m_s = 0.3\nrest_s = 0\nramp_s = 0.2\nsettle_s = 0.2\n[run]\nduration_s = 1\n[world.floor]\nfriction = 0\n",
    );
    assert!(told.says("which cost less than 1 mJ"), "{:#?}", told.lines);
    assert!(
        !told.says("0.000 J") && !told.says(" 0.0 %,"),
        "{:#?}",
        told.lines
    );
    assert!(!told.says("takes 0.0 %"), "{:#?}", told.lines);
}

/// Both directions are reported also beside an event.
#[test]
fn every_direction_is_told_beside_an_event() {
    let told = Told::shipped(
        "[twist]\nvx_m_s = 0.3\nvy_m_s = 0.2\nomega_rad_s = 0.2\nrest_s = 0\nramp_s = 0.2\nsettle_s = 0.2\n[run]\nduration_s = 2\n\
         [[faults]]\npayload = { mass_kg = 1, from_s = 1 }\n",
    );
    for words in [
        "Ahead ",
        "To the left ",
        "Turning left ",
        "he payload of 1 kg",
    ] {
        told.line(words);
    }
}

/// A box that is pushed along dissipates mu m g d of friction over its path, without wheel slip:
/// the answer says where the loss is. The chassis's front does not rub, as both go straight on.
#[test]
fn what_rubs_beside_the_wheels_is_told_with_its_energy() {
    const CRATE: &str = "[[world.bodies]]\nname = 'crate'\nbox = { size_m = [0.2, 0.2, 0.12] }\n\
        mass_kg = 2.0\nfriction = 0.3\nx_m = 0.5\ny_m = 0.0\n";
    let told = Told::shipped(&format!(
        "[twist]\nvx_m_s = 0.2\n[run]\nduration_s = 5\n{CRATE}"
    ));
    let x_m = |row: Option<&Record>| row.expect("rows").bodies[0].place_m[0];
    let way_m = x_m(told.rows().last()) - x_m(told.rows().first());
    assert!(way_m > 0.25, "{way_m}");
    let line = told.line("No wheel lost grip; ");
    let rubbed_j = number(line, "grip; ", " J");
    // Three digits are printed; for a moment after the first touch the pitching chassis also
    // presses on the box from above.
    let expected_j = 0.3 * 2.0 * 9.81 * way_m;
    assert!(
        (rubbed_j - expected_j).abs() < 0.01 * expected_j,
        "{line}, {expected_j}"
    );
    assert!(
        line.contains("into friction of its body and of what it pushes"),
        "{line}"
    );
    let alone = Told::shipped("[twist]\nvx_m_s = 0.2\n[run]\nduration_s = 1\n");
    assert!(!alone.says("friction of"), "{:#?}", alone.lines);
}

/// A run that ends before its mean velocities begin has no shares of the motion, but its sliding is
/// reported.
#[test]
fn a_run_too_short_for_means_tells_what_slid() {
    let told = Told::shipped(
        "[world.floor]\nfriction = 0.1\n[twist]\nvx_m_s = 0.8\nrest_s = 0.2\nramp_s = 0.1\n[run]\nduration_s = 0.5\n",
    );
    assert!(told.says("No mean velocities"), "{:#?}", told.lines);
    let cost_j = number(told.line("Sliding cost "), "Sliding cost ", " J");
    let slid_j = told.run.summary.energy.slip_j.expect("an energy balance");
    assert!((cost_j - slid_j).abs() < 0.01 * slid_j, "{cost_j} {slid_j}");
}
