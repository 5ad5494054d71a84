//! The outline of a roller: points `[z, r]` along and across its axis, from one end to the other,
//! closed by flat ends.

use ilon_robot::{Barrel, Profile, SolidOfRevolution};

/// Intervals of a barrel's outline; chosen so that no chord deviates from the arc by more than a
/// hundredth of the roller's radius.
const PLACES: usize = 10;
/// Steps of the arc over a rounded edge; chosen.
const EDGE_STEPS: u32 = 4;
/// Directions in which the hull of a modelled roller is sampled; chosen.
const DIRECTIONS: usize = 64;

/// The exact barrel: the envelope of its spheres, over the part that touches the ground.
///
/// The sphere at t with radius s(t) touches the envelope where the direction's component along the
/// axis is w = -s'(t) = k^2 t / hypot(a, k t), with k = sin delta: at z = t + s w, r = s sqrt(1 -
/// w^2) (see [`ilon_robot::barrel_profile`]).
pub fn of_barrel(barrel: &Barrel) -> Vec<[f32; 2]> {
    let k = barrel.sin_delta;
    let surface = (0..=PLACES).map(|i| {
        let t = barrel.half_length_m * (2.0 * i as f64 / PLACES as f64 - 1.0);
        let s = barrel.sphere_radius_m(t).max(0.0);
        let w = k * k * t / libm::hypot(barrel.ring_radius_m, k * t);
        [t + s * w, s * (1.0 - w * w).max(0.0).sqrt()]
    });
    closed(surface.collect())
}

/// A roller as its file models it: the convex hull of its parts, which is what touches flat ground.
pub fn of_profile(profile: &Profile) -> Vec<[f32; 2]> {
    let mut surface: Vec<[f64; 2]> = Vec::new();
    for i in 0..=DIRECTIONS {
        // From one end over the side to the other.
        let angle = std::f64::consts::PI * (i as f64 / DIRECTIONS as f64 - 0.5);
        let (w, across) = libm::sincos(angle);
        let (part, _) = profile.furthest(w);
        let point = [
            part.t_m + part.ball_m * w,
            part.ring_m + part.ball_m * across.max(0.0),
        ];
        if surface.last() != Some(&point) {
            surface.push(point);
        }
    }
    closed(surface)
}

/// A roller with a profile given by numbers: its points, and arcs over rounded edges.
pub fn of_turned(turned: &SolidOfRevolution) -> Vec<[f32; 2]> {
    let corners = turned.corners();
    // The outward normal of the line or face before the corner, as an angle from the axis.
    let before_rad = |i: usize| match i {
        0 => std::f64::consts::PI,
        i if i == corners.len() => 0.0,
        i => {
            let (p, q) = (&corners[i - 1], &corners[i]);
            libm::atan2(q.t_m - p.t_m, p.ring_m - q.ring_m)
        }
    };
    let steps = if turned.edge_radius_m() > 0.0 {
        EDGE_STEPS
    } else {
        0
    };
    let surface = corners.iter().enumerate().flat_map(|(i, corner)| {
        let (from_rad, to_rad) = (before_rad(i), before_rad(i + 1));
        (0..=steps).map(move |step| {
            let share = f64::from(step) / f64::from(steps.max(1));
            let (out, along) = libm::sincos(from_rad + share * (to_rad - from_rad));
            let c = corner.ball_m;
            [corner.t_m + c * along, corner.ring_m + c * out]
        })
    });
    closed(surface.collect())
}

/// Adds a point on the axis at both ends.
fn closed(surface: Vec<[f64; 2]>) -> Vec<[f32; 2]> {
    let ends = surface.first().copied().zip(surface.last().copied());
    let Some(([first, _], [last, _])) = ends else {
        return Vec::new();
    };
    let inner = surface.into_iter();
    [[first, 0.0]]
        .into_iter()
        .chain(inner)
        .chain([[last, 0.0]])
        .map(|[z, r]| [z as f32, r as f32])
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use ilon_robot::ProfilePart;

    use super::*;

    #[test]
    fn a_profile_by_numbers_is_drawn_on_its_surface() {
        for edge_radius_m in [0.0, 0.002] {
            let points = [[-0.02, 0.006], [-0.006, 0.01], [0.006, 0.01], [0.02, 0.007]];
            let turned = SolidOfRevolution::new(&points, edge_radius_m).unwrap();
            let outline = of_turned(&turned);
            // From the axis at one end to the axis at the other, with every other point on the
            // surface, to f32 rounding.
            let (first, last) = (outline[0], outline[outline.len() - 1]);
            assert_eq!(
                ([first[0], last[0]], [first[1], last[1]]),
                ([-0.02, 0.02], [0.0; 2])
            );
            for [z, r] in &outline[1..outline.len() - 1] {
                let (off_m, _) = turned.distance_m(f64::from(*z), f64::from(*r));
                assert!(off_m.abs() < 1e-8, "{z} {r}: {off_m:e}");
            }
        }
    }

    #[test]
    fn every_point_of_the_outline_reaches_the_wheels_circle() {
        // A wheel of 50 mm with nine rollers at 45 deg. In the roller's frame, axis z, the hub axis
        // lies at the distance a along -x and has the direction (0, -cos delta', sin delta'), with
        // k = sin(angle between the axes). A point at (z, r) is furthest from the hub axis at the
        // angle phi about the roller's axis; that distance is the wheel's radius.
        let barrel = Barrel::handing_over(0.05, 0.012, PI / 4.0, 9);
        let (k, c) = (barrel.sin_delta, (1.0 - barrel.sin_delta.powi(2)).sqrt());
        for [z, r] in of_barrel(&barrel).into_iter().filter(|p| p[1] > 0.0) {
            let (z, r) = (f64::from(z), f64::from(r));
            let furthest = (0..3600)
                .map(|i| {
                    let (y, x) = libm::sincos(2.0 * PI * f64::from(i) / 3600.0);
                    // Across the hub axis: outwards, and k z +- c y along the rim.
                    libm::hypot(barrel.ring_radius_m + r * x, k * z - c * r * y)
                })
                .fold(0.0, f64::max);
            // Rounded to f32, at angles a tenth of a degree apart: 0.05 (1 - cos 0.05 deg) is 2e-8.
            assert!((furthest - 0.05).abs() < 5e-8, "{furthest} at {z}");
        }
    }

    #[test]
    fn no_chord_of_the_outline_is_off_the_arc_by_more_than_a_hundredth_of_the_radius() {
        // The longest and most curved of common rollers: six per wheel.
        let barrel = Barrel::handing_over(0.05, 0.015, PI / 4.0, 6);
        let outline = of_barrel(&barrel);
        let inner = &outline[1..outline.len() - 1];
        for ends in inner
            .windows(2)
            .filter(|ends| ends[0][0].abs().max(ends[1][0].abs()) < barrel.half_length_m as f32)
        {
            let [z, r] = [0, 1].map(|i| f64::from(ends[0][i] + ends[1][i]) / 2.0);
            let off_m = barrel.surface_radius_m(z) - r;
            assert!((0.0..0.01 * 0.015).contains(&off_m), "{off_m} at {z}");
        }
    }

    #[test]
    fn the_outline_of_a_cylinder_is_a_rectangle() {
        let part = |t_m| ProfilePart {
            t_m,
            ring_m: 0.25,
            ball_m: 0.0,
        };
        let profile = Profile::new(vec![part(-0.5), part(0.5)]).unwrap();
        let rectangle = [[-0.5, 0.0], [-0.5, 0.25], [0.5, 0.25], [0.5, 0.0]];
        assert_eq!(of_profile(&profile), rectangle);
    }
}
