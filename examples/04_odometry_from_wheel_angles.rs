//! Dead reckoning with the rollers in contact on a real robot: it needs the robot's description and
//! its wheel angles. Here the angles of a simulated run stand in for the encoders.

use ilon::control::{ContactKinematics, Odometry};
use ilon::formats::LoadRobot;
use ilon::robot::Robot;

fn main() -> Result<(), ilon::Error> {
    let scenario = ilon::Scenario::load("assets/scenarios/mecanum4_6_rollers_lateral.toml")?;
    let run = ilon::run(&scenario)?;

    // On the robot: once, ...
    let robot = Robot::load("assets/robots/mecanum4_6_rollers.urdf")?;
    let start = run.trace.records()[0].truth.pose;
    let mut odometry = Odometry::new(ContactKinematics::new(&robot)?, start, &[0.0; 4]);
    // ... and whenever the encoders are read.
    for (_, wheels) in run.trace.steps() {
        let angles_rad: Vec<f64> = wheels.iter().map(|wheel| wheel.angle_rad).collect();
        odometry.update(&angles_rad);
    }

    let last = run.trace.records().last().expect("a run has records");
    let off_mm =
        |pose: ilon::robot::Pose| 1e3 * (pose.position_m() - last.truth.pose.position_m()).norm();
    let (ideal_mm, contact_mm) = (off_mm(last.odometry_ideal), off_mm(odometry.pose()));
    println!(
        "after {:.2} m sideways on six rollers a wheel",
        run.summary.travelled_m
    );
    println!("dead reckoning by equation (7) is {ideal_mm:.1} mm off");
    println!("dead reckoning by the rollers that touch is {contact_mm:.1} mm off");
    assert!(ideal_mm > 50.0 && contact_mm < 1.0);
    Ok(())
}
