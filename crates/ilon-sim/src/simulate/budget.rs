//! The error budget of a run as it grows: where the motion asked for went.

use ilon_control::{ContactKinematics, Kinematics};
use ilon_robot::{Pose, Twist, wrap_angle};
use ilon_trace::Ledger;
use ilon_trace::ledger::Chain;
use ilon_world::World;

/// A span ends once it is this long, in seconds, or where a decision changes. The touching rollers are taken as they are in its middle, which
/// is of second order in what the wheels turn in it: at 20 rad/s a tenth of a radian, which leaves 4e-4 of what the rollers' geometry takes.
const SPAN_S: f64 = 5e-3;

/// A sum of steps may miss the span by rounding.
const SLACK: f64 = 1e-6;

/// Counts the [`Ledger`] over spans of a few physics steps, however often rows are written.
pub(super) struct Budget {
    ledger: Ledger,
    /// Twists in the body frame that hold until the next decision.
    asked: Twist,
    granted: Twist,
    ideal_of_targets: Twist,
    /// How long the span that is not counted yet has lasted, in seconds, and where the robot and its wheels were as it began.
    lasted_s: f64,
    pose: Pose,
    angles_rad: Vec<f64>,
    turned_rad: Vec<f64>,
    middle_rad: Vec<f64>,
}

impl Budget {
    /// For a robot that begins at a pose with all wheel angles zero.
    pub fn new(start: Pose, wheels: usize) -> Self {
        Self {
            ledger: Ledger::default(),
            asked: Twist::default(),
            granted: Twist::default(),
            ideal_of_targets: Twist::default(),
            lasted_s: 0.0,
            pose: start,
            angles_rad: vec![0.0; wheels],
            turned_rad: vec![0.0; wheels],
            middle_rad: vec![0.0; wheels],
        }
    }

    /// What has been counted up to the last decision or end of a span.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Sets the twists that hold from now on, in the body frame: asked for, granted, and that of the wheels' targets by eq. (7).
    pub fn decide(&mut self, [asked, granted, ideal_of_targets]: [Twist; 3]) {
        (self.asked, self.granted) = (asked, granted);
        self.ideal_of_targets = ideal_of_targets;
    }

    /// Counts a physics step that was taken.
    pub fn count(
        &mut self,
        world: &World,
        dt_s: f64,
        kinematics: (&Kinematics, &mut ContactKinematics),
    ) {
        self.lasted_s += dt_s;
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
        let pose = world.robot().state().pose;
        let before = std::mem::replace(&mut self.pose, pose);
        let turned_rad = wrap_angle(pose.heading_rad - before.heading_rad);
        let moved = Twist::new(pose.x_m - before.x_m, pose.y_m - before.y_m, turned_rad);
        let chain = Chain {
            asked: self.asked.scaled(span_s),
            granted: self.granted.scaled(span_s),
            ideal_of_targets: self.ideal_of_targets.scaled(span_s),
            ideal: kinematics.twist(&self.turned_rad),
            contact: contact.twist(&self.middle_rad, &self.turned_rad),
            real: moved.rotated(-(before.heading_rad + 0.5 * turned_rad)),
        };
        self.ledger
            .count(&chain, [before.heading_rad, pose.heading_rad]);
    }
}
