//! Numbers of any size: values that cannot be computed with are refused with a message, and a
//! diverged run is no result.

use crate::support;

use ilon::Scenario;
use ilon::simulate::{Commanded, Controller, Moment, Simulation};
use ilon::trace::{Recording, TraceError};
use support::{Folder, HOLDS, ended_with};

const WAY: &str = "\
[robot]
file = \"robot.urdf\"
[reference.waypoints]
file = \"way.csv\"
[run]
duration_s = 0.5
";

#[test]
fn waypoints_are_of_a_size_to_compute_with() {
    let folder = Folder::new();
    folder.write("way.toml", WAY);
    folder.write("way.csv", "t_s,x_m,y_m\n0,0,0\n1,1e308,0\n2,-1e308,0\n");
    let told = ended_with(2, &folder.ilon(&["run", "way.toml", "--out", "out"]));
    assert!(
        told.contains("way.csv: line 3: `x_m` is \"1e308\""),
        "{told}"
    );
    assert!(!folder.path("out/summary.json").exists());
    // The largest allowed: far beyond any real robot, and still a complete result.
    folder.write("way.csv", "t_s,x_m,y_m\n0,0,0\n1,1e9,0\n2,-1e9,0\n");
    let told = ended_with(0, &folder.ilon(&["run", "way.toml", "--out", "out"]));
    assert!(!told.contains("NaN"), "{told}");
}

/// Valid commands for a while, and then a torque that is not finite.
struct Breaking {
    from_s: f64,
}

impl Controller for Breaking {
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
        wheels.fill(if now.t_s < self.from_s { 0.0 } else { f64::NAN });
        Commanded::Torques
    }
}

#[test]
fn a_run_that_diverges_ends_there_and_is_no_result() {
    let folder = Folder::new();
    let scenario = Scenario::load(folder.path("good.toml")).expect("a good scenario");
    let breaking = Breaking { from_s: 0.2 };
    let simulation = Simulation::with_controller(&scenario, breaking).expect("a good scenario");
    let recording = Recording::into_file(
        simulation.trace().header.clone(),
        folder.path("trace.parquet"),
        folder.path("trace.partial"),
    );
    let recording = recording.expect("the folder can be written to");
    let run = simulation.run_recorded(recording, |_, _| Ok::<(), TraceError>(()));
    match run {
        Err(TraceError::Diverged { t_s, value, .. }) => {
            // Recorded before it acts: the torque at once, the rest a period later at most.
            assert!((0.2 - 1e-9..0.22).contains(&t_s), "{t_s} s");
            assert!(value.is_nan());
        }
        other => panic!("it ended well: {}", other.is_ok()),
    }
    assert!(!folder.path("trace.parquet").exists());
}

#[test]
fn a_velocity_limit_that_stands_for_none_costs_no_steps() {
    let folder = Folder::new();
    let robot = folder.read("robot.urdf");
    let limits = robot.matches("velocity=\"91.6\"").count();
    assert_eq!(limits, 3, "a limit for each wheel");
    folder.write(
        "robot.urdf",
        &robot.replace("velocity=\"91.6\"", "velocity=\"1e9\""),
    );
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "out"]));
    // No requested motion needs less than a millisecond, ten of which are a control period.
    assert!(
        folder
            .read("out/scenario.toml")
            .contains("physics_dt_s = 0.001\n")
    );
    // Explicitly requested, it is refused with a message.
    let fast = ["run", "good.toml", "--set", "twist.vx_m_s=1e8"];
    let told = ended_with(2, &folder.ilon(&fast));
    assert!(
        told.contains("`run.physics_dt_s` = \"auto\" comes to"),
        "{told}"
    );
    assert!(
        told.contains("the scenario asks for wheel rates of"),
        "{told}"
    );
}

#[test]
fn poses_of_any_age_and_rate_end_no_process() {
    let folder = Folder::new();
    folder.scenario("fused.toml", &format!("[sensors.fusion]\n{HOLDS}"));
    for (settings, code) in [
        (&["sensors.pose.latency_s=1e6"][..], 2),
        (
            &["sensors.pose.rate_hz=1e9", "sensors.pose.latency_s=0.1"],
            2,
        ),
        (&["sensors.pose.rate_hz=1e9", "run.physics_dt_s=1e-3"], 2),
        (&["sensors.pose.latency_s=0.5"], 0),
        (
            &[
                "sensors.pose.rate_hz=1000",
                "run.physics_dt_s=1e-3",
                "sensors.pose.latency_s=0.4",
            ],
            0,
        ),
        (
            &[
                "sensors.pose.latency_s=5e7",
                "run.duration_s=1e8",
                "run.record_every=100000",
            ],
            2,
        ),
    ] {
        let set = settings.iter().flat_map(|setting| ["--set", setting]);
        let arguments: Vec<&str> = ["check", "fused.toml"].into_iter().chain(set).collect();
        ended_with(code, &folder.ilon(&arguments));
    }
}
