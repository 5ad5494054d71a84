//! Rollers of other shapes. The small robot: rho 50 mm, r 12 mm, a 38 mm, eight rollers, gamma 0.

use std::f64::consts::{FRAC_PI_4, PI};

use super::{fault_of, load, remarked, with_roller_collision};
use crate::traits::common::{SPEC, options, small};
use ilon_formats::{Fault, LoadOptions, LoadRobot, RollerForms, Spec, generate};
use ilon_robot::{Robot, RollerForm};
use nalgebra::Vector3;
use test_case::test_case;

#[test]
fn a_lone_sphere_is_a_barrel_that_reaches_its_neighbours() {
    let robot = load(&with_roller_collision(
        &small(),
        r#"<collision><geometry><sphere radius="0.012"/></geometry></collision>"#,
    ));
    for roller in &robot.wheels[0].rollers {
        assert!((roller.radius_m - 0.012).abs() < 1e-15);
        // L = 2 a tan(pi / 8).
        assert!((roller.length_m - 2.0 * 0.038 * (PI / 8.0).tan()).abs() < 1e-14);
    }
    // Between two spheres the hub sinks to a cos(pi/8) + r: by 38 (1 - cos(pi/8)) = 2.89 mm.
    assert!(remarked(&robot, "wheel `wheel_1`", "dip 2.89 mm"));
}

#[test]
fn a_capsule_spans_the_centres_of_its_ends() {
    let robot = load(&with_roller_collision(
        &small(),
        r#"<collision><geometry><capsule radius="0.012" length="0.032"/></geometry></collision>"#,
    ));
    assert!((robot.wheels[0].radius_m - 0.05).abs() < 1e-15);
    for roller in &robot.wheels[0].rollers {
        assert!((roller.length_m - 0.032).abs() < 1e-15);
    }
}

#[test]
fn taken_as_modelled_rollers_keep_the_shapes_of_their_file_gaps_and_all() {
    // Short cylinders with gaps between them, and a ball off the middle of each: as barrels they
    // would be refused.
    let text = with_roller_collision(
        &small(),
        r#"<collision><geometry><cylinder radius="0.012" length="0.01"/></geometry></collision>
        <collision><origin xyz="0 0 0.004"/><geometry><sphere radius="0.01"/></geometry></collision>"#,
    );
    assert!(matches!(fault_of(&text), Fault::RollersHaveGaps { .. }));
    let options = options(|o| {
        o.rollers = RollerForms::AsModelled;
    });
    let loaded = Robot::from_urdf_str_with(&text, "short.urdf", &options).expect("as it is");
    // Between the ends of two cylinders, L/2 = 5 mm beside their middles at a = 50 mm, which are pi/4
    // apart, the hub falls by hypot(a, L/2) (1 - cos(pi/8 - atan(L/2 / a))) = 2.14 mm.
    assert!((loaded.outlines[0].ripple_m - 2.14e-3).abs() < 1e-5);
    let wheel = &loaded.robot.wheels[0];
    for roller in &wheel.rollers {
        let RollerForm::AsModelled(modelled) = &roller.form else {
            panic!("{:?}", roller.form);
        };
        // Along its axis, in both directions: the cylinder to 5 mm, the ball to 14 mm on its side.
        let reach = |z: f64| {
            let reaches = modelled
                .shapes
                .iter()
                .map(|s| s.reach_m(&Vector3::new(0.0, 0.0, z)));
            reaches.fold(f64::NEG_INFINITY, f64::max)
        };
        let mut ends = [reach(1.0), reach(-1.0)];
        ends.sort_by(f64::total_cmp);
        // The file's rotations are written with about ten digits.
        assert!(
            (ends[0] - 0.006).abs() < 1e-8 && (ends[1] - 0.014).abs() < 1e-8,
            "{ends:?}"
        );
        // The profile agrees.
        assert!((modelled.profile.support_m(1.0) - reach(1.0)).abs() < 1e-8);
        assert!((modelled.profile.support_m(-1.0) - reach(-1.0)).abs() < 1e-8);
        // Across the axis it is as thick as the cylinder.
        assert!((modelled.profile.support_m(0.0) - 0.012).abs() < 1e-15);
    }
    // A roller points straight down: the wheel stands on its cylinder.
    assert!(
        (wheel.reach_at_rest_m() - 0.05).abs() < 1e-6,
        "{}",
        wheel.reach_at_rest_m()
    );
}

#[test_case(r#"<cylinder radius="0.012" length="0.0383"/>"#; "cylinder")]
#[test_case(r#"<box size="0.024 0.024 0.0383"/>"#; "square box")]
fn a_roller_that_is_cut_flat_ends_where_its_last_sphere_touches(geometry: &str) {
    let robot = load(&with_roller_collision(
        &small(),
        &format!("<collision><geometry>{geometry}</geometry></collision>"),
    ));
    assert!((robot.wheels[0].radius_m - 0.05).abs() < 1e-15);
    for roller in &robot.wheels[0].rollers {
        // With gamma = 0 the sphere at t = a tan(phi) touches at t + s sin(phi) = rho sin(phi): the
        // cut at 19.15 mm is touched at phi = asin(19.15 / 50).
        let phi = (0.01915f64 / 0.05).asin();
        assert!((roller.length_m - 2.0 * 0.038 * phi.tan()).abs() < 1e-12);
    }
}

#[test]
fn a_cylinder_across_its_axis_is_no_roller() {
    let text = with_roller_collision(
        &small(),
        r#"<collision><origin rpy="1.57 0 0"/><geometry><cylinder radius="0.012" length="0.04"/></geometry></collision>"#,
    );
    assert_eq!(fault_of(&text), Fault::RollerNotRound);
}

#[test]
fn a_stack_of_cylinders_is_fitted_as_the_barrel_that_it_stands_for() {
    // The surface of the barrel in 41 discs of 1 mm (see `barrel_rings_mm` for its shape).
    let discs: String = (-20..=20)
        .map(|i| {
            let z: f64 = 0.019 * f64::from(i) / 20.0;
            let r = (0.05f64.powi(2) - z * z).sqrt() - 0.038;
            format!(
                "<collision><origin xyz=\"0 0 {z}\"/><geometry><cylinder radius=\"{r}\" length=\"1e-4\"/></geometry></collision>"
            )
        })
        .collect();
    let robot = load(&with_roller_collision(&small(), &discs));
    // A disc of half-width 50 um is tilted over by that times the slope of the surface, 0.4 at
    // most, and the chords between discs fall short by 1.3 um.
    assert!(
        (robot.wheels[0].radius_m - 0.05).abs() < 2e-5,
        "{}",
        robot.wheels[0].radius_m
    );
}

#[test]
fn rollers_of_the_common_length_overlap_by_what_geometry_says() {
    // Nine rollers at 45 deg, rho 50 mm, a 38 mm. The common L = 2 rho sin(pi/n) / sin(delta)
    // reaches atan(L/2 sin(delta) / a) = atan(50 sin(20 deg) / 38) = 24.23 deg to each side of
    // pitches of 40 deg: 8.46 deg of each, 76.1 deg of a turn.
    let spec = SPEC
        .split("[wheels.ring]")
        .next()
        .expect("a description")
        .replace("per_row = 8", "per_row = 9")
        + "[wheels.mecanum]\naxles_m = [0.2, -0.2]\nhalf_width_m = 0.25\ngamma_deg = 45.0\n";
    let text =
        generate(&Spec::from_toml_str(&spec, "mecanum.toml").expect("good")).expect("in range");
    let length_m = 2.0 * 0.05 * (PI / 9.0).sin() / FRAC_PI_4.sin();
    let capsule = format!(
        "<collision><geometry><capsule radius=\"0.012\" length=\"{length_m}\"/></geometry></collision>"
    );
    let loaded = Robot::from_urdf_str_with(
        &with_roller_collision(&text, &capsule),
        "m.urdf",
        &LoadOptions::default(),
    )
    .unwrap_or_else(|e| panic!("{e}"));
    assert!(remarked(
        &loaded.robot,
        "wheel `rear_left`",
        "over 76.1 deg of each turn (21.1 %) two rollers touch"
    ));
    // A capsule protrudes where the barrel tapers: the centre of its end is hypot(a, L/2 cos(45
    // deg)) from the hub axis. Samples a tenth of a degree apart miss the peak by 54 mm (0.05
    // deg)^2 / 2 = 2e-8 m at most.
    let peak_m = 0.038f64.hypot(0.5 * length_m * FRAC_PI_4.cos()) + 0.012;
    assert!((loaded.outlines[0].peak_radius_m - peak_m).abs() < 3e-8);
    assert!(remarked(
        &loaded.robot,
        "wheel `rear_left`",
        "rolls on a radius of 53.25 mm"
    ));
}
