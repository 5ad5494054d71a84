//! What to measure.

use ilon_formats::LoadRobot;
use ilon_robot::Robot;

use crate::Error;

/// The built-in robots and their files.
pub const ROBOTS: [(&str, &str); 2] = [
    ("mecanum4", include_str!("mecanum4.urdf")),
    ("volksbot", include_str!("volksbot.urdf")),
];

/// Physics steps per second with the shapes of all rollers in the world.
const ALL_RATES_HZ: [f64; 7] = [1000.0, 500.0, 240.0, 120.0, 60.0, 30.0, 20.0];
/// Physics steps per second with the contact window, which holds only rollers near the ground.
const NEAR_RATES_HZ: [f64; 10] = [
    1000.0, 500.0, 240.0, 120.0, 60.0, 40.0, 30.0, 20.0, 15.0, 10.0,
];
/// Physics steps per second with contacts solved by rapier.
const RAPIER_RATES_HZ: [f64; 3] = [1000.0, 500.0, 240.0];
/// Which rollers are in contact detection, and which solver solves their contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactMode {
    /// All rollers; solved by ilon.
    All,
    /// Rollers near the ground; solved by ilon.
    Near,
    /// All rollers; solved by rapier.
    Rapier,
}

/// What to measure.
#[derive(Clone, Debug)]
pub struct Options {
    /// The robots, each with a unique name.
    pub robots: Vec<(String, Robot)>,
    /// Contact modes with physics steps per second (> 0), in the order of measurement.
    pub configurations: Vec<(ContactMode, f64)>,
    /// Bandwidth of the wheel loops on the ground, in rad/s; `None` for a scenario's default.
    pub bandwidth_rad_s: Option<f64>,
    /// Headings at which accuracy is measured, in degrees, at least one. Speed is measured at the
    /// first.
    pub headings_deg: Vec<f64>,
    /// Number of timing rounds, at least 1. Each round times at least one stretch of each drive;
    /// the best stretch counts.
    pub rounds: usize,
}

impl Options {
    /// The whole measurement with both built-in robots; takes about three minutes.
    ///
    /// # Errors
    /// The built-in robots have no faults; an error is a defect of this program.
    pub fn full() -> Result<Self, Error> {
        let all = ALL_RATES_HZ.map(|rate_hz| (ContactMode::All, rate_hz));
        let near = NEAR_RATES_HZ.map(|rate_hz| (ContactMode::Near, rate_hz));
        let rapier = RAPIER_RATES_HZ.map(|rate_hz| (ContactMode::Rapier, rate_hz));
        let robots = ROBOTS.map(|(name, _)| Ok((name.to_owned(), Self::built_in(name)?)));
        Ok(Self {
            robots: robots.into_iter().collect::<Result<_, Error>>()?,
            configurations: all.into_iter().chain(near).chain(rapier).collect(),
            bandwidth_rad_s: None,
            headings_deg: vec![0.0, 20.0],
            rounds: 5,
        })
    }

    /// A short measurement, in a tenth of the time.
    ///
    /// # Errors
    /// As [`Self::full`].
    pub fn quick() -> Result<Self, Error> {
        let near = [240.0, 60.0, 20.0].map(|rate_hz| (ContactMode::Near, rate_hz));
        Ok(Self {
            configurations: [(ContactMode::All, 240.0)]
                .into_iter()
                .chain(near)
                .collect(),
            headings_deg: vec![20.0],
            rounds: 3,
            ..Self::full()?
        })
    }

    /// Returns a built-in robot by its name.
    ///
    /// # Errors
    /// If no built-in robot has that name.
    pub fn built_in(name: &str) -> Result<Robot, Error> {
        let known = ROBOTS.iter().find(|(known, _)| *known == name);
        let (name, urdf) = known.ok_or_else(|| {
            Error::invalid(
                format!("there is no built-in robot `{name}`"),
                "choose `mecanum4` or `volksbot`, or name a robot's file",
            )
        })?;
        Ok(Robot::from_urdf_str(urdf, name)?)
    }
}

impl ContactMode {
    /// All contact modes.
    pub const ALL: [Self; 3] = [Self::All, Self::Near, Self::Rapier];

    /// The mode's keyword in a scenario.
    pub fn word(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Near => "near",
            Self::Rapier => "rapier",
        }
    }
}
