//! The shipped robots, from file to matrix.

use ilon_control::{Arrangement, Kinematics, SpeedLimits};
use ilon_formats::LoadRobot;
use ilon_robot::Robot;
use nalgebra::MatrixXx3;

/// One of the shipped robots.
pub fn shipped(name: &str) -> Robot {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/robots");
    Robot::load(format!("{folder}/{name}.urdf")).unwrap()
}

#[test]
fn eq_08_the_shipped_mecanum_robot_has_the_textbook_matrix() {
    let kinematics = Kinematics::new(&shipped("mecanum4")).unwrap();
    // Each row is (1, -+1, -+0.31)/sqrt 2 by the wheel's corner: (1, -s, -side 0.31) with s = +1
    // for front left and rear right. The order of the wheels is the file's.
    let rows: Vec<_> = kinematics
        .wheels()
        .iter()
        .map(|w| {
            let (front, left) = (w.position_m().x.signum(), w.position_m().y.signum());
            nalgebra::RowVector3::new(1.0, -front * left, -left * 0.31) / 2.0_f64.sqrt()
        })
        .collect();
    // A file's angles are rounded to about 1e-15; 1e-9 would show any real difference.
    assert!((kinematics.m() - MatrixXx3::from_rows(&rows)).norm() < 1e-9);
}

#[test]
fn section_4_the_shipped_volksbot_has_the_papers_speeds() {
    let kinematics = Kinematics::new(&shipped("volksbot")).unwrap();
    assert!(kinematics.is_decoupled());
    let limits = SpeedLimits::uniform(&kinematics, 8.7);
    assert!((limits.top_yaw_rate_rad_s().to_degrees() - 99.7).abs() < 0.05);
    let (least, largest) = limits.top_speed_range_m_s();
    assert!((least - 0.435).abs() < 1e-6 && (largest - 0.502).abs() < 5e-4);
}

#[test]
fn lemma_1_every_shipped_robot_is_omnidirectional() {
    for name in ["mecanum4", "volksbot", "mecanum6"] {
        let arrangement = Arrangement::of(&shipped(name)).unwrap();
        assert_eq!(arrangement.rank, 3, "{name}");
        // The worst of them maps 1 m/s of error in the wheels' speeds to at most 10 m/s of motion.
        assert!(
            arrangement.condition < 10.0,
            "{name}: {}",
            arrangement.condition
        );
    }
}
