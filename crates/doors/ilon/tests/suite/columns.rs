//! Every recorded signal against the world's true state, or against an independent calculation.
//!
//! The rows are destructured field by field, so that a new signal is not forgotten here.

use std::path::Path;

use approx::assert_relative_eq;
use ilon::Scenario;
use ilon::control::{ContactKinematics, Kinematics};
use ilon::robot::{Pose, Robot, Twist, wrap_angle};
use ilon::simulate::Simulation;
use ilon::trace::{
    BodySample, Desired, JointSample, MAX_BODIES, MAX_JOINTS, Record, Support, TaskShare, Trace,
    Truth, WheelSample,
};
use ilon::world::{BodyState, Energy, WheelContact};
use ilon_formats::LoadRobot;
use nalgebra::UnitQuaternion;

/// Onto a circle, over a slippery patch and a kerb, with a push meanwhile; a row at every physics
/// step, exact sensors.
const SCENARIO: &str = "
[robot]
file = 'mecanum4.urdf'
x_m = 0.05
heading_deg = 20
[reference.circle]
radius_m = 0.6
center_x_m = -0.6
speed_m_s = 0.3
heading = { constant_deg = 0 }
[guidance]
wheel_rate_limit_rad_s = 9
[world.floor]
friction = 0.5
patches = [{ x_m = 0, y_m = 0.2, length_x_m = 0.3, length_y_m = 0.3, friction = 0.05 }]
boxes = [{ x_m = 0, y_m = 0.55, length_x_m = 2, length_y_m = 0.1, height_m = 0.004 }]
[[world.bodies]]
name = 'ball'
sphere = { radius_m = 0.05 }
mass_kg = 0.5
x_m = 1
y_m = -2
vx_m_s = 0.3
omega_rad_s = 0.7
[[faults]]
push = { impulse_x_n_s = 4, frame = 'world', from_s = 0.4, lasts_s = 0.2 }
[run]
duration_s = 2
control_dt_s = 0.002
physics_dt_s = 0.002
";

/// The world's state after a step.
struct Seen {
    body: BodyState,
    rates_rad_s: Vec<f64>,
    angles_rad: Vec<f64>,
    torques_n_m: Vec<f64>,
    hubs_m: Vec<f64>,
    contacts: Vec<WheelContact>,
    spins_rad_s: Vec<Vec<f64>>,
    energy: Energy,
    slip_j: f64,
    spin_up_j: f64,
    motor_j: f64,
    motor_positive_j: f64,
    bearing_j: f64,
    impact_j: f64,
    residual_m_s: f64,
    support: ilon::world::Support,
    ball: ilon::world::FreeBodyState,
}

fn look(simulation: &Simulation) -> Seen {
    let world = simulation.world();
    let wheels = 0..world.robot().wheel_angles_rad().len();
    Seen {
        body: world.robot().state(),
        rates_rad_s: world.robot().wheel_rates_rad_s().to_vec(),
        angles_rad: world.robot().wheel_angles_rad().to_vec(),
        torques_n_m: world.robot().motor_torques_n_m().to_vec(),
        hubs_m: wheels
            .clone()
            .map(|wheel| world.robot().hub_height_m(wheel))
            .collect(),
        contacts: world.robot().contacts().to_vec(),
        spins_rad_s: wheels
            .map(|wheel| world.robot().roller_spins_rad_s(wheel))
            .collect(),
        energy: world.energy(),
        slip_j: world.slip_energy_j(),
        spin_up_j: world.spin_up_energy_j(),
        motor_j: world.motor_energy_j(),
        motor_positive_j: world.motor_positive_energy_j(),
        bearing_j: world.bearing_energy_j(),
        impact_j: world.impact_energy_j(),
        residual_m_s: world.contact_residual_m_s(),
        support: world.robot().support(),
        ball: world
            .free_body(world.free_bodies()[0])
            .expect("it is there"),
    }
}

/// The run, and the world's state at each row.
fn run() -> (Robot, Trace, Vec<Seen>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let robot = Robot::load(folder.join("mecanum4.urdf")).expect("a shipped robot");
    let scenario = Scenario::from_toml(SCENARIO, "columns", folder).expect("a scenario");
    let mut simulation = Simulation::new(&scenario).expect("it begins");
    let mut seen = Vec::new();
    while !simulation.is_done() {
        seen.push(look(&simulation));
        simulation.step();
    }
    seen.push(look(&simulation));
    let trace = simulation.trace().clone();
    assert_eq!(trace.records().len(), seen.len());
    (robot, trace, seen)
}

fn same(pose: Pose, other: Pose) -> f64 {
    let off_m = (pose.position_m() - other.position_m()).norm();
    off_m.max(wrap_angle(pose.heading_rad - other.heading_rad).abs())
}

fn apart(a: Twist, b: Twist) -> f64 {
    let off = a - b;
    off.vx_m_s
        .abs()
        .max(off.vy_m_s.abs())
        .max(off.omega_rad_s.abs())
}

#[test]
fn every_signal_of_the_robot_is_what_happened() {
    let (robot, trace, seen) = run();
    let kinematics = Kinematics::new(&robot).expect("wheels");
    let mut contact = ContactKinematics::new(&robot).expect("wheels");
    let dt_s = 0.002;
    let mut outside_j = 0.0;
    let mut odometry = [seen[0].body.pose; 2];
    let mut targets = vec![0.0; 4];
    let mut asked_m = [0.0; 2];
    let pose_of = |record: &Record| record.truth.pose;
    for (step, (record, now)) in trace.records().iter().zip(&seen).enumerate() {
        let Record {
            t_s,
            truth,
            twist_ideal,
            twist_contact,
            seen_pose,
            odometry_ideal,
            odometry_contact,
            desired,
            measured,
            command_twist_in_body,
            granted_twist_in_body,
            twist_target_ideal,
            tasks,
            torque_weight_position,
            torque_weight_heading,
            slip_energy_j,
            spin_up_energy_j,
            motor_energy_j,
            motor_positive_energy_j,
            bearing_energy_j,
            impact_energy_j,
            outside_energy_j,
            kinetic_energy_j,
            potential_energy_j,
            contact_residual_m_s,
            support,
            reckoned,
            imu,
            storage,
            joints,
            odometry_posed,
            bodies,
            saturated_share,
            rate_conflict_share,
            ledger,
        } = *record;
        // The norm of a projection is at most that of the vector.
        assert!((0.0..=1.0).contains(&rate_conflict_share));
        assert_relative_eq!(t_s, dt_s * step as f64, epsilon = 1e-12);
        assert!(
            [0.0, 1.0].contains(&saturated_share),
            "one control instant a row"
        );
        let gives_way = tasks
            .iter()
            .any(|task| task.asked_rad_s > 0.0 && task.weight < 1.0);
        assert_eq!(saturated_share, f64::from(u8::from(gives_way)));
        if let Some(before) = step.checked_sub(1).map(|before| &trace.records()[before]) {
            // The last row's command was held until this one, while the robot moved from there to
            // here.
            let turned_rad = wrap_angle(pose_of(record).heading_rad - pose_of(before).heading_rad);
            let heading_rad = pose_of(before).heading_rad + 0.5 * turned_rad;
            let went = before
                .command_twist_in_body
                .rotated(heading_rad)
                .scaled(dt_s);
            asked_m[0] += went.vx_m_s;
            asked_m[1] += went.vy_m_s;
        }
        let moved_m = pose_of(record).position_m() - pose_of(&trace.records()[0]).position_m();
        // A span ends where a decision changes, and so at every row here. A thousand sums of
        // numbers below 1.
        assert_relative_eq!(ledger.total.x_m, asked_m[0] - moved_m.x, epsilon = 1e-12);
        assert_relative_eq!(ledger.total.y_m, asked_m[1] - moved_m.y, epsilon = 1e-12);
        let terms = ledger.named();
        let sum_m: f64 = terms.iter().map(|(_, term)| term.x_m).sum();
        assert_relative_eq!(ledger.total.x_m, sum_m, epsilon = 1e-12);
        // This robot has no joints between bodies.
        assert_eq!(joints, [JointSample::default(); MAX_JOINTS]);
        assert_eq!(odometry_posed, None);
        let ball = &bodies[0];
        assert_eq!(ball.place_m, <[f64; 3]>::from(now.ball.place_m));
        assert_eq!(ball.velocity_m_s, <[f64; 3]>::from(now.ball.velocity_m_s));
        let turned =
            UnitQuaternion::from_euler_angles(ball.roll_rad, ball.pitch_rad, ball.heading_rad);
        assert!(turned.angle_to(&now.ball.rotation) < 1e-9);
        // No robot comes near it.
        assert_eq!((ball.push_n, ball.work_j), (0.0, 0.0));
        assert_eq!(bodies[1..], [BodySample::default(); MAX_BODIES - 1]);
        let Truth {
            pose,
            height_m,
            roll_rad,
            pitch_rad,
            twist_in_body,
        } = truth;
        assert_eq!(pose, now.body.pose);
        assert_eq!(
            (height_m, roll_rad, pitch_rad, twist_in_body),
            (
                now.body.height_m,
                now.body.roll_rad,
                now.body.pitch_rad,
                now.body.twist_in_body
            )
        );
        assert_eq!(twist_ideal, kinematics.twist(&now.rates_rad_s));
        assert_eq!(
            twist_contact,
            contact.twist(&now.angles_rad, &now.rates_rad_s)
        );
        assert_eq!(measured, None, "no log");
        assert_eq!((imu, storage), (None, None), "no IMU, no passive law");
        let reckoned = reckoned.expect("rollers that say how they err");
        assert!((0..3).all(|axis| reckoned.pose_covariance[axis][axis] >= 0.0));
        assert_eq!(reckoned.twist, twist_ideal, "exact encoders");
        assert_eq!(seen_pose, pose, "exact sensors without latency");

        // Computed here as a sum over the steps, with the contact kinematics at their middle.
        if let Some(before) = step.checked_sub(1).map(|before| &seen[before]) {
            let turned = now.angles_rad.iter().zip(&before.angles_rad);
            let turned: Vec<f64> = turned.map(|(now, before)| now - before).collect();
            let middle = now.angles_rad.iter().zip(&turned);
            let middle: Vec<f64> = middle.map(|(now, turned)| now - 0.5 * turned).collect();
            odometry[0] = odometry[0].moved(kinematics.twist(&turned));
            odometry[1] = odometry[1].moved(contact.twist(&middle, &turned));
        }
        assert!(same(odometry_ideal, odometry[0]) < 1e-12);
        // In a step with a hand-over, its middle need not represent both rollers: below 2 % of a
        // step's path each.
        assert!(same(odometry_contact, odometry[1]) < 1e-3, "{t_s} s");

        let Desired {
            pose: wanted,
            velocity_in_world,
            position_error_max_m,
            heading_error_max_rad,
        } = desired.expect("a reference");
        let off_m = (wanted.position_m() - pose.position_m()).norm();
        assert_relative_eq!(position_error_max_m, off_m, epsilon = 1e-12);
        let off_rad = wrap_angle(wanted.heading_rad - pose.heading_rad).abs();
        assert_relative_eq!(heading_error_max_rad, off_rad, epsilon = 1e-12);
        // The circle starts at (0, 0), to the right of its centre, and is run through
        // counter-clockwise at 0.3 m/s.
        let angle_rad = 0.5 * t_s;
        let (sin, cos) = angle_rad.sin_cos();
        assert!(
            same(
                wanted,
                Pose {
                    x_m: 0.6 * cos - 0.6,
                    y_m: 0.6 * sin,
                    heading_rad: 0.0
                }
            ) < 1e-12
        );
        assert!(apart(velocity_in_world, Twist::new(-0.3 * sin, 0.3 * cos, 0.0)) < 1e-12);

        let asked = tasks
            .iter()
            .fold(Twist::default(), |sum, task| sum + task.asked_twist_in_body);
        assert!(
            apart(command_twist_in_body, asked) < 1e-12,
            "the tasks make the command"
        );
        let granted = tasks.iter().fold(Twist::default(), |sum, task| {
            sum + task.asked_twist_in_body.scaled(task.weight)
        });
        assert!(
            apart(granted_twist_in_body, granted) < 1e-12,
            "their weights make what is granted"
        );
        let samples = trace.wheels_at(step);
        targets.clear();
        targets.extend(samples.iter().map(|sample| sample.target_rad_s));
        assert_eq!(twist_target_ideal, kinematics.twist(&targets));
        assert!(
            apart(granted_twist_in_body, twist_target_ideal) < 1e-9,
            "ideal kinematics commands"
        );
        let mut left_rad_s = 9.0;
        // Beyond the tasks in use all values are zero.
        for task in &tasks[..trace.header.task_names.len()] {
            let TaskShare {
                asked_rad_s,
                capacity_rad_s,
                weight,
                asked_twist_in_body,
            } = *task;
            let mut rates = vec![0.0; 4];
            kinematics.wheel_rates(asked_twist_in_body, &mut rates);
            let largest = rates
                .iter()
                .fold(0.0_f64, |most, rate| most.max(rate.abs()));
            assert_relative_eq!(asked_rad_s, largest, epsilon = 1e-9);
            assert_relative_eq!(capacity_rad_s, left_rad_s, epsilon = 1e-9);
            // Eqs. (33)-(34): all of it, or as much as there is capacity for.
            let room = if capacity_rad_s < 1e-9 {
                0.0
            } else if asked_rad_s > capacity_rad_s {
                capacity_rad_s / asked_rad_s
            } else {
                1.0
            };
            // A task without demand may have any weight.
            if asked_rad_s > 1e-9 {
                assert_relative_eq!(weight, room, epsilon = 1e-9);
            }
            left_rad_s -= weight * asked_rad_s;
        }
        assert_eq!(
            (torque_weight_position, torque_weight_heading),
            (1.0, 1.0),
            "wheel loops weigh no tasks"
        );

        assert_eq!(
            (
                slip_energy_j,
                spin_up_energy_j,
                motor_energy_j,
                motor_positive_energy_j,
                bearing_energy_j,
                impact_energy_j
            ),
            (
                now.slip_j,
                now.spin_up_j,
                now.motor_j,
                now.motor_positive_j,
                now.bearing_j,
                now.impact_j
            )
        );
        // The push: 20 N along x times the path.
        if let Some(before) = step.checked_sub(1)
            && (0.4 - 1e-9..0.6 - 1e-9).contains(&(dt_s * before as f64))
        {
            outside_j += 20.0 * (pose.x_m - seen[before].body.pose.x_m);
        }
        assert!(
            (outside_energy_j - outside_j).abs() < 2e-3 * (1.0 + outside_j.abs()),
            "{t_s} s"
        );
        assert_eq!(
            (kinetic_energy_j, potential_energy_j),
            (now.energy.kinetic_j, now.energy.potential_j)
        );
        assert_eq!(contact_residual_m_s, now.residual_m_s);
        let Support {
            wheels_n,
            chassis_n,
            obstacles_x_n,
            obstacles_y_n,
        } = support.expect("what carried it");
        let (sin, cos) = pose.heading_rad.sin_cos();
        let [x_n, y_n] = now.support.obstacles_n.into();
        // A mean over one step is that step's value, to the rounding of a product and a quotient.
        for (recorded, seen) in [
            (wheels_n, now.support.wheels_n),
            (chassis_n, now.support.chassis_n),
            (obstacles_x_n, cos * x_n + sin * y_n),
            (obstacles_y_n, cos * y_n - sin * x_n),
        ] {
            assert_relative_eq!(recorded, seen, max_relative = 1e-9, epsilon = 1e-9);
        }
    }
    assert!(outside_j.abs() > 0.1, "the push did something");
    assert!(
        seen.last().expect("rows").slip_j > 0.1,
        "and something slid"
    );
}

/// The mean torques times the rates in the middles of the steps are the motors' work; the rates at
/// both ends approximate those in the middle to second order.
#[test]
fn torque_times_rate_is_the_work_of_the_motors() {
    let (_, trace, _) = run();
    let (mut work_j, mut positive_j) = (0.0, 0.0_f64);
    for step in 1..trace.records().len() {
        let (before, now) = (trace.wheels_at(step - 1), trace.wheels_at(step));
        for (before, now) in before.iter().zip(now) {
            let mean_rad_s = 0.5 * (now.rate_rad_s + before.rate_rad_s);
            let did_j = now.torque_n_m * mean_rad_s * 0.002;
            work_j += did_j;
            positive_j += did_j.max(0.0);
        }
    }
    let counted_j = trace.records().last().expect("rows").motor_energy_j;
    assert!(counted_j > 1.0, "{counted_j} J");
    assert_relative_eq!(work_j, counted_j, max_relative = 1e-3);
    // Positive and negative work add up to the same, wheel by wheel and row by row: rows here are
    // steps.
    let drove_j = trace
        .records()
        .last()
        .expect("rows")
        .motor_positive_energy_j;
    assert_relative_eq!(positive_j, drove_j, max_relative = 1e-3);
}

#[test]
fn every_signal_of_a_wheel_is_what_happened() {
    let (robot, trace, seen) = run();
    let weight_n = 9.81 * robot.mass_kg();
    let (mut carried_n, mut rows) = (0.0, 0);
    for (step, now) in seen.iter().enumerate() {
        let friction_of = |x_m: f64, y_m: f64| {
            let inside = x_m.abs() <= 0.15 && (y_m - 0.2).abs() <= 0.15;
            if inside { 0.05 } else { 0.5 }
        };
        for (wheel, sample) in trace.wheels_at(step).iter().enumerate() {
            let WheelSample {
                target_rad_s,
                target_peak_rad_s,
                rate_rad_s,
                rate_error_rms_rad_s,
                angle_rad,
                torque_n_m,
                torque_min_n_m,
                torque_max_n_m,
                hub_height_m,
                hub_height_min_m,
                hub_height_max_m,
                roller,
                touching,
                load_share,
                roller_spin_rad_s,
                roller_spin_ideal_rad_s,
                touching_share,
                contact_x_m,
                contact_y_m,
                normal_force_n,
                normal_force_min_n,
                normal_force_max_n,
                force_x_n,
                force_y_n,
                friction,
                friction_used_max,
                slip_x_m_s,
                slip_y_m_s,
                slip_speed_rms_m_s,
                slip_speed_max_m_s,
                slip_energy_j,
                spin_up_energy_j,
            } = *sample;
            let contact = &now.contacts[wheel];
            assert!(target_rad_s.abs() <= 9.0 + 1e-9, "the limit holds");
            assert_eq!(target_peak_rad_s, target_rad_s.abs());
            // The mean square of a difference that changed evenly over the one step of the period.
            let off_rad_s = step.checked_sub(1).map_or(0.0, |before| {
                let before = &trace.wheels_at(before)[wheel];
                let [a, b] = [before.rate_rad_s, rate_rad_s]
                    .map(|rate_rad_s| rate_rad_s - before.target_rad_s);
                ((a * a + a * b + b * b) / 3.0).sqrt()
            });
            assert_relative_eq!(
                rate_error_rms_rad_s,
                off_rad_s,
                max_relative = 1e-12,
                epsilon = 1e-12
            );
            assert_eq!(
                (rate_rad_s, angle_rad, hub_height_m),
                (
                    now.rates_rad_s[wheel],
                    now.angles_rad[wheel],
                    now.hubs_m[wheel]
                )
            );
            // A period of one step: the extremes are the means.
            assert_eq!([hub_height_min_m, hub_height_max_m], [hub_height_m; 2]);
            assert_eq!([torque_min_n_m, torque_max_n_m], [torque_n_m; 2]);
            assert_eq!(
                [normal_force_min_n, normal_force_max_n],
                [normal_force_n; 2]
            );
            assert_relative_eq!(
                torque_n_m,
                now.torques_n_m[wheel],
                max_relative = 1e-12,
                epsilon = 1e-12
            );
            let powers = seen[..=step].iter().map(|seen| seen.contacts[wheel]);
            let (slip_w, spin_up_w) = powers.fold((0.0, 0.0), |(slip, spin), contact| {
                (slip + contact.slip_power_w, spin + contact.spin_up_power_w)
            });
            assert_relative_eq!(
                slip_energy_j,
                0.002 * slip_w,
                max_relative = 1e-9,
                epsilon = 1e-12
            );
            assert_relative_eq!(
                spin_up_energy_j,
                0.002 * spin_up_w,
                max_relative = 1e-9,
                epsilon = 1e-12
            );
            assert_eq!(touching, contact.touching);
            assert!(touching_share > 0.0 || !touching);
            if touching_share == 0.0 {
                let nothing = [
                    load_share,
                    contact_x_m,
                    contact_y_m,
                    normal_force_n,
                    force_x_n,
                    force_y_n,
                    friction,
                    friction_used_max,
                    slip_x_m_s,
                    slip_y_m_s,
                    slip_speed_rms_m_s,
                    slip_speed_max_m_s,
                    roller_spin_rad_s,
                    roller_spin_ideal_rad_s,
                ];
                assert_eq!((roller, nothing), (0, [0.0; 14]));
                continue;
            }
            carried_n += normal_force_n;
            assert_eq!(
                (roller as usize, load_share),
                (contact.roller, contact.load_share)
            );
            // Means over a step, to the rounding of a product and a quotient.
            for (recorded, seen) in [
                (normal_force_n, contact.normal_force_n),
                (contact_x_m, contact.place_in_body_m.x),
                (contact_y_m, contact.place_in_body_m.y),
                (force_x_n, contact.force_in_body_n.x),
                (force_y_n, contact.force_in_body_n.y),
                (slip_x_m_s, contact.sliding_in_body_m_s.x),
                (slip_y_m_s, contact.sliding_in_body_m_s.y),
            ] {
                assert_relative_eq!(recorded, seen, max_relative = 1e-12, epsilon = 1e-15);
            }
            // Coulomb: at most the limit in any part of the step, and at least the share of the
            // means.
            let used = force_x_n.hypot(force_y_n) / (friction * normal_force_n);
            assert!(friction_used_max >= used * (1.0 - 1e-9) && friction_used_max <= 1.0 + 1e-6);
            let sliding_m_s = slip_x_m_s.hypot(slip_y_m_s);
            assert!(slip_speed_rms_m_s >= sliding_m_s * (1.0 - 1e-9));
            assert!(slip_speed_max_m_s >= slip_speed_rms_m_s * (1.0 - 1e-9));
            // Unless the place is too near to the patch's edge, it has the friction there.
            let pose = now.body.pose;
            let (sin, cos) = pose.heading_rad.sin_cos();
            let x_m = pose.x_m + cos * contact_x_m - sin * contact_y_m;
            let y_m = pose.y_m + sin * contact_x_m + cos * contact_y_m;
            let near_edge = [[0.002, 0.0], [-0.002, 0.0], [0.0, 0.002], [0.0, -0.002]]
                .iter()
                .any(|[dx, dy]| friction_of(x_m + dx, y_m + dy) != friction_of(x_m, y_m));
            if !near_edge {
                assert_relative_eq!(friction, friction_of(x_m, y_m), max_relative = 1e-12);
            }
            // The place is under the wheel: at most a roller's length from its middle.
            let middle_m = robot.wheels[wheel].position_m();
            let off_m = (contact_x_m - middle_m.x).hypot(contact_y_m - middle_m.y);
            assert!(off_m < 0.04, "{off_m} m");
            assert_relative_eq!(
                roller_spin_rad_s,
                now.spins_rad_s[wheel][roller as usize],
                epsilon = 1e-9
            );
            // A roller that does not slide spins at the rate that rolling requires.
            if slip_speed_max_m_s < 1e-6 && load_share == 1.0 {
                assert!((roller_spin_rad_s - roller_spin_ideal_rad_s).abs() < 1e-3);
            }
        }
        rows += 1;
    }
    // Over the whole run the floor carries the robot's weight: its vertical motion is at most a
    // kerb's height, and it is at rest across the floor.
    let mean_n = carried_n / f64::from(rows);
    assert_relative_eq!(mean_n, weight_n, max_relative = 0.01);
}
