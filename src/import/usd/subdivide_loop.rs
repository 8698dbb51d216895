//! Subdivision surfaces of triangles by Loop ("Smooth subdivision surfaces based on triangles", 1987), with the borders and
//! creases of Hoppe and others ("Piecewise smooth surface reconstruction", 1994).

use std::f64::consts::TAU;

use glam::DVec3;

use super::polygons::{Corner, Polygons};
use super::subdivide::{Blend, Topology, Wishes, divided, doubles, softer, topology};

/// The share of each of the n points about another: β of Loop's thesis.
fn share(n: usize) -> f64 {
    let n = n as f64;
    let root = 0.375 + 0.25 * (TAU / n).cos();
    (0.625 - root * root) / n
}

/// Where an edge's point goes: 3/8 of both ends and 1/8 of the points across.
fn edge_point(all: &Topology, (a, b): (u32, u32), polygons: &Polygons, points: &[DVec3]) -> DVec3 {
    let ends = points[a as usize] + points[b as usize];
    let straight = 0.5 * ends;
    let Some(edge) = all.edge(a, b).filter(|edge| edge.sharpness < 1.0) else {
        return straight;
    };
    let across = |face: &u32| {
        let ring = polygons.corners.get(3 * *face as usize..)?.get(..3)?;
        let other = ring.iter().find(|p| **p != a && **p != b)?;
        Some(points[*other as usize])
    };
    let across: Vec<DVec3> = edge.faces.iter().filter_map(across).collect();
    let [one, other] = across.as_slice() else {
        return straight;
    };
    let smooth = 0.375 * ends + 0.125 * (one + other);
    smooth.lerp(straight, edge.sharpness)
}

/// One step: each triangle becomes four.
pub(super) fn divide(polygons: &mut Polygons, parts: &mut Vec<usize>, wishes: &mut Wishes) {
    let points = doubles(&polygons.points);
    let all = topology(polygons, &points, wishes);
    let old = points.len() as u32;
    let mut moved: Vec<DVec3> = (0..old)
        .map(|point| {
            let around = &all.neighbours[point as usize];
            let here = points[point as usize];
            if around.is_empty() {
                return here;
            }
            let share = share(around.len());
            let ends: DVec3 = around.iter().map(|p| points[*p as usize]).sum();
            let smooth = (1.0 - around.len() as f64 * share) * here + share * ends;
            all.ruled(point, smooth, &points, wishes)
        })
        .collect();
    let edges = all.order.iter();
    moved.extend(edges.map(|ends| edge_point(&all, *ends, polygons, &points)));
    let mut next = Polygons {
        points: moved.iter().map(|p| p.as_vec3().to_array()).collect(),
        counts: Vec::new(),
        corners: Vec::new(),
        hole: Vec::new(),
        primvars: polygons.primvars.clone(),
        normals: None,
        ..*polygons
    };
    let mut next_parts = Vec::new();
    let mut origin: Vec<Blend> = Vec::new();
    let (rings, _) = polygons.corners.as_chunks::<3>();
    for (face, ring) in rings.iter().enumerate() {
        // Corners 0 to 2, and 3 to 5 between each of them and the next one.
        let point = |i: usize| match i {
            0..=2 => ring[i],
            _ => {
                let edge = all.edge(ring[i - 3], ring[(i - 2) % 3]);
                edge.map_or(0, |edge| old + edge.number)
            }
        };
        let corner = |i: usize| Corner {
            face,
            number: 3 * face + i % 3,
            point: ring[i % 3],
        };
        for inner in [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]] {
            next.face(&inner.map(point));
            if let Some(hole) = next.hole.last_mut() {
                *hole = polygons.hole.get(face) == Some(&true);
            }
            next_parts.push(parts.get(face).copied().unwrap_or(0));
            origin.extend(inner.map(|i| match i {
                0..=2 => Blend(vec![corner(i)]),
                _ => Blend(vec![corner(i - 3), corner(i - 2)]),
            }));
        }
    }
    for layer in next.primvars.values_mut() {
        *layer = divided(layer, &origin);
    }
    softer(wishes, &all, old);
    *polygons = next;
    *parts = next_parts;
}

/// Brings the points to where endless steps would: between n others each of these has 1 / (n + 3/(8β)).
pub(super) fn to_limit(polygons: &mut Polygons, wishes: &Wishes) {
    let points = doubles(&polygons.points);
    let all = topology(polygons, &points, wishes);
    let limit = |point: u32| {
        let here = points[point as usize];
        let around = &all.neighbours[point as usize];
        let smooth = || {
            let n = around.len();
            let weight = 1.0 / (n as f64 + 0.375 / share(n));
            let ends: DVec3 = around.iter().map(|p| points[*p as usize]).sum();
            (1.0 - n as f64 * weight) * here + weight * ends
        };
        all.limit_by_creases(point, &points, wishes)
            .unwrap_or_else(smooth)
    };
    let moved = (0..points.len() as u32).map(|point| limit(point).as_vec3().to_array());
    polygons.points = moved.collect();
}
