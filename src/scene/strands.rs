//! Strands of hair, and points: what has a thickness about its vertices.

use super::Mesh;

pub use crate::ffi::embree::StrandShape;

/// What makes strands or points of a mesh's vertices.
///
/// Such a mesh has segments in place of triangles: [`Strands::segment`] from one vertex to another, or [`Strands::point`]. A
/// segment that begins where the last one ended goes on with its curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Strands {
    /// What they look like.
    pub shape: StrandShape,
    /// Radius at each vertex, object space, metres.
    pub radii: Vec<f32>,
    /// The curve's normal at each vertex, which elliptic sections follow, Blender's axes; empty where there are none. As in Cycles it
    /// does not turn with the object.
    pub normals: Vec<[f32; 3]>,
}

impl Strands {
    /// The corners that stand for a segment: what is linear between them is so along the segment, whatever lies across.
    pub fn segment(from: u32, to: u32) -> [u32; 3] {
        [from, to, from]
    }

    /// The corners that stand for a point.
    pub fn point(at: u32) -> [u32; 3] {
        [at; 3]
    }
}

impl Mesh {
    /// Whether it is made of strands or points, and not of triangles.
    pub fn has_strands(&self) -> bool {
        self.strands.is_some()
    }
}
