//! The visual meshes of a robot, made small enough for a page.
//!
//! They do not collide and are no part of the dynamics.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use serde::{Deserialize, Serialize};

/// The meshes of the `<visual>` elements of a robot, and remarks on what was left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VisualMeshes {
    /// The meshes, each once however often it is used.
    pub meshes: Vec<Mesh>,
    /// What was left out or simplified.
    pub remarks: Vec<String>,
}

/// A mesh in the frame of its file, unscaled.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Its file name in the URDF.
    pub name: String,
    /// The lowest coordinates of its vertices.
    pub low: [f32; 3],
    /// Quantisation step of each coordinate.
    pub step: [f32; 3],
    /// The vertices, three steps each from the lowest coordinates: u16, little-endian, in base64.
    pub vertices: String,
    /// The triangles, three indices of vertices each: u16, little-endian, in base64.
    pub triangles: String,
}

impl VisualMeshes {
    /// Whether there is neither a mesh nor a remark.
    pub fn is_empty(&self) -> bool {
        self.meshes.is_empty() && self.remarks.is_empty()
    }

    /// Returns a copy with other meshes.
    pub fn with_meshes(&self, meshes: Vec<Mesh>) -> Self {
        Self {
            meshes,
            remarks: self.remarks.clone(),
        }
    }

    /// Returns the mesh with a name in the URDF, and its index.
    pub fn mesh(&self, name: &str) -> Option<(usize, &Mesh)> {
        let mut meshes = self.meshes.iter().enumerate();
        meshes.find(|(_, mesh)| mesh.name == name)
    }
}

impl Mesh {
    /// The corners of its bounding box: the lowest and the highest coordinates.
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let high = [0, 1, 2].map(|k| self.low[k] + self.step[k] * f32::from(u16::MAX));
        [self.low, high]
    }

    /// The number of its triangles.
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
