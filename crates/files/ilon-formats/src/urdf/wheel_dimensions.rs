//! Measures a wheel and its rollers.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Point3, Unit, Vector3};

use super::body::RigidBody;
use super::from_rollers::{self, RollerGeometry};
use super::hub::{check_level, hub_frame, remark_motor};
use super::loading::Loading;
use super::outline;
use super::recognise::Candidate;
use super::roller_gaps::{Handover, WIDEST_GAP_RAD, close_gaps};
use crate::error::{Fault, RobotError};
use crate::model::{DriveTrain, Remark, Roller, RollerForm, RollerSurface, RollersAsMade, Wheel};
use crate::options::RollerForms;

/// Common measures of a wheel's rollers.
struct Ring {
    /// Its middle along the hub axis, from the joint's origin, in metres.
    middle_z_m: f64,
    body_from_hub: Isometry3<f64>,
    gamma_rad: f64,
    radius_m: f64,
}

impl Ring {
    fn of(
        seen: &[RollerGeometry],
        body_from_joint: &Isometry3<f64>,
        axis: &Unit<Vector3<f64>>,
    ) -> Self {
        let along_hub = |pick: fn(f64, f64) -> f64, from: f64| {
            seen.iter().map(|s| s.skew.foot.z).fold(from, pick)
        };
        let middle_z_m =
            0.5 * (along_hub(f64::min, f64::INFINITY) + along_hub(f64::max, f64::NEG_INFINITY));
        let center = body_from_joint * Point3::new(0.0, 0.0, middle_z_m);
        let count = seen.len() as f64;
        Self {
            middle_z_m,
            body_from_hub: hub_frame(&center, axis),
            gamma_rad: seen.iter().map(|s| s.skew.gamma_rad).sum::<f64>() / count,
            radius_m: seen.iter().map(|s| s.outline.wheel_radius_m).sum::<f64>() / count,
        }
    }
}

/// Measures a wheel.
pub(super) fn measure(
    loading: &mut Loading,
    candidate: &Candidate,
    hub_body: &RigidBody,
) -> Result<Wheel, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let joint = &tree.joints[candidate.hub];
    check_level(source, &joint.name, &joint.axis)?;
    // First about the joint's own origin; the wheel's middle is known only after the rollers.
    let body_from_joint = hub_frame(&joint.origin, &joint.axis);
    let mut seen = from_rollers::rollers(loading, candidate, &body_from_joint, hub_body)?;
    let ring = Ring::of(&seen, &body_from_joint, &joint.axis);
    from_rollers::check_alike(source, tree, &seen, ring.gamma_rad, ring.radius_m)?;
    let lone_spheres = remark_fit(loading, &joint.name, &mut seen, &ring);
    let hub_mass = hub_body.mass.as_ref().ok_or_else(|| {
        let link = &tree.links[hub_body.link].name;
        source.inertial_error(link, Fault::NoMass)
    })?;
    let mut rollers = rollers(loading, &seen, &ring)?;
    hand_over(loading, &joint.name, &mut rollers, &ring)?;
    remark_motor(&joint.name, &joint.limits, &mut loading.remarks);
    remark_stops(loading, candidate);
    outline(loading, &joint.name, seen, &ring, lone_spheres);
    remark_crowd(&joint.name, &rollers, &mut loading.remarks);
    Ok(Wheel {
        name: joint.name.clone(),
        carrier: None,
        body_from_hub: ring.body_from_hub,
        hub: hub_mass.moved(&ring.body_from_hub.inverse()),
        radius_m: ring.radius_m,
        gamma_rad: ring.gamma_rad,
        rollers,
        motor: joint.limits,
        joint: joint.losses,
        drive: DriveTrain::default(),
        surface: RollerSurface::default(),
        material: None,
        made: RollersAsMade::default(),
    })
}

/// Adds a remark on stops of wheels and rollers, which are ignored.
fn remark_stops(loading: &mut Loading, candidate: &Candidate) {
    /// Range between stops, in turns, that is never reached.
    const ENDLESS_TURNS: f64 = 1000.0;
    for &j in std::iter::once(&candidate.hub).chain(&candidate.rollers) {
        let joint = &loading.tree.joints[j];
        let turns = (joint.travel[1] - joint.travel[0]) / TAU;
        if turns < ENDLESS_TURNS {
            loading.remarks.push(Remark::new(
                format!("joint `{}`", joint.name),
                format!(
                    "its limits stop it after {turns:.1} turns in other simulators: here it turns freely; make it `continuous`"
                ),
            ));
        }
    }
}

/// Gives single spheres a length, and remarks how the rollers fit the wheel's circle. Returns the
/// number of single spheres.
fn remark_fit(
    loading: &mut Loading,
    wheel: &str,
    seen: &mut [RollerGeometry],
    ring: &Ring,
) -> usize {
    // The fit of barrels to the geometry is irrelevant without barrels.
    let mut unsaid = Vec::new();
    let bare = seen.iter().filter(|s| s.body.shapes.is_empty()).count();
    if bare > 0 {
        loading.remarks.push(Remark::new(
            format!("wheel `{wheel}`"),
            format!("{bare} rollers have no collision geometry: their sizes are taken from what is shown of them"),
        ));
    }
    let remarks = match loading.options.rollers {
        RollerForms::Barrel => &mut loading.remarks,
        RollerForms::AsModelled => &mut unsaid,
    };
    let lone_spheres =
        from_rollers::give_lone_spheres_a_length(wheel, seen, ring.radius_m, remarks);
    from_rollers::remark_outline(wheel, seen, ring.radius_m, remarks);
    lone_spheres
}

/// Returns the rollers of the model, ordered by angle.
fn rollers(
    loading: &mut Loading,
    seen: &[RollerGeometry],
    ring: &Ring,
) -> Result<Vec<Roller>, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let mut rollers = Vec::with_capacity(seen.len());
    for s in seen {
        let mut roller = from_rollers::roller(
            source,
            tree,
            s,
            ring.middle_z_m,
            ring.radius_m,
            &ring.body_from_hub,
            &mut loading.remarks,
        )?;
        if loading.options.rollers == RollerForms::AsModelled {
            let modelled = from_rollers::as_modelled(&roller, s, ring.middle_z_m, &loading.meshes)
                .map_err(|fault| source.link_error(&tree.links[s.body.link].name, fault))?;
            roller.form = RollerForm::AsModelled(modelled);
        }
        rollers.push(roller);
    }
    rollers.sort_by(|p, q| p.place_rad().total_cmp(&q.place_rad()));
    Ok(rollers)
}

/// Checks how barrels hand over around the wheel, and remarks it. Barrels with too wide gaps are
/// lengthened, if allowed.
fn hand_over(
    loading: &mut Loading,
    wheel: &str,
    rollers: &mut [Roller],
    ring: &Ring,
) -> Result<(), RobotError> {
    let mut handover = Handover::between(rollers, ring.gamma_rad);
    if loading.options.rollers == RollerForms::AsModelled {
        handover.remark_stuck(wheel, ring.radius_m, &mut loading.remarks);
        return Ok(());
    }
    let may_close = loading.options.repair && !handover.has_missing();
    if handover.widest_gap_rad > WIDEST_GAP_RAD && may_close {
        loading.remarks.push(Remark::new(
            format!("wheel `{wheel}`"),
            format!(
                "repaired: rollers made longer to close gaps of up to {:.2} deg",
                handover.widest_gap_rad.to_degrees()
            ),
        ));
        close_gaps(rollers, ring.radius_m, ring.gamma_rad);
        handover = Handover::between(rollers, ring.gamma_rad);
    }
    // Rollers too slender to reach their neighbours keep a gap.
    if handover.widest_gap_rad > WIDEST_GAP_RAD {
        return Err(loading.source.joint_error(wheel, handover.fault()));
    }
    handover.remark(wheel, ring.radius_m, &mut loading.remarks);
    Ok(())
}

/// Stores the outline of the wheel as modelled in the file, and remarks where it rolls differently
/// from the fitted wheel.
fn outline(
    loading: &mut Loading,
    wheel: &str,
    seen: Vec<RollerGeometry>,
    ring: &Ring,
    lone_spheres: usize,
) {
    let modelled: Vec<outline::Modelled> = seen
        .into_iter()
        .map(|s| outline::Modelled {
            foot_in_hub_m: s.skew.foot.coords - Vector3::z() * ring.middle_z_m,
            axis_in_hub: s.axis,
            profile: s.profile,
        })
        .collect();
    let outline = outline::outline(wheel, ring.radius_m, &modelled);
    // For single spheres the fitted barrels were remarked before.
    let forms = loading.options.rollers;
    if lone_spheres == 0 || forms == RollerForms::AsModelled {
        outline.remark_rolling(forms, &mut loading.remarks);
    }
    loading.outlines.push(outline);
}

/// Adds a remark if rollers overlap at their middles. Their ends usually do in one closed row.
fn remark_crowd(wheel: &str, rollers: &[Roller], remarks: &mut Vec<Remark>) {
    let neighbours = rollers.iter().zip(rollers.iter().cycle().skip(1));
    let closest = neighbours
        .map(|(p, q)| {
            let apart_m = (p.center_in_hub_m - q.center_in_hub_m).norm();
            (apart_m, p.radius_m + q.radius_m)
        })
        .min_by(|p, q| (p.0 - p.1).total_cmp(&(q.0 - q.1)));
    if let Some((apart_m, thick_m)) = closest.filter(|(apart_m, thick_m)| *apart_m < 0.99 * thick_m)
    {
        remarks.push(Remark::new(
            format!("wheel `{wheel}`"),
            format!(
                "neighbouring rollers stand {:.2} mm apart, but are {:.2} mm thick: they run into each other, which here \
                 does nothing, but jams wheels in simulators where rollers collide. Make them slimmer, or use fewer",
                1e3 * apart_m,
                1e3 * thick_m
            ),
        ));
    }
}
