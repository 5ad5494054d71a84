//! Ground to drive over.

use ilon_sim::Scenario;
use ilon_sim::simulate::Simulation;

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/robots");

fn last(keys: &str) -> ilon_sim::trace::Truth {
    let text = format!(
        "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n[run]\nduration_s = 3\nphysics_dt_s = 0.001\n{keys}"
    );
    let scenario = Scenario::from_toml(&text, "ground", ROBOTS).unwrap();
    let run = Simulation::new(&scenario).unwrap().run();
    run.trace.records().last().unwrap().truth
}

/// A robot on a ramp leans as the ramp does, and is as high above it as it is above level ground.
#[test]
fn a_robot_drives_up_a_ramp() {
    let ramp = "[twist]\nvx_m_s = 0.3\n[[world.floor.ramps]]\nx_m = 0.3\ny_m = 0\nlength_m = 2\nwidth_m = 1\nrise_m = 0.1\n";
    let level = last("[twist]\nvx_m_s = 0.3\n");
    let up = last(ramp);
    let slope_rad = f64::atan2(0.1, 2.0);
    // Rollers hand over: at each wheel the hub goes up and down by some tenths of a millimetre, over a base of 0.3 m.
    assert!((up.pitch_rad + slope_rad).abs() < 2e-3, "{}", up.pitch_rad);
    let above_m = up.height_m * slope_rad.cos() - (up.pose.x_m - 0.3) * slope_rad.sin();
    println!("{above_m} {}", level.height_m);
    // The body's origin lies in the ground's plane.
    assert!((above_m - level.height_m).abs() < 5e-4, "{above_m}");
    // The rear wheels have passed its foot.
    assert!(up.pose.x_m > 0.46, "{}", up.pose.x_m);
}

/// Ground of a class carries a robot that drives, no higher than its waves are.
#[test]
fn a_robot_drives_over_ground_of_a_class_of_roughness() {
    let truth = last(
        "[twist]\nvx_m_s = 0.3\n[world.floor.rough]\niso_8608 = 'A'\ncell_m = 0.02\nside_m = 4\nseed = 2\n",
    );
    // Four deviations of sqrt(pi / 2 G n_0^2 L) with L = 5.12 m: 1.1 mm.
    assert!(truth.height_m.abs() < 4.5e-3, "{}", truth.height_m);
    assert!(truth.height_m.abs() > 1e-5, "{}", truth.height_m);
    assert!(truth.pose.x_m > 0.4, "{}", truth.pose.x_m);
}
