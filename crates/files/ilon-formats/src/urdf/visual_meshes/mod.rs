//! The visual meshes of a robot, from its `<visual>` elements, reduced for a page.
//!
//! They do not collide and are no part of the model; unreadable ones are left out with a remark.

mod coarse;
mod soup;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;

use super::links::link_tree;
use super::mesh::Meshes;
use crate::files::FileAccess;
use crate::model::{Link, LinkTree, Mesh, Visual, VisualMeshes, VisualShape};

/// Largest number of triangles of all meshes of a robot: about 200 kB of a page.
const MOST_TRIANGLES: usize = 16_000;
/// Largest number of files read.
const MOST_FILES: usize = 200;
/// Largest number of triangles read from all files, before the reduction.
const MOST_READ: usize = 3_000_000;

/// Returns the triangles of a mesh file, `.stl`, `.obj` or `.dae`: three vertices each, unscaled,
/// all finite.
///
/// # Errors
/// The reason why it cannot be read, as text.
pub fn mesh_triangles(path: &Path, files: &FileAccess) -> Result<Vec<[[f32; 3]; 3]>, String> {
    soup::read(path, files)
}

/// Reads the meshes of a URDF, except those of rollers, which are drawn by their exact outlines.
pub(crate) fn read(text: &str, meshes: &Meshes, rollers: &BTreeSet<&str>) -> VisualMeshes {
    let mut looks = VisualMeshes::default();
    // Most robots have none.
    if !text.contains("<mesh") {
        return looks;
    }
    let Some(tree) = link_tree(text) else {
        return looks;
    };
    let mut paths: BTreeMap<String, PathBuf> = BTreeMap::new();
    for name in names(&tree, rollers) {
        match meshes.find(name) {
            Ok(path) if paths.len() < MOST_FILES => {
                paths.insert(name.to_owned(), path);
            }
            Ok(_) => not_shown(&mut looks, name, "the robot shows too many meshes"),
            Err(fault) => not_shown(&mut looks, name, &fault.to_string()),
        }
    }
    let mut soups = Vec::new();
    let mut read = 0;
    for (name, path) in paths {
        match soup::read(&path, meshes.files()) {
            Ok(soup) if read + soup.len() > MOST_READ => not_shown(
                &mut looks,
                &name,
                &format!("the meshes of the robot have more than {MOST_READ} triangles"),
            ),
            Ok(soup) => {
                read += soup.len();
                soups.push((name, soup));
            }
            Err(reason) => not_shown(&mut looks, &name, &reason),
        }
    }
    let counts: Vec<usize> = soups.iter().map(|(_, soup)| soup.len()).collect();
    let share = share(&counts, MOST_TRIANGLES);
    let (mut before, mut after) = (0, 0);
    for (name, soup) in soups {
        let indexed = coarse::of(&soup, share);
        match mesh_of(&name, &indexed) {
            Some(mesh) => looks.meshes.push(mesh),
            None => not_shown(&mut looks, &name, "it holds no triangle that can be seen"),
        }
        if soup.len() > share {
            before += soup.len();
            after += indexed.triangles.len();
        }
    }
    if before > 0 {
        looks.remarks.push(format!(
                "The robot's meshes are drawn simplified, {after} triangles for {before}, so that a page stays light"
            ));
    }
    looks
}

fn not_shown(looks: &mut VisualMeshes, name: &str, reason: &str) {
    looks
        .remarks
        .push(format!("The mesh `{name}` is not drawn: {reason}"));
}

fn mesh_of(name: &str, indexed: &coarse::Indexed) -> Option<Mesh> {
    let first = *indexed.vertices.first()?;
    let (mut low, mut high) = (first, first);
    for vertex in &indexed.vertices {
        for axis in 0..3 {
            low[axis] = low[axis].min(vertex[axis]);
            high[axis] = high[axis].max(vertex[axis]);
        }
    }
    let step = [0, 1, 2].map(|k| (high[k] - low[k]) / f32::from(u16::MAX));
    let steps = |vertex: &[f32; 3]| -> [u16; 3] {
        [0, 1, 2].map(|k| match step[k] > 0.0 {
            // The number is between 0 and 65535.
            true => ((vertex[k] - low[k]) / step[k]).round() as u16,
            false => 0,
        })
    };
    let vertices = indexed.vertices.iter().flat_map(steps);
    // At most three vertices per triangle, of which there are at most 16,000.
    let triangles = indexed
        .triangles
        .iter()
        .flatten()
        .map(|index| *index as u16);
    Some(Mesh {
        name: name.to_owned(),
        low,
        step,
        vertices: base64(vertices),
        triangles: base64(triangles),
    })
}

fn base64(numbers: impl Iterator<Item = u16>) -> String {
    BASE64_STANDARD.encode(numbers.flat_map(u16::to_le_bytes).collect::<Vec<u8>>())
}

/// Returns the number of triangles per mesh so that the sum is at most `most`: small meshes keep
/// theirs, the others share the rest.
fn share(counts: &[usize], most: usize) -> usize {
    let mut sorted = counts.to_vec();
    sorted.sort_unstable();
    let mut left = most;
    for (k, count) in sorted.iter().enumerate() {
        let each = left / (sorted.len() - k);
        if *count > each {
            return each;
        }
        left -= count;
    }
    usize::MAX
}

/// Returns the meshes in the links of a robot, except those below the given rollers' joints.
fn names<'a>(tree: &'a LinkTree, rollers: &BTreeSet<&str>) -> BTreeSet<&'a str> {
    let is_shown = |link: &&Link| {
        let above = link.above.map(|joint| tree.joints[joint].name.as_str());
        above.is_none_or(|joint| !rollers.contains(joint))
    };
    let visuals = tree.links.iter().filter(is_shown).flat_map(|l| &l.visuals);
    let mesh = |visual: &'a Visual| match &visual.shape {
        VisualShape::Mesh { name, .. } => Some(name.as_str()),
        _ => None,
    };
    visuals.filter_map(mesh).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_small_keep_their_triangles_and_the_large_share_the_rest() {
        assert_eq!(share(&[10, 20, 30], 100), usize::MAX);
        assert_eq!(share(&[], 100), usize::MAX);
        // 10 stays, 90 are left for two.
        assert_eq!(share(&[500, 10, 60], 100), 45);
        assert_eq!(share(&[500, 10, 40], 100), 50);
        for counts in [vec![7, 90, 33, 2], vec![1; 200], vec![1000; 7]] {
            let each = share(&counts, 100);
            assert!(counts.iter().map(|c| c.min(&each)).sum::<usize>() <= 100.max(counts.len()));
        }
    }
}
