//! How gamma, the number of rollers and the places of the wheels affect the condition of M and the
//! top speeds, for three, four and six wheels. Prints a table for each choice.

use ilon::control::{self, Kinematics, SpeedLimits};
use ilon::formats::LoadRobot;
use ilon::formats::{Arrangement, PlacedWheel, Spec, generate};
use ilon::robot::Robot;

/// Largest wheel rate; chosen.
const WHEEL_RATE_RAD_S: f64 = 10.0;

type Fault = Box<dyn std::error::Error>;

/// The smallest singular value of M of a robot A with other wheel places and another number of
/// rollers; prints its condition and top speeds.
fn tell(choice: &str, x: f64, wheels: Arrangement, rollers: usize) -> Result<f64, Fault> {
    let mut spec = Spec::load("assets/robots/mecanum4.toml")?;
    spec.wheels = wheels;
    spec.rollers.per_row = rollers;
    let robot = Robot::from_urdf_str(&generate(&spec)?, "varied")?;
    let of = control::Arrangement::of(&robot)?;
    let speeds = match Kinematics::new(&robot) {
        Ok(kinematics) => {
            let limits = SpeedLimits::uniform(&kinematics, WHEEL_RATE_RAD_S);
            let (slowest, fastest) = limits.top_speed_range_m_s();
            format!("{slowest:.3} to {fastest:.3} m/s")
        }
        Err(why) => why.to_string(),
    };
    println!("{choice} {x:7.2}: condition {:8.2}, {speeds}", of.condition);
    Ok(of.singular_values[2])
}

fn ring(count: usize, gamma_deg: f64) -> Arrangement {
    Arrangement::Ring {
        count,
        distance_m: 0.25,
        first_deg: 0.0,
        gamma_deg,
    }
}

fn mecanum(axles_m: &[f64], half_width_m: f64, gamma_deg: f64) -> Arrangement {
    Arrangement::Mecanum {
        axles_m: axles_m.to_vec(),
        half_width_m,
        gamma_deg,
    }
}

fn main() -> Result<(), Fault> {
    let four = |gamma_deg| mecanum(&[0.15, -0.15], 0.16, gamma_deg);
    for gamma_deg in [15.0, 30.0, 45.0, 60.0, 75.0] {
        tell(
            "three on a ring, gamma in deg",
            gamma_deg,
            ring(3, gamma_deg),
            9,
        )?;
        tell(
            "four, mecanum, gamma in deg  ",
            gamma_deg,
            four(gamma_deg),
            9,
        )?;
    }
    // The number of rollers moves nothing of M.
    let counts = [6, 9, 12, 18];
    let least = counts.map(|count| tell("four, rollers a wheel", count as f64, four(45.0), count));
    let least = least.into_iter().collect::<Result<Vec<_>, _>>()?;
    assert!(least.iter().all(|s| (s - least[0]).abs() < 1e-6));
    // Handed in the usual X, only the sum of both half distances counts. Handed the other way the
    // difference does: the square robot cannot control its rotation.
    let mut worst = f64::INFINITY;
    for half_m in [0.05, 0.10, 0.155, 0.20, 0.25] {
        let usual = mecanum(&[half_m, -half_m], 0.31 - half_m, 45.0);
        tell("handed in X, half length in m      ", half_m, usual, 9)?;
        let least = tell(
            "handed the other way, half length in m",
            half_m,
            wrong_handed(half_m),
            9,
        )?;
        worst = worst.min(least);
    }
    assert!(worst < 0.02, "{worst}");
    // At 120 deg every direction is alike.
    for angle_deg in [100.0, 120.0, 140.0, 160.0] {
        tell(
            "three wheels, rear ones at deg",
            angle_deg,
            spread(angle_deg),
            9,
        )?;
    }
    // The middle axle is handed like the one that it is nearer to.
    for x_m in [-0.2, -0.1, 0.0, 0.1, 0.2] {
        tell(
            "six wheels, x of the middle axle in m",
            x_m,
            mecanum(&[0.25, x_m, -0.25], 0.16, 45.0),
            9,
        )?;
    }
    Ok(())
}

/// Four mecanum wheels with left and right ones exchanged.
fn wrong_handed(half_m: f64) -> Arrangement {
    let wheels = mecanum(&[half_m, -half_m], 0.31 - half_m, 45.0).placed();
    let exchanged = wheels.into_iter().map(|wheel| PlacedWheel {
        gamma_deg: -wheel.gamma_deg,
        ..wheel
    });
    Arrangement::List(exchanged.collect())
}

/// Three wheels on a ring: one ahead, two at an angle on either side.
fn spread(angle_deg: f64) -> Arrangement {
    let wheel = |name: &str, at_deg: f64| {
        let (sin, cos) = at_deg.to_radians().sin_cos();
        PlacedWheel {
            name: name.to_owned(),
            position_m: [0.25 * cos, 0.25 * sin],
            axis_deg: at_deg,
            gamma_deg: 0.0,
        }
    };
    Arrangement::List(vec![
        wheel("ahead", 0.0),
        wheel("left", angle_deg),
        wheel("right", -angle_deg),
    ])
}
