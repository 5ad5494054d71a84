//! Section III-A: the dynamic model, eq. (11).

use ilon_control::DynamicModel;
use ilon_robot::{Robot, Twist, Wheel};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

use crate::paper::fixtures::{mecanum4, six_wheels, volksbot};
use crate::paper::random::{any_robot, cases};

/// Robots A, B and the six-wheel one, with losses and a payload off the middle.
fn robots() -> Vec<Robot> {
    let mut robots = vec![mecanum4(), volksbot(), six_wheels()];
    for robot in &mut robots {
        robot.chassis.mass.center_of_mass_m = Vector3::new(0.06, -0.03, 0.1);
        for wheel in &mut robot.wheels {
            wheel.joint.damping_n_m_s = 2e-3;
            for roller in &mut wheel.rollers {
                roller.joint.damping_n_m_s = 3e-5;
            }
        }
    }
    robots
}

fn model(robot: &Robot) -> DynamicModel {
    DynamicModel::new(robot).unwrap()
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn eq_11_any_robot_has_the_papers_structure((robot, _) in any_robot(), omega in -3.0..3.0_f64) {
        let model = model(&robot);
        let i = model.inertia();
        prop_assert!((i - i.transpose()).norm() < 1e-12 * i.norm());
        prop_assert!(i.symmetric_eigenvalues().min() > 0.0);
        let c = model.coriolis(omega);
        prop_assert!((&c + c.transpose()).norm() < 1e-12 * (1.0 + c.norm()));
        prop_assert!((model.coriolis(2.0 * omega) - &c * 2.0).norm() < 1e-12 * (1.0 + c.norm()));
        prop_assert!(model.damping_n_m_s().iter().all(|d| *d >= 0.0));
    }
}

#[test]
fn eq_11_inertia_is_positive_definite_coriolis_skew_and_linear_friction_diagonal() {
    for robot in robots() {
        let model = model(&robot);
        let i = model.inertia();
        assert!((i - i.transpose()).norm() < 1e-15 * i.norm().max(1.0));
        assert!(i.symmetric_eigenvalues().min() > 0.0);
        let c = model.coriolis(0.7);
        assert!(c.norm() > 0.0 && (&c + c.transpose()).norm() < 1e-15);
        assert!((model.coriolis(2.1) - c * 3.0).norm() < 1e-15);
        assert!(model.damping_n_m_s().iter().all(|d| *d >= 0.0));
        assert!(model.bearing_drag().symmetric_eigenvalues().min() > -1e-15);
    }
}

/// The kinetic energy summed body by body from their velocities, without the matrices of the model.
fn energy_by_bodies_j(robot: &Robot, twist: Twist, rates: &[f64]) -> f64 {
    let at = |p: Vector3<f64>| {
        let omega = twist.omega_rad_s;
        Vector3::new(twist.vx_m_s - omega * p.y, twist.vy_m_s + omega * p.x, 0.0)
    };
    let body = Vector3::new(0.0, 0.0, twist.omega_rad_s);
    let solid = |mass_kg: f64, v: Vector3<f64>, inertia: Matrix3<f64>, w: Vector3<f64>| {
        0.5 * mass_kg * v.norm_squared() + 0.5 * w.dot(&(inertia * w))
    };
    let c = &robot.chassis.mass;
    let mut sum = solid(c.mass_kg, at(c.center_of_mass_m), c.inertia_kg_m2, body);
    for (wheel, rate) in robot.wheels.iter().zip(rates) {
        let turn = wheel
            .body_from_hub
            .rotation
            .to_rotation_matrix()
            .into_inner();
        let w = body + turn * Vector3::new(0.0, 0.0, *rate);
        let hub_inertia = turn * wheel.hub.inertia_kg_m2 * turn.transpose();
        sum += solid(wheel.hub.mass_kg, at(wheel.position_m()), hub_inertia, w);
        for (j, r) in wheel.rollers.iter().enumerate() {
            let center = wheel.body_from_hub * nalgebra::Point3::from(r.center_in_hub_m);
            let v = at(wheel.position_m()) + w.cross(&(center.coords - wheel.position_m()));
            let a = turn * r.axis_in_hub.into_inner();
            let mut w_roller = w;
            if j == touching(wheel) {
                // Rolling: the velocity of the material at the ground is zero across the axis.
                let down = -wheel.radius_m * Vector3::z();
                let material = at(wheel.position_m()) + w.cross(&down);
                let e = a.cross(&Vector3::z());
                w_roller += a * material.dot(&e) / r.radius_m;
            }
            let own = Matrix3::identity() * r.transverse_inertia_kg_m2
                + a * a.transpose() * (r.axial_inertia_kg_m2 - r.transverse_inertia_kg_m2);
            sum += solid(r.mass_kg, v, own, w_roller);
        }
    }
    sum
}

fn touching(wheel: &Wheel) -> usize {
    let off = |j: &usize| wheel.rollers[*j].place_rad().abs();
    (0..wheel.rollers.len())
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .unwrap()
}

#[test]
fn eq_11_inertia_gives_the_kinetic_energy_of_all_bodies() {
    for robot in robots() {
        let model = model(&robot);
        for twist in [
            Twist::new(0.4, 0.0, 0.0),
            Twist::new(0.0, 0.3, 0.0),
            Twist::new(0.0, 0.0, 1.5),
            Twist::new(0.2, -0.3, 0.8),
        ] {
            let mut rates = vec![0.0; robot.wheels.len()];
            model.kinematics().wheel_rates(twist, &mut rates);
            let (by_model, by_bodies) = (
                model.kinetic_energy_j(&rates),
                energy_by_bodies_j(&robot, twist, &rates),
            );
            // The two differ by what cancels out of the mean over a wheel's turn: the products of
            // the touching roller's spin with the body's own yaw vanish because roller axes are
            // level there. Rounding remains.
            assert!(
                (by_model / by_bodies - 1.0).abs() < 1e-12,
                "{twist:?}: {by_model} against {by_bodies}"
            );
        }
    }
}

#[test]
fn eq_11_power_of_the_torques_is_energy_gained_and_energy_lost() {
    for robot in robots() {
        let model = model(&robot);
        let n = robot.wheels.len();
        let mut rates = vec![0.0; n];
        model
            .kinematics()
            .wheel_rates(Twist::new(0.3, -0.2, 1.1), &mut rates);
        let torques: Vec<_> = (0..n).map(|h| 0.1 - 0.07 * h as f64).collect();
        let (mut scratch, mut acceleration) = (vec![0.0; n], vec![0.0; n]);
        model.accelerations(&rates, &torques, &mut scratch, &mut acceleration);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        // d/dt (q'^T I q' / 2) = q'^T I q''; C is skew and does no work.
        let i_acceleration = model.inertia() * nalgebra::DVector::from_vec(acceleration);
        let gained = product(&rates, i_acceleration.as_slice());
        let drag = model.bearing_drag() * nalgebra::DVector::from_vec(rates.clone());
        let damping: f64 = rates
            .iter()
            .zip(model.damping_n_m_s())
            .map(|(r, d)| d * r * r)
            .sum();
        let lost = damping + product(&rates, drag.as_slice());
        let given = product(&torques, &rates);
        assert!(lost > 0.0);
        assert!(
            (given - gained - lost).abs() < 1e-12,
            "{given} {gained} {lost}"
        );
    }
}

#[test]
fn eq_11_accelerations_keep_the_wheels_rolling_and_undo_the_torques() {
    for robot in robots() {
        let model = model(&robot);
        let n = robot.wheels.len();
        let (mut rates, mut wanted) = (vec![0.0; n], vec![0.0; n]);
        model
            .kinematics()
            .wheel_rates(Twist::new(0.3, 0.2, -0.9), &mut rates);
        model
            .kinematics()
            .wheel_rates(Twist::new(-0.5, 0.8, 1.2), &mut wanted);
        let (mut torques, mut scratch, mut got) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        model.torques(&rates, &wanted, &mut torques);
        model.accelerations(&rates, &torques, &mut scratch, &mut got);
        for (got, wanted) in got.iter().zip(&wanted) {
            assert!((got - wanted).abs() < 1e-10);
        }
    }
}

#[test]
fn eq_11_a_point_mass_pushed_ahead_accelerates_by_newton() {
    // Robot A without wheel and roller inertia is a rigid body: torque tau on every wheel pushes
    // with 4 tau / rho straight ahead, and a = F / m.
    let mut robot = mecanum4();
    for wheel in &mut robot.wheels {
        wheel.hub.inertia_kg_m2 *= 0.0;
        for roller in &mut wheel.rollers {
            (roller.mass_kg, roller.axial_inertia_kg_m2) = (0.0, 0.0);
            roller.transverse_inertia_kg_m2 = 0.0;
        }
    }
    let model = model(&robot);
    let rate = model.twist_rate(&[0.0; 4], &[0.1; 4], &mut [0.0; 4]);
    let expected = 4.0 * 0.1 / 0.05 / robot.mass_kg();
    assert!((rate.vx_m_s - expected).abs() < 1e-12);
    assert!(rate.vy_m_s.abs() < 1e-12 && rate.omega_rad_s.abs() < 1e-12);
}

#[test]
fn eq_11_coriolis_holds_a_free_bodys_momentum_straight_in_the_world() {
    // Without torques and losses the robot coasts: wheels and rollers aside, a turning body whose
    // centre of mass is its origin keeps its velocity in the world, so in the body frame v' =
    // -omega k x v.
    let mut robot = volksbot();
    for wheel in &mut robot.wheels {
        wheel.hub.inertia_kg_m2 *= 0.0;
        for roller in &mut wheel.rollers {
            (roller.mass_kg, roller.axial_inertia_kg_m2) = (0.0, 0.0);
            roller.transverse_inertia_kg_m2 = 0.0;
        }
    }
    let model = model(&robot);
    let twist = Twist::new(0.3, 0.1, 0.8);
    let mut rates = [0.0; 3];
    model.kinematics().wheel_rates(twist, &mut rates);
    let rate = model.twist_rate(&rates, &[0.0; 3], &mut [0.0; 3]);
    assert!((rate.vx_m_s - 0.8 * 0.1).abs() < 1e-12);
    assert!((rate.vy_m_s + 0.8 * 0.3).abs() < 1e-12);
    assert!(rate.omega_rad_s.abs() < 1e-12);
}

#[test]
fn torques_that_only_strain_the_floor_accelerate_nothing() {
    let robot = mecanum4();
    let model = model(&robot);
    // The columns of R are along (1, 1, 1, 1), (-1, 1, 1, -1) and (-1, 1, -1, 1); the second torque
    // is across all.
    let turning = model.twist_rate(&[0.0; 4], &[-0.3, 0.3, -0.3, 0.3], &mut [0.0; 4]);
    let still = model.twist_rate(&[0.0; 4], &[1.0, 1.0, -1.0, -1.0], &mut [0.0; 4]);
    assert!(turning.omega_rad_s > 1.0);
    assert!(still.linear_m_s().norm() < 1e-12 && still.omega_rad_s.abs() < 1e-12);
}
