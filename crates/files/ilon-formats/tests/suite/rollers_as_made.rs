//! Real roller shapes, against closed-form geometry.
//!
//! Symbols as in `ilon_robot::barrel_profile`: rho the wheel's radius, a the ring's, k = cos gamma,
//! phi the angle of a roller from straight down. The roller's axis then has the component w = k
//! sin(phi) along "down", and a roller reaches a cos(phi) + h(w), h its own extent along w.

use std::f64::consts::{PI, TAU};

use ilon_formats::{LoadOptions, LoadRobot, RobotError, RollerForms, Spec, generate};
use ilon_robot::*;
use test_case::test_case;

/// A robot from a short description: four mecanum wheels or three omni wheels of radius 50 mm with
/// nine or eight rollers.
fn robot(gamma_deg: f64, rollers: &str) -> Result<Robot, RobotError> {
    Robot::from_urdf_str(&urdf(gamma_deg, rollers)?, "r.urdf")
}

/// Its URDF.
fn urdf(gamma_deg: f64, rollers: &str) -> Result<String, RobotError> {
    generate(&Spec::from_toml_str(
        &description(gamma_deg, rollers),
        "made.toml",
    )?)
}

fn description(gamma_deg: f64, rollers: &str) -> String {
    let wheels = if gamma_deg == 0.0 {
        "per_row = 8\n".to_owned()
    } else {
        "per_row = 9\n".to_owned()
    };
    let arrangement = if gamma_deg == 0.0 {
        "[wheels.ring]\ncount = 3\ndistance_m = 0.2\ngamma_deg = 0.0".to_owned()
    } else {
        format!(
            "[wheels.mecanum]\naxles_m = [0.15, -0.15]\nhalf_width_m = 0.16\ngamma_deg = {gamma_deg}"
        )
    };
    format!(
        "name = \"made\"\n[chassis]\nshape.box = {{ size_m = [0.4, 0.24, 0.1] }}\nmass_kg = 10.0\ncenter_m = [0.0, 0.0, 0.1]\n\
         [wheel]\nradius_m = 0.05\nhub_mass_kg = 0.25\nhub_radius_m = 0.03\nhub_width_m = 0.04\nmotor_effort_n_m = 1.0\n\
         motor_velocity_rad_s = 30.0\n[rollers]\n{wheels}radius_m = 0.012\nmass_kg = 0.01\n{rollers}\n{arrangement}\n"
    )
}

const RHO: f64 = 0.05;
const R: f64 = 0.012;
const A: f64 = RHO - R;

/// Error of a length by the file's fifteen digits, and by angles that its reader derives from them.
const DIGITS_M: f64 = 1e-12;

fn wheel(gamma_deg: f64, rollers: &str) -> Wheel {
    robot(gamma_deg, rollers).unwrap().wheels.remove(0)
}

/// Angles from straight down at which a roller is the lowest, over half of its range.
fn angles(count: usize) -> impl Iterator<Item = f64> {
    (-20..=20).map(move |i| PI / count as f64 * f64::from(i) / 20.0)
}

#[test]
fn the_default_is_the_ideal_barrel_bit_by_bit() {
    let plain = wheel(45.0, "");
    let said = wheel(45.0, "crown = 1.0\nradius_spread_m = 0.0\nradius_seed = 7");
    assert_eq!(plain.rollers, said.rollers);
    assert!(plain.is_round() && said.is_round());
    let mut made = plain.clone();
    made.make_rollers(RollersAsMade::default(), None).unwrap();
    assert_eq!(plain.rollers, made.rollers);
}

#[test]
fn a_crown_near_one_nears_the_ideal_barrel() {
    let height_m = |crown: f64| wheel(45.0, &format!("crown = {crown}")).hub_height_m(0.3);
    for off in [1e-3, 1e-6, 1e-9] {
        // A = k^2 ((r + a / k^2) / c - r), so that dA = -(k^2 r + a) dc, and the hub rises by dA
        // (1 - cos phi) at most.
        let phi = 0.3;
        let slope_m = (0.5 * R + A) * (1.0 - f64::cos(phi));
        let off_m = height_m(1.0 + off) - RHO;
        assert!(
            (off_m + slope_m * off).abs() < slope_m * off * off * 2.0 + DIGITS_M,
            "{off_m:e}"
        );
    }
}

#[test]
fn a_crown_moves_the_hub_by_the_difference_of_the_circles() {
    // Of s(t) = R - sqrt(A^2 + k^2 t^2) the sphere that reaches furthest is that at k t = A
    // tan(phi), and a cos(phi) + k t sin(phi) + s = R - (A - a) cos(phi) = rho + (A - a) (1 -
    // cos(phi)), as far as tan(phi) <= k L / 2 A.
    for (gamma_deg, count) in [(45.0_f64, 9), (0.0, 8)] {
        for crown in [0.3, 0.8, 1.5] {
            let wheel = wheel(gamma_deg, &format!("crown = {crown}"));
            let k2 = f64::cos(gamma_deg.to_radians()).powi(2);
            let crown_radius_m = (R + A / k2) / crown;
            let a_made = k2 * (crown_radius_m - R);
            assert!(
                (wheel.barrel(&wheel.rollers[0]).crown_radius_m() - crown_radius_m).abs()
                    < DIGITS_M
            );
            let half_m = 0.5 * wheel.rollers[0].length_m;
            let ends = f64::atan2(k2.sqrt() * half_m, a_made);
            for phi in angles(count).filter(|phi| phi.abs() < ends) {
                let exact_m = RHO + (a_made - A) * (1.0 - phi.cos());
                assert!(
                    (wheel.hub_height_m(phi) - exact_m).abs() < DIGITS_M,
                    "{crown} {phi}"
                );
            }
            assert!(!wheel.is_round());
        }
    }
}

#[test]
fn over_a_gap_the_wheel_stands_on_the_end_of_a_roller() {
    // The end sphere's middle is H = sqrt(a^2 + (k L / 2)^2) from the hub axis at psi = atan(k L /
    // 2 a) from the roller's, and its radius is rho - H: at phi the hub is rho - H + H cos(phi -
    // psi) high.
    for (gamma_deg, count) in [(45.0_f64, 9), (0.0, 8)] {
        let wheel = wheel(gamma_deg, "length_factor = 0.7");
        let k = gamma_deg.to_radians().cos();
        let half_m = 0.7 * A * (PI / count as f64).tan() / k;
        assert!((0.5 * wheel.rollers[0].length_m - half_m).abs() < DIGITS_M);
        let (far_m, psi) = (f64::hypot(A, k * half_m), f64::atan2(k * half_m, A));
        for phi in angles(count) {
            let beyond = (phi.abs() - psi).max(0.0);
            let exact_m = RHO - far_m * (1.0 - beyond.cos());
            assert!(
                (wheel.hub_height_m(phi) - exact_m).abs() < DIGITS_M,
                "{phi}"
            );
        }
        let drop_m = far_m * (1.0 - (PI / count as f64 - psi).cos());
        let lowest_m = wheel.hub_height_m(PI / count as f64);
        assert!((RHO - lowest_m - drop_m).abs() < DIGITS_M && drop_m > 1e-4);
    }
}

#[test]
fn a_wheel_of_cylinders_stands_on_their_edges() {
    // A cylinder of half length l with edges of radius c: corners at l - c, r - c. At phi the lower
    // one reaches a cos(phi) + (l - c) w + (r - c) sqrt(1 - w^2) + c.
    let (half_m, c) = (0.012, 0.001);
    for (gamma_deg, count) in [(45.0_f64, 9), (0.0, 8)] {
        let profile =
            format!("profile_m = [[-{half_m}, {R}], [{half_m}, {R}]]\nedge_radius_m = {c}");
        let wheel = wheel(gamma_deg, &profile);
        let k = gamma_deg.to_radians().cos();
        for phi in angles(count) {
            let w = k * phi.sin().abs();
            let exact_m = A * phi.cos() + (half_m - c) * w + (R - c) * (1.0 - w * w).sqrt() + c;
            assert!(
                (wheel.hub_height_m(phi) - exact_m).abs() < DIGITS_M,
                "{phi}"
            );
        }
        // Flat on the floor in the middle, and there as high as the ideal wheel.
        assert!((wheel.hub_height_m(0.0) - RHO).abs() < DIGITS_M);
    }
}

#[test]
fn unequal_rollers_repeat_with_the_turn_of_the_wheel() {
    let spread_m = 2e-4;
    let wheel = wheel(
        45.0,
        &format!("radius_spread_m = {spread_m}\nradius_seed = 3"),
    );
    let radii_m: Vec<f64> = wheel.rollers.iter().map(|r| r.radius_m - R).collect();
    assert!(radii_m.iter().all(|off| off.abs() <= spread_m));
    let distinct = radii_m
        .iter()
        .map(|off| (off * 1e12) as i64)
        .collect::<std::collections::HashSet<_>>();
    assert_eq!(distinct.len(), 9, "{radii_m:?}");
    // With a roller straight down the hub is higher by that roller's excess thickness.
    for (roller, off_m) in wheel.rollers.iter().zip(&radii_m) {
        let height_m = wheel.hub_height_m(-roller.place_rad());
        assert!((height_m - RHO - off_m).abs() < DIGITS_M);
        let again_m = wheel.hub_height_m(TAU - roller.place_rad());
        assert!((height_m - again_m).abs() < DIGITS_M);
    }
}

#[test]
fn draws_are_even_over_the_tolerance_and_follow_seed_and_name() {
    let mut made = RollersAsMade {
        radius_spread_m: 1.0,
        ..RollersAsMade::default()
    };
    let draws: Vec<f64> = (0..4000)
        .map(|i| made.radius_offset_m(&format!("wheel_{}_roller_{}", i / 50, i % 50)))
        .collect();
    let mean = draws.iter().sum::<f64>() / 4000.0;
    let variance = draws.iter().map(|x| x * x).sum::<f64>() / 4000.0;
    // Uniform draws have variance 1/3 and fourth moment 1/5: their means are off by 1/sqrt(3 n) and
    // sqrt(4/45 n); four of these.
    assert!(mean.abs() < 4.0 / (3.0 * 4000.0_f64).sqrt(), "{mean}");
    assert!(
        (variance - 1.0 / 3.0).abs() < 4.0 * (4.0 / 45.0 / 4000.0_f64).sqrt(),
        "{variance}"
    );
    let before = made.radius_offset_m("a");
    made.radius_seed = 1;
    assert_ne!(before, made.radius_offset_m("a"));
    made.radius_offsets_m.insert("a".into(), 0.25);
    assert_eq!(made.radius_offset_m("a"), 0.25);
}

#[test]
fn what_a_description_says_of_its_rollers_goes_through_the_file() {
    let wheel = wheel(
        45.0,
        "crown = 0.8\nlength_factor = 0.9\nradius_spread_m = 1e-4\nradius_seed = 5\n\
         radius_offsets_m = { front_left_roller_2 = 5e-4 }",
    );
    let mut expected = RollersAsMade::default();
    (
        expected.crown,
        expected.radius_spread_m,
        expected.radius_seed,
    ) = (0.8, 1e-4, 5);
    expected
        .radius_offsets_m
        .insert("front_left_roller_2".into(), 5e-4);
    assert_eq!(wheel.made, expected);
    let second = wheel
        .rollers
        .iter()
        .find(|r| r.name == "front_left_roller_2")
        .unwrap();
    assert!((second.radius_m - R - 5e-4).abs() < DIGITS_M);
    // Applied again with the same values, nothing changes except by rounding.
    let mut again = wheel.clone();
    again.make_rollers(wheel.made.clone(), None).unwrap();
    for (a, b) in wheel.rollers.iter().zip(&again.rollers) {
        assert!((a.radius_m - b.radius_m).abs() < DIGITS_M);
        assert!((a.axial_inertia_kg_m2 / b.axial_inertia_kg_m2 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_robot_with_gaps_stands_on_what_is_lowest() {
    // Four wheels with a roller straight down at wheel angle zero stand on the middles of these
    // rollers.
    let mecanum = robot(45.0, "length_factor = 0.7").unwrap();
    let stands = mecanum.standing_pose().unwrap();
    assert!((stands.height_m).abs() < 1e-9, "{}", stands.height_m);
    // Thicker ones lift it.
    let thicker = "profile_m = [[-0.01, 0.013], [0.01, 0.013]]";
    let stands = robot(45.0, thicker).unwrap().standing_pose().unwrap();
    assert!(
        (stands.height_m - 0.001).abs() < 1e-9,
        "{}",
        stands.height_m
    );
}

#[test]
fn rollers_that_cannot_be_made_are_refused_by_their_keys() {
    for (rollers, key) in [
        ("crown = 0.0", "crown"),
        ("crown = -1.0", "crown"),
        ("crown = nan", "crown"),
        ("crown = 20.0", "crown"),
        ("length_factor = 0.0", "length_factor"),
        ("length_factor = -0.5", "length_factor"),
        ("radius_spread_m = -1e-4", "radius_spread_m"),
        ("radius_spread_m = 0.02", "radius_spread_m"),
        ("radius_offsets_m = { nobody = 1e-4 }", "radius_offsets_m"),
        (
            "radius_offsets_m = { front_left_roller_1 = -0.02 }",
            "radius_offsets_m",
        ),
        ("profile_m = []", "profile_m"),
        ("profile_m = [[0.0, 0.01]]", "profile_m"),
        ("profile_m = [[-12.0, 12.0], [12.0, 12.0]]", "profile_m"),
        (
            "profile_m = [[-0.01, 0.012], [0.0, 0.01], [0.01, 0.012]]",
            "profile_m",
        ),
        (
            "profile_m = [[-0.01, 0.012], [0.01, 0.012]]\ncrown = 0.5",
            "crown",
        ),
        (
            "profile_m = [[-0.01, 0.012], [0.01, 0.012]]\nlength_factor = 0.5",
            "length_factor",
        ),
        (
            "profile_m = [[-0.01, 0.012], [0.01, 0.012]]\nedge_radius_m = 0.02",
            "profile_m",
        ),
        ("edge_radius_m = 0.001", "edge_radius_m"),
    ] {
        let error = robot(45.0, rollers).unwrap_err().to_string();
        assert!(error.contains(key), "{rollers}: {error}");
    }
}

#[test]
fn elements_of_a_file_that_make_no_rollers_are_refused_where_they_stand() {
    let text = |attributes: &str| {
        let spec = include_str!("../../../../../assets/robots/mecanum4.toml");
        let spec = Spec::from_toml_str(spec, "mecanum4.toml").unwrap();
        let element = format!("<ilon_rollers joint=\"front_left\" {attributes}</robot>");
        generate(&spec).unwrap().replace("</robot>", &element)
    };
    for attributes in [
        "profile=\"1 2 3\"/>",
        "profile=\"a b\"/>",
        "profile=\"\"/>",
        "crown=\"1e-9\"/>",
        "crown=\"nan\"/>",
        "radius_seed=\"-1\"/>",
        "length_factor=\"50\"/>",
        "><roller joint=\"nobody\" radius_offset=\"0.1\"/></ilon_rollers>",
        "><roller joint=\"front_left_roller_1\"/></ilon_rollers>",
        "><roller joint=\"front_left_roller_1\" radius_offset=\"1\"/></ilon_rollers>",
    ] {
        let error = Robot::from_urdf_str(&text(attributes), "r.urdf").unwrap_err();
        assert!(error.to_string().contains(':'), "{attributes}: {error}");
    }
    assert!(Robot::from_urdf_str(&text("crown=\"0.9\"/>"), "r.urdf").is_ok());
}

/// Tools that know only URDF roll on the solids of the links: these raise and lower the hub as the
/// rollers that are made do. Between two of seven spheres their envelope lacks at most an eighth of
/// the second difference of their radii.
#[test_case("crown = 0.8", 0.0)]
#[test_case("crown = 1.5", 0.0)]
#[test_case("length_factor = 0.7", 0.0)]
#[test_case("length_factor = 1.2\ncrown = 0.8", 0.0)]
#[test_case(
    "length_factor = 0.9\ncrown = 0.8\nradius_offsets_m = { front_left_roller_2 = 5e-4 }",
    0.0
)]
// Equal cylinders end to end are the one cylinder.
#[test_case("profile_m = [[-0.01, 0.013], [0.01, 0.013]]", 1e-9)]
fn links_of_made_rollers_have_their_shapes(rollers: &str, bound_m: f64) {
    let text = urdf(45.0, rollers).unwrap();
    let wheel = Robot::from_urdf_str(&text, "r.urdf")
        .unwrap()
        .wheels
        .remove(0);
    let mut options = LoadOptions::default();
    options.rollers = RollerForms::AsModelled;
    let shown = Robot::from_urdf_str_with(&text, "r.urdf", &options).unwrap();
    let shown = &shown.robot.wheels[0];
    let barrel = wheel.barrel(&wheel.rollers[0]);
    let radius_m = |i: usize| barrel.sphere_radius_m((i as f64 / 3.0 - 1.0) * barrel.half_length_m);
    let bend_m = |i: usize| (radius_m(i - 1) + radius_m(i + 1) - 2.0 * radius_m(i)).abs();
    let lacks_m = (1..6).map(bend_m).fold(0.0, f64::max) / 8.0;
    let bound_m = if bound_m > 0.0 {
        bound_m
    } else {
        lacks_m + 1e-9
    };
    for i in 0..400 {
        let turned_rad = TAU * f64::from(i) / 400.0;
        let (made_m, shown_m) = (
            wheel.hub_height_m(turned_rad),
            shown.hub_height_m(turned_rad),
        );
        assert!(
            (made_m - shown_m).abs() < bound_m,
            "{turned_rad}: {made_m} {shown_m} {bound_m}"
        );
    }
    // What is read is what the description builds.
    let spec = Spec::from_toml_str(&description(45.0, rollers), "made.toml").unwrap();
    let built = ilon_formats::build(&spec).unwrap();
    for (read, built) in wheel.rollers.iter().zip(&built.wheels[0].rollers) {
        assert!(
            (read.length_m - built.length_m).abs() < DIGITS_M,
            "{read:?}"
        );
        assert!(
            (read.radius_m - built.radius_m).abs() < DIGITS_M,
            "{read:?}"
        );
    }
    // The file's moments are those of what is made.
    let (a, b) = (&wheel.rollers[0], &shown.rollers[0]);
    assert!((a.axial_inertia_kg_m2 / b.axial_inertia_kg_m2 - 1.0).abs() < 1e-12);
}
