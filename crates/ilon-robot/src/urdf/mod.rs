//! Reads a robot from URDF.
//!
//! In this order: the text is held against the form of URDF ([`source`], [`form`]; [`repair`] where it is asked for), urdf-rs
//! reads it, its links and joints become a tree placed in the body frame ([`tree`]), wheels and rollers are recognised and
//! measured ([`recognise`], [`measure`] with [`geometry`], [`fit`], [`mesh`] and [`dae`], [`handover`], [`outline`]) or put in
//! ([`given`]), and the whole is checked ([`check`]). Faults are errors; what is ignored, assumed or doubted is remarked.

mod check;
mod dae;
mod fit;
mod form;
mod geometry;
mod given;
mod handover;
mod measure;
mod mesh;
mod options;
mod outline;
mod recognise;
mod repair;
mod source;
mod tree;

use std::collections::HashSet;
use std::path::Path;

use crate::error::{Fault, RobotError};
use crate::model::{Remark, Robot, Wheel};
use mesh::Meshes;
pub use options::{Handedness, LoadOptions, RollerForms, WheelOptions};
pub use outline::WheelOutline;
use source::Source;
use tree::Tree;

/// A robot as it was read, and how well its file models it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The robot.
    pub robot: Robot,
    /// The outline of each wheel as the file models it; of wheels that were given rollers there is none.
    pub outlines: Vec<WheelOutline>,
}

impl Robot {
    /// Reads a robot from a URDF file.
    ///
    /// # Errors
    /// A file that cannot be read, that is not URDF, or whose robot is not an omnidirectional one that can be simulated:
    /// every [`Fault`], with its place in the file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, RobotError> {
        Self::load_with(path, &LoadOptions::default()).map(|loaded| loaded.robot)
    }

    /// Reads a robot from the text of a URDF file; `file` is what errors call it, and meshes are sought beside it.
    ///
    /// # Errors
    /// As [`Robot::load`], but for reading the file.
    pub fn from_urdf_str(text: &str, file: &str) -> Result<Self, RobotError> {
        Self::from_urdf_str_with(text, file, &LoadOptions::default()).map(|loaded| loaded.robot)
    }

    /// Reads a robot from a URDF file as the options say. A xacro file is expanded first, without ROS and with its
    /// arguments at their defaults; an expansion that takes ten seconds is given up.
    ///
    /// # Errors
    /// As [`Robot::load`], and options that do not fit the file.
    pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, RobotError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = options
            .files
            .read_text(path, crate::xml::MAX_BYTES)
            .map_err(|fault| {
                let reason = fault.to_string();
                RobotError::new(&file, Fault::Unreadable { reason })
            })?;
        let loaded = Self::from_urdf_str_with(&text, &file, options);
        if let Err(error) = &loaded
            && let Fault::Unexpanded { what, .. } = error.fault()
        {
            let settings = crate::xacro::Settings {
                arguments: &options.arguments,
                packages: &options.packages,
                files: &options.files,
                leave_out_missing: options.leave_out_missing,
            };
            return match crate::xacro::expand(path, &file, &text, &settings) {
                Ok(expanded) => load_expanded(&expanded.text, &file, options),
                Err(failure) => Err(error.clone().with_fault(Fault::Unexpanded {
                    what: what.clone(),
                    tried: Some(format!("{failure:?}")),
                })),
            };
        }
        loaded
    }

    /// Reads a robot from the text of a URDF file as the options say.
    ///
    /// # Errors
    /// As [`Robot::load_with`], but for reading the file.
    pub fn from_urdf_str_with(
        text: &str,
        file: &str,
        options: &LoadOptions,
    ) -> Result<Loaded, RobotError> {
        // A byte order mark is no part of the text.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source::parse(text, file)?;
        if !options.mend {
            return read(&source, options, Vec::new());
        }
        let (mended, remarks) = repair::mend(&source);
        read(&Source::parse(&mended, file)?, options, remarks)
    }
}

/// Reads what a xacro file expanded to. Faults are shown in the expanded text, which no file holds.
fn load_expanded(urdf: &str, file: &str, options: &LoadOptions) -> Result<Loaded, RobotError> {
    let mut loaded = Robot::from_urdf_str_with(urdf, &format!("{file} (expanded)"), options)?;
    let text = "expanded without ROS, its arguments at their defaults";
    loaded.robot.remarks.insert(0, remark("xacro", text));
    Ok(loaded)
}

/// What is needed in every stage, and what the stages gather.
struct Loading<'a> {
    source: &'a Source<'a>,
    tree: &'a Tree,
    options: &'a LoadOptions,
    meshes: Meshes,
    remarks: Vec<Remark>,
    outlines: Vec<WheelOutline>,
}

impl Loading<'_> {
    /// Whether the radius of wheels that are given rollers must come from their geometry.
    fn needs_wheel_size(&self) -> bool {
        self.options
            .wheels
            .as_ref()
            .is_some_and(|w| w.radius_m.is_none())
    }
}

fn read(
    source: &Source,
    options: &LoadOptions,
    mut remarks: Vec<Remark>,
) -> Result<Loaded, RobotError> {
    form::check(source)?;
    let urdf = urdf_rs::read_from_string(source.text).map_err(|e| {
        let reason = e.to_string();
        RobotError::new(source.file, Fault::Urdf { reason })
    })?;
    let name = urdf.name.clone();
    let tree = Tree::build(source, urdf, &mut remarks)?;
    let mut loading = Loading {
        source,
        tree: &tree,
        options,
        meshes: Meshes::beside(source.file, options),
        remarks,
        outlines: Vec::new(),
    };

    let candidates = recognise::find(&tree);
    let given = match &options.wheels {
        Some(wheels) => given::joints(&loading, wheels, &candidates)?,
        None => Vec::new(),
    };
    check::check_wheel_count(&loading, &candidates, given.len())?;

    let moving: HashSet<usize> = candidates
        .iter()
        .flat_map(|c| c.rollers.iter().copied().chain([c.hub]))
        .chain(given.iter().map(|g| g.joint))
        .collect();
    let rigid_body = |link| tree.rigid_body(link, |j| moving.contains(&j));
    let chassis_body = rigid_body(tree.root);
    check::remark_held(&tree, &chassis_body, "the chassis", &mut loading.remarks);

    let mut wheels: Vec<(usize, Wheel)> = Vec::with_capacity(moving.len());
    let hub_of = |loading: &mut Loading, j: usize| {
        let joint = &tree.joints[j];
        let body = rigid_body(joint.child);
        check::remark_held(
            &tree,
            &body,
            &format!("wheel `{}`", joint.name),
            &mut loading.remarks,
        );
        body
    };
    for candidate in &candidates {
        let hub = hub_of(&mut loading, candidate.hub);
        wheels.push((
            candidate.hub,
            measure::measure(&mut loading, candidate, &hub)?,
        ));
    }
    if let Some(wheel_options) = &options.wheels {
        for g in &given {
            let hub = hub_of(&mut loading, g.joint);
            wheels.push((g.joint, given::wheel(&mut loading, wheel_options, g, &hub)?));
        }
    }
    wheels.sort_by_key(|(joint, _)| *joint);

    let chassis = check::chassis(&mut loading, chassis_body)?;
    let hub_shapes: usize = candidates
        .iter()
        .map(|c| rigid_body(tree.joints[c.hub].child).shapes.len())
        .sum();
    if hub_shapes > 0 {
        loading.remarks.push(remark(
            "hubs",
            format!("{hub_shapes} collision shapes are not read: of a wheel only the rollers touch the world"),
        ));
    }
    let Loading {
        mut remarks,
        outlines,
        ..
    } = loading;
    remarks.extend(source.ignored_elements());
    source.place(&mut remarks);
    let robot = Robot {
        name,
        chassis,
        wheels: wheels.into_iter().map(|(_, wheel)| wheel).collect(),
        remarks,
    };
    let robot = check::check(source, robot)?;
    Ok(Loaded { robot, outlines })
}

/// A remark about an element.
fn remark(subject: impl Into<String>, text: impl Into<String>) -> Remark {
    Remark {
        subject: subject.into(),
        line: None,
        text: text.into(),
    }
}
