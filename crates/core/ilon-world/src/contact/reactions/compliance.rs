//! Compliant contacts: treads and creep.

use ilon_robot::Scale;
use nalgebra::{Vector2, Vector3};

use super::ReactionSolver;
use crate::contact::law::tread::{Press, Softness, TreadLaw};
use crate::contact::reactions::potential::PotentialContact;
use crate::contact::reactions::reaction::{Part, Reaction, TangentCompliance, Tread, turned_to};
use crate::contact::reactions::row::Row;
use crate::contact::scene::Scene;
use crate::contact::search::candidate::Candidate;
use crate::ground::FloorSurface;

/// A tread that would still be this far from the ground after a step is not included, in wheel
/// radii. Chosen.
const OPEN: f64 = 2e-5;

/// The least load for creep, relative to the mean load of a wheel: a roller with hardly any load
/// would creep without limit. Chosen.
const LEAST_LOAD: f64 = 1e-2;

/// Whether a tread does not reach the ground in the step, with its current rate and with that
/// without any contact.
pub(super) fn stays_open(
    contact: &PotentialContact,
    press: &Press,
    (scale, dt_s): (&Scale, f64),
) -> bool {
    let comes_m_s = contact.before.x.min(contact.free.x).min(0.0);
    press.gap_m + dt_s * comes_m_s > OPEN * scale.length_m
}

/// The tread of a part, if it has one.
fn tread_of<'a>(scene: &'a Scene<'_>, part: Part) -> Option<&'a TreadLaw> {
    scene.wheels[part.wheel()?].surface.tread.as_ref()
}

impl ReactionSolver {
    /// The normal law of a contact's tread; `None` without one.
    pub(super) fn press(
        &self,
        scene: &Scene<'_>,
        part: Part,
        contact: &PotentialContact,
    ) -> Option<Press> {
        let tread = tread_of(scene, part)?;
        Some(tread.press(contact.gap_before_m, contact.before.x, scene.dt_s))
    }

    /// The load of a contact at the beginning of the step, in N: for a tread at its present depth;
    /// for a rigid contact, whose load is only known at the end of the step, that of the wheel in
    /// the last one.
    pub(super) fn load_n(
        &self,
        scene: &Scene<'_>,
        place: &Candidate,
        press: Option<&Press>,
    ) -> f64 {
        if let Some(press) = press {
            return press.load_n;
        }
        let Candidate { a, b, .. } = *place;
        let before_dt_s = scene.reactions.dt_s();
        let before = self.impulse_before(scene, (a, b));
        let before = before.filter(|_| before_dt_s > 0.0);
        before.map_or_else(
            || mean_load_n(scene, a.part),
            |impulse| impulse.x / before_dt_s,
        )
    }

    /// The tangential compliance of a contact: by its tread and by the ground's creep. `along` is
    /// the direction of the ground's nap among the tangents.
    pub(super) fn tangent_compliance(
        &self,
        scene: &Scene<'_>,
        (place, contact): (&Candidate, &PotentialContact),
        (press, load_n): (Option<Press>, f64),
        (ground, along): (&FloorSurface, Option<Vector2<f64>>),
    ) -> Option<TangentCompliance> {
        let part = place.a.part;
        let travel_m_s = place.travel_m_s.norm();
        let load_n = load_n.max(LEAST_LOAD * mean_load_n(scene, part));
        // Slip per rolled distance, per newton of force, along the nap and across it.
        let creep_1_n = ground.creeps().map(|creep| creep / load_n);
        let along = along.filter(|_| creep_1_n[0] != creep_1_n[1]);
        let Some((tread, press)) = tread_of(scene, part).zip(press) else {
            let creeps = matches!(part, Part::Roller(..)) && creep_1_n.iter().any(|c| *c > 0.0);
            let softness = creep_1_n.map(|creep_1_n| Softness {
                compliance: creep_1_n * travel_m_s / scene.dt_s,
                bias_m_s: 0.0,
            });
            return creeps.then(|| TangentCompliance::along(softness, along, None));
        };
        // What pressed here in the last step continues from there: of several places of a tyre on
        // one face each from its own.
        let Candidate { a, b, .. } = *place;
        let same = |other: &&Reaction| {
            (other.a, other.b) == (a, b) && other.frame[0].dot(&contact.frame[0]) > 0.7
        };
        let beside = self.all.iter().filter(same).count();
        let mut before = scene.reactions.all().iter().filter(same);
        let before = before.nth(beside).and_then(|other| other.tread());
        let bend_m = before.map_or_else(Vector2::zeros, |tread| {
            Vector2::new(
                tread.bend_m.dot(&contact.frame[1]),
                tread.bend_m.dot(&contact.frame[2]),
            )
        });
        let of_axle = |row: &Row| match (row.a.axle, &contact.axles[0]) {
            (Some((_, share)), Some(axle)) => {
                let [about, along] = axle.responses();
                share * share * about + row.a.slide * row.a.slide * along
            }
            _ => 0.0,
        };
        let mut per_kg = [1, 2].map(|k| 1.0 / tread.load_kg + of_axle(&contact.rows[k]));
        let renewed_1_s = creep_1_n.map(|creep_1_n| {
            travel_m_s * (tread.renewal_1_m + creep_1_n * tread.shear.stiffness_n_m)
        });
        let (mut bend_m, mut rate_m_s) = (bend_m, contact.before.yz());
        if let Some(along) = along {
            let turn = turned_to(along);
            (bend_m, rate_m_s) = (turn * bend_m, turn * rate_m_s);
            let shares = along.component_mul(&along);
            let [first, second] = per_kg;
            per_kg = [
                shares.x * first + shares.y * second,
                shares.y * first + shares.x * second,
            ];
        }
        let shear = tread.shear((bend_m, rate_m_s), per_kg, renewed_1_s, scene.dt_s);
        let tread = Tread {
            press,
            shear,
            bend_m: Vector3::zeros(),
            stored_before_j: before.map_or([0.0; 2], |tread| tread.stored_j),
            stored_j: [0.0; 2],
        };
        Some(TangentCompliance::along(shear.softness, along, Some(tread)))
    }
}

/// The mean load of a robot's wheels, in N.
fn mean_load_n(scene: &Scene<'_>, part: Part) -> f64 {
    part.wheel().map_or(0.0, |wheel| {
        scene.wheels[wheel].surface.load_kg * scene.settings.gravity_m_s2
    })
}
