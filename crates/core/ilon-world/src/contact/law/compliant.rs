//! Newton's step where every law is that of a compliant contact: tyres.
//!
//! There W = Z Z^T + C, with a row of Z for each row of W, its half solution by degree of freedom
//! of the bodies, and C the diagonal of tangential compliance. The derivative of F is then E + B Z
//! Z^T, E and B with a block of three rows for each contact, and E regular because the contact
//! gives. With G = E^-1 B and y = Z^T dp the step is
//!
//! dp = -E^-1 F - G Z y,  (1 + Z^T G Z) y = -Z^T E^-1 F:
//!
//! a system of as many rows as the bodies have degrees of freedom, and not three for each contact.

use nalgebra::{Matrix3, Vector3};

use super::kinds::Law;
use super::system::ImpulseProblem;
use crate::contact::linear::solve_in_place;

/// The least compliance relative to the row's own response: with less, rounding would exceed that
/// of the whole system. Chosen.
const LEAST: f64 = 1e-6;

/// Work space of the step.
#[derive(Clone, Debug, Default)]
pub(super) struct CompliantStep {
    /// 1 + Z^T G Z, and y.
    system: Vec<f64>,
    rates: Vec<f64>,
    /// G.
    gains: Vec<Matrix3<f64>>,
    /// The degrees of freedom of a contact, and its three entries of Z for each.
    moves: Vec<(usize, Vector3<f64>)>,
}

impl CompliantStep {
    /// Whether all laws are those of compliant contacts whose half solutions are known.
    pub fn applies(problem: &ImpulseProblem) -> bool {
        let gives = |&(at, law): &(usize, Law)| match law {
            Law::Contact { compliance, .. } => {
                let [_, first, second] = [0, 1, 2].map(|k| problem.softness[at + k]);
                compliance > LEAST * problem.w(at, at)
                    && first > LEAST * problem.w(at + 1, at + 1)
                    && second > LEAST * problem.w(at + 2, at + 2)
            }
            _ => false,
        };
        !problem.halves.is_empty() && problem.laws.iter().all(gives)
    }

    /// Finds the step from F = `missing`. Returns whether there is one.
    pub fn find(&mut self, problem: &ImpulseProblem, missing: &[f64], step: &mut Vec<f64>) -> bool {
        let dofs = problem.halves.len() / missing.len().max(1);
        self.system.clear();
        self.system.resize(dofs * dofs, 0.0);
        self.system
            .iter_mut()
            .step_by(dofs + 1)
            .for_each(|own| *own = 1.0);
        self.rates.clear();
        self.rates.resize(dofs, 0.0);
        self.gains.clear();
        step.clear();
        for &(at, law) in &problem.laws {
            let (own, coupled) = problem.blocks(at, law);
            let Some(inverse) = own.try_inverse() else {
                return false;
            };
            let gain = inverse * coupled;
            let alone = inverse * -Vector3::from_row_slice(&missing[at..at + 3]);
            self.gains.push(gain);
            step.extend(alone.iter());
            self.moves.clear();
            self.moves.extend(moves(problem, at));
            for (dof, z) in &self.moves {
                let gained = gain * z;
                self.rates[*dof] += z.dot(&alone);
                for (by, z) in &self.moves {
                    self.system[by * dofs + dof] += z.dot(&gained);
                }
            }
        }
        if !solve_in_place(&mut self.system, &mut self.rates) {
            return false;
        }
        for ((at, _), gain) in problem.laws.iter().zip(&self.gains) {
            let moved: Vector3<f64> = moves(problem, *at)
                .map(|(dof, z)| z * self.rates[dof])
                .sum();
            for (step, back) in step[*at..].iter_mut().zip(&(gain * moved)) {
                *step -= back;
            }
        }
        step.iter().all(|step| step.is_finite())
    }
}

/// The degrees of freedom that a contact moves, and its entries of Z for each.
fn moves(problem: &ImpulseProblem, at: usize) -> impl Iterator<Item = (usize, Vector3<f64>)> {
    // The last joints first, which the bodies' other joints do not couple with.
    let columns = problem.halves.chunks_exact(problem.rows()).rev();
    let entries = columns.map(move |column| Vector3::from_row_slice(&column[at..at + 3]));
    entries.enumerate().filter(|(_, z)| *z != Vector3::zeros())
}
