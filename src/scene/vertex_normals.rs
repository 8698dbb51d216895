//! Normals and tangents of vertices, made fit for rendering.

use super::{Diagnostics, Effect, Mesh, Verdict, area};
use glam::{DVec3, Vec3};

/// Stands for a normal that is to be made of the faces.
const NONE: [f32; 3] = [f32::NAN; 3];

/// How far the square of a unit vector's length may be from 1 before it is normalised again: 16-bit
/// and 8-bit normals are further off, f32 ones are not.
const UNIT_TOLERANCE: f32 = 1e-4;

/// Makes normals unit ones. What is none is the mean of its faces' normals, and told; but zero stays zero in files by Blender (vertices
/// of opposed faces have it): Cycles takes what the other corners make, or the face's own normal, and so do hits here.
pub fn clean(mesh: &mut Mesh, from_blender: bool, diagnostics: &mut Diagnostics) {
    let Some(normals) = &mut mesh.normals else {
        return;
    };
    let mut missing = false;
    for normal in normals.iter_mut() {
        let n = Vec3::from(*normal);
        if (n.length_squared() - 1.0).abs() > UNIT_TOLERANCE || !n.is_finite() {
            // f64, as the square of a short normal may vanish in f32.
            match n.as_dvec3().try_normalize().filter(|_| n.is_finite()) {
                Some(unit) => *normal = unit.as_vec3().into(),
                None if from_blender && n == Vec3::ZERO => *normal = [0.0; 3],
                None => (*normal, missing) = (NONE, true),
            }
        }
    }
    if !missing {
        return;
    }
    // The sum of the faces' normals, weighted by area, where the file has none.
    let mut sums = vec![DVec3::ZERO; normals.len()];
    let mut used = false;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| Vec3::from(mesh.positions[i as usize]));
        for &i in triangle {
            if normals[i as usize][0].is_nan() {
                sums[i as usize] += area::vector(a, b, c);
                used = true;
            }
        }
    }
    for (normal, sum) in normals.iter_mut().zip(sums) {
        if normal[0].is_nan() {
            *normal = sum.normalize_or(DVec3::Z).as_vec3().into();
        }
    }
    if used {
        diagnostics.report_effect(
            Effect::SmoothNormals,
            "bad-normals",
            Verdict::Approximated,
            "vertex normals that are zero or not finite",
            &mesh.name,
            "computed from the faces",
        );
    }
}

/// Makes tangents unit ones. What is none is any direction at right angles to the normal, and told.
pub fn clean_tangents(mesh: &mut Mesh, diagnostics: &mut Diagnostics) {
    let (Some(tangents), normals) = (&mut mesh.tangents, &mesh.normals) else {
        return;
    };
    let mut replaced = false;
    // Those that were made of coordinates may be none.
    let may_be_none = mesh.tangent_set.is_some();
    for (i, tangent) in tangents.iter_mut().enumerate() {
        let [x, y, z, w] = *tangent;
        let t = Vec3::new(x, y, z);
        if may_be_none && t == Vec3::ZERO {
            continue;
        }
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        let unit = match t.as_dvec3().try_normalize().filter(|_| t.is_finite()) {
            Some(_) if (t.length_squared() - 1.0).abs() <= UNIT_TOLERANCE => t,
            Some(unit) => unit.as_vec3(),
            None => {
                replaced = true;
                normals
                    .as_ref()
                    .map_or(Vec3::X, |n| Vec3::from(n[i]).any_orthonormal_vector())
            }
        };
        *tangent = [unit.x, unit.y, unit.z, sign];
    }
    if replaced {
        diagnostics.report_effect(
            Effect::NormalMaps,
            "bad-tangents",
            Verdict::Approximated,
            "tangents that are zero or not finite",
            &mesh.name,
            "any direction along the surface is used",
        );
    }
}
