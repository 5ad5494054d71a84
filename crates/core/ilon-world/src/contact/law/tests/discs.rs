//! Impulses in a disc: rolling resistance.

use nalgebra::Vector2;

use super::super::system::{TOLERANCE, pair};
use super::super::{ImpulseProblem, Law};
use super::{Draw, contact, problem, solve};

/// A motion in a plane with u and a response of 1 / m is stopped by p = -m u if that is within its
/// disc, and otherwise loses most / m of its speed; over a nap p lies on the ellipse, and no other
/// impulse dissipates more.
#[test]
fn a_disc_holds_what_it_can_and_slows_the_rest() {
    let mass_kg = 2.0;
    let response = [1.0 / mass_kg, 0.0, 0.0, 1.0 / mass_kg];
    let free = Vector2::new(0.3, -0.4);
    for most_n_s in [0.0, 0.2, 0.9, 1.1] {
        let mut one = problem(&[Law::Disc { most_n_s }], free.as_slice(), &response);
        assert!(solve(&mut one) <= TOLERANCE);
        let lost = most_n_s.min(mass_kg * free.norm());
        // Solved to 1e-8 m/s: 2e-8 N s.
        let apart = pair(&one.impulses, 0) + lost * free.normalize();
        assert!(apart.norm() < 1e-7, "{most_n_s}: {apart}");
    }
    let (along, ratio, most_n_s) = (Vector2::new(0.6, 0.8), 0.5, 0.4);
    let across = Vector2::new(-0.8, 0.6);
    let mut napped = ImpulseProblem::default();
    napped.push(Law::Disc { most_n_s }, free.as_slice());
    napped.make_anisotropic(along, ratio);
    napped.set_delassus(|row, w| w.copy_from_slice(&response[row * 2..][..w.len()]));
    assert!(solve(&mut napped) <= TOLERANCE && !napped.holds(0));
    let (p, u) = (pair(&napped.impulses, 0), pair(&napped.velocities, 0));
    assert!((u - free - p / mass_kg).norm() < 1e-12);
    let size = p.dot(&along).hypot(p.dot(&across) / ratio);
    assert!((size / most_n_s - 1.0).abs() < 1e-6, "{size}");
    for step in 0..24 {
        let (s, c) = (f64::from(step) * 0.27).sin_cos();
        let other = most_n_s * (c * along + ratio * s * across);
        assert!(p.dot(&u) <= other.dot(&u) + 1e-9);
    }
}

/// Contacts and discs on the same rollers, like friction with rolling resistance.
#[test]
fn random_problems_with_discs_are_solved_and_never_gain_power() {
    let mut draw = Draw(6);
    let mut unsolved = 0;
    for _ in 0..500 {
        let laws: Vec<Law> = (0..3)
            .flat_map(|_| {
                let most_n_s = 0.3 * draw.next().abs();
                [contact(draw.next().abs()), Law::Disc { most_n_s }]
            })
            .collect();
        let free: Vec<f64> = (0..15).map(|_| draw.next()).collect();
        let response = draw.response(15, 11, 1e-3);
        let mut random = problem(&laws, &free, &response);
        let error = solve(&mut random);
        unsolved += usize::from(error > TOLERANCE);
        for (at, law) in random.laws.clone() {
            let Law::Disc { most_n_s } = law else {
                continue;
            };
            let (p, u) = (pair(&random.impulses, at), pair(&random.velocities, at));
            assert!(p.norm() <= most_n_s * (1.0 + 1e-9));
            assert!(p.dot(&u) <= error * p.norm() + 1e-12);
            if error <= TOLERANCE && p.norm() < most_n_s * (1.0 - 1e-6) {
                assert!(u.norm() <= TOLERANCE);
            }
        }
    }
    assert_eq!(unsolved, 0);
}
