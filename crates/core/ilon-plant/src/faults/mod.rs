//! Injected faults of the robot's own sensors and motors over time.

pub mod disturbances;
pub mod tilt;

use ilon_robot::{Pose, Robot, wrap_angle};
use ilon_trace::FaultKind;
use nalgebra::Vector3;

use crate::faults::tilt::Tilts;
use ilon_scenario::Error;
use ilon_scenario::robot::wheel_index;
use ilon_scenario::scenario::{Fault, Frame, within};

/// A point of the chassis in the body frame, in metres; coordinates that are not given are those
/// of its centre of mass.
pub(crate) fn place_m(robot: &Robot, [x_m, y_m, z_m]: [Option<f64>; 3]) -> Vector3<f64> {
    let center_m = robot.chassis.mass.center_of_mass_m;
    Vector3::new(
        x_m.unwrap_or(center_m.x),
        y_m.unwrap_or(center_m.y),
        z_m.unwrap_or(center_m.z),
    )
}

/// The faults of a scenario as stored in a trace.
///
/// # Errors
/// [`Error::Invalid`] for a wheel that the robot does not have.
pub(crate) fn recorded(faults: &[Fault], robot: &Robot) -> Result<Vec<ilon_trace::Fault>, Error> {
    let index_of = |wheel: &str| wheel_index(wheel, robot, "a fault is");
    let kind_of = |fault: &Fault| -> Result<FaultKind, Error> {
        Ok(match fault {
            Fault::MotorLost { wheel, shorted, .. } => FaultKind::MotorLost {
                wheel: index_of(wheel)?,
                shorted: *shorted,
            },
            Fault::EncoderLost { wheel, .. } => FaultKind::EncoderLost {
                wheel: index_of(wheel)?,
            },
            Fault::EncoderScaled { wheel, factor, .. } => FaultKind::EncoderScaled {
                wheel: index_of(wheel)?,
                factor: *factor,
            },
            Fault::PoseLost { .. } => FaultKind::PoseLost,
            Fault::PoseShifted {
                x_m,
                y_m,
                heading_deg,
                ..
            } => FaultKind::PoseShifted {
                by_m: [*x_m, *y_m],
                by_rad: heading_deg.to_radians(),
            },
            Fault::BatterySag { share, .. } => FaultKind::BatterySag { share: *share },
            Fault::Push {
                impulse_x_n_s,
                impulse_y_n_s,
                impulse_z_n_s,
                frame,
                x_m,
                y_m,
                z_m,
                ..
            } => FaultKind::Push {
                impulse_n_s: [*impulse_x_n_s, *impulse_y_n_s, *impulse_z_n_s],
                in_body: *frame == Frame::Body,
                place_m: place_m(robot, [*x_m, *y_m, *z_m]).into(),
            },
            Fault::Payload {
                mass_kg,
                x_m,
                y_m,
                z_m,
                ..
            } => FaultKind::Payload {
                mass_kg: *mass_kg,
                place_m: place_m(robot, [*x_m, *y_m, *z_m]).into(),
            },
            Fault::RollerStuck { wheel, roller, .. } => FaultKind::RollerStuck {
                wheel: index_of(wheel)?,
                roller: *roller,
            },
            Fault::FrictionChanged { friction, .. } => FaultKind::FrictionChanged {
                friction: *friction,
            },
            Fault::Tilt {
                amplitude_deg,
                frequency_hz,
                direction_deg,
                ..
            } => FaultKind::Tilt {
                amplitude_rad: amplitude_deg.to_radians(),
                frequency_hz: *frequency_hz,
                direction_rad: direction_deg.to_radians(),
            },
        })
    };
    faults
        .iter()
        .map(|fault| {
            let (from_s, until_s) = fault.window_s();
            Ok(ilon_trace::Fault {
                from_s,
                until_s,
                kind: kind_of(fault)?,
            })
        })
        .collect()
}

/// The state of a lost motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum LostMotor {
    /// No current: the wheel turns freely.
    Free,
    /// Shorted winding: the back-EMF brakes the wheel.
    Shorted,
}

/// The injected faults within the robot; those from outside are in [`disturbances`].
#[derive(Clone)]
pub(crate) struct Faults {
    faults: Vec<ilon_trace::Fault>,
    tilts: Tilts,
}

impl Faults {
    /// # Errors
    /// [`Error::Invalid`] for a wheel that the robot does not have.
    pub fn new(faults: &[Fault], robot: &Robot) -> Result<Self, Error> {
        Ok(Self {
            faults: recorded(faults, robot)?,
            tilts: Tilts::new(faults),
        })
    }

    /// The tilts of the ground.
    pub fn tilts(&self) -> &Tilts {
        &self.tilts
    }

    /// Whether the pose sensor is blind.
    pub fn pose_is_lost(&self, t_s: f64) -> bool {
        self.on(t_s).any(|fault| *fault == FaultKind::PoseLost)
    }

    /// The pose that the sensor measures for a real pose.
    pub fn pose(&self, t_s: f64, mut pose: Pose) -> Pose {
        for fault in self.on(t_s) {
            if let FaultKind::PoseShifted { by_m, by_rad } = fault {
                pose.x_m += by_m[0];
                pose.y_m += by_m[1];
                pose.heading_rad = wrap_angle(pose.heading_rad + by_rad);
            }
        }
        pose
    }

    /// By how much a wheel's encoder counts wrong: what it counts over what it should; 0 of one
    /// that is lost.
    pub fn encoder_factor(&self, t_s: f64, wheel: usize) -> f64 {
        let lost = FaultKind::EncoderLost { wheel };
        match self.on(t_s).any(|fault| *fault == lost) {
            true => 0.0,
            false => self.encoder_scale(t_s, wheel),
        }
    }

    /// The same of an encoder that is not lost.
    pub fn encoder_scale(&self, t_s: f64, wheel: usize) -> f64 {
        self.on(t_s)
            .map(|fault| match fault {
                FaultKind::EncoderScaled { wheel: of, factor } if *of == wheel => *factor,
                _ => 1.0,
            })
            .product()
    }

    /// Remaining share of the supply voltage, from 0 to 1.
    pub fn supply_share(&self, t_s: f64) -> f64 {
        self.on(t_s)
            .map(|fault| match fault {
                FaultKind::BatterySag { share } => *share,
                _ => 1.0,
            })
            .product()
    }

    /// The state of a wheel's motor if it is lost; a short takes precedence.
    pub fn lost_motor(&self, t_s: f64, wheel: usize) -> Option<LostMotor> {
        let lost = self.on(t_s).filter_map(|fault| match fault {
            FaultKind::MotorLost { wheel: of, shorted } if *of == wheel => Some(if *shorted {
                LostMotor::Shorted
            } else {
                LostMotor::Free
            }),
            _ => None,
        });
        lost.max()
    }

    fn on(&self, t_s: f64) -> impl Iterator<Item = &FaultKind> {
        let is_on = move |of: &&ilon_trace::Fault| within(t_s, of.from_s, of.until_s);
        self.faults.iter().filter(is_on).map(|fault| &fault.kind)
    }
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;

    use super::*;

    /// Of a robot whose second wheel is `b`.
    fn faults(toml: &str) -> Faults {
        #[derive(serde::Deserialize)]
        struct Section {
            faults: Vec<Fault>,
        }
        let section: Section = toml::from_str(toml).expect("faults");
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let mut robot = Robot::from_urdf_str(urdf, "mecanum4").expect("a robot");
        robot.wheels[1].name = "b".to_owned();
        Faults::new(&section.faults, &robot).expect("it has this wheel")
    }

    #[test]
    fn a_fault_is_there_from_its_beginning_to_its_end_and_on_its_wheel_only() {
        let faults = faults("[[faults]]\nmotor_lost = { wheel = 'b', from_s = 1, until_s = 2 }");
        let lost = |t_s| [0, 1].map(|wheel| faults.lost_motor(t_s, wheel));
        assert_eq!(lost(0.99), [None, None]);
        assert_eq!(lost(1.0), [None, Some(LostMotor::Free)]);
        assert_eq!(lost(2.0), [None, None]);
    }

    #[test]
    fn faults_add_up() {
        let faults = faults(
            "[[faults]]\nencoder_scaled = { wheel = 'b', factor = 2 }\n\
             [[faults]]\nencoder_scaled = { wheel = 'b', factor = 3, until_s = 5 }\n\
             [[faults]]\nbattery_sag = { share = 0.5 }\n\
             [[faults]]\nbattery_sag = { share = 0.8, from_s = 2 }\n\
             [[faults]]\npose_shifted = { x_m = 0.5, heading_deg = 270 }\n\
             [[faults]]\npose_lost = { from_s = 9 }",
        );
        assert_eq!(
            [0, 1].map(|wheel| faults.encoder_factor(0.0, wheel)),
            [1.0, 6.0]
        );
        assert_eq!([0.0, 2.0].map(|t_s| faults.supply_share(t_s)), [0.5, 0.4]);
        let pose = faults.pose(0.0, Pose::default());
        assert_eq!(pose.x_m, 0.5);
        // 270 deg wrapped is a quarter turn clockwise; rounding of one sum of numbers below 8.
        assert!((pose.heading_rad + std::f64::consts::FRAC_PI_2).abs() < 1e-14);
        assert!(!faults.pose_is_lost(8.9) && faults.pose_is_lost(9.0));
    }
}
