//! Builds a robot from URDF text.
//!
//! The stages: check the text against the form of URDF ([`source`], [`schema`], [`numbers`]); parse
//! it with urdf-rs ([`normalise`]); place its links and joints in a tree in the body frame
//! ([`tree`], [`body`]); recognise wheels and rollers ([`recognise`]) and measure them
//! ([`wheel_dimensions`], [`from_rollers`] with [`geometry`], [`roller_dimensions`], [`mesh`] and
//! [`dae`], [`roller_gaps`], [`outline`]); find wheels without rollers ([`candidates`], [`disc`])
//! and add some ([`from_options`]) if the user or the file implies them ([`infer`]); undo rounding
//! of level wheels ([`level`]); check the whole ([`check`]). Faults are errors, all of a stage at
//! once ([`faults`]); ignored, assumed and doubtful parts give remarks. [`visual_meshes`] reads
//! visual meshes. [`repair`] changes the text to repair errors.

mod asked_joint;
mod body;
mod candidates;
mod casters;
mod check;
mod dae;
mod disc;
mod even_rollers;
mod faults;
mod from_options;
mod from_rollers;
mod geometry;
mod hub;
mod inertia_doubts;
mod inertia_from_shapes;
mod inertial;
mod infer;
mod level;
mod linkage;
mod links;
mod loading;
mod mesh;
mod mesh_rollers;
mod names;
mod normalise;
mod numbers;
mod outline;
mod plausibility;
mod recognise;
mod repair;
mod roller_dimensions;
mod roller_gaps;
mod said_tyres;
mod schema;
mod sides;
mod source;
mod transmission;
mod tree;
mod urdf_text;
mod visual_meshes;
mod wheel_dimensions;
mod wheel_size;

use std::collections::HashSet;

use nalgebra::{Unit, Vector3};

use crate::error::{CandidateJoint, Fault, RobotError};
use crate::model::{MassProperties, Remark, Robot, Wheel};
use crate::options::{LoadOptions, RollerForms, TyreOptions, WheelOptions};
use body::RigidBody;
use candidates::Survey;
use check::LEAST_WHEELS;
use faults::Faults;
use from_options::BareWheel;
pub(crate) use hub::hub_frame;
pub(crate) use linkage::frame as joint_frame;
use linkage::{Linkage, moving};
pub use links::link_tree;
use loading::Loading;
pub(crate) use mesh::{LFS_POINTER, Meshes, is_lfs_pointer};
pub use outline::WheelOutline;
use recognise::Candidate;
pub(crate) use repair::{levelled, repaired, with_light_parts_repaired};
use source::Source;
pub(crate) use source::{child, text_of};
use tree::{Motion, Tree};
pub(crate) use urdf_text::{Edit, Origin, UrdfText, in_order};
pub use visual_meshes::mesh_triangles;
pub(crate) use visual_meshes::read as read_looks;
pub(crate) use wheel_size::is_wheel_size;

/// A robot read from URDF.
#[derive(Clone, Debug)]
pub(crate) struct Read {
    pub(crate) robot: Robot,
    pub(crate) outlines: Vec<WheelOutline>,
    /// The rollers inferred from the file.
    pub(crate) inferred: Option<WheelOptions>,
}

/// Reads a robot.
pub(crate) fn read(prepared: &UrdfText, options: &LoadOptions) -> Result<Read, RobotError> {
    let source = Source::parse(prepared)?;
    let mut remarks = prepared.remarks.clone();
    let tree = tree(&source, options, &mut remarks)?;
    let mut loading = Loading {
        source: &source,
        tree: &tree,
        options,
        meshes: Meshes::beside(&prepared.file, options),
        remarks,
        outlines: Vec::new(),
    };
    let candidates = recognise::find(&tree);
    let (given, rollers, inferred) = bare_wheels(&mut loading, &candidates)?;
    let linkage = linkage::decide(&mut loading, &candidates, &given)?;
    let wheels = wheels(&mut loading, &candidates, &given, rollers.as_ref())?;
    let robot = assemble(loading, wheels, (&candidates, &given), &linkage)?;
    Ok(Read {
        outlines: robot.1,
        robot: check::check(&source, robot.0)?,
        inferred,
    })
}

/// Returns the number of wheels with rollers in a text, and of level joints that turn and have
/// nothing that turns above or below them.
pub(crate) fn wheels_seen(prepared: &UrdfText) -> (usize, usize) {
    let source = Source::parse(prepared).ok();
    let Some(tree) = source.and_then(|source| repair::tree(&source)) else {
        return (0, 0);
    };
    let is_bare = |j: &usize| {
        tree.is_level(*j) && tree.turning_above(*j).is_none() && tree.turning_below(*j).is_none()
    };
    let bare = tree.moving(Motion::Turning).filter(is_bare).count();
    (recognise::find(&tree).len(), bare)
}

/// Places the file's links and joints.
fn tree(
    source: &Source,
    options: &LoadOptions,
    remarks: &mut Vec<Remark>,
) -> Result<Tree, RobotError> {
    let links_may_miss = options.leave_out_missing;
    remarks.extend(schema::check(source, links_may_miss)?);
    let left_out = if links_may_miss {
        let (left_out, said) = normalise::without_missing(source);
        remarks.extend(said);
        left_out
    } else {
        normalise::LeftOut::default()
    };
    let urdf = urdf_rs::read_from_string(&normalise::normalised(source, &left_out));
    let urdf = urdf.map_err(|e| {
        let reason = e.to_string();
        RobotError::new(&source.prepared.file, Fault::Urdf { reason })
    })?;
    Tree::build(source, urdf)
}

/// Largest number of wheel joints: the checks of each visit all others.
const MOST_WHEELS: usize = 500;

/// The wheels that get rollers: by the options, or inferred from the file; with these rollers, and
/// with the inferred ones.
type Bare = (Vec<BareWheel>, Option<WheelOptions>, Option<WheelOptions>);

fn bare_wheels(loading: &mut Loading, candidates: &[Candidate]) -> Result<Bare, RobotError> {
    let asked = loading.options.wheels.clone();
    let enough = candidates.len() >= LEAST_WHEELS;
    let tyres = loading.options.tyres.clone();
    let tyres = tyres.or_else(|| match asked {
        None => said_tyres::of(loading.source),
        Some(_) => None,
    });
    if enough && asked.is_none() && tyres.is_none() {
        return Ok((Vec::new(), None, None));
    }
    let survey = match &asked {
        // Named wheels need no search, unless a name is wrong.
        Some(rollers) if enough && !rollers.joints.is_empty() => Survey::default(),
        _ => candidates::survey(loading.tree, candidates, &loading.meshes),
    };
    if survey.turning.len() > MOST_WHEELS {
        return Err(loading.source.robot_error(Fault::TooManyWheels {
            count: survey.turning.len(),
            most: MOST_WHEELS,
        }));
    }
    let may_infer = candidates.is_empty()
        && asked.is_none()
        && tyres.is_none()
        && loading.options.infer_rollers;
    // Modelled but fixed rollers are not added a second time.
    let inferred = match may_infer && recognise::fixed_rollers(loading.tree).is_empty() {
        true => infer::infer(loading, &survey),
        false => None,
    };
    if let Some(inferred) = &inferred {
        let count = inferred.rollers.rollers;
        let count = match inferred.are_drawn {
            true => format!("the {count} rollers that its mesh shows"),
            false => format!(
                "{count} rollers. This number is a guess: give number and angle of the real ones if slip matters"
            ),
        };
        loading.remarks.push(Remark::new(
            "the wheels",
            format!(
                "the file has no rollers; by {} they are Swedish wheels, and each is given {count}{}",
                inferred.why,
                other_values(&loading.source.prepared.choices)
            ),
        ));
    }
    let inferred = inferred.map(|inferred| inferred.rollers);
    let rollers = asked.or_else(|| inferred.clone());
    let mut given = match &rollers {
        Some(rollers) => from_options::wheels(loading, rollers, candidates, &survey)?,
        None => Vec::new(),
    };
    let tyres = match (tyres, &rollers) {
        (None, None) if may_infer => infer::tyres(loading, &survey),
        (Some(asked), _) if asked.joints.is_empty() => {
            let found = infer::on_tyres(loading.tree, &survey);
            let is_asked = |name: &String| asked.free.contains(name);
            let mut free = asked.free.clone();
            free.extend(found.free.into_iter().filter(|name| !is_asked(name)));
            Some(TyreOptions {
                joints: found
                    .joints
                    .into_iter()
                    .filter(|name| !is_asked(name))
                    .collect(),
                free,
                ..asked
            })
        }
        (tyres, _) => tyres,
    };
    if let Some(tyres) = &tyres {
        given.extend(from_options::tyred(
            loading,
            tyres,
            (candidates, &given),
            &survey,
        )?);
    }
    check::check_wheel_count(loading, candidates, (&given, tyres.is_some()), &survey)?;
    if rollers.is_some() {
        remark_left_alone(loading, &survey, &given);
    }
    Ok((given, rollers, inferred))
}

/// Returns other values of the file's arguments, which may add rollers, as text.
fn other_values(choices: &[(String, Vec<String>)]) -> String {
    let choice =
        |(name, values): &(String, Vec<String>)| format!("`{name}` ({})", values.join(", "));
    let choices: Vec<String> = choices.iter().take(6).map(choice).collect();
    match &choices[..] {
        [] => String::new(),
        choices => format!(
            "; other values that the file knows of its arguments may bring rollers: {}",
            choices.join(", ")
        ),
    }
}

/// Adds remarks on turning joints that are no wheels, after a search without names.
fn remark_left_alone(loading: &mut Loading, survey: &Survey, given: &[BareWheel]) {
    let tree = loading.tree;
    let steered = survey.left_out(tree, &survey.likely());
    let is_new = |of: &&CandidateJoint| survey.looked.iter().all(|known| known.joint != of.joint);
    let is_wheel = |of: &&CandidateJoint| {
        let mut wheels = given.iter().map(|of| &tree.joints[of.like.joint].name);
        wheels.any(|name| *name == of.joint)
    };
    let left = survey.looked.iter().chain(steered.iter().filter(is_new));
    for looked in left.filter(|of| !is_wheel(of)) {
        let subject = format!("joint `{}`", looked.joint);
        loading
            .remarks
            .push(Remark::new(subject, format!("no wheel: {}", looked.reason)));
    }
}

/// Returns all wheels, in the order of their joints in the file. All faults are collected.
fn wheels(
    loading: &mut Loading,
    candidates: &[Candidate],
    given: &[BareWheel],
    rollers: Option<&WheelOptions>,
) -> Result<Vec<Wheel>, RobotError> {
    let tree = loading.tree;
    let moving = moving(candidates, given);
    let mut faults = Faults::default();
    let mut wheels: Vec<(usize, Wheel)> = Vec::with_capacity(moving.len());
    for candidate in candidates {
        let hub = hub_body(loading, candidate.hub, &moving);
        let measured = wheel_dimensions::measure(loading, candidate, &hub).and_then(|wheel| {
            check_wheel(loading, &wheel, &hub, false)?;
            Ok((candidate.hub, wheel))
        });
        wheels.extend(faults.keep(measured));
    }
    for given in given {
        let j = given.like.joint;
        let body = hub_body(loading, j, &moving);
        let made = from_options::wheel(loading, rollers, given, &body).and_then(|wheel| {
            check_wheel(loading, &wheel, &body, true)?;
            Ok((j, wheel))
        });
        wheels.extend(faults.keep(made));
    }
    faults.into_result()?;
    if loading.options.rollers == RollerForms::Barrel {
        even_rollers::even_out(tree, candidates, &mut wheels, &mut loading.remarks);
    }
    wheels.sort_by_key(|(joint, _)| *joint);
    let mut drives = transmission::drives(loading.source, tree);
    drives.extend(loading.source.prepared.drives.clone());
    let surfaces = transmission::surfaces(loading.source);
    let mut materials = transmission::materials(loading.source);
    wheels
        .into_iter()
        .map(|(_, mut wheel)| {
            if let Some(drive) = drives.get(&wheel.name) {
                wheel.drive = *drive;
            }
            if let Some(surface) = surfaces.get(&wheel.name) {
                wheel.surface = *surface;
            }
            wheel.material = materials.remove(&wheel.name);
            transmission::make_rollers(loading.source, &mut wheel).map(|()| wheel)
        })
        .collect()
}

fn hub_body(loading: &mut Loading, joint: usize, moving: &HashSet<usize>) -> RigidBody {
    let tree = loading.tree;
    let body = tree.rigid_body(tree.joints[joint].child, |j| moving.contains(&j));
    let of = format!("wheel `{}`", tree.joints[joint].name);
    body.remark_held(tree, &of, &[], &mut loading.remarks);
    body
}

/// Checks the inertia of a wheel and of its rollers against their sizes.
fn check_wheel(
    loading: &mut Loading,
    wheel: &Wheel,
    body: &RigidBody,
    is_bare: bool,
) -> Result<(), RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let mut faults = Faults::default();
    let axis = Unit::new_normalize(wheel.body_from_hub * Vector3::z());
    let as_wheel = is_bare.then_some((&axis, wheel.radius_m));
    faults.keep(inertia_doubts::check(loading, body, as_wheel));
    let remarks = &mut loading.remarks;
    if let Some(mass) = &body.mass {
        let link = &tree.links[body.link].name;
        let reach_m = body.reach_m(&mass.center_of_mass_m).max(wheel.radius_m);
        faults.keep(check::check_gyration(
            source,
            link,
            mass,
            (reach_m, 1.0),
            remarks,
        ));
    }
    for roller in &wheel.rollers {
        let joint = tree.joints.iter().find(|joint| joint.name == roller.name);
        let Some(joint) = joint.filter(|joint| joint.motion == Motion::Turning) else {
            continue;
        };
        let link = &tree.links[joint.child].name;
        let reach_m = libm::hypot(roller.radius_m, 0.5 * roller.length_m);
        let mass = roller.mass_in_hub();
        faults.keep(check::check_gyration(
            source,
            link,
            &mass,
            (reach_m, 1.0),
            remarks,
        ));
    }
    faults.into_result()
}

/// Builds the robot from its parts, with all remarks.
fn assemble(
    mut loading: Loading,
    mut wheels: Vec<Wheel>,
    (candidates, given): (&[Candidate], &[BareWheel]),
    linkage: &Linkage,
) -> Result<(Robot, Vec<WheelOutline>), RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let mut moving = moving(candidates, given);
    moving.extend(linkage.joints());
    let mut body = tree.rigid_body(tree.root, |j| moving.contains(&j));
    let hubs = candidates.iter().map(|candidate| candidate.hub);
    let hubs = hubs.chain(given.iter().map(|given| given.like.joint));
    let hubs: Vec<usize> = hubs.collect();
    body.remark_held(tree, "the chassis", &hubs, &mut loading.remarks);
    let reach_m = |mass: &MassProperties| {
        let to_wheels = wheels
            .iter()
            .map(|w| (w.position_m() - mass.center_of_mass_m).norm());
        to_wheels.fold(body.reach_m(&mass.center_of_mass_m), f64::max)
    };
    inertia_doubts::check(&mut loading, &body, None)?;
    if let Some(mass) = &body.mass {
        let link = &tree.links[body.link].name;
        // The reach of a mesh is unknown: half of the rejected range is doubted then.
        let is_mesh =
            |shape: &tree::PlacedShape| matches!(shape.geometry, urdf_rs::Geometry::Mesh { .. });
        let has_meshes = body.shapes.iter().chain(&body.visuals).any(is_mesh);
        let reach = (reach_m(mass), if has_meshes { 2.5 } else { 1.0 });
        check::check_gyration(source, link, mass, reach, &mut loading.remarks)?;
    }
    // Meshes may show the casters on which a pair of wheels stands.
    let reads_meshes = casters::is_lone_pair(&wheels);
    if reads_meshes {
        loading
            .remarks
            .extend(casters::of_shown_balls(&mut body, &wheels));
    }
    let chassis = check::chassis(&mut loading, body, reads_meshes)?;
    let (joints, couplings) = linkage::assemble(&mut loading, linkage, &moving, &mut wheels)?;
    remark_hubs(&mut loading, candidates, &moving);
    let Loading {
        mut remarks,
        outlines,
        ..
    } = loading;
    remarks.extend(source.ignored_elements());
    let mut robot = Robot {
        name: source
            .robot()
            .attribute("name")
            .unwrap_or_default()
            .to_owned(),
        chassis,
        joints,
        couplings,
        wheels,
        remarks: Vec::new(),
    };
    remarks.extend(level::level(&mut robot));
    remarks.extend(linkage.set_gains(&mut robot));
    source.place(&mut remarks);
    robot.remarks = remarks;
    Ok((robot, outlines))
}

/// Adds a remark that hubs do not collide.
fn remark_hubs(loading: &mut Loading, candidates: &[Candidate], moving: &HashSet<usize>) {
    let tree = loading.tree;
    let shapes: usize = candidates
        .iter()
        .map(|c| {
            let hub = tree.joints[c.hub].child;
            tree.rigid_body(hub, |j| moving.contains(&j)).shapes.len()
        })
        .sum();
    if shapes > 0 {
        loading.remarks.push(Remark::aside(
            "hubs",
            format!("{shapes} collision shapes are ignored: only rollers touch the floor"),
        ));
    }
}
