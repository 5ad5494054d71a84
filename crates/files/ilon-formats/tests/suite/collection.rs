//! Every robot file of a folder named by `ILON_ROBOTS`: each must load, or be refused with a
//! message that says where and how to repair it; and proposals must work. `ILON_ROBOTS=~/urdf cargo
//! test -p ilon-robot --test suite collection:: -- --nocapture` prints the results.

use crate::common;

use std::path::{Path, PathBuf};

use ilon_formats::{LoadOptions, LoadRobot, Loaded};
use ilon_robot::Robot;

fn urdf_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            urdf_files(&path, found);
        } else if path.extension().is_some_and(|e| {
            ["urdf", "xacro", "sdf", "mjcf"]
                .iter()
                .any(|known| e == *known)
        }) {
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
        let options = LoadOptions::default();
        let loaded = Robot::load_with(&file, &options);
        report(&loaded);
        if loaded.is_ok() {
            continue;
        }
        let diagnosis = Robot::diagnose(&file, &options, |_| true);
        for fault in &diagnosis.faults[1..] {
            println!("  and {fault}\n    help: {}", fault.help());
        }
        assert_eq!(
            diagnosis.proposal.is_some(),
            diagnosis.loaded.is_some(),
            "what is proposed works"
        );
        if let (Some(proposal), Some(loaded)) = (&diagnosis.proposal, diagnosis.loaded) {
            println!("  with {proposal:?}:");
            report(&Ok(*loaded));
        }
    }
}

fn report(loaded: &Result<Loaded, ilon_formats::RobotError>) {
    let (robot, outlines) = match loaded {
        Ok(Loaded {
            robot, outlines, ..
        }) => (robot, outlines),
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
            // The outermost sphere of every barrel must exist.
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
