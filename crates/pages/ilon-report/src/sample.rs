//! A made-up run for the report's tests: a four-wheeled mecanum robot that follows a circle, its
//! slip and its rollers' geometry drawn from simple formulas. Not a simulation: it only has every
//! kind of curve in it.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_4, TAU};

use ilon_robot::{Pose, Twist, wrap_angle};
use ilon_trace::ledger::Chain;
use ilon_trace::{
    Desired, Header, Ledger, Record, Support, TaskShare, Trace, Truth, WheelHeader, WheelSample,
};

const DT_S: f64 = 0.01;
const RADIUS_M: f64 = 0.05;
const LIMIT_RAD_S: f64 = 12.0;
const ROLLERS: usize = 9;

/// A run of some seconds, closed loop on a circle or open loop to the left.
pub(super) fn made_up_run(duration_s: f64, open_loop: bool) -> Trace {
    let steps = (duration_s / DT_S).round() as usize;
    let mut trace = Trace::with_capacity(header(duration_s, open_loop), steps);
    let mut pose = if open_loop {
        Pose::default()
    } else {
        Pose {
            x_m: 2.2,
            y_m: -0.6,
            heading_rad: 2.0,
        }
    };
    let (mut by_ideal, mut by_contact) = (pose, pose);
    let mut rates = [0.0; 4];
    let mut angles: [f64; 4] = [0.0; 4];
    let (mut slip_j, mut motor_j) = (0.0, 0.0);
    let mut budget = Ledger::default();
    for step in 0..steps {
        let t_s = step as f64 * DT_S;
        let desired = (!open_loop).then(|| circle(t_s));
        let tasks_asked = asked(t_s, pose, desired);
        let (tasks, granted) = saturated(&trace.header, tasks_asked);
        let command = tasks_asked.iter().fold(Twist::default(), |sum, t| sum + *t);
        let targets: Vec<f64> = trace
            .header
            .wheels
            .iter()
            .map(|w| rate_of(w, granted))
            .collect();
        let before = rates;
        for (rate, target) in rates.iter_mut().zip(&targets) {
            *rate += (target - *rate) * (1.0 - (-DT_S / 0.06_f64).exp());
        }
        let ideal = twist_of(&rates);
        let [contact, real] = contact_and_real(ideal, &angles);
        let wheels: Vec<WheelSample> = (0..4)
            .map(|j| WheelSample {
                target_rad_s: targets[j],
                slip_energy_j: 0.25 * slip_j,
                ..sampled(
                    &trace.header.wheels[j],
                    [before[j], rates[j]],
                    angles[j],
                    t_s,
                    real,
                )
            })
            .collect();
        let speed = real.linear_m_s().norm_squared() + 0.05 * real.omega_rad_s.powi(2);
        let kinetic_j = 0.5 * 11.0 * speed;
        slip_j += wheels
            .iter()
            .map(|w| w.slip_speed_m_s() * w.tangential_force_n())
            .sum::<f64>()
            * DT_S;
        motor_j += wheels
            .iter()
            .map(|w| (w.torque_n_m * w.rate_rad_s).max(0.0))
            .sum::<f64>()
            * DT_S;
        trace.push(
            Record {
                t_s,
                truth: Truth {
                    pose,
                    height_m: RADIUS_M,
                    twist_in_body: real,
                    ..Truth::default()
                },
                twist_ideal: ideal,
                twist_contact: contact,
                seen_pose: pose,
                odometry_ideal: by_ideal,
                odometry_contact: by_contact,
                desired,
                command_twist_in_body: command,
                granted_twist_in_body: granted,
                twist_target_ideal: granted,
                tasks,
                torque_weight_position: 1.0,
                torque_weight_heading: 1.0,
                slip_energy_j: slip_j,
                ledger: budget,
                contact_residual_m_s: 1e-9,
                support: Some(Support {
                    wheels_n: wheels.iter().map(|w| w.normal_force_n).sum(),
                    ..Support::default()
                }),
                motor_energy_j: motor_j,
                bearing_energy_j: (motor_j - slip_j - kinetic_j).max(0.0) * 0.97,
                kinetic_energy_j: kinetic_j,
                ..Record::default()
            },
            &wheels,
        );
        let chain = Chain::held(&trace.records()[step], DT_S);
        let turned_rad = real.omega_rad_s * DT_S;
        budget.count(&chain, [pose.heading_rad, pose.heading_rad + turned_rad]);
        pose = moved(pose, real);
        by_ideal = moved(by_ideal, ideal);
        by_contact = moved(by_contact, contact);
        for (angle, rate) in angles.iter_mut().zip(&rates) {
            *angle += rate * DT_S;
        }
    }
    trace
}

/// How far the touching roller's middle is from straight down.
fn phi_rad(angle_rad: f64) -> f64 {
    (angle_rad * ROLLERS as f64).rem_euclid(TAU) / ROLLERS as f64 - TAU / 18.0
}

/// What the rollers make of the ideal twist, and what is left of that by slip.
fn contact_and_real(ideal: Twist, angles_rad: &[f64; 4]) -> [Twist; 2] {
    let cosines = angles_rad.iter().map(|&angle| phi_rad(angle).cos());
    let ripple = cosines.sum::<f64>() / 4.0;
    let contact = Twist::new(
        ideal.vx_m_s,
        ideal.vy_m_s * ripple,
        ideal.omega_rad_s * (0.5 + 0.5 * ripple),
    );
    let real = Twist::new(
        contact.vx_m_s * 0.999,
        contact.vy_m_s * 0.997,
        contact.omega_rad_s * 0.998,
    );
    [contact, real]
}

/// A wheel that turned at one rate and now turns at another: it slides as its roller leans.
fn sampled(
    wheel: &WheelHeader,
    [before_rad_s, rate_rad_s]: [f64; 2],
    angle_rad: f64,
    t_s: f64,
    real: Twist,
) -> WheelSample {
    let torque_n_m = 0.02 * rate_rad_s + 0.08 * (rate_rad_s - before_rad_s) / DT_S;
    let phi = phi_rad(angle_rad);
    let slide = 0.004 * phi.abs() / 0.35 * (rate_rad_s.abs() / 5.0).min(1.0)
        + 2e-5 * (7.0 * t_s).sin().abs();
    let force_n = torque_n_m / RADIUS_M;
    let spin_rad_s = 8.0 * real.vy_m_s / 0.012 * 0.1;
    WheelSample {
        rate_rad_s,
        angle_rad,
        torque_n_m,
        hub_height_m: RADIUS_M + 2e-5 * (9.0 * angle_rad).cos(),
        roller: (angle_rad.rem_euclid(TAU) / TAU * ROLLERS as f64) as u32,
        touching: true,
        load_share: if phi.abs() > 0.33 { 0.6 } else { 1.0 },
        contact_x_m: wheel.position_m[0],
        contact_y_m: wheel.position_m[1] + 0.038 * phi.tan() * wheel.gamma_rad.tan(),
        normal_force_n: 28.0 + 2.0 * (9.0 * angle_rad).sin(),
        force_x_n: 0.7 * force_n,
        force_y_n: 0.7 * force_n * wheel.gamma_rad.signum(),
        friction: 0.6,
        slip_x_m_s: slide * (phi * 3.0).cos(),
        slip_y_m_s: slide * (phi * 3.0).sin(),
        roller_spin_rad_s: spin_rad_s + 3.0 * (-phi.abs() * 30.0).exp(),
        roller_spin_ideal_rad_s: spin_rad_s,
        ..WheelSample::default()
    }
    .steady()
}

fn header(duration_s: f64, open_loop: bool) -> Header {
    // Hubs, and the handedness that gives the long arm.
    let hubs = [
        ("front left", 0.15, 0.16, -1.0),
        ("front right", 0.15, -0.16, 1.0),
        ("rear left", -0.15, 0.16, 1.0),
        ("rear right", -0.15, -0.16, -1.0),
    ];
    Header {
        scenario_name: if open_loop {
            "mecanum4 lateral"
        } else {
            "mecanum4 circle"
        }
        .to_owned(),
        scenario_toml:
            "[robot]\nfile = \"mecanum4.urdf\"\n\n[reference]\nkind = \"circle\"\nradius_m = 1.0\n"
                .to_owned(),
        robot_name: "mecanum4".to_owned(),
        reference_point_m: [0.0; 2],
        wheels: hubs
            .map(|(name, x_m, y_m, hand)| WheelHeader {
                name: name.to_owned(),
                position_m: [x_m, y_m],
                radius_m: RADIUS_M,
                gamma_rad: hand * FRAC_PI_4,
                axis: [0.0, 1.0],
                width_m: 0.04,
                roller_count: ROLLERS,
                rate_limit_rad_s: Some(LIMIT_RAD_S),
                torque_limit_n_m: Some(2.0),
                ..WheelHeader::default()
            })
            .to_vec(),
        chassis_outlines_m: vec![vec![[0.2, 0.12], [-0.2, 0.12], [-0.2, -0.12], [0.2, -0.12]]],
        task_names: if open_loop {
            Vec::new()
        } else {
            [
                "position feedforward",
                "position feedback",
                "heading feedforward",
                "heading feedback",
            ]
            .map(str::to_owned)
            .to_vec()
        },
        physics_dt_s: 0.001,
        control_dt_s: DT_S,
        measure_from_s: if open_loop { 1.5 } else { 0.0 },
        measure_to_s: duration_s,
        wheel_rate_limit_rad_s: Some(LIMIT_RAD_S),
        open_loop,
        faults: Some(Vec::new()),
        versions: BTreeMap::from([("ilon".to_owned(), "0.1.0".to_owned())]),
        ..Header::default()
    }
}

/// 0.3 m/s around a circle of 1 m, heading 0.
fn circle(t_s: f64) -> Desired {
    let (s, c) = (0.3 * t_s).sin_cos();
    Desired {
        pose: Pose {
            x_m: c,
            y_m: s,
            heading_rad: 0.0,
        },
        velocity_in_world: Twist::new(-0.3 * s, 0.3 * c, 0.0),
        ..Desired::default()
    }
}

/// The four tasks' twists in the body frame; open loop all in the first.
fn asked(t_s: f64, pose: Pose, desired: Option<Desired>) -> [Twist; 4] {
    let none = Twist::default();
    let Some(desired) = desired else {
        let ramp = ((t_s - 1.0) / 0.5).clamp(0.0, 1.0);
        return [Twist::new(0.0, 0.3 * ramp, 0.0), none, none, none];
    };
    let e_r = 1.5 * (desired.pose.position_m() - pose.position_m());
    let e_phi = 2.0 * wrap_angle(desired.pose.heading_rad - pose.heading_rad);
    let in_body = |v: Twist| v.rotated(-pose.heading_rad);
    [
        in_body(desired.velocity_in_world),
        in_body(Twist::new(e_r.x, e_r.y, 0.0)),
        none,
        Twist::new(0.0, 0.0, e_phi),
    ]
}

/// Prioritised saturation of the tasks and the twist it leaves.
fn saturated(header: &Header, asked: [Twist; 4]) -> ([TaskShare; ilon_trace::MAX_TASKS], Twist) {
    let mut left_rad_s = LIMIT_RAD_S;
    let mut granted = Twist::default();
    let tasks = asked.map(|twist| {
        let rates = header.wheels.iter().map(|w| rate_of(w, twist).abs());
        let asked_rad_s = rates.fold(0.0, f64::max);
        let weight = if asked_rad_s > left_rad_s {
            left_rad_s / asked_rad_s
        } else {
            1.0
        };
        let share = TaskShare {
            asked_rad_s,
            capacity_rad_s: left_rad_s,
            weight,
            asked_twist_in_body: twist,
        };
        granted = granted + twist.scaled(weight);
        left_rad_s = (left_rad_s - weight * asked_rad_s).max(0.0);
        share
    });
    let mut all = [TaskShare::default(); ilon_trace::MAX_TASKS];
    all[..tasks.len()].copy_from_slice(&tasks);
    (all, granted)
}

/// The wheel's rate for a twist, Indiveri 2009, eq. (9).
fn rate_of(wheel: &WheelHeader, twist: Twist) -> f64 {
    let [m_x, m_y, m_a] = wheel.m_row();
    (m_x * twist.vx_m_s + m_y * twist.vy_m_s + m_a * twist.omega_rad_s)
        / (RADIUS_M * wheel.gamma_rad.cos())
}

/// The twist for four rates: the least squares of the made-up robot's M, whose columns are
/// orthogonal.
fn twist_of(rates: &[f64; 4]) -> Twist {
    let header = header(1.0, true);
    let columns = [0, 1, 2].map(|c| {
        let rows = || header.wheels.iter().map(|w| w.m_row()[c]);
        let along: f64 = rows().zip(rates).map(|(m, rate)| m * rate).sum();
        along * RADIUS_M * FRAC_PI_4.cos() / rows().map(|m| m * m).sum::<f64>()
    });
    Twist::new(columns[0], columns[1], columns[2])
}

fn moved(pose: Pose, twist_in_body: Twist) -> Pose {
    let v = twist_in_body.rotated(pose.heading_rad);
    Pose {
        x_m: pose.x_m + v.vx_m_s * DT_S,
        y_m: pose.y_m + v.vy_m_s * DT_S,
        heading_rad: wrap_angle(pose.heading_rad + v.omega_rad_s * DT_S),
    }
}
