//! Scenarios that repeat a recorded drive.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ilon_robot::Twist;

use super::Scenario;
use super::playback::{Drives, Playback};

impl Scenario {
    /// This scenario with a recorded drive in place of its motion, and without its bounds; and the
    /// text of the drive's log, a CSV file beside the scenario. Each row is a time in seconds and
    /// the twist commanded from then on, in the body frame; the last row ends the drive.
    pub fn driven(mut self, log: impl Into<PathBuf>, rows: &[(f64, Twist)]) -> (Self, String) {
        let mut text = "t_s,vx_m_s,vy_m_s,omega_rad_s\n".to_owned();
        for (t_s, twist) in rows {
            let Twist {
                vx_m_s,
                vy_m_s,
                omega_rad_s,
            } = twist;
            text += &format!("{t_s},{vx_m_s},{vy_m_s},{omega_rad_s}\n");
        }
        (self.reference, self.twist) = (None, None);
        self.playback = Some(Playback {
            file: log.into(),
            drives: Drives::Twist,
            topic: None,
            pose_topic: None,
            joint_topic: None,
            joints_by: None,
            names: BTreeMap::new(),
            from_s: 0.0,
            angle_gain_per_s: None,
        });
        self.expect = Default::default();
        self.run.duration_s = rows.last().map_or(0.0, |(t_s, _)| *t_s);
        (self, text)
    }
}
