//! Mesh files: paths and vertices.

use std::cell::RefCell;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use nalgebra::Point3;

use super::dae;
use crate::error::Fault;
use crate::files::FileAccess;
use crate::options::LoadOptions;
use crate::packages::Machine;

/// Largest mesh file that is read, in bytes.
const MAX_BYTES: u64 = 256 << 20;

/// Reads mesh files, each once.
pub(crate) struct Meshes {
    folder: PathBuf,
    machine: Machine,
    read: RefCell<HashMap<PathBuf, Rc<[Point3<f64>]>>>,
}

impl Meshes {
    /// Reads meshes named by a URDF file.
    pub(crate) fn beside(file: &str, options: &LoadOptions) -> Self {
        let folder = Path::new(file).parent().unwrap_or(Path::new(""));
        Self {
            folder: folder.to_owned(),
            machine: options.machine(),
            read: RefCell::new(HashMap::new()),
        }
    }

    /// Returns the vertices of a mesh, unscaled.
    pub(super) fn vertices(&self, mesh: &str) -> Result<Rc<[Point3<f64>]>, Fault> {
        let path = self.find(mesh)?;
        if let Some(known) = self.read.borrow().get(&path) {
            return Ok(Rc::clone(known));
        }
        let vertices: Rc<[Point3<f64>]> = read(&path, self.files())
            .map_err(|reason| Fault::MeshUnreadable {
                mesh: path.display().to_string(),
                reason,
            })?
            .into();
        self.read.borrow_mut().insert(path, Rc::clone(&vertices));
        Ok(vertices)
    }

    /// The accessible files.
    pub(crate) fn files(&self) -> &FileAccess {
        &self.machine.files
    }

    /// Returns the file of a mesh's name.
    pub(crate) fn find(&self, mesh: &str) -> Result<PathBuf, Fault> {
        // Windows uses backslashes, and MuJoCo accepts them everywhere.
        let mesh = &mesh.replace('\\', "/");
        let bare = mesh.strip_prefix("file://").unwrap_or(mesh);
        // `model://` is SDF's prefix of packages; `$(find NAME)` remains if xacro did not find a
        // package.
        let in_package = ["package://", "model://", "$(find "]
            .iter()
            .find_map(|prefix| bare.strip_prefix(prefix));
        let Some(in_package) = in_package else {
            let path = self.folder.join(bare);
            let elsewhere = || self.of_another_machine(bare);
            return Ok(match self.files().is_file(&path) {
                true => path,
                false => elsewhere().unwrap_or(path),
            });
        };
        let end = in_package.find(['/', ')']).unwrap_or(in_package.len());
        let name = in_package[..end].trim();
        let path = in_package[end..].trim_start_matches([')', '/']);
        let find = |holds: &dyn Fn(&Path) -> bool| self.machine.find(&self.folder, name, holds);
        let file = find(&|folder| self.files().is_file(&folder.join(path)));
        // If the package exists but not the mesh, the mesh is what is missing.
        let folder = || find(&|folder| self.files().is_folder(folder));
        match file.or_else(folder) {
            Some(folder) => Ok(folder.join(path)),
            None => Err(Fault::PackageUnknown {
                package: name.to_owned(),
                mesh: mesh.clone(),
            }),
        }
    }
}

impl Meshes {
    /// Returns the file for a path of another machine that contains a package:
    /// `/home/ada/ws/install/base/share/base/m.stl` is `m.stl` of the package `base`.
    fn of_another_machine(&self, mesh: &str) -> Option<PathBuf> {
        /// Largest number of folders of a path tried as packages.
        const MOST: usize = 8;
        let folders: Vec<usize> = mesh.match_indices('/').map(|(at, _)| at).collect();
        if !mesh.starts_with('/') {
            return None;
        }
        let pairs = folders.windows(2).rev().take(MOST);
        pairs.into_iter().find_map(|pair| {
            let (name, path) = (&mesh[pair[0] + 1..pair[1]], &mesh[pair[1] + 1..]);
            let holds = |folder: &Path| self.files().is_file(&folder.join(path));
            let folder = self.machine.find(&self.folder, name, &holds)?;
            Some(folder.join(path)).filter(|file| self.files().is_file(file))
        })
    }
}

/// The bytes of a mesh file, of which there may be as many.
pub(super) fn bytes(path: &Path, files: &FileAccess, most: u64) -> Result<Vec<u8>, String> {
    let bytes = files.read(path, most).map_err(|e| e.to_string())?;
    match is_lfs_pointer(&bytes) {
        true => Err(LFS_POINTER.to_owned()),
        false => Ok(bytes),
    }
}

fn read(path: &Path, files: &FileAccess) -> Result<Vec<Point3<f64>>, String> {
    let bytes = bytes(path, files, MAX_BYTES)?;
    let vertices = match kind(path).as_str() {
        "stl" => stl(bytes)?,
        "obj" => obj(&bytes)?,
        "dae" => dae::vertices(&String::from_utf8_lossy(&bytes))?,
        other => return Err(other_kind(other)),
    };
    if vertices.is_empty() {
        return Err("it holds no vertices".to_owned());
    }
    if vertices
        .iter()
        .any(|v| !v.coords.iter().all(|x| x.is_finite()))
    {
        return Err("it holds a vertex that is not finite".to_owned());
    }
    Ok(vertices)
}

/// The message for a file whose content is missing.
pub(crate) const LFS_POINTER: &str =
    "it is a pointer of Git LFS to a file that was not fetched: `git lfs pull` fetches it";

/// Whether a file is only a Git LFS pointer.
pub(crate) fn is_lfs_pointer(bytes: &[u8]) -> bool {
    bytes.starts_with(b"version https://git-lfs.github.com/spec/")
}

/// Returns the kind of a mesh file: its extension in lower case.
pub(super) fn kind(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase()
}

/// Returns the message for a mesh of an unsupported kind.
pub(super) fn other_kind(kind: &str) -> String {
    format!("meshes of the kind `.{kind}` are not read, but `.stl`, `.obj` and `.dae` are")
}

fn stl(mut bytes: Vec<u8>) -> Result<Vec<Point3<f64>>, String> {
    open_stl(&mut bytes)?;
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let point = |v: &stl_io::Vertex| Point3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
    Ok(mesh.vertices.iter().map(point).collect())
}

/// Rejects an STL file that is shorter than it claims, and fixes the header of a binary one that
/// starts with `solid` like the text form, by which the reader decides.
pub(super) fn open_stl(bytes: &mut [u8]) -> Result<(), String> {
    // A binary STL has at byte 80 the number of triangles of 50 bytes that follow: the size
    // distinguishes the forms, and reveals a wrong count.
    let count = bytes
        .get(80..84)
        .and_then(|b| b.try_into().ok())
        .map_or(0, u32::from_le_bytes);
    let binary = bytes.len() as u64 >= 84 + 50 * u64::from(count) && count > 0;
    if binary {
        bytes[..80].fill(0);
    } else if !bytes.starts_with(b"solid") {
        return Err("it is cut short: fewer triangles than it says".to_owned());
    }
    Ok(())
}

/// Rejects an OBJ file that is no text, or whose faces have too few points or impossible indices,
/// which its reader would multiply. They count from 1, or backwards from the last one so far.
fn check_obj(bytes: &[u8]) -> Result<(), String> {
    /// A file of 64 MB contains fewer of anything.
    const MOST: i64 = 1_000_000_000;
    const KINDS: [&str; 3] = ["v", "vt", "vn"];
    let text = str::from_utf8(bytes).map_err(|_| "it is not UTF-8 text")?;
    let mut counts = [0; 3];
    for (line, number) in text.lines().zip(1..) {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        if let Some(kind) = KINDS.iter().position(|kind| *kind == first) {
            counts[kind] += 1;
        }
        if !["f", "l", "p"].contains(&first) {
            continue;
        }
        if first == "f" && words.clone().count() < 3 {
            return Err(format!(
                "on line {number}, a face has fewer than three points"
            ));
        }
        for (index, count) in words.flat_map(|corner| corner.split('/').zip(counts)) {
            match index.parse::<i64>() {
                Err(_) if index.is_empty() => {}
                Err(_) => {
                    return Err(format!(
                        "on line {number}, `{index:.20}` is no index of a point"
                    ));
                }
                Ok(index) if index == 0 || index < -count || index > MOST => {
                    return Err(format!(
                        "on line {number}, a face names a point that is not there"
                    ));
                }
                Ok(_) => {}
            }
        }
    }
    Ok(())
}

/// The models of an OBJ file.
pub(super) fn models(
    bytes: &[u8],
    options: &tobj::LoadOptions,
) -> Result<Vec<tobj::Model>, String> {
    check_obj(bytes)?;
    // Materials only set colours, and URDF has its own.
    let no_materials = |_: &Path| Ok(Default::default());
    let read = tobj::load_obj_buf(&mut Cursor::new(bytes), options, no_materials);
    read.map(|(models, _)| models).map_err(|e| e.to_string())
}

fn obj(bytes: &[u8]) -> Result<Vec<Point3<f64>>, String> {
    let models = models(bytes, &tobj::LoadOptions::default())?;
    Ok(models
        .iter()
        .flat_map(|model| model.mesh.positions.chunks_exact(3))
        .map(|v| Point3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])))
        .collect())
}
