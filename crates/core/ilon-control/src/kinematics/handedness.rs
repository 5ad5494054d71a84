//! Checks whether the handedness of the wheels fits their places.
//!
//! Mecanum wheels come in two hands. Mounted in the usual X, each row of M has the largest moment
//! that its wheel can have, and the columns of M are orthogonal: by Hadamard's inequality no other
//! choice of hands gives M^T M a larger determinant. Exchanged wheels make an O, whose lever for
//! rotation is the difference of the arms instead of their sum: 10 mm instead of 310 mm on a robot
//! that is nearly square. Such a robot is singular only if the arms are equal, so the rank alone
//! does not show it.
//!
//! sqrt(det M^T M) is the product of the singular values of M. A change of the reference point
//! shears M by a matrix of determinant 1 and leaves it unchanged.

use std::fmt;

use ilon_robot::Wheel;
use nalgebra::{Matrix3, Vector2};

use crate::kinematics::matrix::row_of_m;
use crate::kinematics::singularity::{RANK_TOLERANCE, quoted};

/// Wheels count as exchanged if reversing the hand of some of them improves the product by this
/// factor.
const CLEARLY: f64 = 1.2;
/// Choices whose products differ by less than this share count as equal.
const ALIKE: f64 = 1e-6;
/// Up to this many wheels with a hand all choices are tried; beyond, only single wheels and all.
const MOST_WHEELS: usize = 8;
/// A wheel whose rollers lean by less than this has no hand, in radians.
const STRAIGHT_RAD: f64 = 1e-3;

/// Wheels whose hand does not fit their place.
#[derive(Clone, Debug, PartialEq)]
pub struct WrongHands {
    /// The lever with which the wheels rotate the robot, in metres: the mean rim speed of a wheel,
    /// in m/s, per rad/s, about the point where rotation costs least. For mecanum wheels in the X
    /// it is the sum of the two arms.
    pub lever_m: f64,
    /// The same lever with fitting hands.
    pub fitting_lever_m: f64,
    /// The wheels whose hand must be reversed.
    pub reversed: Vec<String>,
    /// Pairs of these with opposite hands: exchanging their places has the same effect. Empty if
    /// not all can be paired.
    pub exchanged: Vec<[String; 2]>,
}

impl WrongHands {
    /// Returns the wheels that would work clearly better with reversed hands; `None` if there are
    /// none.
    pub fn of(wheels: &[Wheel]) -> Option<Self> {
        let own = size(wheels);
        let choices = other_hands(wheels);
        let sizes: Vec<f64> = choices.iter().map(|of| size(&handed(wheels, of))).collect();
        let most = sizes.iter().copied().fold(0.0, f64::max);
        // A singular arrangement has its own error.
        if own <= RANK_TOLERANCE * most || most < CLEARLY * own {
            return None;
        }
        // The smallest change among the equally good ones.
        let good = choices.iter().zip(&sizes);
        let good = good.filter(|(_, size)| **size >= most * (1.0 - ALIKE));
        let (reversed, _) = good.min_by_key(|(of, _)| of.len())?;
        Some(Self {
            lever_m: turning_lever_m(wheels),
            fitting_lever_m: turning_lever_m(&handed(wheels, reversed)),
            exchanged: exchanged(wheels, reversed),
            reversed: reversed.iter().map(|&i| wheels[i].name.clone()).collect(),
        })
    }
}

impl fmt::Display for WrongHands {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let swaps: Vec<String> = self.exchanged.iter().map(|pair| quoted(pair)).collect();
        let change = match &swaps[..] {
            [] => format!("{} handed the other way", quoted(&self.reversed)),
            swaps => format!("{} exchanged", swaps.join(" and ")),
        };
        write!(
            f,
            "their handedness does not fit their places: the lever with which they turn the robot is {:.1} mm; with {change} it is {:.1} mm; change the wheels on the robot, or their angles in the file",
            1e3 * self.lever_m,
            1e3 * self.fitting_lever_m
        )
    }
}

/// Returns all sets of wheels whose hands could be reversed, each by the wheels' indices, without
/// wheels that have no hand.
pub fn other_hands(wheels: &[Wheel]) -> Vec<Vec<usize>> {
    let has_hand = |i: &usize| wheels[*i].gamma_rad.abs() > STRAIGHT_RAD;
    let handed: Vec<usize> = (0..wheels.len()).filter(has_hand).collect();
    if handed.len() > MOST_WHEELS {
        let singles = handed.iter().map(|&i| vec![i]);
        return singles.chain([handed.clone()]).collect();
    }
    let choice = |bits: u32| {
        let of = handed.iter().enumerate();
        let of = of.filter(|(place, _)| bits >> place & 1 == 1);
        of.map(|(_, &i)| i).collect()
    };
    (1..1_u32 << handed.len()).map(choice).collect()
}

/// Returns the wheels with the hands of some of them reversed.
pub fn handed(wheels: &[Wheel], reversed: &[usize]) -> Vec<Wheel> {
    let mut wheels = wheels.to_vec();
    for &i in reversed {
        wheels[i].gamma_rad = -wheels[i].gamma_rad;
    }
    wheels
}

/// Returns pairs of wheels with opposite hands, each with the nearest one left; empty if not all
/// can be paired.
fn exchanged(wheels: &[Wheel], reversed: &[usize]) -> Vec<[String; 2]> {
    /// Wheels whose angles differ by less than this are of one kind, in radians.
    const SAME_RAD: f64 = 0.02;
    let mut left = reversed.to_vec();
    let mut pairs = Vec::new();
    while let Some(first) = (!left.is_empty()).then(|| left.remove(0)) {
        let own = &wheels[first];
        let apart_m = |i: usize| (wheels[i].position_m() - own.position_m()).norm();
        let fits = |i: &usize| (wheels[*i].gamma_rad + own.gamma_rad).abs() < SAME_RAD;
        let nearest = (0..left.len()).filter(|&place| fits(&left[place]));
        let nearest = nearest.min_by(|&p, &q| apart_m(left[p]).total_cmp(&apart_m(left[q])));
        let Some(place) = nearest else {
            return Vec::new();
        };
        let second = left.remove(place);
        pairs.push([first, second].map(|i| wheels[i].name.clone()));
    }
    pairs
}

/// M^T M about the wheels' middle.
fn gram(wheels: &[Wheel]) -> Matrix3<f64> {
    let sum: Vector2<f64> = wheels.iter().map(|w| w.position_m().xy()).sum();
    let mean_m = sum / wheels.len() as f64;
    let rows = wheels.iter().map(|w| row_of_m(w, mean_m));
    rows.map(|row| row.transpose() * row).sum()
}

/// Returns the product of the singular values of M, in metres.
fn size(wheels: &[Wheel]) -> f64 {
    gram(wheels).determinant().max(0.0).sqrt()
}

/// sqrt(det M^T M / det M_l^T M_l) is the length of the part of M_a orthogonal to M_l; dividing by
/// the length of the column of cos(gamma) makes it per wheel.
fn turning_lever_m(wheels: &[Wheel]) -> f64 {
    let gram = gram(wheels);
    let linear = gram.fixed_view::<2, 2>(0, 0).determinant();
    let cosines: f64 = wheels.iter().map(|w| libm::cos(w.gamma_rad).powi(2)).sum();
    let square = gram.determinant() / linear / cosines;
    if square.is_finite() {
        square.max(0.0).sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::robots::{MECANUM_HANDEDNESS, mecanum4_specs, robot, six_wheels, volksbot};

    #[test]
    fn an_o_is_told_with_both_levers() {
        let o = robot(10.0, &mecanum4_specs(-MECANUM_HANDEDNESS));
        let found = WrongHands::of(&o.wheels).unwrap();
        // Arms of 0.15 and 0.16 m: their difference, and their sum.
        assert!((found.lever_m - 0.01).abs() < 1e-12, "{found:?}");
        assert!((found.fitting_lever_m - 0.31).abs() < 1e-12, "{found:?}");
        assert_eq!(found.exchanged.len(), 2, "{found:?}");
        let x = robot(10.0, &mecanum4_specs(MECANUM_HANDEDNESS));
        assert_eq!(WrongHands::of(&x.wheels), None);
    }

    #[test]
    fn an_exchanged_axle_and_a_single_wheel_are_told() {
        let mut specs = mecanum4_specs(MECANUM_HANDEDNESS);
        specs[0].gamma_rad *= -1.0;
        let one = WrongHands::of(&robot(10.0, &specs).wheels).unwrap();
        assert_eq!(one.reversed.len(), 1);
        assert!(one.exchanged.is_empty());
        specs[1].gamma_rad *= -1.0;
        let axle = robot(10.0, &specs);
        let found = WrongHands::of(&axle.wheels).unwrap();
        let names = [0, 1].map(|i| axle.wheels[i].name.clone());
        assert_eq!(found.exchanged, vec![names]);
        // About the point where rotation costs least, the arm across does not count: 0.15 m of 0.31
        // m are left.
        assert!((found.lever_m - 0.15).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn robots_as_they_are_built_are_not_doubted() {
        // The longest and the widest mecanum robots: the difference of the arms is 80 % of their
        // sum at 9 : 1, and still detected.
        for (x_m, y_m) in [(0.45_f64, 0.05_f64), (0.05, 0.45), (0.2, 0.2)] {
            let mut specs = mecanum4_specs(MECANUM_HANDEDNESS);
            for spec in &mut specs {
                (spec.x_m, spec.y_m) = (x_m.copysign(spec.x_m), y_m.copysign(spec.y_m));
            }
            assert_eq!(WrongHands::of(&robot(10.0, &specs).wheels), None);
            specs.iter_mut().for_each(|spec| spec.gamma_rad *= -1.0);
            let o = WrongHands::of(&robot(10.0, &specs).wheels);
            // A robot of equal arms is singular, which has its own error.
            assert_eq!(o.is_some(), x_m != y_m, "{o:?}");
        }
        assert_eq!(WrongHands::of(&volksbot().wheels), None);
        assert_eq!(WrongHands::of(&six_wheels().wheels), None);
        // A third axle in the middle, with the hands of the one ahead.
        let mut specs = mecanum4_specs(MECANUM_HANDEDNESS);
        let middle = specs[..2].to_vec();
        specs.extend(middle.into_iter().map(|mut spec| {
            spec.x_m = 0.0;
            spec
        }));
        assert_eq!(WrongHands::of(&robot(10.0, &specs).wheels), None);
    }
}
