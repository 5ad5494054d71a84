//! Impulses that follow by hand, and laws that hold for random problems.

mod compliant;
mod discs;
mod each;
mod play;

use nalgebra::{Vector2, Vector3};

use super::system::TOLERANCE;
use super::{ImpulseProblem, Law, Solver};

/// Random numbers between -1 and 1, the same in every run.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A symmetric matrix A^T A + ridge, row by row: positive definite, or singular without the
    /// ridge if A has fewer rows than columns.
    fn response(&mut self, rows: usize, rank: usize, ridge: f64) -> Vec<f64> {
        let a: Vec<f64> = (0..rank * rows).map(|_| self.next()).collect();
        let entry = |i: usize, j: usize| {
            let sum: f64 = (0..rank).map(|k| a[k * rows + i] * a[k * rows + j]).sum();
            sum + if i == j { ridge } else { 0.0 }
        };
        (0..rows * rows)
            .map(|i| entry(i / rows, i % rows))
            .collect()
    }
}

fn solve(problem: &mut ImpulseProblem) -> f64 {
    Solver::default().solve(problem)
}

fn bearing(most_n_m_s: f64) -> Law {
    Law::Joint {
        least_n_m_s: -most_n_m_s,
        most_n_m_s,
    }
}

fn contact(friction: f64) -> Law {
    Law::Contact {
        friction,
        approach_m_s: 0.0,
        compliance: 0.0,
    }
}

fn problem(laws: &[Law], free: &[f64], response: &[f64]) -> ImpulseProblem {
    let mut problem = ImpulseProblem::default();
    let mut rest = free;
    for law in laws {
        let (own, others) = rest.split_at(law.rows());
        problem.push(*law, own);
        rest = others;
    }
    problem.set_delassus(|row, w| w.copy_from_slice(&response[row * free.len()..][..w.len()]));
    problem
}

/// A block of mass m that falls at v on a floor of friction mu while it slides at s: the floor
/// stops the fall with m v, and friction reduces the sliding speed by mu v, at most to zero. By
/// hand: p_n = m v, |p_t| = min(mu m v, m s).
#[test]
fn a_block_loses_as_much_sliding_as_coulomb_says() {
    let (mass_kg, fall, slide) = (2.5, 0.4, Vector2::new(-0.3, 0.4));
    let response: Vec<f64> = (0..9)
        .map(|i| if i % 4 == 0 { 1.0 / mass_kg } else { 0.0 })
        .collect();
    for mu in [0.0, 0.2, 0.9, 1.25, 3.0] {
        let mut block = problem(&[contact(mu)], &[-fall, slide.x, slide.y], &response);
        assert!(solve(&mut block) <= TOLERANCE);
        let p = block.contact_impulse(0);
        let rubbed = mass_kg * slide.norm().min(mu * fall);
        // Solved to 1e-8 m/s: 2.5e-8 N s.
        assert!((p.x - mass_kg * fall).abs() < 1e-7, "mu {mu}: {p}");
        assert!(
            (p.yz() + slide.normalize() * rubbed).norm() < 1e-7,
            "mu {mu}: {p}"
        );
    }
}

/// A contact that opens by itself, or may come nearer than it does, carries nothing; one that is
/// too deep is pushed out at the given rate.
#[test]
fn contacts_push_only_and_only_as_far_as_asked() {
    let response = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0];
    for (free, approach, impulse, left) in [
        (0.1, 0.0, 0.0, 0.1),
        (-0.1, 0.2, 0.0, -0.1),
        (-0.3, 0.2, 0.05, -0.2),
        (0.1, -0.5, 0.2, 0.5),
    ] {
        let law = Law::Contact {
            friction: 0.5,
            approach_m_s: approach,
            compliance: 0.0,
        };
        let mut one = problem(&[law], &[free, 0.0, 0.0], &response);
        solve(&mut one);
        assert!((one.impulses[0] - impulse).abs() < 1e-8);
        assert!((one.velocities[0] - left).abs() < 2e-8);
    }
}

/// A compliant contact deflects by c p: the spring's share.
#[test]
fn a_soft_contact_gives_in_proportion_to_what_it_carries() {
    let law = Law::Contact {
        friction: 0.0,
        approach_m_s: 0.0,
        compliance: 0.5,
    };
    let response = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0];
    let mut soft = problem(&[law], &[-1.0, 0.0, 0.0], &response);
    solve(&mut soft);
    // -1 + 2 p + 0.5 p = 0.
    assert!((soft.impulses[0] - 0.4).abs() < 1e-8);
}

/// A sticking contact whose tangential compliance is a matrix, so that the impulse along either
/// tangent moves the other too: with w = 2 of the bodies, (w + 0.5) p_1 + 0.3 p_2 = -0.3 and 0.3
/// p_1 + (w + 0.8) p_2 = 0.2, that is p = (-0.9, 0.59) / 6.91. It comes after another law, so that
/// its rows are not the first.
#[test]
fn a_contact_that_gives_by_a_matrix_solves_both_tangents_together() {
    let mut both = ImpulseProblem::default();
    both.push(bearing(1.0), &[0.4]);
    both.push(contact(10.0), &[-1.0, 0.3, -0.2]);
    both.soften([0.5, 0.8]);
    both.couple(0.3);
    both.set_delassus(|row, w| {
        w.fill(0.0);
        w[row] = 2.0;
    });
    assert!(solve(&mut both) <= TOLERANCE);
    // Solved to 1e-8 m/s, which w makes 5e-9 N s.
    for (found, expected) in both
        .impulses
        .iter()
        .zip([-0.2, 0.5, -0.9 / 6.91, 0.59 / 6.91])
    {
        assert!((found - expected).abs() < 1e-8, "{:?}", both.impulses);
    }
}

/// A roller's end on a tilted robot: friction turns it so that it presses itself down, mu |W_nt| >
/// W_nn. An iteration that solves for the normal with the previous friction alternates between an
/// impulse and none.
#[test]
fn a_contact_that_its_friction_presses_down_or_lifts_is_solved() {
    for (coupling, sliding) in [(-1.061, 0.32), (-1.061, -0.32), (1.061, 0.32)] {
        let response = [
            0.54, coupling, 0.695, //
            coupling, 4.65, -2.4, //
            0.695, -2.4, 49.0,
        ];
        let free = [-0.0206, sliding, -0.0177];
        let mut problem = problem(&[contact(0.6)], &free, &response);
        assert!(solve(&mut problem) < 1e-8, "{coupling}, {sliding}");
        assert!(problem.impulses()[0] > 0.0);
        assert!(problem.velocities()[0].abs() < 1e-8);
    }
}

/// A dry bearing holds within its limit and opposes the motion beyond it: p = -clamp(free / w,
/// +-most).
#[test]
fn a_dry_bearing_holds_what_it_can() {
    for (free, most, impulse) in [(0.5, 0.2, -0.2), (0.5, 0.1, -0.1), (-0.5, 0.1, 0.1)] {
        let mut bearing = problem(&[bearing(most)], &[free], &[2.5]);
        assert!(solve(&mut bearing) <= TOLERANCE);
        assert!((bearing.impulses[0] - impulse).abs() < 1e-8);
    }
}

/// The solution may start from the impulses of the last step, on a floor that has become slippery
/// since: an impulse beyond friction's limit is no solution, although it holds the contact. By
/// hand: a block of mass m on a slope, held by p_t = m g sin dt, of which mu m g cos dt remains.
#[test]
fn a_start_beyond_the_cone_is_no_solution() {
    let (mass_kg, dt_s, slope) = (2.5, 2e-3, 0.3_f64);
    let response: Vec<f64> = (0..9)
        .map(|i| if i % 4 == 0 { 1.0 / mass_kg } else { 0.0 })
        .collect();
    let pulls = 9.81 * dt_s * slope.sin();
    let presses = 9.81 * dt_s * slope.cos();
    for mu in [0.1, 0.0] {
        let mut block = problem(&[contact(mu)], &[-presses, pulls, 0.0], &response);
        let held = Vector3::new(mass_kg * presses, -mass_kg * pulls, 0.0);
        // Set without projection into the cone: the residual must show it.
        held.iter()
            .enumerate()
            .for_each(|(row, p)| block.set(row, *p));
        let excess_m_s = pulls - mu * presses;
        assert!((block.error() - excess_m_s).abs() < 1e-12);
        assert!(solve(&mut block) <= TOLERANCE);
        let rubbed = block.contact_impulse(0).yz().norm();
        assert!((rubbed - mu * mass_kg * presses).abs() < 1e-7, "{rubbed}");

        block.warm_start(0, held);
        assert!(block.contact_impulse(0).yz().norm() <= mu * held.x);
    }
}

/// The same for a bearing whose friction has fallen.
#[test]
fn a_start_beyond_a_bearings_friction_is_no_solution() {
    let mut bearing = problem(&[bearing(0.1)], &[0.5], &[2.5]);
    bearing.set(0, -0.2);
    assert!((bearing.error() - 0.25).abs() < 1e-12);
    assert!(solve(&mut bearing) <= TOLERANCE);
    assert!((bearing.impulses[0] + 0.1).abs() < 1e-8);
}

/// The law that keeps a motor from driving beyond a rate removes as much of its impulse as needed,
/// and no more than it gives: a wheel with response w that would be u too fast loses min(u / w,
/// given); one that is too slow loses nothing.
#[test]
fn a_one_sided_joint_holds_one_way_only() {
    for (free, given, impulse) in [(0.5, 1.0, -0.2), (0.5, 0.1, -0.1), (-0.5, 1.0, 0.0)] {
        let limit = Law::Joint {
            least_n_m_s: -given,
            most_n_m_s: 0.0,
        };
        let mut limit = problem(&[limit], &[free], &[2.5]);
        assert!(solve(&mut limit) <= TOLERANCE);
        assert!((limit.impulses[0] - impulse).abs() < 1e-8);
    }
}

/// Four legs under one table, where three would do: they carry it together, whatever their shares.
#[test]
fn redundant_contacts_carry_the_load_together() {
    let legs = [[0.15, 0.16], [0.15, -0.16], [-0.15, 0.16], [-0.15, -0.16]];
    let (mass_kg, inertia) = (11.0, 0.2);
    let w = |i: usize, j: usize| {
        if !(i.is_multiple_of(3) && j.is_multiple_of(3)) {
            return if i == j { 1.0 / mass_kg } else { 0.0 };
        }
        let (a, b) = (legs[i / 3], legs[j / 3]);
        1.0 / mass_kg + (a[0] * b[0] + a[1] * b[1]) / inertia
    };
    let response: Vec<f64> = (0..144).map(|i| w(i / 12, i % 12)).collect();
    let fall: Vec<f64> = (0..12)
        .map(|i| if i % 3 == 0 { -0.02 } else { 0.0 })
        .collect();
    let mut table = problem(&[contact(0.6); 4], &fall, &response);
    assert!(solve(&mut table) <= TOLERANCE);
    let carried: f64 = (0..4).map(|leg| table.impulses[3 * leg]).sum();
    assert!((carried - 0.02 * mass_kg).abs() < 1e-6);
}

/// Random contacts and bearings, sticking, sliding, open and redundant: every law holds afterwards,
/// and so does u = u_free + W p. Fifteen rows on a robot with ten degrees of freedom.
#[test]
fn random_problems_are_solved_to_the_end() {
    let mut draw = Draw(2);
    let mut unsolved = 0;
    for _ in 0..500 {
        let mu = draw.next().abs();
        let mut laws = vec![contact(mu); 4];
        laws.extend([bearing(0.3 * draw.next().abs()); 3]);
        let free: Vec<f64> = (0..15).map(|_| draw.next()).collect();
        let response = draw.response(15, 10, 1e-3);
        let mut random = problem(&laws, &free, &response);
        let error = solve(&mut random);
        unsolved += usize::from(error > TOLERANCE);
        for row in 0..15 {
            let of_impulses: f64 = (0..15)
                .map(|k| response[row * 15 + k] * random.impulses[k])
                .sum();
            let apart = random.velocities[row] - free[row] - of_impulses;
            // Sums of some hundred terms of about 1e2.
            assert!(apart.abs() < 1e-10, "{apart:e}");
        }
        for at in [0, 3, 6, 9] {
            let (p, u) = (random.contact_impulse(at), random.contact_velocity(at));
            assert!(p.x >= 0.0 && p.yz().norm() <= mu * p.x * (1.0 + 1e-9));
            assert!(u.x >= -error - 1e-12 && p.x.min(u.x) <= error + 1e-12);
        }
    }
    // A random matrix is not a robot: some problems have no solution with friction, and some need
    // more iterations.
    assert!(unsolved <= 25, "{unsolved} of 500");
}

/// Contacts strongly coupled by friction beyond 1 may have no solution. The remaining impulses are
/// finite, no worse than those at the start, and the velocities are theirs: u = u_free + W p.
#[test]
fn where_there_is_no_solution_the_best_is_kept_with_its_velocities() {
    let mut draw = Draw(12);
    for case in 0..400 {
        let friction = 1.0 + 4.0 * draw.next().abs();
        let laws = [contact(friction); 5];
        let rows = 3 * laws.len();
        let response = draw.response(rows, 6, 0.0);
        let free: Vec<f64> = (0..rows).map(|_| draw.next()).collect();
        let mut jam = problem(&laws, &free, &response);
        let begun = jam.error();
        let error = solve(&mut jam);
        assert!(error <= begun, "case {case}: {error:e}");
        let left = jam.error();
        assert!(
            (left - error).abs() <= 1e-3 * error,
            "case {case}: {left:e}"
        );
        let most = jam.impulses.iter().fold(1.0, |most, p| p.abs().max(most));
        for (row, w) in response.chunks_exact(rows).enumerate() {
            let follows: f64 = w.iter().zip(&jam.impulses).map(|(w, p)| w * p).sum();
            // Rounding of Newton's method, from velocities of 1e6 m/s at most.
            let off_m_s = (free[row] + follows - jam.velocities[row]).abs();
            assert!(
                off_m_s < TOLERANCE * most,
                "case {case}: {off_m_s:e} in row {row}"
            );
        }
    }
}

/// A problem without a solution keeps its best state: solved again from there it never ends with a
/// greater error.
#[test]
fn what_is_solved_on_never_ends_with_a_greater_error() {
    let mut draw = Draw(2);
    let mut unsolved = 0;
    for _ in 0..100 {
        // Friction so high that some have no solution.
        let mu = 20.0 * draw.next().abs();
        let free: Vec<f64> = (0..15).map(|_| draw.next()).collect();
        let response = draw.response(15, 6, 0.0);
        let left_from = |impulses: &[f64]| {
            let mut random = problem(&[contact(mu); 5], &free, &response);
            for (law, start) in impulses.chunks_exact(3).enumerate() {
                random.warm_start(law, Vector3::from_row_slice(start));
            }
            let error = solve(&mut random);
            (error, random.impulses)
        };
        let (first, impulses) = left_from(&[]);
        let (then, _) = left_from(&impulses);
        // Within rounding: fifteen products of entries up to 6.
        let largest = impulses.iter().fold(0.0_f64, |most, p| p.abs().max(most));
        let most = first.max(TOLERANCE) + 2e-14 * largest;
        assert!(then <= most, "{then:e} after {first:e}, {largest:e}");
        unsolved += usize::from(first > TOLERANCE);
    }
    // The case occurs.
    assert!(unsolved > 0);
}

/// Four rollers under a robot, each of which slides in its own direction at 1 m/s, on a floor so
/// stiff that it deflects by a ten-thousandth of the robot's motion. The load shares are visible in
/// the velocities only by that: an error of 1e-6 m/s is a hundredth of the load, and sweeps
/// approach it by a ten-thousandth each.
#[test]
fn wheels_that_slide_share_their_load_on_a_stiff_floor() {
    let legs = [[0.15, 0.16], [0.15, -0.16], [-0.15, 0.16], [-0.15, -0.16]];
    let (mass_kg, inertia_kg_m2, height_m) = (11.4, [0.1, 0.2, 0.25], 0.06);
    // A roller turns easily about its axis, which lies at 45 degrees.
    let light = 200.0;
    let mut draw = Draw(5);
    for _ in 0..200 {
        let rows: Vec<[f64; 6]> = (0..12)
            .map(|row| {
                let leg = legs[row / 3];
                let side = if matches!(row / 3, 0 | 3) { 1.0 } else { -1.0 };
                let along = Vector3::new(1.0, side, 0.0).normalize();
                let axis = match row % 3 {
                    0 => Vector3::z(),
                    1 => along,
                    _ => Vector3::z().cross(&along),
                };
                let turn = Vector3::new(leg[0], leg[1], -height_m).cross(&axis);
                [axis.x, axis.y, axis.z, turn.x, turn.y, turn.z]
            })
            .collect();
        let w = |i: usize, j: usize| {
            let own = if i == j && i % 3 == 2 { light } else { 0.0 };
            let of_body = (0..6).map(|k| {
                let per = if k < 3 { mass_kg } else { inertia_kg_m2[k - 3] };
                rows[i][k] * rows[j][k] / per
            });
            of_body.sum::<f64>() + own
        };
        let response: Vec<f64> = (0..144).map(|i| w(i / 12, i % 12)).collect();
        // 10 ms of gravity, and each roller in its own direction.
        let free: Vec<f64> = (0..12)
            .map(|row| if row % 3 == 0 { -0.0981 } else { draw.next() })
            .collect();
        let law = Law::Contact {
            friction: 0.6,
            approach_m_s: 0.0,
            compliance: 9.1e-5,
        };
        let mut sliding = problem(&[law; 4], &free, &response);
        let error = solve(&mut sliding);
        assert!(error <= TOLERANCE, "{error:e}");
        let carried: f64 = (0..4).map(|leg| sliding.impulses[3 * leg]).sum();
        // Only the deflection of soft contacts by the load moves the robot down: 3e-5 m/s.
        let let_down = (carried / mass_kg - 0.0981).abs();
        assert!(let_down < 1e-4, "{let_down:e}");
    }
}

/// Ground with a nap: (direction among the tangents, friction across over along).
fn over_a_nap(
    laws: &[Law],
    free: &[f64],
    response: &[f64],
    (along, ratio): (Vector2<f64>, f64),
) -> ImpulseProblem {
    let mut problem = ImpulseProblem::default();
    let mut rest = free;
    for law in laws {
        let (own, others) = rest.split_at(law.rows());
        problem.push(*law, own);
        if matches!(law, Law::Contact { .. }) {
            problem.make_anisotropic(along, ratio);
        }
        rest = others;
    }
    problem.set_delassus(|row, w| w.copy_from_slice(&response[row * free.len()..][..w.len()]));
    problem
}

/// A block of 2 kg that falls at 0.4 m/s and slides at 1 m/s has friction mu along the nap and r mu
/// across it. At an angle its friction lies on the ellipse, and the remaining sliding velocity
/// along the ellipse's normal: u = -k (p_a / mu^2, p_c / (r mu)^2).
#[test]
fn friction_over_a_nap_lies_on_its_ellipse_and_takes_the_most_it_can() {
    let (mass_kg, fall, mu, ratio) = (2.0, 0.4, 0.3, 0.5);
    let response: Vec<f64> = (0..9)
        .map(|i| if i % 4 == 0 { 1.0 / mass_kg } else { 0.0 })
        .collect();
    let (y, x) = 0.4_f64.sin_cos();
    let (along, across) = (Vector2::new(x, y), Vector2::new(-y, x));
    let mut draw = Draw(11);
    for _ in 0..200 {
        let slide = Vector2::new(draw.next(), draw.next()).normalize();
        let free = [-fall, slide.x, slide.y];
        let mut block = over_a_nap(&[contact(mu)], &free, &response, (along, ratio));
        assert!(solve(&mut block) <= TOLERANCE);
        let (p, u) = (block.contact_impulse(0), block.contact_velocity(0).yz());
        let rubs = Vector2::new(p.yz().dot(&along), p.yz().dot(&across));
        let left = Vector2::new(u.dot(&along), u.dot(&across));
        assert!((p.x - mass_kg * fall).abs() < 1e-7);
        let size = (rubs.x / mu).hypot(rubs.y / (ratio * mu)) / p.x;
        // 2 kg at 1 m/s have 2 N s, and friction takes at most 0.24: it slides. Solved to 1e-8 m/s.
        assert!((size - 1.0).abs() < 1e-6, "{size}");
        let normal = -Vector2::new(rubs.x, rubs.y / (ratio * ratio)).normalize();
        assert!(left.perp(&normal).abs() < 1e-6 && left.dot(&normal) > 0.0);
        // No other impulse of the ellipse dissipates more.
        for step in 0..24 {
            let (s, c) = (f64::from(step) * 0.27).sin_cos();
            let other = (c * along + ratio * s * across) * mu * p.x;
            assert!(p.yz().dot(&u) <= other.dot(&u) + 1e-9);
        }
        // The solution belongs to the given problem: u = u_free + W p.
        assert!((u - slide - p.yz() / mass_kg).norm() < 1e-12);
    }
}

#[test]
fn random_problems_over_a_nap_never_gain_power() {
    let mut draw = Draw(3);
    let mut unsolved = 0;
    for _ in 0..500 {
        let (mu, ratio) = (draw.next().abs(), 2.0_f64.powf(2.0 * draw.next()));
        let (y, x) = (3.0 * draw.next()).sin_cos();
        let nap = (Vector2::new(x, y), ratio);
        let free: Vec<f64> = (0..12).map(|_| draw.next()).collect();
        let response = draw.response(12, 9, 1e-3);
        let mut random = over_a_nap(&[contact(mu); 4], &free, &response, nap);
        let error = solve(&mut random);
        unsolved += usize::from(error > TOLERANCE);
        for row in 0..12 {
            let of_impulses: f64 = (0..12)
                .map(|k| response[row * 12 + k] * random.impulses[k])
                .sum();
            let apart = random.velocities[row] - free[row] - of_impulses;
            // As without a nap; S and its inverse, of sizes up to 4, round once more.
            assert!(apart.abs() < 1e-9, "{apart:e}");
        }
        for at in [0, 3, 6, 9] {
            let (p, u) = (random.contact_impulse(at), random.contact_velocity(at));
            let disc = random.anisotropies.in_disc(at + 1, p.yz());
            assert!(disc.norm() <= mu * p.x * (1.0 + 1e-9));
            // The velocity of a sticking contact is the error, which S scales by up to 4.
            assert!(p.yz().dot(&u.yz()) <= 8.0 * error * p.yz().norm() + 1e-12);
        }
    }
    // As without a nap.
    assert!(unsolved <= 25, "{unsolved} of 500");
}

/// Rotated tangents with a nap rotated back by the same angle describe the same contact.
#[test]
fn a_nap_turned_against_the_tangents_is_the_same() {
    let mut draw = Draw(4);
    let response = draw.response(3, 3, 0.1);
    let free = [-0.5, 0.8, 0.3];
    let turn = |angle: f64, of: Vector2<f64>| {
        let (s, c) = angle.sin_cos();
        Vector2::new(c * of.x - s * of.y, s * of.x + c * of.y)
    };
    let found = |angle: f64| {
        let w = nalgebra::Matrix3::from_row_slice(&response);
        let (s, c) = angle.sin_cos();
        let r = nalgebra::Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
        let (turned, u) = (r * w * r.transpose(), r * Vector3::from(free));
        let nap = (turn(angle, Vector2::new(0.8, 0.6)), 0.4);
        let mut problem = over_a_nap(
            &[contact(0.3)],
            u.as_slice(),
            turned.transpose().as_slice(),
            nap,
        );
        assert!(solve(&mut problem) <= TOLERANCE);
        let p = problem.contact_impulse(0);
        (p.x, turn(-angle, p.yz()))
    };
    let (normal, rubs) = found(0.0);
    for angle in [0.3, 1.2, 2.5] {
        let (other_normal, other) = found(angle);
        assert!((other_normal - normal).abs() < 1e-7 && (other - rubs).norm() < 1e-7);
    }
}

fn slide([least_m_s, most_m_s]: [f64; 2]) -> Law {
    Law::Slide {
        least_m_s,
        most_m_s,
    }
}

/// A bead of 0.5 kg on a rod moves on, or is stopped at a stop in the step.
#[test]
fn a_bead_between_stops_does_what_follows_on_paper() {
    for (free, impulse, left) in [
        (0.3, 0.0, 0.3),
        (-0.3, 0.0, -0.3),
        (0.9, -0.2, 0.5),
        (-0.9, 0.25, -0.4),
    ] {
        let mut bead = problem(&[slide([-0.4, 0.5])], &[free], &[2.0]);
        assert!(solve(&mut bead) <= TOLERANCE);
        assert!((bead.impulses[0] - impulse).abs() < 1e-8, "{free}");
        assert!((bead.velocities[0] - left).abs() < 2e-8, "{free}");
        assert_eq!(bead.holds(0), impulse != 0.0);
    }
}

/// A roller on the ground with play, random: the floor's force along its tilted axle moves a light
/// row of its own, of 100 1/kg. The contact's laws hold, and those of the stops: between them the
/// row has no impulse, at one the impulse pushes it back from there.
#[test]
fn a_contact_with_play_is_solved_wherever_the_roller_is_between_its_stops() {
    const OWN_1_KG: f64 = 100.0;
    let mut draw = Draw(11);
    let mut stopped = 0;
    for _ in 0..300 {
        let robot = draw.response(3, 6, 0.05);
        let lean = 0.25 * draw.next();
        let along = [lean, (1.0 - lean * lean).sqrt(), 0.0, 1.0];
        let response: Vec<f64> = (0..16)
            .map(|k| {
                let (i, j) = (k / 4, k % 4);
                let of_robot = if i < 3 && j < 3 {
                    robot[3 * i + j]
                } else {
                    0.0
                };
                of_robot + OWN_1_KG * along[i] * along[j]
            })
            .collect();
        let (least_m_s, most_m_s) = (-draw.next().abs(), draw.next().abs());
        // It comes down, and the roller rests on its axle.
        let free = [
            -0.3 * draw.next().abs(),
            0.3 * draw.next(),
            0.3 * draw.next(),
            0.0,
        ];
        let laws = [contact(0.6), slide([least_m_s, most_m_s])];
        let mut problem = problem(&laws, &free, &response);
        assert!(solve(&mut problem) <= TOLERANCE);
        let (p, u) = (problem.contact_impulse(0), problem.contact_velocity(0));
        assert!(p.yz().norm() <= 0.6 * p.x * (1.0 + 1e-9) && p.yz().dot(&u.yz()) <= 1e-9);
        let (impulse, rate_m_s) = (problem.impulses[3], problem.velocities[3]);
        // Solved to 1e-8 m/s.
        let near = 1e-7;
        let held = if rate_m_s < least_m_s + near {
            impulse >= -near / OWN_1_KG
        } else if rate_m_s > most_m_s - near {
            impulse <= near / OWN_1_KG
        } else {
            impulse.abs() <= near / OWN_1_KG
        };
        assert!(held && (least_m_s - near..most_m_s + near).contains(&rate_m_s));
        stopped += usize::from(impulse.abs() > near);
    }
    // Both cases occur.
    assert!((30..270).contains(&stopped), "{stopped}");
}
