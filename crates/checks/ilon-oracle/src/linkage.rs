//! Forces in the joints between bodies.
//!
//! Symbols: W, the acceleration of a joint per unit of torque or force in it, with all else free;
//! Omega, the angular frequency at which the robot bounces on the floor's springs. Besides spring
//! and damper there are:
//!
//! - **a stop**: a spring with a damper that only pushes, of the stiffness Omega^2 / W. Beyond it
//!   the joint oscillates as fast as the robot on the floor, with a damping ratio of 0.7;
//! - **dry friction**: a bristle of 2/3 of that stiffness with a damping ratio of 0.5, in series
//!   with a slider, as on the floor;
//! - **a coupling**: a spring with a damper on the deviation between the two joints, with stiffness
//!   and damping from its own W.
//!
//! All tend to rigid stops, Coulomb friction and rigid gears as the floor's stiffness grows.

use ilon_robot::Robot;
use nalgebra::Vector2;

use crate::ContactLaw;
use crate::dynamics::ArrowSystem;
use crate::error::OracleError;
use crate::forces::{Forces, Prescribed};
use crate::generalised::Generalised;
use crate::posture::Posture;
use crate::tree::Tree;

/// Damping ratio of oscillations on stops and couplings; chosen.
const STOP_DAMPING_RATIO: f64 = 0.7;
/// A bristle's stiffness over a stop's, and its damping ratio; both as on the floor.
const BRISTLE_SHARE: f64 = 2.0 / 3.0;
const BRISTLE_DAMPING_RATIO: f64 = 0.5;

/// A spring and its damper.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sprung {
    pub stiffness: f64,
    pub damping: f64,
}

/// The stiff elements of all joints.
#[derive(Clone, Debug)]
pub(crate) struct Linkage {
    /// Of each joint.
    pub stops: Vec<Sprung>,
    bristles: Vec<Sprung>,
    /// Of each coupling.
    couplings: Vec<Sprung>,
    /// The deflection of each joint's bristle, in rad or m.
    bends: Vec<f64>,
    /// W of each joint and of each coupling.
    pub responses: Vec<f64>,
    coupled: Vec<f64>,
}

fn sprung(omega: f64, response: f64, damping_ratio: f64) -> Sprung {
    Sprung {
        stiffness: omega * omega / response,
        damping: 2.0 * damping_ratio * omega / response,
    }
}

impl Linkage {
    pub fn new(tree: &Tree, robot: &Robot, law: &ContactLaw) -> Result<Self, OracleError> {
        let on_each_kg = robot.mass_kg() / robot.wheels.len() as f64;
        let omega = (law.normal_stiffness_n_m / on_each_kg).sqrt();
        let no_inertia = |joint: usize| {
            let part = tree.joints[joint].law.name.clone();
            OracleError::NoInertia { part }
        };
        let gained = |along: &[(usize, f64)]| {
            let gained = response(tree, along).filter(|w| w.is_finite() && *w > 0.0);
            gained.ok_or_else(|| no_inertia(along[0].0))
        };
        let responses: Vec<f64> = (0..tree.joints.len())
            .map(|joint| gained(&[(joint, 1.0)]))
            .collect::<Result<_, _>>()?;
        let coupled: Vec<f64> = (tree.couplings.iter())
            .map(|of| gained(&[(of.joint, 1.0), (of.follows, -of.factor)]))
            .collect::<Result<_, _>>()?;
        let bristle_omega = omega * BRISTLE_SHARE.sqrt();
        let stiff = |w: &f64| sprung(omega, *w, STOP_DAMPING_RATIO);
        Ok(Self {
            stops: responses.iter().map(stiff).collect(),
            bristles: (responses.iter())
                .map(|w| sprung(bristle_omega, *w, BRISTLE_DAMPING_RATIO))
                .collect(),
            couplings: coupled.iter().map(stiff).collect(),
            bends: vec![0.0; tree.joints.len()],
            responses,
            coupled,
        })
    }

    /// The sums of k W and of c W over all elements in joints: upper bounds of the square of the
    /// fastest frequency, and of its damping.
    pub fn stiffest(&self, tree: &Tree) -> (f64, f64) {
        let mut sums = (0.0, 0.0);
        let mut add = |of: &Sprung, w: f64| {
            sums.0 += of.stiffness * w;
            sums.1 += of.damping * w;
        };
        for (i, joint) in tree.joints.iter().enumerate() {
            let w = self.responses[i];
            let own = Sprung {
                stiffness: joint.law.spring().map_or(0.0, |spring| spring.stiffness),
                damping: joint.law.damping,
            };
            add(&own, w);
            if joint.law.limits.iter().any(|limit| limit.is_finite()) {
                add(&self.stops[i], w);
            }
            if joint.law.friction > 0.0 {
                add(&self.bristles[i], w);
            }
        }
        for (of, w) in self.couplings.iter().zip(&self.coupled) {
            add(of, *w);
        }
        sums
    }

    /// Adds the forces in joints over a step of `h` seconds at these positions and rates to
    /// `forces`, writes the dissipative part into `losses`, and returns the heat of dry friction,
    /// in J.
    pub fn act(
        &mut self,
        tree: &Tree,
        (positions, rates): (&[f64], &[f64]),
        h: f64,
        (forces, losses): (&mut [f64], &mut [f64]),
    ) -> f64 {
        let mut heat_j = 0.0;
        for (i, joint) in tree.joints.iter().enumerate() {
            let (position, rate, law) = (positions[i], rates[i], &joint.law);
            losses[i] = -law.damping * rate;
            let mut stored = law.spring().map_or(0.0, |spring| spring.force_at(position));
            for (beyond, way) in [
                (law.limits[0] - position, 1.0),
                (position - law.limits[1], -1.0),
            ] {
                if beyond > 0.0 {
                    let Sprung { stiffness, damping } = self.stops[i];
                    let push = (stiffness * beyond - damping * way * rate).max(0.0);
                    stored += way * stiffness * beyond;
                    losses[i] += way * (push - stiffness * beyond);
                }
            }
            forces[i] += stored + losses[i];
            if law.friction > 0.0 {
                let mut bend = Vector2::new(self.bends[i], 0.0);
                let rate = Vector2::new(rate, 0.0);
                let dry = self.bristle(i).bend(&mut bend, rate, law.friction, h);
                self.bends[i] = bend.x;
                forces[i] += dry.force.x;
                heat_j += dry.slip_j + dry.damping_j;
            }
        }
        for (of, Sprung { stiffness, damping }) in tree.couplings.iter().zip(&self.couplings) {
            let off = |of_joints: &[f64]| of_joints[of.joint] - of.factor * of_joints[of.follows];
            let stored = -stiffness * (off(positions) - of.offset);
            let lost = -damping * off(rates);
            for (joint, share) in [(of.joint, 1.0), (of.follows, -of.factor)] {
                forces[joint] += share * (stored + lost);
                losses[joint] += share * lost;
            }
        }
        heat_j
    }

    /// The bristle of a joint's dry friction, with the friction in place of the normal force.
    fn bristle(&self, joint: usize) -> ContactLaw {
        ContactLaw {
            normal_stiffness_n_m: 0.0,
            normal_damping_n_s_m: 0.0,
            bristle_stiffness_n_m: self.bristles[joint].stiffness,
            bristle_damping_n_s_m: self.bristles[joint].damping,
            friction: 1.0,
            nap: None,
        }
    }

    /// Energy in springs, stops, couplings and bristles, in J.
    pub fn stored_j(&self, tree: &Tree, positions: &[f64]) -> f64 {
        let joints = tree.joints.iter().enumerate().map(|(i, joint)| {
            let (law, position) = (&joint.law, positions[i]);
            let beyond = (law.limits[0] - position).max(position - law.limits[1]);
            let stop_j = 0.5 * self.stops[i].stiffness * beyond.max(0.0).powi(2);
            let bristle_j = 0.5 * self.bristles[i].stiffness * self.bends[i].powi(2);
            law.stored_j(position) + stop_j + bristle_j
        });
        let couplings = tree
            .couplings
            .iter()
            .zip(&self.couplings)
            .map(|(of, sprung)| {
                let off = positions[of.joint] - of.factor * positions[of.follows] - of.offset;
                0.5 * sprung.stiffness * off * off
            });
        joints.sum::<f64>() + couplings.sum::<f64>()
    }
}

/// The joints' acceleration along a direction per unit of force along it, wheels and rollers free,
/// but tyres.
fn response(tree: &Tree, along: &[(usize, f64)]) -> Option<f64> {
    let held = Prescribed {
        wheels: vec![None; tree.wheels.len()],
        rollers: tree
            .rollers
            .iter()
            .map(|of| of.is_tyre.then_some(0.0))
            .collect(),
    };
    let (mut force, mut unused) = (Forces::zero(tree), Forces::zero(tree));
    for (joint, share) in along {
        force.joints[*joint] += share;
    }
    let rest = Generalised::zero(tree);
    let mut gained = rest.clone();
    let mut system = ArrowSystem::new(tree);
    system.assemble(tree, &Posture::new(tree), &rest, &force);
    let solved = system.solve(tree, &held, &mut gained, &mut unused);
    solved.then(|| {
        along
            .iter()
            .map(|(joint, share)| share * gained.joints[*joint])
            .sum()
    })
}
