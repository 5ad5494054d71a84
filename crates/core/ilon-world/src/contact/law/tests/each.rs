//! Each law by itself: its proximal map satisfies the law, and its slopes and those of the residual
//! are the numerical derivatives.

use nalgebra::Vector2;

use super::super::curve::Curves;
use super::super::kinds::Allowed;
use super::super::{Curve, ImpulseProblem, Law};
use super::{Draw, bearing, slide};

/// A motor whose torque falls beyond its rate, as a curve.
fn curve() -> Curve {
    Curve {
        points: vec![[0.0, 0.0], [1.0, 0.2], [1.0, -0.3], [4.0, -0.6]],
        ends: [[1.0, 0.1], [1.0, -0.2]],
    }
}

/// One of each law.
fn laws() -> [Law; 5] {
    [
        bearing(0.3),
        slide([-0.4, 0.5]),
        Law::Curve { place: 0 },
        Law::Disc { most_n_s: 0.4 },
        Law::Contact {
            friction: 0.7,
            approach_m_s: 0.1,
            compliance: 0.2,
        },
    ]
}

fn curves() -> Curves {
    let mut curves = Curves::default();
    curves.push(&curve());
    curves
}

/// The violation of a law by an impulse and a velocity, computed from its definition.
fn off(law: Law, p: [f64; 3], u: [f64; 3]) -> f64 {
    let in_disc = |first: usize, limit: f64| {
        let p = Vector2::new(p[first], p[first + 1]);
        let u = Vector2::new(u[first], u[first + 1]);
        // It dissipates the most that an impulse of the disc can.
        (p.norm() - limit).max(limit * u.norm() + p.dot(&u))
    };
    match law {
        Law::Joint {
            least_n_m_s,
            most_n_m_s,
        } => {
            let takes = u[0].max(0.0) * (p[0] - least_n_m_s) - u[0].min(0.0) * (most_n_m_s - p[0]);
            takes.max(least_n_m_s - p[0]).max(p[0] - most_n_m_s)
        }
        Law::Slide {
            least_m_s,
            most_m_s,
        } => {
            let pushes = p[0].max(0.0) * (u[0] - least_m_s) - p[0].min(0.0) * (most_m_s - u[0]);
            pushes.max(least_m_s - u[0]).max(u[0] - most_m_s)
        }
        // The distance from its nearest piece.
        Law::Curve { .. } => {
            let (points, ends) = (curve().points, curve().ends);
            let at = Vector2::new(u[0], p[0]);
            let points: Vec<Vector2<f64>> = points.into_iter().map(Vector2::from).collect();
            let [first, last] = ends.map(Vector2::from);
            let mut pieces = vec![(points[0], -first, f64::INFINITY)];
            pieces.extend(points.windows(2).map(|two| (two[0], two[1] - two[0], 1.0)));
            pieces.push((points[points.len() - 1], last, f64::INFINITY));
            let apart = pieces.into_iter().map(|(from, along, most)| {
                let share = (at - from).dot(&along) / along.norm_squared();
                (from + share.clamp(0.0, most) * along - at).norm()
            });
            apart.fold(f64::INFINITY, f64::min)
        }
        Law::Disc { most_n_s } => in_disc(0, most_n_s),
        Law::Contact {
            friction,
            approach_m_s,
            compliance,
        } => {
            let gap = u[0] + approach_m_s + compliance * p[0];
            let normal = (-p[0]).max(-gap).max(p[0] * gap);
            normal.max(in_disc(1, friction * p[0]))
        }
    }
}

/// Random impulses on both sides of every kink.
fn asked(draw: &mut Draw) -> [f64; 3] {
    [0.0; 3].map(|_| 1.5 * draw.next())
}

/// The impulse p nearest to q, and the velocity (p - q) / g, satisfy the law.
#[test]
fn the_proximal_map_of_each_law_is_on_the_law() {
    let (curves, mut draw) = (curves(), Draw(21));
    for law in laws() {
        for _ in 0..500 {
            let q = asked(&mut draw);
            // The curve's impulse rises by no more than 0.2 per velocity.
            let yields = 0.25 + draw.next().abs();
            let p = law.allows(&curves, &q, yields).impulse;
            let u = [0, 1, 2].map(|k| (p[k] - q[k]) / yields);
            let off = off(law, p, u);
            assert!(off < 1e-12, "{law:?}: {q:?} to {p:?}, off by {off:e}");
        }
    }
}

/// With no compliance it is the nearest impulse that the law allows at any velocity, and an allowed
/// one is unchanged.
#[test]
fn without_room_to_yield_only_the_bounds_count() {
    let (curves, mut draw) = (curves(), Draw(22));
    for law in laws() {
        for _ in 0..200 {
            let q = asked(&mut draw);
            let p = law.allows(&curves, &q, 0.0).impulse;
            let again = law.allows(&curves, &p, 0.0).impulse;
            // A disc is projected onto its rim to rounding.
            let apart = [0, 1, 2].map(|k| (again[k] - p[k]).abs());
            assert!(apart.iter().all(|apart| *apart < 1e-15), "{law:?} {q:?}");
            let stays = match law {
                Law::Slide { .. } | Law::Curve { .. } => p[0] == q[0],
                Law::Joint { .. } => p[0] == q[0].clamp(-0.3, 0.3),
                Law::Disc { .. } => p[0].hypot(p[1]) <= 0.4 * (1.0 + 1e-15),
                Law::Contact { .. } => {
                    p[0] == q[0].max(0.0) && p[1].hypot(p[2]) <= 0.7 * p[0] * (1.0 + 1e-15)
                }
            };
            assert!(stays, "{law:?}: {q:?} to {p:?}");
        }
    }
}

/// Difference quotients over 2e-6 N s: the maps are piecewise smooth with second derivatives of
/// some tens per N s, so that these are accurate to 1e-9, and no kink is within 1e-6 of these few
/// points.
#[test]
fn the_slopes_of_each_law_are_those_of_differences() {
    const BY: f64 = 1e-6;
    let (curves, mut draw) = (curves(), Draw(23));
    for law in laws() {
        for _ in 0..300 {
            let q = asked(&mut draw);
            let yields = 0.25 + draw.next().abs();
            let Allowed { slope, .. } = law.allows(&curves, &q, yields);
            for by in 0..law.rows() {
                let [before, after] = [-BY, BY].map(|more| {
                    let mut there = q;
                    there[by] += more;
                    law.allows(&curves, &there, yields).impulse
                });
                for row in 0..law.rows() {
                    let expected = (after[row] - before[row]) / (2.0 * BY);
                    let got = slope[row][by];
                    assert!(
                        (got - expected).abs() < 1e-8,
                        "{law:?} {q:?}: {got} {expected}"
                    );
                }
            }
        }
    }
}

/// Two contacts and one of each other law, where each moves all others.
fn coupled(friction: f64, free: &[f64]) -> ImpulseProblem {
    let mut problem = ImpulseProblem::default();
    problem.add_curve(&curve());
    let contact = Law::Contact {
        friction,
        approach_m_s: 0.01,
        compliance: 0.2,
    };
    let mut rest = free;
    for law in [contact].into_iter().chain(laws()) {
        let (own, others) = rest.split_at(law.rows());
        problem.push(law, own);
        rest = others;
    }
    problem.set_delassus(|row, w| {
        for (column, w) in w.iter_mut().enumerate() {
            let apart = (row - column) as f64;
            *w = if row == column {
                2.0 + 0.1 * (row % 3) as f64
            } else {
                0.3 / (1.0 + apart)
            };
        }
    });
    problem
}

/// The derivative of F equals difference quotients over 2e-6 N s, wherever F has one: F is
/// piecewise smooth with second derivatives below 1e3 per N s, so that these are accurate to 1e-5,
/// and no kink is within 1e-6 of these few points.
#[test]
fn the_derivative_of_the_residual_is_that_of_differences() {
    const BY: f64 = 1e-6;
    let mut draw = Draw(24);
    for case in 0..100 {
        let free: Vec<f64> = (0..11).map(|_| draw.next()).collect();
        let mut problem = coupled(0.3 + 0.02 * f64::from(case), &free);
        let rows = problem.rows();
        let at: Vec<f64> = (0..rows).map(|_| 0.5 * draw.next()).collect();
        let mut missing = |impulses: &[f64], derivative: Option<&mut [f64]>| {
            problem.impulses.copy_from_slice(impulses);
            problem.follow_impulses();
            let mut missing = vec![0.0; rows];
            problem.residual(&mut missing, derivative);
            missing
        };
        let mut derivative = vec![f64::NAN; rows * rows];
        missing(&at, Some(&mut derivative));
        for column in 0..rows {
            let [before, after] = [-BY, BY].map(|by| {
                let mut there = at.clone();
                there[column] += by;
                missing(&there, None)
            });
            for row in 0..rows {
                let expected = (after[row] - before[row]) / (2.0 * BY);
                let got = derivative[row * rows + column];
                assert!(
                    (got - expected).abs() < 1e-5,
                    "case {case}, row {row}, column {column}: {got} {expected}"
                );
            }
        }
    }
}

/// F vanishes if and only if the laws hold: friction from 1 to 3, which couples pressure and
/// sliding as in jams.
#[test]
fn the_residual_vanishes_where_the_laws_hold() {
    let mut draw = Draw(25);
    let mut solved = 0;
    for case in 0..40 {
        let free: Vec<f64> = (0..11).map(|_| draw.next()).collect();
        let mut problem = coupled(1.0 + 0.05 * f64::from(case), &free);
        let error = super::solve(&mut problem);
        let size = problem.residual(&mut [0.0; 11], None).sqrt();
        if error <= super::TOLERANCE {
            solved += 1;
            // Eleven rows of a response of 2 to 4 per impulse, whose laws hold to 1e-8.
            assert!(size < 1e-7, "case {case}: {size:e}");
        } else {
            assert!(size > 1e-9, "case {case}: {size:e} with {error:e}");
        }
    }
    assert!(solved >= 38, "{solved} of 40");
}
