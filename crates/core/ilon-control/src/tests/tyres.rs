//! Robots on tyres.

use ilon_robot::{Robot, Roller};

use super::robots::{WheelSpec, mecanum4_specs, robot};

/// Tyres at these places, all on axles along y.
pub fn on_tyres(places_m: &[[f64; 2]]) -> Robot {
    let like = |[x_m, y_m]: &[f64; 2]| WheelSpec {
        x_m: *x_m,
        y_m: *y_m,
        gamma_rad: 0.0,
        ..mecanum4_specs(1.0)[0]
    };
    let specs: Vec<WheelSpec> = places_m.iter().map(like).collect();
    let mut robot = robot(10.0, &specs);
    for wheel in &mut robot.wheels {
        let tyre = Roller::tyre(&wheel.name, wheel.radius_m, 0.03, 0.004);
        wheel.rollers = vec![tyre.expect("a tyre")];
    }
    robot
}
