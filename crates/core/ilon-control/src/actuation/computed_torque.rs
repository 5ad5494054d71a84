//! Computed torque, eq. (12): the centralised low-level control of section III-A.
//!
//! The law tau = (C(omega) + F) q' + I y cancels the couplings in (11) and leaves q'' = y. With the
//! rate error e = q'_d - q' and y = q''_d + k_p e + k_i integral(e), each wheel's error obeys e' +
//! k_p e + k_i integral(e) = 0 independently. k_p = w_b and k_i = w_b^2 / 4 put both poles at -w_b
//! / 2: critically damped.
//!
//! **Bandwidth limit.** If the torque is held over dt, the loop of the rolling robot is that of
//! [`WheelGains`](crate::WheelGains) with a = k_p dt, whatever the inertia. But wheels that slide
//! or hang in the air feel only their own inertia J_air, while the torques are computed for the
//! whole robot. Their errors follow the matrix k_p dt I / J_air, whose largest eigenvalue is a =
//! k_p dt J_ground / J_air. As there, a <= 1 is kept: k_p = min(w_b, J_air / (J_ground dt)).

use ilon_robot::Robot;

use super::derivative::{FilteredDerivative, weight};
use super::{Demand, TorqueLaw};
use crate::error::{not_negative, positive};
use crate::{ControlError, DynamicModel};

/// Settings of the computed-torque law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputedTorqueSettings {
    /// Requested bandwidth w_b of the rate loops, in rad/s.
    pub bandwidth_rad_s: f64,
    /// Time constant of the low-pass filter on the targets' derivative q''_d, in seconds; 0 for
    /// none. If the targets change more slowly than the loop runs, choose about their period.
    pub target_filter_s: f64,
    /// The longest update period, in seconds.
    pub dt_s: f64,
}

/// Computed torque for all wheels together. It replaces a [`WheelLoop`](crate::WheelLoop): same
/// inputs, same output.
#[derive(Clone, Debug)]
pub struct ComputedTorque {
    model: DynamicModel,
    k_p: f64,
    target_filter_s: f64,
    wheels: Vec<WheelState>,
    /// y of eq. (12), in rad/s^2.
    y_rad_s2: Vec<f64>,
    torques_n_m: Vec<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct WheelState {
    /// k_i integral(e), in rad/s^2.
    integral_rad_s2: f64,
    /// Filtered q''_d, in rad/s^2.
    target_acceleration_rad_s2: FilteredDerivative<f64>,
}

impl ComputedTorque {
    /// Builds the law (12) from a robot's model.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`], [`ControlError::Negative`] for settings out of range.
    pub fn new(
        model: DynamicModel,
        settings: &ComputedTorqueSettings,
    ) -> Result<Self, ControlError> {
        let w_b = positive(
            "the computed torque's bandwidth in rad/s",
            settings.bandwidth_rad_s,
        )?;
        let dt_s = positive("the computed torque's period in s", settings.dt_s)?;
        let target_filter_s = not_negative(
            "the target filter's time constant in s",
            settings.target_filter_s,
        )?;
        let n = model.kinematics().wheel_count();
        Ok(Self {
            k_p: model.bandwidth_rad_s(w_b, dt_s),
            model,
            target_filter_s,
            wheels: vec![WheelState::default(); n],
            y_rad_s2: vec![0.0; n],
            torques_n_m: vec![0.0; n],
        })
    }
}

impl TorqueLaw for ComputedTorque {
    /// Eq. (12), plus compensation of the rollers' drag and of dry friction. Dry friction is
    /// compensated in the targets' direction, so a wheel at rest gets none. A wheel's integral is
    /// frozen while its torque is at the limit and its error would drive it further beyond.
    fn step(&mut self, demand: &Demand<'_>) {
        let Demand {
            targets_rad_s: targets,
            rates_rad_s: rates,
            limits,
            dt_s,
        } = *demand;
        let (k_p, k_i) = (self.k_p, 0.25 * self.k_p * self.k_p);
        let weight = weight(self.target_filter_s, dt_s);
        let errors = targets
            .iter()
            .zip(rates)
            .map(|(target, rate)| target - rate);

        for (((wheel, y), target), e) in self
            .wheels
            .iter_mut()
            .zip(&mut self.y_rad_s2)
            .zip(targets)
            .zip(errors.clone())
        {
            let target_acceleration = &mut wheel.target_acceleration_rad_s2;
            target_acceleration.update(*target, weight, dt_s);
            wheel.integral_rad_s2 += k_i * e * dt_s;
            *y = target_acceleration.value + k_p * e + wheel.integral_rad_s2;
        }

        // Eq. (12).
        self.model
            .resistance_towards(rates, targets, &mut self.torques_n_m);
        self.model
            .add_inertia_times(&self.y_rad_s2, &mut self.torques_n_m);

        for (((wheel, torque_n_m), limit), e) in self
            .wheels
            .iter_mut()
            .zip(&mut self.torques_n_m)
            .zip(limits)
            .zip(errors)
        {
            let (too_high, too_low) = (*torque_n_m > limit.max_n_m, *torque_n_m < limit.min_n_m);
            if (too_high && e > 0.0) || (too_low && e < 0.0) {
                wheel.integral_rad_s2 -= k_i * e * dt_s;
            }
            *torque_n_m = limit.clamp(*torque_n_m);
        }
    }

    fn torques_n_m(&self) -> &[f64] {
        &self.torques_n_m
    }

    fn stand(&mut self, posed: &Robot) {
        if let Ok(model) = DynamicModel::new(posed) {
            self.model = model;
        }
    }

    fn boxed(&self) -> Box<dyn TorqueLaw> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TorqueRange;
    use crate::tests::joints::{driven, joint};
    use crate::tests::robots::{mecanum4, six_wheels, volksbot};
    use ilon_robot::{Robot, Twist};
    use nalgebra::Vector3;

    fn law(robot: &Robot, bandwidth_rad_s: f64, dt_s: f64) -> ComputedTorque {
        let model = DynamicModel::new(robot).unwrap();
        let settings = ComputedTorqueSettings {
            bandwidth_rad_s,
            target_filter_s: 0.0,
            dt_s,
        };
        ComputedTorque::new(model, &settings).unwrap()
    }

    /// Integrates the model (11) under the law from rest, with the targets of `twist_at` and the
    /// torque held over each step of `dt_s`. Returns the largest rate error after `settle_s`, in
    /// rad/s.
    fn worst_error(
        robot: &Robot,
        law: &mut ComputedTorque,
        twist_at: impl Fn(f64) -> Twist,
        (dt_s, settle_s, end_s): (f64, f64, f64),
    ) -> f64 {
        let model = DynamicModel::new(robot).unwrap();
        let n = robot.wheels.len();
        let open = vec![TorqueRange::UNLIMITED; n];
        let (mut rates, mut targets) = (vec![0.0; n], vec![0.0; n]);
        let (mut scratch, mut accelerations) = (vec![0.0; n], vec![0.0; n]);
        let (mut worst, mut t_s) = (0.0_f64, 0.0);
        while t_s < end_s {
            model.kinematics().wheel_rates(twist_at(t_s), &mut targets);
            let torques = law
                .update(&Demand::new(&targets, &rates, &open, dt_s))
                .to_vec();
            model.accelerations(&rates, &torques, &mut scratch, &mut accelerations);
            for ((rate, acceleration), target) in rates.iter_mut().zip(&accelerations).zip(&targets)
            {
                if t_s > settle_s {
                    worst = worst.max((target - *rate).abs());
                }
                *rate += acceleration * dt_s;
            }
            t_s += dt_s;
        }
        worst
    }

    #[test]
    fn eq_12_rates_follow_a_fast_turning_reference() {
        for mut robot in [mecanum4(), volksbot(), six_wheels()] {
            robot.chassis.mass.center_of_mass_m.x = 0.07;
            for wheel in &mut robot.wheels {
                wheel.joint.damping_n_m_s = 5e-3;
            }
            let twist_at =
                |t: f64| Twist::new(0.5 * (2.0 * t).sin(), 0.3 * (3.0 * t).cos(), 2.0 * t.sin());
            let mut law = law(&robot, 20.0, 1e-3);
            let error = worst_error(&robot, &mut law, twist_at, (1e-3, 1.0, 4.0));
            // Rates reach 20 rad/s and 60 rad/s^2. A derivative taken one step late has an error of
            // q''' dt, below 0.3 rad/s^2, which a loop of 20 rad/s turns into 0.3 / 20 = 0.015
            // rad/s; one step of lag adds q'' dt = 0.06.
            assert!(error < 0.08, "{error}");
        }
    }

    #[test]
    fn eq_12_each_rate_error_decays_by_itself_as_the_design_says() {
        let robot = six_wheels();
        let (bandwidth, dt_s) = (20.0, 1e-5);
        let mut law = law(&robot, bandwidth, dt_s);
        let model = law.model.clone();
        let (mut targets, mut rates) = ([0.0; 6], [0.0; 6]);
        model
            .kinematics()
            .wheel_rates(Twist::new(0.3, -0.2, 0.8), &mut targets);
        let open = [TorqueRange::UNLIMITED; 6];
        let (mut scratch, mut accelerations) = ([0.0; 6], [0.0; 6]);
        for _ in 0..10_000 {
            let torques = law
                .update(&Demand::new(&targets, &rates, &open, dt_s))
                .to_vec();
            model.accelerations(&rates, &torques, &mut scratch, &mut accelerations);
            for (rate, acceleration) in rates.iter_mut().zip(accelerations) {
                *rate += acceleration * dt_s;
            }
        }
        // e' + w e + (w^2/4) integral(e) = 0 from e(0) = target has the solution e(t) = target (1 -
        // w t / 2) exp(-w t / 2), which is zero at t = 2 / w = 0.1 s. An Euler step of 1e-5 s has
        // an error of about w^2 t dt / 8 = 5e-5 of the target.
        for (target, rate) in targets.iter().zip(rates) {
            assert!(((target - rate) / target).abs() < 3e-4, "{target} {rate}");
        }
    }

    /// A law updated to a pose gives the same torques as one built in that pose: an arm swung out
    /// needs other torques.
    #[test]
    fn eq_12_takes_masses_where_the_joints_have_them() {
        let mut robot = mecanum4();
        let mass = (3.0, 0.5 * Vector3::x());
        robot
            .joints
            .push(driven(joint(0.1 * Vector3::z(), Vector3::z(), mass)));
        let posed = robot.posed(&[1.2]);
        let [mut unmoved, mut stands, mut made] =
            [&robot, &robot, &posed].map(|robot| ComputedTorque {
                k_p: 20.0,
                ..law(robot, 20.0, 1e-3)
            });
        let open = [TorqueRange::UNLIMITED; 4];
        let (targets, rates) = ([5.0, -3.0, 2.0, 4.0], [4.0, -3.5, 2.0, 4.5]);
        let before = unmoved
            .update(&Demand::new(&targets, &rates, &open, 1e-3))
            .to_vec();
        stands.stand(&posed);
        let torques = stands
            .update(&Demand::new(&targets, &rates, &open, 1e-3))
            .to_vec();
        assert_eq!(
            torques,
            made.update(&Demand::new(&targets, &rates, &open, 1e-3))
        );
        let furthest = torques.iter().zip(&before).map(|(a, b)| (a - b).abs());
        let most = torques.iter().fold(0.0, |most: f64, of| most.max(of.abs()));
        assert!(furthest.fold(0.0, f64::max) > 0.01 * most);
    }

    #[test]
    fn wheels_in_the_air_hold_the_bandwidth_down_and_stay_stable() {
        let robot = mecanum4();
        let dt_s = 1.0 / 240.0;
        let mut law = law(&robot, 1000.0, dt_s);
        let j_air = law.model.air_inertia_kg_m2();
        assert!(law.k_p < 1000.0);
        let mut rates = [0.0; 4];
        let open = [TorqueRange::UNLIMITED; 4];
        for _ in 0..5000 {
            let torques = law
                .update(&Demand::new(&[5.0, -3.0, 2.0, 4.0], &rates, &open, dt_s))
                .to_vec();
            for (rate, torque) in rates.iter_mut().zip(torques) {
                *rate += dt_s / j_air * torque;
                assert!(rate.abs() < 15.0);
            }
        }
        for (rate, target) in rates.iter().zip([5.0, -3.0, 2.0, 4.0]) {
            assert!((rate - target).abs() < 0.01, "{rates:?}");
        }
    }

    #[test]
    fn the_integral_does_not_wind_up_while_the_motors_are_at_their_limit() {
        let robot = volksbot();
        let mut law = law(&robot, 20.0, 1e-2);
        let limit = [TorqueRange {
            min_n_m: -0.1,
            max_n_m: 0.1,
        }; 3];
        for _ in 0..10_000 {
            let torques = law.update(&Demand::new(&[50.0, 50.0, 50.0], &[0.0; 3], &limit, 0.01));
            assert!(torques.iter().all(|t| *t == 0.1));
        }
        let torques = law.update(&Demand::new(&[50.0; 3], &[51.0; 3], &limit, 0.01));
        assert!(torques.iter().all(|t| *t < 0.1), "{torques:?}");
    }

    /// The reference brakes so hard that the motors are at their limits, while the wheels are a
    /// little behind it. An error that leads back from the limit must be integrated as without a
    /// limit, in both directions.
    #[test]
    fn an_error_that_leads_back_from_the_limit_is_summed_as_without_one() {
        let robot = volksbot();
        let limit = [TorqueRange {
            min_n_m: -0.1,
            max_n_m: 0.1,
        }; 3];
        let open = [TorqueRange::UNLIMITED; 3];
        for way in [1.0, -1.0] {
            let (mut limited, mut free) = (law(&robot, 20.0, 0.01), law(&robot, 20.0, 0.01));
            for law in [&mut limited, &mut free] {
                law.update(&Demand::new(
                    &[way * 50.0; 3],
                    &[way * 50.0; 3],
                    &open,
                    0.01,
                ));
            }
            let (targets, rates) = ([way * 5.0; 3], [way * 4.5; 3]);
            let torques = limited
                .update(&Demand::new(&targets, &rates, &limit, 0.01))
                .to_vec();
            assert!(torques.iter().all(|torque| *torque == -0.1 * way));
            free.update(&Demand::new(&targets, &rates, &open, 0.01));
            let after = limited
                .update(&Demand::new(&targets, &rates, &open, 0.01))
                .to_vec();
            assert_eq!(
                after,
                free.update(&Demand::new(&targets, &rates, &open, 0.01))
            );
        }
    }
}
