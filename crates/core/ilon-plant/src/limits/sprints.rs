//! The accelerations of [`Limits`] that the simulated robot can hold.
//!
//! Statics about the middles of the wheels ignore some effects: rollers touch off these middles,
//! wheels strain one another, targets of the wheel loops come in steps. So the plant sprints in
//! each direction of the table, from rest to the top speed and back, with the accelerations of the
//! table. If it slides, the table is lowered, and it sprints again.

use ilon_control::Kinematics;
use ilon_robot::{Robot, Twist};
use ilon_world::World;

use crate::limits::share::{Drive, ShareSearch};
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
        for (rows, (_, eighths, turning)) in rows_of.zip(MOTIONS) {
            sprinter.lower(direction(eighths, turning), rows)?;
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

    /// Sets the share to try next after one at which so much slid, or the one that was found; says whether it is another one.
    fn learn(&mut self, slid: f64, search: &mut ShareSearch) -> bool {
        let share = self.share_held;
        search.learn(Drive {
            share,
            slid,
            // It speeds up in inverse proportion.
            takes_s: 1.0 / share,
        });
        let next = search.next().or(search.found().map(|found| found.share));
        self.set_share(next.unwrap_or(share));
        self.share_held != share
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

    /// Lowers the rows of a motion until the robot holds them: speeding up, and slowing down from
    /// the speed reached.
    fn lower(&mut self, direction: Twist, rows: &mut [LimitRow]) -> Result<(), Error> {
        let at_rest = Moving {
            plant: self.standing.clone(),
            speed: 0.0,
        };
        let fast = self.lower_one_way(direction, rows, (&at_rest, true))?;
        // From rest it slows down like it speeds up the other way.
        if fast.speed > 0.0 && rows.last().is_some_and(|row| row.speed > 0.0) {
            self.lower_one_way(direction, rows, (&fast, false))?;
        }
        Ok(())
    }

    /// Lowers the limits of speeding up, or of slowing down from a speed, until the robot holds
    /// them. Returns its motion afterwards.
    fn lower_one_way(
        &mut self,
        direction: Twist,
        rows: &mut [LimitRow],
        (from, is_up): (&Moving, bool),
    ) -> Result<Moving, Error> {
        const MOST_SPRINTS: usize = 16;
        /// What slides at a smaller share does not slide for the acceleration.
        const LEAST: f64 = 0.3;
        let mut searches = vec![ShareSearch::new(1.0, LEAST); rows.len()];
        let mut moving = from.clone();
        for _ in 0..MOST_SPRINTS {
            moving.clone_from(from);
            let slid = self.sprint(&mut moving, direction, (rows, is_up))?;
            let mut again = false;
            for ((row, slid), search) in rows.iter_mut().zip(slid).zip(&mut searches) {
                again |= row.limit_mut(is_up).learn(slid.share(), search);
            }
            if !again {
                break;
            }
        }
        for (row, search) in rows.iter_mut().zip(&searches) {
            if let Some(found) = search.found() {
                row.limit_mut(is_up).set_share(found.share);
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
            self.lower(Twist::new(side(0), side(1), side(2)), &mut rows)?;
            held = rows[0].speeding_up.largest;
        }
        Ok(held)
    }

    /// Speeds up along a direction with the rows' accelerations, to beyond the speed of the last,
    /// or slows down to rest; returns the sliding at each row.
    fn sprint(
        &mut self,
        moving: &mut Moving,
        direction: Twist,
        (rows, is_up): (&[LimitRow], bool),
    ) -> Result<Vec<Slid>, Error> {
        /// Relative to the fastest row's speed, which is 0.9 of the top speed. Chosen.
        const BEYOND: f64 = 1.05;
        let mut slid = vec![Slid::default(); rows.len()];
        let top = rows.last().map_or(0.0, |row| BEYOND * row.speed);
        let (until, most_s) = match top > 0.0 {
            true => (top, MOST_S),
            false => (f64::INFINITY, WITHOUT_END_S),
        };
        let mut since_s = 0.0;
        let Moving { plant, speed } = moving;
        while since_s < most_s && if is_up { *speed < until } else { *speed > 0.0 } {
            let of_row = &mut slid[nearest(rows, *speed)];
            let u = (since_s / COMES_S).min(1.0);
            let gain = u * u * (3.0 - 2.0 * u) * largest(rows, *speed, is_up) * self.period_s;
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
