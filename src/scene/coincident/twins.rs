//! Triangles that have all corners of another, bit for bit in world space and f32.

use super::seen::{Seen, mixed};
use super::{AT_ONCE, MOST_TRIANGLES, bits, corners, lies_on_nothing, mesh_of, placed};
use crate::scene::{Instance, Scene};
use rayon::prelude::*;

/// All of them, by instance and triangle.
pub(super) fn find(scene: &Scene) -> Vec<(u32, u32)> {
    let mut left = MOST_TRIANGLES;
    let looked_at: Vec<(u32, &Instance)> = (0..)
        .zip(&scene.instances)
        .filter(|(_, instance)| !lies_on_nothing(scene, instance))
        .take_while(|(_, instance)| {
            left = left.saturating_sub(mesh_of(scene, instance).triangles.len());
            left > 0
        })
        .collect();
    let seen = Seen::new(MOST_TRIANGLES - left);
    looked_at.par_iter().for_each(|&(_, instance)| {
        let none = |hash| {
            seen.add(hash);
            false
        };
        triangles(scene, instance, none);
    });
    let again = looked_at.par_iter().flat_map_iter(|&(number, instance)| {
        let again = triangles(scene, instance, |hash| seen.was_twice(hash));
        again
            .into_iter()
            .map(move |(hash, triangle)| (hash, number, triangle))
    });
    let mut again: Vec<(u64, u32, u32)> = again.collect();
    again.par_sort_unstable();
    let groups = again.chunk_by(|a, b| a.0 == b.0);
    let groups = groups.filter(|group| group.len() > 1);
    groups.flat_map(|group| alike(scene, group)).collect()
}

/// Those of one hash that have all corners of another.
fn alike(scene: &Scene, group: &[(u64, u32, u32)]) -> Vec<(u32, u32)> {
    let places = |&(_, number, triangle): &(u64, u32, u32)| {
        let instance = &scene.instances[number as usize];
        let of = corners(mesh_of(scene, instance), triangle);
        let mut places = of.map(|p| bits(placed(&instance.world_from_object, p)));
        places.sort_unstable();
        (places, number, triangle)
    };
    let mut group: Vec<_> = group.iter().map(places).collect();
    group.sort_unstable();
    let same = group.chunk_by(|a, b| a.0 == b.0);
    same.filter(|same| same.len() > 1)
        .flatten()
        .map(|&(_, number, triangle)| (number, triangle))
        .collect()
}

/// Those triangles of an instance whose hash is wanted, with it. It is that of the sum of the corners' hashes, whichever comes first.
fn triangles(
    scene: &Scene,
    instance: &Instance,
    is_wanted: impl Fn(u64) -> bool + Sync,
) -> Vec<(u64, u32)> {
    let mesh = mesh_of(scene, instance);
    let of_corner = |p: &[f32; 3]| {
        let [x, y, z] = bits(placed(&instance.world_from_object, *p)).map(u64::from);
        mixed(mixed(x | (y << 32)) ^ z)
    };
    let positions = mesh.positions.par_iter().with_min_len(AT_ONCE);
    let corners: Vec<u64> = positions.map(of_corner).collect();
    let wanted = |(triangle, of): (usize, &[u32; 3])| {
        let [a, b, c] = of.map(|corner| corners[corner as usize]);
        let has_area = a != b && b != c && c != a;
        let hash = mixed(a.wrapping_add(b).wrapping_add(c));
        (has_area && is_wanted(hash)).then_some((hash, triangle as u32))
    };
    let triangles = mesh.triangles.par_iter().with_min_len(AT_ONCE);
    triangles.enumerate().filter_map(wanted).collect()
}
