//! Triangle meshes in the layout that Embree reads in place.

use super::{EmbreeError, check_steps};

/// Vertices and corner indices in the layout that Embree reads in place.
pub struct TriangleMesh {
    /// One more than there are: Embree reads 16 bytes at each vertex.
    pub(super) vertices: Vec<[f32; 3]>,
    /// Where they are at equal steps of time, padded alike; empty where they stand still.
    pub(super) keys: Vec<Vec<[f32; 3]>>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Takes the buffers over.
    ///
    /// # Errors
    /// If an index is out of range: Embree would read outside the buffer.
    pub fn new(mut vertices: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, EmbreeError> {
        let count = vertices.len();
        if triangles.iter().flatten().any(|&i| i as usize >= count) {
            return Err(EmbreeError(format!(
                "a triangle refers to a vertex beyond the {count} that there are"
            )));
        }
        vertices.push([0.0; 3]);
        Ok(Self {
            vertices,
            keys: Vec::new(),
            triangles,
        })
    }

    /// The same with places of the vertices at equal steps of time, the first at 0 and the last at 1.
    ///
    /// # Errors
    /// If a step has another number of vertices, or there are more steps than Embree takes.
    pub fn moving(mut self, keys: Vec<Vec<[f32; 3]>>) -> Result<Self, EmbreeError> {
        check_steps(keys.len())?;
        let count = self.vertices().len();
        if keys.iter().any(|key| key.len() != count) {
            let words = format!("a step of a motion has not the {count} vertices of its mesh");
            return Err(EmbreeError(words));
        }
        self.keys = keys;
        for key in &mut self.keys {
            key.push([0.0; 3]);
        }
        Ok(self)
    }

    /// One triangle.
    pub fn single(corners: [[f32; 3]; 3]) -> Self {
        let [a, b, c] = corners;
        Self {
            vertices: vec![a, b, c, [0.0; 3]],
            keys: Vec::new(),
            triangles: vec![[0, 1, 2]],
        }
    }

    /// Whether its vertices move.
    pub fn moves(&self) -> bool {
        !self.keys.is_empty()
    }

    /// How many steps of time there are; 0 where it stands still.
    pub fn steps(&self) -> usize {
        self.keys.len()
    }

    /// Where a vertex is at a step.
    #[inline]
    pub fn vertex_at(&self, step: usize, vertex: u32) -> [f32; 3] {
        self.keys[step][vertex as usize]
    }

    /// The vertices.
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices[..self.vertices.len() - 1]
    }

    /// The corner indices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The three corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [[f32; 3]; 3] {
        self.between(self.triangles[triangle as usize])
    }

    /// The corners with these numbers.
    #[inline]
    pub fn between(&self, corners: [u32; 3]) -> [[f32; 3]; 3] {
        corners.map(|i| self.vertices[i as usize])
    }
}
