//! The error budget of a run, accumulated: the commanded motion minus the real one, by causes.

use ilon_control::{ContactKinematics, Kinematics};
use ilon_robot::{Pose, Twist, Wheel, wrap_angle};
use ilon_trace::Ledger;
use ilon_trace::ledger::Chain;
use ilon_world::{BodyState, World};
use nalgebra::Vector3;

use crate::pilot::contradiction::{Contradiction, Sizes};

/// A span ends after this time, in seconds, or when a decision changes. The touching rollers are
/// those in its middle, an error of second order in the wheels' rotation: at 20 rad/s a tenth of a
/// radian, which leaves 4e-4 of the geometry term. Chosen.
const SPAN_S: f64 = 5e-3;

/// A sum of steps may miss the span by rounding.
const SLACK: f64 = 1e-6;

/// Counts the [`Ledger`] over spans of a few physics steps, independent of the rows.
pub(crate) struct Budget {
    ledger: Ledger,
    weight_n: f64,
    /// The height and attitude of the robot at the start of the current span, where the ground is
    /// uneven; `None` before the first span, in which the robot rests.
    stood: Option<BodyState>,
    is_uneven: bool,
    /// Twists in the body frame that hold until the next decision: asked for, granted, and those of
    /// the wheels' targets, as the controller believes and as they are; `None` if there are no rate
    /// targets.
    decided: Option<[Twist; 4]>,
    /// The twist by the joints of active casters, in the body frame.
    by_casters: Twist,
    /// The rates at which joints roll wheels of pairs, in rad/s; empty without joints.
    along_rad_s: Vec<f64>,
    /// When and how the rates of the wheels contradicted each other.
    contradiction: Contradiction,
    /// The inconsistent part of the rates since the last row.
    conflict: Sizes,
    /// The load of each wheel in the span, in N s.
    loads_n_s: Vec<f64>,
    /// The time for which any wheel touched the ground in it, in seconds.
    touched_s: f64,
    /// The start of the current span, in seconds since the start of the run.
    begun_s: f64,
    /// The length of the current span so far, in seconds, and the pose of the robot and the angles
    /// of its wheels at its start.
    lasted_s: f64,
    pose: Pose,
    angles_rad: Vec<f64>,
    turned_rad: Vec<f64>,
    /// What each wheel's encoder counts over what it should.
    encoder_scales: Vec<f64>,
    middle_rad: Vec<f64>,
    rates_rad_s: Vec<f64>,
}

impl Budget {
    /// For a robot of a weight in N that begins at a pose with all wheel angles zero; `is_uneven`
    /// says whether it may stand on anything but the plane of the floor.
    pub fn new(start: Pose, wheels: usize, weight_n: f64, is_uneven: bool) -> Self {
        Self {
            weight_n,
            stood: None,
            is_uneven,
            ledger: Ledger::default(),
            decided: Some([Twist::default(); 4]),
            by_casters: Twist::default(),
            along_rad_s: Vec::new(),
            contradiction: Contradiction::new(wheels),
            conflict: Sizes::default(),
            loads_n_s: vec![0.0; wheels],
            touched_s: 0.0,
            begun_s: 0.0,
            lasted_s: 0.0,
            pose: start,
            angles_rad: vec![0.0; wheels],
            turned_rad: vec![0.0; wheels],
            encoder_scales: vec![1.0; wheels],
            middle_rad: vec![0.0; wheels],
            rates_rad_s: vec![0.0; wheels],
        }
    }

    /// The ledger up to the last decision or end of a span.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// When and how the rates of the wheels contradicted each other.
    pub fn contradiction(&self) -> &Contradiction {
        &self.contradiction
    }

    /// The inconsistent share of the wheels' rates since the last call: `|r| / |q'|`, root mean
    /// squares over time.
    pub fn take_conflict_share(&mut self) -> f64 {
        std::mem::take(&mut self.conflict).share()
    }

    /// Sets the twists that hold from now on, in the body frame: asked for, granted, and those
    /// of the wheels' targets by eq. (7), of the robot that the controller believes in and of
    /// the real one; `None` if the wheels have no rate targets. Then the twist by the joints of
    /// active casters, and the rates at which joints roll the wheels of pairs. `scales` is by
    /// how much each wheel's encoder counts wrong: what it counts over what it should.
    pub fn decide(
        &mut self,
        decided: Option<[Twist; 4]>,
        (by_casters, along_rad_s): (Twist, impl Iterator<Item = f64>),
        scales: impl Iterator<Item = f64>,
    ) {
        self.decided = decided;
        self.by_casters = by_casters;
        self.along_rad_s.clear();
        self.along_rad_s.extend(along_rad_s);
        self.encoder_scales.clear();
        self.encoder_scales.extend(scales);
    }

    /// Counts a physics step that was taken.
    pub fn count(
        &mut self,
        world: &World,
        dt_s: f64,
        kinematics: (&Kinematics, &mut ContactKinematics),
    ) {
        self.lasted_s += dt_s;
        let mut touching: f64 = 0.0;
        for (load, tally) in self.loads_n_s.iter_mut().zip(world.robot().wheel_tallies()) {
            *load += tally.normal_force_mean_n() * dt_s;
            touching += tally.touching_share();
        }
        self.touched_s += touching.min(1.0) * dt_s;
        if self.lasted_s >= SPAN_S * (1.0 - SLACK) {
            self.end_span(world, kinematics);
        }
    }

    /// Ends the span here, if one has begun.
    pub fn end_span(
        &mut self,
        world: &World,
        (kinematics, contact): (&Kinematics, &mut ContactKinematics),
    ) {
        if self.lasted_s <= 0.0 {
            return;
        }
        let span_s = std::mem::take(&mut self.lasted_s);
        let wheels = self.turned_rad.iter_mut().zip(&mut self.middle_rad);
        let angles = self.angles_rad.iter_mut();
        for (((turned, middle), before), now) in
            wheels.zip(angles).zip(world.robot().wheel_angles_rad())
        {
            *turned = now - *before;
            *middle = now - 0.5 * *turned;
            *before = *now;
        }
        let state = world.robot().state();
        let pose = state.pose;
        let before = std::mem::replace(&mut self.pose, pose);
        let turned_rad = wrap_angle(pose.heading_rad - before.heading_rad);
        let moved = Twist::new(pose.x_m - before.x_m, pose.y_m - before.y_m, turned_rad);
        let real = moved.rotated(-(before.heading_rad + 0.5 * turned_rad));
        let stood = self.stood.replace(state).filter(|_| self.is_uneven);
        let along = stood.map_or(real, |stood| along(&stood, &state));
        let by_casters = self.by_casters.scaled(span_s);
        let ideal = kinematics.twist(&self.turned_rad) + by_casters;
        let of_contacts = contact.twist(&self.middle_rad, &self.turned_rad) + by_casters;
        let by_wheels = along - by_casters;
        let carried = contact.twist_by_load_here(&self.turned_rad, &self.loads_n_s, by_wheels);
        let carried = carried + by_casters;
        let carried = along + (carried - along).scaled(self.hold(span_s));
        let all_carry = self.loads_n_s.iter().all(|load| *load > 0.0);
        self.loads_n_s.fill(0.0);
        let settled = self.settled(kinematics, (span_s, all_carry), [carried, along]);
        let decided = self
            .decided
            .map(|twists| twists.map(|twist| twist.scaled(span_s)));
        let counted =
            match decided.is_some() && self.encoder_scales.iter().any(|scale| *scale != 1.0) {
                true => kinematics.twist(&self.counted_rad()) + by_casters,
                false => ideal,
            };
        let [asked, granted, believed_of_targets, ideal_of_targets] = decided.unwrap_or([ideal; 4]);
        let chain = Chain {
            asked,
            granted,
            believed_of_targets,
            ideal_of_targets,
            counted,
            ideal,
            contact: of_contacts,
            carried,
            settled,
            along,
            real,
        };
        self.ledger
            .count(&chain, [before.heading_rad, pose.heading_rad]);
    }

    /// The angles that the wheels turned in a span, as their encoders count them, in rad.
    fn counted_rad(&self) -> Vec<f64> {
        let turned = self.turned_rad.iter().zip(&self.encoder_scales);
        turned.map(|(turned, scale)| turned * scale).collect()
    }

    /// The wheels' hold on the robot, in [0, 1]: the share of the span in which any of them
    /// touches, and 1 from half of the robot's weight on, so that neither a slope nor vibration
    /// reduces it. For the rest of the span the robot flies freely.
    fn hold(&mut self, span_s: f64) -> f64 {
        let load_n_s: f64 = self.loads_n_s.iter().sum();
        let whole_n_s = 0.5 * self.weight_n * span_s;
        let by_load = match load_n_s < whole_n_s {
            true => load_n_s / whole_n_s,
            false => 1.0,
        };
        // A sum of steps may miss the span by rounding.
        let touched = std::mem::take(&mut self.touched_s) / span_s;
        match touched < 1.0 - SLACK {
            true => by_load.min(touched),
            false => by_load,
        }
    }

    /// The motion, on the way from `carried` to `along`, that the robot takes as wheels with
    /// inconsistent rates allow: as long as each wheel slides in the sense of its part of r.
    ///
    /// A wheel's slide along its roller's axis is in the sense of s = r + a g, with g the change of
    /// its rolling rate by eq. (9) over the whole way and a the share of it. Because r is
    /// perpendicular to the rates of all motions, some wheel ends it; without r it ends at once.
    fn settled(
        &mut self,
        kinematics: &Kinematics,
        (span_s, all_carry): (f64, bool),
        [carried, along]: [Twist; 2],
    ) -> Twist {
        let wheels = self.turned_rad.iter().zip(&mut self.rates_rad_s);
        for (wheel, (turned, rate)) in wheels.enumerate() {
            *rate = match kinematics.swivels(wheel) {
                true => 0.0,
                false => turned / span_s + self.along_rad_s.get(wheel).copied().unwrap_or(0.0),
            };
        }
        let begun_s = self.begun_s;
        self.begun_s += span_s;
        let sizes = self.contradiction.of(kinematics, &self.rates_rad_s);
        if all_carry {
            let when_s = [begun_s, span_s];
            (self.contradiction).add(kinematics, &self.rates_rad_s, sizes, when_s);
        }
        self.conflict.of_no_motion += sizes.of_no_motion * span_s;
        self.conflict.of_all += sizes.of_all * span_s;
        let off = (carried - along).scaled(1.0 / span_s);
        kinematics.wheel_rates(off, &mut self.rates_rad_s);
        let largest = |rates: &[f64]| {
            rates
                .iter()
                .fold(0.0, |most: f64, rate| most.max(rate.abs()))
        };
        // What tyres hold may keep r from ending it: it explains no more than its own size.
        let mut part = match kinematics.wheels().iter().any(Wheel::has_tyre) {
            true => largest(self.contradiction.residual()) / largest(&self.rates_rad_s),
            false => 1.0_f64,
        };
        part = part.min(1.0);
        for (residual, change) in self.contradiction.residual().iter().zip(&self.rates_rad_s) {
            if residual * change <= 0.0 && *change != 0.0 {
                part = part.min((residual / change).abs());
            }
        }
        carried - off.scaled(part * span_s)
    }
}

/// The displacement from one state to a later one along the robot's own axes, at the mean of both
/// attitudes: the error is of second order in the rotation between them.
fn along(before: &BodyState, after: &BodyState) -> Twist {
    let moved_m = Vector3::new(
        after.pose.x_m - before.pose.x_m,
        after.pose.y_m - before.pose.y_m,
        after.height_m - before.height_m,
    );
    let [from, to] = [before, after].map(|state| state.world_from_body);
    let in_body_m = 0.5 * (from.inverse() * moved_m + to.inverse() * moved_m);
    let turned_rad = (from.inverse() * to).scaled_axis();
    Twist::new(in_body_m.x, in_body_m.y, turned_rad.z)
}
