//! Random robots, and what else the property tests draw.

use std::f64::consts::PI;

use ilon_control::Kinematics;
use ilon_robot::Robot;
use proptest::prelude::*;

use crate::paper::fixtures::{WheelSpec, robot};

/// Settings of a property test: `cases` cases, always the same ones, nothing written to disk.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(20_090_202),
        ..ProptestConfig::default()
    }
}

/// Three to eight wheels anywhere within half a metre, hub axes any way, |gamma| up to 75 deg of
/// either sign, each wheel with its own radius and gamma; the arrangement may be singular.
pub fn any_wheels() -> impl Strategy<Value = Vec<WheelSpec>> {
    let wheel = (
        -0.5..0.5,
        -0.5..0.5,
        -PI..PI,
        -75.0_f64..75.0,
        0.03..0.15,
        6_usize..12,
    )
        .prop_map(
            |(x_m, y_m, axis_rad, gamma_deg, radius_m, rollers)| WheelSpec {
                radius_m,
                ..WheelSpec::new(x_m, y_m, axis_rad, gamma_deg.to_radians(), rollers)
            },
        );
    prop::collection::vec(wheel, 3..=8)
}

/// A robot with such wheels that can be driven: the ratio of M's extreme singular values stays
/// below 100, so that rounding errors of 1e-16 stay below 1e-13 in what is solved for.
pub fn any_robot() -> impl Strategy<Value = (Robot, Kinematics)> {
    any_wheels().prop_filter_map("badly conditioned", |wheels| {
        let robot = robot(10.0, &wheels);
        let kinematics = Kinematics::new(&robot).ok()?;
        let s = kinematics.m().clone().svd(false, false).singular_values;
        (s.min() > 0.01 * s.max()).then_some((robot, kinematics))
    })
}
