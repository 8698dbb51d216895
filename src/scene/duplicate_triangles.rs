//! Triangles that stand twice in one place.

use super::graph::Opacity;
use super::validate::Dropped;
use super::{Instance, Material, Mesh, MeshId, Scene, Visibility};
use glam::DVec3;
use std::collections::{BTreeMap, HashSet};
use std::hash::{BuildHasher, RandomState};

/// Whether twins of such triangles make light: each is sampled as a light of its own, but a ray meets one of them. (With
/// transparency each of them counts: two layers are two.)
pub fn make_light(material: &Material) -> bool {
    let summary = material.summary();
    summary.emits() && !summary.unlit && summary.opacity == Opacity::Full
}

/// Leaves out triangles whose corners are those of one before them, bit for bit; says how many. In the same order, if they have
/// one side: of two that are turned over each can be the one that is seen where back faces are not there.
pub fn leave_out(mesh: &mut Mesh, double_sided: bool) -> usize {
    let before = mesh.triangles.len();
    // Those that move may part; strands have no faces.
    if !mesh.motion.is_empty() || mesh.has_strands() {
        return 0;
    }
    let mut seen = HashSet::with_capacity(before);
    let positions = &mesh.positions;
    mesh.triangles.retain(|corners| {
        let corners = corners.map(|i| positions[i as usize].map(f32::to_bits));
        seen.insert(if double_sided {
            unordered(corners)
        } else {
            from_the_least(corners)
        })
    });
    before - mesh.triangles.len()
}

/// From the least corner on: it does not matter with which a triangle begins.
fn from_the_least<T: Ord + Copy>([a, b, c]: [T; 3]) -> [T; 3] {
    [b, c, a].min([c, a, b]).min([a, b, c])
}

/// Without regard to the side from which it is seen.
fn unordered<T: Ord>(mut corners: [T; 3]) -> [T; 3] {
    corners.sort_unstable();
    corners
}

/// A triangle of an instance.
#[derive(Clone, Copy)]
struct PlacedTriangle {
    hash: u64,
    single_sided: bool,
    instance: u32,
    triangle: u32,
}

/// What rays see of triangles that stand where others do, where that is less than their instance says: by instance.
type Seen = BTreeMap<u32, BTreeMap<Visibility, HashSet<u32>>>;

/// Triangles that make light and have the corners of one of another instance before theirs (in files from Blender: after), bit for bit as their
/// transforms place them, in f64, are seen by those rays only that do not see the other; where there are none, they are left out.
/// Those with one side have to be turned to the same side, or the other has two. An instance of whose mesh all are left out
/// goes, of others the mesh is divided.
pub fn leave_out_across(scene: &mut Scene) -> Dropped {
    let mut dropped = Dropped::default();
    let lights: Vec<bool> = scene.materials.iter().map(make_light).collect();
    let shining: Vec<u32> = (0..scene.instances.len() as u32)
        .filter(|&i| material_of(scene, i).is_some_and(|m| lights[m]) && !stands_alone(scene, i))
        .collect();
    if shining.len() < 2 {
        return dropped;
    }
    let twins = twins_among(scene, &shining);
    let mut gone = HashSet::new();
    for (&instance, seen) in &twins {
        let placed = scene.instances[instance as usize].clone();
        let mesh = scene.meshes[placed.mesh.0 as usize].clone();
        let with = |kept: &dyn Fn(u32) -> bool| {
            let mut number = 0..;
            let mut part = mesh.clone();
            part.triangles.retain(|_| number.next().is_some_and(kept));
            part
        };
        for (&visibility, triangles) in seen {
            if visibility.is_nothing() {
                dropped.add(&placed.name, triangles.len());
                continue;
            }
            let part = MeshId(scene.meshes.len() as u32);
            scene.meshes.push(with(&|n| triangles.contains(&n)));
            scene.instances.push(Instance {
                mesh: part,
                visibility,
                ..placed.clone()
            });
        }
        let rest = with(&|n| !seen.values().any(|triangles| triangles.contains(&n)));
        if rest.triangles.is_empty() {
            gone.insert(instance);
        } else {
            scene.instances[instance as usize].mesh = MeshId(scene.meshes.len() as u32);
            scene.meshes.push(rest);
        }
    }
    let mut number = 0..;
    scene
        .instances
        .retain(|_| number.next().is_some_and(|n| !gone.contains(&n)));
    dropped
}

/// Whether it moves: then it stands where another does for a moment only. Strands have no faces that could.
fn stands_alone(scene: &Scene, instance: u32) -> bool {
    let placed = &scene.instances[instance as usize];
    let mesh = &scene.meshes[placed.mesh.0 as usize];
    !placed.motion.is_empty() || !mesh.motion.is_empty() || mesh.has_strands()
}

/// The number of its material.
fn material_of(scene: &Scene, instance: u32) -> Option<usize> {
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh.0 as usize];
    mesh.material.map(|m| m.0 as usize)
}

/// Triangles of some instances that stand where one of another does that is kept.
fn twins_among(scene: &Scene, instances: &[u32]) -> Seen {
    let hasher = RandomState::new();
    let corners = |place: &PlacedTriangle| {
        let placed = &scene.instances[place.instance as usize];
        placed_corners(
            &scene.meshes[placed.mesh.0 as usize],
            placed,
            place.triangle,
        )
    };
    let mut places = Vec::new();
    for &instance in instances {
        let placed = &scene.instances[instance as usize];
        let count = scene.meshes[placed.mesh.0 as usize].triangles.len();
        let single_sided =
            material_of(scene, instance).is_some_and(|m| !scene.materials[m].double_sided);
        places.extend((0..count as u32).map(|triangle| {
            let place = PlacedTriangle {
                hash: 0,
                single_sided,
                instance,
                triangle,
            };
            let hash = hasher.hash_one((unordered(corners(&place)), placed.holdout));
            PlacedTriangle { hash, ..place }
        }));
    }
    // Those with two sides first: they stand for either. Cycles shows the last of several.
    let last_first = scene.is_from_blender();
    let order = |instance: u32| if last_first { !instance } else { instance };
    places.sort_unstable_by_key(|p| (p.hash, p.single_sided, order(p.instance), p.triangle));
    let mut twins = Seen::new();
    for group in places
        .chunk_by(|a, b| a.hash == b.hash)
        .filter(|g| g.len() > 1)
    {
        for (number, place) in group.iter().enumerate().skip(1) {
            let instance = &scene.instances[place.instance as usize];
            let here = corners(place);
            let seen = group[..number]
                .iter()
                .fold(instance.visibility, |seen, first| {
                    let other = &scene.instances[first.instance as usize];
                    let there = corners(first);
                    let covers = if first.single_sided {
                        from_the_least(here) == from_the_least(there)
                    } else {
                        unordered(here) == unordered(there)
                    };
                    if covers
                        && first.instance != place.instance
                        && other.holdout == instance.holdout
                        && other.is_catcher() == instance.is_catcher()
                    {
                        seen.behind(other.visibility)
                    } else {
                        seen
                    }
                });
            if seen != instance.visibility {
                let parts = twins.entry(place.instance).or_default();
                parts.entry(seen).or_default().insert(place.triangle);
            }
        }
    }
    twins
}

/// The corners of a triangle where its instance stands.
fn placed_corners(mesh: &Mesh, instance: &Instance, triangle: u32) -> [[u64; 3]; 3] {
    mesh.triangles[triangle as usize].map(|i| {
        let p = DVec3::from(mesh.positions[i as usize].map(f64::from));
        let p = instance.world_from_object.transform_point3(p);
        // 0 and -0 are one place.
        p.to_array().map(|x| (x + 0.0).to_bits())
    })
}

#[cfg(test)]
#[path = "../../tests/unit/scene/duplicate_triangles.rs"]
mod tests;
