//! Recorded motions of either engine, and their differences.

use ilon_robot::wrap_angle;
use nalgebra::Vector2;

/// Work and heat since the start, in J.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Heat of sliding.
    pub slip_j: f64,
    /// Dissipated by contacts along the ground: sliding, and in the oracle also the dampers and
    /// lost energy of the bristles.
    pub along_ground_j: f64,
    /// Otherwise dissipated by contacts: the oracle's dampers, ilon's impacts.
    pub other_j: f64,
    /// Work of the wheels' drives.
    pub drives_j: f64,
    /// Heat of the bearings.
    pub bearings_j: f64,
    /// Current kinetic energy.
    pub kinetic_j: f64,
}

/// The end of one tick of a course.
#[derive(Clone, Debug)]
pub struct Row {
    pub t_s: f64,
    pub position_m: Vector2<f64>,
    /// Not wrapped.
    pub heading_rad: f64,
    pub yaw_rate_rad_s: f64,
    /// Sliding speed of the fastest wheel, the load-weighted mean over its rollers, in m/s.
    pub slide_m_s: f64,
    /// Each wheel's normal force, the mean over the tick, in N.
    pub loads_n: Vec<f64>,
    /// Angles of the wheels, in rad.
    pub wheels_rad: Vec<f64>,
    /// Height of the body frame's origin in metres, roll and pitch in rad.
    pub stands: [f64; 3],
    /// Positions of the joints between bodies, in rad or m.
    pub joints: Vec<f64>,
    pub sums: Sums,
}

/// A recorded motion.
#[derive(Clone, Debug, Default)]
pub struct Course {
    pub rows: Vec<Row>,
}

impl Course {
    pub fn record(&mut self, mut row: Row) {
        if let Some(last) = self.rows.last() {
            let turned = wrap_angle(row.heading_rad - last.heading_rad);
            row.heading_rad = last.heading_rad + turned;
        }
        self.rows.push(row);
    }

    pub fn end(&self) -> &Row {
        self.rows.last().expect("a course has rows")
    }

    /// The last row that ends at `t_s` or before.
    pub fn at(&self, t_s: f64) -> &Row {
        let before = |row: &&Row| row.t_s < t_s + 1e-9;
        self.rows
            .iter()
            .rfind(before)
            .expect("the course has begun")
    }

    /// Path length of a point that turning moves by `arm_m` per radian, in metres.
    pub fn way_m(&self, arm_m: f64) -> f64 {
        let pairs = self.rows.windows(2);
        pairs.map(|pair| apart_m(&pair[0], &pair[1], arm_m)).sum()
    }

    /// The largest distance from another course at the same time, with turning counted on an arm,
    /// in metres.
    pub fn worst_m(&self, other: &Self, arm_m: f64) -> f64 {
        let pairs = self.rows.iter().zip(&other.rows);
        pairs.map(|(a, b)| apart_m(a, b, arm_m)).fold(0.0, f64::max)
    }

    /// The longest sequence of ticks in which rollers slide faster than `limit_m_s`: the ends of
    /// its first and last tick. Shorter ones are rollers that are spun up at hand-overs.
    pub fn slide_s(&self, limit_m_s: f64) -> Option<(f64, f64)> {
        let stretches = self
            .rows
            .chunk_by(|a, b| (a.slide_m_s > limit_m_s) == (b.slide_m_s > limit_m_s));
        let sliding = stretches.filter(|rows| rows[0].slide_m_s > limit_m_s);
        let longest = sliding.max_by_key(|rows| rows.len())?;
        Some((longest[0].t_s, longest[longest.len() - 1].t_s))
    }

    /// The course as far beyond this one as this one is beyond `from`: position, heading, yaw rate
    /// and sums.
    pub fn beyond(&self, from: &Self) -> Self {
        let mut beyond = self.clone();
        for (row, from) in beyond.rows.iter_mut().zip(&from.rows) {
            row.position_m = 2.0 * row.position_m - from.position_m;
            let twice = |near: &mut f64, far: f64| *near = 2.0 * *near - far;
            twice(&mut row.heading_rad, from.heading_rad);
            twice(&mut row.yaw_rate_rad_s, from.yaw_rate_rad_s);
            twice(&mut row.sums.slip_j, from.sums.slip_j);
            twice(&mut row.sums.other_j, from.sums.other_j);
            twice(&mut row.sums.drives_j, from.sums.drives_j);
            twice(&mut row.sums.bearings_j, from.sums.bearings_j);
            twice(&mut row.sums.kinetic_j, from.sums.kinetic_j);
        }
        beyond
    }
}

fn apart_m(a: &Row, b: &Row, arm_m: f64) -> f64 {
    let turned_m = arm_m * (a.heading_rad - b.heading_rad);
    (a.position_m - b.position_m).norm().hypot(turned_m)
}
