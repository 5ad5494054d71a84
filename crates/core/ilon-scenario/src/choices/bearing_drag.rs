//! Checks whether a robot's rollers and wheels turn against the drag of their bearings.
//!
//! Friction mu turns a roller of radius r, under the wheel's share N of the weight, with a torque
//! of at most mu N r. The bearing resists with dry friction, whose part on the axle is proportional
//! to N, and with damping times the roller's rate: v / (r cos gamma) if the robot moves sideways at
//! v. If the bearing takes all of the torque, the roller does not turn and the wheel slides. A
//! wheel of radius rho is held by the dry friction of its own bearing and gear: if that exceeds mu
//! N rho, the most that the floor can turn it with, or the torque of its motor, the wheel does not
//! turn.

use ilon_robot::{Robot, Wheel};

/// The speed at which damping is evaluated, in m/s: a slow walk. Chosen.
const SPEED_M_S: f64 = 0.5;
/// Drag below this share of the floor's torque is normal for bearings. Chosen.
const WORTH_A_WORD: f64 = 0.05;

/// Remarks on the drag in the bearings of a robot's rollers and wheels, on a floor with a given
/// friction.
pub fn remarks(robot: &Robot, friction: f64, gravity_m_s2: f64) -> Vec<String> {
    let load_n = robot.mass_kg() * gravity_m_s2 / robot.wheels.len().max(1) as f64;
    let of_wheel = |wheel: &Wheel| {
        let words = [
            of_rollers(wheel, friction, load_n),
            of_bearing(wheel, friction, load_n),
        ];
        let name = wheel.name.clone();
        let said = words.into_iter().flatten();
        said.map(move |words| format!("wheel `{name}`: {words}"))
    };
    robot.wheels.iter().flat_map(of_wheel).collect()
}

/// Remarks on a wheel that is held by its own bearing and gear.
fn of_bearing(wheel: &Wheel, friction: f64, load_n: f64) -> Option<String> {
    let dry_n_m = wheel.dry_friction_n_m();
    let effort_n_m = wheel.motor.effort_n_m;
    if effort_n_m == 0.0 {
        return None;
    }
    if dry_n_m >= effort_n_m {
        return Some(format!(
            "its motor never turns it: the dry friction of its bearing and gear is {} mN m, and its motor gives {} mN m",
            millis(dry_n_m),
            millis(effort_n_m)
        ));
    }
    let turning_n_m = friction * load_n * wheel.radius_m;
    (turning_n_m > 0.0 && dry_n_m >= turning_n_m).then(|| {
        format!(
            "the dry friction of its bearing and gear, {} mN m, is more than a floor of friction {friction} can turn it with, {} mN m: it stands \
             wherever its motor gives less, and a wheel loop that is tuned for its inertia may never start it",
            millis(dry_n_m),
            millis(turning_n_m)
        )
    })
}

/// Remarks on a wheel whose rollers have drag.
fn of_rollers(wheel: &Wheel, friction: f64, load_n: f64) -> Option<String> {
    let dry_n_m = |roller: &ilon_robot::Roller| {
        roller.joint.friction_n_m + wheel.surface.axle_drag_n_m(load_n)
    };
    // The roller with the largest drag relative to the torque that turns it.
    let share = |roller: &&ilon_robot::Roller| {
        let turning_n_m = friction * load_n * roller.radius_m;
        let rate_rad_s = SPEED_M_S / (roller.radius_m * libm::cos(wheel.gamma_rad));
        (dry_n_m(roller) + roller.joint.damping_n_m_s * rate_rad_s) / turning_n_m
    };
    let by_share = |p: &&ilon_robot::Roller, q: &&ilon_robot::Roller| share(p).total_cmp(&share(q));
    let rollers = wheel.rollers.iter().filter(|roller| !roller.is_tyre());
    let worst = rollers.max_by(by_share)?;
    let worst_share = share(&worst);
    if !(load_n > 0.0 && friction > 0.0) || worst_share.is_nan() || worst_share < WORTH_A_WORD {
        return None;
    }
    let turning_n_m = friction * load_n * worst.radius_m;
    let (dry_n_m, damping_n_m_s) = (dry_n_m(worst), worst.joint.damping_n_m_s);
    let floor = format!(
        "a floor of friction {friction} turns them with {} mN m at most under the wheel's share of the weight",
        millis(turning_n_m)
    );
    if dry_n_m >= turning_n_m {
        return Some(format!(
            "its rollers never turn: {floor}, and the dry friction of their bearings is {} mN m; the wheel slides instead",
            millis(dry_n_m)
        ));
    }
    let mut parts = Vec::new();
    if dry_n_m > 0.0 {
        parts.push(format!(
            "the dry friction of their bearings {} mN m",
            millis(dry_n_m)
        ));
    }
    if damping_n_m_s > 0.0 {
        let rate_rad_s = SPEED_M_S / (worst.radius_m * libm::cos(wheel.gamma_rad));
        parts.push(format!(
            "their damping {} mN m at {SPEED_M_S} m/s sideways",
            millis(damping_n_m_s * rate_rad_s)
        ));
    }
    // The speed at which friction and damping take all of the floor's torque.
    let stop_m_s =
        (turning_n_m - dry_n_m) * worst.radius_m * libm::cos(wheel.gamma_rad) / damping_n_m_s;
    let end = if damping_n_m_s > 0.0 && stop_m_s < 10.0 {
        format!(": faster than {stop_m_s:.2} m/s they slide")
    } else {
        format!(": {:.0} % of the grip", 100.0 * worst_share)
    };
    Some(format!(
        "its rollers drag: {floor}, of which {} take{end}",
        parts.join(" and ")
    ))
}

/// A torque in mN m with three digits.
fn millis(torque_n_m: f64) -> String {
    let value = 1e3 * torque_n_m;
    let decimals = (2.0 - libm::log10(value.abs().max(1e-9)).floor()).clamp(0.0, 4.0);
    format!("{value:.*}", decimals as usize)
}

#[cfg(test)]
mod tests {
    use ilon_formats::{LoadRobot, Spec, generate};
    use ilon_robot::Robot;

    use super::*;

    /// 5.84 kg on three wheels of 50 mm: 19.0968 N each, and 0.6 of it turn a wheel with 573 mN m.
    /// Its motors give 1 N m.
    #[test]
    fn friction_that_holds_wheels_is_named() {
        let held = |friction_n_m: f64| {
            let mut robot = robot(0.0, 0.0);
            robot.wheels[1].joint.friction_n_m = friction_n_m;
            remarks(&robot, 0.6, 9.81)
        };
        assert_eq!(held(0.5), Vec::<String>::new());
        let [stands] = &held(0.7)[..] else {
            panic!("one wheel");
        };
        assert!(
            stands.contains("700 mN m") && stands.contains("573 mN m"),
            "{stands}"
        );
        let [never] = &held(1.5)[..] else {
            panic!("one wheel");
        };
        assert!(
            never.contains("never turns it") && never.contains("1500 mN m"),
            "{never}"
        );
    }

    fn robot(damping: f64, friction: f64) -> Robot {
        let spec = format!(
            "name = 'r'\n[chassis]\nshape.box = {{ size_m = [0.3, 0.3, 0.1] }}\nmass_kg = 5.0\ncenter_m = [0, 0, 0.06]\n\
             [wheel]\nradius_m = 0.05\nhub_mass_kg = 0.2\nhub_radius_m = 0.03\nhub_width_m = 0.04\nmotor_effort_n_m = 1\n\
             motor_velocity_rad_s = 20\n[rollers]\nper_row = 8\nradius_m = 0.012\nmass_kg = 0.01\ndamping_n_m_s = {damping}\n\
             friction_n_m = {friction}\n[wheels.ring]\ncount = 3\ndistance_m = 0.2\ngamma_deg = 0.0\n"
        );
        let spec = Spec::from_toml_str(&spec, "r.toml").expect("a description");
        let urdf = generate(&spec).expect("in range");
        Robot::from_urdf_str(&urdf, "r.urdf").expect("a robot")
    }

    /// 5.84 kg on three wheels: 19.0968 N each, and 0.6 of it at 12 mm are 137.5 mN m.
    #[test]
    fn drag_that_stops_rollers_is_named_with_what_the_floor_can_turn() {
        assert_eq!(remarks(&robot(0.0, 0.0), 0.6, 9.81), Vec::<String>::new());
        // One per cent is normal for a bearing.
        assert_eq!(
            remarks(&robot(0.0, 1.4e-3), 0.6, 9.81),
            Vec::<String>::new()
        );
        let stands = remarks(&robot(0.0, 0.2), 0.6, 9.81);
        assert_eq!(stands.len(), 3);
        assert!(
            stands[0].contains("never turn")
                && stands[0].contains("137 mN m")
                && stands[0].contains("200 mN m"),
            "{stands:?}"
        );
        // c v / r = 1e-3 * 0.5 / 0.012 = 41.7 mN m; all of 137.5 are taken at 137.5e-3 * 0.012 /
        // 1e-3 = 1.65 m/s.
        let damped = remarks(&robot(1e-3, 0.0), 0.6, 9.81);
        assert!(
            damped[0].contains("41.7 mN m") && damped[0].contains("faster than 1.65 m/s"),
            "{damped:?}"
        );
        // Ice turns them with less torque.
        assert!(remarks(&robot(0.0, 0.1), 0.3, 9.81)[0].contains("never turn"));
    }
}
