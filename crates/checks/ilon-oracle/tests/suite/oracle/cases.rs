//! The cases: transients in which rollers slide, coasting, a locked wheel, and steady drives.

use ilon_robot::Twist;
use nalgebra::Vector3;

use crate::oracle::case::{Case, Shove, Wheels, ramp, robot};

/// A start within `ramp_s` that demands more than the floor's grip.
pub fn start(name: &str, end: Twist, ramp_s: f64, friction: f64, duration_s: f64) -> Case {
    let target = ramp(end, 0.2, ramp_s);
    Case::new(name, robot("mecanum4"), friction, duration_s, move |t_s| {
        Wheels::Follow(target(t_s))
    })
}

/// A gentle start over 0.8 s; at 1.2 s all wheels are commanded to stop at once.
pub fn emergency_stop(name: &str, from: Twist, friction: f64) -> Case {
    let target = ramp(from, 0.2, 0.8);
    Case::new(name, robot("mecanum4"), friction, 1.9, move |t_s| {
        Wheels::Follow(if t_s < 1.2 {
            target(t_s)
        } else {
            Twist::default()
        })
    })
}

/// 60 N for 0.3 s on the chassis's centre of mass, at an angle to the left of straight ahead,
/// wheels held at rest.
pub fn push(name: &str, robot_name: &str, angle_deg: f64, friction: f64) -> Case {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let mut case = Case::new(name, robot(robot_name), friction, 1.0, |_| {
        Wheels::Follow(Twist::default())
    });
    case.shove = Some(Shove {
        force_in_world_n: 60.0 * Vector3::new(cos, sin, 0.0),
        from_s: 0.2,
        until_s: 0.5,
    });
    case
}

/// When the wheels of [`coasting`] become free, in seconds.
pub const COASTS_FROM_S: f64 = 1.2;

/// Up to a twist within 0.8 s; from 1.2 s on the wheels are free.
pub fn coasting(name: &str, from: Twist) -> Case {
    let target = ramp(from, 0.2, 0.8);
    Case::new(name, robot("mecanum4"), 0.6, 3.7, move |t_s| {
        if t_s < COASTS_FROM_S {
            Wheels::Follow(target(t_s))
        } else {
            Wheels::Free
        }
    })
}

/// A drive with the front left wheel locked.
pub fn one_wheel_locked(name: &str, end: Twist) -> Case {
    let target = ramp(end, 0.2, 0.5);
    let mut case = Case::new(name, robot("mecanum4"), 0.6, 2.0, move |t_s| {
        Wheels::Follow(target(t_s))
    });
    case.locked_wheel = Some(0);
    case
}

/// A second of rest, half a second of ramp, and four seconds held, of which the last three count.
pub fn steady(name: &str, robot_name: &str, end: Twist) -> Case {
    let target = ramp(end, 1.0, 0.5);
    Case::new(name, robot(robot_name), 0.6, 5.5, move |t_s| {
        Wheels::Follow(target(t_s))
    })
}

/// A twist in m/s and rad/s.
pub fn twist(vx_m_s: f64, vy_m_s: f64, omega_rad_s: f64) -> Twist {
    Twist::new(vx_m_s, vy_m_s, omega_rad_s)
}

/// 45 degrees to the left of straight ahead.
pub fn diagonally(speed_m_s: f64) -> Twist {
    twist(speed_m_s * 0.5_f64.sqrt(), speed_m_s * 0.5_f64.sqrt(), 0.0)
}

/// The hard start of the table and of the test.
pub fn hard_start_diagonal() -> Case {
    start(
        "hard start 4 m/s^2, mu 0.3, diagonal",
        diagonally(1.0),
        0.25,
        0.3,
        1.5,
    )
}

/// The emergency stop out of an arc of the table and of the test.
pub fn stop_out_of_an_arc() -> Case {
    emergency_stop(
        "stop from 0.8 m/s with 2 rad/s, mu 0.4",
        twist(0.8, 0.0, 2.0),
        0.4,
    )
}

/// The oblique push of the table and of the test: three wheels, whose loads follow from statics.
pub fn push_volksbot() -> Case {
    push("push 60 N, mu 0.6, volksbot, 30 deg", "volksbot", 30.0, 0.6)
}

/// The same on four wheels, whose loads are statically indeterminate.
pub fn push_mecanum() -> Case {
    push("push 60 N, mu 0.6, 30 deg", "mecanum4", 30.0, 0.6)
}

/// All rows of the table.
pub fn table() -> Vec<Case> {
    let push_mu = |friction: f64, angle: f64, word: &str| {
        push(
            &format!("push 60 N, mu {friction}, {word}"),
            "mecanum4",
            angle,
            friction,
        )
    };
    let (ahead, sideways) = (twist(1.0, 0.0, 0.0), twist(0.0, 1.0, 0.0));
    vec![
        start("hard start 4 m/s^2, mu 0.3, ahead", ahead, 0.25, 0.3, 1.5),
        start(
            "hard start 4 m/s^2, mu 0.3, sideways",
            sideways,
            0.25,
            0.3,
            1.5,
        ),
        hard_start_diagonal(),
        start(
            "hard start to 5 rad/s in 0.1 s, mu 0.3",
            twist(0.0, 0.0, 5.0),
            0.1,
            0.3,
            1.5,
        ),
        emergency_stop("stop from 1 m/s, mu 0.6, ahead", ahead, 0.6),
        emergency_stop("stop from 1 m/s, mu 0.6, sideways", sideways, 0.6),
        stop_out_of_an_arc(),
        start("spin-up to 1 m/s, mu 0.1, ahead", ahead, 0.05, 0.1, 2.5),
        start(
            "spin-up to 1 m/s, mu 0.1, sideways",
            sideways,
            0.05,
            0.1,
            2.5,
        ),
        push_mu(0.6, 0.0, "ahead"),
        push_mu(0.6, 90.0, "sideways"),
        push_mecanum(),
        push_volksbot(),
        push_mu(0.3, 0.0, "ahead"),
        push_mu(0.3, 90.0, "sideways"),
        push_mu(0.3, 45.0, "45 deg"),
        coasting("coasting ahead from 0.5 m/s", twist(0.5, 0.0, 0.0)),
        coasting("coasting sideways from 0.5 m/s", twist(0.0, 0.5, 0.0)),
        coasting("coasting yaw from 3 rad/s", twist(0.0, 0.0, 3.0)),
        one_wheel_locked("one wheel locked, 0.4 m/s ahead", twist(0.4, 0.0, 0.0)),
        one_wheel_locked("one wheel locked, 0.4 m/s sideways", twist(0.0, 0.4, 0.0)),
    ]
}
