//! The meshes by which a robot is **seen**: those of its `<visual>` elements, made small enough for a page.
//!
//! Nothing touches the world there, so they are no part of the model, and what cannot be read is remarked and left out.

mod coarse;
mod soup;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use roxmltree::{Document, Node};
use serde::{Deserialize, Serialize};

use super::mesh::Meshes;
use super::source::child;

/// The most triangles of all meshes of a robot together: about 200 kB of a page.
const MOST_TRIANGLES: usize = 16_000;
/// The most files that are read.
const MOST_FILES: usize = 200;
/// The most triangles that are read of all files together, before they are made fewer.
const MOST_READ: usize = 3_000_000;

/// The meshes of the `<visual>` elements of a robot, and what of them was left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Looks {
    /// The meshes, each once however often it is shown.
    pub meshes: Vec<Mesh>,
    /// What was left out or simplified.
    pub remarks: Vec<String>,
}

/// A mesh in the frame of its file, unscaled.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Mesh {
    /// What the URDF calls its file.
    pub name: String,
    /// The lowest coordinates of its vertices.
    pub low: [f32; 3],
    /// The step of each coordinate.
    pub step: [f32; 3],
    /// The vertices, three steps each from the lowest coordinates: u16, little-endian, in base64.
    pub vertices: String,
    /// The triangles, three indices of vertices each: u16, little-endian, in base64.
    pub triangles: String,
}

impl Looks {
    /// Whether there is neither a mesh nor anything to be said.
    pub fn is_empty(&self) -> bool {
        self.meshes.is_empty() && self.remarks.is_empty()
    }

    /// The same with other meshes.
    pub fn with_meshes(&self, meshes: Vec<Mesh>) -> Self {
        Self {
            meshes,
            remarks: self.remarks.clone(),
        }
    }

    /// The mesh that a URDF calls so.
    pub fn mesh(&self, name: &str) -> Option<(usize, &Mesh)> {
        let mut meshes = self.meshes.iter().enumerate();
        meshes.find(|(_, mesh)| mesh.name == name)
    }

    /// Reads the meshes of a URDF. Rollers are left out: they are drawn by their exact outlines.
    pub(crate) fn of_urdf(text: &str, meshes: &Meshes, rollers: &BTreeSet<&str>) -> Self {
        let mut looks = Self::default();
        // Most robots are seen without any.
        if !text.contains("<mesh") {
            return looks;
        }
        let Ok(document) = Document::parse(text) else {
            return looks;
        };
        let mut paths: BTreeMap<String, PathBuf> = BTreeMap::new();
        for name in names(&document, rollers) {
            match meshes.find(name) {
                Ok(path) if paths.len() < MOST_FILES => {
                    paths.insert(name.to_owned(), path);
                }
                Ok(_) => looks.not_shown(name, "the robot shows too many meshes"),
                Err(fault) => looks.not_shown(name, &fault.to_string()),
            }
        }
        let mut soups = Vec::new();
        let mut read = 0;
        for (name, path) in paths {
            match soup::read(&path, meshes.files()) {
                Ok(soup) if read + soup.len() > MOST_READ => looks.not_shown(
                    &name,
                    &format!("the meshes of the robot have more than {MOST_READ} triangles"),
                ),
                Ok(soup) => {
                    read += soup.len();
                    soups.push((name, soup));
                }
                Err(reason) => looks.not_shown(&name, &reason),
            }
        }
        let counts: Vec<usize> = soups.iter().map(|(_, soup)| soup.len()).collect();
        let share = share(&counts, MOST_TRIANGLES);
        let (mut before, mut after) = (0, 0);
        for (name, soup) in soups {
            let indexed = coarse::of(&soup, share);
            match Mesh::of(&name, &indexed) {
                Some(mesh) => looks.meshes.push(mesh),
                None => looks.not_shown(&name, "it holds no triangle that can be seen"),
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

    fn not_shown(&mut self, name: &str, reason: &str) {
        self.remarks
            .push(format!("The mesh `{name}` is not drawn: {reason}"));
    }
}

impl Mesh {
    fn of(name: &str, indexed: &coarse::Indexed) -> Option<Self> {
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
                // Of a number between 0 and 65535.
                true => ((vertex[k] - low[k]) / step[k]).round() as u16,
                false => 0,
            })
        };
        let vertices = indexed.vertices.iter().flat_map(steps);
        // No more vertices than three for each of the triangles, of which there are at most 16,000.
        let triangles = indexed
            .triangles
            .iter()
            .flatten()
            .map(|index| *index as u16);
        Some(Self {
            name: name.to_owned(),
            low,
            step,
            vertices: base64(vertices),
            triangles: base64(triangles),
        })
    }

    /// The corners of the box around it: the lowest and the highest coordinates.
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let high = [0, 1, 2].map(|k| self.low[k] + self.step[k] * f32::from(u16::MAX));
        [self.low, high]
    }

    /// How many triangles it has.
    pub fn triangle_count(&self) -> usize {
        BASE64_STANDARD
            .decode(&self.triangles)
            .map_or(0, |bytes| bytes.len() / 6)
    }

    /// Its vertices, in the frame of its file.
    pub fn vertices(&self) -> Vec<[f32; 3]> {
        let bytes = BASE64_STANDARD.decode(&self.vertices).unwrap_or_default();
        let steps: Vec<u16> = bytes
            .chunks_exact(2)
            .map(|b| u16::from_le_bytes([b[0], b[1]]))
            .collect();
        steps
            .chunks_exact(3)
            .map(|v| [0, 1, 2].map(|k| self.low[k] + self.step[k] * f32::from(v[k])))
            .collect()
    }
}

fn base64(numbers: impl Iterator<Item = u16>) -> String {
    BASE64_STANDARD.encode(numbers.flat_map(u16::to_le_bytes).collect::<Vec<u8>>())
}

/// How many triangles each may have so that all have at most `most`: the small ones keep theirs, the others share what is left.
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

/// The meshes that the links of a robot show, but for its rollers: what joints of these names carry.
fn names<'a>(document: &'a Document, rollers: &BTreeSet<&str>) -> BTreeSet<&'a str> {
    let elements = |tag: &'static str| {
        let all = document.root_element().children();
        all.filter(move |n| n.has_tag_name(tag))
    };
    let carried: BTreeSet<&str> = elements("joint")
        .filter(|joint| {
            joint
                .attribute("name")
                .is_some_and(|name| rollers.contains(name))
        })
        .filter_map(|joint| child(joint, "child")?.attribute("link"))
        .collect();
    let is_shown = |link: &Node| {
        link.attribute("name")
            .is_some_and(|name| !carried.contains(name))
    };
    elements("link")
        .filter(is_shown)
        .flat_map(|link| link.children().filter(|n| n.has_tag_name("visual")))
        .filter_map(|visual| child(child(visual, "geometry")?, "mesh")?.attribute("filename"))
        .collect()
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
