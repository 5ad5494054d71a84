//! Collects the laws of a step: contacts of bodies with the ground and with one another, dry
//! bearings, motors at their rate limits.

use nalgebra::{Vector2, Vector3};

use super::ReactionSolver;
use super::compliance::stays_open;
use super::last_step::spring_between;
use crate::contact::frame::along_frame;
use crate::contact::law::Law;
use crate::contact::law::tread::Press;
use crate::contact::reactions::potential::{Axle, PotentialContact};
use crate::contact::reactions::reaction::{Member, Part, Partner, Reaction};
use crate::contact::reactions::row::{Row, Side};
use crate::contact::scene::{Scene, Scenes};
use crate::contact::search::candidate::Candidate;
use crate::dynamics::Path;
use crate::ground::{FloorSurface, Nap};

/// A contact that would still open at this rate, in its robot's unit of speed, after a step without
/// impulses is left out: other contacts do not change its velocity by as much, unless they have to
/// stop more. This removes most potential contacts on rough ground. 0.1 m/s for wheels of 50 mm.
/// Chosen.
const OPEN: f64 = 0.143;

/// A contact deeper than its load explains is pushed out at this speed, in the same unit: too
/// slowly to bounce, by 2.5e-5 of a wheel's radius. 5 mm/s for wheels of 50 mm. Chosen.
const PUSH_OUT: f64 = 7.1e-3;

/// Whether a roller comes down because its round wheel rolls on to it from one that bears, without
/// an impact. On an even floor its approach is no faster than the load would move the wheel alone
/// within the step; on bumps and edges it must not be deep after half of it.
fn rolls_on(scene: &Scene<'_>, (part, contact): (Part, &PotentialContact), half_s: f64) -> bool {
    /// Depths of a gentle approach on even ground and on bumps, in wheel radii: 0.1 mm and 30 um
    /// for wheels of 50 mm. Chosen.
    const EVEN: f64 = 2e-3;
    const BUMPY: f64 = 6e-4;
    let Some(wheel) = part.wheel() else {
        return false;
    };
    let (body, robot) = (&scene.wheels[wheel], &scene.robot.wheels[wheel]);
    let deep_m_s = |share: f64| share * scene.scale.length_m / half_s;
    let most_m_s = match scene.ground.has_solids() {
        false => {
            let rollers_kg: f64 = robot.rollers.iter().map(|roller| roller.mass_kg).sum();
            let load_n = body.surface.load_kg * scene.settings.gravity_m_s2;
            let loaded_m_s = 2.0 * half_s * load_n / (robot.hub.mass_kg + rollers_kg);
            loaded_m_s.max(deep_m_s(EVEN))
        }
        true => deep_m_s(BUMPY),
    };
    let is_gentle = -contact.before.x < most_m_s;
    body.is_round && is_gentle && body.rollers.iter().any(|roller| roller.pressed)
}

/// The direction of a nap among the tangents of a contact; `None` if the ground is vertical along
/// the nap.
fn nap_among(nap: &Nap, frame: &[Vector3<f64>; 3]) -> Option<Vector2<f64>> {
    /// Ground that is steeper than this, as the cosine of an angle, has no nap. Chosen.
    const LEAST: f64 = 1e-3;
    let (y, x) = libm::sincos(nap.angle_rad);
    let lies = along_frame(frame, &Vector3::new(x, y, 0.0)).yz();
    lies.try_normalize(LEAST)
}

impl ReactionSolver {
    /// Finds the places where the bodies are near the ground and one another.
    pub(super) fn find(&mut self, scenes: Scenes<'_>) {
        for scene in scenes.each() {
            if scene.body.is_robot() {
                scene.find_ground(&mut self.nearby);
            }
            for wheel in 0..scene.robot.wheels.len() {
                scene.find_wheel(wheel, &mut self.workspace, &mut self.found);
                self.nearby.append(&mut self.found);
            }
        }
        scenes.find_between_robots(&mut self.nearby);
        scenes.find_near_free_bodies(&mut self.workspace, &mut self.nearby);
    }

    /// Collects the laws of all contacts and dry bearings.
    pub(super) fn assemble(&mut self, scenes: Scenes<'_>) {
        self.touch(scenes);
        for scene in scenes.each() {
            for (index, wheel) in scene.robot.wheels.iter().enumerate() {
                if self.needs_drive(&scene, index) {
                    self.hold_drive(&scene, index);
                    continue;
                }
                let friction_n_m = wheel.dry_friction_n_m();
                self.limit_motor(&scene, index);
                if friction_n_m > 0.0 {
                    let side = scene.of_hub(index);
                    self.hold_bearing(&scene, Part::Hub(index), side, friction_n_m);
                }
            }
        }
        for scene in scenes.each() {
            self.hold_joints(&scene);
        }
        for i in 0..self.axles.len() {
            let axle = self.axles[i];
            let scene = scenes.of(axle.body);
            let body = &scene.wheels[axle.wheel];
            let under_load_n_m = body.surface.axle_drag_m * axle.load_n.max(0.0);
            let friction_n_m = body.rollers[axle.roller].friction_n_m + under_load_n_m;
            if friction_n_m > 0.0 && axle.response.is_some() {
                // Its spin relative to the hub.
                let still = (&Vector3::zeros(), &Vector3::zeros());
                let (hub, hub_turns) = (Some(body.joint), -axle.axis);
                let mut side = scene.moving_with(hub, &scene.step.middle, still, &hub_turns);
                side.axle = Some((i, 1.0));
                let part = Part::Axle(axle.wheel, axle.roller);
                self.hold_bearing(&scene, part, side, friction_n_m);
            }
            self.hold_slide(&scene, i);
        }
    }

    /// Turns the places where bodies are near something into contacts.
    fn touch(&mut self, scenes: Scenes<'_>) {
        let dt_s = scenes.dt_s;
        let mut potential = std::mem::take(&mut self.potential);
        let nearby = std::mem::take(&mut self.nearby);
        potential.clear();
        potential.extend(nearby.iter().map(|place| scenes.potential_contact(place)));

        // Stopping the fastest approach may move the others by as much.
        let open_m_s =
            |contact: &PotentialContact| contact.free.x + contact.gap_before_m.max(0.0) / dt_s;
        let comes_m_s = potential.iter().map(open_m_s).fold(0.0, f64::min).abs();
        for (place, contact) in nearby.iter().zip(&mut potential) {
            let scene = &scenes.of(place.a.body);
            let press = self.press(scene, place.a.part, contact);
            let opens = match &press {
                Some(press) => stays_open(contact, press, (scene.scale, dt_s)),
                None => open_m_s(contact) > OPEN * scene.scale.speed_m_s() + comes_m_s,
            };
            if !opens {
                self.take_up(scenes, (place, contact), press);
            }
        }
        self.potential = potential;
        self.nearby = nearby;
    }

    /// Adds a contact that may press in the step: the laws of its normal, its friction and its
    /// rolling resistance.
    fn take_up(
        &mut self,
        scenes: Scenes<'_>,
        (place, contact): (&Candidate, &mut PotentialContact),
        press: Option<Press>,
    ) {
        let scene = &scenes.of(place.a.body);
        let (approach_m_s, compliance) = self.closing(scenes, (place, contact), press.as_ref());
        // Bodies have the friction of the floor beneath, and are rigid.
        let wheel = place.a.part.wheel();
        let material = wheel.and_then(|wheel| scene.robot.wheels[wheel].material.as_deref());
        let footing = scene.ground.footing_at(&place.place_m, material);
        let ground = match place.b {
            Partner::Ground if scene.body.is_robot() => footing.surface,
            _ => FloorSurface::default(),
        };
        let along = ground.nap.and_then(|nap| nap_among(&nap, &contact.frame));
        let grip = scenes.friction_between(place, footing.friction);
        let friction = ground.friction_at_speed(grip, contact.before.yz().norm())
            * wheel.map_or(1.0, |wheel| scene.wheels[wheel].grip);
        let law = Law::Contact {
            friction,
            approach_m_s,
            compliance,
        };
        let load_n = self.load_n(scene, place, press.as_ref());
        self.seat_axles(contact);
        for (axle, _) in contact.rows[0].sides().filter_map(|side| side.axle) {
            self.axles[axle].load_n += load_n;
        }
        let tangents =
            self.tangent_compliance(scene, (place, contact), (press, load_n), (&ground, along));
        let nap = along.and_then(|along| {
            let ratio = ground.nap?.friction_ratio;
            (ratio != 1.0).then_some((along, ratio))
        });
        let reaction = Reaction {
            b: place.b,
            at_m: place.place_m,
            frame: contact.frame,
            friction,
            nap,
            came_down: place.came_down,
            rolling_radius_m: contact.rows[2].a.axle.map_or(0.0, |(_, radius_m)| radius_m),
            compliance: tangents.map(Box::new),
            ..Reaction::within(place.a, contact.before)
        };
        let mut free = contact.free;
        if let Some(tangents) = &tangents {
            free.y += tangents.softness[0].bias_m_s;
            free.z += tangents.softness[1].bias_m_s;
        }
        self.push(law, reaction, &contact.rows, free.as_slice());
        if let Some(tangents) = tangents {
            self.problem.soften(tangents.softness.map(|s| s.compliance));
            if tangents.coupled != 0.0 {
                self.problem.couple(tangents.coupled);
            }
        }
        if let Some((along, ratio)) = nap {
            self.problem.make_anisotropic(along, ratio);
        }
        self.gaps_m.push((place.gap_m, contact.gap_before_m));
        self.resist_rolling(scene, (place, contact), (&ground, along), load_n);
    }

    /// The closing speed of a contact in the step before it presses, in m/s, negative to push it
    /// out; and the compliance of its normal, in m/s per N s.
    fn closing(
        &self,
        scenes: Scenes<'_>,
        (place, contact): (&Candidate, &PotentialContact),
        press: Option<&Press>,
    ) -> (f64, f64) {
        if let Some(press) = press {
            return (press.softness.bias_m_s, press.softness.compliance);
        }
        let (scene, dt_s) = (scenes.of(place.a.body), scenes.dt_s);
        let spring = spring_between(scenes.bodies, place.a, place.b);
        let compliance = spring.compliance(dt_s);
        let gap_m = contact.gap_before_m;
        let approach_m_s = if scene.body.coupled().is_some() {
            // rapier lets its contacts overlap a little.
            place.gap_m / dt_s
        } else if gap_m > 0.0 {
            let half_s = 0.5 * dt_s;
            let takes_over = place.came_down && rolls_on(&scene, (place.a.part, contact), half_s);
            gap_m / if takes_over { half_s } else { dt_s }
        } else {
            // No faster than by the deflection under the previous load, plus a little.
            let before = self.impulse_before(&scene, (place.a, place.b));
            let loaded_m_s = compliance * before.map_or(0.0, |impulse| impulse.x);
            let relaxed_s = dt_s + spring.relaxation_s;
            (gap_m / relaxed_s).max(-loaded_m_s - PUSH_OUT * scene.scale.speed_m_s())
        };
        (approach_m_s, compliance)
    }

    /// Sets in the rows of a contact the indices of its rollers among those that may touch.
    fn seat_axles(&mut self, contact: &mut PotentialContact) {
        let index_of = |axle: &Option<Axle>| axle.as_ref().map(|axle| self.index_of(axle));
        let [of_a, of_b] = contact.axles.each_ref().map(index_of);
        let seat = |side: &mut Side, index: Option<usize>| {
            side.axle = index.zip(side.axle).map(|(index, (_, c))| (index, c));
        };
        for row in &mut contact.rows {
            seat(&mut row.a, of_a);
            if let Some(side) = &mut row.b {
                seat(side, of_b);
            }
        }
    }

    /// The index of a roller among those that may touch; it is added if it is not there yet.
    fn index_of(&mut self, axle: &Axle) -> usize {
        let key = |axle: &Axle| (axle.body, axle.wheel, axle.roller);
        let of_this = |other: &Axle| key(other) == key(axle);
        self.axles.iter().position(of_this).unwrap_or_else(|| {
            self.axles.push(*axle);
            self.axles.len() - 1
        })
    }

    /// The impulse of the last step between these, from which a new reaction continues.
    pub(super) fn impulse_before(
        &self,
        scene: &Scene<'_>,
        (a, b): (Member, Partner),
    ) -> Option<Vector3<f64>> {
        let follows = |other: &&Reaction| a.follows(other.a) && b.follows(other.b);
        let place = self.all.iter().filter(follows).count();
        let mut before = scene.reactions.all().iter().filter(follows);
        before.nth(place).map(|reaction| reaction.impulse)
    }

    /// Adds a dry bearing.
    pub(super) fn hold_bearing(
        &mut self,
        scene: &Scene<'_>,
        part: Part,
        side: Side,
        friction_n_m: f64,
    ) {
        let most_n_m_s = friction_n_m * scene.dt_s;
        let law = Law::Joint {
            least_n_m_s: -most_n_m_s,
            most_n_m_s,
        };
        self.hold_joint(scene, part, side, law, 0.0);
    }

    /// Holds a roller with play between its stops, given its index among those that may touch.
    fn hold_slide(&mut self, scene: &Scene<'_>, index: usize) {
        let axle = self.axles[index];
        let roller = &scene.wheels[axle.wheel].rollers[axle.roller];
        let Some(slide) = roller.slide.as_ref().filter(|_| !roller.seized) else {
            return;
        };
        let [least_m_s, most_m_s] = slide.to_stops_m_s(scene.dt_s);
        let law = Law::Slide {
            least_m_s,
            most_m_s,
        };
        let side = Side {
            axle: Some((index, 0.0)),
            slide: 1.0,
            ..Side::of_joints(scene.index, Path::NONE)
        };
        let part = Part::Slide(axle.wheel, axle.roller);
        self.hold_joint(scene, part, side, law, 0.0);
    }

    /// Keeps the motor of a wheel from driving it beyond its rate limit: removes as much of its
    /// torque as needed, and not more.
    fn limit_motor(&mut self, scene: &Scene<'_>, wheel: usize) {
        let (motor, dof) = (&scene.step.motors[wheel], scene.body.dof_of(wheel));
        let (now_rad_s, free_rad_s) = (scene.step.rates_before[dof], scene.step.rates_free[dof]);
        // The sense in which the step would end beyond it; a wheel may start from rest, or reverse
        // within the step.
        let is_near = motor.is_near_limit(now_rad_s);
        let ends_beyond = free_rad_s.abs() > motor.rate_limit_rad_s;
        let way = if is_near && !ends_beyond {
            now_rad_s
        } else {
            free_rad_s
        };
        let limit_rad_s = motor.rate_limit_rad_s.copysign(way);
        if !is_near && !motor.is_near_limit(free_rad_s) {
            return;
        }
        let gives_n_m = motor.torque_n_m - motor.droop_n_m_s * (limit_rad_s - now_rad_s);
        let gives_n_m_s = gives_n_m * scene.dt_s;
        let law = Law::Joint {
            least_n_m_s: if limit_rad_s > 0.0 {
                -gives_n_m_s.max(0.0)
            } else {
                0.0
            },
            most_n_m_s: if limit_rad_s > 0.0 {
                0.0
            } else {
                -gives_n_m_s.min(0.0)
            },
        };
        let side = scene.of_hub(wheel);
        self.hold_joint(scene, Part::RateLimit(wheel), side, law, limit_rad_s);
    }

    /// The rate of a side whose roller has an index among those that may touch.
    pub(super) fn rate(&self, side: &Side, rates: &[f64], of_axle: fn(&Axle) -> (f64, f64)) -> f64 {
        let axle = side.axle.map(|(i, c)| (c, of_axle(&self.axles[i])));
        let of_axle = axle.map_or(0.0, |(c, (rad_s, m_s))| c * rad_s + side.slide * m_s);
        side.of_bodies(rates) + of_axle
    }

    /// Adds a joint, whose two parts are both of body A, with its rate relative to a given one.
    pub(super) fn hold_joint(
        &mut self,
        scene: &Scene<'_>,
        part: Part,
        side: Side,
        law: Law,
        from_rad_s: f64,
    ) {
        let before = self.rate(&side, &scene.step.rates_before, Axle::before) - from_rad_s;
        let free = self.rate(&side, &scene.step.rates_free, Axle::now) - from_rad_s;
        let reaction = Reaction::within(scene.member(part), Vector3::new(before, 0.0, 0.0));
        self.push(law, reaction, &[Row::of_one(side)], &[free]);
    }

    /// Adds a law and its place.
    pub(super) fn push(&mut self, law: Law, reaction: Reaction, rows: &[Row], free: &[f64]) {
        self.problem.push(law, free);
        self.rows.extend_from_slice(rows);
        self.all.push(reaction);
    }
}
