//! Generated files are read back as the description, with any choice of frames.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use ilon_formats::{
    Arrangement, ChassisShape, ChassisSpec, LoadOptions, LoadRobot, PlacedWheel, RollerBearings,
    RollerSpec, Spec, TreadSpec, WheelSpec, build, described, generate,
};
use ilon_robot::{Robot, wrap_angle};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

prop_compose! {
    fn wheel_list()(count in 3usize..7)(
        wheels in prop::collection::vec(
            (-0.5..0.5, -0.5..0.5, -180.0..180.0, -75.0..75.0),
            count,
        ),
    ) -> Vec<PlacedWheel> {
        wheels
            .into_iter()
            .enumerate()
            .map(|(i, (x, y, axis_deg, gamma_deg))| PlacedWheel {
                name: format!("w{i}"),
                position_m: [x, y],
                axis_deg,
                gamma_deg,
            })
            .collect()
    }
}

prop_compose! {
    fn spec()(
        wheels in wheel_list(),
        radius_m in 0.02..0.3,
        per_row in 5usize..16,
        rows in 1usize..3,
        thickness in 0.1..0.9,
        row_spacing_m in 0.0..0.05,
        masses_kg in (0.5..50.0, 0.05..2.0, 0.001..0.2),
        motor in (0.1..20.0, 1.0..200.0),
        losses in (0.0..0.1, 0.0..0.1, 0.0..1e-4, 0.0..1e-3),
        drive in (0.1..300.0, 0.0..1e-4, 0.01..1.0, 0.0..0.5),
        longer in 0.0..1.0,
        surface in (0.0..0.2, prop::option::of((1e3..1e8, prop::option::of(0.0..1e4), prop::option::of(1e-3..0.1)))),
    ) -> Spec {
        // Between the smallest radius at which neighbours meet and 0.45 of the wheel.
        let least_m = radius_m * (1.0 - (PI / (per_row * rows) as f64).cos());
        let roller_radius_m = least_m + thickness * (0.45 * radius_m - least_m);
        let ring_m = radius_m - roller_radius_m;
        let most_tan = f64::sqrt(radius_m * radius_m - ring_m * ring_m) / ring_m;
        Spec {
            name: "random".to_owned(),
            chassis: ChassisSpec {
                shape: ChassisShape::Box { size_m: [0.4, 0.3, 0.1] },
                mass_kg: masses_kg.0,
                center_m: [0.01, -0.02, 0.2],
            },
            wheel: WheelSpec {
                radius_m,
                hub_mass_kg: masses_kg.1,
                hub_radius_m: 0.5 * radius_m,
                hub_width_m: 0.4 * radius_m,
                motor_effort_n_m: motor.0,
                motor_velocity_rad_s: motor.1,
                damping_n_m_s: losses.0,
                friction_n_m: losses.1,
                gear_ratio: drive.0,
                rotor_inertia_kg_m2: drive.1,
                gear_efficiency: drive.2,
                gear_friction_n_m: drive.3,
            },
            rollers: RollerSpec {
                per_row,
                rows,
                row_spacing_m,
                radius_m: roller_radius_m,
                mass_kg: masses_kg.2,
                damping_n_m_s: losses.2,
                friction_n_m: losses.3,
                // Up to nine tenths of the length at which the barrel tapers to zero.
                length_factor: 1.0 + 0.9 * longer * (most_tan / (PI / (per_row * rows) as f64).tan() - 1.0),
                crown: 1.0,
                profile_m: None,
                edge_radius_m: 0.0,
                radius_spread_m: 0.0,
                radius_seed: 0,
                radius_offsets_m: BTreeMap::new(),
                rolling_resistance: surface.0,
                // Characters that XML has to escape.
                material: (longer > 0.5).then(|| "rubber <60> & \"cord\"".to_owned()),
                axial_play_m: 0.1 * surface.0 * roller_radius_m,
                bearings: (surface.0 > 0.5).then_some(RollerBearings::Bushings),
                axle_friction: (longer > 0.5).then_some(0.3 * longer),
                axle_radius_m: (longer > 0.5).then_some(0.2 * roller_radius_m),
                tread: surface.1.map(|(stiffness_n_m, damping_n_s_m, relaxation_length_m)| TreadSpec {
                    stiffness_n_m,
                    damping_n_s_m,
                    shear_stiffness_n_m: damping_n_s_m.map(|_| 0.3 * stiffness_n_m),
                    shear_damping_n_s_m: relaxation_length_m.map(|_| 3.0),
                    relaxation_length_m,
                }),
            },
            wheels: Arrangement::List(wheels),
            suspension: BTreeMap::new(),
            overrides: BTreeMap::new(),
        }
    }
}

/// Tolerance, relative: fifteen digits in the file, reduced by cancellation at steep gamma, where
/// the axes of hub and roller are nearly parallel, by a factor of up to 1 / cos(75 deg)^2 = 15, and
/// by the chain of frames.
const TOLERANCE: f64 = 1e-11;

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= TOLERANCE * (1.0 + b.abs())
}

/// Words and numbers of a robot's debug text, without its remarks.
fn words_and_numbers(robot: &Robot) -> (Vec<String>, Vec<f64>) {
    let mut bare = Robot {
        remarks: Vec::new(),
        ..robot.clone()
    };
    // If a roller points straight up, rounding decides which is the first.
    for wheel in &mut bare.wheels {
        wheel.rollers.sort_by(|p, q| p.name.cmp(&q.name));
    }
    let shown = format!("{bare:?}");
    let parts = shown.split(|c: char| c.is_whitespace() || "[](){},:".contains(c));
    let (mut words, mut numbers) = (Vec::new(), Vec::new());
    for part in parts.filter(|part| !part.is_empty()) {
        match part.parse::<f64>() {
            Ok(number) => numbers.push(number),
            Err(_) => words.push(part.to_owned()),
        }
    }
    (words, numbers)
}

fn alike(built: &Robot, read: &Robot) {
    for wheel in built.wheels.iter().chain(&read.wheels) {
        let places = wheel.rollers.iter().map(|roller| roller.place_rad());
        assert!(places.is_sorted(), "one after the other around the wheel");
    }
    let ((words, numbers), (read_words, read_numbers)) =
        (words_and_numbers(built), words_and_numbers(read));
    assert_eq!(words, read_words);
    assert_eq!(numbers.len(), read_numbers.len());
    for (built, read) in numbers.iter().zip(&read_numbers) {
        assert!(built == read || close(*built, *read), "{built} {read}");
    }
}

/// The shipped descriptions, with crowned, turned and short rollers among them; and some that both
/// ways refuse.
#[test]
fn shipped_descriptions_are_built_as_they_are_read() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    let mut compared = 0;
    for entry in std::fs::read_dir(folder).expect("the folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|ending| ending != "toml") {
            continue;
        }
        let read = Robot::load(&path).expect("it loads");
        let Some((built, _)) = described(&path, &LoadOptions::default()).expect("it is a robot")
        else {
            continue;
        };
        alike(&built, &read);
        compared += 1;
    }
    assert!(compared >= 9, "{compared}");
    let mut options = LoadOptions::default();
    let changed = |key: &str| key.parse().expect("TOML");
    options.spec = changed("rollers.per_row = 3");
    let path = std::path::Path::new(folder).join("mecanum4.toml");
    assert_eq!(
        described(&path, &options).is_err(),
        Robot::load_with(&path, &options).is_err()
    );
    options.spec = changed("rollers.length_factor = 0.8");
    let (built, _) = described(&path, &options)
        .expect("it is a robot")
        .expect("it is described");
    alike(
        &built,
        &Robot::load_with(&path, &options).expect("it loads").robot,
    );
    options.repair = true;
    assert!(described(&path, &options).expect("it is read").is_none());
}

/// Rockers across, along and oblique, springs, arms in both directions, and several at once: with
/// wheels of one radius and, raised, of another.
#[test]
fn suspensions_are_built_as_they_are_read() {
    let sprung = "law.sprung = { stiffness_n_m = 4000, damping_n_s_m = 120, friction_n = 0.5, preload_n = 20, travel_m = 0.02 }";
    let arm = |length_m: f64| {
        format!(
            "law.trailing_arm = {{ length_m = {length_m}, stiffness_n_m_rad = 40, damping_n_m_s_rad = 0.3, preload_n_m = 2, travel_deg = 15 }}"
        )
    };
    let rocker = "law.rocker = { limit_deg = 5, damping_n_m_s_rad = 0.1, friction_n_m = 0.02 }";
    let on = |name: &str, wheels: &str, law: &str| {
        format!("[suspension.{name}]\nwheels = [{wheels}]\nmass_kg = 0.4\n{law}\n")
    };
    let (front, rear) = (r#""a", "b""#, r#""c", "d""#);
    let cases = [
        on("x", front, rocker),
        on("x", r#""d", "c""#, rocker),
        on("x", r#""a", "c""#, rocker),
        on("x", r#""b", "c""#, rocker),
        on("x", front, sprung),
        on("x", r#""a", "b", "c", "d""#, &arm(0.1)),
        on("x", rear, &arm(-0.07)),
        on("y", front, &arm(0.05)) + &on("x", r#""d""#, sprung),
        on("y", front, rocker) + &on("x", rear, sprung),
    ];
    for hung in cases {
        for raised in ["", "[overrides.b]\nradius_m = 0.06\n"] {
            let text = format!(
                "name = \"hung\"\nchassis = {{ shape.box = {{ size_m = [0.4, 0.24, 0.1] }}, mass_kg = 10.0, center_m = [0.03, 0.01, 0.1] }}\n\
                 wheel = {{ radius_m = 0.05, hub_mass_kg = 0.25, hub_radius_m = 0.03, hub_width_m = 0.04, motor_effort_n_m = 1.8, motor_velocity_rad_s = 30 }}\n\
                 rollers = {{ per_row = 9, radius_m = 0.012, mass_kg = 0.01 }}\n\
                 wheels.list = [\n\
                 {{ name = \"a\", position_m = [0.15, 0.16], axis_deg = 90, gamma_deg = -45 }},\n\
                 {{ name = \"b\", position_m = [0.14, -0.16], axis_deg = 85, gamma_deg = 45 }},\n\
                 {{ name = \"c\", position_m = [-0.15, 0.16], axis_deg = 90, gamma_deg = 45 }},\n\
                 {{ name = \"d\", position_m = [-0.16, -0.17], axis_deg = 95, gamma_deg = -45 }}]\n{hung}{raised}"
            );
            let spec = Spec::from_toml_str(&text, "hung.toml").expect("a description");
            let built = build(&spec).expect("in range");
            let urdf = generate(&spec).expect("in range");
            let read = Robot::from_urdf_str(&urdf, "hung.urdf").expect("it loads");
            assert!(!read.joints.is_empty(), "{hung}");
            alike(&built, &read);
        }
    }
}

/// Random robots per property: more in optimised builds.
const CASES: u32 = if cfg!(debug_assertions) { 12 } else { 64 };

proptest! {
    #![proptest_config(ProptestConfig { cases: CASES, failure_persistence: None, rng_seed: RngSeed::Fixed(1973), ..ProptestConfig::default() })]

    /// A robot built directly equals the one that is written and read: the same words, and the same
    /// numbers except for rounding.
    #[test]
    fn a_robot_that_is_built_is_the_one_that_is_read(spec in spec()) {
        let built = build(&spec).expect("in range");
        let read = Robot::from_urdf_str(&generate(&spec).expect("in range"), "random.urdf").expect("it loads");
        alike(&built, &read);
    }

    #[test]
    fn a_generated_robot_is_read_back_as_described(spec in spec()) {
        let text = generate(&spec).expect("in range");
        let robot = Robot::from_urdf_str(&text, "random.urdf").expect("it loads");
        let described = spec.wheels.placed();
        prop_assert_eq!(robot.wheels.len(), described.len());
        prop_assert!(close(robot.chassis.mass.mass_kg, spec.chassis.mass_kg));
        prop_assert!(close(robot.ride_height_m(), 0.0));
        let count = spec.rollers.per_row * spec.rollers.rows;
        for (wheel, placed) in robot.wheels.iter().zip(&described) {
            prop_assert_eq!(&wheel.name, &placed.name);
            let position_m = wheel.position_m();
            prop_assert!(close(position_m.x, placed.position_m[0]));
            prop_assert!(close(position_m.y, placed.position_m[1]));
            prop_assert!(close(position_m.z, spec.wheel.radius_m));
            let axis_rad = wheel.axis().y.atan2(wheel.axis().x);
            prop_assert!(wrap_angle(axis_rad - placed.axis_deg.to_radians()).abs() < TOLERANCE);
            prop_assert!(close(wheel.gamma_rad, placed.gamma_deg.to_radians()));
            prop_assert!(close(wheel.radius_m, spec.wheel.radius_m));
            prop_assert!(close(wheel.hub.mass_kg, spec.wheel.hub_mass_kg));
            prop_assert!(close(wheel.motor.effort_n_m, spec.wheel.motor_effort_n_m));
            prop_assert!(close(wheel.motor.velocity_rad_s, spec.wheel.motor_velocity_rad_s));
            prop_assert!(close(wheel.joint.damping_n_m_s, spec.wheel.damping_n_m_s));
            prop_assert!(close(wheel.joint.friction_n_m, spec.wheel.friction_n_m));
            prop_assert!(close(wheel.drive.gear_ratio, spec.wheel.gear_ratio));
            // A rotor's inertia is far below 1, so the comparison is relative.
            let rotor = spec.wheel.rotor_inertia_kg_m2;
            prop_assert!((wheel.drive.rotor_inertia_kg_m2 - rotor).abs() <= TOLERANCE * rotor);
            prop_assert!(close(wheel.drive.gear_efficiency, spec.wheel.gear_efficiency));
            prop_assert!(close(wheel.drive.gear_friction_n_m, spec.wheel.gear_friction_n_m));
            prop_assert_eq!(wheel.rollers.len(), count);
            let ring_m = spec.wheel.radius_m - spec.rollers.radius_m;
            let gap_free_m = 2.0 * ring_m * (PI / count as f64).tan() / placed.gamma_deg.to_radians().cos();
            let length_m = spec.rollers.length_factor * gap_free_m;
            prop_assert_eq!(&wheel.material, &spec.rollers.material);
            let (found, said) = (wheel.surface, spec.rollers.surface());
            prop_assert!(close(found.rolling_resistance, said.rolling_resistance));
            prop_assert!(close(found.axle_friction, said.axle_friction));
            prop_assert!(close(found.axle_radius_m, said.axle_radius_m));
            prop_assert_eq!(found.tread.is_some(), said.tread.is_some());
            if let (Some(found), Some(said)) = (found.tread, said.tread) {
                let same = |a: Option<f64>, b: Option<f64>| match (a, b) {
                    (Some(a), Some(b)) => close(a, b),
                    (a, b) => a == b,
                };
                prop_assert!(close(found.stiffness_n_m, said.stiffness_n_m));
                prop_assert!(same(found.damping_n_s_m, said.damping_n_s_m));
                prop_assert!(same(found.shear_stiffness_n_m, said.shear_stiffness_n_m));
                prop_assert!(same(found.shear_damping_n_s_m, said.shear_damping_n_s_m));
                prop_assert!(same(found.relaxation_length_m, said.relaxation_length_m));
            }
            for roller in &wheel.rollers {
                prop_assert!(close(roller.radius_m, spec.rollers.radius_m));
                prop_assert!(close(roller.ring_radius_m(), ring_m));
                prop_assert!(close(roller.length_m, length_m), "{} {}", roller.length_m, length_m);
                prop_assert!(close(roller.mass_kg, spec.rollers.mass_kg));
                prop_assert!(close(roller.joint.damping_n_m_s, spec.rollers.damping_n_m_s));
                prop_assert!(close(roller.joint.friction_n_m, spec.rollers.friction_n_m));
                let offset_m = if spec.rollers.rows == 2 { 0.5 * spec.rollers.row_spacing_m } else { 0.0 };
                prop_assert!(close(roller.row_offset_m().abs(), offset_m));
            }
        }
    }

    #[test]
    fn the_frames_of_links_do_not_matter(
        spec in spec(),
        turns in prop::collection::vec((-3.0..3.0, -1.5..1.5, -3.0..3.0), 16),
    ) {
        let text = generate(&spec).expect("in range");
        let robot = Robot::from_urdf_str(&text, "random.urdf").expect("it loads");
        // Compound roll, pitch and yaw: every link is rotated at random.
        let turned = reframed(&text, |i, _| {
            let (r, p, y) = turns[i % turns.len()];
            UnitQuaternion::from_euler_angles(r, p, y)
        });
        same_robot(&robot, &Robot::from_urdf_str(&turned, "turned.urdf").expect("it loads"))?;
        // Every link along the body's axes, with the joint's axis rotated instead.
        let unturned = reframed(&text, |_, body_from_link| body_from_link.inverse());
        same_robot(&robot, &Robot::from_urdf_str(&unturned, "unturned.urdf").expect("it loads"))?;
    }
}

fn same_robot(p: &Robot, q: &Robot) -> Result<(), TestCaseError> {
    prop_assert_eq!(p.wheels.len(), q.wheels.len());
    for (v, w) in p.wheels.iter().zip(&q.wheels) {
        prop_assert!((v.position_m() - w.position_m()).norm() < TOLERANCE);
        prop_assert!(v.body_from_hub.rotation.angle_to(&w.body_from_hub.rotation) < 1e-7);
        prop_assert!(close(v.gamma_rad, w.gamma_rad));
        prop_assert!(close(v.radius_m, w.radius_m));
        prop_assert!((v.hub.inertia_kg_m2 - w.hub.inertia_kg_m2).norm() < TOLERANCE);
        prop_assert_eq!(v.rollers.len(), w.rollers.len());
        for a in &v.rollers {
            // The order can differ for a roller at the discontinuity at +-pi.
            let b = w
                .rollers
                .iter()
                .find(|b| b.name == a.name)
                .expect("the same rollers");
            prop_assert!((a.center_in_hub_m - b.center_in_hub_m).norm() < TOLERANCE);
            prop_assert!(
                (a.axis_in_hub.into_inner() - b.axis_in_hub.into_inner()).norm() < TOLERANCE
            );
            prop_assert!(close(a.length_m, b.length_m));
            let (axial, across) = (a.axial_inertia_kg_m2, a.transverse_inertia_kg_m2);
            prop_assert!(
                (axial - b.axial_inertia_kg_m2).abs() < 1e-11 * axial,
                "{axial} {}",
                b.axial_inertia_kg_m2
            );
            prop_assert!(
                (across - b.transverse_inertia_kg_m2).abs() < 1e-11 * across,
                "{across} {}",
                b.transverse_inertia_kg_m2
            );
        }
    }
    Ok(())
}

/// The same robot with the frame of every link except the root rotated: `turn` receives the joint's
/// index and the link's orientation in the body, and returns the new frame's orientation in the old
/// one.
fn reframed(
    text: &str,
    turn: impl Fn(usize, UnitQuaternion<f64>) -> UnitQuaternion<f64>,
) -> String {
    let mut robot = urdf_rs::read_from_string(text).expect("a generated robot");
    // The generator writes each joint after its parent link, so that one pass from the top visits
    // parents first.
    let mut body_from_old =
        std::collections::HashMap::from([("base_link".to_owned(), UnitQuaternion::identity())]);
    let mut old_from_new =
        std::collections::HashMap::from([("base_link".to_owned(), UnitQuaternion::identity())]);
    for (i, joint) in robot.joints.iter_mut().enumerate() {
        let parent_turn: UnitQuaternion<f64> = old_from_new[&joint.parent.link];
        let old = isometry(&joint.origin);
        let in_body: UnitQuaternion<f64> = body_from_old[&joint.parent.link] * old.rotation;
        let child_turn = turn(i, in_body);
        set(
            &mut joint.origin,
            &(parent_turn.inverse() * old * child_turn),
        );
        let axis = Unit::new_normalize(child_turn.inverse() * Vector3::from(*joint.axis.xyz));
        *joint.axis.xyz = axis.into_inner().into();
        body_from_old.insert(joint.child.link.clone(), in_body);
        old_from_new.insert(joint.child.link.clone(), child_turn);
    }
    for link in &mut robot.links {
        let new_from_old = old_from_new[&link.name].inverse();
        let turned = |pose: &mut urdf_rs::Pose| set(pose, &(new_from_old * isometry(pose)));
        turned(&mut link.inertial.origin);
        link.collision
            .iter_mut()
            .for_each(|c| turned(&mut c.origin));
    }
    urdf_rs::write_to_string(&robot).expect("a robot that can be written")
}

fn isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [r, p, y] = *pose.rpy;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(*pose.xyz)),
        UnitQuaternion::from_euler_angles(r, p, y),
    )
}

fn set(pose: &mut urdf_rs::Pose, to: &Isometry3<f64>) {
    // Yaw first, and removed: the textbook's arc sine loses half of the digits near a pitch of
    // 90 degrees.
    let m = to.rotation.to_rotation_matrix();
    let yaw = m[(1, 0)].atan2(m[(0, 0)]);
    let (s, c) = yaw.sin_cos();
    let pitch = (-m[(2, 0)]).atan2(c * m[(0, 0)] + s * m[(1, 0)]);
    let roll = (s * m[(0, 2)] - c * m[(1, 2)]).atan2(c * m[(1, 1)] - s * m[(0, 1)]);
    *pose.xyz = to.translation.vector.into();
    *pose.rpy = [roll, pitch, yaw];
}
