//! Reads a roller from its joint and its geometry.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Isometry3, Translation3, Unit, Vector3};
use urdf_rs::Geometry;

use super::body::RigidBody;
use super::disc::NoDisc;
use super::faults::Faults;
use super::geometry::{self, mesh_hull, primitive};
use super::loading::Loading;
use super::mesh::Meshes;
use super::recognise::Candidate;
use super::roller_dimensions::{self, DrawnOutline, Skew};
use super::roller_gaps::barrel_half_length_m;
use super::source::Source;
use super::transmission;
use super::tree::{PlacedShape, Tree};
use super::wheel_size::Unsized;
use crate::error::{Fault, RobotError};
use crate::generate::elements::spheres_of;
use crate::model::{
    Barrel, Collision, MassProperties, ModelledRoller, Profile, ProfilePart, Remark, Roller,
    RollerForm,
};
use crate::options::RollerForms;

/// If gamma is closer to 90 degrees than this, the rollers turn with the hub.
const LEAST_CARRY_RAD: f64 = 0.035;

/// A roller's joint and geometry, in a frame on the hub axis.
pub(super) struct RollerGeometry {
    pub(super) joint: usize,
    pub(super) body: RigidBody,
    pub(super) axis: Unit<Vector3<f64>>,
    pub(super) skew: Skew,
    /// Shapes in the frame of the axis and foot.
    pub(super) shapes: Vec<PlacedShape>,
    pub(super) profile: Profile,
    pub(super) outline: DrawnOutline,
}

/// Reads all rollers of a wheel from a frame on its hub axis.
pub(super) fn rollers(
    loading: &mut Loading,
    candidate: &Candidate,
    body_from_joint: &Isometry3<f64>,
    hub: &RigidBody,
) -> Result<Vec<RollerGeometry>, RobotError> {
    let count = candidate.rollers.len();
    let name = &loading.tree.joints[candidate.hub].name;
    let given_m = match loading.options.rollers {
        RollerForms::Barrel => transmission::given_radius_m(loading.source, name),
        RollerForms::AsModelled => None,
    };
    let mut faults = Faults::default();
    let mut seen = Vec::with_capacity(candidate.rollers.len());
    let mut bare: Vec<Fault> = Vec::new();
    for &j in &candidate.rollers {
        let look = see(loading, j, body_from_joint, (count, given_m), &mut bare);
        seen.extend(faults.keep(look).flatten());
    }
    faults.into_result()?;
    let joint = &loading.tree.joints[candidate.hub];
    let Some(fault) = bare.first() else {
        return Ok(seen);
    };
    let radius_m = loading.options.wheel_radius_m;
    let unsized_wheel = Unsized {
        joint: candidate.hub,
        origin: joint.origin,
        axis: joint.axis,
        body: hub,
        ring_m: ring_m(loading, candidate, body_from_joint),
        roller_m: match radius_m {
            // If a radius is given, rollers without a shape received one.
            Some(_) => None,
            None => seen
                .iter()
                .flat_map(|of| of.profile.parts())
                .map(|part| part.ring_m + part.ball_m)
                .reduce(f64::max),
        },
    };
    if let Some(radius_m) = radius_m.filter(|_| seen.len() == candidate.rollers.len()) {
        let words = format!(
            "{} of its rollers have no geometry that can be read, and are taken to reach its radius; {}",
            bare.len(),
            unsized_wheel.words_on(loading, radius_m)
        );
        let subject = format!("wheel `{}`", joint.name);
        loading.remarks.push(Remark::new(subject, words));
        return Ok(seen);
    }
    let why = match fault {
        Fault::RollerWithoutShape => {
            NoDisc::NotRound(format!("{} of its rollers have no geometry", bare.len()))
        }
        other => NoDisc::Unreadable(other.clone()),
    };
    let fault = unsized_wheel.fault(loading, &why);
    Err(loading.source.joint_error(&joint.name, fault))
}

/// Returns the mean distance of the rollers' axes from the hub axis, in metres.
fn ring_m(
    loading: &Loading,
    candidate: &Candidate,
    body_from_joint: &Isometry3<f64>,
) -> Option<f64> {
    let hub_from_body = body_from_joint.inverse();
    let rings_m = candidate.rollers.iter().map(|&j| {
        let joint = &loading.tree.joints[j];
        let axis = Unit::new_unchecked(hub_from_body * joint.axis.into_inner());
        Some(roller_dimensions::skew(&(hub_from_body * joint.origin), &axis)?.ring_radius_m)
    });
    let rings_m = rings_m.collect::<Option<Vec<f64>>>()?;
    Some(rings_m.iter().sum::<f64>() / rings_m.len() as f64)
}

fn see(
    loading: &Loading,
    j: usize,
    body_from_joint: &Isometry3<f64>,
    (count, given_m): (usize, Option<f64>),
    bare: &mut Vec<Fault>,
) -> Result<Option<RollerGeometry>, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let joint = &tree.joints[j];
    let hub_from_body = body_from_joint.inverse();
    let axis = Unit::new_unchecked(hub_from_body * joint.axis.into_inner());
    let skew = roller_dimensions::skew(&(hub_from_body * joint.origin), &axis)
        .filter(|skew| skew.gamma_rad.abs() < FRAC_PI_2 - LEAST_CARRY_RAD)
        .ok_or_else(|| source.joint_error(&joint.name, Fault::GammaRightAngle))?;
    let body = tree.rigid_body(joint.child, |_| false);
    let shown = if body.shapes.is_empty() {
        &body.visuals
    } else {
        &body.shapes
    };
    let shapes: Vec<PlacedShape> = shown
        .iter()
        .map(|s| PlacedShape {
            body_from_shape: hub_from_body * s.body_from_shape,
            geometry: s.geometry.clone(),
        })
        .collect();
    let drawn = match given_m {
        Some(radius_m) => ideal(&skew, radius_m, count),
        None => geometry::profile(&skew.foot, &axis, &shapes, &loading.meshes),
    };
    let profile = match drawn {
        Ok(profile) => profile,
        Err(fault) => {
            let unreadable = matches!(
                fault,
                Fault::RollerWithoutShape
                    | Fault::MeshUnreadable { .. }
                    | Fault::PackageUnknown { .. }
            );
            if !unreadable {
                return Err(source.link_error(&tree.links[joint.child].name, fault));
            }
            bare.push(fault);
            let ball_m = loading
                .options
                .wheel_radius_m
                .map(|rho| rho - skew.ring_radius_m);
            let Some(ball_m) = ball_m.filter(|ball_m| *ball_m > 0.0) else {
                return Ok(None);
            };
            let ball = ProfilePart {
                t_m: 0.0,
                ring_m: 0.0,
                ball_m,
            };
            Profile::of(ball)
        }
    };
    let outline = roller_dimensions::outline(&skew, &profile, PI / count as f64);
    Ok(Some(RollerGeometry {
        joint: j,
        body,
        axis,
        skew,
        shapes,
        profile,
        outline,
    }))
}

/// Returns the spheres of the ideal barrel that rollers of a radius are made from.
fn ideal(skew: &Skew, radius_m: f64, count: usize) -> Result<Profile, Fault> {
    let wheel_radius_m = skew.ring_radius_m + radius_m;
    let barrel = Barrel::handing_over(wheel_radius_m, radius_m, skew.gamma_rad, count);
    let parts = spheres_of(&barrel).map(|[t_m, ball_m]| ProfilePart {
        t_m,
        ring_m: 0.0,
        ball_m,
    });
    Profile::new(parts.collect()).ok_or(Fault::RollerWithoutShape)
}

/// Checks that all rollers of a wheel imply the same wheel.
pub(super) fn check_alike(
    source: &Source,
    tree: &Tree,
    seen: &[RollerGeometry],
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

/// A single sphere gives a roller's thickness but not its length: it is assumed to reach its
/// neighbours. Returns the number of such rollers.
pub(super) fn give_lone_spheres_a_length(
    wheel: &str,
    seen: &mut [RollerGeometry],
    radius_m: f64,
    remarks: &mut Vec<Remark>,
) -> usize {
    let place_rad = |s: &RollerGeometry| libm::atan2(s.skew.foot.y, s.skew.foot.x);
    let places: Vec<f64> = seen.iter().map(place_rad).collect();
    let mut lone = 0;
    let mut dip_m: f64 = 0.0;
    for (i, s) in seen.iter_mut().enumerate() {
        if s.outline.half_length_m.is_some() {
            continue;
        }
        // The wider of the gaps to the two neighbours.
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
        remarks.push(Remark::new(format!("wheel `{wheel}`"), format!(
                "{lone} of {} rollers show no length (lone spheres, or no shape): each is taken as a barrel that reaches its \
                 neighbours; as spheres the wheel would dip {:.2} mm between them",
                seen.len(),
                1e3 * dip_m
            )));
    }
    lone
}

/// Adds a remark on where the rollers deviate from the fitted circle.
pub(super) fn remark_outline(
    wheel: &str,
    seen: &[RollerGeometry],
    radius_m: f64,
    remarks: &mut Vec<Remark>,
) {
    let off_circle =
        |s: &RollerGeometry| s.outline.error_m + (s.outline.wheel_radius_m - radius_m).abs();
    let worst_m = seen.iter().map(off_circle).fold(0.0, f64::max);
    if worst_m > 1e-3 * radius_m {
        remarks.push(Remark::new(format!("wheel `{wheel}`"), format!(
                "the rollers as modelled leave the circle of radius {:.2} mm by up to {:.2} mm; they are taken as the \
                 barrels that fit it",
                1e3 * radius_m,
                1e3 * worst_m
            )));
    }
    let off_middle = |s: &RollerGeometry| {
        s.outline.middle_m.abs() / s.outline.half_length_m.unwrap_or(f64::INFINITY)
    };
    let worst = seen.iter().map(off_middle).fold(0.0, f64::max);
    if worst > 0.05 {
        remarks.push(Remark::new(format!("wheel `{wheel}`"), format!(
                "rollers sit up to {:.0} % of their half length off the point nearest to the hub axis; they are taken \
                 as centred there",
                100.0 * worst
            )));
    }
}

/// Returns the roller of the model.
pub(super) fn roller(
    source: &Source,
    tree: &Tree,
    seen: &RollerGeometry,
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
        remarks.push(Remark::new(
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
    // At most the length at which its barrel tapers to nothing.
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
        remarks.push(Remark::new(
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

/// Returns the file's own shapes of a roller, in its frame.
pub(super) fn as_modelled(
    roller: &Roller,
    seen: &RollerGeometry,
    middle_z_m: f64,
    meshes: &Meshes,
) -> Result<ModelledRoller, Fault> {
    // The shapes are in the frame about the joint's origin; the hub frame has the wheel's middle.
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
            (None, Geometry::Mesh { filename, scale }) => mesh_hull(meshes, filename, *scale)?,
            (None, _) => continue,
        };
        shapes.push(Collision {
            friction: None,
            body_from_shape: roller_from_seen * body_from_shape,
            shape,
        });
    }
    Ok(ModelledRoller {
        shapes,
        // Counted from the foot, which is the roller's centre, along the joint's axis, which is z
        // of its frame.
        profile: seen.profile.clone(),
    })
}
