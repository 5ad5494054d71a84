//! The accelerations of [`Limits`] that the simulated robot can hold.
//!
//! Statics about the middles of the wheels ignore some effects: rollers touch off these middles,
//! wheels strain one another, targets of the wheel loops come in steps. So the plant sprints in
//! each direction of the table, from rest to the top speed and back, with the accelerations of the
//! table. If it slides, the table is lowered, and it sprints again.

use ilon_control::Kinematics;
use ilon_robot::{Robot, Twist};
use ilon_world::World;

use crate::faults::tilt::built_up;
use crate::limits::share::ShareSearch;
use crate::limits::{Limit, LimitRow, Limits, MOTIONS, direction};
use crate::plant::Plant;
use crate::resolve::{Driver, resolve_as_given};
use ilon_scenario::Error;
use ilon_scenario::choices::defaults;
use ilon_scenario::course::command::WheelCommand;
use ilon_scenario::scenario::{Controller, Scenario};

/// Time before the first sprint, in seconds: springs come to rest. Chosen.
const SETTLES_S: f64 = 0.2;

/// Rise time of an acceleration, in seconds. Chosen.
const COMES_S: f64 = 0.1;

/// Longest time of speeding up or slowing down, in seconds, also without a speed limit. Chosen.
const MOST_S: f64 = 1.0;
const WITHOUT_END_S: f64 = 0.4;

impl Limits {
    /// Like [`Limits::of`], but lowered where the simulated robot loses more than 0.5 % of its
    /// motors' work to sliding: with its rollers, springs and joints, under the scenario's wheel
    /// loops, with targets once a control period. [`Limit::share_held`] is the remaining share.
    ///
    /// Outlines are lowered like the neighbouring directions of the table; polytope and box by the
    /// worst of the table at rest and of the corners of the box.
    ///
    /// # Errors
    /// Like [`Limits::of`], and if the scenario cannot be simulated.
    pub fn held(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        let mut limits = Self::of(scenario, robot)?;
        // A robot that cannot stand does not sprint.
        if !limits.remarks.is_empty() {
            return Ok(limits);
        }
        let mut sprinter = Sprinter::new(scenario, robot)?;
        let rows_of = limits.rows.chunk_by_mut(|a, b| a.motion == b.motion);
        let mut motions: Vec<Motion<'_>> = rows_of
            .zip(MOTIONS)
            .map(|(rows, (_, eighths, turning))| Motion {
                direction: direction(eighths, turning),
                rows,
            })
            .collect();
        while let Some(first) = motions.pop() {
            let mut images = vec![first];
            for at in (0..motions.len()).rev() {
                if sprinter.is_mirrored(&images[0], &motions[at])? {
                    images.push(motions.remove(at));
                }
            }
            sprinter.lower(&mut images)?;
        }
        let at_rest = limits.rows.iter().filter(|row| row.speed == 0.0);
        let least = at_rest
            .map(|row| row.speeding_up.share_held)
            .fold(1.0, f64::min);
        // The box stays inside the polytope by the same ratio.
        let held = sprinter.box_held(limits.acceleration_box, least)?;
        limits.acceleration_box = limits.acceleration_box.map(|side| held * side);
        if let Some(polytope) = &mut limits.polytope {
            polytope.scale(held);
        }
        limits.lower_outlines();
        Ok(limits)
    }

    /// Lowers the outlines like the neighbouring directions of the table.
    fn lower_outlines(&mut self) {
        /// Angle between directions of the table, in degrees.
        const APART_DEG: f64 = 45.0;
        let rows: Vec<(f64, f64)> = self
            .rows
            .iter()
            .filter_map(|row| Some((row.direction_deg?, row.speeding_up.share_held)))
            .collect();
        // Each direction has one row per speed level.
        let levels = (rows.len() as f64 * APART_DEG / 360.0).max(1.0) as usize;
        for (level, outline) in self.outlines.iter_mut().enumerate() {
            let of_level = || rows.iter().skip(level).step_by(levels);
            for point in &mut outline.points {
                let weighted = of_level().map(|(direction_deg, share)| {
                    let off_deg = (point.direction_deg - direction_deg).rem_euclid(360.0);
                    let off_deg = off_deg.min(360.0 - off_deg);
                    (1.0 - off_deg / APART_DEG).max(0.0) * share
                });
                point.limit.lower(weighted.sum());
            }
        }
    }
}

impl Limit {
    /// Lowers the limit to a share.
    fn lower(&mut self, share: f64) {
        self.set_share(share * self.share_held);
    }

    /// Sets the share of statics that is held, or tried.
    fn set_share(&mut self, share: f64) {
        self.share_held = share;
        self.largest = share * self.by_statics;
    }
}

/// Energy lost to sliding, and work that the motors gave and took, in J.
#[derive(Clone, Copy, Debug, Default)]
struct Slid {
    slip_j: f64,
    work_j: f64,
}

impl Slid {
    /// Totals since the start of a world.
    fn so_far(world: &World) -> Self {
        Self {
            slip_j: world.slip_energy_j(),
            // Given plus taken: the taken work is the positive work minus the net work.
            work_j: 2.0 * world.motor_positive_energy_j() - world.motor_energy_j(),
        }
    }

    fn plus(self, more: Self) -> Self {
        Self {
            slip_j: self.slip_j + more.slip_j,
            work_j: self.work_j + more.work_j,
        }
    }

    fn share(&self) -> f64 {
        match self.work_j > 0.0 {
            true => self.slip_j / self.work_j,
            false => 0.0,
        }
    }
}

impl LimitRow {
    /// The limit of speeding up, or of slowing down.
    fn limit(&self, is_up: bool) -> &Limit {
        match is_up {
            true => &self.speeding_up,
            false => &self.slowing_down,
        }
    }

    fn limit_mut(&mut self, is_up: bool) -> &mut Limit {
        match is_up {
            true => &mut self.speeding_up,
            false => &mut self.slowing_down,
        }
    }
}

/// A direction and its rows of the table.
struct Motion<'a> {
    direction: Twist,
    rows: &'a mut [LimitRow],
}

impl Motion<'_> {
    /// Whether another direction is its image in a mirror along or across the robot, and has the
    /// same limits by statics.
    fn has_image(&self, other: &Motion<'_>) -> bool {
        /// Relative, for rounding.
        const SAME: f64 = 1e-9;
        let parts = |twist: Twist| [twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s];
        let pairs = parts(self.direction)
            .into_iter()
            .zip(parts(other.direction));
        let mut limits = self.rows.iter().zip(other.rows.iter());
        let is_same = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
        pairs
            .into_iter()
            .all(|(a, b)| (a.abs() - b.abs()).abs() <= SAME)
            && limits.all(|(a, b)| {
                is_same(a.speed, b.speed)
                    && [true, false]
                        .into_iter()
                        .all(|up| is_same(a.limit(up).by_statics, b.limit(up).by_statics))
            })
    }
}

/// A robot that moves along a direction, and its speed, in m/s or rad/s.
#[derive(Clone)]
struct Moving {
    plant: Plant,
    speed: f64,
}

/// A standing robot for sprints in all directions.
struct Sprinter {
    standing: Plant,
    kinematics: Kinematics,
    period_s: f64,
    rates_rad_s: Vec<f64>,
}

impl Sprinter {
    fn new(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        /// Length of the split parts of steps relative to those of a run. It changes shares by at
        /// most 0.03, and sprints take a quarter of the time.
        const LONGER: f64 = 5.0;
        let mut knowing = Scenario {
            controller: Controller::default(),
            ..scenario.clone()
        };
        let split_dt_s = &mut knowing.world.solver.split_dt_s;
        let of_run_s = defaults::split_dt_s(scenario, robot);
        *split_dt_s = split_dt_s.or(of_run_s.map(|dt_s| LONGER * dt_s));
        let resolved = resolve_as_given(&knowing, robot, Driver::Own)?;
        let mut standing = Plant::new(&resolved, robot)?;
        let rates_rad_s = vec![0.0; robot.wheels.len()];
        let period_s = resolved.control_dt_s();
        for _ in 0..(SETTLES_S / period_s).ceil() as u32 {
            standing.advance(WheelCommand::Rates(&rates_rad_s), period_s)?;
        }
        Ok(Self {
            kinematics: standing.kinematics().clone(),
            standing,
            period_s,
            rates_rad_s,
        })
    }

    /// Whether two motions are mirror images of one another for the simulated robot too: the table
    /// by statics is the same, and so are sliding and work in the first moments of a sprint by it.
    fn is_mirrored(&mut self, one: &Motion<'_>, other: &Motion<'_>) -> Result<bool, Error> {
        /// Relative to the motors' work. Rounding differs, and grows from step to step.
        const SAME: f64 = 1e-6;
        if !one.has_image(other) {
            return Ok(false);
        }
        let [one, other] = [self.first_moments(one)?, self.first_moments(other)?];
        let most_j = SAME * one.work_j.max(other.work_j);
        let is_same = |one_j: f64, other_j: f64| (one_j - other_j).abs() <= most_j;
        Ok(is_same(one.work_j, other.work_j) && is_same(one.slip_j, other.slip_j))
    }

    /// Sliding and work while the acceleration of a sprint from rest comes.
    fn first_moments(&mut self, motion: &Motion<'_>) -> Result<Slid, Error> {
        let mut moving = self.at_rest();
        let rows = (&*motion.rows, true);
        let slid = self.sprint(&mut moving, motion.direction, rows, COMES_S)?;
        Ok(slid.into_iter().fold(Slid::default(), Slid::plus))
    }

    fn at_rest(&self) -> Moving {
        Moving {
            plant: self.standing.clone(),
            speed: 0.0,
        }
    }

    /// Lowers the rows of motions that are mirror images of one another until the robot holds them:
    /// speeding up, and slowing down from the speed reached. All have the same rows then: what
    /// slides is that of all together.
    fn lower(&mut self, motions: &mut [Motion<'_>]) -> Result<(), Error> {
        let at_rest = vec![self.at_rest(); motions.len()];
        let fast = self.lower_one_way(motions, (&at_rest, true))?;
        let rows = motions.first().and_then(|motion| motion.rows.last());
        // From rest it slows down like it speeds up the other way.
        if fast.iter().all(|fast| fast.speed > 0.0) && rows.is_some_and(|row| row.speed > 0.0) {
            self.lower_one_way(motions, (&fast, false))?;
        }
        Ok(())
    }

    /// Lowers the limits of speeding up, or of slowing down from a speed, until the robot holds
    /// them. Returns its motions afterwards.
    fn lower_one_way(
        &mut self,
        motions: &mut [Motion<'_>],
        (from, is_up): (&[Moving], bool),
    ) -> Result<Vec<Moving>, Error> {
        const MOST_SPRINTS: usize = 16;
        /// What slides at a smaller share does not slide for the acceleration.
        const LEAST: f64 = 0.3;
        let count = motions.first().map_or(0, |motion| motion.rows.len());
        let mut searches = vec![ShareSearch::new(1.0, LEAST); count];
        let mut moving = from.to_vec();
        for _ in 0..MOST_SPRINTS {
            moving.clone_from_slice(from);
            let mut slid = vec![Slid::default(); count];
            for (motion, moving) in motions.iter().zip(&mut moving) {
                let rows = (&*motion.rows, is_up);
                let of_it = self.sprint(moving, motion.direction, rows, f64::INFINITY)?;
                slid.iter_mut()
                    .zip(of_it)
                    .for_each(|(slid, more)| *slid = slid.plus(more));
            }
            let mut again = false;
            for (at, (slid, search)) in slid.iter().zip(&mut searches).enumerate() {
                let share = motions[0].rows[at].limit(is_up).share_held;
                let next = search.after(share, slid.share());
                again |= next != share;
                set_shares(motions, (at, is_up), next);
            }
            if !again {
                break;
            }
        }
        for (at, search) in searches.iter().enumerate() {
            if let Some(found) = search.found() {
                set_shares(motions, (at, is_up), found.share);
            }
        }
        Ok(moving)
    }

    /// The share, up to `most`, of a box of accelerations from rest of which the robot holds every
    /// corner.
    fn box_held(&mut self, sides: [f64; 3], most: f64) -> Result<f64, Error> {
        let mut held = most;
        for corner in 0..8 {
            let side = |axis: usize| match corner >> axis & 1 {
                0 => sides[axis],
                _ => -sides[axis],
            };
            let mut rows = [LimitRow::from_rest(held)];
            self.lower(&mut [Motion {
                direction: Twist::new(side(0), side(1), side(2)),
                rows: &mut rows,
            }])?;
            held = rows[0].speeding_up.largest;
        }
        Ok(held)
    }

    /// Speeds up along a direction with the rows' accelerations, to beyond the speed of the last,
    /// or slows down to rest, for a time at most; returns the sliding at each row.
    fn sprint(
        &mut self,
        moving: &mut Moving,
        direction: Twist,
        (rows, is_up): (&[LimitRow], bool),
        at_most_s: f64,
    ) -> Result<Vec<Slid>, Error> {
        /// Relative to the fastest row's speed, which is 0.9 of the top speed. Chosen.
        const BEYOND: f64 = 1.05;
        let mut slid = vec![Slid::default(); rows.len()];
        let top = rows.last().map_or(0.0, |row| BEYOND * row.speed);
        let (until, most_s) = match top > 0.0 {
            true => (top, MOST_S),
            false => (f64::INFINITY, WITHOUT_END_S),
        };
        let most_s = most_s.min(at_most_s);
        let mut since_s = 0.0;
        let Moving { plant, speed } = moving;
        while since_s < most_s && if is_up { *speed < until } else { *speed > 0.0 } {
            let of_row = &mut slid[nearest(rows, *speed)];
            let come = built_up(since_s, COMES_S);
            let gain = come * largest(rows, *speed, is_up) * self.period_s;
            *speed = match is_up {
                true => *speed + gain,
                false => (*speed - gain).max(0.0),
            };
            since_s += self.period_s;
            self.kinematics
                .wheel_rates(direction.scaled(*speed), &mut self.rates_rad_s);
            let before = Slid::so_far(plant.world());
            plant.advance(WheelCommand::Rates(&self.rates_rad_s), self.period_s)?;
            let after = Slid::so_far(plant.world());
            of_row.slip_j += after.slip_j - before.slip_j;
            of_row.work_j += after.work_j - before.work_j;
        }
        Ok(slid)
    }
}

/// Sets the share of statics of one row of each motion.
fn set_shares(motions: &mut [Motion<'_>], (row, is_up): (usize, bool), share: f64) {
    for motion in motions {
        motion.rows[row].limit_mut(is_up).set_share(share);
    }
}

/// The row nearest in speed.
fn nearest(rows: &[LimitRow], speed: f64) -> usize {
    let off = |row: &LimitRow| (row.speed - speed).abs();
    let mut nearest = 0;
    for (index, row) in rows.iter().enumerate() {
        if off(row) < off(&rows[nearest]) {
            nearest = index;
        }
    }
    nearest
}

/// The acceleration interpolated between rows by speed; constant beyond the last.
fn largest(rows: &[LimitRow], speed: f64, is_up: bool) -> f64 {
    let of = |row: &LimitRow| row.limit(is_up).largest;
    let after = rows.partition_point(|row| row.speed <= speed);
    match (
        after.checked_sub(1).map(|before| &rows[before]),
        rows.get(after),
    ) {
        (Some(before), Some(after)) => {
            let part = (speed - before.speed) / (after.speed - before.speed);
            of(before) + part * (of(after) - of(before))
        }
        (Some(row), None) | (None, Some(row)) => of(row),
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;

    use super::*;

    #[test]
    fn ahead_is_no_mirror_image_of_left() {
        let motion = |direction: Twist| Motion {
            direction,
            rows: &mut [],
        };
        let ahead = motion(Twist::new(1.0, 0.0, 0.0));
        assert!(ahead.has_image(&motion(Twist::new(-1.0, 0.0, 0.0))));
        assert!(!ahead.has_image(&motion(Twist::new(0.0, 1.0, 0.0))));
    }

    /// Motors and grip of all wheels are alike, so statics cannot tell the sides apart; the drag of
    /// one bearing can.
    #[test]
    fn a_robot_with_one_stiff_bearing_is_not_its_own_mirror_image() {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let text = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1.0\n";
        let scenario = Scenario::from_toml(text, "test", "").expect("a scenario");
        let even = Robot::from_urdf_str(urdf, "mecanum4").expect("a robot");
        let mut uneven = even.clone();
        uneven.wheels[0].joint.damping_n_m_s += 0.01;
        for (robot, is_expected) in [(even, true), (uneven, false)] {
            let mut limits = Limits::of(&scenario, &robot).expect("it stands");
            let mut sprinter = Sprinter::new(&scenario, &robot).expect("it is simulated");
            let (left, right) = limits.rows.split_at_mut(27);
            let motion = |rows, turning| Motion {
                direction: Twist::new(0.0, 0.0, turning),
                rows,
            };
            let (left, right) = (motion(&mut left[24..], 1.0), motion(right, -1.0));
            assert_eq!(left.rows[0].motion, "turning left");
            assert!(left.has_image(&right));
            let found = sprinter.is_mirrored(&left, &right).expect("it sprints");
            assert_eq!(found, is_expected);
        }
    }

    /// From 0.3 m/s at 2 m/s^2 the motors brake it to rest within the time of a sprint, 1 s.
    #[test]
    fn a_sprint_down_ends_at_rest() {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let text = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1.0\n";
        let scenario = Scenario::from_toml(text, "test", "").expect("a scenario");
        let robot = Robot::from_urdf_str(urdf, "mecanum4").expect("a robot");
        let mut sprinter = Sprinter::new(&scenario, &robot).expect("it is simulated");
        let rows = [LimitRow {
            speed: 0.3,
            ..LimitRow::from_rest(2.0)
        }];
        let mut moving = sprinter.at_rest();
        let mut sprint = |is_up: bool| {
            let ahead = Twist::new(1.0, 0.0, 0.0);
            let slid = sprinter.sprint(&mut moving, ahead, (&rows, is_up), f64::INFINITY);
            (moving.speed, slid.expect("it drives")[0].work_j)
        };
        let (fast, _) = sprint(true);
        let (slow, work_j) = sprint(false);
        assert!(
            fast > 0.3 && slow == 0.0 && work_j > 0.0,
            "{fast} {slow} {work_j}"
        );
    }

    /// Of 4 m/s^2 by statics three quarters are held, and of those two thirds.
    #[test]
    fn a_limit_is_its_share_of_statics() {
        let mut limit = LimitRow::from_rest(1.0).speeding_up;
        limit.by_statics = 4.0;
        limit.set_share(0.75);
        assert_eq!((limit.share_held, limit.largest), (0.75, 3.0));
        limit.lower(2.0 / 3.0);
        assert!((limit.largest - 2.0).abs() < 1e-12, "{limit:?}");
    }
}
