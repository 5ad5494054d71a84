//! What goes wrong on purpose, while it does.

use ilon_robot::{Pose, Robot, wrap_angle};

use crate::Error;
use crate::scenario::{Fault, nearest};

/// The faults of a run.
pub(super) struct Faults {
    faults: Vec<Fault>,
    /// For each fault the index of its wheel; 0 where it is about none.
    wheels: Vec<usize>,
}

impl Faults {
    /// # Errors
    /// [`Error::Invalid`] for a wheel that the robot does not have.
    pub fn new(faults: &[Fault], robot: &Robot) -> Result<Self, Error> {
        let names = || robot.wheels.iter().map(|wheel| wheel.name.as_str());
        let index_of = |fault: &Fault| match fault.wheel() {
            None => Ok(0),
            Some(name) => names().position(|known| known == name).ok_or_else(|| {
                Error::invalid(
                    format!("a fault is about the wheel `{name}`, which the robot does not have"),
                    match nearest(name, names()) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => {
                            format!("its wheels are {}", names().collect::<Vec<_>>().join(", "))
                        }
                    },
                )
            }),
        };
        Ok(Self {
            wheels: faults.iter().map(index_of).collect::<Result<_, _>>()?,
            faults: faults.to_vec(),
        })
    }

    /// Whether the pose sensor sees nothing.
    pub fn pose_is_lost(&self, t_s: f64) -> bool {
        self.on(t_s)
            .any(|(fault, _)| matches!(fault, Fault::PoseLost { .. }))
    }

    /// The pose that the sensor takes for the real one.
    pub fn pose(&self, t_s: f64, mut pose: Pose) -> Pose {
        for (fault, _) in self.on(t_s) {
            if let Fault::PoseShifted {
                x_m,
                y_m,
                heading_deg,
                ..
            } = fault
            {
                pose.x_m += x_m;
                pose.y_m += y_m;
                pose.heading_rad = wrap_angle(pose.heading_rad + heading_deg.to_radians());
            }
        }
        pose
    }

    /// Spoils the wheel rates that the encoders tell, in rad/s.
    pub fn spoil_rates(&self, t_s: f64, rates_rad_s: &mut [f64]) {
        for (fault, wheel) in self.on(t_s) {
            let factor = match fault {
                Fault::EncoderLost { .. } => 0.0,
                Fault::EncoderScaled { factor, .. } => *factor,
                _ => continue,
            };
            if let Some(rate_rad_s) = rates_rad_s.get_mut(wheel) {
                *rate_rad_s *= factor;
            }
        }
    }

    /// Spoils the torques that the motors give, in N m.
    pub fn spoil_torques(&self, t_s: f64, torques_n_m: &mut [f64]) {
        for (fault, wheel) in self.on(t_s) {
            match fault {
                Fault::MotorLost { .. } => {
                    if let Some(torque_n_m) = torques_n_m.get_mut(wheel) {
                        *torque_n_m = 0.0;
                    }
                }
                Fault::BatterySag { share, .. } => {
                    torques_n_m.iter_mut().for_each(|torque| *torque *= share);
                }
                _ => {}
            }
        }
    }

    fn on(&self, t_s: f64) -> impl Iterator<Item = (&Fault, usize)> {
        self.faults
            .iter()
            .zip(self.wheels.iter().copied())
            .filter(move |(fault, _)| fault.is_on(t_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(toml: &str) -> Faults {
        #[derive(serde::Deserialize)]
        struct Section {
            faults: Vec<Fault>,
        }
        let section: Section = toml::from_str(toml).expect("faults");
        Faults {
            wheels: vec![1; section.faults.len()],
            faults: section.faults,
        }
    }

    #[test]
    fn a_fault_is_there_from_its_beginning_to_its_end_and_on_its_wheel_only() {
        let faults = faults("[[faults]]\nmotor_lost = { wheel = 'b', from_s = 1, until_s = 2 }");
        let given = |t_s| {
            let mut torques_n_m = [1.0, 1.0];
            faults.spoil_torques(t_s, &mut torques_n_m);
            torques_n_m
        };
        assert_eq!(given(0.99), [1.0, 1.0]);
        assert_eq!(given(1.0), [1.0, 0.0]);
        assert_eq!(given(2.0), [1.0, 1.0]);
    }

    #[test]
    fn faults_add_up() {
        let faults = faults(
            "[[faults]]\nencoder_scaled = { wheel = 'b', factor = 2 }\n\
             [[faults]]\nbattery_sag = { share = 0.5 }\n\
             [[faults]]\npose_shifted = { x_m = 0.5, heading_deg = 270 }\n\
             [[faults]]\npose_lost = { from_s = 9 }",
        );
        let mut rates_rad_s = [3.0, 3.0];
        faults.spoil_rates(0.0, &mut rates_rad_s);
        assert_eq!(rates_rad_s, [3.0, 6.0]);
        let mut torques_n_m = [1.0, -2.0];
        faults.spoil_torques(0.0, &mut torques_n_m);
        assert_eq!(torques_n_m, [0.5, -1.0]);
        let pose = faults.pose(0.0, Pose::default());
        assert_eq!(pose.x_m, 0.5);
        // 270 deg wrapped is a quarter turn clockwise; rounding of one sum of numbers below 8.
        assert!((pose.heading_rad + std::f64::consts::FRAC_PI_2).abs() < 1e-14);
        assert!(!faults.pose_is_lost(8.9) && faults.pose_is_lost(9.0));
    }
}
