//! A common state-estimation filter on the data of a bag: `fusion_witness.py`.

use std::process::Command;

use crate::support::python;

#[test]
#[ignore = "minutes: .ci/nightly"]
fn a_filter_that_is_fed_with_odometry_and_imu_is_consistent() {
    let Some(python) = python("rosbags, scipy") else {
        return;
    };
    let output = Command::new(python)
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/fusion_witness.py"
        ))
        .arg(env!("CARGO_BIN_EXE_ilon"))
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../assets/robots/mecanum4.urdf"
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
