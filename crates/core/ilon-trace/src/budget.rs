//! The error budget between two rows, and at one row.

use ilon_robot::{Twist, wrap_angle};

use crate::ledger::{Chain, Terms};
use crate::record::Record;

impl Chain {
    /// The chain of a robot that keeps the state of a row for `time_s` seconds, with a controller
    /// that knows the robot, all wheels on the ground and consistent wheel rates.
    pub fn held(record: &Record, time_s: f64) -> Self {
        Self {
            asked: record.command_twist_in_body.scaled(time_s),
            granted: record.granted_twist_in_body.scaled(time_s),
            believed_of_targets: record.twist_target_ideal.scaled(time_s),
            ideal_of_targets: record.twist_target_ideal.scaled(time_s),
            counted: record.twist_ideal.scaled(time_s),
            ideal: record.twist_ideal.scaled(time_s),
            contact: record.twist_contact.scaled(time_s),
            carried: record.twist_contact.scaled(time_s),
            settled: record.twist_contact.scaled(time_s),
            along: record.truth.twist_in_body.scaled(time_s),
            real: record.truth.twist_in_body.scaled(time_s),
        }
    }
}

impl Terms {
    /// The mean terms from one row to a later one, in m/s and rad/s. The net displacement of each
    /// term in the world is turned into the body frame at the mean of both headings; the error is
    /// of second order in the rotation between them. Zero for rows of one instant.
    pub fn between(before: &Record, after: &Record) -> Self {
        let span_s = after.t_s - before.t_s;
        if span_s <= 0.0 {
            return Self::default();
        }
        let heading_rad = before.truth.pose.heading_rad;
        let turned_rad = wrap_angle(after.truth.pose.heading_rad - heading_rad);
        let grown = after.ledger.since(&before.ledger);
        let body_rad = -(heading_rad + 0.5 * turned_rad);
        grown.zip(&grown, |term, _| {
            let net = Twist::new(term.x_m, term.y_m, term.heading_rad);
            net.rotated(body_rad).scaled(1.0 / span_s)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ledger::Ledger;

    /// A robot turns and falls short by 0.06 m/s to its left: the mean between two rows is 0.06 m/s
    /// to its left.
    #[test]
    fn the_budget_between_two_rows_is_told_in_the_body_frame() {
        let left = |v: f64| Twist::new(0.0, v, -v);
        let mut short = Record {
            command_twist_in_body: left(1.0),
            granted_twist_in_body: left(0.8),
            twist_target_ideal: left(0.8),
            twist_ideal: left(0.7),
            twist_contact: left(0.69),
            ..Record::default()
        };
        short.truth.twist_in_body = left(0.66);
        let (mut before, mut after) = (Record::default(), Record::default());
        let mut ledger = Ledger::default();
        let at = |k: i32| 3.1 + 0.001 * f64::from(k);
        for k in 0..20 {
            if k == 5 {
                before.t_s = 0.5;
                before.ledger = ledger;
                before.truth.pose.heading_rad = at(k);
            }
            ledger.count(&Chain::held(&short, 0.1), [at(k), at(k + 1)]);
        }
        after.t_s = 2.0;
        after.ledger = ledger;
        after.truth.pose.heading_rad = wrap_angle(at(20));
        let terms = Terms::between(&before, &after);
        // It turns by 15 mrad: the second-order error is 15e-3^2 / 24, 1e-5 of the value.
        let near = |a: f64, b: f64| (a - b).abs() < 1e-5 * b.abs().max(0.1);
        assert!(near(terms.slip.vy_m_s, 0.03) && near(terms.slip.vx_m_s, 0.0));
        assert!(near(terms.total.vy_m_s, 0.34) && near(terms.total.omega_rad_s, -0.34));
        assert_eq!(Terms::between(&after, &after), Terms::default());
    }
}
