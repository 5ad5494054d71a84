//! Writes down what happens, once a control period or less often.

use std::borrow::Cow;

use ilon_control::{ContactKinematics, Kinematics, Odometry, OdometryCovariance, WayErrors};
use ilon_robot::{Pose, Robot};
use ilon_trace::{
    Desired, Header, JointSample, MAX_JOINTS, MAX_TASKS, Reckoned, Record, Support, TaskShare,
    Trace, WheelSample,
};
use ilon_world::World;
use nalgebra::Vector2;

use super::bodies;
use super::command::Decided;
use super::header::{Appearance, header};
use super::hubs::{self, Hubs};
use super::pilot::{Idle, Pilot};
use super::plant::Plant;
use super::posed_odometry::PosedOdometry;
use crate::Error;
use crate::scenario::{Scenario, TIME_SLACK_S};

/// Writes down what happens to a [`Plant`]: the growing trace, and what has to be summed between its rows.
///
/// For a loop of one's own around a plant, once a control period: [`Recorder::reckon`] with the angles that were seen, decide,
/// [`Recorder::record`], and [`Recorder::count`] after every physics step of [`Plant::advance_watched`].
pub struct Recorder {
    trace: Trace,
    kinematics: Kinematics,
    contact_kinematics: ContactKinematics,
    odometry_ideal: Pose,
    /// With all joints between bodies where they are, of a robot that has some.
    posed: Option<PosedOdometry>,
    /// With those where they are that the robot measures, of a robot whose wheels they move, and which they are.
    measured: Option<(PosedOdometry, Vec<bool>)>,
    odometry_contact: Odometry,
    /// Of `odometry_ideal`; of a robot whose rollers say how it errs.
    covariance: Option<OdometryCovariance>,
    control_dt_s: f64,
    /// From row to row.
    row_period_s: f64,
    last_angles_rad: Vec<f64>,
    turned_rad: Vec<f64>,
    /// Of each wheel, since the start or the last row.
    sums: Vec<WheelSums>,
    /// The largest since the last row.
    residual_m_s: f64,
    /// Of the whole robot, since the last row.
    carried: Carried,
    samples: Vec<WheelSample>,
    /// Seconds between samples of the rollers' angles, where they are recorded, and how many have been taken.
    rollers_every_s: Option<f64>,
    rollers_taken: u64,
}

/// What is summed of a wheel between rows.
#[derive(Clone, Copy, Debug, Default)]
struct WheelSums {
    /// Since the start, in J.
    slip_j: f64,
    spin_up_j: f64,
    /// Of the motor since the last row: angular impulse in N m s, and time in s.
    angular_n_m_s: f64,
    time_s: f64,
}

/// What is summed of the whole robot between rows: impulses in the world frame in N s, and time in s.
#[derive(Clone, Copy, Debug, Default)]
struct Carried {
    wheels_n_s: f64,
    chassis_n_s: f64,
    obstacles_n_s: Vector2<f64>,
    time_s: f64,
}

/// The share of a wheel's way that a controller takes to slip, where it does not know: what rollers of steel and rubber lose by creep and by
/// handing over.
const SLIP_SHARE: f64 = 0.005;

impl Carried {
    /// Means along a heading, in N.
    fn means(&self, heading_rad: f64) -> Support {
        if self.time_s <= 0.0 {
            return Support::default();
        }
        let (sin, cos) = libm::sincos(heading_rad);
        let obstacles_n = self.obstacles_n_s / self.time_s;
        Support {
            wheels_n: self.wheels_n_s / self.time_s,
            chassis_n: self.chassis_n_s / self.time_s,
            obstacles_x_n: cos * obstacles_n.x + sin * obstacles_n.y,
            obstacles_y_n: cos * obstacles_n.y - sin * obstacles_n.x,
        }
    }
}

impl Recorder {
    #[allow(clippy::too_many_arguments)]
    pub(super) fn new(
        header: Header,
        robot: &Robot,
        kinematics: Kinematics,
        contact_kinematics: ContactKinematics,
        start: Pose,
        rows: usize,
        scenario: &Scenario,
    ) -> Self {
        let wheel_count = robot.wheels.len();
        let errors = WayErrors::of_rollers(robot, SLIP_SHARE).map(|errors| WayErrors {
            rate_noise_rad_s: scenario.sensors.encoders.rate_noise_rad_s,
            ..errors
        });
        let roller_angles_hz = scenario.run.roller_angles_hz;
        Self {
            covariance: errors
                .and_then(|errors| OdometryCovariance::new(kinematics.clone(), errors))
                .ok(),
            control_dt_s: header.control_dt_s,
            row_period_s: header.control_dt_s * f64::from(header.record_every.max(1)),
            trace: Trace::with_capacity(header, rows),
            kinematics,
            odometry_ideal: start,
            posed: (!robot.joints.is_empty()).then(|| PosedOdometry::new(robot, start)),
            measured: Hubs::that_move(robot)
                .map(|_| (PosedOdometry::new(robot, start), hubs::measured(robot))),
            odometry_contact: Odometry::new(contact_kinematics.clone(), start, &[]),
            contact_kinematics,
            last_angles_rad: vec![0.0; wheel_count],
            turned_rad: vec![0.0; wheel_count],
            sums: vec![WheelSums::default(); wheel_count],
            residual_m_s: 0.0,
            carried: Carried::default(),
            samples: vec![WheelSample::default(); wheel_count],
            rollers_every_s: roller_angles_hz.map(|rate_hz| 1.0 / rate_hz),
            rollers_taken: 0,
        }
    }

    /// For a loop of one's own around this plant, which stands at its start: its rows are once a control period, and time counts
    /// from zero. `urdf` is [`ilon_formats::Loaded::urdf`], or empty.
    ///
    /// # Errors
    /// [`Error`] where the scenario cannot be written as text.
    pub fn of_plant(plant: &Plant, urdf: &str) -> Result<Self, Error> {
        let (resolved, robot) = (plant.resolved(), plant.robot());
        let scenario = resolved.scenario();
        let standing = &resolved.joint_targets().standing(robot);
        let kinematics = Kinematics::new(standing)?;
        let contact = ContactKinematics::new(standing)?;
        let pilot = Pilot::new(
            scenario,
            (resolved.reference().cloned(), None),
            (kinematics.clone(), contact.clone()),
            robot,
            Some(Box::new(Idle)),
        )?;
        let header = Header {
            // A row each control period, for as long as the loop goes on.
            record_every: 1,
            control_periods: 0,
            ..header(resolved, robot, Appearance::by(urdf), &pilot)?
        };
        let start = plant.truth().pose;
        Ok(Self::new(
            header, robot, kinematics, contact, start, 1, scenario,
        ))
    }

    /// Sums what happened during the last physics step.
    pub fn count(&mut self, world: &World, dt_s: f64) {
        let acted = world
            .robot()
            .contacts()
            .iter()
            .zip(world.robot().motor_torques_n_m());
        for (sums, (contact, torque_n_m)) in self.sums.iter_mut().zip(acted) {
            sums.slip_j += contact.slip_power_w * dt_s;
            sums.spin_up_j += contact.spin_up_power_w * dt_s;
            sums.angular_n_m_s += torque_n_m * dt_s;
            sums.time_s += dt_s;
        }
        self.residual_m_s = self.residual_m_s.max(world.contact_residual_m_s());
        if let Some(posed) = &mut self.posed {
            posed.see(world.robot().joint_positions().iter().copied());
        }
        if let Some((odometry, known)) = &mut self.measured {
            let joints = world.robot().joint_positions().iter().zip(known);
            odometry.see(joints.map(|(position, known)| if *known { *position } else { 0.0 }));
        }
        let support = world.robot().support();
        self.carried.wheels_n_s += support.wheels_n * dt_s;
        self.carried.chassis_n_s += support.chassis_n * dt_s;
        self.carried.obstacles_n_s += support.obstacles_n * dt_s;
        self.carried.time_s += dt_s;
    }

    /// Adds a row: the state now, what was decided on it, and the torques that follow.
    pub fn record(&mut self, t_s: f64, plant: &Plant, decided: &Decided<'_>) {
        let (world, seen, shares) = (plant.world(), plant.seen(), plant.torque_shares());
        let angles_rad = world.robot().wheel_angles_rad();
        let rates_rad_s = world.robot().wheel_rates_rad_s();
        let twist_contact = self.contact_kinematics.twist(angles_rad, rates_rad_s);

        let mut tasks = [TaskShare::default(); MAX_TASKS];
        for (share, task) in tasks.iter_mut().zip(decided.tasks) {
            *share = TaskShare {
                asked_rad_s: task.asked_rad_s,
                capacity_rad_s: task.capacity_rad_s,
                weight: task.weight,
                asked_twist_in_body: task.twist_in_body,
            };
        }
        let energy = world.energy();
        let record = Record {
            t_s,
            truth: plant.truth(),
            twist_ideal: self.kinematics.twist(rates_rad_s),
            twist_contact,
            seen_pose: seen.pose,
            odometry_ideal: self.odometry_ideal,
            odometry_contact: self.odometry_contact.pose(),
            odometry_posed: self.posed.as_ref().map(PosedOdometry::pose),
            desired: decided.desired.map(|desired| Desired {
                pose: desired.pose,
                velocity_in_world: desired.velocity_in_world,
            }),
            measured: decided.measured,
            command_twist_in_body: decided.command_twist_in_body,
            granted_twist_in_body: decided.granted_twist_in_body,
            twist_target_ideal: self.kinematics.twist(decided.wheel_rates_rad_s),
            tasks,
            joints: joints(world),
            bodies: bodies::samples(world),
            torque_weight_position: shares.map_or(1.0, |shares| shares.position),
            torque_weight_heading: shares.map_or(1.0, |shares| shares.heading),
            slip_energy_j: world.slip_energy_j(),
            spin_up_energy_j: world.spin_up_energy_j(),
            motor_energy_j: world.motor_energy_j(),
            motor_positive_energy_j: world.motor_positive_energy_j(),
            bearing_energy_j: world.bearing_energy_j(),
            impact_energy_j: world.impact_energy_j(),
            outside_energy_j: world.outside_energy_j(),
            kinetic_energy_j: energy.kinetic_j,
            potential_energy_j: energy.potential_j,
            contact_residual_m_s: self.residual_m_s,
            support: Some(self.carried.means(plant.truth().pose.heading_rad)),
            reckoned: self.reckoned(&seen.wheel_rates_rad_s),
            imu: seen.imu,
            storage: plant.storage(),
        };
        self.sample_wheels(world, decided.wheel_rates_rad_s);
        self.residual_m_s = 0.0;
        self.carried = Carried::default();
        self.trace.push(record, &self.samples);
        self.record_rollers(t_s, world);
    }

    /// What dead reckoning says of the twist where encoders say rates in rad/s, and how sure it is.
    fn reckoned(&self, seen_rad_s: &[f64]) -> Option<Reckoned> {
        let covariance = self.covariance.as_ref()?;
        let rolling_rad_s = match &self.measured {
            None => Cow::Borrowed(seen_rad_s),
            Some((measured, _)) => {
                let carried = measured.hubs().carried_rad();
                let rates = seen_rad_s.iter().zip(carried);
                rates
                    .map(|(seen, carried)| seen + carried / self.control_dt_s)
                    .collect()
            }
        };
        let pose = covariance.covariance(self.odometry_ideal.heading_rad);
        let twist = covariance.twist_covariance(&rolling_rad_s, self.row_period_s);
        Some(Reckoned {
            twist: self.kinematics.twist(&rolling_rad_s),
            pose_covariance: pose.into(),
            twist_covariance: twist.into(),
        })
    }

    /// Puts the rollers' angles into the last row where they are due: at most once a row, and on the mean as often as asked.
    fn record_rollers(&mut self, t_s: f64, world: &World) {
        let Some(every_s) = self.rollers_every_s else {
            return;
        };
        let due = ((t_s + TIME_SLACK_S) / every_s).floor() as u64 + 1;
        if due > self.rollers_taken {
            self.rollers_taken = due;
            let wheels = 0..self.samples.len();
            let angles = wheels.flat_map(|wheel| world.robot().roller_angles_rad(wheel));
            self.trace.push_roller_angles(angles);
        }
    }

    /// What was recorded so far.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Where dead reckoning by Indiveri 2009, eq. (7), puts the robot, from the true pose at the start.
    pub fn odometry(&self) -> Pose {
        self.odometry_ideal
    }

    /// What was recorded so far, to be taken out.
    pub fn trace_mut(&mut self) -> &mut Trace {
        &mut self.trace
    }

    /// What was recorded; no row is left.
    pub(super) fn take_trace(&mut self) -> Trace {
        let none = Trace::with_capacity(self.trace.header.clone(), 0);
        std::mem::replace(&mut self.trace, none)
    }

    /// Dead reckoning from the wheel angles turned since the last control period, by both kinematics: what a robot with
    /// encoders would do once a control period.
    pub fn reckon(&mut self, angles_rad: &[f64]) {
        let increments = self.turned_rad.iter_mut().zip(&mut self.last_angles_rad);
        for ((turned, last), now) in increments.zip(angles_rad) {
            *turned = now - *last;
            *last = *now;
        }
        if let Some(posed) = &mut self.posed {
            posed.reckon(&self.turned_rad);
        }
        let before = self.odometry_ideal;
        let Some((measured, _)) = &mut self.measured else {
            if let Some(covariance) = &mut self.covariance {
                covariance.count(&before, &self.turned_rad);
            }
            self.odometry_contact.update(angles_rad);
            // The kinematics is linear in the rates: angles turned give the displacement.
            let displacement = self.kinematics.twist(&self.turned_rad);
            self.odometry_ideal = self.odometry_ideal.moved(displacement);
            return;
        };
        let moved = measured.reckon(&self.turned_rad);
        self.odometry_ideal = measured.pose();
        let hubs = measured.hubs();
        if let Some(covariance) = &mut self.covariance {
            if let Some(kinematics) = hubs.kinematics().filter(|_| moved) {
                covariance.stand(kinematics);
            }
            covariance.count(&before, measured.rolled_rad());
        }
        if moved
            && let (Some(kinematics), Ok(contact)) =
                (hubs.kinematics(), ContactKinematics::new(&hubs.posed()))
        {
            self.kinematics = kinematics.clone();
            self.contact_kinematics = contact.clone();
            self.odometry_contact.stand(contact);
        }
        self.odometry_contact
            .update_carried(angles_rad, hubs.carried_rad());
    }

    fn sample_wheels(&mut self, world: &World, targets_rad_s: &[f64]) {
        for (index, (sample, contact)) in self
            .samples
            .iter_mut()
            .zip(world.robot().contacts())
            .enumerate()
        {
            let sums = &mut self.sums[index];
            let (angular_n_m_s, time_s) = (sums.angular_n_m_s, sums.time_s);
            (sums.angular_n_m_s, sums.time_s) = (0.0, 0.0);
            let place = contact.place_in_body_m;
            *sample = WheelSample {
                target_rad_s: targets_rad_s[index],
                rate_rad_s: world.robot().wheel_rates_rad_s()[index],
                angle_rad: world.robot().wheel_angles_rad()[index],
                torque_n_m: if time_s > 0.0 {
                    angular_n_m_s / time_s
                } else {
                    0.0
                },
                hub_height_m: world.robot().hub_height_m(index),
                roller: contact.roller as u32,
                touching: contact.touching,
                load_share: 0.0,
                slip_energy_j: sums.slip_j,
                spin_up_energy_j: sums.spin_up_j,
                ..WheelSample::default()
            };
            if contact.touching {
                *sample = WheelSample {
                    load_share: contact.load_share,
                    contact_x_m: place.x,
                    contact_y_m: place.y,
                    normal_force_n: contact.normal_force_n,
                    force_x_n: contact.force_in_body_n.x,
                    force_y_n: contact.force_in_body_n.y,
                    friction: contact.friction,
                    slip_x_m_s: contact.sliding_in_body_m_s.x,
                    slip_y_m_s: contact.sliding_in_body_m_s.y,
                    roller_spin_rad_s: contact.roller_spin_rad_s,
                    roller_spin_ideal_rad_s: contact.roller_spin_ideal_rad_s,
                    ..*sample
                };
            }
        }
    }
}

/// The joints between the robot's bodies, as they are recorded.
fn joints(world: &World) -> [JointSample; MAX_JOINTS] {
    let robot = world.robot();
    let mut samples = [JointSample::default(); MAX_JOINTS];
    let places = robot.joint_positions().iter().zip(robot.joint_rates());
    let found = places.zip(robot.joint_forces());
    for (sample, ((position, rate), force)) in samples.iter_mut().zip(found) {
        *sample = JointSample {
            position: *position,
            rate: *rate,
            force: *force,
        };
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot that looks along the world's y axis has the world's x axis to its right.
    #[test]
    fn what_obstacles_push_is_told_along_the_robots_own_axes() {
        let carried = Carried {
            obstacles_n_s: Vector2::new(3.0, 4.0),
            time_s: 0.5,
            ..Carried::default()
        };
        let means = carried.means(std::f64::consts::FRAC_PI_2);
        // The cosine of a rounded right angle is 6e-17.
        assert!((means.obstacles_x_n - 8.0).abs() < 1e-14);
        assert!((means.obstacles_y_n + 6.0).abs() < 1e-14);
    }
}
