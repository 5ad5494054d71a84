//! The poses of a run at marked times, from which the distance between two runs follows.

use ilon_robot::{Pose, wrap_angle};
use ilon_trace::Apart;

use crate::simulate::RunLoop;

/// The largest number of marks. Chosen.
const MOST_MARKS: u64 = 2000;

/// The largest number of poses drawn, besides the last one. Chosen.
const MOST_DRAWN: usize = 150;

/// Poses of a run at marked control instants. Two runs of one scenario have the same marks.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    /// Control instants from one mark to the next.
    every: u64,
    last: u64,
    seen: u64,
    marks: Vec<(f64, Pose)>,
    leaned_rad: f64,
}

impl Path {
    /// The path of a run of this many control periods, or of its twin, which has `parts` control
    /// periods for each of them.
    pub fn of(control_periods: u64, parts: u64) -> Self {
        Self {
            every: parts * control_periods.div_ceil(MOST_MARKS).max(1),
            last: parts * control_periods,
            seen: 0,
            marks: Vec::new(),
            leaned_rad: 0.0,
        }
    }

    /// Records the run's state at a control instant.
    pub fn look(&mut self, run: &RunLoop) {
        let truth = run.truth();
        let upright = libm::cos(truth.roll_rad) * libm::cos(truth.pitch_rad);
        self.leaned_rad = self.leaned_rad.max(libm::acos(upright.clamp(-1.0, 1.0)));
        if self.seen.is_multiple_of(self.every) || self.seen == self.last {
            self.marks.push((run.time_s(), truth.pose));
        }
        self.seen += 1;
    }

    /// Poses for a picture: time in seconds, x and y in metres, heading in radians, rounded.
    pub fn drawn(&self) -> Vec<[f64; 4]> {
        let rounded = |x: f64| (1e5 * x).round() * 1e-5;
        let every = self.marks.len().div_ceil(MOST_DRAWN).max(1);
        let drawn = self.marks.iter().step_by(every).chain(self.marks.last());
        drawn
            .map(|(t_s, pose)| [*t_s, pose.x_m, pose.y_m, pose.heading_rad].map(rounded))
            .collect()
    }

    /// The distance between this path and its twin's.
    pub fn apart(&self, twin: &Self) -> Apart {
        let mut apart = Apart {
            twin_leaned_rad: twin.leaned_rad,
            ..Apart::default()
        };
        for (&(t_s, here), &(_, there)) in self.marks.iter().zip(&twin.marks) {
            let off_m = (here.position_m() - there.position_m()).norm();
            let off_rad = wrap_angle(here.heading_rad - there.heading_rad);
            if off_m > apart.most_m {
                (apart.most_m, apart.most_at_s) = (off_m, t_s);
            }
            if off_rad.abs() > apart.most_rad {
                (apart.most_rad, apart.most_rad_at_s) = (off_rad.abs(), t_s);
            }
        }
        if let (Some((_, here)), Some((_, there))) = (self.marks.last(), twin.marks.last()) {
            let (sin, cos) = libm::sincos(there.heading_rad);
            let off_m = here.position_m() - there.position_m();
            apart.ahead_m = cos * off_m.x + sin * off_m.y;
            apart.left_m = cos * off_m.y - sin * off_m.x;
            apart.turned_rad = wrap_angle(here.heading_rad - there.heading_rad);
        }
        apart
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The run ends at (2, 1) with a heading of 100 degrees, its twin at (1, 1) with 90 degrees: to
    /// the twin +x is to the right.
    #[test]
    fn the_distance_at_the_end_is_in_the_twins_frame() {
        let path = |x_m: f64, heading_deg: f64| Path {
            marks: vec![(
                1.0,
                Pose {
                    x_m,
                    y_m: 1.0,
                    heading_rad: heading_deg.to_radians(),
                },
            )],
            ..Path::of(1, 1)
        };
        let apart = path(2.0, 100.0).apart(&path(1.0, 90.0));
        assert!(apart.ahead_m.abs() < 1e-15 && (apart.left_m + 1.0).abs() < 1e-15);
        assert!((apart.turned_rad - 10f64.to_radians()).abs() < 1e-12);
        assert_eq!((apart.most_m, apart.most_at_s), (1.0, 1.0));
    }
}
