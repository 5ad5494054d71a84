//! Several rows as one: the state at the end of the last, and what happened in all of them.

use crate::record::{BodySample, JointSample, Record, Support, WheelSample};

/// Rows that follow each other, as one row.
#[derive(Clone, Debug, Default)]
pub struct Joined {
    record: Record,
    wheels: Vec<WheelSample>,
    /// How long the rows lasted that are joined so far, in seconds.
    lasted_s: f64,
    /// The squares of the wheels' rates over that time, in rad^2/s.
    turned_rad2_s: f64,
    /// The time of the last row, in seconds.
    until_s: f64,
}

impl Joined {
    /// Joins the next row to those before it.
    pub fn add(&mut self, record: &Record, wheels: &[WheelSample]) {
        let lasts_s = record.t_s - self.until_s;
        let turned = wheels.iter().map(|wheel| wheel.rate_rad_s.powi(2));
        let turns_rad2_s = turned.sum::<f64>() * lasts_s;
        self.until_s = record.t_s;
        if self.lasted_s > 0.0 {
            let spans_s = [self.lasted_s, lasts_s];
            let turned_rad2_s = [self.turned_rad2_s, turns_rad2_s];
            let before = std::mem::replace(&mut self.record, *record);
            self.record.join(&before, spans_s, turned_rad2_s);
            for (joined, wheel) in self.wheels.iter_mut().zip(wheels) {
                *joined = WheelSample::joined([joined, wheel], spans_s);
            }
        } else {
            self.record = *record;
            self.wheels.clear();
            self.wheels.extend_from_slice(wheels);
        }
        self.lasted_s += lasts_s;
        self.turned_rad2_s += turns_rad2_s;
    }

    /// The row that all rows since the last call make.
    pub fn take(&mut self) -> (&Record, &[WheelSample]) {
        (self.lasted_s, self.turned_rad2_s) = (0.0, 0.0);
        (&self.record, &self.wheels)
    }
}

/// The weighted mean of two values; the second where nothing has weight.
fn mean([a, b]: [f64; 2], [of_a, of_b]: [f64; 2]) -> f64 {
    match of_a > 0.0 {
        true => b + (a - b) * (of_a / (of_a + of_b)),
        false => b,
    }
}

/// The weighted root mean square of two values.
fn root_mean_square(values: [f64; 2], weights: [f64; 2]) -> f64 {
    mean(values.map(|value| value * value), weights).sqrt()
}

impl Record {
    /// Adds what happened in the rows before: for how long each lasted, in seconds, and the squares
    /// of the wheels' rates over this time.
    fn join(&mut self, before: &Self, spans_s: [f64; 2], turned_rad2_s: [f64; 2]) {
        if let (Some(now), Some(before)) = (&mut self.desired, &before.desired) {
            let most = &mut now.position_error_max_m;
            *most = most.max(before.position_error_max_m);
            let most = &mut now.heading_error_max_rad;
            *most = most.max(before.heading_error_max_rad);
        }
        let shares = [before.saturated_share, self.saturated_share];
        self.saturated_share = mean(shares, spans_s);
        for (joint, before) in self.joints.iter_mut().zip(&before.joints) {
            joint.join(before, spans_s);
        }
        for (body, before) in self.bodies.iter_mut().zip(&before.bodies) {
            body.join(before, spans_s);
        }
        let worst = &mut self.contact_residual_m_s;
        *worst = worst.max(before.contact_residual_m_s);
        let shares = [before.rate_conflict_share, self.rate_conflict_share];
        self.rate_conflict_share = root_mean_square(shares, turned_rad2_s);
        if let (Some(now), Some(before)) = (&mut self.support, &before.support) {
            now.join(before, spans_s);
        }
    }
}

impl JointSample {
    fn join(&mut self, before: &Self, spans_s: [f64; 2]) {
        self.position_min = self.position_min.min(before.position_min);
        self.position_max = self.position_max.max(before.position_max);
        self.force = mean([before.force, self.force], spans_s);
        self.force_min = self.force_min.min(before.force_min);
        self.force_max = self.force_max.max(before.force_max);
    }
}

impl BodySample {
    fn join(&mut self, before: &Self, spans_s: [f64; 2]) {
        self.push_n = mean([before.push_n, self.push_n], spans_s);
        self.push_max_n = self.push_max_n.max(before.push_max_n);
    }
}

impl Support {
    fn join(&mut self, before: &Self, spans_s: [f64; 2]) {
        let mean = |of: fn(&Self) -> f64| mean([of(before), of(self)], spans_s);
        *self = Self {
            wheels_n: mean(|support| support.wheels_n),
            chassis_n: mean(|support| support.chassis_n),
            obstacles_x_n: mean(|support| support.obstacles_x_n),
            obstacles_y_n: mean(|support| support.obstacles_y_n),
        };
    }
}

impl WheelSample {
    /// Two samples that follow each other, of so many seconds each, as one.
    fn joined(samples: [&Self; 2], spans_s: [f64; 2]) -> Self {
        let weighted = |of: fn(&Self) -> f64| {
            let weight = |at: usize| spans_s[at] * of(samples[at]);
            [weight(0), weight(1)]
        };
        let touching_s = weighted(|wheel| wheel.touching_share);
        let pressed_n_s = weighted(|wheel| wheel.normal_force_n);
        let mean_by = |weights: [f64; 2], of: fn(&Self) -> f64| mean(samples.map(of), weights);
        let mean = |of: fn(&Self) -> f64| mean_by(spans_s, of);
        let least = |of: fn(&Self) -> f64| of(samples[0]).min(of(samples[1]));
        let most = |of: fn(&Self) -> f64| of(samples[0]).max(of(samples[1]));
        Self {
            target_peak_rad_s: most(|wheel| wheel.target_peak_rad_s),
            rate_error_rms_rad_s: root_mean_square(
                samples.map(|wheel| wheel.rate_error_rms_rad_s),
                spans_s,
            ),
            torque_n_m: mean(|wheel| wheel.torque_n_m),
            torque_min_n_m: least(|wheel| wheel.torque_min_n_m),
            torque_max_n_m: most(|wheel| wheel.torque_max_n_m),
            hub_height_min_m: least(|wheel| wheel.hub_height_min_m),
            hub_height_max_m: most(|wheel| wheel.hub_height_max_m),
            touching_share: mean(|wheel| wheel.touching_share),
            contact_x_m: mean_by(pressed_n_s, |wheel| wheel.contact_x_m),
            contact_y_m: mean_by(pressed_n_s, |wheel| wheel.contact_y_m),
            normal_force_n: mean(|wheel| wheel.normal_force_n),
            normal_force_min_n: least(|wheel| wheel.normal_force_min_n),
            normal_force_max_n: most(|wheel| wheel.normal_force_max_n),
            force_x_n: mean(|wheel| wheel.force_x_n),
            force_y_n: mean(|wheel| wheel.force_y_n),
            friction: mean_by(pressed_n_s, |wheel| wheel.friction),
            friction_used_max: most(|wheel| wheel.friction_used_max),
            slip_x_m_s: mean_by(touching_s, |wheel| wheel.slip_x_m_s),
            slip_y_m_s: mean_by(touching_s, |wheel| wheel.slip_y_m_s),
            slip_speed_rms_m_s: root_mean_square(
                samples.map(|wheel| wheel.slip_speed_rms_m_s),
                touching_s,
            ),
            slip_speed_max_m_s: most(|wheel| wheel.slip_speed_max_m_s),
            ..*samples[1]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A period of 1 s and one of 3 s: means are by time, by load or by the time of touching,
    /// extremes are over both.
    #[test]
    fn what_happened_in_all_rows_is_in_the_one_that_they_make() {
        let wheel = |force_n: f64, touching_share, torque_n_m: f64| WheelSample {
            normal_force_n: force_n,
            contact_x_m: 0.01 * force_n,
            friction: 0.1 * force_n,
            touching_share,
            torque_n_m,
            torque_min_n_m: -torque_n_m,
            torque_max_n_m: 2.0 * torque_n_m,
            slip_speed_rms_m_s: torque_n_m,
            rate_error_rms_rad_s: torque_n_m,
            slip_x_m_s: torque_n_m,
            rate_rad_s: torque_n_m,
            ..WheelSample::default()
        };
        let record = |t_s, conflict: f64| Record {
            t_s,
            saturated_share: conflict,
            rate_conflict_share: conflict,
            contact_residual_m_s: conflict,
            ..Record::default()
        };
        let pushed = |t_s, conflict, push_n: f64| {
            let mut record = record(t_s, conflict);
            (record.bodies[0].push_n, record.bodies[0].push_max_n) = (push_n, 2.0 * push_n);
            record
        };
        let mut joined = Joined::default();
        joined.add(&record(0.0, 0.0), &[wheel(0.0, 0.0, 7.0)]);
        joined.take();
        joined.add(&pushed(1.0, 1.0, 8.0), &[wheel(2.0, 0.5, 4.0)]);
        joined.add(&pushed(4.0, 0.0, 4.0), &[wheel(6.0, 0.5, 1.0)]);
        let (of_both, wheels) = joined.take();
        let body = of_both.bodies[0];
        assert_eq!((body.push_n, body.push_max_n), (5.0, 16.0));
        assert_eq!((of_both.t_s, of_both.saturated_share), (4.0, 0.25));
        assert_eq!(of_both.contact_residual_m_s, 1.0);
        // 16 rad^2/s^2 for 1 s, all of no motion, and 1 rad^2/s^2 for 3 s.
        let conflict = (16.0_f64 / 19.0).sqrt();
        assert!((of_both.rate_conflict_share - conflict).abs() < 1e-15);
        let sample = wheels[0];
        assert_eq!((sample.normal_force_n, sample.touching_share), (5.0, 0.5));
        // 2 N s at 0.02 m and 18 N s at 0.06 m.
        assert!((sample.contact_x_m - 0.056).abs() < 1e-15);
        assert!((sample.friction - 0.56).abs() < 1e-15);
        let torques = [
            sample.torque_min_n_m,
            sample.torque_n_m,
            sample.torque_max_n_m,
        ];
        assert_eq!(torques, [-4.0, 1.75, 8.0]);
        // 16 for half a second and 1 for one and a half.
        assert_eq!(sample.slip_speed_rms_m_s, 4.75_f64.sqrt());
        // 16 for 1 s and 1 for 3 s.
        assert_eq!(sample.rate_error_rms_rad_s, 4.75_f64.sqrt());
        assert_eq!((sample.slip_x_m_s, sample.rate_rad_s), (1.75, 1.0));
    }
}
