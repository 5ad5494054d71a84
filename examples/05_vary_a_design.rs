//! The speeds that the shipped robots' wheels allow, and how gamma, the number of rollers and the
//! places of the wheels affect them, for three, four and six wheels. Writes `target/design.html`.

use ilon::control::{Kinematics, SpeedLimits};
use ilon::formats::LoadRobot;
use ilon::formats::{Arrangement, PlacedWheel, Spec, generate};
use ilon::pages::design::{self, Curve, Merits, Reach, Study};
use ilon::robot::Robot;

/// Largest wheel rate; chosen.
const WHEEL_RATE_RAD_S: f64 = 10.0;

type Fault = Box<dyn std::error::Error>;

/// Robot A's chassis, wheels and rollers with other wheel places and another number of rollers.
fn merits(wheels: Arrangement, rollers: usize) -> Result<Merits, Fault> {
    let mut spec = Spec::load("assets/robots/mecanum4.toml")?;
    spec.wheels = wheels;
    spec.rollers.per_row = rollers;
    let robot = Robot::from_urdf_str(&generate(&spec)?, "varied")?;
    Ok(Merits::of(&robot, WHEEL_RATE_RAD_S))
}

fn curve(
    name: &str,
    numbers: impl IntoIterator<Item = f64>,
    robot: impl Fn(f64) -> Result<Merits, Fault>,
) -> Result<Curve, Fault> {
    let points = numbers.into_iter().map(|x| Ok((x, robot(x)?)));
    Ok(Curve {
        name: name.to_owned(),
        points: points.collect::<Result<_, Fault>>()?,
    })
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

const FOUR: [f64; 2] = [0.15, -0.15];
const SIX: [f64; 3] = [0.25, 0.0, -0.25];

fn main() -> Result<(), Fault> {
    let degrees = || (1..=30).map(|k| 2.5 * f64::from(k));
    let gamma = Study {
        id: "gamma",
        title: "The angle gamma",
        lead: "From rollers across the wheel (0 deg) towards rollers along its way (90 deg). Mecanum wheels on parallel axles \
               need an angle: at 0 deg all roller axes are parallel, and nothing resists sideways motion. Towards 90 deg \
               the wheels' top speeds fall with cos gamma, or the sideways one does."
            .to_owned(),
        x_title: "|gamma| in deg".to_owned(),
        curves: vec![
            curve("three on a ring", degrees(), |g| merits(ring(3, g), 9))?,
            curve("four, mecanum", degrees(), |g| merits(mecanum(&FOUR, 0.16, g), 9))?,
            curve("six, mecanum", degrees(), |g| merits(mecanum(&SIX, 0.16, g), 9))?,
        ],
    };
    let counts = || (6..=18).map(f64::from);
    let rollers = Study {
        id: "rollers",
        title: "The number of rollers",
        lead: "It moves nothing of M. What it moves is how far the touching roller tilts before the next one takes over: \
               few rollers at 45 deg fall short sideways, and ripple; at 0 deg they do neither."
            .to_owned(),
        x_title: "rollers a wheel".to_owned(),
        curves: vec![
            curve("three on a ring, 0 deg", counts(), |n| merits(ring(3, 0.0), n as usize))?,
            curve("four, mecanum", counts(), |n| merits(mecanum(&FOUR, 0.16, 45.0), n as usize))?,
            curve("six, mecanum", counts(), |n| merits(mecanum(&SIX, 0.16, 45.0), n as usize))?,
        ],
    };
    let halves_m = || (1..=29).map(|k| 0.01 * f64::from(k));
    let four = Study {
        id: "four",
        title: "Four wheels: long or wide",
        lead: "Half the distance of the axles, the sum of both half distances held at 0.31 m. Handed in the usual X, only the \
               sum counts. Handed the other way the difference does: the square robot cannot control its rotation."
            .to_owned(),
        x_title: "half the distance of the axles in m".to_owned(),
        curves: vec![
            curve("handed in X", halves_m(), |x| merits(mecanum(&[x, -x], 0.31 - x, 45.0), 9))?,
            curve("handed the other way", halves_m(), |x| merits(wrong_handed(x), 9))?,
        ],
    };
    let angles = || (0..=32).map(|k| 95.0 + 2.5 * f64::from(k));
    let three = Study {
        id: "three",
        title: "Three wheels: how the ring is spread",
        lead: "One wheel ahead, the two others at this angle to its sides, hub axes outward, gamma 0. At 120 deg every \
               direction is alike and the robot is decoupled about its middle."
            .to_owned(),
        x_title: "angle of the rear wheels in deg".to_owned(),
        curves: vec![curve("three wheels", angles(), |a| merits(spread(a), 9))?],
    };
    let places_m = || (0..=40).map(|k| 0.01 * f64::from(k) - 0.2);
    let six = Study {
        id: "six",
        title: "Six wheels: where the middle axle sits",
        lead: "Axles at 0.25 m and -0.25 m, the third between them. It is handed like the one that it is nearer to, so that two \
               of three axles pull the decoupling point their way."
            .to_owned(),
        x_title: "x of the middle axle in m".to_owned(),
        curves: vec![curve("six wheels", places_m(), |x| {
            merits(mecanum(&[0.25, x, -0.25], 0.16, 45.0), 9)
        })?],
    };

    // The page's statements as assertions: the number of rollers does not affect M, and Lemma 1
    // refuses a square robot with its wheels on the wrong sides.
    let values = |curve: &Curve| {
        curve
            .points
            .iter()
            .map(|(_, m)| m.singular_values[2])
            .collect::<Vec<_>>()
    };
    for of_count in &rollers.curves {
        let values = values(of_count);
        assert!(values.iter().all(|s| (s - values[0]).abs() < 1e-6));
    }
    let worst = values(&four.curves[1])
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    assert!(worst < 0.02, "{worst}");

    // The paper's experiment limits its robot's wheels to 8.7 rad/s; the others have their motors'
    // limits.
    let reach = |name: &str, limit_rad_s: Option<f64>| -> Result<Reach, Fault> {
        let robot = Robot::load(format!("assets/robots/{name}.urdf"))?;
        let limit_rad_s = limit_rad_s.unwrap_or(robot.wheel_rate_limit_rad_s());
        Ok(Reach {
            name: name.to_owned(),
            limits: SpeedLimits::uniform(&Kinematics::new(&robot)?, limit_rad_s),
        })
    };
    let reaches = [
        reach("volksbot", Some(8.7))?,
        reach("mecanum4", None)?,
        reach("mecanum6", None)?,
    ];
    let studies = [gamma, rollers, four, three, six];
    let path = std::path::Path::new("target/design.html");
    design::write(path, "What a design choice moves", &reaches, &studies)?;
    println!("written to {}", path.display());
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
