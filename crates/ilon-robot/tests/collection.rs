//! Every URDF of a folder named by `ILON_URDF_DIR`: each must load, or be refused in words that say where and how to
//! mend it. `ILON_URDF_DIR=~/urdf cargo test -p ilon-robot --test collection -- --nocapture` prints what was made of
//! them.

use std::path::{Path, PathBuf};

use ilon_robot::Robot;

fn urdf_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            urdf_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "urdf") {
            found.push(path);
        }
    }
}

#[test]
fn every_robot_of_the_folder_loads_or_is_refused_in_clear_words() {
    let Some(folder) = std::env::var_os("ILON_URDF_DIR") else {
        return;
    };
    let mut files = Vec::new();
    urdf_files(Path::new(&folder), &mut files);
    files.sort();
    assert!(!files.is_empty(), "no .urdf below {}", folder.display());
    for file in files {
        match Robot::load(&file) {
            Ok(robot) => {
                println!(
                    "{}: {:.2} kg, {} wheels",
                    file.display(),
                    robot.mass_kg(),
                    robot.wheels.len()
                );
                for w in &robot.wheels {
                    println!(
                        "    {}: b {:.4?}, rho {:.4}, gamma {:.2} deg, {} rollers of {:.4}",
                        w.name,
                        w.position_m().as_slice(),
                        w.radius_m,
                        w.gamma_rad.to_degrees(),
                        w.rollers.len(),
                        w.rollers[0].radius_m
                    );
                    assert!(w.radius_m.is_finite() && w.radius_m > 0.0);
                    assert!(
                        w.rollers
                            .iter()
                            .all(|r| r.radius_m > 0.0 && r.length_m > 0.0)
                    );
                }
                for r in &robot.remarks {
                    println!("    remark: {}: {}", r.subject, r.text);
                }
            }
            Err(error) => {
                println!("{error}\n    help: {}", error.help());
                assert!(!error.help().is_empty());
            }
        }
    }
}
