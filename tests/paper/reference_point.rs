//! The decoupling point as the guidance's reference point, on an asymmetric base.

use ilon::Scenario;
use ilon::scenario::ReferencePoint;
use ilon::simulate::Simulation;
use ilon_control::Kinematics;

use crate::position_errors_m;
use crate::robots::shipped;

#[test]
fn section_3_the_decoupling_point_follows_the_reference_of_an_asymmetric_robot() {
    // Robot A with its front axle 6 cm further ahead.
    let mut robot = shipped("mecanum4");
    for wheel in &mut robot.wheels {
        if wheel.position_m().x > 0.0 {
            wheel.body_from_hub.translation.vector.x += 0.06;
        }
    }
    let kinematics = Kinematics::new(&robot).unwrap();
    let d = kinematics.decoupling_point_m();
    assert!(d.norm() > 0.02 && !kinematics.is_decoupled(), "{d:?}");
    assert!(kinematics.about(d).unwrap().is_decoupled());

    let scenarios = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenarios");
    let mut scenario = Scenario::load(format!("{scenarios}/mecanum4_circle.toml")).unwrap();
    scenario.guidance.reference_point = ReferencePoint::Decoupling;
    scenario.robot.roller_bodies = ilon::scenario::RollerBodies::Near;
    // The origin begins where the reference does: the other point is off by the arm, and arrives
    // within seconds.
    (scenario.robot.x_m, scenario.robot.heading_deg) = (1.0, 0.0);
    scenario.run.duration_s = 10.0;
    scenario.run.physics_dt_s = ilon::scenario::Step::Seconds(0.002);
    let run = Simulation::with_robot(&scenario, &robot).unwrap().run();
    assert_eq!(run.trace.header.reference_point_m, <[f64; 2]>::from(d));
    let last = run.trace.records().last().unwrap();
    let desired = last.desired.unwrap().pose.position_m();
    let errors_m = position_errors_m(&run.trace);
    let off_m = errors_m.last().unwrap();
    // The point tracks the reference; the origin is off by the arm between them.
    println!("reference point off by {:.2} mm", 1e3 * off_m);
    assert!(*off_m < 5e-3, "{off_m}");
    let origin_m = (desired - last.truth.pose.position_m()).norm();
    assert!(
        (origin_m - d.norm()).abs() < 2.0 * off_m,
        "{origin_m} {d:?}"
    );
    // The recorded command is that of the origin: it fits the targets.
    let (told, made) = (last.granted_twist_in_body, last.twist_target_ideal);
    let off = told - made;
    assert!(off.linear_m_s().norm() < 1e-12 && off.omega_rad_s.abs() < 1e-12);
}
