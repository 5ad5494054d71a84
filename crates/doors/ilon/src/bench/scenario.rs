//! The scenario of a drive.

use super::options::ContactMode;
use crate::Error;
use crate::scenario::{Contacts, RollerBodies, Scenario, Step, Twist};

/// The scenario of a drive at a heading in degrees, with a step in seconds: 1 s of rest, a ramp of
/// 0.5 s, then the held twist to the end. The control rate is about 100 Hz, as closely as the step
/// allows.
pub(super) fn scenario(
    [vx_m_s, vy_m_s, omega_rad_s]: [f64; 3],
    heading_deg: f64,
    kind: ContactMode,
    rate_hz: f64,
    bandwidth_rad_s: Option<f64>,
) -> Result<Scenario, Error> {
    const BASE: &str = "[robot]\nfile = \"\"\n[twist]\n[run]\nduration_s = 5.5\n";
    let physics_dt_s = 1.0 / rate_hz;
    let mut scenario = Scenario::from_toml(BASE, "bench", "")?;
    scenario.robot.roller_bodies = match kind {
        ContactMode::All | ContactMode::Rapier => RollerBodies::All,
        ContactMode::Near => RollerBodies::Near,
    };
    if kind == ContactMode::Rapier {
        scenario.world.solver.contacts = Contacts::Rapier;
    }
    scenario.robot.heading_deg = heading_deg;
    if let Some(bandwidth_rad_s) = bandwidth_rad_s {
        scenario.wheel_loop.bandwidth_rad_s = bandwidth_rad_s;
    }
    scenario.twist = Some(Twist {
        vx_m_s,
        vy_m_s,
        omega_rad_s,
        ..scenario.twist.unwrap_or_default()
    });
    scenario.run.physics_dt_s = Step::Seconds(physics_dt_s);
    scenario.run.control_dt_s = physics_dt_s * (0.01 * rate_hz).round().max(1.0);
    Ok(scenario)
}
