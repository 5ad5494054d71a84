//! The passive law on a robot: what its control loop has to call, once a millisecond. Here a model
//! on a slope that the robot does not know stands in for encoders, IMU and motors; a motion-capture
//! pose comes every ten milliseconds.

use ilon_control::*;
use ilon_formats::LoadRobot;
use ilon_robot::{Pose, Robot};
use nalgebra::Vector3;

const DT_S: f64 = 1e-3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");
    let robot = Robot::load(format!("{root}/assets/robots/mecanum4.urdf"))?;

    // Once: springs and dampers from the robot's mass, guidance with the gains that make the
    // spring, and the IMU's filter.
    let tilt_loop = TiltLoop {
        time_constant_s: 1.0,
        delay_s: DT_S,
    };
    let settings = PassiveTorqueSettings {
        tilt: Some(tilt_loop),
        ..PassiveTorqueSettings::for_robot(&robot, 9.81, DT_S, 0.01, 0.0)?
    };
    let mut law = PassiveTorque::new(&robot, &settings)?;
    let mut guidance = Guidance::new(
        Kinematics::new(&robot)?,
        &GuidanceSettings {
            position_gain: Gain::Scalar(settings.position_gain_per_s()),
            heading_gain: settings.heading_gain_per_s(),
            wheel_rate_limit_rad_s: robot.wheel_rate_limit_rad_s(),
            saturation: Saturation::Prioritised(Priority::Position),
        },
    )?;
    let reference = Reference::hold(Pose {
        x_m: 0.2,
        ..Pose::default()
    })?;
    let mut tilt = TiltFilter::new(1.0)?;
    let symmetric = |most_n_m: f64| TorqueRange {
        min_n_m: -most_n_m,
        max_n_m: most_n_m,
    };
    let wheels = robot.wheels.iter();
    let limits: Vec<_> = wheels.map(|w| symmetric(w.motor.effort_n_m)).collect();

    let mut hardware = StandIn::new(&robot)?;
    let mut targets = vec![0.0; robot.wheels.len()];
    for tick in 0..5000 {
        let t_s = DT_S * f64::from(tick);
        if tick % 10 == 0 {
            let desired = reference.at(t_s);
            targets.copy_from_slice(&guidance.update(&hardware.pose, &desired).wheel_rates_rad_s);
        }
        tilt.update(&hardware.turn_rad_s, &hardware.force_m_s2, DT_S);
        law.sense(&BodySense {
            angles_rad: &hardware.angles_rad,
            gravity_in_body_m_s2: Some(9.81 * tilt.down_in_body()),
        });
        let torques = law.update(&Demand::new(&targets, &hardware.rates_rad_s, &limits, DT_S));
        hardware.act(torques, DT_S);
    }
    let off_m = (hardware.pose.x_m - 0.2).abs();
    println!(
        "0.2 m down a slope of 5 deg it stands {:.3} mm off",
        1e3 * off_m
    );
    assert!(off_m < 1e-4);
    Ok(())
}

/// A rolling robot on a slope of 5 deg that falls ahead.
struct StandIn {
    model: DynamicModel,
    mass_kg: f64,
    pose: Pose,
    angles_rad: Vec<f64>,
    rates_rad_s: Vec<f64>,
    turn_rad_s: Vector3<f64>,
    force_m_s2: Vector3<f64>,
}

impl StandIn {
    fn new(robot: &Robot) -> Result<Self, ControlError> {
        let (sin, cos) = 5_f64.to_radians().sin_cos();
        let n = robot.wheels.len();
        Ok(Self {
            model: DynamicModel::new(robot)?,
            mass_kg: robot.mass_kg(),
            pose: Pose::default(),
            angles_rad: vec![0.0; n],
            rates_rad_s: vec![0.0; n],
            turn_rad_s: Vector3::zeros(),
            force_m_s2: 9.81 * Vector3::new(-sin, 0.0, cos),
        })
    }

    fn act(&mut self, torques_n_m: &[f64], dt_s: f64) {
        let downhill_n = -self.mass_kg * self.force_m_s2.x;
        let kinematics = self.model.kinematics().clone();
        // Gravity as the torques that would pull as much.
        let pull = kinematics.twist_matrix().transpose() * Vector3::new(downhill_n, 0.0, 0.0);
        let all: Vec<f64> = torques_n_m
            .iter()
            .zip(pull.iter())
            .map(|(a, b)| a + b)
            .collect();
        let (mut scratch, mut gained) = (all.clone(), all.clone());
        self.model
            .accelerations(&self.rates_rad_s, &all, &mut scratch, &mut gained);
        let wheels = self.rates_rad_s.iter_mut().zip(&mut self.angles_rad);
        for ((rate_rad_s, angle_rad), gained_rad_s2) in wheels.zip(&gained) {
            *rate_rad_s += gained_rad_s2 * dt_s;
            *angle_rad += *rate_rad_s * dt_s;
        }
        self.pose = self
            .pose
            .moved(kinematics.twist(&self.rates_rad_s).scaled(dt_s));
    }
}
