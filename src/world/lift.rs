//! The curved surface that normals of vertices stand for.

use super::Asking;
use super::geometry::{MeshData, MeshInstance};
use super::place::HitPoint;
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
    let Some((at, normals)) = with_normals((entry, mesh, triangle), hit) else {
        return Vec3::ZERO;
    };
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

/// From a point of a triangle to where Cycles starts rays to lights that graze it: along the normal between those of the corners.
/// `side`: the triangle's normal on the side that the light is on. 0 where there are no normals.
pub fn bulge(
    (entry, mesh, triangle): (&MeshInstance, &MeshData, u32),
    hit: &Hit,
    side: Vec3,
) -> Vec3 {
    let Some((at, normals)) = with_normals((entry, mesh, triangle), hit) else {
        return Vec3::ZERO;
    };
    let normals = at
        .corners
        .map(|corner| Vec3::from(normals[corner as usize]));
    let weights = Vec3::new(1.0 - hit.u - hit.v, hit.u, hit.v);
    let normal = entry.vector::<General>(between(normals, weights));
    let outward = normal.dot(side) > 0.0;
    normal * height(mesh.corners(triangle), normals, weights, outward)
}

/// The point, and the normals of its mesh's vertices, if it has any.
fn with_normals<'a>(
    (entry, mesh, triangle): (&'a MeshInstance, &'a MeshData, u32),
    hit: &Hit,
) -> Option<(HitPoint<'a>, &'a [[f32; 3]])> {
    let normals = mesh.normals.as_deref()?;
    let at = entry.at(mesh, (triangle, hit.u, hit.v), Asking::along(Vec3::ZERO));
    Some((at, normals))
}

fn between(of: [Vec3; 3], weights: Vec3) -> Vec3 {
    of[0] * weights.x + of[1] * weights.y + of[2] * weights.z
}

/// How far that is: to the nearest of the corners' tangent planes, or where the surface is hollow to the nearest of the parallel planes
/// through the highest other corner; at least half the height of a parabola through the corners. `outward`: to the side of the
/// normals; to the other it is below 0.
fn height(corners: [Vec3; 3], normals: [Vec3; 3], weights: Vec3, outward: bool) -> f32 {
    let point = between(corners, weights);
    // How much the normals open along each edge.
    let opens = |i: usize, k: usize| (normals[k] - normals[i]).dot(corners[k] - corners[i]);
    let (ca, cb, ab) = (-opens(0, 2), -opens(1, 2), opens(0, 1));
    let (u, v) = (weights.x, weights.y);
    let parabola = ca * u * (u - 1.0) + (ca + cb + ab) * u * v + cb * v * (v - 1.0);
    let sign = if outward { 1.0 } else { -1.0 };
    let plane = |i: usize| {
        let above = |to: Vec3| sign * (to - corners[i]).dot(normals[i]);
        let most = above(corners[(i + 1) % 3]).max(above(corners[(i + 2) % 3]));
        (most.max(0.0) - above(point)).max(0.0)
    };
    let least = plane(0).min(plane(1)).min(plane(2));
    sign * least.max(0.5 * parabola * sign)
}

#[cfg(test)]
#[path = "../../tests/unit/world/lift.rs"]
mod tests;
