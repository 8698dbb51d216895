//! The curved surface that normals of vertices stand for.

use super::Asking;
use super::geometry::{MeshData, MeshInstance};
use crate::effects::General;
use crate::ffi::embree::Hit;
use glam::Vec3;

/// From a point of a triangle to the curved surface that its vertex normals tell of: the mean, weighted by the barycentric
/// coordinates, of where the point is projected to on the tangent planes of the corners, as far as it lies below them
/// (Hanika, *Hacking the Shadow Terminator*; Boubekeur and Alexa, *Phong Tessellation*, 2008). `side`: the triangle's
/// normal on the side that counts. 0 where there are no normals, or the surface is hollow.
pub fn lift(
    (entry, mesh, triangle): (&MeshInstance, &MeshData, u32),
    hit: &Hit,
    side: Vec3,
) -> Vec3 {
    let Some(normals) = &mesh.normals else {
        return Vec3::ZERO;
    };
    let at = entry.at(mesh, (triangle, hit.u, hit.v), Asking::along(Vec3::ZERO));
    let sign = if entry.normal::<General>(at.vector(normals)).dot(side) < 0.0 {
        -1.0
    } else {
        1.0
    };
    let [a, b, c] = mesh.corners(triangle);
    let (to_b, to_c) = (b - a, c - a);
    // The point from each corner, without the corners' own size.
    let from_a = to_b * hit.u + to_c * hit.v;
    let offsets = [from_a, from_a - to_b, from_a - to_c];
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let mut lift = Vec3::ZERO;
    for ((corner, offset), weight) in at.corners.into_iter().zip(offsets).zip(weights) {
        let n = Vec3::from(normals[corner as usize]) * sign;
        lift -= n * (weight * offset.dot(n).min(0.0));
    }
    entry.vector::<General>(lift)
}
