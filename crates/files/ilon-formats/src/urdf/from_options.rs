//! Adds the requested rollers to wheels that have none in the file.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};

use super::body::RigidBody;
use super::candidates::{self, Survey, WheelLike};
use super::disc::{self, Disc};
use super::hub::{check_level, hub_frame, remark_motor};
use super::loading::Loading;
use super::recognise::Candidate;
use super::tree::Motion;
use super::wheel_size::Unsized;
use crate::error::{Fault, RobotError};
use crate::model::mass::principal_moments;
use crate::model::{
    Barrel, DriveTrain, Joint, MassProperties, Remark, Roller, RollerForm, RollerSurface,
    RollersAsMade, Wheel,
};
use crate::options::{Handedness, TyreOptions, WheelOptions};

/// Density of rubber, for rollers without a given mass, in kg/m^3.
const RUBBER_KG_M3: f64 = 1100.0;
/// Width of the tyre of a wheel whose geometry shows none, such as a sphere, over its radius
/// (chosen).
const WIDTH_SHARE: f64 = 0.4;
/// A wheel this close to the middle line of the X is in the middle, in metres.
const IN_THE_MIDDLE_M: f64 = 1e-3;

/// A wheel without rollers in the file.
pub(super) struct BareWheel {
    pub(super) like: WheelLike,
    gives: Gives,
}

impl BareWheel {
    /// Whether it rolls on a tyre.
    pub(super) fn has_tyre(&self) -> bool {
        matches!(self.gives, Gives::Tyre(..))
    }

    /// Whether it rolls on a tyre that nothing drives.
    pub(super) fn rolls_along(&self) -> bool {
        matches!(self.gives, Gives::Tyre(_, false))
    }
}

/// What such a wheel is given.
enum Gives {
    /// Rollers at this gamma, in radians.
    Rollers(f64),
    /// A tyre, and whether a motor drives it.
    Tyre(TyreOptions, bool),
}

/// Returns the wheels that roll on tyres, as the options name them.
pub(super) fn tyred(
    loading: &Loading,
    options: &TyreOptions,
    (candidates, given): (&[Candidate], &[BareWheel]),
    survey: &Survey,
) -> Result<Vec<BareWheel>, RobotError> {
    for (key, value) in [
        ("tyres.width_m", options.width_m),
        // Sharp shoulders have the radius 0.
        (
            "tyres.shoulder_radius_m",
            options.shoulder_radius_m.filter(|m| *m != 0.0),
        ),
    ] {
        if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(loading.source.robot_error(Fault::OutOfRange {
                key: key.to_owned(),
                value: value.to_string(),
                range: "a finite number above 0",
            }));
        }
    }
    let is_free = |like: &&WheelLike| given.iter().all(|of| of.like.joint != like.joint);
    let likes = options
        .joints
        .iter()
        .map(|name| named(loading, name, candidates, survey));
    let likes: Vec<WheelLike> = likes.collect::<Result<_, _>>()?;
    let free = options.free.iter();
    let free = free.map(|name| named(loading, name, candidates, survey));
    let free: Vec<WheelLike> = free.collect::<Result<_, _>>()?;
    let all = || likes.iter().chain(&free);
    for (place, like) in all().enumerate() {
        let name = &loading.tree.joints[like.joint].name;
        check_level(loading.source, name, &like.axis)?;
        if !is_free(&like) {
            return Err(loading.source.joint_error(name, Fault::HasRollers));
        }
        if all().take(place).any(|other| other.joint == like.joint) {
            return Err(loading.source.robot_error(Fault::OutOfRange {
                key: "tyres.joints".to_owned(),
                value: format!("a list with `{name}` twice"),
                range: "each wheel once, in `joints` or in `free`",
            }));
        }
    }
    let given = |(like, driven)| BareWheel {
        like,
        gives: Gives::Tyre(options.clone(), driven),
    };
    let driven = likes.into_iter().map(|like| (like, true));
    let idle = free.into_iter().map(|like| (like, false));
    Ok(driven.chain(idle).map(given).collect())
}

/// Returns the wheels that the options name, by default those that turn and stand on the floor,
/// with gamma of each.
pub(super) fn wheels(
    loading: &Loading,
    options: &WheelOptions,
    candidates: &[Candidate],
    survey: &Survey,
) -> Result<Vec<BareWheel>, RobotError> {
    check(loading, options)?;
    let likes = if options.joints.is_empty() {
        survey.turning.clone()
    } else {
        let found = options
            .joints
            .iter()
            .map(|name| named(loading, name, candidates, survey));
        found.collect::<Result<_, _>>()?
    };
    for like in &likes {
        check_level(
            loading.source,
            &loading.tree.joints[like.joint].name,
            &like.axis,
        )?;
    }
    let gammas_deg = match &options.gamma {
        Handedness::AllDeg(gamma_deg) => vec![*gamma_deg; likes.len()],
        Handedness::EachDeg(gammas_deg) => gammas_deg.clone(),
        Handedness::XDeg(gamma_deg) => in_x_deg(&likes, *gamma_deg).map_err(|(i, what)| {
            let name = &loading.tree.joints[likes[i].joint].name;
            loading.source.joint_error(name, Fault::NotInX { what })
        })?,
    };
    if gammas_deg.len() != likes.len() {
        return Err(loading.source.robot_error(Fault::OutOfRange {
            key: "gamma.each_deg".to_owned(),
            value: format!("{} numbers", gammas_deg.len()),
            range: "as long as the list of wheels",
        }));
    }
    let given = |(like, gamma_deg): (WheelLike, f64)| BareWheel {
        like,
        gives: Gives::Rollers(gamma_deg.to_radians()),
    };
    Ok(likes.into_iter().zip(gammas_deg).map(given).collect())
}

/// Returns the joint with a name as a wheel.
fn named(
    loading: &Loading,
    name: &str,
    candidates: &[Candidate],
    survey: &Survey,
) -> Result<WheelLike, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let Some(j) = tree.joints.iter().position(|joint| joint.name == name) else {
        let likely = survey.likely();
        let names = likely
            .iter()
            .map(|like| tree.joints[like.joint].name.clone());
        return Err(source.robot_error(Fault::NoSuchJoint {
            joint: name.to_owned(),
            likely: names.collect(),
            looked: survey.looked.clone(),
        }));
    };
    if candidates.iter().any(|c| c.hub == j) {
        return Err(source.joint_error(name, Fault::HasRollers));
    }
    candidates::named(tree, j, &loading.meshes)
        .map_err(|reason| source.joint_error(name, Fault::NotAWheel { reason }))
}

fn check(loading: &Loading, options: &WheelOptions) -> Result<(), RobotError> {
    let out_of_range = |key: &str, value: String, range| {
        let key = key.to_owned();
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

/// Returns gamma of each wheel in the usual X, or for a negative gamma in the O, which is the X
/// reversed. In the X gamma is negative if the wheel's coordinates ahead of the middle and to the
/// left of it have the same sign, in the frame whose hub axes point left. With the hub axis along y
/// the roller's axis on the ground is then (-cos gamma, -sin gamma) ~ (-1, 1) at the front left,
/// across the arm (1, 1). An axle in the middle is handed like one ahead.
///
/// The error is the index of a wheel that does not fit an X, with the reason.
pub(super) fn in_x_deg(
    likes: &[WheelLike],
    gamma_deg: f64,
) -> Result<Vec<f64>, (usize, &'static str)> {
    let Some(first) = likes.first() else {
        return Ok(Vec::new());
    };
    let count = likes.len() as f64;
    let middle = likes
        .iter()
        .map(|w| w.middle().coords)
        .sum::<Vector3<f64>>()
        / count;
    // The left of the frame: along the axes, towards y if closer to it, otherwise towards x.
    let axis = first.axis.into_inner();
    let leading = if axis.y.abs() >= axis.x.abs() {
        axis.y
    } else {
        axis.x
    };
    let left = axis * 1f64.copysign(leading);
    let ahead = left.cross(&Vector3::z());
    let of_like = |(i, like): (usize, &WheelLike)| {
        if like.axis.dot(&left).abs() < 0.99 {
            return Err((i, "the hub axis does not lie along that of the others"));
        }
        let from_middle = like.middle().coords - middle;
        let (x, y) = (from_middle.dot(&ahead), from_middle.dot(&left));
        if y.abs() < IN_THE_MIDDLE_M {
            return Err((i, "the wheel stands on the middle line that runs ahead"));
        }
        let x = if x.abs() < IN_THE_MIDDLE_M { 1.0 } else { x };
        Ok(-gamma_deg * 1f64.copysign(x * y))
    };
    likes.iter().enumerate().map(of_like).collect()
}

/// Returns a wheel with its added rollers, as these options describe them, or its tyre.
pub(super) fn wheel(
    loading: &mut Loading,
    options: Option<&WheelOptions>,
    given: &BareWheel,
    body: &RigidBody,
) -> Result<Wheel, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let joint = &tree.joints[given.like.joint];
    let link = &tree.links[body.link].name;
    let whole = body
        .mass
        .as_ref()
        .ok_or_else(|| source.inertial_error(link, Fault::NoMass))?;
    let (radius_m, middle_m) =
        size(loading, given, body).map_err(|fault| source.link_error(link, fault))?;
    let axis = &given.like.axis;
    let frame = hub_frame(&given.like.origin, axis);
    let body_from_hub = hub_frame(&(frame * Point3::new(0.0, 0.0, middle_m)), axis);
    let whole = whole.moved(&body_from_hub.inverse());
    let (gamma_rad, rollers) = match (&given.gives, options) {
        (Gives::Tyre(tyre, _), _) => (0.0, tyre_of(loading, tyre, (given, body), radius_m)),
        (Gives::Rollers(gamma_rad), Some(options)) => {
            let rollers = rollers(options, *gamma_rad, &joint.name, radius_m, whole.mass_kg);
            (*gamma_rad, rollers)
        }
        (Gives::Rollers(gamma_rad), None) => (*gamma_rad, Ok(Vec::new())),
    };
    let rollers = rollers.map_err(|fault| source.joint_error(&joint.name, fault))?;
    remark_given(loading, given, &rollers, radius_m);
    let mut motor = joint.limits;
    if let Gives::Tyre(_, false) = given.gives {
        motor.effort_n_m = 0.0;
    } else {
        remark_motor(&joint.name, &motor, &mut loading.remarks);
    }
    Ok(Wheel {
        name: joint.name.clone(),
        carrier: None,
        body_from_hub,
        hub: match given.gives {
            Gives::Tyre(..) => whole,
            Gives::Rollers(_) => without(&whole, &rollers),
        },
        radius_m,
        gamma_rad,
        rollers,
        motor,
        joint: joint.losses,
        drive: DriveTrain::default(),
        surface: RollerSurface::default(),
        material: None,
        made: RollersAsMade::default(),
    })
}

/// Returns the wheel's radius, and the position of its middle along the hub axis.
fn size(loading: &mut Loading, given: &BareWheel, body: &RigidBody) -> Result<(f64, f64), Fault> {
    let like = &given.like;
    let shown = disc::about(body, &hub_frame(&like.origin, &like.axis), &loading.meshes);
    let unsized_wheel = Unsized {
        joint: like.joint,
        origin: like.origin,
        axis: like.axis,
        body,
        ring_m: None,
        roller_m: None,
    };
    match (loading.options.wheel_radius_m, shown) {
        (Some(radius_m), Ok(disc)) => {
            let words = format!(
                "its geometry shows a radius of {:.1} mm: {:.1} mm are taken as given",
                1e3 * disc.radius_m,
                1e3 * radius_m
            );
            if (disc.radius_m - radius_m).abs() > 1e-3 * radius_m {
                remark_wheel(loading, given, words);
            }
            Ok((radius_m, disc.middle_m))
        }
        (Some(radius_m), Err(_)) => {
            let words = unsized_wheel.words_on(loading, radius_m);
            remark_wheel(loading, given, words);
            Ok((radius_m, 0.0))
        }
        (None, Ok(disc)) => {
            remark_visual(loading, given, &disc);
            Ok((disc.radius_m, disc.middle_m))
        }
        (None, Err(why)) => Err(unsized_wheel.fault(loading, &why)),
    }
}

/// Returns the tyre of a wheel, in place of its rollers.
fn tyre_of(
    loading: &Loading,
    options: &TyreOptions,
    (given, body): (&BareWheel, &RigidBody),
    radius_m: f64,
) -> Result<Vec<Roller>, Fault> {
    let frame = hub_frame(&given.like.origin, &given.like.axis);
    let shown_m = || disc::width_m(body, &frame, &loading.meshes);
    let width_m = options.width_m.or_else(shown_m);
    let width_m = width_m.unwrap_or(WIDTH_SHARE * radius_m);
    let shoulder_m = options.shoulder_radius_m.unwrap_or(0.125 * width_m);
    let name = &loading.tree.joints[given.like.joint].name;
    let tyre = Roller::tyre(name, radius_m, width_m, shoulder_m);
    let tyre = tyre.map_err(|_| Fault::OutOfRange {
        key: "tyres".to_owned(),
        value: format!(
            "a tyre {:.1} mm wide with shoulders of {:.1} mm on a wheel of {:.1} mm",
            1e3 * width_m,
            1e3 * shoulder_m,
            1e3 * radius_m
        ),
        range: "wider than both of its shoulders together, and these smaller than the wheel",
    })?;
    Ok(vec![tyre])
}

fn remark_wheel(loading: &mut Loading, given: &BareWheel, words: String) {
    let name = &loading.tree.joints[given.like.joint].name;
    let subject = format!("wheel `{name}`");
    loading.remarks.push(Remark::new(subject, words));
}

fn remark_visual(loading: &mut Loading, given: &BareWheel, disc: &Disc) {
    if disc.of_visuals {
        let words = "it has no collision geometry: its size is taken from what is shown of it";
        remark_wheel(loading, given, words.to_owned());
    }
}

/// Returns the rollers of a wheel, in its hub frame, ordered by angle.
fn rollers(
    options: &WheelOptions,
    gamma_rad: f64,
    wheel: &str,
    radius_m: f64,
    wheel_kg: f64,
) -> Result<Vec<Roller>, Fault> {
    let count = options.rollers;
    // The end spheres keep a positive radius where rho > a / cos(pi/n): r_max > rho (1 -
    // cos(pi/n)).
    let least_radius_m = radius_m * (1.0 - libm::cos(PI / count as f64));
    let roller_radius_m = options
        .roller_radius_m
        .unwrap_or(f64::max(0.2 * radius_m, 1.3 * least_radius_m));
    if roller_radius_m <= least_radius_m || roller_radius_m >= radius_m {
        return Err(Fault::RollersTooSlender {
            key: String::new(),
            roller_radius_mm: 1e3 * roller_radius_m,
            least_radius_mm: 1e3 * least_radius_m,
        });
    }
    let barrel = Barrel::handing_over(radius_m, roller_radius_m, gamma_rad, count);
    let most_kg = 0.5 * wheel_kg / count as f64;
    let mass_kg = match options.roller_mass_kg {
        Some(mass_kg) if mass_kg * count as f64 >= wheel_kg => {
            return Err(Fault::OutOfRange {
                key: "roller_mass_kg".to_owned(),
                value: mass_kg.to_string(),
                range: "so light that all rollers weigh less than the wheel",
            });
        }
        Some(mass_kg) => mass_kg,
        None => f64::min(RUBBER_KG_M3 * barrel.volume_m3(), most_kg),
    };
    let (axial, across) = barrel.solid_moments_kg_m2(mass_kg);
    // The roller that points down: cos gamma y - sin gamma z in the hub frame (see the module
    // `roller_dimensions`).
    let down_axis = Vector3::new(0.0, libm::cos(gamma_rad), -libm::sin(gamma_rad));
    let mut rollers: Vec<Roller> = (0..count)
        .map(|i| {
            let around =
                Rotation3::from_axis_angle(&Vector3::z_axis(), TAU * i as f64 / count as f64);
            Roller {
                name: format!("{wheel}_roller_{}", i + 1),
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
    Ok(rollers)
}

/// Adds a remark on the rollers that a wheel was given, and on its joint in the file.
fn remark_given(loading: &mut Loading, given: &BareWheel, rollers: &[Roller], radius_m: f64) {
    let joint = &loading.tree.joints[given.like.joint];
    let subject = format!("wheel `{}`", joint.name);
    let (count, first) = (rollers.len(), &rollers[0]);
    let remark = match given.gives {
        Gives::Tyre(_, driven) => Remark::aside(
            subject.clone(),
            format!(
                "rolls on a tyre {:.1} mm wide{}; the wheel's radius is {:.1} mm",
                1e3 * first.length_m,
                if driven {
                    ""
                } else {
                    ", and nothing drives it"
                },
                1e3 * radius_m
            ),
        ),
        Gives::Rollers(gamma_rad) => Remark::new(
            subject.clone(),
            format!(
                "given {count} rollers of radius {:.1} mm and {:.1} g at gamma = {:.1} deg; the wheel's radius is {:.1} mm",
                1e3 * first.radius_m,
                1e3 * first.mass_kg,
                gamma_rad.to_degrees(),
                1e3 * radius_m
            ),
        ),
    };
    loading.remarks.push(remark);
    let in_the_file = match (joint.motion, joint.mimics) {
        (Motion::Turning, false) => return,
        (Motion::Turning, true) => "follows another joint in the file, which is not read",
        (Motion::Swinging, _) => "turns within limits in the file, which are not read",
        _ => "does not turn in the file",
    };
    loading.remarks.push(Remark::new(
        subject,
        format!("its joint {in_the_file}: it is taken to turn freely about its level axis"),
    ));
}

/// Returns the hub that remains when the rollers are removed from a whole wheel. If the file's
/// inertia is too small for the rollers, the hub keeps its share by mass.
fn without(whole: &MassProperties, rollers: &[Roller]) -> MassProperties {
    let rollers_kg: f64 = rollers.iter().map(|r| r.mass_kg).sum();
    let mass_kg = whole.mass_kg - rollers_kg;
    // The rollers are spread evenly around the wheel's middle, which is their common centre of
    // mass; the hub's moment restores the whole's centre of mass.
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
