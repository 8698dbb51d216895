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

/// Triangles that make light and have the corners of one of another instance before theirs, bit for bit as their
/// transforms place them, in f64, are seen by those rays only that do not see the other; where there are none, they are left out.
/// Those with one side have to be turned to the same side, or the other has two. An instance of whose mesh all are left out
/// goes, of others the mesh is divided.
pub fn leave_out_across(scene: &mut Scene) -> Dropped {
    let mut dropped = Dropped::default();
    let lights: Vec<bool> = scene.materials.iter().map(make_light).collect();
    let shining: Vec<u32> = (0..scene.instances.len() as u32)
        .filter(|&i| material_of(scene, i).is_some_and(|m| lights[m]))
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

/// The number of its material.
fn material_of(scene: &Scene, instance: u32) -> Option<usize> {
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh.0 as usize];
    mesh.material.map(|m| m.0 as usize)
}

/// Triangles of some instances that stand where one of an instance before them does.
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
    // Those with two sides first: they stand for either.
    places.sort_unstable_by_key(|p| (p.hash, p.single_sided, p.instance, p.triangle));
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
mod tests {
    use super::*;
    use crate::scene::{MaterialId, MetallicRoughness, RayKind};
    use glam::DAffine3;

    /// A copy of an object in its place goes, one that only shares a triangle loses it, whichever way it is turned.
    #[test]
    fn twins_of_other_objects_go() {
        let shining = Material::from(MetallicRoughness {
            emission: [1.0; 3],
            ..MetallicRoughness::default()
        });
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
            info: Default::default(),
        };
        let all = Visibility::ALL;
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
                placed(0, 0.4, all),
            ],
            ..Scene::default()
        };
        let mut with_two_sides = scene.clone();
        with_two_sides.materials[0].double_sided = true;
        leave_out_across(&mut with_two_sides);
        assert_eq!(with_two_sides.instances.len(), 3);
        let rest = with_two_sides.instances[1].mesh.0 as usize;
        assert_eq!(with_two_sides.meshes[rest].triangles, [[0, 2, 3]]);

        scene.materials[0].double_sided = false;
        // What the camera does not see is seen by no ray that sees the others; what they do not see stays for the camera.
        let mut hidden = scene.clone();
        let behind = Visibility::ALL.without(RayKind::Camera);
        hidden.instances = vec![placed(0, 0.3, all), placed(0, 0.3, behind)];
        leave_out_across(&mut hidden);
        assert_eq!(hidden.instances.len(), 1);
        hidden.instances = vec![placed(0, 0.3, behind), placed(1, 0.3, all)];
        leave_out_across(&mut hidden);
        let [first, rest, shared] = &hidden.instances[..] else {
            panic!("{:?}", hidden.instances);
        };
        let triangles = |i: &Instance| hidden.meshes[i.mesh.0 as usize].triangles.len();
        assert_eq!([first, rest, shared].map(triangles), [2, 2, 1]);
        assert_eq!((first.visibility, rest.visibility), (behind, all));
        for (kind, _) in RayKind::ALL {
            let sees = matches!(kind, RayKind::Camera | RayKind::Shadow);
            assert_eq!(shared.visibility.sees(kind), sees, "{kind:?}");
        }

        leave_out_across(&mut scene);
        let left: Vec<_> = scene
            .instances
            .iter()
            .map(|i| scene.meshes[i.mesh.0 as usize].triangles.clone())
            .collect();
        let whole = scene.meshes[0].triangles.clone();
        assert_eq!(left, [whole.clone(), vec![[0, 2, 3], [0, 3, 1]], whole]);
        // The mesh itself stays what it was.
        assert_eq!(scene.meshes[1].triangles.len(), 3);
        scene.materials[0] = Material::default();
        scene.instances.push(placed(0, 0.3, all));
        leave_out_across(&mut scene);
        assert_eq!(scene.instances.len(), 4);
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
        assert_eq!(leave_out(&mut mesh, false), 2);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 1], [0, 1, 3]]);
        assert_eq!(leave_out(&mut mesh, true), 1);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
    }
}
