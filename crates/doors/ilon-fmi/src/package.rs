//! The archive of an FMU.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::{Component, Path, PathBuf};

use ilon_files::FileAccess;
use ilon_sim::robot::Robot;
use ilon_sim::scenario::Setting;
use ilon_sim::{Driver, Error, Plant, Scenario, load_robot, resolve_for};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::instance::Instance;
use crate::{MARK, MODEL, SCENARIO, description};

/// The largest file of a robot, and the largest library, that are packed, in bytes; chosen.
const MOST_BYTES: u64 = 512 << 20;

/// The FMU of a scenario with changed keys: the bytes of its archive. `library` is the shared
/// library of `ilon-c`.
///
/// # Errors
/// If the scenario or its robot is invalid, the library has another version, or the robot's files
/// cannot be packed.
pub fn package(
    path: &Path,
    settings: &[Setting],
    files: &FileAccess,
    library: &Path,
) -> Result<Vec<u8>, Error> {
    let binary = read_library(library)?;
    let noting = files.noting();
    let scenario = Scenario::load_within(path, settings, &noting)?;
    let robot = load_robot(&scenario)?;
    let resolved = resolve_for(&scenario, &robot, Driver::Own)?;
    Plant::new(&resolved, &robot)?;
    let resources = resources(path, resolved.scenario(), &noting)?;
    let instance = check(&resources, &robot)?;
    let name = &resolved.scenario().name;
    let xml = description::description(name, instance.plant(), instance.variables());
    zipped(&xml, &resources, &binary).map_err(|fault| Error::encode("the FMU", &fault))
}

fn read_library(path: &Path) -> Result<Vec<u8>, Error> {
    let binary = FileAccess::anywhere().read(path, MOST_BYTES);
    let binary = binary.map_err(|fault| Error::Read {
        path: path.to_owned(),
        reason: fault.to_string(),
        help: "build the crate `ilon-c` in release, or name its shared library".to_owned(),
    })?;
    let is_ours = binary
        .windows(MARK.len())
        .any(|bytes| bytes == MARK.as_bytes());
    if is_ours {
        return Ok(binary);
    }
    Err(Error::invalid(
        format!(
            "`{}` is not ilon's library of version {}",
            path.display(),
            env!("CARGO_PKG_VERSION")
        ),
        "build the crate `ilon-c` of the same version",
    ))
}

/// The files that an instance reads, by their paths within the resources: the resolved scenario,
/// and every file that was opened for its robot.
fn resources(
    path: &Path,
    scenario: &Scenario,
    files: &FileAccess,
) -> Result<BTreeMap<PathBuf, Vec<u8>>, Error> {
    let itself = real(path);
    let opened = files.opened();
    let opened: Vec<PathBuf> = opened.iter().map(|path| real(path)).collect();
    let others = || opened.iter().filter(|path| **path != itself);
    let root = others()
        .filter_map(|path| path.parent().map(Path::to_owned))
        .reduce(|a, b| shared(&a, &b))
        .unwrap_or_default();
    let packages = others().flat_map(|path| path.ancestors().skip(1));
    let packages = packages.filter(|folder| folder.starts_with(&root));
    // Needed to resolve `package://`.
    let packages = packages.map(|folder| folder.join("package.xml"));
    let packages = packages.filter(|path| files.is_file(path));
    let mut resources = BTreeMap::new();
    for path in others().cloned().chain(packages) {
        let bytes = files.read(&path, MOST_BYTES);
        let bytes = bytes.map_err(|fault| Error::read(&path, &fault))?;
        let within = path.strip_prefix(&root).unwrap_or(&path).to_owned();
        resources.insert(within, bytes);
    }
    let text = scenario.moved_to(&root).to_toml()?;
    resources.insert(PathBuf::from(SCENARIO), text.into_bytes());
    Ok(resources)
}

/// A path with its folder resolved.
fn real(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    match (absolute.parent(), absolute.file_name()) {
        (Some(folder), Some(name)) => folder
            .canonicalize()
            .unwrap_or_else(|_| folder.to_owned())
            .join(name),
        _ => absolute,
    }
}

/// The deepest folder that holds both.
fn shared(a: &Path, b: &Path) -> PathBuf {
    let pairs = a.components().zip(b.components());
    pairs.take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}

/// Builds an instance from the packed files alone, so that a missing file is found at export.
fn check(resources: &BTreeMap<PathBuf, Vec<u8>>, robot: &Robot) -> Result<Instance, Error> {
    let held = resources
        .iter()
        .map(|(path, bytes)| (path.clone(), bytes.clone()));
    let text = String::from_utf8_lossy(&resources[Path::new(SCENARIO)]).into_owned();
    let instance = Instance::of(text, Path::new(""), FileAccess::of_memory(held));
    let refused = |why: String| {
        Error::invalid(
            format!("the robot's files cannot be taken along in an FMU: {why}"),
            "name folders of packages with `robot.packages`, or make one URDF of it, without xacro's `find`",
        )
    };
    let instance = instance.map_err(|fault| refused(fault.to_string()))?;
    let same = instance.plant().robot() == robot;
    if same {
        Ok(instance)
    } else {
        Err(refused(
            "without its surroundings it is another robot".to_owned(),
        ))
    }
}

/// The name of this platform in FMI 3.0, and the extension of its shared libraries.
pub fn platform() -> (String, &'static str) {
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    let tuple = format!("{}-{system}", std::env::consts::ARCH);
    (tuple, std::env::consts::DLL_EXTENSION)
}

fn zipped(
    xml: &str,
    resources: &BTreeMap<PathBuf, Vec<u8>>,
    binary: &[u8],
) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    // Without a date: the same input gives the same bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default());
    let mut add = |name: String, bytes: &[u8]| -> Result<(), Box<dyn std::error::Error>> {
        zip.start_file(name, options)?;
        Ok(zip.write_all(bytes)?)
    };
    add("modelDescription.xml".to_owned(), xml.as_bytes())?;
    let (tuple, ending) = platform();
    add(format!("binaries/{tuple}/{MODEL}.{ending}"), binary)?;
    // Where FMI 3.0 looks for the licences of a model.
    let licenses = [
        (
            "license.txt",
            "MIT, in LICENSE-MIT, or Apache 2.0, in LICENSE-APACHE, as you like\n",
        ),
        ("LICENSE-MIT", include_str!("../LICENSE-MIT")),
        ("LICENSE-APACHE", include_str!("../LICENSE-APACHE")),
    ];
    for (name, text) in licenses {
        add(format!("documentation/licenses/{name}"), text.as_bytes())?;
    }
    for (path, bytes) in resources {
        let parts = path.components().filter_map(|part| match part {
            Component::Normal(part) => Some(part.to_string_lossy()),
            _ => None,
        });
        let name = parts.collect::<Vec<_>>().join("/");
        add(format!("resources/{name}"), bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}
