//! Reads the triangles of a mesh file, vertex by vertex.

use std::io::Cursor;
use std::path::Path;

use super::super::{dae, mesh};
use crate::files::FileAccess;

/// Largest file of a visual mesh, in bytes.
pub(super) const MAX_BYTES: u64 = 64 << 20;

/// Three vertices, unscaled.
pub(super) type Triangle = [[f32; 3]; 3];

/// Reads the triangles of a file.
pub(super) fn read(path: &Path, files: &FileAccess) -> Result<Vec<Triangle>, String> {
    let bytes = mesh::bytes(path, files, MAX_BYTES)?;
    let triangles = match mesh::kind(path).as_str() {
        "stl" => stl(bytes)?,
        "obj" => obj(&bytes)?,
        "dae" => {
            let triangles = dae::triangles(&String::from_utf8_lossy(&bytes))?;
            let corner = |p: nalgebra::Point3<f64>| [p.x as f32, p.y as f32, p.z as f32];
            triangles.into_iter().map(|t| t.map(corner)).collect()
        }
        other => return Err(mesh::other_kind(other)),
    };
    let is_finite = |t: &Triangle| t.iter().flatten().all(|x| x.is_finite());
    if !triangles.iter().all(is_finite) {
        return Err("it holds a vertex that is not finite".to_owned());
    }
    Ok(triangles)
}

fn stl(mut bytes: Vec<u8>) -> Result<Vec<Triangle>, String> {
    mesh::open_stl(&mut bytes)?;
    let mut file = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut file).map_err(|e| e.to_string())?;
    reader
        .map(|triangle| {
            let triangle = triangle.map_err(|e| e.to_string())?;
            Ok(triangle.vertices.map(|v| [v[0], v[1], v[2]]))
        })
        .collect()
}

fn obj(bytes: &[u8]) -> Result<Vec<Triangle>, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_lines: true,
        ignore_points: true,
        ..tobj::LoadOptions::default()
    };
    let models = mesh::models(bytes, &options)?;
    let mut triangles = Vec::new();
    for model in &models {
        let point = |index: &u32| {
            let first = 3 * *index as usize;
            let xyz = model.mesh.positions.get(first..first + 3)?;
            Some([xyz[0], xyz[1], xyz[2]])
        };
        for corners in model.mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| point(&corners[k]));
            let triangle = a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
            triangles.push(triangle.ok_or("a face names a vertex that is not there")?);
        }
    }
    Ok(triangles)
}
