//! Strands of hair, and points: what has a thickness about its vertices.

use super::Mesh;

/// What strands look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrandShape {
    /// Flat, but shaded as if they were round; so many pieces for each segment.
    Ribbon(u8),
    /// Round about Catmull-Rom curves.
    Round,
    /// Round about straight segments.
    RoundLinear,
    /// Spheres.
    Points,
}

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
    /// The curve or point that each of its segments is of, by number.
    pub fn curves(&self) -> Vec<u32> {
        let mut number = 0;
        let mut end = None;
        let numbers = self.triangles.iter().map(|&[from, to, _]| {
            number += u32::from(end.is_some_and(|end| end != from || from == to));
            end = Some(to);
            number
        });
        numbers.collect()
    }

    /// Whether it is made of strands or points, and not of triangles.
    pub fn has_strands(&self) -> bool {
        self.strands.is_some()
    }
}
