//! Rollers for wheels that have none in the file, as a person asks for them.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Unit, Vector3};
use urdf_rs::Geometry;

use super::measure::{check_level, hub_frame, remark_motor};
use super::options::{Handedness, WheelOptions};
use super::recognise::Candidate;
use super::tree::{Motion, RigidBody};
use super::{Loading, remark};
use crate::error::{Fault, RobotError};
use crate::model::mass::principal_moments;
use crate::model::{Barrel, Joint, MassProperties, Roller, RollerForm, Wheel};

/// Density of rubber, for rollers of which no mass is said, in kg/m^3.
const RUBBER_KG_M3: f64 = 1100.0;

/// A wheel joint that is given rollers, and its gamma.
pub(super) struct Given {
    pub(super) joint: usize,
    gamma_rad: f64,
}

/// The joints that the options name, with gamma of each.
pub(super) fn joints(
    loading: &Loading,
    options: &WheelOptions,
    candidates: &[Candidate],
) -> Result<Vec<Given>, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    check(loading, options)?;
    let named: Vec<usize> = if options.joints.is_empty() {
        tree.plain_wheels()
    } else {
        let find = |name: &String| {
            let turning = |j: &usize| tree.joints[*j].motion == Motion::Turning;
            let all = || (0..tree.joints.len()).filter(turning);
            all()
                .find(|&j| tree.joints[j].name == *name)
                .ok_or_else(|| {
                    source.robot_error(Fault::NoSuchWheel {
                        joint: name.clone(),
                        turning: all().map(|j| tree.joints[j].name.clone()).collect(),
                    })
                })
        };
        options.joints.iter().map(find).collect::<Result<_, _>>()?
    };
    for &j in &named {
        let joint = &tree.joints[j];
        check_level(source, joint)?;
        if candidates.iter().any(|c| c.hub == j) {
            return Err(source.joint_error(&joint.name, Fault::HasRollers));
        }
    }
    let gammas_deg = match &options.gamma {
        Handedness::AllDeg(gamma_deg) => vec![*gamma_deg; named.len()],
        Handedness::EachDeg(gammas_deg) => gammas_deg.clone(),
        Handedness::XDeg(gamma_deg) => in_x(loading, &named, *gamma_deg)?,
    };
    if gammas_deg.len() != named.len() {
        return Err(source.robot_error(Fault::OutOfRange {
            key: "gamma.each_deg".to_owned(),
            value: format!("{} numbers", gammas_deg.len()),
            range: "as long as the list of wheels",
        }));
    }
    let given = |(joint, gamma_deg): (usize, f64)| Given {
        joint,
        gamma_rad: gamma_deg.to_radians(),
    };
    Ok(named.into_iter().zip(gammas_deg).map(given).collect())
}

fn check(loading: &Loading, options: &WheelOptions) -> Result<(), RobotError> {
    let out_of_range = |key: &str, value: String, range| {
        let key = format!("robot.wheels.{key}");
        Err(loading
            .source
            .robot_error(Fault::OutOfRange { key, value, range }))
    };
    if !(3..=1000).contains(&options.rollers) {
        return out_of_range("rollers", options.rollers.to_string(), "from 3 to 1000");
    }
    let gammas_deg = match &options.gamma {
        Handedness::AllDeg(gamma_deg) | Handedness::XDeg(gamma_deg) => {
            std::slice::from_ref(gamma_deg)
        }
        Handedness::EachDeg(gammas_deg) => gammas_deg,
    };
    if let Some(gamma_deg) = gammas_deg.iter().find(|g| g.is_nan() || g.abs() > 85.0) {
        return out_of_range("gamma", gamma_deg.to_string(), "from -85 to 85 degrees");
    }
    for (key, value) in [
        ("radius_m", options.radius_m),
        ("roller_radius_m", options.roller_radius_m),
        ("roller_mass_kg", options.roller_mass_kg),
    ] {
        if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return out_of_range(key, value.to_string(), "a finite number above 0");
        }
    }
    for (key, value) in [
        ("damping_n_m_s", options.damping_n_m_s),
        ("friction_n_m", options.friction_n_m),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return out_of_range(key, value.to_string(), "a finite number, 0 or above");
        }
    }
    Ok(())
}

/// gamma of each wheel in the usual X: negative where x and y from the middle have one sign. With the hub axis along y
/// the roller's axis on the ground is then (-cos gamma, -sin gamma) ~ (-1, 1) at the front left, across the arm (1, 1).
fn in_x(loading: &Loading, joints: &[usize], gamma_deg: f64) -> Result<Vec<f64>, RobotError> {
    let tree = loading.tree;
    let count = joints.len().max(1) as f64;
    let middle: Vector3<f64> = joints
        .iter()
        .map(|&j| tree.joints[j].origin.coords)
        .sum::<Vector3<f64>>()
        / count;
    joints
        .iter()
        .map(|&j| {
            let joint = &tree.joints[j];
            let from_middle = joint.origin.coords - middle;
            let not_in_x = |what| {
                Err(loading
                    .source
                    .joint_error(&joint.name, Fault::NotInX { what }))
            };
            if joint.axis.y.abs() < 0.99 {
                return not_in_x("the hub axis does not lie along y");
            }
            if from_middle.x.abs() < 1e-3 || from_middle.y.abs() < 1e-3 {
                return not_in_x("the wheel stands on a middle line");
            }
            Ok(-gamma_deg.abs().copysign(from_middle.x * from_middle.y))
        })
        .collect()
}

/// A wheel with its rollers put in.
pub(super) fn wheel(
    loading: &mut Loading,
    options: &WheelOptions,
    given: &Given,
    body: &RigidBody,
) -> Result<Wheel, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let joint = &tree.joints[given.joint];
    let link = &tree.links[body.link].name;
    let whole = body
        .mass
        .as_ref()
        .ok_or_else(|| source.inertial_error(link, Fault::NoMass))?;
    let frame = hub_frame(&joint.origin, &joint.axis);
    let (size_m, middle_m) =
        size(loading, body, &frame).map_err(|fault| source.link_error(link, fault))?;
    let radius_m = options
        .radius_m
        .or(size_m)
        .ok_or_else(|| source.link_error(link, Fault::WheelSizeUnknown))?;
    let body_from_hub = hub_frame(&(frame * Point3::new(0.0, 0.0, middle_m)), &joint.axis);
    let whole = whole.moved(&body_from_hub.inverse());

    let count = options.rollers;
    let gamma_rad = given.gamma_rad;
    // The end spheres keep a positive radius where rho > a / cos(pi/n): r_max > rho (1 - cos(pi/n)).
    let least_radius_m = radius_m * (1.0 - libm::cos(PI / count as f64));
    let roller_radius_m = options
        .roller_radius_m
        .unwrap_or(f64::max(0.2 * radius_m, 1.3 * least_radius_m));
    if roller_radius_m <= least_radius_m || roller_radius_m >= radius_m {
        return Err(source.joint_error(
            &joint.name,
            Fault::RollersTooSlender {
                roller_radius_mm: 1e3 * roller_radius_m,
                least_radius_mm: 1e3 * least_radius_m,
            },
        ));
    }
    let barrel = Barrel::handing_over(radius_m, roller_radius_m, gamma_rad, count);
    let most_kg = 0.5 * whole.mass_kg / count as f64;
    let mass_kg = match options.roller_mass_kg {
        Some(mass_kg) if mass_kg * count as f64 >= whole.mass_kg => {
            return Err(source.joint_error(
                &joint.name,
                Fault::OutOfRange {
                    key: "robot.wheels.roller_mass_kg".to_owned(),
                    value: mass_kg.to_string(),
                    range: "so light that all rollers weigh less than the wheel",
                },
            ));
        }
        Some(mass_kg) => mass_kg,
        None => f64::min(RUBBER_KG_M3 * barrel.volume_m3(), most_kg),
    };
    let (axial, across) = barrel.solid_moments_kg_m2(mass_kg);
    // The roller that points down: cos gamma y - sin gamma z in the hub frame (see the module on rollers).
    let down_axis = Vector3::new(0.0, libm::cos(gamma_rad), -libm::sin(gamma_rad));
    let mut rollers: Vec<Roller> = (0..count)
        .map(|i| {
            let around =
                Rotation3::from_axis_angle(&Vector3::z_axis(), TAU * i as f64 / count as f64);
            Roller {
                name: format!("{}_roller_{}", joint.name, i + 1),
                center_in_hub_m: around * Vector3::new(barrel.ring_radius_m, 0.0, 0.0),
                axis_in_hub: Unit::new_normalize(around * down_axis),
                radius_m: roller_radius_m,
                length_m: 2.0 * barrel.half_length_m,
                mass_kg,
                axial_inertia_kg_m2: axial,
                transverse_inertia_kg_m2: across,
                joint: Joint {
                    damping_n_m_s: options.damping_n_m_s,
                    friction_n_m: options.friction_n_m,
                },
                form: RollerForm::Barrel,
            }
        })
        .collect();
    rollers.sort_by(|p, q| p.place_rad().total_cmp(&q.place_rad()));
    let hub = without(&whole, &rollers);
    loading.remarks.push(remark(
        format!("wheel `{}`", joint.name),
        format!(
            "given {count} rollers of radius {:.1} mm and {:.1} g at gamma = {:.1} deg; the wheel's radius is {:.1} mm",
            1e3 * roller_radius_m,
            1e3 * mass_kg,
            gamma_rad.to_degrees(),
            1e3 * radius_m
        ),
    ));
    remark_motor(&joint.name, &joint.limits, &mut loading.remarks);
    Ok(Wheel {
        name: joint.name.clone(),
        body_from_hub,
        hub,
        radius_m,
        gamma_rad,
        rollers,
        motor: joint.limits,
        joint: joint.losses,
    })
}

/// The hub that is left of a whole wheel when its rollers are taken out. Where the file's inertia is too small to hold
/// them, the hub keeps its share by mass.
fn without(whole: &MassProperties, rollers: &[Roller]) -> MassProperties {
    let rollers_kg: f64 = rollers.iter().map(|r| r.mass_kg).sum();
    let mass_kg = whole.mass_kg - rollers_kg;
    // The rollers stand evenly around the wheel's middle, where their common centre of mass is; the moment of what is
    // left keeps the whole's centre of mass.
    let center_of_mass_m = whole.center_of_mass_m * (whole.mass_kg / mass_kg);
    let origin = Vector3::zeros();
    let of_roller = |r: &Roller| {
        let d = r.axis_in_hub.into_inner();
        let along = d * d.transpose();
        let roller = MassProperties {
            mass_kg: r.mass_kg,
            center_of_mass_m: r.center_in_hub_m,
            inertia_kg_m2: along * r.axial_inertia_kg_m2
                + (Matrix3::identity() - along) * r.transverse_inertia_kg_m2,
        };
        roller.inertia_about(&origin)
    };
    let about_origin =
        whole.inertia_about(&origin) - rollers.iter().map(of_roller).sum::<Matrix3<f64>>();
    let mut hub = MassProperties {
        mass_kg,
        center_of_mass_m,
        inertia_kg_m2: whole.inertia_kg_m2 * (mass_kg / whole.mass_kg),
    };
    let inertia_kg_m2 = about_origin - hub.inertia_of_place(&origin);
    let [least, middle, most] = principal_moments(inertia_kg_m2);
    if least > 0.0 && least + middle >= most {
        hub.inertia_kg_m2 = inertia_kg_m2;
    }
    hub
}

/// Radius of a wheel from its collision geometry, and where its middle is along the hub axis from the joint.
fn size(
    loading: &Loading,
    body: &RigidBody,
    body_from_frame: &Isometry3<f64>,
) -> Result<(Option<f64>, f64), Fault> {
    let mut largest: Option<(f64, f64)> = None;
    for shape in &body.shapes {
        let from_shape = body_from_frame.inverse() * shape.body_from_shape;
        let center = from_shape.translation.vector;
        let along = (from_shape * Vector3::z()).z.abs();
        let off_m = center.xy().norm();
        let found = match &shape.geometry {
            Geometry::Sphere { radius } => Some((off_m + radius, center.z)),
            Geometry::Cylinder { radius, .. } if along > 0.99 => Some((off_m + radius, center.z)),
            Geometry::Mesh { filename, scale } => match loading.meshes.vertices(filename) {
                Ok(vertices) => {
                    let scale = scale.map_or(Vector3::repeat(1.0), |s| Vector3::from(*s));
                    let placed = vertices
                        .iter()
                        .map(|v| from_shape * Point3::from(v.coords.component_mul(&scale)));
                    let (mut radius, mut low, mut high) =
                        (0.0f64, f64::INFINITY, f64::NEG_INFINITY);
                    for v in placed {
                        radius = radius.max(v.xy().coords.norm());
                        (low, high) = (low.min(v.z), high.max(v.z));
                    }
                    Some((radius, 0.5 * (low + high)))
                }
                // A missing mesh matters only where no other shape shows the size.
                Err(fault) if body.shapes.len() == 1 && loading.needs_wheel_size() => {
                    return Err(fault);
                }
                Err(_) => None,
            },
            _ => None,
        };
        if let Some(found) = found.filter(|f| largest.is_none_or(|l| f.0 > l.0)) {
            largest = Some(found);
        }
    }
    Ok((largest.map(|l| l.0), largest.map_or(0.0, |l| l.1)))
}
