//! Fusion of poses and wheel odometry: the robot's estimate of its pose.

use ilon_control::{Kinematics, PoseFilter, PoseFilterSettings};
use ilon_robot::{Pose, Robot, Wheel};

use crate::sensing::hubs::Hubs;
use ilon_scenario::{Error, scenario};

/// Odometry and poses joined by a filter.
#[derive(Clone)]
pub(crate) struct Fusion {
    filter: PoseFilter,
    kinematics: Kinematics,
    /// For a robot whose joints move its wheels.
    hubs: Option<Hubs>,
    /// The wheel angles at the last odometry update, in rad.
    counted_rad: Vec<f64>,
    turned_rad: Vec<f64>,
}

impl Fusion {
    /// A filter that knows the start, for poses of `sensor` and odometry once a control period, in
    /// a run of `duration_s`.
    ///
    /// # Errors
    /// [`Error::Control`] for invalid filter settings.
    pub fn new(
        section: &scenario::Fusion,
        sensor: &scenario::PoseSensor,
        start: Pose,
        (robot, kinematics): (&Robot, &Kinematics),
        control_dt_s: f64,
        duration_s: f64,
    ) -> Result<Self, Error> {
        // A sensor without noise gets a deviation of a tenth of a millimetre and a hundredth of a
        // degree, because the filter cannot weigh exact values.
        let (least_m, least_deg) = (1e-4, 0.01);
        // Odometry as far back as the oldest pose, with as many steps again for the poses that
        // split them. Nothing older than the run is needed.
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

    /// Counts the rotation of the wheels since the last call, by their angles and the joints'
    /// positions; the robot's rotation is the gyroscope's, if given.
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
        let mut displacement = None;
        if let Some(hubs) = &mut self.hubs {
            if hubs.see(joint_positions) {
                let kinematics = hubs.kinematics().unwrap_or(&self.kinematics);
                self.filter.resize(size_m(kinematics));
            }
            displacement = hubs.displacement(&mut self.turned_rad);
        }
        // Eq. (7) is linear: wheel angles give the displacement.
        let mut displacement =
            displacement.unwrap_or_else(|| self.kinematics.twist(&self.turned_rad));
        displacement.omega_rad_s = turned_rad.unwrap_or(displacement.omega_rad_s);
        self.filter.predict(t_s, displacement);
    }

    /// Adds a pose that was taken now or earlier.
    pub fn correct(&mut self, taken_s: f64, pose: &Pose) {
        self.filter.correct(taken_s, pose);
    }

    /// The estimated pose of the robot.
    pub fn pose(&self) -> Pose {
        self.filter.estimate().pose
    }
}

/// The largest distance of a wheel from the body's origin, in metres.
fn size_m(kinematics: &Kinematics) -> f64 {
    let far = |wheel: &Wheel| wheel.position_m().xy().norm();
    kinematics.wheels().iter().map(far).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use ilon_robot::Twist;

    use super::*;

    /// A pose with the sensor's full latency is not too old for the filter. A robot has gone ahead
    /// and back again, and a pose of 0.4 s ago is 1 m further than the odometry was then; with an
    /// odometry deviation of ten metres after each metre, the pose is believed.
    #[test]
    fn a_pose_as_old_as_the_sensors_latency_still_counts() {
        const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
        const DT_S: f64 = 2e-3;
        let text = "robot.file = \"mecanum4.urdf\"\n[reference.hold_pose]\nx_m = 0\ny_m = 0\nheading_deg = 0\n\
                    [run]\nduration_s = 4\n";
        let scenario = scenario::Scenario::from_toml(text, "fusion", ROBOTS).expect("a scenario");
        let robot = ilon_scenario::robot::load_robot(&scenario).expect("a shipped robot");
        let kinematics = Kinematics::new(&robot).expect("it drives");
        for rate_hz in [None, Some(50.0), Some(2000.0)] {
            let sensor = scenario::PoseSensor {
                rate_hz,
                latency_s: 0.4,
                ..scenario::PoseSensor::default()
            };
            let drifts = scenario::Fusion {
                position_drift_m: 10.0,
                ..scenario::Fusion::default()
            };
            let known = (&robot, &kinematics);
            let start = Pose::default();
            let mut fusion = Fusion::new(&drifts, &sensor, start, known, DT_S, 4.0).expect("valid");
            // Ahead and back again, so that the estimate is very uncertain.
            let ahead = Twist::new(0.5, 0.0, 0.0);
            let mut rates = vec![0.0; 4];
            kinematics.wheel_rates(ahead, &mut rates);
            let mut angles = vec![0.0; 4];
            let mut steps = 0;
            let mut drive = |fusion: &mut Fusion, sense: f64, count: usize| {
                for _ in 0..count {
                    steps += 1;
                    for (angle, rate) in angles.iter_mut().zip(&rates) {
                        *angle += sense * rate * DT_S;
                    }
                    fusion.reckon(f64::from(steps) * DT_S, (&angles, &[]), None);
                }
                f64::from(steps) * DT_S
            };
            drive(&mut fusion, 1.0, 250);
            let now_s = drive(&mut fusion, -1.0, 250);
            let seen = Pose {
                x_m: 1.0 + 0.5 * 0.4,
                ..Pose::default()
            };
            fusion.correct(now_s - sensor.latency_s, &seen);
            // With a drift of 10 m and a sensor deviation of a tenth of a millimetre the sensor's
            // weight is 1 - 1e-10.
            let x_m = fusion.pose().x_m;
            assert!((x_m - 1.0).abs() < 1e-3, "{x_m} m at {rate_hz:?} Hz");
        }
    }
}
