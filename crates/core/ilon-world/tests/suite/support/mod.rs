//! Robots A and B built by hand, an independent contact kinematics, and open-loop drives.

#![allow(dead_code, reason = "each test file uses its own part")]

pub mod linked;
pub mod rig;

use std::f64::consts::{FRAC_PI_4, TAU};

use ilon_robot::*;
use ilon_world::*;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};

/// One wheel: centre, hub axis yaw, gamma, roller count.
pub fn wheel(position_m: Vector3<f64>, axis_yaw_rad: f64, gamma_rad: f64, count: usize) -> Wheel {
    let (rho, r_max) = (0.05, 0.012);
    let n = Vector3::new(axis_yaw_rad.cos(), axis_yaw_rad.sin(), 0.0);
    let x = -Vector3::z();
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, n.cross(&x), n]));
    let barrel = Barrel::handing_over(rho, r_max, gamma_rad, count);
    let length_m = 2.0 * barrel.half_length_m;
    let rollers = (0..count)
        .map(|i| {
            let psi = TAU * i as f64 / count as f64;
            let e = Vector3::new(psi.cos(), psi.sin(), 0.0);
            let t = Vector3::new(-psi.sin(), psi.cos(), 0.0);
            let axis = gamma_rad.cos() * t - gamma_rad.sin() * Vector3::z();
            Roller {
                name: format!("r{i}"),
                center_in_hub_m: (rho - r_max) * e,
                axis_in_hub: Unit::new_normalize(axis),
                radius_m: r_max,
                length_m,
                mass_kg: 0.01,
                axial_inertia_kg_m2: 0.01 * 0.009f64.powi(2) / 2.0,
                transverse_inertia_kg_m2: 0.01 * (3.0 * 0.009f64.powi(2) + length_m.powi(2)) / 12.0,
                joint: Joint {
                    damping_n_m_s: 1e-6,
                    friction_n_m: 0.0,
                },
                form: ilon_robot::RollerForm::Barrel,
            }
        })
        .collect();
    let (m, r, h): (f64, f64, f64) = (0.25, 0.03, 0.04);
    let across = m * (3.0 * r * r + h * h) / 12.0;
    Wheel {
        name: "w".into(),
        carrier: None,
        body_from_hub: Isometry3::from_parts(
            position_m.into(),
            UnitQuaternion::from_rotation_matrix(&rotation),
        ),
        hub: MassProperties {
            mass_kg: m,
            center_of_mass_m: Vector3::zeros(),
            inertia_kg_m2: Matrix3::from_diagonal(&Vector3::new(across, across, m * r * r / 2.0)),
        },
        radius_m: rho,
        gamma_rad,
        rollers,
        motor: MotorLimits::default(),
        joint: Joint::default(),
        drive: DriveTrain::default(),
        surface: RollerSurface::default(),
        material: None,
        made: RollersAsMade::default(),
    }
}

fn robot(
    name: &str,
    mass_kg: f64,
    center: Vector3<f64>,
    inertia: Vector3<f64>,
    wheels: Vec<Wheel>,
) -> Robot {
    Robot {
        name: name.into(),
        chassis: Chassis {
            name: "base".into(),
            mass: MassProperties {
                mass_kg,
                center_of_mass_m: center,
                inertia_kg_m2: Matrix3::from_diagonal(&inertia),
            },
            collisions: vec![],
        },
        joints: vec![],
        couplings: vec![],
        wheels,
        remarks: vec![],
    }
}

pub fn mecanum4() -> Robot {
    let (m, a, b, c): (f64, f64, f64, f64) = (10.0, 0.4, 0.24, 0.1);
    let inertia = m / 12.0 * Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b);
    let g = FRAC_PI_4;
    let yaw = TAU / 4.0;
    let at = |x: f64, y: f64, g: f64| wheel(Vector3::new(x, y, 0.05), yaw, g, 9);
    let wheels = vec![
        at(0.15, 0.16, -g),
        at(0.15, -0.16, g),
        at(-0.15, 0.16, g),
        at(-0.15, -0.16, -g),
    ];
    robot("mecanum4", m, Vector3::new(0.0, 0.0, 0.06), inertia, wheels)
}

pub fn volksbot() -> Robot {
    let m = 8.0 - 3.0 * (0.25 + 8.0 * 0.01);
    let ixx = m / 12.0 * (3.0 * 0.22f64.powi(2) + 0.01);
    let inertia = Vector3::new(ixx, ixx, m / 2.0 * 0.22f64.powi(2));
    let wheels = (0..3)
        .map(|i| {
            let yaw = TAU * i as f64 / 3.0;
            wheel(
                Vector3::new(0.25 * yaw.cos(), 0.25 * yaw.sin(), 0.05),
                yaw,
                0.0,
                8,
            )
        })
        .collect();
    robot("volksbot", m, Vector3::new(0.0, 0.0, 0.06), inertia, wheels)
}

/// Six mecanum wheels of twelve rollers each, 20 kg.
pub fn mecanum6() -> Robot {
    let (m, a, b, c): (f64, f64, f64, f64) = (18.0, 0.7, 0.24, 0.1);
    let inertia = m / 12.0 * Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b);
    let g = FRAC_PI_4;
    let yaw = TAU / 4.0;
    let at = |x: f64, y: f64, g: f64| wheel(Vector3::new(x, y, 0.05), yaw, g, 12);
    // The middle pair has the front pair's sense: its axes pass the centre on the same side.
    let wheels = vec![
        at(0.3, 0.16, -g),
        at(0.3, -0.16, g),
        at(0.02, 0.16, -g),
        at(0.02, -0.16, g),
        at(-0.3, 0.16, g),
        at(-0.3, -0.16, -g),
    ];
    robot("mecanum6", m, Vector3::new(0.0, 0.0, 0.06), inertia, wheels)
}

/// The same robot with each wheel's rollers rotated about the hub by an angle, in radians.
pub fn with_phases(mut robot: Robot, phases_rad: &[f64]) -> Robot {
    for (wheel, phase_rad) in robot.wheels.iter_mut().zip(phases_rad) {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), *phase_rad);
        for roller in &mut wheel.rollers {
            roller.center_in_hub_m = turn * roller.center_in_hub_m;
            roller.axis_in_hub = turn * roller.axis_in_hub;
        }
    }
    robot
}

/// Eq. (9), computed independently: wheel rates of a body twist.
pub fn ideal_rates(robot: &Robot, twist: Twist) -> Vec<f64> {
    robot
        .wheels
        .iter()
        .map(|w| {
            let (n, b, u) = (
                w.roller_axis(),
                w.position_m().xy(),
                w.roller_rolling_direction(),
            );
            -(n.x * twist.vx_m_s + n.y * twist.vy_m_s + b.dot(&u) * twist.omega_rad_s)
                / (w.radius_m * w.gamma_rad.cos())
        })
        .collect()
}

/// Least-squares inverse of eq. (7).
pub fn ideal_twist(robot: &Robot, rates: &[f64]) -> Twist {
    let n = robot.wheels.len();
    let mut m = DMatrix::zeros(n, 3);
    for (j, t) in [
        Twist::new(1.0, 0.0, 0.0),
        Twist::new(0.0, 1.0, 0.0),
        Twist::new(0.0, 0.0, 1.0),
    ]
    .iter()
    .enumerate()
    {
        m.set_column(j, &DVector::from_vec(ideal_rates(robot, *t)));
    }
    let x = m
        .svd(true, true)
        .solve(&DVector::from_column_slice(rates), 1e-12)
        .expect("full rank");
    Twist::new(x[0], x[1], x[2])
}

/// The twist without slip at the touching rollers: section "contact kinematics", one constraint per
/// wheel, solved by least squares.
pub fn contact_twist(robot: &Robot, angles: &[f64], rates: &[f64]) -> Twist {
    let n = robot.wheels.len();
    let (mut j, mut rhs) = (DMatrix::zeros(n, 3), DVector::zeros(n));
    for (i, w) in robot.wheels.iter().enumerate() {
        let turned = w.body_from_hub * Isometry3::rotation(Vector3::z() * angles[i]);
        let r = w
            .rollers
            .iter()
            .min_by(|a, b| {
                let off = |r: &Roller| wrap_angle(r.place_rad() + angles[i]).abs();
                off(a).total_cmp(&off(b))
            })
            .expect("rollers");
        let d = turned.rotation * r.axis_in_hub.into_inner();
        let c = turned.translation.vector + turned.rotation * r.center_in_hub_m;
        let barrel = w.barrel(r);
        let t = barrel.support_place_m(-d.z);
        let p = c + t * d - barrel.sphere_radius_m(t) * Vector3::z();
        let axis = turned.rotation * Vector3::z();
        j.set_row(
            i,
            &nalgebra::RowVector3::new(d.x, d.y, d.y * p.x - d.x * p.y),
        );
        let carried = axis.cross(&(p - turned.translation.vector)) * rates[i];
        rhs[i] = -(d.x * carried.x + d.y * carried.y);
    }
    let x = j.svd(true, true).solve(&rhs, 1e-12).expect("full rank");
    Twist::new(x[0], x[1], x[2])
}

pub const DRIVES: [(&str, [f64; 3]); 5] = [
    ("D1", [0.3, 0.0, 0.0]),
    ("D2", [0.0, 0.3, 0.0]),
    ("D3", [0.0, 0.0, 1.0]),
    ("D4", [0.2, 0.2, 0.0]),
    ("D5", [0.3, 0.0, 0.5]),
];

/// The results of a drive.
#[derive(Debug, Default, Clone)]
pub struct Drive {
    pub real: [f64; 3],
    pub ideal: [f64; 3],
    pub contact: [f64; 3],
    pub ripple_mm: f64,
    pub slip_rms: f64,
    pub creep_m_s: f64,
    pub servo: f64,
    pub side_mm_m: f64,
    pub cpu_s: f64,
}

impl Drive {
    /// Worst deviation from contact kinematics over the driven components, relative.
    pub fn worst(&self, command: [f64; 3]) -> f64 {
        (0..3)
            .filter(|&i| command[i] != 0.0)
            .map(|i| (self.real[i] / self.contact[i] - 1.0).abs())
            .fold(0.0, f64::max)
    }
}

/// 1 s rest, 0.5 s ramp, 4 s hold, the last 3 s measured; PI wheel loops, torque driven.
pub fn drive(
    robot: &Robot,
    command: [f64; 3],
    heading: f64,
    floor: &Floor,
    settings: &Settings,
    kp: f64,
    ki: f64,
) -> Drive {
    let start = Pose {
        x_m: 0.0,
        y_m: 0.0,
        heading_rad: heading,
    };
    let mut world = World::new(robot, floor, start, settings).expect("valid");
    let target = ideal_rates(robot, Twist::new(command[0], command[1], command[2]));
    let dt = settings.dt_s;
    let n = robot.wheels.len();
    let mut integral = vec![0.0; n];
    let steps = (5.5 / dt).round() as usize;
    let (mut real, mut ideal, mut contact) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    let (mut count, mut slip2) = (0.0, 0.0);
    let (mut low, mut high) = (vec![f64::INFINITY; n], vec![f64::NEG_INFINITY; n]);
    let mut creep = 0.0f64;
    let mut servo = 0.0f64;
    let clock = std::time::Instant::now();
    let mut rest = start;
    for k in 0..steps {
        let t = k as f64 * dt;
        let share = ((t - 1.0) / 0.5).clamp(0.0, 1.0);
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let torques: Vec<f64> = (0..n)
            .map(|i| {
                let e = share * target[i] - rates[i];
                integral[i] += ki * e * dt;
                kp * e + integral[i]
            })
            .collect();
        let motors: Vec<_> = torques
            .iter()
            .map(|t| MotorTorque::with_droop(*t, kp))
            .collect();
        world.robot_mut().drive(&motors);
        let (before, angles_before) = (
            world.robot().state().pose,
            world.robot().wheel_angles_rad().to_vec(),
        );
        world.step();
        let b = world.robot().state();
        if (t - 0.5).abs() < 0.5 * dt {
            rest = b.pose;
        }
        if (t - 0.95).abs() < 0.5 * dt {
            creep = (b.pose.position_m() - rest.position_m()).norm() / 0.45;
        }
        if t >= 2.5 {
            let add = |a: &mut [f64; 3], t: Twist| {
                for (a, x) in a.iter_mut().zip([t.vx_m_s, t.vy_m_s, t.omega_rad_s]) {
                    *a += x;
                }
            };
            // The displacement in the step, not the current velocity: rollers that hand over within
            // it change the velocity.
            let angles = angles_before.iter().zip(world.robot().wheel_angles_rad());
            let middle: Vec<f64> = angles.clone().map(|(a, b)| 0.5 * (a + b)).collect();
            let rates: Vec<f64> = angles.map(|(a, b)| (b - a) / dt).collect();
            add(&mut real, before.displacement_to(&b.pose).scaled(1.0 / dt));
            add(&mut ideal, ideal_twist(robot, &rates));
            add(&mut contact, contact_twist(robot, &middle, &rates));
            count += 1.0;
            for (i, c) in world.robot().contacts().iter().enumerate() {
                slip2 += c.sliding_in_body_m_s.norm_squared() / n as f64;
                low[i] = low[i].min(world.robot().hub_height_m(i));
                high[i] = high[i].max(world.robot().hub_height_m(i));
                servo = servo.max((world.robot().wheel_rates_rad_s()[i] - target[i]).abs());
            }
        }
    }
    let cpu_s = clock.elapsed().as_secs_f64();
    let mean = |a: [f64; 3]| a.map(|x| x / count);
    let real = mean(real);
    let side = (real[1] * f64::from(command[1] == 0.0)).abs() / (real[0].hypot(real[1])).max(1e-9);
    Drive {
        real,
        ideal: mean(ideal),
        contact: mean(contact),
        ripple_mm: 1e3
            * low
                .iter()
                .zip(&high)
                .map(|(l, h)| h - l)
                .fold(0.0, f64::max),
        slip_rms: (slip2 / count).sqrt(),
        creep_m_s: creep,
        servo,
        side_mm_m: 1e3 * side,
        cpu_s,
    }
}

/// Brakes all wheels for the coming step, with 20 N m per rad/s.
pub fn brake(world: &mut World) {
    const GAIN_N_M_S: f64 = 20.0;
    let rates = world.robot().wheel_rates_rad_s().iter();
    let motors: Vec<_> = rates
        .map(|rate| MotorTorque::with_droop(-GAIN_N_M_S * rate, GAIN_N_M_S))
        .collect();
    world.robot_mut().drive(&motors);
}

/// Seizes all rollers of a robot.
pub fn seize_all(world: &mut World, robot: &Robot) {
    for (wheel, of) in robot.wheels.iter().enumerate() {
        for roller in 0..of.rollers.len() {
            world.robot_mut().seize_roller(wheel, roller, true);
        }
    }
}
