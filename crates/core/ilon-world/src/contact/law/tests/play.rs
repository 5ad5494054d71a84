//! Rollers that slide along their axles, on floors that drag and creep.

use nalgebra::{SVector, Vector3};

use super::super::system::{TOLERANCE, pair};
use super::super::{ImpulseProblem, Law};
use super::{Draw, bearing, solve};

/// Rates: the robot's six, and of each of four wheels those of hub and roller about their axes, and
/// of the roller along its own.
type Rates = SVector<f64, 18>;

/// A robot of 11 kg on four rollers of 10 g in a step of 1 ms.
struct Robot {
    laws: Vec<Law>,
    rows: Vec<Rates>,
    free: Vec<f64>,
    /// Addition by creep along each tangent, in m/s per N s.
    creeps: f64,
}

const MASSES: [f64; 6] = [11.4, 11.4, 11.4, 0.1, 0.2, 0.25];
const HUB_KG_M2: f64 = 5e-3;
const SPIN_KG_M2: f64 = 5e-7;
const ROLLER_KG: f64 = 0.01;
const STEP_S: f64 = 1e-3;

impl Robot {
    fn drawn(draw: &mut Draw, (drag, creep): (f64, f64)) -> Self {
        const RADIUS_M: f64 = 0.06;
        const THICK_M: f64 = 0.01;
        const LOAD_N: f64 = 28.0;
        let legs = [[0.15, 0.16], [0.15, -0.16], [-0.15, 0.16], [-0.15, -0.16]];
        let (mut laws, mut rows) = (Vec::new(), Vec::new());
        let friction = 0.2 + 0.6 * draw.next().abs();
        for (wheel, leg) in legs.into_iter().enumerate() {
            let side = if matches!(wheel, 0 | 3) { 1.0 } else { -1.0 };
            let along = Vector3::new(1.0, side, 0.0).normalize();
            let across = Vector3::z().cross(&along);
            // It leans as it rolls on.
            let (up, level) = (0.2 * draw.next()).sin_cos();
            let axle = level * along + up * Vector3::z();
            let [hub, spin, slide] = [6, 7, 8].map(|of| of + 3 * wheel);
            // The hub's rate at the contact point, in a direction.
            let of_hub = |way: &Vector3<f64>| {
                let turn = Vector3::new(leg[0], leg[1], -RADIUS_M).cross(way);
                let mut rates = Rates::zeros();
                rates.fixed_rows_mut::<3>(0).copy_from(way);
                rates.fixed_rows_mut::<3>(3).copy_from(&turn);
                rates[hub] = -RADIUS_M * way.x;
                rates
            };
            let mut slides = -of_hub(&axle);
            slides[slide] = 1.0;
            // The roller moves with its hub, except along its axle.
            rows.extend([Vector3::z(), along, across].map(|way| {
                let mut rates = of_hub(&way) + way.dot(&axle) * slides;
                rates[spin] += THICK_M * way.dot(&across);
                rates
            }));
            laws.push(Law::Contact {
                friction,
                approach_m_s: 0.0,
                compliance: 0.1,
            });
            if drag > 0.0 {
                let mut turns = Rates::zeros();
                turns[hub] = -RADIUS_M * along.x;
                let mut spins = Rates::zeros();
                (spins[hub], spins[spin]) = (THICK_M * along.y, THICK_M);
                rows.extend([turns, spins]);
                laws.push(Law::Disc {
                    most_n_s: drag * LOAD_N * STEP_S,
                });
            }
            let mut spins = Rates::zeros();
            spins[spin] = 1.0;
            rows.extend([slides, spins]);
            // A play of up to 0.5 mm to either side, often at one of its ends.
            let least_m_s = -0.5 * draw.next().max(0.0);
            let most_m_s = 0.5 * draw.next().max(0.0);
            laws.push(Law::Slide {
                least_m_s,
                most_m_s,
            });
            laws.push(bearing(1e-6));
        }
        let mut rates = Rates::from_fn(|_, _| 0.3 * draw.next());
        rates[2] = -9.81 * STEP_S;
        rates.fixed_rows_mut::<2>(3).scale_mut(0.1);
        for wheel in 0..4 {
            rates[6 + 3 * wheel] *= 1.0 / RADIUS_M;
            rates[7 + 3 * wheel] *= 1.0 / THICK_M;
        }
        Self {
            laws,
            free: rows.iter().map(|row| row.dot(&rates)).collect(),
            rows,
            creeps: creep / LOAD_N * 0.3 / STEP_S,
        }
    }

    fn problem(&self) -> ImpulseProblem {
        let mut problem = ImpulseProblem::default();
        let mut rest = &self.free[..];
        for law in &self.laws {
            let (own, others) = rest.split_at(law.rows());
            problem.push(*law, own);
            if matches!(law, Law::Contact { .. }) {
                problem.soften([self.creeps; 2]);
            }
            rest = others;
        }
        let moves = Rates::from_fn(|rate, _| match rate.checked_sub(6) {
            None => 1.0 / MASSES[rate],
            Some(of_wheel) => 1.0 / [HUB_KG_M2, SPIN_KG_M2, ROLLER_KG][of_wheel % 3],
        });
        problem.set_delassus(|row, w| {
            let by = self.rows[row].component_mul(&moves);
            for (w, other) in w.iter_mut().zip(&self.rows) {
                *w = by.dot(other);
            }
        });
        problem
    }
}

/// Each of the four rollers is in the air, sticks or slides on the floor, turns or not, and lies at
/// one of its stops or at neither.
#[test]
fn rollers_with_play_are_solved_where_the_floor_drags_and_creeps_and_never_gain_power() {
    let mut draw = Draw(7);
    let mut unsolved = 0;
    for (drag, creep) in [(0.0, 0.0), (0.1, 0.0), (0.0, 0.2), (0.1, 0.2), (5.0, 100.0)] {
        let (mut pressed, mut stopped, mut free) = (0, 0, 0);
        for _ in 0..300 {
            let robot = Robot::drawn(&mut draw, (drag, creep));
            let mut problem = robot.problem();
            let error = solve(&mut problem);
            let near = error + 1e-12;
            unsolved += usize::from(error > TOLERANCE);
            for (at, law) in problem.laws.clone() {
                let (p, u) = (problem.impulses[at], problem.velocities[at]);
                let rubs = |first: usize, limit: f64| {
                    let (p, u) = (
                        pair(&problem.impulses, first),
                        pair(&problem.velocities, first),
                    );
                    assert!(p.norm() <= limit * (1.0 + 1e-9));
                    assert!(p.dot(&u) <= error * p.norm() + 1e-12, "{p} {u}");
                };
                match law {
                    Law::Contact { friction, .. } => {
                        assert!(p >= 0.0);
                        pressed += usize::from(p > 0.0);
                        rubs(at + 1, friction * p);
                    }
                    Law::Disc { most_n_s } => rubs(at, most_n_s),
                    Law::Joint { .. } => assert!(p * u <= error * p.abs() + 1e-15),
                    Law::Curve { .. } => unreachable!("no curve is drawn here"),
                    Law::Slide {
                        least_m_s,
                        most_m_s,
                    } => {
                        assert!((least_m_s - near..=most_m_s + near).contains(&u), "{u}");
                        // It is pushed only away from the stop at which it lies.
                        let from = if p > 0.0 { least_m_s } else { most_m_s };
                        let pushed = p.abs() > TOLERANCE * ROLLER_KG;
                        assert!(!pushed || error > TOLERANCE || (u - from).abs() <= TOLERANCE);
                        (stopped, free) =
                            (stopped + usize::from(pushed), free + usize::from(!pushed));
                    }
                }
            }
        }
        // All cases occur.
        let tried = [pressed, stopped, free];
        assert!(tried.iter().all(|times| *times > 300), "{tried:?}");
    }
    // Most random problems are not steps of a robot: of 1500 this many may stay unsolved.
    assert!(unsolved <= 15, "{unsolved}");
}
