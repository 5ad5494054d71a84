//! Rolling resistance.
//!
//! A roller turns over the ground with the angular velocity W. Where it does not slide as fast over
//! the ground, its contact point moves over its surface with V = R1 (W . e2) e1 - R2 (W . e1) e2:
//! e1 and e2 are the tangents along the roller and across it, R1 and R2 the radii of curvature of
//! its surface along them. Under a load N that takes the power N h(V), with h = c |V| on ground of
//! rolling resistance c, and the moment has this power as its potential: M = N (R1 F1 e2 - R2 F2
//! e1) with F = dh / dV. Because h(s V) = s h(V), M . W = N h(V). If rolling costs more on small
//! radii, h is c |S V|, S with (R / R1)^p along e1 and (R / R2)^p along e2, R the wheel's radius;
//! over a nap it is |C S V|, C with the values along the nap and across it. So the hub pays for the
//! motion of the contact point along the roller, and the roller for that across it.
//!
//! p = 1 is a moment of load times a lever arm c R. p = 1/2 is a bed of springs that returns a
//! share less than what pressed it down: the pressure is lower where the roller rises, which moves
//! the centre of pressure by e along V, |e| = k |V| / sqrt(V . K V), K the curvatures 1 / R1 and 1
//! / R2, with the same k for all directions. It takes N e . K V = k N sqrt(V . K V).
//!
//! Under wheels without tilt the contact point moves like the robot, and the drag is c m g in any
//! direction. Under a mecanum wheel it moves in zigzag, along one roller and back to the next:
//! ahead by sqrt((r cos d)^2 + (r sin d + a / sin d)^2) / R of the robot's way at the middle of a
//! roller, d = 90 deg - gamma, r its radius, a = R - r.
//!
//! In the step V is held as friction holds sliding: by an impulse of at most N c dt, opposed to V
//! if it is at the limit. At rest it resists everything that would start the rolling.

use nalgebra::{Matrix2, SymmetricEigen, Vector2, Vector3};

use super::ReactionSolver;
use crate::contact::law::Law;
use crate::contact::reactions::potential::{Axle, PotentialContact};
use crate::contact::reactions::reaction::{Part, Partner, Reaction, turned_to};
use crate::contact::reactions::row::{Row, Side};
use crate::contact::scene::Scene;
use crate::contact::search::candidate::Candidate;
use crate::ground::FloorSurface;

/// An edge sharper than this share of the wheel's radius rolls like one with this radius. Chosen.
const SHARP: f64 = 1e-3;

impl ReactionSolver {
    /// Adds the rolling resistance of ground and roller under a load in N. `along` is the direction
    /// of the ground's nap among the tangents.
    pub(super) fn resist_rolling(
        &mut self,
        scene: &Scene<'_>,
        (place, contact): (&Candidate, &PotentialContact),
        (ground, along): (&FloorSurface, Option<Vector2<f64>>),
        load_n: f64,
    ) {
        let (Part::Roller(wheel, roller), Partner::Ground) = (place.a.part, place.b) else {
            return;
        };
        let of_roller = scene.wheels[wheel].surface.rolling_resistance;
        if of_roller <= 0.0 && !ground.drags() {
            return;
        }
        let hub = &scene.step.middle.hubs()[wheel];
        let state = &scene.wheels[wheel].rollers[roller];
        let [normal, first, second] = contact.frame;
        let Some(radii_m) = state.radii_m(hub, &normal) else {
            return;
        };
        let wheel_m = scene.robot.wheels[wheel].radius_m;
        let [along_m, across_m] = radii_m.map(|radius_m| radius_m.max(SHARP * wheel_m));
        let axle = contact.rows[2].a.axle.map(|(index, _)| index);
        let travels = [along_m * second, -across_m * first]
            .map(|moment| turned_by(scene, (wheel, roller), axle, &moment));
        let rates = |rates: &[f64], of_axle: fn(&Axle) -> (f64, f64)| {
            travels.map(|side| self.rate(&side, rates, of_axle))
        };
        let before = Vector2::from(rates(&scene.step.rates_before, Axle::before));
        let free = rates(&scene.step.rates_free, Axle::now);
        let mut hold = |resistance: f64| {
            let most_n_s = resistance * load_n * scene.dt_s;
            let part = scene.member(Part::Rolling(wheel, roller));
            let reaction = Reaction::within(part, before.push(0.0));
            let rows = travels.map(Row::of_one);
            self.push(Law::Disc { most_n_s }, reaction, &rows, &free);
        };
        let along = along.filter(|_| ground.drags_by_direction());
        if along.is_none() && ground.radius_exponent == 0.0 {
            hold(ground.rolling_resistance + of_roller);
            return;
        }
        if of_roller > 0.0 {
            hold(of_roller);
        }
        let grows = |radius_m: f64| libm::pow(wheel_m / radius_m, ground.radius_exponent);
        let by_radius = Matrix2::from_diagonal(&Vector2::new(grows(along_m), grows(across_m)));
        let nap = along.unwrap_or_else(Vector2::x);
        let of_ground = Matrix2::from_diagonal(&ground.resistances(nap.dot(&before)).into());
        // h(V)^2 is a quadratic form: along its axes the drag has two coefficients.
        let root = of_ground * turned_to(nap) * by_radius;
        let axes = SymmetricEigen::new(root.transpose() * root);
        let (most, least) = (axes.eigenvalues.imax(), axes.eigenvalues.imin());
        let [most_drag, least_drag] =
            [most, least].map(|axis| axes.eigenvalues[axis].max(0.0).sqrt());
        if most_drag > 0.0 {
            // If one of them is zero, a thousandth keeps the scale of the other's row. Chosen.
            const LEAST_RATIO: f64 = 1e-3;
            hold(most_drag);
            let ratio = (least_drag / most_drag).max(LEAST_RATIO);
            let towards = axes.eigenvectors.column(most).into_owned();
            self.problem.make_anisotropic(towards, ratio);
        }
    }
}

/// The derivative of the rate `moment` . W of a roller's angular velocity W by the robot's rates: W
/// is the hub's, except for the roller's rate about its own axis.
fn turned_by(
    scene: &Scene<'_>,
    (wheel, roller): (usize, usize),
    axle: Option<usize>,
    moment: &Vector3<f64>,
) -> Side {
    let body = &scene.wheels[wheel];
    let hub = &scene.step.middle.hubs()[wheel];
    let axis = hub.rotation * body.rollers[roller].axis_in_hub;
    let of_axle = axle.map_or(0.0, |_| moment.dot(&axis));
    let of_hub = moment - of_axle * axis;
    let still = (&Vector3::zeros(), &Vector3::zeros());
    let mut side = scene.moving_with(Some(body.joint), &scene.step.middle, still, &of_hub);
    side.axle = axle.map(|index| (index, of_axle));
    side
}
