//! Every URDF and xacro file of a folder named by `ILON_ROBOTS`: each must load, or be refused in words that say where and how to
//! mend it; the same with what can be mended mended, and with rollers put into wheels that have none.
//! `ILON_ROBOTS=~/urdf cargo test -p ilon-robot --test collection -- --nocapture` prints what was made of them.

mod common;

use std::path::{Path, PathBuf};

use ilon_robot::{Fault, Handedness, LoadOptions, Loaded, Robot, WheelOptions};

fn urdf_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            urdf_files(&path, found);
        } else if path
            .extension()
            .is_some_and(|e| e == "urdf" || e == "xacro")
        {
            found.push(path);
        }
    }
}

#[test]
fn every_robot_of_the_folder_loads_or_is_refused_in_clear_words() {
    let Some(folder) = std::env::var_os("ILON_ROBOTS") else {
        return;
    };
    let mut files = Vec::new();
    urdf_files(Path::new(&folder), &mut files);
    files.sort();
    assert!(!files.is_empty(), "no .urdf below {}", folder.display());
    for file in files {
        println!("\n{}", file.display());
        let mut options = LoadOptions::default();
        let mut loaded = Robot::load_with(&file, &options);
        report(&loaded);
        if loaded.is_err() {
            println!("  mended:");
            options.mend = true;
            loaded = Robot::load_with(&file, &options);
            report(&loaded);
        }
        let rollerless = |e: &Fault| matches!(e, Fault::NoRollers { .. } | Fault::Steered { .. });
        if loaded.as_ref().is_err_and(|e| rollerless(e.fault())) {
            println!("  given rollers:");
            options.wheels = Some(WheelOptions {
                joints: match loaded.as_ref().err().map(|e| e.fault()) {
                    Some(Fault::Steered { wheels } | Fault::NoRollers { wheels }) => wheels.clone(),
                    _ => Vec::new(),
                },
                gamma: Handedness::XDeg(45.0),
                rollers: 12,
                radius_m: None,
                roller_radius_m: None,
                roller_mass_kg: None,
                damping_n_m_s: 0.0,
                friction_n_m: 0.0,
            });
            report(&Robot::load_with(&file, &options));
        }
    }
}

fn report(loaded: &Result<Loaded, ilon_robot::RobotError>) {
    let Loaded { robot, outlines } = match loaded {
        Ok(loaded) => loaded,
        Err(error) => {
            println!("  {error}\n    help: {}", error.help());
            assert!(!error.help().is_empty());
            return;
        }
    };
    println!(
        "  {:.2} kg, {} wheels, fingerprint {:016x}",
        robot.mass_kg(),
        robot.wheels.len(),
        common::fingerprint(robot)
    );
    for w in &robot.wheels {
        let r = &w.rollers[0];
        println!(
            "    {}: b {:.4?} m, rho {:.4} m, gamma {:.2} deg, {} rollers of {:.4} x {:.4} m and {:.4} kg, hub {:.3} kg",
            w.name,
            w.position_m().as_slice(),
            w.radius_m,
            w.gamma_rad.to_degrees(),
            w.rollers.len(),
            r.radius_m,
            r.length_m,
            r.mass_kg,
            w.hub.mass_kg
        );
        assert!(w.radius_m.is_finite() && w.radius_m > 0.0 && w.hub.mass_kg > 0.0);
        for r in &w.rollers {
            // The outermost sphere of every barrel must be there.
            let end_m = w.barrel(r).sphere_radius_m(0.5 * r.length_m);
            assert!(r.radius_m > 0.0 && r.length_m > 0.0 && end_m > 0.0, "{r:?}");
            assert!(r.axial_inertia_kg_m2 > 0.0 && r.transverse_inertia_kg_m2 > 0.0);
        }
    }
    for outline in outlines {
        println!("    {outline:?}");
        assert!(outline.ripple_m >= 0.0 && outline.peak_radius_m >= outline.rolling_radius_m);
    }
    for r in &robot.remarks {
        println!("    remark: {}: {}", r.subject, r.text);
    }
}
