//! Checks of the whole robot: its chassis, and relations between its wheels.

use nalgebra::{Unit, Vector2, Vector3};
use urdf_rs::Geometry;

use super::body::RigidBody;
use super::candidates::{Survey, WheelLike, is_called_wheel};
use super::casters::{self, REMARKED_TILT_DEG, TOUCHES};
use super::faults::Faults;
use super::from_options::BareWheel;
use super::geometry::{mesh_hull, primitive};
use super::loading::Loading;
use super::recognise::{Candidate, fixed_hubs, fixed_rollers};
use super::source::Source;
use super::tree::{Motion, PlacedShape, Tree};
use super::{inertia_doubts, infer, plausibility, schema, wheel_size};
use crate::error::{CandidateJoint, Fault, RobotError};
use crate::model::{Chassis, Collision, MassProperties, Remark, Robot, StandingPose, Wheel};

/// Smallest number of wheels that control all three degrees of freedom of the plane.
pub(super) const LEAST_WHEELS: usize = 3;
/// Above this radius the file is probably in millimetres.
const LARGEST_WHEEL_M: f64 = 5.0;
/// The largest accepted lean of a robot on its wheels, in degrees.
const MOST_TILT_DEG: f64 = 5.0;
/// A radius of gyration above this multiple of the body's reach is rejected; above the reach it is
/// doubted.
const MOST_GYRATION: f64 = 5.0;
/// Density of steel, in kg/m^3; a denser wheel is doubted.
const STEEL_KG_M3: f64 = 8000.0;

/// Why a joint that turns as a wheel does is none.
const BARE: &str = "could be a wheel, but carries no rollers";

/// Rejects fewer than three wheels, or two on tyres, with a report of what was found instead.
pub(super) fn check_wheel_count(
    loading: &Loading,
    candidates: &[Candidate],
    (given, on_tyres): (&[BareWheel], bool),
    survey: &Survey,
) -> Result<(), RobotError> {
    // Tyres hold a robot sideways: two drive it.
    let least = if on_tyres { 2 } else { LEAST_WHEELS };
    if candidates.len() + given.len() >= least {
        return Ok(());
    }
    let (source, tree) = (loading.source, loading.tree);
    let names = |likes: &[&WheelLike]| -> Vec<String> {
        let names = likes
            .iter()
            .map(|like| tree.joints[like.joint].name.clone());
        names.collect()
    };
    let hubs = fixed_hubs(tree);
    if !hubs.is_empty() {
        let mut faults = Faults::default();
        for (hub, rollers) in hubs {
            let wheels = candidates.len() + given.len();
            let fault = Fault::HubDoesNotTurn { rollers, wheels };
            faults.push(source.joint_error(&tree.joints[hub].name, fault));
        }
        faults.into_result()?;
    }
    let fixed = fixed_rollers(tree);
    if let [first, ..] = &fixed[..]
        && candidates.len() + fixed.len() >= LEAST_WHEELS
    {
        let name = |of: &Candidate| tree.joints[of.hub].name.clone();
        let fault = Fault::RollersDoNotTurn {
            rollers: first.rollers.len(),
            wheels: fixed.iter().map(name).collect(),
        };
        return Err(source.joint_error(&tree.joints[first.hub].name, fault));
    }
    if candidates.is_empty() && given.is_empty() {
        let turning: Vec<&WheelLike> = survey.turning.iter().collect();
        let likely = survey.likely();
        let steering: Vec<usize> = infer::steered(tree, survey).collect();
        let steered = survey.steered.iter();
        let steered = steered.filter(|like| steering.contains(&like.joint));
        let steered: Vec<&WheelLike> = steered.collect();
        // Any part of an arm may be round and fixed.
        let is_fixed = |joint: usize| tree.joints[joint].motion == Motion::Fixed;
        let may_be = |like: &&WheelLike| {
            let is_on_arm = || !tree.joints_above(like.joint).all(is_fixed);
            is_called_wheel(tree, like.joint) || !is_fixed(like.joint) || !is_on_arm()
        };
        let mut bare = [turning, likely].into_iter();
        let bare = bare.find(|likes| likes.len() >= LEAST_WHEELS && likes.iter().any(may_be));
        if let Some(bare) = bare {
            let (rollers, why) = infer::fitting(loading, &bare, false, &survey.looked);
            let fault = Fault::NoRollers {
                wheels: names(&bare),
                rollers,
                why,
                left_out: survey.left_out(tree, &bare),
            };
            return with_sizes(loading, &bare, fault);
        }
        let is_called = |like: &&WheelLike| is_called_wheel(tree, like.joint);
        let makes_a_robot = steered.len() + survey.turning.len() >= LEAST_WHEELS
            || (steered.len() + survey.turning.len() >= 2 && steered.iter().all(is_called));
        if makes_a_robot && !steered.is_empty() {
            let fault = Fault::Steered {
                wheels: names(&steered),
                rollers: infer::fitting(loading, &steered, true, &survey.looked).0,
                left_out: survey.left_out(tree, &steered),
            };
            return with_sizes(loading, &steered, fault);
        }
    }
    if let Some(error) = schema::of_old_xacro(source) {
        return Err(error);
    }
    let wheels = candidates.iter().map(|c| c.hub);
    let wheels = wheels.chain(given.iter().map(|of| of.like.joint));
    let wheels: Vec<String> = wheels
        .map(|joint| tree.joints[joint].name.clone())
        .collect();
    let mut looked = looked(loading, survey);
    looked.retain(|of| !wheels.contains(&of.joint));
    for of in looked.iter_mut().filter(|of| on_tyres && of.reason == BARE) {
        of.reason = "could be one too".to_owned();
    }
    Err(source.robot_error(Fault::TooFewWheels {
        wheels,
        on_tyres,
        looked,
        has: match candidates {
            [] if given.is_empty() => format!(". The file has {}", inventory(tree)),
            _ => String::new(),
        },
    }))
}

/// Returns a fault of wheels without rollers, with the faults of unknown sizes, so that the user is
/// asked for both at once.
fn with_sizes(loading: &Loading, wheels: &[&WheelLike], fault: Fault) -> Result<(), RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let mut faults = Faults::default();
    faults.push(source.joint_error(&tree.joints[wheels[0].joint].name, fault));
    if loading.options.wheel_radius_m.is_none() {
        for wheel in wheels.iter().filter(|wheel| wheel.disc.is_none()) {
            if faults.is_full() {
                break;
            }
            let link = &tree.links[tree.joints[wheel.joint].child].name;
            let size = wheel_size::unknown(loading, wheel);
            faults.push(source.link_error(link, size));
        }
    }
    faults.into_result()
}

/// Returns a summary of a file: links, and joints by motion.
fn inventory(tree: &Tree) -> String {
    let kinds = [
        (Motion::Turning, "turn"),
        (Motion::Swinging, "turn within limits"),
        (Motion::Other, "slide or float"),
        (Motion::Fixed, "are fixed"),
    ];
    let counts = kinds.map(|(motion, words)| (tree.moving(motion).count(), words));
    let counts = counts.into_iter().filter(|(count, _)| *count > 0);
    let joints: Vec<String> = counts
        .map(|(count, words)| format!("{count} {words}"))
        .collect();
    let links = match tree.links.len() {
        1 => "1 link".to_owned(),
        count => format!("{count} links"),
    };
    match &joints[..] {
        [] => format!("{links} and no joints"),
        _ => format!("{links}, and joints of which {}", joints.join(", ")),
    }
}

/// Returns the reason why each joint is no wheel, including possible ones.
fn looked(loading: &Loading, survey: &Survey) -> Vec<CandidateJoint> {
    let of = |like: &WheelLike, reason: &str| CandidateJoint {
        joint: loading.tree.joints[like.joint].name.clone(),
        reason: reason.to_owned(),
        is_too_high: false,
    };
    let likely = survey.likely();
    let likely = likely.iter().map(|like| of(like, BARE));
    let steered = survey
        .steered
        .iter()
        .map(|like| of(like, "hangs by an upright joint that steers it"));
    likely
        .chain(steered)
        .chain(survey.looked.iter().cloned())
        .collect()
}

/// Builds the chassis from the body of the root link, or a body on a joint. `reads_meshes` takes
/// meshes as their convex hulls; else they touch nothing.
pub(super) fn chassis(
    loading: &mut Loading,
    body: RigidBody,
    reads_meshes: bool,
) -> Result<Chassis, RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let name = tree.links[body.link].name.clone();
    let mass = body
        .mass
        .ok_or_else(|| source.link_error(&name, Fault::NoMass))?;
    let mut meshes = 0;
    let mut collisions = Vec::with_capacity(body.shapes.len());
    for PlacedShape {
        body_from_shape,
        geometry,
    } in body.shapes
    {
        let hull = || match &geometry {
            Geometry::Mesh { filename, scale } if reads_meshes => {
                mesh_hull(&loading.meshes, filename, *scale).ok()
            }
            _ => None,
        };
        let Some(shape) = primitive(&geometry).or_else(hull) else {
            meshes += 1;
            continue;
        };
        collisions.push(Collision {
            friction: None,
            body_from_shape,
            shape,
        });
    }
    if meshes > 0 {
        loading.remarks.push(Remark::new(
            format!("link `{name}`"),
            match meshes {
                1 => "a collision mesh of the chassis is not read: it touches nothing there".to_owned(),
                _ => format!(
                    "{meshes} collision meshes of the chassis are not read: it touches nothing there"
                ),
            },
        ));
    }
    Ok(Chassis {
        name,
        mass,
        collisions,
    })
}

/// Rejects an inertia far beyond the mass and reach of a body, and doubts one beyond them by a
/// factor: 1 if all of the body is known.
pub(super) fn check_gyration(
    source: &Source,
    link: &str,
    mass: &MassProperties,
    (reach_m, doubted): (f64, f64),
    remarks: &mut Vec<Remark>,
) -> Result<(), RobotError> {
    let fault = inertia_doubts::beyond_reach(mass, reach_m, doubted);
    let Some(fault) = fault.filter(|_| reach_m > 0.0) else {
        return Ok(());
    };
    if mass.gyration_m() > MOST_GYRATION * reach_m {
        return Err(source.inertial_error(link, fault));
    }
    // Its links may have been doubted one by one.
    let remark = inertia_doubts::doubtful(link, &fault);
    if !remarks
        .iter()
        .any(|known| known.subject == remark.subject && known.text.contains("doubtful"))
    {
        remarks.push(remark);
    }
    Ok(())
}

/// Checks the relations between the wheels, and returns the robot.
pub(super) fn check(source: &Source, mut robot: Robot) -> Result<Robot, RobotError> {
    let mut faults = Faults::default();
    for wheel in robot.wheels.iter().filter(|w| w.radius_m > LARGEST_WHEEL_M) {
        let fault = Fault::LooksLikeMillimetres {
            radius_m: wheel.radius_m,
        };
        faults.push(source.joint_error(&wheel.name, fault));
    }
    faults.into_result()?;
    let mut remarks = Vec::new();
    let has_casters = casters::stand_on(&mut robot, &mut remarks);
    let pose = robot.standing_pose();
    match &pose {
        Some(pose) if has_casters => check_wheels_carry(source, &robot, pose)?,
        Some(pose) => check_standing(source, &robot, pose, &mut remarks)?,
        // It stands on its casters too.
        None if robot.has_tyres() && !robot.joints.is_empty() => {}
        None if casters::is_lone_pair(&robot.wheels) => {
            let fault = Fault::NoCaster { lean_deg: None };
            return Err(source.link_error(&robot.chassis.name, fault));
        }
        None => remarks.push(Remark::new(
            format!("link `{}`", robot.chassis.name),
            "the robot's centre of mass lies outside the area of its wheels: it does not stand on them",
        )),
    }
    check_chassis_above_floor(source, &robot, pose.as_ref())?;
    remark_root(&robot, &mut remarks);
    remark_masses(&robot, &mut remarks);
    plausibility::remark(&robot, &mut remarks);
    robot.remarks.extend(remarks);
    Ok(robot)
}

/// Checks that a robot that stands on its casters hardly leans, and stands on all of its wheels
/// too.
fn check_wheels_carry(
    source: &Source,
    robot: &Robot,
    pose: &StandingPose,
) -> Result<(), RobotError> {
    let lean_deg = pose.tilt_rad().to_degrees();
    if lean_deg > MOST_TILT_DEG {
        let lean_deg = Some(lean_deg);
        return Err(source.link_error(&robot.chassis.name, Fault::NoCaster { lean_deg }));
    }
    let near_m = TOUCHES * casters::least_radius_m(robot);
    if robot.wheels.iter().all(|wheel| pose.gap_m(wheel) < near_m) {
        return Ok(());
    }
    let level_m = -robot.ride_height_m();
    chassis_on_floor(source, robot, (&Vector3::z_axis(), level_m), |_| true)
}

/// Checks that all wheels reach the floor, or nearly, and that the robot hardly leans on them.
fn check_standing(
    source: &Source,
    robot: &Robot,
    pose: &StandingPose,
    remarks: &mut Vec<Remark>,
) -> Result<(), RobotError> {
    let tilt_deg = pose.tilt_rad().to_degrees();
    let wheels = &robot.wheels;
    let places = || wheels.iter().map(|w| w.position_m().xy());
    let span_m = places()
        .flat_map(|p| places().map(move |q| (p - q).norm()))
        .fold(0.0, f64::max);
    // The allowed height of a wheel is that to which the robot would lean.
    let most_m = span_m * MOST_TILT_DEG.to_radians();
    let gaps: Vec<(f64, &Wheel)> = wheels.iter().map(|w| (pose.gap_m(w), w)).collect();
    let Some((highest_m, highest)) = gaps.iter().max_by(|p, q| p.0.total_cmp(&q.0)) else {
        return Ok(());
    };
    if tilt_deg > MOST_TILT_DEG || *highest_m > most_m {
        let bottom_m = |w: &Wheel| w.position_m().z - w.reach_at_rest_m();
        let by_height = |p: &&Wheel, q: &&Wheel| bottom_m(p).total_cmp(&bottom_m(q));
        let hangs = *highest_m > most_m;
        // If the robot leans, the wheel with the highest lowest point in the file is at fault.
        let at_fault = if hangs {
            highest
        } else {
            wheels.iter().max_by(by_height).unwrap_or(highest)
        };
        let lowest_m = wheels.iter().map(bottom_m).fold(f64::INFINITY, f64::min);
        let fault = Fault::UnevenWheels {
            apart_mm: 1e3 * (bottom_m(at_fault) - lowest_m),
            tilt_deg,
            gap_mm: if hangs { 1e3 * highest_m } else { 0.0 },
            most_deg: MOST_TILT_DEG,
        };
        return Err(source.joint_error(&at_fault.name, fault));
    }
    if tilt_deg > REMARKED_TILT_DEG {
        remarks.push(Remark::new(
            "the robot",
            format!(
                "its wheels do not reach equally low: it stands rolled by {:.2} deg and pitched by {:.2} deg",
                pose.roll_rad.to_degrees(),
                pose.pitch_rad.to_degrees()
            ),
        ));
    }
    Ok(())
}

/// Checks that the chassis does not touch the floor of the wheels: it would carry the robot instead
/// of them.
fn check_chassis_above_floor(
    source: &Source,
    robot: &Robot,
    pose: Option<&StandingPose>,
) -> Result<(), RobotError> {
    let up: Unit<Vector3<f64>> = pose.map_or_else(Vector3::z_axis, StandingPose::up_in_body);
    let floor_m = -pose.map_or_else(|| robot.ride_height_m(), |pose| pose.height_m);
    let is_no_caster = |shape: &Collision| shape.friction.is_none();
    chassis_on_floor(source, robot, (&up, floor_m), is_no_caster)
}

/// The error of a chassis of which some shapes reach a floor, given by its normal and height: with
/// less clearance than [`TOUCHES`] the first bump or the deflection of a tread puts it there.
fn chassis_on_floor(
    source: &Source,
    robot: &Robot,
    (up, floor_m): (&Unit<Vector3<f64>>, f64),
    counts: impl Fn(&Collision) -> bool,
) -> Result<(), RobotError> {
    let down = -up.into_inner();
    let shapes = robot.chassis.collisions.iter();
    let heights = shapes
        .filter(|shape| counts(shape))
        .map(|collision| (-collision.reach_m(&down), collision));
    let Some((lowest_m, lowest)) = heights.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Ok(());
    };
    let above_m = lowest_m - floor_m;
    if above_m >= TOUCHES * casters::least_radius_m(robot) {
        return Ok(());
    }
    let at = lowest.farthest(&down);
    let fault = Fault::ChassisBelowFloor {
        deep_mm: -1e3 * above_m,
        at_m: [at.x, at.y],
    };
    Err(source.link_error(&robot.chassis.name, fault))
}

/// Adds a remark if the body frame, the centre of the robot's rotation, lies outside its wheels.
fn remark_root(robot: &Robot, remarks: &mut Vec<Remark>) {
    let places: Vec<Vector2<f64>> = robot.wheels.iter().map(|w| w.position_m().xy()).collect();
    let count = places.len() as f64;
    let middle = places.iter().sum::<Vector2<f64>>() / count;
    let farthest_m = places
        .iter()
        .map(|p| (p - middle).norm())
        .fold(0.0, f64::max);
    if middle.norm() > 1.05 * farthest_m {
        remarks.push(Remark::new(
            format!("link `{}`", robot.chassis.name),
            format!(
                "the robot's frame lies {:.0} mm from the middle of its wheels and outside them: what turns it on the spot turns \
                 it about there",
                1e3 * middle.norm()
            ),
        ));
    }
}

/// Adds remarks on disproportionate masses.
fn remark_masses(robot: &Robot, remarks: &mut Vec<Remark>) {
    let wheel_kg = |w: &Wheel| w.hub.mass_kg + w.rollers.iter().map(|r| r.mass_kg).sum::<f64>();
    let wheels_kg: f64 = robot.wheels.iter().map(wheel_kg).sum();
    let chassis_kg = robot.chassis.mass.mass_kg;
    if chassis_kg < 0.1 * wheels_kg {
        remarks.push(Remark::new(
            format!("link `{}`", robot.chassis.name),
            format!(
                "the chassis weighs {chassis_kg:.4} kg beside {wheels_kg:.4} kg of wheels: its mass may be missing"
            ),
        ));
    }
    for wheel in &robot.wheels {
        let kg = wheel_kg(wheel);
        // At least as wide as its rollers are thick.
        let width_m = wheel
            .rollers
            .iter()
            .map(|r| 2.0 * r.radius_m)
            .fold(0.0, f64::max);
        let disc_m3 = std::f64::consts::PI * wheel.radius_m * wheel.radius_m * width_m;
        let density = kg / disc_m3.max(1e-12);
        let words = if kg > chassis_kg && chassis_kg >= 0.1 * wheels_kg {
            format!("it weighs {kg:.2} kg, more than the chassis with its {chassis_kg:.2} kg")
        } else if density > 2.0 * STEEL_KG_M3 {
            format!("it weighs {kg:.2} kg, twice as much as a disc of steel of its size")
        } else {
            continue;
        };
        remarks.push(Remark::new(format!("wheel `{}`", wheel.name), words));
    }
}
