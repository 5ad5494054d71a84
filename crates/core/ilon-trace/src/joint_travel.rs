//! The travel of joints between bodies over a run.

use crate::fold::Mean;
use crate::header::Header;
use crate::metrics::JointTravel;
use crate::record::{MAX_JOINTS, Record};

/// A joint counts as on a stop within this share of its range, because stops are elastic. Chosen.
const NEAR_STOP: f64 = 1e-3;

/// Sums over all joints in one pass over all rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointAccumulator {
    joints: Vec<One>,
}

#[derive(Clone, Debug)]
struct One {
    least: f64,
    most: f64,
    on_stop: Mean,
}

impl JointAccumulator {
    pub fn add(&mut self, header: &Header, record: &Record) {
        let count = header.joints.len().min(MAX_JOINTS);
        let none = One {
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            on_stop: Mean::default(),
        };
        self.joints.resize(count, none);
        let samples = record.joints.iter().zip(&header.joints);
        for (one, (sample, of)) in self.joints.iter_mut().zip(samples) {
            one.least = one.least.min(sample.position_min);
            one.most = one.most.max(sample.position_max);
            if let Some([lower, upper]) = of.limits {
                let near = NEAR_STOP * (upper - lower);
                let is_on = sample.position < lower + near || sample.position > upper - near;
                one.on_stop.add(f64::from(u8::from(is_on)));
            }
        }
    }

    pub fn travels(&self, header: &Header) -> Vec<JointTravel> {
        let joints = self.joints.iter().zip(&header.joints);
        let travel = |(one, of): (&One, &crate::header::JointHeader)| JointTravel {
            name: of.name.clone(),
            slides: of.slides,
            least: one.least,
            most: one.most,
            on_stop: one.on_stop.get(),
        };
        joints.map(travel).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::JointHeader;

    fn joint(name: &str, limits: Option<[f64; 2]>) -> JointHeader {
        JointHeader {
            name: name.to_owned(),
            slides: false,
            limits,
        }
    }

    /// Smallest and largest position over all periods, and the share of rows on a stop, of each
    /// joint.
    #[test]
    fn joints_are_followed_over_a_run() {
        let header = Header {
            joints: vec![joint("rocker", Some([-0.1, 0.1])), joint("turret", None)],
            ..Header::default()
        };
        let mut joints = JointAccumulator::default();
        for [rocker, turret] in [[0.0, 1.0], [0.1, 7.0], [0.05, -2.0], [-0.1, 0.0]] {
            let mut record = Record::default();
            for (sample, position) in record.joints.iter_mut().zip([rocker, turret]) {
                (sample.position, sample.position_min, sample.position_max) =
                    (position, position - 0.25, position + 0.5);
            }
            joints.add(&header, &record);
        }
        let [rocker, turret] = &joints.travels(&header)[..] else {
            panic!("two joints");
        };
        assert_eq!((rocker.least, rocker.most), (-0.35, 0.6));
        assert_eq!(rocker.on_stop, Some(0.5));
        assert_eq!(
            (turret.least, turret.most, turret.on_stop),
            (-2.25, 7.5, None)
        );
    }

    /// Of a joint beyond those that are recorded nothing is known.
    #[test]
    fn joints_beyond_the_recorded_ones_are_left_out() {
        let header = Header {
            joints: vec![joint("one of many", None); MAX_JOINTS + 1],
            ..Header::default()
        };
        let mut joints = JointAccumulator::default();
        joints.add(&header, &Record::default());
        assert_eq!(joints.travels(&header).len(), MAX_JOINTS);
    }
}
