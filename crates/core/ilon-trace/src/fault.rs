//! The injected faults of a run as data, so that they can be reported without the scenario.

use serde::{Deserialize, Serialize};

use crate::significant;

/// An injected fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// Start, in seconds.
    pub from_s: f64,
    /// End, in seconds; `None` if it lasts to the end of the run.
    pub until_s: Option<f64>,
    /// Its kind.
    pub kind: FaultKind,
}

/// The kinds of faults. Wheels are numbered as in [`crate::Header::wheels`].
///
/// The enum is exhaustive, so that no writer or report can forget a new kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// A motor is not driven.
    MotorLost {
        /// Its wheel.
        wheel: usize,
        /// Whether its winding is shorted, so that the back-EMF brakes the wheel.
        #[serde(default)]
        shorted: bool,
    },
    /// An encoder reads zero.
    EncoderLost {
        /// Its wheel.
        wheel: usize,
    },
    /// An encoder reads a wrong rate.
    EncoderScaled {
        /// Its wheel.
        wheel: usize,
        /// Measured over real rate.
        factor: f64,
    },
    /// The pose sensor is blind.
    PoseLost,
    /// The pose sensor has an offset.
    PoseShifted {
        /// Offset along the world's x and y, in metres.
        by_m: [f64; 2],
        /// Offset in heading, in radians.
        by_rad: f64,
    },
    /// The battery voltage drops.
    BatterySag {
        /// Remaining share of the voltage, in [0, 1].
        share: f64,
    },
    /// A push on the chassis.
    Push {
        /// The impulse, spread evenly over the time, in N s.
        impulse_n_s: [f64; 3],
        /// Whether its axes are those of the body frame, turned level, instead of the world's.
        in_body: bool,
        /// Point of application on the chassis, in the body frame, in metres.
        place_m: [f64; 3],
    },
    /// A mass on the chassis.
    Payload {
        /// Its mass, in kg.
        mass_kg: f64,
        /// Its place on the chassis, in the body frame, in metres.
        place_m: [f64; 3],
    },
    /// A roller is stuck on its axle.
    RollerStuck {
        /// Its wheel.
        wheel: usize,
        /// Its number on the wheel, from 0.
        roller: u32,
    },
    /// The floor has another friction, except on its patches.
    FrictionChanged {
        /// Coulomb's coefficient.
        friction: f64,
    },
    /// The ground tilts or rocks.
    Tilt {
        /// The largest angle, in radians.
        amplitude_rad: f64,
        /// Rocking frequency, in Hz; 0 for a constant tilt.
        frequency_hz: f64,
        /// The direction that goes down first, in radians from the world's x axis.
        direction_rad: f64,
    },
}

impl Fault {
    /// A description to follow "without", with its times: `the payload of 2 kg from 3.00 s on`.
    /// `name_of` names the wheels.
    pub fn words<'a>(&self, name_of: impl Fn(usize) -> Option<&'a str>) -> String {
        let what = self.kind.words(name_of);
        let (from_s, until_s) = (self.from_s, self.until_s);
        match (&self.kind, until_s) {
            (FaultKind::Push { .. }, _) => format!("{what} at {from_s:.2} s"),
            (_, Some(until_s)) => format!("{what} from {from_s:.2} to {until_s:.2} s"),
            (_, None) if from_s > 0.0 => format!("{what} from {from_s:.2} s on"),
            (_, None) => what,
        }
    }
}

impl FaultKind {
    /// A description to follow "without". `name_of` names the wheels.
    pub fn words<'a>(&self, name_of: impl Fn(usize) -> Option<&'a str>) -> String {
        let name_of = |wheel: usize| name_of(wheel).unwrap_or("a wheel");
        match self {
            Self::MotorLost { wheel, shorted } => format!(
                "the {} motor of {}",
                if *shorted { "shorted" } else { "lost" },
                name_of(*wheel)
            ),
            Self::EncoderLost { wheel } => format!("the lost encoder of {}", name_of(*wheel)),
            Self::EncoderScaled { wheel, factor } => {
                format!(
                    "the encoder of {} that reads {factor} times the rate",
                    name_of(*wheel)
                )
            }
            Self::PoseLost => "the lost pose sensor".to_owned(),
            Self::PoseShifted { by_m, by_rad } => format!(
                "the pose sensor with an offset of {:.1} mm and {:.2}°",
                1e3 * by_m[0].hypot(by_m[1]),
                by_rad.to_degrees()
            ),
            Self::BatterySag { share } => {
                format!(
                    "the battery at {} % of its voltage",
                    significant(100.0 * share, 4)
                )
            }
            Self::Push { impulse_n_s, .. } => {
                let size_n_s = impulse_n_s
                    .iter()
                    .map(|part| part * part)
                    .sum::<f64>()
                    .sqrt();
                format!("the push of {} N s", significant(size_n_s, 4))
            }
            Self::Payload { mass_kg, .. } => match *mass_kg < 0.1 {
                true => format!("the payload of {} g", significant(1e3 * mass_kg, 4)),
                false => format!("the payload of {} kg", significant(*mass_kg, 4)),
            },
            Self::RollerStuck { wheel, roller } => {
                format!("the stuck roller {roller} of {}", name_of(*wheel))
            }
            Self::FrictionChanged { friction } => {
                format!("the floor's change of friction to {friction}")
            }
            Self::Tilt {
                amplitude_rad,
                frequency_hz,
                ..
            } => {
                let by_deg = significant(amplitude_rad.to_degrees().abs(), 4);
                match *frequency_hz > 0.0 {
                    true => format!(
                        "the ground that rocks by {by_deg}° at {} Hz",
                        significant(*frequency_hz, 4)
                    ),
                    false => format!("the ground that leans by {by_deg}°"),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 mm ahead and 4 mm to the side are 5 mm.
    #[test]
    fn a_shifted_pose_is_named_by_its_distance() {
        let shifted = FaultKind::PoseShifted {
            by_m: [3e-3, -4e-3],
            by_rad: 0.5,
        };
        let expected = "the pose sensor with an offset of 5.0 mm and 28.65°";
        assert_eq!(shifted.words(|_| None), expected);
    }

    /// The length of (1, 0, 2) N s is the root of 5, 2.23607, of which four digits are said.
    #[test]
    fn a_push_is_named_by_its_size() {
        let push = FaultKind::Push {
            impulse_n_s: [1.0, 0.0, 2.0],
            in_body: false,
            place_m: [0.0; 3],
        };
        assert_eq!(push.words(|_| None), "the push of 2.236 N s");
    }
}
