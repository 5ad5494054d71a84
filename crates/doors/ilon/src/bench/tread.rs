//! The cost of treads: time of a step on compliant rollers over that on rigid ones, timed in turn
//! in one run.

use ilon_report::bench::{DRIVES, TreadCost};
use ilon_robot::{Robot, Tread};

use super::configuration::Timing;
use super::options::ContactMode;
use crate::Error;

/// Stiffness of a rubber tread, in N/m, for a robot without treads; chosen.
const STIFFNESS_N_M: f64 = 1e5;
/// Steps per second of both robots: treads need steps that resolve their spring.
const RATE_HZ: f64 = 1000.0;
const KIND: ContactMode = ContactMode::Near;

/// A robot with and without treads, warmed up.
pub(super) struct TreadTiming {
    stiffness_n_m: f64,
    rigid: Timing,
    gives: Timing,
}

impl TreadTiming {
    /// Sets up a robot without its treads and with them; a robot without treads gets rubber ones.
    pub fn warmed_up(
        robot: &Robot,
        bandwidth_rad_s: Option<f64>,
        heading_deg: f64,
    ) -> Result<Self, Error> {
        let with = |tread: &dyn Fn(Option<Tread>) -> Option<Tread>| {
            let mut robot = robot.clone();
            for wheel in &mut robot.wheels {
                wheel.surface.tread = tread(wheel.surface.tread);
            }
            robot
        };
        let rigid = with(&|_| None);
        let gives = with(&|own| own.or(Some(Tread::new(STIFFNESS_N_M))));
        let own = gives.wheels.first().and_then(|wheel| wheel.surface.tread);
        let timing =
            |robot: &Robot| Timing::warmed_up(robot, (KIND, RATE_HZ), bandwidth_rad_s, heading_deg);
        Ok(Self {
            stiffness_n_m: own.map_or(STIFFNESS_N_M, |tread| tread.stiffness_n_m),
            rigid: timing(&rigid)?,
            gives: timing(&gives)?,
        })
    }

    /// Times both, one after the other.
    pub fn round(&mut self) {
        self.rigid.round();
        self.gives.round();
    }

    /// The result; `None` without a CPU clock.
    pub fn cost(self) -> Option<TreadCost> {
        let (rigid, gives) = (self.rigid.cpu_s_per_sim_s()?, self.gives.cpu_s_per_sim_s()?);
        let drives = DRIVES.iter().zip(gives.iter().zip(&rigid));
        Some(TreadCost {
            rate_hz: RATE_HZ,
            roller_bodies: KIND.word().to_owned(),
            stiffness_n_m: self.stiffness_n_m,
            ratio: gives.iter().sum::<f64>() / rigid.iter().sum::<f64>(),
            drives: drives
                .map(|((name, _), (gives, rigid))| ((*name).to_owned(), gives / rigid))
                .collect(),
        })
    }
}
