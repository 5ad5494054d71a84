//! Two driven wheels on a body that a joint turns below the base, their axle behind the joint: the
//! wheels turn the lower body, and the joint turns the base over it, so that it moves any way at
//! any angle.

use ilon_sim::{Run, Scenario, Simulation};

/// From the joint back to the axle.
const TRAIL_M: f64 = 0.1;

/// A wheel below a link, at a place in its frame.
fn wheel(name: &str, below: &str, [x_m, y_m]: [f64; 2]) -> String {
    format!(
        r#"<link name="{name}"><inertial><mass value="0.4"/><inertia ixx="3e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="3e-4"/></inertial>
        <collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
        <joint name="{name}_wheel" type="continuous"><parent link="{below}"/><child link="{name}"/>
        <origin xyz="{x_m} {y_m} 0.05"/><axis xyz="0 1 0"/><limit effort="5" velocity="20"/></joint>"#
    )
}

/// The end of a robot's text, with its base.
fn base(name: &str, rest: &str) -> String {
    format!(
        r#"<robot name="{name}"><link name="base"><inertial><origin xyz="0 0 0.15"/><mass value="6"/>
        <inertia ixx="0.06" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.1"/></inertial></link>{rest}</robot>"#
    )
}

/// A base above a lower body with two wheels and two balls.
fn caster() -> String {
    let ball = |y_m: f64| {
        format!(
            r#"<collision><origin xyz="0.12 {y_m} 0.02"/><geometry><sphere radius="0.02"/></geometry></collision>"#
        )
    };
    let (left, right) = ([-TRAIL_M, 0.15], [-TRAIL_M, -0.15]);
    let rest = format!(
        r#"<link name="lower"><inertial><origin xyz="0 0 0.06"/><mass value="5"/>
        <inertia ixx="0.03" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.05"/></inertial>{}{}</link>
        <joint name="yaw" type="continuous"><parent link="base"/><child link="lower"/>
        <axis xyz="0 0 1"/><limit effort="40" velocity="6"/></joint>{}{}"#,
        ball(0.1),
        ball(-0.1),
        wheel("left", "lower", left),
        wheel("right", "lower", right)
    );
    base("caster", &rest)
}

/// A base on four bodies with two wheels each beside their upright joints.
fn four_pairs() -> String {
    let module = |[x_m, y_m]: [f64; 2]| {
        let name = format!("at_{}_{}", x_m > 0.0, y_m > 0.0);
        format!(
            r#"<link name="{name}"><inertial><origin xyz="0 0 0.06"/><mass value="1"/>
            <inertia ixx="2e-3" ixy="0" ixz="0" iyy="2e-3" iyz="0" izz="2e-3"/></inertial></link>
            <joint name="{name}_yaw" type="continuous"><parent link="base"/><child link="{name}"/>
            <origin xyz="{x_m} {y_m} 0"/><axis xyz="0 0 1"/><limit effort="2" velocity="6"/></joint>{}{}"#,
            wheel(&format!("{name}_left"), &name, [0.0, 0.05]),
            wheel(&format!("{name}_right"), &name, [0.0, -0.05])
        )
    };
    let places_m = [[0.2, 0.2], [0.2, -0.2], [-0.2, 0.2], [-0.2, -0.2]];
    base("pairs", &places_m.map(module).concat())
}

/// A robot that a twist drives for some seconds.
fn driven(urdf: &str, twist: [f64; 3], duration_s: f64) -> Run {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("caster.urdf"), urdf).expect("a file");
    let [vx, vy, omega] = twist;
    let text = format!(
        "robot.file = \"caster.urdf\"\nworld.floor.friction = 0.8\n\
         twist = {{ vx_m_s = {vx}, vy_m_s = {vy}, omega_rad_s = {omega}, rest_s = 0 }}\nrun.duration_s = {duration_s}\n"
    );
    let scenario = Scenario::from_toml(&text, "caster", folder.path()).expect("a scenario");
    Simulation::new(&scenario).expect("it drives").run()
}

/// The joint lies at the origin, which stands still: neither wheel turns, and the joint turns back
/// as fast as the base turns.
#[test]
fn on_the_spot_the_wheels_stand_and_the_joint_turns_the_base() {
    let found = driven(&caster(), [0.0, 0.0, 0.8], 3.0);
    let row = found.trace.records().len() - 1;
    let end = &found.trace.records()[row];
    // A servo's lag is constant at a constant rate.
    let omega = end.truth.twist_in_body.omega_rad_s;
    assert!((omega / 0.8 - 1.0).abs() < 2e-3, "{omega}");
    let of_joint = end.joints[0].rate;
    assert!((of_joint / -0.8 - 1.0).abs() < 2e-3, "{of_joint}");
    for wheel in found.trace.wheels_at(row) {
        assert!(wheel.rate_rad_s.abs() < 0.02, "{}", wheel.rate_rad_s);
    }
    let ideal = found.summary.twist_ratio_ideal.omega.expect("it turns");
    assert!((ideal - 1.0).abs() < 2e-3, "{ideal}");
}

/// Sideways from the start, before its wheels point there, and with a turn besides. Ahead of its
/// axle the joint moves at v + (rate of the lower body) x trail, so wheels that roll without slip
/// and a joint that keeps up give the twist that was asked; the odometry that knows the joint's
/// angle knows all of it.
#[test]
fn it_moves_any_way_and_its_odometry_knows() {
    for twist in [[0.0, 0.2, 0.0], [0.15, -0.1, 0.5], [-0.1, 0.1, -0.4]] {
        let summary = driven(&caster(), twist, 4.0).summary;
        let ratios = [summary.twist_ratio_asked, summary.twist_ratio_ideal];
        for ratio in ratios {
            for (ratio, asked) in [ratio.vx, ratio.vy, ratio.omega].into_iter().zip(twist) {
                if asked == 0.0 {
                    continue;
                }
                let off = ratio.expect("it was asked for") - 1.0;
                // Slip by creep and scrub, and the servo's lag while the joint's rate changes.
                assert!(off.abs() < 0.01, "{twist:?}: {ratio:?}");
            }
        }
        let off_m = summary.odometry_ideal.m_per_m.expect("it drove");
        assert!(off_m < 5e-3, "{twist:?}: {off_m} m per m");
    }
}

/// Servos of 2 N m do not turn modules whose wheels hold their angle: the wheels turn with them,
/// and then roll the way that was asked, all within 1 s.
#[test]
fn pairs_turn_their_modules_to_the_side() {
    let found = driven(&four_pairs(), [0.0, 0.3, 0.0], 3.0);
    let ratio = found.summary.twist_ratio_asked.vy.expect("it drove");
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    let away_m = found.summary.end_y_m.expect("it drove");
    assert!((0.6..0.9).contains(&away_m), "{away_m} m");
    // A wheel that turns with its module does not turn the base. By its rate alone it would, at 6
    // rad/s by s^2 / (b^2 + s^2) of that, 0.18 rad/s, with s = 0.05 m and b = 0.28 m. What is left
    // is a period's lag while the joint speeds up.
    let falsely = found.trace.records().iter().map(|row| {
        let [ideal, real] = [row.twist_ideal, row.truth.twist_in_body];
        (ideal.omega_rad_s - real.omega_rad_s).abs()
    });
    let most_rad_s = falsely.fold(0.0, f64::max);
    assert!(most_rad_s < 0.12, "{most_rad_s} rad/s");
}

/// The joint can turn back by half a radian. There it stops, and the robot turns about the middle
/// of its axle, as one whose wheels are not steered: they roll at 0.8 rad/s x 0.15 m / 0.05 m.
#[test]
fn with_its_joint_at_the_stop_it_drives_as_one_without() {
    let limited = caster().replace(
        r#"<joint name="yaw" type="continuous">"#,
        r#"<joint name="yaw" type="revolute">"#,
    );
    let limits = r#"<limit lower="-0.5" upper="0.5" effort="40" velocity="6"/>"#;
    let limited = limited.replace(r#"<limit effort="40" velocity="6"/>"#, limits);
    let found = driven(&limited, [0.0, 0.0, 0.8], 3.0);
    let row = found.trace.records().len() - 1;
    let end = &found.trace.records()[row];
    assert!((end.joints[0].position + 0.5).abs() < 0.01);
    let omega = end.truth.twist_in_body.omega_rad_s;
    assert!((omega / 0.8 - 1.0).abs() < 0.02, "{omega}");
    for wheel in found.trace.wheels_at(row) {
        assert!(
            (wheel.rate_rad_s.abs() / 2.4 - 1.0).abs() < 0.02,
            "{}",
            wheel.rate_rad_s
        );
    }
}
