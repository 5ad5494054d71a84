//! State shared by the stages of reading a robot.

use super::mesh::Meshes;
use super::outline::WheelOutline;
use super::source::Source;
use super::tree::Tree;
use crate::model::Remark;
use crate::options::LoadOptions;

/// Inputs of every stage, and collected results.
pub(super) struct Loading<'a> {
    pub(super) source: &'a Source<'a>,
    pub(super) tree: &'a Tree,
    pub(super) options: &'a LoadOptions,
    pub(super) meshes: Meshes,
    pub(super) remarks: Vec<Remark>,
    pub(super) outlines: Vec<WheelOutline>,
}
