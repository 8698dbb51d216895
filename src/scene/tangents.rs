//! Tangents by MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited"), as glTF
//! demands where a normal map comes without them (specification 3.7.2.1).

use rustc_hash::FxHashMap;

use bevy_mikktspace::{Geometry, TangentSpace};
use glam::Vec3;

use super::Mesh;

struct Corners<'a> {
    mesh: &'a Mesh,
    uv_set: usize,
    /// One for each corner of each triangle.
    tangents: Vec<Option<[f32; 4]>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        match &self.mesh.normals {
            Some(normals) => normals[self.vertex(face, corner)],
            None => face_normal(self.mesh, face),
        }
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // glTF's v grows downwards; MikkTSpace and normal maps with +Y up mean it upwards.
        let [u, v] = self.mesh.uvs[self.uv_set][self.vertex(face, corner)];
        [u, 1.0 - v]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[face * 3 + corner] = space.map(|s| s.tangent_encoded());
    }
}

/// Computes the tangents of a mesh from one of its UV sets.
///
/// MikkTSpace works on single corners; afterwards corners of the same vertex with the same tangent
/// become one vertex again. All indices of the mesh must be in range.
///
/// Where coordinates span no area tangents are along x, as Cycles has them, or zero.
pub fn compute(mesh: &mut Mesh, uv_set: usize) {
    let mut corners = Corners {
        mesh,
        uv_set,
        tangents: vec![None; mesh.triangles.len() * 3],
    };
    if !is_sane(&corners) {
        // Not-a-numbers go to `scene::validate`, which drops their triangles; the sort inside the
        // algorithm has no order for them.
        return;
    }
    // Its error type has no values; were there one, `None` tangents would be filled in below.
    let _ = bevy_mikktspace::generate_tangents(&mut corners);
    let tangents: Vec<[f32; 4]> = corners
        .tangents
        .iter()
        .map(|tangent| match tangent {
            Some(t) if Vec3::new(t[0], t[1], t[2]).try_normalize().is_some() => *t,
            Some(_) => [0.0, 0.0, 0.0, 1.0],
            // The paper's own code begins with that one, and the lesser sign.
            None => [1.0, 0.0, 0.0, -1.0],
        })
        .collect();

    let mut vertices: FxHashMap<(u32, [u32; 4]), u32> =
        FxHashMap::with_capacity_and_hasher(mesh.positions.len(), Default::default());
    let mut origin: Vec<u32> = Vec::with_capacity(mesh.positions.len());
    let mut kept: Vec<[f32; 4]> = Vec::with_capacity(mesh.positions.len());
    for (corner, tangent) in mesh.triangles.iter_mut().flatten().zip(&tangents) {
        *corner = *vertices
            .entry((*corner, tangent.map(f32::to_bits)))
            .or_insert_with(|| {
                origin.push(*corner);
                kept.push(*tangent);
                (origin.len() - 1) as u32
            });
    }
    // All else comes along; those of before go.
    mesh.tangents = None;
    mesh.take_vertices(&origin);
    mesh.tangents = Some(kept);
    mesh.tangent_set = Some(uv_set as u32);
}

fn is_sane(corners: &Corners) -> bool {
    let finite = |v: &[f32]| v.iter().all(|c| c.is_finite());
    let mesh = corners.mesh;
    mesh.positions.iter().all(|p| finite(p))
        && mesh.uvs[corners.uv_set].iter().all(|p| finite(p))
        && mesh.normals.iter().flatten().all(|n| finite(n))
}

fn face_normal(mesh: &Mesh, face: usize) -> [f32; 3] {
    let [a, b, c] = mesh.triangles[face].map(|i| Vec3::from(mesh.positions[i as usize]));
    (b - a).cross(c - a).normalize_or(Vec3::Z).into()
}

#[cfg(test)]
#[path = "../../tests/unit/scene/tangents.rs"]
mod tests;
