//! Poses and wheel odometry joined: the robot's own idea of where it is.

use ilon_control::{Kinematics, PoseFilter, PoseFilterSettings};
use ilon_robot::{Pose, Robot, Wheel};

use super::hubs::Hubs;
use crate::{Error, scenario};

/// Odometry and poses joined by a filter.
#[derive(Clone)]
pub(super) struct Fusion {
    filter: PoseFilter,
    kinematics: Kinematics,
    /// Of a robot whose joints move its wheels.
    hubs: Option<Hubs>,
    /// The wheel angles up to which odometry has been counted, in rad.
    counted_rad: Vec<f64>,
    turned_rad: Vec<f64>,
}

impl Fusion {
    /// A filter that knows the start, for poses of `sensor` and odometry once in a control period, in a run of `duration_s`.
    ///
    /// # Errors
    /// [`Error::Control`] for settings that no filter can have.
    pub fn new(
        section: &scenario::Fusion,
        sensor: &scenario::PoseSensor,
        start: Pose,
        (robot, kinematics): (&Robot, &Kinematics),
        control_dt_s: f64,
        duration_s: f64,
    ) -> Result<Self, Error> {
        // A sensor without noise is believed to a tenth of a millimetre and a hundredth of a degree: a filter cannot
        // weigh what it takes for certain.
        let (least_m, least_deg) = (1e-4, 0.01);
        // Odometry as far back as the oldest pose, with as many steps again for the poses that split them.
        // What is older than the run is never asked for.
        let back_s = sensor.latency_s.min(duration_s);
        let periods = (back_s / control_dt_s).ceil();
        let poses = sensor.rate_hz.map_or(periods, |rate_hz| rate_hz * back_s);
        let settings = PoseFilterSettings {
            measured_position_m: sensor.position_noise_m.max(least_m),
            measured_heading_rad: sensor.heading_noise_deg.max(least_deg).to_radians(),
            drift_position_m: section.position_drift_m,
            drift_heading_rad: section.heading_drift_deg.to_radians(),
            size_m: size_m(kinematics),
            memory: (2.0 * (periods + poses)) as usize + 10,
        };
        Ok(Self {
            filter: PoseFilter::new(0.0, start, &settings)?,
            kinematics: kinematics.clone(),
            hubs: Hubs::that_move(robot),
            counted_rad: vec![0.0; kinematics.wheel_count()],
            turned_rad: vec![0.0; kinematics.wheel_count()],
        })
    }

    /// Counts what the wheels have turned since the last time, by their angles and the joints' positions; where a gyroscope says by how much the
    /// robot has turned, by that.
    pub fn reckon(
        &mut self,
        t_s: f64,
        (wheel_angles_rad, joint_positions): (&[f64], &[f64]),
        turned_rad: Option<f64>,
    ) {
        let turned = self.turned_rad.iter_mut().zip(&mut self.counted_rad);
        for ((turned, counted), angle) in turned.zip(wheel_angles_rad) {
            *turned = angle - *counted;
            *counted = *angle;
        }
        let mut kinematics = &self.kinematics;
        if let Some(hubs) = &mut self.hubs {
            let moved = hubs.see(joint_positions);
            let turned = self.turned_rad.iter_mut().zip(hubs.carried_rad());
            turned.for_each(|(turned, carried)| *turned += carried);
            kinematics = hubs.kinematics().unwrap_or(kinematics);
            if moved {
                self.filter.resize(size_m(kinematics));
            }
        }
        // Eq. (7) is linear: angles turned give the displacement.
        let mut displacement = kinematics.twist(&self.turned_rad);
        displacement.omega_rad_s = turned_rad.unwrap_or(displacement.omega_rad_s);
        self.filter.predict(t_s, displacement);
    }

    /// Puts in a pose that was taken now or earlier.
    pub fn correct(&mut self, taken_s: f64, pose: &Pose) {
        self.filter.correct(taken_s, pose);
    }

    /// Where the robot takes itself to be.
    pub fn pose(&self) -> Pose {
        self.filter.estimate().pose
    }
}

/// How far the wheels are from the body's origin at most, in metres.
fn size_m(kinematics: &Kinematics) -> f64 {
    let far = |wheel: &Wheel| wheel.position_m().xy().norm();
    kinematics.wheels().iter().map(far).fold(0.0, f64::max)
}
