//! The outline of a wheel's collision geometry, on which simulators without barrels roll.
//!
//! The wheel rolls on the convex hull of its rollers: the hub's height is the hull's support h(phi)
//! in the direction phi that points down. Between two rollers the hull is a straight bridge, over
//! which the wheel tips from one to the next; only there the outline leaves the rollers.

use std::f64::consts::TAU;

use nalgebra::{Unit, Vector2, Vector3};
use serde::Serialize;

use super::geometry::directions;
use super::roller_gaps::Handover;
use crate::model::{Profile, Remark};
use crate::options::RollerForms;

/// Directions in which the hull is sampled: a tenth of a degree apart.
const SAMPLES: usize = 3600;
/// Directions in which the outline of a single roller is sampled: a degree apart, which for an arc
/// of radius r loses r (1 - cos 0.5 deg) = 4e-5 r.
const ROLLER_SAMPLES: usize = 360;
/// Rollers whose reaches differ by less than this share of the wheel's radius touch the ground
/// together: files hold rounded numbers.
const AS_ONE: f64 = 1e-5;

/// A wheel's outline by its collision geometry on flat ground, compared with the fitted barrels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WheelOutline {
    /// The wheel's joint.
    pub wheel: String,
    /// The radius rho of the fitted wheel, in metres.
    pub fitted_radius_m: f64,
    /// The mean distance of the outline from the hub axis, seen along it, over the directions with
    /// a roller, in metres.
    pub mean_radius_m: f64,
    /// The mean height of the hub over the ground in a turn, in metres: 2 pi times it is the
    /// perimeter of the convex hull, the distance of a turn.
    pub rolling_radius_m: f64,
    /// The greatest height of the hub over the ground, in metres.
    pub peak_radius_m: f64,
    /// The largest deviation of the hub's height from the fitted radius, in metres.
    pub outline_error_m: f64,
    /// Peak-to-peak motion of the hub in a turn, in metres.
    pub ripple_m: f64,
    /// Share of a turn, seen from the hub, that lies on bridges between rollers, in [0, 1].
    pub gap_share: f64,
    /// The largest depth of the rollers' own outline below these bridges, seen from the hub, in
    /// metres; the bridge's whole distance from the hub axis where no roller is below it.
    pub gap_depth_m: f64,
    /// Share of a turn with two fitted rollers on the ground, in [0, 1].
    pub overlap_share: f64,
    /// The largest penetration of two neighbouring rollers, in metres; 0 if none.
    pub overlap_depth_m: f64,
}

impl WheelOutline {
    /// Adds a remark if the geometry rolls differently from the fitted wheel by more than one
    /// percent.
    pub(super) fn remark_rolling(&self, form: RollerForms, remarks: &mut Vec<Remark>) {
        let off_m = (self.rolling_radius_m - self.fitted_radius_m).abs();
        if off_m.max(self.ripple_m) > 0.01 * self.fitted_radius_m {
            let taken = match form {
                RollerForms::Barrel => "it is taken as a wheel with barrels for rollers of",
                RollerForms::AsModelled => "it rolls so, and the control takes it for a wheel of",
            };
            remarks.push(Remark::new(
                format!("wheel `{}`", self.wheel),
                format!(
                    "its collision geometry rolls on a radius of {:.2} mm and rises and falls by {:.2} mm a turn; {taken} \
                     {:.2} mm",
                    1e3 * self.rolling_radius_m,
                    1e3 * self.ripple_m,
                    1e3 * self.fitted_radius_m
                ),
            ));
        }
    }
}

/// A roller of a wheel, in the hub frame.
pub(super) struct Modelled {
    pub(super) foot_in_hub_m: Vector3<f64>,
    pub(super) axis_in_hub: Unit<Vector3<f64>>,
    pub(super) profile: Profile,
}

impl Modelled {
    /// Returns the reach from the hub's centre in a unit direction, in metres.
    fn reach_m(&self, outward: &Vector3<f64>) -> f64 {
        let w = self.axis_in_hub.dot(outward);
        self.foot_in_hub_m.dot(outward) + self.profile.support_m(w)
    }

    /// Returns the furthest point in a unit direction across the hub axis, seen along the hub axis,
    /// in metres.
    fn point_m(&self, outward: &Vector3<f64>) -> Vector2<f64> {
        let w = self.axis_in_hub.dot(outward);
        let (part, _) = self.profile.furthest(w);
        // Outward across the roller's axis; on the axis itself any direction works.
        let across = outward - self.axis_in_hub.into_inner() * w;
        let across = across.try_normalize(1e-12).unwrap_or_default();
        let on_axis = self.foot_in_hub_m + self.axis_in_hub.into_inner() * part.t_m;
        (on_axis + across * part.ring_m + outward * part.ball_m).xy()
    }
}

/// Returns a unit direction across the hub axis.
fn outward(angle_rad: f64) -> Vector3<f64> {
    let (s, c) = libm::sincos(angle_rad);
    Vector3::new(c, s, 0.0)
}

/// Returns the outline of a wheel, from its rollers ordered by angle.
pub(super) fn outline(
    wheel: &str,
    fitted_radius_m: f64,
    rollers: &[Modelled],
    handover: &Handover,
) -> WheelOutline {
    let step_rad = TAU / SAMPLES as f64;
    // In each direction the ground touches the furthest roller, or several: neighbours often share
    // a sphere.
    let hull: Vec<(f64, Vec<usize>)> = (0..SAMPLES)
        .map(|i| {
            let down = outward(step_rad * i as f64);
            let reaches_m: Vec<f64> = rollers.iter().map(|r| r.reach_m(&down)).collect();
            let height_m = reaches_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let touches = |i: &usize| reaches_m[*i] > height_m - AS_ONE * fitted_radius_m;
            (height_m, (0..rollers.len()).filter(touches).collect())
        })
        .collect();
    let heights_m = || hull.iter().map(|(height_m, _)| *height_m);
    let peak_radius_m = heights_m().fold(f64::NEG_INFINITY, f64::max);
    let least_m = heights_m().fold(f64::INFINITY, f64::min);
    // A bridge is passed if rollers touch at different positions at once, or if the next sample has
    // other rollers: between samples a smooth outline advances by a step, and any excess is the
    // bridge.
    let place_rad = |i: usize, roller: usize| {
        let down = outward(step_rad * i as f64);
        let p = rollers[roller].point_m(&down);
        libm::atan2(down.xy().perp(&p), down.xy().dot(&p))
    };
    let bridge_rad = |i: usize| {
        let next = (i + 1) % SAMPLES;
        let (touching, then) = (&hull[i].1, &hull[next].1);
        let places = || touching.iter().map(|&roller| place_rad(i, roller));
        let first_rad = places().fold(f64::INFINITY, f64::min);
        let last_rad = places().fold(f64::NEG_INFINITY, f64::max);
        let here_rad = last_rad - first_rad;
        if touching.iter().any(|roller| then.contains(roller)) {
            return here_rad;
        }
        let next_rad = then
            .iter()
            .map(|&roller| place_rad(next, roller))
            .fold(f64::INFINITY, f64::min);
        // Positions are relative to each sample's own direction, which advances by a step itself.
        here_rad + f64::max(next_rad - last_rad, 0.0)
    };
    let heights_m: Vec<f64> = heights_m().collect();
    let radii_m = radii_m(rollers);
    WheelOutline {
        wheel: wheel.to_owned(),
        fitted_radius_m,
        mean_radius_m: mean_of_seen(&radii_m),
        rolling_radius_m: heights_m.iter().sum::<f64>() / SAMPLES as f64,
        peak_radius_m,
        outline_error_m: heights_m
            .iter()
            .map(|height_m| (height_m - fitted_radius_m).abs())
            .fold(0.0, f64::max),
        ripple_m: peak_radius_m - least_m,
        gap_share: (0..SAMPLES).map(bridge_rad).sum::<f64>() / TAU,
        gap_depth_m: gap_depth_m(&heights_m, &radii_m),
        overlap_share: handover.overlaps_rad / TAU,
        overlap_depth_m: overlap_depth_m(rollers),
    }
}

/// Returns the distance of the rollers' outline from the hub axis, seen along it, in each sampled
/// direction; 0 without a roller.
fn radii_m(rollers: &[Modelled]) -> Vec<f64> {
    let step_rad = TAU / SAMPLES as f64;
    let mut radii_m = vec![0.0f64; SAMPLES];
    for roller in rollers {
        let corner = |k: usize| {
            roller.point_m(&outward(
                TAU * (k % ROLLER_SAMPLES) as f64 / ROLLER_SAMPLES as f64,
            ))
        };
        let mut p = corner(0);
        for k in 1..=ROLLER_SAMPLES {
            let q = corner(k);
            let turn_rad = libm::atan2(p.perp(&q), p.dot(&q));
            // Of the two sides of a roller the outer one runs counter-clockwise.
            if turn_rad > 0.0 {
                let from = (libm::atan2(p.y, p.x) / step_rad).ceil();
                let count = ((libm::atan2(p.y, p.x) + turn_rad) / step_rad - from).floor();
                for i in 0..=(count.max(-1.0) as i64) {
                    let angle_rad = step_rad * (from + i as f64);
                    let d = outward(angle_rad).xy();
                    // The ray d r crosses the side from p to q where d r x (q - p) = p x q.
                    let across = d.perp(&(q - p));
                    if across > 0.0 {
                        let place = (from as i64 + i).rem_euclid(SAMPLES as i64) as usize;
                        radii_m[place] = radii_m[place].max(p.perp(&q) / across);
                    }
                }
            }
            p = q;
        }
    }
    radii_m
}

/// Returns the largest depth of an outline below its convex hull, from the hull's supports and the
/// outline's radii.
fn gap_depth_m(heights_m: &[f64], radii_m: &[f64]) -> f64 {
    // The hull is inside all its tangents: r(theta) = min over phi of h(phi) / cos(theta - phi).
    const NEAR: usize = SAMPLES / 6;
    let step_rad = TAU / SAMPLES as f64;
    let cosines: Vec<f64> = (0..=NEAR).map(|k| libm::cos(step_rad * k as f64)).collect();
    let lowest_m = heights_m.iter().copied().fold(f64::INFINITY, f64::min);
    let hull_m = |i: usize| {
        let mut hull_m = f64::INFINITY;
        for (k, cosine) in cosines.iter().enumerate() {
            // Further tangents cannot be closer than the lowest of all would be here.
            if lowest_m / cosine > hull_m {
                break;
            }
            for j in [i + k, i + SAMPLES - k] {
                hull_m = hull_m.min(heights_m[j % SAMPLES] / cosine);
            }
        }
        hull_m
    };
    (0..SAMPLES)
        .map(|i| hull_m(i) - radii_m[i])
        .fold(0.0, f64::max)
}

fn mean_of_seen(radii_m: &[f64]) -> f64 {
    let (sum, count) = radii_m
        .iter()
        .filter(|&&r| r > 0.0)
        .fold((0.0, 0usize), |(sum, count), r| (sum + r, count + 1));
    sum / count.max(1) as f64
}

/// Returns the penetration depth of neighbours.
fn overlap_depth_m(rollers: &[Modelled]) -> f64 {
    // In a wheel of two rows the next roller is in the other row, and the one after it in the same.
    let pairs = |ahead| rollers.iter().zip(rollers.iter().cycle().skip(ahead));
    let all = pairs(1).chain(pairs(2));
    all.map(|(a, b)| -apart_m(a, b)).fold(0.0, f64::max)
}

/// Returns the gap between two convex bodies: the largest over all directions, negative if they
/// overlap.
///
/// Gap in direction u: smallest reach of b along u less largest reach of a. The search starts at
/// the best of 128 directions spread over the sphere and climbs with decreasing steps.
fn apart_m(a: &Modelled, b: &Modelled) -> f64 {
    const SPREAD: usize = 128;
    const LEAST_STEP: f64 = 1e-4;
    // A dozen halvings with some steps between them; for bodies a thousand kilometres long it would
    // climb for seconds.
    const MOST_STEPS: usize = 100;
    let gap_m = |u: &Vector3<f64>| -b.reach_m(&-u) - a.reach_m(u);
    let (mut best_m, mut u) = directions(SPREAD)
        .map(|u| (gap_m(&u), u))
        .max_by(|p, q| p.0.total_cmp(&q.0))
        .unwrap_or((0.0, Vector3::z()));
    let mut step = 0.2;
    for _ in 0..MOST_STEPS {
        if step < LEAST_STEP {
            break;
        }
        let aside = if u.x.abs() < 0.7 {
            Vector3::x()
        } else {
            Vector3::y()
        };
        let p = u.cross(&aside).normalize();
        let q = u.cross(&p);
        let tries = [p, -p, q, -q].map(|t| (u + t * step).normalize());
        let better = tries
            .into_iter()
            .map(|u| (gap_m(&u), u))
            .max_by(|p, q| p.0.total_cmp(&q.0))
            .filter(|(gap_m, _)| *gap_m > best_m);
        match better {
            Some(found) => (best_m, u) = found,
            None => step *= 0.5,
        }
    }
    best_m
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::model::ProfilePart;

    /// `count` spheres of a radius on a ring.
    fn spheres(count: usize, ring_m: f64, radius_m: f64) -> Vec<Modelled> {
        let sphere = |i: usize| Modelled {
            foot_in_hub_m: outward(TAU * i as f64 / count as f64) * ring_m,
            axis_in_hub: Vector3::z_axis(),
            profile: Profile::new(vec![ProfilePart {
                t_m: 0.0,
                ring_m: 0.0,
                ball_m: radius_m,
            }])
            .unwrap(),
        };
        (0..count).map(sphere).collect()
    }

    fn of(rollers: &[Modelled], fitted_radius_m: f64) -> WheelOutline {
        let no_overlap = Handover {
            widest_gap_rad: 0.0,
            gaps_rad: 0.0,
            overlaps_rad: 0.0,
            rollers: 0,
            missing: 0,
        };
        outline("w", fitted_radius_m, rollers, &no_overlap)
    }

    #[test]
    fn six_spheres_roll_on_their_hull() {
        let (n, a, r) = (6, 0.04, 0.01);
        let seen = of(&spheres(n, a, r), a + r);
        // The hull of n circles on a ring: n straight bridges of 2 a sin(pi/n) and n arcs that make
        // one circle of r.
        let perimeter = n as f64 * 2.0 * a * (PI / n as f64).sin() + TAU * r;
        // The sum over 3600 samples of a smooth function with n corners is accurate to the square
        // of a step.
        assert!((seen.rolling_radius_m - perimeter / TAU).abs() < 1e-8);
        assert!((seen.peak_radius_m - (a + r)).abs() < 1e-12);
        // Between two spheres the hub is at a cos(pi/n) + r.
        let dip = a * (1.0 - (PI / n as f64).cos());
        assert!((seen.ripple_m - dip).abs() < 1e-9, "{}", seen.ripple_m);
        assert!((seen.outline_error_m - dip).abs() < 1e-9);
        // A bridge touches its spheres at r in the direction of its normal, pi/n from the sphere's
        // own.
        let half = (a * (PI / n as f64).sin()).atan2(a * (PI / n as f64).cos() + r);
        let share = n as f64 * 2.0 * half / TAU;
        // A sample's step is 1/3600 of the turn, and each bridge has two ends.
        assert!((seen.gap_share - share).abs() < 2.0 * n as f64 / 3600.0);
        assert_eq!(seen.overlap_depth_m, 0.0);
        // Beyond asin(r / a) from a sphere's centre no roller is below the bridge, which is at a
        // cos(pi/n) + r from the axis; there, off its middle, it is furthest away. One sample
        // changes that by 2e-5 m.
        let off = PI / n as f64 - (r / a).asin();
        let through = (a * (PI / n as f64).cos() + r) / off.cos();
        assert!(
            (seen.gap_depth_m - through).abs() < 3e-5,
            "{}",
            seen.gap_depth_m
        );
    }

    #[test]
    fn the_mean_radius_is_that_of_the_outline_not_of_the_hull() {
        // Twelve spheres of 12 mm on 40 mm overlap and close the outline: r(theta) = a cos +
        // sqrt(r^2 - a^2 sin^2), whose mean follows by the midpoint rule.
        let (n, a, r) = (12, 0.04, 0.012);
        let seen = of(&spheres(n, a, r), a + r);
        let half = PI / n as f64;
        let steps = 1000;
        let mean = (0..steps)
            .map(|i| half * (i as f64 + 0.5) / f64::from(steps))
            .map(|t| a * t.cos() + (r * r - (a * t.sin()).powi(2)).sqrt())
            .sum::<f64>()
            / f64::from(steps);
        // Sides of a degree lose 4e-5 r = 5e-7 m, samples of a tenth of a degree a little more at
        // the corners.
        assert!(
            (seen.mean_radius_m - mean).abs() < 2e-6,
            "{}",
            seen.mean_radius_m
        );
        assert!(seen.mean_radius_m < seen.rolling_radius_m);
        // The bridge is at a cos(pi/n) + r over the valley at a cos(pi/n) + sqrt(r^2 - a^2
        // sin^2(pi/n)). The sides of a degree lose up to 5e-7 m, and as much again where they cut
        // the valley's slopes.
        let deep = r - (r * r - (a * half.sin()).powi(2)).sqrt();
        assert!(
            (seen.gap_depth_m - deep).abs() < 5e-6,
            "{}",
            seen.gap_depth_m
        );
    }

    #[test]
    fn spheres_that_run_into_each_other_are_measured() {
        let (n, a, r) = (10, 0.0213, 0.02);
        let seen = of(&spheres(n, a, r), a + r);
        // The centres are 2 a sin(pi/n) apart.
        let deep = 2.0 * r - 2.0 * a * (PI / n as f64).sin();
        // The search ends at steps of 1e-4, whose error is of second order in them.
        assert!(
            (seen.overlap_depth_m - deep).abs() < 1e-8,
            "{}",
            seen.overlap_depth_m
        );
    }

    #[test]
    fn rollers_of_any_size_are_measured_in_good_time() {
        // Capsules as long as a file allows, side by side: 40 m apart with radii of 10 m.
        let rod = |x_m: f64| Modelled {
            foot_in_hub_m: Vector3::new(x_m, 0.0, 0.0),
            axis_in_hub: Vector3::z_axis(),
            profile: Profile::new(
                [-1e9, 1e9]
                    .map(|t_m| ProfilePart {
                        t_m,
                        ring_m: 0.0,
                        ball_m: 10.0,
                    })
                    .to_vec(),
            )
            .unwrap(),
        };
        let rods: Vec<Modelled> = [0.0, 40.0, 80.0].map(rod).into();
        let start = std::time::Instant::now();
        overlap_depth_m(&rods);
        // Milliseconds; without a step limit the search takes a second.
        assert!(start.elapsed().as_secs_f64() < 0.5);
    }
}
