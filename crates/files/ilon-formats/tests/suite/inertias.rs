//! Inertias that are impossible for the mass and shapes: remarked, and computed from the shapes
//! with the repair.

use crate::common;

use ilon_formats::{LoadOptions, LoadRobot};
use ilon_robot::Robot;
use test_case::test_case;

/// A wheel of 0.5 kg, radius 0.05 m and width 0.04 m about y: across (3 r^2 + w^2) m / 12, along m
/// r^2 / 2.
const WHEEL: [f64; 3] = [3.791_667e-4, 6.25e-4, 3.791_667e-4];
/// A box of 10 kg, 0.4 x 0.3 x 0.1 m: m (b^2 + c^2) / 12.
const BOX: [f64; 3] = [0.083_333, 0.141_667, 0.208_333];

fn text(base: [f64; 3], wheel: [f64; 3]) -> String {
    let inertia = |[x, y, z]: [f64; 3]| {
        format!(r#"<inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/>"#)
    };
    let wheels = [
        ("fl", 0.2, 0.18),
        ("fr", 0.2, -0.18),
        ("rl", -0.2, 0.18),
        ("rr", -0.2, -0.18),
    ];
    let wheels = wheels.map(|(name, x, y)| {
        format!(
            r#"<link name="{name}"><inertial><mass value="0.5"/>{}</inertial>
<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision></link>
<joint name="mecanum_{name}" type="continuous"><parent link="base"/><child link="{name}"/><origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/></joint>"#,
            inertia(wheel)
        )
    });
    format!(
        r#"<robot name="r"><link name="base"><inertial><mass value="10"/>{}</inertial>
<collision><origin xyz="0 0 0.05"/><geometry><box size="0.4 0.3 0.1"/></geometry></collision></link>
{}</robot>"#,
        inertia(base),
        wheels.join("\n")
    )
}

fn load(text: &str, options: &LoadOptions) -> (Robot, String) {
    let robot = Robot::from_urdf_str_with(text, "r.urdf", options)
        .unwrap()
        .robot;
    let said = robot.remarks.iter().map(ToString::to_string);
    let said = said.collect::<Vec<_>>().join("\n");
    (robot, said)
}

/// The inertia of a wheel with its rollers about its middle: along its axis, and the two across.
fn of_wheel(robot: &Robot) -> [f64; 3] {
    let wheel = &robot.wheels[0];
    let mut parts = vec![wheel.hub.clone()];
    parts.extend(wheel.rollers.iter().map(|roller| roller.mass_in_hub()));
    let whole = ilon_robot::MassProperties::merged(&parts).unwrap();
    let i = whole.inertia_kg_m2;
    [i.m33, i.m11, i.m22]
}

#[test]
fn inertias_of_the_shapes_are_not_doubted() {
    let (robot, said) = load(&text(BOX, WHEEL), &LoadOptions::default());
    assert!(!said.contains("doubtful"), "{said}");
    // A ring of the same mass, a heavy rim and a battery in the middle of the chassis are no
    // faults.
    for (base, wheel) in [
        (BOX, [0.000_7, 0.001_2, 0.000_7]),
        (BOX.map(|i| 0.2 * i), WHEEL),
        (BOX, WHEEL.map(|i| 0.3 * i)),
    ] {
        let (_, said) = load(&text(base, wheel), &LoadOptions::default());
        assert!(!said.contains("doubtful"), "{said}");
    }
    assert!((of_wheel(&robot)[0] - WHEEL[1]).abs() < 1e-9);
}

// Extent of the wheel hypot(0.05, 0.02) = 53.9 mm: 1.01 of it, and 2.4 times. Of the box half of
// its diagonal, 255 mm from its middle, which lies 50 mm above the centre of mass.
#[test_case(BOX, [0.0005, 0.00149, 0.00148], "radius of gyration"; "a wheel just beyond its reach")]
#[test_case(BOX, [0.008, 0.008, 0.008], "radius of gyration"; "a wheel 2.4 times beyond")]
#[test_case([0.4, 0.7, 0.99], WHEEL, "radius of gyration"; "a chassis just beyond")]
#[test_case(BOX, [3.791_667e-4, 3.791_667e-4, 6.25e-4], "about other axes"; "a wheel whose axes are exchanged")]
#[test_case([0.208_333, 0.141_667, 0.083_333], WHEEL, "about other axes"; "a box whose axes are exchanged")]
#[test_case(BOX, [3.79e-8, 6.25e-8, 3.79e-8], "where a solid of its shape has"; "a wheel a ten thousandth")]
#[test_case([8.3e-6, 1.4e-5, 2.1e-5], WHEEL, "where a solid of its shape has"; "a chassis a ten thousandth")]
fn impossible_inertias_are_remarked_and_mended(base: [f64; 3], wheel: [f64; 3], words: &str) {
    let text = text(base, wheel);
    let (_, said) = load(&text, &LoadOptions::default());
    assert!(said.contains("doubtful") && said.contains(words), "{said}");
    let (robot, said) = load(&text, &common::options(|o| o.repair = true));
    assert!(
        said.contains("repaired") && !said.contains("doubtful"),
        "{said}"
    );
    // Six digits are written above.
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-5;
    assert!(
        near(of_wheel(&robot)[0], WHEEL[1]),
        "{:?}",
        of_wheel(&robot)
    );
    // Valid values are kept.
    let chassis = robot.chassis.mass.inertia_kg_m2.diagonal();
    assert!((0..3).all(|i| near(chassis[i], BOX[i])), "{chassis}");
}

/// A tenth of m r^2 / 2 about the axle and correct moments across it: no permutation of the moments
/// fits, and no wheel has that. A third about it is also outside the tolerance; a wheel whose
/// length is its diameter (6 / 7) is not.
#[test]
fn a_moment_about_the_axle_that_lacks_a_power_of_ten_is_doubted() {
    let [across, along, _] = WHEEL;
    let said = |axial: f64| load(&text(BOX, [across, axial, across]), &LoadOptions::default()).1;
    for axial in [0.1 * along, across / 3.0] {
        let said = said(axial);
        assert!(said.contains("a power of ten be missing"), "{said}");
    }
    let even = said(6.0 / 7.0 * across);
    assert!(!even.contains("doubtful"), "{even}");
    let mut options = LoadOptions::default();
    options.repair = true;
    let (repaired, said) = load(&text(BOX, [across, 0.1 * along, across]), &options);
    let [axial, ..] = of_wheel(&repaired);
    assert!((axial / along - 1.0).abs() < 1e-3, "{axial} {said}");
}

/// A capsule of radius r about a line of length l is a cylinder with the two halves of a ball on its
/// ends: V = pi r^2 l + 4/3 pi r^3. A half's centre of mass is 3/8 r beyond the cylinder's end, so
/// that about its middle the ball's moment across is (2/5 r^2 + l^2 / 4 + 3/8 l r) m.
#[test]
fn a_capsule_without_inertia_is_given_that_of_a_capsule() {
    use std::f64::consts::PI;
    let (r, l, density): (f64, f64, f64) = (0.1, 0.3, 1500.0);
    let whole = text(BOX, WHEEL);
    let (head, rest) = whole.split_once("<inertial>").unwrap();
    let (_, wheels) = rest.split_once("</link>").unwrap();
    let capsule = format!(
        "<collision><origin xyz=\"0 0 0.2\"/><geometry><capsule radius=\"{r}\" length=\"{l}\"/></geometry></collision></link>"
    );
    let of = format!("{head}{capsule}{wheels}");
    let (robot, said) = load(&of, &common::options(|o| o.repair = true));
    let mass = &robot.chassis.mass;
    let (rod, ball) = (
        density * PI * r * r * l,
        density * 4.0 / 3.0 * PI * r.powi(3),
    );
    let axial = rod * r * r / 2.0 + ball * 0.4 * r * r;
    let across =
        rod * (r * r / 4.0 + l * l / 12.0) + ball * (0.4 * r * r + l * l / 4.0 + 3.0 / 8.0 * l * r);
    // A dozen operations round.
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
    assert!(near(mass.mass_kg, rod + ball), "{} {said}", mass.mass_kg);
    let moments = mass.inertia_kg_m2.diagonal();
    for (moment, expected) in moments.iter().zip([across, across, axial]) {
        assert!(near(*moment, expected), "{moments} {across} {axial}");
    }
}
