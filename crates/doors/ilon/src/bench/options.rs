//! What is measured.

use ilon_formats::LoadRobot;
use ilon_robot::Robot;

use crate::Error;

/// The robots that are built in, and their files.
pub const ROBOTS: [(&str, &str); 2] = [
    ("mecanum4", include_str!("mecanum4.urdf")),
    ("volksbot", include_str!("volksbot.urdf")),
];

/// Physics steps a second with the shapes of all rollers in the world.
const ALL_RATES_HZ: [f64; 7] = [1000.0, 500.0, 240.0, 120.0, 60.0, 30.0, 20.0];
/// Physics steps a second in the contact window.
const NEAR_RATES_HZ: [f64; 10] = [
    1000.0, 500.0, 240.0, 120.0, 60.0, 40.0, 30.0, 20.0, 15.0, 10.0,
];
/// Physics steps a second with contacts that rapier solves.
const RAPIER_RATES_HZ: [f64; 3] = [1000.0, 500.0, 240.0];
/// Which rollers are looked at, and who solves their contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactMode {
    /// All of them; ilon.
    All,
    /// Those near the ground; ilon.
    Near,
    /// All of them; rapier itself.
    Rapier,
}

/// What to measure.
#[derive(Clone, Debug)]
pub struct Options {
    /// The robots, each by a name that no other has.
    pub robots: Vec<(String, Robot)>,
    /// Which rollers are looked at, or who solves their contacts, and at how many steps a second (> 0), in the order of
    /// measurement.
    pub configurations: Vec<(ContactMode, f64)>,
    /// Bandwidth of the wheel loops on the ground, in rad/s; a scenario's own where none is given.
    pub bandwidth_rad_s: Option<f64>,
    /// Headings at which the accuracy is measured, in degrees, at least one; speed is measured at the first.
    pub headings_deg: Vec<f64>,
    /// In how many rounds, at least 1, all configurations are timed: a stretch of each drive or more a round, of which the
    /// best counts.
    pub rounds: usize,
    /// How many robots simulate at once in one process; none to leave that out.
    pub fleets: Vec<usize>,
    /// On how many threads they do so.
    pub threads: Vec<usize>,
}

impl Options {
    /// All that there is to measure, with both built-in robots: some three minutes.
    ///
    /// # Errors
    /// None of the built-in robots has a fault; an error is one of this program.
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
            fleets: vec![1, 10, 100],
            threads: vec![1, 2],
        })
    }

    /// A first look, in a tenth of the time.
    ///
    /// # Errors
    /// Like [`Self::full`].
    pub fn quick() -> Result<Self, Error> {
        let near = [240.0, 60.0, 20.0].map(|rate_hz| (ContactMode::Near, rate_hz));
        Ok(Self {
            configurations: [(ContactMode::All, 240.0)]
                .into_iter()
                .chain(near)
                .collect(),
            headings_deg: vec![20.0],
            rounds: 3,
            fleets: vec![1, 10],
            ..Self::full()?
        })
    }

    /// A built-in robot by its name.
    ///
    /// # Errors
    /// Where there is none of that name.
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
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::All, Self::Near, Self::Rapier];

    /// The kind in a word, as a scenario writes it.
    pub fn word(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Near => "near",
            Self::Rapier => "rapier",
        }
    }
}
