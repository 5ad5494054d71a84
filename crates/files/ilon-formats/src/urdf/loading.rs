//! What the stages of reading a robot share.

use super::mesh::Meshes;
use super::outline::WheelOutline;
use super::source::Source;
use super::tree::Tree;
use crate::model::Remark;
use crate::options::LoadOptions;

/// What is needed in every stage, and what the stages gather.
pub(super) struct Loading<'a> {
    pub(super) source: &'a Source<'a>,
    pub(super) tree: &'a Tree,
    pub(super) options: &'a LoadOptions,
    pub(super) meshes: Meshes,
    pub(super) remarks: Vec<Remark>,
    pub(super) outlines: Vec<WheelOutline>,
}
