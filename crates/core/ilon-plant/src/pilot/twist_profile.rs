//! The twist of an open-loop run over time.

use ilon_robot::Twist;

use ilon_scenario::scenario::{self, within};

/// A twist over time: constant, with linear ramps between.
#[derive(Clone, Debug, PartialEq)]
pub struct TwistProfile {
    /// The start of each change, in seconds, and the twist after it.
    pub(crate) changes: Vec<(f64, Twist)>,
    ramp_s: f64,
    settle_s: f64,
}

impl TwistProfile {
    /// The profile of a `[twist]` section.
    pub fn new(section: &scenario::Twist) -> Self {
        let first = Twist::new(section.vx_m_s, section.vy_m_s, section.omega_rad_s);
        let further = section.schedule.iter().map(|next| {
            (
                next.from_s,
                Twist::new(next.vx_m_s, next.vy_m_s, next.omega_rad_s),
            )
        });
        Self {
            changes: std::iter::once((section.rest_s, first))
                .chain(further)
                .collect(),
            ramp_s: section.ramp_s,
            settle_s: section.settle_s,
        }
    }

    /// A constant twist.
    pub fn of(twist: Twist) -> Self {
        Self {
            changes: vec![(f64::NEG_INFINITY, twist)],
            ramp_s: 0.0,
            settle_s: 0.0,
        }
    }

    /// The twist in the body frame at a time in seconds. A change without a ramp holds from its
    /// instant on.
    pub fn at(&self, t_s: f64) -> Twist {
        let mut twist = Twist::default();
        for (from_s, to) in &self.changes {
            if !within(t_s, *from_s, None) {
                break;
            }
            let share = match self.ramp_s {
                0.0 => 1.0,
                ramp_s => ((t_s - from_s) / ramp_s).clamp(0.0, 1.0),
            };
            twist = twist + (*to - twist).scaled(share);
        }
        twist
    }

    /// The constant twists, in order.
    pub fn held(&self) -> impl Iterator<Item = Twist> {
        self.changes.iter().map(|(_, twist)| *twist)
    }

    /// The time when the last change has settled, in seconds.
    pub fn settled_s(&self) -> f64 {
        let last_s = self.changes.last().map_or(0.0, |(from_s, _)| *from_s);
        last_s + self.ramp_s + self.settle_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twist_rests_ramps_and_holds() {
        let profile = TwistProfile::new(&scenario::Twist {
            vx_m_s: 0.4,
            schedule: vec![scenario::Scheduled {
                from_s: 3.0,
                vx_m_s: 0.0,
                vy_m_s: -0.2,
                omega_rad_s: 0.0,
            }],
            ..scenario::Twist::default()
        });
        assert_eq!(profile.at(0.5), Twist::default());
        assert_eq!(profile.at(1.25), Twist::new(0.2, 0.0, 0.0));
        assert_eq!(profile.at(2.0), Twist::new(0.4, 0.0, 0.0));
        assert_eq!(profile.at(3.25), Twist::new(0.2, -0.1, 0.0));
        assert_eq!(profile.at(9.0), Twist::new(0.0, -0.2, 0.0));
        assert_eq!(profile.settled_s(), 4.5);
    }

    #[test]
    fn without_a_ramp_a_twist_is_there_at_once_and_whole() {
        let profile = TwistProfile::new(&scenario::Twist {
            vx_m_s: 0.4,
            rest_s: 0.5,
            ramp_s: 0.0,
            ..scenario::Twist::default()
        });
        assert_eq!(profile.at(0.499), Twist::default());
        // Whatever the rounding of a sum of control periods.
        assert_eq!(profile.at(0.5 - 1e-15), Twist::new(0.4, 0.0, 0.0));
        assert_eq!(profile.at(0.5), Twist::new(0.4, 0.0, 0.0));
        assert_eq!(profile.at(9.0), Twist::new(0.4, 0.0, 0.0));
    }
}
