//! The native shape of other simulators that is nearest to a roller as made.
//!
//! On level ground only the support of a roller counts: how far it reaches in the direction of the
//! ground, as a function of the direction's component w along its axis. A roller serves the angles
//! phi from straight down to half of the way to its neighbours, and the wheel's hub stands at a
//! cos(phi) plus that support. A shape is fitted so that the largest error of the support over
//! these angles is the least, which is the largest error of the hub's height; further out the shape
//! must end where the wheel rests on the neighbours.

use std::f64::consts::{PI, TAU};

use nalgebra::{Rotation3, Vector3};

use super::frame::Format;
use super::shape::{RollerShape, at};
use crate::model::{
    CollisionShape, ModelledRoller, Robot, Roller, RollerForm, SolidOfRevolution, Wheel,
};

/// A robot whose rollers have shapes of another simulator.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FittedRobot {
    /// The robot with the outlines of the shapes in place of the rollers' own, so that its
    /// kinematics are those of the shapes.
    pub robot: Robot,
    /// Height of the body frame's origin above the ground when the robot stands level, in metres.
    pub ride_height_m: f64,
    /// The shape of each roller of each wheel.
    pub shapes: Vec<Vec<RollerShape>>,
    /// The largest error of a hub's height on level ground over a turn of its wheel, in metres.
    pub error_m: f64,
    /// The largest travel of a hub over a turn of its wheel, with these shapes, in metres.
    pub travel_m: f64,
    /// The same of the rollers as made, in metres.
    pub travel_as_made_m: f64,
}

/// An error of this share of the wheel's radius is small enough for one native shape: as much again
/// is off in speed, which shall stay below 0.1 % together with the simulator's own errors. Of
/// spheres more are taken until the second is reached.
const ENOUGH: f64 = 9e-4;
const OF_SPHERES: f64 = 2e-4;
/// Beyond the hand-over a shape must stay below what carries the wheel there, by this share of the
/// wheel's radius per radian and at most by so much of it. The end spheres of barrels that touch
/// each other lie in one place: as long as both carry, they slip against each other.
const CLEAR_PER_RAD: f64 = 0.03;
const CLEAR: f64 = 2e-3;
/// Angles at which supports are compared.
const LOOKS: usize = 60;

/// A shape by two figures, in metres.
struct Native {
    /// How far it reaches, by the component of the direction along its axis.
    support_m: fn([f64; 2], f64) -> f64,
    made: fn([f64; 2]) -> RollerShape,
}

const NATIVE: [Native; 3] = [
    Native {
        support_m: |[p, q], w| (p * p * (1.0 - w * w) + q * q * w * w).sqrt(),
        made: |[radius_m, half_length_m]| RollerShape::Ellipsoids {
            radius_m,
            half_length_m,
            at_m: vec![0.0],
        },
    },
    Native {
        support_m: |[p, q], w| p + q * w.abs(),
        made: |[radius_m, half_m]| {
            let length_m = 2.0 * half_m;
            RollerShape::of(CollisionShape::Capsule { radius_m, length_m })
        },
    },
    Native {
        support_m: |[p, q], w| p * (1.0 - w * w).sqrt() + q * w.abs(),
        made: |[radius_m, half_m]| {
            let length_m = 2.0 * half_m;
            RollerShape::of(CollisionShape::Cylinder { radius_m, length_m })
        },
    },
];

/// Gives each roller of a robot the nearest shape that a format has.
pub fn fit(robot: &Robot, format: Format) -> FittedRobot {
    let mut fitted = robot.clone();
    let mut shapes = Vec::new();
    let (mut error_m, mut travel_m, mut travel_as_made_m) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (wheel, next) in robot.wheels.iter().zip(&mut fitted.wheels) {
        // Equal rollers get equal shapes, and are fitted once.
        let mut known: Vec<(RollerForm, [f64; 3], RollerShape)> = Vec::new();
        let mut of_wheel = Vec::new();
        for (index, roller) in wheel.rollers.iter().enumerate() {
            if let Some(tyre) = super::tyres::shape(roller, format) {
                of_wheel.push(tyre);
                continue;
            }
            let target = Target::new(wheel, index);
            let figures = [target.tallest_m(), roller.length_m, roller.ring_radius_m()];
            let same = |was: &&(RollerForm, [f64; 3], RollerShape)| {
                let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
                was.0 == roller.form && was.1.iter().zip(&figures).all(near)
            };
            let shape = match known.iter().find(same) {
                Some((_, _, shape)) => shape.clone(),
                None => target.nearest(format),
            };
            if let Some(profile) = shape.profile().filter(|_| !target.is_modelled()) {
                let shapes = Vec::new();
                next.rollers[index].form =
                    RollerForm::AsModelled(ModelledRoller { shapes, profile });
            }
            known.push((roller.form.clone(), figures, shape.clone()));
            of_wheel.push(shape);
        }
        shapes.push(of_wheel);
        let (made, shown) = (heights_m(wheel), heights_m(next));
        let off = made.iter().zip(&shown).map(|(a, b)| (a - b).abs());
        error_m = error_m.max(off.fold(0.0, f64::max));
        travel_m = travel_m.max(span(&shown));
        travel_as_made_m = travel_as_made_m.max(span(&made));
    }
    FittedRobot {
        robot: fitted,
        ride_height_m: robot.ride_height_m(),
        shapes,
        error_m,
        travel_m,
        travel_as_made_m,
    }
}

/// Heights of a wheel's hub on level ground over a turn, in metres.
fn heights_m(wheel: &Wheel) -> Vec<f64> {
    let looks = LOOKS * wheel.rollers.len();
    let reaches: Vec<_> = wheel.rollers.iter().map(|r| reach(wheel, r)).collect();
    let look = |i| {
        let (sin, cos) = libm::sincos(TAU * i as f64 / looks as f64);
        height_m(wheel, &reaches, &Vector3::new(cos, sin, 0.0))
    };
    (0..looks).map(look).collect()
}

/// Height of a wheel's hub above ground that lies in a direction, in metres.
fn height_m(wheel: &Wheel, reaches: &[Reach<'_>], down: &Vector3<f64>) -> f64 {
    let rollers = wheel.rollers.iter().zip(reaches);
    let heights = rollers.map(|(roller, reach)| {
        roller.center_in_hub_m.dot(down) + reach(roller.axis_in_hub.dot(down))
    });
    heights.fold(f64::NEG_INFINITY, f64::max)
}

fn span(heights_m: &[f64]) -> f64 {
    let most = heights_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most - heights_m.iter().copied().fold(f64::INFINITY, f64::min)
}

/// How far a roller reaches, in metres.
type Reach<'a> = Box<dyn Fn(f64) -> f64 + 'a>;

/// How far a roller reaches from its middle, by the component of the direction along its axis.
fn reach<'a>(wheel: &Wheel, roller: &'a Roller) -> Reach<'a> {
    match &roller.form {
        RollerForm::Turned(turned) | RollerForm::Tyre(turned) => {
            Box::new(|w| turned.profile().support_m(w))
        }
        RollerForm::AsModelled(modelled) => Box::new(|w| modelled.profile.support_m(w)),
        RollerForm::Barrel | RollerForm::Made(_) => {
            let barrel = wheel.barrel(roller);
            Box::new(move |w| {
                let t_m = barrel.support_place_m(w);
                t_m * w + barrel.sphere_radius_m(t_m)
            })
        }
    }
}

/// A roller, and the directions in which it meets the ground.
struct Target<'a> {
    wheel: &'a Wheel,
    roller: &'a Roller,
    supports: Vec<Support>,
}

/// How far a roller reaches in a direction.
struct Support {
    /// The direction's component along the roller's axis.
    w: f64,
    /// The reach, in metres; where a neighbour carries the wheel, what the roller must not exceed.
    reach_m: f64,
    is_served: bool,
}

impl<'a> Target<'a> {
    fn new(wheel: &'a Wheel, index: usize) -> Self {
        let roller = &wheel.rollers[index];
        let count = wheel.rollers.len();
        let half_way = |next: usize| {
            let apart = wheel.rollers[next].place_rad() - roller.place_rad();
            0.5 * crate::model::wrap_angle(apart).abs().min(PI / 1.5)
        };
        let [after, before] = [index + 1, index + count - 1].map(|next| half_way(next % count));
        let reaches: Vec<_> = wheel.rollers.iter().map(|r| reach(wheel, r)).collect();
        let outward = roller.center_in_hub_m.xy().normalize();
        let outward = Vector3::new(outward.x, outward.y, 0.0);
        let supports = (0..2 * LOOKS).map(|i| {
            // From twice as far before as the roller serves to twice as far after.
            let share = 2.0 * (i as f64 + 0.5) / LOOKS as f64 - 2.0;
            let phi = if share < 0.0 { before } else { after } * share;
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), phi);
            let down = turn * outward;
            let w = roller.axis_in_hub.dot(&down);
            let is_served = share.abs() <= 1.0;
            let reach_m = if is_served {
                reaches[index](w)
            } else {
                let beyond_rad = phi.abs() * (1.0 - 1.0 / share.abs());
                let clear_m = wheel.radius_m * (CLEAR_PER_RAD * beyond_rad).min(CLEAR);
                height_m(wheel, &reaches, &down) - clear_m - roller.center_in_hub_m.dot(&down)
            };
            Support {
                w,
                reach_m,
                is_served,
            }
        });
        Self {
            wheel,
            roller,
            supports: supports.collect(),
        }
    }

    /// The directions in which the roller carries the wheel.
    fn served(&self) -> impl Iterator<Item = &Support> {
        self.supports.iter().filter(|of| of.is_served)
    }

    fn is_modelled(&self) -> bool {
        matches!(self.roller.form, RollerForm::AsModelled(_))
    }

    fn tallest_m(&self) -> f64 {
        self.served().map(|of| of.w.abs()).fold(0.0, f64::max)
    }

    /// How far supports fall short and reach too far at most, in metres: the least and the largest
    /// error.
    fn errors_m(&self, support_m: impl Fn(f64) -> f64) -> [f64; 2] {
        self.supports.iter().fold([0.0_f64; 2], |[low, high], of| {
            let off_m = support_m(of.w) - of.reach_m;
            let low = if of.is_served { low.min(off_m) } else { low };
            [low, high.max(off_m)]
        })
    }

    /// The largest error of a support, in metres.
    fn error_m(&self, support_m: impl Fn(f64) -> f64) -> f64 {
        let [low_m, high_m] = self.errors_m(support_m);
        high_m.max(-low_m)
    }

    /// The simplest shape that is near enough, or the nearest.
    fn nearest(&self, format: Format) -> RollerShape {
        if let RollerForm::AsModelled(modelled) = &self.roller.form {
            return RollerShape::Solids(modelled.shapes.clone());
        }
        let is_turned = matches!(self.roller.form, RollerForm::Turned(_));
        // URDF has neither ellipsoids nor capsules. Meshes have flat sides, and each costs a
        // rolling roller energy: in MuJoCo 64 of them take 8 % of the speed sideways.
        let native = match (format, is_turned) {
            (Format::Urdf, false) => &[],
            (Format::Urdf, true) => &NATIVE[2..],
            (_, false) => &NATIVE[..2],
            (_, true) => &NATIVE[..],
        };
        let of_many = || self.spheres(OF_SPHERES * self.wheel.radius_m);
        let of_one = native
            .iter()
            .map(|of| (of.made)(self.two_figures(of.support_m)));
        let mut best = (f64::INFINITY, None);
        for shape in of_one.chain(std::iter::once_with(of_many)) {
            let profile = shape.profile();
            let error_m = profile.map_or(f64::INFINITY, |of| self.error_m(|w| of.support_m(w)));
            if error_m < best.0 {
                best = (error_m, Some(shape));
            }
            if error_m < ENOUGH * self.wheel.radius_m {
                break;
            }
        }
        best.1.unwrap_or_else(of_many)
    }

    /// The two figures of a shape, in metres, by which the largest error of its support is the
    /// least: the first is searched for each value of the second.
    fn two_figures(&self, support_m: impl Fn([f64; 2], f64) -> f64) -> [f64; 2] {
        let thick_m = self.served().map(|of| of.reach_m).fold(0.0, f64::max);
        let most_m = 2.0 * self.roller.length_m + thick_m;
        let first = |q: f64| least(thick_m, |p| self.error_m(|w| support_m([p, q], w)));
        let (second, _) = least(most_m, |q| first(q).1);
        [first(second).0, second]
    }

    /// Spheres along the axis: the fewest that are near enough, or of which more are hardly nearer.
    /// The outermost stand at the roller's ends or a little before, so that neighbours hand over;
    /// all are grown so that they reach too far by as much as they fall short.
    fn spheres(&self, enough_m: f64) -> RollerShape {
        const MOST: usize = 25;
        const WORTH: f64 = 0.8;
        let tallest = self.tallest_m();
        let stack = |count: usize, share: f64, grown_m: f64| {
            let sphere = |i: usize| {
                let along = share * (2.0 * i as f64 / (count - 1) as f64 - 1.0);
                let (t_m, radius_m) = match &self.roller.form {
                    RollerForm::Turned(turned) => sphere_within(turned, along * tallest),
                    _ => {
                        let barrel = self.wheel.barrel(self.roller);
                        let t_m = along * barrel.half_length_m;
                        (t_m, barrel.sphere_radius_m(t_m))
                    }
                };
                let radius_m = radius_m + grown_m;
                at(t_m, CollisionShape::Sphere { radius_m })
            };
            RollerShape::Solids((0..count).map(sphere).collect())
        };
        let mut best = (f64::INFINITY, stack(3, 1.0, 0.0));
        for count in (5..=MOST).step_by(2) {
            let fitted = [1.0, 0.98, 0.96, 0.94, 0.92].map(|share| {
                let Some(profile) = stack(count, share, 0.0).profile() else {
                    return (f64::INFINITY, share, 0.0);
                };
                let [low_m, high_m] = self.errors_m(|w| profile.support_m(w));
                (0.5 * (high_m - low_m), share, -0.5 * (high_m + low_m))
            });
            let nearest = fitted.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((error_m, share, grown_m)) = nearest.filter(|(e, ..)| *e < WORTH * best.0)
            else {
                break;
            };
            best = (error_m, stack(count, share, grown_m));
            if error_m < enough_m {
                break;
            }
        }
        best.1
    }
}

/// Place and radius, in metres, of the sphere on a solid's axis that touches it where it reaches
/// furthest in a direction: the tangent of its support over the direction's component w.
fn sphere_within(turned: &SolidOfRevolution, w: f64) -> (f64, f64) {
    let (part, _) = turned.profile().furthest(w);
    let t_m = part.t_m - part.ring_m * w / (1.0 - w * w).sqrt();
    (t_m, turned.profile().support_m(w) - t_m * w)
}

/// Where a function with one minimum between 0 and an end has it, and its value there: of the
/// thirds of a range the one beside the larger value is left out.
fn least(end: f64, of: impl Fn(f64) -> f64) -> (f64, f64) {
    /// They leave 1e-7 of the range.
    const SECTIONS: usize = 40;
    let (mut low, mut high) = (0.0, end);
    for _ in 0..SECTIONS {
        let third = (high - low) / 3.0;
        match of(low + third) <= of(high - third) {
            true => high -= third,
            false => low += third,
        }
    }
    let x = 0.5 * (low + high);
    (x, of(x))
}
