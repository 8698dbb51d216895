//! Triangles without area, which no ray meets.

use super::validate::Dropped;
use super::{Diagnostics, Mesh, Scene, Verdict};
use glam::{DVec3, Vec3};

/// Leaves such triangles out; how many.
pub(super) fn leave_out_without(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let corner = |i: u32| Vec3::from(mesh.positions[i as usize]);
    mesh.triangles
        .retain(|&[a, b, c]| vector(corner(a), corner(b), corner(c)) != DVec3::ZERO);
    before - mesh.triangles.len()
}

/// The same in a scene whose vertices have been displaced: what was a line may have been opened.
pub fn clean_displaced(scene: &mut Scene, diagnostics: &mut Diagnostics) {
    let mut dropped = Dropped::default();
    for mesh in scene.meshes.iter_mut().filter(|m| m.strands.is_none()) {
        let count = leave_out_without(mesh);
        dropped.add(&mesh.name, count);
    }
    report(&dropped, diagnostics);
}

/// Tells those that were left out.
pub(super) fn report(dropped: &Dropped, diagnostics: &mut Diagnostics) {
    dropped.report(
        diagnostics,
        "degenerate-triangles",
        Verdict::Exact,
        "without area",
    );
}

/// Twice the area along the normal, in f64: products of f32 differences neither round nor vanish.
pub(super) fn vector(a: Vec3, b: Vec3, c: Vec3) -> DVec3 {
    let a = a.as_dvec3();
    (b.as_dvec3() - a).cross(c.as_dvec3() - a)
}
