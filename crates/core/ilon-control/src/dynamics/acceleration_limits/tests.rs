use std::f64::consts::{FRAC_PI_2, SQRT_2};

use ilon_robot::MotorLimits;

use super::*;
use crate::tests::robots::{mecanum4, six_wheels, volksbot};
use crate::{DynamicModel, MotorCurve};

const FRICTION: f64 = 0.6;

fn settings(sharing: PushSharing) -> LimitSettings {
    LimitSettings {
        friction: FRICTION,
        gravity_m_s2: 9.81,
        slope_rad: 0.0,
        downhill_rad: 0.0,
        sharing,
        share: 1.0,
    }
}

fn motors(count: usize, effort_n_m: f64) -> Vec<Motor> {
    let limits = MotorLimits {
        effort_n_m,
        velocity_rad_s: f64::INFINITY,
    };
    vec![Motor::new(&limits, MotorCurve::Flat).unwrap(); count]
}

fn towards(angle_rad: f64) -> Twist {
    Twist::new(angle_rad.cos(), angle_rad.sin(), 0.0)
}

fn limit(robot: &Robot, settings: &LimitSettings, direction: Twist) -> AccelerationLimit {
    let motors = motors(robot.wheels.len(), f64::INFINITY);
    let mut limits = AccelerationLimits::new(robot, settings).unwrap();
    limits.along(direction, Twist::default(), &motors).unwrap()
}

/// Effect of the rollers of robot A, up to this share of a wheel's grip: at 10 mg each, J / r^2 =
/// 2.8 mg at 45 degrees, of 2.8 kg per wheel.
const SPUN: f64 = 1.5e-3;

/// Ahead, with the centre of mass at height h and axles L apart, equal loops push f = m a / (2
/// sqrt 2) on each wheel, and the front wheels bear m g / 4 - m a h / (2 L): they slide at a = mu g
/// / 4 / (1 / (2 sqrt 2) + mu h / (2 L)). Sideways the track replaces L.
#[test]
fn with_equal_loops_the_wheels_that_are_relieved_slide_first() {
    let robot = mecanum4();
    let height_m = robot.center_of_mass_m().z + robot.ride_height_m();
    for (angle_rad, apart_m, relieved) in [
        (0.0, 0.30, [0, 1]),
        (2.0 * FRAC_PI_2, 0.30, [2, 3]),
        (FRAC_PI_2, 0.32, [0, 2]),
        (-FRAC_PI_2, 0.32, [1, 3]),
    ] {
        let found = limit(
            &robot,
            &settings(PushSharing::EqualLoops),
            towards(angle_rad),
        );
        let push = 0.5 / SQRT_2;
        let expected = FRICTION * 9.81 / 4.0 / (push + FRICTION * height_m / (2.0 * apart_m));
        assert!(
            (found.largest / expected - 1.0).abs() < SPUN,
            "{found:?} {expected}"
        );
        assert!(relieved.contains(&found.wheel), "{found:?}");
        assert_eq!(found.cause, LimitCause::Grip);
    }
}

/// Bushings resist a mecanum robot sideways with sqrt(2) mu a / r of its weight, whatever the
/// loads, and ahead not at all: with limiting motors the acceleration is reduced by this, and if
/// the floor cannot turn the rollers any more none is possible.
#[test]
fn friction_on_axles_takes_its_share_of_the_load() {
    let plain = mecanum4();
    let on_axles = |friction: f64| {
        let mut robot = mecanum4();
        for wheel in &mut robot.wheels {
            wheel.surface.axle_friction = friction;
            wheel.surface.axle_radius_m = 2e-3;
        }
        robot
    };
    let model = DynamicModel::new(&plain).unwrap();
    let r = model.kinematics().rate_matrix();
    let moving_kg = (r.transpose() * model.inertia() * r)[(1, 1)];
    let radius_m = plain.wheels[0].rollers[0].radius_m;
    let weak = motors(4, 0.3);
    for sharing in [PushSharing::EqualLoops, PushSharing::ByGrip] {
        let mut settings = settings(sharing);
        settings.friction = 5.0;
        let largest = |robot: &Robot, angle_rad: f64| {
            let direction = towards(angle_rad);
            let mut limits = AccelerationLimits::new(robot, &settings).unwrap();
            let found = limits
                .along(direction, direction.scaled(0.1), &weak)
                .unwrap();
            assert_eq!(found.cause, LimitCause::Motor, "{found:?}");
            found.largest
        };
        let bushed = on_axles(0.2);
        let lost = largest(&plain, FRAC_PI_2) - largest(&bushed, FRAC_PI_2);
        let expected = SQRT_2 * 0.2 * 2e-3 / radius_m * plain.mass_kg() * 9.81 / moving_kg;
        // Bisection ends at 1e-9 of the limit.
        assert!(
            (lost / expected - 1.0).abs() < 1e-6,
            "{sharing:?}: {lost} {expected}"
        );
        let ahead = largest(&plain, 0.0) - largest(&bushed, 0.0);
        assert!(ahead.abs() < 1e-6 * expected, "{sharing:?}: {ahead}");
    }
    // mu a = 0.6 r: the rollers just take the floor's friction of 0.6.
    let stuck = on_axles(1.01 * FRICTION * radius_m / 2e-3);
    let mut limits = AccelerationLimits::new(&stuck, &settings(PushSharing::EqualLoops)).unwrap();
    let left = towards(FRAC_PI_2);
    let found = limits
        .along(left, left.scaled(0.1), &motors(4, 1e3))
        .unwrap();
    assert_eq!((found.largest, found.cause), (0.0, LimitCause::Grip));
}

/// By grip the rear wheels push what the front ones cannot: sqrt 2 mu times half the weight in all,
/// whatever the height.
#[test]
fn by_grip_the_wheels_with_load_make_up_for_those_without() {
    let mut robot = mecanum4();
    for height_m in [0.06, 0.12] {
        robot.chassis.mass.center_of_mass_m.z = height_m;
        for angle_rad in [0.0, FRAC_PI_2] {
            let found = limit(&robot, &settings(PushSharing::ByGrip), towards(angle_rad));
            let expected = FRICTION * 9.81 / SQRT_2;
            assert!((found.largest / expected - 1.0).abs() < SPUN, "{found:?}");
        }
    }
}

/// Three wheels have a unique distribution: both ways are the same, in any direction and with
/// rotation.
#[test]
fn three_wheels_have_one_way_to_push() {
    let robot = volksbot();
    for direction in (0..12)
        .map(|i| towards(f64::from(i) * 0.5))
        .chain([Twist::new(0.3, -0.5, 2.0), Twist::new(0.0, 0.0, 1.0)])
    {
        let by_loops = limit(&robot, &settings(PushSharing::EqualLoops), direction);
        let by_grip = limit(&robot, &settings(PushSharing::ByGrip), direction);
        assert!((by_loops.largest / by_grip.largest - 1.0).abs() < 1e-6);
        assert_eq!(by_loops.cause, by_grip.cause);
    }
}

/// 4 tau / rho = (m + 4 J / rho^2) a with the wheels' spin J, if the motors limit.
#[test]
fn a_weak_motor_limits_before_grip_does() {
    let robot = mecanum4();
    let effort_n_m = 0.2;
    let mut limits = AccelerationLimits::new(&robot, &settings(PushSharing::EqualLoops)).unwrap();
    let found = limits
        .along(towards(0.0), Twist::default(), &motors(4, effort_n_m))
        .unwrap();
    let spin: f64 = limits.capacity.model.wheel_inertias_kg_m2().iter().sum();
    let mass_kg = robot.mass_kg() + spin / (0.05 * 0.05);
    let expected = 4.0 * effort_n_m / 0.05 / mass_kg;
    assert!(
        (found.largest / expected - 1.0).abs() < 3e-4,
        "{found:?} {expected}"
    );
    assert_eq!(found.cause, LimitCause::Motor);
    // At half its no-load rate a DC motor has half its torque; at the no-load rate none is left to
    // accelerate, and all of it to brake.
    let curve = MotorCurve::dc_line(effort_n_m, 20.0).unwrap();
    let dc = vec![Motor::new(&MotorLimits::default(), curve).unwrap(); 4];
    let mut at = |speed_m_s: f64, angle_rad: f64| {
        let moving = Twist::new(speed_m_s, 0.0, 0.0);
        limits
            .along(towards(angle_rad), moving, &dc)
            .unwrap()
            .largest
    };
    assert!((at(0.5, 0.0) / expected - 0.5).abs() < 3e-4);
    assert!(at(1.0, 0.0) < 1e-9);
    assert!((at(0.5, 2.0 * FRAC_PI_2) / expected - 1.5).abs() < 1e-3);
}

/// On a slope the robot has the rest beside its weight: downhill and uphill the limits are a level
/// robot's with gravity g cos, shifted by g sin (the slope shifts the load as the same acceleration
/// would). If the slope is too steep nothing is left.
#[test]
fn a_slope_takes_its_share() {
    let robot = volksbot();
    let slope_rad: f64 = 0.1;
    let level = LimitSettings {
        gravity_m_s2: 9.81 * slope_rad.cos(),
        ..settings(PushSharing::EqualLoops)
    };
    let slope = LimitSettings {
        slope_rad,
        ..settings(PushSharing::EqualLoops)
    };
    let along_m_s2 = 9.81 * slope_rad.sin();
    // The frame's x axis points downhill; wheels and rollers need 2 % of the accelerating force,
    // but not of the weight's.
    for (angle_rad, sign) in [(0.0, 1.0), (2.0 * FRAC_PI_2, -1.0)] {
        let on_level = limit(&robot, &level, towards(angle_rad)).largest;
        let found = limit(&robot, &slope, towards(angle_rad)).largest;
        let more = found - on_level;
        assert!((more / (sign * along_m_s2) - 1.0).abs() < 0.02, "{more}");
    }
    let steep = LimitSettings {
        slope_rad: 0.6,
        ..slope
    };
    assert_eq!(limit(&robot, &steep, towards(1.0)).largest, 0.0);
}

/// A torque law by grip uses all the grip at the limit, and less at half of it.
#[test]
fn the_distribution_by_grip_is_used_up_at_the_limit() {
    for robot in [mecanum4(), six_wheels()] {
        let direction = Twist::new(0.6, 0.5, 1.0);
        let mut limits = AccelerationLimits::new(&robot, &settings(PushSharing::ByGrip)).unwrap();
        let n = robot.wheels.len();
        let found = limits
            .along(direction, Twist::default(), &motors(n, f64::INFINITY))
            .unwrap();
        let free = vec![TorqueRange::UNLIMITED; n];
        let still = vec![0.0; n];
        let moment = Moment {
            rates: &still,
            towards: &still,
            limits: &free,
            nu: Twist::default(),
        };
        let along = Vector3::new(0.6, 0.5, 1.0);
        let mut use_at = |scale: f64| {
            let force = limits.capacity.weigh(&moment, scale * along);
            let capacity = &limits.capacity;
            let mut out = vec![0.0; n];
            capacity
                .set
                .distribute(&force, &capacity.motor, &capacity.grips_n, &mut out)
        };
        assert!((use_at((1.0 - 1e-9) * found.largest) - 1.0).abs() < 1e-6);
        assert!(use_at(0.5 * found.largest) < 0.7);
    }
}

/// The robot is its own mirror image, left to right.
#[test]
fn a_symmetric_robot_has_symmetric_limits() {
    let robot = mecanum4();
    for sharing in [PushSharing::EqualLoops, PushSharing::ByGrip] {
        for (x, y, turning) in [(1.0, 0.4, 0.0), (-0.3, 1.0, 2.0), (0.0, 0.0, 1.0)] {
            let one = limit(&robot, &settings(sharing), Twist::new(x, y, turning)).largest;
            let other = limit(&robot, &settings(sharing), Twist::new(x, -y, -turning)).largest;
            assert!((other / one - 1.0).abs() < 1e-9, "{one} {other}");
        }
    }
}

/// Newton: the ground's force on the wheels is mass times acceleration, and on a slope less the
/// downhill gravity, whatever turns rollers and hubs, and whatever their bearings do inside the
/// robot. Euler: the same for its moment about the common centre of mass.
#[test]
fn what_the_ground_does_is_mass_times_acceleration() {
    for (mut robot, sharing) in [
        (mecanum4(), PushSharing::EqualLoops),
        (six_wheels(), PushSharing::EqualLoops),
        (volksbot(), PushSharing::ByGrip),
        (six_wheels(), PushSharing::ByGrip),
    ] {
        robot.chassis.mass.center_of_mass_m += Vector3::new(0.03, -0.02, 0.0);
        for wheel in &mut robot.wheels {
            wheel.joint.friction_n_m = 0.02;
            for roller in &mut wheel.rollers {
                roller.joint.friction_n_m = 2e-3;
                roller.joint.damping_n_m_s = 1e-4;
                // Heavy enough to matter.
                roller.axial_inertia_kg_m2 *= 50.0;
            }
        }
        let n = robot.wheels.len();
        let on_slope = LimitSettings {
            slope_rad: 0.1,
            downhill_rad: 0.7,
            ..settings(sharing)
        };
        let mut limits = AccelerationLimits::new(&robot, &on_slope).unwrap();
        let (twist, rate) = (Twist::new(0.4, -0.2, 0.0), Twist::new(0.9, 0.7, 0.0));
        let mut used = vec![0.0; n];
        let free = motors(n, f64::INFINITY);
        limits.grip_used(rate, twist, &free, &mut used).unwrap();
        let (mut force, mut moment) = (Vector2::zeros(), 0.0);
        for (wheel, at) in robot.wheels.iter().zip(&limits.forces) {
            let (n_g, u_g) = (
                wheel.roller_axis().xy(),
                wheel.roller_rolling_direction().xy(),
            );
            let of_wheel = -at.at_ground_n[0] * n_g - at.at_ground_n[1] * u_g;
            force += of_wheel;
            moment += (wheel.position_m() - robot.center_of_mass_m())
                .xy()
                .perp(&of_wheel);
        }
        let pull = 9.81 * 0.1_f64.sin() * Vector2::new(0.7_f64.cos(), 0.7_f64.sin());
        let expected = robot.mass_kg() * (Vector2::new(0.9, 0.7) - pull);
        assert!((force - expected).norm() < 1e-9, "{force} {expected}");
        // Hubs and rollers lie in the plane: their spin has no component about the vertical.
        assert!(moment.abs() < 1e-9, "{moment}");
    }
}

/// Beyond its no-load rate a motor at full voltage brakes: a robot that rolls so fast can brake,
/// but not keep its speed.
#[test]
fn a_range_need_not_hold_zero() {
    let robot = mecanum4();
    let curve = MotorCurve::dc_line(0.2, 20.0).unwrap();
    let dc = vec![Motor::new(&MotorLimits::default(), curve).unwrap(); 4];
    let mut limits = AccelerationLimits::new(&robot, &settings(PushSharing::EqualLoops)).unwrap();
    let (ahead, fast) = (Twist::new(1.0, 0.0, 0.0), Twist::new(1.5, 0.0, 0.0));
    let none = Twist::default();
    let range = limits.range(none, ahead, fast, &dc).unwrap().unwrap();
    assert!(range.least < -1.0 && range.largest < -0.1, "{range:?}");
    assert_eq!(limits.along(ahead, fast, &dc).unwrap().largest, 0.0);
    // The same by bisection.
    limits.sharing = PushSharing::ByGrip;
    let halved = limits.range(none, ahead, fast, &dc).unwrap().unwrap();
    assert!((halved.largest - range.largest).abs() < 1e-6, "{halved:?}");
    // Too steep to stand on: the wheels give mu g cos / sqrt 2 = 3.6 m/s^2 to 4.2 while the slope
    // pulls with 5.2; downhill accelerations are possible.
    let steep = LimitSettings {
        slope_rad: 0.56,
        ..settings(PushSharing::ByGrip)
    };
    let mut limits = AccelerationLimits::new(&robot, &steep).unwrap();
    let free = motors(4, f64::INFINITY);
    let down = limits.range(none, ahead, none, &free).unwrap().unwrap();
    assert!(down.least > 0.5 && down.largest > 8.0, "{down:?}");
    assert!(
        limits
            .range(none, towards(FRAC_PI_2), none, &free)
            .unwrap()
            .is_none()
    );
}

/// Roots and bisection find the same ends, for pseudo-random robots and motions.
#[test]
fn roots_and_halving_agree() {
    let mut compared = 0;
    for (k, mut robot) in [mecanum4(), six_wheels(), volksbot()]
        .into_iter()
        .cycle()
        .take(60)
        .enumerate()
    {
        let x = |i: u32| ((k as f64 + 1.0) * f64::from(i) * 0.754_877_666).fract() - 0.5;
        robot.chassis.mass.center_of_mass_m =
            Vector3::new(0.1 * x(1), 0.1 * x(2), 0.1 + 0.1 * x(3));
        for roller in robot.wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
            roller.joint.friction_n_m = 0.005 + 0.01 * x(4);
        }
        let of = LimitSettings {
            friction: 0.55 + 0.8 * x(5),
            slope_rad: 0.1 + 0.2 * x(6),
            downhill_rad: 6.0 * x(7),
            share: 0.9,
            ..settings(PushSharing::EqualLoops)
        };
        let n = robot.wheels.len();
        let mut limits = AccelerationLimits::new(&robot, &of).unwrap();
        let base = Twist::new(x(8), x(9), x(10));
        let along = Twist::new(x(11), x(12), 3.0 * x(13));
        let twist = Twist::new(x(14), x(15), x(16));
        let (moving, course) = limits
            .begin(base, along, twist, &motors(n, 1.0 + x(17)))
            .unwrap();
        let Some(roots) = limits.by_roots(&moving, &course) else {
            continue;
        };
        let halved = limits.by_halving(&moving, &course);
        assert_eq!(roots.is_empty(), halved.is_none(), "{roots:?} {halved:?}");
        if let Some(halved) = halved {
            compared += 1;
            let off = (roots.low - halved.low)
                .abs()
                .max((roots.high - halved.high).abs());
            assert!(
                off < 1e-6 * (1.0 + roots.high.abs()),
                "{roots:?} {halved:?}"
            );
        }
    }
    assert!(compared > 30, "{compared}");
}

/// A gear of 80 % passes on 0.8 when driving; when braking 1 / (2 - 1 / 0.8).
#[test]
fn a_gear_takes_its_share() {
    let mut robot = mecanum4();
    let free = motors(4, 0.1);
    let mut at = |efficiency: f64, angle_rad: f64| {
        for wheel in &mut robot.wheels {
            wheel.drive.gear_efficiency = efficiency;
        }
        let mut limits = AccelerationLimits::new(&robot, &settings(PushSharing::ByGrip)).unwrap();
        let moving = Twist::new(0.3, 0.0, 0.0);
        limits
            .along(towards(angle_rad), moving, &free)
            .unwrap()
            .largest
    };
    let whole = at(1.0, 0.0);
    assert!((at(0.8, 0.0) / whole - 0.8).abs() < 1e-9);
    assert!((at(0.8, 2.0 * FRAC_PI_2) / whole - 1.0 / 0.75).abs() < 1e-9);
}

#[test]
fn what_is_no_condition_is_refused() {
    let robot = mecanum4();
    let fine = settings(PushSharing::ByGrip);
    for wrong in [
        LimitSettings {
            friction: 0.0,
            ..fine
        },
        LimitSettings {
            gravity_m_s2: f64::NAN,
            ..fine
        },
        LimitSettings {
            slope_rad: FRAC_PI_2 + 1e-9,
            ..fine
        },
        LimitSettings {
            downhill_rad: f64::INFINITY,
            ..fine
        },
        LimitSettings { share: 0.0, ..fine },
        LimitSettings { share: 2.0, ..fine },
    ] {
        assert!(AccelerationLimits::new(&robot, &wrong).is_err());
    }
    let mut limits = AccelerationLimits::new(&robot, &fine).unwrap();
    let four = motors(4, 1.0);
    let none = Twist::default();
    assert!(limits.along(none, none, &four).is_err());
    assert!(limits.along(towards(0.0), none, &four[1..]).is_err());
    assert!(limits.along(towards(f64::NAN), none, &four).is_err());
}
