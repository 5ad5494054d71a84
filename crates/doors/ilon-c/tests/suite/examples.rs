//! The examples in C and C++ build, run, and give the same results as the plant.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use ilon_sim::robot::Twist;
use ilon_sim::{Plant, Scenario, WheelCommand};

use crate::support::{library, root, scenario};

/// Builds an example; prints a line and returns `None` without such a compiler.
fn build(compiler: &str, source: &str, flags: &[&str], folder: &Path) -> Option<PathBuf> {
    let source = root().join("crates/doors/ilon-c/examples").join(source);
    build_file(compiler, &source, flags, folder)
}

/// Like [`build`], for any file.
pub fn build_file(compiler: &str, source: &Path, flags: &[&str], folder: &Path) -> Option<PathBuf> {
    let program = folder.join("program.run");
    let (examples, library) = (root().join("crates/doors/ilon-c"), library());
    let library = library.parent().unwrap();
    let built = Command::new(compiler)
        .args(["-O1", "-g", "-Wall", "-Wextra", "-Werror"])
        .args(flags)
        .arg(format!("-I{}", examples.join("include").display()))
        .arg(source)
        .arg(format!("-L{}", library.display()))
        .arg(format!("-Wl,-rpath,{}", library.display()))
        .args(["-lilon_c", "-lm", "-pthread", "-o"])
        .arg(&program)
        .output();
    match built {
        Err(_) => {
            println!("skipped: there is no {compiler}");
            None
        }
        Ok(built) => {
            assert!(
                built.status.success(),
                "{}",
                String::from_utf8_lossy(&built.stderr)
            );
            Some(program)
        }
    }
}

/// A built program, which finds the library of this build: Cargo's search path may lead to an older
/// one.
pub fn example(program: PathBuf) -> Command {
    let mut command = Command::new(program);
    command.env_remove("LD_LIBRARY_PATH");
    command
}

fn numbers(output: &Output) -> Vec<Vec<u64>> {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let bits = |number: &str| number.parse::<f64>().unwrap().to_bits();
    text.lines()
        .map(|line| line.split(' ').map(bits).collect())
        .collect()
}

fn plant() -> Plant {
    Plant::of_scenario(&Scenario::load(scenario("mecanum4_lateral.toml")).unwrap()).unwrap()
}

fn rates_for(plant: &Plant, twist: Twist) -> [f64; 4] {
    let mut rates = [0.0; 4];
    plant.kinematics().wheel_rates(twist, &mut rates);
    rates
}

/// The same as `drive.c`, in Rust.
fn driven_in_rust() -> Vec<Vec<u64>> {
    let mut plant = plant();
    let rates = rates_for(&plant, Twist::new(0.0, 0.3, 0.0));
    let period_s = plant.resolved().control_dt_s();
    (0..50)
        .map(|period| {
            let pose = plant.truth().pose;
            let force_n = [-4.0 * pose.x_m, -4.0 * pose.y_m, 0.0];
            let moment_n_m = [0.0, 0.0, -0.5 * pose.heading_rad];
            plant.set_wrench(force_n, moment_n_m, None).unwrap();
            let mass_kg = 0.02 * f64::from(period);
            plant.carry_at(mass_kg, Some([0.1, 0.0, 0.1])).unwrap();
            plant
                .advance(WheelCommand::Rates(&rates), period_s)
                .unwrap();
            let truth = plant.truth();
            let (pose, twist) = (truth.pose, truth.twist_in_body);
            let row = [
                plant.time_s(),
                pose.x_m,
                pose.y_m,
                pose.heading_rad,
                twist.vx_m_s,
                twist.vy_m_s,
                twist.omega_rad_s,
            ];
            row.map(f64::to_bits).to_vec()
        })
        .collect()
}

#[test]
fn the_example_in_c_comes_to_what_the_plant_does_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = build("cc", "drive.c", &["-std=c99", "-pedantic"], folder.path()) else {
        return;
    };
    let output = example(program)
        .arg(scenario("mecanum4_lateral.toml"))
        .output()
        .unwrap();
    let rows = numbers(&output);
    let wanted = driven_in_rust();
    assert_eq!(rows.len(), 2 * wanted.len());
    assert_eq!(rows[..50], wanted);
    assert_eq!(rows[50..], wanted, "from the snapshot on it is the same");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("front_left") && said.contains("freed twice"),
        "{said}"
    );
}

#[test]
fn the_example_in_cpp_drives_two_robots_on_two_threads() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = build("c++", "drive.cpp", &["-std=c++17"], folder.path()) else {
        return;
    };
    let output = example(program)
        .arg(scenario("mecanum4_lateral.toml"))
        .output()
        .unwrap();
    let wanted = [Twist::new(0.3, 0.0, 0.0), Twist::new(0.0, 0.3, 0.0)].map(|twist| {
        let mut plant = plant();
        let rates = rates_for(&plant, twist);
        let period_s = plant.resolved().control_dt_s();
        while plant.time_s() < 1.0 - 0.5 * period_s {
            plant
                .advance(WheelCommand::Rates(&rates), period_s)
                .unwrap();
        }
        let pose = plant.truth().pose;
        [pose.x_m, pose.y_m, pose.heading_rad]
            .map(f64::to_bits)
            .to_vec()
    });
    assert_eq!(numbers(&output), wanted);
}

/// The compiler's address sanitizer watches every allocation of both sides.
#[test]
fn the_example_in_c_is_clean_under_the_address_sanitizer() {
    let folder = tempfile::tempdir().unwrap();
    let probe = folder.path().join("probe");
    let has = Command::new("cc")
        .args(["-fsanitize=address", "-x", "c", "-", "-o"])
        .arg(&probe)
        .stdin(std::fs::File::open(root().join("crates/doors/ilon-c/tests/empty.c")).unwrap())
        .output()
        .is_ok_and(|built| built.status.success());
    if !has || !Command::new(&probe).status().is_ok_and(|ran| ran.success()) {
        println!("skipped: cc has no address sanitizer");
        return;
    }
    let flags = ["-std=c99", "-fsanitize=address"];
    let program = build("cc", "drive.c", &flags, folder.path()).expect("there is cc");
    let output = example(program)
        .arg(scenario("mecanum4_lateral.toml"))
        .output()
        .unwrap();
    assert_eq!(numbers(&output)[..50], driven_in_rust());
}

/// Valgrind takes a minute in this profile, so it runs only if `ILON_VALGRIND` is set. The test
/// requires that no access is invalid and no memory is lost; results are not compared, as its
/// emulation may round differently.
#[test]
fn the_example_in_c_is_clean_under_valgrind() {
    let Some(valgrind) = std::env::var_os("ILON_VALGRIND") else {
        println!("skipped: name valgrind in ILON_VALGRIND to run it");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = build("cc", "drive.c", &["-std=c99"], folder.path()) else {
        return;
    };
    let output = Command::new(valgrind)
        .args([
            "-q",
            "--error-exitcode=9",
            "--leak-check=full",
            "--errors-for-leak-kinds=definite",
            // Compilers may branch on uninitialised values if both branches agree; memcheck reports
            // that also for Rust without `unsafe`.
            "--undef-value-errors=no",
        ])
        .arg(program)
        .arg(scenario("mecanum4_lateral.toml"))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
