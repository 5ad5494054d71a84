//! The ledger: where the difference between the twist asked for and the real twist goes.
//!
//! Over any time, in the body frame,
//!
//! asked - real = guidance + compensation + belief + servo + geometry + lift-off + conflict + slip +
//! incline
//!
//! | term | is | why |
//! |---|---|---|
//! | guidance | asked - granted | saturation made a task give way |
//! | compensation | granted - believed(targets) | the command allows for the rollers' geometry; zero under eq. (7) |
//! | belief | believed(targets) - ideal(targets) + ideal(counted) - ideal(rates) | the controller takes the robot for another than it is, or its encoders count wrong; zero where it knows it |
//! | servo | ideal(targets) - ideal(counted) | by their encoders the wheels are behind their targets, or ahead of them |
//! | geometry | ideal(rates) - contact(rates) | the touching roller is tilted and stands off the wheel's middle |
//! | lift-off | contact(rates) - carried(rates) | wheels are in the air, or carry less than others |
//! | conflict | carried(rates) - settled | the rates belong to no one motion, so that wheels slide against each other |
//! | slip | settled - along | the contacts slide besides |
//! | incline | along - real | on a ramp the way along the ground is longer than its projection on the level; zero on a plane floor |
//!
//! where counted are the rates by encoders without noise, ideal is Indiveri 2009, eq. (7), believed
//! the same of the robot that the controller believes in, contact the contact kinematics, and
//! carried the same with each wheel weighted by the load that it carries. What the weighted wheels
//! leave open, as fewer than three carry, is as the robot really moves; and so is a part of all,
//! where they carry less than half of its weight. Rates q' that eq. (9) maps from no twist leave a
//! residual r = q' - M M^+ q', and each wheel with a part of r slides. As long as friction acts
//! against that slide, any motion will do: settled is the motion nearest to along, on the way to it
//! from carried, at which no wheel's slide has turned round. Along is the real motion in the
//! robot's own plane.
//!
//! Under a law without rate targets nobody asks for a twist: asked is then what the wheels do, and
//! the first four terms are zero.
//!
//! The sum telescopes, so that it equals the total to rounding, whatever the run did. A recorder
//! counts it over spans of a few physics steps ([`Ledger::count`]), by the angles that the wheels
//! turned and the way that the robot went in each, so that it does not depend on how often rows are
//! written.

use ilon_robot::{Twist, wrap_angle};
use serde::{Deserialize, Serialize};

/// One value for each term of the ledger, and for the total.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "T: Serialize + Default + PartialEq"))]
pub struct Parts<T> {
    /// Asked minus real: the sum of the other terms, except for path lengths.
    pub total: T,
    /// Lost to saturation.
    pub guidance: T,
    /// Added by the command in advance against the rollers' geometry.
    pub compensation: T,
    /// What the controller takes by believing in another robot, or in encoders that count wrong;
    /// not written where there is none of it.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub belief: T,
    /// Deviation of the wheels from their targets.
    pub servo: T,
    /// Lost to the rollers' geometry.
    pub geometry: T,
    /// Lost to wheels in the air, or with less load than others.
    #[serde(default)]
    pub lift_off: T,
    /// Lost to wheels that contradict each other.
    #[serde(default)]
    pub conflict: T,
    /// Lost to other sliding.
    pub slip: T,
    /// The way along inclined ground minus its projection on the level; not written where there
    /// is none of it.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub incline: T,
}

fn is_nothing<T: Default + PartialEq>(term: &T) -> bool {
    *term == T::default()
}

/// The number of terms.
pub const TERMS: usize = 9;

/// The names of the terms, in the order of the chain from asked to real.
pub const NAMES: [&str; TERMS] = [
    "guidance",
    "compensation",
    "belief",
    "servo",
    "geometry",
    "lift-off",
    "conflict",
    "slip",
    "incline",
];

/// The terms that most runs have not, and that these do not record.
pub const RARE: [&str; 2] = ["belief", "incline"];

/// The terms of the ledger over some time, as mean twists or displacements in the body frame.
pub type Terms = Parts<Twist>;

/// The ledger integrated over the run, each twist turned into the world frame by the true heading.
/// The total is the sum of the other terms in `x_m`, `y_m` and `heading_rad`.
pub type Ledger = Parts<Integral>;

/// The motion at each link of the chain from asked to real over a span of time, as displacements in
/// the body frame: m, m and rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chain {
    /// The commanded displacement.
    pub asked: Twist,
    /// The displacement after saturation.
    pub granted: Twist,
    /// Eq. (7) of Indiveri 2009 for the wheels' targets and the robot that the controller believes
    /// in.
    pub believed_of_targets: Twist,
    /// The same for the real robot.
    pub ideal_of_targets: Twist,
    /// What it makes of the angles that the encoders counted, without their noise.
    pub counted: Twist,
    /// The same for the angles that the wheels turned.
    pub ideal: Twist,
    /// Contact kinematics for these angles.
    pub contact: Twist,
    /// Contact kinematics with each wheel weighted by its load.
    pub carried: Twist,
    /// The motion after wheels that contradict each other have slid against each other.
    pub settled: Twist,
    /// The real displacement along the robot's own axes, which lie in the ground that it stands on.
    pub along: Twist,
    /// The real displacement, on the level.
    pub real: Twist,
}

impl Chain {
    /// The differences from link to link.
    pub fn terms(&self) -> Terms {
        Terms {
            total: self.asked - self.real,
            guidance: self.asked - self.granted,
            compensation: self.granted - self.believed_of_targets,
            belief: self.believed_of_targets - self.ideal_of_targets + (self.counted - self.ideal),
            servo: self.ideal_of_targets - self.counted,
            geometry: self.ideal - self.contact,
            lift_off: self.contact - self.carried,
            conflict: self.carried - self.settled,
            slip: self.settled - self.along,
            incline: self.along - self.real,
        }
    }
}

impl<T: Copy> Parts<T> {
    /// The total, and then the terms in the order of [`NAMES`].
    pub(crate) fn all(&self) -> [T; 1 + TERMS] {
        let mut copy = *self;
        copy.all_mut().map(|term| *term)
    }

    /// The terms without the total, in the order of [`NAMES`].
    pub fn terms(&self) -> [T; TERMS] {
        let [_, terms @ ..] = self.all();
        terms
    }

    /// The terms with their names.
    pub fn named(&self) -> [(&'static str, T); TERMS] {
        let terms = self.terms();
        std::array::from_fn(|term| (NAMES[term], terms[term]))
    }

    /// The terms with their index in [`NAMES`] and their names, without the belief if the
    /// controller knows its robot, and without the incline on a plane floor.
    pub fn shown(&self) -> impl Iterator<Item = (usize, &'static str, T)>
    where
        T: Default + PartialEq,
    {
        let terms = self.named().into_iter().enumerate();
        let is_shown =
            |term: &(usize, (&str, T))| !RARE.contains(&NAMES[term.0]) || term.1.1 != T::default();
        (terms.filter(is_shown)).map(|(place, (name, term))| (place, name, term))
    }

    /// Combines each term, and the total, with that of another ledger.
    pub fn zip<U: Copy, V: Copy + Default>(
        &self,
        other: &Parts<U>,
        of: impl Fn(T, U) -> V,
    ) -> Parts<V> {
        let mut both = Parts::default();
        let pairs = self.all().into_iter().zip(other.all());
        for (term, (ours, theirs)) in both.all_mut().into_iter().zip(pairs) {
            *term = of(ours, theirs);
        }
        both
    }
}

impl<T> Parts<T> {
    /// The total, and then the terms in the order of [`NAMES`].
    pub(crate) fn all_mut(&mut self) -> [&mut T; 1 + TERMS] {
        [
            &mut self.total,
            &mut self.guidance,
            &mut self.compensation,
            &mut self.belief,
            &mut self.servo,
            &mut self.geometry,
            &mut self.lift_off,
            &mut self.conflict,
            &mut self.slip,
            &mut self.incline,
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
    /// Net rotation, in radians.
    pub heading_rad: f64,
    /// Path length: the integral of the linear part's magnitude, in metres.
    pub path_m: f64,
    /// The integral of the yaw rate's magnitude, in radians.
    pub turned_rad: f64,
}

impl Ledger {
    /// Counts a span of time in which the heading changed between two values, in radians. The terms
    /// are turned into the world frame at the mean heading; the error is of second order in the
    /// rotation.
    pub fn count(&mut self, chain: &Chain, [before_rad, after_rad]: [f64; 2]) {
        let heading_rad = before_rad + 0.5 * wrap_angle(after_rad - before_rad);
        let (sin, cos) = libm::sincos(heading_rad);
        *self = self.zip(&chain.terms(), |sum, term| sum.plus(term, [sin, cos]));
    }

    /// What was added since an earlier state of this ledger.
    pub fn since(&self, earlier: &Self) -> Self {
        self.zip(earlier, |now, before| now.since(&before))
    }
}

impl Integral {
    /// Adds a displacement in the body frame at a heading with this sine and cosine.
    fn plus(mut self, moved: Twist, [sin, cos]: [f64; 2]) -> Self {
        self.x_m += cos * moved.vx_m_s - sin * moved.vy_m_s;
        self.y_m += sin * moved.vx_m_s + cos * moved.vy_m_s;
        self.heading_rad += moved.omega_rad_s;
        self.path_m += moved.linear_m_s().norm();
        self.turned_rad += moved.omega_rad_s.abs();
        self
    }

    fn since(&self, earlier: &Self) -> Self {
        Self {
            x_m: self.x_m - earlier.x_m,
            y_m: self.y_m - earlier.y_m,
            heading_rad: self.heading_rad - earlier.heading_rad,
            path_m: self.path_m - earlier.path_m,
            turned_rad: self.turned_rad - earlier.turned_rad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot asked for 1 m/s to the left and 1 rad/s to the right for a span: saturation leaves
    /// 0.8, the targets of a controller that takes the wheels for larger ones mean 0.75, the
    /// encoders count 0.72 of it while the wheels reach 0.7, of which the rollers' geometry leaves
    /// 0.69, wheels in the air 0.64, those that contradict each other 0.56, slip 0.53 along the
    /// ground, and the incline 0.5.
    fn falls_short(span_s: f64) -> Chain {
        let left = |v: f64| Twist::new(0.0, v * span_s, -v * span_s);
        Chain {
            asked: left(1.0),
            granted: left(0.8),
            believed_of_targets: left(0.8),
            ideal_of_targets: left(0.75),
            counted: left(0.72),
            ideal: left(0.7),
            contact: left(0.69),
            carried: left(0.64),
            settled: left(0.56),
            along: left(0.53),
            real: left(0.5),
        }
    }

    #[test]
    fn each_cause_is_booked_under_its_own_name() {
        let heading_rad = f64::atan2(0.8, 0.6);
        let mut ledger = Ledger::default();
        for _ in 0..4 {
            ledger.count(&falls_short(0.5), [heading_rad; 2]);
        }
        // 2 s; the body's left is (-0.8, 0.6) in the world.
        for (got, want) in [
            (ledger.guidance, 0.4),
            (ledger.compensation, 0.0),
            (ledger.belief, 0.14),
            (ledger.servo, 0.06),
            (ledger.geometry, 0.02),
            (ledger.lift_off, 0.1),
            (ledger.conflict, 0.16),
            (ledger.slip, 0.06),
            (ledger.incline, 0.06),
            (ledger.total, 1.0),
        ] {
            // Differences of decimals near 1: a few 1e-16 each, four of them.
            let near = |a: f64, b: f64| (a - b).abs() < 1e-14;
            assert!(near(got.x_m, -0.8 * want) && near(got.y_m, 0.6 * want));
            assert!(near(got.heading_rad, -want));
            assert!(near(got.path_m, want) && near(got.turned_rad, want));
        }
    }

    /// Over any chain the terms add up to the total, along the world's axes too.
    #[test]
    fn the_terms_add_up_to_the_total() {
        let some = |k: f64| Twist::new((1.7 * k).sin(), (2.3 * k).cos(), (3.1 * k).sin());
        let mut ledger = Ledger::default();
        for step in 0..500 {
            let k = f64::from(step);
            let chain = Chain {
                asked: some(k),
                granted: some(k + 0.1),
                believed_of_targets: some(k + 0.15),
                ideal_of_targets: some(k + 0.2),
                counted: some(k + 0.25),
                ideal: some(k + 0.3),
                contact: some(k + 0.4),
                carried: some(k + 0.5),
                settled: some(k + 0.6),
                along: some(k + 0.65),
                real: some(k + 0.7),
            };
            ledger.count(&chain, [k, k + 0.01]);
        }
        let sum = |f: fn(&Integral) -> f64| ledger.named().iter().map(|(_, i)| f(i)).sum::<f64>();
        // 500 sums of numbers below 2, each rounded by 2e-16.
        assert!((sum(|i| i.x_m) - ledger.total.x_m).abs() < 1e-12);
        assert!((sum(|i| i.y_m) - ledger.total.y_m).abs() < 1e-12);
        assert!((sum(|i| i.heading_rad) - ledger.total.heading_rad).abs() < 1e-12);
        assert!(ledger.total.path_m > 0.0);
    }
}
