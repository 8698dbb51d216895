//! Triangles that stand twice in one place.

use super::validate::Dropped;
use super::{AlphaMode, Instance, Material, Mesh, MeshId, Scene};
use glam::DVec3;
use std::collections::{BTreeMap, HashSet};
use std::hash::{BuildHasher, RandomState};

/// Whether twins of such triangles make light: each is sampled as a light of its own, but a ray meets one of them. (With
/// transparency each of them counts: two layers are two.)
pub fn make_light(material: &Material) -> bool {
    material.emission.iter().any(|&c| c > 0.0) && material.alpha_mode == AlphaMode::Opaque
}

/// Leaves out triangles whose corners are those of one before them, in the same order, bit for bit; says how many.
pub fn leave_out(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let mut seen = HashSet::with_capacity(before);
    let positions = &mesh.positions;
    mesh.triangles.retain(|corners| {
        let [a, b, c] = corners.map(|i| positions[i as usize].map(f32::to_bits));
        // From the least on, as it does not matter with which a triangle begins.
        seen.insert([[a, b, c], [b, c, a], [c, a, b]].into_iter().min())
    });
    before - mesh.triangles.len()
}

/// A triangle of an instance.
#[derive(Clone, Copy)]
struct Place {
    hash: u64,
    instance: u32,
    triangle: u32,
}

/// Leaves out triangles that make light and have the corners, in the same order, of one of an instance before theirs:
/// bit for bit as their transforms place them, in f64. Only instances that the same rays see are compared. An instance of
/// whose mesh all are left out goes, of others the mesh is copied.
pub fn leave_out_across(scene: &mut Scene) -> Dropped {
    let mut dropped = Dropped::default();
    let shining: Vec<u32> = (0..scene.instances.len() as u32)
        .filter(|&i| {
            let mesh = &scene.meshes[scene.instances[i as usize].mesh.0 as usize];
            let material = mesh.material.map(|m| &scene.materials[m.0 as usize]);
            material.is_some_and(make_light)
        })
        .collect();
    if shining.len() < 2 {
        return dropped;
    }
    let twins = twins_among(scene, &shining);
    let mut gone = HashSet::new();
    for (&instance, triangles) in &twins {
        let placed = &scene.instances[instance as usize];
        let mesh = &scene.meshes[placed.mesh.0 as usize];
        dropped.add(&placed.name, triangles.len());
        if triangles.len() == mesh.triangles.len() {
            gone.insert(instance);
            continue;
        }
        let mut number = 0..;
        let mut rest = mesh.clone();
        rest.triangles
            .retain(|_| number.next().is_some_and(|n| !triangles.contains(&n)));
        scene.instances[instance as usize].mesh = MeshId(scene.meshes.len() as u32);
        scene.meshes.push(rest);
    }
    let mut number = 0..;
    scene
        .instances
        .retain(|_| number.next().is_some_and(|n| !gone.contains(&n)));
    dropped
}

/// Triangles of some instances that stand where one of an instance before them does.
fn twins_among(scene: &Scene, instances: &[u32]) -> BTreeMap<u32, HashSet<u32>> {
    let hasher = RandomState::new();
    let corners = |instance: u32, triangle: u32| {
        let placed = &scene.instances[instance as usize];
        placed_corners(&scene.meshes[placed.mesh.0 as usize], placed, triangle)
    };
    let mut places = Vec::new();
    for &instance in instances {
        let placed = &scene.instances[instance as usize];
        let count = scene.meshes[placed.mesh.0 as usize].triangles.len();
        let seen = (placed.visibility.bits(), placed.holdout);
        places.extend((0..count as u32).map(|triangle| Place {
            hash: hasher.hash_one((corners(instance, triangle), seen)),
            instance,
            triangle,
        }));
    }
    places.sort_unstable_by_key(|p| (p.hash, p.instance, p.triangle));
    let mut twins: BTreeMap<u32, HashSet<u32>> = BTreeMap::new();
    for pair in places.windows(2) {
        let [first, second] = [pair[0], pair[1]];
        if first.hash == second.hash
            && first.instance != second.instance
            && corners(first.instance, first.triangle) == corners(second.instance, second.triangle)
        {
            twins
                .entry(second.instance)
                .or_default()
                .insert(second.triangle);
        }
    }
    twins
}

/// The corners of a triangle where its instance stands, from the least on.
fn placed_corners(mesh: &Mesh, instance: &Instance, triangle: u32) -> [[u64; 3]; 3] {
    let [a, b, c] = mesh.triangles[triangle as usize].map(|i| {
        let p = DVec3::from(mesh.positions[i as usize].map(f64::from));
        let p = instance.world_from_object.transform_point3(p);
        // 0 and -0 are one place.
        p.to_array().map(|x| (x + 0.0).to_bits())
    });
    [[a, b, c], [b, c, a], [c, a, b]]
        .into_iter()
        .min()
        .unwrap_or([a, b, c])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{MaterialId, Visibility};
    use glam::DAffine3;

    /// A copy of an object in its place goes, one that only shares a triangle loses it, one that other rays see stays.
    #[test]
    fn twins_of_other_objects_go() {
        let shining = Material {
            emission: [1.0; 3],
            ..Material::default()
        };
        let mesh = |triangles: &[[u32; 3]]| Mesh {
            positions: vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
            ],
            triangles: triangles.to_vec(),
            material: Some(MaterialId(0)),
            ..Mesh::default()
        };
        let placed = |mesh: u32, x: f64, visibility| Instance {
            name: format!("{mesh} at {x}"),
            mesh: MeshId(mesh),
            world_from_object: DAffine3::from_translation(DVec3::X * x),
            visibility,
            holdout: false,
        };
        let all = Visibility::ALL;
        let hidden = Visibility::ALL.without(crate::scene::RayKind::Camera);
        let mut scene = Scene {
            materials: vec![shining],
            meshes: vec![
                mesh(&[[0, 1, 2], [0, 1, 3]]),
                mesh(&[[0, 2, 3], [1, 2, 0], [0, 3, 1]]),
            ],
            instances: vec![
                placed(0, 0.3, all),
                placed(0, 0.3, all),
                placed(1, 0.3, all),
                placed(0, 0.3, hidden),
                placed(0, 0.4, all),
            ],
            ..Scene::default()
        };
        leave_out_across(&mut scene);
        let left: Vec<_> = scene
            .instances
            .iter()
            .map(|i| scene.meshes[i.mesh.0 as usize].triangles.clone())
            .collect();
        let whole = scene.meshes[0].triangles.clone();
        assert_eq!(
            left,
            [
                whole.clone(),
                vec![[0, 2, 3], [0, 3, 1]],
                whole.clone(),
                whole
            ]
        );
        // The mesh itself stays what it was.
        assert_eq!(scene.meshes[1].triangles.len(), 3);
        scene.materials[0].emission = [0.0; 3];
        scene.instances.push(placed(0, 0.3, all));
        leave_out_across(&mut scene);
        assert_eq!(scene.instances.len(), 5);
    }

    #[test]
    fn twins_go_and_others_stay() {
        let (p, q, r, s) = (
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        );
        let mut mesh = Mesh {
            positions: vec![p, q, r, s, p, q, r],
            // The second is the first with other vertices, the third is turned over, the fourth begins elsewhere.
            triangles: vec![[0, 1, 2], [4, 5, 6], [0, 2, 1], [1, 2, 0], [0, 1, 3]],
            ..Mesh::default()
        };
        assert_eq!(leave_out(&mut mesh), 2);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 1], [0, 1, 3]]);
    }
}
