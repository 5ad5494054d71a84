//! Distance of the simulated robot from the one in a measured log.

use ilon_robot::{Pose, wrap_angle};
use ilon_trace::Record;

use crate::text::{angle, length, time};

/// Sums over the rows with a measured pose.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Measured {
    rows: usize,
    sum_m2: f64,
    largest_m: f64,
    largest_at_s: f64,
    last_m: f64,
    last_rad: f64,
}

/// Returns the distance between the simulated and the measured position in metres, and the
/// simulated minus the measured heading in radians.
pub(crate) fn apart(truth: Pose, measured: Pose) -> (f64, f64) {
    (
        (truth.position_m() - measured.position_m()).norm(),
        wrap_angle(truth.heading_rad - measured.heading_rad),
    )
}

impl Measured {
    pub fn add(&mut self, record: &Record) {
        let Some(measured) = record.measured else {
            return;
        };
        let (apart_m, turned_rad) = apart(record.truth.pose, measured);
        self.rows += 1;
        self.sum_m2 += apart_m * apart_m;
        if apart_m > self.largest_m {
            (self.largest_m, self.largest_at_s) = (apart_m, record.t_s);
        }
        (self.last_m, self.last_rad) = (apart_m, turned_rad);
    }

    /// Returns the result as HTML; `None` if nothing was measured.
    pub fn sentence(&self) -> Option<String> {
        if self.rows == 0 {
            return None;
        }
        let rms_m = (self.sum_m2 / self.rows as f64).sqrt();
        Some(format!(
            "The simulated robot is up to <b>{}</b> from where the log measured the real one, at <b>{}</b> ({} rms), and at the end \
             <b>{}</b> and <b>{}</b>.",
            length(self.largest_m),
            time(self.largest_at_s),
            length(rms_m),
            length(self.last_m),
            angle(self.last_rad)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_the_mean_and_the_last_distance_are_said() {
        let mut sums = Measured::default();
        assert_eq!(sums.sentence(), None);
        for (t_s, x_m) in [(0.0, 0.0), (1.0, 0.4), (2.0, 0.3)] {
            let truth = Pose {
                x_m,
                heading_rad: 0.1,
                ..Pose::default()
            };
            sums.add(&Record {
                t_s,
                truth: ilon_trace::Truth {
                    pose: truth,
                    ..ilon_trace::Truth::default()
                },
                // Nothing is measured at the second instant.
                measured: (t_s != 0.0).then(Pose::default),
                ..Record::default()
            });
        }
        // rms of 0.4 and 0.3 m: sqrt(0.125) = 0.35355 m.
        let said = sums.sentence().unwrap_or_default();
        for words in [
            "<b>400.0 mm</b>",
            "at <b>1.00 s</b>",
            "353.6 mm rms",
            "<b>300.0 mm</b> and <b>5.73°</b>",
        ] {
            assert!(said.contains(words), "{said}");
        }
    }
}
