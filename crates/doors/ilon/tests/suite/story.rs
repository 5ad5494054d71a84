//! The answer names the cause of the robot's deviation: a slope, and the difference from a real
//! robot that a log measured.

use crate::support;

use ilon_trace::Trace;
use support::{Folder, ended_with};

#[test]
fn a_slope_that_is_too_steep_for_the_floor_is_named_first() {
    let folder = Folder::new();
    let steep = [
        "run",
        "good.toml",
        "--out",
        "out",
        "--set",
        "world.floor.slope_deg=40",
    ];
    let said = ended_with(
        0,
        &folder.ilon(&[&steep[..], &["--set", "run.duration_s=2"]].concat()),
    );
    // atan 0.6 = 31.0 degrees.
    let sentence = "The floor falls by 40.0° towards +x, steeper than friction 0.6 can hold (31.0°): the robot slid";
    assert!(said.contains(sentence), "{said}");
    let page = folder.read("out/report.html");
    let first = page
        .split("<div class=\"story\">")
        .nth(1)
        .and_then(|rest| rest.split("</p>").next());
    assert!(
        first.is_some_and(|first| first.contains("downhill")),
        "{first:?}"
    );

    let level = ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "out"]));
    assert!(!level.contains("The floor falls"), "{level}");
}

#[test]
fn a_log_that_measured_the_real_robot_is_drawn_beside_the_simulated_one() {
    let folder = Folder::new();
    let rows: String = (0..=40)
        .map(|k| {
            let t_s = 0.05 * f64::from(k);
            // The real robot goes a tenth less far than commanded.
            format!("{t_s:.2},0.3,0,0,{:.4},0,0\n", 0.27 * t_s)
        })
        .collect();
    let header = "t_s,vx_m_s,vy_m_s,omega_rad_s,measured_x_m,measured_y_m,measured_heading_deg\n";
    folder.write("log.csv", &format!("{header}{rows}"));
    folder.write(
        "played.toml",
        "[robot]\nfile = \"robot.urdf\"\n[playback]\nfile = \"log.csv\"\ndrives = \"twist\"\n[run]\nduration_s = 2\n",
    );
    let said = ended_with(0, &folder.ilon(&["run", "played.toml", "--out", "out"]));
    let trace = Trace::read_parquet(&folder.path("out/trace.parquet")).expect("a trace");
    let apart = trace.records().iter().filter_map(|record| {
        let measured = record.measured?;
        Some((record.truth.pose.position_m() - measured.position_m()).norm())
    });
    let largest_m = apart.fold(0.0, f64::max);
    assert!(largest_m > 0.02, "{largest_m}");
    let sentence = format!(
        "The simulated robot is up to {:.2} mm from where the log measured the real one",
        1e3 * largest_m
    );
    assert!(said.contains(&sentence), "{sentence} in {said}");
    let page = folder.read("out/report.html");
    for part in [
        "data-figure=\"measured-distance\"",
        "data-figure=\"measured-turn\"",
        "measured, by the log",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

/// The file of a robot gives the motor in front on the right a tenth of the others' torque. While it
/// starts the robot turns towards that wheel, and then goes straight on: its means are as commanded,
/// and its end is not. A run that starts gently has nothing to say of it.
#[test]
fn a_robot_that_veers_while_it_starts_is_said_to_have_ended_elsewhere() {
    let folder = Folder::new();
    let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
    let joint = urdf.find("<joint name=\"front_right\"").expect("the joint");
    let (before, after) = urdf.split_at(joint);
    let weak = after.replacen("effort=\"1.8\"", "effort=\"0.18\"", 1);
    folder.write("weak.urdf", &format!("{before}{weak}"));
    let said = |ramp_s: f64| {
        let text = format!(
            "robot.file = \"weak.urdf\"\ntwist = {{ vx_m_s = 0.6, ramp_s = {ramp_s} }}\nrun.duration_s = 4\n"
        );
        folder.write("veers.toml", &text);
        let said = ended_with(0, &folder.ilon(&["run", "veers.toml", "--out", "out"]));
        let trace = Trace::read_parquet(&folder.path("out/trace.parquet")).expect("a trace");
        let end = trace.records().last().expect("rows").truth.pose;
        (said, end)
    };
    let (hard, end) = said(0.2);
    let sentence = format!(
        "it had turned by {:.3}° to the right of it",
        -end.heading_rad.to_degrees()
    );
    assert!(end.heading_rad < -0.008 && end.y_m < -0.01, "{end:?}");
    assert!(hard.contains(&sentence), "{sentence}: {hard}");
    assert!(hard.contains("100.0 %"), "{hard}");
    let (gentle, _) = said(2.0);
    assert!(!gentle.contains("where the command leads"), "{gentle}");
}
