//! The ledger: where the difference between the twist asked for and the real twist goes.
//!
//! At every step, in the body frame,
//!
//! asked - real = guidance + compensation + servo + geometry + slip
//!
//! | term | is | why |
//! |---|---|---|
//! | guidance | asked - granted | saturation made a task give way |
//! | compensation | granted - ideal(targets) | the command allows for the rollers' geometry; zero under eq. (7) |
//! | servo | ideal(targets) - ideal(rates) | the wheels have not reached their targets |
//! | geometry | ideal(rates) - contact(rates) | the touching roller is tilted and stands off the wheel's middle |
//! | slip | contact(rates) - real | the contacts slide |
//!
//! where ideal is Indiveri 2009, eq. (7), and contact the contact kinematics. The sum telescopes, so that it equals
//! the total to rounding, whatever the run did.

use ilon_robot::Twist;
use serde::{Deserialize, Serialize};

use crate::record::Record;
use crate::trace::Trace;

/// The terms of the ledger at one step, as twists in the body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// Asked minus real: what the others add up to.
    pub total: Twist,
    /// What saturation took away.
    pub guidance: Twist,
    /// What the command gave in advance against the rollers' geometry.
    pub compensation: Twist,
    /// What the wheels have not reached.
    pub servo: Twist,
    /// What the rollers' geometry takes.
    pub geometry: Twist,
    /// What sliding takes.
    pub slip: Twist,
}

impl Terms {
    /// The terms of one record.
    pub fn of(record: &Record) -> Self {
        let asked = record.command_twist_in_body;
        let granted = record.granted_twist_in_body;
        let ideal_of_targets = record.twist_target_ideal;
        let ideal = record.twist_ideal;
        let contact = record.twist_contact;
        let real = record.truth.twist_in_body;
        Self {
            total: asked - real,
            guidance: asked - granted,
            compensation: granted - ideal_of_targets,
            servo: ideal_of_targets - ideal,
            geometry: ideal - contact,
            slip: contact - real,
        }
    }

    /// The five terms with their names, in the order of the chain from asked to real.
    pub fn named(&self) -> [(&'static str, Twist); 5] {
        [
            ("guidance", self.guidance),
            ("compensation", self.compensation),
            ("servo", self.servo),
            ("geometry", self.geometry),
            ("slip", self.slip),
        ]
    }
}

/// One term of the ledger over the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Integral {
    /// Net displacement along the world's x axis, in metres.
    pub x_m: f64,
    /// Net displacement along the world's y axis, in metres.
    pub y_m: f64,
    /// Net turn, in radians.
    pub heading_rad: f64,
    /// Length of the way: the integral of the linear part's magnitude, in metres.
    pub path_m: f64,
    /// The integral of the yaw rate's magnitude, in radians.
    pub turned_rad: f64,
}

/// The ledger integrated over the run, each twist turned to the world frame by the true heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Ledger {
    /// Asked minus real: what the others add up to in `x_m`, `y_m` and `heading_rad`.
    pub total: Integral,
    /// What saturation took away.
    pub guidance: Integral,
    /// What the command gave in advance against the rollers' geometry.
    pub compensation: Integral,
    /// What the wheels had not reached.
    pub servo: Integral,
    /// What the rollers' geometry took.
    pub geometry: Integral,
    /// What sliding took.
    pub slip: Integral,
}

impl Ledger {
    /// The ledger of a run. Each record holds until the next.
    pub fn of(trace: &Trace) -> Self {
        let mut ledger = Self::default();
        for record in trace.records() {
            ledger.add(record, trace.header.row_span_s(record.t_s));
        }
        ledger
    }

    /// Adds a record that holds for `dt_s`.
    pub(crate) fn add(&mut self, record: &Record, dt_s: f64) {
        let heading_rad = record.truth.pose.heading_rad;
        let terms = Terms::of(record);
        self.total.add(terms.total, heading_rad, dt_s);
        self.guidance.add(terms.guidance, heading_rad, dt_s);
        self.compensation.add(terms.compensation, heading_rad, dt_s);
        self.servo.add(terms.servo, heading_rad, dt_s);
        self.geometry.add(terms.geometry, heading_rad, dt_s);
        self.slip.add(terms.slip, heading_rad, dt_s);
    }

    /// The five terms with their names, in the order of the chain from asked to real.
    pub fn named(&self) -> [(&'static str, Integral); 5] {
        [
            ("guidance", self.guidance),
            ("compensation", self.compensation),
            ("servo", self.servo),
            ("geometry", self.geometry),
            ("slip", self.slip),
        ]
    }
}

impl Integral {
    /// Adds a twist in the body frame held for `dt_s`.
    fn add(&mut self, twist_in_body: Twist, heading_rad: f64, dt_s: f64) {
        let step = twist_in_body.rotated(heading_rad).scaled(dt_s);
        self.x_m += step.vx_m_s;
        self.y_m += step.vy_m_s;
        self.heading_rad += step.omega_rad_s;
        self.path_m += step.linear_m_s().norm();
        self.turned_rad += step.omega_rad_s.abs();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::Header;
    use crate::sample::made_up_trace;

    #[test]
    fn the_terms_add_up_to_the_total_at_every_step_and_over_the_run() {
        let trace = made_up_trace(4, 500, true);
        for record in trace.records() {
            let terms = Terms::of(record);
            let sum = terms
                .named()
                .iter()
                .fold(Twist::default(), |s, (_, t)| s + *t);
            let rest = sum - terms.total;
            // Ten additions of numbers below 100, each rounding below 1e-14.
            assert!(rest.linear_m_s().norm() < 1e-12 && rest.omega_rad_s.abs() < 1e-12);
        }
        let ledger = Ledger::of(&trace);
        let sum = |f: fn(&Integral) -> f64| ledger.named().iter().map(|(_, i)| f(i)).sum::<f64>();
        // 500 steps of the above, times dt and a rotation.
        assert!((sum(|i| i.x_m) - ledger.total.x_m).abs() < 1e-11);
        assert!((sum(|i| i.y_m) - ledger.total.y_m).abs() < 1e-11);
        assert!((sum(|i| i.heading_rad) - ledger.total.heading_rad).abs() < 1e-11);
        assert!(ledger.total.path_m > 0.0);
    }

    #[test]
    fn each_cause_is_booked_under_its_own_name() {
        // A robot asked for 1 m/s to the left and 1 rad/s to the right: saturation leaves 0.8, the wheels reach 0.7, of which
        // the rollers' geometry leaves 0.69, of which slip leaves 0.66.
        let left = |v| Twist::new(0.0, v, -v);
        let mut record = Record {
            command_twist_in_body: left(1.0),
            granted_twist_in_body: left(0.8),
            twist_target_ideal: left(0.8),
            twist_ideal: left(0.7),
            twist_contact: left(0.69),
            ..Record::default()
        };
        record.truth.twist_in_body = left(0.66);
        record.truth.pose.heading_rad = f64::atan2(0.8, 0.6);
        let header = Header {
            control_dt_s: 0.5,
            ..Header::default()
        };
        let mut trace = Trace::with_capacity(header, 4);
        for _ in 0..4 {
            trace.push(record, &[]);
        }
        let ledger = Ledger::of(&trace);
        // 2 s; the body's left is (-0.8, 0.6) in the world.
        for (got, want) in [
            (ledger.guidance, 0.4),
            (ledger.compensation, 0.0),
            (ledger.servo, 0.2),
            (ledger.geometry, 0.02),
            (ledger.slip, 0.06),
            (ledger.total, 0.68),
        ] {
            // Differences of decimals near 1: a few 1e-16 each, four of them.
            let near = |a: f64, b: f64| (a - b).abs() < 1e-14;
            assert!(near(got.x_m, -0.8 * want) && near(got.y_m, 0.6 * want));
            assert!(near(got.heading_rad, -want));
            assert!(near(got.path_m, want) && near(got.turned_rad, want));
        }
    }
}
