//! A filter of the field on what a bag says: `fusion_witness.py`.

use std::process::Command;

/// A Python that has what `fusion_witness.py` judges by: that under `ILON_PYTHON`, or `python3`.
fn python() -> Option<String> {
    let named = std::env::var("ILON_PYTHON").ok();
    let python = named.clone().unwrap_or("python3".into());
    let tried = Command::new(&python)
        .args(["-c", "import rosbags, scipy"])
        .output();
    if tried.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    assert!(
        named.is_none(),
        "{python}, named by ILON_PYTHON, lacks what crates/ilon/tests/requirements.txt lists"
    );
    println!("skipped: {python} lacks what crates/ilon/tests/requirements.txt lists");
    None
}

#[test]
fn a_filter_that_is_fed_with_odometry_and_imu_is_consistent() {
    let Some(python) = python() else { return };
    let output = Command::new(python)
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/fusion_witness.py"
        ))
        .arg(env!("CARGO_BIN_EXE_ilon"))
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../assets/robots/mecanum4.urdf"
        ))
        .output()
        .expect("Python runs");
    print!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
