//! Newton's step through the bodies' degrees of freedom.

use super::super::compliant::CompliantStep;
use super::super::{ImpulseProblem, Law};
use super::Draw;
use crate::contact::linear::solve_in_place;

/// Both solve the same equations, dF dp = -F: at random impulses, at which contacts stick, slide
/// and open. Without half solutions and with a bearing there is no such step.
#[test]
fn the_step_through_degrees_of_freedom_is_newtons() {
    const CONTACTS: usize = 5;
    const ROWS: usize = 3 * CONTACTS;
    let mut draw = Draw(61);
    let mut open = 0;
    for _ in 0..200 {
        let dofs = 6;
        let halves: Vec<f64> = (0..dofs * ROWS).map(|_| draw.next()).collect();
        let mut problem = ImpulseProblem::default();
        for _ in 0..CONTACTS {
            let law = Law::Contact {
                friction: draw.next().abs(),
                approach_m_s: 0.1 * draw.next(),
                compliance: 0.01 + draw.next().abs(),
            };
            problem.push(law, &[draw.next(), draw.next(), draw.next()]);
            problem.soften([0.01 + draw.next().abs(), 0.01 + draw.next().abs()]);
        }
        let product = |row: usize, other: usize| -> f64 {
            let columns = halves.chunks_exact(ROWS);
            columns.map(|column| column[row] * column[other]).sum()
        };
        problem.set_delassus(|row, w| {
            for (other, w) in w.iter_mut().enumerate() {
                *w = product(row, other);
            }
        });
        assert!(!CompliantStep::applies(&problem));
        problem.set_halves(&halves);
        assert!(CompliantStep::applies(&problem));
        for row in 0..ROWS {
            problem.set(row, draw.next());
        }
        let (mut missing, mut matrix) = (vec![0.0; ROWS], vec![0.0; ROWS * ROWS]);
        problem.residual(&mut missing, Some(&mut matrix));
        open += matrix
            .chunks_exact(ROWS)
            .filter(|line| line.iter().filter(|entry| **entry != 0.0).count() == 1)
            .count();
        let mut expected: Vec<f64> = missing.iter().map(|missing| -missing).collect();
        assert!(solve_in_place(&mut matrix, &mut expected));
        let mut step = Vec::new();
        assert!(CompliantStep::default().find(&problem, &missing, &mut step));
        let largest = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (step, expected) in step.iter().zip(&expected) {
            // Rounding, times the condition of random systems.
            assert!(
                (step - expected).abs() < 1e-9 * largest,
                "{step} {expected}"
            );
        }
    }
    assert!(open > 100, "{open} rows of open contacts");
    let mut problem = ImpulseProblem::default();
    problem.push(super::bearing(1.0), &[0.1]);
    problem.set_delassus(|_, w| w.fill(1.0));
    problem.set_halves(&[1.0]);
    assert!(!CompliantStep::applies(&problem));
}
