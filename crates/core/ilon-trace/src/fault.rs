//! What went wrong on purpose in a run, as data: whoever tells of it needs no scenario to read.

use serde::{Deserialize, Serialize};

/// One thing that went wrong on purpose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// When it begins, in seconds.
    pub from_s: f64,
    /// When it ends, in seconds; `None` where it never does.
    pub until_s: Option<f64>,
    /// What it is.
    pub kind: FaultKind,
}

/// What goes wrong. Wheels count as in [`crate::Header::wheels`].
///
/// It is exhaustive, so that a kind that is added cannot be forgotten by what writes it or tells of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// A motor is driven by nobody.
    MotorLost {
        /// Its wheel.
        wheel: usize,
        /// Whether its winding is shorted, so that its back-EMF brakes the wheel.
        #[serde(default)]
        shorted: bool,
    },
    /// An encoder reads zero.
    EncoderLost {
        /// Its wheel.
        wheel: usize,
    },
    /// An encoder counts wrong.
    EncoderScaled {
        /// Its wheel.
        wheel: usize,
        /// The rate that it reads over the real one.
        factor: f64,
    },
    /// The pose sensor sees nothing.
    PoseLost,
    /// The pose sensor is off.
    PoseShifted {
        /// By how much along the world's x and y, in metres.
        by_m: [f64; 2],
        /// By how much in heading, in radians.
        by_rad: f64,
    },
    /// The battery sags.
    BatterySag {
        /// What is left of its voltage, in [0, 1].
        share: f64,
    },
    /// Something pushes the chassis.
    Push {
        /// The impulse, spread evenly over the time, in N s.
        impulse_n_s: [f64; 3],
        /// Whether its axes are the robot's, turned level, and not the world's.
        in_body: bool,
        /// Where on the chassis, in the body frame, in metres.
        place_m: [f64; 3],
    },
    /// A mass lies on the chassis.
    Payload {
        /// Its mass, in kg.
        mass_kg: f64,
        /// Where on the chassis, in the body frame, in metres.
        place_m: [f64; 3],
    },
    /// A roller does not turn on its axle.
    RollerStuck {
        /// Its wheel.
        wheel: usize,
        /// Its number on the wheel, from 0.
        roller: u32,
    },
    /// The floor has another friction, everywhere but on its patches.
    FrictionChanged {
        /// Coulomb's coefficient.
        friction: f64,
    },
    /// The ground leans, or rocks.
    Tilt {
        /// The largest angle, in radians.
        amplitude_rad: f64,
        /// How often it rocks, in Hz; 0 where it leans and stays.
        frequency_hz: f64,
        /// Which way it goes down first, in radians from the world's x axis.
        direction_rad: f64,
    },
}

impl Fault {
    /// What it is, to be read behind "without", with its times: `the payload of 2 kg from 3.00 s on`. Wheels are called by the names that are given.
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
    /// What it is, to be read behind "without". Wheels are called by the names that are given.
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
                "the pose sensor that is off by {:.1} mm and {:.2}°",
                1e3 * by_m[0].hypot(by_m[1]),
                by_rad.to_degrees()
            ),
            Self::BatterySag { share } => {
                format!("the battery at {} % of its voltage", rounded(100.0 * share))
            }
            Self::Push { impulse_n_s, .. } => {
                let size_n_s = impulse_n_s
                    .iter()
                    .map(|part| part * part)
                    .sum::<f64>()
                    .sqrt();
                format!("the push of {} N s", rounded(size_n_s))
            }
            Self::Payload { mass_kg, .. } => match *mass_kg < 0.1 {
                true => format!("the payload of {} g", rounded(1e3 * mass_kg)),
                false => format!("the payload of {} kg", rounded(*mass_kg)),
            },
            Self::RollerStuck { wheel, roller } => {
                format!("the stuck roller {roller} of {}", name_of(*wheel))
            }
            Self::FrictionChanged { friction } => format!("the floor's friction of {friction}"),
            Self::Tilt {
                amplitude_rad,
                frequency_hz,
                ..
            } => {
                let by_deg = rounded(amplitude_rad.to_degrees().abs());
                match *frequency_hz > 0.0 {
                    true => format!(
                        "the ground that rocks by {by_deg}° at {} Hz",
                        rounded(*frequency_hz)
                    ),
                    false => format!("the ground that leans by {by_deg}°"),
                }
            }
        }
    }
}

/// A number with four significant digits, without zeros at its end.
fn rounded(x: f64) -> f64 {
    let text = format!("{x:.3e}");
    text.parse().unwrap_or(x)
}
