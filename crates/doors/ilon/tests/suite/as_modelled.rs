//! Rollers with the collision shapes of their file, as in other simulators.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use ilon::Scenario;

/// Ring radius a and roller radius r, in metres.
const A_M: f64 = 0.038;
const R_M: f64 = 0.012;
const COUNT: usize = 8;

/// Three omni wheels at 120 degrees, each with eight capsules across its axis that just reach their
/// neighbours: the centre of each end is the corner of the polygon around the circle of radius a.
fn three_wheels() -> String {
    let half_m = A_M * (PI / COUNT as f64).tan();
    let inertia = |kg_m2: f64| {
        format!(r#"<inertia ixx="{kg_m2}" ixy="0" ixz="0" iyy="{kg_m2}" iyz="0" izz="{kg_m2}"/>"#)
    };
    let mut urdf = format!(
        r#"<robot name="capsules"><link name="base"><inertial><mass value="6"/>{}</inertial></link>"#,
        inertia(0.08)
    );
    for w in 0..3 {
        let turn = TAU * f64::from(w) / 3.0;
        urdf += &format!(
            r#"<link name="hub{w}"><inertial><mass value="0.3"/>{}</inertial></link>
            <joint name="wheel{w}" type="continuous"><parent link="base"/><child link="hub{w}"/>
            <origin xyz="{} {} 0" rpy="0 0 {turn}"/><axis xyz="1 0 0"/><limit effort="5" velocity="50"/></joint>"#,
            inertia(3e-4),
            0.25 * turn.cos(),
            0.25 * turn.sin(),
        );
        for i in 0..COUNT {
            // The hub's axis is x; the roller that points down has its axis along y.
            let place = TAU * i as f64 / COUNT as f64;
            let (s, c) = place.sin_cos();
            urdf += &format!(
                r#"<link name="r{w}_{i}"><inertial><mass value="0.01"/>{}</inertial>
                <collision><origin rpy="1.5707963267948966 0 0"/><geometry><capsule radius="{R_M}" length="{}"/></geometry></collision>
                </link><joint name="roll{w}_{i}" type="continuous"><parent link="hub{w}"/><child link="r{w}_{i}"/>
                <origin xyz="0 {} {}" rpy="{place} 0 0"/><axis xyz="0 1 0"/></joint>"#,
                inertia(8e-7),
                2.0 * half_m,
                A_M * s,
                -A_M * c,
            );
        }
    }
    urdf + "</robot>"
}

fn spun(folder: &Path, rollers: &str) -> ilon::Run {
    // Slowly, so that the robot follows its wheels' rise and fall at every moment.
    let text = format!(
        "[robot]\nfile = \"capsules.urdf\"\nrollers = \"{rollers}\"\n[twist]\nomega_rad_s = 0.3\n[run]\nduration_s = 5\n\
         physics_dt_s = 0.001"
    );
    let scenario = Scenario::from_toml(&text, "spin", folder).unwrap();
    ilon::run(&scenario).unwrap()
}

#[test]
fn capsules_roll_on_their_own_radius_and_ripple_while_barrels_do_not() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("capsules.urdf"), three_wheels()).unwrap();

    // The hub is at h(phi) = a cos phi + (L/2) sin phi + r over a capsule at phi from down, up to
    // pi/n: from a + r to a / cos(pi/n) + r, as L/2 = a tan(pi/n).
    let half_pitch = PI / COUNT as f64;
    let ripple_m = A_M * (1.0 / half_pitch.cos() - 1.0);
    // Its mean over the turn is the wheel's rolling radius.
    let rolling_m =
        R_M + A_M / half_pitch * (half_pitch.sin() + half_pitch.tan() * (1.0 - half_pitch.cos()));
    let ratio = rolling_m / (A_M + R_M);
    assert!(ratio > 1.015, "the test would see nothing");

    let modelled = spun(folder.path(), "as_modelled").summary;
    // In 3 s a wheel turns by 4.5 rad, which is 5.7 pitches: the place within a pitch at which the
    // window ends changes the mean by up to (ripple / radius) / (2 pi 5.7) = 0.2 %.
    let measured = modelled.twist_ratio_ideal.omega.unwrap();
    assert!(
        (measured / ratio - 1.0).abs() < 3e-3,
        "{measured} of {ratio}"
    );
    let rose_m = modelled.hub_ripple_m.unwrap();
    assert!(
        (rose_m / ripple_m - 1.0).abs() < 0.05,
        "{rose_m} of {ripple_m}"
    );
    // The contact kinematics of the capsules explains all of it.
    let contact = modelled.twist_ratio_contact.omega.unwrap();
    assert!((contact - 1.0).abs() < 2e-3, "{contact}");

    let barrels = spun(folder.path(), "barrel").summary;
    let measured = barrels.twist_ratio_ideal.omega.unwrap();
    assert!((measured - 1.0).abs() < 1e-3, "{measured}");
    assert!(barrels.hub_ripple_m.unwrap() < 0.02 * ripple_m);
}

#[test]
fn the_shapes_of_the_file_need_bodies_for_all_rollers() {
    let text = "[robot]\nfile = \"x.urdf\"\nrollers = \"as_modelled\"\nroller_bodies = \"near\"\n[twist]\nvx_m_s = 0.1\n[run]\n\
                duration_s = 1";
    let error = Scenario::from_toml(text, "near", ".").unwrap_err();
    assert!(error.to_string().contains("do not go together"), "{error}");
}
