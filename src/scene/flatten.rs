//! Objects that their transform presses flat: a transform that cannot be inverted is none that rays follow, so that they
//! get meshes of their own that are flat by themselves.

use std::collections::{HashMap, HashSet};

use glam::{DMat3, DVec3};

use super::{Mesh, MeshId, Scene, own_space};

/// What is flattened may have so many triangles more than the scene's meshes have.
const SPARE: usize = 1 << 20;

/// Columns within this of a line or of a plane are one in f32.
const ROUNDING: f64 = f32::EPSILON as f64;

/// How many directions a transform keeps: 3, 2 (a plane) or fewer, in a way that does not depend on its scale.
pub(super) fn directions(m: &DMat3) -> usize {
    let columns = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.try_normalize());
    if let [Some(x), Some(y), Some(z)] = columns
        && DMat3::from_cols(x, y, z).determinant().abs() >= ROUNDING
    {
        return 3;
    }
    let pairs = [(0, 1), (1, 2), (2, 0)];
    let independent = pairs.iter().any(|&(a, b)| match (columns[a], columns[b]) {
        (Some(a), Some(b)) => a.cross(b).length() >= ROUNDING,
        _ => false,
    });
    if independent { 2 } else { 1 }
}

/// Gives objects that are flat but have an area meshes of their own, in place of the transform. What becomes a line or a point
/// is left for `validate` to leave out, as are copies beyond all proportion. So is what Cycles does not show: it turns rays into the
/// space of a mesh that stays there, by a transform that does not exist. Returns the numbers of these instances.
pub(super) fn flatten(scene: &mut Scene) -> HashSet<usize> {
    let mut hidden = HashSet::new();
    let mut left = SPARE
        + scene
            .meshes
            .iter()
            .map(|m| m.triangles.len())
            .sum::<usize>();
    let mut made: HashMap<(MeshId, [u64; 9]), Option<MeshId>> = HashMap::new();
    let is_from_blender = scene.is_from_blender();
    // Most scenes have none.
    let mut stays = None;
    for number in 0..scene.instances.len() {
        let place = scene.instances[number].world_from_object;
        let m = place.matrix3;
        if !place.is_finite() || directions(&m) != 2 {
            continue;
        }
        if is_from_blender && stays.get_or_insert_with(|| own_space::stays(scene))[number] {
            hidden.insert(number);
            continue;
        }
        let instance = &mut scene.instances[number];
        let Some(mesh) = scene.meshes.get(instance.mesh.0 as usize) else {
            continue;
        };
        if mesh.has_strands() {
            continue;
        }
        let key = (instance.mesh, m.to_cols_array().map(f64::to_bits));
        let flat = match made.get(&key) {
            Some(&flat) => flat,
            None => {
                // Corners and the attributes of vertices take memory alike.
                let size = mesh.triangles.len().max(mesh.positions.len());
                let flat = (size <= left)
                    .then(|| flat(mesh, &m))
                    .filter(|flat| !flat.triangles.is_empty())
                    .map(|flat| {
                        left -= size;
                        scene.meshes.push(flat);
                        MeshId(u32::try_from(scene.meshes.len() - 1).unwrap_or(u32::MAX))
                    });
                made.insert(key, flat);
                flat
            }
        };
        if let Some(flat) = flat {
            instance.mesh = flat;
            instance.world_from_object.matrix3 = DMat3::IDENTITY;
        }
    }
    hidden
}

/// A mesh under a transform that keeps a plane.
fn flat(mesh: &Mesh, m: &DMat3) -> Mesh {
    let d3 = |v: &[f32]| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
    let place = |i: u32| mesh.positions.get(i as usize).map(|p| *m * d3(p));
    let triangles = mesh.triangles.iter().copied().filter(|corners| {
        // Corners that do not exist, or are not finite, are for others to count.
        let [Some(a), Some(b), Some(c)] = corners.map(place) else {
            return true;
        };
        let (e, f) = (b - a, c - a);
        // By f64, as f32 would make slivers of what has become a line.
        let area = e.cross(f).length();
        area.is_nan() || area > ROUNDING * e.length() * f.length()
    });
    Mesh {
        positions: mesh
            .positions
            .iter()
            .map(|p| (*m * d3(p)).as_vec3().into())
            .collect(),
        triangles: triangles.collect(),
        // The inverse transpose does not exist, but the cofactor matrix turns all normals to the plane's: that of the
        // triangles.
        normals: None,
        tangents: mesh.tangents.as_ref().map(|tangents| {
            let turned = tangents.iter().map(|t| {
                let along = (*m * d3(t)).normalize_or_zero().as_vec3();
                [along.x, along.y, along.z, t[3]]
            });
            turned.collect()
        }),
        // All normals become one: nothing goes around it.
        radial: None,
        motion: Vec::new(),
        ..mesh.clone()
    }
}

#[cfg(test)]
#[path = "../../tests/unit/scene/flatten.rs"]
mod tests;
