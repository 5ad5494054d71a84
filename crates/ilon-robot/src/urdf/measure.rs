//! What a wheel and its rollers measure.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{
    Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};

use urdf_rs::Geometry;

use super::fit::{self, Outline, Skew};
use super::geometry::{self, primitive};
use super::handover::{Handover, WIDEST_GAP_RAD, barrel_half_length_m, close_gaps};
use super::mesh::Meshes;
use super::options::RollerForms;
use super::outline;
use super::recognise::Candidate;
use super::source::Source;
use super::tree::{PlacedShape, RigidBody, Tree, TreeJoint};
use super::{Loading, remark};
use crate::error::{Fault, RobotError};
use crate::model::{
    Collision, CollisionShape, MassProperties, ModelledRoller, MotorLimits, Profile, Remark,
    Roller, RollerForm, Wheel,
};

/// Hub axes may lean this far out of the ground plane: beyond it the model of the wheel does not hold.
const MOST_LEAN_RAD: f64 = 0.02;
/// Gamma nearer to 90 degrees than this means that the rollers turn with the hub.
const LEAST_CARRY_RAD: f64 = 0.035;

/// A roller as its joint and geometry show it, in a frame on the hub axis.
struct Seen {
    joint: usize,
    body: RigidBody,
    axis: Unit<Vector3<f64>>,
    skew: Skew,
    /// In the frame of the axis and foot.
    shapes: Vec<PlacedShape>,
    profile: Profile,
    outline: Outline,
}

/// Measures a wheel.
pub(super) fn measure(
    loading: &mut Loading,
    candidate: &Candidate,
    hub_body: &RigidBody,
) -> Result<Wheel, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let joint = &tree.joints[candidate.hub];
    check_level(source, joint)?;

    // First about the joint's own origin; the wheel's middle is known once the rollers are.
    let body_from_joint = hub_frame(&joint.origin, &joint.axis);
    let half_pitch_rad = PI / candidate.rollers.len() as f64;
    let mut seen = Vec::with_capacity(candidate.rollers.len());
    for &j in &candidate.rollers {
        seen.push(see(loading, j, &body_from_joint, half_pitch_rad)?);
    }
    let along_hub =
        |pick: fn(f64, f64) -> f64, from: f64| seen.iter().map(|s| s.skew.foot.z).fold(from, pick);
    let middle_z_m =
        0.5 * (along_hub(f64::min, f64::INFINITY) + along_hub(f64::max, f64::NEG_INFINITY));
    let center = body_from_joint * Point3::new(0.0, 0.0, middle_z_m);
    let body_from_hub = hub_frame(&center, &joint.axis);

    let count = seen.len() as f64;
    let gamma_rad = seen.iter().map(|s| s.skew.gamma_rad).sum::<f64>() / count;
    let radius_m = seen.iter().map(|s| s.outline.wheel_radius_m).sum::<f64>() / count;
    check_alike(source, tree, &seen, gamma_rad, radius_m)?;
    let remarks = &mut loading.remarks;
    let forms = loading.options.rollers;
    // What barrels make of the geometry is of no interest where there are none.
    let mut unsaid = Vec::new();
    let of_barrels = match forms {
        RollerForms::Barrel => &mut *remarks,
        RollerForms::AsModelled => &mut unsaid,
    };
    let lone_spheres = give_lone_spheres_a_length(&joint.name, &mut seen, radius_m, of_barrels);
    remark_outline(&joint.name, &seen, radius_m, of_barrels);

    let hub_mass = hub_body.mass.as_ref().ok_or_else(|| {
        let link = &tree.links[hub_body.link].name;
        source.inertial_error(link, Fault::NoMass)
    })?;
    let mut rollers = Vec::with_capacity(seen.len());
    for s in &seen {
        rollers.push(roller(
            source,
            tree,
            s,
            middle_z_m,
            radius_m,
            &body_from_hub,
            remarks,
        )?);
    }
    if forms == RollerForms::AsModelled {
        for (roller, s) in rollers.iter_mut().zip(&seen) {
            let modelled = as_modelled(roller, s, middle_z_m, &loading.meshes)
                .map_err(|fault| source.link_error(&tree.links[s.body.link].name, fault))?;
            roller.form = RollerForm::AsModelled(modelled);
        }
    }
    rollers.sort_by(|p, q| p.place_rad().total_cmp(&q.place_rad()));
    let mut handover = Handover::between(&rollers, gamma_rad);
    if handover.widest_gap_rad > WIDEST_GAP_RAD && forms == RollerForms::Barrel {
        if !loading.options.mend {
            return Err(source.joint_error(&joint.name, handover.fault()));
        }
        remarks.push(remark(
            format!("wheel `{}`", joint.name),
            format!(
                "mended: rollers made longer to close gaps of up to {:.2} deg",
                handover.widest_gap_rad.to_degrees()
            ),
        ));
        close_gaps(&mut rollers, radius_m, gamma_rad);
        handover = Handover::between(&rollers, gamma_rad);
        // Rollers too slender to reach their neighbours stay apart.
        if handover.widest_gap_rad > WIDEST_GAP_RAD {
            return Err(source.joint_error(&joint.name, handover.fault()));
        }
    }
    if forms == RollerForms::Barrel {
        handover.remark(&joint.name, radius_m, remarks);
    }
    remark_motor(&joint.name, &joint.limits, remarks);

    let mut modelled: Vec<outline::Modelled> = seen
        .into_iter()
        .map(|s| outline::Modelled {
            foot_in_hub_m: s.skew.foot.coords - Vector3::z() * middle_z_m,
            axis_in_hub: s.axis,
            profile: s.profile,
        })
        .collect();
    let place_rad = |m: &outline::Modelled| libm::atan2(m.foot_in_hub_m.y, m.foot_in_hub_m.x);
    modelled.sort_by(|p, q| place_rad(p).total_cmp(&place_rad(q)));
    let outline = outline::outline(&joint.name, radius_m, &modelled, &handover);
    // Of lone spheres it is said already what barrels make of them.
    if lone_spheres == 0 || forms == RollerForms::AsModelled {
        outline.remark_rolling(forms, remarks);
    }
    remark_crowd(&joint.name, &rollers, remarks);
    loading.outlines.push(outline);
    Ok(Wheel {
        name: joint.name.clone(),
        body_from_hub,
        hub: hub_mass.moved(&body_from_hub.inverse()),
        radius_m,
        gamma_rad,
        rollers,
        motor: joint.limits,
        joint: joint.losses,
    })
}

/// Says where rollers run into each other at their middles. That their ends do is the rule in one closed row.
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
        remarks.push(remark(
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

/// Says which limits of a motor are missing.
pub(super) fn remark_motor(wheel: &str, limits: &MotorLimits, remarks: &mut Vec<Remark>) {
    let missing = match (
        limits.effort_n_m.is_finite(),
        limits.velocity_rad_s.is_finite(),
    ) {
        (true, true) => return,
        (false, true) => "effort",
        (true, false) => "velocity",
        (false, false) => "effort and velocity",
    };
    remarks.push(remark(
        format!("wheel `{wheel}`"),
        format!("its joint sets no limit of {missing}: the motor is taken as unlimited there"),
    ));
}

/// Refuses a hub axis that leans out of the ground plane.
pub(super) fn check_level(source: &Source, joint: &TreeJoint) -> Result<(), RobotError> {
    let lean_rad = libm::asin(joint.axis.z.abs().min(1.0));
    if lean_rad > MOST_LEAN_RAD {
        let lean_deg = lean_rad.to_degrees();
        return Err(source.joint_error(&joint.name, Fault::HubNotLevel { lean_deg }));
    }
    Ok(())
}

/// The hub frame at wheel angle zero: z along the axis, x as straight down as it can be.
pub(super) fn hub_frame(origin: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> Isometry3<f64> {
    let z = axis.into_inner();
    let down = -Vector3::z();
    // The axis is nearly level, so that this is never zero.
    let x = (down - z * down.dot(&z)).normalize();
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
    Isometry3::from_parts(
        Translation3::from(origin.coords),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

fn see(
    loading: &Loading,
    j: usize,
    body_from_joint: &Isometry3<f64>,
    half_pitch_rad: f64,
) -> Result<Seen, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let joint = &tree.joints[j];
    let hub_from_body = body_from_joint.inverse();
    let axis = Unit::new_unchecked(hub_from_body * joint.axis.into_inner());
    let skew = fit::skew(&(hub_from_body * joint.origin), &axis)
        .filter(|skew| skew.gamma_rad.abs() < FRAC_PI_2 - LEAST_CARRY_RAD)
        .ok_or_else(|| source.joint_error(&joint.name, Fault::GammaRightAngle))?;
    let body = tree.rigid_body(joint.child, |_| false);
    let shapes: Vec<PlacedShape> = body
        .shapes
        .iter()
        .map(|s| PlacedShape {
            body_from_shape: hub_from_body * s.body_from_shape,
            geometry: s.geometry.clone(),
        })
        .collect();
    let profile = geometry::profile(&skew.foot, &axis, &shapes, &loading.meshes)
        .map_err(|fault| source.link_error(&tree.links[joint.child].name, fault))?;
    let outline = fit::outline(&skew, &profile, half_pitch_rad);
    Ok(Seen {
        joint: j,
        body,
        axis,
        skew,
        shapes,
        profile,
        outline,
    })
}

/// All rollers of a wheel must make the same wheel.
fn check_alike(
    source: &Source,
    tree: &Tree,
    seen: &[Seen],
    gamma_rad: f64,
    radius_m: f64,
) -> Result<(), RobotError> {
    for s in seen {
        let name = &tree.joints[s.joint].name;
        let fault = |quantity, this: String, others: String| {
            let fault = Fault::RollersDiffer {
                quantity,
                this,
                others,
            };
            Err(source.joint_error(name, fault))
        };
        if (s.skew.gamma_rad - gamma_rad).abs() > 1f64.to_radians() {
            let degrees = |rad: f64| format!("{:.2} deg", rad.to_degrees());
            return fault("gamma", degrees(s.skew.gamma_rad), degrees(gamma_rad));
        }
        let this_m = s.outline.wheel_radius_m;
        if (this_m - radius_m).abs() > 0.02 * radius_m {
            let millimetres = |m: f64| format!("{:.2} mm", 1e3 * m);
            return fault(
                "the reach from the hub axis",
                millimetres(this_m),
                millimetres(radius_m),
            );
        }
    }
    Ok(())
}

/// A lone sphere says how thick a roller is and not how long: it is taken to reach its neighbours. Returns how many there
/// are.
fn give_lone_spheres_a_length(
    wheel: &str,
    seen: &mut [Seen],
    radius_m: f64,
    remarks: &mut Vec<Remark>,
) -> usize {
    let place_rad = |s: &Seen| libm::atan2(s.skew.foot.y, s.skew.foot.x);
    let places: Vec<f64> = seen.iter().map(place_rad).collect();
    let mut lone = 0;
    let mut dip_m: f64 = 0.0;
    for (i, s) in seen.iter_mut().enumerate() {
        if s.outline.half_length_m.is_some() {
            continue;
        }
        // The wider of the gaps to the neighbours on either side.
        let ahead = |j: usize| (places[j] - places[i]).rem_euclid(TAU);
        let others = || (0..places.len()).filter(|&j| j != i).map(ahead);
        let to_next = others().fold(TAU, f64::min);
        let to_previous = TAU - others().fold(0.0, f64::max);
        let half_rad = (0.5 * to_next.max(to_previous)).min(0.49 * PI);
        let a = s.skew.ring_radius_m;
        let half_length_m = barrel_half_length_m(a, radius_m, s.skew.gamma_rad, half_rad);
        s.outline.half_length_m = Some(half_length_m);
        dip_m = dip_m.max(a * (1.0 - libm::cos(half_rad)));
        lone += 1;
    }
    if lone > 0 {
        remarks.push(remark(format!("wheel `{wheel}`"), format!(
                "{lone} of {} rollers are lone spheres: each is taken as a barrel that reaches its neighbours; as \
                 modelled, the wheel would dip {:.2} mm between rollers",
                seen.len(),
                1e3 * dip_m
            )));
    }
    lone
}

fn remark_outline(wheel: &str, seen: &[Seen], radius_m: f64, remarks: &mut Vec<Remark>) {
    let off_circle = |s: &Seen| s.outline.error_m + (s.outline.wheel_radius_m - radius_m).abs();
    let worst_m = seen.iter().map(off_circle).fold(0.0, f64::max);
    if worst_m > 1e-3 * radius_m {
        remarks.push(remark(format!("wheel `{wheel}`"), format!(
                "the rollers as modelled leave the circle of radius {:.2} mm by up to {:.2} mm; they are taken as the \
                 barrels that fit it",
                1e3 * radius_m,
                1e3 * worst_m
            )));
    }
    let off_middle =
        |s: &Seen| s.outline.middle_m.abs() / s.outline.half_length_m.unwrap_or(f64::INFINITY);
    let worst = seen.iter().map(off_middle).fold(0.0, f64::max);
    if worst > 0.05 {
        remarks.push(remark(format!("wheel `{wheel}`"), format!(
                "rollers sit up to {:.0} % of their half length off the point nearest to the hub axis; they are taken \
                 as centred there",
                100.0 * worst
            )));
    }
}

fn roller(
    source: &Source,
    tree: &Tree,
    seen: &Seen,
    middle_z_m: f64,
    wheel_radius_m: f64,
    body_from_hub: &Isometry3<f64>,
    remarks: &mut Vec<Remark>,
) -> Result<Roller, RobotError> {
    let joint = &tree.joints[seen.joint];
    let link = &tree.links[joint.child].name;
    let mass = seen
        .body
        .mass
        .as_ref()
        .ok_or_else(|| source.inertial_error(link, Fault::NoMass))?;
    let MassProperties {
        mass_kg,
        center_of_mass_m,
        inertia_kg_m2,
    } = mass.moved(&body_from_hub.inverse());
    let center_in_hub_m = seen.skew.foot.coords - Vector3::z() * middle_z_m;
    let axis = seen.axis;
    let from_center = center_of_mass_m - center_in_hub_m;
    let radius_m = wheel_radius_m - seen.skew.ring_radius_m;
    let off_axis_m = (from_center - axis.into_inner() * from_center.dot(&axis)).norm();
    if off_axis_m > 0.05 * radius_m {
        remarks.push(remark(
            format!("link `{link}`"),
            format!(
                "its centre of mass is {:.2} mm off the roller's axis; it is taken as on it",
                1e3 * off_axis_m
            ),
        ));
    }
    if radius_m <= 0.0 {
        let fault = Fault::RollersDiffer {
            quantity: "the distance from the hub axis",
            this: format!("{:.2} mm", 1e3 * seen.skew.ring_radius_m),
            others: format!(
                "less than the wheel's radius, {:.2} mm,",
                1e3 * wheel_radius_m
            ),
        };
        return Err(source.joint_error(&joint.name, fault));
    }
    let axial_inertia_kg_m2 = axis.dot(&(inertia_kg_m2 * axis.into_inner()));
    // No longer than where its barrel tapers to nothing.
    let gamma_rad = seen.skew.gamma_rad;
    let longest_m = 2.0
        * barrel_half_length_m(
            seen.skew.ring_radius_m,
            wheel_radius_m,
            gamma_rad,
            FRAC_PI_2,
        );
    let length_m = 2.0 * seen.outline.half_length_m.unwrap_or_default();
    if length_m > longest_m {
        remarks.push(remark(
            format!("joint `{}`", joint.name),
            format!(
                "the roller is {:.2} mm long, but its barrel tapers to nothing at {:.2} mm, which is taken",
                1e3 * length_m,
                1e3 * longest_m
            ),
        ));
    }
    Ok(Roller {
        name: joint.name.clone(),
        center_in_hub_m,
        axis_in_hub: axis,
        radius_m,
        length_m: length_m.min(longest_m),
        mass_kg,
        axial_inertia_kg_m2,
        // The trace is the same in every frame.
        transverse_inertia_kg_m2: 0.5 * (inertia_kg_m2.trace() - axial_inertia_kg_m2),
        joint: joint.losses,
        form: RollerForm::Barrel,
    })
}

/// The file's own shapes of a roller, in its frame.
fn as_modelled(
    roller: &Roller,
    seen: &Seen,
    middle_z_m: f64,
    meshes: &Meshes,
) -> Result<ModelledRoller, Fault> {
    // What was seen is placed in the frame about the joint's origin; the hub's frame has the wheel's middle.
    let hub_from_seen = Translation3::new(0.0, 0.0, -middle_z_m);
    let roller_from_seen = roller.hub_from_roller().inverse() * hub_from_seen;
    let mut shapes = Vec::with_capacity(seen.shapes.len());
    for PlacedShape {
        body_from_shape,
        geometry,
    } in &seen.shapes
    {
        let shape = match (primitive(geometry), geometry) {
            (Some(shape), _) => shape,
            (None, Geometry::Mesh { filename, scale }) => {
                let scale = scale.map_or(Vector3::repeat(1.0), |s| Vector3::from(*s));
                let vertices = meshes.vertices(filename)?;
                let points_m = vertices
                    .iter()
                    .map(|v| Point3::from(v.coords.component_mul(&scale)));
                CollisionShape::ConvexHull {
                    points_m: points_m.collect(),
                }
            }
            (None, _) => continue,
        };
        shapes.push(Collision {
            body_from_shape: roller_from_seen * body_from_shape,
            shape,
        });
    }
    Ok(ModelledRoller {
        shapes,
        // Counted from the foot, which is the roller's centre, along the joint's axis, which is z of its frame.
        profile: seen.profile.clone(),
    })
}
