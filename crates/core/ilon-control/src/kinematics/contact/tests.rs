use super::*;
use crate::tests::robots::{WheelSpec, mecanum4, mecanum4_specs, robot, six_wheels, volksbot};
use ilon_robot::{ModelledRoller, ProfilePart};
use std::f64::consts::{PI, TAU};

/// Mean twist while every wheel turns at its ideal rate for `ideal`, over a whole number of roller
/// pitches of each wheel where the rates are equal in amount: sampled at `count` equal steps of the
/// first wheel's turn.
fn mean_twist(contact: &mut ContactKinematics, kinematics: &Kinematics, ideal: Twist) -> Twist {
    let n = kinematics.wheel_count();
    let mut rates = vec![0.0; n];
    kinematics.wheel_rates(ideal, &mut rates);
    let top = rates.iter().fold(0.0, |a: f64, r| a.max(r.abs()));
    let (count, mut sum) = (3600, Twist::default());
    for k in 0..count {
        // The middle of each step, so that no sample falls on a hand-over.
        let time_s = TAU / top * (f64::from(k) + 0.5) / f64::from(count);
        let angles: Vec<_> = rates.iter().map(|r| r * time_s).collect();
        sum = sum + contact.twist(&angles, &rates);
    }
    sum.scaled(1.0 / f64::from(count))
}

#[test]
fn sideways_a_mecanum_robot_gets_sinc_of_what_the_ideal_says() {
    for n in [6, 9, 12] {
        let mut specs = mecanum4_specs(crate::tests::robots::MECANUM_HANDEDNESS);
        for spec in &mut specs {
            spec.rollers = n;
        }
        let robot = robot(10.0, &specs);
        let kinematics = Kinematics::new(&robot).unwrap();
        let mut contact = ContactKinematics::new(&robot).unwrap();
        let mean = mean_twist(&mut contact, &kinematics, Twist::new(0.0, 0.3, 0.0));
        // The mean of cos(phi) over phi in [-pi/n, pi/n]. The midpoint rule over 3600/n steps a
        // pitch errs by less than (pi/n)^2 (n/3600)^2, below 1e-6.
        let sinc = (PI / n as f64).sin() / (PI / n as f64);
        assert!((mean.vy_m_s / 0.3 - sinc).abs() < 1e-6, "{n}: {mean:?}");
        assert!(
            mean.vx_m_s.abs() < 1e-4 && mean.omega_rad_s.abs() < 1e-3,
            "{mean:?}"
        );
    }
}

#[test]
fn the_mecanum_robot_of_nine_rollers_has_the_known_factors() {
    let robot = mecanum4();
    let kinematics = Kinematics::new(&robot).unwrap();
    let mut contact = ContactKinematics::new(&robot).unwrap();
    // Figures of an independent implementation in another language, sampled in the same way, given
    // to six digits.
    let lateral = mean_twist(&mut contact, &kinematics, Twist::new(0.0, 0.3, 0.0));
    assert!(
        (lateral.vy_m_s / 0.3 - 0.979816).abs() < 1e-6,
        "{lateral:?}"
    );
    let yaw = mean_twist(&mut contact, &kinematics, Twist::new(0.0, 0.0, 1.0));
    assert!((yaw.omega_rad_s - 0.989440).abs() < 1e-6, "{yaw:?}");
}

#[test]
fn straight_ahead_the_rollers_tilt_changes_nothing() {
    let robot = mecanum4();
    let kinematics = Kinematics::new(&robot).unwrap();
    let mut contact = ContactKinematics::new(&robot).unwrap();
    let mut rates = [0.0; 4];
    kinematics.wheel_rates(Twist::new(0.3, 0.0, 0.0), &mut rates);
    for k in 0..500 {
        let angles = [0.013 * f64::from(k); 4];
        let off = contact.twist(&angles, &rates) - Twist::new(0.3, 0.0, 0.0);
        assert!(off.linear_m_s().norm() < 1e-13 && off.omega_rad_s.abs() < 1e-12);
    }
}

#[test]
fn with_gamma_zero_the_contact_changes_nothing() {
    let robot = volksbot();
    let kinematics = Kinematics::new(&robot).unwrap();
    let mut contact = ContactKinematics::new(&robot).unwrap();
    let rates = [3.0, -2.0, 5.0];
    let ideal = kinematics.twist(&rates);
    for k in 0..500 {
        let angles = [0.013, 0.29, -0.17].map(|step| step * f64::from(k));
        let off = contact.twist(&angles, &rates) - ideal;
        assert!(off.linear_m_s().norm() < 1e-13 && off.omega_rad_s.abs() < 1e-12);
    }
}

#[test]
fn at_wheel_angle_zero_with_a_roller_straight_down_it_is_the_ideal_kinematics() {
    let robot = six_wheels();
    let kinematics = Kinematics::new(&robot).unwrap();
    let contact = ContactKinematics::new(&robot).unwrap();
    let twist = Twist::new(0.2, -0.3, 0.4);
    let (mut ideal, mut real) = ([0.0; 6], [0.0; 6]);
    kinematics.wheel_rates(twist, &mut ideal);
    contact.wheel_rates_here(twist, &mut real);
    for (ideal, real) in ideal.iter().zip(real) {
        assert!((ideal - real).abs() < 1e-12);
    }
    for (contact, wheel) in contact.contacts().iter().zip(kinematics.wheels()) {
        let below = wheel.position_m() - wheel.radius_m * Vector3::z();
        assert!((contact.point_in_body_m - below).norm() < 1e-12);
    }
}

#[test]
fn the_contact_lies_on_the_wheels_outline_and_wanders_along_the_hub_axis() {
    let robot = mecanum4();
    let mut contact = ContactKinematics::new(&robot).unwrap();
    let a = 0.038;
    for k in 0..400 {
        let angle = -1.0 + 0.005 * f64::from(k) + 1e-4;
        contact.update(&[angle; 4]);
        for (c, wheel) in contact.contacts().iter().zip(&robot.wheels) {
            let from_hub = c.point_in_body_m - wheel.position_m();
            assert!((from_hub.z + 0.05).abs() < 1e-12);
            // Hub axis +y: a tan(phi) tan(gamma) along it, nothing across it.
            let offset = a * c.angle_rad.tan() * wheel.gamma_rad.tan();
            assert!(from_hub.x.abs() < 1e-12, "{from_hub:?}");
            assert!((from_hub.y.abs() - offset.abs()).abs() < 1e-12);
            assert!(c.angle_rad.abs() <= PI / 9.0 + 1e-9);
        }
    }
}

#[test]
fn wheel_rates_and_twist_are_each_others_inverse() {
    for robot in [mecanum4(), volksbot(), six_wheels()] {
        let mut contact = ContactKinematics::new(&robot)
            .unwrap()
            .about(nalgebra::Vector2::new(0.1, -0.05))
            .unwrap();
        let n = robot.wheels.len();
        let twist = Twist::new(0.25, -0.1, 0.6);
        let mut rates = vec![0.0; n];
        for k in 0..200 {
            let angles: Vec<_> = (0..n).map(|h| 0.07 * (k * (h + 1)) as f64).collect();
            contact.wheel_rates(&angles, twist, &mut rates);
            let off = contact.twist(&angles, &rates) - twist;
            assert!(off.linear_m_s().norm() < 1e-12 && off.omega_rad_s.abs() < 1e-12);
            let mut residuals = vec![1.0; n];
            contact.residuals_here(twist, &rates, &mut residuals);
            assert!(residuals.iter().all(|r| r.abs() < 1e-12));
        }
    }
}

/// Checks the constraint without the derivation: moves the body and the wheel by a small step, with
/// the rollers fixed, and checks that the material at a contact moves on the ground only across its
/// roller's axis, as the roller's spin makes good.
#[test]
fn along_its_axis_a_rollers_contact_point_does_not_move() {
    let robot = mecanum4();
    let mut contact = ContactKinematics::new(&robot).unwrap();
    let twist = Twist::new(0.2, 0.15, 0.4);
    let mut rates = [0.0; 4];
    for k in 0..100 {
        let angles = [0.11, -0.07, 0.05, 0.13].map(|s| s * f64::from(k));
        contact.wheel_rates(&angles, twist, &mut rates);
        for (h, c) in contact.contacts().iter().enumerate() {
            let wheel = &robot.wheels[h];
            let spin_of = |angle: f64, axis: Unit<Vector3<f64>>| {
                nalgebra::UnitQuaternion::from_axis_angle(&axis, angle)
            };
            // World position of the material point that touches at time zero, at time t.
            let hub_spin = |t: f64| spin_of(angles[h] + rates[h] * t, Vector3::z_axis());
            let in_hub = {
                let at_hub =
                    wheel.body_from_hub.inverse() * nalgebra::Point3::from(c.point_in_body_m);
                hub_spin(0.0).inverse() * at_hub.coords
            };
            let place = |t: f64| {
                let in_body = wheel.body_from_hub * nalgebra::Point3::from(hub_spin(t) * in_hub);
                let turn = spin_of(twist.omega_rad_s * t, Vector3::z_axis());
                turn * in_body.coords + Vector3::new(twist.vx_m_s, twist.vy_m_s, 0.0) * t
            };
            // Central difference over 1 us: curvature enters with t^2, rounding with 1e-16 / 1e-6.
            let velocity = (place(1e-6) - place(-1e-6)) / 2e-6;
            let along = c.axis_in_body.xy().normalize();
            assert!(velocity.xy().dot(&along).abs() < 1e-8, "wheel {h}");
            assert!(velocity.xy().norm() > 1e-3, "wheel {h}");
        }
    }
}

/// The rollers skipped by the search cannot touch: compares with all rollers, turned one by one.
#[test]
fn no_roller_reaches_lower_than_the_one_that_is_found() {
    for robot in [mecanum4(), volksbot(), six_wheels()] {
        let mut contact = ContactKinematics::new(&robot).unwrap();
        for k in 0..1000 {
            let angle_rad = 0.0137 * f64::from(k) - 5.0;
            contact.update(&vec![angle_rad; robot.wheels.len()]);
            for (wheel, found) in robot.wheels.iter().zip(contact.contacts()) {
                let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
                let body_from_wheel = wheel.body_from_hub.rotation * turn;
                let depth_m = |roller: &ilon_robot::Roller| {
                    let axis = body_from_wheel * roller.axis_in_hub;
                    let barrel = wheel.barrel(roller);
                    let w_axial = -axis.z;
                    let t_m = barrel.support_place_m(w_axial);
                    let center = body_from_wheel * roller.center_in_hub_m;
                    t_m * w_axial + barrel.sphere_radius_m(t_m) - center.z
                };
                let deepest_m = wheel.rollers.iter().map(depth_m).reduce(f64::max).unwrap();
                let found_m = wheel.position_m().z - found.point_in_body_m.z;
                // The tie, 1e-9 of the radius, plus rounding.
                assert!((found_m - deepest_m).abs() < 2e-9 * wheel.radius_m);
                assert!((found_m - depth_m(&wheel.rollers[found.roller])).abs() < 1e-15);
            }
        }
    }
}

#[test]
fn two_rows_touch_by_turns() {
    let specs: Vec<_> = (0..3)
        .map(|i| {
            let a = TAU * f64::from(i) / 3.0;
            let mut spec = WheelSpec::new(0.25 * a.cos(), 0.25 * a.sin(), a, 0.0, 5);
            spec.rows = 2;
            spec
        })
        .collect();
    let robot = robot(8.0, &specs);
    let mut contact = ContactKinematics::new(&robot).unwrap();
    let mut seen = [false; 10];
    for k in 0..360 {
        let angle = (f64::from(k) + 0.5).to_radians();
        contact.update(&[angle; 3]);
        let c = contact.contacts()[0];
        seen[c.roller] = true;
        let roller = &robot.wheels[0].rollers[c.roller];
        let off_middle = (c.point_in_body_m - robot.wheels[0].position_m()).x;
        assert!((off_middle - roller.row_offset_m()).abs() < 1e-12);
        assert!(c.angle_rad.abs() <= PI / 10.0 + 1e-9);
    }
    assert!(seen.iter().all(|s| *s));
}

/// The robot with given outlines of its rollers, from their barrel.
fn modelled(mut robot: Robot, profile: impl Fn(&Barrel) -> Vec<ProfilePart>) -> Robot {
    for wheel in &mut robot.wheels {
        let barrels: Vec<Barrel> = wheel.rollers.iter().map(|r| wheel.barrel(r)).collect();
        for (roller, barrel) in wheel.rollers.iter_mut().zip(barrels) {
            roller.form = RollerForm::AsModelled(ModelledRoller {
                shapes: Vec::new(),
                profile: Profile::new(profile(&barrel)).unwrap(),
            });
        }
    }
    robot
}

#[test]
fn a_barrel_written_down_as_spheres_touches_where_the_barrel_does() {
    const SPHERES: usize = 400;
    let spheres = |barrel: &Barrel| {
        let sphere = |i: usize| {
            let t_m = barrel.half_length_m * (2.0 * i as f64 / SPHERES as f64 - 1.0);
            ProfilePart {
                t_m,
                ring_m: 0.0,
                ball_m: barrel.sphere_radius_m(t_m),
            }
        };
        (0..=SPHERES).map(sphere).collect()
    };
    let mut exact = ContactKinematics::new(&mecanum4()).unwrap();
    let mut written = ContactKinematics::new(&modelled(mecanum4(), spheres)).unwrap();
    for i in 0..50 {
        let angles = [0.123 * f64::from(i); 4];
        exact.update(&angles);
        written.update(&angles);
        for (p, q) in exact.contacts().iter().zip(written.contacts()) {
            assert_eq!(p.roller, q.roller);
            // The spheres are 0.1 mm apart, and the nearest to the one that touches is half of that
            // away.
            assert!((p.point_in_body_m - q.point_in_body_m).norm() < 6e-5);
            assert!((p.radius_m - q.radius_m).abs() < 6e-5);
        }
    }
}

#[test]
fn a_cylinder_touches_at_its_lower_edge() {
    // At gamma = 0 and phi from down the axis is tilted by phi: the lower edge is r straight across
    // the axis, and the axis r / cos phi above it.
    let (r, l) = (0.012, 0.01);
    let ends = |_: &Barrel| {
        let end = |t_m| ProfilePart {
            t_m,
            ring_m: r,
            ball_m: 0.0,
        };
        vec![end(-l), end(l)]
    };
    let robot = modelled(volksbot(), ends);
    let a = robot.wheels[0].rollers[0].ring_radius_m();
    let hub_z_m = robot.wheels[0].position_m().z;
    let mut contact = ContactKinematics::new(&robot).unwrap();
    for phi in [0.05f64, 0.2, 0.35] {
        contact.update(&[phi; 3]);
        let height_m = a * phi.cos() + l * phi.sin() + r * phi.cos();
        for touching in contact.contacts() {
            // A few roundings.
            assert!((hub_z_m - touching.point_in_body_m.z - height_m).abs() < 1e-15);
            assert!((touching.radius_m - r / phi.cos()).abs() < 1e-15);
        }
        // A turning wheel rolls on its height: q' h = |b| omega for each.
        let twist = contact.twist_here(&[1.0; 3]);
        let arm_m = robot.wheels[0].position_m().xy().norm();
        assert!((twist.omega_rad_s.abs() - height_m / arm_m).abs() < 1e-12);
    }
}

#[test]
fn a_wheel_without_rollers_is_refused() {
    let mut robot = mecanum4();
    robot.wheels[1].rollers.clear();
    let error = ContactKinematics::new(&robot).unwrap_err();
    let wheel = "wheel_1".to_owned();
    assert_eq!(error, ControlError::NoRollers { wheel });
}

#[test]
fn rollers_as_they_are_made_roll_on_the_height_of_their_hub() {
    // The forward part of omega n x (p - p_hub) is omega h, and along d_g of a roller at phi the
    // wheel requires d_g . v = omega h d_g . x: ahead v = omega h, sideways at gamma = 45 deg v =
    // omega h cos(phi).
    let made = |change: &dyn Fn(&mut ilon_robot::RollersAsMade), factor| {
        let mut robot = mecanum4();
        let mut made = ilon_robot::RollersAsMade::default();
        change(&mut made);
        for wheel in &mut robot.wheels {
            wheel.make_rollers(made.clone(), factor).unwrap();
        }
        robot
    };
    let cylinder = vec![[-0.012, 0.012], [0.012, 0.012]];
    for robot in [
        made(&|made| made.crown = 0.7, None),
        made(&|made| made.crown = 1.3, Some(0.9)),
        made(&|made| made.profile_m = Some(cylinder.clone()), None),
    ] {
        let kinematics = Kinematics::new(&robot).unwrap();
        let mut contact = ContactKinematics::new(&robot).unwrap();
        for ideal in [Twist::new(0.3, 0.0, 0.0), Twist::new(0.0, 0.3, 0.0)] {
            let mut rates = vec![0.0; 4];
            kinematics.wheel_rates(ideal, &mut rates);
            for i in 0..50 {
                let time_s = 0.007 * f64::from(i) + 0.001;
                let angles: Vec<f64> = rates.iter().map(|rate| rate * time_s).collect();
                let twist = contact.twist(&angles, &rates);
                let share = |wheel: usize| {
                    let phi = contact.contacts()[wheel].angle_rad;
                    let sideways = if ideal.vx_m_s == 0.0 { phi.cos() } else { 1.0 };
                    sideways * robot.wheels[wheel].hub_height_m(angles[wheel])
                        / robot.wheels[wheel].radius_m
                };
                // All wheels are equal or mirrored: their shares are equal, and so is the robot's,
                // up to rounding.
                let got = twist.linear_m_s().norm() / 0.3;
                assert!((share(0) - share(3)).abs() < 1e-12);
                assert!(
                    (got - share(0)).abs() < 1e-9,
                    "{ideal:?} {i}: {got} {}",
                    share(0)
                );
            }
        }
    }
}
